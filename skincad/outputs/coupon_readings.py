"""Output of a measured coupon: words with their errors, and a printer.toml."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from skincad.base.result import Writer
from skincad.fabrication.coupon_reading import CouponReading, no_growth_words
from skincad.fabrication.coupon_sheet import BAR_FORM, PAD_DESIGN, PAD_FORM, fit_bar_command, fit_pad_command
from skincad.outputs.delivery import text

COMMAND = "coupon-reading"
PRINTER = "printer.toml"
# a folder in which the same command left forms keeps them: this result has its own manifest


def lines(reading: CouponReading) -> list[str]:
    """Return what `coupon --measured` prints."""
    return [
        f"The coupon of {reading.name} says (± 95 %):",
        *_numbers(reading),
        f"In {PRINTER}, for --printer: " + ", ".join(f"{row.key} = {row.value:g}" for row in reading.keys),
        "The silicone, once bar and pad are measured:",
        f"  {fit_bar_command(str(reading.folder / BAR_FORM))}",
        f"  {fit_pad_command(str(reading.folder / PAD_FORM), str(reading.folder / PAD_DESIGN))}",
    ]


def _numbers(reading: CouponReading) -> Iterator[str]:
    notches, crests, before = reading.notches, reading.crests, reading.before
    if notches and notches.growth:
        yield f"  growth         {notches.growth} a side; it was taken as {before.growth:g}"
        yield f"  notches        each off by {notches.scatter:.4f} mm (standard deviation)"
    elif notches:
        yield f"  growth         {no_growth_words()}"
    if notches and notches.gap:
        yield f"  narrowest gap  {notches.gap.value:g} mm or less; it was taken as {before.gap:g} mm"
    if crests:
        yield f"  crests         scatter {crests.sigma}; it was taken as {before.crest_sigma:g} mm"
        yield f"  all crests     off by {crests.offset}; it was taken as {before.crest_offset:g} mm"
    worst = max(feature.worst for feature in (notches, crests) if feature)
    word = "more" if worst > before.tolerance else "not more"
    yield f"  largest error  {worst:.3f} mm, {word} than the tolerance of {before.tolerance:g} mm"


def manifest(reading: CouponReading) -> dict[str, Any]:
    """Return what the manifest says of the result: all of it."""
    return reading.as_json()


def figures(_: CouponReading) -> dict[str, Callable[[], Any]]:
    """Return none."""
    return {}


def files(reading: CouponReading) -> dict[str, Writer]:
    """Return the writer of the printer.toml."""
    return {PRINTER: text(reading.to_toml)}
