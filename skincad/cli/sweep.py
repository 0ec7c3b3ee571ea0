"""The command `sweep`."""

from __future__ import annotations

from typing import Annotated

import typer

import skincad
from skincad.base.progress import step_bar
from skincad.cli.options import (
    DaskOption,
    ForceOption,
    FreshOption,
    GrippersOption,
    JsonOption,
    OutOption,
    PrinterOption,
    SetOption,
    SiliconesOption,
    SubjectArgument,
    VerboseOption,
    WorkersOption,
    as_typed,
    deliver,
    leave,
    out_folder,
)


def sweep(
    source: SubjectArgument,
    vary: Annotated[
        list[str],
        typer.Option(
            "--vary",
            metavar="KEY=LOW:HIGH:N",
            help="A key and its N values, or its choices as A,B,C or all; repeat for several.",
        ),
    ],
    settings: SetOption = [],  # noqa: B006
    sample: Annotated[
        int | None,
        typer.Option(
            "--sample", metavar="N", help="N points spread over the ranges (Sobol), not their grid."
        ),
    ] = None,
    rank: Annotated[
        list[str],
        typer.Option(
            "--rank",
            metavar="KEY=min|max",
            help="What rows are ranked by; default of a design: all_touch_force=min; twice: their front too.",
        ),
    ] = [],  # noqa: B006
    force: ForceOption = None,
    model: Annotated[
        str | None,
        typer.Option("--model", "--tier", help="The model of all checks; default: linear."),
    ] = None,
    tol: Annotated[
        float | None, typer.Option("--tol", metavar="REL", help="Relative error of each mesh to meet.")
    ] = None,
    workers: WorkersOption = 1,
    dask: DaskOption = None,
    fresh: FreshOption = False,
    printer: PrinterOption = None,
    silicones: SiliconesOption = None,
    grippers: GrippersOption = None,
    folder: OutOption = None,
    verbose: VerboseOption = False,
    as_json: JsonOption = False,
) -> None:
    """Evaluate many designs side by side, and rank them.

    A table, pictures and a page appear in the output folder. Each finished evaluation goes into
    evaluations.jsonl there at once: after Ctrl-C the same command goes on where it was.
    """
    from skincad.outputs.studies import sweep_names
    from skincad.studies.subject import load_subject, texts
    from skincad.studies.sweeping import points_of

    varied, ranks = texts(vary, "vary"), texts(rank, "rank")
    subject = load_subject(source, settings, printer=printer, silicones=silicones, grippers=grippers)
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
            fresh=fresh,
            workers=workers,
            dask=dask,
            tick=tick,
        )
    typed = as_typed(source, settings, force, printer=printer, silicones=silicones, grippers=grippers)
    deliver(result, as_json, skincad.write(result, target), typed, verbose=verbose)
    leave(result)
