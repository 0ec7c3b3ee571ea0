"""History-dependent shear stress of silicone (viscoelasticity): Kelvin-Voigt, and a Prony series.

The design's modulus is the slow one, as a tensile test finds it, and what is viscous comes on top:
G(t) = G (1 + sum of g exp(-t / tau)), and a dashpot whose stress is G `retardation_time` times twice the
strain rate. Volume changes stay elastic, and so do films. Range: small strain. The default of 2.4e-5 s is an
assumption that keeps a pad from chattering; a silicone's own series is to be measured. Taylor, Pister,
Goudreau, IJNME 2 (1970) 45; Simo and Hughes, Computational Inelasticity, 1998, sec. 10.3. Reference cases:
creep and relaxation of a sheared layer, closed form (tests/mechanics/dynamics/test_steps.py). It says nothing
of what leaving it out changes: no design tells how its silicone relaxes.
"""

from __future__ import annotations

from typing import Annotated, ClassVar, Self

from pydantic import Field, model_validator

from skincad.base.errors import InputError
from skincad.base.tables import quantity
from skincad.effects.kinds import RATE, Share, Step, Term
from skincad.mechanics.dynamics.ringing import RETARDATION

MOST_BRANCHES = 20
LARGEST = 1e6  # of a branch's modulus by the slow one, and of its time, s, as of the retardation time


class Viscosity(Term):
    """Viscous shear stress of the silicone."""

    asks: ClassVar[frozenset[str]] = frozenset({RATE})

    retardation_time: float | None = quantity(
        "s", "viscosity over slow shear modulus; 2.4e-5 if there is no prony", ge=0.0, le=1e6, default=None
    )
    prony: list[Annotated[list[float], Field(min_length=2, max_length=2)]] = Field(
        default=[],
        max_length=MOST_BRANCHES,
        description="pairs of a modulus, relative to the slow one, and its relaxation time in s",
    )

    @model_validator(mode="after")
    def _rules(self) -> Self:
        for pair in self.prony:
            if not (pair[0] > 0 and pair[1] > 0):
                raise InputError("prony", "needs a modulus and a time above 0 in each pair", pair)
            if max(pair) > LARGEST:
                raise InputError("prony", f"needs a modulus and a time of at most {LARGEST:g}", pair)
        if self.retardation_time == 0.0 and not self.prony:
            raise InputError("retardation_time", "must be above 0 where there is no prony", 0.0)
        return self

    def share(self, step: Step) -> Share:  # noqa: ARG002
        """Return the dashpot and the branches; they do not depend on the step."""
        alone = 0.0 if self.prony else RETARDATION
        rate = alone if self.retardation_time is None else self.retardation_time
        return Share(rate=rate, relaxing=tuple((g, time) for g, time in self.prony))
