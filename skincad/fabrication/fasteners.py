"""What holds a mold together, as its parts have it: screws with washers and nuts, and dowels."""

from __future__ import annotations

import math
from collections import Counter
from typing import NamedTuple

from skincad.inputs.design import Design
from skincad.solids.fasteners import LENGTHS, PITCH, screw_for, standard_length
from skincad.solids.layout import cavity_process
from skincad.solids.mold import ClosedMold
from skincad.solids.plan import CAVITIES, END_PLATES, PINS, Bore, CutRole, PartRole, bores, unturned
from skincad.solids.shrinkage import scaled_for_shrinkage

NUT = 4.0  # mm, assumption: nut and washer of an M3 bolt
# mm, source: ISO 8734, nominal lengths of parallel pins of 2 mm
PIN_LENGTHS = (5, 6, 8, 10, 12, 14, 16, 18, 20)


class Screws(NamedTuple):
    """Equal M3 screws: how many, their length, mm, washers under each head, and nuts in all. `bottoming`
    asks for a bottoming tap at last."""

    pieces: int
    length: float
    washers: int = 0
    nuts: int = 0
    bottoming: bool = False

    @property
    def rod(self) -> bool:
        """Whether there are none so long: a threaded rod with a nut at both ends."""
        return self.length > LENGTHS[-1]


def cover_screws(design: Design, closed: ClosedMold) -> Screws | None:
    """Return the cover's screws; None where clamps hold it."""
    cover, blocks = closed.first(PartRole.COVER), closed.of(*CAVITIES)
    screws = bores(cover, CutRole.COVER_BOLT)
    if not screws:
        return None
    passed = max((b.length for p in blocks for b in bores(p, CutRole.COVER_BOLT)), default=0.0)
    thread_length = max(b.length for p in blocks for b in bores(p, CutRole.COVER_THREAD))
    split = bool(closed.of(PartRole.BASE))
    long, washers = screw_for(
        screws[0].length + passed, thread_length, cavity_process(design), bottomed=split
    )
    return Screws(len(screws), long, washers)


def end_screws(design: Design, closed: ClosedMold) -> Screws:
    """Return the end plates' screws: along y through both plates, or, of a doubly curved mold, into each of
    the cavity's ends."""
    if design.skin.curvature_radius_y is not None:
        count = sum(len(bores(plate, CutRole.END_BOLT)) for plate in closed.of(*END_PLATES))
        threads = bores(closed.first(PartRole.CAVITY), CutRole.END_THREAD)
        process, plate, deep = cavity_process(design), design.mold.end_plate, min(b.length for b in threads)
        long, washers = screw_for(plate, deep, process, bottomed=True)
        bottoming = process.thread == "tapped" and screw_for(plate, deep, process)[1] > washers
        return Screws(count, long, washers, bottoming=bottoming)
    cuts = [cut.role for part in closed.of(*END_PLATES) if part.end == "b" for cut in part.cuts]
    sunk, tapped = cuts.count(CutRole.NUT), cuts.count(CutRole.END_THREAD)
    count = cuts.count(CutRole.END_BOLT) + tapped
    through = scaled_for_shrinkage(design).skin.length + 2 * design.mold.end_plate
    long = standard_length(through + (0 if tapped else PITCH if sunk else NUT + PITCH))
    return Screws(count, long, nuts=0 if tapped else count * (2 if long > LENGTHS[-1] else 1))


def dowels(closed: ClosedMold) -> dict[float, int]:
    """Return how many dowels there are of each greatest length, mm, whole tenths."""
    pins = (unturned(part).body for part in closed.of(*PINS))
    return dict(Counter(math.floor(10 * pin.length) / 10 for pin in pins if isinstance(pin, Bore)))


def pin_length(most: float) -> float:
    """Return the longest standard pin of at most this length, mm; below the shortest, what one is cut to."""
    return max((float(length) for length in PIN_LENGTHS if length <= most), default=most)
