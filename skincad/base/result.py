"""Results: frozen data whose numbers are declared once, and what all of them offer.

Records: frozen data whose every number is declared once, with unit and meaning. The declaration gives the
JSON (`as_json`) and the table of numbers (`numbers`, name -> Estimate) that studies vary, wish and rank by. A
field or property that isn't declared with `item` or `reported` is in neither.
"""

from __future__ import annotations

import base64
import html
import io
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping
from dataclasses import MISSING, dataclass, field, fields
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, ClassVar, Generic, Protocol, TypeVar, cast, dataclass_transform

import numpy as np

from skincad.base.estimate import Estimate

MAX_LISTED = 64  # numbers of a list that have a name each; longer ones, over steps, have their ends
NAMES = ("name", "effect", "rule", "tier")  # keys by which an entry of a list is named
T = TypeVar("T")


@dataclass(frozen=True)
class ReportedItem:
    """How an attribute is reported: its JSON key, and the unit of its numbers.

    `error` is the attribute that holds a plain number's error; `inline` puts the entries of a nested record
    or mapping beside the other keys.
    """

    key: str
    unit: str
    meaning: str
    error: str = ""
    inline: bool = False


def item(
    unit: str = "",
    meaning: str = "",
    *,
    key: str = "",
    error: str = "",
    inline: bool = False,
    default: Any = MISSING,
) -> Any:
    """Return a dataclass field that is reported; its key is its name and its unit unless `key` is given."""
    return field(default=default, metadata={"item": ReportedItem(key, unit, meaning, error, inline)})


class ReportedProperty(Generic[T]):
    """A property that is reported; made by `reported`."""

    def __init__(self, method: Callable[[Any], T], declared: ReportedItem) -> None:
        self.method, self.item, self.__doc__ = method, declared, method.__doc__

    def __get__(self, record: Any, kind: type | None = None) -> T:
        return self if record is None else self.method(record)  # type: ignore[return-value]


def reported(
    unit: str = "", meaning: str = "", *, key: str = "", error: str = "", inline: bool = False
) -> Callable[[Callable[[Any], T]], ReportedProperty[T]]:
    """Make a method a property that is reported, as `item` does a field."""
    return lambda method: ReportedProperty(method, ReportedItem(key, unit, meaning, error, inline))


def key_of(name: str, unit: str) -> str:
    """Return the JSON key of a name: the unit is its suffix, N/mm as N_per_mm."""
    return f"{name}_{unit.replace('/', '_per_')}" if unit else name


@dataclass_transform(kw_only_default=True, frozen_default=True, field_specifiers=(item, field))
def record(*, eq: bool = True) -> Callable[[type[T]], type[T]]:
    """Make a class of records: frozen data, built by keyword only.

    Without `eq` it is equal to itself alone, as arrays in it need.
    """
    return dataclass(frozen=True, kw_only=True, eq=eq)


class Record:
    """A frozen dataclass whose attributes are declared with `item` and `reported`."""

    def as_json(self) -> dict[str, Any]:
        """Return the object that `--json` prints: numbers with their unit in the key, errors beside them."""
        return {key: plain(value) for key, value, _ in _entries(self)}

    def numbers(self) -> dict[str, Estimate]:
        """Return every number by its name in the JSON, with its error where it has one.

        Lists are counted from 1, as ridges are, or by their entries' names: `ridge_force_N.3`,
        `parts.cavity.volume_mm3`; a list of plain numbers has `.min`, `.max` and `.last` too, any other
        `.count`. A null where a number may be is an Estimate without value.
        """
        return dict(_numbers_of_record(self, ""))


@cache
def _declared(kind: type) -> tuple[tuple[str, ReportedItem], ...]:
    """The declared attributes of a class of records, in their order."""
    listed = {
        declared.name: declared.metadata["item"] for declared in fields(kind) if "item" in declared.metadata
    }
    for parent in reversed(kind.__mro__):
        for name, value in vars(parent).items():
            if isinstance(value, ReportedProperty):
                listed[name] = value.item
    return tuple(listed.items())


def _entries(record: Record) -> Iterator[tuple[str, Any, ReportedItem]]:
    """Key, value and declaration of everything that a record reports."""
    for name, declared in _declared(type(record)):  # type: ignore[arg-type]  # a class is hashable
        value = getattr(record, name)
        if not declared.inline:
            yield declared.key or key_of(name, declared.unit), value, declared
        elif isinstance(value, Record):
            yield from _entries(value)
        elif value is not None:
            yield from ((key, entry, declared) for key, entry in value.items())


def plain(value: Any) -> Any:
    """Return a value as JSON has it: records and estimates as objects, arrays as lists."""
    if isinstance(value, Record | Estimate):
        return value.as_json()
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [plain(entry) for entry in value]
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    return value


def _numbers_of_record(record: Record, at: str) -> Iterator[tuple[str, Estimate]]:
    entries = list(_entries(record))
    keys = {key for key, _, _ in entries}
    for key, value, declared in entries:
        if key.removesuffix("_error") in keys - {key}:
            continue
        name = f"{at}.{key}" if at else key
        error = getattr(record, declared.error) if declared.error else None
        if error is not None and value is not None:
            yield name, Estimate(float(value), float(error), declared.unit)
        else:
            yield from _numbers(value, name, declared.unit)


def _numbers(value: Any, at: str, unit: str) -> Iterator[tuple[str, Estimate]]:
    if isinstance(value, Estimate):
        yield at, value
    elif isinstance(value, Record):
        yield from _numbers_of_record(value, at)
    elif isinstance(value, Mapping):
        for key, entry in value.items():
            yield from _numbers(entry, f"{at}.{key}", unit)
    elif isinstance(value, list | tuple | np.ndarray):
        yield from _numbers_of_list(list(value), at, unit)
    elif isinstance(value, bool):
        yield at, Estimate(float(value), 0.0, "")
    elif value is None or isinstance(value, int | float | np.number):
        yield at, Estimate(None if value is None else float(value), None, unit)


def _numbers_of_list(values: list[Any], at: str, unit: str) -> Iterator[tuple[str, Estimate]]:
    plain_numbers = [
        float(x) for x in values if isinstance(x, int | float | np.number) and not isinstance(x, bool)
    ]
    if len(values) <= MAX_LISTED or not plain_numbers:
        for number, value in enumerate(values[:MAX_LISTED], 1):
            yield from _numbers(value, f"{at}.{_name_of(value) or number}", unit)
    if not plain_numbers and not any(isinstance(value, Estimate) for value in values):
        yield f"{at}.count", Estimate(float(len(values)), 0.0, "")
    if plain_numbers and len(plain_numbers) == len(values):
        for name, end in (
            ("min", min(plain_numbers)),
            ("max", max(plain_numbers)),
            ("last", plain_numbers[-1]),
        ):
            yield f"{at}.{name}", Estimate(end, None, unit)


def _name_of(value: Any) -> str:
    """The name of a list's entry, "" without one."""
    if isinstance(value, Record):
        named = {key: entry for key, entry, _ in _entries(value)}
    elif isinstance(value, Mapping):
        named = dict(value)
    else:
        return ""
    return next((str(named[key]) for key in NAMES if key in named), "")


Figure = Any  # matplotlib's, which outputs/ alone names
Writer = Callable[[Path], None]
LONGEST_REPR = 200  # letters: a line of a console, not a page


class Presenter(Protocol):
    """What shows one kind of result: a module of outputs/, or a `Presentation`."""

    COMMAND: str  # whose manifest lists the files

    def lines(self, result: Any, /) -> list[str]:
        """Return what the command prints."""

    def files(self, result: Any, /) -> dict[str, Writer]:
        """Return a writer for each file, by its name."""

    def figures(self, result: Any, /) -> Mapping[str, Callable[[], Figure]]:
        """Return what draws each figure, by its name."""

    def manifest(self, result: Any, /) -> Mapping[str, Any]:
        """Return what the manifest says of the result beside its files."""


class Result(ABC):
    """A frozen answer. `shown_by` names what shows it, imported when it is asked: a module of outputs/, or
    after a colon one of a module's `Presentation`s."""

    shown_by: ClassVar[str]

    @abstractmethod
    def as_json(self) -> dict[str, Any]:
        """Return the object that `--json` prints: numbers with their unit in the key, errors beside them."""

    @property
    def exit_status(self) -> int:
        """What a command that computes it exits with: 0 done and passed, 1 a check failed or is undecided."""
        return 0

    def presenter(self) -> Presenter:
        """Return what shows results of this kind."""
        module, _, name = self.shown_by.partition(":")
        shown = import_module(module)
        return cast(Presenter, getattr(shown, name) if name else shown)

    def files(self) -> dict[str, Writer]:
        """Return name -> writer; a writer takes the path to write to. `skincad.write` writes them all."""
        return self.presenter().files(self)

    def figures(self) -> dict[str, Figure]:
        """Return all matplotlib figures by name, drawn now."""
        return {name: draw() for name, draw in self.presenter().figures(self).items()}

    def figure(self, name: str | None = None) -> Figure:
        """Return the matplotlib figure of this name, the first one if None; KeyError lists the names."""
        draws = self.presenter().figures(self)
        if not draws or (name is not None and name not in draws):
            raise KeyError(f"no figure {name or 'here'}; there are: {', '.join(draws) or 'none'}")
        return draws[name or next(iter(draws))]()

    def __str__(self) -> str:
        return "\n".join(self.presenter().lines(self))

    def __repr__(self) -> str:
        text = f"<{type(self).__name__} {str(self).partition(chr(10))[0]}"
        return text[: LONGEST_REPR - 4] + "...>" if len(text) >= LONGEST_REPR else text + ">"

    def _repr_html_(self) -> str:
        """The words, and the first figure, for a notebook."""
        words = f"<pre>{html.escape(str(self))}</pre>"
        if not self.presenter().figures(self):
            return words
        picture = io.BytesIO()
        self.figure().savefig(picture, format="png")
        return f'{words}<img src="data:image/png;base64,{base64.b64encode(picture.getvalue()).decode()}">'
