"""The rubber body of finite length, which Newton presses like the plane one (plane_body.py).

Functions are the products of prisms.py, laws are those of plane_body.py, in three dimensions in solid_law.py.
Lengths in the pad's unit, stresses in E.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial

import ngsolve as ng
import numpy as np

from skincad.base.arrays import Array, Index, Mask
from skincad.laws.rubber import Rubber
from skincad.mechanics.bodies import prisms, solid_law
from skincad.mechanics.bodies.condense import Front, FrontFactors, Unknowns, factored
from skincad.mechanics.bodies.elements import ContactStiffness, outlines
from skincad.mechanics.bodies.plane_body import NO_LAWS, raised, undetected_contact
from skincad.mechanics.bodies.prisms import SectionForms, along_y, free_unknowns, fronts_of
from skincad.mechanics.bodies.solid_law import Elements
from skincad.mechanics.problem import Bend, DeformedLoop


@dataclass(frozen=True)
class SolidBody:
    """A pad's part in `elements`, a triangle times a layer each.

    A state `(n,)` lists displacements (component x, z, y; section function; function along y), then pressures
    (element; function); `free` `(n,)` marks those not held. `of_element` `(e, 3 b)` numbers an element's
    displacements, `of_triangle` `(t, prisms)` the elements above a triangle. `symmetric` and, of a half,
    `antisymmetric` are the fronts (condense.py) for movements of either parity. `along` `(points,)` is y of
    the contact points. Of `rest` the contact unknowns and rows are the solid's, all else the section's.
    """

    forms: SectionForms
    rest: ContactStiffness
    free: Mask
    symmetric: tuple[list[Front], Unknowns]
    antisymmetric: tuple[list[Front], Unknowns] | None
    elements: Elements
    of_element: Index
    of_triangle: Index
    along: Array
    bend: Bend | None = None

    @property
    def displacements(self) -> int:
        """How many of the unknowns are displacements; the pressures follow."""
        pressures = self.elements.softening
        return int(self.free.size - pressures.shape[0] * pressures.shape[1])

    def split(self, state: Array) -> tuple[Array, Array]:
        """Return each element's displacements `(e, 3, b)` and pressures `(e, q)`."""
        count = len(self.of_element)
        displacement = state[self.of_element].reshape(count, 3, -1)
        return displacement, state[self.displacements :].reshape(count, -1)

    def residual(self, state: Array) -> Array:
        """Return the energy's derivative `(n,)` by all unknowns, held ones included."""
        nodal, tested = solid_law.forces(solid_law.points(self.elements, *self.split(state)))
        return np.concatenate([self.summed(nodal), tested.ravel()])

    def summed(self, nodal: Array) -> Array:
        """Return the displacements' sum `(displacements,)` of what each element `(e, 3 b)` adds to them."""
        return np.bincount(self.of_element.ravel(), nodal.ravel(), self.displacements).astype(np.float64)

    def energy(self, state: Array) -> float:
        """Return the energy; infinite where a point of the elements is turned inside out."""
        return solid_law.energy(self.elements, *self.split(state))

    def linearised(
        self, state: Array, residual: Array, fronts: tuple[list[Front], Unknowns] | None = None
    ) -> SolidLinearised:
        """Return the tangent factorised, for symmetric movements unless by other `fronts`; ContactError where
        the contact, held, leaves it indefinite."""
        at = solid_law.points(self.elements, *self.split(state))
        coupling = solid_law.coupling(at)
        stiffness = solid_law.stiffness(at, coupling)
        of_element = self.of_element

        def inside(triangle: int) -> Iterator[tuple[Index, Array]]:
            for element in self.of_triangle[triangle]:
                yield of_element[element], stiffness[element]

        small = factored(inside, *(fronts or self.symmetric), self.displacements)
        free = np.isin(self.rest.contact, small.border)  # on the cut no point moves up that the mirror turns
        flexibility = np.zeros((free.size, free.size))
        flexibility[np.ix_(free, free)] = small.flexibility
        return SolidLinearised(self, coupling, small, state, residual, flexibility)

    def undetected_contact(
        self, state: Array, plate: float, over: Callable[[Array], Array] = np.zeros_like
    ) -> str | None:
        """Return what touches without being in contact in the middle or at the end, or None; `over` as of a
        plane body."""
        cut = bool(self.forms.cut.any())
        plates = [plate, plate]
        if self.bend is not None:  # as far from the axis as the end's plane meets it
            plates[1] = self.bend.axis + (plate - self.bend.axis) / self._lean[1]
        for height, loops in zip(plates, self.outlines(state), strict=True):
            wrong = undetected_contact(loops, partial(raised, over, height), mirrored=cut)
            if wrong:
                return wrong
        return None

    @property
    def _lean(self) -> tuple[float, float]:
        """Cosine of the angle by which the section is turned in the middle and at the end."""
        return 1.0, 1.0 if self.bend is None else float(np.cos(self.along.max() / self.bend.radius))

    def outlines(self, state: Array) -> list[list[DeformedLoop]]:
        """Return the loops of the boundary, moved in their plane, at the middle y = 0 and at the end."""
        plane, count = self.forms.plane, self.forms.clamped.size
        loops = []
        for along, lean in zip((0, -1), self._lean, strict=True):
            moved = np.zeros(plane.space.ndof)
            x, z = state[: self.displacements].reshape(3, count, -1)[:2, :, along]
            moved[: 2 * count] = np.concatenate([x, z / lean])
            loops.append(outlines(plane, moved))
        return loops


@dataclass(frozen=True)
class SolidLinearised:
    """The tangent of `body` with its pressures condensed: `coupling` `(e, q, 3 b)` is that of pressures and
    displacements, `small` the factors; `residual` `(n,)` is that at the `state` `(n,)`."""

    body: SolidBody
    coupling: Array
    small: FrontFactors
    state: Array
    residual: Array
    flexibility: Array

    @property
    def negative_eigenvalues(self) -> tuple[int, int]:
        """How many eigenvalues of the tangent are negative: contact unknowns held, and free."""
        return 0, self.small.negative_eigenvalues

    def rebalanced(self, state: Array, residual: Array) -> SolidLinearised:
        """Return the same tangent at another state nearby with its `residual`."""
        return replace(self, state=state, residual=residual)

    def antisymmetric(self) -> SolidLinearised | None:
        """Return the same tangent for antisymmetric movements: on a half's cut z and y are held. None of a
        whole pad."""
        fronts = self.body.antisymmetric
        return None if fronts is None else self.body.linearised(self.state, self.residual, fronts)

    def move(self, push: Array) -> Array:
        """Return the step `(n,)` that balances the body, to first order, under contact forces `-push`."""
        body, count = self.body, self.body.displacements
        softening = body.elements.softening
        inner = softening @ self.residual[count:].reshape(*self.coupling.shape[:2], 1)
        load = -push[:count] - self.residual[:count] - body.summed(np.swapaxes(self.coupling, 1, 2) @ inner)
        displacement = self.small.solve(load)
        pressure = inner + softening @ (self.coupling @ displacement[body.of_element][:, :, None])
        return np.concatenate([displacement, pressure.ravel()])


def solid_body(
    forms: SectionForms,
    borders: Array,
    order: int,
    *,
    clamped_end: bool = False,
    laws: Mapping[str, Rubber] = NO_LAWS,
    bend: Bend | None = None,
) -> SolidBody:
    """Return the body over layers between `borders` `(layers + 1,)`, displacements of `order` along y.

    `laws` as in neo_hooke.body; a section with a `bend` turns. At y = 0 u_y is 0; with `clamped_end` at the
    end too: plane strain.
    """
    line, count = prisms.line(borders, order, bend=bend), forms.clamped.size
    along, height = line.at.size, len(borders) - 1
    domains, by_law = np.array([element.mat for element in forms.plane.mesh.Elements(ng.VOL)]), []
    for law in dict.fromkeys(laws.values()):  # with the numbers of its elements, `height` above a triangle
        triangles = np.flatnonzero(np.isin(domains, [name for name, other in laws.items() if other == law]))
        by_law.append((law, (triangles[:, None] * height + np.arange(height)).ravel()))
    elements = _extruded(forms, borders, order, tuple(by_law), bend)
    # an element's functions: the section's first, then y's; elements: triangle, then layer
    functions = forms.functions[:, None, :, None] * along
    functions = functions + (np.arange(height)[:, None] * order + np.arange(order + 1))[:, None]
    total = len(forms.functions) * height
    of_element = functions.reshape(total, 1, -1) + np.arange(3)[:, None] * count * along
    free = free_unknowns(forms, line, clamped_end=clamped_end)
    free_antisymmetric = free_unknowns(forms, line, clamped_end=clamped_end, antisymmetric=True)
    contact = (forms.plane.contact[:, None] * along + np.arange(along)).ravel()
    return SolidBody(
        forms=forms,
        rest=replace(along_y(forms.plane, line), contact=contact),
        free=np.concatenate([free.ravel(), np.ones(elements.test[:, 0].size, dtype=bool)]),
        symmetric=fronts_of(forms, free),
        antisymmetric=fronts_of(forms, free_antisymmetric) if forms.cut.any() else None,
        elements=elements,
        of_element=of_element.reshape(total, -1),
        of_triangle=np.arange(total).reshape(-1, height),
        along=np.repeat(line.at, forms.plane.nodes.weight.size),
        bend=bend,
    )


def _extruded(
    section: SectionForms,
    borders: Array,
    order: int,
    laws: tuple[tuple[Rubber, Index], ...],
    bend: Bend | None,
) -> Elements:
    """Products of the section's functions and points with those of layers between `borders`
    `(layers + 1,)`."""
    layer = prisms.layer_functions(order)
    thickness, (triangles, points) = np.diff(borders), section.weight.shape
    shape = (triangles, thickness.size, points, layer.at.size)
    total = triangles * thickness.size
    weight = np.einsum("tg,l,h->tlgh", section.weight, thickness, layer.weight)
    flat = np.einsum("tgjf,ha->tghjfa", section.basis[:, :, :2], layer.value)
    upright = np.einsum("tgf,ha,l->tlghfa", section.basis[:, :, 2], layer.slope, 1 / thickness)
    basis = np.empty((*shape, 3, *upright.shape[-2:]))
    basis[..., :2, :, :] = flat[:, None]
    basis[..., 2, :, :] = upright
    if bend is not None:
        stretch = bend.stretch(section.height)[:, None, :, None]
        weight = weight * stretch
        turn = (borders[:-1, None] + thickness[:, None] * layer.at) / bend.radius
        cosine, sine = (f(turn)[None, :, None, :, None, None] for f in (np.cos, np.sin))
        away, around = basis[..., 1, :, :].copy(), basis[..., 2, :, :] / stretch[..., None, None]
        basis[..., 1, :, :] = cosine * away - sine * around
        basis[..., 2, :, :] = sine * away + cosine * around
    test = np.einsum("tgp,hr->tghpr", section.test, layer.pressure)
    test = np.broadcast_to(test[:, None], (*shape, *test.shape[-2:]))
    g = points * layer.at.size
    shear, bulk = (np.repeat(m, thickness.size)[:, None] for m in (section.shear, section.bulk))
    weight, basis = weight.reshape(total, g), basis.reshape(total, g, 3, -1)
    return Elements(weight, basis, test.reshape(total, g, -1), shear, bulk, laws)
