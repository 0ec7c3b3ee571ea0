"""Studies with one key, with choices and with whole numbers, against all combinations or a dense grid."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest

from skincad.base import Estimate, RefusedError
from skincad.inputs import Design, silicones
from skincad.studies import Optimisation, Study, knobs, optimise, query, sweep, value_of

Row = tuple[float, ...]  # the losses of an allowed design
WORK = ["force", "depth"]  # numbers of a check that takes no time
CHOICES: dict[str, list[Any]] = {
    "material.name": sorted(silicones(None)),
    "ridge.levelling": [0.0, 0.1, 0.2, 0.35, 0.5, 0.8],
    "skin.thickness": [4.0, 5.0, 6.0, 7.5, 9.0],
    "skin.curvature_radius": [45.0, 60.0, 80.0, 120.0, 160.0],
}


def study(vary: dict[str, Any], aims: Sequence[str], **changes: Any) -> Study:
    plain = {"name": "try", "about": "plain-ridges", "model": "winkler", "judge": "winkler", "vary": vary}
    return Study(**{**plain, "objectives": [{"key": key} for key in aims], **changes})


def discrete_keys(random: np.random.Generator, most: int) -> dict[str, Any]:
    """One to three keys, whole or choices or both, with at most this many combinations."""
    while True:
        names = random.permutation([*CHOICES, "ridge.count"])[: random.integers(1, 4)]
        vary, count = dict[str, Any](), 1
        for name in map(str, names):
            if name == "ridge.count":
                low, wide = int(random.integers(3, 8)), int(random.integers(2, 8))
                vary[name], count = f"{low}:{low + wide - 1}", count * wide
            else:
                values = list(random.permutation(np.array(CHOICES[name], dtype=object)))
                vary[name] = values[: int(random.integers(1, len(values) + 1))]
                count *= len(vary[name])
        if count <= most:
            return vary


def allowed_rows(wanted: Study) -> tuple[list[Row], int]:
    """The losses of all combinations that keep the limits, by the pessimistic end; and how many there are."""
    subject = wanted.subject()
    vary = {knob.key: list(knob.values()) for knob in knobs(subject, dict(wanted.vary))}
    rows = sweep(subject, vary, model="winkler").rows
    kept = []
    for row in rows:
        if row.refused:
            continue
        upper, lower = (
            {
                key.removesuffix("_N").removesuffix("_mm"): getattr(each, end)
                for key, each in row.results.items()
            }
            for end in ("upper", "lower")
        )
        broken = any(
            (limit.at_most is not None and upper[limit.key] > limit.at_most)
            or (limit.at_least is not None and lower[limit.key] < limit.at_least)
            for limit in wanted.constraints
        )
        if not broken:
            kept.append(tuple(upper[o.key] if o.goal == "min" else -lower[o.key] for o in wanted.objectives))
    return kept, len(rows)


def front(result: Optimisation) -> list[Row]:
    goals = [objective.goal for objective in result.study.objectives]
    return [
        tuple(
            float(objective.upper or 0.0) if goal == "min" else -float(objective.lower or 0.0)
            for goal, objective in zip(goals, member.objectives.values(), strict=True)
        )
        for member in result.front
    ]


def random_aims(random: np.random.Generator, several: bool) -> dict[str, Any]:
    goals = [
        {"key": "all_touch_force", "goal": str(random.choice(["min", "max"]))},
        {"key": "approach", "goal": str(random.choice(["min", "max"]))},
    ]
    limits: list[list[dict[str, Any]]] = [
        [],
        [{"key": "all_touch_force", "at_most": float(random.uniform(1.0, 6.0))}],
        [{"key": "approach", "at_least": float(random.uniform(0.02, 0.1))}],
    ]
    return {
        "objectives": goals if several else [goals[int(random.integers(2))]],
        "constraints": limits[int(random.integers(3))],
    }


@pytest.mark.slow
@pytest.mark.parametrize("several", [False, True], ids=["one", "front"])
def test_all_combinations_are_evaluated_if_they_fit(several: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """40 random studies find the best of all, or the whole front, with the package optuna or without."""
    monkeypatch.setitem(sys.modules, "optuna", None)
    random = np.random.default_rng(34 + several)
    for _ in range(20 if several else 40):
        vary = discrete_keys(random, 25)
        wanted = study(vary, [], **random_aims(random, several))
        kept, count = allowed_rows(wanted)
        result = optimise(wanted.with_(evaluations=count))
        assert result.untried == 0
        assert len(result.rows.rows) == count
        assert result.feasible == bool(kept), vary
        best = front(result)
        for row in kept:  # the same numbers by the same model, so no tolerance
            assert any(all(x <= y for x, y in zip(member, row, strict=True)) for member in best), vary


def test_the_budget_is_spent_on_new_designs_alone() -> None:
    """Where not all combinations fit, it says how many were not tried."""
    random = np.random.default_rng(5)
    for _ in range(10):
        vary: dict[str, Any] = {}
        while math.prod([len(knob) for knob in vary.values()]) < 40:
            vary = {k: v for k, v in discrete_keys(random, 10**6).items() if not isinstance(v, str)}
        wanted = study(vary, ["approach"], evaluations=int(random.integers(5, 25)))
        result = optimise(wanted)
        count = math.prod([len(values) for values in vary.values()])
        tried = len(result.rows.rows)
        assert wanted.evaluations <= tried < wanted.evaluations + 8  # a batch that was begun is ended
        assert result.untried == count - tried
        assert json.loads(json.dumps(result.as_json()))["untried"] == result.untried
        assert f"not tried      {result.untried} of {count} combinations" in str(result)
        assert result.evaluations <= tried + 1  # and the start, for the judge


@pytest.mark.parametrize("name", ["sobol", pytest.param("nsga2", marks=pytest.mark.slow)])
def test_a_named_optimiser_spends_its_budget_too(name: str) -> None:
    """A whole number has few places on the cube, which both ask again and again."""
    if name == "nsga2":
        pytest.importorskip("optuna")
    vary = {"ridge.count": "3:13", "ridge.levelling": np.linspace(0.0, 0.95, 20).tolist()}
    result = optimise(study(vary, ["approach"], optimiser=name, evaluations=219))
    assert len(result.rows.rows) >= 219
    assert result.untried == 220 - len(result.rows.rows)


class Work:
    """A check that takes no time: `force` and `depth` are functions of the design."""

    functions: dict[str, Callable[[Design], float]]

    def __init__(self, design: Design) -> None:
        self.values = {name: function(design) for name, function in self.functions.items()}
        if not all(map(math.isfinite, self.values.values())):
            raise RefusedError("has no solution here")

    def numbers(self) -> dict[str, Estimate]:
        return {name: Estimate(value, 0.0, "") for name, value in self.values.items()}


def wave(random: np.random.Generator) -> Callable[[Any], Any]:
    """A random sum of sines from 0 to 1, of a few minima."""
    size, phase = random.normal(size=4), random.uniform(0.0, 2 * math.pi, 4)
    return lambda x: sum(
        a * np.sin(2 * math.pi * k * x + p) for k, a, p in zip((0.5, 1, 2, 3), size, phase, strict=True)
    )


def work(monkeypatch: pytest.MonkeyPatch, **functions: Callable[[Design], float]) -> None:
    monkeypatch.setattr(Work, "functions", functions, raising=False)
    monkeypatch.setitem(query._ASKED, "check", lambda design, _: Work(design))


def thickness(design: Design) -> float:
    """Its share of 4 to 8 mm."""
    return (design.skin.thickness - 4.0) / 4.0


GRID = np.linspace(0.0, 1.0, 2001)


@pytest.mark.parametrize("budget", [60, pytest.param(200, marks=pytest.mark.slow)])
def test_one_number_is_no_worse_than_a_dense_grid(budget: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of random functions with several minima, limits, and ranges that are refused."""
    random = np.random.default_rng(budget)
    for number in range(12 if budget == 60 else 6):
        loss, limit, low = wave(random), wave(random), float(random.uniform(0.0, 0.2))
        limited, holed = bool(number % 2), number % 3 == 2

        def force(design: Design, loss=loss, holed=holed, low=low) -> float:  # type: ignore[no-untyped-def]
            x = thickness(design)
            return math.nan if holed and x < low else float(loss(x))

        work(monkeypatch, force=force, depth=lambda design, limit=limit: float(limit(thickness(design))))
        limits = [{"key": "depth", "at_most": 0.0}] if limited else []
        result = optimise(study({"skin.thickness": "4:8"}, ["force"], constraints=limits, evaluations=budget))
        entry = GRID[((limit(GRID) <= 0) | (not limited)) & ((low <= GRID) | (not holed))]
        assert result.untried is None
        assert result.feasible or not entry.size
        if entry.size:
            best = result.front[0].objectives["force"].value
            # values have 5 digits, and the steepest of these functions rise by 20 in the range
            assert best is not None
            assert best <= loss(entry).min() + 1e-3


def test_one_number_has_a_front_too(monkeypatch: pytest.MonkeyPatch) -> None:
    """A front of two losses comes as near to each point of a dense grid's front as the next ones on it."""
    monkeypatch.setitem(sys.modules, "optuna", None)
    random = np.random.default_rng(3)
    for _ in range(4):
        force, depth = wave(random), wave(random)
        work(
            monkeypatch,
            force=lambda design, of=force: float(of(thickness(design))),
            depth=lambda design, of=depth: float(of(thickness(design))),
        )
        result = optimise(study({"skin.thickness": "4:8"}, WORK, evaluations=150))
        losses = np.array([force(GRID), depth(GRID)]).T
        spread = np.ptp(losses, axis=0)
        members = np.array(front(result))
        excess = ((members[:, None] - losses[None]) / spread).max(axis=2).min(axis=0)
        assert excess.max() < 0.03  # of the range, by 150 designs


@pytest.mark.parametrize("names", [1, 3])
def test_choices_beside_a_number_are_no_worse_than_a_dense_grid(
    names: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One or several choices, each with another function, of which each has several minima."""
    random = np.random.default_rng(names)
    for _ in range(4):
        counts = [5, 7, 9][: int(random.integers(1, 4))] if names > 1 else [9]
        losses = {count: wave(random) for count in counts}
        work(
            monkeypatch,
            force=lambda design, of=losses: float(of.get(design.ridge.count, abs)(thickness(design))),
            depth=lambda _: 0.0,
        )
        vary = {"ridge.count": counts, "skin.thickness": "4:8"}
        result = optimise(study(vary, ["force"], evaluations=150))
        best = result.front[0].objectives["force"].value
        assert best is not None
        assert best <= min(of(GRID).min() for of in losses.values()) + 1e-3  # 5 digits, as above


def test_choices_beside_a_number_that_do_not_fit(monkeypatch: pytest.MonkeyPatch) -> None:
    """Four evaluations for each choice find the best one and its best number, of smooth results."""
    names = sorted(silicones(None))
    for seed in range(3):
        random = np.random.default_rng(seed)
        height, place = random.permutation(len(names)) / 4.0, random.uniform(0.2, 0.8)

        def force(design: Design, height=height, place=place) -> float:  # type: ignore[no-untyped-def]
            level = names.index(str(value_of(design, "material.name")))
            return float(height[level] + (thickness(design) - place) ** 2)

        work(monkeypatch, force=force, depth=lambda _: 0.0)
        vary = {"material.name": "all", "skin.thickness": "4:8"}
        result = optimise(study(vary, ["force"], evaluations=4 * len(names)))
        best = result.front[0].objectives["force"].value
        assert best is not None
        assert best <= 1e-4  # the next best choice has 0.25


def test_keys_that_do_not_fit_come_near_the_best(monkeypatch: pytest.MonkeyPatch) -> None:
    """60 of 1210 designs find one of the best ten; as many random ones would do so in two of five studies."""
    radii, thicknesses = np.linspace(50.0, 150.0, 11), np.linspace(4.0, 8.0, 10)
    for seed in range(4):
        a, b, c = np.random.default_rng(seed).uniform(0.2, 0.8, 3)

        def loss(radius: Any, thick: Any, count: Any, a=a, b=b, c=c) -> Any:  # type: ignore[no-untyped-def]
            return ((radius - 50) / 100 - a) ** 2 + ((thick - 4) / 4 - b) ** 2 + ((count - 3) / 10 - c) ** 2

        def force(design: Design, of=loss) -> float:  # type: ignore[no-untyped-def]
            return float(of(design.skin.curvature_radius, design.skin.thickness, design.ridge.count))

        work(monkeypatch, force=force, depth=lambda _: 0.0)
        vary = {
            "skin.curvature_radius": radii.tolist(),
            "skin.thickness": thicknesses.tolist(),
            "ridge.count": "3:13",
        }
        best = optimise(study(vary, ["force"], evaluations=60)).front[0].objectives["force"].value
        every = loss(*np.meshgrid(radii, thicknesses, np.arange(3, 14)))
        assert best is not None
        assert (every < best - 1e-12).sum() < 10


def test_the_same_seed_asks_the_same(tmp_path: Any) -> None:
    for number, vary in enumerate(
        (
            {"skin.thickness": "4:8"},
            {"material.name": "all", "ridge.count": "3:9"},
            {"material.name": "all", "skin.thickness": "4:8"},
        )
    ):
        wanted = study(vary, ["approach"], evaluations=30)
        first, again = (optimise(wanted, folder=tmp_path / str(number)) for _ in range(2))
        assert (again.evaluations, again.front, again.rows.rows) == (0, first.front, first.rows.rows)
