"""The skin: a base with placed features, and its exact cross-section.

In the section's plane (x, z), mm: flat back at z = 0, features up, the material on the left of every segment.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Literal, NamedTuple

import numpy as np
import shapely

from skincad.base.arrays import Array
from skincad.base.errors import InputError
from skincad.inputs.design import Design
from skincad.inputs.feature_tables import Pin, Pocket
from skincad.inputs.guards import LEAST_POCKET_WALL, shoulder
from skincad.inputs.skin_tables import Base, Slot
from skincad.shape.curves import Loop, Point, Segment, area, loop, moments, polygon
from skincad.shape.families import place
from skincad.shape.feature import Feature, Form, Frame, Placed, SensorPlace

# A section that runs along y, or along an arc there; one that turns about z; pins, which no section shows all
Body = Literal["straight", "bent", "turned", "pins"]
MOLDABLE_WALL = 0.04  # mm, assumption: a thinner silicone membrane tears when the shim is drawn
GUARD_TOLERANCE = 1e-5  # mm, chord tolerance of the polygons that the guards judge
POCKET_POINTS = 48  # round a pocket, and along it, at which its wall in a pin is measured
VISIBLE = 10 * GUARD_TOLERANCE  # mm; less is the chords' own error


@dataclass(frozen=True)
class Section:
    """The skin's section: outline counterclockwise, and the slots in it."""

    outline: Loop
    slots: tuple[SensorPlace, ...] = ()

    @cached_property
    def area(self) -> float:
        """Area of the material, mm2: outline less slots."""
        return area(self.outline) - math.fsum(area(s.loop()) for s in self.slots)

    @cached_property
    def centroid(self) -> Point:
        """Centroid of the material, mm."""
        rows = np.array([moments(self.outline), *([-m for m in moments(s.loop())] for s in self.slots)])
        total = rows.sum(axis=0)
        return Point(float(total[1] / total[0]), float(total[2] / total[0]))

    @cached_property
    def top(self) -> float:
        """Largest z of the outline, mm, exact."""
        return max(segment.top for segment in self.outline)


class Narrowest(NamedTuple):
    """A groove or a tooth of what casts the skin: where, its width and its depth or height, mm."""

    where: str
    width: float
    height: float


class Undercut(NamedTuple):
    """A feature's overhang: mm by which a flank widens towards the tip, and the nominal squeeze to pass it,
    1 where nothing passes."""

    width: float
    strain: float


@dataclass(frozen=True, eq=False)
class Skin:
    """A base with features placed on it, number 1 at the smallest x.

    `pitch` mm is from one feature to the next along the base circle; of a lone one a length of its size.
    """

    name: str
    base: Base
    placed: tuple[Placed, ...]
    pitch: float

    @property
    def family(self) -> str:
        """The family of its features, and the name of one."""
        return self.profile.family

    @property
    def form(self) -> Form:
        """What its features have in common with all of their family."""
        return self.profile.form

    @property
    def standing(self) -> tuple[Placed, ...]:
        """The features that stand on its section, which shows none of them: pins."""
        return () if self.form.sides else self.placed

    @property
    def body(self) -> Body:
        """How its section makes it."""
        if self.base.round and len(self.standing) < 2:
            return "turned"
        return "pins" if self.standing else "straight" if math.isinf(self.base.radius_y) else "bent"

    @property
    def bare(self) -> bool:
        """Whether it has no features: its face is what touches."""
        return not self.profile.outline

    @property
    def count(self) -> int:
        """How many features there are."""
        return len(self.placed)

    @property
    def profile(self) -> Feature:
        """The first feature. All share its widths, fillets and slots, and may differ in height."""
        return self.placed[0].feature

    @property
    def slot(self) -> Slot | None:
        """The table of the slots in every feature, None without."""
        return self.profile.slot

    @cached_property
    def heights(self) -> tuple[float, ...]:
        """Each feature's height, base circle to summit, mm."""
        return tuple(placed.feature.height for placed in self.placed)

    @property
    def uneven(self) -> bool:
        """Whether features differ in height."""
        return len({*self.heights}) > 1

    @property
    def leans(self) -> tuple[float, ...]:
        """The angle from z to each feature's axis, rad, towards +x."""
        return tuple(placed.lean for placed in self.placed)

    def lean(self, number: int) -> float:
        """Return the angle from z to a feature's axis, rad, towards +x."""
        return self.placed[number - 1].lean

    @cached_property
    def crests(self) -> tuple[float, ...]:
        """Each summit's height over the flat back, mm."""
        return tuple(placed.summit.z for placed in self.placed)

    @cached_property
    def height(self) -> float:
        """How high skin and features are, mm: the thickness and the height of the one with the highest
        crest."""
        return self.base.thickness + self.heights[self.crests.index(max(self.crests))]

    @property
    def counted(self) -> str:
        """How many features there are, as words: "1 ridge", "9 pins", or "no features"."""
        if self.bare:
            return "no features"
        return f"{self.count} {self.family}{'s' * (self.count > 1)}"

    def named(self, number: int) -> str:
        """Return what a finding calls a feature: a pin by its place too, x and y from the skin's middle."""
        return f"{self.family} {number}{self.form.place.format(*self.placed[number - 1].tip)}"

    @property
    def turned_down(self) -> str:
        """What of it is down while it is poured."""
        return "its face" if self.bare else f"the {self.family}s"

    def levelled(self, arc: Segment) -> Segment:
        """Return an arc of its base, or of a layer's face, or its chord where both are one and pins stand on
        it: on a plane."""
        plane = self.standing and abs(arc.bulge) * arc.chord / 2 < GUARD_TOLERANCE
        return replace(arc, bulge=0.0) if plane else arc

    def groove(self) -> Narrowest:
        """Return the narrowest groove of what casts the skin: the tip of the highest feature."""
        deepest = max(self.heights)
        which = f"{self.family} {self.heights.index(deepest) + 1}" if self.uneven else f"a {self.family}"
        return Narrowest(f"groove of {which}'s tip", self.profile.tip_width, deepest)

    def tooth(self) -> Narrowest | None:
        """Return the narrowest tooth of what casts the skin, between two neighbours' roots; None of features
        without neighbours.

        The width is that of its free end, before fillets, and the height that over the shallower groove:
        below its bottom the tooth is backed.
        """
        pairs = [(p.number, n) for p in self.placed for n in p.neighbours if n > p.number]
        if not pairs:
            return None
        free = [min(self.heights[a - 1], self.heights[b - 1]) for a, b in pairs]
        first, second = pairs[free.index(max(free))]
        name = self.family
        which = f"the roots of {name}s {first} and {second}" if self.uneven else f"two {name}s' roots"
        return Narrowest(f"tooth between {which}", self.pitch - self.profile.root_width, max(free))

    @cached_property
    def undercuts(self) -> dict[int, Undercut]:
        """Each feature's undercut when the skin leaves its mold straight along its own -z, by number.

        The fan leans alike to both sides and leaves as one, so no feature can give way sideways: every level
        of it has to pass the narrowest opening that the groove leaves on its way, w out of its width W. It is
        squeezed by the nominal strain 1 - w / W. Exact to the guards' chord tolerance; 0 is below it.
        """
        return {p.number: _undercut(tuple(upright(p).outline)) for p in self.placed if p.feature.outline}


@lru_cache(maxsize=32)
def skin_of(design: Design) -> Skin:
    """Return the design's skin. Raises InputError where features have no shape, or no room."""
    return Skin(design.name, design.skin, place(design), design.spacing)


@lru_cache(maxsize=32)
def section(design: Design) -> Section:
    """Return the design's section, guarded: what is swept along y or turned. Pins are not in it.

    Raises InputError when fillets do not fit, when the outline is not simple, or when a slot leaves it
    or leaves too thin a wall. Valid for curvature radii up to 1e8 mm.
    """
    skin = skin_of(design)
    slots = tuple(place for placed in skin.placed for place in placed.sensors)
    result = Section(tuple(_outline(skin)), slots)
    _guard(result, skin)
    if isinstance(design.features, Pin) and design.features.pocket:
        _guard_pockets(skin, design.features, design.features.pocket)
    return result


@lru_cache(maxsize=32)
def summit(design: Design) -> float:
    """Return how high the skin is over its back, mm, exact; pins are not in its section."""
    tops = (s.top for placed in skin_of(design).placed for s in upright(placed).outline)
    return max([section(design).top, *tops])


def cell_section(
    design: Design, radius: float, number: int = 1, curvature_radius: float = math.inf
) -> Section:
    """Return the section through the axis of one pin, feature 1, upright in the middle of a disc of base of a
    `radius` mm, which falls away from the pin's foot as on a sphere of a `curvature_radius` mm.

    Raises InputError for a pin whose foot covers the disc.
    """
    up = Frame(Point(0.0, design.skin.thickness), Point(1.0, 0.0), Point(0.0, 1.0))
    pin = replace(skin_of(design).placed[number - 1], frame=up, number=1, lean=0.0, y=0.0, axis_y=0.0)
    foot, thickness = pin.feature.feet[0].x, design.skin.thickness
    if not foot < radius:
        rule = f"must leave base round a pin's foot, {foot:.4g} mm in radius"
        raise InputError("skin.width", rule, 2 * radius, "enlarge it, or take a thinner pin")
    side = math.asin(radius / curvature_radius)
    rim = thickness - (2 * curvature_radius * math.sin(side / 2) ** 2 if side else 0.0)
    bulge = math.tan((side - math.asin(foot / curvature_radius)) / 4)
    outline = (
        Segment(Point(-radius, 0.0), Point(radius, 0.0), kind="back"),
        Segment(Point(radius, 0.0), Point(radius, rim), kind="side"),
        Segment(Point(radius, rim), Point(foot, thickness), bulge, "base"),
        *pin.outline,
        Segment(Point(-foot, thickness), Point(-radius, rim), bulge, "base"),
        Segment(Point(-radius, rim), Point(-radius, 0.0), kind="side"),
    )
    return Section(outline)


def pictured_section(design: Design, tolerance: float) -> Array:
    """Return what a picture shows as the section, `(n, 2)` mm of x and z, arcs within `tolerance` mm: the
    outline, with the pins of the row next to the middle and their pockets."""
    skin, outline = skin_of(design), polygon(section(design).outline, tolerance)
    least = min((abs(p.y) for p in skin.standing), default=0.0)
    row = [p for p in skin.standing if abs(p.y) <= least + VISIBLE]
    if not row:
        return outline
    body = shapely.Polygon(outline)
    for placed in row:
        (right, left), at = placed.feature.feet, placed.frame.at
        buried = [at(left.x, -0.1 * skin.base.thickness), at(right.x, -0.1 * skin.base.thickness)]
        pin = [*polygon(tuple(placed.outline), tolerance), at(*left), *buried]
        body = body.union(shapely.Polygon(pin))
    if pocket := design.of(Pin).pocket:
        half = pocket.diameter / 2
        for x in (placed.tip[0] + pocket.offset for placed in row):
            body = body.difference(shapely.box(x - half, -1.0, x + half, pocket.depth))
    points: Array = shapely.get_coordinates(shapely.orient_polygons(body).exterior)[:-1]
    return points


DRAWN = 1e-4  # mm, of pins' arcs in a drawing as chords


def drawn_section(design: Design) -> Section:
    """Return the section as drawings have it: that of the plane y = 0, or of the row of pins next to it."""
    if not skin_of(design).standing:
        return section(design)
    return Section(loop([Point(x, z) for x, z in pictured_section(design, DRAWN).tolist()], "side"))


def _outline(skin: Skin) -> Iterator[Segment]:
    """Outline from the back's left corner, counterclockwise; segments without length are left out."""
    base = skin.base
    radius, x = base.curvature_radius, base.width / 2
    side, rim = math.asin(x / radius), shoulder(base)
    yield Segment(Point(-x, 0.0), Point(x, 0.0), kind="back")
    yield Segment(Point(x, 0.0), Point(x, rim), kind="side")
    here, angle = Point(x, rim), side
    for placed in _crossings(skin):
        right, left = placed.feature.feet
        reach = math.atan2(right.x, radius + right.z)
        yield from _base_arc(skin, here, placed.frame.at(*right), angle - placed.lean - reach)
        yield from placed.outline
        here, angle = placed.frame.at(*left), placed.lean - reach
    yield from _base_arc(skin, here, Point(-x, rim), angle + side)
    yield Segment(Point(-x, rim), Point(-x, 0.0), kind="side")


def _crossings(skin: Skin) -> Iterator[Placed]:
    """The features that cross the section, from the largest x: rings on either side of the middle."""
    placed = [] if skin.bare else skin.placed
    for side in reversed(skin.form.sides):
        yield from reversed(placed) if side > 0 else map(_mirrored, placed)


def _mirrored(placed: Placed) -> Placed:
    """A ring where the section's half at -x crosses it."""
    origin, along, out = placed.frame.origin, placed.frame.tangent, placed.frame.normal
    frame = Frame(Point(-origin.x, origin.z), Point(along.x, -along.z), Point(-out.x, out.z))
    return replace(placed, frame=frame, lean=-placed.lean)


def upright(placed: Placed) -> Placed:
    """Return a feature in the plane of its axis and z, where all but pins stand."""
    sine, cosine = math.sin(placed.lean), math.cos(placed.lean)
    return replace(placed, frame=Frame(placed.frame.origin, Point(cosine, -sine), Point(sine, cosine)))


def _base_arc(skin: Skin, start: Point, end: Point, sweep: float) -> Iterator[Segment]:
    face = skin.bare
    segment = skin.levelled(Segment(start, end, math.tan(sweep / 4), "base", 1 if face else None, face))
    if segment.chord > 0.0:
        yield segment


def _guard(result: Section, skin: Skin) -> None:
    """Judge the whole section on its polygons: simple, slots inside, walls and webs thick enough."""
    body = shapely.Polygon(polygon(result.outline, GUARD_TOLERANCE))
    if not body.is_valid:
        rule = f"the outline crosses itself ({shapely.is_valid_reason(body)})"
        raise InputError(skin.family, rule, remedy=f"move {skin.family}s apart")
    if not result.slots or skin.slot is None:
        return
    slots = [shapely.Polygon(polygon(s.loop(), GUARD_TOLERANCE)) for s in result.slots]
    outside = [s for s, shape in zip(result.slots, slots, strict=True) if not body.contains(shape)]
    if outside:
        rule = f"must lie inside the outline; {outside[0].side} of ridge {outside[0].feature} crosses it"
        place = f"offset {skin.slot.offset:g}, elevation {skin.slot.elevation:g} mm"
        raise InputError("slot", rule, place, "reduce offset, depth or elevation")
    walls = [float(body.exterior.distance(shape)) for shape in slots]
    wall = min(walls)
    thinnest = result.slots[walls.index(wall)]
    where = f" at {thinnest.side} of ridge {thinnest.feature}" if skin.uneven else ""
    tree = shapely.STRtree(slots)
    pairs = tree.query(slots, predicate="dwithin", distance=MOLDABLE_WALL)
    close = pairs[:, pairs[0] < pairs[1]].T
    web = min((float(slots[i].distance(slots[j])) for i, j in close), default=math.inf)
    for place_name, size in ((f"wall to the outline{where}", wall), ("web between slots", web)):
        if size < MOLDABLE_WALL:
            rule = f"leaves a {place_name} of {max(size, 0.0):.4g} mm; silicone needs {MOLDABLE_WALL:g} mm"
            raise InputError("slot.offset", rule, skin.slot.offset, "move, turn or shorten the slots")


def _guard_pockets(skin: Skin, pin: Pin, pocket: Pocket) -> None:
    """Raise InputError where an upright pocket comes too near to the flank of a pin that leans."""
    turn = np.linspace(0.0, 2 * math.pi, POCKET_POINTS, endpoint=False)
    across, along_y = (pocket.diameter / 2 * part for part in (np.cos(turn), np.sin(turn)))
    height = np.linspace(0.0, pocket.depth, POCKET_POINTS)[:, None]
    walls = dict[int, float]()
    for placed in skin.placed:
        (x, y, _), axis = placed.tip, np.array(placed.axis)
        rim = np.broadcast_arrays(x + pocket.offset + across, y + along_y, height)
        out = np.stack(rim, axis=-1) - np.array(placed.foot)
        along = out @ axis
        beside = np.linalg.norm(out - along[..., None] * axis, axis=-1)
        radius = _radius_at(pin, placed.feature.height, along)
        walls[placed.number] = float(np.where(along > 0, radius - beside, math.inf).min())
    number = min(walls, key=lambda number: walls[number])
    if walls[number] < LEAST_POCKET_WALL - GUARD_TOLERANCE:
        lean = math.degrees(math.acos(min(1.0, skin.placed[number - 1].axis[2])))
        wall = max(walls[number], 0.0)
        rule = f"leaves {wall:.2g} mm of silicone in pin {number}, which leans by {lean:.2g} degrees"
        rule += f"; {LEAST_POCKET_WALL:g} mm are needed"
        remedy = "make it narrower, end it below the pin, or curve the skin less"
        raise InputError("pin.pocket.depth", rule, pocket.depth, remedy)


def _radius_at(pin: Pin, height: float, along: Array) -> Array:
    """A pin's radius at places `along` its axis, mm from its foot, without the fillet there."""
    root, tip = pin.root_diameter / 2, pin.tip_diameter / 2
    edge = height - pin.crown
    flank = root + (tip - root) * np.clip(along / edge, 0.0, 1.0) if edge > 0 else np.full(along.shape, tip)
    if pin.crown == 0.0:
        return np.where(along <= height, flank, 0.0)
    ball = (tip**2 + pin.crown**2) / (2 * pin.crown)
    cap = np.sqrt(np.maximum(ball**2 - (along - height + ball) ** 2, 0.0))
    return np.where(along <= edge, flank, cap)


def _undercut(outline: Loop) -> Undercut:
    points = np.vstack([polygon(outline, GUARD_TOLERANCE), outline[-1].end])
    summit = int(np.argmax(points[:, 1]))
    sides = points[: summit + 1], (points[summit:] * [-1.0, 1.0])[::-1]  # each from its foot to the summit
    mouths = [np.minimum.accumulate(side[:, 0]) for side in sides]
    width = max(float((side[:, 0] - mouth).max()) for side, mouth in zip(sides, mouths, strict=True))
    if width <= VISIBLE:
        return Undercut(0.0, 0.0)
    levels = np.unique(np.concatenate([side[:, 1] for side in sides]))
    levels = levels[(levels >= max(s[0, 1] for s in sides)) & (levels < points[summit, 1])]
    # a side may dip at its foot where the ridge leans much: below the dip there is no groove
    heights = [np.maximum.accumulate(side[:, 1]) for side in sides]
    full = sum(np.interp(levels, z, side[:, 0]) for z, side in zip(heights, sides, strict=True))
    free = sum(np.interp(levels, z, mouth) for z, mouth in zip(heights, mouths, strict=True))
    return Undercut(width, min(1.0, float((1 - free / full).max())))
