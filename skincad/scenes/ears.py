"""What the wired films tell of a lift, sample by sample, through the amplifier and the low-pass."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from skincad.base.arrays import Array
from skincad.base.errors import InputError
from skincad.circuit.model import circuit_network, fitted, output_swing
from skincad.circuit.state import PASS, run, stepper
from skincad.effects.piezo import SIDES, Chain, Piezo, strip_charges
from skincad.scenes.scene import Scene
from skincad.shape.skin import skin_of

UNHEARD_RATE = 2000.0  # Hz, steps of a lift that no recorder hears
NEAR_RAIL = 0.9  # of an amplifier's swing at a sample: it may come to the rail between two; assumption


class Ears:
    """The wired films' outputs of a lift, sample by sample: exact for stresses straight in between.

    `gain` is what the stresses are multiplied by. An amplifier that comes to a rail is read out anew from the
    lift's begin at each block (circuit/rails.py).
    """

    def __init__(self, scene: Scene, piezo: Piezo, rate: float, count: int, gain: float) -> None:
        self.design, self.gain = scene.design, gain
        self.circuit = fitted(piezo.loaded, scene.design)
        network = circuit_network(self.circuit)
        band = bandwidth(scene, rate)
        swing = output_swing(self.circuit.amplifier, network)
        self.chain = Chain.of(network, np.arange(count) / rate, band, swing)
        self.step, ridges = stepper(network, rate, band), scene.readout.ridges
        # rails are ahead of the low-pass, which shows less of a short peak
        self.ahead = stepper(network, rate) if math.isfinite(max(swing)) else None
        self.columns = [2 * (ridge - 1) + side for ridge in ridges for side in range(len(SIDES))]
        self.states, self.ahead_states, self.railed = dict[int, Any](), dict[int, Any](), set[int]()
        self.charges = np.zeros((0, 2 * skin_of(scene.design).count))
        self.noise = np.zeros((count, len(ridges), len(SIDES)))

    def make_noise(self, ridges: Sequence[int], seed: int) -> None:
        """Add a seed's noise of film and amplifier to all outputs to come."""
        for place, ridge in enumerate(ridges):
            for side in range(len(SIDES)):
                self.noise[:, place, side] = self.chain.noise((seed, ridge, side + 1))

    def outputs(self, films: Array) -> Array:
        """Return outputs `(n, ridges, 2)` V at the next stresses `(n, strips, 3)` MPa."""
        begun, charges = self.charges.shape[0], strip_charges(self.circuit, self.design, self.gain * films)
        self.charges = np.concatenate([self.charges, charges])
        rows = self.charges[max(0, begun - 1) :]
        out = np.empty((films.shape[0], len(self.columns)))
        for place, column in enumerate(self.columns):
            values, self.states[place] = run(self.step, rows[:, column], self.states.get(place))
            out[:, place] = values[-films.shape[0] :]
            if self._near_rail(place, rows[:, column]):
                every = self.charges[:, column]
                clipped = replace(self.chain, count=every.size).clipped(every)
                if clipped:
                    out[:, place] = clipped[0][begun:]
        pairs = out.reshape(films.shape[0], -1, len(SIDES))
        return np.asarray(pairs + self.noise[begun : begun + films.shape[0]])

    def _near_rail(self, place: int, charge: Array) -> bool:
        """Whether an amplifier has come near a rail by the end of this charge `(n,)` C."""
        if self.ahead is None:
            return False
        values, self.ahead_states[place] = run(self.ahead, charge, self.ahead_states.get(place))
        low, high = self.chain.swing
        if values.max() > NEAR_RAIL * high or values.min() < NEAR_RAIL * low:
            self.railed.add(place)
        return place in self.railed


def piezo_of(scene: Scene) -> Piezo | None:
    """Return the effect that has the scene's amplifier, None without one."""
    return next((part for part in scene.parts.values() if isinstance(part, Piezo)), None)


def rate_of(scene: Scene) -> float:
    """Return the samples of a lift, Hz: the recorder's, or UNHEARD_RATE."""
    piezo = piezo_of(scene)
    if piezo is None:
        return UNHEARD_RATE
    circuit = fitted(piezo.loaded, scene.design)
    if piezo.sampling_Hz is not None:
        return piezo.sampling_Hz
    if circuit.sampling is None:
        rule = f"is missing, and the circuit {circuit.name} has no sampling.rate"
        raise InputError("effects.piezo.sampling_Hz", rule, remedy="give samples per second, as 2000")
    return circuit.sampling.rate


def ears_of(scene: Scene, rate: float, count: int, seed: int | None, gain: float) -> Ears | None:
    """Return what hears a scene's wired films for `count` samples; None without an amplifier."""
    piezo = piezo_of(scene)
    if piezo is None or not scene.readout.ridges:
        return None
    ears = Ears(scene, piezo, rate, count, gain)
    if seed is not None:
        ears.make_noise(scene.readout.ridges, seed)
    return ears


def bandwidth(scene: Scene, rate: float) -> float:
    """Return the low-pass's before the sampling, Hz."""
    return min(scene.readout.bandwidth_Hz, PASS * rate / 2)
