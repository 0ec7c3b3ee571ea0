"""The cover as a plate: how many screws hold it, how thick it is, and how far it bows between them.

A filled mold pushes its cover up over its carriers. The cover is a plate on rows of screws: across (x) it
spans from row to row, along (y) from screw to screw. As in a flat slab each way carries the whole load
(Nichols, Trans. ASCE 77, 1914), so both bows add: for a square plate on its four corners 2 x 5/384 q a4 / D,
0.0260, where the plate's exact solution has 0.0257 (Timoshenko and Woinowsky-Krieger, Theory of Plates and
Shells, section 47). Without the walls' support and the plate's Poisson ratio it is on the safe side.
"""

from __future__ import annotations

import math
from typing import NamedTuple

PRESSURE = 0.01  # MPa, assumption: 10 kPa, a syringe pushed by hand after the mold is full
SHEETS = (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0)  # mm, assumption: as closed-cell foam is sold
SQUEEZED_SHARE = 0.7  # assumption: of a sheet's thickness, under the cover; by 0.5 to 0.9 it seals
SEAL_PLAY = 0.2  # of its thickness, that follows from it, up and down
# MPa, source: makers' data sheets, EVA foam of 100 kg/m3 squeezed by 30 %; at 10 % it is 0.02
SEAL_PRESSURE = 0.06
MOST_BOW = 0.02  # mm, assumption: what the cover may bow under it; a flash as thin is wiped off
LEAST_COVER = 4.0  # mm, assumption: least thickness, for its pins and the cup
TWIST_REACH = 2.6  # of the skin's length, by finite elements: a gang's cover twists on rows of one screw each
THICKEST = 50.0  # mm, that of mold.cover


class Spans(NamedTuple):
    """What a cover spans, mm: from row to row across, how wide its load is there, and its reach along: from
    screw to screw, or twice what stands over the last one."""

    row_distance: float
    load: float
    along: float


def bow(spans: Spans, thickness: float, modulus: float, pressure: float = PRESSURE) -> float:
    """Return how far a cover bows, mm: two simply supported beams' bows, across under a load in the middle,
    along under its whole one (handbooks). A cantilever bows less than a beam twice as long."""
    a, c, b = spans
    rigid = 384 * modulus * thickness**3 / 12  # N mm2 a mm of width
    return pressure * (c * (8 * a**3 - 4 * a * c**2 + c**3) + 5 * b**4) / rigid


def thick_enough(spans: Spans, modulus: float, stock: float) -> float:
    """Return the least thickness from `LEAST_COVER` on, in steps of `stock` mm, that keeps to `MOST_BOW`."""
    need = LEAST_COVER * max(1.0, math.cbrt(bow(spans, LEAST_COVER, modulus) / MOST_BOW))
    return min(THICKEST, math.ceil(need / stock - 1e-9) * stock)


class ScrewRow(NamedTuple):
    """A row of screws along y: how many, how far apart, mm, and their reach, as in `Spans`."""

    screws: int
    spacing: float
    reach: float


def screw_rows(
    length: float, diagonal: float, end_distance: float, least_spacing: float, skins: int = 1
) -> list[ScrewRow]:
    """Return the rows that a cover of this length can have, the fewest screws first. One in each row, the
    outer ones' at `diagonal` mm from the middle, opposite a pin; or more, `aside` mm from the ends and at
    least `beside` from each other, where a pin stands between two."""
    choices = [ScrewRow(1, 0.0, length + 2 * diagonal if skins == 1 else TWIST_REACH * length)]
    last = length / 2 - end_distance
    count = 2
    while last > 0 and (spacing := 2 * last / (count - 1)) >= least_spacing:
        choices.append(ScrewRow(count, spacing, max(spacing, 2 * end_distance)))
        count += 1
    return choices


def choose_screws(
    choices: list[ScrewRow],
    row_distance: float,
    load: float,
    modulus: float,
    thickness: float | None,
    stock: float,
) -> tuple[ScrewRow, float]:
    """Return the row of fewest screws and the cover's thickness, mm, with which it keeps to
    `MOST_BOW`; a given thickness is kept, whatever its bow."""
    least = thickness or thick_enough(Spans(row_distance, load, 0.0), modulus, stock)
    for row in choices:
        if bow(Spans(row_distance, load, row.reach), least, modulus) <= MOST_BOW:
            return row, least
    row = min(choices, key=lambda choice: choice.reach)
    return row, thickness or thick_enough(Spans(row_distance, load, row.reach), modulus, stock)


def seal_thickness(stack: float) -> float:
    """Return the thickness of the foam sheet that stays squeezed by 10 to 50 % where what it lies on is up to
    `stack` mm higher or lower; the thickest there is where none does."""
    return next((sheet for sheet in SHEETS if SEAL_PLAY * sheet >= stack - 1e-9), SHEETS[-1])
