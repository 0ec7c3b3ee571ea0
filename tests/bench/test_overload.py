"""Scenes with forces up to a thousand times what the pad bears: refused, stopped with a reason, or right."""

from __future__ import annotations

import hypothesis
import pytest
from hypothesis import HealthCheck, Phase, given, settings

from bench.campaign.cases import Case, figures
from bench.campaign.invariants import sane
from bench.campaign.strategies import scenes
from skincad.base import InputError, RefusedError

OVERLOAD = 1000.0


def became(case: Case) -> str:
    """What became of a case, "" for one that is wrong."""
    try:
        numbers = figures(case)
    except InputError as refusal:
        return f"refused: {refusal.key}"
    except RefusedError as failure:
        return f"unsolved: {failure}"
    wrong = list(sane(case, numbers))
    assert not wrong, (wrong, case.toml())
    return f"stopped: {numbers['stopped']}" if numbers["failed"] else "right"


def run(count: int, seed: int) -> list[str]:
    """What became of `count` cases."""
    rows: list[str] = []

    @hypothesis.seed(seed)
    @settings(
        max_examples=count,
        database=None,
        deadline=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(scenes(overload=OVERLOAD))
    def one(case: Case) -> None:
        rows.append(became(case))

    one()
    return rows


KINDS = ("refused: history.normal_force_N", "stopped: step", "right")


@pytest.mark.slow
def test_overloaded_scenes_are_refused_or_right() -> None:
    """60 of them; of 300 with the seed 71 the same was seen.

    What a seed draws hangs on the constants of all loaded modules, so more are drawn until each kind is seen.
    """
    completed = run(60, seed=72)
    for seed in range(73, 77):
        if all(any(entry.startswith(kind) for entry in completed) for kind in KINDS):
            break
        completed += run(60, seed)
    for kind in KINDS:
        assert any(entry.startswith(kind) for entry in completed), completed
