"""The metal on both faces of a strip, and how tabs are spread to a board."""

from __future__ import annotations

import math
import re

import pytest

import skincad
from skincad.fabrication import Finding, Job, design_findings, electrode_findings, fan_out, sheet_steps
from skincad.fabrication.electrodes import faces, half_gap, half_tab, tab
from skincad.inputs import Design
from skincad.shape import area, section
from skincad.solids import BEND, MOST_TURN
from tests.designs import SHIPPED

PITCH = 2.54  # mm, of pads and pins
FILMED = [name for name in SHIPPED if skincad.load(str(name.values[0])).film]


def by_rule(design: Design) -> dict[str, Finding]:
    return {finding.rule: finding for finding in electrode_findings(Job(design))}


def test_a_faces_metal_by_hand(yamada: Design) -> None:
    """Electrode, lead to the link's end, the link above the lead, and the pad beyond the link."""
    film = yamada.film
    front, back, overlap, pads = faces(film, 0.25, 6.0, 14.0)
    sensed = 2 * (6 - 0.04) * 2 * (0.125 - 0.04)
    first = 14.0 + 0.5 + 4.5 + 0.5
    lead = (first + 1.0 - (6 - 0.04)) * (0.125 - 0.02)
    rest = 1.0 * (2.02 - 0.125) + 2.0 * 1.5
    for metal in (front, back):
        assert area(metal) == pytest.approx(sensed + lead + rest, rel=1e-12)
    assert area(overlap) == pytest.approx(sensed, rel=1e-12)
    assert [area(pad) for pad in pads] == pytest.approx([3.0 * 1.5] * 2)
    heights = [sum(s.start.z for s in pad) / 4 for pad in pads]
    assert heights == pytest.approx([PITCH / 2, -PITCH / 2])
    assert {s.start.x for s in front} == {s.start.x for s in back}
    assert {s.start.z for s in front} == {-s.start.z for s in back}


def test_margin_gap_and_tab_by_hand(yamada: Design) -> None:
    coarse = yamada.with_(film={"cut_tolerance": 0.03, "registration": 0.01}).film
    wide = yamada.with_(film={"electrode_margin": 0.06}).film
    assert (yamada.film.margin, coarse.margin, wide.margin) == pytest.approx((0.04, 0.04, 0.06))
    assert [half_gap(film, 0.25) for film in (yamada.film, coarse)] == pytest.approx([0.02, 0.01])
    assert half_gap(yamada.film, 0.1) == pytest.approx(0.01 / 3)  # a third of what is left beside the margin
    film = yamada.film
    assert half_tab(film, 0.25) == pytest.approx((2.54 + 1.5) / 2 + 0.5)
    # the label is beside leads of 3 mm each
    assert half_tab(film, 6.0) == pytest.approx(3.0 + 0.25 + 1.5)
    assert tab(film)[1] - tab(film)[0] == pytest.approx(3.0 + 0.5 + 1.0)  # pad, bare film, cut corner


@pytest.mark.parametrize("name", SHIPPED)
def test_templates_have_no_finding(name: str) -> None:
    assert electrode_findings(Job(skincad.load(name))) == []


def test_a_lead_or_a_margin_that_is_too_narrow_is_told(yamada: Design) -> None:
    """0.2 mm: half of it less margin and registration, 0.04 and 0.02, leaves 0.04 of metal. Without a margin
    the lead lies at the edge, which may be off by 0.02, and so may the lead, and the other one."""
    narrow = yamada.with_(slot={"depth": 0.2})
    finding = by_rule(narrow)["lead width"]
    assert (finding.severity, finding.measured, finding.limit) == ("error", pytest.approx(0.04), 0.05)
    deep = float(re.search(r"slot.depth of ([\d.]+) mm", finding.remedy)[1])
    assert deep == pytest.approx(0.22)
    assert "lead width" not in by_rule(yamada.with_(slot={"depth": deep}))
    assert "lead width" in by_rule(yamada.with_(slot={"depth": deep - 0.001}))
    narrow = yamada.with_(slot={"depth": 0.2}, film={"electrode_margin": 0.0})
    assert by_rule(narrow)["lead width"].measured == pytest.approx(0.1 - 0.02 - 0.04)
    thin = by_rule(yamada.with_(film={"electrode_margin": 0.02}))["electrode margin"]
    assert (thin.severity, thin.measured, thin.limit) == ("warning", 0.02, pytest.approx(0.04))
    assert by_rule(yamada.with_(film={"electrode_margin": 0.04})) == {}


@pytest.mark.parametrize("lead", [3.9, 4.1])
def test_an_end_plate_must_slide_off_its_pins_between_skin_and_tab(lead: float) -> None:
    """Of strips that are cast in; and of a bent skin's, whose lead goes through the plate of 4 mm besides."""
    cast = skincad.load("cast-in", [f"film.lead={lead}"])
    bent = skincad.load("yamada-2002", ["skin.curvature_radius_y=200", f"film.lead={4 + lead}"])
    for design in (cast, bent):
        assert ("strip tab" in by_rule(design)) == (lead < 4.0)
    assert "strip tab" not in by_rule(skincad.load("yamada-2002", ["film.lead=1.0"]))


def test_no_film_no_electrodes() -> None:
    assert electrode_findings(Job(skincad.load("plain-ridges"))) == []


def tabs_that_cross(design: Design) -> list[Finding]:
    return [finding for finding in design_findings(Job(design)) if finding.rule == "strip tabs"]


def board(design: Design) -> str:
    return sheet_steps(Job(design))["board"]


def test_the_outermost_tab_goes_from_its_slot_to_its_pin(yamada: Design) -> None:
    spread = fan_out(Job(yamada))
    outermost = section(yamada).slots[-1].centre.x
    assert spread.offset == pytest.approx(17 / 2 * PITCH - outermost, rel=1e-12)
    # the S, followed in 1e5 steps: an arc, a straight, the arc back
    radius = BEND * 0.028
    arc = radius * MOST_TURN
    steps = 100_000
    shift = 0.0
    for i in range(steps):
        s = (i + 0.5) / steps * spread.lead
        angle = min(s, spread.lead - s, arc) / radius
        shift += math.sin(angle) * spread.lead / steps
    assert shift == pytest.approx(spread.offset, rel=1e-8)  # the midpoint rule's error is 1e-10


def test_a_small_way_aside_takes_two_arcs_alone() -> None:
    """One ridge: its two tabs go from 0.16 mm to half a pitch; at 3 mm radius 0.8 mm is all by arcs."""
    design = skincad.load("nozzle-04", ["ridge.count=1"])
    spread = fan_out(Job(design))
    radius = BEND * design.film.thickness
    angle = spread.lead / 2 / radius
    assert angle < MOST_TURN
    assert 2 * radius * (1 - math.cos(angle)) == pytest.approx(spread.offset, rel=1e-12)


def test_tabs_cross_where_slots_lean_against_each_other() -> None:
    """S1 and S2 of a ridge lean towards each other by 45 degrees about centres 0.34 mm apart; upright ones
    stand as far apart as their slots."""
    tilted = skincad.load("yamada-2002-tilted")
    (finding,) = tabs_that_cross(tilted)
    assert finding.severity == "note"
    assert half_tab(tilted.film, tilted.slot.depth) * math.sin(math.pi / 4) > 0.17
    assert "Tabs cross" in board(tilted)


@pytest.mark.parametrize("name", FILMED)
def test_only_leaning_slots_have_a_finding(name: str) -> None:
    design = skincad.load(name)
    assert bool(tabs_that_cross(design)) == (design.slot.tilt > 0)


@pytest.mark.slow
def test_the_sheet_says_whether_the_lead_is_long_enough(yamada: Design) -> None:
    assert f"the lead of {Job(yamada).lead:g} mm is long enough" in board(yamada)
    short = board(yamada.with_(film={"lead": 8.0}))
    need = float(re.search(r"in a lead of ([\d.]+) mm", short)[1])
    assert "single plugs on wires" in short
    enough = board(yamada.with_(film={"lead": math.ceil(need)}))
    assert "is long enough" in enough
    assert "board" not in sheet_steps(Job(skincad.load("plain-ridges")))
