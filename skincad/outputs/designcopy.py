"""A copy of a design's, scene's or circuit's TOML with some values changed, its comments kept."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import tomlkit

from skincad.base.errors import InputError, RefusedError, shown
from skincad.base.freshfile import fresh
from skincad.base.reading import tables_of, text_of
from skincad.base.tables import Document, Ranged
from skincad.inputs.catalog import LARGEST_FILE, design_tables, kind_of, template_names, template_text
from skincad.inputs.design import Design
from skincad.laws.rubber import Rubber
from skincad.outputs.fits import ranged_toml


def write_copy(path: Path, source: str, wanted: Document, said: Mapping[str, str]) -> None:
    """Write `wanted`, which a template's name or a file was changed to, as that file with what differs.

    `said` is by key, with dots, the comment that its line gets. The file appears whole or not at all. Raises
    InputError for one that is there already or cannot be written.
    """
    document = tomlkit.parse(_text(source))
    try:
        before = type(wanted)(**tables_of(_text(source), source)).model_dump(exclude_none=True)
    except InputError:  # it needs the changes to be one at all
        before = {}
    _follow(document, before, wanted.model_dump(exclude_none=True))
    for key, words in said.items():
        *tables, last = key.split(".")
        table: Any = document
        for name in tables:
            table = table[name]
        value = tomlkit.item(table[last])
        value.comment(shown(words))
        table[last] = value
    text = tomlkit.dumps(document)
    if type(wanted)(**tomllib.loads(text)) != wanted:
        raise RefusedError(f"the copy of {source} does not say what was found")
    with fresh(path, "copy") as staging:
        staging.write_text(text, encoding="utf-8")


def write_with_modulus(
    path: Path,
    source: str,
    overrides: list[str],
    modulus: Ranged,
    law: Rubber | None,
    provenance: str,
    silicones: Path | None = None,
) -> None:
    """Write the design of a template's name or a file, overrides applied, with this `modulus` and `law`.

    `silicones` is a file of own ones, which go into the design as `load_design` puts them there. The line's
    comment says `provenance`. Raises InputError as `write_copy` does.
    """
    data = design_tables(source, overrides, silicones=silicones)
    kept = {key: value for key, value in data.get("material", {}).items() if key != "law"}
    stiff = {"law": tomllib.loads(tomlkit.dumps(law.model_dump()))} if law else {}
    told = tomllib.loads(f"told = {ranged_toml(modulus)}")["told"]
    data["material"] = {**kept, "young_modulus": told, **stiff}
    write_copy(path, source, Design(**data), {"material.young_modulus": provenance})


def _text(source: str) -> str:
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
