"""What is to be typed to get a document again gives it again."""

from __future__ import annotations

import shlex

import pytest

import skincad
from skincad.circuit import load_circuit
from skincad.inputs import load_design, retyped


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
