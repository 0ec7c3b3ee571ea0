"""The skin as second-order tetrahedra, written as MSH 4.1 and VTU, and its surface as a height map.

The section's triangles are swept along y and each prism is cut in three. Regions `skin` and `film` share
their nodes. Edges are straight, so an element's Jacobian is that of its corners: the sign of its volume shows
whether it is inside out. The volume that straight edges miss is reported. Slots that are voids are voids of
the mesh; elsewhere silicone or film fills them.

No library at hand writes the files: netgen knows MSH 2 only, NGSolve's VTU has no named regions, trimesh no
volumes. Sources: Gmsh reference manual, MSH file format version 4.1; VTK file formats, unstructured grid.

The height map is for tactile simulators that work on images. At each x the highest point of the section's
outline is exact; a doubly curved skin turns it about its axis, which leaves x as it is: z = c + sqrt((z0 -
c)^2 - y^2).
"""

from __future__ import annotations

import base64
import math
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations, pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skincad.base.arrays import Array, Index
from skincad.fabrication.papers import macro
from skincad.inputs.design import Design
from skincad.inputs.material import layers, silicone
from skincad.inputs.silicone import Silicone
from skincad.mechanics.bodies.mesh import PlainMesh, Sizes, height_of, plain_mesh, unit_of
from skincad.mechanics.bodies.prisms import graded
from skincad.mechanics.problem import PVDF_DENSITY, Pad, pad_of
from skincad.outputs.simulators.models import exactly
from skincad.shape import curves
from skincad.shape.skin import section, skin_of
from skincad.solids.plan import RevolvedBody
from skincad.solids.shots import behind
from skincad.solids.skin import along_skin

EDGES = tuple(combinations(range(4), 2))  # of a tetrahedron, in the order below
# node of each edge in the order 01 12 02 03 13 23 that VTK and CalculiX have
MIDDLES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))
CUTS = ((0, 1, 2, 5), (0, 1, 4, 5), (0, 3, 4, 5))  # of a prism, corners below 0 1 2, above 3 4 5, ascending
# The outermost layer, of the height; each layer against the one outside it
OUTER_LAYER, GROWTH = 0.15, 1.6

TRIANGLE, TETRAHEDRON = 9, 11  # Gmsh's exactly of second-order elements
GMSH_ORDER = [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]  # Gmsh has the middle of edge 23 before that of 13
VTK_TETRAHEDRON = 24
PIXELS_PER_PITCH, MAX_PIXELS = 50, 4096  # pixels: in a pitch, and of an image's longer side
LEVELS = 65535  # of a pixel; 0 is where there is no skin
CHORD = 1e-4  # of the pitch, of the polygon that heights are taken from


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
    alike = design.skin.curvature_radius_y is not None  # contact ends somewhere along y
    growth = 1.0 if alike else GROWTH
    half = graded(design.skin.length / 2, OUTER_LAYER * height_of(pad) / fineness, growth)
    levels = np.concatenate([-half[:0:-1], half])
    corners, count = _sweep(design, flat, levels), len(flat.points)
    cut = _cut(flat.corners, len(levels) - 1, count)
    turned = signed_volumes(corners, cut) < 0  # inside out: two corners change places
    cut[turned] = cut[turned][:, [1, 0, 2, 3]]
    domain = np.tile(np.repeat(flat.domain, len(CUTS)), len(levels) - 1)
    regions = {name: cut[domain == number] for number, name in enumerate(region_names(design), 1)}
    faces = {
        name.replace("contact", "crest-"): _walls(ends, len(levels) - 1, count)
        for name, ends in flat.edges.items()
        if name == "back" or name.startswith("contact")
    }
    edges = np.unique(np.sort(cut[:, np.array(EDGES)].reshape(-1, 2), axis=1), axis=0)
    edge_of = {(a, b): len(corners) + i for i, (a, b) in enumerate(edges.tolist())}
    volumes = {
        name: (float(signed_volumes(corners, cells).sum()), exact)
        for (name, cells), exact in zip(regions.items(), _exact(design, pad), strict=True)
        if len(cells)
    }
    return Tetrahedra(
        np.concatenate([corners, corners[edges].mean(axis=1)]),
        {name: _second_order(regions[name], edge_of, MIDDLES) for name in volumes},
        {name: _second_order(cells, edge_of, MIDDLES[:3]) for name, cells in sorted(faces.items())},
        volumes,
    )


def region_names(design: Design) -> list[str]:
    """Return the regions of a mesh by their domains, 1, 2 and on: skin, film, and the shots from the back."""
    return ["skin", "film", *(f"shot-{number}" for number in range(1, len(design.shot or ()) + 1))]


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


def _walls(edges: Index, layers: int, count: int) -> Index:
    """Triangles of the wall over boundary edges, cut as the prisms are."""
    a, b = np.sort(edges, axis=1).T
    one = np.concatenate([np.stack([a, b, b + count], 1), np.stack([a, b + count, a + count], 1)])
    return np.concatenate([one + layer * count for layer in range(layers)])


def _second_order(
    corners: Index, edge_of: dict[tuple[int, int], int], middles: tuple[tuple[int, int], ...]
) -> Index:
    ends = np.sort(corners[:, np.array(middles)], axis=2)
    nodes = [[edge_of[a, b] for a, b in row] for row in ends.tolist()]
    return np.hstack([corners, np.array(nodes, dtype=np.int64).reshape(len(corners), len(middles))])


def _exact(design: Design, pad: Pad) -> tuple[float, ...]:
    """Exact volumes of skin, film and shots, mm3."""
    strips = tuple(pad.strips)
    below = [0.0, *(behind(design, number).volume for number in range(1, len(design.shot or ()) + 1))]
    skin = along_skin(design, pad.section.outline, (*strips, *pad.voids)).volume - below[-1]
    film = math.fsum(along_skin(design, strip, ()).volume for strip in strips)
    return (skin, film, *(high - low for low, high in pairwise(below)))


def msh(mesh: Tetrahedra) -> str:
    """Return the mesh as MSH 4.1 text, mm: physical volumes skin, film and shot-1, ...; surfaces back
    and crest-1, ..."""
    return "\n".join([*_msh(mesh), ""])


def _msh(mesh: Tetrahedra) -> Iterator[str]:
    surfaces = dict(enumerate(mesh.surfaces, 1))
    volumes = dict(enumerate(mesh.elements, 1))
    yield "$MeshFormat\n4.1 0 8\n$EndMeshFormat"
    yield f"$PhysicalNames\n{len(surfaces) + len(volumes)}"
    yield from (f'2 {tag} "{name}"' for tag, name in surfaces.items())
    yield from (f'3 {tag} "{name}"' for tag, name in volumes.items())
    yield "$EndPhysicalNames"
    yield f"$Entities\n0 0 {len(surfaces)} {len(volumes)}"
    yield from (f"{tag} {_box(mesh, mesh.surfaces[name])} 1 {tag} 0" for tag, name in surfaces.items())
    yield from (f"{tag} {_box(mesh, mesh.elements[name])} 1 {tag} 0" for tag, name in volumes.items())
    yield "$EndEntities"
    count = len(mesh.nodes)
    yield f"$Nodes\n1 {count} 1 {count}\n3 1 0 {count}"
    yield from map(str, range(1, count + 1))
    yield from (exactly(node) for node in mesh.nodes)
    yield "$EndNodes"
    blocks = [(2, tag, TRIANGLE, mesh.surfaces[name]) for tag, name in surfaces.items()]
    blocks += [(3, tag, TETRAHEDRON, mesh.elements[name][:, GMSH_ORDER]) for tag, name in volumes.items()]
    total = sum(len(rows) for *_, rows in blocks)
    yield f"$Elements\n{len(blocks)} {total} 1 {total}"
    first = 1
    for dimension, tag, kind, rows in blocks:
        yield f"{dimension} {tag} {kind} {len(rows)}"
        for i, row in enumerate((rows + 1).tolist(), first):
            yield " ".join(map(str, (i, *row)))
        first += len(rows)
    yield "$EndElements"


def _box(mesh: Tetrahedra, rows: Index) -> str:
    places = mesh.nodes[np.unique(rows)]
    return exactly([*places.min(axis=0), *places.max(axis=0)])


def vtu(mesh: Tetrahedra) -> str:
    """Return the tetrahedra as VTU, mm; cell data `region` is 1 in the skin, 2 in the film, 3 and on in the
    shots from the back."""
    cells = np.concatenate(list(mesh.elements.values()))
    numbers = [
        {"skin": 1, "film": 2}.get(name) or 2 + int(name.removeprefix("shot-")) for name in mesh.elements
    ]
    region = np.repeat(numbers, [len(rows) for rows in mesh.elements.values()])
    offsets, types = 10 * np.arange(1, len(cells) + 1), np.full(len(cells), VTK_TETRAHEDRON)
    parts = {
        "Points": [_array("Float64", 3, "points", mesh.nodes)],
        "Cells": [
            _array("Int64", 1, "connectivity", cells),
            _array("Int64", 1, "offsets", offsets),
            _array("UInt8", 1, "types", types),
        ],
        "CellData": [_array("Int64", 1, "region", region)],
    }
    return macro("simulators/mesh.vtu", "grid", len(mesh.nodes), len(cells), parts)


def _array(kind: str, width: int, name: str, values: Array | Index) -> tuple[str, int, str, str]:
    """An array's type, its numbers a row, its name, and itself as base64."""
    raw = np.ascontiguousarray(values).astype(f"<{np.dtype(kind.lower()).str[1:]}").tobytes()
    return kind, width, name, base64.b64encode(struct.pack("<Q", len(raw)) + raw).decode()


def _stuff(material: Silicone) -> dict[str, Any]:
    return {
        "name": material.name,
        "young_modulus": material.young_modulus.value,
        "poisson_ratio": material.poisson_ratio,
        "density": material.density,
        "law": {"kind": "neo-hooke"} if material.law is None else material.law.model_dump(mode="json"),
    }


def materials(design: Design, mesh: Tetrahedra) -> dict[str, Any]:
    """Return what the regions are made of, with units, and how far the mesh's volume is off."""
    material, film = silicone(design), design.film
    data: dict[str, Any] = {
        "units": {"length": "mm", "young_modulus": "MPa", "density": "kg/m3"},
        "volume": {n: {"mesh_mm3": a, "exact_mm3": b} for n, (a, b) in mesh.volumes.items()},
        "volume_deviation": mesh.deviation,
        "held": "surface back is clamped in every check; crest-1, crest-2, ... are what may touch",
        "skin": _stuff(material),
    }
    data |= {f"shot-{number}": _stuff(stuff) for number, stuff in enumerate(layers(design), 1)}
    if film and "film" in mesh.elements:
        data["film"] = {
            "young_modulus": film.young_modulus,
            "poisson_ratio": film.poisson_ratio,
            "density": PVDF_DENSITY,
            "law": {"kind": "linear elastic"},
        }
    return data


@dataclass(frozen=True, eq=False)
class HeightMap:
    """Heights `(rows, columns)` mm above the back's plane z = 0, NaN where there is no skin: row 0 at the
    largest y, column 0 at the smallest x; squares of `pixel` mm whose middles are meant, the first one's at
    `corner` (x, y) mm."""

    height: Array
    pixel: float
    corner: tuple[float, float]

    @property
    def scale(self) -> float:
        """Height of one level of the image, mm."""
        return float(np.nanmax(self.height)) / LEVELS

    def levels(self) -> NDArray[np.uint16]:
        """Return the image: height over `scale`, 0 without skin."""
        return np.nan_to_num(self.height / self.scale).round().astype(np.uint16)

    def about(self) -> dict[str, Any]:
        """Return what a reader of the image needs."""
        return {
            "unit": "mm",
            "height": "level x scale_mm, over the flat back z = 0; level 0: no skin",
            "scale_mm": self.scale,
            "pixel_mm": self.pixel,
            "first_pixel_xy_mm": list(self.corner),
            "rows": "from the largest y down; columns: from the smallest x up",
        }


def height_map(design: Design) -> HeightMap:
    """Return the heights of a skin, ridges included."""
    skin, radius = design.skin, design.skin.curvature_radius_y
    centre, angle = (0.0, 0.0) if radius is None else (skin.thickness - radius, skin.length / 2 / radius)
    reach = skin.length / 2 if radius is None else (section(design).top - centre) * math.sin(angle)
    pixel = max(skin_of(design).pitch / PIXELS_PER_PITCH, max(skin.width, 2 * reach) / MAX_PIXELS)
    columns, rows = (max(1, math.floor(size / pixel)) for size in (skin.width, 2 * reach))
    x = (np.arange(columns) - (columns - 1) / 2) * pixel
    y = ((rows - 1) / 2 - np.arange(rows)) * pixel
    top = _tops(design, x)
    if radius is None:
        height = np.tile(top, (rows, 1))
    else:
        arm = top - centre
        with np.errstate(invalid="ignore"):
            height = centre + np.sqrt(arm**2 - y[:, None] ** 2)
        height[np.abs(y)[:, None] > arm * math.sin(angle)] = np.nan
    return HeightMap(height, pixel, (float(x[0]), float(y[0])))


def _tops(design: Design, x: NDArray[np.floating[Any]]) -> Array:
    """Largest z of the outline at each x, mm, between its corners along chords."""
    corners = curves.polygon(section(design).outline, CHORD * skin_of(design).pitch)
    tops = np.full(x.size, -np.inf)
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        (x0, z0), (x1, z1) = sorted([tuple(a), tuple(b)])
        here = (x >= x0) & (x <= x1)
        if x1 > x0:
            tops[here] = np.maximum(tops[here], z0 + (z1 - z0) * (x[here] - x0) / (x1 - x0))
    return tops
