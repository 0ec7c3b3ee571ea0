"""The command `solve`."""

from __future__ import annotations

import re
import shlex
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

import skincad
from skincad.base.errors import InputError
from skincad.base.progress import stage_bar
from skincad.cli.options import (
    ForceOption,
    GrippersOption,
    JsonOption,
    PrinterOption,
    SetOption,
    SiliconesOption,
    SubjectArgument,
    VerboseOption,
    as_typed,
    leave,
    report,
    show,
)


def solve(
    source: SubjectArgument,
    target: Annotated[
        list[str],
        typer.Option(
            "--target",
            metavar="KEY=VALUE",
            help="What a result is to be, by its key in --json: all_touch_force=3, or a limit as "
            "all_touch_force<=3; repeat for several.",
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
    model: Annotated[
        str | None,
        typer.Option(
            "--model",
            "--tier",
            help="The model of all checks; default: corrected, where that takes the design.",
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
    grippers: GrippersOption = None,
    copy: Annotated[
        Path | None,
        typer.Option("-o", "--out", metavar="FILE", help="Write the first solution as a TOML file."),
    ] = None,
    picture: Annotated[
        Path | None,
        typer.Option("--picture", metavar="PNG", help="Draw the result against the one key that is varied."),
    ] = None,
    verbose: VerboseOption = False,
    as_json: JsonOption = False,
) -> None:
    """Find the values that give a wanted result.

    Any number of a design, scene or circuit may be varied, and any number of its result wanted. With one
    key its whole range is searched before it is said that no value exists; with several the least change is
    looked for.
    """
    from skincad.base.outfolder import checked_fresh
    from skincad.studies.subject import knobs, load_subject, texts

    for path, suffix, key in ((copy, ".toml", "copy"), (picture, ".png", "picture")):
        if path is not None:
            checked_fresh(path, suffix, key)
    wishes = dict[str, float | str]()
    for typed_key, text in texts(target, "target").items():
        key = typed_key.rstrip("<> ")
        if key in wishes:
            raise InputError("target", f"names {key} twice", remedy="give one; check the other afterwards")
        side = typed_key.removeprefix(key).strip()
        wishes[key] = f"{side}={text}" if side else text
    varied = texts(vary, "vary")
    subject = load_subject(source, settings, printer=printer, silicones=silicones, grippers=grippers)
    if picture is not None and (len(varied) > 1 or knobs(subject, varied)[0].choices):
        raise InputError("picture", "is drawn of one key with a range", remedy="leave it out")
    with stage_bar(8) as progress:
        solution = skincad.solve(
            subject,
            wishes,
            varied,
            model=model,
            tol=tol,
            force=force,
            evaluations=evaluations,
            progress=progress,
        )
    written = []
    if copy is not None and solution.solutions:
        from skincad.outputs.studies import write_solution

        write_solution(solution, copy, source)
        written.append(f"  written        {copy}")
    if picture is not None and skincad.save_picture(solution, picture, key="picture"):
        written.append(f"  picture        {picture}")
    file = str(copy) if copy and solution.solutions else None
    typed = as_typed(source, settings, force, printer=printer, silicones=silicones, grippers=grippers)
    if file is not None:  # which has the values that the next step sets
        typed = partial(re.sub, r"\{design\}( --set [^\s`]+)*", shlex.quote(file).replace("\\", "/"))
    lines = report(solution, typed, verbose=verbose, more=written)
    show({**solution.as_json(), "file": file}, as_json, "\n".join(lines))
    leave(solution)
