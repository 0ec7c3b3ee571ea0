"""The picture of a material test: its rows, and the model with the fitted modulus."""

from __future__ import annotations

from skincad.material.modulus import MaterialFit
from skincad.pictures.canvas import BLUE, VERMILION, Picture, legend, sheet

SIZE, DPI = (7.5, 4.4), 100


def fit_figure(fit: MaterialFit) -> Picture:
    """Return a figure of the rows used and the fitted model: N against mm of a pad, MPa against strain."""
    deformation, load, modelled = fit.curve
    with sheet(SIZE, DPI, 255) as figure:
        axes = figure.add_subplot()
        axes.plot(deformation, load, ".", color=BLUE, markersize=4, label=f"{fit.rows_used} rows of the test")
        axes.plot(deformation, modelled, color=VERMILION, linewidth=1.2, label="model")
        pad = fit.kind == "pad"
        axes.set_xlabel("approach, mm" if pad else "strain, mm/mm")
        axes.set_ylabel("force, N" if pad else "stress, MPa")
        legend(axes)
        figure.suptitle(f"Young's modulus {fit.young_modulus}")
    return figure
