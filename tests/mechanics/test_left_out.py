"""What a model leaves out, against the model that computes it; free ends by ridge; swaying ridges."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import linalg

from skincad import load
from skincad.base import Estimate
from skincad.inputs import Design
from skincad.mechanics import (
    Answer,
    LeftOut,
    Request,
    added_compliance,
    force_changes,
    free_ends,
    mean_width,
    sway_amplification,
    sway_force,
    validity,
)
from skincad.mechanics import finite_strain as small_strain
from skincad.mechanics import friction as grip
from skincad.mechanics import left_out as bounds
from skincad.mechanics.models import corrected, finite_strain, friction, linear
from tests.mechanics.designs import filleted, yamada

CASES: dict[str, tuple[str, dict[str, dict[str, float]]]] = {
    "plain-ridges": ("plain-ridges", {}),
    "yamada-2002": ("yamada-2002", {}),
    "fingertip-soft": ("fingertip-soft", {}),
    "long": ("plain-ridges", {"skin": {"length": 48.0}}),
    "short": ("plain-ridges", {"skin": {"length": 6.0}}),
    "thin": ("plain-ridges", {"skin": {"thickness": 2.0}}),
    "five": ("plain-ridges", {"ridge": {"count": 5}}),
}
CALIBRATION = pytest.mark.evidence(subject="left out: {name}")
TOO_WIDE = 10.0  # times the change; at most 7 over the calibration at nu 0.499 (left_out.py)


def assert_bounds(bound: LeftOut, without: Answer, computed: Answer, force: float) -> None:
    for of, limit in (("all_touch_force", bound.threshold), ("approach", bound.approach)):
        left, right = getattr(without, of).value, getattr(computed, of).value
        change = abs(right / left - 1)
        assert change <= limit <= TOO_WIDE * change
    mean = force / len(without.ridge_force)
    pairs = zip(without.ridge_force, computed.ridge_force, strict=True)
    assert max(abs((a.value or 0.0) - (b.value or 0.0)) for a, b in pairs) <= bound.share * mean


@CALIBRATION
@pytest.mark.parametrize("name", CASES)
def test_free_ends_and_finite_strain_lie_within_their_bounds(name: str) -> None:
    template, change = CASES[name]
    design = load(template).with_(**change)
    request = Request(design.contact.force, 0.05)
    plane = linear.answer(design, request)
    ends, finite = corrected.answer(design, request, fine=plane), finite_strain.answer(design, request)
    assert_bounds(free_ends(design), plane, ends, request.force)
    assert_bounds(small_strain(design, plane, request.force), plane, finite, request.force)


# the calibration's, and of those that only judged it two random designs' worth (left_out.py)
GRIPPED: dict[str, tuple[str, dict[str, dict[str, float]]]] = {
    **CASES,
    "gripper-pad": ("gripper-pad", {}),
    "steep-fingertip": ("steep-fingertip", {}),
    "no crown": ("plain-ridges", {"ridge": {"crown": 0.0}}),
    "nu 0.3": ("plain-ridges", {"material": {"poisson_ratio": 0.3}}),
    "nu 0": ("plain-ridges", {"material": {"poisson_ratio": 0.0}}),
    "thick": ("plain-ridges", {"skin": {"thickness": 7.0}}),
}
FAST_GRIPPED = ("five", "nu 0")


@pytest.mark.parametrize(
    "name", [n if n in FAST_GRIPPED else pytest.param(n, marks=CALIBRATION) for n in GRIPPED]
)
@pytest.mark.parametrize("coefficient", [0.2, 1.0, 2.0])
def test_friction_lies_within_its_bound(name: str, coefficient: float) -> None:
    template, change = GRIPPED[name]
    design = load(template).with_(**change)
    force = design.contact.force
    presses = friction.solve(corrected.plain_pad(design), coefficient, force)
    without, with_it = presses.before, presses.after
    bound = grip(design, int((without.ridge_force > 0).sum()))
    assert abs((with_it.all_touch_force or 0.0) / (without.all_touch_force or 1.0) - 1) <= bound.threshold
    assert abs(with_it.approach / without.approach - 1) <= bound.approach
    mean = without.ridge_force.mean()
    assert abs(with_it.ridge_force - without.ridge_force).max() <= bound.share * mean


def test_the_bound_of_friction_is_not_a_blanket() -> None:
    """It is small where little is confined, and large where a wide thin pad is."""
    plain, wide = load("plain-ridges"), load("gripper-pad")
    loose = plain.with_(material={"poisson_ratio": 0.3})
    known = [grip(design, design.ridge.count) for design in (loose, plain, wide)]
    for of in ("threshold", "approach", "share"):
        loosest, usual, widest = (getattr(bound, of) for bound in known)
        assert loosest < usual < widest
    assert known[1].threshold < 0.07
    assert known[1].approach < 0.13
    assert (
        1
        < bounds.tip_constraint(loose, 9)
        < 1.1
        < bounds.tip_constraint(plain, 9)
        < 1.5
        < bounds.tip_constraint(wide, 21)
    )
    assert grip(plain, 3).approach < grip(plain, 9).approach  # few ridges confine little


def test_tips_that_stick_along_y_take_back_a_part_of_what_free_ends_do() -> None:
    """In three dimensions with full stick, against stick in x alone: F9 and approach of plain-ridges change
    by + 12 and - 9.3 %, 2 mm thick by + 10.9 and - 9.8 %."""
    for change in ({}, {"skin": {"thickness": 2.0}}):
        bound, ends = (of(load("plain-ridges").with_(**change)) for of in (bounds.friction_along, free_ends))
        assert 0.12 <= bound.threshold < 0.5 * ends.threshold
        assert 0.098 <= bound.approach < 0.5 * ends.approach
    named = bounds.left_out((bounds.ALONG,), load("plain-ridges"), ANSWER, 4.0)
    assert [part.effect for part in named] == ["friction along y"]


ANSWER = Answer(
    9, Estimate(3.0, 0.0, "N"), Estimate(0.1, 0.0, "mm"), (Estimate(4 / 9, 0.0, "N"),) * 9, 1, 0.0, {}
)


def five(**changes: dict[str, float]) -> Design:
    """A pad of none of the shapes that the constants were read off."""
    return filleted().with_(ridge={"count": 5}, skin={"width": 7.0, **changes.pop("skin", {})}, **changes)


@pytest.mark.slow
@pytest.mark.parametrize("skin", [{"thickness": 4.0, "length": 10.0}, {"thickness": 2.5, "length": 16.0}])
def test_ends_soften_as_in_three_dimensions(skin: dict[str, float]) -> None:
    design = five(skin=skin)
    solid, said = added_compliance(design), bounds.end_compliance(design)
    assert np.diag(said) == pytest.approx(np.diag(solid), rel=0.15)
    # ridges at opposite sides of a thick pad soften each other less than is said
    assert said == pytest.approx(solid, abs=0.16 * solid.max())


@pytest.mark.evidence(subject="left out: strips")
def test_strips_hold_ridges_along_y() -> None:
    design = yamada().with_(ridge={"count": 3}, skin={"width": 5.0, "thickness": 3.0})
    bonded, bare = (design.with_(contact={"film": film}) for film in ("bonded", "ignored"))
    middle = bounds.end_compliance(bonded)[1, 1], bounds.end_compliance(bare)[1, 1]
    wanted = added_compliance(bonded)[1, 1], added_compliance(bare)[1, 1]
    assert middle == pytest.approx(wanted, rel=0.25)
    assert middle[0] < 0.5 * middle[1]


def test_force_goes_from_the_middle_outwards_and_none_is_lost() -> None:
    shift = force_changes(five(), np.array([[1.0, 1.0, 1.0, 1.0, 1.0], [0.0, 1.0, 2.0, 1.0, 0.0], [0.0] * 5]))
    assert shift.sum(axis=1) == pytest.approx(0, abs=1e-12)
    assert shift[0, :3] == pytest.approx(shift[0, :1:-1])
    assert shift[0, 0] > 0 > shift[0, 2]
    assert not shift[1, [0, 4]].any()  # what does not touch bears nothing
    assert not shift[2].any()


def test_ends_count_by_the_square_of_poissons_ratio_and_of_the_length() -> None:
    usual = bounds.end_compliance(five())
    assert not bounds.end_compliance(five(material={"young_modulus": 0.8, "poisson_ratio": 0.0})).any()
    assert bounds.end_compliance(five(skin={"length": 24.0})) == pytest.approx(usual / 4)


STIFF = 1e9  # a spring that is as good as a clamp


def beam(root: float, top: float, elements: int = 40) -> float:
    """phi of the smallest load at which a beam of E I = h = 1 sways, from Hermite elements' stiffness."""
    size = 2 * (elements + 1)
    bends, tilts, h = np.zeros((size, size)), np.zeros((size, size)), 1 / elements
    stiffness = np.array([[12, 6 * h, -12, 6 * h], [6 * h, 4 * h**2, -6 * h, 2 * h**2]])
    stiffness = np.vstack([stiffness, -stiffness[0], [6 * h, 2 * h**2, -6 * h, 4 * h**2]]) / h**3
    tilt = np.array([[36, 3 * h, -36, 3 * h], [3 * h, 4 * h**2, -3 * h, -(h**2)]])
    tilt = np.vstack([tilt, -tilt[0], [3 * h, -(h**2), -3 * h, 4 * h**2]]) / (30 * h)
    for i in range(elements):
        part = slice(2 * i, 2 * i + 4)
        bends[part, part] += stiffness
        tilts[part, part] += tilt
    bends[1, 1] += root
    bends[-1, -1] += top
    free = np.arange(1, size)  # the root does not move
    load = linalg.eigvals(bends[np.ix_(free, free)], tilts[np.ix_(free, free)]).real
    return math.sqrt(load[load > 0].min())


@pytest.mark.parametrize("springs", [(2.7, 1.2), (0.3, 4.0), (50.0, 0.1)])
def test_the_column_between_springs_is_a_beams(springs: tuple[float, float]) -> None:
    """1e-6: 40 Hermite elements. Between clamps it is Euler's: 1e-8 is what springs of 1e9 give way."""
    assert bounds.sway_angle(*springs) == pytest.approx(beam(*springs), rel=1e-6)
    assert bounds.sway_angle(STIFF, STIFF) == pytest.approx(math.pi, rel=1e-8)
    assert bounds.sway_angle(STIFF, 1e-9) == pytest.approx(math.pi / 2, rel=1e-8)


def test_ends_that_turn_bear_less_than_clamps() -> None:
    """Unpressed, less than Haringx's column of validity.py, which is clamped and whose tip is level; pressed,
    a ridge is squatter."""
    design = yamada()
    assert 0.3 * validity.buckling_force(design) < sway_force(design, 0.0) < validity.buckling_force(design)
    assert sway_force(design, 0.6) > 1.1 * sway_force(design, 0.0)


def test_similar_ridges_sway_at_similar_forces() -> None:
    """E times two: twice the force; all of a section and the length times two: four times. To rounding."""
    design, modulus = yamada(), {"young_modulus": {"value": 1.6, "low": 1.3, "high": 1.9}}
    one = sway_force(design, 0.5)
    assert sway_force(design.with_(material=modulus), 1.0) == pytest.approx(2 * one, rel=1e-12)
    twice = {
        "height": 2 * design.ridge.height,
        "root_width": 2 * design.ridge.root_width,
        "tip_width": 2 * design.ridge.tip_width,
        "pitch": 2 * design.ridge.pitch,
    }
    larger = design.with_(ridge=twice, skin={"length": 2 * design.skin.length, "width": 22.0})
    assert mean_width(larger) == 2 * mean_width(design)
    assert sway_force(larger, 2.0) == pytest.approx(4 * one, rel=1e-12)


def test_a_ridge_that_does_not_stand_is_told_as_the_most() -> None:
    design = yamada()
    assert sway_amplification(design, 0.0, 2.0) == 0.0
    critical = sway_force(design, 0.5)
    assert sway_amplification(design, 0.5, 2.0) == pytest.approx(0.5 / (critical - 0.5), rel=1e-12)
    assert sway_amplification(design, 0.5, 0.1) == 0.1
    assert sway_amplification(design, 100.0, 2.0) == 2.0
