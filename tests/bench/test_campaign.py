"""Campaigns: random designs and scenes are sound, and failures are seen, shrunk and saved."""

from __future__ import annotations

import faulthandler
import os
import signal
import time
import tomllib
from pathlib import Path
from typing import Any

import hypothesis
import pytest
from hypothesis import HealthCheck, Phase, given, settings

from bench.campaign import __main__ as campaign_module
from bench.campaign import cases, soundness
from bench.campaign.__main__ import Campaign, alone, judged
from bench.campaign.cases import Case, figures
from bench.campaign.invariants import faults, sane
from bench.campaign.random_designs import drawn
from bench.campaign.soundness import outcome, summary
from bench.campaign.strategies import scenes
from skincad.base import InputError, RefusedError
from skincad.fabrication import Job
from skincad.inputs import read_table

CASE = Case("section", read_table("plain-ridges", "designs"))


def raising(failure: Exception) -> Any:
    def figures(case: Case) -> dict[str, Any]:
        raise failure

    return figures


def crash(case: Case) -> dict[str, Any]:
    faulthandler.disable()  # pytest's: it would tell of this
    os.kill(os.getpid(), signal.SIGABRT)
    return {}


def hog(case: Case) -> dict[str, Any]:
    return {"area": len(bytearray(2**40))}


def spin(case: Case) -> dict[str, Any]:
    while True:
        pass


@pytest.mark.parametrize(
    ("figures", "words"),
    [
        (crash, "the process ended by SIGABRT"),
        (hog, "MemoryError at"),
        (spin, "the process ended by SIGXCPU"),
        (raising(ZeroDivisionError("on purpose")), "ZeroDivisionError at"),
    ],
)
def test_a_process_that_fails_is_a_fault(figures: Any, words: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(cases.FIGURES, "section", figures)
    monkeypatch.setattr(campaign_module, "SECONDS", 1)
    ((kind, _),) = alone(CASE).faults
    assert words in kind


def test_refusals_are_none(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(cases.FIGURES, "section", raising(InputError("ridge.height", "is bad")))
    assert alone(CASE).refused == "ridge.height"
    monkeypatch.setitem(cases.FIGURES, "section", raising(RefusedError("does not settle")))
    assert judged(CASE).unsolved == "RefusedError: does not settle"


def test_a_sound_case_has_no_fault() -> None:
    answer = alone(CASE)
    assert (answer.refused, answer.unsolved, answer.faults) == ("", "", [])
    assert answer.peak > 0


WRONG: dict[str, tuple[str, str, dict[str, Any], dict[str, Any]]] = {
    "area closure": ("section", "plain-ridges", {}, {"area": 1.0}),
    "volume closure": ("solid", "plain-ridges", {}, {"mesh_volume": 1.0}),
    "mesh is open": ("solid", "plain-ridges", {}, {"watertight": False}),
    "balance": ("check", "plain-ridges", {"model": "winkler"}, {"force": 5.0}),
    "units": ("check", "plain-ridges", {"model": "winkler"}, {"approach": 0.2}),
    "mirror image": ("check", "plain-ridges", {"model": "winkler"}, {"ridge_force": [4.0] + [0.0] * 8}),
}


@pytest.mark.parametrize("kind", WRONG)
def test_a_wrong_figure_is_a_fault(kind: str) -> None:
    what, template, arguments, change = WRONG[kind]
    tables = read_table(template, "designs")
    tables["material"] = {"young_modulus": 0.8, "poisson_ratio": 0.499}
    case = Case(what, tables, arguments=arguments)
    numbers = cases.figures(case)
    assert not list(faults(case, numbers))
    if kind == "mirror image":
        change = {**change, "share_error": 1e-3}
    assert kind in {fault for fault, _ in faults(case, {**numbers, **change})}


@pytest.mark.slow
def test_a_failure_is_shrunk_and_saved(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A made-up fault of wide skins: what is saved is one, and the campaign goes on."""

    def narrow(case: Case) -> dict[str, Any]:
        if case.design.skin.width > 20.0:
            raise ZeroDivisionError("wide")
        raise InputError("skin.width", "is narrow")

    monkeypatch.setitem(cases.FIGURES, "section", narrow)
    # many cases, and none that ends its process
    monkeypatch.setattr(campaign_module, "alone", lambda case, **_: judged(case))
    monkeypatch.setattr(campaign_module.engine, "MAX_SHRINKING_SECONDS", 3)
    campaign = Campaign(tmp_path, time.monotonic() + 120.0)
    campaign.round("geometry", 0, seed=1)
    (kind,) = campaign.failed
    assert kind.startswith("ZeroDivisionError")
    saved = next(tmp_path.glob("shrunk-*.toml"))
    assert tomllib.loads(saved.read_text("utf-8"))["tables"]["skin"]["width"] > 20.0
    assert campaign.refused["section: width"] > 0


SMALLEST = 4  # the first seed that takes half a second without the CAD kernel


@pytest.mark.evidence(subject="seeds: sound parts")
@pytest.mark.parametrize("first", range(0, 60, 15))  # shared out to the processes
def test_every_part_is_sound(first: int) -> None:
    rows = [outcome(seed) for seed in range(first, first + 15)]
    assert not any(entry.faults for entry in rows), summary(rows)


def test_one_of_them_without_the_cad_kernel() -> None:
    rows = [outcome(SMALLEST, kernel=False)]
    assert not any(entry.faults for entry in rows), summary(rows)


@pytest.mark.slow
def test_a_gang_is_poured_with_its_own_thicker_seal() -> None:
    """The seal of one skin was taken for that of two: 22 mm3 of 6545."""
    assert list(soundness.faults(drawn(21).design, kernel=False)) == []


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


@pytest.mark.slow
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


KINDS = ("refused: history.normal_force_N", "stopped: step", "right")
DRAWN = settings(
    max_examples=60, database=None, deadline=None, phases=[Phase.generate],
    suppress_health_check=list(HealthCheck),
)  # fmt: skip


def became(case: Case) -> str:
    try:
        numbers = figures(case)
    except InputError as refusal:
        return f"refused: {refusal.key}"
    except RefusedError as failure:
        return f"unsolved: {failure}"
    wrong = list(sane(case, numbers))
    assert not wrong, (wrong, case.toml())
    return f"stopped: {numbers['stopped']}" if numbers["failed"] else "right"


@pytest.mark.evidence(subject="seeds: overloaded scenes")
def test_overloaded_scenes_are_refused_or_right() -> None:
    """60 of them; of 300 with the seed 71 the same was seen.

    What a seed draws hangs on the constants of all loaded modules, so more are drawn until each kind is seen.
    """
    rows: list[str] = []
    for seed in range(72, 77):
        hypothesis.seed(seed)(DRAWN(given(scenes(overload=1000.0))(lambda case: rows.append(became(case)))))()
        if all(any(row.startswith(kind) for row in rows) for kind in KINDS):
            return
    pytest.fail(f"not all of {KINDS} in {rows}")
