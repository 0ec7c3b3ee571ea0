"""Pads of very many features: against the full models, their ends, and their number."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy import interpolate, sparse

from skincad import InputError, check, load
from skincad.inputs import Design
from skincad.mechanics import Answer, Request, pad_of, pressed
from skincad.mechanics import check as checking
from skincad.mechanics.models import corrected, linear, reduced
from skincad.shape import skin_of


def pad(count: int, **ridge: float) -> Design:
    """Short and thin, so that the cell is short too: its crests lie as far apart as nine of plain-ridges."""
    skin = {
        "width": count + 2.0,
        "curvature_radius": 60.0 * (count / 9) ** 2,
        "length": 4.0,
        "thickness": 1.5,
    }
    contact = {"force": 0.25 * count, "friction": 0.0}
    return load("plain-ridges").with_(ridge={"count": count, **ridge}, skin=skin, contact=contact)


@cache
def answers(count: int) -> tuple[Answer, Answer]:
    design = pad(count)
    request = Request(design.contact.force)
    return reduced.answer(design, request), corrected.answer(design, request)


def assert_same(quick: Answer, full: Answer) -> None:
    assert quick.all_touch_force.value == pytest.approx(
        full.all_touch_force.value, rel=reduced.ERRORS.threshold
    )
    assert quick.approach.value == pytest.approx(full.approach.value, rel=reduced.ERRORS.approach)
    shares = [np.array([f.value for f in answer.ridge_force]) for answer in (quick, full)]
    assert np.abs(shares[0] - shares[1]).max() <= reduced.ERRORS.share * shares[1].mean()
    assert shares[0].sum() == pytest.approx(shares[1].sum(), rel=1e-8)  # the root's


@pytest.mark.slow
def test_twenty_five_features_are_those_of_the_full_model() -> None:
    assert skin_of(reduced.cell_of(pad(25))).count < 20
    assert_same(*answers(25))


@pytest.mark.evidence(subject="reduced: {count}")
@pytest.mark.parametrize("count", [45, 101])
def test_more_are_too(count: int) -> None:
    assert_same(*answers(count))


def springs(count: int, reach: int = 3) -> reduced.FeatureModel:
    """Features that stiffen, each felt by its neighbours."""
    indentation = np.linspace(0.0, 1.0, 40)
    offsets = [*range(-reach, reach + 1)]
    coupling = sparse.diags([0.1 * 0.5 ** abs(k) for k in offsets], offsets, (count, count), format="csr")
    gap = 0.2 * np.linspace(-1.0, 1.0, count) ** 2
    return reduced.FeatureModel(gap, 2 * indentation**1.5, indentation, coupling)


def test_each_touching_feature_bears_what_its_indentation_asks_for() -> None:
    model = springs(31)
    forces, approach = pressed(model, 0.3)
    indentation = approach - model.gap - model.coupling @ forces
    touching = indentation > 0
    assert 0 < touching.sum() < 31
    assert forces.sum() == pytest.approx(0.3, rel=1e-8)
    asked = interpolate.PchipInterpolator(model.indentation, model.force)(indentation[touching])
    np.testing.assert_allclose(forces[touching], asked, rtol=1e-8)
    assert not forces[~touching].any()


def test_all_touch_where_the_last_gap_closes() -> None:
    model = springs(31)
    first = reduced.all_touch_force(model)
    fewer, all_of_them = (pressed(model, share * first)[0] for share in (0.999, 1.001))
    assert (fewer > 0).sum() == 29
    assert (all_of_them > 0).all()
    one = replace(model, gap=model.gap[:1], coupling=model.coupling[:1, :1])
    assert reduced.all_touch_force(one) == 0.0


def test_two_thousand_features_are_a_sparse_system() -> None:
    """What a pad of pins has: the time is not asserted, but a dense system would not end."""
    model = springs(2000)
    forces, indentation = reduced.at_approach(model, 0.25)
    assert (indentation > 0).any()
    assert (indentation < 0).any() == (forces == 0).any()
    assert pressed(model, float(forces.sum()))[1] == pytest.approx(0.25, rel=1e-7)


@pytest.mark.slow
def test_without_free_ends_it_is_plane_strain() -> None:
    """A pad no longer than its cell: what is reduced alone differs."""
    design = pad(15)
    model = reduced.feature_model(design, design.contact.force, {}, ends=False)
    full = linear.solve(pad_of(design), Request(design.contact.force))
    assert reduced.all_touch_force(model) == pytest.approx(full.all_touch_force.value, rel=0.02)
    assert pressed(model, design.contact.force)[1] == pytest.approx(full.approach.value, rel=0.01)


@pytest.mark.slow
def test_auto_takes_it_of_many_features_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first where there are more than 60, and where no time is left for a better one the last."""
    monkeypatch.setattr(checking, "DEFAULT_BUDGET", 0.0)
    monkeypatch.setattr(checking, "SHARP_SECONDS", 0.0)
    many = check(pad(61))
    assert (many.model, many.models_tried, many.manufacture) == ("reduced", (), None)
    assert many.next_model.model == "corrected"
    assert check(pad(5)).model == "linear"


def test_unlike_features_are_none_of_its() -> None:
    with pytest.raises(InputError, match="must be alike for the reduced model"):
        check(pad(9, levelling=0.5), model="reduced")
