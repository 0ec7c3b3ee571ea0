"""A scene's picture: the history, the signals of a told ridge laid out as Figs 11 to 13, and the slip map."""

from __future__ import annotations

import numpy as np

from skincad.circuit.low_pass import Limited
from skincad.pictures.canvas import Axes, ListedColormap, Patch, Picture, sheet
from skincad.scenes.simulation import Simulation

OPEN, STICK, SLIP = "#ffffff", "#b9cbe0", "#c1531f"
NORMAL, TANGENTIAL = "#1f5fa8", "#c1531f"
WIDTH, PANEL, DPI = 9.0, 1.9, 100


def scene_figure(found: Simulation) -> Picture:
    """Return a figure: forces by step (Fig 11), stress-rate and stress-jerk (Figs 12, 13), slip by ridge.

    The signals are drawn as they come out of the low-pass, later by its delay.
    """
    panels = 2 + 2 * bool(found.signals)
    with sheet((WIDTH, PANEL * panels + 0.8), DPI) as figure:
        axes = np.atleast_1d(figure.subplots(panels, 1, sharex=True))
        _forces(axes[0], found)
        if found.signals:
            _signals(axes[1], found, "stress-rate, MPa/s", lambda s: s.rate)
            _signals(axes[2], found, "stress-jerk, MPa/s$^2$", lambda s: s.jerk)
        _slip_map(axes[-1], found)
        axes[-1].set_xlabel("step")
        width = found.scene.readout.bandwidth_Hz
        figure.suptitle(
            f"{found.scene.name}: signals band-limited to {width:g} Hz, {1e3 * found.delay:.3g} ms late",
            fontsize=11,
        )
    return figure


def _forces(axes: Axes, found: Simulation) -> None:
    axes.plot(found.march.column("normal"), color=NORMAL, label="normal force $F_n$")
    axes.plot(found.march.column("tangential"), color=TANGENTIAL, label="tangential force $F_t$")
    axes.set_ylabel("force, N")
    axes.legend(loc="upper left", fontsize=8)
    axes.grid(color="#ddd", linewidth=0.6)


def _signals(axes: Axes, found: Simulation, label: str, of: object) -> None:
    assert callable(of)
    for row, (ridge, signal) in enumerate(found.signals.items()):
        assert isinstance(signal, Limited)
        axes.plot(of(signal), label=f"ridge {ridge}", linewidth=1.0)
        step = found.slip_steps[ridge - 1]
        if step is not None and len(found.signals) <= 2:
            axes.axvline(step, color="#888", linewidth=0.8, linestyle="--")
            axes.annotate(
                f"ridge {ridge} slips",
                (step, 0.02 + 0.1 * row),
                xycoords=("data", "axes fraction"),
                fontsize=7,
            )
    axes.set_ylabel(label, fontsize=9)
    axes.legend(loc="upper left", fontsize=8, ncols=3)
    axes.grid(color="#ddd", linewidth=0.6)


def _slip_map(axes: Axes, found: Simulation) -> None:
    """Ridge by step: clear, sticking (in part at least), slipping with all that touches."""
    count = found.scene.design.ridge.count
    touches = np.array([reading.touches for reading in found.march.readings])
    touching = np.stack([touches[:, found.march.ridge == r].any(axis=1) for r in range(1, count + 1)], axis=1)
    state = touching.astype(int) + (touching & found.slipping)
    edges = np.arange(state.shape[0] + 1) - 0.5, np.arange(count + 1) + 0.5
    axes.pcolormesh(*edges, state.T, cmap=ListedColormap([OPEN, STICK, SLIP]), vmin=0, vmax=2)
    axes.set_ylabel("ridge")
    names = ((OPEN, "clear"), (STICK, "sticks"), (SLIP, "slips"))
    handles = [Patch(facecolor=colour, edgecolor="#888", label=name) for colour, name in names]
    axes.legend(handles=handles, loc="lower right", bbox_to_anchor=(1.0, 1.0), fontsize=8, ncols=3)
