"""From one model of a scene to the next: small strain, finite strain in chosen steps, finite strain in each.

A scene that names no law, and is asked for a tolerance, is marched in small strain first. Where leaving out
finite strain changes more than the tolerance, it is marched with finite strain in chosen steps
(effects/chosen_steps.py), on the coarsest mesh: what mesh and time step change is known from small strain. If
the drift between chosen steps is more than the tolerance too, each step is taken at finite strain, unless
that had to stop: where no step can be chosen there is no smooth state at finite strain.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from time import perf_counter
from typing import Any

import numpy as np

from skincad.base.climbing import unmet
from skincad.base.errors import InputError, RefusedError
from skincad.effects.kinds import Law
from skincad.scenes.climb import RefinedRun, differential
from skincad.scenes.levels import LEVELS
from skincad.scenes.march import INTERRUPTED, March
from skincad.scenes.omitted import omitted
from skincad.scenes.on_mesh import Marching, march_on, piece_for
from skincad.scenes.scene import Scene

SMALL_STRAIN, CORRECTED, FINITE_STRAIN = "small_strain", "corrected", "finite_strain"
CHOSEN, EACH = ({FINITE_STRAIN: {"steps": steps}} for steps in ("chosen", "all"))
DRIFTS = "between chosen steps the differential stress drifts by {:.2g} of its largest"
# What a scene in chosen steps may take, in condensations of small strain's two meshes, and each step of
# finite strain by a chosen one; as of bench/table_leads.py
DEAR, DEARER = 40.0, 1.0


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


def drifted(on: Marching, march: March) -> dict[int, float]:
    """Return the largest drift of each told ridge's difference, MPa; nothing without chosen steps."""
    if march.readings[-1].drift is None:
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
    on: Marching,
    climbed: RefinedRun,
    tol: float,
    budget: float | None,
    began: float,
    seconds: dict[str, float],
) -> tuple[Marching, RefinedRun]:
    """Return what is marched, and the march that counts, by the model that `tol` asks for: `found` in small
    strain, or one beyond it. `seconds` are by stage; `budget` s run from `began`."""
    scene, short = on.scene, climbed.short
    if not _asks(scene, climbed.march, tol):
        return on, climbed
    try:
        price = DEAR * seconds["condense"]
        on, climbed = _by(CHOSEN, on, climbed, price, budget, began, seconds)
        drift, last = _relative(on, climbed), climbed.march.readings[-1].drift
        if drift <= tol:
            return on, climbed
        climbed = replace(climbed, short=[*short, *unmet(DRIFTS.format(drift), drift, tol)])
        if last is None or last.cut:  # finite strain in each step would stop there
            return on, climbed
        steps = chosen_steps(climbed.march) or [0]
        price = DEARER * seconds[CORRECTED] * scene.history.step_count / len(steps)
        on, climbed = _by(EACH, on, climbed, price, budget, began, seconds)
        return on, replace(climbed, short=short)
    except KeyboardInterrupt:
        if not on.partial:
            raise
        return on, replace(climbed, march=replace(climbed.march, stopped=INTERRUPTED))
    except (InputError, RefusedError) as refusal:
        return on, replace(
            climbed, short=[*climbed.short, f"no model beyond this one was marched: {refusal}"]
        )


def _asks(scene: Scene, small: March, tol: float) -> bool:
    """Whether small strain leaves out more than `tol` of a scene that names no law and tells a signal."""
    named = any(isinstance(part, Law) for part in scene.parts.values())
    if named or not scene.readout.ridges or small.failed or small.interrupted:
        return False
    left_out = {entry.effect: entry.change for entry in omitted(scene, small)}
    return left_out.get(FINITE_STRAIN, 0.0) > tol


def _by(
    law: Mapping[str, Any],
    on: Marching,
    climbed: RefinedRun,
    price: float,
    budget: float | None,
    began: float,
    seconds: dict[str, float],
) -> tuple[Marching, RefinedRun]:
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
    if march.failed and len(march.readings) < len(climbed.march.readings):
        raise RefusedError(f"it stopped at {march.stopped}")
    refined = climbed.refined if climbed.refined.after else replace(climbed.refined, after=climbed.march)
    return better, replace(climbed, march=march, refined=refined)


def _relative(on: Marching, climbed: RefinedRun) -> float:
    """The largest drift of a told ridge's differential stress, of the largest stress."""
    stress = differential(on.piece, on.scene, climbed.march)
    largest = max((float(np.abs(error).max()) for error in stress.values()), default=0.0)
    return max(drifted(on, climbed.march).values(), default=0.0) / largest if largest else 0.0
