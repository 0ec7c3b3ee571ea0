"""Small strain of the solid pad, on ever finer meshes.

The solid model: the pad's finite length with its free ends, small strain, exact contact. A level is one
section mesh, one order in it and one set of layers along y. A refinement solves the section at two orders and
the layers at two gradings. Functions are products, so what finer layers change is nearly the same at both
orders: it is added, and the differences are the errors. Meshes are refined until the tolerance is met."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np

from skincad.base.adaptivity import Refinement, by_price, refine
from skincad.base.arrays import Array
from skincad.base.estimate import Estimate
from skincad.base.machine import one_blas_thread
from skincad.base.progress import Progress, Stopwatch
from skincad.inputs.design import Design
from skincad.mechanics.bodies import elements, prisms
from skincad.mechanics.bodies.mesh import (
    FOCUS_EDGES,
    MeshRefinement,
    PadPiece,
    Sizes,
    height_of,
    meshed_piece,
    unit_of,
)
from skincad.mechanics.contact.frictionless import seen_by_plate
from skincad.mechanics.models.correction import LevelAnswer, frictionless_level
from skincad.mechanics.models.linear import relative_error, shortfalls
from skincad.mechanics.problem import (
    Answer,
    Bend,
    Pad,
    Request,
    SizeError,
    check_balance,
    check_pad,
    focused,
    solid_pad_of,
)

MOST_UNKNOWNS = 600_000  # about 6 GB of fronts
MOST_CONTACT = 6000  # dense blocks of 0.3 GB each


@dataclass(frozen=True)
class Layers:
    """Layers along y: the last about `last` of the pad's height thick, each one inwards thicker by `growth`,
    displacements of `order` in each."""

    last: float
    growth: float
    order: int


def coarse_sizes(pad: Pad, fineness: float) -> Sizes:
    """Return edge sizes for three dimensions: a few triangles a ridge, fast growth away from them."""
    height = height_of(pad)
    unit = min(unit_of(pad), height) if pad.focus else unit_of(pad)  # of a face as wide as the pad
    return Sizes(
        contact=unit / 2 / fineness,
        ridge=unit / fineness,
        bulk=height / 2 / fineness,
        corner=height / 4 / fineness**4,
        slot=0.3 * unit / fineness,
        grading=0.9 / fineness,
        focus=pad.focus,
        fine=pad.focus / FOCUS_EDGES / fineness,
    )


def forms_of(meshed: PadPiece, order: int) -> prisms.SectionForms:
    """Return the section's integrals at an order."""
    return prisms.section_forms(elements.curved(meshed.mesh, order), order, meshed.pad.materials)


def solve_level(
    meshed: PadPiece,
    forms: prisms.SectionForms,
    along: Layers | None,
    force: float,
    seconds: dict[str, float],
    *,
    crest_offsets: tuple[float, ...] = (),
    clamped_end: bool = False,
) -> LevelAnswer:
    """Solve at `force` N on the whole pad; without layers in plane strain, on the same section mesh.

    Crests lower than the section's by `crest_offsets` mm need the whole pad's mesh.
    """
    small, scale = condensed_pad(meshed, forms, along, seconds, clamped_end=clamped_end)
    with one_blas_thread(), Stopwatch(stages=seconds).stage("contact"):
        ridges = seen_by_plate(meshed.whole, small.seen, small.flexibility, meshed.unit, crest_offsets)
        return frictionless_level(meshed, ridges, force, scale, small.unknowns, small.rigid_body_error)


def condensed_pad(
    meshed: PadPiece,
    forms: prisms.SectionForms,
    along: Layers | None,
    seconds: dict[str, float],
    *,
    clamped_end: bool = False,
    in_plane: bool = False,
) -> tuple[prisms.Solid, float]:
    """Return the condensed piece, for many forces, and the force on the whole pad, N, per unit on it; with
    `in_plane` condensed to movements along x and y too."""
    half = meshed.whole.length / 2 / meshed.unit
    line = prisms.constant() if along is None else layers_of(meshed, along)
    check_size(forms, line, 3 if in_plane else 1)
    with one_blas_thread(), Stopwatch(stages=seconds).stage("condense"):
        small = prisms.condensed(forms, line, plane=along is None, clamped_end=clamped_end, in_plane=in_plane)
    check_balance(small.rigid_body_error)
    length = 2 * half if along is None else 2.0
    return small, meshed.whole.young_modulus * meshed.unit**2 * length * meshed.sides


def layers_of(meshed: PadPiece, along: Layers) -> prisms.AlongY:
    """Return the functions along y of these prisms, on half of the pad's length."""
    return prisms.line(borders_of(meshed, along), along.order, bend=bend_of(meshed))


def borders_of(meshed: PadPiece, along: Layers) -> Array:
    """Return the layers' borders `(layers + 1,)` on half of the pad's length, in units; alike on a pad whose
    contact ends somewhere along y."""
    growth = along.growth if meshed.whole.bend is None else 1.0
    return prisms.graded(
        meshed.whole.length / 2 / meshed.unit, along.last * height_of(meshed.whole) / meshed.unit, growth
    )


def bend_of(meshed: PadPiece) -> Bend | None:
    """Return the pad's bend in the piece's units."""
    return None if meshed.whole.bend is None else meshed.whole.bend.over(meshed.unit)


def check_size(forms: prisms.SectionForms, line: prisms.AlongY, directions: int = 1) -> None:
    """Raise SizeError for more unknowns than fit, before any is solved."""
    unknowns = 3 * forms.clamped.size * line.at.size
    contact = directions * forms.plane.contact.size * line.at.size
    if unknowns > MOST_UNKNOWNS or contact > MOST_CONTACT:
        rule = f"three dimensions take at most {MOST_UNKNOWNS} unknowns and {MOST_CONTACT} in contact"
        remedy = "take fewer ridges, a shorter skin or the linear model"
        raise SizeError("ridge.count", rule, max(unknowns, contact), remedy)


DEFAULT_TOLERANCE = 1e-2  # relative; finite strain changes more (docs/evidence/facts.md)
# What is left after order 3, of the difference to order 2; measured 0.15 to 0.45 on five pads (test_solid.py)
SECTION_TAIL = 0.6
LAYERS_TAIL = 1.0  # what is left after the finer layers, against their difference to the coarser


# A section mesh, fineness 1 the coarsest, and by fineness the layers on it and the finer ones
REFINEMENTS = MeshRefinement(1.0, 3), MeshRefinement(1.5, 3, 5.0)
LAYERS = {
    1.0: (Layers(0.6, 2.0, 4), Layers(0.3, 1.8, 4)),
    1.5: (Layers(0.3, 1.8, 4), Layers(0.15, 1.8, 4)),
}


def answer(design: Design, request: Request, progress: Progress | None = None) -> Answer:
    """Return the solid model's verdict on a design."""
    return solve(focused(solid_pad_of(design), request.force), request, progress)


def solve(pad: Pad, request: Request, progress: Progress | None = None) -> Answer:
    """Return touching ridges, all-touch force, approach and shares of a pad of finite length, with errors.

    The errors are those of discretisation alone: strains are taken as small. A budget ends the
    refinement; the coarsest mesh is always solved.
    """
    check_pad(pad)
    force, budget = request.force, request.budget
    wanted = request.tol or (DEFAULT_TOLERANCE if budget is None else 0.0)
    seconds: dict[str, float] = {}
    reached: Refinement[MeshRefinement, Answer, Answer] = refine(
        lambda refinement, _: _refine(pad, refinement, force, seconds, progress),
        REFINEMENTS,
        lambda _, answer, __: (answer, relative_error(answer, force, unit_of(pad))),
        wanted,
        budget,
        began=perf_counter(),
        ends=(SizeError,),
        price=by_price,
    )
    warnings = shortfalls(reached.error, wanted, "", reached.spent, budget, "solid")
    return replace(reached.assessment, warnings=warnings, seconds=seconds)


def _refine(
    pad: Pad, refinement: MeshRefinement, force: float, seconds: dict[str, float], progress: Progress | None
) -> Answer:
    if progress:
        progress(f"solid model: fineness {refinement.fineness:g}, order {refinement.order}")
    watch = Stopwatch(stages=seconds)
    with watch.stage("mesh"):
        meshed = meshed_piece(pad, coarse_sizes(pad, refinement.fineness))
    with watch.stage("assemble"):
        lower_forms, forms = (forms_of(meshed, order) for order in (refinement.order - 1, refinement.order))
    layers, finer_layers = LAYERS[refinement.fineness]
    for section, line in ((lower_forms, finer_layers), (forms, layers)):
        check_size(section, layers_of(meshed, line))  # of all that the refinement solves, before the first
    lower = solve_level(meshed, lower_forms, layers, force, seconds)
    finer = solve_level(meshed, lower_forms, finer_layers, force, seconds)
    best = solve_level(meshed, forms, layers, force, seconds)
    return estimated_answer(best, lower, finer)


def estimated_answer(best: LevelAnswer, lower: LevelAnswer, finer: LevelAnswer) -> Answer:
    """Values of the best level and what finer layers change; errors from the order and from the layers.

    All ridges share the largest error among them: a single difference may vanish by chance.
    """

    def value(of: Callable[[LevelAnswer], Array]) -> Array:
        return of(best) + of(finer) - of(lower)

    def error(of: Callable[[LevelAnswer], Array]) -> float:
        section = float(np.abs(of(best) - of(lower)).max())
        return SECTION_TAIL * section + LAYERS_TAIL * float(np.abs(of(finer) - of(lower)).max())

    def estimate(of: Callable[[LevelAnswer], Array], unit: str) -> Estimate:
        return Estimate(float(value(of)[0]), error(of), unit)

    threshold = Estimate(None, None, "N")
    if None not in [c.all_touch_force for c in (best, lower, finer)]:
        threshold = estimate(lambda c: np.array([c.all_touch_force], dtype=float), "N")
    shares, share_error = value(lambda c: c.ridge_force), error(lambda c: c.ridge_force)
    if (shares < 0).any():  # a ridge at the brink of touching
        shares = best.ridge_force
    return Answer(
        touching=int(np.count_nonzero(shares > 0)),
        all_touch_force=threshold,
        approach=estimate(lambda c: np.array([c.approach]), "mm"),
        ridge_force=tuple(Estimate(float(f), share_error, "N") for f in shares),
        unknowns=best.unknowns,
        residual=max(c.residual for c in (best, lower, finer)),
        seconds={},
    )
