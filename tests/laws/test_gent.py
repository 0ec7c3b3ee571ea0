"""Gent's closed forms (Rubber Chem. Technol. 69 (1996) 59), his limits, and where the law ends."""

from __future__ import annotations

import numpy as np
import pytest

from skincad.laws import Gent, NeoHooke
from tests.laws.closed import Closed, holds

MU, LIMIT = 0.3, 20.0


def test_closed_forms() -> None:
    def slope(i: float) -> float:
        return MU * LIMIT / (LIMIT - i)

    holds(
        Closed(
            Gent(mu=MU, j_m=LIMIT),
            bar=lambda t: (t - t**-2) * slope(t**2 + 2 / t - 3),
            sheet=lambda t: (t - t**-5) * slope(2 * t**2 + t**-4 - 3),
            sheared=lambda k: k * slope(k**2),
        )
    )


def test_it_tends_to_neo_hooke() -> None:
    stretch = np.linspace(0.5, 2.0, 7)
    far = Gent(mu=MU, j_m=1e6).stress(stretch)
    assert far == pytest.approx(NeoHooke(mu=MU).stress(stretch), rel=3e-6)  # (I1 - 3) / j_m


def test_it_ends_where_chains_are_straight() -> None:
    """I1 - 3 is 2 at a stretch of 2."""
    near, past_end = Gent(mu=MU, j_m=2.0).stress(np.array([1.99, 2.01]))
    assert near > 50 * MU
    assert np.isnan(past_end)
