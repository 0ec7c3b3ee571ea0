"""The parts list of a mold: what is made, by which process, and what is bought, by its standard."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from skincad.base.reading import csv_text
from skincad.base.version import __version__
from skincad.fabrication.estimates import PartEstimate, ProcessEstimate, by_part
from skincad.fabrication.fasteners import Screws, cover_screws, dowels, end_screws, mount_of, pin_length
from skincad.fabrication.job import Job
from skincad.fabrication.machine_rules import extent
from skincad.fabrication.part_drawing import general_tolerance, material_words, process_words
from skincad.fabrication.patterns import shim_length
from skincad.fabrication.pouring import pours
from skincad.fabrication.shopping import consumables
from skincad.inputs.catalog import display_name
from skincad.solids.fasteners import METRIC, insert_outer, pin_depth
from skincad.solids.inserts import PIN_RADIUS
from skincad.solids.layout import SQUEEZED_SHARE
from skincad.solids.plan import PartRole, Prism

HEADS = ("item", "quantity", "what", "designation", "made_by", "material", "volume_cm3", "place")
ESTIMATED = ("mass_g", "mass_error_g", "time_h", "time_error_h", "cost_EUR", "cost_error_EUR", "basis")
ORDERED = ("unit", "tolerance", "condition", "design")


SHIM_STEEL = "spring steel 1.4310, hard-rolled"  # assumption: feeler stock is that, or C100S hardened
SHIM_TOLERANCE = "thickness ±5 %, depth ±0.02"  # source: makers' data sheets, precision strip; assumption


class Item(NamedTuple):
    """A row: how many, what, by which standard or of which size, mm, how it is come by, of what; the volume,
    cm3, of one that is made; where it goes; mass g, time h and cost EUR of one that is made, with their
    errors, and the basis of these estimates; the quantity's unit, tolerance, and condition as delivered."""

    quantity: str
    what: str
    designation: str
    made_by: str
    material: str
    volume: str
    place: str
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


def parts_list(job: Job, estimates: tuple[ProcessEstimate, ...] = ()) -> list[Item]:
    """Return what is made, a row for each part with its estimates, then what is bought, the bench's
    consumables last."""
    return [*_made_items(job, by_part(estimates)), *_bought_items(job)]


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


def _bought_items(job: Job) -> Iterator[Item]:
    skin = job.skin
    slot = skin.slot
    lid, ends = cover_screws(job), end_screws(job)
    bent = job.bent
    for screws, place in ((ends, "end plates"), (lid, "cover")):
        if screws is not None and screws.pieces:
            yield from _screws(screws, place)
    if lid is None:
        yield _item(2, "clamp", "", "steel", "cover, held down on the cavity")
    if job.block_process.thread != "tapped":
        inserts = (lid.pieces if lid else 0) + (ends.pieces if bent else 0)
        metric, how = METRIC["M3"], job.block_process.thread
        size = f"M3 x {metric.insert:g}, outer diameter {insert_outer('M3', how):g}, {how}"
        yield _item(inserts, "threaded insert", size, "brass", "printed parts")
    yield from _mount(job)
    for most, count in sorted(dowels(job.closed).items()):
        size = f"ISO 8734 {2 * PIN_RADIUS:g} x {pin_length(most):g}"
        yield _item(count, "dowel pin", size, "steel", f"holes that take {most:g} mm")
    for seal in job.closed.of(PartRole.SEAL):
        if isinstance(seal.body, Prism):
            size = (
                f"sheet of {(seal.body.high - seal.body.low) / SQUEEZED_SHARE:.3g}, cut by drawings/seal.dxf"
            )
            yield _item(1, "seal", size, "closed-cell EVA foam", "under the cover")
    shims = len(job.closed.of(PartRole.SHIM))
    if shims and slot is not None:
        size = f"{slot.thickness:g} x {slot.depth:g} x {shim_length(job):g}"
        yield _item(shims, "shim", size, SHIM_STEEL, "slots", SHIM_TOLERANCE, shim_edges(job))
    grams = dict[str, float]()
    for pour in pours(job):
        grams[pour.silicone.name] = grams.get(pour.silicone.name, 0.0) + pour.batch
    for name, mass in grams.items():
        yield Item(
            quantity=f"{mass:.4g}",
            unit="g",
            what="silicone",
            designation=name,
            made_by="bought",
            material="",
            volume="",
            place="skin, cup and syringe",
        )
    for need in consumables(job):
        row = _item(need.quantity, need.what, need.size, "", need.use, need.tolerance, need.condition)
        yield row._replace(unit=need.unit)


def _screws(screws: Screws, place: str) -> Iterator[Item]:
    what, size = "screw", f"ISO 4762 M3 x {screws.length:g}"
    if screws.rod:
        what, size = "stud", f"DIN 976 M3 x {screws.length:g}"
    yield _item(screws.pieces, what, size, "steel", place)
    if screws.washers:
        yield _item(screws.pieces * screws.washers, "washer", "ISO 7089 3", "steel", place)
    if screws.nuts:
        yield _item(screws.nuts, "nut", "ISO 4032 M3", "steel", place)


def _mount(job: Job) -> Iterator[Item]:
    """What a mount asks for; a screw or a pin is as much longer as what the skin is screwed to is thick."""
    mount = mount_of(job)
    if mount is None or mount.reach is None:
        return
    count, (least, most) = job.design.mold.cavities * len(mount.positions), mount.reach
    size = f"ISO 4762 {mount.thread}, {least:g} to {most:g} in the carrier"
    yield _item(count, "mount screw", size, "steel", "carrier, from the robot's side; no longer")
    if mount.insert:
        name = mount.thread or ""
        outer = f"outer diameter {insert_outer(name, mount.insert):g}"
        size = f"{name} x {METRIC[name].insert:g}, {outer}, {mount.insert}"
        yield _item(count, "threaded insert", size, "brass", "carrier, mount")
    if mount.pin is not None:
        size = f"ISO 8734 {mount.pin:g}, {pin_depth(mount.pin):g} in the carrier"
        yield _item(job.design.mold.cavities, "mount pin", size, "steel", "carrier, from the robot's side")


def shim_edges(job: Job) -> str:
    """Return the condition of a shim's edges: a burr must be less than the clearance in its notch."""
    return f"deburred, burr at most {job.design.mold.slit_clearance / 2:.2g}, all on one face"


def _item(
    quantity: int,
    what: str,
    designation: str,
    material: str,
    place: str,
    tolerance: str = "",
    condition: str = "",
) -> Item:
    return Item(
        quantity=f"{quantity}",
        what=what,
        designation=designation,
        made_by="bought",
        material=material,
        volume="",
        place=place,
        tolerance=tolerance,
        condition=condition,
    )
