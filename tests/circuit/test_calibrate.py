"""Cut-off and slopes of curves whose answer is known; what calibration reaches of the paper's statements."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bench.circuits import READINGS, nearest
from skincad.base import Estimate
from skincad.circuit import (
    BOUNDS,
    FITTED,
    PAPER_CUTOFF,
    Constants,
    constants,
    decibels,
    gain,
    load_circuit,
)
from skincad.circuit.calibrate import Calibration, _between, calibrate
from skincad.circuit.response import fit_slopes
from tests.circuit.paper import exact_response, paper_target
from tests.refusals import refused

F = np.geomspace(10.0, 20_000.0, 400)


def lines(corner: float, below: float, above: float) -> np.ndarray:
    return np.where(corner > F, below, above) * np.log10(F / corner) - 40.0


@pytest.mark.parametrize(
    ("corner", "below", "above"),
    [
        *((1200.0, 20.0, 60.0), (300.0, 0.0, -20.0)),
        # all but at the range's ends: nearer than a tenth of it, in log f, no line stands on its own
        *((10.0 * 800.0**share, 10.0, 60.0) for share in (0.12, 0.3, 0.7, 0.88)),
    ],
)
def test_two_lines_are_found(corner: float, below: float, above: float) -> None:
    slopes = fit_slopes(F, lines(corner, below, above), 10.0, 8000.0)
    assert slopes.cutoff.value == pytest.approx(corner, rel=2e-3)  # the minimiser's own tolerance
    assert slopes.below.value == pytest.approx(below, abs=0.1)
    assert slopes.above.value == pytest.approx(above, abs=0.1)
    if corner in (1200.0, 300.0):
        assert slopes.cutoff.value == pytest.approx(corner, rel=1e-3)
        assert slopes.level == pytest.approx(-40.0, abs=0.05)
        assert slopes.cutoff.error < 5.0


@pytest.mark.evidence(subject="seeds: bends of curves")
def test_the_error_covers_the_truth_under_noise() -> None:
    """Noise of 1 dB: 20 seeded curves, each within its claimed error (two standard errors and the ranges)."""
    misses = 0
    for seed in range(20):
        noise = np.random.default_rng(seed).normal(0.0, 1.0, F.size)
        slopes = fit_slopes(F, lines(1200.0, 20.0, 60.0) + noise, 10.0, 8000.0)
        misses += abs(slopes.cutoff.value - 1200.0) > slopes.cutoff.error
    assert misses <= 2  # 5 % of 20, and one more


def test_a_straight_line_has_no_cutoff_a_roll_off_its_corner() -> None:
    slopes = fit_slopes(F, 20 * np.log10(F), 10.0, 8000.0)
    assert slopes.cutoff.value is None
    assert slopes.below == slopes.above
    assert slopes.below.value == pytest.approx(20.0, abs=1e-6)
    # A smooth curve: its asymptotes meet at 800 Hz, and the range moves the fitted corner
    slopes = fit_slopes(F, -10 * np.log10(1 + (F / 800.0) ** 2), 10.0, 20_000.0)
    assert abs(slopes.cutoff.value - 800.0) < slopes.cutoff.error
    # The same noiseless bend on a grid four times as fine above 1 kHz: the same answer
    uneven = np.concatenate([F[F < 1000.0], np.geomspace(1000.0, 20_000.0, 700)])

    def bend(f: np.ndarray) -> np.ndarray:
        return 10 * np.log10((f / 1000.0) ** 2 + (f / 1000.0) ** 6)

    even, other = fit_slopes(F, bend(F), 10.0, 8000.0), fit_slopes(uneven, bend(uneven), 10.0, 8000.0)
    assert other.cutoff.value == pytest.approx(even.cutoff.value, rel=0.01)  # the grids' own sampling


def test_too_few_points_are_told_and_the_same_seed_gives_the_same_answer() -> None:
    with refused("at least 20"):
        fit_slopes(F[:10], F[:10], 10.0, 8000.0)
    with refused("at least 10"):
        calibrate(np.array([10.0, 20.0]), np.array([1.0, 2.0]))
    target = paper_target()
    assert calibrate(*target, starts=4) == calibrate(*target, starts=4)


@pytest.mark.parametrize(("below", "above", "flatter"), [
    (20.0, 60.0, "below"), (-20.0, 5.0, "above"), (None, 0.5, "below"), (0.5, None, "above"),
])  # fmt: skip
def test_mid_band_is_on_the_flatter_side(below: float | None, above: float | None, flatter: str) -> None:
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


@pytest.mark.parametrize("share", [0.02, 0.98])
def test_a_bend_at_the_very_end_is_no_corner_there(share: float) -> None:
    slopes = fit_slopes(F, lines(10.0 * 800.0**share, 10.0, 60.0), 10.0, 8000.0)
    if slopes.cutoff.value is not None:
        assert 0.09 < math.log(slopes.cutoff.value / 10.0) / math.log(800.0) < 0.91


@pytest.mark.parametrize("mirror", [False, True])
def test_the_error_covers_an_outermost_tenth_that_bends_off(mirror: bool) -> None:
    """A line of 20 dB/dec but for a tenth at one end: without it the slope is exactly 20, and the error is
    how far the whole range's is off."""
    x = np.linspace(1.0, 4.0, 201)
    off = np.maximum(x - 3.7, 0.0) * 2.5  # less than a corner needs
    level = 20.0 * x + (off[::-1] if mirror else off)
    slopes = fit_slopes(10**x, level, 10.0, 10_000.0)
    assert slopes.cutoff.value is None
    assert abs(slopes.below.value - 20.0) > 0.01
    assert slopes.below.error == pytest.approx(abs(slopes.below.value - 20.0), rel=1e-6)


def misfit(c: Constants) -> float:
    frequency, gain = paper_target()
    return float(np.std(decibels(exact_response(c, frequency)) - gain))


@pytest.fixture(scope="module")
def shipped() -> Constants:
    """The reading that is all network."""
    return constants(load_circuit("yamada-2002-motional"))


@pytest.fixture(scope="module")
def calibration() -> Calibration:
    """The nearest to the paper's statements."""
    return calibrate(*paper_target())


@pytest.mark.slow
def test_the_shipped_set_is_as_near_to_the_paper_as_any(shipped: Constants, calibration: Calibration) -> None:
    assert misfit(shipped) == pytest.approx(1.82, abs=0.01)
    assert calibration.rms == pytest.approx(misfit(shipped), abs=0.01)
    assert calibration.agreeing >= 2  # more than one start ended there
    # Which constants the other six mix hangs on the machine's rounding: only their number is told
    assert len(calibration.combinations) - len(calibration.open_combinations) == 4
    frequency, _ = paper_target()
    before = decibels(exact_response(calibration.constants, frequency))
    step = calibration.open_combinations[0].exponents
    moved = {
        name: getattr(calibration.constants, name) * np.exp(0.5 * step.get(name, 0.0)) for name in FITTED
    }
    moved["motional_capacitance"] *= moved["capacitance"] / calibration.constants.capacitance
    after = decibels(exact_response(Constants(d33=-33e-12, **moved), frequency))
    assert np.std(after - before) < 0.1  # OPEN, over half a factor e


def test_every_shipped_constant_lies_in_its_bounds_which_are_the_pages(shipped: Constants) -> None:
    for name in FITTED:
        value = getattr(shipped, name)
        if name == "motional_capacitance":
            value /= shipped.capacitance
        low, high = BOUNDS[name]
        assert low <= value <= high * 1.001, name  # its three digits: the ratio is at its bound
    page = (Path(__file__).parents[2] / "docs" / "evidence" / "circuit.md").read_text("utf-8")
    rows = re.findall(r"^\| `(\w+)` \| (\S+) \| (\S+) \|", page, re.M)
    ranges = {name: (float(low), float(high)) for name, low, high in rows if name in BOUNDS}
    assert ranges == BOUNDS
    # the cut-off is the paper's, but 60 dB a decade are not reached
    frequency = np.geomspace(10.0, 20_000.0, 400)
    slopes = fit_slopes(frequency, decibels(exact_response(shipped, frequency)), 10.0, 8000.0)
    assert slopes.cutoff.value == pytest.approx(PAPER_CUTOFF, rel=0.05)
    assert slopes.below.value == pytest.approx(21.3, abs=0.2)
    assert slopes.above.value == pytest.approx(53.7, abs=0.3)


@pytest.mark.slow
def test_with_a_films_own_coupling_the_network_stays_at_20_db_a_decade() -> None:
    """Static over motional capacitance as a PVDF film has it: no better than a straight line."""
    frequency, gain = paper_target()
    straight = 20 * np.log10(frequency) - gain
    rms, _ = nearest(*READINGS["network, film"])
    assert rms == pytest.approx(float(np.std(straight)), abs=0.05)
    assert rms > 9.0


@pytest.mark.slow
def test_known_constants_curve_is_found_again() -> None:
    """A curve of the network itself, at another level: nothing is left over."""
    known = constants(load_circuit("yamada-2002-motional", ["motional.resistance=50000.0"]))
    frequency = np.geomspace(10.0, 8000.0, 60)
    calibration = calibrate(frequency, decibels(exact_response(known, frequency)) + 7.0)
    assert calibration.rms < 0.01  # the optimiser's own end
    again = exact_response(calibration.constants, frequency)
    shift = decibels(again) - decibels(exact_response(known, frequency)) - 7.0
    assert calibration.offset == pytest.approx(-float(shift.mean()), abs=1e-9)


def test_a_resonance_between_two_points_counts_against_a_start() -> None:
    """One so sharp that no point of the curve sees it: by the points alone it would be as good as a line."""
    frequency, gain = paper_target()
    hidden = Constants(
        d33=-33e-12, capacitance=12.6e-12, motional_resistance=1e-3, motional_inductance=9700.0,
        motional_capacitance=1.257e-12, series_resistance=1e4, input_resistance=1e5,
        input_capacitance=1e-10, feedback_resistance=100.0, output_resistance=1e3, gain=9e6,
    )  # fmt: skip
    plain = replace(hidden, motional_capacitance=1e-17)
    assert misfit(hidden) == pytest.approx(misfit(plain), abs=0.001)
    assert _between(hidden, frequency, gain) > _between(plain, frequency, gain) + 0.5
