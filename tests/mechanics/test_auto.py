"""`auto`: which models it takes, when it ends, and what it does with a model that refuses."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial
from itertools import product
from operator import attrgetter
from typing import Any

import numpy as np
import pytest
from netgen.meshing import NgException

from skincad import InputError, RefusedError, check, load
from skincad import mechanics as mech
from skincad.base import Estimate, ExhaustedError
from skincad.inputs import Design
from skincad.mechanics import check as adaptivity
from skincad.mechanics import expected_seconds
from skincad.mechanics import manufacture as manufacturing
from skincad.mechanics.bodies import elements
from skincad.mechanics.film import stress
from skincad.mechanics.models import finite_strain, linear, solid
from skincad.mechanics.models import table as models
from tests.mechanics.designs import filleted, linear_check, plane, small, wide, yamada


@pytest.mark.evidence(subject="auto: yamada-2002")
def test_yamada_passes() -> None:
    verdict = check(yamada())
    assert (verdict.passed, verdict.touching, verdict.model) == (True, 9, "corrected-finite-strain")


@pytest.mark.parametrize(
    ("key", "bad"),
    [*product(("force", "tol", "budget"), (0.0, -1.0, math.nan, math.inf)), ("force", 1.01e6), ("tol", 1.5)],
)
def test_bad_arguments_are_refused(key: str, bad: float) -> None:
    with pytest.raises(InputError, match=f"^{key}: must be (above 0|between 0 and 1)"):
        check(yamada(), **{key: bad})


@pytest.mark.slow
def test_auto_goes_on_until_the_verdict_is_clear_and_sharp() -> None:
    """Then on, as seconds make it sharp: filleted ridges without strips."""
    verdict = check(filleted())
    assert (verdict.passed, verdict.touching, verdict.ridges, verdict.force) == (True, 9, 9, 4.0)
    assert verdict.model == "corrected-finite-strain"
    assert [run.model for run in verdict.models_tried] == ["linear", "corrected"]
    before = verdict.models_tried[0].all_touch_force
    assert before.value < 4.0 < before.upper  # what the linear model leaves open
    assert verdict.all_touch_force.upper < 4.0
    assert verdict.all_touch_force.error < 0.03 * verdict.all_touch_force.value
    # the plate's force is the sum of the shares: the contact residual
    assert sum(f.value or 0.0 for f in verdict.ridge_force) == pytest.approx(4.0, rel=1e-9)
    assert verdict.residual < 1e-6


SLOW = [
    pytest.param(
        tol,
        model,
        marks=pytest.mark.evidence(subject="auto: yamada-2002") if tol == 0.01 else pytest.mark.slow,
    )
    for tol, model in ((0.15, "corrected"), (0.01, "solid-finite-strain"))
]


@pytest.mark.parametrize(("tol", "model"), [(0.95, "winkler"), (0.45, "linear"), *SLOW])
def test_auto_takes_the_cheapest_model_that_meets_the_tolerance(tol: float, model: str) -> None:
    verdict = check(small() if tol > 0.1 else yamada(), tol=tol)
    assert verdict.model == model
    assert verdict.all_touch_force.error <= tol * verdict.all_touch_force.value
    assert not any("not met" in w for w in verdict.warnings)


@pytest.mark.slow
def test_the_error_is_the_meshs_and_the_models() -> None:
    verdict = linear_check(filleted())
    mesh = verdict.all_touch_force.error - verdict.model_error
    assert 0 < mesh < 0.01 * verdict.all_touch_force.value < 0.1 * verdict.model_error
    assert [bound.effect for bound in verdict.left_out] == ["free ends", "finite strain"]
    assert verdict.margin == pytest.approx(4.0 - verdict.all_touch_force.upper)
    assert verdict.next_model.model == "corrected"


def test_a_budget_that_no_mesh_fits_buys_the_closed_form_and_says_so() -> None:
    """By what the first mesh took."""
    verdict = check(yamada(), budget=1e-3)
    assert verdict.model == "winkler"
    assert any("would take about" in w and "of the budget of 0.001 s" in w for w in verdict.warnings)
    assert verdict.next_model.model == "linear"
    assert verdict.next_model.seconds > 1e-3


@pytest.mark.slow
def test_beyond_small_strain_auto_asks_finite_strain_however_clear_the_verdict(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Three ridges at 1.3 N are clear by the linear model, and strained by 0.12: no time is left to sharpen
    it, and yet a better model judges."""
    pad = small()
    monkeypatch.setattr(adaptivity, "SHARP_SECONDS", 0.0)
    assert check(pad, force=0.65).model == "linear"
    first = linear_check(pad, force=1.3)
    assert first.passed
    assert any("small-strain range" in w for w in first.warnings)
    verdict = check(pad, force=1.3)
    assert verdict.model == "corrected-finite-strain"
    assert verdict.passed


@pytest.mark.evidence(subject="steep-fingertip")
def test_two_models_of_one_law_agree_on_a_steep_pad() -> None:
    """By the small strains of `linear` it passes from 1.9 N on; what auto asks then the solid says too."""
    verdict, best = (check(load("steep-fingertip"), model=model) for model in ("auto", "solid-finite-strain"))
    assert (verdict.model, verdict.passed, best.passed) == ("corrected-finite-strain", True, True)
    for of in (attrgetter("all_touch_force"), attrgetter("approach")):
        assert abs(of(verdict).value - of(best).value) <= of(verdict).error + of(best).error


@pytest.mark.evidence(subject="auto: out of range")
def test_a_force_out_of_a_better_models_range_has_no_verdict() -> None:
    """The small strains of `corrected` would say that all touch; at finite strain a ridge tips over."""
    hard = filleted().with_(ridge={"count": 3}, skin={"width": 4.0}, contact={"force": 12.0})
    verdict = check(hard, tol=0.01)
    assert verdict.model == "corrected"
    assert not verdict.passed
    assert "finite-strain model's range" in verdict.out_of_range
    assert verdict.next_model is None


def test_a_model_is_priced_by_what_the_last_one_took() -> None:
    """0.1 s a ridge where none is solved; else each part by the last one's seconds over its price."""
    solved = {
        name: replace(QUICK, own_seconds=seconds) for name, seconds in (("linear", 2.0), ("winkler", 9.0))
    }
    price = {name: mech.MODELS[name].price for name in mech.MODELS}
    ahead = price["corrected"] + price["corrected-finite-strain"]
    assert expected_seconds("corrected-finite-strain", yamada(), {}) == pytest.approx(0.1 * 9 * (1 + ahead))
    assert expected_seconds("corrected-finite-strain", yamada(), solved) == pytest.approx(2.0 * ahead)
    solved["corrected"] = replace(QUICK, own_seconds=1.0)
    assert expected_seconds("corrected-finite-strain", yamada(), solved) == pytest.approx(
        price["corrected-finite-strain"] / price["corrected"]
    )
    assert expected_seconds("linear", yamada(), solved) == 0.0


QUICK = mech.Answer(
    1, Estimate(0.0, 0.0, "N"), Estimate(0.1, 0.0, "mm"), (Estimate(1.0, 0.0, "N"),), 1, 0.0, {}
)
PRICES = {"linear": 1.0, "corrected": 2.0, "corrected-finite-strain": 4.5, "solid": 8.0}
LEFT = {"free ends": 0.2, "finite strain": 0.1}


class MadeUp:
    """Models that take twice their price in seconds of a clock of their own, and answer at once: F9 of
    `value` N with 1 % of it as the mesh's error (`mesh`); what is left out of a model is LEFT."""

    def __init__(self, patch: pytest.MonkeyPatch, value: float = 3.0) -> None:
        self.value, self.mesh, self.now = value, 0.01, 100.0
        self.asked: dict[str, mech.Request] = {}
        self.refusals: dict[str, Exception] = {}
        winkler = models.load("winkler")
        patch.setattr(
            models, "load", lambda name: winkler if name == "winkler" else partial(self.answer, name)
        )
        patch.setattr(adaptivity, "perf_counter", lambda: self.now)
        patch.setattr(adaptivity, "expected_seconds", self.expected_seconds)
        patch.setattr(adaptivity, "YIELD_PRICE", 0.0)
        patch.setattr(adaptivity, "left_out", lambda effects, *_: tuple(map(self.bound, effects)))

    def answer(self, name: str, _: Any, request: mech.Request, *__: object) -> mech.Answer:
        seconds = 2 * PRICES.get(name, 3.0)
        if request.must_fit and request.budget is not None and seconds > request.budget:
            raise mech.LateError(seconds)
        if name in self.refusals:
            raise self.refusals[name]
        self.now += seconds
        self.asked[name] = request
        first, down = Estimate(self.value, self.mesh * self.value, "N"), Estimate(0.1, 0.0, "mm")
        shares = (Estimate(request.force / 9, 0.0, "N"),) * 9
        return mech.Answer(9, first, down, shares, 10, 0.0, {"contact": seconds, "yield": 50.0})

    def expected_seconds(self, name: str, _: Any, solved: dict[str, mech.Answer]) -> float:
        """By half the speed once one is solved."""
        missing = {*models.prerequisites(name), name} - {*solved, "winkler"}
        slower = 2.0 if set(solved) - {"winkler"} else 1.0
        return slower * math.fsum(PRICES.get(model, 3.0) for model in missing)

    def bound(self, effect: str) -> mech.LeftOut:
        return mech.LeftOut(effect=effect, threshold=LEFT[effect], approach=LEFT[effect], share=LEFT[effect])


@pytest.mark.parametrize(
    ("tol", "model", "climbed"),
    [
        (0.9, "winkler", []),  # its own bar is 0.8
        (0.35, "linear", []),
        (0.305, "corrected", ["linear"]),  # the model alone would do, not with its mesh
        (0.25, "corrected", []),
        (0.105, "corrected-finite-strain", ["corrected"]),
        (0.05, "corrected-finite-strain", []),
        (0.001, "solid-finite-strain", ["corrected-finite-strain"]),
    ],
)
def test_a_tolerance_begins_with_the_first_model_that_may_meet_it(
    tol: float, model: str, climbed: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    fake = MadeUp(monkeypatch)
    verdict = check(yamada(), tol=tol)
    assert (verdict.model, [run.model for run in verdict.models_tried]) == (model, climbed)
    error = {"linear": 0.3, "corrected": 0.1}.get(model, 0.0)
    if model != "winkler":
        assert verdict.all_touch_force.error == pytest.approx((0.01 + error) * 3.0, rel=1e-12)
        mesh = fake.asked[model].tol
        assert 0.2 * min(tol, 0.02) <= (mesh or 0.0) <= 0.5 * tol  # a part of it is the mesh's
    assert [w for w in verdict.warnings if "not met" in w] == (
        ["the all-touch force's error is 0.01 of its value: the tolerance 0.001 is not met"]
        if tol < 0.01
        else []
    )
    assert all(request.budget is None and not request.must_fit for request in fake.asked.values())


def test_a_force_that_a_plane_model_refuses_is_asked_of_the_solid(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where plane strain finds no equilibrium, free ends may; and where neither does, there is no verdict."""
    fake = MadeUp(monkeypatch, 3.9)
    monkeypatch.setattr(adaptivity, "DEFAULT_BUDGET", 40.0)
    fake.refusals["corrected-finite-strain"] = InputError("force", "must lie below 3 N", 4.0)
    verdict = check(yamada(), force=4.0)
    assert (verdict.model, verdict.passed, verdict.out_of_range) == ("solid-finite-strain", True, "")
    fake.refusals["solid"] = InputError("force", "must lie below 3.5 N", 4.0)
    verdict = check(yamada(), force=4.0)
    assert (verdict.model, verdict.passed) == ("corrected", False)
    assert (
        verdict.out_of_range == "the force must lie below 3.5 N (according to the solid-finite-strain model)"
    )


def failure(kind: str) -> Exception:
    """What makes a model refuse, or run out of memory in one of three libraries."""
    if kind == "numpy":
        with pytest.raises(MemoryError) as memory:
            np.empty(2**50)
        return memory.value
    return {
        "balance": RefusedError("it does not balance"),
        "Python": MemoryError(),
        "NGSolve": NgException("Could not allocate localheap, heapsize = 200000000"),
    }[kind]


@pytest.mark.parametrize("kind", ["balance", "Python", "numpy", "NGSolve"])
def test_a_model_that_refuses_leaves_the_verdict_before(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """With the tolerance `corrected` comes first, built on `linear`."""
    fake = MadeUp(monkeypatch, 3.9)
    fake.refusals["corrected"] = failure(kind)
    words = "does not balance" if kind == "balance" else "needs more memory"
    for options in ({}, {"tol": 0.25}):
        verdict = check(yamada(), force=4.0, **options)
        assert verdict.model == "linear"
        assert any("the corrected model" in w and words in w for w in verdict.warnings)
        assert any("not met" in w for w in verdict.warnings) == bool(options)
    fake.refusals["linear"] = failure(kind)
    with pytest.raises(RefusedError if kind == "balance" else ExhaustedError, match=words):
        check(yamada())  # there is none before


@pytest.mark.parametrize(
    ("value", "sharp", "model", "climbed", "passed"),
    [
        (3.0, 5.9, "linear", [], True),  # 3 N and 31 % are less than 4 N
        (3.0, 14.9, "corrected", ["linear"], True),
        (3.0, 15.1, "corrected-finite-strain", ["linear", "corrected"], True),  # 1 %: sharp enough
        (3.0, 40.0, "corrected-finite-strain", ["linear", "corrected"], True),
        (6.0, 5.9, "linear", [], False),
        (3.5, 5.9, "corrected", ["linear"], True),
        (4.6, 5.9, "corrected", ["linear"], False),
        (3.9, 5.9, "corrected-finite-strain", ["linear", "corrected"], True),
        (3.99, 5.9, "solid-finite-strain", ["linear", "corrected", "corrected-finite-strain"], False),
    ],
)
def test_without_a_tolerance_models_follow_until_the_verdict_is_clear_and_sharp(
    value: float, sharp: float, model: str, climbed: list[str], passed: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Models end after 2, 6, 15 and 37 s; what only sharpens a clear verdict must end by `sharp` s."""
    MadeUp(monkeypatch, value)
    monkeypatch.setattr(adaptivity, "SHARP_SECONDS", sharp)
    monkeypatch.setattr(adaptivity, "DEFAULT_BUDGET", 40.0)
    reports: list[tuple[str, float | None]] = []
    verdict = check(yamada(), force=4.0, progress=lambda stage, left=None: reports.append((stage, left)))
    assert (verdict.model, [run.model for run in verdict.models_tried], verdict.passed) == (
        model,
        climbed,
        passed,
    )
    assert [run.seconds for run in verdict.models_tried] == pytest.approx([2.0, 4.0, 9.0][: len(climbed)])
    following = {
        "linear": mech.NextModel("corrected", 4.0),
        "corrected": mech.NextModel("corrected-finite-strain", 9.0),
    }
    last = mech.NextModel("solid-finite-strain", 22.0)
    expected_next = None if model == "solid-finite-strain" else following.get(model, last)
    assert verdict.next_model == expected_next
    # the first by a guess, the others by what the last one took
    assert reports[:2] == [("linear model", 1.0), ("corrected model", 4.0)][: 1 + bool(climbed)]
    assert not any("not met" in w for w in verdict.warnings)


def test_no_model_is_begun_that_would_end_after_half_a_minute(monkeypatch: pytest.MonkeyPatch) -> None:
    MadeUp(monkeypatch, 3.99)
    verdict = check(yamada(), force=4.0)
    assert (verdict.model, verdict.verdict) == ("corrected-finite-strain", "undecided")
    assert verdict.next_model == mech.NextModel("solid-finite-strain", 22.0)
    assert verdict.next_step.startswith("`--model solid-finite-strain` (about ")


@pytest.mark.parametrize(
    ("budget", "model", "late"),
    [
        (1.9, "winkler", "would take about 2 s of the budget"),  # tried, and too slow
        (2.1, "linear", ""),
        (5.9, "linear", ""),
        (6.1, "corrected", ""),
        (14.9, "corrected", ""),
        (15.1, "corrected-finite-strain", ""),
        (36.9, "corrected-finite-strain", ""),
        (37.1, "solid-finite-strain", ""),
    ],
)
def test_a_budget_is_climbed_as_far_as_the_next_model_fits(
    budget: float, model: str, late: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At half the laws' speed the models end after 2, 6, 15 and 37 s, however clear the verdict is."""
    fake = MadeUp(monkeypatch)
    verdict = check(yamada(), budget=budget)
    assert verdict.model == model
    assert [w for w in verdict.warnings if "budget" in w] == (
        [f"the linear model {late} of {budget:g} s"] if late else []
    )
    if late:
        assert verdict.next_model == mech.NextModel("linear", 2.0)
        return
    assert (verdict.next_model is None) == (model == "solid-finite-strain")
    ends = {"linear": 0.0, "corrected": 2.0, "corrected-finite-strain": 6.0, "solid": 15.0}
    for name, expected in ends.items():
        if name in fake.asked:
            assert fake.asked[name].budget == pytest.approx(budget - expected)
            assert fake.asked[name].must_fit == (name == "linear")


def test_a_budget_ends_where_a_tolerance_is_met_and_what_took_longer_says_so(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    fake = MadeUp(monkeypatch)
    assert check(yamada(), budget=100.0, tol=0.4).model == "linear"
    assert check(yamada(), budget=100.0, tol=0.2).model == "corrected"
    assert check(yamada(), budget=6.1, tol=0.05).model == "corrected"
    monkeypatch.setitem(PRICES, "corrected", 5.0)
    monkeypatch.setattr(fake, "expected_seconds", lambda *_: 0.5)
    monkeypatch.setattr(adaptivity, "expected_seconds", fake.expected_seconds)
    slow = check(yamada(), budget=4.0, tol=0.2)
    assert slow.model == "corrected"
    assert [w for w in slow.warnings if "took" in w] == ["took 12 s, more than the budget of 4 s"]


def test_a_model_for_which_a_pad_is_too_large_leaves_the_one_before(monkeypatch: pytest.MonkeyPatch) -> None:
    fake = MadeUp(monkeypatch)
    fake.refusals["corrected"] = mech.SizeError("ridge.count", "too many", 900, "take fewer ridges")
    verdict = check(yamada(), tol=0.25)
    assert verdict.model == "linear"
    words = "the corrected model, which leaves out less, cannot judge this: ridge.count"
    assert any(words in w for w in verdict.warnings)
    fake.refusals["linear"] = mech.SizeError("ridge.count", "too many", 900, "take fewer ridges")
    verdict = check(yamada())
    assert (verdict.model, verdict.next_model) == ("winkler", None)
    assert any(
        w.startswith("the linear model, which leaves out less, cannot judge this") for w in verdict.warnings
    )
    fake.refusals["linear"] = InputError("ridge.count", "too many", 900, "take fewer ridges")
    with pytest.raises(InputError, match="too many"):
        check(yamada())


def test_a_force_that_a_better_model_calls_too_large_is_no_pass(monkeypatch: pytest.MonkeyPatch) -> None:
    fake = MadeUp(monkeypatch, 3.5)
    fake.refusals["corrected"] = InputError("force", "must be below 3 N", 4.0)
    fake.refusals["solid"] = InputError("force", "must be below 3.2 N", 4.0)  # asked after the plane ones
    verdict = check(yamada(), force=4.0)
    assert (verdict.model, verdict.passed, verdict.next_model) == ("linear", False, None)
    assert (
        verdict.out_of_range == "the force must be below 3.2 N (according to the solid-finite-strain model)"
    )
    fake.refusals["corrected"] = RefusedError("it does not balance")
    verdict = check(yamada(), force=4.0)
    assert (verdict.model, verdict.out_of_range, verdict.next_model) == ("linear", "", None)


def test_the_yield_is_sampled_once_and_its_time_told_and_expected_again_of_the_next(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    fake = MadeUp(monkeypatch, 3.9)
    monkeypatch.setattr(adaptivity, "YIELD_PRICE", 1.5)
    monkeypatch.setattr(adaptivity, "linear_seconds", lambda _: 2.0)
    answer = fake.answer

    def with_parts(*arguments: Any) -> mech.Answer:
        return replace(answer(*arguments), ridge_model=object())

    def sampled(*_: object) -> object:
        fake.now += 2.5
        return object()

    monkeypatch.setattr(fake, "answer", with_parts)
    winkler = models.load("winkler")
    monkeypatch.setattr(
        models, "load", lambda name: winkler if name == "winkler" else partial(fake.answer, name)
    )
    monkeypatch.setattr(manufacturing, "manufacture", sampled)
    verdict = check(yamada(), force=4.0)
    assert [run.model for run in verdict.models_tried] == ["linear", "corrected"]
    # each model's own time (see above); the yield's model took the linear model 50 s
    assert [run.seconds for run in verdict.models_tried] == pytest.approx([2.0, 4.0])
    assert verdict.seconds["yield"] == pytest.approx(50.0 + 2.5)  # of the last verdict alone
    assert verdict.seconds["total"] == pytest.approx(2.0 + 4.0 + 9.0 + 2.5)
    # not the 3 s that were expected
    assert verdict.next_model == mech.NextModel("solid-finite-strain", pytest.approx(22.0 + 2.5))
    # within a budget it has its place before it is known what it takes
    for budget, model in ((8.9, "linear"), (9.1, "corrected")):
        within = check(yamada(), force=4.0, budget=budget)
        assert (within.model, within.manufacture is None) == (model, False)
        assert fake.asked["linear"].budget == pytest.approx(budget - 3.0)
        assert not any("budget" in w for w in within.warnings)


@pytest.mark.slow
def test_a_pad_of_very_many_ridges_has_an_answer_within_any_budget(monkeypatch: pytest.MonkeyPatch) -> None:
    """Or with the reduced model, if the budget suffices for that. Here every pad is large."""
    monkeypatch.setitem(models.AUTO_IF, "reduced", lambda _: True)
    monkeypatch.setattr(adaptivity, "DEFAULT_BUDGET", 1e-6)
    design = load("plain-ridges", ["contact.force=3.0"])
    for budget, model in ((1e-3, "winkler"), (None, "reduced")):
        verdict = check(design, budget=budget)
        assert verdict.model == model
        assert verdict.next_model.model in ("linear", "corrected")


# two columns with a base of their own height: both touch at once, the all-touch force is rounding
COLUMNS = [
    *("ridge.count=2", "ridge.pitch=10.343", "ridge.height=8.2", "ridge.root_width=8.2745"),
    *("ridge.tip_width=5.792", "ridge.crown=0.29", "ridge.tip_fillet=0.029", "ridge.root_fillet=1.03"),
    *("skin.curvature_radius=24.8", "skin.width=24.8", "skin.thickness=41.6", "skin.length=7.45"),
]


@pytest.fixture(scope="module")
def plain() -> Design:
    return load("plain-ridges", ["ridge.count=3", "skin.width=5.0", "contact.force=1.3"])


def contact(design: Design, fineness: float, order: int) -> int:
    """Contact unknowns of the plane at this mesh and order."""
    pad = mech.pad_of(design)
    return linear.contact_unknowns(mech.plane_piece(pad, fineness), order)


def unsolved(*arguments: Any, **options: Any) -> Any:
    raise AssertionError("solved, and then refused")


def test_a_finer_mesh_that_is_too_large_leaves_the_last_ones_answer(
    plain: Design, monkeypatch: pytest.MonkeyPatch
) -> None:
    pad = mech.pad_of(plain)
    best = linear.level(mech.plane_piece(pad, 1.0), 3, plain.contact.force)
    monkeypatch.setattr(linear, "MOST_CONTACT_UNKNOWNS", contact(plain, 1.0, 3))
    answer = plane(plain, tol=1e-4)
    assert answer.unknowns == best.unknowns
    assert answer.all_touch_force.value == best.all_touch_force
    assert any("a finer mesh takes more than" in w for w in answer.warnings)


def test_what_fits_no_mesh_is_refused_unsolved_and_auto_takes_the_closed_form(
    plain: Design, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(linear, "MOST_CONTACT_UNKNOWNS", contact(plain, 0.5, 3) - 1)
    monkeypatch.setattr(linear, "level", unsolved)
    with pytest.raises(mech.SizeError, match=r"ridge\.count: the linear model takes at most"):
        linear_check(plain)
    for options in ({}, {"tol": 0.01}, {"budget": 500.0}):
        verdict = check(plain, **options)
        assert verdict.model == "winkler"
        assert verdict.all_touch_force == check(plain, model="winkler").all_touch_force
        assert any(
            "model, which leaves out less, cannot judge this: ridge.count" in w for w in verdict.warnings
        )


def test_far_too_many_ridges_are_told_by_one_of_them_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    meshed: list[int] = []

    def counted(pad: Any, sizes: Any) -> Any:
        meshed.append(len(pad.ridges))
        return mech.triangles(pad, sizes)

    monkeypatch.setattr(linear, "MOST_CONTACT_UNKNOWNS", 3000)
    monkeypatch.setattr(linear, "triangles", counted)
    verdict = check(wide(120), budget=10.0)  # the reduced model takes longer
    assert (verdict.model, verdict.ridges, meshed) == ("winkler", 120, [1])


@pytest.mark.slow
def test_as_many_ridges_as_a_design_may_have_are_not_too_many_for_the_reduced_model() -> None:
    """Of 200 a section is meshed, of 999 it would take more memory than a laptop has."""
    most = linear.MOST_CONTACT_UNKNOWNS
    some, all_ = (
        load("plain-ridges", [f"ridge.count={count}", "skin.width=1000", "skin.curvature_radius=1e6"])
        for count in (200, 999)
    )
    linear.check_coarsest(mech.pad_of(some), most, "linear")
    with pytest.raises(mech.SizeError, match=r"ridge\.count: the linear model takes at most 9000"):
        linear.check_coarsest(mech.pad_of(all_), most, "linear")
    with pytest.raises(mech.SizeError, match=r"ridge\.count: the finite-strain model takes at most 6000"):
        finite_strain.solve(mech.pad_of(all_), mech.Request(450.0))
    assert check(all_, force=450.0, model="reduced").all_touch_force.value


@pytest.mark.parametrize(
    "name",
    ["plain-ridges", *(pytest.param(n, marks=pytest.mark.slow) for n in ("fingertip-soft", "milled-pad"))],
)
def test_one_ridge_alone_does_not_ask_for_much_more_than_its_share(name: str) -> None:
    pad = mech.pad_of(load(name))
    sizes = mech.default_sizes(pad, linear.REFINEMENTS[0].fineness)
    alone, whole = (
        elements.contact_unknowns(elements.curved(mech.triangles(p, sizes), 1), 1)
        for p in (mech.problem.one_ridge(pad), pad)
    )
    assert whole >= linear.SINGLE_RIDGE_FACTOR * alone * len(pad.ridges)
    assert linear.contact_unknowns(mech.plane_piece(pad, 0.5), 1) >= linear.SINGLE_RIDGE_FACTOR * alone * len(
        pad.ridges
    )


def test_a_solid_is_refused_before_any_of_its_levels_is_solved(
    plain: Design, monkeypatch: pytest.MonkeyPatch
) -> None:
    sizes: list[int] = []
    check_size = solid.check_size

    def seen(forms: Any, line: Any) -> None:
        sizes.append(3 * forms.clamped.size * line.at.size)
        check_size(forms, line)

    monkeypatch.setattr(solid, "check_size", seen)
    monkeypatch.setattr(solid, "solve_level", unsolved)
    with pytest.raises(AssertionError, match="solved, and then refused"):
        check(plain, model="solid")
    assert len(sizes) == 2
    # what the first level takes, and not all do
    monkeypatch.setattr(solid, "MOST_UNKNOWNS", min(sizes))
    with pytest.raises(mech.SizeError, match="three dimensions take at most"):
        check(plain, model="solid")


@pytest.mark.slow
def test_film_stresses_keep_the_last_mesh(monkeypatch: pytest.MonkeyPatch) -> None:
    design = load("yamada-2002", ["ridge.count=3", "skin.width=5.0"])
    whole = mech.film_stresses(design, 1.3, (0.0,), tol=0.5)[0]
    orders: list[int] = []
    counted = elements.contact_unknowns

    def seen(mesh: Any, order: int) -> int:
        orders.append(2 * counted(mesh, order))
        return orders[-1] // 2

    monkeypatch.setattr(stress.elements, "contact_unknowns", seen)
    mech.film_stresses(design, 1.3, (0.0,), tol=0.5)
    monkeypatch.setattr(stress, "MOST_CONTACT_UNKNOWNS", max(orders))
    finest = mech.film_stresses(design, 1.3, (0.0,), tol=1e-6)[0]
    assert finest.differential == whole.differential
    assert any("a finer mesh takes more than" in w for w in finest.warnings)
    monkeypatch.setattr(stress, "MOST_CONTACT_UNKNOWNS", orders[0] - 1)
    monkeypatch.setattr(stress, "level", unsolved)
    with pytest.raises(mech.SizeError, match="films' stresses take at most"):
        mech.film_stresses(design, 1.3, (0.0,))


@pytest.mark.slow
def test_two_columns_that_touch_at_once_have_a_verdict_and_a_yield() -> None:
    verdict = check(load("plain-ridges", [*COLUMNS, "contact.force=4.0"]))
    assert verdict.touching == 2
    # both touch from next to nothing on, and crests of 0.015 mm against an approach of 1.3 mm change little
    assert verdict.manufacture.passing.value == pytest.approx(1.0, abs=0.01)
    assert max(verdict.manufacture.crest_sensitivity) < 10.0  # N/mm; 4 N press them by 1.3 mm


@pytest.mark.slow
def test_a_yield_that_does_not_settle_is_no_veto(plain: Design) -> None:
    whole = linear_check(plain, tol=0.05)
    assert whole.manufacture is not None

    def unsettled(*_: Any) -> Any:
        raise mech.ContactError("does not settle")

    for module, name in ((manufacturing, "manufacture"), (linear, "ridge_model")):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(module, name, unsettled)
            verdict = linear_check(plain, tol=0.05)
        assert (verdict.passed, verdict.all_touch_force) == (whole.passed, whole.all_touch_force)
        assert verdict.manufacture is None
        assert "no yield: does not settle" in verdict.warnings
        assert verdict.as_json()["yield"] is None


@pytest.mark.parametrize(
    ("ridges", "parts"),
    [(9, 4096), *(pytest.param(*row, marks=pytest.mark.slow) for row in ((33, 3848), (48, 1816)))],
)
def test_many_ridges_are_judged_by_fewer_parts_and_the_error_says_so(ridges: int, parts: int) -> None:
    """Springs that do not feel each other, as high as each other: all touch in every part."""
    force = np.linspace(0.0, 1.0, 5)
    springs = mech.RidgeModel(
        np.zeros(ridges), np.zeros((ridges, ridges)), force, np.tile(force, (ridges, 1)), 1.0, 1.0
    )
    result = manufacturing.manufacture(
        springs, 0.5 * ridges, 1e-9, mech.problem.Spread("sla", 1e-3, (0.8, 0.8, 0.8))
    )
    assert result.passing.value == 1.0
    # Wilson's score interval at 95 % if none of n fails: 1 - z^2 / (n + z^2)
    assert result.passing.error == pytest.approx(1.96**2 / (parts + 1.96**2), rel=1e-9)
