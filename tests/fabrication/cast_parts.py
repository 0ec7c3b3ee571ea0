"""Parts as they are cast, drawn by a generator that knows nothing of the inspection's limits.

The mold: each groove is off by the process's crest error, each end of the ledge on which the carrier lies by
an error of the same size, surfaces along x and y evenly within the tolerance. Layers: material is where a
layer's middle is, so each height is a whole number of layers. The silicone: shrinkage and density of its
batch, and flash that was left on. The person: gauge, microscope, callipers and balance.

Standard deviations of the silicone and the tools are written out here, not imported, so that limits drawn
from other ones fail.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from skincad.base import Array
from skincad.fabrication import Job
from skincad.inputs import Design, processes
from skincad.shape import section
from skincad.solids import ClosedMold, CutRole, PartRole, bores

BATCH = 0.002  # relative, shrinkage from batch to batch
DENSITY = 0.01  # relative
FLASH = 0.02  # of the mass, at most
GAUGE, MICROSCOPE, CALLIPERS, BALANCE = 0.002, 0.005, 0.01, 0.001  # mm, mm, mm, g
PVDF = 1.78e-3  # g/mm3


class Parts(NamedTuple):
    """What a person reads of `n` parts: crests `(n, ridges)` mm above the back, their true values, and what a
    person has who reads on; pitch, width and length `(n,)` mm, mass `(n,)` g."""

    crests: Array
    true_crests: Array
    crests_again: Array
    mold_crests: Array
    pitch: Array
    width: Array
    length: Array
    mass: Array


def sliced(design: Design, closed: ClosedMold) -> Array:
    """Crest heights `(ridges,)` mm of the cured skin as its mold's layers give them: where the middle of a
    layer lies in the block it is solid. Exact heights where there are no layers, or the cavity is on end."""
    process = processes(design.printer)[design.mold.process]
    radius, thick = design.skin.curvature_radius, design.skin.thickness
    lean = (np.arange(design.ridge.count) - (design.ridge.count - 1) / 2) * design.ridge.pitch / radius
    crests = thick - radius * (1 - np.cos(lean)) + np.array(design.heights) * np.cos(lean)
    if not process.layer or process.orientation == "end":
        return np.asarray(crests)
    grown = closed.first(PartRole.SKIN).volume / (section(design).area * design.skin.length)
    grown = grown ** (1 / 3)
    (block,) = closed.of(PartRole.CAVITY)
    bottom = min(segment.start[1] for segment in block.body.outline)
    middles = (np.arange(20_000) + 0.5) * process.layer + bottom

    def printed(level: float) -> float:
        return float((middles < level).sum() * process.layer)

    return np.array([(printed(0.0) - printed(-crest * grown)) / grown for crest in crests])


def _films(design: Design) -> float:
    """Volume of all films, mm3: in the skin, leads (cast in: through both end plates, and a stub of 2 mm),
    and tabs with their pads, 9.5 by 5.04 mm behind rounded shoulders of 0.5 mm, less their corners."""
    if design.film is None or design.slot is None:
        return 0.0
    outside = Job(design).lead
    if design.mold.method == "cast-in":
        outside += (
            2 * design.mold.end_plate + 2.0 + design.skin.length * (1 / (1 - Job(design).shrinkage) - 1)
        )
    wide = max(5.04, design.slot.depth + 3.5)
    tab = 9.5 * wide + 0.5 * design.slot.depth + 2 * (1 - math.pi / 4) * 0.25 - 0.5
    strip = design.slot.depth * (design.skin.length + outside) + tab
    return 2 * design.ridge.count * design.film.thickness * strip


def drawn(
    design: Design,
    closed: ClosedMold,
    count: int,
    seed: int,
    worse: float = 1.0,
    readings: tuple[int, int] = (1, 1),
) -> Parts:
    """Draw `count` parts; `worse` multiplies the crests' errors alone; crests are means of the first of
    `readings`, and when read on, these among them, of the second."""
    rng = np.random.default_rng(seed)
    body = processes(design.printer)[design.mold.process]
    end = processes(design.printer)[design.mold.end_plate_process or design.mold.process]
    ridges, sigma = design.ridge.count, body.crest_sigma
    batch = 1 + BATCH * rng.standard_normal(count)
    share = 0.5 + (np.arange(ridges) - (ridges - 1) / 2) * design.ridge.pitch / design.skin.width
    left, right = sigma * rng.standard_normal((2, count, 1))
    shrunk = sliced(design, closed) * (batch[:, None] - 1)
    crests = sliced(design, closed) + shrunk + left * (1 - share) + right * share
    crests = crests + worse * sigma * rng.standard_normal((count, ridges))

    def surface(tolerance: float) -> Array:
        return np.asarray(rng.uniform(-tolerance, tolerance, count))

    shift = surface(body.tolerance) + surface(body.tolerance)
    spans = max(1, ridges - 1)
    pitch = design.ridge.pitch * batch + shift / spans
    pitch = pitch + MICROSCOPE * math.sqrt(2) * rng.standard_normal(count) / spans
    width = design.skin.width * batch + surface(body.tolerance) + surface(body.tolerance)
    length = design.skin.length * batch + surface(end.tolerance) + surface(end.tolerance)
    volume = section(design).area * design.skin.length * batch**3
    volume = volume + (crests - crests.mean(axis=0)).mean(axis=1) * design.skin.width * design.skin.length
    if design.film and design.slot:  # glued: what is not film in the slots is silicone, but for some air
        slots = 2 * ridges * design.slot.thickness * design.slot.depth * design.skin.length
        inside = slots * design.film.thickness / design.slot.thickness
        wide = design.slot.thickness if design.mold.method == "shim" else design.film.thickness
        volume = volume + (slots * wide / design.slot.thickness - inside) * rng.uniform(0.7, 1, count)
    carrier = closed.first(PartRole.CARRIER)
    volume = volume + sum(hole.volume for hole in bores(carrier, CutRole.RIVET, CutRole.VENT))
    mass = volume * Job(design).silicone.density * 1e-6 * (1 + DENSITY * rng.standard_normal(count))
    mass = mass * (1 + rng.uniform(0, FLASH, count)) + _films(design) * PVDF
    first, last = readings
    gauge = GAUGE / math.sqrt(first) * rng.standard_normal(crests.shape)
    width = width + CALLIPERS * rng.standard_normal(count)
    length = length + CALLIPERS * rng.standard_normal(count)
    mass = mass + BALANCE * rng.standard_normal(count)
    more = GAUGE * math.sqrt(last - first) * rng.standard_normal(crests.shape)
    return Parts(
        np.asarray(crests + gauge),
        np.asarray(crests),
        np.asarray(crests + (first * gauge + more) / last),
        np.asarray(crests - shrunk + GAUGE * rng.standard_normal(crests.shape)),
        np.asarray(pitch),
        np.asarray(width),
        np.asarray(length),
        np.asarray(mass),
    )
