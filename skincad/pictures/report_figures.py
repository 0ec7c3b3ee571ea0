"""The report's own small figures: error against time of the models tried, and what moves the force."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import shapely

from skincad.mechanics.manufacture import Sensitivity
from skincad.pictures.canvas import (
    BLUE,
    GREY,
    VERMILION,
    Axes,
    Figure,
    LogLocator,
    NullLocator,
    Picture,
    sheet,
)

SIZE, DPI = (7.0, 3.0), 100
AXIS_ROOM = 3.0  # by which the axes reach beyond the points
LABEL_OFFSETS = (
    (7, 7),
    (-7, -7),
    (7, -7),
    (-7, 7),
    (7, 20),
    (-7, -20),
)  # points: where a point's name may begin
LABEL_CLEARANCE = 4.0  # pixels, of a name from a point
NARROW_RATIO = 20.0  # ratio of errors below which more than powers of ten are named


Points = Sequence[tuple[str, float, float]]


def models_figure(models: Points) -> Picture:
    """Return the relative error of the all-touch force against time, s: a point for each model tried, as
    `(name, seconds, error)`; the last one gave the verdict."""
    shown = [model for model in models if model[2] > 0]
    with sheet(SIZE, DPI) as figure:
        axes = figure.add_subplot()
        times, errors = [model[1] for model in shown], [model[2] for model in shown]
        axes.loglog(times, errors, color=GREY, linewidth=1.0, zorder=1)
        axes.scatter(times[:-1], errors[:-1], color=BLUE, s=36, zorder=2)
        axes.scatter(times[-1:], errors[-1:], color=VERMILION, marker="D", s=44, zorder=2)
        axes.set_xlim(min(times) / AXIS_ROOM, max(times) * AXIS_ROOM)
        axes.set_ylim(min(errors) / AXIS_ROOM, max(errors) * AXIS_ROOM)
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_minor_locator(NullLocator())
            axis.set_major_formatter("{x:g}")
        if max(errors) < NARROW_RATIO * min(errors):  # with its room: no two powers of ten need lie within
            axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axes.set_xlabel("predicted time, s")
        axes.set_ylabel("error of the all-touch\nforce, relative")
        _label_points(figure, axes, shown)
    return figure


def _label_points(figure: Figure, axes: Axes, shown: Points) -> None:
    """Put each point's name beside it: within the axes, on no other name, point or line."""
    figure.draw_without_rendering()  # else nothing has its place yet
    at = axes.transData.transform([(time, error) for _, time, error in shown])
    obstacles = [shapely.Point(place).buffer(LABEL_CLEARANCE) for place in at]
    obstacles += [shapely.LineString(at)] if len(at) > 1 else []
    whole = shapely.box(*axes.bbox.extents)
    for name, time, error in shown:
        for x, y in LABEL_OFFSETS:
            side: dict[str, Any] = {"ha": "left" if x > 0 else "right", "va": "bottom" if y > 0 else "top"}
            label = axes.annotate(name, (time, error), (x, y), textcoords="offset points", fontsize=8, **side)
            box = shapely.box(*label.get_window_extent().extents)
            if (whole.contains(box) and not any(map(box.intersects, obstacles))) or (x, y) == LABEL_OFFSETS[
                -1
            ]:
                break
            label.remove()
        obstacles.append(box)


def sensitivity_figure(sensitivities: Sequence[Sensitivity]) -> Picture:
    """Return a bar for each key: the change of the all-touch force by 1 % more of it, N, with its error."""
    with sheet((SIZE[0], 0.9 + 0.24 * len(sensitivities)), DPI) as figure:
        axes = figure.add_subplot()
        places = np.arange(len(sensitivities))[::-1]
        values = [sensitivity.change.value or 0.0 for sensitivity in sensitivities]
        errors = [sensitivity.change.error or 0.0 for sensitivity in sensitivities]
        colours = [BLUE if value > 0 else VERMILION for value in values]
        axes.barh(places, values, xerr=errors, color=colours, capsize=2.5, error_kw={"linewidth": 1.0})
        axes.axvline(0.0, color=GREY, linewidth=0.8)
        axes.set_yticks(places, [sensitivity.key for sensitivity in sensitivities])
        axes.set_xlabel("change of the all-touch force for 1 % more of it, N")
        axes.grid(visible=False, axis="y")
    return figure
