"""A part's drawing for the shop: dimensions, tables, tolerances and notes.

Tolerances on a shop drawing: those of the process, and which sizes matter and why. How far a crest may be off
follows from the check: until the verdict's margin is used up. What pins and slits allow follows from the gaps
that parts slide with.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

from skincad.fabrication.drawn_features import (
    ABOVE,
    FRONT,
    Datum,
    Groove,
    HoleGroup,
    Length,
    Notch,
    NutPocket,
    Slit,
    datums,
    downward,
    grooves_of,
    hole_groups,
    leftward,
    notches,
    number,
    pockets,
    seat_lengths,
    slits,
    views,
)
from skincad.fabrication.fasteners import PINNED
from skincad.fabrication.job import Job
from skincad.fabrication.papers import macro
from skincad.fabrication.patterns import CutProfile, cut_profile, pattern_words
from skincad.fabrication.printing import face_down
from skincad.fabrication.rules import Case, coating, grooves, slit_play, walls_close
from skincad.inputs.catalog import display_name
from skincad.inputs.feature_tables import Pin
from skincad.shape.skin import Skin
from skincad.solids.fasteners import METRIC
from skincad.solids.inserts import PIN_RADIUS
from skincad.solids.plan import CAVITIES, CutRole, Part, PartRole, Prism, RevolvedBody, TurnedBody
from skincad.solids.projection import Projection, Stroke, outlined

if TYPE_CHECKING:
    import cadquery as cq

CUTTERS = {"wire": "Wire", "mill": "Ball-end mill", "lathe": "Turning tool, its nose"}
GENERAL_RA = 1.6  # µm, source: what shops keep without a surcharge on milled and wire-cut faces
ACCURATE = {  # faces on which others close or from which strips hang
    PartRole.COMB: "inner face, lower face, slits and the edge under the keeper",
    PartRole.KEEPER: "inner face and the edge on the comb",
    PartRole.END_PLATE: "inner face and lower face",
    PartRole.CARRIER: "lower face, length and width",
    PartRole.PLUG: "lower face, the face on the ledge, length and width",
    PartRole.COVER: "lower face",
    PartRole.BASE: "upper face",
}
_BOTH = {"end a": "both ends", "below": "both faces"}
_TOOLS = {"mill": ", milled", "lathe": ", turned", "wire": ", wire erosion"}
Coordinate = Callable[[float], float]
NUT = "N"
LEANING = "leaning from upright, positive with the mouth to the right"
MOST_RUNS = 6  # of a hole's numbers in a row
LEVEL = 1e-6  # rad, by which a pin of a flat skin leans
MOST_HIDDEN = 64  # pins' holes drawn as hidden lines; more are a blur, which the view from above tells apart
MOST_ROWS = 40  # of a table of slits or grooves, assumption: more are read from the STEP file


# By how much each crest may be lower alone until the verdict's margin is used up, mm: empty where the check
# leaves none, None where nobody asked for it
Drops = tuple[float, ...] | None


def general_tolerance(job: Job, part: Part) -> str:
    """Return what holds where a size has no limits of its own."""
    process = job.process(part)
    return f"±{process.tolerance:g} (by {job.maker(part)})" if process.layer else "ISO 2768-m"


def surface_words(job: Job, part: Part) -> str:
    """Return how rough all faces may be, µm (ISO 21920-1), but those on the silicone where a shop cuts it; ""
    where the process says nothing of it."""
    process = job.process(part)
    rough = process.roughness if process.layer else max(process.roughness, GENERAL_RA)
    return f"Ra {rough:g}" if process.roughness else ""


def process_words(job: Job, part: Part) -> str:
    """Return how a part is made."""
    name, process = job.maker(part), job.process(part)
    based = f" (as {process.based_on})" if process.based_on not in (None, name) else ""
    return f"{name}{based}{_TOOLS.get(process.tool, '') if not process.layer else ', printed'}"


def material_words(job: Job, part: Part) -> str:
    """Return of what a part is, and whether it is sealed."""
    process = job.process(part)
    return process.material + (", sealed against silicone" if coating(job, process) else "")


def notes(job: Job, part: Part) -> list[str]:
    """Return what holds for the whole part."""
    edges = f"{'right' if leftward(part) else 'left'} and {'upper' if downward(part) else 'lower'}"
    coat = coating(job, job.process(part))
    words = _words("notes", job, part, edges=edges, down=face_down(job, part), pegs=_pegs(part), coat=coat)
    return [*words, *_cutter(Case(job, part, job.maker(part)))]


def _words(macro_name: str, job: Job, part: Part, **facts: Any) -> list[str]:
    """The lines of one of part-notes.md's macros."""
    facts |= {"job": job, "part": part, "process": job.process(part), "role": PartRole}
    return macro("papers/part-notes.md", macro_name, carved=part.role in CAVITIES, **facts).splitlines()


def _pegs(part: Part) -> list[tuple[float, float, float, list[str]]]:
    """A plug's pegs, by their lengths: neck, head and length, mm, and places from its middle."""
    by: dict[tuple[float, float, float], list[str]] = {}
    for body in part.adds:
        if isinstance(body, RevolvedBody):
            continue
        wide = sorted({round(s.end.x, 3) for s in body.outline if s.end.x > 0.0})
        if len(wide) == 2 and body.origin[:2] != (0.0, 0.0):  # else it is a round plug's middle
            key = 2 * wide[0], 2 * wide[1], max(s.end.z for s in body.outline)
            by.setdefault(key, []).append(f"({number(body.origin[0])}, {number(body.origin[1])})")
    return [(*size, places) for size, places in by.items()]


def _cutter(case: Case) -> list[str]:
    """The wire or mill of the process, and what it leaves beside it in the narrowest groove."""
    process, ridge = case.process, case.job.skin.profile
    takes = [(groove.width, f"a {groove.width:.4g} wide {groove.where}") for groove in grooves(case)]
    if not takes or process.tool not in CUTTERS:
        return []
    if case.part.role in CAVITIES and ridge.tip_fillet:
        takes.append((2 * ridge.tip_fillet, f"inner corners of radius {ridge.tip_fillet:g}"))
    width, where = min(takes)
    beside = (width - 2 * process.reach) / 2
    if beside < -1e-9:
        return []  # the rule `tool reach` reports what it leaves
    sparks = f" with a spark gap of {process.spark_gap:g} a side" if process.spark_gap else ""
    cutter = f"{CUTTERS[process.tool]} Ø{2 * process.tool_radius:g}{sparks}"
    left = f"for {where}, with {beside:.2g} a side for trim cuts" if beside >= 5e-4 else f"as wide as {where}"
    return [f"{cutter}: {left}."]


def what_matters(job: Job, part: Part, drops: Drops) -> list[str]:
    """Return which sizes of a part matter and why."""
    process, mold = job.process(part), job.design.mold
    if part.role is PartRole.COMB:
        drawn, play = mold.slit_clearance, slit_play(job, process)
    else:  # a carrier's to its seat
        drawn = mold.clearance
        play = drawn - walls_close(job, job.cavity_process) - walls_close(job, process)
    hollows = "" if job.skin.bare else "holes, " if job.holes else "grooves, "
    faces = ACCURATE.get(part.role, f"seat, trough, {hollows}both ends and the top")
    if not job.ends:
        faces = faces.replace("length and width", "diameter").replace(", both ends", "")
    pinned = {cut.role for cut in part.cuts} & PINNED
    sliding = job.fits(part).slide - PIN_RADIUS if pinned else None
    facts = {"faces": faces, "drops": drops, "sliding": sliding, "METRIC": METRIC}
    return _words("matters", job, part, drawn=drawn, play=play, **facts)


class DrawingTable(NamedTuple):
    """A table: its title, its heads and its rows."""

    title: str
    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


@dataclass(frozen=True, kw_only=True)
class Titled:
    """What the title block, the notes and the tables of any drawing say."""

    name: str
    document: str
    design: str
    revision: str
    what: str
    tables: tuple[DrawingTable, ...]
    notes: tuple[str, ...]
    process: str = ""
    material: str = ""
    tolerance: str = ""
    surface: str = ""  # where the process says nothing of it
    cut_from_solid: bool = False  # not printed


@dataclass(frozen=True, kw_only=True)
class PartDrawing(Titled):
    """A part's drawing: views by name and what is dimensioned in them; lengths mm."""

    views: dict[str, Projection]
    captions: dict[str, str]
    holes: tuple[HoleGroup, ...]
    pockets: tuple[NutPocket, ...]
    datums: tuple[Datum, ...]
    lengths: tuple[Length, ...]
    slits: tuple[Slit, ...]
    grooves: tuple[Groove, ...]
    profile: tuple[Stroke, ...]  # that a detail shows: the front view, or a bent mold's middle section
    cut: CutProfile | None  # what is cut right through, for DXF
    cut_notes: tuple[str, ...]  # what is said of it there


def part_drawing(job: Job, part: Part, shape: cq.Solid, drops: Drops) -> PartDrawing:
    """Return the drawing of a made part; `shape` is its solid in the mold."""
    from skincad.solids.occ import projection, solid

    rest = [cut for cut in part.cuts if cut.role is not CutRole.FEATURE]
    many = len(part.cuts) - len(rest) > MOST_HIDDEN
    plain = solid(replace(part, cuts=tuple(rest))) if many else shape
    seen = {
        view.name: projection(shape if view.name == ABOVE else plain, view.of_solid) for view in views(part)
    }
    holes, nuts = tuple(hole_groups(job, part, shape)), pockets(part)
    cut, carved = slits(job, part), grooves_of(job, part)
    datum = datums(part)
    tables = [
        _hole_table(holes, nuts, general_tolerance(job, part)),
        _places(holes, nuts, seen, part),
        _notch_table(notches(part), seen, part),
        _slit_table(cut, seen),
        _groove_table(job.skin, carved, seen, part, drops or ()),
        _pin_table(job, part, seen),
    ]
    ((left, low), (right, top)), cut_through = seen[FRONT].box(), cut_profile(part)
    (_, near), (_, far) = seen[ABOVE].box()
    overall = Length(FRONT, "u", left, right), Length(FRONT, "v", low, top), Length(ABOVE, "v", near, far)
    straight = part.straight.body if part.straight else None
    profile = outlined(straight.outline) if isinstance(straight, Prism) else seen[FRONT].visible
    words = [*notes(job, part), *what_matters(job, part, drops)]
    if job.design.mold.cavities > 1 and (cut or carved):
        words.append(_gang_words(job, part))
    return PartDrawing(
        name=part.name,
        document="part drawing",
        design=display_name(job.design),
        revision=job.design.revision,
        what=part.what,
        views=seen,
        captions={view.name: view.words for view in views(part)},
        holes=holes,
        pockets=nuts,
        datums=datum,
        lengths=(*overall, *seat_lengths(part, top)),
        slits=cut,
        grooves=carved,
        profile=profile,
        cut=cut_through,
        cut_notes=(*pattern_words("cut", process=job.process(part)),) if cut_through else (),
        tables=tuple(table for table in tables if table.rows),
        notes=(f"Datums: {'; '.join(f'{d.letter} {d.what}' for d in datum)}; {words[0]}", *words[1:]),
        process=process_words(job, part),
        material=material_words(job, part),
        tolerance=general_tolerance(job, part),
        surface=surface_words(job, part),
        cut_from_solid=not job.process(part).layer,
    )


def _pin_table(job: Job, part: Part, seen: dict[str, Projection]) -> DrawingTable:
    """The holes of pins or their tips' cups, as one pattern, a row a size; each place is in the STEP file."""
    skin, table = job.cast_skin, job.cast.features
    holes = [cut for cut in part.cuts if isinstance(cut, TurnedBody) and cut.role is CutRole.FEATURE]
    if not isinstance(table, Pin) or not holes:
        return DrawingTable("", (), ())
    through, cups = bool(holes[0].piece_of) and part.role is PartRole.CAVITY, part.role is PartRole.BASE
    sizes: dict[tuple[str, ...], list[int]] = {}
    first = holes[:: job.design.mold.cavities]  # a gang has each hole once for each skin
    for placed, hole in zip(skin.placed, first, strict=True):
        deep = placed.feature.height if hole.piece_of is None else max(s.end.z for s in hole.outline)
        edges = [2 * s.start.x for s in hole.outline if s.start.z == deep]
        edge = max(edges) if through else table.tip_diameter
        wide = 2 * hole.outline[0].start.x if cups else table.root_diameter
        crown = "-" if through else number(table.crown)
        size = number(wide), number(edge), crown, f"{deep:.3f}"
        sizes.setdefault(size, []).append(placed.number)
    rows = [
        (f"{len(numbers)}", _numbers(numbers) if len(sizes) > 1 else "all", *size)
        for size, numbers in [*sizes.items()][:MOST_ROWS]
    ]
    kind = "Through holes" if through else "Cups for the tips" if cups else "Blind holes"
    pattern = {
        "square": f"square, {table.columns} x {table.rows}" if table.columns else "square",
        "hex": "hexagonal, rows along x",
        "polar": "rings of 6, 12, 18, ...",
    }[table.pattern]
    x, y = (of(v) for of, v in zip(_coordinates(seen, ABOVE, part), holes[0].origin, strict=False))
    place = f"at x {number(x)}, y {number(y)}, next to end b"
    if table.pattern == "polar":
        place = f"at x {number(x)}, y {number(y)}, rings from +x towards end a"
    lean = max(abs(placed.lean) for placed in skin.placed)
    leaning = f" along the base, leaning up to {_degrees(math.degrees(lean))}" if lean > LEVEL else ""
    title = f"{kind} of {skin.count} pins: {pattern}, pitch {number(table.pitch)}{leaning}; pin 1 {place}"
    ends = ("Ø above", "Ø below") if through else ("Ø mouth" if cups else "Ø root", "Ø tip")
    return DrawingTable(title, ("count", "pins", *ends, "crown", "depth on axis"), tuple(rows))


def _numbers(numbers: list[int]) -> str:
    """Numbers with runs drawn together, as "1-4, 6"; of many runs the first."""
    runs: list[list[int]] = []
    for n in numbers:
        if runs and runs[-1][-1] == n - 1:
            runs[-1] = [runs[-1][0], n]
        else:
            runs.append([n, n])
    words = [f"{a}" if a == b else f"{a}-{b}" for a, b in runs]
    return ", ".join(words[:MOST_RUNS]) + (", ..." if len(words) > MOST_RUNS else "")


def _gang_words(job: Job, part: Part) -> str:
    """Where in the front view the slits and grooves of a gang's further skins lie."""
    first, *others = job.place.centres
    here, there = ("right", "left") if part.end == "b" else ("left", "right")
    offsets = " and ".join(number(x - first) for x in others)
    what = "Slits" if part.role is PartRole.COMB else "Seat, trough and grooves"
    return f"{what}: of the skin furthest {here}; the others' are {offsets} to the {there} of them."


def _hole_table(holes: tuple[HoleGroup, ...], nuts: tuple[NutPocket, ...], limits: str) -> DrawingTable:
    rows = []
    for g in holes:
        fit = "-" if g.limits in ("", "6H") else g.limits
        sides = _BOTH[g.sides[0]] if len(g.sides) == 2 else "".join(g.sides)
        opens = f"{sides}, {_degrees(math.degrees(g.lean))} aslant" if g.lean else sides
        name = f"{g.letter} ({len(g.holes)}x)"
        rows.append((name, g.purpose, g.size, fit, g.reach, g.callout or "-", opens))
    if nuts:
        size = f"{number(nuts[0].flats)} A/F"
        tolerance = limits.split(" ", maxsplit=1)[0] if limits.startswith("±") else ""
        name, deep = f"{NUT} ({len(nuts)}x)", number(nuts[0].depth)
        rows.append((name, "M3 nut, hexagon", size, tolerance, deep, "-", "end b"))
    return DrawingTable("Holes", ("hole", "for", "size", "limits", "depth", "thread", "open at"), tuple(rows))


def _degrees(angle: float) -> str:
    return f"{round(angle, 3) + 0.0:.3f}°"


def _places(
    holes: tuple[HoleGroup, ...], nuts: tuple[NutPocket, ...], seen: dict[str, Projection], part: Part
) -> DrawingTable:
    rows = []
    for group in holes:
        x, y = _coordinates(seen, group.view, part)
        rows += [(tag, number(x(u)), number(y(v))) for tag, (u, v) in group.holes.items()]
    x, y = _coordinates(seen, FRONT, part)
    rows += [(f"{NUT}{i}", number(x(p.at[0])), number(y(p.at[1]))) for i, p in enumerate(nuts, 1)]
    return DrawingTable("Positions of holes", ("hole", "x", "y"), tuple(rows))


def _coordinates(seen: dict[str, Projection], view: str, part: Part) -> tuple[Coordinate, Coordinate]:
    """How x and y count in a view: from its left and lower edge, or from those opposite."""
    (left, low), (right, high) = seen[view].box()
    return (
        (lambda x: right - x) if leftward(part) else (lambda x: x - left),
        (lambda y: high - y) if downward(part) and view == FRONT else (lambda y: y - low),
    )


def _notch_table(cut: tuple[Notch, ...], seen: dict[str, Projection], part: Part) -> DrawingTable:
    _, y = _coordinates(seen, FRONT, part)
    rows = []
    for way in dict.fromkeys(notch._replace(side="left") for notch in cut):
        sides = [notch.side for notch in cut if notch._replace(side="left") == way]
        use = "mark of the end" if way.role is CutRole.MARK else "pry notch"
        face = "outer face" if way.outer else "inner face"
        where = f"{' & '.join(sorted(sides))}, {face}"
        rows.append((use, f"{number(way.leg)} x 45°", where, *map(number, sorted((y(way.low), y(way.high))))))
    heads = ("notch", "size", "edge", "from y", "to y")
    return DrawingTable("Notches across upright edges", heads, tuple(rows))


def _slit_table(cut: tuple[Slit, ...], seen: dict[str, Projection]) -> DrawingTable:
    (left, low), _ = seen[FRONT].box()
    rows = [
        (f"{s.ridge} {s.side}", number(s.at[0] - left), number(s.at[1] - low), _degrees(s.lean))
        for s in cut[:MOST_ROWS]
    ]
    size = f"Slits, {number(cut[0].width)} wide: middle of the bottom; {LEANING}" if cut else ""
    return DrawingTable(size, ("ridge", "x", "y", "leaning"), tuple(rows))


def _groove_table(
    skin: Skin, carved: tuple[Groove, ...], seen: dict[str, Projection], part: Part, drops: tuple[float, ...]
) -> DrawingTable:
    x_of, _ = _coordinates(seen, FRONT, part)
    place, rows = skin.form.across, list[tuple[str, ...]]()
    start = x_of(0.0) if place == "radius" else 0.0
    for groove in carved[:MOST_ROWS]:
        x, z = groove.bottom
        across = number(x_of(x) - start)
        row = [str(groove.ridge), across, number(-z), _degrees(groove.lean)]
        if drops:
            allowed = drops[groove.ridge - 1]
            row.append("free" if math.isinf(allowed) else f"0/-{allowed:.4f}")
        rows.append(tuple(row))
    heads = (skin.family, place, "below seat", "leaning", "depth tolerance")[: 5 if drops else 4]
    return DrawingTable(f"Grooves of the {skin.family}s: deepest point; {LEANING}", heads, tuple(rows))
