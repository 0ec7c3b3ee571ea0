"""Friction between skin and plate in a check: bounded in closed form, or computed once for all models.

Models press without friction. Those with free ends get what friction changes on a coarse solid, with
`contact.friction` or, where that is not given, between none and much (models/friction.py). Those without free
ends get the change on a section if the coefficient is known, else a bound: what they leave out at the ends is
more. The closed form keeps the bound. At 0 nothing is left out.
"""

from __future__ import annotations

import math
from dataclasses import replace
from time import perf_counter
from typing import TYPE_CHECKING

from skincad.base.errors import ExhaustedError, InputError, resource_guard
from skincad.inputs.design import Design
from skincad.mechanics.left_out import (
    ALONG,
    FINITE_STRAIN,
    FREE_ENDS,
    FRICTION,
    POCKETS,
    LeftOut,
    finite_strain,
)
from skincad.mechanics.models.table import MODELS
from skincad.mechanics.problem import Answer, ContactError, focused
from skincad.shape.skin import skin_of

if TYPE_CHECKING:
    from skincad.mechanics.models.correction import Correction

CLOSED_FORM = "winkler"


class PlateFriction:
    """The friction of one design's plate at `force` N; `crest_offsets` as in Request."""

    def __init__(self, design: Design, force: float, crest_offsets: tuple[float, ...]) -> None:
        self.design, self.force, self.crest_offsets = design, force, crest_offsets
        self.coefficient = design.contact.friction
        self.solved: dict[bool, Correction] = {}  # with free ends, and without
        self.failed: dict[bool, str] = {}  # of which it could not be computed, and why
        self.unknown: dict[str, tuple[LeftOut, ...]] = {}  # what an unknown coefficient leaves open, by model
        self.seconds = 0.0

    def left_out(self, model: str) -> tuple[str, ...]:
        """Names of the friction effects that a model leaves out, bounded in closed form.

        Friction along y matters where ends are free, unless bonded strips hold the ridges.
        """
        ends, pressed = self.complete(model), MODELS[model].meshed
        if self.coefficient == 0.0 or (pressed and ends in self.solved):
            return ()
        if pressed and ends not in self.failed:  # it will be pressed, if the coefficient is known or ends are
            return () if self.coefficient is not None else (FRICTION,)
        return (FRICTION, ALONG) if has_ends(model) and self.design.film_state != "bonded" else (FRICTION,)

    def complete(self, model: str) -> bool:
        """Whether no better model has other ends: with free ends, or of a disc, which has none."""
        return has_ends(model) or (MODELS[model].meshed and skin_of(self.design).body == "turned")

    def lasting_error(self, model: str, bounds: tuple[LeftOut, ...], of: str = "threshold") -> float:
        """The relative error of the all-touch force, or `of` another number, that no model after this one
        removes."""
        lasting = [
            float(getattr(bound, of)) for bound in bounds if bound.effect in (FRICTION, ALONG, POCKETS)
        ]
        return math.fsum(lasting) if self.complete(model) else 0.0

    def applied_to(self, model: str, answer: Answer, available: float | None, price: float) -> Answer:
        """Return a model's answer with friction, unless the model has no mesh to press.

        If friction cannot be computed, or its `price`, s, exceeds the `available` time, a warning says so and
        its bound stays.
        """
        ends = self.complete(model)
        if self.coefficient == 0.0 or not MODELS[model].meshed or not (ends or self.coefficient):
            return answer
        if ends not in self.solved and ends not in self.failed:
            if available is not None and price > available:
                self.failed[ends] = f"would take about {price:.2g} s"
            else:
                self._solve(ends)
        if ends not in self.solved:
            words = f"contact.friction is left out, within its bound: {self.failed[ends]}"
            return replace(answer, warnings=(*answer.warnings, words))
        from skincad.mechanics.models.friction import with_friction

        large = FINITE_STRAIN not in MODELS[model].leaves_out
        strain = finite_strain(self.design, answer, self.force) if large else None
        known = self.coefficient is not None
        changed, self.unknown[model] = with_friction(
            answer, self.solved[ends], self.force, known=known, strain=strain
        )
        return replace(changed, seconds={**answer.seconds, "friction": self.seconds})

    def _solve(self, ends: bool) -> None:
        from skincad.mechanics.models.corrected import plain_pad
        from skincad.mechanics.models.friction import FULL, solve, solve_solid

        began, turned = perf_counter(), skin_of(self.design).body == "turned"
        press = solve_solid if ends and not turned else solve
        coefficient = FULL if self.coefficient is None else self.coefficient
        try:
            with resource_guard("the press with friction"):
                pad = focused(plain_pad(self.design), self.force)
                self.solved[ends] = press(pad, coefficient, self.force, self.crest_offsets)
        except (ContactError, ExhaustedError, InputError) as failure:
            self.failed[ends] = str(failure)
        self.seconds += perf_counter() - began


def has_ends(model: str) -> bool:
    """Return whether a model computes a pad's free ends."""
    return model != CLOSED_FORM and FREE_ENDS not in MODELS[model].leaves_out
