"""The command `templates`."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated

import typer

from skincad.cli.options import JsonOption, completes, show


def _kinds() -> Iterable[str]:
    from skincad.outputs.tomls import LISTS

    return LISTS


def templates(
    kind: Annotated[
        str | None,
        typer.Argument(
            metavar="KIND",
            help="List one kind: designs, scenes, circuits, studies, silicones, processes or grippers.",
            autocompletion=completes(_kinds),
        ),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """List the templates, silicones, processes and grippers that ship.

    Templates are designs, scenes, circuits and studies. With KIND, silicones, processes and grippers come
    with their values, ranges and sources.
    """
    from skincad.outputs.tomls import listing

    data, lines = listing(kind)
    show(data, as_json, "\n".join(lines))
