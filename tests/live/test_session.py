"""Moves, what waits, undo and redo: frozen states, without a page."""

from __future__ import annotations

import random

import pytest

import skincad
from skincad.base import InputError
from skincad.live import apply_moves, start_session
from skincad.live.controls import controls, with_companions
from skincad.live.session import GESTURE, Session, redo_step, standing, table_for, undo_step
from skincad.shape import section


@pytest.fixture
def session() -> Session:
    return start_session(skincad.load("yamada-2002"))


def test_a_move_is_one_step_of_undo(session: Session) -> None:
    after = apply_moves(session, {"ridge.height": 0.6}, 0.0)
    assert after.design.ridge.height == 0.6
    assert undo_step(after).subject == session.subject
    assert redo_step(undo_step(after)).subject == after.subject
    assert undo_step(session) is session
    assert redo_step(session) is session


def test_a_slider_that_is_drawn_is_one_step_and_two_draws_are_two(session: Session) -> None:
    drawn = session
    for i in range(1, 6):
        drawn = apply_moves(drawn, {"ridge.height": 0.5 + 0.01 * i}, 0.1 * i)
    assert len(drawn.past) == 1
    assert len(apply_moves(drawn, {"ridge.height": 0.7}, 0.5 + 2 * GESTURE).past) == 2
    assert len(apply_moves(drawn, {"ridge.pitch": 1.1}, 0.6).past) == 2  # another key


def test_what_breaks_a_rule_waits_and_the_last_skin_stays(session: Session) -> None:
    broken = apply_moves(session, {"ridge.root_width": 1.5}, 0.0)
    assert broken.subject == session.subject
    assert broken.refusal is not None
    with pytest.raises(InputError) as refused:
        skincad.load("yamada-2002", ["ridge.root_width=1.5"])
    assert str(broken.refusal) == str(refused.value)  # the design's own line
    assert standing(broken, "ridge.root_width") == 1.5  # the slider stays where it was moved to
    assert undo_step(broken) == session


def test_two_moves_may_pass_through_what_is_none(session: Session) -> None:
    """Wider roots need a wider pitch: whichever comes first."""
    first = apply_moves(session, {"ridge.root_width": 1.5}, 0.0)
    both = apply_moves(first, {"ridge.pitch": 2.0, "skin.width": 20.0}, 1.0)
    assert both.refusal is None
    assert not both.pending
    assert (both.design.ridge.root_width, both.design.ridge.pitch) == (1.5, 2.0)
    assert undo_step(both).subject == session.subject


def test_a_value_that_comes_back_is_no_longer_waiting(session: Session) -> None:
    broken = apply_moves(session, {"ridge.root_width": 1.5}, 0.0)
    back = apply_moves(broken, {"ridge.root_width": 0.75}, 0.1)
    assert back.refusal is None
    assert back.subject == session.subject
    assert not back.past


def test_a_section_that_cannot_be_is_refused_too(session: Session) -> None:
    """The rule is the geometry's: fillets that do not fit."""
    broken = apply_moves(session, {"ridge.tip_fillet": 0.4}, 0.0)
    assert broken.refusal is not None
    assert broken.subject == session.subject


def test_tables_go_and_come_back_as_they_were(session: Session) -> None:
    other = apply_moves(session, {"slot.depth": 0.3}, 0.0)
    without = apply_moves(other, {"slot": None}, 2.0)
    assert without.design.slot is None
    assert without.design.film is None
    assert without.refusal is None
    back = apply_moves(without, {"slot": table_for(without, "slot")}, 4.0)
    assert back.design.slot == other.design.slot
    plain = start_session(skincad.load("plain-ridges"))
    table = table_for(plain, "slot")  # never had one: a template's
    assert table == skincad.load("yamada-2002").slot.model_dump()  # type: ignore[union-attr]


@pytest.mark.parametrize("shape", ["tilted", "cylinder", "step"])
def test_a_plate_of_another_shape_gets_what_it_needs(session: Session, shape: str) -> None:
    after = apply_moves(session, with_companions("contact.plate.shape", shape), 0.0)
    assert after.refusal is None
    flat = apply_moves(after, with_companions("contact.plate.shape", "flat"), 2.0)
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


@pytest.mark.parametrize("name", ["yamada-2002", "plain-ridges", "cast-in", "yamada-2002-slip"])
def test_200_random_moves_end_in_a_valid_subject_or_a_line(name: str) -> None:
    """Also far out of range: nothing but the design's own line ever comes back."""
    dice = random.Random(name)
    scene = name in skincad.template_names("scenes")
    session = start_session(skincad.load_scene(name) if scene else skincad.load(name))
    refused = 0
    for step in range(200):
        every = controls(session.subject)
        control = dice.choice(every)
        if control.kind == "choice":
            values = with_companions(control.key, dice.choice(control.choices) or None)
        elif control.kind == "table":
            values = {control.key: None if control.value else table_for(session, control.key)}
        else:
            value = dice.uniform(control.low, control.high) * dice.choice([1.0, 1.0, 1.0, -1.0, 100.0])
            values = {control.key: round(value) if control.whole else value}
        session = apply_moves(session, values, float(step))
        section(session.design)  # always one
        refused += session.refusal is not None
        if session.refusal is not None and dice.random() < 0.7:
            session = undo_step(session)
    assert 0 < refused < 200
