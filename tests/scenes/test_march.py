"""The march: a new effect is a file and a line, a failing step ends it with what it has."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from skincad.base import InputError, quantity
from skincad.effects import CondensedPad, Friction, Law, PadChange, Reader, Share, Step, Term, condensed
from skincad.mechanics import ContactError, ContactPad, ContactState, Drive
from skincad.scenes import simulate
from skincad.scenes.march import march
from tests.small_scene import make_up_effects, small_scene

TIMES = np.linspace(0.0, 1.0, 5)


def block() -> CondensedPad:
    """One point on springs of 0.25 and 0.1 mm/N."""
    one, none = np.ones(1), np.zeros(1)
    pad = ContactPad(
        np.diag([0.25, 0.1]), none, none, np.ones(1, dtype=np.int64), one, np.zeros((0, 3, 2)), 1
    )
    return condensed(pad)


def test_gross_slip_ends_a_march_under_force() -> None:
    drives = [Drive(2.0 * bool(i), 0.4 * i) for i in range(5)]
    run = march(block(), TIMES, drives, [Friction(coefficient=0.5)])
    assert run.stopped == "gross slip"
    assert not run.failed
    assert run.column("tangential") == pytest.approx([0.0, 0.4, 0.8, 1.0], rel=1e-12)
    assert run.column("slips").ravel().tolist() == [False, False, False, True]


def test_a_driven_plate_goes_on_through_gross_slip_and_its_work_is_accounted_for() -> None:
    drives = [Drive(2.0 * bool(i), travel=0.2 * i) for i in range(5)]
    run = march(block(), TIMES, drives, [Friction(coefficient=0.5)])
    assert run.stopped is None
    assert run.column("tangential") == pytest.approx([0.0, 0.8, 1.0, 1.0, 1.0], rel=1e-12)
    # by hand: 0.25 mm of spring, the other 0.55 mm of 0.8 are slip at 1 N but for the step that breaks off
    assert run.column("dissipated").sum() == pytest.approx(0.15 * 0.9 + 0.4, rel=1e-12)


def test_a_march_tells_the_hardest_that_a_ridge_was_pressed() -> None:
    """Two ridges of unlike springs in z: the stiffer bears 2/3 of 3 N, by hand; then the plate eases off."""
    none, two = np.zeros(2), np.ones(2)
    springs = np.diag([0.25, 0.25, 0.1, 0.2])
    pad = ContactPad(springs, none, none, np.array([1, 2]), two, np.zeros((0, 3, 4)), 2)
    drives = [Drive(force, 0.0) for force in (0.0, 1.0, 3.0, 2.0, 1.0)]
    run = march(condensed(pad), TIMES, drives, [Friction(coefficient=0.5)])
    assert run.loads[:, 0].max() == pytest.approx(2.0, rel=1e-9)


class _Failing(CondensedPad):
    def advanced(self, state: ContactState, step: Step, shares: Any) -> ContactState:
        if step.end > 0.6:
            raise self.failure
        return super().advanced(state, step, shares)


@pytest.mark.parametrize("failure", [ContactError("the sets do not settle"), KeyboardInterrupt()])
def test_what_cannot_go_on_stops_with_what_it_has(failure: BaseException) -> None:
    model = _Failing(block().pad, block().skin)
    object.__setattr__(model, "failure", failure)
    drives = [Drive(0.5 * i, 0.0) for i in range(5)]
    run = march(model, TIMES, drives, [Friction(coefficient=0.5)], partial=True)
    assert len(run.readings) == run.time.size == 3
    assert run.failed == isinstance(failure, ContactError)
    assert run.interrupted == isinstance(failure, KeyboardInterrupt)
    if run.failed:
        assert run.stopped == "step 3, t = 0.75 s: the sets do not settle"


def test_ctrl_c_goes_on_to_a_caller_who_does_not_ask_for_a_part() -> None:
    model = _Failing(block().pad, block().skin)
    object.__setattr__(model, "failure", KeyboardInterrupt())
    with pytest.raises(KeyboardInterrupt):
        march(model, TIMES, [Drive(0.5 * i, 0.0) for i in range(5)], [Friction(coefficient=0.5)])


class Softer(Law):
    """A law that makes every compliance larger."""

    factor: float = quantity("1", "of the compliance", gt=0.0)

    def marched(self, part: Any, mesh: Any, order: int, films: bool, terms: Any) -> CondensedPad:  # noqa: ARG002
        from dataclasses import replace

        from skincad.mechanics import sliding

        pad = sliding(part, mesh, order, films)
        # its field is that of the harder pad, and would lie above the plate
        return condensed(replace(pad, compliance=self.factor * pad.compliance, whole=None))


class Thicker(PadChange):
    """A body that changes the pad."""

    def check(self, design: Any) -> None:
        if design.ridge.count > 3:
            raise InputError("", "is for three ridges", design.ridge.count)

    def changed(self, pad: Any, design: Any) -> Any:  # noqa: ARG002
        from dataclasses import replace

        return replace(pad, young_modulus=2 * pad.young_modulus, film_modulus=2 * pad.film_modulus)


class Telling(Reader):
    """A readout with a key of its own."""

    def read(self, watched: Any, time: Any, readings: Any) -> dict[str, Any]:  # noqa: ARG002
        return {"largest_force_N": max(r.normal for r in readings)}


class Sticky(Term):
    """A term of its own."""

    def share(self, step: Step) -> Share:
        return Share(more={"at": step.end})


SMALL = [
    "skin=small.toml",
    "history.time_s=[0.0, 1.0]",
    "history.normal_force_N=[0.0, 1.0]",
    "history.tangential_force_N=[0.0, 0.0]",
    "history.steps=2",
    "effects.film=none",
    "effects.friction=none",
    "readout.ridges=[]",
]


def test_a_new_effect_is_its_own_file_and_a_line_in_the_table(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Any
) -> None:
    make_up_effects(monkeypatch, Softer, Thicker, Telling, Sticky)

    def run(*more: str) -> Any:
        return simulate(small_scene(tmp_path, "yamada-2002-slip", *SMALL, *more))

    plain = run()
    soft = run("effects.softer.factor=2.0", "effects.telling={}")
    stiff = run("effects.thicker={}")
    # in small strain a pad of half the stiffness is the same at half the force
    assert soft.march.readings[1].approach > plain.march.readings[1].approach
    assert stiff.march.readings[2].approach == pytest.approx(plain.march.readings[1].approach, rel=1e-9)
    assert soft.march.readings[1].approach == pytest.approx(plain.march.readings[2].approach, rel=1e-9)
    assert soft.as_json()["largest_force_N"] == pytest.approx(1.0)
    with pytest.raises(Exception, match="takes no share but friction's"):
        run("effects.sticky={}")
    with pytest.raises(InputError, match="effects: must name one law at most"):
        run("effects.softer.factor=2.0", "effects.small_strain={}")
    with pytest.raises(InputError, match=r"effects\.thicker: is for three ridges, got 9"):
        run("effects.thicker={}", "skin=yamada-2002")
