"""Sixty random designs: every part sound, every failure told with the design that shows it.

All five hundred, or any others: `python -m bench.campaign.soundness [first [last]]`.
"""

from __future__ import annotations

from collections.abc import Callable

import pytest

from bench.campaign import soundness
from bench.campaign.random_designs import drawn
from bench.campaign.soundness import faults, outcome, summary
from skincad.fabrication import Job

SEEDS = 60
CHUNKS = 4  # shared out to the processes
SMALLEST = 4  # the seed of the first of them that takes half a second without the CAD kernel


@pytest.mark.slow
@pytest.mark.parametrize("chunk", range(CHUNKS))
def test_every_part_is_sound(chunk: int, record_property: Callable[[str, object], None]) -> None:
    size = SEEDS // CHUNKS
    rows = [outcome(seed) for seed in range(chunk * size, (chunk + 1) * size)]
    summary_text = summary(rows)
    record_property("summary", summary_text)
    print(summary_text)
    assert not any(entry.faults for entry in rows), summary_text


def test_one_of_them_without_the_cad_kernel() -> None:
    rows = [outcome(SMALLEST, kernel=False)]
    assert not any(entry.faults for entry in rows), summary(rows)


def test_a_gang_is_poured_with_its_own_thicker_seal() -> None:
    """The seal of one skin was taken for that of two: 22 mm3 of 6545."""
    assert list(faults(drawn(21).design, kernel=False)) == []


def test_a_seed_draws_the_same_design_again() -> None:
    assert drawn(7) == drawn(7)


def test_what_is_drawn_varies() -> None:
    designs = [drawn(seed).design for seed in range(30)]
    for seen in (
        {d.slot is None for d in designs},
        {d.film is None for d in designs},
        {d.mold.pour == "open" for d in designs},
        {d.mold.carrier == "plain" for d in designs},
    ):
        assert seen == {True, False}
    assert len({d.mold.process for d in designs}) == 4


def test_faults_and_exceptions_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """A wrong formula is seen by mesh and by the poured volume; what raises is a fault with its seed."""
    true = soundness.poured_volume
    monkeypatch.setattr(soundness, "poured_volume", lambda *given: 1.2 * true(*given))
    told = outcome(SMALLEST, kernel=False).faults
    assert any("casting sheet" in fault for fault in told)
    assert any("poured" in fault for fault in told)

    def broken(job: Job) -> float:
        raise ZeroDivisionError("on purpose")

    monkeypatch.setattr(soundness, "poured_volume", broken)
    text = summary([outcome(SMALLEST, kernel=False)])
    assert f"seed {SMALLEST}: ZeroDivisionError: on purpose" in text
    assert f'name = "random-{SMALLEST}"' in text
