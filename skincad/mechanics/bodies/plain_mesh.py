"""A section's mesh as plain arrays, for whoever wants its corners and not the FE library."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skincad.base.arrays import Array, Index, Mask
from skincad.mechanics.bodies.mesh import FILM, Sizes, triangles, unit_of
from skincad.mechanics.problem import Pad


@dataclass(frozen=True, eq=False)
class PlainMesh:
    """Straight triangles of a section: `points` `(p, 2)` mm, `corners` `(t, 3)` of them, counterclockwise,
    `film` `(t,)` those of the film, and by boundary its `edges` `(e, 2)`."""

    points: Array
    corners: Index
    film: Mask
    edges: dict[str, Index]


def plain_mesh(pad: Pad, sizes: Sizes) -> PlainMesh:
    """Return the triangles of a pad's section in these sizes; boundaries are named as in `triangles`."""
    mesh = triangles(pad, sizes)
    points = np.array([[p[0], p[1]] for p in mesh.Points()]) * unit_of(pad)
    elements = list(mesh.Elements2D())
    corners = np.array([[v.nr - 1 for v in element.vertices[:3]] for element in elements], dtype=np.int64)
    film = np.array([element.index == FILM for element in elements])
    edges: dict[str, list[list[int]]] = {}
    for edge in mesh.Elements1D():
        ends = [v.nr - 1 for v in edge.vertices[:2]]
        edges.setdefault(mesh.GetBCName(edge.index - 1), []).append(ends)
    a, b, c = (points[corners[:, i]] for i in range(3))
    (ux, uz), (vx, vz) = (b - a).T, (c - a).T
    turned = ux * vz - uz * vx < 0
    corners[turned] = corners[turned][:, ::-1]
    return PlainMesh(points, corners, film, {name: np.array(ends) for name, ends in edges.items()})
