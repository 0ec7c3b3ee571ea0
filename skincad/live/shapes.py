"""A design as the page draws it: the skin and the mold's parts as meshes, and the section as a picture."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np
import trimesh
from numpy.typing import NDArray

from skincad.base.errors import InputError
from skincad.fabrication.meshes import mesh
from skincad.inputs.design import Design
from skincad.outputs.pages import html
from skincad.outputs.view import explosion_offset
from skincad.shape.curves import Loop, polygon
from skincad.shape.skin import Section, section, skin_of
from skincad.solids.mold import ClosedMold, mold
from skincad.solids.plan import Part
from skincad.solids.skin import skin_part

CHORD = 2e-3  # of the pad's width: what a chord may miss, less than a pixel of the page
FINE = 2e-3  # of the pitch: chords of the section's picture

Vector = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Piece:
    """Parts that look alike and move together: corners `(n, 3)`, and `offset` in the opened mold, mm."""

    name: str
    label: str  # what it is: cavity, end plates, shim, ...
    colour: tuple[int, int, int]  # red, green, blue, 0 to 255
    corners: NDArray[np.float32]
    faces: NDArray[np.uint32]
    offset: Vector


@dataclass(frozen=True, eq=False)
class DesignView:
    """A design as it is drawn: its skin, ridges up, and its mold with what lies in it, ridges down.

    Without a mold `refusal` says why there is none.
    """

    design: Design
    section: str  # HTML
    skin: Piece
    mold: tuple[Piece, ...]
    closed: ClosedMold | None
    refusal: str


def view(design: Design, *, molded: bool = True) -> DesignView:
    """Return what is drawn of a design, its mold only if `molded`; raises InputError for a skin without a
    section."""
    chord = CHORD * design.skin.width
    picture, refusal, closed = section_svg(design), "", None
    part = skin_part(design)
    skin = _piece("skin", [part], (0.0, 0.0, 0.0), chord)
    try:
        closed = mold(design) if molded else None
    except InputError as failure:
        refusal = str(failure)
    return DesignView(design, picture, skin, pieces(closed, chord) if closed else (), closed, refusal)


def pieces(closed: ClosedMold, chord: float) -> tuple[Piece, ...]:
    """Return the mold's parts, those of a kind that leave together as one piece, in the mold's frame."""
    groups: dict[tuple[str, Vector], list[Part]] = {}
    for part in closed.parts:
        x, y, z = explosion_offset(part, closed).tolist()
        groups.setdefault((part.role.label, (x, y, z)), []).append(part)
    counts: Counter[str] = Counter()
    result = []
    for (label, way), parts in groups.items():
        counts[label] += 1
        result.append(_piece(f"{label} {counts[label]}".replace("'", ""), parts, way, chord))
    return tuple(result)


def section_svg(design: Design) -> str:
    """Return the section as HTML with SVG in it: the whole of it, and its middle ridges large."""
    shape, skin = section(design), skin_of(design)
    base, count = skin.base, skin.count
    reach = min(1.6 * skin.pitch, 0.5 * base.width)
    top = base.thickness + skin.heights[(count - 1) // 2]
    wide = max(abs(s.start.x) for s in shape.outline)
    low = max(base.thickness - 0.35 * reach, 0.0)
    size = f"{base.width:g} x {base.length:g} x {shape.top:.4g} mm"
    frames = (
        _frame(shape, design, (-wide, 0.0, wide, shape.top)),
        _frame(shape, design, (-reach, low, reach, top)),
    )
    return html("live.html", "section", f"{count} ridge{'s' * (count > 1)}, {size}", frames)


def _frame(
    shape: Section, design: Design, box: tuple[float, float, float, float]
) -> tuple[str, list[tuple[str, str]]]:
    """A part of the section between these x and z, mm, z up: its view box, and paths by what they show."""
    left, low, right, high = box
    margin = 0.03 * (right - left)
    sides = left - margin, -high - margin, right - left + 2 * margin, high - low + 2 * margin
    fine = min(FINE * skin_of(design).pitch, 1e-3 * (right - left))

    def path(outline: Loop) -> str:
        return f"M{' '.join(f'{x:.5g},{-z:.5g}' for x, z in polygon(outline, fine))}Z"

    paths = [("skin", path(shape.outline))]
    for slot in (slot for slot in shape.slots if left <= slot.centre.x <= right):
        paths.append(("slot" if design.film_state != "loose" else "void", path(slot.loop())))
        if design.film:
            paths.append(("film", path(slot.loop(design.film.thickness))))
    return " ".join(f"{side:.5g}" for side in sides), paths


def _piece(name: str, parts: list[Part], offset: Vector, chord: float) -> Piece:
    shape, role = trimesh.util.concatenate([mesh(part, chord) for part in parts]), parts[0].role
    corners, faces = shape.vertices.astype(np.float32), shape.faces.astype(np.uint32)
    red, green, blue = (round(255 * part) for part in role.colour)
    return Piece(name, role.label, (red, green, blue), corners, faces, offset)
