"""The command `new`."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Annotated

import typer

from skincad.cli.options import completes, say


def _starts() -> Iterable[str]:
    from skincad.outputs.tomls import start_names

    return start_names()


def new(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="The TOML file to write.")],
    template: Annotated[
        str,
        typer.Option(
            "--template",
            metavar="NAME",
            help="Start from this design, scene or circuit, or a table: silicones, processes or grippers.",
            autocompletion=completes(_starts),
        ),
    ] = "designs/yamada-2002",
) -> None:
    """Write a commented TOML file to edit, and its JSON schema.

    It is a design, a scene or a circuit, or a table of silicones, processes or grippers. An editor that
    knows the schema completes and checks the file.
    """
    from skincad.outputs.tomls import write_new

    say("\n".join(map(str, write_new(file, template))))
