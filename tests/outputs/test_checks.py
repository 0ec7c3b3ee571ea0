"""The verdict in words: each way it can end, said once and right."""

from __future__ import annotations

from dataclasses import replace

import pytest

from skincad import Estimate, check, load
from skincad.mechanics.verdict import ContactCheck
from skincad.outputs.checks import lines, verdict


@pytest.fixture(scope="module")
def passed() -> ContactCheck:
    return check(load("plain-ridges"), tier="linear", tol=0.05)


def test_each_ending_has_its_words(passed: ContactCheck) -> None:
    none = Estimate(None, None, "N")
    for change, words in (
        ({"passed": True}, "Passes: all 9 ridges touch a flat plate at 4 N; they already do at 3.0 "),
        (
            {"passed": True, "ridges": 2},
            "Passes: both ridges touch a flat plate at 4 N; they already do at 3.0 ",
        ),
        (
            {"passed": False, "touching": 7},
            "FAILS: 7 of 9 ridges touch a flat plate at 4 N; all need 3.0 ",
        ),
        ({"passed": False}, "FAILS narrowly: all 9 ridges touch a flat plate at 4 N, but they need 3.0 "),
        (
            {"passed": False, "touching": 5, "all_touch_force": none},
            "FAILS: 5 of 9 ridges touch a flat plate at 4 N; "
            "the force that all need is beyond the model's range.",
        ),
        ({"passed": False, "beyond": "too soft"}, "NO VERDICT: too soft."),
        (
            {"ridges": 1, "passed": True},
            "Passes: the one ridge touches a flat plate at any force.",
        ),
        ({"ridges": 1, "passed": False, "beyond": "crushed"}, "NO VERDICT: crushed."),
    ):
        assert verdict(replace(passed, **change)).startswith(words)


def test_the_lines_carry_errors_model_yield_and_notes(passed: ContactCheck) -> None:
    text = "\n".join(lines(passed))
    assert "±" in text
    assert "linear" in text
    assert "yield" in text
    assert f"margin         {passed.margin:.2f} N" in text
    assert "N for leaving out free ends" in text
    assert "finer          --tier corrected would take about" in text
    assert text.count("note") == len(passed.warnings)


def test_a_yield_is_told_only_with_its_error(passed: ContactCheck) -> None:
    made = passed.manufacture
    assert made is not None
    unknown = [Estimate(None, None, ""), Estimate(None, 0.1, ""), Estimate(0.9, None, "")]
    for other in (None, *(replace(made, passing=each) for each in unknown)):
        assert not any("yield" in line for line in lines(replace(passed, manufacture=other)))
    known = replace(made, passing=Estimate(0.9, 0.1, ""))
    assert any("90.0% (± 10.0%) of parts pass" in line for line in lines(replace(passed, manufacture=known)))
