"""A mount in words and figures: what to buy for it, how it is kept from silicone, and where its holes lie."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from skincad.fabrication.bores import mount_thread
from skincad.inputs.design import Design
from skincad.solids.ends import gate
from skincad.solids.fasteners import METRIC
from skincad.solids.mold import ClosedMold
from skincad.solids.plan import CutRole, PartRole, bores

Place = tuple[float, float]  # x and y, mm, from the carrier's middle


@dataclass(frozen=True)
class CarrierMount:
    """A mount as the carrier has it; lengths mm. Where there are no screws, `thread`, `depth` of its hole and
    `reach`, from how far to how far a screw may go in, are None."""

    thread: str | None
    insert: str  # how it is set, "" where the thread is tapped
    depth: float | None
    reach: tuple[float, float] | None
    positions: tuple[Place, ...]
    pin: float | None
    pin_position: Place | None
    fiducials: tuple[Place, ...]
    fiducial_diameter: float
    top: float  # where all of them open, over the skin's back

    def as_json(self) -> dict[str, Any]:
        """Return the mount with units in its keys."""
        return {
            "thread": self.thread,
            "insert": self.insert or None,
            "positions_mm": [list(at) for at in self.positions],
            "depth_mm": self.depth,
            "engagement_mm": self.reach and list(self.reach),
            "pin_mm": self.pin,
            "pin_position_mm": self.pin_position and list(self.pin_position),
            "fiducials_mm": [list(at) for at in self.fiducials],
            "fiducial_diameter_mm": self.fiducial_diameter if self.fiducials else None,
            "top_mm": self.top,
        }


def mount_of(design: Design, closed: ClosedMold) -> CarrierMount | None:
    """Return a design's mount, as the first carrier has it; None without one."""
    mount = design.mount
    if mount is None:
        return None
    carrier, blind = closed.first(PartRole.CARRIER), mount_thread(design)
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


def screws_to_buy(design: Design, closed: ClosedMold) -> list[str]:
    """Return what to buy for a mount; its screws' length depends on what the skin is screwed to."""
    mount = mount_of(design, closed)
    if mount is None or mount.thread is None or mount.reach is None:
        return []
    count, (least, most) = design.mold.cavities * len(mount.positions), mount.reach
    kinds = []
    if mount.insert:
        long, wide = METRIC[mount.thread].insert, METRIC[mount.thread].insert_hole
        size = f"({mount.insert}, {long:g} mm long, in holes of {wide:g} mm)"
        kinds.append(f"{count} threaded inserts {mount.thread} {size}")
    if mount.pin is not None:
        kinds.append(f"a dowel pin of {mount.pin:g} mm for each carrier")
    kinds.append(f"{count} {mount.thread} screws")
    return [
        f"for the mount {', '.join(kinds)}, as long as the flange is thick and {least:g} to {most:g} mm; "
        "a longer one bears on its hole's end, over the silicone"
    ]


def cleanliness_steps(design: Design, closed: ClosedMold) -> list[str]:
    """Return how a mount is kept from silicone, a step before the mold is closed; none without one."""
    mount = mount_of(design, closed)
    if mount is None:
        return []
    over = "foam" if closed.of(PartRole.SEAL) else "cover"
    holes = "threads and fiducials" if mount.positions and mount.fiducials else "threads"
    holes = holes if mount.positions else "fiducials"
    words = f"The mount's {holes} are blind and lie under the {over}, beside its openings"
    sealed = ", so no silicone comes to them."
    words += sealed if over == "foam" else "; fill them flush with wax, for no foam seals there."
    if gate(design) is None:
        words += " Tape them until the carrier lies on its ledge: silicone wells up through its holes."
    return [words]
