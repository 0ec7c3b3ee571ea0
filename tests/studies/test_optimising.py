"""Optimising: a study's file, how results are weighed, and optima that are known or swept."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import skincad
from skincad.base import Estimate, InputError
from skincad.cli import run
from skincad.inputs import template_names
from skincad.scenes import Scene, simulation
from skincad.studies import Member, Optimisation, Study, knobs, load_study, optimise, query, sweep, value_of
from skincad.studies.study import RobustObjective
from tests.refusals import refused

TABLE: dict[str, Any] = {"name": "plain", "about": "yamada-2002", "vary": {"skin.length": "8:14"}}
TABLE |= {"objectives": [{"key": "approach"}]}


def test_a_studys_keys_and_paths(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    quoted = '"skin.length" = "8:14"\n"contact.plate.tilt" = "0:1"\n'
    tables = 'skin.length = "8:14"\ncontact.plate.tilt = "0:1"\n'
    head = 'name = "s"\nabout = "yamada-2002"\n[vary]\n'
    rows = []
    for name, text in (("a", quoted), ("b", tables)):
        path = tmp_path / f"{name}.toml"
        path.write_text(head + text + '[[objectives]]\nkey = "approach"\n')
        rows.append(load_study(path))
    assert rows[0] == rows[1]
    assert dict(rows[0].vary) == {"skin.length": "8:14", "contact.plate.tilt": "0:1"}
    (tmp_path / "mine.toml").write_text(skincad.load_design("yamada-2002").to_toml())
    path = tmp_path / "study.toml"
    path.write_text(Study(**{**TABLE, "about": "mine.toml"}).to_toml())
    monkeypatch.chdir("/")
    assert load_study(path, ["ridge.count=7"]).subject().ridge.count == 7


@pytest.mark.parametrize("name", template_names("studies"))
def test_what_ships_can_be_asked(name: str) -> None:
    study = load_study(name)
    assert study.name == name
    subject = study.subject()
    varied = knobs(subject, dict(study.vary))
    for knob in varied:
        assert knob.start is not None
    assert Study(**study.model_dump(exclude_none=True)) == study


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"objectives": []}, "objectives: names none"),
        ({"vary": {}}, "vary: names no key"),
        ({"form": 0}, "form: must be 1"),
        ({"tier": "lineer"}, "model: unknown model, got 'lineer'; did you mean 'linear'"),
        ({"judge": "x"}, "judge: unknown model"),
        ({"model": "auto"}, "must be one model"),
        ({"model": "winkler", "tier": "linear"}, "tier: unknown key"),
        ({"constraints": [{"key": "yield"}]}, "needs at_least or at_most"),
        ({"objectives": [{"key": "approach", "goal": "least"}]}, "goal"),
        ({"objectives": [{"key": "a"}, {"key": "b"}], "optimiser": "cma"}, "nsga2 or sobol"),
        ({"evaluations": 0}, "evaluations"),
        ({"optimizer": "cma"}, "did you mean 'optimiser'"),
    ],
)
def test_what_can_not_be_used_is_one_line(change: dict[str, Any], says: str) -> None:
    with refused(says):
        Study(**{**TABLE, **change})


def test_a_study_is_no_design_and_a_design_no_study() -> None:
    with pytest.raises(InputError, match="is a design, not a study; give it to"):
        load_study("lab-bench")
    with pytest.raises(InputError, match="is a study, not a design; give it to optimise"):
        skincad.load_design("my-printer")
    with pytest.raises(InputError, match="did you mean 'my-printer'"):
        load_study("my-printr")
    with pytest.raises(InputError, match="did you mean 'approach'"):
        optimise(study(objectives=[{"key": "aproach"}]))


HERE = np.array([0.5])
CHEAP = {"all_touch_force_N": Estimate(2.0, 0.5, "N"), "margin_N": Estimate(1.0, None, "N")}
JUDGED = {"all_touch_force_N": Estimate(1.5, 0.25, "N"), "margin_N": Estimate(2.25, None, "N")}


def weighing(**changes: Any) -> RobustObjective:
    plain = {"name": "try", "about": "lab-bench", "vary": {"skin.thickness": "6:10"}}
    plain |= {"objectives": [{"key": "all_touch_force"}]}
    plain |= {"constraints": [{"key": "margin", "at_least": 2.0}]}
    return RobustObjective(Study(**{**plain, **changes}))


def member(values: Mapping[str, float], loss: float, kept: bool = True) -> Member:
    limit = {"margin_N": (Estimate(2.5, None, "N"), kept)}
    objectives = {"all_touch_force_N": Estimate(loss, 0.0, "N")}
    return Member(values=values, objectives=objectives, constraints=limit, model="linear")


def test_the_worse_end_counts_and_limits_are_parts_of_their_bounds() -> None:
    answer = weighing().told(HERE, CHEAP, "search")
    assert answer.losses.tolist() == [2.5]
    assert answer.limits.tolist() == [0.5]  # 1 of 2 N
    most = weighing(objectives=[{"key": "all_touch_force", "goal": "max"}])
    assert most.told(HERE, CHEAP, "search").losses.tolist() == [-1.5]
    assert weighing(robust=False).told(HERE, CHEAP, "search").losses.tolist() == [2.0]
    both = weighing(constraints=[{"key": "margin", "at_least": 2.0, "at_most": 2.2}])
    answer = both.member({"skin.thickness": 7.0}, JUDGED, "corrected")
    assert answer.constraints == {"margin_N": (JUDGED["margin_N"], False)}
    assert answer.objectives == {"all_touch_force_N": JUDGED["all_touch_force_N"]}


def test_a_judge_moves_a_models_numbers_by_a_factor_and_a_margin_by_a_difference() -> None:
    one = weighing()
    one.correct(one.member({}, JUDGED, "corrected"), CHEAP, "search")
    answer = one.told(HERE, CHEAP, "search")
    assert answer.losses == pytest.approx([1.75], rel=1e-12)  # the judge's upper end
    assert answer.limits == pytest.approx([-0.125], rel=1e-12)
    twice = {"all_touch_force_N": Estimate(4.0, 9.0, "N"), "margin_N": Estimate(0.0, None, "N")}
    again = one.told(HERE, twice, "search")
    assert again.losses == pytest.approx([3.5], rel=1e-12)
    assert again.limits == pytest.approx([(2.0 - 1.25) / 2.0], rel=1e-12)
    assert one.told(HERE, CHEAP, "guide").losses.tolist() == [2.5]  # of another model nothing is known
    # what judge and model say alike keeps its own error
    one = weighing()
    one.correct(one.member({}, CHEAP, "linear"), CHEAP, "search")
    assert not one.differs


def test_what_is_refused_or_not_told_has_no_loss() -> None:
    assert not weighing().told(HERE, None, "search").there
    assert not weighing().told(HERE, {**CHEAP, "margin_N": Estimate(None, None, "N")}, "search").there
    beside = weighing(constraints=[{"key": "make.passed", "at_least": 1}])
    assert beside.others() == ["make"]
    assert not beside.told(HERE, CHEAP, "search").there
    assert beside.told(HERE, CHEAP, "guide").limits.tolist() == [-1.0]  # the closed form can't tell: kept
    with pytest.raises(InputError, match="did you mean 'margin'"):
        weighing(constraints=[{"key": "margn", "at_least": 2.0}]).told(HERE, CHEAP, "search")


def test_members_that_keep_their_limits_come_first_and_what_nothing_beats_is_a_front() -> None:
    worse, best = member({"a": 2.0}, 3.0), member({"a": 3.0}, 2.0)
    broken = member({"a": 1.0}, 0.5, kept=False)
    one = weighing()
    assert one.ordered([broken, worse, best]) == [best, worse, broken]
    assert one.pareto_front([best, worse]) == [best]
    two = weighing(objectives=[{"key": "all_touch_force"}, {"key": "approach"}])

    def at(force: float, approach: float) -> Member:
        table = {"all_touch_force_N": Estimate(force, 0.0, "N"), "approach_mm": Estimate(approach, 0.0, "mm")}
        return Member(values={}, objectives=table, constraints={}, model="linear")

    first, second, beaten = at(1.0, 3.0), at(2.0, 1.0), at(2.0, 3.5)
    assert two.pareto_front([first, second, beaten]) == [first, second]
    middle = [at(1.0 + s, 3.0 - 2.0 * s) for s in (0.1, 0.4, 0.2)]  # the first few cover the front
    assert two.pareto_front([first, *middle, second]) == [first, second, middle[1], middle[2], middle[0]]


OPTIMA = pytest.mark.evidence(subject="optima: studies")
VARY = {"ridge.levelling": "0:0.6", "skin.thickness": "6:10", "skin.curvature_radius": "90:200"}


def study(**changes: Any) -> Study:
    plain = {"name": "try", "about": "lab-bench", "vary": VARY, "model": "winkler", "judge": "winkler"}
    plain |= {"evaluations": 200, "objectives": [{"key": "approach"}]}
    plain |= {"constraints": [{"key": "all_touch_force", "at_most": 3.0}]}
    return Study(**plain | changes)


BAR: list[tuple[str, int]] = []


@pytest.fixture(scope="module")
def few() -> Optimisation:
    """Forty evaluations; what its bar told is in BAR."""
    return optimise(study(evaluations=40), tick=lambda stage, step, _=None, /: BAR.append((stage, step)))


@OPTIMA
def test_the_best_is_no_worse_than_a_fine_grids() -> None:
    vary = {"ridge.levelling": (0.0, 0.6, 13), "skin.thickness": (6.0, 10.0, 5)}
    vary |= {"skin.curvature_radius": (90.0, 200.0, 12)}
    grid = sweep(skincad.load_design("lab-bench"), vary, model="winkler")
    allowed = [
        row.results["approach_mm"].upper or 0.0
        for row in grid.rows
        if (row.results["all_touch_force_N"].upper or np.inf) <= 3.0
    ]
    (best,) = optimise(study()).front
    approach = best.objectives["approach_mm"].upper or np.inf
    assert approach <= 1.005 * min(allowed)  # what 200 evaluations leave
    force, kept = best.constraints["all_touch_force_N"]
    assert kept
    assert (force.upper or np.inf) <= 3.0


@pytest.mark.slow
def test_the_front_is_what_the_judge_says(few: Optimisation) -> None:
    design = few.design()
    again = skincad.check(design, model="winkler")
    assert again.approach == few.front[0].objectives["approach_mm"]
    with pytest.raises(InputError):
        few.design(2)
    row = few.to_frame().iloc[0]
    assert row["approach_mm"] == again.approach.value
    assert row["all_touch_force_N.error"] == again.all_touch_force.error
    assert row["ridge.levelling"] == design.ridge.levelling


@OPTIMA
def test_limits_count_by_their_ends_and_a_better_judge_has_the_last_word() -> None:
    """The largest force below a limit lies at it: its value, or its upper end."""
    most = [{"key": "all_touch_force", "goal": "max"}]
    bold, robust = (optimise(study(robust=kind, objectives=most)).front[0] for kind in (False, True))
    assert bold.objectives["all_touch_force_N"].value == pytest.approx(3.0, rel=0.02)
    assert robust.objectives["all_touch_force_N"].upper == pytest.approx(3.0, rel=0.02)
    # Judged by another model than the one that searches: its numbers, and its limit kept
    judged = optimise(study(judge="linear", evaluations=60))
    (best,) = judged.front
    assert best.model == "linear"
    assert (best.constraints["all_touch_force_N"][0].upper or np.inf) <= 3.0
    # a number may have a limit on either side
    both = [{"key": "all_touch_force", "at_least": 0.05, "at_most": 3.0}]
    goal = [{"key": "all_touch_force", "goal": "min"}]
    (best,) = optimise(study(objectives=goal, constraints=both)).front
    force, kept = best.constraints["all_touch_force_N"]
    assert kept
    assert (force.lower or 0.0) >= 0.05
    impossible = [{"key": "all_touch_force", "at_least": 3.0, "at_most": 1.0}]
    assert not optimise(study(objectives=goal, constraints=impossible, evaluations=30)).feasible


@pytest.mark.slow
def test_a_varied_key_may_be_an_objective() -> None:
    """The most curved pad that needs 3 N at most: at the least radius where the rest can still help."""
    vary = {**VARY, "skin.curvature_radius": "40:200"}
    goals = [{"key": "skin.curvature_radius"}]
    (best,) = optimise(study(objectives=goals, vary=vary, evaluations=60)).front
    assert best.objectives["skin.curvature_radius"].value == best.values["skin.curvature_radius"]
    assert float(best.values["skin.curvature_radius"]) < 120.0  # lab-bench's own


def test_what_nothing_keeps_is_said_with_the_nearest() -> None:
    rows: list[str] = []
    limits = [{"key": "all_touch_force", "at_most": 0.01}]
    none = optimise(study(constraints=limits, evaluations=15), tick=lambda stage, *_: rows.append(stage))
    assert not none.feasible
    assert none.closest is not None
    assert "no design that was judged keeps all constraints" in str(none)
    assert "BROKEN" in str(none)
    assert rows[-1] == "none allowed so far"


@OPTIMA
def test_several_objectives_have_a_front() -> None:
    goals = [{"key": "approach"}, {"key": "all_touch_force", "goal": "min"}]
    several = optimise(study(objectives=goals, constraints=[], evaluations=240))
    upper = np.array([[goal.upper or 0.0 for goal in m.objectives.values()] for m in several.front])
    assert len(upper) >= 3
    assert np.all(np.diff(upper[np.argsort(upper[:, 0]), 1]) <= 0)  # less of one is more of the other


@pytest.mark.slow
def test_a_study_goes_on_where_it_was(tmp_path: Path) -> None:
    first = optimise(study(evaluations=40), folder=tmp_path)
    again = optimise(study(evaluations=40), folder=tmp_path)
    assert (again.evaluations, again.front) == (0, first.front)
    log = tmp_path / "evaluations.jsonl"
    lines = log.read_bytes().splitlines(keepends=True)
    log.write_bytes(b"".join(lines[: len(lines) // 2]))
    half = optimise(study(evaluations=40), folder=tmp_path)
    assert half.front == first.front
    assert half.evaluations == len(lines) - len(lines) // 2


def test_the_bar_and_json_tell_the_best(few: Optimisation) -> None:
    assert [step for _, step in BAR] == sorted(step for _, step in BAR)
    last = float(BAR[-1][0].removeprefix("best approach "))
    assert last == pytest.approx(few.front[0].objectives["approach_mm"].upper, rel=1e-3)  # as shown
    data = json.loads(json.dumps(few.as_json(), allow_nan=False))
    assert {"front", "evaluations", "reused", "seconds"} <= data.keys()
    assert {"values", "objectives", "constraints"} <= data["front"][0].keys()


@pytest.mark.slow
def test_the_command_writes_its_files(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
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


@pytest.mark.slow
@pytest.mark.parametrize("judge", ["winkler", pytest.param("linear", marks=OPTIMA)])
def test_shape_and_amplifier_are_found_together(judge: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """By a scene's result, with a limit of the check beside it, which the judge has the last word on."""
    monkeypatch.setitem(query._ASKED, "simulate", lambda scene, _: Led(scene))
    vary = {"skin.skin.curvature_radius": "40:200", "circuit.amplifier.feedback_resistance": "1e6:1e10"}
    goals = [{"key": "longest_lead_time", "goal": "max"}]
    limits = [{"key": "check.margin", "at_least": 1.0}]
    wanted = {"about": "steady-pull", "vary": vary, "objectives": goals, "constraints": limits}
    optimisation = optimise(study(**wanted, judge=judge, evaluations=120))
    (best,) = optimisation.front
    margin, kept = best.constraints["check.margin_N"]
    assert optimisation.aims == ["longest_lead_time_s", "check.margin_N"]
    assert all(set(optimisation.aims) <= set(row.results) for row in optimisation.rows.rows)
    scene = optimisation.design()
    assert kept
    assert margin.value == pytest.approx(skincad.check(scene.design, model=judge).margin, rel=1e-12)
    # 80 mm has too little left of 4 N, so that the radius ends where the limit is just kept: within what a
    # third of the evaluations leave after the judge has moved it last
    assert margin.value == pytest.approx(1.0, abs=0.1)
    resistance = float(value_of(scene, "circuit.amplifier.feedback_resistance") or 0)
    assert resistance == pytest.approx(1e8, rel=0.15)


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
    again = query.evaluate(optimisation.subject, {"history.steps": 500}, query.Query("simulate"))
    assert again.results
    assert len(marches) == 2


@pytest.mark.evidence(subject="amplifier-for-slip")
def test_process_a_finds_an_amplifier_that_warns_without_a_false_alarm() -> None:
    """The template on the paper's skin, whose own settings warn already."""
    optimisation = optimise(skincad.load_study("amplifier-for-slip"))
    (best,) = optimisation.front
    assert optimisation.start.allowed
    lead = best.objectives["warning_lead_time_s"].value or 0.0
    assert 1.0e-3 < lead < 1.85e-3  # the first ridge slips 1.85 ms before all do
    for key in ("event_score.false", "warning_score.false"):
        assert best.constraints[key][0].value == 0
    assert optimisation.evaluations > 60
