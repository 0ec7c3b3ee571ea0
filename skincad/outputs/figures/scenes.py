"""A scene's figures: history, signals (Figs 11 to 13), slip map, and what a recorder shows of it (Fig 15)."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from skincad.base.arrays import Array
from skincad.base.errors import InputError
from skincad.circuit.calibrate import PAPER_CUTOFF
from skincad.circuit.state import Recording, evenly_spaced, recorded
from skincad.outputs.figures.canvas import (
    BLACK,
    BLUE,
    GREY,
    PALE,
    STYLE,
    VERMILION,
    Axes,
    ListedColormap,
    MaxNLocator,
    Patch,
    Picture,
    legend,
    sheet,
)
from skincad.scenes.simulation import Simulation

OPEN, STICK, SLIP = "#ffffff", "#b9cbe0", VERMILION
NORMAL, TANGENTIAL = BLUE, VERMILION
WIDTH, PANEL = 9.0, 1.9  # inches
SIGNALS = (
    ("value", "differential stress\nS1 - S2, MPa"),
    ("rate", "stress-rate, MPa/s"),
    ("jerk", "stress-jerk, MPa/s$^2$"),
)
COLOURS = STYLE["axes.prop_cycle"].by_key()["color"]
DASHES = ("-", "-.", ":")  # of ridges that have the same colour
MAX_ERRORS = 3  # ridges that are named with their errors
NAMES_PER_ROW = 6  # names in one
SLIPS: dict[str, Any] = {"linewidth": 0.9, "linestyle": (0, (5, 3))}
PHASES = {"$P_A$": "#e3ecf7", "$P_B$": "#f9e4d8"}
MIN_SAMPLES = 50  # samples that are worth a picture
PAPERS_RIDGE = 3
ROOM_ABOVE, ROOM_BELOW = 0.14, 0.4  # of the curves' height, for what is written beside them
UNITS = {"V": 1.0, "mV": 1e3, "uV": 1e6}


def scene_figure(simulation: Simulation) -> Picture:
    """Return a figure: forces by step (Fig 11), differential stress, its rate and jerk (Figs 12, 13), slip by
    ridge.

    The signals are drawn as they come out of the low-pass, later by its delay. A dashed line of a ridge's
    colour stands where it begins to slip for good.
    """
    panels = 2 + len(SIGNALS) * bool(simulation.signals)
    with sheet((WIDTH, PANEL * panels + 0.8)) as figure:
        axes = np.atleast_1d(figure.subplots(panels, 1, sharex=True))
        axes[0].plot(simulation.march.column("normal"), color=NORMAL, label="normal force $F_n$")
        axes[0].plot(simulation.march.column("tangential"), color=TANGENTIAL, label="tangential force $F_t$")
        axes[0].set_ylabel("force, N")
        legend(axes[0])
        if simulation.signals:
            for place, (name, label) in zip(axes[1:-1], SIGNALS, strict=True):
                _signals(place, simulation, name)
                place.set_ylabel(label)
            _name_ridges(axes[1], simulation)
        _slip_map(axes[-1], simulation)
        axes[-1].set_xlabel("step")
        figure.align_ylabels(axes)
        width = simulation.scene.readout.bandwidth_Hz
        late = f"signals band-limited to {width:g} Hz, {1e3 * simulation.delay:.3g} ms late"
        figure.suptitle(f"{simulation.scene.name}" + (f": {late}" if simulation.signals else ""))
    return figure


def _signals(axes: Axes, simulation: Simulation, name: str) -> None:
    for row, (ridge, signal) in enumerate(simulation.signals.items()):
        colour, dashes = COLOURS[row % len(COLOURS)], DASHES[row // len(COLOURS) % len(DASHES)]
        values, error = getattr(signal, name), _errors(simulation).get(ridge)
        suffix = f" (± {error:.1g} MPa)" if error and len(simulation.signals) <= MAX_ERRORS else ""
        axes.plot(values, color=colour, linestyle=dashes, linewidth=1.0, label=f"ridge {ridge}{suffix}")
        if name == "value" and error:
            steps = np.arange(values.size)
            axes.fill_between(steps, values - error, values + error, color=colour, alpha=0.25, linewidth=0)
        step = simulation.slip_steps[ridge - 1]
        if step is not None:
            axes.axvline(step, color=colour, zorder=0.9, **SLIPS)


def _name_ridges(axes: Axes, simulation: Simulation) -> None:
    """Name the curves of all panels, and what a dashed line is if there is one."""
    if any(simulation.slip_steps[ridge - 1] is not None for ridge in simulation.signals):
        axes.plot([], [], color=GREY, label="slips from here on", **SLIPS)
    errors = _errors(simulation)
    if errors and len(simulation.signals) > MAX_ERRORS:
        axes.fill_between([], [], [], color=PALE, label=f"at most ± {max(errors.values()):.1g} MPa")
    legend(axes, NAMES_PER_ROW)


def _errors(simulation: Simulation) -> dict[int, float]:
    """The whole error of each monitored ridge's stress, MPa, where it is known."""
    totals = {ridge: error.total for ridge, error in simulation.stress_errors.items()}
    return {ridge: total for ridge, total in totals.items() if total is not None}


def _slip_map(axes: Axes, simulation: Simulation) -> None:
    """Ridge by step: clear, sticking (in part at least), slipping with all that touches."""
    count = simulation.slipping.shape[1]
    touches = np.array([reading.touches for reading in simulation.march.readings])
    touching = np.stack(
        [touches[:, simulation.march.ridge == r].any(axis=1) for r in range(1, count + 1)], axis=1
    )
    state = touching.astype(int) + (touching & simulation.slipping)
    edges = np.arange(state.shape[0] + 1) - 0.5, np.arange(count + 1) + 0.5
    axes.pcolormesh(*edges, state.T, cmap=ListedColormap([OPEN, STICK, SLIP]), vmin=0, vmax=2)
    axes.set_ylabel("ridge")
    axes.yaxis.set_major_locator(MaxNLocator(integer=True, nbins=9))
    axes.grid(visible=False)
    names = ((OPEN, "clear"), (STICK, "sticks"), (SLIP, "slips"))
    handles = [Patch(facecolor=colour, edgecolor=GREY, label=name) for colour, name in names]
    legend(axes, handles=handles)


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
    with sheet((9.0, 6.4)) as figure:
        rate = record.pair.rate
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
            for name, (start, end) in phases(simulation, record.ridge).items():
                axes.axvspan(start * rate, end * rate, color=PHASES[name], zorder=0)
                middle = (start + end) / 2 * rate
                axes.annotate(name, (middle, 0.9), xycoords=("data", "axes fraction"), ha="center")
            axes.set_ylabel(f"output, {unit}")
            legend(axes)
        _name_slips(pair, simulation, record)
        pair.set_xlabel(f"sample at {rate:g} Hz\n\n{caption(simulation, record)}")
        figure.suptitle(f"{simulation.scene.name}: {simulation.read['circuit']} as recorded at {rate:g} Hz")
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
