"""The report's scenes: signals, events, lead times, what was left out, and the amplifier's gain."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape

from skincad.base.errors import InputError
from skincad.circuit.bode import gain, without_rig
from skincad.circuit.model import load_circuit
from skincad.effects.piezo import Piezo, fitted
from skincad.inputs.catalog import retyped, template_names
from skincad.outputs import gains, simulations
from skincad.outputs.calculations_of_scenes import scene_calculations
from skincad.pictures.canvas import png, svg
from skincad.pictures.circuit_figures import gain_figure
from skincad.pictures.markup import calculation, figure, heading, paragraph, table
from skincad.pictures.page import data_url
from skincad.pictures.scene_figures import scene_figure
from skincad.scenes.scene import Scene, load_scene
from skincad.scenes.simulation import Simulation


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
    words, needed = scene_arguments(simulation.scene, source)
    command, title = f"skincad simulate {words}", f"Scene {simulation.scene.name}"
    stopped = "" if simulation.march.stopped is None else f" It stopped: {simulation.march.stopped}."
    caption = f"Signals of {simulation.scene.name} with this skin.{stopped}"
    body = [
        heading(title, title.lower().replace(" ", "-"), new_page=True),
        paragraph(f"Effects: {', '.join(simulation.scene.effects) or 'none'}."),
        figure(data_url(png(scene_figure(simulation)), "image/png"), caption, command),
        _results(simulation),
        _left_out(simulation),
    ]
    for piezo in (part for part in simulation.scene.parts.values() if isinstance(part, Piezo)):
        section, more = _amplifier(simulation, piezo)
        body.append(section)
        needed |= more
    return ScenePart(title, words.partition(" ")[0], "".join(body), needed)


def _results(simulation: Simulation) -> str:
    """Slip, lead times and errors as `simulate` prints them, without the run's time."""
    lines = [line for line in simulations.lines(simulation)[1:] if not line.startswith("  model")]
    rows = [(line[2:17].strip(), line[17:]) for line in lines]
    return table(("result", "value"), rows)


def _left_out(simulation: Simulation) -> str:
    rows = [
        (effect.effect, effect.indicator, f"{effect.change:.1%}", effect.certainty)
        for effect in simulation.left_out
    ]
    if not rows:
        return paragraph("No effect is left out.")
    head = ("left out", "what points to it", "may change signals by", "how sure")
    return table(head, rows)


def _amplifier(simulation: Simulation, piezo: Piezo) -> tuple[str, dict[str, str]]:
    """The gain of the scene's amplifier with this skin's strip, and its closed forms; no rig is in use."""
    circuit = without_rig(fitted(piezo.loaded, simulation.scene.design))
    head = f"<h3>Amplifier {escape(circuit.name)}, with this skin's strip</h3>\n"
    try:
        circuit_gain = gain(circuit)
    except InputError as refusal:  # its sweep needs a key that the scene does not give
        return head + paragraph(f"Its gain cannot be computed: {refusal}."), {}
    file = f"circuit-{circuit.name}.toml"
    words = retyped(circuit, "circuits", load_circuit, file=file)
    command = f"skincad circuit {words}"
    parts = [
        head,
        paragraph(gains.lines(circuit_gain)[0]),
        figure(
            data_url(svg(gain_figure(circuit_gain)), "image/svg+xml"), "Gain of film and amplifier.", command
        ),
        *(calculation(step) for step in scene_calculations(simulation, circuit, circuit_gain)),
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
