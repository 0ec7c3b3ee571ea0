"""The tap test: which channel hears which ridge, and which channels are faulty, without a prediction.

Tap the ridges in their order, each once, from above, with a blunt point, and wait between taps. A tap presses
its ridge, so both its strips answer with one sign, and those of other ridges answer less. From that alone:

- A channel's strip is that of the ridge at whose tap it answers. Neighbours answer too, taps differ in
  strength and channels in gain. So channels are assigned to ridges together, by the largest product of their
  answers: a factor of a tap or of a channel changes no assignment (Jonker and Volgenant, Computing 38 (1987)
  325, by scipy).
- A channel is reversed where its first swing has another sign than that of most channels.
- A clipped channel has a level at which its values pile up: a smooth top thins out towards its highest value.

What it cannot tell: S1 and S2 of one ridge may have changed places, as a tap presses both alike; whether all
films are reversed; what a ridge that nobody tapped would answer. Range: taps of 20 to 60 ms, 0.3 s or more
apart, from 500 samples a second. How often it is right: `python -m bench.table_taps`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.ndimage import median_filter
from scipy.optimize import linear_sum_assignment

from skincad.base.arrays import Array, Mask
from skincad.base.errors import InputError
from skincad.base.result import Record, Result, item, record, reported
from skincad.detector.detector import Detector
from skincad.detector.wire import Block
from skincad.inputs.recordings import FilmRecording

WORKS, DEAD, SWAPPED, REVERSED, WEAK = "works", "dead", "swapped", "reversed", "weak"
CLIPPED, HALF_WAVE, RAIL, UNDECIDED = "clipped", "half-wave", "on a rail", "undecided"
SLOWEST = 400.0  # Hz: a tap of 20 ms has 8 samples
FASTEST = 2000.0  # Hz, at which taps are looked for; more samples are averaged
REST = 0.5  # s, before the first tap on a port
BASELINE = 0.5  # s, over whose median a channel's level is followed
MAINS = (50.0, 60.0)  # Hz
OFF_MAINS = 0.006  # relative, that the mains may be off
WAVES = (1, 2, 3)  # of the mains that are taken out
LOUD = 7.0  # times its noise, from which on a channel answers
LONG = 0.15  # s: a tap that is louder for longer may be two
APART = 0.12  # s: what is nearer belongs to the same tap
BEFORE, AFTER = 0.02, 0.05  # s, that a tap is looked at beyond what is loud
FAINTEST = 0.02  # of the median tap: what is fainter is none
FIRST_SWING = 0.35  # of the larger one
WEAK_SHARE = 0.19  # of the median answer; assumption: gains of good channels differ by a factor of two
DEAD_SHARE = 0.025  # of it: what a wire beside another hears
ALIKE = 0.9  # cosine of the answers to two taps on one ridge
MISSED, DOUBLE, STRAY = 0.3, 0.15, 2.5  # costs, in answers of a channel: a ridge that was missed, ...
CUT_SHARE = 0.42  # of values at rest that are the end of a range, where half of the noise is cut
SHORT = 0.06  # of a top, that its flanks say is missing
FORCED = 2.5  # times less than at another ridge: no answer to this one, but what was left
OWN = 0.3  # log-likelihood of a channel's own ridge before the taps; assumption: swaps are rare
PILE, FEWEST = 0.34, 3  # as many values in seven steps below a top as in its own; a parabola has 1.8


@record()
class Tap(Record):
    """A tap and its ridge, None where that is unknown."""

    time: float = item("s", "when it begins")
    ridge: int | None = item(meaning="ridge, from 1; null where no ridge fits")


@record()
class ChannelState(Record):
    """What a channel shows; templates/answers/taps.txt says why, and what to do."""

    ridge: int = item(meaning="ridge in its name, from 1")
    side: str = item(meaning="S1 or S2")
    state: str = item(
        meaning="works, dead, swapped, reversed, weak, clipped, half-wave, on a rail or undecided"
    )
    shows: int | None = item(meaning="the ridge at whose tap it answers; null where it answers at none")
    swapped_with: str | None = item(meaning="the channel with which it has changed places, if one fits")
    answer: float | None = item("1", "to that tap, over the median channel's", key="answer")

    @property
    def name(self) -> str:
        """The channel's name for people."""
        return channel_name(self.ridge, self.side)


def channel_name(ridge: int, side: str) -> str:
    """Return a channel's name for people."""
    return f"ridge {ridge} {side}"


@record(eq=False)
class TapTest(Result):
    """What taps say of the channels; `recording` is what was judged."""

    shown_by = "skincad.outputs.measurements:TAPS"
    name: str = item(meaning="of the design or the file")
    channels: tuple[ChannelState, ...] = item(meaning="in the order of the recording")
    taps: tuple[Tap, ...] = item(meaning="in the order of time")
    rate: float = item("Hz", "of the recording")
    warnings: tuple[str, ...] = item(meaning="what to know of the answer")
    recording: FilmRecording = field(compare=False)

    @reported(meaning="whether all channels work")
    def passed(self) -> bool:
        """Whether all channels work."""
        return all(channel.state == WORKS for channel in self.channels)

    @reported(meaning="ridges that were not tapped, or whose films answer to no tap")
    def missed(self) -> tuple[int, ...]:
        """The ridges that no tap was on."""
        return tuple(sorted({channel.ridge for channel in self.channels} - {tap.ridge for tap in self.taps}))

    @reported(meaning="ridges that were tapped more than once")
    def again(self) -> tuple[int, ...]:
        """The ridges with more than one tap."""
        ridges = [tap.ridge for tap in self.taps]
        return tuple(sorted({ridge for ridge in ridges if ridge is not None and ridges.count(ridge) > 1}))

    @property
    def exit_status(self) -> int:
        """0 where all channels work, else 1."""
        return 0 if self.passed else 1


def tap_test(recording: FilmRecording, name: str = "taps") -> TapTest:
    """Return the state of each channel of a recording of taps, ridge after ridge.

    Raises InputError for a recording that is too slow, or without a channel.
    """
    seconds = float(recording.time[-1] - recording.time[0]) if recording.time.size else 0.0
    if seconds < APART:
        raise InputError("recording", f"must be {APART:g} s long or more", seconds, "record all taps")
    rate = recording.rate
    if rate < SLOWEST:
        rule = f"must have at least {SLOWEST:g} samples a second"
        raise InputError("recording", rule, float(f"{rate:.4g}"), "sample faster: a tap takes 20 to 60 ms")
    signals = _signals(recording)
    spans = _spans(signals)
    cut = np.array([_rests_at_end(recording, signals, spans, c) for c in range(len(recording.strips))])
    answers = _answers(signals, spans, cut)
    ridges = _ridges(answers, recording.strips)
    shows = _assigned(answers, ridges, recording.strips, cut)
    evidence = _Evidence(recording, signals, spans, answers, ridges, shows, cut)
    channels = tuple(evidence.channel(c) for c in range(len(recording.strips)))
    taps = tuple(
        Tap(time=float(signals.time[a] + recording.time[0]), ridge=ridge)
        for (a, _), ridge in zip(spans, ridges, strict=True)
    )
    return TapTest(
        name=name, channels=channels, taps=taps, rate=rate, warnings=recording.notes, recording=recording
    )


def hear_taps(detector: Detector, blocks: Iterable[Block], tell: Callable[[str], None]) -> FilmRecording:
    """Return the recording of a stream that ends REST s after as many taps as it has ridges, or by Ctrl-C.

    `tell` gets what a person is to do, and what was heard. Nothing may touch the skin in the first REST s.
    """
    ridges, rate, parts = detector.ridges, detector.rate, list[Block]()
    level, noise, quiet, taps = np.zeros(0), np.zeros(0), 0, 0
    tell(f"Keep off the skin for {REST:g} s.")
    try:
        for block in blocks:
            parts.append(block)
            values = block.values
            if level.size == 0:
                rest = np.concatenate([part.values for part in parts])
                if rest.shape[0] >= REST * rate:
                    level, noise = rest.mean(axis=0), rest.std(axis=0) + 1e-12
                    tell(f"Tap ridge {ridges[0]}.")
                continue
            follow = min(1.0, values.shape[0] / (BASELINE * rate))
            level = level + follow * (np.median(values, axis=0) - level)
            loudness = np.abs(values - level) / noise
            loud = np.flatnonzero(loudness.max(axis=1) > 2 * LOUD)
            if loud.size and (taps == 0 or quiet + loud[0] > APART * rate):
                taps += 1
                name = channel_name(*detector.channels[int(loudness.max(axis=0).argmax())])
                then = f"Tap ridge {ridges[taps]}." if taps < len(ridges) else "That was the last one."
                tell(f"Heard, most of all by {name}. {then}")
            quiet = values.shape[0] - 1 - int(loud[-1]) if loud.size else quiet + values.shape[0]
            if taps >= len(ridges) and quiet > REST * rate:
                break
    except KeyboardInterrupt:
        if not parts:
            raise
    if not parts:
        raise InputError("recording", "has no samples", remedy="see to the board's power and program")
    values = np.concatenate([part.values for part in parts])
    lost = sum(part.gap + sum(count for count, _ in part.lost) for part in parts)
    notes = (f"{lost} samples were lost on the way",) if lost else ()
    return FilmRecording(detector.channels, np.arange(values.shape[0]) / rate, values.T.copy(), notes)


@dataclass(frozen=True, eq=False)
class _Signals:
    """Channels `(channels, m)` at `rate` Hz without their levels and hum, in the recording's unit; `noise`
    `(channels,)` rms, `step` of the converter, `level` the median of what was recorded."""

    time: Array
    values: Array
    rate: float
    noise: Array
    step: Array
    level: Array


def _signals(recording: FilmRecording) -> _Signals:
    width = max(1, int(recording.rate / FASTEST))
    count = recording.time.size // width
    time = recording.time[: count * width].reshape(count, width).mean(axis=1) - recording.time[0]
    means = recording.values[:, : count * width].reshape(-1, count, width).mean(axis=2)
    rate = recording.rate / width
    step = np.array([_step(row) for row in recording.values])
    level = np.median(means, axis=1)
    values = _without_hum(time, means - level[:, None])
    coarse = max(1, int(rate * 0.01))
    parts = count // coarse
    slow = values[:, : parts * coarse].reshape(values.shape[0], parts, coarse).mean(axis=2)
    size = min(2 * int(BASELINE / 0.02) + 1, 2 * (parts // 2) + 1)
    slow = median_filter(slow, size=(1, size), mode="nearest")
    middles = (np.arange(parts) + 0.5) * coarse
    values = np.array(
        [row - np.interp(np.arange(count), middles, base) for row, base in zip(values, slow, strict=True)]
    )
    low, high = np.quantile(values, [0.1, 0.9], axis=1)
    noise = np.maximum(1.4826 * np.median(np.abs(values), axis=1), (high - low) / 2.563)
    return _Signals(time, values, rate, np.maximum(noise, 0.5 * step / np.sqrt(width)), step, level)


def _step(row: Array) -> float:
    """The converter's step: the smallest difference of two values, 0 of a constant."""
    some = np.unique(row[:: max(1, row.size // 20_000)])
    steps = np.diff(some)
    steps = steps[steps > 1e-9 * max(float(np.abs(some).max()), 1e-300)]
    return float(steps.min()) if steps.size else 0.0


def _without_hum(time: Array, values: Array) -> Array:
    """The values without the mains' waves, if there are any, fitted where nothing is loud."""
    span = float(time[-1] - time[0])
    if span < 0.3:
        return values
    slow = values - values.mean(axis=1, keepdims=True)
    size = 1.4826 * np.median(np.abs(slow), axis=1, keepdims=True) + 1e-300
    quiet = (np.abs(slow) < 5 * size).all(axis=0)
    still = np.where(quiet, slow / size, 0.0)
    if quiet.sum() < 0.3 * time.size:
        return values
    size = max(1, round(0.004 * time.size / span))
    count = time.size // size
    coarse = still[:, : count * size].reshape(-1, count, size).sum(axis=2)
    at = time[: count * size].reshape(count, size).mean(axis=1)

    def power(f: float) -> float:
        return float((np.abs(coarse @ np.exp(-2j * np.pi * f * at)) ** 2).sum())

    step = min(0.25 / span, OFF_MAINS * MAINS[0])
    grid = [
        f for mains in MAINS for f in np.arange(mains * (1 - OFF_MAINS), mains * (1 + OFF_MAINS) + step, step)
    ]
    best = max(grid, key=power)
    best = max(best + step * np.linspace(-1, 1, 41), key=power)
    angles = [2 * np.pi * best * k * time for k in WAVES]
    waves = np.stack([np.ones_like(time), *(w(a) for a in angles for w in (np.sin, np.cos))], axis=1)
    parts = np.linalg.lstsq(waves[quiet], values[:, quiet].T, rcond=None)[0]
    return np.asarray(values - (waves[:, 1:] @ parts[1:]).T)


def _spans(signals: _Signals) -> list[tuple[int, int]]:
    """First and last sample of each tap."""
    alive = signals.noise > 0
    if not alive.any():
        return []
    loudness = np.abs(signals.values[alive] / signals.noise[alive, None])
    loudest = loudness.max(axis=0)
    at = np.flatnonzero(loudest > LOUD)
    if at.size == 0:
        return []
    cuts = np.flatnonzero(np.diff(at) > APART * signals.rate)
    firsts, lasts = at[np.concatenate([[0], cuts + 1])], at[np.concatenate([cuts, [at.size - 1]])]
    spans = [
        part
        for a, b in zip(firsts, lasts, strict=True)
        for part in _parts(loudest, int(a), int(b), signals.rate)
        if part[1] > part[0]
    ]
    peaks = np.array([loudness[:, a : b + 1].max() for a, b in spans])
    return [span for span, peak in zip(spans, peaks, strict=True) if peak > FAINTEST * np.median(peaks)]


def _parts(loudest: Array, first: int, last: int, rate: float) -> list[tuple[int, int]]:
    """The taps in a stretch that is loud all along: an amplifier's tail may reach to the next tap."""
    limit, most = 2 * LOUD, float(loudest[first : last + 1].max())
    while last - first > LONG * rate and limit < 0.3 * most:
        at = first + np.flatnonzero(loudest[first : last + 1] > limit)
        cuts = np.flatnonzero(np.diff(at) > APART * rate)
        if cuts.size:
            edges = [
                *zip(np.concatenate([[0], cuts + 1]), np.concatenate([cuts, [at.size - 1]]), strict=True)
            ]
            return [part for a, b in edges for part in _parts(loudest, int(at[a]), int(at[b]), rate)]
        limit *= 1.5
    return [(first, last)]


def _window(signals: _Signals, span: tuple[int, int]) -> slice:
    first = max(0, span[0] - int(BEFORE * signals.rate))
    return slice(first, min(signals.values.shape[1], span[1] + 1 + int(AFTER * signals.rate)))


@dataclass(frozen=True, eq=False)
class _Answers:
    """Signed answers `(taps, channels)` in the recording's unit, positive for the first swing up; `error`
    theirs, `shapes` the taps' own course in time, of 1 at its top."""

    sizes: Array
    error: Array
    shapes: list[Array]

    @property
    def heard(self) -> Mask:
        """Where an answer stands out of the noise `(taps, channels)`."""
        return np.asarray(np.abs(self.sizes) > 4 * self.error)


def _answers(signals: _Signals, spans: Sequence[tuple[int, int]], cut: Mask) -> _Answers:
    """The answers by the course that all channels share: the first singular vector of a tap."""
    count = signals.values.shape[0]
    scale = np.array(
        [
            max((np.abs(signals.values[c, a : b + 1]).max() for a, b in spans), default=0.0)
            for c in range(count)
        ]
    )
    loud = scale > LOUD * signals.noise
    whole = loud & ~cut if (loud & ~cut).any() else loud  # half a course tells no first swing
    scale = np.where(whole, scale, np.inf)
    sizes, error, shapes = np.zeros((len(spans), count)), np.ones((len(spans), count)), []
    for k, span in enumerate(spans):
        part = signals.values[:, _window(signals, span)]
        _, _, rows = np.linalg.svd(part / scale[:, None], full_matrices=False)
        shape = rows[0] / np.abs(rows[0]).max()
        first = shape[np.argmax(np.abs(shape) > FIRST_SWING)]
        shape = shape * np.sign(first)
        power = float(shape @ shape)
        sizes[k], error[k] = part @ shape / power, signals.noise / np.sqrt(power)
        shapes.append(shape)
    return _Answers(sizes, error, shapes)


def _shares(answers: _Answers) -> Array:
    """Answers `(taps, channels)` over the channel's largest one, 0 where nothing is heard."""
    sizes = np.where(answers.heard, np.abs(answers.sizes), 0.0)
    return np.asarray(sizes / np.maximum(sizes.max(axis=0, initial=0.0), 1e-300))


def _ridges(answers: _Answers, strips: Sequence[tuple[int, str]]) -> list[int | None]:
    """The ridge of each tap: the ridges' order, with as few missed, doubled and stray taps as channels allow.

    Dynamic programming over taps; a ridge's score at a tap is the sum of its channels' shares.
    """
    shares, numbers = _shares(answers), sorted({ridge for ridge, _ in strips})
    if not shares.shape[0]:
        return []
    loudest = np.abs(answers.sizes * answers.heard).max(axis=0)
    weight = np.minimum(1.0, loudest / np.median(loudest[loudest > 0])) if loudest.any() else loudest
    pattern = shares * weight  # a strip that nobody tapped answers as a neighbour, now more, now less
    lengths = np.linalg.norm(pattern, axis=1) + 1e-300
    alike = (pattern @ pattern.T) / np.outer(lengths, lengths)
    best = shares.argmax(axis=0)
    beside = np.where(alike[best].T > ALIKE, 0.0, shares).max(
        axis=0
    )  # such a strip answers to two ridges alike
    own = np.array([[ridge == number for ridge, _ in strips] for number in numbers], float)
    score = shares @ (own * weight * (1.0 - beside)).T  # (taps, ridges)
    taps, count = score.shape
    # paths[k][r, p]: taps up to k, the last one that is no stray was p on ridge r; r = -1 before any
    paths: list[dict[tuple[int, int], tuple[float, tuple[int, int] | None]]] = [{(-1, -1): (0.0, None)}]
    for k in range(taps):
        row: dict[tuple[int, int], tuple[float, tuple[int, int] | None]] = {}

        def offer(at: tuple[int, int], value: float, from_: tuple[int, int]) -> None:
            if at not in row or value > row[at][0]:  # noqa: B023
                row[at] = value, from_  # noqa: B023

        for (last, tap), (value, _) in paths[-1].items():
            offer((last, tap), value - STRAY, (last, tap))
            if last >= 0 and alike[tap, k] > ALIKE:
                offer((last, k), value + score[k, last] - DOUBLE, (last, tap))
            for r in range(last + 1, count):
                offer((r, k), value + score[k, r] - MISSED * (r - last - 1), (last, tap))
        paths.append(row)
    at = max(paths[-1], key=lambda key: paths[-1][key][0] - MISSED * (count - 1 - key[0]))
    ridges: list[int | None] = []
    for k in range(taps, 0, -1):
        before = paths[k][at][1]
        assert before is not None
        ridges.append(numbers[at[0]] if at != before else None)
        at = before
    return ridges[::-1]


def _by_ridge(answers: _Answers, ridges: Sequence[int | None], number: int) -> Array:
    """A ridge's largest answers `(channels,)`, of all its taps."""
    rows = [np.abs(answers.sizes[k]) for k, ridge in enumerate(ridges) if ridge == number]
    return np.asarray(np.max(rows, axis=0))


def _assigned(
    answers: _Answers, ridges: Sequence[int | None], strips: Sequence[tuple[int, str]], cut: Mask
) -> list[int | None]:
    """The ridge that each channel shows; None where it answers nowhere, or as others' neighbour alone."""
    count = len(strips)
    tapped = sorted({ridge for ridge in ridges if ridge is not None})
    shows: list[int | None] = [None] * count
    if not tapped:
        return shows
    sizes = np.array([_by_ridge(answers, ridges, ridge) for ridge in tapped])
    most = np.where(answers.heard.any(axis=0), sizes.max(axis=0), 0.0)
    for c in np.flatnonzero(cut & (most > 0)):
        shows[c] = tapped[int(sizes[:, c].argmax())]
    alive = np.flatnonzero((most > 0) & ~cut)
    if alive.size == 0:
        return shows
    alive = alive[most[alive] > DEAD_SHARE * np.quantile(most[alive], 0.25)]
    sizes = sizes[:, alive]
    floor = np.min(answers.error[:, alive], axis=0)
    logs = np.log(np.maximum(sizes, floor) / floor)
    logs = _balanced(logs)
    slots = [r for r, ridge in enumerate(tapped) for number, _ in strips if number == ridge]
    prefer = np.array([[OWN * (strips[c][0] == tapped[r]) for r in slots] for c in alive])
    prefer += np.log(sizes.max(axis=0) / np.median(sizes.max(axis=0)))[:, None]  # neighbours yield
    rows, places = linear_sum_assignment(-(logs[slots].T + prefer))
    for row, place in zip(rows, places, strict=True):
        most_at = int(sizes[:, row].argmax())
        forced = strips[alive[row]][0] != tapped[slots[place]]
        forced = forced and sizes[slots[place], row] < sizes[most_at, row] / FORCED
        shows[int(alive[row])] = tapped[most_at if forced else slots[place]]
    return shows


def _balanced(logs: Array) -> Array:
    """Logarithms of answers `(ridges, channels)` whose largest of each channel and of each ridge is 0: taps'
    strengths and channels' gains taken off."""
    for _ in range(3):
        logs = logs - logs.max(axis=0)
        logs = logs - np.clip(logs.max(axis=1), np.log(0.5), 0.0)[:, None]
    return logs


def _still(recording: FilmRecording, signals: _Signals, spans: Sequence[tuple[int, int]]) -> Mask:
    """Where nobody taps `(samples,)`."""
    times = recording.time - recording.time[0]
    still = np.ones(times.size, bool)
    for a, b in spans:
        first, last = np.searchsorted(times, signals.time[[a, b]] + [-0.03, 0.15])
        still[first:last] = False
    return still if still.sum() > 50 else ~still


def _rests_at_end(
    recording: FilmRecording, signals: _Signals, spans: Sequence[tuple[int, int]], c: int
) -> bool:
    """Whether a channel's noise is cut: at rest about half of its values are the end of its range, the others
    spread to one side."""
    row, step = recording.values[c], float(signals.step[c])
    rest = row[_still(recording, signals, spans)]
    if step == 0.0:
        return False
    for sign in (1, -1):
        above = (sign * rest - (sign * row).min()) / step
        if (above < 0.5).mean() > CUT_SHARE and (above > 1.5).mean() > 0.03:
            return True
        pile = int((above < 3.5).sum())  # the converter's own noise blurs the end
        if (
            pile > CUT_SHARE * above.size
            and pile > 3 * int(((above > 3.5) & (above < 7.5)).sum())
            and np.quantile(above, 0.98) > 9
        ):
            return True
    return False


@dataclass(frozen=True, eq=False)
class _Evidence:
    """What a recording's taps show of its channels, and the states that follow."""

    recording: FilmRecording
    signals: _Signals
    spans: Sequence[tuple[int, int]]
    answers: _Answers
    ridges: Sequence[int | None]
    shows: Sequence[int | None]
    cut: Mask

    @cached_property
    def tapped(self) -> set[int]:
        """The ridges that a tap was on."""
        return {ridge for ridge in self.ridges if ridge is not None}

    @cached_property
    def best(self) -> list[int | None]:
        """The tap of each channel's answer: the largest on the ridge that it shows."""
        taps = [
            [k for k, ridge in enumerate(self.ridges) if ridge is not None and ridge == shown]
            for shown in self.shows
        ]
        return [
            max(of, key=lambda k, c=c: abs(self.answers.sizes[k, c]), default=None)  # type: ignore[misc]
            for c, of in enumerate(taps)
        ]

    @cached_property
    def size(self) -> Array:
        """The answers `(channels,)`, 0 without."""
        sizes = self.answers.sizes
        return np.array([0.0 if k is None else abs(float(sizes[k, c])) for c, k in enumerate(self.best)])

    @cached_property
    def half(self) -> list[bool]:
        """Which channels pass one sign alone."""
        return [self._half_wave(c) for c in range(len(self.shows))]

    @cached_property
    def clipped(self) -> list[bool]:
        """Which channels are clipped."""
        return [not half and self._clipped(c) for c, half in enumerate(self.half)]

    @cached_property
    def median(self) -> float:
        """The median answer, of whole ones if there are any."""
        answers = self.size > 0
        whole = answers & ~np.array(self.half) & ~np.array(self.clipped)
        return float(np.quantile(self.size[whole if whole.any() else answers], 0.6)) if answers.any() else 0.0

    def _usual(self, c: int) -> float:
        """The usual answer: the median, and as much that of the strip beside, which felt the same tap."""
        ridge = self.recording.strips[c][0]
        beside = [
            float(self.size[d])
            for d, (other, _) in enumerate(self.recording.strips)
            if other == ridge == self.shows[d] and d != c and not self.half[d] and not self.clipped[d]
        ]
        fair = [size for size in beside if size > 0.25 * self.median]
        return float(np.sqrt(self.median * fair[0])) if fair else self.median

    @cached_property
    def signs(self) -> Array:
        """The signs `(channels,)` of first swings, 0 where there is none."""
        sizes = self.answers.sizes
        signs = np.array([0.0 if k is None else np.sign(sizes[k, c]) for c, k in enumerate(self.best)])
        return np.where(np.array(self.half) | (self.size < DEAD_SHARE * self.median), 0.0, signs)

    def channel(self, c: int) -> ChannelState:
        """Return a channel's state."""
        ridge, side = self.recording.strips[c]
        state, partner = self.state(c), self._partner(c)
        other = channel_name(*self.recording.strips[partner]) if partner is not None else None
        return ChannelState(
            ridge=ridge,
            side=side,
            state=state,
            shows=self.shows[c],
            swapped_with=other if state == SWAPPED else None,
            answer=float(self.size[c] / self.median) if self.shows[c] is not None else None,
        )

    def state(self, c: int) -> str:
        """Return the first state whose sign a channel shows."""
        ridge, shown, majority = self.recording.strips[c][0], self.shows[c], np.sign(self.signs.sum())
        silent = shown is None or self.size[c] < DEAD_SHARE * self.median
        elsewhere = ridge in self.tapped and not silent and shown != ridge
        states = {
            RAIL: bool(self.median) and silent and self._stands(c) and self._at_rail(c),
            HALF_WAVE: self.half[c],
            CLIPPED: self.clipped[c],
            SWAPPED: self._partner(c) is not None or elsewhere,
            UNDECIDED: ridge not in self.tapped or (majority == 0 and not silent),
            DEAD: silent,
            REVERSED: self.signs[c] != majority,
            WEAK: self.size[c] < WEAK_SHARE * self._usual(c),
        }
        return next((state for state, shows in states.items() if shows), WORKS)

    def _partner(self, c: int) -> int | None:
        """The channel with which one has changed places."""
        strips, mine = self.recording.strips, self.recording.strips[c][0]
        for d, (ridge, _) in enumerate(strips):
            if ridge == mine or self.half[d]:
                continue
            gives, takes = self.shows[d] == mine, self.shows[c] == ridge
            if gives and takes:
                return d
            # a strip of a ridge that nobody tapped answers as a neighbour alone
            if takes and self._faint(d, mine) and self._own(c):
                return d
            if gives and self._faint(c, ridge) and self._own(d):
                return d
        return None

    def _own(self, c: int) -> bool:
        """Whether a channel's answer is that of a strip to its own ridge, not of a neighbour's."""
        k = self.best[c]
        others = [j for j, ridge in enumerate(self.ridges) if k is not None and ridge != self.ridges[k]]
        most = np.abs(self.answers.sizes[others, c]).max(initial=0.0)
        return bool(self.size[c] > 0.5 * self.median and most < 0.45 * self.size[c])

    def _faint(self, c: int, ridge: int) -> bool:
        """Whether a channel may show the strip of a ridge that was not tapped."""
        strips, mine = self.recording.strips, self.recording.strips[c][0]
        clear = np.abs(self.answers.sizes[:, c]) > np.maximum(
            8 * self.answers.error[:, c], DEAD_SHARE * self.median
        )
        elsewhere = any(r == self.shows[c] and self.shows[d] == mine for d, (r, _) in enumerate(strips))
        return ridge not in self.tapped and bool(clear.any()) and self.shows[c] != mine and not elsewhere

    def _stands(self, c: int) -> bool:
        """Whether a channel has no noise but its converter's."""
        return bool(self.signals.noise[c] <= 1.5 * self.signals.step[c])

    def _at_rail(self, c: int) -> bool:
        """Whether a silent channel stands farther off the others' levels than their swings reach."""
        level = self.signals.level
        others = [d for d, shown in enumerate(self.shows) if shown is not None and d != c]
        if not others:
            return False
        values, middle = self.recording.values, float(np.median(level[others]))
        reach = max(
            (float(np.abs(values[d] - level[d]).max()) for d in [c, *others] if not self.cut[d]), default=0.0
        )
        spread = float(np.median(np.abs(level[others] - middle)))
        return abs(float(level[c]) - middle) > max(0.8 * reach, 10 * spread)

    def _reference(self, k: int, c: int) -> Array:
        """The course of a tap in the other channels, 1 at its first large swing's top."""
        window = _window(self.signals, self.spans[k])
        sizes = self.answers.sizes[k].copy()
        use = (np.abs(sizes) > 30 * self.signals.noise) & (self.signals.noise > 0) & ~self._at_end
        use[c] = False
        weights = np.where(use, sizes, 0.0) / np.where(use, self.signals.noise, 1.0) ** 2
        course = weights @ self.signals.values[:, window]
        top = float(np.abs(course).max())
        return np.asarray(course / top if top > 0 else course)

    def _half_wave(self, c: int) -> bool:
        """Whether a channel rests at an end of its range: its noise is cut there, or swings that others have
        are missing."""
        k = self.best[c]
        if k is None:
            return bool(self.cut[c])
        step = float(self.signals.step[c])
        return bool(self._at_end[c]) or any(
            self._rests_near(c, sign) and self._lacks(c, k, -sign, 6 * step) for sign in (1, -1)
        )

    @cached_property
    def _at_end(self) -> Mask:
        """Which channels rest at an end of their range `(channels,)`, by their noise or their level."""
        return np.array(
            [
                cut or (self._at_rail(c) and any(self._rests_near(c, sign) for sign in (1, -1)))
                for c, cut in enumerate(self.cut)
            ]
        )

    def _rests_near(self, c: int, sign: int) -> bool:
        """Whether a channel never goes below (1) or above (-1) its rest by more than its noise."""
        rest, row = self._resting(c), self.recording.values[c]
        step = float(self.signals.step[c])
        return bool((sign * rest).min() - (sign * row).min() < 2 * step)

    def _lacks(self, c: int, k: int, side: int, least: float) -> bool:
        """Whether a channel lacks swings to a `side` that others have, where they would be `least` high."""
        course = self._reference(k, c)
        y = side * self.signals.values[c, _window(self.signals, self.spans[k])]
        course = course * np.sign(y @ course)  # what is there is below 0
        there, other = course < -0.1, course > 0.1
        clear = np.abs(self.answers.sizes[k]) > 30 * self.signals.noise
        if there.sum() < 2 or other.sum() < 2 or (clear & ~self._at_end).sum() < 3:  # two others at least
            return False
        slope = float(y[there] @ course[there]) / float(course[there] @ course[there])
        expected = slope * float(course[other].mean())
        if float(course.max()) < 0.25 * float(-course.min()):
            return False
        return expected > max(least, 6 * self.signals.noise[c]) and float(y[other].mean()) < 0.2 * expected

    @cached_property
    def _still(self) -> Mask:
        return _still(self.recording, self.signals, self.spans)

    def _resting(self, c: int) -> Array:
        return np.asarray(self.recording.values[c][self._still])

    def _clipped(self, c: int) -> bool:
        if self.best[c] is None:
            return False
        row, step, level = self.recording.values[c], self.signals.step[c], self.signals.level[c]
        times = self.recording.time - self.recording.time[0]
        near = np.zeros(row.size, bool)
        for span in self.spans:
            window = _window(self.signals, span)
            first, last = np.searchsorted(times, self.signals.time[[window.start, window.stop - 1]])
            near[first:last] = True
        part = row[near] - level
        noise = self.signals.noise[c] * max(1.0, np.sqrt(self.recording.rate / self.signals.rate))
        most = float(np.abs(part).max())
        for side in (part, -part):
            top = float(side.max())
            if top < max(0.3 * most, 12 * step, 6 * noise):
                continue
            if self.recording.unit == "counts" and _is_end(
                row, round(level + (top if side is part else -top))
            ):
                return True
            width = step
            while width <= max(0.02 * top, step):
                gap = top - side + 0.5 * step
                first, beside = int((gap < width).sum()), int(((gap >= width) & (gap < 8 * width)).sum())
                # noise as wide as the bins makes piles by chance, unless they are one value of a converter
                alone = width < 1.01 * step or width < 0.25 * noise
                least = FEWEST if width > 1.5 * noise else 2 * FEWEST if alone else 3 * FEWEST
                if first >= least and beside <= PILE * first:
                    return True
                width *= 2
            few = int((side > 0.8 * top).sum()) <= 6
            if (
                few
                and self.recording.rate == self.signals.rate
                and self._short(c, 1 if side is part else -1, top)
            ):
                return True
        return False

    def _short(self, c: int, side: int, top: float) -> bool:
        """Whether a channel's top is lower than its flanks and the other channels' course say."""
        k = self.best[c]
        assert k is not None
        course = self._reference(k, c)
        y = self.signals.values[c, _window(self.signals, self.spans[k])]
        at = int(np.argmax(side * y))
        level = side * float(y[at])
        beside = max((i for i in (at - 1, at + 1) if 0 <= i < y.size), key=lambda i: side * y[i])
        step, noise = float(self.signals.step[c]), float(self.signals.noise[c])
        flank = (np.abs(course) > 0.1) & (np.abs(course) < 0.8)
        if level - side * y[beside] > 3.5 * step or level < top - 3 * (step + noise) or flank.sum() < 3:
            return False
        slope = float(y[flank] @ course[flank]) / float(course[flank] @ course[flank])
        expected = side * slope * course[[at, beside]]
        least = max(SHORT * level, 4 * noise)
        return bool(
            (expected - level > least).all() and abs(expected[0] - expected[1]) > max(15 * step, 3 * noise)
        )


def _is_end(row: Array, count: int) -> bool:
    """Whether a count is the first or the last of a converter, by all the counts of a channel."""
    if count >= 255:
        return count & (count + 1) == 0
    return count == 0 if row.min() >= 0 else count <= -128 and -count & (-count - 1) == 0
