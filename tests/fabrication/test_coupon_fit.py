"""A coupon whose truth is known says that truth: growth, scatter and offset, and how well it knows them."""

from __future__ import annotations

import numpy as np
import pytest

from skincad.fabrication.coupon_reading import crest_result, notch_result
from skincad.inputs import CrestForm, NotchForm
from skincad.solids import HEIGHTS, NOTCH_PITCH, NOTCHES, drawn_steps

BLADES = np.round(np.arange(0.02, 1.0, 0.01), 2)  # mm: a set of feeler gauges, single or laid together


def ladder(growth: float, seed: int, scatter: float = 0.005, blade: float = 0.002) -> NotchForm:
    """A person's form: notches that grew and scatter by one standard deviation, blades that are off by
    another, the thickest that goes in and the next one."""
    rng = np.random.default_rng(seed)
    drawn = np.array(NOTCHES)
    wide = drawn - 2 * growth + rng.normal(0, scatter, drawn.size)
    return by_blades(drawn, wide, BLADES + rng.normal(0, blade, BLADES.size))


def by_blades(drawn: np.ndarray, wide: np.ndarray, true: np.ndarray) -> NotchForm:
    """Blades of these true thicknesses, tried one by one until one does not go in."""
    last = [next(i for i, thick in enumerate(true) if thick > width) for width in wide]
    goes = np.array([BLADES[i - 1] if i else 0.0 for i in last])
    return NotchForm(drawn, goes, BLADES[last])


@pytest.mark.parametrize("seed", range(20))
def test_a_growth_of_30_um_is_recovered_to_5_um(seed: int) -> None:
    growth = notch_result(ladder(0.03, seed)).growth
    assert growth is not None
    assert growth.value == pytest.approx(0.03, abs=0.005)  # what the issue asks for
    assert growth.error is not None
    assert growth.error < 0.005


@pytest.mark.slow
@pytest.mark.parametrize("growth", [-0.01, 0.012, 0.03, 0.08])
@pytest.mark.parametrize("scatter", [0.0, 0.005, 0.015])
def test_its_error_bar_holds(growth: float, scatter: float) -> None:
    """In 95 % of 200 parts. 95 % of 200 has itself a standard deviation of 3: 3 of them below is 181. The
    seeds are others than those by which the assumptions of the fit were set, 10000 and up."""
    covered = 0
    for seed in range(200):
        growth_estimate = notch_result(ladder(growth, seed, scatter)).growth
        assert growth_estimate is not None
        covered += growth_estimate.lower <= growth <= growth_estimate.upper  # type: ignore[operator]
    assert covered >= 181


def test_a_ladder_that_pixels_drew() -> None:
    """A pixel is printed where its middle is in material. Pixels of 0.05 mm hit each notch elsewhere, so that
    growth is still known to 5 um beside it."""
    drawn, pixel = np.array(NOTCHES), 0.05
    for growth in (0.0, 0.03):
        places = (np.arange(drawn.size) - (drawn.size - 1) / 2) * NOTCH_PITCH
        low, high = np.ceil((places - drawn / 2) / pixel - 0.5), np.floor((places + drawn / 2) / pixel - 0.5)
        estimate = notch_result(by_blades(drawn, (high - low + 1) * pixel - 2 * growth, BLADES)).growth
        assert estimate is not None
        assert estimate.value == pytest.approx(growth, abs=0.005)
        assert estimate.lower <= growth <= estimate.upper  # type: ignore[operator]


def test_no_growth_is_said_of_notches_that_are_shut() -> None:
    drawn = np.array(NOTCHES)
    shut = notch_result(NotchForm(drawn, 0 * drawn, 0 * drawn + 0.02))
    assert (shut.growth, shut.gap) == (None, None)
    two = notch_result(ladder(0.125, 0, 0.0, 0.0))
    assert two.growth is None
    assert two.gap is not None


def test_the_narrowest_gap_is_that_from_which_all_are_open() -> None:
    drawn = np.array([0.06, 0.08, 0.10, 0.12, 0.14])
    goes = np.array([0.0, 0.02, 0.0, 0.03, 0.05])
    gap = notch_result(NotchForm(drawn, goes, goes + 0.02)).gap
    assert gap is not None
    assert (gap.value, gap.error) == (0.12, pytest.approx(0.02))


def steps(
    seed: int, within: float, between: float = 0.0, offset: float = 0.0, tilt: float = 0.0
) -> CrestForm:
    """Steps with normal errors of one and of all crests of a height, on a block that lies askew."""
    rng = np.random.default_rng(seed)
    drawn = np.array(drawn_steps())
    place = np.arange(1.0, drawn.size + 1)
    shared = dict(zip(HEIGHTS, rng.normal(0, between, len(HEIGHTS)), strict=True))
    scatter = rng.normal(0, within, drawn.size) + [shared[h] for h in drawn]
    return CrestForm(place, drawn, drawn + offset + tilt * (place - place.mean()) + scatter)


@pytest.mark.parametrize(("within", "between"), [(0.015, 0.0), (0.01, 0.01), (0.005, 0.02)])
def test_scatter_and_offset_hold(within: float, between: float) -> None:
    """Both in 95 % of 400 blocks, each of which lies askew; 4.4 of 380 is the standard deviation, 3 of them
    are 366."""
    sigma, covered = np.hypot(within, between), np.zeros(2)
    for seed in range(400):
        result = crest_result(steps(seed, within, between, 0.02, 0.002))
        covered += [
            result.sigma.lower <= sigma <= result.sigma.upper,  # type: ignore[operator]
            result.offset.lower <= 0.02 <= result.offset.upper,  # type: ignore[operator]
        ]
    assert (covered >= 366).all(), covered


def test_a_block_that_lies_askew_changes_nothing() -> None:
    """0.1 mm from end to end; to rounding, for the tilt is found within each height."""
    level, askew = (crest_result(steps(1, 0.01, 0.01, 0.02, tilt)) for tilt in (0.0, 0.1 / 23))
    assert askew.sigma.value == pytest.approx(level.sigma.value, abs=1e-12)
    assert askew.offset.value == pytest.approx(level.offset.value, abs=1e-12)
    assert askew.worst == pytest.approx(level.worst, abs=1e-12)


def test_layers_are_in_the_scatter() -> None:
    """Heights that are rounded to layers of 0.2 mm are off by up to half of one: 0.2 / sqrt(12) on average,
    within a quarter, for eight heights are no uniform distribution."""
    drawn = np.array(drawn_steps())
    layered = np.round(drawn / 0.2) * 0.2
    result = crest_result(CrestForm(np.arange(1.0, drawn.size + 1), drawn, layered))
    assert result.sigma.value == pytest.approx(0.2 / np.sqrt(12), rel=0.25)
    assert result.worst <= 0.1 + 1e-9


def test_a_perfect_part_has_no_scatter() -> None:
    drawn = np.array(drawn_steps())
    result = crest_result(CrestForm(np.arange(1.0, drawn.size + 1), drawn, drawn + 0.01))
    assert result.sigma.value == pytest.approx(0.0, abs=1e-12)
    assert result.offset.value == pytest.approx(0.01)
