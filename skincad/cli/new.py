"""The command `new`."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Annotated, Any

import typer

from skincad.base.errors import InputError, did_you_mean
from skincad.base.interrupt import at_once
from skincad.base.progress import stage_bar
from skincad.cli.options import (
    GrippersOption,
    JsonOption,
    PrinterOption,
    SiliconesOption,
    completes,
    leave,
    report,
    say,
    show,
)

WISH_STAGES = 5  # of its bar at first: shape, two checks of the curvature, the last check


def _starts() -> Iterable[str]:
    from skincad.outputs.tomls import start_names

    return start_names()


def _listed(table: str) -> Callable[[], Iterable[str]]:
    def names() -> Iterable[str]:
        from skincad.outputs.tomls import listing

        return list(listing(table)[0]["entries"])

    return names


def _wish(name: str, metavar: str, words: str, table: str = "") -> Any:
    """An option of the wish; its names are completed from a table that ships."""
    names = completes(_listed(table)) if table else None
    return typer.Option(name, metavar=metavar, help=words, autocompletion=names, rich_help_panel="Wish")


def new(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="The TOML file to write.")],
    template: Annotated[
        str | None,
        typer.Option(
            "--template",
            metavar="NAME",
            help="Start from this design, scene or circuit, or a table: silicones, processes or grippers.",
            autocompletion=completes(_starts),
        ),
    ] = None,
    size: Annotated[
        str | None,
        _wish("--size", "WxL", "The pad, across and along its ridges: 24x30, in mm, or 2.4x3cm."),
    ] = None,
    touch: Annotated[
        str | None, _wish("--touch", "N", "The force at which all features are to touch: 1N or 500mN.")
    ] = None,
    silicone: Annotated[
        str | None, _wish("--silicone", "NAME", "Cast in this silicone.", "silicones")
    ] = None,
    process: Annotated[str | None, _wish("--process", "NAME", "Make the mold by this.", "processes")] = None,
    gripper: Annotated[
        str | None, _wish("--gripper", "NAME", "Drill the carrier for this gripper.", "grippers")
    ] = None,
    film: Annotated[
        str | None, _wish("--film", "NAME", "Slots for this film, as pvdf-28um, or none.")
    ] = None,
    family: Annotated[
        str | None, _wish("--family", "NAME", "What stands on the skin: ridge, pin, ring or flat.")
    ] = None,
    thickness: Annotated[
        str | None, _wish("--thickness", "MM", "Thickness of the skin under its features: 8, in mm, or 8mm.")
    ] = None,
    printer: PrinterOption = None,
    silicones: SiliconesOption = None,
    grippers: GrippersOption = None,
    full: Annotated[bool, typer.Option("--full", help="Write every key with its meaning.")] = False,
    as_json: JsonOption = False,
) -> None:
    """Write a TOML file to edit, and its JSON schema: from a wish, or after a template.

    With any of --size, --touch, --silicone, --process, --gripper, --film and --thickness it chooses a
    castable pad that meets them, checks it, and says what it chose and why. What is not given is chosen too.
    That takes about 30 s. In a terminal without options it asks. --family alone copies a template of that
    family.

    An editor that knows the schema completes and checks the file.
    """
    from skincad.outputs.tomls import HOME, check_new, first_of, write_new

    check_new(file)
    wish = {
        "size": size,
        "touch": touch,
        "silicone": silicone,
        "process": process,
        "gripper": gripper,
        "film": film,
        "thickness": thickness,
    }
    given: dict[str, Any] = {key: value for key, value in wish.items() if value is not None}
    own = {"printer": printer, "silicones": silicones, "grippers": grippers}
    if family is not None and template is not None:
        raise InputError("family", "does not go with a template", family, "leave one of them out")
    if given and template is not None:
        raise InputError("template", "does not go with a wish", template, f"leave out --{next(iter(given))}")
    if not given and family is not None:
        template = first_of(family)
    elif family is not None:
        given["family"] = family
    if not given and template is None and not as_json and _at_a_terminal():
        given = _asked()
    if not given:
        if used := [key for key, value in own.items() if value is not None]:
            raise InputError(used[0], "needs a wish", remedy="give one of --size, --touch, ... too")
        paths = [str(path) for path in write_new(file, HOME if template is None else template)]
        show({"files": paths}, as_json, "\n".join(paths))
        return
    _write_wish(file, given, own, full, as_json)


def _write_wish(file: Path, given: dict[str, Any], own: dict[str, Any], full: bool, as_json: bool) -> None:
    import skincad
    from skincad.outputs.studies import write_wish
    from skincad.outputs.tomls import document_name

    with stage_bar(WISH_STAGES) as progress:
        result = skincad.design_for(**given, **own, name=document_name(file.stem), progress=progress)
    paths = [str(path) for path in write_wish(file, result, full)]
    written = [f"  {'written':22} {' and '.join(paths)}"]
    lines = report(result, lambda step: step.replace("{design}", shlex.quote(paths[0])), more=written)
    show({**result.as_json(), "files": paths}, as_json, "\n".join(lines))
    leave(result)


def _at_a_terminal() -> bool:
    """Whether a person can be asked; a closed stream is None."""
    return all(stream is not None and stream.isatty() for stream in (sys.stdin, sys.stdout))


def _asked() -> dict[str, str]:
    """Ask for each part of the wish; an answer that is none is asked again."""
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
        known = dict.fromkeys([*_listed(table)(), usual])

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
