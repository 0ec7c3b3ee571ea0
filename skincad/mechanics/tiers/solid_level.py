"""One level of the solid: a pad meshed in three dimensions (or, on the same mesh, plane), and pressed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np

from skincad.base.arrays import Array
from skincad.base.blas import one_blas_thread
from skincad.mechanics.bodies import elements, layers, prisms
from skincad.mechanics.bodies.mesh import Sizes, unit_of
from skincad.mechanics.bodies.meshed import PadMesh, height_of
from skincad.mechanics.contact.frictionless import NodalContact, press
from skincad.mechanics.contact.threshold import all_touch_force
from skincad.mechanics.contact.under_plate import seen_by_plate
from skincad.mechanics.problem import ContactError, Pad, SizeError

MOST_UNKNOWNS = 600_000  # about 6 GB of fronts
MOST_CONTACT = 6000  # dense blocks of 0.3 GB each
BALANCE = 1e-6  # relative; the clamped back must carry the force, or the factorisation is inaccurate


@dataclass(frozen=True)
class Layers:
    """Layers along y: the last about `last` of the pad's height thick, each one inwards thicker by `growth`,
    displacements of `order` in each."""

    last: float
    growth: float
    order: int


@dataclass(frozen=True)
class SolidSolution:
    """The verdict's numbers for the whole pad, mm and N; `ridge_force` is `(ridges,)`.

    `pressure` `(m,)` in MPa, `x` and `y` `(m,)` in mm are those of the piece that is meshed.
    """

    all_touch_force: float | None
    approach: float
    ridge_force: Array
    x: Array
    y: Array
    pressure: Array
    unknowns: int
    residual: float

    @property
    def touching(self) -> int:
        """Number of ridges that carry force somewhere along y."""
        return int(np.count_nonzero(self.ridge_force > 0))


def coarse_sizes(pad: Pad, fineness: float) -> Sizes:
    """Return edge sizes for three dimensions: a few triangles a ridge, fast growth away from them."""
    unit = unit_of(pad)
    height = height_of(pad)
    return Sizes(
        contact=unit / 2 / fineness,
        ridge=unit / fineness,
        bulk=height / 2 / fineness,
        corner=height / 4 / fineness**4,
        slot=0.3 * unit / fineness,
        grading=0.9 / fineness,
    )


def forms_of(meshed: PadMesh, order: int) -> prisms.SectionForms:
    """Return the section's integrals at an order."""
    return prisms.section_forms(elements.curved(meshed.mesh, order), order, meshed.piece.materials)


def solve_level(
    meshed: PadMesh,
    forms: prisms.SectionForms,
    along: Layers | None,
    force: float,
    seconds: dict[str, float],
    *,
    crest_offsets: tuple[float, ...] = (),
    clamped_end: bool = False,
) -> SolidSolution:
    """Solve at `force` N on the whole pad; without layers in plane strain, on the same section mesh.

    Crests lower than the section's by `crest_offsets` mm need the whole pad's mesh.
    """
    small, scale = condensed_pad(meshed, forms, along, seconds, clamped_end=clamped_end)
    with one_blas_thread():
        solution: SolidSolution = timed(
            seconds, "contact", lambda: _level(meshed, small, force, scale, crest_offsets)
        )
    return solution


def condensed_pad(
    meshed: PadMesh,
    forms: prisms.SectionForms,
    along: Layers | None,
    seconds: dict[str, float],
    *,
    clamped_end: bool = False,
) -> tuple[prisms.Solid, float]:
    """Return the condensed piece, for many forces, and the force on the whole pad, N, per unit on it."""
    half = meshed.whole.length / 2 / meshed.unit
    line = layers.constant() if along is None else layers_of(meshed, along)
    check_size(forms, line)
    with one_blas_thread():
        small: prisms.Solid = timed(
            seconds,
            "condense",
            lambda: prisms.condensed(forms, line, plane=along is None, clamped_end=clamped_end),
        )
    if not small.rigid_body_error <= BALANCE:
        raise ContactError(
            f"the clamped back carries the force to {small.rigid_body_error:.1e} only; "
            "take a smaller poisson_ratio"
        )
    length = 2 * half if along is None else 2.0
    return small, meshed.whole.young_modulus * meshed.unit**2 * length * meshed.sides


def _level(
    meshed: PadMesh, small: prisms.Solid, force: float, scale: float, crest_offsets: tuple[float, ...]
) -> SolidSolution:
    """Contact at `force` N; `scale` N on the whole pad is a force of 1 on the piece, in its units."""
    unit = meshed.unit
    ridges = seen_by_plate(meshed.whole, small.seen, small.flexibility, unit)
    if crest_offsets:
        ridges = ridges.lowered(np.array(crest_offsets) / unit)
    state = press(ridges.flexibility, ridges.gap, force / scale)
    threshold = all_touch_force(ridges, force / scale)
    residual = max(state.residual, small.rigid_body_error)
    return level_of(
        meshed,
        small.seen.nodes,
        small.along,
        state,
        state.approach,
        threshold,
        scale,
        small.unknowns,
        residual,
    )


def level_of(
    meshed: PadMesh,
    nodes: elements.Sample,
    along: Array,
    state: NodalContact,
    approach: float,
    threshold: float | None,
    scale: float,
    unknowns: int,
    residual: float,
) -> SolidSolution:
    """Return the solution in mm and N from the piece's units, for contact `nodes` at y = `along`."""
    unit = meshed.unit
    shares = np.array([state.force[nodes.ridge == r].sum() for r in np.unique(nodes.ridge)]) * scale
    return SolidSolution(
        None if threshold is None else threshold * scale,
        approach * unit,
        meshed.on_whole(shares),
        nodes.position[:, 0] * unit,
        along * unit,
        state.force / nodes.weight * meshed.whole.young_modulus,
        unknowns,
        residual,
    )


def layers_of(meshed: PadMesh, along: Layers) -> layers.AlongY:
    """Return the functions along y of these layers, on half of the pad's length."""
    half = meshed.whole.length / 2 / meshed.unit
    return layers.line(
        layers.graded(half, along.last * meshed.height / meshed.unit, along.growth), along.order
    )


def check_size(forms: prisms.SectionForms, line: layers.AlongY) -> None:
    """Raise SizeError for more unknowns than fit, before any is solved."""
    unknowns, contact = 3 * forms.held.size * line.at.size, forms.plane.contact.size * line.at.size
    if unknowns > MOST_UNKNOWNS or contact > MOST_CONTACT:
        raise SizeError(
            "ridge.count",
            f"three dimensions take at most {MOST_UNKNOWNS} unknowns and {MOST_CONTACT} in contact",
            max(unknowns, contact),
            "take fewer ridges, a shorter skin or the linear tier",
        )


def timed(seconds: dict[str, float], stage: str, work: Callable[[], Any]) -> Any:
    """Return what `work` returns, its time added to the stage's."""
    started = perf_counter()
    result = work()
    seconds[stage] = seconds.get(stage, 0.0) + perf_counter() - started
    return result
