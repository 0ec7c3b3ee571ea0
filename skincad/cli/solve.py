"""The command `solve`."""

from __future__ import annotations

import re
import shlex
from functools import partial
from pathlib import Path
from typing import Annotated

import skincad
from skincad.base.errors import InputError
from skincad.base.progress import stage_bar
from skincad.cli import options
from skincad.cli.options import option
from skincad.cli.printing import as_typed, leave, report, show


def solve(
    source: options.Subject,
    target: Annotated[
        list[str],
        option(
            "--target KEY=VALUE",
            "What a result is to be, by its key in --json: all_touch_force=3, or a limit as "
            "all_touch_force<=3; repeat for several.",
        ),
    ],
    vary: Annotated[
        list[str],
        option(
            "--vary KEY=LOW:HIGH", "A key and its range, or its choices as A,B,C or all; repeat for several."
        ),
    ],
    settings: options.Settings = [],  # noqa: B006
    force: options.Force = None,
    model: Annotated[
        str | None,
        option("--model --tier", "The model of all checks; default: corrected, where that takes the design."),
    ] = None,
    tol: Annotated[float, option("--tol REL", "How near to the target is enough, relative.")] = 0.005,
    evaluations: Annotated[
        int | None, option("--evaluations N", "At most so many; default: 40, of several keys 100.")
    ] = None,
    *,
    workshop: options.Workshop,
    copy: Annotated[Path | None, option("-o --out FILE", "Write the first solution as a TOML file.")] = None,
    picture: Annotated[
        Path | None, option("--picture PNG", "Draw the result against the one key that is varied.")
    ] = None,
    display: options.Display,
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
    subject = load_subject(source, settings, **vars(workshop))
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
    typed = as_typed(source, settings, force, **vars(workshop))
    if file is not None:  # which has the values that the next step sets
        typed = partial(re.sub, r"\{design\}( --set [^\s`]+)*", shlex.quote(file).replace("\\", "/"))
    lines = report(solution, typed, verbose=display.verbose, more=written)
    show({**solution.as_json(), "file": file}, display.as_json, lines)
    leave(solution)
