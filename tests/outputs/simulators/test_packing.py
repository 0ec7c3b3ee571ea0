"""A package's files: the same numbers in each, taxels in their places, the same bytes again, and refusals."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path
from typing import Any, NamedTuple

import cadquery as cq
import numpy as np
import pytest
import trimesh
from PIL import Image

import skincad
from skincad.fabrication import mesh
from skincad.inputs import Design
from skincad.outputs.simulators import meshes, taxels
from skincad.solids import skin_part, workplane
from tests.conftest import run_skincad
from tests.refusals import refused_command

COUNTS = {"one ridge": 1, "three ridges": 3}


class Written(NamedTuple):
    """A whole package, written by the command into its usual folder."""

    folder: Path
    answer: dict[str, Any]  # what `--json` says
    words: tuple[str, ...]  # the command's, without its output
    design: Design


@pytest.fixture(scope="module", params=["one ridge", pytest.param("three ridges", marks=pytest.mark.slow)])
def made(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Written:
    folder = tmp_path_factory.mktemp("work")
    settings = ["ridge.count=1", "skin.width=4"] if request.param == "one ridge" else []
    words = ("steep-fingertip", *(w for s in settings for w in ("--set", s)), "--tier", "winkler")
    process = run_skincad("package", *words, "--json", cwd=folder)
    assert process.returncode == 0, process.stderr
    design = skincad.load_design("steep-fingertip", settings)
    return Written(folder / "out" / "steep-fingertip" / "package", json.loads(process.stdout), words, design)


@pytest.mark.slow
def test_json_and_card_say_what_is_there(made: Written) -> None:
    folder, answer, _, design = made
    card = json.loads((folder / "package.json").read_text())
    assert answer["taxels"] == 3 * design.ridge.count
    assert answer["mass_g"] == pytest.approx(card["mass_g"])
    assert {row["path"].rpartition("/")[2] for row in answer["files"]} == {
        p.name for p in folder.iterdir()
    } - {"package.json"}
    assert card["licence"] is None
    assert {*card["numbers"][0]} == {"what", "rests_on", "holds"}
    text = (folder / "package.md").read_text()
    for words in ("Licence: to be stated by the skin's owner", "What was simplified", "rests on", "ridge"):
        assert words in text


def test_taxels_and_response_read_alike_from_csv_and_npz(made: Written) -> None:
    folder, ridges = made.folder, made.design.ridge.count
    for name, key in (("taxels", "poses"), ("response", "stress")):
        lines = (folder / f"{name}.csv").read_text().splitlines()
        assert "mm" in " ".join(lines[:3]) or "MPa" in " ".join(lines)
        rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
        arrays = np.load(folder / f"{name}.npz")
        if name == "taxels":
            assert "frame of the design" in lines[0]
            assert [row["name"] for row in rows] == arrays["names"].tolist()
            place = [[float(row[f"{c}_mm"]) for c in "xyz"] for row in rows]
            assert (arrays[key][:, :, 3] == place).all()
            out = [[float(row[f"outward_{c}"]) for c in "xyz"] for row in rows]
            assert (arrays[key][:, :, 2] == out).all()
        else:
            assert arrays[key].shape == (2, ridges, 2 * ridges, 3)
            stress = np.array([float(row["through_film_MPa_per_N"]) for row in rows]).reshape(
                2, ridges, 2 * ridges
            )
            assert stress == pytest.approx(arrays[key][..., 0], rel=1e-8)
            charge = np.array([float(row["charge_pC_per_N"]) for row in rows]).reshape(2, ridges, 2 * ridges)
            assert charge == pytest.approx(arrays["charge"], rel=1e-8)


def test_charge_is_the_films_constants_times_stress_and_area(made: Written) -> None:
    """d33 through the film, d31 along y, d32 along it in the section; MPa mm2 is N, pC/N times N is pC."""
    design, arrays = made.design, np.load(made.folder / "response.npz")
    film, slot = design.film, design.slot
    area = (design.skin.length - 2 * film.margin) * (slot.depth - 2 * film.margin)
    by_part = np.array([film.d33, film.d32, film.d31])
    assert arrays["charge"] == pytest.approx(area * arrays["stress"] @ by_part)


def test_meshes_are_closed_and_each_in_its_unit(made: Written) -> None:
    folder, ridges = made.folder, made.design.ridge.count
    exact = skincad.skin_solid(made.design).val().Volume()
    skin = trimesh.load_mesh(folder / "skin.obj")
    assert skin.is_watertight
    assert skin.volume == pytest.approx(exact, rel=2e-3)
    scene = trimesh.load_scene(folder / "skin.glb")
    assert {*scene.geometry} == {"skin", "carrier"}
    metres = scene.geometry["skin"]
    assert metres.volume * 1e9 == pytest.approx(exact, rel=2e-3)
    assert metres.bounds[1, 1] * 1e3 == pytest.approx(skin.bounds[1, 2], rel=1e-5)  # y is up
    for i in range(1, ridges + 1):
        assert trimesh.load_mesh(folder / f"ridge-{i}.stl").is_convex


@pytest.mark.parametrize("bent", [None, 20.0])
def test_heights_are_those_of_rays_on_the_mesh(bent: float | None) -> None:
    """Rays from above on a mesh within 1e-4 mm; not within a pixel of an end or a side."""
    plain = skincad.load_design("steep-fingertip")
    heights = [plain.ridge.height * share for share in (0.8, 1.0, 0.9)]  # left is not right
    design = plain.with_(skin={"curvature_radius_y": bent}, ridge={"heights": heights})
    image, shape = meshes.height_map(design), mesh(skin_part(design), 1e-4)
    rng = np.random.default_rng(7)
    rows, columns = image.height.shape
    at = np.column_stack([rng.integers(2, rows - 2, 200), rng.integers(2, columns - 2, 200)])
    x = image.corner[0] + at[:, 1] * image.pixel
    y = image.corner[1] - at[:, 0] * image.pixel
    above = np.column_stack([x, y, np.full(200, 100.0)])
    places, ray, _ = shape.ray.intersects_location(above, np.tile([0.0, 0.0, -1.0], (200, 1)))
    top = np.full(200, np.nan)
    np.fmax.at(top, ray, places[:, 2])
    mine = image.height[at[:, 0], at[:, 1]]
    both = ~np.isnan(mine) & ~np.isnan(top)
    assert both.sum() > 150
    assert np.quantile(np.abs(mine - top)[both], 0.98) < 1e-3  # a steep flank within a chord's width


def test_the_image_of_heights_reads_back(made: Written) -> None:
    folder = made.folder
    about = json.loads((folder / "heights.json").read_text())
    with Image.open(folder / "heights.png") as image:
        levels = np.asarray(image)
    heights = meshes.height_map(made.design)
    assert levels.dtype == np.uint16
    assert levels * about["scale_mm"] == pytest.approx(heights.height, abs=0.51 * about["scale_mm"])
    assert levels.max() == 65535


@pytest.mark.slow
@pytest.mark.parametrize("made", ["one ridge"], indirect=True)
def test_the_same_again_is_the_same_bytes(
    made: Written, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Computed again: what patches the program gets nothing that other tests left."""
    assert run_skincad("package", *made.words, "-o", "again", cwd=tmp_path).returncode == 0
    again = tmp_path / "again"
    assert {p.name for p in again.iterdir()} == {p.name for p in made.folder.iterdir()}
    assert [p.name for p in again.iterdir() if p.read_bytes() != (made.folder / p.name).read_bytes()] == []


@pytest.mark.slow
def test_make_takes_a_folder_that_holds_a_package(tmp_path: Path) -> None:
    """Either may come first; each leaves the other's files alone."""
    package = tmp_path / "out" / "steep-fingertip" / "package"
    words = ("package", "steep-fingertip", "--tier", "winkler", "--for")
    assert run_skincad(*words, "mujoco", cwd=tmp_path).returncode == 0
    process = run_skincad("make", "steep-fingertip", "--preview", "--format", "stl", cwd=tmp_path)
    assert (package.parent / "make.json").is_file(), process.stderr
    assert (package / "scene.xml").is_file()
    assert run_skincad(*words, "urdf", cwd=tmp_path).returncode == 0
    assert not (package / "scene.xml").exists()
    assert (package / "skin.urdf").is_file()


def test_a_skin_without_slots_has_files_of_crests_and_says_that_its_films_do_not_feel() -> None:
    package = skincad.package(skincad.load_design("plain-ridges", ["ridge.count=3"]), ["taxels"])
    assert {*package.files()} == {
        *("package.md", "design.toml", "taxels.csv", "taxels.npz", "skin.step", "carrier.step")
    }
    assert package.response is None
    assert "taxels         0 film strips, 3 crests" in str(package)
    assert "no film that is bonded" in str(package)
    bent = skincad.load_design("yamada-2002", ["ridge.count=3", "skin.curvature_radius_y=100"])
    assert "straight along y" in str(skincad.package(bent, ["taxels"]))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--for", "mujocco"), "--for: unknown simulator, got 'mujocco'; did you mean 'mujoco'?"),
        (
            ("--set", "contact.plate.shape=tilted", "--set", "contact.plate.tilt=1"),
            "contact.plate.shape: must be 'flat' for mujoco",
        ),
        (("--tier", "sold"), "--tier: unknown model"),
    ],
)
def test_what_cannot_be_exported_is_refused_in_one_line(
    arguments: tuple[str, ...], words: str, tmp_path: Path
) -> None:
    assert refused_command("package", "yamada-2002", *arguments, cwd=tmp_path).startswith(words)


@pytest.mark.slow
def test_progress_tells_each_check_of_the_springs() -> None:
    stages: list[tuple[str, float | None]] = []
    design = skincad.load("steep-fingertip")
    skincad.package(
        design, "mujoco", model="winkler", progress=lambda stage, left=None, /: stages.append((stage, left))
    )
    assert stages[0] == ("springs", None)
    assert (
        sum(stage.startswith("springs: winkler model") for stage, _ in stages) == 3
    )  # at half and twice too
    assert {left for _, left in stages} == {None}  # of one check, not of the package


@pytest.mark.slow
def test_progress_tells_how_long_a_mesh_of_pins_takes() -> None:
    stages: list[tuple[str, float | None]] = []
    few = [
        "pin.columns=2",
        "pin.rows=1",
        "pin.heights=none",
        "pin.height=4",
        "pin.pocket=none",
        "skin.width=14",
    ]
    design = skincad.load_design("pillars-9", [*few, "skin.length=8"])
    skincad.package(design, "mesh", progress=lambda stage, left=None, /: stages.append((stage, left)))
    assert ("mesh of 2 pins", 2.0) in stages  # about 1 s each


NAMES = ("yamada-2002", "yamada-2002-tilted", "steep-fingertip")


@pytest.mark.parametrize("name", NAMES)
def test_axes_are_right_handed_and_the_third_points_outward(name: str) -> None:
    design = skincad.load_design(name)
    places = taxels.taxels(design)
    turn = places.poses[:, :, :3]
    assert np.linalg.det(turn) == pytest.approx(1.0)
    assert np.einsum("nij,nik->njk", turn, turn) == pytest.approx(np.broadcast_to(np.eye(3), turn.shape))
    assert (turn[:, 2, 2] > 0).all()
    assert turn[:, :, 1] == pytest.approx(np.broadcast_to([0.0, 1.0, 0.0], (len(turn), 3)))


def test_a_tilted_strip_leans_as_its_slot() -> None:
    """45 degrees, tops inward: of the middle ridge S1's outward axis has +x, S2's -x."""
    places = taxels.films(skincad.load_design("yamada-2002-tilted"))
    one, other = (places.poses[places.names.index(f"ridge-5-{side}")][:, 2] for side in ("S1", "S2"))
    assert one == pytest.approx([np.sqrt(0.5), 0.0, np.sqrt(0.5)])
    assert other == pytest.approx([-np.sqrt(0.5), 0.0, np.sqrt(0.5)])


@pytest.mark.parametrize("doubly", [False, True])
@pytest.mark.parametrize("name", ["yamada-2002", "yamada-2002-tilted"])
def test_strips_lie_within_a_micrometre_of_the_slots_in_the_solid(
    name: str, doubly: bool, tmp_path: Path
) -> None:
    """The mean of each slot's four corner edges in the middle of the skin, as read back from STEP."""
    design = skincad.load_design(name, ["ridge.count=2", "skin.width=4"])
    if doubly:
        design = design.with_(skin={"curvature_radius_y": 100.0})
    path = str(tmp_path / "skin.step")
    workplane(skin_part(design)).val().exportStep(path)
    solid = cq.importers.importStep(path).val()
    places = taxels.films(design)
    middle = solid.intersect(cq.Solid.makeBox(40, 1e-3, 20, cq.Vector(-20, -5e-4, -1)))
    faces = [f for f in middle.Faces() if abs(f.normalAt().y) > 0.9 and f.Center().y < 0]
    holes = np.array([wire.Center().toTuple() for face in faces for wire in face.innerWires()])
    assert len(holes) == len(places.names) == 4
    away = np.linalg.norm(places.poses[:, None, :, 3][:, :, [0, 2]] - holes[None][:, :, [0, 2]], axis=2)
    assert away.min(axis=1).max() < 1e-3
    assert len({*away.argmin(axis=1).tolist()}) == 4


def test_without_slots_crests_alone_feel() -> None:
    places = taxels.taxels(skincad.load_design("plain-ridges"))
    assert {*places.kinds} == {"crest"}
    assert len(places.names) == 9
    assert places.poses[4, :, 3] == pytest.approx([0.0, 0.0, 4.5])
    assert re.fullmatch(r"ridge-\d-crest", places.names[0])
