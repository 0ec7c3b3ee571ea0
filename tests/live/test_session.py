"""A session without a page: moves, what waits, undo and redo; a control for every number and choice."""

from __future__ import annotations

import random
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import skincad
from skincad.base import InputError, Table
from skincad.live import apply_moves, controls, plots, start_session
from skincad.live import session as steps
from skincad.shape import section

DESIGNS = skincad.template_names()
SCENES = [name for name in skincad.template_names("scenes") if skincad.load_scene(name).grip is None]


def loaded(name: str) -> Any:
    return skincad.load_scene(name) if name in SCENES else skincad.load(name)


@pytest.fixture
def session() -> steps.Session:
    return start_session(loaded("yamada-2002"))


def test_a_move_is_one_step_of_undo(session: steps.Session) -> None:
    after = apply_moves(session, {"ridge.height": 0.6}, 0.0)
    assert after.design.ridge.height == 0.6
    assert steps.undo_step(after).subject == session.subject
    assert steps.redo_step(steps.undo_step(after)).subject == after.subject
    assert steps.undo_step(session) is session
    assert steps.redo_step(session) is session


def test_a_slider_that_is_drawn_is_one_step_and_two_draws_are_two(session: steps.Session) -> None:
    drawn = session
    for i in range(1, 6):
        drawn = apply_moves(drawn, {"ridge.height": 0.5 + 0.01 * i}, 0.1 * i)
    assert len(drawn.past) == 1
    assert len(apply_moves(drawn, {"ridge.height": 0.7}, 0.5 + 2 * steps.GESTURE).past) == 2
    assert len(apply_moves(drawn, {"ridge.pitch": 1.1}, 0.6).past) == 2  # another key


def test_what_breaks_a_rule_waits_and_the_last_skin_stays(session: steps.Session) -> None:
    broken = apply_moves(session, {"ridge.root_width": 1.5}, 0.0)
    assert broken.subject == session.subject
    assert isinstance(broken.refusal, InputError)
    assert broken.refusal.key == "ridge.root_width"
    with pytest.raises(InputError) as refused:
        skincad.load("yamada-2002", ["ridge.root_width=1.5"])
    assert str(broken.refusal) == str(refused.value)  # the design's own line
    assert steps.standing(broken, "ridge.root_width") == 1.5  # the slider stays where it was moved to
    assert steps.undo_step(broken) == session


def test_two_moves_may_pass_through_what_is_none(session: steps.Session) -> None:
    """Wider roots need a wider pitch: whichever comes first."""
    first = apply_moves(session, {"ridge.root_width": 1.5}, 0.0)
    both = apply_moves(first, {"ridge.pitch": 2.0, "skin.width": 20.0}, 1.0)
    assert both.refusal is None
    assert not both.pending
    assert (both.design.ridge.root_width, both.design.ridge.pitch) == (1.5, 2.0)
    assert steps.undo_step(both).subject == session.subject


def test_a_value_that_comes_back_is_no_longer_waiting(session: steps.Session) -> None:
    broken = apply_moves(session, {"ridge.root_width": 1.5}, 0.0)
    back = apply_moves(broken, {"ridge.root_width": 0.75}, 0.1)
    assert back.refusal is None
    assert back.subject == session.subject
    assert not back.past


def test_a_section_that_cannot_be_is_refused_too(session: steps.Session) -> None:
    """The rule is the geometry's: fillets that do not fit."""
    broken = apply_moves(session, {"ridge.tip_fillet": 0.4}, 0.0)
    assert broken.refusal is not None
    assert broken.subject == session.subject


def test_tables_go_and_come_back_as_they_were(session: steps.Session) -> None:
    other = apply_moves(session, {"slot.depth": 0.3}, 0.0)
    without = apply_moves(other, {"slot": None}, 2.0)
    assert without.design.slot is None
    assert without.design.film is None
    assert without.refusal is None
    back = apply_moves(without, {"slot": steps.table_for(without, "slot")}, 4.0)
    assert back.design.slot == other.design.slot
    plain = start_session(skincad.load("plain-ridges"))
    table = steps.table_for(plain, "slot")  # never had one: a template's
    assert table == skincad.load("yamada-2002").slot.model_dump()  # type: ignore[union-attr]


@pytest.mark.parametrize("shape", ["tilted", "cylinder", "step"])
def test_a_plate_of_another_shape_gets_what_it_needs(session: steps.Session, shape: str) -> None:
    after = apply_moves(session, controls.with_companions("contact.plate.shape", shape), 0.0)
    assert after.refusal is None
    flat = apply_moves(after, controls.with_companions("contact.plate.shape", "flat"), 2.0)
    assert flat.subject == session.subject


def test_a_scene_moves_with_its_skin_and_its_history() -> None:
    session = start_session(skincad.load_scene("yamada-2002-slip"))
    after = apply_moves(session, {"skin.ridge.height": 0.45, "history.tangential_force_N.3": 3.0}, 0.0)
    assert after.refusal is None
    assert after.design.ridge.height == 0.45
    assert after.subject.history.tangential_force_N[2] == 3.0  # type: ignore[union-attr,index]
    backwards = apply_moves(after, {"history.time_s.3": 0.0005}, 2.0)
    assert backwards.refusal is not None
    assert "must not go back" in str(backwards.refusal)


@pytest.mark.parametrize("name", SCENES)
def test_every_scenes_history_is_a_plot_and_takes_a_point_more_or_less(name: str) -> None:
    """Each given curve on its unit's axis, in one length; what is added lies on the curve."""
    scene = loaded(name)
    plot = plots.history_plot(scene.history)
    assert len(plot["data"]) == len(plot["series"]) == len(plots.lists(scene.history))
    assert {len(row) for row in plot["data"]} == {len(scene.history.time_s)}
    units = {curve["scale"] for curve in plot["series"][1:]}
    assert units == {axis["scale"] for axis in plot["axes"][1:]} <= {"N", "mm", "deg"}
    longer = apply_moves(start_session(scene), plots.with_point(scene.history), 0.0)
    assert longer.refusal is None
    shorter = apply_moves(longer, plots.without_point(longer.subject.history), 2.0)
    times = scene.history.time_s
    assert len(longer.subject.history.time_s) == len(times) + 1
    if shorter.refusal is None:
        assert len(shorter.subject.history.time_s) == len(times)
    (time, *curves), before = plots.history_plot(longer.subject.history)["data"], plot["data"]
    for curve, known in zip(curves, before[1:], strict=True):
        assert curve == pytest.approx(np.interp(time, before[0], known), rel=1e-5, abs=1e-9)


def test_a_history_keeps_two_points() -> None:
    history = SimpleNamespace(**dict.fromkeys(plots.CURVES), time_s=[0.0, 1.0])
    history.normal_force_N = [0.0, 4.0]
    assert plots.without_point(history) == {}


def moved(subject: Any, dice: random.Random, moves: int) -> int:
    """Make so many random moves, far out of range too; return how many the design's own line refused."""
    session, refused = start_session(subject), 0
    for step in range(moves):
        control = dice.choice(controls.controls(session.subject))
        if control.kind == "choice":
            values = controls.with_companions(control.key, dice.choice(control.choices) or None)
        elif control.kind == "table":
            values = {control.key: None if control.value else steps.table_for(session, control.key)}
        else:
            value = dice.uniform(control.low, control.high) * dice.choice([1.0, 1.0, 1.0, -1.0, 100.0])
            values = {control.key: round(value) if control.whole else value}
        session = apply_moves(session, values, float(step))
        section(session.design)  # always one
        refused += session.refusal is not None
        if session.refusal is not None and dice.random() < 0.7:
            session = steps.undo_step(session)
    return refused


RANDOM_MOVES = [
    ("yamada-2002", 40),
    ("yamada-2002-slip", 40),
    *(
        pytest.param(name, 200, marks=pytest.mark.evidence(subject="live: 200 moves"))
        for name in ("yamada-2002", "plain-ridges", "cast-in", "yamada-2002-slip")
    ),
]


@pytest.mark.parametrize(("name", "moves"), RANDOM_MOVES)
def test_random_moves_end_in_a_valid_subject_or_a_line(name: str, moves: int) -> None:
    assert 0 < moved(loaded(name), random.Random(name), moves) < moves


def numbers(table: Table, before: str = "") -> Iterator[str]:
    """The keys of all numbers that a design's tables hold, by walking what they hold."""
    for key, value in table:
        if isinstance(value, bool | str | dict) or value is None:
            continue
        if isinstance(value, Table) and {"value", "low", "high"} != {name for name, _ in value}:
            yield from numbers(value, f"{before}{key}.")
        elif isinstance(value, tuple | list):
            yield from (f"{before}{key}.{place}" for place, _ in enumerate(value, 1))
        else:
            yield f"{before}{key}"


@pytest.mark.parametrize("name", DESIGNS)
def test_every_number_of_a_design_has_a_slider(name: str) -> None:
    design = loaded(name)
    sliders = {control.key for control in controls.controls(design) if control.kind == "slider"}
    assert {*numbers(design)} <= sliders


@pytest.mark.parametrize("name", [*DESIGNS, *SCENES])
def test_each_control_holds_its_value_and_says_what_it_is(name: str) -> None:
    rows = controls.controls(loaded(name))
    assert len({control.key for control in rows}) == len(rows)
    for control in rows:
        assert control.hint
        if control.kind == "slider":
            assert control.low < control.high
            assert 0 < control.step <= control.high - control.low
            value = control.initial if control.value is None else control.value
            assert isinstance(value, int | float)
            assert control.low <= value <= control.high, control
        elif control.kind == "choice":
            assert control.value in control.choices


@pytest.mark.parametrize("name", ["yamada-2002", "yamada-2002-tilted", "drop", "rolling"])
def test_each_control_can_be_set_to_its_own_value(name: str) -> None:
    """A key that a control names is one that a session knows: nothing moves, and nothing is refused."""
    session = start_session(loaded(name))
    for control in controls.controls(session.subject):
        if control.value not in (None, "", True, False):
            after = apply_moves(session, {control.key: control.value}, 0.0)
            assert after.refusal is None, control


def test_a_scene_has_its_skins_controls_and_its_own() -> None:
    keys = {control.key for control in controls.controls(loaded("yamada-2002-slip"))}
    assert {"skin.ridge.height", "effects.friction.coefficient", "history.normal_force_N.2"} <= keys
    assert "history.normal_force_N.1" not in keys  # a history begins unloaded


@pytest.mark.parametrize(
    ("value", "low", "high", "unit", "ends"),
    [
        (0.5, 0.0, 50.0, "mm", (0.0, 2.0)),
        (60.0, 1.0, 1e8, "mm", (1.0, 240.0)),
        (0.3, 0.0, 1.0, "", (0.0, 1.0)),  # a share, whole
        (10.0, -80.0, 80.0, "deg", (-80.0, 80.0)),
        (-2.0, -50.0, 50.0, "mm", (-10.0, 6.0)),
        (0.0, 0.0, 20.0, "mm", (0.0, 1.0)),
    ],
)
def test_a_slider_reaches_so_far(
    value: float, low: float, high: float, unit: str, ends: tuple[float, float]
) -> None:
    assert controls.reach(value, low, high, unit) == ends
    assert controls.REACH == 4.0
