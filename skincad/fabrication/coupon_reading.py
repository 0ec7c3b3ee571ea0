"""A coupon's filled-in forms read back: what is known of the process now, and its table for printer.toml."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import tomlkit

from skincad.base.errors import InputError, did_you_mean
from skincad.base.estimate import Estimate
from skincad.base.progress import Progress, Stopwatch
from skincad.base.reading import text_of
from skincad.base.result import Result
from skincad.fabrication.coupon_fit import CrestResult, NotchResult, crest_result, notch_result
from skincad.inputs.catalog import LARGEST_FILE, load_design
from skincad.inputs.measurements import CREST_FORM, NOTCH_FORM, read_crests, read_notches
from skincad.inputs.process import Process, processes
from skincad.solids.coupon import NOTCHES, drawn_notches, drawn_steps


class MeasuredKey(NamedTuple):
    """A key of a process as a coupon gave it, mm, with what its line says of where it is from."""

    key: str
    value: float
    comment: str


@dataclass(frozen=True, repr=False)
class CouponReading(Result):
    """What the forms in `folder` say of the process `name`, which was `before`.

    `own` is the text of one's own printer.toml, or "". `notches` and `crests` are None where their form is
    not there.
    """

    shown_by = "skincad.outputs.coupons:READING"
    name: str
    folder: Path
    before: Process
    printer_text: str
    notches: NotchResult | None
    crests: CrestResult | None
    seconds: dict[str, float] = field(compare=False)

    @property
    def keys(self) -> list[MeasuredKey]:
        """The process's keys that are known now."""
        return list(_keys(self))

    def as_json(self) -> dict[str, Any]:
        """Return the object of `--json`; the unit is the key's suffix."""
        notches, crests = self.notches, self.crests
        return {
            "name": self.name,
            "passed": True,
            "growth_mm": _json(notches.growth if notches else None),
            "gap_mm": _json(notches.gap if notches else None),
            "crest_sigma_mm": _json(crests.sigma if crests else None),
            "crest_offset_mm": _json(crests.offset if crests else None),
            "keys": {row.key: row.value for row in self.keys},
            "seconds": dict(self.seconds),
        }

    def to_toml(self) -> str:
        """Return one's own printer.toml with the process's keys as they are known now."""
        document = tomlkit.parse(self.printer_text)
        if self.name not in document:
            document[self.name] = tomlkit.table()
        table: Any = document[self.name]
        for key, value, comment in self.keys:
            item = tomlkit.item(value)
            item.comment(comment)
            table[key] = item
        text = tomlkit.dumps(document).lstrip("\n")
        load_design("plain-ridges", printer=tomllib.loads(text))  # what is written can be read
        return text


def _json(estimate: Estimate | None) -> dict[str, float | None]:
    return estimate.as_json() if estimate else {"value": None, "error": None}


def _keys(reading: CouponReading) -> Iterator[MeasuredKey]:
    by = "measured on a coupon"
    if (notches := reading.notches) is not None:
        if notches.gap:
            shut = "the narrowest notch that is open, of the ladder's"
            yield MeasuredKey("gap", float(notches.gap), f"{by}: {shut}")
        if notches.growth:
            comment = f"{by}: ± {notches.growth.error:.4f} (95 %)"
            yield MeasuredKey("growth", round(float(notches.growth), 4), comment)
    if (crests := reading.crests) is not None:
        comment = f"{by}: ± {crests.sigma.error:.4f} (95 %)"
        yield MeasuredKey("crest_sigma", round(float(crests.sigma), 4), comment)
        comment = f"{by}: ± {crests.offset.error:.4f} (95 %)"
        yield MeasuredKey("crest_offset", round(float(crests.offset), 4), comment)
    worst = max((result.worst for result in (notches, crests) if result), default=0.0)
    if worst > reading.before.tolerance:
        comment = f"{by}: the largest error of a side or a crest"
        yield MeasuredKey("tolerance", round(worst, 4), comment)


def read_coupon(
    process: str, folder: Path, *, printer: Path | None = None, progress: Progress | None = None
) -> CouponReading:
    """Return what the filled-in forms in a folder say of a process that ships or is one of `printer`'s.

    Raises InputError for an unknown process, forms that are not filled in or whose rows are not those of the
    process's coupon, and a folder without any.
    """
    clock = Stopwatch(progress)
    with clock.stage("read"):
        known = processes(load_design("plain-ridges", printer=printer).printer)
        if process not in known:
            raise InputError("process", "unknown process", process, did_you_mean(process, known))
        printer_text = text_of(printer, str(printer), LARGEST_FILE, "TOML") if printer else ""
        widths = drawn_notches(known[process])
        if not widths and (folder / NOTCH_FORM).exists():
            rule = f"must not be there: the tool of {process!r} cuts no ladder of notches"
            remedy = "name the process that made the ladder, or remove the file"
            raise InputError(str(folder / NOTCH_FORM), rule, remedy=remedy)
        notches, crests = read_notches(folder, widths), read_crests(folder, drawn_steps())
    if notches is None and crests is None:
        rule = f"must hold {NOTCH_FORM} or {CREST_FORM}, filled in"
        raise InputError("measured", rule, str(folder), "name the folder of the coupon's forms")
    with clock.stage("fit"):
        ladder = notch_result(notches) if notches else None
        steps = crest_result(crests) if crests else None
    return CouponReading(process, folder, known[process], printer_text, ladder, steps, clock.seconds())


def no_growth_words() -> str:
    """Return the words for a ladder that does not show the growth."""
    return (
        f"fewer than three notches are open: growth is not known, and the gap may be above {NOTCHES[-1]:g} mm"
    )
