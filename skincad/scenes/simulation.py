"""Simulating a scene: run it, read it out, and say what was left out."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any

import numpy as np

from skincad.base.arrays import Array, Mask
from skincad.base.errors import require_goals
from skincad.base.estimate import Estimate
from skincad.base.interrupt import INTERRUPTED
from skincad.base.progress import Tick
from skincad.base.result import Result
from skincad.circuit.state import FilteredSignal, band_limited, delay
from skincad.effects.kinds import LeftOutEffect, Reader, ReaderContext, RidgePath, Step
from skincad.mechanics.contact.state import Drive, FrictionCoefficients
from skincad.mechanics.validity import material_warnings
from skincad.scenes.detector import report
from skincad.scenes.errors import (
    SlipErrors,
    Slips,
    in_steps,
    lead,
    slip_errors,
    slip_step,
    slips_of,
    stress_errors,
    unresolved,
)
from skincad.scenes.march import Level, March
from skincad.scenes.models import (
    FINITE_STRAIN,
    MATTERS,
    BySource,
    MarchSetup,
    RefinedRun,
    chosen_steps,
    climb,
    cut_short,
    differential,
    drifted,
    further,
    march_on,
    model_of,
    omitted,
    piece_for,
    spent,
)
from skincad.scenes.scene import Scene


def energy(march: March) -> dict[str, float]:
    """Return the plate's work, what is stored and lost, mJ, and what is missing, relative to the work."""
    normal, tangential = march.column("normal"), march.column("tangential")
    down, along = np.diff(march.column("approach")), np.diff(march.column("travel"))
    by_forces = (normal[1:] + normal[:-1]) / 2 * down + (tangential[1:] + tangential[:-1]) / 2 * along
    works = [reading.work for reading in march.readings[1:]]
    pushed = sum(force if work is None else work for force, work in zip(by_forces, works, strict=True))
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
        "imbalance": float(missing) / max(abs(float(pushed)), stored, 1e-300),
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
    return report(march.time, reading["output_V"], noise, width, runs, gross, alarms, even, noises)


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


@dataclass(frozen=True, eq=False, repr=False)
class Simulation(Result):
    """A scene's result. `raw` and `signals`, by monitored ridge: differential stress S1 - S2, MPa, as it is
    and band-limited; `error` MPa its change from the mesh before, None with one mesh, and `stress_errors`
    MPa its whole error by source; `slipping` `(steps + 1, ridges)`; `slip_errors` ms.
    """

    shown_by = "skincad.outputs.simulations"
    scene: Scene
    march: March
    raw: dict[int, Array]
    signals: dict[int, FilteredSignal]
    error: dict[int, float] | None
    stress_errors: dict[int, BySource]
    slipping: Mask
    runs: list[list[list[int]]]
    slip_steps: list[int | None]
    gross_slip_step: int | None
    slip_errors: SlipErrors
    left_out: list[LeftOutEffect]
    read: dict[str, Any]
    seconds: dict[str, float]
    warnings: tuple[str, ...]

    @property
    def delay(self) -> float:
        """By how many s the signals lag behind what is felt; steps named by signals have it taken out."""
        return delay(self.scene.readout.bandwidth_Hz)

    @property
    def energy(self) -> dict[str, float]:
        """Work of the plate, what is stored and dissipated, mJ, and what is missing, relative to the work."""
        return energy(self.march)

    @property
    def lead(self) -> dict[int, Estimate]:
        """By how many ms a monitored ridge's lasting slip comes before gross slip; no value without both,
        no error where nobody asked what the mesh or the step changes."""
        slips = ((ridge, self.slip_steps[ridge - 1]) for ridge in self.scene.readout.ridges)
        gross, errors = self.gross_slip_step, self.slip_errors.leads
        return {r: lead(self.march.time, gross, step, errors[r - 1].total) for r, step in slips}

    @property
    def slip_step_errors(self) -> list[BySource | None]:
        """How many steps `slip_steps` may be wrong by, ridge by ridge; None for one that does not slip."""
        pairs = zip(self.slip_steps, self.slip_errors.slips, strict=True)
        return [in_steps(self.march, step, error) for step, error in pairs]

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

    @property
    def largest_stress(self) -> dict[int, Estimate]:
        """A monitored ridge's largest differential stress, MPa, either way, with its whole error."""
        return {
            r: Estimate(float(np.abs(values).max()), self.stress_errors[r].total, "MPa")
            for r, values in self.raw.items()
        }

    @property
    def exit_status(self) -> int:
        """0 where it ran to its end, 1 where it failed, 130 where Ctrl-C ended it."""
        return INTERRUPTED if self.march.interrupted else 1 if self.march.failed else 0

    def as_json(self) -> dict[str, Any]:
        """Return the result under the contract's keys."""
        slips, gross = self.slip_step_errors, self.gross_slip_step_error

        def told(of: Callable[[FilteredSignal], Array]) -> dict[str, list[float]]:
            return {str(r): of(signal).tolist() for r, signal in self.signals.items()}

        march = self.march
        before = {
            "name": self.scene.name,
            "effects": list(self.scene.effects),
            "left_out": [entry.as_json() for entry in self.left_out],
            "tier": model_of(self.scene),
            "chosen_steps": chosen_steps(march),
            "steps": len(march.readings) - 1,
            "stopped": march.stopped,
            "time_s": march.time.tolist(),
            "normal_force_N": march.column("normal").tolist(),
            "tangential_force_N": march.column("tangential").tolist(),
            "ridge_slip_intervals": self.runs,
            "ridge_slip_step": self.slip_steps,
            "slip_step_error": [None if estimate is None else estimate.with_total() for estimate in slips],
            "gross_slip_step": self.gross_slip_step,
            "gross_slip_step_error": None if gross is None else gross.with_total(),
            "lead_ms": {str(r): estimate.as_json() for r, estimate in self.lead.items()},
            "lead_error_ms": {str(r): self.slip_errors.leads[r - 1].as_json() for r in self.lead},
            "slip_lead_ms": {str(r): estimate.value for r, estimate in self.lead.items()},
            "differential_stress_MPa": told(lambda s: s.value),
            "stress_rate_MPa_per_s": told(lambda s: s.rate),
            "stress_jerk_MPa_per_s2": told(lambda s: s.jerk),
            "differential_stress_error_MPa": (
                None if self.error is None else {str(r): e for r, e in self.error.items()}
            ),
            "differential_stress_error_by_source_MPa": {
                str(r): estimate.as_json() for r, estimate in self.stress_errors.items()
            },
            "largest_differential_stress_MPa": {
                str(r): estimate.as_json() for r, estimate in self.largest_stress.items()
            },
            "bandwidth_Hz": self.scene.readout.bandwidth_Hz,
            "signal_delay_s": self.delay,
        }
        after = {
            "residual_max": float(march.column("residual").max()),
            "energy": self.energy,
            "unknowns": march.unknowns,
            "seconds": self.seconds,
            "warnings": list(self.warnings),
        }
        return joined({"the march": before, "a reader": self.read, "the run": after})


def simulate(
    scene: Scene,
    *,
    tol: float | None = None,
    budget: float | None = None,
    tick: Tick | None = None,
    partial: bool = False,
) -> Simulation:
    """March a scene on one mesh after the other until the differential stress is within `tol` of its largest.

    A scene that names no law, and of which small strain leaves out more than `tol`, is marched with finite
    strain in chosen steps next, then in each (scenes/models.py): `model` and `scene` of the result say so.
    Without `tol` the model is the scene's own.

    `seconds` are by stage; `effect <name>` are those that an effect's own code took, beside what it makes
    others' work longer, which only a run without it tells (`skincad accuracy --ladder effects`).

    The error is the change from the mesh before; `budget` s ends the climb before a mesh that would overrun
    it, but the coarsest is marched whatever it takes; alone it asks for the best that it buys. `tick` is told
    stage, step and the seconds left. A march that stops early is a result: its `march.stopped` says why.
    With `partial` Ctrl-C too ends in a result, of what is done by then. Raises ExhaustedError where memory or
    another resource does not suffice for the coarsest mesh.
    """
    run = marched(scene, tol=tol, budget=budget, tick=tick, partial=partial, further_models=True)
    return read_out(scene, run)


@dataclass(frozen=True, eq=False)
class SceneRun:
    """What was marched, the march that counts, and the seconds that both took, by stage."""

    on: MarchSetup
    climbed: RefinedRun
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
    """Return a scene's march, as `simulate` asks for it; nothing has read it yet. Whether its `tol` may ask
    for a model `beyond` the scene's own."""
    require_goals(tol, budget, "0.02")
    began, seconds = perf_counter(), dict[str, float]()
    on = MarchSetup(scene, piece_for(scene, seconds), tick, partial)
    climbed = climb(on, tol, budget, began, seconds)
    if further_models and tol is not None:
        on, climbed = further(on, climbed, tol, budget, began, seconds)
    return SceneRun(on, climbed, {"total": perf_counter() - began, **seconds})


def read_out(scene: Scene, run: SceneRun) -> Simulation:
    """Return what a scene's readers tell of a march: its own, or that of a scene which differs in its readers
    and its band alone (`marching` is the same)."""
    if model_of(scene) != model_of(run.on.scene):
        scene = scene.with_(effects={FINITE_STRAIN: run.on.scene.effects[FINITE_STRAIN]})
    return _told(replace(run.on, scene=scene), run.climbed, dict(run.seconds))


def marching(scene: Scene) -> Scene:
    """Return the scene as its march knows it: without what only reads it."""
    readers = {name: None for name, part in scene.parts.items() if isinstance(part, Reader)}
    return scene.with_(effects=readers, readout={"bandwidth_Hz": None})


def at_level(scene: Scene, level: Level, tick: Tick | None = None) -> Simulation:
    """March a scene on one mesh alone, whatever its error, which nobody estimates then."""
    began, seconds = perf_counter(), dict[str, float]()
    on = MarchSetup(scene, piece_for(scene, seconds), tick)
    climbed = RefinedRun(march_on(level, on, seconds), None, [])
    return _told(on, climbed, {"total": perf_counter() - began, **seconds})


def friction_cone(scene: Scene) -> FrictionCoefficients:
    """Return what friction bears; without any no ridge bears a pull, so that any cone does."""
    still = Drive(0.0)
    shares = (term.share(Step(0.0, 1.0, still, still, scene.plate.mass or 0.0)) for term in scene.terms)
    return next((share.cone for share in shares if share.cone), FrictionCoefficients(1.0, 1.0))


def _change(left_out: list[LeftOutEffect]) -> float:
    """The relative change of a ridge's load by all that is left out: taken to be the signals'."""
    return math.fsum(entry.change for entry in left_out)


def _told(on: MarchSetup, climbed: RefinedRun, seconds: dict[str, float]) -> Simulation:
    """The result of the last march that counts."""
    began = perf_counter()
    scene, march, notes = on.scene, climbed.march, [*climbed.short, *cut_short(climbed.march)]
    raw, width = differential(on.piece, scene, march), scene.readout.bandwidth_Hz
    slips = slips_of(march.readings, march.ridge, scene.design.ridge.count)
    left_out, driven = omitted(scene, march), scene.history.tangential_force_N is None
    change = _change(left_out)
    stressed = stress_errors(
        raw,
        climbed.error,
        climbed.refined,
        lambda one: differential(on.piece, scene, one),
        change,
        drifted(on, march),
    )
    if raw and "film" not in scene.effects:
        notes = [*notes, "effects.film is not named: the stress shown is the silicone's, in the films' place"]
    notes = [*notes, *unresolved(march.time, width)] if raw else notes
    notes = [*notes, *material_warnings(scene.design)]
    notes = [*notes, *(remark for term in scene.terms for remark in term.remarks(scene.asked))]
    normal, tangential, area = np.moveaxis(march.loads, 1, 0)
    path = RidgePath(normal, tangential, area, slips.slipping)
    notes = [*notes, *(remark for term in scene.terms for remark in term.afterwards(path))]
    readings, remarks = read(scene, march, slips, seconds)
    return Simulation(
        scene=scene,
        march=march,
        raw=raw,
        signals={r: band_limited(march.time, values, width) for r, values in raw.items()},
        error=climbed.error,
        stress_errors=stressed,
        slipping=slips.slipping,
        runs=slips.runs,
        slip_steps=slips.steps,
        gross_slip_step=slips.gross,
        slip_errors=slip_errors(march, slips, climbed.refined, change, driven, friction_cone(scene)),
        left_out=left_out,
        read=readings,
        seconds={**seconds, "total": seconds["total"] + perf_counter() - began},
        warnings=(*notes, *remarks, *(entry.warning for entry in left_out if entry.change > MATTERS)),
    )
