"""Verdicts near the force that is needed: one of three words, and numbers that agree with it."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import count

import numpy as np
import pytest

from bench.campaign.random_designs import drawn
from skincad import InputError, RefusedError, check, load
from skincad.mechanics import ContactCheck
from skincad.mechanics import check as adaptivity
from skincad.mechanics.models import table

NEAR = 0.03  # relative: how far the applied forces lie from the one that is needed


def near_the_needed_force(model: str, members: int) -> Iterator[ContactCheck]:
    """Checks of random designs at the force that they need times 0.97 to 1.03."""
    dice, seeds = np.random.default_rng(34), count()
    while members:
        design = drawn(next(seeds)).design
        bent = {"skin": {"curvature_radius_y": None}} if design.skin.curvature_radius_y else {}
        design = design.with_(**bent, contact={"plate": {"shape": "flat"}})
        try:
            needed = check(design, model=model, tol=0.05).all_touch_force.value
            if not needed or needed < 0.01 * design.contact.force:  # 0.01: FLOOR, known in parts of the force
                continue
            verdict = check(design, model=model, tol=0.05, force=needed * dice.uniform(1 - NEAR, 1 + NEAR))
        except (InputError, RefusedError):  # crushed by such a force
            continue
        members -= 1
        yield verdict


def consistent(verdict: ContactCheck) -> None:
    force, value = verdict.all_touch_force, verdict.all_touch_force.value
    assert value is not None
    assert force.lower is not None
    assert force.upper is not None
    expected = (
        "passes" if force.upper <= verdict.force else "fails" if force.lower > verdict.force else "undecided"
    )
    assert verdict.verdict == (expected if not verdict.out_of_range else "undecided")
    assert verdict.passed == (verdict.verdict == "passes")
    assert str(verdict).upper().startswith(verdict.verdict.upper())
    assert ("\nNext: " in str(verdict)) == (verdict.verdict == "undecided")
    # the count and the ridge forces say the same as the all-touch force
    shares = np.array([share.value for share in verdict.ridge_force], dtype=float)
    assert (verdict.touching == verdict.ridges) == (value <= verdict.force)
    assert np.count_nonzero(shares) == verdict.touching
    assert shares.sum() == pytest.approx(verdict.force, rel=1e-6)  # the contact residual


def test_winkler_verdicts_near_the_needed_force_agree_with_themselves() -> None:
    for verdict in near_the_needed_force("winkler", 40):
        consistent(verdict)


@pytest.mark.slow
@pytest.mark.parametrize(("model", "members"), [("linear", 8), ("corrected", 6)])
def test_verdicts_near_the_needed_force_agree_with_themselves(model: str, members: int) -> None:
    """Before, a corrected count contradicted its force: "4 of 6 touch at 2.49 N; all need 2.44 N"."""
    for verdict in near_the_needed_force(model, members):
        consistent(verdict)


@pytest.mark.slow
def test_without_tolerance_or_budget_no_late_model_is_begun(monkeypatch: pytest.MonkeyPatch) -> None:
    """An undecided check names the next model and its time; with a tolerance it takes the time it needs."""
    monkeypatch.setattr(adaptivity, "DEFAULT_BUDGET", 0.0)
    design = load("plain-ridges", ["contact.force=3.0"])
    early = check(design)
    assert (early.model, early.verdict) == ("linear", "undecided")
    assert early.next_step.startswith("`--model corrected` (about ")
    assert check(design, tol=0.3).model != "linear"


def test_a_pad_of_very_many_ridges_has_an_answer_within_any_budget(monkeypatch: pytest.MonkeyPatch) -> None:
    """Or with the reduced model, if the budget suffices for that. Here every pad is large."""
    monkeypatch.setitem(table.AUTO_IF, "reduced", lambda _: True)
    monkeypatch.setattr(adaptivity, "DEFAULT_BUDGET", 1e-6)
    design = load("plain-ridges", ["contact.force=3.0"])
    for budget, model in ((1e-3, "winkler"), (None, "reduced")):
        verdict = check(design, budget=budget)
        assert verdict.model == model
        assert verdict.next_model is not None
        assert verdict.next_model.model in ("linear", "corrected")
