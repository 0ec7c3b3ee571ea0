"""How tests run: evidence by subject and turn, groups that share set-up, processes that end."""

from __future__ import annotations

import signal
import subprocess
import sys
import tomllib
from collections import Counter
from types import SimpleNamespace
from typing import Any

import pytest

from tests import tiers
from tests.processes import lines_until, started
from tests.tiers import EVIDENCE, LEDGER, SECONDS, TURNS, group_of, subject_of, tier_of, turns

MOST_OF_A_TURN = 0.15  # of all seconds: a tenth, and half of that for subjects that can't be split


def test_each_stretch_of_a_run_has_a_loop_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first 30 core-seconds on a core half as fast as the limits' machine, the next 10 on one as fast."""
    config, clock = SimpleNamespace(stash=pytest.Stash()), SimpleNamespace(now=30.0, loop=2 * tiers.LOOP)
    monkeypatch.setattr(tiers, "core_seconds", lambda: clock.now)
    monkeypatch.setattr(tiers, "loop_seconds", lambda: clock.loop)
    assert tiers.spent(config) == pytest.approx(15.0)  # type: ignore[arg-type]
    clock.now, clock.loop = 31.0, tiers.LOOP
    assert tiers.spent(config, between=2.0) == pytest.approx(15.0)  # type: ignore[arg-type]
    clock.now = 40.0
    assert tiers.spent(config, between=2.0) == pytest.approx(25.0)  # type: ignore[arg-type]


def test_every_evidence_test_has_a_subject(request: pytest.FixtureRequest) -> None:
    assert [name for name, subject in request.config.stash[EVIDENCE].items() if not subject] == []


@pytest.mark.skipif(not LEDGER.exists(), reason="no turn was run yet")
def test_each_subject_has_one_turn(request: pytest.FixtureRequest) -> None:
    """A subject that no turn holds is new: each turn takes it."""
    rows = tomllib.loads(LEDGER.read_text("utf-8"))["turn"]
    assert sorted(row["number"] for row in rows) == [*range(1, TURNS + 1)]
    times = Counter(subject for row in rows for subject in row["subjects"])
    assert {subject for subject, count in times.items() if count > 1} == set()
    items = Counter(request.config.stash[EVIDENCE].values())
    numbers = turns()
    new = sum(count for subject, count in items.items() if subject not in numbers)
    of_turns = Counter[int]()
    for subject, count in items.items():
        if subject in numbers:
            of_turns[numbers[subject]] += count
    assert of_turns.total() + new == items.total()
    assert set(of_turns) <= set(range(1, TURNS + 1))


@pytest.mark.skipif(not LEDGER.exists(), reason="no turn was run yet")
def test_no_turn_is_much_dearer_than_the_others() -> None:
    spent = tomllib.loads(SECONDS.read_text("utf-8"))["evidence"]
    sums = Counter[int]()
    for subject, number in turns().items():
        sums[number] += spent.get(subject, 0.0)
    if min(sums.values()) == 0:
        pytest.skip("not all turns were measured yet: python -m bench.seconds")
    assert {number: s for number, s in sums.items() if s > MOST_OF_A_TURN * sum(spent.values())} == {}


def test_the_table_of_seconds_names_files_that_are_there() -> None:
    groups = tomllib.loads(SECONDS.read_text("utf-8"))
    files = {name.partition(": ")[0] for tier in ("fast", "slow") for name in groups[tier]}
    assert [name for name in files if name.endswith(".py") and not (SECONDS.parent / name).is_file()] == []


def item(node: str, *marks: pytest.MarkDecorator, **parameters: Any) -> Any:
    """Stand in for a collected test: its id, marks (those of the function last) and parameters."""
    kept = [decorator.mark for decorator in marks]
    named = lambda name: [mark for mark in kept if mark.name == name]  # noqa: E731
    more = {"callspec": SimpleNamespace(params=parameters)} if parameters else {}
    return SimpleNamespace(
        nodeid=f"tests/{node}",
        own_markers=kept,
        iter_markers=named,
        get_closest_marker=lambda name: next(iter(named(name)), None),
        **more,
    )


EVIDENT = pytest.mark.evidence(subject="{name}")
SLOW = pytest.mark.slow


def test_tests_that_share_set_up_are_one_group() -> None:
    readers = {("a/test_a.py", "design"): 3, ("a/test_a.py", "model"): 1}
    cases = {
        "a/test_a.py": [item("a/test_a.py::test_x"), item("a/test_a.py::test_y[2]", number=2)],
        "a/test_a.py: pins": [  # the parameter that more tests of the file take
            item("a/test_a.py::test_x[pins-linear]", SLOW, model="linear", design="pins"),
            item("a/test_a.py::test_y[pins]", SLOW, design=SimpleNamespace(name="pins")),
        ],
        "pins": [
            item("a/test_a.py::test_z[pins]", EVIDENT, name="pins"),
            item("b/test_b.py::test_z[pins]", SLOW, pytest.mark.evidence(subject="pins"), design="pins"),
        ],
        "a/test_a.py: <object object>": [item("a/test_a.py::test_x[0]", SLOW, design=object())],
        "by hand": [item("a/test_a.py::test_x", pytest.mark.xdist_group("by@ hand]"))],
    }
    for group, items in cases.items():
        assert {group_of(test, readers) for test in items} == {group}
    assert group_of(item("b/test_b.py::test_x", SLOW), readers) == "b/test_b.py"


def test_evidence_is_told_from_slow_and_fast() -> None:
    assert tier_of(item("test_a.py::test_x")) == "fast"
    assert tier_of(item("test_a.py::test_x", SLOW)) == "slow"
    assert tier_of(item("test_a.py::test_x", SLOW, EVIDENT)) == "evidence"
    assert subject_of(item("test_a.py::test_x[a]", EVIDENT, name=SimpleNamespace(__name__="a"))) == "a"
    # pytest gives a parameter's mark after the function's
    assert subject_of(item("test_a.py::test_x", pytest.mark.evidence(), EVIDENT, name=7)) == "7"
    assert subject_of(item("test_a.py::test_x", pytest.mark.evidence())) == ""


@pytest.mark.slow
def test_tests_of_a_group_run_on_one_worker(request: pytest.FixtureRequest) -> None:
    """pytest-xdist sorts by a node id that it wrote the group to; pytest 9.2 let it write and forgot."""
    if not request.config.getoption("loadgroup", default=False):
        pytest.skip("only --dist loadgroup has groups")
    assert request.node.nodeid.endswith("@test_tiers.py")


def test_a_started_process_hears_ctrl_c_where_tests_run_in_the_background() -> None:
    """As `skincad live` in a script's background, which would wait for ever."""
    code = "import time; print('ready', flush=True); time.sleep(100)"
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with started([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=-3, text=True) as process:
            assert lines_until("ready\n", process.stdout) == []
            process.send_signal(signal.SIGINT)
            assert process.wait(timeout=60) == -signal.SIGINT
    finally:
        signal.signal(signal.SIGINT, before)


def test_what_does_not_end_is_ended() -> None:
    code = "import subprocess, sys; subprocess.run([sys.executable, '-c', 'import time; time.sleep(100)'])"
    with started([sys.executable, "-c", code], limit=0.5, stdout=subprocess.PIPE, text=True) as process:
        with pytest.raises(AssertionError, match="did not come"):  # its child has the pipe too
            lines_until("ready\n", process.stdout)
        assert process.wait(timeout=60) == -signal.SIGKILL
