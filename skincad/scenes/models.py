"""Which model and which meshes a scene runs on, until its error is as small as wanted.

Marches that one is held against, and an error by source: the mesh, the time step, what is left out, and what
drifts where the skin is linear between chosen steps (mechanics/contact/frozen_tangent.py). Mesh and time
step: the change to a march on the mesh before, and to one of fewer steps.

A scene is marched with the slow modes of its masses where its steps show them (effects/modal.py). One that
names no law is marched in small strain first. Where leaving out finite strain changes more than a tenth, or
than the tolerance that is asked, it is marched with finite strain in chosen steps (effects/chosen_steps.py),
with free ends where they matter, on the coarsest mesh: what mesh and time step change is known from small
strain. If the drift between chosen steps is more than a tolerance too, each step is taken at finite strain,
unless that had to stop: where no step can be chosen there is no smooth state at finite strain.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from skincad.base import adaptivity
from skincad.base.adaptivity import Refinement, overrun, unmet
from skincad.base.arrays import Array, Index
from skincad.base.errors import InputError, RefusedError, resource_guard
from skincad.base.machine import one_blas_thread
from skincad.base.progress import Tick
from skincad.circuit.state import longest_step
from skincad.effects import EFFECTS, effect
from skincad.effects.kinds import (
    MASS,
    RELIEF,
    Law,
    LeftOutEffect,
    MarchedPad,
    PadChange,
    PlatePath,
    SceneOutline,
    Step,
)
from skincad.mechanics.contact.state import Drive
from skincad.mechanics.dynamics.ringing import layer_period, skin_mass
from skincad.mechanics.fits import unlike
from skincad.scenes.march import EXPONENT, INTERRUPTED, LEVELS, Level, March, expected, kept_steps, march
from skincad.scenes.scene import Scene
from skincad.shape.skin import skin_of

if TYPE_CHECKING:
    from skincad.mechanics.dynamics.modes import Modes
    from skincad.mechanics.film.stick import PadPiece


COARSE_STEP_FACTOR = 5  # steps of a march that are one of the march with fewer
LONGER = 2.0  # such a step's time, by that of one of these: 1.7 to 3.2, measured on four scenes


class BySource(NamedTuple):
    """An error, in the unit of what is wrong by it; a source that nobody asked is None."""

    mesh: float | None
    time_step: float | None
    left_out: float
    drift: float = 0.0

    @property
    def total(self) -> float | None:
        """The sum; None where the mesh's or the step's share is unknown."""
        if self.mesh is None or self.time_step is None:
            return None
        return self.mesh + self.time_step + self.left_out + self.drift

    def with_total(self) -> dict[str, float | None]:
        """Return it under JSON keys, the sum too."""
        return {**self._asdict(), "total": self.total}


@dataclass(frozen=True, eq=False)
class ComparisonRuns:
    """Marches to hold a march against, None where there is none: `before` on the mesh before; `every` on the
    coarsest mesh, and `coarse` there with fewer steps; `after` on the finer mesh, where the march in question
    is by another model; `heavy` under a plate as heavy as the skin, on the coarsest mesh."""

    before: March | None = None
    after: March | None = None
    every: March | None = None
    coarse: March | None = None
    heavy: March | None = None


def coarse_steps(steps: int, points: Index) -> Index:
    """Return the steps `(k,)` of a march with fewer steps: one in COARSE_STEP_FACTOR, those at the history's
    `points`, and the last."""
    return np.unique(np.concatenate([np.arange(0, steps + 1, COARSE_STEP_FACTOR), points, [steps]]))


@dataclass(frozen=True, eq=False)
class MarchSetup:
    """What a scene's marches share: the piece that is meshed, None of pins, which have no section; who is
    told, whether a march that Ctrl-C ends is wanted (`partial`), the meshes made so far by fineness, the
    model's name where it is not the scene's own, and the slow `modes` of the first mesh, once known."""

    scene: Scene
    piece: PadPiece | None
    tick: Tick | None = None
    partial: bool = False
    meshes: dict[float, object] = field(default_factory=dict)
    model: str = ""
    modes: list[Modes] = field(default_factory=list)


@contextmanager
def spent(seconds: dict[str, float], name: str) -> Iterator[None]:
    """Count the block's seconds for an effect's own work."""
    began, key = perf_counter(), f"effect {name}"
    yield
    seconds[key] = seconds.get(key, 0.0) + perf_counter() - began


def piece_for(scene: Scene, seconds: dict[str, float]) -> PadPiece | None:
    """Return what is to be meshed: slots full of silicone, each effect that changes the pad changing that;
    None of pins."""
    if skin_of(scene.design).symmetry == "revolved":
        return None
    from skincad.mechanics.film.stick import piece_of
    from skincad.mechanics.film.stress import filled_pad
    from skincad.mechanics.problem import check_pad, pad_of

    design = scene.design.with_(contact={"plate": {"shape": scene.plate.shape}})
    plain = (
        design.with_(contact={"film": "ignored"})
        if skin_of(design).slot
        else design.with_(contact={"film": None})
    )
    pad, thickness = filled_pad(plain) if skin_of(design).slot else (pad_of(plain), 0.0)
    for name, part in scene.parts.items():
        if isinstance(part, PadChange):
            with spent(seconds, name):
                pad = part.changed(pad, design)
    check_pad(pad)
    return piece_of(pad, thickness, halved=scene.law.halves)


def march_on(
    level: Level,
    on: MarchSetup,
    seconds: dict[str, float],
    following: Level | None = None,
    again: bool = False,
) -> March:
    """March on one mesh; `seconds` get its stages, the tick the time left, with that of a level `following`
    and of a march with fewer steps, where it is marched `again`. Pins have no mesh: the first level takes
    their contacts as softest, the others as stiffest."""
    model = f"{on.model.replace('_', ' ')}, " if on.model else ""
    stage, scene, tick = f"{model}fineness {level.fineness:g}, order {level.order}", on.scene, on.tick
    if tick:
        tick(stage, 0)
    marks = [perf_counter()]
    with resource_guard(f"the mesh of {stage}"):
        if on.piece is None:
            from skincad.effects.pin_pad import SLIDING, STICKING, pin_pad

            marks.append(perf_counter())
            pad: MarchedPad = pin_pad(scene.design, SLIDING if level == LEVELS[0] else STICKING)
        else:
            mesh = meshed_pad(on.piece, level, on.meshes)
            marks.append(perf_counter())
            films = bool(scene.readout.ridges)
            pad = scene.law.marched(on.piece, mesh, level.order, films, scene.terms)
        marks.append(perf_counter())
        if on.piece is not None and marches_masses(scene):
            pad = _with_masses(pad, on, mesh, level, films)
            seconds["modes"] = seconds.get("modes", 0.0) + perf_counter() - marks[-1]
    history, mass = scene.history, scene.plate.mass or 0.0
    count = history.step_count
    fewer = LONGER * _fewer(scene).size / count if again else 0.0
    stages = dict(zip(("mesh", "condense"), np.diff(marks).tolist(), strict=True))

    began = perf_counter()

    def told(step: int) -> None:
        if tick:
            whole = (perf_counter() - began) * count / step
            after = expected(following, level, {**stages, "march": whole}) if following else 0.0
            tick(stage, step, whole * (1 - step / count + fewer) + after)

    # to ask for one thread at each step takes longer than the step
    with resource_guard(f"the computation on the mesh of {stage}"), one_blas_thread():
        times, drives, ends = history.times, history.drives(), scene.law.limits(scene.design)
        keep = kept_steps(scene)
        march_result = march(pad, times, drives, scene.terms, told, keep, mass, ends, on.partial)
    seconds |= {**stages, "march": march_result.seconds}
    return march_result


def march_coarse_steps(
    on: MarchSetup, whole: March, seconds: dict[str, float], after: float = 0.0
) -> March | None:
    """March the pad of a march again with fewer steps, to tell the steps' error; None where that fails.
    `seconds` have a stage of its own, as the price of the next mesh depends on the march's alone. The tick is
    told the history's steps, and the time left with the s `after` it."""
    scene, history, tick = on.scene, on.scene.history, on.tick
    indices = _fewer(scene)
    if whole.pad is None or indices.size > history.step_count:
        return None
    stage, began, last = "march with fewer steps", perf_counter(), indices.size - 1
    if tick:
        tick(stage, 0)

    def told(step: int) -> None:
        if tick:
            left = (perf_counter() - began) * (last / step - 1)
            tick(stage, int(indices[step]), left + after)

    drives = history.drives()
    with one_blas_thread():
        ends = scene.law.limits(scene.design)
        times, mass = history.times[indices], scene.plate.mass or 0.0
        fewer = [drives[i] for i in indices]
        coarse = march(whole.pad, times, fewer, scene.terms, told, (), mass, ends, on.partial)
    seconds[stage] = coarse.seconds
    return None if coarse.failed else coarse


def march_under_heavy_plate(on: MarchSetup, whole: March, seconds: dict[str, float]) -> March | None:
    """March the pad of a march again under a plate as heavy as the skin; None of a plate that is driven or
    has its own mass, of a skin without masses, and where that fails. `seconds` have a stage of its own."""
    from skincad.effects.modal import ModalPad

    scene, history, pad = on.scene, on.scene.history, whole.pad
    if scene.plate.mass is not None or history.tangential_force_N is None or not isinstance(pad, ModalPad):
        return None
    mass, ends = skin_mass(scene.design), scene.law.limits(scene.design)
    with one_blas_thread():
        heavier = replace(pad, mass=mass, prepared={})
        run = march(heavier, history.times, history.drives(), scene.terms, None, (), mass, ends, on.partial)
    seconds["heavy plate"] = run.seconds
    return None if run.failed or run.interrupted else run


def _fewer(scene: Scene) -> Index:
    """The steps that the march with fewer has."""
    history = scene.history
    return coarse_steps(history.step_count, history.points)


SWINGS = 2.0  # steps in the slowest mode's period from which on masses are marched


def marches_masses(scene: Scene) -> bool:
    """Whether the slow modes are marched: the scene names no effect with masses or a past of its own, the
    plate keeps its angle, and the steps are short enough to see the slowest mode, or the plate has a mass."""
    design, history = scene.design, scene.history
    if scene.moving or any(history.rotation_deg or []) or not scene.law.swings:
        return False
    if skin_of(design).symmetry == "revolved":
        return False
    return scene.plate.mass is not None or longest_step(history.times) < layer_period(design) / SWINGS


def halts_of(scene: Scene) -> float:
    """Return how long a ridge that slips may halt while the skin swings, s: half of its slowest swing where
    masses count, else 0."""
    return layer_period(scene.design) / 2 if marches_masses(scene) or MASS in scene.asked else 0.0


def _with_masses(pad: MarchedPad, on: MarchSetup, mesh: object, level: Level, films: bool) -> MarchedPad:
    """The pad with the slow modes of the first mesh that is marched."""
    from skincad.effects.chosen_steps import ChosenPad
    from skincad.effects.modal import ModalPad
    from skincad.effects.small_strain import CondensedPad
    from skincad.mechanics.dynamics.modes import at_points, resolved, slow_modes

    assert isinstance(pad, CondensedPad | ChosenPad)
    assert on.piece is not None
    step = longest_step(on.scene.history.times)
    if not on.modes:
        on.modes.append(slow_modes(on.piece, mesh, level.order, films, pad.x, pad.ridge, step))
    modes = at_points(on.modes[0], pad.x, pad.ridge)
    slow = resolved(modes, pad.compliance, step)
    first = (
        level == LEVELS[0] and not on.model
    )  # what it differs from the next mesh by counts these modes too
    return ModalPad(pad, slow.coarser if first else slow, on.scene.plate.mass or 0.0)


def meshed_pad(piece: PadPiece, level: Level, meshes: dict[float, object]) -> object:
    """Return the level's mesh, of those made already where it is among them."""
    from skincad.mechanics.bodies.mesh import default_sizes, triangles
    from skincad.mechanics.film.stress import REFINEMENTS

    if level.fineness not in meshes:
        fine = REFINEMENTS[int(level.fineness > REFINEMENTS[0].fineness)]
        sizes = fine.sizes(piece) if piece.pad.strips else default_sizes(piece.pad, level.fineness)
        meshes[level.fineness] = triangles(piece.pad, sizes)
    return meshes[level.fineness]


MATTERS = 0.1  # relative; a larger change is warned of


def left_out_effects(scene: Scene, march: March) -> list[LeftOutEffect]:
    """Return the effects that the scene leaves out, the one that matters most first. Where no design that its
    constants were fitted to is like this one, an estimate is not calibrated."""
    history, path = scene.history, path_of(march)
    if skin_of(scene.design).symmetry == "revolved":
        from skincad.effects.pin_pad import left_out

        return left_out(scene.design, path)
    driven = history.tangential_force_N is None
    pull = (history.displacement_mm if driven else history.tangential_force_N) or []
    loads = (tuple(history.normal_force_N), tuple(pull))
    outline = SceneOutline(scene.design, tuple(history.time_s), loads, path, driven, _friction(scene))
    there = {*scene.effects, *(["inertia"] if marches_masses(scene) else [])}
    unnamed = [name for name, row in EFFECTS.items() if row.indicates and name not in there]
    found = {name: entry for name in unnamed if (entry := effect(name).left_out(outline))}
    entries = [
        replace(entry, calibrated=False, within=None) if unlike(scene.design, effect=name) else entry
        for name, entry in found.items()
    ]
    return sorted(entries, key=lambda entry: -entry.change)


def path_of(march: March) -> PlatePath:
    """Return what a march found, as indicators see it."""
    normal_loads, pulled, _ = np.moveaxis(march.loads, 1, 0)
    films = march.column("films")[:, :, 0]
    return PlatePath(
        time=march.time,
        approach=march.column("approach"),
        travel=march.column("travel"),
        pressed=normal_loads,
        pulled=pulled,
        slips=_slipping(march, normal_loads.shape[1]),
        felt=films[:, ::2] - films[:, 1::2],
    )


def _friction(scene: Scene) -> float:
    """The coefficient of static friction, at small pressures where it depends on pressure; 0 without any."""
    still = Drive(0.0)
    cones = (term.share(Step(0.0, 1.0, still, still)).cone for term in scene.terms)
    return next((cone.static for cone in cones if cone), 0.0)


def _slipping(march: March, ridges: int) -> Array:
    """The share of each ridge's touching points that slips `(steps + 1, ridges)`."""
    of = (march.ridge[:, None] == np.arange(1, ridges + 1)).astype(float)
    touches, slips = (march.column(name).astype(float) @ of for name in ("touches", "slips"))
    return np.asarray(slips / np.maximum(touches, 1.0))


_Error = dict[int, float] | None
# of the largest differential stress; what is left out changes more (docs/evidence/facts.md)
DEFAULT_TOLERANCE = 0.05


@dataclass(frozen=True, eq=False)
class RefinedRun:
    """The last march that counts, its error MPa by monitored ridge (None with one mesh), shortfalls, and the
    marches that its slips are held against."""

    march: March
    error: dict[int, float] | None
    short: list[str]
    refined: ComparisonRuns = field(default_factory=ComparisonRuns)


def refine(
    on: MarchSetup, tol: float | None, budget: float | None, began: float, seconds: dict[str, float]
) -> RefinedRun:
    """March on one mesh after the other as `simulate` says; `began` is when the budget began to run."""
    wanted, films = tol or DEFAULT_TOLERANCE, bool(on.scene.readout.ridges) or on.piece is None
    last: dict[str, float] = {}
    refined = [ComparisonRuns()]

    def marched(level: Level, before: Refinement[Level, March, _Error] | None) -> March:
        two = before is None and budget is None  # two meshes are the least
        last.clear()
        following = LEVELS[1] if two and len(LEVELS) > 1 else None
        march = march_on(level, on, last, following, before is None and films)
        if before is not None:
            refined[0] = replace(refined[0], before=before.answer)
        elif films and not (march.failed or march.interrupted):
            after = expected(following, level, last) if following else 0.0
            coarse = march_coarse_steps(on, march, last, after)
            if coarse is not None and coarse.interrupted:
                coarse, march = (
                    None,
                    replace(march, stopped=INTERRUPTED),
                )  # Ctrl-C ends the refinement, not its march
            heavy = None if march.interrupted else march_under_heavy_plate(on, march, last)
            refined[0] = ComparisonRuns(every=march, coarse=coarse, heavy=heavy)
        for stage, more in last.items():
            seconds[stage] = seconds.get(stage, 0.0) + more
        if before is not None and march.interrupted:
            raise KeyboardInterrupt  # a whole march says more than a part
        if before is not None and march.failed and before.error <= wanted:
            raise _StoppedError(f"a finer mesh stopped at {march.stopped}")  # what is there is good enough
        return march

    def price(before: Refinement[Level, March, _Error], following: Level) -> float:
        if before.answer.failed or before.answer.interrupted:
            return np.inf
        return expected(following, before.levels[-1], {**last, "mesh": seconds["mesh"]})

    reached = adaptivity.refine(
        marched,
        LEVELS,
        lambda _, found, before: (None, np.inf) if before is None else _errors(on, before, found),
        wanted if tol is not None or budget is None else 0.0,  # a budget alone asks for the best it buys
        budget,
        began=began,
        price=price,
        ends=(InputError, RefusedError, *((KeyboardInterrupt,) if on.partial else ())),
    )
    march, error, ended, short = reached.answer, reached.assessment, reached.ended, list[str]()
    if isinstance(ended, KeyboardInterrupt):
        march = replace(march, stopped=INTERRUPTED)
    elif ended is not None:
        words = str(ended) if isinstance(ended, _StoppedError) else f"a finer mesh is refused ({ended})"
        short.append(f"{words}; the results are those of the mesh before")
    if films and on.piece is not None:
        how = "of unknown error" if error is None else f"within {reached.error:.1e} of its largest"
        short += unmet(f"the differential stress is {how}", reached.error, wanted)
    counts = refined[0] if len(reached.levels) > 1 else replace(refined[0], before=None)
    return RefinedRun(march, error, [*short, *overrun("", reached.spent, budget)], counts)


class _StoppedError(RefusedError):
    """A march that did not reach the end of its history."""


def differential(piece: PadPiece | None, scene: Scene, march: March) -> dict[int, Array]:
    """Return S1 - S2 across the films `(steps + 1,)` MPa by monitored ridge."""
    if piece is None:
        return {}
    place = {(s.feature, s.side): i for i, s in enumerate(piece.whole.section.slots)}
    films = march.column("films")
    return {r: films[:, place[r, "S1"], 0] - films[:, place[r, "S2"], 0] for r in scene.readout.ridges}


def _errors(on: MarchSetup, before: March, march: March) -> tuple[dict[int, float], float]:
    """Largest change of each monitored ridge's difference from the mesh before, MPa; largest relative one."""
    one, other = (differential(on.piece, on.scene, run) for run in (before, march))
    steps = min(before.time.size, march.time.size)
    error = {r: float(np.abs(one[r][:steps] - other[r][:steps]).max()) for r in one}
    largest = max((float(np.abs(v).max()) for v in other.values()), default=0.0)
    return error, max(error.values(), default=0.0) / largest if largest else 0.0


SMALL_STRAIN, CORRECTED, FINITE_STRAIN = "small_strain", "corrected", "finite_strain"
FREE_ENDS = "free_ends"
CHOSEN, EACH = ({FINITE_STRAIN: {"steps": steps}} for steps in ("chosen", "all"))
DRIFTS = "between chosen steps the differential stress drifts by {:.2g} of its largest"
# s of a march in chosen steps, and of one with free ends, on a mesh of so many unknowns: yamada-2002-slip on
# two cores of 2026; and each step of finite strain by a chosen one
DEAR, ENDS_DEAR, OF_UNKNOWNS, DEARER = 25.0, 5.0, 22_676, 1.0
PROMPT = 60.0  # s
ENDS_MATTER = 0.02  # relative; a larger change is computed


def model_of(scene: Scene) -> str:
    """Return the model that a scene is marched by."""
    named = scene.parts.get(FINITE_STRAIN)
    if named is None:
        return SMALL_STRAIN
    return CORRECTED if getattr(named, "steps", None) == "chosen" else FINITE_STRAIN


def chosen_steps(march: March) -> list[int] | None:
    """Return the steps of a march that were chosen for finite strain; None where it does not choose any."""
    drifts = [reading.drift for reading in march.readings]
    return None if drifts[-1] is None else [i for i, drift in enumerate(drifts) if drift and drift.chosen]


def drifted(on: MarchSetup, march: March) -> dict[int, float]:
    """Return the largest drift of each monitored ridge's difference, MPa; nothing without chosen steps."""
    if march.readings[-1].drift is None or on.piece is None:
        return {}
    place = {(s.feature, s.side): i for i, s in enumerate(on.piece.whole.section.slots)}
    films = np.array([reading.drift.films for reading in march.readings if reading.drift])
    both = {r: [films[:, place[r, side], 0] for side in ("S1", "S2")] for r in on.scene.readout.ridges}
    return {r: float((one + other).max()) for r, (one, other) in both.items()}


def cut_short(march: March) -> list[str]:
    """Return what to warn of where no more steps could be chosen."""
    drift, chosen = march.readings[-1].drift, chosen_steps(march)
    if drift is None or not chosen or not drift.cut:
        return []
    words = f"after step {chosen[-1]} no step could be taken at finite strain: {drift.cut}"
    return [f"{words}; the skin stays linear about that step, and what that misses is in the errors"]


def further(
    on: MarchSetup,
    refined_run: RefinedRun,
    tol: float | None,
    budget: float | None,
    began: float,
    seconds: dict[str, float],
) -> tuple[MarchSetup, RefinedRun]:
    """Return what is marched, and the march that counts, by the model that the scene calls for: what was
    found in small strain, or one beyond it. Without `tol` that is one which is expected to take at most
    PROMPT s. `seconds` are by stage; `budget` s run from `began`."""
    scene, short, small = on.scene, refined_run.short, refined_run.march
    wanted = _missing(scene, small, tol)
    ends = {FREE_ENDS: wanted[FREE_ENDS]} if FREE_ENDS in wanted else {}
    try:
        for effects in [wanted, ends] if ends != wanted else [wanted]:
            if not effects:
                break
            try:
                price = _price(effects, refined_run.refined.every or small)
                if tol is None and price > PROMPT:
                    words = f"finite strain in chosen steps would take about {price:.2g} s"
                    raise RefusedError(f"{words}; --tol {DEFAULT_TOLERANCE:g} includes it")
                on, refined_run = _by(effects, on, refined_run, price, budget, began, seconds)
                break
            except (InputError, RefusedError) as refusal:
                short = [*short, f"no model beyond this one was marched: {refusal}"]
                refined_run = replace(refined_run, short=short)
        last = refined_run.march.readings[-1].drift
        if tol is None or last is None or (drift := _relative(on, refined_run)) <= tol:
            return on, refined_run
        refined_run = replace(refined_run, short=[*short, *unmet(DRIFTS.format(drift), drift, tol)])
        if last.cut:  # finite strain in each step would stop there
            return on, refined_run
        steps = chosen_steps(refined_run.march) or [0]
        price = DEARER * seconds[CORRECTED] * scene.history.step_count / len(steps)
        on, refined_run = _by({**wanted, **EACH}, on, refined_run, price, budget, began, seconds)
        return on, replace(refined_run, short=short)
    except KeyboardInterrupt:
        if not on.partial:
            raise
        return on, replace(refined_run, march=replace(refined_run.march, stopped=INTERRUPTED))
    except (InputError, RefusedError) as refusal:
        words = f"no model beyond this one was marched: {refusal}"
        return on, replace(refined_run, short=[*refined_run.short, words])


def _missing(scene: Scene, small: March, tol: float | None) -> dict[str, dict[str, Any]]:
    """What a scene that names no law, and tells a signal, is marched with beside small strain: effects whose
    absence changes more than `tol`, or what is MATTERS or ENDS_MATTER without one."""
    named = any(isinstance(part, Law) for part in scene.parts.values())
    moving = bool(scene.moving)  # which neither knows: with a tolerance that is said
    drawn = scene.readout.steps or scene.readout.frames  # of which finite strain tells no section
    # what finite strain does not know either
    turns = any(scene.history.rotation_deg or []) or RELIEF in scene.asked
    if named or (moving and tol is None) or not scene.readout.ridges or small.failed or small.interrupted:
        return {}
    change = {entry.effect: entry.change for entry in left_out_effects(scene, small)}
    wanted: dict[str, dict[str, Any]] = {}
    if change.get(FINITE_STRAIN, 0.0) > (tol or MATTERS) and not drawn and not turns:
        wanted |= CHOSEN
    ends_matter = change.get(FREE_ENDS, 0.0) > min(tol or 1.0, ENDS_MATTER)
    if ends_matter and not moving and scene.design.skin.curvature_radius_y is None:
        wanted[FREE_ENDS] = {}
    return wanted


def _price(effects: Mapping[str, Any], coarse: March) -> float:
    """About how many s a march with these effects takes, by the unknowns of the coarsest mesh and not by the
    clock: so a scene has the same model on every machine."""
    size = float((coarse.unknowns / OF_UNKNOWNS) ** EXPONENT)
    return (DEAR if FINITE_STRAIN in effects else ENDS_DEAR) * size


def _by(
    law: Mapping[str, Any],
    on: MarchSetup,
    refined_run: RefinedRun,
    price: float,
    budget: float | None,
    began: float,
    seconds: dict[str, float],
) -> tuple[MarchSetup, RefinedRun]:
    """March by another law on the coarsest mesh; RefusedError where that would overrun the budget or stops
    before what was found already. What mesh and time step change stays as it was found, in small strain."""
    if budget is not None and perf_counter() - began + price > budget:
        raise RefusedError(f"it would take about {price:.2g} s, more than the budget of {budget:g} s leaves")
    scene = on.scene.with_(effects=law)
    piece, last = piece_for(scene, seconds), dict[str, float]()
    better = replace(on, scene=scene, piece=piece, meshes={}, model=model_of(scene))
    march = march_on(LEVELS[0], better, last)
    seconds[better.model] = sum(last.values())
    if march.interrupted:
        raise KeyboardInterrupt
    if march.failed and len(march.readings) < len(refined_run.march.readings):
        raise RefusedError(f"it stopped at {march.stopped}")
    refined = (
        refined_run.refined
        if refined_run.refined.after
        else replace(refined_run.refined, after=refined_run.march)
    )
    return better, replace(refined_run, march=march, refined=refined)


def _relative(on: MarchSetup, refined_run: RefinedRun) -> float:
    """The largest drift of a monitored ridge's differential stress, of the largest stress."""
    stress = differential(on.piece, on.scene, refined_run.march)
    largest = max((float(np.abs(error).max()) for error in stress.values()), default=0.0)
    return max(drifted(on, refined_run.march).values(), default=0.0) / largest if largest else 0.0
