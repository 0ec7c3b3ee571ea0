"""Responses add up to the films' stress, and are symmetric as the pad is."""

from __future__ import annotations

import numpy as np
import pytest

import skincad
from skincad.base import InputError
from skincad.mechanics import FilmResponse, film_response

NAMES = ("steep-fingertip", "fingertip-soft", "yamada-2002", "yamada-2002-tilted")


@pytest.fixture(
    scope="module", params=[pytest.param(n, marks=[pytest.mark.slow] * (i > 0)) for i, n in enumerate(NAMES)]
)
def case(request: pytest.FixtureRequest) -> tuple[skincad.Design, FilmResponse]:
    design = skincad.load_design(request.param)
    return design, film_response(design)


def test_they_add_up_to_the_stress_of_check(case: tuple[skincad.Design, FilmResponse]) -> None:
    """Pressed alone, and pulled by a quarter: within both errors, by the forces that each tells itself."""
    design, felt = case
    for state in skincad.film_stress(design).states:
        normal = np.array([float(estimate) for estimate in state.ridge_force])
        pull = np.array([float(estimate) for estimate in state.ridge_tangential])
        stress = felt.stress(normal, pull).reshape(-1, 2, 3)
        error = felt.stress_error(normal, pull)
        pairs = [(state.s1, state.s2), (state.along1, state.along2), (state.lengthwise1, state.lengthwise2)]
        for k, pair in enumerate(pairs):
            theirs = np.array([[float(e) for e in side] for side in pair]).T
            assert np.abs(stress[:, :, k] - theirs).max() <= error[k] + (pair[0][0].error or 0.0)
            assert error[k] <= 0.25 * np.abs(theirs).max()  # worth something: errors of all ridges add up


def test_a_mirrored_force_gives_the_mirrored_stress(case: tuple[skincad.Design, FilmResponse]) -> None:
    """S1 of ridge i under a force on ridge j is S2 of the mirrored ridge; a tangential one turns its sign."""
    _, felt = case
    for k, (way, sign) in enumerate(((felt.normal, 1), (felt.tangential, -1))):
        difference = np.abs(way - sign * way[::-1, ::-1]).max(axis=(0, 1))
        assert (difference <= 2 * felt.error[k].max(axis=0)).all()


def test_forces_of_the_reference_add_up(case: tuple[skincad.Design, FilmResponse]) -> None:
    design, felt = case
    assert felt.ridge_force.sum() == pytest.approx(design.contact.force, rel=1e-9)
    assert felt.ridge_force_per_pull.sum(axis=1) == pytest.approx([0.0, 1.0], abs=1e-9)


def test_without_slots_there_is_none() -> None:
    with pytest.raises(InputError, match="slot: is missing"):
        film_response(skincad.load_design("plain-ridges"))
