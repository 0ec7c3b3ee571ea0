"""What a part's drawing shows: views, bores, slits, grooves and pockets.

From where a made part is drawn: three views in first-angle arrangement (ISO 5456-2), in its own frame. Below
the front view is what is seen from above, to its right what is seen from the left. The front view is the one
that shows most: an end plate's outer face, a lid's plan, what one sees of a cavity at end a.

The bores of a made part as a shop asks for them: where, how wide, how deep, which thread, for what. Bores
that are alike have one letter, and each its own number: D1, D2. Two on one line, in from both ends, are one
hole with two sides.

Places are those of the part's own views, mm.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import groupby
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

from skincad.fabrication.fasteners import full_thread, limits, purpose, thread, thread_words
from skincad.fabrication.job import Job
from skincad.inputs.design import Design
from skincad.shape.curves import Loop, Point
from skincad.shape.feature import SensorPlace
from skincad.solids.plan import (
    CAVITIES,
    END_PLATES,
    Body,
    Bore,
    CutRole,
    ExtendedCut,
    Part,
    PartRole,
    Prism,
    RotatedBody,
    TurnedBody,
    Vector,
    unturned,
)
from skincad.solids.projection import Place, View

if TYPE_CHECKING:
    import cadquery as cq

FRONT, ABOVE, LEFT = "front", "above", "left"
LIDS = {PartRole.CARRIER, PartRole.COVER}
LETTERS = "DEFGHJKLMPQRSTUVXYZ"  # A to C are datums, N nuts, W a detail; I and O look like digits
PROBE_DISTANCE = 0.01  # mm beyond a bore's end, where there is material or none
ORDER = tuple(CutRole)
_SIDES = {"y": ("end a", "end b"), "z": ("below", "above")}
Edge = Literal["left", "right", "bottom", "top"]
_Faces = tuple[tuple[str, Edge, str], ...]
SEAT_TOLERANCE = 1e-6  # mm, how level the seat's corners lie


class PartView(NamedTuple):
    """A view of a part: its place on the sheet, from where it is seen in words, and the view in the part's
    own frame and in that in which its solid is."""

    name: str
    words: str
    of_part: View
    of_solid: View


def views(part: Part) -> list[PartView]:
    """Return front view, view from above and view from the left of a part."""
    if part.role in LIDS:
        front = View((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    else:
        front = View((-1.0 if part.end == "b" else 1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    right, up = front.right, front.up
    x, y, z = front.towards
    below, from_left = View(right, (-x, -y, -z)), View(front.towards, up)
    if part.role in LIDS:
        words = "top view", "from end b", "from the left"
    else:
        words = "front view", "top view", "left view"
    return [
        PartView(name, caption, view, _turned(part, view))
        for name, caption, view in zip((FRONT, ABOVE, LEFT), words, (front, below, from_left), strict=True)
    ]


def _turned(part: Part, view: View) -> View:
    """The same view of a part that stands turned in the mold."""
    if not isinstance(part.body, RotatedBody):
        return view
    turn, shift = part.body.placement()
    right, up = (tuple((turn @ np.array(way)).tolist()) for way in (view.right, view.up))
    return View(right, up, tuple(shift.tolist()))


class SideView(NamedTuple):
    """A bore seen from its side: in which view, and where its axis starts and ends there, mm."""

    view: str
    start: Place
    end: Place


@dataclass(frozen=True)
class HoleGroup:
    """Holes that are alike, seen round in one view. Lengths mm; `depth` is None where they go through.

    A conical one's `far_diameter` is at the last of its `sides`, to which it opens; elsewhere both are the
    same. `lean`, rad, is by how much its axis leans out of the view's line of sight. `holes` are by their
    tags where they are in the view.
    """

    letter: str
    view: str
    role: CutRole
    purpose: str
    diameter: float
    far_diameter: float
    depth: float | None
    thread: str  # "" where there is none
    limits: str  # of the diameter
    sides: tuple[str, ...]
    lean: float
    holes: dict[str, Place]
    side_views: tuple[SideView, ...]
    full: float | None = None  # depth of its full thread, where that is not all of it
    callout: str = ""  # the thread with its depths

    @property
    def size(self) -> str:
        """The diameter as a drawing says it, both where it is conical."""
        if self.far_diameter == self.diameter:
            return f"Ø{number(self.diameter)}"
        return f"Ø{number(self.diameter)}-{number(self.far_diameter)}"

    @property
    def reach(self) -> str:
        """The depth, or THRU."""
        return "THRU" if self.depth is None else number(self.depth)


def number(value: float) -> str:
    """Return a length, mm, as drawings have it: to the micrometre, without zeros behind."""
    return f"{round(value, 3) + 0.0:.3f}".rstrip("0").rstrip(".")


class _DrilledBore(NamedTuple):
    bore: Bore
    role: CutRole
    opens: tuple[bool, bool]  # at its start, at its end
    lean: float
    start: Vector  # in the part's own frame
    end: Vector

    @property
    def axis(self) -> Vector:
        """The way from its start to its end, of length 1."""
        x, y, z = ((b - a) / self.bore.length for a, b in zip(self.start, self.end, strict=True))
        return x, y, z

    @property
    def mouth(self) -> Vector:
        """The middle of where it opens."""
        return self.start if self.opens[0] or not self.opens[1] else self.end

    def like(self) -> tuple[float | str, ...]:
        """What bores of one letter have in common."""
        depth = -1.0 if all(self.opens) else self.bore.length
        sizes = (round(v, 6) for v in (self.bore.radius, self.bore.far_radius, depth, abs(self.lean)))
        return (ORDER.index(self.role), self.bore.axis, *sizes)


def hole_groups(job: Job, part: Part, shape: cq.Solid) -> list[HoleGroup]:
    """Return all bores of a made part, `made` its solid in the mold, in groups of a letter each."""
    drilled, seen = sorted(_drilled_bores(part, shape), key=_DrilledBore.like), views(part)
    alike = [list(group) for _, group in groupby(drilled, key=_DrilledBore.like)]
    letters = [*LETTERS, *(f"{a}{b}" for a in LETTERS for b in LETTERS)]
    return [_group(job, part, letter, group, seen) for letter, group in zip(letters, alike, strict=False)]


def _group(job: Job, part: Part, letter: str, alike: list[_DrilledBore], seen: list[PartView]) -> HoleGroup:
    first = alike[0]
    view = max(seen, key=lambda s: abs(np.dot(s.of_part.towards, first.axis)))
    places: dict[Place, None] = {}
    for one in alike:
        x, y = view.of_part.at(one.mouth)
        places[(round(x, 6) + 0.0, round(y, 6) + 0.0)] = None
    rows = sorted(places, key=lambda at: (-at[1], at[0]))
    names = _SIDES[first.bore.axis]
    depth = None if all(first.opens) else first.bore.length
    sides = [name for i, name in enumerate(names) if any(one.opens[i] for one in alike)]
    return HoleGroup(
        letter=letter,
        view=view.name,
        role=first.role,
        purpose=purpose(job, part, first.role),
        diameter=2 * first.bore.radius,
        far_diameter=2 * first.bore.far_radius,
        depth=depth,
        thread=thread(job, part, first.role),
        limits=limits(job, part, first.role),
        sides=tuple(sides),
        lean=abs(first.lean),
        holes={f"{letter}{i}": at for i, at in enumerate(rows, 1)},
        side_views=tuple(_side_views(alike, [one for one in seen if one is not view])),
        full=full_thread(job, part, first.role, depth),
        callout=thread_words(job, part, first.role, depth),
    )


def _side_views(alike: list[_DrilledBore], seen: list[PartView]) -> list[SideView]:
    """Bores from their sides, those that lie behind others once."""
    rows = [
        SideView(view.name, view.of_part.at(one.start), view.of_part.at(one.end))
        for view in seen
        for one in alike
    ]
    return list({(row.view, *np.round([*row.start, *row.end], 6).tolist()): row for row in rows}.values())


def _drilled_bores(part: Part, shape: cq.Solid) -> list[_DrilledBore]:
    """The bores of a part. Whether they open at their ends is asked of the solid once for all that differ by
    their place alone."""
    rows: list[_DrilledBore] = []
    known: dict[tuple[object, ...], tuple[bool, bool]] = {}
    for cut in part.cuts:
        bore, turned = _bore(cut)
        if bore is None or bore.role is None:
            continue
        start, end = _ends(bore, 0.0)
        level = bore.start[1 if bore.axis == "y" else 2]
        kind = (bore.role, bore.axis, level, bore.length, bore.radius, turned and turned.angle)
        if kind not in known:
            low, high = (not shape.isInside(_placed(turned, p), 1e-6) for p in _ends(bore, PROBE_DISTANCE))
            known[kind] = low, high
        opens, lean = known[kind], 0.0
        if turned is not None and not isinstance(part.body, RotatedBody):
            start, end, lean = _placed(turned, start), _placed(turned, end), turned.angle
        rows.append(_DrilledBore(bore, bore.role, opens, lean, start, end))
    return rows


def _bore(cut: Body) -> tuple[Bore | None, RotatedBody | None]:
    """A cut's bore in its own frame, and how it is turned; None if it is none."""
    counts = cut.counts if isinstance(cut, ExtendedCut) else cut
    body, turned = (counts.body, counts) if isinstance(counts, RotatedBody) else (counts, None)
    return (body, turned) if isinstance(body, Bore) else (None, None)


def _ends(bore: Bore, extra: float) -> tuple[Vector, Vector]:
    """Where a bore's axis is at both ends, or this far beyond them, mm."""
    x, y, z = bore.start
    if bore.axis == "y":
        return (x, y - extra, z), (x, y + bore.length + extra, z)
    return (x, y, z - extra), (x, y, z + bore.length + extra)


def _placed(turned: RotatedBody | None, point: Vector) -> Vector:
    if turned is None:
        return point
    x, y, z = turned.placed(np.array([point]))[0].tolist()
    return x, y, z


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
            (ABOVE, "bottom", "lower edge of the face at end a" if _slanted(part) else "face at end a"),
        )
    return tuple(Datum(letter, *face) for letter, face in zip("ABC", faces, strict=True))


def _slanted(part: Part) -> bool:
    return isinstance(part.body, Prism) and part.body.grid is not None


def seat_lengths(part: Part, top: float) -> tuple[Length, ...]:
    """Return the sizes of the carrier's seat in a cavity in one piece: widths of trough and skin, and how
    deep it lies below the part's `top`, mm; of the first trough of a gang."""
    straight = unturned(part.straight or part)
    if part.role is not PartRole.CAVITY or not isinstance(straight.body, Prism):
        return ()
    level = sorted({s.start.x for s in straight.body.outline if abs(s.start.z) < SEAT_TOLERANCE})
    if len(level) < 4:
        return ()
    turned = any(isinstance(cut, TurnedBody) and cut.role is CutRole.TROUGH for cut in part.cuts)
    across = " Ø" if turned else ""
    wide = Length(FRONT, "u", level[0], level[3], f"seat{across}")
    depth = Length(FRONT, "v", 0.0, top, "seat")
    skin = Length(FRONT, "u", level[1], level[2], f"skin{across}")
    return (wide, skin, depth) if top > 0 else (skin,)  # a disc's ledge is its top


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


def slits(job: Job, part: Part) -> tuple[Slit, ...]:
    """Return a comb's slits, of the first skin of a gang, as its outline has them."""
    body = unturned(part).body
    if part.role is not PartRole.COMB or not isinstance(body, Prism):
        return ()
    mirrored = -1.0 if part.end == "b" else 1.0
    shape, shift = job.cast_section, job.place.centres[0]
    return tuple(_slit(job.design, slot, body.outline, shift, mirrored) for slot in shape.slots)


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


def grooves_of(job: Job, part: Part) -> tuple[Groove, ...]:
    """Return the grooves of ridges in a cavity's part, of the first skin of a gang, as poured."""
    body = (part.straight or part).body
    if part.role not in CAVITIES or not isinstance(body, Prism):
        return ()
    cast, rows, shift = job.cast_skin, [], job.place.centres[0]
    cut = {s.feature for s in body.outline if s.feature is not None}
    for placed in cast.placed:
        if placed.number in cut and placed.feature.outline:
            shape, summit, lean = placed.feature, placed.summit, -math.degrees(placed.lean)
            place = (summit.x + shift, -summit.z)
            rows.append(Groove(placed.number, place, lean, shape.height, shape.root_width, shape.tip_width))
    return tuple(rows)
