"""Where a skin feels: the pose of every film strip and of every ridge's crest; they and responses as files.

A pose `(3, 4)` in the design's frame has the axes as columns, then the place in mm. The third axis points out
of the skin: along a strip's depth, or off a crest; the second is y, along the ridge; the first is across,
towards +x. A strip's place is its slot's centre, a crest's its summit, both in the middle of the length. CSV
and NPZ say frame, unit and meaning themselves.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from skincad.base.arrays import Array
from skincad.base.reading import Cell, csv_text
from skincad.circuit.network import charge, electrode
from skincad.inputs.design import Design
from skincad.mechanics.film.response import SPANS, FilmResponse
from skincad.outputs.simulators.links import touching
from skincad.shape.curves import Point
from skincad.shape.skin import section, skin_of
from skincad.solids.pins import pockets
from skincad.solids.plan import Prism, RevolvedBody, TurnedBody
from skincad.solids.skin import along_skin, skin_part

FRAME = (
    "frame of the design: x along the skin's width, y along its length, z out of the skin, flat back at z = 0"
)
AXES = ("across", "along_y", "outward")
PARTS = ("through_film", "along_film", "lengthwise")
WAYS = ("normal", "tangential")
SAMPLES = (np.arange(64) + 0.5) / 64  # of a segment's length: areas within 1e-4


@dataclass(frozen=True, eq=False)
class Taxels:
    """Places that feel: their `names`, `kinds` ("film", "pocket" or "crest"), `ridges`, `sides` ("S1", "S2"
    or ""), `poses` `(n, 3, 4)` mm, `sizes` `(n, 2)` mm: across or along a strip's depth, and along y, and
    `areas` `(n,)` mm2: of a strip's face, of a pocket's end, and of what of a crest may touch.
    """

    poses: Array
    names: tuple[str, ...]
    kinds: tuple[str, ...]
    ridges: tuple[int, ...]
    sides: tuple[str, ...]
    sizes: Array
    areas: Array


Row = tuple[str, str, int, str, Array, tuple[float, float], float]  # of one place, as `Taxels` has them


def taxels(design: Design) -> Taxels:
    """Return all film strips, ridge by ridge, then the ends of all pockets, then all crests; without a film
    there are no strips."""
    return _columns([*_strips(design), *_pocket_ends(design), *_summits(design)])


def films(design: Design) -> Taxels:
    """Return the film strips; none without slots, without a film, or where it is ignored."""
    return _columns(_strips(design))


def crests(design: Design) -> Taxels:
    """Return the summits of all ridges, or the tips of all pins."""
    return _columns(_summits(design))


def _columns(rows: list[Row]) -> Taxels:
    names, kinds, ridges, sides, poses, sizes, areas = zip(*rows, strict=True) if rows else [()] * 7
    both = np.reshape(poses, (-1, 3, 4)), np.reshape(sizes, (-1, 2))
    return Taxels(both[0], names, kinds, ridges, sides, both[1], np.array(areas, dtype=float))


def _strips(design: Design) -> list[Row]:
    slots = section(design).slots if design.film and design.film_state != "ignored" else ()
    rows: list[Row] = []
    for s in slots:
        along = float(_way(along_skin(design, s.loop(), ()), np.array([s.centre]))[0])
        size = s.depth, design.skin.length
        pose, area = _pose(s.centre, s.direction), s.depth * along
        rows.append((f"ridge-{s.feature}-{s.side}", "film", s.feature, s.side, pose, size, area))
    return rows


def _pocket_ends(design: Design) -> list[Row]:
    """The middles of the pockets' ends, for what lies in them."""
    rows: list[Row] = []
    for i, hole in enumerate(pockets(design), 1):
        pose = np.column_stack([np.eye(3), (hole.start[0], hole.start[1], hole.length)])
        size, area = (2 * hole.radius, 2 * hole.radius), math.pi * hole.radius**2
        rows.append((f"pocket-{i}", "pocket", i, "", pose, size, area))
    return rows


def _summits(design: Design) -> list[Row]:
    skin = skin_of(design)
    poses = [np.column_stack([TurnedBody((), p.foot, p.axis).frame(), p.tip]) for p in skin.placed]
    wide, round_tips = skin.profile.tip_width, skin_part(design).adds
    size = wide, wide if round_tips else design.skin.length
    areas = [
        math.fsum(s.length * float(_way(body, s.points(SAMPLES)).mean()) for s in loop)
        for body, loop in touching(design)
    ]
    return [
        (f"{skin.family}-{i}-crest", "crest", i, "", pose, size, area)
        for i, (pose, area) in enumerate(zip(poses, areas, strict=True), 1)
    ]


def _way(body: Prism | RevolvedBody | TurnedBody, points: Array) -> Array:
    """How far each of a section's points `(n, 2)` mm is swept or turned with a body, `(n,)` mm."""
    if isinstance(body, TurnedBody):
        return np.asarray(2 * math.pi * points[:, 0])
    arm = points[:, 1] - body.centre if isinstance(body, RevolvedBody) else 1.0
    return np.full(len(points), (body.high - body.low) * np.abs(arm))


def _pose(place: Point, outward: Point) -> Array:
    """Pose of a place in the section, its third axis along a unit vector of the section."""
    return np.array(
        [[outward.z, 0.0, outward.x, place.x], [0.0, 1.0, 0.0, 0.0], [-outward.x, 0.0, outward.z, place.z]]
    )


def taxels_csv(places: Taxels) -> str:
    """Return a taxel a row: its place and its three axes, the third outward."""
    columns = ["name", "kind", "ridge", "side", "x_mm", "y_mm", "z_mm"]
    columns += [f"{axis}_{x}" for axis in AXES for x in "xyz"] + ["size_mm", "length_mm", "area_mm2"]
    rows: list[list[Cell]] = [[*columns]]
    for i, name in enumerate(places.names):
        pose = places.poses[i]
        values = [*pose[:, 3], *pose[:, :3].T.ravel(), *places.sizes[i], places.areas[i]]
        words = [name, places.kinds[i], str(places.ridges[i]), places.sides[i]]
        rows.append([*words, *(repr(float(v) + 0.0) for v in values)])
    return csv_text(rows, [FRAME, "mm; axes are unit vectors, the third points out of the skin"])


def write_taxels(places: Taxels, path: Path) -> None:
    """Write the same as NPZ: `poses` (n, 3, 4), `names`, `kinds`, `ridges`, `sides`, `sizes`, `areas`
    and `about`."""
    about = f"poses (n, 3, 4): axes as columns, then the place in mm; {FRAME}"
    columns: dict[str, Any] = {key: np.array(column) for key, column in vars(places).items()}
    np.savez(path, **columns, about=np.array(about))


def charges(design: Design, response: FilmResponse) -> tuple[Array, Array]:
    """Return charge per N `(2, ridges, strips)` pC/N and its error `(2, ridges)`, of normal and tangential
    force; the film's draw axis lies along y."""
    film = design.film
    assert film is not None
    both = np.stack([response.normal, response.tangential])
    coefficients, area = (film.d31, film.d32, film.d33), electrode(design)
    values = charge(both[..., 0], both[..., 2], both[..., 1], area=area, coefficients=coefficients) * 1e12
    size = np.abs([film.d33, film.d32, film.d31])
    return values, area * response.error @ size


def response_csv(design: Design, response: FilmResponse) -> str:
    """Return a row for each force on a ridge and strip: stress and charge per N, error and range."""
    stress = [f"{part}_MPa_per_N" for part in PARTS]
    columns = ["force_on_ridge", "direction", "strip", *stress, *(f"{name}_error" for name in stress)]
    columns += [f"{name}_change_at_{span:g}_of_force" for span in SPANS for name in stress]
    columns += ["charge_pC_per_N", "charge_error_pC_per_N"]
    comments = [
        "mean stress in a strip, tension positive, and its charge, per N of force on one ridge alone;",
        "normal: in compression; tangential: what the plate does to the skin, to +x; add up ridges",
        f"contact as at {response.force:g} N on the skin; change: how much differs where it is that of "
        "another",
    ]
    return csv_text([columns, *_rows(design, response)], comments)


def _rows(design: Design, response: FilmResponse) -> Iterator[list[Cell]]:
    strip_charge, charge_error = charges(design, response)
    for w, (way, stress) in enumerate(zip(WAYS, (response.normal, response.tangential), strict=True)):
        for r in range(len(stress)):
            errors = [*response.error[w, r], *response.at_other_forces[:, w, r].ravel()]
            for s, (ridge, side) in enumerate(response.strips):
                values = [*stress[r, s], *errors, strip_charge[w, r, s], charge_error[w, r]]
                yield [str(r + 1), way, f"ridge-{ridge}-{side}", *(f"{v:.9g}" for v in values)]


def write_response(design: Design, response: FilmResponse, path: Path) -> None:
    """Write the same as NPZ: `stress` (2, ridges, strips, 3) MPa/N, `charge` (2, ridges, strips) pC/N, their
    errors, and the ridges' forces `pressed` (ridges,) N and `pulled` (2, ridges) of 1 N."""
    strip_charge, charge_error = charges(design, response)
    about = "axis 0: normal, tangential; last of stress: through the film, along it in the section, along y"
    np.savez(
        path,
        stress=np.stack([response.normal, response.tangential]),
        stress_error=response.error,
        change=response.at_other_forces,
        spans=np.array(SPANS),
        charge=strip_charge,
        charge_error=charge_error,
        strips=np.array([f"ridge-{ridge}-{side}" for ridge, side in response.strips]),
        force=np.array(response.force),
        contact=response.contact,
        pressed=response.ridge_force,
        pulled=response.ridge_force_per_pull,
        about=np.array(about),
    )
