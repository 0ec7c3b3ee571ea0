"""The one file that names matplotlib: figures drawn by Agg in matplotlib's own defaults.

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

from matplotlib import colormaps, rc_context, rcParamsDefault  # noqa: E402
from matplotlib.axes import Axes  # noqa: E402
from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: E402
from matplotlib.cm import ScalarMappable  # noqa: E402
from matplotlib.collections import PolyCollection  # noqa: E402
from matplotlib.colors import ListedColormap, Normalize, to_rgb  # noqa: E402
from matplotlib.figure import Figure  # noqa: E402
from matplotlib.patches import Patch  # noqa: E402
from matplotlib.ticker import NullFormatter  # noqa: E402
from matplotlib.tri import Triangulation  # noqa: E402

__all__ = [
    "Axes",
    "Figure",
    "ListedColormap",
    "Normalize",
    "NullFormatter",
    "Patch",
    "Picture",
    "PolyCollection",
    "ScalarMappable",
    "Triangulation",
    "agg",
    "colormaps",
    "own_style",
    "save",
    "sheet",
    "to_rgb",
]
DEFAULTS: dict[Any, Any] = {key: value for key, value in rcParamsDefault.items() if key != "backend"}
_ONE_AT_A_TIME = RLock()  # matplotlib's settings are the process's, and so restored by one thread at a time


@contextmanager
def own_style() -> Iterator[None]:
    """Draw the block in matplotlib's defaults; then its settings are again what they were."""
    with _ONE_AT_A_TIME, rc_context(DEFAULTS):
        yield


class Picture(Figure):
    """A figure that is written in so many `colours` at most; None: in all that it has."""

    colours: int | None = None


def agg(size: tuple[float, float], dpi: float) -> Picture:
    """Return a figure of this size, inches, that Agg draws; to be used within `own_style`."""
    figure = Picture(figsize=size, dpi=dpi, layout="constrained")
    FigureCanvasAgg(figure)
    return figure


@contextmanager
def sheet(size: tuple[float, float], dpi: float, colours: int | None = None) -> Iterator[Picture]:
    """Yield a figure of this size, inches, to be drawn on in the block, in matplotlib's defaults."""
    with own_style():
        figure = agg(size, dpi)
        figure.colours = colours
        yield figure


def save(figure: Picture, path: Path) -> None:
    """Write a figure as PNG, in as many colours as it asks for."""
    drawn = BytesIO()
    with own_style():
        figure.savefig(drawn, metadata={"Software": "skincad"}, format="png")
    if figure.colours is None:
        path.write_bytes(drawn.getvalue())
        return
    few = Image.open(drawn).convert("RGB")
    few = few.quantize(figure.colours, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
    few.save(path, format="PNG", optimize=True)
