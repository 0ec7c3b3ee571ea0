"""Sweeps: rows of a grid or of a sample, their ranking, as table, arrays and words."""

from __future__ import annotations

import csv
import io
import json
import math
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest

import skincad
from skincad.base import Estimate, InputError
from skincad.cli import run
from skincad.outputs import pareto, sweep_csv, sweep_names, sweep_page
from skincad.studies import Evaluation, SweepResult, model_error, points_of, sweep
from skincad.studies.sweeping import OWN, difference_error, ranking

KEY = "all_touch_force_N"
Goal = Literal["min", "max"]


def row(
    value: float | None,
    error: float | None,
    error_of_model: float = 0.0,
    model: str = "linear",
    refused: str = "",
) -> Evaluation:
    table = {KEY: Estimate(value, error, "N"), "model_error_N": Estimate(error_of_model, None, "N")}
    return Evaluation(str(value), {}, table, None, refused, model)


def test_what_two_designs_share_of_a_models_error_is_none_of_their_difference() -> None:
    a, b = row(2.0, 0.53, 0.5), row(2.4, 0.64, 0.6)
    by_hand = math.hypot(0.03, 0.04) + 0.1 + OWN * math.hypot(0.5, 0.6)
    assert difference_error(a, b, KEY) == pytest.approx(by_hand)
    assert by_hand < math.hypot(0.53, 0.64)
    other = row(2.4, 0.64, 0.6, "corrected")
    assert difference_error(a, other, KEY) == pytest.approx(math.hypot(0.53, 0.64))
    # the approach has its model's part too
    table = {"approach_mm": Estimate(0.2, 0.05, "mm"), "left_out.friction.approach": Estimate(0.1, None, "")}
    table["left_out.finite strain.approach"] = Estimate(0.05, None, "")
    assert model_error(Evaluation("", {}, table), "approach_mm") == pytest.approx(0.03)
    table |= {"cutoff_Hz": Estimate(1.0, 0.1, "Hz")}
    assert model_error(Evaluation("", {}, table), "cutoff_Hz") == 0.0


def wins(rows: list[Evaluation], goal: Goal = "min") -> dict[int, int]:
    """Return how many rows each row surely beats."""
    return {rank.row: rank.wins for rank in ranking(rows, KEY, goal).ranks}


def test_a_row_wins_beyond_the_error_of_the_difference() -> None:
    assert wins([row(1.0, 0.1), row(1.2, 0.1)]) == {1: 1, 2: 0}  # 0.2 against 0.141
    assert wins([row(1.0, 0.1), row(1.1, 0.1)]) == {1: 0, 2: 0}
    assert wins([row(1.2, 0.1), row(1.0, 0.1)], "max") == {1: 1, 2: 0}
    # an unknown error makes nothing sure
    assert difference_error(row(1.0, None), row(2.0, 0.1), KEY) is None
    assert wins([row(1.0, None), row(2.0, 0.1)]) == {1: 0, 2: 0}
    assert wins([row(None, None), row(2.0, 0.1)]) == {2: 0}
    # of a chain each ties with the next, but not all with the first
    answer = ranking([row(1.0, 0.1), row(1.1, 0.1), row(1.2, 0.1), row(1.3, 0.1)], KEY, "min")
    assert answer.ties == ((1, 2), (3, 4))


def test_rows_are_ranked_with_what_they_beat_and_what_ties() -> None:
    rows = [row(3.0, 0.1), row(1.0, 0.1), row(1.05, 0.1)]
    rows += [row(None, None), row(0.5, 0.1, refused="no"), row(2.0, 0.1)]
    answer = ranking(rows, "all_touch_force", "min")
    assert answer.key == KEY
    assert [(rank.row, rank.wins) for rank in answer.ranks] == [(2, 2), (3, 2), (6, 1), (1, 0)]
    assert answer.ties == ((2, 3),)
    most = ranking(rows, KEY, "max")
    assert [(rank.row, rank.wins) for rank in most.ranks] == [(1, 3), (6, 2), (3, 0), (2, 0)]
    with pytest.raises(InputError, match="rank approach: no such number"):
        ranking([row(1.0, 0.1)], "approach", "min")
    with pytest.raises(InputError, match="KEY=min or KEY=max"):
        ranking([row(1.0, 0.1)], KEY, "least")
    assert ranking([], KEY, "min").ranks == ()
    points = np.array([[0.0, 3.0], [1.0, 1.0], [2.0, 2.0], [3.0, 0.0], [1.0, 1.0], [0.0, 4.0]])
    assert pareto(points).tolist() == [True, True, False, True, True, False]


DESIGN = skincad.load_design("yamada-2002")
VARY: dict[str, Any] = {"skin.length": (8.0, 14.0, 4), "material.name": "dragon-skin-20,dragon-skin-30"}


@pytest.fixture(scope="module")
def swept() -> SweepResult:
    rank = {"all_touch_force": "min", "approach": "max"}
    return sweep(DESIGN, {**VARY, "skin.width": [11.0, 2.0]}, model="winkler", rank=rank)


def test_a_grid_is_every_combination_in_order_and_ranked(swept: SweepResult) -> None:
    assert len(swept.rows) == 4 * 2 * 2
    assert [row.values["skin.length"] for row in swept.rows[::4]] == [8.0, 10.0, 12.0, 14.0]
    for row in swept.rows:
        if row.refused:
            assert row.values["skin.width"] == 2.0
            continue
        length, name = row.values["skin.length"], row.values["material.name"]
        design = DESIGN.with_(skin={"length": length}, material={"name": name})
        assert row.results["all_touch_force_N"] == skincad.check(design, model="winkler").all_touch_force
    assert swept.refused == 8
    first, second = swept.rankings
    assert len(first.ranks) == 8
    best = swept.best()
    assert best.values == {"skin.length": 8.0, "material.name": "dragon-skin-20", "skin.width": 11.0}
    assert (second.key, second.goal) == ("approach_mm", "max")
    with pytest.raises(InputError):
        swept.best(9)


def test_a_sample_fills_the_ranges_and_is_the_same_each_time() -> None:
    vary = {"skin.length": (8.0, 14.0), "skin.curvature_radius": (20.0, 200.0)}
    vary |= {"material.name": "all", "ridge.count": (5, 9)}
    points = points_of(DESIGN, vary, 200)
    assert points == points_of(DESIGN, vary, 200)
    assert len(points) == 200
    lengths = np.array([float(point["skin.length"]) for point in points])
    assert np.histogram(lengths, 8, (8, 14))[0].min() >= 20  # of 25; random ones would leave 14
    radii = np.array([float(point["skin.curvature_radius"]) for point in points])
    assert np.median(radii) == pytest.approx(np.sqrt(20 * 200), rel=0.1)  # by ratios
    assert {point["ridge.count"] for point in points} == {5, 6, 7, 8, 9}
    assert len({point["material.name"] for point in points}) == 10


def test_table_arrays_frame_and_json_have_all_that_is_known(swept: SweepResult) -> None:
    rows = list(csv.DictReader(io.StringIO(sweep_csv(swept))))
    assert len(rows) == len(swept.rows)
    for told, row in zip(rows, swept.rows, strict=True):
        assert told["material.name"] == row.values["material.name"]
        assert told["refused"] == row.refused
        if not row.refused:
            assert float(told["all_touch_force_N"]) == row.results["all_touch_force_N"].value
            assert float(told["all_touch_force_N.error"]) == row.results["all_touch_force_N"].error
    assert not {"seconds.total", "cause"} & rows[0].keys()
    arrays = swept.arrays()
    force = arrays["all_touch_force_N"]
    assert np.isnan(force).sum() == swept.refused
    assert arrays["all_touch_force_N.error"].shape == force.shape == (16,)
    frame = swept.frame()
    assert list(frame["skin.length"]) == [row.values["skin.length"] for row in swept.rows]
    named = swept.to_frame()
    assert list(named["skin.length_mm"]) == list(frame["skin.length"])
    assert named.shape == frame.shape
    data = json.loads(json.dumps(swept.as_json(), allow_nan=False))
    assert {"rows", "ranking", "ties", "evaluations", "reused", "seconds"} <= data.keys()
    assert {"values", "results", "passed", "refused"} <= data["rows"][0].keys()
    assert data["rows"][0]["results"]["all_touch_force_N"].keys() == {"value", "error"}
    first = swept.rankings[0].ranks[0]
    assert data["ranking"][0] == {"row": first.row, "wins": first.wins}
    assert data["evaluations"] == 16


def test_words_say_the_best_the_ties_and_why_rows_are_refused(swept: SweepResult) -> None:
    first, sure, rows, last = str(swept).splitlines()
    assert first.startswith("yamada-2002: row 1 has the smallest all_touch_force 0.")
    assert first.endswith("skin.length 8, material.name dragon-skin-20, skin.width 11.")
    words = "surely better than 0 of the other 7 rows; not surely better than rows "
    assert sure.startswith(f"  how sure       {words}")
    assert rows.startswith("  rows           16 by winkler: ")
    assert "8 refused" in rows
    assert last.startswith("Next: the same sweep with `--model ")
    text = swept.details()
    assert "smallest 1" in text
    assert "largest 1" in text
    assert "is not surely better than" in text
    assert "refused        8; the first: ridge.count" in text
    # refusals that differ in their numbers are counted together
    text = str(sweep(DESIGN, {"ridge.pitch": [0.2, 0.3]}, model="winkler"))
    assert text.count("  refused ") == 1
    assert "refused        2; the first: ridge.root_width" in text


@pytest.mark.slow
def test_all_files_are_written_and_the_log_stays(tmp_path: Path) -> None:
    folder = tmp_path / "study"
    swept_rows = sweep(DESIGN, VARY, model="winkler", folder=folder)
    written = skincad.write(swept_rows, folder)
    there = {path.name for path in folder.iterdir()}
    assert there == {*sweep_names(), "sweep.json", "evaluations.jsonl", ".skincad-claims"} - {"front.png"}
    assert {name for name, _ in written.files} <= there
    again = sweep(DESIGN, VARY, model="winkler", folder=folder)
    assert (again.evaluations, again.reused) == (0, 8)
    skincad.write(again, folder)
    from pyarrow import parquet

    columns = parquet.read_table(folder / "sweep.parquet").to_pydict()
    assert columns["skin.length"] == [row.values["skin.length"] for row in swept_rows.rows]


def test_the_page_needs_nothing_else_and_has_every_design(swept: SweepResult) -> None:
    page = sweep_page(swept)
    assert "http" not in page.replace("http://www.w3.org/2000/svg", "")
    assert page.count("<script") == 2
    data = json.loads(page.partition('id="data">')[2].partition("</script>")[0])
    assert len(data["designs"]) == len(data["rows"]) == 16
    assert "length = 8.0" in data["designs"][0]
    assert data["designs"][1].startswith("# ridge.count: at most 2 ridges")
    assert data["head"][data["y"]] == "all_touch_force_N"
    varied = [knob.key for knob in swept.knobs]
    assert data["head"][: len(varied) + 2] == ["row", *varied, "all_touch_force_N"]  # what counts, first
    for column in zip(*data["rows"], strict=True):
        assert any(value not in (None, "") for value in column)
    aimed = sweep_page(swept, ["words"], title="other", aims=["approach_mm"])
    assert "<title>other: 16 rows</title>" in aimed
    data = json.loads(aimed.partition('id="data">')[2].partition("</script>")[0])
    assert data["head"][len(varied) + 1] == "approach_mm"


def test_scenes_and_circuits_are_swept_too() -> None:
    vary = {"amplifier.feedback_resistance": (1e7, 1e9, 3)}
    swept_rows = sweep(skincad.load_circuit("transimpedance"), vary, rank={"cutoff": "max"})
    assert swept_rows.question.kind == "circuit"
    assert not swept_rows.refused
    assert swept_rows.next_model is None


@pytest.mark.parametrize(
    ("vary", "options", "says"),
    [
        ({}, {}, "names no key"),
        ({"skin.length": (8, 12)}, {}, "needs a number of values"),
        ({"skin.length": (8, 12)}, {"sample": 0}, "must be from 1"),
        ({"skin.length": (8, 12, 400), "skin.width": (11, 12, 400)}, {}, "at most 100000 rows"),
        ({"skin.length": (8, 12, 2)}, {"model": "lineer"}, "did you mean 'linear'"),
        ({"skin.length": (8, 12, 2)}, {"force": -1.0}, "force"),
        ({"skin.length": (8, 12, 2)}, {"workers": 0}, "workers"),
        ({"skin.length": (8, 12, 2)}, {"rank": {"all_touch_force": "least"}}, "KEY=min or KEY=max"),
        ({"skin.length": (8, 12, 2)}, {"tol": 2.0}, "tol"),
        ({"skin.length": (8, 12, 2)}, {"rank": {"all_touch_forc": "min"}}, "did you mean 'all_touch_force'"),
    ],
)
def test_what_can_not_be_asked_is_said(vary: dict[str, Any], options: dict[str, Any], says: str) -> None:
    with pytest.raises(InputError, match=says):
        sweep(DESIGN, vary, **{"model": "winkler", **options})


SWEEP = "sweep yamada-2002 --tier winkler --vary skin.length=8:14:4"


def said(capsys: pytest.CaptureFixture[str], command: str) -> tuple[int, str]:
    status = run(command.split())
    return status, capsys.readouterr().out


@pytest.mark.slow
def test_sweep_writes_its_files_and_goes_on(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = f"{SWEEP} -o {tmp_path / 'out'}"
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


def test_a_sweep_without_results_is_status_1(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out"
    status, text = said(capsys, f"sweep yamada-2002 --vary skin.width=1,2 --tier winkler -o {out}")
    assert status == 1
    assert "2 refused" in text


def test_bad_input_leaves_a_log_and_foreign_files_as_they_are(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    rows = f"{SWEEP} -o {tmp_path / 'out'}"
    said(capsys, rows)
    log = tmp_path / "out" / "evaluations.jsonl"
    before = log.read_bytes()
    for wrong in ("--tier lineer", "--force -1", "--rank x=least"):
        with pytest.raises(InputError):
            run(f"{rows} --fresh {wrong}".split())
        assert log.read_bytes() == before
    said(capsys, f"{rows} --fresh")
    assert log.read_bytes().startswith(before)  # asked anew, and nothing that was finished is lost
    assert len(log.read_bytes().splitlines()) == 8
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "mine.txt").write_text("keep")
    monkeypatch.setattr("skincad.sweep", None)
    with pytest.raises(InputError, match="holds files"):  # before any work
        run(f"{SWEEP} -o {tmp_path / 'other'}".split())
    assert [path.name for path in (tmp_path / "other").iterdir()] == ["mine.txt"]
