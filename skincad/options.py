"""What the commands share: their arguments and options, and how a result is handed on."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from skincad.base.errors import InputError, shown
from skincad.base.strictjson import strict_json

if TYPE_CHECKING:
    from skincad.base.result import Result
    from skincad.inputs.design import Design
    from skincad.outputs.delivery import Written
    from skincad.scenes.simulation import Simulation


def _names(kind: str) -> Any:
    """What completes a template's name."""

    def complete(incomplete: str) -> list[str]:
        from skincad.inputs.catalog import template_names

        return [name for name in template_names(kind) if name.startswith(incomplete)]  # type: ignore[arg-type]

    return complete


def source_argument(metavar: str, kind: str) -> Any:
    """Return the argument that names a template of this kind, or a file."""
    text = "A template's name or a TOML file."
    return typer.Argument(metavar=metavar, help=text, autocompletion=_names(kind))


DesignArgument = Annotated[str, source_argument("DESIGN", "designs")]
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
OutOption = Annotated[
    Path | None,
    typer.Option("-o", "--out", metavar="DIR", help="The folder to write to; default: out/<name>."),
]
BudgetOption = Annotated[
    float | None,
    typer.Option("--budget", metavar="S", help="Seconds to spend; gives the best answer they allow."),
]
TierOption = Annotated[
    str,
    typer.Option(
        "--model",
        "--tier",
        help="winkler, linear, corrected, finite-strain, corrected-finite-strain, solid, "
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
ScenesOption = Annotated[
    list[str],
    typer.Option(
        "--scene",
        metavar="SCENE",
        help="A scene's template or TOML file, run with this skin for report.html; repeat for several.",
        autocompletion=_names("scenes"),
    ),
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print one JSON object on stdout and nothing else.")]


def simulated(sources: list[str], design: Design, preview: bool = False) -> list[Simulation]:
    """Return scenes as they run with a design's skin; all are read before the first one is run. A preview
    takes none."""
    import skincad
    from skincad.base.bars import step_bar

    if sources and preview:
        raise InputError("scenes", "are for the report, which --preview leaves out", remedy="leave one out")

    found = []
    for scene in [skincad.load_scene(source, skin=design) for source in sources]:
        with step_bar(scene.history.step_count) as tick:
            found.append(skincad.simulate(scene, tick=tick))
    return found


def say(text: str) -> None:
    """Print lines. A reader who has had enough, as `head`, does not change a command's status."""
    _print("\n".join(shown(line) for line in text.split("\n")))


def deliver(found: Result, as_json: bool, written: Written | None = None) -> None:
    """Print a result, and what was written of it."""
    data = found.as_json()
    if written is None:
        show(data, as_json, str(found))
        return
    spent, more = data.get("seconds", {}), written.seconds
    total = spent.get("total", 0.0) + more["total"]
    data |= {"files": written.as_json(), "seconds": {**spent, **more, "total": total}}
    show(data, as_json, f"{found}\n{written}, {total:.1f} s")


def show(data: dict[str, Any], as_json: bool, text: str) -> None:
    """Print a command's result."""
    if as_json:
        _print(strict_json(data))
    else:
        say(text)


def _print(text: str) -> None:
    try:
        print(text, flush=True)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
