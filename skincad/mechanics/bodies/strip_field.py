"""Stress in the elements: averages over the film's strips, and the field to draw; names ngsolve.

A body is assembled once and solved under either mirror condition on a cut at x = 0: what the condition
holds are unknowns left out of the factorisation, as those of the clamped back are. Lengths are in the
pad's unit, stresses in E.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import ngsolve as ng
import numpy as np

from skincad.base.arrays import Array, Index, Mask
from skincad.mechanics.bodies import elements, fe
from skincad.mechanics.bodies.elements import ContactStiffness
from skincad.mechanics.problem import ContactError
from skincad.shape.feature import SensorPlace

PIECES = 2  # a triangle's edge is drawn in so many
AREA = 1e-9  # relative; the triangles of a strip make up its area


@dataclass(frozen=True)
class StripBody:
    """A meshed pad at one order; `held` gives the unknowns in x and in z that lie on x = 0.

    `along_x` numbers the contact unknowns in x in the order of `system.contact`, those in z.
    """

    system: ContactStiffness
    order: int
    form: Any
    stress: Any
    moved: Any
    along_x: Index
    held: tuple[Index, Index]


def body(mesh: Any, order: int, materials: Mapping[str, tuple[float, float]]) -> StripBody:
    """Return the body of a mesh; `materials` maps a domain to (Young's modulus, Poisson's ratio)."""
    form, both = elements.small_strain(mesh, order, materials)
    space = both.components[0]
    first = [space.Range(i).start for i in (0, 1)]
    system = elements.with_contact(fe.as_csr(form.mat), mesh, both, order)
    moved = ng.GridFunction(both)
    stress = _stress(mesh, materials, *moved.components)
    along_x = system.contact - first[1] + first[0]
    return StripBody(system, order, form, stress, moved, along_x, fe.held_on_cut(mesh, space))


def _stress(mesh: Any, materials: Mapping[str, tuple[float, float]], u: Any, q: Any) -> Any:
    """Stresses xx, xz, zz and yy of a state: 2 G dev(e) + q, q being the mean stress (elements.py)."""
    shear, _ = fe.moduli(mesh, materials)
    h = ng.Grad(u)
    mean = (h[0, 0] + h[1, 1]) / 3
    return ng.CF(
        (
            2 * shear * (h[0, 0] - mean) + q,
            shear * (h[0, 1] + h[1, 0]),
            2 * shear * (h[1, 1] - mean) + q,
            -2 * shear * mean + q,
        )
    )


def set_state(body: StripBody, condensed: Array) -> None:
    """Put displacements `(n,)` of the condensed unknowns into the body, what is inside the elements with
    them; `averages` and `field` then tell of this state."""
    whole = body.moved.vec
    whole.FV().NumPy()[:] = condensed
    whole.data += body.form.harmonic_extension * whole


def averages(body: StripBody, slots: Sequence[SensorPlace], thickness: float, unit: float) -> Array:
    """Return `(strips, 4)`: the state's stresses xx, xz, zz, yy averaged over each strip of domain `film`.

    `slots` are the strips' places, `thickness` theirs, both mm. Integrated exactly. Because a Galerkin
    solution satisfies a(u, v) = 0 for the v that is linear in a strip and dies out in the skin, this mean
    is the mean of n x over the strip's sides of what the skin exerts, and converges as fast as an energy.
    """
    mesh = body.system.mesh
    film = mesh.Materials("film")
    parts = (ng.CF(1.0), *(body.stress[i] for i in range(4)))
    sums = [
        ng.Integrate(part, mesh, order=body.order + 1, definedon=film, element_wise=True) for part in parts
    ]
    elements, strip = strips_of(mesh, slots, thickness, unit)
    inside = np.array(sums).T[elements]
    total = np.zeros((len(slots), 5))
    np.add.at(total, strip, inside)
    areas = np.array([slot.depth * thickness for slot in slots]) / unit**2
    if np.abs(total[:, 0] / areas - 1).max() > AREA:
        raise ContactError("the triangles of a strip do not make up its area")
    return np.asarray(total[:, 1:] / total[:, :1])


def average_rows(
    body: StripBody,
    materials: Mapping[str, tuple[float, float]],
    slots: Sequence[SensorPlace],
    thickness: float,
    unit: float,
) -> Array:
    """Return `(strips, 4, n)`: `averages` as linear functionals of the condensed unknowns.

    Each is assembled against the test functions and carried from inside the elements to their edges, so that
    one solve gives the stress under any load (its adjoint). The mesh must have the strips as domain `film`.
    """
    mesh, space = body.system.mesh, body.system.space
    elements, strip = strips_of(mesh, slots, thickness, unit)
    inside = ng.GridFunction(ng.L2(mesh, order=0))
    forms = []  # each takes one of the library's 8192 timers for good, so there is not one for each strip too
    stress = _stress(mesh, materials, *space.TestFunction())
    for j in range(4):
        forms.append(ng.LinearForm(space))
        forms[-1] += inside * stress[j] * ng.dx(definedon=mesh.Materials("film"))
    rows = np.empty((len(slots), 4, space.ndof))
    for i, slot in enumerate(slots):
        mark = np.zeros(mesh.ne)
        mark[elements[strip == i]] = 1.0
        inside.vec.FV().NumPy()[:] = mark
        share = unit**2 / (slot.depth * thickness)
        for j, form in enumerate(forms):
            form.Assemble()
            form.vec.data += body.form.harmonic_extension_trans * form.vec
            rows[i, j] = share * form.vec.FV().NumPy()
    return rows


def strips_of(mesh: Any, slots: Sequence[SensorPlace], thickness: float, unit: float) -> tuple[Index, Index]:
    """Return the elements of domain `film` and the number of the strip that each lies in, both `(e,)`."""
    inside = list(mesh.Materials("film").Elements())
    numbers = np.array([e.nr for e in inside], dtype=np.int64)
    return numbers, nearest(fe.centres(mesh, inside) * unit, slots, thickness)


def nearest(points: Array, slots: Sequence[SensorPlace], thickness: float) -> Index:
    """Number of the strip that each point, mm, lies in."""
    centre = np.array([s.centre for s in slots])
    along, normal = np.array([s.direction for s in slots]), np.array([s.across for s in slots])
    away = points[:, None] - centre
    depth = np.array([s.depth for s in slots])
    parts = np.abs((away * along).sum(2)) / depth, np.abs((away * normal).sum(2)) / thickness
    return np.asarray(np.maximum(*parts).argmin(axis=1))


@dataclass(frozen=True)
class Patch:
    """A piece of the mesh to draw: `place`, `shift` `(p, 2)`, `stress` `(p, 4)` at its points,
    `triangles` `(t, 3)` of them, `film` `(t,)` those of the film."""

    place: Array
    shift: Array
    stress: Array
    triangles: Index
    film: Mask


def field(body: StripBody, centre: tuple[float, float], reach: float, cuts: int = PIECES) -> Patch:
    """Return the state within `reach` of `centre`, in units; a triangle's edge is drawn in so many `cuts`."""
    mesh = body.system.mesh
    lattice = [(i, j) for j in range(cuts + 1) for i in range(cuts + 1 - j)]
    number = {at: k for k, at in enumerate(lattice)}
    pieces = [[number[i, j], number[i + 1, j], number[i, j + 1]] for i, j in lattice if i + j < cuts]
    pieces += [
        [number[i + 1, j], number[i + 1, j + 1], number[i, j + 1]] for i, j in lattice if i + j < cuts - 1
    ]
    rule = ng.IntegrationRule([(i / cuts, j / cuts) for i, j in lattice], [0.0] * len(lattice))
    points = mesh.MapToAllElements(rule, ng.VOL)
    values = ng.CF((ng.x, ng.y, *body.moved.components[0], *body.stress))(points)
    values = np.asarray(values).reshape(mesh.ne, len(lattice), 8)
    near = np.flatnonzero(np.hypot(*(values[:, :, :2].mean(axis=1) - centre).T) < reach)
    film = np.array([e.mat == "film" for e in mesh.Elements(ng.VOL)])[near]
    flat = values[near].reshape(-1, 8)
    triangles = (np.arange(near.size)[:, None, None] * len(lattice) + np.array(pieces)).reshape(-1, 3)
    return Patch(flat[:, :2], flat[:, 2:4], flat[:, 4:], triangles, np.repeat(film, len(pieces)))
