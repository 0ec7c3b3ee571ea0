"""Output of what is measured: a machine on a coupon, a silicone on bar and pad, finished parts by a press."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from pathlib import Path
from typing import Any

import tomlkit

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
from skincad.fabrication.machine_rules import on_end
from skincad.inputs.silicone import Silicone
from skincad.material.laws import FITTED_SHARE
from skincad.material.modulus import MaterialFit
from skincad.outputs.delivery import Presentation, drawn, text
from skincad.outputs.tomls import ranged_toml
from skincad.solids.coupon import NOTCHES
from skincad.solids.plan import Part

SHEET = "coupon-sheet.md"
PRINTER = "printer.toml"


def _kit_files(kit: CouponKit) -> dict[str, Writer]:
    """The writer of each file."""
    return {
        **{f"{part.name}.step": partial(_step, part) for part in kit.parts},
        **{f"{part.name}.stl": partial(_prints, kit, [part]) for part in kit.parts},
        "coupon.3mf": partial(_prints, kit, kit.parts),
        SHEET: text(lambda: coupon_sheet(kit)),
        **{name: text(partial(str, form)) for name, form in coupon_forms(kit).items()},
        PAD_DESIGN: text(kit.pad.to_toml),
    }


def _step(part: Part, path: Path) -> None:
    from skincad.outputs.solid_files import write_step
    from skincad.solids.occ import workplane

    write_step(workplane(part), path)


def _prints(kit: CouponKit, parts: Iterable[Part], path: Path) -> None:
    """Parts as they are printed: one as STL, all as 3MF."""
    from skincad.fabrication.meshes import laid, mesh
    from skincad.outputs.solid_files import write_3mf, write_stl

    turned = {part: laid(mesh(part, kit.process.chord), on_end(part, kit.process)) for part in parts}
    if path.suffix == ".stl":
        (shape,) = turned.values()
        write_stl(shape, path)
    else:
        write_3mf({part.name: (shape, part.colour) for part, shape in turned.items()}, path)


def toml_lines(fit: MaterialFit) -> list[str]:
    """Return the lines of a design's TOML."""
    modulus = ["[material]", f"young_modulus = {ranged_toml(fit.ranged)}"]
    if fit.law is None:
        return modulus
    table = tomlkit.dumps({key: _rounded(value) for key, value in fit.law.model_dump().items()})
    return [*modulus, "", "[material.law]", *table.splitlines()]


def _rounded(value: Any) -> Any:
    """Constants to 6 digits: no test says more."""
    if isinstance(value, tuple):
        return [_rounded(item) for item in value]
    return float(f"{value:.6g}") if isinstance(value, float) else value


FIT = Presentation(
    COMMAND="fit-material",
    words="fit-material.txt",
    facts={"FITTED_SHARE": FITTED_SHARE, "POISSON_RATIO": Silicone().poisson_ratio, "toml_lines": toml_lines},
    writers=lambda fit: {"material.toml": text(lambda: "\n".join(toml_lines(fit)) + "\n")},
    figures=drawn("fit.png", "results:fit_figure"),
)
ACCEPTANCE = Presentation(
    COMMAND="accept",
    words="accept.txt",
    writers=lambda result: {"accept.txt": text(lambda: f"{result}\n")},
    figures=drawn("accept.png", "results:acceptance_figure"),
)
TAPS = Presentation(COMMAND="listen", words="taps.txt")
# a folder in which the same command left forms keeps them: this result has its own manifest


KIT = Presentation(
    COMMAND="coupon",
    words="coupon.txt",
    facts={"SHEET": SHEET, "read_command": read_command},
    writers=_kit_files,
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
        "WIDEST_NOTCH": NOTCHES[-1],
    },
    writers=lambda reading: {PRINTER: text(reading.to_toml)},
)
