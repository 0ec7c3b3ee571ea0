"""The command `make`."""

from __future__ import annotations

import webbrowser
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

import skincad
from skincad.base.errors import InputError
from skincad.base.progress import stage_bar, step_bar
from skincad.cli.check import advised, waits_for_advice
from skincad.cli.options import (
    AdviceOption,
    BudgetOption,
    DesignArgument,
    FormatOption,
    GrippersOption,
    JsonOption,
    ModelOption,
    OpenOption,
    OutOption,
    PrinterOption,
    ScenesOption,
    SetOption,
    SiliconesOption,
    VerboseOption,
    as_typed,
    deliver,
    leave,
    out_folder,
    say,
)

VIEW = "view.html"


def make(
    source: DesignArgument,
    settings: SetOption = [],  # noqa: B006
    folder: OutOption = None,
    formats: FormatOption = [],  # noqa: B006
    strict: Annotated[bool, typer.Option("--strict", help="Warnings count as failures.")] = False,
    checked: Annotated[
        bool, typer.Option("--check/--no-check", help="Ask whether all ridges touch, or leave that out.")
    ] = True,
    model: ModelOption = "auto",
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
    grippers: GrippersOption = None,
    verbose: VerboseOption = False,
    as_json: JsonOption = False,
) -> None:
    """Make skin and mold, check both, and write all files.

    STEP, STL, 3MF, DXF, SVG, a picture, a casting sheet and a report appear in the output folder, all of
    them or none.
    """
    from skincad.fabrication.making import STAGES
    from skincad.outputs.delivery import of_formats

    design = skincad.load(source, settings, printer=printer, silicones=silicones, grippers=grippers)
    check_opened(opened, formats)
    from skincad.outputs import makes  # loads what draws: only for a design that is one

    solids = not preview or "step" in formats
    files = of_formats(makes.names(design, solids, preview), formats)
    target = out_folder(folder, design.name, makes.COMMAND, files)
    if preview:
        makes.keep_whole(target)
    if scenes and preview:
        raise InputError("scenes", "are for the report, which --preview leaves out", remedy="leave one out")
    simulations = []
    for scene in [skincad.load_scene(scene, skin=design) for scene in scenes]:  # all are read before one runs
        with step_bar(scene.history.step_count) as tick:
            simulations.append(skincad.simulate(scene, tick=tick))
    with stage_bar(len(STAGES)) as progress:
        result = skincad.make(
            design,
            strict=strict,
            checked=checked,
            model=model,
            budget=budget,
            preview=preview,
            solids=solids,
            scenes=simulations,
            progress=progress,
        )
        written = skincad.write(result, target, formats=formats, progress=progress)
    typed = as_typed(
        source,
        settings,
        printer=printer,
        silicones=silicones,
        grippers=grippers,
        model=None if model == "auto" else model,
    )
    full = verbose or as_json
    waits = result.check is not None and waits_for_advice(result.check, advice, budget, full=full)
    if not as_json:
        deliver(result, False, written, typed, verbose=verbose, last=not waits)
    if opened:
        open_view(target)
    if waits and result.check is not None:
        check = advised(design, result.check, advice, budget, full=full, quiet=as_json)
        result = replace(result, check=check)
        if not as_json:
            say("\n".join(result.next_line(typed)))
    if as_json:
        deliver(result, True, written)
    leave(result)


def check_opened(opened: bool, formats: list[str]) -> None:
    """Raise InputError where the page that is to be opened is not among what is written."""
    if opened and formats and "html" not in formats:
        raise InputError("opened", "needs view.html", remedy="add --format html")


def open_view(folder: Path) -> None:
    """Show the page in the browser that the system names, or say where it lies."""
    page = (folder / VIEW).resolve()
    if not webbrowser.open(page.as_uri()):
        typer.echo(f"skincad: no browser answers; open {page}", err=True)
