"""Pads with mass and memory on a plate with mass: linear but for the contact, two back-solves a step.

At a step's end K u + D e + M a = r, with K the elastic stiffness, D its relaxing part, e what of the strain
has not relaxed yet, M the mass and r the contact forces; time_scheme.py says where within a step it is met.
Branches that relax are integrated exactly for strains straight in time: Taylor, Pister, Goudreau, IJNME 2
(1970) 45; Simo and Hughes, Computational Inelasticity, 1998, sec. 10.3.

Contact and friction hold exactly at each step's end, as at rest. Points that touch should have no mass
(dynamics_pad.py): then the force grows from 0 when the plate strikes, and the order stays 2. The energy of
every step is kept to show it.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import exp

import numpy as np
from scipy import sparse

from skincad.base.arrays import Array
from skincad.mechanics.bodies.condense import Condensation, condense
from skincad.mechanics.contact.frictional import grip
from skincad.mechanics.contact.grip import (
    Compliance,
    ContactState,
    Drive,
    FrictionCoefficients,
    GrossSlip,
    Inert,
)
from skincad.mechanics.contact.halving import in_halves, joined
from skincad.mechanics.dynamics.plate import TONNE, friction_work, plate_inertia, plate_state, plate_work
from skincad.mechanics.dynamics.state import DynamicState, PadEquations, sum_of, unrelaxed
from skincad.mechanics.dynamics.time_scheme import Matter, Scheme, scheme

MAX_HALVINGS = 4  # of a step that does not converge
LENGTH_DIGITS = 9  # of a step's length: equal ones share a factorisation
MOST_LENGTHS = 12  # of steps whose factorisations are in memory: each corner between steps has two of its own


@dataclass(frozen=True, eq=False)
class Operators:
    """What does not change from step to step: `small` of each half. Of each branch `gained` is its gain per
    displacement, `decay` the share that stays."""

    scheme: Scheme
    small: tuple[Condensation, ...]
    skin: Compliance
    gained: tuple[float, ...]
    decay: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class Dynamics:
    """A pad with mass or memory; `operators` remembers factorisations for the lengths of step used last."""

    pad: PadEquations
    operators: dict[tuple[float, Matter], Operators] = field(default_factory=dict)

    def step(
        self, state: DynamicState, drive: Drive, dt: float, cone: FrictionCoefficients, matter: Matter
    ) -> DynamicState:
        """Return the state after `dt` s; a step that does not converge is cut in two.

        Raises GrossSlip, whose `last` is a Moved, where the plate has no mass, and ContactError.
        """
        if len(state.memory) != len(matter.relaxing):
            state = replace(state, memory=(np.zeros_like(state.u),) * len(matter.relaxing))
        start = replace(state, matter=matter)
        length = float(f"{dt:.{LENGTH_DIGITS}g}")

        def advance(before: DynamicState, _start: Drive, end: Drive, share: float) -> DynamicState:
            return self._one(before, end, share * length, cone)

        return in_halves(advance, start, start.drive, drive, _joined, MAX_HALVINGS)

    def _one(self, state: DynamicState, drive: Drive, dt: float, cone: FrictionCoefficients) -> DynamicState:
        pad, ops = self.pad, self.factorised(dt, state.matter)
        past, slower = self._history(state, ops)
        free = np.stack([ops.small[i].solve(past[:, i]) for i in range(len(pad.halves))], axis=1)
        at_points = sum_of(half.points @ free[:, i] for i, half in enumerate(pad.halves))
        skin = replace(ops.skin, free=at_points)
        inert, pushing = plate_inertia(state, drive, ops.scheme)

        def after(contact: ContactState) -> DynamicState:
            return self._after(state, drive, contact, free, slower, ops, (inert, pushing))

        try:
            return after(grip(skin, state.contact, pushing, cone, inert))
        except GrossSlip as end:
            raise GrossSlip(after(end.last), str(end)) from None

    def factorised(self, dt: float, matter: Matter) -> Operators:
        """Factorise for this length of step, once."""
        if known := self.operators.pop((dt, matter), None):
            self.operators[dt, matter] = known  # the last one used is the last one dropped
            return known
        if len(self.operators) >= MOST_LENGTHS:
            del self.operators[next(iter(self.operators))]
        pad, method = self.pad, scheme(dt, matter.damped)
        left = tuple(exp(-dt / time) for _, time in matter.relaxing)
        fresh = tuple(
            g * (1 - stays) / (dt / time) for (g, time), stays in zip(matter.relaxing, left, strict=True)
        )
        whole = pad.stiff + (method.speed * matter.rate + sum(fresh)) * pad.soft + method.force * pad.mass
        matrix = sparse.csr_matrix(whole)
        small = tuple(condense(matrix, half.inner, half.contact) for half in pad.halves)
        size = 2 * pad.gap.size
        compliance = np.zeros((size, size))
        for half, condensed in zip(pad.halves, small, strict=True):
            points = half.points[:, condensed.order[-half.contact.size :]]
            half_compliance = points @ np.asarray(points @ condensed.flexibility).T
            compliance += pad.share * (half_compliance + half_compliance.T) / 2
        skin = Compliance(compliance, pad.gap, np.zeros(size), area=pad.area)
        operators = self.operators[dt, matter] = Operators(method, small, skin, fresh, left)
        return operators

    def _history(self, state: DynamicState, ops: Operators) -> tuple[Array, Array]:
        """The forces `(n, halves)` of earlier states, and `speed` times u less the velocity."""
        pad, s, dt, matter = self.pad, ops.scheme, ops.scheme.dt, state.matter
        if s.moves:
            ahead = state.u + dt * state.v + dt**2 * (0.5 - s.beta) * state.a
            slower = s.speed * ahead - state.v - dt * (1 - s.gamma) * state.a
            force = pad.mass @ (s.force * ahead - s.lag / (1 - s.late) * state.a)
            force += s.before * (self.contact_force(state.contact) - state.elastic_force)
        else:
            slower = s.speed * state.u + 0.5 * state.v
            force = np.zeros_like(state.u)
        past = matter.rate * slower - sum_of(
            (
                stays * h - b * state.u
                for stays, b, h in zip(ops.decay, ops.gained, state.memory, strict=True)
            ),
            np.zeros_like(state.u),
        )
        if matter.rate or matter.relaxing:
            force = force + pad.soft @ (past - s.before * unrelaxed(state))
        return force, slower

    def contact_force(self, state: ContactState) -> Array:
        """Forces `(n, halves)` on the unknowns of the part, N."""
        force = self.pad.share * np.concatenate([state.tangential, -state.normal])
        return np.stack([half.points.T @ force for half in self.pad.halves], axis=1)

    def _after(
        self,
        state: DynamicState,
        drive: Drive,
        contact: ContactState,
        free: Array,
        slower: Array,
        ops: Operators,
        pushing: tuple[Inert | None, Drive],
    ) -> DynamicState:
        """The state that the contact forces lead to."""
        s, dt = ops.scheme, ops.scheme.dt
        pushed = self.contact_force(contact)
        u = free + np.stack([small.solve(pushed[:, i]) for i, small in enumerate(ops.small)], axis=1)
        rate = s.speed * u - slower
        if s.moves:
            v = rate
            a = (v - state.v) / (s.gamma * dt) - (1 - s.gamma) / s.gamma * state.a
        else:
            v, a = (u - state.u) / dt, state.a
        memory = tuple(
            stays * h + b * (u - state.u)
            for stays, b, h in zip(ops.decay, ops.gained, state.memory, strict=True)
        )
        plate = plate_state(state, drive, contact, s, pushing)
        new = DynamicState(contact, u, v, a, rate, self.pad.stiff @ u, memory, plate, drive, state.matter)
        return replace(
            new,
            friction=friction_work(state.contact, contact),
            viscous=self._viscous(state, new, dt),
            work=plate_work(state, new),
        )

    def _viscous(self, before: DynamicState, after: DynamicState, dt: float) -> float:
        """Viscous dissipation in a step, mJ, exact for dashpots and strains straight in time."""
        matter = after.matter
        if not (matter.rate or matter.relaxing):
            return 0.0
        moved, soft = after.u - before.u, self.pad.soft
        lost = matter.rate / dt * float((moved * (soft @ moved)).sum())
        for (g, time), one, other in zip(matter.relaxing, before.memory, after.memory, strict=True):
            branch_work = time / dt * float(((g * moved - (other - one)) * (soft @ moved)).sum())
            lost += branch_work - float(((other - one) * (soft @ (other + one))).sum()) / (2 * g)
        return lost / self.pad.share

    def elastic(self, state: DynamicState) -> float:
        """Stored energy of the whole pad, mJ."""
        stored = float((state.u * state.elastic_force).sum())
        for (g, _), h in zip(state.matter.relaxing, state.memory, strict=True):
            stored += float((h * (self.pad.soft @ h)).sum()) / g
        return stored / 2 / self.pad.share

    def kinetic(self, state: DynamicState) -> float:
        """Kinetic energy of pad and plate, mJ; a driven plate's in x is its drive's."""
        if state.matter.damped is None:
            return 0.0
        skin = float((state.v * (self.pad.mass @ state.v)).sum()) / 2 / self.pad.share
        counted = state.plate[1, : 1 if state.drive.travel is not None else 2]
        return skin + TONNE * state.matter.plate / 2 * float(counted @ counted)

    def strips(self, state: DynamicState) -> Array:
        """Mean stresses `(strips, 3)` MPa across, along and lengthwise."""
        late = unrelaxed(state)
        stress = sum_of(
            half.strips[0] @ state.u[:, i] + half.strips[1] @ late[:, i]
            for i, half in enumerate(self.pad.halves)
        )
        return np.asarray(stress).reshape(-1, 3)


def _joined(first: DynamicState, second: DynamicState) -> DynamicState:
    """The state at the end of two steps as that of one."""
    return replace(
        second,
        contact=joined(first.contact, second.contact),
        friction=first.friction + second.friction,
        viscous=first.viscous + second.viscous,
        work=first.work + second.work,
    )
