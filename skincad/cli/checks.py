"""The commands that judge a design or a circuit: `check`, `accuracy`, `circuit`."""

from __future__ import annotations

from contextlib import closing
from functools import partial, reduce
from operator import or_
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import skincad
from skincad.base.errors import InputError
from skincad.base.progress import one_by_one, stage_bar
from skincad.cli import options
from skincad.cli.options import option
from skincad.cli.printing import as_typed, deliver, leave, out_folder, report, say, show

if TYPE_CHECKING:
    from skincad.inputs.design import Design
    from skincad.mechanics.verdict import ContactCheck


NEXT_OF_PART = {  # of a cast part that was measured
    True: "Next: mount this part.",
    False: "Next: cast another part; -v shows what each crest changes.",
}
ADVICE_STAGES = 9  # of its bar at first: checks and searches for them, about two or three a change


def check(
    source: options.DesignSource,
    settings: options.Settings = [],  # noqa: B006
    force: options.Force = None,
    tol: Annotated[
        float | None, option("--tol REL", "Relative error to meet; with --model, the mesh's alone.")
    ] = None,
    budget: options.Budget = None,
    measured: Annotated[
        Path | None, option("--measured CSV", "Judge a cast part by its crest heights.")
    ] = None,
    model: options.Model = "auto",
    *,
    workshop: options.Workshop,
    stress: Annotated[
        Path | None, option("--stress PNG", "Draw the stress at S1 and S2 of each ridge.")
    ] = None,
    tangential: Annotated[
        float | None,
        option("--pull N", "With --stress: tangential force; default: a quarter of the normal one."),
    ] = None,
    film: Annotated[
        bool, option("--film", "Say which films that can be bought fit, and by what to cut the strips.")
    ] = False,
    hold: Annotated[
        str | None,
        option(
            "--hold MASS",
            "Say how many drawn lifts of an object of 0.3kg or 300g are held; light ones take longer.",
        ),
    ] = None,
    gripper: Annotated[
        str | None,
        option(
            "--gripper NAME",
            "With --hold: the gripper; default: the design's mold.mount.",
            autocompletion=options.completes("grippers"),
        ),
    ] = None,
    advice: options.Advice = None,
    display: options.Display,
) -> None:
    """Say whether all ridges touch a plate.

    Prints the verdict, its margin, its error, the force on each ridge, how far the films' signal of a slow
    lift stands over the noise, and what to do next. --hold marches 20 drawn lifts, some 20 s, and for
    light objects up to three times as long; with a --budget as many as fit in what is left of it.
    """
    from skincad.base.outfolder import checked_fresh

    if tangential is not None and stress is None:
        raise InputError("tangential", "needs --stress", tangential, "name the picture with --stress")
    if stress is not None:
        checked_fresh(stress, ".png", "stress")
    design = skincad.load(source, settings, **vars(workshop))
    if stress is not None:
        from skincad.mechanics.film.stress import check_request

        check_request(design, design.contact.force if force is None else force, (tangential or 0.0,))
    offers = skincad.film_offers(design) if film else None
    with stage_bar(4) as progress:
        result = skincad.check(
            design,
            force=force,
            tol=tol,
            budget=budget,
            model=model,
            measured=measured,
            hold=hold,
            gripper=gripper,
            signal=True,
            progress=progress,
        )
        films = None
        if stress is not None:
            films = skincad.film_stress(design, result.force, tangential, progress=progress)
            skincad.save_picture(films, stress, key="stress")
    typed = as_typed(source, settings, force, **vars(workshop), model=model)
    waits = measured is None and waits_for_advice(result, advice, budget, display)
    if not display.as_json:
        more = [] if films is None else [str(films), f"  picture        {stress}"]
        more += [] if offers is None else offers.presenter().lines(offers)
        more += [] if measured is None else [NEXT_OF_PART[result.passed]]
        last = measured is None and not waits
        say(*report(result, typed, verbose=display.verbose, more=more, last=last))
    if waits:
        result = advised(design, result, advice, budget, display)
        if not display.as_json:
            say(*result.next_line(typed))
    if display.as_json:
        parts = [part.as_json() for part in (films, offers) if part is not None]
        show(reduce(or_, parts, result.as_json()), True, ())
    leave(result)


def waits_for_advice(
    check: ContactCheck, wanted: bool | None, budget: float | None, display: options.Display
) -> bool:
    """Return whether to look for advice: unless all is displayed, only where the next step needs it."""
    from skincad.outputs.checks import awaits_advice
    from skincad.studies.advice import seconds_for_advice

    if check.passed or check.out_of_range or not seconds_for_advice(check, wanted, budget):
        return False
    return display.full or wanted is True or awaits_advice(check)


def advised(
    design: Design, check: ContactCheck, wanted: bool | None, budget: float | None, display: options.Display
) -> ContactCheck:
    """Return a check with its advice: all of it where all is displayed or it is `wanted`, each line printed
    when it is known unless JSON is; else the first change alone."""
    from skincad.outputs.checks import advice_lines
    from skincad.studies.advice import advising, seconds_for_advice

    seconds, whole = seconds_for_advice(check, wanted, budget), display.full or wanted is True
    result, printed = check, 0
    steps = one_by_one(ADVICE_STAGES, partial(advising, design, check, budget=seconds))
    with closing(steps):  # the bar of a search that is left early
        for result in steps:
            if not whole and result.changes:
                break
            lines = advice_lines(result)[printed:]
            printed += len(lines)
            if lines and whole and not display.as_json:
                say(*lines)
    return result


def accuracy(
    source: options.DesignSource,
    settings: options.Settings = [],  # noqa: B006
    ladders: Annotated[
        list[str],
        option(
            "--ladder NAME", "Only these: tessellation, contact, circuit, slip, effects; repeat for several."
        ),
    ] = [],  # noqa: B006
    silicones: options.Silicones = None,
    repeats: Annotated[int, option("--repeats N", "Runs of each setting, whose median is taken.")] = 3,
    folder: options.Out = None,
    as_json: options.Json = False,
) -> None:
    """Show what accuracy costs in time on this design.

    Writes accuracy.csv and a diagram of error against time, a row for each ladder of models and settings.
    """
    from skincad.outputs.studies import ACCURACY_FILES

    design = skincad.load(source, settings, silicones=silicones)
    target = out_folder(folder, design.name, "accuracy", ACCURACY_FILES)
    with stage_bar(1) as progress:
        result = skincad.accuracy(design, ladders, repeats=repeats, progress=progress)
    deliver(result, skincad.write(result, target), options.Display(as_json=as_json))


def circuit(
    source: Annotated[str, options.argument("CIRCUIT", autocompletion=options.completes("circuits"))],
    settings: Annotated[list[str], option("--set KEY=VALUE", "Override a key: amplifier.gain=1e6.")] = [],  # noqa: B006
    measured: Annotated[
        Path | None,
        option("--measured CSV", "Calibrate to a measured curve: columns frequency_Hz, gain_dB; any level."),
    ] = None,
    board: Annotated[
        Path | None, option("--board DIR", "Write an amplifier board into DIR: schematic, parts, pins.")
    ] = None,
    strips: Annotated[
        str | None,
        option(
            "--strips N", "With --board: how many strips, 4 to 16, or which, 2S1,2S2,3S1,3S2; default: 8."
        ),
    ] = None,
    folder: options.Out = None,
    as_json: options.Json = False,
) -> None:
    """Show how film and amplifier respond to frequency.

    Prints the gain, its cut-off and its slopes, and writes gain.csv, gain.png and netlist.cir; with
    --measured also the calibrated circuit, with --board a schematic and what it takes to solder it.
    """
    from skincad.outputs.boards import BOARD, board_names
    from skincad.outputs.simulations import GAIN, gain_names

    if strips is not None and board is None:
        raise InputError("strips", "needs --board", strips, "name the folder with --board")
    if measured is not None and board is not None:
        raise InputError("board", "is of a circuit as it is", board, "give --board with calibrated.toml")
    loaded = skincad.load_circuit(source, settings)
    target = out_folder(folder, loaded.name, GAIN.COMMAND, gain_names(measured is not None))
    layout = None
    if board is not None:
        try:
            out_folder(board, board, BOARD.COMMAND, board_names(loaded.name))
        except InputError as failure:
            raise InputError("board", failure.rule, failure.value, failure.remedy) from None
        layout = skincad.board(loaded, 8 if strips is None else strips)
    with stage_bar(2) as progress:
        result = skincad.gain(loaded, measured, progress)
    written, display = skincad.write(result, target), options.Display(as_json=as_json)
    if board is None or layout is None:
        deliver(result, written, display)
        return
    files = skincad.write(layout, board)
    deliver(result, written, display, beside={"board": layout.as_json() | {"files": files.sizes()}})
    if not as_json:
        say(*report(layout, more=[f"  files          {files}"]))
