"""By which model and on which meshes a scene is marched: tolerance, budget, and what the next one costs."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from skincad.base import InputError
from skincad.effects import Drift, Observables, chosen_steps
from skincad.outputs import SIMULATION
from skincad.scenes import (
    LEVELS,
    Level,
    March,
    Runs,
    Scene,
    SceneRun,
    Simulation,
    expected,
    held_against_rounder,
    load_scene,
    marched,
    piece_for,
    plan,
    read_out,
    runs,
    simulate,
    slips_of,
    with_rounder_fillets,
)
from skincad.scenes.march import march
from tests.small_scene import THIRD, small_scene

SPENT = {"mesh": 0.5, "condense": 1.0, "march": 3.0}


def test_a_shared_mesh_costs_nothing_more_and_a_finer_one_is_made_anew() -> None:
    """Condensing and marching grow with one power of the unknowns, meshing as these."""
    shared, finer = (expected(LEVELS[i + 1], LEVELS[i], SPENT) for i in (0, 2))
    growth = LEVELS[3].size / LEVELS[2].size
    assert LEVELS[0].fineness == LEVELS[1].fineness
    power = math.log(shared / 4.0) / math.log(LEVELS[1].size / LEVELS[0].size)
    assert 1 < power < 2.5  # a sparse factorisation in the plane, at most a dense one of its front
    assert finer == pytest.approx(0.5 * growth + 4.0 * growth**power)
    assert Level(1.0, 5).size == 1.0  # its own unit unless told


def two_steps(folder: Path, **limits: Any) -> Simulation:
    press = ("history.steps=2", "readout.ridges=[1]", THIRD)
    return simulate(small_scene(folder, "yamada-2002-press", *press), model="small_strain", **limits)


@pytest.mark.slow
def test_sizes_of_meshes_grow_as_their_unknowns(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Within a tenth: sizes were rounded, and a mesh changes with netgen's release."""
    unknowns = []
    for level in LEVELS[:2]:
        monkeypatch.setattr(plan, "LEVELS", (level,))
        unknowns.append(two_steps(tmp_path).march.unknowns)
    assert unknowns[1] / unknowns[0] == pytest.approx(LEVELS[1].size / LEVELS[0].size, rel=0.1)


def test_the_time_left_is_told_and_falls_to_what_must_follow(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(runs, "LONGER", 1e6)  # so that the march with fewer steps stands out
    ticks: list[tuple[str, int, float]] = []

    def tick(stage: str, step: int, left: float | None = None) -> None:
        if left is not None:
            ticks.append((stage, step, left))

    press = ("history.steps=8", "readout.ridges=[1]", THIRD)
    simulation = simulate(small_scene(tmp_path, "yamada-2002-press", *press), tol=0.5, tick=tick)
    stages = list(dict.fromkeys(stage for stage, _, _ in ticks))
    assert len(stages) == 3  # no error without a second mesh, nor without a march with fewer steps
    first, fewer, second = ([left for name, _, left in ticks if name == stage] for stage in stages)
    assert len(first) == len(second) == 8
    assert second[-1] == 0.0
    assert first[-1] > 100 * fewer[-1] > 0.0  # then the second mesh alone is left
    assert stages[1] == "march with fewer steps"
    assert [step for name, step, _ in ticks if name == stages[1]] == [5, 8]
    assert simulation.error is not None


def test_a_budget_is_told_to_be_too_small(tmp_path: Path) -> None:
    simulation = two_steps(tmp_path, budget=1e-3)
    assert simulation.error is None
    assert any("more than the budget of 0.001 s" in warning for warning in simulation.warnings)
    assert any("of unknown error" in warning for warning in simulation.warnings)


@pytest.mark.slow
def test_an_error_comes_with_two_meshes(tmp_path: Path) -> None:
    assert all(0 < error < math.inf for error in two_steps(tmp_path).error.values())


@pytest.mark.parametrize(
    ("limits", "meshes"), [({"budget": 1e6}, 3), ({"budget": 1e6, "tol": 0.9}, 2), ({"tol": 0.9}, 2)]
)
def test_a_budget_alone_buys_the_best_and_a_tolerance_the_cheapest(
    limits: dict[str, float], meshes: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(plan, "LEVELS", LEVELS[:3])
    stages: set[str] = set()

    def tick(stage: str, step: int, left: float | None = None) -> None:
        if "fineness" in stage:
            stages.add(stage)

    simulation = two_steps(tmp_path, tick=tick, **limits)
    assert len(stages) == meshes
    assert not any("met" in warning or "budget" in warning for warning in simulation.warnings)


def test_a_finer_mesh_that_fails_does_not_cost_what_was_good_enough(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(plan, "LEVELS", LEVELS[:3])
    marches: list[March] = []
    march_on = plan.march_on

    def fail_third(*arguments: Any) -> March:
        marches.append(march_on(*arguments))
        last = marches[-1]
        return replace(last, failed=True, stopped="step 2") if len(marches) == 3 else last

    monkeypatch.setattr(plan, "march_on", fail_third)
    press = small_scene(tmp_path, "yamada-2002-press", "history.steps=2", "readout.ridges=[1]", THIRD)
    runs_made = marched(press, budget=1e6).runs
    assert len(marches) == 3
    assert runs_made.march is marches[1]
    assert runs_made.before is marches[0]  # not the march itself, which would tell no error
    assert any("a finer mesh stopped at step 2" in note for note in runs_made.notes)


PULLED = (
    "history.steps=24",
    "history.time_s=[0.0, 0.001, 0.004]",
    "history.normal_force_N=[0.0, 1.3, 1.3]",
    "history.tangential_force_N=[0.0, 0.0, 0.65]",
    "effects.friction.coefficient=0.5",
    "readout.ridges=[2]",
)


def scene_in(folder: Path, *overrides: str) -> Scene:
    return small_scene(folder, "yamada-2002-slip", *PULLED, *overrides)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("models")


@cache
def corrected_run(folder: Path) -> SceneRun:
    return marched(scene_in(folder), tol=0.1, further_models=True)


@cache
def corrected(folder: Path) -> Simulation:
    return read_out(scene_in(folder), corrected_run(folder))


@pytest.mark.slow
@pytest.mark.dear("small strain on two meshes and chosen steps, once for all tests of them")
def test_a_tolerance_that_small_strain_does_not_meet_asks_for_chosen_steps(folder: Path) -> None:
    simulation = corrected(folder)
    data = simulation.as_json()
    assert data["tier"] == "corrected"
    assert data["effects"] == ["friction", "film", "finite_strain"]
    assert 3 < len(data["chosen_steps"]) < 20
    assert "finite_strain" not in {entry["effect"] for entry in data["left_out"]}
    steps = len(data["chosen_steps"]) - 1
    words = f"Finite strain in {steps} chosen steps, linear in between, with the skin's mass."
    assert words in SIMULATION.lines(simulation)[2]
    json.dumps(data, allow_nan=False)


@pytest.mark.slow
def test_its_errors_are_small_strains_and_what_drifts(folder: Path) -> None:
    """Mesh and time step are as small strain has them; what drifts counts in stress, slips and leads."""
    simulation, small = corrected(folder), simulate(scene_in(folder, "effects.small_strain={}"), tol=0.1)
    one, other = simulation.stress_errors[2], small.stress_errors[2]
    assert (one.mesh, one.time_step) == (other.mesh, other.time_step)
    assert one.drift > 0 == other.drift
    assert one.left_out < other.left_out
    lead, coarse = simulation.slip_errors.leads[1], small.slip_errors.leads[1]
    assert (lead.mesh, lead.time_step) == (coarse.mesh, coarse.time_step)
    assert simulation.slip_errors.leads[1].left_out < small.slip_errors.leads[1].left_out
    assert small.as_json()["tier"] == "small_strain"
    assert small.as_json()["chosen_steps"] is None


@pytest.mark.evidence(subject="finer steps: chosen steps of scenes")
def test_it_holds_against_finite_strain_in_each_step(folder: Path) -> None:
    """The stress and each ridge's lead within the errors told, without what both leave out."""
    simulation, reference = corrected(folder), simulate(scene_in(folder, "effects.finite_strain={}"))
    assert reference.as_json()["tier"] == "finite_strain"
    error = simulation.stress_errors[2]
    common = min(simulation.raw[2].size, reference.raw[2].size)  # in the last step the surface may fold
    assert common >= 24
    off = np.abs(simulation.raw[2][:common] - reference.raw[2][:common]).max()
    assert off <= (error.total or 0) - error.left_out
    assert off < 0.03 * np.abs(reference.raw[2]).max()
    for one, other, slip in zip(
        simulation.slip_steps, reference.slip_steps, simulation.slip_step_errors, strict=True
    ):
        assert slip is not None
        assert abs((one or 0) - (other or common)) <= (slip.total or 0) - slip.left_out + 1


@pytest.mark.evidence(subject="finer meshes: chosen steps of scenes")
def test_the_papers_slip_holds_against_half_the_step_on_a_mesh_twice_as_fine() -> None:
    """Nine ridges, pulled by 0.4 of the normal force, at which nothing folds before all slip (0.5 does).

    The judge's mesh, by order 2 or 3, changes S1 - S2 by 0.6 % of its largest. One as fine without its small
    elements at the strips' edges is 12 % off.

    Stress, slips and leads of all ridges within what mesh, time step and drift are told to change. A thousand
    times as slow, for the judge has no masses.
    """
    pull = [0.0, 0.0, 1.36, 1.36, 1.04, 1.28, 1.6]  # 0.4 of the scene's own
    slow = [0.0, 1.0, 2.0, 3.0, 3.3, 4.5, 5.5]
    weaker = [f"history.tangential_force_N={pull}", f"history.time_s={slow}"]
    weaker += ["effects.friction.coefficient=0.4", "effects.free_ends={}"]
    simulation = simulate(load_scene("yamada-2002-slip", [*weaker, "history.steps=110"]), tol=0.05)
    assert simulation.as_json()["tier"] == "corrected"
    judge = load_scene("yamada-2002-slip", [*weaker, "history.steps=220", "effects.finite_strain={}"])
    piece, times = piece_for(judge, {}), judge.history.times
    mesh = runs.meshed_pad(piece, LEVELS[3], {})  # as fine at the strips' edges as films ask for
    pad = judge.law.marched(piece, mesh, LEVELS[0].order, True, judge.terms)
    true = march(pad, times, judge.history.drives(), judge.terms)
    slips = slips_of(true, judge.design.ridge.count)
    assert true.stopped == "gross slip"
    assert simulation.gross_slip_step is not None
    assert slips.gross is not None
    films = true.column("films")[::2, :, 0]
    for ridge, error in simulation.stress_errors.items():
        one, other = simulation.raw[ridge], films[:, 2 * ridge - 2] - films[:, 2 * ridge - 1]
        common = min(one.size, other.size)
        assert common >= 109
        assert np.abs(one[:common] - other[:common]).max() <= (error.total or 0) - error.left_out
    step, rounding = 1e3 * times[2], 1e-9  # ms
    for one, other, error in zip(
        simulation.slip_steps, slips.steps, simulation.slip_errors.leads, strict=True
    ):
        assert (one is None) == (other is None)
        if one is not None and other is not None:
            lead, known = (simulation.gross_slip_step - one) * step, 1e3 * (times[slips.gross] - times[other])
            assert abs(lead - known) <= (error.total or 0) - error.left_out + rounding


@pytest.mark.slow
def test_without_a_tolerance_or_where_it_is_met_small_strain_stays(folder: Path) -> None:
    run = marched(scene_in(folder), tol=1 - 1e-9, further_models=True)
    assert plan.model_of(run.on.scene) == "small_strain"
    light = ("history.normal_force_N=[0.0, 0.02, 0.02]", "history.tangential_force_N=[0.0, 0.0, 0.01]")
    run = marched(scene_in(folder, *light), tol=0.1, further_models=True)
    assert plan.model_of(run.on.scene) == "small_strain"


@pytest.mark.slow
def test_a_named_law_stays_and_so_does_a_scene_without_signals(folder: Path) -> None:
    for override in ("effects.small_strain={}", "readout.ridges=[]"):
        run = marched(scene_in(folder, override), tol=0.1, further_models=True)
        assert plan.model_of(run.on.scene) == "small_strain"
        assert not any("model beyond" in note for note in run.runs.notes)


@pytest.mark.slow
def test_what_cannot_be_had_at_finite_strain_is_said(folder: Path) -> None:
    """With the effect, the reason, and the results of small strain."""
    simulation = simulate(scene_in(folder, "effects.viscosity.retardation_time=1e-4"), tol=0.1)
    assert simulation.as_json()["tier"] == "small_strain"
    rows = [note for note in simulation.warnings if "no model beyond this one was marched" in note]
    assert len(rows) == 1
    assert "viscosity" in rows[0]


@pytest.mark.evidence(subject="finer steps: chosen steps of scenes")
def test_chosen_steps_that_are_named_stay_whatever_drifts(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(plan, "LEVELS", LEVELS[:1])
    chosen = ("effects.finite_strain={steps='chosen'}", "history.steps=8")
    simulation = simulate(scene_in(folder, *chosen), tol=1e-4)
    assert simulation.as_json()["tier"] == "corrected"
    assert any("drifts by" in note and "1.0e-04 is not met" in note for note in simulation.warnings)


@pytest.mark.slow
def test_a_budget_that_does_not_allow_chosen_steps_is_kept(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(plan, "DEAR", math.inf)
    simulation = simulate(scene_in(folder), tol=0.1, budget=300)
    assert simulation.as_json()["tier"] == "small_strain"
    assert any("more than the budget of 300 s leaves" in note for note in simulation.warnings)


@pytest.mark.slow
def test_readers_are_told_of_the_march_by_its_model(folder: Path) -> None:
    """A scene that differs in its readers alone is read out of the same march, law and all."""
    scene = scene_in(folder).with_(effects={"piezo": {"circuit": "transimpedance"}})
    simulation = read_out(scene, corrected_run(folder))
    assert simulation.as_json()["tier"] == "corrected"
    assert "events" in simulation.read


def of_chosen(last: int, cut: str) -> March:
    """Ten steps, every one up to the last chosen."""
    one, none = np.ones(1, dtype=bool), np.zeros((2, 1))
    readings = tuple(
        Observables(
            1.0, 1.0, 0.0, 0.0, one, ~one, none, 0.0, 0.0, 0.0, drift=Drift(none, none, i <= last, cut)
        )
        for i in range(11)
    )
    return March(np.arange(11.0), readings, np.ones(1, dtype=int), 0, None, False, {}, np.zeros((11, 3, 1)))


@pytest.mark.parametrize(
    ("drawn", "rounder", "counts"),
    [((4, "snaps"), (9, ""), True), ((4, "snaps"), (4, "snaps"), False), ((9, ""), (9, ""), False)],
)
def test_rounder_fillets_count_where_those_as_drawn_let_no_step_be_chosen(
    drawn: tuple[int, str], rounder: tuple[int, str], counts: bool
) -> None:
    one, other = of_chosen(*drawn), of_chosen(*rounder)
    scene = with_rounder_fillets(load_scene("yamada-2002-slip"))
    runs = held_against_rounder(Runs(one), other, scene)
    assert (runs.march, runs.fillets) == ((other, one) if counts else (one, other))
    assert ["0.2 mm at the tips" in note for note in runs.notes] == [True] * counts


def test_a_rounder_march_that_fails_early_does_not_count() -> None:
    one, other = of_chosen(2, "snaps"), of_chosen(5, "")
    failed = replace(other, failed=True, readings=other.readings[:6])
    runs = held_against_rounder(Runs(one), failed, with_rounder_fillets(load_scene("yamada-2002-slip")))
    assert (runs.march, runs.fillets) == (one, failed)


def test_without_a_common_chosen_step_what_a_fold_changes_is_said_to_be_unknown() -> None:
    one, scene = of_chosen(0, "snaps"), with_rounder_fillets(load_scene("yamada-2002-slip"))
    runs = held_against_rounder(Runs(one), of_chosen(9, ""), scene)
    assert (runs.march, runs.fillets) == (one, None)
    assert "no chosen step in common" in runs.notes[0]


def test_rounder_fillets_are_larger_and_there_where_none_are_drawn() -> None:
    scene = load_scene("yamada-2002-slip")
    drawn, ridge = scene.design.ridge, with_rounder_fillets(scene).design.ridge
    assert ridge.tip_fillet == pytest.approx(0.4 * drawn.tip_width)
    assert ridge.root_fillet == pytest.approx(1.5 * drawn.root_fillet)
    sharp = scene.with_(skin={"ridge": {"tip_fillet": 0.0, "root_fillet": 0.0}})
    assert with_rounder_fillets(sharp).design.ridge.tip_fillet == pytest.approx(0.4 * drawn.tip_width)
    round_already = scene.with_(skin={"ridge": {"tip_fillet": 0.22}})
    assert with_rounder_fillets(round_already).design.ridge.tip_fillet == 0.22
    with pytest.raises(InputError):  # wider than what is left of a groove
        with_rounder_fillets(scene.with_(skin={"ridge": {"root_width": 0.84}}))


@pytest.mark.evidence(subject="finer steps: chosen steps of scenes")
def test_where_no_more_steps_could_be_chosen_is_said(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """And finite strain in each step is not tried: it would stop there."""
    monkeypatch.setattr(plan, "LEVELS", LEVELS[:2])
    seen = iter([None, None, None])
    monkeypatch.setattr(chosen_steps, "undetected_contact", lambda *_: next(seen, "the surface folds"))
    simulation = simulate(scene_in(folder), tol=0.01)
    assert simulation.as_json()["tier"] == "corrected"
    assert any(
        "no step could be taken at finite strain: the surface folds" in note for note in simulation.warnings
    )
    assert any("the tolerance 1.0e-02 is not met" in note for note in simulation.warnings)
