"""MeshLab (pymeshlab) opens each STL: no self-intersection, no hole, one piece, and near to the STEP.

Two files by two builders are held against each other: manifold3d's chords and the CAD kernel's surfaces.
"""

from __future__ import annotations

from pathlib import Path

import cadquery as cq
import numpy as np
import pymeshlab
import trimesh
from OCP.BRepMesh import BRepMesh_IncrementalMesh

from skincad.fabrication import laid, laid_on_end
from skincad.solids.mold import mold
from tests.consumers import Job

FINER = 3.0  # the kernel's triangles keep this many times closer to the surface than was asked of the STL
TURN = 0.5  # rad, of the kernel's chords at most
SAMPLES = 20_000


def missing() -> str:
    """Return why it can't run here, or ""."""
    return ""  # skincad measures with it


def tessellated(path: Path, chord: float) -> trimesh.Trimesh:
    """Return a STEP file's one solid as the CAD kernel's own triangles, within `chord` mm."""
    solid = cq.importers.importStep(str(path)).val()
    BRepMesh_IncrementalMesh(solid.wrapped, chord, False, TURN, True)  # False: mm, not a share of an edge
    corners, faces = solid.tessellate(chord, TURN)  # takes the triangles that are there
    return trimesh.Trimesh(np.array([c.toTuple() for c in corners]), np.array(faces), process=False)


def deviation(stl: Path, true: trimesh.Trimesh) -> float:
    """Return the Hausdorff distance of an STL and a mesh, both ways, mm."""
    pair = pymeshlab.MeshSet(verbose=False)
    pair.load_new_mesh(str(stl))
    pair.add_mesh(pymeshlab.Mesh(np.asarray(true.vertices), np.asarray(true.faces, dtype=np.int32)))
    ways = [
        pair.get_hausdorff_distance(sampledmesh=a, targetmesh=b, samplenum=SAMPLES, sampleedge=True)["max"]
        for a, b in ((0, 1), (1, 0))
    ]
    return float(max(ways))


def flaws(stl: Path) -> list[str]:
    """Return what MeshLab finds wrong with an STL by itself."""
    meshes = pymeshlab.MeshSet(verbose=False)
    meshes.load_new_mesh(str(stl))
    meshes.meshing_remove_duplicate_vertices()  # an STL has each corner once a face
    meshes.compute_selection_by_self_intersections_per_face()
    crossing = meshes.current_mesh().selected_face_number()
    topology = meshes.get_topological_measures()
    counts = {
        "self-intersecting faces": (crossing, 0),
        "open edges": (topology["boundary_edges"], 0),
        "edges of more than two faces": (topology["non_two_manifold_edges"], 0),
        "pieces": (topology["connected_components_number"], 1),
    }
    return [f"{stl.name}: {count} {what}" for what, (count, right) in counts.items() if count != right]


def deviations(job: Job) -> dict[str, float]:
    """Return by part how far its STL is from its STEP, mm."""
    parts = {part.name: part for part in mold(job.design).parts}
    rows = {}
    for part in job.printed:
        true = tessellated(job.file(f"solids/{part.name}.step"), part.asked_deviation / FINER)
        if part.name != "skin":
            part_values = parts[part.name]
            true = laid(true, laid_on_end(job.plan, part_values), part_values)
        rows[part.name] = deviation(job.file(f"solids/{part.name}.stl"), true)
    return rows


def complaints(job: Job) -> list[str]:
    """Return flaws of the STL files, and those further from their STEP than was asked."""
    wrong = [flaw for part in job.printed for flaw in flaws(job.file(f"solids/{part.name}.stl"))]
    chord = job.result.parts[0].asked_deviation
    # the triangles' own, and digits of an STL: 6e-8 of 100 mm
    allowed = chord * (1 + 1 / FINER) + 1e-5
    for name, far in deviations(job).items():
        if far > allowed:
            wrong.append(f"{name}.stl: {far:.3g} mm from its STEP, asked were {chord:.3g}")
    return wrong
