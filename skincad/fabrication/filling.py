"""How a mold fills: the void that silicone fills, its levels, and the air that stays.

Everything that silicone can reach in the closed mold: disjoint prisms and bores that touch on plane faces,
and a round skin. In a doubly curved mold the skin and what touches its back are curved; volumes hold there as
well.

The seats (carrier on ledge, cover on carrier) and the shims' slits in the end plates count as tight.

To which level air escapes from every place of a void while a liquid rises in it: the void is cut into convex
cells. In a convex cell a straight way leads from any point to any other and never below the lower of them, so
a cell needs one number: the level of the best way out of it. That way's lowest passage is as high as can be
(a widest path; Pollack 1960), and passages are the faces that cells share, each as high as its highest
corner. Levels spread from the outlets, cell by cell, until none rises. Exact but for arcs as chords.

Statics: the level rises slowly, wets everything and leaves no bubble of its own; what silicone's viscosity
catches besides, and what the mix holds, has to be taken out of it before. An open pour is two fillings: the
level trough with its back open, then the closed mold at the tilt at which the carrier is laid on.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal, NamedTuple

import numpy as np
import shapely
from manifold3d import Manifold, triangulate
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from skincad.base.arrays import Array
from skincad.base.errors import RefusedError
from skincad.fabrication.job import Job
from skincad.fabrication.rules import Finding, note, warning
from skincad.inputs.design import Design
from skincad.shape import curves
from skincad.shape.curves import polygon
from skincad.solids.bent import gap_beside
from skincad.solids.kind import kind_of
from skincad.solids.layout import end_angle
from skincad.solids.mold import ClosedMold
from skincad.solids.plan import (
    END_PLATES,
    Body,
    Bore,
    CutRole,
    PartRole,
    Prism,
    TurnedBody,
    Vector,
    bores,
    turn_steps,
)

Points = Array
TOUCH = 1e-9  # mm and mm2; faces within it are on one plane, and less of a common area is none
LEVEL = 1e-9  # mm; air less than this above its way out is rounding
CHORD = 1e-3  # mm, of arcs; a tenth of it changes no pocket of a template by 0.001 mm3
TURN_CHORD = 0.02  # mm, of a round skin's turn: its highest places are exact, what lies between is 0.2 % off
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
class Space:
    """A part of the void, in or beside a part of the mold. Air leaves it through its faces on the plane
    z = `open_at` mm."""

    name: str
    body: Body
    beside: PartRole
    open_at: float | None = None
    number: int | None = None  # among spaces of its name

    @property
    def where(self) -> str:
        """The name of the place, as a finding says it."""
        return self.name if self.number is None else f"{self.name} {self.number}"


@dataclass(frozen=True)
class Void:
    """Spaces that touch, and the rim over which silicone runs off, `(n, 3)` mm: it rises no higher."""

    spaces: tuple[Space, ...]
    rim: Array | None = None

    @property
    def volume(self) -> float:
        """Volume by formula, mm3."""
        return math.fsum(space.body.volume for space in self.spaces)


def void(job: Job) -> Void:
    """Return what the silicone fills in a mold of one skin: skin, gate, the carrier's holes and vent, the gap
    round the carrier, bleeds and the reservoir in the cover. A gate stays shut by its syringe; bleeds are
    taped when full. Of a skin in layers it is the gate of the last pour."""
    closed = job.single.closed
    carrier, cover = closed.first(PartRole.CARRIER), closed.first(PartRole.COVER)
    top = cover.body.high if isinstance(cover.body, Prism) else math.inf
    open_over = CutRole.RESERVOIR, CutRole.BLEED
    over = bores(cover, *open_over)
    through = [bore for part in closed.of(PartRole.SEAL) for bore in bores(part, *open_over)]
    rivets = enumerate(bores(carrier, CutRole.RIVET), 1)
    gates = [cut for part in closed.of(*END_PLATES) for cut in part.cuts if cut.role is CutRole.GATE]
    spaces = [
        Space("skin", closed.first(PartRole.SKIN).body, PartRole.SKIN),
        *(Space("vent", bore, PartRole.CARRIER) for bore in bores(carrier, CutRole.VENT)),
        *(Space("carrier hole", bore, PartRole.CARRIER, number=i) for i, bore in rivets),
        *(Space("gap round the carrier", ring, PartRole.CARRIER) for ring in _gap(job.cast, carrier.body)),
        *(Space("seal", bore, PartRole.COVER) for bore in through),
        *(Space("cover", bore, PartRole.COVER, top) for bore in over),
        *(Space("gate", gate, PartRole.END_PLATE) for gate in gates[:1]),
    ]
    return Void(tuple(spaces), _rim(over[0]))


def open_trough(closed: ClosedMold) -> Void:
    """Return the skin's space with its back open, as the silicone is poured into it before the carrier."""
    return Void((Space("skin", closed.first(PartRole.SKIN).body, PartRole.SKIN, open_at=0.0),))


def _gap(design: Design, carrier: Body) -> list[Prism]:
    gap = design.mold.clearance
    if gap == 0.0 or not (kind_of(design).ends and isinstance(carrier, Prism)):
        return []  # a round carrier lies on its ledge all round
    if carrier.axis == "x":
        return gap_beside(carrier, gap)
    corners = np.array([s.start for s in carrier.outline])
    (x, y), half = corners.max(axis=0), design.skin.length / 2
    outer = curves.rectangle(-float(x) - gap, float(x) + gap, -half, half)
    inner = curves.rectangle(-float(x), float(x), -float(y), float(y))
    return [replace(carrier, outline=outer, holes=(inner,))]


def _rim(cup: Bore) -> Array:
    (x, y, z), radius = cup.start, cup.far_radius
    turn = np.linspace(0, 2 * math.pi, 64, endpoint=False)
    around = (x + radius * np.cos(turn), y + radius * np.sin(turn), np.full(64, z + cup.length))
    return np.column_stack(around)


class _Face(NamedTuple):
    """A convex polygon on a plane across `axis` (1: y, 2: z) that a cell offers to its neighbours."""

    cell: int
    axis: int
    outward: int  # +1 when the plane's positive side is outside
    corners: Points  # (n, 3) mm


_Link = tuple[int, int, Points]  # two cells and the face that they share
_Pieces = tuple[list[Points], list[_Link], list[_Face]]  # of a body: cells, links between them, outer faces


@dataclass(frozen=True)
class Cells:
    """Convex cells of a void with their passages; corners `(n, 3)` mm in the mold's frame."""

    void: Void
    corners: tuple[Points, ...]
    space: tuple[int, ...]  # of each cell
    pairs: Array  # (n, 2), cells that share a face
    passages: tuple[Points, ...]  # that face
    outlets: tuple[tuple[int, Points], ...]  # cell and its face to the open air


class TrappedAir(NamedTuple):
    """Air that stays: the cells that it touches, its level and its volume in mm3."""

    cells: tuple[int, ...]
    level: float  # mm along the vertical, of its lower surface
    volume: float
    highest: tuple[float, float, float]  # mm, its highest place
    height: float  # mm, from level to highest place


def vertical(tilt: float) -> Points:
    """Return the unit vector that points up in the mold's frame when end b (+y) is raised by `tilt` deg."""
    angle = math.radians(tilt)
    return np.array([0.0, math.sin(angle), math.cos(angle)])


def cells(space: Void, tolerance: float) -> Cells:
    """Return the void's convex cells, arcs as chords within `tolerance` mm.

    Spaces must be disjoint and touch on faces across y or z; prisms offer their caps and level sides, what
    turns its level faces.
    Raises RefusedError when a prism's section can't be cut into triangles.
    """
    corners, owner, links, faces = list[Points](), list[int](), list[_Link](), list[_Face]()
    outlets: list[tuple[int, Points]] = []
    for index, part in enumerate(space.spaces):
        first, body = len(corners), part.body
        if isinstance(body, TurnedBody):
            pieces, inner, outer = _turned(body, tolerance)
        elif isinstance(body, Prism):
            pieces, inner, outer = _prism(body, tolerance)
        elif isinstance(body, Bore):
            pieces, inner, outer = _bore(body, tolerance)
        else:
            raise RefusedError(f"{part.name}: how it fills is known of prisms, bores and round skins alone")
        corners += pieces
        owner += [index] * len(pieces)
        links += [(first + a, first + b, shared) for a, b, shared in inner]
        outer = [face._replace(cell=first + face.cell) for face in outer]
        faces += outer
        if part.open_at is not None:
            up = [f for f in outer if (f.axis, f.outward) == (2, 1)]
            outlets += [(f.cell, f.corners) for f in up if abs(f.corners[0, 2] - part.open_at) < TOUCH]
    links += _contacts(faces)
    pairs = np.array([link[:2] for link in links], dtype=int).reshape(-1, 2)
    passages = tuple(shared for *_, shared in links)
    return Cells(space, tuple(corners), tuple(owner), pairs, passages, tuple(outlets))


def escape(partition: Cells, up: Points) -> Array:
    """Return for each cell the level above which its air can't leave, mm along `up`; -inf: no way out."""
    one, other = partition.pairs.T
    passage = _tops(partition.passages, up)
    level, before = np.full(len(partition.corners), -np.inf), None
    for cell, corners in partition.outlets:
        level[cell] = max(level[cell], float((corners @ up).max()))
    while before is None or (level > before).any():
        before = level.copy()
        np.maximum.at(level, one, np.minimum(before[other], passage))
        np.maximum.at(level, other, np.minimum(before[one], passage))
    rim = partition.void.rim
    return level if rim is None else np.minimum(level, (rim @ up).min())


def trapped(partition: Cells, up: Points, ignored: frozenset[int] = frozenset()) -> list[TrappedAir]:
    """Return the air that stays when a liquid rises along `up`, the largest first; none of the spaces
    `ignored`. Statics only: no viscosity, no wetting, and air is not compressed."""
    level = escape(partition, up)
    airy = _tops(partition.corners, up) > level + LEVEL
    airy &= ~np.isin(partition.space, list(ignored))
    one, other = partition.pairs.T
    above = _tops(partition.passages, up) > np.maximum(level[one], level[other]) + LEVEL
    joined = airy[one] & airy[other] & above
    links = coo_array((joined[joined], (one[joined], other[joined])), shape=(len(level), len(level)))
    group = connected_components(links, directed=False)[1]
    members = [tuple(np.flatnonzero(airy & (group == i)).tolist()) for i in np.unique(group[airy])]
    pockets = [_trapped(partition, up, inside, float(level[inside[0]])) for inside in members]
    return sorted(pockets, key=lambda air: -air.volume)


def _trapped(partition: Cells, up: Points, members: tuple[int, ...], level: float) -> TrappedAir:
    points = np.vstack([partition.corners[i] for i in members])
    heights = points @ up
    highest = points[int(np.argmax(heights))]
    lowest = max(level, float(heights.min()))
    hulls = [Manifold.hull_points(partition.corners[i]) for i in members]
    if np.isfinite(level):
        hulls = [hull.trim_by_plane(tuple(up), level) for hull in hulls]
    volume = math.fsum(hull.volume() for hull in hulls)
    x, y, z = (float(v) for v in highest)
    return TrappedAir(members, level, volume, (x, y, z), float(heights.max()) - lowest)


def _tops(shapes: tuple[Points, ...], up: Points) -> Array:
    starts = np.cumsum([0, *(len(points) for points in shapes[:-1])])
    return np.maximum.reduceat(np.vstack(shapes) @ up, starts) if shapes else np.empty(0)


def _prism(prism: Prism, tolerance: float) -> _Pieces:
    """Cut a prism along its length into triangular ones, joined along the edges that they share."""
    loops = [curves.polygon(prism.outline, tolerance)]
    loops += [curves.polygon(hole, tolerance)[::-1] for hole in prism.holes]
    plane, third = np.vstack(loops), 1 if prism.axis == "y" else 2
    first = np.cumsum([0, *(len(points) for points in loops)])
    rim = {(i, a + (i - a + 1) % (b - a)) for a, b in pairwise(first) for i in range(a, b)}
    cells, links, faces = list[Points](), list[_Link](), list[_Face]()
    open_edges: dict[tuple[int, int], int] = {}
    low, high = (_lifted(plane, third, level) for level in (prism.low, prism.high))
    for cell, triangle in enumerate(np.asarray(triangulate(loops)).tolist()):
        ends = [low[triangle], high[triangle]]
        cells.append(np.vstack(ends))
        faces += [_Face(cell, third, sign, end) for sign, end in zip((-1, 1), ends, strict=True)]
        for edge in zip(triangle, (*triangle[1:], triangle[0]), strict=True):
            one, other = edge
            side = np.array([low[one], low[other], high[other], high[one]])
            if edge in rim:
                if third == 1 and abs(plane[edge[0], 1] - plane[edge[1], 1]) < TOUCH:
                    outward = 1 if plane[edge[0], 0] > plane[edge[1], 0] else -1  # material on the left
                    faces.append(_Face(cell, 2, outward, side))
            elif edge[::-1] in open_edges:
                links.append((open_edges.pop(edge[::-1]), cell, side))
            else:
                open_edges[edge] = cell
    if open_edges:
        raise RefusedError("a prism's triangles do not share all inner edges; report it with the design")
    return cells, links, faces


def _turned(body: TurnedBody, tolerance: float) -> _Pieces:
    """Cut what turns into wedges, a triangle of its loop from one angle to the next, each with plane faces:
    joined along the edges that triangles share, and round the turn. The highest of a level face lies at a
    quarter turn, so it is exact."""
    flat = curves.polygon(body.outline, tolerance)
    reach = float(flat[:, 0].max())
    count = 4 * math.ceil(turn_steps(2 * math.pi, reach, TURN_CHORD) / 4)
    angles = 2 * math.pi * np.arange(count) / count
    t, n = flat.T
    # exact at the quarters
    circle = np.column_stack([np.cos(angles), np.sin(angles)]).round(15).tolist()
    rings = [body.placed(np.column_stack([t * c, t * s, n])) for c, s in circle]
    triangles = np.asarray(triangulate([flat])).tolist()
    owner = {edge: i for i, corners in enumerate(triangles) for edge in _edges(corners)}
    cells, links, faces = list[Points](), list[_Link](), list[_Face]()
    for step, low in enumerate(rings):
        high = rings[(step + 1) % count]
        first, after = step * len(triangles), (step + 1) % count * len(triangles)
        for i, triangle in enumerate(triangles):
            cells.append(np.vstack([low[triangle], high[triangle]]))
            links.append((first + i, after + i, high[triangle]))
            for one, other in _edges(triangle):
                side = np.array([low[one], low[other], high[other], high[one]])
                neighbour = owner.get((other, one))
                if neighbour is None and abs(n[one] - n[other]) < TOUCH:
                    faces.append(_Face(first + i, 2, 1 if t[one] > t[other] else -1, side))
                elif neighbour is not None and neighbour > i:
                    links.append((first + i, first + neighbour, side))
    return cells, links, faces


def _edges(corners: list[int]) -> list[tuple[int, int]]:
    return list(pairwise([*corners, corners[0]]))


def _lifted(points: Points, third: int, level: float) -> Points:
    return np.insert(points, third, level, axis=1)


def _bore(bore: Bore, tolerance: float) -> _Pieces:
    """A bore is one convex cell; its corners lie at the quarters, so that its highest line is exact."""
    count = bore.circle(tolerance, multiple=4)
    turn = 2 * math.pi * np.arange(count) / count
    circle, third = np.column_stack([np.cos(turn), np.sin(turn)]), 1 if bore.axis == "y" else 2
    middle = np.delete(np.array(bore.start), third)
    base = bore.start[third]
    caps = [
        _lifted(middle + radius * circle, third, base + along)
        for radius, along in ((bore.radius, 0.0), (bore.far_radius, bore.length))
    ]
    faces = [_Face(0, third, sign, cap) for sign, cap in zip((-1, 1), caps, strict=True)]
    return [np.vstack(caps)], [], faces


def _contacts(faces: list[_Face]) -> Iterator[_Link]:
    """Pairs of cells whose faces meet, looking opposite ways on one plane, with what they share."""
    planes: dict[tuple[int, int], tuple[list[_Face], list[_Face]]] = defaultdict(lambda: ([], []))
    for face in faces:
        level = round(float(face.corners[0, face.axis]) / (1e3 * TOUCH))
        planes[face.axis, level][face.outward > 0].append(face)
    for (axis, _), (below, above) in planes.items():
        if not below or not above:
            continue
        lower, upper = (
            [shapely.Polygon(np.delete(face.corners, axis, axis=1)) for face in side]
            for side in (below, above)
        )
        for i, j in shapely.STRtree(upper).query(lower, predicate="intersects").T:
            shared = lower[i].intersection(upper[j])
            if shared.area > TOUCH:
                corners = np.asarray(shared.exterior.coords)[:-1]
                yield below[i].cell, above[j].cell, _lifted(corners, axis, below[i].corners[0, axis])


@dataclass(frozen=True)
class AirPocket:
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


_Filling = tuple[Cells, list[_Surface], bool]  # what fills, what bounds the skin, whether the mold is tilted


def pockets(job: Job, tilt: float | None = None) -> tuple[AirPocket, ...]:
    """Return the air pockets of at least `LEAST_POCKET` mm3, the largest first.

    End b is up by `tilt` deg, by the design's own tilt if not given.
    """
    return tuple(_pockets(_fillings(job), job.design.mold.pour_tilt if tilt is None else tilt))


def best_tilt(job: Job) -> tuple[float, float]:
    """Return the tilt in deg (within `TILTS`) at which least air stays, to 0.5 deg, and how much, mm3.

    Every 5 deg first, then finer about the best; of equal ones the nearest to the design's own.
    """
    fillings = _fillings(job)

    def rank(tilt: float) -> tuple[float, float]:
        air = math.fsum(pocket.volume for pocket in _pockets(fillings, tilt))
        return round(air, 3), abs(tilt - job.design.mold.pour_tilt)

    low, high = TILTS
    best = min((low, *(float(tilt) for tilt in range(5, int(high) + 1, 5))), key=rank)
    for step in (1.0, 0.5):
        near = [best + step * i for i in range(-4, 5)]
        best = min((tilt for tilt in near if low <= tilt <= high), key=rank)
    return best, rank(best)[0]


def filling_findings(job: Job) -> list[Finding]:
    """Return the rule `trapped air`: a warning where it harms the skin, a note where it doesn't.

    At a ridge or slot the limit is `LEAST_POCKET`. In the skin's body it is a bubble with a diameter of
    `BUBBLE_SHARE` of the thickness. Pockets of one kind make one finding.
    """
    if job.bent:
        return _bent_findings(job)
    air = pockets(job)
    if not air:
        return _level(job.design)
    tilt, least = best_tilt(job)
    if least > 0.9 * math.fsum(pocket.volume for pocket in air):
        remedy = f"no tilt traps less: {PRESSURE_REMEDY}"
    else:
        rest = f"which traps {least:.2g} mm3: {PRESSURE_REMEDY}" if least else "which traps none"
        remedy = f"mold.pour_tilt = {tilt:g}, {rest}"
    return [*_level(job.design), *_grouped_findings(job.design, air, remedy)]


def _bent_findings(job: Job) -> list[Finding]:
    """Both ends of a doubly curved skin rise, by the angle that they lean. What stays at an end is judged on
    the straight mold of the section at that end's slope: a pocket is short against the radius. It has
    one layer and no bone: what ridges trap is in front, and a plug leads air along as the carrier does."""
    bare = dict.fromkeys(("bone", "bone_at", "bone_turn", "bone_bond"))
    straight = Job(job.design.with_(skin={"curvature_radius_y": None}, shot=None, mold=bare))
    rise, tilt = math.degrees(end_angle(job.design)), job.design.mold.pour_tilt
    remedy, findings = PRESSURE_REMEDY, []
    if tilt <= rise:
        where = "end a, which stays high unless mold.pour_tilt exceeds the angle by which it leans"
        leave = f"mold.pour_tilt above {rise:.3g}; or fill slowly: its air escapes round the carrier"
        findings.append(note("trapped air", where, tilt, rise, "deg", leave))
    for end, slope in (("b", rise + tilt), ("a", rise - tilt)):
        if slope <= 0:
            continue
        for finding in _grouped_findings(job.design, pockets(straight, slope), remedy):
            place = finding.where.replace("end b", f"end {end}")
            findings.append(replace(finding, where=f"{place}, in a straight mold at the slope of end {end}"))
    return findings


def _level(design: Design) -> list[Finding]:
    """A note where the carrier lies so level that statics says nothing about bubbles under it."""
    tilt, least = design.mold.pour_tilt, TILTS[0]
    if tilt >= least:
        return []
    where, remedy = "carrier, too level to lead a bubble along", f"mold.pour_tilt of {least:g} or more"
    return [note("trapped air", where, tilt, least, "deg", remedy)]


def _grouped_findings(design: Design, air: Iterable[AirPocket], remedy: str) -> list[Finding]:
    kinds: dict[tuple[str, str], list[AirPocket]] = defaultdict(list)
    for pocket in air:
        kinds[pocket.harm, pocket.alike].append(pocket)
    return [_finding(design, group, remedy) for group in kinds.values()]


def _finding(design: Design, group: list[AirPocket], remedy: str) -> Finding:
    largest, volume = group[0], math.fsum(pocket.volume for pocket in group)
    body = math.pi / 6 * (BUBBLE_SHARE * design.skin.thickness) ** 3
    limit = LEAST_POCKET if largest.harm == "relief" else body
    harms = largest.harm != "riser" and largest.volume > limit
    x, y, z = (round(length, 2) + 0.0 for length in largest.place)  # no minus before a zero
    more = f" and {len(group) - 1} more like it" if len(group) > 1 else ""
    where = f"{largest.where} at ({x:g}, {y:g}, {z:g}), {largest.height:.2g} mm high{more}"
    return (warning if harms else note)("trapped air", where, volume, limit, "mm3", remedy)


def _fillings(job: Job) -> list[_Filling]:
    """The closed mold's filling, and for an open pour the open trough's: level, or it would run over."""
    closed = job.single.closed
    spaces = [(void(job), True)]
    if job.gate is None:
        spaces.append((open_trough(closed), False))
    surfaces = _surfaces(closed, job.skin.family)
    return [(cells(space, CHORD), surfaces, tilted) for space, tilted in spaces]


def _surfaces(closed: ClosedMold, family: str) -> list[_Surface]:
    """The surfaces that bound the skin in its section, by name. The skin is a prism, so x and z identify the
    surface of a point, or turns, so z and the distance from the axis do. Where several meet, the first
    counts: shim or strip, feature, carrier, the rest."""
    body = closed.first(PartRole.SKIN).body
    if not isinstance(body, Prism | TurnedBody):
        return []
    surfaces = []
    for part in closed.of(PartRole.SHIM, PartRole.STRIP):
        if isinstance(part.body, Prism):
            edge = shapely.LinearRing(polygon(part.body.outline, CHORD))
            surfaces.append(
                _Surface(part.name, f"{part.role.label} of ridge {part.body.outline[0].feature}", True, edge)
            )
    holes = body.holes if isinstance(body, Prism) else ()
    segments = [*body.outline, *(s for hole in holes for s in hole)]
    for segment in sorted(segments, key=lambda s: (s.feature is None, s.kind != "back")):
        along = segment.points(np.linspace(0, 1, segment.pieces(CHORD) + 1))
        name = {"back": "carrier", "side": "side of the cavity", "base": "valley"}.get(segment.kind)
        name = name or f"{segment.kind.replace('_', ' ')} of {family} {segment.feature}"
        surfaces.append(_Surface(name, segment.kind, segment.feature is not None, shapely.LineString(along)))
    return surfaces


def _pockets(fillings: list[_Filling], tilt: float) -> list[AirPocket]:
    pockets = []
    for partition, surfaces, tilted in fillings:
        spaces, up = partition.void.spaces, vertical(tilt if tilted else 0.0)
        ignored = frozenset(i for i, part in enumerate(spaces) if part.beside is PartRole.COVER)
        pockets += [_pocket(partition, surfaces, up, air) for air in trapped(partition, up, ignored)]
    return sorted((p for p in pockets if p.volume >= LEAST_POCKET), key=lambda p: (-p.volume, p.place))


def _pocket(partition: Cells, surfaces: list[_Surface], up: Points, air: TrappedAir) -> AirPocket:
    """Name what the air lies under: all that it touches has a corner of a cell above the air's level."""
    spaces = partition.void.spaces
    skin = [c for c in air.cells if spaces[partition.space[c]].beside is PartRole.SKIN]
    if not skin:
        first = min(air.cells, key=lambda c: -float((partition.corners[c] @ up).max()))
        space = spaces[partition.space[first]]
        return AirPocket(space.where, space.name, air.highest, air.volume, air.height, "riser")
    corners = np.unique(np.vstack([partition.corners[c] for c in skin]), axis=0)
    heights = corners @ up
    touched = [(p, h) for p, h in zip(corners, heights, strict=True) if h > air.level]
    turns = any(isinstance(space.body, TurnedBody) for space in spaces)
    points = shapely.points([(math.hypot(p[0], p[1]) if turns else p[0], p[2]) for p, _ in touched])
    names = [[s for s in surfaces if s.edge.distance(point) < SURFACE_TOLERANCE] for point in points]
    top = int(np.argmax([h for _, h in touched]))
    place = touched[top][0]
    where, alike = (names[top][0].name, names[top][0].alike) if names[top] else ("skin", "skin")
    ends = {-1: ", at end a's edge", 1: ", at end b's edge"}
    edge = ends.get(int(np.sign(place[1])), "") if abs(up[1]) > 0 else ""
    relief = any(s.relief for meeting in names for s in meeting)
    x, y, z = (float(v) for v in place)
    harm: Literal["relief", "body"] = "relief" if relief else "body"
    return AirPocket(where + edge, where + edge if edge else alike, (x, y, z), air.volume, air.height, harm)
