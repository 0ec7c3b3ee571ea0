"""The command `coupon`: the calibration kit, which is made, measured and read back."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import skincad
from skincad.base.errors import InputError
from skincad.base.progress import stage_bar
from skincad.cli import options
from skincad.cli.options import argument, completes, option
from skincad.cli.printing import deliver, out_folder


def coupon(
    process: Annotated[
        str,
        argument("PROCESS", "fdm, sla, cnc, edm, or one of yours.", autocompletion=completes("processes")),
    ],
    silicone: Annotated[str | None, option("--silicone NAME", "What bars and pad are cast in.")] = None,
    measured: Annotated[
        Path | None, option("--measured DIR", "Read the forms in this folder back; printer.toml goes there.")
    ] = None,
    printer: options.Printer = None,
    silicones: options.Silicones = None,
    folder: options.Out = None,
    as_json: options.Json = False,
) -> None:
    """Measure your own machine and silicone once.

    Writes parts to make, molds to cast in, a sheet that says how, and forms to fill in. With --measured the
    filled-in forms become a printer.toml: how much material grows, the narrowest gap, the crests' scatter.
    """
    if measured is None:
        from skincad.fabrication.coupon import SILICONE
        from skincad.fabrication.coupon import coupon as kit_of

        kit = kit_of(process, silicone or SILICONE, printer=printer, silicones=silicones)
        target = out_folder(folder, f"coupon-{process}", kit.presenter().COMMAND, kit.files())
        with stage_bar(2) as progress:
            written = skincad.write(kit, target, progress=progress)
        deliver(kit, written, options.Display(as_json=as_json))
        return
    for name, value in (("silicone", silicone), ("silicones", silicones)):
        if value is not None:
            raise InputError(name, "is not used with --measured", str(value), "leave it out")
    from skincad.fabrication.coupon_reading import read_coupon

    reading = read_coupon(process, measured, printer=printer)
    deliver(reading, skincad.write(reading, folder or measured), options.Display(as_json=as_json))
