"""The commands of what was measured: `coupon`, `fit-material`, `accept`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import skincad
from skincad.base.errors import InputError
from skincad.base.progress import stage_bar
from skincad.cli import options
from skincad.cli.options import argument, completes, option
from skincad.cli.printing import as_typed, deliver, leave, out_folder, report, show

if TYPE_CHECKING:
    from skincad.inputs.design import Design
    from skincad.material.acceptance import Acceptance


def coupon(
    process: Annotated[
        str,
        argument("PROCESS", "fdm, sla, cnc, edm, or one of yours.", autocompletion=completes("processes")),
    ],
    silicone: Annotated[str | None, option("--silicone NAME", "What bars and pad are cast in.")] = None,
    measured: Annotated[
        Path | None, option("--measured DIR", "Read the forms in this folder back; printer.toml goes there.")
    ] = None,
    printer: options.Printer = None,
    silicones: options.Silicones = None,
    folder: options.Out = None,
    as_json: options.Json = False,
) -> None:
    """Measure your own machine and silicone once.

    Writes parts to make, molds to cast in, a sheet that says how, and forms to fill in. With --measured the
    filled-in forms become a printer.toml: how much material grows, the narrowest gap, the crests' scatter.
    """
    if measured is None:
        from skincad.fabrication.coupon import SILICONE
        from skincad.fabrication.coupon import coupon as kit_of

        kit = kit_of(process, silicone or SILICONE, printer=printer, silicones=silicones)
        target = out_folder(folder, f"coupon-{process}", kit.presenter().COMMAND, kit.files())
        with stage_bar(2) as progress:
            written = skincad.write(kit, target, progress=progress)
        deliver(kit, written, options.Display(as_json=as_json))
        return
    for name, value in (("silicone", silicone), ("silicones", silicones)):
        if value is not None:
            raise InputError(name, "is not used with --measured", str(value), "leave it out")
    from skincad.fabrication.coupon import read_coupon

    reading = read_coupon(process, measured, printer=printer)
    deliver(reading, skincad.write(reading, folder or measured), options.Display(as_json=as_json))


def fit_material(
    file: Annotated[
        Path,
        options.argument(
            "CSV",
            "Columns approach_mm, force_N (a pad); strain, stress_MPa or extension_mm, force_N (a bar).",
        ),
    ],
    design: Annotated[
        str | None, option("--design DESIGN", "The design of the pad that a flat plate pressed.")
    ] = None,
    settings: options.Settings = [],  # noqa: B006
    silicones: options.Silicones = None,
    up_to: Annotated[
        float | None,
        option("--up-to X", "Largest strain used (default: 0.3) or, for a pad, largest force in N."),
    ] = None,
    gauge_length: Annotated[
        float | None, option("--gauge-length MM", "Gauge length of a bar, with extension_mm.")
    ] = None,
    area: Annotated[float | None, option("--area MM2", "Cross-section of a bar, with extension_mm.")] = None,
    copy: Annotated[
        Path | None, option("-o --out FILE", "Write a copy of the design with modulus and law.")
    ] = None,
    as_json: options.Json = False,
) -> None:
    """Find the silicone's modulus and its error from a test, and from a bar's its law.

    The test is force against approach of a cast pad, or stress against strain of a bar pulled or squeezed.
    Laws of rubber are fitted to the first half of a bar's strains, and judged by the second.
    """
    from skincad.base.outfolder import checked_fresh

    for name, value in (("settings", settings), ("silicones", silicones), ("copy", copy)):
        if value and design is None:
            raise InputError(name, "needs --design", remedy="name the design with --design")
    loaded = skincad.load(design, settings, silicones=silicones) if design else None
    if copy is not None:
        checked_fresh(copy, ".toml", "copy")
    with stage_bar(6) as progress:
        fit = skincad.fit_material(
            file, loaded, up_to=up_to, gauge_length=gauge_length, area=area, progress=progress
        )
    lines = [str(fit)]
    if copy is not None and design is not None:
        from skincad.outputs.tomls import write_with_modulus

        said = f"measured: {fit.kind} test {file.name}"
        write_with_modulus(copy, design, settings, fit.ranged, fit.law, said, silicones)
        lines.append(f"written to {copy}")
    show({**fit.as_json(), "file": str(copy) if copy else None}, as_json, lines)


def accept(
    sources: Annotated[
        list[str],
        options.argument(
            "PRESS DESIGN",
            "A CSV with the columns approach_mm, force_N, and a template's name or a TOML file.",
        ),
    ],
    recording: Annotated[
        Path | None,
        option("--recording CSV", "Refused: it names the command that judges films now.", hidden=True),
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
    """Say whether a finished part is good, by a press: in, out or can't tell.

    It compares force against approach under a flat plate with what the design's parts give, and names the
    cause that fits best.
    """
    from skincad.base.outfolder import checked_fresh

    if recording is not None:
        rule = "is no option any more: films are judged by taps on the ridges, without a scene"
        remedy = "`skincad listen --taps DESIGN --csv FILE`"
        raise InputError("recording", rule, str(recording), remedy)
    if len(sources) != 2:
        rule = "must be a press and a design"
        raise InputError("arguments", rule, " ".join(sources), "see `skincad accept --help`")
    given = {
        "force_error": force_error, "approach_error": approach_error, "ruled_out": ruled_out or None,
        "good_share": good_share,
    }  # fmt: skip
    said: dict[str, Any] = {key: value for key, value in given.items() if value is not None}
    source = sources[-1]
    typed = as_typed(source, settings, silicones=silicones)
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
