"""Public functions take a template's name or a file in the place of a design, scene, circuit or study."""

from __future__ import annotations

import inspect
import pickle
import tempfile
from pathlib import Path
from typing import Any

import pytest

import skincad
from skincad.base import InputError
from skincad.studies import load_subject

LOADERS = {
    "design": (skincad.load_design, "plain-ridges"),
    "scene": (skincad.load_scene, "steady-pull"),
    "circuit": (skincad.load_circuit, "transimpedance"),
    "subject": (load_subject, "plain-ridges"),
    "study": (skincad.load_study, "shape-for-4-N"),
}


def taken(function: Any) -> set[str]:
    """Which arguments of a function a name may stand for."""
    return {*inspect.signature(function).parameters} & {*LOADERS}


FUNCTIONS = [name for name in skincad.__all__ if not isinstance(getattr(skincad, name), type)]
TAKING = [name for name in FUNCTIONS if taken(getattr(skincad, name))]


def test_there_are_functions_of_each_kind() -> None:
    assert set.union(*(taken(getattr(skincad, name)) for name in TAKING)) == {*LOADERS}
    assert {"check", "section", "make", "simulate", "gain", "sweep", "optimise", "fit_material"} <= {*TAKING}


@pytest.mark.parametrize("name", TAKING)
def test_a_name_and_a_file_are_loaded(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """By whatever place the argument is given; the function gets what the loader returns."""
    function = getattr(skincad, name)
    assert pickle.loads(pickle.dumps(function)) is function  # by whom it is sent to other processes
    seen = dict[str, Any]()
    taking = skincad.by_name(spy(function.__wrapped__, seen))
    needed = [p.name for p in inspect.signature(function).parameters.values() if p.default is p.empty]
    for key in taken(function):
        load, template = LOADERS[key]
        wanted = load(template)
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder, "own.toml")
            file.write_text(wanted.to_toml())
            others = {other: object() for other in needed if other != key}
            for given, expected in (
                (template, wanted),
                (file, load(file)),
                (str(file), load(file)),
                (wanted, wanted),
            ):
                taking(**others, **{key: given})
                assert seen[key] == expected
                assert {other: seen[other] for other in others} == others
        with pytest.raises(InputError, match="no-such: no such template"):
            taking(**others, **{key: "no-such"})


def spy(function: Any, seen: dict[str, Any]) -> Any:
    """A function of the same arguments that only notes them."""

    def noted(*given: Any, **named: Any) -> None:
        seen.update(inspect.signature(function).bind(*given, **named).arguments)

    noted.__signature__ = inspect.signature(function)  # type: ignore[attr-defined]
    return noted


def test_answers_are_those_of_what_is_loaded(tmp_path: Path) -> None:
    design = skincad.load_design("plain-ridges")
    (tmp_path / "own.toml").write_text(design.with_(ridge={"height": 0.45}).to_toml())
    assert skincad.section("plain-ridges") == skincad.section(design)
    by_name, by_design = (skincad.check(given, model="winkler") for given in ("plain-ridges", design))
    assert by_name.all_touch_force == by_design.all_touch_force
    assert skincad.section(tmp_path / "own.toml").top < skincad.section(design).top
    assert skincad.gain("transimpedance").name == "transimpedance"


def test_a_model_has_a_second_name_but_not_two_at_once() -> None:
    assert skincad.check("plain-ridges", tier="winkler").model == "winkler"  # type: ignore[call-arg]
    with pytest.raises(TypeError, match="tier"):
        skincad.check("plain-ridges", model="linear", tier="winkler")  # type: ignore[call-arg]
