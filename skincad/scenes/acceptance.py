"""Acceptance of a skin by a recording of its films: which strips work, and which are dead, reversed, swapped.

A press must show each strip. It can't show all swaps: strips at mirrored places of a symmetric press give the
same signal, and the two strips of a ridge nearly the same. Such pairs are named; a pull tells most of them.
Range: one recording of the scene, begun before its press, driven at 0.7 to 1.45 times the scene's duration.
Evidence: docs/evidence/recordings.md; test: tests/scenes/test_acceptance.py.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter

import numpy as np

from skincad.base.arrays import Array
from skincad.base.errors import InputError
from skincad.base.estimate import Estimate
from skincad.base.machine import one_blas_thread
from skincad.base.progress import Tick
from skincad.base.result import Record, Result, item, record, reported
from skincad.inputs.recordings import FilmRecording, check_time, column_name, film_recording
from skincad.scenes.film_prediction import (
    MEMBERS,
    FilmPrediction,
    Strip,
    monitored_strips,
    predict_films,
    press_end,
    recorded_scene,
)
from skincad.scenes.scene import Scene
from skincad.scenes.strip_assignment import (
    CELLS,
    DEAD,
    FEWEST_CELLS,
    FINE,
    HUM,
    REVERSED,
    SPEEDS,
    WEAK_STATE,
    WORKS,
    Alignment,
    Assignment,
    Judge,
    SignalModel,
    align,
    assign,
    cell_means,
    signal_model,
)
from skincad.scenes.strip_posterior import SWAPPED, ChannelStates, Posterior, posterior

SURE = 0.75  # probability from which a state is told
LONE_SWAP = 0.97  # the same of a strip behind another channel whose own strip is not behind this one
PRESS_SWAP = 0.95  # the most that is said of a swap by a press alone: of 21 recordings so said 20 were right
MOST_OF_DEAD = 0.25  # gain over the common one: what shows more of its strip is not dead,
CLEAR = 20.0  # if that is as many times its error: hum shows some by chance
SHOWN = 3.0  # of log-likelihood, by which a strip that works must differ from a dead one
WORLDS_REFINED = 2  # moduli that are looked at closely
ROUNDS = 8  # of the search for the alignment
DELAYS = 100  # of a recording, tried for when the scene begins
FINEST_QUIET = 10  # samples before the press from which noise is taken
ALIKE_SHAPE = 0.8  # cosine with the prediction from which a small signal is one
SPARE_CELLS = 20  # cells from which what no basis describes gives the noise
FEWEST_WAVES, WIDEST_CELL = 2.0, 0.4  # of the hum, in a recording and in a cell, to take it out
LOUD_LEFT = 0.4  # of its power, of a channel that mostly hums
HUM_LEFT = 0.7  # of what is left, where hum is taken out: noise alone loses less
SLOWEST = 0.75  # of the scene's duration, or as much longer
FULL_SCALE = 30.0  # times the prediction, either way: beyond it is another unit
CANT_TELL = "can't tell"


@record()
class StripState(Record):
    """What a channel of the recording shows of its strip."""

    ridge: int = item(meaning="ridge, from 1")
    side: str = item(meaning="S1 or S2")
    state: str = item(meaning="works, weak, dead, reversed, swapped with another strip, or can't tell")
    shows: str | None = item(meaning="the other strip that the channel shows, where swapped")
    probability: float = item("1", "of the state, among all of them", key="probability")
    second: str = item(meaning="the next likely state")
    gain: Estimate = item("1", "of the strip over the common gain", key="gain")
    alike: tuple[str, ...] = item(meaning="strips with which a swap would not show in this recording")

    @property
    def name(self) -> str:
        """The strip's name."""
        return strip_name((self.ridge, self.side))


@record(eq=False)
class RecordingAcceptance(Result):
    """What a recording says of the strips; `pull` whether it covers more than the press."""

    shown_by = "skincad.outputs.measurements:RECORDING"
    scene: Scene
    strips: tuple[StripState, ...] = item(meaning="by channel")
    common_gain: Estimate = item("1", "of all strips, recorded over predicted", key="common_gain")
    delay: Estimate = item("s", "of the recording, when the scene begins")
    duration: float = item("1", "of the recorded scene over the predicted one", key="duration")
    pull: bool = item(meaning="whether the recording covers more than the press")
    seconds: dict[str, float] = item(meaning="wall time by stage, s")
    warnings: tuple[str, ...] = item(meaning="what to know of the numbers")

    @reported(meaning="of the scene")
    def name(self) -> str:
        """The scene's name."""
        return self.scene.name

    @reported(meaning="whether all strips work")
    def passed(self) -> bool:
        """Whether all strips work."""
        return all(strip.state == WORKS for strip in self.strips)

    @property
    def exit_status(self) -> int:
        """0 where all strips work, else 1."""
        return 0 if self.passed else 1


def strip_name(strip: Strip) -> str:
    """Return a strip's name for people."""
    return f"ridge {strip[0]} {strip[1]}"


def accept_recording(
    scene: Scene,
    recording: FilmRecording | Path | str,
    *,
    members: int = MEMBERS,
    tick: Tick | None = None,
) -> RecordingAcceptance:
    """Compare a recording of a scene's films with their prediction, and name strips that do not work.

    `recording` is a CSV (see `film_recording`) or its data. `members` simulations with drawn tolerances say
    how far the prediction may be off. Raises InputError for a recording that cannot be compared.
    """
    began = perf_counter()
    scene = recorded_scene(scene)
    if not isinstance(recording, FilmRecording):
        recording = film_recording(recording, monitored_strips(scene))
    check_recording(monitored_strips(scene), press_end(scene), recording)
    prediction = predict_films(scene, members, tick)
    predicted = perf_counter() - began
    result = judge(scene, prediction, recording)
    seconds = {"total": perf_counter() - began, "prediction": predicted}
    return replace(result, seconds=seconds)


def judge(scene: Scene, prediction: FilmPrediction, recording: FilmRecording) -> RecordingAcceptance:
    """Return what a recording says by a prediction that is there already."""
    began = perf_counter()
    with one_blas_thread():
        check_recording(prediction.strips, prediction.press_end, recording)
        fit = _fitted(prediction, recording)
        _check_units(fit, prediction.strips)
        shown = posterior(
            fit.model, fit.parts, fit.noise, fit.hum, fit.assignment.gain, fit.assignment.places
        )
    pull = bool(fit.model.edges[-1] > prediction.press_end * (1 + 1e-9))
    strips = tuple(_state(fit, shown, prediction.strips, c, pull) for c in range(len(prediction.strips)))
    assignment = fit.assignment
    step = float(np.median(np.diff(recording.time)))
    cell = fit.alignment.speed * float(np.diff(fit.model.edges).min())
    return RecordingAcceptance(
        scene=scene,
        strips=strips,
        common_gain=Estimate(assignment.gain, 2 * assignment.gain_error, ""),
        delay=Estimate(fit.alignment.delay, max(step, cell), "s"),
        duration=fit.alignment.speed,
        pull=pull,
        seconds={"total": perf_counter() - began},
        warnings=tuple(_warnings(fit, recording)),
    )


@dataclass(frozen=True, eq=False)
class RecordingFit:
    """A recording's channels in the model's basis, aligned and assigned; `noise` `(channels,)` V s^0.5, and
    `hum` `(rank, k)` the mains' waves."""

    model: SignalModel
    alignment: Alignment
    parts: Array
    noise: Array
    hum: Array
    assignment: Assignment


def check_recording(strips: Sequence[Strip], press: float, recording: FilmRecording) -> None:
    """Raise InputError for a recording of other strips than `strips`, or one too short or too coarse for a
    press of `press` s."""
    odd = [s for s in (*strips, *recording.strips) if (s in strips) != (s in recording.strips)]
    if odd or recording.volts.shape != (len(strips), recording.time.size):
        rule = "must be recorded as each strip of readout.ridges is, and no other"
        raise InputError(column_name(*(odd or list(strips))[0]), rule, remedy="give a column a strip")
    check_time(recording.time, "recording, row {}", "time_s")
    span = float(np.ptp(recording.time))
    if span < SPEEDS[0] * press:
        rule = f"must cover the press, {press:g} s in the scene"
        raise InputError("time_s", rule, span, "record the whole press; a time in s is named time_s")
    step = float(np.median(np.diff(recording.time)))
    if step > press / FEWEST_CELLS:
        rule = (
            f"must have a step of at most {press / FEWEST_CELLS:.3g} s: the scene's press takes {press:g} s"
        )
        raise InputError("time_s", rule, step, "sample faster; a time in ms is named time_ms")


def _check_units(fit: RecordingFit, strips: Sequence[Strip]) -> None:
    """Raise InputError for voltages that no gain explains: another unit."""
    ratio = np.linalg.norm(fit.parts, axis=1) / np.linalg.norm(fit.model.mean, axis=1)
    cosine = np.abs((fit.parts * fit.model.mean).sum(axis=1))
    cosine /= np.linalg.norm(fit.parts, axis=1) * np.linalg.norm(fit.model.mean, axis=1) + 1e-300
    middle = float(np.median(ratio))
    if middle > FULL_SCALE or (middle < 1 / FULL_SCALE and float(np.median(cosine)) > ALIKE_SHAPE):
        rule = f"must be in volts, and within a factor of {FULL_SCALE:g} of the prediction"
        remedy = "divide millivolts by 1000, or correct the scene's circuit"
        raise InputError(column_name(*strips[0]), rule, f"{middle:.3g} times the prediction", remedy)


def _warnings(fit: RecordingFit, recording: FilmRecording) -> Iterator[str]:
    """What to know of a recording."""
    yield from recording.notes
    if int((recording.time - recording.time[0] < fit.alignment.delay).sum()) < FINEST_QUIET:
        yield "there is no rest before the press, so noise and offset are guessed: record a moment of it"
    if fit.alignment.speed in (SPEEDS[0], SPEEDS[-1]) or not SLOWEST < fit.alignment.speed < 1 / SLOWEST:
        yield (
            f"the recorded scene takes {fit.alignment.speed:.2f} times as long as predicted: "
            "give the scene the times that you drove"
        )


def _edges(press: float, end: float, step: float) -> Array:
    """Edges of the cells of the press and what follows until `end` s, none shorter than a sample."""
    count = int(np.clip(press / step, FEWEST_CELLS, CELLS))
    edges = np.linspace(0.0, press, count + 1)
    if end > 1.05 * press:
        more = int(np.clip((end - press) / step, FEWEST_CELLS, CELLS))
        edges = np.concatenate([edges, np.linspace(press, end, more + 1)[1:]])
    return edges


def _fitted(prediction: FilmPrediction, recording: FilmRecording) -> RecordingFit:
    """The recording by the modulus that fits it best: aligned by the press, then by all that it covers."""
    time, press = recording.time - recording.time[0], prediction.press_end
    step = float(np.median(np.diff(recording.time)))
    finest = step / SPEEDS[0]
    last = np.linspace(0.0, max(0.0, time[-1] - SPEEDS[0] * press), DELAYS)
    rest = int(np.clip(0.02 * time.size, 3, FINEST_QUIET))
    volts = recording.volts - recording.volts[:, :rest].mean(axis=1, keepdims=True)
    still = _without_loud_hum(time, volts)
    edges = _edges(press, float(prediction.time[-1]), finest)
    cells = np.array([cell_means(prediction.time, world, edges) for world in prediction.worlds])
    pressed = int(np.searchsorted(edges, 0.95 * press))
    firsts = align(edges, pressed, cells, time, still, last, SPEEDS)
    order = sorted(range(len(firsts)), key=lambda world: -firsts[world].score)[:WORLDS_REFINED]
    if not np.isfinite(firsts[order[0]].score):
        rule = f"must go on until the press ends, {press:g} s after it begins"
        raise InputError("time_s", rule, float(time[-1]), "record longer")
    near = float(last[1]) if last[-1] > 0 else 0.0
    fits = []
    for world in order:
        first = firsts[world]
        delays = np.unique(np.clip(first.delay + near * np.linspace(-2, 2, 9), 0.0, None))
        speeds = first.speed * np.linspace(0.94, 1.06, 7)
        close = align(edges, pressed, cells[[world]], time, still, delays, speeds)[0]
        end = max(press, min(float(prediction.time[-1]), (time[-1] - close.delay) / close.speed))
        covered = _edges(press, end, finest)
        model = signal_model(prediction.time, prediction.worlds, world, prediction.changes, covered)
        fits.append(_refined(model, time, volts, close))
    return max(fits, key=lambda fit: fit.assignment.score)


def _refined(model: SignalModel, time: Array, volts: Array, start: Alignment) -> RecordingFit:
    """The alignment near `start` whose assignment is most probable."""
    clean, white = _without_hum(time, volts, start.delay)

    def parts_at(at: Alignment) -> tuple[Array, Array]:
        cells = model.weighted(cell_means(time, clean, at.delay + at.speed * model.edges))
        return _split(model, cells, at)

    shown, rest = parts_at(start)
    spare = max(1, rest.shape[1] - model.basis.shape[1] - 4)
    floor = 1e-6 * np.linalg.norm(model.mean) / np.sqrt(model.mean.size)
    left = (rest**2).sum(axis=1) / spare
    noise = np.sqrt(left if spare >= SPARE_CELLS else left + white**2 / start.speed) + floor
    size = np.linalg.norm(shown, axis=1)
    court = Judge(model, noise, size)

    def score(at: Alignment) -> float:
        return assign(court.likelihoods(parts_at(at)[0], _hum(model, at.delay, at.speed))).score

    cell = start.speed * float(np.diff(model.edges).min())
    best, shift, by = Alignment(start.delay, start.speed, score(start)), cell, 0.02
    for _ in range(ROUNDS):
        moves = [(shift, 1.0), (-shift, 1.0), (0.0, 1 + by), (0.0, 1 - by)]
        moved = False
        for way, factor in moves:
            there = Alignment(max(0.0, best.delay + way), best.speed * factor, 0.0)
            if (found := score(there)) > best.score:
                best, moved = Alignment(there.delay, there.speed, found), True
        if not moved:
            shift, by = shift / 2, by / 2
    parts, waves = parts_at(best)[0], _hum(model, best.delay, best.speed)
    fine = assign(court.likelihoods(parts, waves)).likeliest * FINE
    answer = assign(Judge(model, noise, size, fine).likelihoods(parts, waves))
    return RecordingFit(model, best, parts, noise, waves, answer)


def _without_loud_hum(time: Array, volts: Array) -> Array:
    """The channels `(channels, samples)` V, those that mostly hum without their hum."""
    still = volts
    for f in HUM:
        if time[-1] * f < FEWEST_WAVES:
            continue
        angle = 2 * np.pi * f * time
        waves = np.stack([np.ones_like(time), np.sin(angle), np.cos(angle)], axis=1)
        left = still - (waves @ np.linalg.lstsq(waves, still.T, rcond=None)[0]).T
        loud = left.var(axis=1) < LOUD_LEFT * still.var(axis=1)
        still = np.where(loud[:, None], left, still)
    return still


def _without_hum(time: Array, volts: Array, delay: float) -> tuple[Array, Array]:
    """The channels without offset and mains' hum, as the quiet part before `delay` s shows them, and the
    density of what noise is left there `(channels,)` V s^0.5."""
    quiet = time < delay
    count = int(quiet.sum())
    step = float(np.median(np.diff(time)))
    if count < FINEST_QUIET:
        jitter = np.median(np.abs(np.diff(volts, axis=1)), axis=1) / 0.6745 / np.sqrt(2)
        return volts - volts[:, :1], jitter * np.sqrt(step)
    columns = [np.ones_like(time)]
    clean, rest = volts, volts[:, quiet]
    best = np.inf
    choices = [f for f in HUM if delay * f > 1.0 and f * step < 0.4] if count > 3 * FINEST_QUIET else []
    for waves in [[], *([f] for f in choices)]:
        angles = [2 * np.pi * f * time for f in waves]
        design = np.stack([*columns, *(wave(a) for a in angles for wave in (np.sin, np.cos))], axis=1)
        weights = np.linalg.lstsq(design[quiet], volts[:, quiet].T, rcond=None)[0]
        off = volts - (design @ weights).T
        left = float((np.log((off[:, quiet] ** 2).mean(axis=1) + 1e-300)).sum()) * count / 2
        left += 2 * len(volts) * len(waves) * np.log(count)  # so that noise alone is no hum
        if left < best:
            best, clean, rest = left, off, off[:, quiet]
    return clean, rest.std(axis=1) * np.sqrt(step)


def _split(model: SignalModel, cells: Array, at: Alignment) -> tuple[Array, Array]:
    """A recording's cells `(channels, cells)` V s^0.5 in the model's basis, and what is left of them, both
    without the hum of the mains that this rest shows."""
    basis = model.basis
    parts = cells @ basis
    rest = cells - parts @ basis.T
    middle = at.delay + at.speed * (model.edges[1:] + model.edges[:-1]) / 2
    width = at.speed * float(np.diff(model.edges).max())
    for f in HUM:
        if at.speed * model.edges[-1] * f < FEWEST_WAVES or width * f > WIDEST_CELL:
            continue
        waves = model.weighted(np.array([np.sin(2 * np.pi * f * middle), np.cos(2 * np.pi * f * middle)]))
        beyond = waves - (waves @ basis) @ basis.T
        weights = np.linalg.lstsq(beyond.T, rest.T, rcond=None)[0].T
        left = rest - weights @ beyond
        humming = (left**2).sum(axis=1) < HUM_LEFT * (rest**2).sum(axis=1)
        parts = np.where(humming[:, None], parts - weights @ (waves @ basis), parts)
        rest = np.where(humming[:, None], left, rest)
    return parts, rest


def _hum(model: SignalModel, delay: float, speed: float) -> Array:
    """The mains' waves in the model's basis `(rank, 4)`, each of energy 1."""
    middle = delay + speed * (model.edges[1:] + model.edges[:-1]) / 2
    waves = np.array([wave(2 * np.pi * f * middle) for f in HUM for wave in (np.sin, np.cos)])
    cells = model.weighted(waves)
    return np.asarray((cells / (np.linalg.norm(cells, axis=1, keepdims=True) + 1e-12)) @ model.basis).T


def _state(fit: RecordingFit, shown: Posterior, strips: Sequence[Strip], c: int, pull: bool) -> StripState:
    """What a channel shows in a press, and in a `pull` after it."""
    channel = shown.channels[c]
    (name, other, _), chance = channel[0]
    mutual = other is None or shown.channels[other][0][0][:2] == (SWAPPED, c)
    told = chance >= (SURE if mutual else LONE_SWAP) and name in (WORKS, REVERSED, DEAD, WEAK_STATE, SWAPPED)
    if not pull and other is not None and _crossed(shown, strips, strips[c][0], strips[other][0]):
        told = False
    if name in (WORKS, REVERSED, WEAK_STATE) and shown.dead_evidence[c] < SHOWN:
        told = False
    gain = _gain(fit, c, other if other is not None else c)
    if name == DEAD and abs(float(gain)) > max(MOST_OF_DEAD, CLEAR * (gain.error or 0.0)):
        told = False
    pairs = [b if a == c else a for a, b in shown.alike if c in (a, b)]
    ridge, side = strips[c]
    return StripState(
        ridge=ridge,
        side=side,
        state=_words(channel, 0, strips) if told else CANT_TELL,
        shows=strip_name(strips[other]) if told and other is not None else None,
        probability=chance if pull or name != SWAPPED else min(chance, PRESS_SWAP),
        second=_words(channel, 1 if told else 0, strips),
        gain=gain,
        alike=tuple(strip_name(strips[b]) for b in pairs),
    )


def _crossed(shown: Posterior, strips: Sequence[Strip], ridge: int, other: int) -> bool:
    """Whether the channels of a ridge show those of another crosswise, S1 as S2 and S2 as S1: in a press a
    crest that is lower than its mirror image does the same."""
    own = (channel for (of, _), channel in zip(strips, shown.channels, strict=True) if of == ridge)
    seen = [channel[0][0][1] for channel in own]
    crosswise = [(other, "S2"), (other, "S1")]
    return ridge != other and [None if i is None else strips[i] for i in seen] == crosswise


def _words(channel: ChannelStates, rank: int, strips: Sequence[Strip]) -> str:
    """A state in words."""
    name, other, sign = channel[rank][0]
    if other is None:
        return name
    return f"swapped with {strip_name(strips[other])}" + ", reversed" * (sign < 0)


def _gain(fit: RecordingFit, c: int, strip: int) -> Estimate:
    """A channel's gain over the common one, by the strip that it shows, with twice its standard error."""
    mean, common = fit.model.mean[strip], fit.assignment.gain
    eye = np.eye(mean.size)
    covariance = common**2 * fit.model.spread[strip] + fit.noise[c] ** 2 * eye
    weight = np.linalg.solve(covariance, mean)
    size = float(weight @ mean)
    return Estimate(float(weight @ fit.parts[c]) / size / common, 2 / np.sqrt(size) / common, "")
