"""A pad pressed with friction from first touch to the wanted force, and where its free surface would crease.

Where a compressed free surface folds onto itself: a limit of the material, not of the mesh. In plane strain a
smooth neo-Hookean surface compressed along itself to the stretch WRINKLES is unstable at every wavelength
(Biot, Appl. Sci. Res. A 12 (1963) 168; 0.544), so the finer the mesh the more surely it folds there. A defect
starts a crease from the stretch CREASES on (Hong, Zhao and Suo, Appl. Phys. Lett. 95 (2009) 111901; 0.646). A
crease is contact of the skin with itself, which no model here knows.

Measured on docs/facts.md's section, three ridges at 1.2 N, a coefficient of 1, pulled by travel: the stretch
passes WRINKLES at Ft/Fn 0.666, 0.673, 0.649 and 0.655 (fineness and order 0.5 2, 0.5 3, 1 3, 2 2), first in
the leading root fillet. There finer meshes fold at once: the determinant of F turns negative, on the coarsest
it is 0.5 still. The forces hardly feel it: 0.6 % between four meshes at 0.68. A tip fillet of 0.15 mm, not
0.05, does not help (0.635); at coefficients of 0.8 and 0.6 the tips fold too, at 0.61 and 0.59.

Small strain, plane strain. The plate comes down from the first touch on, its normal force growing from step
to step; sideways it is free, as in a scene's press. Each step is solved exactly (frictional.py). All ridges
touch where the last one's finely sampled gap closes. That force is found with this ridge out of contact, by
root finding within the step in which it begins to touch, as without friction (frictionless.py).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import optimize

from skincad.base.arrays import Array, Index
from skincad.mechanics.bodies import plane_body
from skincad.mechanics.bodies.condense import condense
from skincad.mechanics.bodies.elements import ContactStiffness, Outline, outlines
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


def undetected_contact(pad: FrictionalPad, state: FrictionalState, creases: bool) -> str | None:
    """Return what a state has that the model does not know: contact of the skin with itself or, off its
    crests, with the plate; with `creases` a surface that folds too. None for a sound state."""
    plate = (pad.top - state.contact.approach) / pad.unit
    loops = outlines(pad.rest, state.values)
    least = pinch(loops, plate)
    if creases and least.stretch < WRINKLES:
        ridge = pad.ridge[int(np.abs(pad.x / pad.unit - least.place[0]).argmin())]
        where = "tip" if least.tip else "flank or root"
        return (
            f"the surface folds onto itself at ridge {ridge}'s {where}: its stretch there is "
            f"{least.stretch:.3f}, and below {WRINKLES:g} no free surface stays smooth in plane strain"
        )
    return plane_body.undetected_contact(loops, lambda x: np.full_like(x, plate), with_itself=creases)


ROOT = 1e-9  # relative, of the force; steps are known to 1e-10
SEARCH_FACTOR = 3.0  # of the larger of the force and the all-touch force without friction: the search's end


@dataclass(frozen=True)
class StickingPad:
    """A condensed pad in its own units, both directions: `ridges` as the plate sees them without friction,
    `compliance` `(2 m, 2 m)` in x, then in z, and `fine` `(p, 2 m)`: how far the fine samples rise under
    these forces."""

    ridges: Ridges
    compliance: Array
    fine: Array

    def lowered(self, drops: Array) -> StickingPad:
        """Return the same pad with each ridge's crest lower by `drops` `(ridges,)`."""
        return replace(self, ridges=self.ridges.lowered(drops))


def sticking_pad_of(pad: Pad, system: ContactStiffness, unit: float) -> StickingPad:
    """Return the pad of an assembled mesh; `unit` is the pad's, mm."""
    space = system.space.components[0]
    along_x = system.contact - space.Range(1).start + space.Range(0).start
    contact, k = np.concatenate([along_x, system.contact]), along_x.size
    by_unknown = condense(system.matrix, np.setdiff1d(system.interior, along_x), contact).flexibility
    rows, fine = system.nodes.rows, system.fine.rows
    moved = np.hstack([(rows @ by_unknown[:k]).T, (rows @ by_unknown[k:]).T])
    whole = np.vstack([rows @ moved[:k], rows @ moved[k:]])
    ridges = seen_by_plate(pad, system, by_unknown[k:, k:], unit)
    return StickingPad(ridges, (whole + whole.T) / 2, np.asarray(fine @ moved[k:]))


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

    Up to the smaller of both, and from there to the larger, the force rises in `steps` equal steps. Raises
    ContactError where a step's sets do not settle, halved or not, or all do not touch up to SEARCH_FACTOR.
    """
    path = _Path(pad, FrictionCoefficients(coefficient, coefficient))
    state, load, residual = at_rest(pad.ridges.gap.size), 0.0, 0.0
    at_force: ContactState | None = None
    all_touch = None if path.waiting and first is not None else first
    searching = all_touch is None and first is not None
    for following in _forces(force, first, steps):
        if at_force is not None and not searching:
            break
        after = path.step(state, load, following)
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
    of_point = pad.ridges.of_point
    shares = np.array([at_force.normal[of_point == r].sum() for r in pad.ridges.numbers])
    return PressResult(all_touch, at_force.approach, shares, residual)


def _forces(force: float, first: float | None, steps: int) -> list[float]:
    """The forces of a press: `force` itself is one of them."""
    low, high = sorted((force, first or force))
    shares = (np.arange(steps) + 1) / steps
    forces = [*(low * shares[:-1]), low]
    if high > low:
        forces += [*(low + (high - low) * shares[:-1]), high]
    further = high * (1 + shares)
    return [float(level) for level in (*forces, *further, *(high + further))]


class _Path:
    """A press under way; `waiting` are the ridges that do not touch yet."""

    def __init__(self, pad: StickingPad, cone: FrictionCoefficients) -> None:
        self.pad, self.cone = pad, cone
        self.points = np.arange(pad.ridges.gap.size)
        self.skin = self._compliant(self.points)
        self.waiting = [r for r in pad.ridges.numbers.tolist() if self._least(r, pad.ridges.fine_gap) > 0]

    def step(self, before: ContactState, start: float, end: float) -> ContactState:
        """The state at a force from the one before."""
        return self._stepped(self.skin, before, start, end)

    def clear(self, state: ContactState) -> list[int]:
        """Those of the waiting ridges that still do not touch; the gap of a point that does is rounding."""
        gaps, touched = self._gaps(state, self.points), self.pad.ridges.of_point[state.touches]
        return [r for r in self.waiting if r not in touched and self._least(r, gaps) > 0]

    def closing(self, ridge: int, before: ContactState, start: float, end: float) -> float:
        """The force between two at which a ridge begins to touch that is clear at the first."""
        points = np.flatnonzero(self.pad.ridges.of_point != ridge)
        skin, others = self._compliant(points), _of_points(before, points)

        def gap(force: float) -> float:
            state = self._stepped(skin, others, start, force) if force > start else others
            return self._least(ridge, self._gaps(state, points))

        if gap(end) >= 0.0:  # by rounding alone: with the ridge in contact it touches
            return end
        return float(optimize.brentq(gap, start, end, xtol=ROOT * end, rtol=ROOT))

    def _stepped(self, skin: Compliance, before: ContactState, start: float, end: float) -> ContactState:
        return halved(lambda _: skin, before, Drive(start, 0.0), Drive(end, 0.0), self.cone)

    def _compliant(self, points: Index) -> Compliance:
        both = self._both(points)
        gap = self.pad.ridges.gap[points]
        return Compliance(self.pad.compliance[np.ix_(both, both)], gap, np.zeros(both.size))

    def _both(self, points: Index) -> Index:
        return np.concatenate([points, points + self.points.size])

    def _gaps(self, state: ContactState, points: Index) -> Array:
        """Fine gaps `(p,)` in a state of these points alone."""
        force = np.concatenate([state.tangential, -state.normal])
        risen = self.pad.fine[:, self._both(points)] @ force
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


def _of_points(state: ContactState, points: Index) -> ContactState:
    """A state of some points; the others carry nothing."""
    per_point = ("normal", "tangential", "anchor", "status", "slipped")
    return replace(state, **{name: getattr(state, name)[points] for name in per_point})
