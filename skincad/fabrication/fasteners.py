"""What holds a mold together and what its bores are for: screws, dowels, the mount, threads and fits."""

from __future__ import annotations

import math
from collections import Counter
from typing import NamedTuple

from skincad.base.result import Record, item, record, reported
from skincad.fabrication.job import Job
from skincad.solids.fasteners import (
    LENGTHS,
    METRIC,
    PITCH,
    RUN_OUT,
    BlindThread,
    blind_thread,
    insert_outer,
    screw_for,
    standard_length,
)
from skincad.solids.inserts import PIN_RADIUS
from skincad.solids.lids import core_hole
from skincad.solids.mold import ClosedMold
from skincad.solids.plan import CAVITIES, END_PLATES, PINS, Bore, CutRole, Part, PartRole, bores, unturned

Place = tuple[float, float]  # x and y, mm, from the carrier's middle
THREADED = frozenset({CutRole.END_THREAD, CutRole.COVER_THREAD, CutRole.PULL, CutRole.MOUNT})
PINNED = frozenset({CutRole.END_PIN, CutRole.COVER_PIN, CutRole.BASE_PIN})
CLEARING = frozenset({CutRole.END_BOLT, CutRole.COVER_BOLT})
H13 = 0.18  # mm, source: ISO 286-2, of 3 to 6 mm; ISO 273 has it for the medium series of clearance holes
H7 = 0.010  # mm, source: ISO 286-2, up to 3 mm: what a mount's dowel pin goes into
# source: ISO 286-2, up to 3 mm: P7 is 0.006 to 0.016 below the pin's nominal size, and the hole is drawn 0.01
# below it, the next size of a reamer
PRESSED = "+0.004/-0.006 (P7), ream"
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
    CutRole.PULL: "M3 jack screw",
    CutRole.MOUNT: "mount",
    CutRole.FIDUCIAL: "fiducial for a camera",
    CutRole.RESERVOIR: "riser cup",
    CutRole.BLEED: "bleed",
    CutRole.MARK: "mark, in line with the other part's",
    CutRole.EJECT: "to push the cavity out",
    CutRole.CORE: "core pin, slides in by hand",
    CutRole.BONE_SCREW: "screw into the bone",
    CutRole.ACCESS: "clearance round what stands out of the carrier",
}
NUT = 4.0  # mm, assumption: nut and washer of an M3 bolt
# mm, source: ISO 8734, nominal lengths of parallel pins of 2 mm
PIN_LENGTHS = (5, 6, 8, 10, 12, 14, 16, 18, 20)


SCREW = "M3"


def is_pressed(part: Part, role: CutRole) -> bool:
    """Whether a pin is pressed into this part, and so slides in the other one."""
    lids = {(PartRole.COVER, CutRole.COVER_PIN), (PartRole.BASE, CutRole.BASE_PIN)}
    return (part.role, role) in lids or (part.role in CAVITIES and role is CutRole.END_PIN)


def mount_thread(job: Job) -> BlindThread | None:
    """Return the blind threads of a design's mount; None where it has no screws."""
    name = job.design.mounting and job.design.mounting.thread
    return blind_thread(name, job.lid_process) if name else None


def full_thread(job: Job, part: Part, role: CutRole, depth: float | None) -> float | None:
    """Return how deep a blind bore of this depth has full thread, mm; None for any other bore."""
    if depth is None or role not in THREADED or "insert" in thread(job, part, role):
        return None
    if role is CutRole.MOUNT and (blind := mount_thread(job)):
        return blind.most
    into_ends = role is CutRole.END_THREAD and job.bent
    bottoming = role is CutRole.PULL or (into_ends and end_screws(job).bottoming)
    return depth - (PITCH if bottoming else RUN_OUT)


def thread_words(job: Job, part: Part, role: CutRole, depth: float | None) -> str:
    """Return a thread as a drawing has it: "M3-6H x 5 / Ø2.5 x 7.5", or an insert with its length and outer
    diameter; "" where there is none."""
    name = thread(job, part, role).partition(" ")[0]
    if not name:
        return ""
    metric = METRIC[name]
    if "insert" in thread(job, part, role):
        how = job.process(part).thread
        return f"{name} insert {metric.insert:g} x Ø{insert_outer(name, how):g}, {how}"
    full = full_thread(job, part, role, depth)
    if full is None or depth is None:
        return f"{name}-6H"
    tap = ", bottoming tap" if depth - full < RUN_OUT - 1e-9 else ""
    return f"{name}-6H x {round(full, 2):g} / Ø{metric.drill:g} x {round(depth, 2):g}{tap}"


def major(thread: str) -> float | None:
    """Return the major diameter, mm, of what is tapped; None for an insert's hole and for no thread."""
    name = thread.partition(" ")[0]
    return METRIC[name].diameter if name in METRIC and "insert" not in thread else None


def purpose(job: Job, part: Part, role: CutRole) -> str:
    """Return what goes into a bore."""
    if role is CutRole.MOUNT and job.design.mounting and (blind := mount_thread(job)):
        return f"{job.design.mounting.thread} screw of mount, engages {blind.least:g} to {blind.most:g}"
    if role is CutRole.MOUNT_PIN and job.design.mounting and job.design.mounting.pin:
        return f"pin {job.design.mounting.pin:g} of mount"
    if role in PINNED:
        fit = "press fit" if is_pressed(part, role) else "sliding fit"
        return f"dowel Ø{2 * PIN_RADIUS:g} {_FOR[role]}, {fit}"
    return _FOR[role]


def threads(job: Job) -> list[tuple[str, str, str, list[str]]]:
    """Return the threads that are still to be made, by what brings them: a shop taps those of metal.

    Of those that come alike: their name, how their inserts are set, "" where they are tapped, how deep, ""
    where that is all of their holes, and the parts that have them.
    """
    where: dict[str, list[str]] = {}
    for part in job.closed.made:
        process = job.process(part)
        for role in sorted(THREADED, key=lambda role: role.name):
            # a shop that cuts metal cuts its threads too
            if bores(part, role) and (process.layer or process.thread != "tapped"):
                names = where.setdefault(thread(job, part, role), [])
                names += [part.name] * (part.name not in names)
    rows = []
    for what, names in where.items():
        kind, _, how = what.partition(" insert, ")
        name, _, deep = what.partition(" x ")
        rows.append((kind if how else name, how, "" if how else deep, names))
    return rows


def press_fits(job: Job) -> list[str]:
    """Return the parts into which dowels are pressed."""
    return [p.name for p in job.closed.made if any(is_pressed(p, r) and bores(p, r) for r in PINNED)]


def thread(job: Job, part: Part, role: CutRole) -> str:
    """Return the thread of a bore, or what brings one; "" where it has none."""
    if role not in THREADED:
        return ""
    if role is CutRole.MOUNT and job.design.mounting and (blind := mount_thread(job)):
        how = f"insert, {blind.insert}" if blind.insert else f"x {blind.most:g}"  # deep, by ISO 6410-1
        return f"{job.design.mounting.thread} {how}"
    insert = job.fits(part).insert
    return f"{SCREW} insert, {insert}" if insert and role is not CutRole.PULL else SCREW


def limits(job: Job, part: Part, role: CutRole) -> str:
    """Return the limits of a bore's diameter, mm: its fit's, where the process keeps it, or the process's;
    "" where the general tolerance does."""
    process = job.process(part)
    either, general = f"±{process.tolerance:g}", f"±{process.tolerance:g}" if process.layer else ""
    if role in CLEARING:
        return f"+{H13:g}/0 (H13)" if process.tolerance <= H13 / 2 else either
    pressed = role in PINNED and is_pressed(part, role)
    if process.layer and (pressed or role is CutRole.CORE):
        wide = 2 * PIN_RADIUS if pressed else core_hole(job.design)
        return f"we ream Ø{wide:g} H7"
    if pressed:
        return PRESSED
    if role in (CutRole.MOUNT_PIN, CutRole.CORE):
        return either if process.layer else f"+{H7:.3f}/0 (H7)"
    if role in THREADED and (process.thread == "tapped" or role is CutRole.PULL):
        return "6H"
    return either if role in (*PINNED, *THREADED) else general


class Screws(NamedTuple):
    """Equal M3 screws: how many, their length, mm, washers under each head, nuts in all, and how many of
    these are sunk. `bottoming` asks for a bottoming tap at last."""

    pieces: int
    length: float
    washers: int = 0
    nuts: int = 0
    bottoming: bool = False
    sunk: int = 0

    @property
    def rod(self) -> bool:
        """Whether there are none so long: studs, with nuts where a screw would have its head or nut."""
        return self.length > LENGTHS[-1]


def cover_screws(job: Job) -> Screws | None:
    """Return the cover's screws; None where clamps hold it."""
    cover, blocks = job.closed.first(PartRole.COVER), job.closed.of(PartRole.BLOCK, *CAVITIES)
    screws = bores(cover, CutRole.COVER_BOLT)
    if not screws:
        return None
    passed = max((b.length for p in blocks for b in bores(p, CutRole.COVER_BOLT)), default=0.0)
    thread_length = max(b.length for p in blocks for b in bores(p, CutRole.COVER_THREAD))
    split = bool(job.closed.of(PartRole.BASE))
    long, washers = screw_for(screws[0].length + passed, thread_length, job.block_process, bottomed=split)
    studs = long > LENGTHS[-1]
    return Screws(len(screws), long + (NUT if studs else 0.0), washers, len(screws) if studs else 0)


def end_screws(job: Job) -> Screws:
    """Return the end plates' screws: along y through both plates, or, of a doubly curved mold, into each of
    the cavity's ends; no pieces where there are no end plates."""
    if not job.closed.of(*END_PLATES):
        return Screws(0, 0.0)
    if job.bent:
        count = sum(len(bores(plate, CutRole.END_BOLT)) for plate in job.closed.of(*END_PLATES))
        threads = bores(job.closed.first(PartRole.CAVITY), CutRole.END_THREAD)
        process, plate, deep = job.cavity_process, job.design.mold.end_plate, min(b.length for b in threads)
        long, washers = screw_for(plate, deep, process, bottomed=True)
        bottoming = process.thread == "tapped" and screw_for(plate, deep, process)[1] > washers
        return Screws(count, long, washers, bottoming=bottoming)
    cuts = [cut.role for part in job.closed.of(*END_PLATES) if part.end == "b" for cut in part.cuts]
    sunk, tapped = cuts.count(CutRole.NUT), cuts.count(CutRole.END_THREAD)
    count = cuts.count(CutRole.END_BOLT) + tapped
    through = job.cast.skin.length + 2 * job.design.mold.end_plate
    long = standard_length(through + (0 if tapped else PITCH if sunk == count else NUT + PITCH))
    if long <= LENGTHS[-1]:
        return Screws(count, long, nuts=0 if tapped else count, sunk=sunk)
    return Screws(count, math.ceil(long + NUT), nuts=count * (1 if tapped else 2), sunk=sunk)


def dowels(closed: ClosedMold) -> dict[float, int]:
    """Return how many dowels there are of each greatest length, mm, whole tenths."""
    pins = (unturned(part).body for part in closed.of(*PINS))
    return dict(Counter(math.floor(10 * pin.length) / 10 for pin in pins if isinstance(pin, Bore)))


def pin_length(most: float) -> float:
    """Return the longest standard pin of at most this length, mm; below the shortest, what one is cut to."""
    return max((float(length) for length in PIN_LENGTHS if length <= most), default=most)


@record()
class CarrierMount(Record):
    """A mount as the carrier has it; lengths mm. Where there are no screws, `thread`, `depth` of its hole and
    `reach`, from how far to how far a screw may go in, are None."""

    thread: str | None = item(meaning="of the screws")
    insert: str = item(meaning="how it is set, null where the thread is tapped", null=True)
    depth: float | None = item("mm", "of the hole")
    reach: tuple[float, float] | None = item("mm", "how far a screw goes in", key="engagement_mm")
    positions: tuple[Place, ...] = item("mm", "of the screws")
    pin: float | None = item("mm", "its diameter")
    pin_position: Place | None = item("mm", "of the pin")
    fiducials: tuple[Place, ...] = item("mm", "of the marks")
    fiducial_diameter: float
    top: float = item("mm", "where all of them open, over the skin's back")

    @reported("mm", "of the marks", key="fiducial_diameter_mm")
    def _fiducial_diameter(self) -> float | None:
        return self.fiducial_diameter if self.fiducials else None


def mount_of(job: Job) -> CarrierMount | None:
    """Return a design's mount, as the first carrier has it; None without one."""
    mount = job.design.mounting
    if mount is None:
        return None
    carrier, blind = job.closed.first(PartRole.CARRIER), mount_thread(job)
    middle = sum(bore.start[0] for bore in bores(carrier, CutRole.VENT))  # a gang's first skin lies aside

    def places(role: CutRole) -> tuple[Place, ...]:
        starts = [bore.start for bore in bores(carrier, role)]
        return tuple((round(x - middle, 9) + 0.0, round(y, 9) + 0.0) for x, y, _ in starts)

    pins, marks = places(CutRole.MOUNT_PIN), places(CutRole.FIDUCIAL)
    every = bores(carrier, CutRole.MOUNT, CutRole.FIDUCIAL)
    return CarrierMount(
        thread=mount.thread,
        insert=blind.insert if blind else "",
        depth=blind and blind.depth,
        reach=(blind.least, blind.most) if blind else None,
        positions=places(CutRole.MOUNT),
        pin=mount.pin,
        pin_position=pins[0] if pins else None,
        fiducials=marks,
        fiducial_diameter=mount.fiducial_diameter,
        top=every[0].start[2] + every[0].length,
    )
