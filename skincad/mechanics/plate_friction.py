"""Friction between skin and plate in a check: bounded, or computed once for all models.

Models press without friction. Without `contact.friction`, a bound for friction is part of the error. With it,
each model's answer gets the change that friction makes on a coarse mesh (models/friction.py). The closed form
keeps the bound, since a mesh costs a thousand times as much. At 0 nothing is left out.
"""

from __future__ import annotations

import math
from dataclasses import replace
from time import perf_counter
from typing import TYPE_CHECKING

from skincad.base.errors import ExhaustedError, InputError, resource_guard
from skincad.inputs.design import Design
from skincad.mechanics.left_out import ALONG, FREE_ENDS, FRICTION, LeftOut
from skincad.mechanics.models.table import MODELS
from skincad.mechanics.problem import Answer, ContactError

if TYPE_CHECKING:
    from skincad.mechanics.models.friction import TwoPresses

CLOSED_FORM = "winkler"


class PlateFriction:
    """The friction of one design's plate at `force` N; `crest_offsets` as in Request."""

    def __init__(self, design: Design, force: float, crest_offsets: tuple[float, ...]) -> None:
        self.design, self.force, self.crest_offsets = design, force, crest_offsets
        self.coefficient = design.contact.friction
        self.solved: TwoPresses | None = None
        self.failed = ""
        self.seconds = 0.0

    def left_out(self, model: str) -> tuple[str, ...]:
        """Names of the friction effects that a model neglects.

        Friction along y matters where ends are free, unless bonded strips hold the ridges. No model computes
        it.
        """
        if self.coefficient == 0.0:
            return ()
        unknown = self._unknown or model == CLOSED_FORM
        free = model != CLOSED_FORM and FREE_ENDS not in MODELS[model].leaves_out
        along = free and self.design.film_state != "bonded"
        return (*([FRICTION] if unknown else []), *([ALONG] if along else []))

    def lasting_error(self, bounds: tuple[LeftOut, ...]) -> float:
        """The relative error of the all-touch force that no model removes."""
        lasting = (FRICTION, ALONG) if self._unknown else (ALONG,)
        return math.fsum(bound.threshold for bound in bounds if bound.effect in lasting)

    @property
    def _unknown(self) -> bool:
        """Whether the coefficient is not given, or of no use."""
        return self.coefficient is None or bool(self.failed)

    def applied_to(self, model: str, answer: Answer, available: float | None, price: float) -> Answer:
        """Return a model's answer with friction, if that is known and the model is not the closed form.

        If friction cannot be computed, or its `price`, s, exceeds the `available` time, a warning says so and
        its bound stays.
        """
        if not self.coefficient or model == CLOSED_FORM:
            return answer
        if self.solved is None and not self.failed:
            if available is not None and price > available:
                self.failed = f"would take about {price:.2g} s"
            else:
                self._solve()
        if self.solved is None:
            words = f"contact.friction is left out, within its bound: {self.failed}"
            return replace(answer, warnings=(*answer.warnings, words))
        from skincad.mechanics.models.friction import with_friction

        changed = with_friction(answer, self.solved, self.force)
        return replace(changed, seconds={**answer.seconds, "friction": self.seconds})

    def _solve(self) -> None:
        from skincad.mechanics.models.corrected import plain_pad
        from skincad.mechanics.models.friction import solve

        began = perf_counter()
        try:
            with resource_guard("the press with friction"):
                self.solved = solve(
                    plain_pad(self.design), self.coefficient or 0.0, self.force, self.crest_offsets
                )
        except (ContactError, ExhaustedError, InputError) as failure:
            self.failed = str(failure)
        self.seconds = perf_counter() - began
