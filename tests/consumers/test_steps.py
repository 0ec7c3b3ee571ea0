"""STEP's names and colours, and the casting sheet's numbers from re-read solids."""

from __future__ import annotations

from tests.conftest import Made
from tests.consumers import Job, steps
from tests.consumers.test_dxf import skin_of


def test_names_colours_and_the_casting_sheet_agree_with_the_solids(job: Job) -> None:
    assert steps.complaints(job) == []


def test_a_sheet_with_a_wrong_number_is_seen(made: Made) -> None:
    job = Job(skin_of(made), made)
    text = job.file("casting-sheet.md").read_text("utf-8")
    written = steps.sheet_numbers(text)
    assert {"cavity", "cover", "carrier", "poured", "grams"} <= set(written)
    true = steps.from_solids(job)
    # the cup alone is a tenth of what is poured
    assert abs(float(written["poured"]) - true["skin"]) > 0.05 * true["skin"]
