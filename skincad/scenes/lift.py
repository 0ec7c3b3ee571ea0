"""A lift: does the object stay, how far does it slide, how hard was it squeezed?

The object is a mass on the skin of a finger: half of it, which the other finger's half mirrors. It is pulled
by its load and held by the skin's friction (carrying.py). The skin is linear about its equilibrium at finite
strain under the first grip. The grip is a force that does not depend on how far the skin gives. Steps are the
recorder's samples.

What a policy hears changes the force a gripper's delay later, so that a lift is marched one delay at a time:
the march, then the films' outputs (ears.py), then the policy (grip.py). Range: at a pull of 0.3 of the grip
the signals are off by 5 % of the largest, as the skin is not linear in the pull.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from time import perf_counter
from typing import Any

import numpy as np

from skincad.base.arrays import Array, Mask
from skincad.base.errors import InputError, RefusedError
from skincad.base.estimate import Estimate
from skincad.base.interrupt import safe_point
from skincad.base.machine import one_blas_thread
from skincad.base.progress import Tick
from skincad.base.result import Result, item, record, reported, reported_from
from skincad.circuit.response import tells_stress
from skincad.detector.detector import Detector, Tuning, change_noise, tuned
from skincad.effects.kinds import FRICTIONLESS, LeftOutEffect, PlatePath
from skincad.effects.piezo import SIDES, Chain
from skincad.mechanics.problem import ContactError
from skincad.mechanics.validity import material_warnings
from skincad.scenes.carrying import Carrier, PressedSkin, carrier
from skincad.scenes.ears import Ears, bandwidth, ears_of, piezo_of, rate_of
from skincad.scenes.errors import slip_by_ridge
from skincad.scenes.grip import (
    HARDER_BY_RATE,
    HEARING,
    Force,
    Grip,
    Raising,
    alarmed,
    fallen,
    followed,
)
from skincad.scenes.march import LEVELS
from skincad.scenes.plan import (
    FINITE_STRAIN,
    IN_CHOSEN_STEPS,
    MATTERS,
    NO_BETTER,
    SMALL_STRAIN,
    left_out_effects,
)
from skincad.scenes.runs import MarchSetup, piece_for
from skincad.scenes.scene import Scene
from skincad.shape.skin import skin_of

LOST = 0.5  # of the skin's width: the object has slid out of the finger; assumption
SLIDES = 1e-6  # mm in a step; less is rounding
ROUNDING = 1e-6  # of a sample
LEANS = 0.3  # of the grip: a pull up to which signals are off by 5 % of the largest (tests/scenes)
SETTLED = 10  # samples at the end in which an object that is held does not slide


@dataclass(frozen=True, eq=False)
class LiftRun:
    """One march of a lift at `time` `(n,)` s: what is `asked` of a finger and its force `grip`, its `pull` on
    the object and the object's `load`, N; the object's `travel` and `slide`, mm; which ridges slip
    `(n, ridges)`, what each bears, `loads` `(n, 3, ridges)` as in `March`; the films' stresses
    `(n, strips, 3)` MPa, their `outputs` `(n, wired, 2)` V with the `noise` in them, and the samples of
    alarms that a policy took. `lost` says whether the object has slid out."""

    time: Array
    asked: Array
    grip: Array
    pull: Array
    load: Array
    approach: Array
    travel: Array
    slide: Array
    slipping: Mask
    loads: Array
    films: Array
    outputs: Array
    noise: Array
    noise_rms: float
    alarms: tuple[int, ...]
    lost: bool
    residual: float
    unknowns: int
    seconds: float

    @property
    def slides(self) -> Mask:
        """Whether the object slides in each step `(n,)`."""
        return np.append(False, np.abs(np.diff(self.slide)) > SLIDES)

    @property
    def held(self) -> bool:
        """Whether the object is in the fingers at the end, and at rest on them."""
        return not self.lost and not bool(self.slides[-SETTLED:].any())


def tuning_of(scene: Scene, rate: float, chain: Chain) -> Tuning:
    """Return the detector's tuning in a scene."""
    pair, alarms = math.sqrt(2) * chain.noise_rms(), scene.readout.alarms
    change = change_noise(alarms, chain.network, chain.bandwidth, rate)
    return tuned(rate, bandwidth(scene, rate), pair, alarms, change=change)


def policy_of(scene: Scene, grip: Grip, rate: float, ears: Ears | None, load: Array) -> Raising | Force:
    """Return the scene's policy under a `load` `(n,)` N, at its start."""
    if grip.policy == "constant":
        return Force(math.inf, grip.force, load, 0)  # what is never needed: it grips as at first
    if grip.policy == "force":
        friction = (scene.cone or FRICTIONLESS).static
        ramp = float(np.abs(load).max()) / friction / (grip.force_rate or math.inf)
        return Force(friction, grip.force, load, math.ceil(((grip.delay or 0.0) + ramp) * rate))
    assert ears is not None  # the scene was checked for it
    tuning = tuning_of(scene, rate, ears.chain)
    begun, late = math.ceil(grip.close * rate), (grip.delay or 0.0) * rate
    if grip.policy == "stress-rate":
        falls = fallen(tuning.window, tuning.noise, differs=tells_stress(ears.chain.network))
        return Raising(falls, late, begun, HARDER_BY_RATE)
    detector = Detector.of(tuning, scene.readout.ridges, rate)
    return Raising(alarmed(detector), late, begun)


@one_blas_thread()
def carried(
    scene: Scene,
    finger: Carrier,
    *,
    rate: float,
    seed: int | None = None,
    gain: float = 1.0,
    finer: int = 1,
    tick: Callable[[int], None] | None = None,
    policy: Raising | Force | None = None,
) -> LiftRun:
    """March a lift on a finger. `gain` is what the films' signals are multiplied by, `finer` how many steps
    are marched in one sample; `policy` is the scene's if not given. Raises ContactError for a step that does
    not converge."""
    began = perf_counter()
    assert scene.grip is not None
    grip = scene.grip.acts(scene.design.grippers or {})
    points, loads = grip.points
    count = max(2, math.ceil(points[-1] * rate)) + 1
    time = np.arange(count) / rate
    load = np.interp(time, points, loads)
    ears = ears_of(scene, rate, count, seed, gain)
    policy = policy or policy_of(scene, grip, rate, ears, load)
    block, closed = max(1, math.ceil((grip.delay or 0.0) * rate - ROUNDING)), math.ceil(grip.close * rate)
    begun = float(finger.start.contact.normal.sum())  # of a skin that is pressed already
    force = begun + (grip.force - begun) * np.minimum(1.0, time / grip.close)
    wanted = np.full(count, grip.force)
    parts = finer * finger.parts(1 / rate / finer)
    states, outputs = [finger.start], [np.zeros((0, 0, len(SIDES)))]
    most, lost = LOST * scene.design.skin.width, False
    while len(states) < count and not lost:
        begin = len(states)
        end = min(count, begin + block)
        free = np.arange(max(begin, closed + 1), end)
        if free.size:
            told = wanted[np.maximum(free - block - 1, 0)]  # so that it changes from then on
            force[free] = followed(grip, told, float(force[free[0] - 1]), 1 / rate)
        for k in range(begin, end):
            safe_point()
            drives = np.linspace((force[k - 1], load[k - 1]), (force[k], load[k]), parts + 1).tolist()
            states.append(finger.through(states[-1], 1 / rate, drives))
            lost = abs(states[-1].slide) > most
            if lost:
                break
        new = states[begin if begin > 1 else 0 :]
        at = len(states) - len(new)
        if ears:
            outputs.append(ears.outputs(np.array([state.films for state in new])))
        asked = float(wanted[max(0, at - 1)])
        wanted[at : len(states)] = policy.wanted(outputs[-1], asked, len(new))
        wanted[len(states) :] = wanted[len(states) - 1]
        if tick:
            tick(len(states) - 1)
    contacts, done = [state.contact for state in states], len(states)
    touches, slips = (np.array([getattr(c, name) for c in contacts]) for name in ("touches", "slips"))
    ridge, ridges = finger.ridge, skin_of(scene.design).count
    of = (ridge[:, None] == np.arange(1, ridges + 1)).astype(float)
    borne = [np.array([getattr(c, name) for c in contacts]) @ of for name in ("normal", "tangential")]
    return LiftRun(
        time=time[:done],
        asked=wanted[:done],
        grip=force[:done],
        pull=np.array([state.pull for state in states]),
        load=load[:done],
        approach=np.array([c.approach for c in contacts]),
        travel=np.array([state.travel for state in states]),
        slide=np.array([state.slide for state in states]),
        slipping=slip_by_ridge(touches, slips, ridge, ridges),
        loads=np.stack([*borne, (touches * finger.skin.area) @ of], axis=1),
        films=np.array([state.films for state in states]),
        outputs=np.concatenate(outputs[1:]) if ears else outputs[0],
        noise=ears.noise[:done] if ears else outputs[0],
        noise_rms=ears.chain.noise_rms() if ears else 0.0,
        alarms=tuple(policy.alarms),
        lost=lost,
        residual=max(c.residual for c in contacts),
        unknowns=finger.unknowns,
        seconds=perf_counter() - began,
    )


HELD, DROPPED, UNDECIDED = "held", "dropped", "undecided"


@record(eq=False)
class Lift(Result):
    """A lift's result: is the object held? `pairs` are runs that tell its errors, by source: one, and what it
    is with something changed. `model` says how the skin is strained."""

    shown_by = "skincad.outputs.simulations:LIFT"
    scene: Scene
    march: LiftRun
    pairs: dict[str, tuple[tuple[LiftRun, LiftRun], ...]]
    model: str = item(meaning="by which model of the skin", key="tier")
    left_out: list[LeftOutEffect] = item(meaning="effects that are not in, with what they may change")
    seconds: dict[str, float] = item(meaning="wall time by stage, s")
    warnings: tuple[str, ...] = item(meaning="what to know of the numbers")

    name = reported_from("scene.name", meaning="of the scene")

    @property
    def grip(self) -> Grip:
        """The grip, with what its gripper is known for."""
        assert self.scene.grip is not None
        return self.scene.grip.acts(self.scene.design.grippers or {})

    policy = reported_from("grip.policy", meaning="what grips harder when")

    gripper = reported_from("grip.gripper", meaning="that grips")

    @reported(meaning="of the object: held, dropped, or undecided where the errors allow both")
    def verdict(self) -> str:
        """Whether the object is held at the end, by all runs or by some."""
        if any(one.held != other.held for pairs in self.pairs.values() for one, other in pairs):
            return UNDECIDED
        return HELD if self.march.held else DROPPED

    @reported(meaning="whether it is held; null where that is undecided")
    def passed(self) -> bool | None:
        """True of an object that is held, False of one that is dropped, None where the errors allow both."""
        return {HELD: True, DROPPED: False}.get(self.verdict)

    @reported(meaning="1 of an object that is held, 0 of one that is dropped; null where that is undecided")
    def held(self) -> int | None:
        """The verdict as a number, to rank and search by."""
        return None if self.passed is None else int(self.passed)

    lost = reported_from("march.lost", meaning="whether it slid out of the fingers, where its slide ends")

    def _errors(self, of: Callable[[LiftRun], float | None]) -> dict[str, float | None]:
        """By how much a number is off by each source: the largest change; None where one run has none."""
        changes = {
            source: [(of(one), of(other)) for one, other in pairs] for source, pairs in self.pairs.items()
        }
        return {
            source: max((abs(b - a) for a, b in each if a is not None and b is not None), default=0.0)
            if not any((a is None) != (b is None) for a, b in each)
            else None
            for source, each in changes.items()
        }

    def _estimate(self, of: Callable[[LiftRun], float | None], unit: str) -> Estimate:
        """A number of the run that counts, with the sum of its errors; none where one is unknown."""
        value, errors = of(self.march), [*self._errors(of).values()]
        known = [error for error in errors if error is not None]
        whole = value is not None and len(known) == len(errors)
        return Estimate(value, math.fsum(known) if whole else None, unit)

    @reported("mm", "by how far the object slides on the skin")
    def slide(self) -> Estimate:
        """How far the object slides, mm; of one that is dropped until it is out of the finger."""
        return self._estimate(_slide, "mm")

    @reported("mm", "its error by source")
    def slide_error(self) -> dict[str, float | None]:
        """The slide's error by source, mm."""
        return self._errors(_slide)

    mass = reported_from("grip.mass", "g", "of the object")

    @reported(meaning="static friction's coefficient, which the policy does not know")
    def friction(self) -> float:
        """Static friction's coefficient."""
        return (self.scene.cone or FRICTIONLESS).static

    delay = reported_from("grip.delay", "s", "from what is felt to a change of force")

    @reported("N", "of a finger that never changes and holds: the largest load over friction")
    def least_grip(self) -> float:
        """The least constant grip that holds, N: without swings of the object."""
        return float(np.abs(self.grip.points[1]).max()) / self.friction

    @reported("N", "largest force of a finger")
    def peak_grip(self) -> Estimate:
        """The largest force of a finger, N."""
        return self._estimate(self._peak, "N")

    @reported("N", "mean force of a finger, from where the table gives up the weight")
    def mean_grip(self) -> Estimate:
        """The mean force of a finger once it has closed, N."""
        return self._estimate(self._mean, "N")

    def _mean(self, run: LiftRun) -> float:
        return float(run.grip[run.time >= self.grip.close].mean())

    def _peak(self, run: LiftRun) -> float:
        return float(run.grip[run.time >= self.grip.close].max())

    @reported(meaning="largest force over the least that holds")
    def peak_grip_ratio(self) -> Estimate:
        """The largest force over the least that holds."""
        return self._estimate(lambda run: self._peak(run) / self.least_grip, "")

    @reported(meaning="mean force over the least that holds")
    def mean_grip_ratio(self) -> Estimate:
        """The mean force over the least that holds."""
        return self._estimate(lambda run: self._mean(run) / self.least_grip, "")

    def _moment(self, of: Callable[[LiftRun], float | None]) -> Estimate:
        """A time, s; a sample more or less at best."""
        time = self._estimate(of, "s")
        sample = float(self.march.time[1])
        return time if time.error is None else Estimate(time.value, time.error + sample, "s")

    @reported("s", "from the first touch, at which a first ridge slips under the load")
    def first_slip(self) -> Estimate:
        """When a first ridge slips, s."""
        return self._moment(lambda run: self._first(run, np.asarray(run.slipping.any(axis=1))))

    def _first(self, run: LiftRun, now: Mask) -> float | None:
        at = np.flatnonzero(now & (run.time >= self.grip.close))
        return float(run.time[at[0]]) if at.size else None

    @reported("s", "at which the whole object slides")
    def slide_begins(self) -> Estimate:
        """When the object begins to slide, s."""
        return self._moment(lambda run: self._first(run, run.slides))

    @reported("s", "of the first alarm")
    def first_alarm(self) -> Estimate:
        """When the policy first takes an alarm, s."""
        return self._moment(lambda run: float(run.time[run.alarms[0]]) if run.alarms else None)

    @reported("s", "at which the force that the first alarm asks for is there")
    def force_arrives(self) -> Estimate:
        """When the first alarm's force is there, s."""
        return self._moment(_arrives)

    @reported("s", "at which the object slides for the last time")
    def slide_ends(self) -> Estimate:
        """When the object's slide ends, s; no value while it still slides at the end."""

        def ends(run: LiftRun) -> float | None:
            at = np.flatnonzero(run.slides)
            return float(run.time[at[-1]]) if at.size and run.held else None

        return self._moment(ends)

    @reported("s", "of each alarm that the policy took")
    def alarms(self) -> list[float]:
        """The times of the alarms that the policy took, s."""
        return [float(self.march.time[at]) for at in self.march.alarms]

    @reported("dB", "of each wired pair over its noise, until the object slides", key="signal_to_noise_dB")
    def signal_to_noise(self) -> dict[int, float | None]:
        """How far each wired pair's signal stands over its noise, dB, from the load on until the object
        slides; None without noise or signal."""
        run, ridges = self.march, self.scene.readout.ridges
        if not run.noise_rms:
            return {}
        begins = self.slide_begins.value
        until = (run.time >= self.grip.close) & (run.time <= (np.inf if begins is None else begins))
        pairs = (run.outputs - run.noise)[until, :, 0] - (run.outputs - run.noise)[until, :, 1]
        levels = np.std(pairs, axis=0) / (math.sqrt(2) * run.noise_rms)
        return {
            r: 20 * math.log10(level) if level > 0 else None
            for r, level in zip(ridges, levels.tolist(), strict=True)
        }

    residual = reported_from(
        "march.residual",
        meaning="the largest relative violation of contact and equilibrium",
        key="residual_max",
    )

    unknowns = reported_from("march.unknowns", meaning="of the mesh")

    def columns(self) -> dict[str, Any]:
        """Return a row for each sample: time, forces, slide, how many ridges slip, alarms and outputs."""
        run = self.march
        alarm = np.zeros(run.time.size, int)
        alarm[list(run.alarms)] = 1
        outputs = {
            f"ridge_{ridge}_{side}_V": run.outputs[:, place, i]
            for place, ridge in enumerate(self.scene.readout.ridges if run.outputs.size else ())
            for i, side in enumerate(SIDES)
        }
        return {
            "time_s": run.time,
            "asked_N": run.asked,
            "grip_N": run.grip,
            "load_N": run.load,
            "pull_N": run.pull,
            "travel_mm": run.travel,
            "slide_mm": run.slide,
            "slipping_ridges": run.slipping.sum(axis=1),
            "alarm": alarm,
            **outputs,
        }


def _slide(run: LiftRun) -> float:
    """How far the object slides at most, mm."""
    return float(np.abs(run.slide).max())


def _arrives(run: LiftRun) -> float | None:
    """When the force that the first alarm asked for is there, s."""
    if not run.alarms:
        return None
    first = run.alarms[0]
    there = np.flatnonzero(run.grip[first:] >= run.asked[first] * (1 - 1e-9))
    return float(run.time[first + there[0]]) if there.size else None


NOISES = 2  # other seeds that tell what noise changes
RAISED = 1.25  # of the first grip, at least: another equilibrium about which the skin is linear


class _Runner:
    """Marches a scene's lift on one skin or another, and counts the seconds of each stage."""

    def __init__(self, scene: Scene, tick: Tick | None) -> None:
        self.scene, self.tick, self.seconds = scene, tick, dict[str, float]()
        self.rate = rate_of(scene)
        piezo = piezo_of(scene)
        self.seed = None if piezo is None else piezo.noise_seed
        steps = scene.history.step_count / (scene.history.time_s[-1] * self.rate)
        self.told = lambda stage, sample: tick(stage, int(sample * steps)) if tick else None

    def run(self, stage: str, finger: Carrier, **how: Any) -> LiftRun:
        """Return one march. Raises RefusedError for a step that does not converge."""
        try:
            how = {"rate": self.rate, "seed": self.seed, "tick": partial(self.told, stage), **how}
            run = carried(self.scene, finger, **how)
        except ContactError as failure:
            raise RefusedError(f"the lift does not converge: {failure}") from None
        self.seconds[stage] = self.seconds.get(stage, 0.0) + run.seconds
        return run


def lift(scene: Scene, *, tick: Tick | None = None) -> Lift:
    """Lift a scene's object and say whether it is held.

    The skin is linear about its equilibrium at finite strain under the first grip; where none is found it is
    in small strain. The lift is marched again about the largest grip, with half the steps, with other noise,
    with signals weaker by what is left out, and in small strain on two meshes: what these change are the
    errors. Raises InputError for a scene without [grip], RefusedError for an object that is too light for
    explicit steps, or a step that does not converge.
    """
    if scene.grip is None:
        raise InputError("grip", "is missing", remedy="add [grip], or call simulate")
    began, runner, on = perf_counter(), _Runner(scene, tick), MarchSetup(scene, piece_for(scene, {}))
    coarse = carrier(scene, on, LEVELS[0])
    small = runner.run(SMALL_STRAIN, coarse)
    finer = runner.run("finer mesh", carrier(scene, on, LEVELS[1]))
    left_out, notes = left_out_effects(scene, _path(small)), [*material_warnings(scene.design)]
    finger, march, raised = coarse, small, list[LiftRun]()
    try:
        finger, march, raised = _pressed(runner, scene.grip.force, small)
        left_out = [entry for entry in left_out if entry.effect != FINITE_STRAIN]
    except ContactError as failure:
        notes = [*notes, NO_BETTER.format(failure), *_beyond(scene, small)]
    pairs = {
        "mesh": [(small, finer)],
        "time_step": [(march, runner.run("finer steps", finger, finer=2))],
        "left_out": [(march, other) for other in raised],
    }
    if scene.grip.policy in HEARING:
        seeds = () if runner.seed is None else range(runner.seed + 1, runner.seed + 1 + NOISES)
        pairs["noise"] = [(march, runner.run("other noise", finger, seed=seed)) for seed in seeds]
        change = math.fsum(entry.change for entry in left_out)
        if change:
            weaker = runner.run("weaker signals", finger, gain=max(0.0, 1 - change))
            pairs["left_out"].append((march, weaker))
    if raised == [small]:
        notes.append("no equilibrium is found under a larger grip: errors are those of small strain")
    notes += _leaning(scene.grip, march)
    return Lift(
        scene=scene,
        march=march,
        pairs={source: tuple(each) for source, each in pairs.items()},
        model=SMALL_STRAIN if finger is coarse else IN_CHOSEN_STEPS,
        left_out=left_out,
        seconds={**runner.seconds, "total": perf_counter() - began},
        warnings=(*notes, *(entry.warning for entry in left_out if entry.change > MATTERS)),
    )


def _pressed(runner: _Runner, grip: float, small: LiftRun) -> tuple[Carrier, LiftRun, list[LiftRun]]:
    """The skin about its equilibrium under the first grip, N, its march, and that about a larger grip; where
    there is no equilibrium under that, the march in small strain. Raises ContactError without the first."""
    began = perf_counter()
    skin = PressedSkin(runner.scene)
    finger = skin.at(grip)
    runner.seconds["finite strain"] = perf_counter() - began
    march = runner.run("lift", finger)
    try:
        other = runner.run("larger grip", skin.at(max(RAISED * grip, float(march.grip.max()))))
    except ContactError:
        other = small
    return finger, march, [other]


def _leaning(grip: Grip, march: LiftRun) -> list[str]:
    """Return a warning where the pull leans the ridges further than is computed."""
    closed = march.time >= grip.close
    most = float((np.abs(march.pull) / march.grip)[closed].max())
    if most <= LEANS:
        return []
    return [f"the pull reaches {most:.2g} of the grip: beyond {LEANS:g}, signals are off by more than 5 %"]


def _beyond(scene: Scene, march: LiftRun) -> list[str]:
    """Return a warning where ridges bear more than small strain's range."""
    ends, borne = scene.law.limits(scene.design), march.loads
    beyond = ends.overload_reason(float(borne[:, 0].max()), float(np.abs(borne[:, 1]).max()))
    return [f"the grip leaves small strain's range: {beyond}"] if beyond else []


def _path(run: LiftRun) -> PlatePath:
    """What indicators see of a lift."""
    films = run.films[:, :, 0]
    return PlatePath(
        time=run.time,
        approach=run.approach,
        travel=run.travel,
        pressed=run.loads[:, 0],
        pulled=run.loads[:, 1],
        slips=run.slipping.astype(float),
        felt=films[:, ::2] - films[:, 1::2],
        area=run.loads[:, 2],
    )
