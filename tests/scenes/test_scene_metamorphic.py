"""Scenes told in another way: other units, names, order or side. What must be the same then is the same.

ROUNDING is that of loads that are interpolated and scaled in another order, carried through a contact problem
whose own residual is 1e-10.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomlkit

from skincad.inputs import read_table
from skincad.scenes import LEVELS, Simulation, at_level, load_scene
from tests.hard_cases import scaled

ROUNDING = 1e-8
Tables = dict[str, Any]
PULL = {"normal_force_N": [0.0, 1.3, 1.3], "tangential_force_N": [0.0, 0.0, 1.0]}
CRUSH = {"normal_force_N": [0.0, 7.0, 7.0], "tangential_force_N": [0.0, 0.0, 0.0]}  # beyond 0.3 of strain


def skin() -> Tables:
    tables = read_table("yamada-2002", "designs")
    tables["ridge"]["count"], tables["skin"]["width"] = 3, 5.0
    return tables


def scene(history: Tables) -> Tables:
    tables = read_table("yamada-2002-press-and-pull", "scenes")
    tables["history"] = {"time_s": [0.0, 0.1, 0.2], "steps": 16, **history}
    tables["readout"] = {"ridges": [1, 2, 3], "bandwidth_Hz": 30.0}
    return tables


def marched(folder: Path, tables: Tables, of: Tables, name: str = "skin") -> Simulation:
    (folder / f"{name}.toml").write_text(tomlkit.dumps(of))
    (folder / "scene.toml").write_text(tomlkit.dumps({**tables, "skin": f"{name}.toml"}))
    return at_level(load_scene(folder / "scene.toml"), LEVELS[0])


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Simulation]:
    """The scene as it is, and the one that goes beyond the range."""
    simulations = {
        name: marched(tmp_path_factory.mktemp(name), scene(history), skin())
        for name, history in (("pull", PULL), ("crush", CRUSH))
    }
    assert simulations["pull"].march.stopped is None
    assert any(step is not None for step in simulations["pull"].slip_steps)
    assert simulations["crush"].march.failed
    assert len(simulations["crush"].march.readings) > 5
    return simulations.__getitem__


def same(
    one: Simulation, other: Simulation, *, force: float = 1.0, length: float = 1.0, stress: float = 1.0
) -> None:
    """All columns of `other` are those of `one` times these factors, slip and stop at the same steps."""
    of = {"normal": force, "tangential": force, "approach": length, "travel": length, "films": stress}
    largest = {name: factor * float(np.abs(one.march.column(name)).max()) for name, factor in of.items()}
    largest |= {"tangential": largest["normal"], "travel": largest["approach"]}  # of a mere press: rounding
    for name, factor in of.items():
        here, there = factor * one.march.column(name), other.march.column(name)
        assert there == pytest.approx(here, abs=ROUNDING * largest[name]), name
    energy = force * length * one.march.column("elastic")
    assert other.march.column("elastic") == pytest.approx(energy, rel=1e-6, abs=ROUNDING * energy.max())
    assert other.slip_steps == one.slip_steps
    assert other.march.failed == one.march.failed
    assert len(other.march.readings) == len(one.march.readings)


@pytest.mark.parametrize("name", ["pull", "crush"])
@pytest.mark.parametrize("factor", [1e5, 1e3])
def test_the_unit_of_time(name: str, factor: float, plain: Any, tmp_path: Path) -> None:
    """A quasi-static march knows no time; rates behind a band as much wider are by the factor smaller."""
    tables = scene(PULL if name == "pull" else CRUSH)
    tables["history"]["time_s"] = [factor * t for t in tables["history"]["time_s"]]
    tables["readout"]["bandwidth_Hz"] /= factor
    simulation = marched(tmp_path, tables, skin())
    same(plain(name), simulation)
    rate = plain(name).signals[1].rate
    assert simulation.signals[1].rate * factor == pytest.approx(rate, abs=1e-6 * float(np.abs(rate).max()))


@pytest.mark.parametrize("name", ["pull", "crush"])
def test_the_unit_of_force(name: str, plain: Any, tmp_path: Path) -> None:
    """Forces and moduli a hundred times as large: the same lengths, and it stops at the same step."""
    tables = scene(
        {k: [100 * v for v in values] for k, values in (PULL if name == "pull" else CRUSH).items()}
    )
    same(plain(name), marched(tmp_path, tables, scaled(skin(), 1.0, 100.0)), force=100.0, stress=100.0)


@pytest.mark.parametrize("name", ["pull", "crush"])
def test_the_unit_of_length(name: str, plain: Any, tmp_path: Path) -> None:
    """Lengths twice as large and moduli a quarter: the same forces. Meshes are made in the pad's own unit."""
    tables = scene(PULL if name == "pull" else CRUSH)
    simulation = marched(tmp_path, tables, scaled(skin(), 2.0, 0.25))
    same(plain(name), simulation, length=2.0, stress=0.25)


def test_pulling_to_the_other_side(plain: Any, tmp_path: Path) -> None:
    """The mirror image: ridges in the other order, S1 and S2 changed over, normal forces as they were."""
    tables = scene({**PULL, "tangential_force_N": [-t for t in PULL["tangential_force_N"]]})
    one, other = plain("pull"), marched(tmp_path, tables, skin())
    for name, sign in (("normal", 1), ("tangential", -1), ("approach", 1), ("travel", -1)):
        here = sign * one.march.column(name)
        assert other.march.column(name) == pytest.approx(here, abs=ROUNDING * float(np.abs(here).max())), name
    largest = float(np.abs(one.march.column("films")).max())
    for ridge, image in ((1, 3), (2, 2), (3, 1)):
        assert other.raw[ridge] == pytest.approx(-one.raw[image], abs=ROUNDING * largest)
    assert other.slip_steps == one.slip_steps[::-1]
    assert other.runs == one.runs[::-1]


def test_a_point_more_on_a_straight_line(plain: Any, tmp_path: Path) -> None:
    history = {
        "time_s": [0.0, 0.05, 0.1, 0.17, 0.2],
        "normal_force_N": [0.0, 0.65, 1.3, 1.3, 1.3],
        "tangential_force_N": [0.0, 0.0, 0.0, 0.7, 1.0],
    }
    same(plain("pull"), marched(tmp_path, scene(history), skin()))


def test_names_and_order_change_nothing(plain: Any, tmp_path: Path) -> None:
    """To the last bit: they are read, and that is all."""
    tables = scene(PULL)
    tables = {key: tables[key] for key in sorted(tables, reverse=True)} | {"name": "another"}
    for key in ("effects", "history", "readout"):
        tables[key] = {name: tables[key][name] for name in sorted(tables[key])}
    assert list(tables["effects"]) != list(scene(PULL)["effects"])
    named = {key: skin()[key] for key in sorted(skin(), reverse=True)} | {"name": "other-skin"}
    one, other = plain("pull").as_json(), marched(tmp_path, tables, named, "elsewhere").as_json()
    for data in (one, other):
        data["effects"] = sorted(data["effects"])
        data.pop("name")
        data.pop("seconds")
    assert other == one


@pytest.mark.slow
def test_a_skin_turned_round_and_pulled_the_other_way_moves_alike(tmp_path: Path) -> None:
    """On ridges of unlike height."""

    def moves(heights: list[float], pull: float) -> np.ndarray:
        """Normal force, approach and travel at each step."""
        tables, unlike = scene({**PULL, "tangential_force_N": [0.0, 0.0, pull], "steps": 8}), skin()
        del unlike["ridge"]["height"]
        unlike["ridge"]["heights"] = heights
        march = marched(tmp_path, tables, unlike).march
        return np.array([(r.normal, r.approach, r.travel) for r in march.readings])

    one, other = moves([0.49, 0.5, 0.504], 0.3), moves([0.504, 0.5, 0.49], -0.3) * [1, 1, -1]
    # the coarsest meshes: each is off by some tenths of a percent, and not its own mirror image
    assert one == pytest.approx(other, rel=0.01, abs=1e-4)
    assert abs(one[-1, 2]) > 1e-2
