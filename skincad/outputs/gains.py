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
from skincad.circuit.response import Slopes
from skincad.outputs.delivery import Presentation, picture, text

if TYPE_CHECKING:
    from skincad.outputs.figures.canvas import Picture

COMMAND = "circuit"


def names(measured: bool) -> list[str]:
    """Return the names of what will be written, with measured data or without."""
    return ["gain.csv", "netlist.cir", "gain.png", *["calibrated.toml"] * measured]


def lines(circuit_gain: CircuitGain) -> list[str]:
    """Return what `circuit` prints."""
    slopes, sweep = circuit_gain.slopes, circuit_gain.circuit.sweep
    fitted = f"fitted from {sweep.low:g} to {sweep.fit_high:g} Hz"
    by = ", as measured with its rig" if circuit_gain.own else ""
    headline = f"{circuit_gain.name}: the gain rises by {_rise(slopes)}, {fitted}{by}."
    middle, gain = circuit_gain.mid_band
    return [
        headline,
        f"  mid-band       {gain:.2f} dB re 1 V/N at {middle:.4g} Hz: {10 ** (gain / 20):.3g} V/N",
        f"  fit            two lines are {slopes.rms:.2g} dB rms from the curve",
        *_rig_lines(circuit_gain),
        *_measured_lines(circuit_gain),
        *(f"  note           {warning}" for warning in circuit_gain.warnings),
    ]


def _rise(slopes: Slopes) -> str:
    if slopes.cutoff.value is None:
        return f"{slopes.below} without a cut-off"
    return f"{slopes.below} up to the cut-off at {slopes.cutoff}, then by {slopes.above}"


def _rig_lines(circuit_gain: CircuitGain) -> list[str]:
    if not circuit_gain.own:
        return []
    return [
        f"  own signal     by the load on the film the gain rises by {_rise(circuit_gain.own.slopes)}: "
        "that is the film's signal in use, in scenes and in netlist.cir",
        f"  rig            the measured load is not the film's, by {told_rig(circuit_gain.circuit)}",
    ]


def _measured_lines(circuit_gain: CircuitGain) -> list[str]:
    if not circuit_gain.measured:
        return []
    fit, slopes = circuit_gain.measured.calibration, circuit_gain.measured.slopes
    bounds = ", ".join(fit.at_bounds) or "none"
    fixed = len(fit.combinations) - len(fit.open_combinations)
    return [
        f"  measured       {slopes.below}, cut-off {slopes.cutoff}, {slopes.above}",
        f"  calibrated     {fit.rms:.2g} dB rms from it; {fit.agreeing} of {fit.starts} starts agree",
        f"  determined     {fixed} of {len(fit.combinations)} combinations of constants; at bounds: {bounds}",
    ]


def figures(circuit_gain: CircuitGain) -> dict[str, Callable[[], Picture]]:
    """Return the gain against frequency (Fig 7)."""
    from skincad.outputs.figures.results import gain_figure

    return {"gain.png": partial(gain_figure, circuit_gain)}


def files(circuit_gain: CircuitGain) -> dict[str, Writer]:
    """Return the writer of each file."""
    sweep = circuit_gain.circuit.sweep
    writers = {
        "gain.csv": text(lambda: gain_csv(circuit_gain)),
        "netlist.cir": text(lambda: netlist(circuit_gain.network, circuit_gain.name, sweep.low, sweep.high)),
        **{name: picture(draw) for name, draw in figures(circuit_gain).items()},
    }
    return (
        {**writers, "calibrated.toml": text(lambda: calibrated_toml(circuit_gain))}
        if circuit_gain.measured
        else writers
    )


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
    lines=lines,
    files=files,
    figures=figures,
    manifest=lambda circuit_gain: {"name": circuit_gain.name},
)
