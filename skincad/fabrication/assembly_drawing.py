"""What an assembly's drawing shows: the closed mold cut along y through gate, vent and riser cup, and from
above, with the rows of the parts list that it is put together of. Lengths in mm."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import shapely
from manifold3d import Manifold

from skincad.fabrication.fasteners import NUT
from skincad.fabrication.job import Job
from skincad.fabrication.meshes import manifold
from skincad.fabrication.part_drawing import DrawingTable, Titled
from skincad.fabrication.parts_list import Item, parts_list
from skincad.inputs.catalog import display_name
from skincad.solids.fasteners import HEAD
from skincad.solids.plan import CAVITIES, END_PLATES, CutRole, PartRole, bores
from skincad.solids.projection import Arc, Place, Polyline, Stroke
from skincad.solids.shots import room

CHORD = 5e-3  # mm, of arcs in the section: a tenth of a line's width at 10:1
ASIDE = 1e-3  # mm, by which the cut lies beside the middle, where meshes may have edges
LEAST_AREA = 0.05  # mm2; what is smaller is no face to be hatched or named
_HARDWARE = {PartRole.SEAL: "seal", PartRole.SHIM: "shim", PartRole.STRIP: "film strip"}
_HARDWARE |= {PartRole.CORE_PIN: "core pin", PartRole.BONE_SCREW: "bone screw", PartRole.BONE: "bone"}
# of what is bought: not the bench's consumables
BESIDE = {"screw", "stud", "nut", "washer", "threaded insert", "dowel pin", "clamp", *_HARDWARE.values()}


class CutFace(NamedTuple):
    """A face of a part in the section: its part, the number of its row in the parts list, "" for the skin,
    its outline and holes, y and z, and a point in it."""

    part: str
    item: str
    rings: tuple[tuple[Place, ...], ...]
    middle: Place


@dataclass(frozen=True, kw_only=True)
class AssemblyDrawing(Titled):
    """The closed mold: the section's faces, y to the right and z up, and those of plugs, which lie in the
    carrier's place while layers cure; the view from above, x to the right and y up, and its balloons, rows of
    the parts list and what they point to; where the section is cut, x, and whether a gate lies there."""

    faces: tuple[CutFace, ...]
    plugs: tuple[CutFace, ...]
    plan: tuple[Stroke, ...]
    hidden: tuple[Stroke, ...]
    balloons: tuple[tuple[str, Place], ...]
    cut_at: float
    gate: bool


def assembly_drawing(job: Job) -> AssemblyDrawing:
    """Return the drawing of a closed mold."""
    rows = {str(n): item for n, item in enumerate(parts_list(job), 1)}
    in_it = {n: item for n, item in rows.items() if item.made_by != "bought" or item.what in BESIDE}
    made = {item.what: n for n, item in rows.items()}
    cut_at = job.place.centres[0]
    cells = ((n, row.quantity, row.what, row.designation, row.material) for n, row in in_it.items())
    plan, hidden = _from_above(job)
    return AssemblyDrawing(
        name="assembly",
        document="assembly drawing",
        design=display_name(job.design),
        revision=job.design.revision,
        what="the mold, closed",
        tables=(DrawingTable("Parts", ("item", "quantity", "part", "size", "material"), tuple(cells)),),
        notes=(
            "Items are the rows of parts-list.csv; what is used up at the bench stands there alone.",
            f"End a{' with the gate' if job.gate else ''} is at the left of the section. End b with vent and "
            "riser cup is raised while silicone is filled in.",
            "Tighten all screws by the casting sheet's torque, crosswise; the cover last.",
        ),
        faces=tuple(_faces(job, cut_at + ASIDE, made)),
        plugs=tuple(
            face
            for plug in (stage.first(PartRole.PLUG) for stage in job.closed.earlier)
            for face in _cut(plug.name, made.get(plug.name, ""), manifold(plug, CHORD), cut_at + ASIDE)
        ),
        plan=plan,
        hidden=hidden,
        balloons=tuple(_balloons(job, in_it)),
        cut_at=cut_at,
        gate=job.gate is not None,
    )


def _faces(job: Job, x: float, made: dict[str, str]) -> Iterator[CutFace]:
    """What the plane across x cuts of each part, and of the skin layer by layer."""
    for part in job.closed.parts:
        if part.role is PartRole.SKIN and job.cast.shot:
            continue
        item = made.get(part.name) or made.get(_HARDWARE.get(part.role, ""), "")
        yield from _cut(part.name, item, manifold(part, CHORD), x)
    for name, body in _layers(job):
        yield from _cut(name, "", body, x)


def _layers(job: Job) -> Iterator[tuple[str, Manifold]]:
    """The layers of the first skin, by name, from the front; none where it is cast of one silicone."""
    rest, shots = manifold(job.poured_part, CHORD), job.cast.shot or ()
    for number in range(len(shots), 0, -1):
        behind = manifold(room(job.cast, number), CHORD).rotate((180.0, 0.0, 0.0))
        behind = behind.translate((job.place.centres[0], 0.0, 0.0))
        yield ("skin" if number == len(shots) else f"shot {number + 1}"), rest - behind
        rest ^= behind
    if shots:
        yield "shot 1", rest


def _cut(name: str, item: str, body: Manifold, x: float) -> Iterator[CutFace]:
    """What the plane across x cuts of a body."""
    plane = np.array([[0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [1.0, 0.0, 0.0, -x]])
    region = shapely.Polygon()
    for ring in body.transform(plane).slice(0.0).to_polygons():
        region = region.symmetric_difference(shapely.Polygon(ring).buffer(0.0))
    for piece in getattr(region, "geoms", [region]):
        if piece.area < LEAST_AREA:
            continue
        inside = piece.representative_point()
        outline = tuple(map(_place, piece.exterior.coords))
        holes = tuple(tuple(map(_place, hole.coords)) for hole in piece.interiors)
        yield CutFace(name, item, (outline, *holes), (inside.x, inside.y))


def _place(point: tuple[float, ...]) -> Place:
    return float(point[0]), float(point[1])


def _from_above(job: Job) -> tuple[tuple[Stroke, ...], tuple[Stroke, ...]]:
    """Outlines and bores of the cover, and what stands out under it; the bolts along y as hidden lines."""
    closed, seen = job.closed, list[Stroke]()
    cover = closed.first(PartRole.COVER)
    blocks = [closed.of(PartRole.BLOCK, *CAVITIES)[0], *closed.of(*END_PLATES), cover]
    boxes = [manifold(part, CHORD).bounding_box() for part in blocks]
    for low_x, low_y, _, high_x, high_y, _ in boxes:
        corners = (low_x, low_y), (high_x, low_y), (high_x, high_y), (low_x, high_y), (low_x, low_y)
        seen.append(Polyline(corners))
    for bore in bores(cover):
        for radius in {bore.radius, bore.far_radius}:
            seen.append(Arc(bore.start[:2], radius, 0.0, 2 * np.pi))
    for bore in bores(cover, CutRole.COVER_BOLT):
        seen.append(Arc(bore.start[:2], HEAD / 2, 0.0, 2 * np.pi))
    low, high = min(box[1] for box in boxes), max(box[4] for box in boxes)
    lanes = [Polyline(((x, low - NUT), (x, high + NUT))) for x in job.place.lanes]
    return tuple({stroke.key(): stroke for stroke in seen}.values()), tuple(lanes)


def _balloons(job: Job, rows: dict[str, Item]) -> Iterator[tuple[str, Place]]:
    """What holds the mold together: a screw of the cover, one of the end plates, a pin, nuts."""
    closed = job.closed
    cover, place = closed.first(PartRole.COVER), job.place
    bolts, pins = bores(cover, CutRole.COVER_BOLT), bores(cover, CutRole.COVER_PIN)
    end = place.end + job.design.mold.end_plate
    for number_, item in rows.items():
        if item.what in ("screw", "stud") and item.place == "cover" and bolts:
            yield number_, _top(bolts[0].start)
        elif item.what in ("screw", "stud") and item.place == "end plates":
            yield number_, (place.lanes[-1], -end - NUT / 2)
        elif item.what == "nut" and item.place == "end plates":
            yield number_, (place.lanes[0], end)
        elif item.what == "threaded insert" and bolts and "mount" not in item.place:
            yield number_, _top(bolts[-1].start)
    for number_, item in rows.items():
        if item.what == "dowel pin" and pins:
            yield number_, _top(pins[0].start)
            return


def _top(start: tuple[float, float, float]) -> Place:
    return start[0], start[1]
