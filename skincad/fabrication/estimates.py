"""Mass, time and cost of the parts by process.

How long a nozzle moves: straight moves and loops of lines, with acceleration and slower corners. A move
begins and ends at the speed that a corner allows, accelerates evenly and brakes evenly, as firmware of
printers plans it, but for looking further ahead than one line: where a circle of short chords begins or ends,
that is 0.02 s too much, about what is left out of ends of filling. Source: PrusaSlicer's own estimate, whose
machine limits are the defaults here.

Time of a print of resin: layers are exposed whole, however much of them is filled. So the time is the
height's, and that of a plate its tallest part's.

Stock and time of a part that is cut: the time follows from rates of removal and of faces. No slicer says
these times; rates are assumptions, and the process's errors as wide.

Material and time of a print of molten filament, by the lines of its layers. Each layer has loops along its
contours, a filled rest, and ways between them. The layers' sections are the print mesh's. No number here is
fitted: those of the machine are the process's, the rest is what PrusaSlicer does with its defaults. How often
it draws filament back was counted in G-code of two parts (`_ways`).

Prints are estimated by their layers, what is cut from stock by its faces. Errors and prices are the
process's own; a part's errors are those of its process, and so add up.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
import trimesh
from manifold3d import CrossSection, Manifold, Mesh
from numpy.typing import NDArray

from skincad.base.arrays import Array
from skincad.base.estimate import Estimate
from skincad.base.result import Record, item, record, reported
from skincad.fabrication.crests import SLICE_CLOSING
from skincad.fabrication.job import Job
from skincad.fabrication.machine_rules import extent
from skincad.fabrication.meshes import BedPart, plates
from skincad.inputs.process import Process
from skincad.shape import curves
from skincad.shape.curves import Loop, polygon
from skincad.solids.plan import Part, PartRole, Prism, RevolvedBody, bores, plain, unturned

JERK = 10.0  # mm/s, source: PrusaSlicer's machine_max_jerk_x and _y, by which speed may jump along an axis
DIAGONAL = math.sqrt(2.0)  # lines that fill lie at 45 degrees: each axis has its share of a jump
_SHORTEST = 1e-9  # mm, of a line: no division by 0
MINUTE = 60.0  # s
_CHORD = 0.01  # mm, of arcs: no rate is that sharp
SAMPLES = 16  # layers that are looked at; they stand for those between
OVERLAP = 0.25  # of a line, source: PrusaSlicer's infill_overlap, by which what fills lies over the last loop
SOLID_BELOW = 70.0  # mm2, source: PrusaSlicer's solid_infill_below_area
RETRACTED, RETRACT_SPEED = 2.0, 40.0  # mm, mm/s, source: PrusaSlicer's retract_length and _speed
RETRACT_ACCELERATION, RETRACT_JERK = 1500.0, 2.5  # mm/s2, mm/s, source: PrusaSlicer's machine limits
CONTOUR_TOLERANCE = 0.01  # mm, by which contours are simplified: far below a line
HOUR, MINUTES = 3600.0, 60.0  # s and min of an hour
RESIN = "layers by exposure and lift; no supports"
FILAMENT = "lines of the layers by speed and acceleration; no supports"
MILLED = "stock's mass; its removal, faces and holes by assumed rates"
WIRED = "stock's mass; cut faces and holes by assumed rates"


def moves(length: float, count: float, speed: float, corner: float, acceleration: float) -> float:
    """Return the s that `count` equal straight moves of `length` mm together take, each from `corner` mm/s to
    `speed` mm/s, or to what it reaches, and back."""
    if count <= 0 or length <= 0:
        return 0.0
    corner = min(corner, speed)
    size = length / count
    if size * acceleration >= speed**2 - corner**2:
        return count * (size / speed + (speed - corner) ** 2 / (acceleration * speed))
    return count * 2 * (math.sqrt(corner**2 + acceleration * size) - corner) / acceleration


def contour_moves(section: CrossSection, speed: float, acceleration: float) -> tuple[float, float]:
    """Return mm and s of lines along all contours of a section, each begun and ended at the jerk's speed."""
    if section.is_empty():
        return 0.0, 0.0
    steps, last = _edges(section)
    length = np.maximum(np.hypot(*steps.T), _SHORTEST)
    ways = steps / length[:, None]
    jump = np.abs(np.roll(ways, -1, axis=0) - ways).max(axis=1) * speed
    after = speed * np.minimum(1.0, JERK / np.maximum(jump, _SHORTEST))
    after[last] = min(JERK, speed)
    before = np.roll(after, 1)  # every contour begins as every other one ends
    mean = (before**2 + after**2) / 2
    peak = np.sqrt(np.minimum(speed**2, acceleration * length + mean))
    peak = np.maximum(peak, np.maximum(before, after))
    cruising = np.maximum(0.0, length - (peak**2 - mean) / acceleration) / peak
    return float(length.sum()), float(((2 * peak - before - after) / acceleration + cruising).sum())


def fill_moves(
    region: CrossSection, spacing: float, speed: float, acceleration: float
) -> tuple[float, float, float]:
    """Return how many parallel lines at 45 degrees, `spacing` mm apart, fill a region; their mm and s, with
    the way from each to the next along the edge.

    As many lines end on the contours as their edges are long across the lines (Cauchy), by both diagonals.
    """
    if region.is_empty():
        return 0.0, 0.0, 0.0
    steps, _ = _edges(region)
    widths = np.abs(steps @ [[1.0, 1.0], [-1.0, 1.0]]) / DIAGONAL
    count, length = float(widths.sum()) / 4 / spacing, region.area() / spacing
    corner = min(speed, JERK * DIAGONAL)
    link = moves(DIAGONAL * spacing * count, count, speed, corner, acceleration)
    return count, length, moves(length, count, speed, corner, acceleration) + link


def _edges(section: CrossSection) -> tuple[Array, NDArray[np.int_]]:
    """From corner to corner of all contours, `(n, 2)` mm, and which of these close a contour."""
    contours = section.to_polygons()
    points, last = np.vstack(contours), np.cumsum([len(contour) for contour in contours]) - 1
    onward = np.arange(1, len(points) + 1)
    onward[last] = [0, *(last[:-1] + 1)]
    return points[onward] - points, last


def exposure_time(height: float, process: Process) -> float:
    """Return how long the layers of a height in mm take, s: the first ones longer, the next ones fading to
    the usual exposure in equal steps, as PrusaSlicer has them; each with its lift."""
    layers = max(1, round(height / process.layer))
    first = min(layers, process.first_layers)
    fading = min(layers - first, process.fading)
    step = (process.first_exposure - process.exposure) / (process.fading + 1)
    faded = math.fsum(process.first_exposure - number * step for number in range(1, fading + 1))
    rest = (layers - first - fading) * process.exposure
    return first * process.first_exposure + faded + rest + layers * process.lift


def machining(part: Part, process: Process) -> MachineEffort:
    """Return the volume of a part's stock, mm3, and how long it is cut, s.

    A mill clears what stock has over the part and finishes all faces. A wire cuts the faces along its way
    alone, and offcuts come off whole. The skin's negative and notches go by the fine tool's rate.
    """
    stock = math.prod(side + 2 * process.allowance for side in extent(part))
    coarse, fine = _faces(part, ends=process.removal_rate > 0)
    minutes = coarse / process.finish_rate + fine / process.fine_rate + len(bores(part)) * process.hole_time
    if process.removal_rate > 0:
        minutes += (stock - part.volume) / process.removal_rate
    return MachineEffort(stock, minutes * MINUTE)


def _faces(part: Part, ends: bool) -> tuple[float, float]:
    """Area of a part's faces beside its bores, mm2, for a coarse tool and for a fine one; with its two `ends`
    or without."""
    body = unturned(part).body
    if not isinstance(body, Prism):
        raise ValueError("a made part is a prism less its cuts")
    long = body.high - body.low
    loops = (body.outline, *body.holes)
    around, fine = math.fsum(map(curves.length, loops)), math.fsum(map(_negative, loops))
    if part.role is PartRole.COMB:
        fine = max(0.0, around - 2 * float(np.ptp(polygon(body.outline, _CHORD), axis=0).sum()))  # notches
    coarse = (around - fine) * long + (2 * body.volume / long if ends else 0.0)
    turned = [cut for cut in map(plain, part.cuts) if isinstance(cut, RevolvedBody)]  # a bowl's trough
    swept = (_negative(cut.outline) * abs(cut.centre) * (cut.high - cut.low) for cut in turned)
    return coarse, fine * long + math.fsum(swept)


def _negative(outline: Loop) -> float:
    """Length of what is the skin's in an outline, mm."""
    return math.fsum(segment.length for segment in outline if segment.kind != "other")


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


@record()
class PartEstimate(Record):
    """What a part takes, made alone; of the cost, its share of a plate's time and setup."""

    name: str
    process: str
    mass: Estimate = item("g", "of the print, or of the stock")
    time: Estimate = item("h", "of the machine")
    cost: Estimate = item("EUR", "of material, machine and setup")
    basis: str = item(meaning="what it rests on")


@record()
class ProcessEstimate(Record):
    """What all parts of a mold take that one process makes."""

    process: str = item(meaning="its name")
    parts: tuple[PartEstimate, ...]
    plates: int = item(meaning="0 where there are none")
    mass: Estimate = item("g", "of all its parts")
    time: Estimate = item("h", "of a plate of resin, its tallest part's")
    cost: Estimate = item("EUR", "of material, machine and setup")

    @reported(meaning="what each takes", key="parts")
    def _parts(self) -> list[dict[str, Any]]:
        return [
            {"name": n.name, "mass_g": n.mass, "time_h": n.time, "cost_EUR": n.cost, "basis": n.basis}
            for n in self.parts
        ]


def estimates(job: Job, prints: Mapping[str, trimesh.Trimesh]) -> tuple[ProcessEstimate, ...]:
    """Return what each process takes for a mold's parts, in the parts' order; `prints` are the meshes of what
    is made as they lie on the bed, mm, by part name."""
    parts_by_process: dict[str, list[Part]] = {}
    for part in job.closed.made:
        parts_by_process.setdefault(job.maker(part), []).append(part)
    known = job.processes
    return tuple(_of_process(name, known[name], parts, prints) for name, parts in parts_by_process.items())


def by_part(process_estimates: tuple[ProcessEstimate, ...]) -> dict[str, PartEstimate]:
    """Return the estimates of all parts by name."""
    return {part.name: part for estimate in process_estimates for part in estimate.parts}


def _of_process(
    name: str, process: Process, parts: list[Part], prints: Mapping[str, trimesh.Trimesh]
) -> ProcessEstimate:
    shapes = {part.name: prints[part.name] for part in parts}
    took = {part.name: _effort(part, shapes[part.name], process) for part in parts}
    groups = [[part.name] for part in parts]
    if process.layer > 0:
        lying = [BedPart(n, *map(float, shape.extents)) for n, shape in shapes.items()]
        groups = [[spot.name for spot in plate] for plate in plates(lying, process)]
        basis = RESIN if process.exposure > 0 else FILAMENT
    else:
        basis = MILLED if process.removal_rate > 0 else WIRED
    together = max if process.exposure > 0 else math.fsum
    rows, hours = dict[str, PartEstimate](), 0.0
    for group in groups:
        alone = {n: took[n].seconds / HOUR for n in group}
        long, total = float(together(alone.values())), math.fsum(alone.values())
        hours += long
        for n in group:
            grams = took[n].volume * process.density / 1000
            share = alone[n] / total * long if total else 0.0
            rows[n] = PartEstimate(
                name=n,
                process=name,
                mass=Estimate(grams, grams * process.mass_error, "g"),
                time=Estimate(alone[n], alone[n] * process.time_error, "h"),
                cost=_cost(grams, share, process.setup / MINUTES / len(group), process),
                basis=basis,
            )
    estimated = tuple(rows[n] for n in took)
    return ProcessEstimate(
        process=name,
        parts=estimated,
        plates=len(groups) if process.layer else 0,
        mass=_sum([part.mass for part in estimated]),
        time=Estimate(hours, hours * process.time_error, "h"),
        cost=_sum([part.cost for part in estimated]),
    )


def _effort(part: Part, shape: trimesh.Trimesh, process: Process) -> MachineEffort:
    if not process.layer:
        return machining(part, process)
    if process.exposure > 0:
        return MachineEffort(part.volume, exposure_time(float(shape.extents[2]), process))
    return filament(shape, process, notched=part.role is PartRole.COMB)


def _cost(grams: float, hours: float, setup: float, process: Process) -> Estimate:
    """Material with its waste, and the machine with its setup, h; errors of amount and price add up."""
    material = grams / 1000 * (1 + process.waste) * process.price
    machine, ready = hours * process.rate, setup * process.rate
    off = material * (process.mass_error + process.price_error)
    off += machine * (process.time_error + process.price_error) + ready * process.price_error
    return Estimate(material + machine + ready, off, "EUR")


def _sum(parts: list[Estimate]) -> Estimate:
    """A sum whose parts are off the same way."""
    values, errors = [float(part) for part in parts], [part.error or 0.0 for part in parts]
    return Estimate(math.fsum(values), math.fsum(errors), parts[0].unit)
