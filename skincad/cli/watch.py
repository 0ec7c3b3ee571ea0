"""The command `watch`: make --preview again at each save."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import skincad
from skincad.base.errors import InputError, RefusedError, shown
from skincad.base.progress import stage_bar
from skincad.cli import options
from skincad.cli.make import check_opened, open_view
from skincad.cli.printing import as_typed, deliver, say


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
