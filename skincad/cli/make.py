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
from skincad.cli import options
from skincad.cli.check import advised, waits_for_advice
from skincad.cli.options import option
from skincad.cli.printing import as_typed, deliver, leave, out_folder, say

VIEW = "view.html"


def make(
    source: options.DesignSource,
    settings: options.Settings = [],  # noqa: B006
    folder: options.Out = None,
    formats: options.Formats = [],  # noqa: B006
    strict: Annotated[bool, option("--strict", "Warnings count as failures.")] = False,
    checked: Annotated[
        bool, option("--check/--no-check", "Ask whether all ridges touch, or leave that out.")
    ] = True,
    model: options.Model = "auto",
    budget: options.Budget = None,
    preview: Annotated[
        bool,
        option(
            "--preview",
            "Meshes, pictures and findings alone, in seconds: no check, STEP only by --format step.",
        ),
    ] = False,
    opened: options.View = False,
    advice: options.Advice = None,
    scenes: Annotated[
        list[str],
        option(
            "--scene SCENE",
            "A scene's template or TOML file, run with this skin for report.html; repeat for several.",
            autocompletion=options.completes("scenes"),
        ),
    ] = [],  # noqa: B006
    *,
    workshop: options.Workshop,
    display: options.Display,
) -> None:
    """Make skin and mold, check both, and write all files.

    STEP, STL, 3MF, DXF, SVG, a picture, a casting sheet and a report appear in the output folder, all of
    them or none.
    """
    from skincad.fabrication.making import STAGES
    from skincad.outputs.delivery import of_formats

    design = skincad.load(source, settings, **vars(workshop))
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
    typed = as_typed(source, settings, **vars(workshop), model=model)
    full = display.verbose or display.as_json
    waits = result.check is not None and waits_for_advice(result.check, advice, budget, full=full)
    if not display.as_json:
        deliver(result, written, display, typed, last=not waits)
    if opened:
        open_view(target)
    if waits and result.check is not None:
        check = advised(design, result.check, advice, budget, full=full, quiet=display.as_json)
        result = replace(result, check=check)
        if not display.as_json:
            say(*result.next_line(typed))
    if display.as_json:
        deliver(result, written, display)
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
