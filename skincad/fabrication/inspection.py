"""What to measure on the cast skin, and within which limits it is the one that was checked."""

from __future__ import annotations

import math
from dataclasses import dataclass

from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.inputs.process import processes
from skincad.shape.crests import summits
from skincad.solids.plan import Part

SHARE_OF_WALL = 3.0  # standard deviations: what the process itself lets a crest differ by
CALLIPERS = 0.03  # mm, assumption: how well a soft part is measured across
SCATTER = 0.002  # relative, assumption: what shrinkage differs by from batch to batch
DENSITY = 0.01  # relative, assumption: a data sheet's density of a cured silicone
LEAST_BUBBLE = 0.02  # of the skin's mass, assumption: less can't be told from flash that was left on


@dataclass(frozen=True)
class Measure:
    """A quantity of the cast part: nominal, limits and unit; `how` says with what."""

    what: str
    nominal: float
    low: float
    high: float
    unit: str
    how: str


def inspection(design: Design, skin: Part, allowed_drops: tuple[float, ...] = ()) -> tuple[Measure, ...]:
    """Return the inspection list of a cast `skin`, its film strips drawn or not yet in.

    `allowed_drops` `(ridges,)` mm is how much lower each crest may lie alone until the verdict's margin is
    used up (inf where lowering it does no harm); the process's own three standard deviations otherwise.
    """
    limits = processes(design.printer)
    body = limits[design.mold.process]
    end = limits[design.mold.end_plate_process or design.mold.process]
    wide = 2 * body.tolerance + CALLIPERS
    rows = [
        _symmetric("width across the back", design.skin.width, wide, "callipers, lightly"),
        _symmetric(*_length(design), wide + 2 * end.tolerance, "callipers, lightly"),
        _symmetric("pitch of the ridges", design.ridge.pitch, wide, "microscope, mean of all"),
    ]
    own = SHARE_OF_WALL * body.crest_sigma
    back = "flat back" if design.skin.curvature_radius_y is None else "back, in the middle of its length"
    crests = summits(design)
    for ridge in range(1, design.ridge.count + 1):
        height = crests[ridge - 1]
        allowed = allowed_drops[ridge - 1] if allowed_drops else own
        drop = min(own, allowed)
        rows.append(
            Measure(
                f"crest of ridge {ridge} over the {back}",
                height,
                height - drop,
                height + own,
                "mm",
                "height gauge or profile projector, without force",
            )
        )
    return (*rows, _mass(design, skin))


def _length(design: Design) -> tuple[str, float]:
    """What is measured of the length, and its value: with a second curvature a chord."""
    radius, skin = design.skin.curvature_radius_y, design.skin
    if radius is None:
        return "length along the ridges", skin.length
    return "length of the back, straight from end to end", 2 * (radius - skin.thickness) * math.sin(
        skin.length / 2 / radius
    )


def _symmetric(what: str, nominal: float, tolerance: float, how: str) -> Measure:
    spread = tolerance + SCATTER * nominal
    return Measure(what, nominal, nominal - spread, nominal + spread, "mm", how)


def _mass(design: Design, skin: Part) -> Measure:
    """Mass of the bare skin: too light means a bubble or a short shot, too heavy means flash."""
    volume = skin.volume
    grams = volume * silicone(design).density * 1e-6
    tolerance = processes(design.printer)[design.mold.process].tolerance
    surface = 2 * design.skin.width * design.skin.length
    spread = grams * (DENSITY + LEAST_BUBBLE + tolerance * surface / volume)
    how = "balance; the trimmed skin without rivets, or less what the carrier weighed"
    return Measure("mass of the skin alone", grams, grams - spread, grams + spread, "g", how)


def inspection_lines(measures: tuple[Measure, ...]) -> list[str]:
    """Return the list as Markdown."""
    rows = [
        f"| {m.what} | {m.nominal:.3f} | {m.low:.3f} to {m.high:.3f} | {m.unit} | {m.how} |" for m in measures
    ]
    return [
        "## Inspection",
        "",
        "Measure the cured skin on its carrier, a day after it was cast:",
        "",
        "| what | as designed | limits | unit | with |",
        "|---|---|---|---|---|",
        *rows,
        "",
        "`skincad check design.toml --measured crests.csv` judges all crest heights together, from a CSV "
        "with columns `ridge,crest_mm`: its verdict counts, not each crest alone.",
        "",
    ]
