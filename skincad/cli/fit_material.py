"""The command `fit-material`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import skincad
from skincad.base.errors import InputError
from skincad.base.progress import stage_bar
from skincad.cli.options import JsonOption, SetOption, SiliconesOption, show


def fit_material(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="CSV",
            help="Columns approach_mm, force_N (a pad); strain, stress_MPa or extension_mm, force_N (a bar).",
        ),
    ],
    design: Annotated[
        str | None,
        typer.Option("--design", metavar="DESIGN", help="The design of the pad that a flat plate pressed."),
    ] = None,
    settings: SetOption = [],  # noqa: B006
    silicones: SiliconesOption = None,
    up_to: Annotated[
        float | None,
        typer.Option(
            "--up-to",
            metavar="X",
            help="Largest strain used (default: 0.3) or, for a pad, largest force in N.",
        ),
    ] = None,
    gauge_length: Annotated[
        float | None,
        typer.Option("--gauge-length", metavar="MM", help="Gauge length of a bar, with extension_mm."),
    ] = None,
    area: Annotated[
        float | None, typer.Option("--area", metavar="MM2", help="Cross-section of a bar, with extension_mm.")
    ] = None,
    copy: Annotated[
        Path | None,
        typer.Option("-o", "--out", metavar="FILE", help="Write a copy of the design with modulus and law."),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Find the silicone's modulus and its error from a test, and from a bar's its law.

    The test is force against approach of a cast pad, or stress against strain of a bar pulled or squeezed.
    Laws of rubber are fitted to the first half of a bar's strains, and judged by the second.
    """
    from skincad.base.outfolder import checked_fresh

    for name, value in (("settings", settings), ("silicones", silicones), ("copy", copy)):
        if value and design is None:
            raise InputError(name, "needs --design", remedy="name the design with --design")
    loaded = skincad.load(design, settings, silicones=silicones) if design else None
    if copy is not None:
        checked_fresh(copy, ".toml", "copy")
    with stage_bar(6) as progress:
        fit = skincad.fit_material(
            file, loaded, up_to=up_to, gauge_length=gauge_length, area=area, progress=progress
        )
    written = ""
    if copy is not None and design is not None:
        from skincad.outputs.tomls import write_with_modulus

        said = f"measured: {fit.kind} test {file.name}"
        write_with_modulus(copy, design, settings, fit.ranged, fit.law, said, silicones)
        written = f"\nwritten to {copy}"
    show({**fit.as_json(), "file": str(copy) if copy else None}, as_json, f"{fit}{written}")
