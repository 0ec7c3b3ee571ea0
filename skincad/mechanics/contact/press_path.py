"""A pad pressed with friction from first touch to the wanted force.

Small strain. The plate comes down from the first touch on, its normal force growing from step to step;
sideways it is free, as in a scene's press. Each step is solved exactly (frictional.py; of a solid by
disc_friction.py). All ridges touch where the last one's finely sampled gap closes. That force is found with
this ridge out of contact, by root finding within the step in which it begins to touch, as without friction
(frictionless.py).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy import optimize

from skincad.base.arrays import Array, Index
from skincad.mechanics.bodies.condense import condense
from skincad.mechanics.bodies.elements import ContactStiffness
from skincad.mechanics.contact.disc_friction import DiscCompliance, solve_discs, unloaded
from skincad.mechanics.contact.frictional import halved, in_halves
from skincad.mechanics.contact.frictionless import Ridges, least_gap, seen_by_plate
from skincad.mechanics.contact.state import (
    Compliance,
    ContactState,
    Drive,
    FrictionCoefficients,
    at_rest,
)
from skincad.mechanics.problem import ContactError, Pad

ROOT, SOLID_ROOT = 1e-9, 1e-6  # relative, of the force; steps are known to 1e-10, of a solid to 1e-8
HELD = 1e-9  # of the largest compliance; less is a movement that a mirror holds
SEARCH_FACTOR = 3.0  # of the larger of the force and the all-touch force without friction: the search's end


@dataclass(frozen=True)
class StickingPad:
    """A condensed pad in its own units: `ridges` as the plate sees them without friction, `compliance`
    `(n m, n m)` of its m points in x, then in z, of a solid in y too, and `fine` `(p, n m)`: how far the fine
    samples rise under these forces. `whole` says whether it is more than a mirrored half."""

    ridges: Ridges
    compliance: Array
    fine: Array
    whole: bool = True

    @property
    def directions(self) -> int:
        """In how many directions points move: 2 in a section, 3 of a solid."""
        return len(self.compliance) // self.ridges.gap.size

    @cached_property
    def plane_skin(self) -> Compliance:
        """The points of a section as frictional.py takes them."""
        return Compliance(self.compliance, self.ridges.gap, np.zeros(len(self.compliance)))

    @cached_property
    def solid_skin(self) -> DiscCompliance:
        """The points of a solid as disc_friction.py takes them."""
        x, z, y = np.arange(self.compliance.shape[0]).reshape(3, -1)
        sideways = np.concatenate([x, y])
        tangential = self.compliance[np.ix_(sideways, sideways)]
        return DiscCompliance(
            normal=self.compliance[np.ix_(z, z)],
            tangential=tangential,
            cross=self.compliance[np.ix_(z, sideways)],
            gap=self.ridges.gap,
            able=tangential.diagonal() > HELD * self.compliance.diagonal().max(),
            floats=self.whole,
        )

    def of(self, points: Index) -> StickingPad:
        """Return the same pad with these contact points alone."""
        ridges = self.ridges
        numbers = (points + np.arange(self.directions)[:, None] * ridges.gap.size).ravel()
        some = replace(
            ridges,
            flexibility=ridges.flexibility[np.ix_(points, points)],
            gap=ridges.gap[points],
            of_point=ridges.of_point[points],
            rows=ridges.rows[points],
        )
        compliance = self.compliance[np.ix_(numbers, numbers)]
        return replace(self, ridges=some, compliance=compliance, fine=self.fine[:, numbers])

    def fine_gaps(self, state: ContactState) -> Array:
        """Return the fine samples' gaps `(p,)` in a state of the pad's points."""
        x, y = np.split(state.tangential, [self.ridges.gap.size])
        risen = self.fine @ np.concatenate([x, -state.normal, y])
        return np.asarray(self.ridges.fine_gap - state.approach - risen)


def sticking_pad_of(
    pad: Pad, system: ContactStiffness, unit: float, crest_offsets: tuple[float, ...] = ()
) -> StickingPad:
    """Return the pad of an assembled mesh, of a section that turns its half; `unit` is the pad's, mm, and
    `crest_offsets` as in Request."""
    space = system.space.components[0]
    along_x = system.contact - space.Range(1).start + space.Range(0).start
    contact, k = np.concatenate([along_x, system.contact]), along_x.size
    free = np.append(np.isin(along_x, system.interior), np.ones(k, dtype=bool))  # but what the axis holds
    inside = np.setdiff1d(system.interior, along_x)
    by_unknown = condense(system.matrix, inside, contact[free]).flexibility
    if not free.all():  # alone on its own, where no force moves it: any number but 0
        whole = np.diag(np.where(free, 0.0, by_unknown.diagonal().max()))
        whole[np.ix_(free, free)] = by_unknown
        by_unknown = whole
    ridges = seen_by_plate(pad, system, by_unknown[k:, k:], unit, crest_offsets)
    return sticking(ridges, system, by_unknown, whole=not pad.revolved)


def sticking(ridges: Ridges, system: ContactStiffness, by_unknown: Array, *, whole: bool) -> StickingPad:
    """Return the pad by the flexibility of its contact unknowns in all directions; `whole` as in
    StickingPad."""
    rows, directions = system.nodes.rows, by_unknown.shape[0] // system.nodes.rows.shape[1]
    parts = np.split(by_unknown, directions)
    moved = [
        np.hstack([(rows @ block.T).T for block in np.split(part, directions, axis=1)]) for part in parts
    ]
    compliance = np.vstack([rows @ part for part in moved])
    risen = np.asarray(system.fine.rows @ moved[1])
    return StickingPad(ridges, (compliance + compliance.T) / 2, risen, whole)


def press_with_friction(
    pad: StickingPad, coefficient: float, force: float, first: float | None, steps: int
) -> tuple[ContactState, float | None]:
    """Press to `force` and until all ridges touch; `first` is the all-touch force without friction.

    Return the state at the force, with the largest residual of all steps, and the all-touch force, None if
    there is none without friction either. Up to the smaller of both the force rises in `steps` equal steps;
    from there to the larger in as many, of a solid, whose steps take longer, in no more than the same size
    asks for. Raises ContactError where a step's sets do not settle, halved or not, or all do not touch up to
    SEARCH_FACTOR.
    """
    ridges, points = pad.ridges, pad.ridges.gap.size
    waiting = [r for r in ridges.numbers.tolist() if _least(ridges, r, ridges.fine_gap) > 0]
    state = at_rest(points) if pad.directions == 2 else unloaded(points)
    load, residual, at_force = 0.0, 0.0, None
    searching = bool(waiting and first)  # at 0 all touch at once
    all_touch = None if searching else first
    low, high = sorted((force, first or force))
    later_steps = steps if pad.directions == 2 else max(1, math.ceil(steps * min(1.0, high / low - 1)))
    for following in _forces(force, first, steps, later_steps):
        if at_force is not None and not searching:
            break
        after = _step(pad, coefficient, state, load, following)
        residual = max(residual, after.residual)
        if searching:  # the gap of a point that touches is rounding
            gaps, touched = pad.fine_gaps(after), ridges.of_point[after.touches]
            still = [r for r in waiting if r not in touched and _least(ridges, r, gaps) > 0]
            if not still:
                all_touch = max(_closing(pad, coefficient, r, state, load, following) for r in waiting)
                searching = False
            else:
                waiting = still
        state, load = after, following
        at_force = state if load == force else at_force
    if searching or at_force is None:
        words = f"not all ridges touch at up to {SEARCH_FACTOR:g} times the force without friction"
        raise ContactError(words)
    return replace(at_force, residual=residual), all_touch


def _forces(force: float, first: float | None, steps: int, later_steps: int) -> list[float]:
    """The forces of a press: `force` itself is one of them."""
    low, high = sorted((force, first or force))
    shares, later = (np.arange(steps) + 1) / steps, (np.arange(later_steps) + 1) / later_steps
    forces = [*(low * shares[:-1]), low]
    if high > low:
        forces += [*(low + (high - low) * later[:-1]), high]
    further = high * (1 + shares)
    return [float(level) for level in (*forces, *further, *(high + further))]


def _step(
    pad: StickingPad, coefficient: float, before: ContactState, start: float, end: float
) -> ContactState:
    """The state at a force from the one before; where points do not settle, in halves."""
    if pad.directions == 2:
        sideways = (0.0, None) if pad.whole else (None, 0.0)  # without a pull, or without a travel
        first, last = (Drive(force, *sideways) for force in (start, end))
        cone = FrictionCoefficients(coefficient, coefficient)
        return halved(lambda _: pad.plane_skin, before, first, last, cone)

    def advance(before: ContactState, _start: Drive, end: Drive, _share: float) -> ContactState:
        return solve_discs(pad.solid_skin, before, end.normal, coefficient)

    return in_halves(advance, before, Drive(start), Drive(end), lambda _, second: second, 4)


def _closing(
    pad: StickingPad, coefficient: float, ridge: int, before: ContactState, start: float, end: float
) -> float:
    """The force between two at which a ridge begins to touch that is clear at the first."""
    points = np.flatnonzero(pad.ridges.of_point != ridge)
    others, per_point = pad.of(points), ("normal", "tangential", "anchor", "status", "slipped")
    by_point = {name: getattr(before, name).reshape(-1, before.normal.size) for name in per_point}
    alone = replace(before, **{name: values[:, points].ravel() for name, values in by_point.items()})

    def gap(force: float) -> float:
        state = _step(others, coefficient, alone, start, force) if force > start else alone
        return _least(pad.ridges, ridge, others.fine_gaps(state))

    if gap(end) >= 0.0:  # by rounding alone: with the ridge in contact it touches
        return end
    root = ROOT if pad.directions == 2 else SOLID_ROOT
    return float(optimize.brentq(gap, start, end, xtol=root * end, rtol=root))


def _least(ridges: Ridges, ridge: int, gaps: Array) -> float:
    """Smallest of a ridge's fine gaps, of those of all `(p,)`."""
    points = ridges.fine_of_point == ridge
    return least_gap(gaps[points], ridges.fine_edge[points])
