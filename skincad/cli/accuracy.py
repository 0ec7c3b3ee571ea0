"""The command `accuracy`."""

from __future__ import annotations

from typing import Annotated

import skincad
from skincad.base.progress import stage_bar
from skincad.cli import options
from skincad.cli.options import option
from skincad.cli.printing import deliver, out_folder


def accuracy(
    source: options.DesignSource,
    settings: options.Settings = [],  # noqa: B006
    ladders: Annotated[
        list[str],
        option(
            "--ladder NAME", "Only these: tessellation, contact, circuit, slip, effects; repeat for several."
        ),
    ] = [],  # noqa: B006
    silicones: options.Silicones = None,
    repeats: Annotated[int, option("--repeats N", "Runs of each setting, whose median is taken.")] = 3,
    folder: options.Out = None,
    as_json: options.Json = False,
) -> None:
    """Show what accuracy costs in time on this design.

    Writes accuracy.csv and a diagram of error against time for each ladder of models and settings.
    """
    from skincad.outputs.studies import accuracy_names

    design = skincad.load(source, settings, silicones=silicones)
    target = out_folder(folder, design.name, "accuracy", accuracy_names(ladders))
    with stage_bar(1) as progress:
        result = skincad.accuracy(design, ladders, repeats=repeats, progress=progress)
    deliver(result, skincad.write(result, target), options.Display(as_json=as_json))
