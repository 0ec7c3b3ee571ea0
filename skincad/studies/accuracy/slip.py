"""The ladder of slip: a scene's meshes and steps.

Slip: mesh, order and time step of the paper's scene, by the differential stress and by when a ridge slips.
Quasi-static Coulomb friction knows no rate, so a coarser step does not blur the signal: it moves the instant
at which a ridge is found to slip.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from time import perf_counter

import numpy as np

from skincad.base.arrays import Array
from skincad.base.errors import InputError, RefusedError
from skincad.inputs.design import Design
from skincad.scenes.march import LEVELS, Level
from skincad.scenes.scene import LAW, Scene, load_scene
from skincad.scenes.simulation import Simulation, at_level
from skincad.shape.skin import skin_of
from skincad.studies.accuracy.ladder import ErrorMeasure, Ladder, Measurement, timed

SCENE, FORCE = "yamada-2002-slip", 4.0  # its normal force, N
TOLD = 3  # paper: the third ridge from an end


def scene_on(design: Design, *more: str, friction: float = 1.0) -> Scene:
    """Return the scene with this skin, its forces scaled to the design's, `more` as `--set` texts.

    With another coefficient of friction the pull is that many times as large. A skin without slots has no
    films to tell of; no mass counts but where it is named. Raises InputError for what scene and skin do not
    allow.
    """
    skin = skin_of(design)
    plain = load_scene(SCENE).history
    scale = design.contact.force / FORCE
    pulls = plain.tangential_force_N or []
    changes = [
        f"history.normal_force_N={[scale * f for f in plain.normal_force_N]}",
        f"history.tangential_force_N={[friction * scale * f for f in pulls]}",
        *([] if friction == 1.0 else [f"effects.friction.coefficient={friction}"]),
        f"readout.ridges={[min(TOLD, skin.count)] if skin.slot else []}",
        *([] if any("finite_strain" in text for text in more) else [f"effects.{LAW}.masses=false"]),
        *([] if design.film else ["effects.film=none"]),
    ]
    return load_scene(SCENE, [*changes, *more], skin=design)


def marched(scene: Scene, level: Level, most: float) -> Simulation:
    """Return the scene marched on one mesh; raises RefusedError for one that takes over `most` s or fails."""
    began = perf_counter()

    def tick(_stage: str, step: int, _left: float | None = None, /) -> None:
        if step and perf_counter() - began > most:
            raise RefusedError(
                f"takes more than {most:g} s: at step {step} of {scene.history.step_count} by then"
            )

    simulation = at_level(scene, level, tick)
    if simulation.march.failed:
        raise RefusedError(f"stopped: {simulation.march.stopped}")
    return simulation


def signal(simulation: Simulation) -> Array:
    """Return what is compared `(steps + 1,)`: the told ridge's S1 - S2, MPa, or else the travel, mm."""
    return next(iter(simulation.raw.values())) if simulation.raw else simulation.march.column("travel")


def apart(simulation: Simulation, truth: Simulation) -> dict[str, float]:
    """Return the errors of the signal, relative to its largest, of its peak rate, and of the slip's time,
    relative to the history's length."""
    end = min(simulation.march.time[-1], truth.march.time[-1])
    at = simulation.march.time[simulation.march.time < end]  # the last state is at the brink of gross slip
    exact = np.interp(at, truth.march.time, signal(truth))
    errors = {"signal": float(np.abs(signal(simulation)[: at.size] - exact).max() / np.abs(exact).max())}
    rate, there = (  # MPa/s, of the band-limited signals; 0 without any
        max((float(np.abs(s.rate).max()) for s in run.signals.values()), default=0.0)
        for run in (simulation, truth)
    )
    if there:
        errors["peak rate"] = abs(rate / there - 1)
    steps = [run.slip_steps[min(TOLD, len(run.slip_steps)) - 1] for run in (simulation, truth)]
    if steps[0] is not None and steps[1] is not None:
        late = float(simulation.march.time[steps[0]]) - float(truth.march.time[steps[1]])
        errors["slip"] = abs(late) / truth.scene.history.time_s[-1]
    return errors


MESHES = (*((level.fineness, level.order) for level in LEVELS), (1.0, 5))  # the last is the reference
STEPS = (55, 110, 275, 550, 2200)  # of one history, 550 the paper's; the last is the reference
MOST = 120.0  # s a trial


def ladder(design: Design, repeats: int, tell: Callable[[str], None]) -> Ladder:
    """Return the scene on each mesh at the paper's step, and at each step on the coarsest mesh."""
    settings = {
        "mesh": [(f"fineness {f:g}, order {k}", Level(f, k), STEPS[3]) for f, k in MESHES],
        "time step": [(f"{n} steps", Level(*MESHES[0]), n) for n in STEPS],
    }
    trials: list[Measurement] = []
    known: list[str] = []
    skipped: dict[str, str] = {}
    for model, steps in settings.items():
        results = []
        try:
            for setting, level, count in steps:
                tell(setting)
                scene = scene_on(design, f"history.steps={count}")
                # the last is the reference: its time is not asked
                times = repeats if setting != steps[-1][0] else 1
                results.append(timed(partial(marched, scene, level, MOST), times))
        except (InputError, RefusedError) as refusal:
            skipped[model] = str(refusal)
            continue
        *others, (truth, _) = results
        trials += [
            Measurement(model, setting, result.march.unknowns, runs, apart(result, truth))
            for (setting, *_), (result, runs) in zip(steps, others, strict=False)
        ]
        differs = trials[-1].errors["signal"]
        known.append(f"{model}: {steps[-1][0]}; {steps[-2][0]} differs by {differs:.0e} of the signal")
    what = "S1 - S2 at the ridge read out" if skin_of(design).slot else "the plate's travel"
    errors = {
        "signal": f"largest error of {what}, relative to its largest",
        "peak rate": "error of the signal's peak rate, relative",
        "slip": "error of when the ridge slips, of the history's length",
    }
    words = ("each way's own finest setting", "; ".join(known))
    measures = tuple(ErrorMeasure(name, text, "1", *words, compares=False) for name, text in errors.items())
    return Ladder("slip", f"slip of {design.name}", tuple(trials), measures, skipped=skipped)
