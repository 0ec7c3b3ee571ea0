import math

import pytest

import skincad
from skincad.fabrication import Job, design_findings
from skincad.fabrication.findings import freeing_widths
from skincad.inputs import Design
from skincad.shape import skin_of
from skincad.solids import SAFE_SHARE, safe_strain


def upright(radius: float, **other: object) -> Design:
    """Sharp ridges of constant width 0.75 mm: nothing but the fan's lean undercuts them."""
    return skincad.load("yamada-2002").with_(
        slot=None,
        skin={"curvature_radius": radius},
        ridge={"tip_width": 0.75, "crown": 0.0, "tip_fillet": 0.0, "root_fillet": 0.0},
        **other,
    )


def flank(radius: float) -> float:
    """Length of a flank: 0.5 mm and the base circle's fall over half a root."""
    return 0.5 + radius - math.sqrt(radius**2 - 0.375**2)


def test_the_default_leaves_its_mold_freely(yamada: Design) -> None:
    assert {u.width for u in skin_of(yamada).undercuts.values()} == {0.0}


@pytest.mark.parametrize("radius", [12.0, 20.0, 60.0])
def test_undercut_of_a_leaning_upright_flank_is_its_closed_form(radius: float) -> None:
    """A flank that leans by a overhangs by its length x sin a; the ridge's level is 0.75 / cos a wide."""
    undercuts, lean = skin_of(upright(radius)).undercuts, 4 / radius
    width = flank(radius) * math.sin(lean)
    # chords of 1e-5 mm, and levels between the polygons' corners
    assert undercuts[9].width == pytest.approx(width, abs=1e-4)
    assert undercuts[9].strain == pytest.approx(width * math.cos(lean) / 0.75, abs=2e-4)
    assert undercuts[1] == pytest.approx(undercuts[9], abs=1e-9)  # mirror images, to rounding
    assert undercuts[5] == (0.0, 0.0)


def test_the_silicone_decides_whether_it_leaves() -> None:
    """0.2 squeezed: a fifth of Sylgard's 120 % is a stretch of 1.24, a squeeze of 0.19; Dragon Skin's 364 %
    takes 0.42."""
    stiff = upright(12.0, material={"name": "sylgard-184"})
    assert safe_strain(stiff) == pytest.approx(1 - 1 / (1 + SAFE_SHARE * 1.2), rel=1e-12)
    errors = [f for f in design_findings(Job(stiff)) if f.rule == "undercut" and f.severity == "error"]
    assert {f.where.split(",")[0] for f in errors} == {"ridge 1", "ridge 9"}
    closed_form = flank(12.0) * math.sin(1 / 3) * math.cos(1 / 3) / 0.75
    assert all(f.measured == pytest.approx(closed_form, abs=2e-4) for f in errors)
    soft = [f for f in design_findings(Job(upright(12.0))) if f.rule == "undercut"]
    assert len(soft) == 8
    assert {f.severity for f in soft} == {"note"}
    assert "364 % elongation" in soft[0].remedy


def test_what_leans_more_than_it_is_wide_is_locked() -> None:
    locked = skincad.load("plain-ridges").with_(
        skin={"curvature_radius": 9.0, "thickness": 4.0},
        ridge={
            "height": 2.0,
            "count": 7,
            "pitch": 1.3,
            "root_width": 0.5,
            "tip_width": 0.5,
            "crown": 0.0,
            "tip_fillet": 0.0,
            "root_fillet": 0.0,
        },
    )
    assert skin_of(locked).undercuts[7].strain == 1.0
    assert any(f.severity == "error" for f in design_findings(Job(locked)) if f.rule == "undercut")


def test_the_draft_told_is_just_enough() -> None:
    design = upright(20.0)
    root, tip = freeing_widths(Job(design))
    assert root is not None
    assert tip is not None
    for key, value, back in (("root_width", root, -0.005), ("tip_width", tip, 0.005)):
        assert not any(u.width for u in skin_of(design.with_(ridge={key: value})).undercuts.values())
        assert any(u.width for u in skin_of(design.with_(ridge={key: value + back})).undercuts.values())
    remedy = next(f.remedy for f in design_findings(Job(design)) if f.rule == "undercut")
    assert f"root_width of {root:g} mm" in remedy
    assert f"tip_width of {tip:g} mm" in remedy


def test_a_root_that_the_pitch_forbids_is_not_told() -> None:
    root, tip = freeing_widths(Job(upright(12.0, material={"name": "sylgard-184"})))
    assert root is None  # 0.75 + 0.36 is above the pitch
    assert tip is not None


def test_a_split_cavity_is_advised_unless_the_cavity_is_split() -> None:
    for split, advised in (("none", True), ("auto", False)):
        findings = [
            f for f in design_findings(Job(upright(12.0, mold={"split": split}))) if f.rule == "undercut"
        ]
        assert findings
        assert all(('a split cavity (mold.split = "auto")' in f.remedy) == advised for f in findings)
