"""The state of an edit: the last valid design or scene, the values that still wait, and the undo steps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from skincad.base.errors import InputError
from skincad.inputs.catalog import load_design
from skincad.inputs.design import Design
from skincad.inputs.material import refuse_layers
from skincad.scenes.scene import Scene
from skincad.shape.skin import section
from skincad.studies.subject import Setting, changed, value_of

Editable = Design | Scene
GESTURE = 1.0  # s; moves of one key that follow each other so soon are one step of undo
MAX_UNDO_STEPS = 500  # of undo
TABLES_OF = "yamada-2002"  # the template whose slot or film a design gets that never had one


@dataclass(frozen=True)
class Session:
    """A `subject` that obeys all rules, and later values that it cannot take.

    `pending` are the keys whose values no valid subject has yet, `refusal` says why; both are empty where all
    that was asked stands. `past` and `future` are what undo and redo lead to, the nearest last.
    """

    subject: Editable
    pending: Mapping[str, Setting] = field(default_factory=dict)
    refusal: InputError | None = None
    past: tuple[Editable, ...] = ()
    future: tuple[Editable, ...] = ()
    gesture: tuple[frozenset[str], float] = (frozenset(), 0.0)  # the keys that moved last, and when, s

    @property
    def design(self) -> Design:
        """The design, or the scene's."""
        return self.subject.design if isinstance(self.subject, Scene) else self.subject


def start_session(subject: Editable) -> Session:
    """Return the session that a command begins with; raises InputError for a skin without a section, or with
    shots, whose mold it could not show."""
    session = Session(subject)
    refuse_layers(session.design, "live")
    section(session.design)
    return session


def apply_moves(session: Session, values: Mapping[str, Setting], now: float) -> Session:
    """Return the session after some keys were given values at `now` s of any clock that goes on evenly.

    Values that break a rule wait, beside those that wait already, for others with which they don't.
    """
    wanted = {**session.pending, **values}
    gesture = frozenset(values), now
    try:
        after = changed(session.subject, wanted)
        assert isinstance(after, Design | Scene)
        section(after.design if isinstance(after, Scene) else after)
    except InputError as refusal:
        return replace(session, pending=wanted, refusal=refusal, gesture=gesture)
    settled = replace(session, pending={}, refusal=None, gesture=gesture)
    if after == session.subject:
        return settled
    keys, last = session.gesture
    goes_on = bool(session.past) and len(keys) == 1 and keys == gesture[0] and now - last < GESTURE
    past = session.past if goes_on else (*session.past, session.subject)[-MAX_UNDO_STEPS:]
    return replace(settled, subject=after, past=past, future=())


def undo_step(session: Session) -> Session:
    """Return the session a step back: what waits is dropped first; the same one where there is no step."""
    if session.pending:
        return replace(session, pending={}, refusal=None, gesture=(frozenset(), 0.0))
    if not session.past:
        return session
    *past, before = session.past
    return Session(before, past=tuple(past), future=(*session.future, session.subject))


def redo_step(session: Session) -> Session:
    """Return the session with the last step that was undone; the same one where there is none."""
    if session.pending or not session.future:
        return session
    *future, after = session.future
    return Session(after, past=(*session.past, session.subject), future=tuple(future))


def standing(session: Session, key: str) -> Setting:
    """Return what a key is shown as: what waits, or its value in the subject, None where it has none."""
    if key in session.pending:
        return session.pending[key]
    return value_of(session.subject, key)


def table_for(session: Session, key: str) -> Mapping[str, Setting]:
    """Return the values with which an optional table, as `slot` or `skin.film`, comes back: its last ones, or
    a template's where it never was."""
    name = key.rpartition(".")[2]
    designs = [s.design if isinstance(s, Scene) else s for s in reversed(session.past)]
    for design in (*designs, load_design(TABLES_OF)):
        if (table := getattr(design, name)) is not None:
            values: Mapping[str, Setting] = table.model_dump(exclude_none=True)
            return values
    raise InputError(key, "is no optional table")
