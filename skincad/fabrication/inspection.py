"""What to measure of a cast part, and the form for it.

Limits hold what good parts of the process do: all rows together reject ODDS of them. What they mean for the
verdict is said beside them (crests.py).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np

from skincad.fabrication.crests import (
    GAUGE_SIGMA,
    MOST_LISTED,
    SHRINKAGE_SCATTER,
    Crests,
    crest_limits,
    offset_of,
    remarks,
)
from skincad.fabrication.job import Job
from skincad.fabrication.papers import paper
from skincad.fabrication.patterns import strip_patterns
from skincad.fabrication.pouring import pours
from skincad.fabrication.rules import walls_close
from skincad.fabrication.strips import PVDF_DENSITY
from skincad.shape.crests import crest_column, crest_places
from skincad.shape.curves import area, length, polygon, right_half
from skincad.shape.skin import Skin
from skincad.solids.plan import Bore, CutRole, PartRole, bores

MICROSCOPE = 0.005  # mm, assumption: standard deviation of a crest's place along x
CALLIPERS = 0.01  # mm, assumption: standard deviation of a soft part's width
BALANCE = 0.001  # g, assumption: a laboratory balance
DENSITY = 0.01  # relative, assumption: standard deviation of a data sheet's density of a cured silicone
FLASH_SHARE = 0.02  # of the silicone's mass, assumption: what may be left on


@dataclass(frozen=True)
class Measure:
    """A quantity of the cast part: nominal, limits and unit; `how` says with what."""

    what: str
    nominal: float
    low: float
    high: float
    unit: str
    how: str


class Inspection(NamedTuple):
    """What is measured: crests one by one, all else, what is said of the limits, and of which skin."""

    crests: Crests
    measures: tuple[Measure, ...]
    said: tuple[str, ...]
    skin: Skin


def inspection(job: Job, allowed_drops: tuple[float, ...] = (), margin: float = 0.0) -> Inspection:
    """Return the inspection of a cast skin on its carrier.

    `allowed_drops` `(ridges,)` mm is how much lower each crest may lie alone until the verdict's margin is
    used up, `margin` N (inf where lowering it does no harm), empty where there is no verdict, or it fails.
    """
    crests = crest_limits(job)
    said = tuple(remarks(job, crests, allowed_drops, margin))
    return Inspection(crests, tuple(_measures(job, crests)), said, job.skin)


def _measures(job: Job, crests: Crests) -> list[Measure]:
    known, base, skin = job.processes, job.design.skin, job.skin
    body = known[job.design.mold.process]
    end = known[job.design.mold.end_plate_process or job.design.mold.process]
    mean, place = math.fsum(crests.heights) / len(crests.heights), "the flat back"
    lengthwise, long = f"length along {skin.form.way}", base.length
    if job.bent:
        place = "the back, in the middle of its length"
        lengthwise = "length of the back, straight from end to end"
        long = 2 * (base.back_radius * math.sin(base.length / 2 / base.radius_y))
    what, them = ("face", "places") if skin.bare else ("crest", "crests")
    what, how = f"mean {what} over {place}", f"mean of the {them} as measured: the thickness"
    rows = [Measure(what, mean, mean - crests.mean, mean + crests.mean, "mm", how)]
    if skin.count > 1 and skin.form.along:
        spans = skin.count - 1
        how = f"the line's rise from crest 1 to crest {skin.count}"
        rows.append(Measure("tilt of the crests", 0.0, -crests.rise, crests.rise, "mm", how))
        how = f"microscope, from crest 1 to crest {skin.count}" + (f", by {spans}" if spans > 1 else "")
        tool = MICROSCOPE * math.sqrt(2) / spans
        rows.append(_size("mean pitch", skin.pitch, 2 * body.tolerance / spans, tool, crests, how))
    how, near = "callipers, lightly", walls_close(job, body)
    sizes = [("width across the back", base.width - 2 * near, body), (lengthwise, long + 2 * near, end)]
    if not job.ends:
        sizes = [("diameter of the back", base.width - 2 * near, body)]
        how += ", twice square to each other"
    rows += [_size(name, size, 2 * by.tolerance, CALLIPERS, crests, how) for name, size, by in sizes]
    return [*rows, _mass(job, crests)]


def _size(what: str, nominal: float, mold: float, tool: float, crests: Crests, how: str) -> Measure:
    """A size across: the mold's surfaces lie `mold` mm off at most, the batch and the tool scatter."""
    spread = mold + crests.deviations * math.hypot(SHRINKAGE_SCATTER * nominal, tool)
    return Measure(what, nominal, nominal - spread, nominal + spread, "mm", how)


def _mass(job: Job, crests: Crests) -> Measure:
    """What stays on the carrier: skin, rivets, the vent's plug and films. Too light means a bubble or a short
    shot, too heavy means flash."""
    made, skin = pours(job), job.design.skin
    density = 1e-6 * math.fsum(layer.volume * layer.silicone.density for layer in made)
    density /= math.fsum(layer.volume for layer in made)
    holes = bores(job.closed.first(PartRole.CARRIER), CutRole.RIVET, CutRole.VENT)
    films, glue = _films(job)
    body = density * (job.skin_part.volume + _extra_volume(job) + glue)
    behind = made[-1].silicone.density * 1e-6
    rubber = body + behind * math.fsum(map(partial(_hole_volume, job), holes))
    process = job.cavity_process
    sides = process.tolerance * math.sqrt(2 / 3) * math.hypot(1 / skin.width, 1 / skin.length)  # two, evenly
    shape = body * math.hypot(crests.mean / crests.deviations / skin.thickness, sides)
    spread = math.hypot(rubber * DENSITY, rubber * 3 * SHRINKAGE_SCATTER, shape, BALANCE) * crests.deviations
    its = [word for word, there in (("rivets", len(holes) > 1), ("films", films > 0)) if there]
    what = "mass of the skin" + (f" with {' and '.join(its)}" if its else "")
    holder = "carrier" if job.bone is None else "bone"
    flush = "cut flush with the carrier's top, " if job.bone is None else ""
    how = f"balance, {flush}less what the {holder} weighed{', without magnets' if job.magnet else ''}"
    nominal = rubber + films
    return Measure(what, nominal, nominal - spread, nominal + spread + FLASH_SHARE * rubber, "g", how)


def _extra_volume(job: Job) -> float:
    """Return how much more silicone a mold takes than drawn, mm3, to first order in what comes out.

    Where walls come nearer by w, so does the ledge, on which the back lies: of the section w times (the cast
    outline less its width) goes, for floors rise with the ledge; the cavity's ends, between which the plates
    lie, stand 2 w further apart. An offset of all crests deepens all of it. Of a round skin w times (the face
    that turns less its back) goes.
    """
    near = walls_close(job, job.cavity_process)
    skin, shape = job.design.skin, job.section
    if not job.ends:
        points = polygon(right_half(shape.outline), MICROSCOPE)
        steps = np.roll(points, -1, axis=0) - points
        face = math.pi * float(np.hypot(*steps.T) @ (points[:, 0] + np.roll(points[:, 0], -1)))
        back = math.pi / 4 * skin.width**2  # is in the turned face as well
        return offset_of(job) * back - near * (face - 2 * back)
    less = near * (length(shape.outline) - 2 * skin.width) - offset_of(job) * skin.width
    drawn = area(shape.outline)
    return (drawn - less) * (skin.length + 2 * near) - drawn * skin.length


def _hole_volume(job: Job, bore: Bore) -> float:
    """Volume of a carrier's hole as it comes out, mm3: by its mean radius."""
    near = walls_close(job, job.lid_process)
    return bore.volume * max(0.0, 1 - 2 * near / (bore.radius + bore.far_radius)) ** 2


def _films(job: Job) -> tuple[float, float]:
    """Mass of the trimmed films with leads and tabs, g, and the silicone's volume beside them, mm3."""
    skin = job.skin
    film, slot = job.design.film, skin.slot
    if film is None or slot is None:
        return 0.0, 0.0
    count, long = 2 * skin.count, job.design.skin.length
    beside = job.section.slots[0].thickness - film.thickness
    glue = 0.0 if job.design.contact.film == "loose" else count * beside * slot.depth * long
    trimmed = math.fsum(area(strip.trimmed) for strip in strip_patterns(job))
    return film.thickness * trimmed * PVDF_DENSITY * 1e-6, glue


def inspection_lines(inspected: Inspection) -> list[str]:
    """Return the form as Markdown: of very many crests not in a row, those alike together. Its words are
    templates/papers/inspection.md."""
    crests, alike = inspected.crests, dict[object, list[int]]()
    for i, height in enumerate(crests.heights):
        alike.setdefault(i if len(crests.heights) <= MOST_LISTED else f"{height:.3f}", []).append(i)
    limit = crests.deviations * math.hypot(crests.sigma, GAUGE_SIGMA)
    facts = {**inspected._asdict(), "alike": alike.values(), "limit": limit, "gauge": GAUGE_SIGMA}
    facts |= {"places": crest_places(inspected.skin), "column": crest_column(inspected.skin)}
    return paper("inspection.md", **facts).splitlines()
