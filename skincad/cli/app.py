"""The commands by name, in the order in which `--help` lists them."""

from __future__ import annotations

from typing import Annotated

import typer

import skincad
from skincad.cli.checks import accuracy, check, circuit
from skincad.cli.designs import new, templates
from skincad.cli.making import make, package, watch
from skincad.cli.measurements import accept, coupon, fit_material
from skincad.cli.options import expanded
from skincad.cli.running import listen, live, simulate
from skincad.cli.searching import optimise, solve, sweep

HELP = "Artificial robot skin: its solids and mold, files to make them, and what it will feel."
COMMANDS = (
    templates, new, make, watch, coupon, package, check, circuit, simulate, accuracy, fit_material, accept,
    solve, sweep, optimise, live, listen,
)  # fmt: skip

app = typer.Typer(
    name="skincad", help=HELP, no_args_is_help=True, rich_markup_mode=None, pretty_exceptions_enable=False
)
for command in COMMANDS:
    app.command(command.__name__.replace("_", "-"))(expanded(command))


def _version(wanted: bool) -> None:
    if wanted:
        print(f"skincad {skincad.__version__}")
        raise typer.Exit


@app.callback(help=HELP)
def root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    """Take the options before a command."""
