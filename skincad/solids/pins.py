"""Pins and pockets as bodies: what of a skin turns about axes of its own.

A pin's loop is its feature's outline from the foot to the summit, closed along its axis. On a plane base it
ends at its foot. On a curved base it goes on as a cylinder into the base, and fills what the base falls away
under its foot; the part of the cylinder inside the base doesn't count.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np

from skincad.base.arrays import Array
from skincad.inputs.design import Design
from skincad.inputs.feature_tables import Pin, Pocket, places
from skincad.inputs.guards import CAP
from skincad.inputs.skin_tables import Base
from skincad.shape.curves import Loop, Point, Segment, flipped
from skincad.shape.feature import Feature, Placed
from skincad.shape.shots import heights
from skincad.shape.skin import Section, Skin, skin_of, upright
from skincad.solids.kind import kind_of
from skincad.solids.plan import Bore, CutRole, ExtendedCut, TurnedBody, shifted
from skincad.solids.shrinkage import on_grid

SUNK = 0.2  # mm, by which a pin's cylinder goes at least into a curved base
# mm, source: makers' lists, small disc and rod magnets: lengths by diameter
MAGNETS = {
    1.0: (1.0, 2.0),
    1.5: (0.5, 1.0, 1.5),
    2.0: (1.0, 2.0, 4.0),
    3.0: (1.0, 2.0, 3.0, 4.0, 6.0),
    4.0: (1.0, 2.0, 3.0, 4.0, 5.0),
    5.0: (1.0, 2.0, 3.0, 5.0),
    6.0: (1.0, 2.0, 3.0, 5.0, 6.0),
    8.0: (1.0, 2.0, 3.0, 5.0, 8.0),
    10.0: (1.0, 2.0, 3.0, 5.0, 10.0),
}
SQUEEZE = 0.1, 0.2  # mm, assumption: by which a pocket is narrower than its magnet, so that it holds it
MAGNET_PLAY = 0.1  # mm, assumption: of a magnet in the carrier's hole through which it goes in
_GAUSS, _TURN = np.polynomial.legendre.leggauss(12), 32  # of the quadrature over a pocket
_TURNS, _RINGS = 16, np.polynomial.legendre.leggauss(8)  # of the quadrature over a foot; smooth, so exact
_STEPS, _STILL = 60, 1e-14  # of the way down to the base; mm


def magnet_diameter(pocket: Pocket) -> float | None:
    """Return the diameter of the magnets that a pocket squeezes, mm: of the named ones, or else of what is
    sold; None where none is."""
    if pocket.magnet is not None:
        return pocket.magnet.diameter
    low, high = SQUEEZE
    return next((wide for wide in MAGNETS if low - 1e-9 <= wide - pocket.diameter <= high + 1e-9), None)


def magnet_of(design: Design) -> tuple[float, float] | None:
    """Return diameter and length of the magnet in a design's pockets, mm: the named one, or else the longest
    that is sold and that they hold by their squeeze; None where none fits, and without pockets."""
    pocket = design.features.pocket
    if pocket is not None and pocket.magnet is not None:
        return pocket.magnet.diameter, pocket.magnet.length
    if pocket is None or (wide := magnet_diameter(pocket)) is None:
        return None
    long = [each for each in MAGNETS[wide] if each <= pocket.depth - CAP + 1e-9]
    return (wide, long[-1]) if long else None


def pins(design: Design, shape: Section) -> tuple[TurnedBody, ...]:
    """Return the design's pins on its base, whose section is `shape`; none of another family."""
    skin = skin_of(design)
    if not skin.standing:
        return ()
    base = next(s for s in shape.outline if s.kind == "base")
    if on_plane(design, shape):
        level = base.start.z
        return tuple(
            TurnedBody(_loop(p.feature, 0.0), (p.foot[0], p.foot[1], level), (0.0, 0.0, 1.0))
            for p in skin.placed
        )
    foot = np.array([p.feature.feet[0].x for p in skin.placed])
    filled, deepest = _filled(design.skin, skin, foot)
    deep = deepest + SUNK
    buried = math.pi * foot**2 * deep - filled
    return tuple(
        TurnedBody(_loop(p.feature, deep), p.foot, p.axis, float(b))
        for p, b in zip(skin.placed, buried, strict=True)
    )


def on_plane(design: Design, shape: Section) -> bool:
    """Whether the base, whose section is `shape`, is plane."""
    flat = all(s.bulge == 0.0 for s in shape.outline if s.kind == "base")
    return flat and not kind_of(design).leans


def flank_end(pins: Iterable[TurnedBody]) -> float:
    """Return how far the flank of the shortest pin reaches along its axis, mm."""
    return min(max(s.end.z for s in pin.outline if s.bulge == 0.0 and s.end.x > 0.0) for pin in pins)


def parted(pin: TurnedBody, level: float) -> tuple[TurnedBody, TurnedBody]:
    """Return what of a pin on a plane base lies up to `level` mm on its axis, on its flank, and what beyond,
    the latter from that plane on."""
    i = next(i for i, s in enumerate(pin.outline) if s.end.z >= level)
    flank = pin.outline[i]
    share = (level - flank.start.z) / (flank.end.z - flank.start.z)
    edge, middle = Point(flank.start.x + share * (flank.end.x - flank.start.x), level), Point(0.0, level)
    down, foot = pin.outline[-2:]
    below = (
        *pin.outline[:i],
        replace(flank, end=edge),
        Segment(edge, middle),
        Segment(middle, down.end),
        foot,
    )
    rest = () if flank.end.z == level else (replace(flank, start=edge),)
    tip = (*rest, *pin.outline[i + 1 : -2], Segment(down.start, middle), Segment(middle, edge))
    (x, y, z), up = pin.origin, pin.direction[2]
    whole = replace(pin, role=None)
    return (
        replace(pin, outline=below, piece_of=whole),
        replace(pin, outline=shifted(tip, 0.0, -level), origin=(x, y, z + up * level), piece_of=whole),
    )


def cast(body: TurnedBody, role: CutRole | None = None) -> TurnedBody:
    """Return a pin as it lies in the mold: turned about x by half a turn."""
    (x, y, z), (u, v, w) = body.origin, body.direction
    return replace(body, origin=(x, -y, -z), direction=(u, -v, -w), role=role)


def pocket_places(design: Design) -> list[tuple[float, float]]:
    """Return (x, y) of the pockets, mm: under the summits of pins, or where a flat skin has them."""
    pocket = design.features.pocket
    if pocket is None:
        return []
    if isinstance(design.features, Pin):
        return [(p.tip[0] + pocket.offset, p.tip[1]) for p in skin_of(design).placed]
    radius, along = design.skin.curvature_radius, design.skin.radius_y
    where = places(design.skin, design.features)
    return [
        (radius * math.sin(at.u / radius) + pocket.offset, at.v * float(np.sinc(at.v / along / math.pi)))
        for at in where
    ]


def pockets(design: Design, up: float = 1.0) -> tuple[Bore, ...]:
    """Return the pockets as blind holes from the back's middle; `up` = -1 as the skin lies in its mold."""
    pocket = design.features.pocket
    if pocket is None:
        return ()
    deep = on_grid(pocket.depth)
    return tuple(
        Bore((x, up * y, min(0.0, up * deep)), "z", deep, pocket.diameter / 2, role=CutRole.POCKET)
        for x, y in pocket_places(design)
    )


def pocket_cuts(design: Design, up: float = 1.0, number: int | None = None) -> Iterator[Bore | ExtendedCut]:
    """Yield what pockets take from the skin, or from what lies behind the face of shot `number`: from a back
    that bends on, or up to a face that they go through. There they are built beyond it."""
    for pocket in pockets(design):
        low, _, out = over_disc(design, 0, pocket.start[:2], pocket.radius)
        top, beyond = pocket.length, pocket.length
        if number is not None:
            mean, most, _ = over_disc(design, number, pocket.start[:2], pocket.radius)
            top, beyond = (mean, max(top, most + SUNK)) if pocket.length > mean else (top, top)
        counts, built = (
            replace(pocket, start=(pocket.start[0], up * pocket.start[1], min(up * a, up * b)), length=b - a)
            for a, b in ((low, top), (out - SUNK if low else 0.0, beyond))
        )
        yield counts if counts == built else ExtendedCut(counts, built)


def over_disc(
    design: Design, number: int, at: tuple[float, float], radius: float
) -> tuple[float, float, float]:
    """Return mean, largest and least height of a shot's face over a disc, or with 0 of the back, mm; the mean
    by a quadrature that rounding limits."""
    nodes, weights = _GAUSS
    u, weight = (nodes + 1) / 2, weights / 2 * (nodes + 1)
    turn = 2 * math.pi * np.arange(_TURN) / _TURN
    x, y = at[0] + radius * np.outer(u, np.cos(turn)), at[1] + radius * np.outer(u, np.sin(turn))
    mean = float(weight @ heights(design, number, x, y).mean(axis=1))
    rim = heights(design, number, at[0] + radius * np.cos(turn), at[1] + radius * np.sin(turn))
    middle = float(heights(design, number, np.array([at[0]]), np.array([at[1]]))[0])
    return mean, max(float(rim.max()), middle), min(float(rim.min()), middle)


def hole_block(placed: Placed) -> Loop:
    """Return the block with a pin's hole alone, in the plane of the pin's axis and z, z as in the mold: what
    a tool or a layer meets there is what it meets in the round hole."""
    hole = flipped(tuple(upright(placed).outline))
    start, end = hole[-1].end, hole[0].start
    low = min(min(s.start.z, s.end.z) for s in hole) - 2 * placed.feature.root_width
    wide = 2 * (start.x - end.x)
    corners = [end, Point(end.x - wide, end.z), Point(end.x - wide, low), Point(start.x + wide, low)]
    corners += [Point(start.x + wide, start.z), start]
    ground = (Segment(a, b) for a, b in pairwise(corners))
    return (*(s.reversed() for s in reversed(hole)), *ground)


def _loop(feature: Feature, deep: float) -> Loop:
    """A feature's half outline at t >= 0, closed along its axis, `deep` mm below its foot."""
    half: list[Segment] = []
    for s in feature.outline:
        if s.kind == "crown":
            half.append(replace(s, end=Point(0.0, feature.height), bulge=math.tan(s.sweep / 8)))
            break
        half += [s] if s.chord > 0.0 else []
    foot = half[0].start
    corners = [Point(0.0, feature.height), Point(0.0, -deep), Point(foot.x, -deep), foot]
    lines = (Segment(a, b) for a, b in pairwise(corners) if a != b)
    return (*half, *lines)


def _filled(base: Base, skin: Skin, foot: Array) -> tuple[Array, float]:
    """What the base falls away under each pin's foot, `(n,)` mm3, and how far at most, mm: the way along the
    pin's axis from the foot's plane to the base, summed over the foot."""
    nodes, weights = _RINGS
    share = np.append((nodes + 1) / 2, 1.0)  # of the foot; the rim counts for the depth alone
    turn = 2 * math.pi * np.arange(_TURNS) / _TURNS
    frames = np.stack([TurnedBody((), p.foot, p.axis).frame() for p in skin.placed])
    round_foot = np.cos(turn), np.sin(turn), 0.0 * turn
    disk = np.einsum("p,r,it->prti", foot, share, np.array(round_foot))
    plane = np.einsum("prti,pji->prtj", disk, frames) + np.array([p.foot for p in skin.placed])[:, None, None]
    axis = np.array([p.axis for p in skin.placed])[:, None, None]
    down = np.zeros(plane.shape[:3])
    for _ in range(_STEPS):
        step = _over(base, plane - down[..., None] * axis)
        down = down + step
        if np.abs(step).max() < _STILL:
            break
    mean = down[:, :-1].mean(axis=2)
    return 2 * math.pi * foot**2 * (mean @ (weights / 2 * share[:-1])), float(down.max())


def _over(base: Base, points: Array) -> Array:
    """How far points `(..., 3)` mm lie outside the base's face, mm, about: exact where that is 0."""
    x, y, z = np.moveaxis(points, -1, 0)
    radius, along, thick = base.curvature_radius, base.radius_y, base.thickness
    n = z - thick
    if math.isfinite(along):
        n = (y * y + n * n + 2 * along * n) / (along + np.hypot(y, n + along))
    aside = x * x + y * y if base.round else x * x
    over: Array = (aside + n * n + 2 * radius * n) / (radius + np.sqrt(aside + (n + radius) ** 2))
    return over
