"""What is typed: names and files of each kind, what takes another kind, how a document is got again; and what
`--set` reads."""

from __future__ import annotations

import random
import re
import shlex
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from pydantic import BaseModel

import skincad
from skincad.base import InputError, table_of
from skincad.circuit import Circuit, load_circuit
from skincad.inputs import (
    KINDS,
    Design,
    Kind,
    display_name,
    load,
    load_design,
    overridden,
    retyped,
    template_names,
    template_text,
)
from skincad.scenes import Scene, load_scene
from skincad.studies import changed, load_study, points_of, value_of
from tests.refusals import refused_by, refused_command

LOAD: dict[Kind, Callable] = {"designs": load, "scenes": load_scene, "circuits": load_circuit}
TAKERS = {"designs": "make, check or accuracy", "scenes": "simulate", "circuits": "circuit"}


@pytest.mark.parametrize("wanted", KINDS)
@pytest.mark.parametrize("given", KINDS)
def test_what_takes_another_kind_says_what_takes_this(wanted: Kind, given: Kind, tmp_path: Path) -> None:
    for name in template_names(given):
        file = tmp_path / f"{name}.toml"
        file.write_text(template_text(name, given))
        for source in (name, file):
            if name in template_names(wanted) and (source == name or wanted == given):
                LOAD[wanted](source)
                continue
            with pytest.raises(InputError) as refusal:
                LOAD[wanted](source)
            assert refusal.value.key == str(source)[:80]
            assert f"a {given[:-1]}" in refusal.value.rule
            assert refusal.value.rule.endswith(f", not a {wanted[:-1]}")
            assert TAKERS[given] in refusal.value.remedy


def test_two_kinds_tables_and_a_scene_for_a_skin_are_told(tmp_path: Path) -> None:
    with pytest.raises(InputError) as refusal:
        load_scene("yamada-2002")
    both = "give it to make, check or accuracy, or to circuit"
    assert str(refusal.value) == f"yamada-2002: is a design and a circuit, not a scene; {both}"
    for text, what in (
        ("[lab-10]\nyoung_modulus = 0.2", "a table of silicones, not a design; give it to --silicones"),
        ("[sla]\nlayer = 0.1", "a table of processes, not a design; give it to --printer"),
    ):
        (tmp_path / "own.toml").write_text(text)
        with pytest.raises(InputError, match=what):
            load(tmp_path / "own.toml")
    with pytest.raises(InputError) as refusal:
        load_scene("hold", ["skin=drop"])
    assert str(refusal.value) == "skin: is a scene, not a design, got 'drop'; give it to simulate"
    (tmp_path / "own.toml").unlink()
    takers = {"make": "drop", "check": "drop", "simulate": "lab-bench", "circuit": "drop"}
    for command, source in takers.items():
        assert refused_command(command, source, cwd=tmp_path).startswith(f"{source}: is a ")


def test_a_changed_template_says_so_and_has_another_revision() -> None:
    as_shipped, changed = load("yamada-2002"), load("yamada-2002", ["ridge.height=0.45"])
    assert display_name(as_shipped) == "yamada-2002"
    assert display_name(changed) == "yamada-2002 (changed)"
    assert display_name(changed.with_(name="my-skin")) == "my-skin"
    assert re.fullmatch("[0-9a-f]{8}", as_shipped.revision)
    assert as_shipped.revision != changed.revision
    assert load("yamada-2002").revision == as_shipped.revision


@pytest.mark.parametrize(
    "settings",
    [
        [],
        ["ridge.height=0.6"],
        ["slot=none"],
        ["film=none"],
        ["ridge.levelling=0.5", "contact.force=3.0"],
        ["contact.plate.shape='tilted'", "contact.plate.tilt=1.0"],
        ["material.young_modulus=0.5"],
        ["material.name=ecoflex-00-30"],
        ["ridge.count=3", "skin.width=5.0", "ridge.heights=[0.5, 0.52, 0.5]"],
    ],
)
def test_a_changed_template_is_its_name_and_what_was_set(settings: list[str]) -> None:
    design = load_design("yamada-2002", settings)
    name, *options = shlex.split(retyped(design, "designs", load_design))
    assert name == "yamada-2002"
    assert options[::2] == ["--set"] * (len(options) // 2)
    assert load_design(name, options[1::2]) == design


def test_what_no_line_tells_is_a_file() -> None:
    design = load_design("yamada-2002", ["name=own"])
    assert retyped(design, "designs", load_design, file="design.toml") == "design.toml"
    assert retyped(design, "designs", load_design) == "own.toml"
    lengths = {"root_fillet": 0.07, "tip_fillet": 0.04, "crown": 0.02, "height": 0.51, "pitch": 1.01}
    many = design.with_(name="yamada-2002", ridge=lengths, skin={"length": 12.5, "width": 11.2})
    assert retyped(many, "designs", load_design, file="design.toml") == "design.toml"
    lab = skincad.load("yamada-2002", silicones={"lab": {"based_on": "dragon-skin-30"}})
    command = retyped(lab, "designs", load_design, file="design.toml")
    words = shlex.split(command)
    assert command == "design.toml" or load_design(words[0], words[2::2]) == lab
    circuit = load_circuit("transimpedance", ["film.area=4.2"])
    assert retyped(circuit, "circuits", load_circuit) == "transimpedance --set film.area=4.2"


DICE = random.Random(17)
SIZES = {"height": (0.3, 0.6), "root_width": (0.6, 1.2), "root_fillet": (0.0, 0.2)}  # mm
HEIGHTS = "ridge.heights=[0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5]"


def read(text: str) -> Any:
    return overridden({}, [f"table.key={text}"])["table"]["key"]


def decimals(count: int) -> list[str]:
    """Numbers without a digit before or behind the point, some with signs and exponents."""
    keys = []
    for _ in range(count):
        digits = str(DICE.randint(0, 9999))
        whole, half = f"{DICE.randint(0, 999)}.", f"{DICE.randint(1, 99)}.5"
        body = DICE.choice([f".{digits}", whole, f"0.{digits}", half])
        keys.append(DICE.choice(["", "+", "-"]) + body + DICE.choice(["", f"e{DICE.randint(-9, 9)}", "E+2"]))
    return keys


def test_a_decimal_needs_no_zero_beside_its_point() -> None:
    assert load_design("yamada-2002", ["ridge.crown=.02"]).ridge.crown == 0.02
    for text in decimals(200):
        assert read(text) == float(text), text
        assert read(f"[1, {text}, {{a = {text}}}]") == [1, float(text), {"a": float(text)}], text
        for other in (f"v{text}", f"./{text}", f"{text}.5", f'"a {text}"'):
            assert read(other) == other.strip('"'), other


def test_a_key_is_given_once() -> None:
    """However its parts are written, whatever stands between; a table and a key in it are two."""
    for _ in range(50):
        key = ".".join(DICE.choices(["ridge", "skin", "a", "b"], k=DICE.randint(1, 4)))
        again = DICE.choice([key, key.replace(".", " . "), f" {key} "])
        with refused_by(f"settings: must give {key} once, got "):
            overridden({}, [f"{key}=1", "z.other=2", f"{again}={DICE.choice(['2', 'none'])}"])
    both = load_design("yamada-2002", ["contact={force = 3.0}", "contact.force=5"])
    assert both.contact.force == 5


def test_a_setting_of_the_command_line_stands_above_the_studys(tmp_path: Path) -> None:
    study = "about = 'plain-ridges'\nsettings = ['ridge.height=0.4', 'skin.length=9']\nname = 's'\nform = 1\n"
    study += "vary = {'ridge.crown' = '0.01:0.02'}\nobjectives = [{key = 'approach'}]\n"
    (tmp_path / "s.toml").write_text(study)
    settings = load_study(tmp_path / "s.toml", ["ridge.height=0.3"]).settings
    assert settings == ("skin.length=9", "ridge.height=0.3")
    with pytest.raises(InputError, match=r"must give ridge\.height once"):
        load_study(tmp_path / "s.toml", ["ridge.height=0.3", "ridge.height=0.2"]).subject()


def whole_numbers(model: type[BaseModel], path: str = "") -> list[str]:
    """The keys of a table, and of those in it, that hold a whole number."""
    keys = []
    for key, field in model.model_fields.items():
        if (inner := table_of(model, key)) is not None:
            keys += whole_numbers(inner, f"{path}{key}{'.x' * ('dict[' in str(field.annotation))}.")
        elif re.fullmatch(r"int( \| None)?|<class 'int'>", str(field.annotation)):
            keys.append(path + key)
    return keys


@pytest.mark.parametrize("model", [Design, Scene, Circuit])
def test_a_whole_number_with_a_point_is_shown_with_it(model: type[BaseModel]) -> None:
    keys = whole_numbers(model)
    assert keys
    for key in keys:
        for number in DICE.sample(range(1000), 3):
            error = refusal(model, key, float(number))
            assert f"{key}: must be an integer, got {number}.0; write {number}" in error, key
            assert f"{key}: must be an integer, got {number}.5" in refusal(model, key, number + 0.5)


def refusal(model: type[BaseModel], key: str, value: object) -> str:
    tables: dict[str, Any] = {}
    inner = tables
    *parts, last = key.split(".")
    for part in parts:
        inner = inner.setdefault(part, {})
    inner[last] = value
    with pytest.raises(InputError) as refused:
        model(**tables)
    return str(refused.value)


def test_an_entry_of_a_list_that_is_not_there_is_told() -> None:
    rule = "there is no list ridge.heights yet; give the whole list first: ridge.heights=[...]"
    design = load_design("yamada-2002")
    for ask in (
        lambda: load_design("yamada-2002", ["ridge.heights.1=0.5"]),
        lambda: changed(design, {"ridge.heights.1": 0.5}),
        lambda: skincad.sweep(design, {"ridge.heights.1": (0.4, 0.5, 2)}, model="winkler"),
    ):
        with pytest.raises(InputError) as refused:
            ask()
        assert str(refused.value) == f"ridge.heights.1: {rule}"
    with pytest.raises(InputError, match=r"history\.time_s\.2: there is no list"):
        load_scene("steady-pull", ["history.time_s=none", "history.time_s.2=1"])


def test_an_entry_of_a_list_is_set_and_counts_from_one() -> None:
    uneven = load_design("yamada-2002", [HEIGHTS])
    for number in range(1, 10):
        height = round(DICE.uniform(0.4, 0.6), 3)
        design = load_design("yamada-2002", [HEIGHTS, f"ridge.heights.{number}={height}"])
        assert design.heights == tuple(height if n == number else 0.5 for n in range(1, 10))
        assert changed(uneven, {f"ridge.heights.{number}": height}) == design
        assert value_of(design, f"ridge.heights.{number}") == height
    for number in (0, 10, 99, "01", "9" * 5000):
        with pytest.raises(InputError, match="must name one of the list's 9 entries, from 1 to 9"):
            load_design("yamada-2002", [HEIGHTS, f"ridge.heights.{number}=0.5"])
        with pytest.raises(InputError, match="must name one of the list's 9 entries, from 1 to 9"):
            points_of(uneven, {f"ridge.heights.{number}": (0.4, 0.5, 2)})


def test_a_number_of_values_beside_a_sample_is_refused() -> None:
    design = load_design("yamada-2002")
    for _ in range(20):
        low, count = round(DICE.uniform(0.001, 0.01), 4), DICE.randint(2, 9)
        values = DICE.choice([f"{low}:0.02:{count}", (low, 0.02, count)])
        with pytest.raises(InputError) as refused:
            points_of(design, {"skin.length": (8.0, 9.0), "ridge.crown": values}, 4)
        assert str(refused.value) == (
            f"ridge.crown: must have no number of values beside a sample, which takes its own, got {count}; "
            f"write ridge.crown={low:g}:0.02, or leave the sample out"
        )
    assert len(points_of(design, {"ridge.crown": "0.01:0.02"}, 4)) == 4


def test_one_ridge_needs_no_pitch() -> None:
    """It moves no point of the section and no force; where it scales an error, the verdicts overlap."""
    for _ in range(10):
        sizes = {key: round(DICE.uniform(*ends), 3) for key, ends in SIZES.items()}
        tables = {"count": 1, "tip_width": 0.4, "crown": 0.02, **sizes}
        others = load_design("plain-ridges").model_dump(exclude_none=True)
        bare = Design(**{**others, "ridge": tables})
        pitched = bare.with_(ridge={"pitch": round(DICE.uniform(2.0, 50.0), 2)})
        assert bare.ridge.pitch is None
        assert bare.ridge.spacing == 2 * (sizes["root_width"] + 2 * sizes["root_fillet"])
        assert skincad.section(bare) == skincad.section(pitched)
        one, other = (skincad.check(design, model="winkler") for design in (bare, pitched))
        assert one.approach.lower <= other.approach.value <= one.approach.upper
        assert Design(**tomllib.loads(bare.to_toml())) == bare
    with pytest.raises(InputError, match=r"ridge.pitch: is missing; give ridge.pitch a value"):
        bare.with_(ridge={"count": 2})
