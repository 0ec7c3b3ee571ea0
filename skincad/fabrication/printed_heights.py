"""How high a printed mold's crests come out: each height is a whole number of layers.

Slicers ask the middle of each layer what is inside, and close gaps that are as narrow as CLOSED there. So a
groove ends at the layer whose middle is the first to find it wider, by the print mesh's own chords.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from skincad.base.arrays import Array
from skincad.fabrication.meshes import print_chord
from skincad.inputs.design import Design, height_keys, with_heights
from skincad.inputs.process import Process, processes
from skincad.shape.skin import section, skin_of
from skincad.solids.mold import ClosedMold
from skincad.solids.plan import PartRole, Prism, corners
from skincad.solids.shrinkage import scaled_for_shrinkage, shrinkage

LEVEL_BAND = 0.002  # mm, assumption: what meshes and slicers round of a level, or of a narrow groove's width
NEGLIGIBLE_CHANGE = 1e-3  # mm, and layers: nobody sees so little
SLICE_CLOSING = 0.098  # mm, source: PrusaSlicer's default slice closing radius is 0.049


class _Block(NamedTuple):
    """A printed cavity in its section's plane, mm: outline `(n, 2)`, its foot and top, a layer's height, how
    much larger than the skin it is, and of each groove its place across, its bottom's height, and how far a
    layer's middle may be from that for all that one knows."""

    outline: Array
    foot: float
    top: float
    layer: float
    grown: float
    grooves: tuple[tuple[float, float, float], ...]


def printed_crests(design: Design, closed: ClosedMold) -> tuple[float, ...] | None:
    """Return each crest's height over the flat back of the cured skin, mm, ridge 1 first, as its mold comes
    out: the designed ones without layers.

    All layers are equal, the first too; on end they follow the section, unless a screen's pixels draw it.
    None where steps fall anywhere: those pixels, and the layers of a cavity that is parted, or a bowl; and
    where layers are so high that none has its middle in a groove or in what is over it.
    """
    process = processes(design.printer)[design.mold.process]
    if not process.layer or (process.orientation == "end" and process.tool != "screen"):
        return skin_of(design).crests
    block = _block(design, closed)
    return block and _heights(block)


def uncertain_ridges(design: Design, closed: ClosedMold) -> tuple[int, ...]:
    """Return which ridges, from 1 on, may come out a layer higher or lower than `printed_crests` says.

    A layer's middle is then within `LEVEL_BAND` of the groove's bottom, or, where the groove leans, of its
    depth within a pixel beside the axis. If it is that near to the ledge, all ridges may.
    """
    block, crests = _block(design, closed), printed_crests(design, closed)
    if block is None or crests is None:
        return ()
    ridges = set()
    for signs in ((-1, 0), (1, 0), (0, -1), (0, 1)):  # each by itself
        moved = _heights(block, *signs) or [math.inf] * len(crests)
        ridges |= {i for i, (a, b) in enumerate(zip(crests, moved, strict=True), 1) if not math.isclose(a, b)}
    return tuple(sorted(ridges))


def snapped_to_layers(design: Design, closed: ClosedMold) -> tuple[tuple[float, ...], float] | None:
    """Return the heights of the ridges, mm, and the mold's floor with which each groove's bottom, and the
    ledge, is where a layer ends: the nearest to the design's. None where crests come out as designed, or
    nobody knows how.

    Rounded to what a TOML shows, which moves a crest by less than a micrometre.
    """
    skin = skin_of(design)
    block, crests = _block(design, closed), printed_crests(design, closed)
    if block is None or crests is None:
        return None
    off = max(abs(out - high) for out, high in zip(crests, skin.crests, strict=True))
    heights = []
    for ridge, high in enumerate(skin.crests, 1):
        foot, one = (skin.placed[ridge - 1].frame.at(0.0, h).z for h in (0.0, 1.0))
        crest = block.layer * round(high * block.grown / block.layer) / block.grown
        heights.append(round((crest - foot) / (one - foot), 4))
    if min(heights) <= 0 or (off < NEGLIGIBLE_CHANGE and not uncertain_ridges(design, closed)):
        return None
    cast = scaled_for_shrinkage(with_heights(design, heights))
    top = section(cast).top
    least = -block.foot - section(scaled_for_shrinkage(design)).top
    return tuple(heights), round(
        block.layer * math.ceil((top + least) / block.layer - NEGLIGIBLE_CHANGE) - top, 4
    )


def snapping_remarks(design: Design, closed: ClosedMold) -> tuple[str, ...]:
    """Return with which keys each crest is at a layer's end."""
    if (snapped := snapped_to_layers(design, closed)) is None:
        return ()
    heights, floor = snapped
    keys = " and ".join(height_keys(design))
    return (
        f"With `mold.floor = {floor:g}` and `ridge.heights = {list(heights)}`"
        f"{f' in the place of {keys}' if keys else ''} each crest is at a layer's end: then section, check "
        "and mold are of what comes out.",
    )


def _block(design: Design, closed: ClosedMold) -> _Block | None:
    """Return the block that a printed cavity is, flat on the bed; None where steps fall anywhere."""
    process = processes(design.printer)[design.mold.process]
    blocks, skin = closed.of(PartRole.CAVITY), closed.first(PartRole.SKIN).body
    body = blocks[0].body if len(blocks) == 1 else None
    flat = process.layer and process.orientation != "end"
    if not (flat and isinstance(body, Prism) and isinstance(skin, Prism)) or body.grid:
        return None
    grown = 1 / (1 - shrinkage(design))
    outline = corners(body, body.outline, print_chord(design))
    sides = [segment.start.x for segment in skin.outline]  # of the first skin of a gang
    middle = (min(sides) + max(sides)) / 2
    pixel = process.pixel if process.tool == "screen" else 0.0
    grooves = tuple(
        (
            middle
            + skin_of(design).placed[ridge - 1].frame.at(0.0, skin_of(design).heights[ridge - 1]).x * grown,
            -high * grown,
            LEVEL_BAND + pixel * abs(math.tan(skin_of(design).lean(ridge))),
        )
        for ridge, high in enumerate(skin_of(design).crests, 1)
    )
    foot, top = float(outline[:, 1].min()), float(outline[:, 1].max())
    return _Block(outline, foot, top, process.layer, grown, grooves)


def _heights(block: _Block, at_ledge: int = 0, in_grooves: int = 0) -> tuple[float, ...] | None:
    """Return the crests' heights, mm, by the layers' middles, where these are off by as much as may be, so
    signed; None where no layer is over a groove."""
    layer = block.layer
    ledge = layer * math.ceil(-(block.foot + at_ledge * LEVEL_BAND) / layer - 0.5)
    heights = []
    for x, depth, band in block.grooves:
        foot = block.foot + in_grooves * band
        layers = math.ceil((depth - foot) / layer - 0.5)
        while _open(block.outline, x, foot + (layers + 0.5) * layer) <= SLICE_CLOSING:
            layers += 1
            if foot + (layers + 0.5) * layer > block.top:
                return None
        heights.append((ledge - layers * layer) / block.grown)
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
