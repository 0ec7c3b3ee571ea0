"""The command `live`: the page with sliders."""

from __future__ import annotations

from typing import Annotated

from skincad.base.errors import InputError
from skincad.cli import options
from skincad.cli.options import option
from skincad.cli.printing import say


def live(
    source: Annotated[
        str, options.argument("DESIGN", "A template's name or a TOML file: a design or a scene.")
    ],
    settings: options.Settings = [],  # noqa: B006
    host: Annotated[
        str, option("--host ADDRESS", "Where to listen; default: this machine alone.")
    ] = "127.0.0.1",
    port: Annotated[int, option("--port N", "The port, or the next free one; 0: any.")] = 8642,
    browser: Annotated[bool, option("--open", "Open it in the browser.")] = False,
    *,
    workshop: options.Workshop,
) -> None:
    """Move a design or scene with sliders, in the browser.

    Section, skin and mold follow each move; findings and the closed form's verdict come at once, those of
    better models as they finish. A scene's history is drawn by hand. Undo, save as TOML, make. Ctrl-C ends.
    """
    from skincad.circuit.model import Circuit
    from skincad.live.serve import serve
    from skincad.studies.subject import load_subject

    subject = load_subject(source, settings, **vars(workshop))
    if isinstance(subject, Circuit):
        raise InputError(source[:80], "is a circuit, not a design or a scene", remedy="give it to circuit")
    serve(subject, source, host, port, browser=browser, say=say)
