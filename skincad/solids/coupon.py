"""The calibration coupon's parts.

What is measured on the first two says how a process draws, what is cast in the other two what its silicone
is. Frames are the mold's: x across, y along, z up, the face that is measured or struck off at z = 0. Lengths
are mm.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from skincad.inputs.design import Design
from skincad.inputs.process import Process
from skincad.shape import curves
from skincad.shape.curves import Loop, Point, Segment, flipped, loop
from skincad.shape.skin import section
from skincad.solids.plan import CutRole, Part, PartRole, Prism, shifted
from skincad.solids.shrinkage import on_grid, scaled_for_shrinkage, shrinkage

NOTCHES = tuple(round(0.06 + 0.02 * i, 2) for i in range(13))  # mm wide: all that shims and films ask for
NOTCH_DEPTH = 0.75  # mm, assumption: a little over the deepest notch of a template's comb that is so narrow
NOTCH_LENGTH = 4.0  # mm: mold.end_plate's default, the length of a comb's notch
# mm; no multiple of a pixel: 0.05 mm pixels meet the notches at five different places. Assumption: 3 mm leave
# a feeler gauge alone with its notch
NOTCH_PITCH = 3.03
LADDER_HEIGHT = 8.0  # mm, assumption: to hold it by
FEWEST_NOTCHES = 5  # assumption: with fewer notches the growth is not known

HEIGHTS = tuple(round(0.40 + 0.13 * i, 2) for i in range(8))  # mm; meet layers of 0.05 and 0.2 mm anywhere
REPEATS = 3  # steps of each height
STEP_PITCH = 3.5  # mm, assumption: 1.5 mm of land between two steps
STEP_WIDTHS = 2.0, 1.2  # mm, at the root and at the tip; assumption: a gauge's ball finds the tip
STEP_LENGTH = 12.0  # mm, of a ridge: as yamada-2002's skin
STEP_BASE = 5.0  # mm, assumption: a block that stays flat

END_LAND = 5.0  # mm, assumption: at both ends of ladder and steps, to zero a gauge on
NICK = 1.0  # mm, leg at 45 degrees so that it prints; under every fifth notch or step
CORNER = 3.0  # mm, leg of the corner that is cut off where notch 1 or step 1 is
WALL = FLOOR = 4.0  # mm, assumption: of the open molds, stiff enough to be struck off
_ROUNDING = 1e-9  # mm


def drawn_notches(process: Process) -> tuple[float, ...]:
    """Return the widths of a process's ladder, mm: those that its tool passes; none where few are left."""
    wide = tuple(width for width in NOTCHES if width >= 2 * process.reach - _ROUNDING)
    return wide if len(wide) >= FEWEST_NOTCHES else ()


def drawn_steps() -> tuple[float, ...]:
    """Return the height of each step, mm, step 1 first: each height once in any eight, never in order."""
    count = len(HEIGHTS)
    return tuple(HEIGHTS[(3 * i + 3 * r) % count] for r in range(REPEATS) for i in range(count))


def coupon_parts(process: Process, pad: Design) -> tuple[Part, ...]:
    """Return the parts of the coupon of a process, whose pad is `pad`: that is cast in the last one."""
    widths = drawn_notches(process)
    ladder = (notch_ladder(widths),) if widths else ()
    return (*ladder, crest_steps(), tensile_mold(pad), pad_mold(pad))


def notch_ladder(widths: tuple[float, ...]) -> Part:
    """Return a plate like a comb, notch 1 at the smallest x: open at the top, and right through along y."""
    top = []
    half = _half(len(widths), NOTCH_PITCH)
    for i, width in enumerate(widths):
        middle, side = _place(i, len(widths), NOTCH_PITCH), width / 2
        corners = [middle - side, middle - side, middle + side, middle + side]
        top += [Point(x, z) for x, z in zip(corners, (0.0, -NOTCH_DEPTH, -NOTCH_DEPTH, 0.0), strict=True)]
    outline = _block(half, LADDER_HEIGHT, top, len(widths), NOTCH_PITCH)
    return Part("notch-ladder", PartRole.COMB, Prism(outline, "y", -NOTCH_LENGTH / 2, NOTCH_LENGTH / 2))


def crest_steps() -> Part:
    """Return a block with ridges of several heights, step 1 at the smallest x, over a land at z = 0."""
    heights, top = drawn_steps(), []
    root, tip = (width / 2 for width in STEP_WIDTHS)
    for i, height in enumerate(heights):
        middle = _place(i, len(heights), STEP_PITCH)
        corners = [middle - root, middle - tip, middle + tip, middle + root]
        top += [Point(x, z) for x, z in zip(corners, (0.0, height, height, 0.0), strict=True)]
    outline = _block(_half(len(heights), STEP_PITCH), STEP_BASE, top, len(heights), STEP_PITCH)
    return Part("crest-steps", PartRole.CAVITY, Prism(outline, "y", -STEP_LENGTH / 2, STEP_LENGTH / 2))


def _place(i: int, count: int, pitch: float) -> float:
    """The middle of notch or step i, which counts from 0, in x."""
    return (i - (count - 1) / 2) * pitch


def _half(count: int, pitch: float) -> float:
    return count * pitch / 2 + END_LAND


def _block(half: float, height: float, top: list[Point], count: int, pitch: float) -> Loop:
    """A block's outline in (x, z) below what its top has from left to right; nicks in its foot, under every
    fifth place, and a corner cut off at its left foot."""
    foot = []
    for i in range(4, count, 5):
        x = _place(i, count, pitch)
        foot += [Point(x - NICK, -height), Point(x, NICK - height), Point(x + NICK, -height)]
    right = [Point(half, -height), Point(half, 0.0)]
    left = [Point(-half, 0.0), Point(-half, CORNER - height), Point(CORNER - half, -height)]
    return loop([*foot, *right, *reversed(top), *left])


def tensile_mold(pad: Design) -> Part:
    """Return an open mold for bars of the pad's silicone, larger by its shrinkage."""
    by = 1 / (1 - shrinkage(pad))
    deep, pitch = on_grid(BAR.thickness * by), BAR.end_width * by + WALL
    half, end = BARS * pitch / 2 + WALL / 2, BAR.length * by / 2 + WALL
    body = Prism(curves.rectangle(-half, half, -end, end), "z", -deep - FLOOR, 0.0)
    outline = bar_outline(by)
    troughs = [
        Prism(shifted(outline, _place(i, BARS, pitch)), "z", -deep, 0.0, role=CutRole.TROUGH)
        for i in range(BARS)
    ]
    return Part("tensile-mold", PartRole.CAVITY, body, tuple(troughs))


def pad_mold(pad: Design) -> Part:
    """Return an open mold for a pad, its ridges down, larger by its shrinkage."""
    cast = scaled_for_shrinkage(pad)
    outline, half = flipped(section(cast).outline), cast.skin.length / 2
    corners = [point for segment in outline for point in (segment.start, segment.end)]
    wide = max(abs(point.x) for point in corners) + WALL
    deep = on_grid(section(cast).top + FLOOR)
    body = Prism(curves.rectangle(-wide, wide, -deep, 0.0), "y", -half - WALL, half + WALL)
    return Part("pad-mold", PartRole.CAVITY, body, (Prism(outline, "y", -half, half, role=CutRole.TROUGH),))


def poured_volumes(parts: tuple[Part, ...]) -> dict[str, float]:
    """Return what each open mold takes, mm3, by its name."""
    return {
        part.name: math.fsum(cut.volume for cut in part.cuts if cut.role is CutRole.TROUGH)
        for part in parts
        if part.cuts
    }


class TensileBar(NamedTuple):
    """A dumb-bell test piece, mm: two wide ends, a narrow part, and arcs between that are tangent to both."""

    length: float
    end_width: float
    narrow_length: float
    width: float
    outer_radius: float
    inner_radius: float
    thickness: float
    gauge_length: float

    @property
    def area(self) -> float:
        """Cross-section of the narrow part, mm2."""
        return self.width * self.thickness


# source: ISO 37, dumb-bells, type 2, which is DIN 53504's S2
BAR = TensileBar(
    length=75.0,
    end_width=12.5,
    narrow_length=25.0,
    width=4.0,
    outer_radius=8.0,
    inner_radius=12.5,
    thickness=2.0,
    gauge_length=20.0,
)
BARS = 3  # source: ISO 37 asks for at least three test pieces


def bar_outline(by: float = 1.0) -> Loop:
    """Return the bar's outline in (x, y), mm, its length along y, all sizes times `by`.

    From the narrow part an arc of the inner radius turns outward, and one of the outer radius back, both by
    the same angle, so that together they rise by what the end is wider.
    """
    both = BAR.inner_radius + BAR.outer_radius
    turn = math.acos(1 - (BAR.end_width - BAR.width) / 2 / both)
    narrow, wide = BAR.width / 2, BAR.end_width / 2
    start, end, bulge = BAR.narrow_length / 2, BAR.length / 2, math.tan(turn / 4)
    x = narrow + BAR.inner_radius * (1 - math.cos(turn))  # where the arcs meet
    y, shoulder = start + BAR.inner_radius * math.sin(turn), start + both * math.sin(turn)
    right = [  # from the lower end upward: a corner, and the bulge of what begins there
        (wide, -end, 0.0),
        (wide, -shoulder, bulge),
        (x, -y, -bulge),
        (narrow, -start, 0.0),
        (narrow, start, -bulge),
        (x, y, bulge),
        (wide, shoulder, 0.0),
        (wide, end, 0.0),
    ]
    whole = [*right, *((-x, -y, bulge) for x, y, bulge in right)]
    corners = [Point(by * x, by * y) for x, y, _ in whole]
    onward = [*corners[1:], corners[0]]
    return tuple(Segment(a, b, bulge) for a, b, (*_, bulge) in zip(corners, onward, whole, strict=True))
