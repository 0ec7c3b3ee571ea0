"""Profile that is cut right through a made part along its body's axis: outline and holes, at nominal size.

A wire, a laser or a router follows it; kerf and spark gap are the machine's to compensate. A conical hole is
in it with its narrow end, to be reamed afterwards. Blind and crosswise cuts are not: the sheet's tables have
them.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from skincad.fabrication.bore_fits import process_of
from skincad.fabrication.drawing_views import PartView, views
from skincad.inputs.design import Design
from skincad.shape.curves import Loop, Point, Segment, area
from skincad.solids.plan import Axis, Body, Bore, Part, Prism, Vector, unturned
from skincad.solids.projection import View

FLUSH_TOLERANCE = 1e-9  # mm, within which a cut reaches a face: rounding
PLACES = 6  # decimals of a millimetre within which cuts are in line
AXES: tuple[Axis, ...] = ("x", "y", "z")


class CutProfile(NamedTuple):
    """The view that looks along the body's axis, and the profile in it, mm: outline first, then holes, all
    counterclockwise."""

    view: str
    loops: tuple[Loop, ...]

    @property
    def area(self) -> float:
        """Area of the outline less its holes, mm2."""
        outline, *holes = (area(loop) for loop in self.loops)
        return outline - sum(holes)


def cut_profile(part: Part) -> CutProfile | None:
    """Return the profile of a part whose body is a prism; None for any other body."""
    plain = unturned(part)
    body = plain.body
    if not isinstance(body, Prism):
        return None
    seen = _along(part, body.axis)
    loops = [body.outline, *body.holes, *_through(plain.cuts, body)]
    return CutProfile(seen.name, tuple(_seen(loop, body.axis, seen.of_part) for loop in loops))


def cut_words(design: Design, part: Part) -> str:
    """Return what layer CUT of a part's DXF holds, and what the machine has to take off."""
    process = process_of(design, part)
    kerf = "kerf not compensated"
    if process.tool == "wire":
        wire, off = f"wire Ø{2 * process.tool_radius:g}", f"{process.spark_gap:g} a side sparks off"
        kerf += f": {wire}, {off}, path {process.reach:g} beside it"
    return f"Layer CUT: profile and through holes (of a cone the narrow end) at nominal size, {kerf}."


def _along(part: Part, axis: Axis) -> PartView:
    index = AXES.index(axis)
    return next(view for view in views(part) if abs(view.of_part.towards[index]) == 1.0)


def _through(cuts: tuple[Body, ...], body: Prism) -> tuple[Loop, ...]:
    """The loops of what goes from face to face of a prism: by itself, or a hole with the pocket that it ends
    in; the narrowest of what is in line."""
    rows: dict[tuple[float, float], list[Prism | Bore]] = {}
    for cut in cuts:
        if isinstance(cut, Prism | Bore) and cut.axis == body.axis:
            u, v = _middle(cut)
            rows.setdefault((round(u, PLACES), round(v, PLACES)), []).append(cut)
    return tuple(_narrowest(row) for row in rows.values() if _spans(row, body))


def _narrowest(row: list[Prism | Bore]) -> Loop:
    loops = [cut.outline if isinstance(cut, Prism) else _circle(cut) for cut in row]
    return min(loops, key=area)


def _spans(row: list[Prism | Bore], body: Prism) -> bool:
    """Whether cuts in line with each other go through without a gap."""
    reached = body.low
    for low, high in sorted(map(_range, row)):
        reached = max(reached, high) if low <= reached + FLUSH_TOLERANCE else reached
    return reached >= body.high - FLUSH_TOLERANCE


def _range(cut: Prism | Bore) -> tuple[float, float]:
    if isinstance(cut, Prism):
        return cut.low, cut.high
    low = cut.start[AXES.index(cut.axis)]
    return low, low + cut.length


def _middle(cut: Prism | Bore) -> tuple[float, float]:
    if isinstance(cut, Bore):
        u, v = (place for axis, place in zip(AXES, cut.start, strict=True) if axis != cut.axis)
        return u, v
    x, z = zip(*(s.start for s in cut.outline), strict=True)
    return (min(x) + max(x)) / 2, (min(z) + max(z)) / 2


def _circle(bore: Bore) -> Loop:
    """A bore's narrow end as two half circles, mm."""
    (u, v), radius = _middle(bore), min(bore.radius, bore.far_radius)
    left, right = Point(u - radius, v), Point(u + radius, v)
    return Segment(left, right, 1.0), Segment(right, left, 1.0)


def _seen(loop: Loop, axis: Axis, view: View) -> Loop:
    """A loop of a prism's section as a view shows it, counterclockwise again where that mirrors it."""

    def at(point: Point) -> Point:
        u, v = point.x, point.z
        placed: dict[Axis, Vector] = {"x": (0.0, u, v), "y": (u, 0.0, v), "z": (u, v, 0.0)}
        return Point(*view.at(placed[axis]))

    ahead = tuple(replace(s, start=at(s.start), end=at(s.end)) for s in loop)
    behind = view.towards[AXES.index(axis)] < 0.0
    if behind == (axis == "y"):  # (x, z) is seen unmirrored from -y
        return ahead
    return tuple(replace(s, start=s.end, end=s.start) for s in reversed(ahead))
