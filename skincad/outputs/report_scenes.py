"""The report's scenes: signals, events, lead times, what was left out, and the amplifier's gain."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape

from skincad.base.errors import InputError
from skincad.circuit.bode import gain
from skincad.circuit.model import load_circuit
from skincad.circuit.rig import without_rig
from skincad.effects.piezo import Piezo, fitted
from skincad.inputs.catalog import template_names
from skincad.inputs.retyped import retyped
from skincad.outputs import gains, simulations
from skincad.outputs.calculations_of_scenes import felt_calculations
from skincad.pictures.canvas import png, svg
from skincad.pictures.circuit_figures import gain_figure
from skincad.pictures.markup import calculation, figure, heading, paragraph, table
from skincad.pictures.page import inlined
from skincad.pictures.scene_figures import scene_figure
from skincad.scenes.scene import Scene, load_scene
from skincad.scenes.simulation import Simulation


@dataclass(frozen=True)
class ScenePart:
    """A scene's part of the report, what `skincad make --scene` takes for it, and the TOML files by name that
    its commands need."""

    title: str
    source: str
    html: str
    files: dict[str, str]

    @property
    def key(self) -> str:
        """What the contents lead to."""
        return self.title.lower().replace(" ", "-")


def scene_arguments(scene: Scene, source: str) -> tuple[str, dict[str, str]]:
    """Return what stands behind `skincad simulate` to run it again, and the files that it needs.

    `source` is what stands behind `skincad make` for its skin.
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


def scene_part(found: Simulation, source: str) -> ScenePart:
    """Return a scene's part of the report."""
    words, needed = scene_arguments(found.scene, source)
    command, title = f"skincad simulate {words}", f"Scene {found.scene.name}"
    stopped = "" if found.march.stopped is None else f" It stopped: {found.march.stopped}."
    caption = f"Signals of {found.scene.name} with this skin.{stopped}"
    body = [
        heading(title, title.lower().replace(" ", "-"), new_page=True),
        paragraph(f"Effects: {', '.join(found.scene.effects) or 'none'}."),
        figure(inlined(png(scene_figure(found)), "image/png"), caption, command),
        _told(found),
        _left_out(found),
    ]
    for piezo in (part for part in found.scene.parts.values() if isinstance(part, Piezo)):
        drawn, more = _amplifier(found, piezo)
        body.append(drawn)
        needed |= more
    return ScenePart(title, words.partition(" ")[0], "".join(body), needed)


def _told(found: Simulation) -> str:
    """What is told of slip, lead times and errors, as `simulate` prints it, without the run's time."""
    lines = [line for line in simulations.lines(found)[1:] if not line.startswith("  model")]
    rows = [(line[2:17].strip(), line[17:]) for line in lines]
    return table(("result", "value"), rows)


def _left_out(found: Simulation) -> str:
    rows = [(each.effect, each.indicator, f"{each.change:.1%}", each.certainty) for each in found.left_out]
    if not rows:
        return paragraph("No effect is left out.")
    head = ("left out", "what points to it", "may change signals by", "how sure")
    return table(head, rows)


def _amplifier(found: Simulation, piezo: Piezo) -> tuple[str, dict[str, str]]:
    """The gain of the scene's amplifier with this skin's strip, and its closed forms; no rig is in use."""
    circuit = without_rig(fitted(piezo.loaded, found.scene.design))
    head = f"<h3>Amplifier {escape(circuit.name)}, with this skin's strip</h3>\n"
    try:
        swept = gain(circuit)
    except InputError as refusal:  # what its sweep asks for, which the scene has not
        return head + paragraph(f"Its gain cannot be told: {refusal}."), {}
    file = f"circuit-{circuit.name}.toml"
    words = retyped(circuit, "circuits", load_circuit, file=file)
    command = f"skincad circuit {words}"
    parts = [
        head,
        paragraph(gains.lines(swept)[0]),
        figure(inlined(svg(gain_figure(swept)), "image/svg+xml"), "Gain of film and amplifier.", command),
        *(calculation(step) for step in felt_calculations(found, circuit, swept)),
    ]
    return "".join(parts), {file: circuit.to_toml()} if words == file else {}


def _own_toml(scene: Scene) -> str:
    """A scene's TOML that needs no other file: its skin, and its amplifier's circuit, are in it."""
    effects = {
        name: {**table, "circuit": part.loaded.model_dump(exclude_none=True)}
        if isinstance(part := scene.parts[name], Piezo)
        else table
        for name, table in scene.effects.items()
    }
    return scene.with_(skin=scene.design, effects=effects).to_toml()
