"""The command `accept`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import skincad
from skincad.base.errors import InputError
from skincad.base.progress import stage_bar
from skincad.cli.options import (
    DesignArgument,
    JsonOption,
    SetOption,
    SiliconesOption,
    as_typed,
    leave,
    report,
    show,
)


def accept(
    press: Annotated[
        Path,
        typer.Argument(metavar="PRESS", help="A CSV with the columns approach_mm, force_N; ten rows do."),
    ],
    source: DesignArgument,
    settings: SetOption = [],  # noqa: B006
    silicones: SiliconesOption = None,
    force_error: Annotated[
        float, typer.Option("--force-error", metavar="N", help="Standard deviation of a force.")
    ] = 0.05,
    approach_error: Annotated[
        float, typer.Option("--approach-error", metavar="MM", help="Of an approach, and of its zero.")
    ] = 0.02,
    ruled_out: Annotated[
        list[str],
        typer.Option(
            "--ruled-out",
            metavar="CAUSE",
            help="A cause that you excluded otherwise: crests, ridge, back, friction or modulus; repeat.",
        ),
    ] = [],  # noqa: B006
    good_share: Annotated[
        float,
        typer.Option(
            "--good-share", metavar="SHARE", help="How many of your parts are good, before this press."
        ),
    ] = 0.5,
    update: Annotated[
        Path | None,
        typer.Option(
            "--update", metavar="FILE", help="Write a copy of the design, its silicone as measured."
        ),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Say whether a cast part is good, by a press: in, out or can't tell.

    Compares force against approach under a flat plate with what the design's parts give, and names the cause
    that fits best.
    """
    from skincad.base.outfolder import checked_fresh

    if update is not None:
        checked_fresh(update, ".toml", "update")
    design = skincad.load(source, settings, silicones=silicones)
    if update is not None and design.shot:
        rule, remedy = "must not be given with [[shot]]: a press sees all layers together", "leave it out"
        raise InputError("update", rule, str(update), remedy)
    with stage_bar(7) as progress:
        result = skincad.accept(
            design,
            press,
            force_error=force_error,
            approach_error=approach_error,
            ruled_out=ruled_out,
            good_share=good_share,
            progress=progress,
        )
    written = update if update is not None and result.measures_modulus else None
    if written is not None:
        from skincad.outputs.tomls import write_with_modulus

        law = f"measured: press {press.name}"
        write_with_modulus(written, source, settings, result.ranged, None, law, silicones)
    more = [f"  written        {written}"] if written else []
    if update is not None and written is None:
        more = [f"  not written    {update}: another cause than the modulus fits best"]
    typed = as_typed(source, settings, silicones=silicones)
    words = "\n".join(report(result, typed, more=more))
    show({**result.as_json(), "file": str(written) if written else None}, as_json, words)
    leave(result)
