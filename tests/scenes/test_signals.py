"""The low-pass against closed forms, and what is read off the slip of points."""

from __future__ import annotations

import math

import numpy as np
import pytest

from skincad.circuit import band_limited, corner, delay
from skincad.scenes import intervals
from skincad.scenes.errors import gross_slip_step, lasting_slip_step, slip_by_ridge

WIDTH = 300.0
TIME = np.linspace(0.0, 0.02, 401)


def test_a_ramp_by_the_closed_form() -> None:
    """y = t - 2/w + exp(-w t) (t + 2/w): a ramp is straight between samples, so only rounding is left."""
    w, signal = corner(WIDTH), band_limited(TIME, 5.0 + TIME, WIDTH)
    fade = np.exp(-w * TIME)
    assert signal.value == pytest.approx(5.0 + TIME - 2 / w + fade * (TIME + 2 / w), abs=1e-13)
    assert signal.rate == pytest.approx(1 - fade * (1 + w * TIME), abs=1e-11)
    assert signal.jerk == pytest.approx(w * w * TIME * fade, abs=1e-11 * w)


def test_the_delay_is_what_a_ramp_lags() -> None:
    # after 40 delays the start has faded to e^-80
    lag = TIME[-1] - band_limited(TIME, TIME, 5e3).value[-1]
    assert lag == pytest.approx(delay(5e3), rel=1e-9)


def test_a_sine_at_the_bandwidth_is_down_by_3_db() -> None:
    time = np.linspace(0.0, 0.1, 40_001)
    out = band_limited(time, np.sin(2 * math.pi * WIDTH * time), WIDTH).value[-4000:]
    # 1e-4: straight lines between 1300 samples a period, and the start's rest
    assert out.max() == pytest.approx(math.sqrt(0.5), rel=1e-4)


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_signals_hang_on_the_band_not_on_the_step(factor: float) -> None:
    """A kink's jerk: raw it is 1 / dt; behind the low-pass it is the same whatever dt."""
    fine = np.linspace(0.0, 0.02, int(400 * factor) + 1)
    one, other = (band_limited(t, np.maximum(t - 0.01, 0.0), WIDTH).jerk.max() for t in (TIME, fine))
    # the peak falls between samples: (w dt)^2 / 8
    assert one == pytest.approx(other, rel=(corner(WIDTH) * 1e-4) ** 2 / 4)


def test_runs_of_slip() -> None:
    assert intervals(np.array([1, 1, 0, 0, 1, 0, 1], dtype=bool)) == [[0, 1], [4, 4], [6, 6]]
    assert intervals(np.zeros(3, dtype=bool)) == []
    runs = [[2, 4], [7, 9]]
    assert lasting_slip_step(runs, 9, 20) == 7
    assert lasting_slip_step(runs, None, 9) == 7
    assert lasting_slip_step(runs, None, 10) is None


def test_a_ridge_slips_when_all_that_touches_slips() -> None:
    ridge = np.array([1, 1, 2])
    touches = np.array([[0, 0, 0], [1, 1, 1], [1, 0, 1], [1, 1, 0]], dtype=bool)
    slips = np.array([[0, 0, 0], [1, 0, 0], [1, 0, 1], [1, 1, 0]], dtype=bool)
    assert slip_by_ridge(touches, slips, ridge, 2).tolist() == [
        [False, False],
        [False, False],
        [True, True],
        [True, False],
    ]
    assert gross_slip_step(touches, slips) == 2
    assert gross_slip_step(touches[:2], slips[:2]) is None


def test_one_sample_alone_stands_still() -> None:
    signal = band_limited(np.zeros(1), np.array([5.0]), WIDTH)
    assert [values.tolist() for values in (signal.value, signal.rate, signal.jerk)] == [[5.0], [0.0], [0.0]]
