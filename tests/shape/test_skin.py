"""The section of ridges, of unlike ones too; how much lower measured crests lie; arcs and polygons."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import skincad
from skincad.base import InputError
from skincad.inputs import Design, template_names
from skincad.shape import (
    FACE,
    Point,
    Segment,
    area,
    concentric_hit,
    crest_column,
    crest_drops,
    crest_places,
    flipped,
    length,
    polygon,
    rectangle,
    section,
    shift_warnings,
    skin_of,
)
from skincad.shape.curves import moments, offset
from tests.refusals import refused


def test_a_section_is_closed_smooth_at_fillets_and_of_its_polygons_area(variants: dict[str, Design]) -> None:
    for name, design in variants.items():
        outline = section(design).outline
        x, z = polygon(outline, 1e-8).T
        shoelace = float(np.sum(x * np.roll(z, -1) - z * np.roll(x, -1))) / 2
        # chords cut off at most tolerance x perimeter
        assert area(outline) == pytest.approx(shoelace, abs=1e-8 * 300), name
    for name, design in variants.items():
        outline = section(design).outline
        for one, two in zip(outline, (*outline[1:], outline[0]), strict=True):
            assert one.end == two.start, name
            if "fillet" in one.kind + two.kind:
                a, b = one.points(np.array([1 - 1e-6, 1.0])), two.points(np.array([0.0, 1e-6]))
                u, v = a[1] - a[0], b[1] - b[0]
                turn = abs(u[0] * v[1] - u[1] * v[0]) / (np.hypot(*u) * np.hypot(*v))
                assert turn < 1e-4, (name, one.kind, two.kind)  # secants over 1e-6 of each arc


def test_dimensions_are_those_of_the_design(yamada: Design) -> None:
    shape = section(yamada)
    points = polygon(shape.outline, 1e-6)
    middle = points[np.abs(points[:, 0]) < 0.3]
    assert middle[:, 1].max() == pytest.approx(4.5, abs=1e-6)  # thickness + height, to the chord tolerance
    assert np.ptp(points[:, 0]) == pytest.approx(11.0, abs=1e-12)
    assert points[:, 1].min() == 0.0
    assert {s.feature for s in shape.outline} == {None, *range(1, 10)}
    assert shape.top == 4.5
    assert len(shape.slots) == 18
    outer, middle = skin_of(yamada).placed[8].frame, skin_of(yamada).placed[4].frame
    lean = 4 / 60
    drop = (60 + 0.5) * (1 - math.cos(lean))
    summit, top = outer.at(0.0, 0.5), middle.at(0.0, 0.5)
    assert top.z - summit.z == pytest.approx(drop, rel=1e-12)
    assert drop == pytest.approx(0.133, abs=0.0015)  # docs/evidence/facts.md#the-reference-section
    points = polygon(section(yamada).outline, 1e-4)
    for x, z in points * [-1, 1]:
        assert np.hypot(*(points - [x, z]).T).min() < 1e-9  # rounding; corners are 0.01 mm apart
    assert section(yamada).centroid.x == pytest.approx(0.0, abs=1e-12)


def test_slots_leave_the_stated_wall_and_web_and_lean_inward(yamada: Design) -> None:
    s1, s2 = section(yamada).slots[8:10]
    web = s2.at(-s2.thickness / 2, 0.0).x - s1.at(s1.thickness / 2, 0.0).x
    assert web == pytest.approx(0.27, abs=1e-9)  # 2 x 0.16 of offset less 0.05
    assert (s1.side, s2.side, s1.feature) == ("S1", "S2", 5)
    assert s1.centre.x < 0 < s2.centre.x
    left, right = section(skincad.load("yamada-2002-tilted")).slots[8:10]
    assert left.direction.x > 0 > right.direction.x
    assert math.degrees(math.atan2(left.direction.x, left.direction.z)) == pytest.approx(45.0)


def test_every_template_has_a_section() -> None:
    for name in template_names():
        assert section(skincad.load(name)).area > 0, name
    small, large = (section(skincad.load(n)) for n in ("yamada-2002", "lab-bench"))
    assert area(large.outline) == pytest.approx(4 * area(small.outline), rel=1e-14)  # all lengths doubled


@pytest.mark.parametrize(
    ("change", "key", "words"),
    [
        ({"slot": {"offset": 0.4}}, "slot", "crosses it"),
        ({"slot": {"offset": 0.27}}, "slot", "wall to the outline"),
        ({"slot": {"offset": 0.04}}, "slot", "web between slots"),
        ({"ridge": {"tip_fillet": 0.6}}, "ridge", "fillet"),
        ({"ridge": {"root_fillet": 0.2}}, "ridge", "neighbouring root fillets overlap"),
        ({"ridge": {"crown": 0.2, "tip_fillet": 0.3}}, "ridge", "as steep as the flanks"),
    ],
)
def test_what_does_not_fit_is_refused(yamada: Design, change: dict, key: str, words: str) -> None:
    with pytest.raises(InputError, match=words) as refused:
        section(yamada.with_(**change))
    assert refused.value.key.startswith(key)
    assert "\n" not in str(refused.value)


FLAT = {"count": 1, "pitch": 5.0, "root_width": 4.5, "tip_width": 0.5, "height": 0.2, "crown": 0.0}
BULGED = {"height": 0.2, "crown": 0.19}
SHORT = {"curvature_radius": 8.0, "width": 6.0, "thickness": 5.0}


@pytest.mark.parametrize(
    ("skin", "ridge", "key", "words"),
    [
        (SHORT, FLAT, "ridge.root_width", "flanks begin inside the base circle"),
        ({}, BULGED, "ridge.crown", "edges as steep as the flanks"),
    ],
)
@pytest.mark.parametrize("fillet", [0.0, 0.01])
def test_no_fillet_is_blamed_for_a_flank(
    yamada: Design, skin: dict, ridge: dict, key: str, words: str, fillet: float
) -> None:
    """A flank's angles with base circle and crown are the same with fillets and without: no word of them."""
    wrong = yamada.with_(skin=skin, ridge={**ridge, "tip_fillet": fillet, "root_fillet": fillet}, slot=None)
    with pytest.raises(InputError) as refused:
        section(wrong)
    assert refused.value.key == key
    assert words in str(refused.value)
    assert "fillet" not in str(refused.value)
    assert refused.value.remedy


def test_the_steepest_crown_is_that_whose_tangent_is_the_flank(yamada: Design) -> None:
    """A crown's edge has the slope 2 atan(2 crown / tip); refused from where a flank has it, not before."""
    ridge = yamada.ridge
    flank = math.atan2(ridge.height - ridge.crown, (ridge.root_width - ridge.tip_width) / 2)
    steep = ridge.tip_width / 2 * math.tan(flank / 2)
    flank_high = ridge.height - ridge.crown
    low, high = (
        {"crown": share * steep, "height": flank_high + share * steep, "tip_fillet": 0.0, "root_fillet": 0.0}
        for share in (0.9, 1.1)
    )
    assert section(yamada.with_(ridge=low, slot=None))
    with pytest.raises(InputError, match=r"^ridge.crown: makes"):
        section(yamada.with_(ridge=high, slot=None))


def test_a_ridge_without_fillets_has_no_tiny_edges(yamada: Design) -> None:
    """Rounding made a fillet of radius 0 an edge of 1e-17 mm, and one root in ten crossed itself by it."""
    ridge = {"tip_width": 0.75, "crown": 0.0, "tip_fillet": 0.0, "root_fillet": 0.0}
    sharp = yamada.with_(slot=None, skin={"curvature_radius": 20.0}, ridge=ridge)
    for root in np.linspace(0.76, 0.98, 23):
        outline = section(sharp.with_(ridge={"root_width": float(root)})).outline
        assert min(s.chord for s in outline) > 1e-3
        assert not any(s.kind in ("tip_fillet", "root_fillet") for s in outline)


@pytest.mark.parametrize("fillets", [(0.05, 0.08), (0.1, 0.02), (0.0, 0.05), (0.03, 0.0)])
def test_fillets_touch_what_they_join(yamada: Design, fillets: tuple[float, float]) -> None:
    """A tip fillet touches flank and crown, a root fillet flank and base circle: heads agree there."""
    tip, root = fillets
    shape = section(yamada.with_(ridge={"tip_fillet": tip, "root_fillet": root}))
    ridge = [s for s in shape.outline if s.feature == 9]
    kinds = [s.kind for s in ridge]
    half = [*(["root_fillet"] if root else []), "flank", *(["tip_fillet"] if tip else [])]
    assert kinds == [*half, "crown", *half[::-1]]
    for one, two in pairwise(ridge):
        if "fillet" in one.kind + two.kind:
            heads = [math.atan2(s.end.z - s.start.z, s.end.x - s.start.x) for s in (one, two)]
            turn = heads[1] - two.sweep / 2 - (heads[0] + one.sweep / 2)
            assert abs(math.remainder(turn, 2 * math.pi)) < 1e-9  # rounding of short chords
    for kind, radius, sign in (("tip_fillet", tip, 1), ("root_fillet", root, -1)):
        for segment in (s for s in ridge if s.kind == kind):
            assert segment.radius == pytest.approx(radius, rel=1e-9)
            assert segment.bulge * sign > 0


@pytest.mark.parametrize("radius", [2.0, 60.0, 1e7])
@pytest.mark.parametrize("level", [-0.5, 0.0, 0.3])
def test_a_line_meets_a_circle_that_is_concentric_with_the_base(radius: float, level: float) -> None:
    start, along = np.array([0.4, -0.6]), np.array([0.28, 0.96])

    def over(u: float) -> float:
        """Distance of the line's point from the circle of this radius about (0, -radius)."""
        x, n = start + u * along
        return float((x * x + n * n + 2 * radius * n) / (math.hypot(x, n + radius) + radius))

    u = concentric_hit(start, along, 1 / radius, level + level**2 / (2 * radius))
    assert over(u) == pytest.approx(level, abs=1e-9)
    assert concentric_hit(start, -along, 1 / radius, 0.3) is None  # it falls
    assert concentric_hit(np.array([0.0, -0.6]), np.array([1.0, 0.0]), 1 / radius, 0.3) is None  # it is level
    beside = np.array([-3 * radius, 0.0])
    assert concentric_hit(beside, np.array([0.0, 1.0]), 1 / radius, 0.0) is None  # it misses the circle


UNLIKE = [0.5, 0.52, 0.5, 0.48, 0.5, 0.5, 0.47, 0.5, 0.55]


def crown(design: Design, ridge: int) -> Segment:
    (segment,) = (s for s in section(design).outline if s.kind == "crown" and s.feature == ridge)
    return segment


@pytest.mark.parametrize("ridge", [{"heights": UNLIKE}, {"levelling": 0.7}, {"levelling": 1.0}])
def test_each_summit_stands_its_height_over_the_base_circle(yamada: Design, ridge: dict[str, Any]) -> None:
    design = yamada.with_(ridge=ridge)
    for number, height in enumerate(design.heights, 1):
        lean = (number - 5) / 60
        x, z = crown(design, number).point(0.5)
        assert x == pytest.approx((60 + height) * math.sin(lean), abs=1e-12)  # rounding of 60 mm
        assert z == pytest.approx(4 - 60 + (60 + height) * math.cos(lean), abs=1e-12)
        assert skin_of(design).crests[number - 1] == pytest.approx(z, abs=1e-12)


def test_a_ridge_is_as_on_a_skin_of_its_height(yamada: Design) -> None:
    unlike = section(yamada.with_(ridge={"heights": UNLIKE})).outline
    for number, height in enumerate(UNLIKE, 1):
        alike = section(yamada.with_(ridge={"height": height})).outline
        assert [s for s in unlike if s.feature == number] == [s for s in alike if s.feature == number]
    assert all(a.end == b.start for a, b in zip(unlike, (*unlike[1:], unlike[0]), strict=True))
    assert section(yamada.with_(ridge={"heights": [0.5] * 9})) == section(yamada)
    # the skin is as high as at its highest crest
    assert skin_of(yamada).height == 4.5
    assert skin_of(yamada.with_(ridge={"levelling": 0.9})).height == 4.5  # outer ridges are higher, and lower
    assert skin_of(yamada.with_(ridge={"heights": [*UNLIKE[:8], 0.8]})).height == 4.8
    one, other = (
        np.array([[*s.start, s.bulge] for s in section(yamada.with_(ridge={"heights": heights})).outline])
        for heights in (UNLIKE, UNLIKE[::-1])
    )
    images = {tuple(np.round(row, 12) + 0.0) for row in one[:, :2] * [-1.0, 1.0]}
    assert images == {tuple(np.round(row, 12) + 0.0) for row in other[:, :2]}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"ridge": {"heights": [*UNLIKE[:5], 0.155, *UNLIKE[6:]], "root_fillet": 0.45}},
         "ridge.root_fillet: ridge 6, 0.155 mm high: root and tip fillet need"),
        ({"ridge": {"heights": [*UNLIKE[:5], 0.04, *UNLIKE[6:]]}},
         "ridge.crown: ridge 6, 0.04 mm high: makes the crown's edges as steep"),
        ({"ridge": {"heights": [*UNLIKE[:6], 0.15, *UNLIKE[7:]]}},
         "slot: must lie inside the outline; S1 of ridge 7 crosses it"),
        ({"ridge": {"heights": [*UNLIKE[:6], 0.2, *UNLIKE[7:]]}},
         "slot.offset: leaves a wall to the outline at S1 of ridge 7 of 0.0"),
        ({"ridge": {"heights": [3.0, 0.5, *UNLIKE[2:]], "root_width": 0.97, "root_fillet": 0.05}},
         " mm at ridges 1 and 2, got 0.05"),
    ],
)  # fmt: skip
def test_what_does_not_fit_names_its_ridge(yamada: Design, change: dict[str, Any], message: str) -> None:
    with refused(message):
        section(yamada.with_(**change))


def test_a_measured_crest_is_held_against_its_own_ridge(yamada: Design, tmp_path: Any) -> None:
    design = yamada.with_(ridge={"heights": [*UNLIKE[:8], 1.0]})
    lower = [0.01, -0.02, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.6]  # the last would be too much of 0.5 mm
    rows = [
        f"{i},{z - drop!r}" for i, (z, drop) in enumerate(zip(skin_of(design).crests, lower, strict=True), 1)
    ]
    (tmp_path / "crests.csv").write_text("ridge,crest_mm\n" + "\n".join(rows))
    assert crest_drops(tmp_path / "crests.csv", design)[0] == pytest.approx(lower, abs=1e-12)
    (tmp_path / "crests.csv").write_text(
        "ridge,crest_mm\n" + "\n".join([*rows[:7], "8,3.7", f"9,{skin_of(design).crests[8] - 0.95!r}"])
    )
    with pytest.raises(InputError, match=r"ridge 8: must be within 0\.5 mm \(ridge\.heights\)"):
        crest_drops(tmp_path / "crests.csv", design)


def summit(design: Design, ridge: int) -> float:
    """Height of a crest above the back, mm: all lie on one circle, pitch by pitch along the base circle."""
    skin, middle = design.skin, (design.ridge.count + 1) / 2
    lean = (ridge - middle) * design.ridge.pitch / skin.curvature_radius
    out = skin.curvature_radius + design.ridge.height
    return skin.thickness + design.ridge.height - out * (1 - math.cos(lean))


def measured(path: Path, design: Design, lower: list[float]) -> Path:
    """The crests of a part, as much lower than designed as said, in a file of another order."""
    rows = [f"{i},{summit(design, i) - drop!r}" for i, drop in enumerate(lower, 1)]
    path.write_text("ridge,crest_mm\n" + "\n".join(reversed(rows)))
    return path


@pytest.mark.parametrize("name", ["yamada-2002", "plain-ridges", "fingertip-soft"])
def test_drops_are_those_from_the_circle_of_the_crests(tmp_path: Path, name: str) -> None:
    design = skincad.load(name)
    lower = [0.01 * (-1) ** i * i for i in range(design.ridge.count)]
    drops, _ = crest_drops(measured(tmp_path / "crests.csv", design, lower), design)
    assert drops == pytest.approx(lower, abs=1e-12)  # rounding of a height of some mm


@pytest.mark.parametrize("sign", [1, -1])
def test_a_crest_farther_off_than_a_ridge_is_high_is_refused(
    tmp_path: Path, yamada: Design, sign: int
) -> None:
    height = yamada.ridge.height
    lower = [0.0, sign * 0.9 * height, *[0.0] * 5, -sign * 1.1 * height, 0.0]
    path = measured(tmp_path / "crests.csv", yamada, lower)
    with pytest.raises(InputError) as refused:
        crest_drops(path, yamada)
    designed = summit(yamada, 8)
    rule = f"must be within {height:g} mm (ridge.height) of the designed {designed:.4g} mm"
    assert "ridge 8" in str(refused.value)
    assert rule in str(refused.value)
    assert refused.value.value == pytest.approx(designed + sign * 1.1 * height, abs=1e-12)
    lower[7], lower[4] = -sign * 0.999 * height, sign * height  # the middle one just as far: it is exact
    assert len(crest_drops(measured(path, yamada, lower), yamada)[0]) == 9


def test_of_many_pins_the_wrong_rows_are_named(tmp_path: Path) -> None:
    design = skincad.load("nibs-fine")
    rows = [f"{i},{z!r}" for i, (_, _, z) in enumerate(crest_places(skin_of(design)), 1)]
    path = tmp_path / "crests.csv"
    path.write_text("\n".join(["pin,crest_mm", *rows[:36], rows[4], *rows[37:]]))
    with pytest.raises(InputError, match=r"each pin from 1 to \d+ once, got '5 2 times, 37 0 times'"):
        crest_drops(path, design)


@pytest.mark.parametrize(
    ("name", "column", "count"),
    [
        ("pillars-9", "pin", 9),
        ("rings-5", "ring", 5),
        ("flat-magnet", "place", 3),
        ("plain-ridges", "ridge", 9),
    ],
)
def test_each_family_has_its_places_and_its_column(
    name: str, column: str, count: int, tmp_path: Path
) -> None:
    design = skincad.load(name)
    places, lower = crest_places(skin_of(design)), [0.01 * i for i in range(count)]
    assert (crest_column(skin_of(design)), len(places)) == (column, count)
    rows = [f"{i},{z - drop!r}" for i, ((_, _, z), drop) in enumerate(zip(places, lower, strict=True), 1)]
    path = tmp_path / "crests.csv"
    for header in (column, "ridge"):  # which counts features of any family
        path.write_text("\n".join([f"{header},crest_mm", *rows]))
        assert crest_drops(path, design)[0] == pytest.approx(lower, abs=1e-12)
    path.write_text("\n".join([f"{column},crest_mm", *rows[:-1]]))
    with pytest.raises(InputError, match=f"must give crest_mm of each {column} from 1 to {count} once"):
        crest_drops(path, design)
    path.write_text("\n".join([f"{column},crest_mm", *rows[:-1], f"{count},-1.0"]))
    with pytest.raises(InputError, match=rf"{column} {count}: must be within .* mm \((\w+)\.\w+\) of the"):
        crest_drops(path, design)


def test_a_faces_places_lie_on_its_arc_and_both_sides_of_a_round_one_count_alike(tmp_path: Path) -> None:
    design = skincad.load("flat-magnet")
    for (x, y, z), place in zip(crest_places(skin_of(design)), FACE, strict=True):
        assert (x, y) == (pytest.approx(place * design.skin.width / 2), 0.0)
        assert math.hypot(x, z - design.skin.thickness + 60.0) == pytest.approx(60.0, abs=1e-9)
    bare = {"pocket": None, "rows": None, "columns": None, "pitch": None}
    disc = design.with_(skin={"outline": "round"}, flat=bare)
    heights = [z for _, _, z in crest_places(skin_of(disc))]
    rows = [f"{i},{z - drop!r}" for i, (z, drop) in enumerate(zip(heights, [0.1, 0.0, 0.3], strict=True), 1)]
    (tmp_path / "crests.csv").write_text("\n".join(["place,crest_mm", *rows]))
    assert crest_drops(tmp_path / "crests.csv", disc)[0] == pytest.approx((0.2, 0.0, 0.2), abs=1e-12)


def test_a_file_of_numbers_without_heights_is_refused(tmp_path: Path, yamada: Design) -> None:
    path = tmp_path / "crests.csv"
    path.write_text("ridge\n" + "\n".join(map(str, range(1, 10))))
    with pytest.raises(InputError, match="must have the columns ridge and crest_mm"):
        crest_drops(path, yamada)


@pytest.mark.parametrize("thickness", [1.0, 4.0])
def test_a_large_shift_of_all_crests_warns(yamada: Design, thickness: float) -> None:
    """One crest alone, however low, is no shift: the median counts."""
    design = yamada.with_(skin={"thickness": thickness}, slot=None, film=None, contact={"film": None})
    most = 0.02 * thickness
    assert shift_warnings((), design) == ()
    assert shift_warnings((0.4, *[0.0] * 8), design) == ()
    for sign, side in ((1, "lower"), (-1, "higher")):
        assert shift_warnings((sign * most,) * 9, design) == ()
        (said,) = shift_warnings((sign * 1.01 * most,) * 8 + (-0.4 * sign,), design)
        assert f"the median crest lies {1.01 * most:.3g} mm {side} than designed" in said
        assert f"another thickness than the {thickness:g} mm" in said


def circle(radius: float, x: float = 0.0, z: float = 0.0) -> tuple[Segment, ...]:
    """Four quarter arcs, counterclockwise."""
    corners = [Point(x + radius * c, z + radius * s) for c, s in ((1, 0), (0, 1), (-1, 0), (0, -1))]
    bulge = math.tan(math.pi / 8)
    return tuple(Segment(corners[i], corners[(i + 1) % 4], bulge) for i in range(4))


def test_circle_and_half_disk_have_area_perimeter_and_centroid() -> None:
    ring = circle(2.5, 3.0, -4.0)
    total, mx, mz = moments(ring)
    assert total == pytest.approx(math.pi * 2.5**2, rel=1e-14)  # rounding of a few sums
    assert (mx / total, mz / total) == pytest.approx((3.0, -4.0), rel=1e-14)
    assert length(ring) == pytest.approx(5 * math.pi, rel=1e-14)
    quarter = circle(2.0)[:2]
    half = (*quarter, Segment(quarter[-1].end, quarter[0].start))
    total, mx, mz = moments(half)
    assert mx == pytest.approx(0.0, abs=1e-13)
    assert mz / total == pytest.approx(4 * 2.0 / (3 * math.pi), rel=1e-13)  # rounding
    ring = circle(1.5, 0.2, 0.7)
    assert area(flipped(ring)) == pytest.approx(area(ring), rel=1e-14)
    assert area(tuple(s.reversed() for s in reversed(ring))) == pytest.approx(-area(ring), rel=1e-14)


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


def test_a_polygon_has_a_loops_corners_and_an_arcs_points_its_circle() -> None:
    arc = circle(2.0)[0]
    points = arc.points(np.linspace(0, 1, 9))
    assert np.hypot(*points.T) == pytest.approx(np.full(9, 2.0), abs=1e-14)
    assert arc.point(0.5) == pytest.approx((math.sqrt(2), math.sqrt(2)), abs=1e-14)
    # (4 - 14.6) / 2 - (-14.6 - 4) / 2 is 4 + 1e-15: a bore that ends at 4 would stay closed by a film
    block = rectangle(-26.519999999999996, 26.52, -14.6, 4.0)
    assert {tuple(p) for p in polygon(block, 1e-3)} == {tuple(s.start) for s in block}


@pytest.mark.parametrize("tolerance", [1e-2, 1e-4, 1e-6])
def test_polygon_keeps_within_its_tolerance_and_uses_it(tolerance: float) -> None:
    points = polygon(circle(1.0), tolerance)
    middles = (points + np.roll(points, -1, axis=0)) / 2
    sagitta = 1 - np.hypot(*middles.T).min()
    assert sagitta <= tolerance * (1 + 1e-9)  # rounding
    assert sagitta > tolerance / 4  # no more than twice as many chords as are needed


@pytest.mark.parametrize("distance", [0.3, -0.3])
def test_offset_of_a_rectangle_is_rounded_outward_and_sharp_inward(distance: float) -> None:
    (grown,) = offset(rectangle(0.0, 4.0, 0.0, 2.0), distance, 1e-4)
    x, z = grown.T
    shoelace = abs(float(np.sum(x * np.roll(z, -1) - z * np.roll(x, -1)))) / 2
    corners = math.pi * distance**2 if distance > 0 else 4 * distance**2
    exact = 8.0 + 12.0 * distance + corners  # Steiner's formula; inward it keeps square corners
    assert shoelace == pytest.approx(exact, abs=12 * 1e-4)  # perimeter x chord tolerance


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
def test_an_arc_has_as_few_chords_as_it_needs(sweep: float, radius: float, tolerance: float) -> None:
    """A chord over an angle a lies up to R (1 - cos(a / 2)) off its arc."""
    reach = 2 * radius * abs(math.sin(sweep / 2))
    arc = Segment(Point(0.0, 0.0), Point(reach, 0.0), math.tan(sweep / 4))
    assert arc.radius == pytest.approx(radius, rel=1e-9)
    count = arc.pieces(tolerance)
    most = tolerance * (1 + 1e-6)  # rounding of a radius by its chord
    assert 2 * radius * math.sin(sweep / 4 / count) ** 2 <= most
    assert count == 1 or 2 * radius * math.sin(sweep / 4 / (count - 1)) ** 2 > tolerance * (1 - 1e-6)
    assert Segment(arc.start, arc.end).pieces(tolerance) == 1
