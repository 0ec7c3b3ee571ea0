"""Slip: mesh, order and time step of the paper's scene, by the differential stress and by when a ridge slips.

Quasi-static Coulomb friction knows no rate, so a coarser step does not blur the signal: it moves the instant
at which a ridge is found to slip.
"""

from __future__ import annotations

from skincad.base.errors import InputError, RefusedError
from skincad.base.stopwatch import Progress
from skincad.inputs.design import Design
from skincad.ladders.ladder import ErrorMeasure, Ladder, Measurement, repeated, timed
from skincad.ladders.scenes import apart, marched, of_size, scene_on
from skincad.scenes.levels import LEVELS, Level, expected
from skincad.scenes.simulation import Simulation
from skincad.shape.skin import skin_of

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
    for model, settings in _ways().items():
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
    for settings in _ways().values():
        for setting, mesh, steps in settings:
            once = LAST * larger if mesh == MESHES[-1] else _seconds(mesh, steps) * larger
            seconds[_stage(setting)] = repeated(once, 1 if setting == settings[-1][0] else repeats)
    return seconds


def _seconds(mesh: tuple[float, int], steps: int) -> float:
    """Of yamada-2002: the first mesh's, measured, carried on as `simulate` does."""
    first, level = LEVELS[0], LEVELS[MESHES.index(mesh)]
    spent = {**FIRST, "march": FIRST["march"] * steps / STEPS[3]}
    return FIRST["mesh"] + expected(level, first, spent)


def _ways() -> dict[str, list[tuple[str, tuple[float, int], int]]]:
    """Settings by model: in words, the mesh and the steps."""
    return {
        "mesh": [(f"fineness {f:g}, order {k}", (f, k), STEPS[3]) for f, k in MESHES],
        "time step": [(f"{n} steps", MESHES[0], n) for n in STEPS],
    }


def _stage(setting: str) -> str:
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
        progress(_stage(setting))
    scene = scene_on(design, f"history.steps={steps}")
    simulation, runs = timed(lambda: marched(scene, Level(*mesh), MOST), repeats)
    return setting, simulation, runs
