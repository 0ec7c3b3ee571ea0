"""`skincad templates`: what ships, by kind; silicones and processes with values, ranges and sources."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import tomlkit

from skincad.base.errors import InputError, did_you_mean
from skincad.base.tables import NumberWithRange, Table, unit_of
from skincad.inputs.catalog import KINDS, Kind, template_names, template_text
from skincad.inputs.process import Process
from skincad.inputs.shipped import table_text
from skincad.inputs.silicone import Silicone, silicones

STUDIES: Kind = "studies"
LISTS = {
    "designs": "design",
    "scenes": "scene",
    "circuits": "circuit",
    "studies": "study",
    "silicones": "silicone",
    "processes": "process",
}
_COLUMNS = (  # of the table of silicones: key, head, unit
    ("young_modulus", "modulus", "MPa"),
    ("poisson_ratio", "Poisson", ""),
    ("density", "density", "kg/m3"),
    ("mix", "A:B", ""),
    ("pot_life_min", "pot", "min"),
    ("cure_h", "cure", "h"),
    ("elongation_at_break", "breaks", "at %"),
    ("viscosity", "visc.", "Pa s"),
)


def listing(kind: str | None) -> tuple[dict[str, Any], list[str]]:
    """Return what ships of a kind, or of all, as plain data and as lines to read.

    The data are the names by kind; of one kind `entries` by name, with `units` of their keys and, of
    processes, the `sources` of their values. Raises InputError for an unknown kind.
    """
    if kind is None:
        return {k: list(_about(k)) for k in LISTS}, [row for k in LISTS for row in _rows(k)]
    if kind not in LISTS:
        raise InputError("kind", "no such kind", kind, did_you_mean(kind, LISTS))
    if kind == "silicones":
        return _silicones()
    if kind == "processes":
        return _processes()
    return {"kind": kind, "entries": {name: {"about": text} for name, text in _about(kind).items()}}, _rows(
        kind
    )


def _about(kind: str) -> dict[str, str]:
    """Every name of a kind with its description in one line."""
    for file_kind in (*KINDS, STUDIES):
        if kind == file_kind:
            return {name: _first(template_text(name, file_kind)) for name in template_names(file_kind)}
    if kind == "silicones":
        return {name: f"{_modulus(s.young_modulus)} MPa" for name, s in silicones().items()}
    return {name: _comment(table) for name, table in tomlkit.parse(table_text("processes")).items()}


def _rows(kind: str) -> list[str]:
    return [f"{LISTS[kind]:8} {name:26} {text}" for name, text in _about(kind).items()]


def _first(text: str) -> str:
    return text.splitlines()[0].lstrip("# ")


def _comment(item: Any) -> str:
    """What a TOML says behind a value or a table's name."""
    return str(item.trivia.comment).lstrip("# ")


def _modulus(modulus: NumberWithRange) -> str:
    return f"{modulus.value:g} ({modulus.low:g} to {modulus.high:g})"


def _silicones() -> tuple[dict[str, Any], list[str]]:
    """A row a silicone, its source beneath."""
    known = silicones()
    rows = [("", *(head for _, head, _ in _COLUMNS)), ("", *(unit for *_, unit in _COLUMNS))]
    rows += [(name, *(_cell(entry, key) for key, *_ in _COLUMNS)) for name, entry in known.items()]
    head, units, *lines = _aligned(rows)
    sources = [[f"  {entry.source}", *_sources(entry)] for entry in known.values()]
    cured = {True: "All are platinum-cured.", False: "Not all are platinum-cured: see --json."}
    notes = [
        "",
        "modulus: Young's at small strain, most likely (lowest to highest); pot: its life there; A:B by mass",
        cured[all(entry.platinum_cure for entry in known.values())],
        "Your own: skincad new FILE --template silicones, then --silicones FILE",
    ]
    body = [text for line, more in zip(lines, sources, strict=True) for text in (line, *more)]
    entries = {name: entry.model_dump(mode="json", exclude={"name"}) for name, entry in known.items()}
    return {"kind": "silicones", "entries": entries, "units": _units(Silicone)}, [head, units, *body, *notes]


def _sources(entry: Silicone) -> list[str]:
    """A silicone's stiffness by each source, a line each."""
    lines = []
    for source in entry.sources:
        law = ""
        if source.law:
            constants = source.law.model_dump(mode="json", exclude={"kind"})
            law = f", {source.law.kind}, " + ", ".join(f"{key} {_plain(v)}" for key, v in constants.items())
        lines.append(f"    {source.modulus(entry.poisson_ratio):.3g} MPa: {source.what}; {source.where}{law}")
    return lines


def _plain(value: float | list[float]) -> str:
    return " ".join(f"{number:g}" for number in value) if isinstance(value, list) else f"{value:g}"


def _cell(entry: Silicone, key: str) -> str:
    value = getattr(entry, key)
    if isinstance(value, NumberWithRange):
        return _modulus(value)
    if isinstance(value, list):
        return ":".join(f"{part:g}" for part in value)
    return f"{100 * value:g}" if key == "elongation_at_break" else f"{value:g}"


def _aligned(rows: Sequence[tuple[str, ...]]) -> list[str]:
    """Rows as lines with columns of the same width, the first to the left."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [
        "  ".join([row[0].ljust(widths[0]), *(c.rjust(w) for c, w in zip(row[1:], widths[1:], strict=True))])
        for row in rows
    ]


def _processes() -> tuple[dict[str, Any], list[str]]:
    """A block a key: its meaning, and each process's value with its source."""
    tables: dict[str, Any] = dict(tomlkit.parse(table_text("processes")).items())
    lines, units = [], _units(Process)
    for key, field in Process.model_fields.items():
        values = {name: table.item(key) for name, table in tables.items() if key in table}
        if values:
            unit = f", {units[key]}" if key in units else ""
            lines.append(f"{key}: {field.description}{unit}")
            lines += [f"  {name}  {item.as_string():8} {_comment(item)}" for name, item in values.items()]
    about = [f"{name}: {text}" for name, text in _about("processes").items()]
    note = "Your own: skincad new FILE --template processes, then --printer FILE"
    entries = {name: dict(table.unwrap()) for name, table in tables.items()}
    sources = {name: {key: _comment(table.item(key)) for key in table} for name, table in tables.items()}
    data = {"kind": "processes", "entries": entries, "sources": sources, "units": units}
    return data, [*about, "", *lines, "", note]


def _units(model: type[Table]) -> dict[str, str]:
    return {key: unit for key in model.model_fields if (unit := unit_of(model, (key,)))}
