"""The command line as a user meets it; in its own process where what is shown is the process's."""

from __future__ import annotations

import json
import os
import shlex
import signal
import subprocess
import sys
import time
from contextlib import chdir
from pathlib import Path

import pytest
import typer

from skincad.base import InputError, checked_folder
from skincad.cli import run
from skincad.cli.app import app
from tests.conftest import run_skincad, skincad_process
from tests.processes import started
from tests.refusals import refused_command

CHECK_KEYS = {
    *("name", "passed", "force_N", "ridges", "touching", "all_touch_force_N", "approach_mm"),
    *("ridge_force_N", "tier", "unknowns", "residual", "yield", "seconds", "warnings"),
}
ONE_RIDGE = ("--set", "ridge.count=1", "--set", "skin.width=3.0", "--set", "contact.force=0.4")
BY_FORM = ("--model", "winkler")  # where the verdict is not what is looked at
MAKE_KEYS = {"name", "passed", "files", "parts", "findings", "check", "seconds"}
LONG = "x" * 300
PART_KEYS = {"name", "volume_mm3", "area_mm2", "faces", "valid", "watertight", "deviation_mm"}


@pytest.mark.slow
def test_make_prints_the_contracts_json_and_writes_what_it_lists(tmp_path: Path) -> None:
    done = run_skincad("make", "plain-ridges", *ONE_RIDGE, *BY_FORM, "--json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    result = json.loads(done.stdout)
    assert result.keys() >= MAKE_KEYS
    assert all(part.keys() >= PART_KEYS for part in result["parts"])
    assert result["check"].keys() >= CHECK_KEYS
    assert result["passed"]
    assert all((tmp_path / file["path"]).stat().st_size == file["bytes"] for file in result["files"])
    folder = Path("out", "plain-ridges")
    below = {folder, folder / "solids", folder / "drawings", folder / "orders"}
    assert {Path(f["path"]).parent for f in result["files"]} == below
    assert all(part["deviation_mm"] <= part["asked_deviation_mm"] for part in result["parts"])
    assert done.stderr == ""


def test_check_prints_the_contracts_json(tmp_path: Path) -> None:
    done = run_skincad("check", "yamada-2002", "--json", "--tier", "winkler", "--no-advice", cwd=tmp_path)
    result = json.loads(done.stdout)
    assert result.keys() >= CHECK_KEYS
    assert result["all_touch_force_N"].keys() == {"value", "error"}
    assert result["tier"] == "winkler"
    assert len(result["ridge_force_N"]) == result["ridges"] == 9
    assert list(tmp_path.iterdir()) == []


def test_a_failed_verdict_exits_with_1(tmp_path: Path) -> None:
    done = run_skincad("check", "yamada-2002", "--force", "1.0", "--tier", "winkler", "--json", cwd=tmp_path)
    assert done.returncode == 1
    assert json.loads(done.stdout)["passed"] is False


@pytest.mark.slow
def test_a_format_is_written_alone(tmp_path: Path) -> None:
    done = run_skincad(
        "make", "plain-ridges", *ONE_RIDGE, *BY_FORM, "--format", "dxf", "-o", "here", cwd=tmp_path
    )
    assert done.returncode == 0
    drawn = {p.name for p in (tmp_path / "here" / "drawings").iterdir()}
    made = {f"{part}.dxf" for part in ("carrier", "cavity", "cover", "end-a", "end-b", "assembly")}
    assert drawn == {"section.dxf", "seal.dxf", *made}
    assert {p.name for p in (tmp_path / "here").iterdir()} == {"make.json", "drawings"}


BAD = {  # numbers of options, files and names that mean harm: tests/attacks
    "make yamada-2002 --set ridge.heigth=0.6": "ridge.heigth: unknown key; did you mean 'height'?",
    "make yamada-2002 --set 'ridge.height=0.6 mm'": "ridge.height: must be a number (mm)",
    "make yamada-2002 --set ridge.height=nan": "ridge.height: must be a finite number",
    "make yamada-2002 --set ridge.height=-1.0": "ridge.height: must be greater than 0",
    "make yamada-2002 --set ridge.root_width=1.2": "ridge.root_width: must be less than 1 mm",
    "make yamada-2002 --set slot.offset=0.4": "slot: must lie inside the outline",
    "make yamada-2002 --set ridge.count=1000000000": "ridge.count: must be less than or equal to 999",
    "make yamada-2003": "yamada-2003: no such template among designs, and no TOML file",
    "make missing.toml": "missing.toml: cannot be read (No such file or directory)",
    "make syntax.toml": "syntax.toml: is not TOML",
    "make deep.toml": "deep.toml: is not TOML",
    "make large.toml": "large.toml: must be at most 1000000 bytes",
    "make binary.toml": "binary.toml: is not UTF-8 text",
    "make .": ".: no such template",
    f"make {LONG}": "xxxxxxxx",
    "make pipe.toml": "pipe.toml: is not a regular file",
    "make yamada-2002 -o file": "-o: file is a file",
    "make yamada-2002 -o .": "-o: . is the folder you are in",
    f"make yamada-2002 -o {LONG}": "-o: xxxxxxxx",
    "make yamada-2002 -o file/x": "-o: ",
    "make yamada-2002 -o /proc/x": "-o: ",
    "make yamada-2002 --format stp": "--format: unknown format, got 'stp'; did you mean 'step'?",
    f"new {LONG}.toml": "FILE: xxxxxxxx",
    "new file": "FILE: file exists already",
    "check yamada-2002 --force 1e300": "--force: must be above 0 N and at most 1e+06 N",
    "check yamada-2002 --tier wincler": "--tier: unknown model, got 'wincler'; did you mean 'winkler'?",
    "check yamada-2002 --tier solid-finite": "--tier: unknown model",
    "check yamada-2002 --pull 1": "--pull: needs --stress",
    "check plain-ridges --stress s.png": "slot: ",
    "check yamada-2002 --stress s.pdf": "--stress: s.pdf must end in .png",
    "check yamada-2002 --tol 0": "--tol: must be between 0 and 1",
    "mkae": "No such command 'mkae'",
    "make": "Missing argument",
    "make yamada-2002 --bogus": "No such option",
}


@pytest.mark.parametrize("line", BAD)
def test_bad_input_is_one_line_and_exit_2_and_no_file(line: str, tmp_path: Path) -> None:
    (tmp_path / "syntax.toml").write_text("[ridge\nheight = 1")
    (tmp_path / "deep.toml").write_text("a = " + "[" * 100_000)
    (tmp_path / "large.toml").write_text("# padding\n" * 1_000_000)
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    (tmp_path / "file").write_text("")
    os.mkfifo(tmp_path / "pipe.toml")
    assert refused_command(*shlex.split(line), cwd=tmp_path).startswith(BAD[line])


@pytest.mark.slow
@pytest.mark.dear("a process that imports the CAD kernel and is stopped while it makes")
def test_ctrl_c_exits_with_130_and_leaves_no_half_result(tmp_path: Path) -> None:
    words = [
        sys.executable,
        "-c",
        "from skincad.cli import main; main()",
        "make",
        "yamada-2002",
        *ONE_RIDGE,
        *BY_FORM,
    ]
    pipes = {"stderr": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    with started(words, cwd=tmp_path, **pipes) as running:
        deadline = time.monotonic() + 60
        staging = "out/yamada-2002/.skincad-make-*/new"
        while not list(tmp_path.glob(staging)) and time.monotonic() < deadline and running.poll() is None:
            time.sleep(0.01)
        running.send_signal(signal.SIGINT)
        out, err = running.communicate(timeout=60)
    assert (running.returncode, out) == (130, ""), err
    assert "Traceback" not in err
    assert not list(tmp_path.iterdir())


def test_version_and_help(tmp_path: Path) -> None:
    import skincad

    assert skincad_process("--version", cwd=tmp_path).stdout == f"skincad {skincad.__version__}\n"
    text = run_skincad("--help", cwd=tmp_path).stdout
    assert all(word in text for word in ("templates", "new", "make", "check"))


def test_templates_are_listed_with_what_they_are_for(tmp_path: Path) -> None:
    rows = run_skincad("templates", cwd=tmp_path).stdout.splitlines()
    assert any(row.split()[:2] == ["design", "yamada-2002"] for row in rows)
    assert all(len(row.split(maxsplit=2)) == 3 for row in rows)
    assert "yamada-2002" in json.loads(run_skincad("templates", "--json", cwd=tmp_path).stdout)["designs"]


@pytest.mark.slow
def test_no_colour_and_no_bar_off_a_terminal(tmp_path: Path) -> None:
    done = skincad_process("check", "plain-ridges", *ONE_RIDGE, *BY_FORM, cwd=tmp_path)
    assert done.stderr == ""
    assert "\x1b" not in done.stdout


def test_each_command_that_has_o_has_out() -> None:
    """And calls it so where neither was written."""
    commands = typer.main.get_command(app).commands  # type: ignore[attr-defined]
    flags = {
        name: [option.opts for option in command.params if {"-o", "--out"} & {*option.opts}]
        for name, command in commands.items()
    }
    assert {name for name, found in flags.items() if found} == {
        *("make", "watch", "coupon", "package", "circuit", "simulate", "accuracy", "fit-material"),
        *("solve", "sweep", "optimise"),
    }
    assert all(found in ([], [["-o", "--out"]]) for found in flags.values())


def test_out_is_o(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    for flag in ("-o", "--out"):
        done = run_skincad("circuit", "yamada-2002", flag, "file", cwd=tmp_path)
        assert (done.returncode, done.stderr) == (2, f"skincad: {flag}: file is a file; name a folder\n")


def test_a_working_directory_that_was_deleted(tmp_path: Path) -> None:
    """An out folder that is given whole needs none; one that counts from it is refused."""
    gone = tmp_path / "gone"
    gone.mkdir()
    with chdir(gone):
        gone.rmdir()
        run(["circuit", "yamada-2002", "--out", str(tmp_path / "here")])
        assert (tmp_path / "here" / "gain.csv").is_file()
        with pytest.raises(InputError, match="folder: here cannot be written"):
            checked_folder(Path("here"), "circuit")


def test_at_and_set_of_the_same_steps_are_one_line(tmp_path: Path) -> None:
    for flag, key in ((("--at", "1"), "readout.steps=[2]"), (("--gif",), "readout.frames=3")):
        done = run_skincad("simulate", "steady-pull", *flag, "--set", key, cwd=tmp_path)
        told = (
            f"skincad: {flag[0]}: gives {key.partition('=')[0]}, and --set does too; leave one of them out\n"
        )
        assert (done.returncode, done.stderr) == (2, told)
    assert not list(tmp_path.iterdir())
