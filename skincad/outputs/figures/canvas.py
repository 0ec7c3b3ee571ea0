"""The one file that names matplotlib: figures in one style, drawn by Agg.

What the process has set for its own pictures (backend, MPLBACKEND, a matplotlibrc, rcParams) neither changes
ours nor is changed by them.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from io import BytesIO
from pathlib import Path
from threading import RLock
from typing import Any

from PIL import Image

from skincad.base.errors import InputError


def _load() -> None:
    """Import matplotlib, whatever MPLBACKEND says: matplotlib refuses to be imported where it names a
    backend that is not installed. One that is there stays the process's, as by an import of its own.
    """
    if "matplotlib" in sys.modules:
        return
    wanted = os.environ.pop("MPLBACKEND", "")
    try:
        import matplotlib
    except UnicodeDecodeError as failure:
        rule = f"matplotlib cannot read it ({failure.reason})"
        raise InputError("matplotlibrc", rule, remedy="rename it, or save it as UTF-8") from None
    finally:
        if wanted:
            os.environ["MPLBACKEND"] = wanted
    if wanted:
        with suppress(ValueError):
            matplotlib.rcParams["backend"] = wanted


_load()

from cycler import cycler  # noqa: E402
from matplotlib import colormaps, rc_context, rcParamsDefault  # noqa: E402
from matplotlib.axes import Axes  # noqa: E402
from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: E402
from matplotlib.cm import ScalarMappable  # noqa: E402
from matplotlib.collections import EllipseCollection, PathCollection, PolyCollection  # noqa: E402
from matplotlib.colors import ListedColormap, Normalize, to_rgb  # noqa: E402
from matplotlib.figure import Figure  # noqa: E402
from matplotlib.lines import Line2D  # noqa: E402
from matplotlib.patches import Patch  # noqa: E402
from matplotlib.path import Path as Curve  # noqa: E402
from matplotlib.ticker import FixedLocator, LogLocator, MaxNLocator, NullFormatter, NullLocator  # noqa: E402
from matplotlib.transforms import Affine2D  # noqa: E402
from matplotlib.tri import Triangulation  # noqa: E402

__all__ = [  # of matplotlib, for the figures
    "Affine2D", "Axes", "Curve", "EllipseCollection", "Figure", "FixedLocator", "Line2D",
    "ListedColormap", "LogLocator", "MaxNLocator", "Normalize", "NullFormatter", "NullLocator", "Patch",
    "PathCollection", "PolyCollection", "ScalarMappable", "Triangulation", "colormaps", "to_rgb",
]  # fmt: skip
# Distinct for colour-blind people: Okabe and Ito, Color Universal Design, 2008; vermilion a little darker,
# for thin lines on white
BLUE, VERMILION, GREEN, ORANGE, SKY, PURPLE, BLACK = (
    "#0072b2",
    "#c24e00",
    "#009e73",
    "#e69f00",
    "#56b4e9",
    "#cc79a7",
    "#222222",
)
DPI = 100
GREY, PALE, GRID, FRAME = "#777777", "#c4c4c4", "#e0e0e0", "#555555"
SKIN, STRIP, OUTLINE = "#eebfa6", "#b5482a", "#333333"  # of a drawn section: silicone, film strip, its edge
FILM, PLATE, AROUND = "#111111", "#9a9a9a", "#d7e3d0"  # of a stressed section; a tint that no stress has
OPEN, STICK = "#ffffff", "#b9cbe0"  # of a ridge that is clear of the plate, and of one that sticks
PHASE_A, PHASE_B = "#e3ecf7", "#f9e4d8"  # of a pull: before the ridge slips, and after
FRONT, FLOOR = "#c9c9c9", "#ededed"  # behind curves: the best ones, and errors below the reference's own
STYLES: tuple[tuple[str, str, Any], ...] = (  # colour, marker, dashes; they differ without colour too
    ("#000000", "o", "-"),
    ("#0072b2", "s", (0, (6, 2))),
    ("#b3470a", "^", (0, (2, 1.5))),
    ("#007a5a", "D", (0, (7, 2, 1.5, 2))),
    ("#8f4c86", "v", (0, (1, 1.5))),
    ("#6f6000", "P", (0, (10, 3))),
    ("#4c7ea6", "X", (0, (4, 1.5, 1, 1.5, 1, 1.5))),
)
NOTE, SMALL, LABEL, TITLE, HEAD = 7.0, 8.0, 9.0, 10.0, 11.0  # points: every letter has one of these sizes
THIN, CURVE = 0.8, 1.3  # points, of lines that help, and of curves
MAP, SIGNED_MAP = "viridis_r", "RdBu_r"  # of what has no sign, distinct in grey too; and of what has one
STYLE: dict[str, Any] = {  # of every figure, on matplotlib's defaults
    "axes.axisbelow": True,
    "axes.edgecolor": FRAME,
    "axes.grid": True,
    "axes.labelsize": LABEL,
    "axes.prop_cycle": cycler(color=[BLUE, VERMILION, GREEN, ORANGE, PURPLE, SKY, BLACK]),
    "axes.titlesize": TITLE,
    "figure.titlesize": HEAD,
    "font.family": "DejaVu Sans",  # matplotlib's own: the same on every machine
    "font.size": TITLE,
    "grid.color": GRID,
    "grid.linewidth": 0.6,
    "legend.fontsize": SMALL,
    "lines.linewidth": CURVE,
    "xtick.labelsize": SMALL,
    "ytick.labelsize": SMALL,
}
DEFAULTS: dict[Any, Any] = {
    **{key: value for key, value in rcParamsDefault.items() if key != "backend"},
    **STYLE,
}
_ONE_AT_A_TIME = RLock()  # matplotlib's settings are the process's, and so restored by one thread at a time


@contextmanager
def own_style() -> Iterator[None]:
    """Draw the block in our style; then its settings are again what they were."""
    with _ONE_AT_A_TIME, rc_context(DEFAULTS):
        yield


class Picture(Figure):
    """A figure that is written in so many `colours` at most; None: in all that it has."""

    colours: int | None = None


def agg(size: tuple[float, float], dpi: float = DPI) -> Picture:
    """Return a figure of this size, inches, that Agg draws; to be used within `own_style`."""
    figure = Picture(figsize=size, dpi=dpi, layout="constrained")
    FigureCanvasAgg(figure)
    return figure


@contextmanager
def sheet(size: tuple[float, float], colours: int | None = None, *, dpi: float = DPI) -> Iterator[Picture]:
    """Yield a figure of this size, inches, to be drawn on in the block."""
    with own_style():
        figure = agg(size, dpi)
        figure.colours = colours
        yield figure


def legend(axes: Axes, columns: int = 3, **more: Any) -> None:
    """Name what is drawn above the axes, where no curve is; `more` is matplotlib's own."""
    place = {"loc": "lower left", "bbox_to_anchor": (0.0, 1.0), "borderaxespad": 0.2, "frameon": False}
    axes.legend(**{**place, "ncols": columns, "columnspacing": 1.6, **more})


@contextmanager
def chart(
    size: tuple[float, float], title: str, columns: int = 3, **labels: str
) -> Iterator[tuple[Picture, Axes]]:
    """Yield a figure of this size, inches, and its only axes, to be drawn on in the block; then they get
    their `labels` and the legend."""
    with sheet(size, 255) as figure:
        figure.suptitle(title)
        axes = figure.add_subplot()
        yield figure, axes
        axes.set(**labels)
        legend(axes, columns)


def save(figure: Picture, path: Path) -> None:
    """Write a figure as PNG, in as many colours as it asks for."""
    path.write_bytes(png(figure))


def png(figure: Picture) -> bytes:
    """Return a figure as PNG, in as many colours as it asks for."""
    drawn, written = BytesIO(), BytesIO()
    with own_style():
        figure.savefig(drawn, metadata={"Software": "skincad"}, format="png")
    if figure.colours is None:
        return drawn.getvalue()
    few = Image.open(drawn).convert("RGB")
    # two rounds of k-means: else a large shaded face takes the colour of a letter's edge
    few = few.quantize(figure.colours, Image.Quantize.MAXCOVERAGE, kmeans=2, dither=Image.Dither.NONE)
    few.save(written, format="PNG", optimize=True)
    return written.getvalue()


def svg(figure: Picture) -> bytes:
    """Return a figure as SVG, the same bytes for the same figure; letters are paths, so no font is needed."""
    written = BytesIO()
    with own_style(), rc_context({"svg.hashsalt": "skincad"}):
        figure.savefig(written, metadata={"Date": None, "Creator": "skincad"}, format="svg")
    return written.getvalue()


def pdf(figure: Picture, title: str) -> bytes:
    """Return a figure as PDF, the same bytes for the same figure; letters are text in a font of every reader
    (ISO 32000-1, 9.6.2.2)."""
    written, said = BytesIO(), {"Title": title, "Creator": "skincad", "Producer": None, "CreationDate": None}
    with own_style(), rc_context({"pdf.use14corefonts": True, "path.simplify": False}):
        figure.savefig(written, metadata=said, format="pdf")
    return written.getvalue()
