"""A detector as C for a microcontroller: code, weights, test vectors, a sketch, and what it costs there.

The code is C99 in float32. It keeps the running means to more than float32 by carrying what each step loses,
so its odds are Python's within some 1e-5, and its alarms are Python's unless a threshold lies in between.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import cached_property, partial
from typing import Any

import numpy as np
from scipy.signal import lfilter

from skincad.base.errors import InputError
from skincad.base.result import Result, Writer, item, record, reported, reported_from
from skincad.base.version import __version__
from skincad.detector import features
from skincad.detector.detector import AHEAD, BACK, GRIPPER, SEEN, SKIN, Detector, Tuning
from skincad.fabrication.papers import environment
from skincad.outputs.delivery import Presentation, text

CLOCK = 600e6  # Hz, of a Teensy 4.1
SHARE = 0.5  # of it, for the detector
# instructions of a Cortex-M7, all ridges loud, within 5 %: gcc 12.2 -O2 under QEMU (bench/detector_cost.py)
PER_RIDGE = 750.0  # of a sample
# of a decision, by the network that warns: four ridges; one to three more
PER_FOUR, REST = (
    {SKIN: 127e3, GRIPPER: 23e3},
    {SKIN: (0, 47.5e3, 72e3, 103e3), GRIPPER: (0, 7.4e3, 12.4e3, 17.2e3)},
)
UNITS, LANES = 6, 4  # hidden units and ridges that are computed together
WIDEST = 118  # letters of a line of numbers
ROUNDING = 3.3 / 4096 / math.sqrt(6)  # V rms: of a pair, by 12 bits of 3.3 V, each 1 / sqrt(12) of a step
CODE = "skincad_detector"  # a folder, as Arduino wants it: its sketch has its name
NAMES = (
    "README.md", "test_detector.c", "test_vectors.h",
    *(f"{CODE}/{name}" for name in (f"{CODE}.h", f"{CODE}.c", "skincad_weights.h", f"{CODE}.ino")),
)  # fmt: skip
COMMAND = "export"
REST_ROWS, ROWS, WINDOWS, MOST_ROWS = 20, 600, 40, 4000  # of the test vectors
COUNT, BIAS = 0.125, 1000  # noise rms of a step of their inputs, at least; steps that they rest at
MOST_COUNT = 30_000  # steps from there, so that they are C's shorts
MARGIN, SEEDS = 2e-4, 20  # of odds from each threshold, a hundred times float32's rms error; attempts at that
FACTS = {"CODE": CODE, "CLOCK": CLOCK, "SHARE": SHARE, "ROUNDING": ROUNDING}
EVERY_ODDS = 50  # decisions whose odds are test vectors: each so manyth


@record(eq=False)
class DetectorCode(Result):
    """A detector's code in C, and what it costs on a Cortex-M7.

    `tuning` and `ridges` are the detector's as it is made; what it has heard is left out.
    """

    shown_by = "skincad.outputs.detector_code:DETECTOR_CODE"
    name: str = item(meaning="whose films it hears, and behind what")
    ridges: tuple[int, ...] = item(meaning="wired ridges, from 1")
    rate: float = item("Hz", "of the samples")
    tuning: Tuning
    inverted: bool = item(
        meaning="whether the amplifier's pin moves against output_V, so that the sketch turns it"
    )

    noise = reported_from(
        "tuning.noise", "V", "rms of S1 - S2, which alarms are measured by where change_V is null"
    )

    change = reported_from(
        "tuning.change",
        "V",
        "rms of what S1 - S2 changes by from sample to sample, where the detector hears that",
    )

    every = reported_from("tuning.every", meaning="samples from one decision to the next")

    @reported(meaning="values of a sample: S1 and S2 of each ridge")
    def channels(self) -> int:
        """Values of a sample."""
        return 2 * len(self.ridges)

    @reported("ms", "at most, by which deciding at one of `every` samples delays an alarm")
    def delay(self) -> float:
        """Delay of an alarm, ms."""
        return 1e3 * (self.tuning.every - 1) / self.rate

    @reported(meaning="of a Cortex-M7 for a sample, with all ridges loud, a mean over `every`")
    def instructions(self) -> float:
        """Instructions of a Cortex-M7 for a sample."""
        return instructions(len(self.ridges), self.tuning.every, self.tuning.network)

    @property
    def quiet_instructions(self) -> float:
        """Instructions for a sample while no ridge is loud."""
        return PER_RIDGE * len(self.ridges)

    @reported(meaning="instructions in a second over the 600 MHz of a Teensy 4.1")
    def clock_share(self) -> float:
        """Share of the clock's ticks."""
        return self.instructions * self.rate / CLOCK

    @reported(meaning="the smallest `every` with which instructions are half of that, null for none")
    def fitting_every(self) -> int | None:
        """Smallest `every` that fits."""
        return fitting_every(len(self.ridges), self.rate, self.tuning.network)

    @reported(meaning="bytes of constants")
    def constant_bytes(self) -> int:
        """Bytes of the weights."""
        return 4 * sum(w.into.size + w.bias.size + w.out.size + 1 for w in self.tuning.networks)

    @reported(meaning="bytes of one detector's state")
    def state_bytes(self) -> int:
        """Bytes of the structure."""
        count, last = len(self.ridges), 0 if self.tuning.change is None else 1
        flags = count + 1 + last
        return 4 * (4 * count + 120 * count + count + 1 + 2 + last * 2 * count) + -(-flags // 4) * 4

    @cached_property
    def vectors(self) -> dict[str, Any]:
        """Test vectors: see `test_vectors`."""
        return test_vectors(self.ridges, self.rate, self.tuning)


def export(detector: Detector, *, name: str = "a detector made in Python") -> DetectorCode:
    """Return a detector as C code; `skincad.write` writes it into a folder. `name` stands in its words.

        skincad.write(skincad.export(detector), "out/detector")

    What the detector has heard stays here: the code begins at rest. Raises InputError for anything else than
    a Detector.
    """
    if "*/" in name or not name.isprintable():
        raise InputError("name", "must be a line without */: it stands in a comment", name)
    if not isinstance(detector, Detector):
        raise InputError("detector", "must be a Detector", detector, "skincad.Detector(...) gives one")
    return DetectorCode(
        name=name,
        ridges=detector.ridges,
        rate=detector.rate,
        tuning=detector.tuning,
        inverted=detector.inverted,
    )


def instructions(ridges: int, every: int, network: str = SKIN) -> float:
    """Return how many instructions a Cortex-M7 needs for a sample of loud ridges, a mean over `every`."""
    fours, more = divmod(ridges, LANES)
    return PER_RIDGE * ridges + (PER_FOUR[network] * fours + REST[network][more]) / every


def fitting_every(ridges: int, rate: float, network: str = SKIN) -> int | None:
    """Return the smallest `every` with which the code fits in half of 600 MHz; None where none does."""
    means = PER_RIDGE * ridges
    decision, left = instructions(ridges, 1, network) - means, SHARE * CLOCK / rate - means
    return math.ceil(decision / left) if left > 0 else None


def test_vectors(ridges: tuple[int, ...], rate: float, tuning: Tuning) -> dict[str, Any]:
    """Return whole numbers `rest` and `rows` `(n, channels)`, the `volts` of one, the `alarms` (sample, kind,
    ridge) that Python's detector raises of them, and `odds` (sample, log odds...) of some decisions.

    Pulls and presses that run and stop, ridge after ridge, in noise, behind the low-pass. They are drawn anew
    until both kinds of alarm are among them and no odds lie at a threshold, where rounding decides; or SEEDS
    times, and the best are taken.
    """
    count = min(max(ROWS, WINDOWS * tuning.window), MOST_ROWS)
    best: dict[str, Any] = {}
    rank: tuple[bool, int, float] = (False, -1, 0.0)
    for seed in range(SEEDS):
        vectors, margin = _drawn(ridges, rate, tuning, count, np.random.default_rng((60, seed)))
        kinds = len({kind for _, kind, _ in vectors["alarms"]})
        if (margin > MARGIN, kinds, margin) > rank:
            best, rank = vectors, (margin > MARGIN, kinds, margin)
        if rank[:2] == (True, 2 if tuning.network == SKIN else 1):  # a gripper's names no ridge
            break
    return best


def _drawn(
    ridges: tuple[int, ...], rate: float, tuning: Tuning, count: int, draw: np.random.Generator
) -> tuple[dict[str, Any], float]:
    """Vectors of one seed, and how far all odds are from the thresholds. Of a detector that hears changes,
    pulls and presses are the rates of outputs that fade."""
    width, hold = len(ridges), 8 * tuning.window
    pull, press = (np.repeat(draw.normal(0, size, count // hold + 1), hold)[:count] for size in (150, 50))
    late = [np.roll(pull, int(lag)) for lag in draw.integers(0, 3 * tuning.window, width)]
    pair = np.stack(late, axis=1) * draw.uniform(0.4, 1.2, width)
    total = press[:, None] * draw.uniform(0.5, 1.2, width)
    strips = np.stack([total + pair, total - pair], axis=2).reshape(count, 2 * width) / 2
    pole = math.exp(-2 / (tuning.window / 3.5))  # two of them, which delay by the window over 3.5
    for _ in range(2):
        strips = lfilter([1 - pole], [1, -pole], strips, axis=0)
    noise = math.sqrt(0.5)
    if tuning.change is not None:
        strips, noise = lfilter([1], [1, 1 / hold - 1], strips, axis=0), 0.5
    step = max(COUNT, np.abs(strips).max() / MOST_COUNT)
    strips = np.concatenate([np.zeros((REST_ROWS, 2 * width)), strips])
    strips += draw.normal(0, noise, strips.shape)
    rows = np.rint(strips / step).astype(int) + BIAS + 10 * np.arange(2 * width)
    volts = float(np.float32(step * tuning.noise_floor))
    inputs = rows.astype(np.float32) * np.float32(volts)  # as the code has them
    detector = Detector.of(tuning, ridges, rate)
    detector.rest(inputs[:REST_ROWS])
    odds = detector.odds(inputs[REST_ROWS:])
    at = np.arange(tuning.every - 1, count, tuning.every)
    levels = np.append(np.full(width, tuning.threshold), tuning.warning)
    margin = np.abs(np.stack([odds - levels, odds - levels + BACK])).min(initial=math.inf)
    alarms = [
        (alarm.index, int(alarm.kind == AHEAD), alarm.ridge or 0)
        for alarm in detector.feed(inputs[REST_ROWS:])
    ]
    quiet = min(tuning.threshold, tuning.warning) - BACK - 1.0  # which those of what is quiet do not pass
    some = range(EVERY_ODDS // 2, at.size, EVERY_ODDS)
    vectors = {
        "rest": rows[:REST_ROWS],
        "rows": rows[REST_ROWS:],
        "volts": volts,
        "alarms": alarms,
        "odds": [(int(at[i]), *odds[i].tolist()) for i in some],
        "quiet": quiet,
    }
    return vectors, float(margin)


def _files(code: DetectorCode) -> dict[str, Writer]:
    return {name: text(partial(_written, code, name.rpartition("/")[2])) for name in NAMES}


def _written(code: DetectorCode, template: str) -> str:
    """A file of the code."""
    networks, count = code.tuning.networks, features.COUNT
    blocks = [w.into.T.reshape(-1, UNITS, count).transpose(0, 2, 1).ravel() for w in networks]
    facts = {
        "version": __version__,
        "seen": SEEN,
        "features": count,
        "hidden": [w.bias.size for w in networks],
        "units": UNITS,
        "shares": [1.0 / (1.0 + span * code.tuning.window) for span in features.SPANS],
        "base": [w.base for w in networks],
        "bias": np.concatenate([w.bias for w in networks]),
        "out": np.concatenate([w.out for w in networks]),
        "into": np.concatenate(blocks),
        "real": real,
        "lines": lines,
        **FACTS,
    }
    return environment().get_template(f"detector/{template}").render(code=code, tuning=code.tuning, **facts)


def real(value: float) -> str:
    """Return a number as C's float that is the nearest float32, with as few digits as tell it."""
    number = np.float32(value)
    plain = number == 0 or 1e-4 <= abs(number) < 1e7
    form = np.format_float_positional if plain else np.format_float_scientific
    return f"{form(number, unique=True, trim='0')}f"


def lines(values: Iterable[Any]) -> str:
    """Return numbers as C's initialiser, in lines; whole ones as they are."""
    rows, row = [], "   "
    for value in values:
        word = f" {value}," if isinstance(value, int | np.integer) else f" {real(value)},"
        if len(row) + len(word) > WIDEST:
            rows.append(row)
            row = "   "
        row += word
    return "\n".join([*rows, row])


DETECTOR_CODE = Presentation(COMMAND=COMMAND, words="export.txt", writers=_files, facts=FACTS)
