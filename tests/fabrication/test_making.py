"""What `make` asks the check for: by which model, in which time, or nothing."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import skincad
from skincad.base.errors import InputError
from skincad.fabrication.making import MakeResult
from skincad.inputs.design import Design
from tests.conftest import run_skincad


@pytest.fixture(scope="module")
def small() -> Design:
    """Three ridges that do not all touch at their force."""
    return skincad.load("plain-ridges").with_(
        ridge={"count": 3}, skin={"width": 5.0}, contact={"force": 0.01}
    )


@pytest.fixture(scope="module")
def unchecked(small: Design) -> MakeResult:
    return skincad.make(small, checked=False)


def test_without_a_check_the_findings_alone_decide(small: Design, unchecked: MakeResult) -> None:
    judged = skincad.make(small, tier="winkler")
    assert judged.check is not None
    assert judged.check.tier == "winkler"
    assert (judged.passed, unchecked.passed) == (False, True)
    assert unchecked.check is None
    assert unchecked.findings == judged.findings
    assert "contact check" not in unchecked.seconds


def test_everything_says_that_nobody_asked(unchecked: MakeResult, tmp_path: Path) -> None:
    assert str(unchecked).startswith("Not checked whether all ridges touch.")
    assert unchecked.as_json()["check"] is None
    skincad.write(unchecked, tmp_path / "made", formats=["md", "html"])
    for name in ("casting-sheet.md", "casting-sheet.html"):
        assert "Not checked whether all ridges touch." in (tmp_path / "made" / name).read_text("utf-8")
    assert json.loads((tmp_path / "made" / "make.json").read_text())["all_touch_force_N"] is None


def test_the_command_leaves_the_check_out(tmp_path: Path) -> None:
    few = ("--set", "ridge.count=1", "--set", "skin.width=3.0", "--format", "toml")
    done = run_skincad("make", "plain-ridges", *few, "--no-check", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("Not checked whether all ridges touch.\nParts:")


@pytest.mark.parametrize(
    ("asked", "says"),
    [
        (("--tier", "lineer"), "did you mean 'linear'"),
        (("--budget", "-1"), "budget"),
        (("--no-check", "--tier", "linear"), "tier: is the check's, which is left out"),
        (("--no-check", "--budget", "3"), "budget: is the check's, which is left out"),
    ],
)
def test_what_the_check_does_not_take_is_told_before_any_work(
    asked: tuple[str, ...], says: str, tmp_path: Path
) -> None:
    done = run_skincad("make", "plain-ridges", *asked, cwd=tmp_path)
    assert done.returncode == 2
    assert says in done.stderr
    assert done.stderr.count("\n") == 1
    assert not [*tmp_path.iterdir()]
    with pytest.raises(InputError):
        skincad.make(skincad.load("plain-ridges"), checked=False, budget=1.0)
