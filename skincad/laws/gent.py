"""Gent: W = -mu j_m / 2 ln(1 - (I1 - 3) / j_m), for rubber whose chains can be stretched no further.

Gent, Rubber Chem. Technol. 69 (1996) 59. It ends where I1 - 3 is j_m; neo-Hooke for j_m to infinity. Where
the volume changes I1 - 3 is taken as I1 - 3 - 2 ln J.
"""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from skincad.base.arrays import Array
from skincad.base.tables import quantity
from skincad.laws.rubber import Candidate, Rubber


class Gent(Rubber):
    """Two constants."""

    kind: Literal["gent"] = Field(default="gent", description="which law")
    mu: float = quantity("MPa", "shear modulus", gt=0.0, le=100.0)
    j_m: float = quantity("1", "largest I1 - 3", ge=0.1, le=1e6)

    @property
    def shear(self) -> float:
        """The shear modulus at small strain, MPa."""
        return self.mu

    def energy(self, x: Any, of: Any) -> Any:
        """Return f(x) in units of the shear modulus; I1 - 3 is 2 x."""
        return -self.j_m / 2 * of.log(1 - x * (2 / self.j_m))

    def slopes(self, x: Array) -> tuple[Array, Array]:
        """Return f'(x) and f''(x)."""
        left = 1 - 2 * x / self.j_m
        return 1 / left, 2 / self.j_m / left**2

    @staticmethod
    def candidates() -> tuple[Candidate, ...]:
        """How it is fitted, j_m by its inverse: 0 is neo-Hooke's."""
        return (
            Candidate("gent", (1.0, 0.03), lambda p: Gent(mu=float(p[0]), j_m=1 / max(float(p[1]), 1e-6))),
        )
