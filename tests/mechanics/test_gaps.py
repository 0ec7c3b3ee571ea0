"""Gaps to the plate: ridges of unlike height, measured crests, shaped plates; symmetry, limits, by hand."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import skincad
from skincad import check, load
from skincad import mechanics as mech
from skincad.base import Estimate
from skincad.inputs import Design, Plate
from skincad.mechanics.models import finite_strain, linear, winkler
from skincad.shape import skin_of
from tests.mechanics.designs import BARE, THREE, assert_inside, linear_check, plane, yamada
from tests.refusals import refused_by

UNLIKE = (0.49, 0.5, 0.504)  # mm; no two alike, none symmetric, and all touch
FORCE = 1.0  # N, at which the three touch


def three(heights: Sequence[float] | None = None) -> Design:
    design = load("plain-ridges").with_(**THREE, contact={"friction": 0.0})
    return design if heights is None else design.with_(ridge={"heights": list(heights)})


def values(estimates: Sequence[Estimate]) -> np.ndarray:
    return np.array([estimate.value for estimate in estimates], dtype=float)


def test_half_of_a_levelled_skin_is_enough_and_all_of_an_unlike_one() -> None:
    assert mech.plane_piece(mech.pad_of(three().with_(ridge={"levelling": 0.8})), 0.5).mirrored
    assert mech.plane_piece(mech.pad_of(three((0.49, 0.5, 0.49))), 0.5).mirrored
    assert not mech.plane_piece(mech.pad_of(three(UNLIKE)), 0.5).mirrored
    assert not mech.plane_piece(mech.pad_of(three((0.5, 0.5, 0.5 + 1e-6))), 0.5).mirrored


@pytest.mark.parametrize(
    "answer",
    [
        pytest.param(linear.answer, marks=pytest.mark.slow),
        pytest.param(finite_strain.answer, marks=pytest.mark.evidence(subject="measured parts")),
    ],
)
def test_reversed_heights_reverse_the_ridges_forces(answer: object) -> None:
    """To the meshes' own errors: a mesh is not its own mirror image."""
    one, other = (answer(three(h), mech.Request(FORCE, 0.05)) for h in (UNLIKE, UNLIKE[::-1]))  # type: ignore[operator]
    error = 2 * float(one.ridge_force[0].error)
    assert np.ptp(values(one.ridge_force)) > 20 * error  # they tell which way round they are
    assert values(one.ridge_force) == pytest.approx(values(other.ridge_force)[::-1], abs=error)
    first, second = one.all_touch_force, other.all_touch_force
    assert first.value == pytest.approx(second.value, abs=(first.error or 0.0) + (second.error or 0.0))


def test_heights_all_alike_have_the_very_same_verdict() -> None:
    one, other = plane(three(), force=FORCE, tol=0.05), plane(three([0.5] * 3), force=FORCE, tol=0.05)
    assert one.all_touch_force == other.all_touch_force
    assert one.ridge_force == other.ridge_force


@pytest.mark.slow
def test_lower_ridges_are_as_a_measured_part_with_lower_crests(tmp_path: Path) -> None:
    """A measured part is the designed section, whole, with gaps: another mesh and another way to the gap. The
    ridges' stiffness changes with their height, by 2 % of a part of the whole."""
    even, drops = three(), [0.5 - height for height in UNLIKE]
    rows = [
        f"{i},{z - drop!r}" for i, (z, drop) in enumerate(zip(skin_of(even).crests, drops, strict=True), 1)
    ]
    (tmp_path / "crests.csv").write_text("ridge,crest_mm\n" + "\n".join(rows))
    part = check(even, model="linear", force=FORCE, measured=tmp_path / "crests.csv")
    designed = plane(three(UNLIKE), force=FORCE)
    first = designed.all_touch_force.value
    assert first == pytest.approx(part.all_touch_force.value, rel=0.02)
    # twice the crests' own difference in the force: what is compared is no rounding
    assert abs((plane(even, force=FORCE).all_touch_force.value or 0.0) / (first or 1.0) - 1) > 0.04
    assert values(designed.ridge_force) == pytest.approx(values(part.ridge_force), abs=0.02 * FORCE / 3)


def test_springs_of_unlike_ridges_by_hand() -> None:
    """k = L E' / (n T / W + 2 h / (root + tip)), each pressed by the plate less its own gap."""
    design = yamada().with_(**BARE, ridge={"heights": [0.5, 0.52, 0.5, 0.48, 0.5, 0.5, 0.47, 0.5, 0.55]})
    crests = np.array(skin_of(design).crests)
    gaps = crests.max() - crests
    assert winkler.crest_gaps(design) == pytest.approx(gaps, abs=1e-12)  # rounding of 4.5 mm
    stiffness = 12.0 * 0.8 / (1 - 0.499**2) / (9 * 4.0 / 11.0 + 2 * np.array(design.heights) / 1.25)
    approach = 0.3
    assert winkler.line_forces(design, approach) == pytest.approx(stiffness * (approach - gaps), rel=1e-10)
    for force in (0.1, 1.0, 4.0):  # one ridge carries, some, all
        verdict = check(design, model="winkler", force=force)
        carried = stiffness * np.maximum((verdict.approach.value or 0.0) - gaps, 0.0)
        assert carried.sum() == pytest.approx(force, rel=1e-9)
        assert values(verdict.ridge_force) == pytest.approx(carried, rel=1e-9, abs=1e-12)


def test_rows_of_springs_along_unlike_ridges_by_hand() -> None:
    """A second curvature: along y a crest falls away on its own arm about the axis."""
    heights = [0.5, 0.52, 0.5, 0.48, 0.5, 0.5, 0.47, 0.5, 0.55]
    design = yamada().with_(**BARE, skin={"curvature_radius_y": 20.0}, ridge={"heights": heights})
    crests, angle = np.array(skin_of(design).crests), (np.arange(200_000) + 0.5) * 0.3 / 200_000
    approach, per_mm = 0.05, 0.8 / (1 - 0.499**2) / (9 * 4.0 / 11.0 + 2 * np.array(heights) / 1.25)
    arm = 20.0 - 4.0 + crests
    depth = approach - (crests.max() - crests)
    depths = np.maximum(depth[:, None] - arm[:, None] * (1 - np.cos(angle)), 0.0)
    carried = per_mm * 20.0 * 2 * depths.sum(axis=1) * 0.3 / 200_000
    # the midpoint rule where contact ends
    assert winkler.line_forces(design, approach) == pytest.approx(carried, rel=1e-6, abs=1e-12)


@pytest.mark.parametrize("share", [1.0, pytest.param(0.5, marks=pytest.mark.slow)])
@pytest.mark.parametrize("crown", [0.0, 0.03])
def test_the_linear_model_lies_inside_the_springs_error(share: float, crown: float) -> None:
    """Levelled crests have hardly a gap; what leaning crowns add to it counts then."""
    design = yamada().with_(**BARE, ridge={"levelling": share, "crown": crown, "tip_fillet": 0.0})
    assert_inside(check(design, model="winkler"), plane(design, tol=0.05))


def test_crowns_highest_points_over_their_summits() -> None:
    """By points along the section's crowns."""
    for crown in (0.0, 0.001, 0.03):
        design = yamada().with_(**BARE, ridge={"levelling": 0.5, "crown": crown, "tip_fillet": 0.0})
        outline = skincad.section(design).outline
        over = [
            float(s.points(np.linspace(0, 1, 20001))[:, 1].max()) - s.point(0.5).z
            for s in outline
            if s.kind == "crown"
        ]
        assert winkler.crown_height_spread(design) == pytest.approx(max(over) - min(over), abs=1e-9)
    assert winkler.crown_height_spread(yamada()) == 0.0


def test_the_highest_ridge_says_when_one_tips_over() -> None:
    tall = three((0.5, 0.5, 1.5))
    assert mech.validity.buckling_force(tall) == mech.validity.buckling_force(
        three().with_(ridge={"height": 1.5})
    )
    verdict = check(tall, model="winkler", force=0.01)
    assert mech.ridge_strain(tall, verdict) == mech.ridge_strain(three(), verdict)  # by width and length


@pytest.mark.slow
def test_nine_ridges_touch_at_half_the_force_of_ridges_alike() -> None:
    """2.64 ± 0.38 N by `corrected` without levelling: half of that is 1.32 N."""
    levelled = load("yamada-2002", ["ridge.levelling=0.7"])
    verdict = check(levelled, force=1.32, model="corrected")
    assert verdict.passed
    assert verdict.touching == 9
    assert (verdict.all_touch_force.upper or 9.0) <= 1.32
    assert (verdict.manufacture.passing.value or 0.0) > 0.99  # of parts, with the process's crest errors


ERRORS = (0.006, 0.0, -0.008)  # mm, of the crests: no two alike, none symmetric
SAME = 1e-7  # relative; a shift of 0.1 mm leaves 1e-13 of a gap, the root of F9 is found to 1e-12
MEASURED = [
    "linear",
    *(
        pytest.param(t, marks=pytest.mark.evidence(subject="measured parts"))
        for t in ("corrected", "finite-strain")
    ),
]


def judged(
    design: Design, folder: Path, model: str, errors: Sequence[float], order: Sequence[int] = (1, 2, 3)
) -> mech.ContactCheck:
    """The verdict on a part whose crests are off by `errors` mm, its rows in this order of ridges."""
    crests = [
        skin_of(design).placed[r - 1].frame.at(0.0, design.ridge.height).z + errors[r - 1]
        for r in range(1, 4)
    ]
    rows = [f"{r},{crests[r - 1]!r}" for r in order]
    (folder / "crests.csv").write_text("ridge,crest_mm\n" + "\n".join(rows))
    return check(design, model=model, force=FORCE, tol=0.05, measured=folder / "crests.csv")


def numbers(verdict: mech.ContactCheck) -> np.ndarray:
    """F9, approach and the ridges' forces, each with its error."""
    estimates = [verdict.all_touch_force, verdict.approach, *verdict.ridge_force]
    return np.array([[estimate.value, estimate.error] for estimate in estimates], dtype=float)


@pytest.mark.slow
@pytest.mark.parametrize("model", MEASURED)
def test_the_datum_and_the_order_of_rows_change_nothing_and_a_mirror_mirrors(
    model: str, tmp_path: Path
) -> None:
    design = three()
    part = judged(design, tmp_path, model, ERRORS)
    assert part.touching == 3
    for shift in (0.15, 0.02, -0.15):  # above the highest crest as designed, and below the lowest
        moved = judged(design, tmp_path, model, [e + shift for e in ERRORS])
        assert numbers(moved) == pytest.approx(numbers(part), rel=SAME)
        assert (moved.passed, moved.touching) == (part.passed, part.touching)
        side = "higher" if shift > 0 else "lower"
        assert any(f"mm {side} than designed" in w for w in moved.warnings) == (abs(shift) > 0.1)
    assert numbers(judged(design, tmp_path, model, ERRORS, (2, 1, 3))).tolist() == numbers(part).tolist()
    mirrored = numbers(judged(design, tmp_path, model, ERRORS[::-1]))
    mirrored[2:] = mirrored[:1:-1]
    # the mesh is no mirror image of itself: as far apart as the errors allow, and no further
    assert (np.abs(mirrored - numbers(part))[:, 0] <= numbers(part)[:, 1]).all()


PLAIN = load("plain-ridges", ["ridge.count=5", "skin.width=7.0", "contact.force=2.2"])


def on(**plate: object) -> mech.Answer:
    return plane(PLAIN.with_(contact={"plate": plate}), tol=0.01)


@cache
def flat() -> mech.Answer:
    """On the mesh of a shaped plate's pad, which is not halved."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(linear, "plane_piece", lambda *a, **_: mech.plane_piece(*a, whole=True))
        return plane(PLAIN, tol=0.01)


def shares(verdict) -> np.ndarray:
    return np.array([f.value for f in verdict.ridge_force])


@pytest.mark.evidence(subject="shaped plates")
def test_a_plate_that_is_hardly_shaped_is_flat() -> None:
    for plate in (
        {"shape": "tilted", "tilt": 0.0},
        {"shape": "cylinder", "radius": 1e8},
        {"shape": "step", "height": 0.0},
    ):
        verdict = on(**plate)
        # the first touch is a sample here, the exact summit there: 1e-6 mm
        assert verdict.all_touch_force.value == pytest.approx(flat().all_touch_force.value, rel=1e-4)
        assert shares(verdict) == pytest.approx(shares(flat()), abs=1e-4)


@pytest.mark.slow
def test_tilting_the_other_way_mirrors_the_shares() -> None:
    left, right = on(shape="tilted", tilt=-0.3), on(shape="tilted", tilt=0.3)
    assert shares(left) == pytest.approx(shares(right)[::-1], abs=2e-3)  # the mesh is not a mirror's
    assert shares(right)[0] > shares(right)[-1]  # it rises towards +x: the last ridge is farther


def test_a_tilt_is_the_base_circle_rolled_aside() -> None:
    """On an arc, tilting by a moves the lowest point by R a: a hand calculation for the gaps."""
    x = np.linspace(-4, 4, 9)
    arc = 60.5 * (1 - np.cos(x / 60))
    gap = arc + mech.problem.rise(Plate(shape="tilted", tilt=1.0), 60.5 * np.sin(x / 60))
    assert x[np.argmin(gap)] == -1.0  # R a = 60 x 0.01745


@pytest.mark.slow
def test_a_cylinder_of_the_skins_own_radius_doubles_the_gaps() -> None:
    x = np.array([-4.0, 0.0, 4.0])
    height = mech.problem.rise(Plate(shape="cylinder", radius=60.5), x)
    assert height == pytest.approx(60.5 - np.sqrt(60.5**2 - x**2), rel=1e-9)  # closed form, cancelling
    assert on(shape="cylinder", radius=60.5).all_touch_force.value > 1.9 * flat().all_touch_force.value
    assert np.isinf(mech.problem.rise(Plate(shape="cylinder", radius=2.0), x)[0])


@pytest.mark.parametrize("model", ["winkler", pytest.param("linear", marks=pytest.mark.slow)])
def test_a_plate_that_is_higher_everywhere_is_the_flat_one(model: str) -> None:
    raised = PLAIN.with_(contact={"plate": {"shape": "step", "height": 0.3, "position": -100.0}})
    answer, same = (mech.run(model, design, mech.Request(2.2, 0.9), {}, None) for design in (raised, PLAIN))
    assert answer.approach.value == pytest.approx(same.approach.value, rel=1e-4)  # first touch is sampled
    assert shares(answer) == pytest.approx(shares(same), abs=1e-4)


@pytest.mark.slow
def test_a_step_unloads_the_ridges_under_it() -> None:
    verdict = on(shape="step", height=0.05, position=0.5)
    assert (shares(verdict)[3:] < shares(flat())[3:]).all()
    assert shares(verdict)[:3].sum() > shares(flat())[:3].sum()


@pytest.mark.parametrize(
    ("plate", "words"),
    [
        ({"shape": "cylinder"}, "contact.plate.radius: is missing"),
        ({"shape": "flat", "tilt": 1.0}, "contact.plate.shape: must be 'tilted' where tilt is given"),
        ({"shape": "cylinder", "radius": 6.0}, "contact.plate: must not slope by more than 0.35"),
        ({"shape": "tilted", "tilt": 30.0}, "contact.plate.tilt: must be less than or equal to 5"),
        ({"shape": "wedge"}, "contact.plate.shape: must be 'flat', 'tilted', 'cylinder' or 'step'"),
    ],
)
def test_a_plate_out_of_range_is_refused(plate: dict, words: str) -> None:
    with refused_by(words):
        linear_check(PLAIN.with_(contact={"plate": plate}))


@pytest.mark.parametrize("name", ["rings-5", "pillars-9"])
def test_a_plate_that_no_model_takes_is_refused(name: str) -> None:
    with refused_by("contact.plate.shape: must be 'flat' for pins and for a round skin, got 'tilted'"):
        skincad.check(skincad.load(name).with_(contact={"plate": {"shape": "tilted", "tilt": 1.0}}))
