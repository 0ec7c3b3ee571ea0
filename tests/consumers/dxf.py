"""ezdxf re-reads the section: its own flattening of true arcs gives the area of outline and slots."""

from __future__ import annotations

from pathlib import Path

import ezdxf
import numpy as np
import shapely
from ezdxf.path import make_path

from skincad.shape import area, section
from tests.consumers import Job

CHORD = 1e-6  # mm, of the flattened arcs


def missing() -> str:
    """Return why it can't run here, or ""."""
    return ""  # skincad writes with it


def polygons(path: Path, layer: str) -> list[shapely.Polygon]:
    """Return a layer's closed polylines, their arcs flattened within `CHORD` mm."""
    lines = ezdxf.readfile(path).modelspace().query(f'LWPOLYLINE[layer=="{layer}"]')
    return [shapely.Polygon(np.array([(p.x, p.y) for p in make_path(x).flattening(CHORD)])) for x in lines]


def complaints(job: Job) -> list[str]:
    """Return what of section.dxf is not the section, and cutting patterns that overlap or are missing."""
    shape, path = section(job.design), job.file("drawings/section.dxf")
    outline, slots = polygons(path, "OUTLINE"), polygons(path, "SLOTS")
    if len(outline) != 1 or len(slots) != len(shape.slots):
        return [f"section.dxf: {len(outline)} outlines and {len(slots)} slots"]
    wrong = [] if ezdxf.readfile(path).header["$INSUNITS"] == 4 else ["section.dxf: not in mm"]
    off = abs(outline[0].area - area(shape.outline))
    if off > CHORD * outline[0].length or not outline[0].is_valid:
        wrong.append(f"section.dxf: {outline[0].area:.9g} mm2 of {area(shape.outline):.9g}")
    if abs(outline[0].area - sum(s.area for s in slots) - shape.area) > CHORD * outline[0].length:
        wrong.append("section.dxf: slots of another area")
    if not all(s.within(outline[0]) for s in slots):
        wrong.append("section.dxf: a slot leaves the outline")
    return wrong
