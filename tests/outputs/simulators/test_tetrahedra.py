"""The volume mesh: nothing inside out, one piece, its volume, and what other programs make of it."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

import meshio
import numpy as np
import pytest
import trimesh
from scipy import sparse
from scipy.sparse import csgraph

import skincad
from skincad.outputs import tetrahedra
from skincad.outputs.simulators import meshes, taxels
from skincad.shape import skin_of
from skincad.solids import along_skin
from tests.consumers import gmsh
from tests.outputs.simulators import ccx
from tests.outputs.simulators.conftest import DESIGNS, marks
from tests.processes import run_gmsh
from tests.solids.kinds import boned, stem

SMALL = skincad.load_design("steep-fingertip", ["ridge.count=1", "skin.width=4"])


ASK = """Merge "skin.msh";
Plugin(AnalyseMeshQuality).JacobianDeterminant = 1;
Plugin(AnalyseMeshQuality).Run;
Plugin(MeshVolume).Dimension = 3;
Plugin(MeshVolume).Run;
"""


mesh_of = cache(tetrahedra)


@pytest.fixture(
    scope="module", params=["small", *(pytest.param(name, marks=marks(name)) for name in DESIGNS)]
)
def mesh(request: pytest.FixtureRequest) -> tuple[skincad.Design, meshes.Tetrahedra]:
    design = SMALL if request.param == "small" else DESIGNS[request.param]
    return design, mesh_of(design)


def test_none_is_inside_out_and_volumes_are_the_solids(
    mesh: tuple[skincad.Design, meshes.Tetrahedra],
) -> None:
    """Of all regions together the stated deviation."""
    design, tets = mesh
    total = 0.0
    for elements in tets.elements.values():
        volumes = meshes.signed_volumes(tets.nodes, elements)
        assert volumes.min() > 0
        total += float(volumes.sum())
    whole = along_skin(design, skincad.section(design).outline, ()).volume
    assert total == pytest.approx(whole, rel=1.001 * tets.deviation)
    assert tets.deviation < 2e-3
    film = 2 * design.ridge.count * design.film.thickness * design.slot.depth * design.skin.length
    assert tets.volumes["film"][0] == pytest.approx(film, rel=1e-2)  # a doubly curved one is shorter below


def test_it_is_one_piece_without_gaps(mesh: tuple[skincad.Design, meshes.Tetrahedra]) -> None:
    """Every face has two elements or lies on the boundary; middles lie in the middle."""
    _, tets = mesh
    cells = np.concatenate(list(tets.elements.values()))
    faces = np.sort(cells[:, [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]].reshape(-1, 3), axis=1)
    unique, count = np.unique(faces, axis=0, return_counts=True)
    assert count.max() == 2
    boundary = {tuple(row) for row in unique[count == 1].tolist()}
    for rows in tets.surfaces.values():
        assert all(tuple(sorted(row[:3])) in boundary for row in rows.tolist())
    middles = tets.nodes[cells[:, 4:]]
    for k, (a, b) in enumerate(((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))):
        halfway = (tets.nodes[cells[:, a]] + tets.nodes[cells[:, b]]) / 2
        assert np.abs(middles[:, k] - halfway).max() < 1e-12  # mm, of doubles of some 10 mm


def test_surfaces_lie_where_they_say(mesh: tuple[skincad.Design, meshes.Tetrahedra]) -> None:
    design, tets = mesh
    assert {*tets.surfaces} == {"back", *(f"crest-{i}" for i in range(1, design.ridge.count + 1))}
    top = tets.nodes[:, 2].max()
    middle = (design.ridge.count + 1) // 2
    assert tets.nodes[tets.surfaces[f"crest-{middle}"]][..., 2].max() == top
    assert top == pytest.approx(skincad.section(design).top, abs=1e-9)
    if design.skin.curvature_radius_y is None:
        assert (tets.nodes[tets.surfaces["back"]][..., 2] == 0).all()


def test_meshio_reads_the_same_from_both_files(tmp_path: Path) -> None:
    mesh_of_design = mesh_of(SMALL)
    (tmp_path / "skin.msh").write_text(meshes.msh(mesh_of_design))
    (tmp_path / "skin.vtu").write_text(meshes.vtu(mesh_of_design))
    cells = np.concatenate(list(mesh_of_design.elements.values()))
    one, other = meshio.read(tmp_path / "skin.msh"), meshio.read(tmp_path / "skin.vtu")
    for read in (one, other):
        assert (read.points == mesh_of_design.nodes).all()
        tets = np.concatenate([block.data for block in read.cells if block.type == "tetra10"])
        assert (tets == cells).all()  # meshio has VTK's order, and turns Gmsh's into it
    assert {*one.field_data} == {"skin", "film", *mesh_of_design.surfaces}
    assert (other.cell_data["region"][0] == 2).sum() == len(mesh_of_design.elements["film"])


@pytest.mark.skipif(bool(gmsh.missing()), reason=gmsh.missing())
def test_gmsh_finds_positive_jacobians_and_the_volume(tmp_path: Path) -> None:
    tets = mesh_of(SMALL)
    (tmp_path / "skin.msh").write_text(meshes.msh(tets))
    (tmp_path / "ask.geo").write_text(ASK)
    process = run_gmsh(tmp_path / "ask.geo")
    output = process.stdout + process.stderr
    assert "Error" not in output
    least, evenness = (
        float(re.search(rf"{what}\s+=\s+(\S+?),", output)[1]) for what in ("minJ", "minJ/maxJ")
    )
    assert least > 0
    assert evenness == 1.0  # edges are straight
    volume = float(re.search(r"Mesh volume .*: (\S+)", output)[1])
    assert volume == pytest.approx(sum(pair[0] for pair in tets.volumes.values()), rel=1e-5)


def test_materials_say_what_each_region_is() -> None:
    tets = mesh_of(SMALL)
    data = meshes.materials(SMALL, tets)
    assert data["units"]["young_modulus"] == "MPa"
    assert data["film"]["young_modulus"] == SMALL.film.young_modulus
    assert data["skin"]["density"] == 1030.0
    assert data["volume_deviation"] == tets.deviation


def test_empty_slots_are_voids() -> None:
    loose = SMALL.with_(contact={"film": "loose"})
    void = 2 * SMALL.ridge.count * SMALL.slot.thickness * SMALL.slot.depth * SMALL.skin.length
    tets, full = tetrahedra(loose), mesh_of(SMALL)
    assert {*tets.elements} == {"skin"}
    more = sum(pair[0] for pair in full.volumes.values()) - tets.volumes["skin"][0]
    assert more == pytest.approx(void, rel=1e-6)


# What no section swept along y shows: by netgen of the solid, or turned about z.
PINS = ("pin.columns=2", "pin.rows=2", "pin.heights=none", "pin.height=4", "skin.width=14", "skin.length=14")
TURNED = {
    "rings": ("rings-5", ("ring.count=2", "skin.width=12"), "turned"),
    "round face": (
        "flat-magnet",
        ("flat.pocket=none", "skin.outline=round", "skin.width=12", "skin.length=12"),
        "turned",
    ),
    "pockets in a face": ("flat-magnet", (), "meshed"),
    "pins": ("pillars-9", (*PINS, "pin.pocket=none"), "meshed"),
    "pins with pockets": ("pillars-9", PINS, "meshed"),
    "pins on a dome": (
        "pins-dome",
        ("pin.rings=1", "skin.width=6", "skin.length=6", "skin.thickness=3"),
        "meshed",
    ),
    "pins in layers": ("pillars-9", PINS, "meshed"),
}
RING = "rings-5", ("ring.count=1", "ring.pitch=3.2", "skin.width=6", "skin.thickness=3")
LAYERS = [{"name": "ecoflex-00-30", "thickness": 1.0}, {"name": "ecoflex-00-50", "thickness": 2.0}]


@pytest.fixture(
    scope="module",
    params=[pytest.param(name, marks=pytest.mark.evidence(subject=f"meshes: {name}")) for name in TURNED],
)
def turned(request: pytest.FixtureRequest) -> tuple[skincad.Design, meshes.Tetrahedra]:
    name, settings, way = TURNED[request.param]
    design = skincad.load_design(name, settings)
    design = design.with_(shot=LAYERS) if request.param == "pins in layers" else design
    tets = tetrahedra(design)
    assert tets.way == way
    return design, tets


def test_no_element_of_them_is_inside_out_and_volumes_are_the_kernels(
    turned: tuple[skincad.Design, meshes.Tetrahedra],
) -> None:
    """0.5 %: chords of the roundest region; the least scaled Jacobian is that of slivers at an axis."""
    design, tets = turned
    volumes = [meshes.signed_volumes(tets.nodes, cells) for cells in tets.elements.values()]
    assert min(part.min() for part in volumes) > 0
    kernel = skincad.skin_solid(design).val().Volume()
    assert sum(part.sum() for part in volumes) == pytest.approx(kernel, rel=5e-3)
    assert sum(exact for _, exact in tets.volumes.values()) == pytest.approx(kernel, rel=1e-8)
    for meshed, exact in tets.volumes.values():
        assert meshed == pytest.approx(exact, rel=6e-3)
    assert tets.quality > 1e-3
    assert {*tets.elements} == {"skin", *(["shot-1", "shot-2"] if design.shot else [])}


def test_they_are_in_one_piece(turned: tuple[skincad.Design, meshes.Tetrahedra]) -> None:
    test_it_is_one_piece_without_gaps(turned)
    _, tets = turned
    cells = np.concatenate(list(tets.elements.values()))
    joined = sparse.coo_matrix(
        (np.ones(3 * len(cells)), (cells[:, [0, 1, 2]].ravel(), cells[:, [1, 2, 3]].ravel()))
    )
    corners = np.unique(cells[:, :4])
    size = len(tets.nodes)
    joined.resize(size, size)
    _, label = csgraph.connected_components(joined, directed=False)
    assert len({*label[corners]}) == 1


def test_each_cap_and_the_back_are_marked(turned: tuple[skincad.Design, meshes.Tetrahedra]) -> None:
    """Their areas against those of the exact surfaces; 5 %: a cap's facets. Each cap has its own tip."""
    design, tets = turned
    crests = taxels.crests(design)
    assert {*tets.surfaces} == {"back", *(f"crest-{i}" for i in range(1, len(crests.names) + 1))}
    areas = {
        name: trimesh.Trimesh(tets.nodes, rows[:, :3], process=False).area
        for name, rows in tets.surfaces.items()
    }
    for i, (exact, pose) in enumerate(zip(crests.areas, crests.poses, strict=True), 1):
        assert areas[f"crest-{i}"] == pytest.approx(exact, rel=0.05)
        away = np.linalg.norm(tets.nodes[tets.surfaces[f"crest-{i}"].ravel()] - pose[:, 3], axis=1)
        assert away.min() < 0.3 * crests.sizes[i - 1].min()
    below = [face for face in skincad.skin_solid(design).val().Faces() if face.BoundingBox().zmax < 1e-6]
    if design.skin.curvature_radius_y is None:  # else the back is bent
        assert areas["back"] == pytest.approx(max(face.Area() for face in below), rel=1e-2)


@pytest.mark.evidence(subject="meshes: pins")
def test_a_bone_is_a_flat_back_as_in_a_check(tmp_path: Path) -> None:
    """Its mesh is that of the skin without one; the package says so."""
    bare = skincad.load_design("pillars-9", [*PINS, "pin.pocket=none"])
    on_bone = boned(tmp_path, stem(), bare)
    package = skincad.package(on_bone, "mesh")
    assert (package.mesh.nodes == tetrahedra(bare).nodes).all()
    assert "takes the bone as a flat back" in str(package)


@pytest.mark.evidence(subject="meshes: heights")
@pytest.mark.parametrize("name", ["pillars-9", "rings-5", "pins-dome"])
def test_heights_of_round_features_are_their_crests(name: str) -> None:
    """The nearest pixel to each tip; 2 chords of the visual mesh, and what a crown falls away in a pixel."""
    design = skincad.load_design(name)
    heights = meshes.height_map(design)
    for x, y, z in taxels.crests(design).poses[:, :, 3]:
        column, row = (
            round(v)
            for v in ((x - heights.corner[0]) / heights.pixel, (heights.corner[1] - y) / heights.pixel)
        )
        assert heights.height[row, column] == pytest.approx(z, abs=0.005 * skin_of(design).pitch)


@pytest.mark.evidence(subject="calculix: package")
@pytest.mark.skipif(bool(ccx.missing()), reason=ccx.missing())
@pytest.mark.parametrize(("name", "fineness"), [("pins", 1.0), ("ring", 0.35)])
def test_calculix_on_the_mesh_of_pins_and_a_ring_has_the_force_of_the_check(
    name: str, fineness: float
) -> None:
    """Small strain, no friction: the force at the check's approach, less and more its error, is below and
    above the check's, so that at equal force the approach is within the check's error. The ring has 25 steps
    round: with 36 CalculiX takes minutes."""
    source, settings = {"pins": ("pillars-9", (*PINS, "pin.pocket=none")), "ring": RING}[name]
    design = skincad.load_design(source, settings)
    design = design.with_(contact={"friction": 0.0, "force": 1.0 if name == "pins" else 0.2})
    verdict, tets = skincad.check(design), tetrahedra(design, fineness)
    approach = verdict.approach
    low, high = (ccx.pressed(design, tets, approach.value + sign * approach.error) for sign in (-1, 1))
    assert low < verdict.force < high


@pytest.mark.evidence(subject="calculix: package")
@pytest.mark.skipif(bool(ccx.missing()), reason=ccx.missing())
def test_calculix_on_that_mesh_has_the_approach_of_the_check() -> None:
    """Its force at the solid model's approach: what that force is off, the approach at equal force is off by
    less, for contact grows. 3 % is the issue's; measured 0.7 % on all of plain-ridges, which takes minutes.
    Small strain, no friction, free ends on both sides.
    """
    few = skincad.load_design("plain-ridges").with_(
        ridge={"count": 3}, skin={"width": 4.0, "length": 6.0}, contact={"force": 0.6}
    )
    verdict = skincad.check(few.with_(contact={"friction": 0.0}), model="solid")
    force = ccx.pressed(few, tetrahedra(few), float(verdict.approach))
    assert force == pytest.approx(verdict.force, rel=0.03)
