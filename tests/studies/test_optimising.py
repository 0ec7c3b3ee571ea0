"""Optimising designs by models that take no time, against optima that are known or swept."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import skincad
from skincad.base import Estimate, InputError
from skincad.cli import run
from skincad.scenes import Scene, simulation
from skincad.studies import Optimisation, Study, optimise, query, sweep, value_of

VARY = {"ridge.levelling": "0:0.6", "skin.thickness": "6:10", "skin.curvature_radius": "90:200"}


def study(**changes: Any) -> Study:
    plain = {
        "name": "try",
        "about": "lab-bench",
        "vary": VARY,
        "model": "winkler",
        "judge": "winkler",
        "evaluations": 200,
        "objectives": [{"key": "approach"}],
        "constraints": [{"key": "all_touch_force", "at_most": 3.0}],
    }
    return Study(**{**plain, **changes})


@pytest.fixture(scope="module")
def found() -> Optimisation:
    return optimise(study())


@pytest.mark.slow
def test_the_best_is_no_worse_than_a_fine_grids(found: Optimisation) -> None:
    grid = sweep(
        skincad.load_design("lab-bench"),
        {
            "ridge.levelling": (0.0, 0.6, 13),
            "skin.thickness": (6.0, 10.0, 5),
            "skin.curvature_radius": (90.0, 200.0, 12),
        },
        model="winkler",
    )
    allowed = [
        row.results["approach_mm"].upper or 0.0
        for row in grid.rows
        if (row.results["all_touch_force_N"].upper or np.inf) <= 3.0
    ]
    (best,) = found.front
    assert (best.objectives["approach_mm"].upper or np.inf) <= 1.005 * min(
        allowed
    )  # what 200 evaluations leave
    force, kept = best.constraints["all_touch_force_N"]
    assert kept
    assert (force.upper or np.inf) <= 3.0


def test_the_front_is_what_the_judge_says(found: Optimisation) -> None:
    design = found.design()
    again = skincad.check(design, model="winkler")  # type: ignore[arg-type]
    assert again.approach == found.front[0].objectives["approach_mm"]
    with pytest.raises(InputError):
        found.design(2)
    row = found.to_frame().iloc[0]
    assert row["approach_mm"] == again.approach.value
    assert row["all_touch_force_N.error"] == again.all_touch_force.error
    assert row["ridge.levelling"] == design.ridge.levelling  # type: ignore[union-attr]


@pytest.mark.slow
def test_without_robustness_the_value_counts() -> None:
    """The largest force below a limit lies at it: its value, or its upper end."""
    most = [{"key": "all_touch_force", "goal": "max"}]
    bold, robust = (optimise(study(robust=kind, objectives=most)).front[0] for kind in (False, True))
    assert bold.objectives["all_touch_force_N"].value == pytest.approx(3.0, rel=0.02)
    assert robust.objectives["all_touch_force_N"].upper == pytest.approx(3.0, rel=0.02)


def test_a_varied_key_may_be_an_objective() -> None:
    """The most curved pad that needs 3 N at most: at the least radius where the rest can still help."""
    optimisation = optimise(
        study(objectives=[{"key": "skin.curvature_radius"}], vary={**VARY, "skin.curvature_radius": "40:200"})
    )
    (best,) = optimisation.front
    assert best.objectives["skin.curvature_radius"].value == best.values["skin.curvature_radius"]
    assert float(best.values["skin.curvature_radius"]) < 120.0  # lab-bench's own


@pytest.mark.slow
def test_a_better_judge_has_the_last_word() -> None:
    """Judged by another model than the one that searches: its numbers, and its limit kept."""
    judged = optimise(study(judge="linear", evaluations=60))
    (best,) = judged.front
    assert best.model == "linear"
    assert (best.constraints["all_touch_force_N"][0].upper or np.inf) <= 3.0


@pytest.mark.slow
def test_a_number_may_have_a_limit_on_either_side() -> None:
    both = [{"key": "all_touch_force", "at_least": 0.05, "at_most": 3.0}]
    goal = [{"key": "all_touch_force", "goal": "min"}]
    (best,) = optimise(study(objectives=goal, constraints=both)).front
    force, kept = best.constraints["all_touch_force_N"]
    assert kept
    assert (force.lower or 0.0) >= 0.05
    impossible = [{"key": "all_touch_force", "at_least": 3.0, "at_most": 1.0}]
    assert not optimise(study(objectives=goal, constraints=impossible, evaluations=30)).feasible


def test_what_nothing_keeps_is_said_with_the_nearest() -> None:
    none = optimise(study(constraints=[{"key": "all_touch_force", "at_most": 0.01}], evaluations=40))
    assert not none.feasible
    assert none.closest is not None
    assert "no design that was judged keeps all constraints" in str(none)
    assert "BROKEN" in str(none)


@pytest.mark.slow
def test_several_objectives_have_a_front() -> None:
    goals = [{"key": "approach"}, {"key": "all_touch_force", "goal": "min"}]
    several = optimise(study(objectives=goals, constraints=[], evaluations=240))
    told = np.array([[float(each) for each in member.objectives.values()] for member in several.front])
    assert len(told) >= 3
    order = np.argsort(told[:, 0])
    upper = np.array([[each.upper or 0.0 for each in m.objectives.values()] for m in several.front])
    assert np.all(np.diff(upper[np.argsort(upper[:, 0]), 1]) <= 0)  # less of one is more of the other
    assert len(order) == len(several.front)


def test_a_study_goes_on_where_it_was(tmp_path: Path) -> None:
    first = optimise(study(evaluations=60), folder=tmp_path)
    again = optimise(study(evaluations=60), folder=tmp_path)
    assert (again.evaluations, again.front) == (0, first.front)
    log = tmp_path / "evaluations.jsonl"
    lines = log.read_bytes().splitlines(keepends=True)
    log.write_bytes(b"".join(lines[: len(lines) // 2]))
    half = optimise(study(evaluations=60), folder=tmp_path)
    assert half.front == first.front
    assert half.evaluations == len(lines) - len(lines) // 2


def test_the_bar_tells_the_best_so_far() -> None:
    rows: list[tuple[str, int]] = []
    optimisation = optimise(
        study(evaluations=40), tick=lambda stage, step, _=None, /: rows.append((stage, step))
    )
    assert [step for _, step in rows] == sorted(step for _, step in rows)
    last = float(rows[-1][0].removeprefix("best approach "))
    assert last == pytest.approx(optimisation.front[0].objectives["approach_mm"].upper, rel=1e-3)  # as shown
    none = optimise(
        study(evaluations=10, constraints=[{"key": "all_touch_force", "at_most": 0.001}]),
        tick=lambda stage, step, _=None, /: rows.append((stage, step)),
    )
    assert not none.feasible
    assert rows[-1][0] == "none allowed so far"


def test_json_has_the_contracts_keys(found: Optimisation) -> None:
    data = json.loads(json.dumps(found.as_json(), allow_nan=False))
    assert {"front", "evaluations", "reused", "seconds"} <= data.keys()
    assert {"values", "objectives", "constraints"} <= data["front"][0].keys()


@pytest.mark.slow
def test_the_command_writes_designs_table_pictures_and_a_page(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "try.toml"
    file.write_text(study(evaluations=40).to_toml())
    assert run(["optimise", str(file), "-o", str(tmp_path / "out"), "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    names = {Path(entry["path"]).name for entry in data["files"]}
    assert {"front-1.toml", "optimise.csv", "optimise.html", "effects.png", "pairs.png"} <= names
    best = skincad.load_design(tmp_path / "out" / "front-1.toml")
    assert best.ridge.levelling == data["front"][0]["values"]["ridge.levelling"]
    assert run(["optimise", str(file), "-o", str(tmp_path / "out")]) == 0
    assert capsys.readouterr().out.startswith("try: the best design that was found for approach small.")


class Led:
    """A simulation that takes no time: the lead is longest at 1e8 ohm and a radius of 80 mm."""

    def __init__(self, scene: Scene) -> None:
        self.resistance = value_of(scene, "circuit.amplifier.feedback_resistance")
        self.radius = scene.design.skin.curvature_radius

    def numbers(self) -> dict[str, Estimate]:
        off = np.log10(float(self.resistance or 0.0) / 1e8) ** 2 + (self.radius / 80 - 1) ** 2
        return {"longest_lead_time_s": Estimate(float(1e-3 * np.exp(-off)), None, "s")}


@pytest.mark.parametrize("judge", ["winkler", pytest.param("linear", marks=pytest.mark.slow)])
def test_shape_and_amplifier_are_found_together(judge: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """By a scene's result, with a limit of the check beside it, which the judge has the last word on."""
    monkeypatch.setitem(query._ASKED, "simulate", lambda scene, _: Led(scene))
    vary = {"skin.skin.curvature_radius": "40:200", "circuit.amplifier.feedback_resistance": "1e6:1e10"}
    optimisation = optimise(
        study(
            about="steady-pull",
            vary=vary,
            judge=judge,
            evaluations=120,
            objectives=[{"key": "longest_lead_time", "goal": "max"}],
            constraints=[{"key": "check.margin", "at_least": 1.0}],
        )
    )
    (best,) = optimisation.front
    margin, kept = best.constraints["check.margin_N"]
    assert optimisation.aims == ["longest_lead_time_s", "check.margin_N"]
    assert all(set(optimisation.aims) <= set(row.results) for row in optimisation.rows.rows)
    scene = optimisation.design()
    assert isinstance(scene, Scene)
    assert kept
    assert margin.value == pytest.approx(skincad.check(scene.design, model=judge).margin, rel=1e-12)
    # 80 mm has too little left of 4 N, so that the radius ends where the limit is just kept: within what a
    # third of the evaluations leave after the judge has moved it last
    assert margin.value == pytest.approx(1.0, abs=0.1)
    assert float(value_of(scene, "circuit.amplifier.feedback_resistance") or 0) == pytest.approx(
        1e8, rel=0.15
    )


def test_a_search_over_an_amplifier_marches_once(monkeypatch: pytest.MonkeyPatch) -> None:
    marches: list[Scene] = []
    monkeypatch.setattr(query, "_LAST", {})
    monkeypatch.setattr(simulation, "marched", lambda scene, **_: marches.append(scene))
    monkeypatch.setattr(simulation, "read_out", lambda scene, _: Led(scene))
    vary = {"circuit.amplifier.feedback_resistance": "1e6:1e10", "readout.bandwidth_Hz": "1000:20000"}
    goals = [{"key": "longest_lead_time", "goal": "max"}]
    optimisation = optimise(
        study(about="steady-pull", vary=vary, evaluations=20, model=None, objectives=goals, constraints=[])
    )
    assert optimisation.feasible
    assert len(marches) == 1
    evaluate = query.evaluate
    again = evaluate(optimisation.subject, {"history.steps": 500}, query.Query("simulate"))
    assert again.results
    assert len(marches) == 2


def test_a_misspelt_key_is_told_at_once() -> None:
    with pytest.raises(InputError, match="did you mean 'approach'"):
        optimise(study(objectives=[{"key": "aproach"}]))


@pytest.mark.slow
def test_process_a_finds_an_amplifier_that_warns_without_a_false_alarm() -> None:
    """The template on the paper's skin, whose own settings warn already."""
    optimisation = optimise(skincad.load_study("amplifier-for-slip"))
    (best,) = optimisation.front
    assert optimisation.start is not None
    assert optimisation.start.allowed
    lead = best.objectives["warning_lead_time_s"].value or 0.0
    assert 1.0e-3 < lead < 1.85e-3  # the first ridge slips 1.85 ms before all do
    for key in ("event_score.false", "warning_score.false"):
        assert best.constraints[key][0].value == 0
    assert optimisation.evaluations > 60
