"""The tables of a scene that say what the plate does, what it is, and what is told."""

from __future__ import annotations

from functools import cached_property
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import BeforeValidator, Field, model_validator

from skincad.base.arrays import Array
from skincad.base.errors import InputError
from skincad.base.tables import Table, quantity
from skincad.mechanics.contact.grip import Drive

MOST_FRAMES = 60  # of an animation of less than 2 MB
STEEPEST = 5.0  # deg; of a plate that turns, as of a tilted one (design.py)
# of a history; forces as contact.force, travel as the widest skin (design.py)
LARGEST = {"time_s": 1e6, "normal_force_N": 1e6, "tangential_force_N": 1e6, "displacement_mm": 1e3}
NARROWEST = 1e-4  # Hz; less shows nothing of the longest history
SHORTEST = 1e-9  # s; assumption: sound passes a micrometre of silicone, far less than any mesh shows


def _listed(given: Any) -> Any:
    """A tuple, range or array as the list that a file has."""
    if isinstance(given, np.ndarray):
        return given.tolist()
    return list(given) if isinstance(given, tuple | range) else given


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
    steps: int = Field(description="number of equal time steps", ge=1, le=1_000_000)

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
        given = [self.tangential_force_N, self.displacement_mm]
        if given.count(None) != 1:
            rule = "needs either tangential_force_N or displacement_mm"
            raise InputError("", rule, remedy="give the one that the plate is driven by")
        across = self.tangential_force_N or self.displacement_mm or [0.0]
        if across[0] != 0.0:
            key = "tangential_force_N" if self.tangential_force_N else "displacement_mm"
            raise InputError(key, "must begin at 0", across[0])
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
        """Times `(steps + 1,)`, s."""
        return np.linspace(0.0, self.time_s[-1], self.steps + 1)

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
