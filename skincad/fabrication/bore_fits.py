"""What goes into a bore of a part, and from that its thread and the limits of its diameter."""

from __future__ import annotations

from typing import NamedTuple

from skincad.fabrication.rules import maker
from skincad.inputs.design import Design
from skincad.inputs.process import Process, processes
from skincad.solids.fasteners import METRIC, BlindThread, blind_thread
from skincad.solids.inserts import PIN_RADIUS
from skincad.solids.layout import fits, lid_process
from skincad.solids.plan import CAVITIES, CutRole, Part, PartRole


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
