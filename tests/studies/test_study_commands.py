"""Solve and sweep from the command line: words, JSON, files, status."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import skincad
from skincad.base import InputError
from skincad.cli import run

RADIUS = "--vary skin.curvature_radius=20:200 --tier winkler"
SOLVE = f"solve yamada-2002 {RADIUS} --target"
SWEEP = "sweep yamada-2002 --vary skin.length=8:14:4"


def said(capsys: pytest.CaptureFixture[str], command: str) -> tuple[int, str]:
    status = run(command.split())
    return status, capsys.readouterr().out


def test_solve_tells_the_value_and_writes_the_design(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    copy, picture = tmp_path / "solved.toml", tmp_path / "solved.png"
    status, text = said(capsys, f"{SOLVE} all_touch_force=1.5 -o {copy} --picture {picture}")
    assert status == 0
    assert text.startswith("yamada-2002: skin.curvature_radius ")
    assert "gives all_touch_force 1.5 N." in text
    assert text.splitlines()[-1] == f"Next: `skincad check {copy}` judges it by more accurate models."
    assert picture.read_bytes().startswith(b"\x89PNG")
    written = copy.read_text()
    assert "# solved for all_touch_force 1.5 N" in written
    assert "# Fig" in written or "# paper" in written  # the template's own comments stay
    solved = skincad.load_design(copy)
    assert skincad.check(solved, model="winkler").all_touch_force.value == pytest.approx(1.5, rel=5e-3)
    assert solved.with_(skin=dict(skincad.load_design("yamada-2002").skin)) == skincad.load_design(
        "yamada-2002"
    )
    with pytest.raises(InputError, match="exists already"):
        run(f"{SOLVE} approach=1 -o {copy}".split())


def test_solve_without_a_solution_is_status_1_and_writes_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    copy = tmp_path / "solved.toml"
    status, text = said(capsys, f"{SOLVE} all_touch_force=0.1 -o {copy}")
    assert status == 1
    assert "no skin.curvature_radius from 20 to 200 mm gives all_touch_force 0.1 N. The nearest is" in text
    assert not copy.exists()


def test_solve_prints_one_object(capsys: pytest.CaptureFixture[str]) -> None:
    status, text = said(capsys, f"{SOLVE} all_touch_force=1.5 --json")
    data = json.loads(text)
    assert (status, data["feasible"], data["file"]) == (0, True, None)


def test_a_scenes_skin_is_written_with_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A scene's own keys, and those of its skin, which then stands in it."""
    from skincad.outputs import write_solution
    from skincad.studies import Evaluation, Query, Solution, SolutionPoint

    scene = skincad.load_scene("yamada-2002-press")
    for values in ({"effects.friction.coefficient": 0.3}, {"skin.ridge.height": 0.45}):
        one = SolutionPoint(values=values, reached={}, interval={}, nearest={}, passed=None)
        solution = Solution(
            subject=scene,
            question=Query("simulate"),
            target={"steps": 1.0},
            knobs=(),
            solutions=(one,),
            closest=None,
            evaluations=tuple[Evaluation](),
            notes=(),
            seconds=0.0,
        )
        path = tmp_path / f"{next(iter(values))}.toml"
        write_solution(solution, path, "yamada-2002-press")
        assert skincad.load_scene(path).design == solution.solved.design  # type: ignore[union-attr]
        assert skincad.load_scene(path).effects == solution.solved.effects  # type: ignore[union-attr]


@pytest.mark.slow
def test_sweep_writes_its_files_and_goes_on(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = f"{SWEEP} --tier winkler -o {tmp_path / 'out'}"
    status, text = said(capsys, rows)
    assert status == 0
    assert "4 evaluations, 0 reused" in text
    assert "smallest 1" not in text
    assert "smallest 1" in said(capsys, f"{rows} --verbose")[1]
    data = json.loads(said(capsys, f"{rows} --json")[1])
    assert (data["evaluations"], data["reused"]) == (0, 4)
    assert {Path(file["path"]).name for file in data["files"]} >= {"sweep.csv", "study.html", "effects.png"}
    data = json.loads(said(capsys, f"{rows} --json --fresh --rank approach=max")[1])
    assert (data["evaluations"], data["reused"]) == (4, 0)
    assert data["ranked_by"] == [{"key": "approach_mm", "goal": "max"}]


def test_a_sweep_of_refused_rows_alone_is_status_1(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    status, text = said(capsys, f"sweep yamada-2002 --vary skin.width=1,2 --tier winkler -o {out}")
    assert status == 1
    assert "2 refused" in text


def test_bad_input_leaves_a_log_as_it_is(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = f"{SWEEP} -o {tmp_path / 'out'}"
    said(capsys, f"{rows} --tier winkler")
    log = tmp_path / "out" / "evaluations.jsonl"
    before = log.read_bytes()
    for wrong in ("--tier lineer", "--tier winkler --force -1", "--rank x=least"):
        with pytest.raises(InputError):
            run(f"{rows} --fresh {wrong}".split())
        assert log.read_bytes() == before
    said(capsys, f"{rows} --tier winkler --fresh")
    assert log.read_bytes().startswith(before)  # asked anew, and nothing that was finished is lost
    assert len(log.read_bytes().splitlines()) == 8


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (f"--target all_touch_force {RADIUS}", "target: must be KEY=VALUE"),
        (f"--target all_touch_force=a {RADIUS}", "must be a number"),
        (f"--target all_touch_force=nan {RADIUS}", "must be finite"),
        ("--target approach=1 --vary skin.length", "vary: must be KEY=LOW:HIGH"),
        ("--target approach=1 --vary skin.lenth=8:12", "did you mean 'length'"),
        ("--target approach=1 --vary material.name=all --picture x.png", "one key with a range"),
    ],
)
def test_bad_input_is_one_line(arguments: str, says: str) -> None:
    with pytest.raises(InputError) as refused:
        run(f"solve yamada-2002 {arguments}".split())
    assert says in str(refused.value).replace("--", "")
    assert "\n" not in str(refused.value)


def test_a_foreign_folder_is_refused_before_any_work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "mine.txt").write_text("keep")
    monkeypatch.setattr("skincad.sweep", None)
    with pytest.raises(InputError, match="holds files"):
        run(f"{SWEEP} -o {tmp_path}".split())
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]
