"""A design, a scene, a circuit: built, changed, written, loaded, copied; InputError for all that is bad."""

from __future__ import annotations

import copy
import inspect
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from skincad.base import Document, InputError
from skincad.circuit import Circuit, load_circuit
from skincad.inputs import KINDS, Design, Material, Ridge, load, load_design, template_names
from skincad.scenes import Scene, load_scene
from tests.refusals import refused_by

LOADS = {"designs": load_design, "scenes": load_scene, "circuits": load_circuit}
TEMPLATES = [(kind, name) for kind in KINDS for name in template_names(kind)]
PRESS = {"time_s": [0, 1], "normal_force_N": [0, 2], "tangential_force_N": [0, 1], "steps": 4}


def tables(document: Document) -> dict[str, Any]:
    return document.model_dump(exclude_none=True)


def own_design() -> Design:
    """A design that no file has, with all that is optional."""
    modulus, mill = {"value": 0.8, "low": 0.7, "high": 1.0}, {"based_on": "cnc", "tool_radius": 0.1}
    changes = {"ridge": {"height": 0.55}, "material": {"young_modulus": modulus}}
    return load_design("yamada-2002").with_(name="own", **changes, printer={"my-mill": mill})


def own_scene(**changes: Any) -> Scene:
    tables = {"name": "own", "skin": own_design(), "history": PRESS}
    return Scene(**tables | {"effects": {"friction": {"coefficient": 0.5}}} | changes)


@pytest.mark.parametrize(("kind", "name"), TEMPLATES)
def test_what_is_written_loads_back_equal(kind: str, name: str, tmp_path: Path) -> None:
    document = LOADS[kind](name)
    (tmp_path / "copy.toml").write_text(document.to_toml(), encoding="utf-8")
    assert LOADS[kind](tmp_path / "copy.toml") == document
    assert type(document)(**tables(document)) == document == document.with_()


def test_what_is_built_in_memory_loads_back_equal(tmp_path: Path) -> None:
    scene = own_scene(effects={"film": {}, "piezo": {"circuit": "yamada-2002", "noise_seed": None}})
    for load_it, document in ((load_design, own_design()), (load_scene, scene)):
        (tmp_path / "copy.toml").write_text(document.to_toml(), encoding="utf-8")
        assert load_it(tmp_path / "copy.toml") == document
    assert load_scene(tmp_path / "copy.toml").design == own_design()


def test_a_path_means_the_same_from_everywhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    here, there = tmp_path / "here", tmp_path / "there"
    for folder in (here, there):
        folder.mkdir()
    (here / "skin.toml").write_text(own_design().to_toml(), encoding="utf-8")
    (here / "circuit.toml").write_text(load_circuit("yamada-2002").to_toml(), encoding="utf-8")
    monkeypatch.chdir(here)
    scene = own_scene(skin="skin.toml", effects={"film": {}, "piezo": {"circuit": "circuit.toml"}})
    assert scene.design == own_design()
    monkeypatch.chdir(there)
    (there / "scene.toml").write_text(scene.to_toml(), encoding="utf-8")
    assert load_scene("scene.toml") == scene


# what is changed of a good one, and what is told of it
BAD: list[tuple[str, dict[str, Any], str]] = [
    ("designs", {"ridge": {"heigth": 0.5}}, "ridge.heigth: unknown key; did you mean 'height'?"),
    ("designs", {"ridge": {"height": "0.5"}}, "ridge.height: must be a number (mm), got '0.5'"),
    ("designs", {"ridge": {"height": None}}, "ridge.height: is missing; give ridge.height a value"),
    ("designs", {"ridge": 3}, "ridge: must be a table, [ridge], got 3"),
    ("designs", {"skin": {"width": 1e9}},
     "skin.width: must be less than or equal to 1000 (mm), got 1e+09"),
    ("designs", {"ridge": {"pitch": 0.1}},
     "ridge.root_width: must be less than 0.1 mm (ridge.pitch), got 0.75"),
    ("designs", {"material": {"name": "x" * 65}}, "material.name: must have at most 64 characters"),
    ("designs", {"name": "a b"},
     "name: must be letters, digits, - and _, up to 64; it names the output folder"),
    ("scenes", {"readout": {"ridges": [99]}}, "readout.ridges: must be from 1 to 9, got 99"),
    ("scenes", {"effects": {"fricton": {}}}, "effects.fricton: unknown effect; did you mean 'friction'?"),
    ("scenes", {"effects": {"friction": {}}}, "effects.friction.coefficient: is missing"),
    ("scenes", {"effects": {"friction": 0.5}},
     "effects.friction: must be a table, [effects.friction], got 0.5"),
    ("scenes", {"effects": 3}, "effects: must be a table, [effects], got 3"),
    ("scenes", {"effects": {"inertia": {}}}, "plate.mass: is missing; masses count here"),
    ("scenes", {"skin": 3}, "skin: must be a design, or the name of a template or TOML file, got 3"),
    ("scenes", {"skin": "x" * 5000}, "skin: must have at most 4096 characters, got 'xxx"),
    ("scenes", {"skin": "yamada-2003"},
     "skin: no such template among designs, and no TOML file, got 'yamada-2003'"),
    ("scenes", {"skin": {"ridge": {"height": -1.0}}},
     "skin.ridge.height: must be greater than 0 (mm), got -1"),
    ("scenes", {"history": {"time_s": [0.0]}}, "history.time_s: must have at least 2 items, got [0.0]"),
    ("scenes", {"history": {"tangential_force_N": None}},
     "history: needs either tangential_force_N or displ"),
    ("circuits", {"amplifier": {"gain": -1.0}}, "amplifier.gain: must be greater than 0, got -1"),
    ("circuits", {"film": {"d33": 0.0}},
     "film.d33: must not be 0 pC/N: the load would give no charge, got 0"),
    ("circuits", {"sampling": {"rate": 1.0}},
     "sampling.rate: must be above 20 Hz (twice sweep.low), got 1"),
]  # fmt: skip


def good(kind: str) -> Document:
    kinds = {"designs": own_design, "scenes": own_scene, "circuits": lambda: load_circuit("yamada-2002")}
    return kinds[kind]()


@pytest.mark.parametrize(("kind", "change", "words"), BAD, ids=[words[:30] for _, _, words in BAD])
def test_what_is_bad_is_an_input_error_however_it_comes(kind: str, change: dict, words: str) -> None:
    def built(document: Document) -> Document:
        """By the constructor, each changed table whole."""
        data = tables(document)
        for key, value in change.items():
            both = isinstance(value, dict) and isinstance(data.get(key), dict)
            data[key] = {**data[key], **value} if both else value
        if kind == "scenes" and isinstance(change.get("skin"), dict):
            skin = tables(own_design())
            data["skin"] = skin | {"ridge": skin["ridge"] | change["skin"]["ridge"]}
        return type(document)(**data)

    document = good(kind)
    copies = (document, copy.deepcopy(document), pickle.loads(pickle.dumps(document)))
    ways = [lambda original=original: original.with_(**change) for original in copies]
    if not any(v is None or (isinstance(v, dict) and None in v.values()) for v in change.values()):
        ways.append(lambda: built(document))
    for way in ways:
        with refused_by(words):
            way()


def test_a_table_by_itself_tells_its_own_keys() -> None:
    with pytest.raises(InputError, match=r"^height: must be greater than 0"):
        Ridge(**{**own_design().ridge.model_dump(), "height": 0.0})
    with pytest.raises(InputError, match=r"^material: needs a name, a young_modulus or a law"):
        Material()
    data = tables(own_design())
    data["ridge"]["height"], data["skin"]["width"] = -1.0, "wide"
    with pytest.raises(InputError) as refused:
        Design(**data)
    assert {e.key for e in (refused.value, *refused.value.others)} == {"ridge.height", "skin.width"}


@pytest.mark.parametrize("kind", KINDS)
def test_nothing_is_set_in_place(kind: str) -> None:
    document = good(kind)
    with pytest.raises(InputError, match=r"^name: is frozen, got 'other'; make"):
        document.name = "other"
    assert document == good(kind)


@pytest.mark.parametrize("model", [Design, Scene, Circuit])
def test_a_constructors_signature_names_its_keys(model: type[Document]) -> None:
    assert list(inspect.signature(model).parameters) == list(model.model_fields)
    assert load is load_design


def test_a_scenes_tables_change_by_key_and_may_be_arrays() -> None:
    scene = own_scene()
    more = scene.with_(effects={"film": {}}, history={"steps": 8}, readout={"ridges": (3,)})
    assert set(more.effects) == {"friction", "film"}
    assert (more.history.steps, more.history.time_s, more.readout.ridges) == (8, [0, 1], [3])
    assert more.with_(effects={"film": None}, history={"steps": 4}, readout=None) == scene
    lists = own_scene(history={**PRESS, "time_s": [0.0, 1.0], "normal_force_N": [0.0, 2.0]})
    others = {"time_s": np.linspace(0.0, 1.0, 2), "normal_force_N": (0.0, 2.0)}
    assert own_scene(history={**PRESS, **others}) == lists
    assert own_scene(readout={"ridges": range(1, 4)}).readout.ridges == [1, 2, 3]


def test_a_scene_is_put_on_another_skin() -> None:
    lower, scene = own_design().with_(ridge={"height": 0.4}), own_scene()
    for moved in (
        scene.with_(skin=lower),
        scene.with_(skin={"ridge": {"height": 0.4}}),
        own_scene(skin="yamada-2002").with_(skin=lower),
        own_scene(skin=tables(lower)),
    ):
        assert moved == own_scene(skin=lower)
        assert moved.design == lower
    named = own_scene(skin="yamada-2002").with_(skin={"ridge": {"height": 0.4}})
    assert named.design == load_design("yamada-2002", ["ridge.height=0.4"])
    slip = load_scene("yamada-2002-slip", ["history.steps=5"], skin=lower)
    assert (slip.design, slip.history.steps) == (lower, 5)
    assert load_scene("yamada-2002-slip", skin="lab-bench").design == load_design("lab-bench")
