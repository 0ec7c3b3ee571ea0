"""What solving finds, by models whose evaluations take no time."""

from __future__ import annotations

from typing import Any

import pytest

import skincad
from skincad.base import InputError, RefusedError
from skincad.inputs import silicones
from skincad.studies import Solution, solve, value_of
from skincad.studies.solving import TOL

DESIGN = skincad.load_design("yamada-2002")
PLAIN = skincad.load_design("plain-ridges")
CIRCUIT = skincad.load_circuit("transimpedance")


def quick(target: dict[str, float], vary: dict[str, Any], **options: Any) -> Solution:
    return solve(DESIGN, target, vary, model="winkler", **options)


def test_a_value_gives_what_was_wanted_when_it_is_asked_anew() -> None:
    answer = quick({"all_touch_force": 1.5}, {"skin.curvature_radius": (20, 200)})
    (one,) = answer.solutions
    again = skincad.check(
        DESIGN.with_(skin={"curvature_radius": one.values["skin.curvature_radius"]}), model="winkler"
    )
    assert again.all_touch_force == one.reached["all_touch_force_N"]
    assert again.all_touch_force.value == pytest.approx(1.5, rel=TOL)
    assert answer.solved == DESIGN.with_(
        skin=dict(DESIGN.skin) | {"curvature_radius": one.values["skin.curvature_radius"]}
    )
    assert answer.feasible


def test_the_interval_is_where_the_error_leaves_it_open() -> None:
    answer = quick({"all_touch_force": 1.5}, {"skin.curvature_radius": (20, 200)})
    (one,) = answer.solutions
    low, high = one.interval["skin.curvature_radius"]
    assert 20 <= low < float(one.values["skin.curvature_radius"]) < high <= 200
    error = one.reached["all_touch_force_N"].error or 0.0
    ends = [
        skincad.check(DESIGN.with_(skin={"curvature_radius": end}), model="winkler").all_touch_force.value
        or 0.0
        for end in (low, high)
        if end not in (20, 200)
    ]
    assert ends
    for end in ends:  # by the cubics through a few evaluations
        assert abs(end - 1.5) == pytest.approx(error, rel=0.05)


def test_several_numbers_change_least() -> None:
    vary = {
        "skin.curvature_radius": (20, 200),
        "material.young_modulus": (0.1, 2.0),
        "skin.thickness": (2, 8),
    }
    answer = quick({"all_touch_force": 1.5}, vary)
    (one,) = answer.solutions
    assert one.reached["all_touch_force_N"].value == pytest.approx(1.5, rel=TOL)
    assert all(
        one.values[key] != start for key, start in (("skin.curvature_radius", 60), ("skin.thickness", 4))
    )
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


def test_a_number_is_solved_for_each_choice() -> None:
    vary = {"material.name": "dragon-skin-20,dragon-skin-30", "skin.curvature_radius": (20, 200)}
    answer = quick({"all_touch_force": 1.5}, vary)
    names = [one.values["material.name"] for one in answer.solutions]
    assert names == ["dragon-skin-30", "dragon-skin-20"]  # the design's own first: the least change
    for one in answer.solutions:
        assert one.reached["all_touch_force_N"].value == pytest.approx(1.5, rel=TOL)
    frame = answer.to_frame()
    assert list(frame["material.name"]) == names
    assert list(frame["skin.curvature_radius_mm"]) == [
        one.values["skin.curvature_radius"] for one in answer.solutions
    ]
    assert list(frame["all_touch_force_N.error"]) == [
        one.reached["all_touch_force_N"].error for one in answer.solutions
    ]


def test_out_of_reach_says_how_near_any_value_comes() -> None:
    answer = quick({"all_touch_force": 0.1}, {"skin.curvature_radius": (20, 200)})
    assert not answer.feasible
    assert answer.closest is not None
    assert answer.closest.values == {"skin.curvature_radius": 200.0}
    assert "no skin.curvature_radius from 20 to 200 mm gives all_touch_force 0.1 N. The nearest is" in str(
        answer
    )
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


@pytest.mark.slow  # three evaluations of three seconds
def test_a_key_that_the_closed_form_does_not_know_is_solved() -> None:
    """The closed form says the same for every crown: corrected needs 2.73 N at 0.01 mm, 2.44 N at 0.09 mm."""
    solution = solve(DESIGN, {"all_touch_force": 2.45}, {"ridge.crown": (0.01, 0.09)})
    assert solution.question.model == "corrected"
    assert solution.solutions[0].reached["all_touch_force_N"].value == pytest.approx(2.45, rel=TOL)


def test_a_resonance_between_wide_steps_is_found() -> None:
    """The gain at the sweep's end, as the film's resonance passes it: 3.7 dB, of 0.1 and 1.9 at the ends."""
    follower = skincad.load_circuit("voltage-follower")
    inductance = float(value_of(follower, "motional.inductance"))  # type: ignore[arg-type]
    vary = {"motional.inductance": (inductance / 10, inductance * 10)}
    assert solve(follower, {"gain_dB.last": 3.5}, vary).feasible


@pytest.mark.slow  # about seven evaluations of a second
def test_a_number_that_only_the_better_model_tells_is_solved_for() -> None:
    solution = solve(
        PLAIN, {"modulus_sensitivity": 3.0}, {"skin.curvature_radius": (40, 120)}, model="linear"
    )  # 3.8 N/MPa at its own 60 mm; the closed form's result has no such number
    assert solution.feasible


def test_a_number_that_no_model_tells_is_refused_with_the_nearest() -> None:
    with pytest.raises(InputError, match="did you mean 'modulus_sensitivity'"):
        solve(PLAIN, {"modulus_sensitivty": 3.0}, {"skin.curvature_radius": (40, 120)}, model="linear")


@pytest.mark.parametrize(
    ("force", "ends", "word"),
    [(0.02, (0.004, 0.1), "soft"), (2.2, (0.2, 1.6), ""), (30.0, (2.0, 50.0), "stiff")],
)
def test_a_modulus_names_a_silicone_and_says_if_none_is_like_it(
    force: float, ends: tuple[float, float], word: str
) -> None:
    answer = quick({"all_touch_force": force}, {"material.young_modulus": ends}, force=force)
    (one,) = answer.solutions
    assert one.nearest["material.name"] in silicones(None)
    assert one.nearest["material.name"] in str(answer)
    rows = [note for note in answer.notes if note.startswith("no silicone is as")]
    assert [word in note for note in rows] == ([True] if word else [])


def test_values_that_are_refused_everywhere_are_told_with_the_reason() -> None:
    answer = quick({"all_touch_force": 2.0}, {"skin.width": (1.0, 2.0)})
    assert not answer.feasible
    assert answer.closest is None
    assert "every value is refused" in str(answer)
    assert "skin.width" in str(answer)


def test_circuits_and_scenes_are_solved_too() -> None:
    solution = solve(CIRCUIT, {"cutoff": 800.0}, {"amplifier.feedback_resistance": (1e7, 1e9)})
    told = f"{solution}"
    assert solution.question.kind == "circuit"
    assert solution.feasible or "the result has no cutoff_Hz at any value" in told


def test_json_has_the_contracts_keys() -> None:
    data = quick({"all_touch_force": 1.5}, {"skin.curvature_radius": (20, 200)}).as_json()
    assert {"name", "target", "vary", "solutions", "evaluations", "feasible", "seconds"} <= data.keys()
    assert data["target"] == {"all_touch_force_N": 1.5}
    assert data["vary"] == {"skin.curvature_radius": [20, 200]}
    assert {"values", "reached", "nearest"} <= data["solutions"][0].keys()


@pytest.mark.parametrize(
    ("target", "vary", "options", "says"),
    [
        ({}, {"skin.length": (8, 12)}, {}, "names no number"),
        ({"all_touch_force": 1.0}, {}, {}, "names no key"),
        ({"all_touch_forc": 1.0}, {"skin.length": (8, 12)}, {}, "did you mean 'all_touch_force'"),
        ({"all_touch_force": float("nan")}, {"skin.length": (8, 12)}, {}, "must be finite"),
        (
            {"all_touch_force": 1.0, "approach": 1.0},
            {"skin.length": (8, 12)},
            {},
            "as many numbers as keys are varied",
        ),
        ({"all_touch_force": 1.0}, {"skin.length": (8, 12)}, {"tol": 0.0}, "between 0 and 1"),
        ({"all_touch_force": 1.0}, {"skin.length": (8, 12)}, {"evaluations": 0}, "at least 1"),
        ({"all_touch_force": 1.0}, {"ridge.count": (1, 999)}, {}, "combinations of choices"),
    ],
)
def test_what_can_not_be_asked_is_said(
    target: dict[str, float], vary: dict[str, Any], options: dict[str, Any], says: str
) -> None:
    with pytest.raises(InputError, match=says):
        quick(target, vary, **options)


def test_a_model_is_a_designs() -> None:
    with pytest.raises(InputError, match="is for a design"):
        solve(CIRCUIT, {"cutoff": 800.0}, {"amplifier.gain": (1e3, 1e5)}, model="linear")
