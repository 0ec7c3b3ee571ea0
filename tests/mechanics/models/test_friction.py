"""Friction of the plate in a check: what it changes, its bound, against finer meshes and a scene."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from skincad import check, load, simulate
from skincad import mechanics as mech
from skincad.base import Estimate
from skincad.inputs import Design
from skincad.mechanics import check as adaptivity
from skincad.mechanics import left_out as bounds
from skincad.mechanics.models import friction as pressing
from skincad.outputs import CHECK
from skincad.scenes import load_scene
from tests.mechanics.designs import linear_check, small
from tests.mechanics.test_auto import LEFT, MadeUp

# mm at 4 N, `simulate yamada-2002-press --model small_strain` with effects.friction.coefficient 0 and 1
SMOOTH, ROUGH = 0.16860, 0.15950


def rubbed(coefficient: float | None) -> Design:
    return small().with_(contact={"friction": coefficient})


def exact(answer: mech.LevelAnswer) -> mech.Answer:
    """A coarse answer as a model's that knows it to the last digit."""
    shares = tuple(Estimate(float(f), 0.0, "N") for f in answer.ridge_force)
    first, down = Estimate(answer.all_touch_force, 0.0, "N"), Estimate(answer.approach, 0.0, "mm")
    return mech.Answer(len(shares), first, down, shares, answer.unknowns, answer.residual, {})


@cache
def on_yamada() -> mech.Correction:
    return pressing.solve(mech.plain_pad(load("yamada-2002")), 1.0, 4.0)


def test_a_scenes_press_gives_way_less_by_as_much() -> None:
    smooth = replace(exact(on_yamada().before), approach=Estimate(SMOOTH, 0.0, "mm"))
    approach = pressing.with_friction(smooth, on_yamada(), 4.0)[0].approach
    assert abs((approach.value or 0.0) - ROUGH) < 0.05 * (SMOOTH - ROUGH)
    assert approach.lower < ROUGH < approach.upper


@pytest.mark.evidence(subject="yamada-2002")
def test_the_scene_still_gives_way_so_far() -> None:
    for coefficient, approach in ((0.0, SMOOTH), (1.0, ROUGH)):
        scene = load_scene("yamada-2002-press", [f"effects.friction.coefficient={coefficient}"])
        march = simulate(scene, model="small_strain").march
        assert march.column("approach")[-1] == pytest.approx(approach, abs=6e-6)
        design = load("yamada-2002", [f"contact.friction={coefficient}"])
        smooth = linear_check(design, tol=0.05).approach
        bound = sum(part.approach for part in linear_check(design, tol=0.05).left_out) * (smooth.value or 0.0)
        assert abs((smooth.value or 0.0) - approach) <= (smooth.error or 0.0) - bound


def test_friction_raises_f9_and_takes_from_the_approach_on_thin_pads() -> None:
    """An independent linear solver: F9 + 0.8 to + 1.4 %, the approach - 4.6 to - 5.3 % at 0.2 to 1."""
    answer, _ = pressing.with_friction(exact(on_yamada().before), on_yamada(), 4.0)
    by_force = (answer.all_touch_force.value or 0.0) / (on_yamada().before.all_touch_force or 1.0) - 1
    by_approach = (answer.approach.value or 0.0) / on_yamada().before.approach - 1
    assert by_force == pytest.approx(0.014, abs=0.002)
    assert by_approach == pytest.approx(-0.053, abs=0.002)
    assert sum(f.value or 0.0 for f in answer.ridge_force) == pytest.approx(4.0, rel=1e-9)
    assert answer.all_touch_force.error == pytest.approx(
        (0.02 + 0.3 * by_force) * answer.all_touch_force.value
    )
    assert answer.approach.error == pytest.approx((0.005 - 0.5 * by_approach) * answer.approach.value)


OTHERS = [  # judged on: none of these set the errors
    pytest.param(name, coefficient, marks=pytest.mark.evidence(subject="friction: {name}"))
    for name in ("milled-pad", "steep-fingertip", "nozzle-04")
    for coefficient in (0.2, 1.0)
]


@pytest.mark.parametrize(
    ("name", "coefficient"), [pytest.param("small", 1.0, marks=pytest.mark.slow), *OTHERS]
)
def test_a_finer_mesh_and_more_steps_change_less_than_the_stated_error(name: str, coefficient: float) -> None:
    design = small() if name == "small" else load(name)
    force = design.contact.force
    fine = pressing.solve(mech.pad_of(design), coefficient, force, fineness=1.0, order=3, steps=200)
    assert_same(pressing.solve(mech.plain_pad(design), coefficient, force), fine, force)


@pytest.mark.parametrize(
    ("name", "coefficient"), [pytest.param("small", 0.4, marks=pytest.mark.slow), *OTHERS]
)
def test_a_finer_solid_changes_less_too(name: str, coefficient: float) -> None:
    """Fillets, a finer section and layers, twice the steps."""
    design = small() if name == "small" else load(name)
    force, finer = design.contact.force, mech.Layers(0.3, 1.8, 3)
    fine = mech.solve_solid(mech.pad_of(design), coefficient, force, (), finer, 1.3, 2, 2 * mech.SOLID_STEPS)
    assert_same(mech.solve_solid(mech.plain_pad(design), coefficient, force), fine, force)


def assert_same(coarse: mech.Correction, fine: mech.Correction, force: float) -> None:
    (answer, _), truth = pressing.with_friction(exact(fine.before), coarse, force), fine.after
    assert answer.all_touch_force.lower <= (truth.all_touch_force or 0.0) <= answer.all_touch_force.upper
    assert answer.approach.lower <= truth.approach <= answer.approach.upper
    missed = np.abs(np.array([f.value for f in answer.ridge_force]) - truth.ridge_force)
    assert missed.max() <= (answer.ridge_force[0].error or 0.0)


@pytest.mark.parametrize(
    "plate",
    [
        {"shape": "tilted", "tilt": 1.0},
        {"shape": "cylinder", "radius": 200.0},
        {"shape": "step", "height": 0.01},
    ],
)
def test_shaped_plates_are_pressed_with_friction(plate: dict[str, object]) -> None:
    pressed = pressing.solve(mech.pad_of(small().with_(contact={"plate": plate})), 0.5, 0.65).after
    assert pressed.ridge_force.sum() == pytest.approx(0.65, rel=1e-9)
    assert pressed.residual < 1e-10


@pytest.mark.slow
def test_measured_parts_are_pressed_with_friction() -> None:
    """Equal drops are none; a part that is not symmetric has other forces left than right."""
    level, same, lower = (
        pressing.solve(mech.pad_of(small()), 0.5, 0.65, drops).after
        for drops in ((), (0.02, 0.02, 0.02), (0.02, 0.02, 0.03))
    )
    assert same.all_touch_force == pytest.approx(level.all_touch_force, rel=1e-9)
    assert (lower.all_touch_force or 0.0) > 1.05 * (level.all_touch_force or 0.0)
    assert lower.ridge_force[2] < level.ridge_force[2]


@pytest.mark.slow
def test_solids_too() -> None:
    """A tilted plate moves sideways as no force holds it; a part's half is none."""
    tilted = small().with_(contact={"plate": {"shape": "tilted", "tilt": 1.0}})
    for pad, drops in ((mech.pad_of(tilted), ()), (mech.pad_of(small()), (0.0, 0.0, 0.02))):
        pressed = mech.solve_solid(pad, 0.5, 0.65, drops)
        assert pressed.after.ridge_force.sum() == pytest.approx(0.65, rel=1e-9)
        assert pressed.after.ridge_force[0] > 1.05 * pressed.after.ridge_force[2]
        assert pressed.after.residual < 1e-7


@pytest.fixture(scope="module")
def smooth() -> mech.ContactCheck:
    return linear_check(rubbed(0.0), tol=0.05)


def of(verdict: mech.ContactCheck) -> list[str]:
    return [part.effect for part in verdict.left_out]


@pytest.fixture
def made_up(monkeypatch: pytest.MonkeyPatch) -> MadeUp:
    """Models of test_auto.py, and no press with friction succeeds, so that its bound stays."""

    def fails(*_: object) -> None:
        raise mech.ContactError("the sets do not settle")

    monkeypatch.setattr(pressing, "solve", fails)
    monkeypatch.setattr(pressing, "solve_solid", fails)
    monkeypatch.setitem(LEFT, "friction", 0.03)
    return MadeUp(monkeypatch)


def test_an_unknown_coefficient_is_left_out_within_its_bound(smooth: mech.ContactCheck) -> None:
    verdict, bound = linear_check(rubbed(None), tol=0.05), mech.friction(rubbed(None), smooth.touching)
    assert of(smooth) == ["free ends", "finite strain"]
    assert of(verdict) == ["free ends", "finite strain", "friction"]
    for name, more in (("all_touch_force", bound.threshold), ("approach", bound.approach)):
        wider, before = getattr(verdict, name), getattr(smooth, name)
        assert wider.value == before.value
        assert wider.error == pytest.approx(before.error + more * before.value, rel=1e-9)
    assert verdict.ridge_force[0].error > smooth.ridge_force[0].error
    assert any("N for not knowing friction" in line for line in CHECK.lines(verdict))
    assert verdict.as_json()["left_out"][-1]["effect"] == "friction"


@pytest.mark.parametrize(("coefficient", "left"), [(None, True), (0.0, False), (0.5, True)])
def test_the_closed_form_computes_no_friction(coefficient: float | None, left: bool) -> None:
    verdict, without = (check(rubbed(c), model="winkler") for c in (coefficient, 0.0))
    assert of(verdict) == (["friction"] if left else [])
    assert verdict.all_touch_force.value == without.all_touch_force.value
    assert (verdict.all_touch_force.error > without.all_touch_force.error) == left


def test_a_known_coefficient_changes_the_answer_as_computed(smooth: mech.ContactCheck) -> None:
    verdict, design = linear_check(rubbed(0.5), tol=0.05), rubbed(0.5)
    assert of(verdict) == of(smooth)
    change = pressing.solve(mech.plain_pad(design), 0.5, 0.65)
    ratio = change.after.approach / change.before.approach
    assert verdict.approach.value == pytest.approx(ratio * smooth.approach.value, rel=1e-9)
    assert verdict.approach.value < 0.995 * smooth.approach.value
    assert sum(f.value for f in verdict.ridge_force) == pytest.approx(0.65, rel=1e-9)
    assert verdict.seconds["friction"] > 0


@pytest.mark.usefixtures("made_up")
def test_friction_that_fails_stays_left_out_and_says_so() -> None:
    design = load("yamada-2002").with_(contact={"friction": 15.0})
    for model, effects in (("linear", ["free ends", "finite strain"]), ("corrected", ["finite strain"])):
        verdict = check(design, model=model)
        assert of(verdict) == [*effects, "friction"]
        assert any("contact.friction is left out, within its bound: the sets" in w for w in verdict.warnings)


@pytest.mark.usefixtures("made_up")
def test_friction_that_does_not_fit_a_budget_stays_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pressing, "solve", lambda *_: pytest.fail("pressed"))
    monkeypatch.setattr(adaptivity, "linear_seconds", lambda _: 2.0)
    verdict = check(load("yamada-2002").with_(contact={"friction": 0.5}), model="linear", budget=2.1)
    assert "friction" in of(verdict)
    assert any("contact.friction is left out" in w and "would take about" in w for w in verdict.warnings)


@pytest.mark.parametrize(
    ("name", "model", "effects"),
    [
        ("plain-ridges", "corrected", ["finite strain", "friction", "friction along y"]),
        ("plain-ridges", "linear", ["free ends", "finite strain", "friction"]),
        ("yamada-2002", "corrected", ["finite strain", "friction"]),  # strips hold the ridges along y
        ("plain-ridges", "solid-finite-strain", ["friction", "friction along y"]),
    ],
)
@pytest.mark.usefixtures("made_up")
def test_along_y_it_counts_where_ends_are_free(
    name: str, model: str, effects: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where no press tells: bounds in closed form."""
    monkeypatch.setitem(LEFT, "friction along y", 0.1)
    assert of(check(load(name), model=model)) == effects
    assert bounds.friction_along(load(name)).threshold < 0.15


@pytest.mark.parametrize(
    ("tol", "model", "said"),
    [
        (0.4, "linear", False),
        (0.335, "corrected", False),  # linear would do without friction
        (0.05, "corrected-finite-strain", False),
        (0.034, "corrected-finite-strain", True),  # not to be met by friction: the rest meets it
        (0.02, "corrected-finite-strain", True),
        (0.005, "solid-finite-strain", True),
    ],
)
@pytest.mark.usefixtures("made_up")
def test_a_tolerance_that_friction_misses_is_climbed_for_without_it(
    tol: float, model: str, said: bool
) -> None:
    verdict = check(load("yamada-2002"), tol=tol)
    assert verdict.model == model
    missed = [w for w in verdict.warnings if "not met" in w]
    assert bool(missed) == said
    assert all("friction may change it by 0.03: give contact.friction" in w for w in missed)


@pytest.mark.parametrize(
    ("value", "model", "hangs"),
    [
        (2.9, "linear", False),
        (3.7, "corrected-finite-strain", False),  # 3.7 N and 4 %
        (3.9, "solid-finite-strain", True),  # 1 % and 3 %: a better model might move it
        (3.99, "corrected-finite-strain", False),  # no model moves it far enough
    ],
)
def test_no_model_is_climbed_for_what_friction_leaves_open(
    value: float, model: str, hangs: bool, made_up: MadeUp, monkeypatch: pytest.MonkeyPatch
) -> None:
    made_up.value = value
    monkeypatch.setattr(adaptivity, "DEFAULT_BUDGET", 40.0)
    monkeypatch.setattr(adaptivity, "SHARP_SECONDS", 0.0)
    verdict = check(load("yamada-2002"), force=4.0)
    assert verdict.model == model
    words = "the verdict depends on friction, which is not known: give contact.friction"
    assert (words in verdict.warnings) == hangs


@pytest.mark.usefixtures("made_up")
def test_a_meshs_tolerance_that_is_missed_is_not_blamed_on_friction() -> None:
    """A model by name is asked for its mesh's error alone."""
    verdict = check(load("yamada-2002"), model="linear", tol=0.005)
    assert [w for w in verdict.warnings if "not met" in w] == [
        "the all-touch force's error is 0.01 of its value: the tolerance 0.005 is not met"
    ]


@pytest.mark.usefixtures("made_up")
def test_a_coefficient_that_is_given_is_not_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """Along y none computes it: what is said of a missed tolerance names the effect alone."""
    monkeypatch.setitem(LEFT, "friction along y", 0.2)
    verdict = check(load("plain-ridges", ["contact.friction=0.5"]), tol=0.12)
    assert verdict.model == "corrected"  # 0.1 and its mesh; 0.23 stays in any case
    assert [w for w in verdict.warnings if "not met" in w] == [
        "the all-touch force's error is 0.34 of its value: the tolerance 0.12 is not met; "
        "friction may change it by 0.03 and friction along y may change it by 0.2"
    ]
    assert verdict.friction == verdict.as_json()["friction"] == 0.5


@pytest.fixture(scope="module")
def corrected() -> dict[float | None, mech.ContactCheck]:
    return {c: check(rubbed(c), model="corrected", tol=0.05) for c in (None, 0.0, 0.3, 1.0)}


@pytest.mark.slow
def test_with_free_ends_an_unknown_coefficient_lies_between_none_and_much(
    corrected: dict[float | None, mech.ContactCheck],
) -> None:
    """The middle of both; what is left out is half their distance."""
    unknown = corrected[None]
    assert of(unknown) == ["finite strain", "friction"]
    assert all(of(corrected[known]) == ["finite strain"] for known in (0.0, 0.3, 1.0))
    for name, key in (("all_touch_force", "threshold"), ("approach", "approach")):
        none, much = (getattr(corrected[known], name).value for known in (0.0, 1.0))
        middle = getattr(unknown, name)
        assert middle.value == pytest.approx((none + much) / 2, rel=1e-9)
        assert getattr(unknown.left_out[-1], key) * middle.value == pytest.approx(
            abs(much - none) / 2 * middle.value / none, rel=1e-9
        )
        assert middle.lower <= min(none, much) <= max(none, much) <= middle.upper
        between = getattr(corrected[0.3], name).value
        assert min(none, much) < between < max(none, much)
    assert unknown.seconds["friction"] > 0
    assert any("N for not knowing friction" in line for line in CHECK.lines(unknown))


@pytest.mark.slow
def test_friction_holds_the_free_ends_too(corrected: dict[float | None, mech.ContactCheck]) -> None:
    """Ends that cannot bulge take less from the all-touch force: more than friction on a section changes."""
    none, much = corrected[0.0].all_touch_force.value, corrected[1.0].all_touch_force.value
    section = pressing.solve(mech.plain_pad(rubbed(1.0)), 1.0, 0.65)
    in_plane = section.after.all_touch_force / section.before.all_touch_force - 1
    assert much / none - 1 > in_plane + 0.03


@pytest.mark.slow
def test_at_finite_strain_what_is_lost_of_the_change_is_in_the_error() -> None:
    """By finite strain's bound; a section at finite strain keeps a quarter, and as much as all is the
    error."""
    design = rubbed(1.0)
    large = mech.finite_strain(design, linear_check(rubbed(0.0), tol=0.05), 0.65)
    section, solid = (
        pressing.solve(mech.plain_pad(design), 1.0, 0.65),
        mech.solve_solid(mech.plain_pad(design), 1.0, 0.65),
    )
    fine = exact(solid.before)
    for presses in (section, solid):
        small_strain, _ = pressing.with_friction(fine, presses, 0.65)
        changed, left = pressing.with_friction(fine, presses, 0.65, strain=large)
        change = small_strain.all_touch_force.value / fine.all_touch_force.value - 1
        by_strain = changed.all_touch_force.value / fine.all_touch_force.value - 1
        first, last = small_strain.all_touch_force, changed.all_touch_force
        more = last.error / last.value - first.error / first.value
        assert left == ()
        if presses is solid:
            assert by_strain == pytest.approx(
                change - pressing.LOST.threshold * large.threshold / 2, rel=1e-9
            )
            assert more == pytest.approx(pressing.LOST.threshold * large.threshold / 2, rel=1e-6)
        else:
            assert by_strain == pytest.approx(pressing.PLANE_PART * change, rel=1e-9)
            assert more == pytest.approx(abs(change), rel=1e-6)


@pytest.mark.slow
def test_a_pad_too_large_for_friction_keeps_its_bound() -> None:
    wide = {"skin": {"curvature_radius": 3000.0, "width": 154.0}, "ridge": {"count": 150}}
    design = load("plain-ridges").with_(**wide, contact={"friction": 0.5})
    with pytest.raises(mech.SizeError, match="at most 1000 contact points"):
        pressing.solve(mech.plain_pad(design), 0.5, 4.0)
