"""What goes into a bore of a part, and from that its thread and the limits of its diameter."""

from __future__ import annotations

from typing import NamedTuple

from skincad.fabrication.rules import maker
from skincad.inputs.design import Design
from skincad.inputs.process import Process, processes
from skincad.solids.inserts import PIN_RADIUS
from skincad.solids.layout import fits
from skincad.solids.plan import Part
from skincad.solids.roles import CAVITIES, CutRole, PartRole


class Screw(NamedTuple):
    """A thread's name and major diameter, mm (ISO 261)."""

    name: str
    diameter: float


SCREW = Screw("M3", 3.0)
THREADED = frozenset({CutRole.END_THREAD, CutRole.COVER_THREAD, CutRole.PULL})
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


def purpose(part: Part, role: CutRole) -> str:
    """Return what goes into a bore."""
    if role in PINNED:
        fit = "pressed" if is_pressed(part, role) else "sliding"
        return f"pin {2 * PIN_RADIUS:g} {_FOR[role]}, {fit}"
    return _FOR[role]


def thread(design: Design, part: Part, role: CutRole) -> str:
    """Return the thread of a bore, or what brings one; "" where it has none."""
    if role not in THREADED:
        return ""
    insert = fits(design, maker(design, part)).insert
    return f"{SCREW.name} insert, {insert}" if insert and role is not CutRole.PULL else SCREW.name


def limits(design: Design, part: Part, role: CutRole) -> str:
    """Return the limits of a bore's diameter, mm: its fit's, where the process keeps it, or the process's."""
    process = process_of(design, part)
    either = f"±{process.tolerance:g}"
    if role in CLEARING:
        return f"+{H13:g}/0 (H13)" if process.tolerance <= H13 / 2 else either
    if role in PINNED and is_pressed(part, role):
        return either if process.layer else f"+{H7:.3f}/0 (H7)"
    if role in THREADED and (process.thread == "tapped" or role is CutRole.PULL):
        return "6H"
    return either
