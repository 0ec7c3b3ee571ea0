"""The rigid plate over a step: its inertia, its motion and the work of its drives."""

from __future__ import annotations

import numpy as np

from skincad.base.arrays import Array
from skincad.mechanics.contact.grip import ContactState, Drive, Inert
from skincad.mechanics.dynamics.state import DynamicState
from skincad.mechanics.dynamics.time_scheme import Scheme

TONNE = 1e-6  # of a gram


def plate_inertia(state: DynamicState, drive: Drive, s: Scheme) -> tuple[Inert | None, Drive]:
    """The plate's inertia over a step, and the effective forces on it."""
    if not s.moves or not state.matter.plate:
        return None, drive
    mass, dt = TONNE * state.matter.plate, s.dt
    place, speed, rate = state.plate
    ahead = place + dt * speed + dt**2 * (0.5 - s.beta) * rate
    now = np.array([drive.normal, drive.tangential or 0.0])
    was = np.array([state.drive.normal, state.drive.tangential or 0.0])
    borne = np.array([state.contact.normal.sum(), state.contact.tangential.sum()])
    force = now + s.before * (was - borne) - mass * s.lag / (1 - s.late) * rate
    effective = Drive(float(force[0]), None if drive.travel is not None else float(force[1]), drive.travel)
    return Inert(mass * s.force, float(ahead[0]), float(ahead[1])), effective


def plate_state(
    state: DynamicState, drive: Drive, contact: ContactState, s: Scheme, pushing: tuple[Inert | None, Drive]
) -> Array:
    """The plate's place, speed and acceleration `(3, 2)` after a step, from its unbalanced force."""
    inert, force = pushing
    place = np.array([contact.approach, contact.travel])
    if inert is None:
        return np.stack([place, np.zeros(2), np.zeros(2)])
    missing = np.array(
        [force.normal - contact.normal.sum(), (force.tangential or 0.0) - contact.tangential.sum()]
    )
    rate = missing / inert.stiffness / (s.beta * s.dt**2)
    speed = state.plate[1] + s.dt * ((1 - s.gamma) * state.plate[2] + s.gamma * rate)
    if drive.travel is not None:
        rate[1], speed[1] = 0.0, (contact.travel - state.plate[0, 1]) / s.dt
    return np.stack([place, speed, rate])


def friction_work(before: ContactState, after: ContactState) -> float:
    """Friction's dissipation in a step, mJ: the mean force times the slip of the points on the plate. Without
    damping of high modes it closes the energy balance to rounding, open points included."""
    return -float((before.tangential + after.tangential) / 2 @ (after.anchor - before.anchor))


def plate_work(before: DynamicState, after: DynamicState) -> float:
    """Work of the plate's drives in a step, mJ, by the mean force; driven in x, by the skin's force."""
    one, other = before.drive, after.drive
    down, along = after.plate[0] - before.plate[0]
    if other.travel is None:
        pull = ((one.tangential or 0.0) + (other.tangential or 0.0)) / 2
    else:
        pull = float(before.contact.tangential.sum() + after.contact.tangential.sum()) / 2
    return (one.normal + other.normal) / 2 * float(down) + pull * float(along)
