"""Numbers of a result by their keys, with unit and error."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from importlib import import_module

import numpy as np
import pytest

import skincad
from skincad.base import Estimate, InputError, Record, ReportedProperty, item, record, unit_of_key
from skincad.studies import worded
from skincad.studies.query import resolved, slack


@record()
class _Part(Record):
    name: str = item(meaning="of the part")
    volume: float = item("mm3", "of the part")


@record()
class _Shelf(Record):
    load: float = item("N", "that it carries", error="error")
    error: float = item(key="load_N_error")
    parts: tuple[_Part, ...] = item(meaning="on it")
    notes: tuple[str, ...] = item(meaning="none", default=())
    remark: str = item(meaning="none", null=True, default="")
    heights: np.ndarray = item("mm", "of each board")
    aside: int = 0  # not reported
    name: str = item(meaning="its name", default="shelf")


SHELF = _Shelf(load=0.9, error=0.01, parts=(_Part(name="cavity", volume=3.0),), heights=np.array([1.0, 2.0]))
CHECK = skincad.check(skincad.load_design("yamada-2002"), model="winkler").numbers()
GAIN = skincad.gain(skincad.load_circuit("transimpedance")).numbers()


def test_estimates_keep_their_error_and_unit() -> None:
    verdict = skincad.check(skincad.load_design("yamada-2002"), model="winkler")
    assert CHECK["all_touch_force_N"] == verdict.all_touch_force
    assert CHECK["ridge_force_N.3"] == verdict.ridge_force[2]
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
    assert SHELF.numbers()["parts.count"].value == 1
    assert SHELF.numbers()["notes.count"].value == 0
    assert not any(key.startswith("ridge_force") and key.endswith("count") for key in CHECK)


def test_an_error_beside_a_number_is_its_own() -> None:
    numbers = SHELF.numbers()
    assert numbers["load_N"] == Estimate(0.9, 0.01, "N")
    assert "load_N_error" not in numbers
    assert numbers["parts.cavity.volume_mm3"] == Estimate(3.0, None, "mm3")


def test_json_has_a_key_for_each_declared_attribute() -> None:
    assert SHELF.as_json() == {
        "name": "shelf",
        "load_N": 0.9,
        "load_N_error": 0.01,
        "parts": [{"name": "cavity", "volume_mm3": 3.0}],
        "notes": [],
        "remark": None,
        "heights_mm": [1.0, 2.0],
    }
    assert next(iter(SHELF.as_json())) == "name"  # what a reader looks for first


def test_two_attributes_of_one_key_are_a_mistake() -> None:
    @record()
    class Twice(Record):
        first: int = item(key="a")
        second: int = item(key="a")

    with pytest.raises(ValueError, match="Twice gives 'a' twice: rename one of them"):
        Twice(first=1, second=2).as_json()


def subclasses(kind: type) -> set[type]:
    below = kind.__subclasses__()
    return {*below, *(one for other in below for one in subclasses(other))}


def test_every_reported_attribute_says_what_it_means() -> None:
    for module in ("mechanics.check", "scenes.simulation", "circuit.bode", "material.modulus", "live.desk"):
        import_module(f"skincad.{module}")
    for module in ("fabrication.making", "fabrication.coupon_reading", "studies.optimising"):
        import_module(f"skincad.{module}")
    kinds = [
        kind for kind in subclasses(Record) if is_dataclass(kind) and kind.__module__.startswith("skincad.")
    ]
    assert len(kinds) > 20
    for kind in kinds:
        listed = {f.name: f.metadata["item"] for f in fields(kind) if "item" in f.metadata}
        listed |= {
            name: value.item for name, value in vars(kind).items() if isinstance(value, ReportedProperty)
        }
        for name, declared in listed.items():
            assert declared.meaning or declared.inline, f"{kind.__name__}.{name}"


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
