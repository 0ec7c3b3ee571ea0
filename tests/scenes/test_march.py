"""The march on springs: a new effect is a file and a line, a failing step ends it, and steps stand on the
corners of a history, on random ones with corners between the equal steps."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from skincad.base import InputError, quantity
from skincad.effects import CondensedPad, Friction, Law, PadChange, Reader, Share, Step
from skincad.mechanics import ContactError, ContactPad, ContactState, Drive
from skincad.scenes import LEVELS, History, March, Simulation, at_level, coarse_steps, frames, simulate
from skincad.scenes.march import march
from tests.small_scene import make_up_effects, small_scene

TIMES = np.linspace(0.0, 1.0, 5)


def block() -> CondensedPad:
    """One point on springs of 0.25 and 0.1 mm/N."""
    one, none = np.ones(1), np.zeros(1)
    pad = ContactPad(
        np.diag([0.25, 0.1]), none, none, np.ones(1, dtype=np.int64), one, np.zeros((0, 3, 2)), 1
    )
    return CondensedPad(pad)


def marched(pad: Any, drives: list[Drive], **more: Any) -> March:
    return march(pad, TIMES, drives, [Friction(coefficient=FRICTION)], **more)


FRICTION, SPRING = 0.5, 4.0  # N/mm along


def test_gross_slip_ends_a_march_under_force() -> None:
    run = marched(block(), [Drive(2.0 * bool(i), 0.4 * i) for i in range(5)])
    assert run.stopped == "gross slip"
    assert not run.failed
    assert run.column("tangential") == pytest.approx([0.0, 0.4, 0.8, 1.0], rel=1e-12)
    assert run.column("slips").ravel().tolist() == [False, False, False, True]


def test_a_driven_plate_goes_on_through_gross_slip_and_its_work_is_accounted_for() -> None:
    run = marched(block(), [Drive(2.0 * bool(i), travel=0.2 * i) for i in range(5)])
    assert run.stopped is None
    assert run.column("tangential") == pytest.approx([0.0, 0.8, 1.0, 1.0, 1.0], rel=1e-12)
    # by hand: 0.25 mm of spring, the other 0.55 mm of 0.8 are slip at 1 N but for the step that breaks off
    assert run.column("dissipated").sum() == pytest.approx(0.15 * 0.9 + 0.4, rel=1e-12)


def test_a_march_tells_the_hardest_that_a_ridge_was_pressed() -> None:
    """Two ridges of unlike springs in z: the stiffer bears 2/3 of 3 N, by hand; then the plate eases off."""
    none, two = np.zeros(2), np.ones(2)
    springs = np.diag([0.25, 0.25, 0.1, 0.2])
    pad = ContactPad(springs, none, none, np.array([1, 2]), two, np.zeros((0, 3, 4)), 2)
    run = marched(CondensedPad(pad), [Drive(force, 0.0) for force in (0.0, 1.0, 3.0, 2.0, 1.0)])
    assert run.loads[:, 0].max() == pytest.approx(2.0, rel=1e-9)


class _Failing(CondensedPad):
    def advanced(self, state: ContactState, step: Step, share: Share) -> ContactState:
        if step.end > 0.6:
            raise self.failure
        return super().advanced(state, step, share)


@pytest.mark.parametrize("failure", [ContactError("the sets do not settle"), KeyboardInterrupt()])
def test_what_cannot_go_on_stops_with_what_it_has(failure: BaseException) -> None:
    model = _Failing(block().pad, block().skin)
    object.__setattr__(model, "failure", failure)
    drives = [Drive(0.5 * i, 0.0) for i in range(5)]
    run = marched(model, drives, partial=True)
    assert len(run.readings) == run.time.size == 3
    assert run.failed == isinstance(failure, ContactError)
    assert run.interrupted == isinstance(failure, KeyboardInterrupt)
    if run.failed:
        assert run.stopped == "step 3, t = 0.75 s: the sets do not settle"
    else:  # it goes on to a caller who does not ask for a part
        with pytest.raises(KeyboardInterrupt):
            marched(model, drives)


class Softer(Law):
    """A law that makes every compliance larger."""

    factor: float = quantity("1", "of the compliance", gt=0.0)

    def marched(self, part: Any, mesh: Any, order: int, films: bool, terms: Any) -> CondensedPad:  # noqa: ARG002
        from dataclasses import replace

        from skincad.mechanics import sliding

        pad = sliding(part, mesh, order, films)
        # its field is that of the harder pad, and would lie above the plate
        return CondensedPad(replace(pad, compliance=self.factor * pad.compliance, whole=None))


class Thicker(PadChange):
    """A body that changes the pad."""

    def check(self, design: Any) -> None:
        if design.ridge.count > 3:
            raise InputError("", "is for three ridges", design.ridge.count)

    def changed(self, pad: Any, design: Any) -> Any:  # noqa: ARG002
        from dataclasses import replace

        return replace(pad, young_modulus=2 * pad.young_modulus, film_modulus=2 * pad.film_modulus)


class Telling(Reader):
    """A readout with a key of its own."""

    def read(self, watched: Any, time: Any, readings: Any) -> dict[str, Any]:  # noqa: ARG002
        return {"largest_force_N": max(r.normal for r in readings)}


SMALL = [
    "skin=small.toml",
    "history.time_s=[0.0, 1.0]",
    "history.normal_force_N=[0.0, 1.0]",
    "history.tangential_force_N=[0.0, 0.0]",
    "history.steps=2",
    "effects.film=none",
    "effects.friction=none",
    "readout.ridges=[]",
]


@pytest.mark.slow
def test_a_new_effect_is_its_own_file_and_a_line_in_the_table(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Any
) -> None:
    make_up_effects(monkeypatch, Softer, Thicker, Telling)

    def run(*more: str) -> Any:
        return simulate(small_scene(tmp_path, "yamada-2002-slip", *SMALL, *more))

    plain = run()
    soft = run("effects.softer.factor=2.0", "effects.telling={}")
    stiff = run("effects.thicker={}")
    # in small strain a pad of half the stiffness is the same at half the force
    assert soft.march.readings[1].approach > plain.march.readings[1].approach
    assert stiff.march.readings[2].approach == pytest.approx(plain.march.readings[1].approach, rel=1e-9)
    assert soft.march.readings[1].approach == pytest.approx(plain.march.readings[2].approach, rel=1e-9)
    assert soft.as_json()["largest_force_N"] == pytest.approx(1.0)
    with pytest.raises(InputError, match="effects: must name one law at most"):
        run("effects.softer.factor=2.0", "effects.small_strain={}")
    with pytest.raises(InputError, match=r"effects\.thicker: is for three ridges, got 9"):
        run("effects.thicker={}", "skin=yamada-2002")


SEEDS = range(40)


def pulses(seed: int, driven: bool = False) -> History:
    """A press, then one to four pulls to either side, each up and down within about a step, up to 1.6 times
    what friction holds, never within 2 % of it; a driven plate's travel is up to 0.8 mm."""
    draw = np.random.default_rng((34, seed))
    steps = int(draw.integers(5, 16))
    normal = float(draw.uniform(0.5, 4.0))
    time, pulls = [0.0, float(draw.uniform(0.05, 0.25))], [0.0, 0.0]
    for _ in range(int(draw.integers(1, 5))):
        begins = time[-1] + draw.uniform(0.1, 0.9) / steps
        width = draw.uniform(0.05, 0.9) / steps
        share = float(draw.choice([draw.uniform(0.2, 0.98), draw.uniform(1.02, 1.6)]))
        size = 0.8 * share / 1.6 if driven else share * FRICTION * normal
        time += [begins, begins + draw.uniform(0.2, 0.8) * width, begins + width]
        pulls += [pulls[-1], float(draw.choice([-1, 1])) * size, 0.0]
    time, pulls = [*time, time[-1] + 0.3], [*pulls, 0.0]
    key = "displacement_mm" if driven else "tangential_force_N"
    forces = [0.0] + [normal] * (len(time) - 1)
    return History(time_s=time, normal_force_N=forces, steps=steps, **{key: pulls})


def marched_through(history: History) -> March:
    return march(block(), history.times, history.drives(), [Friction(coefficient=FRICTION)])


@pytest.mark.parametrize("seed", SEEDS)
def test_a_pull_between_two_steps_slips_where_friction_does_not_hold_it(seed: int) -> None:
    """A line's largest pull is at its ends, so the history's points alone say whether all slips, and when."""
    history = pulses(seed)
    pull, normal = np.abs(np.array(history.tangential_force_N)), np.array(history.normal_force_N)
    slips = np.flatnonzero(pull > FRICTION * normal)
    run = marched_through(history)
    assert (run.stopped == "gross slip") == bool(slips.size)
    if slips.size:
        first = int(slips[0])
        here, before = pull[first] - FRICTION * normal[first], pull[first - 1] - FRICTION * normal[first - 1]
        span = history.time_s[first] - history.time_s[first - 1]
        begins = history.time_s[first] - span * here / (here - before)
        assert begins <= run.time[-1] <= history.time_s[first]


@pytest.mark.parametrize("seed", SEEDS)
def test_what_a_driven_plate_did_between_two_steps_is_in_the_end(seed: int) -> None:
    """A point on a spring, dragged under a constant force: by hand from point to point of the history."""
    history = pulses(seed, driven=True)
    force, most = 0.0, FRICTION * history.normal_force_N[-1]
    travel = history.displacement_mm or []
    for before, after in pairwise(travel):
        force = float(np.clip(force + SPRING * (after - before), -most, most))
    assert marched_through(history).column("tangential")[-1] == pytest.approx(force, abs=1e-9)


@pytest.mark.parametrize("seed", SEEDS)
def test_each_corner_has_a_time_and_no_other_is_added(seed: int) -> None:
    history = pulses(seed)
    times, drives = history.times, history.drives()
    even = np.linspace(0.0, history.time_s[-1], history.steps + 1)
    assert times[history.even].tolist() == even.tolist()
    assert np.all(np.diff(times) > 0)
    for time, pull in zip(history.time_s, history.tangential_force_N or [], strict=True):
        (here,) = np.flatnonzero(np.abs(times - time) < 1e-14)
        assert drives[here].tangential == pytest.approx(pull, abs=1e-12)
    assert times.size <= even.size + len(history.time_s)
    assert history.step_count == times.size - 1
    indices = coarse_steps(history.step_count, history.points)
    assert np.isin(history.time_s, times[indices]).all()


@pytest.mark.parametrize("seed", SEEDS)
def test_a_history_with_its_corners_on_steps_has_the_equal_steps_alone(seed: int) -> None:
    """To the bit, by decimals and by sums; points on a straight line are no corners wherever they are."""
    draw = np.random.default_rng((35, seed))
    steps, step = int(draw.integers(4, 2000)), float(f"{10 ** draw.uniform(-6, 2):.3g}")
    places = np.sort(draw.choice(np.arange(1, steps), min(steps - 1, 6), replace=False))
    places = np.array([0, *places, steps])
    time = [float(f"{step * place:.12g}") for place in places] if seed % 2 else (step * places).tolist()
    normal = [0.0, *draw.uniform(0.0, 5.0, places.size - 1).tolist()]
    if seed % 3 == 0:  # one more between two of them, on the line
        share = draw.uniform(0.1, 0.9)
        time.insert(2, time[1] + share * (time[2] - time[1]))
        normal.insert(2, normal[1] + share * (normal[2] - normal[1]))
    history = History(time_s=time, normal_force_N=normal, tangential_force_N=[0.0] * len(time), steps=steps)
    assert history.times.tolist() == np.linspace(0.0, time[-1], steps + 1).tolist()
    assert history.even.tolist() == list(range(steps + 1))


def test_a_short_pull_is_not_lost(tmp_path: Path) -> None:
    """8 N for half a step, from force to signals: all entries go with `time_s`."""
    changes = [
        "history.time_s=[0.0, 0.1, 0.2003, 0.2013, 0.2023, 0.4]",
        "history.normal_force_N=[0.0, 1.3, 1.3, 1.3, 1.3, 1.3]",
        "history.tangential_force_N=[0.0, 0.0, 0.0, 8.0, 0.0, 0.0]",
        "history.steps=100",
        "readout.ridges=[2]",
        "effects.piezo.circuit=transimpedance",
        "effects.piezo.noise_seed=3",
    ]
    scene = small_scene(tmp_path, "hold", *changes)
    simulation = at_level(scene, LEVELS[0])
    assert simulation.march.stopped == "gross slip"
    assert simulation.march.time[-1] == pytest.approx(0.2013, abs=1e-15)
    data = simulation.as_json()
    count = data["steps"] + 1
    assert data["gross_slip_step"] == data["steps"]
    every = (data["time_s"], data["normal_force_N"], data["differential_stress_MPa"]["2"])
    assert [len(series) for series in (*every, data["output_V"]["2"]["pair"])] == [count] * 4
    assert "103 steps" in str(simulation)
    assert "100 equal ones" in str(simulation)
    assert frames(scene.with_(readout={"frames": 3})) == [0, 50, 103]
    scene.with_(readout={"steps": [103]})
    with pytest.raises(InputError, match="from 0 to 103"):
        scene.with_(readout={"steps": [104]})


def viscous(folder: Path, steps: int, *more: str) -> Simulation:
    """A press and a pull, the corners of which are between steps of a hundredth, not of a 250th."""
    changes = [
        "history.time_s=[0.0, 0.000332, 0.000776, 0.001]",
        "history.normal_force_N=[0.0, 1.2, 1.2, 1.2]",
        "history.tangential_force_N=[0.0, 0.0, 0.4, 0.1]",
        f"history.steps={steps}",
        "readout.ridges=[2]",
        *more,
    ]
    return at_level(small_scene(folder, "hold", *changes), LEVELS[0])


@pytest.mark.evidence(subject="finer steps: corners of histories")
@pytest.mark.parametrize(
    "more",
    [
        ("effects.viscosity.prony=[[0.5, 2e-4]]",),
        ("effects.viscosity={}", "effects.inertia={}", "plate.mass=0.2"),
        ("effects.finite_strain.steps=chosen",),
    ],
)
def test_unequal_steps_march_as_many_small_ones_do(more: tuple[str, ...], tmp_path: Path) -> None:
    """With memory, with masses and in chosen steps."""
    few, many = viscous(tmp_path, 100, *more), viscous(tmp_path, 250, *more)
    assert few.scene.history.step_count == 102
    assert many.scene.history.step_count == 250
    assert few.march.stopped is None
    assert many.march.stopped is None
    assert few.energy["imbalance"] < 1e-2
    exact = np.interp(few.march.time, many.march.time, many.raw[2])
    # 2.5 times the step: what is of first order in it, and where points slip
    assert np.abs(few.raw[2] - exact).max() < 0.03 * np.abs(exact).max()
