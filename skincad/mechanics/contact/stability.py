"""Whether a pressed body is stable while the plate holds the points that touch it, and which ridge tips over
where it is not.

A body that would buckle if its contact were free may well stand under its plate. What counts is the tangent
for all movements in which touching points stay on the plate, which rests on them with a dead load.
"""

from __future__ import annotations

import numpy as np
from scipy import linalg

from skincad.base.arrays import Array
from skincad.mechanics.contact.elastic import Elastic, LinearisedBody
from skincad.mechanics.contact.frictionless import NodalContact
from skincad.mechanics.contact.threshold import Ridges

ITERATIONS = 6  # of the inverse iteration; the weakest movement is 10 times weaker than most others


def stable(linear: LinearisedBody, ridges: Ridges, contact: NodalContact) -> bool:
    """Whether an equilibrium is stable under a plate with a dead load: the tangent positive definite for all
    movements in which the touching points move with the plate.

    With these points held the tangent has as many negative eigenvalues as it has free, less those of the
    points' flexibility (Haynsworth, Linear Algebra Appl. 1 (1968) 73); the plate's own stiffness is left.
    """
    held, free = linear.falling
    if held or not free:
        return not held
    points = np.flatnonzero(contact.active)
    flexibility = ridges.flexibility[np.ix_(points, points)]
    if int((linalg.eigvalsh(flexibility) < 0).sum()) != free:
        return False
    return bool(linalg.solve(flexibility, np.ones(points.size), assume_a="sym").sum() > 0)


def tipping_ridge(
    body: Elastic, state: Array, linear: LinearisedBody, ridges: Ridges, contact: NodalContact
) -> int:
    """Return the number of the ridge that the weakest movement with the touching points held moves most.

    Inverse iteration at an equilibrium `state` `(n,)`, from a movement with a part of every other.
    """
    rest = body.rest
    rows = rest.nodes.rows[contact.active]
    points = np.flatnonzero(contact.active)
    held = ridges.flexibility[np.ix_(points, points)]
    balanced = _at_contact(body, -(rest.nodes.rows.T @ contact.force))
    still = linear.move(-balanced)

    def moved(load: Array) -> Array:
        free = linear.move(-balanced - load) - still
        force = linalg.solve(held, rows @ free[rest.contact], assume_a="sym")
        return free - (linear.move(-balanced - _at_contact(body, rows.T @ force)) - still)

    step = np.random.default_rng(0).standard_normal(state.size) * body.free
    for _ in range(ITERATIONS):
        step = moved(step)
        step /= np.abs(step).max()
    nearest = np.abs(rest.nodes.position[:, 0] - body.widest(step)).argmin()
    return int(rest.nodes.ridge[nearest])


def _at_contact(body: Elastic, force: Array) -> Array:
    """A load `(n,)` that is `force` `(k,)` on the contact unknowns."""
    load = np.zeros(body.free.size)
    load[body.rest.contact] = force
    return load
