"""Rules of milling and wire erosion: what the tool can't reach, and how deep it gets."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache

from skincad.fabrication.finding import Finding
from skincad.fabrication.reach import ERROR, corner, left_standing
from skincad.fabrication.rules import Case, Rule, grooves, slit_play
from skincad.shape.curves import Segment
from skincad.shape.skin import section, skin_of
from skincad.solids.layout import end_angle
from skincad.solids.plan import CAVITIES, PartRole, Prism

# a corner of 89 degrees leaves 2 % more than a right angle: no two are the same on a fan
_CORNER_ALLOWANCE = 1.02

_left = lru_cache(maxsize=64)(left_standing)


def _reach(case: Case) -> Iterator[Finding]:
    """What the tool leaves: a warning in a ridge's groove beyond the tolerance, and elsewhere beyond what any
    tool leaves in a right angle; there a note where a part's sharp edge would not go in."""
    reach, body = case.process.reach, case.along.body
    if not reach or not isinstance(body, Prism) or body.axis != "y":
        return
    milled_down = case.part.role in CAVITIES and case.process.tool == "mill"
    left = _left(body.outline, reach, from_above=milled_down)
    depths = sorted(zip(left, range(len(left)), body.outline, strict=True), reverse=True)
    yield from _in_grooves(case, [(depth, s) for depth, _, s in depths if s.feature is not None])
    yield from _elsewhere(case, [(depth, s) for depth, _, s in depths if s.feature is None])


def _in_grooves(case: Case, depths: list[tuple[float, Segment]]) -> Iterator[Finding]:
    over = [(d, s) for d, s in depths if d > case.process.tolerance + ERROR]
    if not over:
        return
    depth, worst = over[0]
    count = len({s.feature for _, s in over})
    others = f" and {count - 1} more" if count > 1 else ""
    place = f"{worst.kind.replace('_', ' ')} of ridge {worst.feature}{others}"
    reach, ridge = case.process.reach, skin_of(case.design).profile
    remedy = f"a tip_fillet of {reach:g} mm, the tool's radius"
    if ridge.tip_width < 2 * reach:
        remedy = f"a tip_width above {2 * reach:g} mm and a tip_fillet of {reach:g} mm"
    elif ridge.tip_fillet >= reach:
        remedy = "no undercut, which a tool from above can't cut"
    yield case.breaks("tool reach", place, depth, case.process.tolerance, "mm left", remedy)


def _elsewhere(case: Case, depths: list[tuple[float, Segment]]) -> Iterator[Finding]:
    if not depths:
        return
    depth, worst = depths[0]
    reach, choice = case.process.reach, case.design.mold
    comb = case.part.role is PartRole.COMB
    play = math.sqrt(2) * max(0.0, slit_play(case.design, case.process)) if comb else choice.clearance
    limit = play + case.process.tolerance
    if depth > _CORNER_ALLOWANCE * corner(reach, math.pi / 2) + ERROR:
        notch = grooves(case)[0].width if comb else math.inf
        remedy = f"room for a tool of {2 * reach:g} mm" + (f" in {notch:.3g} mm" if comb else "")
        yield case.breaks("tool reach", _place(case, worst), depth, limit, "mm left", remedy)
    elif depth > limit + ERROR:
        what = "the shims' edges" if comb else "the edges of what lies in it"
        remedy = f"break {what} by {depth - play:.2g} mm"
        yield case.breaks("tool reach", _place(case, worst), depth, limit, "mm left", remedy, grave=False)


def _place(case: Case, segment: Segment) -> str:
    """Name a segment: the slot that it is next to in a comb, else its place in the mold's frame."""
    x, z = (segment.start.x + segment.end.x) / 2, (segment.start.z + segment.end.z) / 2
    if case.part.role is PartRole.COMB:
        slot = min(section(case.design).slots, key=lambda s: math.hypot(s.centre.x - x, s.centre.z + z))
        return f"notch {slot.side} of ridge {slot.feature}"
    return f"corner near x {x:.3g}, z {z:.3g} mm"


def _depth(case: Case) -> Iterator[Finding]:
    """A groove deeper than the thickest tool that fits it can cut; a comb is cut through along y."""
    least, most = 2 * case.process.tool_radius, case.process.groove_ratio
    cavity = case.part.role in CAVITIES
    for groove in grooves(case):
        depth = groove.height if cavity else case.design.mold.end_plate
        fits = min(groove.width, 2 * skin_of(case.design).profile.tip_fillet) if cavity else groove.width
        tool = max(fits, least)
        if most and groove.width >= least and depth > most * tool:
            remedy = f"a depth of at most {most * tool:g} mm"
            yield case.breaks("tool depth", groove.where, depth / tool, most, "tool diameters", remedy)


def _straight_cut(case: Case) -> Iterator[Finding]:
    """A wire is straight: it cuts no trough that is bent along it."""
    if case.process.tool == "wire" and case.part.straight:
        angle = math.degrees(2 * end_angle(case.design))
        remedy = "mill, sink-erode or print it, or drop skin.curvature_radius_y"
        yield case.breaks("tool reach", "bent along y", angle, 0.0, "deg end to end", remedy)


TOOL_RULES: tuple[Rule, ...] = (_reach, _depth, _straight_cut)
