"""TOML files that people edit: what ships (`templates`), a new one (`new`), and a copy with other values.

A new file is a design, a scene or a circuit after a template, or a table of one's own silicones or processes:
every key with its meaning, unit, range and default, and its JSON schema beside it.
"""

from __future__ import annotations

import json
import os
import re
import tomllib
from collections.abc import Callable, Mapping
from functools import cache, partial
from pathlib import Path
from typing import Any, NamedTuple

import tomlkit
from pydantic import BaseModel, TypeAdapter
from pydantic.fields import FieldInfo

from skincad.base.errors import InputError, RefusedError, did_you_mean, shown
from skincad.base.outfolder import checked_fresh, fresh
from skincad.base.reading import tables_of, text_of
from skincad.base.tables import Document, NumberWithRange, Table, table_of, unit_of
from skincad.fabrication.papers import macro
from skincad.inputs import shipped
from skincad.inputs.catalog import (
    KINDS,
    LARGEST_FILE,
    Kind,
    design_tables,
    kind_of,
    kinds_of,
    load,
    template_names,
    template_text,
)
from skincad.inputs.design import Design
from skincad.inputs.feature_tables import FAMILY_TABLES
from skincad.inputs.film_product import FilmProduct, film_products
from skincad.inputs.gripper import Gripper, grippers
from skincad.inputs.process import Process
from skincad.inputs.shipped import table_text
from skincad.inputs.silicone import SOFTEST, STIFFEST, Silicone, silicones
from skincad.laws.rubber import Rubber
from skincad.outputs import gallery

_LIMITS = {"gt": "above", "ge": "from", "lt": "below", "le": "to"}
_LENGTHS = {"min_length": "from", "max_length": "to"}


class _OwnTable(NamedTuple):
    """Tables of one's own in place of shipped ones."""

    option: str  # of the commands, by which a design takes them
    model: type[Table]  # of a row
    base: str  # the shipped row that shows its keys
    key: str  # of a design, which names a row


_OWN: dict[shipped.Table, _OwnTable] = {
    "silicones": _OwnTable("silicones", Silicone, "dragon-skin-30", "material.name"),
    "processes": _OwnTable("printer", Process, "sla", "mold.process"),
    "grippers": _OwnTable("grippers", Gripper, "franka-hand", "mold.mount"),
}
STUDIES: Kind = "studies"
HOME = "designs/home-printer"  # what a new file starts from: any maker can cast it
FIRST = {"ridge": HOME, "pin": "designs/pillars-9", "ring": "designs/rings-5", "flat": "designs/flat-magnet"}
LISTS = {
    "designs": "design",
    "scenes": "scene",
    "circuits": "circuit",
    "studies": "study",
    "silicones": "silicone",
    "processes": "process",
    "grippers": "gripper",
    "films": "film",
}


def write_new(path: Path, template: str = HOME) -> list[Path]:
    """Write a commented file after a template, and its schema beside it; return both paths.

    `template` is a design's, a scene's or a circuit's name, with its kind before it where two kinds have that
    name; or `silicones`, `processes` or `grippers`, for a table of one's own. Raises InputError for
    an unknown template, a file that is there already or cannot be written, and a name that a TOML comment
    can't hold.
    """
    kind, name = _kind_and_name(template)
    text = "" if kind in _OWN else template_text(name, kind)  # type: ignore[arg-type]  # a Kind where it is none
    family = next((key for key in FAMILY_TABLES if kind == "designs" and key in tomllib.loads(text)), "")
    make = partial(commented_toml, kind, text, path.stem)
    return write_with_schema(path, kind, make, family)


def write_with_schema(
    path: Path, kind: Kind | shipped.Table, text: Callable[[str], str], family: str = ""
) -> list[Path]:
    """Write a TOML file of this kind and its schema beside it; return both paths.

    `text` makes the TOML of the schema's file name; the schema is that of a design's `family` alone where one
    is named. Raises InputError as `write_new`.
    """
    schema, link = check_new(path)
    with fresh(schema, "FILE") as first, fresh(path, "FILE") as second:
        first.write_text(schema_of(kind, family), encoding="utf-8")
        second.write_text(text(link), encoding="utf-8")
        _model_and_loader(kind)[1](second)  # before it takes its place: what we write is of its kind
    return [path, schema]


def first_of(family: str) -> str:
    """Return the template that a new file of a family starts from; raises InputError for an unknown one."""
    if family not in FIRST:
        raise InputError("family", "no such family", family, did_you_mean(family, FIRST))
    return FIRST[family]


def check_new(path: Path) -> tuple[Path, str]:
    """Return where a new file's schema goes, and its name as UTF-8; raises InputError where the two can't be
    written."""
    schema = path.with_suffix(".schema.json")
    for target, suffix in ((path, ".toml"), (schema, ".json")):
        checked_fresh(target, suffix, "FILE")
    try:
        link = os.fsencode(schema.name).decode("utf-8")  # a poor locale leaves what it cannot read escaped
    except UnicodeDecodeError:
        raise InputError("FILE", "must be UTF-8", path.name, "name another file") from None
    if not link.isprintable():
        raise InputError("FILE", "must have a name of printable characters", path.name)
    return schema, link


def _kind_and_name(template: str) -> tuple[Kind | shipped.Table, str]:
    """The kind and the name that a template's name means."""
    for table in shipped.TABLES:
        if template == table:
            return table, ""
    before, _, name = template.rpartition("/")
    kinds = [kind for kind in kinds_of(name) if before in ("", kind)]
    if len(kinds) == 1:
        return kinds[0], name
    if kinds:
        remedy = f"say {' or '.join(f'{kind}/{name}' for kind in kinds)}"
        raise InputError("template", f"is a name of {' and '.join(kinds)}", template, remedy)
    raise InputError("template", "no such template", template, did_you_mean(name, start_names()))


def start_names() -> list[str]:
    """Return what `write_new` takes as its template; the kind comes before a name that two kinds have."""
    names = [(kind, name) for kind in KINDS for name in template_names(kind)]
    return [*shipped.TABLES, *(n if len(kinds_of(n)) == 1 else f"{kind}/{n}" for kind, n in names)]


def _model_and_loader(kind: Kind | shipped.Table) -> tuple[type[Table], Callable[[Path], object]]:
    """The model of a kind's file, or of a row of one's own tables, and what loads the file."""
    if kind == "scenes":
        from skincad.scenes.scene import Scene, load_scene

        return Scene, load_scene
    if kind == "circuits":
        from skincad.circuit.model import Circuit, load_circuit

        return Circuit, load_circuit
    if kind == "designs":
        return Design, load
    if kind == "studies":
        raise InputError("template", "is a study, which new does not write", remedy="copy its TOML")
    own = _OWN[kind]
    return own.model, lambda path: load("yamada-2002", **{own.option: path})


@cache
def schema_of(kind: Kind | shipped.Table, family: str = "") -> str:
    """Return the JSON schema of a kind of file, for an editor that completes and checks TOML; of a design
    with the tables of one family alone where that is named."""
    model = _model_and_loader(kind)[0]
    rows = TypeAdapter(dict[str, model])  # type: ignore[valid-type]
    schema = rows.json_schema() if kind in _OWN else model.model_json_schema()
    if kind == "scenes":
        from skincad.effects import EFFECTS, effect

        tables = {name: effect(name).model_json_schema() for name in EFFECTS}
        for table in tables.values():
            schema["$defs"] |= table.pop("$defs", {})  # where their references look
        effects = {"type": "object", "properties": tables, "additionalProperties": False}
        schema["properties"]["effects"] = effects
    if family:
        for key in not_of(family):
            del schema["properties"][key]
            schema["$defs"].pop(key.capitalize())
        schema["oneOf"] = [{"required": [family]}]
    if ranged := schema.get("$defs", {}).get("NumberWithRange"):  # all of them are moduli
        limits = {"minimum": SOFTEST, "maximum": STIFFEST}
        numbers = {key: {**number, **limits} for key, number in ranged["properties"].items()}
        either = [{"type": "number", **limits}, {**ranged, "properties": numbers}]
        schema["$defs"]["NumberWithRange"] = {"anyOf": either}
    return json.dumps({"$schema": "http://json-schema.org/draft-07/schema#", **schema}, indent=1) + "\n"


def not_of(family: str) -> set[str]:
    """Return the tables of a design that features of this family can't have."""
    alone = {"ridge": {"slot", "film"}, "pin": {"magnetometer"}}
    return {*FAMILY_TABLES} - {family} | {key for other in {*alone} - {family} for key in alone[other]}


def commented_toml(kind: Kind | shipped.Table, text: str, name: str, schema: str) -> str:
    """Return a TOML text with each key's meaning above it; keys left at their default are comments. A
    table of one's own needs no text: a shipped row shows its keys."""
    from skincad.effects import EFFECTS, effect

    facts: dict[str, Any] = {"schema": schema, "EFFECTS": EFFECTS, "effect": effect, "table": _table}
    facts |= {"default": _default, "unit_and_range": _unit_and_range}
    if kind in _OWN:
        own = _OWN[kind]
        row: Any = tomlkit.parse(table_text(kind))[own.base]
        if kind == "processes":
            row["based_on"] = own.base
        else:
            row.pop("source")  # one's own values are from elsewhere
        return macro("papers/new-file.txt", "own", LISTS[kind], kind, *own, row, **facts)
    document: Any = tomlkit.parse(text)
    document["name"] = document_name(name, kind)
    remarks = [line for line in text.splitlines() if line.startswith("#")]
    family = next((key for key in FAMILY_TABLES if key in document), "")
    hidden = not_of(family) if family else set()
    options = {own.option: table for table, own in _OWN.items()}
    values = _model_and_loader(kind)[0], document, remarks, hidden, family, options
    return macro("papers/new-file.txt", "document", *values, **facts)


def document_name(stem: str, kind: str = "designs") -> str:
    """Return the name of the document in a file of this stem."""
    return re.sub(r"[^A-Za-z0-9_-]", "-", stem)[:64].lstrip("-_") or kind[:-1]


def _table(model: type[BaseModel], key: str) -> type[Table] | None:
    """The model of a table behind a key; None for a value, a modulus too."""
    inner = table_of(model, key)
    return None if inner is NumberWithRange else inner


def _default(field: FieldInfo) -> str:
    if field.default is None or field.is_required():
        return "..."
    return str(tomlkit.item(field.default).as_string())


def _unit_and_range(field: FieldInfo) -> str:
    """A key's unit and range, as "mm, from 0.2 to 100"."""
    extra = field.json_schema_extra if isinstance(field.json_schema_extra, dict) else {}
    unit = str(extra.get("unit", ""))
    rules, items = field.metadata, _LENGTHS.items() if "list" in str(field.annotation) else ()
    limits = [f"{w} {getattr(rule, k):.8g}" for rule in rules for k, w in _LIMITS.items() if hasattr(rule, k)]
    lengths = [f"{w} {getattr(rule, k)}" for rule in rules for k, w in items if hasattr(rule, k)]
    values = " ".join([*lengths, "values"]) if lengths else ""
    return ", ".join(part for part in (unit if unit != "1" else "", " ".join(limits), values) if part)


def _written_default(field: FieldInfo) -> str:
    """A key's default as TOML; "" where it is computed or absent."""
    if isinstance(field.default, NumberWithRange):
        return ranged_toml(field.default)
    return _default(field) if isinstance(field.default, bool | int | float | str | list | tuple) else ""


def table_entries(model: type[BaseModel]) -> tuple[list[tuple[str, ...]], dict[str, type[Table]]]:
    """Return the plain keys of a table for a page of reference, as key, unit and range, default ("" for none)
    and meaning; and the tables within by their keys."""
    fields = {key: field for key, field in model.model_fields.items() if key != "effects"}
    inner = {key: table for key in fields if (table := _table(model, key))}
    rows = list[tuple[str, ...]]()
    for key, field in fields.items():
        if key not in inner:
            default = "required" if field.is_required() else _written_default(field)
            rows.append((key, _unit_and_range(field), default, field.description or ""))
    return rows, inner


def listing(kind: str | None) -> tuple[dict[str, Any], list[str]]:
    """Return what ships of a kind, or of all, as plain data and as lines to read.

    The data are the names by kind; of one kind `entries` by name, with `units` of their keys and, of
    processes, the `sources` of their values. Raises InputError for an unknown kind.
    """
    if kind is None:
        return {k: list(_about(k)) for k in LISTS}, [row for k in LISTS for row in _list_rows(k)]
    if kind not in LISTS:
        raise InputError("kind", "no such kind", kind, did_you_mean(kind, LISTS))
    if kind == "designs":
        return {"kind": kind, "entries": gallery.entries()}, _list_rows(kind)
    if kind == "films":
        units = {key: "mm" for key in FilmProduct.model_fields if unit_of(FilmProduct, (key,))}
        entries = {name: row.model_dump(mode="json") for name, row in film_products().items()}
        return {"kind": kind, "entries": entries, "units": units}, _said(kind, film_products()).splitlines()
    own = next((own for table, own in _OWN.items() if table == kind), None)
    if own is None:
        return {"kind": kind, "entries": {k: {"about": v} for k, v in _about(kind).items()}}, _list_rows(kind)
    units = {key: unit for key in own.model.model_fields if (unit := unit_of(own.model, (key,)))}
    data: dict[str, Any] = {}
    known: Any
    if kind == "processes":
        known = dict(tomlkit.parse(table_text("processes")).items())
        entries = {name: dict(table.unwrap()) for name, table in known.items()}
        data["sources"] = {name: {key: _comment(t.item(key)) for key in t} for name, t in known.items()}
        said = _said(kind, known, Process.model_fields, units)
    else:
        known = silicones() if kind == "silicones" else grippers()
        left_out = {"name"} if kind == "silicones" else None
        entries = {name: row.model_dump(mode="json", exclude=left_out) for name, row in known.items()}
        said = _said(kind, known)
    lines = (said + _said("own", kind, own.option)).splitlines()
    return {"kind": kind, "entries": entries, **data, "units": units}, lines


def _said(name: str, *values: Any) -> str:
    """What a macro of the listing makes of these values."""
    return macro("papers/listing.txt", name, *values, LISTS=LISTS, comment=_comment)


def _about(kind: str) -> dict[str, str]:
    """Every name of a kind with its description in one line."""
    for file_kind in (*KINDS, STUDIES):
        if kind == file_kind:
            return {name: gallery.purpose(name, file_kind) for name in template_names(file_kind)}
    if kind == "silicones":
        return {name: f"{_said('modulus', entry)} MPa" for name, entry in silicones().items()}
    if kind == "grippers":
        return {name: _said("mount", gripper) for name, gripper in grippers().items()}
    if kind == "films":
        return {name: _said("film", row) for name, row in film_products().items()}
    return {name: _comment(table) for name, table in tomlkit.parse(table_text("processes")).items()}


def _list_rows(kind: str) -> list[str]:
    said = _said("designs", gallery.entries()) if kind == "designs" else _said("rows", kind, _about(kind))
    return said.splitlines()


def _comment(item: Any) -> str:
    """What a TOML says behind a value or a table's name."""
    return str(item.trivia.comment).lstrip("# ")


def write_copy(path: Path, source: str, wanted: Document, comments: Mapping[str, str]) -> None:
    """Write `wanted` as a copy of the template or file `source`, with only the changed values replaced.

    `comments` are by key, with dots: the comment that its line gets. The file appears whole or not at all.
    Raises InputError for one that is there already or cannot be written.
    """
    document = tomlkit.parse(_source_text(source))
    try:
        before = type(wanted)(**tables_of(_source_text(source), source)).model_dump(exclude_none=True)
    except InputError:  # the source is valid only with the changes
        before = {}
    _follow(document, before, wanted.model_dump(exclude_none=True))
    for key, words in comments.items():
        *tables, last = key.split(".")
        table: Any = document
        for name in tables:
            table = table[name]
        value = tomlkit.item(table[last])
        value.comment(shown(words))
        table[last] = value
    text = tomlkit.dumps(document)
    if type(wanted)(**tomllib.loads(text)) != wanted:
        raise RefusedError(f"the copy of {source} does not hold the wanted values")
    with fresh(path, "copy") as staging:
        staging.write_text(text, encoding="utf-8")


def write_with_modulus(
    path: Path,
    source: str,
    overrides: list[str],
    modulus: NumberWithRange,
    law: Rubber | None,
    provenance: str,
    silicones: Path | None = None,
) -> None:
    """Write the design of a template's name or a file, overrides applied, with this `modulus` and `law`.

    `silicones` is a file of the user's own silicones; they go into the design as in `load_design`. The line's
    comment says `provenance`. Raises InputError as `write_copy` does.
    """
    data = design_tables(source, overrides, silicones=silicones)
    material = {key: value for key, value in data.get("material", {}).items() if key != "law"}
    law_table = {"law": tomllib.loads(tomlkit.dumps(law.model_dump()))} if law else {}
    modulus_value = tomllib.loads(f"modulus = {ranged_toml(modulus)}")["modulus"]
    data["material"] = {**material, "young_modulus": modulus_value, **law_table}
    write_copy(path, source, Design(**data), {"material.young_modulus": provenance})


def ranged_toml(ranged: NumberWithRange) -> str:
    """Return a number with its range as a TOML value."""
    return f"{{ value = {ranged.value}, low = {ranged.low}, high = {ranged.high} }}"


def _source_text(source: str) -> str:
    kind = kind_of(source)
    if source in template_names(kind):
        return template_text(source, kind)
    return text_of(Path(source), source, LARGEST_FILE, "TOML")


def _follow(table: Any, before: Mapping[str, Any], after: Mapping[str, Any]) -> None:
    """Change in a TOML table what differs between two of its meanings, and nothing else."""
    for key in [key for key in table if key not in after]:
        del table[key]
    for key, value in after.items():
        if isinstance(value, dict) and isinstance(table.get(key), dict):
            earlier = before.get(key)
            _follow(table[key], earlier if isinstance(earlier, dict) else {}, value)
        elif key not in before or before[key] != value:
            table[key] = _inline(value)


def _inline(value: Any) -> Any:
    """A value as a file has it: a modulus's range in one line."""
    if isinstance(value, dict) and set(value) == {"value", "low", "high"}:
        table = tomlkit.inline_table()
        table.update(value)
        return table
    return list(value) if isinstance(value, tuple) else value
