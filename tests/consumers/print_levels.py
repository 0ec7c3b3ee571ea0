"""To which height PrusaSlicer's layers fill a part at given places: resin pictures, and G-code of filament.

A level face comes out at the top of the highest layer that has material there. Heights are read from the
files that a printer would take; what skincad says of layers is not used.
"""

from __future__ import annotations

import re
import zipfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import trimesh
from PIL import Image

from skincad.base import Array, Mask
from tests.consumers.prusaslicer import MARGIN, run

NOZZLE = 0.45  # mm, wide as a line is laid
REACH = 2.0  # mm to either side along y in which a line's cover is looked for: solid layers leave gaps


def resin_levels(path: Path, places: Array, layer: float, pixel: float, folder: Path) -> Array:
    """Return the heights `(n,)` mm over the bed at `places` `(n,)` mm along x from the part's middle."""
    levels = np.zeros(len(places))
    for number, lit in enumerate(resin_layers(path, layer, pixel, folder), 1):
        if number == 1:  # the block's whole foot: its middle is the part's
            rows, columns = np.flatnonzero(lit.any(axis=1)), np.flatnonzero(lit.any(axis=0))
            row, column = rows.mean(), columns.mean()
        at = np.rint(column + places / pixel).astype(int)
        beside = lit[round(row), at[:, None] + [-1, 0, 1]]  # no gauge sees a single pixel
        levels[beside.all(axis=1)] = number * layer
    return levels


def resin_layers(path: Path, layer: float, pixel: float, folder: Path) -> Iterator[Mask]:
    """Yield which pixels are lit, `(rows, columns)`, layer by layer from the bed up."""
    low, high = trimesh.load_mesh(path).bounds
    pixels = np.ceil((high[:2] - low[:2] + 2 * MARGIN) / pixel).astype(int)
    wide, deep = pixels * pixel
    settings = {
        "layer-height": layer,
        "initial-layer-height": layer,
        "elefant-foot-compensation": 0,
        "supports-enable": 0,
        "pad-enable": 0,
        "support-object-elevation": 0,
        "faded-layers": 0,
        "display-width": wide,
        "display-height": deep,
        "display-pixels-x": pixels[0],
        "display-pixels-y": pixels[1],
        "display-orientation": "landscape",
        "display-mirror-x": 0,
        "max-print-height": high[2] + 1,
        "bed-shape": f"0x0,{wide}x0,{wide}x{deep},0x{deep}",
    }
    archive = folder / "layers.sl1"
    run("--export-sla", str(path), "-o", str(archive), *(f"--{k}={v}" for k, v in settings.items()))
    with zipfile.ZipFile(archive) as layers:
        for name in sorted(n for n in layers.namelist() if n.endswith(".png") and "thumbnail" not in n):
            with layers.open(name) as picture:
                yield np.asarray(Image.open(picture).convert("L")) > 127


def filament_levels(path: Path, places: Array, layer: float, folder: Path) -> Array:
    """The same of G-code for a 0.4 mm nozzle."""
    code = folder / "part.gcode"
    settings = {
        "layer-height": layer,
        "first-layer-height": layer,
        "nozzle-diameter": 0.4,
        "extrusion-width": NOZZLE,
        "first-layer-extrusion-width": NOZZLE,
        "skirts": 0,
        "fill-density": "15%",
        "elefant-foot-compensation": 0,
        "bed-shape": "0x0,300x0,300x300,0x300",
    }
    run(
        "--export-gcode", str(path), "-o", str(code), *(f"--{key}={value}" for key, value in settings.items())
    )
    lines = _extruded(code.read_text())
    foot = lines[lines[:, 4] == lines[:, 4].min()]
    middle = (foot[:, :4].reshape(-1, 2).min(axis=0) + foot[:, :4].reshape(-1, 2).max(axis=0)) / 2
    levels = np.zeros(len(places))
    for i, place in enumerate(places):
        spots = middle + np.column_stack([np.full(9, place), np.linspace(-REACH, REACH, 9)])
        levels[i] = max(z for *ends, z in lines if _covers(np.array(ends), spots))
    return levels


def _covers(ends: Array, spots: Array) -> bool:
    """Whether a line from (x, y) to (x, y) mm covers one of the spots `(n, 2)` mm."""
    start, along = ends[:2], ends[2:] - ends[:2]
    share = np.clip((spots - start) @ along / max(float(along @ along), 1e-12), 0.0, 1.0)
    return bool((np.hypot(*(spots - start - share[:, None] * along).T) < NOZZLE / 2).any())


def _extruded(code: str) -> Array:
    """Lines that are laid: x, y of both ends and z, `(n, 5)` mm."""
    x = y = z = 0.0
    rows = []
    for line in code.splitlines():
        if not re.match(r"G[01] ", line):
            continue
        word = {key: float(value) for key, value in re.findall(r"([XYZE])(-?[\d.]+)", line.split(";")[0])}
        before, x, y, z = (x, y), word.get("X", x), word.get("Y", y), word.get("Z", z)
        if word.get("E", 0.0) > 0 and ("X" in word or "Y" in word):
            rows.append((*before, x, y, z))
    return np.array(rows)
