"""What the next mesh of a scene is expected to cost."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from skincad.mechanics import triangles
from skincad.mechanics.bodies import elements, film_field
from skincad.mechanics.film.stress import REFINEMENTS
from skincad.scenes import LEVELS, Level, March, expected, load_scene, models, piece_for, simulate
from skincad.scenes.march import EXPONENT
from tests.small_scene import THIRD, small_scene

SPENT = {"mesh": 0.5, "condense": 1.0, "march": 3.0}


def test_a_shared_mesh_costs_nothing_more() -> None:
    last, following = LEVELS[:2]
    assert last.fineness == following.fineness
    assert expected(following, last, SPENT) == pytest.approx(4.0 * 1.75**EXPONENT)


def test_a_finer_mesh_is_made_anew() -> None:
    last, following = LEVELS[2:4]
    growth = following.size / last.size
    assert expected(following, last, SPENT) == pytest.approx(0.5 * growth + 4.0 * growth**EXPONENT)


def test_sizes_are_those_of_the_papers_scene() -> None:
    """Within a tenth: the sizes were rounded, and a mesh changes with netgen's release."""
    piece = piece_for(load_scene("yamada-2002-press"), {})
    mesh = triangles(piece.pad, REFINEMENTS[0].sizes(piece))
    unknowns = [
        film_field.body(elements.curved(mesh, level.order), level.order, piece.pad.materials).system.unknowns
        for level in LEVELS[:2]
    ]
    assert unknowns[1] / unknowns[0] == pytest.approx(LEVELS[1].size, rel=0.1)


def test_the_time_left_is_told_and_falls_to_what_must_follow(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(models, "LONGER", 1e6)  # so that the march with fewer steps stands out
    ticks: list[tuple[str, int, float]] = []

    def tick(stage: str, step: int, left: float | None = None) -> None:
        if left is not None:
            ticks.append((stage, step, left))

    press = ("history.steps=8", "readout.ridges=[1]", THIRD)
    simulation = simulate(small_scene(tmp_path, "yamada-2002-press", *press), tol=0.5, tick=tick)
    stages = list(dict.fromkeys(stage for stage, _, _ in ticks))
    assert len(stages) == 3  # no error without a second mesh, nor without a march with fewer steps
    first, fewer, second = ([left for name, _, left in ticks if name == stage] for stage in stages)
    assert len(first) == len(second) == 8
    assert second[-1] == 0.0
    assert first[-1] > 100 * fewer[-1] > 0.0  # then the second mesh alone is left
    assert stages[1] == "march with fewer steps"
    assert [step for name, step, _ in ticks if name == stages[1]] == [5, 8]
    assert simulation.error is not None


def test_a_budget_is_told_to_be_too_small(tmp_path: Path) -> None:
    press = ("history.steps=4", "readout.ridges=[1]", THIRD)
    simulation = simulate(small_scene(tmp_path, "yamada-2002-press", *press), budget=1e-3)
    assert simulation.error is None
    assert any("more than the budget of 0.001 s" in warning for warning in simulation.warnings)
    assert any("of unknown error" in warning for warning in simulation.warnings)


@pytest.mark.parametrize(
    ("limits", "meshes"), [({"budget": 1e6}, 3), ({"budget": 1e6, "tol": 0.9}, 2), ({"tol": 0.9}, 2)]
)
def test_a_budget_alone_buys_the_best_and_a_tolerance_the_cheapest(
    limits: dict[str, float], meshes: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(models, "LEVELS", LEVELS[:3])
    stages: set[str] = set()

    def tick(stage: str, step: int, left: float | None = None) -> None:
        if "fineness" in stage:
            stages.add(stage)

    press = ("history.steps=2", "readout.ridges=[1]", THIRD)
    simulation = simulate(
        small_scene(tmp_path, "yamada-2002-press", *press), tick=tick, model="small_strain", **limits
    )
    assert len(stages) == meshes
    assert not any("met" in warning or "budget" in warning for warning in simulation.warnings)


def test_a_finer_mesh_that_fails_does_not_cost_what_was_good_enough(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(models, "LEVELS", LEVELS[:3])
    marched: list[March] = []
    march = models.march_on

    def fail_third(*arguments: Any) -> March:
        marched.append(march(*arguments))
        return replace(marched[-1], failed=True, stopped="step 2") if len(marched) == 3 else marched[-1]

    monkeypatch.setattr(models, "march_on", fail_third)
    press = ("history.steps=2", "readout.ridges=[1]", THIRD)
    simulation = simulate(
        small_scene(tmp_path, "yamada-2002-press", *press), budget=1e6, model="small_strain"
    )
    assert len(marched) == 3
    assert simulation.march is marched[1]
    assert any("a finer mesh stopped at step 2" in warning for warning in simulation.warnings)


def test_a_level_is_its_own_unit_unless_told() -> None:
    assert Level(1.0, 5).size == 1.0
