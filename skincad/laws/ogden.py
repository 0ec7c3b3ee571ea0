"""Ogden: W = sum of 2 mu / alpha^2 (l1^alpha + l2^alpha + l3^alpha - 3), in one or several terms.

The shear modulus is the sum of mu, and alpha 2 is neo-Hooke's. Others write mu / alpha in place of
2 mu / alpha^2: their mu is ours times 2 / alpha. Ogden, Proc. R. Soc. A 326 (1972) 565.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from skincad.base.arrays import Array
from skincad.base.errors import InputError
from skincad.base.tables import quantity
from skincad.laws.rubber import Candidate, Rubber

MOST_TERMS = 6  # assumption: CalculiX has four, and no fit of a bar knows more than three
# Powers between which the plane body's series (bodies/plane_body.py) is exact to rounding; assumption: fits
# of rubber lie within
LEAST_POWER, LARGEST_POWER = 0.1, 14.0

Terms = Annotated[tuple[float, ...], Field(strict=False, min_length=1, max_length=MOST_TERMS)]


class Ogden(Rubber):
    """Two constants a term."""

    kind: Literal["ogden"] = Field(default="ogden", description="which law")
    mu: Terms = quantity("MPa", "of each term; in sum the shear modulus")
    alpha: Terms = quantity("1", "power of each term")

    def own_rules(self) -> None:
        """Raise InputError for terms that lack a number, and powers out of range."""
        if len(self.mu) != len(self.alpha):
            rule = f"must have as many numbers as mu, {len(self.mu)}"
            raise InputError("alpha", rule, list(self.alpha))
        for power in self.alpha:
            if not LEAST_POWER <= abs(power) <= LARGEST_POWER:
                rule = f"must be from {LEAST_POWER:g} to {LARGEST_POWER:g}, or minus that"
                raise InputError("alpha", rule, power)

    @property
    def shear(self) -> float:
        """The shear modulus at small strain, MPa."""
        return sum(self.mu)

    @property
    def powers(self) -> tuple[tuple[float, float], ...]:
        """Shares and powers of the strain's measure."""
        return tuple((mu / self.shear, power) for mu, power in zip(self.mu, self.alpha, strict=True))

    @staticmethod
    def candidates() -> tuple[Candidate, ...]:
        """How it is fitted: with one term and with two."""

        def make(numbers: Array) -> Ogden:
            mu, alpha = numbers.reshape(2, -1).tolist()
            return Ogden(mu=tuple(mu), alpha=tuple(alpha))

        return Candidate("ogden, 1 term", (1.0, 2.5), make), Candidate(
            "ogden, 2 terms", (0.7, 0.3, 2.0, 4.0), make
        )
