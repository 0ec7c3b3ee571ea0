"""What effects read of a march, each under keys of its own, and what follows from what they read."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from skincad.effects.kinds import Reader, ReaderContext
from skincad.scenes.march import March
from skincad.scenes.on_mesh import spent
from skincad.scenes.scene import Scene
from skincad.scenes.signals import Slips
from skincad.scenes.slip import report

Outcome = Mapping[str, Any]


def _felt(reading: Outcome, scene: Scene, march: March, slips: Slips) -> Outcome:
    """Slip as the films' outputs show it, against when ridges slip; of outputs with noise for other seeds
    too."""
    readout, noise = scene.readout, reading["output_noise_V_rms"]
    width, alarms = readout.bandwidth_Hz, readout.alarms
    runs, gross, even = slips.runs, slips.gross, scene.history.even
    noises = (
        noise_of_seed
        for effect in scene.parts.values()
        if isinstance(effect, Reader)
        for noise_of_seed in effect.other_noises(_watched(scene), march.time)
    )
    return report(march.time, reading["output_V"], noise, width, runs, gross, alarms, even, noises)


# by the key that it follows from
FOLLOWING: dict[str, Callable[[Outcome, Scene, March, Slips], Outcome]] = {"output_V": _felt}


def read(
    scene: Scene, march: March, slips: Slips, seconds: dict[str, float]
) -> tuple[dict[str, Any], list[str]]:
    """Return what the scene's readers tell, and what follows from it; and their warnings."""
    watched = _watched(scene)
    readings: dict[str, Outcome] = {}
    for name, effect in scene.parts.items():
        if isinstance(effect, Reader):
            with spent(seconds, name):
                readings[f"effects.{name}"] = effect.read(watched, march.time, march.readings)
    notes = [note for reading in readings.values() for note in reading.get("warnings", ())]
    readings = {
        who: {key: v for key, v in reading.items() if key != "warnings"} for who, reading in readings.items()
    }
    direct = joined(readings)
    after = {
        f"what follows {key}": FOLLOWING[key](direct, scene, march, slips)
        for key in direct
        if key in FOLLOWING
    }
    return joined({**readings, **after}), notes


def _watched(scene: Scene) -> ReaderContext:
    return ReaderContext(scene.design, tuple(scene.readout.ridges), scene.readout.bandwidth_Hz)


def joined(parts: Mapping[str, Outcome]) -> dict[str, Any]:
    """Return all keys, of each who tells some; raises ValueError where two tell the same one."""
    merged: dict[str, Any] = {}
    by: dict[str, str] = {}
    for who, keys in parts.items():
        for key, value in keys.items():
            if key in by:
                raise ValueError(f"{who} gives {key!r}, which {by[key]} gives already: rename one of them")
            merged[key], by[key] = value, who
    return merged
