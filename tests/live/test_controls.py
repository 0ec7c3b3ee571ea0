"""Controls: one for every number and choice of every template, whose range holds its value."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

import skincad
from skincad.base import InputError, Table
from skincad.live import apply_moves, start_session
from skincad.live.controls import REACH, controls, reach

DESIGNS, SCENES = skincad.template_names(), skincad.template_names("scenes")


def loaded(name: str) -> Any:
    return skincad.load_scene(name) if name in SCENES else skincad.load(name)


def numbers(table: Table, before: str = "") -> Iterator[str]:
    """The keys of all numbers that a design's tables hold, by walking what they hold."""
    for key, value in table:
        if isinstance(value, bool | str | dict) or value is None:
            continue
        if isinstance(value, Table) and {"value", "low", "high"} != {name for name, _ in value}:
            yield from numbers(value, f"{before}{key}.")
        elif isinstance(value, tuple | list):
            yield from (f"{before}{key}.{place}" for place, _ in enumerate(value, 1))
        else:
            yield f"{before}{key}"


@pytest.mark.parametrize("name", DESIGNS)
def test_every_number_of_a_design_has_a_slider(name: str) -> None:
    design = loaded(name)
    sliders = {control.key for control in controls(design) if control.kind == "slider"}
    assert {*numbers(design)} <= sliders


@pytest.mark.parametrize("name", [*DESIGNS, *SCENES])
def test_each_control_holds_its_value_and_says_what_it_is(name: str) -> None:
    rows = controls(loaded(name))
    assert len({control.key for control in rows}) == len(rows)
    for control in rows:
        assert control.hint
        if control.kind == "slider":
            assert control.low < control.high
            assert 0 < control.step <= control.high - control.low
            value = control.initial if control.value is None else control.value
            assert isinstance(value, int | float)
            assert control.low <= value <= control.high, control
        elif control.kind == "choice":
            assert control.value in control.choices


@pytest.mark.parametrize("name", ["yamada-2002", "yamada-2002-tilted", "drop", "rolling"])
def test_each_control_can_be_set_to_its_own_value(name: str) -> None:
    """A key that a control names is one that a session knows: nothing moves, and nothing is refused."""
    session = start_session(loaded(name))
    for control in controls(session.subject):
        if control.value not in (None, "", True, False):
            after = apply_moves(session, {control.key: control.value}, 0.0)
            assert after.refusal is None, control


def test_a_scene_has_its_skins_controls_and_its_own() -> None:
    keys = {control.key for control in controls(loaded("yamada-2002-slip"))}
    assert {"skin.ridge.height", "effects.friction.coefficient", "history.normal_force_N.2"} <= keys
    assert "history.normal_force_N.1" not in keys  # a history begins unloaded


@pytest.mark.parametrize(
    ("value", "low", "high", "unit", "ends"),
    [
        (0.5, 0.0, 50.0, "mm", (0.0, 2.0)),
        (60.0, 1.0, 1e8, "mm", (1.0, 240.0)),
        (0.3, 0.0, 1.0, "", (0.0, 1.0)),  # a share, whole
        (10.0, -80.0, 80.0, "deg", (-80.0, 80.0)),
        (-2.0, -50.0, 50.0, "mm", (-10.0, 6.0)),
        (0.0, 0.0, 20.0, "mm", (0.0, 1.0)),
    ],
)
def test_a_slider_reaches_so_far(
    value: float, low: float, high: float, unit: str, ends: tuple[float, float]
) -> None:
    assert reach(value, low, high, unit) == ends
    assert REACH == 4.0


def test_a_refused_value_is_told_with_its_key() -> None:
    session = apply_moves(start_session(loaded("yamada-2002")), {"ridge.pitch": -1.0}, 0.0)
    assert isinstance(session.refusal, InputError)
    assert session.refusal.key == "ridge.pitch"
