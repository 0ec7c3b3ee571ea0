"""The steps of a march whose state is kept, to be drawn."""

from __future__ import annotations

import numpy as np

from skincad.scenes.scene import Scene


def kept_steps(scene: Scene) -> frozenset[int]:
    """Return the steps whose state is kept: named ones, and an animation's."""
    return frozenset({*scene.readout.steps, *frames(scene)})


def frames(scene: Scene) -> list[int]:
    """Return the steps of an animation, evenly over the history's time."""
    even = scene.history.even
    count = min(scene.readout.frames, even.size)
    places = np.unique(np.linspace(0, even.size - 1, count).round().astype(int))
    return list(map(int, even[places]))
