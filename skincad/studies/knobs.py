"""What is varied: a key and the values that it may have, a range or choices."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from skincad.base.arrays import Array
from skincad.base.errors import InputError, did_you_mean
from skincad.base.tables import NumberWithRange, unit_of
from skincad.inputs.process import processes
from skincad.inputs.silicone import silicones
from skincad.studies.subject import Subject, Value, field_of, kinds, owner, value_of

ALL = "all"
DIGITS = 5  # of a value that is tried: finer than any tolerance, and a design reads well
MOST_VALUES = 10_000  # of one key
WIDE = 3.0  # times its low end, from which on a range is looked at by ratios, not by differences
Outcome = str | Sequence[Any]  # LOW:HIGH, LOW:HIGH:N, all, or A,B,C; or (low, high), (low, high, n), names
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

    def share(self, value: float) -> float:
        """Return at which share of the range a value of it lies."""
        if self.by_ratio:
            return math.log(value / self.low) / math.log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)

    def shares(self, values: Sequence[float]) -> Array:
        """Return the shares of several values."""
        return np.array([self.share(value) for value in values])

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


def knob(subject: Subject, key: str, choices_told: Outcome) -> DesignVariable:
    """Return the knob of a key of a design, scene or circuit.

    `told` is a text as on the command line, or (low, high), (low, high, count), or a list of choices. Raises
    InputError for an unknown key, for one that holds no number or name, and for an empty range.
    """
    field = field_of(subject, key)
    types = {float if kind is NumberWithRange else kind for kind in kinds(field) if isinstance(kind, type)}
    start, unit = value_of(subject, key), _unit(subject, key)
    parts = _parts(key, choices_told)
    if parts == [ALL]:
        names = _catalogue(subject, key, field)
        return DesignVariable(key, unit, start, choices=names)
    numbers = [_number(part) for part in parts]
    ranged = ":" in choices_told if isinstance(choices_told, str) else _is_range(choices_told)
    if not ranged and {int, float} & types and str not in types and None in numbers:
        raise InputError(key, "must be numbers", str(choices_told), FORM)
    if not ranged:
        if not parts:
            raise InputError(key, "needs values", remedy=FORM)
        known = _catalogue(subject, key, field, must=False)
        for part in parts:
            if known and part not in known:
                raise InputError(key, "unknown choice", part, did_you_mean(str(part), map(str, known)))
        values = tuple(
            p if n is None or known else _whole(n, types) for p, n in zip(parts, numbers, strict=True)
        )
        return DesignVariable(key, unit, start, choices=tuple(dict.fromkeys(values)))
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
    return DesignVariable(
        key, unit, start, low, high, whole, _count(key, numbers[2]) if len(parts) == 3 else None
    )


def knobs(subject: Subject, vary: Mapping[str, Outcome]) -> tuple[DesignVariable, ...]:
    """Return the knobs of several keys; raises InputError for none."""
    if not vary:
        raise InputError("vary", "names no key", remedy="as in ridge.height=0.4:1.3")
    return tuple(knob(subject, key, values) for key, values in vary.items())


def _parts(key: str, values: Outcome) -> list[Any]:
    if not isinstance(values, str):
        return list(values)
    text = values.strip()
    parts = [part.strip() for part in text.split(":" if ":" in text else ",")]
    if not all(parts):
        raise InputError(key, "has an empty place", values, FORM)
    return list(parts)


def _is_range(values: Sequence[Any]) -> bool:
    """Whether a Python sequence is (low, high) or (low, high, count): a tuple of numbers."""
    return isinstance(values, tuple) and len(values) in (2, 3) and not any(isinstance(t, str) for t in values)


def _number(part: Any) -> float | None:
    try:
        return None if isinstance(part, bool) else float(part)
    except (TypeError, ValueError):
        return None


def _whole(number: float, types: set[Any]) -> float | int:
    return number if float in types or not number.is_integer() else int(number)


def _count(key: str, number: float | None) -> int:
    if number is None or not number.is_integer() or not 2 <= number <= MOST_VALUES:
        raise InputError(key, f"must have from 2 to {MOST_VALUES} values", number, "as in LOW:HIGH:10")
    return int(number)


def _unit(subject: Subject, key: str) -> str:
    whose, name = owner(subject, key)
    return unit_of(type(whose), tuple(name.split(".")))


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
