"""The command `templates`."""

from __future__ import annotations

from typing import Annotated

from skincad.cli import options
from skincad.cli.options import argument, completes
from skincad.cli.printing import show


def templates(
    kind: Annotated[
        str | None,
        argument(
            "KIND",
            "List one kind: designs, scenes, circuits, studies, silicones, processes or grippers.",
            autocompletion=completes("kinds"),
        ),
    ] = None,
    as_json: options.Json = False,
) -> None:
    """List the templates, silicones, processes and grippers that ship.

    Templates are designs, scenes, circuits and studies. With KIND, silicones, processes and grippers come
    with their values, ranges and sources.
    """
    from skincad.outputs.tomls import listing

    data, lines = listing(kind)
    show(data, as_json, lines)
