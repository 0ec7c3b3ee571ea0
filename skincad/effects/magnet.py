"""Magnets in the pins, read by magnetometers under the skin: fields, and the forces and slips that they tell.

The field is exact for the magnets where the forces on the tips have put them (mechanics/magnetics.py), with
the sway of a pressed pin on top (mechanics/contact/tips.py). A sensor takes samples at its rate, from the
start on; a step shows the last one, with noise, rounding and the range's end. Forces follow from all readings
by least squares and the skin's own model; the field of the unloaded skin is known from before. A slip is told
where a pin's pull stays behind its share of the whole pull by more than noise may.
Range: that of pins in a scene (effects/pin_pad.py); sensors without lag, offset or errors of scale.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from pydantic import Field

from skincad.base.arrays import Array, Mask
from skincad.base.errors import InputError
from skincad.effects.kinds import Observables, Reader, ReaderContext
from skincad.inputs.design import Design
from skincad.inputs.feature_tables import Magnetometer
from skincad.mechanics.magnetics import MagneticPins, force_noise, magnetic_pins

AXES = "x", "y", "z"
SURE, FALLS = 4.0, 0.05  # times its noise, and of its share, by which a pull stays behind in a slip
CORRECTIONS = 6  # of forces, by a fixed map: an error of a third is then below 0.002
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
        on the pin; its largest error against the march, N; and the step from which the readings tell each
        pin's slip, None for none."""
        from skincad.effects.pin_pad import pin_pad

        sensors, pins = watched.design.magnetometer, magnetic_pins(watched.design)
        assert sensors is not None  # as it is checked
        tips, soften = np.array([reading.tips for reading in readings]), pin_pad(watched.design).tips.soften

        def fields(forces: Array) -> Array:
            """The sensors' fields `(..., s, 3)` mT under forces on tips; a pressed pin sways the more."""
            sway = 1 - np.clip(-forces[..., 2] * soften, 0.0, SWAYS)
            bending = forces / np.stack([sway, sway, np.ones_like(sway)], axis=-1)
            return np.array([pins.fields(pins.poses(load)).sum(axis=1) for load in bending])

        field = fields(tips)
        seen = sampled(field, time, sensors, self.noise_seed)
        beyond = np.abs(field).max(axis=(0, 2)) > sensors.range
        estimates = force_estimates(seen, fields, pins, sensors, ~beyond)
        bent = any(reading.drift is not None for reading in readings)
        further = (
            "at finite strain tips go further than the map of magnets knows, by a sixth on magnet-pillars"
        )
        notes = [further] * bent + [
            f"sensor {i + 1} leaves its range of {sensors.range:g} mT" for i in np.flatnonzero(beyond)
        ]
        forces: dict[str, Any] = {"magnet_slip_step": [None] * len(pins.middle)}
        if estimates is None:
            notes.append("the sensors within their range are too few to tell the forces on all pins")
        else:
            forces = {
                "pin_force_N": _by_number(estimates.forces),
                "pin_force_error_N": float(np.abs(estimates.forces - tips).max()),
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


class ForceEstimates(NamedTuple):
    """The `forces` on tips `(steps, n, 3)` N that readings tell, their noise rms, the `floor` `(n, 3)` N, and
    that of the whole `pull` along x, N."""

    forces: Array
    floor: Array
    pull: float


def force_estimates(
    seen: Array, fields: Callable[[Array], Array], pins: MagneticPins, sensors: Magnetometer, within: Mask
) -> ForceEstimates | None:
    """Return the forces that readings `(steps, s, 3)` mT of the sensors `within` `(s,)` their range tell, if
    they do: by the map of an unloaded skin, and by it again for what `fields` of these forces are off."""
    slope = pins.slope(np.zeros((len(pins.middle), 6))) * np.repeat(within, 3)[:, None]
    floor, _, condition = force_noise(slope, sensors, within)
    if condition is None:
        return None
    inverse, forces = np.linalg.pinv(slope), np.zeros((len(seen), len(pins.middle), 3))
    for _ in range(CORRECTIONS):
        missing = (seen - fields(forces)).reshape(len(seen), -1)
        forces = forces + (missing @ inverse.T).reshape(forces.shape)
    return ForceEstimates(forces, floor, sensors.rms * float(np.linalg.norm(inverse[::3].sum(axis=0))))


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
