"""Friction between plate and skin, point by point, with exact stick: by Coulomb, by area, or by a table.

A point sticks where |t| is at most what static friction bears, without creep, and slips at the kinetic part
of that. Coulomb's law, 1785: `coefficient` times the normal force. Soft adhesive elastomers do not keep to
it: a smooth glass lens that slides on silicone feels nearly the same shear stress all over its contact
(Chateauminois and Fretigny, Eur. Phys. J. E 27 (2008) 221), whatever the pressure (Trejo, Fretigny,
Chateauminois, arXiv 1701.08013), so that friction follows the contact's area, and mu falls as the load rises;
static friction follows it too (Sahli and others, PNAS 115 (2018) 471). `shear` is that, capped by Coulomb
where the pressure is small; on rough plates the stress rises with the pressure, which a `table` says.

Range: dry, the same at any speed; areas are the undeformed skin's and keep their size under shear, where
Sahli and others see them shrink by up to 30 %; adhesion, which holds a contact without load, is left out.
The algorithm and its sources are in mechanics/contact/frictional.py. Reference cases: a block on a plate,
Cattaneo-Mindlin, Hertz with friction by area (tests/mechanics/contact/test_frictional.py).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from skincad.base.errors import InputError
from skincad.base.tables import quantity
from skincad.effects.kinds import PlatePath, Share, Step, Term
from skincad.effects.slip_order import flipped
from skincad.mechanics.contact.state import FrictionCoefficients

LEAST, MOST = 1e-6, 20.0  # of a coefficient; less caps any shear stress
MOST_PAIRS = 100
HARDEST = 1e3  # MPa; of a pressure or shear stress, as no silicone bears
KEYS = {"shear_stress": "shear", "table": "table"}  # and the law that asks for them


class Friction(Term):
    """Friction of the plate."""

    law: Literal["coulomb", "shear", "table"] = Field(
        default="coulomb",
        description="coulomb: coefficient times normal force; shear: the same shear stress at any pressure, "
        "capped by coulomb; table: coefficients by pressure",
    )
    coefficient: float | None = quantity(
        "1",
        "static friction: a point sticks up to this times its normal force; not with a table",
        ge=0.0,
        le=MOST,
        default=None,
    )
    kinetic: float | None = quantity(
        "1",
        "kinetic friction, once a point slips; same as coefficient if not given, and under any law the same "
        "part of static friction at any pressure",
        ge=0.0,
        le=MOST,
        default=None,
    )
    shear_stress: float | None = quantity(
        "MPa",
        "static friction by contact area, with law = shear; assumption: smooth silicones 0.1 to 0.5",
        gt=0.0,
        le=HARDEST,
        default=None,
    )
    table: list[Annotated[list[float], Field(min_length=2, max_length=2)]] | None = Field(
        default=None,
        min_length=1,
        max_length=MOST_PAIRS,
        description="pairs of a pressure in MPa, rising, and the static friction coefficient at it, with "
        "law = table; below the first the coefficient stays, beyond the last the shear stress",
    )

    @model_validator(mode="after")
    def _rules(self) -> Self:
        wanted = {
            "coefficient": self.law != "table",
            "shear_stress": self.law == "shear",
            "table": self.law == "table",
        }
        for key, needed in wanted.items():
            value = getattr(self, key)
            if needed and value is None:
                reason = "" if self.law == "coulomb" else f", which law = {self.law} asks for"
                raise InputError(key, f"is missing{reason}", remedy=f"give {key} a value")
            if not needed and value is not None:
                remedy = "leave it out" if key == "coefficient" else f"take law = {KEYS[key]}"
                raise InputError(key, f"has no effect with law = {self.law}", value, remedy)
        if self.table is not None:
            _check_table(self.table)
        if self.law == "shear" and self._static < LEAST:
            raise InputError("coefficient", f"must be at least {LEAST:g} with law = shear", self.coefficient)
        if self.kinetic is not None and self.kinetic > self._static:
            of = "coefficient" if self.table is None else f"the table's first coefficient, {self._static:g}"
            raise InputError("kinetic", f"must be at most {of}", self.kinetic)
        return self

    @property
    def _static(self) -> float:
        """Static friction's coefficient at small pressures."""
        return self.table[0][1] if self.table else self.coefficient or 0.0

    @property
    def cone(self) -> FrictionCoefficients:
        """What friction bears."""
        breakpoints: tuple[tuple[float, float], ...] = ()
        if self.table is not None:
            breakpoints = tuple((pressure, mu * pressure) for pressure, mu in self.table)
        elif self.shear_stress is not None:
            breakpoints = ((self.shear_stress / self._static, self.shear_stress),)
        return FrictionCoefficients(
            self._static, self._static if self.kinetic is None else self.kinetic, breakpoints
        )

    def share(self, step: Step) -> Share:  # noqa: ARG002
        """Return the cone; the same at every step."""
        return Share(self.cone)

    def afterwards(self, path: PlatePath) -> Iterator[str]:
        """Warn where another ridge would slip first by another law."""
        by_area = self.law != "coulomb"
        if ridges := flipped(path, by_area):
            other = "Coulomb's law" if by_area else "a constant shear stress"
            yield (
                f"the order of slip rests on effects.friction.law: ridge {ridges[0]} slips first, "
                f"but by {other} ridge {ridges[1]} would"
            )


def _check_table(table: list[list[float]]) -> None:
    """Raise InputError for a table that is no law of friction."""
    last = [0.0, 0.0]
    for pair in table:
        pressure, mu = pair
        if not 0 < pressure <= HARDEST or not 0 < mu <= MOST:
            rule = f"needs pressures above 0 up to {HARDEST:g} MPa and coefficients above 0 up to {MOST:g}"
            raise InputError("table", rule, pair)
        if pressure <= last[0]:
            raise InputError("table", "needs pressures that rise", pair, f"put it before {last}")
        if mu * pressure < last[0] * last[1]:
            rule = "must not bear a smaller shear stress (coefficient times pressure) at a larger pressure"
            least = f"take a coefficient of at least {last[0] * last[1] / pressure:.4g} there"
            raise InputError("table", rule, pair, least)
        last = pair
