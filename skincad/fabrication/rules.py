"""Rules that every process has: gap, wall, slender tooth, hole, clearance, cure inhibition, knife edges.

A rule is a function of a case, one part by one process, that yields a finding for each limit it breaks.
Widths are exact: they are the design's own, or distances between the plan's polygons. A knife edge is a
corner of a made part so sharp that it chips or bends, and leaves a flash where parts meet. At a corner of the
plan's outline the part's own angle lies between the tangents of the two segments. What is worked here is the
outline's plane; along a prism every face meets its ends at a right angle.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Literal

import numpy as np
import shapely

from skincad.base.result import Record, item
from skincad.fabrication.job import Job
from skincad.inputs.process import Process
from skincad.shape.curves import Loop, Point, Segment, polygon
from skincad.shape.skin import GUARD_TOLERANCE, Narrowest
from skincad.solids.plan import CAVITIES, END_PLATES, Part, PartRole, Prism, bores, unturned
from skincad.solids.split import notch_rise

FINER_COMBS = 'or a finer process for the combs: mold.end_plate_process = "edm"'
LEAST_ANGLE = 30.0  # deg, assumption: a more pointed edge of metal or resin chips within a few castings
_SHORTEST = 1e-6  # mm; a shorter segment has no direction to speak of
_ROUNDING = 1e-9  # mm


@dataclass(frozen=True)
class Finding(Record):
    """A broken rule. `error` fails the job, `warning` fails it under --strict, `note` never does."""

    rule: str = item(meaning="which is broken")
    where: str = item(meaning="the place")
    measured: float = item(meaning="in the unit")
    limit: float = item(meaning="in the unit")
    unit: str = item(meaning="of both")
    remedy: str = item(meaning="what to do")
    severity: Literal["note", "warning", "error"] = item(meaning="note, warning or error")

    def __str__(self) -> str:
        unit = f" {self.unit}" if self.unit else ""
        numbers = f": {self.measured:.4g}{unit}, limit {self.limit:.4g}"
        if not unit and {self.measured, self.limit} == {0.0, 1.0}:  # yes or no, as `where` says
            numbers = ""
        return f"{self.severity}: {self.rule}: {self.where}{numbers}; {self.remedy}"


error = partial(Finding, severity="error")
warning = partial(Finding, severity="warning")
note = partial(Finding, severity="note")


def counted(findings: Iterable[Finding]) -> str:
    """Return how many errors and warnings there are, as "no errors, 1 warning"."""
    count = Counter(finding.severity for finding in findings)
    words = []
    for severity in ("error", "warning"):
        number = count[severity]
        words.append(f"{number or 'no'} {severity}{'s' * (number != 1)}")
    return ", ".join(words)


@dataclass(frozen=True)
class Case:
    """One part of a design's mold by one process."""

    job: Job
    part: Part
    name: str  # of the process

    @property
    def process(self) -> Process:
        """The process by which the part is judged."""
        return self.job.processes[self.name]

    @property
    def along(self) -> Part:
        """The part as its section along y is judged: straight where it is bent, upright where it leans."""
        return self.part.straight or unturned(self.part)

    def breaks(
        self, rule: str, what: str, measured: float, limit: float, unit: str, remedy: str, grave: bool = True
    ) -> Finding:
        """Return a rule that something of the part breaks: a warning, or a note where it is not grave."""
        where = f"{self.part.role.label}, {what}, by {self.name}"
        return (warning if grave else note)(rule, where, measured, limit, unit, remedy)


Rule = Callable[[Case], Iterator[Finding]]


def coating(job: Job, process: Process) -> float:
    """Return how thick a coat a process's parts need against the design's silicone, mm."""
    return process.coating if process.inhibits_platinum and job.silicone.platinum_cure else 0.0


def inhibiting(job: Job) -> list[str]:
    """Return the parts that are washed, cured and baked for the silicone's sake."""
    if not job.silicone.platinum_cure:
        return []
    return [part.name for part in job.closed.made if job.process(part).inhibits_platinum]


def coats(job: Job) -> list[float]:
    """Return the thicknesses of the coats that seal them, mm."""
    return sorted({coating(job, job.process(part)) for part in job.closed.made} - {0.0})


def walls_close(job: Job, process: Process) -> float:
    """Return by how much each wall of a notch comes nearer than it is drawn, mm: growth, and a coat where one
    is needed."""
    return process.growth + coating(job, process)


def slit_play(job: Job, process: Process) -> float:
    """Return the clearance of shims or strips a side as it comes out, mm; below 0 they jam."""
    return job.design.mold.slit_clearance - walls_close(job, process)


def grooves(case: Case) -> list[Narrowest]:
    """Return the narrowest groove of each kind: the highest ridge's in the cavity, a shim's in a comb."""
    design, skin = case.job.design, case.job.skin
    if case.part.role in CAVITIES:
        return [skin.groove()]
    if case.part.role is PartRole.COMB and skin.slot:
        gap = 2 * design.mold.slit_clearance
        insert = "strip" if design.mold.method == "cast-in" else "shim"
        return [Narrowest(f"notch of a {insert}", design.core_thickness + gap, skin.slot.depth + gap)]
    return []


def teeth(case: Case) -> list[Narrowest]:
    """Return the narrowest free tooth: between two ridges' grooves in the cavity, between notches in a comb,
    there by the least distance."""
    if case.part.role in CAVITIES:
        tooth = case.job.skin.tooth()
        return [tooth] if tooth else []
    return [_comb_tooth(case.job)] if case.part.role is PartRole.COMB else []


@lru_cache(maxsize=8)
def _comb_tooth(job: Job) -> Narrowest:
    """The narrowest tooth between two neighbouring notches of a comb, the same by every process."""
    gap = job.design.mold.slit_clearance
    slots = sorted(job.section.slots, key=lambda slot: slot.centre.x)
    shapes = np.array([shapely.Polygon(polygon(s.loop(grown=gap), GUARD_TOLERANCE)) for s in slots])
    widths = shapely.distance(shapes[:-1], shapes[1:])
    least = int(np.argmin(widths))
    where = " and ".join(f"{s.side} of ridge {s.feature}" for s in slots[least : least + 2])
    return Narrowest(f"tooth between {where}", float(widths[least]), slots[least].depth + 2 * gap)


def scaled(measured: float, limit: float) -> str:
    """Return the remedy that scales the design up."""
    by = math.ceil(100 * limit / measured) / 100
    return f"multiply all lengths by {by:g} and take a silicone {by**2:.2g} times softer, as lab-bench does"


def _gap(case: Case) -> Iterator[Finding]:
    if case.process.reach:
        return  # what the tool leaves there is measured instead
    for groove in grooves(case):
        yield from below("gap", case, groove.where, groove.width, case.process.gap)


def _wall(case: Case) -> Iterator[Finding]:
    skin, least = case.job.skin, case.process.wall
    for tooth in teeth(case):
        wider = f"{skin.family}.pitch of at least {skin.pitch + least - tooth.width:.4g} mm, or "
        apart = wider if case.part.role in CAVITIES else ""
        yield from below("wall", case, tooth.where, tooth.width, least, apart)


def below(
    rule: str, case: Case, where: str, size: float, least: float, otherwise: str = ""
) -> Iterator[Finding]:
    """Yield a warning where a size is below the least that the process makes; `otherwise` is a remedy besides
    that of larger lengths."""
    if size < least - _ROUNDING:
        yield case.breaks(rule, where, size, least, "mm", otherwise + scaled(size, least))


def _slender(case: Case) -> Iterator[Finding]:
    """A tooth that bends under the tool or breaks in use; in the cavity its mean width bears it."""
    most = case.process.tooth_ratio
    for tooth in teeth(case):
        width = tooth.width
        if case.part.role in CAVITIES:
            profile = case.job.skin.profile
            width += (profile.root_width - profile.tip_width) / 2
        if most and tooth.height > most * width:
            apart = f"{case.job.skin.family}s or slots further apart"
            remedy = f"{_height_key(case)} of at most {most * width:.3g} mm, or {apart}"
            times = "times as high as wide"
            yield case.breaks("slender", tooth.where, tooth.height / width, most, times, remedy)


def _height_key(case: Case) -> str:
    """How high what is cast there is, as a key of the design; of a comb its slots' depth."""
    return f"{case.job.skin.family}.height" if case.part.role in CAVITIES else "slot.depth"


def _hole(case: Case) -> Iterator[Finding]:
    sizes = [2 * min(bore.radius, bore.far_radius) for bore in bores(case.part)]
    if sizes and min(sizes) < case.process.hole - _ROUNDING:
        remedy = "drill it afterwards, or make it larger"
        yield case.breaks("hole", "bore", min(sizes), case.process.hole, "mm", remedy)


def _clearance(case: Case) -> Iterator[Finding]:
    """One key for all that slides, so one finding a process. Coat and growth are on both parts."""
    least = case.process.clearance + 2 * walls_close(case.job, case.process)
    clearance = case.job.design.mold.clearance
    if clearance < least - _ROUNDING:
        place = f"sliding parts, by {case.name}"
        yield warning("clearance", place, clearance, least, "mm", f"mold.clearance of {least:g} mm")


def _slit_fit(case: Case) -> Iterator[Finding]:
    """By the clearance that comes out; where nothing is left of it, the rule `notch` reports it.

    An error in a print, which nobody laps to a tenth; metal is lapped, so that is a note.
    """
    left, limit, printed = slit_play(case.job, case.process), case.process.tolerance, case.process.layer > 0
    if case.part.role is not PartRole.COMB or not -_ROUNDING <= left < limit - _ROUNDING:
        return
    remedy = "try each shim in its notch and lap the notch where it binds"
    if printed:
        remedy = f"mold.slit_clearance of {limit + walls_close(case.job, case.process):g} mm, {FINER_COMBS}"
    where = f"{case.part.role.label}, fit of shims and notches, by {case.name}"
    yield (error if printed else note)("slit fit", where, left, limit, "mm", remedy)


def _notch_room(case: Case) -> Iterator[Finding]:
    """A note where straight notches let silicone in beside shims that are arcs."""
    if case.part.role is not PartRole.COMB:
        return
    room, gap = notch_rise(case.job.design, case.job.section.slots), case.job.design.mold.slit_clearance
    if room > gap:
        place = f"{case.part.role.label}, straight notches round shims that rise in them"
        remedy = "cut the fins off the skin's ends; a thinner mold.end_plate leaves shorter ones"
        yield note("notch room", place, room, gap, "mm", remedy)


def _cure(case: Case) -> Iterator[Finding]:
    material = case.job.silicone
    if case.process.inhibits_platinum and material.platinum_cure:
        place = f"{case.name} parts may keep {material.name}, a platinum-cured silicone, from curing"
        how = "wash, cure, bake and seal" if coating(case.job, case.process) else "wash, cure and bake"
        remedy = f"{how} them as the casting sheet says, and cast its trial drop first"
        yield note("cure inhibition", place, 1.0, 0.0, "", remedy)


RULES: tuple[Rule, ...] = (_gap, _wall, _slender, _hole, _clearance, _slit_fit, _notch_room, _cure)


def edges(outline: Loop) -> list[tuple[Point, float]]:
    """Return every corner of an outline and the material's angle there in deg, 180 where it runs straight."""
    real = [s for s in outline if s.chord > _SHORTEST]
    corners = []
    for before, after in zip([real[-1], *real[:-1]], real, strict=True):
        turn = math.remainder(_heading(after, 0.0) - _heading(before, 1.0), 2 * math.pi)
        corners.append((after.start, math.degrees(math.pi - turn)))
    return corners


def _heading(segment: Segment, fraction: float) -> float:
    """Direction of a segment's tangent, rad."""
    chord = math.atan2(segment.end.z - segment.start.z, segment.end.x - segment.start.x)
    return chord + (fraction - 0.5) * segment.sweep


def _knife_edge(case: Case) -> Iterator[Finding]:
    """The sharpest corner of a part; no process makes a plan's angle blunter."""
    body = case.along.body
    if not isinstance(body, Prism):
        return
    place, angle = min(edges(body.outline), key=lambda edge: edge[1])
    if angle < LEAST_ANGLE:
        where = f"{case.part.role.label}, {drawn_at(case.part, place.x, place.z)}"
        remedy = "a slot or flank that meets its parting line at a larger angle, or a larger curvature_radius"
        yield warning("knife edge", where, angle, LEAST_ANGLE, "deg", remedy)


def drawn_at(part: Part, x: float, z: float) -> str:
    """Return a place of a part's section as its drawing's front view has it: from its left or right edge, and
    from its lower or upper one, as the drawing's notes say."""
    body = (part.straight or unturned(part)).body
    if not isinstance(body, Prism):
        return f"x {x:.4g}, z {z:.4g} mm"
    points = np.asarray(polygon(body.outline, GUARD_TOLERANCE))
    (left, low), (right, high) = points.min(axis=0).tolist(), points.max(axis=0).tolist()
    from_top = part.role is PartRole.KEEPER and part is unturned(part)
    across = right - x if part.role is PartRole.RIGHT else x - left
    up = high - z if from_top else z - low
    whose = "end a's drawing" if part.role in END_PLATES else "its drawing"  # end b's is its mirror image
    return f"x {across:.4g}, y {up:.4g} mm of {whose}"


EDGE_RULES: tuple[Rule, ...] = (_knife_edge,)
