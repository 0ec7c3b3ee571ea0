"""Measured properties of print meshes: deviation, self-intersections, and interference of parts."""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import pymeshlab
import shapely
import trimesh
from manifold3d import Manifold

from skincad.base.arrays import Array, Mask
from skincad.base.interrupt import safe_point
from skincad.fabrication.fasteners import PINNED
from skincad.fabrication.meshes import FINER, manifold
from skincad.fabrication.meshes import mesh as mesh_of
from skincad.fabrication.rules import Finding, error
from skincad.shape.curves import polygon
from skincad.solids.bone import BENT_SLACK
from skincad.solids.mold import ClosedMold
from skincad.solids.plan import (
    PINS,
    Body,
    Bore,
    CutRole,
    ExtendedCut,
    GivenBody,
    Part,
    PartRole,
    Prism,
    RevolvedBody,
    RotatedBody,
    TurnedBody,
    bores,
    plain,
)
from skincad.solids.skin import Way, swept

SAMPLES = 10_000  # points on each mesh, besides all corners and edges; seeded by the library
CROSSING_TOLERANCE = 1e-9  # mm, by which faces may cross: corners of 0.1 m are rounded to some 1e-14 mm
SAME = 1e-6  # mm, of outlines: a thousandth of what a print mesh may be off
LEAST_COMMON_VOLUME = 1e-9  # mm3; a common volume below this is rounding of touching faces


@dataclass(frozen=True)
class MeshMeasure:
    """A print mesh as measured: mm, mm2, mm3."""

    watertight: bool
    self_intersections: int
    volume: float
    deviation: float  # largest distance to the true surface, both ways; never below the truth


def measure(part: Part, mesh: trimesh.Trimesh, tolerance: float) -> MeshMeasure:
    """Measure a part's print mesh against one `FINER` times finer; that one's own error is added. Pins that
    are alike but for their place have meshes that are, so the distance is measured at one of them."""
    frames = [_with_flat_ends(part.body, mesh)]
    if isinstance(part.body, Prism) and part.body.grid:
        frames.append(mesh)  # the library takes other coplanar faces for crossings in each; real ones in both
    alike = _one_of_each(part)
    coarse = mesh if alike is part else mesh_of(alike, tolerance)
    meshes = _mesh_set(coarse, mesh_of(alike, tolerance / FINER))
    ways = [
        meshes.get_hausdorff_distance(
            sampledmesh=a, targetmesh=b, samplenum=SAMPLES, samplevert=True, sampleedge=True
        )["max"]
        for a, b in ((0, 1), (1, 0))
    ]
    return MeshMeasure(
        watertight=bool(mesh.is_watertight and mesh.is_winding_consistent),
        self_intersections=_crossings(mesh, np.logical_and.reduce([_crossing(m) for m in frames])),
        volume=float(mesh.volume),
        deviation=max(ways) + tolerance / FINER,
    )


def _one_of_each(part: Part) -> Part:
    """A part with one of its turned bodies of each outline, to `SAME` mm."""
    bodies = [body for body in (*part.adds, *part.cuts) if isinstance(body, TurnedBody)]
    first = {*{tuple(round(v / SAME) for s in b.outline for v in s.start): b for b in bodies}.values()}
    if len(first) == len(bodies):
        return part
    cuts = tuple(cut for cut in part.cuts if not isinstance(cut, TurnedBody) or cut in first)
    return replace(part, adds=tuple(body for body in part.adds if body in first), cuts=cuts)


def _crossing(mesh: trimesh.Trimesh) -> Mask:
    """Which faces cross others, `(n,)`, and some that only touch, by rounding, on a slanting plane."""
    meshes = _mesh_set(mesh)
    meshes.compute_selection_by_self_intersections_per_face()
    return np.asarray(meshes.current_mesh().face_selection_array(), dtype=bool)


def _crossings(mesh: trimesh.Trimesh, suspects: Mask) -> int:
    """Return how many of the faces `(n,)` cross another one by more than `CROSSING_TOLERANCE`.

    The library also reports faces that lie in one plane but for rounding.
    """
    corners = np.asarray(mesh.triangles)
    low, high, count = corners.min(axis=1), corners.max(axis=1), 0
    for face in np.flatnonzero(suspects):
        near = np.all((low <= high[face]) & (high >= low[face]), axis=1)
        near[face] = False
        count += any(_cross(corners[face], other) for other in corners[near])
    return count


def _cross(triangle_a: Array, triangle_b: Array) -> bool:
    """Whether two triangles `(3, 3)` mm cut each other by more than `CROSSING_TOLERANCE`.

    The planes' common line then runs in both over more than that. Source: Moeller, A fast triangle-triangle
    intersection test, 1997.
    """
    normals = [np.cross(t[1] - t[0], t[2] - t[0]) for t in (triangle_a, triangle_b)]
    line = np.cross(normals[0], normals[1])
    if not line.any():
        return False
    spans = []
    for triangle, plane, normal in (
        (triangle_a, triangle_b, normals[1]),
        (triangle_b, triangle_a, normals[0]),
    ):
        distances = (triangle - plane[0]) @ normal / max(float(np.linalg.norm(normal)), sys.float_info.min)
        if distances.min() >= -CROSSING_TOLERANCE or distances.max() <= CROSSING_TOLERANCE:
            return False
        along = triangle @ line / np.linalg.norm(line)
        ends = [
            along[i] + (along[j] - along[i]) * distances[i] / (distances[i] - distances[j])
            for i, j in ((0, 1), (1, 2), (2, 0))
            if distances[i] * distances[j] < 0 or (distances[i] == 0) != (distances[j] == 0)
        ]
        spans.append((min(ends), max(ends)))
    return bool(min(spans[0][1], spans[1][1]) - max(spans[0][0], spans[1][0]) > CROSSING_TOLERANCE)


def _with_flat_ends(body: Body, mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """Return the mesh of a body whose ends slant with ends that don't, any other as it is: the library takes
    the rounding of a slanting end's triangles for crossings. Faces cross after if and only if before.

    A turned body is turned back. A prism along x with a grid has ends in planes through the grid's axis: the
    projective map (x, y, -c) / (c - z), c the axis's height, takes them to parallel planes, any plane to a
    plane. In a revolved body, between two angle steps, straightening takes section to section, so plane
    trapezoids to rectangles, one to one.
    """
    points = np.asarray(mesh.vertices)
    if isinstance(body, RotatedBody):
        points = body.returned(points).round(12)
    elif isinstance(body, Prism) and body.grid:
        (x, y, z), centre = points.T, body.grid.centre
        points = np.column_stack([x, y, np.full(len(x), -centre)]) * (centre / (centre - z))[:, None]
        points[:, 1] = points[:, 1].round(9)
    elif isinstance(body, RevolvedBody):
        points = body.straightened(points)
        points[:, 1] = points[:, 1].round(9)  # mm; an end's corners are level again
    else:
        return mesh
    return trimesh.Trimesh(points, mesh.faces, process=False, validate=False)


def _mesh_set(*shapes: trimesh.Trimesh) -> pymeshlab.MeshSet:
    meshes = pymeshlab.MeshSet(verbose=False)
    for mesh in shapes:
        corners, faces = np.asarray(mesh.vertices, dtype=float), np.asarray(mesh.faces, dtype=np.int32)
        meshes.add_mesh(pymeshlab.Mesh(corners, faces))
    return meshes


def interference(assembled: ClosedMold, tolerance: float) -> list[Finding]:
    """Return every pair of parts that share volume, closed or on the way of an opening step.

    A pin fills the hole that it is pressed into, which is smaller by design. All meshes take their corners
    from the same exact section, so touching faces share none. `tolerance` (mm) must be well below the
    clearances.
    """
    shapes = {part.name: _Shape(part, tolerance) for part in assembled.parts}
    names = list(shapes)
    findings = [
        _finding(f"{a} in {b}, closed", volume)
        for i, a in enumerate(names)
        for b, volume in _shared(shapes[a], [shapes[name] for name in names[i + 1 :]])
    ]
    for step in assembled.opening:
        moving = [shapes.pop(name) for name in step.parts]
        for shape in moving:
            safe_point()
            name, way = shape.part.name, swept(shape.part, step.axis, step.travel, tolerance)
            # the skin bends, and the strips in it: the undercut rule judges it
            free = PartRole.CAVITY if shape.part.role in (PartRole.SKIN, PartRole.STRIP) else None
            path = _Shape(way, tolerance)
            others = [other for other in shapes.values() if other.part.role is not free]
            for other, volume in _shared(path, others):
                where = f"{name} against {other}, opening along {_way(step.axis)}"
                findings.append(_finding(where, volume))
    return findings


@dataclass(frozen=True)
class _Shape:
    """A part, the tolerance of its chords in mm, and its mesh, made when it is needed."""

    part: Part
    tolerance: float

    @cached_property
    def mesh(self) -> Manifold:
        """Its mesh, mm."""
        return manifold(self.part, self.tolerance)

    @cached_property
    def filled(self) -> _Shape:
        """The shape with its pins' holes filled, which has all volume of it."""
        cuts = tuple(cut for cut in self.part.cuts if cut.role is not CutRole.FEATURE)
        whole = len(cuts) == len(self.part.cuts)
        return self if whole else _Shape(replace(self.part, cuts=cuts), self.tolerance)

    @cached_property
    def bare(self) -> _Shape:
        """The shape without what is added to it."""
        return _Shape(replace(self.part, adds=()), self.tolerance) if self.part.adds else self

    @cached_property
    def box(self) -> _Box:
        """Lowest and highest coordinates, `(3,)` mm, in which it lies."""
        low, high = _box_of(self.part.adds)
        box = np.array(self.bare.filled.mesh.bounding_box())
        return np.minimum(low, box[:3]), np.maximum(high, box[3:])


_Box = tuple[Array, Array]


def _box_of(bodies: tuple[TurnedBody | RevolvedBody, ...]) -> _Box:
    """A box round turned bodies, `(3,)` mm each; of none it holds nothing, of any about x everything."""
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for body in bodies:
        if isinstance(body, RevolvedBody):
            return np.full(3, -np.inf), np.full(3, np.inf)
        wide = max(s.start.x for s in body.outline) + max(abs(s.bulge) * s.chord for s in body.outline)
        for s in body.outline:
            middle = np.array(body.origin) + s.start.z * np.array(body.direction)
            low, high = np.minimum(low, middle - wide), np.maximum(high, middle + wide)
    return low, high


def _apart(a: _Box, b: _Box) -> bool:
    return bool(np.any(a[0] >= b[1]) or np.any(b[0] >= a[1]))


def _shared(shape: _Shape, others: list[_Shape]) -> list[tuple[str, float]]:
    """Which others share volume with a part, and how much, mm3."""
    volumes = [(other.part.name, _common(shape, other)) for other in others]
    return [(name, volume) for name, volume in volumes if volume > LEAST_COMMON_VOLUME]


def _way(axis: Way) -> str:
    return axis if isinstance(axis, str) else f"x {axis[0]:.3g}, z {axis[1]:.3g}"


def _common(a: _Shape, b: _Shape) -> float:
    if _apart(a.box, b.box):
        return 0.0
    a, b = _without_pins(a, b), _without_pins(b, a)
    a, b = _near(a, b), _near(b, a)
    one, other = a.part, b.part
    if (
        isinstance(one.body, RevolvedBody)
        and isinstance(other.body, RevolvedBody)
        and not (one.cuts or other.cuts)
    ):
        return _turned_alike(one.body, other.body, a.tolerance / 2)
    if any(_lies_in(p, q, a.tolerance / 2) for p, q in ((one, other), (other, one))):
        return 0.0
    if (a.filled, b.filled) != (a, b) and _common(a.filled, b.filled) <= LEAST_COMMON_VOLUME:
        return 0.0
    return float((_pressed(a, b).mesh ^ _pressed(b, a).mesh).volume())


def _near(shape: _Shape, other: _Shape) -> _Shape:
    """A shape with what of its pins may meet another one."""
    adds = tuple(body for body in shape.part.adds if not _apart(_box_of((body,)), other.box))
    return shape if adds == shape.part.adds else _Shape(replace(shape.part, adds=adds), shape.tolerance)


def _without_pins(shape: _Shape, other: _Shape) -> _Shape:
    """A shape without what is added to it where the other one has the very same bodies as cuts, or without
    these cuts: what of it lies there shares nothing, and meshes that touch everywhere take minutes."""
    adds, cuts = frozenset(shape.part.adds), _turned_cuts(other.part)
    if adds and adds <= cuts.keys():
        return shape.bare
    if other.part.adds and (own := _turned_cuts(shape.part)).keys() >= frozenset(other.part.adds):
        filled = {own[body] for body in other.part.adds if isinstance(body, TurnedBody)}
        part = replace(shape.part, cuts=tuple(cut for cut in shape.part.cuts if cut not in filled))
    else:
        return shape
    return _Shape(part, shape.tolerance)


def _turned_cuts(part: Part) -> dict[TurnedBody, TurnedBody]:
    """The turned cuts of a part, by what they are without their role."""
    return {cut.piece_of or replace(cut, role=None): cut for cut in part.cuts if isinstance(cut, TurnedBody)}


def _pressed(shape: _Shape, other: _Shape) -> _Shape:
    """A pin as it is in a part that it is pressed into, whose hole is smaller; a bone lower under a
    bent carrier, on whose arc it lies within its own chords; any other shape as it is."""
    given, roof = shape.part.body, other.part.body
    if isinstance(given, GivenBody) and isinstance(roof, Prism) and roof.grid:
        low = given.pose[11] - max(2 * shape.tolerance, BENT_SLACK)
        lower = replace(given, pose=(*given.pose[:11], low))
        return _Shape(replace(shape.part, body=lower), shape.tolerance)
    roles = PINNED if shape.part.role in PINS else (CutRole.CORE,)
    body, pin = shape.part.body, plain(shape.part.body)
    if shape.part.role not in (*PINS, PartRole.CORE_PIN) or not isinstance(pin, Bore):
        return shape
    least = min((bore.radius for bore in bores(other.part, *roles)), default=pin.radius)
    if least >= pin.radius:
        return shape
    slim = replace(pin, radius=least)
    turned = replace(body, body=slim) if isinstance(body, RotatedBody) else slim
    return _Shape(replace(shape.part, body=turned), shape.tolerance)


def _turned_alike(a: RevolvedBody, b: RevolvedBody, tolerance: float) -> float:
    """What two bodies that turn about one axis share, mm3: what their sections share, times its path. Meshes
    that touch all along a slot share up to 1e-6 mm3 by rounding."""
    angle = min(a.high, b.high) - max(a.low, b.low)
    common = _region(a, tolerance).intersection(_region(b, tolerance))
    if angle <= 0 or common.is_empty:
        return 0.0
    return float(common.area * abs(common.centroid.y - a.centre) * angle)


def _lies_in(inner: Part, outer: Part, tolerance: float) -> bool:
    """Whether a turned part lies all in one turned cut of another one, as a skin in its trough: meshes that
    touch everywhere take the boolean a hundred times longer."""
    body, cuts = inner.body, [cut.built if isinstance(cut, ExtendedCut) else cut for cut in outer.cuts]
    if not isinstance(body, RevolvedBody | TurnedBody) or inner.adds:
        return False
    return any(
        _turn(cut, body)
        and _region(body, tolerance).difference(_region(cut, tolerance)).area * body.volume
        <= LEAST_COMMON_VOLUME
        for cut in cuts
        if isinstance(cut, RevolvedBody | TurnedBody)
    )


def _turn(outer: RevolvedBody | TurnedBody, inner: RevolvedBody | TurnedBody) -> bool:
    """Whether one body turns about the axis of another one, as far at least."""
    if isinstance(outer, TurnedBody) or isinstance(inner, TurnedBody):
        axes = [(b.origin, b.direction) if isinstance(b, TurnedBody) else None for b in (outer, inner)]
        return axes[0] == axes[1]
    return outer.low <= inner.low and inner.high <= outer.high


def _region(body: RevolvedBody | TurnedBody, tolerance: float) -> shapely.Polygon:
    holes = body.holes if isinstance(body, RevolvedBody) else ()
    return shapely.Polygon(polygon(body.outline, tolerance), [polygon(h, tolerance) for h in holes])


def _finding(where: str, volume: float) -> Finding:
    remedy = "enlarge mold.clearance or change the parts"
    return error("interference", where, volume, LEAST_COMMON_VOLUME, "mm3", remedy)
