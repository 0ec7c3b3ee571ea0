"""The steps of a march whose state is kept: those to draw, and the extreme ones, to look for collisions."""

from __future__ import annotations

import numpy as np

from skincad.effects.kinds import Showing
from skincad.march import March
from skincad.scene import Scene


def kept_steps(scene: Scene) -> frozenset[int]:
    """Return the steps whose state is kept: named ones, an animation's, the hardest pressed and pulled."""
    return frozenset({*scene.readout.steps, *frames(scene), *_extremes(scene)})


def frames(scene: Scene) -> list[int]:
    """Return the steps of an animation, evenly over the history."""
    count = min(scene.readout.frames, scene.history.steps + 1)
    return np.unique(np.linspace(0, scene.history.steps, count).round().astype(int)).tolist() if count else []


def _extremes(scene: Scene) -> set[int]:
    drives = scene.history.drives()
    pressed = int(np.argmax([drive.normal for drive in drives]))
    pulled = int(np.argmax([abs(drive.tangential or drive.travel or 0.0) for drive in drives]))
    turned = [int(np.argmax([sign * drive.angle for drive in drives])) for sign in (1, -1)]
    return {pressed, pulled, *turned}


def collisions(found: March) -> list[str]:
    """Return a warning where the skin goes through itself or the plate unseen, by the first kept step."""
    if not isinstance(found.model, Showing):
        return []
    for step, state in sorted(found.states.items()):
        wrong = found.model.fault(state)
        if wrong:
            return [f"at step {step} {wrong}: no model of contact there, what follows is off"]
    return []
