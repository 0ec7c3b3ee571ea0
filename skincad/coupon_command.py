"""The command of the calibration kit: coupon, which is made, measured and read back."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import skincad
from skincad.base.bars import stage_bar
from skincad.base.errors import InputError
from skincad.options import JsonOption, OutOption, PrinterOption, SiliconesOption, deliver


def _names(incomplete: str) -> list[str]:
    """What completes a process."""
    from skincad.inputs.process import PROCESSES

    return [name for name in PROCESSES if name.startswith(incomplete)]


def coupon(
    process: Annotated[
        str,
        typer.Argument(metavar="PROCESS", help="fdm, sla, cnc, edm, or one of yours.", autocompletion=_names),
    ],
    silicone: Annotated[
        str | None, typer.Option("--silicone", metavar="NAME", help="What bars and pad are cast in.")
    ] = None,
    measured: Annotated[
        Path | None,
        typer.Option(
            "--measured", metavar="DIR", help="Read the forms in this folder back; printer.toml goes there."
        ),
    ] = None,
    printer: PrinterOption = None,
    silicones: SiliconesOption = None,
    folder: OutOption = None,
    as_json: JsonOption = False,
) -> None:
    """Measure your own machine and silicone once.

    Writes parts to make, molds to cast in, a sheet that says how, and forms to fill in. With --measured the
    filled-in forms become a printer.toml: how much material grows, the narrowest gap, the crests' scatter.
    """
    from skincad.outputs.delivery import ready

    if measured is None:
        from skincad.fabrication.coupon_kit import SILICONE
        from skincad.fabrication.coupon_kit import coupon as kit_of
        from skincad.outputs.coupons import COMMAND, files

        kit = kit_of(process, silicone or SILICONE, printer=printer, silicones=silicones)
        target = folder or Path("out") / f"coupon-{process}"
        ready(target, COMMAND, files(kit))
        with stage_bar(2) as progress:
            written = skincad.write(kit, target, progress=progress)
        deliver(kit, as_json, written)
        return
    for name, given in (("silicone", silicone), ("silicones", silicones)):
        if given is not None:
            raise InputError(name, "is not used with --measured", str(given), "leave it out")
    from skincad.fabrication.coupon_reading import read_coupon

    found = read_coupon(process, measured, printer=printer)
    deliver(found, as_json, skincad.write(found, folder or measured))
