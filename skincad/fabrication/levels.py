"""To which level air escapes from every place of a void while a liquid rises in it: a merge tree.

The void is cut into convex cells. In a convex cell a straight way leads from any point to any other and
never below the lower of them, so a cell needs one number: the level of the best way out of it. That way's
lowest passage is as high as can be (a widest path; Pollack 1960), and passages are the faces that cells
share, each as high as its highest corner. Exact but for arcs as chords.
"""

from __future__ import annotations

import heapq
import math
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import shapely
from manifold3d import Manifold, triangulate

from skincad.base.arrays import Array
from skincad.base.errors import RefusedError
from skincad.fabrication.void import Void
from skincad.shape import curves
from skincad.solids.plan import Bore, Prism

Points = Array
TOUCH = 1e-9  # mm and mm2; faces within it are on one plane, and less of a common area is none
LEVEL = 1e-9  # mm; air less than this above its way out is rounding


class _Face(NamedTuple):
    """A convex polygon on a plane across `axis` (1: y, 2: z) that a cell offers to its neighbours."""

    cell: int
    axis: int
    outward: int  # +1 when the plane's positive side is outside
    corners: Points  # (n, 3) mm


@dataclass(frozen=True)
class Cells:
    """Convex cells of a void with their passages; corners `(n, 3)` mm in the mold's frame."""

    corners: tuple[Points, ...]
    space: tuple[int, ...]  # of each cell
    pairs: tuple[tuple[int, int], ...]  # cells that share a face
    passages: tuple[Points, ...]  # that face
    outlets: tuple[tuple[int, Points], ...]  # cell and its face to the open air
    rim: Points | None


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

    Spaces must be disjoint and touch on faces across y or z; prisms offer their caps and level sides.
    Raises RefusedError when a prism's section can't be cut into triangles.
    """
    corners: list[Points] = []
    owner: list[int] = []
    links: list[tuple[int, int]] = []
    passages: list[Points] = []
    faces: list[_Face] = []
    outlets: list[tuple[int, Points]] = []
    for index, part in enumerate(space.spaces):
        first = len(corners)
        if not isinstance(part.body, Prism | Bore):
            raise RefusedError(f"{part.name}: how it fills is known of prisms and bores alone")
        pieces = _prism(part.body, tolerance) if isinstance(part.body, Prism) else _bore(part.body, tolerance)
        corners += pieces.corners
        owner += [index] * len(pieces.corners)
        links += [(first + a, first + b) for a, b in pieces.pairs]
        passages += pieces.passages
        part_faces = [face._replace(cell=first + face.cell) for face in pieces.faces]
        faces += part_faces
        if part.open_at is not None:
            up = [f for f in part_faces if (f.axis, f.outward) == (2, 1)]
            outlets += [(f.cell, f.corners) for f in up if abs(f.corners[0, 2] - part.open_at) < TOUCH]
    for a, b, shared in _contacts(faces):
        links.append((a, b))
        passages.append(shared)
    return Cells(tuple(corners), tuple(owner), tuple(links), tuple(passages), tuple(outlets), space.rim)


def escape(partition: Cells, up: Points) -> Array:
    """Return for each cell the level above which its air can't leave, mm along `up`; -inf: no way out."""
    around: dict[int, list[tuple[int, float]]] = defaultdict(list)
    for (a, b), height in zip(partition.pairs, _tops(partition.passages, up), strict=True):
        around[a].append((b, height))
        around[b].append((a, height))
    level = np.full(len(partition.corners), -np.inf)
    queue = [(-float((corners @ up).max()), cell) for cell, corners in partition.outlets]
    heapq.heapify(queue)
    while queue:
        height, cell = heapq.heappop(queue)
        if -height <= level[cell]:
            continue
        level[cell] = -height
        for other, passage in around[cell]:
            reached = min(-height, passage)
            if reached > level[other]:
                heapq.heappush(queue, (-reached, other))
    return level if partition.rim is None else np.minimum(level, (partition.rim @ up).min())


def trapped(partition: Cells, up: Points, ignored: frozenset[int] = frozenset()) -> list[TrappedAir]:
    """Return the air that stays when a liquid rises along `up`, the largest first; none of the spaces
    `ignored`. Statics only: no viscosity, no wetting, and air is not compressed."""
    level = escape(partition, up)
    tops = np.array(_tops(partition.corners, up))
    airy = [i for i in np.flatnonzero(tops > level + LEVEL) if partition.space[i] not in ignored]
    group = {int(i): int(i) for i in airy}

    def root(i: int) -> int:
        while group[i] != i:
            group[i] = group[group[i]]
            i = group[i]
        return i

    for (a, b), height in zip(partition.pairs, _tops(partition.passages, up), strict=True):
        if a in group and b in group and height > max(level[a], level[b]) + LEVEL:
            group[root(a)] = root(b)
    members: dict[int, list[int]] = defaultdict(list)
    for cell in group:
        members[root(cell)].append(cell)
    pockets = [
        _trapped(partition, up, tuple(group_cells), float(level[group_cells[0]]))
        for group_cells in members.values()
    ]
    return sorted(pockets, key=lambda air: -air.volume)


def _trapped(partition: Cells, up: Points, members: tuple[int, ...], level: float) -> TrappedAir:
    points = np.vstack([partition.corners[i] for i in members])
    heights = points @ up
    highest = points[int(np.argmax(heights))]
    lowest = max(level, float(heights.min()))
    volume = math.fsum(_above(partition.corners[i], up, level) for i in members)
    x, y, z = (float(v) for v in highest)
    return TrappedAir(members, level, volume, (x, y, z), float(heights.max()) - lowest)


def _above(corners: Points, up: Points, level: float) -> float:
    """Volume of a convex cell above a level, mm3."""
    whole = Manifold.hull_points(corners)
    return float((whole.trim_by_plane(tuple(up), level) if np.isfinite(level) else whole).volume())


def _tops(shapes: tuple[Points, ...], up: Points) -> list[float]:
    if not shapes:
        return []
    starts = np.cumsum([0, *(len(points) for points in shapes[:-1])])
    tops: list[float] = np.maximum.reduceat(np.vstack(shapes) @ up, starts).tolist()
    return tops


class _CellMesh(NamedTuple):
    corners: list[Points]
    pairs: list[tuple[int, int]]
    passages: list[Points]
    faces: list[_Face]


def _prism(prism: Prism, tolerance: float) -> _CellMesh:
    """Cut a prism along its length into triangular ones, joined along the edges that they share."""
    loops = [curves.polygon(prism.outline, tolerance)]
    loops += [curves.polygon(hole, tolerance)[::-1] for hole in prism.holes]
    plane, third = np.vstack(loops), 1 if prism.axis == "y" else 2
    first = np.cumsum([0, *(len(points) for points in loops)])
    rim = {(i, a + (i - a + 1) % (b - a)) for a, b in pairwise(first) for i in range(a, b)}
    pieces = _CellMesh([], [], [], [])
    open_edges: dict[tuple[int, int], int] = {}
    low, high = (_lifted(plane, third, level) for level in (prism.low, prism.high))
    for cell, triangle in enumerate(np.asarray(triangulate(loops)).tolist()):
        ends = [low[triangle], high[triangle]]
        pieces.corners.append(np.vstack(ends))
        pieces.faces.extend([_Face(cell, third, sign, end) for sign, end in zip((-1, 1), ends, strict=True)])
        for edge in zip(triangle, (*triangle[1:], triangle[0]), strict=True):
            one, other = edge
            side = np.array([low[one], low[other], high[other], high[one]])
            if edge in rim:
                if third == 1 and abs(plane[edge[0], 1] - plane[edge[1], 1]) < TOUCH:
                    outward = 1 if plane[edge[0], 0] > plane[edge[1], 0] else -1  # material on the left
                    pieces.faces.append(_Face(cell, 2, outward, side))
            elif edge[::-1] in open_edges:
                pieces.pairs.append((open_edges.pop(edge[::-1]), cell))
                pieces.passages.append(side)
            else:
                open_edges[edge] = cell
    if open_edges:
        raise RefusedError("a prism's triangles do not share all inner edges; report it with the design")
    return pieces


def _lifted(points: Points, third: int, level: float) -> Points:
    return np.insert(points, third, level, axis=1)


def _bore(bore: Bore, tolerance: float) -> _CellMesh:
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
    return _CellMesh([np.vstack(caps)], [], [], faces)


def _contacts(faces: list[_Face]) -> Iterator[tuple[int, int, Points]]:
    """Pairs of cells whose faces meet, looking opposite ways on one plane, with what they share."""
    planes: dict[tuple[int, int], tuple[list[_Face], list[_Face]]] = defaultdict(lambda: ([], []))
    for face in faces:
        level = round(float(face.corners[0, face.axis]) / (1e3 * TOUCH))
        planes[face.axis, level][face.outward > 0].append(face)
    for (axis, _), (below, above) in planes.items():
        if not below or not above:
            continue
        lower, upper = ([_flat(face) for face in side] for side in (below, above))
        for i, j in shapely.STRtree(upper).query(lower, predicate="intersects").T:
            shared = lower[i].intersection(upper[j])
            if shared.area > TOUCH:
                corners = np.asarray(shared.exterior.coords)[:-1]
                yield below[i].cell, above[j].cell, _lifted(corners, axis, below[i].corners[0, axis])


def _flat(face: _Face) -> shapely.Polygon:
    return shapely.Polygon(np.delete(face.corners, face.axis, axis=1))
