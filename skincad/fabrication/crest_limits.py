"""Limits of a part's crests by their process, and whether parts within these limits pass the verdict.

Crests are judged beside the line through all of them, which neither a shifted nor a tilted gauge moves; the
line's rise and its height have limits of their own. The mold's ledge, on which the back is cast, is taken
for as far off as a groove, on each side by itself: the same machine along the same axis (assumption).
"""

from __future__ import annotations

import math
from statistics import NormalDist
from typing import NamedTuple

from skincad.fabrication.printed_heights import (
    printed_crests,
    snapping_remarks,
    uncertain_ridges,
    unknown_step,
)
from skincad.inputs.design import Design
from skincad.inputs.process import processes
from skincad.shape.skin import skin_of
from skincad.solids.mold import ClosedMold
from skincad.solids.shrinkage import shrinkage

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


class Crests(NamedTuple):
    """What crests of good parts do, mm: their heights over the back as they come out `(ridges,)`, each one's
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


def crest_limits(design: Design, closed: ClosedMold) -> Crests:
    """Return the limits of a cast skin's crests."""
    skin = skin_of(design)
    process, count = processes(design.printer)[design.mold.process], skin.count
    printed = printed_crests(design, closed)
    step, offset = 0.0 if printed else unknown_step(process), offset_of(design)
    heights = tuple(high + offset for high in printed or skin.crests)
    sigma = math.hypot(process.crest_sigma, step / math.sqrt(12))  # a step falls anywhere
    deviations = NormalDist().inv_cdf(1 - REJECTED_SHARE / 2 / (count + OTHER_ROWS))
    read = math.hypot(sigma, GAUGE_SIGMA)
    places = [i - (count - 1) / 2 for i in range(count)]
    squares = math.fsum(place**2 for place in places)
    beside = [math.sqrt(1 - 1 / count - place**2 / squares) for place in places] if count > 2 else []
    rise = math.hypot(read * (count - 1) / math.sqrt(squares or 1.0), sigma * math.sqrt(2) * _span(design))
    batch = SHRINKAGE_SCATTER * math.fsum(heights) / count
    deviation_parts = read / math.sqrt(count), sigma / math.sqrt(2), GAUGE_SIGMA, batch
    gauges = GAUGE_SIGMA * math.sqrt(2 + 2 / count)  # part and mold: each one's datum and crests
    return Crests(
        heights,
        tuple(deviations * read * share for share in beside),
        deviations * rise,
        deviations * math.hypot(*deviation_parts),
        deviations * math.hypot(gauges, batch),
        deviations,
        sigma,
        printed is not None,
    )


def offset_of(design: Design) -> float:
    """Return by how much all crests of the cured skin come out higher over its back, mm."""
    return processes(design.printer)[design.mold.process].crest_offset * (1 - shrinkage(design))


def _span(design: Design) -> float:
    """Return how far it is from the first crest to the last, by the distance of the ledge's two sides."""
    skin = skin_of(design)
    return (skin.count - 1) * skin.pitch / design.skin.width


def layer_remarks(design: Design, closed: ClosedMold, crests: Crests) -> tuple[str, ...]:
    """Return what layers do to the crests."""
    process, meant_all = processes(design.printer)[design.mold.process], offset_of(design)
    meant = tuple(high + meant_all for high in skin_of(design).crests)
    if crests.heights == meant and crests.layers_known:
        return ()
    if not crests.layers_known:
        return (
            f"Where the steps of {design.mold.process} fall on the crests is not known: the "
            f"limits hold one of {unknown_step(process):g} mm.",
        )
    off = [out - high for out, high in zip(crests.heights, meant, strict=True)]
    middle = math.fsum(off) / len(off)
    largest = max(abs(value - middle) for value in off)
    return (
        f"Slice the cavity in layers of {process.layer:g} mm from the bed on, the first one too: then "
        f"crests come out as in the table, {middle:+.3f} mm from the design in the mean, and from there up "
        f"to {largest:.3f} mm up or down.",
        *_uncertain_remarks(design, closed),
        *snapping_remarks(design, closed),
    )


def _uncertain_remarks(design: Design, closed: ClosedMold) -> tuple[str, ...]:
    which, layer = uncertain_ridges(design, closed), processes(design.printer)[design.mold.process].layer
    if not which:
        return ()
    return (
        f"Crests {', '.join(map(str, which))} may come out a layer of {layer:g} mm lower or higher than "
        "that: a layer's middle is where their groove, or the ledge, ends.",
    )


def thickness_remarks(design: Design, crests: Crests) -> tuple[str, ...]:
    """Return how to check the thickness where the process's own errors hide a fault of it."""
    if crests.mean < THICKNESS_FAULT:
        return ()
    return (
        f"The mean crest's limit passes a part that is {THICKNESS_FAULT:g} mm too thick: "
        f"{design.mold.process} itself "
        f"takes {crests.mean / crests.deviations:.3f} mm in the standard deviation. Measure the mold once, "
        "each groove's bottom under the ledge, by the same gauge: a part's mean crest is within "
        f"±{crests.beside_mold:.3f} mm of theirs times {1 - shrinkage(design):.4g}.",
    )


def undecided_margin(margin: float, allowed_drops: tuple[float, ...]) -> float:
    """Return the margin, N, within which the gauge's error alone may decide a measured part's verdict.

    It is `EDGE_DEVIATIONS` standard deviations of the margin by `READINGS` of each crest. `margin` N is the
    design's; a crest that lies lower by its entry of `allowed_drops` uses it up.
    """
    slopes = (margin / drop for drop in allowed_drops if drop)
    return EDGE_DEVIATIONS * GAUGE_SIGMA / math.sqrt(READINGS) * math.hypot(*slopes)


def verdict_remark(design: Design, crests: Crests, allowed_drops: tuple[float, ...], margin: float) -> str:
    """Return whether parts within the limits pass the verdict. `allowed_drops` `(ridges,)` mm is by how much
    each crest may lie lower alone until the verdict's `margin`, N, is used up, empty where there is none."""
    skin = skin_of(design)
    if skin.count == 1:
        return "One ridge touches in any case: its height changes no verdict."
    if not allowed_drops:
        return (
            "The check leaves no margin or was not asked: the limits say what the process does, not whether "
            "all ridges touch."
        )
    drops = [meant - out for meant, out in zip(skin.crests, crests.heights, strict=True)]
    which = min(range(len(drops)), key=lambda i: allowed_drops[i] - drops[i])
    room = allowed_drops[which] - (drops[which] - min(drops))
    if math.isinf(room):
        return "No crest that lies lower does harm to the verdict."
    # a crest counts against a mean of the others, at most against one of them; the ledge's sides are two more
    share = math.sqrt(2 + 2 * _span(design) ** 2)
    scatter = crests.deviations * crests.sigma * share
    one = f"crest {which + 1}, which counts most, {max(room, 0.0):.3f} mm against the others"
    if scatter < room:
        return (
            f"The verdict allows {one}, and {design.mold.process} takes {scatter:.3f} mm at most: parts "
            "within "
            "these limits pass it."
        )
    return (
        f"**These limits don't decide.** The verdict allows {one}, and {design.mold.process} alone may take "
        f"{scatter:.3f} mm: no limit on single crests keeps out the parts that fail and lets the good ones "
        f"pass. Judge each part by `--measured`, each crest the mean of {READINGS} readings; where its "
        f"margin is within ±{undecided_margin(margin, allowed_drops):.2g} N, read on until each crest is "
        "the mean of "
        f"{READINGS_NEAR_EDGE}: "
        "that verdict counts. Or take a finer process or more margin (`ridge.levelling`)."
    )
