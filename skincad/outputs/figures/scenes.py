"""A scene's figures: history, signals (Figs 11 to 13), slip map, and what a recorder shows of it (Fig 15)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from skincad.base.arrays import Array, Mask
from skincad.base.errors import InputError
from skincad.circuit.calibrate import PAPER_CUTOFF
from skincad.circuit.state import Recording, evenly_spaced, recorded
from skincad.fabrication.papers import macro
from skincad.outputs.figures.canvas import (
    BLACK,
    BLUE,
    GREY,
    LABEL,
    MAP,
    NOTE,
    OPEN,
    PALE,
    PHASE_A,
    PHASE_B,
    SIGNED_MAP,
    SMALL,
    STICK,
    THIN,
    VERMILION,
    Axes,
    EllipseCollection,
    FixedLocator,
    Line2D,
    ListedColormap,
    MaxNLocator,
    Patch,
    Picture,
    colormaps,
    legend,
    sheet,
)
from skincad.scenes.simulation import Simulation
from skincad.shape.skin import skin_of

SLIP = VERMILION
NORMAL, TANGENTIAL = BLUE, VERMILION
WIDTH, PANEL = 9.0, 1.9  # inches
SIGNALS = (
    ("value", "differential stress\nS1 - S2, MPa"),
    ("rate", "stress-rate, MPa/s"),
    ("jerk", "stress-jerk, MPa/s$^2$"),
)
MAX_PANELS = 9  # side by side; more ridges share panels
SLIPS: dict[str, Any] = {"linewidth": THIN, "linestyle": (0, (5, 3))}
PHASES = {"$P_A$": PHASE_A, "$P_B$": PHASE_B}
MIN_SAMPLES = 50  # samples that are worth a picture
PAPERS_RIDGE = 3
MAX_NUMBERS = 49  # pins that have their number in them
ROOM_ABOVE, ROOM_BELOW = 0.14, 0.4  # of the curves' height, for what is written beside them
UNITS = {"V": 1.0, "mV": 1e3, "uV": 1e6}


def scene_figure(simulation: Simulation) -> Picture:
    """Return a figure: forces by time (Fig 11), differential stress, its rate and jerk (Figs 12, 13) of each
    monitored ridge in its own panel, slip by ridge.

    The signals are drawn as they come out of the low-pass, later by its delay. A dashed line stands where a
    ridge begins to slip for good. Of a skin without films, the share of the contact that slips stands in the
    signals' place; of pins, a map (`_pin_figure`).
    """
    if skin_of(simulation.scene.design).standing:
        return _pin_figure(simulation)
    groups = ridge_groups(list(simulation.signals))
    shares = not groups and bool(simulation.scene.timed)
    rows = 2 + len(SIGNALS) * bool(groups) + shares
    with sheet((WIDTH, PANEL * rows + 0.8), 255) as figure:
        grid = figure.add_gridspec(rows, max(1, len(groups)))
        forces = figure.add_subplot(grid[0, :])
        _forces(forces, simulation)
        ticks = np.asarray(MaxNLocator(nbins=8).tick_values(0.0, milliseconds(simulation)[-1]))
        fewer = ticks[:: -(-ticks.size // (2 if len(groups) > MAX_PANELS // 2 else 4))]  # of narrow panels
        firsts = [forces]
        for row, (name, label) in enumerate(SIGNALS if groups else (), 1):
            places = [figure.add_subplot(grid[row, 0])]
            places += [figure.add_subplot(grid[row, i], sharey=places[0]) for i in range(1, len(groups))]
            for axes, group in zip(places, groups, strict=True):
                _signals(axes, simulation, group, name, first=axes is places[0])
            places[0].set_ylabel(label)
            firsts.append(places[0])
            for axes, group in zip(places if row == 1 else (), groups, strict=False):
                axes.set_title(_panel_name(group, list(simulation.signals)), fontsize=SMALL)
            for axes in places if row == len(SIGNALS) else ():
                axes.tick_params(labelbottom=True)
                axes.set_xlabel("time, ms")
        legend(forces, 3, handles=[*forces.lines, *_marks(simulation, groups)])
        if shares:
            firsts.append(figure.add_subplot(grid[1, :]))
            _slip_share(firsts[-1], simulation)
        slip = figure.add_subplot(grid[-1, :])
        _slip_map(slip, simulation)
        for axes in figure.axes:
            axes.set_xlim(0.0, milliseconds(simulation)[-1])
            wide = axes in (forces, slip) or shares
            axes.xaxis.set_major_locator(FixedLocator((ticks if wide else fewer).tolist()))
        slip.set_xlabel(_time_label(simulation))
        figure.align_ylabels([*firsts, slip])
        width = simulation.scene.readout.bandwidth_Hz
        late = f"signals band-limited to {width:g} Hz, {1e3 * simulation.delay:.3g} ms late"
        figure.suptitle(f"{simulation.scene.name}" + (f": {late}" if simulation.signals else ""))
    return figure


def milliseconds(simulation: Simulation) -> Array:
    """Return the time of each step `(steps + 1,)`, ms."""
    return np.asarray(1e3 * simulation.march.time)


def _forces(axes: Axes, simulation: Simulation) -> None:
    """The plate's forces by time."""
    time = milliseconds(simulation)
    axes.plot(time, simulation.march.column("normal"), color=NORMAL, label="normal force $F_n$")
    axes.plot(time, simulation.march.column("tangential"), color=TANGENTIAL, label="tangential force $F_t$")
    axes.set(ylabel="force, N", xlim=(0.0, time[-1]))


def _time_label(simulation: Simulation) -> str:
    """What the time is in, and how long a step is: words name steps."""
    time = milliseconds(simulation)
    equal = time.size > 1 and evenly_spaced(time)
    return f"time (a step is {time[1] - time[0]:.3g} ms), ms" if equal else "time, ms"


def strips_figure(simulation: Simulation) -> Picture:
    """Return the strips of all monitored ridges as images of ridge by time: S1 - S2, which a pull makes, and
    the mean of both, which a normal force makes."""
    march, ridges = simulation.march, list(simulation.raw)
    films = march.column("films")[:, :, 0]
    mean = np.array([(films[:, 2 * r - 2] + films[:, 2 * r - 1]) / 2 for r in ridges])
    parts = {
        "tangential part, S1 - S2, MPa": np.array([simulation.raw[r] for r in ridges]),
        "normal part, (S1 + S2) / 2, MPa": mean,
    }
    edges = np.append(march.time - np.diff(march.time, prepend=0.0) / 2, march.time[-1]) * 1e3
    with sheet((WIDTH, 2 * PANEL + 1.2), 255) as figure:
        places = figure.subplots(2, 1, sharex=True)
        for axes, (name, values) in zip(places, parts.items(), strict=True):
            most = float(np.abs(values).max()) or 1.0  # rest is the map's middle
            rows = np.arange(len(ridges) + 1) - 0.5
            image = axes.pcolormesh(edges, rows, values, cmap=colormaps[SIGNED_MAP], vmin=-most, vmax=most)
            axes.set_yticks(range(len(ridges)), [str(r) for r in ridges])
            axes.set_ylabel("ridge")
            axes.grid(visible=False)
            figure.colorbar(image, ax=axes, label=name)
        places[-1].set_xlabel("time, ms")
        figure.suptitle(f"{simulation.scene.name}: what the strips feel, as it is before any filter")
    return figure


def _pin_figure(simulation: Simulation) -> Picture:
    """A figure of pins: forces by time, and a map of the tips from above, coloured by the step from
    which each slips for good; those that never do are left white."""
    skin = skin_of(simulation.scene.design)
    tips = np.array([placed.tip for placed in skin.placed])
    steps = np.array([np.nan if step is None else step for step in simulation.slip_steps], dtype=float)
    with sheet((WIDTH, PANEL + WIDTH / 2), 255) as figure:
        grid = figure.add_gridspec(2, 1, height_ratios=(PANEL, WIDTH / 2))
        forces, plan = figure.add_subplot(grid[0]), figure.add_subplot(grid[1])
        _forces(forces, simulation)
        forces.set_xlabel(_time_label(simulation))
        legend(forces, 2)
        sizes = [np.full(skin.count, size) for size in (skin.profile.tip_width, skin.profile.tip_width, 0.0)]
        at: dict[str, Any] = {"units": "xy", "offsets": tips[:, :2], "offset_transform": plan.transData}
        circles = EllipseCollection(*sizes, **at, edgecolor=GREY, cmap=colormaps[MAP])
        circles.set_array(np.ma.masked_invalid(steps))
        plan.add_collection(circles)
        for number, (x, y, _) in enumerate(tips.tolist() if skin.count <= MAX_NUMBERS else (), 1):
            dark = steps[number - 1] > np.nan_to_num(steps).mean()
            colour = "white" if dark else BLACK
            plan.annotate(str(number), (x, y), ha="center", va="center", fontsize=NOTE, color=colour)
        across, along = skin.base.width / 2, skin.base.length / 2
        plan.set(aspect="equal", xlim=(-across, across), ylim=(-along, along))
        plan.set(xlabel="pulled along x, mm", ylabel="y, mm")
        plan.grid(visible=False)
        if np.isfinite(steps).any():
            figure.colorbar(circles, ax=plan, label="step from which it slips for good")
        figure.suptitle(simulation.scene.name)
    return figure


def magnet_figure(simulation: Simulation) -> Picture:
    """Return what magnetometers read of pins: the change of each one's field along x since the start, and the
    pull on each pin that the readings tell, over the march's own as a dashed line, both by time; a triangle
    is where the readings tell a pin's slip."""
    time, read = milliseconds(simulation), simulation.read
    fields, forces = read["field_mT"], read.get("pin_force_N", {})
    own = np.array([reading.tips[:, 0] for reading in simulation.march.readings if reading.tips is not None])
    with sheet((WIDTH, 2 * PANEL + 1.6), 255) as figure:
        upper, lower = figure.subplots(2, 1, sharex=True)
        for numbers, axes in ((fields, upper), (own.T, lower)):
            axes.set_prop_cycle(color=colormaps[MAP](np.linspace(1.0, 0.15, len(numbers))))
        for number, field in fields.items():
            values = 1e3 * (np.array(field["x"]) - field["x"][0])
            upper.plot(time, values, linewidth=1.0, label=f"sensor {number}")
        for number, (pull, slip) in enumerate(zip(own.T, read["magnet_slip_step"], strict=True), 1):
            (line,) = lower.plot(time, 1e3 * pull, linestyle="--", linewidth=THIN)
            if pin := forces.get(str(number)):
                values, colour = 1e3 * np.array(pin["x"]), line.get_color()
                lower.plot(time, values, color=colour, linewidth=1.0, label=f"pin {number}")
                if slip is not None:
                    lower.plot(time[slip], values[slip], "v", color=colour, markersize=7)
        upper.set(ylabel="change of field\nalong x, uT", xlim=(0.0, time[-1]))
        lower.set(ylabel="pull on a pin, mN", xlabel=_time_label(simulation))
        for axes, numbers in ((upper, fields), (lower, forces)):
            if 0 < len(numbers) <= MAX_NUMBERS // 2:
                legend(axes, 8)
        noise = f"noise {read['field_noise_uT_rms']:.2g} uT rms at {read['field_rate_Hz']:g} Hz"
        figure.suptitle(f"{simulation.scene.name}: {noise}\ndashed: the true pull; triangle: a slip is told")
    return figure


def ridge_groups(ridges: list[int]) -> list[list[int]]:
    """Return the ridges of each panel: one in each, or where they are many, as many neighbours in each."""
    size = max(1, -(-len(ridges) // MAX_PANELS))
    return [ridges[i : i + size] for i in range(0, len(ridges), size)]


def read_ridge(ridges: Sequence[int]) -> int:
    """Return the monitored ridge that is read: ridge 3, the paper's, or else the last one."""
    return PAPERS_RIDGE if PAPERS_RIDGE in ridges else ridges[-1]


def _signals(axes: Axes, simulation: Simulation, group: list[int], name: str, *, first: bool) -> None:
    """One signal of the ridges of one panel, with the error of the ridge that is read."""
    read = read_ridge(list(simulation.signals))
    shades = [BLUE] if len(group) == 1 else colormaps[MAP](np.linspace(1.0, 0.25, len(group)))
    time = milliseconds(simulation)
    for ridge, colour in zip(group, shades, strict=True):
        values, error = getattr(simulation.signals[ridge], name), _errors(simulation).get(ridge)
        axes.plot(time, values, color=colour, linewidth=1.0, label=f"ridge {ridge}")
        if name == "value" and error and ridge == read:
            axes.fill_between(time, values - error, values + error, color=PALE, alpha=0.7, linewidth=0)
        step = simulation.slip_steps[ridge - 1]
        if step is not None:
            axes.axvline(time[step], color=GREY if len(group) == 1 else colour, zorder=0.9, **SLIPS)
    axes.tick_params(labelbottom=False, labelleft=first)


def _panel_name(group: list[int], ridges: list[int]) -> str:
    read = read_ridge(ridges)
    if len(group) == 1:
        return f"ridge {group[0]}" + ", read" * (group == [read] != ridges)
    return f"{group[0]} to {group[-1]}" + f" ({read} read)" * (read in group)


def _marks(simulation: Simulation, groups: list[list[int]]) -> list[Any]:
    """What names bands, dashes and shades of the panels."""
    errors, ridges, marks = _errors(simulation), list(simulation.signals), list[Any]()
    if ridges and (error := errors.get(read := read_ridge(ridges))):
        others = f"; of all: at most ± {max(errors.values()):.1g}" if len(ridges) > 1 else ""
        marks.append(Patch(facecolor=PALE, label=f"error of ridge {read}: ± {error:.1g} MPa{others}"))
    if any(simulation.slip_steps[ridge - 1] is not None for ridge in ridges):
        marks.append(Line2D([], [], color=GREY, label="slips from here on", **SLIPS))
    if groups and len(groups[0]) > 1:
        for colour, name in zip(colormaps[MAP]([1.0, 0.25]), ("first", "last"), strict=True):
            marks.append(Line2D([], [], color=colour, label=f"{name} ridge of a panel"))
    return marks


def _errors(simulation: Simulation) -> dict[int, float]:
    """The whole error of each monitored ridge's stress, MPa, where it is known."""
    totals = {ridge: error.total for ridge, error in simulation.stress_errors.items()}
    return {ridge: total for ridge, total in totals.items() if total is not None}


def _slip_share(axes: Axes, simulation: Simulation) -> None:
    """The share of the contact that slips, by time."""
    axes.plot(milliseconds(simulation), 100 * simulation.slip_share, color=SLIP, linewidth=1.0)
    axes.set(ylabel="contact that\nslips, %", ylim=(0.0, 105.0))


def _slip_map(axes: Axes, simulation: Simulation) -> None:
    """Ridge by step: clear, sticking (in part at least), slipping with all that touches. Of a face, place by
    step."""
    march, count = simulation.march, simulation.slipping.shape[1]
    skin, bare = simulation.scene.design.skin, simulation.scene.bare
    touching: Mask = march.column("touches") > 0
    slipping: Mask = march.column("slips") > 0
    if bare:  # points are in the order of their places, and what each stands for adds up to its edge
        swept = np.append(0.0, np.cumsum(march.area))
        rows, place = (swept - swept[-1] / 2) / skin.length, "x, mm"
        if skin.round:
            rows, place = np.sqrt(swept / np.pi), "from the middle, mm"
    else:
        by_ridge = (touching[:, march.ridge == r] for r in range(1, count + 1))
        touching = np.column_stack([places.any(axis=1) for places in by_ridge])
        rows, place = np.arange(count + 1) + 0.5, skin_of(simulation.scene.design).family
        slipping = simulation.slipping
    state = touching.astype(int) + (touching & slipping)
    time = milliseconds(simulation)
    edges = np.append(time - np.diff(time, prepend=0.0) / 2, time[-1]), rows
    axes.pcolormesh(*edges, state.T, cmap=ListedColormap([OPEN, STICK, SLIP]), vmin=0, vmax=2)
    axes.set_ylabel(place)
    if not bare:
        axes.yaxis.set_major_locator(MaxNLocator(integer=True, nbins=9))
    axes.grid(visible=False)
    names = ((OPEN, "clear"), (STICK, "sticks"), (SLIP, "slips"))
    handles = [Patch(facecolor=colour, edgecolor=GREY, label=name) for colour, name in names]
    legend(axes, handles=handles)


@dataclass(frozen=True)
class RidgeRecording:
    """Both strips' outputs and their difference, V, at a recorder's rate or else at the run's steps."""

    ridge: int
    s1: Recording
    s2: Recording
    pair: Recording
    sampled: bool = True


def recording(simulation: Simulation) -> RidgeRecording | None:
    """Return what is recorded of ridge 3, or of the last monitored one; None without outputs.

    Without a sampling, where the run's steps are coarser or in no ratio of small numbers to it, and for fewer
    than MIN_SAMPLES, these are the outputs at the run's equal steps.
    """
    outputs, wanted = simulation.read.get("output_V"), simulation.read.get("sampling_Hz")
    time = simulation.march.time
    if not outputs or time.size < 2:
        return None
    ridge = read_ridge([int(name) for name in outputs])
    even = np.arange(time.size)
    if not evenly_spaced(time):
        steps = simulation.scene.history.even
        even = steps[steps < time.size]
    if even.size < 2:
        return None
    rate = 1 / float(time[even[1]] - time[even[0]])
    values = [np.array(outputs[str(ridge)][k])[even] for k in ("S1", "S2", "pair")]
    if wanted is not None and wanted * float(time[-1]) >= MIN_SAMPLES:
        with suppress(InputError):  # the rates of recorder and run have no ratio of small numbers
            s1, s2, pair = (recorded(of, rate, wanted) for of in values)
            return RidgeRecording(ridge, s1, s2, pair)
    s1, s2, pair = (Recording(of, rate, rate / 2, 0.0, ()) for of in values)
    return RidgeRecording(ridge, s1, s2, pair, sampled=False)


def recording_figure(simulation: Simulation, record: RidgeRecording) -> Picture:
    """Return a figure: S1 and S2, their difference vd with the phases P_A and P_B, the noise, the alarms, and
    what is not seen.

    P_A is from the start of the pull to the ridge's slip, P_B from there to gross slip.
    """
    with sheet((9.0, 6.4)) as figure:
        time = 1e3 * np.arange(record.pair.values.size) / record.pair.rate
        strips, pair = figure.subplots(2, 1, sharex=True)
        largest = max(float(np.abs(part.values).max()) for part in (record.s1, record.s2, record.pair))
        unit, factor = next(((u, f) for u, f in UNITS.items() if largest * f >= 1), ("uV", 1e6))
        for part, name, colour in ((record.s1, "S1", BLUE), (record.s2, "S2", VERMILION)):
            label = f"ridge {record.ridge} {name}"
            strips.plot(time, factor * part.values, color=colour, linewidth=1.0, label=label)
        pair.plot(time, factor * record.pair.values, color=BLACK, linewidth=1.0, label="$v_d$ = S1 - S2")
        if noise := simulation.read.get("output_noise_V_rms"):
            for axes, rms in ((strips, noise), (pair, math.sqrt(2) * noise)):
                band = f"noise, ± {factor * rms:.2g} {unit} rms"
                axes.axhspan(-factor * rms, factor * rms, color=GREY, alpha=0.4, linewidth=0, label=band)
        _name_alarms(pair, simulation, record.ridge)
        _make_room(strips, 0.0)
        _make_room(pair, ROOM_BELOW)
        for axes in (strips, pair):
            for name, (start, end) in phases(simulation, record.ridge).items():
                axes.axvspan(1e3 * start, 1e3 * end, color=PHASES[name], zorder=0)
                middle = 1e3 * (start + end) / 2
                axes.annotate(name, (middle, 0.9), xycoords=("data", "axes fraction"), ha="center")
            axes.set_ylabel(f"output, {unit}")
            legend(axes)
        _name_slips(pair, simulation, record)
        pair.set_xlabel("time, ms")
        figure.supxlabel(caption(simulation, record), fontsize=LABEL)
        seen = f"as recorded at {record.pair.rate:g} Hz" if record.sampled else "at the run's steps"
        figure.suptitle(f"{simulation.scene.name}: {simulation.read['circuit']} {seen}")
    return figure


def _name_alarms(axes: Axes, simulation: Simulation, ridge: int) -> None:
    """The alarms of all monitored ridges together, and those of this one."""
    for who, colour in ((None, VERMILION), (ridge, BLUE)):
        whose = "alarm" if who is None else f"alarm of ridge {ridge}"
        at = [1e3 * event["time_s"] for event in simulation.read.get("events", ()) if event["ridge"] == who]
        if at:
            foot: dict[str, Any] = {"transform": axes.get_xaxis_transform(), "clip_on": False}
            axes.plot(at, [0.0] * len(at), "^", color=colour, markersize=7, label=whose, **foot)


def _make_room(axes: Axes, under: float) -> None:
    """Leave room for the phases' names over the curves, and `under` them, of their height."""
    low, high = axes.get_ylim()
    axes.set_ylim(low - under * (high - low), high + ROOM_ABOVE * (high - low))


def caption(simulation: Simulation, record: RidgeRecording) -> str:
    """Return what this recording cannot show."""
    said = macro("answers/simulate.txt", "recorded", simulation, record, PAPER_CUTOFF)
    return said.removesuffix("\n")


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
    time = milliseconds(simulation)
    marks = {f"ridge {r}": simulation.slip_steps[r - 1] for r in (record.ridge - 1, record.ridge) if r >= 1}
    for name, step in {**marks, "all": simulation.gross_slip_step}.items():
        if step is not None:
            axes.axvline(time[step], color=GREY, linewidth=0.8, linestyle="--")
            foot: dict[str, Any] = {"xy": (time[step], 0.02), "xycoords": ("data", "axes fraction")}
            axes.annotate(f" {name} slips", **foot, fontsize=NOTE, rotation=90)
