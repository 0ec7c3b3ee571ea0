"""The picture of a gain: the curve, its fitted lines, the paper's statements, data without their offset."""

from __future__ import annotations

from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from skincad.base import Estimate
from skincad.circuit import CircuitGain, gain, load_circuit
from skincad.outputs import Axes, gain_figure


@cache
def of(name: str) -> CircuitGain:
    return gain(load_circuit(name))


def changed(found: CircuitGain, **more: object) -> CircuitGain:
    return CircuitGain(**{**{key: getattr(found, key) for key in found.__dataclass_fields__}, **more})


def lines(found: CircuitGain) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    axes: Axes = gain_figure(found).axes[0]
    assert axes.get_xscale() == "log"
    return {str(line.get_label()): np.array(line.get_data(), dtype=float) for line in axes.lines}


def slope(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return np.diff(y) / np.diff(np.log10(x))


def starting(drawn: dict[str, tuple[np.ndarray, np.ndarray]], words: str) -> tuple[np.ndarray, np.ndarray]:
    (curve,) = (data for label, data in drawn.items() if label.startswith(words))
    return curve


def test_the_fitted_lines_meet_at_the_cut_off_and_span_the_fitted_range() -> None:
    circuit_gain = of("transimpedance")
    assert np.array(starting(lines(circuit_gain), "network")) == pytest.approx(
        np.array([circuit_gain.frequency, circuit_gain.gain])
    )
    circuit_gain = of("yamada-2002")
    assert circuit_gain.own is not None
    drawn, slopes = lines(circuit_gain), circuit_gain.slopes
    film_gain = np.array([circuit_gain.frequency, circuit_gain.own.gain])
    assert np.array(starting(drawn, "network alone")) == pytest.approx(film_gain)
    assert np.array(starting(drawn, "network and rig")) == pytest.approx(
        np.array([circuit_gain.frequency, circuit_gain.gain])
    )
    x, y = starting(drawn, "fitted")
    assert x == pytest.approx(
        [circuit_gain.frequency[0], slopes.cutoff.value, circuit_gain.circuit.sweep.fit_high]
    )
    assert y[1] == pytest.approx(slopes.level)
    assert slope(x, y) == pytest.approx([slopes.below.value, slopes.above.value])


@pytest.mark.parametrize("name", ["yamada-2002", "yamada-2002-motional"])
def test_the_papers_lines_have_its_slopes_and_the_curves_mean_level(name: str) -> None:
    """20 dB a decade up to 1.2 kHz and 60 dB above, from 10 Hz to 8 kHz, and a drop at 9 kHz."""
    circuit_gain = of(name)
    drawn = lines(circuit_gain)
    x, y = starting(drawn, "paper: 20")
    assert list(x) == [10.0, 1200.0, 8000.0]
    assert slope(x, y) == pytest.approx([20.0, 60.0])
    inside = circuit_gain.frequency <= 8000.0
    at = circuit_gain.frequency[inside]
    line = y[1] + np.where(at < 1200.0, 20.0, 60.0) * np.log10(at / 1200.0)
    assert np.mean(circuit_gain.gain[inside] - line) == pytest.approx(0.0, abs=1e-9)
    assert list(starting(drawn, "paper: drop at 9 kHz")[0]) == [9000.0, 9000.0]
    other = of("transimpedance")
    assert not any(label.startswith("paper") for label in lines(other))


def test_without_a_cut_off_one_line_goes_through_the_fitted_ranges_middle() -> None:
    circuit_gain = of("yamada-2002")
    none = Estimate(None, None, "Hz")
    slopes = circuit_gain.slopes.__class__(
        **{**vars(circuit_gain.slopes), "cutoff": none, "above": circuit_gain.slopes.below}
    )
    drawn = lines(changed(circuit_gain, slopes=slopes))
    x, y = starting(drawn, "fitted")
    sweep = circuit_gain.circuit.sweep
    assert x[1] == pytest.approx(np.sqrt(sweep.low * sweep.fit_high))
    assert slope(x, y) == pytest.approx([slopes.below.value] * 2)


def test_data_are_drawn_without_the_offset_that_was_fitted() -> None:
    circuit_gain = of("yamada-2002")
    measurement = SimpleNamespace(
        frequency=np.array([20.0, 200.0]),
        gain=np.array([3.0, 5.0]),
        calibration=SimpleNamespace(offset=-12.5),
    )
    x, y = starting(lines(changed(circuit_gain, measured=measurement)), "measured, +12.5 dB")
    assert (list(x), list(y)) == ([20.0, 200.0], [15.5, 17.5])
