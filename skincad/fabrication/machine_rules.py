"""Rules of the machine: layers and overhangs, its build volume, and what a round tool can't reach.

A tool reaches the opening of the space that it cuts by a disk of its radius, in the plane of a part's
section: a ball-end mill along y and a wire along y both sweep that disk. A corner of the space with the angle
a keeps r (1 / sin(a / 2) - 1) of material on its bisector: a right angle 0.414 r.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
import shapely
from numpy.typing import NDArray

from skincad.fabrication.crests import listed_crests, snapping_remarks, uncertain_ridges
from skincad.fabrication.job import Job
from skincad.fabrication.rules import (
    FINER_COMBS,
    Case,
    Finding,
    Rule,
    coating,
    drawn_at,
    error,
    grooves,
    note,
    slit_play,
    walls_close,
)
from skincad.inputs.process import Process
from skincad.inputs.skin_tables import RADIUS_Y
from skincad.shape.curves import Loop, Segment, polygon
from skincad.solids.cavity import parts_at_tips
from skincad.solids.mold import mold
from skincad.solids.pins import hole_block
from skincad.solids.plan import (
    CAVITIES,
    END_PLATES,
    Body,
    Bore,
    Part,
    PartRole,
    Prism,
    RevolvedBody,
    TurnedBody,
    plain,
    unturned,
)

if TYPE_CHECKING:
    import trimesh

CHORD = 2e-5  # mm, of the polygons that stand for arcs; depths below are exact to `ERROR`
ERROR = 5 * CHORD  # two buffers and the outline's own chords, and one in reserve
TOLD = 1e-3  # mm; by less than that a note is none
_SAMPLES = 8  # least points a segment besides its chords' ends; corners are always among them
CREST_TOLERANCE = 0.02  # mm, asked: of a crest, to what the casting sheet says of it
BED = 1e-6  # mm, rounding of the lowest facets
_ROUNDING_DEG = 1e-6
PIXEL_CHORD = 0.01  # mm, of arcs: no machine's limit is that sharp
UPRIGHT_TOLERANCE = 1e-6  # mm, by which an upright notch's walls may lean from end to end
CLEARANCE_STEP = 1e-3  # mm, to which a remedy's clearance is rounded up
# a corner of 89 degrees leaves 2 % more than a right angle: no two are the same on a fan
_CORNER_ALLOWANCE = 1.02
_ROUNDING = 1e-9  # mm


@lru_cache(maxsize=64)
def left_standing(outline: Loop, radius: float, *, from_above: bool = False) -> list[float]:
    """Return for each segment of a part's outline how thick (mm) the material is that a tool of this radius
    leaves on it at most: the largest distance of its points to what the tool reaches.

    `from_above`: the tool comes down z, so nothing under an overhang is cut either. Exact to `ERROR`; too
    small where the nearest reached place lies behind a wall thinner than what is left.
    """
    rows = [s.points(np.linspace(0, 1, max(_SAMPLES, s.pieces(CHORD)) + 1)) for s in outline]
    body = shapely.Polygon(polygon(outline, CHORD))
    solid = body.union(_shade(body)) if from_above else body
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


def _shade(body: shapely.Polygon) -> shapely.Geometry:
    """Everything straight below an outline's overhanging edges, down to its lowest level."""
    corners, low = shapely.orient_polygons(body).exterior.coords, body.bounds[1]
    quads = [
        shapely.Polygon([(a[0], low), (b[0], low), b, a])
        for a, b in pairwise(corners)
        if b[0] > a[0] and max(a[1], b[1]) > low
    ]
    return shapely.union_all(quads)


def _edges(region: shapely.Geometry) -> NDArray[np.object_]:
    rings = [np.asarray(ring.coords) for ring in shapely.get_parts(shapely.boundary(region))]
    pairs = np.concatenate([np.stack([ring[:-1], ring[1:]], axis=1) for ring in rings])
    edges: NDArray[np.object_] = shapely.linestrings(pairs)
    return edges


def on_end(part: Part, process: Process) -> bool:
    """Whether a part is printed with its y face on the bed."""
    return part.role in END_PLATES or (part.role in CAVITIES and process.orientation == "end")


def laid_on_end(job: Job, part: Part) -> bool:
    """Whether a part of a design is printed with its y face on the bed."""
    return on_end(part, job.process(part))


def _details(case: Case) -> Iterator[Finding]:
    """The cavity's shapes that a pixel or a layer swallows. Flat on the bed the crown's rise is cut into
    layers; on end, the section lies in the layers' plane, whose detail is the pixel."""
    process, ridge = case.process, case.job.skin.profile
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
    Bores up to the process's bridge are left out: horizontal ones and the ends of blind ones close by
    themselves."""
    process, part = case.process, unturned(case.part)
    if not process.layer:
        return
    end = on_end(part, process)

    def closes(cut: Body) -> bool:
        return isinstance(cut, Bore) and 2 * cut.radius <= process.bridge

    cuts = tuple(cut for cut in part.cuts if not closes(plain(cut)))
    angle, area = overhang(replace(part, cuts=cuts), process, end)
    if area > 0:
        place = f"{area:.3g} mm2 as printed {'on end' if end else 'flat'}"
        turned = "flat" if end else "end"
        _, other = overhang(replace(part, cuts=cuts), process, not end)
        remedy = "support it" if other else f'orientation = "{turned}", or support it'
        yield case.breaks("overhang", place, angle, process.overhang, "deg", remedy)


def crest_findings(job: Job) -> Iterator[Finding]:
    """Yield a note where crests may come out a layer lower or higher than the casting sheet says."""
    which, layer = uncertain_ridges(job), job.cavity_process.layer
    if which and layer > CREST_TOLERANCE:
        remedy = "; ".join(snapping_remarks(job)) or "another mold.floor"
        where = f"crest {listed_crests(which)} may come out a layer lower or higher than the sheet says"
        yield note("crest layer", where, layer, CREST_TOLERANCE, "mm", remedy)


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


def extent(part: Part) -> tuple[float, float, float]:
    """Return how long a part is along x, y and z, mm, as its body is: before cuts, and before it is turned
    into its mold."""
    body = unturned(part).body
    if not isinstance(body, Prism):
        raise ValueError("a made part is a prism less its cuts")
    flat = polygon(body.outline, PIXEL_CHORD)
    (a, b), along = np.ptp(flat, axis=0).tolist(), body.high - body.low
    x, y, z = {"x": (along, a, b), "y": (a, along, b), "z": (a, b, along)}[body.axis]
    if part.adds:  # a plug's, under it
        low, top = (
            (body.low, body.high) if body.axis == "z" else (float(flat[:, 1].min()), float(flat[:, 1].max()))
        )
        z = top - min(low, *(_lowest(added) for added in part.adds))
    return x, y, z


def _lowest(added: TurnedBody | RevolvedBody) -> float:
    """How low what is added under a plug reaches in its middle, mm."""
    if isinstance(added, RevolvedBody):
        return float(polygon(added.outline, PIXEL_CHORD)[:, 1].min())
    return added.origin[2] - max(s.end.z for s in added.outline)


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
    design = case.job.design
    remedy = f"a larger machine (build_x, build_y and build_z in [printer.{case.name}])"
    for count in range(design.mold.cavities - 1, 0, -1):
        fewer = mold(design.with_(mold={"cavities": count}))
        if _too_long(fewer.first(case.part.role), case.process) is None:
            remedy = f"mold.cavities of at most {count}, or {remedy}"
            break
    where = f"{case.part.role.label}, by {case.name}"
    yield error("build volume", where, *long, "mm", remedy)


def _pixel_steps(job: Job) -> tuple[float, bool]:
    """How many pixels across a leaning notch its steps take at most, 0 where none leans; and whether one
    stands upright. A notch leans if its walls leave a pixel's column at all."""
    skin = job.skin
    slot = skin.slot
    if slot is None:
        return 0.0, False
    tilt = math.radians(slot.tilt)
    leans = [skin.lean(i) + side * tilt for i in range(1, skin.count + 1) for side in (-1, 1)]
    stepped = [a for a in leans if abs(math.sin(a)) * slot.depth > UPRIGHT_TOLERANCE]
    most = max((abs(math.cos(a)) + abs(math.sin(a)) for a in stepped), default=0.0)
    return most, len(stepped) < len(leans)


def passage(job: Job, width: float, pixel: float) -> float:
    """Return the thickest plate that is sure to pass all notches of this width, mm, as a screen exposes them.

    Upright, a notch is as many whole pixels wide as fit into it, wherever it lies on the screen. In a leaning
    one the corner of a pixel whose middle is outside stands in by up to half its width across, at both walls.
    """
    pixels, upright = _pixel_steps(job)
    whole = math.floor(width / pixel + _ROUNDING) * pixel
    return min([whole] * upright + [width - pixels * pixel] * (pixels > 0))


def _notch(case: Case) -> Iterator[Finding]:
    """What is left of a comb's notch by whole pixels, and by a coat and growth on both walls, against what
    lies in it: an error, since no shim goes in."""
    process, job = case.process, case.job
    coat, wall = coating(job, process), walls_close(job, process)
    pixel = process.pixel if process.tool == "screen" else 0.0
    if case.part.role is not PartRole.COMB or not (pixel or wall):
        return
    (notch,) = grooves(case)
    need = job.design.core_thickness
    left = max(0.0, (passage(job, notch.width, pixel) if pixel else notch.width) - 2 * wall)
    if left >= need - _ROUNDING or notch.width < process.gap - _ROUNDING:  # the rule `gap` reports the latter
        return
    pixels, upright = _pixel_steps(job)
    wide = need + 2 * wall + pixel * pixels
    if pixel and upright:
        wide = max(wide, math.ceil((need + 2 * wall) / pixel - _ROUNDING) * pixel)
    least = math.ceil((wide - need) / 2 / CLEARANCE_STEP - _ROUNDING) * CLEARANCE_STEP
    ways = ("in whole pixels", pixel), ("under its coat", coat), ("grown", process.growth)
    what = " and ".join(words for words, size in ways if size)
    where = f"{notch.where} {what}"
    place = f"{case.part.role.label}, {where}, by {case.name}"
    yield error("notch", place, left, need, "mm", f"mold.slit_clearance of {least:.3g} mm, {FINER_COMBS}")


MACHINE_RULES: tuple[Rule, ...] = (_build_volume, _notch)


def _reach(case: Case) -> Iterator[Finding]:
    """What the tool leaves: a warning in a ridge's groove beyond the tolerance, and elsewhere beyond what any
    tool leaves in a right angle; there a note where a part's sharp edge would not go in."""
    reach, body = case.process.reach, case.along.body
    if not reach or not isinstance(body, Prism) or body.axis != "y":
        return
    milled_down = case.part.role in CAVITIES and case.process.tool in ("mill", "lathe")
    left = left_standing(body.outline, reach, from_above=milled_down)
    depths = sorted(zip(left, range(len(left)), body.outline, strict=True), reverse=True)
    holes = _deepest_holes(case) if case.part.role in CAVITIES and case.process.tool == "mill" else []
    in_holes = [
        (depth, s)
        for hole in holes
        for depth, s in zip(left_standing(hole, reach, from_above=True), hole, strict=True)
        if s.feature is not None
    ]
    in_holes.sort(key=lambda row: -row[0])
    bare = case.job.skin.bare  # the face is the feature, and no groove
    grooved = [(depth, s) for depth, _, s in depths if s.feature is not None and not bare]
    yield from _in_grooves(case, [*in_holes, *grooved])
    yield from _elsewhere(case, [(depth, s) for depth, _, s in depths if s.feature is None or bare])


def _deepest_holes(case: Case) -> list[Loop]:
    """The blocks of the pins' holes that a tool reaches least: the deepest one, and the most leaning one."""
    skin = case.job.skin
    cup = next((s for s in skin.profile.outline if s.kind == "crown"), None)
    through = cup and case.job.closed.of(PartRole.BASE) and cup.radius >= case.process.reach
    if not case.job.holes or through:  # of a hole that goes through, the cup alone has a bottom
        return []
    worst = (
        max(skin.placed, key=lambda p: p.feature.height),
        max(skin.placed, key=lambda p: round(abs(p.lean), 9)),
    )
    return [hole_block(placed) for placed in dict.fromkeys(worst)]


def _in_grooves(case: Case, depths: list[tuple[float, Segment]]) -> Iterator[Finding]:
    over = [(d, s) for d, s in depths if d > case.process.tolerance + ERROR]
    if not over:
        return
    depth, worst = over[0]
    count = len({s.feature for _, s in over})
    others = f" and {count - 1} more" if count > 1 else ""
    skin = case.job.skin
    place = f"{worst.kind.replace('_', ' ')} of {skin.named(worst.feature or 1)}{others}"
    reach, ridge = case.process.reach, skin.profile
    _, tip_key = case.job.design.features.widths
    remedy = f"a tip_fillet of {reach:g} mm, the tool's radius"
    if ridge.tip_width < 2 * reach:
        remedy = f"a {tip_key} above {2 * reach:g} mm and a tip_fillet of {reach:g} mm"
    elif ridge.tip_fillet >= reach:
        remedy = "no undercut, which a tool from above can't cut"
    yield case.breaks("tool reach", place, depth, case.process.tolerance, "mm left", remedy)


def _elsewhere(case: Case, depths: list[tuple[float, Segment]]) -> Iterator[Finding]:
    if not depths:
        return
    depth, worst = depths[0]
    reach, choice = case.process.reach, case.job.design.mold
    comb = case.part.role is PartRole.COMB
    play = math.sqrt(2) * max(0.0, slit_play(case.job, case.process)) if comb else choice.clearance
    limit = play + case.process.tolerance
    if depth > _CORNER_ALLOWANCE * corner(reach, math.pi / 2) + ERROR:
        notch = grooves(case)[0].width if comb else math.inf
        remedy = f"room for a tool of {2 * reach:g} mm" + (f" in {notch:.3g} mm" if comb else "")
        yield case.breaks("tool reach", _place(case, worst), depth, limit, "mm left", remedy)
    elif depth > limit + TOLD:
        what = "the shims' edges" if comb else "the carrier's edges"
        remedy = f"break {what} by {depth - play:.2g} mm"
        yield case.breaks("tool reach", _place(case, worst), depth, limit, "mm left", remedy, grave=False)


def _place(case: Case, segment: Segment) -> str:
    """Name a segment: the slot that it is next to in a comb, else its place in its drawing."""
    x, z = (segment.start.x + segment.end.x) / 2, (segment.start.z + segment.end.z) / 2
    if case.part.role is PartRole.COMB:
        slot = min(case.job.section.slots, key=lambda s: math.hypot(s.centre.x - x, s.centre.z + z))
        return f"notch {slot.side} of ridge {slot.feature}"
    return f"corner near {drawn_at(case.part, x, z)}"


def _depth(case: Case) -> Iterator[Finding]:
    """A groove deeper than the thickest tool that fits it can cut; a comb is cut through along y."""
    least, most = 2 * case.process.tool_radius, case.process.groove_ratio
    cavity = case.part.role in CAVITIES
    for groove in grooves(case):
        depth = groove.height if cavity else case.job.design.mold.end_plate
        bottom = cavity and not parts_at_tips(case.job.design)
        fits = min(groove.width, 2 * case.job.skin.profile.tip_fillet) if bottom else groove.width
        tool = max(fits, least)
        if most and groove.width >= least and depth > most * tool:
            key = f"{case.job.skin.family}.height" if cavity else "mold.end_plate"
            remedy = f"{key} of at most {most * tool:g} mm"
            yield case.breaks("tool depth", groove.where, depth / tool, most, "tool diameters", remedy)


def _straight_cut(case: Case) -> Iterator[Finding]:
    """A wire is straight: it cuts no trough that is bent along it, or turns. A lathe turns a round cavity."""
    disc = case.part.role is PartRole.CAVITY and case.job.closed.of(PartRole.BLOCK)
    if case.process.tool == "lathe" and (not disc or case.job.holes):
        remedy = (
            "mill or print it: the cavity of a round skin without pins is turned, with a mold.block_process"
        )
        where = f"{case.part.role.label}, by a lathe, which does not make it"
        yield error("tool reach", where, 1.0, 0.0, "", remedy)
    if case.process.tool == "wire" and case.part.straight and not case.job.bent:
        where, remedy = "a trough that turns, which a wire does not cut", "mill, sink-erode or print it"
        yield error("tool reach", f"{case.part.role.label}, {where}", 1.0, 0.0, "", remedy)
    elif case.process.tool == "wire" and case.part.straight:
        angle, remedy = 2 * case.job.rise, f"mill, sink-erode or print it, or drop {RADIUS_Y}"
        yield case.breaks("tool reach", "bent along y", angle, 0.0, "deg end to end", remedy)
    skin = case.job.skin
    if case.process.tool == "wire" and case.part.role in CAVITIES and case.job.holes:
        where = f"{case.part.role.label}, blind holes of {skin.counted}, by {case.name}"
        remedy = "mill, sink-erode or print it: a wire goes through"
        yield error("tool reach", where, float(skin.count), 0.0, "holes", remedy)


TOOL_RULES: tuple[Rule, ...] = (_reach, _depth, _straight_cut)
