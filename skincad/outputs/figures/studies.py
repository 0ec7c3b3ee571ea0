"""Figures of studies: a result against what is varied, and the ladders' error against time, both logarithmic.

The ladders are read in grey too: methods differ by marker and by dashes; trials that no other beats are
filled.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from statistics import median
from textwrap import fill
from typing import Any

import numpy as np

from skincad.base.arrays import Array
from skincad.outputs.figures.canvas import (
    BLACK,
    BLUE,
    FLOOR,
    FRAME,
    FRONT,
    GREY,
    LABEL,
    MAP,
    NOTE,
    SMALL,
    STYLES,
    THIN,
    VERMILION,
    Axes,
    Normalize,
    NullFormatter,
    Picture,
    ScalarMappable,
    Triangulation,
    chart,
    sheet,
)
from skincad.studies.accuracy.accuracy import Accuracy
from skincad.studies.accuracy.ladder import ErrorMeasure, Ladder, Measurement, slope
from skincad.studies.query import Evaluation
from skincad.studies.solving import Solution
from skincad.studies.subject import DesignVariable
from skincad.studies.sweeping import Ranking, SweepResult

Pair = tuple[DesignVariable, DesignVariable]
POINT, TARGET, HIGHLIGHT = BLUE, GREY, VERMILION
SIZE = (7.0, 4.6)  # inches
PANEL = 3.0  # inches, of one of several
MAX_KEYS = 6  # that are drawn
LOG_RATIO = 100.0  # the ratio of a result's ends from which on its axis is logarithmic
MAX_LOG_RATIO = 1e6  # beyond it the smallest is rounding
PANELS = 2  # measures that are drawn: the first with two errors to show
LADDER_SIZE = (9.0, 4.9)  # inches, of a ladder's row
# trials above the reference's own error, and the ratio of the longest of their times to the shortest
LEAST_FOR_SLOPE, SPREAD_FOR_SLOPE = 3, 2.0
MIN_AXIS_RATIO = 12.0  # an axis has at least this ratio between its ends
HEADROOM = 0.3  # of the errors' decades
TITLE_LETTERS, LABEL_LETTERS = 56, 52  # letters of a line: a title's, an error axis's


def solution_figure(solution: Solution) -> Picture:
    """Return a figure of the wanted result at each value that was tried, with its error as a band, the
    design's own value and the solutions; crosses at the foot are refused values."""
    (key, wanted), (knob,) = next(iter(solution.target.items())), solution.knobs
    points = sorted(
        (float(evaluation.values[knob.key]), estimate.value, estimate.error or 0.0)
        for evaluation in solution.evaluations
        if not evaluation.refused and (estimate := evaluation.results[key]).value is not None
    )
    name, _, unit = (label := _axis_label(key, solution.evaluations)).partition(", ")
    title = f"{solution.name}: {name} against {knob.key}"
    with chart(SIZE, title, 6, xlabel=_label(knob), ylabel=label) as (figure, axes):
        side = {"<=": "at most ", ">=": "at least "}.get((solution.bounds or {}).get(key, ""), "")
        words = f"wanted: {side}{wanted:g}" + f" {unit}" * (unit != "1")
        axes.axhline(wanted, color=TARGET, linestyle="--", label=words)
        if points:
            at, value, error = np.array(points).T
            band: dict[str, Any] = {"color": POINT, "alpha": 0.18, "linewidth": 0}
            axes.fill_between(at, value - error, value + error, label="error", **band)
            axes.plot(at, value, "o-", color=POINT, markersize=5, label="evaluated")
        if refused := [float(e.values[knob.key]) for e in solution.evaluations if e.refused]:
            foot: dict[str, Any] = {"transform": axes.get_xaxis_transform(), "clip_on": False}
            axes.plot(refused, np.full(len(refused), 0.02), "x", color=GREY, label="refused", **foot)
        for number, solved in enumerate(solution.solutions):
            place = float(solved.values[knob.key]), float(solved.reached[key])
            label = "" if number else "solution"
            axes.plot(*place, "D", color=HIGHLIGHT, markersize=9, markeredgecolor="white", label=label)
            words = f"{place[0]:.4g} {knob.unit or ''}".rstrip()
            axes.annotate(words, place, (9, 9), textcoords="offset points", fontsize=LABEL)
        if isinstance(knob.start, int | float):
            axes.axvline(knob.start, color=GREY, linewidth=THIN, linestyle=":", label="in the design")
        if knob.by_ratio:
            axes.set_xscale("log")
            axes.xaxis.set_major_formatter("{x:g}")
            axes.xaxis.set_minor_formatter("{x:g}")
        if points and 0 < LOG_RATIO / 10 * min(value) < max(value) < MAX_LOG_RATIO * min(value):
            axes.set_yscale("log")
            axes.yaxis.set_major_formatter("{x:g}")
    return figure


def effects_figure(sweep: SweepResult) -> Picture:
    """Return a figure of the first ranking's result against each key: all rows, and means."""
    ranking, keys = sweep.rankings[0], sweep.knobs[:MAX_KEYS]
    rows, results = _ranked(sweep, ranking)
    column_count = min(3, len(keys))
    row_count = -(-len(keys) // column_count)
    with sheet((max(PANEL * column_count, 4.0), PANEL * row_count), 255) as figure:
        places = figure.subplots(row_count, column_count, squeeze=False, sharey=True).ravel()
        for axes, knob in itertools.zip_longest(places, keys):
            if knob is None:
                axes.set_axis_off()
                continue
            at = _places(sweep, knob, rows)
            axes.plot(at, results, ".", color=POINT, alpha=0.5, markersize=5)
            for value in _levels(at):
                axes.plot(value, np.mean(results[at == value]), "_", color=HIGHLIGHT, markersize=16, mew=2)
            _name_ticks(axes, knob)
            axes.set_xlabel(_label(knob))
            if np.all(results > 0) and results.max() > LOG_RATIO * results.min():
                axes.set_yscale("log")
        for axes in places[::column_count]:
            axes.set_ylabel(_axis_label(ranking.key, sweep.rows))
        bars = "; bars: means" if any(len(_levels(_places(sweep, k, rows))) for k in keys) else ""
        figure.suptitle(f"{sweep.name}: {ranking.key} of {len(rows)} rows{bars}")
    return figure


def pairs_figure(sweep: SweepResult) -> Picture:
    """Return a figure of all pairs of keys, each row a point whose colour is the first ranking's result.

    Of two keys with numbers it is a filled map: linear within each triangle of neighbouring rows, and
    nothing where one of them is refused. Refused rows are crosses, a star is the design itself.
    """
    ranking, keys = sweep.rankings[0], sweep.knobs[:MAX_KEYS]
    results = _ranked(sweep, ranking)[1]
    pairs = list(itertools.combinations(keys, 2))
    columns = min(3, len(pairs))
    row_count = -(-len(pairs) // columns)
    colours = Normalize(float(results.min()), float(results.max()))
    size = SIZE if len(pairs) == 1 else (PANEL * columns + 1.0, PANEL * row_count)
    with sheet(size, 255) as figure:
        places = figure.subplots(row_count, columns, squeeze=False).ravel()
        for axes, pair in itertools.zip_longest(places, pairs):
            if pair is None:
                axes.set_axis_off()
                continue
            filled = len(keys) == 2 and _draw_map(axes, sweep, ranking, colours)
            _draw_rows(axes, sweep, ranking, pair, colours)
            for knob, side in zip(pair, "xy", strict=True):
                _name_ticks(axes, knob, side)
            axes.set(xlabel=_label(pair[0]), ylabel=_label(pair[1]))
        bar = ScalarMappable(colours, MAP)
        figure.colorbar(bar, ax=list(places), label=_axis_label(ranking.key, sweep.rows))
        handles = [mark for mark in places[0].get_legend_handles_labels()[0] if mark.get_label()[0] != "_"]
        figure.legend(handles=handles, loc="outside lower left", ncols=3, frameon=False)
        between = ", linear between evaluated points" if filled else ""
        figure.suptitle(f"{sweep.name}: {ranking.key}{between}")
    return figure


def _draw_map(axes: Axes, sweep: SweepResult, ranking: Ranking, colours: Normalize) -> bool:
    """Fill the triangles between evaluated rows of two keys; return whether there are any."""
    if any(isinstance(choice, str) for knob in sweep.knobs for choice in knob.choices):
        return False
    rows, results = _ranked(sweep, ranking)
    places = np.column_stack([_places(sweep, knob, range(len(sweep.rows))) for knob in sweep.knobs])
    scaled = (places - places.min(axis=0)) / np.maximum(np.ptp(places, axis=0), 1e-300)
    _, first = np.unique(scaled.round(9), axis=0, return_index=True)
    if len(first) < 3 or np.linalg.matrix_rank(scaled[first] - scaled[first[0]], tol=1e-6) < 2:
        return False
    values = np.full(len(places), np.nan)
    values[rows] = results
    triangles = first[Triangulation(scaled[first, 0], scaled[first, 1]).triangles]
    known = triangles[np.isfinite(values[triangles]).all(axis=1)]
    if not len(known):
        return False
    mesh = Triangulation(places[:, 0], places[:, 1], known)
    axes.tripcolor(mesh, np.nan_to_num(values), cmap=MAP, norm=colours, shading="gouraud", zorder=0.5)
    return True


def _draw_rows(axes: Axes, sweep: SweepResult, ranking: Ranking, pair: Pair, colours: Normalize) -> None:
    """The rows as points, the best on top, the refused ones as crosses, and the design's own place."""
    rows, results = _ranked(sweep, ranking)
    others = sorted(set(range(len(sweep.rows))) - set(rows))
    if others:
        x, y = (_places(sweep, knob, others) for knob in pair)
        axes.scatter(x, y, marker="x", s=20, color=GREY, linewidths=1.0, label="refused, or without it")
    x, y = (_places(sweep, knob, rows) for knob in pair)
    order = np.argsort(results if ranking.goal == "max" else -results)
    look: dict[str, Any] = {"edgecolors": BLACK, "linewidths": 0.5, "s": 24, "label": "evaluated"}
    axes.scatter(x[order], y[order], c=results[order], cmap=MAP, norm=colours, **look)
    across, up = map(_own_place, pair)
    if across is not None and up is not None:
        look = {"markersize": 15, "markeredgecolor": "white", "linestyle": "", "zorder": 4}
        axes.plot(across, up, marker="*", color=HIGHLIGHT, label="the design itself", **look)


def _own_place(knob: DesignVariable) -> float | None:
    """A key's value in the design, a choice by its number; None where it has none or is not a choice."""
    if knob.choices:
        return float(knob.choices.index(knob.start)) if knob.start in knob.choices else None
    return float(knob.start) if isinstance(knob.start, int | float) else None


def front_figure(sweep: SweepResult) -> Picture:
    """Return a figure of the first two rankings' results; no row beats one of the front in both."""
    first, second = sweep.rankings[:2]
    rows = [row for row in _ranked(sweep, first)[0] if row in set(_ranked(sweep, second)[0])]
    x, y = (_results(sweep, ranking, rows) for ranking in (first, second))
    front = pareto(np.column_stack([_less(x, first), _less(y, second)]))
    order = np.argsort(x[front])
    labels = [f"{_axis_label(ranking.key, sweep.rows)} ({ranking.goal})" for ranking in (first, second)]
    title = f"{sweep.name}: {first.key} and {second.key}"
    with chart(SIZE, title, xlabel=labels[0], ylabel=labels[1]) as (figure, axes):
        axes.plot(x, y, ".", color=POINT, alpha=0.5, label="rows")
        axes.plot(x[front][order], y[front][order], "o-", color=HIGHLIGHT, markersize=5, label="front")
        for place, i in enumerate(np.flatnonzero(front)[order]):
            look: dict[str, Any] = {"fontsize": NOTE, "ha": "center", "va": "center"}
            side = (0, 9) if place % 2 else (0, -9)  # neighbours' numbers above and below in turn
            axes.annotate(str(rows[i] + 1), (x[i], y[i]), side, textcoords="offset points", **look)
    return figure


def pareto(points: Array) -> Array:
    """Return which of points `(n, m)`, smaller is better, no other one beats: `(n,)` bool."""
    undominated = np.ones(len(points), dtype=bool)
    for i, point in enumerate(points):
        undominated[i] = not np.any(np.all(points <= point, axis=1) & np.any(points < point, axis=1))
    return undominated


def _less(values: Array, ranking: Ranking) -> Array:
    return values if ranking.goal == "min" else -values


def _ranked(sweep: SweepResult, ranking: Ranking) -> tuple[list[int], Array]:
    """Rows with the ranking's result, by index, and their results."""
    rows = sorted(rank.row - 1 for rank in ranking.ranks)
    return rows, _results(sweep, ranking, rows)


def _results(sweep: SweepResult, ranking: Ranking, rows: Sequence[int]) -> Array:
    return np.array([float(sweep.rows[i].results[ranking.key]) for i in rows])


def _places(sweep: SweepResult, knob: DesignVariable, rows: Sequence[int]) -> Array:
    """A key's values of some rows, choices by their number."""
    values = [sweep.rows[i].values[knob.key] for i in rows]
    if knob.choices:
        values = [knob.choices.index(value) for value in values]
    return np.array(values, dtype=float)


def _levels(at: Array) -> Array:
    """The values that several rows share: of a grid, not of a sample, of which few meet by chance."""
    values, counts = np.unique(at, return_counts=True)
    return values[(counts > 1) & (2 * len(values) <= len(at))]


def _name_ticks(axes: Axes, knob: DesignVariable, side: str = "x") -> None:
    axis = axes.xaxis if side == "x" else axes.yaxis
    if any(isinstance(choice, str) for choice in knob.choices):
        axis.set_ticks(range(len(knob.choices)), [str(choice) for choice in knob.choices], fontsize=NOTE)
        if side == "x":
            for label in axis.get_ticklabels():
                label.set(rotation=60, horizontalalignment="right")


def _axis_label(key: str, rows: Sequence[Evaluation]) -> str:
    """A result's key with its unit, which stands behind a comma, whether or not it ends the key."""
    unit = next((row.results[key].unit for row in rows if key in row.results), "1")
    return f"{key.removesuffix(f'_{unit}')}, {unit}"


def _label(knob: DesignVariable) -> str:
    """A key with its unit, 1 for a pure number; a key of names has none."""
    named = any(isinstance(choice, str) for choice in knob.choices)
    return knob.key if named else f"{knob.key}, {knob.unit or 1}"


def accuracy_figure(accuracy: Accuracy) -> Picture:
    """Return a figure of the first measures of each ladder, a row each."""
    width, height = LADDER_SIZE
    with sheet((width, height * len(accuracy.ladders)), 255) as figure:
        for part, ladder in zip(
            figure.subfigures(len(accuracy.ladders), 1, squeeze=False)[:, 0], accuracy.ladders, strict=True
        ):
            _draw_ladder(part, ladder, f"{accuracy.machine['processor']}, {accuracy.machine['cores']} cores")
    return figure


def _draw_ladder(figure: Any, ladder: Ladder, where: str) -> None:
    """A ladder's first measures; without anything to draw, words that say so."""
    measures = [m for m in ladder.measures if len({r.errors[m.name] for r in _drawable(ladder, m)}) > 1]
    measures = measures[:PANELS]
    figure.suptitle(ladder.title)
    places = figure.subplots(1, max(1, len(measures)), squeeze=False)[0]
    models = list(dict.fromkeys(point.model for point in ladder.trials))
    style = {model: STYLES[i % len(STYLES)] for i, model in enumerate(models)}
    for axes, measure in zip(places, measures, strict=False):
        _ladder_panel(axes, ladder, measure, style)
    if not measures:
        places[0].text(0.5, 0.5, "no trial can be judged on this design", ha="center")
        places[0].set_axis_off()
    filled = "; filled: none is both faster and more exact" if ladder.lines and measures else ""
    words = f"{where}; medians, bars from the shortest to the longest run{filled}"
    figure.supxlabel(words, fontsize=SMALL, color=FRAME)


def _drawable(ladder: Ladder, measure: ErrorMeasure) -> list[Measurement]:
    return [point for point in ladder.trials if point.errors.get(measure.name, 0.0) > 0]


def _ladder_panel(
    axes: Axes, ladder: Ladder, measure: ErrorMeasure, style: dict[str, tuple[str, str, Any]]
) -> None:
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
        label = model + (_ladder_slope(model_points, measure) if ladder.lines else "")
        axes.plot([], [], color=colour, marker=marker, linestyle=dashes if ladder.lines else "", label=label)
    _ladder_words(axes, measure, "time, s" if ladder.lines else "time of the scene with the effect, s")


def _ladder_slope(trials: list[Measurement], measure: ErrorMeasure) -> str:
    """The exponent of error against time in words, of the trials above the reference's own error."""
    points = [point for point in trials if point.errors[measure.name] > measure.floor]
    exponent = slope([r.seconds for r in points], [r.errors[measure.name] for r in points])
    times = [r.seconds for r in points]
    if exponent is None or len(points) < LEAST_FOR_SLOPE or max(times) < SPREAD_FOR_SLOPE * min(times):
        return ""
    return f", slope {round(exponent, 1) + 0.0:g}"


def _ladder_words(axes: Axes, measure: ErrorMeasure, time: str) -> None:
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
    axes.set_title(fill(f"against {against}", TITLE_LETTERS), fontsize=LABEL)
    axes.legend(fontsize=NOTE, loc="best", framealpha=0.9)
