"""Knife edges: corners of a made part so sharp that they chip or bend, and leave a flash where they part.

At a corner of the plan's outline the part's own angle lies between the tangents of the two segments. What is
worked here is the outline's plane; along a prism every face meets its ends at a right angle.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from skincad.fabrication.finding import Finding
from skincad.fabrication.rules import Case, Rule
from skincad.shape.curves import Loop, Point, Segment
from skincad.solids.plan import Prism

LEAST_ANGLE = 30.0  # deg, assumption: a more pointed edge of metal or resin chips within a few castings
_SHORTEST = 1e-6  # mm; a shorter segment has no direction to speak of


def edges(outline: Loop) -> list[tuple[Point, float]]:
    """Return every corner of an outline and the material's angle there in deg, 180 where it runs straight."""
    real = [s for s in outline if s.chord > _SHORTEST]
    corners = []
    for before, after in zip([real[-1], *real[:-1]], real, strict=True):
        turn = math.remainder(_heading(after, 0.0) - _heading(before, 1.0), 2 * math.pi)
        corners.append((after.start, math.degrees(math.pi - turn)))
    return corners


def _heading(segment: Segment, fraction: float) -> float:
    """Direction of a segment's tangent, rad."""
    chord = math.atan2(segment.end.z - segment.start.z, segment.end.x - segment.start.x)
    return chord + (fraction - 0.5) * segment.sweep


def _knife_edge(case: Case) -> Iterator[Finding]:
    """The sharpest corner of a part; no process makes a plan's angle blunter."""
    body = case.along.body
    if not isinstance(body, Prism):
        return
    place, angle = min(edges(body.outline), key=lambda edge: edge[1])
    if angle < LEAST_ANGLE:
        where = f"{case.part.role.label}, x {place.x:.3g}, z {place.z:.3g} mm"
        remedy = "a slot or flank that meets its parting line at a larger angle, or a larger curvature_radius"
        yield Finding("knife edge", where, angle, LEAST_ANGLE, "deg", "warning", remedy)


EDGE_RULES: tuple[Rule, ...] = (_knife_edge,)
