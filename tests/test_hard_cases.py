"""Every row of the catalogue of hard cases: the figure that it watches, and what holds for all of a kind."""

from __future__ import annotations

import pytest

from bench.campaign.cases import figures
from bench.campaign.invariants import sane
from skincad.base import InputError, RefusedError
from tests.hard_cases import Entry, entries, watched

ALL = tuple(entries())
MARKS = {"fast": [], "slow": [pytest.mark.slow]}
CASES = [
    pytest.param(entry, id=entry.name, marks=MARKS.get(entry.tier, [pytest.mark.evidence(subject=entry.row)]))
    for entry in ALL
]


@pytest.mark.parametrize("entry", CASES)
def test_hard_case(entry: Entry) -> None:
    if entry.refused:
        with pytest.raises((InputError, RefusedError)) as refusal:
            figures(entry.case())
        assert entry.refused in str(refusal.value)
        return
    case = entry.case()
    numbers = figures(case)
    assert not list(sane(case, numbers))
    assert not numbers.get("failed"), numbers["stopped"]
    if entry.rel or entry.abs:
        answer = watched(numbers, entry.watch)
        assert answer == pytest.approx(entry.expected(), rel=entry.rel or 1e-300, abs=entry.abs)
    else:
        assert watched(numbers, entry.watch) == entry.value


def test_every_row_says_what_is_hard_and_why_its_number_is_right() -> None:
    for entry in ALL:
        assert entry.hard
        assert entry.why
        assert bool(entry.refused) != bool(entry.watch), entry.name
        assert entry.tier in (*MARKS, "evidence"), entry.name
        assert entry.refused or entry.like or entry.value is not None, entry.name
    assert len({entry.name for entry in ALL}) == len(ALL)


def test_no_more_than_a_fifth_is_refused() -> None:
    assert sum(bool(entry.refused) for entry in ALL) <= len(ALL) / 5
