"""One level of the plane: a mesh at one order, small strain, exact contact."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from skincad.base.arrays import Array
from skincad.base.blas import one_blas_thread
from skincad.mechanics.bodies import elements
from skincad.mechanics.bodies.chain import ChainFactors, chained
from skincad.mechanics.bodies.folding import fault
from skincad.mechanics.bodies.meshed import PadMesh
from skincad.mechanics.contact.frictionless import NodalContact, press
from skincad.mechanics.contact.threshold import Ridges, all_touch_force
from skincad.mechanics.contact.under_plate import height_above, seen_by_plate
from skincad.mechanics.problem import ContactError, SizeError

# At order 3 about 90 kB each, all in all (101 ridges of plain-ridges, slabs of five): 5 GB
MOST_CONTACT_UNKNOWNS = 60_000
BALANCE = 1e-6  # relative; the clamped back must carry the force, or the factorisation is inaccurate


@dataclass(frozen=True)
class PlaneSolution:
    """The solution on one mesh at one order: the verdict's numbers for the whole pad, mm and N, and the
    state.

    `ridge_force` is `(ridges,)`. Of the meshed piece are: `x`, `pressure` `(m,)`, its contact points
    in mm and MPa, `unknowns`, `ridges`, and of a mirrored half `half`, its stiffness for loads of either
    parity.
    """

    all_touch_force: float | None
    approach: float
    ridge_force: Array
    touching: int
    x: Array
    pressure: Array
    unknowns: int
    residual: float
    seconds: dict[str, float]
    ridges: Ridges
    unit: float  # of the piece, mm
    scale: float  # N on the whole pad for a force of 1 on the piece, in its units
    fault: str = ""  # undetected contact of the skin with itself or the plate
    half: elements.ContactStiffness | None = None
    outlines: tuple[elements.Outline, ...] = ()  # of the piece, at rest and under the force, in units


LevelSolver = Callable[[PadMesh, int, float, tuple[float, ...]], PlaneSolution]


def level(meshed: PadMesh, order: int, force: float, crest_offsets: tuple[float, ...] = ()) -> PlaneSolution:
    """Solve one order at `force` N on the pad, crests lower than the section's by `crest_offsets` mm. Those
    need a mesh of the whole pad."""
    with one_blas_thread():
        return _level(meshed, order, force, crest_offsets)


def scale_of(meshed: PadMesh) -> float:
    """Return the force on the whole pad, N, for a force of 1 on the piece, in its units."""
    return meshed.whole.young_modulus * meshed.unit * meshed.whole.length * meshed.sides


def contact_unknowns(meshed: PadMesh, order: int) -> int:
    """Return how many contact unknowns the whole pad has at this order: the yield asks for all of them."""
    return elements.contact_unknowns(elements.curved(meshed.mesh, 1), order) * meshed.sides


def _level(meshed: PadMesh, order: int, force: float, crest_offsets: tuple[float, ...]) -> PlaneSolution:
    pad, unit, scale = meshed.whole, meshed.unit, scale_of(meshed)
    clock = [perf_counter()]
    curved = elements.curved(meshed.mesh, order)
    contact = contact_unknowns(meshed, order)
    if contact > MOST_CONTACT_UNKNOWNS:
        raise too_large(contact, MOST_CONTACT_UNKNOWNS, "linear")
    assembled = elements.assemble(curved, order, pad.materials)
    system = elements.even(assembled)
    clock.append(perf_counter())
    small = chained(system)
    clock.append(perf_counter())
    ridges = seen_by_plate(pad, system, small.flexibility, unit)
    if crest_offsets:
        ridges = ridges.lowered(np.array(crest_offsets) / unit)
    state = press(ridges.flexibility, ridges.gap, force / scale)
    threshold = all_touch_force(ridges, force / scale)
    moved = _moved(system, small, state)
    residual = max(state.residual, _balance(system, moved, force / scale))
    plate = height_above(pad, ridges, system, state.approach, unit)
    outlines = elements.outlines(system, moved)
    wrong = fault(outlines, plate, mirrored=meshed.mirrored)
    clock.append(perf_counter())
    shares = np.array([state.force[ridges.of_point == r].sum() for r in ridges.numbers]) * scale
    return PlaneSolution(
        None if threshold is None else threshold * scale,
        state.approach * unit,
        meshed.on_whole(shares),
        int(np.count_nonzero(meshed.on_whole(shares) > 0)),
        system.nodes.position[:, 0] * unit,
        state.force / system.nodes.weight * pad.young_modulus,
        system.unknowns,
        residual,
        dict(zip(("assemble", "condense", "contact"), np.diff(clock).tolist(), strict=True)),
        ridges,
        unit,
        scale,
        wrong or "",
        assembled if meshed.mirrored else None,
        tuple(outlines),
    )


def too_large(contact: int, most: int, tier: str) -> SizeError:
    """Return a tier's refusal of a pad with so many contact unknowns, more than `most`."""
    return SizeError(
        "ridge.count",
        f"the {tier} tier takes at most {most} contact unknowns",
        contact,
        "take fewer ridges or the winkler tier",
    )


def _moved(system: elements.ContactStiffness, small: ChainFactors, state: NodalContact) -> Array:
    """Displacements `(n,)` under the contact forces."""
    load = np.zeros(system.lift.size)
    load[system.contact] = -(system.nodes.rows.T @ state.force)
    return small.solve(load)


def _balance(system: elements.ContactStiffness, moved: Array, force: float) -> float:
    """Relative difference between the plate's force and what the clamped back carries."""
    clamped = system.lift.copy()
    clamped[system.interior] = clamped[system.contact] = 0.0
    carried = float(clamped @ (system.matrix @ moved))
    balance = abs(carried / force - 1)
    if not balance <= BALANCE:
        raise ContactError(
            f"the clamped back carries {carried / force:.6f} of the force; take a smaller poisson_ratio"
        )
    return balance
