"""The report of a made design: one page that needs nothing else, to be forwarded and printed.

Every figure says where it comes from and which command gives it. It holds no date and no time of the run: the
same design gives the same bytes. Of a scene it shows signals, events, lead times, what was left out, and the
amplifier's gain; without a scene nothing of a run is imported.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, cast

from skincad.base.errors import InputError
from skincad.base.version import __version__
from skincad.fabrication.making import Build, passes
from skincad.fabrication.rules import counted
from skincad.inputs.catalog import display_name, load_design, read_table, retyped, template_names
from skincad.inputs.design import Design
from skincad.mechanics.check import spread_of
from skincad.mechanics.manufacture import quick_force, quick_model, sensitivities
from skincad.mechanics.models import winkler
from skincad.mechanics.models.table import MODELS, unsupported_reason, whole_price
from skincad.mechanics.plate_friction import PlateFriction
from skincad.mechanics.problem import Request
from skincad.mechanics.validity import limits
from skincad.mechanics.verdict import ContactCheck
from skincad.outputs import checks
from skincad.outputs.calculations import (
    casting_calculations,
    contact_calculations,
    scene_calculations,
    strip_calculations,
)
from skincad.outputs.figures import results as figures
from skincad.outputs.figures.canvas import Picture, png, svg
from skincad.outputs.pages import data_url, document, html, markdown_html
from skincad.scenes.scene import Scene, load_scene
from skincad.shape.skin import skin_of

if TYPE_CHECKING:
    from skincad.effects.piezo import Piezo
    from skincad.scenes.simulation import Simulation


FINDING = ("severity", "rule", "where", "measured", "limit", "unit", "remedy")
SPRINGS = ("ridges' common base", "slots and films", "free ends", "finite strain", "friction")
Facts = dict[str, Any]  # by their names in templates/pages/report.html


def report(build: Build, picture: Callable[[], bytes], sheet: str, drawing: str) -> str:
    """Return the report as HTML. `picture` gives the design's PNG, `sheet` is the casting sheet in Markdown,
    `drawing` the SVG with its dimensions."""
    design, check = build.design, build.check
    source = retyped(design, "designs", load_design, file="design.toml")
    scenes: list[ScenePart] = []
    if build.scenes:
        simulations = cast("tuple[Simulation, ...]", build.scenes)
        scenes = [scene_part(simulation, source) for simulation in simulations]
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
        "magnet_rows": [],
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
            "forces_picture": _svg_url(figures.ridge_force_figure(check)),
            "verdict_rows": _verdict_rows(check),
            "error_rows": _error_rows(check),
            **_model_facts(design, check),
            **_yield_facts(design, check),
            **_magnet_facts(check),
        }
    body = html("report.html", "page", build, **facts)
    return document(f"skincad report: {design.name}", body, "report.css")


def _svg_url(drawn: Picture) -> str:
    return data_url(svg(drawn), "image/svg+xml")


def _skin_of(scene: str) -> dict[str, Any]:
    """The design's data that a scene's template names."""
    return read_table(read_table(scene, "scenes")["skin"], "designs")


def suggested_scene(design: Design) -> str | None:
    """Return the name of a scene that this skin can take, with signals in volts if there is one."""
    skin = skin_of(design)
    names = [name for name in template_names("scenes") if skin.family in _skin_of(name)]
    for wanted in ("piezo", "film", "magnet", "friction"):
        for name in names:
            data = read_table(name, "scenes")
            if "grip" in data:  # the report shows histories
                continue
            effects, ridges = data.get("effects", {}), data.get("readout", {}).get("ridges", [])
            force = max(data["history"]["normal_force_N"])
            films_suffice = design.film is not None or not (ridges or "film" in effects)
            if (
                wanted in effects
                and films_suffice
                and (design.magnetometer is not None or "magnet" not in effects)
                and max(ridges, default=0) <= skin.count
                and force <= limits(design).bears(skin.count)
            ):
                return name
    return None


def _calculation_facts(build: Build) -> Facts:
    """The closed forms: the foundation's verdict, casting, films."""
    forces = build.check.ridge_force if build.check else ()
    share = max((force.value or 0.0 for force in forces), default=0.0)
    skin = skin_of(build.design)  # of bars the closed forms are, springs in a row
    contact = contact_calculations(build.design, share or None) if skin.family == "ridge" else []
    given = [quantity for step in contact for quantity in step.given]
    ridges = {q.symbol: q for q in given if isinstance(q.value, tuple) and len(q.value) == skin.count}
    return {
        "contact": contact,
        "ridge_quantities": list(ridges.values()),
        "casting": casting_calculations(build.job),
        "films": strip_calculations(build.design),
    }


def _verdict_rows(check: ContactCheck) -> list[tuple[str, str]]:
    """What the verdict rests on."""
    rows, margin = [("asked force", f"{check.force:g} N")], check.margin
    if check.ridges > 1:  # one feature, and a face, touch from the first contact on
        rows.insert(0, (f"all {check.family}s touch from", str(check.all_touch_force)))
        rows += [("margin to the worst case", f"{margin:.2f} N")] if margin is not None else []
    wide = [("width of the contact", str(check.contact_width))] if check.contact_width else []
    rows += [("approach", str(check.approach)), *wide, ("plate", check.plate)]
    if check.friction is not None:
        rows.append(("friction of the plate", f"{check.friction:g}"))
    rows.append(("model", f"{check.model}, {check.unknowns} unknowns"))
    return rows + [("note", warning) for warning in check.warnings]


def _error_rows(check: ContactCheck) -> list[tuple[str, str, str]]:
    """The error's parts, N."""
    whole = check.all_touch_force.error
    if not check.all_touch_force.value or not whole:
        return []
    names = {"": "mesh and method"}
    parts = [(names.get(x, f"leaving out {x}"), error) for x, error in checks.error_parts(check)]
    return [(name, f"{error:.2g}", f"{error / whole:.0%}") for name, error in [*parts, ("together", whole)]]


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
        words, price = ", ".join(left) or "none of these", whole_price(name)
        rows.append((name, words, unknowns, f"{price:.2g}", str(force))[: 5 if check.ridges > 1 else 4])
        if force.value and force.error:
            points.append((name, price, force.error / force.value))
    return {
        "model_rows": rows,
        "models_picture": _svg_url(figures.models_figure(points)) if len(points) > 1 else "",
    }


def _yield_facts(design: Design, check: ContactCheck) -> Facts:
    """The share of parts that pass and what it is made of, and how each crest counts."""
    part_yield = check.manufacture
    if part_yield is None or part_yield.passing.value is None:
        return {"part_yield": None}
    return {
        "part_yield": part_yield,
        "passing_share": checks.CHECK.said("passing_share", check),
        "spread": spread_of(design),
        "slopes": [f"{slope / 100:+.2g}" for slope in part_yield.crest_sensitivity],
    }


def _sensitivity_facts(design: Design, check: ContactCheck | None, source: str) -> Facts:
    """Which dimension or modulus moves the force by how much."""
    quick = quick_model(design)
    force = check.all_touch_force.value if check else None
    quickly = quick_force(design, quick) if skin_of(design).count > 1 else 0.0
    own = quickly and (force or quickly)  # None where the quick model refuses the design
    changes = sensitivities(design, own or 0.0)
    if not changes:
        return {"changes": changes, "moved_force": own}
    first, finer = changes[0], " --model linear" if quick == "winkler" else ""
    return {
        "changes": changes,
        "change_rows": [(change.key, change.now, change.unit, str(change.change)) for change in changes],
        "changes_picture": _svg_url(figures.sensitivity_figure(changes)),
        "quick_model": quick,
        "moved_force": own,
        "force": force,
        "sweep_command": f"skincad sweep {source} --vary "
        f"{first.key}={0.97 * first.now:.4g}:{1.03 * first.now:.4g}:3{finer}",
    }


def _magnet_facts(check: ContactCheck) -> Facts:
    """What magnetometers tell of the pins' forces."""
    lines = (line for part in ("magnets", "magnet_numbers") for line in checks.CHECK.rows(part, check))
    rows = [(line[2:17].strip(), line[17:]) for line in lines]
    return {"magnet_rows": rows, "magnet_picture": _svg_url(figures.magnet_figure(check)) if rows else ""}


@dataclass(frozen=True)
class ScenePart:
    """A scene's part of the report, its name for `skincad make --scene`, and its commands' TOML files."""

    title: str
    source: str
    html: str
    files: dict[str, str]

    @property
    def key(self) -> str:
        """What the contents lead to."""
        return self.title.lower().replace(" ", "-")


def scene_arguments(scene: Scene, source: str) -> tuple[str, dict[str, str]]:
    """Return the arguments of `skincad simulate` that run it again, and the files that it needs.

    `source` is the argument of `skincad make` for its skin.
    """
    file = f"scene-{scene.name}.toml"
    if scene.name not in template_names("scenes"):
        return file, {file: _own_toml(scene)}
    shipped = load_scene(scene.name)
    if shipped.model_dump(exclude={"skin"}) != scene.model_dump(exclude={"skin"}):
        return file, {file: _own_toml(scene)}
    if shipped.design == scene.design:
        return scene.name, {}
    skin = source if " " not in source else "design.toml"
    return f"{scene.name} --set skin={skin}", {}


def scene_part(simulation: Simulation, source: str) -> ScenePart:
    """Return a scene's part of the report."""
    from skincad.effects.piezo import Piezo
    from skincad.outputs.figures.scenes import scene_figure
    from skincad.outputs.simulations import SIMULATION

    words, needed = scene_arguments(simulation.scene, source)
    command, title = f"skincad simulate {words}", f"Scene {simulation.scene.name}"
    # slip, lead times and errors as `simulate` prints them, without the run's time
    printed = [*SIMULATION.lines(simulation)[1:], *SIMULATION.details(simulation)]
    results = [
        (line[2:17].strip(), line[17:]) for line in printed if not line.startswith(("  model", "  run"))
    ]
    amplifiers = []
    for piezo in (part for part in simulation.scene.parts.values() if isinstance(part, Piezo)):
        section, more = amplifier_part(simulation, piezo)
        amplifiers.append(section)
        needed |= more
    address, key = data_url(png(scene_figure(simulation)), "image/png"), title.lower().replace(" ", "-")
    left_out = [(e.effect, e.indicator, f"{e.change:.1%}", e.certainty) for e in simulation.left_out]
    facts = (title, key, command, simulation, address, results, left_out, amplifiers)
    return ScenePart(title, words.partition(" ")[0], html("scene.html", "scene", *facts), needed)


def amplifier_part(simulation: Simulation, piezo: Piezo) -> tuple[str, dict[str, str]]:
    """The gain of the scene's amplifier with this skin's strip, and its closed forms; no rig is in use."""
    from skincad.circuit.bode import gain, without_rig
    from skincad.circuit.model import fitted, load_circuit
    from skincad.outputs.simulations import GAIN

    circuit = without_rig(fitted(piezo.loaded, simulation.scene.design))
    try:
        circuit_gain = gain(circuit)
    except InputError as refusal:  # its sweep needs a key that the scene does not give
        return html("scene.html", "amplifier", circuit, refusal), {}
    file = f"circuit-{circuit.name}.toml"
    words = retyped(circuit, "circuits", load_circuit, file=file)
    address, sentence = (
        data_url(svg(figures.gain_figure(circuit_gain)), "image/svg+xml"),
        GAIN.lines(circuit_gain)[0],
    )
    steps = scene_calculations(simulation, circuit, circuit_gain)
    section = html(
        "scene.html", "amplifier", circuit, None, sentence, address, f"skincad circuit {words}", steps
    )
    return section, {file: circuit.to_toml()} if words == file else {}


def _own_toml(scene: Scene) -> str:
    """A scene's TOML that needs no other file: its skin, and its amplifier's circuit, are in it."""
    from skincad.effects.piezo import Piezo

    effects = {
        name: {**table, "circuit": part.loaded.model_dump(exclude_none=True)}
        if isinstance(part := scene.parts[name], Piezo)
        else table
        for name, table in scene.effects.items()
    }
    return scene.with_(skin=scene.design, effects=effects).to_toml()
