"""Pins on flat and doubly curved skins, pockets, and the mold that casts them."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest
from manifold3d import Manifold

import skincad
from skincad.fabrication import Job, design_findings, listed_crests, manifold, mesh, printed_crests
from skincad.fabrication.part_drawing import part_drawing
from skincad.inputs import Design
from skincad.shape import skin_of
from skincad.solids import CutRole, PartRole, skin_part, solid, volume
from skincad.solids.mold import mold
from skincad.solids.skin import cast_skin
from tests import designs

DOMES = pytest.mark.evidence(subject="kernel: domes")


def one_pin(radius: float, along: float | None = None) -> Design:
    """A cylindrical pin with a hemisphere, alone in the middle of a skin."""
    skin = {"curvature_radius": radius, "thickness": 4.0, "width": 8.0, "length": 8.0}
    skin |= {"curvature_radius_y": along} if along else {}
    pin = {"pitch": 4.0, "columns": 1, "rows": 1, "height": 3.0, "root_diameter": 2.0, "tip_diameter": 2.0}
    rest = {"material": {"name": "dragon-skin-20"}, "mold": {"process": "sla"}}
    return skincad.Design(name="one", skin=skin, pin={**pin, "crown": 1.0}, **rest)


def test_a_pin_on_a_sphere_counts_from_the_sphere_on_and_turns_with_its_mold() -> None:
    (pin,) = skin_part(one_pin(10.0, 10.0)).adds
    height = 10 - math.sqrt(10**2 - 1)  # of the cap under its foot, whose volume the cylinder there leaves
    filled = math.pi * height - math.pi * height**2 * (10 - height / 3)
    # height over the tangent plane is 3, so cylinder 2 and hemisphere; quadrature exact to rounding
    assert pin.volume == pytest.approx(2 * math.pi + 2 / 3 * math.pi + filled, rel=1e-12)
    design = designs.pillars().with_(pin={"heights": [4.0 + 0.1 * i for i in range(9)]})
    for pin, negative in zip(skin_part(design).adds, cast_skin(design).adds, strict=True):
        x, y, z = pin.origin
        assert negative.origin == (x, -y, -z)  # mirrored would make another skin of unequal pins


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "levelling"), [("pillars", None), *(pytest.param("dome", by, marks=DOMES) for by in (None, 0.7))]
)
def test_skin_has_its_formulas_volume_by_kernel_and_mesh(name: str, levelling: float | None) -> None:
    design = designs.OF_FAMILIES[name]().with_(pin={"levelling": levelling})
    for part in (skin_part(design), cast_skin(design)):
        shape = solid(part)  # which checks its volume against the formula to 1e-9
        assert volume(part, shape) == pytest.approx(part.volume, rel=2e-9)
        assert len(shape.Solids()) == 1
        errors = [manifold(part, chord).volume() - part.volume for chord in (4e-3, 4e-4)]
        # chords within c of the surface move the volume by less than c times the area
        assert abs(errors[1]) < 4e-4 * shape.Area()
        assert abs(errors[1]) < abs(errors[0]) / 5


@pytest.mark.slow
@pytest.mark.parametrize("name", ["pillars", pytest.param("dome", marks=DOMES)])
def test_cavity_less_its_skin_is_empty(name: str) -> None:
    closed = mold(designs.OF_FAMILIES[name]())
    skin, cavity = closed.first(PartRole.SKIN), closed.first(PartRole.CAVITY)
    negatives = [cut for cut in cavity.cuts if cut.role is CutRole.FEATURE]
    assert math.fsum(n.volume for n in negatives) == pytest.approx(
        math.fsum(pin.volume for pin in skin.adds), rel=1e-12
    )
    assert (manifold(skin, 1e-2) ^ manifold(cavity, 1e-2)).volume() < 1e-6  # rounding of faces that touch


def test_pockets_are_blind_holes_from_a_flat_back() -> None:
    design = designs.flat()
    part, bare = skin_part(design), skin_part(design.with_(flat={"pocket": None}))
    assert bare.volume - part.volume == pytest.approx(4 * math.pi * 1.05**2 * 2.0, rel=1e-12)
    assert {cut.role for cut in part.cuts} == {CutRole.POCKET}
    solid(part)
    at_vent = {"pitch": 15.6, "pocket": {"diameter": 3.0, "depth": 2.0}, "columns": 1}
    with pytest.raises(skincad.InputError, match=r"pocket: puts a core pin at \(0, 7.8"):
        mold(design.with_(flat=at_vent))


def test_pockets_end_on_a_level_and_begin_at_a_bent_back() -> None:
    """The back's rise over a disc by its series, y2 / 2R + y4 / 8R3 and their means over the disc; the next
    term is 6e-7 mm of 2.1."""
    design = designs.flat().with_(skin={"curvature_radius_y": 60.0})
    part, bare = skin_part(design), skin_part(design.with_(flat={"pocket": None}))
    arm, r = 60.0 - design.skin.thickness, 1.05
    y = 60.0 * math.sin(design.features.pitch / 2 / 60.0)
    rise = (y**2 + r**2 / 4) / (2 * arm) + (y**4 + 1.5 * y**2 * r**2 + r**4 / 8) / (8 * arm**3)
    assert bare.volume - part.volume == pytest.approx(4 * math.pi * r**2 * (2.0 + rise), rel=1e-6)
    assert manifold(part, 1e-3).bounding_box()[2] == pytest.approx(
        -(arm - arm * math.cos(design.skin.length / 120)), abs=1e-3
    )
    tops = {round(point[2], 9) for point in mesh(mold(design).part("core-pin-1"), 1e-3).vertices}
    assert -2.0 / (1 - Job(design).shrinkage) == pytest.approx(min(tops), abs=1e-9)


@pytest.mark.parametrize("seed", range(40))
def test_a_pocket_in_a_pin_that_leans_keeps_its_wall_or_is_refused(seed: int) -> None:
    """By meshes, another way than the rule: the pocket, wider by its wall, lies in the skin without it."""
    dice = np.random.default_rng(seed)
    radius, tip = float(dice.uniform(12.0, 80.0)), float(dice.uniform(2.4, 4.0))
    skin = {"curvature_radius": radius, "thickness": 4.0, "width": 16.0, "length": 8.0}
    pocket = {"diameter": float(dice.uniform(0.6, tip - 0.8)), "depth": float(dice.uniform(2.0, 6.5))}
    pin = {"pitch": 5.5, "columns": 3, "rows": 1, "heights": None, "height": 4.0, "pocket": pocket}
    pin |= {"root_diameter": tip + 0.3, "tip_diameter": tip, "crown": 0.3}
    bare = designs.pillars().with_(skin=skin, pin={**pin, "pocket": None})
    body = manifold(skin_part(bare), 1e-3)

    def inside(wall: float) -> bool:
        """Whether the pockets, with so much silicone beside and 0.25 mm over them, lie in the skin."""
        rods = [
            Manifold.cylinder(
                pocket["depth"] + 0.25, pocket["diameter"] / 2 + wall, circular_segments=64
            ).translate((*placed.tip[:2], 0.0))
            for placed in skin_of(bare).placed
        ]
        return all((rod - body).volume() < 1e-6 for rod in rods)

    if inside(0.29):  # less the chords of the meshes
        with suppress(skincad.InputError):
            skin_part(bare.with_(pin={"pocket": pocket}))
            return
        # a wall is measured square to the pin's axis, and to the pin without the fillet at its root
        assert not inside(0.3 / math.cos(8.0 / radius) + 0.2)
    else:
        with pytest.raises(skincad.InputError, match=r"pin\.pocket"):
            skin_part(bare.with_(pin={"pocket": pocket}))


@DOMES
def test_hundreds_of_nibs_are_one_solid() -> None:
    pin = {"pattern": "hex", "pitch": 1.2, "margin": 0.6, "height": 0.4, "root_diameter": 0.8}
    pin |= {"tip_diameter": 0.5, "crown": 0.08, "root_fillet": 0.1}
    skin = {"curvature_radius": 1e8, "thickness": 2.0, "width": 24.0, "length": 24.0}
    part = skin_part(skincad.Design(name="nibs", skin=skin, pin=pin, material={"name": "dragon-skin-20"}))
    assert len(part.adds) == 389
    assert len(solid(part).Faces()) == 6 + 3 * 389  # fillet, flank and crown of each


def test_core_pins_stand_in_the_carrier_and_leave_with_it() -> None:
    closed = mold(designs.flat())
    carrier, cores = closed.first(PartRole.CARRIER), closed.of(PartRole.CORE_PIN)
    assert len(cores) == 4
    holes = [cut for cut in carrier.cuts if cut.role is CutRole.CORE]
    # a pocket's volume is the rod's under the carrier; over it 8 mm stand for pliers, in wider holes
    area = math.pi * (designs.flat().flat.pocket.diameter / 2) ** 2
    rods = math.fsum(core.volume for core in cores)
    pockets = [cut for cut in closed.first(PartRole.SKIN).cuts if cut.role is CutRole.POCKET]
    above = 4 * area * (holes[0].length + 8.0)
    assert rods == pytest.approx(math.fsum(cut.volume for cut in pockets) + above, rel=1e-12)
    assert {round(2 * hole.radius, 6) for hole in holes} == {1.9}  # of a print, to be reamed to 2.1
    for lid in (PartRole.COVER, PartRole.SEAL):
        round_pins = [cut for cut in closed.first(lid).cuts if cut.role is CutRole.ACCESS]
        assert {round(2 * hole.radius, 6) for hole in round_pins} == {2.7}
        assert len(round_pins) == 4
    assert {core.name for core in cores} <= set(closed.opening[-1].parts)


def test_a_wire_makes_no_blind_holes_and_a_mill_no_deep_ones() -> None:
    by_wire, milled, printed = (
        {f.rule: f for f in design_findings(Job(designs.pillars().with_(mold={"process": name})))}
        for name in ("edm", "cnc", "sla")
    )
    assert by_wire["tool reach"].severity == "error"
    assert "blind holes of 9 pins" in by_wire["tool reach"].where
    assert milled["tool depth"].where == "cavity, groove of pin 5's tip, by cnc"
    assert not {"tool reach", "tool depth"} & printed.keys()


@pytest.mark.parametrize("split", ["none", "tips"])
def test_thin_walls_between_pins_and_deep_holes_name_key_limit_and_remedy(split: str) -> None:
    """Nibs 1.2 mm apart: 0.05 mm are left between roots of 1.15, and a hole of 3 mm is for a tool of 0.5."""
    nibs = skincad.load("nibs-fine").with_(skin={"width": 5.0, "length": 5.0}, mold={"split": split})
    narrow = nibs.with_(pin={"root_diameter": 1.15, "root_fillet": 0.0})
    high = nibs.with_(pin={"height": 3.0, "crown": 0.05}, mold={"process": "cnc"})
    thin, deep = ({f.rule: f for f in design_findings(Job(design))} for design in (narrow, high))
    assert (thin["wall"].measured, thin["wall"].limit) == (pytest.approx(0.05), 0.1)
    assert "pin.pitch of at least 1.25 mm" in thin["wall"].remedy
    assert "pin.height of at most 2.2 mm" in deep["slender"].remedy
    assert "pin.height of at most 2 mm" in deep["tool depth"].remedy


@pytest.mark.slow
def test_one_finding_tells_of_all_leaning_pins_of_a_dome() -> None:
    pin = {"root_diameter": 0.7, "tip_diameter": 0.65, "rings": 6, "pitch": 1.2}
    design = designs.dome().with_(pin=pin)
    findings = [f for f in design_findings(Job(design)) if f.rule == "undercut"]
    undercuts = [u for u in skin_of(design).undercuts.values() if u.width > 0]
    assert [f"and {len(undercuts) - 1} more" in f.where for f in findings] == [True]
    assert max(f.measured for f in findings) == max(u.strain for u in undercuts)
    assert all(" at x " in f.where for f in findings)


def test_printed_pins_end_at_layers() -> None:
    job = Job(designs.pillars())
    layer = job.cavity_process.layer
    for crest in printed_crests(job) or ():
        layers = crest / (1 - job.shrinkage) / layer
        assert layers == pytest.approx(round(layers), abs=1e-6)
    off = [a - b for a, b in zip(printed_crests(job) or (), job.skin.crests, strict=True)]
    assert max(map(abs, off)) < 1.5 * layer  # a hole ends at the first layer whose middle it is in
    # hundreds of crests are not listed one by one
    assert listed_crests(range(1, 65)).endswith(", 64")
    assert listed_crests(range(1, 390)) == "1, 2, 3, 4, 5, 6 and 383 more"


@pytest.mark.parametrize("pin", [{}, {"heights": [4.0, 3.6]}])
def test_a_plate_of_through_holes_lies_on_a_base_of_cups(pin: dict[str, list[float]]) -> None:
    design = designs.pillars().with_(pin=pin, mold={"split": "tips"})
    closed, block = mold(design), mold(design.with_(mold={"split": "none"}))
    plate, base = closed.first(PartRole.CAVITY), closed.first(PartRole.BASE)
    pieces = [cut.volume for part in (plate, base) for cut in part.cuts if cut.role is CutRole.FEATURE]
    whole = [cut.volume for cut in block.first(PartRole.CAVITY).cuts if cut.role is CutRole.FEATURE]
    # a split loop's moments add up but for rounding
    assert math.fsum(pieces) == pytest.approx(math.fsum(whole), rel=1e-12)
    assert manifold(plate, 4e-3).genus() - manifold(replace(plate, cuts=plate.cuts[:-9]), 4e-3).genus() == 9
    base_off, skin_out = closed.opening[-2:]
    assert base.name in base_off.parts
    assert base_off.travel < 0 < skin_out.travel


def test_split_auto_is_of_ridges_and_of_holes_that_a_tool_makes() -> None:
    with pytest.raises(skincad.InputError, match="split: must be 'none' here"):
        mold(designs.flat().with_(mold={"split": "auto"}))
    for process, split in (("sla", False), ("cnc", True)):
        closed = mold(designs.pillars().with_(mold={"split": "auto", "process": process}))
        assert bool(closed.of(PartRole.BASE)) == split
    for pins in (designs.dome(), designs.pillars().with_(skin={"curvature_radius": 60.0})):
        with pytest.raises(skincad.InputError, match="split: needs pins on a flat base"):
            mold(pins.with_(mold={"split": "tips"}))


@pytest.mark.slow
def test_plate_and_base_are_drawn_and_cast_from() -> None:
    job = Job(designs.pillars().with_(mold={"split": "auto", "process": "cnc"}))
    plate, base = job.closed.first(PartRole.CAVITY), job.closed.first(PartRole.BASE)
    tables = [part_drawing(job, part, solid(part), None).tables[-1] for part in (plate, base)]
    assert [t.title.partition(" of ")[0] for t in tables] == ["Through holes", "Cups for the tips"]
    scale = 1 / (1 - job.shrinkage)
    # the middle pin is 0.5 mm higher, and its cup as much deeper than a crown of 1.5
    assert [float(row[-1]) for row in tables[1].rows] == pytest.approx([1.5 * scale, 2.0 * scale], abs=1e-3)
    assert [float(row[-1]) for row in tables[0].rows] == pytest.approx([4.0 * scale], abs=1e-3)
    half = (plate.body.outline[0].start.x, plate.body.high)
    x, y = half[0] - 5.0 * scale, half[1] + 5.0 * scale  # pin 1, from the left and lower edge of the top view
    assert f"pin 1 at x {x:.3f}, y {y:.3f}" in tables[0].title
    assert not {f.rule for f in design_findings(job)} & {"tool depth"}
