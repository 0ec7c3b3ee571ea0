"""The day plan: every wait is kept, hands work by day, primer is used while it is good."""

from __future__ import annotations

import pytest

import skincad
from skincad.fabrication import Job, casting_sheet
from skincad.fabrication.day_plan import BEGIN, END, PRIMER_H, day_plan, tasks
from skincad.inputs import template_names
from tests.templates import SHIPPED


@pytest.mark.parametrize("name", SHIPPED)
def test_hands_work_by_day_after_what_has_to_cure(name: str) -> None:
    entries = day_plan(Job(skincad.load(name)))
    assert [entry.task for entry in entries] == tasks(Job(skincad.load(name)))
    ready = 0.0
    for entry in entries:
        begin = 24 * (entry.day - 1) + entry.hour
        assert BEGIN <= entry.hour <= END
        assert begin >= ready - 1e-9
        assert entry.hour + entry.task.hands / 60 <= END or entry.hour == BEGIN
        ready = begin + (entry.task.hands + entry.task.wait) / 60
    *_, opened, last = [e for e in entries if e.task.wait or e is entries[-1]]
    cured = 24 * (opened.day - 1) + opened.hour + (opened.task.hands + opened.task.wait) / 60
    assert 24 * (last.day - 1) + last.hour >= cured + 24 - 1e-9  # a day after the last cure


@pytest.mark.parametrize("name", [n for n in template_names() if skincad.load(n).film])
def test_primed_strips_are_used_while_their_primer_is_good(name: str) -> None:
    entries = day_plan(Job(skincad.load(name)))
    primed = next(i for i, e in enumerate(entries) if e.task.what == "make the strips ready")
    used = next(e for e in entries[primed:] if e.task.what.startswith(("draw the strips", "close the mold")))
    begin = entries[primed].hour + entries[primed].task.hands / 60
    end = 24 * (used.day - entries[primed].day) + used.hour + used.task.hands / 60
    assert end - begin <= PRIMER_H


def test_a_resin_is_washed_and_tried_before_all_else() -> None:
    what = [task.what for task in tasks(Job(skincad.load("lab-bench")))]
    assert what[:2] == ["wash, light and bake the printed parts", "cast the trial drop"]
    assert "wash" not in tasks(Job(skincad.load("yamada-2002")))[0].what
    text = casting_sheet(Job(skincad.load("lab-bench")), [], "", True)
    assert "| 1 | 9:00 | wash, light and bake the printed parts | 10 min | 5 h |" in text
