"""The commands: each loads, computes, and hands its result on."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import skincad
from skincad.base.bars import stage_bar, step_bar
from skincad.base.errors import InputError
from skincad.coupon_command import coupon
from skincad.live_command import live
from skincad.make_commands import advised, make, watch
from skincad.options import (
    AdviceOption,
    BudgetOption,
    DesignArgument,
    JsonOption,
    OutOption,
    PrinterOption,
    SetOption,
    SiliconesOption,
    TierOption,
    deliver,
    say,
    show,
    source_argument,
)
from skincad.package_command import package
from skincad.study_commands import optimise, solve, sweep

if TYPE_CHECKING:
    pass

app = typer.Typer(
    name="skincad",
    help="Artificial robot skin with ridges: its solids and mold, files to make them, and what it will feel.",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)


def _starts(incomplete: str) -> list[str]:
    """What completes the name of what `new` starts from."""
    from skincad.outputs.newfile import start_names

    return [name for name in start_names() if name.startswith(incomplete)]


def _kinds(incomplete: str) -> list[str]:
    """What completes a kind of what ships."""
    from skincad.outputs.lists import LISTS

    return [kind for kind in LISTS if kind.startswith(incomplete)]


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
def templates(
    kind: Annotated[
        str | None,
        typer.Argument(
            metavar="KIND",
            help="List one kind: designs, scenes, circuits, studies, silicones or processes.",
            autocompletion=_kinds,
        ),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """List the templates, silicones and processes that ship.

    Templates are designs, scenes, circuits and studies. With KIND, silicones and processes come with their
    values, ranges and sources.
    """
    from skincad.outputs.lists import listing

    data, lines = listing(kind)
    show(data, as_json, "\n".join(lines))


@app.command()
def new(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="The TOML file to write.")],
    template: Annotated[
        str,
        typer.Option(
            "--template",
            metavar="NAME",
            help="Start from this design, scene or circuit, or from a table: silicones or processes.",
            autocompletion=_starts,
        ),
    ] = "designs/yamada-2002",
) -> None:
    """Write a commented TOML file to edit, and its JSON schema.

    It is a design, a scene or a circuit, or a table of silicones or processes. An editor that knows the
    schema completes and checks the file.
    """
    from skincad.outputs.newfile import write_new

    show({}, False, "\n".join(map(str, write_new(file, template))))


app.command()(make)
app.command()(watch)
app.command()(coupon)
app.command()(package)


@app.command()
def check(
    source: DesignArgument,
    settings: SetOption = [],  # noqa: B006
    force: Annotated[
        float | None, typer.Option("--force", metavar="N", help="Normal force; default: the design's.")
    ] = None,
    tol: Annotated[
        float | None,
        typer.Option("--tol", metavar="REL", help="Relative error to meet; with --tier, the mesh's alone."),
    ] = None,
    budget: BudgetOption = None,
    measured: Annotated[
        Path | None, typer.Option("--measured", metavar="CSV", help="Judge a cast part by its crest heights.")
    ] = None,
    tier: TierOption = "auto",
    printer: PrinterOption = None,
    silicones: SiliconesOption = None,
    stress: Annotated[
        Path | None,
        typer.Option("--stress", metavar="PNG", help="Draw the stress at S1 and S2 of each ridge."),
    ] = None,
    tangential: Annotated[
        float | None,
        typer.Option(
            "--pull",
            metavar="N",
            help="With --stress: tangential force; default: a quarter of the normal one.",
        ),
    ] = None,
    advice: AdviceOption = None,
    as_json: JsonOption = False,
) -> None:
    """Say whether all ridges touch a plate.

    Prints the force it takes, the approach and the force on each ridge too, each with its error.
    """
    from skincad.base.freshfile import checked_fresh, fresh

    if tangential is not None and stress is None:
        raise InputError("tangential", "needs --stress", tangential, "name the picture with --stress")
    if stress is not None:
        checked_fresh(stress, ".png", "stress")
    design = skincad.load(source, settings, printer=printer, silicones=silicones)
    if stress is not None:
        from skincad.mechanics.film.stress import check_request

        check_request(design, design.contact.force if force is None else force, (tangential or 0.0,))
    with stage_bar(4) as progress:
        found = skincad.check(
            design,
            force=force,
            tol=tol,
            budget=budget,
            tier=tier,
            measured=measured,
            progress=progress,
        )
        films = None
        if stress is not None:
            films = skincad.film_stress(design, found.force, tangential, progress=progress)
            (draw,) = films.files().values()
            with fresh(stress, "stress") as staging:
                draw(staging)
    if not as_json:
        say(str(found) if films is None else f"{found}\n{films}\n  picture        {stress}")
    if measured is None:
        found = advised(design, found, advice, budget, as_json)
    if as_json:
        show(found.as_json() | (films.as_json() if films else {}), True, "")
    raise typer.Exit(0 if found.passed else 1)


@app.command()
def circuit(
    source: Annotated[str, source_argument("CIRCUIT", "circuits")],
    settings: Annotated[
        list[str],
        typer.Option("--set", metavar="KEY=VALUE", help="Override a key: amplifier.gain=1e6."),
    ] = [],  # noqa: B006
    measured: Annotated[
        Path | None,
        typer.Option(
            "--measured",
            metavar="CSV",
            help="Calibrate to a measured curve: columns frequency_Hz, gain_dB; any level.",
        ),
    ] = None,
    folder: OutOption = None,
    as_json: JsonOption = False,
) -> None:
    """Show how film and amplifier respond to frequency.

    Prints the gain, its cut-off and its slopes, and writes gain.csv, gain.png and netlist.cir; with
    --measured also the calibrated circuit.
    """
    from skincad.outputs.delivery import ready
    from skincad.outputs.gains import COMMAND, names

    loaded = skincad.load_circuit(source, settings)
    target = folder or Path("out") / loaded.name
    ready(target, COMMAND, names(measured is not None))
    with stage_bar(2) as progress:
        found = skincad.gain(loaded, measured, progress)
    deliver(found, as_json, skincad.write(found, target))


@app.command()
def simulate(
    source: Annotated[str, source_argument("SCENE", "scenes")],
    settings: SetOption = [],  # noqa: B006
    silicones: SiliconesOption = None,
    tol: Annotated[
        float | None,
        typer.Option("--tol", metavar="REL", help="Relative error of the differential stress to meet."),
    ] = None,
    budget: BudgetOption = None,
    at: Annotated[
        list[int],
        typer.Option(
            "--at", metavar="STEP", help="Draw the section with its stress at this step; repeat for several."
        ),
    ] = [],  # noqa: B006
    gif: Annotated[bool, typer.Option("--gif", help="Animate the section over the scene.")] = False,
    folder: OutOption = None,
    as_json: JsonOption = False,
) -> None:
    """Run a scene, and say which ridge slips when.

    Only the effects that the scene names are computed. Signals as CSV and a picture appear in the output
    folder; Ctrl-C keeps what is done by then.
    """
    from skincad.inputs.catalog import setting_key

    for key, option, given in (("readout.steps", "at", at), ("readout.frames", "gif", gif)):
        if given and key in map(setting_key, settings):
            raise InputError(option, f"gives {key}, and --set does too", remedy="leave one of them out")
    drawn = [f"readout.steps={at}"] * bool(at) + ["readout.frames=24"] * gif
    try:
        scene = skincad.load_scene(source, [*settings, *drawn], silicones=silicones)
    except InputError as failure:
        if not (at and failure.key.startswith("readout.steps")):
            raise
        raise InputError("at", failure.rule, failure.value, failure.remedy) from None
    from skincad.outputs.delivery import ready
    from skincad.outputs.simulations import COMMAND, names

    target = folder or Path("out") / scene.name
    ready(target, COMMAND, names(scene))
    with step_bar(scene.history.step_count) as tick:
        found = skincad.simulate(scene, tol=tol, budget=budget, tick=tick, partial=True)
    deliver(found, as_json, skincad.write(found, target))
    if found.march.interrupted:
        raise KeyboardInterrupt
    raise typer.Exit(1 if found.march.failed else 0)


@app.command()
def accuracy(
    source: DesignArgument,
    settings: SetOption = [],  # noqa: B006
    ladders: Annotated[
        list[str],
        typer.Option(
            "--ladder",
            metavar="NAME",
            help="Only these: tessellation, contact, circuit, slip, effects; repeat for several.",
        ),
    ] = [],  # noqa: B006
    silicones: SiliconesOption = None,
    repeats: Annotated[
        int, typer.Option("--repeats", metavar="N", help="Runs of each setting, whose median is taken.")
    ] = 3,
    folder: OutOption = None,
    as_json: JsonOption = False,
) -> None:
    """Show what accuracy costs in time on this design.

    Writes accuracy.csv and a diagram of error against time for each ladder of models and settings. What
    check's models took (ladder contact) is kept in your cache folder: check --budget chooses by it.
    """
    from skincad.outputs.accuracies import COMMAND, names
    from skincad.outputs.delivery import ready

    design = skincad.load(source, settings, silicones=silicones)
    target = folder or Path("out") / design.name
    ready(target, COMMAND, names(ladders))
    with stage_bar(1) as progress:
        found = skincad.accuracy(design, ladders, repeats=repeats, progress=progress).keep()
    deliver(found, as_json, skincad.write(found, target))


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
        str | None,
        typer.Option("--design", metavar="DESIGN", help="The design of the pad that a flat plate pressed."),
    ] = None,
    settings: SetOption = [],  # noqa: B006
    silicones: SiliconesOption = None,
    up_to: Annotated[
        float | None,
        typer.Option(
            "--up-to",
            metavar="X",
            help="Largest strain used (default: 0.3) or, for a pad, largest force in N.",
        ),
    ] = None,
    gauge_length: Annotated[
        float | None,
        typer.Option("--gauge-length", metavar="MM", help="Gauge length of a bar, with extension_mm."),
    ] = None,
    area: Annotated[
        float | None, typer.Option("--area", metavar="MM2", help="Cross-section of a bar, with extension_mm.")
    ] = None,
    copy: Annotated[
        Path | None,
        typer.Option("-o", "--out", metavar="FILE", help="Write a copy of the design with modulus and law."),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Find the silicone's modulus and its error from a test, and from a bar's its law.

    The test is force against approach of a cast pad, or stress against strain of a bar pulled or squeezed.
    Laws of rubber are fitted to the first half of a bar's strains, and judged by the second.
    """
    from skincad.base.freshfile import checked_fresh

    for name, given in (("settings", settings), ("silicones", silicones), ("copy", copy)):
        if given and design is None:
            raise InputError(name, "needs --design", remedy="name the design with --design")
    loaded = skincad.load(design, settings, silicones=silicones) if design else None
    if copy is not None:
        checked_fresh(copy, ".toml", "copy")
    with stage_bar(6) as progress:
        found = skincad.fit_material(
            file, loaded, up_to=up_to, gauge_length=gauge_length, area=area, progress=progress
        )
    written = ""
    if copy is not None and design is not None:
        from skincad.outputs.designcopy import write_with_modulus

        said = f"measured: {found.kind} test {file.name}"
        write_with_modulus(copy, design, settings, found.ranged, found.law, said, silicones)
        written = f"\nwritten to {copy}"
    show({**found.as_json(), "file": str(copy) if copy else None}, as_json, f"{found}{written}")


app.command()(solve)
app.command()(sweep)
app.command()(optimise)
app.command()(live)
