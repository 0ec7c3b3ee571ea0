"""The command `accuracy`."""

from __future__ import annotations

from typing import Annotated

import typer

import skincad
from skincad.base.progress import stage_bar
from skincad.cli.options import (
    DesignArgument,
    JsonOption,
    OutOption,
    SetOption,
    SiliconesOption,
    deliver,
    out_folder,
)


def accuracy(
    source: DesignArgument,
    settings: SetOption = [],  # noqa: B006
    ladders: Annotated[
        list[str],
        typer.Option(
            "--ladder",
            metavar="NAME",
            help="Only these: tessellation, contact, circuit, slip, effects; repeat for several.",
        ),
    ] = [],  # noqa: B006
    silicones: SiliconesOption = None,
    repeats: Annotated[
        int, typer.Option("--repeats", metavar="N", help="Runs of each setting, whose median is taken.")
    ] = 3,
    folder: OutOption = None,
    as_json: JsonOption = False,
) -> None:
    """Show what accuracy costs in time on this design.

    Writes accuracy.csv and a diagram of error against time for each ladder of models and settings.
    """
    from skincad.outputs.studies import accuracy_names

    design = skincad.load(source, settings, silicones=silicones)
    target = out_folder(folder, design.name, "accuracy", accuracy_names(ladders))
    with stage_bar(1) as progress:
        result = skincad.accuracy(design, ladders, repeats=repeats, progress=progress)
    deliver(result, as_json, skincad.write(result, target))
