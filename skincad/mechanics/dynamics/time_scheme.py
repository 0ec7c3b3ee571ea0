"""The time integration scheme: generalised-alpha with masses, its first-order form without.

With masses the equation is met at a point within the step: Chung and Hulbert, J. Appl. Mech. 60 (1993) 371.
Without, as Jansen, Whiting, Hulbert, CMAME 190 (2000) 305, whose method damps the highest modes out
in one step; with equal steps it is BDF2. Both are of order 2 where velocities are smooth.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Matter:
    """Inertia and viscosity in a step. `damped`: with masses, None without; `plate` g; `rate` s, the viscous
    stress per strain rate by the elastic one per strain; `relaxing`, pairs of stiffness and time, s."""

    damped: float | None = None
    plate: float = 0.0
    rate: float = 0.0
    relaxing: tuple[tuple[float, float], ...] = ()


@dataclass(frozen=True)
class Scheme:
    """A method's numbers for one step of `dt` s: velocity is `speed` times displacement less a predictor,
    acceleration `force` times it; the equation is met at `late` of the step from its end, the acceleration's
    at `lag`."""

    dt: float
    late: float
    lag: float
    beta: float
    gamma: float
    moves: bool

    @property
    def speed(self) -> float:
        """What a displacement of 1 at the end adds to the velocity."""
        return self.gamma / (self.beta * self.dt) if self.moves else 1.5 / self.dt

    @property
    def force(self) -> float:
        """What it adds to the mass's force, per mass, of an equation divided by 1 - late."""
        return (1 - self.lag) / ((1 - self.late) * self.beta * self.dt**2) if self.moves else 0.0

    @property
    def before(self) -> float:
        """Weight of the forces at the step's start by those at its end."""
        return self.late / (1 - self.late)


def scheme(dt: float, damped: float | None) -> Scheme:
    """Return the method: with masses Chung and Hulbert's eqs. 17, 20, 21, 25; without, rates alone."""
    if damped is None:
        return Scheme(dt, 0.0, 0.0, 1.0, 1.0, False)
    lag, late = (2 * damped - 1) / (damped + 1), damped / (damped + 1)
    return Scheme(dt, late, lag, (1 - lag + late) ** 2 / 4, 0.5 - lag + late, True)
