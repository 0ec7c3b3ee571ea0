"""Bores and their fits, screws and pins."""

from __future__ import annotations

import math
from collections import Counter
from typing import NamedTuple

from skincad.fabrication.rules import maker
from skincad.inputs.design import Design
from skincad.inputs.process import Process, processes
from skincad.solids.fasteners import (
    LENGTHS,
    METRIC,
    PITCH,
    BlindThread,
    blind_thread,
    screw_for,
    standard_length,
)
from skincad.solids.inserts import PIN_RADIUS
from skincad.solids.layout import cavity_process, fits, lid_process
from skincad.solids.mold import ClosedMold
from skincad.solids.plan import CAVITIES, END_PLATES, PINS, Bore, CutRole, Part, PartRole, bores, unturned
from skincad.solids.shrinkage import scaled_for_shrinkage


class Screw(NamedTuple):
    """A thread's name and major diameter, mm (ISO 261)."""

    name: str
    diameter: float


SCREW = Screw("M3", 3.0)
THREADED = frozenset({CutRole.END_THREAD, CutRole.COVER_THREAD, CutRole.PULL, CutRole.MOUNT})
PINNED = frozenset({CutRole.END_PIN, CutRole.COVER_PIN, CutRole.BASE_PIN})
CLEARING = frozenset({CutRole.END_BOLT, CutRole.COVER_BOLT})
H13 = 0.18  # mm, source: ISO 286-2, of 3 to 6 mm; ISO 273 has it for the medium series of clearance holes
H7 = 0.010  # mm, source: ISO 286-2, up to 3 mm: what a dowel pin m6 is pressed into
_FOR = {
    CutRole.END_BOLT: "M3 bolt of end plate",
    CutRole.END_THREAD: "M3 bolt of end plate",
    CutRole.COVER_BOLT: "M3 bolt of cover",
    CutRole.COVER_THREAD: "M3 bolt of cover",
    CutRole.END_PIN: "of end plate",
    CutRole.COVER_PIN: "of cover",
    CutRole.BASE_PIN: "of base",
    CutRole.GATE: "gate",
    CutRole.VENT: "vent",
    CutRole.RIVET: "silicone rivet",
    CutRole.PULL: "M3 screw to pull by",
    CutRole.MOUNT: "mount",
    CutRole.FIDUCIAL: "fiducial for a camera",
    CutRole.RESERVOIR: "riser cup",
    CutRole.BLEED: "bleed",
}


def process_of(design: Design, part: Part) -> Process:
    """Return the limits of the process that makes a part."""
    return processes(design.printer)[maker(design, part)]


def is_pressed(part: Part, role: CutRole) -> bool:
    """Whether a pin is pressed into this part, and so slides in the other one."""
    return (part.role, role) in {
        (PartRole.COVER, CutRole.COVER_PIN),
        (PartRole.BASE, CutRole.BASE_PIN),
    } or (part.role in CAVITIES and role is CutRole.END_PIN)


def mount_thread(design: Design) -> BlindThread | None:
    """Return the blind threads of a design's mount; None where it has no screws."""
    name = design.mount and design.mount.thread
    return blind_thread(name, lid_process(design)) if name else None


def full_thread(design: Design, role: CutRole) -> float | None:
    """Return how deep a bore has full thread, mm, where that is not all of it."""
    blind = mount_thread(design) if role is CutRole.MOUNT else None
    return blind.most if blind and not blind.insert else None


def major(thread: str) -> float | None:
    """Return the major diameter, mm, of what is tapped; None for an insert's hole and for no thread."""
    name = thread.partition(" ")[0]
    return METRIC[name].diameter if name in METRIC and "insert" not in thread else None


def purpose(design: Design, part: Part, role: CutRole) -> str:
    """Return what goes into a bore."""
    if role is CutRole.MOUNT and design.mount and (blind := mount_thread(design)):
        return f"{design.mount.thread} screw of mount, engages {blind.least:g} to {blind.most:g}"
    if role is CutRole.MOUNT_PIN and design.mount and design.mount.pin:
        return f"pin {design.mount.pin:g} of mount"
    if role in PINNED:
        fit = "pressed" if is_pressed(part, role) else "sliding"
        return f"pin {2 * PIN_RADIUS:g} {_FOR[role]}, {fit}"
    return _FOR[role]


def thread(design: Design, part: Part, role: CutRole) -> str:
    """Return the thread of a bore, or what brings one; "" where it has none."""
    if role not in THREADED:
        return ""
    if role is CutRole.MOUNT and design.mount and (blind := mount_thread(design)):
        how = f"insert, {blind.insert}" if blind.insert else f"x {blind.most:g}"  # deep, by ISO 6410-1
        return f"{design.mount.thread} {how}"
    insert = fits(design, maker(design, part)).insert
    return f"{SCREW.name} insert, {insert}" if insert and role is not CutRole.PULL else SCREW.name


def limits(design: Design, part: Part, role: CutRole) -> str:
    """Return the limits of a bore's diameter, mm: its fit's, where the process keeps it, or the process's."""
    process = process_of(design, part)
    either = f"±{process.tolerance:g}"
    if role in CLEARING:
        return f"+{H13:g}/0 (H13)" if process.tolerance <= H13 / 2 else either
    if role is CutRole.MOUNT_PIN:
        return either if process.layer else f"+{H7:.3f}/0 (H7)"
    if role in PINNED and is_pressed(part, role):
        return either if process.layer else f"+{H7:.3f}/0 (H7)"
    if role in THREADED and (process.thread == "tapped" or role is CutRole.PULL):
        return "6H"
    return either


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
