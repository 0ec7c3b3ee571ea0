"""Triangles of a section: netgen on exact lines and arcs, in a unit of its own.

All lengths are divided by the pad's own unit first, so that a pad of twice the size gets the same mesh.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from netgen.geom2d import SplineGeometry
from netgen.meshing import NgException

from skincad.base.errors import InputError, exhausted
from skincad.mechanics.problem import Pad

# gone
from skincad.shape.curves import Loop, Point, Segment

SKIN, FILM = 1, 2  # domain numbers, 0 is outside
WIDEST_ARC = math.radians(100)  # of one spline, whose control point runs off towards a half turn
SHORTEST = 1e-5  # in units; shorter segments (nanometres) are closed up: netgen fails on them below 1e-6
GENTLER = (1.0, 0.85, 0.7, 0.5, 0.35, 0.25)  # of the asked grading, until netgen finds a mesh
SUMMIT_MARGIN = 0.05  # of a segment; a summit nearer to its end is left between two points


@dataclass(frozen=True)
class Sizes:
    """Largest edges, in mm: on contact segments, the ridges' sides, elsewhere, the back's corners.

    Long sides of slots and strips may have edges of `slot` mm, their corners of `tip` mm if it is not 0;
    `grading` is the growth of neighbouring triangles, netgen's default 0.3. Where the back of a half ends on
    its cut, no corner of the pad, edges are of `corner` too unless `smooth`.
    """

    contact: float
    ridge: float
    bulk: float
    corner: float
    slot: float = 0.0
    grading: float = 0.3
    tip: float = 0.0
    smooth: bool = False


def unit_of(pad: Pad) -> float:
    """Return the pad's own unit of length, mm: the mean length of a ridge's contact segments."""
    total = math.fsum(s.length for s in pad.section.outline if s.touches)
    return total / len(pad.ridges)


def default_sizes(pad: Pad, fineness: float = 1.0) -> Sizes:
    """Return edge sizes for this pad; twice the fineness halves them all.

    The clamped back's corners are singular: unless they are graded to about 1/2000 of the height, the
    difference between two orders says nothing of the error (docs/facts.md#mesh-and-method).
    """
    unit = unit_of(pad)
    flank = max((s.length for s in pad.section.outline if s.kind == "flank"), default=unit)
    height = max(p.start.z for p in pad.section.outline) - min(p.start.z for p in pad.section.outline)
    return Sizes(
        contact=0.1 * unit / fineness,
        ridge=max(0.2 * unit, flank / 8) / fineness,
        bulk=height / 9 / fineness,
        corner=height / 2250 / fineness,
    )


def triangles(pad: Pad, sizes: Sizes) -> Any:
    """Return the netgen mesh of the pad, in the pad's own unit.

    Boundaries are named `back`, `contact<ridge>`, `free`, `strip` and, of a half, `cut`; domains `skin` and
    `film`.
    Raises InputError when netgen finds no mesh.
    """
    unit = unit_of(pad)
    failure: Exception | None = None
    for share in GENTLER:
        try:
            return _geometry(pad, sizes).GenerateMesh(maxh=sizes.bulk / unit, grading=share * sizes.grading)
        except NgException as caught:
            if exhausted(caught):
                raise
            failure = caught
    text = f"netgen finds no mesh ({failure})"
    raise InputError("section", text, remedy="make thin parts thicker")


def _geometry(pad: Pad, sizes: Sizes) -> Any:
    """Return netgen's geometry of the pad."""
    unit = unit_of(pad)
    geometry = SplineGeometry()
    geometry.SetMaterial(SKIN, "skin")
    geometry.SetMaterial(FILM, "film")
    _add(geometry, pad.section.outline, (SKIN, 0), sizes, unit)
    for strip in pad.strips:
        _add(geometry, strip, (FILM, SKIN), sizes, unit)
    for void in pad.voids:
        _add(geometry, void, (0, SKIN), sizes, unit)
    return geometry


def _add(geometry: Any, loop: Loop, domains: tuple[int, int], sizes: Sizes, unit: float) -> None:
    """Add a closed loop with the (left, right) domains."""
    segments = list(_pieces(loop, SHORTEST * unit))
    if len(segments) < 2:
        raise InputError("section", "a loop has no area", remedy="leave it out")
    corners = [_corner(a, b, sizes) for a, b in pairwise([segments[-1], *segments])]
    ids = [
        geometry.AppendPoint(s.start.x / unit, s.start.z / unit, **({"maxh": size / unit} if size else {}))
        for s, size in zip(segments, corners, strict=True)
    ]
    shortest = min(s.length for s in segments)
    for s, first, last in zip(segments, ids, [*ids[1:], ids[0]], strict=True):
        curve: list[Any] = ["line", first, last]
        if s.bulge != 0.0:
            x, z = _control(s)
            curve = ["spline3", first, geometry.AppendPoint(x / unit, z / unit), last]
        left, right = domains
        size = _size(s, sizes, shortest) / unit
        geometry.Append(curve, leftdomain=left, rightdomain=right, maxh=size, bc=_name(s, domains))


def _pieces(loop: Loop, shortest: float) -> Iterator[Segment]:
    """Yield the loop's segments, none shorter than `shortest`, cut as `_cuts` says."""
    long_enough = [s for s in loop if s.length > shortest]
    for i, s in enumerate(long_enough):
        end = long_enough[(i + 1) % len(long_enough)].start
        cuts = _cuts(s)
        points = [s.start, *(s.point(f) for f in cuts[1:-1]), end]
        for a, b, share in zip(points, points[1:], np.diff(cuts), strict=False):
            yield replace(s, start=a, end=b, bulge=math.tan(s.sweep * share / 4) if s.bulge else 0.0)


def _cuts(segment: Segment) -> list[float]:
    """Fractions from 0 to 1 at which to cut: no arc wider than WIDEST_ARC, a contact arc at its summit.

    With a vertex on every summit the first touch is exact, however light the load and flat the skin.
    """
    highest = segment.summit if segment.touches else None
    ends = [0.0, 1.0]
    if highest is not None and SUMMIT_MARGIN < highest < 1 - SUMMIT_MARGIN:
        ends.insert(1, highest)
    cuts = [0.0]
    for a, b in pairwise(ends):
        count = max(1, math.ceil(abs(segment.sweep) * (b - a) / WIDEST_ARC))
        cuts += [a + (b - a) * (j + 1) / count for j in range(count)]
    return cuts


def _control(arc: Segment) -> Point:
    """Control point of the arc as a rational quadratic spline: where its end tangents meet."""
    rise = 2 * arc.bulge / (1 - arc.bulge**2) / 2
    return Point(
        (arc.start.x + arc.end.x) / 2 + rise * (arc.end.z - arc.start.z),
        (arc.start.z + arc.end.z) / 2 - rise * (arc.end.x - arc.start.x),
    )


def _corner(before: Segment, after: Segment, sizes: Sizes) -> float:
    """Largest edge at a singular corner, mm; 0 for the sizes of its segments."""
    if (before.kind == "back") != (after.kind == "back"):
        return 0.0 if sizes.smooth and "cut" in (before.kind, after.kind) else sizes.corner
    return sizes.tip if after.kind == "slot" else 0.0


def _size(segment: Segment, sizes: Sizes, shortest: float) -> float:
    """Largest edge on a segment, mm.

    A slot or strip is straight: its long sides take edges twice its thickness, its ends one edge.
    """
    if segment.kind == "slot":
        return max(2 * shortest, segment.length / 8, sizes.slot)
    if segment.touches:
        return min(sizes.contact, segment.length / 2)
    if segment.kind in ("flank", "root_fillet"):
        return sizes.ridge
    return sizes.bulk


def _name(segment: Segment, domains: tuple[int, int]) -> str:
    if domains[0] == FILM:
        return "strip"
    if segment.kind in ("back", "cut"):
        return segment.kind
    return f"contact{segment.feature}" if segment.touches and domains[0] == SKIN else "free"
