"""What is bought for the bench: each thing once, for the casting sheet and for the parts list alike.

Parts that are made, and screws, pins, inserts, foam and shims, follow from the mold (parts_list.py). Here is
what is used up or held in the hand: for mixing and filling, and so that films go in and hold.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

from skincad.fabrication.casting_steps import (
    ALCOHOL_ML,
    PRIMER,
    PRIMER_ML,
    THREAD_LENGTH,
    printed_parts,
    strip_count,
)
from skincad.fabrication.electrodes import tab
from skincad.fabrication.filling import perforated
from skincad.fabrication.job import Job
from skincad.fabrication.pouring import batch, filling, outlet_words, small_batch
from skincad.fabrication.strips import GRAVITY, lap, pull_test, strip, strips_per_mix
from skincad.solids.inserts import PITCH

SPARE_SHARE = 0.1  # assumption: of the strips, for those that crease
BATHS_ML = 500  # ml, assumption: two baths in a jar that the parts fit in
RISE = 4.0  # of its height, to which a mix rises as it is degassed, source: makers' data sheets, 3 to 4


class Need(NamedTuple):
    """A thing to buy: how much, what, of which size or kind, what for, the quantity's unit, and tolerance and
    condition as it is delivered."""

    quantity: int
    what: str
    size: str
    use: str
    unit: str = "pcs"
    tolerance: str = ""
    condition: str = ""

    @property
    def words(self) -> str:
        """As the casting sheet has it."""
        what = f"{self.quantity} {self.what}s" if self.quantity > 1 else self.what
        if self.unit != "pcs":
            what = f"{self.quantity} {self.unit} of {self.what}"
        size = f", {self.size}" if self.size else ""
        return f"{what}{size}" + (f": {self.use}" if self.use else "")


def consumables(job: Job) -> list[Need]:
    """Return what is used up in a cast, and small tools for it."""
    return [*_filling(job), *_films(job)]


def _filling(job: Job) -> Iterator[Need]:
    volume = RISE * batch(job) / job.silicone.density * 1000
    cup = math.ceil(volume / 10) * 10
    yield Need(1, "mixing cup", f"clear, {cup} ml or more", "a mix rises to four times its height")
    if job.gate is not None:
        yield Need(1, "syringe", f"{filling(job).syringe} ml, {outlet_words(job.gate)}", "")
        yield Need(1, "plug", f"for a hole of {job.gate:g} mm", "the gate")
    if printed_parts(job):
        yield Need(1, "release agent", "for silicone, with a brush", "printed parts")
    if job.silicone.platinum_cure and any(
        job.process(part).inhibits_platinum for part in job.closed.parts if part.made == "made"
    ):
        yield Need(BATHS_ML, "isopropanol", "", "washes resin parts", "ml")
    yield Need(1, "tape", "acrylic adhesive", "bleeds; rubber adhesive, as on crepe tape, inhibits silicone")
    yield Need(1, "pair of gloves", "nitrile", "latex inhibits silicone")
    if filling(job).brushed:
        yield Need(1, "soft brush", "2 mm wide or less", "the mix into the grooves")
    if not perforated(job.closed) and job.design.film is None:
        yield Need(1, PRIMER, "with a fine brush", "the carrier's lower face", "ml")


def _films(job: Job) -> Iterator[Need]:
    film, slot, rod, pull = job.design.film, job.skin.slot, strip(job), pull_test(job)
    if film is None or slot is None or rod is None or pull is None:
        return
    strips, cavities, cast_in = strip_count(job), job.design.mold.cavities, lap(job) is None
    wiped, spare = strips * (1 if cast_in else 3), math.ceil(SPARE_SHARE * strips)
    coat = PRIMER_ML * 2 * (strips + spare) * slot.depth * job.design.skin.length / 100
    masked = 2 * (job.lead + tab(film)[1] + (20 if cast_in else 0))  # mm, folded over
    sheets = f"film/strips.dxf {cavities} times" if cavities > 1 else "film/strips.dxf"
    yield Need(
        strips,
        "film strip",
        f"PVDF, {1000 * film.thickness:.0f} µm, sputtered metal on both faces, and {spare} to spare",
        f"cut by {sheets}, its + side up",
        tolerance=f"cut ±{film.cut_tolerance:g}, faces registered ±{film.registration:g}",
        condition="poled, draw axis along the strips; cut edges free of metal burrs",
    )
    yield Need(2 * strips, "crimp contact", f"for flat cable, {PITCH:g} mm apart", "one for each pad")
    backing = math.ceil(strips * (tab(film)[1] + 2) / 10)
    yield Need(backing, "polyester tape", "0.1 mm", "backs the pads: bare film tears in a crimp", "cm")
    yield Need(cavities, "pin header", f"2 x {2 * job.skin.count}, {PITCH:g} mm", "on the board")
    yield Need(
        cavities,
        "board",
        "by film/strip-board.kicad_mod, FR-4, 1.6 mm",
        "brings the tabs together",
        tolerance="thickness ±10 %",
        condition="tinned or gold pads",
    )
    yield Need(max(1, math.ceil(coat)), PRIMER, "with a fine brush", "the strips' faces", "ml")
    yield Need(
        math.ceil(ALCOHOL_ML[0] + ALCOHOL_ML[1] * wiped), "isopropanol", "", "wipes strips and shims", "ml"
    )
    yield Need(wiped, "lint-free wipe", "10 cm or so", "")
    tape = math.ceil((strips + spare) * masked / 10)
    yield Need(tape, "low-tack tape", "acrylic adhesive", "masks", "cm")
    if cast_in:
        yield Need(2 * strips, "weight", f"{rod.hung:.3g} g", "hang on the strips' tabs")
        yield Need(math.ceil(2 * strips * THREAD_LENGTH), "thread", "", "holds the weights", "m")
        yield Need(2, "rod", "3 mm", "for the thread to run over, on one board with the mold")
    else:
        most = strips_per_mix(job)
        mixes, each = math.ceil(strips / most) if most else 1, small_batch(job.silicone)
        more = math.ceil(mixes * each)
        yield Need(
            more, "more silicone", job.silicone.name, f"draws the strips in, {mixes} x {each:g} g", "g"
        )
        yield Need(1, "cyanoacrylate", "thin", "glues strips to shims", "g")
        yield Need(1, "polythene film", "10 cm or so", "keeps glue off")
        yield Need(1, "flat pliers", "smooth jaws", "draw the shims")
    hung = f"{1000 * pull.force / GRAVITY:.3g} g together"
    yield Need(1, "film clip and weight", hung, f"pull test, on {THREAD_LENGTH:g} m of thread")
