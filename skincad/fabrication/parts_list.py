"""The parts list of a mold: what is made, by which process, and what is bought, by its standard.

What is bought for the bench stands once, for the casting sheet and for the parts list alike: what is used up
or held in the hand, for mixing and filling, and so that films go in and hold.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from functools import lru_cache
from pathlib import PurePath
from typing import Any, NamedTuple

from skincad.base.errors import shown
from skincad.base.reading import csv_text
from skincad.base.version import __version__
from skincad.fabrication import electrodes, fasteners, films, patterns, pouring, rules, strips
from skincad.fabrication.estimates import PartEstimate, ProcessEstimate, by_part
from skincad.fabrication.job import Job
from skincad.fabrication.machine_rules import extent
from skincad.fabrication.papers import cell, cells, macro
from skincad.fabrication.part_drawing import general_tolerance, material_words, process_words
from skincad.inputs.catalog import display_name
from skincad.solids import fasteners as threads
from skincad.solids import inserts, layout
from skincad.solids.bone import LEAST_GRIP
from skincad.solids.plan import CutRole, PartRole
from skincad.solids.shots import NECK

HEADS = ("item", "quantity", "what", "designation", "made_by", "material", "volume_cm3", "place")
ESTIMATED = ("mass_g", "mass_error_g", "time_h", "time_error_h", "cost_EUR", "cost_error_EUR", "basis")
ORDERED = ("unit", "tolerance", "condition", "design")
PRIMER = "primer that bonds silicone to plastics and metal (silane or titanate type)"
PRIMER_ML = 0.02  # ml/cm2, assumption: a thin coat, most of which stays in the brush
THREAD_LENGTH = 0.3  # m, assumption: over a rod and tied twice
ALCOHOL_ML = 10.0, 0.5  # ml, assumption: spilt, and for each wipe
SPARE_SHARE = 0.1  # assumption: of the strips, for those that crease
TAPE = 0.05  # mm, source: makers' data sheets, polyimide tape with its adhesive
BATHS_ML = 500  # ml, assumption: two baths in a jar that the parts fit in
STRIP_FACES = "the strips' faces"


class Item(NamedTuple):
    """A row: how many, what, by which standard or of which size, mm, how it is come by, of what; the volume,
    cm3, of one that is made; where it goes or what for; mass g, time h and cost EUR of one that is made, with
    their errors, and the basis of these estimates; the quantity's unit, tolerance, and condition as
    delivered."""

    quantity: str
    what: str
    designation: str
    made_by: str = "bought"
    material: str = ""
    volume: str = ""
    place: str = ""
    mass: str = ""
    mass_error: str = ""
    time: str = ""
    time_error: str = ""
    cost: str = ""
    cost_error: str = ""
    basis: str = ""
    unit: str = "pcs"
    tolerance: str = ""
    condition: str = ""

    @property
    def words(self) -> str:
        """What is bought, as the casting sheet has it."""
        what = f"{self.quantity} {self.what}s" if self.quantity != "1" else self.what
        if self.unit != "pcs":
            what = f"{self.quantity} {self.unit} of {self.what}"
        size = f", {self.designation}" if self.designation else ""
        return f"{what}{size}" + (f": {self.place}" if self.place else "")


def facts(job: Job) -> dict[str, Any]:
    """Return what a bench's papers ask: the job, and the modules that plan it by their names there."""
    return {
        "job": job,
        "role": PartRole,
        "cut": CutRole,
        "buying": sys.modules[__name__],
        "electrodes": electrodes,
        "fastening": fasteners,
        "films": films,
        "inserts": inserts,
        "layout": layout,
        "patterns": patterns,
        "pouring": pouring,
        "rules": rules,
        "strips": strips,
        "threads": threads,
        "LEAST_GRIP": LEAST_GRIP,
    }


@lru_cache(maxsize=4)  # a job's orders, drawings and sheet ask for the same rows
def _rows(job: Job, name: str) -> tuple[Item, ...]:
    """The rows of one of parts-list.txt's macros."""
    (primed, area), grams = _primed(job), dict[str, float]()
    for pour in pouring.pours(job):
        name_cell = cell(pour.silicone.name)
        grams[name_cell] = grams.get(name_cell, 0.0) + pour.batch
    lines = macro(
        "papers/parts-list.txt",
        name,
        **facts(job),
        ceil=math.ceil,
        grams=grams,
        processes=[job.process(part) for part in job.closed.made],
        bone_file=cell(shown(PurePath(job.bone.body.file).name)) if job.bone else "",
        primed=primed,
        primed_area=area,
        NECK=NECK,
    ).splitlines()
    items = []
    for quantity, what, size, place, *more in map(cells, lines):
        known = {key: value for key, _, value in (part.partition("=") for part in more)}
        items.append(Item(quantity, what, size, place=place, **known))
    return tuple(items)


def parts_list(job: Job, estimates: tuple[ProcessEstimate, ...] = ()) -> list[Item]:
    """Return what is made, a row for each part with its estimates, then what is bought, the bench's
    consumables last."""
    return [*_made_items(job, by_part(estimates)), *_rows(job, "stock"), *consumables(job)]


def parts_csv(job: Job, estimates: tuple[ProcessEstimate, ...] = ()) -> str:
    """Return the parts list as CSV, lengths in mm; its last column is the design's name and revision."""
    design = f"{display_name(job.design)}, revision {job.design.revision}, skincad {__version__}"
    rows = [(number, *item, design) for number, item in enumerate(parts_list(job, estimates), 1)]
    return csv_text([(*HEADS, *ESTIMATED, *ORDERED), *rows])


def _made_items(job: Job, estimates: dict[str, PartEstimate]) -> Iterator[Item]:
    for part in job.closed.made:
        size = " x ".join(f"{side:.2f}" for side in extent(part))
        volume, by = f"{part.volume / 1000:.4g}", process_words(job, part)
        details = material_words(job, part), volume, part.what
        cells = [""] * len(ESTIMATED)
        if (took := estimates.get(part.name)) is not None:
            numbers = [n for e in (took.mass, took.time, took.cost) for n in (float(e), e.error or 0.0)]
            cells = [*(f"{number:.4g}" for number in numbers), took.basis]
        limits, edges = general_tolerance(job, part), "as its drawing says"
        row = Item("1", part.name, size, by, *details, *cells)
        yield row._replace(tolerance=limits, condition=edges)


def consumables(job: Job) -> tuple[Item, ...]:
    """Return what is used up in a cast, and small tools for it."""
    return _rows(job, "consumables")


def _primed(job: Job) -> tuple[list[str], float]:
    """What is primed, and about how large that is, mm2: carrier or bone, and the strips' faces."""
    film, slot, skin = job.design.film, job.skin.slot, job.design.skin
    what, area = list[str](), 0.0
    if job.bone is not None and job.design.mold.bone_bond != "rivets":
        what, area = ["the bone"], 3 * float(job.bone.shadow(2, 0.0).area)
    elif job.bone is None and not job.riveted:
        what = ["the carrier's lower face"]
        area = skin.area
    area *= job.design.mold.cavities
    if film is not None and slot is not None:
        count = strips.strip_count(job)
        what.append(STRIP_FACES)
        area += 2 * (count + math.ceil(SPARE_SHARE * count)) * slot.depth * skin.length
    return what, area
