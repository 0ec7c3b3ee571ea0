"""The deformed section of the plane model: its moved boundary and the pressure on it."""

from __future__ import annotations

import numpy as np

from skincad.base.arrays import Array
from skincad.mechanics.bodies.elements import Outline
from skincad.mechanics.problem import DeformedLoop, DeformedPiece
from skincad.mechanics.tiers.plane_level import PlaneSolution


def deformed_section(solution: PlaneSolution) -> tuple[DeformedPiece, ...]:
    """Return the whole section in pieces: one, or the half that was meshed and its image at x = 0.

    Every loop has the silicone to its left. Between contact points the pressure is taken as straight.
    """
    order = np.argsort(solution.x)
    x, pressure = solution.x[order], solution.pressure[order]
    loops = [_loop(outline, solution.unit, x, pressure) for outline in solution.outlines]
    if not loops:
        return ()
    outer = max(loops, key=lambda loop: abs(_area(loop)))
    piece = tuple(loop if (_area(loop) > 0) == (loop is outer) else _reversed(loop) for loop in loops)
    return (piece,) if solution.half is None else (piece, tuple(map(_image, piece)))


def _loop(outline: Outline, unit: float, x: Array, pressure: Array) -> DeformedLoop:
    rest = outline.rest * unit
    touches = outline.touches | np.roll(outline.touches, 1)  # an edge's last point is the next one's first
    there = np.where(touches, np.interp(rest[:, 0], x, pressure), 0.0)
    return DeformedLoop(rest, outline.moved * unit, np.maximum(there, 0.0))


def _area(loop: DeformedLoop) -> float:
    """The area within a loop at rest, mm2; negative where it runs clockwise."""
    x, z = loop.rest.T
    return float(x @ np.roll(z, -1) - z @ np.roll(x, -1)) / 2


def _reversed(loop: DeformedLoop) -> DeformedLoop:
    return DeformedLoop(loop.rest[::-1], loop.moved[::-1], loop.pressure[::-1])


def _image(loop: DeformedLoop) -> DeformedLoop:
    """The loop mirrored at x = 0, still with the silicone to its left."""
    rest, moved = (points * [-1.0, 1.0] for points in (loop.rest, loop.moved))
    return _reversed(DeformedLoop(rest, moved, loop.pressure))
