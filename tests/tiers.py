"""Which tests run in which tier, in which order, on which worker, and what they take in core-seconds.

*Fast* tests have no mark. *Slow* tests see what any commit can break. *Evidence* compares with other
programs, judges over many seeds, goes through every template: it runs by turns (`python -m bench.evidence`).
An evidence test names its subject: `@pytest.mark.evidence(subject="{name}")` is its parameter `name`.
"""

from __future__ import annotations

import json
import os
import re
import time
import tomllib
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest

TESTS = Path(__file__).parent
SECONDS, LEDGER = TESTS / "seconds.toml", TESTS.parent / "docs" / "evidence" / "ledger.toml"
MEASURED = TESTS.parent / "out" / "core-seconds"  # of the last runs: `bench.seconds` makes SECONDS of them
TIERS = {
    "fast": 2.0,
    "slow": 10.0,
    "evidence": float("inf"),
}  # core-seconds of a test that isn't marked `dear`
SLACK = 1.5  # a test's core-seconds differ by as much from run to run
TURNS = 10
LOOP = 0.010  # s, of `loop_seconds` while both cores of the machine are busy for which the limits were set
BETWEEN_LOOPS = 2.0  # core-seconds between two loops

STARTED, PROCESSES = pytest.StashKey[float](), pytest.StashKey[list[float]]()
LOOPED, SPENT = pytest.StashKey[float](), pytest.StashKey[float]()
LINES, EVIDENCE = pytest.StashKey[list[str]](), pytest.StashKey[dict[str, str]]()


def tier_of(item: pytest.Item) -> str:
    """Return "fast", "slow" or "evidence"."""
    return next((name for name in ("evidence", "slow") if item.get_closest_marker(name)), "fast")


def subject_of(item: pytest.Item) -> str:
    """Return what an evidence test is about, "" if it names nothing. Tests of one subject run together."""
    nearest = [mark for mark in item.own_markers if mark.name == "evidence"]  # of a parameter: the last
    mark = nearest[-1] if nearest else next(item.iter_markers("evidence"))
    return str(mark.kwargs.get("subject", "")).format(
        **{name: _word(value) for name, value in _parameters(item).items()}
    )


def _parameters(item: pytest.Item) -> Mapping[str, Any]:
    return item.callspec.params if hasattr(item, "callspec") else {}


def _word(value: object) -> str:
    text = str(getattr(value, "name", None) or getattr(value, "__name__", None) or value)
    return re.sub(r" at 0x[0-9a-f]+", "", text)  # an address differs from worker to worker


def _file(item: pytest.Item) -> str:
    return item.nodeid.removeprefix("tests/").partition("::")[0]


def turns() -> dict[str, int]:
    """Return the turn of each subject in the ledger."""
    rows = tomllib.loads(LEDGER.read_text("utf-8"))["turn"] if LEDGER.exists() else []
    return {subject: row["number"] for row in rows for subject in row["subjects"]}


def group_of(item: pytest.Item, readers: Mapping[tuple[str, str], int]) -> str:
    """Return the group of tests that share set-up, and so a worker.

    Of evidence it is the subject, of fast tests the file. Of slow tests it is the value of the parameter that
    most tests of the file take: `readers` counts the tests by file and parameter.
    """
    file, parameters = _file(item), _parameters(item)
    if mark := item.get_closest_marker("xdist_group"):
        name = str(mark.args[0])
    elif tier_of(item) == "evidence":
        name = subject_of(item)
    elif tier_of(item) == "fast" or not parameters:
        name = file
    else:
        shared = max(parameters, key=lambda parameter: readers[file, parameter])
        name = f"{file}: {_word(parameters[shared])[:60]}"
    return re.sub(r"[\]@]", "", name)  # pytest-xdist takes a name with these for no group


def pytest_addoption(parser: pytest.Parser) -> None:
    """Options: which evidence, and whether core-seconds have limits."""
    parser.addoption("--turn", help="of evidence only these turns, as 3 or 3,4, and what none holds")
    parser.addoption("--subject", action="append", default=[], help="with a turn: this subject too")
    parser.addoption("--core-seconds", type=float, help="fail if the run takes more")


@pytest.hookimpl(tryfirst=True)  # before pytest-xdist reads the groups
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave out evidence of other turns. Group tests: quick fast files, then the dearest groups."""
    config.stash[EVIDENCE] = {item.nodeid: subject_of(item) for item in items if tier_of(item) == "evidence"}
    if config.option.turn:
        asked, known = config.option.turn.split(","), turns()
        later = {
            item
            for item in items
            if (subject := config.stash[EVIDENCE].get(item.nodeid)) is not None
            if str(known.get(subject, asked[0])) not in asked and subject not in config.option.subject
        }
        config.hook.pytest_deselected(items=list(later))
        items[:] = [item for item in items if item not in later]
    takers = {
        (item.nodeid.partition("[")[0], _file(item), name) for item in items for name in _parameters(item)
    }
    readers = Counter((file, parameter) for _, file, parameter in takers)
    seconds = tomllib.loads(SECONDS.read_text("utf-8"))
    order: dict[pytest.Item, tuple[bool, bool, float, str]] = {}
    for item in items:
        tier, group = tier_of(item), group_of(item, readers)
        item.add_marker(pytest.mark.xdist_group(group))
        expected = seconds.get(tier, {}).get(group, 0.0)
        order[item] = (tier != "fast", tier == "fast" and expected > 0, -expected, group)
    items.sort(key=order.__getitem__)


def core_seconds() -> float:
    """Return what this process and its children took so far, in seconds of one core as it is now."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


def loop_seconds() -> float:
    """Return what a loop takes that takes `LOOP` on the machine for which the limits hold."""
    began = time.process_time()
    sum(i * i for i in range(100_000))
    return time.process_time() - began


def spent(config: pytest.Config, *, between: float = 0.0) -> float:
    """Return this process's core-seconds as that machine would take them, brought up to date after `between`.

    A core is up to twice as slow while its other thread is busy, or another guest of its host. So each
    stretch of a run has a loop of its own.
    """
    now, looped, sum_so_far = core_seconds(), config.stash.get(LOOPED, 0.0), config.stash.get(SPENT, 0.0)
    if now - looped <= between:
        return sum_so_far
    config.stash[SPENT] = sum_so_far + (now - looped) * LOOP / loop_seconds()
    config.stash[LOOPED] = core_seconds()
    return config.stash[SPENT]


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[object]:
    """Measure a test with its set-up."""
    item.stash[STARTED] = core_seconds()
    return (yield)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Iterator[Any]:
    """Report what a test took, in which tier, and whether it may."""
    report = yield
    if report.when == "teardown":
        took = core_seconds() - item.stash[STARTED]
        report.user_properties.append(("spent", (tier_of(item), took, bool(item.get_closest_marker("dear")))))
        spent(item.config, between=BETWEEN_LOOPS)
    return report


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node: Any) -> None:
    """Note what a worker's process took."""
    node.config.stash.setdefault(PROCESSES, []).append(
        getattr(node, "workeroutput", {}).get("core_seconds", 0.0)
    )


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Say what a worker's process took, its imports too; of the whole run write what each test took.

    Tests that take more than their tier allows are named. With `--core-seconds` a run that takes more fails.
    """
    config = session.config
    if hasattr(config, "workeroutput"):
        config.workeroutput["core_seconds"] = spent(config)
        return
    reports = config.pluginmanager.get_plugin("terminalreporter").getreports("")
    properties = [(report.nodeid, *pair) for report in reports for pair in report.user_properties]
    rows = [(name, *value) for name, key, value in properties if key == "spent"]
    lines = []
    for tier, limit in TIERS.items():
        tests = {name: round(took, 2) for name, of, took, _ in rows if of == tier}
        if tests:
            lines.append(f"{tier}: {len(tests)} tests, {sum(tests.values()):.0f} core-seconds")
            MEASURED.mkdir(parents=True, exist_ok=True)
            path = MEASURED / f"{tier}.json"
            if path.exists():  # of a run of a few tests the others stay
                tests = json.loads(path.read_text("utf-8")) | tests
            path.write_text(json.dumps(tests, indent=0), encoding="utf-8")
        lines += [
            f"{name}: {took:.1f} core-seconds, {limit:g} are allowed (mark it `dear` with the reason)"
            for name, of, took, dear in rows
            if of == tier and took > SLACK * limit and not dear
        ]
    workers, most = config.stash.get(PROCESSES, []), config.option.core_seconds
    whole = sum(workers) + time.process_time() if workers else spent(config)
    lines.append(f"all processes: {whole:.0f} core-seconds")
    if most is not None and whole > most:
        lines.append(f"all processes: {whole:.0f} core-seconds, {most:g} are allowed")
        session.exitstatus = session.exitstatus or 1
    config.stash[LINES] = lines


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    """Print core-seconds."""
    for line in config.stash.get(LINES, []):
        terminalreporter.write_line(line)
