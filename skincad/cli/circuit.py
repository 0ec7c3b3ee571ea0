"""The command `circuit`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import skincad
from skincad.base.progress import stage_bar
from skincad.cli import options
from skincad.cli.options import option
from skincad.cli.printing import deliver, out_folder


def circuit(
    source: Annotated[str, options.argument("CIRCUIT", autocompletion=options.completes("circuits"))],
    settings: Annotated[list[str], option("--set KEY=VALUE", "Override a key: amplifier.gain=1e6.")] = [],  # noqa: B006
    measured: Annotated[
        Path | None,
        option("--measured CSV", "Calibrate to a measured curve: columns frequency_Hz, gain_dB; any level."),
    ] = None,
    folder: options.Out = None,
    as_json: options.Json = False,
) -> None:
    """Show how film and amplifier respond to frequency.

    Prints the gain, its cut-off and its slopes, and writes gain.csv, gain.png and netlist.cir; with
    --measured also the calibrated circuit.
    """
    from skincad.outputs import gains

    loaded = skincad.load_circuit(source, settings)
    target = out_folder(folder, loaded.name, gains.COMMAND, gains.names(measured is not None))
    with stage_bar(2) as progress:
        result = skincad.gain(loaded, measured, progress)
    deliver(result, skincad.write(result, target), options.Display(as_json=as_json))
