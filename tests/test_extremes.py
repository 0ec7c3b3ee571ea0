"""Every number that a person writes, at the ends of what is accepted: finite results or a clear refusal."""

from __future__ import annotations

import json
import math
import random
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import annotated_types
import numpy as np
import pytest
import tomlkit

import skincad
from bench.campaign.strategies import numbers
from skincad.base import InputError, RefusedError, Table, table_of
from skincad.circuit import Circuit, circuit_network, gain
from skincad.effects import EFFECTS, Chain, effect
from skincad.inputs import FAMILY_TABLES, Design, overridden, read_table, template_text
from skincad.mechanics import filled_pad
from skincad.outputs import write
from skincad.scenes import LEVELS, Readout, ScenePlate, at_level, load_scene
from tests.small_scene import small_skin

HUGE, TINY = 1e300, 5e-324  # where a field has no limit of its own
Keys = tuple[str, ...]


def ends(model: type[Table], path: Keys) -> list[float]:
    """The smallest and the largest values that a field takes, and those nearest to 0."""
    for key in path[:-1]:
        model = table_of(model, key) or model
    low, high = -HUGE, HUGE
    for rule in model.model_fields[path[-1]].metadata:
        if isinstance(rule, annotated_types.Ge):
            low = float(rule.ge)  # type: ignore[arg-type]
        if isinstance(rule, annotated_types.Gt):
            low = math.nextafter(float(rule.gt), math.inf)  # type: ignore[arg-type]
        if isinstance(rule, annotated_types.Le):
            high = float(rule.le)  # type: ignore[arg-type]
    return sorted({low, high, *(v for v in (0.0, TINY, -TINY) if low <= v <= high)})


def changed(tables: dict[str, Any], path: Keys, value: Any) -> dict[str, Any]:
    """The tables with one number another; a table that is not there is begun."""
    inner = tables.get(path[0])
    if len(path) > 1:
        value = changed(dict(inner) if isinstance(inner, dict) else {}, path[1:], value)
    return {**tables, path[0]: value}


def finite(found: Callable[[], dict[str, Any]]) -> bool:
    """Whether what is found is finite; False where it is refused. ValueError where it is not."""
    try:
        json.dumps(found(), allow_nan=False)
    except (InputError, RefusedError):
        return False
    return True


def circuit_told(tables: dict[str, Any]) -> dict[str, Any]:
    """What a circuit tells, and what it makes of a film's charge in a scene."""
    circuit = Circuit(**tables)
    data = gain(circuit).as_json()
    chain = Chain.of(circuit_network(circuit), np.linspace(0.0, 0.1, 11), 50.0)
    return {**data, "noise": chain.noise_rms(), "output": chain.output(np.linspace(0.0, 1e-12, 11)).tolist()}


def design_told(tables: dict[str, Any]) -> dict[str, Any]:
    """The closed form's verdict on a design, and the numbers that a mesh of it begins with."""
    design = Design(**tables)
    data = skincad.check(design, model="winkler").as_json()
    if design.slot and design.skin.curvature_radius_y is None:
        pad = filled_pad(design.with_(contact={"film": "ignored"}))[0]
        data["pad"] = [pad.top, pad.length, pad.young_modulus, pad.poisson_ratio]
    return data


BASES: dict[
    str, tuple[type[Table], Callable[[], dict[str, Any]], Callable[[dict[str, Any]], dict[str, Any]]]
] = {
    "circuit": (
        Circuit,
        lambda: {
            **read_table("yamada-2002", "circuits"),
            "sweep": {"points": 40},
            "indenter": {"resonance": 9000.0},
            "force_sensor": {"resonance": 1200.0, "damping": 0.57},
            "sampling": {"rate": 650.0},
        },
        circuit_told,
    ),
    "design": (Design, lambda: read_table("yamada-2002", "designs"), design_told),
}

CIRCUIT = pytest.param("circuit", marks=pytest.mark.evidence(subject="ends: circuits"))


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["design", CIRCUIT])
def test_each_number_at_its_ends(kind: str) -> None:
    model, base, told = BASES[kind]
    assert finite(lambda: told(base()))
    for path in numbers(model):
        for value in ends(model, path):
            case = changed(base(), path, value)
            try:
                finite(lambda case=case: told(case))  # type: ignore[misc]
            except (ValueError, ArithmeticError) as failure:
                pytest.fail(f"{'.'.join(path)} = {value!r}: {failure}")


@pytest.mark.parametrize("kind", ["design", CIRCUIT])
def test_any_three_numbers_at_their_ends(kind: str) -> None:
    model, base, told = BASES[kind]
    other = {*FAMILY_TABLES, "magnetometer"} - {*base()}  # a skin has one family, and magnets in pins
    poses = {("mold", "bone_at"), ("mold", "bone_turn")}  # of a bone, which the design has not
    paths = [path for path in numbers(model) if path[0] not in other and tuple(path[:2]) not in poses]
    dice, accepted = random.Random(20261), 0
    for _ in range(60):
        case, said = base(), []
        for path in dice.sample(paths, 3):
            value = dice.choice(ends(model, path))
            case, said = changed(case, path, value), [*said, (path, value)]
        try:
            accepted += finite(lambda case=case: told(case))  # type: ignore[misc]
        except (ValueError, ArithmeticError) as failure:
            pytest.fail(f"{said}: {failure}")
    assert accepted >= 10  # else it would say nothing


# of a history: the largest and the smallest that its rules take, or leave to them
HISTORIES: tuple[dict[str, Any], ...] = (
    {"normal_force_N": [0.0, 1e6, 1e6]},
    {"normal_force_N": [0.0, 7.1, 7.1]},
    {"normal_force_N": [0.0, TINY, TINY]},
    {"normal_force_N": [0.0, 1e-300, 1e-300]},
    {"normal_force_N": [0.0, 1e-9, 1e-9]},
    {"normal_force_N": [0.0, 0.0, 0.0]},
    {"tangential_force_N": [0.0, 0.0, 1e6]},
    {"tangential_force_N": [0.0, 0.0, -TINY]},
    {"tangential_force_N": None, "displacement_mm": [0.0, 0.0, 1e3]},
    {"tangential_force_N": None, "displacement_mm": [0.0, 0.0, TINY]},
    {"rotation_deg": [0.0, 5.0, -5.0]},
    {"rotation_deg": [0.0, TINY, -TINY]},
    {"time_s": [0.0, 1e-9, 2.1e-9]},
    {"time_s": [0.0, 1e-9, 1e6]},
    {"time_s": [0.0, 9e5, 1e6]},
)


def scenes() -> Iterator[dict[str, Any]]:
    """Changes of a scene: one number at an end."""
    for history in HISTORIES:
        yield {"history": history}
    for name in EFFECTS:
        for path in numbers(effect(name)):
            for value in ends(effect(name), path):
                yield {"effects": {name: {path[0]: value}}}
    yield {"effects": {"viscosity": {"prony": [[TINY, TINY]]}}}
    yield {"effects": {"viscosity": {"prony": [[HUGE, HUGE]]}}}
    yield {"effects": {"viscosity": {"prony": [[0.5, 1e-3], [1e3, 1e-9]]}}}
    for value in ends(ScenePlate, ("mass",)):
        yield {"plate": {"mass": value}, "effects": {"inertia": {}}}
    for value in ends(Readout, ("bandwidth_Hz",)):
        yield {"readout": {"bandwidth_Hz": value}}
        yield {"readout": {"bandwidth_Hz": value}, "effects": {"piezo": {"noise_seed": 1}}}


def merged(one: dict[str, Any], other: dict[str, Any]) -> dict[str, Any]:
    """Tables with those of `other` on top; None drops a key."""
    table = dict(one)
    for key, value in other.items():
        table[key] = merged(table.get(key) or {}, value) if isinstance(value, dict) else value
    return {key: value for key, value in table.items() if value is not None}


def scene_told(folder: Path, change: dict[str, Any]) -> dict[str, Any]:
    """What a scene on three ridges tells, on the coarsest mesh."""
    (folder / "small.toml").write_text(small_skin(template_text("yamada-2002")))
    base = overridden(
        read_table("yamada-2002-press-and-pull", "scenes"),
        [
            "history.steps=6",
            "history.normal_force_N=[0.0, 1.3, 1.3]",
            "history.tangential_force_N=[0.0, 0.0, 0.4]",
        ],
    )
    base["skin"] = str(folder / "small.toml")
    base["readout"] = {"ridges": [1], "bandwidth_Hz": 20.0}
    named = change.get("effects", {})
    tables = merged(base, change)
    if "piezo" in named:
        tables["effects"]["piezo"]["circuit"] = "transimpedance"
    if "inertia" in named:
        tables = merged({"plate": {"mass": 1.0}}, tables)
    if "finite_strain" in named or "viscosity" in named or "inertia" in named:
        tables["history"]["steps"] = 3
    (folder / "scene.toml").write_text(tomlkit.dumps(tables))
    return at_level(load_scene(folder / "scene.toml"), LEVELS[0]).as_json()


ALL = list(scenes())
FEW = {0, 5, 13}  # a force too large and one too small, points of time too far apart
ENDS = pytest.mark.evidence(subject="ends: scenes")


@pytest.mark.parametrize(
    "number", [pytest.param(n, marks=[] if n in FEW else [ENDS]) for n in range(len(ALL))]
)
def test_a_scene_at_its_ends(number: int, tmp_path: Path) -> None:
    change = ALL[number]
    try:
        finite(lambda: scene_told(tmp_path, change))
    except (ValueError, ArithmeticError) as failure:
        pytest.fail(f"{change}: {failure}")


BEYOND = {
    "history.normal_force_N=[0.0, 1e300, 1e300]": "must be at most 1e+06 N in size, got 1e+300",
    "history.tangential_force_N=[0.0, 0.0, -1e7]": "must be at most 1e+06 N in size, got -1e+07",
    "history.time_s=[0.0, 5e-324, 1e-323]": "needs points at least 1e-09 s apart",
    "history.time_s=[0.0, 1.0, 1e300]": "must be at most 1e+06 s",
    "history.normal_force_N=[0.0, 1e4, 1e4]": "must be at most 21.6 N: the ridges' nominal strain is 1.4e+02",
    "readout.bandwidth_Hz=5e-324": "must be at least 0.0001 Hz",
    "effects.viscosity.prony=[[1e300, 1.0]]": "needs a modulus and a time of at most 1e+06",
}


@pytest.mark.parametrize("setting", BEYOND)
def test_what_overflows_is_refused_before_any_work(setting: str) -> None:
    with pytest.raises(InputError) as refusal:
        load_scene("yamada-2002-press-and-pull", [setting])
    assert refusal.value.key == setting.partition("=")[0]
    assert BEYOND[setting] in str(refusal.value)


@pytest.mark.slow
def test_numbers_that_are_not_finite_leave_an_earlier_result_as_it_was(tmp_path: Path) -> None:
    """Whatever lets one through: nothing is written, in JSON or in CSV."""
    settings = [
        "skin=steep-fingertip",
        "history.steps=2",
        "history.normal_force_N=[0.0, 0.5]",
        "readout.ridges=[2]",
    ]
    answer = at_level(load_scene("yamada-2002-press", settings), LEVELS[0])
    write(answer, tmp_path / "out")
    before = {file.name: file.read_bytes() for file in (tmp_path / "out").iterdir()}
    for wrong in (math.nan, math.inf):
        bad = replace(answer, read={"peak_V": wrong})
        readings = (*answer.march.readings[:-1], replace(answer.march.readings[-1], approach=wrong))
        for broken in (bad, replace(answer, march=replace(answer.march, readings=readings))):
            with pytest.raises(RefusedError, match="not finite: nothing is written"):
                write(broken, tmp_path / "out")
    assert {file.name: file.read_bytes() for file in (tmp_path / "out").iterdir()} == before
    assert [file.name for file in tmp_path.iterdir()] == ["out"]
