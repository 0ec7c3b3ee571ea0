"""The sliders of a page, and the panel that holds them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from itertools import groupby
from typing import TYPE_CHECKING, Any, Literal, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from skincad.base.errors import InputError
from skincad.base.tables import NumberWithRange, table_of, unit_of
from skincad.circuit.model import Circuit
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.live.session import Editable, standing, table_for
from skincad.scenes.scene import Scene
from skincad.studies.subject import ALL, CIRCUIT, SKIN, Setting, Value, kinds, knob, value_of

if TYPE_CHECKING:
    from skincad.live.desk import Desk


# no numbers or choices that a slider could mean: names, and tables that are files of their own
LEFT_OUT = {"name", "printer", "silicones", "grippers", "kind", "effects", "steps", "frames", "ridges"}
SWITCHED_TABLES = {"slot", "film"}  # optional tables that one switch turns on and off
ALWAYS = {"ridge.height", "material.young_modulus"}  # optional only beside another that says the same
REACH = 4.0  # times its value, up and down, that a slider reaches where the key's own range is wider
ZERO_REACH = 1.0  # in the key's unit: how far a slider of 0 reaches
MIN_STEPS = 400  # steps of a slider, at least
MAX_WHOLE_RANGE = 200.0  # a range that is no wider, of an angle or a plain number, is a slider's as it is
# what a plate of another shape needs, and with which value it begins
PLATES: dict[str, tuple[str, float]] = {
    "tilted": ("tilt", 1.0),
    "cylinder": ("radius", 100.0),
    "step": ("height", 0.1),
}
PLATE, HISTORY = "contact.plate.", "history"


@dataclass(frozen=True)
class Control:
    """A key that can be moved, in the `table` of its key, with its unit in the label.

    `value` is None where the key is not given; `initial` is its first value then, and None where it
    must be given. A slider goes from `low` to `high` in steps of `step`; a choice has `choices`, and "" for
    not given; a table is on or off.
    """

    key: str
    table: str
    label: str
    hint: str
    kind: Literal["slider", "choice", "table"]
    value: Setting
    initial: Value | None = None
    low: float = math.nan
    high: float = math.nan
    step: float = math.nan
    whole: bool = False
    choices: tuple[str, ...] = ()


def controls(subject: Editable) -> tuple[Control, ...]:
    """Return all controls of a design or scene, in the order of its tables."""
    if isinstance(subject, Design):
        return tuple(_of_model(subject, subject, ""))
    rows = [*_of_model(subject, subject, ""), *_of_model(subject, subject.design, SKIN)]
    for name, part in subject.parts.items():
        rows += _of_model(subject, part, f"effects.{name}.")
        circuit = getattr(part, "circuit", None)
        if isinstance(circuit, Circuit):
            rows += _of_model(subject, circuit, CIRCUIT)
    return tuple(rows)


def with_companions(key: str, value: Setting) -> dict[str, Setting]:
    """Return a choice with what must change beside it: a plate's shape has one size of its own."""
    table = key.removesuffix("shape")
    if not key.endswith(f"{PLATE}shape"):
        return {key: value}
    needs = PLATES.get(str(value))
    dropped: dict[str, Setting] = {f"{table}{size}": None for size, _ in PLATES.values()}
    return {key: value, **dropped, **({f"{table}{needs[0]}": needs[1]} if needs else {})}


def _of_model(subject: Editable, model: BaseModel, before: str) -> Iterator[Control]:
    for name, field in type(model).model_fields.items():
        key, value = f"{before}{name}", getattr(model, name)
        if name in LEFT_OUT or (isinstance(model, Scene) and name == "skin"):
            continue
        if (
            name in SWITCHED_TABLES
            and (value is None or isinstance(value, BaseModel))
            and before in ("", SKIN)
        ):
            inner = table_of(type(model), name)
            hint = (inner.__doc__ if inner else "") or ""
            yield Control(key, key, f"with {name}", hint.partition("\n")[0], "table", value is not None)
        if isinstance(value, BaseModel) and not isinstance(value, NumberWithRange):
            yield from _of_model(subject, value, f"{key}.")
        elif isinstance(value, list | tuple):
            yield from _of_list(type(model), field, key, value)
        elif not {list, tuple} & {get_origin(kind) for kind in kinds(field)}:
            yield from _of_value(subject, model, field, key)


def _of_list(model: type[BaseModel], field: FieldInfo, key: str, values: Any) -> Iterator[Control]:
    """A slider for each entry, all as wide as the largest one needs; a history's first entries are 0."""
    table, _, name = key.rpartition(".")
    numbers = [entry for entry in values if isinstance(entry, int | float)]
    if not numbers:
        return
    unit, largest = unit_of(model, (name,)), max(map(abs, numbers)) or ZERO_REACH
    ends = 0.0 if min(numbers) >= 0 else -2 * largest, 2 * largest
    for place, value in enumerate(numbers, 1):
        if place > 1 or table != HISTORY:
            label, own = _label(f"{name.removesuffix(f'_{unit}')} {place}", unit), f"{key}.{place}"
            hint = f"{own}: {field.description}"
            yield Control(own, table, label, hint, "slider", value, None, *ends, _step(*ends))


def _of_value(subject: Editable, model: BaseModel, field: FieldInfo, key: str) -> Iterator[Control]:
    table, _, name = key.rpartition(".")
    value, hint = getattr(model, name), f"{key}: {field.description}"
    drops = not field.is_required() and field.default is None
    if names := _names(subject, field, key):
        choices = ("",) * drops + names
        yield Control(key, table, _label(name, ""), hint, "choice", value or "", choices=choices)
        return
    if not {int, float, NumberWithRange} & {*kinds(field)}:
        return
    if value is None and f"{table}.".endswith(PLATE):
        return  # the size of another shape
    low, high = limits(NumberWithRange.model_fields["value"] if NumberWithRange in kinds(field) else field)
    unit, whole = unit_of(type(model), (name,)), not {float, NumberWithRange} & {*kinds(field)}
    value = value.value if isinstance(value, NumberWithRange) else value
    shown = value_of(subject, key) if value is None else value
    known = (value is None and shown is not None) or key.removeprefix(SKIN) in ALWAYS
    initial = _initial(subject, key, low, high) if drops and not known else None
    start = shown if isinstance(shown, int | float) else initial or 0.0
    ends, step = reach(start, low, high, unit), 1.0
    if whole:
        ends = float(math.floor(ends[0])), float(math.ceil(ends[1]))
    else:
        step = _step(*ends)
    limited = [words for end, words in ((low, f"from {low:g}"), (high, f"to {high:g}")) if math.isfinite(end)]
    hint = f"{hint} ({' '.join(limited)})" if limited else hint
    yield Control(key, table, _label(name, unit), hint, "slider", shown, initial, *ends, step, whole)


def _names(subject: Editable, field: FieldInfo, key: str) -> tuple[str, ...]:
    """All that a key may be, where it is one of names, as the model has them in order; none for a number."""
    every = [*kinds(field)]
    if named := [entry for entry in every if isinstance(entry, str)]:
        return tuple(reversed(named))
    if str in every:
        with suppress(InputError):
            return tuple(str(entry) for entry in knob(subject, key, ALL).choices)
    return ()


def _initial(subject: Editable, key: str, low: float, high: float) -> float:
    """What a key that is not given begins with: the silicone's own, or the middle of its range."""
    design = subject.design if isinstance(subject, Scene) else subject
    table, _, name = key.removeprefix(SKIN).rpartition(".")
    if table == "material" and name in ("poisson_ratio", "density"):
        return float(getattr(silicone(design), name))
    if low < 0 < high:
        return 0.0
    if not math.isfinite(high):
        return low or ZERO_REACH
    return _rounded(math.sqrt((low or 1e-3 * high) * high))


def limits(field: FieldInfo) -> tuple[float, float]:
    """Return the least and the largest value of a number's field, infinite where it has none."""
    ends = {"ge": -math.inf, "gt": -math.inf, "le": math.inf, "lt": math.inf}
    for rule in field.metadata:
        ends |= {name: getattr(rule, name) for name in ends if getattr(rule, name, None) is not None}
    return max(ends["ge"], ends["gt"]), min(ends["le"], ends["lt"])


def reach(value: float, low: float, high: float, unit: str) -> tuple[float, float]:
    """Return from where to where a slider goes: the key's whole range where that is narrow, else `REACH`
    times the value, so that a slider of 0.5 mm is not one of 0 to 50 mm. It holds the value."""
    if high - low <= MAX_WHOLE_RANGE and unit in ("", "deg"):
        return low, high
    far = REACH * abs(value) or ZERO_REACH
    if low >= 0:
        return low if low * REACH <= value else _rounded(value / REACH), _rounded(min(high, far))
    return max(low, _rounded(value - far)), min(high, _rounded(value + far))


def _rounded(value: float) -> float:
    return float(f"{value:.3g}")


def _step(low: float, high: float) -> float:
    """The largest power of ten of which `MIN_STEPS` lie in the range."""
    return float(10.0 ** math.floor(math.log10((high - low) / MIN_STEPS))) if high > low else 1.0


def _label(name: str, unit: str) -> str:
    return name.replace("_", " ") + (f", {unit}" if unit else "")


OPEN = ("history", "skin", "ridge", "effects.")  # folders that are open at first, by how their tables begin
NEAR = 0.05  # of a slider's range: an end, at which the range is set again
NOT_GIVEN = "-"  # in a list, of a key that need not be given
WORDS = {"skin": "skin", "contact": "pressing", "contact.plate": "plate that it is pressed on"}


class Panel:
    """The inputs in a tab of a GUI, by key; `guarded` wraps what an input calls."""

    def __init__(self, gui: Any, tab: Any, desk: Desk, guarded: Callable[..., Callable[..., None]]) -> None:
        self._gui, self._tab, self._desk, self._guarded = gui, tab, desk, guarded
        self._folders: dict[str, Any] = {}
        self._shapes: dict[str, tuple[Any, ...]] = {}
        self._inputs: dict[str, Any] = {}
        self._switches: dict[str, Any] = {}

    def refresh(self) -> None:
        """Show the session's values; folders whose keys changed are rebuilt."""
        by_table = groupby(controls(self._desk.session.subject), lambda control: control.table)
        tables = {table: list(entries) for table, entries in by_table}
        for table in [table for table in self._folders if table not in tables]:
            self._folders.pop(table).remove()
            self._shapes.pop(table)
        for place, (table, entries) in enumerate(tables.items()):
            shape = tuple((control.key, control.kind, control.choices) for control in entries)
            if self._shapes.get(table) != shape:
                self._build(table, entries, place)
                self._shapes[table] = shape
            for control in entries:
                self._show(control)

    def widen(self) -> None:
        """Lay the range of each slider that was moved near its end round its value again."""
        for control in controls(self._desk.session.subject):
            if control.kind != "slider" or not isinstance(control.value, int | float):
                continue
            widget = self._inputs[control.key]
            share = (control.value - widget.min) / (widget.max - widget.min)
            if not NEAR < share < 1 - NEAR:
                kind = int if control.whole else float
                ends = kind(control.low), kind(control.high), kind(control.step)
                if (widget.min, widget.max, widget.step) != ends:
                    widget.min, widget.max, widget.step = ends
                    widget.precision = 0 if control.whole else max(0, round(-math.log10(control.step)))
                self._show(control)

    def _build(self, table: str, entries: list[Control], place: int) -> None:
        if table in self._folders:
            self._folders[table].remove()
        name = table.removeprefix("skin.") if table != "skin" else table
        words = WORDS.get(name, name.replace("_", " ").replace("effects.", "effect: "))
        is_open = table.startswith(OPEN) and not (table.startswith("skin.") and table != "skin.ridge")
        with self._tab:
            folder = self._gui.add_folder(words, order=float(place), expand_by_default=is_open)
        self._folders[table] = folder
        with folder:
            for control in entries:
                self._add(control)

    def _add(self, control: Control) -> None:
        """Add a control's input; moved, it gives its key another value."""
        key, hint, gui, desk = control.key, control.hint, self._gui, self._desk
        if control.kind == "table":
            widget = gui.add_checkbox(control.label, bool(control.value), hint=hint)
        elif control.kind == "choice":
            options, value = [choice or NOT_GIVEN for choice in control.choices], control.value or NOT_GIVEN
            widget = gui.add_dropdown(control.label, options, initial_value=str(value), hint=hint)
        else:
            kind = int if control.whole else float
            if control.initial is not None:
                switch = gui.add_checkbox(control.label, control.value is not None, hint=hint)
                self._switches[key] = switch
                switch.on_update(
                    self._guarded(lambda: desk.move({key: control.initial if switch.value else None}))
                )
            value = control.value if isinstance(control.value, int | float) else control.initial or 0
            ends = kind(control.low), kind(control.high), kind(control.step), kind(value)
            widget = gui.add_slider(control.label if control.initial is None else "", *ends, hint=hint)

        def moved() -> None:
            wanted = {key: widget.value}
            if control.kind == "table":
                wanted = {key: table_for(desk.session, key) if widget.value else None}
            elif control.kind == "choice":
                wanted = with_companions(key, None if widget.value == NOT_GIVEN else widget.value)
            desk.move(wanted)

        self._inputs[key] = widget
        widget.on_update(self._guarded(moved))

    def _show(self, control: Control) -> None:
        """Bring an input to what the session has, what waits included."""
        widget, value = self._inputs[control.key], standing(self._desk.session, control.key)
        if control.key not in self._desk.session.pending:
            value = control.value
        if control.kind == "table":
            widget.value = bool(value)
        elif control.kind == "choice":
            widget.value = str(value or NOT_GIVEN)
        else:
            if (switch := self._switches.get(control.key)) is not None:
                switch.value, widget.visible = value is not None, value is not None
            if isinstance(value, int | float) and not isinstance(value, bool):
                if not widget.min <= value <= widget.max:
                    widget.min, widget.max = min(widget.min, value), max(widget.max, value)
                widget.value = value
