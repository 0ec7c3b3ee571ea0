"""On how many plates of a printer parts lie: rectangles in rows, the tallest parts together."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from skincad.inputs.process import Process

PART_GAP = 5.0  # mm, assumption: between parts on a plate


class BedPart(NamedTuple):
    """A part as it lies on the bed: its sides along x, y and z, mm."""

    name: str
    x: float
    y: float
    z: float


def plates(parts: Sequence[BedPart], process: Process) -> list[list[BedPart]]:
    """Return parts by plate. Each part, from the tallest down, goes onto the first plate that takes it; one
    that is larger than any plate has one to itself (the finding `build volume` reports it)."""
    full: list[list[BedPart]] = []
    for part in sorted(parts, key=lambda part: (-part.z, part.name)):
        for plate in full:
            if _fit([*plate, part], process):
                plate.append(part)
                break
        else:
            full.append([part])
    return full


def _fit(parts: list[BedPart], process: Process) -> bool:
    """Whether parts lie in rows, widest rows first, each part with its longer side along the row."""
    longer, shorter = sorted((process.build_x, process.build_y), reverse=True)
    if not shorter:
        return True  # no limit
    sides = sorted((sorted((part.x, part.y)) for part in parts), reverse=True)
    used = reach = deep = 0.0
    for wide, long in sides:
        if reach and reach + PART_GAP + long <= longer:
            reach += PART_GAP + long
        else:
            used += deep + (PART_GAP if deep else 0.0)
            reach, deep = long, wide
        if reach > longer or used + deep > shorter:
            return False
    return True
