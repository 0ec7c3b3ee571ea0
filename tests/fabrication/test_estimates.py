"""What a mold takes: material, time, cost and plates of prints and of what is cut, by hand.

Sheets, orders and lists that say it are in tests/golden; slicers' own estimates in consumers.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
import trimesh
from manifold3d import CrossSection

import skincad
from skincad.base import InputError
from skincad.fabrication import Job, by_part, laid, laid_on_end, mesh, print_chord
from skincad.fabrication.estimates import (
    contour_moves,
    estimates,
    exposure_time,
    filament,
    fill_moves,
    machining,
    moves,
)
from skincad.fabrication.meshes import BedPart, plates
from skincad.inputs import Process, processes
from skincad.shape import Point, loop
from skincad.solids import Bore, Part, PartRole, Prism, RevolvedBody, box, plain
from skincad.solids.mold import mold
from tests.designs import SHIPPED, of_one_printer

CNC, EDM, FDM, SLA = (processes()[name] for name in ("cnc", "edm", "fdm", "sla"))  # SLA's bed: 120 x 68 mm
FIRM = 1000.0  # mm/s2
HEIGHT = 10.0  # mm, 50 layers of 0.2
JERK, OVERLAP = 10.0, 0.25  # mm/s, of a line: PrusaSlicer's own
DIAGONAL = math.sqrt(2.0)
BLOCK = Part("cover", PartRole.COVER, box(20.0, (-10.0, 10.0), (0.0, 5.0)))  # 40 x 20 x 5
HOLES = tuple(Bore((x, 0.0, 0.0), "z", 5.0, 1.5) for x in (-5.0, 5.0))


@cache
def estimated(name: str, *settings: str) -> tuple[Any, ...]:
    """The estimates by process of a template whose parts come from one printer."""
    job = Job(of_one_printer(name, settings))
    parts = [part for part in job.closed.parts if part.made == "made"]
    chord = print_chord(job.design)
    return estimates(job, {p.name: laid(mesh(p, chord), laid_on_end(job, p), p) for p in parts})


@pytest.mark.parametrize("name", SHIPPED)
def test_every_made_part_has_estimates_with_errors(name: str) -> None:
    processes = estimated(name)
    assert sorted(by_part(processes)) == sorted(
        p.name for p in mold(of_one_printer(name)).parts if p.made == "made"
    )
    for estimate in (*processes, *by_part(processes).values()):
        for number in (estimate.mass, estimate.time, estimate.cost):
            assert 0 < number.error < float(number)
    for estimate in processes:
        assert float(estimate.mass) == pytest.approx(sum(float(part.mass) for part in estimate.parts))
        assert float(estimate.cost) == pytest.approx(sum(float(part.cost) for part in estimate.parts))


def test_resin_takes_the_tallest_part_of_each_plate() -> None:
    """lab-bench: the cavity, 23.1 mm high, and what lies beside it; the cover does not fit there."""
    (resin,) = estimated("lab-bench")
    assert resin.plates == 2
    assert float(resin.time) == pytest.approx((exposure_time(23.1, SLA) + exposure_time(4.0, SLA)) / 3600)
    assert float(resin.time) < sum(float(part.time) for part in resin.parts)
    (one,) = estimated("lab-bench", "printer.sla.build_y=120.0")
    assert one.plates == 1
    assert float(one.time) == pytest.approx(exposure_time(23.1, SLA) / 3600)


def test_filament_takes_all_parts_one_after_the_other() -> None:
    (printed,) = estimated("nozzle-04")
    assert printed.plates == 1
    assert float(printed.time) == pytest.approx(sum(float(part.time) for part in printed.parts))


def test_parts_of_two_processes_are_told_apart() -> None:
    rows = [(estimate.process, len(estimate.parts), estimate.plates) for estimate in estimated("milled-pad")]
    assert rows == [("cnc", 3, 0), ("edm", 4, 0)]


def test_cost_is_material_machine_and_setup() -> None:
    """Of lab-bench by hand; and where prices are known, its error is that of mass and time."""
    (resin,) = estimated("lab-bench")
    material = float(resin.mass) / 1000 * (1 + SLA.waste) * SLA.price
    machine, setup = float(resin.time) * SLA.rate, resin.plates * SLA.setup / 60 * SLA.rate
    assert float(resin.cost) == pytest.approx(material + machine + setup)
    (sure,) = estimated("lab-bench", "printer.sla.price_error=0.0")
    assert sure.cost.error == pytest.approx(material * SLA.mass_error + machine * SLA.time_error)
    (shipped,) = estimated("lab-bench")
    (priced,) = estimated("lab-bench", "printer.sla.price=0.0", "printer.sla.rate=20.0")
    setup, hours = 2 * 45 / 60, float(shipped.time)
    assert float(priced.cost) == pytest.approx(20.0 * (hours + setup))
    assert priced.mass == shipped.mass


@pytest.mark.parametrize(
    ("key", "value"),
    [("density", 0.0), ("infill", 1.5), ("loops", 0), ("loops", 2.5), ("outer_speed", 0.0), ("price", -1.0)],
)
def test_bad_keys_are_refused(key: str, value: float) -> None:
    with pytest.raises(InputError, match=rf"^printer.fdm.{key}: "):
        of_one_printer("nozzle-04", [f"printer.fdm.{key}={value}"])


HALF = (120.0 - 5.0) / 2  # mm: 5 mm lie between parts
LOW, HIGH, FLAT = (
    BedPart("low", 100.0, 50.0, 2.0), BedPart("high", 100.0, 50.0, 9.0), BedPart("flat", 100.0, 10.0, 1.0)
)  # fmt: skip


@pytest.mark.parametrize(
    ("parts", "names"),
    [
        ([BedPart("a", HALF, 57.0, 5.0), BedPart("b", HALF, 57.0, 9.0)], [["b", "a"]]),  # they just fit
        ([BedPart("a", HALF + 0.1, 40.0, 5.0), BedPart("b", HALF, 40.0, 5.0)], [["a"], ["b"]]),
        # rows lie behind each other: 3 x 17 and 2 x 5 are 61 of 68 mm
        ([BedPart(name, 100.0, 17.0, 4.0) for name in "abcd"], [["a", "b", "c"], ["d"]]),
        ([BedPart("a", 60.0, 118.0, 4.0)], [["a"]]),  # as it fits: turned
        # the tallest go first, and the order given doesn't matter
        ([LOW, HIGH, FLAT], [["high", "flat"], ["low"]]),
        ([FLAT, HIGH, LOW], [["high", "flat"], ["low"]]),
        # what no plate takes is alone
        ([BedPart("big", 200.0, 10.0, 4.0), BedPart("a", 10.0, 10.0, 4.0)], [["a"], ["big"]]),
    ],
)
def test_parts_share_plates_as_they_fit(parts: list[BedPart], names: list[list[str]]) -> None:
    assert [[part.name for part in plate] for plate in plates(parts, SLA)] == names


@pytest.mark.parametrize("key", ["build_x", "build_y"])
def test_no_limit_is_one_plate(key: str) -> None:
    boundless = SLA.model_copy(update={key: 0.0})
    assert len(plates([BedPart(name, 100.0, 60.0, 4.0) for name in "abc"], boundless)) == 1


def counted(layers: int) -> float:
    """As PrusaSlicer counts: three layers at the first exposure, then each by a step less."""
    usual, first = SLA.exposure, SLA.first_exposure
    step, total, exposure = (first - usual) / (SLA.fading + 1), 0.0, first
    for layer in range(layers):
        if layer >= SLA.first_layers:
            exposure = max(usual, exposure - step)
        total += exposure + SLA.lift
    return total


@pytest.mark.parametrize("layers", [1, 2, 3, 4, 12, 13, 14, 80, 461])
def test_layers_fade_to_the_usual_exposure(layers: int) -> None:
    assert exposure_time(layers * SLA.layer, SLA) == pytest.approx(counted(layers))


def test_the_least_print_is_one_layer() -> None:
    assert exposure_time(0.01, SLA) == SLA.first_exposure + SLA.lift


def stepped(length: float, speed: float, corner: float) -> float:
    """The same by small steps of way: at each, the least of what start, end and the machine allow."""
    way = (np.arange(200_000) + 0.5) / 200_000 * length
    fast = np.sqrt(corner**2 + 2 * FIRM * np.minimum(way, length - way))
    return float((length / 200_000 / np.minimum(fast, speed)).sum())


@pytest.mark.parametrize("length", [0.3, 2.0, 6.3, 40.0])
def test_a_move_is_what_small_steps_give(length: float) -> None:
    assert moves(length, 1, 80.0, 10.0, FIRM) == pytest.approx(stepped(length, 80.0, 10.0), rel=1e-4)  # steps
    assert moves(3 * length, 3, 80.0, 10.0, FIRM) == pytest.approx(3 * moves(length, 1, 80.0, 10.0, FIRM))


def test_nothing_takes_no_time() -> None:
    assert moves(0.0, 3, 80.0, 10.0, FIRM) == moves(5.0, 0, 80.0, 10.0, FIRM) == 0.0
    assert fill_moves(CrossSection(), 0.4, 80.0, FIRM) == (0.0, 0.0, 0.0)
    assert contour_moves(CrossSection(), 45.0, FIRM) == (0.0, 0.0)


def test_ways_along_contours_by_hand() -> None:
    """A square is four moves between corners, a circle has none but its begin."""
    length, seconds = contour_moves(CrossSection.square((20.0, 20.0)), 45.0, FIRM)
    assert length == pytest.approx(80.0)
    assert seconds == pytest.approx(moves(80.0, 4, 45.0, JERK, FIRM))
    length, seconds = contour_moves(CrossSection.circle(10.0, 400), 45.0, FIRM)
    assert length == pytest.approx(2 * math.pi * 10.0, rel=1e-4)  # 400 chords
    begun_and_ended = 2 * (45.0 - JERK) ** 2 / (2 * FIRM * 45.0)
    # a chord alone can't reach that speed: twice (45 - 10) / 1000 s less what those ways take anyhow
    assert seconds == pytest.approx(length / 45.0 + begun_and_ended, abs=0.04)
    two = CrossSection.square((20.0, 20.0)) + CrossSection.circle(3.0, 24).translate((40.0, 0.0))
    alone = [contour_moves(contour, 45.0, FIRM) for contour in two.decompose()]
    assert contour_moves(two, 45.0, FIRM) == pytest.approx(tuple(map(sum, zip(*alone, strict=True))))


def test_lines_fill_a_rectangle_less_its_hole() -> None:
    count, length, seconds = fill_moves(CrossSection.square((30.0, 10.0)), 0.4, 80.0, FIRM)
    assert count == pytest.approx(40.0 / DIAGONAL / 0.4)  # its width across the diagonal
    assert length == pytest.approx(300.0 / 0.4)
    corner = JERK * DIAGONAL
    link = moves(DIAGONAL * 0.4 * count, count, 80.0, corner, FIRM)
    assert seconds == pytest.approx(moves(length, count, 80.0, corner, FIRM) + link)
    holed = CrossSection.square((30.0, 10.0)) - CrossSection.circle(2.0, 400).translate((15.0, 5.0))
    assert fill_moves(holed, 0.4, 80.0, FIRM)[0] == pytest.approx(count + 4.0 / 0.4, rel=1e-4)  # its diameter


def changed(**keys: float) -> Process:
    return FDM.model_copy(update=keys)


def block(x: float, y: float, z: float = HEIGHT) -> trimesh.Trimesh:
    shape = trimesh.creation.box((x, y, z))
    shape.apply_translation((0.0, 0.0, z / 2))
    return shape


def spacing(process: Process) -> float:
    """How far apart lines lie that are rectangles with half circles at their sides, mm."""
    return process.line - (1 - math.pi / 4) * process.layer


def layer_of_box(x: float, y: float, process: Process, bottom: bool) -> float:
    """Seconds of a solid layer of a rectangle, written out."""
    pitch, firm, seconds = spacing(process), process.acceleration, 0.0
    for ring in range(process.loops):
        in_by = process.line + 2 * ring * pitch
        speed = process.outer_speed if ring == 0 else process.loop_speed
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
    effort = filament(block(x, y), FDM)
    by_hand = layer_of_box(x, y, FDM, bottom=True) + 49 * layer_of_box(x, y, FDM, bottom=False)
    assert effort.seconds == pytest.approx(by_hand, rel=1e-6)  # single precision of the manifold's corners


def test_a_solid_print_holds_its_volume() -> None:
    """Less the corners' roundness, and more by what filling overlaps the loops: 1.5 % of 600 mm2."""
    assert filament(block(30.0, 20.0), FDM).volume == pytest.approx(6000.0, rel=0.02)
    cylinder = trimesh.creation.cylinder(12.0, HEIGHT, sections=120)
    cylinder.apply_translation((0.0, 0.0, HEIGHT / 2))
    assert filament(cylinder, FDM).volume == pytest.approx(math.pi * 144.0 * HEIGHT, rel=0.02)


def test_inside_of_a_sparse_box() -> None:
    """Four solid layers below and above; between, loops are solid, and of the rest a share, with links."""
    sparse, solid = filament(block(30.0, 20.0), changed(infill=0.25)), filament(block(30.0, 20.0), FDM)
    pitch = spacing(FDM)
    in_by = FDM.line + (2 * FDM.loops - 1) * pitch - 2 * OVERLAP * FDM.line
    wide, deep = 30.0 - in_by, 20.0 - in_by
    links = (wide + deep) / DIAGONAL / (pitch / 0.25) * DIAGONAL * (pitch / 0.25) * pitch  # mm2
    empty = 42 * FDM.layer * (0.75 * wide * deep - links)
    assert solid.volume - sparse.volume == pytest.approx(empty, rel=0.06)  # 16 of 50 layers are looked at
    assert sparse.seconds < solid.seconds


def test_a_patch_below_70_mm2_is_filled() -> None:
    small = changed(infill=0.25)
    assert filament(block(10.0, 10.0), small) == filament(block(10.0, 10.0), FDM)


@pytest.mark.parametrize("key", ["outer_speed", "loop_speed", "fill_speed", "first_speed", "acceleration"])
def test_each_speed_saves_time_and_no_material(key: str) -> None:
    usual, faster = (
        filament(block(30.0, 20.0), FDM),
        filament(block(30.0, 20.0), changed(**{key: 500.0 + 1000.0})),
    )
    assert faster.seconds < usual.seconds
    assert faster.volume == usual.volume


def test_slow_ways_take_longer() -> None:
    """Faster than 180 mm/s no way here is: the nozzle never gets there."""
    slow = filament(block(30.0, 20.0), changed(travel_speed=30.0))
    assert slow.seconds > filament(block(30.0, 20.0), FDM).seconds


def test_slits_that_a_slicer_closes_have_no_loops() -> None:
    """0.08 mm wide, 5 mm deep: below the 0.098 mm that are closed; of 0.2 mm they stay."""

    def slit(width: float) -> trimesh.Trimesh:
        return block(30.0, 20.0).difference(block(width, 10.0).apply_translation((0.0, 10.0, 0.0)))

    closed, open_ = (filament(slit(width), FDM, notched=True).seconds for width in (0.08, 0.2))
    assert closed == pytest.approx(filament(block(30.0, 20.0), FDM).seconds, rel=0.02)
    assert open_ > 1.03 * closed


def test_higher_layers_than_the_part_are_one_layer() -> None:
    """No layer's middle is in it then: as much as the slicer says, nothing."""
    assert filament(block(30.0, 20.0, 0.3), changed(layer=2.0)).seconds == 0.0
    assert filament(block(30.0, 20.0, 1.2), changed(layer=2.0)).volume > 0.0


def test_a_block_by_mill_by_wire_and_with_holes() -> None:
    stock = 44.0 * 24.0 * 9.0
    faces = 2 * (40.0 * 20.0 + 40.0 * 5.0 + 20.0 * 5.0)
    effort = machining(BLOCK, CNC)
    assert effort.volume == pytest.approx(stock)
    minutes = (stock - 4000.0) / CNC.removal_rate + faces / CNC.finish_rate
    assert effort.seconds == pytest.approx(60 * minutes)
    effort = machining(BLOCK, EDM)
    assert effort.volume == pytest.approx(46.0 * 26.0 * 11.0)
    assert effort.seconds == pytest.approx(60 * (120.0 * 5.0 / EDM.finish_rate))
    drilled = Part("cover", PartRole.COVER, BLOCK.body, HOLES)
    more = machining(drilled, EDM).seconds - machining(BLOCK, EDM).seconds
    assert more == pytest.approx(60 * 2 * EDM.hole_time)


def test_notches_of_a_comb_are_cut_by_the_fine_wire() -> None:
    """Two notches of 0.1 x 1 mm: four walls; their bottoms are as long as what they take from the edge."""
    notches = [(20.1, 8), (20.1, 7), (20, 7), (20, 8), (10.1, 8), (10.1, 7), (10, 7), (10, 8)]
    outline = loop([Point(*map(float, p)) for p in [(0, 0), (30, 0), (30, 8), *notches, (0, 8)]])
    comb = Part("end-a-comb", PartRole.COMB, Prism(outline, "y", 0.0, 4.0))
    minutes = 76.0 * 4.0 / EDM.finish_rate + 4.0 * 4.0 / EDM.fine_rate
    assert machining(comb, EDM).seconds == pytest.approx(60 * minutes)


def test_the_skins_negative_is_cut_by_the_fine_tool() -> None:
    """A finer rate changes the cavity's time by the trough's own outline, and no lid's."""
    closed = mold(skincad.load("yamada-2002"))
    slower = EDM.model_copy(update={"fine_rate": EDM.fine_rate / 2})
    cavity, cover = closed.part("cavity"), closed.part("cover")
    assert machining(cover, slower) == machining(cover, EDM)
    assert isinstance(cavity.body, Prism)
    trough = math.fsum(s.length for s in cavity.body.outline if s.kind != "other")
    long = cavity.body.high - cavity.body.low
    more = machining(cavity, slower).seconds - machining(cavity, EDM).seconds
    assert more == pytest.approx(60 * trough * long / EDM.fine_rate)


def test_a_bowls_trough_is_fine_work_too() -> None:
    design = skincad.load("yamada-2002", ["skin.curvature_radius_y=60"])
    cavity, slower = mold(design).part("cavity"), CNC.model_copy(update={"fine_rate": CNC.fine_rate / 2})
    (trough,) = (cut for cut in map(plain, cavity.cuts) if isinstance(cut, RevolvedBody))
    long = trough.centre * (trough.high - trough.low)  # of its back's arc
    area = math.fsum(s.length for s in trough.outline if s.kind != "other") * abs(long)
    more = machining(cavity, slower).seconds - machining(cavity, CNC).seconds
    assert more == pytest.approx(60 * area / CNC.fine_rate)
    assert area > 11.0 * 12.0  # more than the skin's back
