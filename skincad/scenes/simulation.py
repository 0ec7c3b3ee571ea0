"""Simulating a scene: meshes, march, signals, and what is told of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial as bound
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from skincad.base.arguments import require_goals
from skincad.base.blas import one_blas_thread
from skincad.base.errors import InputError, RefusedError, needing
from skincad.base.result import Result
from skincad.base.stopwatch import Tick
from skincad.circuit.low_pass import Limited, band_limited, delay
from skincad.effects.kinds import PadChange, Reader, Watched
from skincad.scenes.levels import LEVELS, Level, expected
from skincad.scenes.march import INTERRUPTED, March, march
from skincad.scenes.moments import kept_steps
from skincad.scenes.omitted import MATTERS, Omitted, omitted
from skincad.scenes.scene import Scene
from skincad.scenes.signals import (
    gross_slip_step,
    intervals,
    lasting_slip_step,
    slip_by_ridge,
    unresolved,
)
from skincad.scenes.slip import report

if TYPE_CHECKING:
    from skincad.mechanics.film.stick import PadPiece

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
DEFAULT_TOLERANCE = 0.05  # of the largest differential stress; what is left out changes more (docs/facts.md)


@dataclass(frozen=True, eq=False, repr=False)
class Simulation(Result):
    """A scene's result. `raw` and `signals` are by told ridge: the differential stress S1 - S2, MPa, as it is
    and band-limited; `error` MPa its change from the mesh before, None with one mesh; `slipping`
    `(steps + 1, ridges)`.
    """

    shown_by = "skincad.outputs.simulations"
    scene: Scene
    march: March
    raw: dict[int, Array]
    signals: dict[int, Limited]
    error: dict[int, float] | None
    slipping: Mask
    runs: list[list[list[int]]]
    slip_steps: list[int | None]
    gross_slip_step: int | None
    left_out: list[Omitted]
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
        normal, tangential = self.march.column("normal"), self.march.column("tangential")
        down, along = np.diff(self.march.column("approach")), np.diff(self.march.column("travel"))
        by_forces = (normal[1:] + normal[:-1]) / 2 * down + (tangential[1:] + tangential[:-1]) / 2 * along
        told = [reading.work for reading in self.march.readings[1:]]
        pushed = sum(force if work is None else work for force, work in zip(by_forces, told, strict=True))
        stored = float(self.march.readings[-1].elastic)
        lost = float(self.march.column("dissipated").sum())
        kinetic = float(self.march.readings[-1].kinetic)
        viscous = float(self.march.column("viscous").sum())
        missing = abs(pushed - stored - kinetic - lost - viscous)
        return {
            "work_mJ": float(pushed),
            "elastic_mJ": stored,
            "kinetic_mJ": kinetic,
            "dissipated_mJ": lost,
            "viscous_mJ": viscous,
            "imbalance": float(missing) / max(abs(float(pushed)), stored, 1e-300),
        }

    @property
    def lead(self) -> dict[int, float | None]:
        """By how many ms a told ridge's lasting slip comes before gross slip; None without one of them."""
        at, gross = 1e3 * self.march.time, self.gross_slip_step
        steps = {ridge: self.slip_steps[ridge - 1] for ridge in self.scene.readout.ridges}
        return {
            ridge: None if gross is None or step is None else float(at[gross] - at[step])
            for ridge, step in steps.items()
        }

    def as_json(self) -> dict[str, Any]:
        """Return the result under the contract's keys."""

        def told(of: Callable[[Limited], Array]) -> dict[str, list[float]]:
            return {str(r): of(signal).tolist() for r, signal in self.signals.items()}

        found = self.march
        return {
            "name": self.scene.name,
            "effects": list(self.scene.effects),
            "left_out": [entry.as_json() for entry in self.left_out],
            "steps": len(found.readings) - 1,
            "stopped": found.stopped,
            "time_s": found.time.tolist(),
            "normal_force_N": found.column("normal").tolist(),
            "tangential_force_N": found.column("tangential").tolist(),
            "ridge_slip_intervals": self.runs,
            "ridge_slip_step": self.slip_steps,
            "gross_slip_step": self.gross_slip_step,
            "slip_lead_ms": {str(ridge): lead for ridge, lead in self.lead.items()},
            "differential_stress_MPa": told(lambda s: s.value),
            "stress_rate_MPa_per_s": told(lambda s: s.rate),
            "stress_jerk_MPa_per_s2": told(lambda s: s.jerk),
            "differential_stress_error_MPa": (
                None if self.error is None else {str(r): e for r, e in self.error.items()}
            ),
            "bandwidth_Hz": self.scene.readout.bandwidth_Hz,
            "signal_delay_s": self.delay,
            **self.read,
            "residual_max": float(found.column("residual").max()),
            "energy": self.energy,
            "unknowns": found.unknowns,
            "seconds": self.seconds,
            "warnings": list(self.warnings),
        }


def simulate(
    scene: Scene,
    *,
    tol: float | None = None,
    budget: float | None = None,
    tick: Tick | None = None,
    partial: bool = False,
) -> Simulation:
    """March a scene on one mesh after the other until the differential stress is within `tol` of its largest.

    `seconds` are by stage; `effect <name>` are those that an effect's own code took, beside what it makes
    others' work longer, which only a run without it tells (`skincad accuracy --ladder effects`).

    The error is the change from the mesh before; `budget` s ends the climb before a mesh that would overrun
    it, but the coarsest is marched whatever it takes; alone it asks for the best that it buys. `tick` is told
    stage, step and the seconds left. A march that stops early is a result: its `march.stopped` says why.
    With `partial` Ctrl-C too ends in a result, of what is done by then. Raises ExhaustedError where memory or
    another resource does not suffice for the coarsest mesh.
    """
    require_goals(tol, budget, "0.02")
    wanted, began = tol or DEFAULT_TOLERANCE, perf_counter()
    seconds: dict[str, float] = {}
    piece, films = _piece(scene, seconds), bool(scene.readout.ridges)
    before: March | None = None
    error: dict[int, float] | None = None
    reached, met = np.inf, False
    meshes: dict[float, object] = {}
    short: list[str] = []
    for level, following in zip(LEVELS, (*LEVELS[1:], None), strict=True):
        spent: dict[str, float] = {}
        rest = following if before is None and budget is None else None  # two meshes are the least
        run = bound(_march, scene, piece, level, films, meshes, spent, tick, rest, partial)
        found = _or_before(run, before, met, partial, short)
        for stage, more in spent.items():
            seconds[stage] = seconds.get(stage, 0.0) + more
        if before is not None and found.readings is before.readings:
            break
        if before is not None:
            error, reached = _errors(piece, scene, before, found)
            met = reached <= wanted
        enough = met and (tol is not None or budget is None)  # a budget alone asks for the best it buys
        if enough or found.failed or found.interrupted or following is None:
            break
        if not films and before is not None:
            break
        price = expected(following, level, {**spent, "mesh": seconds["mesh"]})
        if budget is not None and perf_counter() - began + price > budget:
            break
        before = found
    if films and not met:
        how = "of unknown error" if error is None else f"within {reached:.1e} of its largest"
        short.append(f"the differential stress is {how}: {wanted:.1e} is not met")
    if budget is not None and (late := perf_counter() - began) > budget:
        short.append(f"took {late:.2g} s, more than the budget of {budget:g} s")
    told = _told(scene, piece, found, error, seconds, short)
    return replace(told, seconds={"total": perf_counter() - began, **seconds})


def _or_before(
    run: Callable[[], March], before: March | None, met: bool, partial: bool, short: list[str]
) -> March:
    """Return the march on the next mesh, or that `before` where it says more; `short` gets why."""
    try:
        found = run()
    except KeyboardInterrupt:
        if not partial or before is None:
            raise
        return replace(before, stopped=INTERRUPTED)
    except (InputError, RefusedError) as refusal:
        if before is None:
            raise
        short.append(f"a finer mesh is refused ({refusal}); the one before counts")
        return before
    if found.interrupted and before is not None:
        return replace(before, stopped=INTERRUPTED)  # a whole march says more than a part
    if found.failed and met and before is not None:  # only a budget climbs on from what is good enough
        short.append(f"a finer mesh stopped at {found.stopped}; the one before counts")
        return before
    return found


def at_level(scene: Scene, level: Level, tick: Tick | None = None) -> Simulation:
    """March a scene on one mesh alone, whatever its error, which nobody estimates then."""
    began, seconds = perf_counter(), dict[str, float]()
    piece, films = _piece(scene, seconds), bool(scene.readout.ridges)
    found = _march(scene, piece, level, films, {}, seconds, tick)
    told = _told(scene, piece, found, None, seconds, [])
    return replace(told, seconds={"total": perf_counter() - began, **seconds})


@contextmanager
def _spent(seconds: dict[str, float], name: str) -> Iterator[None]:
    """Count the block's seconds for an effect's own work."""
    began, key = perf_counter(), f"effect {name}"
    yield
    seconds[key] = seconds.get(key, 0.0) + perf_counter() - began


def _piece(scene: Scene, seconds: dict[str, float]) -> PadPiece:
    """What is to be meshed: slots full of silicone, each body of the scene changing that."""
    from skincad.mechanics.film.stick import piece_of
    from skincad.mechanics.film.stress import filled_pad
    from skincad.mechanics.problem import check_pad, pad_of

    design = scene.design.with_(contact={"plate": {"shape": scene.plate.shape}})
    plain = design.with_(contact={"film": "ignored"}) if design.slot else design.with_(contact={"film": None})
    pad, thickness = filled_pad(plain) if design.slot else (pad_of(plain), 0.0)
    for name, body in scene.parts.items():
        if isinstance(body, PadChange):
            with _spent(seconds, name):
                pad = body.changed(pad, design)
    check_pad(pad)
    return piece_of(pad, thickness, halved=scene.law.halves)


def _march(
    scene: Scene,
    piece: PadPiece,
    level: Level,
    films: bool,
    meshes: dict[float, object],
    seconds: dict[str, float],
    tick: Tick | None,
    following: Level | None = None,
    partial: bool = False,
) -> March:
    """March on one mesh; `seconds` get its stages, `tick` the time left, with that of a level `following`."""
    stage = f"fineness {level.fineness:g}, order {level.order}"
    if tick:
        tick(stage, 0)
    marks = [perf_counter()]
    with needing(f"the mesh of {stage}"):
        mesh = _meshed(piece, level, meshes)
        marks.append(perf_counter())
        model = scene.law.model(piece, mesh, level.order, films, scene.terms)
        marks.append(perf_counter())
    history, mass = scene.history, scene.plate.mass or 0.0
    spent = dict(zip(("mesh", "condense"), np.diff(marks).tolist(), strict=True))

    def told(step: int) -> None:
        if tick:
            whole = (perf_counter() - marks[-1]) * history.steps / step
            after = expected(following, level, {**spent, "march": whole}) if following else 0.0
            tick(stage, step, whole * (1 - step / history.steps) + after)

    # to ask for one thread at each step takes longer than the step
    with needing(f"the march on the mesh of {stage}"), one_blas_thread():
        times, drives, ends = history.times, history.drives(), scene.law.limits(scene.design)
        keep = kept_steps(scene)
        found = march(model, times, drives, scene.terms, told, keep, mass, ends, partial)
    seconds |= {**spent, "march": found.seconds}
    return found


def _meshed(piece: PadPiece, level: Level, meshes: dict[float, object]) -> object:
    """Return the level's mesh, of those made already where it is among them."""
    from skincad.mechanics.bodies.mesh import default_sizes, triangles
    from skincad.mechanics.film.rungs import RUNGS

    if level.fineness not in meshes:
        fine = RUNGS[int(level.fineness > RUNGS[0].fineness)]
        sizes = fine.sizes(piece) if piece.pad.strips else default_sizes(piece.pad, level.fineness)
        meshes[level.fineness] = triangles(piece.pad, sizes)
    return meshes[level.fineness]


def _differential(piece: PadPiece, scene: Scene, found: March) -> dict[int, Array]:
    """S1 - S2 across the films `(steps + 1,)` MPa by told ridge."""
    place = {(s.ridge, s.side): i for i, s in enumerate(piece.whole.section.slots)}
    films = found.column("films")
    return {r: films[:, place[r, "S1"], 0] - films[:, place[r, "S2"], 0] for r in scene.readout.ridges}


def _errors(piece: PadPiece, scene: Scene, before: March, found: March) -> tuple[dict[int, float], float]:
    """Largest change of each told ridge's difference from the mesh before, MPa; the largest relative one."""
    one, other = (_differential(piece, scene, each) for each in (before, found))
    steps = min(before.time.size, found.time.size)
    error = {r: float(np.abs(one[r][:steps] - other[r][:steps]).max()) for r in one}
    largest = max((float(np.abs(v).max()) for v in other.values()), default=0.0)
    return error, max(error.values(), default=0.0) / largest if largest else 0.0


def _told(
    scene: Scene,
    piece: PadPiece,
    found: March,
    error: dict[int, float] | None,
    seconds: dict[str, float],
    notes: list[str],
) -> Simulation:
    raw = _differential(piece, scene, found)
    width = scene.readout.bandwidth_Hz
    touches = np.array([reading.touches for reading in found.readings])
    slips = np.array([reading.slips for reading in found.readings])
    slipping = slip_by_ridge(touches, slips, found.ridge, scene.design.ridge.count)
    runs = [intervals(column) for column in slipping.T]
    gross, last = gross_slip_step(touches, slips), len(found.readings) - 1
    left_out = omitted(scene, found)
    if raw and "film" not in scene.effects:
        notes = [*notes, "film is not named: this is the silicone's stress in the films' place"]
    notes = [*notes, *unresolved(found.time, width)] if raw else notes
    notes = [*notes, *(remark for term in scene.terms for remark in term.remarks(scene.asked))]
    read: dict[str, Any] = {}
    watched = Watched(scene.design, tuple(scene.readout.ridges), width)
    for name, effect in scene.parts.items():
        if isinstance(effect, Reader):
            with _spent(seconds, name):
                told = dict(effect.read(watched, found.time, found.readings))
            notes = [*notes, *told.pop("warnings", ())]
            read |= told
    if "output_V" in read:
        felt = report(found.time, read["output_V"], read["output_noise_V_rms"], width, runs, gross)
        read |= felt
    return Simulation(
        scene,
        found,
        raw,
        {r: band_limited(found.time, values, width) for r, values in raw.items()},
        error,
        slipping,
        runs,
        [lasting_slip_step(each, gross, last) for each in runs],
        gross,
        left_out,
        read,
        seconds,
        (*notes, *(entry.warning for entry in left_out if entry.change > MATTERS)),
    )
