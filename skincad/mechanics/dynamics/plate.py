"""The rigid plate over a step: its inertia, where it gets to, and the work done at it."""

from __future__ import annotations

import numpy as np

from skincad.base.arrays import Array
from skincad.mechanics.contact.grip import Drive, Grip, Inert
from skincad.mechanics.dynamics.state import DynamicState
from skincad.mechanics.dynamics.time_scheme import Scheme

TONNE = 1e-6  # of a gram


def pushed_plate(state: DynamicState, drive: Drive, s: Scheme) -> tuple[Inert | None, Drive]:
    """The plate's own inertia over a step, and the forces that drive it there."""
    if not s.moves or not state.matter.plate:
        return None, drive
    mass, dt = TONNE * state.matter.plate, s.dt
    place, speed, rate = state.plate
    ahead = place + dt * speed + dt**2 * (0.5 - s.beta) * rate
    now = np.array([drive.normal, drive.tangential or 0.0])
    was = np.array([state.drive.normal, state.drive.tangential or 0.0])
    borne = np.array([state.grip.normal.sum(), state.grip.tangential.sum()])
    force = now + s.before * (was - borne) - mass * s.lag / (1 - s.late) * rate
    effective = Drive(float(force[0]), None if drive.travel is not None else float(force[1]), drive.travel)
    return Inert(mass * s.force, float(ahead[0]), float(ahead[1])), effective


def carried(
    state: DynamicState, drive: Drive, found: Grip, s: Scheme, pushing: tuple[Inert | None, Drive]
) -> Array:
    """The plate's place, speed and acceleration `(3, 2)` after a step, from the forces that it lacks."""
    inert, force = pushing
    place = np.array([found.approach, found.travel])
    if inert is None:
        return np.stack([place, np.zeros(2), np.zeros(2)])
    missing = np.array(
        [force.normal - found.normal.sum(), (force.tangential or 0.0) - found.tangential.sum()]
    )
    rate = missing / inert.stiffness / (s.beta * s.dt**2)
    speed = state.plate[1] + s.dt * ((1 - s.gamma) * state.plate[2] + s.gamma * rate)
    if drive.travel is not None:
        rate[1], speed[1] = 0.0, (found.travel - state.plate[0, 1]) / s.dt
    return np.stack([place, speed, rate])


def rubbed(before: Grip, after: Grip) -> float:
    """What friction dissipated in a step, mJ: the mean force by all that points went on the plate. Without
    high modes' damping that is what the equations of motion miss to the last digit, open points as well."""
    return -float((before.tangential + after.tangential) / 2 @ (after.anchor - before.anchor))


def work_done(before: DynamicState, after: DynamicState) -> float:
    """What drives the plate did in a step, mJ: its mean force, or where it is driven in x the skin's."""
    one, other = before.drive, after.drive
    down, along = after.plate[0] - before.plate[0]
    if other.travel is None:
        pull = ((one.tangential or 0.0) + (other.tangential or 0.0)) / 2
    else:
        pull = float(before.grip.tangential.sum() + after.grip.tangential.sum()) / 2
    return (one.normal + other.normal) / 2 * float(down) + pull * float(along)
