"""Output of `coupon`: its parts, sheet and forms as files; and of a measured one words and a printer.toml."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

from skincad.base.result import Writer
from skincad.fabrication.coupon import (
    BAR_FORM,
    PAD_DESIGN,
    PAD_FORM,
    CouponKit,
    coupon_forms,
    coupon_sheet,
    fit_bar_command,
    fit_pad_command,
    read_command,
)
from skincad.fabrication.coupon_reading import CouponReading, no_growth_words
from skincad.fabrication.machine_rules import on_end
from skincad.outputs.delivery import Presentation, text
from skincad.solids.plan import Part

COMMAND = "coupon"
SHEET = "coupon-sheet.md"
PRINTER = "printer.toml"


def lines(kit: CouponKit) -> list[str]:
    """Return what `coupon` prints."""
    poured = " and ".join(f"{grams:.3g} g for {name}" for name, grams in kit.grams.items())
    return [
        f"The coupon of {kit.name}, to make, cast in {kit.silicone.name} and measure:",
        *(f"  {part.name:14} {part.volume:10.2f} mm3" for part in kit.parts),
        f"  silicone       {poured}",
        f"{SHEET} says how; then: {read_command(kit)}",
    ]


def files(kit: CouponKit) -> dict[str, Writer]:
    """Return the writer of each file."""
    return {
        **{f"{part.name}.step": partial(_step, part) for part in kit.parts},
        **{f"{part.name}.stl": partial(_stl, kit, part) for part in kit.parts},
        "coupon.3mf": partial(_plate, kit),
        SHEET: text(lambda: coupon_sheet(kit)),
        **{name: text(partial(str, form)) for name, form in coupon_forms(kit).items()},
        PAD_DESIGN: text(kit.pad.to_toml),
    }


def _step(part: Part, path: Path) -> None:
    from skincad.outputs.solid_files import write_step
    from skincad.solids.occ import workplane

    write_step(workplane(part), path)


def _oriented_mesh(kit: CouponKit, part: Part) -> Any:
    from skincad.fabrication.meshes import laid, mesh

    return laid(mesh(part, kit.process.chord), on_end(part, kit.process))


def _stl(kit: CouponKit, part: Part, path: Path) -> None:
    from skincad.outputs.solid_files import write_stl

    write_stl(_oriented_mesh(kit, part), path)


def _plate(kit: CouponKit, path: Path) -> None:
    from skincad.outputs.solid_files import write_3mf

    write_3mf({part.name: (_oriented_mesh(kit, part), part.colour) for part in kit.parts}, path)


# a folder in which the same command left forms keeps them: this result has its own manifest


def reading_lines(reading: CouponReading) -> list[str]:
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


KIT = Presentation(
    COMMAND=COMMAND,
    lines=lines,
    files=files,
    manifest=lambda kit: {"name": kit.name, "silicone": kit.silicone.name},
)
READING = Presentation(
    COMMAND="coupon-reading", lines=reading_lines, files=lambda reading: {PRINTER: text(reading.to_toml)}
)
