"""A pad with masses, condensed for time steps.

A meshed pad with all its displacements kept: stiffness, relaxing part and mass; names ngsolve. Where a pad at
rest is condensed element by element, inner displacements have mass and memory of their own, so the pressure
alone is eliminated here. At rest both give the same displacements, to rounding.

The contact points bear no mass; theirs is spread over the rest. Points with mass of their own
stop or bounce at the plate by a rule that no mesh has, chatter, and gain energy: a bar that a plate strikes
ends with up to 2.9 times the work too much at small steps, without their mass with 5e-5 of it (undamped,
tests/mechanics/dynamics/test_steps.py). Khenous, Laborde, Renard, Eur. J. Mech. A/Solids 27 (2008) 918.
"""

from __future__ import annotations

from dataclasses import replace

import ngsolve as ng
import numpy as np
from scipy import sparse

from skincad.base.machine import one_blas_thread
from skincad.mechanics.bodies import elements, fe, film_field
from skincad.mechanics.bodies.film_field import StripBody
from skincad.mechanics.bodies.mesh import PadPiece
from skincad.mechanics.dynamics.steps import PadEquations
from skincad.mechanics.film.sliding import MOST_CONTACT_UNKNOWNS, halves_of, whole_points
from skincad.mechanics.film.stick import in_strip_axes, on_whole
from skincad.mechanics.problem import SizeError


def linear(
    piece: PadPiece, mesh: object, order: int, films: bool, *, massless_contact: bool = True
) -> PadEquations:
    """Return the equations of netgen's mesh of the piece; `films` asks for the strips' stresses. With
    `massless_contact` contact points have no mass, so that contact starts no waves of its own.

    Raises SizeError for more contact unknowns than a dense block can hold.
    """
    pad, unit = piece.pad, piece.unit
    materials = pad.materials
    silicone = "|".join(
        name for name, moduli in materials.items() if name != "film" or moduli == materials["skin"]
    )
    with one_blas_thread():
        body = film_field.body(elements.curved(mesh, order), order, materials)
        curved, (space, pressures) = body.system.mesh, body.system.space.components
        mixed = fe.as_csr(elements.small_strain(curved, order, materials, condense=False)[0].mat)
        n = space.ndof
        divergence = sparse.csr_matrix(mixed[n:, :n])  # tested by the mean stress
        mean_stress = sparse.csr_matrix(fe.block_inverse(-mixed[n:, n:], curved, pressures) @ divergence)
        shear, _ = fe.moduli(curved, materials)
        u, v = space.TnT()
        strain, test = ng.Sym(ng.Grad(u)), ng.Sym(ng.Grad(v))
        deviatoric = 2 * shear * (ng.InnerProduct(strain, test) - ng.div(u) * ng.div(v) / 3)
        soft = fe.assembled(deviatoric * ng.dx(definedon=curved.Materials(silicone)), space)
        density = curved.MaterialCF(dict(pad.densities))
        mass = fe.assembled(density * ng.InnerProduct(u, v) * ng.dx, space)
        mass = sparse.csr_matrix(1e-12 * pad.length * unit**2 * mass)  # kg/m3 are 1e-12 tonne/mm3
        scale, none = pad.young_modulus * pad.length, sparse.csr_matrix((0, n))
        stiff = sparse.csr_matrix(scale * (mixed[:n, :n] + divergence.T @ mean_stress))
        by_strip = [none, none]
        if films:
            relaxes = "film" in silicone.split("|")
            by_strip = [
                m * (pad.young_modulus / unit) for m in _strip_stresses(piece, body, mean_stress, relaxes)
            ]
    points = whole_points(piece, body)
    if 2 * points.x.size > MOST_CONTACT_UNKNOWNS:
        limit = f"a scene takes at most {MOST_CONTACT_UNKNOWNS} contact unknowns"
        raise SizeError("ridge.count", limit, 2 * points.x.size, "take fewer ridges")
    free = np.flatnonzero(np.fromiter(space.FreeDofs(), dtype=bool, count=n))
    halves = tuple(
        replace(half, points=half.points[:, :n])  # the pressure's unknowns come after the displacements'
        for half in halves_of(piece, body, points, free)
    )
    if massless_contact:
        bears, lift = np.ones(n), body.system.lift[:n]  # of a rigid motion by 1
        bears[body.contact] = 0.0
        rest = sparse.csr_matrix(sparse.diags(bears) @ mass @ sparse.diags(bears))
        mass = rest * float((lift @ (mass @ lift)) / (lift @ (rest @ lift)))
    strips = []
    for half in halves:
        turn = _turned(piece, half.parity) if films else sparse.csr_matrix((0, 0))
        slow, relaxing = (sparse.csr_matrix(turn @ stresses) for stresses in by_strip)
        strips.append((slow, relaxing))
    return PadEquations(
        stiff=stiff,
        soft=sparse.csr_matrix(scale * soft),
        mass=mass,
        halves=halves,
        strips=tuple(strips),
        share=points.share,
        gap=points.gap,
        area=points.area,
        ridge=points.ridge,
        unknowns=sum(half.inner.size + half.contact.size for half in halves),
        body=body,
    )


def _strip_stresses(
    piece: PadPiece, body: StripBody, mean_stress: sparse.csr_matrix, relaxes: bool
) -> tuple[sparse.csr_matrix, sparse.csr_matrix]:
    """Mean stresses xx, xz, zz, yy, in E per unit, of all the elastic stress and of what relaxes of it,
    `(4 strips, n)` each, strip by strip; `mean_stress` `(p, n)` gives its unknowns, and `relaxes` says
    whether strips are of silicone."""
    mesh, (space, pressures) = body.system.mesh, body.system.space.components
    flat = ng.L2(mesh, order=0)
    shear, _ = fe.moduli(mesh, piece.pad.materials)
    u, q, test = space.TrialFunction(), pressures.TrialFunction(), flat.TestFunction()
    h = ng.Grad(u)
    mean = (h[0, 0] + h[1, 1]) / 3
    parts = 2 * (h[0, 0] - mean), h[0, 1] + h[1, 0], 2 * (h[1, 1] - mean), -2 * mean
    inside = ng.dx(definedon=mesh.Materials("film"))
    by_element = [fe.assembled(shear * part * test * inside, space, flat) for part in parts]
    volumetric = fe.assembled(q * test * inside, pressures, flat) @ mean_stress
    count = len(piece.slots)
    numbers, strip = film_field.strips_of(mesh, piece)
    areas = film_field.strip_areas(piece)
    averages = sparse.csr_matrix((1 / areas[strip], (strip, numbers)), shape=(count, flat.ndof))
    order = np.arange(4 * count).reshape(4, count).T.ravel()  # strip by strip, its four stresses together
    relaxing = sparse.vstack([averages @ part for part in by_element]).tocsr()[order]
    steady = sparse.vstack([averages @ volumetric * share for share in (1.0, 0.0, 1.0, 1.0)]).tocsr()[order]
    return sparse.csr_matrix(relaxing + steady), relaxing * float(relaxes)


def _turned(piece: PadPiece, parity: int) -> sparse.csr_matrix:
    """How all strips' stresses, each in its own axes, follow from those of the piece:
    `(3 strips of the whole, 4 strips)`."""
    count, turned = len(piece.slots), []
    for one in np.eye(4 * count):
        turned.append(on_whole(piece, in_strip_axes(one.reshape(count, 4), piece.slots), parity).ravel())
    return sparse.csr_matrix(np.array(turned).T)
