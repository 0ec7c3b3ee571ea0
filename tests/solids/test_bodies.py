"""Bodies: volumes by hand or by slices, places there and back, outlines, what they sweep; the CAD kernel's
solids of them, and its hidden-line projections."""

from __future__ import annotations

import math
import sys
from contextlib import nullcontext
from dataclasses import replace
from itertools import pairwise

import cadquery as cq
import numpy as np
import pytest
from scipy.integrate import quad

import skincad
from skincad.fabrication import manifold
from skincad.inputs import Design
from skincad.shape import Loop, Point, Segment, loop, polygon, rectangle, section
from skincad.solids import (
    Arc,
    Bore,
    CutRole,
    ExtendedCut,
    Grid,
    KernelError,
    Part,
    PartRole,
    Polyline,
    Prism,
    RevolvedBody,
    RotatedBody,
    Stroke,
    TurnedBody,
    Vector,
    View,
    box,
    corners,
    extent,
    outlined,
    plain,
    skin_part,
    skin_solid,
    solid,
    swept,
    unchecked_solid,
    unturned,
)
from skincad.solids.mold import mold
from skincad.solids.occ import flattened, projection, rounding_error
from skincad.solids.plan import moved, turned

SQUARE, HOLE = rectangle(-1.0, 2.0, 3.0, 5.0), rectangle(0.0, 0.5, 3.5, 4.5)
SAME = 1e-12  # rounding of sums of a few mm


def test_volumes_by_hand() -> None:
    assert Prism(SQUARE, "y", -1.0, 3.0).volume == pytest.approx(3 * 2 * 4, rel=SAME)
    assert Prism(SQUARE, "y", -1.0, 3.0, (HOLE, HOLE)).volume == pytest.approx((6 - 2 * 0.5) * 4, rel=SAME)
    assert Bore((1.0, 2.0, 3.0), "y", 4.0, 0.5).volume == pytest.approx(math.pi * 0.25 * 4, rel=SAME)
    cone = Bore((1.0, 2.0, 3.0), "z", 4.0, 2.0, 0.5)
    whole, cut_off = math.pi * 4 * (16 / 3) / 3, math.pi * 0.25 * (4 / 3) / 3
    assert cone.volume == pytest.approx(whole - cut_off, rel=SAME)
    assert (cone.far_radius, Bore((0.0, 0.0, 0.0), "z", 4.0, 2.0).far_radius) == (0.5, 2.0)
    drilled = Part("p", PartRole.COVER, box(2, (0, 5), (0, 1)), (Bore((0, 2, 0), "z", 1.0, 0.5, 1.0),))
    frustum = math.pi / 3 * (0.25 + 0.5 + 1.0)
    assert drilled.volume == pytest.approx(20.0 - frustum, rel=1e-14)
    short = Bore((0.0, 0.0, 0.0), "z", 2.0, 1.0, role=CutRole.VENT)
    long = Bore((0.0, 0.0, -1.0), "z", 4.0, 1.0)
    assert ExtendedCut(short, long).volume == short.volume
    assert ExtendedCut(short, long).role is CutRole.VENT
    turned = RotatedBody(short, 20.0, 0.3, 0.0)
    for cut in (short, turned, ExtendedCut(short, long), ExtendedCut(turned, long)):
        assert plain(cut) is short


@pytest.mark.parametrize(("radius", "end"), [(0.5, None), (5.0, None), (0.5, 5.0), (5.0, 0.5)])
@pytest.mark.parametrize("tolerance", [1.0, 0.02, 1e-3])
def test_a_bore_has_as_few_chords_as_it_needs(radius: float, end: float | None, tolerance: float) -> None:
    bore = Bore((0.0, 0.0, 0.0), "z", 1.0, radius, end)
    widest = max(radius, end or 0.0)
    count = bore.circle(tolerance)
    assert widest * (1 - math.cos(math.pi / count)) <= tolerance
    assert count == 12 or widest * (1 - math.cos(math.pi / (count - 1))) > tolerance
    assert count >= 12
    for multiple in (2, 4, 8):
        more = bore.circle(tolerance, multiple)
        assert max(12, count) <= more < max(13, count + multiple)
        assert more == 12 or more % multiple == 0


@pytest.mark.parametrize(
    ("y", "wide", "low", "long"),
    [
        *((y, wide, -1.0, 7.0) for y, wide in ((0.0, 1.0), (3.0, 1.6), (-5.0, 0.7))),
        *((y, wide, -0.3, 6.3) for y, wide in ((0.0, 1.0), (3.0, 1.0), (-5.0, 1.6), (2.0, 0.7))),
    ],
)
def test_a_bore_into_an_arc_counts_what_lies_inside(y: float, wide: float, low: float, long: float) -> None:
    """By slices of equal height: of each disk what lies between the arc's two sides."""
    axis, limit = 20.0, 20.0
    bore = Bore((1.0, y, low), "z", long, 1.0, wide, within=(axis, limit))

    def disk(z: float) -> float:
        """Area at this height of what lies above the arc, z >= axis - sqrt(limit^2 - y^2)."""
        radius, reach = 1.0 + (wide - 1.0) * (z - low) / long, math.sqrt(max(0.0, limit**2 - (axis - z) ** 2))

        def part(v: float) -> float:
            v = min(radius, max(-radius, v))
            return v * math.sqrt(max(0.0, radius**2 - v * v)) + radius**2 * math.asin(v / radius)

        return part(reach - y) - part(-reach - y)

    kinks = [axis - math.sqrt(limit**2 - min(19.0, abs(y) + s) ** 2) for s in (-1.0, 0.0, 1.0, wide)]
    bounds = sorted({0.0, low + long, *(k for k in kinks if 0 < k < low + long)})
    pieces = pairwise(bounds)
    sliced = math.fsum(quad(disk, a, b, limit=200, epsabs=1e-11)[0] for a, b in pieces)
    assert bore.volume == pytest.approx(sliced, rel=1e-8)  # the slices' own error, at their kinks
    assert bore.volume < replace(bore, within=None).volume


def test_what_turns_has_its_rings_volume_on_either_side_of_the_axis() -> None:
    """A ring's part: half the angle times the difference of the squares of its radii, times its width."""
    for centre, radii, hole in ((10.0, (7.0, 5.0), (6.5, 5.5)), (-4.0, (9.0, 7.0), (8.5, 7.5))):
        ring = (radii[0] ** 2 - radii[1] ** 2) / 2 * 3
        less = (hole[0] ** 2 - hole[1] ** 2) / 2 * 0.5
        assert RevolvedBody(SQUARE, centre, -0.2, 0.5).volume == pytest.approx(0.7 * ring, rel=SAME)
        assert RevolvedBody(SQUARE, centre, -0.2, 0.5, (HOLE,)).volume == pytest.approx(
            0.7 * (ring - less), rel=SAME
        )


@pytest.mark.parametrize("centre", [10.0, -4.0, 1e9])
@pytest.mark.parametrize("angle", [0.0, 0.3, -1.2])
def test_section_points_turn_about_the_axis_and_back(centre: float, angle: float) -> None:
    points = np.array([[1.0, 3.0], [-2.0, 5.0], [0.5, 3.5]])
    angle = angle * min(1.0, 10 / abs(centre))  # some mm of arc about a far axis
    body = RevolvedBody(SQUARE, centre, -0.2, 0.5)
    placed = body.placed(points, angle)
    away = np.abs(points[:, 1] - centre)
    assert placed[:, 0] == pytest.approx(points[:, 0])
    assert placed[:, 1] == pytest.approx(away * math.sin(angle), rel=1e-9, abs=SAME)
    # how far z comes towards the axis: arm (1 - cos), written so that no digits go
    drawn = np.sign(centre - points[:, 1]) * 2 * away * math.sin(angle / 2) ** 2
    assert placed[:, 2] == pytest.approx(points[:, 1] + drawn, abs=1e-9)
    straight = body.straightened(placed)
    assert straight[:, [0, 2]] == pytest.approx(points, abs=1e-9)
    assert straight[:, 1] == pytest.approx(np.full(3, angle * abs(centre)), rel=1e-6, abs=SAME)


@pytest.mark.parametrize(
    "body", [Bore((1.0, 6.0, 2.0), "y", 3.0, 0.5, role=CutRole.NUT), Prism(SQUARE, "y", 6.0, 9.0)]
)
def test_a_turned_body_keeps_its_shape_and_has_its_base_on_the_axis_foot(body: Bore | Prism) -> None:
    turned = RotatedBody(body, 20.0, 0.3, 6.0)
    assert (turned.volume, turned.role) == (body.volume, body.role)
    points = np.array([[0.0, 6.0, 20.0], [0.0, 6.0, 0.0], [3.0, 9.0, 0.0], [1.0, -4.0, 7.0]])
    placed = turned.placed(points)
    assert placed[0] == pytest.approx([0.0, 0.0, 20.0], abs=SAME)  # on the axis nothing moves
    assert placed[1] == pytest.approx([0.0, 20 * math.sin(0.3), 20 - 20 * math.cos(0.3)], abs=SAME)
    assert placed[2] - placed[1] == pytest.approx([3.0, 3 * math.cos(0.3), 3 * math.sin(0.3)], abs=SAME)
    assert turned.returned(placed) == pytest.approx(points, abs=SAME)
    turn, _ = turned.placement()
    assert turn @ turn.T == pytest.approx(np.eye(3), abs=SAME)
    assert np.linalg.det(turn) == pytest.approx(1.0, rel=SAME)


def bowl(radius: float, half: float) -> Prism:
    """Block in (y, z) whose upper side is the back's arc, z = 0 in its middle, about the axis above."""
    y, z = radius * math.sin(half), 2 * radius * math.sin(half / 2) ** 2
    arc = Segment(Point(y, z), Point(-y, z), -math.tan(half / 2))
    ends = [Point(-y, z), Point(-y, -3.0), Point(y, -3.0), Point(y, z)]
    lines = [Segment(a, b) for a, b in pairwise(ends)]
    return Prism((arc, *lines), "x", -1.0, 1.0, grid=Grid(radius, half, radius + 3.0))


@pytest.mark.parametrize("upside_down", [False, True])
def test_an_arc_that_turns_has_its_corners_on_the_grid(upside_down: bool) -> None:
    body, tolerance = bowl(25.0, 0.4), 1e-2
    outline = tuple(s.reversed() for s in reversed(body.outline)) if upside_down else body.outline
    points = corners(body, outline, tolerance)
    assert body.grid
    angles = body.grid.angles(-0.4, 0.4, tolerance)
    assert len(points) == len(angles) + 2  # the block's two lower corners; no end twice
    assert [z for _, z in points if z < 0] == [-3.0, -3.0]
    on_arc = points[points[:, 1] >= 0]
    assert np.hypot(on_arc[:, 0], on_arc[:, 1] - 25.0) == pytest.approx(np.full(len(angles), 25.0), rel=SAME)
    corner_angles = np.arctan2(on_arc[:, 0], 25.0 - on_arc[:, 1])
    assert np.sort(corner_angles) == pytest.approx(angles, abs=SAME)
    steps = np.hypot(*(np.roll(points, -1, axis=0) - points).T)
    assert steps.min() > 0.1  # in order, none twice
    around = 2 * 25 * (0.4 + math.sin(0.4)) + 2 * (3 + on_arc[:, 1].max())
    assert steps.sum() == pytest.approx(around, rel=1e-3)
    x, z = points.T
    area = float(np.sum(x * np.roll(z, -1) - z * np.roll(x, -1))) / 2
    sector = 25**2 * (0.4 - math.sin(0.4) * math.cos(0.4))  # between the arc and its ends' level
    block = 2 * 25 * math.sin(0.4) * (3 + on_arc[:, 1].max()) - sector
    assert abs(area) == pytest.approx(block, abs=tolerance * 20)
    assert (area < 0) == upside_down


def test_any_other_outline_is_a_polygon_within_the_tolerance() -> None:
    round_end = loop([Point(0.0, 0.0), Point(2.0, 0.0), Point(2.0, 2.0)])
    assert len(corners(Prism(round_end, "x", 0.0, 1.0), round_end, 0.01)) == 3
    body = bowl(25.0, 0.4)
    along_y = Prism(body.outline, "y", -1.0, 1.0, grid=body.grid)
    coarse, fine = (len(corners(along_y, body.outline, tolerance)) for tolerance in (0.1, 1e-3))
    assert fine > 5 * coarse / 2  # as the root of the tolerance, two corners aside


def test_a_straight_move_sweeps_a_longer_prism_or_its_shadow() -> None:
    plate = Part("p", PartRole.COVER, box(2, (0, 1), (0, 4), "y"), (Bore((0, 0, 2), "y", 1.0, 0.5),))
    path = swept(plate, "y", -3.0, 1e-3)
    assert path.volume == pytest.approx(4 * plate.volume, rel=1e-14)
    assert manifold(path, 1e-3).bounding_box()[1] == -3.0
    mushroom = loop([Point(*p) for p in ((-1, 0), (1, 0), (1, 1), (3, 2), (-3, 2), (-1, 1))])
    part = Part("p", PartRole.SKIN, Prism(mushroom, "y", 0.0, 1.0))
    path = swept(part, "z", 5.0, 1e-3)
    assert path.volume == pytest.approx(part.volume + 6 * 5.0, rel=1e-12)  # width 6 everywhere above
    # aside, along the heading
    part = Part("p", PartRole.COVER, box(1.0, (0.0, 2.0), (0.0, 1.0), "y"))
    path = swept(part, (math.sin(0.3), -math.cos(0.3)), 5.0, 1e-3)
    width = 2.0 * math.cos(0.3) + 1.0 * math.sin(0.3)  # width of a 2 x 1 mm box seen along the heading
    assert path.volume == pytest.approx(2.0 * (2.0 + 5.0 * width), rel=1e-12)
    # a blind hole leaves no way open, a pin that moves across its axis sweeps a stadium if it lies along y
    blind = Part("p", PartRole.COVER, box(2, (0, 4), (0, 4), "y"), (Bore((0, 0, 2), "y", 3.0, 0.5),))
    assert swept(blind, "y", 2.0, 1e-3).volume == pytest.approx(4 * 6 * 4)
    pin = Part("pin", PartRole.END_PIN, Bore((0, 0, 0), "y", 3.0, 1.0))
    path = swept(pin, "z", -4.0, 1e-5)
    assert path.volume == pytest.approx(3.0 * (math.pi + 8.0), rel=1e-4)  # chords within 1e-5 mm
    pin = Part("pin", PartRole.END_PIN, Bore((0, 0, 0), "z", 1.0, 0.5))
    with pytest.raises(ValueError, match="pin moves along its axis only"):
        swept(pin, "y", 1.0, 1e-3)


def test_what_turns_is_swept_in_its_frame_by_turning_or_upward() -> None:
    plate = Part("p", PartRole.COVER, box(2, (5, 6), (0, 4), "y"), (Bore((0, 5, 2), "y", 1.0, 0.5),))
    leaning = turned(plate, 20.0, 0.3, 5.0)
    assert unturned(leaning) == plate
    assert leaning.volume == plate.volume
    path = swept(leaning, "y", 3.0, 1e-3)
    assert path.volume == pytest.approx(4 * plate.volume, rel=1e-14)
    grid = Grid(20.0, 0.3, 22.0)
    square = loop([Point(*p) for p in ((-1, -2), (1, -2), (1, 0), (-1, 0))])
    arc = Part("a", PartRole.SHIM, RevolvedBody(square, 20.0, -0.3, 0.3, grid=grid))
    assert swept(arc, "turn", 0.9, 1e-3).volume == pytest.approx(2.5 * arc.volume, rel=1e-14)
    risen = swept(arc, "z", 5.0, 1e-4)
    assert risen.volume == pytest.approx(arc.volume + 2 * 5.0 * 2 * 22 * math.sin(0.3), rel=1e-4)  # chords


def test_a_grids_angles_are_common_and_ends_between_them_lie_on_its_chords() -> None:
    grid, fine = Grid(20.0, 0.3, 22.0), 1e-3
    whole, part = grid.angles(-0.3, 0.3, fine), grid.angles(-0.11, 0.9, fine)
    assert (whole[0], whole[-1], part[0], part[-1]) == (-0.3, 0.3, -0.11, 0.9)
    assert set(whole[whole > -0.11]) <= set(part)  # to the last digit
    step = whole[1] - whole[0]
    assert 22.0 * (1 - math.cos(step / 2)) < fine / 2 < 22.0 * (1 - math.cos(0.6 * step))
    (y0, z0), (y1, z1) = grid.arc(whole[3], whole[4], fine)
    y2, z2 = grid.arc(whole[3] + 0.3 * step, 0.3, fine)[0]
    assert (y1 - y0) * (z2 - z0) == pytest.approx((y2 - y0) * (z1 - z0), rel=1e-9)
    assert math.hypot(y2, 20 - z2) < 20.0


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


KERNEL_TOLERANCE = 1e-7  # mm


@pytest.mark.evidence(subject="kernel: hard sections")
def test_hard_shapes_are_valid_and_of_their_volume(variants: dict[str, Design]) -> None:
    for name, design in variants.items():
        shape = solid(skin_part(design))
        # arcs that rise less than the kernel's 1e-7 mm become lines: that moves area by 1e-7 x width
        slack = 1e-7 * design.skin.width * design.skin.length
        exact = section(design).area * design.skin.length
        assert shape.Volume() == pytest.approx(exact, rel=1e-9, abs=slack), name


def test_a_solid_has_exact_faces_and_its_plans_volume(yamada: Design) -> None:
    cover = mold(yamada).part("cover")
    outside = replace(cover, cuts=(*cover.cuts, Bore((100.0, 0.0, 0.0), "z", 1.0, 1.0)))
    with pytest.raises(KernelError, match="cover: volume differs from its formula"):
        solid(outside)
    faces = skin_solid(yamada).faces().vals()
    kinds = {face.geomType() for face in faces}
    assert kinds == {"PLANE", "CYLINDER"}
    assert len(faces) == len(section(yamada).outline) + 4 * 18 + 2


@pytest.mark.parametrize("share", [0.9, 1.2])
def test_cuts_may_be_off_by_the_tolerance(
    share: float, yamada: Design, monkeypatch: pytest.MonkeyPatch
) -> None:
    cover = mold(yamada).part("cover")
    off = share * KERNEL_TOLERANCE * solid(cover).Area()
    monkeypatch.setattr("skincad.solids.occ.volume", lambda part, _: part.volume + off)
    with nullcontext() if share < 1 else pytest.raises(KernelError, match="cover: volume differs"):
        solid(cover)
    uncut = replace(cover, cuts=())
    with pytest.raises(KernelError, match="cover: volume differs"):  # no edge of it is computed
        solid(uncut)


def test_a_missing_system_library_is_named_with_its_package(monkeypatch: pytest.MonkeyPatch) -> None:
    import importlib

    class Lacking:
        """As the dynamic linker has it on a bare Linux."""

        def find_spec(self, name: str, *_: object) -> None:
            if name == "cadquery":
                words = "libGL.so.1: cannot open shared object file: No such file or directory"
                raise ImportError(words)

    monkeypatch.setattr(sys, "meta_path", [Lacking(), *sys.meta_path])
    monkeypatch.delitem(sys.modules, "cadquery")
    monkeypatch.delitem(sys.modules, "skincad.solids.occ")
    with pytest.raises(skincad.InputError, match="libgl1 libx11-6"):
        importlib.import_module("skincad.solids.occ")


@pytest.mark.parametrize("far", [1e4, 1e8])
def test_what_far_centres_may_round_is_the_last_digits_of_their_distance_on_every_face(far: float) -> None:
    """By hand: faces of 2 (10 + 4) mm round the section, each 20 mm long, moved by the distance's digits."""
    flat = rectangle(-5.0, 5.0, 0.0, 4.0)
    assert rounding_error(Prism(flat, "y", -10.0, 10.0)) == 0.0
    assert rounding_error(Bore((0.0, 0.0, 0.0), "z", 1.0, 1.0)) == 0.0
    digits = far * sys.float_info.epsilon
    for centre in (far, -far):
        swept = rounding_error(RevolvedBody(flat, centre, -10.0 / far, 10.0 / far))
        assert swept == pytest.approx(4 * digits * 28.0 * 20.0, rel=1e-9)  # up to 4 times as much
    # an arc of a far centre is as a face that far
    arc = replace(flat[0], bulge=10.0 / far / 4)
    curved = rounding_error(Prism((arc, *flat[1:]), "y", -10.0, 10.0))
    assert curved == pytest.approx(4 * digits * 10.0 * 20.0, rel=1e-6)


def test_only_an_arc_that_the_kernel_cannot_tell_from_a_line_is_one() -> None:
    flat = rectangle(-5.0, 5.0, 0.0, 4.0)
    for rise, line in ((0.99 * KERNEL_TOLERANCE, True), (1.01 * KERNEL_TOLERANCE, False)):
        for sign in (1, -1):
            arc = replace(flat[0], bulge=sign * 2 * rise / 10.0)  # rise: half the chord by the bulge
            assert arc.point(0.5).z == pytest.approx(-sign * rise, rel=1e-6)
            shown = flattened(Prism((arc, *flat[1:]), "y", -10.0, 10.0))
            assert isinstance(shown, Prism)
            assert (shown.outline[0].bulge == 0.0) == line


PLAN, FRONT = View((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)), View((1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
PLACE = 1e-6  # mm, the kernel's own tolerance is 1e-7


def plate(depth: float | None) -> cq.Solid:
    """A block of 10 x 6 x 4 about the origin with a bore of 2 from above."""
    return cq.Workplane().box(10, 6, 4).faces(">Z").workplane().hole(2.0, depth).val()


def lines(strokes: tuple[Stroke, ...]) -> set[tuple[tuple[float, float], ...]]:
    straight = [stroke.points for stroke in strokes if isinstance(stroke, Polyline)]
    return {tuple(sorted((round(x, 6) + 0.0, round(y, 6) + 0.0) for x, y in points)) for points in straight}


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
    # Seen along its own axes from its own origin, a solid that was turned and moved is as it was
    turned = plate(None).rotate(cq.Vector(0, 0, 0), cq.Vector(1, 0, 0), 30).translate(cq.Vector(1, 2, 3))
    c, s = math.cos(math.radians(30)), math.sin(math.radians(30))
    seen = projection(turned, View((1.0, 0.0, 0.0), (0.0, c, s), (1.0, 2.0, 3.0)))
    assert lines(seen.visible) == lines(projection(plate(None), PLAN).visible)


def test_a_blind_bore_is_hidden_to_its_depth_and_a_through_one_is_not() -> None:
    seen = projection(plate(3.0), FRONT)
    bore = {((-1.0, -1.0), (-1.0, 2.0)), ((1.0, -1.0), (1.0, 2.0)), ((-1.0, -1.0), (1.0, -1.0))}
    assert bore <= lines(seen.hidden)
    assert len(lines(seen.visible)) == 4
    assert all(abs(x) <= 1.0 for line in lines(seen.hidden) for x, _ in line)
    below = View((1.0, 0.0, 0.0), (0.0, -1.0, 0.0))
    assert below.towards == (0.0, 0.0, -1.0)
    blind, through = (projection(plate(depth), below) for depth in (3.0, None))
    assert [isinstance(s, Arc) for s in blind.visible].count(True) == 0
    assert [isinstance(s, Arc) for s in blind.hidden].count(True) == 1
    assert [isinstance(s, Arc) for s in through.visible].count(True) == 1


@pytest.mark.parametrize("bulge", [0.4, -0.2])
def test_a_loop_with_an_arc_keeps_its_ends_and_extent(bulge: float) -> None:
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
