"""The commands that make a design: make, and watch, which makes it again at each save."""

from __future__ import annotations

import webbrowser
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import skincad
from skincad.base.bars import one_by_one, stage_bar
from skincad.base.errors import InputError, RefusedError, shown
from skincad.options import (
    AdviceOption,
    BudgetOption,
    DesignArgument,
    JsonOption,
    OutOption,
    PrinterOption,
    ScenesOption,
    SetOption,
    SiliconesOption,
    TierOption,
    deliver,
    say,
    simulated,
)

if TYPE_CHECKING:
    from skincad.inputs.design import Design
    from skincad.mechanics.verdict import ContactCheck

VIEW = "view.html"
ADVICE_STAGES = 9  # of its bar at first: checks and searches for them, about two or three a change
FormatOption = Annotated[
    list[str],
    typer.Option(
        "--format", metavar="KIND", help="Only files of this kind, as step, stl or 3mf; repeat for several."
    ),
]
OpenOption = Annotated[bool, typer.Option("--open", help="Open view.html, the design to turn, in a browser.")]


def make(
    source: DesignArgument,
    settings: SetOption = [],  # noqa: B006
    folder: OutOption = None,
    formats: FormatOption = [],  # noqa: B006
    strict: Annotated[bool, typer.Option("--strict", help="Warnings count as failures.")] = False,
    checked: Annotated[
        bool, typer.Option("--check/--no-check", help="Ask whether all ridges touch, or leave that out.")
    ] = True,
    tier: TierOption = "auto",
    budget: BudgetOption = None,
    preview: Annotated[
        bool,
        typer.Option(
            "--preview",
            help="Meshes, pictures and findings alone, in seconds: no check, STEP only by --format step.",
        ),
    ] = False,
    opened: OpenOption = False,
    advice: AdviceOption = None,
    scenes: ScenesOption = [],  # noqa: B006
    printer: PrinterOption = None,
    silicones: SiliconesOption = None,
    as_json: JsonOption = False,
) -> None:
    """Make skin and mold, check both, and write all files.

    STEP, STL, 3MF, DXF, SVG, a picture, a casting sheet and a report appear in the output folder, all of
    them or none.
    """
    from skincad.fabrication.making import STAGES
    from skincad.outputs.delivery import of_formats, ready
    from skincad.outputs.makes import COMMAND, names

    design = skincad.load(source, settings, printer=printer, silicones=silicones)
    target = folder or Path("out") / design.name
    _check_opened(opened, formats)
    solids = not preview or "step" in formats
    ready(target, COMMAND, of_formats(names(design, solids, preview), formats))
    felt = simulated(scenes, design, preview)
    with stage_bar(len(STAGES)) as progress:
        found = skincad.make(
            design,
            strict=strict,
            checked=checked,
            tier=tier,
            budget=budget,
            preview=preview,
            solids=solids,
            scenes=felt,
            progress=progress,
        )
        written = skincad.write(found, target, formats=formats, progress=progress)
    if not as_json:
        deliver(found, False, written)
    if opened:
        _open(target)
    if found.check is not None:
        found = replace(found, check=advised(design, found.check, advice, budget, as_json))
    if as_json:
        deliver(found, True, written)
    raise typer.Exit(0 if found.passed else 1)


def watch(
    source: Annotated[Path, typer.Argument(metavar="DESIGN", help="A design's TOML file.")],
    settings: SetOption = [],  # noqa: B006
    folder: OutOption = None,
    formats: FormatOption = [],  # noqa: B006
    opened: OpenOption = False,
    printer: PrinterOption = None,
    silicones: SiliconesOption = None,
) -> None:
    """Preview a design again at each save of its file.

    Like make --preview: meshes, pictures and findings alone, in the output folder. What is wrong with the
    file is said, and the next save tried. Load view.html again to see what has changed. Ctrl-C ends it.
    """
    from skincad.base.saved import saves
    from skincad.fabrication.making import STAGES

    _check_opened(opened, formats)
    if not source.is_file():
        remedy = "write one to edit: skincad new my-skin.toml --template NAME"
        raise InputError("source", "must be a design's file", str(source), remedy)
    for _ in saves([path for path in (source, printer, silicones) if path]):
        try:
            design = skincad.load(str(source), settings, printer=printer, silicones=silicones)
            with stage_bar(len(STAGES)) as progress:
                found = skincad.make(design, preview=True, solids="step" in formats, progress=progress)
                target = folder or Path("out") / design.name
                written = skincad.write(found, target, formats=formats, progress=progress)
            deliver(found, False, written)
            if opened:
                _open(target)
            opened = False  # from now on a person loads the page again
        except (InputError, RefusedError) as failure:
            typer.echo(shown(f"skincad: {failure}"), err=True)
        say(f"Watching {source}; Ctrl-C ends.")


def _check_opened(opened: bool, formats: list[str]) -> None:
    """Raise InputError where the page that is to be opened is not among what is written."""
    if opened and formats and "html" not in formats:
        raise InputError("opened", "needs view.html", remedy="add --format html")


def _open(folder: Path) -> None:
    """Show the page in the browser that the system names, or say where it lies."""
    page = (folder / VIEW).resolve()
    if not webbrowser.open(page.as_uri()):
        typer.echo(f"skincad: no browser answers; open {page}", err=True)


def advised(
    design: Design, found: ContactCheck, advice: bool | None, budget: float | None, quiet: bool
) -> ContactCheck:
    """Return a check with its advice, each line of which is printed when it is known, unless `quiet`.

    `advice` None stops in time, or leaves it out where the check had a budget.
    """
    from skincad.outputs.checks import advice_lines
    from skincad.studies.advice import advising, patience

    if advice is False or (advice is None and budget is not None):
        return found
    limit = None if advice else patience(found)
    told, printed = found, 0
    for told in one_by_one(ADVICE_STAGES, partial(advising, design, found, budget=limit)):
        lines = advice_lines(told)[printed:]
        printed += len(lines)
        if lines and not quiet:
            say("\n".join(lines))
    return told
