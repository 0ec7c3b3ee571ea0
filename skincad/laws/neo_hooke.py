"""Neo-Hooke: W = mu / 2 (I1 - 3), as silicones are up to strains of about 0.3.

Treloar, Trans. Faraday Soc. 39 (1943) 241; Rivlin, Phil. Trans. R. Soc. A 240 (1948) 459.
"""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from skincad.base.tables import quantity
from skincad.laws.rubber import Candidate, Rubber


class NeoHooke(Rubber):
    """One constant."""

    kind: Literal["neo-hooke"] = Field(default="neo-hooke", description="which law")
    mu: float = quantity("MPa", "shear modulus", gt=0.0, le=100.0)

    @property
    def shear(self) -> float:
        """The shear modulus at small strain, MPa."""
        return self.mu

    @staticmethod
    def candidates() -> tuple[Candidate, ...]:
        """How it is fitted."""
        return (Candidate("neo-hooke", (1.0,), lambda p: NeoHooke(mu=float(p[0]))),)
