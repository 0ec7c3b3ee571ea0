"""The calibration plot: stated error against true error of random designs, read in grey too."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from bench.error_bars import Row

PANELS = {
    "mesh of the linear model": lambda row: row.part == "mesh",
    "model: free ends, finite strain": lambda row: row.part in ("ends", "strain", "method"),
    "model: winkler": lambda row: row.part == "model",
}
MARKS = {
    "all_touch_force": ("#0072b2", "o", "all-touch force"),
    "approach": ("#b3470a", "^", "approach"),
    "shares": ("#3a7d44", "s", "shares"),
}
LEAST = 1e-7  # of the value; smaller errors are drawn there
MOST = 3.0


def calibration_plot(rows: list[Row], path: Path) -> None:
    """Write a PNG of stated against true relative error; below the line a bar is too narrow."""
    figure = Figure(figsize=(12.0, 4.4), dpi=100, layout="constrained")
    FigureCanvasAgg(figure)
    for axes, (title, belongs) in zip(figure.subplots(1, len(PANELS)), PANELS.items(), strict=True):
        _panel(axes, title, [row for row in rows if belongs(row) and row.value])
    drawn = BytesIO()
    figure.savefig(drawn, metadata={"Software": "skincad"})
    colours = Image.open(drawn).convert("RGB").quantize(64, dither=Image.Dither.NONE)
    colours.save(path, format="PNG", optimize=True)


def _panel(axes: Axes, title: str, rows: list[Row]) -> None:
    for quantity, (colour, marker, label) in MARKS.items():
        for top in (False, True):
            mine = [row for row in rows if row.quantity == quantity and row.top is top]
            true = [max(row.true / abs(row.value), LEAST) for row in mine]
            stated = [max(row.stated / abs(row.value), LEAST) for row in mine]
            told = f"{label}, {'top refinement' if top else 'refinement above'}"
            fill = colour if top else "none"
            axes.plot(
                true,
                stated,
                marker,
                color=colour,
                markerfacecolor=fill,
                markersize=4.5,
                alpha=0.75,
                label=told,
            )
    ends = np.array([LEAST, MOST])
    axes.plot(ends, ends, color="#222222", linewidth=1.2)
    axes.plot(ends, 10 * ends, color="#777777", linewidth=0.9, linestyle="--")
    axes.set(xscale="log", yscale="log", xlim=(LEAST / 1.5, MOST), ylim=(LEAST / 1.5, MOST))
    axes.set_xlabel("true error, relative")
    axes.set_ylabel("stated error, relative")
    axes.grid(color="#e4e4e4", linewidth=0.6)
    axes.legend(fontsize=7, loc="upper left")
    if rows:
        held, width = np.mean([r.held for r in rows]), np.median([r.width for r in rows])
        title += f"\n{len(rows)} cases, {held:.1%} held, median {width:.1f} times too wide"
    axes.set_title(title, fontsize=9)
    axes.text(MOST / 2, 3 * LEAST, "below the line: too narrow", fontsize=7, ha="right", color="#222222")
