"""A mount's holes: where the keys say, inside the carrier, over the silicone and clear of all it fills."""

from __future__ import annotations

import cmath
import math
from itertools import combinations, permutations
from typing import Any

import numpy as np
import pytest

import skincad
from skincad.base import InputError
from skincad.fabrication import interference, manifold
from skincad.inputs import Design
from skincad.shape import section
from skincad.solids import (
    Bore,
    ClosedMold,
    CutRole,
    PartRole,
    Prism,
    bores,
    scaled_for_shrinkage,
    solid,
    volume,
)
from skincad.solids.bent import rise
from skincad.solids.layout import layout
from skincad.solids.lids import fiducial_bores
from skincad.solids.mold import mold
from tests.mounted import IN_LINE, NAMES, mounted_design

HOLES = (CutRole.MOUNT, CutRole.MOUNT_PIN, CutRole.FIDUCIAL)
SLACK = 1e-9  # mm, rounding


def requested(design: Design) -> list[tuple[float, float]]:
    """Where the keys say that screws are, by another formula than the program's."""
    mount = design.mount
    assert mount is not None
    if mount.thread is None:
        return []
    if mount.diameter:
        count = mount.count or 4
        first = math.radians(180 / count if mount.angle is None else mount.angle)
        turns = [
            cmath.rect(mount.diameter / 2, first) * cmath.exp(2j * math.pi * i / count) for i in range(count)
        ]
        return [(z.real, z.imag) for z in turns]
    xs, ys = ({-(w or 0) / 2, (w or 0) / 2} for w in (mount.pitch_x, mount.pitch_y))
    return [(x, y) for x in xs for y in ys]


def at(bore: Bore) -> tuple[float, float]:
    return bore.start[0], bore.start[1]


def web(one: Bore, other: Bore) -> float:
    return math.dist(at(one), at(other)) - one.far_radius - other.far_radius


def sides(closed: ClosedMold) -> tuple[float, float]:
    """Half of the width and length of the carrier's top, mm, as its mesh has them."""
    mesh = manifold(closed.first(PartRole.CARRIER), 1e-3)
    points = np.asarray(mesh.to_mesh().vert_properties)[:, :3]
    top = points[points[:, 2] > points[:, 2].max() - 1e-6]
    return float(top[:, 0].max()), float(top[:, 1].max())


@pytest.mark.parametrize("name", NAMES)
def test_holes_lie_where_the_keys_say_inside_and_apart(name: str) -> None:
    design = mounted_design(name)
    closed = mold(design)
    part, over = closed.part("carrier"), closed.part("cover")
    screws, all_holes = bores(part, CutRole.MOUNT), bores(part, *HOLES, CutRole.PULL)
    places = requested(design)
    assert len(screws) == len(places) > 0
    assert all(min(math.dist(at(screw), place) for place in places) < SLACK for screw in screws)
    assert len(bores(part, CutRole.MOUNT_PIN)) == (design.mount.pin is not None)
    assert len(bores(part, CutRole.FIDUCIAL)) == design.mount.fiducials
    high = max(bore.start[2] + bore.length for bore in bores(part, CutRole.VENT))
    x, y = sides(closed)
    for hole in bores(part, *HOLES):
        assert hole.start[2] + hole.length == high  # to the last bit: a film would stay in the mesh
        assert abs(hole.start[0]) + hole.radius <= x - 1.2 + 1e-5  # the mesh's vertices are single
        assert abs(hole.start[1]) + hole.radius <= y - 1.2 + 1e-5
        for other in (*bores(part, CutRole.VENT, CutRole.RIVET), *bores(over, CutRole.BLEED)):
            assert web(hole, other) >= 0.6 - SLACK
        (cup,) = bores(over, CutRole.RESERVOIR)
        assert math.dist(at(hole), at(cup)) - hole.radius - cup.radius >= 0.6 - SLACK
    for one, other in combinations(all_holes, 2):
        least = 0.6 if CutRole.FIDUCIAL in (one.role, other.role) else 1.2
        assert web(one, other) >= least - SLACK


@pytest.mark.parametrize("name", NAMES)
def test_no_hole_comes_nearer_to_the_silicone_than_a_millimetre(name: str) -> None:
    part = mold(mounted_design(name)).part("carrier")
    body = part.body
    assert isinstance(body, Prism)
    for hole in bores(part, *HOLES):
        under = rise(body.grid, abs(hole.start[1]) + hole.radius) if body.grid else 0.0
        assert hole.start[2] - under >= 1.0 - SLACK


@pytest.mark.parametrize("name", NAMES)
def test_the_kernel_finds_the_plans_volume(name: str) -> None:
    part = mold(mounted_design(name)).part("carrier")
    assert volume(part, solid(part)) == pytest.approx(part.volume, rel=1e-9)  # the kernel's quadrature


@pytest.mark.parametrize("name", ["yamada-2002", "bent", pytest.param("gripper-pad", marks=pytest.mark.slow)])
def test_the_mold_still_opens_freely_and_every_hole_keeps_its_bleed(name: str) -> None:
    closed = mold(mounted_design(name))
    assert interference(closed, 1e-3) == []
    assert len(bores(closed.part("cover"), CutRole.BLEED)) == len(
        bores(closed.part("carrier"), CutRole.RIVET)
    )


def test_each_carrier_of_a_gang_has_its_own() -> None:
    one = mold(mounted_design("yamada-2002"))
    two = mold(mounted_design("yamada-2002").with_(mold={"cavities": 2}))
    carriers = two.of(PartRole.CARRIER)
    assert len(carriers) == 2
    alone = sorted(at(hole) for hole in bores(one.part("carrier"), *HOLES))
    for part in carriers:
        (vent,) = bores(part, CutRole.VENT)
        there = sorted((x - vent.start[0], y) for x, y in map(at, bores(part, *HOLES)))
        assert np.allclose(there, alone, atol=1e-9)
        assert solid(part).Volume() == pytest.approx(part.volume, rel=1e-9)


def misfit(seen: np.ndarray[Any, Any], drawn: np.ndarray[Any, Any]) -> float:
    """The largest distance that the best turn and shift leave (Kabsch 1976, in the plane)."""
    a, b = ((row - row.mean(axis=0)) @ np.array([1, 1j]) for row in (seen, drawn))
    turn = np.vdot(a, b)
    return float(np.abs(a * turn / abs(turn) - b).max())


@pytest.mark.parametrize("name", [n for n in NAMES if mounted_design(n).mount.fiducials])
def test_a_camera_knows_a_turned_carrier(name: str) -> None:
    """Of all ways to match what is seen with what is drawn only the right one fits within half a dimple."""
    drawn = np.array(
        [at(hole) for hole in bores(mold(mounted_design(name)).part("carrier"), CutRole.FIDUCIAL)]
    )
    fits = [order for order in permutations(range(len(drawn))) if misfit(drawn[list(order)], drawn) < 0.5]
    assert fits == [tuple(range(len(drawn)))]


def test_a_carrier_is_computed_as_thick_as_its_mount_asks_or_refused() -> None:
    plain = skincad.load("yamada-2002")
    thick = {
        name: mold(plain.with_(mount={**IN_LINE, "thread": name, "pitch_x": 10.0}, mold={"carrier": "plain"}))
        for name in ("M2", "M3")
    }
    tops = {name: max(s.high for s in [closed.part("carrier").body]) for name, closed in thick.items()}
    assert tops == {"M2": 6.0, "M3": 7.5}  # 2 + 1 + 2 and 3 + 1 + 2.5, and 1 over the silicone
    exact = plain.with_(mount=IN_LINE, mold={"carrier_thickness": 6.0})
    assert mold(exact).part("carrier").body.high == 6.0
    with pytest.raises(InputError) as refused:
        mold(plain.with_(mount=IN_LINE, mold={"carrier_thickness": 5.9}))
    assert str(refused.value).startswith(
        "mold.carrier_thickness: must be at least 6 mm, for the mount's M2 threads over 1 mm that stay"
    )


REFUSED = [
    ("yamada-2002", {"thread": "M3", "diameter": 20.0}, "mount.diameter: must be at most 10.029 mm"),
    (
        "yamada-2002",
        {**IN_LINE, "pitch_x": 14.0},
        "mount.pitch_x: must be at most 11 mm, for 1.2 mm between a thread and",
    ),
    (
        "yamada-2002",
        {"thread": "M2", "pattern": "rectangle", "pitch_y": 7.0},
        "mount.pitch_y: puts a thread at",
    ),
    (
        "yamada-2002",
        {**IN_LINE, "pitch_x": 2.0},
        "mount.pitch_x: puts a thread at (1, 0) 0.4 mm from a thread",
    ),
    (
        "gripper-pad",
        {"thread": "M3", "diameter": 20.0, "angle": 0.0, "pin": 2.0},
        "mount.pin: puts the pin's",
    ),
    ("yamada-2002", {"thread": "M2", "diameter": 8.0}, "mount.diameter: is in the way of 4 of the 4 holes"),
    (
        "yamada-2002",
        {"fiducials": 3, "fiducial_diameter": 6.0},
        "mount.fiducials: finds no room for a dimple",
    ),
]


@pytest.mark.parametrize(("name", "mount", "words"), REFUSED)
def test_what_has_no_room_is_told(name: str, mount: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError) as refused:
        mold(skincad.load(name).with_(mount=mount))
    assert str(refused.value).startswith(words)
    assert refused.value.remedy
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("name", ["gripper-pad", "milled-pad"])
def test_the_most_that_is_told_is_taken_and_no_more(name: str) -> None:
    plain = skincad.load(name).with_(mold={"carrier": "plain"})
    mount = {"thread": "M2", "diameter": 500.0, "count": 2, "angle": 10.0}
    with pytest.raises(InputError) as refused:
        mold(plain.with_(mount=mount))
    most = float(str(refused.value).split("at most ")[1].split()[0])
    assert (
        len(bores(mold(plain.with_(mount={**mount, "diameter": most})).part("carrier"), CutRole.MOUNT)) == 2
    )
    with pytest.raises(InputError):
        mold(plain.with_(mount={**mount, "diameter": most + 0.002}))


def test_a_dimple_is_refused_rather_than_drawn_to_the_middle() -> None:
    """All but the carrier's inner third is taken: three there would lie too near to each other to tell."""
    design = scaled_for_shrinkage(skincad.load("gripper-pad").with_(mount={"fiducials": 3}))
    place = layout(design, section(design))[0]
    x, y = place.trough - 1.7, place.end - 1.7  # of a corner's dimple, about
    free = 0.3 * math.hypot(x, y)
    ring = [cmath.rect(math.hypot(x, y), math.radians(2 * i)) for i in range(180)]
    occupied = [((z.real, z.imag, 0.0), math.hypot(x, y) - free) for z in ring]
    with pytest.raises(InputError, match=r"^mount.fiducials: finds no room"):
        fiducial_bores(design, place, occupied)
    assert len(fiducial_bores(design, place, [])) == 3
