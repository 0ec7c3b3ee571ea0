"""The mount in a carrier's top: where its threads, its pin's hole and its fiducials lie, and if they fit.

x and y count from the carrier's middle, as the mold's do; a robot sees the carrier's top as the cover does.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import combinations

import numpy as np

from skincad.base.errors import InputError
from skincad.inputs.design import Design
from skincad.inputs.mount_table import Mount
from skincad.solids.body import Bore, Vector
from skincad.solids.layout import EDGE, Layout, lid_process
from skincad.solids.plan import drilled
from skincad.solids.roles import CutRole
from skincad.solids.threads import blind_thread, pin_depth

SCREWS = 4  # source: ISO 9409-1, on the smaller of its bolt circles
STEP = 0.1  # mm, assumption: by which a fiducial goes aside where its corner is taken
TENTHS = 10  # a mm, assumption: a fiducial's place is written in tenths
# assumption: a fiducial's distance from the middle is at least its corner's by this
INSET_DIVISOR = 3.0

Filled = tuple[str, Vector, float]  # what silicone fills: its name, place and radius, mm


def mount_places(mount: Mount) -> list[tuple[float, float]]:
    """Return (x, y) of a mount's screws, mm: round the circle from its first one, or the rectangle's."""
    if mount.thread is None:
        return []
    if mount.diameter is not None:
        count = mount.count or SCREWS
        first = 180.0 / count if mount.angle is None else mount.angle
        turns = [math.radians(first + 360.0 * i / count) for i in range(count)]
        return [(mount.diameter / 2 * math.cos(a), mount.diameter / 2 * math.sin(a)) for a in turns]
    xs, ys = ((0.0,) if wide is None else (-wide / 2, wide / 2) for wide in (mount.pitch_x, mount.pitch_y))
    return [(x, y) for x in xs for y in ys]


def pin_place(mount: Mount) -> tuple[float, float]:
    """Return (x, y) of a mount's pin, mm: on its circle or its rectangle at +x, or between two in line."""
    side = mount.pitch_x if mount.pitch_y is not None else None
    return (mount.diameter or side or 0.0) / 2, 0.0


def mount_bores(design: Design, place: Layout) -> list[Bore]:
    """Return the threads and the pin's hole in the carrier's top; none without a mount."""
    mount = design.mount
    if mount is None or mount.thread is None:
        return []
    blind, top = blind_thread(mount.thread, lid_process(design)), place.back
    low = top - blind.depth
    holes = drilled(CutRole.MOUNT, "z", mount_places(mount), low, blind.depth, blind.radius)
    if mount.pin is None:
        return holes
    deep = pin_depth(mount.pin)
    return [*holes, *drilled(CutRole.MOUNT_PIN, "z", [pin_place(mount)], top - deep, deep, mount.pin / 2)]


def check_mount(design: Design, place: Layout, holes: Sequence[Bore], filled: Iterable[Filled]) -> None:
    """Raise InputError for the first hole of a mount that leaves the carrier or comes too near to another, or
    to what silicone fills."""
    if design.mount is None:
        return
    for hole in holes:
        _inside(design, place, hole)
        for name, at, radius in filled:
            web, least = math.dist(hole.start[:2], at[:2]) - hole.radius - radius, EDGE / 2
            if web < least:
                raise _near(design.mount, hole, web, least, name)
    for one, other in combinations(holes, 2):
        web = math.dist(one.start[:2], other.start[:2]) - one.radius - other.radius
        if web < EDGE:
            raise _near(design.mount, other, web, EDGE, _name(one))


def _inside(design: Design, place: Layout, hole: Bore) -> None:
    """Raise InputError for a hole that is too near to the carrier's edge."""
    mount = design.mount or Mount()
    room = [half - EDGE - hole.radius for half in _halves(design, place)]
    share = [most / abs(v) if v else math.inf for most, v in zip(room, hole.start[:2], strict=True)]
    if min(share) >= 1:
        return
    key = size_key(mount, 1 if share[1] < share[0] else 0)
    size = getattr(mount, key)
    rule = f"leaves less than {EDGE:g} mm between {_name(hole)} and the carrier's edge"
    if (most := math.floor(1000 * min(share) * size) / 1000) > 0:
        rule = f"must be at most {most:g} mm, for {EDGE:g} mm between {_name(hole)} and the carrier's edge"
    raise InputError(f"mount.{key}", rule, size, "take a smaller pattern or a larger skin")


def _near(mount: Mount, hole: Bore, web: float, least: float, other: str) -> InputError:
    x, y = hole.start[:2]
    key = "pin" if hole.role is CutRole.MOUNT_PIN else size_key(mount, 1)
    rule = (
        f"puts {_name(hole)} at ({x:.4g}, {y:.4g}) {max(web, 0.0):.3g} mm from {other}, needed are {least:g}"
    )
    turn = " (mount.angle)" if mount.pattern == "circle" else ""
    return InputError(f"mount.{key}", rule, getattr(mount, key), f"take another pattern{turn} or thread")


def _name(hole: Bore) -> str:
    return "the pin's hole" if hole.role is CutRole.MOUNT_PIN else "a thread"


def size_key(mount: Mount, axis: int = 0) -> str:
    """Return the key that gives a pattern's size along x (0) or y (1)."""
    if mount.pattern == "circle":
        return "diameter"
    wanted = ("pitch_x", "pitch_y") if axis == 0 else ("pitch_y", "pitch_x")
    return next(key for key in wanted if getattr(mount, key) is not None)


def _halves(design: Design, place: Layout) -> tuple[float, float]:
    """Half of the carrier's width and length, mm."""
    return place.trough - design.mold.clearance, place.end - design.mold.clearance


def fiducial_bores(design: Design, place: Layout, occupied: Sequence[tuple[Vector, float]]) -> list[Bore]:
    """Return the dimples in three of the carrier's corners, and a fourth between two of them, each as near
    to its corner as it clears what is `taken`, by place and radius. Raises InputError where one finds no
    room."""
    mount = design.mount
    if mount is None or not mount.fiducials:
        return []
    wide, deep = mount.fiducial_diameter / 2, mount.fiducial_depth
    x, y = (math.floor(TENTHS * (half - EDGE - wide)) / TENTHS for half in _halves(design, place))
    places: list[tuple[float, float]] = []
    for corner in ((x, -y), (-x, -y), (-x, y), (-math.floor(TENTHS * x / 3) / TENTHS, -y))[: mount.fiducials]:
        beside = [*occupied, *(((*at, 0.0), wide + EDGE) for at in places)]
        free = (at for at in _inward(corner) if all(_clear(at, wide, *other) for other in beside))
        if min(x, y) <= 0 or (at := next(free, None)) is None:
            rule = f"finds no room for a dimple of {mount.fiducial_diameter:g} mm in a corner of the carrier"
            remedy = "take a smaller mount.fiducial_diameter, another pattern or a larger skin"
            raise InputError("mount.fiducials", rule, mount.fiducials, remedy)
        places.append(at)
    return drilled(CutRole.FIDUCIAL, "z", places, place.back - deep, deep, wide)


def _inward(corner: tuple[float, float]) -> Iterator[tuple[float, float]]:
    """Places from a corner towards the middle, along y first, to its distance by `INSET_DIVISOR` at least."""
    x, y = corner
    for u in np.arange(abs(x), abs(x) / INSET_DIVISOR - STEP, -STEP).tolist():
        for v in np.arange(abs(y), abs(y) / INSET_DIVISOR, -STEP).tolist():
            yield math.copysign(round(u, 6), x), math.copysign(round(v, 6), y)


def _clear(at: tuple[float, float], wide: float, other: Vector, radius: float) -> bool:
    return math.dist(at, other[:2]) >= wide + radius + EDGE / 2
