"""Stress in the film strips: of a linear state, and of a pad at finite strain; names ngsolve.

A linear body is assembled once and solved under either mirror condition on a cut at x = 0: what the condition
holds are unknowns left out of the factorisation, as those of the clamped back are.

At finite strain it is Cauchy stress, N per present area, resolved where it is on the strip as it now lies:
across is normal to the material planes that were parallel to its faces, along is the material line along it.
What a strip bears does not change when it turns with its ridge. Averaged over the present volume. Lengths are
in the pad's unit, stresses in E.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import ngsolve as ng
import numpy as np
from scipy import sparse

from skincad.base.arrays import Array, Index, Mask
from skincad.mechanics.bodies import elements, fe
from skincad.mechanics.bodies.elements import ContactStiffness
from skincad.mechanics.bodies.mesh import PadPiece
from skincad.mechanics.bodies.plane_body import NeoHookeBody, dilatation, excess
from skincad.mechanics.problem import ContactError

AREA = 1e-9  # relative; the triangles of a strip make up its area


@dataclass(frozen=True)
class StripBody:
    """A meshed pad at one order; `on_cut` gives the unknowns in x and in z that lie on x = 0.

    `along_x` numbers the contact unknowns in x in the order of `system.contact`, those in z. `points`
    `(2 m, n)` gives displacements of the contact points, in x, then in z, by the unknowns.
    """

    system: ContactStiffness
    order: int
    form: Any
    stress: Any
    moved: Any
    along_x: Index
    on_cut: tuple[Index, Index]
    points: sparse.csr_matrix

    @property
    def contact(self) -> Index:
        """The contact unknowns, in x, then in z."""
        return np.concatenate([self.along_x, self.system.contact])


def body(
    mesh: Any, order: int, materials: Mapping[str, tuple[float, float]], revolved: bool = False
) -> StripBody:
    """Return the body of a mesh; `materials` maps a domain to (Young's modulus, Poisson's ratio). One that is
    `revolved` has no strips."""
    form, both = elements.small_strain(mesh, order, materials, revolved=revolved)
    space = both.components[0]
    first = [space.Range(i).start for i in (0, 1)]
    system = elements.with_contact(fe.as_csr(form.mat), mesh, both, order, revolved)
    moved = ng.GridFunction(both)
    stress = _stress(mesh, materials, *moved.components)
    along_x = system.contact - first[1] + first[0]
    rows = sparse.coo_matrix(sparse.block_diag([system.nodes.rows, system.nodes.rows]))
    column = np.concatenate([along_x, system.contact])[rows.col]
    shape = rows.shape[0], system.lift.size
    return StripBody(
        system=system,
        order=order,
        form=form,
        stress=stress,
        moved=moved,
        along_x=along_x,
        on_cut=fe.held_on_cut(mesh, space),
        points=sparse.csr_matrix((rows.data, (rows.row, column)), shape),
    )


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


def averages(body: StripBody, piece: PadPiece) -> Array:
    """Return `(strips, 4)`: the state's stresses xx, xz, zz, yy averaged over each strip of domain `film`.

    Integrated exactly. Because a Galerkin solution satisfies a(u, v) = 0 for the v that is linear in a strip
    and dies out in the skin, this mean is the mean of n x over the strip's sides of what the skin exerts, and
    converges as fast as an energy.
    """
    mesh = body.system.mesh
    parts = (ng.CF(1.0), *(body.stress[i] for i in range(4)))
    total = _sums(mesh, parts, body.order + 1, *strips_of(mesh, piece))
    if np.abs(total[:, 0] / strip_areas(piece) - 1).max() > AREA:
        raise ContactError("the triangles of a strip do not make up its area")
    return np.asarray(total[:, 1:] / total[:, :1])


def _sums(mesh: Any, parts: Sequence[Any], order: int, elements: Index, strip: Index) -> Array:
    """Integrals `(strips, parts)` over each strip, of whose elements `(e,)` the `strip` is known."""
    film = mesh.Materials("film")
    sums = [ng.Integrate(part, mesh, order=order, definedon=film, element_wise=True) for part in parts]
    total = np.zeros((strip.max(initial=-1) + 1, len(parts)))
    np.add.at(total, strip, np.array(sums).T[elements])
    return total


def average_rows(body: StripBody, piece: PadPiece) -> Array:
    """Return `(strips, 4, n)`: `averages` as linear functionals of the condensed unknowns.

    Each is assembled against the test functions and carried from inside the elements to their edges, so that
    one solve gives the stress under any load (its adjoint). The mesh must have the strips as domain `film`.
    """
    mesh, space = body.system.mesh, body.system.space
    elements, strip = strips_of(mesh, piece)
    inside = ng.GridFunction(ng.L2(mesh, order=0))
    forms = []  # each takes one of the library's 8192 timers for good, so there is not one for each strip too
    stress = _stress(mesh, piece.pad.materials, *space.TestFunction())
    for j in range(4):
        forms.append(ng.LinearForm(space))
        forms[-1] += inside * stress[j] * ng.dx(definedon=mesh.Materials("film"))
    rows = np.empty((len(piece.slots), 4, space.ndof))
    for i, slot in enumerate(piece.slots):
        mark = np.zeros(mesh.ne)
        mark[elements[strip == i]] = 1.0
        inside.vec.FV().NumPy()[:] = mark
        share = piece.unit**2 / (slot.depth * piece.thickness)
        for j, form in enumerate(forms):
            form.Assemble()
            form.vec.data += body.form.harmonic_extension_trans * form.vec
            rows[i, j] = share * form.vec.FV().NumPy()
    return rows


def strip_areas(piece: PadPiece) -> Array:
    """Return the areas of a piece's strips `(strips,)`, in units."""
    return np.array([slot.depth * piece.thickness for slot in piece.slots]) / piece.unit**2


def strips_of(mesh: Any, piece: PadPiece) -> tuple[Index, Index]:
    """Return the elements of domain `film` and the number of the strip that each lies in, both `(e,)`."""
    slots = piece.slots
    inside = list(mesh.Materials("film").Elements())
    numbers = np.array([e.nr for e in inside], dtype=np.int64)
    away = (fe.centres(mesh, inside) * piece.unit)[:, None] - np.array([s.centre for s in slots])
    along, normal = np.array([s.direction for s in slots]), np.array([s.normal for s in slots])
    depth = np.array([s.depth for s in slots])
    parts = np.abs((away * along).sum(2)) / depth, np.abs((away * normal).sum(2)) / piece.thickness
    return numbers, np.maximum(*parts).argmin(axis=1)


@dataclass(frozen=True, eq=False)
class Patch:
    """A piece of the mesh to draw: `place`, `shift` `(p, 2)`, `stress` `(p, 4)`, xx, xz, zz and yy, at its
    points, `triangles` `(t, 3)` of them, `film` `(t,)` those of the film."""

    place: Array
    shift: Array
    stress: Array
    triangles: Index
    film: Mask


def field(body: StripBody, centre: Array, reach: float, cuts: int) -> Patch:
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


EXTRA = 2  # of the integration's order beyond twice the displacements': the integrand is no polynomial


@dataclass(frozen=True, eq=False)
class StripStress:
    """The stresses of a body's strips; `moved` is set to the state that is asked.

    `parts` are the present volume and, times it, the stresses; `elements` `(e,)` lie in strips `strip`.
    `slopes` are the parts' derivatives along a movement, `strip_of` `(n,)` the strip of each unknown, -1
    outside.
    """

    moved: Any
    parts: tuple[Any, ...]
    slopes: tuple[Any, ...]
    elements: Index
    strip: Index
    strip_of: Index
    order: int

    def at(self, values: Array) -> Array:
        """Return `(strips, 3)`: across, along and lengthwise in a state `(n,)`, means over each strip."""
        total = self._totals(values)
        return np.asarray(total[:, 1:] / total[:, :1])

    def gradient(self, body: NeoHookeBody, values: Array) -> Array:
        """Return the derivative `(3 strips, n)` of `at` in a state by all condensed unknowns, what is inside
        the elements carried to their edges by the body's latest tangent."""
        total = self._totals(values)
        inside = np.flatnonzero(self.strip_of >= 0)
        strip = self.strip_of[inside]  # strips share no unknown
        size, *sums = total[strip].T
        whole = body.form.mat.CreateColVector()
        load = whole.FV().NumPy()
        for slope in self.slopes:
            slope.Assemble()
        volume, *parts = (slope.vec.FV().NumPy()[inside] for slope in self.slopes)
        rows = np.zeros((len(total), len(parts), values.size))
        for j, part in enumerate(parts):
            load[:] = 0.0
            load[inside] = (part - volume * (sums[j] / size)) / size
            whole.data += body.form.harmonic_extension_trans * whole
            rows[strip, j, inside] = load[inside]
        return rows.reshape(-1, values.size)

    def _totals(self, values: Array) -> Array:
        """Each strip's present volume and, times it, its stresses `(strips, 4)`."""
        self.moved.vec.FV().NumPy()[:] = values
        return _sums(self.moved.space.mesh, self.parts, self.order, self.elements, self.strip)


def strip_stress(body: NeoHookeBody, order: int, piece: PadPiece) -> StripStress:
    """Return the stresses of a piece's strips; the mesh has them as domain `film`.

    sigma = G / J (F F^T - 1) + (q - 2 G / 3 (J - 1)) 1: neo_hooke.strain_energy's own, with lambda (J - 1)
    lengthwise, where plane strain has a stretch of 1. Another law adds P F^T / J of what its energy has
    more (plane_body.py), and nothing lengthwise: there each power of the stretch, 1, balances ln J.
    """
    mesh, pad = body.mesh, piece.pad
    elements, strip = strips_of(mesh, piece)
    moved = ng.GridFunction(body.space)
    u, q = moved.components[0], moved.components[1].MakeVariable()
    shear, _ = fe.shear_and_bulk(*pad.materials["film"])
    h = ng.Grad(u).MakeVariable()  # by which a law is derived, and the stress itself
    swell = dilatation(h)
    stretch, mean = ng.Id(2) + h, q - 2 * shear / 3 * swell
    # J sigma, so that sums are over the present volume
    stress = shear * (stretch * stretch.trans - ng.Id(2)) + (1 + swell) * mean * ng.Id(2)
    if "film" in pad.laws:
        stress += shear * (excess(pad.laws["film"], h).Diff(h) * stretch.trans)
    along = stretch * _directions(mesh, elements, np.array([s.direction for s in piece.slots])[strip])
    normal = ng.CF((-along[1], along[0]))  # Nanson's, of the faces that the strip's direction lies in
    parts = (
        1 + swell,
        *((direction * (stress * direction)) / (direction * direction) for direction in (normal, along)),
        (1 + swell) * mean,
    )
    compiled = tuple(part.Compile() for part in parts)  # a fifth of the time
    degree = 2 * order + EXTRA
    slopes = tuple(_slope(body.space, part, (h, q), degree - order) for part in parts)
    of = np.full(body.space.ndof, -1, dtype=np.int64)
    for element, number in zip(elements.tolist(), strip.tolist(), strict=True):
        of[list(body.space.GetDofNrs(ng.ElementId(ng.VOL, element)))] = number
    return StripStress(
        moved=moved, parts=compiled, slopes=slopes, elements=elements, strip=strip, strip_of=of, order=degree
    )


def _slope(space: Any, part: Any, by: tuple[Any, Any], extra: int) -> Any:
    """Return the form, to be assembled in each state, of a part's derivative `by` gradient and pressure."""
    v, p = space.TestFunction()
    form = ng.LinearForm(space)
    slope = part.Diff(by[0], ng.Grad(v)) + part.Diff(by[1], p)
    form += slope.Compile() * ng.dx("film", bonus_intorder=extra)
    return form


def _directions(mesh: Any, elements: Index, direction: Array) -> Any:
    """Return a vector that is constant on each of the elements, `(e, 2)`, zero elsewhere."""
    constant, on_all = ng.GridFunction(ng.VectorL2(mesh, order=0)), np.zeros((2, mesh.ne))
    on_all[:, elements] = direction.T
    constant.vec.FV().NumPy()[:] = on_all.ravel()
    return constant
