"""What is bought for the bench: each thing once, for the casting sheet and for the parts list alike.

Parts that are made, and screws, pins, inserts, foam and shims, follow from the mold (parts_list.py). Here is
what is used up or held in the hand: for mixing and filling, and so that films go in and hold.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from pathlib import PurePath
from typing import NamedTuple

from skincad.base.reading import markdown_text
from skincad.fabrication.electrodes import tab
from skincad.fabrication.fasteners import (
    Screws,
    cover_screws,
    dowels,
    end_screws,
    pin_length,
    screws_to_buy,
)
from skincad.fabrication.job import Job
from skincad.fabrication.papers import listed
from skincad.fabrication.patterns import arc_length, arc_radius, shim_length
from skincad.fabrication.pouring import filling, in_two_pucks, outlet_words, pours, small_batch, veiled
from skincad.fabrication.strips import lap, pull_test, shim_bend, strip, strip_count, strips_per_mix
from skincad.solids.bone import LEAST_GRIP
from skincad.solids.fasteners import BEARING, TAP_RADIUS, standard_below, torque
from skincad.solids.gate import GRAVITY
from skincad.solids.inserts import GRIP, PIN_RADIUS, PITCH
from skincad.solids.layout import SQUEEZED_SHARE, block_fits
from skincad.solids.mold import ClosedMold
from skincad.solids.plan import END_PLATES, Bore, CutRole, PartRole, Prism, bores
from skincad.solids.shots import NECK

PRIMER = "primer that bonds silicone to plastics and metal (silane or titanate type)"
PRIMER_ML = 0.02  # ml/cm2, assumption: a thin coat, most of which stays in the brush
THREAD_LENGTH = 0.3  # m, assumption: over a rod and tied twice
ALCOHOL_ML = 10.0, 0.5  # ml, assumption: spilt, and for each wipe
SPARE_SHARE = 0.1  # assumption: of the strips, for those that crease
TAPE = 0.05  # mm, source: makers' data sheets, polyimide tape with its adhesive
BATHS_ML = 500  # ml, assumption: two baths in a jar that the parts fit in


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
    return [*_in_the_skin(job), *_filling(job), *_bench(job), *_films(job)]


def _in_the_skin(job: Job) -> Iterator[Need]:
    """What keeps pockets free and what goes into them, a bone and what holds it."""
    cores = job.closed.of(PartRole.CORE_PIN)
    if cores and isinstance(rod := cores[0].body, Bore):
        size = f"gauge pin or drill blank {2 * rod.radius:g} x {rod.length:.2f}, lower end square"
        holes = (
            "holes of carrier and plugs" if any(pour.cored for pour in pours(job)) else "holes of the carrier"
        )
        yield Need(len(cores), "core pin", size, f"keeps a pocket free, in the reamed {holes}")
    if (magnet := job.magnet) is not None:
        size = f"{magnet[0]:g} x {magnet[1]:g}, N45, magnetised along its axis, nickel-plated"
        yield Need(len(cores), "magnet", size, "in the pockets, all with the same pole down")
        yield Need(
            1, "polyimide tape", f"{TAPE:g} mm", "round the core pins, in holes that let magnets through"
        )
    if (bone := job.bone) is None:
        return
    many = job.design.mold.cavities
    yield Need(many, "bone", PurePath(bone.body.file).name, "your own, in the skin, where it stays")
    threads: dict[str, list[float]] = {}
    for core, name in job.bone_screws:
        threads.setdefault(name, []).append(core.length)
    for name, lengths in threads.items():
        size = f"ISO 4762 {name}, {standard_below(job.place.back + min(lengths)):g} mm long"
        yield Need(many * len(lengths), "bone screw", size, "through the carrier into the bone")
    if bone.printed and job.bone_out >= LEAST_GRIP:
        yield Need(many, "collar or small clamp", "", "holds the bone up, over the cover")
    elif bone.printed:
        size = f"{bone.end_thread}, with a bar across the cover's window"
        yield Need(many, "screw", size, "holds the bone up")


def _bench(job: Job) -> Iterator[Need]:
    """What parts are made ready with."""
    made = [job.process(part) for part in job.closed.made]
    if any(process.layer for process in made):
        yield Need(1, "sheet of abrasive paper", "400 grit", "laps printed joints, on a glass plate")
        yield Need(1, "petroleum jelly", "a thin coat", "seals printed joints", "g")
    if any(process.thread == "glued" for process in made):
        yield Need(1, "epoxy glue", "", "sets the threaded inserts", "g")
    if bores(job.closed.first(PartRole.CARRIER), CutRole.PULL):
        yield Need(2, "jack screw", "M3, 16 mm long", "lift carrier" + " and plugs" * bool(job.closed.plugs))
    if job.closed.of(PartRole.CORE_PIN) or job.bone:
        yield Need(
            1,
            "wax",
            "",
            "keeps silicone off " + ("core pins" if job.bone is None else "the bone's hold"),
            "g",
        )


def _filling(job: Job) -> Iterator[Need]:
    made = pours(job)
    size = f"clear, {max(pour.cup for pour in made)} ml or more"
    small = (lap(job) is not None) + (job.magnet is not None) + in_two_pucks(job)
    yield Need(len(made) + small, "mixing cup", size, "a mix rises to four times its height")
    if small:
        names = listed([*dict.fromkeys(pour.silicone.name for pour in made)])
        what = [*["a trial puck of each"] * in_two_pucks(job), *["magnets' caps"] * (job.magnet is not None)]
        if what:
            yield Need(
                math.ceil(small_batch(job.silicone)), "more silicone", names, f"for {listed(what)}", "g"
            )
    if job.gate is not None:
        yield Need(1, "syringe", f"{filling(job).syringe} ml, {outlet_words(job.gate)}", "")
        yield Need(1, "plug", f"for a hole of {job.gate:g} mm", "the gate")
    if any(process.layer for process in (job.cavity_process, job.end_process, job.lid_process)):
        yield Need(1, "release agent", "for silicone, with a brush", "printed parts")
    if job.silicone.platinum_cure and any(job.process(part).inhibits_platinum for part in job.closed.made):
        yield Need(BATHS_ML, "isopropanol", "", "washes resin parts", "ml")
    if job.gate is not None and job.riveted:
        yield Need(
            1, "tape", "acrylic adhesive", "bleeds; rubber adhesive, as on crepe tape, inhibits silicone"
        )
    yield Need(1, "pair of gloves", "nitrile", "latex inhibits silicone")
    if filling(job).brushed:
        pins = job.skin.symmetry == "revolved"
        size = f"{min(2.0, job.skin.profile.tip_width):g} mm wide or less" if pins else "2 mm wide or less"
        yield Need(1, "soft brush", size, f"the mix into the {'holes' if pins else 'grooves'}")
    if any(pour.bond == "rivets" for pour in made):
        yield Need(1, "fine brush", f"{2 * NECK:g} mm wide or less", "the mix into the rivets' holes")
    if plugs := veiled(job):
        yield Need(
            5, "parting film", "PVA in solution, with a brush", f"the lower face of {listed(plugs)}", "ml"
        )
    if any(pour.bond == "primer" and front.plug for front, pour in pairwise(made)):
        yield Need(1, "silicone adhesive", "one component", "a layer's back, where its test peels", "tube")
    primed, area = _primed(job)
    if primed:
        many = max(1, math.ceil(PRIMER_ML * area / 100))
        yield Need(many, PRIMER, "with a fine brush", listed(primed), "ml")
    if job.bone is not None or len(made) > 1:
        what = ["the bone"] * (job.bone is not None) + ["the layers' backs"] * (len(made) > 1)
        yield Need(math.ceil(ALCOHOL_ML[0]), "isopropanol", "", f"cleans {listed(what)}", "ml")


def _films(job: Job) -> Iterator[Need]:
    film, slot, rod, pull = job.design.film, job.skin.slot, strip(job), pull_test(job)
    if film is None or slot is None or rod is None or pull is None:
        return
    strips, cavities, cast_in = strip_count(job), job.design.mold.cavities, lap(job) is None
    wiped, spare = strips * (1 if cast_in else 3), math.ceil(SPARE_SHARE * strips)
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


def _primed(job: Job) -> tuple[list[str], float]:
    """What is primed, and about how large that is, mm2: carrier or bone, and the strips' faces."""
    film, slot, skin = job.design.film, job.skin.slot, job.design.skin
    what, area = list[str](), 0.0
    if job.bone is not None and job.design.mold.bone_bond != "rivets":
        what, area = ["the bone"], 3 * float(job.bone.shadow(2, 0.0).area)
    elif job.bone is None and not job.riveted:
        what, area = ["the carrier's lower face"], skin.width * skin.length
    if film is not None and slot is not None:
        strips = strip_count(job)
        what.append("the strips' faces")
        area += 2 * (strips + math.ceil(SPARE_SHARE * strips)) * slot.depth * skin.length
    return what, area


def to_buy(job: Job) -> list[str]:
    """Return what is bought for a mold and its cast, a line each: what holds and seals the mold, what keeps
    slots free, the mount's screws, and what is used up."""
    lengths = ", ".join(f"{count} x {pin_length(size):g} mm" for size, count in dowels(job.closed).items())
    return [
        *_bolts(job),
        *_seal(job.closed),
        f"dowel pins of {2 * PIN_RADIUS:g} mm: {lengths}; {_reamed(job)}",
        *(_arcs if job.bent else _straight_shims)(job),
        *screws_to_buy(job),
        *(markdown_text(need.words) for need in consumables(job)),
    ]


def _bolts(job: Job) -> list[str]:
    """What holds the mold together, as the parts have it."""
    holes = block_fits(job.design)
    hold = f"{holes.insert} inserts in holes of {2 * holes.thread:g} mm" if holes.insert else "tapped holes"
    upper = "two clamps that hold the cover down on the cavity"
    if (lid := cover_screws(job)) is not None:
        kind = "studs, DIN 976, with a nut each" if lid.rod else "screws, ISO 4762"
        upper = f"M3 {kind}: {lid.pieces} M3 x {lid.length:g} for the cover, into {hold}"
        upper += _under_heads(lid.washers)
    makers = {job.maker(part): job.process(part) for part in job.closed.made}
    tightest = min(map(torque, makers.values()))
    tight = (
        f"for the mold's screws a torque of {tightest:g} N m, dry: 0.2 times 3 mm times the tension at which "
        f"a head presses on its part by {BEARING['plastic']:g} MPa (plastic) or {BEARING['metal']:g} MPa "
        "(metal)"
    )
    ends = end_screws(job)
    if not ends.pieces:
        return [upper, tight]
    if job.bent:
        return [_bent_screws(ends, hold), upper, tight]
    sunk = sum(cut.role is CutRole.NUT for p in job.closed.of(*END_PLATES) if p.end == "b" for cut in p.cuts)
    where = f"into M3 threads of end plate b, {2 * TAP_RADIUS:g} mm drilled"
    if ends.nuts > ends.pieces or (ends.nuts and not ends.rod):
        where = f"with nuts, {sunk} of them sunk in end plate b"
    kind = "bolts, ISO 4762"
    if ends.rod:
        kind = f"studs, DIN 976, with a nut {'each' if ends.nuts == ends.pieces else 'at both ends'}"
    return [f"M3 {kind}: {ends.pieces} M3 x {ends.length:g} through both end plates, {where}", upper, tight]


def _seal(closed: ClosedMold) -> list[str]:
    """The foam under the cover, as it is bought and as it lies."""
    highs = [s.body.high - s.body.low for s in closed.of(PartRole.SEAL) if isinstance(s.body, Prism)]
    return [
        f"closed-cell EVA foam, a sheet of {high / SQUEEZED_SHARE:.3g} mm, cut by drawings/seal.dxf to "
        f"carrier{' and end plates' if closed.of(*END_PLATES) else ''} "
        f"with the cover's holes over them; the closed cover squeezes it to {high:.3g} mm, so it follows "
        "what these stand higher or lower by their processes' tolerances"
        for high in highs
    ]


def _reamed(job: Job) -> str:
    """How pin holes are finished."""
    block = "block" if job.closed.of(PartRole.BLOCK) else "cavity"
    printed = [name for name, part in ((block, job.block_process), ("cover", job.lid_process)) if part.layer]
    if not printed:
        return "their holes come reamed from the shop"
    ends = "the end plates and " if job.closed.of(*END_PLATES) else ""
    return (
        f"ream the holes of the printed {listed(printed)} that they are pressed into to {2 * PIN_RADIUS:g} "
        f"mm (H7); in {ends}the {block}'s top they slide"
    )


def _bent_screws(screws: Screws, hold: str) -> str:
    """Return the words for the end plates' screws; `hold` is what they go into."""
    how = ", bottoming tap at last" * screws.bottoming + _under_heads(screws.washers)
    return (
        f"M3 screws, ISO 4762: {screws.pieces} M3 x {screws.length:g} for the end plates, square to the "
        f"cavity's leaning ends, into {hold}{how}"
    )


def _under_heads(washers: int) -> str:
    """Return the words for washers that keep a screw's tip off the end of its hole."""
    return f", {washers} washers under each head" if washers else ""


def _arcs(job: Job) -> list[str]:
    """Return what to buy for the slots: shims cut as arcs, with the radius of each."""
    slot, radius = job.skin.slot, job.design.skin.curvature_radius_y
    if slot is None or radius is None:
        return []
    size = f"{slot.thickness:g} x {slot.depth:g} mm"
    arms = [f"{s.feature} {s.side} {arc_radius(job, s.feature, s.side):.2f}" for s in job.section.slots]
    strain, joint, film = 100 * shim_bend(job), lap(job), job.design.film
    thin = ""
    if joint is not None and film is not None and joint.tail < slot.thickness:
        thin = (
            f", the last {GRIP:g} mm at end {film.wiring_side} thinned to {joint.tail:.3f} mm (etched or "
            "stoned, by micrometer), so that film and shim, glued, pass the notches together"
        )
    return [
        f"{len(arms)} shims of spring steel, {size}, {math.ceil(arc_length(job.closed))} mm long, cut or "
        f"etched as arcs from sheet by film/shims.dxf, deburred{thin}; "
        f"straight stock bent on edge is strained by {strain:.2g} % and buckles between its combs. Radius "
        f"at mid-depth, mm, by ridge and slot: {', '.join(arms)}"
    ]


def _straight_shims(job: Job) -> list[str]:
    """Return what to buy to keep the slots of a skin free that is straight along y."""
    slot = job.skin.slot
    if slot is None or job.design.mold.method == "cast-in":
        return []
    size = f"{slot.thickness:g} x {slot.depth:g} mm"
    return [
        f"{strip_count(job)} shims of spring steel, {size}, {shim_length(job)} mm long: "
        "slit or "
        "etched from feeler stock, edges deburred"
    ]
