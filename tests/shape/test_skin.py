import math
from itertools import pairwise

import numpy as np
import pytest

import skincad
from skincad.base import InputError
from skincad.inputs import Design, template_names
from skincad.shape import area, concentric_hit, polygon, section, skin_of


def test_area_agrees_with_a_fine_polygon(variants: dict[str, Design]) -> None:
    for name, design in variants.items():
        outline = section(design).outline
        x, z = polygon(outline, 1e-8).T
        shoelace = float(np.sum(x * np.roll(z, -1) - z * np.roll(x, -1))) / 2
        # chords cut off at most tolerance x perimeter
        assert area(outline) == pytest.approx(shoelace, abs=1e-8 * 300), name


def test_outline_is_closed_and_smooth_at_fillets(variants: dict[str, Design]) -> None:
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


def test_outer_crests_sit_where_the_circle_puts_them(yamada: Design) -> None:
    outer, middle = skin_of(yamada).placed[8].frame, skin_of(yamada).placed[4].frame
    lean = 4 / 60
    drop = (60 + 0.5) * (1 - math.cos(lean))
    summit, top = outer.at(0.0, 0.5), middle.at(0.0, 0.5)
    assert top.z - summit.z == pytest.approx(drop, rel=1e-12)
    assert drop == pytest.approx(0.133, abs=0.0015)  # docs/evidence/facts.md#the-reference-section


def test_section_mirrors_itself(yamada: Design) -> None:
    points = polygon(section(yamada).outline, 1e-4)
    for x, z in points * [-1, 1]:
        assert np.hypot(*(points - [x, z]).T).min() < 1e-9  # rounding; corners are 0.01 mm apart
    assert section(yamada).centroid.x == pytest.approx(0.0, abs=1e-12)


def test_default_slots_leave_the_stated_wall_and_web(yamada: Design) -> None:
    s1, s2 = section(yamada).slots[8:10]
    web = s2.at(-s2.thickness / 2, 0.0).x - s1.at(s1.thickness / 2, 0.0).x
    assert web == pytest.approx(0.27, abs=1e-9)  # 2 x 0.16 of offset less 0.05
    assert (s1.side, s2.side, s1.feature) == ("S1", "S2", 5)
    assert s1.centre.x < 0 < s2.centre.x


def test_positive_tilt_leans_the_tops_inward() -> None:
    left, right = section(skincad.load("yamada-2002-tilted")).slots[8:10]
    assert left.direction.x > 0 > right.direction.x
    assert math.degrees(math.atan2(left.direction.x, left.direction.z)) == pytest.approx(45.0)


def test_doubling_all_lengths_doubles_the_section() -> None:
    small, large = (section(skincad.load(n)) for n in ("yamada-2002", "lab-bench"))
    assert area(large.outline) == pytest.approx(4 * area(small.outline), rel=1e-14)


@pytest.mark.parametrize("name", template_names())
def test_every_template_has_a_section(name: str) -> None:
    assert section(skincad.load(name)).area > 0


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
def test_what_does_not_fit_is_refused(
    yamada: Design, change: dict[str, dict[str, float]], key: str, words: str
) -> None:
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
def test_a_flank_that_no_fillet_could_meet_is_not_laid_to_one(
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
    low, high = (
        yamada.with_(
            ridge={"crown": share * steep, "height": ridge.height - ridge.crown + share * steep}, slot=None
        )
        for share in (0.9, 1.1)
    )
    bare = {"tip_fillet": 0.0, "root_fillet": 0.0}
    assert section(low.with_(ridge=bare))
    with pytest.raises(InputError, match=r"^ridge.crown: makes"):
        section(high.with_(ridge=bare))


def test_a_ridge_without_fillets_has_no_tiny_edges(yamada: Design) -> None:
    """Rounding made a fillet of radius 0 an edge of 1e-17 mm, and one root in ten crossed itself by it."""
    sharp = yamada.with_(
        slot=None,
        skin={"curvature_radius": 20.0},
        ridge={"tip_width": 0.75, "crown": 0.0, "tip_fillet": 0.0, "root_fillet": 0.0},
    )
    for root in np.linspace(0.76, 0.98, 23):
        outline = section(sharp.with_(ridge={"root_width": float(root)})).outline
        assert min(s.chord for s in outline) > 1e-3
        assert not any(s.kind in ("tip_fillet", "root_fillet") for s in outline)


@pytest.mark.parametrize("fillets", [(0.05, 0.08), (0.1, 0.02), (0.0, 0.05), (0.03, 0.0)])
def test_fillets_have_their_radius_and_touch_what_they_join(
    yamada: Design, fillets: tuple[float, float]
) -> None:
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
            assert math.remainder(turn, 2 * math.pi) == pytest.approx(
                0.0, abs=1e-9
            )  # rounding of short chords
    for segment in ridge:
        if segment.kind == "tip_fillet":
            assert segment.radius == pytest.approx(tip, rel=1e-9)
            assert segment.bulge > 0
        if segment.kind == "root_fillet":
            assert segment.radius == pytest.approx(root, rel=1e-9)
            assert segment.bulge < 0


@pytest.mark.parametrize("radius", [2.0, 60.0, 1e7])
@pytest.mark.parametrize("level", [-0.5, 0.0, 0.3])
def test_a_line_meets_a_circle_that_is_concentric_with_the_base(radius: float, level: float) -> None:
    start, along = np.array([0.4, -0.6]), np.array([0.28, 0.96])

    def over(u: float) -> float:
        """Distance of the line's point from the circle of this radius about (0, -radius)."""
        x, n = start + u * along
        return float((x * x + n * n + 2 * radius * n) / (math.hypot(x, n + radius) + radius))

    u = concentric_hit(start, along, 1 / radius, level + level**2 / (2 * radius))
    assert u is not None
    assert over(u) == pytest.approx(level, abs=1e-9)
    assert concentric_hit(start, -along, 1 / radius, 0.3) is None  # it falls
    assert concentric_hit(np.array([0.0, -0.6]), np.array([1.0, 0.0]), 1 / radius, 0.3) is None  # it is level
    beside = np.array([-3 * radius, 0.0])
    assert concentric_hit(beside, np.array([0.0, 1.0]), 1 / radius, 0.0) is None  # it misses the circle
