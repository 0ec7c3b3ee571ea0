"""What a person types to get a design or a circuit again: a template's name with what was set, or a file."""

from __future__ import annotations

import json
import shlex
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from skincad.base.errors import InputError
from skincad.base.tables import Document
from skincad.inputs.catalog import Kind, template_names

MOST_SETTINGS = 6  # a line to be read; more of them are a file


def retyped(
    document: Document,
    kind: Kind,
    load: Callable[[str, list[str]], Document],
    file: str | None = None,
) -> str:
    """Return the words after a command that give this document again: its template's name and `--set`
    options, or else `file`, the name that its TOML has.

    `load` makes a document of a name and settings.
    """
    other = file or f"{document.name}.toml"
    if document.name not in template_names(kind):
        return other
    values, shipped = document.model_dump(mode="json", exclude_none=True), load(document.name, [])
    template = shipped.model_dump(mode="json", exclude_none=True)
    settings = list(_differences(values, template))
    if len(settings) > MOST_SETTINGS:
        return other
    try:
        again = load(document.name, settings).model_dump(mode="json", exclude_none=True)
    except InputError:
        return other
    if again != values:
        return other
    return " ".join([document.name, *(f"--set {shlex.quote(setting)}" for setting in settings)])


def _differences(values: Mapping[str, Any], template: Mapping[str, Any], table: str = "") -> Iterator[str]:
    """Yield `key=value` of what differs, `key=none` of what is gone."""
    for key in [*values, *(key for key in template if key not in values)]:
        name = f"{table}{key}"
        one, other = values.get(key), template.get(key)
        if one == other:
            continue
        if isinstance(one, dict) and isinstance(other, dict):
            yield from _differences(one, other, f"{name}.")
        else:
            yield f"{name}={_toml(one)}"


def _toml(value: Any) -> str:
    """A value as TOML in one line."""
    if value is None:
        return "none"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {_toml(entry)}" for key, entry in value.items()) + "}"
    if isinstance(value, str) and value.replace("-", "").isalnum() and not value[:1].isdigit():
        return value
    return json.dumps(value)
