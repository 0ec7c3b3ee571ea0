"""Coulomb friction between plate and skin, point by point, with exact stick.

A point sticks where |t| <= coefficient * p, without creep, and slips at `kinetic` times p. Range: dry contact
whose coefficient hangs neither on pressure nor on speed; for silicone both are simplifications. Coulomb 1785;
the algorithm and its sources are in mechanics/frictional.py. Reference cases: a block on a plate, and
Cattaneo-Mindlin (tests/mechanics/contact/test_frictional.py).
"""

from __future__ import annotations

from typing import Self

from pydantic import model_validator

from skincad.base.errors import InputError
from skincad.base.tables import quantity
from skincad.effects.kinds import Share, Step, Term
from skincad.mechanics.contact.grip import Cone


class Friction(Term):
    """Coulomb friction of the plate."""

    coefficient: float = quantity(
        "1", "static friction: a point sticks up to this times its normal force", ge=0.0, le=20.0
    )
    kinetic: float | None = quantity(
        "1",
        "kinetic friction, once a point slips; same as coefficient if not given",
        ge=0.0,
        le=20.0,
        default=None,
    )

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.kinetic is not None and self.kinetic > self.coefficient:
            raise InputError("kinetic", "must be at most coefficient", self.kinetic)
        return self

    def share(self, step: Step) -> Share:  # noqa: ARG002
        """Return the cone; the same at every step."""
        return Share(Cone(self.coefficient, self.coefficient if self.kinetic is None else self.kinetic))
