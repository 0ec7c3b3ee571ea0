"""The paper's scene on the skin in question: what the ladders of slip and of effects march."""

from __future__ import annotations

from time import perf_counter

import numpy as np

from skincad.base.arrays import Array
from skincad.base.errors import RefusedError
from skincad.inputs.design import Design
from skincad.mechanics.models.table import plane_unknowns
from skincad.scenes.levels import Level
from skincad.scenes.scene import Scene, load_scene
from skincad.scenes.simulation import Simulation, at_level
from skincad.shape.skin import skin_of

SCENE, FORCE = "yamada-2002-slip", 4.0  # its normal force, N
TOLD = 3  # paper: the third ridge from an end


def of_size(design: Design) -> float:
    """Return how large a skin is of the paper's, on which the ladders' times were measured."""
    return plane_unknowns(design) / plane_unknowns(load_scene(SCENE).design)


def scene_on(design: Design, *more: str, friction: float = 1.0) -> Scene:
    """Return the scene with this skin, its forces scaled to the design's, `more` as `--set` texts.

    With another coefficient of friction the pull is that many times as large. A skin without slots has no
    films to tell of. Raises InputError for what scene and skin do not allow.
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
