"""The rules of making a mold's parts: what a process can't make, by layers, machines and tools.

Knife edges: corners of a made part so sharp that they chip or bend, and leave a flash where they part. At a
corner of the plan's outline the part's own angle lies between the tangents of the two segments. What is
worked here is the outline's plane; along a prism every face meets its ends at a right angle.

Material that a round tool leaves: the opening of the space that it cuts by a disk of its radius, in the plane
of a part's section. A ball-end mill along y and a wire along y both sweep that disk. A corner of the space
with the angle a keeps r (1 / sin(a / 2) - 1) of material on its bisector: a right angle 0.414 r.

A rule is a function of a case, one part by one process, that yields a finding for each limit it breaks.
Widths are exact: they are the design's own, or distances between the plan's polygons.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
import shapely
from numpy.typing import NDArray

from skincad.base.arrays import Array
from skincad.fabrication.crests import snapping_remarks, uncertain_ridges
from skincad.fabrication.finding import Finding
from skincad.fabrication.strips import STEEL_MODULUS
from skincad.inputs.design import Design
from skincad.inputs.material import foreign_modulus, silicone
from skincad.inputs.process import Process, processes
from skincad.shape.curves import Loop, Point, Segment, polygon
from skincad.shape.skin import GUARD_TOLERANCE, Narrowest, section, skin_of
from skincad.solids.layout import end_angle
from skincad.solids.mold import ClosedMold, mold
from skincad.solids.plan import (
    CAVITIES,
    END_PLATES,
    Bore,
    Part,
    PartRole,
    Prism,
    RevolvedBody,
    bores,
    plain,
    unturned,
)
from skincad.solids.split import notch_rise

if TYPE_CHECKING:
    import trimesh


LEAST_ANGLE = 30.0  # deg, assumption: a more pointed edge of metal or resin chips within a few castings
_SHORTEST = 1e-6  # mm; a shorter segment has no direction to speak of


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
        where = f"{case.part.role.label}, x {place.x:.3g}, z {place.z:.3g} mm"
        remedy = "a slot or flank that meets its parting line at a larger angle, or a larger curvature_radius"
        yield Finding(
            rule="knife edge",
            where=where,
            measured=angle,
            limit=LEAST_ANGLE,
            unit="deg",
            severity="warning",
            remedy=remedy,
        )


EDGE_RULES: tuple[Rule, ...] = (_knife_edge,)


CHORD = 2e-5  # mm, of the polygons that stand for arcs; depths below are exact to `ERROR`
ERROR = 5 * CHORD  # two buffers and the outline's own chords, and one in reserve
_SAMPLES = 8  # least points a segment besides its chords' ends; corners are always among them


def left_standing(outline: Loop, radius: float, *, from_above: bool = False) -> list[float]:
    """Return for each segment of a part's outline how thick (mm) the material is that a tool of this radius
    leaves on it at most: the largest distance of its points to what the tool reaches.

    `from_above`: the tool comes down z, so nothing under an overhang is cut either. Exact to `ERROR`; too
    small where the nearest reached place lies behind a wall thinner than what is left.
    """
    rows = [s.points(np.linspace(0, 1, max(_SAMPLES, s.pieces(CHORD)) + 1)) for s in outline]
    body = shapely.Polygon(polygon(outline, CHORD))
    solid = body.union(_shade(np.asarray(body.exterior.coords))) if from_above else body
    quarter = max(8, math.ceil(math.pi / 4 / math.sqrt(CHORD / max(2 * radius, CHORD))))
    # what the tool's centre can't enter is the solid grown by r; what it reaches is the rest grown by r
    room = shapely.box(*body.bounds).buffer(4 * radius, join_style="mitre")
    centres = room.difference(solid.buffer(radius, quad_segs=quarter))
    reached = centres.buffer(radius, quad_segs=quarter)
    edges = _edges(reached)
    _, distances = shapely.STRtree(edges).query_nearest(
        shapely.points(np.vstack(rows)), return_distance=True, all_matches=False
    )
    ends = np.cumsum([len(points) for points in rows])
    return [float(part.max()) for part in np.split(distances, ends[:-1])]


def corner(radius: float, angle: float) -> float:
    """Return what a tool leaves on the bisector of a corner of this angle (rad), mm."""
    return radius * (1 / math.sin(angle / 2) - 1)


def _shade(corners: Array) -> shapely.Geometry:
    """Everything straight below an outline's overhanging edges, down to its lowest level."""
    low = corners[:, 1].min()
    quads = [
        shapely.Polygon([(a[0], low), (b[0], low), b, a])
        for a, b in zip(_ccw(corners)[:-1], _ccw(corners)[1:], strict=True)
        if b[0] > a[0] and max(a[1], b[1]) > low
    ]
    return shapely.union_all(quads)


def _ccw(corners: Array) -> Array:
    return corners if shapely.is_ccw(shapely.LinearRing(corners)) else corners[::-1]


def _edges(region: shapely.Geometry) -> NDArray[np.object_]:
    rings = [np.asarray(ring.coords) for ring in shapely.get_parts(shapely.boundary(region))]
    pairs = np.concatenate([np.stack([ring[:-1], ring[1:]], axis=1) for ring in rings])
    edges: NDArray[np.object_] = shapely.linestrings(pairs)
    return edges


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
        return Finding(
            rule=rule,
            where=where,
            measured=measured,
            limit=limit,
            unit=unit,
            severity="warning" if grave else "note",
            remedy=remedy,
        )


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
            rule="clearance",
            where=place,
            measured=clearance,
            limit=least,
            unit="mm",
            severity="warning",
            remedy=f"mold.clearance of {least:g} mm",
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
        yield Finding(
            rule="notch room",
            where=place,
            measured=room,
            limit=gap,
            unit="mm",
            severity="note",
            remedy=remedy,
        )


def _cure(case: Case) -> Iterator[Finding]:
    material = silicone(case.design)
    if case.process.inhibits_platinum and material.platinum_cure:
        place = f"{case.name} parts may keep {material.name}, a platinum-cured silicone, from curing"
        remedy = "wash, post-cure and bake the parts, seal them, and cast a trial first"
        yield Finding(
            rule="cure inhibition",
            where=place,
            measured=1.0,
            limit=0.0,
            unit="",
            severity="note",
            remedy=remedy,
        )


RULES: tuple[Rule, ...] = (_gap, _wall, _slender, _hole, _clearance, _slit_fit, _notch_room, _cure)


def material_findings(design: Design) -> Iterator[Finding]:
    """Yield a warning where the material's name and its modulus are those of two silicones."""
    if mismatch := foreign_modulus(design):
        named, modulus, remedy = mismatch
        named_range, value = named.young_modulus, modulus.value
        where = f"material.young_modulus, which is not that of {named.name}"
        limit = named_range.high if value > named_range.high else named_range.low
        yield Finding(
            rule="silicone",
            where=where,
            measured=value,
            limit=limit,
            unit="MPa",
            severity="warning",
            remedy=remedy,
        )


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
    return [
        *bend_findings,
        Finding(
            rule="slender",
            where=where,
            measured=sag,
            limit=limit,
            unit="mm",
            severity="warning",
            remedy=remedy,
        ),
    ]


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
    return [
        Finding(
            rule="shim bend",
            where=where,
            measured=strain,
            limit=SHIM_ELASTIC,
            unit="",
            severity="note",
            remedy=remedy,
        )
    ]


CREST_TOLERANCE = 0.02  # mm, asked: of a crest, to what the casting sheet says of it
BED = 1e-6  # mm, rounding of the lowest facets
_ROUNDING_DEG = 1e-6


def on_end(part: Part, process: Process) -> bool:
    """Whether a part is printed with its y face on the bed."""
    return part.role in END_PLATES or (part.role in CAVITIES and process.orientation == "end")


def laid_on_end(design: Design, part: Part) -> bool:
    """Whether a part of a design is printed with its y face on the bed."""
    return on_end(part, processes(design.printer)[maker(design, part)])


def _details(case: Case) -> Iterator[Finding]:
    """The cavity's shapes that a pixel or a layer swallows. Flat on the bed the crown's rise is cut into
    layers; on end, the section lies in the layers' plane, whose detail is the pixel."""
    process, ridge = case.process, skin_of(case.design).profile
    if not process.layer or case.part.role not in CAVITIES:
        return
    end = on_end(case.part, process)
    rise = process.pixel if end else process.layer
    fine = process.pixel if end else max(process.pixel, process.layer)
    details = [
        ("crown's rise", ridge.crown, rise),
        ("tip fillet", ridge.tip_fillet, fine),
        ("root fillet", ridge.root_fillet, fine),
    ]
    for what, size, limit in details:
        if 0 < size < limit - _ROUNDING:
            ways = [f"multiply all lengths by {math.ceil(100 * limit / size) / 100:g}"]
            if not end and size >= process.pixel - _ROUNDING:
                ways.insert(0, f'print it on end (orientation = "end" in [printer.{case.name}])')
            remedy = f"it comes out stepped: {', or '.join(ways)}"
            yield case.breaks("detail", what, size, limit, "mm", remedy, grave=False)


def _overhang(case: Case) -> Iterator[Finding]:
    """Facets of the print mesh that lean out further than the process can without support, off the bed.
    Horizontal bores up to the process's bridge are left out: they close by themselves."""
    process, part = case.process, unturned(case.part)
    if not process.layer:
        return
    end = on_end(part, process)
    upright = "y" if end else "z"

    def closes(cut: Prism | RevolvedBody | Bore) -> bool:
        return isinstance(cut, Bore) and cut.axis != upright and 2 * cut.radius <= process.bridge

    cuts = tuple(cut for cut in part.cuts if not closes(plain(cut)))
    angle, area = overhang(replace(part, cuts=cuts), process, end)
    if area > 0:
        place = f"{area:.3g} mm2 as printed {'on end' if end else 'flat'}"
        turned = "flat" if end else "end"
        _, other = overhang(replace(part, cuts=cuts), process, not end)
        remedy = "support it" if other else f'orientation = "{turned}", or support it'
        yield case.breaks("overhang", place, angle, process.overhang, "deg", remedy)


def crest_findings(design: Design, closed: ClosedMold) -> Iterator[Finding]:
    """Yield a note where crests may come out a layer lower or higher than the casting sheet says."""
    which, layer = uncertain_ridges(design, closed), processes(design.printer)[design.mold.process].layer
    if which and layer > CREST_TOLERANCE:
        remedy = "; ".join(snapping_remarks(design, closed)) or "another mold.floor"
        where = f"crest {', '.join(map(str, which))} may come out a layer lower or higher than the sheet says"
        yield Finding(
            rule="crest layer",
            where=where,
            measured=layer,
            limit=CREST_TOLERANCE,
            unit="mm",
            severity="note",
            remedy=remedy,
        )


def overhang(part: Part, process: Process, end: bool) -> tuple[float, float]:
    """Return the steepest overhang of a part's print mesh in deg from the vertical, and the area in mm2 that
    is beyond the process's, without the face on the bed; (0, 0) where none is."""
    from skincad.fabrication.meshes import laid

    shape = laid(_print_mesh(part, process.chord), end, part)
    down = -np.asarray(shape.face_normals)[:, 2]
    corners = np.asarray(shape.vertices)[np.asarray(shape.faces)]
    lifted = corners[:, :, 2].max(axis=1) > BED
    angle = np.degrees(np.arcsin(np.clip(down, -1.0, 1.0)))
    over = lifted & (angle > process.overhang + _ROUNDING_DEG)
    areas = np.asarray(shape.area_faces)
    return (float(angle[over].max()), float(areas[over].sum())) if over.any() else (0.0, 0.0)


@lru_cache(maxsize=2)  # a part is laid both ways
def _print_mesh(part: Part, chord: float) -> trimesh.Trimesh:
    from skincad.fabrication.meshes import mesh

    return mesh(part, chord)


LAYER_RULES: tuple[Rule, ...] = (_details, _overhang)


PIXEL_CHORD = 0.01  # mm, of arcs: no machine's limit is that sharp
UPRIGHT_TOLERANCE = 1e-6  # mm, by which an upright notch's walls may lean from end to end
CLEARANCE_STEP = 1e-3  # mm, to which a remedy's clearance is rounded up


def extent(part: Part) -> tuple[float, float, float]:
    """Return how long a part is along x, y and z, mm, as its body is: before cuts, and before it is turned
    into its mold."""
    body = unturned(part).body
    if not isinstance(body, Prism):
        raise ValueError("a made part is a prism less its cuts")
    (a, b), along = np.ptp(polygon(body.outline, PIXEL_CHORD), axis=0).tolist(), body.high - body.low
    return {"x": (along, a, b), "y": (a, along, b), "z": (a, b, along)}[body.axis]


def _sides(part: Part, process: Process) -> list[tuple[float, float]]:
    """How long a part is as it lies in the machine, and how long it may be, mm. A print lies flat or on end,
    its longer side along the bed's; what is cut from stock is turned as it fits."""
    x, y, z = extent(part)
    longer, shorter = sorted((process.build_x, process.build_y), reverse=True)
    if not process.layer:
        room = sorted((longer, shorter, process.build_z))
        return list(zip(sorted((x, y, z)), room, strict=True))[::-1]
    if on_end(part, process):
        y, z = z, y
    return [(max(x, y), longer), (min(x, y), shorter), (z, process.build_z)]


def _too_long(part: Part, process: Process) -> tuple[float, float] | None:
    """The first side that is longer than the machine takes, and what it takes; 0 is no limit."""
    over = ((size, most) for size, most in _sides(part, process) if most and size > most + _ROUNDING)
    return next(over, None)


def _build_volume(case: Case) -> Iterator[Finding]:
    """An error: the part can't be made on this machine at all."""
    long = _too_long(case.part, case.process)
    if long is None:
        return
    design, remedy = case.design, f"a larger machine (build_x, build_y and build_z in [printer.{case.name}])"
    for count in range(design.mold.cavities - 1, 0, -1):
        fewer = mold(design.with_(mold={"cavities": count}))
        if _too_long(fewer.first(case.part.role), case.process) is None:
            remedy = f"mold.cavities of at most {count}, or {remedy}"
            break
    where = f"{case.part.role.label}, by {case.name}"
    yield Finding("build volume", where, *long, "mm", "error", remedy)


def _pixel_steps(design: Design) -> tuple[float, bool]:
    """How many pixels across a leaning notch its steps take at most, 0 where none leans; and whether one
    stands upright. A notch leans if its walls leave a pixel's column at all."""
    skin = skin_of(design)
    slot = skin.slot
    if slot is None:
        return 0.0, False
    tilt = math.radians(slot.tilt)
    leans = [skin.lean(i) + side * tilt for i in range(1, skin.count + 1) for side in (-1, 1)]
    stepped = [a for a in leans if abs(math.sin(a)) * slot.depth > UPRIGHT_TOLERANCE]
    most = max((abs(math.cos(a)) + abs(math.sin(a)) for a in stepped), default=0.0)
    return most, len(stepped) < len(leans)


def passage(design: Design, width: float, pixel: float) -> float:
    """Return the thickest plate that is sure to pass all notches of this width, mm, as a screen exposes them.

    Upright, a notch is as many whole pixels wide as fit into it, wherever it lies on the screen. In a leaning
    one the corner of a pixel whose middle is outside stands in by up to half its width across, at both walls.
    """
    pixels, upright = _pixel_steps(design)
    whole = math.floor(width / pixel + _ROUNDING) * pixel
    return min([whole] * upright + [width - pixels * pixel] * (pixels > 0))


def _notch(case: Case) -> Iterator[Finding]:
    """What is left of a comb's notch by whole pixels, and by a coat and growth on both walls, against what
    lies in it."""
    process, design, coat = case.process, case.design, coating(case.design, case.process)
    wall = walls_close(design, process)
    pixel = process.pixel if process.tool == "screen" else 0.0
    if case.part.role is not PartRole.COMB or not (pixel or wall):
        return
    (notch,) = grooves(case)
    need = design.core_thickness
    left = max(0.0, (passage(design, notch.width, pixel) if pixel else notch.width) - 2 * wall)
    if left >= need - _ROUNDING or notch.width < process.gap - _ROUNDING:  # the rule `gap` reports the latter
        return
    pixels, upright = _pixel_steps(design)
    wide = need + 2 * wall + pixel * pixels
    if pixel and upright:
        wide = max(wide, math.ceil((need + 2 * wall) / pixel - _ROUNDING) * pixel)
    least = math.ceil((wide - need) / 2 / CLEARANCE_STEP - _ROUNDING) * CLEARANCE_STEP
    ways = ("in whole pixels", pixel), ("under its coat", coat), ("grown", process.growth)
    what = " and ".join(words for words, size in ways if size)
    where = f"{notch.where} {what}"
    yield case.breaks("notch", where, left, need, "mm", f"mold.slit_clearance of {least:.3g} mm")


MACHINE_RULES: tuple[Rule, ...] = (_build_volume, _notch)


# a corner of 89 degrees leaves 2 % more than a right angle: no two are the same on a fan
_CORNER_ALLOWANCE = 1.02

_left = lru_cache(maxsize=64)(left_standing)


def _reach(case: Case) -> Iterator[Finding]:
    """What the tool leaves: a warning in a ridge's groove beyond the tolerance, and elsewhere beyond what any
    tool leaves in a right angle; there a note where a part's sharp edge would not go in."""
    reach, body = case.process.reach, case.along.body
    if not reach or not isinstance(body, Prism) or body.axis != "y":
        return
    milled_down = case.part.role in CAVITIES and case.process.tool == "mill"
    left = _left(body.outline, reach, from_above=milled_down)
    depths = sorted(zip(left, range(len(left)), body.outline, strict=True), reverse=True)
    yield from _in_grooves(case, [(depth, s) for depth, _, s in depths if s.feature is not None])
    yield from _elsewhere(case, [(depth, s) for depth, _, s in depths if s.feature is None])


def _in_grooves(case: Case, depths: list[tuple[float, Segment]]) -> Iterator[Finding]:
    over = [(d, s) for d, s in depths if d > case.process.tolerance + ERROR]
    if not over:
        return
    depth, worst = over[0]
    count = len({s.feature for _, s in over})
    others = f" and {count - 1} more" if count > 1 else ""
    place = f"{worst.kind.replace('_', ' ')} of ridge {worst.feature}{others}"
    reach, ridge = case.process.reach, skin_of(case.design).profile
    remedy = f"a tip_fillet of {reach:g} mm, the tool's radius"
    if ridge.tip_width < 2 * reach:
        remedy = f"a tip_width above {2 * reach:g} mm and a tip_fillet of {reach:g} mm"
    elif ridge.tip_fillet >= reach:
        remedy = "no undercut, which a tool from above can't cut"
    yield case.breaks("tool reach", place, depth, case.process.tolerance, "mm left", remedy)


def _elsewhere(case: Case, depths: list[tuple[float, Segment]]) -> Iterator[Finding]:
    if not depths:
        return
    depth, worst = depths[0]
    reach, choice = case.process.reach, case.design.mold
    comb = case.part.role is PartRole.COMB
    play = math.sqrt(2) * max(0.0, slit_play(case.design, case.process)) if comb else choice.clearance
    limit = play + case.process.tolerance
    if depth > _CORNER_ALLOWANCE * corner(reach, math.pi / 2) + ERROR:
        notch = grooves(case)[0].width if comb else math.inf
        remedy = f"room for a tool of {2 * reach:g} mm" + (f" in {notch:.3g} mm" if comb else "")
        yield case.breaks("tool reach", _place(case, worst), depth, limit, "mm left", remedy)
    elif depth > limit + ERROR:
        what = "the shims' edges" if comb else "the edges of what lies in it"
        remedy = f"break {what} by {depth - play:.2g} mm"
        yield case.breaks("tool reach", _place(case, worst), depth, limit, "mm left", remedy, grave=False)


def _place(case: Case, segment: Segment) -> str:
    """Name a segment: the slot that it is next to in a comb, else its place in the mold's frame."""
    x, z = (segment.start.x + segment.end.x) / 2, (segment.start.z + segment.end.z) / 2
    if case.part.role is PartRole.COMB:
        slot = min(section(case.design).slots, key=lambda s: math.hypot(s.centre.x - x, s.centre.z + z))
        return f"notch {slot.side} of ridge {slot.feature}"
    return f"corner near x {x:.3g}, z {z:.3g} mm"


def _depth(case: Case) -> Iterator[Finding]:
    """A groove deeper than the thickest tool that fits it can cut; a comb is cut through along y."""
    least, most = 2 * case.process.tool_radius, case.process.groove_ratio
    cavity = case.part.role in CAVITIES
    for groove in grooves(case):
        depth = groove.height if cavity else case.design.mold.end_plate
        fits = min(groove.width, 2 * skin_of(case.design).profile.tip_fillet) if cavity else groove.width
        tool = max(fits, least)
        if most and groove.width >= least and depth > most * tool:
            remedy = f"a depth of at most {most * tool:g} mm"
            yield case.breaks("tool depth", groove.where, depth / tool, most, "tool diameters", remedy)


def _straight_cut(case: Case) -> Iterator[Finding]:
    """A wire is straight: it cuts no trough that is bent along it."""
    if case.process.tool == "wire" and case.part.straight:
        angle = math.degrees(2 * end_angle(case.design))
        remedy = "mill, sink-erode or print it, or drop skin.curvature_radius_y"
        yield case.breaks("tool reach", "bent along y", angle, 0.0, "deg end to end", remedy)


TOOL_RULES: tuple[Rule, ...] = (_reach, _depth, _straight_cut)
