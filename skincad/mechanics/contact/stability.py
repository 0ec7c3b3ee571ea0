"""Whether a pressed body is stable while the plate holds its touching points, and which ridge tips over where
it is not.

A body that would buckle if its contact were free may well stand under its plate. What counts is the tangent
for all movements in which touching points stay on the plate, which rests on them with a dead load. A mirrored
half has two kinds, symmetric and antisymmetric ones. Under antisymmetric ones the plate, which does not turn,
stays where it is.
"""

from __future__ import annotations

import numpy as np
from scipy import linalg, sparse

from skincad.base.arrays import Array
from skincad.mechanics.bodies.plane_body import NeoHookeBody, PlaneLinearised
from skincad.mechanics.bodies.solid_body import SolidBody, SolidLinearised
from skincad.mechanics.contact.frictionless import NodalContact, Ridges
from skincad.mechanics.problem import ContactError

# What Newton presses, and its tangent; a state is the vector of all its unknowns `(n,)`
Body = NeoHookeBody | SolidBody
LinearisedBody = PlaneLinearised | SolidLinearised

ITERATIONS = 6  # of the inverse iteration; the weakest movement is 10 times weaker than most others


def stable(
    body: Body, linear: LinearisedBody, ridges: Ridges, contact: NodalContact, *, both: bool = True
) -> bool:
    """Whether an equilibrium is stable under a plate with a dead load: the tangent positive definite for all
    movements in which the touching points move with the plate.

    Of a half `both` kinds of movements are looked at, or the symmetric ones alone.
    """
    fixed_count, free = linear.negative_eigenvalues
    points = np.flatnonzero(contact.active)
    flexibility = ridges.flexibility[np.ix_(points, points)]
    if not _held_up(fixed_count, free, flexibility):
        return False
    if free and not linalg.solve(flexibility, np.ones(points.size), assume_a="sym").sum() > 0:
        return False  # the plate's own stiffness
    if not both:
        return True
    try:
        antisymmetric = linear.antisymmetric()
    except ContactError:  # it has no such tangent
        return False
    return antisymmetric is None or _held_up(
        *antisymmetric.negative_eigenvalues, _at_points(body, antisymmetric, contact)[0]
    )


def _held_up(fixed_count: int, free: int, flexibility: Array) -> bool:
    """Whether a tangent is positive definite while points of a `flexibility` `(k, k)` are held; it has
    `fixed_count` negative eigenvalues with all contact unknowns held, and `free` without.

    With these points held the tangent has as many negative eigenvalues as it has free, less those of the
    points' flexibility (Haynsworth, Linear Algebra Appl. 1 (1968) 73).
    """
    if fixed_count or not free:
        return not fixed_count
    return int((linalg.eigvalsh(flexibility) < 0).sum()) == free


def _at_points(body: Body, linear: LinearisedBody, contact: NodalContact) -> tuple[Array, sparse.csr_matrix]:
    """The flexibility `(k, k)` and the rows `(k, contact unknowns)` of touching points that can move up."""
    rows = body.rest.nodes.rows[contact.active]
    flexibility = np.asarray(rows @ np.asarray(rows @ linear.flexibility).T)
    able = np.flatnonzero(flexibility.any(axis=1))  # on a half's cut some cannot
    return (flexibility + flexibility.T)[np.ix_(able, able)] / 2, rows[able]


def tipping_ridge(body: Body, state: Array, linear: LinearisedBody, contact: NodalContact) -> int:
    """Return the number of the ridge that the weakest movement with the touching points held moves most.

    Inverse iteration at an equilibrium `state` `(n,)`, from a movement with a part of every other.
    """
    antisymmetric = linear.antisymmetric()
    kinds = [_weakest(body, state, kind, contact) for kind in (linear, antisymmetric) if kind is not None]
    step, _ = max(kinds, key=lambda kind: kind[1])
    nodes = body.rest.nodes
    nearest = np.abs(nodes.position[:, 0] - x_of_largest_displacement(body, step)).argmin()
    return int(nodes.ridge[nearest])


def x_of_largest_displacement(body: Body, step: Array) -> float:
    """Return x at rest of the place on the boundary that a step `(n,)` moves furthest."""
    loops = [loop for section in body.outlines(step) for loop in section]
    moves = np.concatenate([loop.moved - loop.rest for loop in loops])
    return float(np.concatenate([loop.rest for loop in loops])[np.hypot(*moves.T).argmax(), 0])


def _weakest(body: Body, state: Array, linear: LinearisedBody, contact: NodalContact) -> tuple[Array, float]:
    """The weakest movement `(n,)` with the touching points held, and how far a load of 1 moves it."""
    rest = body.rest
    flexibility, rows = _at_points(body, linear, contact)
    balanced = at_contact(body, -(rest.nodes.rows.T @ contact.force))
    still = linear.move(-balanced)

    def moved(load: Array) -> Array:
        free = linear.move(-balanced - load) - still
        force = linalg.solve(flexibility, rows @ free[rest.contact], assume_a="sym")
        return free - (linear.move(-balanced - at_contact(body, rows.T @ force)) - still)

    step, growth = np.random.default_rng(0).standard_normal(state.size) * body.free, 0.0
    for _ in range(ITERATIONS):
        step = moved(step)
        growth = float(np.abs(step).max())
        step /= growth
    return step, growth


def at_contact(body: Body, force: Array) -> Array:
    """Return a load `(n,)` that is `force` `(k,)` on the contact unknowns."""
    load = np.zeros(body.free.size)
    load[body.rest.contact] = force
    return load
