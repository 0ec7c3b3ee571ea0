"""Contact with friction on a condensed pad: a plate's step by sets of open, sticking and slipping points.

Unknown are the points' normal forces p >= 0 and tangential forces t, the plate's approach d and travel s.
With the compliance C, gaps g, and anchors a (where a point sits on the plate): w = g - d - u_z >= 0, w p = 0,
and |t| <= mu p; a point sticks, u_x - s = a, or slips with t = mu p against its motion. Where friction
follows another law, mu p stands for what that bears (state.py). The plate has a given normal force,
and a given tangential force or travel. Sticking points keep their anchor from step to step, so a held load
does not creep. Implicit in time: Klarbring, Ing.-Arch. 56 (1986) 529; the sets are found by a semi-smooth
Newton, Alart and Curnier, CMAME 92 (1991) 353.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from scipy import linalg

from skincad.base.arrays import Array, Index, Mask
from skincad.base.interrupt import safe_point
from skincad.mechanics.contact.state import (
    LEFT,
    OPEN,
    RIGHT,
    STICK,
    Compliance,
    ContactState,
    Drive,
    FrictionCoefficients,
    GrossSlip,
    Status,
    at_rest,
)
from skincad.mechanics.problem import ContactError

State = TypeVar("State")
Contact = TypeVar("Contact", bound=ContactState)
# From a state, and the drive that led to it, to another drive; what share of the whole step that is
Advance = Callable[[State, Drive, Drive, float], State]


def in_halves(
    advance: Advance[State],
    before: State,
    start: Drive,
    end: Drive,
    joined: Callable[[State, State], State],
    deepest: int,
    share: float = 1.0,
) -> State:
    """Return what `advance` says of a step, or of this `share` of one; where it does not converge, of both
    halves `joined`, cut `deepest` times at most. Raises as `advance` does."""
    try:
        return advance(before, start, end, share)
    except GrossSlip:
        raise
    except ContactError:
        if deepest == 0:
            raise
    middle = between(start, end)
    first = in_halves(advance, before, start, middle, joined, deepest - 1, share / 2)
    try:
        return joined(first, in_halves(advance, first, middle, end, joined, deepest - 1, share / 2))
    except GrossSlip as limit:
        limit.last = joined(first, limit.last)
        raise


def halved(
    skin: Callable[[Drive], Compliance],
    before: ContactState,
    start: Drive,
    end: Drive,
    cone: FrictionCoefficients,
) -> ContactState:
    """Return `solve_contact` at `end`, in halves where need be; what the parts slipped is added up."""

    def advance(before: ContactState, _start: Drive, end: Drive, _share: float) -> ContactState:
        return solve_contact(skin(end), before, end, cone)

    return in_halves(advance, before, start, end, joined, 4)


def joined(first: Contact, second: Contact) -> Contact:
    """Return the state at the end of two steps as that of one."""
    slipped, residual = first.slipped + second.slipped, max(first.residual, second.residual)
    return replace(second, slipped=slipped, residual=residual)


def between(a: Drive, b: Drive) -> Drive:
    """Return what the plate does halfway."""

    def mean(one: float | None, other: float | None) -> float | None:
        return None if one is None or other is None else (one + other) / 2

    pull, travel = mean(a.tangential, b.tangential), mean(a.travel, b.travel)
    return Drive((a.normal + b.normal) / 2, pull, travel, (a.angle + b.angle) / 2)


SWEEPS = 40  # with all points updated at once; five to ten are usual, beyond this it cycles
SINGLE_SWEEPS = 80  # with the worst point alone updated
SEARCHED = 2500  # sets of those that are searched best first, 1 ms each; one to two thousand are usual
MOST_WRONG = 4  # points of which each is put elsewhere then
EASY_COEFFICIENT = 0.3  # a coefficient below which the sets settle by themselves
START_SHARE = 0.8  # of the coefficient, for a start
MAX_FACTORISATIONS = 8  # factorisations of the last sets, for the steps in which they stay
ROUNDING = 1e-12  # relative; what counts as zero when the sets are updated
MAX_RESIDUAL = 1e-10  # relative; a larger residual is never accepted


def solve_contact(
    skin: Compliance, before: ContactState, drive: Drive, cone: FrictionCoefficients
) -> ContactState:
    """Return the state at the end of a step; a plate with mass may leave the skin and may slide.

    Raises GrossSlip where friction cannot hold the tangential force, ContactError where the sets do not
    settle or the residual is above 1e-10 of scale: halve the step then.
    """
    if drive.stiffness:
        return _Step(skin, before, drive, cone).solution()
    if drive.normal < 0:
        raise ContactError(f"the plate's normal force must not pull, got {drive.normal:g} N")
    if drive.normal == 0.0:
        return _lifted(skin, before, drive)
    step = _Step(skin, before, drive, cone)
    pull = abs(drive.tangential or 0.0)
    if drive.travel is None and not cone.breakpoints and pull > cone.static * drive.normal * (1 - ROUNDING):
        sliding_state = step.solution(all_slip=float(np.sign(drive.tangential or 0.0)))
        raise GrossSlip(sliding_state, f"{pull:g} N is all that friction holds at {drive.normal:g} N")
    return step.solution()


def _lifted(skin: Compliance, before: ContactState, drive: Drive) -> ContactState:
    """The state without a normal force: nothing touches, the plate is where it would just touch."""
    if drive.tangential:
        limit = replace(before, normal=0 * before.normal, tangential=0 * before.normal)
        raise GrossSlip(limit, "a plate without normal force holds no tangential force")
    m = skin.gap.size
    travel = before.travel if drive.travel is None else drive.travel
    approach = float((skin.gap - skin.free[m:]).min())
    anchor = skin.free[:m] - travel
    return replace(at_rest(m), anchor=anchor, approach=approach, travel=travel, angle=drive.angle)


@dataclass(frozen=True, eq=False)
class _TrialSolution:
    """The solution for one choice of sets; arrays are `(m,)`.

    Forces `p` and `t`, plate `d` and `s`, gaps `w`, slips `moved`, displacements `x` by the forces. `rounded`
    are the gaps of closed points too, 0 but for rounding. `plate_residual` is the relative imbalance of the
    forces on a plate with mass.
    """

    p: Array
    t: Array
    d: float
    s: float
    w: Array
    rounded: Array
    x: Array
    moved: Array
    plate_residual: float


class _Step:
    """One step's data and scales."""

    def __init__(
        self, skin: Compliance, before: ContactState, drive: Drive, cone: FrictionCoefficients
    ) -> None:
        self.skin, self.before, self.drive, self.cone = skin, before, drive, cone
        m = self.m = skin.gap.size
        c, self.solved = skin.compliance, skin.solved
        self.xx, self.xz, self.zx, self.zz = c[:m, :m], c[:m, m:], c[m:, :m], c[m:, m:]
        self.gap = skin.gap - skin.free[m:]
        self.home = before.anchor - skin.free[:m]  # what C (t, -p) in x is compared with, plus the travel
        self.load = drive.normal  # scale of the forces
        if drive.stiffness:
            self.load = max(abs(drive.normal), float(before.normal.sum()), 1e-300)
        self.force = self.load / max(1, int(np.count_nonzero(before.touches)))
        self.length = float(np.ptp(self.gap)) or float(self.load * self.zz.diagonal().mean())
        if cone.breakpoints and not skin.area.size:
            raise ContactError("friction by shear stress asks for the area of each contact point")
        # a point that slid keeps sliding by the kinetic coefficient; one that stuck breaks off at the static
        self.limit = np.where(before.status >= RIGHT, cone.slides, cone.sticks)
        self.line = cone.line(before.normal, skin.area)
        self.searches = not drive.stiffness and not cone.breakpoints and bool(before.touches.any())

    def solution(self, all_slip: float = 0.0) -> ContactState:
        """The state whose sets reproduce themselves; with `all_slip` every closed point slips that way.

        Much friction makes the sets cycle from where the last step left them, although an equilibrium is
        near: then the search restarts from all points sliding, and from all sticking; and at last it tries
        one set after the other, the least wrong one first.
        """
        starts = iter([self._all(self._way(all_slip))]) if all_slip else self._starts()
        sweeps, slides = 0, 0.0
        for status in starts:
            result, count = self._sweep(status, all_slip)
            sweeps += count
            if isinstance(result, ContactState):
                return result
            slides = result or slides
        if slides:  # less than the static limit, but what has broken off holds the kinetic friction alone
            pull, normal = abs(self.drive.tangential or 0.0), self.drive.normal
            words = f"{pull:g} N is more than kinetic friction holds at {normal:g} N once all points slip"
            raise GrossSlip(self.solution(all_slip=slides), words)
        if self.searches and not all_slip and (found := self._least_wrong()):
            return found
        raise ContactError(f"the sets of open, sticking and slipping points do not settle in {sweeps} sweeps")

    def _least_wrong(self) -> ContactState | None:
        """The state of the first sets that are right, of at most SEARCHED, searched best first: next to sets
        lie those with all wrong points put right, and with one of the most wrong ones put elsewhere.

        A point at a corner may neither stick nor slip among these neighbours, however much the sweeps go on:
        it has to let go, and some around it with it. From rest, under a law with breakpoints, and of a plate
        with mass, whose steps are cut instead, nothing is searched.
        """
        queue: list[tuple[float, int, Status, Array, Status]] = []
        seen = set[bytes]()

        def add(status: Status) -> ContactState | None:
            if (key := status.tobytes()) in seen or not (status != OPEN).any():
                return None
            seen.add(key)
            try:
                solution = self._solve(status, 0.0)
                wrong, wanted = self._violations(solution, status, 0.0)
                if self._missing_pull(solution, status):
                    return None
                if not wrong.any():
                    return self._accepted(solution, status, 0.0)
            except ContactError:  # no solution, or none that is accurate: others are tried
                return None
            heapq.heappush(queue, (float(wrong.sum()), len(seen), status, wrong, wanted))
            return None

        found = add(self._start())
        while found is None and queue and len(seen) < SEARCHED:
            safe_point()
            _, _, status, wrong, wanted = heapq.heappop(queue)
            # all wrong points put right, or one of the most wrong ones put elsewhere
            neighbours = [np.where(wrong > 0, wanted, status)]
            for point in np.argsort(-wrong, kind="stable")[: min(MOST_WRONG, np.count_nonzero(wrong))]:
                for other in (kind for kind in (OPEN, STICK, RIGHT, LEFT) if kind != status[point]):
                    neighbours.append(status.copy())
                    neighbours[-1][point] = other
            found = next((state for change in neighbours if (state := add(change))), None)
        return found

    def _starts(self) -> Iterator[Status]:
        """Where the search starts: the sets before; all that touched sliding either way, or sticking; the
        sets of less friction."""
        yield self._start()
        ways = (RIGHT, LEFT) if (self.drive.tangential or 0.0) >= 0 else (LEFT, RIGHT)
        for way in (*ways, STICK):
            yield self._all(way)
        if self.cone.static > EASY_COEFFICIENT:
            weak = _Step(self.skin, self.before, self.drive, self.cone.capped(START_SHARE))
            weak.searches = False
            try:
                yield weak.solution().status
            except ContactError:
                return

    def _sweep(self, status: Status, all_slip: float) -> tuple[ContactState | float, int]:
        """The state that the sets lead to; 0 where they cycle, the way (+1, -1) where all that touches slides
        and does not hold the pull; and the sweeps that it took."""
        seen: set[bytes] = set()
        single, self.line = False, self.cone.line(self.before.normal, self.skin.area)
        for sweep in range(SWEEPS + SINGLE_SWEEPS):
            safe_point()
            solution = self._solve(status, all_slip)
            wrong, wanted = self._violations(solution, status, all_slip)
            missing = 0.0 if all_slip else self._missing_pull(solution, status)
            if missing:  # nothing sticks, so the travel is not solved for, and no halt is judged by it
                halts = (status >= RIGHT) & (wanted == STICK)
                wrong[halts] = self._off_line(solution, status)[halts]
                wanted[halts] = status[halts]
                if not wrong.any():
                    status = self._split_sliding(solution, status)
                    if not (status == STICK).any():
                        return float(np.sign(missing)), sweep + 1
                    continue
            if not wrong.any():
                return self._accepted(solution, status, all_slip), sweep + 1
            key = status.tobytes() + self.line.tobytes()
            single = single or sweep >= SWEEPS or key in seen
            seen.add(key)
            status = status.copy()
            change = [int(np.argmax(wrong))] if single else np.flatnonzero(wrong)
            status[change] = wanted[change]
            if self.cone.breakpoints:  # points go on the lines on which their pressures lie
                self.line = self.line.copy()
                self.line[change] = self.cone.line(solution.p, self.skin.area)[change]
            if not self.drive.stiffness and not (status != OPEN).any():
                status[int(np.argmin(solution.w))] = STICK if not all_slip else self._way(all_slip)
        return 0.0, SWEEPS + SINGLE_SWEEPS

    def _missing_pull(self, solution: _TrialSolution, status: Status) -> float:
        """The part of the pull, N, that is not borne. Without a sticking point `_solve` does not enforce
        it."""
        if self.drive.stiffness or self.drive.tangential is None or (status == STICK).any():
            return 0.0
        missing = self.drive.tangential - float(solution.t.sum())
        return missing if abs(missing) > ROUNDING * self.drive.normal else 0.0

    def _split_sliding(self, solution: _TrialSolution, status: Status) -> Status:
        """The sets of sliding points where the plate's travel bears the pull: points it has passed are
        dragged along, the others back; the one at which the sum is reached sticks, none where it is not."""
        closed = np.flatnonzero(status != OPEN)
        closed = closed[np.argsort(solution.moved[closed], kind="stable")]
        borne = self.cone.borne(solution.p, self.skin.area)
        dragged = self.cone.slides * (2 * np.cumsum(borne[closed]) - borne.sum())
        pull, whole = self.drive.tangential or 0.0, self.cone.slides * float(borne.sum())
        at = int(np.searchsorted(dragged, pull)) if pull >= -whole else closed.size
        status = status.copy()
        status[closed[:at]], status[closed[at:]] = RIGHT, LEFT
        status[closed[at : at + 1]] = STICK
        return status

    def _start(self) -> Status:
        """The sets before, or from rest the points within a stiff guess of the approach, sticking."""
        if self.drive.stiffness or self.before.touches.any():
            return self.before.status
        near = min(float(np.ptp(self.gap)), 0.5 * self.drive.normal * float(np.mean(self.zz)))
        return np.where(self.gap <= self.gap.min() + near, STICK, OPEN).astype(np.int8)

    @staticmethod
    def _way(sign: float) -> int:
        return RIGHT if sign > 0 else LEFT

    def _all(self, way: int) -> Status:
        """All points of the start in one set."""
        return np.where(self._start() != OPEN, way, OPEN).astype(np.int8)

    def _solve(self, status: Status, all_slip: float) -> _TrialSolution:
        """Forces and plate for given sets.

        Rows: closed points' gaps, sticking points' slips, sum of p, and sum of t or the travel. Without a
        sticking point the travel is not determined by the forces; it stays as it was, or the smallest that
        lets all slip. A plate with mass always has its place: its approach and travel are counted from there.
        """
        inert = self.drive.stiffness
        closed, stuck = np.flatnonzero(status != OPEN), np.flatnonzero(status == STICK)
        way = (status == RIGHT).astype(float) - (status == LEFT)
        drag, offset = self.cone.sliding(self.line, way, self.skin.area)
        k, n = closed.size, stuck.size
        travel_given = self.drive.travel is not None or (n == 0 and not inert)
        # counted from here, so that a tiny force is not lost in rounding
        first = self.drive.ahead[0] if inert else float(self.gap[closed].min())
        start = self.drive.ahead[1] if inert else self.before.travel
        travel = start if self.drive.travel is None else self.drive.travel
        side = np.concatenate([first - self.gap[closed], self.home[stuck], [self.drive.normal]])
        if travel_given or inert:
            side[k : k + n] += travel
        if not travel_given:
            side = np.append(side, self.drive.tangential or 0.0)
        if offset is not None:
            side[:k] += (self.zx @ offset)[closed]
            side[k : k + n] -= (self.xx @ offset)[stuck]
            side[-1] -= 0.0 if travel_given else offset.sum()
        unknowns, _ = linalg.lapack.dgetrs(*self._factor(status, closed, stuck, drag, travel_given), side)
        p, t = np.zeros(self.m), np.zeros(self.m)
        p[closed] = unknowns[:k]
        t[closed] = drag[closed] * p[closed]
        t[stuck] += unknowns[k : k + n]
        t += 0.0 if offset is None else offset
        d = first + float(unknowns[k + n])
        rounded = self.gap - d + self.zz @ p - self.zx @ t
        w = rounded.copy()
        w[closed] = 0.0
        x = self.xx @ t - self.xz @ p
        place = x - self.home
        if not travel_given:
            travel = (travel if inert else 0.0) + float(unknowns[-1])
        elif self.drive.travel is None and not inert and all_slip and self.drive.tangential:
            # the last point has just begun to slip
            travel = float(place[closed].max() if all_slip > 0 else place[closed].min())
        moved = place - travel
        unborne = 0.0
        if inert:  # what the plate's equations miss, by how far it is beyond its drive's place
            ahead = unknowns[k + n :]
            sums = [p.sum() - self.drive.normal, t.sum() - (self.drive.tangential or 0.0)]
            unborne = float(np.abs(np.array(sums[: ahead.size]) + inert * ahead).max()) / self.load
        return _TrialSolution(p, t, d, travel, w, rounded, x, moved, unborne)

    def _factor(
        self, status: Status, closed: Index, stuck: Index, drag: Array, travel_given: bool
    ) -> tuple[Array, Array]:
        """The factorised equations of these sets; t is drag p, plus an own unknown where a point sticks."""
        slopes = drag if self.cone.breakpoints else np.float64(self.cone.kinetic)
        key = self.skin.tag + status.tobytes() + bytes([travel_given]) + slopes.tobytes()
        if key in self.solved:
            return self.solved[key]  # type: ignore[no-any-return]
        k, n = closed.size, stuck.size
        # by columns, as the factorisation wants it; a whole row is taken faster than the parts of it
        matrix = np.zeros((k + n + (1 if travel_given else 2),) * 2, order="F")
        equations, slides = np.concatenate([self.m + closed, stuck]), np.flatnonzero(drag[closed])
        rows, points = self.skin.compliance[equations], matrix[: k + n, : k + n]
        points[...] = rows.take(equations, axis=1)
        points[:k, k:] *= -1  # np.negative in place is wrong on one strided row (numpy 2.4)
        points[k:, :k] *= -1
        if slides.size:
            dragged = rows.take(closed[slides], axis=1) * drag[closed[slides]]
            points[:k, slides] -= dragged[:k]
            points[k:, slides] += dragged[k:]
        matrix[:k, k + n] = -1.0
        matrix[k + n, :k] = 1.0
        matrix[k + n, k + n] = self.drive.stiffness
        if not travel_given:
            matrix[k : k + n, -1] = -1.0
            matrix[-1, :k] = drag[closed]
            matrix[-1, k : k + n] = 1.0
            matrix[-1, -1] = self.drive.stiffness
        lower, pivots, singular = linalg.lapack.dgetrf(matrix, overwrite_a=True)
        if singular:
            raise ContactError("the contact equations are singular: friction wedges the points")
        if len(self.solved) >= MAX_FACTORISATIONS:
            self.solved.clear()
        self.solved[key] = lower, pivots
        return lower, pivots

    def _violations(self, solution: _TrialSolution, status: Status, all_slip: float) -> tuple[Array, Status]:
        """How wrong each point's set is, relative to scale (0: not at all), and the set it should have."""
        p, t, w, moved = solution.p, solution.t, solution.w, solution.moved
        small = ROUNDING * max(float(np.abs(p).max()), 1e-300)
        short = ROUNDING * self.length
        wrong, wanted = np.zeros(self.m), status.copy()

        def mark(where: Mask, amount: Array, scale: float, to: Index | Status | int) -> None:
            wrong[where] = amount[where] / scale
            wanted[where] = to[where] if isinstance(to, np.ndarray) else to

        closed = status != OPEN
        if self.cone.breakpoints:
            off = self._off_line(solution, status)
            mark(off > 0, off, 1.0, status)
        if not all_slip:
            excess = np.abs(t) - self.limit * self.cone.borne(p, self.skin.area)
            if (breaks := (status == STICK) & (excess > small)).any():
                mark(breaks, excess, self.force, np.where(t > 0, RIGHT, LEFT))
            way = np.where(status == RIGHT, 1.0, -1.0)
            if (halts := (status >= RIGHT) & (way * moved > short)).any():
                mark(halts, np.abs(moved), self.length, STICK)
        if (opens := closed & (p < -small)).any():
            mark(opens, -p, self.force, OPEN)
        if (closes := ~closed & (w < -short)).any():
            # a closing point whose trial slip exceeds mu times its gap slips, or the sets cycle
            follows = np.abs(moved) > self.cone.static * np.abs(w)
            against = np.where(moved > 0, LEFT, RIGHT)  # friction opposes the slip
            to = self._way(all_slip) if all_slip else np.where(follows, against, STICK)
            mark(closes, -w, self.length, to)
        return wrong, wanted

    def _off_line(self, solution: _TrialSolution, status: Status) -> Array:
        """How wrong sliding points' lines are `(m,)`, relative to the forces: by Coulomb's law never."""
        if not self.cone.breakpoints:
            return np.zeros(self.m)
        off = np.abs(np.abs(solution.t) - self.cone.slides * self.cone.borne(solution.p, self.skin.area))
        off[(status < RIGHT) | (off <= ROUNDING * np.abs(solution.p).max())] = 0.0
        return np.asarray(off / self.force)

    def _accepted(self, solution: _TrialSolution, status: Status, all_slip: float) -> ContactState:
        """Measure every condition against its scale; refuse what is not met."""
        residual = self._residual(solution, status, all_slip)
        if not residual <= MAX_RESIDUAL:
            words = f"contact and friction are satisfied only to {residual:.1e}, not to {MAX_RESIDUAL:g}"
            raise ContactError(words)
        stuck = status == STICK
        # what does not stick sits where it is now; counted from its last anchor, rounding would add up
        anchor = np.where(stuck, self.before.anchor, solution.x + self.skin.free[: self.m] - solution.s)
        slipped = np.where(status >= RIGHT, solution.moved, 0.0)
        p, t = np.maximum(solution.p, 0.0), solution.t
        gross, angle = bool(all_slip), self.drive.angle
        return ContactState(
            normal=p,
            tangential=t,
            anchor=anchor,
            status=status,
            slipped=slipped,
            approach=solution.d,
            travel=solution.s,
            residual=residual,
            gross=gross,
            angle=angle,
        )

    def _residual(self, solution: _TrialSolution, status: Status, all_slip: float) -> float:
        p, t, w = solution.p, solution.t, solution.rounded
        closed, stuck, slides = status != OPEN, status == STICK, status >= RIGHT
        borne = self.cone.borne(p, self.skin.area)
        excess = np.abs(t) - np.where(stuck, self.limit, self.cone.slides) * borne
        if self.cone.breakpoints:
            excess[slides] = np.abs(excess[slides])  # what slides bears neither more nor less
        largest, length = float(np.abs(p).max()), self.length + abs(solution.d)
        largest = largest or self.force  # nothing touches a plate with mass
        terms: list[float] = [
            float(-w.min()) / length,
            float(np.abs(w[closed]).max(initial=0.0)) / length,
            float(-p.min()) / largest,
            float(excess.max()) / largest,
            float(np.abs(solution.moved[stuck]).max(initial=0.0)) / length,
            solution.plate_residual,
        ]
        if not self.drive.stiffness:
            terms.append(abs(float(p.sum()) / self.drive.normal - 1))
        if not self.drive.stiffness and self.drive.tangential is not None and not all_slip:
            terms.append(abs(float(t.sum()) - self.drive.tangential) / self.drive.normal)
        way = np.where(status == RIGHT, 1.0, -1.0)[slides]
        if not all_slip:
            terms.append(float((way * solution.moved[slides]).max(initial=0.0)) / length)
        return max(0.0, *terms)
