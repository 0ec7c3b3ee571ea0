"""The command `check`."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import skincad
from skincad.base.errors import InputError
from skincad.base.progress import one_by_one, stage_bar
from skincad.cli.options import (
    AdviceOption,
    BudgetOption,
    DesignArgument,
    ForceOption,
    GrippersOption,
    JsonOption,
    ModelOption,
    PrinterOption,
    SetOption,
    SiliconesOption,
    leave,
    say,
    show,
)

if TYPE_CHECKING:
    from skincad.inputs.design import Design
    from skincad.mechanics.verdict import ContactCheck

ADVICE_STAGES = 9  # of its bar at first: checks and searches for them, about two or three a change


def check(
    source: DesignArgument,
    settings: SetOption = [],  # noqa: B006
    force: ForceOption = None,
    tol: Annotated[
        float | None,
        typer.Option("--tol", metavar="REL", help="Relative error to meet; with --model, the mesh's alone."),
    ] = None,
    budget: BudgetOption = None,
    measured: Annotated[
        Path | None, typer.Option("--measured", metavar="CSV", help="Judge a cast part by its crest heights.")
    ] = None,
    model: ModelOption = "auto",
    printer: PrinterOption = None,
    silicones: SiliconesOption = None,
    grippers: GrippersOption = None,
    stress: Annotated[
        Path | None,
        typer.Option("--stress", metavar="PNG", help="Draw the stress at S1 and S2 of each ridge."),
    ] = None,
    tangential: Annotated[
        float | None,
        typer.Option(
            "--pull",
            metavar="N",
            help="With --stress: tangential force; default: a quarter of the normal one.",
        ),
    ] = None,
    advice: AdviceOption = None,
    as_json: JsonOption = False,
) -> None:
    """Say whether all ridges touch a plate.

    Prints the force it takes, the approach and the force on each ridge too, each with its error.
    """
    from skincad.base.outfolder import checked_fresh

    if tangential is not None and stress is None:
        raise InputError("tangential", "needs --stress", tangential, "name the picture with --stress")
    if stress is not None:
        checked_fresh(stress, ".png", "stress")
    design = skincad.load(source, settings, printer=printer, silicones=silicones, grippers=grippers)
    if stress is not None:
        from skincad.mechanics.film.stress import check_request

        check_request(design, design.contact.force if force is None else force, (tangential or 0.0,))
    with stage_bar(4) as progress:
        result = skincad.check(
            design, force=force, tol=tol, budget=budget, model=model, measured=measured, progress=progress
        )
        films = None
        if stress is not None:
            films = skincad.film_stress(design, result.force, tangential, progress=progress)
            skincad.save_picture(films, stress, key="stress")
    if not as_json:
        say(str(result) if films is None else f"{result}\n{films}\n  picture        {stress}")
    if measured is None:
        result = advised(design, result, advice, budget, as_json)
    if as_json:
        show(result.as_json() | (films.as_json() if films else {}), True, "")
    leave(result)


def advised(
    design: Design, check: ContactCheck, wanted: bool | None, budget: float | None, quiet: bool
) -> ContactCheck:
    """Return a check with its advice, each line of which is printed when it is known, unless `quiet`."""
    from skincad.outputs.checks import advice_lines
    from skincad.studies.advice import advising, seconds_for_advice

    seconds = seconds_for_advice(check, wanted, budget)
    if not seconds:
        return check
    result, printed = check, 0
    for result in one_by_one(ADVICE_STAGES, partial(advising, design, check, budget=seconds)):
        lines = advice_lines(result)[printed:]
        printed += len(lines)
        if lines and not quiet:
            say("\n".join(lines))
    return result
