"""A drawing with the main dimensions, SVG: the section, one ridge enlarged, the closed mold from above."""

from __future__ import annotations

import math

import numpy as np
import shapely

from skincad.base.arrays import Array
from skincad.inputs.catalog import display_name
from skincad.inputs.design import Design
from skincad.outputs.drawing.formats import sheet_svg
from skincad.outputs.drawing.marks import Ink, Mark, Sheet, Words, linear, rectangle
from skincad.outputs.drawing.part_views import ViewPlacement
from skincad.shape.curves import polygon
from skincad.shape.skin import pictured_section, section, skin_of, summit
from skincad.solids.kind import kind_of
from skincad.solids.mold import ClosedMold
from skincad.solids.plan import (
    CAVITIES,
    END_PLATES,
    Part,
    PartRole,
    Prism,
    RevolvedBody,
    RotatedBody,
    bores,
    corners,
)
from skincad.solids.projection import Arc, Place, Polyline

PAGE = (190.0, 150.0)  # mm, fits A4 with its margins
TEXT = 2.0  # mm, height of capitals
CHORD = 1e-3  # mm of the part; finer than a printed line


def drawing(design: Design, closed: ClosedMold) -> str:
    """Return the drawing as an SVG document."""
    return sheet_svg(overview(design, closed))


def overview(design: Design, closed: ClosedMold) -> Sheet:
    """Return the drawing's sheet."""
    which = f"{display_name(design)}, revision {design.revision}"
    title = f"{which}: all lengths in mm, silicone {design.material.name or 'own'}"
    mold_view = _bent_view if kind_of(design).leans else _mold_view
    marks = [*_section_view(design), *_ridge_view(design), *mold_view(closed)]
    words = Words(title, (5.0, 4.0), TEXT, "TEXT")
    return Sheet(f"{design.name}: drawing", PAGE, 1.0, (*marks, words))


def _section_view(design: Design) -> list[Mark]:
    shape, skin = section(design), design.skin
    placed, top = skin_of(design), summit(design)
    view = ViewPlacement((80.0, 88.0), min(120.0 / skin.width, 45.0 / top))
    (left, base), (right, crest) = view.at((-skin.width / 2, 0.0)), view.at((skin.width / 2, top))
    pitch = f" at {placed.pitch:g} along the arc" if placed.count > 1 else ""
    radius = f"R {skin.curvature_radius:g}, {placed.counted}{pitch}"
    if placed.uneven:
        radius += f", {min(placed.heights):.4g} to {max(placed.heights):.4g} high"
    kind, words = kind_of(design), f"length along {placed.form.way} {skin.length:g}"
    if kind.leans:
        radius += f"; R {skin.radius_y:g} along y"
    if not kind.ends:
        words = "turns about its middle"
    return [
        _ring(view, pictured_section(design, CHORD), "SKIN"),
        *(_ring(view, polygon(slot.loop(), CHORD), "SLOTS") for slot in shape.slots),
        _across(view, (left, right), base, -8.0, f"{skin.width:g}"),
        _upright(view, right, (base, crest), 8.0, f"{top:.4g} to the crest"),
        _upright(view, left, (base, view.at((0.0, skin.thickness))[1]), -8.0, f"{skin.thickness:g}"),
        _caption(80.0, crest + 4.0, radius),
        _caption(80.0, base - 14.5, f"section, scale {view.scale:.3g} : 1; {words}"),
    ]


def _ridge_view(design: Design) -> list[Mark]:
    """The middle feature, or the one beside the middle, upright and enlarged; none of a flat skin."""
    skin = skin_of(design)
    if skin.bare:
        return []
    ridge, number = skin.profile, (skin.count + 1) // 2
    if skin.standing:  # the pin that the section above shows nearest to its middle
        number = min(skin.standing, key=lambda p: (abs(p.y), abs(p.frame.origin.x))).number
    height = skin.heights[number - 1]
    ridge_frame = skin.placed[number - 1].frame
    reach = 1.3 * max(ridge.root_width / 2 + ridge.root_fillet, skin.slot.offset if skin.slot else 0.0)
    view = ViewPlacement((48.0, 40.0), min(38.0 / (2 * reach), 24.0 / (1.5 * height)))
    low = -0.8 * height
    window = shapely.box(-reach, low, reach, 2 * height)

    def clip(outline: Array, layer: str) -> Ink:
        points = outline - np.array(ridge_frame.origin)
        local = np.column_stack(
            [points @ np.array(ridge_frame.tangent), points @ np.array(ridge_frame.normal)]
        )
        part = shapely.Polygon(local).intersection(window)
        return _ring(view, shapely.get_coordinates(part), layer)

    slots = [s for s in section(design).slots if s.feature == number]
    (root, foot), (tip, crest) = view.at((ridge.root_width / 2, 0.0)), view.at((ridge.tip_width / 2, height))
    fillets = f"fillets {ridge.tip_fillet:g} tip, {ridge.root_fillet:g} root"
    words = f"{skin.family} {number}, scale {view.scale:.3g} : 1; {fillets}"
    marks = [
        clip(pictured_section(design, CHORD / 10), "SKIN"),
        *(clip(polygon(slot.loop(), CHORD / 10), "SLOTS") for slot in slots),
        _across(view, (96.0 - root, root), foot, view.scale * low - 5.0, f"root {ridge.root_width:g}"),
        _across(view, (96.0 - tip, tip), crest, 4.0, f"tip {ridge.tip_width:g}, crown {ridge.crown:g}"),
        _upright(view, root, (foot, crest), 48.0 + view.scale * reach + 5.0 - root, f"{height:g}"),
        _caption(48.0, 15.5, words),
    ]
    if skin.slot:
        slot = skin.slot
        words = f"slots {slot.thickness:g} x {slot.depth:g}, {slot.offset:g} from the axis, tilt"
        marks.append(_caption(48.0, 11.0, f"{words} {slot.tilt:g}"))
    return marks


def _mold_view(closed: ClosedMold) -> list[Mark]:
    """The closed mold's outer size, from above."""
    boxes = [_extent(p.body) for p in closed.parts if p.made == "made" and isinstance(p.body, Prism)]
    low = [min(b[0][i] for b in boxes) for i in range(3)]
    high = [max(b[1][i] for b in boxes) for i in range(3)]
    view = _mold_place(low, high)
    marks: list[Mark] = []
    for roles, layer in ((CAVITIES, "MOLD"), ({PartRole.CARRIER}, "OPENING")):
        for part in closed.of(*roles):
            if isinstance(part.body, Prism):
                (x0, y0, _), (x1, y1, _) = _extent(part.body)
                marks.append(rectangle((*view.at((x0, y0)), *view.at((x1, y1))), layer))
                for bore in (bore for bore in bores(part) if bore.axis == "z"):  # conical: the wider end
                    radius = view.scale * max(bore.radius, bore.far_radius)
                    marks.append(Ink(Arc(view.at(bore.start[:2]), radius, 0.0, 2 * math.pi), "OPENING"))
    words = f"closed mold from above, scale {view.scale:.3g} : 1; height {high[2] - low[2]:.4g}"
    frame = rectangle((*view.at((low[0], low[1])), *view.at((high[0], high[1]))), "DIMENSIONS")
    return [*marks, frame, *_sizes(view, low, high), _caption(142.0, 15.5, words)]


def _mold_place(low: list[float], high: list[float]) -> ViewPlacement:
    """The page's lower right for what lies between two corners, mm."""
    scale = min(50.0 / (high[0] - low[0]), 36.0 / (high[1] - low[1]))
    middle = [scale * (a + b) / 2 for a, b in zip(low, high, strict=True)]
    return ViewPlacement((142.0 - middle[0], 45.0 - middle[1]), scale)


def _sizes(view: ViewPlacement, low: list[float], high: list[float]) -> list[Mark]:
    """Dimensions of the mold's length and height on the page."""
    (left, bottom), (right, top) = view.at((low[0], low[1])), view.at((high[0], high[1]))
    return [
        _across(view, (left, right), bottom, -5.0, f"{high[0] - low[0]:.4g}"),
        _upright(view, right, (bottom, top), 5.0, f"{high[1] - low[1]:.4g}"),
    ]


def _bent_view(closed: ClosedMold) -> list[Mark]:
    """The closed bent mold from the side, y to the right: cavity, skin, carrier, end plates and cover."""
    layers = [(roles, "MOLD") for roles in ({PartRole.BLOCK}, CAVITIES, END_PLATES, {PartRole.COVER})]
    layers += [({PartRole.CARRIER}, "OPENING"), ({PartRole.SKIN}, "SKIN")]
    rings = [(layer, _side(part)) for roles, layer in layers for part in closed.of(*roles)]
    points = np.vstack([ring for _, ring in rings])
    low, high = points.min(axis=0).tolist(), points.max(axis=0).tolist()
    view = _mold_place(low, high)
    cavity = closed.first(PartRole.CAVITY).body
    lean = math.degrees(cavity.grid.half) if isinstance(cavity, Prism) and cavity.grid else 0.0
    words = f"closed mold from the side, scale {view.scale:.3g} : 1; ends lean by {lean:.3g} degrees"
    drawn = [_ring(view, ring, layer) for layer, ring in rings]
    return [*drawn, *_sizes(view, low, high), _caption(142.0, 15.5, words)]


def _side(part: Part) -> Array:
    """A part's outline in (y, z), `(n, 2)` mm: of a body that turns, its section's height turned."""
    body = part.body
    if isinstance(body, Prism) and body.axis == "x":
        return corners(body, body.outline, CHORD)
    if isinstance(body, RevolvedBody) and body.grid:
        z = polygon(body.outline, CHORD)[:, 1]
        angles = body.grid.angles(body.low, body.high, CHORD)
        arcs = [[body.placed(np.array([[0.0, end]]), a)[0, 1:] for a in angles] for end in (z.min(), z.max())]
        return np.array([*arcs[0], *arcs[1][::-1]])
    prism = body.body if isinstance(body, RotatedBody) else body
    if not isinstance(prism, Prism):
        raise ValueError(f"{part.name}: no pin is drawn from the side")
    (_, y0, z0), (_, y1, z1) = _extent(prism)
    ring = np.array([[0.0, y, z] for y, z in ((y0, z0), (y1, z0), (y1, z1), (y0, z1))])
    if isinstance(body, RotatedBody):
        ring = body.placed(ring)
    return ring[:, 1:]


def _extent(body: Prism) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    points = polygon(body.outline, CHORD)
    (a0, b0), (a1, b1) = points.min(axis=0), points.max(axis=0)
    if body.axis == "y":
        return (a0, body.low, b0), (a1, body.high, b1)
    return (a0, b0, body.low), (a1, b1, body.high)


def _ring(view: ViewPlacement, points: Array, layer: str) -> Ink:
    """A closed polygon of points `(n, 2)` mm of the part."""
    places = [view.at((x, z)) for x, z in points.tolist()]
    return Ink(Polyline((*places, *places[:1])), layer)


def _across(view: ViewPlacement, ends: Place, start: float, out: float, words: str) -> Mark:
    """A dimension between two x of the page, its extension lines from the height `start` on."""
    return linear(((ends[0], start), (ends[1], start)), start + out, True, view.scale, words)


def _upright(view: ViewPlacement, start: float, ends: Place, out: float, words: str) -> Mark:
    return linear(((start, ends[0]), (start, ends[1])), start + out, False, view.scale, words)


def _caption(x: float, y: float, words: str) -> Words:
    return Words(words, (x, y), TEXT, "TEXT", "middle")
