"""Yeoh: W = c10 (I1 - 3) + c20 (I1 - 3)^2 + c30 (I1 - 3)^3, for rubber that stiffens at large strain.

Yeoh, Rubber Chem. Technol. 63 (1990) 792 and 66 (1993) 754. Where the volume changes I1 - 3 is taken as
I1 - 3 - 2 ln J, so that the higher terms change nothing at small strain.
"""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from skincad.base.arrays import Array
from skincad.base.tables import quantity
from skincad.laws.rubber import Candidate, Rubber


class Yeoh(Rubber):
    """Two or three constants."""

    kind: Literal["yeoh"] = Field(default="yeoh", description="which law")
    c10: float = quantity("MPa", "of I1 - 3: half the shear modulus", gt=0.0, le=100.0)
    c20: float = quantity("MPa", "of its square", ge=-100.0, le=100.0)
    c30: float = quantity("MPa", "of its third power", ge=-100.0, le=100.0, default=0.0)

    @property
    def shear(self) -> float:
        """The shear modulus at small strain, MPa."""
        return 2 * self.c10

    def energy(self, x: Any, of: Any) -> Any:  # noqa: ARG002
        """Return f(x) in units of the shear modulus; I1 - 3 is 2 x."""
        return x * (1 + x * (2 * self.c20 / self.c10 + x * (4 * self.c30 / self.c10)))

    def slopes(self, x: Array) -> tuple[Array, Array]:
        """Return f'(x) and f''(x)."""
        second, third = 4 * self.c20 / self.c10, 12 * self.c30 / self.c10
        return 1 + x * (second + x * third), second + 2 * third * x

    @staticmethod
    def candidates() -> tuple[Candidate, ...]:
        """How it is fitted: with two terms and with three."""
        return (
            Candidate("yeoh, 2 terms", (0.5, 0.0), lambda p: Yeoh(c10=float(p[0]), c20=float(p[1]))),
            Candidate(
                "yeoh, 3 terms",
                (0.5, 0.0, 0.0),
                lambda p: Yeoh(c10=float(p[0]), c20=float(p[1]), c30=float(p[2])),
            ),
        )
