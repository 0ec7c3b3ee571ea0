"""A copy of a design's TOML with a measured modulus in it, its comments kept."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import tomlkit

from skincad.base.errors import RefusedError, shown
from skincad.base.freshfile import fresh
from skincad.base.reading import text_of
from skincad.base.tables import Ranged
from skincad.inputs.catalog import LARGEST_FILE, design_tables, template_names, template_text
from skincad.inputs.design import Design
from skincad.laws.rubber import Rubber
from skincad.outputs.fits import ranged_toml


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
    comment says `provenance`. The file appears whole or not at all. Raises InputError for one that is there
    already or cannot be written.
    """
    data = design_tables(source, overrides, silicones=silicones)
    kept = {key: value for key, value in data.get("material", {}).items() if key != "law"}
    stiff = {"law": tomllib.loads(tomlkit.dumps(law.model_dump()))} if law else {}
    data["material"] = {**kept, "young_modulus": modulus.model_dump(), **stiff}
    document = tomlkit.parse(_text(source))
    _follow(document, data)
    value = tomlkit.value(ranged_toml(modulus))
    value.comment(shown(provenance))
    table: Any = document["material"]
    table["young_modulus"] = value
    text = tomlkit.dumps(document)
    if Design(**tomllib.loads(text)) != Design(**data):
        raise RefusedError(f"the copy of {source} does not say what the design says")
    with fresh(path, "copy") as staging:
        staging.write_text(text, encoding="utf-8")


def _text(source: str) -> str:
    if source in template_names():
        return template_text(source)
    return text_of(Path(source), source, LARGEST_FILE, "TOML")


def _follow(table: Any, data: dict[str, Any]) -> None:
    """Make a TOML table equal to `data`, touching only what differs."""
    for key in [key for key in table if key not in data]:
        del table[key]
    for key, value in data.items():
        if isinstance(value, dict) and isinstance(table.get(key), dict):
            _follow(table[key], value)
        elif key not in table or table[key] != value:
            table[key] = value
