"""The inspection list's limits, the drawing and the page, against the design."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET

import pytest
import shapely

import skincad
from skincad.fabrication import Job
from skincad.fabrication.crests import undecided_margin
from skincad.fabrication.inspection import Measure, inspection, inspection_lines
from skincad.inputs import Design, load
from skincad.inputs.material import silicone
from skincad.outputs import PAGE
from skincad.outputs.drawing.overview import drawing
from skincad.outputs.pages import page
from skincad.shape import polygon, section, skin_of
from skincad.solids import CutRole, bores
from skincad.solids.mold import mold
from skincad.solids.shrinkage import shrinkage
from tests.families import RIDGED


def rows(design: Design) -> dict[str, Measure]:
    return {m.what: m for m in inspection(Job(design)).measures}


def test_crests_have_limits_beside_their_line(yamada: Design) -> None:
    crests = inspection(Job(yamada)).crests
    # by hand: 60.5 mm on an axis leaning by 4 pitches / 60 mm
    assert crests.heights[0] == pytest.approx(4.0 - 60.0 + 60.5 * math.cos(4.0 / 60.0), abs=1e-9)
    # by hand: 0.005 of both sides of 15 rows is 3.588 deviations; of 3 um by wire and 2 um by the gauge a
    # line through nine crests leaves 1 - 1/9 - 16/60 at its ends and 1 - 1/9 in its middle
    sigma = 3.588 * math.hypot(0.003, 0.002)
    assert crests.beside[0] == crests.beside[8] == pytest.approx(sigma * math.sqrt(0.6222), rel=1e-3)
    assert crests.beside[4] == pytest.approx(sigma * math.sqrt(0.8889), rel=1e-3)


def grown_volume(design: Design, grown: float) -> float:
    """Volume of a skin whose mold's faces all stand out by `grown`, mm3: the section's negative, thicker all
    round by another library, and the back where the negative's ledge then is; ends further apart."""
    half = design.skin.width / 2
    skin = shapely.Polygon(polygon(section(design).outline, 1e-6))
    block = shapely.box(-half - 5, 0.0, half + 5, 10.0).difference(skin).buffer(grown, 64, join_style="mitre")
    left = shapely.box(-half, -grown, half, 9.0).difference(block)
    return float(left.area * (design.skin.length + 2 * grown))


@pytest.mark.parametrize("name", ["plain-ridges", "milled-pad"])
def test_growth_is_in_the_nominal_sizes_and_the_mass(name: str) -> None:
    """Of walls nearer by 0.02 mm the width loses 0.04 and the length gains it; silicone alone, by volume."""
    drawn = skincad.load(name, ["mold.carrier=plain", "contact.film=ignored"])
    process = drawn.mold.process
    grown = drawn.with_(printer={process: {"growth": 0.02}})
    before, after = rows(drawn), rows(grown)
    width, length = "width across the back", "length along the ridges"
    assert after[width].nominal - before[width].nominal == pytest.approx(-0.04, abs=1e-12)
    assert after[length].nominal - before[length].nominal == pytest.approx(0.04, abs=1e-12)
    assert after["mean pitch"] == before["mean pitch"]
    assert next(iter(after.values())).nominal == next(iter(before.values())).nominal  # floors and ledge rise
    (vent,) = bores(mold(drawn).part("carrier"), CutRole.VENT)
    plug = vent.volume * ((1 - 0.02 / vent.radius) ** 2 - 1)
    more = grown_volume(drawn, 0.02) - grown_volume(drawn, 0.0) + plug
    more *= silicone(drawn).density * 1e-6
    (mass,) = (key for key in before if key.startswith("mass"))
    # the second order is w^2 at corners and edges: 5e-5 mm2 of section was found
    off = 1e-3 * drawn.skin.length * silicone(drawn).density * 1e-6
    assert after[mass].nominal - before[mass].nominal == pytest.approx(more, abs=off)
    assert abs(more) > 5 * off


def test_an_offset_of_all_crests_is_in_their_heights_and_the_mass(yamada: Design) -> None:
    """0.05 mm deeper everywhere; the line through the crests, and what is said of them, stay."""
    high = yamada.with_(printer={"edm": {"crest_offset": 0.05}})
    before, after = inspection(Job(yamada)), inspection(Job(high))
    up = 0.05 * (1 - shrinkage(yamada))
    for a, b in zip(before.crests.heights, after.crests.heights, strict=True):
        assert b - a == pytest.approx(up, abs=1e-12)
    assert after.said == before.said
    mass, heavier = before.measures[-1].nominal, after.measures[-1].nominal
    assert heavier - mass == pytest.approx(up * 11.0 * 12.0 * silicone(yamada).density * 1e-6, rel=1e-3)
    printed = skincad.load("lab-bench")
    offset = printed.with_(printer={"sla": {"crest_offset": 0.05}})
    remarks = [inspection(Job(variant)).said[0] for variant in (printed, offset)]
    assert remarks[0] == remarks[1]  # what layers do, beside the offset


@pytest.mark.parametrize("count", [1, 2])
def test_nothing_lies_beside_a_line_through_two_crests(yamada: Design, count: int) -> None:
    design = yamada.with_(ridge={"count": count})
    inspected = inspection(Job(design))
    assert inspected.crests.beside == ()
    assert ("tilt of the crests" in {m.what for m in inspected.measures}) is (count == 2)
    assert len([line for line in inspection_lines(inspected) if line.endswith("| - |")]) == count


def test_a_margin_that_the_process_uses_up_is_told(yamada: Design) -> None:
    """By wire: 3.588 deviations of 3 um, of two crests and two sides of the ledge at 8/11 of its width."""
    scatter = 3.588 * 0.003 * math.sqrt(2 + 2 * (8 / 11) ** 2)

    def said(room: float) -> str:
        return " ".join(inspection(Job(yamada), (*[math.inf] * 8, room)).said)

    assert "crest 9" in said(1.01 * scatter)
    assert "parts within these limits pass it" in said(1.01 * scatter)
    assert "These limits don't decide" in said(0.99 * scatter)
    assert "leaves no margin or was not asked" in " ".join(inspection(Job(yamada)).said)


def test_how_near_to_its_edge_a_measured_verdict_is_the_gauges_own_doing() -> None:
    """By hand: means of 4 readings of 2 um are off by 1 um; by slopes of 3 and 4 N/mm that is 0.005 N."""
    assert undecided_margin(1.2, (0.4, math.inf, 0.3)) == pytest.approx(2.5 * 0.005)
    assert undecided_margin(0.0, (0.0, math.inf)) == 0.0  # no margin, no slopes
    coarse = skincad.load("plain-ridges")
    drops = (0.1, *[math.inf] * 7, 0.1)
    text = " ".join(inspection(Job(coarse), drops, 1.0).said)
    assert f"within ±{0.0025 * math.hypot(10, 10):.2g} N, read on until each crest is the mean of 64" in text


def test_the_mass_is_what_stays_on_the_carrier(yamada: Design) -> None:
    mass = rows(yamada)["mass of the skin with rivets and films"]
    closed = mold(yamada)
    holes = [c for c in closed.part("carrier").cuts if c.role in (CutRole.RIVET, CutRole.VENT)]
    silicone = section(yamada).area * 12.0 + 18 * (0.05 - 0.028) * 0.25 * 12.0 + sum(c.volume for c in holes)
    tab = 9.5 * 5.04 - 0.5 + 0.5 * 0.25 + 2 * (1 - math.pi / 4) * 0.25  # less its corner, with its shoulders
    films = 18 * 0.028 * (0.25 * (12.0 + 36.0) + tab)  # with leads and tabs
    assert mass.nominal == pytest.approx(silicone * 1080e-6 + films * 1780e-6, rel=1e-9)
    assert mass.low < 0.97 * mass.nominal < 1.03 * mass.nominal < mass.high


def test_without_films_or_rivets_the_mass_is_the_skins(yamada: Design) -> None:
    bare = yamada.with_(slot=None, film=None, contact={"film": None}, mold={"carrier": "plain"})
    mass = rows(bare)["mass of the skin"]
    vent = next(c for c in mold(bare).part("carrier").cuts if c.role is CutRole.VENT)
    assert mass.nominal == pytest.approx((section(bare).area * 12.0 + vent.volume) * 1080e-6, rel=1e-9)


def test_the_mean_pitch_is_limited_by_the_way_from_first_to_last(yamada: Design) -> None:
    coarse = skincad.load("nozzle-04")
    pitch = rows(coarse)["mean pitch"]
    assert pitch.high - pitch.nominal < 0.12  # mm, of 6; two surfaces of 0.2 mm by six pitches are 0.067
    assert pitch.high - pitch.nominal > 0.4 / 6
    assert rows(yamada)["mean pitch"].high < 1.01


@pytest.mark.parametrize("pixel", [0.05, 0.02])
def test_pixels_that_fall_anywhere_widen_the_limits(pixel: float) -> None:
    """On its end the section is drawn by a screen's pixels."""
    design = skincad.load("plain-ridges").with_(printer={"sla": {"orientation": "end", "pixel": pixel}})
    inspected = inspection(Job(design))
    assert inspected.crests.heights == pytest.approx(skin_of(design).crests, abs=1e-12)
    assert inspected.crests.sigma == pytest.approx(math.hypot(0.015, pixel / math.sqrt(12)))
    assert any(f"one of {pixel:g} mm" in entry for entry in inspected.said)


def test_a_nozzle_follows_the_section_on_its_end() -> None:
    design = skincad.load("nozzle-04").with_(printer={"fdm": {"orientation": "end"}})
    inspected = inspection(Job(design))
    assert (inspected.crests.heights, inspected.crests.sigma) == (skin_of(design).crests, 0.05)
    assert not any("layers" in entry for entry in inspected.said)


def test_the_list_is_a_form(yamada: Design) -> None:
    inspected = inspection(Job(yamada))
    text = inspection_lines(inspected)
    assert sum(line.startswith(tuple(f"| {i} |" for i in range(1, 10))) for line in text) == 9
    assert sum(line.startswith(tuple(f"| {m.what} |" for m in inspected.measures)) for line in text) == 6
    # a spreadsheet's columns: the table's first row is row 1
    assert any("`=D2-FORECAST(A2,D$2:D$10,A$2:A$10)`" in line for line in text)


@pytest.mark.parametrize("name", RIDGED)
def test_the_drawing_is_an_svg_within_its_page(name: str) -> None:
    design = load(name)
    root = ET.fromstring(drawing(design, mold(design)))
    text = " ".join(node.text or "" for node in root.iter("{http://www.w3.org/2000/svg}text"))
    for value in (design.skin.width, design.skin.thickness, design.ridge.height, design.skin.length):
        assert f"{value:g}" in text
    for node in root.iter("{http://www.w3.org/2000/svg}polygon"):
        for corner in node.attrib["points"].split():
            x, y = map(float, corner.split(","))
            assert 0 <= x <= PAGE[0]
            assert 0 <= y <= PAGE[1]


def test_the_page_has_tables_and_takes_no_html() -> None:
    text = page("# A\n\n<script>x</script>\n\n| a | b |\n|---|---|\n| 1 | 2 |\n", "<svg/>", "a < b")
    assert "<td>1</td>" in text
    assert "<script>" not in text
    assert "<title>a &lt; b</title>" in text
    assert "<svg/>" in text
