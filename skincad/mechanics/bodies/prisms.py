"""The solid of a section swept along y in layers of prisms.

Prisms with a triangle of the section's mesh as base: their functions are products, so the integrals
factor and the section's curved triangles are used as they are. With the one constant function along y
the same code is plane strain on the same mesh, to the last digit.

A section may turn about an axis along x instead: y is an arc, a point's functions are those of its movements
along x, away from the axis and around it, and the gradient has two terms more. Integrals still factor. What
is unknown are movements along x, z and y at every layer's points all the same.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise, product
from typing import Any, NamedTuple

import ngsolve as ng
import numpy as np
from numpy.polynomial import legendre
from scipy import linalg, sparse

from skincad.base.arrays import Array, Index, Mask
from skincad.mechanics.bodies import elements, fe
from skincad.mechanics.bodies.condense import NOT_DEFINITE, Front, Unknowns, dissection, schur
from skincad.mechanics.bodies.elements import ContactStiffness, Sample, lobatto
from skincad.mechanics.problem import Bend, ContactError


@dataclass(frozen=True)
class AlongY:
    """Integrals over y of n displacement functions w and q pressure functions r.

    `at` `(n,)` are the functions' points, `weight` `(n,)` what length each stands for. `mass` is w_i w_j,
    `slope` w_i w_j', `stiff` w_i' w_j', all `(n, n)`; `mean` r_i w_j, `rise` r_i w_j', both `(q, n)`;
    `inverse` `(q, q)` is the inverse of r_i r_j. `fine` `(f, n)` samples the functions evenly. Of a section
    that turns, y is the arc of its `bend`.
    """

    at: Array
    weight: Array
    mass: Array
    slope: Array
    stiff: Array
    mean: Array
    rise: Array
    inverse: Array
    fine: Array
    bend: Bend | None = None


class LayerFunctions(NamedTuple):
    """What a layer of thickness 1 has at its Gauss points: their place `at` and `weight` `(g,)`, displacement
    functions, their `value` and `slope` `(g, order + 1)`, and the `pressure` functions `(g, order - 1)`."""

    at: Array
    weight: Array
    value: Array
    slope: Array
    pressure: Array


def layer_functions(order: int) -> LayerFunctions:
    """Return the functions of a layer at Gauss points that are exact for what `line` integrates."""
    gauss, weight = legendre.leggauss(order + 1)
    value, slope = _lagrange(lobatto(order)[0], (gauss + 1) / 2)
    test: Array = legendre.legvander(gauss, order - 2).astype(np.float64)
    return LayerFunctions((gauss + 1) / 2, weight / 2, value, slope, test)


def constant() -> AlongY:
    """Return the line of plane strain: one function, 1, over a length of 1."""
    one, zero = np.ones((1, 1)), np.zeros((1, 1))
    ones: dict[str, Any] = dict.fromkeys(("mass", "mean", "inverse", "fine"), one)
    return AlongY(np.zeros(1), np.ones(1), **ones, slope=zero, stiff=zero, rise=zero)


def graded(half: float, last: float, growth: float) -> Array:
    """Return the borders `(layers + 1,)` of layers from 0 to `half`; the last is about `last` thick, each
    one before it thicker by the factor `growth`, all alike at 1; two layers at least."""
    if growth == 1.0:
        return np.linspace(0.0, half, max(2, round(half / last)) + 1)
    count = max(2, round(np.log1p(half / last * (growth - 1)) / np.log(growth)))
    sizes = growth ** np.arange(count)[::-1]
    return np.concatenate([[0.0], np.cumsum(sizes) * half / sizes.sum()])


def line(borders: Array, order: int, samples: int = 4, bend: Bend | None = None) -> AlongY:
    """Return Lagrange elements of order 2 or more on the layers' Gauss-Lobatto points.

    The pressure is discontinuous and of order - 2: tested with displacements along the section alone, which
    a bubble in each layer controls, it is stable times whatever pair is stable in the section (a product
    of order - 1 is not; Bernardi and Maday, Handbook of Numerical Analysis 5, 1997, sec. 24).
    """
    points, weights = lobatto(order)
    count = (borders.size - 1) * order + 1
    pressures = order - 1
    total = (borders.size - 1) * pressures
    at, weight = np.zeros(count), np.zeros(count)
    mass, slope, stiff = (np.zeros((count, count)) for _ in range(3))
    mean, rise, inverse = np.zeros((total, count)), np.zeros((total, count)), np.zeros((total, total))
    fine = []
    layer = layer_functions(order)
    w, value, derivative, test = layer.weight, layer.value, layer.slope, layer.pressure
    for i, (low, high) in enumerate(pairwise(borders.tolist())):
        size = high - low
        here = slice(i * order, i * order + order + 1)
        there = slice(i * pressures, (i + 1) * pressures)
        at[here] = low + size * points
        weight[here] += size * weights
        mass[here, here] += size * (value.T * w) @ value
        slope[here, here] += (value.T * w) @ derivative
        stiff[here, here] += (derivative.T * w) @ derivative / size
        mean[there, here] = size * (test.T * w) @ value
        rise[there, here] = (test.T * w) @ derivative
        inverse[there, there] = np.linalg.inv(size * (test.T * w) @ test)
        row = np.zeros((samples, count))
        row[:, here] = _lagrange(points, np.arange(samples) / samples)[0]
        fine.append(row)
    end = np.zeros((1, count))
    end[0, -1] = 1.0
    return AlongY(
        at=at,
        weight=weight,
        mass=mass,
        slope=slope,
        stiff=stiff,
        mean=mean,
        rise=rise,
        inverse=inverse,
        fine=np.vstack([*fine, end]),
        bend=bend,
    )


def _lagrange(points: Array, at: Array) -> tuple[Array, Array]:
    """Values and derivatives `(at, points)` of the Lagrange polynomials on `points` in (0, 1)."""
    degree = points.size - 1
    coefficients = np.linalg.inv(legendre.legvander(2 * points - 1, degree))
    derived = 2 * legendre.legder(coefficients, axis=0)
    value = legendre.legvander(2 * at - 1, degree) @ coefficients
    slope = legendre.legvander(2 * at - 1, max(degree - 1, 0)) @ derived
    return value, slope


# For the components x, z, y of a displacement, terms of its gradient: component, direction, which of the
# section's functions (slope by x, by z, value, value over the arm), whether it derives along y, and its sign.
# The last ones are those of a section that turns: around the axis a movement away from it stretches, and what
# moves around it turns
GRADIENT: tuple[tuple[tuple[int, int, int, int, float], ...], ...] = (
    ((0, 0, 0, 0, 1.0), (0, 1, 1, 0, 1.0), (0, 2, 2, 1, 1.0)),
    ((1, 0, 0, 0, 1.0), (1, 1, 1, 0, 1.0), (1, 2, 2, 1, 1.0), (2, 2, 3, 0, 1.0)),
    ((2, 0, 0, 0, 1.0), (2, 1, 1, 0, 1.0), (2, 2, 2, 1, 1.0), (1, 2, 3, 0, -1.0)),
)


@dataclass(frozen=True)
class SectionForms:
    """The section's scalar functions and pressures at the g points of each of its t triangles, of `weight`
    `(t, g)` in area, at x `across` and the `height` `(t, g)`.

    `basis` `(t, g, 3, f)` is the derivative by x, by z and the value of the triangle's functions, `test`
    `(t, g, q)` its pressure functions; `shear`, `bulk` `(t,)` are moduli. `functions` `(t, f)` numbers each
    triangle's functions, `centres` `(t, 2)` are its corners' mean; `clamped` `(n,)` marks functions clamped
    at the back, `cut` `(n,)` those on x = 0. `plane` has the contact points.
    """

    weight: Array
    across: Array
    height: Array
    basis: Array
    test: Array
    shear: Array
    bulk: Array
    clamped: Mask
    cut: Mask
    functions: Index
    centres: Array
    plane: ContactStiffness


@dataclass(frozen=True)
class Solid:
    """The condensed solid: `flexibility` `(k, k)` of the contact unknowns, seen like a section's.

    `rigid_body_error` is by how much a rigid lift of the clamped back by 1 fails to lift the contact unknowns
    by 1, beyond what the functions miss of it: the factorisation's rounding error. `in_plane` `(3 k, 3 k)` is
    the flexibility of movements along x, z and y, 0 where one is held; empty unless asked for.
    """

    seen: ContactStiffness
    flexibility: Array
    rigid_body_error: float
    unknowns: int
    in_plane: Array


def section_forms(mesh: Any, order: int, materials: Mapping[str, tuple[float, float]]) -> SectionForms:
    """Return the section's functions at points that integrate their products on straight triangles;
    `materials` maps a domain to (Young's modulus, Poisson's ratio).

    Displacements and pressure are those of `elements.assemble`.
    """
    space = ng.H1(mesh, order=order, orderinner=order + 1, dirichlet="back")
    pressures = ng.L2(mesh, order=order - 1)
    triangles = list(mesh.Elements(ng.VOL))
    rule = ng.IntegrationRule(ng.TRIG, 2 * space.GetFE(triangles[0]).order)
    at, share = [p[:2] for p in rule.points], np.array(rule.weights)
    _, places, jacobian = fe.mapped(mesh, at, ng.VOL)
    # a hierarchical basis looks alike in all triangles whose corners are numbered in the same order
    corners = np.array([[v.nr for v in triangle.vertices] for triangle in triangles])
    orders, which = np.unique(np.argsort(corners, axis=1), axis=0, return_inverse=True)
    alike = [triangles[int(np.argmax(which.ravel() == k))] for k in range(len(orders))]

    def sampled(field: Any, of: str) -> Array:
        shapes = [field.GetFE(triangle) for triangle in alike]
        values = np.array([[np.asarray(getattr(shape, of)(*p, 0.0)) for p in at] for shape in shapes])
        return values[which.ravel()]

    values = sampled(space, "CalcShape").reshape(len(triangles), len(at), -1)
    slopes = sampled(space, "CalcDShape") @ np.linalg.inv(jacobian)
    moduli = np.array([materials[triangle.mat] for triangle in triangles])
    shear, bulk = fe.shear_and_bulk(*moduli.T)
    return SectionForms(
        weight=share * np.linalg.det(jacobian),
        across=places[..., 0],
        height=places[..., 1],
        basis=np.stack([slopes[..., 0], slopes[..., 1], values], axis=2),
        test=sampled(pressures, "CalcShape").reshape(len(triangles), len(at), -1),
        shear=shear,
        bulk=bulk,
        clamped=~np.fromiter(space.FreeDofs(), dtype=bool, count=space.ndof),
        cut=fe.on_cut(mesh, space),
        functions=np.array([space.GetDofNrs(e) for e in triangles], dtype=np.int64),
        centres=fe.centres(mesh, triangles),
        plane=elements.assemble(mesh, order, materials),
    )


def prisms(forms: SectionForms, line: AlongY) -> tuple[Index, Callable[[int], Array]]:
    """Return the prisms that a line makes of the triangles: the unknowns `(t, 3 f n)` above each (component
    x, z, y; section function; function along y), and what gives their stiffness `(3 f n, 3 f n)`.

    2 G dev(e):dev(e) + K (P div u)^2 with the projection P on the pressures: what `elements.assemble`
    leaves after condensing the pressure, its weak form the same. The stiffness is the sum of eight products,
    by which factors derive along y.
    """
    bend, weight, basis = line.bend, forms.weight, forms.basis
    if bend is not None:
        stretch = bend.stretch(forms.height)
        weight, value = weight * stretch, basis[:, :, 2] / stretch[..., None]
        basis = np.stack([basis[:, :, 0], basis[:, :, 1], value, value / bend.radius], axis=2)
    count, _, kinds, f = basis.shape
    flat = basis.reshape(*weight.shape, kinds * f)
    shear = np.swapaxes(flat * (weight * forms.shear[:, None])[:, :, None], 1, 2) @ flat
    tested = np.swapaxes(forms.test * weight[:, :, None], 1, 2)
    volume_rows, coupled = tested @ forms.test / forms.bulk[:, None, None], tested @ flat
    volume = np.swapaxes(coupled, 1, 2) @ np.linalg.solve(volume_rows, coupled)
    shear, volume = (m.reshape(count, kinds, f, kinds, f) for m in (shear, volume))
    section = np.zeros((count, 2, 2, 2, 3, f, 3, f))
    terms = [
        (a, *term) for a, by_component in enumerate(GRADIENT) for term in by_component if term[2] < kinds
    ]
    for (a, i, j, kind, way, sign), (b, k, m, other, other_way, other_sign) in product(terms, repeat=2):
        # 2 dev(e):dev(e) of a gradient's terms ij and km
        part = float(i == k and j == m) + float(i == m and j == k) - 2 / 3 * float(i == j and k == m)
        if part:
            section[:, 0, way, other_way, a, :, b] += part * sign * other_sign * shear[:, kind, :, other]
        if i == j and k == m:
            section[:, 1, way, other_way, a, :, b] += sign * other_sign * volume[:, kind, :, other]
    strip = line.mean, line.rise
    along = [line.mass, line.slope, line.slope.T, line.stiff]
    along += [one.T @ line.inverse @ other for one in strip for other in strip]
    by_section, by_line = section.reshape(count, 8, -1), np.array(along).reshape(8, -1)
    size, n = forms.clamped.size, line.at.size
    functions = forms.functions[:, None, :] + size * np.arange(3)[:, None]
    unknowns = functions.reshape(count, -1, 1) * n + np.arange(n)
    cosine, sine = (of(line.at / (bend.radius if bend else 1.0))[:, None] for of in (np.cos, np.sin))

    def upright(rows: Array) -> Array:
        """Rows for movements along z and y, from those for movements away from the axis and around it."""
        x, away, around = rows.reshape(3, -1, n, len(rows))
        return np.stack([x, cosine * away - sine * around, sine * away + cosine * around]).reshape(rows.shape)

    def stiffness(triangle: int) -> Array:
        both = (by_section[triangle].T @ by_line).reshape(3 * f, 3 * f, n, n)
        matrix = np.asarray(both.transpose(0, 2, 1, 3).reshape(3 * f * n, 3 * f * n))
        return matrix if bend is None else upright(upright(matrix).T)

    return unknowns.reshape(count, -1), stiffness


def condensed(
    forms: SectionForms,
    line: AlongY,
    *,
    plane: bool = False,
    clamped_end: bool = False,
    in_plane: bool = False,
) -> Solid:
    """Return the solid seen by the plate: half of the length, u_y = 0 at y = 0, the end free.

    With `plane` u_y is 0 everywhere, with `clamped_end` at the end as well: both are plane strain. With
    `in_plane` the flexibility along x and y is returned too.
    """
    numbers, stiffness = prisms(forms, line)
    count, layers = forms.clamped.size, line.at.size
    free = free_unknowns(forms, line, plane=plane, clamped_end=clamped_end)
    flat = forms.plane.contact
    last = np.concatenate([flat - count, flat, flat + count]) if in_plane else flat
    fronts, unknowns = fronts_of(forms, free, last)
    fixed, load = np.zeros((3, count, layers)), np.zeros(3 * count * layers)
    fixed[1] = (forms.plane.lift[count : 2 * count] * forms.clamped)[:, None]
    for triangle in np.flatnonzero(forms.clamped[forms.functions].any(axis=1)).tolist():
        load[numbers[triangle]] += stiffness(triangle) @ fixed.ravel()[numbers[triangle]]

    def inside(triangle: int) -> Iterator[tuple[Index, Array]]:
        yield numbers[triangle], stiffness(triangle)

    complement, load = schur(inside, fronts, unknowns, load)
    try:
        root = linalg.cho_factor(complement, check_finite=False)
    except linalg.LinAlgError:
        raise ContactError(NOT_DEFINITE) from None
    flexibility = linalg.cho_solve(root, np.eye(load.size), check_finite=False)
    flexibility, moved = (flexibility + flexibility.T) / 2, flexibility @ load
    whole = np.zeros((0, 0))
    if in_plane:
        place = np.full(free.size, -1)
        place[np.arange(free.size).reshape(3 * count, layers)[last].ravel()] = np.arange(last.size * layers)
        able, lifted = place[unknowns(fronts[-1].border)], np.zeros(last.size * layers)
        whole = np.zeros((lifted.size, lifted.size))
        whole[np.ix_(able, able)], lifted[able] = flexibility, moved
        flexibility, moved = np.split(np.split(whole, 3)[1], 3, axis=1)[1], np.split(lifted, 3)[1]
    expected = np.repeat(forms.plane.lift[flat], layers)
    rigid_body_error = max(0.0, float(np.abs(moved + expected).max()) - MISSED * missed_lift(line))
    seen = along_y(forms.plane, line)
    return Solid(seen, flexibility, rigid_body_error, int(free.sum()), whole)


MISSED = 20.0  # of what its functions miss of a rigid lift, at most so much is felt; measured: 3 to 10


def missed_lift(line: AlongY) -> float:
    """Return by how much the functions along y miss a rigid lift by 1 of a section that turns."""
    if line.bend is None:
        return 0.0
    turn, fine = line.at / line.bend.radius, line.fine @ line.at / line.bend.radius
    return max(float(np.abs(line.fine @ of(turn) - of(fine)).max()) for of in (np.cos, np.sin))


def free_unknowns(
    forms: SectionForms,
    line: AlongY,
    *,
    plane: bool = False,
    clamped_end: bool = False,
    antisymmetric: bool = False,
) -> Mask:
    """Return which unknowns `(component, section function, function along y)` are free, see `condensed`; of a
    half those of movements that are their own image, or of `antisymmetric` ones, which the mirror turns
    round."""
    count, layers = forms.clamped.size, line.at.size
    free = ~np.tile(forms.clamped, 3).repeat(layers).reshape(3, count, layers)
    for component in (1, 2) if antisymmetric else (0,):
        free[component, forms.cut] = False
    free[2, :, 0] = False
    free[2, :, -1] &= not clamped_end
    free[2] &= not plane
    return np.asarray(free)


def fronts_of(forms: SectionForms, free: Mask, last: Index | None = None) -> tuple[list[Front], Unknowns]:
    """Return fronts over (component, section function), held ones left out; the `last` are never eliminated,
    those of the contact along z unless given."""
    last = forms.plane.contact if last is None else last
    count = forms.clamped.size
    mask = free.reshape(3 * count, -1)
    numbers = np.arange(mask.size).reshape(mask.shape)
    wanted = np.asarray(mask.any(axis=1))
    functions = []
    for f in forms.functions:
        three = np.concatenate([f, f + count, f + 2 * count])
        functions.append(three[wanted[three]])

    def unknowns(functions: Index) -> Index:
        return np.asarray(numbers[functions][mask[functions]])

    return dissection(functions, forms.centres, last[wanted[last]]), unknowns


def along_y(plane: ContactStiffness, line: AlongY) -> ContactStiffness:
    """Return the section's contact points repeated along y; the contact unknowns run along y first."""
    return replace(
        plane,
        nodes=_repeated(plane.nodes, line, np.eye(line.at.size), line.weight),
        fine=_repeated(plane.fine, line, line.fine, np.full(len(line.fine), 1 / len(line.fine))),
    )


def _repeated(sample: Sample, line: AlongY, along: Array, weight: Array) -> Sample:
    """The sample at every row of `along`, an edge's points next to each other as `threshold` wants them."""
    position, area = np.tile(sample.position, (len(along), 1)), np.outer(weight, sample.weight).ravel()
    if line.bend is not None:
        area = area * line.bend.stretch(position[:, 1])
        position[:, 1] = line.bend.height(position[:, 1], np.repeat(along @ line.at, sample.weight.size))
    points, times = sample.weight.size, len(along)
    by_line = np.arange(points * times).reshape(points, times).T.ravel()
    edges = int(sample.edge.max()) + 1
    return Sample(
        sparse.csr_matrix(sparse.kron(sample.rows, along, format="csr"))[by_line],
        position,
        np.tile(sample.ridge, times),
        area,
        (np.arange(times)[:, None] * edges + sample.edge).ravel(),
    )
