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
from skincad.fabrication.electrodes import PITCH, tab
from skincad.fabrication.filling import perforated
from skincad.fabrication.job import Job
from skincad.fabrication.pouring import batch, filling, outlet_words, small_batch
from skincad.fabrication.strips import GRAVITY, lap, pull_test, strip, strips_per_mix

SPARE_SHARE = 0.1  # assumption: of the strips, for those that crease
BATHS_ML = 500  # ml, assumption: two baths in a jar that the parts fit in
RISE = 4.0  # of its height, to which a mix rises as it is degassed, source: makers' data sheets, 3 to 4


class Need(NamedTuple):
    """A thing to buy: how many, what, of which size or kind, and what for."""

    quantity: int
    what: str
    size: str
    use: str

    @property
    def words(self) -> str:
        """As the casting sheet has it."""
        what = f"{self.quantity} {self.what}s" if self.quantity > 1 else self.what
        return f"{what}, {self.size}" + (f": {self.use}" if self.use else "")


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
        yield Need(1, "isopropanol for the baths", f"{BATHS_ML} ml", "washes resin parts")
    yield Need(1, "tape", "acrylic adhesive", "bleeds; rubber adhesive, as on crepe tape, inhibits silicone")
    yield Need(1, "pair of gloves", "nitrile", "latex inhibits silicone")
    if filling(job).brushed:
        yield Need(1, "soft brush", "2 mm wide or less", "the mix into the grooves")
    if not perforated(job.closed) and job.design.film is None:
        yield Need(1, PRIMER, "1 ml, with a fine brush", "the carrier's lower face")


def _films(job: Job) -> Iterator[Need]:
    film, slot, rod, pull = job.design.film, job.skin.slot, strip(job), pull_test(job)
    if film is None or slot is None or rod is None or pull is None:
        return
    strips, cavities, cast_in = strip_count(job), job.design.mold.cavities, lap(job) is None
    wiped, spare = strips * (1 if cast_in else 3), math.ceil(SPARE_SHARE * strips)
    coat = PRIMER_ML * 2 * (strips + spare) * slot.depth * job.design.skin.length / 100
    masked = 2 * (film.lead + tab(film)[1] + (20 if cast_in else 0))  # mm, folded over
    sheets = f"film/strips.dxf {cavities} times" if cavities > 1 else "film/strips.dxf"
    yield Need(
        strips,
        "film strip",
        f"PVDF, {1000 * film.thickness:.0f} µm, sputtered metal on both faces, and {spare} to spare",
        f"cut by {sheets}, its + side up",
    )
    yield Need(2 * strips, "crimp contact", f"for flat cable, {PITCH:g} mm apart", "one for each pad")
    yield Need(cavities, "pin header", f"2 x {2 * job.skin.count}, {PITCH:g} mm", "on the board")
    yield Need(cavities, "board", "by film/strip-board.kicad_mod, FR-4, 1.6 mm", "brings the tabs together")
    yield Need(1, PRIMER, f"{max(1.0, coat):.2g} ml, with a fine brush", "the strips' faces")
    yield Need(1, "isopropanol", f"{math.ceil(ALCOHOL_ML[0] + ALCOHOL_ML[1] * wiped)} ml", "")
    yield Need(wiped, "lint-free wipe", "10 cm or so", "")
    yield Need(1, "low-tack tape", f"acrylic adhesive, {(strips + spare) * masked / 1000:.2g} m", "masks")
    if cast_in:
        yield Need(2 * strips, "weight", f"{rod.hung:.3g} g", "hang on the strips' tabs")
        yield Need(1, "thread", f"{2 * strips * THREAD_LENGTH:.3g} m", "holds the weights")
        yield Need(2, "rod", "3 mm", "for the thread to run over, on one board with the mold")
    else:
        most = strips_per_mix(job)
        mixes, each = math.ceil(strips / most) if most else 1, small_batch(job.silicone)
        yield Need(1, "more silicone", f"{mixes * each:g} g", f"draws the strips in, {mixes} x {each:g} g")
        yield Need(1, "cyanoacrylate", "thin, 1 g", "glues strips to shims")
        yield Need(1, "polythene film", "10 cm or so", "keeps glue off")
        yield Need(1, "flat pliers", "smooth jaws", "draw the shims")
    hung = f"{1000 * pull.force / GRAVITY:.3g} g together"
    yield Need(1, "film clip and weight", hung, f"pull test, on {THREAD_LENGTH:g} m of thread")
