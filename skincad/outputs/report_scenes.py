"""The report's scenes: signals, events, lead times, what was left out, and the amplifier's gain.

The closed forms of their films and amplifiers, too: charge, capacitance, voltage.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from skincad.base.errors import InputError
from skincad.circuit.bode import CircuitGain, gain, without_rig
from skincad.circuit.model import Circuit, constants, load_circuit
from skincad.circuit.network import PICO, Constants, capacitance, electrode
from skincad.effects.piezo import Piezo, fitted, strip_charges
from skincad.inputs.catalog import retyped, template_names
from skincad.outputs.calculations import PIEZO, Calculation, Quantity
from skincad.outputs.figures.canvas import png, svg
from skincad.outputs.figures.results import gain_figure
from skincad.outputs.figures.scenes import scene_figure
from skincad.outputs.gains import GAIN
from skincad.outputs.pages import data_url, html
from skincad.outputs.simulations import SIMULATION
from skincad.scenes.scene import Scene, load_scene
from skincad.scenes.simulation import Simulation

PLATES = "parallel plates, stray field left out"
EPSILON_0 = 8.8541878128e-3  # pF/mm; source: CODATA 2018, as scipy.constants.epsilon_0
KILO, GIGA = 1e3, 1e9


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
    circuit = without_rig(fitted(piezo.loaded, simulation.scene.design))
    try:
        circuit_gain = gain(circuit)
    except InputError as refusal:  # its sweep needs a key that the scene does not give
        return html("scene.html", "amplifier", circuit, refusal), {}
    file = f"circuit-{circuit.name}.toml"
    words = retyped(circuit, "circuits", load_circuit, file=file)
    address, sentence = data_url(svg(gain_figure(circuit_gain)), "image/svg+xml"), GAIN.lines(circuit_gain)[0]
    steps = scene_calculations(simulation, circuit, circuit_gain)
    section = html(
        "scene.html", "amplifier", circuit, None, sentence, address, f"skincad circuit {words}", steps
    )
    return section, {file: circuit.to_toml()} if words == file else {}


def _own_toml(scene: Scene) -> str:
    """A scene's TOML that needs no other file: its skin, and its amplifier's circuit, are in it."""
    effects = {
        name: {**table, "circuit": part.loaded.model_dump(exclude_none=True)}
        if isinstance(part := scene.parts[name], Piezo)
        else table
        for name, table in scene.effects.items()
    }
    return scene.with_(skin=scene.design, effects=effects).to_toml()


def scene_calculations(
    simulation: Simulation, amplifier: Circuit, circuit_gain: CircuitGain
) -> list[Calculation]:
    """Return a strip's charge where the scene's differential stress is largest, its capacitance with the
    lead, and what the ideal amplifier makes of 1 N on the film, by the network's own beside it.

    `amplifier` is the circuit fitted to the skin, `circuit_gain` its gain.
    """
    charge = _largest_charge(simulation, amplifier)
    return [*([charge] if charge else []), _capacitance(amplifier), _ideal(amplifier, circuit_gain)]


def _largest_charge(simulation: Simulation, amplifier: Circuit) -> Calculation | None:
    """The charge of the monitored strip at the step of the largest differential stress of all."""
    design, film = simulation.scene.design, simulation.scene.design.film
    if not simulation.raw or film is None:
        return None
    ridge = max(simulation.raw, key=lambda r: float(np.abs(simulation.raw[r]).max()))
    step = int(np.argmax(np.abs(simulation.raw[ridge])))
    stress = np.array([simulation.march.readings[step].films])
    strip = 2 * (ridge - 1)
    charges = strip_charges(amplifier, design, stress)[0]
    through, transverse, along = (float(value) for value in stress[0, strip])
    drawn, other = (along, transverse) if amplifier.film.draw_axis == "length" else (transverse, along)
    return Calculation(
        f"Charge of S1 in ridge {ridge} at step {step}, where the differential stress is largest",
        Quantity("Q", "charge", float(charges[strip]) / PICO, "pC"),
        "A * (d_31 * T_1 + d_32 * T_2 + d_33 * T_3)",
        (
            Quantity("A", "electrode in the skin", electrode(design), "mm²"),
            Quantity("d_31", "film.d31", film.d31, "pC/N"),
            Quantity("T_1", "stress along the draw axis", drawn, "MPa"),
            Quantity("d_32", "film.d32", film.d32, "pC/N"),
            Quantity("T_2", "stress across it, in the film", other, "MPa"),
            Quantity("d_33", "film.d33", film.d33, "pC/N"),
            Quantity("T_3", "stress through the film", through, "MPa"),
        ),
        PIEZO,
        "Stresses are those of the scene's run, before the low-pass.",
    )


def _capacitance(amplifier: Circuit) -> Calculation:
    film = amplifier.film
    static_capacitance = capacitance(film.area, film.thickness, film.permittivity)
    return Calculation(
        "Capacitance of a strip",
        Quantity("C", "static capacitance", static_capacitance / PICO, "pF"),
        "epsilon_0 * epsilon_r * A_w / t",
        (
            Quantity("epsilon_0", "permittivity of vacuum", EPSILON_0, "pF/mm"),
            Quantity("epsilon_r", "film.permittivity of the circuit", film.permittivity, "1"),
            Quantity("A_w", "electrode in the skin; the leads do not overlap", film.area, "mm²"),
            Quantity("t", "film.thickness", film.thickness, "mm"),
        ),
        PLATES,
    )


def _ideal(amplifier: Circuit, circuit_gain: CircuitGain) -> Calculation:
    """What an ideal amplifier makes of 1 N on the film at the mid-band, against the network's own gain."""
    c = constants(amplifier)
    frequency, decibels = circuit_gain.mid_band
    formula, quantities, value, source = _ideal_gain(c, amplifier.amplifier.topology, frequency)
    network = 10 ** (decibels / 20)
    note = f"The whole network, with its finite gain and its motional branch, gives {network:.4g} V/N there."
    return Calculation(
        f"Output of the ideal amplifier by 1 N on the film, at {frequency:.4g} Hz, the mid-band",
        Quantity("G", "gain", value, "V/N"),
        formula,
        quantities,
        source,
        note,
    )


def _ideal_gain(
    c: Constants, topology: str, frequency: float
) -> tuple[str, tuple[Quantity, ...], float, str]:
    """Formula, its quantities, result in V/N, and source."""
    charge = Quantity("d", "charge by 1 N, the circuit's d33", abs(c.d33) / PICO, "pC/N")
    if topology == "follower":
        whole = c.capacitance + c.input_capacitance
        quantities = (
            charge,
            Quantity("C_p", "film, lead and cable", c.capacitance / PICO, "pF"),
            Quantity("C_i", "amplifier.input_capacitance", c.input_capacitance / PICO, "pF"),
        )
        source = "Horowitz and Hill, The Art of Electronics, 3rd ed., sec. 4.2.3"
        return "d / (C_p + C_i)", quantities, abs(c.d33) / whole, source
    common = (
        charge,
        Quantity("f", "frequency", frequency / KILO, "kHz"),
        Quantity("R_f", "amplifier.feedback_resistance", c.feedback_resistance / GIGA, "GΩ"),
    )
    turn = 2 * math.pi * frequency * c.feedback_resistance
    if not c.feedback_capacitance:
        return (
            "2 * pi * f * R_f * d",
            common,
            turn * abs(c.d33),
            "ideal operational amplifier in the network of Yamada et al. 2002, Figs 5 and 6",
        )
    feedback = Quantity("C_f", "amplifier.feedback_capacitance", c.feedback_capacitance / PICO, "pF")
    formula = "2 * pi * f * R_f * d / sqrt(1 + (2 * pi * f * R_f * C_f)**2)"
    value = turn * abs(c.d33) / math.sqrt(1 + (turn * c.feedback_capacitance) ** 2)
    return (
        formula,
        (*common, feedback),
        value,
        "ideal operational amplifier, its feedback a resistor beside a capacitor",
    )
