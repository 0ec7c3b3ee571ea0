"""The ladder of effects: what leaving each out changes.

Effects: what each changes in the paper's scene, and what it costs. Every effect there is is named and left
out in turn, with its default table, on the coarsest mesh. The error is what leaving it out does; the time is
the scene's with it. Effects change by different physics, so nothing here is a step towards anything: no line
joins them.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

from skincad.base.errors import InputError, RefusedError
from skincad.effects import EFFECTS, effect
from skincad.effects.kinds import Reader
from skincad.inputs.design import Design
from skincad.scenes.march import LEVELS
from skincad.scenes.scene import LAW
from skincad.scenes.simulation import Simulation
from skincad.shape.skin import skin_of
from skincad.studies.accuracy.ladder import ErrorMeasure, Ladder, Measurement, timed
from skincad.studies.accuracy.slip import apart, marched, scene_on

STEPS, FEWER = 550, {"finite_strain": 55}  # of the march; where a step is expensive, fewer
SLIPPERY = {"finite_strain": 0.3}  # coefficient of friction, both with and without: at 1 the surface folds
MOST = 120.0  # s a march
BESIDE = {"inertia": ("plate.mass=0.1",)}  # what naming one asks for; g, assumption: a light plate
TimedSimulation = tuple[Simulation, tuple[float, ...]]


def ladder(design: Design, repeats: int, tell: Callable[[str], None]) -> Ladder:
    """Return two trials an effect: the scene with it, and without it with the error that this makes."""

    @cache
    def run(changes: tuple[str, ...], steps: int, friction: float) -> TimedSimulation:
        scene = scene_on(design, f"history.steps={steps}", *changes, friction=friction)
        return timed(lambda: marched(scene, LEVELS[0], MOST), repeats)

    trials: list[Measurement] = []
    skipped = {LAW: "the law of every scene that names none: it can be replaced, not left out"}
    skipped |= {
        n: "a readout: it changes none of the signals" for n in EFFECTS if issubclass(effect(n), Reader)
    }
    for name in EFFECTS:
        if name in skipped:
            continue
        tell(name)
        try:
            base = scene_on(design).effects
            table = "none" if name in base else "{}"
            changed = (f"effects.{name}={table}", *(BESIDE.get(name, ()) if table == "{}" else ()))
            pair = ((), changed) if name in base else (changed, ())
            steps, friction = FEWER.get(name, STEPS), SLIPPERY.get(name, 1.0)
            (named, spent), (without, short) = (run(changes, steps, friction) for changes in pair)
        except (InputError, RefusedError) as refusal:
            skipped[name] = str(refusal)
            continue
        errors = apart(without, named)
        words = f"{steps} steps" + (f", friction {friction:g}" if name in SLIPPERY else "")
        trials.append(Measurement(name, f"named, {words}", named.march.unknowns, spent, {}))
        trials.append(Measurement(name, f"left out, {words}", without.march.unknowns, short, errors, spent))
    reference = (
        "the same scene, mesh and steps with the effect",
        "both are computed; for the mesh's error see ladder slip",
    )
    what = "S1 - S2 at the ridge read out" if skin_of(design).slot else "the plate's travel"
    measures = (
        ErrorMeasure(
            "peak rate", f"change of the peak rate of {what} by leaving the effect out", "1", *reference
        ),
        ErrorMeasure("signal", f"largest change of {what} by leaving the effect out", "1", *reference),
        ErrorMeasure("slip", "change of when the ridge slips, of the history's length", "1", *reference),
    )
    title = f"effects in the slip of {design.name}"
    return Ladder("effects", title, tuple(trials), measures, lines=False, skipped=skipped)
