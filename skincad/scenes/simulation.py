"""Simulating a scene: run it, read it out, and say what was left out."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from time import perf_counter
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from skincad.base.arrays import Array, Mask
from skincad.base.errors import InputError, did_you_mean, require_goals
from skincad.base.estimate import Estimate
from skincad.base.interrupt import INTERRUPTED
from skincad.base.progress import Tick
from skincad.base.result import Record, Result, item, record, reported, reported_from
from skincad.circuit.model import circuit_network, fitted
from skincad.circuit.state import FilteredSignal, band_limited, delay
from skincad.effects import CondensedPad
from skincad.effects.kinds import LeftOutEffect, Reader, ReaderContext
from skincad.mechanics.contact.state import FrictionCoefficients
from skincad.mechanics.dynamics.ringing import skin_mass
from skincad.mechanics.validity import material_warnings
from skincad.scenes.alarms import report
from skincad.scenes.errors import (
    AROUND,
    BySource,
    SlipErrors,
    Slips,
    in_steps,
    lead,
    shown_band,
    slip_errors,
    slip_share_error,
    slip_step,
    slips_of,
    stress_errors,
    unresolved,
)
from skincad.scenes.march import Level, March
from skincad.scenes.plan import (
    FINITE_STRAIN,
    FREE_ENDS,
    MATTERS,
    SMALL_STRAIN,
    at_finite_strain,
    chosen_steps,
    further,
    left_out_effects,
    model_of,
    path_of,
    refine,
)
from skincad.scenes.runs import (
    MarchSetup,
    Runs,
    differential,
    drifted,
    halts_of,
    march_on,
    piece_for,
    spent,
)
from skincad.scenes.scene import Scene
from skincad.shape.skin import skin_of

if TYPE_CHECKING:
    from skincad.scenes.lift import Lift


def energy(march: March) -> dict[str, float]:
    """Return the plate's work, what is stored and lost, mJ, and what is missing, relative to the largest work
    done or energy stored on the way."""
    normal, tangential = march.column("normal"), march.column("tangential")
    down, along = np.diff(march.column("approach")), np.diff(march.column("travel"))
    by_forces = (normal[1:] + normal[:-1]) / 2 * down + (tangential[1:] + tangential[:-1]) / 2 * along
    works = [reading.work for reading in march.readings[1:]]
    by_step = [force if work is None else work for force, work in zip(by_forces, works, strict=True)]
    pushed, largest = sum(by_step), float(np.abs(np.cumsum(by_step)).max(initial=0.0))
    stored = float(march.readings[-1].elastic)
    lost = float(march.column("dissipated").sum())
    kinetic = float(march.readings[-1].kinetic)
    viscous = float(march.column("viscous").sum())
    missing = abs(pushed - stored - kinetic - lost - viscous)
    return {
        "work_mJ": float(pushed),
        "elastic_mJ": stored,
        "kinetic_mJ": kinetic,
        "dissipated_mJ": lost,
        "viscous_mJ": viscous,
        "imbalance": float(missing) / max(largest, float(march.column("elastic").max()), 1e-300),
    }


Readings = Mapping[str, Any]


def _felt(reading: Readings, scene: Scene, march: March, slips: Slips) -> Readings:
    """Slip as the films' outputs show it, against when ridges slip; of outputs with noise for other seeds
    too."""
    readout, noise = scene.readout, reading["output_noise_V_rms"]
    width, alarms = readout.bandwidth_Hz, readout.alarms
    runs, gross, even = slips.runs, slips.gross, scene.history.even
    noises = (
        noise_of_seed
        for part in scene.parts.values()
        if isinstance(part, Reader)
        for noise_of_seed in part.other_noises(_watched(scene), march.time)
    )
    circuit = getattr(scene.parts.get("piezo"), "loaded", None)
    network = circuit_network(fitted(circuit, scene.design)) if circuit else None
    return report(march.time, reading["output_V"], noise, width, runs, gross, alarms, even, noises, network)


# by the key that it follows from
FOLLOWING: dict[str, Callable[[Readings, Scene, March, Slips], Readings]] = {"output_V": _felt}


def read(
    scene: Scene, march: March, slips: Slips, seconds: dict[str, float]
) -> tuple[dict[str, Any], list[str]]:
    """Return what the scene's readers tell, and what follows from it; and their warnings."""
    watched = _watched(scene)
    readings: dict[str, Readings] = {}
    for name, part in scene.parts.items():
        if isinstance(part, Reader):
            with spent(seconds, name):
                readings[f"effects.{name}"] = part.read(watched, march.time, march.readings)
    notes = [note for reading in readings.values() for note in reading.get("warnings", ())]
    readings = {
        who: {key: v for key, v in reading.items() if key != "warnings"} for who, reading in readings.items()
    }
    direct = joined(readings)
    after = {
        f"what follows {key}": FOLLOWING[key](direct, scene, march, slips)
        for key in direct
        if key in FOLLOWING
    }
    return joined({**readings, **after}), notes


def _watched(scene: Scene) -> ReaderContext:
    return ReaderContext(scene.design, tuple(scene.readout.ridges), scene.readout.bandwidth_Hz)


def joined(parts: Mapping[str, Readings]) -> dict[str, Any]:
    """Return all keys, of each who tells some; raises ValueError where two tell the same one."""
    merged: dict[str, Any] = {}
    by: dict[str, str] = {}
    for who, keys in parts.items():
        for key, value in keys.items():
            if key in by:
                raise ValueError(f"{who} gives {key!r}, which {by[key]} gives already: rename one of them")
            merged[key], by[key] = value, who
    return merged


@dataclass(frozen=True)
class HeavyPlate(Record):
    """A scene of which no plate.mass is known, in small strain under a plate as heavy as the skin."""

    mass: float = item("g", "of that plate")
    gross_slip_step: int | None = item(meaning="from which the skin slips as a whole")
    slip_lead: dict[int, float | None] = item("ms", "of each monitored ridge before that")
    lead_change: dict[int, float | None] = item("ms", "of that, by the plate's mass alone")


def _heavy_plate(scene: Scene, runs: Runs, timed: Sequence[int]) -> HeavyPlate | None:
    """What a plate as heavy as the skin changes; None where nobody marched it."""
    if runs.heavy is None or runs.every is None:
        return None
    count, halts = skin_of(scene.design).count, halts_of(scene)
    heavy, light = (slips_of(run, count, halts) for run in (runs.heavy, runs.every))
    time = runs.heavy.time

    def leads(slips: Slips) -> dict[int, float | None]:
        return {r: lead(time, slips.gross, slips.steps[r - 1], None).value for r in timed}

    now, before = leads(heavy), leads(light)
    change = {r: None if (a := now[r]) is None or (b := before[r]) is None else a - b for r in timed}
    return HeavyPlate(skin_mass(scene.design), heavy.gross, now, change)


@record(eq=False)
class Simulation(Result):
    """A scene's result. `raw` and `signals`, by monitored ridge: differential stress S1 - S2, MPa, as it is
    and band-limited; `error` MPa its change from the mesh before, None with one mesh, and `stress_errors`
    MPa its whole error by source; `slipping` `(steps + 1, ridges)`; `slip_errors` ms.
    `time` s and `slip_share` are `(steps + 1,)`.
    """

    shown_by = "skincad.outputs.simulations:SIMULATION"
    scene: Scene
    march: March
    raw: dict[int, Array]
    signals: dict[int, FilteredSignal]
    error: dict[int, float] | None = item(
        "MPa", "change from the mesh before", key="differential_stress_error_MPa"
    )
    stress_errors: dict[int, BySource] = item(
        "MPa", "whole error of the largest stress", key="differential_stress_error_by_source_MPa"
    )
    slipping: Mask
    runs: list[list[list[int]]] = item(meaning="steps, of each ridge", key="ridge_slip_intervals")
    slip_steps: list[int | None] = item(meaning="from which each ridge slips for good", key="ridge_slip_step")
    gross_slip_step: int | None = item(meaning="from which the skin slips as a whole")
    slip_share_error: float | None = item(
        meaning="of the share that slips, by mesh, step and on a round skin by its model, mean of all steps"
    )
    slip_errors: SlipErrors
    heavy_plate: HeavyPlate | None = item(meaning="the same under a plate as heavy as the skin")
    left_out: list[LeftOutEffect] = item(meaning="effects left out, and what that may change")
    read: dict[str, Any] = item(meaning="what the scene's readers tell", inline=True)
    seconds: dict[str, float] = item(meaning="wall time by stage, s")
    warnings: tuple[str, ...] = item(meaning="what to know of the numbers")

    name = reported_from("scene.name", meaning="of the scene")

    @reported(meaning="which of the physics is in")
    def effects(self) -> list[str]:
        """Names of the scene's effects."""
        return list(self.scene.effects)

    @reported(meaning="by which model of the skin", key="tier")
    def model(self) -> str:
        """Name of the model that marched."""
        return model_of(self.scene)

    @reported(
        meaning="steps that are solved at finite strain, the skin linear in between; null: all, or none"
    )
    def chosen_steps(self) -> list[int] | None:
        """Steps at which finite strain is solved, None where not by chosen steps."""
        return chosen_steps(self.march)

    @reported(meaning="how many steps were marched")
    def steps(self) -> int:
        """How many steps were marched."""
        return len(self.march.readings) - 1

    stopped = reported_from("march.stopped", meaning="why it ended early")

    time = reported_from("march.time", "s", "of each step, from rest")

    @reported("N", "on the plate, at each step")
    def normal_force(self) -> Array:
        """The plate's normal force `(steps + 1,)`, N."""
        return self.march.column("normal")

    @reported("N", "on the plate, at each step")
    def tangential_force(self) -> Array:
        """The plate's tangential force `(steps + 1,)`, N."""
        return self.march.column("tangential")

    slip_share = reported_from("march.slip_share", meaning="of the touching area that slips, at each step")

    @reported("MPa", "S1 - S2 of each monitored ridge, band-limited")
    def differential_stress(self) -> dict[int, Array]:
        """Band-limited differential stress `(steps + 1,)` by ridge, MPa."""
        return {ridge: signal.value for ridge, signal in self.signals.items()}

    @reported("MPa/s", "its rate")
    def stress_rate(self) -> dict[int, Array]:
        """Its rate `(steps + 1,)` by ridge, MPa/s."""
        return {ridge: signal.rate for ridge, signal in self.signals.items()}

    @reported("MPa/s2", "its second derivative")
    def stress_jerk(self) -> dict[int, Array]:
        """Its second derivative `(steps + 1,)` by ridge, MPa/s2."""
        return {ridge: signal.jerk for ridge, signal in self.signals.items()}

    bandwidth = reported_from("scene.readout.bandwidth_Hz", "Hz", "of the readout", key="bandwidth_Hz")

    @reported(meaning="the largest relative violation of contact and equilibrium", key="residual_max")
    def residual(self) -> float:
        """The largest residual of all steps."""
        return float(self.march.column("residual").max())

    unknowns = reported_from("march.unknowns", meaning="of the mesh")

    @reported("s", "by how much the signals lag behind what is felt", key="signal_delay_s")
    def delay(self) -> float:
        """By how many s the signals lag behind what is felt; steps named by signals have it taken out."""
        return delay(self.scene.readout.bandwidth_Hz)

    @reported(meaning="work of the plate, stored, dissipated; what is missing is relative")
    def energy(self) -> dict[str, float]:
        """Work of the plate, what is stored and dissipated, mJ, and what is missing, relative to the work."""
        return energy(self.march)

    @reported("ms", "by how much a monitored ridge's slip comes before gross slip")
    def lead(self) -> dict[int, Estimate]:
        """By how many ms a monitored ridge's lasting slip comes before gross slip; no value without both,
        no error where nobody asked what the mesh or the step changes."""
        slips = ((ridge, self.slip_steps[ridge - 1]) for ridge in self.scene.timed)
        gross, errors = self.gross_slip_step, self.slip_errors.leads
        return {r: lead(self.march.time, gross, step, errors[r - 1].total) for r, step in slips}

    @reported("ms", "its error by source")
    def lead_error(self) -> dict[int, BySource]:
        """The leads' errors by source, ms."""
        return {ridge: self.slip_errors.leads[ridge - 1] for ridge in self.scene.timed}

    @reported("ms", "the lead without its error")
    def slip_lead(self) -> dict[int, float | None]:
        """The leads' values, ms."""
        return {ridge: estimate.value for ridge, estimate in self.lead.items()}

    @property
    def slip_step_errors(self) -> list[BySource | None]:
        """How many steps `slip_steps` may be wrong by, ridge by ridge; None for one that does not slip."""
        pairs = zip(self.slip_steps, self.slip_errors.slips, strict=True)
        return [in_steps(self.march, step, error) for step, error in pairs]

    @reported(meaning="by how many steps each ridge's may be wrong, by source", key="slip_step_error")
    def _slip_step_error(self) -> list[dict[str, float | None] | None]:
        return [None if error is None else error.with_total() for error in self.slip_step_errors]

    @reported(meaning="by how many steps it may be wrong, by source", key="gross_slip_step_error")
    def _gross_slip_step_error(self) -> dict[str, float | None] | None:
        return None if self.gross_slip_step_error is None else self.gross_slip_step_error.with_total()

    @property
    def gross_slip_step_error(self) -> BySource | None:
        """How many steps `gross_slip_step` may be wrong by; None without gross slip."""
        return in_steps(self.march, self.gross_slip_step, self.slip_errors.gross)

    @property
    def slip_estimates(self) -> list[Estimate]:
        """The step from which each ridge slips for good; no value for one that does not."""
        return list(map(slip_step, self.slip_steps, self.slip_step_errors))

    @property
    def gross_slip_estimate(self) -> Estimate:
        """The step of gross slip; no value without it."""
        return slip_step(self.gross_slip_step, self.gross_slip_step_error)

    @reported("MPa", "of each monitored ridge, either way", key="largest_differential_stress_MPa")
    def largest_stress(self) -> dict[int, Estimate]:
        """A monitored ridge's largest differential stress, MPa, either way, with its whole error."""
        return {
            r: Estimate(float(np.abs(values).max()), self.stress_errors[r].total, "MPa")
            for r, values in self.raw.items()
        }

    def columns(self) -> dict[str, Any]:
        """Return a row for each step: time, the plate's forces, and the signals of each monitored ridge, as
        `differential_stress_MPa.1`; how many ridges slip."""
        by_ridge = {
            "differential_stress_MPa": self.differential_stress,
            "stress_rate_MPa_per_s": self.stress_rate,
            "stress_jerk_MPa_per_s2": self.stress_jerk,
        }
        return {
            "step": list(range(self.steps + 1)),
            "time_s": self.time,
            "normal_force_N": self.normal_force,
            "tangential_force_N": self.tangential_force,
            "approach_mm": self.march.column("approach"),
            "travel_mm": self.march.column("travel"),
            **{f"{key}.{ridge}": row for key, rows in by_ridge.items() for ridge, row in rows.items()},
            "slip_share": self.slip_share,
            "slipping_ridges": self.slipping.sum(axis=1),
        }

    @property
    def exit_status(self) -> int:
        """0 where it ran to its end, 1 where it failed, 130 where Ctrl-C ended it."""
        return INTERRUPTED if self.march.interrupted else 1 if self.march.failed else 0


SCENE_MODELS = "auto", SMALL_STRAIN


def simulate(
    scene: Scene,
    *,
    tol: float | None = None,
    budget: float | None = None,
    tick: Tick | None = None,
    partial: bool = False,
    model: Literal["auto", "small_strain"] = "auto",
) -> Simulation | Lift:
    """March a scene, or lift the object of one with [grip] (scenes/lift.py); what follows is of a march.

    March it on one mesh after the other until the differential stress is within `tol` of its largest.

    A scene that names no law, and of which small strain leaves out more than `tol`, is marched with finite
    strain in chosen steps next, then in each (scenes/plan.py): `model` and `scene` of the result say so.
    Without `tol` chosen steps are taken where they change more than a tenth and are expected to take at most
    a minute; what free ends change is computed too. Where the surface folds they are taken again with rounder
    fillets; where a corner snaps these are what is told, and `warnings` says so. With `model="small_strain"`
    neither is: the effects are the scene's own, for many scenes or for a first look.

    `seconds` are by stage; `effect <name>` are those that an effect's own code took, beside what it makes
    others' work longer, which only a run without it tells (`skincad accuracy --ladder effects`).

    The error is the change from the mesh before; `budget` s ends before a mesh that would overrun
    it, but the coarsest is marched whatever it takes; alone it asks for the best that it buys. `tick` is told
    stage, step and the seconds left. A march that stops early is a result: its `march.stopped` says why.
    With `partial` Ctrl-C too ends in a result, of what is done by then. Raises ExhaustedError where memory or
    another resource does not suffice for the coarsest mesh.
    """
    if model not in SCENE_MODELS:
        raise InputError("model", "unknown model of a scene", model, did_you_mean(model, SCENE_MODELS))
    if scene.grip is not None:
        for key, value in (("tol", tol), ("budget", budget)):
            if value is not None:
                raise InputError(key, "has no effect on a lift", value, "leave it out")
        from skincad.scenes.lift import lift

        return lift(scene, tick=tick)
    more = model == "auto"
    run = marched(scene, tol=tol, budget=budget, tick=tick, partial=partial, further_models=more)
    return read_out(scene, run)


@dataclass(frozen=True, eq=False)
class SceneRun:
    """What was marched, the runs, and the seconds that they took, by stage."""

    on: MarchSetup
    runs: Runs
    seconds: dict[str, float]


def marched(
    scene: Scene,
    *,
    tol: float | None = None,
    budget: float | None = None,
    tick: Tick | None = None,
    partial: bool = False,
    further_models: bool = False,
) -> SceneRun:
    """Return a scene's runs, as `simulate` asks for them; nothing has read them yet. `further_models` says
    whether a model beyond the scene's own may be marched."""
    require_goals(tol, budget, "0.02")
    began, seconds = perf_counter(), dict[str, float]()
    on = MarchSetup(scene, piece_for(scene, seconds), tick, partial, seconds=seconds)
    runs = refine(on, tol, budget, began)
    if further_models:
        on, runs = further(on, runs, tol, budget, began)
    return SceneRun(on, runs, {"total": perf_counter() - began, **seconds})


def read_out(scene: Scene, run: SceneRun) -> Simulation:
    """Return what a scene's readers tell of a march: its own, or that of a scene which differs in its readers
    and its band alone (`marching` is the same)."""
    more = {name: table for name, table in run.on.scene.effects.items() if name in (FINITE_STRAIN, FREE_ENDS)}
    if more:
        scene = scene.with_(effects=more)
    return _simulation(replace(run.on, scene=scene), run.runs, dict(run.seconds))


def marching(scene: Scene) -> Scene:
    """Return the scene as its march knows it: without what only reads it."""
    readers = {name: None for name, part in scene.parts.items() if isinstance(part, Reader)}
    return scene.with_(effects=readers, readout={"bandwidth_Hz": None})


def at_level(scene: Scene, level: Level, tick: Tick | None = None) -> Simulation:
    """March a scene on one mesh alone, whatever its error, which nobody estimates then."""
    began, seconds = perf_counter(), dict[str, float]()
    on = MarchSetup(scene, piece_for(scene, seconds), tick, seconds=seconds)
    runs = Runs(march_on(level, on))
    return _simulation(on, runs, {"total": perf_counter() - began, **seconds})


def friction_cone(scene: Scene) -> FrictionCoefficients:
    """Return what friction bears; without any no ridge bears a pull, so that any cone does."""
    return scene.cone or FrictionCoefficients(1.0, 1.0)


def shown_signal(time: Array, values: Array, width: float) -> FilteredSignal:
    """Return a stress in a band of `width` Hz. Where the steps don't show that band a corner between two of
    them has rung out by the second: the jerk is each step's mean then."""
    signal = band_limited(time, values, width)
    if shown_band(time, width) == width:
        return signal
    return replace(signal, jerk=np.append(0.0, np.diff(signal.rate) / np.diff(time)))


def _simulation(on: MarchSetup, runs: Runs, seconds: dict[str, float]) -> Simulation:
    """The result of the march that counts."""
    began = perf_counter()
    scene, march, notes = on.scene, runs.march, [*runs.notes, *at_finite_strain(runs)]
    raw, width = differential(scene, march), scene.readout.bandwidth_Hz
    halts = halts_of(scene)
    slips = slips_of(march, skin_of(scene.design).count, halts)
    path = path_of(march)
    cone, driven = friction_cone(scene), scene.history.tangential_force_N is None
    last = march.states.get(len(march.readings) - 1)
    by_pad = march.pad.left_out(last, cone.static) if last and isinstance(march.pad, CondensedPad) else []
    left_out = left_out_effects(scene, path, by_pad)
    change = math.fsum(entry.change for entry in left_out)  # of a ridge's load, taken to be the signals'
    # a bare face slips as a whole where friction bears no more, whatever is left out
    moved = 0.0 if scene.bare and not driven else change
    stressed = stress_errors(runs, lambda one: differential(scene, one), change, drifted(scene, march))
    if raw and "film" not in scene.effects:
        notes = [*notes, "effects.film is not named: the stress shown is the silicone's, in the films' place"]
    notes = [*notes, *unresolved(march.time, width)] if raw else notes
    notes = [*notes, *material_warnings(scene.design)]
    notes = [*notes, *(remark for term in scene.terms for remark in term.remarks(scene.asked))]
    if on.piece is not None:
        notes = [*notes, *(remark for term in scene.terms for remark in term.afterwards(path))]
    readings, remarks = read(scene, march, slips, seconds)
    return Simulation(
        scene=scene,
        march=march,
        raw=raw,
        signals={r: shown_signal(march.time, values, width) for r, values in raw.items()},
        error=runs.error,
        stress_errors=stressed,
        slipping=slips.slipping,
        runs=slips.runs,
        slip_steps=slips.steps,
        gross_slip_step=slips.gross,
        slip_share_error=slip_share_error(runs, AROUND if by_pad else 0.0),
        slip_errors=slip_errors(runs, slips, moved, driven, cone, halts),
        heavy_plate=_heavy_plate(scene, runs, scene.readout.ridges),
        left_out=left_out,
        read=readings,
        seconds={**seconds, "total": seconds["total"] + perf_counter() - began},
        warnings=(*notes, *remarks, *(entry.warning for entry in left_out if entry.change > MATTERS)),
    )
