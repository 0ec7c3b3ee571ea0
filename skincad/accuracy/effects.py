"""Effects: what each changes in the paper's scene, and what it costs.

Every effect there is is named and left out in turn, with its default table, on the coarsest mesh. The error
is what leaving it out does; the time is the scene's with it. Effects change by different physics, so nothing
here is a step towards anything: no line joins them.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import cache

from skincad.accuracy.ladder import Ladder, Measure, Rung, timed
from skincad.accuracy.scenes import apart, marched, scene_on
from skincad.design import Design
from skincad.effects import EFFECTS, effect
from skincad.effects.kinds import Readout
from skincad.errors import InputError, RefusedError
from skincad.levels import LEVELS
from skincad.scene import LAW
from skincad.simulation import Simulation
from skincad.stopwatch import Progress

STEPS = {550: 8.0, 55: 12.0}  # steps of the march and the s that it may take; the first that fits counts
BESIDE = {"inertia": ("plate.mass=0.1",)}  # what naming one asks for; g, assumption: a light plate
Marched = tuple[Simulation, tuple[float, ...]]


def ladder(design: Design, repeats: int, progress: Progress | None) -> Ladder:
    """Return two rungs an effect: the scene with it, and without it with the error that this makes."""

    @cache
    def run(changes: tuple[str, ...], steps: int) -> Marched:
        scene = scene_on(design, f"history.steps={steps}", *changes)
        return timed(lambda: marched(scene, LEVELS[0], STEPS[steps]), repeats)

    rungs: list[Rung] = []
    skipped = {LAW: "the law of every scene that names none: it can be replaced, not left out"}
    skipped |= {n: "a readout: it changes nothing that it tells of" for n in EFFECTS if _reads(n)}
    for name in EFFECTS:
        if name in skipped:
            continue
        if progress:
            progress(f"effects: {name}")
        try:
            base = scene_on(design).effects
            table = "none" if name in base else "{}"
            changed = (f"effects.{name}={table}", *(BESIDE.get(name, ()) if table == "{}" else ()))
            pair = ((), changed) if name in base else (changed, ())
            steps, (named, spent), (without, short) = _both(run, *pair)
        except (InputError, RefusedError) as refusal:
            skipped[name] = str(refusal)
            continue
        errors = apart(without, named)
        rungs.append(Rung(name, f"named, {steps} steps", named.march.unknowns, spent, {}))
        rungs.append(Rung(name, f"left out, {steps} steps", without.march.unknowns, short, errors))
    told = (
        "the same scene, mesh and steps with the effect",
        "both are marched; the mesh's error: ladder slip",
    )
    what = "S1 - S2 at the told ridge" if design.slot else "the plate's travel"
    measures = (
        Measure("peak rate", f"change of the peak rate of {what} by leaving the effect out", "1", *told),
        Measure("signal", f"largest change of {what} by leaving the effect out", "1", *told),
        Measure("slip", "change of when the ridge slips, of the history's length", "1", *told),
    )
    title = f"effects in the slip of {design.name}"
    return Ladder("effects", title, tuple(rungs), measures, lines=False, skipped=skipped)


def _reads(name: str) -> bool:
    return issubclass(effect(name), Readout)


def _both(
    run: Callable[[tuple[str, ...], int], Marched], named: tuple[str, ...], without: tuple[str, ...]
) -> tuple[int, Marched, Marched]:
    """Both scenes at the most steps that fit into the time; raises what the fewest raise."""
    *more, fewest = STEPS
    for steps in more:
        with suppress(RefusedError):
            return steps, run(named, steps), run(without, steps)
    return fewest, run(named, fewest), run(without, fewest)
