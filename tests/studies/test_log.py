"""The log: nothing that was finished is lost, whatever happens to the run that wrote it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

import skincad
from skincad.base import InputError
from skincad.studies import Evaluation, Log, Query, evaluate
from skincad.studies.running import NAME, evaluation_of, line_of
from tests.processes import started

DESIGN = skincad.load_design("yamada-2002")
FOUND = evaluate(DESIGN, {"skin.length": 12.0}, Query("check", "winkler"))


def numbered(number: int) -> Evaluation:
    return replace(FOUND, key=f"{number:016x}{0:016x}")


def test_a_line_tells_an_evaluation_whole() -> None:
    assert evaluation_of(json.loads(line_of(FOUND))) == FOUND
    refused = evaluate(DESIGN, {"skin.length": -1.0}, Query("check", "winkler"))
    assert refused.refused
    assert evaluation_of(json.loads(line_of(refused))) == refused


def test_what_was_appended_is_read_by_another_run(tmp_path: Path) -> None:
    ours, theirs = Log(tmp_path / "new"), Log(tmp_path / "new")
    theirs.read()
    assert theirs.evaluations == {}
    for number in range(3):
        ours.append(numbered(number))
        theirs.read()
        assert theirs.evaluations == ours.evaluations
    assert len(ours.evaluations) == 3


@pytest.mark.parametrize("tail", [1, 40, 700])
def test_a_torn_tail_is_cut_off_by_the_next_that_appends(tmp_path: Path, tail: int) -> None:
    log = Log(tmp_path)
    log.append(numbered(0))
    whole = log.path.read_bytes()
    with log.path.open("ab") as file:
        file.write(line_of(numbered(1)).encode()[:tail])
    after = Log(tmp_path)
    after.read()
    assert [*after.evaluations] == [numbered(0).key]
    after.append(numbered(2))
    assert after.torn
    assert log.path.read_bytes() == whole + line_of(numbered(2)).encode() + b"\n"
    again = Log(tmp_path)
    again.read()
    assert [*again.evaluations] == [numbered(0).key, numbered(2).key]


def test_a_log_of_nothing_but_a_torn_line_is_empty(tmp_path: Path) -> None:
    (tmp_path / NAME).write_bytes(b'{"key": "abc')
    log = Log(tmp_path)
    log.read()
    assert log.evaluations == {}
    log.append(numbered(0))
    assert log.path.read_bytes().startswith(b'{"key": "0000')


@pytest.mark.parametrize("text", ["not json\n", "[1, 2]\n", '{"key": 1}\n', "null\n"])
def test_another_file_of_that_name_is_refused_and_stays(tmp_path: Path, text: str) -> None:
    (tmp_path / NAME).write_text(text)
    with pytest.raises(InputError, match="no log of a study"):
        Log(tmp_path).read()
    assert (tmp_path / NAME).read_text() == text


def test_another_versions_lines_are_not_used(tmp_path: Path) -> None:
    log = Log(tmp_path)
    log.append(replace(numbered(0), version="0.0.1"))
    log.append(numbered(1))
    again = Log(tmp_path)
    again.read()
    assert [*again.evaluations] == [numbered(1).key]
    assert again.other == 1


def test_a_full_disk_is_one_line_and_leaves_whole_lines(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
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


def test_a_claim_is_one_processs_and_ends_with_it(tmp_path: Path) -> None:
    key = numbered(7).key
    code = (
        "import sys, time; from pathlib import Path; from skincad.studies.running import Log\n"
        f"log = Log(Path({str(tmp_path)!r})); print(log.claim({key!r}), flush=True); time.sleep(60)"
    )
    with started([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == "True\n"
        mine = Log(tmp_path)
        assert not mine.claim(key)
        assert mine.claim(numbered(8).key)
    assert mine.claim(key)
    mine.close()
