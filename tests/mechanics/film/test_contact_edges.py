"""Crowns cut where contact ends: the curve stays, and the cuts lie where the state says."""

from __future__ import annotations

import math
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from skincad.mechanics import Pad, PadPiece
from skincad.mechanics.film.stick import cut_at, with_fine_edges
from skincad.shape import Point, Section, Segment
from tests.mechanics.bodies.test_elements import block


@pytest.mark.parametrize("backwards", [False, True])
@pytest.mark.parametrize("degrees", [-150.0, -10.0, 0.0, 1e-6, 30.0, 175.0])
def test_a_cut_curve_is_the_curve(degrees: float, backwards: bool) -> None:
    whole = Segment(Point(1.0, 2.0), Point(-2.0, 2.3), math.tan(math.radians(degrees) / 4), "crown", 3, True)
    if backwards:
        whole = whole.reversed()
    at = [0.5, -1.9, 7.0, 0.999, -2.0, 1.0]  # in any order; what lies outside or on its ends cuts nothing
    pieces = list(cut_at(whole, at))
    heads = [piece.start.x for piece in pieces[1:]]
    assert heads == pytest.approx(sorted([-1.9, 0.5, 0.999], reverse=not backwards), abs=1e-11)
    assert (pieces[0].start, pieces[-1].end) == (whole.start, whole.end)
    assert all(a.end == b.start for a, b in pairwise(pieces))
    assert sum(piece.length for piece in pieces) == pytest.approx(whole.length, rel=1e-12)
    assert sum(piece.sweep for piece in pieces) == pytest.approx(whole.sweep, rel=1e-12)
    for piece in pieces:
        assert (piece.kind, piece.feature) == ("crown", 3)
        assert degrees == 0.0 or piece.radius == pytest.approx(whole.radius, rel=1e-9)


@pytest.mark.parametrize("unit", [1.0, 0.5])
def test_the_top_is_cut_a_step_either_side_of_where_contact_ends(unit: float) -> None:
    """Points of a block's top in any order, of which those from -0.5 to 0.5 mm stick."""
    pad: Pad = block(4.0, 1.0, 0.3)
    piece = PadPiece(pad, pad, False, (), 0.0, unit)
    x = np.array([0.5, -2.0, 2.0, -1.0, 1.5, -0.5, 0.0])
    nodes = SimpleNamespace(position=np.column_stack([x, np.ones(7)]) / unit, ridge=np.ones(7, dtype=int))
    body = SimpleNamespace(system=SimpleNamespace(nodes=nodes))
    solution: Any = SimpleNamespace(body=body, bonded=np.abs(x) <= 0.5)
    fine = with_fine_edges(piece, solution)
    top = [s for s in fine.pad.section.outline if s.kind == "crown"]
    # contact ends between -1 and -0.5, a step of 0.5, and between 0.5 and 1.5, a step of 1
    assert [s.start.x for s in top] == pytest.approx([2.0, 1.0, 0.0, -0.25, -0.75, -1.25], abs=1e-11)
    rest = [s for s in pad.section.outline if s.kind != "crown"]
    assert [s for s in fine.pad.section.outline if s.kind != "crown"] == rest
    assert fine.whole is pad  # what is told of the section is told of the uncut one
    all_stick: Any = SimpleNamespace(body=body, bonded=np.ones(7, dtype=bool))
    assert with_fine_edges(piece, all_stick).pad.section == pad.section


def test_each_ridge_is_cut_by_its_own_points() -> None:
    def crown(ridge: int, middle: float) -> Segment:
        return Segment(Point(middle + 1, 1.0), Point(middle - 1, 1.0), 0.0, "crown", ridge, True)

    pad: Any = Pad(Section((crown(2, 3.0), crown(1, 0.0))), 2.0, 0.7, 0.3)
    x = np.array([-0.4, 0.4, 2.6, 3.4])
    nodes = SimpleNamespace(position=np.column_stack([x, x]), ridge=np.array([1, 1, 2, 2]))
    solution: Any = SimpleNamespace(
        body=SimpleNamespace(system=SimpleNamespace(nodes=nodes)), bonded=np.array([True, True, True, False])
    )
    cut = with_fine_edges(PadPiece(pad, pad, False, (), 0.0, 1.0), solution).pad.section.outline
    assert [(s.feature, round(s.start.x, 9)) for s in cut] == [
        (2, 4.0),
        (2, 3.8),
        (2, 3.0),
        (2, 2.2),
        (1, 1.0),
    ]
