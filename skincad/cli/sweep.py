"""The command `sweep`."""

from __future__ import annotations

from typing import Annotated

import skincad
from skincad.base.progress import step_bar
from skincad.cli import options
from skincad.cli.options import option
from skincad.cli.printing import as_typed, deliver, leave, out_folder


def sweep(
    source: options.Subject,
    vary: Annotated[
        list[str],
        option(
            "--vary KEY=LOW:HIGH:N",
            "A key and its N values, or its choices as A,B,C or all; repeat for several.",
        ),
    ],
    settings: options.Settings = [],  # noqa: B006
    sample: Annotated[
        int | None, option("--sample N", "N points spread over the ranges (Sobol), not their grid.")
    ] = None,
    rank: Annotated[
        list[str],
        option(
            "--rank KEY=min|max",
            "What rows are ranked by; default of a design: all_touch_force=min; twice: their front too.",
        ),
    ] = [],  # noqa: B006
    force: options.Force = None,
    model: Annotated[
        str | None, option("--model --tier", "The model of all checks; default: linear.")
    ] = None,
    tol: Annotated[float | None, option("--tol REL", "Relative error of each mesh to meet.")] = None,
    *,
    evaluations: options.Evaluations,
    workshop: options.Workshop,
    folder: options.Out = None,
    display: options.Display,
) -> None:
    """Evaluate many designs side by side, and rank them.

    A table, pictures and a page appear in the output folder. Each finished evaluation goes into
    evaluations.jsonl there at once: after Ctrl-C the same command goes on where it was.
    """
    from skincad.outputs.studies import sweep_names
    from skincad.studies.subject import load_subject, texts
    from skincad.studies.sweeping import points_of

    varied, ranks = texts(vary, "vary"), texts(rank, "rank")
    subject = load_subject(source, settings, **vars(workshop))
    count = len(points_of(subject, varied, sample))
    target = out_folder(folder, subject.name, "sweep", sweep_names())
    with step_bar(count) as tick:
        result = skincad.sweep(
            subject,
            varied,
            sample=sample,
            rank=ranks,  # type: ignore[arg-type]
            model=model,
            tol=tol,
            force=force,
            folder=target,
            **vars(evaluations),
            tick=tick,
        )
    typed = as_typed(source, settings, force, **vars(workshop))
    deliver(result, skincad.write(result, target), display, typed)
    leave(result)
