"""The command `circuit`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import skincad
from skincad.base.progress import stage_bar
from skincad.cli.options import JsonOption, OutOption, deliver, out_folder, source_argument


def circuit(
    source: Annotated[str, source_argument("CIRCUIT", "circuits")],
    settings: Annotated[
        list[str],
        typer.Option("--set", metavar="KEY=VALUE", help="Override a key: amplifier.gain=1e6."),
    ] = [],  # noqa: B006
    measured: Annotated[
        Path | None,
        typer.Option(
            "--measured",
            metavar="CSV",
            help="Calibrate to a measured curve: columns frequency_Hz, gain_dB; any level.",
        ),
    ] = None,
    folder: OutOption = None,
    as_json: JsonOption = False,
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
    deliver(result, as_json, skincad.write(result, target))
