"""The command `optimise`."""

from __future__ import annotations

from typing import Annotated

import skincad
from skincad.base.progress import step_bar
from skincad.cli.options import (
    DaskOption,
    FreshOption,
    JsonOption,
    OutOption,
    SetOption,
    WorkersOption,
    deliver,
    leave,
    out_folder,
    source_argument,
)


def optimise(
    source: Annotated[str, source_argument("STUDY", "studies")],
    settings: SetOption = [],  # noqa: B006
    workers: WorkersOption = 1,
    dask: DaskOption = None,
    fresh: FreshOption = False,
    folder: OutOption = None,
    as_json: JsonOption = False,
) -> None:
    """Find the best design of a study, or the front of several objectives.

    The study names what is varied, what is to be small or large, and what must hold. Cheap models propose,
    a better one judges. Designs, a table, pictures and a page appear in the output folder; after Ctrl-C the
    same command goes on where it was.
    """
    from skincad.outputs.studies import front_names

    study = skincad.load_study(source, settings)
    target = out_folder(folder, study.name, "optimise", front_names())
    with step_bar(study.evaluations) as tick:
        result = skincad.optimise(study, folder=target, fresh=fresh, workers=workers, dask=dask, tick=tick)
    deliver(result, as_json, skincad.write(result, target))
    leave(result)
