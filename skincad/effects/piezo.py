"""The strips' charge through an amplifier: the voltages that one measures.

Charge from the mean stresses of a strip (circuit/network.py): d33 across it, d31 and d32 along it in the
section and along y, where plane strain has a stress too; times the electrode that lies in the skin. The
circuit's film is replaced by the skin's own strip, so a wider one changes the output, and a longer lead,
whose metal overlaps nowhere, doesn't; its motional branch stays. Both strips of a pair have the same
amplifier. Range: what the film feels is the mean over the strip, its bare edge included; the amplifier does
not act back on the stress (no stiffening). The stress goes through the signals' low-pass, as rate and jerk
do, and so does the noise. Outputs are from rest, where the input bias current has put it. An amplifier that
comes to a rail (circuit/rails.py) does so before the low-pass.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator, Field

from skincad.base.arrays import Array
from skincad.base.errors import InputError, RefusedError
from skincad.base.tables import quantity
from skincad.circuit.model import (
    UNLIMITED,
    Circuit,
    circuit_network,
    constants,
    fitted,
    load_circuit,
    output_offset,
    output_swing,
)
from skincad.circuit.network import Network, capacitance, charge, electrode
from skincad.circuit.rails import at_rails
from skincad.circuit.response import noise_samples
from skincad.circuit.state import (
    PASS,
    Stepper,
    band_limited,
    corner,
    delay,
    evenly_spaced,
    longest_step,
    rms_behind,
    run,
    stepper,
)
from skincad.effects.kinds import Observables, Reader, ReaderContext
from skincad.inputs.catalog import named_document
from skincad.inputs.design import Design

FINE = 0.1  # of the low-pass's time: a step of the network; straight lines between leave 0.01 / 12
MOST_STEPS = 200  # of the network in one of the march
MOST_SAMPLES = 2_000_000
MOST_LEAD = 20_000_000  # of noise before its record begins
NOISES, FEWEST_NOISES = 20, 5  # seeds that give a lead's spread
MOST_NOISE = 20_000_000  # samples of their noise, some seconds, where the fewest seeds take less
SIDES = ("S1", "S2")  # of a pair
MOST_CLIPPED = 3  # strips at a rail that a warning names
SETTLED = 20.0  # delays of the low-pass after which its start has faded, to e^-40


def _circuit(value: Any) -> Circuit:
    """The circuit of a name or a file, or of tables that a scene has in its place."""
    circuit = named_document(value, Circuit, "a circuit")
    try:
        return load_circuit(circuit) if isinstance(circuit, str) else circuit
    except InputError as failure:
        raise InputError("", f"{failure.key}: {failure.rule}", failure.value, failure.remedy) from None


class Piezo(Reader):
    """Voltages of the strips in the ridges of the readout."""

    needs: ClassVar[tuple[str, ...]] = ("film",)

    circuit: Annotated[str | Circuit, BeforeValidator(_circuit)] = Field(
        description="a circuit's template, or a TOML file beside the scene"
    )
    noise_seed: int | None = Field(
        default=None, ge=0, description="seed of the noise of film and amplifier; no noise if not given"
    )
    sampling_Hz: float | None = quantity(  # noqa: N815
        "Hz", "of the recorder; the circuit's if not given", gt=0.0, le=1e9, default=None
    )

    @property
    def loaded(self) -> Circuit:
        """The circuit, whether the scene names it or has its tables."""
        assert isinstance(self.circuit, Circuit)  # as it is validated
        return self.circuit

    def check(self, design: Design) -> None:
        """Raise InputError for a skin without films or with dead ones, or an unusable circuit."""
        circuit = fitted(self.loaded, design)
        assert design.film is not None  # it has an electrode
        if not any((design.film.d31, design.film.d32, design.film.d33)):
            raise InputError("", "the skin's film.d31, d32 and d33 must not all be 0 pC/N")
        constants(circuit)

    def read(self, watched: ReaderContext, time: Array, readings: Sequence[Observables]) -> Mapping[str, Any]:
        """Return `output_V` by monitored ridge and S1, S2, pair (their difference), and facts about it; the
        largest output is either strip's, by which an amplifier is driven to its limits, or is not. All are V
        from rest, in the sign of `vout`; `clipped_share` is the largest of any strip's time at a rail."""
        circuit = fitted(self.loaded, watched.design)
        recorder = circuit.sampling.rate if circuit.sampling else None
        recorder = recorder if self.sampling_Hz is None else self.sampling_Hz
        film = circuit.film
        stress = np.array([reading.films for reading in readings])
        charges = strip_charges(circuit, watched.design, stress)
        whole = circuit_network(circuit)
        swing = output_swing(circuit.amplifier, whole)
        chain = Chain.of(whole, time, watched.bandwidth, swing)
        noise = chain.noise_rms()
        outputs, ratio, clipped, needed = {}, {}, list[dict[str, Any]](), 0.0
        for ridge in watched.ridges:
            pair = []
            for side, strip in enumerate(SIDES, 1):
                strip_charge = charges[:, 2 * (ridge - 1) + side - 1]
                seed = None if self.noise_seed is None else (self.noise_seed, ridge, side)
                if at_rail := chain.clipped(strip_charge, seed):
                    output, share, swings = at_rail
                    clipped.append({"ridge": ridge, "strip": strip, "share_of_time": share})
                    needed = max(needed, swings)
                else:
                    output = chain.output(strip_charge)
                pair.append(output)
            one, other = pair
            ratio[str(ridge)] = _decibels(float(np.std(one - other)), math.sqrt(2) * noise)  # two amplifiers
            if self.noise_seed is not None:
                one = one + chain.noise((self.noise_seed, ridge, 1))
                other = other + chain.noise((self.noise_seed, ridge, 2))
            outputs[str(ridge)] = {"S1": one.tolist(), "S2": other.tolist(), "pair": (one - other).tolist()}
        return {
            "output_V": outputs,
            "largest_output_V": max(
                (abs(v) for output in outputs.values() for s in SIDES for v in output[s]), default=0.0
            ),
            "output_swing_V": [end if math.isfinite(end) else None for end in swing],
            "output_offset_V": output_offset(circuit.amplifier, whole),
            "clipped_share": max((strip["share_of_time"] for strip in clipped), default=0.0),
            "clipped_strips": clipped,
            "circuit": circuit.name,
            "sampling_Hz": recorder,
            "film_capacitance_F": capacitance(film.area, film.thickness, film.permittivity),
            "output_noise_V_rms": noise,
            "signal_to_noise_dB": ratio,
            "warnings": [
                *_warnings(circuit.name, recorder, watched),
                *_clipping(circuit.name, clipped, needed, float(time[-1] - time[0])),
            ],
        }

    def other_noises(self, watched: ReaderContext, time: Array) -> Iterator[Array]:
        """Yield what makes the noise that of the seeds that follow, NOISES with the scene's own, fewer where
        the march is long; of an amplifier at a rail as if it were not."""
        if self.noise_seed is None or not watched.ridges or time.size < 2:
            return
        chain = Chain.of(circuit_network(fitted(self.loaded, watched.design)), time, watched.bandwidth)

        def noise(seed: int) -> Array:
            strips = [[chain.noise((seed, ridge, side)) for side in (1, 2)] for ridge in watched.ridges]
            return np.asarray(np.moveaxis(np.array(strips), 2, 0))

        noise_seen = noise(self.noise_seed)
        seeds = MOST_NOISE // (chain.size * noise_seen[0].size)
        for more in range(1, max(FEWEST_NOISES, min(NOISES, seeds))):
            yield noise(self.noise_seed + more) - noise_seen


def strip_charges(circuit: Circuit, design: Design, stress: Array) -> Array:
    """Return charges `(steps + 1, strips)` C of a Reading's stresses `(steps + 1, strips, 3)` MPa."""
    strip = design.film
    assert strip is not None  # it has an electrode
    through, over, along = np.moveaxis(stress, -1, 0)
    return charge(
        through,
        along,
        over,
        area=electrode(design),
        coefficients=(strip.d31, strip.d32, strip.d33),
        draw_axis=circuit.film.draw_axis,
    )


@dataclass(frozen=True)
class Chain:
    """Low-pass and network behind a march of `count` entries, `fine` steps of the network in one of it.

    `times` `(count,)` s are those of a march whose steps are not equal, None of one whose are: the network's
    steps are equal all the same, `fine` of them in the longest step. `swing` V is how far `vout` goes
    from rest, below and above.
    """

    network: Network
    step: Stepper
    bandwidth: float
    count: int
    fine: int
    times: Array | None = None
    swing: tuple[float, float] = UNLIMITED

    @classmethod
    def of(
        cls, network: Network, time: Array, bandwidth: float, swing: tuple[float, float] = UNLIMITED
    ) -> Chain:
        """Return the chain; the low-pass is exact, and the network's steps are short against its time."""
        count = time.size
        length = longest_step(time) if count > 1 else 1.0
        wanted = math.ceil(corner(bandwidth) * length / FINE)
        fine = max(1, min(wanted, MOST_STEPS, MOST_SAMPLES // count))
        times = None if count < 2 or evenly_spaced(time) else time
        return cls(network, stepper(network, fine / length), bandwidth, count, fine, times, swing)

    @property
    def size(self) -> int:
        """Number of the network's samples, from the march's first entry to its last or just behind it."""
        if self.times is None:
            return (self.count - 1) * self.fine + 1
        return math.ceil(float(self.times[-1]) * self.step.rate) + 1

    def output(self, charges: Array) -> Array:
        """Return the output `(count,)` V of charges `(count,)` C, at rest before, without rails."""
        every, straight, at_even = self._between(charges)
        behind = band_limited(every, straight, self.bandwidth).value
        return self._marched(run(self.step, behind[at_even])[0])

    def clipped(
        self, charges: Array, noise_seed: tuple[int, ...] | None = None
    ) -> tuple[Array, float, float] | None:
        """Return `output` of an amplifier that comes to a rail, the share of the time in which it lies there,
        and how many times its swing it would need; None where it never does.

        The noise of a seed counts in what comes to a rail; it is not in the output.
        """
        if self.swing == UNLIMITED:
            return None
        _, straight, at_even = self._between(charges)
        ahead = run(self.step, straight[at_even])[0]  # of the low-pass, where the rails are
        noise = 0.0 if noise_seed is None else self._noise_samples(noise_seed)[: self.size]
        added, held = at_rails(self.network, ahead + noise, 1 / self.step.rate, *self.swing)
        if not held.any():
            return None
        behind = band_limited(self._even, ahead + added, self.bandwidth).value
        low, high = self.swing
        swings = max(float(ahead.max()) / high, float(ahead.min()) / low)
        return self._marched(behind), float(held.mean()), swings

    @property
    def _even(self) -> Array:
        """The network's samples `(size,)`, s."""
        return np.asarray(np.arange(self.size) / self.step.rate)

    def _between(self, charges: Array) -> tuple[Array, Array, NDArray[np.intp]]:
        """Times `(n,)` s at which the low-pass knows each corner of the charge, the charge there, and which
        of them are the network's own samples."""
        if self.times is None:
            straight = np.interp(np.arange(self.size) / self.fine, np.arange(self.count), charges)
            return self._even, straight, np.arange(self.size)
        every = np.union1d(self._even, self.times)
        return every, np.interp(every, self.times, charges), np.searchsorted(every, self._even)

    def _marched(self, output: Array) -> Array:
        """What the network's samples are at the march's entries."""
        if self.times is None:
            return output[:: self.fine]
        return np.asarray(np.interp(self.times, self._even, output))

    def _noise_samples(self, seed: tuple[int, ...]) -> Array:
        return noise_samples(self.network, self.step.rate, max(2, self.size), seed)

    def noise(self, seed: tuple[int, ...]) -> Array:
        """Return noise `(count,)` V behind the low-pass; raises RefusedError where that takes too long to
        settle."""
        sample = self._noise_samples(seed)
        size = sample.size
        # periodic: a lead-in of its own end lets the low-pass settle
        lead = math.ceil(SETTLED * delay(self.bandwidth) * self.step.rate)
        if lead > MOST_LEAD:
            raise RefusedError(
                "the noise does not settle behind such a slow low-pass: raise readout.bandwidth_Hz"
            )
        at = np.arange(-lead, size)
        behind = band_limited(at / self.step.rate, sample[at % size], self.bandwidth).value
        if self.times is None:
            return behind[lead :: self.fine][: self.count]
        return np.asarray(behind[lead + np.rint(self.times * self.step.rate).astype(int)])

    def noise_rms(self) -> float:
        """Return the noise behind the low-pass, V rms, from one period of the record up to half the rate."""
        low = self.step.rate / max(2, self.size)
        return rms_behind(self.network, self.bandwidth, low, self.step.rate / 2)


def _decibels(signal: float, noise: float) -> float | None:
    return 20 * math.log10(signal / noise) if signal > 0 and noise > 0 else None


def _clipping(name: str, clipped: Sequence[Mapping[str, Any]], swings: float, duration: float) -> list[str]:
    """Which strips' amplifiers lie at a rail for how long, and the remedy."""
    if not clipped:
        return []
    worst = sorted(clipped, key=lambda strip: -strip["share_of_time"])
    told = [
        f"ridge {c['ridge']} {c['strip']} for {c['share_of_time']:.2g} of the time "
        f"({1e3 * c['share_of_time'] * duration:.3g} ms)"
        for c in worst[:MOST_CLIPPED]
    ]
    more = [f"{len(worst) - len(told)} more for less"] if len(worst) > len(told) else []
    return [
        f"{name} is driven to a rail: {', '.join([*told, *more])}; output_V is clipped there. It would need "
        f"{swings:.2g} times its swing: take as much less gain (a smaller amplifier.feedback_resistance, in "
        "a charge amplifier a larger feedback_capacitance) or wider rails"
    ]


def _warnings(name: str, recorder: float | None, watched: ReaderContext) -> list[str]:
    """What the recorder does not show of these signals."""
    seen = math.inf if recorder is None else PASS * recorder / 2
    if seen >= watched.bandwidth:
        return []
    return [
        f"{name} is sampled at {recorder:g} Hz, true up to {seen:.4g} Hz: output_V reaches up to "
        f"{watched.bandwidth:g} Hz, at the scene's own time steps"
    ]
