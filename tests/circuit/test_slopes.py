"""Cut-off and slopes of curves whose answer is known."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from skincad.base import Estimate, InputError
from skincad.circuit import bode, constants, gain, load_circuit
from skincad.circuit.calibrate import Calibration
from skincad.circuit.response import fit_slopes
from tests.circuit.sets import exact_calibration

F = np.geomspace(10.0, 20_000.0, 400)


def lines(corner: float, below: float, above: float) -> np.ndarray:
    return np.where(corner > F, below, above) * np.log10(F / corner) - 40.0


@pytest.mark.parametrize(("corner", "below", "above"), [(1200.0, 20.0, 60.0), (300.0, 0.0, -20.0)])
def test_two_lines_are_found_exactly(corner: float, below: float, above: float) -> None:
    slopes = fit_slopes(F, lines(corner, below, above), 10.0, 8000.0)
    assert slopes.cutoff.value == pytest.approx(corner, rel=1e-3)  # the minimiser's own tolerance
    assert slopes.below.value == pytest.approx(below, abs=0.01)
    assert slopes.above.value == pytest.approx(above, abs=0.01)
    assert slopes.level == pytest.approx(-40.0, abs=0.05)
    assert slopes.cutoff.error is not None
    assert slopes.cutoff.error < 5.0


def test_the_error_covers_the_truth_under_noise() -> None:
    """Noise of 1 dB: 20 seeded curves, each within its claimed error (two standard errors and the ranges)."""
    misses = 0
    for seed in range(20):
        noise = np.random.default_rng(seed).normal(0.0, 1.0, F.size)
        slopes = fit_slopes(F, lines(1200.0, 20.0, 60.0) + noise, 10.0, 8000.0)
        assert slopes.cutoff.value is not None
        assert slopes.cutoff.error is not None
        misses += abs(slopes.cutoff.value - 1200.0) > slopes.cutoff.error
    assert misses <= 2  # 5 % of 20, and one more


def test_a_straight_line_has_no_cutoff() -> None:
    slopes = fit_slopes(F, 20 * np.log10(F), 10.0, 8000.0)
    assert slopes.cutoff.value is None
    assert slopes.below == slopes.above
    assert slopes.below.value == pytest.approx(20.0, abs=1e-6)


def test_a_first_order_roll_off_has_its_corner_within_the_error() -> None:
    """A smooth curve: its asymptotes meet at 800 Hz, and the range moves the fitted corner."""
    slopes = fit_slopes(F, -10 * np.log10(1 + (F / 800.0) ** 2), 10.0, 20_000.0)
    assert slopes.cutoff.value is not None
    assert slopes.cutoff.error is not None
    assert abs(slopes.cutoff.value - 800.0) < slopes.cutoff.error


def test_points_spread_unevenly_weigh_by_their_share_of_the_range() -> None:
    """The same noiseless bend on a grid four times as fine above 1 kHz: the same answer."""
    uneven = np.concatenate([F[F < 1000.0], np.geomspace(1000.0, 20_000.0, 700)])

    def bend(f: np.ndarray) -> np.ndarray:
        return 10 * np.log10((f / 1000.0) ** 2 + (f / 1000.0) ** 6)

    even, other = fit_slopes(F, bend(F), 10.0, 8000.0), fit_slopes(uneven, bend(uneven), 10.0, 8000.0)
    assert even.cutoff.value is not None
    assert other.cutoff.value == pytest.approx(even.cutoff.value, rel=0.01)  # the grids' own sampling


def test_too_few_points_are_told() -> None:
    with pytest.raises(InputError, match="at least 20"):
        fit_slopes(F[:10], F[:10], 10.0, 8000.0)


@pytest.mark.parametrize(("below", "above", "flatter"), [
    (20.0, 60.0, "below"), (-20.0, 5.0, "above"), (None, 0.5, "below"), (0.5, None, "above"),
])  # fmt: skip
def test_mid_band_is_on_the_flatter_side_of_the_cutoff(
    below: float | None, above: float | None, flatter: str
) -> None:
    """A side without a slope is flat. Its middle is that of logarithms, from end to cut-off."""
    curve = gain(load_circuit("transimpedance"))
    sides = {
        "cutoff": Estimate(100.0, 1.0, "Hz"),
        "below": Estimate(below, None, "dB/dec"),
        "above": Estimate(above, None, "dB/dec"),
    }
    middle, level = replace(curve, slopes=replace(curve.slopes, **sides)).mid_band
    end = curve.frequency[0] if flatter == "below" else curve.circuit.sweep.fit_high
    assert middle == pytest.approx(math.sqrt(100.0 * end))
    nearest = int(np.abs(curve.frequency - middle).argmin())
    assert level == pytest.approx(curve.gain[nearest], abs=0.5)  # between two points of the sweep


@pytest.mark.parametrize("share", [0.12, 0.3, 0.7, 0.88])
def test_a_corner_is_found_all_but_at_the_ranges_ends(share: float) -> None:
    """Of the range in log f; nearer than a tenth of it to an end no line stands on its own."""
    corner = 10.0 * 800.0**share
    slopes = fit_slopes(F, lines(corner, 10.0, 60.0), 10.0, 8000.0)
    assert slopes.cutoff.value == pytest.approx(corner, rel=2e-3)  # the minimiser's own tolerance
    assert (slopes.below.value, slopes.above.value) == (
        pytest.approx(10.0, abs=0.1),
        pytest.approx(60.0, abs=0.1),
    )


@pytest.mark.parametrize("share", [0.02, 0.98])
def test_a_bend_at_the_very_end_is_no_corner_there(share: float) -> None:
    slopes = fit_slopes(F, lines(10.0 * 800.0**share, 10.0, 60.0), 10.0, 8000.0)
    if slopes.cutoff.value is not None:
        assert 0.09 < math.log(slopes.cutoff.value / 10.0) / math.log(800.0) < 0.91


@pytest.mark.parametrize(("last", "fitted"), [(20_000.0, 8000.0), (4000.0, 4000.0)])
def test_a_measured_curve_is_fitted_to_its_end_or_the_sweeps(
    last: float, fitted: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Beyond 8 kHz a curve may drop, as the paper's does, which is no slope of the network."""
    reached = []

    def calibrated(frequency: np.ndarray, *_: object, **__: object) -> Calibration:
        reached.append(frequency[-1])
        return exact_calibration(constants(circuit))

    circuit = load_circuit("yamada-2002")
    monkeypatch.setattr(bode, "calibrate", calibrated)
    frequency = np.append(np.geomspace(10.0, 8000.0, 200), np.geomspace(8001.0, 20_000.0, 50))
    level = np.where(frequency < 1200.0, 20.0, 60.0) * np.log10(frequency / 1200.0)
    level[frequency > 8000.0] -= 60.0
    in_range = frequency[frequency <= last]
    rows = [f"{f:.17g},{g}" for f, g in zip(in_range, level[: in_range.size], strict=True)]
    (tmp_path / "m.csv").write_text("\n".join(["frequency_Hz,gain_dB", *rows]))
    measured = gain(circuit, tmp_path / "m.csv").measured
    assert measured is not None
    assert measured.slopes.cutoff.value == pytest.approx(1200.0, rel=2e-3)  # the minimiser's own tolerance
    assert measured.slopes.above.value == pytest.approx(60.0, abs=0.1)
    assert reached == [in_range[in_range <= fitted][-1]]


@pytest.mark.parametrize("mirror", [False, True])
def test_the_error_covers_an_outermost_tenth_that_bends_off(mirror: bool) -> None:
    """A line of 20 dB/dec but for a tenth at one end: without it the slope is exactly 20, and the error is
    how far the whole range's is off."""
    x = np.linspace(1.0, 4.0, 201)
    off = np.maximum(x - 3.7, 0.0) * 2.5  # less than a corner needs
    level = 20.0 * x + (off[::-1] if mirror else off)
    slopes = fit_slopes(10**x, level, 10.0, 10_000.0)
    assert slopes.cutoff.value is None
    assert slopes.below.value is not None
    assert abs(slopes.below.value - 20.0) > 0.01
    assert slopes.below.error == pytest.approx(abs(slopes.below.value - 20.0), rel=1e-6)
