"""The work-precision diagram of a ladder: error against time, both logarithmic, one line a method.

It is read in grey too: methods differ by marker and by dashes; trials that no other beats are filled.
"""

from __future__ import annotations

import math
from statistics import median
from textwrap import fill
from typing import Any

from skincad.pictures.canvas import Axes, NullFormatter, Picture, sheet
from skincad.studies.accuracy.ladder import ErrorMeasure, Ladder, Measurement, slope

STYLES: tuple[tuple[str, str, Any], ...] = (  # colours of falling lightness, after Okabe and Ito 2008
    ("#000000", "o", "-"),
    ("#0072b2", "s", (0, (6, 2))),
    ("#b3470a", "^", (0, (2, 1.5))),
    ("#007a5a", "D", (0, (7, 2, 1.5, 2))),
    ("#8f4c86", "v", (0, (1, 1.5))),
    ("#6f6000", "P", (0, (10, 3))),
    ("#4c7ea6", "X", (0, (4, 1.5, 1, 1.5, 1, 1.5))),
)
FRONT, FLOOR = "#c9c9c9", "#ededed"
PANELS = 2  # measures that are drawn: the first with two errors to show
SIZE, DPI = (9.0, 4.9), 100  # 900 pixels wide, as the README shows it
# trials above the reference's own error, and the ratio of the longest of their times to the shortest
LEAST_FOR_SLOPE, SPREAD_FOR_SLOPE = 3, 2.0
MIN_AXIS_RATIO = 12.0  # an axis has at least this ratio between its ends
HEADROOM = 0.3  # of the errors' decades
TITLE_LETTERS, LABEL_LETTERS = 56, 52  # letters of a line: a title's, an error axis's


def diagram(ladder: Ladder, machine: dict[str, Any]) -> Picture:
    """Return a figure of the ladder's first measures; without anything to draw, one that says so."""
    measures = [m for m in ladder.measures if len({r.errors[m.name] for r in _drawable(ladder, m)}) > 1][
        :PANELS
    ]
    with sheet(SIZE, DPI, 255) as figure:
        figure.suptitle(ladder.title)
        places = figure.subplots(1, max(1, len(measures)), squeeze=False)[0]
        models = list(dict.fromkeys(point.model for point in ladder.trials))
        style = {model: STYLES[i % len(STYLES)] for i, model in enumerate(models)}
        for axes, measure in zip(places, measures, strict=False):
            _panel(axes, ladder, measure, style)
        if not measures:
            places[0].text(0.5, 0.5, "no trial can be judged on this design", ha="center")
            places[0].set_axis_off()
        filled = "; filled: none is both faster and more exact" if ladder.lines and measures else ""
        where = f"{machine['processor']}, {machine['cores']} cores; medians"
        words = f"{where}, bars from the shortest to the longest run{filled}"
        figure.supxlabel(words, fontsize=8, color="#555555")
    return figure


def _drawable(ladder: Ladder, measure: ErrorMeasure) -> list[Measurement]:
    return [point for point in ladder.trials if point.errors.get(measure.name, 0.0) > 0]


def _panel(axes: Axes, ladder: Ladder, measure: ErrorMeasure, style: dict[str, tuple[str, str, Any]]) -> None:
    trials = _drawable(ladder, measure)
    axes.set_xscale("log")
    axes.set_yscale("log")
    best = [point for point in ladder.best(measure) if point in trials]
    if measure.compares and best:
        x, y = [r.seconds for r in best], [r.errors[measure.name] for r in best]
        band: dict[str, Any] = {"color": FRONT, "linewidth": 5.0, "zorder": 0.5}
        axes.plot(x, y, drawstyle="steps-post", label="Pareto front", **band)
    for model, (colour, marker, dashes) in style.items():
        model_points = [point for point in trials if point.model == model]
        if not model_points:
            continue
        if ladder.lines:
            path = sorted((r.seconds, r.errors[measure.name]) for r in model_points)
            axes.plot(*zip(*path, strict=True), color=colour, linestyle=dashes, linewidth=1.3)
        for point in model_points:
            error = point.errors[measure.name]
            runs = point.instead or point.runs
            axes.hlines(error, min(runs), max(runs), color=colour, linewidth=0.8)
            look: dict[str, Any] = {"marker": marker, "color": colour, "markersize": 6, "linestyle": ""}
            filled = point in best or not ladder.lines
            axes.plot(median(runs), error, markerfacecolor=colour if filled else "white", **look)
        label = model + (_slope(model_points, measure) if ladder.lines else "")
        axes.plot([], [], color=colour, marker=marker, linestyle=dashes if ladder.lines else "", label=label)
    _words(axes, measure, "time, s" if ladder.lines else "time of the scene with the effect, s")


def _slope(trials: list[Measurement], measure: ErrorMeasure) -> str:
    """The exponent of error against time in words, of the trials above the reference's own error."""
    points = [point for point in trials if point.errors[measure.name] > measure.floor]
    exponent = slope([r.seconds for r in points], [r.errors[measure.name] for r in points])
    times = [r.seconds for r in points]
    if exponent is None or len(points) < LEAST_FOR_SLOPE or max(times) < SPREAD_FOR_SLOPE * min(times):
        return ""
    return f", slope {round(exponent, 1) + 0.0:g}"


def _words(axes: Axes, measure: ErrorMeasure, time: str) -> None:
    if measure.floor:
        low, high = axes.get_ylim()
        low = min(low, measure.floor / 3)
        axes.axhspan(low, measure.floor, color=FLOOR, zorder=0, label="reference's own error")
        axes.set_ylim(low, high)
    for ends, set_ends in ((axes.get_xlim(), axes.set_xlim), (axes.get_ylim(), axes.set_ylim)):
        if ends[1] < MIN_AXIS_RATIO * ends[0]:  # no power of ten may lie within: room for one
            middle = math.sqrt(ends[0] * ends[1])
            set_ends(middle / math.sqrt(MIN_AXIS_RATIO), middle * math.sqrt(MIN_AXIS_RATIO))
    low, high = axes.get_ylim()
    axes.set_ylim(low, high * (high / low) ** HEADROOM)  # for the legend
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.set_xlabel(time)
    unit = ", relative" if measure.unit == "1" else f", {measure.unit}"
    axes.set_ylabel(fill(measure.what.removesuffix(", relative") + unit, LABEL_LETTERS))
    against = measure.reference.partition(":")[0].partition(",")[0]
    axes.set_title(fill(f"against {against}", TITLE_LETTERS), fontsize=9)
    axes.legend(fontsize=7.5, loc="best", framealpha=0.9)
