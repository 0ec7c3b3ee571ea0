"""Skins that are curved along y too, for the tests of their molds."""

from __future__ import annotations

import skincad
from skincad.inputs import Design
from tests.small_scene import last_of_each


def bent(name: str, radius: float, *settings: str) -> Design:
    """A template's skin, bent along y to a radius in mm."""
    return skincad.load(name, last_of_each(f"skin.curvature_radius_y={radius}", *settings))


def three_ridges() -> Design:
    """Three ridges with their six shims, 12 mm long; its ends lean by 14 degrees."""
    return bent("yamada-2002", 25.0, "ridge.count=3")
