"""Rules of printing in layers: details below pixel or layer, and overhangs as the part lies on the bed."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from skincad.fabrication.finding import Finding
from skincad.fabrication.printed_heights import snapping_remarks, uncertain_ridges
from skincad.fabrication.rules import Case, Rule, maker
from skincad.inputs.design import Design
from skincad.inputs.process import Process, processes
from skincad.shape.skin import skin_of
from skincad.solids.mold import ClosedMold
from skincad.solids.plan import CAVITIES, END_PLATES, Bore, Part, Prism, RevolvedBody, plain, unturned

if TYPE_CHECKING:
    import trimesh

CREST_TOLERANCE = 0.02  # mm, asked: of a crest, to what the casting sheet says of it
BED = 1e-6  # mm, rounding of the lowest facets
_ROUNDING = 1e-9  # mm
_ROUNDING_DEG = 1e-6


def on_end(part: Part, process: Process) -> bool:
    """Whether a part is printed with its y face on the bed."""
    return part.role in END_PLATES or (part.role in CAVITIES and process.orientation == "end")


def laid_on_end(design: Design, part: Part) -> bool:
    """Whether a part of a design is printed with its y face on the bed."""
    return on_end(part, processes(design.printer)[maker(design, part)])


def _details(case: Case) -> Iterator[Finding]:
    """The cavity's shapes that a pixel or a layer swallows. Flat on the bed the crown's rise is cut into
    layers; on end, the section lies in the layers' plane, whose detail is the pixel."""
    process, ridge = case.process, skin_of(case.design).profile
    if not process.layer or case.part.role not in CAVITIES:
        return
    end = on_end(case.part, process)
    rise = process.pixel if end else process.layer
    fine = process.pixel if end else max(process.pixel, process.layer)
    details = [
        ("crown's rise", ridge.crown, rise),
        ("tip fillet", ridge.tip_fillet, fine),
        ("root fillet", ridge.root_fillet, fine),
    ]
    for what, size, limit in details:
        if 0 < size < limit - _ROUNDING:
            ways = [f"multiply all lengths by {math.ceil(100 * limit / size) / 100:g}"]
            if not end and size >= process.pixel - _ROUNDING:
                ways.insert(0, f'print it on end (orientation = "end" in [printer.{case.name}])')
            remedy = f"it comes out stepped: {', or '.join(ways)}"
            yield case.breaks("detail", what, size, limit, "mm", remedy, grave=False)


def _overhang(case: Case) -> Iterator[Finding]:
    """Facets of the print mesh that lean out further than the process can without support, off the bed.
    Horizontal bores up to the process's bridge are left out: they close by themselves."""
    process, part = case.process, unturned(case.part)
    if not process.layer:
        return
    end = on_end(part, process)
    upright = "y" if end else "z"

    def closes(cut: Prism | RevolvedBody | Bore) -> bool:
        return isinstance(cut, Bore) and cut.axis != upright and 2 * cut.radius <= process.bridge

    cuts = tuple(cut for cut in part.cuts if not closes(plain(cut)))
    angle, area = overhang(replace(part, cuts=cuts), process, end)
    if area > 0:
        place = f"{area:.3g} mm2 as printed {'on end' if end else 'flat'}"
        turned = "flat" if end else "end"
        _, other = overhang(replace(part, cuts=cuts), process, not end)
        remedy = "support it" if other else f'orientation = "{turned}", or support it'
        yield case.breaks("overhang", place, angle, process.overhang, "deg", remedy)


def crest_findings(design: Design, closed: ClosedMold) -> Iterator[Finding]:
    """Yield a note where crests may come out a layer lower or higher than the casting sheet says."""
    which, layer = uncertain_ridges(design, closed), processes(design.printer)[design.mold.process].layer
    if which and layer > CREST_TOLERANCE:
        remedy = "; ".join(snapping_remarks(design, closed)) or "another mold.floor"
        where = f"crest {', '.join(map(str, which))} may come out a layer lower or higher than the sheet says"
        yield Finding("crest layer", where, layer, CREST_TOLERANCE, "mm", "note", remedy)


def overhang(part: Part, process: Process, end: bool) -> tuple[float, float]:
    """Return the steepest overhang of a part's print mesh in deg from the vertical, and the area in mm2 that
    is beyond the process's, without the face on the bed; (0, 0) where none is."""
    from skincad.fabrication.meshes import laid

    shape = laid(_print_mesh(part, process.chord), end, part)
    down = -np.asarray(shape.face_normals)[:, 2]
    corners = np.asarray(shape.vertices)[np.asarray(shape.faces)]
    lifted = corners[:, :, 2].max(axis=1) > BED
    angle = np.degrees(np.arcsin(np.clip(down, -1.0, 1.0)))
    over = lifted & (angle > process.overhang + _ROUNDING_DEG)
    areas = np.asarray(shape.area_faces)
    return (float(angle[over].max()), float(areas[over].sum())) if over.any() else (0.0, 0.0)


@lru_cache(maxsize=2)  # a part is laid both ways
def _print_mesh(part: Part, chord: float) -> trimesh.Trimesh:
    from skincad.fabrication.meshes import mesh

    return mesh(part, chord)


LAYER_RULES: tuple[Rule, ...] = (_details, _overhang)
