"""The report of a made design: one page that needs nothing else, to be forwarded and printed.

Every figure says where it comes from and which command gives it. It holds no date and no time of the run: the
same design gives the same bytes.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, cast

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
from skincad.outputs.figures.canvas import Picture, svg
from skincad.outputs.figures.results import models_figure, ridge_force_figure, sensitivity_figure
from skincad.outputs.pages import data_url, document, html, markdown_html
from skincad.scenes.scene import PIN_EFFECTS
from skincad.shape.skin import skin_of

if TYPE_CHECKING:
    from skincad.outputs.report_scenes import ScenePart
    from skincad.scenes.simulation import Simulation


FINDING = ("severity", "rule", "where", "measured", "limit", "unit", "remedy")
IN_A_ROW = 11  # crests, across a page
SPRINGS = ("ridges' common base", "slots and films", "free ends", "finite strain", "friction")
Facts = dict[str, Any]  # by their names in templates/pages/report.html


def report(build: Build, picture: Callable[[], bytes], sheet: str, drawing: str) -> str:
    """Return the report as HTML. `picture` gives the design's PNG, `sheet` is the casting sheet in Markdown,
    `drawing` the SVG with its dimensions."""
    design, check = build.design, build.check
    source = retyped(design, "designs", load_design, file="design.toml")
    scenes: list[ScenePart] = []
    if build.scenes:  # without any, nothing of a scene is imported
        from skincad.outputs.report_scenes import scene_part

        scenes = [
            scene_part(simulation, source) for simulation in cast("tuple[Simulation, ...]", build.scenes)
        ]
    make_command = f"skincad make {source}{'' if check else ' --no-check'}"
    make_command += "".join(f" --scene {scene.source}" for scene in scenes)
    files = {"design.toml": design.to_toml()}
    for scene in scenes:
        files |= scene.files
    undecided = check is None or check.verdict == "undecided"
    sound = all(finding.severity != "error" for finding in build.findings)
    passed = passes(check, build.findings, strict=False)
    facts: Facts = {
        "title": display_name(design),
        "version": __version__,
        "outcome": "open" if undecided and sound else "passed" if passed else "failed",
        "verdict": checks.verdict_of(build),
        "findings": counted(build.findings),
        "source": source,
        "make_command": make_command,
        "picture": data_url(picture(), "image/png"),
        "closed_form": not unsupported_reason("winkler", design, False),  # it knows ridges on a rectangle
        "finding_rows": [tuple(getattr(finding, key) for key in FINDING) for finding in build.findings],
        "scenes": scenes,
        "suggested_scene": suggested_scene(design),
        "sheet": markdown_html(sheet.partition("\n")[2]).replace("<h2>", "<h3>").replace("</h2>", "</h3>"),
        "drawing": drawing,
        "files": files,
        "addresses": {name: data_url(text.encode(), "text/plain") for name, text in files.items()},
        **_sensitivity_facts(design, check, source),
        **_calculation_facts(build),
    }
    if check:
        facts |= {
            "check_command": f"skincad check {source} --model {check.model}",
            "forces_picture": _svg_url(ridge_force_figure(check)),
            "verdict_rows": _verdict_rows(check),
            "error_rows": _error_rows(check),
            **_model_facts(design, check),
            **_yield_facts(design, check),
        }
    body = html("report.html", "page", build, **facts)
    return document(f"skincad report: {design.name}", body, "report.css")


def _svg_url(drawn: Picture) -> str:
    return data_url(svg(drawn), "image/svg+xml")


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


def _calculation_facts(build: Build) -> Facts:
    """The closed forms: the foundation's verdict, casting, films."""
    share = (
        max((force.value or 0.0 for force in build.check.ridge_force), default=0.0) if build.check else None
    )
    skin = skin_of(build.design)  # of bars the closed forms are, springs in a row
    contact = contact_calculations(build.design, share or None) if skin.symmetry == "extruded" else []
    given = [quantity for step in contact for quantity in step.given]
    ridges = {
        quantity.symbol: quantity
        for quantity in given
        if isinstance(quantity.value, tuple) and len(quantity.value) == skin.count
    }
    return {
        "contact": contact,
        "ridge_quantities": list(ridges.values()),
        "casting": casting_calculations(build.job),
        "films": strip_calculations(build.design),
    }


def _verdict_rows(check: ContactCheck) -> list[tuple[str, str]]:
    """What the verdict rests on."""
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
    return rows + [("note", warning) for warning in check.warnings]


def _error_rows(check: ContactCheck) -> list[tuple[str, str, str]]:
    """The error's parts, N."""
    whole = check.all_touch_force.error
    if not check.all_touch_force.value or not whole:
        return []
    parts = [
        (f"leaving out {name}" if name else "mesh and method", n) for name, n in checks.error_parts(check)
    ]
    rows = [(name, f"{error:.2g}", f"{error / whole:.0%}") for name, error in parts]
    return [*rows, ("together", f"{whole:.2g}", "100%")]


def _model_facts(design: Design, check: ContactCheck) -> Facts:
    """The models tried on the way, and their error against time."""
    plate = PlateFriction(design, check.force, ())
    models = [(run.model, run.all_touch_force, run.unknowns) for run in check.models_tried]
    models.append((check.model, check.all_touch_force, check.unknowns))
    if "winkler" not in {name for name, *_ in models} and not unsupported_reason("winkler", design, False):
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
    return {
        "model_rows": rows,
        "models_picture": _svg_url(models_figure(points)) if len(points) > 1 else "",
    }


def _yield_facts(design: Design, check: ContactCheck) -> Facts:
    """The share of parts that pass and what it is made of, and how each crest counts."""
    part_yield, spread = check.manufacture, spread_of(design)
    if part_yield is None or part_yield.passing.value is None:
        return {"yield_rows": []}
    low, now, high = spread.modulus
    rows = [
        ("parts that pass", checks.passing_share(check)),
        ("crests, one against another", f"normal, sigma {spread.crest_sigma:g} mm by {spread.process}"),
        ("modulus of a batch", f"uniform from {low:g} to {high:g} MPa; nominal {now:g} MPa"),
        ("most are lost by", part_yield.largest or "nothing: none of those sampled fails"),
        ("change of the force with the modulus", f"{part_yield.modulus_sensitivity:.3g} N per MPa"),
    ]
    slopes = [f"{slope / 100:+.2g}" for slope in part_yield.crest_sensitivity]
    crests = []
    for first in range(0, len(slopes), IN_A_ROW):
        shown = slopes[first : first + IN_A_ROW]
        head = (check.family, *range(first + 1, first + len(shown) + 1))
        crests.append((head, ("N for 0.01 mm lower", *shown)))
    return {"yield_rows": rows, "crest_rows": crests}


def _sensitivity_facts(design: Design, check: ContactCheck | None, source: str) -> Facts:
    """Which dimension or modulus moves the force by how much."""
    sweep = f"skincad sweep {source} --vary "
    if unsupported_reason("winkler", design, False):
        thickness = design.skin.thickness
        return {"sweep_command": f"{sweep}skin.thickness={thickness:g}:{1.1 * thickness:.4g}:3"}
    closed_form = winkler.all_touch_force(design)
    force = check.all_touch_force.value if check else None
    changes = sensitivities(design, force or closed_form)
    if not changes:
        return {"changes": changes}
    first = changes[0]
    return {
        "changes": changes,
        "change_rows": [(change.key, change.now, change.unit, str(change.change)) for change in changes],
        "changes_picture": _svg_url(sensitivity_figure(changes)),
        "closed_form_force": closed_form,
        "force": force,
        "sweep_command": f"{sweep}{first.key}={0.97 * first.now:.4g}:{1.03 * first.now:.4g}:3 --model linear",
    }
