"""What every body asks of NGSolve: moduli by domain, matrices, and places in the mesh.

Lengths are in the pad's unit, stresses in E.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, TypeVar

import ngsolve as ng
import numpy as np
from scipy import sparse

from skincad.base.arrays import Array, Index, Mask

Number = TypeVar("Number", float, Array)


def shear_and_bulk(young: Number, ratio: Number) -> tuple[Number, Number]:
    """Return the shear and the bulk modulus of a Young's modulus and a Poisson's ratio."""
    return young / (2 * (1 + ratio)), young / (3 * (1 - 2 * ratio))


def moduli(mesh: Any, materials: Mapping[str, tuple[float, float]]) -> tuple[Any, Any]:
    """Return shear and bulk modulus as NGSolve's functions of a mesh's domains."""
    by_domain = {name: shear_and_bulk(*constants) for name, constants in materials.items()}
    shear, bulk = ({name: both[i] for name, both in by_domain.items()} for i in (0, 1))
    return mesh.MaterialCF(shear), mesh.MaterialCF(bulk)


def turn() -> Any:
    """Return the length of the turn about x = 0, what an area of a revolved section counts for."""
    return 2 * math.pi * ng.x


def in_space(gradient: Any, u: Any) -> Any:
    """Return the gradient 3 x 3 of a section that turns about x = 0, x, z and round: with the hoop strain
    u_x / x, by the section's own `gradient` 2 x 2 and the displacement `u`.

    Where x = 0, u_x must be held; no point of integration lies there. Timoshenko and Goodier, Theory of
    Elasticity, 3rd ed., sec. 120.
    """
    rows = gradient[0, 0], gradient[0, 1], 0.0, gradient[1, 0], gradient[1, 1], 0.0, 0.0, 0.0, u[0] / ng.x
    return ng.CF(rows, dims=(3, 3))


def assembled(form: Any, trial_function: Any, test: Any = None) -> sparse.csr_matrix:
    """Return the matrix of an integrand over a space, or over trial and test functions' spaces."""
    whole = (
        ng.BilinearForm(trial_function)
        if test is None
        else ng.BilinearForm(trialspace=trial_function, testspace=test)
    )
    whole += form
    whole.Assemble()
    return as_csr(whole.mat)


def block_inverse(matrix: sparse.csr_matrix, mesh: Any, pressures: Any) -> sparse.csr_matrix:
    """Return the inverse of a matrix over discontinuous pressures: one block a triangle."""
    unknowns = np.array([pressures.GetDofNrs(element) for element in mesh.Elements(ng.VOL)])
    rows, columns = np.broadcast_arrays(unknowns[:, :, None], unknowns[:, None, :])
    blocks = np.asarray(matrix[rows.ravel(), columns.ravel()]).reshape(rows.shape)
    index = rows.ravel(), columns.ravel()
    return sparse.csr_matrix((np.linalg.inv(blocks).ravel(), index), shape=matrix.shape)


def centres(mesh: Any, triangles: Sequence[Any]) -> Array:
    """Return the mean of each triangle's corners `(t, 2)`."""
    points = np.array([v.point for v in mesh.vertices])
    return np.array([points[[v.nr for v in e.vertices]].mean(axis=0) for e in triangles])


def on_cut(mesh: Any, space: Any) -> Mask:
    """Return which unknowns of a scalar space lie on the cut at x = 0 of a half; none of a whole pad."""
    return np.fromiter(space.GetDofs(mesh.Boundaries("cut")), dtype=bool, count=space.ndof)


def held_on_cut(mesh: Any, space: Any) -> tuple[Index, Index]:
    """Return the displacements' unknowns in x and in z that lie on the cut: which of them symmetric loads
    hold, and which antisymmetric ones do."""
    on = np.flatnonzero(on_cut(mesh, space.components[0]))
    return on + space.Range(0).start, on + space.Range(1).start


def as_csr(matrix: Any) -> sparse.csr_matrix:
    """Return a copy of NGSolve's sparse matrix."""
    values, columns, starts = matrix.CSR()
    shape = matrix.height, matrix.width
    return sparse.csr_matrix((np.array(values), np.array(columns), np.array(starts)), shape=shape)


def mapped(mesh: Any, at: Sequence[Sequence[float]], kind: Any) -> tuple[Any, Array, Array]:
    """Return the points `at` `(p, d)` of all reference elements of a `kind` (ng.VOL, ng.BND) in the mesh.

    They are NGSolve's own, to evaluate fields at, their places `(e, p, 2)` and how these change with the
    reference coordinates, `(e, p, 2, d)`. An element's own map is never called: each point that it returns
    stays in NGSolve's memory until the process ends.
    """
    points = mesh.MapToAllElements(ng.IntegrationRule([tuple(p) for p in at], [0.0] * len(at)), kind)
    sides = len(at[0])
    places = np.asarray(ng.CF((ng.x, ng.y))(points)).reshape(-1, len(at), 2)
    slopes = np.asarray(ng.specialcf.JacobianMatrix(2, sides)(points)).reshape(-1, len(at), 2, sides)
    return points, places, slopes
