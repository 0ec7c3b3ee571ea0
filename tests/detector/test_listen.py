"""`skincad listen`: alarms of a recording, a pipe and a port as JSON lines; recordings that outlive it."""

from __future__ import annotations

import json
import math
import os
import signal
import subprocess
import sys
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from threading import Event, Thread
from typing import Any

import numpy as np
import pytest

from skincad.base import InputError
from skincad.detector import AHEAD, Listener, listen, port_blocks, port_chunks, wire_of
from skincad.detector.listening import RecordingFile
from skincad.detector.wire import check_rate
from tests.conftest import run_skincad
from tests.detector.test_detector import RATE, RIDGES, made, of_stress, slipping, stressed
from tests.processes import started
from tests.refusals import refused, refused_command

WORDS = ("listen", "yamada-2002", "--circuit", "transimpedance", "--ridges", "2,3,7", "--rate", f"{RATE:g}")
REST = round(0.5 * RATE)
HEADER = ",".join(f"ridge_{ridge}_{side}_V" for ridge in RIDGES for side in ("S1", "S2"))


def board_lines(values: np.ndarray, first: int = 777, head: str = "sample") -> str:
    rows = [f"{k},{','.join(f'{v:.7f}' for v in row)}\n" for k, row in enumerate(values.tolist(), first)]
    return f"{head},{HEADER}\n" + "".join(rows)


def felt() -> np.ndarray:
    """Half a second at rest and half a second of slips, behind the bias of a single supply."""
    values = slipping(made())
    values[:REST] *= 0.02
    return np.round(values + 1.65, 7)


def expected(values: np.ndarray) -> list[tuple[str, int | None, int]]:
    detector = made()
    detector.rest(values[:REST])
    return [(alarm.kind, alarm.ridge, alarm.index) for alarm in detector.feed(values)]


def said(out: str) -> list[dict[str, Any]]:
    return [json.loads(line) for line in out.splitlines()]


def alarms_in(events: list[dict[str, Any]], first: int = 0) -> list[tuple[str, int | None, int]]:
    return [(e["kind"], e["ridge"], e["sample"] - first) for e in events if "ridge" in e and "time_s" in e]


def test_a_recordings_alarms_are_the_detectors(tmp_path: Path) -> None:
    values = felt()
    (tmp_path / "film.csv").write_text(board_lines(values))
    done = run_skincad(*WORDS, "--csv", "film.csv", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    *events, end = said(done.stdout)
    assert alarms_in(events, 777) == expected(values)
    assert len(events) > 2
    assert AHEAD in [event["kind"] for event in events]
    assert all(e["time_s"] == pytest.approx((e["sample"] - 777) / RATE) for e in events)
    counts = {"kind": "end", "samples": 5000, "lost": 0, "alarms": len(events), "seconds": 1.0, "garbled": 0}
    assert end.items() >= counts.items()
    assert end["share_of_core"] > 0
    assert done.stderr.startswith(
        "yamada-2002, film.csv: 6 channels at 5000 Hz, a window of 3 samples; at rest, V:"
    )
    assert done.stderr.count("1.65") == 6
    assert done.stderr.count("\n") == 1


def test_of_a_stress_a_grippers_alarms_are_the_detectors(tmp_path: Path) -> None:
    """A file has the outputs; what they change by is the detector's business."""
    values = np.round(stressed() * 100, 7)  # behind a louder board: 0.1 uV is the file's last digit
    values[:REST] = np.round(np.random.default_rng(3).normal(0.0, 5e-5, values[:REST].shape), 7)
    (tmp_path / "film.csv").write_text(board_lines(values, 0))
    right = of_stress(noise=1e-4)
    right.rest(values[:REST])
    alarms = [(alarm.kind, alarm.ridge, alarm.index) for alarm in right.feed(values)]
    words = (*WORDS, "--circuit", "charge-amplifier", "--alarms", "grip", "--noise", "1e-4")
    done = run_skincad(*words, "--csv", "film.csv", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    events = said(done.stdout)
    assert alarms_in(events) == alarms
    assert {(kind, ridge) for kind, ridge, _ in alarms} == {(AHEAD, None)}
    assert len(alarms) >= 3
    assert alarms[0][2] >= REST


def test_a_recording_of_another_program_is_read(tmp_path: Path) -> None:
    """Semicolons, decimal commas, millivolts, a row of units: as all other CSVs of measurements."""
    values = felt()
    names = HEADER.replace(",", ";").replace("_V", "")
    rows = [";".join(f"{v:.7g}" for v in (k / RATE, *(1000 * row))) for k, row in enumerate(values)]
    text = "\n".join([f"Time;{names}", "s" + ";mV" * 6, *rows]).replace(".", ",")
    (tmp_path / "film.csv").write_text(text)
    done = run_skincad(*WORDS, "--csv", "film.csv", cwd=tmp_path)
    assert alarms_in(said(done.stdout)) == expected(values), done.stderr


def test_lost_samples_and_a_restart_are_said_and_time_stays_right(tmp_path: Path) -> None:
    values = felt()
    head, *rows = board_lines(values, 0).splitlines(keepends=True)
    (tmp_path / "film.csv").write_text(
        head + "".join(rows[:2600] + rows[2604:4500]) + board_lines(values[3000:], 0)
    )
    *events, end = said(run_skincad(*WORDS, "--csv", "film.csv", cwd=tmp_path).stdout)
    lost = {"kind": "lost", "samples": 4, "sample": 2600, "time_s": 0.52, "filled": True}
    assert [event for event in events if event["kind"] == "lost"] == [lost]
    assert [event for event in events if event["kind"] == "restart"] == [
        {"kind": "restart", "sample": 0, "time_s": 0.0}
    ]
    assert (end["samples"], end["lost"], end["restarts"]) == (6500, 4, 1)
    filled = values[:4500].copy()
    places = np.arange(2600, 2604)
    columns = [np.interp(places, [2599, 2604], column[[2599, 2604]]) for column in values.T]
    filled[places] = np.stack(columns, axis=1)
    place = [event["kind"] for event in events].index("restart")
    assert alarms_in(events[:place]) == expected(filled)
    again = made()  # it remembers nothing but what rests
    again.rest(values[:REST])
    anew = [(alarm.kind, alarm.ridge, alarm.index) for alarm in again.feed(values[3000:])]
    assert alarms_in(events[place + 1 :]) == anew
    assert anew


def test_a_short_recording_rests_in_its_first_tenth(tmp_path: Path) -> None:
    values = felt()[2000:4000]
    (tmp_path / "film.csv").write_text(board_lines(values))
    done = run_skincad(*WORDS, "--csv", "film.csv", cwd=tmp_path)
    detector = made()
    detector.rest(values[:200])
    alarms = [(alarm.kind, alarm.ridge, alarm.index) for alarm in detector.feed(values)]
    assert alarms_in(said(done.stdout), 777) == alarms
    assert "at rest, V: 2 S1 1.65" in done.stderr


def test_a_touch_at_the_start_is_noticed(tmp_path: Path) -> None:
    (tmp_path / "film.csv").write_text(board_lines(slipping(made())))
    done = run_skincad(*WORDS, "--csv", "film.csv", cwd=tmp_path)
    assert "Does something touch the skin?" in done.stderr


GOOD = board_lines(np.full((3000, 6), 1.65), 0)
BAD = {
    "--csv missing.csv": "missing.csv: cannot be read (No such file or directory)",
    "--csv .": ".: cannot be read",
    "--csv empty.csv": "empty.csv: has no rows of numbers; first row: time_s,ridge_2_S1_V",
    "--csv two.csv": "two.csv, column 'ridge_3_S1_V': is missing",
    "--csv few.csv": "few.csv: has no channel ridge_3_S1_V, nor 3 more",
    "--csv nan.csv": "nan.csv, sample 3000, ridge_2_S2_V: must be finite, got nan",
    "--csv fast.csv": "fast.csv: must have the detector's 5000 samples a second, to 2%, got 5500",
    "--port /dev/none": "--port: cannot be opened (No such file or directory), got '/dev/none'; ports here: ",
    "": "arguments: must be a design or scene, and one of --port PORT, --csv FILE and -",
    "--csv good.csv -": "arguments: must be a design or scene, and one of",
    "--csv good.csv --port /dev/null": "arguments: must be a design or scene, and one of",
    "--csv good.csv --record film.csv": "--record: is of a port or of standard input",
    "--port x --record film.txt": "--record: film.txt must end in .csv",
    "--port x --record good.csv": "--record: good.csv exists already",
    "--port x --record killed.csv": "--record: killed.csv.part is there: a recording whose process",
    "--port x --record no/film.csv": "--record: no is no folder",
    "--port x --timeout 0": "--timeout: must be above 0 s and finite",
    "--csv good.csv --every 0": "--every: must be at least 1 sample",
}


@pytest.mark.parametrize("line", BAD)
def test_what_cannot_be_heard_is_one_line_and_exit_2(line: str, tmp_path: Path) -> None:
    row = ",1.65" * 6 + "\n"
    files = {
        "good.csv": GOOD,
        "empty.csv": "",
        "few.csv": "sample,ridge_2_S1_V,ridge_2_S2_V\n1,1.0,1.0\n",
        "two.csv": "time_s,ridge_2_S1_V,ridge_2_S2_V\n0.0,1.0,1.0\n0.1,1.0,1.0\n",
        "nan.csv": GOOD + "3000,1.65,nan" + ",1.65" * 4 + "\n",
        "fast.csv": f"time_s,{HEADER}\n" + "".join(f"{k / 5500:.7f}{row}" for k in range(3000)),
        "killed.csv.part": GOOD,
    }
    for name, content in files.items():
        (tmp_path / name).write_text(content)
    assert refused_command(*WORDS, *line.split(), cwd=tmp_path).startswith(BAD[line])


def test_a_fault_after_alarms_ends_them_with_its_reason(tmp_path: Path) -> None:
    text = board_lines(felt()) + "5777,nan" + ",1.65" * 5 + "\n"
    (tmp_path / "film.csv").write_text(text + "5778" + ",1.65" * 6 + "\n")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("skincad.detector.listening.CHUNK", 1 << 16)
        done = run_skincad(*WORDS, "--csv", "film.csv", cwd=tmp_path)
    *events, end = said(done.stdout)
    assert done.returncode == 2
    assert [event["kind"] for event in events][:1] == [AHEAD]
    assert done.stderr.splitlines()[-1] == f"skincad: {end['why']}"
    assert end["why"].startswith("film.csv, sample 5777, ridge_2_S1_V: must be finite, got nan")


def test_without_pyserial_its_extra_is_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setitem(sys.modules, "serial", None)
    line = refused_command(*WORDS, "--port", "/dev/null", cwd=tmp_path)
    assert line == "--port: needs the package pyserial, got '/dev/null'; pip install 'skincad[serial]'"


@contextmanager
def board(*pieces: bytes) -> Iterator[tuple[str, Callable[[], None]]]:
    """A pseudo-terminal, and what lets its other end send these bytes and then be silent."""
    ours, theirs = os.openpty()
    tty.setraw(theirs)
    over = Event()

    def send() -> None:
        for piece in pieces:
            data = memoryview(piece)
            while data and not over.is_set():
                data = data[os.write(ours, data[:1000]) :]

    sender = Thread(target=send, daemon=True)
    try:
        yield os.ttyname(theirs), sender.start
    finally:
        over.set()
        os.close(theirs)
        sender.join(timeout=10)
        os.close(ours)


def heard(
    line: tuple[str, Callable[[], None]], recording: RecordingFile, monkeypatch: pytest.MonkeyPatch
) -> tuple[list[dict[str, Any]], str]:
    """What is said of a port until it is silent for 0.3 s, and the error that ends it."""
    port, begin = line
    monkeypatch.setattr("skincad.detector.listening.RATE_AFTER", math.inf)  # it sends as fast as it can
    detector = made()
    events: list[dict[str, Any]] = []
    wire, chunks = wire_of(detector, "board", noisy=True), port_chunks(port, 115_200, 0.3)
    begin()
    with pytest.raises(InputError) as end:
        listen(wire, port_blocks(wire, chunks), Listener(detector), events.append, recording)
    return events, str(end.value)


def test_a_port_is_heard_until_it_stalls_and_its_recording_heard_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    values = felt()
    lines = board_lines(values).encode()
    head = lines[: lines.index(b"\n") + 1]
    noise = b"2,1.65,1.65\x00\xff,1.6\n"
    half = lines.index(b"\n", len(lines) // 2) + 1
    with board(noise, lines[:half], head, b"alarm,999,incipient slip,3\n# hot\n", lines[half:]) as line:
        recording = RecordingFile(tmp_path / "film.csv", "a board", RATE)
        (*events, end), words = heard(line, recording, monkeypatch)
    assert words.startswith(f"{line[0]}: must not be silent for 0.3 s; see to the board's power")
    assert alarms_in(events, 777) == expected(values)
    (own,) = [event for event in events if event["kind"] == "board alarm"]
    assert own == {"kind": "board alarm", "alarm": "incipient slip", "ridge": 3, "sample": 999}
    assert (end["why"], end["recording"]) == (words, str(tmp_path / "film.csv"))
    assert [path.name for path in tmp_path.iterdir()] == ["film.csv"]
    again = run_skincad(*WORDS, "--csv", "film.csv", cwd=tmp_path)
    assert alarms_in(said(again.stdout)) == expected(values)
    table = np.loadtxt(tmp_path / "film.csv", delimiter=",", skiprows=2)
    np.testing.assert_array_equal(table[:, 1:], values)
    np.testing.assert_allclose(table[:, 0], np.arange(5000) / RATE, atol=1e-9)


def test_a_port_that_ends_or_sends_no_header_is_said() -> None:
    ours, theirs = os.openpty()
    tty.setraw(theirs)
    chunks = port_chunks(os.ttyname(theirs), 115_200, 0.3)
    os.write(ours, b"1,1.65\n")
    assert next(chunks) == b"1,1.65\n"
    os.close(ours)
    with refused("ended ("):
        next(chunks)
    os.close(theirs)
    wire = wire_of(made(), "board", noisy=True)
    with pytest.MonkeyPatch.context() as patch, refused("board: must send a header within 3 s"):
        clock = iter(range(100))
        patch.setattr("skincad.detector.listening.monotonic", lambda: next(clock))
        list(port_blocks(wire, iter([b"5,1.65,1.65\n"] * 10)))


@pytest.mark.parametrize(("rate", "good"), [(RATE, True), (1.01 * RATE, True), (1.05 * RATE, False)])
def test_a_ports_rate_is_measured_by_the_clock(rate: float, good: bool) -> None:
    """Samples that wait up to LATE, a pause, and what is caught up after it are no other rate."""
    wire, dice = wire_of(made(), "board", noisy=True), np.random.default_rng(3)
    pieces = np.concatenate([np.arange(0, 8, 0.02), np.arange(8, 10, 0.05), np.arange(10, 16, 0.02)])
    late = pieces + dice.uniform(0, 0.019, pieces.size)
    late[300:305] += 0.05
    late[400:440] = 10 + 0.02 * np.arange(40)  # it waited for 2 s, and comes in 0.8
    late[440:] += 1.0
    counts = [0, *(rate * pieces).astype(int) + 1]
    lines = ["".join(f"{k}{',1.65' * 6}\n" for k in range(a, b)).encode() for a, b in pairwise(counts)]
    lines[0] = f"sample,{HEADER}\n".encode() + lines[0]
    clock = iter(late.tolist())
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("skincad.detector.listening.monotonic", lambda: next(clock))
        blocks = port_blocks(wire, iter(lines))
        if good:
            assert sum(block.values.shape[0] for block in blocks) == counts[-1]
        else:
            with refused("must have the detector's 5000 samples a second, to 2%, got 52"):
                list(blocks)
    with refused("got 5200; listen with --rate 5200"):
        check_rate("board", 5200.4, RATE)


def test_a_full_disk_ends_the_recording_with_a_whole_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And not the detector."""
    recording = RecordingFile(tmp_path / "film.csv", "a board", RATE)
    values = felt()

    class Full:
        """A file on a disk that takes 100 kB."""

        def __init__(self, file: Any) -> None:
            self.file = file

        def write(self, data: bytes) -> int:
            left = 100_000 - self.file.tell()
            if left <= 0:
                raise OSError(28, "No space left on device")
            return int(self.file.write(data[:left]))

        def __getattr__(self, name: str) -> Any:
            return getattr(self.file, name)

    opened = recording._open

    def full() -> None:
        opened()
        recording._file = Full(recording._file)

    recording._open = full  # type: ignore[method-assign]
    lines = board_lines(values).encode()
    with board(lines) as line:
        events, _ = heard(line, recording, monkeypatch)
    sent = (tmp_path / "film.csv").read_bytes()
    assert recording.failure == "No space left on device"
    assert sent.endswith(b"\n")
    assert sent.count(b"\n") == recording.samples + 2
    assert alarms_in(events, 777) == expected(values)


LISTEN = [sys.executable, "-m", "skincad", *WORDS]


@pytest.mark.slow
@pytest.mark.dear("three processes that import the detector")
@pytest.mark.parametrize("ending", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_no_signal_loses_a_recording(ending: signal.Signals, tmp_path: Path) -> None:
    values = felt()
    lines = board_lines(values).encode()
    pipes: dict[str, Any] = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.PIPE)
    with started([*LISTEN, "-", "--record", "film.csv"], cwd=tmp_path, **pipes) as process:
        process.stdin.write(lines)
        process.stdin.flush()
        alarms = expected(values)
        events = [json.loads(process.stdout.readline()) for _ in alarms]
        process.send_signal(ending)
        status, out = process.wait(timeout=60), process.stdout.read()
    assert alarms_in(events, 777) == alarms
    name = "film.csv.part" if ending == signal.SIGKILL else "film.csv"
    assert [path.name for path in tmp_path.iterdir()] == [name]
    assert len((tmp_path / name).read_text().splitlines()) == values.shape[0] + 2
    if ending != signal.SIGKILL:
        assert status == 128 + ending
        (end,) = said(out.decode())
        assert (end["why"], end["samples"], end["recording"]) == ("interrupted", 5000, "film.csv")
    again = run_skincad(*WORDS, "--csv", name, cwd=tmp_path)
    assert alarms_in(said(again.stdout)) == alarms


@pytest.mark.slow
@pytest.mark.parametrize("line", ["pipe", "port"])
def test_the_bench_counts_what_its_board_sends(line: str) -> None:
    from bench.listening import listened

    end = listened(2, 1.5, line)
    assert end["samples"] > RATE
    assert end["share_of_core"] > 0
