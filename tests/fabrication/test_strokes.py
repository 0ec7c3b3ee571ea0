"""Moves of a nozzle against closed forms, and against small steps of time."""

from __future__ import annotations

import math

import numpy as np
import pytest
from manifold3d import CrossSection

from skincad.fabrication.estimates import DIAGONAL, JERK, contour_moves, fill_moves, moves

FIRM = 1000.0  # mm/s2


def stepped(length: float, speed: float, corner: float) -> float:
    """The same by small steps of way: at each, the least of what start, end and the machine allow."""
    way = (np.arange(200_000) + 0.5) / 200_000 * length
    fast = np.sqrt(corner**2 + 2 * FIRM * np.minimum(way, length - way))
    return float((length / 200_000 / np.minimum(fast, speed)).sum())


@pytest.mark.parametrize("length", [0.3, 2.0, 6.3, 40.0])
def test_a_move_is_what_small_steps_give(length: float) -> None:
    assert moves(length, 1, 80.0, 10.0, FIRM) == pytest.approx(stepped(length, 80.0, 10.0), rel=1e-4)  # steps
    assert moves(3 * length, 3, 80.0, 10.0, FIRM) == pytest.approx(3 * moves(length, 1, 80.0, 10.0, FIRM))


def test_no_move_takes_no_time() -> None:
    assert moves(0.0, 3, 80.0, 10.0, FIRM) == moves(5.0, 0, 80.0, 10.0, FIRM) == 0.0


def test_a_square_is_four_moves_between_corners() -> None:
    length, seconds = contour_moves(CrossSection.square((20.0, 20.0)), 45.0, FIRM)
    assert length == pytest.approx(80.0)
    assert seconds == pytest.approx(moves(80.0, 4, 45.0, JERK, FIRM))


def test_a_circle_has_no_corner_but_its_begin() -> None:
    length, seconds = contour_moves(CrossSection.circle(10.0, 400), 45.0, FIRM)
    assert length == pytest.approx(2 * math.pi * 10.0, rel=1e-4)  # 400 chords
    begun_and_ended = 2 * (45.0 - JERK) ** 2 / (2 * FIRM * 45.0)
    # a chord alone can't reach that speed: twice (45 - 10) / 1000 s less what those ways take anyhow
    assert seconds == pytest.approx(length / 45.0 + begun_and_ended, abs=0.04)


def test_contours_do_not_know_of_each_other() -> None:
    two = CrossSection.square((20.0, 20.0)) + CrossSection.circle(3.0, 24).translate((40.0, 0.0))
    alone = [contour_moves(contour, 45.0, FIRM) for contour in two.decompose()]
    assert contour_moves(two, 45.0, FIRM) == pytest.approx(tuple(map(sum, zip(*alone, strict=True))))


def test_lines_fill_a_rectangle_less_its_hole() -> None:
    count, length, seconds = fill_moves(CrossSection.square((30.0, 10.0)), 0.4, 80.0, FIRM)
    assert count == pytest.approx(40.0 / DIAGONAL / 0.4)  # its width across the diagonal
    assert length == pytest.approx(300.0 / 0.4)
    corner = JERK * DIAGONAL
    link = moves(DIAGONAL * 0.4 * count, count, 80.0, corner, FIRM)
    assert seconds == pytest.approx(moves(length, count, 80.0, corner, FIRM) + link)
    holed = CrossSection.square((30.0, 10.0)) - CrossSection.circle(2.0, 400).translate((15.0, 5.0))
    assert fill_moves(holed, 0.4, 80.0, FIRM)[0] == pytest.approx(count + 4.0 / 0.4, rel=1e-4)  # its diameter


def test_nothing_is_filled_in_no_time() -> None:
    assert fill_moves(CrossSection(), 0.4, 80.0, FIRM) == (0.0, 0.0, 0.0)
    assert contour_moves(CrossSection(), 45.0, FIRM) == (0.0, 0.0)
