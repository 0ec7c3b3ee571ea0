"""The assembly's sheet: a hatched section with balloons over the view from above, and the parts' rows."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

import shapely
from shapely import affinity

from skincad.fabrication.assembly_drawing import AssemblyDrawing, CutFace
from skincad.fabrication.drawn_features import number
from skincad.outputs.drawing.marks import Ink, Mark, Sheet, Words, line, linear, moved, rectangle
from skincad.outputs.drawing.part_sheet import (
    COLUMN,
    PAPERS,
    SCALES,
    VIEW_GAP,
    column,
    column_height,
    scale_words,
)
from skincad.outputs.drawing.part_views import ViewPlacement
from skincad.solids.projection import Arc, Place, Polyline, extent

BALLOON = 3.2  # mm, radius
OVER = 16.0  # mm of paper over a view, for its balloons; as much under it, for dimension and caption
HATCH = 2.0, 3.0  # mm of paper, between lines: narrow for what is small
SMALL = 40.0  # mm2 of paper; a smaller face has narrow hatching
BESIDE_MOLD = 6.0  # mm of the part, between the mold and its plugs
SOFT = {"seal", "skin"}  # shown without hatching: they are squeezed or poured


def assembly_sheet(drawing: AssemblyDrawing, date: str) -> Sheet:
    """Return the sheet of a closed mold on the smallest paper that takes it; `date` is "" where it is left
    out."""
    papers = [paper for paper in PAPERS if paper.beside and column_height(drawing) < paper.size[1] - 20.0]
    paper = (papers or [PAPERS[-1]])[0]
    left, low, right, high = paper.frame
    area = left + 4.0, low + 4.0, right - COLUMN - VIEW_GAP, high - 4.0
    (y_low, z_low), (y_high, z_high) = _box([*drawing.faces, *_beside(drawing)])
    plan_low, plan_high = extent([*drawing.plan, *drawing.hidden])
    wide = max(y_high - y_low, plan_high[0] - plan_low[0])
    tall = z_high - z_low + plan_high[1] - plan_low[1]
    across = [s for s in SCALES if wide * s + 4 * BALLOON <= area[2] - area[0]]
    scale = next((s for s in across if tall * s + 4 * OVER <= area[3] - area[1]), SCALES[-1])
    middle = (area[0] + area[2]) / 2
    section = ViewPlacement((middle - scale * (y_low + y_high) / 2, area[3] - OVER - scale * z_high), scale)
    base = section.at((0.0, z_low))[1] - 2 * OVER
    origin = middle - scale * (plan_low[0] + plan_high[0]) / 2, base - scale * plan_high[1]
    plan = ViewPlacement(origin, scale)
    marks: list[Mark] = [
        rectangle(paper.frame, "FRAME"),
        *column(drawing, paper, scale, date),
        *_section_marks(drawing, section),
        *_plan_marks(drawing, plan),
    ]
    return Sheet(f"{drawing.design}: {drawing.name}", paper.size, scale, tuple(marks))


def _box(faces: Iterable[CutFace]) -> tuple[Place, Place]:
    return extent([Polyline(ring) for face in faces for ring in face.rings])


def _section_marks(drawing: AssemblyDrawing, place: ViewPlacement) -> Iterator[Mark]:
    """The cut faces, hatched in turn, their balloons over them, and the overall size."""
    faces = [*drawing.faces, *_beside(drawing)]
    names = list(dict.fromkeys(face.part for face in faces))
    for face in faces:
        for ring in face.rings:
            yield Ink(place.stroke(Polyline(ring)), "OUTLINE")
        yield from _hatching(face, place, 45.0 if names.index(face.part) % 2 else -45.0)
    (left, low), (right, high) = _box(drawing.faces)
    (_, _), (far, _) = _box(faces)
    top = place.at((0.0, high))[1] + OVER - BALLOON - 2.0
    shown = {face.item: face for face in sorted(faces, key=_area) if face.item}
    pointed = sorted((place.at(face.middle)[0], item) for item, face in shown.items())
    span = place.at((left, 0.0))[0], place.at((far, 0.0))[0]
    for (x, item), at in zip(pointed, _spread(len(pointed), *span), strict=True):
        yield from _balloon(item, (at, top), (x, place.at(shown[item].middle)[1]))
    a, b = place.at((left, low)), place.at((right, high))
    yield linear((a, (b[0], a[1])), a[1] - 7.0, True, place.scale, number(right - left))
    yield linear((a, (a[0], b[1])), a[0] - 7.0, False, place.scale, number(high - low))
    cast = {face.part: face for face in sorted(drawing.faces, key=_area) if _is_cast(face)}
    for name, face in cast.items():
        yield Words(name, place.at(face.middle), 2.0, "TEXT", "middle")
    for plug in dict.fromkeys(face.part for face in drawing.plugs):
        (first, under), (last, _) = _box(face for face in faces if face.part == plug)
        foot = place.at(((first + last) / 2, under))
        yield Words(f"{plug}, before the carrier", (foot[0], foot[1] - 4.0), 2.0, "TEXT", "middle")
    through = "gate, vent and riser cup" if drawing.gate else "vent and riser cup"
    caption = f"section A-A ({scale_words(place.scale)}), through {through}"
    yield Words(caption, (sum(span) / 2, a[1] - 14.0), 2.5, "TEXT", "middle")


def _is_cast(face: CutFace) -> bool:
    """Whether a face is the skin's, or one of its layers'."""
    return face.part == "skin" or face.part.startswith("shot ")


def _beside(drawing: AssemblyDrawing) -> list[CutFace]:
    """The plugs' faces to the right of the mold's, one after the other, as high as they lie in it."""
    moved, (_, (right, _)) = list[CutFace](), _box(drawing.faces)
    for name in dict.fromkeys(face.part for face in drawing.plugs):
        faces = [face for face in drawing.plugs if face.part == name]
        (left, _), (end, _) = _box(faces)
        by = right + BESIDE_MOLD - left
        right = end + by
        for face in faces:
            rings = tuple(tuple((y + by, z) for y, z in ring) for ring in face.rings)
            moved.append(face._replace(rings=rings, middle=(face.middle[0] + by, face.middle[1])))
    return moved


def _area(face: CutFace) -> float:
    return float(shapely.Polygon(face.rings[0], face.rings[1:]).area)


def _spread(count: int, low: float, high: float) -> list[float]:
    """Even places between two ends, further out where they would touch."""
    if count < 2:
        return [(low + high) / 2] * count
    wide = max(high - low, (count - 1) * 2.5 * BALLOON)
    start = (low + high - wide) / 2
    return [start + i * wide / (count - 1) for i in range(count)]


def _hatching(face: CutFace, place: ViewPlacement, angle: float) -> Iterator[Mark]:
    if face.part in SOFT or _is_cast(face) or face.item == "":
        return
    outline, *holes = ([place.at(point) for point in ring] for ring in face.rings)
    region = shapely.Polygon(outline, holes)
    step = HATCH[0] if region.area < SMALL else HATCH[1]
    middle = region.centroid
    turned = affinity.rotate(region, -angle, origin=middle)
    left, low, right, high = turned.bounds
    count = math.ceil((high - low) / step)
    for i in range(count):
        level = low + (i + 0.5) * (high - low) / count
        pieces = turned.intersection(shapely.LineString([(left - 1, level), (right + 1, level)]))
        for piece in getattr(pieces, "geoms", [pieces]):
            if piece.geom_type == "LineString" and not piece.is_empty:
                (ax, ay), (bx, by) = affinity.rotate(piece, angle, origin=middle).coords
                yield line((ax, ay), (bx, by), "DIMENSIONS")


def _balloon(item: str, at: Place, to: Place) -> Iterator[Mark]:
    """A circle with the item's number, and a line to a dot on the part."""
    angle = math.atan2(to[1] - at[1], to[0] - at[0])
    rim = moved(at, (math.cos(angle), math.sin(angle)), BALLOON)
    yield Ink(Arc(at, BALLOON, 0.0, 2 * math.pi), "DIMENSIONS")
    yield line(rim, to, "DIMENSIONS")
    yield Ink(Arc(to, 0.4, 0.0, 2 * math.pi), "DIMENSIONS")
    yield Words(item, (at[0], at[1] - 1.0), 2.0, "TEXT", "middle")


def _plan_marks(drawing: AssemblyDrawing, place: ViewPlacement) -> Iterator[Mark]:
    """The view from above with the cut's line, balloons and the overall size."""
    yield from (Ink(place.stroke(stroke), "OUTLINE") for stroke in drawing.plan)
    yield from (Ink(place.stroke(stroke), "CENTRE") for stroke in drawing.hidden)
    (left, low), (right, high) = extent([*drawing.plan, *drawing.hidden])
    (x, under), (_, over) = (place.at((drawing.cut_at, level)) for level in (low, high))
    yield line((x, under - 3.0), (x, over + 3.0), "CENTRE")
    for y in (under - 3.0, over + 3.0):
        yield Words("A", (x + 1.0, y), 2.5, "TEXT")
    side = place.at((right, 0.0))[0] + 2.5 * BALLOON
    rows = sorted(drawing.balloons, key=lambda balloon: balloon[1][1])
    heights = _spread(len(rows), place.at((0.0, low))[1], place.at((0.0, high))[1])
    for (item, at), height in zip(rows, heights, strict=True):
        yield from _balloon(item, (side, height), place.at(at))
    (a_low, b_low), (a_high, b_high) = extent(drawing.plan)
    a, b = place.at((a_low, b_low)), place.at((a_high, b_high))
    under = place.at((0.0, low))[1] - 8.0
    yield linear((a, (b[0], a[1])), under, True, place.scale, number(a_high - a_low))
    yield linear((a, (a[0], b[1])), a[0] - 7.0, False, place.scale, number(b_high - b_low))
    at = place.at(((left + right) / 2, 0.0))[0], place.at((0.0, low))[1] - 14.0
    yield Words("top view, closed", at, 2.5, "TEXT", "middle")
