"""The commands that run a scene: `simulate`, `live`."""

from __future__ import annotations

from typing import Annotated

import skincad
from skincad.base.errors import InputError
from skincad.base.progress import step_bar
from skincad.cli import options
from skincad.cli.options import option
from skincad.cli.printing import as_typed, deliver, leave, out_folder, say


def simulate(
    source: Annotated[str, options.argument("SCENE", autocompletion=options.completes("scenes"))],
    settings: options.Settings = [],  # noqa: B006
    silicones: options.Silicones = None,
    tol: Annotated[
        float | None, option("--tol REL", "Relative error of the differential stress to meet.")
    ] = None,
    budget: options.Budget = None,
    model: Annotated[
        str,
        option("--model", "auto: with finite strain and free ends where they matter; or small_strain alone."),
    ] = "auto",
    at: Annotated[
        list[int], option("--at STEP", "Draw the section with its stress at this step; repeat for several.")
    ] = [],  # noqa: B006
    gif: Annotated[bool, option("--gif", "Animate the section over the scene.")] = False,
    folder: options.Out = None,
    *,
    display: options.Display,
) -> None:
    """Run a scene, and say which ridge slips when.

    The effects that the scene names are computed, and those that change its signals most. Signals as CSV and
    a picture appear in the output folder; Ctrl-C keeps what is done by then.
    """
    from skincad.inputs.catalog import setting_key

    for key, name, value in (("readout.steps", "at", at), ("readout.frames", "gif", gif)):
        if value and key in map(setting_key, settings):
            raise InputError(name, f"gives {key}, and --set does too", remedy="leave one of them out")
    drawn = [f"readout.steps={at}"] * bool(at) + ["readout.frames=24"] * gif
    try:
        scene = skincad.load_scene(source, [*settings, *drawn], silicones=silicones)
    except InputError as failure:
        if not (at and failure.key.startswith("readout.steps")):
            raise
        raise InputError("at", failure.rule, failure.value, failure.remedy) from None
    from skincad.outputs import simulations

    target = out_folder(folder, scene.name, simulations.COMMAND, simulations.names(scene))
    with step_bar(scene.history.step_count) as tick:
        result = skincad.simulate(
            scene,
            tol=tol,
            budget=budget,
            tick=tick,
            partial=True,
            model=model,  # type: ignore[arg-type]
        )
    typed = as_typed(source, settings, silicones=silicones)
    deliver(result, skincad.write(result, target), display, typed)
    leave(result)


def live(
    source: Annotated[
        str, options.argument("DESIGN", "A template's name or a TOML file: a design or a scene.")
    ],
    settings: options.Settings = [],  # noqa: B006
    host: Annotated[
        str, option("--host ADDRESS", "Where to listen; default: this machine alone.")
    ] = "127.0.0.1",
    port: Annotated[int, option("--port N", "The port, or the next free one; 0: any.")] = 8642,
    browser: Annotated[bool, option("--open", "Open it in the browser.")] = False,
    *,
    workshop: options.Workshop,
) -> None:
    """Move a design or scene with sliders, in the browser.

    Section, skin and mold follow each move; findings and the closed form's verdict come at once, those of
    better models as they finish. A scene's history and signals are plots. Undo, save as TOML, make. Ctrl-C
    ends.
    """
    from skincad.circuit.model import Circuit
    from skincad.live.serve import serve
    from skincad.studies.subject import load_subject

    subject = load_subject(source, settings, **vars(workshop))
    if isinstance(subject, Circuit):
        raise InputError(source[:80], "is a circuit, not a design or a scene", remedy="give it to circuit")
    serve(subject, source, host, port, browser=browser, say=say)
