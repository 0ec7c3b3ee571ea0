"""Neo-Hooke's closed forms: Treloar, The Physics of Rubber Elasticity, 3rd ed. 1975, sec. 5.3."""

from __future__ import annotations

from skincad.laws import NeoHooke
from tests.laws.closed import Closed, holds

MU = 0.3


def test_closed_forms() -> None:
    holds(
        Closed(
            NeoHooke(mu=MU),
            bar=lambda t: MU * (t - t**-2),
            sheet=lambda t: MU * (t - t**-5),
            sheared=lambda k: MU * k,
        )
    )
