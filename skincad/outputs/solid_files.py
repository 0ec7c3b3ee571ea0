"""Solids and meshes as files: STEP, STL, 3MF. Same input, same bytes.

Of STEP files the CAD kernel writes the clock's time, a counter that runs on through the process, colours in
the order of memory addresses, and its version as of whichever copy of itself was loaded first (the FE library
brings one too); all are made constant here, in the text. The one time in a file (STEP's header) is
SOURCE_DATE_EPOCH, or 1970 where that is not set.
"""

from __future__ import annotations

import errno
import os
import re
import uuid
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import trimesh

from skincad.base.errors import InputError

if TYPE_CHECKING:
    import cadquery as cq

    from skincad.solids.mold import ClosedMold
    from skincad.solids.plan import Part

_TIME = re.compile(r"(FILE_NAME\('[^']*',')[^']*(')")
_VERSION = re.compile(r"'(Open CASCADE(?: STEP processor)?) \d+\.\d+'")
_NAMELESS = re.compile(r"'Open CASCADE STEP translator [\d. ]+'")
_OCCURRENCE = re.compile(r"(NEXT_ASSEMBLY_USAGE_OCCURRENCE\(')\d+('[^;]*;)")
_WRAP = re.compile(r"\n *")
_ENTITY = re.compile(r"#(\d+) = (.*)", re.DOTALL)
_REFERENCE = re.compile(r"#(\d+)")
_STYLE = "MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION"


def write_step(solid: cq.Workplane, path: Path) -> None:
    """Write one exact solid as STEP (AP214), mm, its product named by the file."""
    solid.val().exportStep(str(path))
    make_deterministic(path, path.stem)


def write_assembly(closed: ClosedMold, solid: Callable[[Part], cq.Workplane], name: str, path: Path) -> None:
    """Write the closed mold with the skin, shims and pins in it, named and coloured, as STEP (AP214), mm."""
    import cadquery as cq

    whole = cq.Assembly(name=name)
    for part in closed.parts:
        whole.add(solid(part), name=part.name, color=cq.Color(*part.colour))
    whole.export(str(path), "STEP")
    make_deterministic(path, name)


def write_stl(mesh: trimesh.Trimesh, path: Path) -> None:
    """Write a mesh as binary STL, mm, single precision."""
    path.write_bytes(mesh.export(file_type="stl"))


def write_3mf(
    meshes: dict[str, tuple[trimesh.Trimesh, tuple[float, float, float]]], path: Path, placed: bool = False
) -> None:
    """Write named, coloured meshes as one 3MF, mm: where they are if they are `placed`, or else side by side
    along y."""
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
        corners = np.asarray(mesh.vertices) + np.array([0.0, 0.0 if placed else along - low[1], 0.0])
        along += high[1] - low[1] + 5.0
        shape.SetGeometry(
            (lib3mf.Position * len(corners)).from_buffer_copy(corners.astype("<f4").tobytes()),
            (lib3mf.Triangle * len(mesh.faces)).from_buffer_copy(mesh.faces.astype("<u4").tobytes()),
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


def make_deterministic(path: Path, name: str) -> None:
    """Rewrite a STEP file in place: header time by SOURCE_DATE_EPOCH (1970 without it), products without a
    name called `name`, occurrences counted from 1, colours in the order of the solids that carry them.

    Raises InputError when SOURCE_DATE_EPOCH is no whole number of seconds, OSError when the file is
    incomplete, which the kernel does not report.
    """
    text = path.read_text("latin-1")
    if not text.rstrip().endswith("END-ISO-10303-21;"):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))
    moment = source_date()
    text = _TIME.sub(lambda m: m[1] + moment + m[2], text, count=1)
    text = text.replace("'Open CASCADE Shape Model'", f"'{name}'", 1).replace("('Author')", "('skincad')", 1)
    text = _VERSION.sub(r"'\1'", text)
    text = _NAMELESS.sub(f"'{name}'", text)
    count = iter(range(1, text.count("NEXT_ASSEMBLY_USAGE_OCCURRENCE") + 1))
    text = _OCCURRENCE.sub(lambda m: f"{m[1]}{next(count)}{_WRAP.sub('', m[2])}", text)
    path.write_text(_styles_in_order(text), "latin-1", newline="\n")


def source_date() -> str:
    """Return the time to write into files, ISO 8601 without zone: SOURCE_DATE_EPOCH, or 1970."""
    seconds = os.environ.get("SOURCE_DATE_EPOCH", "0")
    try:
        moment = datetime.fromtimestamp(int(seconds), UTC)
    except (ValueError, OverflowError, OSError):
        raise InputError("SOURCE_DATE_EPOCH", "must be whole seconds since 1970", seconds) from None
    return moment.strftime("%Y-%m-%dT%H:%M:%S")


def _styles_in_order(text: str) -> str:
    """Renumber the presentation styles, which the kernel writes last, by the solids that they refer to."""
    first = text.find(_STYLE)
    if first < 0:
        return text
    start = text.rfind("#", 0, first)
    end = text.index("ENDSEC;", start)
    entities = {}
    for statement in text[start:end].split(";\n"):
        if match := _ENTITY.fullmatch(statement):
            entities[int(match[1])] = _WRAP.sub("", match[2])
    base = min(entities)
    roots = [number for number, body in entities.items() if body.startswith(_STYLE)]
    order: dict[int, int] = {}
    for root in sorted(roots, key=lambda number: _solids(number, entities)):
        _number(root, entities, base, order)
    lines = [
        f"#{new} = " + _REFERENCE.sub(lambda m: f"#{order.get(int(m[1]), int(m[1]))}", entities[old])
        for old, new in order.items()
    ]
    return text[:start] + ";\n".join(lines) + ";\n" + text[end:]


def _solids(number: int, entities: dict[int, str]) -> list[int]:
    """Entities before the styles that a style refers to; their numbers are stable."""
    references = [int(r) for r in _REFERENCE.findall(entities[number])]
    return [r for r in references if r not in entities]


def _number(old: int, entities: dict[int, str], base: int, order: dict[int, int]) -> None:
    if old in order or old not in entities:
        return
    order[old] = base + len(order)
    for reference in _REFERENCE.findall(entities[old]):
        _number(int(reference), entities, base, order)
