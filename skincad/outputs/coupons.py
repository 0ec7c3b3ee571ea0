"""A coupon as files: its parts as STEP and STL, all of them as one 3MF, sheet and forms."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from skincad.base.result import Writer
from skincad.fabrication.coupon_kit import CouponKit
from skincad.fabrication.coupon_sheet import PAD_DESIGN, coupon_forms, coupon_sheet, read_command
from skincad.fabrication.rules_of_layers import on_end
from skincad.outputs.delivery import text
from skincad.solids.plan import Part

COMMAND = "coupon"
SHEET = "coupon-sheet.md"


def lines(kit: CouponKit) -> list[str]:
    """Return what `coupon` prints."""
    poured = " and ".join(f"{grams:.3g} g for {name}" for name, grams in kit.grams.items())
    return [
        f"The coupon of {kit.name}, to make, cast in {kit.silicone.name} and measure:",
        *(f"  {part.name:14} {part.volume:10.2f} mm3" for part in kit.parts),
        f"  silicone       {poured}",
        f"{SHEET} says how; then: {read_command(kit)}",
    ]


def manifest(kit: CouponKit) -> dict[str, Any]:
    """Return what the manifest says of the coupon."""
    return {"name": kit.name, "silicone": kit.silicone.name}


def figures(_: CouponKit) -> dict[str, Callable[[], Any]]:
    """Return none."""
    return {}


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
    from skincad.outputs.export import write_step
    from skincad.solids.occ import workplane

    write_step(workplane(part), path)


def _oriented_mesh(kit: CouponKit, part: Part) -> Any:
    from skincad.fabrication.meshes import laid, mesh

    return laid(mesh(part, kit.process.chord), on_end(part, kit.process))


def _stl(kit: CouponKit, part: Part, path: Path) -> None:
    from skincad.outputs.export import write_stl

    write_stl(_oriented_mesh(kit, part), path)


def _plate(kit: CouponKit, path: Path) -> None:
    from skincad.outputs.export import write_3mf

    write_3mf({part.name: (_oriented_mesh(kit, part), part.colour) for part in kit.parts}, path)
