"""How two fingers grip and lift an object, and how hard they grip once they hear a slip.

Each finger carries half of the object. Its skin is pressed by the grip, and pulled by half of the weight, as
the table gives it up, and by half of what the lift's acceleration asks. A gripper does what it is told after
its `delay`, at its `force_rate`, up to its `force_max`: a pure delay, then straight rises and falls.

A policy says at each sample how hard to grip, from what is known by then. Friction it does not know, but for
`force`, which nobody can build: it is what a gripper could do that knew friction and pull.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import BeforeValidator, Field, model_validator

from skincad.base.arrays import Array, Mask
from skincad.base.errors import InputError
from skincad.base.tables import Table, quantity
from skincad.detector.detector import Detector
from skincad.inputs.gripper import Gripper, gripper_named

GRAVITY = 9.81  # m/s2
FINGERS = 2  # that share the object
PLANNED = 500  # steps of a lift's plan
HEARING = "detector", "stress-rate"  # policies that hear the films


def listed(value: object) -> object:
    """Return a tuple, range or array as the list that a file has."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    return list(value) if isinstance(value, tuple | range) else value


Numbers = Annotated[list[float], BeforeValidator(listed)]


class Grip(Table):
    """Two alike fingers grip an object and lift it."""

    gripper: str = Field(description="one of `skincad templates grippers`, or of the design's [grippers]")
    policy: Literal["constant", "detector", "stress-rate", "force"] = Field(
        default="detector",
        description="constant: never grips harder; detector: at each alarm; stress-rate: where it falls, as "
        "the paper has it; force: by the pull and the friction, which no gripper knows",
    )
    mass: float = quantity("g", "of the object; each finger carries half", gt=0.0, le=1e5)
    force: float = quantity("N", "of each finger before the lift", gt=0.0, le=1e5)
    close: float = quantity(
        "s", "in which the fingers reach that force; nothing is felt then", ge=1e-3, le=100.0, default=0.1
    )
    rise: float = quantity("s", "in which the table gives up the weight", ge=1e-3, le=100.0, default=0.3)
    acceleration: float = quantity(
        "m/s2", "largest one of the lift: up, then down again", ge=0.0, le=1e3, default=2.0
    )
    lift: float = quantity("s", "of the lift, from rest to rest", ge=1e-3, le=100.0, default=0.3)
    hold: float = quantity("s", "for which the object is held after it", ge=1e-3, le=100.0, default=0.3)
    load_time_s: Numbers | None = Field(
        default=None,
        min_length=2,
        max_length=10_000,
        description="s, once the fingers have closed: the load's points, in place of rise, lift and hold",
    )
    load_N: Numbers | None = Field(  # noqa: N815
        default=None, min_length=2, max_length=10_000, description="N, on each finger at each point"
    )
    delay: float | None = quantity(
        "s",
        "from what is felt to a change of force; the gripper's if not given",
        ge=1e-3,
        le=10.0,
        default=None,
    )
    force_rate: float | None = quantity(
        "N/s", "how fast a finger's force changes; the gripper's if not given", gt=0.0, le=1e6, default=None
    )
    force_max: float | None = quantity(
        "N", "largest force of a finger; the gripper's if not given", gt=0.0, le=1e6, default=None
    )

    @model_validator(mode="after")
    def _rules(self) -> Self:
        time, load = self.load_time_s, self.load_N
        if (time is None) != (load is None):
            key = "load_time_s" if time is None else "load_N"
            raise InputError(key, "is missing beside the other of load_time_s and load_N")
        if time is None or load is None:
            return self
        if len(time) != len(load):
            raise InputError("load_N", f"needs {len(time)} values, as load_time_s has", len(load))
        if time[0] != 0.0 or load[0] != 0.0:
            raise InputError("load_N" if load[0] else "load_time_s", "must begin at 0", load[0] or time[0])
        if not all(b > a for a, b in pairwise(time)):
            raise InputError("load_time_s", "must rise from point to point")
        if not any(load):
            raise InputError("load_N", "must not be 0 all along")
        return self

    @property
    def points(self) -> tuple[Array, Array]:
        """Times, s from the first touch, and loads on each finger at them, N: straight lines between."""
        if self.load_time_s is not None and self.load_N is not None:
            later = self.close + np.array(self.load_time_s)
            return np.append(0.0, later), np.append(0.0, self.load_N)
        carried = 1e-3 * self.mass / FINGERS
        shares = np.array([0.0, 0.25, 0.75, 1.0])
        begun = self.close + self.rise
        time = [0.0, self.close, *(begun + shares * self.lift), begun + self.lift + self.hold]
        up = np.array([0.0, self.acceleration, -self.acceleration, 0.0])
        return np.array(time), np.array([0.0, 0.0, *(carried * (GRAVITY + up)), carried * GRAVITY])

    def plan(self) -> dict[str, object]:
        """Return the history of a plate under the first grip and the load: what a lift is without slips."""
        time, load = self.points
        normal = [0.0, *([self.force] * (time.size - 1))]
        tables = {"time_s": time.tolist(), "normal_force_N": normal, "tangential_force_N": load.tolist()}
        return {**tables, "steps": PLANNED}

    def acts(self, own: dict[str, Gripper]) -> Grip:
        """Return the same with what is not given as the gripper has it. Raises InputError for a gripper that
        nobody knows, or of which that is not known."""
        try:
            gripper = gripper_named(self.gripper, own)
        except InputError as failure:
            raise InputError("gripper", failure.rule, failure.value, failure.remedy) from None
        known = {}
        for key in ("delay", "force_rate", "force_max"):
            value = getattr(self, key)
            value = getattr(gripper, key) if value is None else value
            if value is None:
                raise InputError(key, f"is missing, and {self.gripper} has none", remedy=f"give grip.{key}")
            known[key] = value
        if self.force > known["force_max"]:
            rule = f"must be at most the gripper's largest, {known['force_max']:g} N"
            raise InputError("force", rule, self.force)
        if self.force < (gripper.force_min or 0.0):
            rule = f"must be at least what {self.gripper} can hold, {gripper.force_min:g} N"
            raise InputError("force", rule, self.force)
        return self.model_copy(update=known)


# of the first force, at the first alarm of a detector, and where a stress-rate falls, which is more often;
# set on even seeds of bench/lifts, as are the next two
HARDER, HARDER_BY_RATE = 0.4, 0.25
LESS = 0.75  # power of an alarm's number, by which its raise is smaller
PAUSE = 0.6  # of the delay, until it is asked again
SPARE = 1.1  # of the force that friction needs; assumption


class Raising:
    """Grips harder where `heard` finds that it has to, and again after PAUSE where that lasts. The nth raise
    is `harder` / n^LESS of the first force: the first ones are quick, and a skin that always alarms is not
    squeezed without end. `late` is the gripper's delay, in samples; `begun` is the sample from which on it
    hears."""

    def __init__(
        self, heard: Callable[[Array], Mask], late: float, begun: int, harder: float = HARDER
    ) -> None:
        self.heard, self.pause, self.begun = heard, max(1, math.ceil(PAUSE * late)), begun
        self.harder = harder
        self.alarms: list[int] = []
        self.count, self.first = 0, 0.0

    def wanted(self, outputs: Array, force: float, count: int) -> Array:
        """Return the force asked of a finger `(count,)` N, raised at slips, at each sample since the last:
        `outputs` `(count, ridges, 2)` V of the wired films, after `force` N was asked for."""
        asked = np.empty(count)
        self.first = self.first or force
        last = self.alarms[-1] if self.alarms else -math.inf
        for i, slips in enumerate(self.heard(outputs).tolist()):
            at = self.count + i
            if slips and at >= self.begun and at >= last + self.pause:
                last = at
                self.alarms.append(at)
                force += self.harder / len(self.alarms) ** LESS * self.first
            asked[i] = force
        self.count += count
        return asked


class Force:
    """Grips as the `load` `(n,)` N to come needs at this friction, with SPARE, in time for a gripper that is
    `ahead` samples late; never less than at first, `least` N."""

    def __init__(self, friction: float, least: float, load: Array, ahead: int) -> None:
        padded = np.pad(np.abs(load), (0, ahead), mode="edge")
        coming = np.lib.stride_tricks.sliding_window_view(padded, ahead + 1).max(axis=1)
        self.needed = np.maximum(SPARE * coming / friction, least)
        self.alarms: list[int] = []
        self.count = 0

    def wanted(self, outputs: Array, force: float, count: int) -> Array:  # noqa: ARG002
        """Return what friction needs, as `Raising.wanted`."""
        self.count += count
        return np.asarray(self.needed[self.count - count : self.count])


def alarmed(detector: Detector) -> Callable[[Array], Mask]:
    """Return what finds the samples `(n,)` at which a detector that is asked at each warns."""

    def heard(outputs: Array) -> Mask:
        told = detector.decisions(outputs.reshape(outputs.shape[0], -1))[1]
        return np.asarray(told.any(axis=1))

    return heard


DROP = 0.5  # of the largest of late, set on even seeds of bench/lifts
LATE = 10  # windows; assumption
LOUD = 5.0  # noise rms, below which nothing has fallen; as the detector's SEEN


def fallen(window: int, noise: float, *, differs: bool) -> Callable[[Array], Mask]:
    """Return what finds the samples `(n,)` at which a pair's differential stress-rate falls within a window
    by DROP of its largest of late, which is the paper's sign of a slip. Where it `differs`, outputs are the
    stress, as a charge amplifier's, and the rate is a pair's change in a window; else they are the rate.
    `noise` V rms of a pair."""
    past: list[Array] = []
    kept = (LATE + 1) * window
    least = LOUD * noise * (math.sqrt(2) if differs else 1.0)

    def heard(outputs: Array) -> Mask:
        n = outputs.shape[0]
        new = outputs[:, :, 0] - outputs[:, :, 1]
        before = past[-1] if past else np.tile(new[:1] if differs else 0.0 * new[:1], (kept, 1))
        pair = np.concatenate([before, new])
        past[:] = [pair[-kept:]]
        rate = np.abs(pair[window:] - pair[:-window] if differs else pair[window:])
        views = np.lib.stride_tricks.sliding_window_view(rate, LATE * window, axis=0)[1:]
        largest, falls = views.max(axis=-1), rate[-n - window : -window] - rate[-n:]
        return np.asarray(((falls > DROP * largest) & (largest > least)).any(axis=1))

    return heard


def followed(grip: Grip, wanted: Array, before: float, step: float) -> Array:
    """Return a finger's force `(n,)` N at samples `step` s apart, after `before` N, which goes to what was
    `wanted` `(n,)` of it a delay ago."""
    most = (grip.force_rate or math.inf) * step
    force = np.empty(wanted.size)
    for i, goal in enumerate(np.minimum(wanted, grip.force_max or math.inf).tolist()):
        before = before + min(max(goal - before, -most), most)
        force[i] = before
    return force
