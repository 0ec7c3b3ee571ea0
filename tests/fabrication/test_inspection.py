"""The inspection list: limits against the design, layers, and 10,000 simulated parts."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pytest
import shapely

import skincad
from skincad.base import Array, Mask
from skincad.fabrication import (
    Job,
    design_findings,
    printed_crests,
    snapped_to_layers,
    uncertain_ridges,
)
from skincad.fabrication.crests import crest_limits, limits_decide, remarks, undecided_margin
from skincad.fabrication.inspection import inspection, inspection_lines
from skincad.inputs import Design, processes
from skincad.mechanics import all_touch, level, pad_of, plane_piece, ridge_forces, ridge_model, unit_of
from skincad.outputs import allowance, page
from skincad.shape import crest_places, polygon, section, skin_of
from skincad.solids import CutRole, bores
from skincad.solids.mold import mold
from tests.designs import KINDS, RIDGED, template
from tests.fabrication.cast_parts import Parts, drawn, sliced


def rows(design: Design) -> dict[str, Any]:
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
    more *= Job(drawn).silicone.density * 1e-6
    (mass,) = (key for key in before if key.startswith("mass"))
    # the second order is w^2 at corners and edges: 5e-5 mm2 of section was found
    off = 1e-3 * drawn.skin.length * Job(drawn).silicone.density * 1e-6
    assert after[mass].nominal - before[mass].nominal == pytest.approx(more, abs=off)
    assert abs(more) > 5 * off


def test_an_offset_of_all_crests_is_in_their_heights_and_the_mass(yamada: Design) -> None:
    """0.05 mm deeper everywhere; the line through the crests, and what is said of them, stay."""
    high = yamada.with_(printer={"edm": {"crest_offset": 0.05}})
    before, after = inspection(Job(yamada)), inspection(Job(high))
    up = 0.05 * (1 - Job(yamada).shrinkage)
    for a, b in zip(before.crests.heights, after.crests.heights, strict=True):
        assert b - a == pytest.approx(up, abs=1e-12)
    assert after.said == before.said
    mass, heavier = before.measures[-1].nominal, after.measures[-1].nominal
    assert heavier - mass == pytest.approx(up * 11.0 * 12.0 * Job(yamada).silicone.density * 1e-6, rel=1e-3)
    printed = skincad.load("lab-bench")
    offset = printed.with_(printer={"sla": {"crest_offset": 0.05}})
    remarks = [inspection(Job(variant)).said[0] for variant in (printed, offset)]
    assert remarks[0] == remarks[1]  # what layers do, beside the offset


@pytest.mark.parametrize(
    ("name", "column"), [("pillars-9", "pin"), ("rings-5", "ring"), ("flat-magnet", "place")]
)
def test_the_sheet_asks_for_what_a_measured_part_is_judged_by(name: str, column: str) -> None:
    """A row for each place, in the order of its numbers, and the line that says how."""
    inspected, places = inspection(Job(skincad.load(name))), crest_places(skin_of(skincad.load(name)))
    lines = inspection_lines(inspected)
    head = lines.index(f"| {column} | x, mm | y, mm | comes out at, mm | measured, mm | limit |")
    table = [line.strip("| ").split(" | ") for line in lines[head + 2 : head + 2 + len(places)]]
    assert [int(row[0]) for row in table] == list(range(1, len(places) + 1))
    for row, (x, y, z) in zip(table, places, strict=True):
        assert (float(row[1]), float(row[2])) == (pytest.approx(x, abs=6e-4), pytest.approx(y, abs=6e-4))
        assert abs(float(row[3]) - z) < 0.06  # a layer of sla is 0.05 mm
    assert len(inspected.crests.heights) == len(places)
    assert any(f"columns `{column},crest_mm`, the first and the fifth of the table" in line for line in lines)


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


def test_the_page_has_tables_and_takes_no_html() -> None:
    text = page("# A\n\n<script>x</script>\n\n| a | b |\n|---|---|\n| 1 | 2 |\n", "<svg/>", "a < b")
    assert "<td>1</td>" in text
    assert "<script>" not in text
    assert "<title>a &lt; b</title>" in text
    assert "<svg/>" in text


def heights(design: Design) -> tuple[float, ...]:
    return printed_crests(Job(design))


def test_without_layers_crests_come_out_as_designed(yamada: Design) -> None:
    assert heights(yamada) == skin_of(yamada).crests


ON_LAYERS = [template(name) for name in ("lab-bench", "plain-ridges", "nozzle-04")]


@pytest.mark.parametrize("name", ON_LAYERS)
def test_heights_are_whole_layers_of_the_mold(name: str) -> None:
    design = skincad.load(name)
    layer = {"nozzle-04": 0.2}.get(name, 0.05)
    layers = np.array(heights(design)) / (1 - Job(design).shrinkage) / layer
    assert layers == pytest.approx(np.round(layers), abs=1e-9)
    # ledge and groove are each rounded by half a layer at most
    assert np.abs(np.array(heights(design)) - skin_of(design).crests).max() <= layer


def test_a_groove_that_is_narrower_at_a_middle_than_slicers_close_ends_a_layer_higher() -> None:
    """With a floor of 9.014 a middle lies just over the bottoms of ridges 4 and 6, where the mesh is open,
    by less than 0.098 mm; consumers/test_prusaslicer.py slices it. With 9.012 it is wider."""
    wide, narrow = (skincad.load("plain-ridges", [f"mold.floor={floor}"]) for floor in (9.012, 9.014))
    off = np.array(heights(narrow)) - heights(wide)
    # a layer of the mold, less the shrinkage of 0.1 %
    assert off == pytest.approx([0, 0, 0, -0.05, 0, -0.05, 0, 0, 0], abs=1e-4)


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("plain-ridges", {"printer": {"sla": {"orientation": "end"}}}),
        ("plain-ridges", {"skin": {"curvature_radius_y": 60.0}}),
        ("steep-fingertip", {"mold": {"split": "auto", "process": "sla"}}),
    ],
)
def test_steps_that_fall_anywhere_are_not_told(name: str, changes: dict[str, dict[str, object]]) -> None:
    design = skincad.load(name).with_(**changes)
    assert printed_crests(Job(design)) is None


@pytest.mark.parametrize(("floor", "found"), [(9.0, (2, 8)), (9.012, (4, 6)), (9.03, ())])
def test_a_groove_that_ends_at_a_layers_middle_is_told(floor: float, found: tuple[int, ...]) -> None:
    """A floor of 9 mm has a middle 2.4 um beside the bottoms of ridges 2 and 8, 9.012 at those of 4 and 6."""
    design = skincad.load("plain-ridges", [f"mold.floor={floor}"])
    closed = mold(design)
    assert uncertain_ridges(Job(design, closed)) == found
    notes = [f for f in design_findings(Job(design, closed)) if f.rule == "crest layer"]
    assert [f.severity for f in notes] == ["note"] * bool(found)
    text = " ".join(inspection(Job(design, closed)).said)
    assert ("may come out a layer" in text) == bool(found)


def test_a_pixel_or_a_ledge_at_a_layers_middle_leaves_crests_open() -> None:
    """Of 0.05 mm by tan 0.05, 2.5 um, which 2 um of rounding alone leave out at ridges 2 and 8."""
    design = skincad.load("plain-ridges", ["mold.floor=9.0"])
    fine = design.with_(printer={"sla": {"pixel": 0.001}})
    assert uncertain_ridges(Job(design)) == (2, 8)
    assert uncertain_ridges(Job(fine)) == ()
    design = skincad.load("plain-ridges", ["mold.floor=9.0"])
    ledge = -min(s.start.z for s in mold(design).part("cavity").body.outline)
    floor = 9.0 + 0.05 * (np.ceil(ledge / 0.05 - 0.5) + 0.5) - ledge
    moved = skincad.load("plain-ridges", [f"mold.floor={floor:.6f}"])
    assert uncertain_ridges(Job(moved)) == tuple(range(1, 10))


@pytest.mark.parametrize("name", ON_LAYERS)
def test_heights_and_a_floor_put_each_crest_at_a_layers_end(name: str) -> None:
    design = skincad.load(name)
    heights_and_floor = snapped_to_layers(Job(design))
    tall, floor = heights_and_floor
    layer = processes(design.printer)[design.mold.process].layer
    snapped = skincad.load(name, [f"ridge.heights={list(tall)}", f"mold.floor={floor}"])
    closed = mold(snapped)
    # mm: heights are told to 0.1 um, along axes that lean
    assert heights(snapped) == pytest.approx(skin_of(snapped).crests, abs=2e-4)
    assert np.abs(np.array(skin_of(snapped).crests) - skin_of(design).crests).max() <= 0.501 * layer
    assert uncertain_ridges(Job(snapped, closed)) == ()
    assert snapped_to_layers(Job(snapped, closed)) is None
    assert f"`mold.floor = {floor:g}`" in " ".join(inspection(Job(design)).said)


def test_each_skin_of_a_gang_comes_out_as_one_alone() -> None:
    design = skincad.load("plain-ridges")
    assert heights(design.with_(mold={"cavities": 2})) == pytest.approx(heights(design), abs=1e-9)


def test_layers_higher_than_the_block_are_not_looked_for_for_ever() -> None:
    """The first middle of a layer over the grooves, 22.5 mm, is over the block, so the search had no end."""
    coarse = ["mold.process=sla", "printer.sla.layer=9.0", "skin.thickness=1.0", "mold.floor=13.55"]
    design = skincad.load("plain-ridges", coarse)
    assert printed_crests(Job(design)) is None


PARTS = 10_000
REJECTED = 0.01  # asked, of good parts
CAUGHT = 0.95  # asked, of parts whose verdict fails
SPOILED = 3.0  # times the process's crest errors: a mold that is not what its process makes


class JudgedDesign(NamedTuple):
    """A design, its inspection, whether parts of these crests `(n, ridges)` mm pass the verdict, their
    margins `(n,)` N, and how near to 0 of it crests are read on."""

    design: Design
    inspected: Any
    passes: Callable[[Array], Mask]
    margin: Callable[[Array], Array]
    near: float

    @property
    def decides(self) -> bool:
        """Whether the sheet says that its limits suffice."""
        return not any("don't decide" in entry for entry in self.inspected.said)


@cache
def judged(name: str) -> JudgedDesign:
    design = skincad.load(name)
    check = skincad.check(design)
    pad, force = pad_of(design), design.contact.force
    solved = level(plane_piece(pad, 0.5, whole=True), 2, force)
    model = ridge_model(*solved.ridges.points, force, unit_of(pad), solved.scale)
    upper = check.all_touch_force.upper
    # what a better model and the error add is taken as a change of stiffness, as the yield takes it
    force_needed = float(all_touch(model, np.zeros((1, design.ridge.count)), force / solved.scale)[0])

    def passes(crests: Array) -> Mask:
        drops = (np.array(skin_of(design).crests) - crests) / unit_of(pad)
        drops_allowed = np.full(len(crests), force * force_needed / upper)  # in the pad's unit
        return np.asarray((ridge_forces(model, drops, drops_allowed) > 0).all(axis=1))

    def margin(crests: Array) -> Array:
        drops = (np.array(skin_of(design).crests) - crests) / unit_of(pad)
        return np.asarray(force - all_touch(model, drops, force / solved.scale) * upper / force_needed)

    drops, room = allowance(check)
    return JudgedDesign(
        design, inspection(Job(design), drops, room), passes, margin, undecided_margin(room, drops)
    )


def rejected(case: JudgedDesign, parts: Parts) -> Mask:
    """What a person rejects who follows the sheet: limits, and where these don't decide the verdict too."""
    limits, measures = case.inspected.crests, case.inspected.measures
    number = np.arange(case.design.ridge.count)
    errors = parts.crests - np.array(limits.heights)
    slope, middle = np.polyfit(number, errors.T, 1)
    beside = np.abs(errors - np.outer(slope, number) - middle[:, None]) > np.array(limits.beside)
    read = {
        "mean crest": parts.crests.mean(axis=1),
        "tilt": slope * (case.design.ridge.count - 1),
        "mean pitch": parts.pitch,
        "width": parts.width,
        "length": parts.length,
        "mass": parts.mass,
    }
    assert len(measures) == len(read)
    out = beside.any(axis=1)
    for what, values in read.items():
        (row,) = (m for m in measures if m.what.startswith(what))
        out |= (values < row.low) | (values > row.high)
    if not case.decides:
        out[~out] = ~measured_verdict(case, parts.crests[~out], parts.crests_again[~out])
    return out


def measured_verdict(case: JudgedDesign, crests: Array, crests_again: Array) -> Mask:
    """Whether each part passes as it is measured, and read on where its margin is near 0."""
    margins = case.margin(crests)
    near = np.abs(margins) < case.near
    passed = margins >= 0
    passed[near] = case.passes(crests_again[near])
    return passed


def parts_of(case: JudgedDesign, seed: int, worse: float = 1.0) -> Parts:
    readings = (1, 1) if case.decides else (4, 64)  # as the sheet says
    return drawn(case.design, mold(case.design), PARTS, seed, worse, readings)


@pytest.mark.evidence(subject="{name}")
@pytest.mark.parametrize("name", RIDGED)
def test_good_parts_are_kept(name: str) -> None:
    one = judged(name)
    parts = parts_of(one, 101)
    good = one.passes(parts.true_crests)
    lost = float(rejected(one, parts)[good].mean())
    assert lost < REJECTED


@pytest.mark.evidence(subject="{name}")
@pytest.mark.parametrize("name", RIDGED)
def test_parts_that_fail_are_caught(name: str) -> None:
    """Of a spoiled mold, and with one crest too low by up to three times what the verdict allows."""
    one = judged(name)
    spoiled, one_low = parts_of(one, 102, SPOILED), parts_of(one, 103)
    rng = np.random.default_rng(104)
    room = max(3 * allowed_least(one), 0.1 * one.design.ridge.height)
    low = np.zeros((PARTS, one.design.ridge.count))
    low[np.arange(PARTS), rng.integers(0, low.shape[1], PARTS)] = rng.uniform(0, room, PARTS)
    one_low = one_low._replace(
        crests=one_low.crests - low,
        true_crests=one_low.true_crests - low,
        crests_again=one_low.crests_again - low,
    )
    seen = 0
    for parts in (spoiled, one_low):
        bad = ~one.passes(parts.true_crests)
        seen += int(bad.sum())
        assert not bad.any() or rejected(one, parts)[bad].mean() >= CAUGHT
    assert seen > 500  # enough that 95 % are known to 1 %


@cache
def allowed_least(case: JudgedDesign) -> float:
    """By how much the crest that counts most may lie lower alone, mm, by bisection of the verdict itself."""
    count = case.design.ridge.count
    depths = np.linspace(0.0, case.design.ridge.height, 201)
    out = np.array(skin_of(case.design).crests) - depths[:, None] * (np.arange(count) == 0)
    return float(depths[int(case.passes(out).argmin())])


@pytest.mark.evidence(subject="{name}")
@pytest.mark.parametrize("name", RIDGED)
def test_failing_parts_of_the_process_itself_are_few_among_those_kept(name: str) -> None:
    """Where the limits don't decide, the measured verdict finds the process's own, which crowd at its
    edge."""
    one = judged(name)
    parts = parts_of(one, 105)
    bad = ~one.passes(parts.true_crests)
    assert bad.mean() < 1e-3 or not one.decides
    assert bad.sum() < 20 or rejected(one, parts)[bad].mean() >= CAUGHT


@pytest.mark.evidence(subject="{name}")
@pytest.mark.parametrize("name", RIDGED)
def test_a_shift_of_all_crests_fails_the_thickness_alone(name: str) -> None:
    one = judged(name)
    heights = np.array(one.inspected.crests.heights) + 0.1
    number = np.arange(heights.size)
    line = np.polyval(np.polyfit(number, heights - np.array(one.inspected.crests.heights), 1), number)
    assert np.all(np.abs(0.1 - line) <= np.array(one.inspected.crests.beside))
    (thick,) = (m for m in one.inspected.measures if m.what.startswith("mean crest"))
    limits = one.inspected.crests
    hidden = limits.mean > 0.1
    assert hidden is (one.design.mold.process == "fdm")  # whose ledge alone is off by 0.05 / sqrt(2) mm
    assert hidden is any("Measure the mold once" in entry for entry in one.inspected.said)
    # against its own mold then
    assert heights.mean() > np.mean(limits.heights) + min(limits.beside_mold, limits.mean)
    assert hidden or heights.mean() > thick.high
    assert one.passes(heights[None])[0] == one.passes(heights[None] - 0.1)[0]


@pytest.mark.parametrize("name", [template("nozzle-04"), template("plain-ridges", tier="slow")])
def test_good_parts_lie_beside_their_own_mold(name: str) -> None:
    """In the place of the mean crest's limit, so that it costs no more good parts than that."""
    one = judged(name)
    parts = parts_of(one, 106)
    off = np.abs(parts.crests.mean(axis=1) - parts.mold_crests.mean(axis=1))
    lost = float((off > one.inspected.crests.beside_mold).mean())
    assert lost < 1e-3  # 0.005 by 13 or 15 rows is 4e-4 or 3e-4: three of its errors by 10,000 parts
    assert (off > one.inspected.crests.beside_mold / 2).mean() > 0.01  # and it is no wider than they are


@pytest.mark.parametrize("name", KINDS)
def test_layers_are_told_as_they_fall(name: str) -> None:
    """By another count of layers; the slicers' own are in consumers/test_prusaslicer.py."""
    design = skincad.load(name)
    closed = mold(design)
    heights = inspection(Job(design, closed)).crests.heights
    # mm: the generator's block is of exact arcs, and of a volume that gives its scale to a few digits
    assert heights == pytest.approx(sliced(design, closed), abs=5e-4)


def test_limits_decide_where_the_verdict_allows_more_than_the_process_takes() -> None:
    """What the sheet says in words: crests of sla scatter by 0.015 mm."""
    job = Job(skincad.load("plain-ridges", ["mold.process=sla"]))
    assert limits_decide(job, ())
    for drop, decides, words in ((0.001, False, "These limits don't decide"), (1.0, True, "pass it")):
        drops = (drop,) * job.skin.count
        assert limits_decide(job, drops) == decides
        assert words in " ".join(remarks(job, crest_limits(job), drops, 1.0))
