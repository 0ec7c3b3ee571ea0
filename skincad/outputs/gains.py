"""Output of a circuit's gain: words, gain.csv, gain.png, netlist.cir, and calibrated.toml."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

import tomlkit

from skincad.base.reading import csv_text
from skincad.base.result import Writer
from skincad.circuit.bode import CircuitGain, told_rig
from skincad.circuit.network import PICO, capacitance, netlist
from skincad.outputs.delivery import Presentation, text

if TYPE_CHECKING:
    from skincad.outputs.figures.canvas import Picture

COMMAND = "circuit"


def names(measured: bool) -> list[str]:
    """Return the names of what will be written, with measured data or without."""
    return ["gain.csv", "netlist.cir", "gain.png", *["calibrated.toml"] * measured]


def figures(circuit_gain: CircuitGain) -> dict[str, Callable[[], Picture]]:
    """Return the gain against frequency (Fig 7)."""
    from skincad.outputs.figures.results import gain_figure

    return {"gain.png": partial(gain_figure, circuit_gain)}


def files(circuit_gain: CircuitGain) -> dict[str, Writer]:
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
    if circuit_gain.measured is None:
        raise ValueError("nothing was calibrated")
    c, circuit, fit = circuit_gain.constants, circuit_gain.circuit, circuit_gain.measured.calibration
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


GAIN = Presentation(
    COMMAND=COMMAND,
    words="circuit.txt",
    facts={"told_rig": told_rig},
    writers=files,
    figures=figures,
    manifest=lambda circuit_gain: {"name": circuit_gain.name},
)
