"""The skin as second-order tetrahedra, written as MSH 4.1 and VTU, and its surface as a height map.

The section's triangles are swept along y, or round z in a round skin, and each prism is cut in three. Pins
and pockets are in no section: with them netgen meshes the exact solid. Regions `skin`, `film` and `shot-1`
share their nodes. Edges are straight, so an element's Jacobian is that of its corners: the sign of its volume
shows whether it is inside out. The volume that straight edges miss is reported. Slots that are voids are
voids of the mesh; elsewhere silicone or film fills them. A bone is taken as a flat back, as in a check.

No library at hand writes the files: netgen knows MSH 2 only, NGSolve's VTU has no named regions, trimesh no
volumes. Sources: Gmsh reference manual, MSH file format version 4.1; VTK file formats, unstructured grid.

The height map is for tactile simulators that work on images. At each x the highest point of the section's
outline is exact; a doubly curved skin turns it about its axis, which leaves x as it is: z = c + sqrt((z0 -
c)^2 - y^2). Pins and round skins are seen by rays from above, on the visual mesh.
"""

from __future__ import annotations

import base64
import math
import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Literal, NamedTuple

import numpy as np
import shapely
import trimesh
from numpy.typing import NDArray

from skincad.base.arrays import Array, Index
from skincad.fabrication.papers import macro
from skincad.inputs.design import Design
from skincad.inputs.material import layers, silicone
from skincad.inputs.silicone import Silicone
from skincad.mechanics.bodies.mesh import (
    Sizes,
    SolidMesh,
    height_of,
    piece_of,
    plain_mesh,
    solid_mesh,
    unit_of,
)
from skincad.mechanics.bodies.prisms import graded
from skincad.mechanics.problem import PVDF_DENSITY, Pad, solid_pad_of
from skincad.outputs.simulators.links import touching, visual
from skincad.outputs.simulators.models import exactly
from skincad.shape import curves
from skincad.shape.curves import Segment
from skincad.shape.skin import section, skin_of
from skincad.solids.pins import pockets
from skincad.solids.plan import Body, CutRole, Part, RevolvedBody, TurnedBody
from skincad.solids.shots import behind, room
from skincad.solids.skin import along_skin, skin_part

Way = Literal["swept", "turned", "meshed"]  # the section's mesh along y or round, or netgen's of the solid
EDGES = tuple(combinations(range(4), 2))  # of a tetrahedron, in the order below
# node of each edge in the order 01 12 02 03 13 23 that VTK and CalculiX have
MIDDLES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))
CUTS = ((0, 1, 2, 5), (0, 1, 4, 5), (0, 3, 4, 5))  # of a prism, corners below 0 1 2, above 3 4 5, ascending
# The outermost layer, of the height; each layer against the one outside it
OUTER_LAYER, GROWTH = 0.15, 1.6
LEAST_AROUND = 72  # steps of a full turn, whose chords miss 0.13 % of a volume
NOWHERE = np.empty((0, 3))
CREST_EDGES, BASE_EDGES = 6, 3  # of netgen's, across a tip and in a base's thickness

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
    `volumes` are by region those of the mesh and the exact ones, mm3; `way` is how it was made."""

    nodes: Array
    elements: dict[str, Index]
    surfaces: dict[str, Index]
    volumes: dict[str, tuple[float, float]]
    way: Way = "swept"

    @property
    def quality(self) -> float:
        """The least scaled Jacobian of all tetrahedra, 1 of a regular one (Verdict library, Sandia 2007)."""
        corners = self.nodes[np.concatenate(list(self.elements.values()))[:, :4]]
        others = [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]]
        edges = np.linalg.norm(corners[:, others] - corners[:, :, None], axis=3)
        volumes = np.linalg.det(corners[:, 1:] - corners[:, :1])
        return float((math.sqrt(2) * volumes / edges.prod(axis=2).max(axis=1)).min())

    @property
    def deviation(self) -> float:
        """By how much the mesh's volume is off the exact one, of that."""
        meshed, exact = (math.fsum(pair[i] for pair in self.volumes.values()) for i in (0, 1))
        return abs(meshed / exact - 1)


def tetrahedra(design: Design, fineness: float = 1.0) -> Tetrahedra:
    """Return the mesh of a design; twice the fineness halves the edges. Raises InputError where netgen finds
    none."""
    part = skin_part(design)
    solid = part.adds or pockets(design)  # no section shows it
    mesh = _of_solid(design, part, fineness) if solid else _swept(design, fineness)
    corners, cells = mesh.points, mesh.cells
    turned = signed_volumes(corners, cells) < 0  # inside out: two corners change places
    cells[turned] = cells[turned][:, [1, 0, 2, 3]]
    regions = {name: cells[mesh.domain == number] for number, name in enumerate(region_names(design), 1)}
    edges = np.unique(np.sort(cells[:, np.array(EDGES)].reshape(-1, 2), axis=1), axis=0)
    edge_of = {(a, b): len(corners) + i for i, (a, b) in enumerate(edges.tolist())}
    volumes = {
        name: (float(signed_volumes(corners, rows).sum()), exact)
        for (name, rows), exact in zip(regions.items(), mesh.exact, strict=True)
        if len(rows)
    }
    return Tetrahedra(
        np.concatenate([corners, corners[edges].mean(axis=1)]),
        {name: _second_order(regions[name], edge_of, MIDDLES) for name in volumes},
        {name: _second_order(rows, edge_of, MIDDLES[:3]) for name, rows in sorted(mesh.walls.items())},
        volumes,
        mesh.way,
    )


class _Corners(NamedTuple):
    """A mesh by its corners: `points` `(p, 3)` mm, `cells` `(e, 4)`, their `domain` `(e,)` from 1, triangles
    of `walls` by surface, and `exact` volumes by domain, mm3; `way` says how it was made."""

    points: Array
    cells: Index
    domain: Index
    walls: dict[str, Index]
    exact: tuple[float, ...]
    way: Way


def _swept(design: Design, fineness: float) -> _Corners:
    """The section's triangles swept as the skin is: straight, about its second axis, or round."""
    pad = solid_pad_of(design)
    body = along_skin(design, pad.section.outline, ())
    turned = isinstance(body, TurnedBody)
    section_pad = piece_of(pad).pad if turned else pad
    sizes = section_sizes(section_pad, fineness)
    flat = plain_mesh(section_pad, sizes)
    growth = 1.0 if pad.bend else GROWTH  # contact of a doubly curved skin ends somewhere along y
    half = graded(design.skin.length / 2, OUTER_LAYER * height_of(pad) / fineness, growth)
    levels = np.concatenate([-half[:0:-1], half]) / (pad.bend.radius if pad.bend else 1.0)
    if turned:
        around = math.ceil(math.pi * design.skin.width / sizes.bulk)
        levels = np.linspace(0.0, 2 * math.pi, max(around, round(LEAST_AROUND * fineness)) + 1)
    points = np.concatenate([_at_level(body, flat.points, level) for level in levels])
    node = np.arange(len(points)).reshape(len(levels), -1)
    if turned:  # the last level is the first one, and nodes on the axis are of all
        axis = flat.points[:, 0] == 0.0
        node[-1], node[:, axis] = node[0], node[0, axis]
    layers, count = len(levels) - 1, len(flat.points)
    cells = node.ravel()[_cut(flat.corners, layers, count)]
    domain = np.tile(np.repeat(flat.domain, len(CUTS)), layers)
    walls = {
        name.replace("contact", "crest-"): node.ravel()[_walls(ends, layers, count)]
        for name, ends in flat.edges.items()
        if name == "back" or name.startswith("contact")
    }
    used, kept = np.unique(node), _distinct(cells)
    walls = {name: np.searchsorted(used, rows[_distinct(rows)]) for name, rows in walls.items()}
    cells = np.searchsorted(used, cells[kept])
    way: Way = "turned" if turned else "swept"
    return _Corners(points[used], cells, domain[kept], walls, _exact(design, pad), way)


def _at_level(body: Body, points: Array, level: float) -> Array:
    """Points `(p, 2)` mm of a section at a level of its way, mm or rad: `(p, 3)` mm."""
    if isinstance(body, TurnedBody):
        x, z = points.T
        return np.column_stack([x * math.cos(level), x * math.sin(level), z])
    if isinstance(body, RevolvedBody):
        return body.placed(points, level)
    return np.insert(points, 1, level, axis=1)


def _in_section(body: Body, points: Array) -> Array:
    """Points `(p, 3)` mm where the section of their body passes through them: `(p, 2)` mm."""
    if isinstance(body, TurnedBody):
        own = (points - body.origin) @ body.frame()
        return np.column_stack([np.hypot(own[:, 0], own[:, 1]), own[:, 2]])
    if isinstance(body, RevolvedBody):
        points = body.straightened(points)
    return points[:, [0, 2]]


def _distinct(rows: Index) -> NDArray[np.bool_]:
    """Which rows `(n,)` have no node twice."""
    return np.asarray((np.diff(np.sort(rows, axis=1), axis=1) > 0).all(axis=1))


def _of_solid(design: Design, part: Part, fineness: float) -> _Corners:
    """Netgen's mesh of the exact solid, where no sweep makes it: of pins, and of pockets."""
    from skincad.solids.occ import solid

    skin, count = skin_of(design), len(design.shot or ())
    rooms = [part, *(room(design, number) for number in range(count, 0, -1))]  # each in the one before
    rooms = [replace(one, cuts=tuple(c for c in one.cuts if c.role is CutRole.POCKET)) for one in rooms]
    solids = [solid(whole) for whole in rooms]
    solids = [*(whole.cut(rest) for whole, rest in pairwise(solids)), solids[-1]]
    exact = [*(whole.volume - rest.volume for whole, rest in pairwise(rooms)), rooms[-1].volume]
    size, outline = skin.profile.tip_width / CREST_EDGES / fineness, section(design).outline
    crests = touching(design)
    near = [_around(body, loop, size) for body, loop in crests if isinstance(body, TurnedBody)]
    with TemporaryDirectory() as folder:
        files = [Path(folder, f"{number}.brep") for number in range(len(solids))]
        for shape, file in zip(solids, files, strict=True):
            shape.exportBrep(str(file))
        mesh = solid_mesh(
            files, design.skin.thickness / BASE_EDGES / fineness, np.concatenate([NOWHERE, *near]), size
        )
    walls = {"back": _faces_on(mesh, part.body, [s for s in outline if s.kind == "back"], skin.pitch)}
    for number, (body, loop) in enumerate(crests, 1):
        walls[f"crest-{number}"] = _faces_on(mesh, body, loop, skin.pitch)
    domain = np.array([1, *range(2 + count, 2, -1)])[mesh.domain]  # skin, and the shots from the front
    volumes = exact[0], 0.0, *reversed(exact[1:])
    return _Corners(mesh.points, mesh.corners, domain, walls, volumes, "meshed")


def _around(body: TurnedBody, loop: Sequence[Segment], size: float) -> Array:
    """Places `(n, 3)` mm on what a loop makes of a body, about `size` mm apart."""
    rows = [NOWHERE]
    for s in loop:
        for place in s.points(np.linspace(0.0, 1.0, 1 + math.ceil(s.length / size))):
            turns = np.linspace(0.0, 2 * math.pi, 1 + math.ceil(2 * math.pi * place[0] / size))
            rows += [body.placed(_at_level(body, place[None], turn)) for turn in turns]
    return np.concatenate(rows)


def _faces_on(mesh: SolidMesh, body: Body, loop: Sequence[Segment], pitch: float) -> Index:
    """The triangles `(f, 3)` of those faces that a body's loop makes."""
    lines = [np.vstack([curves.polygon((s,), CHORD * pitch), s.end]) for s in loop]
    places, near = _in_section(body, mesh.points), 2 * CHORD * pitch
    low, high = np.concatenate(lines).min(axis=0) - near, np.concatenate(lines).max(axis=0) + near
    on = ((low <= places) & (places <= high)).all(axis=1)
    on[on] = shapely.dwithin(shapely.points(places[on]), shapely.MultiLineString(lines), near)
    off = np.bincount(mesh.face, weights=~on[mesh.walls].all(axis=1)) > 0
    return mesh.walls[~off[mesh.face]]


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
    """Return the heights of a skin, ridges included; of pins and of a round skin those of its visual mesh."""
    skin, part = design.skin, skin_part(design)
    bent = part.body if isinstance(part.body, RevolvedBody) else None
    reach = (section(design).top - bent.centre) * math.sin(bent.high) if bent else skin.length / 2
    pixel = max(skin_of(design).pitch / PIXELS_PER_PITCH, max(skin.width, 2 * reach) / MAX_PIXELS)
    columns, rows = (max(1, math.floor(size / pixel)) for size in (skin.width, 2 * reach))
    x = (np.arange(columns) - (columns - 1) / 2) * pixel
    y = ((rows - 1) / 2 - np.arange(rows)) * pixel
    if part.adds or isinstance(part.body, TurnedBody):
        return HeightMap(_seen_from_above(visual(design)["skin"], x, y), pixel, (float(x[0]), float(y[0])))
    top = _tops(design, x)
    height = np.tile(top, (rows, 1))
    if bent:
        arm = top - bent.centre
        with np.errstate(invalid="ignore"):
            height = bent.centre + np.sqrt(arm**2 - y[:, None] ** 2)
        height[np.abs(y)[:, None] > arm * math.sin(bent.high)] = np.nan
    return HeightMap(height, pixel, (float(x[0]), float(y[0])))


def _seen_from_above(
    shape: trimesh.Trimesh, x: NDArray[np.floating[Any]], y: NDArray[np.floating[Any]]
) -> Array:
    """Heights `(y, x)` mm at which rays from above meet a mesh, NaN where they miss it."""
    height = np.full((y.size, x.size), np.nan)
    above, down = float(shape.bounds[1, 2]) + 1.0, np.tile([0.0, 0.0, -1.0], (x.size, 1))
    for row, along in zip(height, y, strict=True):
        start = np.column_stack([x, np.full(x.size, along), np.full(x.size, above)])
        places, ray, _ = shape.ray.intersects_location(start, down, multiple_hits=False)
        row[ray] = places[:, 2]
    return height


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
