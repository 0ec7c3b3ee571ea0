"""Magnets in the pins, read by magnetometers under the skin: fields, and the forces and slips that they tell.

The field is exact for the magnets where the forces on the tips have put them (mechanics/magnetics.py), with
the sway of a pressed pin on top (mechanics/contact/tips.py), or what a pin at finite strain does more
(mechanics/models/pin_body.py). A sensor takes samples at its rate, from the
start on; a step shows the last one, with noise, rounding and the range's end. Forces follow from all readings
by least squares and the skin's own model; the field of the unloaded skin is known from before. A slip is told
where a pin's pull stays behind its share of the whole pull by more than noise may.
Range: that of pins in a scene (effects/pin_pad.py); sensors without lag, offset or errors of scale.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from pydantic import Field

from skincad.base.arrays import Array, Mask
from skincad.base.errors import InputError, RefusedError
from skincad.effects.kinds import Observables, Reader, ReaderContext
from skincad.inputs.design import Design
from skincad.inputs.feature_tables import Magnetometer
from skincad.mechanics.magnetics import MagneticPins, force_noise, magnetic_pins

AXES = "x", "y", "z"
SURE, FALLS = 4.0, 0.05  # times its noise, and of its share, by which a pull stays behind in a slip
# Corrections of forces, by a slope that a step changes by little, until the last is so much of the largest
SETTLED, MOST_CORRECTIONS = 1e-6, 60
NUDGE = 1e-5  # N, of a central difference
SWAYS = 0.9  # most of a pin's stiffness that a press is let take, where noise makes forces too large
PULLED, FAINT = 10.0, 0.1  # times its noise, and of its largest, the pull from which on its shares count
AVERAGED = 10  # samples: a mean of them has a third of the noise, and is half as many late


class Magnetometers(Reader):
    """The fields of the design's [magnetometer], and what forces on pins they tell."""

    noise_seed: int | None = Field(
        default=None, ge=0, description="seed of the sensors' noise; no noise if not given"
    )

    def check(self, design: Design) -> None:
        """Raise InputError for a skin without sensors of magnets."""
        if design.magnetometer is None:
            remedy = "give the design [pin.pocket.magnet] and [magnetometer]"
            raise InputError("", "needs a skin with [magnetometer]", design.name, remedy)

    def read(self, watched: ReaderContext, time: Array, readings: Sequence[Observables]) -> Mapping[str, Any]:
        """Return `field_mT` by sensor and `pin_force_N` by pin, each along x, y and z, the force of the plate
        on the pin. Its largest errors, N: against the march, by noise, rounding, samples older than their
        step and what is not linear; and by what way, tilt and remanence of magnets may be off, each pin's by
        themselves. And the step from which the readings tell each pin's slip, None for none."""
        from skincad.effects.pin_pad import pin_pad

        sensors, pins = watched.design.magnetometer, magnetic_pins(watched.design)
        assert sensors is not None  # as it is checked
        tips, sways = np.array([reading.tips for reading in readings]), pin_pad(watched.design).tips.sway

        def own(load: Array, reading: Observables) -> tuple[Array, Array]:
            """Under forces on tips near those of a state, what each pin bends by and what its own magnet goes
            besides."""
            if reading.magnets:
                return load, reading.magnets(load)
            sway = 1 - np.minimum(sways(-load[:, 2]), SWAYS)  # a pressed pin sways the more
            return load / np.stack([sway, sway, np.ones_like(sway)], axis=1), np.zeros((len(load), 6))

        moves = [moved(pins, *own(load, at)) for load, at in zip(tips, readings, strict=True)]
        field = np.array([pins.fields(poses).sum(axis=1) for poses in moves])
        seen = sampled(field, time, sensors, self.noise_seed)
        beyond = np.abs(field).max(axis=(0, 2)) > sensors.range
        notes = [f"sensor {i + 1} leaves its range of {sensors.range:g} mT" for i in np.flatnonzero(beyond)]
        forces: dict[str, Any] = {"magnet_slip_step": [None] * len(pins.middle)}
        try:
            estimates = force_estimates(seen, readings, pins, own, sensors, ~beyond)
        except RefusedError as refusal:
            notes.append(str(refusal))
        else:
            forces = {
                "pin_force_N": _by_number(estimates.forces),
                "pin_force_error_N": float(np.abs(estimates.forces - tips).max()),
                "pin_force_map_error_N": estimates.error,
                "pin_force_noise_N": estimates.floor.tolist(),
                "magnet_slip_step": slip_steps(estimates, time, sensors.rate),
            }
        return {
            "field_mT": _by_number(seen),
            **forces,
            "field_noise_uT_rms": 1000 * sensors.rms,
            "field_rate_Hz": sensors.rate,
            "warnings": notes,
        }


def sampled(field: Array, time: Array, sensors: Magnetometer, seed: int | None) -> Array:
    """Return the last samples at steps `(steps, s, 3)` mT of a field that is straight between steps."""
    at = np.floor(time * sensors.rate + 1e-6).astype(int)  # of the samples since the start
    numbers, back = np.unique(at, return_inverse=True)
    moments = numbers / sensors.rate
    flat = field.reshape(len(time), -1)
    value = np.stack([np.interp(moments, time, column) for column in flat.T], axis=1)
    if seed is not None:
        value = value + np.random.default_rng(seed).normal(0.0, sensors.noise / 1000, value.shape)
    if sensors.resolution:
        value = np.round(value / (sensors.resolution / 1000)) * (sensors.resolution / 1000)
    return np.asarray(np.clip(value, -sensors.range, sensors.range)[back].reshape(field.shape))


def moved(pins: MagneticPins, bends: Array, besides: Array) -> Array:
    """Return how magnets go and turn `(n, 6)` where pins bend as by forces `(n, 3)` N, and `besides`."""
    return np.asarray(pins.poses(bends) + besides)


class ForceEstimates(NamedTuple):
    """The `forces` on tips `(steps, n, 3)` N that readings tell, their noise rms, the `floor` `(n, 3)` N, and
    that of the whole `pull` along x, N; and the largest `error` by what the map is off, N."""

    forces: Array
    floor: Array
    pull: float
    error: float


def force_estimates(
    seen: Array,
    readings: Sequence[Observables],
    pins: MagneticPins,
    own: Callable[[Array, Observables], tuple[Array, Array]],
    sensors: Magnetometer,
    within: Mask,
) -> ForceEstimates:
    """Return the forces that readings `(steps, s, 3)` mT of the sensors `within` `(s,)` their range tell: by
    the map's slope at the forces of the step before, and by it again for what the fields of these forces are
    off, until they settle. `own` says of each pin by what it bends, N, and what its magnet goes besides, near
    the forces of a state.

    Raises RefusedError where the sensors are too few, or the forces don't settle.
    """
    every, forces = np.arange(len(pins.middle)), [np.zeros_like(pins.middle)]
    noise = list[tuple[Array, float, float]]()
    for step, (read, reading) in enumerate(zip(seen, readings, strict=True)):
        load, goes = forces[-1], np.zeros_like(pins.goes)
        for axis, more in enumerate(np.eye(3) * NUDGE):
            up, down = own(load + more, reading), own(load - more, reading)
            bends, besides = ((one - other) / (2 * NUDGE) for one, other in zip(up, down, strict=True))
            goes[..., axis] = np.einsum("ikja,ja->ikj", pins.goes, bends)
            goes[every, :, every, axis] += besides
        slope = replace(pins, goes=goes).slope(moved(pins, *own(load, reading)))
        slope *= np.repeat(within, 3)[:, None]
        floor, _, condition = force_noise(slope, sensors, within)
        if condition is None:
            raise RefusedError("the sensors within their range are too few to tell the forces on all pins")
        inverse = np.linalg.pinv(slope)
        for _ in range(MOST_CORRECTIONS):
            field = pins.fields(moved(pins, *own(load, reading))).sum(axis=1)
            change = (inverse @ (read - field).ravel()).reshape(load.shape)
            load = load + change
            if np.abs(change).max() <= SETTLED * np.abs(load).max():
                break
        else:
            rule = f"do not settle at step {step}; take finer steps or less noise"
            raise RefusedError(f"the forces that the readings tell {rule}")
        forces.append(load)
        off = np.linalg.norm(inverse @ pins.uncertain(moved(pins, *own(load, reading))), axis=1)
        noise.append((floor, sensors.rms * float(np.linalg.norm(inverse[::3].sum(axis=0))), off.max()))
    floors, pulls, errors = zip(*noise, strict=True)
    return ForceEstimates(np.array(forces[1:]), np.max(floors, axis=0), max(pulls), float(max(errors)))


def slip_steps(estimates: ForceEstimates, time: Array, rate: float) -> list[int | None]:
    """Return from which step on each pin's pull, a mean over AVERAGED samples, is told to have fallen behind
    its share of the whole pull before; None for a pin whose does not. The share is that of least squares."""
    steps, samples = np.arange(len(time)), np.floor(time * rate + 1e-6)
    first = np.searchsorted(samples, samples - AVERAGED, side="right")  # of a mean's steps
    new = np.diff(samples, prepend=-1.0) > 0  # steps that show a sample of their own
    shown = _sums(new.astype(float))
    count = np.maximum(shown[steps + 1] - shown[first], 1.0)[:, None]
    pull = estimates.forces[:, :, 0]
    whole = np.abs(pull.sum(axis=1))
    least = max(PULLED * estimates.pull, FAINT * float(whole.max()), 1e-12)
    start = int((whole > least).argmax())
    by_press = pull[first[start] : start + 1].mean(axis=0)  # and by the pull's first part
    pull = np.where(((steps > start) & new)[:, None], pull - by_press, 0.0)
    whole = pull.sum(axis=1, keepdims=True)
    mean, mean_whole = ((_sums(of)[steps + 1] - _sums(of)[first]) / count for of in (pull, whole))
    before, squared = _sums(whole * pull)[first], _sums(whole**2)[first]
    share = before / np.maximum(squared, 1e-300)
    noise = estimates.floor[:, 0] * np.sqrt(1 / count + mean_whole**2 / np.maximum(squared, 1e-300))
    behind = np.abs(share * mean_whole) - np.sign(share * mean_whole) * mean
    known = (squared > least**2) & (first > start)[:, None]
    fallen = known & (behind > SURE * noise + FALLS * np.abs(share * mean_whole))
    return [int(column.argmax()) if column.any() else None for column in fallen.T]


def _sums(values: Array) -> Array:
    """Sums of all values before each, and of all at the end."""
    return np.concatenate([0.0 * values[:1], np.cumsum(values, axis=0)])


def _by_number(values: Array) -> dict[str, dict[str, list[float]]]:
    """Values `(steps, m, 3)` by the number of their sensor or pin, from 1, and axis."""
    return {
        str(i + 1): {axis: values[:, i, k].tolist() for k, axis in enumerate(AXES)}
        for i in range(values.shape[1])
    }
