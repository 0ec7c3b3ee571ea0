"""Elements of a pad's section, in plane strain or turned about x = 0: stiffness, contact rows, and functions
at points.

Displacements of order k with bubbles of order k + 1 inside the triangles, discontinuous pressure of
order k - 1; pressure and inner unknowns are condensed element by element, so the matrix is symmetric
positive definite and does not lock for nu near 0.5. Lengths are in the pad's unit, stresses in E.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import ngsolve as ng
import numpy as np
from numpy.polynomial import legendre
from scipy import sparse

from skincad.base.arrays import Array, Index
from skincad.mechanics.bodies import fe
from skincad.mechanics.problem import DeformedLoop

FINE = 16  # intervals an edge in the fine sampling of gaps
EDGE_POINTS = np.linspace(0.0, 1.0, 9)  # of the deformed outline, on each edge


@dataclass(frozen=True)
class Sample:
    """Points of the contact boundary and how the contact unknowns move them.

    `rows` is `(points, contact unknowns)`: upward displacement; `position` is `(points, 2)`, `ridge` and
    `weight` (arc length that a point stands for, or what it sweeps in a turn) are `(points,)`, `edge` numbers
    the point's edge.
    """

    rows: sparse.csr_matrix
    position: Array
    ridge: Index
    weight: Array
    edge: Index


@dataclass(frozen=True)
class ContactStiffness:
    """A condensed stiffness with its contact unknowns and the sampled contact boundary.

    `matrix` is `(n, n)` over all unknowns, force per length along y, or of the whole turn; `interior` and
    `contact` number the free unknowns, the contact ones (vertical, on the contact boundary) apart, those on a
    half's cut among them (see `symmetric_system`); `lift` `(n,)` is the vertical rigid translation by 1.
    `nodes` are Gauss-Lobatto points, `fine` a dense even sampling; `mesh` and `space` (displacements times
    pressures) are what was assembled.
    """

    matrix: sparse.csr_matrix
    interior: Index
    contact: Index
    lift: Array
    nodes: Sample
    fine: Sample
    mesh: Any
    space: Any

    @property
    def unknowns(self) -> int:
        """Number of free unknowns after element condensation."""
        return self.interior.size + self.contact.size


def curved(triangles: Any, order: int) -> Any:
    """Return the NGSolve mesh of netgen's triangles, its arcs followed to `order`."""
    mesh = ng.Mesh(triangles)
    mesh.Curve(max(3, order))
    return mesh


def contact_unknowns(mesh: Any, order: int) -> int:
    """Return how many contact unknowns the mesh will have at this order, the ridges' ends apart."""
    return order * len([e for e in mesh.Elements(ng.BND) if e.mat.startswith("contact")])


def assemble(
    mesh: Any, order: int, materials: Mapping[str, tuple[float, float]], revolved: bool = False
) -> ContactStiffness:
    """Return the condensed small-strain stiffness, see `small_strain`."""
    form, both = small_strain(mesh, order, materials, revolved=revolved)
    return with_contact(fe.as_csr(form.mat), mesh, both, order, revolved)


def mixed_space(mesh: Any, order: int) -> Any:
    """Return the product of the displacements' space, clamped at the back, and the pressures'."""
    space = ng.VectorH1(mesh, order=order, orderinner=order + 1, dirichlet="back")
    return space * ng.L2(mesh, order=order - 1)


def small_strain(
    mesh: Any,
    order: int,
    materials: Mapping[str, tuple[float, float]],
    condense: bool = True,
    revolved: bool = False,
) -> tuple[Any, Any]:
    """Return NGSolve's assembled form of small strain and its space, in plane strain or of a section that is
    `revolved` about x = 0; to `condense` is to eliminate what is inside the elements.

    `materials` maps a domain to (Young's modulus, Poisson's ratio), the ratio from 0 to below 0.5. The
    split is 2 G dev(e):dev(e) plus a pressure q with q = K div u, which holds at nu = 0 as well (the
    usual Lame form divides by zero there). Bathe, Finite Element Procedures, 1996, sec. 4.4.3.
    """
    both = mixed_space(mesh, order)
    (u, q), (v, r) = both.TnT()
    shear, bulk = fe.moduli(mesh, materials)
    strain, test = ng.Sym(ng.Grad(u)), ng.Sym(ng.Grad(v))
    swell, swelling, inner = ng.div(u), ng.div(v), ng.InnerProduct(strain, test)
    if revolved:
        hoop, hoops = u[0] / ng.x, v[0] / ng.x
        swell, swelling, inner = swell + hoop, swelling + hoops, inner + hoop * hoops
    form = ng.BilinearForm(both, symmetric=True, condense=condense)
    # apart, for NGSolve takes half the time; of one order of integration, by the bubbles, on curved triangles
    dx = ng.dx(bonus_intorder=2)
    shape, volume = 2 * shear * (inner - swell * swelling / 3), q * swelling + r * swell - q * r / bulk
    for part in (fe.turn() * shape, fe.turn() * volume) if revolved else (shape, volume):
        form += part * dx
    form.Assemble()
    return form, both


def with_contact(
    matrix: sparse.csr_matrix, mesh: Any, both: Any, order: int, revolved: bool = False
) -> ContactStiffness:
    """Return a condensed stiffness with its unknowns sorted and its contact boundary sampled.

    `both` is the product of the displacements' space and the pressures'.
    """
    space = both.components[0]
    free = np.fromiter(both.FreeDofs(True), dtype=bool, count=both.ndof)
    boundary = list(enumerate(mesh.Elements(ng.BND)))
    edges = [(number, edge) for number, edge in boundary if edge.mat.startswith("contact")]
    contact = np.unique(np.concatenate([_vertical(space, edge) for _, edge in edges]))
    inside = free.copy()
    inside[contact] = False
    nodes = _merged(_sample(mesh, space, edges, contact, *lobatto(order)))
    if revolved:  # the areas of turns: on the axis 0, where Lobatto's rule has none of the force
        nodes = replace(nodes, weight=2 * np.pi * np.abs(nodes.position[:, 0]) * nodes.weight)
    spacing = np.linspace(0.0, 1.0, FINE + 1)
    lift = np.zeros(both.ndof)  # in a hierarchical basis 1 at each vertex, 0 in higher functions
    lift[space.Range(1).start + np.arange(mesh.nv)] = 1.0
    return ContactStiffness(
        matrix=matrix,
        interior=np.flatnonzero(inside),
        contact=contact,
        lift=lift,
        nodes=nodes,
        fine=_sample(mesh, space, edges, contact, spacing, np.full(FINE + 1, 1 / FINE)),
        mesh=mesh,
        space=both,
    )


def symmetric_system(system: ContactStiffness) -> ContactStiffness:
    """Return the system for symmetric loads: on a half's cut x is held."""
    fixed, _ = fe.held_on_cut(system.mesh, system.space.components[0])
    return replace(system, interior=np.setdiff1d(system.interior, fixed))


def antisymmetric_unknowns(system: ContactStiffness) -> tuple[Index, Index]:
    """Return a half's interior and contact unknowns that are free under antisymmetric loads: on the
    cut z is held. `system` is the one before `symmetric_system`."""
    _, fixed = fe.held_on_cut(system.mesh, system.space.components[0])
    return np.setdiff1d(system.interior, fixed), np.setdiff1d(system.contact, fixed)


def lobatto(order: int) -> tuple[Array, Array]:
    """Return the order + 1 Gauss-Lobatto points of (0, 1) and their weights.

    Exact for polynomials of degree 2 order - 1. Abramowitz and Stegun 25.4.32.
    """
    series = np.zeros(order + 1)
    series[order] = 1.0
    inner = legendre.legroots(legendre.legder(series)) if order > 1 else np.empty(0)
    points = np.concatenate([[-1.0], np.sort(inner), [1.0]])
    weights = 2 / (order * (order + 1) * legendre.legval(points, series) ** 2)
    return (points + 1) / 2, weights / 2


def _vertical(space: Any, edge: Any) -> Index:
    """The vertical unknowns of an edge."""
    return np.array(space.components[1].GetDofNrs(edge), dtype=np.int64) + int(space.Range(1).start)


def _sample(
    mesh: Any, space: Any, edges: list[tuple[int, Any]], contact: Index, at: Array, weights: Array
) -> Sample:
    """Sample every edge, with its number on the boundary, at the parameters `at` in (0, 1)."""
    columns, values, numbers = [], [], [number for number, _ in edges]
    _, places, slopes = fe.mapped(mesh, at[:, None].tolist(), ng.BND)
    for _, edge in edges:
        local, shape = np.searchsorted(contact, _vertical(space, edge)), space.components[1].GetFE(edge)
        for t in at:
            values.append(np.asarray(shape.CalcShape(float(t), 0.0, 0.0)).ravel())
            columns.append(local)
    rows = np.repeat(np.arange(len(columns)), [c.size for c in columns])
    index = (rows, np.concatenate(columns))
    return Sample(
        sparse.csr_matrix((np.concatenate(values), index), shape=(len(columns), contact.size)),
        places[numbers].reshape(-1, 2),
        np.repeat([int(edge.mat.removeprefix("contact")) for _, edge in edges], at.size),
        (np.hypot(*slopes[numbers, :, :, 0].transpose(2, 0, 1)) * weights).ravel(),
        np.repeat(np.arange(len(edges)), at.size),
    )


def _merged(sample: Sample) -> Sample:
    """Return the sample with the vertices that two edges share taken once, their weights added.

    At a vertex the hierarchical basis has one function, of value 1; inside an edge a point is its own.
    """
    count = sample.weight.size
    largest = np.asarray(sample.rows.argmax(axis=1)).ravel()
    is_vertex = np.diff(sample.edge, prepend=-1, append=-1)
    is_vertex = (is_vertex[:-1] != 0) | (is_vertex[1:] != 0)
    key = np.where(is_vertex, largest, sample.rows.shape[1] + np.arange(count))
    _, first, group = np.unique(key, return_index=True, return_inverse=True)
    weight = np.bincount(group.ravel(), sample.weight).astype(np.float64)
    return Sample(sample.rows[first], sample.position[first], sample.ridge[first], weight, sample.edge[first])


def outlines(system: ContactStiffness, values: Array) -> list[DeformedLoop]:
    """Return the loops of the boundary under displacements `values` `(n,)`; edges inside are left out."""
    field = ng.GridFunction(system.space)
    field.vec.FV().NumPy()[:] = values
    points, places, _ = fe.mapped(system.mesh, EDGE_POINTS[:, None].tolist(), ng.BND)
    # along an edge the parameter runs from its second vertex to its first
    at_rest = places[:, ::-1]
    shift = field.components[0](points).reshape(places.shape)[:, ::-1]
    edges = {}
    for i, element in enumerate(system.mesh.Elements(ng.BND)):
        if element.mat != "inside":
            first, last = (v.nr for v in element.vertices)
            touches = np.full(EDGE_POINTS.size - 1, element.mat.startswith("contact"))
            edges[first] = last, at_rest[i, :-1], shift[i, :-1], touches
    loops = []
    while edges:
        following, *parts = edges.popitem()[1]
        loop = [parts]
        while following in edges:
            following, *parts = edges.pop(following)
            loop.append(parts)
        rest, moves, touches = (np.concatenate(columns) for columns in zip(*loop, strict=True))
        loops.append(DeformedLoop(rest, rest + moves, touches))
    return loops
