"""Films behind their shims: what their lap passes, how many with one mix, and what shows that they hold."""

import math
import re

import pytest

import skincad
from bench.campaign.random_designs import drawn
from skincad.fabrication import Finding, Job, strip_findings
from skincad.fabrication.strips import drawing_findings, drawing_time, lap, pull_test, strips_per_mix
from skincad.inputs import Design
from skincad.inputs.material import silicone
from tests.bent_skin import bent, three_ridges
from tests.families import RIDGED


def by_rule(design: Design) -> dict[str, Finding]:
    return {finding.rule: finding for finding in drawing_findings(Job(design))}


def test_a_straight_lap_has_only_the_soft_slot_on_its_way(yamada: Design) -> None:
    """Shim, glue and film: 0.05 + 0.01 + 0.028 in a slot of 0.05 x 0.25."""
    joint = lap(Job(yamada))
    assert joint is not None
    assert (joint.tail, joint.notch) == (0.05, None)
    assert joint.stack == pytest.approx(0.088, rel=1e-12)
    girth, round_it = 2 * (0.05 + 0.25), 2 * (0.088 + 0.25)
    assert joint.stretch == pytest.approx(round_it / girth - 1, rel=1e-12)


def test_a_bent_laps_tail_is_thinned_to_pass_its_notches() -> None:
    """A notch of 0.06 by a wire good to 0.003: 0.057, less film and glue."""
    joint = lap(Job(three_ridges()))
    assert joint is not None
    assert joint.notch == pytest.approx(0.057, rel=1e-12)
    assert joint.tail == pytest.approx(0.057 - 0.028 - 0.01, abs=1e-6)
    assert joint.stack <= joint.notch + 1e-9
    loose = lap(Job(three_ridges().with_(mold={"slit_clearance": 0.05})))
    assert loose is not None
    assert loose.tail == 0.05  # and no thinning where there is room


def test_a_notch_is_at_least_what_its_shim_was_lapped_into() -> None:
    printed = lap(
        Job(bent("lab-bench", 100.0).with_(mold={"slit_clearance": 0.01, "end_plate_process": "sla"}))
    )
    assert printed is not None
    assert printed.notch == 0.1  # 0.12 less the printer's 0.05 would not take the shim itself


def test_a_process_that_grows_leaves_a_narrower_notch() -> None:
    """Both sides of 0.1 come in by 0.015; 0.067 is left by a wire good to 0.003, for a lap of 0.067."""
    wide = three_ridges().with_(mold={"slit_clearance": 0.025})
    joint = lap(Job(wide.with_(printer={"edm": {"growth": 0.015}})))
    assert joint is not None
    assert joint.notch == pytest.approx(0.067)
    assert joint.tail == pytest.approx(0.067 - 0.038)


def test_there_is_no_lap_without_a_film_or_a_shim() -> None:
    assert lap(Job(skincad.load("cast-in"))) is None
    assert lap(Job(skincad.load("plain-ridges"))) is None
    assert lap(Job(skincad.load("yamada-2002", ["film=none", "contact.film=loose"]))) is None


@pytest.mark.parametrize("name", RIDGED)
@pytest.mark.parametrize("radius", [None, 100.0])
def test_every_templates_lap_goes_in(name: str, radius: float | None) -> None:
    """Straight as they ship, and doubly curved where strips are drawn in and the cavity is whole."""
    design = skincad.load(name)
    if radius is not None:
        if design.mold.method == "cast-in" or design.mold.split == "auto":
            pytest.skip("refused by the mold")
        design = design.with_(skin={"curvature_radius_y": radius})
    assert all(f.severity != "error" for f in drawing_findings(Job(design)))


@pytest.mark.parametrize("curved", [False, True])
def test_the_lap_of_a_random_design_passes_or_is_an_error(curved: bool) -> None:
    seen = 0
    for seed in range(60):
        design = drawn(seed).design
        if curved and design.slot and design.mold.method == "shim":
            radius = 40 * max(design.skin.length, design.skin.thickness)
            design = design.with_(skin={"curvature_radius_y": radius})
        joint = lap(Job(design))
        if joint is None:
            continue
        seen += 1
        assert (joint.notch is None) == (design.skin.curvature_radius_y is None)
        breaks = 0.2 * silicone(design).elongation_at_break
        fits = joint.stretch <= breaks and (joint.notch is None or joint.stack <= joint.notch + 1e-6)
        findings = [f for f in strip_findings(Job(design)) if f.rule == "strip lap"]
        assert bool(findings) != fits, f"seed {seed}"
        assert all(f.severity == "error" and f.measured > f.limit for f in findings)
    assert seen >= 10


def test_a_lap_that_jams_is_an_error_that_its_remedy_cures() -> None:
    tight = three_ridges().with_(film={"thickness": 0.05})
    finding = by_rule(tight)["strip lap"]
    assert (finding.severity, finding.unit) == ("error", "mm")
    assert finding.measured == pytest.approx(0.015 + 0.01 + 0.05)
    wide = float(re.search(r"slit_clearance of ([\d.]+) mm", finding.remedy)[1])
    assert "strip lap" not in by_rule(tight.with_(mold={"slit_clearance": wide}))
    assert "strip lap" in by_rule(tight.with_(mold={"slit_clearance": wide - 1e-3}))  # whole micrometres


def test_a_lap_that_would_tear_its_slot_is_an_error_that_its_remedy_cures(yamada: Design) -> None:
    brittle = yamada.with_(silicones={"dragon-skin-30": {"elongation_at_break": 0.6}})
    finding = by_rule(brittle)["strip lap"]
    assert (finding.severity, finding.limit) == ("error", pytest.approx(0.12))
    assert finding.measured == pytest.approx(0.038 / 0.3)
    deep = float(re.search(r"slot.depth of ([\d.]+) mm", finding.remedy)[1])
    assert "strip lap" not in by_rule(brittle.with_(slot={"depth": deep}))
    assert "strip lap" in by_rule(brittle.with_(slot={"depth": deep - 2e-3}))  # rounded up by 1e-3


def test_a_contact_that_ends_in_its_notch_is_told() -> None:
    short = three_ridges().with_(film={"lead": 5.0})
    finding = by_rule(short)["strip lead"]
    assert (finding.measured, finding.limit, finding.severity) == (1.0, 2.0, "warning")
    assert "film.lead of 6 mm" in finding.remedy
    assert "strip lead" not in by_rule(three_ridges().with_(film={"lead": 6.0}))


def test_strips_of_one_mix_fit_half_its_pot_life(yamada: Design) -> None:
    """20 min: 600 s at 97 s each."""
    assert strips_per_mix(Job(yamada.with_(silicones={"dragon-skin-30": {"pot_life_min": 20.0}}))) == 6
    assert strips_per_mix(Job(yamada.with_(material={"name": None, "young_modulus": 0.5}))) is None
    fast = yamada.with_(silicones={"dragon-skin-30": {"pot_life_min": 3.0}})
    finding = by_rule(fast)["strip batch"]
    assert (finding.measured, finding.limit, finding.severity) == (97.0, pytest.approx(90.0), "error")
    assert "strip batch" not in by_rule(yamada)
    deft = yamada.with_(printer={"edm": {"handling_s": 7.0}})
    assert strips_per_mix(Job(deft)) == 96  # 45 min: 1350 s at 14 s each


def test_a_long_strip_is_drawn_in_slowly_for_its_drags_sake(yamada: Design) -> None:
    """40 Pa s in coats of 0.011 mm on both faces of a film that may be pulled with 15 MPa."""
    assert drawing_time(Job(yamada)) == 7.0
    long = yamada.with_(skin={"length": 100.0})
    speed, pull = 100.0 / drawing_time(Job(long)), 15.0 * 0.028 * 0.25
    assert 40e-6 * speed / 0.011 * 2 * 0.25 * 100.0 == pytest.approx(pull, rel=1e-12)
    tight = long.with_(slot={"thickness": 0.028})
    assert drawing_time(Job(tight)) == pytest.approx(
        1.1 * drawing_time(Job(long)), rel=1e-12
    )  # a coat of 0.010
    assert strips_per_mix(Job(long)) == int(0.5 * 45 * 60 / (90 + drawing_time(Job(long))))


def test_the_pull_test_is_a_third_of_the_weaker_of_film_and_bond(yamada: Design) -> None:
    by_film = pull_test(Job(yamada))
    assert by_film is not None
    assert by_film.by_film
    assert by_film.force == pytest.approx(45 * 0.028 * 0.25 / 3)
    assert by_film.shear == pytest.approx(by_film.force / (2 * 0.25 * 12))
    short = pull_test(Job(yamada.with_(skin={"length": 4.0})))
    assert short is not None
    assert not short.by_film
    assert short.force == pytest.approx(0.1 * 2 * 0.25 * 4 / 3)
    assert math.isclose(short.shear, 0.1 / 3)


def test_a_film_that_is_cast_in_and_baked_is_told() -> None:
    cast = skincad.load("cast-in")
    hot = cast.with_(silicones={"dragon-skin-20": {"cure_c": 100.0}})
    assert (by_rule(hot)["film heat"].measured, by_rule(hot)["film heat"].severity) == (100.0, "warning")
    assert by_rule(cast.with_(silicones={"dragon-skin-20": {"cure_c": 80.0}})) == {}
