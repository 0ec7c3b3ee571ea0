"""Ridges as springs that feel each other: the condensed pad reduced to one force a ridge.

A plate at approach d meets ridge i, whose crest is `drop` lower than designed, with

    d - gap_i - drop_i = self_i(f_i) + sum over j != i of coupling_ij f_j   where f_i > 0.

`self_i` is the condensed model's own answer for ridge i pressed alone, so the growing contact patch of a
crowned tip is in it; the coupling takes each ridge's pressure as spread over its crown. One solve of the
condensed model takes half a millisecond, ten thousand of these together a sixth of a second.
"""

from __future__ import annotations

import numpy as np

from skincad.base.arrays import Array, Index
from skincad.mechanics.contact.frictionless import press
from skincad.mechanics.problem import ContactError, RidgeModel

TABLE = np.linspace(0.0, 1.0, 25)[1:] ** 2  # forces of the tables, dense where the patch is small
SWEEPS = 4000  # under a force far below what closes the gaps each sweep leaves 98 % of the error
BATCH = 500  # parts swept together: their forces stay in a processor's cache
SETTLED = 1e-9  # relative, of the force; Gauss-Seidel ends there
MAX_RIDGES = 1000  # features; more take minutes
ROUNDING = 1e-13  # of the force that closes all gaps; a force far below it is rounding


def ridge_model(
    flexibility: Array, gap: Array, of_point: Index, largest: float, unit: float, scale: float
) -> RidgeModel:
    """Return the reduced model of a condensed pad, its tables up to the force `largest` N on one ridge.

    `flexibility` `(m, m)`, `gap` `(m,)` and the ridge `of_point` `(m,)` are those of its contact points,
    `unit` mm and `scale` N the pad's units. Raises ContactError for a pad of more than MAX_RIDGES ridges.
    """
    numbers = np.unique(of_point)
    check_few(numbers.size)
    inside = [np.flatnonzero(of_point == number) for number in numbers]
    first = np.array([gap[points].min() for points in inside])
    force = np.concatenate([[0.0], TABLE * largest / scale])
    spread = np.zeros((gap.size, numbers.size))
    table = np.zeros((numbers.size, force.size))
    for i, points in enumerate(inside):
        block = flexibility[np.ix_(points, points)]
        start = None
        for column in range(1, force.size):
            state = press(block, gap[points], float(force[column]), start)
            start = state.active
            table[i, column] = state.approach - first[i]
            if column == force.size // 2:
                spread[points, i] = state.force / force[column]
    coupling = spread.T @ (flexibility @ spread)
    np.fill_diagonal(coupling, 0.0)
    return RidgeModel(first, coupling, force, table, unit, scale)


def check_few(count: int) -> None:
    """Raise ContactError for more than MAX_RIDGES features."""
    if count > MAX_RIDGES:
        raise ContactError(f"the scatter of crests is counted of at most {MAX_RIDGES} features, got {count}")


def ridge_forces(model: RidgeModel, drop: Array, force: Array) -> Array:
    """Return the forces `(s, n)` of s parts with crest drops `(s, n)`, each under its own force `(s,)`.

    Projected Gauss-Seidel over the ridges; the approach is corrected along with it. Raises ContactError
    when a part does not settle.
    """
    if not len(drop):
        return np.empty((0, model.gap.size))
    stiffness = model.force[-1] / model.indentation[:, -1]
    flexibility = np.diag(1 / stiffness) + model.coupling
    by_one = np.asarray(np.linalg.solve(flexibility, np.ones(model.gap.size)), dtype=np.float64)
    low = model.gap + drop
    low -= low.min(axis=1, keepdims=True)  # the first touch is 0: a light force is not lost in rounding
    rounding = ROUNDING * float(by_one.sum()) * float(np.ptp(low))
    forces = np.empty_like(low)
    for first in range(0, len(low), BATCH):
        some = slice(first, first + BATCH)
        forces[some] = _settle(model, by_one, low[some].T, force[some], rounding).T
    return forces


def ridge_approach(model: RidgeModel, drop: Array, force: Array) -> tuple[Array, Array]:
    """Return the forces `(s, n)` of s parts as `ridge_forces`, and the plate's approach `(s,)` from the first
    touch: that of the most loaded ridge."""
    forces, part = ridge_forces(model, drop, force), np.arange(len(drop))
    most, low = forces.argmax(axis=1), model.gap + drop
    beyond = (model.indentation[:, -1] - model.indentation[:, -2]) / (model.force[-1] - model.force[-2])
    own = [
        np.interp(load, model.force, model.indentation[i]) + beyond[i] * max(load - model.force[-1], 0.0)
        for load, i in zip(forces[part, most], most, strict=True)
    ]
    coupled = (model.coupling[most] * forces).sum(axis=1)
    return forces, low[part, most] - low.min(axis=1) + np.array(own) + coupled


def _settle(model: RidgeModel, by_one: Array, low: Array, force: Array, rounding: float) -> Array:
    """Forces `(n, s)` of parts with crests at `low` `(n, s)`; `by_one` `(n,)` moves all ridges by one.

    A ridge's parts lie together in memory; parts that have settled are swept no further.
    """
    together = float(by_one.sum())
    low, forces, waiting = low.copy(), np.empty_like(low), np.arange(force.size)
    end = model.indentation[:, -1]  # of the tables, which are continued straight
    slope = (model.force[-1] - model.force[-2]) / (end - model.indentation[:, -2])
    carried = np.outer(np.maximum(by_one, 0) / together, force)
    approach = low.mean(axis=0) + force / together
    for _ in range(SWEEPS):
        before = carried.copy()
        for i, row in enumerate(model.coupling):
            indent = approach - low[i] - row @ carried
            inside = np.interp(indent, model.indentation[i], model.force)  # 0 where it does not touch
            carried[i] = inside + slope[i] * np.maximum(indent - end[i], 0.0)
        missing = force - carried.sum(axis=0)
        approach = approach + 0.7 * missing / together
        moved = np.abs(carried - before).max(axis=0) + np.abs(missing)
        still = ~(moved <= SETTLED * force + rounding)
        forces[:, waiting[~still]] = carried[:, ~still]
        if not still.any():
            return forces
        if not still.all():
            low, carried, waiting = low[:, still], carried[:, still], waiting[still]
            approach, force, moved = approach[still], force[still], moved[still]
    raise ContactError(f"the ridge model does not settle ({(moved / force).max():.1e}); take fewer ridges")
