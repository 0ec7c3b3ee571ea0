"""How an end plate is split: comb and keeper meet on a circle at the slits' back ends.

In the design's frame: the split runs from -x to x, straight, then along a circle concentric with the base
circle, then straight. The comb lies beyond it (towards the ridges) and has a notch for every slot.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import pairwise

import numpy as np
import shapely

from skincad.base.errors import InputError
from skincad.inputs.design import Design
from skincad.shape.curves import Loop, Point, Segment, concentric_hit
from skincad.shape.feature import SensorPlace
from skincad.shape.skin import Section, skin_of

LEAST_TOOTH = 1e-3  # mm; a thinner tooth between two notches is none
_MEET = "neighbouring notches of the comb meet"
_APART = "reduce it, or move the slots apart or tilt them less"


def split_height(design: Design, shape: Section) -> tuple[float, float, float]:
    """Split of the end plates in the design's frame: height over the base circle, z beside the arc, half
    angle of the arc. A plain end plate is not split, its bolts sit as if it were at the base circle."""
    skin = skin_of(design)
    slot = skin.slot
    radius, thickness = design.skin.curvature_radius, design.skin.thickness
    corners = [p for s in shape.slots for p in _corners(s, design.mold.slit_clearance)]
    if not corners:
        return (
            0.0,
            thickness - 2 * radius * math.sin(skin.lean(skin.count) / 2) ** 2,
            0.0,
        )
    over = [_over_base(p, radius, thickness) for p in corners]
    height = min(over) - notch_rise(design, shape.slots)
    angle = max(math.atan2(p.x, radius + p.z - thickness) for p in corners)
    wide = design.core_thickness + 2 * design.mold.slit_clearance + notch_rise(design, shape.slots)
    # beyond the outermost corner lies the rest of its mouth, which a tilt stretches
    angle += wide * max(1.0, math.tan(math.radians(abs(slot.tilt if slot else 0.0)))) / radius
    level = thickness + height - 2 * (radius + height) * math.sin(angle / 2) ** 2
    return height, level, angle


def split_edges(design: Design, shape: Section, half: float) -> tuple[list[Segment], list[Segment]]:
    """The split from -x to x in the design's frame: the comb's edge, with a notch up to every slot's outer
    end, and the keeper's, which runs straight over the notches' mouths."""
    radius = design.skin.curvature_radius
    height, level, angle = split_height(design, shape)
    reach = (radius + height) * math.sin(angle)

    def arc(start: Point, end: Point) -> Segment:
        turn = _angle(end, design) - _angle(start, design)
        if turn <= 0:
            gap = design.mold.slit_clearance
            raise InputError("mold.slit_clearance", _MEET, gap, _APART)
        return Segment(start, end, -math.tan(turn / 4))

    here, last = Point(-reach, level), Point(reach, level)
    comb = [Segment(Point(-half, level), here)]
    keeper = list(comb)
    notches = sorted(_notch(design, slot, height) for slot in shape.slots)
    for one, other in pairwise(shapely.Polygon(notch) for notch in notches):
        if one.distance(other) < LEAST_TOOTH:
            gap = design.mold.slit_clearance
            raise InputError("mold.slit_clearance", _MEET, gap, _APART)
    for notch in notches:
        between, mouth = arc(here, notch[0]), arc(notch[0], notch[-1])
        comb += [between, *path(notch)]
        keeper += [between, mouth]
        here = notch[-1]
    rest = [arc(here, last), Segment(last, Point(half, level))]
    return comb + rest, keeper + rest


def _notch(design: Design, slot: SensorPlace, height: float) -> list[Point]:
    """Corners of a comb's notch, from its mouth on the split circle round the slot's outer end. A shim has
    its clearance there too; a strip that is cast in lies on the notch's bottom, its datum."""
    skin = skin_of(design)
    radius, gap = design.skin.curvature_radius, design.mold.slit_clearance
    a, b = slot.thickness / 2 + gap, slot.depth / 2 + gap
    bottom = slot.depth / 2 if design.mold.method == "cast-in" else b
    along, mouth = np.array(slot.direction), []
    shift = notch_rise(design, [slot]) * slot.direction[0]  # across the slot, what rises straight goes aside
    left, right = -a + min(shift, 0.0), a + max(shift, 0.0)
    for side in (left, right):
        foot = slot.at(side, -b)
        start = np.array([foot.x, foot.z - design.skin.thickness])
        u = concentric_hit(start, along, 1 / radius, height + height * height / (2 * radius))
        if u is None:
            rule = "turns its notch so far that it has no mouth in the comb's edge"
            raise InputError("slot.tilt", rule, skin.slot and skin.slot.tilt, "reduce it")
        mouth.append(Point(foot.x + u * float(along[0]), foot.z + u * float(along[1])))
    return [mouth[0], slot.at(left, bottom), slot.at(right, bottom), mouth[1]]


def notch_rise(design: Design, slots: Iterable[SensorPlace]) -> float:
    """Return by how much shims of a doubly curved skin rise towards the axis on their way through an end
    plate, mm; 0 where they are straight.

    A notch is straight, so it is higher and wider by that. Its datum stays: the shim is an arc as stiff as a
    blade, and touches one side of a notch at the plate's inner face and the other one at its outer face.
    """
    arm, thick = design.skin.back_radius, design.mold.end_plate
    arm += min((p.z for slot in slots for p in _corners(slot, design.mold.slit_clearance)), default=0.0)
    return thick**2 / (arm + math.sqrt(arm**2 - thick**2))


def _angle(point: Point, design: Design) -> float:
    return math.atan2(point.x, design.skin.curvature_radius + point.z - design.skin.thickness)


def _over_base(point: Point, radius: float, thickness: float) -> float:
    """Distance of a point from the base circle, outward, without forming the far centre."""
    n = point.z - thickness
    return (point.x**2 + n * n + 2 * radius * n) / (radius + math.hypot(point.x, radius + n))


def _corners(slot: SensorPlace, grown: float) -> list[Point]:
    return [s.start for s in slot.loop(grown=grown)]


def closed_edge(edge: list[Segment], z: float) -> Loop:
    """Close an edge by straight sides over the level z."""
    start, end = edge[0].start, edge[-1].end
    return (*edge, *path([end, Point(end.x, z), Point(start.x, z), start]))


def path(points: list[Point]) -> list[Segment]:
    """Return straight segments from point to point, none without length."""
    return [Segment(a, b) for a, b in pairwise(points) if a != b]
