"""A loop turned fully about any axis: its volume by Pappus, by the CAD kernel and by its mesh."""

from __future__ import annotations

import math

import pytest

from skincad.fabrication import manifold
from skincad.shape import Loop, Point, Segment, loop, rectangle
from skincad.solids import Part, PartRole, TurnedBody, Vector, unchecked_solid
from skincad.solids.plan import moved

CONE = loop([Point(0.0, 0.0), Point(2.0, 0.0), Point(0.0, 3.0)])
HEMISPHERE = (
    Segment(Point(0.0, 0.0), Point(1.5, 0.0)),
    Segment(Point(1.5, 0.0), Point(0.0, 1.5), math.tan(math.pi / 8)),
    Segment(Point(0.0, 1.5), Point(0.0, 0.0)),
)
VOLUMES = {CONE: 4 * math.pi, HEMISPHERE: 2 / 3 * math.pi * 1.5**3, rectangle(2, 3, 0, 1): 5 * math.pi}
WAYS: tuple[Vector, ...] = ((0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (0.36, 0.48, 0.8), (0.0, 1.0, 0.0))


@pytest.mark.parametrize("direction", WAYS)
@pytest.mark.parametrize("outline", VOLUMES)
def test_volume_is_that_of_the_handbook(outline: Loop, direction: Vector) -> None:
    part = Part("turned", PartRole.SKIN, TurnedBody(outline, (1.0, 2.0, 3.0), direction))
    exact = VOLUMES[outline]
    assert part.volume == pytest.approx(exact, rel=1e-14)
    shape = unchecked_solid(part)
    assert shape.isValid()
    assert shape.Volume() == pytest.approx(exact, rel=1e-12)
    coarse, fine = (exact - manifold(part, chord).volume() for chord in (1e-3, 1e-4))
    # chords within c of the surface take at most c times the area, here below 60 mm2
    assert 0 < fine < 60 * 1e-4
    assert fine < coarse / 5  # second order in the chord's length, first in its rise


def test_its_summit_and_what_is_buried() -> None:
    body = TurnedBody(CONE, (1.0, 2.0, 3.0), (0.6, 0.0, 0.8), buried=1.0)
    box = unchecked_solid(Part("turned", PartRole.SKIN, moved(body, 5.0))).BoundingBox()
    # the box is exact to the kernel's gap round it
    assert (box.xmax, box.zmax) == pytest.approx((6 + 0.6 * 3, 3 + 0.8 * 3), abs=1e-6)
    assert body.volume == pytest.approx(4 * math.pi - 1, rel=1e-14)
