"""A meshed pad at finite strain under a plate with friction: one step.

A neo-Hookean pad under a flat plate with Coulomb friction: one step, by Newton. The plate is flat,
so gaps and slips are linear in the displacements and only the body is linearised. In each iteration the body,
condensed to its contact points, is a compliance and a place without contact forces; the contact problem with
*total* forces is then solved exactly (frictional.py), against the anchors of the step's beginning. The
iteration is newton.py's; a tangent is kept while the residual falls quickly, from one step to the next too.

A state is accepted if it balances to RESIDUAL of the contact forces. A tangent that is not positive definite
is no reason to stop: the plate may hold a ridge that would buckle if it were free (stability.py).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from scipy import sparse

from skincad.base.arrays import Array, Index
from skincad.mechanics.bodies.condense import fill_order
from skincad.mechanics.bodies.elements import ContactStiffness
from skincad.mechanics.bodies.plane_body import NeoHookeBody, PlaneLinearised
from skincad.mechanics.contact.frictional import solve_contact
from skincad.mechanics.contact.newton import RESIDUAL, equilibrium
from skincad.mechanics.contact.state import (
    Compliance,
    ContactState,
    Drive,
    FrictionCoefficients,
    GrossSlip,
    Swing,
    at_rest,
)
from skincad.mechanics.problem import ContactError

ITERATIONS = 40  # in one step; with a kept tangent five to ten are usual
SLOW_DECREASE = 0.2  # a residual that falls less in an iteration asks for a new tangent


@dataclass(frozen=True, eq=False)
class Tangential:
    """The body linearised at the state `values` and condensed to its contact unknowns along x and z;
    `compliance` `(2 m, 2 m)` mm/N.

    `solved` remembers the contact's factorisations.
    """

    linear: PlaneLinearised
    compliance: Array
    values: Array
    solved: dict[bytes, Any] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class FrictionalPad:
    """A meshed pad: m contact points in order of their x, `gap` `(m,)` mm from the plate when it first
    touches, `x`, `weight` mm, `ridge`; `top` mm is the highest one's z. `rows` `(2 m, k)`: displacements
    in x, then z, of the unknowns `contact` `(k,)`. A unit of length is `unit` mm, one of force `scale` N.

    `ends` `(2 m, 2 m)` mm/N is what free ends add to the compliance, 0 without. `tangents` holds the latest
    tangent alone, for the body has room for no other.
    """

    body: NeoHookeBody
    contact: Index
    order: Index
    rows: sparse.csr_matrix
    gap: Array
    x: Array
    weight: Array
    ridge: Index
    top: float
    unit: float
    scale: float
    ends: Array
    tangents: list[Tangential] = field(default_factory=list)
    length: float = 1.0  # mm, of the pad along y

    @property
    def area(self) -> Array:
        """What each contact point stands for `(m,)`, mm2, undeformed."""
        return self.weight * self.length

    @property
    def rest(self) -> ContactStiffness:
        """The body at rest."""
        return self.body.rest


@dataclass(frozen=True, eq=False)
class FrictionalState:
    """An equilibrium: the unknowns `values` `(n,)` in units, the contact, in mm and N, and what friction
    dissipated in the step, mJ. `residual` is relative to the contact forces' norm, `iterations` counts
    Newton's steps."""

    values: Array
    contact: ContactState
    dissipated: float = 0.0
    residual: float = 0.0
    iterations: int = 0


def frictional_pad_of(
    body: NeoHookeBody,
    top: float,
    unit: float,
    scale: float,
    length: float = 1.0,
    ends: Callable[[Index], Array] | None = None,
) -> FrictionalPad:
    """Return the pad of a body, `length` mm along y, under its plate; `top` mm is its highest point. `ends`
    says what free ends add to the compliance `(2 m, 2 m)` mm/N of points of these ridges `(m,)`."""
    along_x, along_z = (body.space.components[0].Range(i).start for i in (0, 1))
    rest = body.rest
    contact = np.concatenate([rest.contact - along_z + along_x, rest.contact])
    elimination = np.concatenate([fill_order(rest.matrix, np.setdiff1d(rest.interior, contact)), contact])
    x, z = rest.nodes.position.T * unit
    by_x = np.argsort(x, kind="stable")
    one = rest.nodes.rows[by_x]
    gap = (top - z)[by_x]
    ridge = rest.nodes.ridge[by_x]
    return FrictionalPad(
        body=body,
        contact=contact,
        order=elimination,
        rows=sparse.csr_matrix(sparse.block_diag([one, one])),
        gap=gap - gap.min(),
        x=x[by_x],
        weight=rest.nodes.weight[by_x] * unit,
        ridge=ridge,
        top=float(z.max()),
        unit=unit,
        scale=scale,
        ends=ends(ridge) if ends else np.zeros((2 * ridge.size,) * 2),
        length=length,
    )


def unloaded(pad: FrictionalPad) -> FrictionalState:
    """Return the unloaded state, with no tangent kept: the same steps give the same bits."""
    pad.tangents.clear()
    return FrictionalState(np.zeros(pad.body.free.size), at_rest(pad.gap.size))


def linearised(pad: FrictionalPad, values: Array, residual: Array) -> Tangential:
    """Return the tangent at a state whose `residual` is at hand, and keep it; ContactError without one."""
    pad.tangents.clear()
    linear = pad.body.linearised(values, residual, pad.order, pad.contact.size)
    compliance = pad.rows @ (pad.rows @ linear.flexibility).T * (pad.unit / pad.scale)
    tangential = Tangential(linear, np.asarray(compliance) + pad.ends, values)
    pad.tangents.append(tangential)
    return tangential


def newton(
    pad: FrictionalPad,
    before: FrictionalState,
    drive: Drive,
    cone: FrictionCoefficients,
    guess: Array | None = None,
    swing: Swing | None = None,
    accuracy: float = RESIDUAL,
    steps: int = ITERATIONS,
) -> FrictionalState:
    """Return the equilibrium at a step's end, to an `accuracy` of the contact forces' norm and in so many of
    Newton's `steps` at most; looked for from `guess` `(n,)`, or where that is None or turns an element inside
    out from where the step begins; with what masses add if they `swing`.

    Raises ContactError where there is none to be found, and GrossSlip, whose `last` is the state that just
    slips, where friction cannot hold the tangential force.
    """
    if drive.angle:
        raise ContactError("finite_strain takes a plate that keeps its angle")
    body, values = pad.body, before.values if guess is None else guess
    if drive.normal == 0.0 and drive.tangential in (None, 0.0) and swing is None:
        clear = np.zeros(2 * pad.gap.size)  # of any movement: nothing touches
        lifted = solve_contact(
            Compliance(np.diag(clear), pad.gap, clear, area=pad.area), before.contact, drive, cone
        )
        return FrictionalState(np.zeros_like(values), lifted)
    if guess is not None and not np.isfinite(body.energy(values)):
        return newton(pad, before, drive, cone, None, swing, accuracy, steps)

    def contact(
        tangent: Tangential, linear: PlaneLinearised, values: Array
    ) -> tuple[Array, tuple[ContactState, GrossSlip | None]]:
        # where contact unknowns go without contact forces
        free = pad.rows @ (values[pad.contact] + linear.unloaded()) * pad.unit
        skin = Compliance(tangent.compliance, pad.gap, free, tangent.solved, pad.area)
        if swing:
            skin = skin.swung(swing)
        slipping = None
        try:
            state = solve_contact(skin, before.contact, swing.drive if swing else drive, cone)
        except GrossSlip as limit:  # the contact as it just slips
            state, slipping = limit.last, limit
        return contact_load(pad, state), (state, slipping)

    values, (found, slipping), _, history, _ = equilibrium(
        body,
        values,
        pad.tangents[0] if pad.tangents else None,
        tangent_at=lambda values, unbalanced, _: linearised(pad, values, unbalanced),
        contact=contact,
        keeps=lambda _, history: len(history) == 1 or history[-1] <= SLOW_DECREASE * history[-2],
        steps=steps,
        accuracy=accuracy,
    )
    state = FrictionalState(
        values=values,
        contact=replace(found, residual=max(found.residual, history[-1])),
        dissipated=dissipated(before.contact, found),
        residual=history[-1],
        iterations=len(history),
    )
    if slipping is not None:
        raise GrossSlip(state, str(slipping))
    return state


def dissipated(before: ContactState, after: ContactState) -> float:
    """Return the energy that friction dissipates in a step, mJ. A force that changed sign did so before its
    point slipped."""
    mean = (before.tangential + after.tangential) / 2
    mean = np.where(before.tangential * after.tangential < 0, after.tangential, mean)
    return -float(mean @ after.slipped)


def contact_load(pad: FrictionalPad, contact: ContactState) -> Array:
    """Return what the contact adds to the residual `(n,)`, in units."""
    push = np.zeros(pad.body.free.size)
    push[pad.contact] = -(pad.rows.T @ (contact.force / pad.scale))
    return push
