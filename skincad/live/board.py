"""A scene's history as points on a board, its signals beneath on the same axis of time: positions only."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from skincad.base.arrays import Array
from skincad.inputs.design import Design
from skincad.scenes.scene_tables import History
from skincad.shape.skin import section
from skincad.studies.subject import Setting

CURVES = ("normal_force_N", "tangential_force_N", "displacement_mm", "rotation_deg")
HEAD = 1.3  # times its largest value, that an axis reaches: one may draw beyond what is there
DIGITS = 3  # of a value that is drawn by hand


@dataclass(frozen=True)
class Board:
    """A rectangle behind the skin, upright in the plane y = `y`, mm: history above, signals below."""

    left: float
    right: float
    y: float
    below: tuple[float, float]  # z of the signals' axis, mm
    above: tuple[float, float]  # z of the history's

    def line(self, times: Array, values: Array, ends: tuple[float, float], *, above: bool) -> Array:
        """Return points `(n, 3)` mm for shares of time from 0 to 1 and values on an axis with these ends."""
        low, high = self.above if above else self.below
        shares = (values - ends[0]) / (ends[1] - ends[0])
        x = self.left + times * (self.right - self.left)
        return np.stack([x, np.full_like(x, self.y), low + shares * (high - low)], axis=1)

    def hit(self, eye: Array, target: Array) -> tuple[float, float]:
        """Return the share of time and of the history's axis at which a look from `eye` past `target`, mm,
        meets the board; both may lie outside 0 to 1."""
        along = target - eye
        far = (self.y - eye[1]) / (along[1] or 1e-12)
        x, _, z = eye + far * along
        low, high = self.above
        return float((x - self.left) / (self.right - self.left)), float((z - low) / (high - low))


def board_of(design: Design) -> Board:
    """Return the board behind a design's skin, as wide as it takes to draw on."""
    wide, top = max(design.skin.width, 0.6 * design.skin.length), section(design).top
    levels = [top + share * wide for share in (0.25, 0.85, 1.05, 1.85)]
    return Board(-1.1 * wide, 1.1 * wide, 0.5 * design.skin.length + 0.2 * wide, *pairs(levels))


def pairs(levels: Sequence[float]) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return four numbers as two pairs."""
    a, b, c, d = levels
    return (a, b), (c, d)


def axes(history: History) -> dict[str, tuple[float, float]]:
    """Return the ends of each given curve's axis, by its key; both forces share one."""
    values = {key: curve for key in CURVES if (curve := getattr(history, key)) is not None}
    groups: dict[str, list[float]] = {}
    for key, curve in values.items():
        groups.setdefault(key.rpartition("_")[2], []).extend(curve)
    ends = {}
    for key in values:
        every = groups[key.rpartition("_")[2]]
        low, high = min(0.0, *every), max(0.0, *every)
        if low == high:
            high = 1.0
        ends[key] = (HEAD * low, HEAD * high)
    return ends


def drag_changes(
    history: History, curve: str, place: int, share: tuple[float, float], ends: tuple[float, float]
) -> Mapping[str, Setting]:
    """Return what changes in a scene when a curve's point, from 1 on, is dragged to a share of the board.

    Its time stays between its neighbours'; the last point may not leave the board, nor any its axis.
    """
    times, whole = history.time_s, history.time_s[-1]
    step = whole / 100
    first = times[place - 1] + step
    last = times[place + 1] - step if place + 1 < len(times) else whole
    time = min(max(share[0] * whole, min(first, times[place])), max(last, times[place]))
    value = ends[0] + min(max(share[1], 0.0), 1.0) * (ends[1] - ends[0])
    fine = 10.0 ** (np.floor(np.log10(ends[1] - ends[0])) - DIGITS + 1)
    return {
        f"history.time_s.{place + 1}": float(f"{time:.{DIGITS + 1}g}"),
        f"history.{curve}.{place + 1}": float(f"{round(value / fine) * fine:.6g}"),
    }


def with_point(history: History) -> Mapping[str, Setting]:
    """Return the history's lists with one point more, in the middle of its longest straight line."""
    times = history.time_s
    after = int(np.argmax(np.diff(times))) + 1
    changes: dict[str, Setting] = {"history.time_s": _with(times, after)}
    for key in CURVES:
        if (values := getattr(history, key)) is not None:
            changes[f"history.{key}"] = _with(values, after)
    return changes


def without_point(history: History, place: int) -> Mapping[str, Setting]:
    """Return the history's lists without the point at a place, from 1 on; a history keeps two points."""
    keys = ("time_s", *(key for key in CURVES if getattr(history, key) is not None))
    return {
        f"history.{key}": [value for i, value in enumerate(getattr(history, key)) if i != place]
        for key in keys
    }


def _with(values: Sequence[float], after: int) -> list[float]:
    middle = float(f"{(values[after - 1] + values[after]) / 2:.6g}")
    return [*values[:after], middle, *values[after:]]
