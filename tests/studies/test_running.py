"""Many evaluations: in one process, in several, by two runs at once, and after kills."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

import skincad
from skincad.base import ExhaustedError, InputError
from skincad.studies import Evaluation, Log, Query, running
from skincad.studies.running import NAME, Run, Values, Workers, workers
from tests.processes import LIMIT, started

DESIGN = skincad.load_design("yamada-2002")
QUESTION = Query("check", "winkler")
POINTS: list[Values] = [{"skin.length": float(length)} for length in np.linspace(8, 16, 12)]


def told(rows: Sequence[Evaluation]) -> list[tuple[str, float]]:
    return [(row.key, float(row.results["all_touch_force_N"])) for row in rows]


@pytest.fixture(scope="module")
def alone() -> list[tuple[str, float]]:
    return told(Run(DESIGN, QUESTION).at(POINTS, Workers()))


def test_rows_come_in_the_order_of_their_points(alone: list[tuple[str, float]]) -> None:
    back = told(Run(DESIGN, QUESTION).at(POINTS[::-1], Workers()))
    assert back == alone[::-1]
    assert [force for _, force in alone] == sorted(force for _, force in alone)  # longer: stiffer


def test_a_point_named_twice_is_asked_once() -> None:
    run = Run(DESIGN, QUESTION)
    rows = run.at([*POINTS[:2], POINTS[0]], Workers())
    assert (run.evaluated, run.reused) == (2, 1)
    assert rows[0].results == rows[2].results


@pytest.mark.slow
def test_two_processes_say_the_same(alone: list[tuple[str, float]]) -> None:
    done = []
    with workers(2) as who:
        rows = Run(DESIGN, QUESTION).at(POINTS, who, lambda _, count, of: done.append((count, of)))
    assert told(rows) == alone
    assert done == [(n, len(POINTS)) for n in range(1, len(POINTS) + 1)]


def test_a_log_is_gone_on_with(tmp_path: Path, alone: list[tuple[str, float]]) -> None:
    first = Run(DESIGN, QUESTION, Log(tmp_path))
    first.at(POINTS[:5], Workers())
    second = Run(DESIGN, QUESTION, Log(tmp_path))
    assert told(second.at(POINTS, Workers())) == alone
    assert (second.evaluated, second.reused) == (len(POINTS) - 5, 5)
    third = Run(DESIGN, Query("check", "winkler", force=3.0), Log(tmp_path))
    third.at(POINTS[:1], Workers())
    assert third.evaluated == 1  # another question


def test_an_interruption_keeps_what_is_done(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked, real = [], running.evaluate

    def interrupted(*arguments: object) -> Evaluation:
        if len(asked) == 4:
            raise KeyboardInterrupt
        asked.append(arguments)
        return real(*arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(running, "evaluate", interrupted)
    with pytest.raises(KeyboardInterrupt):
        Run(DESIGN, QUESTION, Log(tmp_path)).at(POINTS, Workers())
    monkeypatch.undo()
    again = Run(DESIGN, QUESTION, Log(tmp_path))
    again.at(POINTS, Workers())
    assert (again.reused, again.evaluated) == (4, len(POINTS) - 4)


def test_what_another_run_has_claimed_is_waited_for_not_repeated(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, alone: list[tuple[str, float]]
) -> None:
    """The other run's claim is refused here once; then its line is in the log."""
    other, ours = Run(DESIGN, QUESTION, Log(tmp_path)), Log(tmp_path)
    claim, theirs = ours.claim, alone[0][0]
    slept = []

    def sleep(_: float) -> None:
        slept.append(1)
        other.at(POINTS[:1], Workers())

    monkeypatch.setattr(ours, "claim", lambda key: key != theirs and claim(key))
    monkeypatch.setattr(running.time, "sleep", sleep)
    run = Run(DESIGN, QUESTION, ours)
    assert told(run.at(POINTS[:3], Workers())) == alone[:3]
    assert (run.evaluated, run.reused, slept) == (2, 1, [1])


def test_refused_designs_are_rows() -> None:
    rows = Run(DESIGN, QUESTION).at([{"skin.width": 2.0}, {"skin.width": 11.0}], Workers())
    assert "skin.width" in rows[0].refused
    assert not rows[1].refused


def dies(*_: object) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def test_a_dead_worker_is_want_of_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(running, "evaluate", dies)
    with pytest.raises(ExhaustedError, match="fewer workers"), workers(2) as who:
        Run(DESIGN, QUESTION).at(POINTS, who)


@pytest.mark.parametrize(
    ("count", "dask", "says"), [(0, None, "must be from 1"), (2, "tcp://x:1", "by the cluster")]
)
def test_what_can_not_be_used_is_said(count: int, dask: str | None, says: str) -> None:
    with pytest.raises(InputError, match=says), workers(count, dask):
        pass


def test_without_dask_the_remedy_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InputError, match=r"pip install 'skincad\[dask\]'"), workers(dask="tcp://localhost:1"):
        pass


def swept(folder: Path, points: Sequence[Values]) -> list[str]:
    lengths = "skin.length=" + ",".join(str(point["skin.length"]) for point in points)
    start = [sys.executable, "-m", "skincad", "sweep", "yamada-2002", "--tier", "winkler"]
    return [*start, "--vary", lengths, "-o", str(folder), "--json"]


@pytest.mark.slow
def test_fifteen_kills_lose_and_repeat_nothing(tmp_path: Path) -> None:
    """SIGKILL of two runs at once, each time as soon as their log has grown, and a torn tail in between."""
    many: list[Values] = [{"skin.length": float(length)} for length in np.linspace(8, 16, 1000)]
    log, kills, seen = tmp_path / NAME, 0, b""
    while kills < 15:
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        with started(swept(tmp_path, many), **quiet) as one, started(swept(tmp_path, many), **quiet) as two:
            deadline = time.monotonic() + LIMIT
            while not log.exists() or log.stat().st_size <= len(seen):
                assert time.monotonic() < deadline
                assert all(run.poll() is None for run in (one, two))
                time.sleep(1e-4)
            for run in (one, two):
                run.send_signal(signal.SIGKILL)
                run.wait(timeout=60)
                kills += 1
        now = log.read_bytes()
        assert now.startswith(seen[: seen.rfind(b"\n") + 1])  # what was finished stays
        if kills == 6:
            with log.open("ab") as file:
                file.write(b'{"key": "torn')
        seen = log.read_bytes()
    assert len(seen.splitlines()) < len(many)  # there was work left for every kill
    subprocess.run(swept(tmp_path, many), check=True, stdout=subprocess.DEVNULL, timeout=300)
    left = Log(tmp_path)
    left.read()
    unbroken = Run(DESIGN, QUESTION)
    unbroken.at(many, Workers())
    assert sorted(told([*left.evaluations.values()])) == sorted(told([*unbroken.evaluations.values()]))
    assert len(log.read_bytes().splitlines()) == len(many)  # none twice


@pytest.mark.slow
def test_two_runs_at_once_share_the_work(tmp_path: Path, alone: list[tuple[str, float]]) -> None:
    one, two = (started(swept(tmp_path, POINTS), stdout=subprocess.PIPE, text=True) for _ in range(2))
    with one as first, two as second:
        told_by = [json.loads(run.communicate(timeout=LIMIT)[0]) for run in (first, second)]
    assert sum(entry["evaluations"] for entry in told_by) == len(POINTS)
    for entry in told_by:
        forces = [row["results"]["all_touch_force_N"]["value"] for row in entry["rows"]]
        assert forces == [force for _, force in alone]


@pytest.mark.slow
def test_a_dask_cluster_of_two_gives_the_same_rows(alone: list[tuple[str, float]]) -> None:
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(2, threads_per_worker=1, dashboard_address=None) as cluster:
        with workers(dask=cluster.scheduler_address) as who:
            assert told(Run(DESIGN, QUESTION).at(POINTS, who)) == alone
        with distributed.Client(cluster) as client, workers(dask=client) as who:
            assert told(Run(DESIGN, QUESTION).at(POINTS, who)) == alone


@pytest.mark.slow
def test_a_cluster_that_does_not_answer_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(running, "PATIENCE", 1.0)
    with pytest.raises(InputError, match="no cluster answers"), workers(dask="tcp://127.0.0.1:9"):
        pass
