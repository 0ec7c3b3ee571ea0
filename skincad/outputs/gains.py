"""What a circuit's gain says and leaves: words, gain.csv, gain.png, netlist.cir, and what was calibrated."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

import tomlkit

from skincad.base.plain import csv_text
from skincad.base.result import Writer
from skincad.circuit.bode import CircuitGain
from skincad.circuit.film import PICO, capacitance
from skincad.circuit.netlist import netlist
from skincad.circuit.rig import told_rig
from skincad.circuit.slopes import Slopes
from skincad.outputs.delivery import picture, text

if TYPE_CHECKING:
    from skincad.pictures.canvas import Picture

COMMAND = "circuit"


def names(measured: bool) -> list[str]:
    """Return the names of what will be written, with measured data or without."""
    return ["gain.csv", "netlist.cir", "gain.png", *["calibrated.toml"] * measured]


def lines(found: CircuitGain) -> list[str]:
    """Return what `circuit` prints."""
    slopes, sweep = found.slopes, found.circuit.sweep
    fitted = f"fitted from {sweep.low:g} to {sweep.fit_high:g} Hz"
    by = ", as measured with its rig" if found.own else ""
    told = f"{found.name}: the gain rises by {_rise(slopes)}, {fitted}{by}."
    middle, gain = found.mid_band
    return [
        told,
        f"  mid-band       {gain:.2f} dB re 1 V/N at {middle:.4g} Hz: {10 ** (gain / 20):.3g} V/N",
        f"  fit            two lines are {slopes.rms:.2g} dB rms from the curve",
        *_rig_lines(found),
        *_measured_lines(found),
        *(f"  note           {warning}" for warning in found.warnings),
    ]


def _rise(slopes: Slopes) -> str:
    if slopes.cutoff.value is None:
        return f"{slopes.below} without a cut-off"
    return f"{slopes.below} up to the cut-off at {slopes.cutoff}, then by {slopes.above}"


def _rig_lines(found: CircuitGain) -> list[str]:
    if not found.own:
        return []
    return [
        f"  own signal     by the load on the film the gain rises by {_rise(found.own.slopes)}: "
        "that is the film's signal in use, in scenes and in netlist.cir",
        f"  rig            the measured load is not the film's, by {told_rig(found.circuit)}",
    ]


def _measured_lines(found: CircuitGain) -> list[str]:
    if not found.measured:
        return []
    fit, given = found.measured.calibration, found.measured.slopes
    held = ", ".join(fit.at_bounds) or "none"
    fixed = len(fit.combinations) - len(fit.open_combinations)
    return [
        f"  measured       {given.below}, cut-off {given.cutoff}, {given.above}",
        f"  calibrated     {fit.rms:.2g} dB rms from it; {fit.agreeing} of {fit.starts} starts agree",
        f"  determined     {fixed} of {len(fit.combinations)} combinations of constants; at bounds: {held}",
    ]


def manifest(found: CircuitGain) -> dict[str, Any]:
    """Return what the manifest says of the result: its name alone."""
    return {"name": found.name}


def figures(found: CircuitGain) -> dict[str, Callable[[], Picture]]:
    """Return the gain against frequency (Fig 7)."""
    from skincad.pictures.circuit_figures import gain_figure

    return {"gain.png": partial(gain_figure, found)}


def files(found: CircuitGain) -> dict[str, Writer]:
    """Return the writer of each file."""
    sweep = found.circuit.sweep
    written = {
        "gain.csv": text(lambda: gain_csv(found)),
        "netlist.cir": text(lambda: netlist(found.network, found.name, sweep.low, sweep.high)),
        **{name: picture(draw) for name, draw in figures(found).items()},
    }
    return {**written, "calibrated.toml": text(lambda: calibrated_toml(found))} if found.measured else written


def gain_csv(found: CircuitGain) -> str:
    """Return the gain as CSV: dB re 1 V/N, and the level of a measured curve by `sweep.offset`; with a rig
    also the film's own."""
    columns = {
        "gain_dB": found.gain,
        "gain_less_offset_dB": found.gain - found.circuit.sweep.offset,
        **({"own_gain_dB": found.own.gain} if found.own else {}),
    }
    rows = zip(found.frequency, *columns.values(), strict=True)
    lines = [[f"{f:.8g}", *(f"{value:.6f}" for value in row)] for f, *row in rows]
    return csv_text([["frequency_Hz", *columns], *lines])


def calibrated_toml(found: CircuitGain) -> str:
    """Return the circuit with the calibrated constants, to be used in its place.

    Film and lead share the calibrated capacitance: what the film's size does not give is the lead's, and a
    film that has more than the whole gets a smaller electrode.
    """
    if found.measured is None:
        raise ValueError("nothing was calibrated")
    c, circuit, fit = found.constants, found.circuit, found.measured.calibration
    film = circuit.film
    own = capacitance(film.area, film.thickness, film.permittivity)
    area = film.area * min(1.0, c.capacitance / own)
    data = circuit.model_dump(exclude_none=True)
    data["film"] = {**data["film"], "area": area, "d33": c.d33 / PICO}
    data["cable"] = {"capacitance": max(0.0, c.capacitance - own)}
    data["motional"] = {key: getattr(c, f"motional_{key}") for key in data["motional"]}
    data["amplifier"] = {key: getattr(c, key, value) for key, value in data["amplifier"].items()}
    head = f"# {found.name}, calibrated to a measured curve: {fit.rms:.2g} dB rms\n"
    return head + tomlkit.dumps(data)
