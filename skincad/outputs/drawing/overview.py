"""A drawing with the main dimensions, SVG: the section, one ridge enlarged, the closed mold from above."""

from __future__ import annotations

import math
from dataclasses import dataclass
from xml.sax.saxutils import escape

import numpy as np
import shapely

from skincad.base.arrays import Array
from skincad.inputs.catalog import display_name
from skincad.inputs.design import Design
from skincad.shape.curves import Loop, polygon
from skincad.shape.skin import pictured_section, section, skin_of, summit
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

PAGE = (190.0, 150.0)  # mm, fits A4 with its margins
TEXT = 2.8  # mm
CHORD = 1e-3  # mm of the part; finer than a printed line


@dataclass(frozen=True)
class PageScale:
    """Part coordinates to the page: `origin` is where the part's (0, 0) lies, `scale` page mm a part mm."""

    origin: tuple[float, float]
    scale: float

    def at(self, x: float, z: float) -> tuple[float, float]:
        """Return the page's point, y down."""
        return self.origin[0] + self.scale * x, self.origin[1] - self.scale * z

    def path(self, outline: Loop, kind: str) -> str:
        """Return a closed outline as an SVG path."""
        return self.ring(polygon(outline, CHORD), kind)

    def ring(self, points: Array, kind: str) -> str:
        """Return a closed polygon of points `(n, 2)` mm of the part."""
        steps = " ".join(f"{x:.3f},{y:.3f}" for x, y in (self.at(a, b) for a, b in points))
        return f'<polygon class="{kind}" points="{steps}"/>'


def drawing(design: Design, closed: ClosedMold) -> str:
    """Return the drawing as an SVG document."""
    bent = design.skin.curvature_radius_y is not None
    rows = [*_section_view(design), *_ridge_view(design), *(_bent_view if bent else _mold_view)(closed)]
    which = f"{display_name(design)}, revision {design.revision}"
    title = f"{which}: all lengths in mm, silicone {design.material.name or 'own'}"
    rows.append(_text(5.0, PAGE[1] - 4.0, title, "start"))
    style = (
        "polygon,rect,circle{stroke:#222;stroke-width:.25}.skin{fill:#f3d3c4}.slot{fill:#fff}.mold{fill:#dde1e6}"
        ".hole,.bore{fill:#fff}.dim{stroke:#0072b2;stroke-width:.18;fill:none}"
        f"text{{font:{TEXT}px sans-serif;fill:#1f3f68}}"
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{PAGE[0]:g}mm" height="{PAGE[1]:g}mm" '
        f'viewBox="0 0 {PAGE[0]:g} {PAGE[1]:g}">\n<style>{style}</style>\n' + "\n".join(rows) + "\n</svg>\n"
    )


def _section_view(design: Design) -> list[str]:
    shape, skin = section(design), design.skin
    outline, placed = pictured_section(design, CHORD), skin_of(design)
    top = summit(design)
    scale = min(120.0 / skin.width, 45.0 / top)
    view = PageScale((80.0, 62.0), scale)
    half = skin.width / 2
    rows = [view.ring(outline, "skin"), *(view.path(s.loop(), "slot") for s in shape.slots)]
    left, base = view.at(-half, 0.0)
    right = view.at(half, 0.0)[0]
    rows += _across(left, right, base + 8.0, f"{skin.width:g}", base)
    middle = view.at(0.0, top)[1]
    rows += _upright(right + 8.0, base, middle, f"{top:.4g} to the crest", right)
    at_base = view.at(0.0, skin.thickness)[1]
    rows += _upright(left - 8.0, base, at_base, f"{skin.thickness:g}", left)
    pitch = f" at {placed.pitch:g} along the arc" if placed.count > 1 else ""
    radius = f"R {skin.curvature_radius:g}, {placed.counted}{pitch}"
    if placed.uneven:
        radius += f", {min(placed.heights):.4g} to {max(placed.heights):.4g} high"
    if skin.curvature_radius_y is not None:
        radius += f"; R {skin.curvature_radius_y:g} along y"
    rows.append(_text(80.0, middle - 4.0, radius))
    along = "along the ridges " if placed.symmetry == "extruded" else "along y "
    words = "turns about its middle" if skin.round else f"length {along}{skin.length:g}"
    rows.append(_text(80.0, base + 14.5, f"section, scale {scale:.3g} : 1; {words}"))
    return rows


def _ridge_view(design: Design) -> list[str]:
    """The middle feature, or the one beside the middle, upright and enlarged; none of a flat skin."""
    skin = skin_of(design)
    if skin.symmetry == "none":
        return []
    ridge, number = skin.profile, (skin.count + 1) // 2
    if skin.symmetry == "revolved":  # the pin that the section above shows nearest to its middle
        number = min(skin.placed, key=lambda p: (abs(p.y), abs(p.frame.origin.x))).number
    height = skin.heights[number - 1]
    ridge_frame = skin.placed[number - 1].frame
    shape = section(design)
    reach = 1.3 * max(ridge.root_width / 2 + ridge.root_fillet, skin.slot.offset if skin.slot else 0.0)
    scale = min(38.0 / (2 * reach), 24.0 / (1.5 * height))
    view = PageScale((48.0, 110.0), scale)

    low = -0.8 * height
    window = shapely.box(-reach, low, reach, 2 * height)

    def clip(outline: Array, kind: str) -> str:
        points = outline - np.array(ridge_frame.origin)
        local = np.column_stack(
            [points @ np.array(ridge_frame.tangent), points @ np.array(ridge_frame.normal)]
        )
        part = shapely.Polygon(local).intersection(window)
        return view.ring(shapely.get_coordinates(part), kind)

    rows = [clip(pictured_section(design, CHORD / 10), "skin")]
    rows += [clip(polygon(s.loop(), CHORD / 10), "slot") for s in shape.slots if s.feature == number]
    crest, foot = view.at(0.0, height)[1], view.at(0.0, 0.0)[1]
    left, right = view.at(-ridge.root_width / 2, 0.0)[0], view.at(ridge.root_width / 2, 0.0)[0]
    rows += _across(left, right, view.at(0.0, low)[1] + 5.0, f"root {ridge.root_width:g}", foot)
    tip = [view.at(s * ridge.tip_width / 2, height)[0] for s in (-1, 1)]
    rows += _across(tip[0], tip[1], crest - 4.0, f"tip {ridge.tip_width:g}, crown {ridge.crown:g}", crest)
    rows += _upright(view.at(reach, 0.0)[0] + 5.0, foot, crest, f"{height:g}", right)
    fillets = f"fillets {ridge.tip_fillet:g} tip, {ridge.root_fillet:g} root"
    words = f"{skin.family} {number}, scale {scale:.3g} : 1; {fillets}"
    rows.append(_text(48.0, 134.5, words))
    if skin.slot:
        slot = skin.slot
        words = (
            f"slots {slot.thickness:g} x {slot.depth:g}, {slot.offset:g} from the axis, tilt {slot.tilt:g}"
        )
        rows.append(_text(48.0, 139.0, words))
    return rows


def _mold_view(closed: ClosedMold) -> list[str]:
    """The closed mold's outer size, from above."""
    boxes = [_extent(p.body) for p in closed.parts if p.made == "made" and isinstance(p.body, Prism)]
    low = [min(b[0][i] for b in boxes) for i in range(3)]
    high = [max(b[1][i] for b in boxes) for i in range(3)]
    view = _mold_scale(low, high)
    rows = []
    for roles, kind in ((CAVITIES, "mold"), ({PartRole.CARRIER}, "hole")):
        for part in closed.of(*roles):
            if isinstance(part.body, Prism):
                (x0, y0, _), (x1, y1, _) = _extent(part.body)
                x, y = view.at(x0, y1)
                wide, high_ = view.scale * (x1 - x0), view.scale * (y1 - y0)
                rect = f'x="{x:.3f}" y="{y:.3f}" width="{wide:.3f}" height="{high_:.3f}"'
                rows.append(f'<rect class="{kind}" {rect}/>')
                rows += _round(view, part)
    left, bottom = view.at(low[0], low[1])
    right, top = view.at(high[0], high[1])
    rows += [
        *(_line(left, y, right, y) for y in (bottom, top)),
        *(_line(x, bottom, x, top) for x in (left, right)),
    ]
    words = f"closed mold from above, scale {view.scale:.3g} : 1; height {high[2] - low[2]:.4g}"
    return [*rows, *_sizes(view, low, high), _text(142.0, 134.5, words)]


def _round(view: PageScale, part: Part) -> list[str]:
    """A part's bores along z, from above: the wider end of conical ones."""
    rows = []
    for bore in (bore for bore in bores(part) if bore.axis == "z"):
        x, y = view.at(*bore.start[:2])
        radius = view.scale * max(bore.radius, bore.far_radius)
        rows.append(f'<circle class="bore" cx="{x:.3f}" cy="{y:.3f}" r="{radius:.3f}"/>')
    return rows


def _mold_scale(low: list[float], high: list[float]) -> PageScale:
    """The page's lower right for what lies between two corners, mm."""
    scale = min(50.0 / (high[0] - low[0]), 36.0 / (high[1] - low[1]))
    middle = [scale * (a + b) / 2 for a, b in zip(low, high, strict=True)]
    return PageScale((142.0 - middle[0], 105.0 + middle[1]), scale)


def _sizes(view: PageScale, low: list[float], high: list[float]) -> list[str]:
    """Dimensions of the mold's length and height on the page."""
    (left, bottom), (right, top) = view.at(low[0], low[1]), view.at(high[0], high[1])
    return [
        *_across(left, right, bottom + 5.0, f"{high[0] - low[0]:.4g}", bottom),
        *_upright(right + 5.0, bottom, top, f"{high[1] - low[1]:.4g}", right),
    ]


def _bent_view(closed: ClosedMold) -> list[str]:
    """The closed bent mold from the side, y to the right: cavity, skin, carrier, end plates and cover."""
    mold = [{PartRole.BLOCK}, CAVITIES, END_PLATES, {PartRole.COVER}]
    kinds = [*((roles, "mold") for roles in mold), ({PartRole.CARRIER}, "hole"), ({PartRole.SKIN}, "skin")]
    rings = [(kind, _side(part)) for roles, kind in kinds for part in closed.of(*roles)]
    points = np.vstack([ring for _, ring in rings])
    low, high = points.min(axis=0), points.max(axis=0)
    view = _mold_scale(low.tolist(), high.tolist())
    rows = [*(view.ring(ring, kind) for kind, ring in rings), *_sizes(view, low.tolist(), high.tolist())]
    cavity = closed.first(PartRole.CAVITY).body
    lean = math.degrees(cavity.grid.half) if isinstance(cavity, Prism) and cavity.grid else 0.0
    words = f"closed mold from the side, scale {view.scale:.3g} : 1; ends lean by {lean:.3g} degrees"
    return [*rows, _text(142.0, 134.5, words)]


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


def _across(x0: float, x1: float, y: float, text: str, start: float) -> list[str]:
    """A dimension along the page's x at height y, its extension lines from `start`."""
    ends = [_line(x, start, x, y) for x in (x0, x1)]
    return [*ends, _line(x0, y, x1, y), *_ticks((x0, y), (x1, y)), _text((x0 + x1) / 2, y - 0.9, text)]


def _upright(x: float, y0: float, y1: float, text: str, start: float) -> list[str]:
    ends = [_line(start, y, x, y) for y in (y0, y1)]
    anchor = "start" if x > start else "end"
    offset = 1.2 if x > start else -1.2
    return [
        *ends,
        _line(x, y0, x, y1),
        *_ticks((x, y0), (x, y1)),
        _text(x + offset, (y0 + y1) / 2 + 1.0, text, anchor),
    ]


def _line(x0: float, y0: float, x1: float, y1: float) -> str:
    return f'<line class="dim" x1="{x0:.3f}" y1="{y0:.3f}" x2="{x1:.3f}" y2="{y1:.3f}"/>'


def _ticks(*places: tuple[float, float]) -> list[str]:
    return [_line(x - 0.8, y + 0.8, x + 0.8, y - 0.8) for x, y in places]


def _text(x: float, y: float, words: str, anchor: str = "middle") -> str:
    return f'<text x="{x:.3f}" y="{y:.3f}" text-anchor="{anchor}">{escape(words)}</text>'
