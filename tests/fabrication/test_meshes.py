"""Print meshes: against the CAD kernel's tessellation, and what parts share."""

from __future__ import annotations

import io
from dataclasses import replace

import numpy as np
import pymeshlab
import pytest
import trimesh

import skincad
from skincad.fabrication import interference, laid, manifold, measure, mesh, print_chord
from skincad.inputs import Design
from skincad.shape import rectangle
from skincad.solids import (
    ClosedMold,
    ExtendedCut,
    Grid,
    Part,
    PartRole,
    RevolvedBody,
    RotatedBody,
    box,
    solid,
)
from skincad.solids.mold import mold
from tests.designs import three_ridges
from tests.solids.test_doubly_curved_mold import level_crowned

FINE = 2e-4  # mm, the kernel's own chord tolerance for the reference


FLAT_SEEDS = pytest.mark.evidence(subject="seeds: nearly flat carriers")


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


@pytest.fixture(scope="module")
def straight() -> Design:
    return skincad.load("yamada-2002", ["ridge.count=3"])


@pytest.mark.slow
def test_no_triangle_loses_its_area_in_single_precision() -> None:
    """Of this pad of pins two triangles of the cavity were lower than 1 nm as an STL has them."""
    pin = {"pitch": 5.44, "columns": 4, "rows": 4, "height": 4.48, "heights": None, "root_diameter": 2.474}
    pin |= {"tip_diameter": 2.348, "crown": 0.117, "tip_fillet": 0.235, "root_fillet": 0.0}
    pin |= {"pocket": {"diameter": 1.0, "depth": 2.0}}
    skin = {"curvature_radius": 200.0, "thickness": 5.0, "width": 30.0, "length": 30.0}
    design = skincad.load("pillars-9").with_(skin=skin, pin=pin, mold={"process": "cnc", "split": "auto"})
    again = mesh(mold(design).part("cavity"), print_chord(design)).export(file_type="stl")
    read = trimesh.load(io.BytesIO(again), file_type="stl")
    assert read.is_watertight
    assert read.nondegenerate_faces(height=1e-6).all()


@pytest.mark.parametrize("name", ["cavity", "end-a-comb", "carrier"])
def test_mesh_is_within_its_tolerance_of_the_kernels_solid(straight: Design, name: str) -> None:
    part = mold(straight).part(name)
    tolerance = 2e-3
    shape = mesh(part, tolerance)
    assert hausdorff(shape, kernel_mesh(part)) <= tolerance + FINE


def test_stated_deviation_is_that_of_the_mesh_not_the_asked_one(straight: Design) -> None:
    part = mold(straight).part("cavity")
    coarse = mesh(part, 0.02)
    seen = measure(part, coarse, 0.002)  # judged against a reference made for a finer mesh
    assert 0.01 < seen.deviation <= 0.02 + 2e-4
    assert seen.watertight
    assert seen.self_intersections == 0


@pytest.mark.slow
@pytest.mark.parametrize(
    "seed", [127, *(pytest.param(i, marks=FLAT_SEEDS) for i in (101, 106, 145, 170, 188))]
)
def test_faces_in_one_plane_but_for_rounding_do_not_cross(seed: int) -> None:
    """In these carriers, nearly flat along y, the library takes a few facets for crossing."""
    design, closed = level_crowned(seed)
    part, chord = closed.part("carrier"), print_chord(design)
    shape = mesh(part, chord)
    assert measure(part, shape, chord).self_intersections == 0
    shape.vertices[np.argmin(shape.vertices[:, 2])] += [0.1, 0.2, 40.0]  # up through the top
    assert measure(part, shape, chord).self_intersections > 0


def test_laid_parts_stand_on_the_bed_with_the_same_volume(straight: Design) -> None:
    part = mold(straight).part("end-a-comb")
    shape = mesh(part, 0.01)
    flat = laid(shape, on_end=True)
    assert flat.bounds[0][2] == 0.0
    assert flat.volume == pytest.approx(shape.volume, rel=1e-12)
    assert flat.extents[2] == pytest.approx(straight.mold.end_plate, abs=1e-9)


@pytest.fixture(scope="module")
def design() -> Design:
    return three_ridges()


@pytest.fixture(scope="module")
def closed(design: Design) -> ClosedMold:
    return mold(design)


@pytest.mark.slow
@pytest.mark.parametrize("asked", [0.02, 0.003])
def test_meshes_are_closed_free_and_as_near_as_asked(closed: ClosedMold, asked: float) -> None:
    for part in closed.parts:
        if part.made == "made" or part.name == "skin":
            seen = measure(part, mesh(part, asked), asked)
            assert seen.watertight, part.name
            assert seen.self_intersections == 0, part.name
            assert seen.deviation <= 1.1 * asked, part.name  # a tenth is the reference mesh's own


@pytest.mark.parametrize(
    ("kind", "name"),
    [("straight", "cover"), ("design", "cavity"), ("design", "carrier"), ("design", "end-b-comb")],
)
def test_a_torn_mesh_is_seen(kind: str, name: str, request: pytest.FixtureRequest) -> None:
    part = mold(request.getfixturevalue(kind)).part(name)
    torn = mesh(part, 0.02)
    torn.vertices[len(torn.vertices) // 2] += [5.0, 1.0, 3.0]
    assert measure(part, torn, 0.02).self_intersections > 0


def test_parts_that_turn_share_their_facets(closed: ClosedMold) -> None:
    """Skin, shims, cavity and carrier touch along arcs; at any chord length their meshes share nothing."""
    for chord in (0.02, 0.003):
        names = ("skin", "cavity", "carrier", "shim-1-S1")
        shapes = {name: manifold(closed.part(name), chord) for name in names}
        for a, b in (("skin", "cavity"), ("skin", "carrier"), ("cavity", "carrier")):
            assert (shapes[a] ^ shapes[b]).volume() < 1e-9, (a, b, chord)
        assert (shapes["skin"] ^ shapes["shim-1-S1"]).volume() < 1e-9
        # nor is there a gap: what is set lower by 1 um meets 11 mm x about 9.6 mm of back
        overlap = shapes["carrier"].translate((0.0, 0.0, -1e-3)) ^ shapes["skin"]
        assert overlap.volume() == pytest.approx(1e-3 * 11 * 9.6, rel=0.1)


def test_two_turned_bodies_share_what_their_sections_do(closed: ClosedMold) -> None:
    skin, shim = closed.part("skin"), closed.part("shim-1-S1")
    assert isinstance(skin.body, RevolvedBody)
    whole = Part("whole", PartRole.SKIN, skin.body.__class__(skin.body.outline, *_turn(skin.body)))
    (finding,) = interference(ClosedMold((whole, shim), ()), 1e-3)
    slot = 0.05 * 0.25 * 12.0 * (1 + 0.1 / 25)  # the slot's middle lies 0.1 mm farther from the axis
    assert finding.measured == pytest.approx(slot, rel=0.01)  # shrinkage
    assert interference(ClosedMold((skin, shim), ()), 1e-3) == []


def _turn(body: RevolvedBody) -> tuple[float, float, float]:
    return body.centre, body.low, body.high


def test_end_plates_are_laid_flat_and_a_block_on_its_leaning_end(closed: ClosedMold) -> None:
    for name in ("end-a-comb", "end-b-keeper"):
        part = closed.part(name)
        assert isinstance(part.body, RotatedBody)
        shape = laid(mesh(part, 0.01), True, part)
        assert shape.bounds[0][2] == 0.0
        assert shape.bounds[1][2] == pytest.approx(4.0, abs=1e-9)  # mold.end_plate
    for end in (False, True):
        shape = laid(mesh(closed.part("cavity"), 0.01), end, closed.part("cavity"))
        down = np.asarray(shape.face_normals)[:, 2] < -1 + 1e-9
        on_bed = np.asarray(shape.triangles)[:, :, 2].max(axis=1) < 1e-9
        assert shape.area_faces[down & on_bed].sum() > 200.0  # mm2: it stands


def ring(
    low: float, high: float, z: tuple[float, float], centre: float = 30.0, **more: object
) -> RevolvedBody:
    return RevolvedBody(
        rectangle(-2.0, 2.0, *z), centre, low, high, grid=Grid(centre, 0.4, centre + 5), **more
    )


def shared(*bodies: RevolvedBody | Part) -> list[float]:
    """Volumes that parts share, mm3, of meshes of 0.1 mm."""
    parts = [
        body if isinstance(body, Part) else Part(f"part-{i}", PartRole.SHIM, body)
        for i, body in enumerate(bodies)
    ]
    return [finding.measured for finding in interference(ClosedMold(tuple(parts), ()), 0.1)]


@pytest.mark.parametrize("turned_over", [False, True])
def test_rings_share_what_their_sections_do_to_the_last_digit(turned_over: bool) -> None:
    """A ring's part: half the angle times the difference of the squares of its radii, times its width."""
    one, other = ring(-0.3, 0.2, (-3.0, 0.0)), ring(-0.1, 0.4, (-1.0, 2.0))
    expected = 0.3 * (31.0**2 - 30.0**2) / 2 * 4
    pair = (other, one) if turned_over else (one, other)
    assert shared(*pair) == pytest.approx([expected], rel=1e-9)  # coarse meshes would be 1e-3 off
    hollow = replace(other, holes=(rectangle(-1.0, 1.0, -0.5, 0.5),))
    less = 0.3 * (30.5**2 - 30.0**2) / 2 * 2
    assert shared(one, hollow) == pytest.approx([expected - less], rel=1e-9)
    assert shared(one, ring(0.2, 0.4, (-1.0, 2.0))) == []  # they meet at an angle
    assert shared(one, ring(-0.3, 0.2, (0.0, 2.0))) == []  # and along a slot
    assert shared(one, ring(-0.3, 0.2, (0.1, 2.0))) == []  # sections apart, boxes not
    assert shared(one, ring(0.25, 0.4, (-1.0, 2.0))) == []


def test_a_ring_in_anothers_cut_shares_nothing_and_beside_it_what_meshes_do() -> None:
    slot = ring(-0.3, 0.3, (-2.0, -1.0))
    cut = Part("cut", PartRole.SKIN, ring(-0.3, 0.3, (-3.0, 0.0)), (slot,))
    filled = replace(slot, outline=rectangle(-2.0, 2.0, -1.9, -1.1))
    assert shared(cut, filled) == []
    volume = 0.2 * (30.5**2 - 30.0**2) / 2 * 4
    beside = replace(slot, outline=rectangle(-2.0, 2.0, -0.5, 1.0), low=-0.1, high=0.1)
    assert shared(cut, beside) == pytest.approx([volume], rel=0.02)  # chords within 0.1 mm of 30 mm


def test_only_what_lies_all_in_a_cut_is_taken_as_clear() -> None:
    """What fills the cut touches it everywhere; a little longer or thicker it shares that little."""
    slot = ring(-0.3, 0.3, (-2.0, -1.0))
    outer = Part("outer", PartRole.SKIN, ring(-0.4, 0.4, (-3.0, 0.0)), (ExtendedCut(slot, slot),))
    assert shared(outer, slot) == shared(slot, outer) == []
    part = (32.0**2 - 31.0**2) / 2 * 4
    for low, high in ((-0.35, 0.3), (-0.3, 0.35), (-0.35, 0.35)):
        longer = replace(slot, low=low, high=high)
        assert shared(outer, longer) == pytest.approx([(high - low - 0.6) * part], rel=0.02)  # chords
    thicker = replace(slot, outline=rectangle(-2.0, 2.0, -2.0, -0.9))
    assert shared(thicker, outer) == pytest.approx([0.6 * (31.0**2 - 30.9**2) / 2 * 4], rel=0.02)
    block = Part("block", PartRole.COVER, box(1.0, (-2.0, 2.0), (-1.8, -0.5)))
    assert shared(outer, block)[0] == pytest.approx(2 * 4 * 0.5, rel=0.2)  # the cut's upper side is an arc
