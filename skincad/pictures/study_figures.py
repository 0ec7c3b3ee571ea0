"""Pictures of studies: a result against the varied keys, alone and in pairs, and against another result."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from skincad.base.arrays import Array
from skincad.pictures.canvas import (
    BLUE,
    GREY,
    PALE,
    VERMILION,
    Axes,
    Normalize,
    Picture,
    ScalarMappable,
    legend,
    sheet,
)
from skincad.studies.query import Evaluation
from skincad.studies.solving import Solution
from skincad.studies.subject import DesignVariable
from skincad.studies.sweeping import Ranking, SweepResult

POINT, TARGET, HIGHLIGHT, REFUSED = BLUE, GREY, VERMILION, PALE
COLOURS = "viridis_r"  # distinct in grey too
SIZE, DPI = (7.0, 4.6), 100
PANEL = 3.0  # inches, of one of several
MAX_KEYS = 6  # that are drawn
LOG_RATIO = 100.0  # the ratio of a result's ends from which on its axis is logarithmic
MAX_LOG_RATIO = 1e6  # beyond it the smallest is rounding


def solution_figure(solution: Solution) -> Picture:
    """Return a figure of the wanted result at each value that was tried, with its error."""
    (key, wanted), (knob,) = next(iter(solution.target.items())), solution.knobs
    points = sorted(
        (float(evaluation.values[knob.key]), estimate.value, estimate.error or 0.0)
        for evaluation in solution.evaluations
        if not evaluation.refused and (estimate := evaluation.results[key]).value is not None
    )
    with sheet(SIZE, DPI, 255) as figure:
        axes = figure.add_subplot()
        axes.axhline(wanted, color=TARGET, linewidth=1.0, linestyle="--", label=f"wanted: {wanted:g}")
        if points:
            at, value, error = zip(*points, strict=True)
            axes.errorbar(at, value, error, fmt=".-", color=POINT, linewidth=1.0, capsize=3, label="tried")
        for number, solved in enumerate(solution.solutions):
            place = float(solved.values[knob.key]), float(solved.reached[key])
            axes.plot(*place, "o", color=HIGHLIGHT, markersize=8, label="" if number else "solution")
        if knob.by_ratio:
            axes.set_xscale("log")
            axes.xaxis.set_major_formatter("{x:g}")
            axes.xaxis.set_minor_formatter("{x:g}")
        if points and 0 < LOG_RATIO / 10 * min(value) < max(value) < MAX_LOG_RATIO * min(value):
            axes.set_yscale("log")
            axes.yaxis.set_major_formatter("{x:g}")
        axes.set_xlabel(_label(knob))
        axes.set_ylabel(_axis_label(key, solution.evaluations))
        legend(axes)
        figure.suptitle(
            f"{solution.name}: {_axis_label(key, solution.evaluations).partition(',')[0]} against {knob.key}"
        )
    return figure


def effects_figure(sweep: SweepResult) -> Picture:
    """Return a figure of the first ranking's result against each key: all rows, and means."""
    ranking, keys = sweep.rankings[0], sweep.knobs[:MAX_KEYS]
    rows, results = _ranked(sweep, ranking)
    column_count = min(3, len(keys))
    row_count = -(-len(keys) // column_count)
    with sheet((max(PANEL * column_count, 4.0), PANEL * row_count), DPI, 255) as figure:
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
    """Return a figure of all pairs of keys, each row a point whose colour is the first ranking's result;
    refused rows are crosses."""
    ranking, keys = sweep.rankings[0], sweep.knobs[:MAX_KEYS]
    rows, results = _ranked(sweep, ranking)
    others = [i for i in range(len(sweep.rows)) if i not in set(rows)]
    pairs = list(itertools.combinations(keys, 2))
    column_count = min(3, len(pairs))
    row_count = -(-len(pairs) // column_count)
    colours = Normalize(float(results.min()), float(results.max()))
    with sheet((max(PANEL * column_count + 1.0, 5.0), PANEL * row_count), DPI, 255) as figure:
        places = figure.subplots(row_count, column_count, squeeze=False).ravel()
        for axes, pair in itertools.zip_longest(places, pairs):
            if pair is None:
                axes.set_axis_off()
                continue
            x, y = (_places(sweep, knob, rows) for knob in pair)
            axes.scatter(
                *(_places(sweep, knob, others) for knob in pair),
                marker="x",
                s=14,
                color=REFUSED,
                linewidths=0.8,
            )
            order = np.argsort(results if ranking.goal == "max" else -results)  # the best on top
            axes.scatter(x[order], y[order], c=results[order], cmap=COLOURS, norm=colours, s=22)
            for knob, side in zip(pair, "xy", strict=True):
                _name_ticks(axes, knob, side)
            axes.set_xlabel(_label(pair[0]))
            axes.set_ylabel(_label(pair[1]))
        figure.colorbar(
            ScalarMappable(colours, COLOURS), ax=list(places), label=_axis_label(ranking.key, sweep.rows)
        )
        figure.suptitle(f"{sweep.name}: {ranking.key}; crosses: refused, or without it")
    return figure


def front_figure(sweep: SweepResult) -> Picture:
    """Return a figure of the first two rankings' results; no row beats one of the front in both."""
    first, second = sweep.rankings[:2]
    rows = [row for row in _ranked(sweep, first)[0] if row in set(_ranked(sweep, second)[0])]
    x, y = (
        np.array([float(sweep.rows[i].results[ranking.key]) for i in rows]) for ranking in (first, second)
    )
    front = pareto(np.column_stack([_less(x, first), _less(y, second)]))
    order = np.argsort(x[front])
    with sheet(SIZE, DPI, 255) as figure:
        axes = figure.add_subplot()
        axes.plot(x, y, ".", color=POINT, alpha=0.5, label="rows")
        axes.plot(x[front][order], y[front][order], "o-", color=HIGHLIGHT, markersize=5, label="front")
        for i in np.flatnonzero(front):
            axes.annotate(
                str(rows[i] + 1), (x[i], y[i]), fontsize=7, xytext=(4, 4), textcoords="offset points"
            )
        axes.set_xlabel(f"{_axis_label(first.key, sweep.rows)} ({first.goal})")
        axes.set_ylabel(f"{_axis_label(second.key, sweep.rows)} ({second.goal})")
        legend(axes)
        figure.suptitle(f"{sweep.name}: {first.key} and {second.key}")
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
    return rows, np.array([float(sweep.rows[i].results[ranking.key]) for i in rows])


def _places(sweep: SweepResult, knob: DesignVariable, rows: Sequence[int]) -> Array:
    """A key's values of some rows, choices by their number."""
    values = [sweep.rows[i].values[knob.key] for i in rows]
    if knob.choices:
        values = [knob.choices.index(value) for value in values]
    return np.array(values, dtype=float)


def _levels(at: Array) -> Array:
    """The values that several rows share: of a grid, not of a sample."""
    values, counts = np.unique(at, return_counts=True)
    return values[counts > 1]


def _name_ticks(axes: Axes, knob: DesignVariable, side: str = "x") -> None:
    axis = axes.xaxis if side == "x" else axes.yaxis
    if any(isinstance(choice, str) for choice in knob.choices):
        axis.set_ticks(range(len(knob.choices)), [str(choice) for choice in knob.choices], fontsize=7)
        if side == "x":
            for label in axis.get_ticklabels():
                label.set(rotation=60, horizontalalignment="right")


def _axis_label(key: str, rows: Sequence[Evaluation]) -> str:
    """A result's key with its unit, which stands behind a comma, whether or not it ends the key."""
    unit = next((row.results[key].unit for row in rows if key in row.results), "1")
    return key if unit == "1" else f"{key.removesuffix(f'_{unit}')}, {unit}"


def _label(knob: DesignVariable) -> str:
    return f"{knob.key}, {knob.unit}" if knob.unit else knob.key
