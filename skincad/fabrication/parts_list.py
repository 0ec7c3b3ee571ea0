"""The parts list of a mold: what is made, by which process, and what is bought, by its standard.

What is bought for the bench stands once, for the casting sheet and for the parts list alike: what is used up
or held in the hand, for mixing and filling, and so that films go in and hold.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from pathlib import PurePath
from typing import NamedTuple

from skincad.base.reading import csv_text
from skincad.base.version import __version__
from skincad.fabrication.electrodes import tab
from skincad.fabrication.estimates import PartEstimate, ProcessEstimate, by_part
from skincad.fabrication.fasteners import Screws, cover_screws, dowels, end_screws, mount_of, pin_length
from skincad.fabrication.job import Job
from skincad.fabrication.machine_rules import extent
from skincad.fabrication.papers import listed
from skincad.fabrication.part_drawing import general_tolerance, material_words, process_words
from skincad.fabrication.patterns import shim_length
from skincad.fabrication.pouring import (
    LayerPour,
    filling,
    in_two_pucks,
    outlet_words,
    pours,
    small_batch,
    veiled,
)
from skincad.fabrication.strips import lap, pull_test, strip, strip_count, strips_per_mix
from skincad.inputs.catalog import display_name
from skincad.solids.bone import LEAST_GRIP
from skincad.solids.fasteners import METRIC, insert_outer, pin_depth, standard_below
from skincad.solids.gate import GRAVITY
from skincad.solids.inserts import PIN_RADIUS, PITCH
from skincad.solids.layout import SQUEEZED_SHARE
from skincad.solids.plan import Bore, CutRole, PartRole, Prism, bores
from skincad.solids.shots import NECK

HEADS = ("item", "quantity", "what", "designation", "made_by", "material", "volume_cm3", "place")
ESTIMATED = ("mass_g", "mass_error_g", "time_h", "time_error_h", "cost_EUR", "cost_error_EUR", "basis")
ORDERED = ("unit", "tolerance", "condition", "design")
SHIM_STEEL = "spring steel 1.4310, hard-rolled"  # assumption: feeler stock is that, or C100S hardened
SHIM_TOLERANCE = "thickness ±5 %, depth ±0.02"  # source: makers' data sheets, precision strip; assumption
PRIMER = "primer that bonds silicone to plastics and metal (silane or titanate type)"
PRIMER_ML = 0.02  # ml/cm2, assumption: a thin coat, most of which stays in the brush
THREAD_LENGTH = 0.3  # m, assumption: over a rod and tied twice
ALCOHOL_ML = 10.0, 0.5  # ml, assumption: spilt, and for each wipe
SPARE_SHARE = 0.1  # assumption: of the strips, for those that crease
TAPE = 0.05  # mm, source: makers' data sheets, polyimide tape with its adhesive
BATHS_ML = 500  # ml, assumption: two baths in a jar that the parts fit in


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


def _bought(
    quantity: int, what: str, designation: str = "", place: str = "", unit: str = "pcs", **cells: str
) -> Item:
    return Item(f"{quantity}", what, designation, place=place, unit=unit, **cells)


def parts_list(job: Job, estimates: tuple[ProcessEstimate, ...] = ()) -> list[Item]:
    """Return what is made, a row for each part with its estimates, then what is bought, the bench's
    consumables last."""
    return [*_made_items(job, by_part(estimates)), *_bought_items(job), *consumables(job)]


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
    """What holds and seals the mold and keeps slots free, the mount's screws, and the silicone."""
    slot, lid, ends = job.skin.slot, cover_screws(job), end_screws(job)
    for screws, place in ((ends, "end plates"), (lid, "cover")):
        if screws is not None and screws.pieces:
            yield from _screws(screws, place)
    if lid is None:
        yield _bought(2, "clamp", "", "cover, held down on the cavity", material="steel")
    if job.block_process.thread != "tapped":
        inserts = (lid.pieces if lid else 0) + (ends.pieces if job.bent else 0)
        metric, how = METRIC["M3"], job.block_process.thread
        size = f"M3 x {metric.insert:g}, outer diameter {insert_outer('M3', how):g}, {how}"
        yield _bought(inserts, "threaded insert", size, "printed parts", material="brass")
    yield from _mount(job)
    for most, count in sorted(dowels(job.closed).items()):
        size = f"ISO 8734 {2 * PIN_RADIUS:g} x {pin_length(most):g}"
        yield _bought(count, "dowel pin", size, f"holes that take {most:g} mm", material="steel")
    for seal in job.closed.of(PartRole.SEAL):
        if isinstance(seal.body, Prism):
            sheet = (seal.body.high - seal.body.low) / SQUEEZED_SHARE
            size = f"sheet of {sheet:.3g}, cut by drawings/seal.dxf"
            yield _bought(1, "seal", size, "under the cover", material="closed-cell EVA foam")
    shims = len(job.closed.of(PartRole.SHIM))
    if shims and slot is not None:
        size = f"{slot.thickness:g} x {slot.depth:g} x {shim_length(job):g}"
        # a burr must be less than the clearance in its notch
        edges = f"deburred, burr at most {job.design.mold.slit_clearance / 2:.2g}, all on one face"
        cells = {"material": SHIM_STEEL, "tolerance": SHIM_TOLERANCE, "condition": edges}
        yield _bought(shims, "shim", size, "slots", **cells)
    grams = dict[str, float]()
    for pour in pours(job):
        grams[pour.silicone.name] = grams.get(pour.silicone.name, 0.0) + pour.batch
    for name, mass in grams.items():
        yield Item(f"{mass:.4g}", "silicone", name, place="skin, cup and syringe", unit="g")


def _screws(screws: Screws, place: str) -> Iterator[Item]:
    what, size = ("stud", "DIN 976") if screws.rod else ("screw", "ISO 4762")
    rows = [(screws.pieces, what, f"{size} M3 x {screws.length:g}")]
    rows += [(screws.pieces * screws.washers, "washer", "ISO 7089 3"), (screws.nuts, "nut", "ISO 4032 M3")]
    yield from (_bought(*row, place, material="steel") for row in rows if row[0])


def _mount(job: Job) -> Iterator[Item]:
    """What a mount asks for; a screw or a pin is as much longer as what the skin is screwed to is thick."""
    mount, robot = mount_of(job), "carrier, from the robot's side"
    if mount is None or mount.reach is None:
        return
    count, (least, most) = job.design.mold.cavities * len(mount.positions), mount.reach
    size = f"ISO 4762 {mount.thread}, {least:g} to {most:g} in the carrier"
    yield _bought(count, "mount screw", size, f"{robot}; no longer", material="steel")
    if mount.insert:
        name = mount.thread or ""
        outer = f"outer diameter {insert_outer(name, mount.insert):g}"
        size = f"{name} x {METRIC[name].insert:g}, {outer}, {mount.insert}"
        yield _bought(count, "threaded insert", size, "carrier, mount", material="brass")
    if mount.pin is not None:
        size = f"ISO 8734 {mount.pin:g}, {pin_depth(mount.pin):g} in the carrier"
        yield _bought(job.design.mold.cavities, "mount pin", size, robot, material="steel")


def consumables(job: Job) -> list[Item]:
    """Return what is used up in a cast, and small tools for it."""
    return [*_in_the_skin(job), *_filling(job), *_bench(job), *_films(job)]


def _in_the_skin(job: Job) -> Iterator[Item]:
    """What keeps pockets free and what goes into them, a bone and what holds it."""
    cores = job.closed.of(PartRole.CORE_PIN)
    if cores and isinstance(rod := cores[0].body, Bore):
        size = f"gauge pin or drill blank {2 * rod.radius:g} x {rod.length:.2f}, lower end square"
        holes = (
            "holes of carrier and plugs" if any(pour.cored for pour in pours(job)) else "holes of the carrier"
        )
        yield _bought(len(cores), "core pin", size, f"keeps a pocket free, in the reamed {holes}")
    if (magnet := job.magnet) is not None:
        size = f"{magnet[0]:g} x {magnet[1]:g}, N45, magnetised along its axis, nickel-plated"
        yield _bought(len(cores), "magnet", size, "in the pockets, all with the same pole down")
        yield _bought(
            1, "polyimide tape", f"{TAPE:g} mm", "round the core pins, in holes that let magnets through"
        )
    if (bone := job.bone) is None:
        return
    many = job.design.mold.cavities
    yield _bought(many, "bone", PurePath(bone.body.file).name, "your own, in the skin, where it stays")
    threads: dict[str, list[float]] = {}
    for core, name in job.bone_screws:
        threads.setdefault(name, []).append(core.length)
    for name, lengths in threads.items():
        size = f"ISO 4762 {name}, {standard_below(job.place.back + min(lengths)):g} mm long"
        yield _bought(many * len(lengths), "bone screw", size, "through the carrier into the bone")
    if bone.printed and job.bone_out >= LEAST_GRIP:
        yield _bought(many, "collar or small clamp", "", "holds the bone up, over the cover")
    elif bone.printed:
        size = f"{bone.end_thread}, with a bar across the cover's window"
        yield _bought(many, "screw", size, "holds the bone up")


def _bench(job: Job) -> Iterator[Item]:
    """What parts are made ready with."""
    made = [job.process(part) for part in job.closed.made]
    if any(process.layer for process in made):
        yield _bought(1, "sheet of abrasive paper", "400 grit", "laps printed joints, on a glass plate")
        yield _bought(1, "petroleum jelly", "a thin coat", "seals printed joints", "g")
    if any(process.thread == "glued" for process in made):
        yield _bought(1, "epoxy glue", "", "sets the threaded inserts", "g")
    if bores(job.closed.first(PartRole.CARRIER), CutRole.PULL):
        yield _bought(
            2, "jack screw", "M3, 16 mm long", "lift carrier" + " and plugs" * bool(job.closed.plugs)
        )
    if job.closed.of(PartRole.CORE_PIN) or job.bone:
        yield _bought(
            1,
            "wax",
            "",
            "keeps silicone off " + ("core pins" if job.bone is None else "the bone's hold"),
            "g",
        )


def _filling(job: Job) -> Iterator[Item]:
    made = pours(job)
    size = f"clear, {max(pour.cup for pour in made)} ml or more"
    small = (lap(job) is not None) + (job.magnet is not None) + in_two_pucks(job)
    yield _bought(len(made) + small, "mixing cup", size, "a mix rises to four times its height")
    if small:
        names = listed([*dict.fromkeys(pour.silicone.name for pour in made)])
        what = [*["a trial puck of each"] * in_two_pucks(job), *["magnets' caps"] * (job.magnet is not None)]
        if what:
            yield _bought(
                math.ceil(small_batch(made[-1].silicone)), "more silicone", names, f"for {listed(what)}", "g"
            )
    if job.gate is not None:
        yield _bought(1, "syringe", f"{filling(job).syringe} ml, {outlet_words(job.gate)}", "")
        yield _bought(1, "plug", f"for a hole of {job.gate:g} mm", "the gate")
    if any(process.layer for process in (job.cavity_process, job.end_process, job.lid_process)):
        yield _bought(1, "release agent", "for silicone, with a brush", "printed parts")
    elif job.bone is not None or (job.inserts == "shims" and job.design.film is None):
        bare = "the carrier's lower face" if job.bone else "shims"
        yield _bought(1, "release agent", "for silicone, with a brush", bare)
    if job.silicone.platinum_cure and any(job.process(part).inhibits_platinum for part in job.closed.made):
        yield _bought(BATHS_ML, "isopropanol", "", "washes resin parts", "ml")
    if job.gate is not None and job.riveted:
        yield _bought(
            1, "tape", "acrylic adhesive", "bleeds; rubber adhesive, as on crepe tape, inhibits silicone"
        )
    yield _bought(1, "pair of gloves", "nitrile", "latex inhibits silicone")
    if filling(job).brushed:
        pins = job.skin.symmetry == "revolved"
        size = f"{min(2.0, job.skin.profile.tip_width):g} mm wide or less" if pins else "2 mm wide or less"
        yield _bought(1, "soft brush", size, f"the mix into the {'holes' if pins else 'grooves'}")
    yield from _between(job, made)


STRIP_FACES = "the strips' faces"


def _between(job: Job, made: list[LayerPour]) -> Iterator[Item]:
    """What layers, a carrier and a bone are made ready with."""
    if any(pour.bond == "rivets" for pour in made):
        yield _bought(1, "fine brush", f"{2 * NECK:g} mm wide or less", "the mix into the rivets' holes")
    if plugs := veiled(job):
        yield _bought(
            5, "parting film", "PVA in solution, with a brush", f"the lower face of {listed(plugs)}", "ml"
        )
    if any(pour.bond == "primer" and front.plug for front, pour in pairwise(made)):
        yield _bought(1, "silicone adhesive", "one component", "a layer's back, where its test peels", "tube")
    primed, area = _primed(job)
    if primed:
        many = max(1, math.ceil(PRIMER_ML * area / 100))
        yield _bought(many, PRIMER, "with a fine brush", listed(primed), "ml")
    cleaned = [what for what in primed if what != STRIP_FACES]
    cleaned += ["the bone"] * (job.bone is not None and not cleaned)
    cleaned += ["the layers' backs"] * (len(made) > 1)
    if cleaned:
        yield _bought(math.ceil(ALCOHOL_ML[0]), "isopropanol", "", f"cleans {listed(cleaned)}", "ml")


def _films(job: Job) -> Iterator[Item]:
    film, slot, rod, pull = job.design.film, job.skin.slot, strip(job), pull_test(job)
    if film is None or slot is None or rod is None or pull is None:
        return
    strips, cavities, cast_in = strip_count(job), job.design.mold.cavities, lap(job) is None
    wiped, spare = strips * (1 if cast_in else 3), math.ceil(SPARE_SHARE * strips)
    masked = 2 * (job.lead + tab(film)[1] + (20 if cast_in else 0))  # mm, folded over
    sheets = f"film/strips.dxf {cavities} times" if cavities > 1 else "film/strips.dxf"
    yield _bought(
        strips,
        "film strip",
        f"PVDF, {1000 * film.thickness:.0f} µm, sputtered metal on both faces, and {spare} to spare",
        f"cut by {sheets}, its + side up",
        tolerance=f"cut ±{film.cut_tolerance:g}, faces registered ±{film.registration:g}",
        condition="poled, draw axis along the strips; cut edges free of metal burrs",
    )
    yield _bought(2 * strips, "crimp contact", f"for flat cable, {PITCH:g} mm apart", "one for each pad")
    backing = math.ceil(strips * (tab(film)[1] + 2) / 10)
    yield _bought(backing, "polyester tape", "0.1 mm", "backs the pads: bare film tears in a crimp", "cm")
    yield _bought(cavities, "pin header", f"2 x {2 * job.skin.count}, {PITCH:g} mm", "on the board")
    yield _bought(
        cavities,
        "board",
        "by film/strip-board.kicad_mod, FR-4, 1.6 mm",
        "brings the tabs together",
        tolerance="thickness ±10 %",
        condition="tinned or gold pads",
    )
    yield _bought(
        math.ceil(ALCOHOL_ML[0] + ALCOHOL_ML[1] * wiped), "isopropanol", "", "wipes strips and shims", "ml"
    )
    yield _bought(wiped, "lint-free wipe", "10 cm or so", "")
    tape = math.ceil((strips + spare) * masked / 10)
    yield _bought(tape, "low-tack tape", "acrylic adhesive", "masks", "cm")
    if cast_in:
        yield _bought(2 * strips, "weight", f"{rod.hung:.3g} g", "hang on the strips' tabs")
        yield _bought(math.ceil(2 * strips * THREAD_LENGTH), "thread", "", "holds the weights", "m")
        yield _bought(2, "rod", "3 mm", "for the thread to run over, on one board with the mold")
    else:
        most = strips_per_mix(job)
        mixes, each = math.ceil(strips / most) if most else 1, small_batch(job.silicone)
        more = math.ceil(mixes * each)
        yield _bought(
            more, "more silicone", job.silicone.name, f"draws the strips in, {mixes} x {each:g} g", "g"
        )
        yield _bought(1, "cyanoacrylate", "thin", "glues strips to shims", "g")
        yield _bought(1, "polythene film", "10 cm or so", "keeps glue off")
        yield _bought(1, "flat pliers", "smooth jaws", "draw the shims")
    hung = f"{1000 * pull.force / GRAVITY:.3g} g together"
    yield _bought(1, "film clip and weight", hung, f"pull test, on {THREAD_LENGTH:g} m of thread")


def _primed(job: Job) -> tuple[list[str], float]:
    """What is primed, and about how large that is, mm2: carrier or bone, and the strips' faces."""
    film, slot, skin = job.design.film, job.skin.slot, job.design.skin
    what, area = list[str](), 0.0
    if job.bone is not None and job.design.mold.bone_bond != "rivets":
        what, area = ["the bone"], 3 * float(job.bone.shadow(2, 0.0).area)
    elif job.bone is None and not job.riveted:
        what, area = (
            ["the carrier's lower face"],
            skin.width * skin.length * (math.pi / 4 if skin.round else 1),
        )
    area *= job.design.mold.cavities
    if film is not None and slot is not None:
        strips = strip_count(job)
        what.append(STRIP_FACES)
        area += 2 * (strips + math.ceil(SPARE_SHARE * strips)) * slot.depth * skin.length
    return what, area
