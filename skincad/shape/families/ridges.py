"""Ridges: bars along y that stand side by side on normals of the base circle, alike but for their heights.

Half a ridge is drawn in its own frame, (t, n) mm: flank, fillets and the crown's arc; the other half is its
mirror image.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from skincad.base.errors import InputError
from skincad.inputs.design import Design
from skincad.inputs.feature_tables import Flat, Pin, Ridge
from skincad.shape.curves import Point, Segment, concentric_hit, rise
from skincad.shape.feature import Feature, Frame, Placed, SensorPlace, Side

ProfileTable = Ridge | Pin


def place(design: Design) -> tuple[Placed, ...]:
    """Return the design's ridges, or rings where the section's half at +x crosses them, side by side from the
    smallest x, each on its own normal of the base circle.

    Raises InputError where one has no shape, or neighbours no room.
    """
    radius = design.skin.curvature_radius
    features = profiles(design, radius)
    _check_roots(design, features)
    placed = []
    for number, feature in enumerate(features, 1):
        lean = design.lean(number)
        sine, cosine = math.sin(lean), math.cos(lean)
        origin = Point(radius * sine, design.skin.thickness - 2 * radius * math.sin(lean / 2) ** 2)
        frame = Frame(origin, Point(cosine, -sine), Point(sine, cosine))
        beside = tuple(n for n in (number - 1, number + 1) if 1 <= n <= len(features))
        placed.append(Placed(feature, frame, number, lean, beside, design.skin.length))
    return tuple(placed)


def profiles(design: Design, radius: float) -> list[Feature]:
    """Return each feature of the design on a base of a `radius` mm, drawn once for each height. Raises
    InputError for one without a shape."""
    drawn: dict[float, Feature] = {}
    for number, height in enumerate(design.heights, 1):
        if height not in drawn:
            try:
                drawn[height] = _profile(design, radius, height)
            except InputError as broken:
                if not design.uneven:
                    raise
                rule = f"{design.features.family} {number}, {height:g} mm high: {broken.rule}"
                raise InputError(broken.key, rule, broken.value, broken.remedy) from None
    return [drawn[height] for height in design.heights]


def _profile(design: Design, radius: float, height: float) -> Feature:
    table = design.features
    if isinstance(table, Flat):
        raise ValueError("a flat skin has no profile")
    half = _half_profile(table, radius, height)
    return Feature(
        family=table.family,
        outline=tuple(_outline(table, half, height)),
        height=height,
        root_width=table.root_width,
        tip_width=table.tip_width,
        crown=table.crown,
        root_fillet=table.root_fillet,
        tip_fillet=table.tip_fillet,
        slot=design.slot,
        sensors=tuple(_sensors(design)),
    )


def without_fillets(design: Design) -> Design:
    """Return the design with the sharp corners that a coarse mesh has."""
    return design.with_(**{design.features.family: {"tip_fillet": 0.0, "root_fillet": 0.0}})


def _check_roots(design: Design, features: list[Feature]) -> None:
    """Raise InputError where root fillets of neighbours overlap; a lone ridge is its own neighbour."""
    pitch, name = design.spacing, design.features.family
    for number, (left, right) in enumerate(pairwise(features) if features[1:] else [features * 2], 1):
        reach = left.feet[0].x + right.feet[0].x
        if reach > pitch:
            where = f" at {name}s {number} and {number + 1}" if design.uneven else ""
            rule = f"neighbouring root fillets overlap by {reach - pitch:.4g} mm{where}"
            fillet = left.root_fillet
            raise InputError(f"{name}.root_fillet", rule, fillet, "take a smaller fillet or a larger pitch")


def _outline(table: ProfileTable, right: list[Point], height: float) -> Iterator[Segment]:
    """The outline from the foot at +t to that at -t, of the corners of its half at +t, from base circle to
    crown; without a fillet its segment has no length."""
    base, low, high, crown = right
    left = [Point(-t, n) for t, n in right]
    foot = _fillet_bulge(base, low, table.root_fillet)
    shoulder = _fillet_bulge(high, crown, table.tip_fillet)
    summit = (height - crown[1]) / crown[0] if crown[0] > 0 else 0.0
    yield Segment(right[0], right[1], -foot, "root_fillet")
    yield Segment(right[1], right[2], 0.0, "flank")
    yield Segment(right[2], right[3], shoulder, "tip_fillet", touches=True)
    yield Segment(right[3], left[3], summit, "crown", touches=True)
    yield Segment(left[3], left[2], shoulder, "tip_fillet", touches=True)
    yield Segment(left[2], left[1], 0.0, "flank")
    yield Segment(left[1], left[0], -foot, "root_fillet")


def _fillet_bulge(p: Point, q: Point, radius: float) -> float:
    chord = math.hypot(p[0] - q[0], p[1] - q[1])
    return math.tan(math.asin(min(1.0, chord / (2 * radius))) / 2) if radius else 0.0


def _sensors(design: Design) -> Iterator[SensorPlace]:
    """The mirrored pair of slots: S1 at -t, S2 at +t."""
    if design.slot is None:
        return
    slot, tilt = design.slot, math.radians(design.slot.tilt)
    sides: tuple[tuple[Side, int], ...] = ("S1", -1), ("S2", 1)
    for side, sign in sides:
        centre = Point(sign * slot.offset, slot.elevation)
        along = Point(-sign * math.sin(tilt), math.cos(tilt))
        yield SensorPlace(0, side, centre, along, slot.depth, design.core_thickness)


def _half_profile(ridge: ProfileTable, radius: float, height: float) -> list[Point]:
    """Corners (t, n) mm of half a feature of a `height` in mm, in its own frame, with its fillets, on a base
    circle of a `radius`, which is infinite where it is flat: base, both ends of the flank, crown.

    A fillet's centre lies at its radius from the flank's line, and on a circle concentric with the base
    (or crown) circle; written with the circle's curvature, the quadratic stays exact for a flat one.
    """
    name, flat = ridge.family, math.isinf(radius)
    sag = 0.0 if flat else 2 * radius * math.sin(math.asin(ridge.root_width / (2 * radius)) / 2) ** 2
    root = np.array([ridge.root_width / 2, -sag])
    edge = np.array([ridge.tip_width / 2, height - ridge.crown])
    flank = edge - root
    size = float(np.hypot(*flank))
    along = flank / size
    out = np.array([along[1], -along[0]])
    summit = np.array([0.0, height])
    crown_curvature = 2 * ridge.crown / (ridge.tip_width**2 / 4 + ridge.crown**2)
    _check_flank(ridge, rise(root, along, 1 / radius), rise(edge - summit, along, crown_curvature))
    r = ridge.root_fillet
    u = concentric_hit(root + r * out, along, 1 / radius, r + r * r / (2 * radius))
    if u is None:
        raise InputError(f"{name}.root_fillet", "does not fit between flank and base circle", r, "reduce it")
    low, centre = root + u * along, root + r * out + u * along
    base = centre - [0.0, r] if flat else centre * radius / (radius + r) - [0.0, r * radius / (radius + r)]
    r, curvature = ridge.tip_fillet, crown_curvature
    if curvature * r >= 1:
        rule = f"must be less than {1 / curvature:.4g} mm (the crown's radius)"
        raise InputError(f"{name}.tip_fillet", rule, r)
    hit = concentric_hit(edge - r * out - summit, along, curvature, curvature * r * r / 2 - r)
    v = hit if r else 0.0
    if v is None:
        raise InputError(f"{name}.tip_fillet", "does not fit between flank and crown", r, "reduce it")
    high, inner = edge + v * along, edge - r * out + v * along - summit
    crown = (inner + np.array([0.0, r])) / (1 - curvature * r) + summit
    if u > size + v:
        rule = f"root and tip fillet need {u - v:.4g} mm of a flank of {size:.4g} mm"
        remedy = "take smaller fillets or a higher ridge"
        raise InputError(f"{name}.root_fillet", rule, ridge.root_fillet, remedy)
    if crown[0] < 0:
        rule = "the two tip fillets overlap on the axis"
        raise InputError(f"{name}.tip_fillet", rule, r, "take a smaller one")
    # without a fillet its two ends are one corner: 1e-17 mm between them would be an edge that crosses others
    base, low = (base, low) if ridge.root_fillet else (root, root)
    high, crown = (high, crown) if ridge.tip_fillet else (edge, edge)
    return [Point(float(p[0]), float(p[1])) for p in (base, low, high, crown)]


STEEP = 1e-9  # rounding of the sine by which a hemisphere's edge is as steep as a cylinder


def _check_flank(table: ProfileTable, at_root: float, at_tip: float) -> None:
    """Raise InputError where a flank doesn't rise from the base circle, or not out of the crown's: by the
    sines of its angles with them, which no fillet changes. A pin's hemisphere may go on as its cylinder."""
    name, root_key = table.family, table.widths[0]
    if at_root <= 0:
        rule = f"is so wide and the {name} so low that its flanks begin inside the base circle"
        remedy = f"make the {name} higher or less crowned, its root narrower, or curvature_radius larger"
        raise InputError(f"{name}.{root_key}", rule, table.root_width, remedy)
    if at_tip <= 0 and not (name == "pin" and table.tip_fillet == 0.0 and at_tip > -STEEP):
        rule = "makes the crown's edges as steep as the flanks or steeper"
        raise InputError(f"{name}.crown", rule, table.crown, "reduce it, or make the flanks steeper")
