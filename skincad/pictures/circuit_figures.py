"""The picture of the frequency test: gain, fitted lines, and what the paper says of its own curve (Fig 7)."""

from __future__ import annotations

import numpy as np

from skincad.circuit.bode import CircuitGain
from skincad.circuit.calibrate import PAPER_ABOVE, PAPER_BELOW, PAPER_CUTOFF, PAPER_HIGH, PAPER_LOW
from skincad.circuit.model import constants, load_circuit
from skincad.pictures.canvas import BLACK, BLUE, GREEN, GREY, VERMILION, Axes, Picture, legend, sheet

PAPERS = ("yamada-2002", "yamada-2002-motional")  # the readings of the paper's circuit
PAPER_DROP = 9000.0  # Hz; paper, section 3.2
SIZE, DPI = (9.0, 5.6), 100


def gain_figure(circuit_gain: CircuitGain) -> Picture:
    """Return a figure of the gain in dB re 1 V/N, its fitted lines, the paper's statements and measured data;
    of a circuit with a rig also the film's own gain.

    The paper's lines take the curve's mean level up to 8 kHz: the paper's own is not known.
    """
    with sheet(SIZE, DPI, 255) as figure:
        axes = figure.add_subplot()
        if circuit_gain.measured:
            measurement = circuit_gain.measured
            shifted = measurement.gain - measurement.calibration.offset
            label = f"measured, {-measurement.calibration.offset:+.4g} dB"
            axes.semilogx(measurement.frequency, shifted, ".", color=BLACK, markersize=4, label=label)
        name = "network and rig, by the measured load" if circuit_gain.own else "network"
        axes.semilogx(circuit_gain.frequency, circuit_gain.gain, color=BLUE, linewidth=1.6, label=name)
        if circuit_gain.own:
            label = "network alone: the film's signal in use"
            axes.semilogx(
                circuit_gain.frequency, circuit_gain.own.gain, color=GREEN, linewidth=1.2, label=label
            )
        _draw_fit(axes, circuit_gain)
        if constants(circuit_gain.circuit) in [constants(load_circuit(name)) for name in PAPERS]:
            _draw_paper(axes, circuit_gain)
        axes.set_xlabel("frequency, Hz")
        axes.set_ylabel("gain, dB re 1 V/N")
        axes.grid(which="both")
        legend(axes, 2)
        figure.suptitle(f"{circuit_gain.name}: gain of film and amplifier")
    return figure


def _draw_fit(axes: Axes, circuit_gain: CircuitGain) -> None:
    slopes = circuit_gain.slopes
    if slopes.cutoff.value is None:
        label = f"fitted: {slopes.below}, no cut-off"
    else:
        label = f"fitted: {slopes.below}, {slopes.above}, cut-off {slopes.cutoff}"
    ends = np.array([circuit_gain.frequency[0], _corner(circuit_gain), circuit_gain.circuit.sweep.fit_high])
    values = _lines(
        ends, _corner(circuit_gain), slopes.level, slopes.below.value or 0.0, slopes.above.value or 0.0
    )
    axes.semilogx(ends, values, color=VERMILION, linewidth=1.0, linestyle="--", label=label)


def _draw_paper(axes: Axes, circuit_gain: CircuitGain) -> None:
    """The paper's statements: two slopes that meet at 1.2 kHz, and the drop at 9 kHz."""
    ends = np.array([PAPER_LOW, PAPER_CUTOFF, PAPER_HIGH])
    inside = circuit_gain.frequency <= PAPER_HIGH
    shape = _lines(circuit_gain.frequency[inside], PAPER_CUTOFF, 0.0, PAPER_BELOW, PAPER_ABOVE)
    level = float(np.mean(circuit_gain.gain[inside] - shape))
    values = _lines(ends, PAPER_CUTOFF, level, PAPER_BELOW, PAPER_ABOVE)
    label = "paper: 20 dB/dec up to 1.2 kHz, 60 above; any level"
    axes.semilogx(ends, values, color=GREY, linewidth=2.4, alpha=0.45, label=label)
    axes.axvline(PAPER_CUTOFF, color=GREY, linewidth=0.8, linestyle=":")
    axes.axvline(PAPER_DROP, color=GREY, linewidth=0.8, linestyle="-.", label="paper: drop at 9 kHz")


def _corner(circuit_gain: CircuitGain) -> float:
    """The fitted cut-off, or the fitted range's middle where there is none, Hz."""
    sweep = circuit_gain.circuit.sweep
    return circuit_gain.slopes.cutoff.value or float(np.sqrt(sweep.low * sweep.fit_high))


def _lines(frequency: np.ndarray, corner: float, level: float, below: float, above: float) -> np.ndarray:
    decades = np.log10(frequency / corner)
    return np.asarray(level + below * np.minimum(decades, 0.0) + above * np.maximum(decades, 0.0))
