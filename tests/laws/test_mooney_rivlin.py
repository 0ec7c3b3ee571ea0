"""Mooney's closed forms: Treloar, The Physics of Rubber Elasticity, 3rd ed. 1975, sec. 10.2."""

from __future__ import annotations

import pytest

from skincad.laws import MooneyRivlin
from tests.laws.closed import Closed, holds


@pytest.mark.parametrize(("c10", "c01"), [(0.11, 0.05), (0.3, 0.0), (0.3, -0.02)])
def test_closed_forms(c10: float, c01: float) -> None:
    holds(
        Closed(
            MooneyRivlin(c10=c10, c01=c01),
            bar=lambda t: 2 * (t - t**-2) * (c10 + c01 / t),
            sheet=lambda t: 2 * (t - t**-5) * (c10 + c01 * t**2),
            sheared=lambda k: 2 * (c10 + c01) * k,
        )
    )
