"""A design to turn in the hand, as one page: skin and mold, taken apart, cut, opened, and under load."""

from __future__ import annotations

import base64
import json
import math
import zlib
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import trimesh
from manifold3d import triangulate

from skincad.base.arrays import Array, Index
from skincad.base.errors import RefusedError
from skincad.fabrication.job import Job
from skincad.fabrication.sheet import SheetStep, opening_steps
from skincad.inputs.catalog import display_name
from skincad.inputs.design import Design
from skincad.mechanics.verdict import ContactCheck
from skincad.outputs.pages import HERE, data_url, html
from skincad.solids.mold import ClosedMold, Move
from skincad.solids.plan import CAVITIES, END_PLATES, Part, PartRole, Prism, RevolvedBody, RotatedBody

Data = dict[str, Any]
SEAM = 1e-9  # mm, how near to x = 0 a half's points on its middle lie
VIEWER_START = "var camera,controls,scene,renderer"  # so begins trimesh's own viewer, behind the libraries


def view_page(
    job: Job,
    meshes: Mapping[str, trimesh.Trimesh],
    check: ContactCheck | None,
    words: str,
    picture: bytes = b"",
) -> str:
    """Return an HTML document that needs nothing else. `meshes` by part name in the mold's frame, mm; `words`
    say how the design was judged, `check` gives the skin under its load. The `picture`, PNG, is shown where
    a browser draws nothing in three dimensions."""
    design, closed = job.design, job.closed

    def moves(step: SheetStep) -> list[Data]:
        return [{"parts": {n: way_out(closed.part(n), move) for n in move.parts}} for move in step.moves]

    data = {
        "parts": [_part(part, closed, meshes[part.name]) for part in closed.parts],
        "steps": [{"words": step.words, "moves": moves(step)} for step in opening_steps(job)],
        "load": _load(design, check),
    }
    payload = base64.b64encode(zlib.compress(json.dumps(data, allow_nan=False).encode(), 9)).decode()
    style, script = ((HERE / name).read_text("utf-8") for name in ("view.css", "view.js"))
    title, drawn = display_name(design), data_url(picture, "image/png")
    body = html("view.html", "page", title, words, drawn, payload, three_js(), script)
    return html("pieces.html", "document", title, style, body)


def _part(part: Part, closed: ClosedMold, mesh: trimesh.Trimesh) -> Data:
    """A part's mesh, where it is drawn apart, and with which others it is listed."""
    one = part.made != "bought"
    return {
        "name": part.name,
        "group": part.name if one else f"{part.role.label}s",
        "colour": part.colour,
        "clear": part.role in (PartRole.COVER, PartRole.CARRIER),
        "apart": explosion_offset(part, closed).tolist(),
        "points": _packed(np.asarray(mesh.vertices)),
        "faces": _packed(np.asarray(mesh.faces)),
    }


def way_out(part: Part, move: Move) -> Data:
    """Return how a part is moved: by a vector in mm, or turned about an axis along x."""
    body = part.body
    if move.axis == "turn":
        if not isinstance(body, RevolvedBody):
            raise ValueError(f"{part.name}: only what is turned about an axis turns out")
        return {"centre": body.centre, "angle": move.travel}
    if isinstance(move.axis, str):
        way = {"x": np.eye(3)[0], "y": np.eye(3)[1], "z": np.eye(3)[2]}[move.axis]
        if isinstance(body, RotatedBody):  # its own axes
            way = body.placement()[0] @ way
    else:
        way = np.array([move.axis[0], 0.0, move.axis[1]])
    return {"shift": (move.travel * way).tolist()}


def _load(design: Design, check: ContactCheck | None) -> Data | None:
    """The skin under its force, ridges up: corners at rest and moved, the pressure at each, and the plate."""
    if check is None or not check.deformed:
        return None
    loops = [loop for piece in check.deformed for loop in piece]
    rest, moved = (np.vstack([getattr(loop, key) for loop in loops]) for key in ("rest", "moved"))
    joined = _joined(rest)
    caps, first = [], 0
    for piece in check.deformed:
        # loops run as it wants them: counterclockwise outside, seen with x to the right and z up
        caps.append(joined[np.asarray(triangulate([loop.rest for loop in piece])) + first])
        first += sum(len(loop.rest) for loop in piece)
    cap, wall = np.vstack(caps), _wall([len(loop.rest) for loop in loops], joined)
    return {
        "rest": _packed(_along(rest, design.skin.length)),
        "moved": _packed(_along(moved, design.skin.length)),
        "pressure": _packed(np.tile(np.concatenate([loop.pressure for loop in loops]), 2)),
        "faces": _packed(np.vstack([wall[:, ::-1], cap, cap[:, ::-1] + len(rest)])),  # seen from outside
        "plate": _plate(design, check),
        "force": f"{check.force:g} N",
        "approach": str(check.approach),
    }


def _plate(design: Design, check: ContactCheck) -> list[float] | None:
    """A flat plate's height, mm, where it touches the first crest, and under the force."""
    if design.contact.plate.shape != "flat" or check.approach.value is None:
        return None
    loops = [loop for piece in check.deformed for loop in piece]
    pressed = max(float(loop.moved[loop.pressure > 0, 1].max(initial=0)) for loop in loops)
    return [max(float(loop.rest[:, 1].max()) for loop in loops), pressed]


def _along(section: Array, length: float) -> Array:
    """A section's points `(n, 2)` at both ends of the skin, `(2 n, 3)` mm."""
    ends = [np.full(len(section), y) for y in (-length / 2, length / 2)]
    return np.vstack([np.column_stack([section[:, 0], end, section[:, 1]]) for end in ends])


def _joined(points: Array) -> Index:
    """For each point its own index, or on x = 0, where a half meets its image, that of the first there."""
    indices, first = np.arange(len(points)), dict[float, int]()
    for i in np.flatnonzero(np.abs(points[:, 0]) < SEAM).tolist():
        indices[i] = first.setdefault(round(float(points[i, 1]), 9), i)
    return indices


def _wall(lengths: Iterable[int], joined: Index) -> Index:
    """Faces between the ends of loops of so many points, which lie one loop after the other; none between a
    half and its image, where one's edge is the other's in reverse."""
    here = np.arange(sum(lengths := list(lengths)))
    onward = np.concatenate([np.roll(part, -1) for part in np.split(here, np.cumsum(lengths)[:-1])])
    far, edges = len(here), np.stack([joined[here], joined[onward]], 1)
    known = {tuple(edge) for edge in edges.tolist()}
    a, b = np.array([edge for edge in edges.tolist() if (edge[1], edge[0]) not in known]).T
    return np.vstack([np.stack([a, b, b + far], 1), np.stack([a, b + far, a + far], 1)])


def _packed(values: Array | Index) -> str:
    """Numbers in one line of base64: single precision, or whole ones in 32 bits; little-endian."""
    kind = "<u4" if values.dtype.kind in "iu" else "<f4"
    return base64.b64encode(np.ascontiguousarray(values, kind).tobytes()).decode()


def explosion_offset(part: Part, closed: ClosedMold) -> Array:
    """Return where a part is drawn, relative to the closed mold, `(3,)` mm."""
    blocks = [b.body for b in closed.of(PartRole.BLOCK, *CAVITIES) if isinstance(b.body, Prism)]
    levels = [
        z for b in blocks for z in ((b.low, b.high) if b.axis == "z" else (s.start.z for s in b.outline))
    ]
    high, side, body = max(levels) - min(levels), 1.1 * closed.length, part.body
    if part.end is not None:
        out = side * (1.0 if part.role in END_PLATES else 0.5) * (-1 if part.end == "a" else 1)
        lift = 0.25 * high if part.role is PartRole.KEEPER else 0.0
        lean = body.angle if isinstance(body, RotatedBody) else 0.0
        return np.array([0.0, out * math.cos(lean), out * math.sin(lean) + lift])
    if part.role is PartRole.PLUG:  # beside the skin, one over the other
        number = closed.plugs.index(part)
        return np.array([-1.6 * side, 0.0, (0.9 - 0.9 * number) * high])
    places = {
        PartRole.COVER: (0.0, 0.0, 2.3 * high),
        PartRole.SEAL: (0.0, 0.0, 2.0 * high),
        PartRole.COVER_PIN: (0.0, 0.0, 2.3 * high),
        PartRole.CARRIER: (0.0, 0.0, 1.7 * high),
        PartRole.SKIN: (0.0, 0.0, 1.0 * high),
        PartRole.BONE: (0.0, 0.0, 1.45 * high),
        PartRole.STRIP: (0.0, 0.0, 1.0 * high),
        PartRole.CORE_PIN: (0.0, 0.0, 1.9 * high),
        PartRole.BONE_SCREW: (0.0, 0.0, 1.9 * high),
        PartRole.SHIM: (0.0, 2.4 * side, 0.0),
        PartRole.BLOCK: (0.0, 0.0, -0.9 * high),
        PartRole.BASE: (0.0, 0.0, -0.7 * high),
        PartRole.BASE_PIN: (0.0, 0.0, -0.7 * high),
        PartRole.LEFT: (-0.3 * high, 0.0, 0.0),
        PartRole.RIGHT: (0.3 * high, 0.0, 0.0),
    }
    return np.array(places.get(part.role, (0.0, 0.0, 0.0)))


def three_js() -> str:
    """Return three.js with its TrackballControls, a script that defines THREE; MIT, its notice in it.

    Raises RefusedError where the trimesh that is installed carries it no longer.
    """
    from trimesh import resources, util

    packed = util.decompress(resources.get_bytes("templates/viewer.zip"), file_type="zip")
    page = packed["viewer.html.template"].read().decode("utf-8")
    script = page.partition("<script>")[2].partition(VIEWER_START)
    if not script[1] or "TrackballControls" not in script[0]:
        raise RefusedError("this trimesh carries no three.js for view.html; install trimesh 5.2")
    return str(script[0])
