"""Material that a round tool leaves: the opening of the space that it cuts by a disk of its radius.

In the plane of a part's section. A ball-end mill along y and a wire along y both sweep that disk. A corner of
the space with the angle a keeps r (1 / sin(a / 2) - 1) of material on its bisector: a right angle 0.414 r.
"""

from __future__ import annotations

import math

import numpy as np
import shapely
from numpy.typing import NDArray

from skincad.base.arrays import Array
from skincad.shape.curves import Loop, polygon

CHORD = 2e-5  # mm, of the polygons that stand for arcs; depths below are exact to `ERROR`
ERROR = 5 * CHORD  # two buffers and the outline's own chords, and one in reserve
_SAMPLES = 8  # least points a segment besides its chords' ends; corners are always among them


def left_standing(outline: Loop, radius: float, *, from_above: bool = False) -> list[float]:
    """Return for each segment of a part's outline how thick (mm) the material is that a tool of this radius
    leaves on it at most: the largest distance of its points to what the tool reaches.

    `from_above`: the tool comes down z, so nothing under an overhang is cut either. Exact to `ERROR`; too
    small where the nearest reached place lies behind a wall thinner than what is left.
    """
    rows = [s.points(np.linspace(0, 1, max(_SAMPLES, s.pieces(CHORD)) + 1)) for s in outline]
    body = shapely.Polygon(polygon(outline, CHORD))
    solid = body.union(_shade(np.asarray(body.exterior.coords))) if from_above else body
    quarter = max(8, math.ceil(math.pi / 4 / math.sqrt(CHORD / max(2 * radius, CHORD))))
    # what the tool's centre can't enter is the solid grown by r; what it reaches is the rest grown by r
    room = shapely.box(*body.bounds).buffer(4 * radius, join_style="mitre")
    centres = room.difference(solid.buffer(radius, quad_segs=quarter))
    reached = centres.buffer(radius, quad_segs=quarter)
    edges = _edges(reached)
    _, distances = shapely.STRtree(edges).query_nearest(
        shapely.points(np.vstack(rows)), return_distance=True, all_matches=False
    )
    ends = np.cumsum([len(points) for points in rows])
    return [float(part.max()) for part in np.split(distances, ends[:-1])]


def corner(radius: float, angle: float) -> float:
    """Return what a tool leaves on the bisector of a corner of this angle (rad), mm."""
    return radius * (1 / math.sin(angle / 2) - 1)


def _shade(corners: Array) -> shapely.Geometry:
    """Everything straight below an outline's overhanging edges, down to its lowest level."""
    low = corners[:, 1].min()
    quads = [
        shapely.Polygon([(a[0], low), (b[0], low), b, a])
        for a, b in zip(_ccw(corners)[:-1], _ccw(corners)[1:], strict=True)
        if b[0] > a[0] and max(a[1], b[1]) > low
    ]
    return shapely.union_all(quads)


def _ccw(corners: Array) -> Array:
    return corners if shapely.is_ccw(shapely.LinearRing(corners)) else corners[::-1]


def _edges(region: shapely.Geometry) -> NDArray[np.object_]:
    rings = [np.asarray(ring.coords) for ring in shapely.get_parts(shapely.boundary(region))]
    pairs = np.concatenate([np.stack([ring[:-1], ring[1:]], axis=1) for ring in rings])
    edges: NDArray[np.object_] = shapely.linestrings(pairs)
    return edges
