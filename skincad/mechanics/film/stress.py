"""The stress in the film strips of a pressed and pulled skin, with its error.

Paper: S1 and S2 bear the same stress under a normal force, and differ under a tangential one. Small strain,
plane strain; first the normal force without friction, then the tangential one with full stick (stick.py).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from skincad.base.adaptivity import refine, unmet
from skincad.base.arrays import Array
from skincad.base.errors import InputError, RefusedError, require_goals, require_number
from skincad.base.estimate import Estimate
from skincad.base.progress import Progress, Stopwatch
from skincad.base.result import Record, Result, columns_of, item, record, reported
from skincad.inputs.design import Design
from skincad.inputs.skin_tables import Slot
from skincad.mechanics.bodies import elements
from skincad.mechanics.bodies.condense import MOST_CONTACT_UNKNOWNS
from skincad.mechanics.bodies.mesh import MeshRefinement, PadPiece, Sizes, default_sizes, piece_of, triangles
from skincad.mechanics.check import LARGEST_FORCE, require_force
from skincad.mechanics.film.fields import RidgeField, collision, ridge_field
from skincad.mechanics.film.stick import StickSolution, level, with_fine_edges
from skincad.mechanics.problem import Pad, SizeError, check_pad, pad_of
from skincad.mechanics.validity import SMALL_STRAIN, limits, slope_warnings
from skincad.shape.skin import skin_of


@record()
class FilmStress(Record):
    """Mean stresses in the strips of ridges 1, 2, ... in MPa, tension positive, each with its error.

    `s1`, `s2`: across the film (its d33 sees that); `differential`: s1 - s2; `along1`, `along2`: along the
    film in the section; `lengthwise1`, `lengthwise2`: along y, the ridge. `force` and `tangential` N,
    `ridge_force` and `ridge_tangential` the plate's on each ridge (N; compression and +x positive).
    `needed_friction`: the coefficient that full stick needs at each ridge, |tangential| / normal force, None
    where the pull removes the normal force. Errors are those of discretisation. `fault` names an undetected
    contact of the skin with itself, "" if there is none. Flanks against the plate are not checked.
    """

    name: str = item(meaning="of the design")
    force: float = item("N", "normal, of the plate")
    tangential: float = item("N", "of the plate", key="tangential_force_N")
    ridges: int = item(meaning="how many there are")
    film: str = item(meaning="bonded, or absent")
    s1: tuple[Estimate, ...]
    s2: tuple[Estimate, ...]
    differential: tuple[Estimate, ...] = item("MPa", "S1 - S2 of each ridge", key="differential_stress_MPa")
    along1: tuple[Estimate, ...]
    along2: tuple[Estimate, ...]
    lengthwise1: tuple[Estimate, ...]
    lengthwise2: tuple[Estimate, ...]
    ridge_force: tuple[Estimate, ...] = item("N", "normal, on each ridge")
    ridge_tangential: tuple[Estimate, ...] = item("N", "on each ridge", key="ridge_tangential_force_N")
    needed_friction: tuple[Estimate, ...] = item(meaning="coefficient that full stick needs at each ridge")
    unknowns: int = item(meaning="of the finest mesh")
    residual: float = item(meaning="the largest relative violation of contact and equilibrium")
    seconds: dict[str, float] = item(meaning="wall time by stage, s")
    warnings: tuple[str, ...] = item(meaning="what to know of the numbers")
    fields: tuple[RidgeField, ...] = ()
    fault: str = ""

    def lean_share(self, ridge: int) -> Estimate:
        """Return |S1 - S2| / |S1| of a ridge, from 1; under the normal force alone it is the lean's doing."""
        one, between = self.s1[ridge - 1], self.differential[ridge - 1]
        if not one.value or between.value is None:
            return Estimate(None, None, "1")
        share = abs(between.value / one.value)
        return Estimate(share, ((between.error or 0.0) + share * (one.error or 0.0)) / abs(one.value), "1")

    @reported("MPa", "across the film in each ridge")
    def film_stress(self) -> dict[str, tuple[Estimate, ...]]:
        """Stress across both films."""
        return {"S1": self.s1, "S2": self.s2}

    @reported("MPa", "along the film in the section")
    def stress_along_film(self) -> dict[str, tuple[Estimate, ...]]:
        """Stress along both films."""
        return {"S1": self.along1, "S2": self.along2}

    @reported("MPa", "along y, the ridge")
    def stress_lengthwise(self) -> dict[str, tuple[Estimate, ...]]:
        """Stress of both films along the ridge."""
        return {"S1": self.lengthwise1, "S2": self.lengthwise2}


@record()
class FilmStresses(Result):
    """The films' stress under the normal force alone, and under it and a tangential force."""

    shown_by = "skincad.outputs.checks:FILM_STRESS"
    name: str = item(meaning="of the design")
    states: tuple[FilmStress, FilmStress] = item(
        meaning="under the normal force alone, and with the tangential one", key="film_stress"
    )

    def columns(self) -> dict[str, Any]:
        """Return a row for each ridge under each load: the plate's forces, and the stress in both strips."""
        return columns_of(
            {
                "force_N": state.force,
                "tangential_force_N": state.tangential,
                "ridge": ridge + 1,
                "ridge_force_N": state.ridge_force[ridge],
                "S1_MPa": state.s1[ridge],
                "S2_MPa": state.s2[ridge],
                "differential_stress_MPa": state.differential[ridge],
            }
            for state in self.states
            for ridge in range(state.ridges)
        )

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings of both states."""
        return tuple(dict.fromkeys(note for state in self.states for note in state.warnings))


EDGE_SEARCH = (0.5, 3)  # fineness and order of the run that finds where contact ends
TAIL = 2.0  # differences of orders; the true error is up to 1.4 of them (measured, film/test_stress.py)
PATH_NOTE = "full stick is an assumption, and the order of the forces counts: normal first, then tangential"


# A strip in silicone is a stiff inclusion whose corners are singular. Ungraded, its stress is 10 % too high
# at order 4 still
REFINEMENTS = (
    MeshRefinement(0.5, 4, tip=1 / 30, grading=0.5),
    MeshRefinement(1.0, 4, tip=1 / 100, grading=0.4),
    MeshRefinement(1.0, 5, tip=1 / 200, grading=0.3),
)


def solve(
    pad: Pad,
    thickness: float,
    force: float,
    tangential: Sequence[float],
    tol: float,
    show: Sequence[int] = (),
    progress: Progress | None = None,
) -> list[FilmStress]:
    """Return the stresses of a pad that has a strip of this thickness, mm, in each of its section's slots.

    Meshes are refined until the error is below `tol` of the largest stress. A warning says if it is not met.
    """
    check_pad(pad)
    watch, pull, plain = Stopwatch(progress), any(tangential), piece_of(pad, thickness)
    spent: dict[str, float] = {}

    def solve_level(piece: PadPiece, order: int, pulled: bool) -> StickSolution:
        solution = level(piece, piece.mesh, order, force, pulled)
        for stage, seconds in solution.seconds.items():
            spent[stage] = spent.get(stage, 0.0) + seconds
        return solution

    def meshed(piece: PadPiece, sizes: Sizes, order: int) -> PadPiece:
        with watch.stage("mesh"):
            mesh = triangles(piece.pad, sizes)
        contact = 2 * elements.contact_unknowns(elements.curved(mesh, 1), order)  # in both directions
        if contact > MOST_CONTACT_UNKNOWNS:
            limit = f"films' stresses take at most {MOST_CONTACT_UNKNOWNS} contact unknowns"
            raise SizeError("ridge.count", limit, contact, "take fewer ridges")
        return replace(piece, mesh=mesh)

    # later meshes are finer: a pad too large here is refused before anything is solved
    coarsest = meshed(plain, default_sizes(plain.pad, EDGE_SEARCH[0]), REFINEMENTS[0].order)
    first = solve_level(coarsest, EDGE_SEARCH[1], False)

    def solve_refinement(refinement: MeshRefinement, before: Any) -> tuple[StickSolution, StickSolution]:
        finer = with_fine_edges(plain, first if before is None else before.answer[0])
        finer = meshed(finer, refinement.sizes(finer), refinement.order)
        if progress:
            progress(f"film stress: fineness {refinement.fineness:g}, order {refinement.order}")
        lower, best = (solve_level(finer, k, pull) for k in (refinement.order - 1, refinement.order))
        return best, lower

    def estimate(
        _: MeshRefinement, both: tuple[StickSolution, StickSolution], __: object
    ) -> tuple[list[FilmStress], float]:
        results = [estimated_stress(*both, force, t) for t in tangential]
        return results, max(relative_error(state) for state in results)

    reached = refine(solve_refinement, REFINEMENTS, estimate, tol, began=watch.started, ends=(SizeError,))
    best, _ = reached.answer
    full = f": a finer mesh takes more than {MOST_CONTACT_UNKNOWNS} contact unknowns" if reached.ended else ""
    missed = unmet(f"the error is {reached.error:.1e} of the largest stress", reached.error, tol)
    short = tuple(words + full for words in missed)
    faults = [
        collision(best.piece, best.body, best.under(t).displacement, math.inf, 0.0) or "" for t in tangential
    ]
    shown = [tuple(ridge_field(best, ridge, t) for ridge in show) for t in tangential]
    seconds = {**watch.seconds(), **spent}
    return [
        replace(state, seconds=seconds, warnings=(*short, *state.warnings), fields=fields, fault=wrong)
        for state, fields, wrong in zip(reached.assessment, shown, faults, strict=True)
    ]


def _values(solution: StickSolution, tangential: float) -> dict[str, Array]:
    """The numbers of one level at a tangential force, by field of FilmStress."""
    state, whole = solution.under(tangential), solution.piece.whole
    place = {(s.feature, s.side): i for i, s in enumerate(whole.section.slots)}
    one, other = (state.strips[[place[r, side] for r in whole.ridges]] for side in ("S1", "S2"))
    return {
        "s1": one[:, 0],
        "s2": other[:, 0],
        "differential": one[:, 0] - other[:, 0],
        "along1": one[:, 1],
        "along2": other[:, 1],
        "lengthwise1": one[:, 2],
        "lengthwise2": other[:, 2],
        "ridge_force": state.normal,
        "ridge_tangential": state.tangential,
    }


UNITS = {"ridge_force": "N", "ridge_tangential": "N"}


def estimated_stress(
    best: StickSolution, lower: StickSolution, force: float, tangential: float
) -> FilmStress:
    """Values of the best level, errors from the next lower order.

    All ridges, and both sides, share the largest error among them: a single difference may vanish by chance.
    """
    here, there = (_values(solution, tangential) for solution in (best, lower))
    error = {key: TAIL * float(np.abs(here[key] - there[key]).max()) for key in here}
    for kind in ("s", "along", "lengthwise"):
        error[f"{kind}1"] = error[f"{kind}2"] = max(error[f"{kind}1"], error[f"{kind}2"])
    fields: dict[str, Any] = {
        key: tuple(Estimate(float(v), error[key], UNITS.get(key, "MPa")) for v in here[key]) for key in here
    }
    friction = tuple(friction_needed(fields["ridge_force"], fields["ridge_tangential"]))
    return FilmStress(
        name="",
        force=force,
        tangential=tangential,
        ridges=len(best.piece.whole.ridges),
        film="",
        **fields,
        needed_friction=friction,
        unknowns=best.unknowns,
        residual=max(best.residual, lower.residual),
        seconds={},
        warnings=tuple(stick_notes(best, friction, tangential)),
    )


def friction_needed(push: Sequence[Estimate], pull: Sequence[Estimate]) -> Iterator[Estimate]:
    """|tangential| / normal force of each ridge, its error from theirs; none where the ridge is lifted."""
    for n, t in zip(push, pull, strict=True):
        normal, along = n.value or 0.0, abs(t.value or 0.0)
        if along == 0.0:
            yield Estimate(0.0, 0.0, "1")
        elif normal <= (n.error or 0.0):
            yield Estimate(None, None, "1")
        else:
            ratio = along / normal
            yield Estimate(ratio, ((t.error or 0.0) + ratio * (n.error or 0.0)) / normal, "1")


def relative_error(stress: FilmStress) -> float:
    """Largest error of S1 and S2, and of their difference, against the largest S."""
    values = [abs(e.value or 0.0) for e in (*stress.s1, *stress.s2)]
    return max(stress.s1[0].error or 0.0, stress.differential[0].error or 0.0) / max(values)


def stick_notes(solution: StickSolution, friction: Sequence[Estimate], tangential: float) -> Iterator[str]:
    """Warnings about the assumptions of full stick at a tangential force."""
    if solution.pull_state is None or tangential == 0.0:
        return
    yield PATH_NOTE
    by_ridge = dict(zip(solution.piece.whole.ridges, (e.value for e in friction), strict=True))
    lifted = [str(r) for r, mu in by_ridge.items() if mu is None]
    if lifted:
        yield f"the pull takes the normal force off ridge {', '.join(lifted)}: no full stick there"
    else:
        worst = max(by_ridge, key=lambda r: by_ridge[r] or 0.0)
        yield f"full stick needs a friction coefficient of {by_ridge[worst]:.2g} (at ridge {worst})"
    counted = np.tile(solution.bonded, (len(solution.pull_state.node), 1))
    counted[1:] &= solution.pull_state.node[1:] != 0  # points on the cut, which the pull does not lift, once
    total = solution.under(tangential).node[counted]
    if (total < 0).any():
        pulling = -total[total < 0].sum() / solution.normal_state.normal.sum()
        count = np.count_nonzero(total < 0)
        yield f"{count} of {total.size} bonded points are in tension, with {pulling:.1%} of the force in all"


DEFAULT_TOLERANCE = 0.02  # of the largest; finite strain and free ends change more (docs/evidence/facts.md)
LEFT_OUT_NOTE = "the pad is taken as long and strains as small: free ends and finite strain are left out"


def film_stress(
    design: Design,
    force: float | None = None,
    tangential: float | None = None,
    *,
    tol: float | None = None,
    progress: Progress | None = None,
) -> FilmStresses:
    """Return the films' stress under a normal force alone, and pulled by a tangential one too, N.

    `force` is the design's own if None, `tangential` a quarter of it; `tol` relative to the largest stress.
    The stress field of the third ridge and of the middle one can be drawn. Raises as `film_stresses`.
    """
    normal = design.contact.force if force is None else force
    middle = (skin_of(design).count + 1) // 2
    pulls = (0.0, normal / 4 if tangential is None else tangential)
    alone, both = film_stresses(
        design, normal, pulls, tol=tol, show=sorted({min(3, middle), middle}), progress=progress
    )
    return FilmStresses(name=design.name, states=(alone, both))


def film_stresses(
    design: Design,
    force: float | None = None,
    tangential: Sequence[float] = (0.0,),
    *,
    tol: float | None = None,
    show: Sequence[int] = (),
    progress: Progress | None = None,
) -> tuple[FilmStress, ...]:
    """Return the films' stresses at a normal force and each tangential one, N, from one solution.

    `force` is the design's own if None, `tol` relative to the largest stress; `show` names ridges whose
    stress field comes as `fields`. Where the film is `ignored`, the stress is the silicone's in the film's
    place (the slot's, without a film). Raises InputError without slots, where they are empty, or for bad
    numbers; RefusedError where ridges strain beyond the model's range.
    """
    normal = design.contact.force if force is None else force
    wanted = DEFAULT_TOLERANCE if tol is None else tol
    check_request(design, normal, tangential, wanted, show)
    pad, thickness = filled_pad(design)
    states = solve(pad, thickness, normal, tangential, wanted, show, progress)
    notes = [LEFT_OUT_NOTE, *slope_warnings(design)]
    if design.film_state == "ignored":
        notes.append("the film is ignored: this is the silicone's stress in its place")
    name, film = design.name, design.film_state
    known = (replace(state, name=name, film=film, warnings=(*state.warnings, *notes)) for state in states)
    return tuple(_in_range(design, state) for state in known)


def filled_pad(design: Design) -> tuple[Pad, float]:
    """Return the pad with a strip in each slot, and the strips' thickness in mm.

    An ignored film is a strip of the skin's own moduli.
    """
    slot, pad = _filled_slot(design), pad_of(design)
    thickness = design.film.thickness if design.film else slot.thickness
    if pad.strips:
        return pad, thickness
    strips = tuple(slot.loop(thickness) for slot in pad.section.slots)
    return replace(
        pad,
        strips=strips,
        film_modulus=pad.young_modulus,
        film_ratio=pad.poisson_ratio,
        film_density=pad.density,
    ), thickness


def check_request(
    design: Design,
    force: float,
    tangential: Sequence[float] = (0.0,),
    tol: float = DEFAULT_TOLERANCE,
    show: Sequence[int] = (),
) -> None:
    """Raise InputError for a request that `film_stresses` refuses before any work."""
    skin = skin_of(design)
    _filled_slot(design)
    require_force(force)
    rule = f"must be from -{LARGEST_FORCE:g} to {LARGEST_FORCE:g} N"
    for pull in tangential:
        require_number("tangential", pull, lambda value: abs(value) <= LARGEST_FORCE, rule)
    require_goals(tol, None, "0.02")
    for ridge in show:
        if not 1 <= ridge <= skin.count:
            raise InputError("show", f"must be a ridge from 1 to {skin.count}", ridge)


def _filled_slot(design: Design) -> Slot:
    """The slot of each film, if stress crosses it."""
    slot = skin_of(design).slot
    if slot is None:
        rule = "is missing: a film's stress needs its place"
        raise InputError("slot", rule, remedy="add [slot] and [film]")
    if design.film_state == "loose":
        rule = "leaves the slots empty, and no stress crosses an empty slot"
        remedy = "add a [film] and say 'bonded', or say 'ignored'"
        raise InputError("contact.film", rule, design.film_state, remedy)
    return slot


def _in_range(design: Design, state: FilmStress) -> FilmStress:
    """Warn about nominal strains beyond small strain; raise RefusedError beyond the model's range."""
    normal, shear = (
        max(abs(force.value or 0.0) for force in forces)
        for forces in (state.ridge_force, state.ridge_tangential)
    )
    limit = limits(design)
    if wrong := limit.overload_reason(normal, shear) or state.fault:
        raise RefusedError(f"{wrong}; take smaller forces")
    strain = limit.strain(normal, shear)
    if strain <= SMALL_STRAIN:
        return state
    note = f"nominal ridge strain {strain:.2g} is beyond the small-strain range ({SMALL_STRAIN:g})"
    return replace(state, warnings=(*state.warnings, note))
