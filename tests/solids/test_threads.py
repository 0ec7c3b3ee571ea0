"""The blind threads of a mount against the tables of the standards, written here a second time."""

from __future__ import annotations

import math

import pytest

from skincad.inputs import Mount, processes
from skincad.solids import METRIC, blind_thread, insert_radius, run_out_room
from skincad.solids.fasteners import LEAST_UNDER_HOLE, least_thickness

METAL, RESIN = processes()["edm"], processes()["sla"]
# source: ISO 261 (diameter, coarse pitch), ISO 273 (medium clearance hole)
COARSE = {"M2": (2.0, 0.4, 2.4), "M2.5": (2.5, 0.45, 2.9), "M3": (3.0, 0.5, 3.4), "M4": (4.0, 0.7, 4.5)}


@pytest.mark.parametrize("name", COARSE)
def test_the_drill_is_a_pitch_narrower_than_the_thread(name: str) -> None:
    """ISO 2306 rounds diameter less pitch to the drills that there are, by 0.05 mm at most."""
    diameter, pitch, clearance = COARSE[name]
    assert METRIC[name][:2] == (diameter, pitch)
    assert METRIC[name].drill == pytest.approx(diameter - pitch, abs=0.051)
    assert METRIC[name].clearance == clearance
    assert METRIC[name].insert_hole >= diameter + 2 * pitch  # there is brass round the thread


@pytest.mark.parametrize("name", COARSE)
def test_a_screw_has_its_thread_and_the_tap_its_run_out(name: str) -> None:
    diameter, pitch, _ = COARSE[name]
    tapped, insert = blind_thread(name, METAL), blind_thread(name, RESIN)
    assert tapped.insert == ""
    assert tapped.least == diameter  # in metal
    assert tapped.depth - tapped.most == pytest.approx(5 * pitch, abs=1e-9)  # DIN 76-1, short
    assert tapped.most - tapped.least == pytest.approx(1.0)  # a screw of a standard length finds its place
    assert insert.insert == "glued"
    assert insert.most == METRIC[name].insert >= insert.least == 1.5 * diameter
    assert insert.depth == pytest.approx(insert.most + 1.0, abs=1e-9)
    process = RESIN.model_copy(update={"thread": "tapped"})
    assert blind_thread(name, process).least == 1.5 * diameter  # in plastic


def test_an_m3_is_the_mold_s_own() -> None:
    for process in (METAL, RESIN):
        blind = blind_thread("M3", process)
        assert 2 * blind.radius == (2.5 if not blind.insert else 2 * insert_radius("M3", blind.insert))
        assert blind.depth - blind.most + (0.0 if blind.insert else 1.0) == pytest.approx(
            run_out_room(process)
        )


def test_a_carrier_is_as_thick_as_the_deepest_hole_asks() -> None:
    for mount, process, deepest, word in (
        (Mount(thread="M3", diameter=9.0), METAL, 3.0 + 1.0 + 2.5, "M3 threads"),
        (Mount(thread="M4", diameter=9.0), RESIN, 8.1 + 1.0, "M4 glued inserts"),
        (Mount(thread="M2", diameter=9.0, pin=3.0), METAL, 2.0 + 1.0 + 2.0, "M2 threads"),
        (Mount(fiducials=3, fiducial_depth=2.0), METAL, 2.0, "fiducials"),
    ):
        need, what = least_thickness(mount, process)
        assert math.isclose(need, deepest + LEAST_UNDER_HOLE, abs_tol=1e-9)
        assert word in what
