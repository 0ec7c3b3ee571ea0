"""The laws' closed forms, from the papers that they come from; their limits and what they are of each other.

Sources: Treloar, The Physics of Rubber Elasticity, 3rd ed. 1975, sections 5.3 and 10.2; Yeoh, Rubber Chem.
Technol. 63 (1990) 792; Gent, Rubber Chem. Technol. 69 (1996) 59; Ogden, Proc. R. Soc. A 326 (1972) 565, eqs
(37) and (41).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from skincad.base import InputError
from skincad.laws import Gent, MooneyRivlin, NeoHooke, Ogden, Yeoh
from skincad.mechanics.bodies import plane_body
from tests.laws.closed import Closed, holds, plane_stress

MU, LIMIT = 0.3, 20.0
C1, C2, C3 = 0.15, 0.03, 0.004
TERMS = ((0.2, 2.5), (0.06, -1.7), (0.01, 7.0))


def mooney(c10: float, c01: float) -> Closed:
    return Closed(
        MooneyRivlin(c10=c10, c01=c01),
        bar=lambda t: 2 * (t - t**-2) * (c10 + c01 / t),
        sheet=lambda t: 2 * (t - t**-5) * (c10 + c01 * t**2),
        sheared=lambda k: 2 * (c10 + c01) * k,
    )


def by_first_invariant(law: NeoHooke | Yeoh | Gent, slope: Callable[[float], float]) -> Closed:
    """Of a law whose energy has this slope in I1, at I1 - 3."""
    return Closed(
        law,
        bar=lambda t: 2 * (t - t**-2) * slope(t**2 + 2 / t - 3),
        sheet=lambda t: 2 * (t - t**-5) * slope(2 * t**2 + t**-4 - 3),
        sheared=lambda k: 2 * k * slope(k**2),
    )


def ogden(terms: tuple[tuple[float, float], ...]) -> Closed:
    def summed(of: Callable[[float], float]) -> float:
        return sum(2 * mu / a * of(a) for mu, a in terms)

    def sheared(shift: float) -> float:
        stretch = (shift + np.sqrt(shift**2 + 4)) / 2
        return summed(lambda a: (stretch**a - stretch**-a) / (stretch + 1 / stretch))

    return Closed(
        Ogden(mu=[mu for mu, _ in terms], alpha=[a for _, a in terms]),
        bar=lambda t: summed(lambda a: t ** (a - 1) - t ** (-a / 2 - 1)),
        sheet=lambda t: summed(lambda a: t ** (a - 1) - t ** (-2 * a - 1)),
        sheared=sheared,
    )


CLOSED = {
    "neo-hooke": by_first_invariant(NeoHooke(mu=MU), lambda _: MU / 2),
    "yeoh": by_first_invariant(Yeoh(c10=C1, c20=C2, c30=C3), lambda i: C1 + 2 * C2 * i + 3 * C3 * i**2),
    "gent": by_first_invariant(Gent(mu=MU, j_m=LIMIT), lambda i: MU / 2 * LIMIT / (LIMIT - i)),
    **{f"mooney-rivlin {pair}": mooney(*pair) for pair in ((0.11, 0.05), (0.3, 0.0), (0.3, -0.02))},
    **{
        f"ogden {terms}": ogden(terms)
        for terms in (TERMS[:1], TERMS, ((0.3, 2.0),), ((0.3, -14.0),), ((0.3, 14.0),))
    },
}


@pytest.mark.parametrize("name", CLOSED)
def test_closed_forms(name: str) -> None:
    holds(CLOSED[name])


def test_gent_tends_to_neo_hooke_and_ends_where_chains_are_straight() -> None:
    stretch = np.linspace(0.5, 2.0, 7)
    far = Gent(mu=MU, j_m=1e6).stress(stretch)
    assert far == pytest.approx(NeoHooke(mu=MU).stress(stretch), rel=3e-6)  # (I1 - 3) / j_m
    near, past_end = Gent(mu=MU, j_m=2.0).stress(np.array([1.99, 2.01]))  # I1 - 3 is 2 at a stretch of 2
    assert near > 50 * MU
    assert np.isnan(past_end)


def test_powers_2_and_minus_2_are_mooney_rivlin() -> None:
    gradient = np.array([[0.3, -0.2], [0.5, 0.1]])
    two, one = Ogden(mu=[0.4, 0.2], alpha=[2.0, -2.0]), MooneyRivlin(c10=0.2, c01=0.1)
    assert plane_stress(two, gradient) == pytest.approx(plane_stress(one, gradient), rel=1e-12)  # rounding


@pytest.mark.parametrize("power", [-14.0, -3.0, 0.1, 2.4, 14.0])
def test_the_series_meets_the_root(power: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """The same stress by both ways where they meet: 1e-10, the rest is what the root's slope loses."""
    law, gradient = Ogden(mu=[1.0], alpha=[power]), np.array([[0.06, 0.07], [0.02, -0.03]])
    errors = []
    for near in (0.0, 1.0):
        monkeypatch.setattr(plane_body, "NEAR", near)
        errors.append(plane_stress(law, gradient))
    assert errors[0] == pytest.approx(errors[1], abs=1e-10)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"alpha": [2.0, 3.0]}, "alpha: must have as many numbers as mu, 1"),
        ({"alpha": [0.0]}, "alpha: must be from 0.1 to 14"),
        ({"mu": [-1.0]}, "must have a shear modulus above 0 MPa"),
        ({"mu": 1.0}, "mu: must be a list"),
        ({"mu": [3.0, -2.0], "alpha": [-9.0, 4.0]}, "must pull a bar the more the longer it is"),
    ],
)
def test_terms_that_are_none_are_refused(change: dict[str, object], words: str) -> None:
    with pytest.raises(InputError, match=words):
        Ogden(**{"mu": [1.0], "alpha": [2.0], **change})
