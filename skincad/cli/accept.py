"""The command `accept`: a finished part, by a press or by a recording of its films."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import skincad
from skincad.base.errors import InputError
from skincad.base.progress import stage_bar, step_bar
from skincad.cli.options import (
    JsonOption,
    SetOption,
    SiliconesOption,
    VerboseOption,
    as_typed,
    leave,
    report,
    show,
)

if TYPE_CHECKING:
    from skincad.inputs.design import Design
    from skincad.material.acceptance import Acceptance


def accept(
    sources: Annotated[
        list[str],
        typer.Argument(
            metavar="PRESS DESIGN|SCENE",
            help="A CSV with the columns approach_mm, force_N, and a template's name or a TOML file; with "
            "--recording only the latter, a scene's.",
        ),
    ],
    recording: Annotated[
        Path | None,
        typer.Option(
            "--recording",
            metavar="CSV",
            help="The films' voltages as the scene is played: columns time_s and a strip each, "
            "as ridge_3_S1_V.",
        ),
    ] = None,
    settings: SetOption = [],  # noqa: B006
    silicones: SiliconesOption = None,
    force_error: Annotated[
        float | None,
        typer.Option("--force-error", metavar="N", help="Standard deviation of a force; 0.05 if not given."),
    ] = None,
    approach_error: Annotated[
        float | None,
        typer.Option(
            "--approach-error", metavar="MM", help="Of an approach, and of its zero; 0.02 if not given."
        ),
    ] = None,
    ruled_out: Annotated[
        list[str],
        typer.Option(
            "--ruled-out",
            metavar="CAUSE",
            help="A cause that you excluded otherwise: crests, ridge, back, friction or modulus; repeat.",
        ),
    ] = [],  # noqa: B006
    good_share: Annotated[
        float | None,
        typer.Option(
            "--good-share",
            metavar="SHARE",
            help="How many of your parts are good, before this press; 0.5 if not given.",
        ),
    ] = None,
    update: Annotated[
        Path | None,
        typer.Option(
            "--update", metavar="FILE", help="Write a copy of the design, its silicone as measured."
        ),
    ] = None,
    verbose: VerboseOption = False,
    as_json: JsonOption = False,
) -> None:
    """Say whether a finished part is good, by a press: in, out or can't tell; or which films work.

    PRESS DESIGN compares force against approach under a flat plate with what the design's parts give, and
    names the cause that fits best. --recording CSV SCENE compares the films' voltages with the scene's, and
    names dead, reversed and swapped strips.
    """
    wanted = 1 if recording is not None else 2
    if len(sources) != wanted:
        rule = "must be a press and a design" if wanted > 1 else "must be one scene beside --recording"
        raise InputError("arguments", rule, " ".join(sources), "see `skincad accept --help`")
    given = {
        "force_error": force_error, "approach_error": approach_error, "ruled_out": ruled_out or None,
        "good_share": good_share,
    }  # fmt: skip
    said: dict[str, Any] = {key: value for key, value in given.items() if value is not None}
    if recording is not None:
        for key, value in ({**said, "update": update} if update is not None else said).items():
            raise InputError(key, "is of a press, not of a recording", str(value), "leave it out")
        _by_films(recording, sources[0], settings, silicones, verbose=verbose, as_json=as_json)
        return
    _by_press(sources, settings, silicones, said, update, verbose=verbose, as_json=as_json)


def _by_films(
    recording: Path,
    source: str,
    settings: list[str],
    silicones: Path | None,
    *,
    verbose: bool,
    as_json: bool,
) -> None:
    scene = skincad.load_scene(source, settings, silicones=silicones)
    with step_bar(scene.history.step_count) as tick:
        result = skincad.accept_recording(scene, recording, tick=tick)
    typed = as_typed(source, settings, silicones=silicones)
    show(result.as_json(), as_json, "\n".join(report(result, typed, verbose=verbose)))
    leave(result)


def _by_press(
    sources: list[str],
    settings: list[str],
    silicones: Path | None,
    said: dict[str, Any],
    update: Path | None,
    *,
    verbose: bool,
    as_json: bool,
) -> None:
    from skincad.base.outfolder import checked_fresh

    if update is not None:
        checked_fresh(update, ".toml", "update")
    press, source = sources
    design: Design = skincad.load(source, settings, silicones=silicones)
    if update is not None and design.shot:
        rule, remedy = "must not be given with [[shot]]: a press sees all layers together", "leave it out"
        raise InputError("update", rule, str(update), remedy)
    with stage_bar(7) as progress:
        result: Acceptance = skincad.accept(design, Path(press), progress=progress, **said)
    written = update if update is not None and result.measures_modulus else None
    if written is not None:
        from skincad.outputs.tomls import write_with_modulus

        law = f"measured: press {Path(press).name}"
        write_with_modulus(written, source, settings, result.ranged, None, law, silicones)
    more = [f"  written        {written}"] if written else []
    if update is not None and written is None:
        more = [f"  not written    {update}: another cause than the modulus fits best"]
    typed = as_typed(source, settings, silicones=silicones)
    if written:
        more.append(f"Next: `skincad check {written}` says whether a part of this silicone will do.")
    words = "\n".join(report(result, typed, verbose=verbose, more=more, last=not written))
    show({**result.as_json(), "file": str(written) if written else None}, as_json, words)
    leave(result)
