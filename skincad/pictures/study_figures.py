"""Pictures of studies: a result against what is varied."""

from __future__ import annotations

from skincad.pictures.canvas import Picture, sheet
from skincad.studies.solution import Solution

POINT, WISH, FOUND = "#1f5fa8", "#777777", "#c1531f"
SIZE, DPI = (7.0, 4.6), 100


def solution_figure(found: Solution) -> Picture:
    """Return a figure of the wanted result at each value that was tried, with its error."""
    (key, wanted), (knob,) = next(iter(found.target.items())), found.knobs
    tried = sorted(
        (float(each.values[knob.key]), estimate.value, estimate.error or 0.0)
        for each in found.evaluations
        if not each.refused and (estimate := each.results[key]).value is not None
    )
    with sheet(SIZE, DPI, 255) as figure:
        axes = figure.add_subplot()
        axes.axhline(wanted, color=WISH, linewidth=1.0, linestyle="--", label=f"wanted: {wanted:g}")
        if tried:
            at, value, error = zip(*tried, strict=True)
            axes.errorbar(at, value, error, fmt=".-", color=POINT, linewidth=1.0, capsize=3, label="tried")
        for number, each in enumerate(found.solutions):
            place = float(each.values[knob.key]), float(each.reached[key])
            axes.plot(*place, "o", color=FOUND, markersize=8, label="" if number else "solution")
        if knob.by_ratio:
            axes.set_xscale("log")
            axes.xaxis.set_major_formatter("{x:g}")
            axes.xaxis.set_minor_formatter("{x:g}")
        if tried and all(low > 0 for low in value) and max(value) > 10 * min(value):
            axes.set_yscale("log")
            axes.yaxis.set_major_formatter("{x:g}")
        axes.set_xlabel(f"{knob.key}, {knob.unit}" if knob.unit else knob.key)
        axes.set_ylabel(key)
        axes.grid(color="#e4e4e4", linewidth=0.6)
        axes.legend(fontsize=8)
        axes.set_title(f"{found.name}: {key} against {knob.key}", fontsize=11)
    return figure
