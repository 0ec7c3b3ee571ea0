"""The plots of a scene, its history and its newest signals, and of films' channels; as keywords of uPlot."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from skincad.base.arrays import Array
from skincad.live.worker import Signals
from skincad.scenes.scene import History
from skincad.studies.subject import Setting

CURVES = ("normal_force_N", "tangential_force_N", "displacement_mm", "rotation_deg")
COLOURS = ("#1f5fa8", "#c1531f", "#6e3c96", "#1b6e3c")
OLDER = "#bec0c6"


def history_plot(history: History) -> dict[str, Any]:
    """Return the plot of a history's given curves, with its points."""
    time, *curves = lists(history).items()
    named = {", ".join(key.rpartition("_")[::2]).replace("_", " "): np.array(row) for key, row in curves}
    return _plot(np.array(time[1]), named, COLOURS, points=True)


def signals_plot(signals: Signals, *, fresh: bool) -> dict[str, Any]:
    """Return the plot of the differential stress of each monitored ridge, grey if the scene moved on."""
    curves = {f"ridge {ridge}, MPa": stress for ridge, stress in signals.stress.items()}
    return _plot(signals.time, curves, COLOURS if fresh else (OLDER,), points=False)


def channels_plot(time: Array, s1: Array, s2: Array) -> dict[str, Any]:
    """Return the plot of a ridge's two strips, V."""
    return _plot(time, {"S1, V": s1, "S2, V": s2}, COLOURS, points=False)


def _plot(time: Array, curves: dict[str, Array], colours: Sequence[str], *, points: bool) -> dict[str, Any]:
    """Curves over time, each on the axis of its unit."""
    units = list(dict.fromkeys(label.rpartition(", ")[2] for label in curves))
    series: list[dict[str, Any]] = [{"label": "time, s"}]
    for number, label in enumerate(curves):
        stroke, unit = colours[number % len(colours)], label.rpartition(", ")[2]
        series.append(
            {"label": label, "stroke": stroke, "scale": unit, "width": 2, "points": {"show": points}}
        )
    axes = [{"label": unit, "scale": unit, "side": 3 - 2 * (place % 2)} for place, unit in enumerate(units)]
    return {
        "data": (time, *curves.values()),
        "series": tuple(series),
        "scales": {"x": {"time": False}},
        "axes": ({"label": "time, s"}, *axes),
    }


def with_point(history: History) -> Mapping[str, Setting]:
    """Return the history's lists with one point more, in the middle of its longest straight line."""
    after = int(np.argmax(np.diff(history.time_s))) + 1

    def longer(values: Sequence[float]) -> list[float]:
        middle = float(f"{(values[after - 1] + values[after]) / 2:.6g}")
        return [*values[:after], middle, *values[after:]]

    return {f"history.{key}": longer(values) for key, values in lists(history).items()}


def without_point(history: History) -> Mapping[str, Setting]:
    """Return the history's lists without their last point; a history keeps two."""
    rows = lists(history)
    return {f"history.{key}": values[:-1] for key, values in rows.items() if len(values) > 2}


def lists(history: History) -> dict[str, list[float]]:
    """Return the times and the given curves, by key."""
    return {key: list(values) for key in ("time_s", *CURVES) if (values := getattr(history, key)) is not None}
