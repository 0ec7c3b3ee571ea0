"""Results: frozen data whose numbers are declared once, and what all of them offer.

Records: frozen data whose every number is declared once, with unit and meaning. The declaration gives the
JSON (`as_json`) and the table of numbers (`numbers`, name -> Estimate) that studies vary, wish and rank by. A
field or property that isn't declared with `item` or `reported` is in neither.
"""

from __future__ import annotations

import base64
import html
import io
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import MISSING, dataclass, field, fields, is_dataclass
from functools import cache
from operator import attrgetter
from pathlib import Path
from typing import Any, ClassVar, Generic, NamedTuple, Protocol, TypeVar, cast, dataclass_transform

import numpy as np

from skincad.base.errors import InputError
from skincad.base.estimate import Estimate
from skincad.base.faces import imported

MAX_LISTED = 64  # numbers of a list that have a name each; longer ones, over steps, have their ends
NAMES = ("name", "effect", "rule", "tier")  # keys by which an entry of a list is named
T = TypeVar("T")
Numbers = Iterator[tuple[str, Estimate]]


@dataclass(frozen=True)
class ReportedItem:
    """How an attribute is reported: its JSON key, and the unit of its numbers.

    `error` is the attribute that holds a plain number's error; `inline` puts the entries of a nested record
    or mapping beside the other keys. `null` says that an empty text, tuple or 0 is null; an `optional`
    attribute that is None has no key.
    """

    unit: str = ""
    meaning: str = ""
    key: str = ""
    error: str = ""
    inline: bool = False
    null: bool = False
    optional: bool = False


def item(
    unit: str = "", meaning: str = "", *, default: Any = MISSING, compare: bool = True, **options: Any
) -> Any:
    """Return a dataclass field that is reported; its key is its name and its unit unless `key` is given.

    `options` are those of `ReportedItem`.
    """
    declared = ReportedItem(unit, meaning, **options)
    return field(default=default, compare=compare, metadata={"item": declared})


class ReportedProperty(Generic[T]):
    """A property that is reported; made by `reported`."""

    def __init__(self, method: Callable[[Any], T], declared: ReportedItem) -> None:
        self.method, self.item, self.__doc__ = method, declared, method.__doc__

    def __get__(self, record: Any, kind: type | None = None) -> T:
        return self if record is None else self.method(record)  # type: ignore[return-value]


def reported(
    unit: str = "", meaning: str = "", **options: Any
) -> Callable[[Callable[[Any], T]], ReportedProperty[T]]:
    """Make a method a property that is reported, as `item` does a field."""
    declared = ReportedItem(unit, meaning, **options)
    return lambda method: ReportedProperty(method, declared)


def reported_from(path: str, unit: str = "", meaning: str = "", **options: Any) -> Any:
    """Return a property that reports what another record has, as "scene.name", as `reported` does."""
    return ReportedProperty(attrgetter(path), ReportedItem(unit, meaning, **options))


def key_of(name: str, unit: str) -> str:
    """Return the JSON key of a name: the unit is its suffix, N/mm as N_per_mm."""
    return f"{name}_{unit.replace('/', '_per_')}" if unit else name


UNITS = (  # suffixes of JSON keys, the longer ones first
    "MPa_per_s2", "MPa_per_s", "dB_per_dec", "N_per_MPa", "N_per_mm", "mm3", "mm2", "MPa", "mm", "Hz", "mJ",
    "mT", "uT", "ms", "dB", "pC", "nV", "V", "N", "s", "g", "deg",
)  # fmt: skip
_UNIT = re.compile(rf"_({'|'.join(UNITS)})(?=\.|$)")


def unit_of_key(key: str) -> str:
    """Return the unit that a JSON key ends in, "" where it has none: N/mm of `sensitivity_N_per_mm.1`."""
    match = _UNIT.search(key)
    return match[1].replace("_per_", "/") if match else ""


def bare_key(key: str) -> str:
    """Return a JSON key without its unit."""
    return _UNIT.sub("", key)


@dataclass_transform(kw_only_default=True, frozen_default=True, field_specifiers=(item, field))
def record(*, eq: bool = True) -> Callable[[type[T]], type[T]]:
    """Make a class of records: frozen data, built by keyword only.

    Without `eq` it is equal to itself alone, as arrays in it need.
    """

    def made(kind: type[T]) -> type[T]:
        return dataclass(frozen=True, kw_only=True, eq=eq, repr=kind.__repr__ is object.__repr__)(kind)

    return made


class Record:
    """A frozen dataclass whose attributes are declared with `item` and `reported`."""

    def as_json(self) -> dict[str, Any]:
        """Return the object that `--json` prints: numbers with their unit in the key, errors beside them."""
        return plain(self)  # type: ignore[no-any-return]

    def numbers(self) -> dict[str, Estimate]:
        """Return every number by its name in the JSON, with its error where it has one.

        Lists are counted from 1, as ridges are, or by their entries' names: `ridge_force_N.3`,
        `parts.cavity.volume_mm3`; a list of plain numbers has `.min`, `.max` and `.last` too, any other
        `.count`. A null where a number may be is an Estimate without value.
        """
        return dict(_numbers(self, "", ""))


FIRST = ("name", "passed", "verdict", "next_step")  # keys that a reader looks for at the top,
LAST = ("seconds", "warnings")  # and at the end


@cache
def declared_items(kind: type) -> tuple[tuple[str, ReportedItem], ...]:
    """Return a class of records' reported attributes by name, in the order of their keys in the JSON."""
    listed = {
        declared.name: declared.metadata["item"] for declared in fields(kind) if "item" in declared.metadata
    }
    for parent in reversed(kind.__mro__):
        for name, value in vars(parent).items():
            if isinstance(value, ReportedProperty):
                listed[name] = value.item
    place = {name: at for at, name in enumerate((*FIRST, "", *LAST), -len(FIRST))}
    return tuple(sorted(listed.items(), key=lambda entry: place.get(entry[0], 0)))


class _Entry(NamedTuple):
    """A key, its value, the unit of its numbers, and a plain number's error where that is known."""

    key: str
    value: Any
    unit: str = ""
    error: float | None = None


def _entries(value: Any) -> list[_Entry] | None:
    """Everything that a record or another object of named values reports; None for what is not one."""
    if isinstance(value, Record):
        return list(_entries_of_record(value))
    if hasattr(value, "_asdict"):  # a named tuple
        named = value._asdict()
    elif hasattr(value, "model_dump"):  # pydantic's
        named = value.model_dump()
    elif is_dataclass(value) and not isinstance(value, Estimate | type):
        named = {declared.name: getattr(value, declared.name) for declared in fields(value)}
    elif isinstance(value, Mapping):
        named = value
    else:  # an estimate's value and error are one number
        return None
    return [_Entry(str(key), entry) for key, entry in named.items()]


def _entries_of_record(record: Record) -> Iterator[_Entry]:
    for name, declared in declared_items(type(record)):  # type: ignore[arg-type]  # a class is hashable
        value = getattr(record, name)
        if declared.null and not value:
            value = None
        if declared.inline:
            yield from _entries(value) or ()
        elif value is not None or not declared.optional:
            error = getattr(record, declared.error) if declared.error else None
            yield _Entry(declared.key or key_of(name, declared.unit), value, declared.unit, error)


def plain(value: Any) -> Any:
    """Return a value as JSON has it: records, named tuples and estimates as objects, arrays as lists."""
    if isinstance(value, Estimate):
        return value.as_json()
    if (entries := _entries(value)) is not None:
        named: dict[str, Any] = {}
        for entry in entries:
            if entry.key in named:
                raise ValueError(f"{type(value).__name__} gives {entry.key!r} twice: rename one of them")
            named[entry.key] = plain(entry.value)
        return named
    if isinstance(value, list | tuple):
        return [plain(entry) for entry in value]
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    return value


def _numbers(value: Any, at: str, unit: str) -> Numbers:
    """Numbers of a value called `at`; `unit` is that of entries which declare none."""
    if isinstance(value, Estimate):
        yield at, value
    elif (entries := _entries(value)) is not None:
        keys = {entry.key for entry in entries}
        for entry in entries:
            if entry.key.endswith("_error") and entry.key.removesuffix("_error") in keys:
                continue
            name = f"{at}.{entry.key}" if at else entry.key
            if entry.error is not None and entry.value is not None:
                yield name, Estimate(float(entry.value), float(entry.error), entry.unit)
            else:
                yield from _numbers(entry.value, name, entry.unit or unit_of_key(entry.key) or unit)
    elif isinstance(value, list | tuple | np.ndarray):
        yield from _numbers_of_list(list(value), at, unit)
    elif isinstance(value, bool | np.bool_):
        yield at, Estimate(float(value), 0.0, "")
    elif value is None or isinstance(value, int | float | np.number):
        yield at, Estimate(None if value is None else float(value), None, unit)


def _numbers_of_list(values: list[Any], at: str, unit: str) -> Numbers:
    plain_numbers = [
        float(x) for x in values if isinstance(x, int | float | np.number) and not isinstance(x, bool)
    ]
    if len(values) <= MAX_LISTED or not plain_numbers:
        for number, value in enumerate(values[:MAX_LISTED], 1):
            named = {entry.key: entry.value for entry in _entries(value) or ()}
            name = next((named[key] for key in NAMES if key in named), number)
            yield from _numbers(value, f"{at}.{name}", unit)
    if not plain_numbers and not any(isinstance(value, Estimate) for value in values):
        yield f"{at}.count", Estimate(float(len(values)), 0.0, "")
    if plain_numbers and len(plain_numbers) == len(values):
        ends = {"min": min(plain_numbers), "max": max(plain_numbers), "last": plain_numbers[-1]}
        yield from ((f"{at}.{name}", Estimate(end, None, unit)) for name, end in ends.items())


Figure = Any  # matplotlib's, which outputs/ alone names
Writer = Callable[[Path], None]
LONGEST_REPR = 200  # letters: a line of a console, not a page


def with_picture(text: str, figure: Figure) -> str:
    """Return the HTML of a text with a matplotlib figure below."""
    picture = io.BytesIO()
    figure.savefig(picture, format="png")
    data = base64.b64encode(picture.getvalue()).decode()
    return f'<pre>{html.escape(text)}</pre><img src="data:image/png;base64,{data}">'


class Presenter(Protocol):
    """What shows one kind of result: a `Presentation` of outputs/."""

    COMMAND: str  # whose manifest lists the files

    def lines(self, result: Any, /) -> list[str]:
        """Return the answer, and how sure it is, in few lines."""

    def next_step(self, result: Any, /) -> str:
        """Return what to do next, with `{design}` or `{scene}` for it as it is typed; "" for nothing."""

    def details(self, result: Any, /) -> list[str]:
        """Return the numbers behind `lines`, without repeating them."""

    def html(self, result: Any, /) -> str:
        """Return what a notebook shows."""

    def files(self, result: Any, /) -> dict[str, Writer]:
        """Return a writer for each file, by its name."""

    def figures(self, result: Any, /) -> Mapping[str, Callable[[], Figure]]:
        """Return what draws each figure, by its name."""

    def manifest(self, result: Any, /) -> Mapping[str, Any]:
        """Return what the manifest says of the result beside its files."""

    def replaces(self, result: Any, folder: Path, /) -> None:
        """Raise InputError for a folder whose files this result must not replace."""


class Result(Record):
    """A frozen answer. `shown_by` names the `Presentation` that shows it, imported when it is asked."""

    shown_by: ClassVar[str]

    @property
    def exit_status(self) -> int:
        """What a command that computes it exits with: 0 done and passed, 1 a check failed or is undecided."""
        return 0

    def presenter(self) -> Presenter:
        """Return what shows results of this kind."""
        return cast(Presenter, imported(self.shown_by))

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

    def columns(self) -> dict[str, Any]:
        """Return the result's table: cells by column, all columns of one length.

        Names are those of the JSON, with the unit; a number's error has the column `NAME.error`. Of a result
        that is no table, each number has a row.
        """
        numbers = self.numbers()
        return {
            "name": list(numbers),
            "value": [number.value for number in numbers.values()],
            "error": [number.error for number in numbers.values()],
            "unit": [number.unit for number in numbers.values()],
        }

    def to_frame(self) -> Any:
        """Return the result's table as a pandas DataFrame, units in the columns' names.

        Raises InputError where pandas is not installed.
        """
        return data_frame(self.columns())

    def next_line(self, fill: Callable[[str], str] | None = None) -> list[str]:
        """Return the line that says what to do next, none for nothing; `fill` puts the design into it, which
        is DESIGN or SCENE without, as in `--help`: nobody knows by what file a result came to be."""
        step = self.presenter().next_step(self)
        words = fill(step) if fill else re.sub(r"\{(\w+)\}", lambda match: match[1].upper(), step)
        return [f"Next: {words}"] if step else []

    def details(self) -> str:
        """Return what the command prints with --verbose: the words of `str`, and the numbers behind them."""
        return "\n".join([str(self), *self.presenter().details(self)])

    def __str__(self) -> str:
        return "\n".join([*self.presenter().lines(self), *self.next_line()])

    def __repr__(self) -> str:
        text = f"<{type(self).__name__} {str(self).partition(chr(10))[0]}"
        return text[: LONGEST_REPR - 4] + "...>" if len(text) >= LONGEST_REPR else text + ">"

    def _repr_html_(self) -> str:
        """What a notebook shows."""
        return self.presenter().html(self)


def data_frame(columns: Mapping[str, Any]) -> Any:
    """Return a pandas DataFrame of columns by name; raises InputError where pandas is not installed."""
    try:
        import pandas
    except ImportError:
        raise InputError("to_frame", "needs the package pandas", remedy="pip install pandas") from None
    return pandas.DataFrame(dict(columns))


def columns_of(rows: Iterable[Any]) -> dict[str, list[Any]]:
    """Return rows (records, or mappings of values) as columns by name; a value that a row lacks is None.

    Names within a name follow a dot. An Estimate gives a column for its value and one for its error.
    """
    table = [dict(_cells(row, "")) for row in rows]
    names = dict.fromkeys(name for row in table for name in row)
    return {name: [row.get(name) for row in table] for name in names}


def estimate_columns(name: str, estimates: Iterable[Estimate]) -> dict[str, list[float | None]]:
    """Return the column of these values, and that of their errors."""
    listed = list(estimates)
    return {name: [e.value for e in listed], f"{name}.error": [e.error for e in listed]}


def _cells(value: Any, at: str) -> Iterator[tuple[str, Any]]:
    if isinstance(value, Estimate):
        yield from ((at, value.value), (f"{at}.error", value.error))
    elif (entries := _entries(value)) is not None:
        for entry in entries:
            yield from _cells(entry.value, f"{at}.{entry.key}" if at else entry.key)
    else:
        yield at, value
