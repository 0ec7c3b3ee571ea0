"""A lift's figure: forces, signals, which ridges slip, and the slide, with the alarms across all of them."""

from __future__ import annotations

import numpy as np

from skincad.outputs.figures.canvas import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    OPEN,
    STICK,
    THIN,
    VERMILION,
    Axes,
    ListedColormap,
    Picture,
    legend,
    sheet,
)
from skincad.scenes.lift import Lift

SIZE = (9.0, 8.6)  # inches
LEAST_SLIDE = 0.1  # mm that the slide's axis reaches at least
MOST_SIGNALS = 4  # ridges whose signals are drawn: the loudest
TOUCHES = 1e-3  # of the mean normal force; a ridge that bears less is clear


def lift_figure(lift: Lift) -> Picture:
    """Return a figure of one lift; a dashed line stands at each alarm that the policy took."""
    run, grip = lift.march, lift.grip
    with sheet(SIZE, 255) as figure:
        heard = bool(run.outputs.size)
        rows = figure.subplots(4 if heard else 3, 1, sharex=True)
        _forces(rows[0], lift)
        if heard:
            _signals(rows[1], lift)
        _slips(rows[-2], lift)
        rows[-1].plot(run.time, np.abs(run.slide), color=VERMILION)
        top = max(LEAST_SLIDE, 1.05 * float(np.abs(run.slide).max()))
        rows[-1].set(ylabel="slide, mm", xlabel="time, s", xlim=(0.0, run.time[-1]), ylim=(0.0, top))
        for axes in rows:
            for i, at in enumerate(lift.alarms):
                axes.axvline(at, color=GREY, linewidth=THIN, linestyle="--", label="_" if i else "alarm")
        legend(rows[0], 5)
        figure.align_ylabels(rows.tolist())
        figure.suptitle(f"{lift.name}: {lift.verdict}, {grip.gripper}, policy {grip.policy}")
    return figure


def _forces(axes: Axes, lift: Lift) -> None:
    """Grip, what was asked of it, what friction needs, and the load."""
    run, cone = lift.march, lift.scene.cone
    assert cone is not None
    axes.plot(run.time, run.grip, color=BLUE, label="grip of a finger")
    axes.plot(run.time, run.asked, color=BLUE, linewidth=THIN, linestyle=":", label="asked for")
    axes.plot(run.time, np.abs(run.load) / cone.static, color=VERMILION, label="least that holds the load")
    axes.plot(run.time, run.pull, color=BLACK, linewidth=THIN, label="pull of the skin")
    axes.set_ylabel("force, N")


def _signals(axes: Axes, lift: Lift) -> None:
    """The pairs of the loudest ridges."""
    run, ridges = lift.march, lift.scene.readout.ridges
    pairs = 1e3 * (run.outputs[:, :, 0] - run.outputs[:, :, 1])
    loudest = np.sort(np.argsort(-pairs.std(axis=0), kind="stable")[:MOST_SIGNALS])
    for place, color in zip(loudest.tolist(), (BLUE, VERMILION, GREEN, BLACK), strict=False):
        axes.plot(run.time, pairs[:, place], color=color, linewidth=THIN, label=f"ridge {ridges[place]}")
    axes.set_ylabel("S1 - S2, mV")
    legend(axes, MOST_SIGNALS)


def _slips(axes: Axes, lift: Lift) -> None:
    """Which ridges are clear of the object, stick, and slip."""
    run = lift.march
    ridges = run.slipping.shape[1]
    bears = run.loads[:, 0] > TOUCHES * run.grip.max() / ridges
    state = np.where(run.slipping, 2, bears.astype(int)).T
    edges = np.append(run.time, 2 * run.time[-1] - run.time[-2])
    colors = ListedColormap([OPEN, STICK, VERMILION])
    axes.pcolormesh(edges, np.arange(ridges + 1) + 0.5, state, cmap=colors, vmin=0, vmax=2)
    axes.set(ylabel="ridge\n(red: slips)", yticks=range(1, ridges + 1))
    axes.grid(visible=False)
