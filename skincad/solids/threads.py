"""The blind threads, the pin's hole and the dimples of a mount: how wide, how deep, by the carrier's process.

Screws come from the robot's side, and silicone lies under the carrier: no hole goes through. Lengths are mm.
"""

from __future__ import annotations

from typing import NamedTuple

from skincad.inputs.mount_table import Mount
from skincad.inputs.process import Process
from skincad.solids.screws import DIAMETER, ENGAGEMENT, INSERT, PITCH, RUN_OUT, TAP_RADIUS, TIP_ROOM
from skincad.solids.shrinkage import on_grid


class Metric(NamedTuple):
    """A coarse thread (ISO 261): diameter and pitch, the drill before tapping (ISO 2306), the clearance hole
    (ISO 273, medium), and a threaded insert's length and hole (makers' tables)."""

    diameter: float
    pitch: float
    drill: float
    clearance: float
    insert: float
    insert_hole: float


METRIC = {
    "M2": Metric(2.0, 0.4, 1.6, 2.4, 4.0, 3.2),
    "M2.5": Metric(2.5, 0.45, 2.05, 2.9, 5.7, 4.0),
    "M3": Metric(DIAMETER, PITCH, 2 * TAP_RADIUS, 3.4, INSERT, 4.0),
    "M4": Metric(4.0, 0.7, 3.3, 4.5, 8.1, 5.6),
}
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
        return BlindThread(metric.insert_hole / 2, depth, least, metric.insert, process.thread)
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
