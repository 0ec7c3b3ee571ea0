"""How long a nozzle moves: straight moves and loops of lines, with acceleration and slower corners.

A move begins and ends at the speed that a corner allows, accelerates evenly and brakes evenly, as firmware
of printers plans it, but for looking further ahead than one line: where a circle of short chords begins or
ends, that is 0.02 s too much, about what is left out of ends of filling. Source: PrusaSlicer's own estimate,
whose machine limits are the defaults here.
"""

from __future__ import annotations

import math

import numpy as np
from manifold3d import CrossSection
from numpy.typing import NDArray

from skincad.base.arrays import Array

JERK = 10.0  # mm/s, source: PrusaSlicer's machine_max_jerk_x and _y, by which speed may jump along an axis
DIAGONAL = math.sqrt(2.0)  # lines that fill lie at 45 degrees: each axis has its share of a jump
_SHORTEST = 1e-9  # mm, of a line: no division by 0


def moves(length: float, count: float, speed: float, corner: float, acceleration: float) -> float:
    """Return the s that `count` equal straight moves of `length` mm together take, each from `corner` mm/s to
    `speed` mm/s, or to what it reaches, and back."""
    if count <= 0 or length <= 0:
        return 0.0
    corner = min(corner, speed)
    size = length / count
    if size * acceleration >= speed**2 - corner**2:
        return count * (size / speed + (speed - corner) ** 2 / (acceleration * speed))
    return count * 2 * (math.sqrt(corner**2 + acceleration * size) - corner) / acceleration


def contour_moves(section: CrossSection, speed: float, acceleration: float) -> tuple[float, float]:
    """Return mm and s of lines along all contours of a section, each begun and ended at the jerk's speed."""
    if section.is_empty():
        return 0.0, 0.0
    steps, last = _edges(section)
    length = np.maximum(np.hypot(*steps.T), _SHORTEST)
    ways = steps / length[:, None]
    jump = np.abs(np.roll(ways, -1, axis=0) - ways).max(axis=1) * speed
    after = speed * np.minimum(1.0, JERK / np.maximum(jump, _SHORTEST))
    after[last] = min(JERK, speed)
    before = np.roll(after, 1)  # every contour begins as every other one ends
    mean = (before**2 + after**2) / 2
    peak = np.sqrt(np.minimum(speed**2, acceleration * length + mean))
    peak = np.maximum(peak, np.maximum(before, after))
    cruising = np.maximum(0.0, length - (peak**2 - mean) / acceleration) / peak
    return float(length.sum()), float(((2 * peak - before - after) / acceleration + cruising).sum())


def fill_moves(
    region: CrossSection, spacing: float, speed: float, acceleration: float
) -> tuple[float, float, float]:
    """Return how many parallel lines at 45 degrees, `spacing` mm apart, fill a region; their mm and s, with
    the way from each to the next along the edge.

    As many lines end on the contours as their edges are long across the lines (Cauchy), by both diagonals.
    """
    if region.is_empty():
        return 0.0, 0.0, 0.0
    steps, _ = _edges(region)
    widths = np.abs(steps @ [[1.0, 1.0], [-1.0, 1.0]]) / DIAGONAL
    count, length = float(widths.sum()) / 4 / spacing, region.area() / spacing
    corner = min(speed, JERK * DIAGONAL)
    link = moves(DIAGONAL * spacing * count, count, speed, corner, acceleration)
    return count, length, moves(length, count, speed, corner, acceleration) + link


def _edges(section: CrossSection) -> tuple[Array, NDArray[np.int_]]:
    """From corner to corner of all contours, `(n, 2)` mm, and which of these close a contour."""
    contours = section.to_polygons()
    points, last = np.vstack(contours), np.cumsum([len(contour) for contour in contours]) - 1
    onward = np.arange(1, len(points) + 1)
    onward[last] = [0, *(last[:-1] + 1)]
    return points[onward] - points, last
