"""The sliders, switches and lists of a page, a folder for each table, kept to what the session says."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import groupby
from typing import TYPE_CHECKING, Any

from skincad.live.controls import Control, controls, with_companions
from skincad.live.session import standing, table_for

if TYPE_CHECKING:
    from skincad.live.desk import Desk

OPEN = ("skin", "ridge", "effects.")  # folders that are open at first, by how their tables begin
NEAR = 0.05  # of a slider's range: an end, at which the range is set again
NOT_GIVEN = "-"  # in a list, of a key that need not be given
WORDS = {"skin": "skin", "contact": "pressing", "contact.plate": "plate that it is pressed on"}


class Panel:
    """The inputs of one GUI, by key; `guarded` wraps what an input calls."""

    def __init__(self, gui: Any, desk: Desk, guarded: Callable[..., Callable[..., None]]) -> None:
        self._gui, self._desk, self._guarded = gui, desk, guarded
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
                self._range(control)
                self._show(control)

    def _build(self, table: str, entries: list[Control], place: int) -> None:
        if table in self._folders:
            self._folders[table].remove()
        name = table.removeprefix("skin.") if table != "skin" else table
        words = WORDS.get(name, name.replace("_", " ").replace("effects.", "effect: "))
        is_open = table.startswith(OPEN) and not (table.startswith("skin.") and table != "skin.ridge")
        folder = self._gui.add_folder(words, order=float(place), expand_by_default=is_open)
        self._folders[table] = folder
        with folder:
            for control in entries:
                if control.kind == "slider":
                    self._add_slider(control)
                elif control.kind == "choice":
                    self._add_choice(control)
                else:
                    self._add_table(control)

    def _add_slider(self, control: Control) -> None:
        key, kind = control.key, int if control.whole else float
        if control.initial is not None:
            switch = self._gui.add_checkbox(control.label, control.value is not None, hint=control.hint)
            switch.on_update(self._guarded(self._on_switch, key, control.initial))
            self._switches[key] = switch
        value = control.value if isinstance(control.value, int | float) else control.initial or 0
        ends = kind(control.low), kind(control.high), kind(control.step), kind(value)
        label = control.label if control.initial is None else ""
        self._inputs[key] = slider = self._gui.add_slider(label, *ends, hint=control.hint)
        slider.on_update(self._guarded(self._on_slider, key))

    def _add_choice(self, control: Control) -> None:
        options = [choice or NOT_GIVEN for choice in control.choices]
        value = str(control.value or NOT_GIVEN)
        self._inputs[control.key] = dropdown = self._gui.add_dropdown(
            control.label, options, initial_value=value, hint=control.hint
        )
        dropdown.on_update(self._guarded(self._on_choice, control.key))

    def _add_table(self, control: Control) -> None:
        box = self._gui.add_checkbox(control.label, bool(control.value), hint=control.hint)
        self._inputs[control.key] = box
        box.on_update(self._guarded(self._on_table, control.key))

    def _on_slider(self, key: str) -> None:
        self._desk.move({key: self._inputs[key].value})

    def _on_switch(self, key: str, initial: float) -> None:
        on = self._switches[key].value
        self._desk.move({key: initial if on else None})

    def _on_choice(self, key: str) -> None:
        value = self._inputs[key].value
        self._desk.move(with_companions(key, None if value == NOT_GIVEN else value))

    def _on_table(self, key: str) -> None:
        on = self._inputs[key].value
        self._desk.move({key: table_for(self._desk.session, key) if on else None})

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

    def _range(self, control: Control) -> None:
        widget, kind = self._inputs[control.key], int if control.whole else float
        ends = kind(control.low), kind(control.high), kind(control.step)
        if (widget.min, widget.max, widget.step) != ends:
            widget.min, widget.max, widget.step = ends
            widget.precision = 0 if control.whole else max(0, round(-math.log10(control.step)))
