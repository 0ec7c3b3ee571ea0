"""A step at finite strain: cut, driven by travel, and stopped where the surface folds."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from skincad.mechanics import ContactError, Drive, FrictionalState, FrictionCoefficients, advance_to
from skincad.mechanics.bodies.elements import Outline
from skincad.mechanics.contact import frictional_pad
from skincad.mechanics.contact.frictional_pad import newton, unloaded
from skincad.mechanics.contact.press_path import CREASES, WRINKLES, pinch, undetected_contact
from tests.mechanics.contact.test_dragged import march, pulled, three

CONE = FrictionCoefficients(0.5, 0.5)


def test_a_step_that_does_not_converge_is_cut(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first tries are made to fail: the halves then are what the step took."""
    tries = []

    def failing(pad: Any, before: FrictionalState, end: Drive, *more: Any) -> FrictionalState:
        tries.append(end.normal)
        if len(tries) == 1:
            raise ContactError("made to fail")
        return newton(pad, before, end, *more)

    monkeypatch.setattr(frictional_pad, "newton", failing)
    what = three()[1]
    state = advance_to(what, unloaded(what), Drive(0.0, 0.0), Drive(0.4, 0.0), CONE)
    assert tries == [0.4, 0.2, 0.4]
    first = newton(what, unloaded(what), Drive(0.2, 0.0), CONE)
    second = newton(what, first, Drive(0.4, 0.0), CONE)
    assert state.values == pytest.approx(second.values, abs=1e-8 * np.abs(second.values).max())
    assert state.dissipated == pytest.approx(first.dissipated + second.dissipated, rel=1e-6)
    assert state.iterations > second.iterations


def test_a_guess_that_turns_an_element_inside_out_is_not_taken() -> None:
    what = three()[1]
    first = newton(what, unloaded(what), Drive(0.2, 0.0), CONE)
    inside_out = np.random.default_rng(1).standard_normal(first.values.size)
    assert not np.isfinite(what.body.residual(inside_out)).all()
    what.tangents.clear()
    wanted = newton(what, first, Drive(0.4, 0.0), CONE)
    what.tangents.clear()
    state = newton(what, first, Drive(0.4, 0.0), CONE, inside_out)
    assert (state.values == wanted.values).all()


def test_a_pull_that_does_not_converge_is_driven_by_travel(monkeypatch: pytest.MonkeyPatch) -> None:
    """Newton is made to fail under every tangential force: the travel finds the same state.

    1e-6: steps of the travel are other steps of friction than the one of the force.
    """
    what, start = three()[1], pulled()[4]
    wanted = advance_to(what, start, Drive(1.2, 0.18), Drive(1.2, 0.22), CONE)

    def failing(pad: Any, before: FrictionalState, end: Drive, *more: Any) -> FrictionalState:
        if end.tangential is not None:
            raise ContactError("made to fail")
        return newton(pad, before, end, *more)

    monkeypatch.setattr(frictional_pad, "newton", failing)
    state = advance_to(what, start, Drive(1.2, 0.18), Drive(1.2, 0.22), CONE)
    assert state.contact.tangential.sum() == pytest.approx(0.22, abs=2e-9)
    assert state.contact.travel == pytest.approx(wanted.contact.travel, rel=1e-6)
    with pytest.raises(ContactError, match=r"the pull cannot grow beyond 0\.\d+ N|Newton finds no"):
        advance_to(what, start, Drive(1.2, 0.18), Drive(1.2, 0.7), CONE)


def loop(stretch: float, height: float) -> Outline:
    """A rectangle whose upper side's middle part is shorter by `stretch`, under a plate at 2."""
    x = np.array([0.0, 1.0, 1.0, 0.8, 0.6, 0.4, 0.2, 0.0])
    z = np.array([0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0])
    moved = np.column_stack([x, z * height])
    moved[4, 0] = 0.4 + 0.2 * stretch
    return Outline(np.column_stack([x, z]), moved, np.arange(8) == 4)


def test_pinch_finds_the_most_compressed_free_surface() -> None:
    smallest = pinch([loop(0.5, 1.0)], 2.0)
    assert smallest.stretch == pytest.approx(0.5)
    assert smallest.place == pytest.approx([0.5, 1.0])
    assert smallest.tip
    # what bears on the plate cannot fold
    assert pinch([loop(0.5, 1.0)], 1.0).stretch == np.inf


def test_limits_are_biots_and_hongs() -> None:
    """A half-space in plane strain, l its stretch: surface waves where l^6 + l^4 + 3 l^2 = 1."""
    roots = np.roots([1.0, 1.0, 3.0, -1.0])
    square = roots[np.isreal(roots)].real.max()
    assert np.sqrt(square) == pytest.approx(WRINKLES, abs=5e-4)
    assert WRINKLES < CREASES == 1 - 0.354


def test_much_friction_folds_the_surface_and_the_reason_names_the_place() -> None:
    """Pulled by travel at a coefficient of 1: smooth at 0.4 mm, folded by 0.6."""
    what, cone = three()[1], FrictionCoefficients(1.0, 1.0)
    state = march(what, [Drive(0.6, 0.0), Drive(1.2, 0.0)], cone)[-1]
    words = None
    for travel in (0.1, 0.2, 0.3, 0.4, 0.5, 0.55, 0.6):
        drive = Drive(1.2, travel=state.contact.travel)
        state = advance_to(what, state, drive, Drive(1.2, travel=travel), cone)
        words = undetected_contact(what, state, True)
        if words:
            break
    assert travel > 0.4
    assert words is not None
    assert "the surface folds onto itself at ridge " in words
    assert undetected_contact(what, state, False) is None
    assert 0.5 < state.contact.tangential.sum() / 1.2 < 0.75
