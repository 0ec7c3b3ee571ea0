"""A workshop's own processes: how they reach a design, and how a bad file is refused."""

import shutil
import tomllib
from pathlib import Path

import pytest

import skincad
from skincad.base import InputError
from skincad.inputs import PROCESSES, processes, table_text
from skincad.mechanics import spread_of
from tests.conftest import run_skincad
from tests.processes import python
from tests.refusals import refused, refused_command

ROOT = Path(skincad.__file__).parents[1]
OWN = """
[sla]
pixel = 0.035
crest_sigma = 0.02

[my-mill]
based_on = "cnc"
tool_radius = 0.1
"""


@pytest.fixture
def printer(tmp_path: Path) -> Path:
    path = tmp_path / "printer.toml"
    path.write_text(OWN)
    return path


def test_every_shipped_value_is_a_key_with_a_source() -> None:
    assert tuple(processes()) == PROCESSES
    rows = [row for row in table_text("processes").splitlines() if " = " in row and not row.startswith("#")]
    assert len(rows) == sum(len(table) for table in tomllib.loads(table_text("processes")).values())
    assert all("# assumption" in row or "# source" in row for row in rows)


def test_an_own_file_changes_what_it_names_and_no_more(printer: Path) -> None:
    design = skincad.load("lab-bench", printer=printer)
    known, shipped = processes(design.printer), processes()
    assert known["sla"] == shipped["sla"].model_copy(update={"pixel": 0.035, "crest_sigma": 0.02})
    assert known["my-mill"] == shipped["cnc"].model_copy(update={"tool_radius": 0.1})
    assert known["edm"] == shipped["edm"]
    assert spread_of(design).crest_sigma == 0.02


def test_the_design_carries_it_without_the_file(printer: Path) -> None:
    design = skincad.load("lab-bench", ["mold.process=my-mill"], printer=printer)
    assert design.with_(ridge={"height": 1.01}).printer == design.printer
    assert skincad.Design.model_validate(design.model_dump(exclude_none=True)) == design
    assert design.model_dump()["printer"] == tomllib.loads(OWN)
    assert hash(design) == hash(design.with_())
    assert design != design.with_(printer={"my-mill": {"based_on": "edm"}})


def test_the_command_lines_keys_come_last(printer: Path) -> None:
    design = skincad.load("lab-bench", ["printer.sla.pixel=0.01"], printer=printer)
    assert processes(design.printer)["sla"].pixel == 0.01
    assert processes(design.printer)["sla"].crest_sigma == 0.02


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[sla]\npixl = 1.0", "printer.sla.pixl: unknown key; did you mean 'pixel'?"),
        ("[sla]\npixel = -1.0", "printer.sla.pixel: must be greater than or equal to 0 (mm), got -1"),
        ("[sla]\npixel = nan", "printer.sla.pixel: must be a finite number (mm), got nan"),
        ("[mine]\npixel = 1.0", "printer.mine.based_on: is missing for a new process; name fdm, sla"),
        ("[mine]\nbased_on = 'x'", "printer.mine.based_on: must be 'fdm', 'sla', 'cnc' or 'edm', got 'x'"),
        ("[sla]\nbased_on = 'cnc'", "printer.sla.based_on: must not be given for sla, got 'cnc'"),
        ("['a b c']\nbased_on = 'cnc'", "printer: the name must be 3 to 32 lower-case letters"),
        ('["abc\\n"]\nbased_on = "cnc"', "printer: the name must be 3 to 32 lower-case letters"),
        ("pixel = 1.0", "printer.pixel: must be a table, [printer.pixel], got 1"),
        ("[sla", "printer.toml: is not TOML"),
    ],
)
def test_a_bad_file_is_refused_in_one_line(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "printer.toml"
    path.write_text(text)
    with refused(message):
        skincad.load("lab-bench", printer=path)


def test_a_process_is_shipped_or_ones_own(printer: Path) -> None:
    with pytest.raises(InputError, match="'edm' or 'my-mill', got 'my-mil'"):
        skincad.load("lab-bench", ["mold.end_plate_process=my-mil"], printer=printer)


def test_the_command_line_takes_a_printer_and_refuses_a_bad_one(tmp_path: Path, printer: Path) -> None:
    good = run_skincad("check", "plain-ridges", "--tier", "winkler", "--printer", str(printer), cwd=tmp_path)
    assert good.returncode in (0, 1), good.stderr
    printer.write_text("[sla]\npixl = 1.0")
    for command in ("check", "make"):
        message = refused_command(command, "plain-ridges", "--printer", str(printer), cwd=tmp_path)
        assert message == "printer.sla.pixl: unknown key; did you mean 'pixel'?"
    message = refused_command("make", "plain-ridges", "--printer", "none.toml", cwd=tmp_path)
    assert "none.toml: cannot be read" in message


LASER = """
[laser]
tool = "wire"            # assumption
tolerance = 0.02         # assumption
"""


@pytest.mark.slow  # a copy of the package in its own process
def test_a_new_shipped_process_needs_its_table_only(tmp_path: Path) -> None:
    """No file of ours names a process: a copy of the package with one more table knows it."""
    for folder in ("skincad", "templates"):
        shutil.copytree(ROOT / folder, tmp_path / folder, ignore=shutil.ignore_patterns("__pycache__"))
    with (tmp_path / "templates" / "processes.toml").open("a") as table:
        table.write(LASER)
    code = (
        "import skincad; from skincad.fabrication.findings import design_findings;"
        "from skincad.fabrication.job import Job;"
        "bent = ['skin.curvature_radius_y=40', 'mold.process=laser'];"
        "findings = design_findings(Job(skincad.load('plain-ridges', bent)));"
        "print([f.remedy for f in findings if f.rule == 'tool reach']);"
        "skincad.load('lab-bench', ['printer.mine.based_on=laser', 'mold.process=mine']);"
        "print('laser' in str(skincad.Design.model_json_schema()['$defs']['Mold']))"
    )
    result = python(code, cwd=tmp_path, PYTHONPATH=str(tmp_path))
    assert result.returncode == 0, result.stderr
    assert "mill, sink-erode or print it" in result.stdout
    assert result.stdout.endswith("True\n")
