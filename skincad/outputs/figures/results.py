"""Figures of a check and its report, of a material test, and of a circuit's gain (Fig 7)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from skincad.circuit.calibrate import PAPER_ABOVE, PAPER_BELOW, PAPER_CUTOFF, PAPER_HIGH, PAPER_LOW
from skincad.circuit.model import constants, load_circuit
from skincad.laws.rubber import LONGEST, SHORTEST, Rubber
from skincad.outputs.figures.canvas import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    MAP,
    NOTE,
    SMALL,
    VERMILION,
    Axes,
    EllipseCollection,
    Figure,
    LogLocator,
    Normalize,
    NullLocator,
    Picture,
    chart,
    colormaps,
    sheet,
)

if TYPE_CHECKING:
    from skincad.circuit.bode import CircuitGain
    from skincad.material.acceptance import Acceptance
    from skincad.material.modulus import MaterialFit
    from skincad.mechanics.manufacture import Sensitivity
    from skincad.mechanics.verdict import ContactCheck

MAGNET_SIZE, MAX_NUMBERS = (9.0, 3.6), 49  # inches; of pins whose numbers can be read
FORCES_SIZE = (7.5, 4.0)  # inches
REPORT_SIZE = (7.0, 3.0)  # inches
AXIS_ROOM = 3.0  # by which the axes reach beyond the points
# points: where a point's name may begin
LABEL_OFFSETS = ((7, 7), (-7, -7), (7, -7), (-7, 7), (7, 20), (-7, -20))
LABEL_CLEARANCE = 4.0  # pixels, of a name from a point
NARROW_RATIO = 20.0  # ratio of errors below which more than powers of ten are named
Points = Sequence[tuple[str, float, float]]
FIT_SIZE = (7.5, 4.4)  # inches
PAPERS = ("yamada-2002", "yamada-2002-motional")  # the readings of the paper's circuit
PAPER_DROP = 9000.0  # Hz; paper, section 3.2
GAIN_SIZE = (9.0, 5.6)  # inches


def ridge_force_figure(check: ContactCheck) -> Picture:
    """Return a figure of each ridge's force, N, with its error bar."""
    needed = "" if check.all_touch_force.value is None else f"; all touch from {check.all_touch_force}"
    title = f"{check.name}: {check.touching} of {check.ridges} touch at {check.force:g} N{needed}"
    counted = "face" if check.family == "flat" else check.family
    with chart(FORCES_SIZE, title, xlabel=counted, ylabel="force, N") as (figure, axes):
        ridges = np.arange(1, check.ridges + 1)
        forces = [force.value or 0.0 for force in check.ridge_force]
        errors = [force.error or 0.0 for force in check.ridge_force]
        axes.bar(ridges, forces, yerr=errors, color=BLUE, ecolor=BLACK, capsize=3, label="force ± error")
        axes.axhline(check.force / check.ridges, color=VERMILION, linewidth=1.2, linestyle="--", label="mean")
        axes.set_xticks(ridges[:: 1 + (check.ridges - 1) // 20])  # from ridge 1 on, 20 at most
        axes.grid(visible=False, axis="x")
    return figure


def magnet_figure(check: ContactCheck) -> Picture:
    """Return maps of the pins from above, coloured by the least force along x, y and z that the sensors tell
    from noise where all pins' forces are unknown, mN, white where they don't; a cross is a sensor."""
    magnet = check.magnet
    assert magnet is not None  # as it is drawn
    place = np.array([pin.place[:2] for pin in magnet.pins])
    floor = 1e3 * np.array([[np.nan if f is None else f for f in pin.floor] for pin in magnet.pins])
    sensor = np.array([reading.place[:2] for reading in magnet.sensors])
    apart = np.linalg.norm(place[:, None] - place, axis=2) + np.diag(np.full(len(place), np.inf))
    wide = 0.8 * float(apart.min()) if len(place) > 1 else 1.0
    most = float(np.nanmax(floor)) if np.isfinite(floor).any() else 1.0
    both, numbers = np.vstack([place, sensor]), len(place) <= MAX_NUMBERS
    with sheet(MAGNET_SIZE, 255) as figure:
        panels = figure.subplots(1, 3, sharey=True)
        for axes, axis, noise in zip(panels, "xyz", floor.T, strict=True):
            sizes = [np.full(len(place), size) for size in (wide, wide, 0.0)]
            at: dict[str, Any] = {"units": "xy", "offsets": place, "offset_transform": axes.transData}
            circles = EllipseCollection(
                *sizes, **at, edgecolor=GREY, cmap=colormaps[MAP], norm=Normalize(0.0, most)
            )
            circles.set_array(np.ma.masked_invalid(noise))
            axes.add_collection(circles)
            axes.plot(*sensor.T, "+", color=VERMILION, markersize=6)
            for (x, y), value in zip(place.tolist(), noise.tolist(), strict=True) if numbers else ():
                words = "none" if np.isnan(value) else f"{value:.2g}"
                colour = "white" if value > 0.6 * most else BLACK
                above = x, y + 0.16 * wide
                axes.annotate(words, above, ha="center", va="bottom", fontsize=NOTE, color=colour)
            low, high = both.min(axis=0) - wide, both.max(axis=0) + wide
            axes.set(aspect="equal", xlim=(low[0], high[0]), ylim=(low[1], high[1]))
            axes.set(title=f"along {axis}", xlabel="x, mm")
            axes.grid(visible=False)
        panels[0].set_ylabel("y, mm")
        figure.colorbar(circles, ax=panels, label="rms noise of a pin's force, mN")
        figure.suptitle(f"{check.name}: forces by magnetometers (+), up to {magnet.band:g} Hz")
    return figure


def models_figure(models: Points) -> Picture:
    """Return the relative error of the all-touch force against the usual time, in that of the linear model: a
    point for each model tried, as `(name, time, error)`; the last one gave the verdict."""
    shown = [model for model in models if model[2] > 0]
    with sheet(REPORT_SIZE) as figure:
        axes = figure.add_subplot()
        times, errors = [model[1] for model in shown], [model[2] for model in shown]
        axes.loglog(times, errors, color=GREY, linewidth=1.0, zorder=1)
        axes.scatter(times[:-1], errors[:-1], color=BLUE, s=36, zorder=2)
        axes.scatter(times[-1:], errors[-1:], color=VERMILION, marker="D", s=44, zorder=2)
        spans = [(min(values) / AXIS_ROOM, max(values) * AXIS_ROOM) for values in (times, errors)]
        axes.set(xlim=spans[0], ylim=spans[1])
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_minor_locator(NullLocator())
            axis.set_major_formatter("{x:g}")
        if max(errors) < NARROW_RATIO * min(errors):  # with its room: no two powers of ten need lie within
            axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axes.set(xlabel="usual time over that of linear, 1", ylabel="error of the all-touch\nforce, relative")
        _label_points(figure, axes, shown)
    return figure


def _label_points(figure: Figure, axes: Axes, shown: Points) -> None:
    """Put each point's name beside it: within the axes, on no other name, point or line."""
    figure.draw_without_rendering()  # else nothing has its place yet
    at = axes.transData.transform([(time, error) for _, time, error in shown])
    import shapely  # which a circuit's figure need not load

    obstacles = [shapely.Point(place).buffer(LABEL_CLEARANCE) for place in at]
    obstacles += [shapely.LineString(at)] if len(at) > 1 else []
    whole = shapely.box(*axes.bbox.extents)
    for name, time, error in shown:
        for x, y in LABEL_OFFSETS:
            side: dict[str, Any] = {"ha": "left" if x > 0 else "right", "va": "bottom" if y > 0 else "top"}
            side |= {"textcoords": "offset points", "fontsize": SMALL}
            label = axes.annotate(name, (time, error), (x, y), **side)
            box = shapely.box(*label.get_window_extent().extents)
            free = whole.contains(box) and not any(map(box.intersects, obstacles))
            if free or (x, y) == LABEL_OFFSETS[-1]:
                break
            label.remove()
        obstacles.append(box)


def sensitivity_figure(sensitivities: Sequence[Sensitivity]) -> Picture:
    """Return a bar for each key: the change of the all-touch force by 1 % more of it, N, with its error."""
    with sheet((REPORT_SIZE[0], 0.9 + 0.24 * len(sensitivities))) as figure:
        axes = figure.add_subplot()
        places = np.arange(len(sensitivities))[::-1]
        values = [sensitivity.change.value or 0.0 for sensitivity in sensitivities]
        errors = [sensitivity.change.error or 0.0 for sensitivity in sensitivities]
        colours = [BLUE if value > 0 else VERMILION for value in values]
        axes.barh(places, values, xerr=errors, color=colours, capsize=2.5, error_kw={"linewidth": 1.0})
        axes.axvline(0.0, color=GREY, linewidth=0.8)
        axes.set_yticks(places, [sensitivity.key for sensitivity in sensitivities])
        axes.set_xlabel("change of the all-touch force for 1 % more of it, N")
        axes.grid(visible=False, axis="y")
    return figure


def fit_figure(fit: MaterialFit) -> Picture:
    """Return a figure of the rows used and the fitted model: N against mm of a pad, MPa against strain."""
    deformation, load, modelled = fit.curve
    x, y = ("approach, mm", "force, N") if fit.kind == "pad" else ("strain, mm/mm", "stress, MPa")
    with chart(FIT_SIZE, f"Young's modulus {fit.young_modulus}", xlabel=x, ylabel=y) as (figure, axes):
        axes.plot(deformation, load, ".", color=BLUE, markersize=4, label=f"{fit.rows_used} rows of the test")
        axes.plot(deformation, modelled, color=VERMILION, linewidth=1.2, label="model")
    return figure


def acceptance_figure(result: Acceptance) -> Picture:
    """Return a figure of a press's rows over the band of good parts, N against mm."""
    approach, force = result.curve
    at, low, high = result.band
    title = f"{result.name}: {result.verdict}"
    with chart(FIT_SIZE, title, xlabel="approach, mm", ylabel="force, N") as (figure, axes):
        axes.fill_betweenx(at, low, high, color=BLUE, alpha=0.25, linewidth=0, label="95 % of good parts")
        look: dict[str, Any] = {"fmt": ".", "color": VERMILION, "markersize": 4, "linewidth": 0.8}
        errors, rows = (2 * result.force_error, 2 * result.approach_error), f"{result.rows} rows of the press"
        axes.errorbar(approach, force, *errors, label=rows, **look)
    return figure


def law_figure(law: Rubber) -> Picture:
    """Return a figure of a law's nominal stress and tangent modulus, MPa, against the stretch of a bar."""
    stretch = np.linspace(SHORTEST, LONGEST, 301)
    title = f"{law.kind} bar, Young's modulus {3 * law.shear:.4g} MPa"
    with chart(FIT_SIZE, title, xlabel="stretch, mm/mm", ylabel="stress and modulus, MPa") as (figure, axes):
        axes.plot(stretch, law.stress(stretch), color=BLUE, linewidth=1.6, label="nominal stress")
        modulus = law.tangent_modulus(stretch)
        axes.plot(stretch, modulus, color=VERMILION, linewidth=1.2, label="tangent modulus")
    return figure


def gain_figure(circuit_gain: CircuitGain) -> Picture:
    """Return a figure of the gain in dB re 1 V/N, its fitted lines, the paper's statements and measured data;
    of a circuit with a rig also the film's own gain.

    The paper's lines take the curve's mean level up to 8 kHz: the paper's own is not known.
    """
    title, labels = f"{circuit_gain.name}: gain of film and amplifier", ("frequency, Hz", "gain, dB re 1 V/N")
    with chart(GAIN_SIZE, title, 2, xlabel=labels[0], ylabel=labels[1]) as (figure, axes):
        if (measured := circuit_gain.measured) and (calibration := circuit_gain.calibration):
            shifted, label = measured.gain - calibration.offset, f"measured, {-calibration.offset:+.4g} dB"
            axes.semilogx(measured.frequency, shifted, ".", color=BLACK, markersize=4, label=label)
        name = "network and rig, by the measured load" if circuit_gain.own else "network"
        axes.semilogx(circuit_gain.frequency, circuit_gain.gain, color=BLUE, linewidth=1.6, label=name)
        if circuit_gain.own:
            name, own = "network alone: the film's signal in use", circuit_gain.own.gain
            axes.semilogx(circuit_gain.frequency, own, color=GREEN, linewidth=1.2, label=name)
        _draw_fit(axes, circuit_gain)
        if constants(circuit_gain.circuit) in [constants(load_circuit(name)) for name in PAPERS]:
            _draw_paper(axes, circuit_gain)
        axes.grid(which="both")
    return figure


def _draw_fit(axes: Axes, circuit_gain: CircuitGain) -> None:
    slopes = circuit_gain.slopes
    beyond = "no cut-off" if slopes.cutoff.value is None else f"{slopes.above}, cut-off {slopes.cutoff}"
    label = f"fitted: {slopes.below}, {beyond}"
    ends = np.array([circuit_gain.frequency[0], _corner(circuit_gain), circuit_gain.circuit.sweep.fit_high])
    below, above = slopes.below.value or 0.0, slopes.above.value or 0.0
    values = _lines(ends, _corner(circuit_gain), slopes.level, below, above)
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
