"""The mesh of a pad's section, or of the half of it where it is mirror-symmetric.

All lengths are divided by the pad's own unit first, so that a pad of twice the size gets the same mesh.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from netgen.geom2d import SplineGeometry
from netgen.meshing import MeshingParameters, NgException
from netgen.occ import Glue, OCCGeometry
from scipy import optimize, spatial

from skincad.base.arrays import Array, Index
from skincad.base.errors import InputError, exhausted
from skincad.mechanics.problem import Pad
from skincad.shape.curves import Loop, Point, Segment
from skincad.shape.feature import SensorPlace
from skincad.shape.skin import Section

SKIN, FILM = 1, 2  # domain numbers, 0 is outside
WIDEST_ARC = math.radians(100)  # of one spline, whose control point runs off towards a half turn
SHORTEST = 1e-5  # in units; shorter segments (nanometres) are closed up: netgen fails on them below 1e-6
GRADING_SHARES = (1.0, 0.85, 0.7, 0.5, 0.35, 0.25)  # of the asked grading, until netgen finds a mesh
# Corner edges from a corner to a point with edges RAMP_EDGE times as long: without it netgen loses a corner's
# size where its neighbours' are about 100 times that. Ridges' meshes stay as they were
RAMP, RAMP_EDGE = 30, 8
SOLID_GRADING, CURVATURE_SAFETY = (
    0.5,
    1.0,
)  # of a solid's mesh: netgen's own are 0.3 and 2, four times as many
FOCUS_EDGES = 9  # of contact segments from x = 0 to the focus's end
SUMMIT_MARGIN = 0.05  # of a segment; a summit nearer to its end is left between two points


@dataclass(frozen=True)
class Sizes:
    """Largest edges, in mm: on contact segments, the ridges' sides, elsewhere, the back's corners.

    Long sides of slots and strips may have edges of `slot` mm, their corners of `tip` mm if it is not 0;
    `grading` is the growth of neighbouring triangles, netgen's default 0.3. Where the back of a half ends on
    its cut, no corner of the pad, edges are of `corner` too unless `smooth`. Contact segments have edges of
    `fine` mm within `focus` mm of x = 0. Back and sides are cut `ramp` mm from their corners.
    """

    contact: float
    ridge: float
    bulk: float
    corner: float
    slot: float = 0.0
    grading: float = 0.3
    tip: float = 0.0
    smooth: bool = False
    focus: float = 0.0
    fine: float = 0.0
    ramp: float = 0.0


def unit_of(pad: Pad) -> float:
    """Return the pad's own unit of length, mm: the mean length of a ridge's contact segments; of a section
    that turns, which a ring crosses twice, those at x >= 0."""
    inside = (s for s in pad.section.outline if not pad.revolved or s.start.x + s.end.x >= 0)
    total = math.fsum(s.length for s in inside if s.touches)
    return total / len(pad.ridges)


def default_sizes(pad: Pad, fineness: float = 1.0) -> Sizes:
    """Return edge sizes for this pad; twice the fineness halves them all.

    The clamped back's corners are singular: unless they are graded to about 1/2000 of the height, the
    difference between two orders says nothing of the error (docs/evidence/facts.md#mesh-and-method).
    """
    unit, ridged = unit_of(pad), not pad.revolved and not pad.face
    flank = max((s.length for s in pad.section.outline if s.kind == "flank"), default=unit)
    height = height_of(pad)
    return Sizes(
        contact=(0.1 * unit if ridged else min(0.1 * unit, height / 9)) / fineness,
        ridge=max(0.2 * unit, flank / 8) / fineness,
        bulk=height / 9 / fineness,
        corner=height / 2250 / fineness,
        focus=pad.focus,
        fine=min(pad.focus / FOCUS_EDGES, height / 9) / fineness,
        ramp=0.0 if ridged else RAMP * height / 2250,
    )


def triangles(pad: Pad, sizes: Sizes) -> Any:
    """Return the netgen mesh of the pad, in the pad's own unit.

    Boundaries are named `back`, `contact<ridge>`, `free`, `inside` and, of a half, `cut`; domains `skin`,
    `film` and `layer<number>`.
    Raises InputError when netgen finds no mesh.
    """
    unit = unit_of(pad)
    failure: Exception | None = None
    for share in GRADING_SHARES:
        try:
            return _geometry(pad, sizes).GenerateMesh(maxh=sizes.bulk / unit, grading=share * sizes.grading)
        except NgException as caught:
            if exhausted(caught):
                raise
            failure = caught
    text = f"netgen finds no mesh ({failure})"
    raise InputError("section", text, remedy="make thin parts thicker")


def _geometry(pad: Pad, sizes: Sizes) -> Any:
    """Return netgen's geometry of the pad."""
    unit = unit_of(pad)
    geometry = SplineGeometry()
    geometry.SetMaterial(SKIN, "skin")
    geometry.SetMaterial(FILM, "film")
    for number in range(1, len(pad.layers) + 1):
        geometry.SetMaterial(FILM + number, f"layer{number}")
    outline = tuple(at_faces(pad))
    points = _add(geometry, outline, [(_domain(pad, s), 0) for s in outline], sizes, unit)
    for number, layer in enumerate(pad.layers, 1):
        above = FILM + number + 1 if number < len(pad.layers) else SKIN
        ends = [min(points, key=partial(math.dist, end)) for end in (layer.face.start, layer.face.end)]
        curve = _curve(geometry, layer.face, (points[ends[0]], points[ends[1]]), unit)
        size = sizes.bulk / unit
        geometry.Append(curve, leftdomain=FILM + number, rightdomain=above, maxh=size, bc="inside")
    for strip in pad.strips:
        _add(geometry, strip, [(FILM, _domain(pad, strip[0]))] * len(strip), sizes, unit)
    for void in pad.voids:
        _add(geometry, void, [(0, _domain(pad, void[0]))] * len(void), sizes, unit)
    return geometry


def _domain(pad: Pad, segment: Segment) -> int:
    """The silicone's domain along a segment, inside the pad."""
    x, z = segment.point(0.5)
    behind = (FILM + number for number, layer in enumerate(pad.layers, 1) if z < layer.over(x))
    return next(behind, SKIN)


def at_faces(pad: Pad) -> Iterator[Segment]:
    """Yield the pad's outline, its sides and cut in pieces where layers' faces end."""
    for s in pad.section.outline:
        heights = [layer.over(s.start.x) for layer in pad.layers] if s.kind in ("side", "cut") else []
        low, high = sorted((s.start.z, s.end.z))
        inside = sorted((z for z in heights if low < z < high), reverse=s.start.z > s.end.z)
        ends = [s.start, *(Point(s.start.x, z) for z in inside), s.end]
        yield from (replace(s, start=a, end=b) for a, b in pairwise(ends))


def _add(
    geometry: Any, loop: Loop, domains: list[tuple[int, int]], sizes: Sizes, unit: float
) -> dict[Point, int]:
    """Add a closed loop with each segment's (left, right) domains; return its points' numbers."""
    pieces = list(_pieces(loop, SHORTEST * unit, sizes))
    segments = [piece for piece, _ in pieces]
    if len(segments) < 2:
        raise InputError("section", "a loop has no area", remedy="leave it out")
    corners = [_corner(a, b, sizes) for a, b in pairwise([segments[-1], *segments])]
    ids = [
        geometry.AppendPoint(s.start.x / unit, s.start.z / unit, **({"maxh": size / unit} if size else {}))
        for s, size in zip(segments, corners, strict=True)
    ]
    shortest = min(s.length for s in segments)
    for (s, of), first, last in zip(pieces, ids, [*ids[1:], ids[0]], strict=True):
        left, right = domains[of]
        geometry.Append(
            _curve(geometry, s, (first, last), unit), leftdomain=left, rightdomain=right,
            maxh=_size(s, sizes, shortest) / unit, bc=_name(s, domains[of]),
        )  # fmt: skip
    return {s.start: number for s, number in zip(segments, ids, strict=True)}


def _curve(geometry: Any, s: Segment, ends: tuple[int, int], unit: float) -> list[Any]:
    """Netgen's curve of a segment between two of its points."""
    if s.bulge == 0.0:
        return ["line", *ends]
    # a rational quadratic spline, whose control point is where the end tangents meet
    rise = 2 * s.bulge / (1 - s.bulge**2) / 2
    x = (s.start.x + s.end.x) / 2 + rise * (s.end.z - s.start.z)
    z = (s.start.z + s.end.z) / 2 - rise * (s.end.x - s.start.x)
    return ["spline3", ends[0], geometry.AppendPoint(x / unit, z / unit), ends[1]]


def _pieces(loop: Loop, shortest: float, sizes: Sizes) -> Iterator[tuple[Segment, int]]:
    """Yield the loop's segments, none shorter than `shortest`, cut as `_cuts` says, and their place in it."""
    long_enough = [(i, s) for i, s in enumerate(loop) if s.length > shortest]
    for at, (i, s) in enumerate(long_enough):
        end = long_enough[(at + 1) % len(long_enough)][1].start
        cuts = _cuts(s, sizes)
        points = [s.start, *(s.point(f) for f in cuts[1:-1]), end]
        for a, b, share in zip(points, points[1:], np.diff(cuts), strict=False):
            yield replace(s, start=a, end=b, bulge=math.tan(s.sweep * share / 4) if s.bulge else 0.0), i


def _cuts(segment: Segment, sizes: Sizes) -> list[float]:
    """Fractions from 0 to 1 at which to cut: no arc wider than WIDEST_ARC, a contact arc at its summit, and
    where `Sizes` has a `focus` or a `ramp`.

    With a vertex on every summit the first touch is exact, however light the load and flat the skin.
    """
    highest = segment.summit if segment.touches else None
    ends, focus = [0.0, 1.0], sizes.focus
    if segment.kind in ("back", "side"):
        near = sizes.ramp / segment.length
        corners = segment.kind == "back" and segment.start.x < 0, segment.kind == "back"
        if segment.kind == "side":
            corners = segment.start.z < segment.end.z, segment.start.z > segment.end.z
        ends += [f for f, at in zip((near, 1 - near), corners, strict=True) if at and 0 < near < 1 / 2]
        return sorted(ends)
    if highest is not None and SUMMIT_MARGIN < highest < 1 - SUMMIT_MARGIN:
        ends.insert(1, highest)
    if focus and segment.touches and segment.bulge:
        apex = highest if highest is not None else float(segment.end.z > segment.start.z)
        reach = math.asin(min(1.0, focus / segment.radius)) / segment.sweep
        if abs(segment.point(apex).x) < focus / FOCUS_EDGES:
            ends += [f for f in (apex - reach, apex + reach) if 0 < f < 1]
            ends.sort()
    cuts = [0.0]
    for a, b in pairwise(ends):
        count = max(1, math.ceil(abs(segment.sweep) * (b - a) / WIDEST_ARC))
        cuts += [a + (b - a) * (j + 1) / count for j in range(count)]
    return cuts


def _corner(before: Segment, after: Segment, sizes: Sizes) -> float:
    """Largest edge at a singular corner, mm; 0 for the sizes of its segments."""
    if (before.kind == "back") != (after.kind == "back"):
        return 0.0 if sizes.smooth and "cut" in (before.kind, after.kind) else sizes.corner
    if sizes.ramp and before.kind == after.kind and after.kind in ("back", "side"):
        return RAMP_EDGE / RAMP * sizes.ramp
    return sizes.tip if after.kind == "slot" else 0.0


def _size(segment: Segment, sizes: Sizes, shortest: float) -> float:
    """Largest edge on a segment, mm.

    A slot or strip is straight: its long sides take edges twice its thickness, its ends one edge.
    """
    if segment.kind == "slot":
        return max(2 * shortest, segment.length / 8, sizes.slot)
    if segment.touches:
        inside = max(abs(segment.start.x), abs(segment.end.x)) <= sizes.focus * (1 + SAME)
        return min(sizes.fine if inside else sizes.contact, segment.length / 2)
    if segment.kind in ("flank", "root_fillet"):
        return sizes.ridge
    return sizes.bulk


def _name(segment: Segment, domains: tuple[int, int]) -> str:
    if domains[0] == FILM:
        return "inside"
    if segment.kind in ("back", "cut"):
        return segment.kind
    return f"contact{segment.feature}" if segment.touches and domains[0] == SKIN else "free"


SAME = 1e-9  # of the outline's extent; mirrored points agree to that


def half_of(pad: Pad) -> Pad | None:
    """Return the part of the pad at x >= 0, or None where it is not its own mirror image.

    A segment that crosses x = 0 is cut there, so a middle ridge is cut in half. A strip or void must lie on
    one side. The plate must be flat.
    """
    extent = max(abs(s.start.x) for s in pad.section.outline)
    inner = ([segment for loop in of for segment in loop] for of in (pad.strips, pad.voids))
    alike = (_mirrored(group, SAME * extent) for group in (list(pad.section.outline), *inner))
    if pad.plate.shape != "flat" or not all(alike):
        return None
    places = ([s.start.x for s in loop] for loop in (*pad.strips, *pad.voids))
    if any(min(x) < SAME * extent and max(x) > -SAME * extent for x in places):  # across the middle
        return None
    outline = _cut(pad.section.outline, SAME * extent)
    if outline is None:
        return None

    strips, voids = (tuple(loop for loop in of if loop[0].start.x > 0) for of in (pad.strips, pad.voids))
    layers = tuple(replace(layer, face=_right_part(layer.face)) for layer in pad.layers)
    return replace(pad, section=Section(outline), strips=strips, voids=voids, layers=layers)


def _mirrored(segments: list[Segment], tolerance: float) -> bool:
    """Whether every segment's mirror image is there; mirroring and running backwards keeps the bulge."""
    if not segments:
        return True
    here = np.array([[*s.start, *s.end] for s in segments])
    image = np.array([[-s.end.x, s.end.z, -s.start.x, s.start.z] for s in segments])
    distance, partner = spatial.cKDTree(image).query(here, p=np.inf)
    return bool(distance.max() <= tolerance) and all(
        math.isclose(s.bulge, segments[j].bulge, rel_tol=1e-6, abs_tol=1e-9) and s.kind == segments[j].kind
        for s, j in zip(segments, partner, strict=True)
    )


def _cut(outline: Loop, tolerance: float) -> Loop | None:
    """The outline's part at x >= 0 in one piece, closed along x = 0; None where it is in several."""
    pieces: list[Segment] = []
    for s in outline:
        if s.start.x >= -tolerance and s.end.x >= -tolerance:
            pieces.append(s)
        elif s.start.x > tolerance or s.end.x > tolerance:
            pieces.append(_right_part(s))
    starts = [i for i, s in enumerate(pieces) if abs(s.start.x) <= tolerance]
    if len(starts) != 1:
        return None
    chain = [*pieces[starts[0] :], *pieces[: starts[0]]]
    first, last = chain[0].start, chain[-1].end
    chain[0] = replace(chain[0], start=Point(0.0, first.z))
    chain[-1] = replace(chain[-1], end=Point(0.0, last.z))
    return (*chain, Segment(Point(0.0, last.z), Point(0.0, first.z), kind="cut"))


def _right_part(segment: Segment) -> Segment:
    """A segment that crosses x = 0 once, without its part at x < 0."""
    at = float(optimize.brentq(lambda t: segment.point(t).x, 0.0, 1.0, xtol=1e-15))
    here = Point(0.0, segment.point(at).z)
    if segment.start.x > 0:
        return replace(segment, end=here, bulge=math.tan(segment.sweep * at / 4))
    return replace(segment, start=here, bulge=math.tan(segment.sweep * (1 - at) / 4))


@dataclass(frozen=True)
class PadPiece:
    """What is meshed of a pad: its half where `mirrored`, as always where the section turns about x = 0.

    `unit` is the piece's, mm: another one than the pad's where a middle ridge is cut, which no number in mm
    or N depends on. `mesh` is netgen's, None before there is one; `thickness` mm is the strips' in its slots.
    """

    whole: Pad
    pad: Pad
    mirrored: bool
    unit: float
    mesh: Any = None
    thickness: float = 0.0

    @property
    def sides(self) -> int:
        """How many times the piece makes up the pad."""
        return 2 if self.mirrored and not self.whole.revolved else 1

    @property
    def along(self) -> float:
        """The length for which a section counts, mm: along y, or of a turn by its own unit."""
        return self.unit if self.whole.revolved else self.whole.length

    @property
    def scale(self) -> float:
        """The force on the whole pad, N, for a force of 1 on the piece, in its units."""
        return self.whole.young_modulus * self.unit * self.along * self.sides

    @property
    def slots(self) -> tuple[SensorPlace, ...]:
        """The places of the piece's strips, mm."""
        slots = self.whole.section.slots
        return tuple(s for s in slots if s.centre.x > 0) if self.mirrored else slots

    def on_whole(self, shares: Array) -> Array:
        """Return each ridge's force `(ridges,)` from those of the piece's ridges, in N on the whole pad; of a
        mirrored half, the sides share what its ridges carry."""
        if self.sides == 1:
            return shares
        values = np.zeros(len(self.whole.ridges))
        for ridge, share in zip(self.pad.ridges, shares, strict=True):
            values[self.whole.ridges.index(ridge)] += share / 2
        return values + values[::-1]


def height_of(pad: Pad) -> float:
    """Return the height of the pad's corners over its lowest, mm."""
    heights = [s.start.z for s in pad.section.outline]
    return max(heights) - min(heights)


def piece_of(pad: Pad, thickness: float = 0.0, halved: bool = True) -> PadPiece:
    """Return what is to be meshed of a pad with strips of this thickness, mm, in its section's slots: the
    half of a mirror-symmetric one, unless `halved` says otherwise. Raises InputError for a section that can't
    turn about x = 0 and should."""
    half = half_of(pad) if halved or pad.revolved else None
    if half is None and pad.revolved:
        raise InputError("section", "must be its own mirror image at x = 0, about which it turns")
    piece = half or pad
    return PadPiece(pad, piece, half is not None, unit_of(piece), thickness=thickness)


def meshed_piece(pad: Pad, sizes: Sizes, *, whole: bool = False) -> PadPiece:
    """Return `piece_of` with its mesh, of all of the pad where asked."""
    piece = piece_of(pad, halved=not whole)
    return replace(piece, mesh=triangles(piece.pad, sizes))


@dataclass(frozen=True)
class MeshRefinement:
    """Orders `order - 1` and `order` on a mesh of a `fineness`, 1 the usual one.

    `price` is its time on top of the refinements before, as a multiple of the first one's; `usual` is the
    relative error that it usually reaches. A strip's corners get edges of `tip` of its thickness; `grading`
    is the growth of the triangles away from them.
    """

    fineness: float
    order: int
    price: float = 1.0
    usual: float = 0.0
    tip: float = 0.0
    grading: float = 0.3

    def sizes(self, piece: PadPiece) -> Sizes:
        """Return the mesh's edge sizes for a piece with strips."""
        usual = default_sizes(piece.pad, self.fineness)
        return replace(usual, tip=self.tip * piece.thickness, grading=self.grading)


def plane_piece(pad: Pad, fineness: float = 1.0, *, whole: bool = False) -> PadPiece:
    """Return `meshed_piece` in the default sizes of the plane; twice the fineness halves them all."""
    return meshed_piece(pad, replace(default_sizes(pad, fineness), smooth=True), whole=whole)


@dataclass(frozen=True, eq=False)
class PlainMesh:
    """Straight triangles of a section: `points` `(p, 2)` mm, `corners` `(t, 3)` of them, counterclockwise,
    `domain` `(t,)` SKIN, FILM, or FILM + a shot's number, and by boundary its `edges` `(e, 2)`."""

    points: Array
    corners: Index
    domain: Index
    edges: dict[str, Index]


def plain_mesh(pad: Pad, sizes: Sizes) -> PlainMesh:
    """Return the triangles of a pad's section in these sizes; boundaries are named as in `triangles`."""
    mesh = triangles(pad, sizes)
    points = np.array([[p[0], p[1]] for p in mesh.Points()]) * unit_of(pad)
    elements = list(mesh.Elements2D())
    corners = np.array([[v.nr - 1 for v in element.vertices[:3]] for element in elements], dtype=np.int64)
    domain = np.array([element.index for element in elements], dtype=np.int64)
    edges: dict[str, list[list[int]]] = {}
    for edge in mesh.Elements1D():
        ends = [v.nr - 1 for v in edge.vertices[:2]]
        edges.setdefault(mesh.GetBCName(edge.index - 1), []).append(ends)
    a, b, c = (points[corners[:, i]] for i in range(3))
    (ux, uz), (vx, vz) = (b - a).T, (c - a).T
    turned = ux * vz - uz * vx < 0
    corners[turned] = corners[turned][:, ::-1]
    return PlainMesh(points, corners, domain, {name: np.array(ends) for name, ends in edges.items()})


@dataclass(frozen=True, eq=False)
class SolidMesh:
    """Straight tetrahedra of solids that share their faces: `points` `(p, 3)` mm, `corners` `(t, 4)` of them,
    `domain` `(t,)` the place of the element's solid in the list, from 0, and of all faces the triangles
    `walls` `(f, 3)`, each of the kernel's `face` `(f,)`."""

    points: Array
    corners: Index
    domain: Index
    walls: Index
    face: Index


def solid_mesh(files: Sequence[Path], largest: float, near: Array, size: float) -> SolidMesh:
    """Return netgen's mesh of solids, a BREP file each, mm. Edges are up to `largest` mm long, at the places
    `near` `(n, 3)` mm up to `size`; neighbouring solids share nodes.

    Raises InputError where netgen finds no mesh.
    """
    shapes = []
    for number, file in enumerate(files):
        (shape,) = OCCGeometry(str(file)).shape.solids
        shape.name = str(number)
        shapes.append(shape)
    geometry = OCCGeometry(Glue(shapes) if len(shapes) > 1 else shapes[0])
    wishes = MeshingParameters(maxh=largest, grading=SOLID_GRADING, curvaturesafety=CURVATURE_SAFETY)
    for place in near.tolist():
        wishes.RestrictH(*place, size)
    try:
        mesh = geometry.GenerateMesh(wishes)
    except NgException as failure:
        if exhausted(failure):
            raise
        rule, remedy = f"netgen finds no mesh of the solid ({failure})", "leave the volume mesh out"
        raise InputError("skin", rule, remedy=remedy) from None
    cells, walls = mesh.Elements3D().NumPy(), mesh.Elements2D().NumPy()
    names = [int(mesh.GetMaterial(i + 1)) for i in range(int(cells["index"].max()))]
    return SolidMesh(
        points=np.array(mesh.Coordinates()),
        corners=cells["nodes"][:, :4].astype(np.int64) - 1,
        domain=np.array(names)[cells["index"] - 1],
        walls=walls["nodes"][:, :3].astype(np.int64) - 1,
        face=walls["index"].astype(np.int64),
    )
