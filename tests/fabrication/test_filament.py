"""Material and time of prints of filament, against boxes and cylinders by hand."""

from __future__ import annotations

import math

import pytest
import trimesh

from skincad.fabrication.estimates import DIAGONAL, JERK, OVERLAP, filament, moves, spacing
from skincad.inputs import Process, processes

FDM = processes()["fdm"]
HEIGHT = 10.0  # mm, 50 layers of 0.2


def changed(**keys: float) -> Process:
    return FDM.model_copy(update=keys)


def box(x: float, y: float, z: float = HEIGHT) -> trimesh.Trimesh:
    shape = trimesh.creation.box((x, y, z))
    shape.apply_translation((0.0, 0.0, z / 2))
    return shape


def layer_of_box(x: float, y: float, process: Process, bottom: bool) -> float:
    """Seconds of a solid layer of a rectangle, written out."""
    pitch, firm, seconds = spacing(process), process.acceleration, 0.0
    for loop in range(process.loops):
        in_by = process.line + 2 * loop * pitch
        speed = process.outer_speed if loop == 0 else process.loop_speed
        speed = process.first_speed if bottom else speed
        seconds += moves(2 * (x - in_by), 2, speed, JERK, firm) + moves(2 * (y - in_by), 2, speed, JERK, firm)
    in_by = process.line + (2 * process.loops - 1) * pitch - 2 * OVERLAP * process.line
    wide, deep, speed = x - in_by, y - in_by, process.first_speed if bottom else process.fill_speed
    count, corner = (wide + deep) / DIAGONAL / pitch, min(speed, JERK * DIAGONAL)
    seconds += moves(wide * deep / pitch, count, speed, corner, firm)
    seconds += moves(DIAGONAL * pitch * count, count, speed, corner, firm)
    drawn = 2 * (2.0 / 40.0 + 37.5**2 / (1500.0 * 40.0))  # back and forth from 2.5 to 40 mm/s
    far = moves(math.sqrt(x * y), 1, process.travel_speed, JERK, firm)
    return seconds + (2 + process.loops - 1) * (drawn + far)


@pytest.mark.parametrize(("x", "y"), [(30.0, 20.0), (48.0, 6.0)])
def test_time_of_a_box_is_its_layers(x: float, y: float) -> None:
    effort = filament(box(x, y), FDM)
    by_hand = layer_of_box(x, y, FDM, bottom=True) + 49 * layer_of_box(x, y, FDM, bottom=False)
    assert effort.seconds == pytest.approx(by_hand, rel=1e-6)  # single precision of the manifold's corners


def test_a_solid_print_holds_its_volume() -> None:
    """Less the corners' roundness, and more by what filling overlaps the loops: 1.5 % of 600 mm2."""
    assert filament(box(30.0, 20.0), FDM).volume == pytest.approx(6000.0, rel=0.02)
    cylinder = trimesh.creation.cylinder(12.0, HEIGHT, sections=120)
    cylinder.apply_translation((0.0, 0.0, HEIGHT / 2))
    assert filament(cylinder, FDM).volume == pytest.approx(math.pi * 144.0 * HEIGHT, rel=0.02)


def test_inside_of_a_sparse_box() -> None:
    """Four solid layers below and above; between, loops are solid, and of the rest a share, with links."""
    sparse, solid = filament(box(30.0, 20.0), changed(infill=0.25)), filament(box(30.0, 20.0), FDM)
    pitch = spacing(FDM)
    in_by = FDM.line + (2 * FDM.loops - 1) * pitch - 2 * OVERLAP * FDM.line
    wide, deep = 30.0 - in_by, 20.0 - in_by
    links = (wide + deep) / DIAGONAL / (pitch / 0.25) * DIAGONAL * (pitch / 0.25) * pitch  # mm2
    empty = 42 * FDM.layer * (0.75 * wide * deep - links)
    assert solid.volume - sparse.volume == pytest.approx(empty, rel=0.06)  # 16 of 50 layers are looked at
    assert sparse.seconds < solid.seconds


def test_a_patch_below_70_mm2_is_filled() -> None:
    small = changed(infill=0.25)
    assert filament(box(10.0, 10.0), small) == filament(box(10.0, 10.0), FDM)


@pytest.mark.parametrize("key", ["outer_speed", "loop_speed", "fill_speed", "first_speed", "acceleration"])
def test_each_speed_saves_time_and_no_material(key: str) -> None:
    usual, faster = (
        filament(box(30.0, 20.0), FDM),
        filament(box(30.0, 20.0), changed(**{key: 500.0 + 1000.0})),
    )
    assert faster.seconds < usual.seconds
    assert faster.volume == usual.volume


def test_slow_ways_take_longer() -> None:
    """Faster than 180 mm/s no way here is: the nozzle never gets there."""
    assert (
        filament(box(30.0, 20.0), changed(travel_speed=30.0)).seconds > filament(box(30.0, 20.0), FDM).seconds
    )


def test_slits_that_a_slicer_closes_have_no_loops() -> None:
    """0.08 mm wide, 5 mm deep: below the 0.098 mm that are closed; of 0.2 mm they stay."""

    def slit(width: float) -> trimesh.Trimesh:
        return box(30.0, 20.0).difference(box(width, 10.0).apply_translation((0.0, 10.0, 0.0)))

    closed, open_ = (filament(slit(width), FDM, notched=True).seconds for width in (0.08, 0.2))
    assert closed == pytest.approx(filament(box(30.0, 20.0), FDM).seconds, rel=0.02)
    assert open_ > 1.03 * closed


def test_higher_layers_than_the_part_are_one_layer() -> None:
    """No layer's middle is in it then: as much as the slicer says, nothing."""
    assert filament(box(30.0, 20.0, 0.3), changed(layer=2.0)).seconds == 0.0
    assert filament(box(30.0, 20.0, 1.2), changed(layer=2.0)).volume > 0.0
