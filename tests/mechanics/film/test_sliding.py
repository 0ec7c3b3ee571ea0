"""The condensed pad of both components: against the film-stress solver, its mirror image and the press."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from skincad.mechanics import ContactPad, PadPiece, filled_pad, piece_of, press, sliding, triangles, unit_of
from skincad.mechanics.film.stick import level
from skincad.mechanics.film.stress import REFINEMENTS
from tests.mechanics.designs import yamada

ORDER = 3


def three() -> PadPiece:
    return piece_of(*filled_pad(yamada().with_(ridge={"count": 3}, skin={"width": 5.0})))


@cache
def meshed() -> tuple[PadPiece, object, ContactPad]:
    piece = three()
    mesh = triangles(piece.pad, REFINEMENTS[0].sizes(piece))
    return piece, mesh, sliding(piece, mesh, ORDER, True)


def test_stresses_and_approach_are_the_film_stress_solvers() -> None:
    """The stresses come from one adjoint solve each; there, from the displacements' own integrals."""
    piece, mesh, pad = meshed()
    other = level(piece, mesh, ORDER, 1.2, False)
    m = pad.gap.size
    state = press(pad.compliance[m:, m:], pad.gap, 1.2)
    stress = pad.strips @ np.concatenate([np.zeros(m), -state.force])
    # 1e-9: rounding of two solves with strips 3750 times as stiff as the skin
    assert stress == pytest.approx(
        other.normal_state.strips, abs=1e-9 * np.abs(other.normal_state.strips).max()
    )


def test_pad_is_its_own_mirror_image() -> None:
    _, _, pad = meshed()
    m = pad.gap.size
    turn = np.concatenate([-np.ones(m), np.ones(m)])
    image = np.concatenate([np.arange(m)[::-1], m + np.arange(m)[::-1]])
    mirrored = (turn[:, None] * pad.compliance * turn)[np.ix_(image, image)]
    # rounding: both halves share one solution
    assert mirrored == pytest.approx(pad.compliance, abs=1e-13 * np.abs(pad.compliance).max())
    assert pad.x == pytest.approx(-pad.x[::-1], abs=1e-14)
    assert (pad.ridge == 4 - pad.ridge[::-1]).all()


@pytest.mark.slow
def test_the_half_agrees_with_the_whole() -> None:
    """Another mesh and no mirror conditions: a shear of all points and a press, to 0.5 % of mesh."""
    piece, _, half = meshed()
    slots, unit = piece.whole.section.slots, unit_of(piece.whole)
    whole = PadPiece(piece.whole, piece.whole, False, slots, piece.thickness, unit)
    pad = sliding(whole, triangles(whole.pad, REFINEMENTS[0].sizes(whole)), ORDER, True)
    answers = []
    for condensed in (half, pad):
        m = condensed.gap.size
        load = np.concatenate([condensed.weight, -0.5 * condensed.weight]) / condensed.weight.sum()
        moved = condensed.compliance @ load
        answers.append(
            np.array([moved[:m] @ condensed.weight, moved[m:] @ condensed.weight]) / condensed.weight.sum()
        )
        answers.append((condensed.strips @ load)[:, 0])
    assert answers[0] == pytest.approx(answers[2], rel=5e-3)
    assert answers[1] == pytest.approx(answers[3], abs=0.02 * np.abs(answers[1]).max())
