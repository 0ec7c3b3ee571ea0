"""What a study varies: a design, a scene or a circuit, seen as one set of keys with dots."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, get_args

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from skincad.base.errors import InputError, did_you_mean
from skincad.base.reading import text_of
from skincad.base.tables import NumberWithRange, no_entry, table_of
from skincad.base.version import __version__
from skincad.circuit.model import Circuit, load_circuit
from skincad.effects import effect
from skincad.inputs.catalog import LARGEST_FILE, Own, kind_of, load_design, overridden
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.scenes.scene import Scene, load_scene

Subject = Design | Scene | Circuit
Value = float | int | str
Setting = Value | Sequence[float] | Mapping[str, Any] | None  # what a key may be changed to
SKIN, CIRCUIT = "skin.", "circuit."  # before the keys of a scene's design, and of its amplifier's circuit
NOT_GIVEN: dict[str, Value] = {"ridge.levelling": 0.0}  # what keys mean that a design need not give


def load_subject(
    source: str | Path,
    settings: list[str] | tuple[str, ...] = (),
    *,
    printer: Own | None = None,
    silicones: Own | None = None,
) -> Subject:
    """Return the design, scene or circuit of a template's name or of a TOML file.

    A name that several kinds have is the design's, then the scene's. Raises InputError as their own loaders
    do.
    """
    kind = kind_of(source)
    if kind == "designs":
        return load_design(source, settings, printer=printer, silicones=silicones)
    if printer is not None:
        raise InputError("printer", "is for a design", str(printer), "leave it out")
    if kind == "scenes":
        return load_scene(source, settings, silicones=silicones)
    if silicones is not None:
        raise InputError("silicones", "are for a design or a scene", str(silicones), "leave them out")
    return load_circuit(source, settings)


def owner(subject: Subject, key: str) -> tuple[Subject, str]:
    """Return whose key it is, and its name there: of a scene, `skin.` stands before its design's keys, and
    `circuit.` before those of its amplifier's circuit.

    Raises InputError for a circuit's key in a scene without one.
    """
    if isinstance(subject, Scene) and key.startswith(SKIN):
        return subject.design, key.removeprefix(SKIN)
    if isinstance(subject, Scene) and key.startswith(CIRCUIT):
        return subject.parts[_behind(subject, key)].circuit, key.removeprefix(CIRCUIT)  # type: ignore[attr-defined]
    return subject, key


def _behind(scene: Scene, key: str) -> str:
    """The name of the effect with the scene's circuit."""
    names = [
        name for name, part in scene.parts.items() if isinstance(getattr(part, "circuit", None), Circuit)
    ]
    if not names:
        raise InputError(key, "needs an amplifier, which this scene has not", remedy="add [effects.piezo]")
    return names[0]


def changed(subject: Subject, values: Mapping[str, Setting]) -> Subject:
    """Return a copy with these keys' values, checked anew; raises InputError for the rules that they break.

    A key is its tables' names and its own, joined by dots; a number at its end counts a list's entries from
    1, as ridges count. In a scene, `skin.` stands before a design's own, `circuit.` before a circuit's. None
    drops a key or an optional table; a mapping is a whole table, a list all its entries.
    """
    if isinstance(subject, Scene):
        return _changed_scene(subject, values)
    tables = _tables(subject)
    if isinstance(subject, Design):
        values = {key: _spread(subject, key, value) for key, value in values.items()}
    return type(subject)(**overridden(tables, _settings(values)))


def _changed_scene(scene: Scene, values: Mapping[str, Setting]) -> Scene:
    """The scene with what is changed of its design and its circuit in the place of their names."""
    inner: dict[str, dict[str, Setting]] = {SKIN: {}, CIRCUIT: {}}
    outer = dict[str, Setting]()
    for key, value in values.items():
        _, inner_key = owner(scene, key)
        before = key.removesuffix(inner_key)
        (inner[before] if before else outer)[inner_key] = value
    parts: dict[str, Any] = {}
    named = {key: value for key, value in outer.items() if key == "skin" or key.endswith(".circuit")}
    # a name that is varied too is the one that the keys within it belong to
    chosen = _changed_scene(scene, named) if named and any(inner.values()) else scene
    for before, own_values in inner.items():
        if own_values:
            try:
                parts[before] = changed(owner(chosen, before)[0], own_values)
            except InputError as failure:
                raise failure.under(before.removesuffix(".")) from None
    tables = overridden({**_tables(scene), "skin": scene.skin}, _settings(outer))
    if SKIN in parts:
        tables["skin"] = parts[SKIN]
    if CIRCUIT in parts:
        name = _behind(scene, CIRCUIT)
        tables["effects"] = {
            **tables["effects"],
            name: {**tables["effects"][name], "circuit": parts[CIRCUIT]},
        }
    return Scene(**tables)


def _tables(subject: Subject) -> dict[str, Any]:
    return subject.model_dump(exclude_none=True, exclude={"skin"} if isinstance(subject, Scene) else None)


def _settings(values: Mapping[str, Any]) -> list[str]:
    """The values as `key=value` with a TOML value."""
    return [f"{key}={'none' if value is None else _toml(value)}" for key, value in values.items()]


def _toml(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {_toml(entry)}" for key, entry in value.items()) + "}"
    return json.dumps(value)


def _at(tables: Any, key: str) -> Any:
    """What stands at a key, whose numbers count a list's entries from 1; None where nothing does."""
    for part in key.split("."):
        if isinstance(tables, list | tuple):
            tables = {str(place): entry for place, entry in enumerate(tables, 1)}
        tables = tables.get(part) if isinstance(tables, Mapping) else None
    return tables


def _spread(design: Design, key: str, value: Setting) -> Any:
    """A modulus with the range that the design's silicone has, as a part of it: what is cast varies still."""
    if key != "material.young_modulus" or not isinstance(value, int | float):
        return value
    known = silicone(design).young_modulus
    ends = {"low": known.low, "high": known.high}
    return {"value": value, **{end: end_value / known.value * value for end, end_value in ends.items()}}


def value_of(subject: Subject, key: str) -> Value | None:
    """Return what a key is now; None where it is not given and has no default."""
    subject, key = owner(subject, key)
    if key == "material.young_modulus" and isinstance(subject, Design):
        return silicone(subject).young_modulus.value
    value = _at(_tables(subject), key)
    return value if isinstance(value, int | float | str) else NOT_GIVEN.get(key)


def field_of(subject: Subject, key: str) -> FieldInfo:
    """Return the field of a key; raises InputError, with the nearest name, for one that there is not."""
    whose, name = owner(subject, key)
    if whose is not subject:
        try:
            return field_of(whose, name)
        except InputError as failure:
            raise failure.under(key.removesuffix(name).removesuffix(".")) from None
    parts = [part for part in key.split(".") if part] or [key]
    model: type[BaseModel] = type(subject)
    field: FieldInfo | None = None
    inner: type[BaseModel] | None = None
    named = False  # whether the next part is a name of one's own, as of a process
    for number, part in enumerate(parts):
        if isinstance(subject, Scene) and number == 1 and parts[0] == "effects":
            model = effect(part)
            continue
        if named:
            named = False
            continue
        if field is not None and part.isdecimal() and number == len(parts) - 1:
            if _at(_tables(subject), key) is None:
                raise no_entry(key, len(_at(_tables(subject), key.rpartition(".")[0]) or ()))
            return field
        if part not in model.model_fields:
            raise InputError(key, "unknown key", remedy=did_you_mean(part, model.model_fields))
        field, inner = model.model_fields[part], table_of(model, part)
        if inner is not None and inner is not NumberWithRange:
            named = "dict[" in str(field.annotation)
            model = inner
    if inner is not None and inner is not NumberWithRange:
        raise InputError(key, "is a table, not a number", remedy=did_you_mean("", inner.model_fields))
    assert field is not None  # a key has one part at least
    return field


def kinds(field: FieldInfo) -> Iterator[Any]:
    """Yield every type, and every choice, in a field's annotation."""
    left = [field.annotation]
    while left:
        kind = left.pop()
        left += get_args(kind)
        yield kind


def fingerprint(subject: Subject) -> str:
    """Return what tells a subject from all that would answer otherwise: a hash of its keys and its files',
    and of skincad's version. Its name is no part of it."""
    data = subject.model_dump(mode="json", exclude_none=True, exclude={"name"})
    if isinstance(subject, Scene):
        data["skin"] = subject.design.model_dump(mode="json", exclude_none=True, exclude={"name"})
    text = json.dumps([__version__, type(subject).__name__, data, sorted(_files(data))], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()


def _files(data: Any) -> Iterator[str]:
    """What stands in the files that a subject names."""
    if isinstance(data, dict | list):
        for entry in data.values() if isinstance(data, dict) else data:
            yield from _files(entry)
    elif isinstance(data, str) and data.endswith(".toml"):
        yield text_of(Path(data), data, LARGEST_FILE, "TOML")
