"""One to four ridges: every model has a verdict that agrees with itself, or refuses with a reason."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import count, islice

import numpy as np
import pytest

import skincad
from bench.campaign.random_designs import drawn
from skincad import InputError, RefusedError
from skincad.inputs import Design
from skincad.mechanics import MODELS, prerequisites
from tests.families import RIDGED

FEW = (1, 2, 3, 4)
COARSE = 0.5  # relative: the coarsest mesh, as it is the path that is tested and not the number
COSTLY = (
    "yamada-2002",
    "steep-fingertip",
)  # of `solid-finite-strain`, 3 s each; the others' meshes are alike


def judge(design: Design, model: str) -> bool:
    """Whether a model has a verdict on a design, and does not refuse it."""
    try:
        verdict = skincad.check(design, model=model, tol=COARSE)
    except (InputError, RefusedError):
        return False
    forces = np.array([share.value for share in verdict.ridge_force], dtype=float)
    assert forces.size == design.ridge.count
    assert forces.sum() == pytest.approx(design.contact.force, rel=1e-6)  # the contact residual
    assert np.count_nonzero(forces) == verdict.touching
    needed = verdict.all_touch_force
    assert needed.value is None or needed.value >= 0
    assert str(verdict).upper().startswith(verdict.verdict.upper())
    return True


def judge_each(design: Design, models: Sequence[str]) -> None:
    """Judge by each model; one on which another builds ran with that, unless the other refused."""
    done: set[str] = set()
    for model in reversed(models):
        if model not in done and judge(design, model):
            done.update(prerequisites(model))


@pytest.mark.parametrize("ridges", FEW)
@pytest.mark.parametrize("model", ["winkler", "linear", pytest.param("corrected", marks=pytest.mark.slow)])
def test_few_ridges_have_a_verdict(model: str, ridges: int) -> None:
    assert judge(skincad.load("yamada-2002", [f"ridge.count={ridges}"]), model)


def random_few() -> Iterator[Design]:
    """Random designs with one to four ridges."""
    dice = np.random.default_rng(12)
    for seed in count():
        design = drawn(seed).design
        bent = {"skin": {"curvature_radius_y": None}} if design.skin.curvature_radius_y else {}
        try:
            yield design.with_(**bent, ridge={"count": int(dice.integers(1, 5))})
        except InputError:
            continue


@pytest.mark.slow
def test_random_designs_with_few_ridges_have_a_verdict() -> None:
    judged = [judge(design, "linear") for design in islice(random_few(), 10)]
    assert sum(judged) >= 7  # the others tip over


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, 60, 15))
def test_random_designs_with_few_ridges_crash_no_model(first: int) -> None:
    for design in islice(random_few(), first, first + 15):
        assert judge(design, "winkler")
        judge_each(design, ("corrected", "corrected-finite-strain"))


@pytest.mark.slow
@pytest.mark.parametrize("name", RIDGED)
def test_few_ridges_of_every_template_crash_no_model(name: str) -> None:
    for ridges in FEW:
        design = skincad.load(name, [f"ridge.count={ridges}"])
        judge_each(design, [m for m in MODELS if m != "solid-finite-strain" or name in COSTLY])
