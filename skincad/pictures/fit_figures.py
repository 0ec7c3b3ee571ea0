"""The picture of a material test: its rows, and the model with the fitted modulus."""

from __future__ import annotations

from skincad.material.modulus import MaterialFit
from skincad.pictures.canvas import Picture, sheet

ROWS, MODEL = "#1f5fa8", "#c1531f"
SIZE, DPI = (7.5, 4.4), 100


def fit_figure(fit: MaterialFit) -> Picture:
    """Return a figure of the rows used and the fitted model: N against mm of a pad, MPa against strain."""
    deformation, load, modelled = fit.curve
    with sheet(SIZE, DPI, 255) as figure:
        axes = figure.add_subplot()
        axes.plot(deformation, load, ".", color=ROWS, markersize=4, label=f"{fit.rows_used} rows of the test")
        axes.plot(deformation, modelled, color=MODEL, linewidth=1.2, label="model")
        pad = fit.kind == "pad"
        axes.set_xlabel("approach, mm" if pad else "strain")
        axes.set_ylabel("force, N" if pad else "stress, MPa")
        axes.grid(color="#ddd", linewidth=0.6)
        axes.legend(fontsize=8)
        axes.set_title(f"Young's modulus {fit.young_modulus}")
    return figure
