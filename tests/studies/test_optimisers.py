"""Known optima, through the code that studies use."""

from __future__ import annotations

from pathlib import Path
from typing import get_args

import numpy as np
import pytest

from skincad.base import Array, InputError
from skincad.studies import DesignVariable
from skincad.studies.optimisers import OPTIMISERS, Archive, OptimiserName, Outcome, minimise, optimiser

UNIT = tuple(DesignVariable(f"x{i}", "", None, 0.0, 1.0) for i in range(5))


def sphere(places: list[Array]) -> list[Outcome]:
    """The sphere around 0.3 with x0 + x1 at least 1: its least is at (0.5, 0.5, 0.3, ...), 0.08."""
    return [Outcome(x, np.array([np.sum((x - 0.3) ** 2)]), np.array([1.0 - x[0] - x[1]])) for x in places]


def zdt1(places: list[Array]) -> list[Outcome]:
    """Zitzler, Deb and Thiele 2000: its front is 1 - sqrt(x0), all other numbers 0."""
    rows = []
    for x in places:
        g = 1 + 9 * np.mean(x[1:])
        rows.append(Outcome(x, np.array([x[0], g * (1 - np.sqrt(x[0] / g))]), np.zeros(0)))
    return rows


def hypervolume(front: Archive) -> float:
    """The area that a front of two losses beats, up to (1.1, 1.1)."""
    points = sorted(tuple(entry.losses) for entry in front.front)
    area, above = 0.0, 1.1
    for x, y in points:
        if x < 1.1 and y < above:
            area += (1.1 - x) * (above - y)
            above = y
    return float(area)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_sphere_with_a_limit_ends_on_the_limit(
    seed: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    answer = minimise(sphere, optimiser("cma", UNIT, 1, seed, None), 1500)
    (best,) = answer.front[:1]
    assert best.losses[0] == pytest.approx(0.08, rel=1e-3)
    assert best.place == pytest.approx([0.5, 0.5, 0.3, 0.3, 0.3], abs=0.01)
    assert not [*tmp_path.iterdir()]  # the library writes logs of its own, if it is let


def test_a_start_that_is_known_is_gone_on_from() -> None:
    start = np.array([0.5, 0.52, 0.3, 0.3, 0.3])

    def bare(places: list[Array]) -> list[Outcome]:
        return [Outcome(entry.place, entry.losses, np.zeros(0)) for entry in sphere(places)]

    near, far = (
        minimise(bare, optimiser("cma", UNIT, 1, 1, begin), 60).front[0] for begin in (start, np.full(5, 0.9))
    )
    assert near.losses[0] < far.losses[0]


def test_whole_numbers_and_choices_are_optimised_too() -> None:
    """Least at 7 of 1 to 12, the third of five choices and 0.25: exactly found."""
    knobs = (
        DesignVariable("n", "", 3, 1.0, 12.0, whole=True),
        DesignVariable("c", "", "a", choices=("a", "b", "c", "d", "e")),
        DesignVariable("x", "", 0.5, 0.0, 1.0),
    )

    def mixed(places: list[Array]) -> list[Outcome]:
        rows = []
        for place in places:
            n, c, x = (knob.at(float(u)) for knob, u in zip(knobs, place, strict=True))
            assert isinstance(n, int)
            assert not isinstance(x, str)
            loss = (n - 7) ** 2 + 3 * (c != "c") + (x - 0.25) ** 2
            rows.append(Outcome(place, np.array([loss]), np.zeros(0)))
        return rows

    best = minimise(mixed, optimiser("cma", knobs, 1, 4, None), 1200).front[0]
    n, c, x = (knob.at(float(u)) for knob, u in zip(knobs, best.place, strict=True))
    assert (n, c) == (7, "c")
    assert x == pytest.approx(0.25, abs=0.01)


def test_places_without_a_result_are_left() -> None:
    def holed(places: list[Array]) -> list[Outcome]:
        return [
            t if t.place[2] > 0.2 else Outcome(t.place, np.array([np.nan]), t.limits) for t in sphere(places)
        ]

    best = minimise(holed, optimiser("cma", UNIT, 1, 5, None), 1500).front[0]
    assert best.losses[0] == pytest.approx(0.08, rel=1e-3)


@pytest.mark.slow
def test_the_front_of_zdt1_is_found_to_one_percent() -> None:
    """3000 evaluations leave 0.3 %, by two seeds."""
    answer = minimise(zdt1, optimiser("nsga2", UNIT, 2, 1, None), 3000)
    exact = 1.1 * 1.1 - 1 / 3  # all but what lies under the front, whose integral is 1/3
    assert hypervolume(answer) >= 0.99 * exact


def test_the_same_is_asked_for_again() -> None:
    """So a study that was interrupted goes through its log, and on."""
    for name, losses in (("cma", 1), ("sobol", 1), ("nsga2", 2)):
        function = sphere if losses == 1 else zdt1
        first, again = (
            minimise(function, optimiser(name, UNIT, losses, 7, None), 100)  # type: ignore[arg-type]
            for _ in range(2)
        )
        for one, other in zip(first.evaluations, again.evaluations, strict=True):
            assert np.array_equal(one.place, other.place)


def test_where_nothing_is_allowed_the_least_broken_is_told() -> None:
    front = Archive(
        [
            Outcome(np.zeros(2), np.array([1.0]), np.array([2.0, -5.0])),
            Outcome(np.ones(2), np.array([9.0]), np.array([0.5, 0.5])),
            Outcome(np.ones(2), np.array([np.nan]), np.array([0.0, 0.0])),
        ]
    )
    assert front.front[0].broken == 1.0


def test_every_name_has_its_row() -> None:
    assert get_args(OptimiserName) == tuple(OPTIMISERS)


def test_several_objectives_want_another_optimiser(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InputError, match="must be nsga2 or sobol"):
        optimiser("cma", UNIT, 2, 1, None)
    import sys

    monkeypatch.setitem(sys.modules, "optuna", None)
    name: OptimiserName = "nsga2"
    with pytest.raises(InputError, match=r"pip install 'skincad\[optuna\]'"):
        optimiser(name, UNIT, 2, 1, None)


@pytest.mark.parametrize("known", [(), ((0, 0), (1, 1))])
def test_a_design_counts_once(known: tuple[tuple[int, int], ...]) -> None:
    """Sobol points on 25 designs: 16 new ones are asked, or all that are left and then the search ends."""

    def design(place: Array) -> tuple[int, int]:
        return (int(place[0] * 5), int(place[1] * 5))

    def bare(places: list[Array]) -> list[Outcome]:
        return [Outcome(x, np.array([x.sum()]), np.zeros(0)) for x in places]

    for most, least in ((16, 16), (99, 25 - len(known))):
        answer = minimise(bare, optimiser("sobol", UNIT[:2], 1, 1, None), most, design, known)
        new = {design(evaluation.place) for evaluation in answer.evaluations} - set(known)
        assert len(new) >= least
        assert len(answer.evaluations) == len({design(evaluation.place) for evaluation in answer.evaluations})
