"""`skincad new`: a design file to edit, every key with its meaning, unit and range, and its JSON schema."""

from __future__ import annotations

import json
import os
import re
from pathlib import Path
from typing import Any

import tomlkit
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from skincad.base.errors import InputError
from skincad.base.freshfile import checked_fresh, fresh
from skincad.base.tables import Ranged, table_of
from skincad.inputs.catalog import load, processes_text, template_text
from skincad.inputs.design import Design
from skincad.inputs.process import Process

_LIMITS = {"Gt": ("above", "gt"), "Ge": ("from", "ge"), "Lt": ("below", "lt"), "Le": ("to", "le")}


def write_new(path: Path, template: str = "yamada-2002") -> list[Path]:
    """Write a commented design after a template, and its schema beside it; return both paths.

    Raises InputError for an unknown template, a file that is there already or cannot be written, and a name
    that a TOML comment can't hold.
    """
    schema = path.with_suffix(".schema.json")
    for target, suffix in ((path, ".toml"), (schema, ".json")):
        checked_fresh(target, suffix, "FILE")
    try:
        link = os.fsencode(schema.name).decode("utf-8")  # a poor locale leaves what it cannot read escaped
    except UnicodeDecodeError:
        raise InputError("FILE", "must be UTF-8", path.name, "name another file") from None
    if not link.isprintable():
        raise InputError("FILE", "must have a name of printable characters", path.name)
    with fresh(schema, "FILE") as first, fresh(path, "FILE") as second:
        first.write_text(design_schema(), encoding="utf-8")
        second.write_text(commented_toml(template, path.stem, link), encoding="utf-8")
        load(second)  # before it takes its place: what we write is a design
    return [path, schema]


def design_schema() -> str:
    """Return the JSON schema of a design, for an editor that completes and checks TOML."""
    schema = Design.model_json_schema()
    ranged = schema["$defs"]["Ranged"]
    schema["$defs"]["Ranged"] = {"anyOf": [{"type": "number"}, ranged]}
    return json.dumps({"$schema": "http://json-schema.org/draft-07/schema#", **schema}, indent=1) + "\n"


def commented_toml(template: str, name: str, schema: str) -> str:
    """Return a template's TOML with each key's meaning above it; keys left at their default are comments."""
    document = tomlkit.parse(template_text(template))
    lines = [f"#:schema ./{schema}", ""]
    lines += [line for line in template_text(template).splitlines() if line.startswith("#")]
    lines += ["", *_key_lines(Design, "name", _safe(name))]
    for table in Design.model_fields:
        model = table_of(Design, table)
        if model is None:
            continue
        if model is Process:
            lines += _printer_lines()
            continue
        given: Any = document.get(table)
        optional = not Design.model_fields[table].is_required()
        absent = "# " if given is None else ""
        note = "  # optional" if optional else ""
        lines += ["", f"{absent}[{table}]{note}"]
        lines += _table_lines(model, given or {})
        for key in model.model_fields:
            inner = table_of(model, key)
            if inner not in (None, Ranged) and key not in (given or {}):
                lines += ["", f"# [{table}.{key}]  # optional", *_table_lines(inner, {})]
    return "\n".join(lines) + "\n"


def _printer_lines() -> list[str]:
    """One own process, all in comments, with the shipped values: a dict of tables has no other default."""
    shipped: Any = tomlkit.parse(processes_text())["sla"]
    lines = [line if line.startswith("#") else f"# {line}" for line in _table_lines(Process, shipped)]
    note = '# your own machine, where it differs from what ships; [printer.my-mill] needs based_on = "cnc"'
    return ["", note, "# [printer.sla]  # optional", *lines]


def _safe(name: str) -> str:
    return re.sub(r"[^A-Za-z0-9_-]", "-", name)[:64].lstrip("-_") or "skin"


def _table_lines(model: type[BaseModel], given: Any) -> list[str]:
    lines = []
    for key, field in model.model_fields.items():
        if table_of(model, key) not in (None, Ranged) and key not in given:
            continue
        if key in given:
            item = given.item(key)
            provenance = item.trivia.comment.lstrip("# ") if item.trivia.comment else ""
            value = item.as_string()
            lines += [*_meaning(field, provenance), f"{key} = {value}"]
        else:
            shown = _default(field)
            lines += [*_meaning(field, ""), f"# {key} = {shown}"]
    return lines


def _key_lines(model: type[BaseModel], key: str, value: str) -> list[str]:
    return [*_meaning(model.model_fields[key], ""), f"{key} = {tomlkit.item(value).as_string()}"]


def _default(field: FieldInfo) -> str:
    if field.default is None or field.is_required():
        return "..."
    return str(tomlkit.item(field.default).as_string())


def _meaning(field: FieldInfo, provenance: str) -> list[str]:
    """Comment lines: meaning, unit and range; then where this template's value is from."""
    extra = field.json_schema_extra if isinstance(field.json_schema_extra, dict) else {}
    unit = str(extra.get("unit", ""))
    limits = " ".join(
        f"{word} {getattr(rule, attribute):.8g}"
        for rule in field.metadata
        for word, attribute in [_LIMITS.get(type(rule).__name__, ("", ""))]
        if word
    )
    stated = ", ".join(part for part in (unit if unit != "1" else "", limits) if part)
    first = f"# {field.description or ''}" + (f" [{stated}]" if stated else "")
    return [first, *([f"#   {provenance}"] if provenance else [])]
