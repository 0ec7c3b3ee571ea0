"""How high a printed mold's crests come out: each height is a whole number of layers.

Slicers ask the middle of each layer what is inside, and close gaps that are as narrow as CLOSED there. So a
groove ends at the layer whose middle is the first to find it wider, by the print mesh's own chords.
"""

from __future__ import annotations

import math

import numpy as np

from skincad.base.arrays import Array
from skincad.fabrication.meshes import print_chord
from skincad.inputs.design import Design
from skincad.inputs.process import Process, processes
from skincad.shape.crests import summits
from skincad.shape.cross_section import frame
from skincad.solids.body import Prism, corners
from skincad.solids.mold import ClosedMold
from skincad.solids.roles import PartRole
from skincad.solids.shrinkage import shrinkage

CLOSED = 0.098  # mm, source: PrusaSlicer's default slice closing radius is 0.049


def come_out(design: Design, closed: ClosedMold) -> tuple[float, ...] | None:
    """Return each crest's height over the flat back of the cured skin, mm, ridge 1 first, as its mold comes
    out: the designed ones without layers.

    All layers are equal, the first too; on end they follow the section, unless a screen's pixels draw it.
    None where steps fall anywhere: those pixels, and the layers of a cavity that is parted, or a bowl; and
    where layers are so high that none has its middle in a groove or in what is over it.
    """
    process = processes(design.printer)[design.mold.process]
    on_its_end = process.orientation == "end"
    if not process.layer or (on_its_end and process.tool != "screen"):
        return summits(design)
    blocks, skin = closed.of(PartRole.CAVITY), closed.first(PartRole.SKIN).body
    body = blocks[0].body if len(blocks) == 1 else None
    if not (isinstance(body, Prism) and isinstance(skin, Prism)) or body.grid or on_its_end:
        return None
    grown = 1 / (1 - shrinkage(design))
    outline = corners(body, body.outline, print_chord(design))
    sides = [each.start.x for each in skin.outline]  # of the first skin of a gang
    middle = (min(sides) + max(sides)) / 2
    bottom, top = float(outline[:, 1].min()), float(outline[:, 1].max())
    ledge = process.layer * math.ceil(-bottom / process.layer - 0.5)
    heights = []
    for ridge, high in enumerate(summits(design), 1):
        across = middle + frame(design, ridge).at(0.0, design.heights[ridge - 1]).x * grown
        layers = math.ceil((-high * grown - bottom) / process.layer - 0.5)
        while _open(outline, across, bottom + (layers + 0.5) * process.layer) <= CLOSED:
            layers += 1
            if bottom + (layers + 0.5) * process.layer > top:
                return None
        heights.append((ledge - layers * process.layer) / grown)
    return tuple(heights)


def _open(outline: Array, x: float, level: float) -> float:
    """Width of the groove round (x, level) mm; 0 in the block, whose outline is `(n, 2)` mm."""
    ends = np.roll(outline, -1, axis=0)
    crossed = (outline[:, 1] < level) != (ends[:, 1] < level)
    a, b = outline[crossed], ends[crossed]
    at = a[:, 0] + (level - a[:, 1]) / (b[:, 1] - a[:, 1]) * (b[:, 0] - a[:, 0])
    left, right = at[at <= x], at[at > x]
    return float(right.min() - left.max()) if left.size % 2 == 0 and left.size else 0.0


def unknown_step(process: Process) -> float:
    """Return by how much a crest may jump where steps fall anywhere, mm: a pixel on end, else a layer."""
    return process.pixel if process.orientation == "end" else process.layer
