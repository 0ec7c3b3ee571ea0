"""The mold's M3 screws: which lengths there are, how deep their holes are, how tight they may be.

Lengths are mm, a torque is N m.
"""

from __future__ import annotations

import math
from bisect import bisect_left

from skincad.inputs.process import Process

DIAMETER, PITCH = 3.0, 0.5  # mm, source: ISO 261, M3 coarse
TAP_RADIUS = 1.25  # mm, source: ISO 2306, drill before tapping M3
# mm, source: ISO 4762, the nominal lengths; of M3 30 is the longest that all makers have
LENGTHS = (5, 6, 8, 10, 12, 16, 20, 25, 30, 35, 40, 45, 50, 55, 60, 65, 70, 80, 90, 100, 110, 120)
TIP_ROOM = 1.0  # mm, assumption: least between a screw's tip and the thread's end; screws come 0.3 longer
RUN_OUT = 2.5  # mm, source: DIN 76-1, short: five pitches below the last full thread, for the tap's lead
INSERT = 5.7  # mm, source: makers' tables, length of a threaded M3 insert
# of diameters, source: design handbooks, least thread for the screw to break first: brass and steel,
# aluminium, plastics. An insert of brass sits in 5.7 mm of plastic
ENGAGEMENT = {"wire": 1.25, "mill": 1.5, "plastic": 2.5, "insert": 1.5}
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
