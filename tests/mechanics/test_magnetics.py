"""Magnets in pins: their field against magpylib's, how they go against beams and CalculiX, and what sensors
tell of forces."""

from __future__ import annotations

import math
import tomllib
from typing import Any

import magpylib
import numpy as np
import pytest

import skincad
from bench import calculix, pins
from skincad.base import Estimate, InputError
from skincad.inputs import Design
from skincad.inputs.material import silicone
from skincad.mechanics import cylinder_field, force_noise, lone, magnet_signal, magnetic_pins
from skincad.mechanics.models import pin_cell as cells
from skincad.shape import skin_of
from tests.refusals import refused, refused_by

SIDES = (1.5, 1.5), (2.0, 4.0), (4.0, 1.0)  # mm, diameters and lengths
NORTH = {"along": (0.0, 0.0, 1.0), "across": (1.0, 0.0, 0.0), "askew": (0.36, -0.48, 0.8)}


def around(wide: float, long: float) -> np.ndarray:
    """Places all round a magnet, from a tenth of its size outside of it on, on its axis and beside it."""
    rng = np.random.default_rng(1)
    way = rng.normal(size=(200, 3))
    way *= (np.hypot(wide, long) / 2 * rng.uniform(1.1, 8.0, 200) / np.linalg.norm(way, axis=1))[:, None]
    below = [[0.0, 0.0, -0.6 * long], [wide / 2, 0.0, -0.6 * long], [0.0, 0.6 * wide, 0.1 * long]]
    return np.vstack([way, below])


@pytest.mark.parametrize("north", NORTH.values(), ids=NORTH)
@pytest.mark.parametrize(("wide", "long"), SIDES)
def test_the_field_is_that_of_magpylib(wide: float, long: float, north: tuple[float, ...]) -> None:
    """1e-9 of the field: magpylib's is a closed form, ours a sum that converges exponentially."""
    places = around(wide, long)
    theirs = magpylib.magnet.Cylinder(polarization=north, dimension=(wide, long)).getB(places)
    ours = cylinder_field(places, north, wide / 2, long)
    off = np.linalg.norm(ours - theirs, axis=1) / np.linalg.norm(theirs, axis=1)
    assert off.max() < 1e-9


def dipole_error(distance: float, wide: float, long: float) -> float:
    """The largest relative error of a dipole so far from the middle, in any direction."""
    angle = np.linspace(0.0, math.pi / 2, 91)
    way, north = np.stack([np.sin(angle), 0 * angle, np.cos(angle)], axis=1), np.array([0.0, 0.0, 1.0])
    field = cylinder_field(distance * way, (0.0, 0.0, 1.0), wide / 2, long)
    volume = math.pi * wide**2 / 4 * long
    dipole = (3 * way * (way @ north)[:, None] - north) * volume / (4 * math.pi * distance**3)
    return float((np.linalg.norm(field - dipole, axis=1) / np.linalg.norm(field, axis=1)).max())


@pytest.mark.parametrize(
    ("long", "five", "one"),
    [(0.25, 2.7, 5.9), (0.5, 2.3, 5.1), (0.87, 1.3, 1.9), (1, 1.7, 3.3), (2, 2.9, 6.4)],
)
def test_where_a_dipole_stops(long: float, five: float, one: float) -> None:
    """Off by 5 % and by 1 %, in the longer side of a magnet as wide as 1; the next term falls by the square
    of the distance, and is least where the length is sqrt(3)/2 of the diameter."""
    side = max(1.0, long)
    assert 0.03 < dipole_error(five * side, 1.0, long) < 0.05
    assert 0.008 < dipole_error(one * side, 1.0, long) < 0.01


def one_pin(**pocket: Any) -> Design:
    """A slender pin of 2 mm on a thin base, on a magnet so thin that it does not stiffen it."""
    table = {"columns": 1, "rows": 1, "pitch": 4.0, "height": 14.0, "root_diameter": 2.0}
    table |= {"tip_diameter": 2.0, "crown": 0.1, "root_fillet": 0.1}
    magnet = {"diameter": 0.3, "length": 0.3, "grade": "N42"}
    return skincad.Design(
        name="slender",
        skin={"curvature_radius": 1e8, "thickness": 0.5, "width": 10.0, "length": 10.0},
        pin={**table, "pocket": {"diameter": 0.3, "depth": 8.65, "magnet": magnet, **pocket}},
        material={"name": "dragon-skin-20"},
        mold={"process": "sla", "pour": "open"},
        contact={"force": 0.01},
        magnetometer={"below": 1.0, "range": 50.0, "noise": 2.0, "rate": 100.0},
    )


@pytest.mark.slow
def test_a_magnet_in_a_slender_pin_goes_as_a_beam_and_a_column() -> None:
    """4 %: a root that turns by its base is as a beam about a tenth of its diameter longer (1.5 % of the
    pull's, 3 % of the moment's), and Timoshenko's shear is in none of it but the pull's."""
    design = one_pin()
    cell, young = cells.pin_cell(lone(design, 14.0, 0.5)), silicone(design).young_modulus.value
    area, second, height, at = math.pi, math.pi / 4, 14.0, 8.5 - 0.5
    up, out, tilt, out_by, tilt_by = cell.magnet
    shear = at / (0.9 * area * young / 3)
    assert up == pytest.approx(at / (young * area), rel=0.04)
    assert out == pytest.approx(at**2 * (3 * height - at) / (6 * young * second) + shear, rel=0.04)
    assert tilt == pytest.approx(at * (2 * height - at) / (2 * young * second), rel=0.04)
    assert out_by == pytest.approx(-(at**2) / (2 * young * second), rel=0.04)
    assert tilt_by == pytest.approx(-at / (young * second), rel=0.04)


@pytest.mark.slow
def test_a_magnets_mesh_and_bore_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """1 % by twice the mesh, a bore a quarter as wide, and ten times the stiffness, as the constants say."""
    cell = lone(pins.magnetic_six(), 2.4, 2.0)
    usual = cells.pin_cell(cell).magnet
    for name, value in (("FINENESS", 2.0), ("CORE", 0.005), ("RIGID", 1e4)):
        with monkeypatch.context() as changed:
            changed.setattr(cells, name, value)
            np.testing.assert_allclose(cells.pin_cell.__wrapped__(cell).magnet, usual, rtol=0.01)


@pytest.mark.slow
def test_a_magnet_stiffens_its_pin_and_says_what_its_pocket_holds() -> None:
    """Silicone in its place: a tenth to a quarter more way, and the bound on pockets is gone."""
    design = skincad.load("magnet-pillars")
    stiff, soft = (
        cells.pin_cell(lone(d, 4.7, 2.4))
        for d in (design, design.with_(magnetometer=None, pin={"pocket": None}))
    )
    assert 1.1 < soft.axial / stiff.axial < 1.6
    assert 1.05 < soft.across[0, 0] / stiff.across[0, 0] < 1.3
    named = skincad.check(design)
    unnamed = skincad.check(design.with_(magnetometer=None, pin={"pocket": {"diameter": 1.4, "depth": 4.5}}))
    assert "pockets" in {part.effect for part in unnamed.left_out}
    assert "pockets" not in {part.effect for part in named.left_out}
    assert (named.all_touch_force.error or 0.0) < (unnamed.all_touch_force.error or 0.0) / 2


@pytest.mark.evidence(subject="calculix: magnets")
@pytest.mark.skipif(bool(calculix.missing()), reason=calculix.missing())
def test_calculix_moves_a_magnet_as_far() -> None:
    """5 % at edges of 0, by a line through six edges, on which meshes scatter by 1 %: two of them alone told
    0.99 and 1.07 of the same pin where gmsh had one thread and two. The edge of 0.3 mm is stiff by 11 %, as
    the root's sharp corner asks, with Poisson's ratio 0.4, by which they do not lock."""
    one = pins.magnetic_six().with_(
        skin={"width": 10.0, "length": 10.0},
        pin={"columns": 1, "rows": 1, "heights": None, "height": 2.4},
        material={"poisson_ratio": 0.4},
    )
    edges, ratios = (0.3, 0.27, 0.24, 0.21, 0.18, 0.15), []
    for edge in edges:
        theirs, ours = pins.magnet_moves(one, ((1, 0), (1, 2)), edge)
        ratios.append(
            [theirs[load, 0, part] / ours[load, 0, part] for load, part in ((0, 0), (0, 4), (1, 2))]
        )
    np.testing.assert_allclose(np.polyfit(edges, ratios, 1)[1], 1.0, atol=0.05)


@pytest.mark.evidence(subject="calculix: magnets")
@pytest.mark.skipif(bool(calculix.missing()), reason=calculix.missing())
def test_calculix_moves_the_magnets_of_neighbours() -> None:
    """1 % of how far a pin's own goes: there they go by 3 %."""
    design = pins.magnetic_six().with_(material={"poisson_ratio": 0.4})
    theirs, ours = pins.magnet_moves(design, ((2, 0), (2, 2)), 0.3)
    others = [0, 2, 3, 4, 5]
    for load, own in ((0, 0), (1, 2)):
        size = abs(theirs[load, 1, own])
        assert 0.02 * size < np.abs(theirs[load, others, :3]).max() < 0.06 * size
        assert np.abs(ours - theirs)[load, others, :3].max() < 0.01 * theirs[0, 1, 0]


@pytest.fixture(scope="module")
def nine() -> Design:
    return skincad.load("magnet-pillars")


@pytest.mark.slow
def test_readings_rise_with_forces_as_their_slope_says(nine: Design) -> None:
    every, rng = magnetic_pins(nine), np.random.default_rng(2)
    loads, more = rng.normal(0.0, 0.05, (9, 3)), rng.normal(0.0, 1.0, (9, 3))
    step = 1e-5  # N; the rise is straight to 1e-4 of itself within it
    rise = sum(
        s * every.fields(every.poses(loads + s * step * more)).sum(axis=1) / (2 * step) for s in (1, -1)
    )
    np.testing.assert_allclose(
        (every.slope(every.poses(loads)) @ more.ravel()).reshape(-1, 3), rise, atol=1e-4 * np.abs(rise).max()
    )


@pytest.mark.slow
def test_moved_and_tilted_magnets_have_the_field_of_magpylibs(nine: Design) -> None:
    """1e-9 of the largest: nine sources, each moved and turned by its own pose."""
    every, poses = magnetic_pins(nine), np.random.default_rng(4).normal(0.0, 0.2, (9, 6))
    theirs = np.zeros((9, 3))
    for middle, pose in zip(every.middle, poses, strict=True):
        source = magpylib.magnet.Cylinder(polarization=(0, 0, every.remanence), dimension=(1.5, 1.5))
        source.rotate_from_rotvec(pose[3:], degrees=False)
        theirs += source.move(middle + pose[:3]).getB(every.place)
    ours = every.fields(poses).sum(axis=1)
    np.testing.assert_allclose(ours, theirs, atol=1e-9 * np.abs(theirs).max())


@pytest.mark.slow
def test_pulls_and_presses_move_magnets_the_way_they_go(nine: Design) -> None:
    """A pull bends a pin over to its side, and a press lowers it and its neighbours' base; a quarter of a
    turn of the forces turns what they do, to the 24 points of a root's mean (6 % of what neighbours feel)."""
    goes = magnetic_pins(nine).goes
    pull, aside, press = goes[4, :, 4].T
    assert pull[0] > 0 < pull[4]
    assert aside[1] > 0 > aside[3]
    np.testing.assert_allclose([aside[1], aside[3]], [pull[0], -pull[4]], rtol=1e-9)
    assert press[2] > 0
    assert np.abs(press[[0, 1, 3, 4, 5]]).max() < 1e-9
    beside = goes[:, :, 4]  # by forces on the middle pin
    assert beside[5, 0, 2] == pytest.approx(-beside[3, 0, 2], rel=0.15)
    assert beside[5, 0, 2] == pytest.approx(beside[7, 1, 2], rel=0.15)
    assert 0.01 * pull[0] < beside[5, 0, 0] < 0.1 * pull[0]


@pytest.mark.slow
def test_the_floor_is_the_spread_of_forces_by_noisy_readings(nine: Design) -> None:
    """3 % of 4,000 draws: a standard deviation's own is 1.1 %."""
    every, sensors = magnetic_pins(nine), nine.magnetometer
    assert sensors is not None
    slope = every.slope(np.zeros((9, 6)))
    floor, alone, condition = force_noise(slope, sensors, np.ones(9, dtype=bool))
    readings = np.random.default_rng(3).normal(0.0, sensors.rms, (4000, len(slope)))
    spread = (np.linalg.lstsq(slope, readings.T, rcond=None)[0]).std(axis=1).reshape(-1, 3)
    np.testing.assert_allclose(spread, floor, rtol=0.05)
    assert (alone < floor).all()
    assert condition == pytest.approx(np.linalg.cond(slope))


@pytest.mark.slow
def test_a_press_is_read_by_all_and_told_apart(nine: Design) -> None:
    """By symmetry the middle sensor reads along z alone; all 27 components are told apart."""
    check = skincad.check(nine)
    magnet = check.magnet
    assert magnet is not None
    assert magnet.resolved == 27
    assert magnet.saturated == 0
    middle = magnet.sensors[4]
    assert abs(middle.change[0].value) + abs(middle.change[1].value) < 0.01 * middle.change[2].value
    assert 0 < middle.change[2].error < 0.4 * middle.change[2].value
    table = check.as_json()["magnet"]
    assert table["sensors"][4]["place_mm"] == [0.0, 0.0, -1.0]
    assert {"rest_mT", "change_mT"} <= {*table["sensors"][0]}
    assert {"floor_N", "alone_N", "displacement_mm", "tilt_deg"} <= {*table["pins"][0]}
    assert 0.1 < magnet.map_error < 0.3
    assert "magnets        9 sensors tell all 27 components" in str(check)
    assert "magnet" not in skincad.check(skincad.load("pillars-9")).as_json()


@pytest.mark.slow
def test_too_few_sensors_tell_what_they_do(nine: Design) -> None:
    """Four sensors read twelve numbers of 27; a range of 5 mT is left at rest."""
    places = [[x, y, 1.0] for x in (-6.0, 6.0) for y in (-6.0, 6.0)]
    four = nine.with_(magnetometer={"below": None, "places": places, "range": 5.0})
    signal = magnet_signal(four, [Estimate(0.1, 0.01, "N")] * 9)
    assert signal is not None
    assert signal.condition is None
    assert signal.resolved < 27
    assert None in {f for pin in signal.pins for f in pin.floor}
    assert signal.saturated == 4
    told = str(skincad.check(four))
    assert "4 sensors tell none of 27 components of the pins' forces apart\n" in told
    assert "is asked for" not in told


@pytest.mark.slow
def test_sensors_beyond_their_range_tell_no_force(nine: Design) -> None:
    """Nine sensors read 10 mT at rest: at 2 mT their readings stand still, whatever presses."""
    signal = magnet_signal(nine.with_(magnetometer={"range": 2.0}), [Estimate(0.1, 0.01, "N")] * 9)
    assert signal is not None
    assert (signal.saturated, signal.resolved, signal.condition) == (9, 0, None)
    assert {f for pin in signal.pins for f in pin.floor} == {None}


@pytest.mark.slow
def test_magnets_push_each_other_as_dipoles_side_by_side(nine: Design) -> None:
    """3 mu0 m^2 / (4 pi r^4), Griffiths, Introduction to Electrodynamics, 4th ed., problem 6.3: 6 %, as four
    magnets' lengths apart the field of one is off by 1.5 % and its slope by two thirds more, on each side."""
    every = magnetic_pins(nine)
    moment = 1.35 * math.pi * 0.75**2 * 1.5 * 1e-9 / (4e-7 * math.pi)
    apart = 3 * 4e-7 * math.pi * moment**2 / (4 * math.pi * 0.006**4)
    force = every.push()[4, 5]
    assert force[0] == pytest.approx(-apart, rel=0.06)
    assert abs(force[1]) + abs(force[2]) < 1e-6 * apart


WRONG = {
    "pin.pocket.magnet.grade: is missing": {"magnet": {"diameter": 1.5, "length": 1.5}},
    "pin.pocket.magnet.grade: must not be given": {
        "magnet": {"diameter": 1.5, "length": 1.5, "grade": "N42", "remanence": [1.2, 1.3]}
    },
    "pin.pocket.magnet.remanence: needs low <= high": {
        "magnet": {"diameter": 1.5, "length": 1.5, "remanence": [1.3, 1.2]}
    },
    "pin.pocket.magnet.diameter: must be from 1.4 to 1.7": {
        "magnet": {"diameter": 2.0, "length": 1.5, "grade": "N42"}
    },
    "pin.pocket.magnet.length: must be at most 3.3": {
        "magnet": {"diameter": 1.5, "length": 3.4, "grade": "N42"}
    },
    "pin.pocket.magnet.gap: must be less than 3.3 mm": {
        "magnet": {"diameter": 1.5, "length": 1.5, "grade": "N42", "gap": 4.0}
    },
    "pin.pocket.offset: must be 0 beside [magnetometer]": {"offset": 0.1},
    "magnetometer: reads magnets in pins": {"magnet": None},
}


@pytest.mark.parametrize("start", WRONG)
def test_what_makes_no_sense_is_refused_in_a_line(start: str) -> None:
    design = skincad.load("magnet-pillars")
    data = design.model_dump(exclude_none=True)
    data["pin"]["pocket"] |= WRONG[start]
    with refused_by(start):
        skincad.Design(**data)


def test_sensors_are_refused_where_they_cannot_be() -> None:
    design = skincad.load("magnet-pillars")
    at = [0.0, 0.0, 1.0]
    for change, words in (
        (
            {"below": None, "places": [at, [1.0, 0.0, 1.0], at]},
            "magnetometer.places: must not hold a place twice, got [0.0, 0.0, 1.0]; move one",
        ),
        ({"below": -1.0}, "magnetometer.below"),
        ({"below": None}, "magnetometer.below: is missing"),
        ({"places": [[0.0, 0.0, 1.0]]}, "must not be given beside places"),
        ({"below": None, "places": [[0.0, 0.0, -1.0]]}, "magnetometer.places.0.2"),
    ):
        with refused(words):
            design.with_(magnetometer=change)
    with pytest.raises(InputError) as failure:  # of one wrong number nothing is said of the list
        design.with_(magnetometer={"below": None, "places": [[0.0, 0.0, -1.0]]})
    assert str(failure.value) == "magnetometer.places.0.2: must be greater than 0, got -1"
    flat = skincad.load("flat-magnet")
    with refused_by("magnetometer: reads magnets in pins"):
        flat.with_(magnetometer=design.magnetometer.model_dump(exclude_none=True))
    named = flat.with_(flat={"pocket": {"diameter": 1.9, "depth": 2.2, "magnet": {
        "diameter": 2.0, "length": 2.0, "remanence": [0.2, 0.3], "north": "x"}}})  # fmt: skip
    assert skincad.Design(**tomllib.loads(named.to_toml())) == named


def test_a_magnet_stays_in_the_file_that_a_design_makes() -> None:
    design = skincad.load("magnet-pillars")
    assert skincad.Design(**tomllib.loads(design.to_toml())) == design
    pocket = design.pin.pocket
    assert pocket is not None
    assert pocket.magnet_span == (2.0, 3.5)
    assert skin_of(design).count == 9
