"""Print meshes from plans by manifold3d: watertight by construction, arcs as chords within a tolerance."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import trimesh
from manifold3d import Manifold, Mesh64, OpType, triangulate
from numpy.typing import NDArray

from skincad import curves
from skincad.solids.plan import Body, Bore, Part, Prism, Revolved

Array = NDArray[np.float64]

_Y_IS_THIRD = np.array([0, 2, 1])  # order of (u, v, along) for a prism along y


def manifold(part: Part, tolerance: float) -> Manifold:
    """Return the part as a manifold whose chords keep within `tolerance` mm of the true surfaces."""
    cuts = [_body(cut, tolerance) for cut in part.cuts]
    body = _body(part.body, tolerance)
    return body - Manifold.batch_boolean(cuts, OpType.Add) if cuts else body  # cuts may touch on a face


def mesh(part: Part, tolerance: float) -> trimesh.Trimesh:
    """Return the part's mesh in the mold's frame, mm, with 64-bit corners."""
    raw = manifold(part, tolerance).to_mesh64()
    corners, faces = np.array(raw.vert_properties)[:, :3], np.array(raw.tri_verts)
    return trimesh.Trimesh(corners, faces, process=False, validate=False)


def upright(shape: trimesh.Trimesh) -> trimesh.Trimesh:
    """Return a mesh of the mold's frame turned into the design's: about x, so that the ridges point up."""
    turned = shape.copy()
    turned.vertices = turned.vertices * [1.0, -1.0, -1.0]
    return turned


def laid(shape: trimesh.Trimesh, on_end: bool) -> trimesh.Trimesh:
    """Return the mesh as it is printed: on the bed at z = 0, in the middle of x and y; on its y face where
    `on_end`."""
    placed = shape.copy()
    if on_end:
        placed.vertices = placed.vertices[:, [0, 2, 1]] * [1.0, -1.0, 1.0]
    low, high = placed.bounds
    placed.vertices -= [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2]]
    return placed


def _body(body: Body, tolerance: float) -> Manifold:
    if isinstance(body, Bore):
        return _bore(body, tolerance)
    return _prism(body, tolerance) if isinstance(body, Prism) else _revolved(body, tolerance)


def _prism(prism: Prism, tolerance: float) -> Manifold:
    """Triangulate the ends and join them; corners keep their exact digits, so that a bore that ends on a
    face really opens it (a library's polygon class that rounds to 1e-8 mm left a film of that thickness)."""
    corners, faces = _strips(prism, tolerance, 1)
    ends = [np.column_stack([corners, np.full(len(corners), level)]) for level in (prism.low, prism.high)]
    points = np.vstack(ends)
    if prism.axis == "y":
        points, faces = points[:, _Y_IS_THIRD], faces[:, ::-1]
    return Manifold(Mesh64(np.ascontiguousarray(points), np.ascontiguousarray(faces)))


def _revolved(body: Revolved, tolerance: float) -> Manifold:
    """Join copies of the section at even angles. Between two of them a chord of the section sweeps a plane
    trapezoid, so the section's sagitta and the turn's add up: each has half of the tolerance."""
    half = tolerance / 2
    arm = float(np.abs(curves.polygon(body.outline, half)[:, 1] - body.centre).max()) + half
    widest = 4 * math.asin(min(1.0, math.sqrt(half / (2 * arm))))  # its sagitta is 2 arm sin^2(widest / 4)
    steps = max(1, math.ceil((body.high - body.low) / widest))
    corners, faces = _strips(body, half, steps)
    points = np.vstack([body.placed(corners, angle) for angle in np.linspace(body.low, body.high, steps + 1)])
    return Manifold(Mesh64(np.ascontiguousarray(points), np.ascontiguousarray(faces[:, ::-1])))


def _strips(body: Prism | Revolved, tolerance: float, steps: int) -> tuple[Array, NDArray[np.uint64]]:
    """The section's corners `(n, 2)` mm and the faces that join `steps + 1` copies of them, in order."""
    loops = [curves.polygon(body.outline, tolerance)]
    loops += [curves.polygon(hole, tolerance)[::-1] for hole in body.holes]
    caps = np.asarray(triangulate(loops), dtype=np.uint64)
    corners = np.vstack(loops)
    first = np.concatenate([[0], np.cumsum([len(points) for points in loops])])
    here = np.arange(len(corners), dtype=np.uint64)
    onward = np.concatenate([np.roll(here[a:b], -1) for a, b in pairwise(first)])
    top = np.uint64(len(corners))
    side = np.vstack(
        [np.stack([here, onward, onward + top], 1), np.stack([here, onward + top, here + top], 1)]
    )
    sides = [side + top * np.uint64(step) for step in range(steps)]
    return corners, np.vstack([caps[:, ::-1], caps + top * np.uint64(steps), *sides])


def _bore(bore: Bore, tolerance: float) -> Manifold:
    end = bore.radius if bore.end_radius is None else bore.end_radius
    count = math.ceil(math.pi / math.acos(1 - min(0.5, tolerance / max(bore.radius, end))))
    upright = Manifold.cylinder(bore.length, bore.radius, end, max(12, count))
    return (upright.rotate((-90.0, 0.0, 0.0)) if bore.axis == "y" else upright).translate(bore.start)
