"""The commands of studies: solve, sweep, optimise."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import skincad
from skincad.base.bars import stage_bar, step_bar
from skincad.base.errors import InputError
from skincad.options import (
    JsonOption,
    OutOption,
    PrinterOption,
    SetOption,
    SiliconesOption,
    deliver,
    show,
    source_argument,
)

SubjectArgument = Annotated[
    str,
    typer.Argument(
        metavar="DESIGN", help="A template's name or a TOML file: a design, a scene or a circuit."
    ),
]
WorkersOption = Annotated[int, typer.Option("--workers", metavar="N", help="Processes on this machine.")]
DaskOption = Annotated[
    str | None,
    typer.Option("--dask", metavar="ADDRESS", help="A Dask cluster's scheduler, as tcp://host:8786."),
]
FreshOption = Annotated[
    bool, typer.Option("--fresh/--resume", help="Ask all anew, or what the folder's log has not.")
]
ForceOption = Annotated[
    float | None, typer.Option("--force", metavar="N", help="Normal force; default: the design's.")
]


def solve(
    source: SubjectArgument,
    target: Annotated[
        list[str],
        typer.Option(
            "--target",
            metavar="KEY=VALUE",
            help="What a result is to be, by its key in --json: all_touch_force=3; repeat for several.",
        ),
    ],
    vary: Annotated[
        list[str],
        typer.Option(
            "--vary",
            metavar="KEY=LOW:HIGH",
            help="A key and its range, or its choices as A,B,C or all; repeat for several.",
        ),
    ],
    settings: SetOption = [],  # noqa: B006
    force: ForceOption = None,
    tier: Annotated[
        str | None,
        typer.Option(
            "--tier", help="The model of all checks; default: corrected, where that takes the design."
        ),
    ] = None,
    tol: Annotated[
        float, typer.Option("--tol", metavar="REL", help="How near to the target is enough, relative.")
    ] = 0.005,
    evaluations: Annotated[
        int | None,
        typer.Option("--evaluations", metavar="N", help="At most so many; default: 40, of several keys 100."),
    ] = None,
    printer: PrinterOption = None,
    silicones: SiliconesOption = None,
    copy: Annotated[
        Path | None,
        typer.Option("-o", "--out", metavar="FILE", help="Write the first solution as a TOML file."),
    ] = None,
    picture: Annotated[
        Path | None,
        typer.Option("--picture", metavar="PNG", help="Draw the result against the one key that is varied."),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Find the values that give a wanted result.

    Any number of a design, scene or circuit may be varied, and any number of its result wanted. With one
    key its whole range is searched before it is said that no value exists; with several the least change is
    looked for.
    """
    from skincad.base.freshfile import checked_fresh, fresh
    from skincad.studies.knobs import knobs, texts
    from skincad.studies.subject import load_subject

    for path, suffix, key in ((copy, ".toml", "copy"), (picture, ".png", "picture")):
        if path is not None:
            checked_fresh(path, suffix, key)
    wishes = {key: _number(key, text) for key, text in texts(target, "target").items()}
    varied = texts(vary, "vary")
    subject = load_subject(source, settings, printer=printer, silicones=silicones)
    if picture is not None and (len(varied) > 1 or knobs(subject, varied)[0].choices):
        raise InputError("picture", "is drawn of one key with a range", remedy="leave it out")
    with stage_bar(8) as progress:
        found = skincad.solve(
            subject,
            wishes,
            varied,
            tier=tier,
            tol=tol,
            force=force,
            evaluations=evaluations,
            progress=progress,
        )
    written = []
    if copy is not None and found.solutions:
        from skincad.outputs.solutions import write_solution

        write_solution(found, copy, source)
        written.append(f"\nwritten to {copy}")
    if picture is not None and (draw := found.files().get("solve.png")):
        with fresh(picture, "picture") as staging:
            draw(staging)
        written.append(f"\n  picture        {picture}")
    file = str(copy) if copy and found.solutions else None
    show({**found.as_json(), "file": file}, as_json, f"{found}{''.join(written)}")
    raise typer.Exit(0 if found.feasible else 1)


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
    tier: Annotated[
        str | None, typer.Option("--tier", help="The model of all checks; default: linear.")
    ] = None,
    tol: Annotated[
        float | None, typer.Option("--tol", metavar="REL", help="Relative error of each mesh to meet.")
    ] = None,
    workers: WorkersOption = 1,
    dask: DaskOption = None,
    fresh: FreshOption = False,
    printer: PrinterOption = None,
    silicones: SiliconesOption = None,
    folder: OutOption = None,
    as_json: JsonOption = False,
) -> None:
    """Evaluate many designs side by side, and rank them.

    A table, pictures and a page appear in the output folder. Each finished evaluation goes into
    evaluations.jsonl there at once: after Ctrl-C the same command goes on where it was.
    """
    from skincad.outputs.delivery import ready
    from skincad.outputs.sweeps import COMMAND, names
    from skincad.studies.knobs import texts
    from skincad.studies.subject import load_subject
    from skincad.studies.sweeping import points_of

    varied, ranks = texts(vary, "vary"), texts(rank, "rank")
    subject = load_subject(source, settings, printer=printer, silicones=silicones)
    count = len(points_of(subject, varied, sample))
    target = folder or Path("out") / subject.name
    ready(target, COMMAND, names())
    with step_bar(count) as tick:
        found = skincad.sweep(
            subject,
            varied,
            sample=sample,
            rank=ranks,  # type: ignore[arg-type]
            tier=tier,
            tol=tol,
            force=force,
            folder=target,
            fresh=fresh,
            workers=workers,
            dask=dask,
            tick=tick,
        )
    deliver(found, as_json, skincad.write(found, target))
    raise typer.Exit(0 if found.refused < len(found.rows) else 1)


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
    from skincad.outputs.delivery import ready
    from skincad.outputs.optimisations import COMMAND, names

    study = skincad.load_study(source, settings)
    target = folder or Path("out") / study.name
    ready(target, COMMAND, names())
    with step_bar(study.evaluations) as tick:
        found = skincad.optimise(study, folder=target, fresh=fresh, workers=workers, dask=dask, tick=tick)
    deliver(found, as_json, skincad.write(found, target))
    raise typer.Exit(0 if found.feasible else 1)


def _number(key: str, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise InputError(f"target {key}", "must be a number", text) from None
