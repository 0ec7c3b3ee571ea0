"""Air that stays in the mold while silicone rises in it, where it lies, and at which tilt least stays.

Statics: the level rises slowly, wets everything and leaves no bubble of its own; what silicone's viscosity
catches besides, and what the mix holds, has to be taken out of it before. An open pour is two fillings: the
level trough with its back open, then the closed mold at the tilt at which the carrier is laid on.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np
import shapely

from skincad.fabrication.finding import Finding
from skincad.fabrication.levels import Cells, Points, TrappedAir, cells, trapped, vertical
from skincad.fabrication.void import Void, open_trough, single_skin_mold, void
from skincad.inputs.design import Design
from skincad.shape.curves import polygon
from skincad.solids.ends import gate
from skincad.solids.layout import end_angle
from skincad.solids.mold import ClosedMold, mold
from skincad.solids.plan import PartRole, Prism, Vector

CHORD = 1e-3  # mm, of arcs; a tenth of it changes no pocket of a template by 0.001 mm3
# mm3, assumption: a bubble of 0.27 mm across, two walls between film and flank; less is let go
LEAST_POCKET = 0.01
BUBBLE_SHARE = 0.25  # assumption: share of the skin's thickness that a bubble in its body may be across
TILTS = (
    2.0,
    60.0,
)  # deg, assumption: below 2 a flat face leads no bubble along; mold.pour_tilt's upper limit
PRESSURE_REMEDY = "brush silicone into the grooves before closing, or cure in a pressure pot"
SURFACE_TOLERANCE = 1e-6  # mm; closer than this a pocket's top is on a surface


@dataclass(frozen=True)
class Pocket:
    """Air that no way leads out of: what it lies under, its highest place (mm, mold's frame), its volume in
    mm3 and its height in mm along the vertical."""

    where: str
    alike: str  # pockets with the same value make one finding
    place: Vector
    volume: float
    height: float
    harm: Literal["relief", "body", "riser"]  # at a ridge or slot; elsewhere in the skin; beside it


class _Surface(NamedTuple):
    name: str
    alike: str  # as a pocket's
    relief: bool  # belongs to a ridge or slot
    edge: shapely.LineString  # (x, z) mm


class _Filling(NamedTuple):
    space: Void
    cells: Cells
    surfaces: list[_Surface]
    tilted: bool


def pockets(design: Design, closed: ClosedMold, tilt: float | None = None) -> tuple[Pocket, ...]:
    """Return the air pockets of at least `LEAST_POCKET` mm3, the largest first.

    End b is up by `tilt` deg, by the design's own tilt if not given.
    """
    return tuple(_pockets(_fillings(design, closed), design.mold.pour_tilt if tilt is None else tilt))


def best_tilt(design: Design, closed: ClosedMold) -> tuple[float, float]:
    """Return the tilt in deg (within `TILTS`) at which least air stays, to 0.5 deg, and how much, mm3.

    Every 5 deg first, then finer about the best; of equal ones the nearest to the design's own.
    """
    fillings = _fillings(design, closed)

    def rank(tilt: float) -> tuple[float, float]:
        air = math.fsum(pocket.volume for pocket in _pockets(fillings, tilt))
        return round(air, 3), abs(tilt - design.mold.pour_tilt)

    low, high = TILTS
    best = min((low, *(float(tilt) for tilt in range(5, int(high) + 1, 5))), key=rank)
    for step in (1.0, 0.5):
        near = [best + step * i for i in range(-4, 5)]
        best = min((tilt for tilt in near if low <= tilt <= high), key=rank)
    return best, rank(best)[0]


def filling_findings(design: Design, closed: ClosedMold) -> list[Finding]:
    """Return the rule `trapped air`: a warning where it harms the skin, a note where it doesn't.

    At a ridge or slot the limit is `LEAST_POCKET`. In the skin's body it is a bubble with a diameter of
    `BUBBLE_SHARE` of the thickness. Pockets of one kind make one finding.
    """
    if design.skin.curvature_radius_y is not None:
        return _bent_findings(design)
    air = pockets(design, closed)
    if not air:
        return _level(design)
    remedy = _remedy(design, closed, math.fsum(pocket.volume for pocket in air))
    return [*_level(design), *_grouped_findings(design, air, remedy)]


def _bent_findings(design: Design) -> list[Finding]:
    """Both ends of a doubly curved skin rise, by the angle that they lean. What stays at an end is judged on
    the straight mold of the section at that end's slope: a pocket is short against curvature_radius_y."""
    straight = design.with_(skin={"curvature_radius_y": None})
    closed, rise, tilt = mold(straight), math.degrees(end_angle(design)), design.mold.pour_tilt
    remedy, findings = PRESSURE_REMEDY, []
    if tilt <= rise:
        where = "end a, which stays high unless mold.pour_tilt exceeds the angle by which it leans"
        leave = f"mold.pour_tilt above {rise:.3g}; or fill slowly: its air escapes round the carrier"
        findings.append(Finding("trapped air", where, tilt, rise, "deg", "note", leave))
    for end, slope in (("b", rise + tilt), ("a", rise - tilt)):
        if slope <= 0:
            continue
        for finding in _grouped_findings(design, pockets(straight, closed, slope), remedy):
            place = finding.where.replace("end b", f"end {end}")
            findings.append(replace(finding, where=f"{place}, in a straight mold at the slope of end {end}"))
    return findings


def _level(design: Design) -> list[Finding]:
    """A note where the carrier lies so level that statics says nothing about bubbles under it."""
    tilt, least = design.mold.pour_tilt, TILTS[0]
    if tilt >= least:
        return []
    where, remedy = "carrier, too level to lead a bubble along", f"mold.pour_tilt of {least:g} or more"
    return [Finding("trapped air", where, tilt, least, "deg", "note", remedy)]


def _grouped_findings(design: Design, air: Iterable[Pocket], remedy: str) -> list[Finding]:
    kinds: dict[tuple[str, str], list[Pocket]] = defaultdict(list)
    for pocket in air:
        kinds[pocket.harm, pocket.alike].append(pocket)
    return [_finding(design, group, remedy) for group in kinds.values()]


def _finding(design: Design, group: list[Pocket], remedy: str) -> Finding:
    largest, volume = group[0], math.fsum(pocket.volume for pocket in group)
    body = math.pi / 6 * (BUBBLE_SHARE * design.skin.thickness) ** 3
    limit = LEAST_POCKET if largest.harm == "relief" else body
    harms = largest.harm != "riser" and largest.volume > limit
    x, y, z = (round(length, 2) + 0.0 for length in largest.place)  # no minus before a zero
    more = f" and {len(group) - 1} more like it" if len(group) > 1 else ""
    where = f"{largest.where} at ({x:g}, {y:g}, {z:g}), {largest.height:.2g} mm high{more}"
    return Finding("trapped air", where, volume, limit, "mm3", "warning" if harms else "note", remedy)


def _remedy(design: Design, closed: ClosedMold, now: float) -> str:
    tilt, least = best_tilt(design, closed)
    if least > 0.9 * now:
        return f"no tilt traps less: {PRESSURE_REMEDY}"
    rest = f"which traps {least:.2g} mm3: {PRESSURE_REMEDY}" if least else "which traps none"
    return f"mold.pour_tilt = {tilt:g}, {rest}"


def _fillings(design: Design, closed: ClosedMold) -> list[_Filling]:
    """The closed mold's filling, and for an open pour the open trough's: level, or it would run over."""
    closed = single_skin_mold(design, closed)
    spaces = [(void(design, closed), True)]
    if gate(design) is None:
        spaces.append((open_trough(closed), False))
    surfaces = _surfaces(closed)
    return [_Filling(space, cells(space, CHORD), surfaces, tilted) for space, tilted in spaces]


def _surfaces(closed: ClosedMold) -> list[_Surface]:
    """The surfaces that bound the skin in its section, by name. The skin is a prism, so x and z identify the
    surface of a point. Where several meet, the first counts: shim or strip, ridge, carrier, the rest."""
    body = closed.first(PartRole.SKIN).body
    if not isinstance(body, Prism):
        return []
    surfaces = []
    for part in closed.of(PartRole.SHIM, PartRole.STRIP):
        if isinstance(part.body, Prism):
            edge = shapely.LinearRing(polygon(part.body.outline, CHORD))
            surfaces.append(
                _Surface(part.name, f"{part.role.label} of ridge {part.body.outline[0].ridge}", True, edge)
            )
    segments = [*body.outline, *(s for hole in body.holes for s in hole)]
    for segment in sorted(segments, key=lambda s: (s.feature is None, s.kind != "back")):
        along = segment.points(np.linspace(0, 1, segment.pieces(CHORD) + 1))
        name = {"back": "carrier", "side": "side of the cavity", "base": "valley"}.get(segment.kind)
        name = name or f"{segment.kind.replace('_', ' ')} of ridge {segment.feature}"
        surfaces.append(_Surface(name, segment.kind, segment.feature is not None, shapely.LineString(along)))
    return surfaces


def _pockets(fillings: list[_Filling], tilt: float) -> list[Pocket]:
    pockets = []
    for filling in fillings:
        ignored = frozenset(i for i, part in enumerate(filling.space.spaces) if part.beside is PartRole.COVER)
        up = vertical(tilt if filling.tilted else 0.0)
        pockets += [_pocket(filling, up, air) for air in trapped(filling.cells, up, ignored)]
    return sorted((p for p in pockets if p.volume >= LEAST_POCKET), key=lambda p: (-p.volume, p.place))


def _pocket(filling: _Filling, up: Points, air: TrappedAir) -> Pocket:
    """Name what the air lies under: all that it touches has a corner of a cell above the air's level."""
    partition, spaces = filling.cells, filling.space.spaces
    skin = [c for c in air.cells if spaces[partition.space[c]].beside is PartRole.SKIN]
    if not skin:
        first = min(air.cells, key=lambda c: -float((partition.corners[c] @ up).max()))
        space = spaces[partition.space[first]]
        return Pocket(space.where, space.name, air.highest, air.volume, air.height, "riser")
    corners = np.unique(np.vstack([partition.corners[c] for c in skin]), axis=0)
    heights = corners @ up
    touched = [(p, h) for p, h in zip(corners, heights, strict=True) if h > air.level]
    points = shapely.points([(p[0], p[2]) for p, _ in touched])
    names = [[s for s in filling.surfaces if s.edge.distance(point) < SURFACE_TOLERANCE] for point in points]
    top = int(np.argmax([h for _, h in touched]))
    place = touched[top][0]
    where, alike = (names[top][0].name, names[top][0].alike) if names[top] else ("skin", "skin")
    ends = {-1: ", at end a's edge", 1: ", at end b's edge"}
    edge = ends.get(int(np.sign(place[1])), "") if abs(up[1]) > 0 else ""
    relief = any(s.relief for surfaces in names for s in surfaces)
    x, y, z = (float(v) for v in place)
    harm: Literal["relief", "body"] = "relief" if relief else "body"
    return Pocket(where + edge, where + edge if edge else alike, (x, y, z), air.volume, air.height, harm)
