"""Files for slicer, machine shop and bench: STEP, STL, 3MF, DXF, SVG. Same input, same bytes.

The one time in a file (STEP's header) is SOURCE_DATE_EPOCH, or 1970 where that is not set.
"""

from __future__ import annotations

import math
import uuid
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import trimesh

from skincad.fabrication.pattern import StripPattern, pattern_notes, strip_patterns
from skincad.fabrication.seal_pattern import seal_pattern
from skincad.fabrication.shim_pattern import shim_notes, shim_patterns
from skincad.inputs.design import Design
from skincad.outputs.dxf import write_dxf
from skincad.outputs.stepfile import make_deterministic
from skincad.pictures.flat_dimensions import (
    SECTION_WIDTH,
    SIZE,
    seal_dimensions,
    section_dimensions,
    section_margin,
    section_notes,
    strip_dimensions,
)
from skincad.pictures.marks import Dimension, Mark, Words, line
from skincad.pictures.sheet_svg import primitives, svg_row, svg_style
from skincad.shape.curves import Loop, Point
from skincad.shape.skin import section

if TYPE_CHECKING:
    import cadquery as cq

    from skincad.solids.mold import ClosedMold

NOTES_Z, SEAL_NOTES_GAP = -14.0, 6.0  # mm of paper: notes' first line, below z = 0, and below a seal
MARGIN_ABOVE, MARGIN_BESIDE = 13.0, 5.0  # mm over and beside the strips, for their dimensions


def write_step(solid: cq.Workplane, path: Path) -> None:
    """Write one exact solid as STEP (AP214), mm, its product named by the file."""
    solid.val().exportStep(str(path))
    make_deterministic(path, path.stem)


def write_assembly(assembly: cq.Assembly, path: Path) -> None:
    """Write a named, coloured assembly as STEP (AP214), mm."""
    assembly.export(str(path), "STEP")
    make_deterministic(path, assembly.name)


def assembly(closed: ClosedMold, solids: dict[str, cq.Workplane], name: str) -> cq.Assembly:
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
    """Write the skin's own section with true arcs (polyline bulges) as DXF, mm: layers OUTLINE and SLOTS,
    DIMENSIONS, and TEXT, which says that a mold is not cut by it."""
    shape = section(design)
    rows = [("OUTLINE", shape.outline), *(("SLOTS", s.loop()) for s in shape.slots)]
    dimensions, scale = section_dimensions(design)
    notes = section_notes(design)
    write_dxf(
        path, [*dimensions, *_note_words(notes, (-SECTION_WIDTH / 2, NOTES_Z), SIZE)], scale, rows, notes
    )


def _note_words(notes: list[str], at: tuple[float, float], height: float) -> list[Words]:
    """Notes below each other from the place of the first one on, mm of paper."""
    return [Words(text, (at[0], at[1] - 2 * height * i), height, "TEXT") for i, text in enumerate(notes)]


def write_strips_dxf(design: Design, path: Path) -> None:
    """Write the cutting pattern of the film strips as DXF, mm: CUT (outlines and holes), FRONT and BACK
    (metal of either face), ENGRAVE (ridge and side, + sign), MARK (where a strip is cut off later); TEXT and
    DIMENSIONS, to be switched off."""
    strips = strip_patterns(design)
    rows = [row for strip in strips for row in _strip_rows(strip)]
    dimensions, scale = strip_dimensions(strips)

    def on_paper(point: Point) -> tuple[float, float]:
        return scale * point.x, scale * point.z

    marks: list[Mark] = [line(on_paper(a), on_paper(b), "MARK") for strip in strips for a, b in strip.cut_off]
    notes = pattern_notes(design)
    for text, x, z in _strip_texts(design, strips):
        marks.append(Words(text, on_paper(Point(x, z)), scale, "TEXT" if text in notes else "ENGRAVE"))
    write_dxf(path, [*marks, *dimensions], scale, rows, notes)


def _strip_rows(strip: StripPattern) -> list[tuple[str, Loop]]:
    cuts = [("CUT", outline) for outline in (strip.cut, *strip.holes)]
    return [*cuts, ("FRONT", strip.front), ("BACK", strip.back)]


def _strip_texts(design: Design, strips: list[StripPattern]) -> list[tuple[str, float, float]]:
    """What is written on the pattern: text, x and z of its left foot, mm."""
    texts = [(strip.label, *strip.label_at) for strip in strips]
    texts += [("+", *strip.plus_at) for strip in strips]
    left = min(s.start.x for strip in strips for s in strip.cut)
    return [*texts, *((text, left, -2.0 - 2 * i) for i, text in enumerate(pattern_notes(design)))]


def write_shims_dxf(design: Design, closed: ClosedMold, path: Path) -> None:
    """Write the cutting pattern of one skin's shims as DXF, mm: CUT, ENGRAVE (ridge and slot, beside each),
    MARK (where a tail is thinned, at +x) and TEXT."""
    shims, notes = shim_patterns(design, closed), shim_notes(design)
    marks: list[Mark] = [Words(shim.label, shim.label_at, 1.0, "ENGRAVE") for shim in shims]
    marks += [line(*shim.thinned, "MARK") for shim in shims if shim.thinned]
    low = min(s.start.z for shim in shims for s in shim.cut)
    marks += _note_words(notes, (min(shim.label_at.x for shim in shims), low - 3.0), 1.0)
    write_dxf(path, marks, loops=[("CUT", shim.cut) for shim in shims], notes=notes)


def write_seal_dxf(closed: ClosedMold, path: Path) -> None:
    """Write the cutting pattern of the foam under the cover as DXF, mm, seen from above, end b up: CUT
    (outline and holes), TEXT and DIMENSIONS."""
    pattern = seal_pattern(closed)
    dimensions, scale = seal_dimensions(pattern)
    (left, low), _ = pattern.box
    notes = pattern.notes
    note_words = _note_words(notes, (scale * left, scale * low - SEAL_NOTES_GAP), SIZE)
    write_dxf(path, [*dimensions, *note_words], scale, [("CUT", loop) for loop in pattern.loops], notes)


def write_strips_svg(design: Design, path: Path) -> None:
    """Write the same cutting pattern as SVG, mm: classes cut, front, back and mark; where both faces
    have metal, both colours lie over each other."""
    strips = strip_patterns(design)
    texts = _strip_texts(design, strips)
    corners = [s.start for strip in strips for s in strip.cut]
    left, foot = min(x for _, x, _ in texts) - MARGIN_BESIDE, min(z for _, _, z in texts) - 1
    right, top = max(p.x for p in corners) + 8, max(p.z for p in corners) + MARGIN_ABOVE
    right = max(right, left + 0.6 * max(len(text) for text, _, _ in texts))
    outlines = [(layer.lower(), loop) for strip in strips for layer, loop in _strip_rows(strip)]
    shapes = [f'  <path class="{name}" d="{_svg_path(outline)}"/>' for name, outline in outlines]
    shapes += [
        f'  <path class="mark" d="M{a.x:.9g} {-a.z:.9g} L{b.x:.9g} {-b.z:.9g}"/>'
        for strip in strips
        for a, b in strip.cut_off
    ]
    shapes += [f'  <text x="{x:.9g}" y="{-z:.9g}">{text}</text>' for text, x, z in texts]
    shapes.append(_dimensions(*strip_dimensions(strips)))
    style = (
        "path{fill:none;stroke:#333;stroke-width:.03}"
        ".front{fill:#d08020;fill-opacity:.5}.back{fill:#2080c0;fill-opacity:.5}"
        ".mark{stroke:#c00}text{font:1px sans-serif}"
    )
    _write_svg((left, -top, right - left, top - foot), style, shapes, path)


def write_section_svg(design: Design, path: Path) -> None:
    """Write the section with true arcs as SVG, mm, z up."""
    shape = section(design)
    half, top, (margin, over) = design.skin.width / 2, shape.top, section_margin(design)
    box = (-half - margin, -top - over, 2 * (half + margin), top + over + margin)
    curves = [
        f'  <path class="{name}" d="{_svg_path(outline)}"/>'
        for name, outline in [("outline", shape.outline), *(("slot", s.loop()) for s in shape.slots)]
    ]
    style = "path{stroke:#333;stroke-width:.02}.outline{fill:#eebfa6}.slot{fill:#fff}"
    _write_svg(box, style, [*curves, _dimensions(*section_dimensions(design))], path)


def _dimensions(marks: list[Dimension], scale: float) -> str:
    """Dimensions as a group of an SVG of the part's own millimetres, z up."""
    rows = "\n".join(svg_row(mark, 0.0) for mark in primitives(marks))
    return (
        f'  <g class="dimensions" transform="scale({1 / scale:g})" {svg_style("DIMENSIONS")}>\n{rows}\n  </g>'
    )


def _write_svg(box: tuple[float, float, float, float], style: str, shapes: list[str], path: Path) -> None:
    """`box`: left, top (downward), width and height, mm."""
    body = "\n".join(shapes)
    path.write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{box[2]:.6g}mm" height="{box[3]:.6g}mm" '
        f'viewBox="{box[0]:.6g} {box[1]:.6g} {box[2]:.6g} {box[3]:.6g}">\n'
        f"  <style>{style}</style>\n{body}\n</svg>\n",
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
            large_arc, clockwise = int(abs(segment.sweep) > math.pi), int(segment.bulge < 0)
            steps.append(f"A{segment.radius:.9g} {segment.radius:.9g} 0 {large_arc} {clockwise} {end}")
    return " ".join([*steps, "Z"])
