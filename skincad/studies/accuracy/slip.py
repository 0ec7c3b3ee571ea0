"""The ladder of slip: a scene's meshes and steps.

Slip: mesh, order and time step of the paper's scene, by the differential stress and by when a ridge slips.
Quasi-static Coulomb friction knows no rate, so a coarser step does not blur the signal: it moves the instant
at which a ridge is found to slip.
"""

from __future__ import annotations

from time import perf_counter

import numpy as np

from skincad.base.arrays import Array
from skincad.base.errors import InputError, RefusedError
from skincad.base.progress import Progress
from skincad.inputs.design import Design
from skincad.scenes.march import LEVELS, Level, expected
from skincad.scenes.scene import LAW, Scene, load_scene
from skincad.scenes.simulation import Simulation, at_level
from skincad.shape.skin import skin_of
from skincad.studies.accuracy.ladder import ErrorMeasure, Ladder, Measurement, repeated, timed

SCENE, FORCE = "yamada-2002-slip", 4.0  # its normal force, N
TOLD = 3  # paper: the third ridge from an end


def of_size(design: Design) -> float:
    """Return how large a skin is of the paper's, on which the ladders' times were measured."""
    return skin_of(design).count / skin_of(load_scene(SCENE).design).count


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


def peak_rate(simulation: Simulation) -> float:
    """Return the largest rate of the band-limited signals, MPa/s; 0 without any."""
    return max((float(np.abs(signal.rate).max()) for signal in simulation.signals.values()), default=0.0)


def slip_time(simulation: Simulation) -> float | None:
    """Return when the told ridge slips for good, s; None where it does not."""
    step = simulation.slip_steps[min(TOLD, len(simulation.slip_steps)) - 1]
    return None if step is None else float(simulation.march.time[step])


def apart(simulation: Simulation, truth: Simulation) -> dict[str, float]:
    """Return the errors of the signal, relative to its largest, of its peak rate, and of the slip's time,
    relative to the history's length."""
    end = min(simulation.march.time[-1], truth.march.time[-1])
    at = simulation.march.time[simulation.march.time < end]  # the last state is at the brink of gross slip
    exact = np.interp(at, truth.march.time, signal(truth))
    errors = {"signal": float(np.abs(signal(simulation)[: at.size] - exact).max() / np.abs(exact).max())}
    if there := peak_rate(truth):
        errors["peak rate"] = abs(peak_rate(simulation) / there - 1)
    first, last = slip_time(simulation), slip_time(truth)
    if first is not None and last is not None:
        errors["slip"] = abs(first - last) / truth.scene.history.time_s[-1]
    return errors


MESHES = (*((level.fineness, level.order) for level in LEVELS), (1.0, 5))  # the last is the reference
STEPS = (55, 110, 275, 550, 2200)  # of one history, 550 the paper's; the last is the reference
MOST = 120.0  # s a trial
# s of yamada-2002 on the first mesh and, in all, on the last; measured
FIRST, LAST = {"mesh": 0.52, "condense": 0.95, "march": 0.4}, 15.0


def ladder(design: Design, repeats: int, progress: Progress | None) -> Ladder:
    """Return the scene on each mesh at the paper's step, and at each step on the coarsest mesh."""
    trials: list[Measurement] = []
    known: list[str] = []
    skipped: dict[str, str] = {}
    for model, settings in settings_by_model().items():
        try:
            results = [
                _marched(design, *mesh_and_steps, repeats, progress) for mesh_and_steps in settings[:-1]
            ]
            results.append(
                _marched(design, *settings[-1], 1, progress)
            )  # the reference: its time is not asked
        except (InputError, RefusedError) as refusal:
            skipped[model] = str(refusal)
            continue
        setting, truth, _ = results[-1]
        trials += [
            Measurement(model, s, f.march.unknowns, runs, apart(f, truth)) for s, f, runs in results[:-1]
        ]
        differs = trials[-1].errors["signal"]
        known.append(f"{model}: {setting}; {trials[-1].setting} differs by {differs:.0e} of the signal")
    what = "S1 - S2 at the ridge read out" if skin_of(design).slot else "the plate's travel"
    words = ("each way's own finest setting", "; ".join(known))
    measures = (
        ErrorMeasure(
            "signal", f"largest error of {what}, relative to its largest", "1", *words, compares=False
        ),
        ErrorMeasure("peak rate", "error of the signal's peak rate, relative", "1", *words, compares=False),
        ErrorMeasure(
            "slip", "error of when the ridge slips, of the history's length", "1", *words, compares=False
        ),
    )
    return Ladder("slip", f"slip of {design.name}", tuple(trials), measures, skipped=skipped)


def prices(design: Design, repeats: int) -> dict[str, float]:
    """Return the stages and their expected seconds."""
    larger = of_size(design)
    seconds = {}
    for settings in settings_by_model().values():
        for setting, mesh, steps in settings:
            once = LAST * larger if mesh == MESHES[-1] else _seconds(mesh, steps) * larger
            seconds[stage_name(setting)] = repeated(once, 1 if setting == settings[-1][0] else repeats)
    return seconds


def _seconds(mesh: tuple[float, int], steps: int) -> float:
    """Of yamada-2002: the first mesh's, measured, carried on as `simulate` does."""
    first, level = LEVELS[0], LEVELS[MESHES.index(mesh)]
    spent = {**FIRST, "march": FIRST["march"] * steps / STEPS[3]}
    return FIRST["mesh"] + expected(level, first, spent)


def settings_by_model() -> dict[str, list[tuple[str, tuple[float, int], int]]]:
    """Settings by model: in words, the mesh and the steps."""
    return {
        "mesh": [(f"fineness {f:g}, order {k}", (f, k), STEPS[3]) for f, k in MESHES],
        "time step": [(f"{n} steps", MESHES[0], n) for n in STEPS],
    }


def stage_name(setting: str) -> str:
    """Return what the bar calls a setting's march."""
    return f"slip: {setting}"


def _marched(
    design: Design,
    setting: str,
    mesh: tuple[float, int],
    steps: int,
    repeats: int,
    progress: Progress | None,
) -> tuple[str, Simulation, tuple[float, ...]]:
    if progress:
        progress(stage_name(setting))
    scene = scene_on(design, f"history.steps={steps}")
    simulation, runs = timed(lambda: marched(scene, Level(*mesh), MOST), repeats)
    return setting, simulation, runs
