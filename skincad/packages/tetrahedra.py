"""The skin as second-order tetrahedra: the section's triangles, swept along y, each prism cut in three.

Regions `skin` and `film` share their nodes. Edges are straight, so an element's Jacobian is that of its
corners: the sign of its volume shows whether it is inside out. The volume that straight edges
miss is reported. Slots that are voids are voids of the mesh; elsewhere silicone or film fills them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from skincad.base.arrays import Array, Index
from skincad.inputs.design import Design
from skincad.mechanics.bodies.mesh import PlainMesh, Sizes, height_of, plain_mesh, unit_of
from skincad.mechanics.bodies.prisms import graded
from skincad.mechanics.problem import Pad, pad_of
from skincad.solids.plan import RevolvedBody
from skincad.solids.skin import along_skin

EDGES = tuple(combinations(range(4), 2))  # of a tetrahedron, in the order below
# node of each edge in the order 01 12 02 03 13 23 that VTK and CalculiX have
MIDDLES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))
CUTS = ((0, 1, 2, 5), (0, 1, 4, 5), (0, 3, 4, 5))  # of a prism, corners below 0 1 2, above 3 4 5, ascending
OUTER_LAYER, GROWTH = (
    0.15,
    1.6,
)  # of the height, the outermost layer; of each layer against the one outside it


@dataclass(frozen=True, eq=False)
class Tetrahedra:
    """`nodes` `(n, 3)` mm in the design's frame; `elements` by region `(e, 10)`, corners first, then middles
    of the edges 01 12 02 03 13 23; `surfaces` by name `(f, 6)`: `back`, and `crest-1`, ... that may touch.
    `volumes` are by region those of the mesh and the exact ones, mm3."""

    nodes: Array
    elements: dict[str, Index]
    surfaces: dict[str, Index]
    volumes: dict[str, tuple[float, float]]

    @property
    def deviation(self) -> float:
        """By how much the mesh's volume is off the exact one, of that."""
        meshed, exact = (math.fsum(pair[i] for pair in self.volumes.values()) for i in (0, 1))
        return abs(meshed / exact - 1)


def tetrahedra(design: Design, fineness: float = 1.0) -> Tetrahedra:
    """Return the mesh of a design; twice the fineness halves the section's edges."""
    pad = pad_of(design.with_(skin={"curvature_radius_y": None}))
    flat = plain_mesh(pad, section_sizes(pad, fineness))
    half = graded(design.skin.length / 2, OUTER_LAYER * height_of(pad) / fineness, GROWTH)
    levels = np.concatenate([-half[:0:-1], half])
    corners, count = _sweep(design, flat, levels), len(flat.points)
    cut = _cut(flat.corners, len(levels) - 1, count)
    cut = _outward(corners, cut)
    film = np.tile(np.repeat(flat.film, len(CUTS)), len(levels) - 1)
    regions = {"skin": cut[~film], "film": cut[film]}
    faces = {_surface(name): _walls(edges, len(levels) - 1, count) for name, edges in flat.edges.items()}
    faces = {name: walls for name, walls in faces.items() if name}
    nodes, edge_of = _middles(corners, cut)
    volumes = {
        name: (float(signed_volumes(corners, cells).sum()), exact)
        for (name, cells), exact in zip(regions.items(), _exact(design, pad), strict=True)
        if len(cells)
    }
    return Tetrahedra(
        nodes,
        {name: _second_order(regions[name], edge_of, MIDDLES) for name in volumes},
        {name: _second_order(cells, edge_of, MIDDLES[:3]) for name, cells in sorted(faces.items())},
        volumes,
    )


def section_sizes(pad: Pad, fineness: float) -> Sizes:
    """Return edges for tetrahedra: four a crest, a film's long sides in a few."""
    unit, height = unit_of(pad), height_of(pad)
    return Sizes(
        contact=unit / 5 / fineness,
        ridge=unit / 3 / fineness,
        bulk=height / 5 / fineness,
        corner=height / 20 / fineness,
        slot=unit / 5 / fineness,
        grading=0.5,
    )


def signed_volumes(nodes: Array, elements: Index) -> Array:
    """Return the volume `(e,)` of each tetrahedron by its corners, below 0 where it is inside out."""
    a, b, c, d = (nodes[elements[:, i]] for i in range(4))
    return np.asarray(np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6)


def _sweep(design: Design, flat: PlainMesh, levels: Array) -> Array:
    """Corners `(levels * p, 3)` mm, level by level; of a doubly curved skin turned about its axis."""
    radius = design.skin.curvature_radius_y
    if radius is None:
        return np.concatenate([np.insert(flat.points, 1, level, axis=1) for level in levels])
    body = RevolvedBody((), design.skin.thickness - radius, 0.0, 0.0)
    return np.concatenate([body.placed(flat.points, level / radius) for level in levels])


def _cut(triangles: Index, layers: int, count: int) -> Index:
    """Tetrahedra `(3 t layers, 4)`. Corners ascend in each prism, so that neighbours cut a face alike."""
    sorted_ = np.sort(triangles, axis=1)
    prisms = np.hstack([sorted_, sorted_ + count])
    one = prisms[:, np.array(CUTS)].reshape(-1, 4)
    return np.concatenate([one + layer * count for layer in range(layers)])


def _outward(corners: Array, cut: Index) -> Index:
    """The tetrahedra, those that were inside out with two corners swapped."""
    elements = cut.copy()
    turned = signed_volumes(corners, cut) < 0
    elements[turned] = elements[turned][:, [1, 0, 2, 3]]
    return elements


def _walls(edges: Index, layers: int, count: int) -> Index:
    """Triangles of the wall over boundary edges, cut as the prisms are."""
    low, high = np.sort(edges, axis=1).T
    one = np.concatenate(
        [np.column_stack([low, high, high + count]), np.column_stack([low, high + count, low + count])]
    )
    return np.concatenate([one + layer * count for layer in range(layers)])


def _surface(boundary: str) -> str:
    if boundary == "back":
        return boundary
    return boundary.replace("contact", "crest-") if boundary.startswith("contact") else ""


def _middles(corners: Array, cut: Index) -> tuple[Array, dict[tuple[int, int], int]]:
    """All nodes, middles of edges after the corners, and the node of each edge by its ends, ascending."""
    ends = np.sort(cut[:, np.array(EDGES)].reshape(-1, 2), axis=1)
    edges = np.unique(ends, axis=0)
    nodes = np.concatenate([corners, corners[edges].mean(axis=1)])
    return nodes, {(a, b): len(corners) + i for i, (a, b) in enumerate(edges.tolist())}


def _second_order(
    corners: Index, edge_of: dict[tuple[int, int], int], middles: tuple[tuple[int, int], ...]
) -> Index:
    ends = np.sort(corners[:, np.array(middles)], axis=2)
    nodes = [[edge_of[a, b] for a, b in row] for row in ends.tolist()]
    return np.hstack([corners, np.array(nodes, dtype=np.int64).reshape(len(corners), len(middles))])


def _exact(design: Design, pad: Pad) -> tuple[float, float]:
    """Exact volumes of skin and film, mm3."""
    strips = tuple(pad.strips)
    skin = along_skin(design, pad.section.outline, (*strips, *pad.voids)).volume
    return skin, math.fsum(along_skin(design, strip, ()).volume for strip in strips)
