"""The picture of a check: the force on each ridge, and from which force on all of them touch."""

from __future__ import annotations

import numpy as np

from skincad.mechanics.verdict import ContactCheck
from skincad.pictures.canvas import BLACK, BLUE, VERMILION, Picture, legend, sheet

SIZE, DPI = (7.5, 4.0), 100


def ridge_force_figure(check: ContactCheck) -> Picture:
    """Return a figure of each ridge's force, N, with its error bar."""
    with sheet(SIZE, DPI, 255) as figure:
        axes = figure.add_subplot()
        ridges = np.arange(1, check.ridges + 1)
        forces = [force.value or 0.0 for force in check.ridge_force]
        errors = [force.error or 0.0 for force in check.ridge_force]
        axes.bar(ridges, forces, yerr=errors, color=BLUE, ecolor=BLACK, capsize=3, label="force ± error")
        axes.axhline(check.force / check.ridges, color=VERMILION, linewidth=1.2, linestyle="--", label="mean")
        axes.set_xlabel("ridge")
        axes.set_ylabel("force, N")
        axes.set_xticks(ridges[:: 1 + (check.ridges - 1) // 20])  # from ridge 1 on, 20 at most
        axes.grid(visible=False, axis="x")
        legend(axes)
        needed = "" if check.all_touch_force.value is None else f"; all touch from {check.all_touch_force}"
        figure.suptitle(
            f"{check.name}: {check.touching} of {check.ridges} touch at {check.force:g} N{needed}"
        )
    return figure
