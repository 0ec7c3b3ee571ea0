"""A feature: what stands on a skin's base, drawn in its own frame, and its place on the skin.

The frame of a feature: t tangential to the base, n outward from it, mm, origin on the base circle. There
curves hold points (t, n), as they hold (x, z) in the section.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

from skincad.inputs.skin_tables import Slot
from skincad.shape.curves import Loop, Point, Segment, loop

Side = Literal["S1", "S2"]
Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Frame:
    """Where a feature stands in the section: t along the base circle towards +x, n outward."""

    origin: Point
    tangent: Point
    normal: Point

    def at(self, t: float, n: float) -> Point:
        """Return the section's point at (t, n) mm."""
        return Point(
            self.origin.x + t * self.tangent.x + n * self.normal.x,
            self.origin.z + t * self.tangent.z + n * self.normal.z,
        )

    def turned(self, direction: Point) -> Point:
        """Return a direction of the feature's frame in the section."""
        t, n = direction
        return Point(t * self.tangent.x + n * self.normal.x, t * self.tangent.z + n * self.normal.z)


@dataclass(frozen=True)
class SensorPlace:
    """One slot for a film strip, as wide as what is drawn out of it or cast into it: `direction` is the unit
    vector along its depth, outward. Of a `feature` by its number; in a feature's own frame that is 0."""

    feature: int
    side: Side
    centre: Point
    direction: Point
    depth: float
    thickness: float

    @property
    def normal(self) -> Point:
        """Unit vector across the slot, which is the film's normal, towards +x for an upright slot."""
        return Point(self.direction.z, -self.direction.x)

    def at(self, across: float, along: float) -> Point:
        """Return the section's point at these distances from the slot's centre, mm."""
        return Point(
            self.centre.x + across * self.normal.x + along * self.direction.x,
            self.centre.z + across * self.normal.z + along * self.direction.z,
        )

    def loop(self, thickness: float | None = None, grown: float = 0.0) -> Loop:
        """Return the slot's outline, counterclockwise; or a strip of `thickness` mm in its middle, or
        either `grown` by a clearance a side."""
        a, b = (thickness or self.thickness) / 2 + grown, self.depth / 2 + grown
        return loop([self.at(-a, -b), self.at(a, -b), self.at(a, b), self.at(-a, b)], "slot", self.feature)


class Column(NamedTuple):
    """A feature's section halfway up, as that of a column of its mean width w: its second moment is
    `gyration` w^2 of its area, and `shear` is Timoshenko's factor (Strength of Materials, 1955, vol. 1, sec.
    39); `held` if it cannot spread along the feature."""

    gyration: float
    shear: float
    held: bool


BAR, ROD = Column(1 / 12, 5 / 6, True), Column(1 / 16, 0.9, False)


class Form(NamedTuple):
    """What features of a family have in common.

    The section shows one on these `sides` of the middle, -1 as its mirror image; pins stand on it as solids
    of their own. `along` is the share of the skin's length along which a crest runs straight. One is `closed`
    all round, or has ends towards which a front can drive air. A cavity can be parted at its `parting`.
    `place` says where one is, beside its number, by x and y of its tip, mm; a groove is at an `across`; the
    skin's length is along its `way`.
    """

    column: Column = BAR
    sides: tuple[int, ...] = (1,)
    along: float = 0.0
    closed: bool = False
    parting: Literal["flanks", "tips", ""] = ""
    place: str = ""
    way: str = "y"
    across: Literal["x", "radius"] = "x"


FORMS = {  # by family
    "ridge": Form(along=1.0, parting="flanks", way="the ridges"),
    "pin": Form(ROD, sides=(), closed=True, parting="tips", place=" at x {:.4g}, y {:.4g} mm"),
    "ring": Form(sides=(-1, 1), closed=True, across="radius"),
    "flat": Form(),
}


@dataclass(frozen=True, kw_only=True)
class Feature:
    """What stands on the base, in its own frame, mm.

    `outline` runs from the foot at +t to that at -t, the material on its left; segments that `touches` may
    meet a plate. `height` is that of its summit, which lies on the axis; `root_width` and `tip_width` are
    chords before fillets, `crown` is the tip's rise in its middle over its edges. `slot` is the table that
    its `sensors` follow. A face without features has no outline.
    """

    family: str
    outline: Loop
    height: float
    root_width: float
    tip_width: float
    crown: float
    root_fillet: float
    tip_fillet: float
    slot: Slot | None = None
    sensors: tuple[SensorPlace, ...] = ()

    @property
    def form(self) -> Form:
        """What it has in common with all of its family."""
        return FORMS[self.family]

    @property
    def mean_width(self) -> float:
        """Mean of the widths at root and tip, mm."""
        return (self.root_width + self.tip_width) / 2

    @property
    def feet(self) -> tuple[Point, Point]:
        """Where the outline leaves the base, at +t and at -t, (t, n) mm."""
        return self.outline[0].start, self.outline[-1].end


@dataclass(frozen=True)
class Placed:
    """A feature on the skin: `number` counts from 1; `lean` rad is from z to its axis, of a ridge towards +x;
    `neighbours` are the numbers of those beside it. It is as `long` mm along its crest as its area halfway
    up over its mean width. A pin stands at `y` mm, its axis has `axis_y` along y, and `frame` is what of it
    lies in the section's plane."""

    feature: Feature
    frame: Frame
    number: int
    lean: float
    neighbours: tuple[int, ...]
    long: float
    y: float = 0.0
    axis_y: float = 0.0

    @property
    def area(self) -> float:
        """Its area halfway up, mm2: a ring's along its crest line; a flat skin's face."""
        return self.feature.mean_width * self.long

    @property
    def foot(self) -> Vector:
        """Where its axis leaves the base, mm."""
        return self.frame.origin.x, self.y, self.frame.origin.z

    @property
    def axis(self) -> Vector:
        """The unit vector along its axis, outward."""
        return self.frame.normal.x, self.axis_y, self.frame.normal.z

    @property
    def tip(self) -> Vector:
        """The highest point of its axis, mm."""
        return self.summit.x, self.y + self.feature.height * self.axis_y, self.summit.z

    @property
    def summit(self) -> Point:
        """The highest point of its axis, mm."""
        return self.frame.at(0.0, self.feature.height)

    @property
    def outline(self) -> Iterator[Segment]:
        """Its outline in the section, numbered; segments without length are left out."""
        at = self.frame.at
        for segment in self.feature.outline:
            placed = replace(segment, start=at(*segment.start), end=at(*segment.end), feature=self.number)
            if placed.chord > 0.0:
                yield placed

    @property
    def sensors(self) -> Iterator[SensorPlace]:
        """Its sensor places in the section, numbered."""
        for place in self.feature.sensors:
            centre, direction = self.frame.at(*place.centre), self.frame.turned(place.direction)
            yield replace(place, feature=self.number, centre=centre, direction=direction)
