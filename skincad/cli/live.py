"""The command `live`: the page with sliders."""

from __future__ import annotations

from typing import Annotated

import typer

from skincad.base.errors import InputError
from skincad.cli.options import GrippersOption, PrinterOption, SetOption, SiliconesOption, say


def live(
    source: Annotated[
        str, typer.Argument(metavar="DESIGN", help="A template's name or a TOML file: a design or a scene.")
    ],
    settings: SetOption = [],  # noqa: B006
    host: Annotated[
        str, typer.Option("--host", metavar="ADDRESS", help="Where to listen; default: this machine alone.")
    ] = "127.0.0.1",
    port: Annotated[
        int, typer.Option("--port", metavar="N", help="The port, or the next free one; 0: any.")
    ] = 8642,
    browser: Annotated[bool, typer.Option("--open", help="Open it in the browser.")] = False,
    printer: PrinterOption = None,
    silicones: SiliconesOption = None,
    grippers: GrippersOption = None,
) -> None:
    """Move a design or scene with sliders, in the browser.

    Section, skin and mold follow each move; findings and the closed form's verdict come at once, those of
    better models as they finish. A scene's history is drawn by hand. Undo, save as TOML, make. Ctrl-C ends.
    """
    from skincad.circuit.model import Circuit
    from skincad.live.serve import serve
    from skincad.studies.subject import load_subject

    subject = load_subject(source, settings, printer=printer, silicones=silicones, grippers=grippers)
    if isinstance(subject, Circuit):
        raise InputError(source[:80], "is a circuit, not a design or a scene", remedy="give it to circuit")
    serve(subject, source, host, port, browser=browser, say=say)
