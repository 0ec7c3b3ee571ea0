"""The verdict: docs/evidence/facts.md's numbers, similarity, limits, and the contract of `check`."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from functools import partial
from operator import attrgetter
from typing import Any

import numpy as np
import pytest
from netgen.meshing import NgException

from skincad.base import Estimate, ExhaustedError, InputError, RefusedError
from skincad.inputs import Design, load
from skincad.mechanics import (
    MODELS,
    Answer,
    ContactCheck,
    LateError,
    LeftOut,
    NextModel,
    Request,
    SizeError,
    expected_seconds,
    pad_of,
    plane_piece,
)
from skincad.mechanics import check as adaptivity
from skincad.mechanics import manufacture as manufacturing
from skincad.mechanics.check import check
from skincad.mechanics.models import linear
from skincad.mechanics.models import table as models
from skincad.mechanics.models.linear import level
from tests.families import RIDGED
from tests.mechanics.designs import SHORT, THREE, filleted, linear_check, plane, reference, void_slots, yamada


def test_reference_section() -> None:
    answer = plane(reference())
    # 0.5 % and 0.003 N are what docs/evidence/facts.md's own numbers claim
    assert answer.all_touch_force.value == pytest.approx(3.026, rel=5e-3)
    assert answer.approach.value == pytest.approx(0.1733, rel=5e-3)
    shares = [f.value for f in answer.ridge_force]
    assert shares[:5] == pytest.approx([0.0885, 0.378, 0.551, 0.646, 0.676], abs=0.003)


def test_filleted_section() -> None:
    answer = plane(filleted())
    assert answer.all_touch_force.value == pytest.approx(3.046, rel=5e-3)
    assert answer.approach.value == pytest.approx(0.17306, rel=5e-3)
    assert answer.ridge_force[0].value == pytest.approx(0.0866, abs=0.003)


@pytest.mark.parametrize(
    ("thickness", "force"), [(0.04, 2.90), pytest.param(0.10, 2.71, marks=pytest.mark.slow)]
)
def test_void_slots_lower_the_force(thickness: float, force: float) -> None:
    answer = plane(void_slots(thickness))
    # the slots of docs/evidence/facts.md lie slightly elsewhere
    assert answer.all_touch_force.value == pytest.approx(force, rel=0.02)


@pytest.fixture(scope="module")
def judged() -> ContactCheck:
    return check(filleted())


@pytest.mark.slow
def test_yamada_passes() -> None:
    verdict = check(yamada())
    assert (verdict.passed, verdict.touching, verdict.model) == (True, 9, "corrected-finite-strain")


def test_plain_ridges_pass_with_all_nine(judged: ContactCheck) -> None:
    verdict = judged
    assert (verdict.passed, verdict.touching, verdict.ridges, verdict.force) == (True, 9, 9, 4.0)
    # the plate's force is the sum of the shares: the contact residual
    assert sum(f.value or 0.0 for f in verdict.ridge_force) == pytest.approx(4.0, rel=1e-9)
    assert verdict.residual < 1e-6


@pytest.mark.slow
def test_ridges_start_to_touch_at_the_stated_force() -> None:
    """Just below the force the outer ridges are free, just above all touch; nodes differ by 1e-4 from it."""
    force = plane(filleted()).all_touch_force.value
    assert force is not None
    below, above = (linear_check(filleted(), force=force * share) for share in (0.999, 1.001))
    assert below.touching == 7
    assert above.touching == 9
    assert not below.passed
    assert not above.passed  # within its error: judged at the pessimistic end


@pytest.fixture(scope="module")
def by_linear() -> ContactCheck:
    """By the linear model alone."""
    return linear_check(filleted())


def test_shares_are_symmetric(by_linear: ContactCheck) -> None:
    verdict = by_linear
    shares = np.array([f.value for f in verdict.ridge_force])
    error = verdict.ridge_force[0].error or 0.0
    assert np.abs(shares - shares[::-1]).max() <= error  # the mesh is not symmetric, its error covers that


def test_similarity() -> None:
    """Lengths times 2 and modulus by 4 leave every force: the mesh is the same, so 1e-6 is rounding."""
    small = yamada().with_(**THREE)
    lengths = {
        "skin": ("curvature_radius", "thickness", "width", "length"),
        "ridge": ("pitch", "height", "root_width", "tip_width", "crown", "tip_fillet", "root_fillet"),
        "slot": ("thickness", "depth", "offset", "elevation"),
        "film": ("thickness",),
    }
    data = small.model_dump()
    change = {table: {key: 2 * data[table][key] for key in keys} for table, keys in lengths.items()}
    change["film"]["young_modulus"] = data["film"]["young_modulus"] / 4
    large = small.with_(**change, material={"young_modulus": 0.2})
    one, two = plane(small, tol=0.05), plane(large, tol=0.05)
    assert two.all_touch_force.value == pytest.approx(one.all_touch_force.value, rel=1e-6)
    assert [f.value for f in two.ridge_force] == pytest.approx([f.value for f in one.ridge_force], rel=1e-6)
    assert two.approach.value == pytest.approx(2 * (one.approach.value or 0.0), rel=1e-6)


@pytest.mark.slow
def test_force_is_smooth_in_the_design() -> None:
    """Steps of 1e-4 mm in height at one order: second differences stay below 2e-4 of the force.

    A change of the mesh's topology moves F9 by 2e-5 to 1e-4 at k = 3
    (docs/evidence/facts.md#mesh-and-method); bisecting on touching nodes would jump by about 1e-3.
    """
    forces = []
    for i in range(7):
        pad = pad_of(filleted().with_(ridge={"height": 0.5 + 1e-4 * i}))
        forces.append(level(plane_piece(pad), 3, 4.0).all_touch_force)
    steps = np.diff(np.array(forces, dtype=float))
    assert np.abs(np.diff(steps)).max() <= 2e-4 * (forces[0] or 0.0)


@pytest.mark.slow
def test_no_locking_towards_incompressible() -> None:
    """F9 tends to its limit linearly in 1 - 2 nu, so each tenth of that leaves a tenth of the distance."""
    ratios = (0.499, 0.4999, 0.49999, 0.499999, 0.4999999)
    forces = [
        plane(filleted().with_(material={"poisson_ratio": nu}), tol=0.05).all_touch_force.value
        for nu in ratios
    ]
    distance = np.abs(np.array(forces[:-1], dtype=float) - (forces[-1] or 0.0))
    assert (distance[1:] / distance[:-1] < 0.15).all()  # 0.1 in exact arithmetic
    assert distance[0] < 0.01 * (forces[-1] or 0.0)


EXTREMES = {
    "compressible": lambda: yamada().with_(material={"poisson_ratio": 0.0}),
    "no crown": lambda: reference().with_(ridge={"crown": 0.0}),
    "nearly flat": lambda: yamada().with_(skin={"curvature_radius": 1e6}),
    "flat": lambda: reference().with_(skin={"curvature_radius": 1e8}),
    "flat without crown": lambda: reference().with_(ridge={"crown": 0.0}, skin={"curvature_radius": 1e8}),
    "two": lambda: yamada().with_(ridge={"count": 2}),
    "eight": lambda: yamada().with_(ridge={"count": 8}),
    "tilted": lambda: yamada().with_(slot={"offset": 0.17, "elevation": -0.05, "tilt": 45.0}, **THREE),
    "tilted voids": lambda: yamada().with_(
        slot={"offset": 0.17, "elevation": -0.05, "tilt": 45.0}, film=None, contact={"film": "loose"}
    ),
    "pointed": lambda: reference().with_(ridge={"tip_width": 0.02, "crown": 0.0}),
}
DEAR = ("compressible", "nearly flat", "eight", "tilted voids")


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.slow) if name in DEAR else name for name in EXTREMES]
)
def test_extremes(name: str) -> None:
    design = EXTREMES[name]()
    answer = plane(design, tol=0.05)
    assert answer.touching == design.ridge.count
    assert not [w for w in answer.warnings if "not met" in w]
    assert answer.residual <= 1e-6
    shares = np.array([f.value for f in answer.ridge_force])
    assert shares.sum() == pytest.approx(4.0, rel=1e-9)  # equilibrium, solved exactly
    assert (shares > 0).all()


@pytest.mark.slow
def test_force_falls_with_the_curvature() -> None:
    """Far towards flat the force goes as 1 / R; 5 % because two errors of 2 % or so meet."""
    forces = [
        plane(reference().with_(skin={"curvature_radius": radius})).all_touch_force.value
        for radius in (1e6, 1e8)
    ]
    assert (forces[0] or 0.0) / (forces[1] or 1.0) == pytest.approx(100.0, rel=0.05)


def test_one_ridge_touches_at_once() -> None:
    verdict = linear_check(yamada().with_(ridge={"count": 1}), force=1.0)
    assert verdict.all_touch_force.value == 0.0
    assert verdict.passed
    assert any("nominal ridge strain 0.1" in w for w in verdict.warnings)


@pytest.mark.slow
def test_101_ridges() -> None:
    skin = {"curvature_radius": 4000.0, "width": 103.0, "length": 12.0}
    design = reference().with_(skin=skin, ridge={"count": 101}, contact={"force": 500.0})
    answer = plane(design, tol=0.05)
    assert answer.touching == 101
    assert sum(f.value or 0.0 for f in answer.ridge_force) == pytest.approx(500.0, rel=1e-9)


def test_too_many_ridges_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(linear, "MOST_CONTACT_UNKNOWNS", 6000)
    skin = {"curvature_radius": 1e6, "width": 999.0}
    with pytest.raises(InputError, match=r"ridge\.count: the linear model takes at most"):
        linear_check(reference().with_(skin=skin, ridge={"count": 900}))


@pytest.mark.slow
def test_the_lightest_load() -> None:
    """An error relative to next to nothing climbs all refinements."""
    assert plane(filleted().with_(**THREE), force=1e-9, tol=0.05).touching == 1


@pytest.mark.parametrize(("force", "touching"), [(0.5, 5), pytest.param(12.0, 9, marks=pytest.mark.slow)])
def test_light_and_heavy_loads(force: float, touching: int) -> None:
    assert plane(filleted(), force=force, tol=0.05).touching == touching


@pytest.mark.parametrize(("force", "said"), [(0.65, False), (2.0, True)])
def test_a_heavy_load_strains_more_than_small(force: float, said: bool) -> None:
    verdict = linear_check(small(), force=force, tol=0.05)
    assert any("small-strain" in w for w in verdict.warnings) == said


@pytest.mark.slow
def test_ridges_that_tip_over_or_are_crushed_have_no_verdict() -> None:
    tall = linear_check(filleted().with_(ridge={"height": 6.0}), force=4.0, tol=0.05)
    assert "tips over at" in tall.out_of_range
    assert not tall.passed
    crushed = linear_check(filleted().with_(skin={"curvature_radius": 9.0}), force=60.0, tol=0.05)
    assert "nominal strain" in crushed.out_of_range
    assert not crushed.passed
    assert linear_check(filleted(), force=12.0, tol=0.05).out_of_range == ""  # all touch long before


def test_a_crushing_force_is_refused() -> None:
    with pytest.raises(InputError, match="force: must stay below about"):
        linear_check(small(), force=1e6)


@pytest.mark.parametrize("name", RIDGED)
@pytest.mark.parametrize("model", ["winkler", pytest.param("linear", marks=pytest.mark.slow)])
def test_every_template_is_checked(model: str, name: str) -> None:
    verdict = check(load(name), model=model, tol=0.05)
    assert verdict.ridges == len(verdict.ridge_force)
    assert sum(f.value or 0.0 for f in verdict.ridge_force) == pytest.approx(verdict.force, rel=1e-9)


@pytest.mark.parametrize("model", ["solid-finite", "liner"])
def test_unknown_models_say_what_to_do(model: str) -> None:
    with pytest.raises(InputError, match=r"^model: .*; "):
        check(yamada(), model=model)


@pytest.mark.parametrize("bad", [{"force": 0.0}, {"force": float("nan")}, {"tol": 0.0}, {"tol": 1.5}])
def test_bad_arguments_are_refused(bad: dict[str, float]) -> None:
    with pytest.raises(InputError):
        linear_check(yamada(), **bad)


def test_json_has_the_contracts_keys() -> None:
    data = linear_check(small(), tol=0.05).as_json()
    keys = (
        "name passed force_N ridges touching all_touch_force_N approach_mm ridge_force_N tier unknowns "
        "residual yield seconds warnings"
    )
    assert set(keys.split()) <= data.keys()
    assert set(data["seconds"]) == {"total", "mesh", "assemble", "condense", "contact", "yield"}
    assert json.loads(json.dumps(data, allow_nan=False)) == data


def test_progress_is_told() -> None:
    reports: list[tuple[str, float | None]] = []
    linear_check(small(), tol=0.05, progress=lambda stage, left=None: reports.append((stage, left)))
    assert [stage.partition(":")[0] for stage, _ in reports] == ["linear model"] * 3
    assert reports[0][1] > 0  # the whole model's, by its law
    assert [left for _, left in reports[1:]] == [None, None]


@pytest.mark.slow
def test_a_budget_buys_the_refinements_that_fit_and_a_larger_one_a_smaller_error() -> None:
    three = filleted().with_(ridge={"count": 3}, skin={"width": 4.0})
    quick, patient = linear_check(three, budget=1e-3), linear_check(three, budget=60.0)
    assert patient.unknowns > quick.unknowns
    assert patient.all_touch_force.error < quick.all_touch_force.error
    assert any("more than the budget" in w for w in quick.warnings)  # one mesh is the least
    assert not any("budget" in w or "not met" in w for w in patient.warnings)


@pytest.mark.parametrize("budget", [0.0, -1.0, math.nan, math.inf])
def test_a_budget_that_is_no_time_is_refused(budget: float) -> None:
    with pytest.raises(InputError, match="budget: must be above 0 s"):
        check(load("yamada-2002"), budget=budget)


UNDECIDED = 0.12  # N; small ridges all touch at 0.11 N, to a third by the linear model


def small() -> Design:
    """Three ridges on a short pad: free ends and finite strain count."""
    return reference().with_(**SHORT, contact={"force": 0.65})


def test_auto_goes_on_until_the_verdict_is_clear_and_sharp(judged: ContactCheck) -> None:
    """Then on, as seconds make it sharp: filleted ridges without strips."""
    verdict = judged
    assert verdict.model == "corrected-finite-strain"
    assert [run.model for run in verdict.models_tried] == ["linear", "corrected"]
    before = verdict.models_tried[0].all_touch_force
    assert before.value < 4.0 < before.upper  # what the linear model leaves open
    assert verdict.all_touch_force.upper < 4.0
    assert verdict.all_touch_force.error < 0.03 * verdict.all_touch_force.value
    assert verdict.passed


SLOW = [
    pytest.param(tol, model, marks=pytest.mark.slow)
    for tol, model in ((0.15, "corrected"), (0.01, "solid-finite-strain"))
]


@pytest.mark.parametrize(("tol", "model"), [(0.95, "winkler"), (0.45, "linear"), *SLOW])
def test_auto_takes_the_cheapest_model_that_meets_the_tolerance(tol: float, model: str) -> None:
    verdict = check(small() if tol > 0.1 else yamada(), tol=tol)
    assert verdict.model == model
    assert verdict.all_touch_force.error <= tol * verdict.all_touch_force.value
    assert not any("not met" in w for w in verdict.warnings)


def test_the_error_is_the_meshs_and_the_models(by_linear: ContactCheck) -> None:
    verdict = by_linear
    mesh = verdict.all_touch_force.error - verdict.model_error
    assert 0 < mesh < 0.01 * verdict.all_touch_force.value < 0.1 * verdict.model_error
    assert [bound.effect for bound in verdict.left_out] == ["free ends", "finite strain"]
    assert verdict.margin == pytest.approx(4.0 - verdict.all_touch_force.upper)
    assert verdict.next_model.model == "corrected"


@pytest.mark.slow
def test_parts_that_go_through_each_other_have_no_verdict() -> None:
    """The skin between ridges reaches the plate: linear contact knows crowns and tip fillets alone."""
    verdict = linear_check(yamada(), force=40.0, tol=0.05)
    assert "meets the plate" in verdict.out_of_range
    assert not verdict.passed
    assert "meets the plate" in check(filleted(), model="solid", force=40.0, tol=0.05).out_of_range
    shallow = reference().with_(ridge={"height": 0.1, "crown": 0.02})
    assert "meets the plate" in linear_check(shallow, force=20.0, tol=0.05).out_of_range


def test_slots_that_close_have_no_verdict() -> None:
    """Empty slots lying flat under the ridges close under their load."""
    flat = void_slots(0.03).with_(slot={"tilt": 45.0, "offset": 0.17, "elevation": -0.05}, **THREE)
    assert linear_check(flat, tol=0.05, force=0.4).out_of_range == ""
    assert "closes" in linear_check(flat, tol=0.05, force=2.7).out_of_range


def test_a_check_says_from_which_force_on_the_skin_meets_itself() -> None:
    """The same slots: below the force a check has a verdict, above none. Without slots nothing is found."""
    flat = void_slots(0.03).with_(slot={"tilt": 45.0, "offset": 0.17, "elevation": -0.05}, **THREE)
    contact = linear_check(flat, tol=0.05, force=0.4).self_contact
    begins = contact.begins
    assert "closes" in contact.where
    assert contact.free_to == pytest.approx(begins.lower)
    assert 0.4 < begins.lower < begins.upper < 2.7
    assert linear_check(flat, tol=0.05, force=begins.lower).out_of_range == ""
    assert "closes" in linear_check(flat, tol=0.05, force=begins.upper).out_of_range
    clear = linear_check(small(), tol=0.05)
    assert (clear.self_contact.begins.value, clear.self_contact.where) == (None, "")
    assert clear.self_contact.free_to > clear.force
    assert any(
        line.startswith("  self-contact   none is found up to ") for line in clear.details().splitlines()
    )


def test_a_budget_that_no_mesh_fits_buys_the_closed_form_and_says_so() -> None:
    """By what the first mesh took."""
    verdict = check(yamada(), budget=1e-3)
    assert verdict.model == "winkler"
    assert any("would take about" in w and "of the budget of 0.001 s" in w for w in verdict.warnings)
    assert verdict.next_model.model == "linear"
    assert verdict.next_model.seconds > 1e-3


@pytest.mark.slow
def test_a_large_budget_refinements_past_a_clear_verdict(monkeypatch: pytest.MonkeyPatch) -> None:
    """Three plain ridges: clear by the linear model, and much of the budget is left."""
    monkeypatch.setattr(adaptivity, "SHARP_SECONDS", 0.0)
    hard = filleted().with_(ridge={"count": 3}, skin={"width": 4.0}, contact={"force": 1.5})
    assert check(hard).model == "linear"
    verdict = check(hard, budget=1e3)
    assert verdict.next_model is None
    assert [run.model for run in verdict.models_tried][:2] == ["linear", "corrected"]


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


@pytest.mark.slow
def test_two_models_of_one_law_agree_on_a_steep_pad() -> None:
    """By the small strains of `linear` it passes from 1.9 N on; what auto asks then the solid says too."""
    verdict, best = (check(load("steep-fingertip"), model=model) for model in ("auto", "solid-finite-strain"))
    assert (verdict.model, verdict.passed, best.passed) == ("corrected-finite-strain", True, True)
    for of in (attrgetter("all_touch_force"), attrgetter("approach")):
        assert abs(of(verdict).value - of(best).value) <= of(verdict).error + of(best).error


@pytest.mark.slow
def test_a_force_out_of_a_better_models_range_has_no_verdict() -> None:
    """The small strains of `corrected` would say that all touch; at finite strain a ridge tips over."""
    hard = filleted().with_(ridge={"count": 3}, skin={"width": 4.0}, contact={"force": 12.0})
    verdict = check(hard, tol=0.01)
    assert verdict.model == "corrected"
    assert not verdict.passed
    assert "finite-strain model's range" in verdict.out_of_range
    assert verdict.next_model is None


def test_a_model_that_refuses_leaves_the_verdict_before(monkeypatch: pytest.MonkeyPatch) -> None:
    refused = ["corrected"]

    def refuse(name: str) -> Any:
        def answer(*_: object) -> Answer:
            raise RefusedError("it does not balance")

        return answer if name in refused else load_model(name)

    load_model = models.load
    monkeypatch.setattr(models, "load", refuse)
    for options in ({}, {"tol": 0.1}):  # with the tolerance corrected comes first, built on linear
        verdict = check(small(), force=UNDECIDED, **options)
        assert verdict.model == "linear"
        assert any("the corrected model" in w and "does not balance" in w for w in verdict.warnings)
        assert any("not met" in w for w in verdict.warnings) == bool(options)
    refused.append("linear")
    with pytest.raises(RefusedError, match="does not balance"):
        check(small())  # there is none before


NOTHING_LEFT = {
    "numpy's": lambda: np.empty(2**50),
    "NGSolve's": lambda: NgException("Could not allocate localheap, heapsize = 200000000"),
}


@pytest.mark.parametrize("kind", NOTHING_LEFT)
def test_a_model_that_runs_out_of_memory_leaves_what_it_builds_on(
    kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def too_large(*_: object) -> Answer:
        raise NOTHING_LEFT[kind]()

    load_model, lacking = models.load, {"corrected"}
    monkeypatch.setattr(models, "load", lambda name: too_large if name in lacking else load_model(name))
    verdict = check(small(), tol=0.1)  # begins with corrected
    assert verdict.model == "linear"
    assert any("the corrected model needs more memory" in w for w in verdict.warnings)
    lacking.add("linear")
    with pytest.raises(ExhaustedError, match="the linear model needs more memory than there is"):
        check(small())


def test_a_refinement_that_runs_out_of_memory_leaves_the_verdict_before(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def too_large(*_: object) -> Answer:
        raise MemoryError

    load_model = models.load
    monkeypatch.setattr(models, "load", lambda name: too_large if name == "corrected" else load_model(name))
    verdict = check(small(), force=UNDECIDED)
    assert verdict.model == "linear"
    assert any("the corrected model needs more memory" in w for w in verdict.warnings)


def test_a_model_is_priced_by_what_the_last_one_took() -> None:
    """0.1 s a ridge where none is solved; else each part by the last one's seconds over its price."""
    solved = {
        name: replace(QUICK, own_seconds=seconds) for name, seconds in (("linear", 2.0), ("winkler", 9.0))
    }
    price = {name: MODELS[name].price for name in MODELS}
    ahead = price["corrected"] + price["corrected-finite-strain"]
    assert expected_seconds("corrected-finite-strain", yamada(), {}) == pytest.approx(0.1 * 9 * (1 + ahead))
    assert expected_seconds("corrected-finite-strain", yamada(), solved) == pytest.approx(2.0 * ahead)
    solved["corrected"] = replace(QUICK, own_seconds=1.0)
    assert expected_seconds("corrected-finite-strain", yamada(), solved) == pytest.approx(
        price["corrected-finite-strain"] / price["corrected"]
    )
    assert expected_seconds("linear", yamada(), solved) == 0.0


QUICK = Answer(1, Estimate(0.0, 0.0, "N"), Estimate(0.1, 0.0, "mm"), (Estimate(1.0, 0.0, "N"),), 1, 0.0, {})
PRICES = {"linear": 1.0, "corrected": 2.0, "corrected-finite-strain": 4.5, "solid": 8.0}
LEFT = {"free ends": 0.2, "finite strain": 0.1}


class MadeUp:
    """Models that take twice their price in seconds of a clock of their own, and answer at once: F9 of
    `value` N with 1 % of it as the mesh's error (`mesh`); what is left out of a model is LEFT."""

    def __init__(self, patch: pytest.MonkeyPatch, value: float = 3.0) -> None:
        self.value, self.mesh, self.now = value, 0.01, 100.0
        self.asked: dict[str, Request] = {}
        self.refusals: dict[str, Exception] = {}
        winkler = models.load("winkler")
        patch.setattr(
            models, "load", lambda name: winkler if name == "winkler" else partial(self.answer, name)
        )
        patch.setattr(adaptivity, "perf_counter", lambda: self.now)
        patch.setattr(adaptivity, "expected_seconds", self.expected_seconds)
        patch.setattr(adaptivity, "YIELD_PRICE", 0.0)
        patch.setattr(adaptivity, "left_out", lambda effects, *_: tuple(map(self.bound, effects)))

    def answer(self, name: str, _: Any, request: Request, *__: object) -> Answer:
        seconds = 2 * PRICES.get(name, 3.0)
        if request.must_fit and request.budget is not None and seconds > request.budget:
            raise LateError(seconds)
        if name in self.refusals:
            raise self.refusals[name]
        self.now += seconds
        self.asked[name] = request
        first, down = Estimate(self.value, self.mesh * self.value, "N"), Estimate(0.1, 0.0, "mm")
        shares = (Estimate(request.force / 9, 0.0, "N"),) * 9
        return Answer(9, first, down, shares, 10, 0.0, {"contact": seconds, "yield": 50.0})

    def expected_seconds(self, name: str, _: Any, solved: dict[str, Answer]) -> float:
        """By half the speed once one is solved."""
        missing = {*models.prerequisites(name), name} - {*solved, "winkler"}
        slower = 2.0 if set(solved) - {"winkler"} else 1.0
        return slower * math.fsum(PRICES.get(model, 3.0) for model in missing)

    def bound(self, effect: str) -> LeftOut:
        return LeftOut(effect=effect, threshold=LEFT[effect], approach=LEFT[effect], share=LEFT[effect])


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
    value: float,
    sharp: float,
    model: str,
    climbed: list[str],
    passed: bool,
    monkeypatch: pytest.MonkeyPatch,
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
        "linear": NextModel("corrected", 4.0),
        "corrected": NextModel("corrected-finite-strain", 9.0),
    }
    last = NextModel("solid-finite-strain", 22.0)
    expected_next = None if model == "solid-finite-strain" else following.get(model, last)
    assert verdict.next_model == expected_next
    # the first by a guess, the others by what the last one took
    assert reports[:2] == [("linear model", 1.0), ("corrected model", 4.0)][: 1 + bool(climbed)]
    assert not any("not met" in w for w in verdict.warnings)


def test_no_model_is_begun_that_would_end_after_half_a_minute(monkeypatch: pytest.MonkeyPatch) -> None:
    MadeUp(monkeypatch, 3.99)
    verdict = check(yamada(), force=4.0)
    assert (verdict.model, verdict.verdict) == ("corrected-finite-strain", "undecided")
    assert verdict.next_model == NextModel("solid-finite-strain", 22.0)


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
        assert verdict.next_model == NextModel("linear", 2.0)
        return
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


def test_a_pad_too_large_for_any_mesh_has_the_closed_forms_verdict(monkeypatch: pytest.MonkeyPatch) -> None:
    fake = MadeUp(monkeypatch)
    fake.refusals["linear"] = SizeError("ridge.count", "too many", 900, "take fewer ridges")
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
    monkeypatch.setattr(adaptivity.ModelSelection, "_linear_seconds", lambda _: 2.0)
    answer = fake.answer

    def with_parts(*arguments: Any) -> Answer:
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
    assert verdict.next_model == NextModel("solid-finite-strain", pytest.approx(22.0 + 2.5))
    # within a budget it has its place before it is known what it takes
    for budget, model in ((8.9, "linear"), (9.1, "corrected")):
        within = check(yamada(), force=4.0, budget=budget)
        assert (within.model, within.manufacture is None) == (model, False)
        assert fake.asked["linear"].budget == pytest.approx(budget - 3.0)
        assert not any("budget" in w for w in within.warnings)
