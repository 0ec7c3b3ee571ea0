"""Material and time of a print of molten filament, by the lines of its layers.

Each layer has loops along its contours, a filled rest, and ways between them. The layers' sections are the
print mesh's. No number here is fitted: those of the machine are the process's, the rest is what PrusaSlicer
does with its defaults. How often it draws filament back was counted in G-code of two parts (`_ways`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import trimesh
from manifold3d import CrossSection, Manifold, Mesh

from skincad.fabrication.printed_heights import SLICE_CLOSING
from skincad.fabrication.strokes import DIAGONAL, JERK, contour_moves, fill_moves, moves
from skincad.inputs.process import Process

SAMPLES = 16  # layers that are looked at; they stand for those between
OVERLAP = 0.25  # of a line, source: PrusaSlicer's infill_overlap, by which what fills lies over the last loop
SOLID_BELOW = 70.0  # mm2, source: PrusaSlicer's solid_infill_below_area
RETRACTED, RETRACT_SPEED = 2.0, 40.0  # mm, mm/s, source: PrusaSlicer's retract_length and _speed
RETRACT_ACCELERATION, RETRACT_JERK = 1500.0, 2.5  # mm/s2, mm/s, source: PrusaSlicer's machine limits
CONTOUR_TOLERANCE = 0.01  # mm, by which contours are simplified: far below a line


class MachineEffort(NamedTuple):
    """What a print takes: volume of material, mm3, and time, s."""

    volume: float
    seconds: float


def spacing(process: Process) -> float:
    """Return how far apart lines lie, mm: a line is a rectangle with half circles at its sides, and they
    touch so far that no gap is left (PrusaSlicer's flow)."""
    return process.line - (1 - math.pi / 4) * min(process.layer, process.line)


def filament(shape: trimesh.Trimesh, process: Process, notched: bool = False) -> MachineEffort:
    """Return what a print of a mesh takes, which lies on the bed as it is printed, mm. Gaps that a slicer
    closes are looked for in what is `notched`: that costs a third of the time."""
    solid = Manifold(Mesh(shape.vertices.astype(np.float32), shape.faces.astype(np.uint32)))
    count = max(1, round(float(shape.bounds[1, 2]) / process.layer))
    sections, known = _Sections(solid, process.layer, count, notched), dict[tuple[int, ...], MachineEffort]()
    volume = seconds = sampled = 0.0
    for layer, stands_for in _sampled(count):
        stack = sections.stack(layer, 0 if process.infill >= 1 else process.shells)
        key = (layer == 0, *map(id, stack))
        if key not in known:
            known[key] = _layer(stack, process, bottom=layer == 0)
        volume += stands_for * known[key].volume
        seconds += stands_for * known[key].seconds
        sampled += stands_for * stack[0].area() * process.layer
    scale = float(shape.volume) / sampled if sampled > 0 else 0.0  # what samples miss
    return MachineEffort(volume * scale, seconds * scale)


def _sampled(count: int) -> Iterator[tuple[int, int]]:
    """Which of `count` layers are looked at, and for how many each stands; the first for itself."""
    yield 0, 1
    rest = np.unique(np.linspace(1, count - 1, min(count - 1, SAMPLES)).round().astype(int))
    if rest.size:
        borders = np.array([1, *((rest[1:] + rest[:-1] + 1) // 2), count])
        yield from zip(rest.tolist(), np.diff(borders).tolist(), strict=True)


class _Sections:
    """Sections of a print's layers at their middles; equal ones are one object, and so compared once."""

    def __init__(self, solid: Manifold, layer: float, count: int, notched: bool) -> None:
        self._solid, self._layer, self._count, self._notched = solid, layer, count, notched
        self._kept: dict[tuple[int, int, float], CrossSection] = {}

    def stack(self, layer: int, reach: int) -> tuple[CrossSection, ...]:
        """Return a layer's section, then those of other shape up to `reach` layers below and above it."""
        sections = [self._at(layer)]
        for step in range(1, reach + 1):
            for near in (self._at(layer - step), self._at(layer + step)):
                if not any(near is other for other in sections):
                    sections.append(near)
        return tuple(sections)

    def _at(self, layer: int) -> CrossSection:
        """A layer's section, narrow gaps closed; an empty one below and above the print."""
        raw = CrossSection()
        if 0 <= layer < self._count:
            raw = self._solid.slice((layer + 0.5) * self._layer).simplify(CONTOUR_TOLERANCE)
        sign = raw.num_contour(), raw.num_vert(), round(raw.area(), 6)
        if sign not in self._kept:
            if self._notched:
                raw = raw.offset(SLICE_CLOSING / 2).offset(-SLICE_CLOSING / 2).simplify(CONTOUR_TOLERANCE)
            self._kept[sign] = raw
        return self._kept[sign]


def _layer(stack: tuple[CrossSection, ...], process: Process, bottom: bool) -> MachineEffort:
    """What the first layer of a stack takes; the `bottom` one of a print is laid slowly."""
    section, pitch, firm = stack[0], spacing(process), process.acceleration
    length = seconds = 0.0
    for loop in range(process.loops):
        speed = process.outer_speed if loop == 0 else process.loop_speed
        ring = section.offset(-(process.line / 2 + loop * pitch))
        line, time = contour_moves(ring, process.first_speed if bottom else speed, firm)
        length, seconds = length + line, seconds + time
    inside = process.line / 2 + (process.loops - 0.5) * pitch - OVERLAP * process.line
    core, speed = section.offset(-inside), process.first_speed if bottom else process.fill_speed
    sparse = _sparse(stack, core, process)
    _, line, time = fill_moves(core - sparse, pitch, speed, firm)
    length, seconds = length + line, seconds + time
    if process.infill > 0:
        wide = pitch / process.infill
        count, line, time = fill_moves(sparse, wide, speed, firm)
        length, seconds = length + line + count * DIAGONAL * wide, seconds + time
    return MachineEffort(length * pitch * process.layer, seconds + _ways(section, process))


def _sparse(stack: tuple[CrossSection, ...], core: CrossSection, process: Process) -> CrossSection:
    """Where a layer is not filled solid: neither near a top or bottom, nor in a patch that is small."""
    if process.infill >= 1:
        return CrossSection()
    region = core
    for other in stack[1:]:
        region = region ^ other
    return CrossSection.compose([patch for patch in region.decompose() if patch.area() >= SOLID_BELOW])


def _ways(section: CrossSection, process: Process) -> float:
    """How long ways between lines take, s: to each contour and to a patch of filling beside it as far as
    contours lie apart, with the filament drawn back, and from loop to loop: so round what lies alone, whose
    loops begin far from where the last one ended, and a step aside round a hole. Source: G-code of an end
    plate's keeper and a carrier by PrusaSlicer."""
    contours = section.num_contour()
    if not contours:
        return 0.0
    left, low, right, high = section.bounds()
    far = math.sqrt((right - left) * (high - low) / contours)
    retraction = moves(RETRACTED, 1, RETRACT_SPEED, RETRACT_JERK, RETRACT_ACCELERATION)

    near_move = moves(2 * process.line, 1, process.travel_speed, JERK, process.acceleration)
    far_move = moves(far, 1, process.travel_speed, JERK, process.acceleration)
    islands = len(section.decompose())
    far_ways = 2 * contours + (process.loops - 1) * islands
    near_ways = (process.loops - 1) * (contours - islands)
    return float(far_ways * (2 * retraction + far_move) + near_ways * near_move)
