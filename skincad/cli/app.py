"""The commands by name, in the order in which `--help` lists them."""

from __future__ import annotations

from typing import Annotated

import typer

import skincad
from skincad.cli.accept import accept
from skincad.cli.accuracy import accuracy
from skincad.cli.check import check
from skincad.cli.circuit import circuit
from skincad.cli.coupon import coupon
from skincad.cli.fit_material import fit_material
from skincad.cli.live import live
from skincad.cli.make import make
from skincad.cli.new import new
from skincad.cli.optimise import optimise
from skincad.cli.options import expanded
from skincad.cli.package import package
from skincad.cli.simulate import simulate
from skincad.cli.solve import solve
from skincad.cli.sweep import sweep
from skincad.cli.templates import templates
from skincad.cli.watch import watch

HELP = "Artificial robot skin: its solids and mold, files to make them, and what it will feel."
COMMANDS = (
    templates, new, make, watch, coupon, package, check, circuit, simulate, accuracy, fit_material, accept,
    solve, sweep, optimise, live,
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
