"""Screws as the standard has them, with thread enough to hold and room below their tips."""

from __future__ import annotations

import math
import re

import pytest

import skincad
from skincad.fabrication import Job, casting_sheet
from skincad.inputs import PROCESSES, processes
from skincad.solids import (
    CAVITIES,
    END_PLATES,
    LENGTHS,
    CutRole,
    PartRole,
    bores,
    screw_for,
    standard_length,
    torque,
)
from skincad.solids.fasteners import DIAMETER, blind_depth, engagement
from skincad.solids.layout import block_process
from skincad.solids.mold import mold
from tests.bent_skin import three_ridges
from tests.families import RIDGED

LISTED = {5, 6, 8, 10, 12, 16, 20, 25, 30}  # ISO 4762, M3; a longer one is cut from a rod


@pytest.mark.parametrize("name", [*RIDGED, "bent"])
def test_every_screw_is_in_the_standard_and_ends_free_in_its_hole(name: str) -> None:
    """By the sheet's own words against the parts' bores: at least 1 mm free, and 2.5 more for the tap."""
    design = three_ridges() if name == "bent" else skincad.load(name)
    closed = mold(design)
    text = casting_sheet(Job(design, closed), [], "", True)
    lengths = [int(size) for size in re.findall(r"M3 x (\d+)", text)]
    assert len(lengths) == 2
    assert {length for length in lengths if length <= 30} <= LISTED
    assert (max(lengths) > 30) == ("studs, DIN 976" in text)
    cover, blocks = closed.first(PartRole.COVER), closed.of(*CAVITIES)
    ((count, long),) = re.findall(r"(\d+) M3 x (\d+) for the cover", text)
    assert int(count) == len(bores(cover, CutRole.COVER_BOLT))
    clamped = cover.body.high - cover.body.low
    clamped += max((b.length for p in blocks for b in bores(p, CutRole.COVER_BOLT)), default=0.0)
    hole = min(b.length for p in blocks for b in bores(p, CutRole.COVER_THREAD))
    washers = re.search(r"for the cover.*?, (\d+) washers", text)
    engaged = int(long) - clamped - (0.5 * int(washers[1]) if washers else 0.0)
    process = block_process(design)
    tap = 0.0 if closed.of(PartRole.BASE) or process.thread != "tapped" else 2.5  # a split base's are open
    assert hole - engaged >= 1.0 + tap - 1e-9
    assert engaged >= 1.25 * 3 - 1e-9
    if name != "bent":  # along y: through both plates, and a nut or the thread of the second
        ends = [p for p in closed.of(*END_PLATES) if p.end == "b"]
        tapped = any(bores(p, CutRole.END_THREAD) for p in ends)
        assert lengths[0] >= closed.length + 2 * design.mold.end_plate + (0.0 if tapped else 0.5)


def test_a_blind_hole_is_as_deep_as_its_screw_needs_and_no_deeper() -> None:
    known = processes()
    for name in PROCESSES:
        process = known[name]
        for clamped in (1.0, 4.0, 4.5, 10.0, 33.3):
            deep = blind_depth(clamped, process)
            long, washers = screw_for(clamped, deep, process)
            assert (long, washers) == (standard_length(clamped + engagement(process)), 0)
            assert screw_for(clamped, deep - 0.4, process)[1] <= 1
            if process.thread == "tapped":
                assert deep == pytest.approx(long - clamped + 1.0 + 2.5, abs=1e-12)
                assert screw_for(clamped, deep - 0.4, process) == (long, 1)  # a washer of 0.5 makes up for it
                assert screw_for(clamped, deep - 2.5, process, bottomed=True) == (long, 0)


def test_lengths_are_the_next_of_the_list_and_beyond_it_a_rods() -> None:
    assert set(LENGTHS) == LISTED
    assert [standard_length(v) for v in (1.0, 5.0, 5.01, 20.5, 30.0)] == [5.0, 5.0, 6.0, 25.0, 30.0]
    assert standard_length(133.2) == 134.0
    far = skincad.load("plain-ridges", ["skin.length=130"])
    assert "M3 studs, DIN 976, with a nut at both ends: 4 M3 x 143 through both end plates" in casting_sheet(
        Job(far), [], "", True
    )


def test_a_plate_too_thin_for_a_thread_has_nuts_behind_it() -> None:
    steel, thin = (skincad.load("yamada-2002", [f"mold.end_plate={t}"]) for t in (3.75, 3.7))
    for design, role in ((steel, CutRole.END_THREAD), (thin, CutRole.END_BOLT)):
        plate = mold(design).part("end-b-comb")
        assert len(bores(plate, role)) == 2
    assert "with nuts, 0 of them sunk" in casting_sheet(Job(thin), [], "", True)


def test_torque_is_what_the_head_bears() -> None:
    """0.2 d F, F by 20 MPa in plastic on the ring of a head of 5.5 mm round a hole of 3.4."""
    known, ring = processes(), math.pi / 4 * (5.5**2 - 3.4**2)
    assert torque(known["sla"]) == torque(known["fdm"]) == pytest.approx(0.2 * 3e-3 * 20 * ring, abs=0.01)
    assert torque(known["edm"]) == pytest.approx(0.2 * 3e-3 * 60 * ring, abs=0.01)
    assert "a torque of 0.17 N m" in casting_sheet(Job(*made_parts("lab-bench")), [], "", True)
    assert "a torque of 0.52 N m" in casting_sheet(Job(*made_parts("yamada-2002")), [], "", True)
    assert engagement(known["cnc"]) == 1.5 * DIAMETER


def made_parts(name: str) -> tuple[skincad.Design, skincad.solids.mold.ClosedMold]:
    design = skincad.load(name)
    return design, mold(design)


@pytest.mark.parametrize("cover", [4.0, 46.0])
def test_a_floor_stays_under_the_threads_of_the_thickest_cover(cover: float) -> None:
    """A screw of 55 for a cover of 46 goes 9 into the cavity: 10 of hole with an insert."""
    flat = skincad.load("plain-ridges", ["ridge.height=0.2", "mold.pour=open", f"mold.cover={cover}"])
    block = mold(flat).part("cavity")
    deep = {b.length for b in bores(block, CutRole.COVER_THREAD)}
    assert deep == {7.0} if cover == 4.0 else {10.0}
    bottom = min(s.start.z for s in block.body.outline)
    assert min(b.start[2] for b in bores(block, CutRole.COVER_THREAD)) - bottom >= 1.2
