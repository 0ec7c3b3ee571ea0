"""A copy of a design's, scene's or circuit's TOML with some values changed, its comments kept."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import tomlkit

from skincad.base.errors import InputError, RefusedError, shown
from skincad.base.outfolder import fresh
from skincad.base.reading import tables_of, text_of
from skincad.base.tables import Document, NumberWithRange
from skincad.inputs.catalog import LARGEST_FILE, design_tables, kind_of, template_names, template_text
from skincad.inputs.design import Design
from skincad.laws.rubber import Rubber
from skincad.outputs.fits import ranged_toml


def write_copy(path: Path, source: str, wanted: Document, comments: Mapping[str, str]) -> None:
    """Write `wanted` as a copy of the template or file `source`, with only the changed values replaced.

    `comments` are by key, with dots: the comment that its line gets. The file appears whole or not at all.
    Raises InputError for one that is there already or cannot be written.
    """
    document = tomlkit.parse(_text(source))
    try:
        before = type(wanted)(**tables_of(_text(source), source)).model_dump(exclude_none=True)
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
