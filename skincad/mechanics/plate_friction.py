"""Friction between skin and plate in a check: left out with its bound, or computed once for all tiers.

Tiers press without friction. Where `contact.friction` is not given it is left out, and its bound is part of
the error; where it is, each tier's answer is changed by what it changes on a coarse mesh (tiers/friction.py).
The closed form keeps the bound: a mesh costs a thousand times its own price. At 0 nothing is left out.
"""

from __future__ import annotations

import math
from dataclasses import replace
from time import perf_counter
from typing import TYPE_CHECKING

from skincad.base.errors import ExhaustedError, InputError, needing
from skincad.inputs.design import Design
from skincad.mechanics.left_out import ALONG, FREE_ENDS, FRICTION, LeftOut
from skincad.mechanics.problem import Answer, ContactError
from skincad.mechanics.tiers.table import TIERS

if TYPE_CHECKING:
    from skincad.mechanics.tiers.friction import TwoPresses

CLOSED_FORM = "winkler"


class PlateFriction:
    """The friction of one design's plate at `force` N; `drops` as in Request."""

    def __init__(self, design: Design, force: float, drops: tuple[float, ...]) -> None:
        self.design, self.force, self.drops = design, force, drops
        self.coefficient = design.contact.friction
        self.solved: TwoPresses | None = None
        self.failed = ""
        self.seconds = 0.0

    def left_out(self, tier: str) -> tuple[str, ...]:
        """What a tier leaves out of friction.

        Along y it has a say where ends are free, unless bonded strips hold the ridges; no tier computes it.
        """
        if self.coefficient == 0.0:
            return ()
        unknown = self._unknown or tier == CLOSED_FORM
        free = tier != CLOSED_FORM and FREE_ENDS not in TIERS[tier].leaves_out
        along = free and self.design.film_state != "bonded"
        return (*([FRICTION] if unknown else []), *([ALONG] if along else []))

    def stays(self, bounds: tuple[LeftOut, ...]) -> float:
        """What of the relative error of F9 no tier takes away."""
        lasting = (FRICTION, ALONG) if self._unknown else (ALONG,)
        return math.fsum(bound.threshold for bound in bounds if bound.effect in lasting)

    @property
    def _unknown(self) -> bool:
        """Whether the coefficient is not given, or of no use."""
        return self.coefficient is None or bool(self.failed)

    def on(self, tier: str, found: Answer, within: float | None, price: float) -> Answer:
        """Return a tier's answer with friction, where that is known and the tier no closed form.

        Where it cannot be computed, or its `price`, s, is more than it must stay `within`, that is said and
        its bound stays.
        """
        if not self.coefficient or tier == CLOSED_FORM:
            return found
        if self.solved is None and not self.failed:
            if within is not None and price > within:
                self.failed = f"would take about {price:.2g} s"
            else:
                self._solve()
        if self.solved is None:
            words = f"contact.friction is left out, within its bound: {self.failed}"
            return replace(found, warnings=(*found.warnings, words))
        from skincad.mechanics.tiers.friction import rubbed

        changed = rubbed(found, self.solved, self.force)
        return replace(changed, seconds={**found.seconds, "friction": self.seconds})

    def _solve(self) -> None:
        from skincad.mechanics.tiers.corrected import plain_pad
        from skincad.mechanics.tiers.friction import solve

        began = perf_counter()
        try:
            with needing("the press with friction"):
                self.solved = solve(plain_pad(self.design), self.coefficient or 0.0, self.force, self.drops)
        except (ContactError, ExhaustedError, InputError) as failure:
            self.failed = str(failure)
        self.seconds = perf_counter() - began
