"""What a print mesh really is: its deviation, self-intersections, and whether parts interfere."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pymeshlab
import trimesh
from manifold3d import Manifold

from skincad.fabrication.findings import Finding
from skincad.fabrication.meshes import manifold
from skincad.fabrication.meshes import mesh as mesh_of
from skincad.solids.mold import Mold
from skincad.solids.plan import Axis, Body, Heading, Part, Revolved, swept

FINER = 10.0  # the reference mesh's chords are this many times finer
SAMPLES = 10_000  # points on each mesh, besides all corners and edges; seeded by the library
SLIVER = 1e-9  # mm3; a common volume below this is rounding of touching faces


@dataclass(frozen=True)
class MeshMeasure:
    """A print mesh as measured: mm, mm2, mm3."""

    watertight: bool
    self_intersections: int
    volume: float
    deviation: float  # largest distance to the true surface, both ways; never below the truth


def measure(part: Part, mesh: trimesh.Trimesh, tolerance: float) -> MeshMeasure:
    """Measure a part's print mesh against one `FINER` times finer; that one's own error is added."""
    finer = mesh_of(part, tolerance / FINER)
    meshes = pymeshlab.MeshSet(verbose=False)
    meshes.add_mesh(_pymeshlab_mesh(mesh), "print")
    meshes.add_mesh(_pymeshlab_mesh(finer), "finer")
    ways = [
        meshes.get_hausdorff_distance(
            sampledmesh=a, targetmesh=b, samplenum=SAMPLES, samplevert=True, sampleedge=True
        )["max"]
        for a, b in ((0, 1), (1, 0))
    ]
    meshes.add_mesh(_pymeshlab_mesh(_with_flat_ends(part.body, mesh)), "flat ends")
    meshes.compute_selection_by_self_intersections_per_face()
    return MeshMeasure(
        watertight=bool(mesh.is_watertight and mesh.is_winding_consistent),
        self_intersections=meshes.current_mesh().selected_face_number(),
        volume=float(mesh.volume),
        deviation=max(ways) + tolerance / FINER,
    )


def _with_flat_ends(body: Body, mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """Return a revolved body's mesh straightened, any other as it is: the library takes the rounding of a
    slanting end's triangles for crossings.

    Between two angle steps straightening takes section to section, so its plane trapezoids to rectangles,
    one to one: they cross after if and only if they crossed before.
    """
    if not isinstance(body, Revolved):
        return mesh
    points = body.straightened(np.asarray(mesh.vertices))
    points[:, 1] = points[:, 1].round(9)  # mm; an end's corners are level again
    return trimesh.Trimesh(points, mesh.faces, process=False, validate=False)


def _pymeshlab_mesh(mesh: trimesh.Trimesh) -> pymeshlab.Mesh:
    return pymeshlab.Mesh(np.asarray(mesh.vertices, dtype=float), np.asarray(mesh.faces, dtype=np.int32))


def interference(assembled: Mold, tolerance: float) -> list[Finding]:
    """Return every pair of parts that share volume, closed or on the way of an opening step.

    All meshes take their corners from the same exact section, so touching faces share none. `tolerance`
    (mm) must be well below the clearances.
    """
    solids = {part.name: manifold(part, tolerance) for part in assembled.parts}
    names = list(solids)
    found = [
        _finding("interference", f"{a} in {b}, closed", volume)
        for i, a in enumerate(names)
        for b in names[i + 1 :]
        if (volume := _common(solids[a], solids[b])) > SLIVER
    ]
    for step in assembled.opening:
        moving = [part for part in assembled.parts if part.name in step.parts]
        for name in step.parts:
            del solids[name]
        for part in moving:
            path = manifold(swept(part, step.axis, step.travel, tolerance), tolerance)
            for name, other in solids.items():
                if name == "cavity" and part.name.startswith(("skin", "strip")):
                    continue  # the skin bends, and the strips in it: the undercut rule judges it
                if (volume := _common(path, other)) > SLIVER:
                    where = f"{part.name} against {name}, opening along {_way(step.axis)}"
                    found.append(_finding("interference", where, volume))
    return found


def _way(axis: Axis | Heading) -> str:
    return axis if isinstance(axis, str) else f"x {axis[0]:.3g}, z {axis[1]:.3g}"


def _common(a: Manifold, b: Manifold) -> float:
    low, high = a.bounding_box(), b.bounding_box()
    if any(low[i] >= high[i + 3] or high[i] >= low[i + 3] for i in range(3)):
        return 0.0
    return float((a ^ b).volume())


def _finding(rule: str, where: str, volume: float) -> Finding:
    return Finding(rule, where, volume, SLIVER, "mm3", "error", "enlarge mold.clearance or change the parts")
