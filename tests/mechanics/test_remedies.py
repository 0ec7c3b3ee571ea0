"""What would pass: changes found by asking a judge whose law is known, and by asking a real one."""

from __future__ import annotations

import math

import pytest

from skincad import check, load
from skincad.base.errors import InputError
from skincad.base.estimate import Estimate
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.mechanics.problem import ContactError
from skincad.mechanics.remedies import CLOSE, cause, changes
from tests.mechanics.designs import SHORT, reference

ERROR = 0.1  # relative


def needed(design: Design, power: float = -1.2) -> Estimate:
    """3 N at 60 mm, 0.8 MPa and 12 mm; with the modulus and the length, and a power of the radius."""
    skin, modulus = design.skin, silicone(design).young_modulus.value
    value = 3.0 * (skin.curvature_radius / 60.0) ** power * modulus / 0.8 * skin.length / 12.0
    return Estimate(value, ERROR * value, "N")


def judged(design: Design, force: float = 2.0, power: float = -1.2) -> tuple[bool, Estimate]:
    found = needed(design, power)
    return (found.upper or math.inf) <= force, found


def plain() -> Design:
    return load("plain-ridges").with_(material={"name": None, "young_modulus": 0.8, "poisson_ratio": 0.499})


def test_each_change_passes_alone_and_is_hardly_larger_than_it_has_to_be() -> None:
    found = changes(plain(), needed(plain()), 2.0, judged)
    assert [change.key for change in found] == [
        "skin.curvature_radius",
        "material.young_modulus",
        "skin.length",
    ]
    for change in found:
        assert CLOSE * 2.0 <= (change.all_touch_force.upper or math.inf) <= 2.0
    # by hand: 1.1 x 3 N have to become 2, a factor of 0.606
    assert 60 * 0.606 ** (-1 / 1.2) <= found[0].after <= 60 * (0.9 * 0.606) ** (-1 / 1.2)
    assert 0.8 * 0.606 * 0.9 <= found[1].after <= 0.8 * 0.606
    assert [change.before for change in found] == [60.0, 0.8, 12.0]
    assert str(found[2]) == f"skin.length 12 -> {found[2].after:g}"
    assert found[2].as_json()["before"] == 12.0


@pytest.mark.parametrize("power", [-0.6, -3.0])
def test_the_slope_is_found_on_the_way(power: float) -> None:
    (radius, *_) = changes(plain(), needed(plain()), 2.0, lambda design: judged(design, 2.0, power))
    assert 0.606 >= (radius.after / 60.0) ** power >= 0.9 * 0.606


def test_where_no_force_is_known_to_suffice_values_are_doubled_or_halved_first() -> None:
    def lost(design: Design) -> tuple[bool, Estimate]:
        return judged(design) if design.skin.curvature_radius > 100.0 else (False, Estimate(None, None, "N"))

    found = changes(plain(), Estimate(None, None, "N"), 2.0, lost)
    assert [change.key for change in found] == ["skin.curvature_radius"]
    assert found[0].after >= 120.0


@pytest.mark.parametrize(
    "refusal", [InputError("skin.length", "must be larger"), ContactError("does not settle")]
)
def test_what_is_refused_is_no_change(refusal: Exception) -> None:
    def judge(design: Design) -> tuple[bool, Estimate]:
        if design.skin.length < 12.0:
            raise refusal
        return judged(design)

    found = changes(plain(), needed(plain()), 2.0, judge)
    assert [change.key for change in found] == ["skin.curvature_radius", "material.young_modulus"]


def test_what_never_passes_is_no_change() -> None:
    assert changes(plain(), needed(plain()), 2.0, lambda design: (False, needed(design))) == ()
    assert changes(plain(), needed(plain()), 0.01, judged) == ()  # by more than a factor of 8


def test_the_modulus_keeps_its_range() -> None:
    """A part's modulus scatters by as much of it as before."""
    seen = []

    def judge(design: Design) -> tuple[bool, Estimate]:
        seen.append(silicone(design).young_modulus)
        return judged(design)

    wide = plain().with_(material={"young_modulus": {"value": 0.8, "low": 0.6, "high": 1.2}})
    changes(wide, needed(wide), 2.0, judge)
    changed = min(seen, key=lambda modulus: modulus.value)
    assert (changed.low / changed.value, changed.high / changed.value) == pytest.approx((0.75, 1.5))


def test_the_cause_is_in_millimetres() -> None:
    """The outer of nine ridges stand 4 mm of arc from the middle: 60.5 (1 - cos(4 / 60)) lower."""
    said = cause(plain(), 0.1234, 2.0)
    assert said.startswith("the lowest crest lies 0.13 mm below the highest, of ridges 0.5 mm high")
    assert said.endswith("at 2 N the plate comes 0.12 mm down")


@pytest.mark.parametrize("tier", ["winkler", pytest.param("linear", marks=pytest.mark.slow)])
def test_a_check_that_fails_names_changes_that_its_own_model_lets_pass(tier: str) -> None:
    design = reference().with_(**SHORT, contact={"force": 0.1, "friction": 0.0})
    assert check(design, tier="winkler").changes is None  # not asked
    found = check(design, tier=tier, tol=0.05, advise=True)
    assert not found.passed
    assert found.changes
    assert "mm below the highest" in found.cause
    for change in found.changes:
        table, key = change.key.split(".")
        assert check(design.with_(**{table: {key: change.after}}), tier=tier, tol=0.05).passed


def test_advice_is_for_designs_that_fail() -> None:
    design = reference().with_(**SHORT, contact={"force": 0.65, "friction": 0.0})
    found = check(design, tier="linear", tol=0.05, advise=True)
    assert (found.passed, found.changes, found.cause) == (True, None, "")
    with pytest.raises(InputError, match=r"^advise: "):
        check(design, budget=1.0, advise=True)
