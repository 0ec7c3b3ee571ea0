"""The wire between a board and `skincad listen`: lines of samples, read in bulk.

    sample,ridge_2_S1_V,ridge_2_S2_V,ridge_3_S1_V,...   the header: first, and again when the board likes
    12345,0.001234,-0.000231,...                        a counter of samples (it wraps at 2**32), then volts
    alarm,12345,gross slip ahead,                       an alarm of the board's own, its last field the ridge
    # any text                                          a remark

A recording has `time_s` in place of `sample`. Lines end in LF or CRLF. Columns that nobody asks for are
passed over.

Samples that are lost show as a gap in the counter or the time. A gap of up to `Wire.longest_gap` samples is
filled by straight lines from the last sample before it to the first after it, so that time stays right. That
is as long as the detector's longest mean looks back: after a longer gap nothing that it remembers is of use,
and the samples after it are no continuation. Nor are they where the counter or the time falls back: the board
has restarted.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from skincad.base.arrays import Array
from skincad.base.errors import InputError
from skincad.detector.detector import Alarm
from skincad.inputs.recordings import column_name

COUNTER, TIME = b"sample", b"time_s"
ALARM = b"alarm"
WRAP = 2**32  # of the counter
WRAP_SECONDS = 60.0  # a counter that begins again from 0 has wrapped if that is the shorter gap; assumption
LONGEST_LINE = 100_000  # bytes: no line of a thousand columns is longer
RATE_TOLERANCE = 0.02  # of the rate: the windows are whole samples, and the time of an alarm is as wrong
RATE_SECONDS = 0.5  # of a recording, over which its rate is measured
FEWEST_STAMPS = 20  # rows, of which a rate is measured


@dataclass(frozen=True, eq=False)
class Block:
    """Samples without a gap: `values` `(n, channels)` V, their `numbers` in the stream and `times` s `(n,)`.

    `numbers` are the board's counter; in a stream with times they count from its first row. Times count from
    the first sample, or are the stream's own. `lost`: of each gap that was filled how many samples, and the
    number of the first. `begins` says why the block is no continuation of the one before: "" if it is one,
    "start", "restart" or "gap", of `gap` samples. `rows` are the places of samples that came, `lines` their
    lines.
    """

    values: Array
    numbers: Array
    times: Array
    lost: tuple[tuple[int, int], ...]
    begins: str
    gap: int
    rows: Array
    lines: Sequence[bytes]


class Wire:
    """Reads a stream of lines: `push` takes bytes as they come, and gives whole blocks.

    `name` is what messages call the stream, `channels` the ridge and strip of each column that is wanted,
    `rate` Hz what its samples should have. A line that cannot be read raises InputError, or, of a `noisy`
    line, is a lost sample: `garbled` counts them, and what comes before the first header is passed over.
    """

    def __init__(
        self,
        name: str,
        channels: Sequence[tuple[int, str]],
        rate: float,
        *,
        longest_gap: int,
        noisy: bool = False,
    ) -> None:
        self.name, self.rate, self.noisy, self.longest_gap = name, rate, noisy, longest_gap
        self.columns = [column_name(ridge, side).encode() for ridge, side in channels]
        self.header: list[bytes] | None = None
        self.garbled, self.line = 0, 0
        self.alarms = list[Alarm]()  # of the board, at its samples, until somebody takes them
        self._left = b""
        self._places = list[int]()
        self._last: tuple[float, float, float, Array] | None = None  # key, number, time and volts
        self._origin = 0.0  # the number at which time is 0
        self._stamps: list[Array] | None = []  # until the rate is measured

    @property
    def timed(self) -> bool:
        """Whether its first column is a time."""
        return self.header is not None and self.header[0] == TIME

    def push(self, data: bytes) -> list[Block]:
        """Return the blocks of the next bytes, but for an unfinished line, which the next bytes end.

        Raises InputError for a header without a wanted channel, one that changes, a value that is not finite,
        a time that stands still, a rate that is off by more than RATE_TOLERANCE; and, if it is not noisy, for
        a line that cannot be read.
        """
        whole, newline, left = data.rpartition(b"\n")
        if not newline:
            self._left += data
            if len(self._left) > LONGEST_LINE:
                raise self._no_lines()
            return []
        lines = (self._left + whole).split(b"\n")
        self._left = left
        return self._blocks(lines)

    def up_to_fault(self, data: bytes) -> tuple[list[Block], InputError | None]:
        """Return the blocks of the next bytes as `push`, and the error of what is refused: then the blocks
        are those of the lines before it, so that they can be heard and recorded.
        """
        before = {key: [*value] if isinstance(value, list) else value for key, value in vars(self).items()}
        try:
            return self.push(data), None
        except InputError as failure:
            vars(self).update(before)
            blocks = list[Block]()
            try:
                for line in data.splitlines(keepends=True):
                    blocks += self.push(line)
            except InputError as fault:
                return blocks, fault
            return [], failure

    def finish(self) -> list[Block]:
        """Return the blocks of a last line without its end, if it is whole, and check a short one's rate."""
        left, self._left = self._left.strip(), b""
        blocks = []
        if left and (self.header is None or left.count(b",") == len(self.header) - 1):
            blocks = self._blocks([left])
        if self.header is None and not self.noisy:
            raise InputError(self.name, "has no header", remedy=self.wanted())
        self._check_rate(self._stamps)
        return blocks

    def table(self, time: Array, values: Array) -> list[Block]:
        """Return the blocks of the next rows of a recording that another reader read: `time` `(n,)` s,
        `values` `(n, channels)` V."""
        self.header = [TIME, *self.columns]
        return self._stretches(time, values, ())

    def wanted(self) -> str:
        """Return a remedy: the header that is wanted."""
        return f"first line: {b','.join([COUNTER, *self.columns[:4]]).decode()}" + ",..." * (
            len(self.columns) > 4
        )

    def _no_lines(self) -> InputError:
        rule = "must send lines of numbers"
        return InputError(self.name, rule, self._left[:20], "see to the port and its --baud")

    def _blocks(self, lines: list[bytes]) -> list[Block]:
        samples, first = list[bytes](), self.line + 1
        begin = 0
        for place in [i for i, line in enumerate(lines) if not line[:1].isdigit()]:
            line = lines[place].strip()
            if not line or line.startswith(b"#"):
                pass
            elif line.startswith((COUNTER + b",", TIME + b",")):
                if self.header is None:
                    begin = place + 1
                    self.header = self._checked_header(line)
                elif [cell.strip() for cell in line.split(b",")] != self.header:
                    rule = f"must keep its columns, which are {b','.join(self.header).decode()}"
                    remedy = "restart the board, and listen again"
                    raise InputError(self.name, rule, line.decode(errors="replace"), remedy)
            elif line.startswith(ALARM + b","):
                self._note_alarm(line)
            else:
                continue
            lines[place] = b""
        self.line += len(lines)
        samples = [line for line in lines[begin:] if line]
        if self.header is None:
            if samples and not self.noisy:
                got = samples[0][:80].decode(errors="replace")
                raise InputError(self.name, "has no header before its numbers", got, self.wanted())
            return []
        if not samples:
            return []
        numbers, samples = self._numbers(samples, lines, first)
        if not samples:
            return []
        keys = numbers[:, 0]
        values = numbers if self._places == list(range(numbers.shape[1])) else numbers[:, self._places]
        self._check_finite(keys, values)
        return self._stretches(keys, values, samples)

    def _checked_header(self, line: bytes) -> list[bytes]:
        header = [cell.strip() for cell in line.split(b",")]
        missing = [column for column in self.columns if column not in header]
        if missing:
            rule = f"has no channel {missing[0].decode()}"
            if len(missing) > 1:
                rule += f", nor {len(missing) - 1} more"
            there = sorted({int(cell.split(b"_")[1]) for cell in header if _is_channel(cell)})
            both = [r for r in there if all(column_name(r, s).encode() in header for s in ("S1", "S2"))]
            remedy = "connect it" + (f", or listen with --ridges {','.join(map(str, both))}" if both else "")
            got = b",".join(header[1:]).decode(errors="replace")
            raise InputError(self.name, rule, got, remedy)
        self._places = [header.index(column) for column in self.columns]
        return header

    def _note_alarm(self, line: bytes) -> None:
        cells = line.decode(errors="replace").split(",")
        try:
            ridge = int(cells[3]) if len(cells) > 3 and cells[3].strip() else None
            self.alarms.append(Alarm(cells[2], ridge, int(cells[1])))
        except (IndexError, ValueError):
            self.garbled += 1
            if not self.noisy:
                where = f"{self.name}, line {line.decode(errors='replace')[:40]!r}"
                raise InputError(where, "must be alarm,SAMPLE,KIND,RIDGE") from None

    def _numbers(self, samples: list[bytes], lines: list[bytes], first: int) -> tuple[Array, list[bytes]]:
        """The numbers `(n, columns)` of lines, all at once; one by one where one of them is no sample."""
        assert self.header is not None
        width = len(self.header)
        if all(line.count(b",") == width - 1 for line in samples):
            numbers = _parsed(b",".join(samples))
            if numbers.size == width * len(samples):
                return numbers.reshape(-1, width), samples
        rows, good = [], []
        for line in samples:
            cells = line.split(b",")
            row = [np.nan] * width
            try:
                if len(cells) != width or b"_" in line:
                    raise ValueError
                for place in (0, *self._places):
                    row[place] = float(cells[place])
            except ValueError:
                self.garbled += 1
                if not self.noisy:
                    where = f"{self.name}, line {first + lines.index(line)}"
                    rule = f"must be {width} numbers, a comma between"
                    raise InputError(where, rule, line[:80].decode(errors="replace")) from None
                continue
            rows.append(row)
            good.append(line)
        return np.array(rows).reshape(-1, width), good

    def _check_finite(self, keys: Array, values: Array) -> None:
        bad = ~np.isfinite(values)
        if bad.any():
            row, column = np.argwhere(bad)[0]
            where = f"{self.name}, {'time' if self.timed else 'sample'} {keys[row]:.10g}"
            channel = self.columns[column].decode()
            remedy = "see to its converter; listen with --ridges of those that work"
            raise InputError(f"{where}, {channel}", "must be finite", float(values[row, column]), remedy)
        if not np.isfinite(keys).all() or not (self.timed or (keys == np.rint(keys)).all()):
            wrong = keys[~(np.isfinite(keys) & (keys == np.rint(keys)))][0]
            rule = "must be a finite number of seconds" if self.timed else "must be a whole number"
            raise InputError(f"{self.name}, {'time_s' if self.timed else 'sample'}", rule, float(wrong))

    def _stretches(self, keys: Array, values: Array, lines: Sequence[bytes]) -> list[Block]:
        """Cut samples where they are no continuation, and fill the gaps between."""
        before = keys[:1] - (1 / self.rate if self.timed else 1) if self._last is None else [self._last[0]]
        steps = np.diff(np.concatenate([before, keys]))
        if self.timed:
            if (steps == 0).any():
                rule, row = "time_s must grow from row to row", int(np.argmax(steps == 0))
                remedy = "write it with more digits"
                raise InputError(self.name, rule, float(keys[row]), remedy)
            self._measure(steps)
            whole = np.rint(steps * self.rate)
            steps = np.where(steps > 0, np.maximum(whole, 1), -1)
        else:
            around = steps + WRAP
            steps = np.where((steps <= 0) & (around <= WRAP_SECONDS * self.rate), around, steps)
        ends = np.flatnonzero((steps <= 0) | (steps > self.longest_gap + 1))
        if self._last is None:
            ends = np.union1d(ends, [0])
        cuts = [*([] if ends.size and ends[0] == 0 else [0]), *ends.tolist(), keys.size]
        return [self._stretch(keys[a:b], values[a:b], steps[a:b], lines[a:b]) for a, b in pairwise(cuts)]

    def _stretch(self, keys: Array, values: Array, steps: Array, lines: Sequence[bytes]) -> Block:
        """The block of samples that come `steps` after one another; the first after the last that came."""
        begins, gap, last = "", 0, self._last
        if last is None:
            begins = "start"
        elif steps[0] <= 0:
            begins = "restart"
        elif steps[0] > self.longest_gap + 1:
            begins, gap = "gap", int(steps[0]) - 1
        if begins or last is None:  # place 0 is the first sample, else the last one before
            zero = last[1] + steps[0] if begins == "gap" and last is not None else self._start(keys)
            places, known, stamps = np.concatenate([[0.0], np.cumsum(steps[1:])]), values, keys
        else:
            zero, places = last[1], np.concatenate([[0.0], np.cumsum(steps)])
            known, stamps = np.vstack([last[3], values]), np.concatenate([[last[2]], keys])
        skip = 0 if begins else 1
        grid = np.arange(skip, int(places[-1]) + 1.0)
        numbers = zero + grid
        times = np.interp(grid, places, stamps) if self.timed else (numbers - self._origin) / self.rate
        widths = np.diff(places)
        lost = tuple(
            (int(widths[i]) - 1, int(zero + places[i] + 1) % WRAP) for i in np.flatnonzero(widths > 1)
        )
        if lost:
            values = np.stack([np.interp(grid, places, column) for column in known.T], axis=1)
        self._last = float(keys[-1]), float(numbers[-1]), float(times[-1]), values[-1]
        rows = (places[skip:] - skip).astype(int)
        return Block(values, np.mod(numbers, WRAP), times, lost, begins, gap, rows, lines)

    def _start(self, keys: Array) -> float:
        """Let numbers and times begin with these samples."""
        self._origin = 0.0 if self.timed else float(keys[0])
        return self._origin

    def _measure(self, steps: Array) -> None:
        if self._stamps is not None:
            self._stamps.append(steps)
            if sum(part.size for part in self._stamps) >= max(FEWEST_STAMPS, RATE_SECONDS * self.rate):
                self._check_rate(self._stamps)
                self._stamps = None

    def _check_rate(self, stamps: list[Array] | None) -> None:
        """Raise InputError where the mean step between samples, gaps left out, is not the detector's."""
        steps = np.concatenate([*(stamps or []), np.zeros(0)])[1:]
        steps = steps[steps > 0]
        if steps.size + 1 >= FEWEST_STAMPS:
            check_rate(self.name, 1 / float(steps[steps < 1.5 * np.median(steps)].mean()), self.rate)


def check_rate(name: str, measured: float, rate: float, slack: float = 0.0) -> None:
    """Raise InputError for a stream whose `measured` rate is not the detector's `rate` Hz, by RATE_TOLERANCE
    and a `slack` beside it."""
    if abs(measured / rate - 1) > RATE_TOLERANCE + slack:
        rule = f"must have the detector's {rate:g} samples a second, to {RATE_TOLERANCE:.0%}"
        near = float(f"{measured:.4g}")
        raise InputError(name, rule, near, f"listen with --rate {near:g}")


def _is_channel(cell: bytes) -> bool:
    parts = cell.split(b"_")
    return (
        len(parts) == 4
        and (parts[0], parts[3]) == (b"ridge", b"V")
        and parts[1].isdigit()
        and parts[2] in (b"S1", b"S2")
    )


def _parsed(text: bytes) -> Array:
    """The numbers of a text, a comma between; fewer where one is none."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # of numpy before 2.3 where one is no number
        try:
            return np.fromstring(text, sep=",")
        except ValueError:
            return np.zeros(0)
