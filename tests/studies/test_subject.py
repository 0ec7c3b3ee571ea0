"""Keys of designs, scenes and circuits, changed and hashed."""

from __future__ import annotations

from pathlib import Path

import pytest

import skincad
from skincad.base import InputError
from skincad.inputs.material import silicone
from skincad.studies import changed, load_subject, value_of
from skincad.studies.subject import Subject, field_of, fingerprint

DESIGN = skincad.load_design("yamada-2002")
SCENE = skincad.load_scene("yamada-2002-press")
CIRCUIT = skincad.load_circuit("transimpedance")
FELT = skincad.load_scene("yamada-2002-slip", ["effects.piezo.circuit=transimpedance"])


def test_a_name_or_a_file_is_known_by_its_kind(tmp_path: Path) -> None:
    for name, kind in (
        ("plain-ridges", "Design"),
        ("yamada-2002-press", "Scene"),
        ("transimpedance", "Circuit"),
    ):
        data = load_subject(name)
        assert type(data).__name__ == kind
        path = tmp_path / f"{name}.toml"
        path.write_text(data.to_toml())
        assert load_subject(path) == data
    assert load_subject("yamada-2002", ["ridge.count=7"]).ridge.count == 7  # type: ignore[union-attr]
    with pytest.raises(InputError, match="did you mean 'yamada-2002'"):
        load_subject("yamda-2002")
    for source, extra in (("transimpedance", {"silicones": {}}), ("yamada-2002-press", {"printer": {}})):
        with pytest.raises(InputError, match="leave"):
            load_subject(source, **extra)  # type: ignore[arg-type]


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
def test_a_changed_key_has_its_value_and_nothing_else_is_changed(
    subject: Subject, key: str, value: float | str
) -> None:
    before = value_of(subject, key)
    answer = changed(subject, {key: value})
    assert value_of(answer, key) == value
    assert fingerprint(answer) != fingerprint(subject)
    if before is not None:
        assert fingerprint(changed(answer, {key: before})) == fingerprint(changed(subject, {key: before}))


def test_a_modulus_takes_the_silicones_range_along() -> None:
    before, after = silicone(DESIGN).young_modulus, silicone(changed(DESIGN, {"material.young_modulus": 0.4}))
    for end in ("low", "high"):
        scaled = getattr(before, end) * 0.4 / before.value
        assert getattr(after.young_modulus, end) == pytest.approx(scaled)


@pytest.mark.parametrize("value", [0.8, 0.1, 0.3, 1.7])
def test_so_does_one_without_a_range(value: float) -> None:
    exact = DESIGN.with_(material={"name": None, "young_modulus": 0.8})
    found = silicone(changed(exact, {"material.young_modulus": value})).young_modulus
    assert found.low == found.value == found.high == value


def test_another_silicone_brings_its_own_values() -> None:
    soft = changed(changed(DESIGN, {"material.young_modulus": 0.4}), {"material.name": "ecoflex-00-30"})
    assert value_of(soft, "material.young_modulus") == pytest.approx(0.07)


def test_what_the_rules_forbid_is_refused_with_its_key() -> None:
    with pytest.raises(InputError, match=r"skin\.ridge\.count"):
        changed(SCENE, {"skin.ridge.count": -1})
    with pytest.raises(InputError, match=r"skin\.length"):
        changed(DESIGN, {"skin.length": -1.0})


def test_the_hash_is_of_what_would_answer_otherwise(tmp_path: Path) -> None:
    assert fingerprint(DESIGN) == fingerprint(DESIGN.with_(name="other"))
    assert fingerprint(DESIGN) != fingerprint(SCENE)
    own = tmp_path / "own.toml"
    own.write_text(CIRCUIT.to_toml())
    felt = skincad.load_scene("yamada-2002-press").with_(effects={"film": {}, "piezo": {"circuit": str(own)}})
    before = fingerprint(felt)
    own.write_text(CIRCUIT.with_(amplifier={"gain": 1e4}).to_toml())
    assert fingerprint(felt) != before  # the file's text counts, not its name


def test_a_scenes_skin_circuit_and_own_keys_change_together() -> None:
    values = {
        "skin.ridge.height": 0.45,
        "circuit.amplifier.feedback_resistance": 3e7,
        "circuit.name": "own",
        "readout.bandwidth_Hz": 3000.0,
    }
    answer = changed(FELT, values)
    assert {key: value_of(answer, key) for key in values} == values
    assert answer.effects["piezo"].keys() == FELT.effects["piezo"].keys()  # type: ignore[union-attr]


def test_a_changed_scene_is_written_and_read_back(tmp_path: Path) -> None:
    answer = changed(FELT, {"circuit.amplifier.feedback_resistance": 3e7, "skin.ridge.height": 0.45})
    path = tmp_path / "scene.toml"
    path.write_text(answer.to_toml())  # type: ignore[union-attr]
    assert fingerprint(load_subject(path)) == fingerprint(answer)


def test_a_circuits_keys_need_an_amplifier() -> None:
    with pytest.raises(InputError, match=r"circuit.amplifier.gain: needs an amplifier.*effects.piezo"):
        field_of(SCENE, "circuit.amplifier.gain")
    with pytest.raises(InputError, match=r"circuit.amplifier.gian: unknown key; did you mean 'gain'"):
        field_of(FELT, "circuit.amplifier.gian")
    with pytest.raises(InputError, match=r"circuit.amplifier.gain: must be greater than 0"):
        changed(FELT, {"circuit.amplifier.gain": -1.0})


def test_a_key_within_a_circuit_or_a_skin_that_is_chosen_too_is_that_ones() -> None:
    both = {"effects.piezo.circuit": "charge-amplifier", "circuit.amplifier.feedback_resistance": 3e7}
    answer = changed(FELT, both)
    assert value_of(answer, "circuit.name") == "charge-amplifier"
    assert value_of(answer, "circuit.amplifier.feedback_resistance") == 3e7
    tilted = changed(FELT, {"skin": "yamada-2002-tilted", "skin.skin.thickness": 4.5})
    assert value_of(tilted, "skin.name") == "yamada-2002-tilted"
    assert value_of(tilted, "skin.skin.thickness") == 4.5
