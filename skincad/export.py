"""Files for slicer, machine shop and bench: STEP, STL, 3MF, DXF, SVG. Same input, same bytes.

The one time in a file (STEP's header) is SOURCE_DATE_EPOCH, or 1970 where that is not set.
"""

from __future__ import annotations

import math
import uuid
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import ezdxf
import numpy as np
import trimesh
from ezdxf import units as dxf_units

from skincad.curves import Loop, rectangle
from skincad.design import Design
from skincad.section import section
from skincad.stepfile import make_deterministic

if TYPE_CHECKING:
    import cadquery as cq

    from skincad.solids.mold import Mold

STRIP_TAB = 8.0  # mm, assumption: what a strip stands out of the skin at one end for its leads
STRIP_GAP = 2.0  # mm, assumption: between strips on the cutting pattern


def write_step(solid: cq.Workplane, path: Path) -> None:
    """Write one exact solid as STEP (AP214), mm, its product named by the file."""
    solid.val().exportStep(str(path))
    make_deterministic(path, path.stem)


def write_assembly(assembly: cq.Assembly, path: Path) -> None:
    """Write a named, coloured assembly as STEP (AP214), mm."""
    assembly.export(str(path), "STEP")
    make_deterministic(path, assembly.name)


def assembly(closed: Mold, solids: dict[str, cq.Workplane], name: str) -> cq.Assembly:
    """Return the closed mold with the skin, shims and pins in it, named and coloured, mm."""
    import cadquery as cq

    whole = cq.Assembly(name=name)
    for part in closed.parts:
        whole.add(solids[part.name], name=part.name, color=cq.Color(*part.colour))
    return whole


def write_stl(mesh: trimesh.Trimesh, path: Path) -> None:
    """Write a mesh as binary STL, mm, single precision."""
    path.write_bytes(mesh.export(file_type="stl"))


def write_3mf(meshes: dict[str, tuple[trimesh.Trimesh, tuple[float, float, float]]], path: Path) -> None:
    """Write named, coloured meshes as one 3MF, mm, side by side along y."""
    import lib3mf

    library = lib3mf.get_wrapper()
    model = library.CreateModel()
    model.SetUnit(lib3mf.ModelUnit.MilliMeter)
    palette = model.AddBaseMaterialGroup()
    along = 0.0
    for name, (mesh, colour) in meshes.items():
        shape = model.AddMeshObject()
        shape.SetName(name)
        shape.SetUUID(_uuid(name, "object"))
        low, high = mesh.bounds
        corners = np.asarray(mesh.vertices) + np.array([0.0, along - low[1], 0.0])
        along += high[1] - low[1] + 5.0
        shape.SetGeometry(
            [lib3mf.Position((float(x), float(y), float(z))) for x, y, z in corners],
            [lib3mf.Triangle((int(a), int(b), int(c))) for a, b, c in mesh.faces],
        )
        rgb = [round(255 * c) for c in colour]
        paint = palette.AddMaterial(name, library.RGBAToColor(*rgb, 255))
        shape.SetObjectLevelProperty(palette.GetResourceID(), paint)
        model.AddBuildItem(shape, library.GetIdentityTransform()).SetUUID(_uuid(name, "item"))
    model.SetBuildUUID(_uuid("", "build"))
    # by way of memory: on a full disk the library's own writer ends the process
    path.write_bytes(bytes(model.QueryWriter("3mf").WriteToBuffer()))


def _uuid(name: str, kind: str) -> str:
    return str(uuid.uuid5(uuid.NAMESPACE_URL, f"skincad:{kind}:{name}"))


def write_section_dxf(design: Design, path: Path) -> None:
    """Write the section with true arcs (polyline bulges) as DXF, mm: layers OUTLINE and SLOTS."""
    shape = section(design)
    _write_dxf([("OUTLINE", shape.outline), *(("SLOTS", s.loop()) for s in shape.slots)], [], path)


def write_strips_dxf(design: Design, path: Path) -> None:
    """Write the cutting pattern of the film strips as DXF, mm: slot depth by length and a tab, numbered by
    ridge and side, as on the end plates."""
    shape = section(design)
    length = design.skin.length + STRIP_TAB
    rows: list[tuple[str, Loop]] = []
    labels: list[tuple[str, float, float]] = []
    for index, slot in enumerate(shape.slots):
        low = index * (slot.depth + STRIP_GAP)
        rows.append(("CUT", rectangle(0.0, length, low, low + slot.depth)))
        labels.append((f"{slot.ridge} {slot.side}", length + 1.0, low))
    _write_dxf(rows, labels, path)


def _write_dxf(rows: Iterable[tuple[str, Loop]], labels: list[tuple[str, float, float]], path: Path) -> None:
    with _no_clock():
        document = ezdxf.new("R2010", units=dxf_units.MM)
        space = document.modelspace()
        for layer, outline in rows:
            corners = [(s.start.x, s.start.z, s.bulge) for s in outline]
            space.add_lwpolyline(corners, format="xyb", close=True, dxfattribs={"layer": layer})
        for text, x, y in labels:
            space.add_text(text, height=1.0, dxfattribs={"layer": "LABEL"}).set_placement((x, y))
        for kind in sorted(document.entitydb.dxf_types_in_use()):  # the library goes through a set
            document.classes.add_class(kind)
        document.saveas(path)


@contextmanager
def _no_clock() -> Iterator[None]:
    """Have the DXF library write constant times and identifiers, in here only."""
    before = ezdxf.options.write_fixed_meta_data_for_testing
    ezdxf.options.write_fixed_meta_data_for_testing = True
    try:
        yield
    finally:
        ezdxf.options.write_fixed_meta_data_for_testing = before


def write_section_svg(design: Design, path: Path) -> None:
    """Write the section with true arcs as SVG, mm, z up."""
    shape = section(design)
    half, top, margin = design.skin.width / 2, shape.top, 1.0
    box = (-half - margin, -top - margin, 2 * (half + margin), top + 2 * margin)
    curves = "\n".join(
        f'  <path class="{name}" d="{_svg_path(outline)}"/>'
        for name, outline in [("outline", shape.outline), *(("slot", s.loop()) for s in shape.slots)]
    )
    path.write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{box[2]:.6g}mm" height="{box[3]:.6g}mm" '
        f'viewBox="{box[0]:.6g} {box[1]:.6g} {box[2]:.6g} {box[3]:.6g}">\n'
        "  <style>path{stroke:#333;stroke-width:.02}.outline{fill:#eebfa6}.slot{fill:#fff}</style>\n"
        f"{curves}\n</svg>\n",
        encoding="utf-8",
    )


def _svg_path(outline: Loop) -> str:
    start = outline[0].start
    steps = [f"M{start.x:.9g} {-start.z:.9g}"]
    for segment in outline:
        end = f"{segment.end.x:.9g} {-segment.end.z:.9g}"
        if segment.bulge == 0.0 or not math.isfinite(segment.radius):
            steps.append(f"L{end}")
        else:
            wide, turn = int(abs(segment.sweep) > math.pi), int(segment.bulge < 0)
            steps.append(f"A{segment.radius:.9g} {segment.radius:.9g} 0 {wide} {turn} {end}")
    return " ".join([*steps, "Z"])
