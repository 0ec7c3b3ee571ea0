"""What a study varies: keys of a design, a scene or a circuit, their ranges and choices."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, get_args

import numpy as np
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from skincad.base.errors import InputError, did_you_mean
from skincad.base.reading import text_of
from skincad.base.result import key_of
from skincad.base.tables import NumberWithRange, no_entry, table_of, unit_of
from skincad.base.version import __version__
from skincad.circuit.model import Circuit, load_circuit
from skincad.effects import effect
from skincad.inputs.catalog import LARGEST_FILE, Own, kind_of, load_design, overridden
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.inputs.process import processes
from skincad.inputs.silicone import silicones
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
    grippers: Own | None = None,
) -> Subject:
    """Return the design, scene or circuit of a template's name or of a TOML file.

    A name that several kinds have is the design's, then the scene's. Raises InputError as their own loaders
    do.
    """
    kind = kind_of(source)
    if kind == "designs":
        return load_design(source, settings, printer=printer, silicones=silicones, grippers=grippers)
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
        if inner is not None and part.isdecimal():
            table = ".".join(parts[:number])
            rule = f"is a key of [[{table}]], a list of tables, which can't be varied"
            raise InputError(key, rule, remedy="write the number into the file")
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


ALL = "all"
DIGITS = 5  # of a value that is tried: finer than any tolerance, and a design reads well
MOST_VALUES = 10_000  # of one key
WIDE = 3.0  # times its low end, from which on a range is looked at by ratios, not by differences
RangeText = str | Sequence[Any]  # LOW:HIGH, LOW:HIGH:N, all, or A,B,C; or (low, high), (low, high, n), names
FORMS = {"vary": "KEY=LOW:HIGH, or KEY=A,B,C", "rank": "KEY=min or KEY=max"}  # of an option's text
FORM = "write LOW:HIGH, LOW:HIGH:N, all, or A,B,C"


@dataclass(frozen=True)
class DesignVariable:
    """A key, in `unit`: from `low` to `high`, whole numbers only if `whole`; or one of `choices`.

    `count` is how many values of a range a sweep takes, None where it is not told. `start` is its value in
    the design, None where it has none.
    """

    key: str
    unit: str
    start: Value | None
    low: float = math.nan
    high: float = math.nan
    whole: bool = False
    count: int | None = None
    choices: tuple[Value, ...] = ()

    @property
    def range(self) -> list[Value]:
        """Its choices, or both ends."""
        return list(self.choices) or [self.low, self.high]

    @property
    def column(self) -> str:
        """Its key with its unit, the name of a table's column: `skin.length_mm`."""
        return key_of(self.key, self.unit)

    @property
    def by_ratio(self) -> bool:
        """Whether the range is one of ratios."""
        return self.low > 0 and self.high >= WIDE * self.low

    def at(self, share: float) -> Value:
        """Return the value at a share of the range, 0 at `low` and 1 at `high`, or at one of the choices."""
        if self.choices:
            return self.choices[min(int(share * len(self.choices)), len(self.choices) - 1)]
        if self.whole:
            wide = int(self.high) - int(self.low) + 1
            return int(self.low) + min(int(share * wide), wide - 1)
        if share in (0.0, 1.0):
            return self.high if share else self.low
        if self.by_ratio:
            return float(f"{self.low * (self.high / self.low) ** share:.{DIGITS}g}")
        return float(f"{self.low + share * (self.high - self.low):.{DIGITS}g}")

    def share(self, value: Value | None) -> float:
        """Return at which share of the range a value lies, or the nearest end: of choices and whole numbers
        the middle of its step. Without a value the middle of the range."""
        steps = list(self.values()) if self.choices or self.whole else []
        if value in steps:
            return (steps.index(value) + 0.5) / len(steps)
        if steps or not isinstance(value, int | float):
            return 0.5
        value = min(max(float(value), self.low), self.high)
        if self.by_ratio:
            return math.log(value / self.low) / math.log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)

    def values(self) -> tuple[Value, ...]:
        """Return the values that a grid takes: all choices, or `count` of the range, its ends among them."""
        if self.choices:
            return self.choices
        if self.whole and (self.count is None or self.count > self.high - self.low):
            return tuple(range(int(self.low), int(self.high) + 1))
        if self.count is None:
            raise InputError(self.key, "needs a number of values", remedy=f"write {self}:10")
        steps = np.linspace(0.0, 1.0, self.count)
        if self.whole:
            return tuple(sorted({round(self.low + s * (self.high - self.low)) for s in steps}))
        # even steps, as a person would write them: ratios only look finer
        return tuple(float(f"{self.low + s * (self.high - self.low):.12g}") for s in steps)

    def __str__(self) -> str:
        if self.choices:
            return f"{self.key}={','.join(map(str, self.choices))}"
        return f"{self.key}={self.low:g}:{self.high:g}"


def knob(subject: Subject, key: str, choices_told: RangeText) -> DesignVariable:
    """Return the knob of a key of a design, scene or circuit.

    `choices_told` is a text as on the command line, or (low, high), (low, high, count), or a list of choices.
    Raises InputError for an unknown key, for one that holds no number or name, and for an empty range.
    """
    field = field_of(subject, key)
    types = {float if kind is NumberWithRange else kind for kind in kinds(field) if isinstance(kind, type)}
    whose, name = owner(subject, key)
    unit = unit_of(type(whose), tuple(name.split(".")))
    variable = partial(DesignVariable, key, unit, value_of(subject, key))
    parts = _parts(key, choices_told)
    if parts == [ALL]:
        return variable(choices=_catalogue(subject, key, field))
    numbers = [_number(part) for part in parts]
    if isinstance(choices_told, str):
        ranged = ":" in choices_told
    else:  # a tuple of numbers is (low, high) or (low, high, count)
        named = any(isinstance(part, str) for part in parts)
        ranged = isinstance(choices_told, tuple) and len(parts) in (2, 3) and not named
    if not ranged:
        if not parts:
            raise InputError(key, "needs values", remedy=FORM)
        if {int, float} & types and str not in types and None in numbers:
            raise InputError(key, "must be numbers", str(choices_told), FORM)
        known = _catalogue(subject, key, field, must=False)
        for part in parts:
            if known and part not in known:
                raise InputError(key, "unknown choice", part, did_you_mean(str(part), map(str, known)))
        values = [
            part if n is None or known else int(n) if float not in types and n.is_integer() else n
            for part, n in zip(parts, numbers, strict=True)
        ]
        return variable(choices=tuple(dict.fromkeys(values)))
    if len(parts) not in (2, 3) or any(n is None or not math.isfinite(n) for n in numbers):
        raise InputError(key, "must be a range of numbers", str(choices_told), FORM)
    if not {int, float} & types:
        raise InputError(key, "holds no number", str(choices_told), f"write {ALL}, or A,B,C")
    low, high = float(numbers[0] or 0.0), float(numbers[1] or 0.0)
    whole = float not in types
    if not low < high:
        raise InputError(key, "is an empty range: its low end must lie below its high end", str(choices_told))
    if whole and not (low.is_integer() and high.is_integer()):
        raise InputError(key, "must be a range of whole numbers", str(choices_told))
    count = _count(key, numbers[2]) if len(parts) == 3 else None
    return variable(low=low, high=high, whole=whole, count=count)


def knobs(subject: Subject, vary: Mapping[str, RangeText]) -> tuple[DesignVariable, ...]:
    """Return the knobs of several keys; raises InputError for none."""
    if not vary:
        raise InputError("vary", "names no key", remedy="as in ridge.height=0.4:1.3")
    return tuple(knob(subject, key, values) for key, values in vary.items())


def values_at(knobs: Sequence[DesignVariable], place: Iterable[float]) -> dict[str, Value]:
    """Return the values by key at a place of the unit cube."""
    return {knob.key: knob.at(float(share)) for knob, share in zip(knobs, place, strict=True)}


def _parts(key: str, values: RangeText) -> list[Any]:
    if not isinstance(values, str):
        return list(values)
    text = values.strip()
    parts = [part.strip() for part in text.split(":" if ":" in text else ",")]
    if not all(parts):
        raise InputError(key, "has an empty place", values, FORM)
    return list(parts)


def _number(part: Any) -> float | None:
    try:
        return None if isinstance(part, bool) else float(part)
    except (TypeError, ValueError):
        return None


def _count(key: str, number: float | None) -> int:
    if number is None or not number.is_integer() or not 2 <= number <= MOST_VALUES:
        raise InputError(key, f"must have from 2 to {MOST_VALUES} values", number, "as in LOW:HIGH:10")
    return int(number)


def _catalogue(subject: Subject, key: str, field: Any, *, must: bool = True) -> tuple[Value, ...]:
    """All that a key may be, where it is one of names; raises InputError where it is none and `must` be."""
    design, name = owner(subject, key)
    if name == "material.name":
        return tuple(sorted(silicones(getattr(design, "silicones", None))))
    if name in ("mold.process", "mold.end_plate_process", "mold.lid_process"):
        return tuple(sorted(processes(getattr(design, "printer", None))))
    named = [kind for kind in kinds(field) if isinstance(kind, str)]  # of a Literal
    if must and not named:
        raise InputError(key, "has no list of names to take all of", ALL, "write LOW:HIGH, or A,B,C")
    return tuple(named)


def texts(settings: Sequence[str], option: str) -> dict[str, str]:
    """Return `KEY=TEXT` options by their keys; raises InputError for another form and a key given twice."""
    values: dict[str, str] = {}
    for text in settings:
        key, equals, value = (part.strip() for part in text.partition("="))
        if not key or not equals or not value:
            raise InputError(option, f"must be {FORMS.get(option, 'KEY=VALUE')}", text)
        if key in values:
            raise InputError(option, f"names {key} twice", text)
        values[key] = value
    return values


def nearest_silicone(subject: Subject, key: str, value: Value) -> str | None:
    """Return the silicone of the catalogue whose modulus is nearest, by ratio, to one of this value."""
    design, inner_name = owner(subject, key)
    if inner_name != "material.young_modulus" or isinstance(value, str):
        return None
    known = silicones(getattr(design, "silicones", None))
    return min(known, key=lambda name: abs(math.log(known[name].young_modulus.value / value)))
