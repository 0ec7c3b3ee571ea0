"""Which runs a scene needs until its error is as small as wanted.

A scene that names no law is marched in small strain first, on one mesh after the other. Where leaving out
finite strain changes more than a tenth, or than the tolerance that is asked, it is marched with finite strain
in chosen steps (effects/chosen_steps.py), with free ends where they matter, on the coarsest mesh: what mesh
and time step change is known from small strain. Where the surface folds it is marched again with rounder
fillets, to tell what a fold depends on; and where a tip's corner snaps, so that no step can be chosen, that
march is the one that counts. If the drift between chosen steps is more than a tolerance too, each step is
taken at finite strain, unless the surface folds or no step could be chosen: a fold depends on the mesh in
each step too.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import pairwise
from math import inf
from time import perf_counter
from typing import Any

import numpy as np

from skincad.base.adaptivity import overrun, unmet
from skincad.base.errors import InputError, RefusedError
from skincad.effects import INDICATORS, effect
from skincad.effects.kinds import FRICTIONLESS, RELIEF, Law, LeftOutEffect, PlatePath, SceneOutline
from skincad.mechanics.fits import unlike
from skincad.scenes.errors import change_of_slip_share, near_chosen
from skincad.scenes.march import EXPONENT, INTERRUPTED, LEVELS, March, expected
from skincad.scenes.runs import (
    MarchSetup,
    Runs,
    differential,
    drifted,
    march_coarse_steps,
    march_on,
    march_under_heavy_plate,
    marches_masses,
    piece_for,
)
from skincad.scenes.scene import Scene
from skincad.shape.skin import skin_of

SMALL_STRAIN, FINITE_STRAIN = "small_strain", "finite_strain"
IN_CHOSEN_STEPS = "corrected"  # as the JSON key `tier` has it; a check's `corrected` is another model
FREE_ENDS = "free_ends"
ROUNDER = "rounder fillets"  # stage
CHOSEN, EACH = ({FINITE_STRAIN: {"steps": steps}} for steps in ("chosen", "all"))
DRIFTS = "between chosen steps {} by {:.2g} of the largest"
NO_BETTER = "no model beyond this one was marched: {}"
# of the largest differential stress; what is left out changes more (docs/evidence/facts.md)
DEFAULT_TOLERANCE = 0.05
# s of a march in chosen steps, and of one with free ends, on a mesh of so many unknowns: yamada-2002-slip on
# two cores of 2026; and each step of finite strain by a chosen one
DEAR, ENDS_DEAR, OF_UNKNOWNS, DEARER = 25.0, 5.0, 22_676, 1.0
# s of the equilibria of pins of one height; of more heights no more are solved than reduced.MOST_NODES says
OF_HEIGHT, MOST_HEIGHTS = 12.0, 4
PROMPT = 60.0  # s
# Rounder fillets: at tips of the width, at roots of the radius. At half as much at tips corners still snap
ROUNDER_TIP, ROUNDER_ROOT = 0.4, 1.5
MATTERS = 0.1  # relative; a larger change is warned of
ENDS_MATTER = 0.02  # relative; a larger change is computed


def refine(on: MarchSetup, tol: float | None, budget: float | None, began: float) -> Runs:
    """March on one mesh after the other as `simulate` says; `began` is when the budget began to run."""
    wanted, timed = tol or DEFAULT_TOLERANCE, bool(on.scene.timed)
    runs, relative = _coarsest(on, timed, budget is None), inf
    goal = wanted if tol is not None or budget is None else 0.0  # a budget alone asks for the best it buys
    for last, level in pairwise(LEVELS):
        if relative <= goal or runs.march.failed or runs.march.interrupted:
            break
        price = expected(level, last, {**runs.march.seconds, "mesh": on.seconds["mesh"]})
        if budget is not None and perf_counter() - began + price > budget:
            break
        try:
            march = march_on(level, on)
        except KeyboardInterrupt:
            if not on.partial:
                raise
            runs = _interrupted(runs)
            break
        except (InputError, RefusedError) as refusal:
            runs = _noted(runs, f"a finer mesh is refused ({refusal}); {BEFORE}")
            break
        if march.interrupted:  # a whole march says more than a part
            runs = _interrupted(runs)
            break
        if march.failed and relative <= wanted:  # what is there is good enough
            runs = _noted(runs, f"a finer mesh stopped at {march.stopped}; {BEFORE}")
            break
        error, relative = _errors(on, runs.march, march)
        runs = replace(runs, march=march, before=runs.march, error=error)
    if timed and on.piece is not None:
        how = "of unknown error" if runs.error is None else f"within {relative:.1e}"
        words = f"the share that slips is {how}"
        if on.scene.readout.ridges:
            words = f"the differential stress is {how}" + " of its largest" * (runs.error is not None)
        runs = _noted(runs, *unmet(words, relative, wanted))
    return _noted(runs, *overrun("", perf_counter() - began, budget))


BEFORE = "the results are those of the mesh before"


def _coarsest(on: MarchSetup, timed: bool, two: bool) -> Runs:
    """The march on the coarsest mesh, and those that are held against it; `two` meshes are the least."""
    following = LEVELS[1] if two and len(LEVELS) > 1 else None
    march = march_on(LEVELS[0], on, following, timed)
    if not timed or march.failed or march.interrupted:
        return Runs(march)
    after = expected(following, LEVELS[0], march.seconds) if following else 0.0
    coarse = march_coarse_steps(on, march, after)
    if coarse is not None and coarse.interrupted:  # Ctrl-C ends the refinement, not its march
        return _interrupted(Runs(march, every=march))
    return Runs(march, every=march, coarse=coarse, heavy=march_under_heavy_plate(on, march))


def _noted(runs: Runs, *notes: str) -> Runs:
    """Return the runs with more notes."""
    return replace(runs, notes=(*runs.notes, *notes))


def _interrupted(runs: Runs) -> Runs:
    return replace(runs, march=replace(runs.march, stopped=INTERRUPTED))


def _errors(on: MarchSetup, before: March, march: March) -> tuple[dict[int, float], float]:
    """Largest change of each monitored ridge's difference from the mesh before, MPa; largest relative one, or
    of a skin without films the mean change of the share that slips, of all steps."""
    if not on.scene.readout.ridges and on.piece is not None:
        return {}, change_of_slip_share(before, march)
    one, other = (differential(on.scene, run) for run in (before, march))
    steps = min(before.time.size, march.time.size)
    error = {r: float(np.abs(one[r][:steps] - other[r][:steps]).max()) for r in one}
    largest = max((float(np.abs(v).max()) for v in other.values()), default=0.0)
    return error, max(error.values(), default=0.0) / largest if largest else 0.0


def further(
    on: MarchSetup, runs: Runs, tol: float | None, budget: float | None, began: float
) -> tuple[MarchSetup, Runs]:
    """Return what is marched, and the runs, by the model that the scene calls for: what was found in small
    strain, or one beyond it. Without `tol` that is one which is expected to take at most PROMPT s; `budget` s
    run from `began`."""
    scene, wanted = on.scene, _missing(on.scene, runs.march, tol, pins=on.piece is None)
    ends = {name: table for name, table in wanted.items() if name == FREE_ENDS}
    try:
        for effects in filter(None, [wanted, ends] if ends != wanted else [wanted]):
            price = _price(effects, runs.every or runs.march, on)
            try:
                if tol is None and price > PROMPT:
                    words = f"finite strain in chosen steps would take about {price:.2g} s"
                    raise RefusedError(f"{words}; --tol {DEFAULT_TOLERANCE:g} includes it")
                on, runs = _by(effects, on, runs, price, budget, began)
                break
            except (InputError, RefusedError) as refusal:
                runs = _noted(runs, NO_BETTER.format(refusal))
        runs = _marched_rounder(on, runs, budget, began)
        drift = runs.march.readings[-1].drift
        if tol is None or drift is None or (relative := _drift(on, runs.march)) <= tol:
            return on, runs
        notes = runs.notes
        drifts = "the differential stress drifts" if on.piece else "pins' forces drift"
        runs = _noted(runs, *unmet(DRIFTS.format(drifts, relative), relative, tol))
        # each step folds as these do, and takes long where none can be chosen; a law that is named stays
        if runs.fillets or folds(runs.march) or on.model != IN_CHOSEN_STEPS or on.piece is None:
            return on, runs
        price = DEARER * on.seconds[IN_CHOSEN_STEPS] * scene.history.step_count
        price /= len(chosen_steps(runs.march) or [0])
        on, runs = _by({**wanted, **EACH}, on, runs, price, budget, began)
        return on, replace(runs, notes=notes)
    except KeyboardInterrupt:
        if not on.partial:
            raise
        return on, _interrupted(runs)
    except (InputError, RefusedError) as refusal:
        return on, _noted(runs, NO_BETTER.format(refusal))


def _missing(scene: Scene, small: March, tol: float | None, *, pins: bool) -> dict[str, dict[str, Any]]:
    """What a scene that names no law, and tells a signal or is of pins, is marched with beside small strain:
    effects whose absence changes more than `tol`, or what is MATTERS or ENDS_MATTER without one. Small strain
    that pins have left is no reason to stay there."""
    named = any(isinstance(part, Law) for part in scene.parts.values())
    moving = bool(scene.moving)  # which neither knows: with a tolerance that is said
    drawn = scene.readout.steps or scene.readout.frames  # of which finite strain tells no section
    # what finite strain does not know either
    turns = any(scene.history.rotation_deg or []) or RELIEF in scene.asked
    told = pins or (scene.swept and scene.timed and not small.failed)
    if named or (moving and tol is None) or not told or small.interrupted:
        return {}
    change = {entry.effect: entry.change for entry in left_out_effects(scene, path_of(small))}
    wanted: dict[str, dict[str, Any]] = {}
    if change.get(FINITE_STRAIN, 0.0) > (tol or MATTERS) and not drawn and not turns:
        wanted |= CHOSEN
    ends_matter = change.get(FREE_ENDS, 0.0) > min(tol or 1.0, ENDS_MATTER)
    if ends_matter and not (pins or moving) and skin_of(scene.design).body != "bent":
        wanted[FREE_ENDS] = {}
    return wanted


def _price(effects: Mapping[str, Any], coarse: March, on: MarchSetup) -> float:
    """About how many s a march with these effects takes, by the unknowns of the coarsest mesh, or by the
    heights of pins, and not by the clock: so a scene has the same model on every machine."""
    if on.piece is None:
        return OF_HEIGHT * min(len(set(skin_of(on.scene.design).heights)), MOST_HEIGHTS)
    size = float((coarse.unknowns / OF_UNKNOWNS) ** EXPONENT)
    return (DEAR if FINITE_STRAIN in effects else ENDS_DEAR) * size


def _by(
    law: Mapping[str, Any], on: MarchSetup, runs: Runs, price: float, budget: float | None, began: float
) -> tuple[MarchSetup, Runs]:
    """March by another law on the coarsest mesh; RefusedError where that would overrun the budget or stops
    before what was found already. What mesh and time step change stays as it was found, in small strain."""
    if budget is not None and perf_counter() - began + price > budget:
        raise RefusedError(f"it would take about {price:.2g} s, more than the budget of {budget:g} s leaves")
    scene = on.scene.with_(effects=law)
    piece = piece_for(scene, on.seconds)
    better = replace(on, scene=scene, piece=piece, meshes={}, model=model_of(scene), seconds={})
    if piece is None:  # its errors are those at finite strain too
        found = refine(better, None, None, began)
    else:
        found = replace(runs, march=march_on(LEVELS[0], better), after=runs.after or runs.march)
    march = found.march
    on.seconds[better.model] = sum(march.seconds.values())
    if march.interrupted:
        raise KeyboardInterrupt
    if march.failed and len(march.readings) < len(runs.march.readings):
        raise RefusedError(f"it stopped at {march.stopped}")
    return replace(better, seconds=on.seconds), found


def _marched_rounder(on: MarchSetup, runs: Runs, budget: float | None, began: float) -> Runs:
    """The runs with a march with rounder fillets too, where the surface folds in chosen steps."""
    if on.model != IN_CHOSEN_STEPS or not folds(runs.march) or on.scene.design.ridge is None:
        return runs  # a face has no fillets
    price = on.seconds[IN_CHOSEN_STEPS]
    try:
        if budget is not None and perf_counter() - began + price > budget:
            raise RefusedError(f"that would take about {price:.2g} s, more than the budget leaves")
        scene = with_rounder_fillets(on.scene)
        piece = piece_for(scene.with_(effects={FREE_ENDS: None}), on.seconds)
        assert on.piece is not None
        assert piece is not None
        piece = replace(piece, pad=replace(piece.pad, ends=on.piece.pad.ends))  # fillets don't change ends
        march = march_on(LEVELS[0], replace(on, scene=scene, piece=piece, meshes={}, seconds={}))
        on.took(ROUNDER, sum(march.seconds.values()))
    except (InputError, RefusedError) as refusal:
        return _noted(runs, f"no march with rounder fillets tells what a fold changes: {refusal}")
    if march.interrupted:
        raise KeyboardInterrupt
    return held_against_rounder(runs, march, scene)


def folds(march: March) -> bool:
    """Return whether the surface folds, or no step can be chosen any more."""
    drift = march.readings[-1].drift
    return _first_fold(march) is not None or (drift is not None and bool(drift.cut))


def with_rounder_fillets(scene: Scene) -> Scene:
    """Return the scene with rounder fillets. Raises InputError where they do not fit, and RefusedError
    without ridges."""
    ridge = scene.design.ridge
    if ridge is None:
        raise RefusedError("a skin without ridges has none")
    tip, root = max(ridge.tip_fillet, ROUNDER_TIP * ridge.tip_width), ROUNDER_ROOT * ridge.root_fillet
    if (tip, root) == (ridge.tip_fillet, ridge.root_fillet):
        raise RefusedError("its fillets are as round as can be")
    return scene.with_(skin={"ridge": {"tip_fillet": tip, "root_fillet": root}})


def held_against_rounder(runs: Runs, rounder: March, scene: Scene) -> Runs:
    """Return the runs with a march of a `scene` with rounder fillets: the one that counts if it chooses steps
    where the fillets as drawn let none be chosen."""
    march, ridge = runs.march, scene.design.ridge
    assert ridge is not None
    if near_chosen(march, rounder) <= 1:
        words = "no march with rounder fillets tells what a fold changes: both have no chosen step in common"
        return _noted(runs, words)
    worse = rounder.failed and len(rounder.readings) < len(march.readings)
    last, later = ((chosen_steps(one) or [0])[-1] for one in (march, rounder))
    drift = march.readings[-1].drift
    if drift is None or not drift.cut or worse or later <= last:
        return replace(runs, fillets=rounder)
    words = (
        f"with fillets as drawn no step after {last} could be taken at finite strain: {drift.cut}; what is "
        f"told is of fillets of {ridge.tip_fillet:.2g} mm at the tips and {ridge.root_fillet:.2g} mm at the "
        "roots, and what these change is in the errors"
    )
    return _noted(replace(runs, march=rounder, fillets=march), words)


def _drift(on: MarchSetup, march: March) -> float:
    """The largest drift of a monitored ridge's differential stress, of the largest stress."""
    if on.piece is None:
        drifts = [reading.drift.forces.max() for reading in march.readings if reading.drift]
        return float(max(drifts) / np.abs(march.loads[:, :2]).max())
    stress = differential(on.scene, march)
    largest = max((float(np.abs(error).max()) for error in stress.values()), default=0.0)
    return max(drifted(on.scene, march).values(), default=0.0) / largest if largest else 0.0


def model_of(scene: Scene) -> str:
    """Return the model that a scene is marched by."""
    named = scene.parts.get(FINITE_STRAIN)
    if named is None:
        return SMALL_STRAIN
    return IN_CHOSEN_STEPS if getattr(named, "steps", None) == "chosen" else FINITE_STRAIN


def chosen_steps(march: March) -> list[int] | None:
    """Return the steps of a march that were chosen for finite strain; None where it does not choose any."""
    drifts = [reading.drift for reading in march.readings]
    return None if drifts[-1] is None else [i for i, drift in enumerate(drifts) if drift and drift.chosen]


def _first_fold(march: March) -> int | None:
    return next((step for step, reading in enumerate(march.readings) if reading.fold), None)


def at_finite_strain(runs: Runs) -> Iterator[str]:
    """Yield what to warn of where the surface folds, and where no more steps could be chosen."""
    march = runs.march
    if (step := _first_fold(march)) is not None:
        words = f"from step {step} on {march.readings[step].fold}"
        told = "and what rounder ones change is in the errors" if runs.fillets else "which no error includes"
        yield f"{words}; how it folds depends on fillets and mesh, {told}"
    drift, chosen = march.readings[-1].drift, chosen_steps(march)
    if drift is not None and chosen and drift.cut:
        words = f"after step {chosen[-1]} no step could be taken at finite strain: {drift.cut}"
        yield f"{words}; the skin stays linear about that step, and what that misses is in the errors"


def left_out_effects(
    scene: Scene, path: PlatePath, further: Iterable[LeftOutEffect] = ()
) -> list[LeftOutEffect]:
    """Return the effects that a scene leaves out, the one that matters most first, by the path of its march;
    `further` is what its pad leaves out besides.
    Where no design that its constants were fitted to is like this one, an estimate is not calibrated."""
    history = scene.history
    if skin_of(scene.design).standing:
        from skincad.effects.pin_pad import left_out

        return left_out(scene.design, path, bent=FINITE_STRAIN in scene.effects)
    driven = history.tangential_force_N is None
    pull = (history.displacement_mm if driven else history.tangential_force_N) or []
    loads = (tuple(history.normal_force_N), tuple(pull))
    static = (scene.cone or FRICTIONLESS).static
    outline = SceneOutline(scene.design, tuple(history.time_s), loads, path, driven, static)
    there = {*scene.effects, *(["inertia"] if marches_masses(scene) else [])}
    there |= set() if scene.swept else {FREE_ENDS}  # it has none
    unnamed = [name for name in INDICATORS if name not in there]
    entries = [
        replace(entry, calibrated=False, within=None) if unlike(scene.design, effect=name) else entry
        for name in unnamed
        if (entry := effect(name).left_out(outline))
    ]
    return sorted([*entries, *further], key=lambda entry: -entry.change)


def path_of(march: March) -> PlatePath:
    """Return what a march found, as indicators see it."""
    normal_loads, pulled, area = np.moveaxis(march.loads, 1, 0)
    films = march.column("films")[:, :, 0]
    of = (march.ridge[:, None] == np.arange(1, normal_loads.shape[1] + 1)).astype(float)
    touches, slips = (march.column(name).astype(float) @ of for name in ("touches", "slips"))
    return PlatePath(
        time=march.time,
        approach=march.column("approach"),
        travel=march.column("travel"),
        pressed=normal_loads,
        pulled=pulled,
        slips=slips / np.maximum(touches, 1.0),  # of each ridge's touching points
        felt=films[:, ::2] - films[:, 1::2],
        area=area,
    )
