"""Many evaluations and their log: in one process, in several, by two runs at once, and after kills."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import skincad
from skincad.base import ExhaustedError, InputError
from skincad.studies import Evaluation, Log, Query, evaluate
from skincad.studies.running import Run, Workers, workers
from tests.processes import LIMIT, started

DESIGN = skincad.load_design("yamada-2002")
EVALUATION = evaluate(DESIGN, {"skin.length": 12.0}, Query("check", "winkler"))


def numbered(number: int) -> Evaluation:
    return replace(EVALUATION, key=f"{number:016x}{0:016x}")


def line(folder: Path, evaluation: Evaluation) -> bytes:
    """Return an evaluation's line, as a log of its own has it."""
    log = Log(folder / evaluation.key)
    log.append(evaluation)
    return log.path.read_bytes()


def test_what_was_appended_is_read_by_another_run(tmp_path: Path) -> None:
    refused = evaluate(DESIGN, {"skin.length": -1.0}, Query("check", "winkler"))
    assert refused.refused
    ours, theirs = Log(tmp_path / "new"), Log(tmp_path / "new")
    theirs.read()
    assert theirs.evaluations == {}
    appended = [numbered(0), EVALUATION, refused]
    for number, evaluation in enumerate(appended, 1):
        ours.append(evaluation)
        theirs.read()
        assert [*theirs.evaluations.values()] == [*ours.evaluations.values()] == appended[:number]


@pytest.mark.parametrize("first", [(), (0,)])
@pytest.mark.parametrize("tail", [1, 40, 700])
def test_a_torn_tail_is_cut_off_by_the_next_that_appends(tmp_path: Path, first: tuple, tail: int) -> None:
    log = Log(tmp_path)
    for number in first:
        log.append(numbered(number))
    whole = b"".join(line(tmp_path, numbered(number)) for number in first)
    with log.path.open("ab") as file:
        file.write(line(tmp_path, numbered(1))[:tail])
    after = Log(tmp_path)
    after.read()
    assert [*after.evaluations] == [numbered(number).key for number in first]
    after.append(numbered(2))
    assert after.torn
    assert log.path.read_bytes() == whole + line(tmp_path, numbered(2))


def test_a_torn_tail_is_passed_over_by_a_fresh_start(tmp_path: Path) -> None:
    log = Log(tmp_path)
    log.append(numbered(0))
    with log.path.open("ab") as file:
        file.write(line(tmp_path, numbered(1))[:40])
    fresh = Log(tmp_path)
    fresh.skip()
    fresh.append(numbered(2))
    fresh.read()
    assert [*fresh.evaluations] == [numbered(2).key]


def test_a_folder_that_cannot_be_made_is_bad_input(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="cannot be written"):
        Log(tmp_path / "file" / "log").claim(numbered(0).key)


@pytest.mark.parametrize("text", ["not json\n", "[1, 2]\n", '{"key": 1}\n', "null\n"])
def test_another_file_of_that_name_is_refused_and_stays(tmp_path: Path, text: str) -> None:
    (tmp_path / "evaluations.jsonl").write_text(text)
    with pytest.raises(InputError, match="no log of a study"):
        Log(tmp_path).read()
    assert (tmp_path / "evaluations.jsonl").read_text() == text


def test_another_versions_lines_are_not_used(tmp_path: Path) -> None:
    log = Log(tmp_path)
    log.append(replace(numbered(0), version="0.0.1"))
    log.append(numbered(1))
    again = Log(tmp_path)
    again.read()
    assert [*again.evaluations] == [numbered(1).key]
    assert again.other == 1


def test_a_full_disk_leaves_whole_lines(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    log = Log(tmp_path)
    log.append(numbered(0))
    before, write, calls = log.path.read_bytes(), os.write, []

    def full(handle: int, data: bytes) -> int:
        calls.append(data)
        if len(calls) > 1:
            raise OSError(28, "No space left on device")
        return write(handle, data[:100])

    monkeypatch.setattr("skincad.studies.running.os.write", full)
    with pytest.raises(InputError, match="No space left on device"):
        log.append(numbered(1))
    assert log.path.read_bytes() == before
    monkeypatch.undo()
    log.append(numbered(1))
    assert len(log.path.read_bytes().splitlines()) == 2


@pytest.mark.slow
def test_a_claim_is_one_processs_and_ends_with_it(tmp_path: Path) -> None:
    key = numbered(7).key
    code = (
        "import sys, time; from pathlib import Path; from skincad.studies.running import Log\n"
        f"log = Log(Path({str(tmp_path)!r})); print(log.claim({key!r}), flush=True); time.sleep(60)"
    )
    with started([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as other:
        assert other.stdout.readline() == "True\n"
        mine = Log(tmp_path)
        assert not mine.claim(key)
        assert mine.claim(numbered(8).key)
    assert mine.claim(key)
    mine.close()


QUESTION = Query("check", "winkler")
Point = dict[str, float | str]
POINTS: list[Point] = [{"skin.length": float(length)} for length in np.linspace(8, 16, 6)]


def told(rows: Sequence[Evaluation]) -> list[tuple[str, float]]:
    return [(row.key, float(row.results["all_touch_force_N"])) for row in rows]


@pytest.fixture(scope="module")
def alone() -> list[tuple[str, float]]:
    return told(Run(DESIGN, QUESTION).at(POINTS, Workers()))


def test_rows_come_in_the_order_of_their_points_each_asked_once(alone: list[tuple[str, float]]) -> None:
    back = told(Run(DESIGN, QUESTION).at(POINTS[::-1], Workers()))
    assert back == alone[::-1]
    assert [force for _, force in alone] == sorted(force for _, force in alone)  # longer: stiffer
    run = Run(DESIGN, QUESTION)
    rows = run.at([*POINTS[:2], POINTS[0]], Workers())
    assert (run.evaluated, run.reused) == (2, 1)
    assert rows[0].results == rows[2].results
    rows = Run(DESIGN, QUESTION).at([{"skin.width": 2.0}, {"skin.width": 11.0}], Workers())
    assert "skin.width" in rows[0].refused
    assert not rows[1].refused


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
    asked = []

    def interrupted(*arguments: object) -> Evaluation:
        if len(asked) == 4:
            raise KeyboardInterrupt
        asked.append(arguments)
        return evaluate(*arguments)

    monkeypatch.setattr("skincad.studies.running.evaluate", interrupted)
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
    monkeypatch.setattr("skincad.studies.running.time.sleep", sleep)
    run = Run(DESIGN, QUESTION, ours)
    assert told(run.at(POINTS[:3], Workers())) == alone[:3]
    assert (run.evaluated, run.reused, slept) == (2, 1, [1])


def dies(*_: object) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


@pytest.mark.slow
def test_a_dead_worker_is_want_of_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("skincad.studies.running.evaluate", dies)
    with pytest.raises(ExhaustedError, match="fewer workers"), workers(2) as who:
        Run(DESIGN, QUESTION).at(POINTS, who)


def test_what_can_not_be_used_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    for count, dask, says in ((0, None, "must be from 1"), (2, "tcp://x:1", "by the cluster")):
        with pytest.raises(InputError, match=says), workers(count, dask):
            pass
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InputError, match=r"pip install 'skincad\[dask\]'"), workers(dask="tcp://localhost:1"):
        pass


def swept(folder: Path, points: Sequence[Point]) -> list[str]:
    lengths = "skin.length=" + ",".join(str(point["skin.length"]) for point in points)
    start = [sys.executable, "-m", "skincad", "sweep", "yamada-2002", "--tier", "winkler"]
    return [*start, "--vary", lengths, "-o", str(folder), "--json"]


@pytest.mark.parametrize(
    ("most", "count"),
    [
        pytest.param(2, 60, marks=[pytest.mark.slow, pytest.mark.dear("starts skincad three times")]),
        pytest.param(15, 1000, marks=pytest.mark.evidence(subject="kills: studies")),
    ],
)
def test_kills_lose_and_repeat_nothing(most: int, count: int, tmp_path: Path) -> None:
    """SIGKILL of two runs at once, each time as soon as their log has grown, and a torn tail in between."""
    many: list[Point] = [{"skin.length": float(length)} for length in np.linspace(8, 16, count)]
    log, kills, seen = tmp_path / "evaluations.jsonl", 0, b""
    while kills < most:
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
        if kills == 2:
            with log.open("ab") as file:
                file.write(b'{"key": "torn')
        seen = log.read_bytes()
    assert len(seen.splitlines()) < len(many)  # there was work left for every kill
    subprocess.run(swept(tmp_path, many), check=True, stdout=subprocess.DEVNULL, timeout=300)
    left = Log(tmp_path)
    left.read()
    unbroken = Run(DESIGN, QUESTION)
    unbroken.at(many, Workers())
    assert sorted(told([*left.evaluations.values()])) == sorted(told([*unbroken.log.evaluations.values()]))
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
    monkeypatch.setattr("skincad.studies.running.PATIENCE", 1.0)
    with pytest.raises(InputError, match="no cluster answers"), workers(dask="tcp://127.0.0.1:9"):
        pass
