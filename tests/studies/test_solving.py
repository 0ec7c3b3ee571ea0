"""The search for values: roots of a function, the least change of several numbers, solving, its command."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import skincad
from skincad.base import Array, Estimate, InputError, RefusedError
from skincad.cli import run
from skincad.inputs import silicones
from skincad.outputs import write_solution
from skincad.studies import Evaluation, Query, Solution, SolutionPoint, solve, value_of
from skincad.studies.roots import CLOSE, STARTS, STEP, least_change, search

Function = Callable[[float], float | None]
EXACT = 1e-3  # relative to the wanted value
TOL = 5e-3  # the same, by default of `solve`
SEEDS = pytest.mark.evidence(subject="seeds: roots")
RISING: dict[str, tuple[Function, float, float]] = {  # function, wanted, root
    "line": (lambda x: 3 * x, 1.0, 1 / 3),
    "power": (lambda x: (0.05 + x) ** -1.5, 5.0, 5.0 ** (-1 / 1.5) - 0.05),
    "exponential": (lambda x: math.exp(8 * x), 100.0, math.log(100) / 8),
}


@pytest.mark.parametrize("name", RISING)
def test_a_monotone_function_is_solved_in_seven_evaluations(name: str) -> None:
    function, wanted, root = RISING[name]
    match = search(function, wanted, EXACT * wanted, 40)
    assert match.exact
    assert len(match.seen) <= 7  # five that are spread, and two
    (x,) = match.roots
    assert abs(function(x) - wanted) <= EXACT * wanted
    assert x == pytest.approx(root, abs=2e-3)  # EXACT over the smallest slope, relative, of the three


def test_all_crossings_are_found_a_pair_by_its_extremum() -> None:
    match = search(lambda x: math.sin(9 * x), 0.5, 5e-4, 40)
    by_hand = [(math.asin(0.5) + turn) / 9 for turn in (0, 2 * math.pi)]
    by_hand += [(math.pi - math.asin(0.5) + turn) / 9 for turn in (0, 2 * math.pi)]
    # an error of 5e-4 over the slope there, 9 cos(asin 0.5)
    assert match.roots == pytest.approx(sorted(by_hand), abs=5e-4 / 7)
    match = search(lambda x: (x - 0.4) ** 2, 0.01, 1e-5, 40)
    assert match.roots == pytest.approx([0.3, 0.5], abs=1e-4)  # 1e-5 over the slope 0.2, doubled
    touching = search(lambda x: (x - 0.37) ** 2, 0.0, 1e-6, 40)
    assert touching.roots == pytest.approx([0.37], abs=1e-3)  # the root of the tolerance


def test_a_guide_saves_evaluations_and_a_wrong_one_misleads_nobody() -> None:
    match = search(lambda x: (1 + 0.3 * x) * (0.05 + x) ** -1.5, 5.0, 0.02, 40, lambda x: (0.05 + x) ** -1.5)
    assert len(match.seen) <= 3
    assert len(match.roots) == 1

    # one shows crossings that a few evaluations do not
    def guide(x: float) -> float:
        return 2 + math.sin(9 * x)

    match = search(lambda x: (1 + 0.3 * x) * guide(x), 2.3, 2e-3, 40, guide)
    assert len(match.roots) == 3
    assert len(match.seen) <= 9
    # a wrong one misleads nobody
    match = search(lambda x: 3 * x + 1, 2.0, 1e-3, 40, lambda x: math.exp(-3 * x))
    assert match.exact
    assert match.roots == pytest.approx([1 / 3], abs=1e-3)

    # holes of a guide are filled, one of no sign is left out
    def holes(x: float) -> float | None:
        return None if x > 0.8 else 1 + x

    assert search(lambda x: 2 + 2 * x, 3.0, 1e-3, 40, holes).roots == pytest.approx([0.5], abs=1e-3)
    assert search(lambda x: 2 * x, 1.0, 1e-3, 40, lambda x: x - 0.3).roots == pytest.approx([0.5], abs=1e-3)


def test_a_guide_that_vanishes_tells_no_ratio_there() -> None:
    """As levelling does: the closed form needs no force at all where crests are level."""
    match = search(lambda x: 2.7 - 2.68 * x, 2.0, 0.01, 40, lambda x: max(2.2 * (1 - x), 1e-13), first=0.0)
    assert len(match.roots) == 1
    low, high = match.within(match.roots[0], 0.27)
    assert (low, high) == pytest.approx((0.43 / 2.68, 0.97 / 2.68), rel=0.1)  # the guide's own slope


def test_jumps_ends_and_missing_values() -> None:
    match = search(lambda x: 0.0 if x < 0.3 else 1.0, 0.5, 1e-3, 40)
    assert not match.roots
    assert match.jumps == pytest.approx([0.3], abs=CLOSE)
    match = search(lambda x: None if x < 0.55 else 1 / (x - 0.5), 12.0, 0.05, 40)
    assert match.roots == pytest.approx([0.5 + 1 / 12], abs=1e-3)  # 0.05 over the slope 144, doubled
    fine = search(lambda x: x**3 + 0.1 * x, 0.3, 1e-9, 40)  # finer than a search tells, but no jump
    assert (fine.roots, fine.jumps, fine.complete) == ([], [], False)
    nothing = search(lambda _: None, 1.0, 1e-3, 40)
    assert (nothing.roots, nothing.exact, len(nothing.seen)) == ([], True, 9)
    above = search(lambda x: 1 + x, 3.0, 1e-3, 40)
    assert (above.roots, above.exact) == ([], True)
    assert above.seen[1.0] == 2.0  # the nearest that there is
    guided = search(lambda x: 1 + x, 9.0, 1e-3, 40, lambda x: 1 + 0.9 * x)
    assert (guided.roots, guided.exact) == ([], True)
    assert guided.seen[1.0] == 2.0
    assert search(lambda x: 3 * x, 3.0, 1e-3, 40).roots == [1.0]
    assert len(search(lambda _: 1.0, 1.0, 1e-3, 40).roots) == 1
    match = search(lambda x: math.sin(9 * x), 0.5, 5e-4, 6)
    assert (match.exact, len(match.seen)) == (False, 6)
    for most in range(1, 5):
        assert not search(lambda x: 1 + x, 9.0, 1e-3, most, lambda _: 1.0, step=STEP).complete


def shapes(seed: int) -> list[Function]:
    """Random functions that turn, are bent sharply, or have no value at first."""
    rng = np.random.default_rng(seed)
    turns, phase, above, middle, width, tilt, hole, steep = rng.uniform(0.05, 0.95, size=8).tolist()
    powers = rng.normal(size=6)
    return [
        lambda x: 1.1 + above + math.sin((1 + 8 * turns) * x + 6.3 * phase),
        lambda x: 2 + tilt * x + math.exp(-(((x - middle) / (0.07 + 0.33 * width)) ** 2) / 2),
        lambda x: 4 - (3 * turns if x < middle else 3 * tilt) * abs(x - middle),
        lambda x: (0.02 + above / 2 + x) ** (6 * phase - 3),
        lambda x: None if x < 0.9 * hole else 1 / (x - 0.9 * hole + 0.01 + steep / 5),
        lambda x: 5 + float(np.polyval(powers, 2 * x - 1)),
    ]


@pytest.mark.parametrize("seeds", [range(3), pytest.param(range(3, 25), marks=SEEDS)], ids=["few", "many"])
def test_no_hidden_value_is_denied_by_a_guide_that_sees_nothing(seeds: range) -> None:
    """Random values, and those of the extrema, which lie between all evaluations; a flat guide, and none."""
    grid = np.linspace(0.0, 1.0, 201)
    denied = []
    for seed in seeds:
        for number, function in enumerate(shapes(seed)):
            values = np.array([np.nan if (y := function(x)) is None else y for x in grid])
            chosen = np.random.default_rng(seed).choice(np.flatnonzero(np.isfinite(values)))
            for at in (chosen, np.nanargmax(values), np.nanargmin(values)):
                wanted = float(values[at])
                guide: Function | None = (lambda _: 1.0) if seed % 2 else None
                match = search(function, wanted, 5e-3 * abs(wanted), 40, guide, step=STEP)
                if not match.roots:
                    denied.append((seed, number, grid[at], wanted, match.complete))
    assert not denied


def test_a_sharp_extremum_beside_an_end_is_not_denied() -> None:
    for top in np.linspace(0.01, 0.11, 6):
        for up, down in ((1, 1), (3, 1), (1, 3), (6, 1)):

            def peak(x: float, top: float = top, up: int = up, down: int = down) -> float:
                return 4 - (up if x < top else down) * abs(x - top)

            assert search(peak, 4.0 - 0.007, 0.008, 40, step=STEP).roots, (top, up, down)


@pytest.mark.parametrize("seeds", [range(1), pytest.param(range(1, 8), marks=SEEDS)], ids=["few", "many"])
def test_what_is_denied_is_nowhere_and_both_ends_were_looked_at(seeds: range) -> None:
    for seed in seeds:
        for function in shapes(seed):
            values = [y for x in np.linspace(0, 1, 2001) if (y := function(x)) is not None]
            spread = max(values) - min(values)
            for wanted in (max(values) + 0.1 * spread, min(values) - 0.1 * spread, max(values) + 9 * spread):
                match = search(function, wanted, 1e-3 * spread, 40, lambda _: 1.0, step=STEP)
                assert match.complete
                assert not match.roots
                assert {0.0, 1.0} <= match.seen.keys()
                assert len(match.seen) >= 5


def test_a_value_beside_an_end_or_in_a_narrow_stretch_is_found() -> None:
    """As where levelling of 0 is none at all: what holds beside it holds not there."""

    def apart(x: float) -> float:
        return 2.35 if x == 0 else 2.16 + 12 * x

    assert search(apart, 2.25, 0.01, 40, step=STEP, cuts=[0.0]).roots
    denied = search(apart, 1.9, 0.01, 40, step=STEP, cuts=[0.0])
    assert denied.complete
    assert not denied.roots

    def narrow(x: float) -> float | None:
        return 3 * x if 0.3 < x < 0.33 else None

    assert search(narrow, 0.95, 5e-3, 40, narrow, first=1.0, step=STEP).roots


NORMAL: Array = np.array([1.0, 2.0, 0.5])


def line(place: Array) -> Array:
    return np.array([place @ NORMAL])


def test_one_line_is_met_at_its_nearest_point_and_a_steep_one_in_the_box() -> None:
    start = np.full(3, 0.2)
    best, seen = least_change(line, start, np.array([2.0]), np.array([1e-3]), 60)
    by_hand = start + NORMAL * (2.0 - line(start)) / (NORMAL @ NORMAL)
    assert best == pytest.approx(by_hand, abs=1e-3)  # the tolerance over the slope
    assert len(seen) <= 6

    def function(place: Array) -> Array:
        return np.array([np.exp(5 * place[0] - 3 * place[1] + place[2])])

    best, _ = least_change(function, np.full(3, 0.2), np.array([20.0]), np.array([0.1]), 60)
    assert np.all((best >= 0) & (best <= 1))
    assert function(best)[0] == pytest.approx(20.0, abs=0.1)


def test_two_curves_are_met_at_once() -> None:
    def function(place: Array) -> Array:
        return np.array([place[0] * place[1], place[1] + place[2] ** 2])

    wanted, start = np.array([0.5, 1.2]), np.full(3, 0.5)
    best, _ = least_change(function, start, wanted, np.full(2, 1e-3), 60)
    assert function(best) == pytest.approx(wanted, abs=1e-3)
    # no point of both curves, looked up finely, is nearer than by what STILL leaves
    y = np.linspace(0.5, 1.0, 5001)
    z = np.sqrt(np.maximum(1.2 - y, 0.0))
    distance = np.sqrt((0.5 / y - 0.5) ** 2 + (y - 0.5) ** 2 + (z - 0.5) ** 2)[(z <= 1) & (0.5 / y <= 1)]
    assert np.linalg.norm(best - start) <= distance.min() + 0.01


def test_out_of_reach_gives_the_closest() -> None:
    best, seen = least_change(line, np.full(3, 0.2), np.array([9.0]), np.array([1e-3]), 60)
    assert best is None
    assert max(seen, key=seen.__getitem__) == pytest.approx([1.0, 1.0, 1.0], abs=1e-6)

    # a start without values is left for one with
    def function(place: Array) -> Array | None:
        return None if place[0] < 0.4 else line(place)

    best, _ = least_change(function, np.full(3, 0.2), np.array([2.0]), np.array([1e-3]), 60)
    assert best[0] >= 0.4
    # no values at all end soon; no more is evaluated than allowed
    best, seen = least_change(lambda _: None, np.full(3, 0.2), np.array([2.0]), np.array([1e-3]), 60)
    assert (best, any(seen.values()), len(seen)) == (None, False, 1 + STARTS)
    _, seen = least_change(line, np.full(3, 0.2), np.array([2.0]), np.array([1e-3]), 3)
    assert len(seen) == 3


DESIGN = skincad.load_design("yamada-2002")
PLAIN = skincad.load_design("plain-ridges", ["ridge.count=3", "skin.width=5.0"])
CIRCUIT = skincad.load_circuit("transimpedance")


def quick(target: dict[str, float], vary: dict[str, Any], **options: Any) -> Solution:
    return solve(DESIGN, target, vary, model="winkler", **options)


def test_a_value_gives_what_was_wanted_when_it_is_asked_anew() -> None:
    answer = quick({"all_touch_force": 1.5}, {"skin.curvature_radius": (20, 200)})
    (one,) = answer.solutions
    radius = float(one.values["skin.curvature_radius"])

    def force(radius: float) -> Estimate:
        return skincad.check(DESIGN.with_(skin={"curvature_radius": radius}), model="winkler").all_touch_force

    assert force(radius) == one.reached["all_touch_force_N"]
    assert force(radius).value == pytest.approx(1.5, rel=TOL)
    assert answer.solved == DESIGN.with_(skin={"curvature_radius": radius})
    assert answer.feasible
    # the interval is where the error leaves it open, by the cubics through a few evaluations
    low, high = one.interval["skin.curvature_radius"]
    assert 20 <= low < radius < high <= 200
    ends = [end for end in (low, high) if end not in (20, 200)]
    assert ends
    for end in ends:
        error = one.reached["all_touch_force_N"].error or 0.0
        assert abs((force(end).value or 0.0) - 1.5) == pytest.approx(error, rel=0.05)
    data = answer.as_json()
    assert {"name", "target", "vary", "solutions", "evaluations", "feasible", "seconds"} <= data.keys()
    assert data["target"] == {"all_touch_force_N": 1.5}
    assert data["vary"] == {"skin.curvature_radius": [20, 200]}
    assert {"values", "reached", "nearest"} <= data["solutions"][0].keys()


def test_several_numbers_change_least() -> None:
    vary = {"skin.curvature_radius": (20, 200), "skin.thickness": (2, 8)}
    vary |= {"material.young_modulus": (0.1, 2.0)}
    answer = quick({"all_touch_force": 1.5}, vary)
    (one,) = answer.solutions
    assert one.reached["all_touch_force_N"].value == pytest.approx(1.5, rel=TOL)
    assert one.values["skin.curvature_radius"] != 60
    assert one.values["skin.thickness"] != 4
    assert one.nearest["material.name"]
    two = quick({"all_touch_force": 1.5, "approach": 0.15}, vary)
    (both,) = two.solutions
    assert both.reached["approach_mm"].value == pytest.approx(0.15, rel=TOL)
    assert both.reached["all_touch_force_N"].value == pytest.approx(1.5, rel=TOL)


def test_choices_and_whole_numbers_are_tried_one_by_one() -> None:
    answer = quick({"all_touch_force": 2.2}, {"material.name": "all"})
    assert len(answer.evaluations) == 10
    assert answer.solutions[0].values == {"material.name": "dragon-skin-30"}  # the design's own, 2.2 N
    counted = quick({"ridges": 7}, {"ridge.count": (5, 9)})
    assert [one.values for one in counted.solutions] == [{"ridge.count": 7}]


def test_a_limit_is_kept_with_the_least_change() -> None:
    """Where the design keeps it nothing changes; else it is met as a number is, and one key may have two."""
    kept = quick({"all_touch_force": "<= 3"}, {"ridge.levelling": (0, 1)})
    assert kept.solutions[0].values == {"ridge.levelling": 0.0}
    assert len(kept.evaluations) == 1
    assert "all_touch_force at most 3 N" in str(kept)
    assert kept.as_json()["target"] == {"all_touch_force_N": 3.0}
    assert kept.as_json()["bounds"] == {"all_touch_force_N": "<="}
    met = quick({"all_touch_force": "<=1.5"}, {"ridge.levelling": (0, 1)})
    exact = quick({"all_touch_force": 1.5}, {"ridge.levelling": (0, 1)})
    assert met.solutions[0].values == exact.solutions[0].values
    assert exact.as_json()["bounds"] is None
    both = quick({"all_touch_force": "<=1.5", "approach": ">=0.05"}, {"ridge.levelling": (0, 1)})
    reached = both.solutions[0].reached
    assert float(reached["all_touch_force_N"]) <= 1.5 * (1 + TOL)
    assert float(reached["approach_mm"]) >= 0.05 * (1 - TOL)
    stiffer = quick({"all_touch_force": ">=3"}, {"material.name": "all"})
    own = quick({"all_touch_force": ">=2"}, {"material.name": "all"}).solutions[0]
    assert own.values == {"material.name": "dragon-skin-30"}  # the design's, of those that keep it
    assert stiffer.solutions
    assert all(float(one.reached["all_touch_force_N"].upper) >= 3 for one in stiffer.solutions)


def test_the_nearest_says_whether_the_target_is_within_its_error() -> None:
    """0.25 N is beyond the flattest skin's value; by the closed form's error it may be that."""
    far = quick({"all_touch_force": 1e-4}, {"skin.curvature_radius": (40, 60)})
    assert "lies within its error" not in str(far)
    nearest = float(far.closest.reached["all_touch_force_N"])
    near = quick({"all_touch_force": 0.97 * nearest}, {"skin.curvature_radius": (40, 60)})
    assert not near.feasible
    assert str(near).splitlines()[0].endswith("; the target lies within its error.")


@pytest.mark.slow
def test_a_number_is_solved_for_each_choice() -> None:
    vary = {"material.name": "dragon-skin-20,dragon-skin-30", "skin.curvature_radius": (20, 200)}
    answer = quick({"all_touch_force": 1.5}, vary)
    names = [one.values["material.name"] for one in answer.solutions]
    assert names == ["dragon-skin-30", "dragon-skin-20"]  # the design's own first: the least change
    for one in answer.solutions:
        assert one.reached["all_touch_force_N"].value == pytest.approx(1.5, rel=TOL)
    frame = answer.to_frame()
    assert list(frame["material.name"]) == names
    columns = zip(frame["skin.curvature_radius_mm"], frame["all_touch_force_N.error"], strict=True)
    for one, (radius, error) in zip(answer.solutions, columns, strict=True):
        assert one.values["skin.curvature_radius"] == radius
        assert one.reached["all_touch_force_N"].error == error


@pytest.mark.slow
def test_out_of_reach_says_how_near_any_value_comes() -> None:
    answer = quick({"all_touch_force": 0.1}, {"skin.curvature_radius": (20, 200)})
    assert not answer.feasible
    assert answer.closest.values == {"skin.curvature_radius": 200.0}
    words = "no skin.curvature_radius from 20 to 200 mm gives all_touch_force 0.1 N. The nearest is"
    assert words in str(answer)
    assert "200 mm" in str(answer)
    assert str(answer).endswith("Next: look further: widen a range of --vary, or vary another key.")
    assert answer.to_frame().empty
    assert answer.as_json()["searched"] == "complete"
    with pytest.raises(RefusedError):
        _ = answer.solved
    above = quick({"all_touch_force": 100.0}, {"skin.curvature_radius": (20, 200)})
    assert "at most" not in str(above)
    assert 20.0 in [evaluation.values["skin.curvature_radius"] for evaluation in above.evaluations]


def test_a_search_that_runs_out_denies_nothing() -> None:
    answer = quick({"all_touch_force": 0.1}, {"skin.curvature_radius": (20, 200)}, evaluations=4)
    assert "none found in 4 evaluations of skin.curvature_radius from 20 to 200 mm" in str(answer)
    assert answer.as_json()["searched"] == "partial"
    walk = quick({"all_touch_force": 1e-3}, {"skin.curvature_radius": (20, 60), "skin.length": (11, 12)})
    assert not walk.feasible
    assert walk.as_json()["searched"] == "partial"
    answer = quick({"all_touch_force": 2.0}, {"skin.width": (1.0, 2.0)})
    assert not answer.feasible
    assert answer.closest is None
    assert "every value is refused" in str(answer)
    assert "skin.width" in str(answer)


@pytest.mark.evidence(subject="optima: solve")
def test_a_key_that_the_closed_form_does_not_know_is_solved() -> None:
    """The closed form says the same for every crown: corrected needs 2.73 N at 0.01 mm, 2.44 N at 0.09 mm."""
    solution = solve(DESIGN, {"all_touch_force": 2.45}, {"ridge.crown": (0.01, 0.09)})
    assert solution.question.model == "corrected"
    assert solution.solutions[0].reached["all_touch_force_N"].value == pytest.approx(2.45, rel=TOL)


@pytest.mark.slow  # about seven evaluations
def test_a_number_that_only_the_better_model_tells_is_solved_for() -> None:
    """The closed form's result has no such number. One that no model tells is refused with the nearest."""
    vary = {"skin.curvature_radius": (40, 120)}
    assert solve(PLAIN, {"modulus_sensitivity": 0.04}, vary, model="linear").feasible
    with pytest.raises(InputError, match="did you mean 'modulus_sensitivity'"):
        solve(PLAIN, {"modulus_sensitivty": 0.04}, vary, model="linear")


@pytest.mark.parametrize(
    ("force", "ends", "word"),
    [(0.02, (0.004, 0.1), "soft"), (2.2, (0.2, 1.6), ""), (30.0, (2.0, 50.0), "stiff")],
)
def test_a_modulus_names_a_silicone(force: float, ends: tuple[float, float], word: str) -> None:
    answer = quick({"all_touch_force": force}, {"material.young_modulus": ends}, force=force)
    (one,) = answer.solutions
    assert one.nearest["material.name"] in silicones(None)
    assert one.nearest["material.name"] in str(answer)
    rows = [note for note in answer.notes if note.startswith("no silicone is as")]
    assert [word in note for note in rows] == ([True] if word else [])


@pytest.mark.slow
def test_circuits_and_scenes_are_solved_too() -> None:
    solution = solve(CIRCUIT, {"cutoff": 800.0}, {"amplifier.feedback_resistance": (1e7, 1e9)})
    told = f"{solution}"
    assert solution.question.kind == "circuit"
    assert solution.feasible or "the result has no cutoff_Hz at any value" in told
    # The gain at the sweep's end, as the film's resonance passes it: 3.7 dB, of 0.1 and 1.9 at the ends
    follower = skincad.load_circuit("voltage-follower")
    inductance = float(value_of(follower, "motional.inductance"))
    vary = {"motional.inductance": (inductance / 10, inductance * 10)}
    assert solve(follower, {"gain_dB.last": 3.5}, vary).feasible


@pytest.mark.parametrize(
    ("target", "vary", "options", "says"),
    [
        ({}, {"skin.length": (8, 12)}, {}, "names no number"),
        ({"all_touch_force": 1.0}, {}, {}, "names no key"),
        ({"all_touch_forc": 1.0}, {"skin.length": (8, 12)}, {}, "did you mean 'all_touch_force'"),
        ({"all_touch_force": float("nan")}, {"skin.length": (8, 12)}, {}, "must be finite"),
        ({"all_touch_force": 1.0, "approach": 1.0}, {"skin.length": (8, 12)}, {}, "as many numbers as keys"),
        ({"all_touch_force": 1.0}, {"skin.length": (8, 12)}, {"tol": 0.0}, "between 0 and 1"),
        ({"all_touch_force": 1.0}, {"skin.length": (8, 12)}, {"evaluations": 0}, "at least 1"),
        ({"all_touch_force": 1.0}, {"ridge.count": (1, 999)}, {}, "combinations of choices"),
    ],
)
def test_what_can_not_be_asked_is_said(target: dict, vary: dict, options: dict, says: str) -> None:
    with pytest.raises(InputError, match=says):
        quick(target, vary, **options)
    with pytest.raises(InputError, match="is for a design"):
        solve(CIRCUIT, {"cutoff": 800.0}, {"amplifier.gain": (1e3, 1e5)}, model="linear")


RADIUS = "--vary skin.curvature_radius=20:200 --tier winkler"
SOLVE = f"solve yamada-2002 {RADIUS} --target"


def said(capsys: pytest.CaptureFixture[str], command: str) -> tuple[int, str]:
    status = run(command.split())
    return status, capsys.readouterr().out


def test_solve_writes_the_design(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    copy, picture = tmp_path / "solved.toml", tmp_path / "solved.png"
    status, text = said(capsys, f"{SOLVE} all_touch_force=1.5 -o {copy} --picture {picture}")
    assert status == 0
    assert text.startswith("yamada-2002: skin.curvature_radius ")
    assert "gives all_touch_force 1.5 N." in text
    assert text.splitlines()[-1] == f"Next: `skincad check {copy}` judges it by more accurate models."
    assert picture.read_bytes().startswith(b"\x89PNG")
    written = copy.read_text()
    assert "# solved for all_touch_force 1.5 N" in written
    assert "# Fig" in written or "# paper" in written  # the template's own comments stay
    solved = skincad.load_design(copy)
    assert skincad.check(solved, model="winkler").all_touch_force.value == pytest.approx(1.5, rel=5e-3)
    shipped = skincad.load_design("yamada-2002")
    assert solved.with_(skin=dict(shipped.skin)) == shipped
    with pytest.raises(InputError, match="exists already"):
        run(f"{SOLVE} approach=1 -o {copy}".split())


def test_solve_without_a_solution_is_status_1(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    copy = tmp_path / "solved.toml"
    status, text = said(capsys, f"{SOLVE} all_touch_force=0.1 -o {copy}")
    assert (status, "gives all_touch_force 0.1 N. The nearest is" in text) == (1, True)
    assert not copy.exists()
    status, text = said(capsys, f"{SOLVE} all_touch_force=1.5 --json")
    data = json.loads(text)
    assert (status, data["feasible"], data["file"]) == (0, True, None)


def test_a_scenes_skin_is_written_with_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A scene's own keys, and those of its skin, which then stands in it."""
    scene = skincad.load_scene("yamada-2002-press")
    for values in ({"effects.friction.coefficient": 0.3}, {"skin.ridge.height": 0.45}):
        one = SolutionPoint(values=values, reached={}, interval={}, nearest={}, passed=None)
        rest = {"closest": None, "evaluations": tuple[Evaluation](), "notes": (), "seconds": 0.0}
        wanted = {"target": {"steps": 1.0}, "knobs": (), "solutions": (one,), **rest}
        solution = Solution(subject=scene, question=Query("simulate"), **wanted)
        path = tmp_path / f"{next(iter(values))}.toml"
        write_solution(solution, path, "yamada-2002-press")
        assert skincad.load_scene(path).design == solution.solved.design
        assert skincad.load_scene(path).effects == solution.solved.effects


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (f"--target all_touch_force {RADIUS}", "target: must be KEY=VALUE"),
        (f"--target all_touch_force=a {RADIUS}", "must be a number"),
        (f"--target all_touch_force=nan {RADIUS}", "must be finite"),
        (f"--target all_touch_force<=a {RADIUS}", "must be a number"),
        (f"--target approach<=1 --target approach>=0.5 {RADIUS}", "target: names approach twice"),
        ("--target approach=1 --vary skin.length", "vary: must be KEY=LOW:HIGH"),
        ("--target approach=1 --vary skin.lenth=8:12", "did you mean 'length'"),
        ("--target approach=1 --vary material.name=all --picture x.png", "one key with a range"),
    ],
)
def test_bad_words_of_solve_are_one_line(arguments: str, says: str) -> None:
    with pytest.raises(InputError) as refused:
        run(f"solve yamada-2002 {arguments}".split())
    assert says in str(refused.value).replace("--", "")
    assert "\n" not in str(refused.value)
