"""What the commands share: their arguments and options, the out folder, and how a result is handed on."""

from __future__ import annotations

import os
import re
import shlex
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from skincad.base.errors import shown
from skincad.base.interrupt import INTERRUPTED, safe_point
from skincad.base.reading import strict_json

if TYPE_CHECKING:
    from skincad.base.result import Result
    from skincad.outputs.delivery import Delivery


def completes(names: Any) -> Any:
    """Return what completes a word of the command line from the names that a function gives."""
    return lambda incomplete: [name for name in names() if name.startswith(incomplete)]


def _template_names(kind: str) -> Any:
    def names() -> Iterable[str]:
        from skincad.inputs.catalog import template_names

        return template_names(kind)  # type: ignore[arg-type]

    return names


def source_argument(metavar: str, kind: str) -> Any:
    """Return the argument that names a template of this kind, or a file."""
    text = "A template's name or a TOML file."
    return typer.Argument(metavar=metavar, help=text, autocompletion=completes(_template_names(kind)))


DesignArgument = Annotated[str, source_argument("DESIGN", "designs")]
SubjectArgument = Annotated[
    str,
    typer.Argument(
        metavar="DESIGN", help="A template's name or a TOML file: a design, a scene or a circuit."
    ),
]
SetOption = Annotated[
    list[str],
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Override a key: ridge.height=0.6; slot=none drops it.",
    ),
]
PrinterOption = Annotated[
    Path | None,
    typer.Option("--printer", metavar="FILE", help="A TOML file of your own processes, a printer.toml."),
]
SiliconesOption = Annotated[
    Path | None,
    typer.Option("--silicones", metavar="FILE", help="A TOML file of your own silicones, a lab.toml."),
]
GrippersOption = Annotated[
    Path | None,
    typer.Option("--grippers", metavar="FILE", help="A TOML file of your own grippers, for mold.mount."),
]
OutOption = Annotated[
    Path | None,
    typer.Option("-o", "--out", metavar="DIR", help="The folder to write to; default: out/<name>."),
]
ForceOption = Annotated[
    float | None, typer.Option("--force", metavar="N", help="Normal force; default: the design's.")
]
BudgetOption = Annotated[
    float | None,
    typer.Option("--budget", metavar="S", help="Seconds to spend; gives the best answer they allow."),
]
ModelOption = Annotated[
    str,
    typer.Option(
        "--model",
        "--tier",
        help="winkler, reduced, linear, corrected, finite-strain, corrected-finite-strain, solid, "
        "solid-finite-strain; auto: the cheapest that meets --tol or settles the verdict.",
    ),
]
AdviceOption = Annotated[
    bool | None,
    typer.Option(
        "--advice/--no-advice",
        help="Look for changes with which a design that fails would pass. Default: for as long as the check "
        "took, or 10 s; --advice takes as long as it needs.",
        show_default=False,
    ),
]
FormatOption = Annotated[
    list[str],
    typer.Option(
        "--format", metavar="KIND", help="Only files of this kind, as step, stl or 3mf; repeat for several."
    ),
]
OpenOption = Annotated[bool, typer.Option("--open", help="Open view.html, the design to turn, in a browser.")]
ScenesOption = Annotated[
    list[str],
    typer.Option(
        "--scene",
        metavar="SCENE",
        help="A scene's template or TOML file, run with this skin for report.html; repeat for several.",
        autocompletion=completes(_template_names("scenes")),
    ),
]
WorkersOption = Annotated[int, typer.Option("--workers", metavar="N", help="Processes on this machine.")]
DaskOption = Annotated[
    str | None,
    typer.Option("--dask", metavar="ADDRESS", help="A Dask cluster's scheduler, as tcp://host:8786."),
]
FreshOption = Annotated[
    bool, typer.Option("--fresh/--resume", help="Ask all anew, or what the folder's log has not.")
]
VerboseOption = Annotated[
    bool, typer.Option("-v", "--verbose", help="Print all numbers, and how they were found.")
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print one JSON object on stdout and nothing else.")]


def out_folder(folder: Path | None, default: str | Path, command: str, names: Iterable[str]) -> Path:
    """Return where a command writes its files, out/<default> unless it is told; raises InputError, before
    any work, where they can't be written."""
    from skincad.outputs.delivery import ready

    target = folder or Path("out") / default
    ready(target, command, names)
    return target


def say(text: str) -> None:
    """Print lines. A reader who has had enough, as `head`, does not change a command's status."""
    safe_point()
    _print_lines(text)


def _print_lines(text: str) -> None:
    _print("\n".join(shown(line) for line in text.split("\n")))


def show(data: dict[str, Any], as_json: bool, text: str) -> None:
    """Print a command's result."""
    safe_point()
    _print_result(data, as_json, text)


def _print_result(data: dict[str, Any], as_json: bool, text: str) -> None:
    if as_json:
        _print(strict_json(data))
    else:
        _print_lines(text)


def as_typed(
    source: str, settings: Iterable[str], force: float | None = None, **options: object
) -> Callable[[str], str]:
    """Return what fills a result's next step with the design as it is typed, and the `force` N as a setting.

    What the next step gives anew is left out; so is an option that is None.
    """
    given = list(settings)
    if force is not None:
        given = [text for text in given if not text.startswith("contact.force=")]
        given.append(f"contact.force={force:g}")

    def fill(step: str) -> str:
        changed = set(re.findall(r"--set '?([^\s=']+)=", step))
        kept = [setting for setting in given if setting.partition("=")[0].strip() not in changed]
        words = [source, *(word for setting in kept for word in ("--set", setting))]
        for name, value in options.items():
            if value is not None and f"--{name} " not in step:
                words += [f"--{name}", str(value)]
        return re.sub(r"\{\w+\}", lambda _: shlex.join(words), step)

    return fill


def report(
    result: Result,
    typed: Callable[[str], str] | None = None,
    *,
    verbose: bool = False,
    more: Iterable[str] = (),
    last: bool = True,
) -> list[str]:
    """Return what a command prints of a result: the answer, how sure it is, `more`, what to do next if it
    is known (`last`), and if `verbose` all numbers."""
    presenter = result.presenter()
    after = presenter.details(result) if verbose else []
    return [*presenter.lines(result), *more, *(result.next_line(typed) if last else []), *after]


def deliver(
    result: Result,
    as_json: bool,
    written: Delivery,
    typed: Callable[[str], str] | None = None,
    *,
    verbose: bool = False,
    last: bool = True,
) -> None:
    """Print a result, and what was written of it: its files lie there, so nothing is undone any more."""
    data = result.as_json()
    seconds = data.get("seconds", {})
    total = seconds.get("total", 0.0) + written.seconds["total"]
    data |= {"files": written.sizes(), "seconds": {**seconds, **written.seconds, "total": total}}
    more = [f"  files          {written}, {total:.1f} s"]
    named = re.findall(r"[\w-]+\.(?:html|png)", "".join(result.next_line()))
    last = last and {name for name, _ in written.files}.issuperset(named)  # it names no missing file
    lines = [] if as_json else report(result, typed, verbose=verbose, more=more, last=last)
    _print_result(data, as_json, "\n".join(lines))


def leave(result: Result) -> None:
    """End a command with its result's status."""
    if result.exit_status == INTERRUPTED:
        raise KeyboardInterrupt
    raise typer.Exit(result.exit_status)


def _print(text: str) -> None:
    try:
        print(text, flush=True)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
