"""The picture of a check: a bar for each ridge's force with its error, and the mean force."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from skincad import load
from skincad.base import Estimate
from skincad.inputs import Design
from skincad.mechanics.check import check
from skincad.outputs.figures.results import ridge_force_figure


def test_each_ridge_has_its_bar_and_the_mean_is_a_line(yamada: Design) -> None:
    result = check(yamada, model="winkler")
    figure = ridge_force_figure(result)
    (axes,) = figure.axes
    bars = axes.patches
    assert [bar.get_x() + bar.get_width() / 2 for bar in bars] == pytest.approx(range(1, 10))
    assert [bar.get_height() for bar in bars] == pytest.approx([f.value for f in result.ridge_force])
    (errors,) = axes.collections
    half = [float(np.ptp(segment[:, 1])) / 2 for segment in errors.get_segments()]
    assert half == pytest.approx([f.error for f in result.ridge_force])
    mean = next(line for line in axes.lines if line.get_label() == "mean")
    assert list(mean.get_ydata()) == pytest.approx([4.0 / 9] * 2)
    assert list(axes.get_xticks()) == list(range(1, 10))
    assert (
        figure.get_suptitle() == f"yamada-2002: 9 of 9 touch at 4 N; all touch from {result.all_touch_force}"
    )


@pytest.mark.parametrize(("count", "named"), [(20, True), (21, False)])
def test_many_ridges_are_not_each_named_and_no_force_is_told_where_none_does(count: int, named: bool) -> None:
    share = (Estimate(0.2, None, "N"), *(Estimate(None, None, "N"),) * (count - 1))
    shown = check(load("yamada-2002"), model="winkler")
    never = replace(shown, ridges=count, ridge_force=share, all_touch_force=Estimate(None, None, "N"))
    figure = ridge_force_figure(never)
    (axes,) = figure.axes
    assert (list(axes.get_xticks()) == list(range(1, count + 1))) == named
    assert [bar.get_height() for bar in axes.patches] == [0.2, *[0.0] * (count - 1)]
    assert "all touch" not in figure.get_suptitle()
