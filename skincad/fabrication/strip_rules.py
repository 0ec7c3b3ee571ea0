"""Rules for strips and shims: do they stay where the section has them, before, in and after the pour."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Literal

from skincad.fabrication.drawing_in import drawing_findings
from skincad.fabrication.finding import Finding
from skincad.fabrication.rules import slit_play
from skincad.fabrication.strips import (
    MOST_PULL,
    PVDF_YIELD,
    Pour,
    Strip,
    deflection,
    pour,
    release_strain,
    straightening_tension,
    strip,
    weight,
)
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.shape.skin import skin_of
from skincad.solids.layout import end_process

MOST_RELEASE = 1e-3  # strain, assumption: as much as a silicone shrinks
SAG_SHARE = 0.01  # assumption: of slot.offset, by which a strip may sag while the silicone cures
DRIFT_SHARE = 0.25  # of the silicone beside it; further, a capillary force that grows as 1 / gap pulls it on
PLACE_SHARE = 0.1  # assumption: of slot.offset; more unbalances a pair by more than a fifth
# assumption: by which S1 and S2 may differ; their difference, the signal, is in doubt beyond
MOST_UNBALANCE = 0.5
SETTLING_SHARE = 0.1  # assumption: of the pot life, in which a strip must be back


def placement_error(design: Design) -> float:
    """Return how far a strip or shim may lie from its place in the section, mm: what growth and a coat
    leave of the slit clearance, and the tolerance of the process that makes the combs."""
    process = end_process(design)
    return max(0.0, slit_play(design, process)) + process.tolerance


def strip_findings(design: Design) -> list[Finding]:
    """Return the rules `strip sag`, `strip stress`, `strip drift`, `strip release` and `strip place`, and
    those of drawing in; none without slots."""
    rod, flow = strip(design), pour(design)
    if rod is None or flow is None or skin_of(design).slot is None:
        return []
    cast = [*_sag(design, rod), *_stress(rod, flow)] if design.mold.method == "cast-in" else []
    moved = [*_drift(design, rod, flow), *_release(design, rod), *_place(design)]
    return [*cast, *moved, *drawing_findings(design)]


def _sag(design: Design, rod: Strip) -> Iterator[Finding]:
    """At rest in the silicone, which is how it cures; in air, before, its load is larger, but that passes."""
    slot = skin_of(design).slot
    load = weight(rod, silicone(design).density)
    sag, limit = (
        abs(deflection(rod, load)),
        SAG_SHARE * (slot.offset if slot else 0.0),
    )
    if sag > limit:
        remedy = f"film.tension of {straightening_tension(rod, load, limit):.2g} N or more, or a shorter skin"
        where = "strips, under their weight in silicone"
        yield Finding("strip sag", where, sag, limit, "mm", "warning", remedy)


def _stress(rod: Strip, flow: Pour) -> list[Finding]:
    stress, limit = (rod.tension + flow.pull) / rod.section, MOST_PULL * PVDF_YIELD
    if stress <= limit:
        return []
    least = max(limit * rod.section - flow.pull, 0.0)
    remedy = f"film.tension of at most {least:.2g} N, or a thicker film; it yields at {PVDF_YIELD:g} MPa"
    severity: Literal["error", "warning"] = "error" if stress > PVDF_YIELD else "warning"
    return [Finding("strip stress", "strips, under their tension", stress, limit, "MPa", severity, remedy)]


def _drift(design: Design, rod: Strip, flow: Pour) -> Iterator[Finding]:
    """While the front passes; and whether a strip is back long before the silicone sets."""
    name = "strips" if design.mold.method == "cast-in" else "shims"
    limit = DRIFT_SHARE * flow.beside
    slower = f"mold.fill_time of {design.mold.fill_time * flow.drift / limit:.2g} s or more"
    stronger = ", more tension or a thicker film" if rod.tension else ", or a thicker slot"
    if flow.drift > limit:
        where = f"{name}, while silicone is poured round them"
        yield Finding("strip drift", where, flow.drift, limit, "mm", "warning", slower + stronger)
    pot_life = silicone(design).pot_life_min
    if pot_life is not None and flow.settling > SETTLING_SHARE * 60 * pot_life:
        where, remedy = f"{name}, coming back after the pour", "a thinner silicone" + stronger
        limit = SETTLING_SHARE * 60 * pot_life
        yield Finding("strip drift", where, flow.settling, limit, "s", "warning", remedy)


def _release(design: Design, rod: Strip) -> Iterator[Finding]:
    """A note: the skin comes out shorter than designed."""
    strain = release_strain(design)
    if strain > MOST_RELEASE:
        where, remedy = "skin, shortened by its strips", f"{rod.tension * MOST_RELEASE / strain:.2g} N"
        yield Finding("strip release", where, strain, MOST_RELEASE, "", "note", f"film.tension of {remedy}")


def _place(design: Design) -> list[Finding]:
    """A note, or a warning beyond `MOST_UNBALANCE`.

    Stress across the film grows about as its distance from the axis (assumption). So a pair is out of balance
    by up to both errors by the offset.
    """
    slot = skin_of(design).slot
    off, offset = placement_error(design), slot.offset if slot else math.inf
    if off <= PLACE_SHARE * offset:
        return []
    remedy = (
        f"calibrate each pair: S1 and S2 may differ by {100 * 2 * off / offset:.0f} %; or a smaller "
        "slit_clearance, a finer process for the combs, or a larger design"
    )
    grave: Literal["note", "warning"] = "warning" if 2 * off / offset > MOST_UNBALANCE + 1e-9 else "note"
    return [Finding("strip place", "strips in their slits", off, PLACE_SHARE * offset, "mm", grave, remedy)]
