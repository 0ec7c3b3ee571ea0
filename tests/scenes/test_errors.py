"""When ridges slip, and the errors of slips and of stress: closed forms, finer steps and meshes."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from skincad.base import Array, plain
from skincad.circuit import band_limited
from skincad.effects import Drift, LeftOutEffect, Observables
from skincad.mechanics import FrictionCoefficients
from skincad.scenes import (
    BySource,
    March,
    Runs,
    Simulation,
    coarse_steps,
    intervals,
    load_scene,
    simulate,
    slip_errors,
    slips_of,
)
from skincad.scenes.errors import in_steps, shown_band, slip_step, stress_errors
from skincad.scenes.simulation import shown_signal
from tests.small_scene import THIRD, small_scene

COULOMB = FrictionCoefficients(1.0, 1.0)


def run_of(touches: Array, slips: Array, ridge: Array, every: float = 1e-4, **changes: Array) -> March:
    """A march of points that touch and slip, `(steps + 1, points)`, at equal times, s."""
    readings = tuple(
        Observables(1.0, 1.0, 0.0, 0.0, *both, np.ones(2, dtype=bool), 0.0, 0.0, 0.0)
        for both in zip(touches, slips, strict=True)
    )
    steps, ridges = len(readings), int(ridge.max())
    run = March(every * np.arange(steps), readings, ridge, 0, None, False, {}, np.ones((steps, 3, ridges)))
    return replace(run, **changes)


def two_ridges(first: int, gross: int, every: int = 1) -> March:
    """100 steps of 0.1 ms, or each so many: a ridge slips from a step on, the other from gross slip on."""
    steps = np.arange(0, 101, every)
    slips = np.stack([steps >= first, steps >= gross], axis=1)
    return run_of(np.ones_like(slips), slips, np.array([1, 2]), 1e-4 * every)


def test_fewer_steps_keep_the_history_s_points() -> None:
    indices = coarse_steps(23, np.array([0, 7, 13, 23]))
    assert indices.tolist() == [0, 5, 7, 10, 13, 15, 20, 23]


def test_without_a_source_there_is_no_sum() -> None:
    assert BySource(None, 0.1, 0.0).total is None
    assert BySource(0.1, None, 0.0).total is None
    assert BySource(0.1, 0.2, 0.3).total == pytest.approx(0.6)
    assert BySource(0.1, 0.2, 0.3, 0.4).total == pytest.approx(1.0)
    data = {"mesh": 0.1, "time_step": 0.2, "left_out": 0.3, "drift": 0.4}
    assert plain(BySource(0.1, 0.2, 0.3, 0.4)) == data


def test_the_jerk_of_slow_steps_is_each_steps_mean() -> None:
    """A stress whose rate jumps by 0.02 MPa/s at a step of 4 ms; a band of 5 kHz has rung out by the next."""
    time = 4e-3 * np.arange(100)
    stress = 0.02 * np.maximum(time - 0.2, 0.0)
    assert shown_band(time, 5000.0) == 125.0
    assert shown_band(time, 100.0) == 100.0
    signal = shown_signal(time, stress, 5000.0)
    assert signal.jerk.max() == pytest.approx(0.02 / 4e-3, rel=1e-6)
    assert signal.jerk @ np.full(100, 4e-3) == pytest.approx(0.02, rel=1e-6)
    assert np.array_equal(shown_signal(time, stress, 100.0).jerk, band_limited(time, stress, 100.0).jerk)


def test_runs_of_slip() -> None:
    assert intervals(np.array([1, 1, 0, 0, 1, 0, 1], dtype=bool)) == [[0, 1], [4, 4], [6, 6]]
    assert intervals(np.zeros(3, dtype=bool)) == []


def test_a_ridge_slips_when_all_that_touches_slips() -> None:
    touches = np.array([[0, 0, 0], [1, 1, 1], [1, 0, 1], [1, 1, 0]], dtype=bool)
    slips = np.array([[0, 0, 0], [1, 0, 0], [1, 0, 1], [1, 1, 0]], dtype=bool)
    ridge = np.array([1, 1, 2])
    state = slips_of(run_of(touches, slips, ridge), 2)
    assert state.slipping.tolist() == [[False, False], [False, False], [True, True], [True, False]]
    assert state.runs == [[[2, 3]], [[2, 2]]]
    assert state.gross == 2
    assert state.steps == [2, 2]
    assert slips_of(run_of(touches[:2], slips[:2], ridge), 2).gross is None


@pytest.mark.parametrize(("gross", "last", "wanted"), [(9, 20, 7), (None, 9, 7), (None, 10, None)])
def test_a_slip_that_lasts_goes_on_until_gross_slip_or_the_end(gross, last: int, wanted: int | None) -> None:
    """Of two runs, to step 4 and to step 9, beside a ridge that slips at gross slip alone."""
    steps = np.arange(last + 1)
    slips = np.stack([((steps >= 2) & (steps <= 4)) | ((steps >= 7) & (steps <= 9)), steps == gross], axis=1)
    state = slips_of(run_of(np.ones_like(slips), slips, np.array([1, 2])), 2)
    assert state.gross == gross
    assert state.steps[0] == wanted


def ridge_error(
    time: Array, normal: Array, pull: Array, area: Array, step: int | None, change: float, cone=COULOMB
) -> float:
    """By how many ms a slip from `step` on moves with a change of its ridge's loads."""
    slips = (np.arange(time.size) >= (time.size if step is None else step))[:, None]
    loads = np.stack([normal, pull, area], axis=1)[:, :, None]
    run = run_of(np.ones_like(slips), slips, np.ones(1, dtype=int), time=time, loads=loads)
    return slip_errors(Runs(run), slips_of(run, 1), change, False, cone).slips[0].left_out


@pytest.mark.parametrize("change", [0.0, 0.1, 1.0])
def test_a_pull_that_grows_evenly_slips_earlier_by_its_share(change: float) -> None:
    """A ratio that rises evenly from 0 to 1 in 10 ms passes 1 / (1 + c) at 10 ms / (1 + c)."""
    time, pull, ones = np.linspace(0.0, 0.01, 1001), np.linspace(0.0, -2.0, 1001), np.ones(1001)
    shift = ridge_error(time, 4 * ones, pull, ones, 1000, change)
    assert shift == pytest.approx(10.0 * (1 - 1 / (1 + change)), abs=0.011)  # a step of 0.01 ms


def test_an_earlier_pull_does_not_count_once_it_was_eased() -> None:
    time, ones = np.linspace(0.0, 0.01, 11), np.ones(11)
    ratio = np.array([0, 0.9, 0.9, 0.1, 0.2, 0.4, 0.6, 0.8, 1, 1, 1])
    assert ridge_error(time, ones, ratio, ones, 8, 0.5) == pytest.approx(1.0)  # from 0.8 on; 0.67 is needed
    assert ridge_error(time, ones, ratio, ones, None, 0.5) == 0.0


def test_by_a_constant_shear_stress_the_area_counts() -> None:
    """A pull that stays while the area shrinks from 2 to 1 mm2 uses ever more of what the area bears."""
    time, ones, area = np.linspace(0.0, 0.01, 101), np.ones(101), np.linspace(2.0, 1.0, 101)
    cone = FrictionCoefficients(1.0, 1.0, ((0.1, 0.1),))
    shift = ridge_error(time, 4 * ones, 0.1 * ones, area, 100, 0.25, cone)
    assert shift == pytest.approx(2.5, abs=0.11)  # from 1.25 mm2 on; a step of 0.1 ms
    # never below
    assert ridge_error(time, 4 * ones, 0.1 * ones, area, 100, 0.25) == pytest.approx(10.0)


def test_a_slips_error_is_told_in_steps() -> None:
    """0.1 ms a step; without a slip there is nothing to be wrong."""
    march = March(np.linspace(0.0, 0.01, 101), (), np.zeros(0, dtype=int), 0, None, False, {}, np.zeros(0))
    error = in_steps(march, 40, BySource(0.2, 0.1, 1.5))
    assert error is not None
    assert error[:3] == (2, 1, 15)
    assert error.with_total() == {**error._asdict(), "total": 18}
    assert str(slip_step(40, error)) == "40 ± 18 steps"
    unknown = in_steps(march, 40, BySource(None, 0.1, 1.5))
    assert unknown is not None
    assert unknown.with_total() == {**unknown._asdict(), "total": None}
    assert slip_step(40, unknown).error is None
    assert in_steps(march, None, BySource(0.2, 0.1, 1.5)) is None
    assert slip_step(None, None).value is None


def test_mesh_and_step_move_slips_and_leads_each_by_its_own() -> None:
    """The mesh moves slip by 3 steps and gross slip by 1, fewer steps by 20 and 10; a lead by the rest."""
    run = two_ridges(40, 80)
    runs = Runs(run, before=two_ridges(43, 81), every=two_ridges(30, 70), coarse=two_ridges(50, 80, 5))
    errors = slip_errors(runs, slips_of(run, 2), 0.0, True, COULOMB)
    assert errors.slips[0][:3] == pytest.approx((0.3, 0.5, 0.0))  # ms
    assert errors.slips[1][:3] == pytest.approx((0.1, 0.25, 0.0))
    assert errors.gross == errors.slips[1]
    assert errors.leads[0][:3] == pytest.approx((0.2, 0.25, 0.0))
    assert errors.leads[1][:3] == pytest.approx((0.0, 0.1, 0.0))  # a step at least


def test_a_slip_that_one_march_has_not_is_as_far_off_as_its_end() -> None:
    run, never = two_ridges(40, 80), 1000
    runs = Runs(run, before=two_ridges(never, never))
    errors = slip_errors(runs, slips_of(run, 2), 0.0, True, COULOMB)
    assert errors.slips[0].mesh == pytest.approx(6.0)
    assert errors.gross.mesh == pytest.approx(2.0)
    assert errors.leads[0].mesh == pytest.approx(4.0)
    assert errors.slips[0].time_step is None


def test_drift_counts_by_what_it_is_of_each_force_at_the_slip() -> None:
    """0.1 of 2 N of pull and 0.2 of 4 N pressed change the share of friction that is used by 0.05 + 0.05."""
    run, none = two_ridges(100, 100), np.zeros((2, 2))
    drift = Drift(np.array([[0.1, 0.0], [0.2, 0.0]]), np.zeros((0, 3)))
    loads = np.ones((101, 3, 2))
    loads[:, :2, 0] = np.stack([np.full(101, 4.0), np.linspace(0.0, -2.0, 101)], axis=1)
    for drift_case, of_slip in ((drift, 10.0 * (1 - 1 / 1.1)), (Drift(none, drift.films), 0.0)):
        readings = tuple(replace(reading, drift=drift_case) for reading in run.readings)
        drifting_run = replace(run, readings=readings, loads=loads)
        errors = slip_errors(Runs(drifting_run), slips_of(drifting_run, 2), 0.0, False, COULOMB)
        assert errors.slips[0].drift == pytest.approx(of_slip, abs=0.11)  # a step of 0.1 ms
        assert errors.slips[1].drift == 0.0


def cut_after(run: March, step: int) -> March:
    """The march in chosen steps, of which this is the last."""
    drifts = [Drift(np.zeros((2, 2)), np.zeros((1, 3)), i <= step, "") for i in range(len(run.readings))]
    drifts[-1] = drifts[-1]._replace(cut="a corner snaps")
    readings = zip(run.readings, drifts, strict=True)
    return replace(run, readings=tuple(replace(one, drift=drift) for one, drift in readings))


def test_other_fillets_count_by_what_they_change_until_one_march_chooses_no_more() -> None:
    """5 % of the friction used in the last fifth of those steps, 2.5 % of the median ridge: twice that, for
    nobody knows what they change later."""
    run = two_ridges(100, 100)
    loads = np.ones((101, 3, 2))
    loads[:, 1] = -np.linspace(0.0, 1.0, 101)[:, None]
    other = loads.copy()
    other[:, 1, 0] *= np.where(np.arange(101) > 50, 1.5, np.where(np.arange(101) > 30, 1.05, 1.2))
    march, rounder = replace(run, loads=loads), cut_after(replace(run, loads=other), 50)
    errors = slip_errors(Runs(march, fillets=rounder), slips_of(run, 2), 0.0, False, COULOMB)
    assert errors.slips[0].left_out == pytest.approx(10.0 * (1 - 1 / 1.1), abs=0.11)  # a step of 0.1 ms
    assert errors.slips[1].left_out == pytest.approx(10.0 * (1 - 1 / 1.05), abs=0.11)


def test_other_fillets_change_a_stress_by_the_most_until_then() -> None:
    time = np.arange(11.0)
    rounder = cut_after(pressed(time, np.where(time > 5, 9.0, 0.25 * time)), 4)
    errors = stress_errors(Runs(pressed(time, time), fillets=rounder), stress, 0.1, {})
    assert errors[1].left_out == pytest.approx(0.1 * 10 + 0.75 * 4 * 1.0)


def euler(steps: int, gross: float = np.inf) -> March:
    """A stress that grows by 2 t, which steps forward miss by t times the step; of one point that slides from
    `gross` on."""
    time = np.linspace(0.0, 20.0, steps + 1)
    return pressed(time, np.concatenate([[0.0], np.cumsum(2 * time[:-1] * np.diff(time))]), gross)


def pressed(time: Array, stress: Array, gross: float = np.inf) -> March:
    """One point that slides from `gross` on, and a strip of this stress."""
    one = np.ones(1, dtype=bool)
    readings = tuple(
        Observables(1.0, 1.0, 0.0, 0.0, one, one & (at >= gross), np.full((1, 3), value), 0.0, 0.0, 0.0)
        for at, value in zip(time, stress, strict=True)
    )
    return March(time, readings, np.ones(1, dtype=int), 0, None, False, {}, np.zeros((time.size, 3, 1)))


def stress(march: March) -> dict[int, Array]:
    return {1: march.column("films")[:, 0, 0]}


def error(change: float = 0.0, mesh: dict[int, float] | None = None, **marches: March | None) -> BySource:
    counts = pressed(np.arange(3.0), np.array([0.0, -3.0, 2.0]))
    return stress_errors(Runs(counts, error=mesh, **marches), stress, change, {})[1]


def test_the_time_steps_share_is_four_errors_of_first_order() -> None:
    every, coarse = euler(20), euler(4)
    exact = np.abs(stress(every)[1] - every.time**2).max()
    assert error(every=every, coarse=coarse).time_step == pytest.approx(4 * float(exact))


@pytest.mark.parametrize(("gross", "coarse_gross"), [(12.0, np.inf), (np.inf, 12.0), (15.0, 12.0)])
def test_from_gross_slip_on_nothing_is_compared(gross: float, coarse_gross: float) -> None:
    """12 s: the march with steps of 5 s has it at 15 s. At 10 s steps of 1 s miss 10, of 5 s they miss 50."""
    known = error(every=euler(20, gross), coarse=euler(4, coarse_gross))
    assert known.time_step == pytest.approx(40.0)


def test_of_two_marches_without_a_common_step_nothing_is_known() -> None:
    assert error(every=euler(20, 3.0), coarse=euler(4)).time_step is None
    assert error(every=euler(20), coarse=None).time_step is None


def test_what_is_left_out_is_a_share_of_the_largest() -> None:
    result = error(0.2, {1: 0.1})
    assert result[:3] == (0.1, None, pytest.approx(0.6))
    assert error()[:3] == (None, None, 0.0)


def test_ctrl_c_while_the_steps_error_is_found_keeps_the_march(tmp_path: Path) -> None:
    def tick(stage: str, step: int, left: float | None = None) -> None:
        if stage == "march with fewer steps" and step:
            raise KeyboardInterrupt

    scene = small_scene(tmp_path, "yamada-2002-press", THIRD, "history.steps=12", "readout.ridges=[3]")
    simulation = simulate(scene, partial=True, tick=tick)
    assert simulation.march.interrupted
    assert len(simulation.march.readings) == 13
    assert simulation.slip_errors.leads[2].time_step is None
    assert simulation.slip_errors.slips[2].time_step is None
    assert simulation.stress_errors[3].time_step is None


@cache
def slip(*more: str) -> Simulation:
    told = ["readout.ridges=[1,2,3,4,6,7,8]", "effects.small_strain.masses=false"]
    return simulate(load_scene("yamada-2002-slip", [*told, *more]))


@pytest.mark.evidence(subject="finer steps: slips and stress")
def test_slips_leads_and_stress_hold_against_finer_steps() -> None:
    """110 steps of 0.05 ms on two meshes against 550 on the same: a step of the coarse march is five of the
    fine one. Stress before gross slip, at the times of both."""
    coarse, fine = slip("history.steps=110"), slip()
    for ridge, estimate in coarse.lead.items():
        error = coarse.slip_errors.leads[ridge - 1]
        assert error.time_step >= 0.05 - 1e-9
        assert abs(estimate.value - fine.lead[ridge].value) <= error.mesh + error.time_step + 1e-9
    for estimate, error, other in zip(
        coarse.slip_estimates, coarse.slip_step_errors, fine.slip_steps, strict=True
    ):
        assert (estimate.value is None) == (error is None) == (other is None)
        if error is not None:
            assert error.time_step >= 1.0
            assert abs(estimate.value - other / 5) <= error.mesh + error.time_step + 1e-9
    assert coarse.gross_slip_step == 110
    assert coarse.gross_slip_estimate.error == 1.0  # friction alone says when, where the force is given
    for ridge, error in coarse.stress_errors.items():
        difference = float(np.abs(coarse.raw[ridge][:110] - fine.raw[ridge][:550:5]).max())
        assert difference <= error.time_step < error.left_out


@pytest.mark.slow
def test_what_is_told_of_slips_and_stress() -> None:
    simulation = slip("history.steps=110")
    data = simulation.as_json()
    assert len(data["slip_step_error"]) == len(data["ridge_slip_step"]) == 9
    for step, error in zip(data["ridge_slip_step"], data["slip_step_error"], strict=True):
        assert (step is None) == (error is None)
        assert error is None or error["total"] == error["mesh"] + error["time_step"] + error["left_out"]
    alone = {source for source, share in data["gross_slip_step_error"].items() if share}
    assert alone == {"time_step", "total"}  # friction alone says when, where the force is given
    assert data["gross_slip_step_error"]["total"] == 1.0
    by_source = data["differential_stress_error_by_source_MPa"]
    assert {r: errors["mesh"] for r, errors in by_source.items()} == data["differential_stress_error_MPa"]
    lead = data["lead_ms"]["3"]
    assert lead["error"] == pytest.approx(sum(data["lead_error_ms"]["3"].values()))
    assert lead["value"] == data["slip_lead_ms"]["3"]
    assert data["lead_error_ms"]["3"]["left_out"] > data["lead_error_ms"]["3"]["mesh"]
    assert 0 < simulation.seconds["march with fewer steps"] < simulation.seconds["march"]
    whole = data["largest_differential_stress_MPa"]["3"]
    assert whole["error"] == pytest.approx(sum(by_source["3"].values()))
    change = sum(entry.change for entry in simulation.left_out)
    assert by_source["3"]["left_out"] == pytest.approx(change * whole["value"])
    words = simulation.details()
    largest = max(errors["left_out"] for errors in data["slip_step_error"] if errors)
    assert f"3 from step {simulation.slip_steps[2]}, " in words
    assert "; all of them from step 110" in words
    assert f" from mesh and time step, {largest:.0f} steps from what is left out (notes)" in words
    first, error, run, *notes, last = str(simulation).splitlines()
    assert run == "  run            after 110 of 110 steps: gross slip. Small strain."
    slips = "the whole skin slips from step 110 on; ridges 2 and 8 for good from step 96 on."
    assert first == f"yamada-2002-slip: {slips}"
    steps = simulation.slip_steps
    assert {96} == {steps[1], steps[7], min(filter(None, steps))}
    worst = max(filter(None, data["slip_step_error"]), key=lambda errors: errors["total"])
    total, by_effects = (math.ceil(worst[source]) for source in ("total", "left_out"))
    assert f"a slip may come up to {total} steps earlier or later; {by_effects} steps by eff" in error
    left_out = {effect.warning for effect in simulation.left_out}
    assert [note.removeprefix("  note           ") for note in notes] == [
        warning for warning in simulation.warnings if warning not in left_out
    ]
    worst_effect = max(simulation.left_out, key=lambda effect: effect.change)
    assert last.startswith("Next: ")
    assert worst_effect.effect in last
    assert f"by {worst_effect.change:.0%}." in last


@pytest.mark.slow
def test_the_next_step_adds_what_is_missed_most() -> None:
    simulation = slip("history.steps=20")

    def step(**changes: float) -> str:
        left_out = [LeftOutEffect(effect, "told by", change) for effect, change in changes.items()]
        return str(replace(simulation, left_out=left_out)).splitlines()[-1]

    assert step(finite_strain=0.5, inertia=0.2).startswith(
        "Next: `skincad simulate SCENE --tol 0.05` includes"
    )
    assert step(finite_strain=0.5).endswith("leaving it out may change signals by 50%.")
    assert step(finite_strain=0.1, inertia=0.2).startswith("Next: add [effects.inertia] and plate.mass")
    assert "--set effects.free_ends={}` adds free_ends" in step(free_ends=0.1)
    amplifier = (
        "Next: `skincad simulate SCENE --set effects.piezo.circuit=yamada-2002` adds the slip detector."
    )
    assert step() == step(free_ends=0.01) == amplifier
