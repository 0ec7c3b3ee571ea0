"""Screws and threads.

The mold's M3 screws: which lengths there are, how deep their holes are, how tight they may be. Lengths are
mm, a torque is N m.

The blind threads, the pin's hole and the dimples of a mount: how wide, how deep, by the carrier's process.
Screws come from the robot's side, and silicone lies under the carrier: no hole goes through. Lengths are mm.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from typing import NamedTuple

from skincad.inputs.mold_table import Mount
from skincad.inputs.process import Process
from skincad.solids.shrinkage import on_grid

DIAMETER, PITCH = 3.0, 0.5  # mm, source: ISO 261, M3 coarse
TAP_RADIUS = 1.25  # mm, source: ISO 2306, drill before tapping M3
LENGTHS = (5, 6, 8, 10, 12, 16, 20, 25, 30)  # mm, source: ISO 4762, M3; a longer one is a stud with nuts
SHORT = 3, 4  # mm, source: ISO 4762, M2 and M2.5
TIP_ROOM = 1.0  # mm, assumption: least between a screw's tip and the thread's end; screws come 0.3 longer
RUN_OUT = 2.5  # mm, source: DIN 76-1, short: five pitches below the last full thread, for the tap's lead
INSERT = 5.7  # mm, source: makers' tables, length of a threaded M3 insert
# of diameters, source: design handbooks, least thread for the screw to break first: brass and steel,
# aluminium, plastics. An insert of brass sits in 5.7 mm of plastic
ENGAGEMENT = {"wire": 1.25, "mill": 1.5, "lathe": 1.5, "plastic": 2.5, "insert": 1.5}
HEAD, HOLE = 5.5, 3.4  # mm, source: ISO 4762, head's width; ISO 273, clearance hole
BEARING = {"metal": 60.0, "plastic": 20.0}  # MPa, assumption: under a head, a third of what yields
NUT_FACTOR = 0.2  # source: design handbooks, torque by diameter and tension of a dry steel screw
WASHER = 0.5  # mm, source: ISO 7089, M3, thickness


def engagement(process: Process) -> float:
    """Return the least length of a screw in a thread of a part that a process makes."""
    kind = "plastic" if process.layer else process.tool
    return DIAMETER * ENGAGEMENT.get("insert" if process.thread != "tapped" else kind, ENGAGEMENT["plastic"])


def run_out_room(process: Process) -> float:
    """Return how much deeper a blind thread's hole is than its screw reaches."""
    return TIP_ROOM + (RUN_OUT if process.thread == "tapped" else 0.0)


def standard_length(least: float) -> float:
    """Return the shortest standard length of at least this; beyond the standard's, what a rod is cut to."""
    i = bisect_left(LENGTHS, least - 1e-9)
    return float(LENGTHS[i]) if i < len(LENGTHS) else math.ceil(least)


def standard_below(most: float) -> float:
    """Return the longest length of a short screw that is at most this, mm; the shortest where none is."""
    return max((long for long in (*SHORT, *LENGTHS) if long <= most + 1e-9), default=SHORT[0])


def blind_depth(grip: float, process: Process) -> float:
    """Return the depth of a blind thread's hole under what a screw clamps: that of the shortest screw that
    is long enough. An insert goes in whole."""
    deep = standard_length(grip + engagement(process)) - grip + run_out_room(process)
    return deep if process.thread == "tapped" else max(deep, INSERT + TIP_ROOM)


def screw_for(grip: float, depth: float, process: Process, *, bottomed: bool = False) -> tuple[float, int]:
    """Return the length of the screw for a hole as it is, and how many washers under its head keep its tip
    off the end: by `TIP_ROOM` where the hole is `bottomed`, open below or finished by a bottoming tap."""
    most = grip + depth - (TIP_ROOM if bottomed else run_out_room(process))
    long = standard_length(grip + engagement(process))
    return long, max(0, math.ceil((long - most) / WASHER - 1e-9))


def torque(process: Process) -> float:
    """Return the torque, N m, at which a dry screw's head presses a part of this process by `BEARING`:
    `NUT_FACTOR` times diameter times tension, Shigley's Mechanical Engineering Design, eq. 8-27."""
    area = math.pi / 4 * (HEAD**2 - HOLE**2)
    tension = area * BEARING["plastic" if process.layer else "metal"]
    return math.floor(100 * NUT_FACTOR * DIAMETER * tension / 1000) / 100


class Metric(NamedTuple):
    """A coarse thread (ISO 261): diameter and pitch, the drill before tapping (ISO 2306), the clearance hole
    (ISO 273, medium), and by makers' tables a threaded insert's length, its outer diameter and hole where it
    is melted in, and the outer diameter of a slimmer one that is glued in; a cylinder head's diameter (ISO
    4762)."""

    diameter: float
    pitch: float
    drill: float
    clearance: float
    insert: float
    insert_outer: float
    insert_hole: float
    glued_outer: float
    head: float


METRIC = {
    "M2": Metric(2.0, 0.4, 1.6, 2.4, 4.0, 3.6, 3.2, 3.2, 3.8),
    "M2.5": Metric(2.5, 0.45, 2.05, 2.9, 5.7, 4.6, 4.0, 3.6, 4.5),
    "M3": Metric(DIAMETER, PITCH, 2 * TAP_RADIUS, 3.4, INSERT, 4.6, 4.0, 3.9, HEAD),
    "M4": Metric(4.0, 0.7, 3.3, 4.5, 8.1, 6.3, 5.6, 5.4, 7.0),
}
# by the thread's diameter, source: ISO 965-1, 6H: from its minor diameter, less a drill that is a twentieth
# of a millimetre small, to what leaves 60 % of the thread
TAPPED = 0.79, 0.88


def thread_in(hole: float) -> str | None:
    """Return the thread that a hole of this diameter, mm, is tapped for; None where there is none."""
    low, high = TAPPED
    fits = (name for name, m in METRIC.items() if low * m.diameter <= hole <= high * m.diameter)
    return next(fits, None)


GLUE_GAP = 0.05  # mm a side, assumption: round an insert that is glued in


def insert_radius(name: str, how: str) -> float:
    """Return the radius of a threaded insert's hole: narrower where it is melted in, wider for glue."""
    return insert_outer(name, how) / 2 + GLUE_GAP if how == "glued" else METRIC[name].insert_hole / 2


def insert_outer(name: str, how: str) -> float:
    """Return the outer diameter of a threaded insert that is melted or glued in."""
    return METRIC[name].glued_outer if how == "glued" else METRIC[name].insert_outer


# of diameters, assumption: a mount bears what presses the skin, some 10 N, and needs no thread that breaks
# its screw; an insert is taken whole
MOUNT_ENGAGEMENT = {"metal": 1.0, "plastic": 1.5, "insert": ENGAGEMENT["insert"]}
# mm, assumption: full thread beyond that, so that a screw of a standard length reaches into it
LENGTH_CHOICE = TIP_ROOM
RUN_OUT_TURNS = RUN_OUT / PITCH  # pitches below the last full thread, see `RUN_OUT`
PIN_ENGAGEMENT = 1.5  # assumption: depth of a pin's hole by its diameter
LEAST_UNDER_HOLE = 1.0  # mm, assumption: what a blind hole leaves of the carrier over the silicone


class BlindThread(NamedTuple):
    """A blind thread of a part: the radius of its hole and how deep it is, mm; from how far to how far a
    screw may reach into it; how an insert is set into it, "" where it is tapped."""

    radius: float
    depth: float
    least: float
    most: float
    insert: str


def blind_thread(name: str, process: Process) -> BlindThread:
    """Return the blind thread that a process gives a part: tapped, or the hole of an insert."""
    metric = METRIC[name]
    if process.thread != "tapped":
        depth, least = on_grid(metric.insert + TIP_ROOM), MOUNT_ENGAGEMENT["insert"] * metric.diameter
        radius = insert_radius(name, process.thread)
        return BlindThread(radius, depth, least, metric.insert, process.thread)
    least = MOUNT_ENGAGEMENT["plastic" if process.layer else "metal"] * metric.diameter
    depth = on_grid(least + LENGTH_CHOICE + RUN_OUT_TURNS * metric.pitch)
    return BlindThread(metric.drill / 2, depth, least, least + LENGTH_CHOICE, "")


def pin_depth(diameter: float) -> float:
    """Return the depth of a mount's pin's hole."""
    return on_grid(PIN_ENGAGEMENT * diameter)


def least_thickness(mount: Mount, process: Process) -> tuple[float, str]:
    """Return how thick a carrier must be for its mount, and for what of it, as words."""
    needs = [(mount.fiducial_depth, "fiducials")] if mount.fiducials else []
    needs += [(pin_depth(mount.pin), "pin")] if mount.pin else []
    if mount.thread is not None:
        blind = blind_thread(mount.thread, process)
        kind = f"{blind.insert} inserts" if blind.insert else "threads"
        needs.append((blind.depth, f"{mount.thread} {kind}"))
    deepest, what = max(needs)
    return (
        deepest + LEAST_UNDER_HOLE,
        f"the mount's {what} over {LEAST_UNDER_HOLE:g} mm that stay above the silicone",
    )
