"""The coupon's parts against hand calculation, the kernel and their own meshes."""

from __future__ import annotations

import math
from collections import Counter
from itertools import pairwise

import numpy as np
import pytest

from skincad.fabrication import laid, mesh, on_end, overhang
from skincad.fabrication.coupon import coupon
from skincad.inputs import PROCESSES, Process, load_design, processes
from skincad.shape import curves
from skincad.solids import (
    BAR,
    BARS,
    HEIGHTS,
    NOTCH_DEPTH,
    NOTCH_PITCH,
    NOTCHES,
    REPEATS,
    Part,
    PartRole,
    coupon_parts,
    drawn_notches,
    drawn_steps,
    poured_volumes,
    solid,
    volume,
)
from skincad.solids.coupon import bar_outline
from skincad.solids.skin import cast_skin
from tests.designs import RIDGED

PARTS = {part.name: part for part in coupon("sla").parts}


def test_the_ladder_is_what_was_asked_for() -> None:
    """0.06 to 0.30 mm in steps of 0.02; a wire passes all of it, a mill of 0.5 mm none."""
    assert (NOTCHES[0], NOTCHES[-1], len(NOTCHES)) == (0.06, 0.30, 13)
    assert all(b - a == pytest.approx(0.02) for a, b in pairwise(NOTCHES))
    known = processes()
    assert drawn_notches(known["sla"]) == drawn_notches(known["edm"]) == NOTCHES
    assert drawn_notches(known["cnc"]) == ()
    assert [p.name for p in coupon("cnc").parts] == ["crest-steps", "tensile-mold", "pad-mold"]
    assert drawn_notches(Process(tool_radius=0.05, spark_gap=0.01))[0] == 0.12
    # A plate of 49.39 x 8 x 4 mm, less notches, two nicks of 1 mm2 and a corner of 4.5 mm2
    width = 13 * 3.03 + 10
    area = width * 8 - 0.75 * sum(NOTCHES) - 2 * 1.0 - 4.5
    assert PARTS["notch-ladder"].volume == pytest.approx(4 * area, rel=1e-12)
    # notches meet pixels of 0.05 mm at different places
    places = {round(i * NOTCH_PITCH / 0.05 % 1, 6) % 1 for i in range(len(NOTCHES))}
    assert len(places) == 5
    # they are as deep as the deepest of a comb
    designs = [load_design(name) for name in RIDGED]
    deep = [
        d.slot.depth + 2 * d.mold.slit_clearance
        for d in designs
        if d.slot and d.core_thickness + 2 * d.mold.slit_clearance <= NOTCHES[-1]
    ]
    assert max(deep) <= NOTCH_DEPTH <= 1.2 * max(deep)


def test_each_height_comes_as_often_in_no_order_and_is_printed_flat() -> None:
    heights = drawn_steps()
    assert Counter(heights) == dict.fromkeys(HEIGHTS, REPEATS)
    assert all(a != b for a, b in pairwise(heights))
    slope = np.polyfit(range(len(heights)), heights, 1)[0]
    assert abs(slope) < 0.003  # mm a step: a block that lies askew makes no height look wrong
    assert coupon_parts(processes()["sla"], load_design("plain-ridges"))[1].role is PartRole.CAVITY


def test_the_bar_is_the_standards() -> None:
    outline = bar_outline()
    points = [p for s in outline for p in (s.start, s.point(0.5))]
    assert max(p.z for p in points) == BAR.length / 2
    assert max(p.x for p in points) == BAR.end_width / 2
    assert min(abs(s.point(0.5).x) for s in outline if abs(s.start.x) > 1) == pytest.approx(0.0, abs=1e-12)
    radii = Counter(round(s.radius, 9) for s in outline if s.bulge)
    assert radii == {8.0: 4, 12.5: 4}
    ends = [math.atan2(s.end.z - s.start.z, s.end.x - s.start.x) for s in outline]
    for (a, t), (b, u) in pairwise(zip(outline, ends, strict=True)):
        if a.bulge or b.bulge:  # arcs are tangent to what lies beside them
            assert math.remainder(t + a.sweep / 2 - (u - b.sweep / 2), 2 * math.pi) == pytest.approx(
                0, abs=1e-9
            )
    # by the trapezoid rule, which misses the ends' corners by nothing and the arcs by 1e-9
    y = np.linspace(-37.5, 37.5, 200001)
    assert curves.area(outline) == pytest.approx(np.trapezoid(_width(y), y), rel=1e-8)


def _width(y: np.ndarray) -> np.ndarray:
    """The bar's width at y, by the circles' equations."""
    turn = math.acos(1 - 4.25 / 20.5)
    along = np.abs(y) - 12.5
    first = 2.0 + 12.5 - np.sqrt(12.5**2 - np.clip(along, 0, 12.5 * math.sin(turn)) ** 2)
    back = np.clip(20.5 * math.sin(turn) - along, 0, 8.0 * math.sin(turn))
    second = 6.25 - 8.0 + np.sqrt(8.0**2 - back**2)
    return 2 * np.where(along < 12.5 * math.sin(turn), first, second)


def test_a_mold_takes_what_its_piece_is_larger_by_shrinkage() -> None:
    lab = {"lab-10": {"based_on": "dragon-skin-10", "shrinkage": 0.01}}
    kit = coupon("sla", silicone="lab-10", silicones=lab)
    by = 1 / 0.99
    volumes = poured_volumes(kit.parts)
    assert volumes["tensile-mold"] == pytest.approx(BARS * curves.area(bar_outline()) * 2.0 * by**3, rel=1e-9)
    assert volumes["pad-mold"] == pytest.approx(cast_skin(kit.pad).volume * by**3, rel=1e-9)


@pytest.mark.parametrize("name", PARTS)
def test_the_kernel_and_the_mesh_agree_with_the_formula(name: str) -> None:
    """The kernel within 1e-9, as every part; a mesh within its chords' tolerance on its whole surface."""
    part: Part = PARTS[name]
    exact = solid(part)  # raises unless it is one valid solid
    assert volume(part, exact) == pytest.approx(part.volume, rel=1e-9)
    shape = mesh(part, 0.005)
    assert shape.is_watertight
    assert abs(shape.volume - part.volume) <= 0.005 * shape.area


@pytest.mark.parametrize("name", PROCESSES)
def test_every_part_fits_its_machine_and_needs_no_support(name: str) -> None:
    """As it is laid, turned on the bed where that helps; 0: a machine without such a limit."""
    kit = coupon(name)
    for part in kit.parts:
        *flat, high = laid(mesh(part, 0.01), on_end(part, kit.process)).extents
        bed = sorted([kit.process.build_x or math.inf, kit.process.build_y or math.inf])
        assert all(np.array(sorted(flat)) <= bed), part.name
        assert high <= (kit.process.build_z or math.inf)
        if kit.process.layer:
            assert overhang(part, kit.process, on_end(part, kit.process)) == (0.0, 0.0), part.name
