"""What a result says, as numbers by key: any number of its JSON, with its error where it has one.

Lists are counted from 1, as ridges are, or by their entries' names: `ridge_force_N.3`,
`parts.cavity.volume_mm3`; a list of plain numbers has `.min`, `.max` and `.last` too, any other `.count`. A
key may leave its unit out: `all_touch_force`, `ridge_force.3`.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from skincad.base.errors import InputError, did_you_mean
from skincad.base.estimate import Estimate

UNITS = (  # suffixes of JSON keys, the longer ones first
    "MPa_per_s2", "MPa_per_s", "dB_per_dec", "N_per_MPa", "N_per_mm", "mm3", "mm2", "MPa", "mm", "Hz", "mJ",
    "ms", "dB", "pC", "nV", "V", "N", "s", "g", "deg",
)  # fmt: skip
_UNIT = re.compile(rf"_({'|'.join(UNITS)})(?=\.|$)")
LONGEST_LIST = 64  # of numbers that are told one by one; longer ones, over steps, by their ends
NAMES = ("name", "effect", "rule", "tier")  # by which entries of a list are told


def measures(result: Mapping[str, Any]) -> dict[str, Estimate]:
    """Return every number of a result's JSON by its key; a null where a number may be has no value."""
    return dict(_leaves(result, ""))


def _leaves(data: Any, at: str) -> Iterator[tuple[str, Estimate]]:
    if isinstance(data, Mapping):
        if data.keys() == {"value", "error"}:
            yield at, Estimate(data["value"], data["error"], unit_of_key(at))
            return
        for key, value in data.items():
            error = data.get(f"{key}_error")
            if key.endswith("_error") and key.removesuffix("_error") in data:
                continue
            where = f"{at}.{key}" if at else str(key)
            if isinstance(error, int | float) and isinstance(value, int | float):
                yield where, Estimate(float(value), float(error), unit_of_key(where))
            else:
                yield from _leaves(value, where)
    elif isinstance(data, list):
        yield from _entries(data, at)
    elif data is None or (isinstance(data, int | float) and not isinstance(data, bool)):
        yield at, Estimate(None if data is None else float(data), None, unit_of_key(at))
    elif isinstance(data, bool):
        yield at, Estimate(float(data), 0.0, "")


def _entries(data: list[Any], at: str) -> Iterator[tuple[str, Estimate]]:
    numbers = [float(x) for x in data if isinstance(x, int | float) and not isinstance(x, bool)]
    if len(data) <= LONGEST_LIST or not numbers:
        for number, entry in enumerate(data[:LONGEST_LIST], 1):
            name = (
                next((entry[k] for k in NAMES if k in entry), number) if isinstance(entry, dict) else number
            )
            yield from _leaves(entry, f"{at}.{name}")
    if not numbers and not any(isinstance(entry, Mapping) and "value" in entry for entry in data):
        yield f"{at}.count", Estimate(float(len(data)), 0.0, "")
    if numbers and len(numbers) == len(data):
        for name, value in (("min", min(numbers)), ("max", max(numbers)), ("last", numbers[-1])):
            yield f"{at}.{name}", Estimate(value, None, unit_of_key(at))


def unit_of_key(key: str) -> str:
    """Return the unit that a JSON key ends in, "" where it has none: N/mm of `sensitivity_N_per_mm.1`."""
    match = _UNIT.search(key)
    return match[1].replace("_per_", "/") if match else ""


def resolved(key: str, known: Iterable[str], *, what: str = "target") -> str:
    """Return the known key that `key` means, its unit left out or not; raises InputError for none."""
    names = list(known)
    if key in names:
        return key
    matches = [name for name in names if _UNIT.sub("", name) == key]
    if len(matches) == 1:
        return matches[0]
    bare = {_UNIT.sub("", name) for name in names if "seconds" not in name}
    remedy = did_you_mean(key, bare)
    if remedy.startswith("known"):  # all entries of all lists would be no help
        remedy = did_you_mean(key, {name.partition(".")[0] for name in bare})
    raise InputError(f"{what} {key}", "no such number in the result", remedy=remedy)


def worded(key: str, value: Estimate | float) -> str:
    """Return a result in words: `all_touch_force 3 N`, or with its error."""
    estimate = value if isinstance(value, Estimate) else Estimate(value, None, unit_of_key(key))
    return f"{_UNIT.sub('', key)} {estimate}".rstrip()


def slack(estimate: Estimate) -> float:
    """Return an estimate's error, 0 where nobody knows it."""
    return 0.0 if estimate.error is None or not math.isfinite(estimate.error) else estimate.error
