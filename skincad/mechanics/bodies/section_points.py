"""The section's functions at quadrature points of its triangles."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import ngsolve as ng
import numpy as np

from skincad.base.arrays import Array
from skincad.mechanics.bodies import fe


@dataclass(frozen=True)
class SectionPoints:
    """The g points of each of t triangles, of `weight` `(t, g)` in area.

    `basis` `(t, g, 3, f)` is the derivative by x, by z and the value of the triangle's functions, `test`
    `(t, g, q)` its pressure functions; `shear`, `bulk` `(t,)` are moduli.
    """

    weight: Array
    basis: Array
    test: Array
    shear: Array
    bulk: Array


def section_points(
    mesh: Any, space: Any, pressures: Any, materials: Mapping[str, tuple[float, float]]
) -> SectionPoints:
    """Return the functions of scalar spaces at points that integrate their products on straight triangles."""
    elements = list(mesh.Elements(ng.VOL))
    rule = ng.IntegrationRule(ng.TRIG, 2 * space.GetFE(elements[0]).order)
    at, share = [p[:2] for p in rule.points], np.array(rule.weights)
    _, _, jacobian = fe.mapped(mesh, at, ng.VOL)
    # a hierarchical basis looks alike in all triangles whose corners are numbered in the same order
    corners = np.array([[v.nr for v in element.vertices] for element in elements])
    orders, which = np.unique(np.argsort(corners, axis=1), axis=0, return_inverse=True)
    alike = [elements[int(np.argmax(which.ravel() == k))] for k in range(len(orders))]

    def sampled(field: Any, of: str) -> Array:
        shapes = [field.GetFE(element) for element in alike]
        values = np.array([[np.asarray(getattr(shape, of)(*p, 0.0)) for p in at] for shape in shapes])
        return values[which.ravel()]

    values = sampled(space, "CalcShape").reshape(len(elements), len(at), -1)
    slopes = sampled(space, "CalcDShape") @ np.linalg.inv(jacobian)
    basis = np.stack([slopes[..., 0], slopes[..., 1], values], axis=2)
    test = sampled(pressures, "CalcShape").reshape(len(elements), len(at), -1)
    moduli = np.array([materials[element.mat] for element in elements])
    young, ratio = moduli.T
    return SectionPoints(
        share * np.linalg.det(jacobian),
        basis,
        test,
        young / (2 * (1 + ratio)),
        young / (3 * (1 - 2 * ratio)),
    )
