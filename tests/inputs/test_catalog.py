"""What is given to a command that takes another kind, by name and by the file's tables; what to type to get a
document again."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable
from pathlib import Path

import pytest

import skincad
from skincad.base import InputError
from skincad.circuit import load_circuit
from skincad.inputs import (
    KINDS,
    Kind,
    display_name,
    load,
    load_design,
    retyped,
    template_names,
    template_text,
)
from skincad.scenes import load_scene
from tests.conftest import run_skincad

LOAD: dict[Kind, Callable[[Path | str], object]] = {
    "designs": load,
    "scenes": load_scene,
    "circuits": load_circuit,
}
TAKERS = {"designs": "make, check or accuracy", "scenes": "simulate", "circuits": "circuit"}


@pytest.mark.parametrize("wanted", KINDS)
@pytest.mark.parametrize("given", KINDS)
def test_whatever_takes_another_kind_says_what_takes_this_one(
    wanted: Kind, given: Kind, tmp_path: Path
) -> None:
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


def test_a_name_of_two_kinds_says_both() -> None:
    with pytest.raises(InputError) as refusal:
        load_scene("yamada-2002")
    assert str(refusal.value) == (
        "yamada-2002: is a design and a circuit, not a scene; "
        "give it to make, check or accuracy, or to circuit"
    )


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("[lab-10]\nyoung_modulus = 0.2", "a table of silicones, not a design; give it to --silicones"),
        ("[sla]\nlayer = 0.1", "a table of processes, not a design; give it to --printer"),
    ],
)
def test_ones_own_tables_are_no_design(text: str, what: str, tmp_path: Path) -> None:
    (tmp_path / "own.toml").write_text(text)
    with pytest.raises(InputError, match=what):
        load(tmp_path / "own.toml")


def test_a_scenes_skin_may_be_no_scene() -> None:
    with pytest.raises(
        InputError, match=r"^skin: is a scene, not a design, got 'drop'; give it to simulate$"
    ):
        load_scene("hold", ["skin=drop"])


@pytest.mark.parametrize(
    ("command", "source"),
    [("make", "drop"), ("check", "drop"), ("simulate", "lab-bench"), ("circuit", "drop")],
)
def test_the_command_leaves_with_2_and_one_line(command: str, source: str, tmp_path: Path) -> None:
    result = run_skincad(command, source, cwd=tmp_path)
    assert (result.returncode, result.stdout, result.stderr.count("\n")) == (2, "", 1)
    assert result.stderr.startswith(f"skincad: {source}: is a ")
    assert not list(tmp_path.iterdir())


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


def test_circuits_too() -> None:
    circuit = load_circuit("transimpedance", ["film.area=4.2"])
    assert retyped(circuit, "circuits", load_circuit) == "transimpedance --set film.area=4.2"
