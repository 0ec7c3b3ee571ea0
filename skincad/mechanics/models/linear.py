"""Small strain in the plane, on ever finer meshes.

A level is one mesh and one order (`level`). A refinement is two successive orders on one mesh: the higher
gives the values, the difference the error. Refinements are tried in order until the tolerance is met.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import Any

import numpy as np

from skincad.base import adaptivity
from skincad.base.adaptivity import overrun, unmet
from skincad.base.arrays import Array
from skincad.base.estimate import Estimate
from skincad.base.machine import one_blas_thread
from skincad.base.progress import Progress, Stopwatch
from skincad.inputs.design import Design
from skincad.mechanics.bodies import elements
from skincad.mechanics.bodies.condense import condense
from skincad.mechanics.bodies.mesh import (
    MeshRefinement,
    PadPiece,
    default_sizes,
    plane_piece,
    triangles,
    unit_of,
)
from skincad.mechanics.bodies.plane_body import signed_area, undetected_contact
from skincad.mechanics.contact.frictionless import (
    NodalContact,
    Ridges,
    all_touch_force,
    on_both_sides,
    over_crests,
    press,
    seen_by_plate,
)
from skincad.mechanics.contact.ridge_model import ridge_model
from skincad.mechanics.models.correction import LevelAnswer, level_answer
from skincad.mechanics.problem import (
    NEGLIGIBLE,
    Answer,
    ContactError,
    DeformedLoop,
    DeformedPiece,
    LateError,
    Pad,
    Request,
    RidgeModel,
    SelfContact,
    SizeError,
    check_balance,
    check_pad,
    focused,
    no_yield,
    one_ridge,
    pad_of,
    rise,
)


def deformed_section(solution: PlaneSolution) -> tuple[DeformedPiece, ...]:
    """Return the whole section in pieces: one, or the half that was meshed and its image at x = 0.

    Every loop has the silicone to its left. Between contact points the pressure is taken as straight.
    """
    by_x = np.argsort(solution.x)
    x, pressure, loops = solution.x[by_x], solution.pressure[by_x], []
    for outline in solution.outlines:
        rest = outline.rest * solution.unit
        # an edge's last point is the next one's first
        touches = outline.touches | np.roll(outline.touches, 1)
        there = np.where(touches, np.interp(rest[:, 0], x, pressure), 0.0)
        loops.append(DeformedLoop(rest, outline.moved * solution.unit, touches, np.maximum(there, 0.0)))
    if not loops:
        return ()
    outer = max(loops, key=lambda loop: abs(signed_area(loop.rest)))
    piece = tuple(
        loop if (signed_area(loop.rest) > 0) == (loop is outer) else _reversed(loop) for loop in loops
    )
    return (piece, tuple(_reversed(loop, -1.0) for loop in piece)) if solution.mirrored else (piece,)


def _reversed(loop: DeformedLoop, x: float = 1.0) -> DeformedLoop:
    """The loop run backwards, its x times a number: of its image at x = 0 by -1."""
    axes = np.array([x, 1.0])
    touches, pressure = loop.touches[::-1], loop.pressure[::-1]
    return DeformedLoop(loop.rest[::-1] * axes, loop.moved[::-1] * axes, touches, pressure)


def relative_error(answer: Answer, force: float, unit: float) -> float:
    """Return the largest relative error: of the all-touch force, of the approach, of a share against the mean
    share."""
    shares, approach, threshold = answer.ridge_force, answer.approach, answer.all_touch_force
    errors = [(shares[0].error or 0.0) * len(shares) / force]
    errors.append((approach.error or 0.0) / max(abs(approach.value or 0.0), NEGLIGIBLE * unit))
    if threshold.value is not None:
        errors.append((threshold.error or 0.0) / max(threshold.value, NEGLIGIBLE * force))
    return float(max(errors))


def shortfalls(
    reached: float, wanted: float, full: str, spent: float, budget: float | None, least: str
) -> tuple[str, ...]:
    """Return warnings for a missed tolerance or budget.

    `full` says why no finer mesh follows; `least` names the cheapest option.
    """
    missed = unmet(f"the mesh's error is {reached:.1e} of the value", reached, wanted)
    return (*(words + full for words in missed), *overrun(f"the cheapest {least} ", spent, budget))


MOST_CONTACT_UNKNOWNS = 9_000  # of 8,400 all in all 4.5 GB, at order 4; about 40 a ridge on the coarsest mesh


@dataclass(frozen=True, kw_only=True)
class PlaneSolution(LevelAnswer):
    """The solution on one mesh at one order, with the state of the meshed piece: `ridges`, whether it is a
    `mirrored` half, and of one in plane strain `half`, its stiffness for loads of either parity. `x` mm and
    `pressure` MPa `(m,)` are the meshed contact points'."""

    x: Array
    pressure: Array
    seconds: dict[str, float]
    ridges: Ridges
    unit: float  # of the piece, mm
    scale: float  # N on the whole pad for a force of 1 on the piece, in its units
    fault: str = ""  # undetected contact of the skin with itself or the plate
    half: elements.ContactStiffness | None = None
    mirrored: bool = False
    outlines: tuple[DeformedLoop, ...] = ()  # of the piece, at rest and under the force, in units
    # the fault at another force, N
    pressed: Callable[[float], str] | None = field(default=None, compare=False, repr=False)
    out_of_range: str = ""  # why the all-touch force is None, where a model ends before it
    states: Any = field(default=None, compare=False, repr=False)  # from which Newton's next level starts


# Of a mesh, an order, a force on the pad, crest offsets, and the level before on the same mesh, if any
LevelSolver = Callable[[PadPiece, int, float, tuple[float, ...], PlaneSolution | None], PlaneSolution]


def contact_unknowns(meshed: PadPiece, order: int) -> int:
    """Return how many contact unknowns the whole pad has at this order: the yield asks for all of them."""
    return elements.contact_unknowns(elements.curved(meshed.mesh, 1), order) * meshed.sides


@one_blas_thread()
def level(
    meshed: PadPiece,
    order: int,
    force: float,
    crest_offsets: tuple[float, ...] = (),
    _before: PlaneSolution | None = None,
) -> PlaneSolution:
    """Solve one order at `force` N on the pad, crests lower than the section's by `crest_offsets` mm. Those
    need a mesh of the whole pad."""
    pad, unit, scale = meshed.whole, meshed.unit, meshed.scale
    watch = Stopwatch()
    with watch.stage("assemble"):
        curved = elements.curved(meshed.mesh, order)
        contact = contact_unknowns(meshed, order)
        if contact > MOST_CONTACT_UNKNOWNS:
            raise too_large(contact, MOST_CONTACT_UNKNOWNS, "linear")
        assembled = elements.assemble(curved, order, pad.materials, pad.revolved)
        system = elements.symmetric_system(assembled)
    with watch.stage("condense"):
        small = condense(system.matrix, system.interior, system.contact)
    ridges = seen_by_plate(pad, system, small.flexibility, unit, crest_offsets)
    x, z = system.nodes.position.T
    over = over_crests(ridges, np.column_stack([x, z - rise(pad.plate, x * unit) / unit]))

    def pressed(force: float) -> tuple[NodalContact, Array, list[DeformedLoop], str | None]:
        state = press(ridges.flexibility, ridges.gap, force / scale)
        load = np.zeros(system.lift.size)
        load[system.contact] = -(system.nodes.rows.T @ state.force)
        moved = small.solve(load)
        outlines = elements.outlines(system, moved)
        wrong = undetected_contact(
            outlines,
            lambda x: over(x) - state.approach + rise(pad.plate, x * unit) / unit,
            mirrored=meshed.mirrored,
        )
        return state, moved, outlines, wrong

    with watch.stage("contact"):
        state, moved, outlines, wrong = pressed(force)
        first = all_touch_force(ridges, force / scale)
        residual = max(state.residual, _balance(system, moved, force / scale))
    x, pressure = pressures(meshed, system.nodes, state.force)
    forces, unknowns = (state.force, state.approach, first), system.unknowns
    answer = level_answer(meshed, ridges, *forces, scale=scale, unknowns=unknowns, residual=residual)
    return PlaneSolution(
        **vars(answer),
        x=x,
        pressure=pressure,
        seconds=watch.stages,
        ridges=ridges,
        unit=unit,
        scale=scale,
        fault=wrong or "",
        half=assembled if meshed.sides > 1 else None,
        mirrored=meshed.mirrored,
        outlines=tuple(outlines),
        pressed=lambda force: pressed(force)[-1] or "",
    )


def pressures(meshed: PadPiece, nodes: elements.Sample, force: Array) -> tuple[Array, Array]:
    """Return x, mm, and the pressure, MPa, of contact points under forces `(m,)` in units: one on the axis of
    a turned section stands for no area, and is left out."""
    off = nodes.weight > 0
    return nodes.position[off, 0] * meshed.unit, force[off] / nodes.weight[off] * meshed.whole.young_modulus


FARTHEST = 10.0  # times the force: how far contact of the skin with itself is looked for
SELF_CONTACT_BISECTIONS = 5  # to a thirtieth of the range looked at


def self_contact(solution: PlaneSolution, force: float, ridge_limit: float) -> SelfContact | None:
    """Return from which force on the skin meets itself or, off its crests, the plate: looked for from `force`
    N up to FARTHEST times that, or to where a ridge bears about `ridge_limit` N; None where it bears more."""
    largest = float(solution.ridge_force.max())
    if solution.pressed is None or largest > ridge_limit:
        return None
    low, high, where = 0.0, force, solution.fault
    with one_blas_thread():
        if not where:
            low, high = force, force * min(FARTHEST, ridge_limit / largest)
            where = solution.pressed(high)
        if not where:
            return SelfContact(high, Estimate(None, None, "N"))
        for _ in range(SELF_CONTACT_BISECTIONS):
            middle = (low + high) / 2
            if fault := solution.pressed(middle):
                high, where = middle, fault
            else:
                low = middle
    return SelfContact(low, Estimate((low + high) / 2, (high - low) / 2, "N"), where)


def too_large(contact: int, most: int, model: str) -> SizeError:
    """Return a model's refusal of a pad with so many contact unknowns, more than `most`."""
    rule = f"the {model} model takes at most {most} contact unknowns"
    return SizeError("ridge.count", rule, contact, "take fewer ridges, or the reduced or winkler model")


def _balance(system: elements.ContactStiffness, moved: Array, force: float) -> float:
    """Relative difference between the plate's force and what the clamped back carries."""
    clamped = system.lift.copy()
    clamped[system.interior] = clamped[system.contact] = 0.0
    carried = float(clamped @ (system.matrix @ moved))
    return check_balance(abs(carried / force - 1))


DEFAULT_TOLERANCE = 5e-3  # relative; model errors are ten times larger (docs/evidence/facts.md)
MOST_A_RIDGE = 150  # contact unknowns on the two coarsest meshes, order 3; an upper bound, never reached
# Contact unknowns of the whole pad against those of one ridge meshed alone, times the ridges: at least 0.92
# on the templates' coarsest mesh. What is too large by this is refused before the whole is meshed
SINGLE_RIDGE_FACTOR = 0.9
TAIL = 1.25  # of differences
# Of the approach's relative error for the all-touch force, and the other way round
THRESHOLD_BY_APPROACH, APPROACH_BY_THRESHOLD = 0.75, 0.4
# Of the approach's relative error for a share against the mean one. On a half few ridges' shares have one
# difference, which vanishes more easily
SHARE_BY_APPROACH = 0.4
CREST_TOLERANCE = 1e-9  # mm; crests that differ by less lie as designed
# Remaining time after the first mesh, and after its lower order, as a multiple of their own time: both orders
# and the yield, the higher order and the yield; 5 to 8 and 2.5 to 4.5 on the templates
AFTER_MESH, AFTER_ORDER = 6.0, 3.4


NEVER_ALL_TOUCH = (
    "taken as small, no strain makes all ridges touch: some stay clear however hard it is pressed"
)
# Prices measured on four templates: 0.7 to 1.3, 0.9 to 2.3, 2.1 to 5.8, 3.2 to 4.2
REFINEMENTS = (
    MeshRefinement(0.5, 3, 1.0, usual=6e-3),
    MeshRefinement(1.0, 3, 1.2, usual=2e-3),
    MeshRefinement(1.0, 4, 2.0, usual=1e-3),
    MeshRefinement(2.0, 4, 4.5, usual=4e-4),
    MeshRefinement(2.0, 5, 4.0),
)


def answer(design: Design, request: Request, progress: Progress | None = None) -> Answer:
    """Return the linear model's verdict on a design."""
    return solve(focused(pad_of(design), request.force), request, progress)


def solve(pad: Pad, request: Request, progress: Progress | None = None) -> Answer:
    """Return touching ridges, all-touch force, approach and shares of a pad, each with its error.

    The errors are those of discretisation alone: strains are taken as small and the pad as long. Meshes are
    refined until `tol` (relative; shares against the mean share) is met, or until the next one would overrun
    `budget`. A budget alone asks for the best answer within it. A warning says if the tolerance is not met.
    """
    result, best = refine(pad, request, level, "linear", progress)
    result = replace(result, deformed=deformed_section(best))
    if request.ridge_limit:
        limit = request.ridge_limit
        result = replace(result, self_contact=self_contact(best, request.force, limit))
    if result.all_touch_force.value is None:
        result = replace(result, warnings=(*result.warnings, NEVER_ALL_TOUCH))
    if request.ridge_model and best.all_touch_force is not None and len(pad.ridges) > 1:
        try:
            result = replace(result, ridge_model=reduced_model(pad, best, request.force, result.seconds))
        except ContactError as failure:  # the verdict does not need the yield's model
            result = replace(result, warnings=(*result.warnings, no_yield(failure)))
    return result


def refine(
    pad: Pad,
    request: Request,
    at: LevelSolver,
    model: str,
    progress: Progress | None = None,
    most: int | None = None,
) -> tuple[Answer, PlaneSolution]:
    """Return a model's answer and best level; `at` solves one level, and meshes are refined as in `solve`.

    A level takes `most` contact unknowns, by default this model's limit.
    """
    most = MOST_CONTACT_UNKNOWNS if most is None else most
    check_pad(pad)
    if request.crest_offsets and np.ptp(request.crest_offsets) <= CREST_TOLERANCE:
        request = replace(request, crest_offsets=())  # the first touch is later, and that is all
    check_coarsest(pad, most, model)
    budget = request.budget
    levels = _Levels(pad, request, at, model, progress, most, perf_counter())
    wanted = request.tol or (DEFAULT_TOLERANCE if budget is None else 0.0)
    reached = adaptivity.refine(
        levels.solved,
        REFINEMENTS,
        levels.estimated,
        wanted,
        budget,
        began=levels.began,
        ends=(SizeError,),
        price=adaptivity.by_price,
        first=0 if budget is not None else _first_refinement(wanted),
    )
    full = f": a finer mesh takes more than {most} contact unknowns" if reached.ended else ""
    warnings = shortfalls(reached.error, wanted, full, reached.spent, budget, "mesh")
    return replace(reached.assessment, warnings=warnings, seconds=levels.seconds), reached.answer


@dataclass
class _Levels:
    """Meshes and levels of one refinement, each made once."""

    pad: Pad
    request: Request
    at: LevelSolver
    model: str
    progress: Progress | None
    most: int
    began: float
    seconds: dict[str, float] = field(default_factory=dict)
    meshes: dict[float, PadPiece] = field(default_factory=dict)
    levels: dict[tuple[float, int], PlaneSolution] = field(default_factory=dict)

    def solved(self, refinement: MeshRefinement, before: object) -> PlaneSolution:
        """Solve both orders on a mesh; raises SizeError first if it is too large."""
        if refinement.fineness not in self.meshes:
            started = perf_counter()
            whole = bool(self.request.crest_offsets)  # crests of one part are not mirrored
            self.meshes[refinement.fineness] = plane_piece(self.pad, refinement.fineness, whole=whole)
            _add(self.seconds, {"mesh": perf_counter() - started})
            self._check_fits(self.levels, AFTER_MESH * (perf_counter() - started))
        mesh = self.meshes[refinement.fineness]
        contact = contact_unknowns(mesh, refinement.order)
        if contact > self.most:
            raise too_large(contact, self.most, self.model)
        for order in (refinement.order - 1, refinement.order):
            if (refinement.fineness, order) in self.levels:
                continue
            if self.progress:
                self.progress(f"{self.model} model: fineness {refinement.fineness:g}, order {order}")
            below = self.levels.get((refinement.fineness, order - 1))
            solution = self.at(mesh, order, self.request.force, self.request.crest_offsets, below)
            # the next order alone asks for states, and they take as much memory as all the rest
            self.levels = {key: replace(known, states=None) for key, known in self.levels.items()}
            self.levels[refinement.fineness, order] = solution
            _add(self.seconds, solution.seconds)
            if order < refinement.order:
                self._check_fits(before, AFTER_ORDER * math.fsum(solution.seconds.values()))
        return replace(self.levels[refinement.fineness, refinement.order], states=None)

    def estimated(
        self, refinement: MeshRefinement, best: PlaneSolution, before: PlaneSolution | None
    ) -> tuple[Answer, float]:
        """The refinement's answer and its largest relative error."""
        lower = self.levels[refinement.fineness, refinement.order - 1]
        result = estimated_answer(best, lower, before, refinement.order, self.seconds)
        if self.pad.face:
            result = replace(result, contact_width=contact_width(best, lower))
        return result, relative_error(result, self.request.force, unit_of(self.pad))

    def _check_fits(self, solved: object, rest: float) -> None:
        """Raise LateError if the first refinement must fit the budget and will not; `solved` holds earlier
        levels."""
        late, budget = perf_counter() - self.began + rest, self.request.budget
        if self.request.must_fit and not solved and budget is not None and late > budget:
            raise LateError(late)


def reduced_model(pad: Pad, best: PlaneSolution, force: float, seconds: dict[str, float]) -> RidgeModel:
    """The best level reduced to one force a ridge, for the yield; its time goes into `seconds`."""
    started = perf_counter()
    with one_blas_thread():
        half, sides = best.half, 1 if best.half is None else 2
        points = best.ridges.points if half is None else on_both_sides(best.ridges, half, pad.ridges)
        model = ridge_model(*points, max(force, best.all_touch_force or 0.0), best.unit, best.scale / sides)
    _add(seconds, {"yield": perf_counter() - started})
    return model


def _first_refinement(wanted: float) -> int:
    """Where to start: the refinement that mostly meets the tolerance, or from the third on the one before it.

    At sharp corners high orders on one mesh agree with each other better than with the truth; the refinement
    before then bounds the error.
    """
    usual = next(i for i, refinement in enumerate(REFINEMENTS) if refinement.usual <= wanted)
    return usual if usual < 2 else usual - 1


def check_coarsest(pad: Pad, most: int, model: str) -> None:
    """Raise SizeError for a pad that is too large in any case: by one of its ridges, meshed alone."""
    if MOST_A_RIDGE * len(pad.ridges) <= most or pad.revolved:
        return
    coarsest = REFINEMENTS[0]
    mesh = elements.curved(triangles(one_ridge(pad), default_sizes(pad, coarsest.fineness)), 1)
    expected = SINGLE_RIDGE_FACTOR * len(pad.ridges) * elements.contact_unknowns(mesh, coarsest.order)
    if expected > most:
        raise too_large(round(expected), most, model)


def estimated_answer(
    best: PlaneSolution,
    lower: PlaneSolution,
    before: PlaneSolution | None,
    order: int,
    seconds: dict[str, float],
) -> Answer:
    """Values of the best level; errors from the next lower order and from the refinement before.

    From order 4 only the corners' slow error is left; one that falls as 1 / k is k - 1 differences away. At
    order 3 the difference still holds the smooth error. A single difference may vanish by chance: all ridges
    share the largest error among them, all-touch force and approach a part of each other's relative one. TAIL
    and these parts were set by 40 random designs (bench/error_bars.py).
    """
    tail = TAIL * (1.2 if order <= 3 else order - 1.0)

    def error(of: Callable[[PlaneSolution], Array]) -> float:
        orders = tail * float(np.abs(of(best) - of(lower)).max())
        return orders if before is None else max(orders, float(np.abs(of(best) - of(before)).max()))

    threshold, approach = Estimate(None, None, "N"), error(lambda c: np.array([c.approach]))
    if None not in [c.all_touch_force for c in (best, lower, before or lower)]:
        value = best.all_touch_force or 0.0
        missed = error(lambda c: np.array([c.all_touch_force], dtype=float))
        by_force = missed / max(value, NEGLIGIBLE * float(best.ridge_force.sum()))
        missed = max(missed, THRESHOLD_BY_APPROACH * approach / abs(best.approach) * value)
        approach = max(approach, APPROACH_BY_THRESHOLD * by_force * abs(best.approach))
        threshold = Estimate(best.all_touch_force, missed, "N")
    share = error(lambda c: c.ridge_force)
    share = max(share, SHARE_BY_APPROACH * approach / abs(best.approach) * float(best.ridge_force.mean()))
    return Answer(
        touching=best.touching,
        all_touch_force=threshold,
        approach=Estimate(best.approach, approach, "mm"),
        ridge_force=tuple(Estimate(float(f), share, "N") for f in best.ridge_force),
        unknowns=best.unknowns,
        residual=best.residual,
        seconds=dict(seconds),
        fault=best.fault,
    )


def contact_width(best: PlaneSolution, lower: PlaneSolution) -> Estimate:
    """Return how wide the contact of a face is, mm: of a section that turns its diameter.

    It ends halfway between the last point under pressure and the next. The error is what lies between them,
    and what the order changes.
    """
    (width, open_), (other, _) = (width_of(s.x, s.pressure) for s in (best, lower))
    return Estimate(width, open_ + abs(width - other), "mm")


def width_of(x: Array, pressure: Array) -> tuple[float, float]:
    """Return how far it is between the ends of a contact, mm, and how far their points are from the next;
    of a piece at x >= 0 with its image. `x` and `pressure` `(m,)` are the contact points'."""
    ends, whole = [], float(x.min()) < -1e-6 * float(x.max())
    for side in (1, -1) if whole else (1,):
        order = np.argsort(side * x)
        far, loaded = side * x[order], pressure[order] > 0
        last = int(np.flatnonzero(loaded).max())
        following = far[min(last + 1, far.size - 1)]
        ends.append((far[last] + following, following - far[last]))
    width, open_ = np.mean(ends, axis=0)
    return float(width), float(open_)


def _add(total: dict[str, float], more: dict[str, float]) -> None:
    for stage, spent in more.items():
        total[stage] = total.get(stage, 0.0) + spent
