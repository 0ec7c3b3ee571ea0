"""The command coupon, from its parts to a printer.toml: files whole or not at all, bad input in one line."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

import cadquery
import pytest
import trimesh

from skincad.fabrication.coupon import coupon
from skincad.inputs import NOTCH_FORM
from tests.conftest import run_skincad
from tests.fabrication.test_coupon_reading import fill
from tests.outputs.test_export import read_3mf
from tests.refusals import refused_command

PARTS = {part.name: part for part in coupon("sla").parts}


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a coupon of `sla`."""
    folder = tmp_path_factory.mktemp("coupon")
    process = run_skincad("coupon", "sla", "--json", cwd=folder)
    assert process.returncode == 0, process.stderr
    answer = json.loads(process.stdout)
    out = folder / "out" / "coupon-sla"
    assert {Path(row["path"]).name for row in answer["files"]} == {
        *(path.name for path in out.iterdir() if path.name != "coupon.json")
    }
    assert [row["name"] for row in answer["parts"]] == [*PARTS]
    return out


@pytest.mark.parametrize("name", PARTS)
def test_each_part_reads_back_as_one_valid_solid_and_a_closed_mesh(name: str, made: Path) -> None:
    """The kernel's volume within the 1e-7 mm that STEP's tolerance leaves on a surface; single precision and
    chords within 0.005 mm on the mesh's."""
    part = PARTS[name]
    (solid,) = cadquery.importers.importStep(str(made / f"{name}.step")).solids().vals()
    assert solid.isValid()
    assert solid.Volume() == pytest.approx(part.volume, abs=1e-7 * solid.Area())
    shape = trimesh.load_mesh(made / f"{name}.stl")
    assert shape.is_watertight
    assert abs(shape.volume - part.volume) <= 0.005 * shape.area
    assert shape.bounds[0][2] == pytest.approx(0.0, abs=1e-6)  # on the bed


def test_the_ladder_lies_on_its_face_and_the_steps_stand(made: Path) -> None:
    assert trimesh.load_mesh(made / "notch-ladder.stl").extents[2] == pytest.approx(4.0)
    assert trimesh.load_mesh(made / "crest-steps.stl").extents[2] == pytest.approx(5.0 + 1.31, abs=1e-5)


def test_all_parts_are_on_one_plate(made: Path) -> None:
    objects, names = read_3mf(made / "coupon.3mf").GetMeshObjects(), []
    while objects.MoveNext():
        names.append(objects.GetCurrentMeshObject().GetName())
    assert names == [*PARTS]


@pytest.mark.slow
def test_filled_in_forms_become_a_printers_file(made: Path, tmp_path: Path) -> None:
    fill(tmp_path)
    process = run_skincad("coupon", "sla", "--measured", str(tmp_path), "-o", "mine", cwd=tmp_path)
    assert process.returncode == 0, process.stderr
    assert "growth         0.0294 ± 0.00" in process.stdout
    assert f"skincad fit-material {tmp_path / 'tensile.csv'} --gauge-length 20 --area 8" in process.stdout
    row = tomllib.loads((tmp_path / "mine" / "printer.toml").read_text())
    assert row["sla"]["growth"] == 0.0294
    by_sla = ("--set", "mold.end_plate_process=sla", "--set", "mold.slit_clearance=0.028", "--preview")
    words = ("make", "lab-bench", *by_sla, "--printer", "mine/printer.toml", "--format", "toml")
    process = run_skincad(*words, cwd=tmp_path)
    assert "notch of a shim in whole pixels and grown, by sla" in process.stdout


def test_the_forms_that_were_filled_in_are_kept(tmp_path: Path) -> None:
    """printer.toml goes beside them; the coupon is not made again over them."""
    assert run_skincad("coupon", "cnc", "-o", "c", cwd=tmp_path).returncode == 0
    fill(tmp_path / "c", growth=None)
    for _ in range(2):  # again over its own result
        process = run_skincad("coupon", "cnc", "--measured", "c", cwd=tmp_path)
        assert process.returncode == 0, process.stderr
    assert (tmp_path / "c" / "printer.toml").exists()
    assert "was changed since" in refused_command("coupon", "cnc", "-o", "c", cwd=tmp_path)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["slb"], "PROCESS: unknown process, got 'slb'; did you mean 'sla'?"),
        (["sla", "--silicone", "dragonskin-10"], "--silicone: unknown silicone"),
        (["sla", "--printer", "none.toml"], "none.toml"),
        (["sla", "--measured", "nowhere"], "--measured: must hold notches.csv or crests.csv"),
        (["sla", "--measured", "forms"], "row 2: goes_mm is empty; measure it"),
        (["sla", "--measured", "forms", "--silicone", "rtv615"], "--silicone: is not used with --measured"),
    ],
)
def test_bad_input_is_one_line_and_nothing_is_written(
    arguments: list[str], words: str, tmp_path: Path
) -> None:
    (tmp_path / "forms").mkdir()
    fill(tmp_path / "forms")
    text = (tmp_path / "forms" / NOTCH_FORM).read_text().splitlines()
    (tmp_path / "forms" / NOTCH_FORM).write_text("\n".join([*text[:2], "2,0.08,,", *text[3:]]))
    before = sorted(tmp_path.rglob("*"))
    process = run_skincad("coupon", *arguments, cwd=tmp_path)
    assert (process.returncode, process.stdout) == (2, "")
    assert words in process.stderr
    assert len(process.stderr.splitlines()) == 1
    assert sorted(tmp_path.rglob("*")) == before


def test_a_changed_ladder_writes_nothing(tmp_path: Path) -> None:
    fill(tmp_path)
    text = (tmp_path / NOTCH_FORM).read_text().replace("3,0.10,", "3,0.99,")
    (tmp_path / NOTCH_FORM).write_text(text)
    before = sorted(tmp_path.iterdir())
    process = run_skincad("coupon", "sla", "--measured", ".", cwd=tmp_path)
    assert (process.returncode, process.stdout) == (2, "")
    words = "skincad: notches.csv, row 3: drawn_mm of notch 3 must be 0.1, as drawn, got 0.99; restore"
    assert process.stderr.startswith(words)
    assert len(process.stderr.splitlines()) == 1
    assert sorted(tmp_path.iterdir()) == before
