"""The verdict in words: each way it can end, said once and right."""

from __future__ import annotations

from dataclasses import replace

import pytest

from skincad import Estimate, check, load
from skincad.mechanics.verdict import ContactCheck
from skincad.outputs.checks import lines, verdict


@pytest.fixture(scope="module")
def passed() -> ContactCheck:
    return check(load("plain-ridges"), force=5.0, model="linear", tol=0.05)


def test_each_ending_has_its_words(passed: ContactCheck) -> None:
    none = Estimate(None, None, "N")
    needs_more, unclear = Estimate(6.0, 0.5, "N"), Estimate(4.8, 0.5, "N")
    for change, words in (
        ({}, "Passes: all 9 ridges touch a flat plate at 5 N; they already do at 3.0 "),
        (
            {"ridges": 2, "touching": 2},
            "Passes: both ridges touch a flat plate at 5 N; they already do at 3.0 ",
        ),
        (
            {"touching": 7, "all_touch_force": needs_more},
            "FAILS: 7 of 9 ridges touch a flat plate at 5 N; all need 6.00 ± 0.50 N.",
        ),
        (
            {"all_touch_force": unclear},
            "UNDECIDED: 9 of 9 ridges touch a flat plate at 5 N, but the force they need is 4.80 ± 0.50 N.",
        ),
        (
            {"touching": 7, "all_touch_force": Estimate(5.2, 0.5, "N")},
            "UNDECIDED: 7 of 9 ridges touch a flat plate at 5 N. All need 5.20 ± 0.50 N, which may be less.",
        ),
        (
            {"touching": 5, "all_touch_force": none},
            "FAILS: 5 of 9 ridges touch a flat plate at 5 N; "
            "the force that all need is beyond the model's range.",
        ),
        ({"out_of_range": "too soft"}, "UNDECIDED: too soft."),
        ({"ridges": 1, "touching": 1}, "Passes: the one ridge touches a flat plate at any force."),
        ({"ridges": 1, "touching": 1, "out_of_range": "crushed"}, "UNDECIDED: crushed."),
    ):
        check = replace(passed, **change)
        assert verdict(check).startswith(words)
        assert verdict(check).upper().startswith(check.verdict.upper())
        assert check.passed == (check.verdict == "passes")
        assert check.as_json()["verdict"] == check.verdict


def test_an_undecided_check_says_what_may_decide_it(passed: ContactCheck) -> None:
    unclear = replace(passed, all_touch_force=Estimate(4.8, 0.5, "N"))
    assert lines(unclear)[1].startswith("Next: `--model corrected` (about ")
    last = replace(unclear, next_model=None, left_out=())
    expected = "Next: no model here can decide it. The design passes from 5.3 N and fails below 4.3 N."
    assert lines(last)[1] == expected
    assert unclear.as_json()["next_step"] == unclear.next_step
    friction = tuple(replace(part, effect="friction", threshold=0.1) for part in passed.left_out[:1])
    lasting = replace(unclear, all_touch_force=Estimate(4.9, 0.6, "N"), left_out=friction)
    assert lines(lasting)[1] == "Next: give contact.friction: its error alone leaves this open."
    for decided in (passed, replace(passed, all_touch_force=Estimate(6.0, 0.5, "N"))):
        assert decided.next_step == ""
        assert not any(line.startswith("Next") for line in lines(decided))


def test_the_lines_carry_errors_model_yield_and_notes(passed: ContactCheck) -> None:
    text = "\n".join(lines(passed))
    assert "±" in text
    assert "linear" in text
    assert "yield" in text
    assert f"margin         {passed.margin:.2f} N" in text
    assert "N for leaving out free ends" in text
    assert "more accurate  --model corrected, about " in text
    assert text.count("note") == len(passed.warnings)


def test_a_yield_is_told_only_with_its_error(passed: ContactCheck) -> None:
    part_yield = passed.manufacture
    assert part_yield is not None
    unknown = [Estimate(None, None, ""), Estimate(None, 0.1, ""), Estimate(0.9, None, "")]
    for other in (None, *(replace(part_yield, passing=passing) for passing in unknown)):
        assert not any("yield" in line for line in lines(replace(passed, manufacture=other)))


@pytest.mark.parametrize(
    ("share", "interval", "words"),
    [
        (0.9, (0.8049, 0.93), "90 % (80 to 93 %) of parts pass"),
        (0.992, (0.474, 1.0), "99 % (47 to 100 %) of parts pass"),
        (1.0, (0.99864, 1.0), "100.0 % (99.8 to 100 %) of parts pass"),
        (0.004, (0.0, 0.379), "0 % (0 to 38 %) of parts pass"),
        (0.4, (0.02, 0.97), "unknown (2 to 97 % are possible)"),
    ],
)
def test_a_yield_is_told_inside_0_to_100_percent(
    passed: ContactCheck, share: float, interval: tuple[float, float], words: str
) -> None:
    assert passed.manufacture is not None
    known = replace(passed.manufacture, passing=Estimate(share, 0.5, "1"), interval=interval)
    assert any(words in line for line in lines(replace(passed, manufacture=known)))


def test_forces_of_very_many_ridges_are_shown_as_a_range() -> None:
    design = load("plain-ridges", ["ridge.count=31", "skin.width=33", "skin.curvature_radius=1000"])
    verdict_of_many = check(design, model="winkler")
    values = [share.value or 0.0 for share in verdict_of_many.ridge_force]
    line = next(line for line in lines(verdict_of_many) if "ridge forces" in line)
    assert f"{min(values):.3f} to {max(values):.3f} (±" in line
