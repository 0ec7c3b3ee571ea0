"""The command `accept`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import skincad
from skincad.base.progress import step_bar
from skincad.cli.options import (
    JsonOption,
    SetOption,
    SiliconesOption,
    VerboseOption,
    as_typed,
    leave,
    report,
    show,
    source_argument,
)


def accept(
    source: Annotated[str, source_argument("SCENE", "scenes")],
    recording: Annotated[
        Path,
        typer.Option(
            "--recording",
            metavar="FILM.csv",
            help="The films' voltages: columns time_s and a strip each, as ridge_3_S1_V.",
        ),
    ],
    settings: SetOption = [],  # noqa: B006
    silicones: SiliconesOption = None,
    verbose: VerboseOption = False,
    as_json: JsonOption = False,
) -> None:
    """Say which strips of a skin work, by a recording of their films.

    The recording is compared with the prediction of its scene. Dead, reversed and swapped strips are named.
    Exit status 0: all strips work; 1: some do not, or the recording can't tell.
    """
    scene = skincad.load_scene(source, settings, silicones=silicones)
    with step_bar(scene.history.step_count) as tick:
        result = skincad.accept_recording(scene, recording, tick=tick)
    typed = as_typed(source, settings, silicones=silicones)
    show(result.as_json(), as_json, "\n".join(report(result, typed, verbose=verbose)))
    leave(result)
