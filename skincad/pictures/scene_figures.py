"""A scene's picture: the history, the signals of monitored ridges as in Figs 11 to 13, and the slip map."""

from __future__ import annotations

from typing import Any

import numpy as np

from skincad.pictures.canvas import (
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
WIDTH, PANEL, DPI = 9.0, 1.9, 100
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


def scene_figure(simulation: Simulation) -> Picture:
    """Return a figure: forces by step (Fig 11), differential stress, its rate and jerk (Figs 12, 13), slip by
    ridge.

    The signals are drawn as they come out of the low-pass, later by its delay. A dashed line of a ridge's
    colour stands where it begins to slip for good.
    """
    panels = 2 + len(SIGNALS) * bool(simulation.signals)
    with sheet((WIDTH, PANEL * panels + 0.8), DPI) as figure:
        axes = np.atleast_1d(figure.subplots(panels, 1, sharex=True))
        _forces(axes[0], simulation)
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


def _forces(axes: Axes, simulation: Simulation) -> None:
    axes.plot(simulation.march.column("normal"), color=NORMAL, label="normal force $F_n$")
    axes.plot(simulation.march.column("tangential"), color=TANGENTIAL, label="tangential force $F_t$")
    axes.set_ylabel("force, N")
    legend(axes)


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
    count = len(simulation.slip_steps)
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
