"""Mooney and Rivlin: W = c10 (I1 - 3) + c01 (I2 - 3), which softens in tension where c01 is above 0.

Of kept volume I2 is the sum of the stretches' power -2, so it is Ogden's law with the powers 2 and -2, and
is taken so where the volume changes. Mooney, J. Appl. Phys. 11 (1940) 582; Rivlin, Phil. Trans. R. Soc. A
241 (1948) 379; as Ogden's: Ogden, Proc. R. Soc. A 326 (1972) 565.
"""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from skincad.base.tables import quantity
from skincad.laws.rubber import Candidate, Rubber


class MooneyRivlin(Rubber):
    """Two constants."""

    kind: Literal["mooney-rivlin"] = Field(default="mooney-rivlin", description="which law")
    c10: float = quantity("MPa", "of the first invariant", ge=-100.0, le=100.0)
    c01: float = quantity("MPa", "of the second invariant", ge=-100.0, le=100.0)

    @property
    def shear(self) -> float:
        """The shear modulus at small strain, MPa."""
        return 2 * (self.c10 + self.c01)

    @property
    def powers(self) -> tuple[tuple[float, float], ...]:
        """Shares and powers of the strain's measure."""
        return (2 * self.c10 / self.shear, 2.0), (2 * self.c01 / self.shear, -2.0)

    @staticmethod
    def candidates() -> tuple[Candidate, ...]:
        """How it is fitted."""
        return (
            Candidate("mooney-rivlin", (0.4, 0.1), lambda p: MooneyRivlin(c10=float(p[0]), c01=float(p[1]))),
        )
