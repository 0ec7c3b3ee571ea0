"""The strips' mean stress at finite strain; names ngsolve.

Cauchy stress, N per present area, resolved where it is on the strip as it now lies: across is normal to the
material planes that were parallel to its faces, along is the material line along it. What a strip bears does
not change when it turns with its ridge. Averaged over the present volume. Lengths in units, stresses in E.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import ngsolve as ng
import numpy as np

from skincad.base.arrays import Array, Index
from skincad.laws.rubber import Rubber
from skincad.mechanics.bodies import fe
from skincad.mechanics.bodies.law_energy import NO_LAWS, excess
from skincad.mechanics.bodies.neo_hooke import NeoHookeBody, dilatation
from skincad.mechanics.bodies.strip_field import strips_of
from skincad.shape.feature import SensorPlace

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
        volume, *parts = (self._assembled(slope)[inside] for slope in self.slopes)
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
        mesh = self.moved.space.mesh
        film = mesh.Materials("film")
        sums = [
            ng.Integrate(part, mesh, order=self.order, definedon=film, element_wise=True)
            for part in self.parts
        ]
        total = np.zeros((self.strip.max(initial=-1) + 1, len(sums)))
        np.add.at(total, self.strip, np.array(sums).T[self.elements])
        return total

    @staticmethod
    def _assembled(slope: Any) -> Array:
        slope.Assemble()
        return np.array(slope.vec.FV().NumPy())


def strip_stress(
    body: NeoHookeBody,
    order: int,
    materials: Mapping[str, tuple[float, float]],
    slots: Sequence[SensorPlace],
    thickness: float,
    unit: float,
    laws: Mapping[str, Rubber] = NO_LAWS,
) -> StripStress:
    """Return the stresses of the strips in `slots`, `thickness` mm; the mesh has them as domain `film`.

    sigma = G / J (F F^T - 1) + (q - 2 G / 3 (J - 1)) 1: neo_hooke.strain_energy's own, with lambda (J - 1)
    lengthwise, where plane strain has a stretch of 1. A law of `laws` adds P F^T / J of what its energy has
    more (law_energy.py), and nothing lengthwise: there each power of the stretch, 1, balances ln J.
    """
    mesh = body.mesh
    elements, strip = strips_of(mesh, slots, thickness, unit)
    moved = ng.GridFunction(body.space)
    u, q = moved.components[0], moved.components[1].MakeVariable()
    shear, _ = fe.shear_and_bulk(*materials["film"])
    h = ng.Grad(u).MakeVariable()  # by which a law is derived, and the stress itself
    swell = dilatation(h)
    stretch, mean = ng.Id(2) + h, q - 2 * shear / 3 * swell
    # J sigma, so that sums are over the present volume
    stress = shear * (stretch * stretch.trans - ng.Id(2)) + (1 + swell) * mean * ng.Id(2)
    if "film" in laws:
        stress += shear * (excess(laws["film"], h).Diff(h) * stretch.trans)
    along = stretch * _directions(mesh, elements, np.array([s.direction for s in slots])[strip])
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
    return StripStress(moved, compiled, slopes, elements, strip, of, degree)


def _slope(space: Any, part: Any, by: tuple[Any, Any], extra: int) -> Any:
    """Return the form, to be assembled in each state, of a part's derivative `by` gradient and pressure."""
    v, p = space.TestFunction()
    form = ng.LinearForm(space)
    slope = part.Diff(by[0], ng.Grad(v)) + part.Diff(by[1], p)
    form += slope.Compile() * ng.dx("film", bonus_intorder=extra)
    return form


def _directions(mesh: Any, elements: Index, direction: Array) -> Any:
    """Return a vector that is constant on each of the elements, `(e, 2)`, zero elsewhere."""
    components = []
    for values in direction.T:
        constant = ng.GridFunction(ng.L2(mesh, order=0))
        on_all = np.zeros(mesh.ne)
        on_all[elements] = values
        constant.vec.FV().NumPy()[:] = on_all
        components.append(constant)
    return ng.CF(tuple(components))
