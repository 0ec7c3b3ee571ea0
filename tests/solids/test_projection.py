"""Hidden-line projections against closed forms."""

from __future__ import annotations

import math

import cadquery as cq
import pytest

from skincad.shape import Point, loop, polygon
from skincad.solids import Arc, Polyline, Stroke, View, extent, outlined
from skincad.solids.occ import projection

PLAN, FRONT = View((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)), View((1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
PLACE = 1e-6  # mm, the kernel's own tolerance is 1e-7


def plate(depth: float | None) -> cq.Solid:
    """A block of 10 x 6 x 4 about the origin with a bore of 2 from above."""
    return cq.Workplane().box(10, 6, 4).faces(">Z").workplane().hole(2.0, depth).val()


def lines(strokes: tuple[Stroke, ...]) -> set[tuple[tuple[float, float], ...]]:
    return {
        tuple(sorted((round(x, 6) + 0.0, round(y, 6) + 0.0) for x, y in stroke.points))
        for stroke in strokes
        if isinstance(stroke, Polyline)
    }


def test_a_bored_block_from_above_is_a_rectangle_and_a_circle() -> None:
    seen = projection(plate(None), PLAN)
    corners = [(-5.0, -3.0), (-5.0, 3.0), (5.0, 3.0), (5.0, -3.0)]
    sides = {tuple(sorted((a, b))) for a, b in zip(corners, [*corners[1:], corners[0]], strict=True)}
    assert lines(seen.visible) == sides
    (circle,) = (stroke for stroke in seen.visible if isinstance(stroke, Arc))
    assert circle.whole
    assert circle.centre == pytest.approx((0.0, 0.0), abs=PLACE)
    assert circle.radius == pytest.approx(1.0, abs=PLACE)
    assert seen.hidden == ()


def test_a_blind_bore_from_the_front_is_hidden_to_its_depth() -> None:
    seen = projection(plate(3.0), FRONT)
    assert {((-1.0, -1.0), (-1.0, 2.0)), ((1.0, -1.0), (1.0, 2.0)), ((-1.0, -1.0), (1.0, -1.0))} <= lines(
        seen.hidden
    )
    assert len(lines(seen.visible)) == 4
    assert all(abs(x) <= 1.0 for line in lines(seen.hidden) for x, _ in line)


def test_from_below_a_blind_bore_is_hidden_and_a_through_one_is_not() -> None:
    below = View((1.0, 0.0, 0.0), (0.0, -1.0, 0.0))
    assert below.towards == (0.0, 0.0, -1.0)
    blind, through = (projection(plate(depth), below) for depth in (3.0, None))
    assert [isinstance(s, Arc) for s in blind.visible].count(True) == 0
    assert [isinstance(s, Arc) for s in blind.hidden].count(True) == 1
    assert [isinstance(s, Arc) for s in through.visible].count(True) == 1


def test_a_turned_view_is_that_of_the_turned_solid() -> None:
    """Seen along its own axes from its own origin, a solid that was turned and moved is as it was."""
    turned = plate(None).rotate(cq.Vector(0, 0, 0), cq.Vector(1, 0, 0), 30).translate(cq.Vector(1, 2, 3))
    c, s = math.cos(math.radians(30)), math.sin(math.radians(30))
    seen = projection(turned, View((1.0, 0.0, 0.0), (0.0, c, s), (1.0, 2.0, 3.0)))
    assert lines(seen.visible) == lines(projection(plate(None), PLAN).visible)


@pytest.mark.parametrize("bulge", [0.4, -0.2])
def test_a_loop_with_an_arc_keeps_its_ends_and_extent(bulge: float) -> None:
    from dataclasses import replace

    first, *rest = loop([Point(0.0, 0.0), Point(4.0, 0.0), Point(4.0, 3.0), Point(0.0, 3.0)])
    outline = (replace(first, bulge=bulge), *rest)
    strokes = outlined(outline)
    arc = strokes[0]
    assert isinstance(arc, Arc)
    ends = sorted([arc.at(0.0), arc.at(1.0)])
    assert ends[0] == pytest.approx((0.0, 0.0), abs=1e-12)
    assert ends[1] == pytest.approx((4.0, 0.0), abs=1e-12)
    assert arc.at(0.5)[1] == pytest.approx(-bulge * 2.0, abs=1e-12)  # half the chord times the bulge
    points = polygon(outline, 1e-6)
    assert extent(strokes)[0] == pytest.approx(points.min(axis=0), abs=1e-5)
