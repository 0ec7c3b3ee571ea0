"""Output of a simulated scene, and of an amplifier alone: words, signals and gain as CSV, and pictures."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import tomlkit

from skincad.base.arrays import Array
from skincad.base.errors import RefusedError
from skincad.base.reading import Cell, csv_text
from skincad.base.result import Writer
from skincad.circuit.bode import CircuitGain, told_rig
from skincad.circuit.network import PICO, capacitance, netlist
from skincad.outputs.delivery import Presentation, drawn, text
from skincad.scenes.march import GROSS_SLIP, frames
from skincad.scenes.plan import (
    DEFAULT_TOLERANCE,
    FREE_ENDS,
    IN_CHOSEN_STEPS,
    SMALL_STRAIN,
)
from skincad.scenes.runs import marches_masses
from skincad.scenes.scene import Scene
from skincad.scenes.simulation import Simulation
from skincad.shape.skin import skin_of

if TYPE_CHECKING:
    from skincad.outputs.figures.canvas import Picture
    from skincad.outputs.figures.stress import Moment
    from skincad.scenes.lift import Lift

COMMAND = "simulate"
TABLE, PICTURE, ANIMATION = "signals.csv", "signals.png", "section.gif"
LIFT_TABLE, LIFT_PICTURE = "lift.csv", "lift.png"
RECORDING = "recording.png"  # where an amplifier with a sampling rate is named
OWNERS = {"field_mT": "sensor", "pin_force_N": "pin"}  # whose readouts are by number, if no ridge's
FIELDS = "magnets.png"  # where magnetometers read pins
STRIPS, MANY_STRIPS = "strips.png", 4  # and of how many monitored ridges on it is drawn


def names(scene: Scene) -> list[str]:
    """Return the names of what will be written, if the scene runs to its end."""
    if scene.grip is not None:
        return [LIFT_TABLE, LIFT_PICTURE]
    sections = [_section_name(step) for step in scene.readout.steps]
    strips = [STRIPS] * (len(scene.readout.ridges) >= MANY_STRIPS)
    fields = [FIELDS] * ("magnet" in scene.effects)
    return [TABLE, PICTURE, *strips, *fields, *sections, *[ANIMATION] * bool(scene.readout.frames)]


def _slip_starts(simulation: Simulation) -> dict[int, int]:
    """From which step each ridge that slips for good does."""
    return {ridge: step for ridge, step in enumerate(simulation.slip_steps, 1) if step is not None}


def _share_slips(simulation: Simulation, share: float) -> int | None:
    """From which step on at least this share of the contact slips until the end, None where it does not."""
    less = np.flatnonzero(simulation.slip_share < share)
    step = int(less[-1]) + 1 if less.size else 0
    return step if step < simulation.slip_share.size else None


def _clear_ridges(simulation: Simulation) -> list[int]:
    """Ridges that don't touch the plate at the end."""
    touching = set(simulation.march.ridge[simulation.march.readings[-1].touches].tolist())
    return [ridge for ridge in range(1, len(simulation.slip_steps) + 1) if ridge not in touching]


def _alarms(simulation: Simulation) -> list[tuple[int | str, float | None, dict[str, Any] | None]]:
    """By ridge, of all together first: how many s before gross slip the detector warns, and the same with
    other noise."""
    leads: dict[int | str, float | None] = simulation.read.get("lead_time_s") or {}
    noises = {noise["ridge"]: noise for noise in simulation.read.get("lead_time_by_noise", ())}
    return [(ridge, leads[ridge], noises.get(ridge)) for ridge in sorted(leads, key=lambda r: r != "all")]


def figures(simulation: Simulation) -> dict[str, Callable[[], Picture]]:
    """Return the signals, the recorder's view of them, and the wanted sections that the run reached."""
    from skincad.outputs.figures.scenes import (
        magnet_figure,
        recording,
        recording_figure,
        scene_figure,
        strips_figure,
    )
    from skincad.outputs.figures.stress import section_figure

    drawings: dict[str, Callable[[], Picture]] = {PICTURE: partial(scene_figure, simulation)}
    if len(simulation.raw) >= MANY_STRIPS:
        drawings[STRIPS] = partial(strips_figure, simulation)
    if "field_mT" in simulation.read:
        drawings[FIELDS] = partial(magnet_figure, simulation)
    if record := recording(simulation):
        drawings[RECORDING] = partial(recording_figure, simulation, record)
    for step in _section_steps(simulation):
        drawings[_section_name(step)] = partial(section_figure, _moment(simulation, step))
    return drawings


def files(simulation: Simulation) -> dict[str, Writer]:
    """Return the writers of the table, the sections and the animation."""
    from skincad.outputs.figures.stress import section_animation, section_picture

    writers: dict[str, Writer] = {TABLE: partial(write_table, simulation)}
    for step in _section_steps(simulation):
        writers[_section_name(step)] = partial(section_picture, _moment(simulation, step))
    if moving := [step for step in frames(simulation.scene) if step in simulation.march.states]:
        writers[ANIMATION] = partial(section_animation, [_moment(simulation, step) for step in moving])
    return writers


def _section_steps(simulation: Simulation) -> list[int]:
    """The steps that are drawn."""
    return sorted({step for step in simulation.scene.readout.steps if step in simulation.march.states})


def _moment(simulation: Simulation, step: int) -> Moment:
    from skincad.effects.modal import ModalPad
    from skincad.effects.small_strain import CondensedPad

    march = simulation.march
    assert isinstance(march.pad, CondensedPad | ModalPad)  # the scene was checked for it
    reading = march.readings[step]
    forces = f"{reading.normal:.2f} N normal, {reading.tangential:.2f} N tangential"
    title = f"{simulation.scene.name}: step {step}, {1e3 * march.time[step]:.4g} ms, {forces}"
    return title, march.pad.shown(march.states[step])


def _section_name(step: int) -> str:
    return f"section-{step:04d}.png"


def write_table(simulation: Simulation, path: Path) -> None:
    """Write the signals as CSV, a row a step, with units in the header; `raw` is before the low-pass.

    Readouts by ridge and step have their own columns. Raises RefusedError for a number that is not
    finite.
    """
    ridges, more = list(simulation.signals), readout_columns(simulation)
    signals: dict[str, Callable[[int], Array]] = {
        "raw differential stress [MPa]": lambda r: simulation.raw[r],
        "differential stress [MPa]": lambda r: simulation.signals[r].value,
        "stress-rate [MPa/s]": lambda r: simulation.signals[r].rate,
        "stress-jerk [MPa/s2]": lambda r: simulation.signals[r].jerk,
    }
    columns = {f"ridge {r} {name}": of(r) for r in ridges for name, of in signals.items()} | more
    head = ["step [1]", "time [s]", "normal force [N]", "tangential force [N]"]
    head += ["approach [mm]", "travel [mm]"]
    rows: list[list[Cell]] = [[*head, *columns, "slipping ridges [1]"]]
    for i, (time, reading) in enumerate(zip(simulation.march.time, simulation.march.readings, strict=True)):
        plate = (time, reading.normal, reading.tangential, reading.approach, reading.travel)
        cells = [column[i] for column in columns.values()]
        slipping = " ".join(str(r + 1) for r in simulation.slipping[i].nonzero()[0])
        if not all(map(math.isfinite, (*plate, *cells))):
            raise RefusedError(f"step {i} has numbers that are not finite: nothing is written")
        rows.append([i, *(f"{float(v):.9g}" for v in (*plate, *cells)), slipping])
    path.write_text(csv_text(rows), encoding="utf-8", newline="")


def readout_columns(simulation: Simulation) -> dict[str, list[float]]:
    """Return the readouts `<name>_<unit>` by ridge and signal: a number a step, by column header."""
    columns = {}
    for key, owners in simulation.read.items():
        name, _, unit = key.replace("_", " ").rpartition(" ")
        for number, signals in owners.items() if isinstance(owners, dict) else ():
            for signal, values in signals.items() if isinstance(signals, dict) else ():
                columns[f"{OWNERS.get(key, 'ridge')} {number} {signal} {name} [{unit}]"] = values
    return columns


def gain_names(measured: bool) -> list[str]:
    """Return the names of what will be written, with measured data or without."""
    return ["gain.csv", "netlist.cir", "gain.png", *["calibrated.toml"] * measured]


def gain_files(circuit_gain: CircuitGain) -> dict[str, Writer]:
    """Return the writers of table, netlist and calibrated circuit."""
    sweep = circuit_gain.circuit.sweep
    writers = {
        "gain.csv": text(lambda: gain_csv(circuit_gain)),
        "netlist.cir": text(lambda: netlist(circuit_gain.network, circuit_gain.name, sweep.low, sweep.high)),
    }
    calibrated = {"calibrated.toml": text(lambda: calibrated_toml(circuit_gain))}
    return writers | (calibrated if circuit_gain.measured else {})


def gain_csv(circuit_gain: CircuitGain) -> str:
    """Return the gain as CSV: dB re 1 V/N, and the level of a measured curve by `sweep.offset`; with a rig
    also the film's own."""
    columns = {
        "gain_dB": circuit_gain.gain,
        "gain_less_offset_dB": circuit_gain.gain - circuit_gain.circuit.sweep.offset,
        **({"own_gain_dB": circuit_gain.own.gain} if circuit_gain.own else {}),
    }
    rows = zip(circuit_gain.frequency, *columns.values(), strict=True)
    lines = [[f"{f:.8g}", *(f"{value:.6f}" for value in row)] for f, *row in rows]
    return csv_text([["frequency_Hz", *columns], *lines])


def calibrated_toml(circuit_gain: CircuitGain) -> str:
    """Return the circuit with the calibrated constants, to be used in its place.

    Film and lead share the calibrated capacitance: what the film's size does not give is the lead's, and a
    film that has more than the whole gets a smaller electrode.
    """
    if circuit_gain.calibration is None:
        raise ValueError("nothing was calibrated")
    c, circuit, fit = circuit_gain.constants, circuit_gain.circuit, circuit_gain.calibration
    film = circuit.film
    film_capacitance = capacitance(film.area, film.thickness, film.permittivity)
    area = film.area * min(1.0, c.capacitance / film_capacitance)
    data = circuit.model_dump(exclude_none=True)
    data["film"] = {**data["film"], "area": area, "d33": c.d33 / PICO}
    data["cable"] = {"capacitance": max(0.0, c.capacitance - film_capacitance)}
    data["motional"] = {key: getattr(c, f"motional_{key}") for key in data["motional"]}
    data["amplifier"] = {key: getattr(c, key, value) for key, value in data["amplifier"].items()}
    head = f"# {circuit_gain.name}, calibrated to a measured curve: {fit.rms:.2g} dB rms\n"
    return head + tomlkit.dumps(data)


SIMULATION = Presentation(
    COMMAND=COMMAND,
    words="simulate.txt",
    facts={
        "slip_starts": _slip_starts,
        "clear_ridges": _clear_ridges,
        "share_slips": _share_slips,
        "alarms": _alarms,
        "skin_of": skin_of,
        "marches_masses": marches_masses,
        "DEFAULT_TOLERANCE": DEFAULT_TOLERANCE,
        "FREE_ENDS": FREE_ENDS,
        "GROSS_SLIP": GROSS_SLIP,
        "IN_CHOSEN_STEPS": IN_CHOSEN_STEPS,
        "SMALL_STRAIN": SMALL_STRAIN,
        "PICTURE": PICTURE,
    },
    writers=files,
    figures=figures,
)


def _lift_table(lift: Lift, path: Path) -> None:
    """Write a lift as CSV, a row a sample, by its keys."""
    columns = lift.columns()
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    path.write_text(csv_text([list(columns), *([f"{value:.8g}" for value in row] for row in rows)]))


LIFT = Presentation(
    COMMAND=COMMAND,
    words="lift.txt",
    facts={"PICTURE": LIFT_PICTURE},
    writers=lambda lift: {LIFT_TABLE: partial(_lift_table, lift)},
    figures=drawn(LIFT_PICTURE, "lifts:lift_figure"),
)
GAIN = Presentation(
    COMMAND="circuit",
    words="circuit.txt",
    facts={"told_rig": told_rig},
    writers=gain_files,
    figures=drawn("gain.png", "results:gain_figure"),
    manifest=lambda circuit_gain: {"name": circuit_gain.name},
)
