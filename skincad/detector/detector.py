"""Slip felt from the films' outputs alone: which ridge slips, and whether gross slip is ahead. No look-ahead.

Small networks (one hidden layer each, their weights as data) hear what each monitored ridge and those beside
it felt over short and long times (features.py). One tells of each ridge how likely it slips. Another tells
how likely gross slip is ahead, by the mean of what it says of each ridge. They were fitted to the design set
of bench/exam: scenes of random skins, frictions and histories. A third, a quarter as large, warns a gripper
that its grip is too weak: that the load is about to exceed what friction bears, or that all slides. It was
fitted to lifts, with raises of the grip in them (bench/lifts), and names no ridge. An alarm asks for more
than a threshold, which is the user's choice (POINTS), and for outputs that stand out of the noise.

Range: outputs that follow the stress-rate in their band; more monitored ridges are better. Where an amplifier
tells the stress itself, the third network hears what the outputs change by from sample to sample. None of the
networks knows friction or the plate's forces: a pull that eases just before gross slip feels like one that
goes on.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from skincad.base.arrays import Array, Index, Mask
from skincad.base.errors import InputError, did_you_mean
from skincad.circuit.model import Circuit, circuit_network, fitted, load_circuit
from skincad.circuit.network import Network
from skincad.circuit.rails import sign
from skincad.circuit.response import tells_stress
from skincad.circuit.state import PASS, delay, rms_behind
from skincad.detector import features as hearing
from skincad.inputs.catalog import load_design
from skincad.inputs.design import Design
from skincad.shape.skin import skin_of

WINDOW = 3.5  # of the low-pass's delay; assumption
FEWEST = 3  # samples of a window
SEEN = 5.0  # noise rms of a pair, a window's mean, below which there is no alarm: noise alone reaches 2.9
PIECE = 1000  # samples of a ridge that are heard at once: 0.8 MB of hidden values; assumption of a cache
LOUDEST = 1e9  # noise rms, as the code in C has it: beyond, squares are no numbers of a float32
SLOWEST = 0.1  # Hz: noise below is taken out with the resting voltage; assumption

INCIPIENT, AHEAD = "incipient slip", "gross slip ahead"
RIDGES, SKIN, GRIPPER = "weights_ridges.toml", "weights_skin.toml", "weights_grip.toml"


@dataclass(frozen=True)
class OperatingPoint:
    """A choice of alarms: a ridge is told to slip above the logarithm of odds `threshold`, gross slip to be
    ahead above `warning`, until BACK below; `network` is the file of the one that warns.

    Of the lifts of bench/lifts, whose gripper grips harder at each alarm: the share `held` with a slide below
    1 mm, with its 95 % interval `held_between`, and the mean `grip` over the least that holds. Of pulls that
    may end in gross slip, behind a transimpedance amplifier with all ridges monitored: the share of gross
    slips `warned` of, with `between`, and false warnings a minute of handling, all (`false`) and those while
    nothing slips (`idle`); None of GRIP, which was never asked that.
    """

    threshold: float
    warning: float
    held: float
    held_between: tuple[float, float]
    grip: float
    warned: float | None = None
    between: tuple[float, float] | None = None
    false: float | None = None
    idle: float | None = None
    network: str = SKIN


BACK = 1.0
SURE, EARLY, GRIP = "sure", "early", "grip"
POINTS = {
    SURE: OperatingPoint(
        threshold=4.0, warning=2.5, held=0.37, held_between=(0.28, 0.47), grip=0.89,
        warned=0.57, between=(0.50, 0.64), false=77.0, idle=13.0,
    ),
    EARLY: OperatingPoint(
        threshold=2.5, warning=1.25, held=0.54, held_between=(0.44, 0.63), grip=1.04,
        warned=0.70, between=(0.63, 0.77), false=196.0, idle=54.0,
    ),
    GRIP: OperatingPoint(
        threshold=-0.3, warning=-0.3, held=0.87, held_between=(0.82, 0.90), grip=1.32, network=GRIPPER
    ),
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class Weights:
    """The network: of `(features,)` to `(hidden,)`, and of these to one."""

    into: Array
    bias: Array
    out: Array
    base: float


SILENT = -100.0  # odds' logarithm of what no network hears


@cache
def weights(file: str) -> Weights:
    """Return a network's weights as fitted by bench/exam/fitting.py or bench/lifts/fitting.py; the head of
    its file says to what. Of no file (""): those of a network without units, which is SILENT."""
    if not file:
        return Weights(np.zeros((hearing.COUNT, 0)), np.zeros(0), np.zeros(0), SILENT)
    table = tomllib.loads((Path(__file__).parent / file).read_text())
    into = np.ascontiguousarray(np.array(table["into"]).T)
    return Weights(into, np.array(table["bias"]), np.array(table["out"]), float(table["base"]))


@dataclass(frozen=True)
class Tuning:
    """`window` samples, `noise` V rms of a pair; alarms at the logarithms of odds `threshold` and `warning`,
    those of SURE if not given; the networks are asked at one of `every` samples; `network` is the file of the
    one that warns. With `change`, V rms, the detector hears what outputs change by from sample to sample, and
    that is the noise of a pair's changes; without, it hears the outputs."""

    window: int
    noise: float
    threshold: float = POINTS[SURE].threshold
    warning: float = POINTS[SURE].warning
    every: int = 1
    network: str = SKIN
    change: float | None = None

    @property
    def noise_floor(self) -> float:
        """The noise of what the detector hears of a pair, V rms."""
        return self.noise if self.change is None else self.change

    @property
    def networks(self) -> tuple[Weights, Weights]:
        """The networks of a ridge that slips, and of the warning; GRIPPER's names no ridge."""
        return weights(RIDGES if self.network == SKIN else ""), weights(self.network)

    def __post_init__(self) -> None:
        for key, volts in (("noise", self.noise), ("change", self.noise_floor)):
            if not (math.isfinite(volts) and volts > 0):
                raise InputError(key, "must be above 0 V and finite", volts)
        for key in ("threshold", "warning"):
            if not math.isfinite(getattr(self, key)):
                raise InputError(key, "must be finite", getattr(self, key))
        if self.every < 1 or self.every != int(self.every):
            raise InputError("every", "must be at least 1 sample, a whole number", self.every)


def tuned(
    rate: float,
    bandwidth: float,
    noise: float,
    alarms: str = SURE,
    every: int = 1,
    *,
    change: float | None = None,
) -> Tuning:
    """Return the tuning for outputs at `rate` Hz behind the low-pass of `bandwidth` Hz, with the thresholds
    of `alarms`, one of POINTS; `noise` V rms of a pair, `change` V rms as `change_noise` has it."""
    for key, value in (("rate", rate), ("bandwidth", bandwidth)):
        if not (math.isfinite(value) and value > 0):
            raise InputError(key, "must be above 0 Hz and finite", value)
    if alarms not in POINTS:
        raise InputError(
            "alarms", f"must be one of {', '.join(POINTS)}", alarms, did_you_mean(alarms, POINTS)
        )
    window, point = max(FEWEST, math.ceil(WINDOW * delay(bandwidth) * rate)), POINTS[alarms]
    return Tuning(window, noise, point.threshold, point.warning, every, point.network, change)


def change_noise(
    alarms: str, network: Network, bandwidth: float, rate: float, noise: float | None = None
) -> float | None:
    """Return the noise of what a pair changes by from sample to sample, V rms, for `alarms` that hear these
    changes; None for those that hear the outputs.

    GRIP's network was fitted to the stress-rate: where the circuit's `network` tells the stress itself, it
    hears the changes. Their noise is that of film and amplifier behind the low-pass of `bandwidth` Hz, in
    samples at `rate` Hz. What the `noise` of a pair of outputs, V rms, has more than theirs is taken to be
    white, as a converter's rounding is: an assumption, by which slower noise counts for more than it is.
    """
    if alarms != GRIP or not tells_stress(network):
        return None
    change = pair_noise(network, bandwidth, rate, 1 / rate)
    own = change if noise is None else pair_noise(network, bandwidth, rate)
    if noise is None or noise <= own:
        return change
    return math.hypot(change, math.sqrt(2 * (noise - own) * (noise + own)))


def pair_noise(network: Network, bandwidth: float, rate: float, step: float | None = None) -> float:
    """Return the noise of a pair by film and amplifier, V rms: of its samples at `rate` Hz behind the
    low-pass, or of differences of samples `step` s apart."""
    return math.sqrt(2) * rms_behind(network, bandwidth, SLOWEST, rate / 2, step)


@dataclass(frozen=True)
class Alarm:
    """At sample `index`, from 0, `ridge` begins to slip, or (None) gross slip is ahead of the whole skin."""

    kind: str
    ridge: int | None
    index: int


@dataclass(frozen=True, eq=False)
class Memory:
    """All that the detector keeps: the running means' state; which ridges are taken to slip, and last whether
    gross slip is ahead `(ridges + 1,)`; how many samples were fed; the channels' resting voltage
    `(2 ridges,)` V; the last sample `(2 ridges,)` V of a detector that hears changes, None before the first.
    """

    means: Array
    told: Mask
    count: int
    rest: Array
    last: Array | None = None


class Detector:
    """Hears the wired ridges' films and raises alarms; any cutting into blocks gives the same.

        detector = skincad.Detector("yamada-2002", "transimpedance", rate=5000.0, ridges=(4, 5, 6))
        detector.rest(block_at_rest)
        for block in blocks:  # (n, 6) V: ridge 4 S1, ridge 4 S2, ridge 5 S1, ...
            for alarm in detector.feed(block):
                print(alarm.kind, alarm.ridge, alarm.index / detector.rate)

    `design` and `circuit` are objects, templates' names or TOML files. `rate` Hz is the circuit's
    `sampling.rate` if not given; `ridges` count from 1, all if not given. `bandwidth` Hz is the low-pass's
    before the sampling, 0.4 of the rate if not given. `noise` V rms of a pair of outputs, S1 - S2 at rest, is
    computed of film and amplifier if not given: give what your board has where that is more. `every` asks the
    networks at one of so many samples only, which is as many times cheaper and at most so many samples later.

    It hears `output_V` as `simulate` has it. The pin of an amplifier that is `inverted` moves the other way.
    The alarms "grip" were fitted to stress-rates. Of an amplifier that tells the stress itself, as a charge
    amplifier does, the detector then hears what the outputs change by from sample to sample: feed the outputs
    all the same. `noise` stays that of the outputs, and `change_noise` has the changes' of it.

    Raises InputError for a skin without films, ridges that it has not, and numbers out of range.
    """

    def __init__(
        self,
        design: Design | str | Path,
        circuit: Circuit | str | Path,
        rate: float | None = None,
        ridges: Sequence[int] | None = None,
        *,
        alarms: str = SURE,
        bandwidth: float | None = None,
        noise: float | None = None,
        every: int = 1,
    ) -> None:
        design = design if isinstance(design, Design) else load_design(design)
        circuit = circuit if isinstance(circuit, Circuit) else load_circuit(circuit)
        if rate is None:
            if circuit.sampling is None:
                rule = f"is missing, and the circuit {circuit.name} has no sampling.rate"
                raise InputError("rate", rule, remedy="give samples per second, as 5000")
            rate = circuit.sampling.rate
        try:
            network = circuit_network(fitted(circuit, design))
        except InputError as failure:
            raise InputError("design", failure.rule, failure.value, failure.remedy) from None
        every_ridge = range(1, skin_of(design).count + 1)
        ridges = tuple(every_ridge if ridges is None else ridges)
        for ridge in ridges:
            if ridge not in every_ridge:
                raise InputError("ridges", f"must be from 1 to {every_ridge[-1]}", ridge)
        if bandwidth is None:
            bandwidth = PASS * rate / 2
        tuning = tuned(rate, bandwidth, 1.0 if noise is None else noise, alarms, every)
        pair = pair_noise(network, bandwidth, rate) if noise is None else noise
        change = change_noise(alarms, network, bandwidth, rate, noise)
        tuning = replace(tuning, noise=pair, change=change)
        self._set(tuning, ridges, rate, inverted=sign(network) < 0)

    @classmethod
    def of(cls, tuning: Tuning, ridges: Sequence[int], rate: float) -> Detector:
        """Return the detector of a tuning that is there already; `ridges` are any numbers that name them."""
        detector = cls.__new__(cls)
        detector._set(tuning, tuple(ridges), rate)
        return detector

    def _set(self, tuning: Tuning, ridges: tuple[int, ...], rate: float, *, inverted: bool = False) -> None:
        if list(ridges) != sorted(set(ridges)) or not ridges:
            rule = "must be one or more, each once, in their order on the skin"
            raise InputError("ridges", rule, ", ".join(map(str, ridges)))
        self.tuning, self.ridges = tuning, tuple(map(int, ridges))
        self.rate, self.inverted = float(rate), inverted
        count = len(ridges)
        self._memory = Memory(hearing.at_rest(count), np.zeros(count + 1, bool), 0, np.zeros(2 * count))

    @property
    def channels(self) -> tuple[tuple[int, str], ...]:
        """Ridge and strip of each column of a block."""
        return tuple((ridge, side) for ridge in self.ridges for side in ("S1", "S2"))

    def rest(self, block: ArrayLike) -> None:
        """Take the mean of `block` `(n, channels)` V, heard while nothing touches, off all that follows."""
        values = self._checked(block)
        if not values.shape[0]:
            raise InputError("block", "must have at least one sample", 0)
        self._memory = replace(self._memory, rest=values.mean(axis=0))

    def feed(self, block: ArrayLike) -> list[Alarm]:
        """Return the alarms of the next samples, `block` `(n, channels)` V; n may be 1.

        Raises InputError for another number of channels or a value that is not finite: nothing was fed then.
        """
        before = self._memory
        asked, told = self.decisions(block)
        rises: Mask = told & ~np.concatenate([before.told[None], told])[:-1]
        alarms = []
        for row, place in np.argwhere(rises):
            ridge = None if place == len(self.ridges) else self.ridges[place]
            kind = AHEAD if ridge is None else INCIPIENT
            alarms.append(Alarm(kind, ridge, before.count + int(asked[row])))
        return alarms

    def decisions(self, block: ArrayLike) -> tuple[Index, Mask]:
        """Feed the next samples, `block` `(n, channels)` V, and return at which of them the networks were
        asked, `(m,)` from 0, and what is taken to be so from then on, `(m, ridges + 1)`: which ridges slip,
        and last whether gross slip is ahead. Raises InputError as `feed`."""
        values, last = self._heard(block)
        odds, asked, means = self._odds(values, skip_quiet=True)
        levels = np.append(np.full(odds.shape[1] - 1, self.tuning.threshold), self.tuning.warning)
        told = taken(self._memory.told, odds, levels, BACK)
        now = told[-1] if told.shape[0] else self._memory.told
        count = self._memory.count + values.shape[0]
        self._memory = replace(self._memory, means=means, told=now, count=count, last=last)
        return asked, told

    def odds(self, block: ArrayLike) -> Array:
        """Return the logarithms of the odds that each ridge slips, and last that gross slip is ahead
        `(n asked, ridges + 1)`, of the next samples; they are not fed."""
        return self._odds(self._heard(block)[0])[0]

    @property
    def state(self) -> dict[str, Any]:
        """All that it keeps, as JSON can hold it: `restore` takes it, in another process too."""
        arrays = {key: value for key, value in vars(self._memory).items() if key != "count"}
        values = {key: None if value is None else value.tolist() for key, value in arrays.items()}
        return {**self._made(), **values, "count": self._memory.count}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Go on from a `state`; raises InputError for one of a detector that was made otherwise."""
        # saved before there were other networks, or any that hears changes
        state = {"network": SKIN, "change": None, "last": None, **state}
        for key, value in self._made().items():
            if key not in state or state[key] != value:
                rule, remedy = (
                    f"must be {value}, as this detector was made",
                    "make it as the one that saved it",
                )
                raise InputError(f"state.{key}", rule, state.get(key), remedy)
        values = dict[str, Any]()
        kinds = {"means": float, "told": bool, "rest": float, "count": int, "last": float}
        if state["last"] is None and (self.tuning.change is None or not state.get("count")):
            del kinds["last"]  # it hears no changes, or has heard no sample
        for key, kind in kinds.items():
            shape = np.shape(self._memory.rest if key == "last" else getattr(self._memory, key))
            try:
                values[key] = np.array(state[key], kind)
            except (KeyError, TypeError, ValueError):
                values[key] = np.zeros(0)
            if values[key].shape != shape:
                rule = f"must have the shape {shape}"
                raise InputError(f"state.{key}", rule, remedy="save it by Detector.state")
        self._memory = Memory(**{**values, "count": int(values["count"])})

    def _made(self) -> dict[str, Any]:
        return {**asdict(self.tuning), "ridges": list(self.ridges), "rate": self.rate}

    def _heard(self, block: ArrayLike) -> tuple[Array, Array | None]:
        """What the networks hear of a block, from its rest or from sample to sample, and its last sample."""
        outputs = self._checked(block)
        values = outputs - self._memory.rest
        if values.size and np.abs(values).max() > LOUDEST * self.tuning.noise_floor:
            rule = f"must be within {LOUDEST:g} times the noise of its resting voltage"
            raise InputError("block", rule, float(np.abs(values).max()), "give it in V")
        if self.tuning.change is None or not values.shape[0]:
            return values, self._memory.last
        before = outputs[:1] if self._memory.last is None else self._memory.last[None]
        return np.diff(outputs, axis=0, prepend=before), outputs[-1].copy()

    def _checked(self, block: ArrayLike) -> Array:
        values = np.asarray(block, float)
        width = 2 * len(self.ridges)
        if values.ndim != 2 or values.shape[1] != width:
            rule = f"must be (n, {width}): S1 and S2 of {len(self.ridges)} ridges"
            raise InputError("block", rule, str(values.shape))
        if not np.isfinite(values).all():
            row, column = np.argwhere(~np.isfinite(values))[0]
            ridge, side = self.channels[column]
            rule = f"must be finite: row {row} of ridge {ridge} {side}"
            raise InputError(
                "block", rule, float(values[row, column]), "leave the sample out, or repeat the last"
            )
        return values

    def _odds(self, values: Array, *, skip_quiet: bool = False) -> tuple[Array, Index, Array]:
        """Long blocks go piece by piece: what a piece needs stays in the processor's cache."""
        size, means, count = max(1, PIECE // len(self.ridges)), self._memory.means, self._memory.count
        odds, asked = [], []
        for start in range(0, max(1, values.shape[0]), size):
            first = -(count + start + 1) % self.tuning.every
            outputs = values[start : start + size].reshape(-1, len(self.ridges), 2)
            every = slice(first, None, self.tuning.every)
            piece, means = self._piece(outputs, means, every, skip_quiet)
            odds.append(piece)
            asked.append(start + first + self.tuning.every * np.arange(piece.shape[0]))
        return np.concatenate(odds), np.concatenate(asked), means

    def _piece(self, outputs: Array, means: Array, asked: slice, skip_quiet: bool) -> tuple[Array, Array]:
        """One sample is multiplied at a time, so that it is the same however the samples are cut.

        Where no ridge is loud there is no alarm, whatever the networks say: they may be skipped.
        """
        t = self.tuning
        felt, loud, after = hearing.features(t.window, t.noise_floor, outputs, means, asked)
        seen = np.concatenate([loud > SEEN, np.any(loud > SEEN, axis=1, keepdims=True)], axis=1)
        rows, quiet = seen[:, -1] if skip_quiet else slice(None), min(t.threshold, t.warning) - BACK - 1.0
        odds = np.full(seen.shape, quiet)
        each, whole = (_odds(network, felt[rows]) for network in t.networks)
        odds[rows] = np.concatenate([each, _mean(whole)[:, None]], axis=1)
        return np.where(seen, odds, np.minimum(odds, quiet)), after


def taken(before: Mask, odds: Array, threshold: Array | float, back: float) -> Mask:
    """Return when each of odds `(n, m)` is taken to be so: from its threshold on until `back` below it."""
    turns = np.where(odds > threshold, 1, np.where(odds < np.subtract(threshold, back), -1, 0))
    turns = np.concatenate([np.where(before, 1, -1)[None], turns])
    last = np.maximum.accumulate(np.where(turns != 0, np.arange(turns.shape[0])[:, None], 0), axis=0)
    return np.asarray(np.take_along_axis(turns, last, axis=0)[1:] > 0)


def _odds(w: Weights, felt: Array) -> Array:
    hidden = np.matmul(felt[:, :, None, :], w.into)
    hidden += w.bias
    np.tanh(hidden, out=hidden)
    return np.asarray(np.matmul(hidden, w.out[:, None])[:, :, 0, 0] + w.base)


def _mean(values: Array) -> Array:
    """The mean of each row, added one after the other: the same for any number of rows."""
    total = np.zeros(values.shape[0])
    for column in values.T:
        total += column
    return np.asarray(total / max(1, values.shape[1]))
