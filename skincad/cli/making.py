"""The commands that make a design's files: `make`, `watch`, `package`."""

from __future__ import annotations

import webbrowser
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

import skincad
from skincad.base.errors import InputError, RefusedError, shown
from skincad.base.progress import stage_bar, step_bar
from skincad.cli import options
from skincad.cli.checks import advised, waits_for_advice
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
    waits = result.check is not None and waits_for_advice(result.check, advice, budget, display)
    if not display.as_json:
        deliver(result, written, display, typed, last=not waits)
    if opened:
        open_view(target)
    if waits and result.check is not None:
        result = replace(result, check=advised(design, result.check, advice, budget, display))
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


def watch(
    source: Annotated[Path, options.argument("DESIGN", "A design's TOML file.")],
    settings: options.Settings = [],  # noqa: B006
    folder: options.Out = None,
    formats: options.Formats = [],  # noqa: B006
    opened: options.View = False,
    *,
    workshop: options.Workshop,
    verbose: options.Verbose = False,
) -> None:
    """Preview a design again at each save of its file.

    Like make --preview: meshes, pictures and findings alone, in the output folder. What is wrong with the
    file is said, and the next save tried. Load view.html again to see what has changed. Ctrl-C ends it.
    """
    from skincad.base.saved import saves
    from skincad.fabrication.making import STAGES

    check_opened(opened, formats)
    if not source.is_file():
        remedy = "write one to edit: skincad new my-skin.toml --template NAME"
        raise InputError("source", "must be a design's file", str(source), remedy)
    for _ in saves([path for path in (source, *vars(workshop).values()) if path]):
        try:
            design = skincad.load(str(source), settings, **vars(workshop))
            with stage_bar(len(STAGES)) as progress:
                result = skincad.make(design, preview=True, solids="step" in formats, progress=progress)
                target = folder or Path("out") / design.name
                written = skincad.write(result, target, formats=formats, progress=progress)
            typed = as_typed(str(source), settings, **vars(workshop))
            deliver(result, written, options.Display(verbose=verbose), typed)
            if opened:
                open_view(target)
            opened = False  # from now on a person loads the page again
        except (InputError, RefusedError) as failure:
            typer.echo(shown(f"skincad: {failure}"), err=True)
        say(f"Watching {source}; Ctrl-C ends.")


STAGES = 26  # of its bar, about: those of the springs' checks among them


def package(
    source: options.DesignSource,
    settings: options.Settings = [],  # noqa: B006
    kinds: Annotated[
        list[str],
        option("--for KIND", "mujoco, urdf, taxels, mesh, usd; repeat for several; default: all."),
    ] = [],  # noqa: B006
    model: options.Model = "auto",
    mesh_prefix: Annotated[
        str,
        option(
            "--mesh-prefix URI",
            "What URDF's meshes begin with, as package://my_robot/meshes/; default: beside the file.",
        ),
    ] = "",
    *,
    workshop: options.Workshop,
    folder: Annotated[
        Path | None, option("-o --out DIR", "The folder to write to; default: out/<name>/package.")
    ] = None,
    as_json: options.Json = False,
) -> None:
    """Export the skin for other people's simulators.

    MuJoCo model and scene, URDF, USD, taxels with the films' response, meshes, and a model card that says
    what each number rests on appear in the output folder.
    """
    design = skincad.load(source, settings, **vars(workshop))
    target = out_folder(folder, Path(design.name, "package"), "package", ())
    with stage_bar(STAGES) as progress:
        result = skincad.package(design, kinds, model=model, mesh_prefix=mesh_prefix, progress=progress)
        written = skincad.write(result, target, progress=progress)
    deliver(result, written, options.Display(as_json=as_json))
