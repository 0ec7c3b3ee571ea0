"""The CAD kernel: solids are valid and of their own formulas' volume, or refused; hidden-line projections."""

from __future__ import annotations

import math
import sys
from contextlib import nullcontext
from dataclasses import replace

import cadquery as cq
import pytest

import skincad
from skincad.inputs import Design
from skincad.shape import Point, loop, polygon, rectangle, section
from skincad.solids import (
    Arc,
    Bore,
    KernelError,
    Polyline,
    Prism,
    RevolvedBody,
    Stroke,
    View,
    extent,
    outlined,
    skin_part,
    skin_solid,
    solid,
)
from skincad.solids.mold import mold
from skincad.solids.occ import flattened, projection, rounding_error

KERNEL_TOLERANCE = 1e-7  # mm


@pytest.mark.evidence(subject="kernel: hard sections")
def test_hard_shapes_are_valid_and_of_their_volume(variants: dict[str, Design]) -> None:
    for name, design in variants.items():
        shape = solid(skin_part(design))
        # arcs that rise less than the kernel's 1e-7 mm become lines: that moves area by 1e-7 x width
        slack = 1e-7 * design.skin.width * design.skin.length
        exact = section(design).area * design.skin.length
        assert shape.Volume() == pytest.approx(exact, rel=1e-9, abs=slack), name


def test_skin_is_a_workplane_with_exact_cylinders(yamada: Design) -> None:
    faces = skin_solid(yamada).faces().vals()
    kinds = {face.geomType() for face in faces}
    assert kinds == {"PLANE", "CYLINDER"}
    assert len(faces) == len(section(yamada).outline) + 4 * 18 + 2


def test_a_solid_that_is_not_its_plans_volume_is_refused(yamada: Design) -> None:
    cover = mold(yamada).part("cover")
    outside = replace(cover, cuts=(*cover.cuts, Bore((100.0, 0.0, 0.0), "z", 1.0, 1.0)))
    with pytest.raises(KernelError, match="cover: volume differs from its formula"):
        solid(outside)


@pytest.mark.parametrize("share", [0.9, 1.2])
def test_cuts_may_be_off_by_the_kernels_tolerance_on_each_face(
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
    assert rounding_error(Prism((arc, *flat[1:]), "y", -10.0, 10.0)) == pytest.approx(
        4 * digits * 10.0 * 20.0, rel=1e-6
    )


def test_only_an_arc_that_the_kernel_cannot_tell_from_a_line_is_one() -> None:
    flat = rectangle(-5.0, 5.0, 0.0, 4.0)
    for rise, line in ((0.99 * KERNEL_TOLERANCE, True), (1.01 * KERNEL_TOLERANCE, False)):
        for sign in (1, -1):
            arc = replace(
                flat[0], bulge=sign * 2 * rise / 10.0
            )  # rise of an arc: half the chord by the bulge
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
