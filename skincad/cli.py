"""The command line: thin commands over the package's functions."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from traceback import print_exc
from typing import TYPE_CHECKING, Annotated, Any, NoReturn, TextIO

import typer

import skincad
from skincad.base.bars import stage_bar, step_bar
from skincad.base.errors import ExhaustedError, InputError, RefusedError, exhausted, shown
from skincad.base.strictjson import strict_json

if TYPE_CHECKING:
    from skincad.base.stopwatch import Progress
    from skincad.inputs.design import Design
    from skincad.mechanics.film.answer import FilmStress

app = typer.Typer(
    name="skincad",
    help="Artificial robot skin with ridges: its solids and mold, files to make them, and what it will feel.",
    add_completion=False,
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)

TRACEBACK = "SKINCAD_TRACEBACK"  # the environment variable that lets a traceback of skincad's own faults pass

# typer carries a parser of its own; its public BadParameter leads to the base of its errors
_USAGE_ERROR: type[Exception] = typer.BadParameter.__mro__[2]

DesignArgument = Annotated[str, typer.Argument(metavar="DESIGN", help="A template's name or a TOML file.")]
SetOption = Annotated[
    list[str],
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Override a key, as in ridge.height=0.6; slot=none drops it.",
    ),
]
PrinterOption = Annotated[
    Path | None,
    typer.Option("--printer", metavar="FILE", help="A TOML file of your own processes: a printer.toml."),
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print one JSON object on stdout and nothing else.")]


def main() -> None:
    """Run the command line and exit: 0 done, 1 a check failed, 2 bad input, 3 a resource ran out or skincad
    itself failed, 130 interrupted, 143 terminated."""
    arguments = sys.argv[1:] or ["--help"]
    try:
        status = run(arguments)
    except InputError as failure:
        _leave(str(failure), 2)
    except _USAGE_ERROR as failure:
        text = failure.format_message() if hasattr(failure, "format_message") else str(failure)
        _leave(f"{text} (see skincad --help)", 2)
    except BrokenPipeError:  # the reader of our output has had enough
        _drop(sys.stdout)
        status = 0
    except KeyboardInterrupt:
        _leave("interrupted", 130)
    except SystemExit as end:  # SIGTERM's
        _leave("terminated", int(end.code or 0))
    except Exception as failure:  # whatever it is, no traceback reaches a user who has not asked for it
        if os.environ.get(TRACEBACK):
            print_exc()
        _leave(*_last_words(failure), as_json="--json" in arguments)
    sys.exit(status)


def run(arguments: list[str]) -> int:
    """Run a command and return its status; signals may break in here, and only here (`__main__.py`)."""
    status = 0
    try:
        with typer.main.get_command(app).make_context("skincad", arguments) as context:
            context.command.invoke(context)
    except typer.Exit as end:
        status = end.exit_code
    sys.stdout.flush()
    return status


def _last_words(failure: Exception) -> tuple[str, int]:
    """Return the line that tells of a failure that is nobody's input, and its status."""
    if lacking := exhausted(failure):
        return f"out of {lacking} ({str(failure) or type(failure).__name__}); allow more, or ask for less", 3
    if isinstance(failure, RefusedError):
        return str(failure), 3 if isinstance(failure, ExhaustedError) else 1
    what = f"internal error: {type(failure).__name__}: {failure}"
    return f"{what}; please report it with its traceback, which {TRACEBACK}=1 shows", 3


def _leave(message: str, status: int, *, as_json: bool = False) -> NoReturn:
    """Exit with a line on stderr, and the same as an object on stdout where that is asked for."""
    line = shown(" ".join(message.split()))
    _say(sys.stdout, json.dumps({"passed": False, "error": line}) + "\n" if as_json else "")
    _say(sys.stderr, f"skincad: {line}\n")
    sys.exit(status)


def _say(stream: TextIO, text: str) -> None:
    """Write where that can be; to whom it does not reach, the status tells what matters."""
    try:
        stream.write(text)
        stream.flush()
    except OSError:
        _drop(stream)


def _drop(stream: TextIO) -> None:
    """Let go whatever is still to be written to a stream, lest Python try again and fail at its end."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def _version(asked: bool) -> None:
    if asked:
        print(f"skincad {skincad.__version__}")
        raise typer.Exit


@app.callback()
def root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    """Artificial robot skin with ridges: its solids and mold, files to make them, and what it will feel."""


@app.command()
def templates(as_json: JsonOption = False) -> None:
    """List the designs and scenes that ship with skincad."""
    from skincad.inputs.catalog import KINDS, template_names, template_text

    rows = [
        f"{kind[:-1]:8} {name:22} {template_text(name, kind).splitlines()[0].lstrip('# ')}"
        for kind in KINDS
        for name in template_names(kind)
    ]
    _print({kind: template_names(kind) for kind in KINDS}, as_json, rows)


@app.command()
def new(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="The TOML file to write.")],
    template: Annotated[
        str, typer.Option("--template", metavar="NAME", help="Start from this design.")
    ] = "yamada-2002",
) -> None:
    """Write a commented design to edit, and its JSON schema.

    An editor that knows the schema completes and checks the file.
    """
    from skincad.outputs.newfile import write_new

    _print({}, False, [str(path) for path in write_new(file, template)])


@app.command()
def make(
    design: DesignArgument,
    settings: SetOption = [],  # noqa: B006
    out: Annotated[
        Path | None, typer.Option("-o", metavar="DIR", help="Out folder; default out/<name>.")
    ] = None,
    formats: Annotated[
        list[str],
        typer.Option(
            "--format",
            metavar="KIND",
            help="Only these files: step stl 3mf dxf svg png md toml; repeat for several.",
        ),
    ] = [],  # noqa: B006
    strict: Annotated[bool, typer.Option("--strict", help="Warnings fail too.")] = False,
    printer: PrinterOption = None,
    as_json: JsonOption = False,
) -> None:
    """Make skin and mold, check both, and write all files.

    STEP, STL, 3MF, DXF, SVG, a picture and a casting sheet appear in the out folder, whole or not at all.
    """
    from skincad.outputs.making import FORMATS, STAGES
    from skincad.outputs.making import make as run
    from skincad.outputs.wording import make_lines

    loaded = skincad.load(design, settings, printer=printer)
    with stage_bar(len(STAGES)) as progress:
        result = run(loaded, out, formats=tuple(formats) or FORMATS, strict=strict, progress=progress)
    _print(result.as_json(), as_json, make_lines(result))
    raise typer.Exit(0 if result.passed else 1)


@app.command()
def check(
    design: DesignArgument,
    settings: SetOption = [],  # noqa: B006
    force: Annotated[
        float | None, typer.Option("--force", metavar="N", help="Normal force; default the design's.")
    ] = None,
    tol: Annotated[
        float | None,
        typer.Option("--tol", metavar="REL", help="Relative error to meet; the mesh's alone with --tier."),
    ] = None,
    budget: Annotated[
        float | None, typer.Option("--budget", metavar="S", help="Seconds: the best that they buy.")
    ] = None,
    measured: Annotated[
        Path | None, typer.Option("--measured", metavar="CSV", help="Judge a cast part by its crest heights.")
    ] = None,
    tier: Annotated[
        str,
        typer.Option(
            "--tier",
            help="winkler, linear, corrected, finite-strain, corrected-finite-strain, solid, "
            "solid-finite-strain; auto: the cheapest that meets --tol, or else settles the verdict.",
        ),
    ] = "auto",
    printer: PrinterOption = None,
    stress: Annotated[
        Path | None,
        typer.Option("--stress", metavar="PNG", help="Draw the stress at S1 and S2 of each ridge."),
    ] = None,
    pull: Annotated[
        float | None,
        typer.Option("--pull", metavar="N", help="With --stress: tangential; default a quarter."),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Say from which force on all ridges touch a plate.

    Also the approach and the force of each ridge, each with its error.
    """
    from skincad.base.freshfile import checked_fresh
    from skincad.mechanics.touching import check as run
    from skincad.outputs.wording import check_lines, stress_lines

    if pull is not None and stress is None:
        raise InputError("--pull", "needs --stress", pull, "name the picture with --stress")
    if stress is not None:
        checked_fresh(stress, ".png", "--stress")
    loaded = skincad.load(design, settings, printer=printer)
    if stress is not None:
        from skincad.mechanics.film.stress import check_request

        check_request(loaded, loaded.contact.force if force is None else force, (pull or 0.0,))
    with stage_bar(4) as progress:
        result = run(
            loaded, force=force, tol=tol, budget=budget, tier=tier, measured=measured, progress=progress
        )
        states = [] if stress is None else _stress(loaded, result.force, pull, stress, progress)
    data = {**result.as_json(), **({"film_stress": [s.as_json() for s in states]} if states else {})}
    _print(data, as_json, [*check_lines(result), *(stress_lines(states, str(stress)) if states else [])])
    raise typer.Exit(0 if result.passed else 1)


def _stress(
    design: Design, force: float, pull: float | None, file: Path, progress: Progress | None
) -> list[FilmStress]:
    """Draw the films' stress under the normal force and under normal and tangential force (Fig 8)."""
    from skincad.base.freshfile import fresh
    from skincad.mechanics.film.stress import film_stresses
    from skincad.pictures.film_figures import film_stress_picture

    middle = (design.ridge.count + 1) // 2
    show = sorted({min(3, middle), middle})
    pulls = (0.0, force / 4 if pull is None else pull)
    states = film_stresses(design, force, pulls, show=show, progress=progress)
    with fresh(file, "--stress") as staging:
        film_stress_picture(states[0], states[1], staging)
    return list(states)


@app.command()
def circuit(
    source: Annotated[str, typer.Argument(metavar="CIRCUIT", help="A template's name or a TOML file.")],
    settings: Annotated[
        list[str],
        typer.Option("--set", metavar="KEY=VALUE", help="Override a key, as in amplifier.gain=1e6."),
    ] = [],  # noqa: B006
    measured: Annotated[
        Path | None,
        typer.Option(
            "--measured", metavar="CSV", help="Calibrate to columns frequency_Hz, gain_dB; any level."
        ),
    ] = None,
    out: Annotated[
        Path | None, typer.Option("-o", metavar="DIR", help="Out folder; default out/<name>.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Say gain against frequency, cut-off and slopes of film and amplifier.

    Writes gain.csv, gain.png and netlist.cir; with --measured also the calibrated circuit.
    """
    from skincad.circuit.model import load_circuit
    from skincad.outputs.circuit_job import circuit_job
    from skincad.outputs.wording import circuit_lines

    loaded = load_circuit(source, settings)
    with stage_bar(2) as progress:
        found, files = circuit_job(loaded, out, measured=measured, progress=progress)
    _print(
        {**found.as_json(), "files": files}, as_json, circuit_lines(found, [str(f["path"]) for f in files])
    )


@app.command()
def simulate(
    scene: Annotated[str, typer.Argument(metavar="SCENE", help="A template's name or a TOML file.")],
    settings: SetOption = [],  # noqa: B006
    tol: Annotated[
        float | None,
        typer.Option("--tol", metavar="REL", help="Relative error of the differential stress to meet."),
    ] = None,
    budget: Annotated[
        float | None, typer.Option("--budget", metavar="S", help="Seconds: the best that they buy.")
    ] = None,
    at: Annotated[
        list[int],
        typer.Option("--at", metavar="STEP", help="Draw the section with its stress there; repeatable."),
    ] = [],  # noqa: B006
    gif: Annotated[bool, typer.Option("--gif", help="Animate the section over the march.")] = False,
    out: Annotated[
        Path | None, typer.Option("-o", metavar="DIR", help="Out folder; default out/<name>.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """March a scene: press, pull, and say which ridge slips when.

    Only the effects that the scene names are computed. Signals as CSV and a picture appear in the out folder;
    after Ctrl-C what is done by then.
    """
    from skincad.outputs.wording import scene_lines
    from skincad.scenes.scene import load_scene

    drawn = [f"readout.steps={at}"] * bool(at) + ["readout.frames=24"] * gif
    try:
        loaded = load_scene(scene, [*settings, *drawn])
    except InputError as failure:
        if not (at and failure.key.startswith("readout.steps")):
            raise
        raise InputError("--at", failure.rule, failure.value, failure.remedy) from None
    target = Path("out") / loaded.name if out is None else out
    from skincad.outputs.scene_files import checked_scene_folder, write_scene

    checked_scene_folder(loaded, target)
    from skincad.scenes.simulation import simulate as run

    with step_bar(loaded.history.steps) as tick:
        found = run(loaded, tol=tol, budget=budget, tick=tick, partial=True)
    files = write_scene(found, target)
    _print(found.as_json(), as_json, [*scene_lines(found), f"{len(files)} files in {target}"])
    if found.march.interrupted:
        raise KeyboardInterrupt
    raise typer.Exit(1 if found.march.failed else 0)


@app.command()
def accuracy(
    design: DesignArgument,
    settings: SetOption = [],  # noqa: B006
    ladders: Annotated[
        list[str],
        typer.Option(
            "--ladder",
            metavar="NAME",
            help="Only these: tessellation, contact, circuit, slip, effects; repeat for several.",
        ),
    ] = [],  # noqa: B006
    repeats: Annotated[
        int, typer.Option("--repeats", metavar="N", help="Runs of each rung; the median counts.")
    ] = 3,
    out: Annotated[
        Path | None, typer.Option("-o", metavar="DIR", help="Out folder; default out/<name>.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Say what accuracy costs in time, on this design.

    Writes accuracy.csv and a diagram of error against time for each ladder of models and settings.
    """
    from skincad.outputs.accuracy_job import accuracy_job
    from skincad.outputs.accuracy_words import accuracy_lines

    loaded = skincad.load(design, settings)
    with stage_bar(1) as progress:
        found, files = accuracy_job(loaded, tuple(ladders), out, repeats=repeats, progress=progress)
    lines = [*accuracy_lines(found), *(f"  {f['path']}" for f in files)]
    _print({**found.as_json(), "files": files}, as_json, lines)


@app.command("fit-material")
def fit_material(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="CSV",
            help="Columns approach_mm, force_N (a pad); strain, stress_MPa or extension_mm, force_N (a bar).",
        ),
    ],
    design: Annotated[
        str | None, typer.Option("--design", metavar="DESIGN", help="The pad that a flat plate pressed.")
    ] = None,
    settings: SetOption = [],  # noqa: B006
    up_to: Annotated[
        float | None,
        typer.Option(
            "--up-to", metavar="X", help="Largest strain (default 0.3) or, of a pad, force in N used."
        ),
    ] = None,
    gauge_length: Annotated[
        float | None, typer.Option("--gauge-length", metavar="MM", help="Of a bar, with extension_mm.")
    ] = None,
    area: Annotated[
        float | None, typer.Option("--area", metavar="MM2", help="Cross-section of a bar, with extension_mm.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option("-o", metavar="FILE", help="Write the design with this modulus.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Say the silicone's modulus, with its error, from a test.

    The test is force against approach of a cast pad, or the stress of a bar pulled or squeezed.
    """
    from skincad.base.freshfile import checked_fresh
    from skincad.material.fit import fit_material as run
    from skincad.outputs.designcopy import write_with_modulus
    from skincad.outputs.wording import material_lines

    for option, given in (("--set", settings), ("-o", out)):
        if given and design is None:
            raise InputError(option, "needs --design", remedy="name the design with --design")
    loaded = skincad.load(design, settings) if design else None
    if out is not None:
        checked_fresh(out, ".toml", "-o")
    with stage_bar(6) as progress:
        found = run(file, loaded, up_to=up_to, gauge_length=gauge_length, area=area, progress=progress)
    if out is not None and design is not None:
        write_with_modulus(out, design, settings, found.ranged, f"measured: {found.kind} test {file.name}")
    data = {**found.as_json(), "file": str(out) if out else None}
    _print(data, as_json, [*material_lines(found), *([f"written to {out}"] if out else [])])


def _print(data: dict[str, Any], as_json: bool, lines: list[str]) -> None:
    """Print a command's result. A reader who has had enough, as `head`, does not change its status."""
    try:
        print(strict_json(data) if as_json else "\n".join(map(shown, lines)), flush=True)
    except BrokenPipeError:
        _drop(sys.stdout)
