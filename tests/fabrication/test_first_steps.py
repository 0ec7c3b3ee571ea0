"""The first step of the casting sheet names what the plan has, part by part."""

from __future__ import annotations

import pytest

from skincad.fabrication import Job, sheet_steps
from tests.templates import of_one_printer


def words(name: str, settings: list[str]) -> str:
    design = of_one_printer(name, settings)
    return sheet_steps(Job(design))["prepare"]


@pytest.mark.parametrize(
    ("name", "settings", "told"),
    [
        ("yamada-2002", [], "Tap the M3 threads of cavity, end-b-comb, end-b-keeper and carrier."),
        ("yamada-2002", [], "Press the dowel pins into cavity and cover."),
        ("yamada-2002", [], "each shim drops into its notches"),
        ("lab-bench", [], "Set the M3 inserts (glued) into cavity."),
        ("lab-bench", [], "Wash all parts in 2 baths of isopropanol, 5 min each."),
        ("nozzle-04", [], "Set the M3 inserts (heat-set) into cavity."),
        ("cast-in", [], "a spare strip drops into each notch"),
        ("steep-fingertip", [], "Press the dowel pins into"),
        ("yamada-2002", ["skin.curvature_radius_y=200"], "Press the dowel pins into cavity"),
        ("yamada-2002", ["mold.lid_process=sla"], "Wash carrier and cover in 2 baths of isopropanol"),
    ],
)
def test_what_is_done_to_the_parts(name: str, settings: list[str], told: str) -> None:
    assert told in words(name, settings)


def test_nothing_is_said_that_the_mold_has_not() -> None:
    plain, metal = words("plain-ridges", []), words("yamada-2002", [])
    assert "shim" not in plain
    assert "strip" not in plain
    assert "insert" not in metal
    assert "resin" not in metal
