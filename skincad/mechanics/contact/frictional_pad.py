"""A meshed pad at finite strain under a plate with friction, in steps of the plate's travel.

A neo-Hookean pad under a flat plate with Coulomb friction: one step, by Newton. The plate is flat,
so gaps and slips are linear in the displacements and only the body is linearised. In each iteration the body,
condensed to its contact points, is a compliance and a place without contact forces; the contact problem with
*total* forces is then solved exactly (frictional.py), against the anchors of the step's beginning. The
iteration is newton.py's; a tangent is kept while the residual falls quickly, from one step to the next too.

A state is accepted if it balances to RESIDUAL of the contact forces. A tangent that is not positive definite
is no reason to stop: the plate may hold a ridge that would buckle if it were free (press_path.py).

A step at finite strain is cut where it does not converge, or driven by the plate's travel. Under a force a
skin that softens has several equilibria, and Newton jumps between them; under a travel it has one. So a pull
that does not converge is replaced by steps of the travel until its force is passed.
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
from skincad.mechanics.contact.frictional import in_halves, joined, solve_contact
from skincad.mechanics.contact.newton import equilibrium
from skincad.mechanics.contact.state import (
    Compliance,
    ContactState,
    Drive,
    FrictionCoefficients,
    GrossSlip,
    Inert,
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
    """An equilibrium: the unknowns `values` `(n,)` in units, which the step changed by `change`, the contact,
    in mm and N, and what friction dissipated in the step, mJ. `residual` is relative to the contact forces'
    norm, `iterations` counts Newton's steps, and `moves` is the change of the plate's drive."""

    values: Array
    contact: ContactState
    change: Array
    dissipated: float = 0.0
    residual: float = 0.0
    iterations: int = 0
    moves: tuple[float, ...] = ()


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
    zero = np.zeros(pad.body.free.size)
    return FrictionalState(zero, at_rest(pad.gap.size), zero)


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
) -> FrictionalState:
    """Return the equilibrium at a step's end, looked for from `guess` `(n,)`, or where that is None or turns
    an element inside out from where the step begins; with what masses add if they `swing`.

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
        return FrictionalState(np.zeros_like(values), lifted, -before.values)
    if guess is not None and not np.isfinite(body.energy(values)):
        return newton(pad, before, drive, cone, None, swing)

    def contact(
        tangent: Tangential, linear: PlaneLinearised, values: Array
    ) -> tuple[Array, tuple[ContactState, GrossSlip | None]]:
        ahead = values[pad.contact] + linear.unloaded()
        skin = _compliance(pad, tangent, ahead)
        if swing:
            found = _contact(skin.swung(swing), before.contact, swing.drive, cone, swing.inert)
        else:
            found = _contact(skin, before.contact, drive, cone)
        return contact_load(pad, found[0]), found

    balanced = equilibrium(
        body,
        values,
        pad.tangents[0] if pad.tangents else None,
        tangent_at=lambda values, unbalanced, _: linearised(pad, values, unbalanced),
        contact=contact,
        keeps=lambda _, history: len(history) == 1 or history[-1] <= SLOW_DECREASE * history[-2],
        steps=ITERATIONS,
    )
    found, slipping = balanced.contact
    size, values = balanced.history[-1], balanced.values
    state = FrictionalState(
        values=values,
        contact=replace(found, residual=max(found.residual, size)),
        change=values - before.values,
        dissipated=dissipated(before.contact, found),
        residual=size,
        iterations=len(balanced.history),
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


def _contact(
    skin: Compliance,
    before: ContactState,
    drive: Drive,
    cone: FrictionCoefficients,
    inert: Inert | None = None,
) -> tuple[ContactState, GrossSlip | None]:
    """The contact of the linearised body; where friction does not hold, as it just slips."""
    try:
        return solve_contact(skin, before, drive, cone, inert), None
    except GrossSlip as end:
        return end.last, end


def _compliance(pad: FrictionalPad, linear: Tangential, ahead: Array) -> Compliance:
    """The linearised body as the plate sees it; `ahead` `(k,)` is where its contact unknowns go without
    contact forces."""
    free = pad.rows @ ahead * pad.unit
    return Compliance(linear.compliance, pad.gap, free, linear.solved, pad.area)


def contact_load(pad: FrictionalPad, contact: ContactState) -> Array:
    """Return what the contact adds to the residual `(n,)`, in units."""
    push = np.zeros(pad.body.free.size)
    force = np.concatenate([contact.tangential, -contact.normal]) / pad.scale
    push[pad.contact] = -(pad.rows.T @ force)
    return push


MAX_HALVINGS = 5  # of a step
TRAVEL_HALVINGS = 3  # of a step of the travel
TRAVEL_FACTOR = 2.0  # of the travel that the last softness predicts
MAX_TRAVEL_STEPS = 40  # of the travel in a step of the pull
MAX_SECANT_STEPS = 30  # of the last step, by the secant; four to six are usual
SAME_FORCE = 1e-9  # of the normal force


def advance_to(
    pad: FrictionalPad,
    before: FrictionalState,
    start: Drive,
    end: Drive,
    cone: FrictionCoefficients,
    deepest: int = MAX_HALVINGS,
) -> FrictionalState:
    """Return `newton` at `end`; a step that does not converge is cut in two, `deepest` times at most, a pull
    that does not is driven by travel. What the parts slipped and dissipated is added up. Raises as `newton`
    does.
    """

    def advance(before: FrictionalState, start: Drive, end: Drive, _share: float) -> FrictionalState:
        return _whole(pad, before, start, end, cone)

    if end.tangential in (None, start.tangential) or not before.contact.touches.any():
        return in_halves(advance, before, start, end, _joined, deepest)
    try:
        return _whole(pad, before, start, end, cone)
    except GrossSlip:
        raise
    except ContactError:
        return _driven(pad, before, end, cone)


def _whole(
    pad: FrictionalPad, before: FrictionalState, start: Drive, end: Drive, cone: FrictionCoefficients
) -> FrictionalState:
    """The state at a step's end; Newton starts where an equal step before leads, then from the step's
    start."""
    steady = _moves(start, end)
    guesses = (before.values + before.change, None) if steady == before.moves else (None,)
    for guess in guesses:
        try:
            return replace(newton(pad, before, end, cone, guess), moves=steady)
        except GrossSlip:
            raise
        except ContactError as refusal:
            pad.tangents.clear()
            failure = refusal
    raise failure


def _moves(start: Drive, end: Drive) -> tuple[float, ...]:
    """The change of a drive in a step, rounded so that equal steps compare equal."""

    def change(a: float | None, b: float | None) -> float:
        return float("nan") if a is None or b is None else float(f"{b - a:.6g}")

    pairs = ((start.normal, end.normal), (start.tangential, end.tangential), (start.travel, end.travel))
    return tuple(change(a, b) for a, b in pairs if b is not None)


def _driven(
    pad: FrictionalPad, before: FrictionalState, end: Drive, cone: FrictionCoefficients
) -> FrictionalState:
    """Return the state at the end's forces, the plate driven there by its travel; the last step is cut."""
    wanted, state, total = float(end.tangential or 0.0), before, None
    here = float(before.contact.tangential.sum())
    way = 1.0 if wanted > here else -1.0
    soft = (
        abs(before.contact.travel) / max(abs(here), 1e-3 * end.normal) or before.contact.approach / end.normal
    )
    length = TRAVEL_FACTOR * soft * (wanted - here)
    for _ in range(MAX_TRAVEL_STEPS):
        last = _by_travel(pad, state, end.normal, state.contact.travel + length, cone)
        passed = float(last.contact.tangential.sum())
        if way * (passed - wanted) >= 0:
            state_reached = _cut(pad, state, last, end.normal, wanted, cone)
            return state_reached if total is None else _joined(total, state_reached)
        if way * (passed - here) < 0:
            break
        total = last if total is None else _joined(total, last)
        state, here = last, passed
    raise ContactError(
        f"the pull cannot grow beyond {abs(here):.4g} N at {end.normal:.4g} N: the skin gives way"
    )


def _by_travel(
    pad: FrictionalPad, before: FrictionalState, normal: float, travel: float, cone: FrictionCoefficients
) -> FrictionalState:
    start = Drive(normal, travel=before.contact.travel)
    return advance_to(pad, before, start, Drive(normal, travel=travel), cone, TRAVEL_HALVINGS)


def _cut(
    pad: FrictionalPad,
    before: FrictionalState,
    after: FrictionalState,
    normal: float,
    wanted: float,
    cone: FrictionCoefficients,
) -> FrictionalState:
    """Return the state between two at which the tangential force is the wanted one, by the Illinois rule."""
    ends = [before.contact.travel, after.contact.travel]
    missing = [float(s.contact.tangential.sum()) - wanted for s in (before, after)]
    side = 0
    for _ in range(MAX_SECANT_STEPS):
        travel = (ends[0] * missing[1] - ends[1] * missing[0]) / (missing[1] - missing[0])
        state_reached = _by_travel(pad, before, normal, travel, cone)
        off = float(state_reached.contact.tangential.sum()) - wanted
        if abs(off) <= SAME_FORCE * normal:
            return state_reached
        new = int(off * missing[1] > 0)
        ends[new], missing[new] = travel, off
        if new == side:
            missing[1 - new] /= 2
        side = new
    raise ContactError(
        f"no travel gives the tangential force {wanted:.4g} N: it jumps by {abs(off):.1e} N there"
    )


def _joined(first: FrictionalState, second: FrictionalState) -> FrictionalState:
    return replace(
        second,
        contact=joined(first.contact, second.contact),
        dissipated=first.dissipated + second.dissipated,
        residual=max(first.residual, second.residual),
        iterations=first.iterations + second.iterations,
    )
