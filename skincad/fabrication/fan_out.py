"""How the tabs of a skin's strips come from their slots to a board: turned upright, spread to its grid.

At its slots a tab may stand nearer to the next than a contact is thick, and tabs of leaning slots cross.
Leads are thin across and bend aside by an S of two arcs: that needs lead.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import shapely

from skincad.fabrication.electrodes import PITCH, half_tab
from skincad.fabrication.finding import Finding
from skincad.inputs.design import Design
from skincad.shape.feature import SensorPlace
from skincad.shape.skin import section, skin_of
from skincad.solids.shrinkage import scaled_for_shrinkage

MOST_TURN = math.radians(30.0)  # assumption: by which a lead may leave its slot's direction
BEND = 50.0  # thicknesses of film, assumption: radius of a bend, 1 % of strain; it yields at 1.5 (strips.py)


class FanOut(NamedTuple):
    """Strips by x, the least distance of two neighbours' tabs as their slots hold them and between slots, how
    far the outermost is bent aside, and the lead that takes, mm."""

    strips: tuple[SensorPlace, ...]
    tab_gap: float
    spacing: float
    offset: float
    lead: float


def fan_out(design: Design) -> FanOut | None:
    """Return how the strips of one skin spread to a board's grid of `PITCH`; None without film."""
    film, slot = design.film, skin_of(design).slot
    if film is None or slot is None:
        return None
    cast = scaled_for_shrinkage(design) if design.mold.method == "cast-in" else design
    strips = tuple(sorted(section(cast).slots, key=lambda place: place.centre.x))
    half = half_tab(film, slot.depth)
    tabs = [shapely.LineString([s.at(0.0, -half), s.at(0.0, half)]) for s in strips]
    middle = (len(strips) - 1) / 2
    offset = max(abs(PITCH * (i - middle) - s.centre.x) for i, s in enumerate(strips))
    return FanOut(
        strips,
        min(a.distance(b) for a, b in pairwise(tabs)) - film.thickness,
        min(b.centre.x - a.centre.x for a, b in pairwise(strips)),
        offset,
        _lead(offset, BEND * film.thickness),
    )


def _lead(offset: float, radius: float) -> float:
    """Length of an S of two arcs and a straight, which moves a lead aside by `offset`, mm."""
    by_arcs = 2 * radius * (1 - math.cos(MOST_TURN))
    if offset <= by_arcs:
        return 2 * radius * math.acos(1 - offset / 2 / radius)
    return 2 * radius * MOST_TURN + (offset - by_arcs) / math.sin(MOST_TURN)


def fan_out_steps(design: Design) -> list[str]:
    """Return how tabs are brought to a board, for the casting sheet; nothing without film."""
    spread, film = fan_out(design), design.film
    if spread is None or film is None:
        return []
    first, *_, last = spread.strips
    crossed = " Tabs cross as the slots hold them." if spread.tab_gap <= 0 else ""
    room = (
        f"the lead of {film.lead:g} mm is long enough"
        if film.lead >= spread.lead
        else f"film.lead is {film.lead:g} mm, so give the outer ones single plugs on wires"
    )
    return [
        f"Bring the tabs to a board (strip-board.kicad_mod), strip by strip from {first.feature} "
        f"{first.side} to {last.feature} {last.side}.{crossed} Turn each tab upright, its cut corner to the "
        "ridges, crimp a "
        f"contact on each pad, and spread the tabs from {spread.spacing:.2f} mm at the slots to {PITCH:g} "
        "mm. "
        f"The outermost ones go {spread.offset:.1f} mm aside, in a lead of {spread.lead:.1f} mm at least; "
        f"{room}. Don't pull: what bends is the lead, not what is in the skin."
    ]


def fan_out_findings(design: Design) -> Iterator[Finding]:
    """A note where tabs cross. That contacts side by side need a longer lead, the casting sheet says."""
    spread, film = fan_out(design), design.film
    if spread is None or film is None or spread.tab_gap > 0:
        return
    where = "tabs of neighbouring strips, which cross as their slots hold them"
    remedy = "turn each tab upright on its lead before the next one is laid in; or a smaller slot.tilt"
    yield Finding("strip tabs", where, spread.tab_gap, 0.0, "mm", "note", remedy)
