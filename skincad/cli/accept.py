"""The command `accept`: a finished part, by a press or by a recording of its films."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import skincad
from skincad.base.errors import InputError
from skincad.base.progress import stage_bar, step_bar
from skincad.cli import options
from skincad.cli.options import option
from skincad.cli.printing import as_typed, leave, report, show

if TYPE_CHECKING:
    from skincad.inputs.design import Design
    from skincad.material.acceptance import Acceptance


def accept(
    sources: Annotated[
        list[str],
        options.argument(
            "PRESS DESIGN|SCENE",
            "A CSV with the columns approach_mm, force_N, and a template's name or a TOML file; with "
            "--recording only the latter, a scene's.",
        ),
    ],
    recording: Annotated[
        Path | None,
        option(
            "--recording CSV",
            "The films' voltages as the scene is played: columns time_s and a strip each, as ridge_3_S1_V.",
        ),
    ] = None,
    settings: options.Settings = [],  # noqa: B006
    silicones: options.Silicones = None,
    force_error: Annotated[
        float | None, option("--force-error N", "Standard deviation of a force; 0.05 if not given.")
    ] = None,
    approach_error: Annotated[
        float | None, option("--approach-error MM", "Of an approach, and of its zero; 0.02 if not given.")
    ] = None,
    ruled_out: Annotated[
        list[str],
        option(
            "--ruled-out CAUSE",
            "A cause that you excluded otherwise: crests, ridge, back, friction or modulus; repeat.",
        ),
    ] = [],  # noqa: B006
    good_share: Annotated[
        float | None,
        option("--good-share SHARE", "How many of your parts are good, before this press; 0.5 if not given."),
    ] = None,
    update: Annotated[
        Path | None, option("--update FILE", "Write a copy of the design, its silicone as measured.")
    ] = None,
    *,
    display: options.Display,
) -> None:
    """Say whether a finished part is good, by a press: in, out or can't tell; or which films work.

    PRESS DESIGN compares force against approach under a flat plate with what the design's parts give, and
    names the cause that fits best. --recording CSV SCENE compares the films' voltages with the scene's, and
    names dead, reversed and swapped strips.
    """
    from skincad.base.outfolder import checked_fresh

    wanted = 1 if recording is not None else 2
    if len(sources) != wanted:
        rule = "must be a press and a design" if wanted > 1 else "must be one scene beside --recording"
        raise InputError("arguments", rule, " ".join(sources), "see `skincad accept --help`")
    given = {
        "force_error": force_error, "approach_error": approach_error, "ruled_out": ruled_out or None,
        "good_share": good_share,
    }  # fmt: skip
    said: dict[str, Any] = {key: value for key, value in given.items() if value is not None}
    source = sources[-1]
    typed = as_typed(source, settings, silicones=silicones)
    if recording is not None:
        for key, value in ({**said, "update": update} if update is not None else said).items():
            raise InputError(key, "is of a press, not of a recording", str(value), "leave it out")
        scene = skincad.load_scene(source, settings, silicones=silicones)
        with step_bar(scene.history.step_count) as tick:
            films = skincad.accept_recording(scene, recording, tick=tick)
        show(films.as_json(), display.as_json, report(films, typed, verbose=display.verbose))
        leave(films)
    if update is not None:
        checked_fresh(update, ".toml", "update")
    press = Path(sources[0])
    design: Design = skincad.load(source, settings, silicones=silicones)
    if update is not None and design.shot:
        rule, remedy = "must not be given with [[shot]]: a press sees all layers together", "leave it out"
        raise InputError("update", rule, str(update), remedy)
    with stage_bar(7) as progress:
        result: Acceptance = skincad.accept(design, press, progress=progress, **said)
    written = update if update is not None and result.measures_modulus else None
    more = []
    if written is not None:
        from skincad.outputs.tomls import write_with_modulus

        law = f"measured: press {press.name}"
        write_with_modulus(written, source, settings, result.ranged, None, law, silicones)
        more = [
            f"  written        {written}",
            f"Next: `skincad check {written}` says whether a part of this silicone will do.",
        ]
    elif update is not None:
        more = [f"  not written    {update}: another cause than the modulus fits best"]
    lines = report(result, typed, verbose=display.verbose, more=more, last=not written)
    show({**result.as_json(), "file": str(written) if written else None}, display.as_json, lines)
    leave(result)
