"""Inserts that lie in the mold while it is poured: shims or strips, and dowel pins."""

from __future__ import annotations

import math

from skincad.inputs.design import Design
from skincad.shape.curves import flipped
from skincad.shape.skin import section
from skincad.solids.kind import kind_of
from skincad.solids.plan import Bore, End, Part, PartRole, Prism, Vector

PIN_RADIUS = 1.0  # mm, source: ISO 2338 dowel pin, 2 mm
GRIP = 6.0  # mm, assumption: of a shim beyond each end plate: pliers hold it there, and a film is glued to it
LEAST_DEFAULT_LEAD = 8.0  # mm, assumption: pliers and tape hold so much
PITCH = 2.54  # mm, source: 0.1 inch, crimps and clinchers for flat cable (TE 108-9024, FCI BUS-12-022)
MOST_TURN = math.radians(30.0)  # assumption: by which a lead may leave its slot's direction
BEND = 50.0  # thicknesses of film, assumption: radius of a bend, 1 % of strain; it yields at 1.5 (strips.py)
STUB = 2.0  # mm, assumption: room for a knife between an end plate and a strip's tab


def shims(design: Design) -> list[Part]:
    """Return a shim for every slot: the slot's rectangle, through both end plates and a grip beyond each."""
    half = design.skin.length / 2 + design.mold.end_plate
    return [
        Part(
            f"shim-{slot.feature}-{slot.side}",
            PartRole.SHIM,
            Prism(flipped(slot.loop()), "y", -half - GRIP, half + GRIP),
        )
        for slot in section(design).slots
    ]


def drawing_end(design: Design) -> End:
    """Return the end towards which shims are drawn: away from the wiring side, so that a film follows with
    its other end first and no contact goes through a slot; end b without film."""
    return "a" if design.film and design.film.wiring_side == "b" else "b"


def strips(design: Design) -> list[Part]:
    """Return the film strip of every slot as it is cast in: straight through both combs, to where its tabs
    are cut off before the mold opens. None without film.

    The tabs, wider than a notch, stand beyond and are on the cutting pattern only.
    """
    film = design.film
    if film is None:
        return []
    half, (a, b) = design.skin.length / 2, strip_overhangs(design)
    return [
        Part(
            f"strip-{slot.feature}-{slot.side}",
            PartRole.STRIP,
            Prism(flipped(slot.loop(film.thickness)), "y", -half - a, half + b),
        )
        for slot in section(design).slots
    ]


def lead_length(design: Design) -> float:
    """Return how long the straight leads of a design's strips are, mm: as it says, or at least 8 and what the
    tabs need to spread to a board, and of a doubly curved mold the end plate besides; 0 without film."""
    if design.film is None:
        return 0.0
    if design.film.lead is not None:
        return design.film.lead
    plate = design.mold.end_plate if kind_of(design).leans else 0.0
    return max(LEAST_DEFAULT_LEAD, math.ceil(2 * fan_lead(design)) / 2) + plate


def fan_offset(design: Design) -> float:
    """Return how far the outermost strip is led aside to a board's grid of `PITCH`, mm."""
    places = sorted(slot.centre.x for slot in section(design).slots)
    middle = (len(places) - 1) / 2
    return max((abs(PITCH * (i - middle) - x) for i, x in enumerate(places)), default=0.0)


def fan_lead(design: Design) -> float:
    """Return the length of an S of two arcs and a straight, which moves the outermost lead aside, mm."""
    offset, radius = fan_offset(design), BEND * (design.film.thickness if design.film else 0.0)
    by_arcs = 2 * radius * (1 - math.cos(MOST_TURN))
    if offset <= by_arcs:
        return 2 * radius * math.acos(1 - offset / 2 / radius) if radius else 0.0
    return 2 * radius * MOST_TURN + (offset - by_arcs) / math.sin(MOST_TURN)


def strip_overhangs(design: Design) -> tuple[float, float]:
    """Return what a strip stands out of the skin at end a and b once its tabs are cut off, mm: the lead on
    the wiring side; a strip that is cast in goes through its end plates besides."""
    if design.film is None:
        return 0.0, 0.0
    through, stub = (design.mold.end_plate, STUB) if design.mold.method == "cast-in" else (0.0, 0.0)
    wired, other = through + lead_length(design), through + stub
    return (wired, other) if design.film.wiring_side == "a" else (other, wired)


def pin(role: PartRole, name: str, start: Vector, length: float, end: End | None = None) -> Part:
    """Return a dowel pin from `start` upward, or along +y where it belongs to an `end`."""
    return Part(name, role, Bore(start, "y" if end else "z", length, PIN_RADIUS), end=end)
