"""Crowns cut where contact ends, so that the mesh is finer there."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from scipy import optimize

from skincad.mechanics.film.stick import PadPiece, StickSolution

# gone
from skincad.shape.curves import Segment


def with_fine_edges(piece: PadPiece, solution: StickSolution) -> PadPiece:
    """Return the piece with its crowns cut around where contact ends in `solution`.

    Full stick has its largest shear at the contact's edges, so its answer is wrong by how far they lie off:
    the last sticking and the first clear point are a step apart. The new pieces are a step long, the mesh's
    edges on them half of that.
    """
    nodes = solution.body.system.nodes
    x = nodes.position[:, 0] * piece.unit
    cuts: dict[int, list[float]] = {}
    for ridge in piece.pad.ridges:
        mine = np.flatnonzero(nodes.ridge == ridge)
        mine = mine[np.argsort(x[mine])]
        for a, b in pairwise(mine):
            if solution.bonded[a] != solution.bonded[b]:
                middle, step = (x[a] + x[b]) / 2, x[b] - x[a]
                cuts.setdefault(ridge, []).extend([middle - step, middle, middle + step])
    outline = tuple(
        piece
        for s in piece.pad.section.outline
        for piece in (_cut(s, cuts.get(s.feature or 0, [])) if s.touches else (s,))
    )
    return replace(piece, pad=replace(piece.pad, section=replace(piece.pad.section, outline=outline)))


def _cut(segment: Segment, at: Sequence[float]) -> Iterator[Segment]:
    """Yield the segment's pieces between these x, mm; it must not turn back in x."""
    low, high = sorted((segment.start.x, segment.end.x))
    inside = [x for x in at if low < x < high]
    roots = [optimize.brentq(lambda t, x=x: segment.point(t).x - x, 0.0, 1.0, xtol=1e-12) for x in inside]
    shares = np.array([0.0, *sorted(roots), 1.0])
    points = [segment.start, *(segment.point(f) for f in shares[1:-1]), segment.end]
    for a, b, share in zip(points, points[1:], np.diff(shares), strict=False):
        yield replace(segment, start=a, end=b, bulge=math.tan(segment.sweep * share / 4))
