"""The tables of a scene that say what the plate does, what it is, and what is told."""

from __future__ import annotations

from functools import cached_property
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import BeforeValidator, Field, model_validator

from skincad.base.arrays import Array, Index
from skincad.base.errors import InputError
from skincad.base.tables import Table, quantity
from skincad.mechanics.contact.state import Drive

MOST_FRAMES = 60  # of an animation of less than 2 MB
STEEPEST = 5.0  # deg; of a plate that turns, as of a tilted one (design.py)
# of a history; forces as contact.force, travel as the widest skin (design.py)
LARGEST = {"time_s": 1e6, "normal_force_N": 1e6, "tangential_force_N": 1e6, "displacement_mm": 1e3}
NARROWEST = 1e-4  # Hz; less shows nothing of the longest history
SHORTEST = 1e-9  # s; assumption: sound passes a micrometre of silicone, far less than any mesh shows
ROUNDING = 4.0  # units in the last place of the history's end: as far as two sums to one time are apart


def _listed(value: Any) -> Any:
    """A tuple, range or array as the list that a file has."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    return list(value) if isinstance(value, tuple | range) else value


Numbers = Annotated[list[float], BeforeValidator(_listed)]


class History(Table):
    """What the plate does: points in time, straight lines between them."""

    time_s: Numbers = Field(
        description="of each point, from 0", min_length=2, max_length=10_000, json_schema_extra={"unit": "s"}
    )
    normal_force_N: Numbers = Field(  # noqa: N815
        description="of the plate on the skin, at each point", json_schema_extra={"unit": "N"}
    )
    tangential_force_N: Numbers | None = Field(  # noqa: N815
        default=None, description="of the plate on the skin, to +x", json_schema_extra={"unit": "N"}
    )
    displacement_mm: Numbers | None = Field(
        default=None, description="of a driven plate, to +x, instead", json_schema_extra={"unit": "mm"}
    )
    rotation_deg: Numbers | None = Field(
        default=None,
        description="of the plate about y, positive where it rises towards +x; forces and displacement "
        "are then normal to the plate and along it",
        json_schema_extra={"unit": "deg"},
    )
    steps: int = Field(
        description="number of equal time steps; a corner between two of them adds a step of its own",
        ge=1,
        le=1_000_000,
    )

    @model_validator(mode="after")
    def _rules(self) -> Self:
        self._check_lists()
        if self.time_s[0] != 0.0:
            raise InputError("time_s", "must begin at 0", self.time_s[0])
        for a, b in zip(self.time_s, self.time_s[1:], strict=False):
            if not b > a:
                raise InputError("time_s", f"must not go back or stand still after {a:g} s", b)
            if b - a < SHORTEST:
                raise InputError("time_s", f"needs points at least {SHORTEST:g} s apart", b - a)
        if min(self.normal_force_N) < 0:
            rule = "must not pull: the plate presses or is clear"
            raise InputError("normal_force_N", rule, min(self.normal_force_N), "take 0 or more")
        if self.normal_force_N[0] != 0.0:
            raise InputError("normal_force_N", "must begin unloaded, at 0", self.normal_force_N[0])
        drives = [self.tangential_force_N, self.displacement_mm]
        if drives.count(None) != 1:
            rule = "needs either tangential_force_N or displacement_mm"
            raise InputError("", rule, remedy="give the one that the plate is driven by")
        pull = self.tangential_force_N or self.displacement_mm or [0.0]
        if pull[0] != 0.0:
            key = "tangential_force_N" if self.tangential_force_N else "displacement_mm"
            raise InputError(key, "must begin at 0", pull[0])
        turn = self.rotation_deg or [0.0]
        if turn[0] != 0.0:
            raise InputError("rotation_deg", "must begin at 0", turn[0])
        if max(map(abs, turn)) > STEEPEST:
            rule = f"must be from -{STEEPEST:g} to {STEEPEST:g} deg: beyond, the plate meets more than ridges"
            raise InputError("rotation_deg", rule, max(turn, key=abs))
        return self

    def _check_lists(self) -> None:
        """Raise InputError for lists that are not of one length, or hold what no scene can mean."""
        for key in (*LARGEST, "rotation_deg"):
            values = getattr(self, key)
            if values is not None and len(values) != len(self.time_s):
                raise InputError(key, f"needs {len(self.time_s)} values, as time_s has", len(values))
        for key, most in LARGEST.items():
            largest = max(getattr(self, key) or [0.0], key=abs)
            if abs(largest) > most:
                raise InputError(key, f"must be at most {most:g} {key.rpartition('_')[2]} in size", largest)

    @cached_property
    def times(self) -> Array:
        """Times of the march, s: `steps + 1` equally spaced ones, and every corner between two of these.

        A march that stepped over a corner would not know of it: a short pull would be lost.
        """
        even, corners = self._even_times, self._corners
        gap = np.abs(even[self._nearest(even, corners)] - corners)
        return np.union1d(even, corners[gap > ROUNDING * np.spacing(even[-1])])

    @cached_property
    def even(self) -> Index:
        """Places of the equally spaced times in `times`, `(steps + 1,)`."""
        return np.asarray(np.searchsorted(self.times, self._even_times))

    @property
    def step_count(self) -> int:
        """Number of steps of the march: `steps`, and one more for each corner between two of them."""
        return self.times.size - 1

    @property
    def points(self) -> Index:
        """Places in `times` of the history's points, those without a corner at the time next to them."""
        return self._nearest(self.times, np.array(self.time_s))

    @property
    def _even_times(self) -> Array:
        return np.linspace(0.0, self.time_s[-1], self.steps + 1)

    @property
    def _corners(self) -> Array:
        """Times of the points at which a line bends; one that lies on the line tells nothing, but for
        rounding of its values and its time."""
        time = np.array(self.time_s)
        bends = np.zeros(time.size, dtype=bool)
        before, span = np.diff(time)[:-1], time[2:] - time[:-2]
        for key in (*LARGEST, "rotation_deg"):
            if key == "time_s" or (listed := getattr(self, key)) is None:
                continue
            values = np.array(listed)
            slope = (values[2:] - values[:-2]) / span
            off = np.abs(values[1:-1] - values[:-2] - slope * before)
            rounding = np.spacing(np.abs(values).max()) + np.abs(slope) * np.spacing(time[-1])
            bends[1:-1] |= off > ROUNDING * rounding
        return time[bends]

    @staticmethod
    def _nearest(times: Array, wanted: Array) -> Index:
        """Return the places in `times` nearest to those `wanted`."""
        after = np.clip(np.searchsorted(times, wanted), 1, times.size - 1)
        return np.asarray(after - (wanted - times[after - 1] <= times[after] - wanted))

    def drives(self) -> list[Drive]:
        """Return what the plate does at each of `times`."""
        at, points = self.times, self.time_s
        normal = np.interp(at, points, self.normal_force_N).tolist()
        angles = np.radians(np.interp(at, points, self.rotation_deg or [0.0] * len(points))).tolist()
        if self.tangential_force_N is not None:
            pulls = np.interp(at, points, self.tangential_force_N).tolist()
            return [Drive(n, tangential=t, angle=a) for n, t, a in zip(normal, pulls, angles, strict=True)]
        moves = np.interp(at, points, self.displacement_mm or []).tolist()
        return [Drive(n, travel=s, angle=a) for n, s, a in zip(normal, moves, angles, strict=True)]


class ScenePlate(Table):
    """The rigid plate."""

    shape: Literal["flat"] = Field(default="flat", description="flat; it keeps its angle")
    mass: float | None = quantity("g", "of the plate; needs effects.inertia", gt=0.0, le=1e6, default=None)


class Readout(Table):
    """What is reported."""

    ridges: Annotated[list[int], BeforeValidator(_listed)] = Field(
        default=[], description="ridges whose films' stresses are reported", max_length=999
    )
    bandwidth_Hz: float = quantity(  # noqa: N815
        "Hz", "of the signals, where they are down by 3 dB", gt=0.0, le=1e9, default=5000.0
    )
    alarms: Literal["sure", "early"] = Field(
        default="sure", description="of the slip detector: few false ones, or few slips without one"
    )
    steps: Annotated[list[Annotated[int, Field(ge=0)]], BeforeValidator(_listed)] = Field(
        default=[], description="at which the deformed section is drawn with its stress", max_length=100
    )
    frames: int = Field(
        default=0, description="of an animated picture of the section; 0: none", ge=0, le=MOST_FRAMES
    )

    @model_validator(mode="after")
    def _rules(self) -> Self:
        if self.bandwidth_Hz < NARROWEST:
            raise InputError("bandwidth_Hz", f"must be at least {NARROWEST:g} Hz", self.bandwidth_Hz)
        return self
