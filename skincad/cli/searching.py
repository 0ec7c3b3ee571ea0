"""The commands that search: `solve`, `sweep`, `optimise`."""

from __future__ import annotations

import re
import shlex
from functools import partial
from pathlib import Path
from typing import Annotated

import skincad
from skincad.base.errors import InputError
from skincad.base.progress import stage_bar, step_bar
from skincad.cli import options
from skincad.cli.options import option
from skincad.cli.printing import as_typed, deliver, leave, out_folder, report, show


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
    hold: options.Hold = None,
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
            hold=hold,
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
    hold: options.Hold = None,
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
            hold=hold,
            folder=target,
            **vars(evaluations),
            tick=tick,
        )
    typed = as_typed(source, settings, force, **vars(workshop))
    deliver(result, skincad.write(result, target), display, typed)
    leave(result)


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
