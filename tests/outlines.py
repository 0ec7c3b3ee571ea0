"""Outlines of scenes as indicators see them, without a march."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from skincad.effects import PlatePath, SceneOutline
from skincad.inputs import Design

DOWN, ALONG = 10.0, 4.0  # N/mm, of the pad


def outline(
    design: Design,
    time: tuple[float, ...],
    normal: tuple[float, ...],
    pull: tuple[float, ...],
    steps: int = 200,
    **changes: Any,
) -> SceneOutline:
    """A pad of linear springs whose ridges share forces evenly, with S1 - S2 of 2 MPa per N of their pull."""
    at = np.linspace(0.0, time[-1], steps + 1)
    down, along = np.interp(at, time, normal), np.interp(at, time, pull)
    pressed, pulled = (np.tile(of[:, None] / design.ridge.count, design.ridge.count) for of in (down, along))
    none = np.zeros_like(pressed)
    path = PlatePath(at, down / DOWN, along / ALONG, pressed, pulled, none, 2 * pulled, none)
    scene_outline = SceneOutline(design, time, (normal, pull), path, friction=1.0)
    return replace(scene_outline, **changes)
