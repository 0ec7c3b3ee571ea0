"""The report of a made design: one page that needs nothing else, to be forwarded and printed.

Every figure says where it comes from and which command gives it. It holds no date and no time of the run:
the same design gives the same bytes.
"""

from __future__ import annotations

from collections.abc import Callable
from html import escape
from typing import TYPE_CHECKING, cast

from skincad.base.version import __version__
from skincad.fabrication.finding import counted
from skincad.fabrication.making import Job, passes
from skincad.inputs.catalog import display_name, load_design, read_table, template_names
from skincad.inputs.design import Design
from skincad.inputs.retyped import retyped
from skincad.mechanics.validity import limits
from skincad.mechanics.verdict import ContactCheck
from skincad.outputs import checks
from skincad.outputs.calculations import contact_calculations
from skincad.outputs.calculations_of_casting import casting_calculations, strip_calculations
from skincad.outputs.report_verdict import (
    forces_figure,
    models_section,
    sensitivity_section,
    verdict_section,
    yield_section,
)
from skincad.pictures.markup import (
    calculation,
    command_line,
    figure,
    heading,
    paragraph,
    ridge_table,
    table,
)
from skincad.pictures.page import data_url, document, markdown_html
from skincad.shape.skin import skin_of

if TYPE_CHECKING:
    from skincad.outputs.report_scenes import ScenePart
    from skincad.scenes.simulation import Simulation

SEVERITY = {"error": "fails the design", "warning": "fails it under --strict", "note": "for information"}


def report(job: Job, picture: Callable[[], bytes], sheet: str, drawing: str) -> str:
    """Return the report as HTML. `picture` gives the design's PNG, `sheet` is the casting sheet in Markdown,
    `drawing` the SVG with its dimensions."""
    design = job.design
    source = retyped(design, "designs", load_design, file="design.toml")
    check_command = None if job.check is None else f"skincad check {source} --tier {job.check.tier}"
    scenes = _scenes(job, source)
    make_command = f"skincad make {source}{'' if job.check else ' --no-check'}"
    make_command += "".join(f" --scene {scene.source}" for scene in scenes)
    pictures = figure(
        data_url(picture(), "image/png"), "The skin, its section, and the mold taken apart.", make_command
    )
    parts = [
        _head(job, make_command, scenes),
        heading("Pictures", "pictures") + pictures,
        forces_figure(job.check, check_command) if job.check and check_command else "",
        *_verdict_sections(job, job.check, check_command or "", source),
        _findings(job, make_command),
        _calculations(job, make_command),
        *([part.html for part in scenes] or [_no_scene(design, source)]),
        heading("Casting sheet", "sheet", new_page=True),
        _lowered_headings(markdown_html(sheet.partition("\n")[2])),
        f"<h3>Drawing</h3>\n{drawing}",
        command_line(make_command),
    ]
    files = {"design.toml": design.to_toml()}
    for scene in scenes:
        files |= scene.files
    parts.append(_files(files))
    return document(f"skincad report: {design.name}", "".join(parts), "report.css")


def _scenes(job: Job, source: str) -> list[ScenePart]:
    """The scenes' parts; without any, nothing of a scene is imported."""
    if not job.scenes:
        return []
    from skincad.outputs.report_scenes import scene_part

    return [scene_part(simulation, source) for simulation in cast("tuple[Simulation, ...]", job.scenes)]


def suggested_scene(design: Design) -> str | None:
    """Return the name of a scene that this skin can take, with signals in volts if there is one."""
    skin = skin_of(design)
    names = template_names("scenes")
    for wanted in ("piezo", "film", "friction"):
        for name in names:
            data = read_table(name, "scenes")
            effects, ridges = data.get("effects", {}), data.get("readout", {}).get("ridges", [])
            force = max(data["history"]["normal_force_N"])
            films_suffice = design.film is not None or not (ridges or "film" in effects)
            if (
                wanted in effects
                and films_suffice
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


def _head(job: Job, make_command: str, scenes: list[ScenePart]) -> str:
    """Name, passed or failed, verdict, and the page's contents."""
    passed = passes(job.check, job.findings, strict=False)
    verdict = checks.verdict(job.check) if job.check else checks.UNCHECKED
    undecided = job.check is None or job.check.verdict == "undecided"
    sound = all(finding.severity != "error" for finding in job.findings)
    outcome = "open" if undecided and sound else "passed" if passed else "failed"
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
    by = f"Revision {job.design.revision}, made with skincad {__version__} by"
    contents = "".join(f'<a href="#{escape(key)}">{escape(text)}</a> ' for key, text in links.items())
    return (
        f"<h1>{escape(display_name(job.design))}: skin and mold</h1>\n"
        f'<p class="{outcome}">{escape(verdict)} '
        f"Mold: {escape(counted(job.findings))}.</p>\n"
        f"{paragraph(_basis(job.check)) if job.check else ''}"
        f"{command_line(make_command, by)}<nav>{contents}</nav>\n"
    )


def _basis(check: ContactCheck) -> str:
    margin = "" if check.margin is None else f", {check.margin:.2f} N of margin to the worst case"
    left = ", ".join(part.effect for part in check.left_out)
    return f"By the {check.tier} model{margin}; what it leaves out is in the error: {left or 'nothing'}."


def _verdict_sections(job: Job, check: ContactCheck | None, command: str, source: str) -> list[str]:
    """The parts that need a verdict; without one, a note that they do."""
    if check is None:
        titles = (("verdict", "What the verdict rests on"), ("models", "Models asked"), ("yield", "Yield"))
        again = command_line(f"skincad check {source}", "It is given by")
        sections = [
            heading(title, key) + paragraph(f"{checks.UNCHECKED} This part needs a verdict.") + again
            for key, title in titles
        ]
        return [*sections, sensitivity_section(job, None, source)]
    return [
        verdict_section(check, command),
        models_section(job, check, command),
        yield_section(job, check, command),
        sensitivity_section(job, check, source),
    ]


def _findings(job: Job, make_command: str) -> str:
    head = heading("Findings", "findings")
    if not job.findings:
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
        for finding in job.findings
    ]
    heads = ("severity", "rule", "where", "measured", "limit", "unit", "remedy")
    severities = dict.fromkeys(finding.severity for finding in job.findings)
    legend = "; ".join(f"{word}: {SEVERITY[word]}" for word in severities)
    return head + table(heads, rows, "small") + paragraph(legend + ".", "small") + command_line(make_command)


def _calculations(job: Job, make_command: str) -> str:
    """The closed forms: the foundation's verdict, casting, films."""
    check = job.check
    share = max((force.value or 0.0 for force in check.ridge_force), default=0.0) if check else None
    contact = contact_calculations(job.design, share or None)
    ridges = {
        quantity.symbol: quantity
        for step in contact
        for quantity in step.given
        if isinstance(quantity.value, tuple) and len(quantity.value) == skin_of(job.design).count
    }
    words = (
        "Closed forms with their numbers, to be checked by hand. They rank designs; the verdict above is a "
        "finer model's, which also knows how the ridges push each other down through their common base."
    )
    parts = [
        heading("Calculation", "calculation"),
        paragraph(words),
        *(calculation(step) for step in contact),
        ridge_table(list(ridges.values())) if ridges else "",
        "<h3>Casting</h3>\n",
        *(calculation(step) for step in casting_calculations(job.design, job.closed)),
    ]
    if films := strip_calculations(job.design):
        parts += ["<h3>Films</h3>\n", *(calculation(step) for step in films)]
    return "".join(parts) + command_line(make_command)


def _lowered_headings(html: str) -> str:
    """Return the sheet with its headings one level lower."""
    return html.replace("<h2>", "<h3>").replace("</h2>", "</h3>")


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
