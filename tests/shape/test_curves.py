import math

import numpy as np
import pytest

from skincad.shape import Point, Segment, area, flipped, length, polygon, rectangle
from skincad.shape.curves import moments, offset


def circle(radius: float, x: float = 0.0, z: float = 0.0) -> tuple[Segment, ...]:
    """Four quarter arcs, counterclockwise."""
    corners = [Point(x + radius * c, z + radius * s) for c, s in ((1, 0), (0, 1), (-1, 0), (0, -1))]
    bulge = math.tan(math.pi / 8)
    return tuple(Segment(corners[i], corners[(i + 1) % 4], bulge) for i in range(4))


def test_circle_has_its_area_perimeter_and_centroid() -> None:
    ring = circle(2.5, 3.0, -4.0)
    total, mx, mz = moments(ring)
    assert total == pytest.approx(math.pi * 2.5**2, rel=1e-14)  # rounding of a few sums
    assert (mx / total, mz / total) == pytest.approx((3.0, -4.0), rel=1e-14)
    assert length(ring) == pytest.approx(5 * math.pi, rel=1e-14)


def test_half_disk_has_its_centroid() -> None:
    quarter = circle(2.0)[:2]
    half = (*quarter, Segment(quarter[-1].end, quarter[0].start))
    total, mx, mz = moments(half)
    assert mx == pytest.approx(0.0, abs=1e-13)
    assert mz / total == pytest.approx(4 * 2.0 / (3 * math.pi), rel=1e-13)  # rounding


@pytest.mark.parametrize("radius", [1.0, 1e3, 1e6, 1e9])
def test_circular_segment_keeps_its_digits_however_flat(radius: float) -> None:
    half = math.asin(0.5 / radius)  # chord 1 mm
    arc = Segment(Point(-0.5, 0.0), Point(0.5, 0.0), math.tan(half / 2))
    closed = (arc, Segment(Point(0.5, 0.0), Point(-0.5, 0.0)))
    flat = 1 / (12 * radius) * (1 + 3 / (40 * radius**2))  # series of the segment's area in chord / radius
    exact = radius**2 * (half - math.sin(half) * math.cos(half)) if radius < 10 else flat
    # closed form cancels at R = 1, the series stops after two terms
    assert area(closed) == pytest.approx(exact, rel=1e-11)
    assert arc.radius == pytest.approx(radius, rel=1e-9)  # the tangent of half / 2 is that well conditioned


def test_points_of_an_arc_lie_on_its_circle() -> None:
    arc = circle(2.0)[0]
    points = arc.points(np.linspace(0, 1, 9))
    assert np.hypot(*points.T) == pytest.approx(np.full(9, 2.0), abs=1e-14)
    assert arc.point(0.5) == pytest.approx((math.sqrt(2), math.sqrt(2)), abs=1e-14)


@pytest.mark.parametrize("tolerance", [1e-2, 1e-4, 1e-6])
def test_polygon_keeps_within_its_tolerance_and_uses_it(tolerance: float) -> None:
    points = polygon(circle(1.0), tolerance)
    middles = (points + np.roll(points, -1, axis=0)) / 2
    sagitta = 1 - np.hypot(*middles.T).min()
    assert sagitta <= tolerance * (1 + 1e-9)  # rounding
    assert sagitta > tolerance / 4  # no more than twice as many chords as are needed


def test_reversing_and_flipping_keep_the_area() -> None:
    ring = circle(1.5, 0.2, 0.7)
    assert area(flipped(ring)) == pytest.approx(area(ring), rel=1e-14)
    assert area(tuple(s.reversed() for s in reversed(ring))) == pytest.approx(-area(ring), rel=1e-14)


@pytest.mark.parametrize("distance", [0.3, -0.3])
def test_offset_of_a_rectangle_is_rounded_outward_and_sharp_inward(distance: float) -> None:
    (grown,) = offset(rectangle(0.0, 4.0, 0.0, 2.0), distance, 1e-4)
    x, z = grown.T
    shoelace = abs(float(np.sum(x * np.roll(z, -1) - z * np.roll(x, -1)))) / 2
    corners = math.pi * distance**2 if distance > 0 else 4 * distance**2
    exact = 8.0 + 12.0 * distance + corners  # Steiner's formula; inward it keeps square corners
    assert shoelace == pytest.approx(exact, abs=12 * 1e-4)  # perimeter x chord tolerance


def test_a_polygon_has_a_loops_corners_to_the_last_digit() -> None:
    """(4 - 14.6) / 2 - (-14.6 - 4) / 2 is 4 + 1e-15: a bore that ends at 4 would stay closed by a film."""
    block = rectangle(-26.519999999999996, 26.52, -14.6, 4.0)
    assert {tuple(p) for p in polygon(block, 1e-3)} == {tuple(s.start) for s in block}


@pytest.mark.parametrize("heading", np.linspace(0.1, 6.2, 12))
@pytest.mark.parametrize("bulge", [0.15, 0.9])
def test_the_top_is_the_highest_of_many_points(heading: float, bulge: float) -> None:
    start = Point(0.3, -0.2)
    arc = Segment(start, Point(start.x + 2 * math.cos(heading), start.z + 2 * math.sin(heading)), bulge)
    seen = arc.points(np.linspace(0.0, 1.0, 20001))[:, 1].max()
    # between two of the points the arc rises by (its angle between them)^2 R / 8, below 1e-8 mm
    assert arc.top == pytest.approx(seen, abs=1e-8)


@pytest.mark.parametrize("sweep", [0.02, 1.0, -2.5, 6.0])
@pytest.mark.parametrize("radius", [0.05, 60.0, 1e6])
@pytest.mark.parametrize("tolerance", [1e-1, 1e-3, 1e-5])
def test_an_arc_has_as_few_chords_as_keep_the_tolerance(
    sweep: float, radius: float, tolerance: float
) -> None:
    """A chord over an angle a lies up to R (1 - cos(a / 2)) off its arc."""
    reach = 2 * radius * abs(math.sin(sweep / 2))
    arc = Segment(Point(0.0, 0.0), Point(reach, 0.0), math.tan(sweep / 4))
    assert arc.radius == pytest.approx(radius, rel=1e-9)
    count = arc.pieces(tolerance)
    most = tolerance * (1 + 1e-6)  # rounding of a radius by its chord
    assert 2 * radius * math.sin(sweep / 4 / count) ** 2 <= most
    assert count == 1 or 2 * radius * math.sin(sweep / 4 / (count - 1)) ** 2 > tolerance * (1 - 1e-6)
    assert Segment(arc.start, arc.end).pieces(tolerance) == 1
