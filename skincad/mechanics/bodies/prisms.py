"""The section extruded along y: stiffness as sums of (integrals over the section) x (integrals over y).

Prisms with a triangle of the section's mesh as base: their functions are products, so the integrals
factor and the section's curved triangles are used as they are. With the one constant function along y
the same code is plane strain on the same mesh, to the last digit.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import ngsolve as ng
import numpy as np
from scipy import linalg, sparse

from skincad.base.arrays import Array, Index, Mask
from skincad.mechanics.bodies import elements, fe
from skincad.mechanics.bodies.dissect import Front, Unknowns, dissection, schur
from skincad.mechanics.bodies.elements import Assembled, Sample
from skincad.mechanics.bodies.layers import AlongY
from skincad.mechanics.problem import ContactError

AXES = ("x", "z", "y")  # order of the displacement's components


@dataclass(frozen=True)
class SectionForms:
    """Integrals over the section's scalar functions v `(n,)` and pressures q.

    `shear[a, b]` is G (a of v_i) (b of v_j) and `volume[a]` is q_i (a of v_j), where x and z derive and y
    stands for the value; `inverse` is the inverse of q_i q_j / K. `held` `(n,)` marks functions clamped at
    the back, `cut` `(n,)` those on x = 0. `functions` and `centres` `(t, 2)` describe the triangles, `plane`
    the contact points.
    """

    shear: dict[tuple[str, str], sparse.csr_matrix]
    volume: dict[str, sparse.csr_matrix]
    inverse: sparse.csr_matrix
    held: Mask
    cut: Mask
    functions: list[Index]
    centres: Array
    plane: Assembled


@dataclass(frozen=True)
class Solid:
    """The condensed solid: `flexibility` `(k, k)` of the contact unknowns, seen like a section's.

    `lifted` is by how much a rigid lift of the clamped back by 1 fails to lift the contact unknowns by 1:
    the factorisation's lost digits. `along` `(points,)` is y of the contact points.
    """

    seen: Assembled
    flexibility: Array
    along: Array
    lifted: float
    unknowns: int


def section_forms(mesh: Any, order: int, materials: Mapping[str, tuple[float, float]]) -> SectionForms:
    """Return the section's integrals; `materials` maps a domain to (Young's modulus, Poisson's ratio).

    Displacements and pressure are those of `elements.assemble`.
    """
    space = ng.H1(mesh, order=order, orderinner=order + 1, dirichlet="back")
    pressure = ng.L2(mesh, order=order - 1)
    shear, _ = fe.moduli(mesh, materials)
    soft = mesh.MaterialCF({name: 3 * (1 - 2 * nu) / e for name, (e, nu) in materials.items()})
    (u, v), (q, r) = space.TnT(), pressure.TnT()
    of_u, of_v = _values(u), _values(v)
    both = {
        (a, b): fe.assembled(shear * of_v[a] * of_u[b] * ng.dx, space)
        for i, a in enumerate(AXES)
        for b in AXES[i:]
    }
    mirrored = {(b, a): m.T.tocsr() for (a, b), m in both.items()}
    volume = {a: fe.assembled(r * of_u[a] * ng.dx, space, pressure) for a in AXES}
    weight = fe.assembled(soft * q * r * ng.dx, pressure)
    inside = list(mesh.Elements(ng.VOL))
    return SectionForms(
        {**mirrored, **both},
        volume,
        fe.block_inverse(weight, mesh, pressure),
        ~np.fromiter(space.FreeDofs(), dtype=bool, count=space.ndof),
        fe.on_cut(mesh, space),
        [np.array(space.GetDofNrs(e), dtype=np.int64) for e in inside],
        fe.centres(mesh, inside),
        elements.assemble(mesh, order, materials),
    )


def _values(u: Any) -> dict[str, Any]:
    gradient = ng.grad(u)
    return {"x": gradient[0], "z": gradient[1], "y": u}


def stiffness(forms: SectionForms, line: AlongY) -> sparse.csr_matrix:
    """Return the stiffness over (component x, z, y; section function; function along y), small strain.

    2 G dev(e):dev(e) + K (P div u)^2 with the projection P on the pressures: what `elements.assemble`
    leaves after condensing the pressure, its weak form the same.
    """
    along = {("y", "y"): line.stiff, ("y", "-"): line.slope.T, ("-", "y"): line.slope, ("-", "-"): line.mass}
    strip = {"y": line.rise, "-": line.mean}
    blocks: list[list[Any]] = [[None] * 3 for _ in AXES]
    for i, a in enumerate(AXES):
        for j, b in enumerate(AXES[i:], i):
            terms = [(b, a, 1.0), (a, b, -2 / 3), *((c, c, 1.0) for c in AXES if a == b)]
            parts: dict[tuple[str, str], Any] = {}
            for test, trial, factor in terms:  # what runs alike along y is added up in the section
                key = _way(test), _way(trial)
                parts[key] = factor * forms.shear[test, trial] + parts.get(key, 0)
            section = forms.volume[a].T @ forms.inverse @ forms.volume[b]
            swell = strip[_way(a)].T @ line.inverse @ strip[_way(b)]
            blocks[i][j] = sparse.kron(section, swell, format="csr")
            for key, part in parts.items():
                blocks[i][j] = blocks[i][j] + sparse.kron(part, along[key], format="csr")
            if i != j:
                blocks[j][i] = blocks[i][j].T
    return sparse.csr_matrix(sparse.bmat(blocks, format="csr"))


def _way(axis: str) -> str:
    return "y" if axis == "y" else "-"


def condensed(forms: SectionForms, line: AlongY, *, plane: bool = False, clamped_end: bool = False) -> Solid:
    """Return the solid seen by the plate: half of the length, u_y = 0 at y = 0, the end free.

    With `plane` u_y is 0 everywhere, with `clamped_end` at the end as well: both are plane strain.
    """
    matrix = stiffness(forms, line)
    count, layers = forms.held.size, line.at.size
    free = free_unknowns(forms, line, plane=plane, clamped_end=clamped_end)
    flat = forms.plane.contact
    fronts, unknowns = fronts_of(forms, free)
    held = np.zeros((3, count, layers))
    held[1] = (forms.plane.lift[count : 2 * count] * forms.held)[:, None]
    complement, load = schur(matrix, fronts, unknowns, matrix @ held.ravel())
    try:
        root = linalg.cho_factor(complement, check_finite=False)
    except linalg.LinAlgError:
        raise ContactError(
            "the condensed stiffness is not positive definite; take a smaller poisson_ratio or film modulus"
        ) from None
    flexibility = linalg.cho_solve(root, np.eye(load.size), check_finite=False)
    expected = np.repeat(forms.plane.lift[flat], layers)
    lifted = float(np.abs(flexibility @ load + expected).max())
    seen = seen_by_plate(forms.plane, line)
    along = np.repeat(line.at, forms.plane.nodes.weight.size)
    return Solid(seen, (flexibility + flexibility.T) / 2, along, lifted, int(free.sum()))


def free_unknowns(
    forms: SectionForms, line: AlongY, *, plane: bool = False, clamped_end: bool = False
) -> Mask:
    """Return which unknowns `(component, section function, function along y)` are free, see `condensed`."""
    count, layers = forms.held.size, line.at.size
    free = ~np.tile(forms.held, 3).repeat(layers).reshape(3, count, layers)
    free[0, forms.cut] = False
    free[2, :, 0] = False
    free[2, :, -1] &= not clamped_end
    free[2] &= not plane
    return np.asarray(free)


def fronts_of(forms: SectionForms, free: Mask) -> tuple[list[Front], Unknowns]:
    """Return fronts over (component, section function), contact functions last, held ones left out."""
    count = forms.held.size
    mask = free.reshape(3 * count, -1)
    numbers = np.arange(mask.size).reshape(mask.shape)
    wanted = np.asarray(mask.any(axis=1))
    functions = []
    for f in forms.functions:
        three = np.concatenate([f, f + count, f + 2 * count])
        functions.append(three[wanted[three]])

    def unknowns(functions: Index) -> Index:
        return np.asarray(numbers[functions][mask[functions]])

    return dissection(functions, forms.centres, forms.plane.contact), unknowns


def seen_by_plate(plane: Assembled, line: AlongY) -> Assembled:
    """The section's contact points repeated along y; the contact unknowns run along y first."""
    return replace(
        plane,
        nodes=_repeated(plane.nodes, np.eye(line.at.size), line.weight),
        fine=_repeated(plane.fine, line.fine, np.full(len(line.fine), 1 / len(line.fine))),
    )


def _repeated(sample: Sample, along: Array, weight: Array) -> Sample:
    """The sample at every row of `along`, an edge's points next to each other as `threshold` wants them."""
    points, times = sample.weight.size, len(along)
    by_line = np.arange(points * times).reshape(points, times).T.ravel()
    edges = int(sample.edge.max()) + 1
    return Sample(
        sparse.csr_matrix(sparse.kron(sample.rows, along, format="csr"))[by_line],
        np.tile(sample.position, (times, 1)),
        np.tile(sample.ridge, times),
        np.outer(weight, sample.weight).ravel(),
        (np.arange(times)[:, None] * edges + sample.edge).ravel(),
    )
