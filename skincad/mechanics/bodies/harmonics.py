"""A turned section under loads that are no turned ones: one harmonic round the axis x = 0.

Displacements are (u_r cos n t, u_z cos n t, u_t sin n t) at the angle t round the axis: n = 0 a pressure, n
= 1 a pull across the axis or a moment about a line across it. Zienkiewicz and Taylor, The Finite Element
Method, 5th ed., vol. 2, sec. 9.6. Lengths are in the pad's unit, stresses in E.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import ngsolve as ng
import numpy as np
from scipy import sparse

from skincad.base.arrays import Array
from skincad.mechanics.bodies import elements, fe
from skincad.mechanics.bodies.condense import Condensation, condense
from skincad.mechanics.bodies.elements import small_strain


def _solved(form: Any, space: Any, held: Sequence[Any], loads: Sequence[Any]) -> list[Any]:
    """The displacements under loads, NGSolve's linear forms of traction on the boundary, by a condensed
    stiffness `form` over a space of which the unknowns `held` are 0."""
    free = ng.BitArray(space.FreeDofs(True))
    for number in np.concatenate(held).tolist():
        free.Clear(number)
    inverse, fields = form.mat.Inverse(free, inverse="sparsecholesky"), []
    for load in loads:
        field = ng.GridFunction(space)
        field.vec.data = inverse * load.vec
        field.vec.data += form.harmonic_extension * field.vec
        fields.append(field)
    return fields


def harmonic(
    mesh: Any, order: int, materials: Mapping[str, tuple[float, float]], number: int
) -> tuple[Any, Any, list[Any]]:
    """Return harmonic `number` of a section that turns about x = 0, in small strain, with the pressure as an
    unknown: NGSolve's condensed form, its space, and which unknowns the axis holds. Materials and orders as
    in `small_strain`, which is harmonic 0.

    The space's first component is (u_r, u_z). For n > 0 the second, round the axis, is w = u_r + n u_t: the
    hoop strain is w / r, and strains stay finite on the axis with w = 0 there, without any condition that
    ties unknowns to each other.
    """
    if number == 0:
        form, both = small_strain(mesh, order, materials, revolved=True)
        return form, both, [fe.held_on_cut(mesh, both.components[0])[0]]
    plane = ng.VectorH1(mesh, order=order, orderinner=order + 1, dirichlet="back")
    around = ng.H1(mesh, order=order, orderinner=order + 1, dirichlet="back")
    both = plane * around * ng.L2(mesh, order=order - 1)
    (u, w, q), (v, s, p) = both.TnT()
    strains, tests = _strains(u, w, number), _strains(v, s, number)
    shear, bulk = fe.moduli(mesh, materials)
    swell, swelling = sum(strains[:3]), sum(tests[:3])
    inner = sum(a * b for a, b in zip(strains[:3], tests[:3], strict=True))
    inner += sum(a * b for a, b in zip(strains[3:], tests[3:], strict=True)) / 2
    form = ng.BilinearForm(both, symmetric=True, condense=True)
    dx = ng.dx(bonus_intorder=2)
    turn = fe.turn() / 2  # the mean of cos^2 round the axis
    form += turn * 2 * shear * (inner - swell * swelling / 3) * dx
    form += turn * (q * swelling + p * swell - q * p / bulk) * dx
    form.Assemble()
    in_r, in_z = fe.held_on_cut(mesh, plane)
    on_axis = np.flatnonzero(fe.on_cut(mesh, around)) + both.Range(1).start
    return form, both, [in_z, on_axis] if number == 1 else [in_r, in_z, on_axis]


def _strains(u: Any, w: Any, n: int) -> list[Any]:
    """Normal strains along r, z and t, and the shear strains rz, rt and zt, doubled, over cos n t or sin n
    t."""
    r, gradient, slope = ng.x, ng.Grad(u), ng.grad(w)
    return [
        gradient[0, 0],
        gradient[1, 1],
        w / r,
        gradient[0, 1] + gradient[1, 0],
        (slope[0] - gradient[0, 0]) / n + ((1 / n - n) * u[0] - w / n) / r,
        (slope[1] - gradient[0, 1]) / n - n * u[1] / r,
    ]


Places = tuple[Array, Array]  # radii and heights `(m,)`, in units


def pushed(
    mesh: Any, order: int, materials: Mapping[str, tuple[float, float]], loaded: float, at: Places
) -> tuple[float, Array]:
    """Return by how much the contact boundary sinks under a force of 1 along the axis, spread evenly within a
    radius, the mean weighted by the load; and the displacements `(2, m)`, outward and up, at places."""
    inside, area, ds = _tip(mesh, loaded)
    push = harmonic(mesh, order, materials, 0)
    (_, _), (v, _) = push[1].TnT()
    down = ng.LinearForm(-2 * math.pi * ng.x * inside / area * v[1] * ds).Assemble()
    (field,) = _solved(*push, [down])
    return float(ng.InnerProduct(down.vec, field.vec)), np.asarray(field.components[0](mesh(*at))).T


def pulled(
    mesh: Any, order: int, materials: Mapping[str, tuple[float, float]], loaded: float, at: Places
) -> tuple[Array, Array]:
    """Return the compliances `(2, 2)` of the contact boundary under a force of 1 across the axis and a moment
    of 1 that lifts the side it points to; and the displacements `(2, 3, m)` of both at places, outward, up
    and round, by the cosine and the sine of the angle to the pull."""
    inside, area, ds = _tip(mesh, loaded)
    turning = ng.Integrate(math.pi * ng.x**3 * inside * ds, mesh)
    pull = harmonic(mesh, order, materials, 1)
    _, (v, s, _) = pull[1].TnT()
    loads = [
        ng.LinearForm(math.pi * ng.x * inside / area * (2 * v[0] - s) * ds).Assemble(),
        ng.LinearForm(math.pi * ng.x**2 * inside / turning * v[1] * ds).Assemble(),
    ]
    fields, points, moves = _solved(*pull, loads), mesh(*at), []
    for field in fields:
        u, w = (np.asarray(field.components[i](points)).T for i in (0, 1))
        moves.append(np.stack([u[0], u[1], w.ravel() - u[0]]))
    across = np.array([[ng.InnerProduct(load.vec, field.vec) for field in fields] for load in loads])
    return across, np.array(moves)


def pulled_rings(
    mesh: Any, order: int, materials: Mapping[str, tuple[float, float]]
) -> tuple[sparse.csr_matrix, Condensation]:
    """Return how the unknowns of harmonic 1 move rings of contact points, `(2 m, n)`, and these unknowns
    condensed: along x, the mean round the ring; then up, at the side that the pull points to.

    A force along x that is spread evenly round a ring works on just that mean, (u_r - u_t) / 2 = u_r - w / 2.
    """
    form, both, held = harmonic(mesh, order, materials, 1)
    system = elements.with_contact(fe.as_csr(form.mat), mesh, both, order, revolved=True)
    plane, nodes, fixed = both.components[0], system.nodes, np.concatenate(held)
    up, count = system.contact, system.nodes.weight.size
    out, around = (up - plane.Range(1).start + start for start in (0, both.Range(1).start))
    rows = sparse.coo_matrix(nodes.rows)
    values = np.concatenate([rows.data, -rows.data / 2, rows.data])
    index = (
        np.concatenate([rows.row, rows.row, rows.row + count]),
        np.concatenate([unknowns[rows.col] for unknowns in (out, around, up)]),
    )
    moves = np.ones(both.ndof)
    moves[fixed] = 0.0
    points = sparse.csr_matrix((values, index), (2 * count, both.ndof)) @ sparse.diags(moves)
    contact = np.setdiff1d(np.concatenate([out, around, up]), fixed)
    inner = np.setdiff1d(system.interior, np.concatenate([contact, fixed]))
    return sparse.csr_matrix(points), condense(system.matrix, inner, contact)


def _tip(mesh: Any, loaded: float) -> tuple[Any, float, Any]:
    """The part of feature 1's contact boundary within a radius: an indicator times the normal's rise, its
    area seen along the axis, and the boundary to integrate over."""
    inside = ng.IfPos(loaded * (1 + 1e-6) - ng.x, ng.specialcf.normal(2)[1], 0.0)
    ds = ng.ds(definedon=mesh.Boundaries("contact1"), bonus_intorder=4)
    return inside, ng.Integrate(2 * math.pi * ng.x * inside * ds, mesh), ds
