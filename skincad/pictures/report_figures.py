"""The report's own small figures: error against time of the models asked, and what moves the force."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from skincad.mechanics.sensitivity import Sensitivity
from skincad.pictures.canvas import BLUE, GREY, VERMILION, LogLocator, NullLocator, Picture, sheet

SIZE, DPI = (7.0, 3.0), 100
ROOM = 3.0  # by which the axes reach beyond the points
FEW = 20.0  # ratio of errors below which more than powers of ten are named


def models_figure(asked: Sequence[tuple[str, float, float]]) -> Picture:
    """Return the relative error of the all-touch force against time, s: a point for each model asked, as
    `(name, seconds, error)`; the last one gave the verdict."""
    shown = [each for each in asked if each[2] > 0]
    with sheet(SIZE, DPI) as figure:
        axes = figure.add_subplot()
        times, errors = [each[1] for each in shown], [each[2] for each in shown]
        axes.loglog(times, errors, color=GREY, linewidth=1.0, zorder=1)
        axes.scatter(times[:-1], errors[:-1], color=BLUE, s=36, zorder=2)
        axes.scatter(times[-1:], errors[-1:], color=VERMILION, marker="D", s=44, zorder=2)
        axes.set_xlim(min(times) / ROOM, max(times) * ROOM)
        axes.set_ylim(min(errors) / ROOM, max(errors) * ROOM)
        middle = math.sqrt(min(times) * max(times))
        for name, time, error in shown:
            left = time > middle or len(shown) == 1
            axes.annotate(
                name,
                (time, error),
                xytext=(-7 if left else 7, 7),
                textcoords="offset points",
                ha="right" if left else "left",
                fontsize=8,
            )
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_minor_locator(NullLocator())
            axis.set_major_formatter("{x:g}")
        if max(errors) < FEW * min(errors):  # with its room: no two powers of ten need lie within
            axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axes.set_xlabel("predicted time, s")
        axes.set_ylabel("error of the all-touch\nforce, relative")
    return figure


def sensitivity_figure(found: Sequence[Sensitivity]) -> Picture:
    """Return a bar for each key: the change of the all-touch force by 1 % more of it, N, with its error."""
    with sheet((SIZE[0], 0.9 + 0.24 * len(found)), DPI) as figure:
        axes = figure.add_subplot()
        places = np.arange(len(found))[::-1]
        values = [each.change.value or 0.0 for each in found]
        errors = [each.change.error or 0.0 for each in found]
        colours = [BLUE if value > 0 else VERMILION for value in values]
        axes.barh(places, values, xerr=errors, color=colours, capsize=2.5, error_kw={"linewidth": 1.0})
        axes.axvline(0.0, color=GREY, linewidth=0.8)
        axes.set_yticks(places, [each.key for each in found])
        axes.set_xlabel("change of the all-touch force for 1 % more of it, N")
        axes.grid(visible=False, axis="y")
    return figure
