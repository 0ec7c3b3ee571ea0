"""Where a view lies on its sheet, and its bores there: centre lines, and threads as ISO 6410-1 draws them."""

from __future__ import annotations

import math
from typing import NamedTuple

from skincad.fabrication.bore_fits import major
from skincad.fabrication.bore_table import HoleGroup, SideView
from skincad.pictures.marks import Box, Ink, Mark, line
from skincad.solids.projection import Arc, Place, Polyline, Projection, Stroke

OVERSHOOT = 1.0  # mm of paper, of a centre line beyond the bore
THREE_QUARTERS = math.radians(100.0), math.radians(270.0)  # start and sweep of a thread's circle


class ViewPlacement(NamedTuple):
    """A view on paper: `origin` mm is where its (0, 0) lies, `scale` paper by part."""

    origin: Place
    scale: float

    def at(self, point: Place) -> Place:
        """Return a view's point on paper, mm."""
        return self.origin[0] + self.scale * point[0], self.origin[1] + self.scale * point[1]

    def stroke(self, stroke: Stroke) -> Stroke:
        """Return a view's stroke on paper."""
        if isinstance(stroke, Arc):
            return Arc(self.at(stroke.centre), self.scale * stroke.radius, stroke.start, stroke.sweep)
        return Polyline(tuple(self.at(point) for point in stroke.points))

    def box(self, projection: Projection) -> Box:
        """Return the rectangle of a view on paper, mm."""
        low, high = projection.box()
        return (*self.at(low), *self.at(high))


def bore_marks(holes: tuple[HoleGroup, ...], placements: dict[str, ViewPlacement]) -> list[Mark]:
    """Return the bores' centre lines, from their ends and sides, and their threads."""
    marks: list[Mark] = []
    for group in holes:
        place, wide = placements[group.view], major(group.thread)
        for hole in group.holes:
            centre = place.at(hole.at)
            marks += _cross(centre, place.scale * max(group.diameter, group.far_diameter) / 2)
            if wide is not None:
                marks.append(Ink(Arc(centre, place.scale * wide / 2, *THREE_QUARTERS), "THREAD"))
        for side_view in group.side_views:
            marks += _along(side_view, placements[side_view.view], wide and wide / 2, group)
    return marks


def _cross(centre: Place, radius: float) -> list[Mark]:
    out, (x, y) = radius + OVERSHOOT, centre
    return [line((x - out, y), (x + out, y), "CENTRE"), line((x, y - out), (x, y + out), "CENTRE")]


def _along(side_view: SideView, place: ViewPlacement, radius: float | None, group: HoleGroup) -> list[Mark]:
    """A bore's centre line from the side, and its thread's lines: hidden, so broken. Where the thread ends
    before the bore does, a line across says so."""
    start, end = place.at(side_view.start), place.at(side_view.end)
    long = math.dist(start, end)
    u, v = (end[0] - start[0]) / long, (end[1] - start[1]) / long
    tail, head = (
        (start[0] - OVERSHOOT * u, start[1] - OVERSHOOT * v),
        (end[0] + OVERSHOOT * u, end[1] + OVERSHOOT * v),
    )
    marks: list[Mark] = [line(tail, head, "CENTRE")]
    if radius is None:
        return marks
    if group.full is not None:  # blind, from above: its mouth is where the bore ends
        deep = group.full * place.scale
        start = end[0] - deep * u, end[1] - deep * v
    x, y = -radius * place.scale * v, radius * place.scale * u
    sides = [((start[0] + s * x, start[1] + s * y), (end[0] + s * x, end[1] + s * y)) for s in (-1, 1)]
    marks += [line(*side, "HIDDEN") for side in sides]
    if group.full is not None:
        marks.append(line(sides[0][0], sides[1][0], "HIDDEN"))
    return marks
