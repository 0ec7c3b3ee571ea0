"""The patterns by which shims and the seal are cut."""

from __future__ import annotations

import math
from typing import NamedTuple

from skincad.fabrication.pattern import ROW_GAP, cut_profile
from skincad.fabrication.strip_rules import lap
from skincad.fabrication.strip_steps import arc_radius, shim_length
from skincad.inputs.design import Design
from skincad.shape.curves import Loop, Point, Segment, rectangle
from skincad.shape.skin import section, skin_of
from skincad.solids.inserts import GRIP
from skincad.solids.layout import SQUEEZED_SHARE
from skincad.solids.mold import ClosedMold
from skincad.solids.plan import PartRole, Prism, RevolvedBody
from skincad.solids.projection import Place

LABEL_DISTANCE = 5.0  # mm, of a label beside its shim


class ShimPattern(NamedTuple):
    """One shim: its ridge and slot, its outline, and the line at which a tail begins that is thinned; None
    where it is not. The tail is at +x. The label's foot is at `label_at`."""

    label: str
    cut: Loop
    thinned: tuple[Point, Point] | None
    label_at: Point


def shim_patterns(design: Design, closed: ClosedMold) -> list[ShimPattern]:
    """Return the shims of one skin, ridge 1 first, one above the other; none where strips are cast in."""
    slot, joint = skin_of(design).slot, lap(design)
    if slot is None or design.mold.method == "cast-in":
        return []
    thin = joint is not None and joint.tail < slot.thickness
    bodies = [part.body for part in closed.of(PartRole.SHIM)]
    pairs = zip(section(design).slots, bodies, strict=False)  # of a gang the first skin's
    rows = []
    for number, (place, body) in enumerate(pairs):
        label, pitch = f"{place.feature} {place.side}", slot.depth + ROW_GAP
        if isinstance(body, RevolvedBody):
            radius = arc_radius(design, place.feature, place.side)
            half = (body.high - body.low) * abs(place.direction.z) / 2
            centre = number * pitch / math.cos(half) - radius
            inner, outer = radius - slot.depth / 2, radius + slot.depth / 2
            cut, foot = _sector(inner, outer, half, centre), _at(inner, -half, centre)
            tail = half - GRIP / radius
            tail_line = _at(inner, tail, centre), _at(outer, tail, centre)
        else:
            long, low = shim_length(design, closed) / 2, number * pitch - slot.depth / 2
            cut, foot = rectangle(-long, long, low, low + slot.depth), Point(-long, low)
            tail_line = Point(long - GRIP, low), Point(long - GRIP, low + slot.depth)
        rows.append(
            ShimPattern(label, cut, tail_line if thin else None, Point(foot.x - LABEL_DISTANCE, foot.z))
        )
    return rows


def shim_notes(design: Design) -> list[str]:
    """Return what is said on the pattern: which sheet, and what the cutter has to know."""
    slot, skins = skin_of(design).slot, design.mold.cavities
    thick = f"spring steel {slot.thickness:g} thick; " if slot else ""
    times = f"; for one skin: cut it {skins} times" if skins > 1 else ""
    return [f"{thick}CUT at nominal size, kerf not compensated{times}", "a shim does not shrink: 1:1"]


def _at(radius: float, angle: float, centre: float) -> Point:
    """A point at this angle from the upright, rad, about (0, centre)."""
    return Point(radius * math.sin(angle), centre + radius * math.cos(angle))


def _sector(inner: float, outer: float, half: float, centre: float) -> Loop:
    """Part of a ring about (0, centre), from -half to half of the upright, rad."""
    a, b = _at(outer, half, centre), _at(outer, -half, centre)
    c, d = _at(inner, -half, centre), _at(inner, half, centre)
    bulge = math.tan(half / 2)
    return Segment(a, b, bulge), Segment(b, c), Segment(c, d, -bulge), Segment(d, a)


class SealPattern(NamedTuple):
    """A seal's outline and then its holes, seen from above with end b up, mm, and what is said of it."""

    loops: tuple[Loop, ...]
    notes: list[str]

    @property
    def box(self) -> tuple[Place, Place]:
        """Lower left and upper right corner, mm: its outline has straight sides."""
        x, y = zip(*(s.start for s in self.loops[0]), strict=True)
        return (min(x), min(y)), (max(x), max(y))


def seal_pattern(closed: ClosedMold) -> SealPattern:
    """Return the pattern of a mold's seal. Raises ValueError where it has none."""
    seal = closed.first(PartRole.SEAL)
    profile = cut_profile(seal)
    if profile is None or not isinstance(seal.body, Prism):
        raise ValueError("a seal is cut from a sheet")
    high = seal.body.high - seal.body.low
    notes = [
        f"closed-cell EVA foam, sheet of {high / SQUEEZED_SHARE:.3g} mm, squeezed to {high:.3g} mm by the "
        "closed cover",
        "seen from above, end b up; CUT at nominal size, kerf not compensated; foam does not shrink: 1:1",
    ]
    return SealPattern(profile.loops, notes)
