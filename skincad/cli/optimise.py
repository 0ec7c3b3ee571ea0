"""The command `optimise`."""

from __future__ import annotations

from typing import Annotated

import skincad
from skincad.base.progress import step_bar
from skincad.cli import options
from skincad.cli.printing import deliver, leave, out_folder


def optimise(
    source: Annotated[str, options.argument("STUDY", autocompletion=options.completes("studies"))],
    settings: options.Settings = [],  # noqa: B006
    *,
    evaluations: options.Evaluations,
    folder: options.Out = None,
    as_json: options.Json = False,
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
        result = skincad.optimise(study, folder=target, **vars(evaluations), tick=tick)
    deliver(result, skincad.write(result, target), options.Display(as_json=as_json))
    leave(result)
