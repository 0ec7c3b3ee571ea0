"""The pictures of docs/ that skincad draws: `python -m bench.pictures [PICTURE]...`, a minute or two.

Most are files of a command that the page shows. The labelled section shows every length of `[skin]`,
`[ridge]`, `[slot]` and `[film]` on a section that skincad builds, with fillets, crown and slots larger than
is usual so that they can be seen. Stress-rate and stress-jerk of yamada-2002-slip stand beside what the paper
says of its figures 12 and 13. `bench.error_bars --picture` draws the calibration plot: stated error
against true error of random designs, read in grey too.
"""

from __future__ import annotations

import math
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

import skincad
from bench.error_bars import Row
from skincad.base import Array
from skincad.inputs import Design
from skincad.outputs import Axes, save, sheet
from skincad.scenes import (
    March,
    differential,
    load_scene,
    marched,
    near_chosen,
    read_out,
    shown_signal,
)
from skincad.shape import polygon, section, skin_of

DOCS = Path(__file__).parents[1] / "docs"
WISH = (
    "new pad.toml --size 24x30 --touch 1N --silicone ecoflex-00-50 --process sla --gripper franka-hand"
    " --film pvdf-28um"
)
GEOMETRY, PAPER = "understand/geometry.png", "evidence/paper.png"
PICTURES = {  # in docs/ -> the commands that draw it, and its file
    "start/pictures/first-skin.png": (("make yamada-2002 --format png",), "out/yamada-2002/picture.png"),
    "start/pictures/own-design.png": ((WISH, "make pad.toml --format png"), "out/pad/picture.png"),
    "start/pictures/first-scene.png": (("simulate yamada-2002-slip",), "out/yamada-2002-slip/signals.png"),
    "howto/pictures/solve.png": (
        ("solve plain-ridges --target all_touch_force=1.5 --vary ridge.levelling=0:1 --picture solve.png",),
        "solve.png",
    ),
    "howto/pictures/sweep.png": (
        ("sweep plain-ridges --vary ridge.levelling=0:1:3 --vary ridge.height=0.5,0.6",),
        "out/plain-ridges/effects.png",
    ),
    "howto/pictures/gain.png": (("circuit transimpedance",), "out/transimpedance/gain.png"),
    "howto/pictures/alarms.png": (
        ("simulate yamada-2002-slip --set effects.piezo.circuit=transimpedance --set readout.ridges=[2,3]",),
        "out/yamada-2002-slip/recording.png",
    ),
    "howto/pictures/lift-held.png": (("simulate lift",), "out/lift/lift.png"),
    "howto/pictures/lift-dropped.png": (("simulate lift --set grip.policy=constant",), "out/lift/lift.png"),
}


SKIN, FILM, INK, HELP = "#eebda5", "#b3432b", "#14447a", "#8a8a8a"
WORDS = {"color": INK, "family": "monospace"}
SIDES = {  # shift in points, alignments
    "above": ((0, 3), "center", "bottom"),
    "below": ((0, -3), "center", "top"),
    "left": ((-5, 0), "right", "center"),
    "right": ((5, 0), "left", "center"),
}
CHORD = 1e-3  # mm; finer than a pixel
MIDDLE = 3  # the upright ridge of five
Place = tuple[float, float]  # mm in the section
PANELS = {
    "mesh of the linear model": lambda row: row.part == "mesh",
    "model: free ends, finite strain": lambda row: row.part in ("ends", "strain", "method"),
    "model: winkler": lambda row: row.part == "model",
}
MARKS = {
    "all_touch_force": ("#0072b2", "o", "all-touch force"),
    "approach": ("#b3470a", "^", "approach"),
    "shares": ("#3a7d44", "s", "shares"),
}
LEAST = 1e-7  # of the value; smaller errors are drawn there
MOST = 3.0


def draw(name: str) -> None:
    if name in DRAWN:
        DRAWN[name](DOCS / name)
        return
    commands, file = PICTURES[name]
    with tempfile.TemporaryDirectory() as folder:
        for command in commands:
            line = [sys.executable, "-m", "skincad", *command.split()]
            subprocess.run(line, cwd=folder, check=True, stdout=subprocess.DEVNULL, timeout=600)
        (DOCS / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(Path(folder) / file, DOCS / name)


def shown() -> Design:
    """Return a design whose details are large enough to be labelled."""
    return skincad.load("yamada-2002").with_(
        skin={"curvature_radius": 9.0, "width": 6.4, "thickness": 2.6},
        ridge={"count": 5, "height": 0.6, "crown": 0.07, "tip_fillet": 0.07, "root_fillet": 0.1},
        slot={"thickness": 0.07, "depth": 0.3, "offset": 0.17, "elevation": 0.1, "tilt": 14.0},
        film={"thickness": 0.028},
    )


def geometry_plot(path: Path) -> None:
    """Draw the whole section and its middle ridge, without and with slots, with their keys, into a PNG."""
    design = shown()
    with sheet((11.0, 8.6), colours=64) as figure:
        panels = figure.subplot_mosaic([["whole", "whole"], ["ridge", "slots"]], height_ratios=(1.0, 1.3))
        for name, draw in (("whole", _whole), ("ridge", _ridge), ("slots", _slots)):
            draw(panels[name], design)
        panels["ridge"].set_title("[ridge]", family="monospace")
        panels["slots"].set_title("[slot] and [film]", family="monospace")
    save(figure, path)


def _skin(axes: Axes, design: Design, slots: bool) -> None:
    """The section in its own colours, without axes."""
    shape, film = section(design), design.film
    places = shape.slots if slots else ()
    outlines = [(shape.outline, SKIN), *((s.loop(), "white") for s in places)]
    outlines += [(s.loop(film.thickness), FILM) for s in places if film]
    for outline, face in outlines:
        axes.fill(*polygon(outline, CHORD).T, facecolor=face, edgecolor="#222222", linewidth=0.9)
    axes.set_aspect("equal")
    axes.set_axis_off()


def _size(axes: Axes, a: Place, b: Place, words: str, side: str) -> None:
    """A length from a to b with its key on one side of its middle."""
    _arrow(axes, a, b, "<->")
    (x, y), across, up = SIDES[side]
    at = ((a[0] + b[0]) / 2, (a[1] + b[1]) / 2)
    axes.annotate(words, at, (x, y), textcoords="offset points", ha=across, va=up, **WORDS)


def _point(axes: Axes, at: Place, words: str, place: Place) -> None:
    """A key at `place` with an arrow to what it means."""
    after = place[0] > at[0]
    arrow = {"arrowstyle": "->", "color": INK, "shrinkB": 0, "relpos": (0.0 if after else 1.0, 0.5)}
    axes.annotate(words, at, place, ha="left" if after else "right", va="center", arrowprops=arrow, **WORDS)


def _arrow(axes: Axes, a: Place, b: Place, style: str) -> None:
    axes.annotate("", b, a, arrowprops={"arrowstyle": style, "color": INK, "shrinkA": 0, "shrinkB": 0})


def _text(axes: Axes, at: Place, words: str) -> None:
    axes.text(*at, words, va="top" if "\n" in words else "baseline", **WORDS)


def _line(axes: Axes, *points: Place) -> None:
    axes.plot(*np.array(points).T, color=HELP, linewidth=0.8, linestyle=(0, (5, 3)))


def _whole(axes: Axes, design: Design) -> None:
    """The whole section: frame, numbers of the ridges, and the lengths of `[skin]`."""
    _skin(axes, design, slots=True)
    skin, half = design.skin, design.skin.width / 2
    for ridge in range(1, skin_of(design).count + 1):
        axes.text(
            *skin_of(design).placed[ridge - 1].frame.at(0.0, -0.35),
            str(ridge),
            ha="center",
            va="center",
            fontsize=11,
        )
    _size(axes, (-half, -0.25), (half, -0.25), "skin.width", "below")
    _size(axes, (0.45, 0.0), (0.45, skin.thickness), "skin.thickness", "right")
    _line(axes, (0.0, skin.thickness), (0.6, skin.thickness))
    base = np.linspace(-0.47, 0.47, 60)
    radius, centre = skin.curvature_radius, skin.thickness - skin.curvature_radius
    _line(axes, *zip(radius * np.sin(base), centre + radius * np.cos(base), strict=True))
    end = (radius * math.sin(0.44), centre + radius * math.cos(0.44))
    _arrow(axes, (end[0] - 1.1 * math.sin(0.44), end[1] - 1.1 * math.cos(0.44)), end, "->")
    _text(axes, (end[0] + 0.2, end[1] - 0.5), "skin.curvature_radius,\nof the base circle (dashed)")
    corner = (-half - 1.4, 0.1)
    for way, name in (((0.8, 0.0), "x"), ((0.0, 0.8), "z")):
        tip = (corner[0] + way[0], corner[1] + way[1])
        _arrow(axes, corner, tip, "->")
        _text(axes, (tip[0] + 0.1, tip[1] + 0.1), name)
    _text(axes, (corner[0] - 1.3, -0.12), "y into the page,\nskin.length along it")
    _text(axes, (-2.6, 0.25), "flat back, z = 0")
    axes.set_xlim(-half - 2.9, half + 3.2)
    axes.set_ylim(-0.65, 3.4)


def _ridge(axes: Axes, design: Design) -> None:
    """The middle ridge and its neighbour without slots, and the lengths of `[ridge]`."""
    _skin(axes, design, slots=False)
    own, ridge = skin_of(design).placed[MIDDLE - 1].frame, design.ridge
    at, root, tip = own.at, ridge.root_width / 2, ridge.tip_width / 2
    edge, crest = ridge.height - ridge.crown, ridge.height
    beside = skin_of(design).placed[MIDDLE].frame
    _line(axes, at(0.0, -0.1), at(0.0, crest + 0.4))
    _line(axes, beside.at(0.0, -0.1), beside.at(0.0, crest + 0.4))
    _size(axes, at(0.0, 0.0), beside.origin, "pitch", "below")
    _line(axes, at(-0.75, 0.0), at(root, 0.0))
    _line(axes, at(-0.75, crest), at(0.62, crest))
    _size(axes, at(-0.59, 0.0), at(-0.59, crest), "height", "right")
    _line(axes, at(-tip, edge), at(0.62, edge))
    _size(axes, at(0.55, edge), at(0.55, crest), "crown", "right")
    _size(axes, at(-tip, crest + 0.12), at(tip, crest + 0.12), "tip_width", "above")
    _size(axes, at(-root, -0.22), at(root, -0.22), "root_width", "below")
    for side in (-1, 1):
        _line(axes, at(side * tip, edge), at(side * tip, crest + 0.18))
        _line(axes, at(side * root, 0.0), at(side * root, -0.28))
    _point(axes, at(-tip - 0.005, edge - 0.03), "tip_fillet", at(-0.42, crest + 0.28))
    _point(axes, at(root + 0.005, 0.035), "root_fillet", at(0.42, 0.27))
    axes.set_xlim(-1.1, 1.55)
    axes.set_ylim(at(0, -0.4)[1], at(0, crest + 0.45)[1])


def _slots(axes: Axes, design: Design) -> None:
    """The middle ridge's slots with their strips, and the lengths of `[slot]` and `[film]`."""
    _skin(axes, design, slots=True)
    own, slot = skin_of(design).placed[MIDDLE - 1].frame, skin_of(design).slot
    assert slot is not None
    at, (one, two) = own.at, (s for s in section(design).slots if s.feature == MIDDLE)
    half, wide = slot.depth / 2, slot.thickness / 2
    for each, aside in ((one, -0.03), (two, 0.03)):
        axes.text(*each.at(aside, half + 0.05), each.side, ha="center", weight="bold", fontsize=12)
    _line(axes, at(0.0, -0.34), at(0.0, 0.7))
    _line(axes, at(-0.45, 0.0), at(0.5, 0.0))
    _line(axes, two.centre, at(slot.offset, -0.34))
    _size(axes, at(0.0, -0.28), at(slot.offset, -0.28), "offset", "below")
    _line(axes, two.centre, at(0.5, slot.elevation))
    _size(axes, at(0.42, 0.0), at(0.42, slot.elevation), "elevation", "right")
    _line(axes, one.centre, one.at(0.0, 0.58))
    _line(axes, one.centre, at(-slot.offset, slot.elevation + 0.58))
    _point(axes, at(-0.12, slot.elevation + 0.45), "tilt, positive here", at(-0.34, 0.7))
    for along in (-half, half):
        _line(axes, one.at(-wide, along), one.at(-wide - 0.22, along))
    _size(axes, one.at(-wide - 0.18, -half), one.at(-wide - 0.18, half), "depth", "left")
    _point(axes, one.at(wide, -half + 0.03), "thickness", at(-0.36, -0.22))
    _point(axes, two.at(0.0, 0.06), "film.thickness", at(0.38, 0.45))
    axes.set_xlim(-0.72, 0.92)
    axes.set_ylim(at(0, -0.4)[1], at(0, 0.78)[1])


def calibration_plot(rows: list[Row], path: Path) -> None:
    """Write a PNG of stated against true relative error; below the line a bar is too narrow."""
    with sheet((12.0, 4.4), colours=64, dpi=100) as figure:
        for axes, (title, belongs) in zip(figure.subplots(1, len(PANELS)), PANELS.items(), strict=True):
            _panel(axes, title, [row for row in rows if belongs(row) and row.value])
    save(figure, path)


def _panel(axes: Axes, title: str, rows: list[Row]) -> None:
    for quantity, (colour, marker, label) in MARKS.items():
        for top in (False, True):
            mine = [row for row in rows if row.quantity == quantity and row.top is top]
            true = [max(row.true / abs(row.value), LEAST) for row in mine]
            stated = [max(row.stated / abs(row.value), LEAST) for row in mine]
            told = f"{label}, {'top refinement' if top else 'refinement above'}"
            fill = colour if top else "none"
            style = {"color": colour, "markerfacecolor": fill, "markersize": 4.5, "alpha": 0.75}
            axes.plot(true, stated, marker, label=told, **style)
    ends = np.array([LEAST, MOST])
    axes.plot(ends, ends, color="#222222", linewidth=1.2)
    axes.plot(ends, 10 * ends, color="#777777", linewidth=0.9, linestyle="--")
    axes.set(xscale="log", yscale="log", xlim=(LEAST / 1.5, MOST), ylim=(LEAST / 1.5, MOST))
    axes.set_xlabel("true error, relative")
    axes.set_ylabel("stated error, relative")
    axes.grid(color="#e4e4e4", linewidth=0.6)
    axes.legend(fontsize=7, loc="upper left")
    if rows:
        held, width = np.mean([r.held for r in rows]), np.median([r.width for r in rows])
        title += f"\n{len(rows)} cases, {held:.1%} held, median {width:.1f} times too wide"
    axes.set_title(title, fontsize=9)
    axes.text(MOST / 2, 3 * LEAST, "below the line: too narrow", fontsize=7, ha="right", color="#222222")


MONITORED, PAPERS_SLIP = 3, 450  # a ridge, and the step at which the paper says that it slips


def paper_plot(path: Path) -> None:
    """Write a PNG of the stress-rate and the stress-jerk of ridge 3 of yamada-2002-slip.

    The band is what a finer mesh and other fillets change; where no step of the fillets as drawn is known it
    stays as wide as on average before.
    """
    scene = load_scene("yamada-2002-slip")
    run = marched(scene, further_models=True)
    told, runs = read_out(scene, run), run.runs

    def signals(march: March | None) -> Array:
        assert march is not None
        values = differential(scene, march)[MONITORED]
        signal = shown_signal(march.time, values, scene.readout.bandwidth_Hz)
        return np.array([signal.rate, signal.jerk])[:, : run.runs.march.time.size]

    values = signals(runs.march)
    mesh, fillets = np.abs(signals(runs.before) - signals(runs.after)), np.abs(signals(runs.fillets) - values)
    last = near_chosen(runs.march, runs.fillets)
    fillets[:, last:] = fillets[:, last // 2 : last].mean(axis=1, keepdims=True)
    step, slip = np.arange(values.shape[1]), told.slip_steps[MONITORED - 1]
    error = told.slip_step_errors[MONITORED - 1].total
    with sheet((7.0, 5.2), colours=64, dpi=110) as figure:
        panels = figure.subplots(2, 1, sharex=True)
        for axes, value, off, words in zip(
            panels, values, mesh + fillets, ("rate, MPa/s", "jerk, MPa/s²"), strict=True
        ):
            axes.fill_between(step, value - off, value + off, color="#c9d8ee", linewidth=0)
            axes.plot(step, value, color=INK, linewidth=1.1)
            axes.axvline(PAPERS_SLIP, color=FILM, linewidth=1.0, linestyle="--")
            axes.axvspan(slip - error, slip + error, color=SKIN, linewidth=0)
            axes.set_ylabel(f"stress-{words}")
            axes.grid(color="#e4e4e4", linewidth=0.6)
            near = slice(scene.history.points[1] + 20, None)  # the first contact is off the scale
            low, high = (value - off)[near].min(), (value + off)[near].max()
            axes.set_ylim(low - 0.05 * (high - low), high + 0.05 * (high - low))
        top = panels[0].get_ylim()[1]
        panels[0].text(
            PAPERS_SLIP - 4, top, "slip in the paper ", color=FILM, ha="right", va="top", fontsize=8
        )
        panels[0].text(
            slip - error, top, "slip of ridge 3 ", color=INK, ha="right", va="top", fontsize=8, rotation=90
        )
        panels[1].set_xlabel("step of 10 µs")
    save(figure, path)


DRAWN = {GEOMETRY: geometry_plot, PAPER: paper_plot}

if __name__ == "__main__":
    for picture in sys.argv[1:] or [*PICTURES, *DRAWN]:
        draw(picture)
        print(f"{picture} {(DOCS / picture).stat().st_size / 1000:.0f} kB")
