"""The half of a mirror-symmetric pad at x >= 0, its cut at x = 0 straight."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from scipy import optimize, spatial

from skincad.mechanics.problem import Pad
from skincad.shape.curves import Loop, Point, Segment
from skincad.shape.skin import Section

SAME = 1e-9  # of the outline's extent; mirrored points agree to that


def half_of(pad: Pad) -> Pad | None:
    """Return the part of the pad at x >= 0, or None where it is not its own mirror image.

    A segment that crosses x = 0 is cut there, so a middle ridge is cut in half. A strip or void must lie on
    one side. The plate must be flat.
    """
    extent = max(abs(s.start.x) for s in pad.section.outline)
    loops = (pad.section.outline, *pad.strips, *pad.voids)
    if pad.plate.shape != "flat" or not all(_mirrored(kind, SAME * extent) for kind in _groups(pad)):
        return None
    if any(_crosses(loop, SAME * extent) for loop in loops[1:]):
        return None
    outline = _cut(pad.section.outline, SAME * extent)
    if outline is None:
        return None

    def right(inner: tuple[Loop, ...]) -> tuple[Loop, ...]:
        return tuple(loop for loop in inner if loop[0].start.x > 0)

    return replace(pad, section=Section(outline), strips=right(pad.strips), voids=right(pad.voids))


def _groups(pad: Pad) -> list[list[Segment]]:
    """Segments that must be mirrored among each other."""
    return [
        list(pad.section.outline),
        [s for strip in pad.strips for s in strip],
        [s for void in pad.voids for s in void],
    ]


def _mirrored(segments: list[Segment], tolerance: float) -> bool:
    """Whether every segment's mirror image is there; mirroring and running backwards keeps the bulge."""
    if not segments:
        return True
    here = np.array([[*s.start, *s.end] for s in segments])
    image = np.array([[-s.end.x, s.end.z, -s.start.x, s.start.z] for s in segments])
    distance, partner = spatial.cKDTree(image).query(here, p=np.inf)
    return bool(distance.max() <= tolerance) and all(
        math.isclose(s.bulge, segments[j].bulge, rel_tol=1e-6, abs_tol=1e-9) and s.kind == segments[j].kind
        for s, j in zip(segments, partner, strict=True)
    )


def _crosses(loop: Loop, tolerance: float) -> bool:
    at = [s.start.x for s in loop]
    return min(at) < tolerance and max(at) > -tolerance


def _cut(outline: Loop, tolerance: float) -> Loop | None:
    """The outline's part at x >= 0 in one piece, closed along x = 0; None where it is in several."""
    pieces: list[Segment] = []
    for s in outline:
        if s.start.x >= -tolerance and s.end.x >= -tolerance:
            pieces.append(s)
        elif s.start.x > tolerance or s.end.x > tolerance:
            pieces.append(_right_part(s))
    starts = [i for i, s in enumerate(pieces) if abs(s.start.x) <= tolerance]
    if len(starts) != 1:
        return None
    chain = [*pieces[starts[0] :], *pieces[: starts[0]]]
    first, last = chain[0].start, chain[-1].end
    chain[0] = replace(chain[0], start=Point(0.0, first.z))
    chain[-1] = replace(chain[-1], end=Point(0.0, last.z))
    return (*chain, Segment(Point(0.0, last.z), Point(0.0, first.z), kind="cut"))


def _right_part(segment: Segment) -> Segment:
    """A segment that crosses x = 0 once, without its part at x < 0."""
    at = float(optimize.brentq(lambda t: segment.point(t).x, 0.0, 1.0, xtol=1e-15))
    here = Point(0.0, segment.point(at).z)
    if segment.start.x > 0:
        return replace(segment, end=here, bulge=math.tan(segment.sweep * at / 4))
    return replace(segment, start=here, bulge=math.tan(segment.sweep * (1 - at) / 4))
