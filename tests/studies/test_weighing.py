"""Losses and broken limits of results, and what a judge's word changes of them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from skincad.base import Estimate, InputError
from skincad.studies import Member, Study
from skincad.studies.study import RobustObjective

HERE = np.array([0.5])
CHEAP = {"all_touch_force_N": Estimate(2.0, 0.5, "N"), "margin_N": Estimate(1.0, None, "N")}
JUDGED = {"all_touch_force_N": Estimate(1.5, 0.25, "N"), "margin_N": Estimate(2.25, None, "N")}


def weighing(**changes: Any) -> RobustObjective:
    plain = {
        "name": "try",
        "about": "lab-bench",
        "vary": {"skin.thickness": "6:10"},
        "objectives": [{"key": "all_touch_force"}],
        "constraints": [{"key": "margin", "at_least": 2.0}],
    }
    return RobustObjective(Study(**{**plain, **changes}))


def member(values: Mapping[str, float], loss: float, kept: bool = True) -> Member:
    limit = {"margin_N": (Estimate(2.5, None, "N"), kept)}
    return Member(
        values=values,
        objectives={"all_touch_force_N": Estimate(loss, 0.0, "N")},
        constraints=limit,
        model="linear",
    )


def test_the_worse_end_counts_and_limits_are_parts_of_their_bounds() -> None:
    answer = weighing().told(HERE, CHEAP, "search")
    assert answer.losses.tolist() == [2.5]
    assert answer.limits.tolist() == [0.5]  # 1 of 2 N
    most = weighing(objectives=[{"key": "all_touch_force", "goal": "max"}])
    assert most.told(HERE, CHEAP, "search").losses.tolist() == [-1.5]
    assert weighing(robust=False).told(HERE, CHEAP, "search").losses.tolist() == [2.0]


def test_a_judge_moves_a_models_numbers_by_a_factor_and_a_margin_by_a_difference() -> None:
    one = weighing()
    one.correct(one.member({}, JUDGED, "corrected"), CHEAP, "search")
    answer = one.told(HERE, CHEAP, "search")
    assert answer.losses == pytest.approx([1.75], rel=1e-12)  # the judge's upper end
    assert answer.limits == pytest.approx([-0.125], rel=1e-12)
    twice = {"all_touch_force_N": Estimate(4.0, 9.0, "N"), "margin_N": Estimate(0.0, None, "N")}
    again = one.told(HERE, twice, "search")
    assert again.losses == pytest.approx([3.5], rel=1e-12)
    assert again.limits == pytest.approx([(2.0 - 1.25) / 2.0], rel=1e-12)
    assert one.told(HERE, CHEAP, "guide").losses.tolist() == [2.5]  # of another model nothing is known


def test_what_judge_and_model_say_alike_keeps_its_own_error() -> None:
    one = weighing()
    one.correct(one.member({}, CHEAP, "linear"), CHEAP, "search")
    assert not one.differs


def test_what_is_refused_or_not_told_has_no_loss() -> None:
    assert not weighing().told(HERE, None, "search").there
    assert not weighing().told(HERE, {**CHEAP, "margin_N": Estimate(None, None, "N")}, "search").there
    beside = weighing(constraints=[{"key": "make.passed", "at_least": 1}])
    assert beside.others() == ["make"]
    assert not beside.told(HERE, CHEAP, "search").there
    assert beside.told(HERE, CHEAP, "guide").limits.tolist() == [-1.0]  # the closed form can't tell: kept
    with pytest.raises(InputError, match="did you mean 'margin'"):
        weighing(constraints=[{"key": "margn", "at_least": 2.0}]).told(HERE, CHEAP, "search")


def test_a_member_tells_which_limits_it_keeps() -> None:
    both = weighing(constraints=[{"key": "margin", "at_least": 2.0, "at_most": 2.2}])
    answer = both.member({"skin.thickness": 7.0}, JUDGED, "corrected")
    assert answer.constraints == {"margin_N": (JUDGED["margin_N"], False)}
    assert answer.objectives == {"all_touch_force_N": JUDGED["all_touch_force_N"]}


def test_members_that_keep_their_limits_come_first_and_one_objective_has_one_best() -> None:
    broken, worse, best = (
        member({"a": 1.0}, 0.5, kept=False),
        member({"a": 2.0}, 3.0),
        member({"a": 3.0}, 2.0),
    )
    one = weighing()
    assert one.ordered([broken, worse, best]) == [best, worse, broken]
    assert one.pareto_front([best, worse]) == [best]


def test_of_several_objectives_all_that_nothing_beats_is_a_front() -> None:
    two = weighing(objectives=[{"key": "all_touch_force"}, {"key": "approach"}])

    def at(force: float, approach: float) -> Member:
        table = {"all_touch_force_N": Estimate(force, 0.0, "N"), "approach_mm": Estimate(approach, 0.0, "mm")}
        return Member(values={}, objectives=table, constraints={}, model="linear")

    first, second, beaten = at(1.0, 3.0), at(2.0, 1.0), at(2.0, 3.5)
    assert two.pareto_front([first, second, beaten]) == [first, second]
    middle = [
        at(1.0 + share, 3.0 - 2.0 * share) for share in (0.1, 0.4, 0.2)
    ]  # the first few cover the front
    assert two.pareto_front([first, *middle, second]) == [first, second, middle[1], middle[2], middle[0]]
