"""Keys of a subject: their ranges and choices, their values changed, and the numbers of a result."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import skincad
from skincad.base import Estimate, InputError, Record, ReportedProperty, item, record, unit_of_key
from skincad.inputs.material import silicone
from skincad.studies import changed, knob, load_subject, texts, value_of, worded
from skincad.studies.query import resolved, slack
from skincad.studies.subject import fingerprint, nearest_silicone

DESIGN = skincad.load_design("yamada-2002")
SCENE = skincad.load_scene("yamada-2002-press")
CIRCUIT = skincad.load_circuit("transimpedance")


def test_a_range_is_told_as_text_or_as_a_tuple_and_once() -> None:
    for entry in ("20:200", (20, 200)):
        answer = knob(DESIGN, "skin.curvature_radius", entry)
        assert (answer.low, answer.high, answer.count, answer.unit, answer.start) == (20, 200, None, "mm", 60)
    heights = knob(DESIGN, "ridge.height", "0.4:1.3:10").values()
    assert heights == pytest.approx([0.4 + 0.1 * i for i in range(10)])
    assert knob(DESIGN, "skin.length", "20").choices == (20.0,)  # a choice of one
    assert str(answer) == "skin.curvature_radius=20:200"
    with pytest.raises(InputError, match=r"write ridge.height=0.4:1.3:10"):
        knob(DESIGN, "ridge.height", "0.4:1.3").values()
    assert texts(["a=1:2", "b = all"], "vary") == {"a": "1:2", "b": "all"}
    for wrong in (["a"], ["a="], ["=1"], ["a=1", "a=2"]):
        with pytest.raises(InputError):
            texts(wrong, "vary")


def test_ranges_go_by_ratios_or_differences_and_whole_numbers_stay_whole() -> None:
    wide, narrow = knob(DESIGN, "skin.curvature_radius", (20, 200)), knob(DESIGN, "ridge.height", (0.5, 0.7))
    assert wide.at(0.5) == pytest.approx(20 * 10**0.5, rel=1e-4)  # five digits are told
    assert narrow.at(0.5) == pytest.approx(0.6, rel=1e-4)
    for entry in (wide, narrow):
        assert [entry.at(0.0), entry.at(1.0)] == [entry.low, entry.high]
        assert entry.share(float(entry.at(0.3))) == pytest.approx(0.3, abs=1e-4)
    answer = knob(DESIGN, "ridge.count", "5:9")
    assert answer.whole
    assert answer.values() == (5, 6, 7, 8, 9)
    assert [answer.at(share) for share in (0.0, 0.5, 1.0)] == [5, 7, 9]
    assert knob(DESIGN, "ridge.count", "5:9:3").values() == (5, 7, 9)
    assert all(isinstance(value, int) for value in answer.values())


def test_names_are_of_the_catalogue_keys_of_all_subjects() -> None:
    names = knob(DESIGN, "material.name", "all").choices
    assert {"dragon-skin-30", "ecoflex-00-30"} <= set(names)
    assert knob(DESIGN, "mold.process", "all").choices == ("cnc", "edm", "fdm", "sla")
    assert set(knob(DESIGN, "mold.method", "all").choices) == {"shim", "cast-in"}
    two = "dragon-skin-30,ecoflex-00-30"
    assert knob(DESIGN, "material.name", two).choices == tuple(two.split(","))
    assert knob(DESIGN, "skin.length", [10.0, 12.0]).choices == (10.0, 12.0)
    assert "dragon-skin-30" in knob(SCENE, "skin.material.name", "all").choices
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


FELT = skincad.load_scene("yamada-2002-slip", ["effects.piezo.circuit=transimpedance"])


def test_a_name_or_a_file_is_known_by_its_kind(tmp_path: Path) -> None:
    kinds = {"plain-ridges": "Design", "yamada-2002-press": "Scene", "transimpedance": "Circuit"}
    for name, kind in kinds.items():
        data = load_subject(name)
        assert type(data).__name__ == kind
        path = tmp_path / f"{name}.toml"
        path.write_text(data.to_toml())
        assert load_subject(path) == data
    assert load_subject("yamada-2002", ["ridge.count=7"]).ridge.count == 7
    with pytest.raises(InputError, match="did you mean 'yamada-2002'"):
        load_subject("yamda-2002")
    for source, extra in (("transimpedance", {"silicones": {}}), ("yamada-2002-press", {"printer": {}})):
        with pytest.raises(InputError, match="leave"):
            load_subject(source, **extra)


@pytest.mark.parametrize(
    ("subject", "key", "value"),
    [
        (DESIGN, "skin.curvature_radius", 76.5),
        (DESIGN, "ridge.count", 7),
        (DESIGN, "material.young_modulus", 0.4),
        (DESIGN, "mold.process", "sla"),
        (DESIGN, "contact.friction", 0.5),
        (SCENE, "skin.ridge.height", 0.45),
        (SCENE, "skin.skin.length", 11.0),
        (SCENE, "effects.friction.coefficient", 0.3),
        (SCENE, "history.normal_force_N.2", 3.5),
        (CIRCUIT, "amplifier.feedback_resistance", 2e8),
        (FELT, "circuit.amplifier.feedback_resistance", 2e8),
        (FELT, "circuit.cable.capacitance", 2e-11),
    ],
)
def test_a_changed_key_changes_nothing_else(subject: Any, key: str, value: float | str) -> None:
    before = value_of(subject, key)
    answer = changed(subject, {key: value})
    assert value_of(answer, key) == value
    assert fingerprint(answer) != fingerprint(subject)
    if before is not None:
        assert fingerprint(changed(answer, {key: before})) == fingerprint(changed(subject, {key: before}))


def test_a_modulus_takes_its_range_along_and_names_the_nearest_silicone() -> None:
    before, after = silicone(DESIGN).young_modulus, silicone(changed(DESIGN, {"material.young_modulus": 0.4}))
    for end in ("low", "high"):
        scaled = getattr(before, end) * 0.4 / before.value
        assert getattr(after.young_modulus, end) == pytest.approx(scaled)
    exact = DESIGN.with_(material={"name": None, "young_modulus": 0.8})
    for value in (0.8, 0.1, 0.3, 1.7):  # so does one without a range
        modulus = silicone(changed(exact, {"material.young_modulus": value})).young_modulus
        assert modulus.low == modulus.value == modulus.high == value
    assert nearest_silicone(DESIGN, "material.young_modulus", 0.8) == "dragon-skin-30"
    assert nearest_silicone(DESIGN, "skin.length", 0.46) is None
    assert nearest_silicone(SCENE, "skin.material.young_modulus", 0.8) == "dragon-skin-30"
    soft = changed(changed(DESIGN, {"material.young_modulus": 0.4}), {"material.name": "ecoflex-00-30"})
    assert value_of(soft, "material.young_modulus") == pytest.approx(0.07)


def test_what_the_rules_forbid_is_refused_and_a_circuits_keys_need_an_amplifier() -> None:
    with pytest.raises(InputError, match=r"skin\.ridge\.count"):
        changed(SCENE, {"skin.ridge.count": -1})
    with pytest.raises(InputError, match=r"skin\.length"):
        changed(DESIGN, {"skin.length": -1.0})
    with pytest.raises(InputError, match=r"circuit.amplifier.gain: needs an amplifier.*effects.piezo"):
        knob(SCENE, "circuit.amplifier.gain", "1:2")
    with pytest.raises(InputError, match=r"circuit.amplifier.gian: unknown key; did you mean 'gain'"):
        knob(FELT, "circuit.amplifier.gian", "1:2")
    with pytest.raises(InputError, match=r"circuit.amplifier.gain: must be greater than 0"):
        changed(FELT, {"circuit.amplifier.gain": -1.0})


def test_the_hash_is_of_what_would_answer_otherwise(tmp_path: Path) -> None:
    assert fingerprint(DESIGN) == fingerprint(DESIGN.with_(name="other"))
    assert fingerprint(DESIGN) != fingerprint(SCENE)
    own = tmp_path / "own.toml"
    own.write_text(CIRCUIT.to_toml())
    felt = skincad.load_scene("yamada-2002-press").with_(effects={"film": {}, "piezo": {"circuit": str(own)}})
    before = fingerprint(felt)
    own.write_text(CIRCUIT.with_(amplifier={"gain": 1e4}).to_toml())
    assert fingerprint(felt) != before  # the file's text counts, not its name


def test_a_scenes_keys_change_together(tmp_path: Path) -> None:
    values = {"skin.ridge.height": 0.45, "circuit.amplifier.feedback_resistance": 3e7}
    values |= {"circuit.name": "own", "readout.bandwidth_Hz": 3000.0}
    answer = changed(FELT, values)
    assert {key: value_of(answer, key) for key in values} == values
    assert answer.effects["piezo"].keys() == FELT.effects["piezo"].keys()
    path = tmp_path / "scene.toml"
    path.write_text(answer.to_toml())
    assert fingerprint(load_subject(path)) == fingerprint(answer)
    both = {"effects.piezo.circuit": "charge-amplifier", "circuit.amplifier.feedback_resistance": 3e7}
    answer = changed(FELT, both)
    assert value_of(answer, "circuit.name") == "charge-amplifier"
    assert value_of(answer, "circuit.amplifier.feedback_resistance") == 3e7
    tilted = changed(FELT, {"skin": "yamada-2002-tilted", "skin.skin.thickness": 4.5})
    assert value_of(tilted, "skin.name") == "yamada-2002-tilted"
    assert value_of(tilted, "skin.skin.thickness") == 4.5


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
NUMBERS = skincad.check(skincad.load_design("yamada-2002"), model="winkler").numbers()
GAIN = skincad.gain(skincad.load_circuit("transimpedance")).numbers()


def test_estimates_flags_and_nulls_are_numbers_with_their_units() -> None:
    verdict = skincad.check(skincad.load_design("yamada-2002"), model="winkler")
    assert NUMBERS["all_touch_force_N"] == verdict.all_touch_force
    assert NUMBERS["ridge_force_N.3"] == verdict.ridge_force[2]
    assert GAIN["cutoff_Hz"].unit == "Hz"
    assert GAIN["slope_below_dB_per_dec"].unit == "dB/dec"
    assert NUMBERS["passed"] == Estimate(0.0, 0.0, "")
    assert NUMBERS["ridges"].value == 9
    assert NUMBERS["yield"].value is None
    assert NUMBERS["left_out.friction.all_touch_force"].error is None


def test_lists_count_from_one_are_told_by_their_ends_or_counted() -> None:
    assert "ridge_force_N.9" in NUMBERS
    assert "ridge_force_N.0" not in NUMBERS
    assert "gain_dB.1" not in GAIN
    gain = skincad.gain(skincad.load_circuit("transimpedance")).gain
    assert GAIN["gain_dB.max"].value == gain.max()
    assert GAIN["gain_dB.last"].value == gain[-1]
    assert SHELF.numbers()["parts.count"].value == 1
    assert SHELF.numbers()["notes.count"].value == 0
    assert not any(key.startswith("ridge_force") and key.endswith("count") for key in NUMBERS)


def test_a_record_gives_each_attribute_once_with_its_own_error() -> None:
    parts = [{"name": "cavity", "volume_mm3": 3.0}]
    data = {"name": "shelf", "load_N": 0.9, "load_N_error": 0.01, "parts": parts, "notes": []}
    assert SHELF.as_json() == data | {"remark": None, "heights_mm": [1.0, 2.0]}
    assert next(iter(SHELF.as_json())) == "name"  # what a reader looks for first
    numbers = SHELF.numbers()
    assert numbers["load_N"] == Estimate(0.9, 0.01, "N")
    assert "load_N_error" not in numbers
    assert numbers["parts.cavity.volume_mm3"] == Estimate(3.0, None, "mm3")

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
    modules = ("mechanics.check", "scenes.simulation", "circuit.bode", "material.modulus", "live.desk")
    for module in (*modules, "fabrication.making", "fabrication.coupon", "studies.optimising"):
        import_module(f"skincad.{module}")
    ours = [kind for kind in subclasses(Record) if kind.__module__.startswith("skincad.")]
    kinds = [kind for kind in ours if is_dataclass(kind)]
    assert len(kinds) > 20
    for kind in kinds:
        listed = {f.name: f.metadata["item"] for f in fields(kind) if "item" in f.metadata}
        listed |= {
            name: value.item for name, value in vars(kind).items() if isinstance(value, ReportedProperty)
        }
        for name, declared in listed.items():
            assert declared.meaning or declared.inline, f"{kind.__name__}.{name}"


def test_a_key_may_leave_its_unit_out_and_is_worded_with_it() -> None:
    for key in ("all_touch_force", "all_touch_force_N"):
        assert resolved(key, NUMBERS) == "all_touch_force_N"
    assert resolved("ridge_force.3", NUMBERS) == "ridge_force_N.3"
    assert resolved("passed", NUMBERS) == "passed"
    with pytest.raises(InputError, match="did you mean 'all_touch_force'"):
        resolved("all_touch_forc", NUMBERS)
    with pytest.raises(InputError, match=r"known: all_touch_force, approach, .*yield") as refused:
        resolved("xyz", NUMBERS)
    assert "ridge_force.1" not in str(refused.value)  # all entries of all lists would be no help
    assert worded("all_touch_force_N", 3.0) == "all_touch_force 3 N"
    assert worded("ridge_force_N.3", Estimate(0.5, 0.01, "N")) == "ridge_force.3 0.500 ± 0.010 N"
    assert worded("yield", 0.9) == "yield 0.9"
    assert unit_of_key("crest_sensitivity_N_per_mm.1") == "N/mm"
    assert unit_of_key("ridges") == ""
    assert slack(Estimate(1.0, None, "N")) == 0.0
