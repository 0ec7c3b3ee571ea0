"""The command `fit-material`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import skincad
from skincad.base.errors import InputError
from skincad.base.progress import stage_bar
from skincad.cli import options
from skincad.cli.options import option
from skincad.cli.printing import show


def fit_material(
    file: Annotated[
        Path,
        options.argument(
            "CSV",
            "Columns approach_mm, force_N (a pad); strain, stress_MPa or extension_mm, force_N (a bar).",
        ),
    ],
    design: Annotated[
        str | None, option("--design DESIGN", "The design of the pad that a flat plate pressed.")
    ] = None,
    settings: options.Settings = [],  # noqa: B006
    silicones: options.Silicones = None,
    up_to: Annotated[
        float | None,
        option("--up-to X", "Largest strain used (default: 0.3) or, for a pad, largest force in N."),
    ] = None,
    gauge_length: Annotated[
        float | None, option("--gauge-length MM", "Gauge length of a bar, with extension_mm.")
    ] = None,
    area: Annotated[float | None, option("--area MM2", "Cross-section of a bar, with extension_mm.")] = None,
    copy: Annotated[
        Path | None, option("-o --out FILE", "Write a copy of the design with modulus and law.")
    ] = None,
    as_json: options.Json = False,
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
    lines = [str(fit)]
    if copy is not None and design is not None:
        from skincad.outputs.tomls import write_with_modulus

        said = f"measured: {fit.kind} test {file.name}"
        write_with_modulus(copy, design, settings, fit.ranged, fit.law, said, silicones)
        lines.append(f"written to {copy}")
    show({**fit.as_json(), "file": str(copy) if copy else None}, as_json, lines)
