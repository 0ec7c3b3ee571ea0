"""Rules that every process has: gap, wall, slender tooth, hole, clearance; cure inhibition; shims.

A rule is a function of a case, one part by one process, that yields a finding for each limit it breaks.
Widths are exact: they are the design's own, or distances between the plan's polygons.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import shapely

from skincad.fabrication.finding import Finding
from skincad.fabrication.strips import STEEL_MODULUS
from skincad.inputs.design import Design
from skincad.inputs.material import foreign_modulus, silicone
from skincad.inputs.process import Process
from skincad.shape.curves import polygon
from skincad.shape.skin import GUARD_TOLERANCE, Narrowest, section, skin_of
from skincad.solids.plan import CAVITIES, END_PLATES, Part, PartRole, bores, unturned
from skincad.solids.split import notch_rise

STEEL_WEIGHT = 7.85e-6 * 9.81  # N/mm3, source: handbooks, 7850 kg/m3
SHIM_ELASTIC = 0.006  # strain, source: handbooks, hardened spring steel yields at about 1200 of 200e3 MPa
SAG_SHARE = 0.5  # assumption: of a slot's thickness; a shim that hangs through by more displaces its film
_ROUNDING = 1e-9  # mm


@dataclass(frozen=True)
class Case:
    """One part of a design's mold by one process."""

    design: Design
    part: Part
    name: str  # of the process
    process: Process

    @property
    def along(self) -> Part:
        """The part as its section along y is judged: straight where it is bent, upright where it leans."""
        return self.part.straight or unturned(self.part)

    def breaks(
        self, rule: str, what: str, measured: float, limit: float, unit: str, remedy: str, grave: bool = True
    ) -> Finding:
        """Return a rule that something of the part breaks: a warning, or a note where it is not grave."""
        where = f"{self.part.role.label}, {what}, by {self.name}"
        return Finding(rule, where, measured, limit, unit, "warning" if grave else "note", remedy)


Rule = Callable[[Case], Iterator[Finding]]


def maker(design: Design, part: Part) -> str:
    """Return the process that makes a part."""
    choice = design.mold
    if part.role in CAVITIES:
        return choice.process
    if part.role in END_PLATES:
        return choice.end_plate_process or choice.process
    return choice.lid_process or choice.process


def coating(design: Design, process: Process) -> float:
    """Return how thick a coat a process's parts need against the design's silicone, mm."""
    return process.coating if process.inhibits_platinum and silicone(design).platinum_cure else 0.0


def walls_close(design: Design, process: Process) -> float:
    """Return by how much each wall of a notch comes nearer than it is drawn, mm: growth, and a coat where one
    is needed."""
    return process.growth + coating(design, process)


def slit_play(design: Design, process: Process) -> float:
    """Return the clearance of shims or strips a side as it comes out, mm; below 0 they jam."""
    return design.mold.slit_clearance - walls_close(design, process)


def grooves(case: Case) -> list[Narrowest]:
    """Return the narrowest groove of each kind: the highest ridge's in the cavity, a shim's in a comb."""
    design, skin = case.design, skin_of(case.design)
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
        tooth = skin_of(case.design).tooth()
        return [tooth] if tooth else []
    return [_comb_tooth(case.design)] if case.part.role is PartRole.COMB else []


@lru_cache(maxsize=8)
def _comb_tooth(design: Design) -> Narrowest:
    """The narrowest tooth between two neighbouring notches of a comb, the same by every process."""
    gap = design.mold.slit_clearance
    slots = sorted(section(design).slots, key=lambda slot: slot.centre.x)
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
    for tooth in teeth(case):
        yield from below("wall", case, tooth.where, tooth.width, case.process.wall)


def below(rule: str, case: Case, where: str, size: float, least: float) -> Iterator[Finding]:
    """Yield a warning where a size is below the least that the process makes."""
    if size < least - _ROUNDING:
        yield case.breaks(rule, where, size, least, "mm", scaled(size, least))


def _slender(case: Case) -> Iterator[Finding]:
    """A tooth that bends under the tool or breaks in use; in the cavity its mean width bears it."""
    most = case.process.tooth_ratio
    for tooth in teeth(case):
        width = tooth.width
        if case.part.role in CAVITIES:
            ridge = skin_of(case.design).profile
            width += (ridge.root_width - ridge.tip_width) / 2
        if most and tooth.height > most * width:
            remedy = f"a height of at most {most * width:.3g} mm, or ridges or slots further apart"
            times = "times as high as wide"
            yield case.breaks("slender", tooth.where, tooth.height / width, most, times, remedy)


def _hole(case: Case) -> Iterator[Finding]:
    sizes = [2 * min(bore.radius, bore.far_radius) for bore in bores(case.part)]
    if sizes and min(sizes) < case.process.hole - _ROUNDING:
        remedy = "drill it afterwards, or make it larger"
        yield case.breaks("hole", "bore", min(sizes), case.process.hole, "mm", remedy)


def _clearance(case: Case) -> Iterator[Finding]:
    """One key for all that slides, so one finding a process. Coat and growth are on both parts."""
    least = case.process.clearance + 2 * walls_close(case.design, case.process)
    clearance = case.design.mold.clearance
    if clearance < least - _ROUNDING:
        place = f"sliding parts, by {case.name}"
        yield Finding(
            "clearance", place, clearance, least, "mm", "warning", f"mold.clearance of {least:g} mm"
        )


def _slit_fit(case: Case) -> Iterator[Finding]:
    """By the clearance that comes out; where nothing is left of it, the rule `notch` reports it."""
    left, limit = slit_play(case.design, case.process), case.process.tolerance
    if case.part.role is PartRole.COMB and -_ROUNDING <= left < limit - _ROUNDING:
        remedy = "try each shim in its notch and lap the notch where it binds"
        yield case.breaks("slit fit", "fit of shims and notches", left, limit, "mm", remedy, grave=False)


def _notch_room(case: Case) -> Iterator[Finding]:
    """A note where straight notches let silicone in beside shims that are arcs."""
    if case.part.role is not PartRole.COMB:
        return
    room, gap = notch_rise(case.design, section(case.design).slots), case.design.mold.slit_clearance
    if room > gap:
        place = f"{case.part.role.label}, straight notches round shims that rise in them"
        remedy = "cut the fins off the skin's ends; a thinner mold.end_plate leaves shorter ones"
        yield Finding("notch room", place, room, gap, "mm", "note", remedy)


def _cure(case: Case) -> Iterator[Finding]:
    material = silicone(case.design)
    if case.process.inhibits_platinum and material.platinum_cure:
        place = f"{case.name} parts may keep {material.name}, a platinum-cured silicone, from curing"
        remedy = "wash, post-cure and bake the parts, seal them, and cast a trial first"
        yield Finding("cure inhibition", place, 1.0, 0.0, "", "note", remedy)


RULES: tuple[Rule, ...] = (_gap, _wall, _slender, _hole, _clearance, _slit_fit, _notch_room, _cure)


def material_findings(design: Design) -> Iterator[Finding]:
    """Yield a warning where the material's name and its modulus are those of two silicones."""
    if mismatch := foreign_modulus(design):
        named, modulus, remedy = mismatch
        named_range, value = named.young_modulus, modulus.value
        where = f"material.young_modulus, which is not that of {named.name}"
        limit = named_range.high if value > named_range.high else named_range.low
        yield Finding("silicone", where, value, limit, "MPa", "warning", remedy)


def shim_sag(design: Design) -> float:
    """Return how far a shim hangs through between its combs, flat and not pulled straight, mm.

    A beam on two supports under its own weight, 5 q l^4 / (384 E I) (handbooks), across its thickness: an
    upright shim hangs by far less. 0 without slots or shims.
    """
    slot = skin_of(design).slot
    if slot is None or design.mold.method != "shim":
        return 0.0
    return 5 / 32 * STEEL_WEIGHT * design.skin.length**4 / (STEEL_MODULUS * slot.thickness**2)


def shim_findings(design: Design) -> list[Finding]:
    """Return a warning where a shim is so slender that its own weight moves the slot."""
    slot = skin_of(design).slot
    sag, bend_findings = shim_sag(design), _shim_bend(design)
    if slot is None or sag <= SAG_SHARE * slot.thickness:
        return bend_findings
    limit = SAG_SHARE * slot.thickness
    most = design.skin.length * (limit / sag) ** 0.25
    remedy = f"a skin.length of at most {most:.3g} mm, or a thicker slot; pull shims straight"
    where = "shims, sagging between their combs"
    return [*bend_findings, Finding("slender", where, sag, limit, "mm", "warning", remedy)]


def shim_bend(design: Design) -> float:
    """Return the strain that a straight shim would take, bent on edge into its slot's arc: half its depth by
    the arc's radius. 0 where slots are straight."""
    slot = skin_of(design).slot
    radius = design.skin.curvature_radius_y
    if slot is None or radius is None or design.mold.method != "shim":
        return 0.0
    return slot.depth / 2 / radius


def _shim_bend(design: Design) -> list[Finding]:
    """A note where straight stock would stay bent. Below that it buckles sideways between its combs, so the
    casting sheet asks for arcs in any case."""
    strain = shim_bend(design)
    if strain <= SHIM_ELASTIC:
        return []
    where, remedy = "shims, if bent on edge from straight stock", "cut them as arcs, as the sheet says"
    return [Finding("shim bend", where, strain, SHIM_ELASTIC, "", "note", remedy)]
