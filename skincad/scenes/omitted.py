"""What a scene leaves out, and about how much that would change: each effect that is not named says so."""

from __future__ import annotations

import numpy as np

from skincad.effects import EFFECTS, effect
from skincad.effects.omitted import Omitted, SceneOutline
from skincad.scenes.march import March
from skincad.scenes.scene import Scene

MATTERS = 0.1  # relative; a larger change is warned of


def omitted(scene: Scene, found: March) -> list[Omitted]:
    """Return the effects that the scene leaves out, the one that matters most first."""
    history = scene.history
    across = history.tangential_force_N or history.displacement_mm or []
    outline = SceneOutline(
        scene.design,
        tuple(history.time_s),
        (tuple(history.normal_force_N), tuple(across)),
        float(found.time[-1]),
        float(np.abs(found.column("travel")).max()),
        float(np.abs(found.column("approach")).max()),
        float(found.loads[:, 0].max()),
    )
    unnamed = [name for name, row in EFFECTS.items() if row.indicates and name not in scene.effects]
    entries = [entry for name in unnamed if (entry := effect(name).left_out(outline))]
    return sorted(entries, key=lambda entry: -entry.change)
