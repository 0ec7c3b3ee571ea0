"""Numbers of a result's JSON by their keys."""

from __future__ import annotations

import pytest

import skincad
from skincad.base.errors import InputError
from skincad.base.estimate import Estimate
from skincad.studies.query import measures, resolved, slack, unit_of_key, worded

CHECK = measures(skincad.check(skincad.load_design("yamada-2002"), model="winkler").as_json())
GAIN = measures(skincad.gain(skincad.load_circuit("transimpedance")).as_json())


def test_estimates_keep_their_error_and_unit() -> None:
    found = skincad.check(skincad.load_design("yamada-2002"), model="winkler")
    assert CHECK["all_touch_force_N"] == found.all_touch_force
    assert CHECK["ridge_force_N.3"] == found.ridge_force[2]
    assert GAIN["cutoff_Hz"].unit == "Hz"
    assert GAIN["slope_below_dB_per_dec"].unit == "dB/dec"


def test_plain_numbers_flags_and_nulls_are_numbers_too() -> None:
    assert CHECK["passed"] == Estimate(0.0, 0.0, "")
    assert CHECK["ridges"].value == 9
    assert CHECK["yield"].value is None
    assert CHECK["left_out.friction.all_touch_force"].error is None


def test_lists_count_from_one_and_long_ones_are_told_by_their_ends() -> None:
    assert "ridge_force_N.9" in CHECK
    assert "ridge_force_N.0" not in CHECK
    assert "gain_dB.1" not in GAIN
    gain = skincad.gain(skincad.load_circuit("transimpedance")).gain
    assert GAIN["gain_dB.max"].value == gain.max()
    assert GAIN["gain_dB.last"].value == gain[-1]


def test_lists_of_anything_else_are_counted() -> None:
    found = measures({"findings": [{"rule": "detail", "measured": 1.0}, {"rule": "reach"}], "warnings": []})
    assert found["findings.count"].value == 2
    assert found["warnings.count"].value == 0
    assert not any(key.startswith("ridge_force") and key.endswith("count") for key in CHECK)


def test_an_error_beside_a_number_is_its_own() -> None:
    found = measures({"yield": 0.9, "yield_error": 0.01, "parts": [{"name": "cavity", "volume_mm3": 3.0}]})
    assert found["yield"] == Estimate(0.9, 0.01, "")
    assert "yield_error" not in found
    assert found["parts.cavity.volume_mm3"] == Estimate(3.0, None, "mm3")


def test_a_key_may_leave_its_unit_out() -> None:
    for key in ("all_touch_force", "all_touch_force_N"):
        assert resolved(key, CHECK) == "all_touch_force_N"
    assert resolved("ridge_force.3", CHECK) == "ridge_force_N.3"
    assert resolved("passed", CHECK) == "passed"
    with pytest.raises(InputError, match="did you mean 'all_touch_force'"):
        resolved("all_touch_forc", CHECK)
    with pytest.raises(InputError, match=r"known: all_touch_force, approach, .*yield") as refused:
        resolved("xyz", CHECK)
    assert "ridge_force.1" not in str(refused.value)  # all entries of all lists would be no help


def test_words_and_units() -> None:
    assert worded("all_touch_force_N", 3.0) == "all_touch_force 3 N"
    assert worded("ridge_force_N.3", Estimate(0.5, 0.01, "N")) == "ridge_force.3 0.500 ± 0.010 N"
    assert worded("yield", 0.9) == "yield 0.9"
    assert unit_of_key("crest_sensitivity_N_per_mm.1") == "N/mm"
    assert unit_of_key("ridges") == ""
    assert slack(Estimate(1.0, None, "N")) == 0.0
