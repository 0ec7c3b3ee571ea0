"""Round skins and their molds: what turns about z, and what only they refuse."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import shapely

from skincad.base import InputError
from skincad.fabrication import Job, design_findings, interference, manifold, mesh
from skincad.fabrication.filling import pockets
from skincad.shape import polygon, section, skin_of
from skincad.solids import CutRole, PartRole, bores, skin_part
from skincad.solids.mold import mold
from tests.designs import rings
from tests.solids.kinds import IN_A_BLOCK, round_flat

UNDER_GROOVES = 3.0  # mm of a disc under its deepest groove


def test_a_round_skin_is_a_cylinder_under_a_cap_or_turned_rings() -> None:
    design = round_flat()
    radius, half = 30.0, 7.0
    cap = radius - math.sqrt(radius**2 - half**2)
    handbook = math.pi * half**2 * (4.0 - cap) + math.pi * cap**2 * (3 * radius - cap) / 3
    assert skin_part(design).volume == pytest.approx(handbook, rel=1e-13)
    # By the section's polygon, cut at x = 0: another library's area and centroid, chords within 1e-6 mm
    design = rings()
    whole = shapely.Polygon(polygon(section(design).outline, 1e-6))
    half = whole.intersection(shapely.box(0.0, -1.0, 100.0, 100.0))
    turned = 2 * math.pi * half.centroid.x * half.area
    assert skin_part(design).volume == pytest.approx(turned, rel=1e-6)


def test_a_cavity_in_a_block_is_a_disc_of_the_same_trough() -> None:
    design = rings()
    whole, parted = mold(design), mold(design.with_(mold=IN_A_BLOCK))
    disc = parted.part("cavity")
    assert {*disc.cuts} == {cut for cut in whole.part("cavity").cuts if cut.role is CutRole.TROUGH}
    low, _, bottom, high, _, top = manifold(disc, 1e-3).bounding_box()
    least = -manifold(parted.part("skin"), 1e-3).bounding_box()[2] + UNDER_GROOVES
    assert top == 0.0
    assert least <= -bottom < least + 0.5  # a round height, in halves of a millimetre
    assert high - low == pytest.approx(parted.part("carrier").body.outline[0].chord, abs=1e-2)  # chords
    assert parted.opening[-1].parts == ("cavity",)


@pytest.mark.parametrize(
    ("tables", "where"),
    [
        ({"process": "edm"}, "cavity, a trough that turns"),
        ({"process": "lathe"}, "cavity, by a lathe"),
        ({"process": "lathe", "block_process": "lathe"}, "block, by a lathe"),
        ({"process": "lathe", "block_process": "sla"}, ""),
    ],
)
def test_what_a_wire_or_a_lathe_does_not_make_is_an_error(tables: dict[str, str], where: str) -> None:
    lathe = {"based_on": "cnc", "tool": "lathe", "tool_radius": 0.1, "groove_ratio": 0.0}
    design = rings().with_(printer={"lathe": lathe}, mold={"lid_process": "sla", **tables})
    errors = [f.where for f in design_findings(Job(design)) if f.severity == "error"]
    assert errors[0].startswith(where) if where else errors == [], errors


def test_a_skin_that_is_not_in_its_trough_shares_its_room() -> None:
    """Of a skin that lies 0.01 mm too low: what its sections say is touching is not taken for it."""
    design = rings()
    closed = mold(design)
    skin = closed.part("skin")
    area = manifold(skin, 1e-3).surface_area()
    larger = replace(skin, body=replace(skin.body, origin=(0.0, 0.0, -0.01)))
    parts = tuple(larger if part is skin else part for part in closed.parts)
    (finding,) = interference(replace(closed, parts=parts, opening=()), design.mold.clearance / 10)
    # a shift of 0.01 along z: of the area that looks down, the back's by its shadow, at least half of all
    assert 0.3 * area * 0.01 < finding.measured < 0.5 * area * 0.01


def test_the_mold_has_no_ends_and_its_vent_stands_at_the_skins_rim() -> None:
    closed = mold(rings())
    assert not closed.of(PartRole.END_PLATE, PartRole.COMB, PartRole.KEEPER, PartRole.END_PIN)
    (vent,) = bores(closed.part("carrier"), CutRole.VENT)
    (trough,) = (cut for cut in closed.part("cavity").cuts if cut.role is CutRole.TROUGH)
    rim = manifold(closed.part("skin"), 1e-3).bounding_box()[4]
    assert trough.volume == closed.part("skin").volume
    assert vent.start[1] + vent.radius == pytest.approx(rim, abs=2e-3)
    # grooves are as deep as the rings are high and the silicone shrinks
    design = rings()
    points = np.asarray(mesh(closed.part("cavity"), 1e-3).vertices)
    grown, skin = 1 / (1 - Job(design).shrinkage), skin_of(design)
    radii = np.hypot(points[:, 0], points[:, 1])
    for placed in skin.placed:
        near = np.abs(radii - placed.summit.x * grown) < skin.profile.tip_width / 4
        crown = max(s.top for s in placed.outline)
        assert points[near, 2].min() == pytest.approx(-crown * grown, abs=2e-3)  # two chords


def test_holes_of_the_carrier_keep_off_its_rim() -> None:
    mount = {"thread": "M3", "diameter": 22.0, "pin": 2.0, "fiducials": 3}
    design = rings().with_(skin={"width": 34.0}, mount=mount)
    carrier = mold(design).part("carrier")
    radius = manifold(carrier, 1e-4).bounding_box()[3]
    roles = {bore.role for bore in bores(carrier)}
    assert roles >= {CutRole.RIVET, CutRole.PULL, CutRole.MOUNT, CutRole.MOUNT_PIN, CutRole.FIDUCIAL}
    for bore in bores(carrier):
        assert radius - math.hypot(*bore.start[:2]) - bore.far_radius > 1.199, bore  # layout's EDGE, chords


@pytest.mark.slow
def test_air_leaves_by_the_vent_and_stays_where_end_b_is_low() -> None:
    """By the wedges of the turned skin: tilted, the back's highest place is at the vent, at the rim."""
    job = Job(rings().with_(mold={"carrier": "plain"}))
    assert pockets(job, 10.0) == ()
    # end b down by 10 deg: air up to the vent's level, at most a wedge of the back, 16 mm x tan(10 deg) high
    (air,) = (p for p in pockets(job, -10.0) if p.harm == "body")
    assert air.place[1] < 0
    assert air.height == pytest.approx(
        15.0 * math.sin(math.radians(10.0)), rel=0.02
    )  # vent's far side to rim


@pytest.mark.parametrize(
    ("change", "start", "rule"),
    [
        ({"mold": {"pour": "syringe"}}, "mold.pour", "poured open"),
        ({"mold": {"gate": 2.0}}, "mold.gate", "poured open"),
        ({"mold": {"cavities": 2}}, "mold.cavities", "must be 1"),
        ({"mold": {"block_process": "edd"}}, "mold.block_process", "must be"),
        ({"mold": {"split": "auto"}}, "mold.split", "must be 'none'"),
        ({"mold": {"reservoir": 40.0}}, "mold.reservoir", "clear of the bolts"),
        ({"mount": {"thread": "M3", "diameter": 19.0}}, "mount.diameter", "at most"),
        ({"ring": {"radius": 0.5}}, "ring.radius", "closes over its middle"),
        ({"ring": {"count": 9}}, "ring.count", "fit on skin.width"),
        ({"ring": {"root_width": 2.5, "radius": 3.0, "count": 2}}, "ring.root_width", "must be less than"),
        ({"skin": {"outline": "rectangle", "length": 16.0}}, "skin.outline", "must be 'round' for rings"),
        ({"skin": {"length": 12.0}}, "skin.length", "of a round skin"),
    ],
)
def test_what_a_round_mold_cannot_be_is_one_line(change: dict[str, object], start: str, rule: str) -> None:
    with pytest.raises(InputError, match=f"^{start}: .*{rule}") as refusal:
        mold(rings().with_(**change))
    assert "\n" not in str(refusal.value)


def test_thin_walls_between_rings_are_a_warning_with_their_width() -> None:
    """The tooth of the mold between two rings is their pitch less a root."""
    design = rings().with_(ring={"root_width": 1.7, "root_fillet": 0.1}, mold={"process": "fdm"})
    (thin,) = (f for f in design_findings(Job(design)) if f.rule == "wall")
    assert thin.measured == pytest.approx(0.3)
    assert "two rings' roots" in thin.where
