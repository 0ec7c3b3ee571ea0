"""The split of the end plates: a circle under the slots, notches from it round each slot, refusals."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
import shapely

import skincad
from skincad.base import InputError
from skincad.inputs import Design
from skincad.shape import Point, Segment, SensorPlace, area, polygon, section
from skincad.solids import notch_rise
from skincad.solids.mold import mold
from skincad.solids.split import closed_edge, path, split_edges, split_height

HALF = 20.0  # mm, of the end plate
MEET = r"^mold.slit_clearance: neighbouring notches of the comb meet"
DESIGNS = {
    "upright": ("yamada-2002", {}),
    "tilted": ("yamada-2002-tilted", {}),
    "outward": ("yamada-2002-tilted", {"slot": {"tilt": -20.0, "offset": 0.12}}),
    "wide gaps": ("yamada-2002", {"mold": {"slit_clearance": 0.03}}),
    "steep": ("yamada-2002", {"skin": {"curvature_radius": 14.0}}),
    "cast in": ("cast-in", {}),
    "bent": ("yamada-2002", {"skin": {"curvature_radius_y": 60.0}}),
    "bent and tilted": ("yamada-2002-tilted", {"skin": {"curvature_radius_y": 90.0}}),
}


def design_of(name: str) -> Design:
    template, change = DESIGNS[name]
    return skincad.load(template).with_(**change)


def over_base(design: Design, x: float, z: float) -> float:
    """Distance of a point from the base circle, outward, mm."""
    radius = design.skin.curvature_radius
    return math.hypot(x, radius + z - design.skin.thickness) - radius


def rise(design: Design, *slots: SensorPlace) -> float:
    """By how much an arc through the lowest corner of slots, square to the plate, rises through the plate."""
    bent, gap = design.skin.curvature_radius_y, design.mold.slit_clearance
    if bent is None:
        return 0.0
    arm = bent - design.skin.thickness + min(p.start.z for s in slots for p in s.loop(grown=gap))
    return arm - math.sqrt(arm**2 - design.mold.end_plate**2)


@pytest.mark.parametrize("name", DESIGNS)
def test_the_split_is_a_circle_that_just_clears_the_slits(name: str) -> None:
    design = design_of(name)
    shape, radius = section(design), design.skin.curvature_radius
    height, level, angle = split_height(design, shape)
    assert notch_rise(design, shape.slots) == pytest.approx(rise(design, *shape.slots), abs=1e-12)
    corners = [p.start for s in shape.slots for p in s.loop(grown=design.mold.slit_clearance)]
    above = [over_base(design, *corner) for corner in corners]
    assert min(above) - height == pytest.approx(rise(design, *shape.slots), abs=1e-11)
    assert over_base(design, (radius + height) * math.sin(angle), level) == pytest.approx(height, abs=1e-11)
    outermost = max(math.atan2(x, radius + z - design.skin.thickness) for x, z in corners)
    assert outermost < angle < outermost + 0.5 / radius  # the arc ends beside the last mouth


def test_without_slots_it_lies_where_the_base_circle_is_at_the_last_ridge(yamada: Design) -> None:
    bare = yamada.with_(slot=None, film=None, contact={"film": None})
    height, level, angle = split_height(bare, section(bare))
    assert (height, angle) == (0.0, 0.0)
    lean = 4 * bare.ridge.pitch / bare.skin.curvature_radius
    fall = bare.skin.curvature_radius * (1 - math.cos(lean))
    assert level == pytest.approx(bare.skin.thickness - fall, abs=1e-12)


@pytest.mark.parametrize("name", DESIGNS)
def test_notches_lead_from_the_circle_round_each_slot_with_the_clearance(name: str) -> None:
    design = design_of(name)
    shape, gap = section(design), design.mold.slit_clearance
    height, level, angle = split_height(design, shape)
    comb, keeper = split_edges(design, shape, HALF)
    for edge in (comb, keeper):
        assert (edge[0].start, edge[-1].end) == (Point(-HALF, level), Point(HALF, level))
        assert all(one.end == other.start for one, other in pairwise(edge))
    reach = (design.skin.curvature_radius + height) * math.sin(angle)
    for segment in keeper:
        for x, z in segment.points(np.linspace(0, 1, 5)):
            on_arc = abs(x) <= reach + 1e-9
            assert over_base(design, x, z) == pytest.approx(height, abs=1e-9) if on_arc else z == level
    ends = [closed_edge(comb, 10.0), closed_edge([s.reversed() for s in keeper[::-1]], -5.0)]
    solid = shapely.union_all([shapely.Polygon(polygon(end, 1e-9)) for end in ends])
    left = shapely.box(-HALF, -5.0, HALF, 10.0).difference(solid.buffer(1e-7))
    notches = sorted(left.geoms, key=lambda notch: notch.centroid.x)
    slots = sorted(shape.slots, key=lambda s: s.at(0.0, -s.depth / 2).x)
    for notch, slot in zip(notches, slots, strict=True):
        points = np.array(notch.exterior.coords) - slot.centre
        side, along = points @ slot.normal, points @ slot.direction
        cast_in = design.mold.method == "cast-in"  # a strip stands on the notch's bottom
        assert along.max() == pytest.approx(slot.depth / 2 + (0.0 if cast_in else gap), abs=1e-6)
        shift = rise(design, slot) * slot.direction.x  # what rises straight goes aside in a leaning slot
        assert side.max() == pytest.approx(slot.thickness / 2 + gap + max(shift, 0.0), abs=1e-6)
        assert side.min() == pytest.approx(-slot.thickness / 2 - gap + min(shift, 0.0), abs=1e-6)
        low = sorted(notch.exterior.coords, key=lambda p: over_base(design, *p))[0]
        assert over_base(design, *low) == pytest.approx(height, abs=1e-5)
        assert along.min() < -slot.depth / 2  # the slit is open towards the keeper


@pytest.mark.parametrize("clearance", [0.2, 0.16])
def test_notches_that_meet_are_refused(yamada: Design, clearance: float) -> None:
    wide = yamada.with_(mold={"slit_clearance": clearance})
    with pytest.raises(InputError, match=MEET):
        split_edges(wide, section(wide), HALF)


def test_a_slot_that_turns_along_the_circle_has_no_mouth() -> None:
    flat = skincad.load("yamada-2002-tilted").with_(ridge={"count": 1}, slot={"tilt": 80.0, "elevation": 0.1})
    steep = flat.with_(skin={"curvature_radius": 6.0, "width": 3.0})
    with pytest.raises(InputError, match=r"^slot.tilt: turns its notch so far"):
        split_edges(steep, section(steep), HALF)
    # 0.16 + 0.16 mm apart, 0.2 + 2 x 0.06 wide: rounding once left a tooth of 1e-17 mm between them
    ridge = {"count": 24, "pitch": 1.0, "root_width": 0.75, "tip_width": 0.5, "height": 0.5}
    close = skincad.load("home-printer").with_(
        skin={"curvature_radius": 1280 / 3, "thickness": 4.0},
        ridge={**ridge, "tip_fillet": 0.05, "root_fillet": 0.08, "crown": 0.03},
        slot={"thickness": 0.2, "depth": 0.25, "offset": 0.16, "elevation": 0.05},
        mold={"slit_clearance": 0.06},
    )
    with pytest.raises(InputError, match=MEET):
        mold(close)


def test_an_edge_is_closed_over_a_level_and_a_path_has_no_empty_steps() -> None:
    a, b, c = Point(-2.0, 1.0), Point(0.0, 2.0), Point(2.0, 1.0)
    edge = [Segment(a, b), Segment(b, c)]
    above, below = closed_edge(edge, 5.0), closed_edge([s.reversed() for s in edge[::-1]], -1.0)
    assert area(above) == pytest.approx(4 * 4 - 2, rel=1e-12)
    assert area(below) == pytest.approx(4 * 2 + 2, rel=1e-12)
    assert above[-1].end == a
    assert path([a, a, b, b, c]) == edge
