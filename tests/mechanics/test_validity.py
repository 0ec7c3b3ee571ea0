"""Where the models end, by hand: flat, strained, tipped over, too steep; and what each end says."""

from __future__ import annotations

import math

import pytest

from skincad import load
from skincad.base import Estimate, InputError
from skincad.inputs import Design
from skincad.mechanics import (
    LARGEST_STRAIN,
    Answer,
    Limits,
    limits,
    refuse_crushed,
    ridge_strain,
    small_strain_violation,
    tipping,
    validity,
)


@pytest.fixture(scope="module")
def design() -> Design:
    """Ridges 0.8 mm wide in the mean and 12 mm long, of 0.8 MPa and nu 0.4."""
    ridge = {"root_width": 0.9, "tip_width": 0.7, "height": 0.6}
    material = {"name": None, "young_modulus": 0.8, "poisson_ratio": 0.4}
    return load("plain-ridges").with_(
        ridge={**ridge, "root_fillet": 0.0}, skin={"length": 12.0, "thickness": 4.0}, material=material
    )


def answer(threshold: float | None, *forces: float) -> Answer:
    shares = tuple(Estimate(f, 0.0, "N") for f in forces)
    return Answer(
        len(forces), Estimate(threshold, 0.0, "N"), Estimate(0.1, 0.0, "mm"), shares, 1, 0.0, {"total": 1.0}
    )


def test_a_force_on_a_ridge_is_strained_by_its_mean_width_and_length(design: Design) -> None:
    ends = limits(design)
    assert ends.height == pytest.approx(4.6)
    assert ends.squeeze == pytest.approx(0.8 / (1 - 0.4**2) * 0.8 * 12.0, rel=1e-12)
    # half the angle: 2 G = E / (1 + nu)
    assert ends.shear == pytest.approx(0.8 / (1 + 0.4) * 0.8 * 12.0, rel=1e-12)
    assert ends.strain(0.1 * ends.squeeze) == pytest.approx(0.1)
    assert ends.strain(0.1 * ends.squeeze, 0.2 * ends.shear) == pytest.approx(0.2)
    assert ridge_strain(design, answer(1.0, 0.1, 0.3, 0.2)) == pytest.approx(0.3 / ends.squeeze)


@pytest.mark.parametrize("height", [0.3, 0.6, 1.7])
def test_a_ridge_tips_over_as_a_column_that_shears(design: Design, height: float) -> None:
    """Haringx' condition, P (1 + P / (G A)) = Euler's force between two clamps of which one slides."""
    ridge = design.with_(ridge={"height": height})
    euler = math.pi**2 * 0.8 / (1 - 0.4**2) * 12.0 * 0.8**3 / 12 / height**2
    shear, tips = 5 / 6 * 0.8 / 2.8 * 0.8 * 12.0, validity.buckling_force(ridge)
    assert tips * (1 + tips / shear) == pytest.approx(euler, rel=1e-12)
    assert tipping(ridge, answer(1.0, 0.1, 0.3)) == pytest.approx(0.3 / tips)


def test_strained_is_what_bears_much_or_nearly_tips_over(design: Design) -> None:
    squeeze, slender = limits(design).squeeze, design.with_(ridge={"height": 4.0})
    assert not validity.exceeds_small_strain(design, answer(1.0, 0.05, 0.099 * squeeze))
    assert validity.exceeds_small_strain(design, answer(1.0, 0.05, 0.101 * squeeze))
    tips = validity.buckling_force(slender)
    assert tips < 0.1 * squeeze
    assert not validity.exceeds_small_strain(slender, answer(1.0, 0.49 * tips))
    assert validity.exceeds_small_strain(slender, answer(1.0, 0.51 * tips))
    assert (
        "51% of the force at which it tips over"
        in validity.strain_warnings(slender, answer(1.0, 0.51 * tips))[0]
    )


def test_beyond_its_range_a_model_says_why() -> None:
    ends = Limits(4.6, squeeze=10.0, shear=5.0, buckling=2.5)
    assert ends.largest == 2.5
    assert Limits(4.6, squeeze=5.0, buckling=2.5).largest == pytest.approx(LARGEST_STRAIN * 5.0)
    assert ends.overload_reason(2.5) == ""
    assert ends.overload_reason(2.6) == "a ridge tips over at 2.5 N and would carry 2.6 N"
    assert ends.overload_reason(4.0) == "the ridges' nominal strain is 0.4; the model's range ends at 0.3"
    assert ends.overload_reason(2.5, 1.5) == ""  # as much as may be, across
    weak = Limits(4.6, squeeze=10.0, shear=0.1)  # what does not press across does not shear
    assert (weak.overload_reason(2.5), weak.strain(2.5)) == ("", 0.25)
    assert ends.overload_reason(0.0, 2.0).startswith("the ridges' nominal strain is 0.4")
    assert ends.crushed_reason(4.59) == ""
    assert ends.crushed_reason(4.6) == "pressed flat: an approach of 4.6 mm into 4.6 mm of skin and ridges"
    large = Limits(4.6)
    assert (large.overload_reason(1e9, 1e9), large.strain(1e9, 1e9), large.largest) == ("", 0.0, math.inf)


def test_a_skin_pressed_flat_is_refused_with_the_force_that_would_do_so(design: Design) -> None:
    refuse_crushed(design, 8.0, "linear", 4.599)
    with pytest.raises(InputError, match=r"below about 4 N, which press the skin flat in the linear model"):
        refuse_crushed(design, 8.0, "linear", 9.2)
    with pytest.raises(InputError, match="below about 8 N"):
        refuse_crushed(design, 8.0, "linear", 4.6 + 1e-12)


def test_the_verdict_is_judged_where_all_begin_to_touch_and_the_warning_at_the_force(design: Design) -> None:
    """A force of twice the threshold strains the ridges half as much there."""
    squeeze = limits(design).squeeze
    half = 0.5 * squeeze  # on the most loaded ridge
    assert small_strain_violation(design, 8.0, answer(4.0, 0.1, half)) == ""
    assert "strain is 0.5" in small_strain_violation(design, 8.0, answer(None, 0.1, half))
    assert "strain is 0.5" in small_strain_violation(design, 8.0, answer(12.0, 0.1, half))
    assert "strain is 0.4" in small_strain_violation(design, 8.0, answer(6.4, 0.1, half))
    assert validity.strain_warnings(design, answer(4.0, validity.SMALL_STRAIN * squeeze * (1 - 1e-9))) == ()
    assert validity.strain_warnings(design, answer(4.0, 0.1, half)) == (
        "nominal ridge strain 0.5 is beyond the small-strain range (0.1)",
        "the most loaded ridge bears 102% of the force at which it tips over",
    )


def plate(design: Design, **values: object) -> Design:
    return design.with_(contact={"plate": values}, skin={"width": 11.0})


def test_a_plates_slope_is_told_with_what_it_leaves_out_and_refused_where_too_steep(design: Design) -> None:
    assert validity.slope_warnings(design) == ()
    assert validity.slope_warnings(plate(design, shape="step", position=0.0, height=0.1)) == ()
    (warning,) = validity.slope_warnings(plate(design, shape="cylinder", radius=55.0))
    # half of 11 mm by 55 mm; half its square is 0.5 %
    assert warning == "contact is taken as vertical: with slopes of up to 0.1 that is 0.5% off"
    (off_centre,) = validity.slope_warnings(plate(design, shape="cylinder", radius=55.0, position=-5.5))
    assert off_centre == "contact is taken as vertical: with slopes of up to 0.2 that is 2.0% off"
    (tilted,) = validity.slope_warnings(plate(design, shape="tilted", tilt=-math.degrees(math.atan(0.08))))
    assert tilted == "contact is taken as vertical: with slopes of up to 0.08 that is 0.3% off"
    edge = 5.5 / validity.LARGEST_SLOPE
    validity.slope_warnings(plate(design, shape="cylinder", radius=edge * 1.0001))
    with pytest.raises(
        InputError, match=r"contact\.plate: must not slope by more than 0\.35 within the skin"
    ):
        validity.slope_warnings(plate(design, shape="cylinder", radius=edge * 0.9999))
