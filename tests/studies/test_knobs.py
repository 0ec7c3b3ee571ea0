"""Keys and their values, as they are written on the command line and in Python."""

from __future__ import annotations

from typing import Any

import pytest

import skincad
from skincad.base import InputError
from skincad.studies import knob, texts
from skincad.studies.subject import nearest_silicone

DESIGN = skincad.load_design("yamada-2002")
SCENE = skincad.load_scene("yamada-2002-press")
CIRCUIT = skincad.load_circuit("transimpedance")


def test_a_range_is_told_as_text_or_as_a_tuple() -> None:
    for entry in ("20:200", (20, 200)):
        answer = knob(DESIGN, "skin.curvature_radius", entry)
        assert (answer.low, answer.high, answer.count, answer.unit, answer.start) == (20, 200, None, "mm", 60)
    assert knob(DESIGN, "ridge.height", "0.4:1.3:10").values() == pytest.approx(
        [0.4 + 0.1 * i for i in range(10)]
    )
    assert knob(DESIGN, "skin.length", "20").choices == (20.0,)  # a choice of one
    assert str(answer) == "skin.curvature_radius=20:200"


def test_wide_ranges_go_by_ratios_and_narrow_ones_by_differences() -> None:
    wide, narrow = knob(DESIGN, "skin.curvature_radius", (20, 200)), knob(DESIGN, "ridge.height", (0.5, 0.7))
    assert wide.at(0.5) == pytest.approx(20 * 10**0.5, rel=1e-4)  # five digits are told
    assert narrow.at(0.5) == pytest.approx(0.6, rel=1e-4)
    for entry in (wide, narrow):
        assert [entry.at(0.0), entry.at(1.0)] == [entry.low, entry.high]
        assert entry.share(float(entry.at(0.3))) == pytest.approx(0.3, abs=1e-4)


def test_whole_numbers_stay_whole() -> None:
    answer = knob(DESIGN, "ridge.count", "5:9")
    assert answer.whole
    assert answer.values() == (5, 6, 7, 8, 9)
    assert [answer.at(share) for share in (0.0, 0.5, 1.0)] == [5, 7, 9]
    assert knob(DESIGN, "ridge.count", "5:9:3").values() == (5, 7, 9)
    assert all(isinstance(value, int) for value in answer.values())


def test_names_are_taken_from_the_catalogue() -> None:
    names = knob(DESIGN, "material.name", "all").choices
    assert {"dragon-skin-30", "ecoflex-00-30"} <= set(names)
    assert knob(DESIGN, "mold.process", "all").choices == ("cnc", "edm", "fdm", "sla")
    assert set(knob(DESIGN, "mold.method", "all").choices) == {"shim", "cast-in"}
    assert knob(DESIGN, "material.name", "dragon-skin-30,ecoflex-00-30").choices == (
        "dragon-skin-30",
        "ecoflex-00-30",
    )
    assert knob(DESIGN, "skin.length", [10.0, 12.0]).choices == (10.0, 12.0)
    assert "dragon-skin-30" in knob(SCENE, "skin.material.name", "all").choices


def test_keys_of_scenes_circuits_and_inner_tables() -> None:
    assert knob(SCENE, "skin.ridge.height", (0.4, 0.6)).unit == "mm"
    assert knob(SCENE, "effects.friction.coefficient", (0.1, 1.0)).low == 0.1
    assert knob(SCENE, "history.normal_force_N.2", (1.0, 4.0)).start == 4.0
    assert knob(CIRCUIT, "amplifier.feedback_resistance", (1e7, 1e9)).start == 1e8
    assert knob(DESIGN, "contact.plate.tilt", (-1.0, 1.0)).start is None
    assert knob(DESIGN, "material.young_modulus", (0.1, 1.0)).start == pytest.approx(0.8)
    assert knob(DESIGN, "printer.mine.crest_sigma", (0.01, 0.1)).start is None


@pytest.mark.parametrize(
    ("key", "told", "says"),
    [
        ("skin.curvature_radis", "20:200", "did you mean 'curvature_radius'"),
        ("skn.curvature_radius", "20:200", "did you mean 'skin'"),
        ("skin", "20:200", "is a table"),
        ("skin.length", "20:", "empty place"),
        ("skin.length", "200:20", "empty range"),
        ("skin.length", "20:20", "empty range"),
        ("skin.length", "a:b", "range of numbers"),
        ("skin.length", "1:inf", "range of numbers"),
        ("skin.length", "1:2:3:4", "range of numbers"),
        ("skin.length", "1:2:1", "from 2 to"),
        ("skin.length", "1:2:2.5", "from 2 to"),
        ("skin.length", "all", "no list of names"),
        ("ridge.count", "5.5:9", "whole numbers"),
        ("material.name", "1:2", "holds no number"),
        ("material.name", "dragon-skin-31", "did you mean 'dragon-skin-30'"),
        ("name", "all", "no list of names"),
        ("skin.length", (), "needs values"),
        ("skin.length", "8-12", "must be numbers"),
    ],
)
def test_what_can_not_be_used_is_said_in_one_line(key: str, told: Any, says: str) -> None:
    with pytest.raises(InputError, match=says) as refused:
        knob(DESIGN, key, told)
    assert refused.value.key == key
    assert "\n" not in str(refused.value)


def test_a_grid_needs_a_number_of_values() -> None:
    with pytest.raises(InputError, match=r"write ridge.height=0.4:1.3:10"):
        knob(DESIGN, "ridge.height", "0.4:1.3").values()


def test_options_are_told_once_each() -> None:
    assert texts(["a=1:2", "b = all"], "vary") == {"a": "1:2", "b": "all"}
    for wrong in (["a"], ["a="], ["=1"], ["a=1", "a=2"]):
        with pytest.raises(InputError):
            texts(wrong, "vary")


def test_the_nearest_silicone_of_a_modulus() -> None:
    assert nearest_silicone(DESIGN, "material.young_modulus", 0.8) == "dragon-skin-30"
    assert nearest_silicone(DESIGN, "skin.length", 0.46) is None
    assert nearest_silicone(SCENE, "skin.material.young_modulus", 0.8) == "dragon-skin-30"
