"""The error of a stress by source, against a closed form."""

from __future__ import annotations

import numpy as np
import pytest

from skincad.base import Array
from skincad.effects import Observables
from skincad.scenes import BySource, ComparisonRuns, March
from skincad.scenes.errors import stress_errors


def euler(steps: int, gross: float = np.inf) -> March:
    """A stress that grows by 2 t, which steps forward miss by t times the step; of one point that slides from
    `gross` on."""
    time = np.linspace(0.0, 20.0, steps + 1)
    stress = np.concatenate([[0.0], np.cumsum(2 * time[:-1] * np.diff(time))])
    one = np.ones(1, dtype=bool)
    readings = tuple(
        Observables(1.0, 1.0, 0.0, 0.0, one, one & (at >= gross), np.full((1, 3), value), 0.0, 0.0, 0.0)
        for at, value in zip(time, stress, strict=True)
    )
    return March(time, readings, np.ones(1, dtype=int), 0, None, False, 0.0, np.zeros((steps + 1, 3, 1)))


def stress(march: March) -> dict[int, Array]:
    return {1: march.column("films")[:, 0, 0]}


def error(refined: ComparisonRuns, change: float = 0.0, mesh: dict[int, float] | None = None) -> BySource:
    return stress_errors({1: np.array([0.0, -3.0, 2.0])}, mesh, refined, stress, change, {})[1]


def test_the_time_steps_share_is_four_errors_of_first_order() -> None:
    every, coarse = euler(20), euler(4)
    exact = np.abs(stress(every)[1] - every.time**2).max()
    assert error(ComparisonRuns(every=every, coarse=coarse)).time_step == pytest.approx(4 * float(exact))


@pytest.mark.parametrize(("gross", "coarse_gross"), [(12.0, np.inf), (np.inf, 12.0), (15.0, 12.0)])
def test_from_gross_slip_on_nothing_is_compared(gross: float, coarse_gross: float) -> None:
    """12 s: the march with steps of 5 s has it at 15 s. At 10 s steps of 1 s miss 10, of 5 s they miss 50."""
    assert error(
        ComparisonRuns(every=euler(20, gross), coarse=euler(4, coarse_gross))
    ).time_step == pytest.approx(40.0)


def test_of_two_marches_without_a_common_step_nothing_is_known() -> None:
    assert error(ComparisonRuns(every=euler(20, 3.0), coarse=euler(4))).time_step is None
    assert error(ComparisonRuns(every=euler(20), coarse=None)).time_step is None


def test_what_is_left_out_is_a_share_of_the_largest() -> None:
    result = error(ComparisonRuns(), 0.2, {1: 0.1})
    assert result[:3] == (0.1, None, pytest.approx(0.6))
    assert error(ComparisonRuns())[:3] == (None, None, 0.0)
