"""The section's functions at quadrature points of its triangles, for laws that prisms.py cannot factor."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import ngsolve as ng
import numpy as np

from skincad.base.arrays import Array
from skincad.mechanics.bodies import fe
from skincad.mechanics.bodies.prisms import SectionForms


@dataclass(frozen=True)
class SectionPoints:
    """The g points of each of t triangles, of `weight` `(t, g)` in area.

    `basis` `(t, g, 3, f)` is the derivative by x, by z and the value of the triangle's functions
    (`SectionForms.functions`), `test` `(t, g, q)` its pressure functions; `shear`, `bulk` `(t,)` are moduli.
    """

    weight: Array
    basis: Array
    test: Array
    shear: Array
    bulk: Array


def section_points(forms: SectionForms, materials: Mapping[str, tuple[float, float]]) -> SectionPoints:
    """Return the functions of `forms` at points that integrate their products on straight triangles."""
    mesh, space = forms.plane.mesh, forms.plane.space
    displacement, pressure = space.components[0].components[0], space.components[1]
    elements = list(mesh.Elements(ng.VOL))
    rule = ng.IntegrationRule(ng.TRIG, 2 * displacement.GetFE(elements[0]).order)
    at, share = [p[:2] for p in rule.points], np.array(rule.weights)
    _, _, jacobian = fe.mapped(mesh, at, ng.VOL)
    inverse = np.linalg.inv(jacobian)
    basis, test = [], []
    for element, to_reference in zip(elements, inverse, strict=True):
        shape, trial = displacement.GetFE(element), pressure.GetFE(element)
        values = np.array([np.asarray(shape.CalcShape(*p, 0.0)).ravel() for p in at])
        slopes = np.array([np.asarray(shape.CalcDShape(*p)) for p in at]) @ to_reference
        basis.append(np.stack([slopes[:, :, 0], slopes[:, :, 1], values], axis=1))
        test.append([np.asarray(trial.CalcShape(*p, 0.0)).ravel() for p in at])
    moduli = np.array([materials[element.mat] for element in elements])
    young, ratio = moduli.T
    return SectionPoints(
        share * np.linalg.det(jacobian),
        np.array(basis),
        np.array(test),
        young / (2 * (1 + ratio)),
        young / (3 * (1 - 2 * ratio)),
    )
