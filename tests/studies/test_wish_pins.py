"""Wishes for pins: met ones pass and can be cast, others name what breaks; and what a family starts from."""

from __future__ import annotations

from pathlib import Path

import pytest

import skincad
from skincad.fabrication import Job, design_findings
from skincad.shape import FAMILIES
from tests.conftest import run_skincad
from tests.refusals import refused_by, refused_command


@pytest.mark.slow
@pytest.mark.parametrize(("size", "touch"), [("24x30", 1.0), ("15x15", 4.0)])
def test_a_wish_for_pins_is_met_by_a_design_that_passes_and_can_be_cast(size: str, touch: float) -> None:
    result = skincad.design_for(family="pin", size=size, touch=touch)
    assert result.passed
    assert result.design.features.family == "pin"
    verdict = skincad.check(result.design, model="reduced")
    assert verdict.passed
    assert verdict.force == touch
    assert all(finding.severity == "note" for finding in design_findings(Job(result.design)))
    assert {"pin.pitch", "pin.height", "skin.curvature_radius"} <= {choice.key for choice in result.choices}


@pytest.mark.slow
def test_a_force_that_pins_cannot_bear_is_named() -> None:
    result = skincad.design_for(family="pin", size="10x10", touch=300.0, silicone="ecoflex-00-30")
    assert [broken.wish for broken in result.broken] == ["touch"]
    assert result.check.passed
    assert result.design.contact.force < 300.0


@pytest.mark.parametrize("family", FAMILIES)
def test_a_family_alone_copies_its_first_template(family: str, tmp_path: Path) -> None:
    result = run_skincad("new", "pad.toml", "--family", family, cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert skincad.load(tmp_path / "pad.toml").features.family == family


def test_what_no_wish_is_is_one_line(tmp_path: Path) -> None:
    assert "--family" in refused_command("new", "pad.toml", "--family", "ring", "--touch", "2N", cwd=tmp_path)
    assert "--film" in refused_command("new", "pad.toml", "--family", "pin", "--film", "0.03mm", cwd=tmp_path)
    both = refused_command("new", "pad.toml", "--family", "pin", "--template", "rings-5", cwd=tmp_path)
    assert "--family" in both
    with refused_by("family"):
        skincad.design_for(family="flat")
    with refused_by("film"):
        skincad.design_for(family="pin", film=0.1)
