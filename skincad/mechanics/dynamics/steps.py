"""Time steps of a linear pad with mass and viscosity under a plate with mass.

The time integration scheme: generalised-alpha with masses, its first-order form without. With masses the
equation is met at a point within the step: Chung and Hulbert, J. Appl. Mech. 60 (1993) 371. Without, as
Jansen, Whiting, Hulbert, CMAME 190 (2000) 305, whose method damps the highest modes out in one step; with
equal steps it is BDF2. Both are of order 2 where velocities are smooth.

At a step's end K u + D e + M a = r, with K the elastic stiffness, D its relaxing part, e what of the strain
has not relaxed yet, M the mass and r the contact forces; `Scheme` says where within a step it is met.
Branches that relax are integrated exactly for strains straight in time: Taylor, Pister, Goudreau, IJNME 2
(1970) 45; Simo and Hughes, Computational Inelasticity, 1998, sec. 10.3.

Contact and friction hold exactly at each step's end, as at rest. Points that touch should have no mass
(pad.py): then the force grows from 0 when the plate strikes, and the order stays 2. The energy of
every step is kept to show it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from math import exp
from typing import Any, TypeVar

import numpy as np
from scipy import sparse

from skincad.base.arrays import Array, Index
from skincad.mechanics.bodies.condense import Condensation, condense
from skincad.mechanics.bodies.film_field import StripBody
from skincad.mechanics.contact.frictional import in_halves, joined, solve_contact
from skincad.mechanics.contact.state import (
    Compliance,
    ContactState,
    Drive,
    FrictionCoefficients,
    GrossSlip,
    at_rest,
)
from skincad.mechanics.film.stick import Half, points_flexibility


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


AT_REST = Matter()


@dataclass(frozen=True, eq=False, kw_only=True)
class PlateMotion:
    """A plate on a skin that has masses or a memory: their `contact`, and `plate` `(3, 2)`, the plate's
    approach and travel, mm, their velocities and accelerations. `drive` and `matter` are those of the last
    step; `friction`, `viscous` and `work` mJ were dissipated and done in it.
    """

    contact: ContactState
    plate: Array
    drive: Drive
    matter: Matter = AT_REST
    friction: float = 0.0
    viscous: float = 0.0
    work: float = 0.0


Key = TypeVar("Key")
Value = TypeVar("Value")
Motion = TypeVar("Motion", bound=PlateMotion)


@dataclass(frozen=True, eq=False, kw_only=True)
class DynamicState(PlateMotion):
    """A state: by unknown and half `(n, halves)`, displacement `u`, velocity `v`, acceleration `a`, mm and s,
    `rate`, the velocity of viscous stress, and `elastic_force`, N. `memory` has the unrelaxed displacement of
    each branch.
    """

    u: Array
    v: Array
    a: Array
    rate: Array
    elastic_force: Array
    memory: tuple[Array, ...]

    @property
    def unrelaxed(self) -> Array:
        """The part of the stress that has not relaxed yet, as a displacement `(n, halves)`."""
        return np.asarray(sum(self.memory, self.matter.rate * self.rate))


TONNE = 1e-6  # of a gram


def plate_inertia(state: PlateMotion, drive: Drive, s: Scheme) -> Drive:
    """The effective forces on the plate over a step, with its inertia."""
    if not s.moves or not state.matter.plate:
        return drive
    mass, dt = TONNE * state.matter.plate, s.dt
    place, speed, rate = state.plate
    ahead = place + dt * speed + dt**2 * (0.5 - s.beta) * rate
    now = np.array([drive.normal, drive.tangential or 0.0])
    was = np.array([state.drive.normal, state.drive.tangential or 0.0])
    borne = np.array([state.contact.normal.sum(), state.contact.tangential.sum()])
    force = now + s.before * (was - borne) - mass * s.lag / (1 - s.late) * rate
    pull, place = None if drive.travel is not None else float(force[1]), (float(ahead[0]), float(ahead[1]))
    return Drive(float(force[0]), pull, drive.travel, stiffness=mass * s.force, ahead=place)


def state_after(
    state: Motion, drive: Drive, contact: ContactState, s: Scheme, pushing: Drive, **skin: Any
) -> Motion:
    """Return the state after a step to `drive` that ends in this contact, `pushing` as of `plate_inertia`;
    `skin` are its fields that are no `PlateMotion`'s."""
    place, speed, rate = np.array([contact.approach, contact.travel]), np.zeros(2), np.zeros(2)
    borne = np.array([contact.normal.sum(), contact.tangential.sum()])
    if pushing.stiffness:  # from the plate's unbalanced force
        missing = np.array([pushing.normal, pushing.tangential or 0.0]) - borne
        rate = missing / pushing.stiffness / (s.beta * s.dt**2)
        speed = state.plate[1] + s.dt * ((1 - s.gamma) * state.plate[2] + s.gamma * rate)
        if drive.travel is not None:
            rate[1], speed[1] = 0.0, (contact.travel - state.plate[0, 1]) / s.dt
    # the mean force times the slip of the points on the plate: without damping of high modes that closes the
    # energy balance to rounding, open points included
    mean = (state.contact.tangential + contact.tangential) / 2
    friction = -float(mean @ (contact.anchor - state.contact.anchor))
    # of the drives, by the mean force; driven in x, by the skin's
    down, along = place - state.plate[0]
    pull = float(state.contact.tangential.sum() + contact.tangential.sum()) / 2
    if drive.travel is None:
        pull = ((state.drive.tangential or 0.0) + (drive.tangential or 0.0)) / 2
    work = (state.drive.normal + drive.normal) / 2 * float(down) + pull * float(along)
    plate = np.stack([place, speed, rate])
    return replace(state, contact=contact, plate=plate, drive=drive, friction=friction, work=work, **skin)


def plate_kinetic(state: PlateMotion) -> float:
    """Kinetic energy of the plate, mJ; a driven one's in x is its drive's."""
    speeds = state.plate[1, : 1 if state.drive.travel is not None else 2]
    return TONNE * state.matter.plate / 2 * float(speeds @ speeds)


# From a state to another drive, in so many s
Advance = Callable[[Motion, Drive, float], Motion]
MAX_HALVINGS = 4  # of a step that does not converge
LENGTH_DIGITS = 9  # of a step's length: equal ones share a factorisation
MOST_LENGTHS = 12  # of steps whose factorisations are in memory: each corner between steps has two of its own


def in_parts(advance: Advance[Motion], state: Motion, drive: Drive, dt: float) -> Motion:
    """Return the state after `dt` s; a step that does not converge is cut in two. Raises as `advance`."""
    length = float(f"{dt:.{LENGTH_DIGITS}g}")

    def part(before: Motion, _start: Drive, end: Drive, share: float) -> Motion:
        return advance(before, end, share * length)

    return in_halves(part, state, state.drive, drive, _joined, MAX_HALVINGS)


def _joined(first: Motion, second: Motion) -> Motion:
    """The state at the end of two steps as that of one."""
    return replace(
        second,
        contact=joined(first.contact, second.contact),
        friction=first.friction + second.friction,
        viscous=first.viscous + second.viscous,
        work=first.work + second.work,
    )


def remembered(store: dict[Key, Value], key: Key, value: Callable[[], Value]) -> Value:
    """Return what is stored under a key, or else `value`, stored; of more than MOST_LENGTHS the one that was
    not used for longest goes."""
    if key not in store and len(store) >= MOST_LENGTHS:
        del store[next(iter(store))]  # before the next one takes memory
    store[key] = store.pop(key) if key in store else value()
    return store[key]


# What does not change from step to step of one length: the method, each half's factors, and the skin
Operators = tuple[Scheme, tuple[Condensation, ...], Compliance]


def _branches(dt: float, matter: Matter) -> list[tuple[float, float]]:
    """Of each relaxing branch the share that stays over `dt` s, and its gain per displacement."""
    return [(stays := exp(-dt / time), g * (1 - stays) / (dt / time)) for g, time in matter.relaxing]


@dataclass(frozen=True, eq=False)
class PadEquations:
    """A pad's equations, in mm, N and tonne, over the n unknowns of the part that is meshed.

    `stiff`, `soft` and `mass` `(n, n)`; `strips` are by half the stresses of all strips, across, along and
    lengthwise, MPa per mm: of the slow stress, and of what relaxes, `(3 strips, n)` each; `share` is the
    share of a force that the part bears, 1 or, of a mirrored pad, 0.5; `gap`, `area` mm2 and `ridge` `(m,)`
    of the contact points; `body` is what was meshed. `operators` remembers factorisations for the lengths of
    step used last.
    """

    stiff: sparse.csr_matrix
    soft: sparse.csr_matrix
    mass: sparse.csr_matrix
    halves: tuple[Half, ...]
    strips: tuple[tuple[sparse.csr_matrix, sparse.csr_matrix], ...]
    share: float
    gap: Array
    area: Array
    ridge: Index
    unknowns: int
    body: StripBody | None = None
    operators: dict[tuple[float, Matter], Operators] = field(default_factory=dict)

    def start(self) -> DynamicState:
        """Return the unloaded start."""
        zero = np.zeros((self.stiff.shape[0], len(self.halves)))
        skin: dict[str, Any] = dict.fromkeys(("u", "v", "a", "rate", "elastic_force"), zero)
        plate, contact = np.zeros((3, 2)), at_rest(self.gap.size)
        return DynamicState(contact=contact, plate=plate, drive=Drive(0.0, 0.0), memory=(), **skin)

    def step(
        self, state: DynamicState, drive: Drive, dt: float, cone: FrictionCoefficients, matter: Matter
    ) -> DynamicState:
        """Return the state after `dt` s; a step that does not converge is cut in two.

        Raises GrossSlip, whose `last` is a DynamicState, where the plate has no mass, and ContactError.
        """
        if len(state.memory) != len(matter.relaxing):
            state = replace(state, memory=(np.zeros_like(state.u),) * len(matter.relaxing))
        start = replace(state, matter=matter)

        def advance(before: DynamicState, end: Drive, part: float) -> DynamicState:
            return self._one(before, end, part, cone)

        return in_parts(advance, start, drive, dt)

    def _one(self, state: DynamicState, drive: Drive, dt: float, cone: FrictionCoefficients) -> DynamicState:
        s, small, condensed = self.factorised(dt, state.matter)
        branches = [(*of, h) for of, h in zip(_branches(dt, state.matter), state.memory, strict=True)]
        past, slower = self._history(state, s, branches)
        free = np.stack([one.solve(past[:, i]) for i, one in enumerate(small)], axis=1)
        at_points = sum(half.points @ free[:, i] for i, half in enumerate(self.halves))
        skin = replace(condensed, free=np.asarray(at_points))
        pushing = plate_inertia(state, drive, s)

        def after(contact: ContactState) -> DynamicState:
            """The state that the contact forces lead to."""
            pushed = self.contact_force(contact)
            u = free + np.stack([one.solve(pushed[:, i]) for i, one in enumerate(small)], axis=1)
            moved = u - state.u
            v = rate = s.speed * u - slower
            a = (v - state.v) / (s.gamma * dt) - (1 - s.gamma) / s.gamma * state.a if s.moves else state.a
            v = v if s.moves else moved / dt
            memory, force = tuple(stays * h + b * moved for stays, b, h in branches), self.stiff @ u
            skin = {"u": u, "v": v, "a": a, "rate": rate, "elastic_force": force, "memory": memory}
            following = state_after(state, drive, contact, s, pushing, **skin)
            return replace(following, viscous=self._viscous(state, following, dt))

        try:
            return after(solve_contact(skin, state.contact, pushing, cone))
        except GrossSlip as end:
            raise GrossSlip(after(end.last), str(end)) from None

    def factorised(self, dt: float, matter: Matter) -> Operators:
        """Factorise for this length of step, once."""
        return remembered(self.operators, (dt, matter), partial(self._operators, dt, matter))

    def _operators(self, dt: float, matter: Matter) -> Operators:
        method = scheme(dt, matter.damped)
        fresh = [gained for _, gained in _branches(dt, matter)]
        whole = self.stiff + (method.speed * matter.rate + sum(fresh)) * self.soft + method.force * self.mass
        matrix = sparse.csr_matrix(whole)
        small = tuple(condense(matrix, half.inner, half.contact) for half in self.halves)
        parts = (points_flexibility(half.points, one) for half, one in zip(self.halves, small, strict=True))
        compliance, free = self.share * np.asarray(sum(parts)), np.zeros(2 * self.gap.size)
        skin = Compliance(compliance, self.gap, free, area=self.area)
        return method, small, skin

    def _history(
        self, state: DynamicState, s: Scheme, branches: list[tuple[float, float, Array]]
    ) -> tuple[Array, Array]:
        """The forces `(n, halves)` of earlier states, and `speed` times u less the velocity."""
        dt, matter = s.dt, state.matter
        if s.moves:
            ahead = state.u + dt * state.v + dt**2 * (0.5 - s.beta) * state.a
            slower = s.speed * ahead - state.v - dt * (1 - s.gamma) * state.a
            force = self.mass @ (s.force * ahead - s.lag / (1 - s.late) * state.a)
            force += s.before * (self.contact_force(state.contact) - state.elastic_force)
        else:
            slower = s.speed * state.u + 0.5 * state.v
            force = np.zeros_like(state.u)
        if matter.rate or matter.relaxing:
            past = matter.rate * slower - sum(stays * h - b * state.u for stays, b, h in branches)
            force = force + self.soft @ (past - s.before * state.unrelaxed)
        return force, slower

    def contact_force(self, state: ContactState) -> Array:
        """Forces `(n, halves)` on the unknowns of the part, N."""
        force = self.share * state.force
        return np.stack([half.points.T @ force for half in self.halves], axis=1)

    def _viscous(self, before: DynamicState, after: DynamicState, dt: float) -> float:
        """Viscous dissipation in a step, mJ, exact for dashpots and strains straight in time."""
        matter = after.matter
        if not (matter.rate or matter.relaxing):
            return 0.0
        moved, soft = after.u - before.u, self.soft
        lost = matter.rate / dt * float((moved * (soft @ moved)).sum())
        for (g, time), one, other in zip(matter.relaxing, before.memory, after.memory, strict=True):
            branch_work = time / dt * float(((g * moved - (other - one)) * (soft @ moved)).sum())
            lost += branch_work - float(((other - one) * (soft @ (other + one))).sum()) / (2 * g)
        return lost / self.share

    def elastic(self, state: DynamicState) -> float:
        """Stored energy of the whole pad, mJ."""
        stored = float((state.u * state.elastic_force).sum())
        for (g, _), h in zip(state.matter.relaxing, state.memory, strict=True):
            stored += float((h * (self.soft @ h)).sum()) / g
        return stored / 2 / self.share

    def kinetic(self, state: DynamicState) -> float:
        """Kinetic energy of pad and plate, mJ; a driven plate's in x is its drive's."""
        if state.matter.damped is None:
            return 0.0
        return float((state.v * (self.mass @ state.v)).sum()) / 2 / self.share + plate_kinetic(state)

    def stresses(self, state: DynamicState) -> Array:
        """Mean stresses `(strips, 3)` MPa across, along and lengthwise."""
        parts = zip(self.strips, state.u.T, state.unrelaxed.T, strict=True)
        stress = sum(slow @ u + relaxing @ late for (slow, relaxing), u, late in parts)
        return np.asarray(stress).reshape(-1, 3)
