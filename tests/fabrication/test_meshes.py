"""Print meshes against the CAD kernel's own tessellation: two builders of one plan."""

from __future__ import annotations

import numpy as np
import pymeshlab
import pytest
import trimesh

from skincad.fabrication import laid, measure, mesh, print_chord
from skincad.inputs import Design
from skincad.solids import solid
from skincad.solids.mold import mold
from tests.solids.test_doubly_curved_mold import level_crowned

FINE = 2e-4  # mm, the kernel's own chord tolerance for the reference


def kernel_mesh(part) -> trimesh.Trimesh:
    corners, faces = solid(part).tessellate(FINE, 0.1)
    return trimesh.Trimesh(np.array([c.toTuple() for c in corners]), np.array(faces), process=False)


def hausdorff(one: trimesh.Trimesh, two: trimesh.Trimesh) -> float:
    pair = pymeshlab.MeshSet(verbose=False)
    for shape in (one, two):
        pair.add_mesh(pymeshlab.Mesh(np.asarray(shape.vertices), np.asarray(shape.faces, dtype=np.int32)))
    ways = [
        pair.get_hausdorff_distance(sampledmesh=a, targetmesh=b, samplenum=20000, sampleedge=True)["max"]
        for a, b in ((0, 1), (1, 0))
    ]
    return max(ways)


@pytest.mark.parametrize("name", ["skin", "cavity", "end-a-comb", "end-b-keeper", "carrier", "cover"])
def test_mesh_is_within_its_tolerance_of_the_kernels_solid(yamada: Design, name: str) -> None:
    part = mold(yamada).part(name)
    tolerance = 2e-3
    shape = mesh(part, tolerance)
    assert hausdorff(shape, kernel_mesh(part)) <= tolerance + FINE


def test_stated_deviation_is_that_of_the_mesh_not_the_asked_one(yamada: Design) -> None:
    part = mold(yamada).part("cavity")
    coarse = mesh(part, 0.02)
    seen = measure(part, coarse, 0.002)  # judged against a reference made for a finer mesh
    assert 0.01 < seen.deviation <= 0.02 + 2e-4
    assert seen.watertight
    assert seen.self_intersections == 0


@pytest.mark.parametrize(
    "seed", [127, *(pytest.param(i, marks=pytest.mark.slow) for i in (101, 106, 145, 170, 188))]
)
def test_faces_in_one_plane_but_for_rounding_do_not_cross(seed: int) -> None:
    """In these carriers, nearly flat along y, the library takes a few facets for crossing."""
    design, closed = level_crowned(seed)
    part, chord = closed.part("carrier"), print_chord(design)
    shape = mesh(part, chord)
    assert measure(part, shape, chord).self_intersections == 0
    shape.vertices[np.argmin(shape.vertices[:, 2])] += [0.1, 0.2, 40.0]  # up through the top
    assert measure(part, shape, chord).self_intersections > 0


def test_self_intersections_are_seen(yamada: Design) -> None:
    part = mold(yamada).part("cover")
    torn = mesh(part, 0.01)
    torn.vertices[0] += [30.0, 0.0, 10.0]  # one corner pulled through the far side
    assert measure(part, torn, 0.01).self_intersections > 0


def test_laid_parts_stand_on_the_bed_with_the_same_volume(yamada: Design) -> None:
    part = mold(yamada).part("end-a-comb")
    shape = mesh(part, 0.01)
    flat = laid(shape, on_end=True)
    assert flat.bounds[0][2] == 0.0
    assert flat.volume == pytest.approx(shape.volume, rel=1e-12)
    assert flat.extents[2] == pytest.approx(yamada.mold.end_plate, abs=1e-9)
