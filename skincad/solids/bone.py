"""A bone: the user's own solid, a finger's or a mount, that a skin is cast on.

It stands in the skin from behind. What of it is behind the back goes through a window of the carrier, its
print, as wide as its shadow there and a clearance more; seal and cover have the same window. A bone that ends
at the back is screwed under the carrier, into holes of its own that open there. One that reaches through is
held over the cover: by a clamp or collar round it, or by a screw in its end and a bar across the window.
Silicone holds on it by a primer, or by filling holes of its own that no straight pull empties. Once it has
cured, the carrier comes off, and the bone is the skin's mount.

How thin silicone gets is measured in the skin's section. Of a skin that is straight along y the distance of a
bone to its outline, slots and ends is that of the bone's shadow along y, and of its reach along y; of a round
one it is that of the bone as turned about z, and of a doubly curved one as turned about the skin's own axis:
what counts in its section is a place's level, its height over the back. Range: the bone as its mesh within
`CHORD`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import combinations
from pathlib import Path
from stat import S_ISREG
from typing import Any

import numpy as np
import shapely
from scipy.spatial.transform import Rotation

from skincad.base.arrays import Array
from skincad.base.errors import InputError
from skincad.inputs.design import Design
from skincad.shape.curves import Loop, Point, loop, polygon
from skincad.shape.shots import face
from skincad.shape.skin import Section, section
from skincad.solids.fasteners import METRIC, thread_in
from skincad.solids.kind import kind_of
from skincad.solids.layout import EDGE, ends_rise
from skincad.solids.pins import pockets
from skincad.solids.plan import Bore, CutRole, ExtendedCut, GivenBody, Part, PartRole, Prism, moved

CHORD = 0.01  # mm, of the mesh that shadows are taken of
LEAST_SILICONE = 0.5  # mm, assumption: over a bone; a thinner wall tears, and bubbles show in it
BEHIND = 1e-4  # mm, behind the back: less is on it
BENT_SLACK = 3 * CHORD  # mm, of a bent back: the mesh has its arc in chords
SNAP = 1e-3  # mm, of the corners of a window over a bent back
LEAST_HOLES = 2  # that say how a bone stands on its carrier
LEAST_RIM = 0.1  # mm, assumption: of the bone's back round a hole into which a screw goes
CHAMFER, CHAMFER_STEP = 0.6, 0.05  # mm, assumption: of a hole; a deeper cone is a countersink
LEAST_GRIP = 1.5  # mm, assumption: of a bone over the cover, for a collar or a clamp's jaws
ROUND = 0.98  # of its circle, assumption: what fills that much can be turned in its window
LEAST_SHOULDER = 1.0  # mm2, assumption: on which it stands on the carrier
TURN_EDGE = 0.25  # mm, between slices of a triangle that is turned: a chord is 2 um off at 5 mm from the axis
FLAT = 1e-9  # mm, a triangle's height: it has no slices
PLAY = 0.02  # mm a side, assumption: of a screw's core in a bone's hole
SAME = 0.01  # mm, to which a hole opens at the back
KEY = "mold.bone"
DEEPEST = 100  # parentheses in each other, assumption: CAD programs write up to 6


@dataclass(frozen=True, eq=False)
class Bone:
    """A bone in its pose, in the design's frame, mm: its mesh's triangles `(f, 3, 3)`, the whole volume and
    that in front of the back, mm3, the radii, lowest places (x, y, z) and tops of round holes along z; and
    `undercut`, the necks of holes in front of the back that no straight pull along z empties: areas, mm2, and
    places of those along z. `levels` `(f, 3)` mm are its corners' heights over the back; less than `slack` mm
    is on it, as exact as the mesh is there."""

    body: GivenBody
    corners: Array
    levels: Array
    slack: float
    volume: float
    inside: float
    holes: tuple[tuple[float, tuple[float, float, float], float], ...]
    undercut: tuple[tuple[float, tuple[float, float] | None], ...] = ()

    @property
    def locks(self) -> tuple[float, ...]:
        """The necks in which silicone holds, mm2: not those of holes into which screws go."""
        screwed = {hole.start[:2] for hole in ([] if self.printed else self.pin_holes)}
        end = float(self.corners[:, :, 2].min())
        if self.printed:
            screwed = {(x, y) for _, (x, y, low), _ in self.holes if abs(low - end) < SAME}
        return tuple(area for area, spot in self.undercut if spot not in screwed)

    @property
    def printed(self) -> bool:
        """Whether it reaches behind the back."""
        return bool(self.levels.min() < -self.slack)

    @property
    def pin_holes(self) -> list[Bore]:
        """The two holes along z that open at the back, closed all round, take a thread and lie furthest
        apart: screws through the carrier hold in them. Fewer where there are fewer. Silicone fills the
        others."""
        back = self.shadow(2, -BEHIND, SAME)
        found = [
            Bore((x, y, 0.0), "z", high, radius, role=CutRole.CORE)
            for radius, (x, y, low), high in self.holes
            if abs(low) < SAME and high > 0 and thread_in(2 * radius) and _closed(back, x, y, radius)
        ]
        pairs = combinations(found, LEAST_HOLES)
        return list(max(pairs, key=lambda two: math.dist(two[0].start, two[1].start), default=found))

    @property
    def end_thread(self) -> str | None:
        """The thread of a hole along z in the end of a bone that reaches behind the back; None without."""
        end = float(self.corners[:, :, 2].min())
        return next((thread_in(2 * r) for r, (_, _, low), _ in self.holes if abs(low - end) < SAME), None)

    @property
    def rivets(self) -> list[Bore]:
        """The holes along z that silicone fills."""
        every = [
            Bore((x, y, low), "z", high - low, radius) for radius, (x, y, low), high in self.holes if high > 0
        ]
        pins = set() if self.printed else {hole.start[:2] for hole in self.pin_holes}
        return [hole for hole in every if hole.start[:2] not in pins]

    def shadow(self, across: int, low: float = -math.inf, high: float = math.inf) -> Any:
        """The shadow along the axis `across` (1: y, or what the skin turns along; 2: z) of what lies between
        two levels, mm: polygons of (x, level) or (x, y)."""
        return _shadow(self, across, low, high)

    def in_section(self, *, turned: bool) -> Any:
        """What of it is in front of the back, in the skin's section: polygons of (x, z), of its shadow along
        y or, `turned` about z, of the distance from the axis and z."""
        return _turned_shadow(self) if turned else self.shadow(1, 0.0)


def _closed(back: Any, x: float, y: float, radius: float) -> bool:
    """Whether a hole has the bone's back all round it, beyond a chamfer."""
    middle = shapely.Point(x, y)
    rims = [radius, *np.arange(radius + CHAMFER_STEP, radius + CHAMFER + CHORD, CHAMFER_STEP).tolist()]
    rings = (middle.buffer(rim + LEAST_RIM).difference(middle.buffer(rim + CHORD)) for rim in rims)
    return any(back.buffer(CHORD / 10).contains(ring) for ring in rings)


@lru_cache(maxsize=32)
def _turned_shadow(bone: Bone) -> Any:
    """Slices of a triangle at equal z are segments: their least and largest distances from the axis are the
    two sides of what it sweeps."""
    faces: list[Any] = []
    for triangle in bone.corners[bone.corners[:, :, 2].max(axis=1) > 0.0]:
        low, middle, high = triangle[np.argsort(triangle[:, 2])]
        if high[2] - low[2] < FLAT:
            outline = shapely.Polygon(triangle[:, :2])
            near = shapely.distance(outline, shapely.Point(0.0, 0.0))
            ends = [(near, high[2]), (np.hypot(triangle[:, 0], triangle[:, 1]).max(), high[2])]
            faces.append(shapely.LineString(ends))
            continue
        cut = low + (middle[2] - low[2]) / (high[2] - low[2]) * (high - low)
        longest = np.linalg.norm(triangle - np.roll(triangle, 1, axis=0), axis=1).max()
        steps = max(1, math.ceil(longest / TURN_EDGE))
        for tip in (low, high):
            if max(tip[2], middle[2]) > 0.0 and abs(middle[2] - tip[2]) > FLAT:
                faces.append(_swept(tip, middle, cut, steps))
    return shapely.union_all(shapely.buffer(faces, 1e-9, join_style="bevel", cap_style="flat"))


def _swept(tip: Array, left: Array, right: Array, steps: int) -> shapely.Polygon:
    """What a triangle sweeps about z above the back, a polygon of (distance from the axis, z): `left` and
    `right` are equally high."""
    onset = tip[2] / (tip[2] - left[2])  # where it is at the back
    shares = np.linspace(onset if tip[2] < 0.0 else 0.0, onset if left[2] < 0.0 else 1.0, steps + 1)[:, None]
    one, other = (tip + shares * (end - tip) for end in (left, right))
    across = other[:, :2] - one[:, :2]
    squares = (across**2).sum(axis=1)
    foot = -(one[:, :2] * across).sum(axis=1) / np.where(squares > 0.0, squares, 1.0)
    nearest = one[:, :2] + np.clip(foot, 0.0, 1.0)[:, None] * across
    far = np.maximum(*(np.hypot(side[:, 0], side[:, 1]) for side in (one, other)))
    sides = [np.hypot(nearest[:, 0], nearest[:, 1]), far[::-1]]
    return shapely.Polygon(
        np.column_stack([np.concatenate(sides), np.concatenate([one[:, 2], one[::-1, 2]])])
    )


@lru_cache(maxsize=32)
def _shadow(bone: Bone, across: int, low: float, high: float) -> Any:
    shown = [0, 3] if across == 1 else [0, 1]
    kept = (_between(triangle, low, high) for triangle in np.dstack([bone.corners, bone.levels]))
    faces = [shapely.Polygon(piece[:, shown]) for piece in kept if len(piece) > 2]
    return shapely.union_all([face.buffer(1e-9) for face in faces if face.area > 0])


def _between(triangle: Array, low: float, high: float) -> Array:
    """A triangle's part between two levels, its last column, `(n, 4)`."""
    points = triangle
    for level, sign in ((low, 1.0), (high, -1.0)):
        if not math.isfinite(level) or not len(points):
            continue
        kept, over = [], sign * (points[:, -1] - level)
        for i in range(len(points)):
            j = (i + 1) % len(points)
            if over[i] >= 0:
                kept.append(points[i])
            if over[i] * over[j] < 0:
                share = over[i] / (over[i] - over[j])
                kept.append(points[i] + share * (points[j] - points[i]))
        points = np.array(kept).reshape(-1, 4)
    return points


def bone_of(design: Design) -> Bone | None:
    """Return a design's bone; None without one. Raises InputError for a file that holds no one solid."""
    name = design.mold.bone
    if name is None:
        return None
    path = Path(name)
    try:
        stamp = path.stat()
    except OSError:
        raise InputError(KEY, "there is no such file", name, "give the path of a STEP file") from None
    if not S_ISREG(stamp.st_mode):  # a pipe would be waited for
        raise InputError(KEY, "is not a regular file", name, "give the path of a STEP file")
    at, turn = design.mold.bone_at or (0.0, 0.0, 0.0), design.mold.bone_turn or (0.0, 0.0, 0.0)
    return _bone(str(path), stamp.st_mtime_ns, stamp.st_size, at, turn, design.skin.back_radius)


Place = tuple[float, float, float]


@lru_cache(maxsize=4)
def _bone(path: str, changed: int, size: int, at: Place, turn: Place, arm: float) -> Bone:
    from skincad.solids.occ import given_solid, holes_of, locks_of, volume_in_front

    if (depth := _depth(path)) > DEEPEST:
        raise InputError(KEY, f"must not nest more than {DEEPEST} deep", depth, "export it again")
    body = GivenBody(path, _pose(at, turn), 0.0, (changed, size))
    shape = given_solid(body, KEY)
    whole, corners = float(shape.Volume()), _corners(body)
    if bent := math.isfinite(arm):
        corners = _divided(corners, math.sqrt(8 * CHORD * arm))
    y, z = corners[:, :, 1], corners[:, :, 2]
    return Bone(
        body=replace(body, volume=whole),
        corners=corners,
        levels=np.where(z + arm > 0, z + y**2 / (arm + z + np.hypot(y, arm + z)), z),
        slack=BENT_SLACK if bent else BEHIND,
        volume=whole,
        inside=volume_in_front(shape, arm),
        holes=holes_of(shape, CHAMFER),
        undercut=locks_of(shape),
    )


def _divided(triangles: Array, longest: float) -> Array:
    """Triangles whose edges are no longer than that, mm: each longer one in four."""
    done = list[Array]()
    while len(triangles):
        edges = np.linalg.norm(triangles - np.roll(triangles, -1, axis=1), axis=2).max(axis=1)
        done.append(triangles[edges <= longest])
        a, b, c = np.moveaxis(triangles[edges > longest], 1, 0)
        d, e, f = (a + b) / 2, (b + c) / 2, (c + a) / 2
        four = ((a, d, f), (d, b, e), (f, e, c), (d, e, f))
        triangles = np.concatenate([np.stack(corners, axis=1) for corners in four])
    return np.concatenate(done)


def _depth(path: str) -> int:
    """How deep a file's parentheses lie in each other: the kernel's reader recurs with them."""
    letters = np.frombuffer(Path(path).read_bytes(), dtype=np.uint8)
    steps = (letters == ord("(")).astype(np.int32) - (letters == ord(")"))
    return int(np.cumsum(steps, dtype=np.int32).max(initial=0))


@lru_cache(maxsize=8)
def _corners(body: GivenBody) -> Array:
    """The corners of a body's triangles, `(f, 3, 3)` mm."""
    from skincad.solids.occ import given_solid, tessellate, triangles

    shape = given_solid(body, KEY)
    tessellate(shape, CHORD)
    corners, faces = triangles(shape, CHORD)
    return np.asarray(np.array([corner.toTuple() for corner in corners])[np.array(faces)])


def lifted(part: Part, travel: float) -> Part:
    """Return a column that covers what a given part passes through on its way up, `travel` mm."""
    if not isinstance(part.body, GivenBody):
        raise ValueError(f"{part.name} is no given body")
    points = _corners(part.body).reshape(-1, 3)
    hull = shapely.MultiPoint(points[:, :2]).convex_hull.exterior.coords[:-1]
    outline = shapely.Polygon(hull)
    corners = [Point(x, y) for x, y in hull]
    ring = loop(corners if outline.exterior.is_ccw else corners[::-1])
    low, high = float(points[:, 2].min()), float(points[:, 2].max())
    return replace(part, body=Prism(ring, "z", low + min(travel, 0.0), high + max(travel, 0.0)))


def _pose(at: Place, turn: Place) -> tuple[float, ...]:
    """Rotation and shift, `(3, 4)` by rows."""
    rotation = Rotation.from_euler("xyz", turn, degrees=True).as_matrix()
    return tuple(np.column_stack([rotation, at]).ravel().tolist())


def cut_of(design: Design, up: float = 1.0) -> tuple[GivenBody | ExtendedCut, ...]:
    """Return what a bone takes from the skin, and the pins in its holes, ridges up, or down where `up` is -1;
    nothing without one."""
    bone = bone_of(design)
    if bone is None:
        return ()
    filled = [
        replace(bore, start=(bore.start[0], up * bore.start[1], min(0.0, up * bore.length)))
        for bore in ([] if bone.printed else bone.pin_holes)
    ]
    # built into the bone, which is cut away too: faces that are the same would leave a film
    pins = (ExtendedCut(bore, replace(bore, radius=bore.radius + PLAY)) for bore in filled)
    return (replace(_turned(bone.body, up), volume=bone.inside), *pins)


def _turned(body: GivenBody, up: float) -> GivenBody:
    """A body of the design's frame in it, or in the mold's, about x."""
    if up > 0:
        return body
    pose = np.array(body.pose).reshape(3, 4) * np.array([[1.0], [-1.0], [-1.0]])
    return replace(body, pose=tuple(pose.ravel().tolist()))


def bone_parts(design: Design) -> list[Part]:
    """Return the bone as a part of the mold; none without one."""
    bone = bone_of(design)
    return [] if bone is None else [Part("bone", PartRole.BONE, _turned(bone.body, -1.0))]


def window(design: Design, low: float, gap: float) -> list[Loop]:
    """Return the loops, in the mold's (x, y), of the opening for a bone's print in a part that begins `low`
    mm above the back, `gap` mm wider than it; none where the bone does not reach that. Over a bent back it is
    the carrier's in all parts."""
    bone = bone_of(design)
    if bone is None or bone.corners[:, :, 2].min() > -low - BEHIND:
        return []
    leans = kind_of(design).leans
    low = 0.0 if leans else low
    shadow = bone.shadow(2, -math.inf, -low - bone.slack)  # it leaves upward, through all that is behind it
    region = shapely.buffer(shadow, gap + (SNAP if leans else 1e-6), quad_segs=4).simplify(CHORD / 4)
    if leans:  # a plane that crosses an arc's axis askew by 1e-5 rad is one across it to the kernel, or none
        region = shapely.set_precision(region, SNAP)
    return [_loop(piece) for piece in getattr(region, "geoms", [region]) if not piece.is_empty]


def _loop(piece: shapely.Polygon) -> Loop:
    """A polygon's outline without its holes, counterclockwise, upside down as the mold has it."""
    points = [Point(x, -y) for x, y in piece.exterior.coords[:-1]]
    outline = shapely.Polygon(points)
    return loop(points if outline.exterior.is_ccw else points[::-1])


def windowed(part: Part, design: Design, low: float, high: float, centres: Sequence[float] = (0.0,)) -> Part:
    """Return a lid with the window of a bone's print, over each of the skins at `centres` mm along x."""
    gap = design.mold.clearance
    holes = [Prism(w, "z", low, high, role=CutRole.WINDOW) for w in window(design, low, gap)]
    holes = [moved(hole, x) for x in centres for hole in holes]
    return replace(part, cuts=(*part.cuts, *holes)) if holes else part


def clear_of(design: Design, low: float, at: tuple[float, float], radius: float) -> bool:
    """Whether a bore keeps its web to a bone's window, in a part that begins `low` mm above the back."""
    return all(
        shapely.Polygon(polygon(w, CHORD)).distance(shapely.Point(at)) >= radius + EDGE / 2
        for w in window(design, low, design.mold.clearance)
    )


def pinned(design: Design) -> list[Bore]:
    """Return the cores of the screws that hold a bone that ends at the back, in the mold's frame; none of a
    bone that reaches through the carrier."""
    bone = bone_of(design)
    if bone is None or bone.printed:
        return []
    return [
        replace(b, start=(b.start[0], -b.start[1], -b.length), radius=b.radius - PLAY) for b in bone.pin_holes
    ]


def check_bone(design: Design) -> Iterator[InputError]:
    """Yield an error for each thing that is wrong with a bone and its pose; none without one."""
    bone, skin, choice = bone_of(design), design.skin, design.mold
    if bone is None:
        return
    for key, value in (
        ("mold.mount", choice.mount),
        ("mount", "a table" if design.mount else None),
    ):
        if value is not None:
            remedy = "the bone is the mount" if "mount" in key else "drop mold.bone"
            yield InputError(key, "must not be given with mold.bone", value, remedy)
            return
    shape = section(design)
    yield from _check_pose(design, bone, shape)
    yield from _check_pockets(design, bone)
    if not bone.printed and kind_of(design).leans:
        rule = "ends at the back, which is bent along y: screws along z would not seat it square"
        yield InputError(KEY, rule, choice.bone, "let it reach behind the back, through the carrier")
    elif not bone.printed and len(bone.pin_holes) < LEAST_HOLES:
        many = len(bone.pin_holes)
        holes = f"{many} hole{'s' * (many != 1)}"
        rule = (
            f"ends at the back, and has {holes} along z that open there, closed all round, to be tapped for"
        )
        rule += " a screw that holds it"
        drills = ", ".join(f"{metric.drill:g} for {name}" for name, metric in METRIC.items())
        remedy = f"give it {LEAST_HOLES} or more ({drills}), or let it reach behind the back"
        yield InputError(KEY, rule, choice.bone, remedy)
    if bone.printed:
        through = bone.shadow(2, -math.inf, -bone.slack).buffer(choice.clearance)
        lies = bone.shadow(2, -bone.slack, max(SAME, bone.slack)).difference(through)
        over = bone.shadow(2, max(SAME, bone.slack), LEAST_SILICONE).difference(through).difference(lies)
        if kind_of(design).leans and over.area > lies.area:
            rule = f"stands on the bent back by {lies.area:.3g} mm2, and leaves a wedge under {over.area:.3g}"
            remedy = f"give its shoulder the back's radius, {skin.back_radius:g} mm, about an axis along x"
            yield InputError(KEY, rule, choice.bone, remedy)
        elif lies.area < LEAST_SHOULDER:
            rule = "has no shoulder at the back, z = 0: nothing stops it in the carrier's window"
            yield InputError(
                KEY, rule, choice.bone, "give it one that lies on the carrier, or move it along z"
            )
    if choice.bone_bond == "rivets" and not bone.rivets and not bone.locks:
        rule = "'rivets' need a round hole of the bone that silicone fills, and it has none"
        yield InputError("mold.bone_bond", rule, "rivets", "take 'primer', or drill the bone")


def check_hold(design: Design, top: float) -> None:
    """Raise InputError where nothing holds a bone that reaches through its carrier, while silicone cures, or
    keeps it from turning; `top` is the cover's upper face above the back, mm."""
    bone = bone_of(design)
    if bone is None or not bone.printed:
        return
    out = -float(bone.corners[:, :, 2].min()) - top
    if out < LEAST_GRIP and bone.end_thread is None:
        rule = (
            f"ends {abs(out):.3g} mm {'over' if out > 0 else 'under'} the cover's top, where a clamp needs "
        )
        rule += f"{LEAST_GRIP:g} of it, and has no hole in its end for a screw: nothing would hold it"
        longer = math.ceil(10 * (LEAST_GRIP - out)) / 10
        remedy = f"make it {longer:g} mm longer behind, or drill its end, {METRIC['M3'].drill:g} for M3"
        raise InputError(KEY, rule, design.mold.bone, remedy)
    shadow = bone.shadow(2, -math.inf, -BEHIND)
    circle = math.pi * shapely.minimum_bounding_radius(shadow) ** 2
    filled = sum(shapely.Polygon(piece.exterior).area for piece in getattr(shadow, "geoms", [shadow]))
    turns = design.features.family in ("ring", "flat") and not pockets(design)
    alike = turns and not kind_of(design).ends
    if filled > ROUND * circle and not alike:
        rule = "is round where it passes the carrier, and turns in its window"
        raise InputError(KEY, rule, design.mold.bone, "give it a flat there")


def _check_pose(design: Design, bone: Bone, shape: Section) -> Iterator[InputError]:
    """Where a bone stands in the skin, and how thin the silicone gets round it."""
    half, long = (
        design.skin.width / 2,
        design.skin.length / 2 * (1 - design.skin.thickness / design.skin.radius_y),
    )
    low, high = bone.corners.reshape(-1, 3).min(axis=0), bone.corners.reshape(-1, 3).max(axis=0)
    at = design.mold.bone_at or (0.0, 0.0, 0.0)
    if high[2] <= LEAST_SILICONE or bone.inside <= 0.0:
        rule = f"puts the bone's top at {high[2]:.4g} mm above the back: it must be in the skin"
        yield InputError("mold.bone_at", rule, list(at), "raise it along z; the file counts in mm")
        return
    kind = kind_of(design)
    within = bone.in_section(turned=not kind.ends)
    front = bone.corners[bone.levels.max(axis=1) > 0.0].reshape(-1, 3)
    ends = _arcs(front, design.skin.back_radius)
    beside = long - float(np.abs(ends).max()) if kind.ends else math.inf
    outline = shapely.Polygon(polygon(shape.outline, CHORD / 10))
    body = shapely.Polygon([(-half, -1e3), (half, -1e3), *_over(design, half)])
    if not outline.buffer(1e-6).contains(within) or beside < 0:
        reach = f"{low.round(2).tolist()} to {high.round(2).tolist()}"
        rule = f"puts the bone outside the skin: it reaches from {reach}"
        yield InputError("mold.bone_at", rule, list(at), "move it, or take a larger skin")
        return
    if not body.contains(within.buffer(LEAST_SILICONE - 1e-6).intersection(shapely.box(-half, 0, half, 1e3))):
        place = within.difference(body.buffer(-LEAST_SILICONE)).centroid
        rule = f"leaves a feature no base: at x = {place.x:.3g} mm the bone ends less than "
        rule += f"{LEAST_SILICONE:g} mm under the base circle"
        yield InputError("mold.bone_at", rule, list(at), "lower it along z, or take a thicker skin")
        return
    edge = shapely.LineString([*_from_corner(outline)])
    slots = [shapely.Polygon(polygon(slot.loop(), CHORD / 10)) for slot in shape.slots]
    thin = min([beside, within.distance(edge), *(within.distance(slot) for slot in slots)])
    if design.shot:
        line = polygon(face(design, 1, half), CHORD / 10)
        thin = min(thin, within.distance(shapely.LineString([*line.tolist(), (-half, line[0][1])])))
    if thin < LEAST_SILICONE - 1e-6:
        rule = f"leaves {thin:.3g} mm of silicone round the bone, and needs {LEAST_SILICONE:g}"
        yield InputError("mold.bone_at", rule, list(at), "move it, or take a larger skin or a thicker layer")


def _arcs(points: Array, arm: float) -> Array:
    """Places along y, `(n,)` mm: of a bent back along its arc."""
    if math.isinf(arm):
        return points[:, 1]
    return np.asarray(arm * np.arctan2(points[:, 1], arm + points[:, 2]))


def _check_pockets(design: Design, bone: Bone) -> Iterator[InputError]:
    """A pocket that runs into a bone, or leaves too little silicone beside it."""
    for pocket in pockets(design):
        x, y, _ = pocket.start
        low = bone.shadow(2, -math.inf, pocket.length + ends_rise(design) + LEAST_SILICONE)
        beside = low.distance(shapely.Point(x, y)) - pocket.radius if not low.is_empty else math.inf
        if beside < LEAST_SILICONE:
            rule = f"leaves {max(beside, 0.0):.3g} mm of silicone beside the bone at ({x:.4g}, {y:.4g}), and "
            rule += f"needs {LEAST_SILICONE:g}"
            yield InputError(
                f"{design.features.family}.pocket", rule, remedy="leave it out, or move the bone"
            )
            return


def _over(design: Design, half: float) -> list[tuple[float, float]]:
    """The base circle from +x to -x, mm."""
    radius = design.skin.curvature_radius
    turn = np.linspace(1.0, -1.0, 201) * math.asin(half / radius)
    top = design.skin.thickness - 2 * radius * np.sin(turn / 2) ** 2
    return list(zip((radius * np.sin(turn)).tolist(), top.tolist(), strict=True))


def _from_corner(outline: shapely.Polygon) -> Iterator[tuple[float, float]]:
    """The outline without its back, from one of the back's corners to the other."""
    points = [(x, z) for x, z in outline.exterior.coords[:-1]]
    first = max(range(len(points)), key=lambda i: (abs(points[i][1]) < 1e-9, points[i][0]))
    ring = points[first:] + points[:first]
    yield from (ring if ring[1][1] > 1e-9 else [ring[0], *reversed(ring[1:])])


def least_over(design: Design) -> float:
    """Return the bone's highest place above the back, mm; 0 without one."""
    bone = bone_of(design)
    return 0.0 if bone is None else float(bone.levels.max())
