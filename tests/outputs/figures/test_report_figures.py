"""The report's own figures: a point for each model, a bar for each key, with errors."""

from __future__ import annotations

import numpy as np
import pytest

from skincad.base import Estimate
from skincad.mechanics import Sensitivity
from skincad.outputs.figures.results import models_figure, sensitivity_figure


def test_each_model_is_a_point_with_its_name() -> None:
    models = [("winkler", 4e-4, 0.8), ("linear", 0.7, 0.45), ("corrected", 2.8, 0.14)]
    (axes,) = models_figure(models).axes
    before, last = (np.asarray(collection.get_offsets()) for collection in axes.collections)
    assert np.vstack([before, last]) == pytest.approx(np.array([collection[1:] for collection in models]))
    assert [text.get_text() for text in axes.texts] == [collection[0] for collection in models]
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")


def test_no_models_name_lies_on_another_or_on_a_point() -> None:
    """As gripper-pad has them: the last two errors are nearly the same."""
    models = [("winkler", 4e-4, 1.1), ("linear", 1.4, 0.69), ("corrected", 5.9, 0.35)]
    figure = models_figure([*models, ("corrected-finite-strain", 15.0, 0.31)])
    (axes,) = figure.axes
    figure.draw_without_rendering()
    boxes = [text.get_window_extent() for text in axes.texts]
    points = axes.transData.transform([(time, error) for _, time, error in models])
    for i, box in enumerate(boxes):
        assert box.count_overlaps(boxes) == 1, axes.texts[i].get_text()  # itself
        assert not any(box.contains(*point) for point in points)
        assert axes.bbox.x0 < box.x0 < box.x1 < axes.bbox.x1


def test_each_key_is_a_bar_the_first_one_on_top() -> None:
    sensitivities = [
        Sensitivity("ridge.pitch", 1.0, "mm", Estimate(0.05, 0.02, "N")),
        Sensitivity("skin.thickness", 4.0, "mm", Estimate(-0.02, 0.01, "N")),
    ]
    (axes,) = sensitivity_figure(sensitivities).axes
    assert [bar.get_width() for bar in axes.patches] == [0.05, -0.02]
    assert axes.patches[0].get_y() > axes.patches[1].get_y()
    assert [label.get_text() for label in axes.get_yticklabels()] == ["ridge.pitch", "skin.thickness"]
