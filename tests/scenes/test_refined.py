"""Errors by source, and the steps of a march with fewer."""

from __future__ import annotations

import numpy as np
import pytest

from skincad.base import plain
from skincad.scenes import BySource, coarse_steps


def test_fewer_steps_keep_the_history_s_points() -> None:
    indices = coarse_steps(23, np.array([0, 7, 13, 23]))
    assert indices.tolist() == [0, 5, 7, 10, 13, 15, 20, 23]


def test_without_a_source_there_is_no_sum() -> None:
    assert BySource(None, 0.1, 0.0).total is None
    assert BySource(0.1, None, 0.0).total is None
    assert BySource(0.1, 0.2, 0.3).total == pytest.approx(0.6)
    assert BySource(0.1, 0.2, 0.3, 0.4).total == pytest.approx(1.0)
    data = {"mesh": 0.1, "time_step": 0.2, "left_out": 0.3, "drift": 0.4}
    assert plain(BySource(0.1, 0.2, 0.3, 0.4)) == data
