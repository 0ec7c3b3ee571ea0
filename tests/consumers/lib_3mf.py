"""lib3mf re-reads strictly: no warning, names, colours, mm, closed oriented meshes of the parts' volume."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import lib3mf
import numpy as np

from skincad.base import Array
from skincad.solids.mold import mold
from tests.consumers import Job, volume_slack


class Object(NamedTuple):
    """A mesh object as read: colour in 0 to 255, and from where to where it lies along y, mm."""

    manifold: bool
    volume: float
    colour: tuple[int, int, int] | None
    along: tuple[float, float]


def missing() -> str:
    """Return why it can't run here, or ""."""
    return ""  # skincad writes with it


def read(path: Path) -> tuple[dict[str, Object], list[str]]:
    """Return a 3MF's objects by name, and the reader's warnings; raises lib3mf's error on a bad file."""
    library = lib3mf.get_wrapper()
    model = library.CreateModel()
    reader = model.QueryReader("3mf")
    reader.SetStrictModeActive(True)
    reader.ReadFromFile(str(path))
    warnings = [reader.GetWarning(i)[1] for i in range(reader.GetWarningCount())]
    if model.GetUnit() != lib3mf.ModelUnit.MilliMeter:
        warnings.append(f"in {model.GetUnit()}")
    objects, shapes = {}, model.GetMeshObjects()
    while shapes.MoveNext():
        shape = shapes.GetCurrentMeshObject()
        corners = np.array([list(corner.Coordinates) for corner in shape.GetVertices()])
        objects[shape.GetName()] = Object(
            bool(shape.IsManifoldAndOriented()),
            _volume(corners, shape),
            _colour(library, model, shape),
            (float(corners[:, 1].min()), float(corners[:, 1].max())),
        )
    return objects, warnings


def _volume(corners: Array, shape: Any) -> float:
    a, b, c = np.moveaxis(corners[np.array([list(t.Indices) for t in shape.GetTriangleIndices()])], 1, 0)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def _colour(library: Any, model: Any, shape: Any) -> tuple[int, int, int] | None:
    resource, index, has = shape.GetObjectLevelProperty()
    if not has:
        return None
    red, green, blue, _ = library.ColorToRGBA(model.GetBaseMaterialGroupByID(resource).GetDisplayColor(index))
    return int(red), int(green), int(blue)


def complaints(job: Job) -> list[str]:
    """Return what the two 3MF files lost or gained."""
    wrong = []
    colours = {p.name: tuple(round(255 * c) for c in p.colour) for p in mold(job.design).parts}
    molded = [part for part in job.result.parts if part.name != "skin"]
    for name, parts in (("solids/skin.3mf", job.result.parts[:1]), ("solids/mold.3mf", molded)):
        objects, warnings = read(job.file(name))
        wrong += [f"{name}: {warning}" for warning in warnings]
        if list(objects) != [part.name for part in parts]:
            wrong.append(f"{name}: holds {', '.join(objects)}")
            continue
        rows = sorted(obj.along for obj in objects.values())
        if any(a[1] >= b[0] for a, b in pairwise(rows)):
            wrong.append(f"{name}: parts lie on each other")
        for part in parts:
            obj = objects[part.name]
            if not obj.manifold or obj.colour != colours[part.name]:
                wrong.append(f"{name}: {part.name} is {obj}")
            # the file's corners are in single precision: 1e-6 of a volume
            if abs(obj.volume - part.volume) > volume_slack(part) + 1e-6 * part.volume:
                wrong.append(f"{name}: {part.name} of {obj.volume:.8g} mm3, made were {part.volume:.8g}")
    return wrong
