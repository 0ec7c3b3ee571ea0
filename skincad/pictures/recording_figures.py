"""What an experiment's recorder shows of a scene: the films' outputs at its sampling, laid out as Fig 15."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from skincad.base.arrays import Array
from skincad.base.errors import InputError
from skincad.circuit.calibrate import PAPER_CUTOFF
from skincad.circuit.state import Recording, evenly_spaced, recorded
from skincad.pictures.canvas import BLACK, BLUE, GREY, VERMILION, Axes, Picture, legend, sheet
from skincad.scenes.simulation import Simulation

PHASES = {"$P_A$": "#e3ecf7", "$P_B$": "#f9e4d8"}
MIN_SAMPLES = 50  # samples that are worth a picture
PAPERS_RIDGE = 3
ROOM_ABOVE, ROOM_BELOW = 0.14, 0.4  # of the curves' height, for what is written beside them
UNITS = {"V": 1.0, "mV": 1e3, "uV": 1e6}


@dataclass(frozen=True)
class RidgeRecording:
    """Both strips' outputs and their difference at the recorder's rate, V."""

    ridge: int
    s1: Recording
    s2: Recording
    pair: Recording


def recording(simulation: Simulation) -> RidgeRecording | None:
    """Return what is recorded of ridge 3, or of the last monitored one.

    None without a sampling, where the run's steps are coarser or in no ratio of small numbers to it, and
    for fewer than 50 samples.
    """
    outputs, wanted = simulation.read.get("output_V"), simulation.read.get("sampling_Hz")
    time = simulation.march.time
    if not outputs or wanted is None or time.size < 2 or wanted * float(time[-1]) < MIN_SAMPLES:
        return None
    ridge = PAPERS_RIDGE if str(PAPERS_RIDGE) in outputs else int(list(outputs)[-1])
    even = np.arange(time.size)
    if not evenly_spaced(time):
        steps = simulation.scene.history.even
        even = steps[steps < time.size]
    if even.size < 2:
        return None
    rate = 1 / float(time[even[1]] - time[even[0]])
    try:
        parts = [recorded(np.array(outputs[str(ridge)][k])[even], rate, wanted) for k in ("S1", "S2", "pair")]
    except InputError:  # the rates of recorder and run have no ratio of small numbers: no picture
        return None
    return RidgeRecording(ridge, *parts)


def recording_figure(simulation: Simulation, record: RidgeRecording) -> Picture:
    """Return a figure: S1 and S2, their difference vd with the phases P_A and P_B, and what is not seen.

    P_A is from the start of the pull to the ridge's slip, P_B from there to gross slip.
    """
    with sheet((9.0, 6.4), 100) as figure:
        strips, pair = figure.subplots(2, 1, sharex=True)
        largest = max(float(np.abs(part.values).max()) for part in (record.s1, record.s2, record.pair))
        unit, factor = next(((u, f) for u, f in UNITS.items() if largest * f >= 1), ("uV", 1e6))
        for part, name, colour in ((record.s1, "S1", BLUE), (record.s2, "S2", VERMILION)):
            strips.plot(
                factor * part.values, color=colour, linewidth=1.0, label=f"ridge {record.ridge} {name}"
            )
        pair.plot(factor * record.pair.values, color=BLACK, linewidth=1.0, label="$v_d$ = S1 - S2")
        _make_room(strips, 0.0)
        _make_room(pair, ROOM_BELOW)
        for axes in (strips, pair):
            _draw_phases(axes, simulation, record)
            axes.set_ylabel(f"output, {unit}")
            legend(axes)
        _name_slips(pair, simulation, record)
        pair.set_xlabel(f"sample at {record.pair.rate:g} Hz\n\n{caption(simulation, record)}")
        figure.suptitle(
            f"{simulation.scene.name}: {simulation.read['circuit']} as recorded at {record.pair.rate:g} Hz"
        )
    return figure


def _make_room(axes: Axes, under: float) -> None:
    """Leave room for the phases' names over the curves, and `under` them, of their height."""
    low, high = axes.get_ylim()
    axes.set_ylim(low - under * (high - low), high + ROOM_ABOVE * (high - low))


def caption(simulation: Simulation, record: RidgeRecording) -> str:
    """Return what this recording cannot show."""
    rate, step = record.pair.rate, 1e3 / record.pair.rate
    seen_to = min(record.pair.passband, simulation.scene.readout.bandwidth_Hz)
    unseen = ": neither the cut-off at 1.2 kHz nor the stress-jerk above it is seen"
    ratio = simulation.read["signal_to_noise_dB"][str(record.ridge)]
    lines = [
        f"True up to {seen_to:.4g} Hz{unseen if seen_to < PAPER_CUTOFF else ''}.",
        f"Samples are {step:.3g} ms apart: no shorter lead time is claimed.",
    ]
    if ratio is not None:
        lines.append(
            f"Drawn without noise; film and amplifier leave a signal-to-noise ratio of {ratio:.3g} dB."
        )
    if rate and record.pair.warnings:
        lines += list(record.pair.warnings)
    return "\n".join(lines)


def phases(simulation: Simulation, ridge: int) -> dict[str, tuple[float, float]]:
    """Return the phases' spans in s: none for a ridge that does not slip for good."""
    slip = simulation.slip_steps[ridge - 1]
    if slip is None:
        return {}
    time = simulation.march.time
    pull: Array = np.abs(simulation.march.column("tangential"))
    start = int(np.argmax(pull > 1e-3 * pull.max()))
    end = simulation.gross_slip_step if simulation.gross_slip_step is not None else time.size - 1
    marks = [float(time[i]) for i in (start, slip, end)]
    return dict(zip(PHASES, pairwise(marks), strict=True))


def _draw_phases(axes: Axes, simulation: Simulation, record: RidgeRecording) -> None:
    for name, (start, end) in phases(simulation, record.ridge).items():
        rate = record.pair.rate
        axes.axvspan(start * rate, end * rate, color=PHASES[name], zorder=0)
        axes.annotate(name, ((start + end) / 2 * rate, 0.9), xycoords=("data", "axes fraction"), ha="center")


def _name_slips(axes: Axes, simulation: Simulation, record: RidgeRecording) -> None:
    """The slips of the ridge and of its neighbours, and gross slip."""
    time, rate = simulation.march.time, record.pair.rate
    marks = {f"ridge {r}": simulation.slip_steps[r - 1] for r in (record.ridge - 1, record.ridge) if r >= 1}
    for name, step in {**marks, "all": simulation.gross_slip_step}.items():
        if step is not None:
            axes.axvline(time[step] * rate, color=GREY, linewidth=0.8, linestyle="--")
            where = (time[step] * rate, 0.02)
            axes.annotate(
                f" {name} slips", where, xycoords=("data", "axes fraction"), fontsize=7, rotation=90
            )
