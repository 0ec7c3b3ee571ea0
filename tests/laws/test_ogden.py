"""Ogden's closed forms (Proc. R. Soc. A 326 (1972) 565, eqs (37) and (41)), and what it is for other laws."""

from __future__ import annotations

import numpy as np
import pytest

from skincad.base import InputError
from skincad.laws import MooneyRivlin, Ogden
from skincad.mechanics.bodies import plane_body
from tests.laws.closed import Closed, holds, plane_stress

TERMS = ((0.2, 2.5), (0.06, -1.7), (0.01, 7.0))


@pytest.mark.parametrize("terms", [TERMS[:1], TERMS, ((0.3, 2.0),), ((0.3, -14.0),), ((0.3, 14.0),)])
def test_closed_forms(terms: tuple[tuple[float, float], ...]) -> None:
    def summed(of: object) -> float:
        return sum(2 * mu / a * of(a) for mu, a in terms)  # type: ignore[operator]

    def sheared(shift: float) -> float:
        stretch = (shift + np.sqrt(shift**2 + 4)) / 2
        return summed(lambda a: (stretch**a - stretch**-a) / (stretch + 1 / stretch))

    holds(
        Closed(
            Ogden(mu=[mu for mu, _ in terms], alpha=[a for _, a in terms]),
            bar=lambda t: summed(lambda a: t ** (a - 1) - t ** (-a / 2 - 1)),
            sheet=lambda t: summed(lambda a: t ** (a - 1) - t ** (-2 * a - 1)),
            sheared=sheared,
        )
    )


def test_powers_2_and_minus_2_are_mooney_rivlin() -> None:
    gradient = np.array([[0.3, -0.2], [0.5, 0.1]])
    ogden, mooney = Ogden(mu=[0.4, 0.2], alpha=[2.0, -2.0]), MooneyRivlin(c10=0.2, c01=0.1)
    assert plane_stress(ogden, gradient) == pytest.approx(plane_stress(mooney, gradient), rel=1e-12)


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
