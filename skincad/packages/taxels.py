"""Where a skin feels: the pose of every film strip and of every ridge's crest, in the design's frame.

A pose `(3, 4)` has the axes as columns, then the place in mm. The third axis points out of the skin: along a
strip's depth, or off a crest; the second is y, along the ridge; the first is across, towards +x. A strip's
place is its slot's centre, a crest's its summit, both in the middle of the length.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skincad.base.arrays import Array
from skincad.inputs.design import Design
from skincad.shape.curves import Point
from skincad.shape.skin import section, skin_of


@dataclass(frozen=True, eq=False)
class Taxels:
    """Places that feel: their `names`, `kinds` ("film" or "crest"), `ridges`, `sides` ("S1", "S2" or ""),
    `poses` `(n, 3, 4)` mm, and `sizes` `(n, 2)` mm: across or along the strip's depth, and along y."""

    names: tuple[str, ...]
    kinds: tuple[str, ...]
    ridges: tuple[int, ...]
    sides: tuple[str, ...]
    poses: Array
    sizes: Array


def taxels(design: Design) -> Taxels:
    """Return all film strips, ridge by ridge, then all crests; without a film there are no strips."""
    strips, tops = films(design), crests(design)
    return Taxels(
        strips.names + tops.names,
        strips.kinds + tops.kinds,
        strips.ridges + tops.ridges,
        strips.sides + tops.sides,
        np.concatenate([strips.poses, tops.poses]),
        np.concatenate([strips.sizes, tops.sizes]),
    )


def films(design: Design) -> Taxels:
    """Return the film strips; none without slots, without a film, or where it is ignored."""
    slots = section(design).slots if design.film and design.film_state != "ignored" else ()
    poses = [_pose(slot.centre, slot.direction) for slot in slots]
    return Taxels(
        tuple(f"ridge-{slot.feature}-{slot.side}" for slot in slots),
        ("film",) * len(slots),
        tuple(slot.feature for slot in slots),
        tuple(slot.side for slot in slots),
        np.array(poses).reshape(-1, 3, 4),
        np.array([(slot.depth, design.skin.length) for slot in slots]).reshape(-1, 2),
    )


def crests(design: Design) -> Taxels:
    """Return the summits of all ridges."""
    skin = skin_of(design)
    count = skin.count
    frames = [skin.placed[ridge - 1].frame for ridge in range(1, count + 1)]
    places = [at.at(0.0, height) for at, height in zip(frames, skin.heights, strict=True)]
    poses = [_pose(place, at.normal) for place, at in zip(places, frames, strict=True)]
    return Taxels(
        tuple(f"ridge-{ridge}-crest" for ridge in range(1, count + 1)),
        ("crest",) * count,
        tuple(range(1, count + 1)),
        ("",) * count,
        np.array(poses),
        np.array([(skin.profile.tip_width, design.skin.length)] * count),
    )


def _pose(place: Point, outward: Point) -> Array:
    """Pose of a place in the section, its third axis along a unit vector of the section."""
    return np.array(
        [
            [outward.z, 0.0, outward.x, place.x],
            [0.0, 1.0, 0.0, 0.0],
            [-outward.x, 0.0, outward.z, place.z],
        ]
    )
