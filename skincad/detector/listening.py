"""A detector that listens to a board, a pipe or a recording: where bytes come from, what it says.

`listen` turns a stream into what a robot must know, each a dict that is one JSON line:

    {"kind": "incipient slip", "ridge": 3, "sample": 8123, "time_s": 1.6246}
    {"kind": "gross slip ahead", "ridge": null, "sample": 8140, "time_s": 1.628}
    {"kind": "lost", "samples": 4, "sample": 9001, "time_s": 1.8002, "filled": true}
    {"kind": "restart", "sample": 0, "time_s": 0.0}
    {"kind": "board alarm", "alarm": "gross slip ahead", "ridge": null, "sample": 8141}
    {"kind": "end", "why": "interrupted", "samples": 90000, "lost": 4, "alarms": 2, "seconds": 18.0,
     "share_of_core": 0.11, ...}

The mean of the first REST_SECONDS is the channels' resting voltage: nothing may touch the skin then. A
listener may be told another time, or 0 for a stream that rests at 0 V, as `simulate` writes it.
"""

from __future__ import annotations

import math
import os
import select
from collections.abc import Callable, Iterator
from contextlib import closing, suppress
from datetime import UTC, datetime
from pathlib import Path
from time import monotonic, process_time, sleep
from typing import Any

import numpy as np

from skincad.base.arrays import Array
from skincad.base.columns import read_columns
from skincad.base.errors import ExhaustedError, InputError, shown
from skincad.base.interrupt import at_once, safe_point
from skincad.base.outfolder import checked_fresh
from skincad.detector.detector import SEEN, Detector
from skincad.detector.features import SPANS
from skincad.detector.wire import COUNTER, TIME, Block, Wire, check_rate
from skincad.inputs.recordings import check_time, column_name

REST_SECONDS = 0.5
REST_SHARE = 0.1  # of a stream that is shorter
POLL = 0.02  # s, of a port: an alarm is as late
CUT, SOON = 2048, 0.002  # bytes of a port's read, after which more may wait: Linux hands on 4095 at once; s
FULL = 1 << 15  # bytes of a pipe's read: fewer are all that was there
QUIET = 0.1  # s, of a pipe, in which Ctrl-C waits
CHUNK, ROWS = 1 << 18, 4096  # bytes of a file at once; rows of one that is read otherwise
TIMEOUT = 2.0  # s, after which a silent port is one that stalls
HEADER = 3.0  # s of a port's bytes, within which a header comes
BOOT = 10.0  # s, that a board may take to begin: opening its port restarts many; assumption
LATE = 0.1  # s, that a sample may wait in this machine's buffers; assumption
BACKLOG = 0.2  # s of samples that a busy machine may catch up; assumption
RATE_AFTER = 1.0  # s of a port's stream, from which on its rate is measured
PART = ".part"

Chunks = Iterator[bytes]


def port_chunks(name: str, baud: int, timeout: float) -> Chunks:
    """Open a serial port, or pyserial's URL, as `socket://host:port`; return its bytes as they come.

    Raises InputError without pyserial, for a port that is not there, that stalls for `timeout` s, that ends.
    Its first bytes may take BOOT.
    """
    try:
        import serial
    except ModuleNotFoundError:
        raise InputError(
            "port", "needs the package pyserial", name, "pip install 'skincad[serial]'"
        ) from None
    try:
        port = serial.serial_for_url(name, baudrate=baud, timeout=0)
    except (serial.SerialException, OSError, ValueError) as failure:
        reason = (
            os.strerror(failure.errno) if isinstance(failure, OSError) and failure.errno else str(failure)
        )
        known = ", ".join(_ports()) or "none; is the board plugged in?"
        raise InputError("port", f"cannot be opened ({reason})", name, f"ports here: {known}") from None
    return _received(port, name, timeout)


def _received(port: Any, name: str, timeout: float) -> Chunks:
    with closing(port):
        heard, limit = monotonic(), max(timeout, BOOT)
        while True:
            safe_point()
            try:
                data = _gathered(port)
            except OSError as failure:  # as pyserial's own error is
                rule, remedy = f"ended ({failure})", "see to its cable and power, and listen again"
                raise InputError(name, rule, remedy=remedy) from None
            if data:
                yield data
                heard, limit = monotonic(), timeout
            elif monotonic() - heard > limit:
                raise stalled(name, limit)


def _gathered(port: Any) -> bytes:
    """What a port receives within POLL: few long reads, and soon another after one that a terminal's buffer
    may have cut."""
    parts, end = [], monotonic() + POLL
    while (left := end - monotonic()) > 0:
        parts.append(port.read(CHUNK))
        sleep(min(left, SOON) if len(parts[-1]) >= CUT else left)
    return b"".join(parts)


def stalled(name: str, timeout: float) -> InputError:
    """Return the error of a stream that is silent for `timeout` s."""
    remedy = "see to the board's power and program, or give --timeout"
    return InputError(name, f"must not be silent for {timeout:g} s", remedy=remedy)


def _ports() -> list[str]:
    from serial.tools.list_ports import comports

    return sorted(str(port.device) for port in comports())


def file_chunks(descriptor: int, name: str, timeout: float | None = None) -> Chunks:
    """Yield bytes of an open file or pipe as fast as they come, of one in real time every POLL.

    Raises InputError where it is silent for `timeout` s.
    """
    heard = monotonic()
    while True:
        safe_point()
        ready, _, _ = select.select([descriptor], [], [], QUIET)
        if ready:
            data = os.read(descriptor, CHUNK)
            if not data:
                return
            yield data
            heard = monotonic()
            if len(data) < FULL:
                sleep(POLL)  # a live stream: few long blocks cost less than many short ones
        elif timeout is not None and monotonic() - heard > timeout:
            raise stalled(name, timeout)


def wire_of(detector: Detector, name: str, *, noisy: bool = False) -> Wire:
    """Return the reader of a detector's stream."""
    longest = int(SPANS[-1] * detector.tuning.window)
    return Wire(name, detector.channels, detector.rate, longest_gap=longest, noisy=noisy)


def blocks_of(wire: Wire, chunks: Chunks, *, live: bool = True) -> Iterator[Block]:
    """Yield the blocks of a stream up to its end, of a live one up to the line that is refused."""
    for data in chunks:
        blocks, fault = wire.up_to_fault(data) if live else (wire.push(data), None)
        yield from blocks
        if fault is not None:
            raise fault
    yield from wire.finish()


def port_blocks(wire: Wire, chunks: Chunks) -> Iterator[Block]:
    """Yield the blocks of a stream in real time, and measure its rate by the clock.

    Raises InputError for a rate that is not the detector's: by RATE_TOLERANCE, and by LATE over the time for
    which it was measured. That is one without a pause of LATE; after a pause, twice as long is left out, in
    which what waited may be caught up. Raises it too where bytes come but no header.
    """
    began = ready = last = math.inf
    first: tuple[float, float] | None = None
    for data in chunks:
        now = monotonic()
        blocks, fault = wire.up_to_fault(data)
        began = min(began, now)
        if wire.header is None and now - began > HEADER:
            remedy = f"let the board send it once a second; {wire.wanted()}"
            raise InputError(wire.name, f"must send a header within {HEADER:g} s", remedy=remedy)
        if now - last > LATE or any(block.begins for block in blocks):
            first, ready = None, now + max(RATE_AFTER, 2 * (now - last))
        last = now
        if blocks and not wire.timed and now > ready:
            number = float(blocks[-1].numbers[-1])
            first = first or (now, number)
            seconds = now - first[0]
            if seconds > RATE_AFTER and number > first[1]:
                check_rate(wire.name, (number - first[1]) / seconds, wire.rate, BACKLOG / seconds)
        yield from blocks
        if fault is not None:
            raise fault


def recording_blocks(detector: Detector, path: Path) -> tuple[Wire, Iterator[Block]]:
    """Return the reader and the blocks of a CSV: a recording of `skincad listen`, or one with `time_s` and
    the channels, in whatever form `read_columns` knows."""
    name = str(path)
    wire = wire_of(detector, name)
    try:
        with at_once():  # a named pipe waits for its writer
            descriptor = os.open(path, os.O_RDONLY)
            head = b"" if not path.is_file() else os.pread(descriptor, CHUNK, 0)
            if path.is_dir():
                raise IsADirectoryError(0, "is a folder")
    except (OSError, ValueError) as failure:
        reason = getattr(failure, "strerror", None) or str(failure)
        raise InputError(name, f"cannot be read ({reason})", remedy="check the path") from None

    def streamed() -> Iterator[Block]:
        with os.fdopen(descriptor, "rb", buffering=0) as file:
            yield from blocks_of(wire, file_chunks(file.fileno(), name), live=False)

    if not path.is_file() or _is_plain(head, wire):
        return wire, streamed()
    os.close(descriptor)
    columns = read_columns(path, ("time_s", *(column_name(*channel) for channel in detector.channels)))
    time = columns["time_s"]
    check_time(time, f"{name}, row {{}}", "time_s")
    values = np.stack([columns[column_name(*channel)] for channel in detector.channels], axis=1)

    def tabled() -> Iterator[Block]:
        for start in range(0, time.size, ROWS):
            safe_point()
            yield from wire.table(time[start : start + ROWS], values[start : start + ROWS])
        yield from wire.finish()

    return wire, tabled()


def _is_plain(head: bytes, wire: Wire) -> bool:
    """Whether a file is one of the wire's form: its header first, with the channels wanted, numbers below."""
    lines = [line for line in head.splitlines() if line.strip() and not line.startswith(b"#")][:2]
    cells = [cell.strip() for cell in lines[0].split(b",")] if lines else []
    counted = cells[:1] == [COUNTER]  # its errors are the wire's
    known = cells[:1] == [TIME] and set(wire.columns) <= set(cells)
    return counted or (known and not lines[-1][:1].isalpha() and b";" not in lines[-1])


class RecordingFile:
    """A stream's samples as a CSV with `time_s`, which `skincad listen --csv` and spreadsheets read.

    It is FILE.part while it grows: each block is there once `write` returns, whatever ends this process.
    `close` makes it FILE. If the disk is full it ends with its last whole line, and `failure` says so.
    """

    def __init__(self, path: Path, name: str, rate: float) -> None:
        checked_fresh(path, ".csv", "record")
        self.path, self.part = path, path.with_name(path.name + PART)
        if self.part.exists() or self.part.is_symlink():
            rule = f"{self.part} is there: a recording whose process was killed"
            raise InputError("record", rule, remedy="read it with listen --csv; rename it, or remove it")
        if not path.parent.is_dir():
            raise InputError("record", f"{path.parent} is no folder", remedy="make it, or name another")
        began = datetime.now(UTC).isoformat(timespec="seconds")
        self._head = f"# skincad listen, {shown(name)}, {rate:g} Hz, began {began}\n".encode()
        self._file: Any = None
        self.samples, self.failure = 0, ""

    def write(self, wire: Wire, block: Block) -> None:
        """Append a block's lines as they came, with times in the place of the counter."""
        if self.failure or wire.header is None:
            return
        head = b""
        if self._file is None:
            self._open()
            head = self._head + b",".join([TIME, *wire.header[1:]]) + b"\n"
        lines = [line.rstrip(b"\r") for line in block.lines]
        if not wire.timed:
            stamps = [b"%.7f" % time for time in block.times[block.rows].tolist()]
            lines = [stamp + line[line.index(b",") :] for stamp, line in zip(stamps, lines, strict=True)]
        data, end = head + b"\n".join(lines) + b"\n", self._file.tell()
        try:
            written = 0
            while written < len(data):
                written += self._file.write(data[written:])
        except OSError as failure:
            self.failure = failure.strerror or str(failure)
            data = data[: data.rfind(b"\n", 0, written) + 1]
            self._file.truncate(end + len(data))
        self.samples += data.count(b"\n") - head.count(b"\n")

    def _open(self) -> None:
        try:
            self._file = self.part.open("xb", buffering=0)
        except OSError as failure:
            reason = failure.strerror
            raise InputError("record", f"{self.path} cannot be written ({reason})") from None

    def close(self) -> Path | None:
        """End the recording; return its file, None if nothing came."""
        if self._file is None:
            return None
        with suppress(OSError):
            os.fsync(self._file.fileno())
        self._file.close()
        if self.path.exists():  # a person wrote it meanwhile
            return self.part
        self.part.rename(self.path)
        return self.path


class Listener:
    """Feeds blocks to a detector and returns events; counts samples, those lost, and alarms."""

    def __init__(self, detector: Detector, rest_seconds: float = REST_SECONDS) -> None:
        if not 0 <= rest_seconds < math.inf:
            raise InputError("rest", "must be 0 s or more, and finite", rest_seconds)
        self.detector, self.rest_samples = detector, round(rest_seconds * detector.rate)
        self.samples = self.fed = self.lost = self.alarms = self.restarts = 0
        self.rest: Array | None = None  # (channels,) V
        self.noise = 0.0  # of the pair with most, at rest, in times of the detector's
        self._held, self._fresh, self._since = list[Block](), dict[str, Any](), 0

    @property
    def seconds(self) -> float:
        """Length of what was heard, with what was lost."""
        return self.samples / self.detector.rate

    def hear(self, block: Block) -> list[dict[str, Any]]:
        """Return the events of a block, and, once the resting voltage is known, of all before it."""
        self._held.append(block)
        if self.rest is None:
            waiting = sum(held.values.shape[0] for held in self._held)
            if waiting < self.rest_samples:
                return []
            self._take_rest(self.rest_samples)
        blocks, self._held = self._held, []
        return [event for held in blocks for event in self._events(held)]

    def finish(self) -> list[dict[str, Any]]:
        """Return the events of a stream that ended before its resting voltage was known: it is then the mean
        of its first REST_SHARE."""
        if self.rest is not None or not self._held:
            return []
        waiting = sum(held.values.shape[0] for held in self._held)
        self._take_rest(max(1, round(REST_SHARE * waiting)))
        blocks, self._held = self._held, []
        return [event for held in blocks for event in self._events(held)]

    def _take_rest(self, count: int) -> None:
        values = np.concatenate([held.values for held in self._held])[:count]
        self.rest = np.zeros(values.shape[1])
        if count:
            self.detector.rest(values)
            self.rest = values.mean(axis=0)
            pairs = values[:, 0::2] - values[:, 1::2]
            self.noise = float(pairs.std(axis=0).max()) / self.detector.tuning.noise
        self._fresh = self.detector.state

    def _events(self, block: Block) -> Iterator[dict[str, Any]]:
        numbers, times, size = block.numbers, block.times, block.values.shape[0]
        self.samples += size + block.gap
        first = {"sample": int(numbers[0]), "time_s": _seconds(times[0])}
        if block.begins == "restart":
            self.restarts += 1
            yield {"kind": "restart", **first}
        if block.gap:
            self.lost += block.gap
            yield {"kind": "lost", "samples": block.gap, **first, "filled": False}
        if block.begins in ("restart", "gap"):
            self.detector.restore(self._fresh)
            self._since = 0
        for count, number in block.lost:
            self.lost += count
            at = times[int(np.argmax(numbers == number))]
            yield {
                "kind": "lost", "samples": count, "sample": number, "time_s": _seconds(at), "filled": True,
            }  # fmt: skip
        for alarm in self.detector.feed(block.values):
            self.alarms += 1
            row = alarm.index - self._since
            yield {
                "kind": alarm.kind, "ridge": alarm.ridge, "sample": int(numbers[row]),
                "time_s": _seconds(times[row]),
            }  # fmt: skip
        self._since += size
        self.fed += size

    @property
    def at_rest(self) -> bool:
        """Whether no pair stood out of the noise while nothing should have touched."""
        return self.noise < SEEN


def _seconds(time: float) -> float:
    return round(float(time), 7)


def listen(
    wire: Wire,
    blocks: Iterator[Block],
    listener: Listener,
    tell: Callable[[dict[str, Any]], None],
    recording: RecordingFile | None = None,
    watch: Callable[[Block, list[dict[str, Any]]], None] = lambda *_: None,
) -> None:
    """Hear a stream to its end: `tell` gets each event as it comes, the end's too, whatever ends it; of a
    stream that is refused before its resting voltage is known, none.

    `watch` sees each block with its events. Raises InputError as the stream does; KeyboardInterrupt;
    ExhaustedError if the recording ended before the stream, for want of space.
    """
    began, why = process_time(), "interrupted"
    try:
        for block in blocks:
            if recording is not None and not recording.failure:
                recording.write(wire, block)
                if recording.failure:
                    why = recording.failure
                    tell({"kind": "recording ends", "samples": recording.samples, "why": why})
            alarms, wire.alarms = wire.alarms, []
            events = listener.hear(block)
            events += [
                {"kind": "board alarm", "alarm": alarm.kind, "ridge": alarm.ridge, "sample": alarm.index}
                for alarm in alarms
            ]
            for event in events:
                tell(event)
            watch(block, events)
        for event in listener.finish():
            tell(event)
        for alarm in wire.alarms:
            tell({"kind": "board alarm", "alarm": alarm.kind, "ridge": alarm.ridge, "sample": alarm.index})
        why = "end"
    except InputError as failure:
        why = str(failure)
        raise
    finally:
        spent, kept = process_time() - began, recording.close() if recording is not None else None
        end: dict[str, Any] = {
            "kind": "end", "why": why, "samples": listener.samples, "lost": listener.lost,
            "alarms": listener.alarms, "restarts": listener.restarts, "garbled": wire.garbled,
            "seconds": _seconds(listener.seconds),
            "share_of_core": round(spent * wire.rate / listener.fed, 4) if listener.fed else None,
        }  # fmt: skip
        if kept is not None:
            end["recording"] = str(kept)
            end["recorded"] = recording.samples if recording is not None else 0
        if listener.samples or kept is not None:
            tell(end)
    if recording is not None and recording.failure:
        raise ExhaustedError(f"{recording.path} ends after {recording.samples} samples: {recording.failure}")
