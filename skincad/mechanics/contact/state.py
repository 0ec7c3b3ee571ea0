"""The state of a contact with friction, what drives it, and the laws of friction.

The force that friction bears at a contact point, by its normal force and its area: by Coulomb's law the
normal force times a coefficient. Other laws give the shear stress over the pressure, straight between a few
breakpoints and constant beyond the last; one breakpoint is a constant shear stress capped by Coulomb. A
sliding point's force is then t = slope p + stress a, both of the line on which its pressure lies: for given
lines the equations of a step stay linear, and the lines are one more set to be found.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from skincad.base.arrays import Array, Index, Mask
from skincad.mechanics.problem import ContactError

NO_LINES = np.zeros(0, dtype=np.int64)
Status = NDArray[np.int8]

OPEN, STICK, RIGHT, LEFT = 0, 1, 2, 3  # RIGHT: slips with t to +x, as the plate drags it; LEFT to -x
MOVES = 1e-9  # of the approach; less is no slip but rounding


@dataclass(frozen=True)
class FrictionCoefficients:
    """Coefficients of friction: `static` holds a point that sticks, `kinetic` drags one that slips.

    `breakpoints` are pairs of a pressure and the shear stress that static friction bears at it, both MPa and
    rising: straight from 0 on, by `static`, from breakpoint to breakpoint, and constant beyond the last.
    Without any the law is Coulomb's. Kinetic friction is the same part of static friction everywhere.
    A point that sticks bears `sticks`, one that slides `slides` times the force `borne`.
    """

    static: float
    kinetic: float
    breakpoints: tuple[tuple[float, float], ...] = ()

    @property
    def sticks(self) -> float:
        """What a point that sticks bears at most of the force `borne`."""
        return 1.0 if self.breakpoints else self.static

    @property
    def slides(self) -> float:
        """What a point that slides bears of the force `borne`."""
        return self.kinetic / self.static if self.breakpoints else self.kinetic

    @cached_property
    def _lines(self) -> tuple[Array, Array, Array, Array]:
        """Pressures and shear stresses at which lines begin, MPa, their slopes, and their offsets, MPa."""
        pressure, stress = np.array([(0.0, 0.0), *self.breakpoints]).T
        slopes = np.append(np.diff(stress) / np.diff(pressure), 0.0)
        return pressure, stress, slopes, stress - slopes * pressure

    def borne(self, normal: Array, area: Array) -> Array:
        """Return the normal forces `(m,)` N or, with breakpoints, what static friction bears at them, N, at
        points of `area` `(m,)` mm2."""
        return area * np.interp(normal / area, *self._lines[:2]) if self.breakpoints else normal

    def line(self, normal: Array, area: Array) -> Index:
        """Return on which line each point lies `(m,)`, 0 up to the first breakpoint; nothing without any."""
        return np.searchsorted(self._lines[0][1:], normal / area) if self.breakpoints else NO_LINES

    def sliding(self, line: Index, way: Array, area: Array) -> tuple[Array, Array | None]:
        """Return slope and offset N `(m,)` of what drags points that slide on these lines, to +x where `way`
        is 1 and to -x where it is -1; None where no law has an offset."""
        along = self.slides * way
        if not self.breakpoints:
            return along, None
        _, _, slopes, offsets = self._lines
        return along * slopes[line], along * offsets[line] * area

    def capped(self, share: float) -> FrictionCoefficients:
        """Return the law that bears no more than this share of `static` times the pressure, else as much."""
        slope, last, breakpoints = share * self.static, (0.0, 0.0), list[tuple[float, float]]()
        for pressure, stress in self.breakpoints:
            if stress < slope * pressure:
                if not breakpoints:
                    rise = (stress - last[1]) / (pressure - last[0])
                    meets = (last[1] - rise * last[0]) / (slope - rise)
                    breakpoints.append((meets, slope * meets))
                breakpoints.append((pressure, stress))
            last = pressure, stress
        if self.breakpoints and not breakpoints:
            breakpoints.append((last[1] / slope, last[1]))
        return FrictionCoefficients(slope, share * self.kinetic, tuple(breakpoints))


@dataclass(frozen=True)
class Drive:
    """What the plate does at a step's end: normal force, N, and tangential force, N, or travel, mm, both
    along the plate at its `angle` about y, rad, positive where it rises towards +x.

    Of a plate with mass the forces fall by its inertia, `stiffness` N/mm times the distance of its approach
    and travel from those `ahead`, mm. Counting from there avoids cancellation for a heavy plate.
    """

    normal: float
    tangential: float | None = None
    travel: float | None = None
    angle: float = 0.0
    stiffness: float = 0.0
    ahead: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True, eq=False)
class ContactState:
    """A contact state: forces `normal`, `tangential` `(m,)` N on the skin (compression, to +x), `anchor`
    `(m,)` mm and `status` `(m,)`, the plate's `approach` and `travel`, mm. `slipped` `(m,)` is what each
    point slid in the step, mm; `residual` the largest relative violation. Of points that may slide along y
    too, `tangential` and `anchor` are `(2 m,)`, x first.
    """

    normal: Array
    tangential: Array
    anchor: Array
    status: Status
    slipped: Array
    approach: float = 0.0
    travel: float = 0.0
    residual: float = 0.0
    gross: bool = False  # all that touches slips, the last point having just begun
    angle: float = 0.0  # of the plate, rad

    @property
    def contact(self) -> Self:
        """The state itself, of a pad whose states are its contact."""
        return self

    @property
    def slips(self) -> Mask:
        """Points `(m,)` that slide on the plate."""
        if self.gross:
            return np.asarray(self.status >= RIGHT)
        least = MOVES * max(abs(self.approach), 1e-12)
        return np.asarray((self.status >= RIGHT) & (np.abs(self.slipped) > least))

    @property
    def force(self) -> Array:
        """Forces on the skin `(2 m,)` N, in x, then in z."""
        return np.concatenate([self.tangential, -self.normal])

    @property
    def touches(self) -> Mask:
        """Points `(m,)` that touch the plate."""
        return np.asarray(self.status != OPEN)


class GrossSlip(ContactError):  # noqa: N818
    """No equilibrium: the tangential force is more than friction holds. `last` is the state that slips."""

    def __init__(self, last: Any, words: str) -> None:
        super().__init__(words)
        self.last = last


@dataclass(frozen=True, eq=False)
class Compliance:
    """The elastic side of a step: u = compliance @ (t, -p) + free, `(2 m,)` mm, and the gaps `(m,)`, mm.

    `solved` remembers the last sets' factorisations, for the steps in which the sets stay, under a `tag`
    where the compliance changes with a step's length. `area` `(m,)` mm2 of the points is what friction by
    shear stress asks for.
    """

    compliance: Array
    gap: Array
    free: Array
    solved: dict[bytes, Any] = field(default_factory=dict)
    area: Array = field(default_factory=lambda: np.zeros(0))
    tag: bytes = b""

    def swung(self, swing: Swing) -> Compliance:
        """Return the same with what masses add in a step."""
        whole = self.compliance + swing.compliance
        return replace(self, compliance=whole, free=self.free + swing.free, tag=swing.tag)


@dataclass(frozen=True, eq=False)
class Swing:
    """What masses add to a step: `compliance` `(2 m, 2 m)` mm/N and displacements `free` `(2 m,)` mm of the
    contact points, beside those of a pad without masses; `drive` has the plate's inertia and the effective
    forces on it. `tag` names the step's length."""

    compliance: Array
    free: Array
    drive: Drive
    tag: bytes

    def sunk(self, force: Array) -> Array:
        """Return how much lower masses let the points be `(m,)`, mm, under forces `(2 m,)` N."""
        moved = self.free + self.compliance @ force
        return np.asarray(-moved[moved.size // 2 :])


def at_rest(points: int) -> ContactState:
    """Return the unloaded start of `points` points."""
    zero = np.zeros(points)
    return ContactState(zero, zero, zero, np.zeros(points, dtype=np.int8), zero)
