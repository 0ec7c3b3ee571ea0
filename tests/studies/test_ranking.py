"""Which of two is better, and how surely: by hand."""

from __future__ import annotations

import math

import pytest

from skincad.base import Estimate, InputError
from skincad.studies import Evaluation, model_error
from skincad.studies.sweeping import OWN, difference_error, ranking, surely_less

KEY = "all_touch_force_N"


def row(
    value: float | None,
    error: float | None,
    error_of_model: float = 0.0,
    model: str = "linear",
    refused: str = "",
) -> Evaluation:
    table = {KEY: Estimate(value, error, "N"), "model_error_N": Estimate(error_of_model, None, "N")}
    return Evaluation(str(value), {}, table, None, refused, model)


def test_what_two_designs_share_of_a_models_error_is_no_error_of_their_difference() -> None:
    a, b = row(2.0, 0.53, 0.5), row(2.4, 0.64, 0.6)
    by_hand = math.hypot(0.03, 0.04) + 0.1 + OWN * math.hypot(0.5, 0.6)
    assert difference_error(a, b, KEY) == pytest.approx(by_hand)
    assert by_hand < math.hypot(0.53, 0.64)
    other = row(2.4, 0.64, 0.6, "corrected")
    assert difference_error(a, other, KEY) == pytest.approx(math.hypot(0.53, 0.64))


def test_an_unknown_error_makes_nothing_sure() -> None:
    assert difference_error(row(1.0, None), row(2.0, 0.1), KEY) is None
    assert not surely_less(row(1.0, None), row(2.0, 0.1), KEY)
    assert not surely_less(row(None, None), row(2.0, 0.1), KEY)


def test_surely_less_is_beyond_the_error_of_the_difference() -> None:
    assert surely_less(row(1.0, 0.1), row(1.2, 0.1), KEY)  # 0.2 against 0.141
    assert not surely_less(row(1.0, 0.1), row(1.1, 0.1), KEY)
    assert not surely_less(row(1.2, 0.1), row(1.0, 0.1), KEY)
    assert surely_less(row(1.2, 0.1), row(1.0, 0.1), KEY, -1.0)


def test_rows_are_ranked_with_what_they_beat_and_what_ties() -> None:
    rows = [
        row(3.0, 0.1),
        row(1.0, 0.1),
        row(1.05, 0.1),
        row(None, None),
        row(0.5, 0.1, refused="no"),
        row(2.0, 0.1),
    ]
    answer = ranking(rows, "all_touch_force", "min")
    assert answer.key == KEY
    assert [(rank.row, rank.wins) for rank in answer.ranks] == [(2, 2), (3, 2), (6, 1), (1, 0)]
    assert answer.ties == ((2, 3),)
    most = ranking(rows, KEY, "max")
    assert [(rank.row, rank.wins) for rank in most.ranks] == [(1, 3), (6, 2), (3, 0), (2, 0)]


def test_a_tie_is_with_the_best_of_its_group() -> None:
    """Each of a chain ties with the next, but not all with the first."""
    answer = ranking([row(1.0, 0.1), row(1.1, 0.1), row(1.2, 0.1), row(1.3, 0.1)], KEY, "min")
    assert answer.ties == ((1, 2), (3, 4))


def test_the_approach_has_its_models_part_too() -> None:
    table = {"approach_mm": Estimate(0.2, 0.05, "mm"), "left_out.friction.approach": Estimate(0.1, None, "")}
    table["left_out.finite strain.approach"] = Estimate(0.05, None, "")
    assert model_error(Evaluation("", {}, table), "approach_mm") == pytest.approx(0.03)
    assert (
        model_error(Evaluation("", {}, table | {"cutoff_Hz": Estimate(1.0, 0.1, "Hz")}), "cutoff_Hz") == 0.0
    )


def test_keys_and_goals_that_there_are_none_of() -> None:
    with pytest.raises(InputError, match="rank approach: no such number"):
        ranking([row(1.0, 0.1)], "approach", "min")
    with pytest.raises(InputError, match="KEY=min or KEY=max"):
        ranking([row(1.0, 0.1)], KEY, "least")  # type: ignore[arg-type]
    assert ranking([], KEY, "min").ranks == ()
