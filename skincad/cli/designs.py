"""The commands that begin a design: `templates`, `new`."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer

import skincad
from skincad.base.errors import InputError, did_you_mean
from skincad.base.interrupt import at_once
from skincad.base.progress import stage_bar
from skincad.cli import options
from skincad.cli.options import argument, completes, option
from skincad.cli.printing import leave, report, say, show


def templates(
    kind: Annotated[
        str | None,
        argument(
            "KIND",
            "List one kind: designs, scenes, circuits, studies, silicones, processes, grippers or films.",
            autocompletion=completes("kinds"),
        ),
    ] = None,
    as_json: options.Json = False,
) -> None:
    """List the templates, silicones, processes, grippers and films that ship.

    Templates are designs, scenes, circuits and studies. With KIND, silicones, processes, grippers and films
    to buy come with their values and sources.
    """
    from skincad.outputs.tomls import listing

    data, lines = listing(kind)
    show(data, as_json, lines)


WISH_STAGES = 5  # of its bar at first: shape, two checks of the curvature, the last check


def _wish(head: str, text: str, kind: str = "") -> Any:
    """An option of the wish, completed by the names of a kind."""
    completion = completes(kind) if kind else None
    return option(head, text, autocompletion=completion, rich_help_panel="Wish")


@dataclass(frozen=True, kw_only=True)
class WishOptions:
    """A pad as a person wishes it; what is None is chosen."""

    size: Annotated[
        str | None, _wish("--size WxL", "The pad, across and along its ridges: 24x30, in mm, or 2.4x3cm.")
    ] = None
    touch: Annotated[
        str | None, _wish("--touch N", "The force at which all features are to touch: 1N or 500mN.")
    ] = None
    silicone: Annotated[str | None, _wish("--silicone NAME", "Cast in this silicone.", "silicones")] = None
    process: Annotated[str | None, _wish("--process NAME", "Make the mold by this.", "processes")] = None
    gripper: Annotated[
        str | None, _wish("--gripper NAME", "Drill the carrier for this gripper.", "grippers")
    ] = None
    hold: Annotated[
        str | None,
        _wish("--hold MASS", "An object that it is to hold, 0.3kg or 300g; one or two minutes more."),
    ] = None
    film: Annotated[str | None, _wish("--film NAME", "Slots for this film, as pvdf-28um, or none.")] = None
    family: Annotated[
        str | None, _wish("--family NAME", "What stands on the skin: ridge, pin, ring or flat.")
    ] = None
    thickness: Annotated[
        str | None, _wish("--thickness MM", "Thickness of the skin under its features: 8, in mm, or 8mm.")
    ] = None


def new(
    file: Annotated[Path, options.argument("FILE", "The TOML file to write.")],
    template: Annotated[
        str | None,
        option(
            "--template NAME",
            "Start from this design, scene or circuit, or a table: silicones, processes or grippers.",
            autocompletion=completes("starts"),
        ),
    ] = None,
    *,
    wish: WishOptions,
    workshop: options.Workshop,
    full: Annotated[bool, option("--full", "Write every key with its meaning.")] = False,
    as_json: options.Json = False,
) -> None:
    """Write a TOML file to edit, and its JSON schema: from a wish, or after a template.

    With any of --size, --touch, --silicone, --process, --gripper, --hold, --film and --thickness it chooses
    a castable pad that meets them, checks it, and says what it chose and why. What is not given is chosen
    too. That takes about 30 s, and with --hold one or two minutes more. In a terminal without options it
    asks. --family alone copies a template of that family.

    An editor that knows the schema completes and checks the file.
    """
    from skincad.outputs.tomls import HOME, check_new, document_name, first_of, write_new

    check_new(file)
    given: dict[str, Any] = {key: value for key, value in vars(wish).items() if value is not None}
    if template is not None and given:
        if wish.family is not None:
            raise InputError("family", "does not go with a template", wish.family, "leave one of them out")
        raise InputError("template", "does not go with a wish", template, f"leave out --{next(iter(given))}")
    if [*given] == ["family"]:
        template = first_of(given.pop("family"))
    terminal = all(stream and stream.isatty() for stream in (sys.stdin, sys.stdout))  # a closed one is None
    if not given and template is None and not as_json and terminal:
        given = _asked()
    if not given:
        if used := [key for key, value in vars(workshop).items() if value is not None]:
            raise InputError(used[0], "needs a wish", remedy="give one of --size, --touch, ... too")
        paths = [str(path) for path in write_new(file, HOME if template is None else template)]
        show({"files": paths}, as_json, paths)
        return
    from skincad.outputs.studies import write_wish

    with stage_bar(WISH_STAGES) as progress:
        name = document_name(file.stem)
        result = skincad.design_for(**given, **vars(workshop), name=name, progress=progress)
    paths = [str(path) for path in write_wish(file, result, full)]
    written = [f"  {'written':22} {' and '.join(paths)}"]
    lines = report(result, lambda step: step.replace("{design}", shlex.quote(paths[0])), more=written)
    show({**result.as_json(), "files": paths}, as_json, lines)
    leave(result)


def _asked() -> dict[str, str]:
    """Ask for each part of the wish; an answer that is none is asked again."""
    from skincad.outputs.tomls import listing
    from skincad.studies.wish import USUAL_FILM, USUAL_PROCESS, USUAL_TOUCH, film_of, force_of, size_of

    def ask(words: str, usual: str, check: Callable[[str], str]) -> str:
        with at_once():
            try:
                return str(typer.prompt(words, usual, value_proc=check))
            except typer.Abort as end:
                if isinstance(end.__context__, KeyboardInterrupt):
                    raise KeyboardInterrupt from None
                remedy = "give the rest as options: skincad new --help"
                raise InputError("FILE", "needs an answer to each question", remedy=remedy) from None

    def choose(words: str, table: str, usual: str) -> str:
        known = dict.fromkeys([*listing(table)[0]["entries"], usual])

        def named(text: str) -> str:
            if text not in known:
                raise typer.BadParameter(f"unknown; {did_you_mean(text, known)}")
            return text

        say(f"{words}: {', '.join(known)}")
        return ask(words, usual, named)

    def valid(check: Callable[[str], object]) -> Callable[[str], str]:
        def checked(text: str) -> str:
            try:
                check(text)
            except InputError as refused:
                raise typer.BadParameter(str(refused)) from None
            return text

        return checked

    say("A pad with ridges. Enter takes the value in brackets.")
    given = {"gripper": choose("Gripper", "grippers", "none")}
    usual = "its face" if given["gripper"] != "none" else "24x30"
    sized = valid(lambda text: None if text == usual else size_of(text))
    given["size"] = ask("Size in mm, across x along the ridges", usual, sized)
    touch = f"{USUAL_TOUCH:g}N"
    given["touch"] = ask("Force at which all ridges touch", touch, valid(force_of))
    given["process"] = choose("Mold by", "processes", USUAL_PROCESS)
    chosen = "the hardest that feels it"
    given["silicone"] = choose("Silicone", "silicones", chosen)
    given["film"] = ask("Film", USUAL_FILM, valid(film_of))
    unsaid = {"gripper": "none", "silicone": chosen, "size": usual}
    return {key: value for key, value in given.items() if unsaid.get(key) != value or value == "24x30"}
