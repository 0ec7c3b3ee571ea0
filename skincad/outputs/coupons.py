"""Output of `coupon`: its parts, sheet and forms as files; and of a measured one words and a printer.toml."""

from __future__ import annotations

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
from skincad.fabrication.coupon_reading import no_growth_words
from skincad.fabrication.machine_rules import on_end
from skincad.outputs.delivery import Presentation, text
from skincad.solids.plan import Part

COMMAND = "coupon"
SHEET = "coupon-sheet.md"
PRINTER = "printer.toml"


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


KIT = Presentation(
    COMMAND=COMMAND,
    words="coupon.txt",
    facts={"SHEET": SHEET, "read_command": read_command},
    files=files,
    manifest=lambda kit: {"name": kit.name, "silicone": kit.silicone.name},
)
READING = Presentation(
    COMMAND="coupon-reading",
    words="coupon-reading.txt",
    facts={
        "BAR_FORM": BAR_FORM,
        "PAD_DESIGN": PAD_DESIGN,
        "PAD_FORM": PAD_FORM,
        "PRINTER": PRINTER,
        "fit_bar_command": fit_bar_command,
        "fit_pad_command": fit_pad_command,
        "no_growth_words": no_growth_words,
    },
    files=lambda reading: {PRINTER: text(reading.to_toml)},
)
