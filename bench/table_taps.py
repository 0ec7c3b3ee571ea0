"""The tap test on synthetic recordings: `python -m bench.table_taps 1 401`, of the odd seeds.

A recording a seed: 1 to 8 ridges, 500 to 20,000 samples a second, 10 to 16 bits, in V, mV or counts. Its
channels have gains of 0.5 to 2, a bias, noise, hum and drift. Taps of 20 to 60 ms come 0.3 to 2 s apart, some
are missed or double; those of a recording differ by 15 % in length and about 20 % in strength. None to three
channels are faulty. The amplifiers pass stress, or its rate. The pulse,
the amplifier and the converter are made here in time, by nothing that the judge uses.

How strongly a tap is felt: `mechanics.film_response` gives for 7 templates (29 November 2026) 0.02 to 0.15 of
a tap on the next ridge, 0.17 beside the end, and by a sideways force of the tap -0.7 to 0.7 of it on its own
strips, 0.3 to 0.9 on the next ridge's. Here up to 0.4 is drawn for the next ridge, and a sideways force of
0.15 of the tap.

A recording is right if the state of each channel is. Constants were chosen on even seeds up to 538. Odd seeds
1 to 399, judged once (29 November 2026): 192 of 200 right, none clipped and accepted. Most of the others have
a ridge that nobody tapped beside another fault. Two faults were mended after it.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from dataclasses import dataclass
from time import perf_counter

import numpy as np
from scipy.signal import lfilter

from bench import runner
from skincad.detector import TapTest, tap_test
from skincad.inputs import FilmRecording

FAULTS = "dead", "humming", "swapped", "reversed", "weak", "clipped", "half-wave", "on a rail"
FINE = 20_000.0  # Hz, at which all is made
RANGE = 3.3  # V, of the converter


@dataclass(frozen=True, eq=False)
class Case:
    """A recording, the states by channel that are right, and what it is like."""

    recording: FilmRecording
    right: tuple[set[str], ...]
    kinds: tuple[str, ...]
    words: str


def pulse(draw: np.random.Generator, size: int, shape: int) -> np.ndarray:
    """A tap's force `(size,)`: a half sine, a bell or a blow with a tail, of 1 at its top."""
    x = np.linspace(0, 1, size)
    if shape == 0:
        return np.sin(np.pi * x)
    if shape == 1:
        return np.sin(np.pi * x ** draw.uniform(0.7, 1.4)) ** 2
    rise = draw.uniform(0.15, 0.4)
    blow = (x / rise) ** 2 * np.exp(2 - 2 * x / rise) * (1 - x) ** 0.5
    return blow / blow.max()


def through(draw: np.random.Generator, rate: float, force: np.ndarray) -> np.ndarray:
    """Forces `(n, channels)` at FINE through amplifiers: stress without DC, or its rate, and a low-pass."""
    pole = np.exp(-2 * np.pi * min(draw.uniform(80, 600), 0.3 * rate) / FINE)
    soft = lfilter([1 - pole], [1, -pole], lfilter([1 - pole], [1, -pole], force, axis=0), axis=0)
    if draw.random() < 0.5:
        return np.gradient(soft, axis=0)
    drain = np.exp(-1 / (FINE * np.exp(draw.uniform(np.log(0.1), np.log(3)))))
    return lfilter([1, -1], [1, -drain], soft, axis=0)


def tapped(draw: np.random.Generator, ridges: int) -> tuple[list[int], list[float]]:
    """The ridges of the taps and their times, s: some missed, some double."""
    order = [r for r in range(ridges) for _ in range(1 + (draw.random() < 0.08))]
    if ridges > 2 and draw.random() < 0.15:
        gone = draw.integers(ridges)
        order = [r for r in order if r != gone]
    pace = np.exp(draw.uniform(np.log(0.35), np.log(1.6)))
    return order, [
        float(t) for t in draw.uniform(0.4, 1.2) + np.cumsum(pace * draw.uniform(0.86, 1.25, len(order)))
    ]


def felt(draw: np.random.Generator, ridges: int, on: int, near: float, sign: float) -> np.ndarray:
    """How strongly each strip feels a tap on a ridge `(2, 2 ridges)`: its force from above, 1 on its own
    strips inside the skin, and a sideways force of the tap."""
    rows = np.zeros((2, 2 * ridges))
    for r in range(ridges):
        far = abs(r - on)
        for side in (0, 1):
            c = 2 * r + side
            if far == 0:
                rows[:, c] = 1.0, 0.5 if side else -0.5
            else:
                rows[0, c] = sign * near**far * draw.uniform(0.7, 1.0)
                rows[1, c] = 0.45 * (1 if r > on else -1) * 0.4 ** (far - 1)
        if far == 0 and r in (0, ridges - 1) and ridges > 1:
            rows[0, 2 * r + (1 if r == 0 else 0)] *= draw.uniform(1.0, 1.5)
    return rows


@dataclass
class Board:
    """A converter's steps and rails, and what is done to each channel of `nominal` V."""

    step: float
    bits: int
    rails: tuple[float, float]
    nominal: float
    noise: float
    bias: np.ndarray
    gains: np.ndarray
    hum: np.ndarray
    sees: np.ndarray
    level: np.ndarray  # of the top, at which a rail cuts
    half: np.ndarray  # the sign that passes
    stuck: np.ndarray  # the rail on which it stands
    states: list[set[str]]


def board_of(draw: np.random.Generator, count: int) -> Board:
    """Return a board that works, and clips nothing."""
    bits = int(draw.integers(10, 17))
    step = RANGE / 2**bits
    nominal = RANGE * draw.uniform(max(0.01, 80 / 2**bits), 0.085)
    inside = 0.0 if draw.random() < 0.5 else draw.uniform(0.01, 0.05) * RANGE
    return Board(
        step,
        bits,
        (inside, RANGE - step - inside),
        nominal,
        nominal * np.exp(draw.uniform(np.log(0.001), np.log(0.02))),
        RANGE / 2 * draw.uniform(0.95, 1.05) + draw.normal(0, 0.005 * RANGE, count),
        np.exp(draw.uniform(np.log(0.5), np.log(2), count)) * draw.choice([-1.0, 1.0]),
        nominal * draw.uniform(0, 0.1) * draw.uniform(0, 1, count) * (draw.random() < 0.6),
        np.arange(count),
        np.full(count, np.nan),
        np.zeros(count),
        np.full(count, np.nan),
        [{"works"} for _ in range(count)],
    )


def spoil(draw: np.random.Generator, board: Board) -> tuple[str, ...]:
    """Put none to three faults on a board; one where it has two channels, by which faults are told."""
    count, kinds = board.gains.size, []
    free = list(range(count))
    for _ in range(min(int(draw.integers(0, 4)), 1 if count == 2 else 3)):
        kind = str(draw.choice(FAULTS))
        c = int(draw.choice(free))
        others = [d for d in free if d // 2 != c // 2]
        if kind == "swapped" and not others:
            continue
        free.remove(c)
        kinds.append(kind)
        board.states[c] = {"dead" if kind == "humming" else kind}
        if kind == "swapped":
            near = [d for d in others if abs(d // 2 - c // 2) == 1]
            d = int(draw.choice(near if near and draw.random() < 0.5 else others))
            free.remove(d)
            board.sees[[c, d]] = board.sees[[d, c]]
            board.states[d] = {"swapped"}
        elif kind in ("dead", "humming"):
            board.gains[c] = 0.0
            if kind == "humming":
                board.hum[c] = board.nominal * draw.uniform(0.1, 1.0)
        elif kind == "reversed":
            board.gains[c] *= -1
        elif kind == "weak":
            board.gains[c] = np.sign(board.gains[c]) * draw.uniform(0.06, 0.1)
        elif kind == "clipped":
            board.level[c] = draw.uniform(0.3, 0.93)
        elif kind == "half-wave":
            board.half[c] = draw.choice([-1.0, 1.0])
        else:
            board.stuck[c] = draw.choice(board.rails)
        if len(free) < 2:
            break
    return tuple(kinds)


def converted(draw: np.random.Generator, board: Board, heard: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Return counts `(n, channels)` of answers of about 1; states that nobody can tell are noted."""
    count, low, high = board.gains.size, *board.rails
    volts = board.nominal * board.gains * heard[:, board.sees]
    volts *= min(1.0, 0.35 * RANGE / float(np.abs(volts).max()))  # what is to work is not clipped
    for c in np.flatnonzero(np.isfinite(board.level)):
        top = volts[np.abs(volts[:, c]).argmax(), c]
        if top:
            volts[:, c] *= abs((high if top > 0 else low) - board.bias[c]) / (board.level[c] * abs(top))
    waves = 2 * np.pi * draw.choice([50.0, 60.0]) * draw.uniform(0.997, 1.003) * time[:, None]
    volts += board.hum * np.sin(waves + draw.uniform(0, 6, count))
    volts += 0.2 * board.hum * np.sin(3 * waves + draw.uniform(0, 6, count))
    volts += board.noise * draw.normal(0, 1, volts.shape)
    volts += board.nominal * draw.uniform(-0.1, 0.1, count) * (board.half == 0) * time[:, None] / time[-1]
    for c in np.flatnonzero(board.half):
        volts[:, c] = np.maximum(volts[:, c] * board.half[c], 0.0) * board.half[c]
        board.bias[c] = low if board.half[c] > 0 else high
        if np.abs(volts[:, c]).max() < max(20 * board.noise, 12 * board.step):
            board.states[c] |= {"dead", "on a rail"}  # its own sign is the one that is lost
    volts += board.bias
    stuck = np.isfinite(board.stuck)
    volts[:, stuck] = board.stuck[stuck]
    for c in np.flatnonzero(np.isfinite(board.level)):
        if not ((volts[:, c] < low) | (volts[:, c] > high)).any():
            board.states[c] |= {"works"}
    volts = np.clip(volts, low, high)
    volts += draw.uniform(0, 0.7) * board.step * draw.normal(0, 1, volts.shape) * (draw.random() < 0.7)
    return np.clip(np.round(volts / board.step), 0, 2**board.bits - 1)


def truth(board: Board, missed: set[int]) -> list[set[str]]:
    """Return what can be told of each channel: of a ridge that nobody tapped nothing but a swap, of signs
    which are the fewer."""
    states = list(board.states)
    for c, state in enumerate(states):
        if board.sees[c] // 2 in missed and state != {"on a rail"}:
            states[c] = {"undecided"} | state - {"works", "weak", "reversed"}
    signed = [s for s in states if s & {"works", "reversed", "weak", "swapped", "clipped"}]
    flips = sum("reversed" in s for s in signed)
    other = {"works": "reversed", "reversed": "works", "weak": "reversed"}
    if 2 * flips > len(signed):
        return [{other.get(state, state) for state in right} for right in states]
    return [{"undecided"} if 2 * flips == len(signed) and right & set(other) else right for right in states]


def answers_of(draw: np.random.Generator, rate: float, ridges: int, order: list[int], times: list[float]):
    """Return all strips' answers `(n, strips)` at FINE, the median one 1 at its top."""
    near, sign = draw.uniform(0.03, 0.4), draw.choice([1.0, 1.0, -1.0])
    force = np.zeros((round((times[-1] + draw.uniform(0.4, 1.5)) * FINE), 2 * ridges))
    length, shape = draw.uniform(0.024, 0.052), int(draw.integers(3))  # one person's taps are alike
    strengths = np.clip(np.exp(draw.normal(0, 0.2, len(order))), 0.65, 1.5)
    for ridge, time, strength in zip(order, times, strengths, strict=True):
        above, aside = felt(draw, ridges, ridge, near, sign)
        start, size = round(time * FINE), round(length * draw.uniform(0.85, 1.15) * FINE)
        force[start : start + size] += strength * pulse(draw, size, shape)[:, None] * above
        force[start : start + size] += (
            strength * draw.normal(0, 0.15) * pulse(draw, size, shape)[:, None] * aside
        )
    heard = through(draw, rate, force)
    starts = [round(time * FINE) for time in times]
    tops = [
        np.abs(heard[start : start + round(0.2 * FINE), 2 * ridge : 2 * ridge + 2]).max(axis=0)
        for ridge, start in zip(order, starts, strict=True)
    ]
    return heard / np.median(tops)


def case_of(seed: int) -> Case:
    """Return the recording of a seed, with its truth."""
    draw = np.random.default_rng([60, seed])
    ridges = int(draw.integers(1, 9))
    rate = float(np.exp(draw.uniform(np.log(500), np.log(20_000))))
    order, times = tapped(draw, ridges)
    heard = answers_of(draw, rate, ridges, order, times)
    board = board_of(draw, 2 * ridges)
    kinds = spoil(draw, board)
    time = np.arange(0, heard.shape[0] / FINE, 1 / rate)
    values = converted(draw, board, heard[np.minimum((time * FINE).astype(int), heard.shape[0] - 1)], time)
    unit = str(draw.choice(["V", "mV", "counts", ""]))
    if unit != "counts":
        volts = values * board.step - (RANGE / 2 if draw.random() < 0.3 else 0.0)
        values = np.round(volts * (1000 if unit == "mV" else 1), 6)
    right = truth(board, set(range(ridges)) - set(order))
    strips = tuple((c // 2 + 1, f"S{c % 2 + 1}") for c in range(2 * ridges))
    taps = ", ".join(str(r + 1) for r in order)
    words = f"{ridges} ridges, {rate:.0f} Hz, {board.bits} bits, {unit or 'no unit'}, taps {taps}"
    return Case(FilmRecording(strips, time, values.T, unit=unit), tuple(right), kinds, words)


def off(case: Case, answer: TapTest) -> list[str]:
    """Return what is wrong in an answer, by channel."""
    return [
        f"ridge {c.ridge} {c.side}: {c.state}, not {'/'.join(sorted(right))}"
        for c, right in zip(answer.channels, case.right, strict=True)
        if c.state not in right
    ]


def accepted_clipped(case: Case, answer: TapTest) -> bool:
    """Return whether a recording with a clipped channel passes."""
    return answer.passed and any("clipped" in right for right in case.right)


def row_of(seed: int) -> dict[str, object]:
    """Return whether a seed's answer is right, whether something clipped was accepted, and what is wrong."""
    case = case_of(seed)
    began = perf_counter()
    answer = tap_test(case.recording)
    wrong = off(case, answer)
    return {
        "kind": case.kinds[0]
        if len(case.kinds) == 1
        else f"{len(case.kinds)} faults"
        if case.kinds
        else "no fault",
        "right": not wrong,
        "accepted": accepted_clipped(case, answer),
        "seconds": perf_counter() - began,
        "text": f"{seed} {case.words}, {', '.join(case.kinds) or 'no fault'}: {'; '.join(wrong)}; heard "
        f"{[tap.ridge for tap in answer.taps]}",
    }


def main() -> None:
    parser = runner.parser(__doc__, "first", "stop")
    options = parser.parse_args()
    rows = runner.rows("taps", row_of, range(options.first, options.stop, 2), options)
    tallies: dict[str, Counter[str]] = defaultdict(Counter)
    for row in rows:
        if not row["right"]:
            print(row["text"])
        for group in (row["kind"], "zz all"):
            tallies[group].update(recordings=1, right=row["right"], accepted=row["accepted"])
    print("| faults | recordings | right | clipped and accepted | right, 95 % |\n|---|---|---|---|---|")
    for group, tally in sorted(tallies.items()):
        low, high = runner.wilson(tally["right"], tally["recordings"])
        counts = [tally[name] for name in ("recordings", "right", "accepted")]
        print(f"| {' | '.join([group.removeprefix('zz '), *map(str, counts), f'{low:.0%} to {high:.0%}'])} |")


if __name__ == "__main__":
    main()
