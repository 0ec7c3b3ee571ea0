"""How strips' tabs are spread to a board, against plane geometry by hand."""

from __future__ import annotations

import math
import re

import pytest

import skincad
from skincad.fabrication import Job, design_findings, fan_out, sheet_steps
from skincad.fabrication.electrodes import fan_out_findings, half_tab
from skincad.inputs import Design, template_names
from skincad.shape import section
from skincad.solids import BEND, MOST_TURN
from skincad.solids.inserts import PITCH


def board(design: Design) -> str:
    return sheet_steps(Job(design))["board"]


def test_the_outermost_tab_goes_from_its_slot_to_its_pin(yamada: Design) -> None:
    spread = fan_out(Job(yamada))
    assert spread is not None
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
    assert spread is not None
    radius = BEND * design.film.thickness  # type: ignore[union-attr]
    angle = spread.lead / 2 / radius
    assert angle < MOST_TURN
    assert 2 * radius * (1 - math.cos(angle)) == pytest.approx(spread.offset, rel=1e-12)


def test_tabs_cross_where_slots_lean_against_each_other() -> None:
    """S1 and S2 of a ridge lean towards each other by 45 degrees about centres 0.34 mm apart; upright ones
    stand as far apart as their slots."""
    tilted = skincad.load("yamada-2002-tilted")
    (finding,) = fan_out_findings(Job(tilted))
    assert (finding.rule, finding.severity) == ("strip tabs", "note")
    assert half_tab(tilted.film, tilted.slot.depth) * math.sin(math.pi / 4) > 0.17  # type: ignore[arg-type, union-attr]
    assert finding in design_findings(Job(tilted))
    assert "Tabs cross" in board(tilted)


@pytest.mark.parametrize("name", [n for n in template_names() if skincad.load(n).film])
def test_only_leaning_slots_have_a_finding(name: str) -> None:
    design = skincad.load(name)
    assert design.slot is not None
    assert bool([*fan_out_findings(Job(design))]) == (design.slot.tilt > 0)


def test_the_sheet_says_whether_the_lead_is_long_enough(yamada: Design) -> None:
    assert f"the lead of {Job(yamada).lead:g} mm is long enough" in board(yamada)
    short = board(yamada.with_(film={"lead": 8.0}))
    need = float(re.search(r"in a lead of ([\d.]+) mm", short)[1])  # type: ignore[index]
    assert "single plugs on wires" in short
    enough = board(yamada.with_(film={"lead": math.ceil(need)}))
    assert "is long enough" in enough
    assert "board" not in sheet_steps(Job(skincad.load("plain-ridges")))
