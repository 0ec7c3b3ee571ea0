"""Tetrahedra as MSH 4.1 and VTU.

No library at hand writes them: netgen knows MSH 2 only, NGSolve's VTU has no named regions, trimesh no
volumes.

Sources: Gmsh reference manual, MSH file format version 4.1; VTK file formats, unstructured grid.
"""

from __future__ import annotations

import base64
import struct
from collections.abc import Iterator
from typing import Any

import numpy as np

from skincad.base.arrays import Array, Index
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.mechanics.problem import PVDF_DENSITY
from skincad.packages.files import exactly
from skincad.packages.tetrahedra import Tetrahedra

TRIANGLE, TETRAHEDRON = 9, 11  # Gmsh's exactly of second-order elements
GMSH_ORDER = [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]  # Gmsh has the middle of edge 23 before that of 13
VTK_TETRAHEDRON = 24
REGIONS = ("skin", "film")


def msh(mesh: Tetrahedra) -> str:
    """Return the mesh as MSH 4.1 text, mm: physical volumes skin and film, surfaces back and crest-1, ..."""
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
    yield from (str(i) for i in range(1, count + 1))
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
    """Return the tetrahedra as VTU, mm; cell data `region` is 1 in the skin, 2 in the film."""
    cells = np.concatenate(list(mesh.elements.values()))
    region = np.concatenate([np.full(len(mesh.elements[n]), REGIONS.index(n) + 1) for n in mesh.elements])
    arrays: list[tuple[str, str, int, str, Array | Index]] = [
        ("Points", "Float64", 3, "points", mesh.nodes),
        ("Cells", "Int64", 1, "connectivity", cells),
        ("Cells", "Int64", 1, "offsets", 10 * np.arange(1, len(cells) + 1, dtype=np.int64)),
        ("Cells", "UInt8", 1, "types", np.full(len(cells), VTK_TETRAHEDRON)),
        ("CellData", "Int64", 1, "region", region),
    ]
    lines = ['<?xml version="1.0"?>']
    lines.append(
        '<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64">'
    )
    lines.append(f'<UnstructuredGrid><Piece NumberOfPoints="{len(mesh.nodes)}" NumberOfCells="{len(cells)}">')
    for part in ("Points", "Cells", "CellData"):
        lines.append(f"<{part}>")
        lines += [_array(*row[1:]) for row in arrays if row[0] == part]
        lines.append(f"</{part}>")
    return "\n".join([*lines, "</Piece></UnstructuredGrid></VTKFile>", ""])


def _array(kind: str, width: int, name: str, values: Array | Index) -> str:
    raw = np.ascontiguousarray(values).astype(f"<{np.dtype(kind.lower()).str[1:]}").tobytes()
    text = base64.b64encode(struct.pack("<Q", len(raw)) + raw).decode()
    head = f'type="{kind}" Name="{name}" NumberOfComponents="{width}" format="binary"'
    return f"<DataArray {head}>{text}</DataArray>"


def materials(design: Design, mesh: Tetrahedra) -> dict[str, Any]:
    """Return what the regions are made of, with units, and how far the mesh's volume is off."""
    material, film = silicone(design), design.film
    data: dict[str, Any] = {
        "units": {"length": "mm", "young_modulus": "MPa", "density": "kg/m3"},
        "volume": {n: {"mesh_mm3": a, "exact_mm3": b} for n, (a, b) in mesh.volumes.items()},
        "volume_deviation": mesh.deviation,
        "held": "surface back is clamped in every check; crest-1, crest-2, ... are what may touch",
        "skin": {
            "name": material.name,
            "young_modulus": material.young_modulus.value,
            "poisson_ratio": material.poisson_ratio,
            "density": material.density,
            "law": {"kind": "neo-hooke"} if material.law is None else material.law.model_dump(mode="json"),
        },
    }
    if film and "film" in mesh.elements:
        data["film"] = {
            "young_modulus": film.young_modulus,
            "poisson_ratio": film.poisson_ratio,
            "density": PVDF_DENSITY,
            "law": {"kind": "linear elastic"},
        }
    return data
