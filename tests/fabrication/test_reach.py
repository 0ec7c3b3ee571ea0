"""What a tool leaves, against triangles and circles by hand."""

import math

import numpy as np
import pytest

from skincad.fabrication import left_standing
from skincad.fabrication.machine_rules import ERROR, corner
from skincad.shape import Loop, Point, Segment, loop

R = 0.25


def grooved(points: list[tuple[float, float]]) -> Loop:
    """A block below z = 0 with this groove, from left to right, in its top."""
    rim = [(-5.0, 0.0), (-5.0, -5.0), (5.0, -5.0), (5.0, 0.0)]
    return loop([Point(*p) for p in [*rim, *reversed(points)]])


@pytest.mark.parametrize("angle_deg", [50.0, 60.0, 90.0, 120.0, 150.0])
def test_a_v_groove_keeps_its_bisector(angle_deg: float) -> None:
    half = math.radians(angle_deg / 2)
    depth = 1.0
    wide = depth * math.tan(half)
    left = left_standing(grooved([(-wide, 0.0), (0.0, -depth), (wide, 0.0)]), R)
    assert max(left) == pytest.approx(R * (1 / math.sin(half) - 1), abs=ERROR)
    assert corner(R, 2 * half) == pytest.approx(R * (1 / math.sin(half) - 1), rel=1e-15)


def test_a_groove_too_narrow_is_left_but_for_what_the_ball_dips_in() -> None:
    """The ball rests on the mouth's edges, its centre c above it: from a bottom corner its surface is at
    sqrt((w / 2)^2 + (D + c)^2) - r."""
    wide, depth = 0.3, 1.0
    centre = math.sqrt(R**2 - wide**2 / 4)
    left = left_standing(
        grooved([(-wide / 2, 0.0), (-wide / 2, -depth), (wide / 2, -depth), (wide / 2, 0.0)]), R
    )
    assert max(left) == pytest.approx(math.hypot(wide / 2, depth + centre) - R, abs=ERROR)


def test_a_wide_groove_keeps_only_its_right_corners() -> None:
    left = left_standing(grooved([(-1.0, 0.0), (-1.0, -1.0), (1.0, -1.0), (1.0, 0.0)]), R)
    assert max(left) == pytest.approx((math.sqrt(2) - 1) * R, abs=ERROR)
    assert min(left) < ERROR


@pytest.mark.parametrize("fillet", [0.1, 0.2, 0.25, 0.4])
def test_a_fillet_is_cut_as_far_as_the_tool_is_smaller(fillet: float) -> None:
    """Two concentric-cornered circles in a right angle: (sqrt 2 - 1) (r - fillet) on the bisector."""
    bulge = math.tan(math.pi / 8)
    corners = [(5.0, -5.0), (5.0, 0.0), (1.0, 0.0), (1.0, -1.0 + fillet), (1.0 - fillet, -1.0)]
    corners += [(-x, z) for x, z in reversed(corners)]
    points = [Point(*p) for p in corners]
    block = tuple(
        Segment(a, b, -bulge if abs(a.x - b.x) == pytest.approx(fillet) else 0.0)
        for a, b in zip(points, [*points[1:], points[0]], strict=True)
    )
    assert sum(s.bulge != 0 for s in block) == 2
    expected = max(0.0, (math.sqrt(2) - 1) * (R - fillet))
    assert max(left_standing(block, R)) == pytest.approx(expected, abs=ERROR)


def test_from_above_nothing_under_a_ledge_is_cut() -> None:
    """A groove 4 wide below a mouth 2 wide, all of it beyond the tool's size: beside the mouth 1 mm stays,
    on the floor as far as the ball's own corner with it."""
    shape = grooved([(-1, 0), (-1, -1), (-2, -1), (-2, -3), (2, -3), (2, -1), (1, -1), (1, 0)])
    free = left_standing(shape, R)
    assert max(free) == pytest.approx((math.sqrt(2) - 1) * R, abs=ERROR)
    above = left_standing(shape, R, from_above=True)
    assert max(above) == pytest.approx(math.hypot(1 + R, R) - R, abs=ERROR)  # floor corner to the ball's


def test_a_larger_tool_leaves_no_less() -> None:
    shape = grooved([(-0.4, 0.0), (-0.3, -0.7), (0.3, -0.7), (0.4, 0.0)])
    left = np.array([left_standing(shape, r) for r in (0.05, 0.1, 0.2, 0.3, 0.5)])
    assert (np.diff(left, axis=0) >= -ERROR).all()
    assert left[-1].max() > left[0].max() + 0.1
