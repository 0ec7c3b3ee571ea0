"""Features on a shop drawing besides bores: datums, sizes, the carrier's seat, nuts' pockets, slits, grooves.

Places are those of the part's own views, mm.
"""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

from skincad.fabrication.drawing_views import ABOVE, FRONT, LIDS
from skincad.inputs.design import Design
from skincad.shape.curves import Loop, Point
from skincad.shape.feature import SensorPlace
from skincad.shape.skin import section, skin_of
from skincad.solids.layout import layout
from skincad.solids.plan import CAVITIES, END_PLATES, CutRole, Part, PartRole, Prism, RotatedBody, unturned
from skincad.solids.projection import Place
from skincad.solids.shrinkage import scaled_for_shrinkage

Edge = Literal["left", "right", "bottom", "top"]
_Faces = tuple[tuple[str, Edge, str], ...]
SEAT_TOLERANCE = 1e-6  # mm, how level the seat's corners lie


class Datum(NamedTuple):
    """A datum: its letter, the view and the edge of it at which the face is seen, and which face it is."""

    letter: str
    view: str
    edge: Edge
    what: str


class Length(NamedTuple):
    """A dimension in a view, along its x ("u") or its y ("v"), from one coordinate to another, mm."""

    view: str
    way: Literal["u", "v"]
    low: float
    high: float
    words: str = ""


class NutPocket(NamedTuple):
    """A nut's hexagonal pocket in the front view: where, its width across flats and its depth, mm."""

    at: Place
    flats: float
    depth: float


class Notch(NamedTuple):
    """A notch at 45 degrees across an end plate's upright edge: its leg, mm, in the front view on which side
    and between which heights, mm, and whether it is in the outer face."""

    role: CutRole
    leg: float
    side: Edge
    low: float
    high: float
    outer: bool


class Slit(NamedTuple):
    """A comb's slit for a shim or strip, in the front view: the middle of its bottom, width and depth, mm,
    and the direction from its bottom to its mouth, of length 1."""

    ridge: int
    side: str
    at: Place
    width: float
    depth: float
    out: Place

    @property
    def lean(self) -> float:
        """Degrees from upright, positive when its mouth is to the right."""
        return math.degrees(math.atan2(self.out[0], self.out[1]))


class Groove(NamedTuple):
    """A ridge's groove in a cavity, in the front view: its bottom, mm, how far it leans from upright,
    degrees, positive when its mouth is to the right, and the sizes of its ridge, mm, before fillets."""

    ridge: int
    bottom: Place
    lean: float
    height: float
    root: float
    tip: float


def downward(part: Part) -> bool:
    """Whether heights count from a part's upper face down: its lower one is bent, as a keeper's is over the
    slots, and the upper one level."""
    return part.role is PartRole.KEEPER and not isinstance(part.body, RotatedBody)


def leftward(part: Part) -> bool:
    """Whether widths count from a part's right side to the left: its left one has the ridges."""
    return part.role is PartRole.RIGHT


def datums(part: Part) -> tuple[Datum, ...]:
    """Return the three faces from which a part is measured, the one it sits on in the mold first."""
    if part.role in LIDS:
        what = "lower face, on the skin" if part.role is PartRole.CARRIER else "lower face"
        faces: _Faces = (ABOVE, "top", what), (FRONT, "left", "left side"), (FRONT, "bottom", "face at end a")
    elif part.role in END_PLATES:
        edge: Edge = "top" if downward(part) else "bottom"
        level = "upper face" if downward(part) else "lower face"
        faces = (ABOVE, "top", "inner face"), (FRONT, "left", "left side"), (FRONT, edge, level)
    else:
        side: Edge = "right" if leftward(part) else "left"
        upright = f"lower edge of the {side} side" if part.role is PartRole.BETWEEN else f"{side} side"
        faces = (
            (FRONT, "bottom", "lower face"),
            (FRONT, side, upright),
            (ABOVE, "bottom", "lower edge of the face at end a" if part.straight else "face at end a"),
        )
    return tuple(Datum(letter, *face) for letter, face in zip("ABC", faces, strict=True))


def seat_lengths(part: Part, top: float) -> tuple[Length, ...]:
    """Return the sizes of the carrier's seat in a cavity in one piece: widths of trough and skin, and how
    deep it lies below the part's `top`, mm; of the first trough of a gang."""
    straight = unturned(part.straight or part)
    if part.role is not PartRole.CAVITY or not isinstance(straight.body, Prism):
        return ()
    level = sorted({s.start.x for s in straight.body.outline if abs(s.start.z) < SEAT_TOLERANCE})
    if len(level) < 4:
        return ()
    wide = Length(FRONT, "u", level[0], level[3], "seat")
    depth = Length(FRONT, "v", 0.0, top, "seat")
    return wide, Length(FRONT, "u", level[1], level[2], "skin"), depth


def pockets(part: Part) -> tuple[NutPocket, ...]:
    """Return the nuts' pockets of an end plate."""
    mirrored = -1.0 if part.end == "b" else 1.0
    rows = []
    for cut in unturned(part).cuts:
        if isinstance(cut, Prism) and cut.role is CutRole.NUT:
            x, z = zip(*(s.start for s in cut.outline), strict=True)
            at = mirrored * (min(x) + max(x)) / 2, (min(z) + max(z)) / 2
            rows.append(NutPocket(at, max(z) - min(z), cut.high - cut.low))
    return tuple(sorted(rows, key=lambda p: (-p.at[1], p.at[0])))


def notches(part: Part) -> tuple[Notch, ...]:
    """Return the notches across an end plate's upright edges."""
    mirrored, rows = -1.0 if part.end == "b" else 1.0, []
    for cut in unturned(part).cuts:
        if isinstance(cut, Prism) and cut.role in (CutRole.PRY, CutRole.MARK):
            x, y = zip(*((s.start.x, s.start.z) for s in cut.outline), strict=True)
            side: Edge = "right" if mirrored * (min(x) + max(x)) > 0 else "left"
            rows.append(Notch(cut.role, max(y) - min(y), side, cut.low, cut.high, cut.role is CutRole.MARK))
    return tuple(rows)


def skins_at(design: Design) -> tuple[float, ...]:
    """Return the x, mm, of the middle of each skin of a gang, 0 for one alone."""
    cast = scaled_for_shrinkage(design)
    return layout(cast, section(cast))[0].centres


def slits(design: Design, part: Part) -> tuple[Slit, ...]:
    """Return a comb's slits, of the first skin of a gang, as its outline has them."""
    body = unturned(part).body
    if part.role is not PartRole.COMB or not isinstance(body, Prism):
        return ()
    mirrored = -1.0 if part.end == "b" else 1.0
    shape, shift = section(scaled_for_shrinkage(design)), skins_at(design)[0]
    return tuple(_slit(design, slot, body.outline, shift, mirrored) for slot in shape.slots)


def _slit(design: Design, slot: SensorPlace, outline: Loop, shift: float, mirrored: float) -> Slit:
    """The outline's corners that are nearest to where the slot ends are the slit's bottom, their neighbours
    its mouth."""
    gap = design.mold.slit_clearance
    along = slot.depth / 2 + (0.0 if design.mold.method == "cast-in" else gap)
    corners = [s.start for s in outline]

    def nearest(wanted: Point) -> int:
        place = wanted.x + shift, -wanted.z
        return min(range(len(corners)), key=lambda i: math.dist(corners[i], place))

    ends = [nearest(slot.at(side * (slot.thickness / 2 + gap), along)) for side in (-1, 1)]
    low, high = sorted(ends)
    if low == 0 and high == len(corners) - 1:
        low, high = high, low
    mouths = corners[low - 1], corners[(high + 1) % len(corners)]
    bottom, mouth = (((a.x + b.x) / 2, (a.z + b.z) / 2) for a, b in ((corners[low], corners[high]), mouths))
    depth = math.dist(bottom, mouth)
    out = mirrored * (mouth[0] - bottom[0]) / depth, (mouth[1] - bottom[1]) / depth
    width = math.dist(corners[low], corners[high])
    return Slit(slot.feature, slot.side, (mirrored * bottom[0], bottom[1]), width, depth, out)


def grooves_of(design: Design, part: Part) -> tuple[Groove, ...]:
    """Return the grooves of ridges in a cavity's part, of the first skin of a gang, as poured."""
    body = (part.straight or part).body
    if part.role not in CAVITIES or not isinstance(body, Prism):
        return ()
    cast, rows, shift = skin_of(scaled_for_shrinkage(design)), [], skins_at(design)[0]
    cut = {s.feature for s in body.outline if s.feature is not None}
    for placed in cast.placed:
        if placed.number in cut:
            shape, summit, lean = placed.feature, placed.summit, -math.degrees(placed.lean)
            place = (summit.x + shift, -summit.z)
            rows.append(Groove(placed.number, place, lean, shape.height, shape.root_width, shape.tip_width))
    return tuple(rows)
