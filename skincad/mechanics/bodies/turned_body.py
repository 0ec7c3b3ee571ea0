"""The rubber body of a section that turns about x = 0, at finite strain under loads that are no turned ones.

Functions are products of the section's (prisms.py) and of cos kt and sin kt, k <= HARMONICS, at the angle t
round the axis; displacements are along x, along the axis z and along y. So a body that turns as a whole is
among them, and each small movement of harmonics 0 and 1 (harmonics.py). Loads and movements are their own
images in the plane y = 0. Integrals round the axis are sums over POINTS. Laws and pressures are those of
solid_law.py. Lengths in the pad's unit, stresses in E. Range: until a surface folds onto itself, which a
finer mesh shows earlier. Reference: tests/mechanics/models/test_pin_body.py.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from skincad.base.arrays import Array
from skincad.mechanics.bodies import elements
from skincad.mechanics.bodies.mesh import PadPiece
from skincad.mechanics.bodies.prisms import SectionForms, fronts_of, section_forms
from skincad.mechanics.bodies.solid_body import SolidBody
from skincad.mechanics.bodies.solid_law import Elements

HARMONICS = 2  # with 3 a pin that sways by 0.4 of its height bears 7e-4 more
POINTS = 3 * HARMONICS  # round half a turn
WAVES = 2 * HARMONICS + 1  # functions round the axis: 1, cosines, sines
TINY = 1e-300


def turned_body(meshed: PadPiece, order: int) -> tuple[SolidBody, Array]:
    """Return the body of a meshed section with one feature, whose tip moves as a rigid one; and how the tip's
    unknowns (`rest.contact`) move `(4, k)`: along x by 1, down by 1, and by the cosine less 1 and the sine of
    its turn towards x about where the tip is highest."""
    forms = section_forms(elements.curved(meshed.mesh, order), order, meshed.pad.materials)
    (triangles, points), count = forms.weight.shape, forms.clamped.size
    domains = np.array([element.mat for element in forms.plane.mesh.Elements()])
    wave, basis = _turned(forms)
    test = np.einsum("tgp,qh->tgqph", forms.test, wave[:, :HARMONICS])
    functions = (forms.functions[:, :, None] * WAVES + np.arange(WAVES)).reshape(triangles, 1, -1)
    free = np.repeat(~forms.clamped[None], 3, axis=0)[:, :, None] & np.ones(WAVES, dtype=bool)
    free[:2, :, HARMONICS + 1 :] = False  # along x and z sines are no images of themselves
    free[2, :, : HARMONICS + 1] = False
    free[:, forms.cut, 1:] = False  # on the axis nothing depends on the angle
    tip = forms.plane.contact
    free[2, tip - count] = False
    fronts, unknowns = fronts_of(forms, free, np.concatenate([tip - count, tip]))
    of_elements = Elements(
        weight=np.repeat(math.tau / POINTS * forms.weight * forms.across, POINTS, axis=1),
        basis=basis.reshape(triangles, points * POINTS, 3, -1),
        test=test.reshape(triangles, points * POINTS, -1),
        shear=forms.shear[:, None],
        whole_bulk=forms.bulk[:, None],
        laws=tuple((law, np.flatnonzero(domains == name)) for name, law in meshed.pad.laws.items()),
    )
    body = SolidBody(
        forms=forms,
        rest=replace(forms.plane, contact=unknowns(fronts[-1].border)),
        free=np.concatenate([free.ravel(), np.ones(of_elements.test[:, 0].size, dtype=bool)]),
        symmetric=(fronts, unknowns),
        antisymmetric=None,
        elements=of_elements,
        of_element=(functions + count * WAVES * np.arange(3)[:, None]).reshape(triangles, -1),
        of_triangle=np.arange(triangles)[:, None],
        along=np.zeros(0),
    )
    return body, _rigid(forms)[:, body.rest.contact]


def rigid_parts(body: SolidBody, domain: str) -> Array:
    """Return means over a domain by displacements `(4, n)`: of those along x and up, and if it is rigid the
    sine of its turn towards x, and the cosine less 1; zeros where there is none."""
    forms, of = body.forms, body.elements
    inside = np.array([element.mat == domain for element in forms.plane.mesh.Elements()])
    weight, area = of.weight[inside], (forms.weight * forms.across)[inside]
    by_x, by_z = np.einsum("eg,egaf->aef", weight, of.basis[inside, :, :2]) / max(2 * weight.sum(), TINY)
    mean = np.einsum("tg,tgf->tf", area, forms.basis[inside, :, 2]) / max(area.sum(), TINY)
    rows = np.zeros((4, len(by_x), 3, by_x.shape[-1]))
    rows[0, :, 0, ::WAVES] = rows[1, :, 1, ::WAVES] = mean  # waves have no mean round the axis
    rows[2, :, 0], rows[2, :, 1], rows[3, :, 0], rows[3, :, 1] = by_z, -by_x, by_x, by_z
    numbers = body.of_element[inside].ravel()
    return np.array([np.bincount(numbers, row.ravel(), body.displacements) for row in rows])


def _turned(forms: SectionForms) -> tuple[Array, Array]:
    """The functions round the axis `(POINTS, WAVES)`, and the gradients along x, z and y of the section's
    functions times these, by triangle, point, point round the axis, direction, and both functions."""
    angle, k = (np.arange(POINTS)[:, None] + 0.5) * math.pi / POINTS, np.arange(1, HARMONICS + 1)
    one, cosine, sine = np.ones_like(angle), np.cos(k * angle), np.sin(k * angle)
    wave, slope = np.hstack([one, cosine, sine]), np.hstack([0 * one, -k * sine, k * cosine])
    x, y, (outward, up, value) = np.cos(angle), np.sin(angle), np.moveaxis(forms.basis, 2, 0)
    round_axis = value / forms.across[..., None]

    def product(section: Array, along: Array) -> Array:
        return np.asarray(np.einsum("tgf,qh->tgqfh", section, along))

    along_x = product(outward, x * wave) - product(round_axis, y * slope)
    along_y = product(outward, y * wave) + product(round_axis, x * slope)
    return wave, np.stack([along_x, product(up, wave), along_y], axis=3)


def _rigid(forms: SectionForms) -> Array:
    """How displacements `(4, n)` change as a rigid tip moves, of others than the tip's by nothing."""
    nodes, count, tip = forms.plane.nodes, forms.clamped.size, forms.plane.contact - forms.clamped.size
    r, height = nodes.position.T
    fields = np.stack([np.ones_like(r), r, height - height.max()], axis=1)
    one, away, below = np.linalg.lstsq(nodes.rows.toarray(), fields, rcond=None)[0].T
    moved = np.zeros((4, 3, count, WAVES))
    moved[0, 0, tip, 0], moved[1, 1, tip, 0] = one, -one
    moved[2, 0, tip, 1], moved[2, 1, tip, 0] = away, below
    moved[3, 0, tip, 0], moved[3, 1, tip, 1] = below, -away
    return moved.reshape(4, -1)
