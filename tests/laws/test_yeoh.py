"""Yeoh's closed forms: Yeoh, Rubber Chem. Technol. 63 (1990) 792, by W's slope in I1."""

from __future__ import annotations

from skincad.laws import Yeoh
from tests.laws.closed import Closed, holds

C1, C2, C3 = 0.15, 0.03, 0.004


def slope(i: float) -> float:
    """Of W at I1 - 3."""
    return C1 + 2 * C2 * i + 3 * C3 * i**2


def test_closed_forms() -> None:
    holds(
        Closed(
            Yeoh(c10=C1, c20=C2, c30=C3),
            bar=lambda t: 2 * (t - t**-2) * slope(t**2 + 2 / t - 3),
            sheet=lambda t: 2 * (t - t**-5) * slope(2 * t**2 + t**-4 - 3),
            sheared=lambda k: 2 * k * slope(k**2),
        )
    )
