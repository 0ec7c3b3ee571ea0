"""Print meshes of the parts, and the plates that they are laid on."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import trimesh
from manifold3d import Manifold, Mesh64, OpType, triangulate
from numpy.typing import NDArray

from skincad.base.arrays import Array
from skincad.base.errors import InputError, resource_guard
from skincad.base.interrupt import safe_point
from skincad.inputs.design import Design
from skincad.inputs.process import Process, processes
from skincad.shape import curves
from skincad.solids.plan import (
    Body,
    Bore,
    ExtendedCut,
    GivenBody,
    Part,
    PartRole,
    Prism,
    RevolvedBody,
    RotatedBody,
    TurnedBody,
    corners,
    turn_steps,
    unturned,
)

FINER = 10.0  # the mesh that a print mesh is measured against has chords this many times finer
_Y_IS_THIRD = np.array([0, 2, 1])  # order of (u, v, along) for a prism along y
_X_IS_THIRD = np.array([2, 0, 1])
SLIVER = 5e-6  # mm, what single precision keeps of 60 mm: a lower triangle has no area in an STL
BOTH = 0.7  # of a chord's tolerance, where two meet
PART_GAP = 5.0  # mm, assumption: between parts on a plate


def asked_chord(design: Design) -> float:
    """Return how far print meshes of a design's mold may leave the true surface, mm: the finest process's."""
    known, choice = processes(design.printer), design.mold
    makers = {choice.process, choice.end_plate_process, choice.block_process, choice.lid_process}
    return min(known[name].chord for name in makers if name)


def print_chord(design: Design) -> float:
    """Return the chord tolerance of the print meshes, mm: the reference mesh's own error is added to it, and
    where a pocket meets an arc along y both chords add up."""
    meet = design.features.pocket is not None and math.isfinite(design.skin.radius_y)
    return (BOTH if meet else 1.0) * asked_chord(design) / (1 + 1 / FINER)


def manifold(part: Part, tolerance: float) -> Manifold:
    """Return the part as a manifold whose chords keep within `tolerance` mm of the true surfaces."""
    if isinstance(part.body, RotatedBody):
        return _placed(manifold(unturned(part), tolerance), part.body)
    cuts = [_body(cut, tolerance) for cut in part.cuts]
    if isinstance(part.body, RevolvedBody):
        cuts += _open_backs(part, part.body.centre, tolerance)
    body = _body(part.body, tolerance)
    if part.adds:
        body = Manifold.batch_boolean([body, *(_body(one, tolerance) for one in part.adds)], OpType.Add)
    return body - Manifold.batch_boolean(cuts, OpType.Add) if cuts else body  # cuts may touch on a face


def _open_backs(part: Part, centre: float, tolerance: float) -> list[Manifold]:
    """Bones that are cut from a bent skin, once more and further out at its back: their own chords along its
    arc would leave films there. Half of the tolerance is the arc's, a quarter theirs."""
    out = math.copysign(0.75 * tolerance, centre)
    bones = (_given(cut, tolerance / 4) for cut in part.cuts if isinstance(cut, GivenBody))
    return [bone.translate((0.0, 0.0, shift)) for bone in bones for shift in (0.0, out)]


def mesh(part: Part, tolerance: float) -> trimesh.Trimesh:
    """Return the part's mesh in the mold's frame, mm, with 64-bit corners.

    Raises ExhaustedError where memory does not suffice.
    """
    safe_point()
    with resource_guard(f"the mesh of {part.name}"):
        body = manifold(part, tolerance)
        found = _mesh(body)
        return _mesh(body.simplify(SLIVER)) if lowest(found) < SLIVER else found


def lowest(shape: trimesh.Trimesh) -> float:
    """Return the least height of a mesh's triangles over their longest edge, mm."""
    edges = np.diff(np.asarray(shape.vertices)[np.asarray(shape.faces)[:, [0, 1, 2, 0]]], axis=1)
    longest = np.linalg.norm(edges, axis=2).max(axis=1)
    doubled = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
    return float((doubled / np.maximum(longest, SLIVER)).min())


def _mesh(body: Manifold) -> trimesh.Trimesh:
    raw = body.to_mesh64()
    corners, faces = np.array(raw.vert_properties)[:, :3], np.array(raw.tri_verts)
    return trimesh.Trimesh(corners, faces, process=False, validate=False)


def upright(shape: trimesh.Trimesh) -> trimesh.Trimesh:
    """Return a mesh of the mold's frame turned into the design's: about x, so that the ridges point up."""
    turned = shape.copy()
    turned.vertices = turned.vertices * [1.0, -1.0, -1.0]
    return turned


def laid(shape: trimesh.Trimesh, on_end: bool, part: Part | None = None) -> trimesh.Trimesh:
    """Return the mesh as it is printed: on the bed at z = 0, in the middle of x and y; on its y face where
    `on_end`. A `part` that leans in its mold is first turned back, and a block whose ends lean onto one."""
    placed = upright(shape) if part and part.role is PartRole.PLUG else shape.copy()  # on its plate
    frame = part.body if part else None
    if isinstance(frame, Prism) and frame.grid and on_end:
        frame = RotatedBody(frame, frame.grid.centre, -frame.grid.half, 0.0)
    if isinstance(frame, RotatedBody):
        placed.vertices = frame.returned(np.asarray(placed.vertices)).round(12)  # mm; a face is level again
    if on_end:
        placed.vertices = placed.vertices[:, [0, 2, 1]] * [1.0, -1.0, 1.0]
    low, high = placed.bounds
    placed.vertices -= [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2]]
    return placed


def _placed(shape: Manifold, place: RotatedBody) -> Manifold:
    turn, shift = place.placement()
    return shape.transform(np.column_stack([turn, shift]))


def _body(body: Body, tolerance: float) -> Manifold:
    if isinstance(body, ExtendedCut):
        return _body(body.built, tolerance)
    if isinstance(body, GivenBody):
        return _given(body, tolerance)
    if isinstance(body, RotatedBody):
        return _placed(_body(body.body, tolerance), body)
    if isinstance(body, Bore):
        return _bore(body, tolerance)
    if isinstance(body, TurnedBody):
        return _turned(body, tolerance)
    return _prism(body, tolerance) if isinstance(body, Prism) else _revolved(body, tolerance)


def _prism(prism: Prism, tolerance: float) -> Manifold:
    """Triangulate the ends and join them; corners keep their exact digits, so that a bore that ends on a
    face really opens it (a library's polygon class that rounds to 1e-8 mm left a film of that thickness)."""
    flat, faces = _strips(prism, tolerance, 1)
    ends = [np.column_stack([flat, np.full(len(flat), level)]) for level in (prism.low, prism.high)]
    points = np.vstack(ends)
    if prism.axis == "y":
        points, faces = points[:, _Y_IS_THIRD], faces[:, ::-1]
    if prism.axis == "x":
        points = points[:, _X_IS_THIRD]
    return Manifold(Mesh64(np.ascontiguousarray(points), np.ascontiguousarray(faces)))


def _revolved(body: RevolvedBody, tolerance: float) -> Manifold:
    """Join copies of the section at even angles. Between two of them a chord of the section sweeps a plane
    trapezoid, so the section's sagitta and the turn's add up: each has half of the tolerance."""
    half = tolerance / 2
    arm = float(np.abs(curves.polygon(body.outline, half)[:, 1] - body.centre).max())
    angles = np.linspace(body.low, body.high, turn_steps(body.high - body.low, arm, half) + 1)
    if body.grid:
        angles = body.grid.angles(body.low, body.high, tolerance)
    flat, faces = _strips(body, half, len(angles) - 1)
    points = np.vstack([body.placed(flat, angle) for angle in angles])
    return Manifold(Mesh64(np.ascontiguousarray(points), np.ascontiguousarray(faces[:, ::-1])))


def _turned(body: TurnedBody, tolerance: float) -> Manifold:
    """As in `_revolved` the loop and the turn have half of the tolerance each; half of that at a curved face,
    whose error adds."""
    points, faces = _whole_turn(body.outline, tolerance / (4 if body.buried else 2))
    return Manifold(Mesh64(np.ascontiguousarray(body.placed(points)), faces))


@lru_cache(maxsize=16)
def _whole_turn(outline: curves.Loop, half: float) -> tuple[Array, NDArray[np.uint64]]:
    """Corners `(n, 3)` mm and faces of copies of a loop all round; its points on the axis are one each."""
    flat = curves.polygon(outline, half)
    steps = max(12, turn_steps(2 * math.pi, float(flat[:, 0].max()), half))
    angles = 2 * math.pi * np.arange(steps) / steps
    t, n = np.repeat(flat[:, :1], steps, 1), np.repeat(flat[:, 1:], steps, 1)
    points = np.stack([t * np.cos(angles), t * np.sin(angles), n], 2).reshape(-1, 3)
    here = np.arange(len(points)).reshape(-1, steps)
    here[flat[:, 0] == 0.0] = here[flat[:, 0] == 0.0, :1]
    onward = np.roll(here, -1, 0)
    a, b, c, d = (k.ravel() for k in (here, onward, np.roll(onward, -1, 1), np.roll(here, -1, 1)))
    faces = np.vstack([np.stack([a, d, c], 1), np.stack([a, c, b], 1)])
    sound = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    used, faces = np.unique(faces[sound], return_inverse=True)
    return points[used], np.ascontiguousarray(faces.reshape(-1, 3).astype(np.uint64))


def _strips(body: Prism | RevolvedBody, tolerance: float, steps: int) -> tuple[Array, NDArray[np.uint64]]:
    """The section's corners `(n, 2)` mm and the faces that join `steps + 1` copies of them, in order."""
    loops = [corners(body, body.outline, tolerance)]
    loops += [corners(body, hole, tolerance)[::-1] for hole in body.holes]
    caps = np.asarray(triangulate(loops), dtype=np.uint64)
    flat = np.vstack(loops)
    first = np.concatenate([[0], np.cumsum([len(points) for points in loops])])
    here = np.arange(len(flat), dtype=np.uint64)
    onward = np.concatenate([np.roll(here[a:b], -1) for a, b in pairwise(first)])
    top = np.uint64(len(flat))
    side = np.vstack(
        [np.stack([here, onward, onward + top], 1), np.stack([here, onward + top, here + top], 1)]
    )
    sides = [side + top * np.uint64(step) for step in range(steps)]
    return flat, np.vstack([caps[:, ::-1], caps + top * np.uint64(steps), *sides])


@lru_cache(maxsize=8)
def _given(body: GivenBody, tolerance: float) -> Manifold:
    """The kernel's mesh of a user's solid, its faces joined at their edges."""
    from skincad.solids.occ import given_solid, tessellate, triangles

    shape = given_solid(body, "mold.bone")
    tessellate(shape, tolerance)
    points, faces = triangles(shape, tolerance)
    joined = trimesh.Trimesh(np.array([point.toTuple() for point in points]), np.array(faces), process=False)
    joined.merge_vertices(digits_vertex=6)
    joined.update_faces(joined.nondegenerate_faces())
    found = Manifold(
        Mesh64(np.ascontiguousarray(joined.vertices), np.ascontiguousarray(joined.faces.astype(np.uint64)))
    )
    if found.is_empty():
        remedy = "repair it in your CAD program"
        raise InputError("mold.bone", "makes no closed mesh", body.file.rpartition("/")[2], remedy)
    return found


def _bore(bore: Bore, tolerance: float) -> Manifold:
    upright = Manifold.cylinder(bore.length, bore.radius, bore.far_radius, bore.circle(tolerance))
    return (upright.rotate((-90.0, 0.0, 0.0)) if bore.axis == "y" else upright).translate(bore.start)


class BedPart(NamedTuple):
    """A part as it lies on the bed: its sides along x, y and z, mm."""

    name: str
    x: float
    y: float
    z: float


class Spot(NamedTuple):
    """Where a part lies on a plate: its middle from the plate's, mm, and whether it is turned by a right
    angle."""

    name: str
    x: float
    y: float
    turned: bool


def plates(parts: Sequence[BedPart], process: Process) -> list[list[Spot]]:
    """Return where parts lie, by plate. Each part, from the tallest down, goes onto the first plate that
    takes it; one that is larger than any plate has one to itself, in its middle (the finding `build volume`
    reports it)."""
    full: list[tuple[list[BedPart], list[Spot]]] = []
    for part in sorted(parts, key=lambda part: (-part.z, part.name)):
        for i, (lying, _) in enumerate(full):
            if (spots := arranged([*lying, part], process)) is not None:
                full[i] = [*lying, part], spots
                break
        else:
            alone = arranged([part], process) or [Spot(part.name, 0.0, 0.0, False)]
            full.append(([part], alone))
    return [spots for _, spots in full]


def arranged(parts: list[BedPart], process: Process) -> list[Spot] | None:
    """Return where parts lie in rows along the bed's longer side, the widest rows first, each part with its
    longer side along its row; None where they don't fit."""
    longer, shorter = sorted((process.build_x, process.build_y), reverse=True)
    spots: list[Spot] = []
    used = reach = deep = most = 0.0
    for part in sorted(parts, key=lambda part: sorted((part.x, part.y)), reverse=True):
        wide, long = sorted((part.x, part.y))
        if reach and (not longer or reach + PART_GAP + long <= longer):
            reach += PART_GAP + long
        else:
            used += deep + (PART_GAP if deep else 0.0)
            reach, deep = long, wide
        most = max(most, reach)
        if shorter and (reach > longer or used + deep > shorter):
            return None
        spots.append(Spot(part.name, reach - long / 2, used + wide / 2, part.x < part.y))
    return [Spot(s.name, s.x - most / 2, s.y - (used + deep) / 2, s.turned) for s in spots]
