"""A pad pressed with friction from first touch to the wanted force, and where its free surface would crease.

Where a compressed free surface folds onto itself: a limit of the material, not of the mesh. In plane strain a
smooth neo-Hookean surface compressed along itself to the stretch WRINKLES is unstable at every wavelength
(Biot, Appl. Sci. Res. A 12 (1963) 168; 0.544), so the finer the mesh the more surely it folds there. A defect
starts a crease from the stretch CREASES on (Hong, Zhao and Suo, Appl. Phys. Lett. 95 (2009) 111901; 0.646). A
crease is contact of the skin with itself, which no model here knows.

Measured on docs/evidence/facts.md's section, three ridges at 1.2 N, a coefficient of 1, pulled by travel:
the stretch passes WRINKLES at Ft/Fn 0.666, 0.673, 0.649 and 0.655 (fineness and order 0.5 2, 0.5 3, 1 3, 2
2), first in the leading root fillet. There finer meshes fold at once: the determinant of F turns negative,
on the coarsest it is 0.5 still. The forces hardly feel it: 0.6 % between four meshes at 0.68. A tip fillet
of 0.15 mm, not 0.05, does not help (0.635); at coefficients of 0.8 and 0.6 the tips fold too, at 0.61 and
0.59.

Small strain, plane strain. The plate comes down from the first touch on, its normal force growing from step
to step; sideways it is free, as in a scene's press. Each step is solved exactly (frictional.py). All ridges
touch where the last one's finely sampled gap closes. That force is found with this ridge out of contact, by
root finding within the step in which it begins to touch, as without friction (frictionless.py).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy import optimize

from skincad.base.arrays import Array, Index
from skincad.mechanics.bodies import plane_body
from skincad.mechanics.bodies.condense import condense
from skincad.mechanics.bodies.elements import ContactStiffness, Outline, outlines
from skincad.mechanics.bodies.prisms import Solid
from skincad.mechanics.contact.disc_friction import DiscCompliance, DiscState, solve_discs, unloaded
from skincad.mechanics.contact.frictional import halved
from skincad.mechanics.contact.frictional_pad import FrictionalPad, FrictionalState
from skincad.mechanics.contact.frictionless import Ridges, seen_by_plate
from skincad.mechanics.contact.state import (
    Compliance,
    ContactState,
    Drive,
    FrictionCoefficients,
    at_rest,
)
from skincad.mechanics.problem import ContactError, Pad

WRINKLES = 0.544
CREASES = 0.646
FOOT = 0.2  # of the height; below, strains at the ends of the clamped back are unbounded in any mesh


@dataclass(frozen=True)
class Pinch:
    """The free surface's smallest stretch along itself, at `place` `(2,)` at rest, in units; `tip` whether
    that may touch the plate."""

    stretch: float
    place: Array
    tip: bool


def pinch(loops: list[Outline], plate: float) -> Pinch:
    """Return where loops are compressed most that do not touch the plate at the height `plate`."""
    top = max(loop.rest[:, 1].max() for loop in loops)
    tightest = Pinch(np.inf, np.zeros(2), False)
    for loop in loops:
        start, end = loop.rest, np.roll(loop.rest, -1, axis=0)
        moved = np.roll(loop.moved, -1, axis=0) - loop.moved
        stretch = np.hypot(*moved.T) / np.hypot(*(end - start).T)
        free = loop.moved[:, 1] < plate - plane_body.THROUGH
        free &= np.roll(free, -1) & (start[:, 1] > FOOT * top)
        if not free.any():
            continue
        i = int(np.where(free, stretch, np.inf).argmin())
        if stretch[i] < tightest.stretch:
            tightest = Pinch(float(stretch[i]), (start[i] + end[i]) / 2, bool(loop.touches[i]))
    return tightest


def _lowered(
    loops: list[Outline], pad: FrictionalPad, contact: ContactState, sunk: Array | None
) -> list[Outline]:
    """The outlines lower by what free ends let the ridges down, and by what masses do, `sunk` `(m,)` mm at
    the contact points: a section at rest knows neither."""
    if sunk is None and not pad.ends.any():
        return loops
    down = pad.ends[pad.x.size :, pad.x.size :] @ contact.normal / pad.unit
    down = down if sunk is None else down + sunk / pad.unit
    x = pad.x / pad.unit
    return [
        replace(
            loop, moved=loop.moved - np.stack([0 * loop.rest[:, 0], np.interp(loop.rest[:, 0], x, down)], 1)
        )
        for loop in loops
    ]


def undetected_contact(
    pad: FrictionalPad, state: FrictionalState, creases: bool, sunk: Array | None = None
) -> str | None:
    """Return what a state has that the model does not know: contact of the skin with itself or, off its
    crests, with the plate; with `creases` a surface that folds too. `sunk` `(m,)` mm is how much lower masses
    let the contact points be. None for a sound state."""
    plate = (pad.top - state.contact.approach) / pad.unit
    loops = _lowered(outlines(pad.rest, state.values), pad, state.contact, sunk)
    least = pinch(loops, plate)
    if creases and least.stretch < WRINKLES:
        ridge = pad.ridge[int(np.abs(pad.x / pad.unit - least.place[0]).argmin())]
        where = "tip" if least.tip else "flank or root"
        return (
            f"the surface folds onto itself at ridge {ridge}'s {where}: its stretch there is "
            f"{least.stretch:.3f}, and below {WRINKLES:g} no free surface stays smooth in plane strain"
        )
    return plane_body.undetected_contact(loops, lambda x: np.full_like(x, plate), with_itself=creases)


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

    def lowered(self, drops: Array) -> StickingPad:
        """Return the same pad with each ridge's crest lower by `drops` `(ridges,)`."""
        return replace(self, ridges=self.ridges.lowered(drops))


def sticking_pad_of(pad: Pad, system: ContactStiffness, unit: float) -> StickingPad:
    """Return the pad of an assembled mesh, of a section that turns its half; `unit` is the pad's, mm."""
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
    seen = _seen(seen_by_plate(pad, system, by_unknown[k:, k:], unit), system, by_unknown)
    return replace(seen, whole=not pad.revolved)


def sticking_solid_of(pad: Pad, small: Solid, unit: float, *, whole: bool) -> StickingPad:
    """Return the pad of a solid condensed along x and y too; `unit` is the pad's, mm."""
    ridges = seen_by_plate(pad, small.seen, small.flexibility, unit)
    return replace(_seen(ridges, small.seen, small.in_plane), whole=whole)


def _seen(ridges: Ridges, system: ContactStiffness, by_unknown: Array) -> StickingPad:
    """The pad as its points see it, of the flexibility of its contact unknowns in all directions."""
    rows, directions = system.nodes.rows, by_unknown.shape[0] // system.nodes.rows.shape[1]
    parts = np.split(by_unknown, directions)
    moved = [
        np.hstack([(rows @ block.T).T for block in np.split(part, directions, axis=1)]) for part in parts
    ]
    whole = np.vstack([rows @ part for part in moved])
    return StickingPad(ridges, (whole + whole.T) / 2, np.asarray(system.fine.rows @ moved[1]))


@dataclass(frozen=True)
class PressResult:
    """Result of a press, in the pad's units. `all_touch_force` is None if there is none without friction
    either; `approach` and `ridge_force` `(ridges,)` are those at the wanted force; `residual` is a step's
    largest."""

    all_touch_force: float | None
    approach: float
    ridge_force: Array
    residual: float


def press_with_friction(
    pad: StickingPad, coefficient: float, force: float, first: float | None, steps: int
) -> PressResult:
    """Press to `force` and until all ridges touch; `first` is the all-touch force without friction.

    Up to the smaller of both the force rises in `steps` equal steps; from there to the larger in as many, of
    a solid, whose steps take longer, in no more than the same size asks for. Raises ContactError where a
    step's sets do not settle, halved or not, or all do not touch up to SEARCH_FACTOR.
    """
    path = _Path(pad, coefficient)
    state, load, residual = path.points.start, 0.0, 0.0
    at_force: ContactState | DiscState | None = None
    searching = bool(path.waiting and first)  # at 0 all touch at once
    all_touch = None if searching else first
    low, high = sorted((force, first or force))
    later_steps = steps if path.plane else max(1, math.ceil(steps * min(1.0, high / low - 1)))
    for following in _forces(force, first, steps, later_steps):
        if at_force is not None and not searching:
            break
        after = path.points.step(state, load, following)
        residual = max(residual, after.residual)
        if searching:
            still = path.clear(after)
            if not still:
                all_touch = max(path.closing(ridge, state, load, following) for ridge in path.waiting)
                searching = False
            else:
                path.waiting = still
        state, load = after, following
        at_force = state if load == force else at_force
    if searching or at_force is None:
        raise ContactError(
            f"not all ridges touch at up to {SEARCH_FACTOR:g} times the force without friction"
        )
    shares = pad.ridges.sums(at_force.normal)
    return PressResult(all_touch, at_force.approach, shares, residual)


def _forces(force: float, first: float | None, steps: int, later_steps: int) -> list[float]:
    """The forces of a press: `force` itself is one of them."""
    low, high = sorted((force, first or force))
    shares, later = (np.arange(steps) + 1) / steps, (np.arange(later_steps) + 1) / later_steps
    forces = [*(low * shares[:-1]), low]
    if high > low:
        forces += [*(low + (high - low) * later[:-1]), high]
    further = high * (1 + shares)
    return [float(level) for level in (*forces, *further, *(high + further))]


class _Path:
    """A press under way; `waiting` are the ridges that do not touch yet."""

    def __init__(self, pad: StickingPad, coefficient: float) -> None:
        self.pad, self.coefficient = pad, coefficient
        self.plane = pad.compliance.shape[0] == 2 * pad.ridges.gap.size
        self.points = self._of(np.arange(pad.ridges.gap.size))
        self.waiting = [r for r in pad.ridges.numbers.tolist() if self._least(r, pad.ridges.fine_gap) > 0]

    def clear(self, state: Any) -> list[int]:
        """Those of the waiting ridges that still do not touch; the gap of a point that does is rounding."""
        gaps, touched = self._gaps(state, self.points), self.pad.ridges.of_point[state.touches]
        return [r for r in self.waiting if r not in touched and self._least(r, gaps) > 0]

    def closing(self, ridge: int, before: Any, start: float, end: float) -> float:
        """The force between two at which a ridge begins to touch that is clear at the first."""
        numbers = np.flatnonzero(self.pad.ridges.of_point != ridge)
        points, others = self._of(numbers), self.points.some(before, numbers)

        def gap(force: float) -> float:
            state = points.step(others, start, force) if force > start else others
            return self._least(ridge, self._gaps(state, points))

        if gap(end) >= 0.0:  # by rounding alone: with the ridge in contact it touches
            return end
        root = points.root
        return float(optimize.brentq(gap, start, end, xtol=root * end, rtol=root))

    def _of(self, numbers: Index) -> _PlanePoints | _SolidPoints:
        """Those contact points alone."""
        return (_PlanePoints if self.plane else _SolidPoints)(self.pad, numbers, self.coefficient)

    def _gaps(self, state: Any, points: _PlanePoints | _SolidPoints) -> Array:
        """Fine gaps `(p,)` in a state of these points alone."""
        risen = self.pad.fine[:, points.numbers] @ points.force(state)
        return np.asarray(self.pad.ridges.fine_gap - state.approach - risen)

    def _least(self, ridge: int, gaps: Array) -> float:
        """Smallest of a ridge's gaps `(p,)`, by a parabola through three of an edge (frictionless.py)."""
        points = self.pad.ridges.fine_of_point == ridge
        gaps, edge = gaps[points], self.pad.ridges.fine_edge[points]
        i = int(np.argmin(gaps))
        if not 0 < i < gaps.size - 1 or not edge[i - 1] == edge[i] == edge[i + 1]:
            return float(gaps[i])
        before, here, after = gaps[i - 1 : i + 2]
        bend = before - 2 * here + after
        return float(here - (after - before) ** 2 / (8 * bend)) if bend > 0 else float(here)


class _PlanePoints:
    """Some contact points of a section, `numbers` those of their movements in x, then in z."""

    root = ROOT

    def __init__(self, pad: StickingPad, points: Index, coefficient: float) -> None:
        self.numbers = np.concatenate([points, points + pad.ridges.gap.size])
        gap = pad.ridges.gap[points]
        compliance = pad.compliance[np.ix_(self.numbers, self.numbers)]
        self.skin = Compliance(compliance, gap, np.zeros(self.numbers.size))
        self.cone, self.start = FrictionCoefficients(coefficient, coefficient), at_rest(points.size)
        self.sideways = (0.0, None) if pad.whole else (None, 0.0)  # without a pull, or without a travel

    def step(self, before: Any, start: float, end: float) -> ContactState:
        """The state at a force from the one before."""
        first, last = (Drive(force, *self.sideways) for force in (start, end))
        return halved(lambda _: self.skin, before, first, last, self.cone)

    @staticmethod
    def force(state: ContactState) -> Array:
        """The forces on the skin, in x, then in z."""
        return np.concatenate([state.tangential, -state.normal])

    @staticmethod
    def some(state: ContactState, points: Index) -> ContactState:
        """A state of some points; the others carry nothing."""
        per_point = ("normal", "tangential", "anchor", "status", "slipped")
        return replace(state, **{name: getattr(state, name)[points] for name in per_point})


class _SolidPoints:
    """Some contact points of a solid, `numbers` those of their movements in x, z and y."""

    root = SOLID_ROOT

    def __init__(self, pad: StickingPad, points: Index, coefficient: float) -> None:
        m = pad.ridges.gap.size
        self.numbers = np.concatenate([points, points + m, points + 2 * m])
        x, z, y = np.arange(3 * points.size).reshape(3, -1)
        sideways, compliance = np.concatenate([x, y]), pad.compliance[np.ix_(self.numbers, self.numbers)]
        tangential = compliance[np.ix_(sideways, sideways)]
        self.skin = DiscCompliance(
            normal=compliance[np.ix_(z, z)],
            tangential=tangential,
            cross=compliance[np.ix_(z, sideways)],
            gap=pad.ridges.gap[points],
            able=tangential.diagonal() > HELD * compliance.diagonal().max(),
            floats=pad.whole,
        )
        self.coefficient, self.start = coefficient, unloaded(points.size)

    def step(self, before: Any, start: float, end: float, deepest: int = 4) -> DiscState:
        """The state at a force from the one before; where points do not settle, in two halves."""
        try:
            return solve_discs(self.skin, before, end, self.coefficient)
        except ContactError:
            if deepest == 0:
                raise
        middle = (start + end) / 2
        return self.step(self.step(before, start, middle, deepest - 1), middle, end, deepest - 1)

    @staticmethod
    def force(state: DiscState) -> Array:
        """The forces on the skin, in x, z and y."""
        x, y = np.split(state.tangential, 2)
        return np.concatenate([x, -state.normal, y])

    @staticmethod
    def some(state: DiscState, points: Index) -> DiscState:
        """A state of some points; the others carry nothing."""
        return state.of(points)
