"""The report of a made design: one page that needs nothing else, to be forwarded and printed.

Every figure says where it comes from and which command gives it. It holds no date and no time of the run: the
same design gives the same bytes.
"""

from __future__ import annotations

from collections.abc import Callable
from html import escape
from typing import TYPE_CHECKING, cast

from skincad.base.version import __version__
from skincad.fabrication.making import Build, passes
from skincad.fabrication.rules import counted
from skincad.inputs.catalog import display_name, load_design, read_table, retyped, template_names
from skincad.inputs.design import Design
from skincad.mechanics.check import spread_of
from skincad.mechanics.manufacture import sensitivities
from skincad.mechanics.models import winkler
from skincad.mechanics.models.table import MODELS, unsupported_reason, whole_price
from skincad.mechanics.plate_friction import PlateFriction
from skincad.mechanics.problem import Request
from skincad.mechanics.validity import limits
from skincad.mechanics.verdict import ContactCheck
from skincad.outputs import checks
from skincad.outputs.calculations import casting_calculations, contact_calculations, strip_calculations
from skincad.outputs.checks import passing_share
from skincad.outputs.figures.canvas import svg
from skincad.outputs.figures.results import models_figure, ridge_force_figure, sensitivity_figure
from skincad.outputs.pages import (
    calculation,
    command_line,
    data_url,
    document,
    figure,
    heading,
    markdown_html,
    paragraph,
    ridge_table,
    table,
)
from skincad.scenes.scene import PIN_EFFECTS
from skincad.shape.skin import skin_of

if TYPE_CHECKING:
    from skincad.outputs.report_scenes import ScenePart
    from skincad.scenes.simulation import Simulation


SEVERITY = {"error": "fails the design", "warning": "fails it under --strict", "note": "for information"}
SVG = "image/svg+xml"
IN_A_ROW = 11  # crests, across a page
SPRINGS = ("ridges' common base", "slots and films", "free ends", "finite strain", "friction")


def report(build: Build, picture: Callable[[], bytes], sheet: str, drawing: str) -> str:
    """Return the report as HTML. `picture` gives the design's PNG, `sheet` is the casting sheet in Markdown,
    `drawing` the SVG with its dimensions."""
    design = build.design
    source = retyped(design, "designs", load_design, file="design.toml")
    check_command = None if build.check is None else f"skincad check {source} --model {build.check.model}"
    scenes: list[ScenePart] = []
    if build.scenes:  # without any, nothing of a scene is imported
        from skincad.outputs.report_scenes import scene_part

        scenes = [
            scene_part(simulation, source) for simulation in cast("tuple[Simulation, ...]", build.scenes)
        ]
    make_command = f"skincad make {source}{'' if build.check else ' --no-check'}"
    make_command += "".join(f" --scene {scene.source}" for scene in scenes)
    pictures = figure(
        data_url(picture(), "image/png"), "The skin, its sections, and the mold taken apart.", make_command
    )
    parts = [
        _head(build, make_command),
        heading("Pictures", "pictures") + pictures,
        forces_figure(build.check, check_command) if build.check and check_command else "",
        *_verdict_sections(build, build.check, check_command or "", source),
        _findings(build, make_command),
        _calculations(build, make_command),
        *([part.html for part in scenes] or [_no_scene(design, source)]),
        heading("Casting sheet", "sheet", new_page=True),
        markdown_html(sheet.partition("\n")[2]).replace("<h2>", "<h3>").replace("</h2>", "</h3>"),
        f"<h3>Drawing</h3>\n{drawing}",
        command_line(make_command),
    ]
    files = {"design.toml": design.to_toml()}
    for scene in scenes:
        files |= scene.files
    parts.append(_files(files))
    body = f"{_contents(scenes)}<main>\n{''.join(parts)}</main>\n"
    return document(f"skincad report: {design.name}", body, "report.css")


def suggested_scene(design: Design) -> str | None:
    """Return the name of a scene that this skin can take, with signals in volts if there is one."""
    skin = skin_of(design)
    names = template_names("scenes") if skin.symmetry in ("extruded", "revolved") else []
    for wanted in ("piezo", "film", "friction"):
        for name in names:
            data = read_table(name, "scenes")
            effects, ridges = data.get("effects", {}), data.get("readout", {}).get("ridges", [])
            force = max(data["history"]["normal_force_N"])
            films_suffice = design.film is not None or not (ridges or "film" in effects)
            if (
                wanted in effects
                and films_suffice
                and (skin.symmetry == "revolved") == (set(effects) <= set(PIN_EFFECTS))
                and max(ridges, default=0) <= skin.count
                and force <= skin.count * limits(design).largest
            ):
                return name
    return None


def _no_scene(design: Design, source: str) -> str:
    """Which command would add a scene."""
    head, name = heading("Scenes", "scenes"), suggested_scene(design)
    if name is None:
        return head + paragraph("No scene was asked for; skincad make --scene FILE adds one of yours.")
    return head + command_line(
        f"skincad make {source} --scene {name}", "No scene was asked for. One is added by"
    )


def _head(build: Build, make_command: str) -> str:
    """Name, passed or failed, and verdict."""
    passed = passes(build.check, build.findings, strict=False)
    verdict = checks.verdict_of(build)
    undecided = build.check is None or build.check.verdict == "undecided"
    sound = all(finding.severity != "error" for finding in build.findings)
    outcome = "open" if undecided and sound else "passed" if passed else "failed"
    by = f"Revision {build.design.revision}, made with skincad {__version__} by"
    return (
        f"<h1>{escape(display_name(build.design))}: skin and mold</h1>\n"
        f'<p class="{outcome}">{escape(verdict)} '
        f"Mold: {escape(counted(build.findings))}.</p>\n"
        f"{paragraph(_basis(build.check)) if build.check else ''}"
        f"{command_line(make_command, by)}"
    )


def _contents(scenes: list[ScenePart]) -> str:
    """The page's contents, twice: as a column beside a wide page, and folded above a narrow one."""
    links = {
        "pictures": "Pictures",
        "verdict": "Verdict",
        "models": "Models",
        "yield": "Yield",
        "sensitivities": "What moves the force",
        "findings": "Findings",
        "calculation": "Calculation",
        **({scene.key: scene.title for scene in scenes} or {"scenes": "Scenes"}),
        "sheet": "Casting sheet",
        "files": "To make it again",
    }
    rows = "".join(f'<li><a href="#{escape(key)}">{escape(text)}</a></li>\n' for key, text in links.items())
    return (
        f'<nav class="column" aria-label="Contents"><b>Contents</b>\n<ul>\n{rows}</ul></nav>\n'
        f'<nav class="folded" aria-label="Contents"><details><summary>Contents</summary>\n<ul>\n{rows}</ul>'
        "</details></nav>\n"
    )


def _basis(check: ContactCheck) -> str:
    margin = "" if check.margin is None else f", {check.margin:.2f} N of margin to the worst case"
    left = ", ".join(part.effect for part in check.left_out)
    return f"By the {check.model} model{margin}; what it leaves out is in the error: {left or 'nothing'}."


def _verdict_sections(build: Build, check: ContactCheck | None, command: str, source: str) -> list[str]:
    """The parts that need a verdict; without one, a note that they do."""
    if check is None:
        titles = (("verdict", "What the verdict rests on"), ("models", "Models asked"), ("yield", "Yield"))
        again = command_line(f"skincad check {source}", "It is given by")
        sections = [
            heading(title, key) + paragraph(f"{checks.verdict_of(build)} This part needs a verdict.") + again
            for key, title in titles
        ]
        return [*sections, sensitivity_section(build, None, source)]
    return [
        verdict_section(check, command),
        models_section(build, check, command),
        yield_section(build, check, command),
        sensitivity_section(build, check, source),
    ]


def _findings(build: Build, make_command: str) -> str:
    head = heading("Findings", "findings")
    if not build.findings:
        return (
            head
            + paragraph("None: all rules of processes, demolding and filling are kept.")
            + command_line(make_command)
        )
    rows = [
        (
            finding.severity,
            finding.rule,
            finding.where,
            finding.measured,
            finding.limit,
            finding.unit,
            finding.remedy,
        )
        for finding in build.findings
    ]
    heads = ("severity", "rule", "where", "measured", "limit", "unit", "remedy")
    severities = dict.fromkeys(finding.severity for finding in build.findings)
    legend = "; ".join(f"{word}: {SEVERITY[word]}" for word in severities)
    return head + table(heads, rows, "small") + paragraph(legend + ".", "small") + command_line(make_command)


def _calculations(build: Build, make_command: str) -> str:
    """The closed forms: the foundation's verdict, casting, films."""
    check = build.check
    share = max((force.value or 0.0 for force in check.ridge_force), default=0.0) if check else None
    bars = skin_of(build.design).symmetry == "extruded"  # whose springs in a row the closed forms are
    contact = contact_calculations(build.design, share or None) if bars else []
    ridges = {
        quantity.symbol: quantity
        for step in contact
        for quantity in step.given
        if isinstance(quantity.value, tuple) and len(quantity.value) == skin_of(build.design).count
    }
    words = (
        "Closed forms with their numbers, to be checked by hand. They rank designs; the verdict above is a "
        "finer model's, which also knows how the ridges push each other down through their common base."
    )
    parts = [
        heading("Calculation", "calculation"),
        paragraph(words) if contact else "",
        *(calculation(step) for step in contact),
        ridge_table(list(ridges.values())) if ridges else "",
        "<h3>Casting</h3>\n",
        *(calculation(step) for step in casting_calculations(build.job)),
    ]
    if films := strip_calculations(build.design):
        parts += ["<h3>Films</h3>\n", *(calculation(step) for step in films)]
    return "".join(parts) + command_line(make_command)


def _files(files: dict[str, str]) -> str:
    """The TOML files that the commands need, to read and to save."""
    parts = [heading("To make it again", "files")]
    for name, text in files.items():
        address = data_url(text.encode(), "text/plain")
        parts.append(
            f'<p>Save as <a download="{escape(name)}" href="{address}">{escape(name)}</a>:</p>\n'
            f'<pre class="file">{escape(text)}</pre>\n'
        )
    return "".join(parts)


def verdict_section(check: ContactCheck, command: str) -> str:
    """Return what the verdict rests on."""
    rows = [
        (f"all {check.family}s touch from", str(check.all_touch_force)),
        ("asked force", f"{check.force:g} N"),
    ]
    if check.margin is not None:
        rows.append(("margin to the worst case", f"{check.margin:.2f} N"))
    rows += [("approach", str(check.approach)), ("plate", check.plate)]
    if check.friction is not None:
        rows.append(("friction of the plate", f"{check.friction:g}"))
    rows.append(("model", f"{check.model}, {check.unknowns} unknowns"))
    rows += [("note", warning) for warning in check.warnings]
    verdict_table = table(("verdict", "value"), rows)
    return (
        heading("What the verdict rests on", "verdict")
        + verdict_table
        + _budget(check)
        + command_line(command)
    )


def _budget(check: ContactCheck) -> str:
    """The error's parts, N."""
    force = check.all_touch_force
    if not force.value or not force.error:
        return ""
    parts = [("mesh and method", force.error - check.model_error)]
    parts += [(f"leaving out {part.effect}", part.threshold * force.value) for part in check.left_out]
    rows = [(name, f"{error:.2g}", f"{error / force.error:.0%}") for name, error in parts]
    total = ("together", f"{force.error:.2g}", "100%")
    return paragraph("What its error is made of:") + table(("from", "N", "part"), [*rows, total])


def forces_figure(check: ContactCheck, command: str) -> str:
    """Return the force on each ridge."""
    address = data_url(svg(ridge_force_figure(check)), SVG)
    return figure(
        address, f"Force on each {check.family} at {check.force:g} N, by the {check.model} model.", command
    )


def _closed_form(design: Design) -> bool:
    """Whether the closed form judges this design: it knows ridges on a rectangular skin."""
    return not unsupported_reason("winkler", design, False)


def models_section(build: Build, check: ContactCheck, command: str) -> str:
    """Return the models tried on the way, and their error against time."""
    design = build.design
    plate = PlateFriction(design, check.force, ())
    models = [(run.model, run.all_touch_force, run.unknowns) for run in check.models_tried]
    models.append((check.model, check.all_touch_force, check.unknowns))
    if "winkler" not in {name for name, *_ in models} and _closed_form(design):
        springs = winkler.answer(design, Request(check.force))
        models.insert(0, ("winkler", springs.all_touch_force, springs.unknowns))

    rows, points = [], []
    for name, force, unknowns in models:
        left = SPRINGS if name == "winkler" else (*MODELS[name].leaves_out, *plate.left_out(name))
        rows.append(
            (name, ", ".join(left) or "none of these", unknowns, f"{whole_price(name):.2g}", str(force))
        )
        if force.value and force.error:
            points.append((name, whole_price(name), force.error / force.value))
    head = ("model", "leaves out", "unknowns", "usual time, linear = 1", "all ridges touch from")
    law = (
        "Times are those usual for a skin with film, in the linear model's; they are not measured in this "
        "run, so that the same design gives the same report. "
        f"{'winkler is the closed form below. ' if _closed_form(design) else ''}"
        "The error includes what a model leaves out."
    )
    drawn = ""
    if len(points) > 1:
        address = data_url(svg(models_figure(points)), SVG)
        drawn = figure(
            address,
            "Error of the models asked against their usual time; diamond: the one that gave the verdict.",
            command,
        )
    return heading("Models asked", "models") + table(head, rows) + paragraph(law, "small") + drawn


def yield_section(build: Build, check: ContactCheck, command: str) -> str:
    """Return the share of parts that pass and what it is made of, and how each crest counts."""
    part_yield, spread = check.manufacture, spread_of(build.design)
    head = heading("Yield", "yield")
    if part_yield is None or part_yield.passing.value is None:
        why = "There is none: it needs a verdict by a meshed model on more than one feature."
        return head + paragraph(why) + command_line(command)
    low, now, high = spread.modulus
    rows = [
        ("parts that pass", passing_share(check)),
        ("crests, one against another", f"normal, sigma {spread.crest_sigma:g} mm by {spread.process}"),
        ("modulus of a batch", f"uniform from {low:g} to {high:g} MPa; nominal {now:g} MPa"),
        ("most are lost by", part_yield.largest or "nothing: none of those sampled fails"),
        ("change of the force with the modulus", f"{part_yield.modulus_sensitivity:.3g} N per MPa"),
    ]
    crests = "".join(
        table(
            (check.family, *(str(first + i) for i in range(1, len(slopes) + 1))),
            [("N for 0.01 mm lower", *(f"{slope / 100:+.2g}" for slope in slopes))],
            "small",
        )
        for first in range(0, len(part_yield.crest_sensitivity), IN_A_ROW)
        if (slopes := part_yield.crest_sensitivity[first : first + IN_A_ROW])
    )
    explanation = paragraph("How much the all-touch force changes when one crest comes out 0.01 mm lower:")
    return head + table(("yield", "value"), rows) + explanation + crests + command_line(command)


def sensitivity_section(build: Build, check: ContactCheck | None, source: str) -> str:
    """Return which dimension or modulus moves the force by how much."""
    head = heading("What moves the force", "sensitivities")
    if not _closed_form(build.design):
        words = "Not told here: the closed form that tells it knows ridges alone. To see it for one key:"
        sweep = f"skincad sweep {source} --vary skin.thickness={build.design.skin.thickness:g}:"
        return head + paragraph(words) + command_line(f"{sweep}{1.1 * build.design.skin.thickness:.4g}:3")
    closed_form = winkler.all_touch_force(build.design)
    force = check.all_touch_force.value if check else None
    changes = sensitivities(build.design, force or closed_form)
    if not changes:
        return head + paragraph("Nothing does: all of it touches from the first contact on.")
    rows = [(change.key, change.now, change.unit, str(change.change)) for change in changes]
    by = "the verdict's force" if force else "the closed form's force, as there is no verdict"
    words = (
        f"Exponents of the closed form times {by}, {force or closed_form:.3g} N. Their errors come "
        "from plane finite elements on 19 designs; on 10 others 70 of 78 changes lay within them. Where the "
        "error exceeds the change, its sign is uncertain."
    )
    first = changes[0]
    sweep_command = (
        f"skincad sweep {source} --vary {first.key}={0.97 * first.now:.4g}:{1.03 * first.now:.4g}:3"
    )
    sweep_command += " --model linear"
    address = data_url(svg(sensitivity_figure(changes)), SVG)
    caption = (
        "Change of the all-touch force for 1 % more of each key, by the closed form. To confirm the first:"
    )
    return (
        head
        + table(("key", "now", "unit", "for 1 % more of it"), rows)
        + paragraph(words, "small")
        + figure(address, caption, sweep_command)
    )
