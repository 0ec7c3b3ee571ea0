"""Crest heights of the cast part: their limits, and what comes out of a printer's layers.

Limits of a part's crests by their process, and whether parts within these limits pass the verdict. Crests are
judged beside the line through all of them, which neither a shifted nor a tilted gauge moves; the line's rise
and its height have limits of their own. The mold's ledge, on which the back is cast, is taken for as far off
as a groove, on each side by itself: the same machine along the same axis (assumption).

How high a printed mold's crests come out: each height is a whole number of layers. Slicers ask the middle of
each layer what is inside, and close gaps that are as narrow as SLICE_CLOSING there. So a groove ends at the
layer whose middle is the first to find it wider, by the print mesh's own chords.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from statistics import NormalDist
from typing import NamedTuple

import numpy as np

from skincad.base.arrays import Array
from skincad.fabrication.job import Job
from skincad.fabrication.meshes import print_chord
from skincad.fabrication.papers import paper
from skincad.inputs.design import height_keys, with_heights
from skincad.inputs.process import Process
from skincad.mechanics.models.table import MODELS, unsupported_reason
from skincad.shape.crests import crest_column, crest_places
from skincad.shape.curves import polygon
from skincad.shape.skin import summit
from skincad.solids.pins import hole_block
from skincad.solids.plan import PartRole, Prism, TurnedBody, corners
from skincad.solids.shrinkage import scaled_for_shrinkage

# assumption: of good parts, by all rows together; the rest of 1 % is for what is not normal
REJECTED_SHARE = 0.005
THICKNESS_FAULT = 0.1  # mm, asked: of a part that is so much too thick, or too thin, the thickness is to fail
OTHER_ROWS = 6  # tilt, mean crest, width, length, pitch, mass
GAUGE_SIGMA = 0.002  # mm, assumption: standard deviation of a measuring microscope's or projector's height
READINGS = 4  # of each crest, where single parts are judged: so that GAUGE_SIGMA counts half
READINGS_NEAR_EDGE = 64  # of each crest in all, near the verdict's edge: so that GAUGE_SIGMA counts an eighth
# standard deviations of what READINGS leave of GAUGE_SIGMA: beyond, one verdict in 160 is the gauge's
EDGE_DEVIATIONS = 2.5
SHRINKAGE_SCATTER = 0.002  # relative, assumption: standard deviation of shrinkage from batch to batch
LEVEL_BAND = 0.002  # mm, assumption: what meshes and slicers round of a level, or of a narrow groove's width
MOST_LISTED = 64  # features that a sheet lists one by one; assumption: nobody reads more
NEGLIGIBLE_CHANGE = 1e-3  # mm, and layers: nobody sees so little
SLICE_CLOSING = 0.098  # mm, source: PrusaSlicer's default slice closing radius is 0.049


class Crests(NamedTuple):
    """What crests of good parts do, mm: their heights above the back as they come out `(ridges,)`, each one's
    limit beside their line `(ridges,)`, both ways (empty for two ridges or one), the line's rise from first
    to last, its height in the middle, and that against the mold's own; how many standard deviations all these
    limits are."""

    heights: tuple[float, ...]
    beside: tuple[float, ...]
    rise: float
    mean: float
    beside_mold: float
    deviations: float
    sigma: float  # mm, of one crest, ridge against ridge
    layers_known: bool  # whether layers, if there are any, are known where they fall


def crest_limits(job: Job) -> Crests:
    """Return the limits of a cast skin's crests."""
    process, printed = job.cavity_process, printed_crests(job)
    step, offset = 0.0 if printed else unknown_step(process), offset_of(job)
    heights = tuple(high + offset for high in printed or drawn_crests(job))
    count = len(heights)
    sigma = math.hypot(process.crest_sigma, step / math.sqrt(12))  # a step falls anywhere
    deviations = NormalDist().inv_cdf(1 - REJECTED_SHARE / 2 / (count + OTHER_ROWS))
    read = math.hypot(sigma, GAUGE_SIGMA)
    places = [i - (count - 1) / 2 for i in range(count)]
    squares = math.fsum(place**2 for place in places)
    beside = [math.sqrt(1 - 1 / count - place**2 / squares) for place in places] if count > 2 else []
    rise = math.hypot(read * (count - 1) / math.sqrt(squares or 1.0), sigma * math.sqrt(2) * _span(job))
    batch = SHRINKAGE_SCATTER * math.fsum(heights) / count
    deviation_parts = read / math.sqrt(count), sigma / math.sqrt(2), GAUGE_SIGMA, batch
    gauges = GAUGE_SIGMA * math.sqrt(2 + 2 / count)  # part and mold: each one's datum and crests
    return Crests(
        heights=heights,
        beside=tuple(deviations * read * share for share in beside),
        rise=deviations * rise,
        mean=deviations * math.hypot(*deviation_parts),
        beside_mold=deviations * math.hypot(gauges, batch),
        deviations=deviations,
        sigma=sigma,
        layers_known=printed is not None,
    )


def drawn_crests(job: Job) -> tuple[float, ...]:
    """Return each crest's height over the flat back as drawn, mm; of a face those of its places."""
    return tuple(high for _, _, high in crest_places(job.skin))


def offset_of(job: Job) -> float:
    """Return by how much all crests of the cured skin come out higher over its back, mm."""
    return job.cavity_process.crest_offset * (1 - job.shrinkage)


def _span(job: Job) -> float:
    """Return how far it is from the first crest to the last, by the distance of the ledge's two sides."""
    skin = job.skin
    return (skin.count - 1) * skin.pitch / job.design.skin.width


def remarks(job: Job, crests: Crests, allowed_drops: tuple[float, ...], margin: float) -> list[str]:
    """Return what is said of the limits: what layers do to the crests, how to check a thickness whose fault
    the process's own errors hide, whether parts within the limits pass the verdict, and what judges them.

    `allowed_drops` `(ridges,)` mm is by how much each crest may lie lower alone until the verdict's `margin`,
    N, is used up, empty where there is none. The words are templates/papers/crest-remarks.md.
    """
    drawn = tuple(high + offset_of(job) for high in drawn_crests(job))
    off = [out - high for out, high in zip(crests.heights, drawn, strict=True)]
    middle = math.fsum(off) / len(off)
    text = paper(
        "crest-remarks.md",
        job=job,
        crests=crests,
        as_drawn=crests.heights == drawn,
        middle=middle,
        largest=max(abs(value - middle) for value in off),
        step=unknown_step(job.cavity_process),
        fault=THICKNESS_FAULT,
        tightest=_tightest(job, crests, allowed_drops) if allowed_drops else None,
        undecided=undecided_margin(margin, allowed_drops),
        readings=READINGS,
        near_edge=READINGS_NEAR_EDGE,
        uncertain_ridges=uncertain_ridges,
        listed_crests=listed_crests,
        column=crest_column(job.skin),
        measurable=len(drawn) > 1 and any(not unsupported_reason(name, job.design, True) for name in MODELS),
        snapping_remarks=snapping_remarks,
    )
    return text.splitlines()


def undecided_margin(margin: float, allowed_drops: tuple[float, ...]) -> float:
    """Return the margin, N, within which the gauge's error alone may decide a measured part's verdict.

    It is `EDGE_DEVIATIONS` standard deviations of the margin by `READINGS` of each crest. `margin` N is the
    design's; a crest that lies lower by its entry of `allowed_drops` uses it up.
    """
    slopes = (margin / drop for drop in allowed_drops if drop)
    return EDGE_DEVIATIONS * GAUGE_SIGMA / math.sqrt(READINGS) * math.hypot(*slopes)


def limits_decide(job: Job, allowed_drops: tuple[float, ...]) -> bool:
    """Return whether parts within the limits pass the verdict; also where there is none, or one feature."""
    if job.skin.count == 1 or not allowed_drops:
        return True
    _, room, scatter = _tightest(job, crest_limits(job), allowed_drops)
    return scatter < room


def _tightest(job: Job, crests: Crests, allowed_drops: tuple[float, ...]) -> tuple[int, float, float]:
    """The crest that counts most, from 0, what the verdict allows it and what the process takes, mm."""
    drops = [meant - out for meant, out in zip(job.skin.crests, crests.heights, strict=True)]
    which = min(range(len(drops)), key=lambda i: allowed_drops[i] - drops[i])
    room = allowed_drops[which] - (drops[which] - min(drops))
    # a crest counts against a mean of the others, at most against one of them; the ledge's sides are two more
    share = math.sqrt(2 + 2 * _span(job) ** 2)
    return which, room, crests.deviations * crests.sigma * share


class _Block(NamedTuple):
    """A printed cavity in its section's plane, mm: its foot and top, a layer's height, how much larger than
    the skin it is, and of each groove its place across, its bottom's height, how far a layer's middle may be
    from that for all that one knows, and an outline `(n, 2)` that has it."""

    foot: float
    top: float
    layer: float
    grown: float
    grooves: tuple[tuple[float, float, float, Array], ...]


def printed_crests(job: Job) -> tuple[float, ...] | None:
    """Return each crest's height over the flat back of the cured skin, mm, ridge 1 first, as its mold comes
    out: the designed ones without layers.

    All layers are equal, the first too; on end they follow the section, unless a screen's pixels draw it.
    None where steps fall anywhere: those pixels, and the layers of a cavity that is parted, or a bowl; and
    where layers are so high that none has its middle in a groove or in what is over it.
    """
    process = job.cavity_process
    if not process.layer or (process.orientation == "end" and process.tool != "screen"):
        return drawn_crests(job)
    block = _block(job)
    return block and _heights(block)


def listed_crests(which: Sequence[int]) -> str:
    """Return crests by number, of very many the first."""
    shown = which if len(which) <= MOST_LISTED else which[:6]
    return ", ".join(map(str, shown)) + (f" and {len(which) - 6} more" if shown is not which else "")


def uncertain_ridges(job: Job) -> tuple[int, ...]:
    """Return which ridges, from 1 on, may come out a layer higher or lower than `printed_crests` says.

    A layer's middle is then within `LEVEL_BAND` of the groove's bottom, or, where the groove leans, of its
    depth within a pixel beside the axis. If it is that near to the ledge, all ridges may.
    """
    block, crests = _block(job), printed_crests(job)
    if block is None or crests is None:
        return ()
    ridges = set()
    for signs in ((-1, 0), (1, 0), (0, -1), (0, 1)):  # each by itself
        moved = _heights(block, *signs) or [math.inf] * len(crests)
        ridges |= {i for i, (a, b) in enumerate(zip(crests, moved, strict=True), 1) if not math.isclose(a, b)}
    return tuple(sorted(ridges))


def snapped_to_layers(job: Job) -> tuple[tuple[float, ...], float] | None:
    """Return the heights of the ridges, mm, and the mold's floor with which each groove's bottom, and the
    ledge, is where a layer ends: the nearest to the design's. None where crests come out as designed, or
    nobody knows how.

    Rounded to what a TOML shows, which moves a crest by less than a micrometre.
    """
    skin = job.skin
    block, crests = _block(job), printed_crests(job)
    if block is None or crests is None or skin.count > MOST_LISTED or skin.bare:
        return None
    off = max(abs(out - high) for out, high in zip(crests, skin.crests, strict=True))
    heights = []
    for ridge, high in enumerate(skin.crests, 1):
        foot, one = (skin.placed[ridge - 1].frame.at(0.0, h).z for h in (0.0, 1.0))
        crest = block.layer * round(high * block.grown / block.layer) / block.grown
        heights.append(round((crest - foot) / (one - foot), 4))
    if min(heights) <= 0 or (off < NEGLIGIBLE_CHANGE and not uncertain_ridges(job)):
        return None
    cast = scaled_for_shrinkage(with_heights(job.design, heights))
    top = summit(cast)
    least = -block.foot - summit(job.cast)
    return tuple(heights), round(
        block.layer * math.ceil((top + least) / block.layer - NEGLIGIBLE_CHANGE) - top, 4
    )


def snapping_remarks(job: Job) -> tuple[str, ...]:
    """Return with which keys each crest is at a layer's end."""
    if (snapped := snapped_to_layers(job)) is None:
        return ()
    heights, floor = snapped
    keys = " and ".join(height_keys(job.design))
    return (
        f"With `mold.floor = {floor:g}` and `{job.skin.family}.heights = {list(heights)}`"
        f"{f' in the place of {keys}' if keys else ''} each crest is at a layer's end: then section, check "
        "and mold are of what comes out.",
    )


def _block(job: Job) -> _Block | None:
    """Return the block that a printed cavity is, flat on the bed; None where steps fall anywhere."""
    process = job.cavity_process
    blocks, skin = job.closed.of(PartRole.CAVITY), job.closed.first(PartRole.SKIN).body
    body = blocks[0].body if len(blocks) == 1 else None
    if isinstance(skin, TurnedBody) and body is not None and blocks[0].straight:
        body = blocks[0].straight.body
    flat = process.layer and process.orientation != "end"
    if not (flat and isinstance(body, Prism) and isinstance(skin, Prism | TurnedBody)) or body.grid:
        return None
    grown = 1 / (1 - job.shrinkage)
    outline = corners(body, body.outline, print_chord(job.design))
    sides = [segment.start.x for segment in skin.outline]  # of the first skin of a gang
    middle = (min(sides) + max(sides)) / 2 if isinstance(skin, Prism) else 0.0
    pixel = process.pixel if process.tool == "screen" else 0.0
    leans = *job.skin.leans, 0.0, 0.0  # of a face at its places
    grooves = tuple(
        (
            (0.0 if job.holes else middle) + x * grown,
            -high * grown,
            LEVEL_BAND + pixel * abs(math.tan(leans[i])),
            polygon(hole_block(job.skin.placed[i]), print_chord(job.design)) * grown
            if job.holes
            else outline,
        )
        for i, (x, _, high) in enumerate(crest_places(job.skin))
    )
    foot, top = float(outline[:, 1].min()), float(outline[:, 1].max())
    return _Block(foot, top, process.layer, grown, grooves)


def _heights(block: _Block, at_ledge: int = 0, in_grooves: int = 0) -> tuple[float, ...] | None:
    """Return the crests' heights, mm, by the layers' middles, where these are off by as much as may be, so
    signed; None where no layer is over a groove."""
    layer = block.layer
    ledge = layer * math.ceil(-(block.foot + at_ledge * LEVEL_BAND) / layer - 0.5)
    heights = []
    for x, depth, band, outline in block.grooves:
        foot = block.foot + in_grooves * band
        layers = math.ceil((depth - foot) / layer - 0.5)
        while _open(outline, x, foot + (layers + 0.5) * layer) <= SLICE_CLOSING:
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
