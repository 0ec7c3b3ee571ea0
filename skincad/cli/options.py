"""Options that several commands have, each declared once, and sets of them that go together.

A command names a set as one parameter; `expanded` gives typer its options one by one, in that place.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass
from functools import wraps
from inspect import Parameter, Signature, signature
from pathlib import Path
from typing import Annotated, Any, get_type_hints

import typer


def completes(kind: str) -> Any:
    """Return what completes a word from the names of a kind that ship, or of `kinds`; `starts`: of all that
    `new` copies."""

    def names(incomplete: str) -> list[str]:
        from skincad.inputs.catalog import template_names
        from skincad.outputs.tomls import LISTS, listing, start_names

        if kind in ("silicones", "processes", "grippers"):
            words = listing(kind)[0]["entries"]
        elif kind in LISTS:
            words = template_names(kind)  # type: ignore[arg-type]
        else:
            words = start_names() if kind == "starts" else LISTS
        return [word for word in words if word.startswith(incomplete)]

    return names


def option(head: str, text: str, **more: Any) -> Any:
    """Return an option by its line in --help: `head` is its flags, and what stands for its value, if any."""
    *flags, last = head.split()
    flags, metavar = ([*flags, last], None) if last.startswith("-") else (flags, last)
    return typer.Option(*flags, metavar=metavar, help=text, **more)


def argument(metavar: str, text: str = "A template's name or a TOML file.", **more: Any) -> Any:
    """Return an argument by its line in --help."""
    return typer.Argument(metavar=metavar, help=text, **more)


DesignSource = Annotated[str, argument("DESIGN", autocompletion=completes("designs"))]
Subject = Annotated[
    str, argument("DESIGN", "A template's name or a TOML file: a design, a scene or a circuit.")
]
Settings = Annotated[
    list[str], option("--set KEY=VALUE", "Override a key: ridge.height=0.6; slot=none drops it.")
]
Silicones = Annotated[
    Path | None, option("--silicones FILE", "A TOML file of your own silicones, a lab.toml.")
]
Printer = Annotated[
    Path | None, option("--printer FILE", "A TOML file of your own processes, a printer.toml.")
]
Out = Annotated[Path | None, option("-o --out DIR", "The folder to write to; default: out/<name>.")]
Force = Annotated[float | None, option("--force N", "Normal force; default: the design's.")]
Hold = Annotated[
    str | None,
    option(
        "--hold MASS",
        "Of a design: march drawn lifts of an object of 0.3kg or 300g by the mount's gripper; 20 s each row.",
    ),
]
Budget = Annotated[float | None, option("--budget S", "Seconds to spend; gives the best answer they allow.")]
Model = Annotated[
    str,
    option(
        "--model --tier",
        "winkler, reduced, linear, corrected, finite-strain, corrected-finite-strain, solid, "
        "solid-finite-strain; auto: the cheapest that meets --tol or settles the verdict.",
    ),
]
Advice = Annotated[
    bool | None,
    option(
        "--advice/--no-advice",
        "Look for changes with which a design that fails would pass. Default: for as long as the check "
        "took, or 10 s; --advice takes as long as it needs.",
        show_default=False,
    ),
]
Formats = Annotated[
    list[str], option("--format KIND", "Only files of this kind, as step, stl or 3mf; repeat for several.")
]
View = Annotated[bool, option("--open", "Open view.html, the design to turn, in a browser.")]
Fresh = Annotated[bool, option("--fresh/--resume", "Ask all anew, or what the folder's log has not.")]
Json = Annotated[bool, option("--json", "Print one JSON object on stdout and nothing else.")]
Verbose = Annotated[bool, option("-v --verbose", "Print all numbers, and how they were found.")]


@dataclass(frozen=True, kw_only=True)
class Workshop:
    """Files of a person's own processes, silicones and grippers."""

    printer: Printer = None
    silicones: Silicones = None
    grippers: Annotated[
        Path | None, option("--grippers FILE", "A TOML file of your own grippers, for mold.mount.")
    ] = None


@dataclass(frozen=True, kw_only=True)
class Evaluations:
    """Where a study's evaluations run, and whether its log counts."""

    workers: Annotated[int, option("--workers N", "Processes on this machine.")] = 1
    dask: Annotated[
        str | None, option("--dask ADDRESS", "A Dask cluster's scheduler, as tcp://host:8786.")
    ] = None
    fresh: Fresh = False


@dataclass(frozen=True, kw_only=True)
class Display:
    """How an answer is printed."""

    verbose: Verbose = False
    as_json: Json = False

    @property
    def full(self) -> bool:
        """Whether all numbers are."""
        return self.verbose or self.as_json


def expanded(command: Callable[..., None]) -> Callable[..., None]:
    """Return a command with the fields of its option sets as its own parameters, each set's in its place."""
    hints = get_type_hints(command, include_extras=True)
    sets: dict[str, Any] = {name: hint for name, hint in hints.items() if is_dataclass(hint)}
    parameters = list[Parameter]()
    for name, parameter in signature(command).parameters.items():
        kind = sets.get(name, command)
        parts = signature(kind).parameters if name in sets else {name: parameter}
        types = get_type_hints(kind, include_extras=True)
        parameters += [
            Parameter(key, Parameter.KEYWORD_ONLY, default=part.default, annotation=types[key])
            for key, part in parts.items()
        ]

    @wraps(command)
    def call(**given: Any) -> None:
        records = {
            name: kind(**{field.name: given.pop(field.name) for field in fields(kind)})
            for name, kind in sets.items()
        }
        command(**given, **records)

    call.__signature__ = Signature(parameters)  # type: ignore[attr-defined]
    call.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    return call
