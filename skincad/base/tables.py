"""Tables that a person writes: strict frozen models, and their errors as one line.

A model's broken rule leaves as InputError with the key's dotted name, never as a library's own error.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterator
from typing import Any, Self, get_args

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    SerializerFunctionWrapHandler,
    ValidationError,
    model_serializer,
    model_validator,
)
from pydantic_core import ErrorDetails

from skincad.base.errors import MOST_TOLD, InputError, did_you_mean, together


def quantity(unit: str, meaning: str, **limits: Any) -> Any:
    """Describe a field of numbers: its unit and meaning go into the schema and the commented TOML."""
    return Field(description=meaning, json_schema_extra={"unit": unit}, **limits)


class Table(BaseModel):
    """A TOML table: frozen, no unknown keys, no silent conversion of types.

    Raises InputError for the rules that its keys break.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)

    def __init__(self, /, **keys: Any) -> None:
        try:
            super().__init__(**keys)
        except ValidationError as failure:
            raise told(type(self), failure) from None

    __init__.__pydantic_base_init__ = True  # type: ignore[attr-defined]  # as inner ones are

    def __setattr__(self, key: str, value: object) -> None:
        raise InputError(key, "is frozen", value, "make a changed copy by with_(...)")


class SparseTable(Table):
    """A table that dumps what was given only: a change to a shipped one changes no more than it names."""

    @model_serializer(mode="wrap")
    def _dump_set_keys(self, handler: SerializerFunctionWrapHandler) -> dict[str, object]:
        return {key: value for key, value in handler(self).items() if key in self.model_fields_set}


class Document(Table):
    """The tables of a TOML file, with its name."""

    name: str = Field(
        pattern=r"^[A-Za-z0-9][A-Za-z0-9_-]{0,63}$",
        description="letters, digits, - and _, up to 64; it names the output folder",
    )

    def with_(self, **changes: Any) -> Self:
        """Return a copy with some keys changed, checked again.

        `design.with_(ridge={"height": 0.6}, slot=None)`: a dict changes the keys that it names in a table,
        None drops a key or an optional table, with all that cannot be without it.
        """
        data = self.model_dump(exclude_none=True)
        for key, change in changes.items():
            before = data.pop(key, None)
            if isinstance(change, dict):
                merged = {**(before if isinstance(before, dict) else {}), **change}
                data[key] = {inner: value for inner, value in merged.items() if value is not None}
            elif change is not None:
                data[key] = change
            self._follow(data, key, change)
        return type(self)(**data)

    @staticmethod
    def _follow(data: dict[str, Any], key: str, change: Any) -> None:
        """Change, in place, what a changed key takes with it."""

    def to_toml(self) -> str:
        """Return the TOML text that this is loaded from, with defaults but without keys that are None."""
        import tomlkit

        return tomlkit.dumps(self.model_dump(exclude_none=True))

    @property
    def revision(self) -> str:
        """Eight hexadecimal digits that tell these values from others: the first of the TOML's SHA-256."""
        return hashlib.sha256(self.to_toml().encode()).hexdigest()[:8]


class NumberWithRange(Table):
    """A number, alone or as `{value, low, high}`: what was measured and how far it may be off."""

    value: float = Field(description="most likely", gt=0.0)
    low: float = Field(description="smallest", gt=0.0)
    high: float = Field(description="largest", gt=0.0)

    @model_validator(mode="before")
    @classmethod
    def _plain_number(cls, data: Any) -> Any:
        if isinstance(data, int | float) and not isinstance(data, bool):
            return {"value": data, "low": data, "high": data}
        return data

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if not 0 < self.low <= self.value <= self.high:
            raise InputError("", "needs 0 < low <= value <= high", (self.low, self.value, self.high))
        return self


def told(model: type[BaseModel], failure: ValidationError, at: str = "") -> InputError:
    """Return what broke the rules of a model: of the table `at`, or else of a file or a table by itself."""
    errors = [_error(model, error) for error in _telling(failure.errors())[:MOST_TOLD]]
    return together([e.under(at) if at or e.key else e.under(model.__name__.lower()) for e in errors])


def table_of(model: type[BaseModel], key: str) -> type[Table] | None:
    """Return the table model behind a key of `model`, or None where a file has a plain value there."""
    field = model.model_fields.get(key)
    if field is None or str in get_args(field.annotation):
        return None
    return next((k for k in _kinds(field.annotation) if isinstance(k, type) and issubclass(k, Table)), None)


def _kinds(annotation: Any) -> Iterator[Any]:
    """Every type in an annotation, as deep as `dict[str, Table] | None` has it."""
    yield annotation
    for inner in getattr(annotation, "__args__", ()):
        yield from _kinds(inner)


def no_entry(key: str, entries: int = 0, *, of_tables: bool = False) -> InputError:
    """Return the error of a key whose last part is no entry, from 1, of its list of so many."""
    if entries:
        return InputError(key, f"must name one of the list's {entries} entries, from 1 to {entries}")
    whole = key.rpartition(".")[0]
    if of_tables:
        return InputError(key, f"there is no [[{whole}]] yet", remedy=f"add a [[{whole}]] table to the file")
    return InputError(
        key, f"there is no list {whole} yet", remedy=f"give the whole list first: {whole}=[...]"
    )


def unit_of(model: type[BaseModel], path: tuple[str, ...]) -> str:
    """Return the unit of the field at this path, or "" where it has none."""
    field = _holder(model, path).model_fields.get(path[-1]) if path else None
    extra = field.json_schema_extra if field else None
    unit = extra.get("unit") if isinstance(extra, dict) else None
    return str(unit) if unit and unit != "1" else ""


def _holder(model: type[BaseModel], path: tuple[str, ...]) -> type[BaseModel]:
    """The table model that has the last key of a path, which begins at `model`."""
    for key in path[:-1]:
        model = table_of(model, key) or model  # a name of [printer] is no field
    return model


def _telling(errors: list[ErrorDetails]) -> list[ErrorDetails]:
    """The errors in the order of their report: unknown keys first, and no key as missing in a table
    with an unknown one, as which it is most often misspelt; no list as short for its faulty items."""
    unknown = [e for e in errors if e["type"] == "extra_forbidden"]
    tables = {e["loc"][:-1] for e in unknown}
    faulty = {(e["loc"][:depth], "too_short") for e in errors for depth in range(len(e["loc"]))}
    rest = [e for e in errors if e["type"] != "extra_forbidden" and (e["loc"], e["type"]) not in faulty]
    return unknown + [e for e in rest if e["type"] != "missing" or e["loc"][:-1] not in tables]


def _error(model: type[BaseModel], error: ErrorDetails) -> InputError:
    path = tuple(str(p) for p in error["loc"])
    key = ".".join(path)
    cause = error.get("ctx", {}).get("error")
    if isinstance(cause, InputError):
        return cause.under(key)
    if error["type"] == "extra_forbidden":
        return InputError(
            key, "unknown key", remedy=did_you_mean(path[-1], _holder(model, path).model_fields)
        )
    if error["type"] == "missing":
        return InputError(key, "is missing", remedy=f"give {key} a value")
    return _wrong_value(model, path, error)


def _wrong_value(model: type[BaseModel], path: tuple[str, ...], error: ErrorDetails) -> InputError:
    key, value = ".".join(path), error.get("input")
    if isinstance(value, dict):
        entry = next(iter(value), "")
        if error["type"] in ("list_type", "tuple_type") and str(entry).isdecimal():
            return no_entry(f"{key}.{entry}", of_tables=table_of(model, path[-1]) is not None)
        value = "a table"
    if error["type"] == "string_pattern_mismatch":
        return InputError(key, f"must be {model.model_fields[path[-1]].description}", value)
    if error["type"] in ("model_type", "model_attributes_type", "dict_type"):
        wanted = "a number or {value, low, high}" if path[-1] == "young_modulus" else f"a table, [{key}]"
        return InputError(key, f"must be {wanted}", value)
    rule = re.sub("^(Input|String|List|Tuple) should", "must", error["msg"]).partition(" after validation")[0]
    rule = rule.replace("a valid integer", "an integer").replace("valid ", "").replace("a tuple", "a list")
    unit = "" if "too_" in error["type"] else unit_of(model, path)  # a length has none
    if error["type"] == "int_type" and isinstance(value, float) and value.is_integer() and abs(value) < 1e9:
        return InputError(key, f"{rule}, got {value}", remedy=f"write {value:.0f}")  # 9.0 is not to read 9
    return InputError(key, rule + (f" ({unit})" if unit else ""), value)
