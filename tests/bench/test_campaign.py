"""The campaign sees what it looks for: exceptions, crashes, thirst for memory, endless loops, bad figures."""

from __future__ import annotations

import faulthandler
import os
import signal
import time
import tomllib
from pathlib import Path
from typing import Any

import pytest

from bench.campaign import __main__ as campaign_module
from bench.campaign import cases, child
from bench.campaign.__main__ import Campaign
from bench.campaign.cases import Case
from bench.campaign.child import alone, judged
from bench.campaign.invariants import faults
from skincad.base import InputError, RefusedError
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
    monkeypatch.setattr(child, "SECONDS", 1)
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
