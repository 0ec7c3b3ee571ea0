"""A pad that sticks to the plate, of a block: what is solved is what was asked, and in balance."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest

from skincad.mechanics import PadPiece, SizeError, Sizes, piece_of, triangles
from skincad.mechanics.bodies import elements
from skincad.mechanics.dynamics import pad as moving_pad
from skincad.mechanics.film import sliding as sliding_pad
from skincad.mechanics.film.stick import level
from tests.mechanics.film.test_stress import strips_in_a_block

FORCE = 0.3  # N


@cache
def meshed(halved: bool) -> tuple[PadPiece, object]:
    pad, thickness = strips_in_a_block(30.0)
    piece = piece_of(replace(pad, density=1000.0, film_density=1780.0), thickness, halved)
    return piece, triangles(piece.pad, Sizes(0.5, 0.5, 0.5, 0.5))


@pytest.mark.parametrize("halved", [False, True])
@pytest.mark.parametrize("pull", [False, True])
def test_it_is_pulled_only_where_that_is_asked(pull: bool, halved: bool) -> None:
    piece, mesh = meshed(halved)
    assert piece.mirrored == halved
    solution = level(piece, mesh, 2, FORCE, pull)
    assert (solution.pull_state is not None) == pull
    # balances, to rounding
    assert solution.normal_state.normal.sum() == pytest.approx(FORCE, rel=1e-9)
    assert solution.normal_state.tangential.sum() == pytest.approx(0.0, abs=1e-9)
    assert solution.normal_state.node.sum() == pytest.approx(FORCE / (2 if halved else 1), rel=1e-9)
    if solution.pull_state:
        assert solution.pull_state.tangential.sum() == pytest.approx(1.0, rel=1e-9)
        assert solution.pull_state.normal.sum() == pytest.approx(0.0, abs=1e-9)
    assert solution.residual < 1e-9
    assert set(solution.seconds) == {"assemble", "condense", "contact"}


def test_as_many_contact_unknowns_as_fit_are_taken_and_one_more_is_refused(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for halved in (False, True):
        piece, mesh = meshed(halved)
        points = sliding_pad.sliding(piece, mesh, 2, False).gap.size
        # both components, on both halves of what is halved
        unknowns = 2 * (2 if halved else 1) * elements.contact_unknowns(elements.curved(mesh, 2), 2)
        monkeypatch.setattr(sliding_pad, "MOST_CONTACT_UNKNOWNS", unknowns)
        assert sliding_pad.sliding(piece, mesh, 2, False).gap.size == points
        monkeypatch.setattr(sliding_pad, "MOST_CONTACT_UNKNOWNS", unknowns - 1)
        with pytest.raises(SizeError, match=rf"at most {unknowns - 1} contact unknowns.* got {unknowns}"):
            sliding_pad.sliding(piece, mesh, 2, False)
        if not halved:  # enough: it counts whole points
            monkeypatch.undo()
            continue
        monkeypatch.setattr(moving_pad, "MOST_CONTACT_UNKNOWNS", 2 * points)
        assert moving_pad.linear(piece, mesh, 2, False).gap.size == points
        monkeypatch.setattr(moving_pad, "MOST_CONTACT_UNKNOWNS", 2 * points - 1)
        with pytest.raises(SizeError, match=rf"at most {2 * points - 1} contact unknowns.* got {2 * points}"):
            moving_pad.linear(piece, mesh, 2, False)
        monkeypatch.undo()
