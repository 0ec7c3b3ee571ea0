"""What a scene leaves out, and about how much that would change: each effect that is not named says so."""

from __future__ import annotations

import numpy as np

from skincad.base.arrays import Array
from skincad.effects import EFFECTS, effect
from skincad.effects.kinds import Step
from skincad.effects.omitted import LeftOutEffect, PlatePath, SceneOutline
from skincad.mechanics.contact.state import Drive
from skincad.scenes.march import March
from skincad.scenes.scene import Scene

MATTERS = 0.1  # relative; a larger change is warned of


def omitted(scene: Scene, march: March) -> list[LeftOutEffect]:
    """Return the effects that the scene leaves out, the one that matters most first."""
    history = scene.history
    driven = history.tangential_force_N is None
    pull = (history.displacement_mm if driven else history.tangential_force_N) or []
    loads = (tuple(history.normal_force_N), tuple(pull))
    times, path = tuple(history.time_s), path_of(march)
    outline = SceneOutline(scene.design, times, loads, path, driven, _friction(scene))
    unnamed = [name for name, row in EFFECTS.items() if row.indicates and name not in scene.effects]
    entries = [entry for name in unnamed if (entry := effect(name).left_out(outline))]
    return sorted(entries, key=lambda entry: -entry.change)


def path_of(march: March) -> PlatePath:
    """Return what a march found, as indicators see it."""
    normal_loads, pulled, _ = np.moveaxis(march.loads, 1, 0)
    films = march.column("films")[:, :, 0]
    return PlatePath(
        march.time,
        march.column("approach"),
        march.column("travel"),
        normal_loads,
        pulled,
        _slipping(march, normal_loads.shape[1]),
        films[:, ::2] - films[:, 1::2],
    )


def _friction(scene: Scene) -> float:
    """The coefficient of static friction, at small pressures where it hangs on pressure; 0 without any."""
    still = Drive(0.0)
    cones = (term.share(Step(0.0, 1.0, still, still)).cone for term in scene.terms)
    return next((cone.static for cone in cones if cone), 0.0)


def _slipping(march: March, ridges: int) -> Array:
    """The share of each ridge's touching points that slips `(steps + 1, ridges)`."""
    of = (march.ridge[:, None] == np.arange(1, ridges + 1)).astype(float)
    touches, slips = (march.column(name).astype(float) @ of for name in ("touches", "slips"))
    return np.asarray(slips / np.maximum(touches, 1.0))
