"""What effects read of a march, each under keys of its own, and what follows from what they read."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from skincad.effects.kinds import Reader, Watched
from skincad.scenes.march import March
from skincad.scenes.on_mesh import spent
from skincad.scenes.scene import Scene
from skincad.scenes.signals import Slips
from skincad.scenes.slip import report

Told = Mapping[str, Any]


def _felt(told: Told, scene: Scene, found: March, slips: Slips) -> Told:
    """Slip as the films' outputs show it, against when ridges slip; of outputs with noise for other seeds
    too."""
    readout, noise = scene.readout, told["output_noise_V_rms"]
    width, alarms = readout.bandwidth_Hz, readout.alarms
    runs, gross, even = slips.runs, slips.gross, scene.history.even
    noises = (
        each
        for effect in scene.parts.values()
        if isinstance(effect, Reader)
        for each in effect.other_noises(_watched(scene), found.time)
    )
    return report(found.time, told["output_V"], noise, width, runs, gross, alarms, even, noises)


# by the key that it follows from
FOLLOWING: dict[str, Callable[[Told, Scene, March, Slips], Told]] = {"output_V": _felt}


def read(
    scene: Scene, found: March, slips: Slips, seconds: dict[str, float]
) -> tuple[dict[str, Any], list[str]]:
    """Return what the scene's readers tell, and what follows from it; and their warnings."""
    watched = _watched(scene)
    told: dict[str, Told] = {}
    for name, effect in scene.parts.items():
        if isinstance(effect, Reader):
            with spent(seconds, name):
                told[f"effects.{name}"] = effect.read(watched, found.time, found.readings)
    notes = [note for each in told.values() for note in each.get("warnings", ())]
    told = {who: {key: v for key, v in each.items() if key != "warnings"} for who, each in told.items()}
    direct = joined(told)
    after = {
        f"what follows {key}": FOLLOWING[key](direct, scene, found, slips)
        for key in direct
        if key in FOLLOWING
    }
    return joined({**told, **after}), notes


def _watched(scene: Scene) -> Watched:
    return Watched(scene.design, tuple(scene.readout.ridges), scene.readout.bandwidth_Hz)


def joined(told: Mapping[str, Told]) -> dict[str, Any]:
    """Return all keys, of each who tells some; raises ValueError where two tell the same one."""
    found: dict[str, Any] = {}
    by: dict[str, str] = {}
    for who, keys in told.items():
        for key, value in keys.items():
            if key in by:
                raise ValueError(f"{who} gives {key!r}, which {by[key]} gives already: rename one of them")
            found[key], by[key] = value, who
    return found
