"""A section's body at finite strain: neo-Hookean or by any law of rubber, and contact that its model misses.

Where the contact model ends: only crowns and tip fillets meet the plate in the models. A flank that reaches
it, two ridges that meet and a slot that closes would pass through each other undetected; a state that shows
one is refused.

The body in plane strain or turned about x = 0: energy, residual and condensed tangent, at any state. It has
neo-Hooke's energy with the volume's part. Another law adds its excess over neo-Hooke's, so that a body
without a law is neo-Hooke's to the last digit, and small strain is the same whatever the law.

Same spaces, unknowns and contact rows as the small-strain stiffness (elements.py), whose law it tends to.
A state is the vector of all unknowns, displacements and pressures, `(n,)`, in the pad's unit and in E.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial, reduce
from operator import add
from types import MappingProxyType
from typing import Any

import ngsolve as ng
import numpy as np
import shapely
from netgen.meshing import NgException
from scipy import sparse

from skincad.base.arrays import Array, Index, Mask
from skincad.laws.rubber import Rubber
from skincad.mechanics.bodies import elements, fe
from skincad.mechanics.bodies.condense import Condensation, factorise, fill_order
from skincad.mechanics.bodies.elements import ContactStiffness, outlines, with_contact
from skincad.mechanics.problem import ContactError, DeformedLoop

THROUGH = 2e-3  # of the unit; between contact points the crown itself is up to 1e-3 above the plate


def undetected_contact(
    loops: list[DeformedLoop],
    plate: Callable[[Array], Array],
    with_itself: bool = True,
    *,
    mirrored: bool = False,
) -> str | None:
    """Return what is wrong with deformed loops under a plate at the heights `plate` of x, or None.

    Contact of the skin with itself is looked for unless `with_itself` is false. Of a `mirrored` half, what
    crosses x = 0 meets its own image.
    """
    for loop in loops:
        x, z = loop.moved[~(loop.touches | np.roll(loop.touches, 1))].T
        if (z > plate(x) + THROUGH).any():
            return "a ridge's flank or the skin between ridges meets the plate"
    if any(signed_area(loop.rest) * signed_area(loop.moved) <= 0 for loop in loops):
        return "a slot is turned inside out"
    if mirrored and min(loop.moved[:, 0].min() for loop in loops) < -THROUGH:
        return "two ridges meet in the middle"
    outer = max(range(len(loops)), key=lambda i: abs(signed_area(loops[i].rest)))
    holes = [loop.moved for i, loop in enumerate(loops) if i != outer]
    if with_itself and not shapely.is_valid(shapely.Polygon(loops[outer].moved, holes)):
        return "the skin folds onto itself: two ridges meet or a slot closes"
    return None


def crossing(loop: Array) -> tuple[float, Array]:
    """Return how deep a closed loop `(points, 2)` goes through itself, as the diameter of the largest circle
    in what it goes round twice or the wrong way; and where. 0 without that."""
    deepest, place = 0.0, np.zeros(2)
    line = shapely.LinearRing(loop)
    if line.is_simple:
        return deepest, place
    way = np.sign(signed_area(loop))
    for face in shapely.polygonize([shapely.unary_union(line)]).geoms:
        inside = np.array(face.representative_point().coords[0])
        turns = np.unwrap(np.arctan2(*(np.append(loop, loop[:1], axis=0) - inside).T[::-1]))
        if round(way * (turns[-1] - turns[0]) / (2 * np.pi)) in (0, 1):
            continue
        depth = 2 * float(shapely.maximum_inscribed_circle(face).length)
        if depth > deepest:
            deepest, place = depth, inside
    return deepest, place


def signed_area(loop: Array) -> float:
    """Return the area of a closed polygon `(points, 2)`, negative where it runs clockwise."""
    x, z = loop.T
    return float(x @ np.roll(z, -1) - z @ np.roll(x, -1)) / 2


PLANE = 2  # dimensions
VOLUME_ORDER = 4  # of the points in which an element's volume is looked at
PLAIN = ((1.0, 2.0),)  # neo-Hooke's powers
# Of (d / s)^2 below, up to which a power of both stretches is summed as a series. With TERMS the series is
# exact to 2e-14 for powers from -14 to 14; above, the root's second derivative loses 3 digits at most
NEAR, TERMS = 0.01, 11


NO_LAWS: Mapping[str, Rubber] = MappingProxyType({})


def excess(law: Rubber, h: Any, of: Any = ng) -> Any:
    """Return the energy density beyond neo-Hooke's, in units of the law's own shear modulus, in terms of the
    displacement gradient `h[i, j]` of two dimensions, or of three with `h[2, 2]` alone in the third. Infinite
    or nan where the law ends. `of` has NGSolve's functions exp, log, sqrt and IfPos, for arrays its own."""
    hoop = None if h.shape[0] == PLANE else h[2, 2]
    trace, minor = h[0, 0] + h[1, 1], h[0, 0] * h[1, 1] - h[0, 1] * h[1, 0]
    squares = h[0, 0] * h[0, 0] + h[1, 1] * h[1, 1] + h[0, 1] * h[0, 1] + h[1, 0] * h[1, 0]
    volume = 1 + trace + minor
    logarithm = of.log(volume)
    plain = squares / 2 + trace - logarithm
    if hoop is not None:
        plain = plain + hoop * hoop / 2 + hoop - of.log(1 + hoop)
    if law.powers == PLAIN:
        return law.energy(plain, of) - plain
    middle = 1 + trace + squares / 2  # of the two stretches' squares
    first = h[0, 0] - h[1, 1] + (h[0, 0] ** 2 + h[1, 0] ** 2 - h[0, 1] ** 2 - h[1, 1] ** 2) / 2
    second = h[0, 1] + h[1, 0] + h[0, 0] * h[0, 1] + h[1, 0] * h[1, 1]
    # (d / s)^2, squares are s + d and s - d
    difference = (first * first + second * second) / (middle * middle)
    measure = 0
    for share, power in law.powers:
        both, product = _power_sum(middle, difference, volume, power / 2, of), logarithm
        if hoop is not None:
            third = of.log(1 + hoop)
            both, product = both + of.exp(power * third) - 1, logarithm + third
        measure = measure + share * (2 / power**2 * both - 2 / power * product)
    return law.energy(measure, of) - plain


def _power_sum(middle: Any, difference: Any, volume: Any, half: float, of: Any) -> Any:
    """Return (s + d)^b + (s - d)^b - 2, with s - d as J^2 / (s + d): without cancellation."""
    series, binomials = 0.0, [1.0]  # binomials; scipy's are nan for negative integers
    for i in range(2 * TERMS - 2):
        binomials.append(binomials[-1] * (half - i) / (i + 1))
    for binomial in binomials[:0:-2]:
        series = difference * (series + binomial)
    near = 2 * (1 + series) * of.exp(half * of.log(middle))
    root = of.sqrt(of.IfPos(difference - NEAR, difference, 1.0 + 0 * difference))
    large = of.log(middle * (1 + root))
    far = of.exp(half * large) + of.exp(half * (2 * of.log(volume) - large))
    return of.IfPos(difference - NEAR, far, near) - 2


CLAMPED_EDGE, FACE_EDGE = 0.005, 0.05  # of the height, of features and of a bare face: see `body`
SINGULAR = "singular"  # what NGSolve says of an element's inner block without an inverse


@dataclass(frozen=True)
class NeoHookeBody:
    """A meshed pad at one order. `rest` is its tangent at rest with the contact's rows.

    `free` `(n,)` marks the unknowns that are not clamped, those inside an element among them; `order` lists
    them as they are eliminated, contact unknowns last, in all steps. Of a half these are for symmetric
    movements; `antisymmetric` lists the unknowns of antisymmetric ones, the last `antisymmetric_contact`
    being contact ones; a whole pad has none, nor has a section that turns.
    """

    mesh: Any
    space: Any
    form: Any
    rest: ContactStiffness
    free: Mask
    order: Index
    antisymmetric: Index
    antisymmetric_contact: int

    def residual(self, state: Array) -> Array:
        """Return the energy's derivative `(n,)` by all unknowns, clamped ones included; not finite where
        there is no energy, as in an element that is turned inside out."""
        vector = _vector(self, state).CreateVector()
        self.form.Apply(_vector(self, state), vector)
        return np.array(vector.FV().NumPy())

    def energy(self, state: Array) -> float:
        """Return the energy per length along y, or of the whole turn; infinite where a point of the elements
        is inside out."""
        value = float(self.form.Energy(_vector(self, state)))
        return value if np.isfinite(value) else np.inf

    def least_volume(self, state: Array, above: float) -> tuple[float, Array]:
        """Return the smallest volume ratio of a plane state `(n,)` at points of the elements that lie higher
        at rest than `above` of the height, and where that is, in units."""
        moved = ng.GridFunction(self.space)
        moved.vec.FV().NumPy()[:] = state
        points = self.mesh.MapToAllElements(ng.IntegrationRule(ng.TRIG, VOLUME_ORDER), ng.VOL)
        swell = dilatation(ng.Grad(moved.components[0]))
        values = np.asarray(ng.CF((ng.x, ng.y, swell))(points)).reshape(-1, 3)
        place, volume = values[:, :2], 1 + values[:, 2]
        high = place[:, 1] > above * place[:, 1].max()
        at = int(np.where(high, volume, np.inf).argmin())
        return float(volume[at]), place[at]

    @cached_property
    def damped(self) -> tuple[NeoHookeBody, Callable[[Array, float], None]]:
        """The body with what resists its movements, and what sets that: from a state `(n,)` on, a damping, E
        by the unit's square, times half the square of the distance, all over the section."""
        damping, since = ng.Parameter(0.0), ng.GridFunction(self.space)
        form = ng.BilinearForm(self.space, symmetric=True, condense=True)
        for part in self.form.integrators:
            form += part
        away = self.space.TrialFunction()[0] - since.components[0]
        form += ng.SymbolicEnergy(damping / 2 * ng.InnerProduct(away, away))
        form.AssembleLinearization(since.vec)

        def hold(state: Array, amount: float) -> None:
            since.vec.FV().NumPy()[:] = state
            damping.Set(amount)

        return replace(self, form=form), hold

    def linearised(
        self, state: Array, residual: Array, order: Index | None = None, contact: int = 0
    ) -> PlaneLinearised:
        """Return the tangent factorised at a state whose `residual` is at hand; ContactError where it is
        singular.

        Condensed to the contact unknowns, or to the last `contact` ones of another `order` of elimination.
        """
        try:
            self.form.AssembleLinearization(_vector(self, state))
        except NgException as failure:
            if SINGULAR not in str(failure):
                raise
            raise ContactError("the tangent stiffness of an element is singular") from None
        matrix = fe.as_csr(self.form.mat)
        small = factorise(matrix, self.order if order is None else order, contact or self.rest.contact.size)
        return PlaneLinearised(self, matrix, small, small.flexibility, *_condensed(self, residual))

    def outlines(self, state: Array) -> list[list[DeformedLoop]]:
        """Return the loops of the boundary in a state `(n,)`, of the one section there is."""
        return [outlines(self.rest, state)]

    def undetected_contact(
        self, state: Array, plate: float, over: Callable[[Array], Array] = np.zeros_like
    ) -> str | None:
        """Return what touches without being in contact, under a plate at the height `plate`, and higher by
        `over` of x, or None."""
        loops = outlines(self.rest, state)
        return undetected_contact(
            loops, partial(raised, over, plate), mirrored="cut" in self.mesh.GetBoundaries()
        )


def raised(over: Callable[[Array], Array], plate: float, x: Array) -> Array:
    """Return the height over x of what is higher by `plate` than `over`."""
    return over(x) + plate


def strain_energy(h: Any, q: Any, shear: Any, bulk: Any, log: Any) -> Any:
    """Return the energy density, in terms of the displacement gradient `h[i, j]` and the pressure q.

    In n = 2 (plane strain) or 3 dimensions (a section turned about x = 0 has its hoop strain as h[2, 2])
    G/2 (F:F - n - 2 ln J) + q (J - 1) - q^2 / (2 K) - G/3 (J - 1)^2, so that with q eliminated the
    volume's part is (K - 2 G/3)/2 (J - 1)^2: neo-Hookean with Lame's constants. Split at the bulk modulus
    K and not at lambda, as in elements.py, it holds at nu = 0 too. Bonet and Wood, Nonlinear Continuum
    Mechanics for Finite Element Analysis, 2nd ed., eq. (6.27), with (J - 1)^2 in place of (ln J)^2.
    """
    axes = range(h.shape[0])
    trace = reduce(add, [h[i, i] for i in axes])
    squares = reduce(add, [h[i, j] * h[i, j] for i in axes for j in axes])
    swell = dilatation(h)
    shape = squares + 2 * trace - 2 * log(1 + swell)  # F:F - n - 2 ln J
    return shear / 2 * shape - shear / 3 * swell * swell + q * swell - q * q / (2 * bulk)


def dilatation(h: Any) -> Any:
    """Return J - 1 of a displacement gradient in two or three dimensions, without cancellation at rest."""

    def minor(i: int, j: int) -> Any:
        return h[i, i] * h[j, j] - h[i, j] * h[j, i]

    if h.shape[0] == PLANE:
        return h[0, 0] + h[1, 1] + minor(0, 1)
    minors = h[1, 2] * h[2, 0] - h[1, 0] * h[2, 2], h[1, 0] * h[2, 1] - h[1, 1] * h[2, 0]
    determinant = h[0, 0] * minor(1, 2) + h[0, 1] * minors[0] + h[0, 2] * minors[1]
    return h[0, 0] + h[1, 1] + h[2, 2] + minor(0, 1) + minor(0, 2) + minor(1, 2) + determinant


def _small_strain_energy(h: Any, q: Any, shear: float, bulk: float) -> Any:
    """Return the energy density of the small-strain law, as `strain_energy` does of the other."""
    strain, swell = ng.Sym(h), h[0, 0] + h[1, 1]
    if h.shape[0] != PLANE:
        swell = swell + h[2, 2]
    return shear * (ng.InnerProduct(strain, strain) - swell * swell / 3) + q * swell - q * q / (2 * bulk)


def _clamped_edges(mesh: Any, reach: float) -> Any:
    """Return the triangles within `reach` times the height of the clamped boundary's ends, as bits."""
    places = np.array([v.point for v in mesh.vertices])
    back: set[int] = set()
    others: set[int] = set()
    for element in mesh.Elements(ng.BND):
        if element.mat != "cut":
            (back if element.mat == "back" else others).update(v.nr for v in element.vertices)
    near = np.zeros(len(places), dtype=bool)
    for end in back & others:
        near |= np.hypot(*(places - places[end]).T) <= reach * np.ptp(places[:, 1])
    return ng.BitArray([bool(near[[v.nr for v in e.vertices]].all()) for e in mesh.Elements(ng.VOL)])


def body(
    mesh: Any,
    order: int,
    materials: Mapping[str, tuple[float, float]],
    laws: Mapping[str, Rubber] = NO_LAWS,
    revolved: bool = False,
    face: bool = False,
) -> NeoHookeBody:
    """Return the body of a mesh, in plane strain or `revolved` about x = 0; `materials` maps a domain to
    (Young's modulus, Poisson's ratio).

    A domain that `laws` names has that law, scaled to its modulus; all others have neo-Hooke's.

    At the ends of the clamped back strains are unbounded in any mesh fine enough, and no load step is small
    enough for elements that turn inside out there. Triangles within CLAMPED_EDGE of the height from such
    an end keep the small-strain law instead; finite_strain.py has what that changes. A bare `face` is pressed
    as far as its back is wide, so strain is large there too: FACE_EDGE.
    """
    both = elements.mixed_space(mesh, order)
    u, q = both.TrialFunction()
    gradient, edges = ng.Grad(u), _clamped_edges(mesh, FACE_EDGE if face else CLAMPED_EDGE)
    if revolved:
        gradient = fe.in_space(gradient, u)
    # A factor with a derivative, 0: times an energy that is not a number it leaves no number in the residual
    # either, which a logarithm's own derivative, 1 / J, would
    one = ng.Parameter(1.0)
    form = ng.BilinearForm(both, symmetric=True, condense=True)
    for domain, constants in materials.items():  # one by one: a function of place is expensive to evaluate
        shear, bulk = fe.shear_and_bulk(*constants)
        density = strain_energy(gradient, q, shear, bulk, ng.log)
        if domain in laws:
            density += shear * excess(laws[domain], gradient)
        small = _small_strain_energy(gradient, q, shear, bulk)
        if revolved:
            density, small = fe.turn() * density, fe.turn() * small
        for energy, where in ((density, ~edges), (small, edges)):  # ng.Variation would not keep to elements
            inside = {"definedon": mesh.Materials(domain), "definedonelements": where}
            form += ng.SymbolicEnergy((one * energy).Compile(), **inside)
    form.AssembleLinearization(ng.GridFunction(both).vec)
    system = with_contact(fe.as_csr(form.mat), mesh, both, order, revolved)
    rest = elements.symmetric_system(system)
    free = np.fromiter(both.FreeDofs(), dtype=bool, count=both.ndof)
    free[np.setdiff1d(system.interior, rest.interior)] = False
    elimination = np.concatenate([fill_order(rest.matrix, rest.interior), rest.contact])
    antisymmetric = contact = np.empty(0, dtype=np.int64)
    if rest.interior.size < system.interior.size and not revolved:
        interior, contact = elements.antisymmetric_unknowns(system)
        antisymmetric = np.concatenate([fill_order(rest.matrix, interior), contact])
    return NeoHookeBody(
        mesh=mesh,
        space=both,
        form=form,
        rest=rest,
        free=free,
        order=elimination,
        antisymmetric=antisymmetric,
        antisymmetric_contact=contact.size,
    )


@dataclass(frozen=True)
class PlaneLinearised:
    """The body linearised at a state: `matrix` `(n, n)` and `residual` `(n,)`, condensed by what is inside
    elements, `inside` NGSolve's vector of the residual before that; `small` is the matrix factorised and
    `flexibility` `(k, k)` that of the contact unknowns. It moves the body's latest tangent."""

    body: NeoHookeBody
    matrix: sparse.csr_matrix
    small: Condensation
    flexibility: Array
    residual: Array
    inside: Any

    @property
    def negative_eigenvalues(self) -> tuple[int, int]:
        """How many eigenvalues of the tangent are negative: contact unknowns held, and free."""
        negative = self.small.pivots < 0
        return int(negative[: -len(self.small.flexibility)].sum()), int(negative.sum())

    def rebalanced(self, _: Array, residual: Array) -> PlaneLinearised:
        """Return the same tangent, the body's latest, at another state nearby with its `residual`."""
        condensed, inside = _condensed(self.body, residual)
        return replace(self, residual=condensed, inside=inside)

    def antisymmetric(self) -> PlaneLinearised | None:
        """Return the same tangent for antisymmetric movements: on a half's cut z is held and x is not. None
        of a whole body; ContactError where it is singular."""
        body = self.body
        if not body.antisymmetric.size:
            return None
        small = factorise(self.matrix, body.antisymmetric, body.antisymmetric_contact)
        free = np.flatnonzero(np.isin(body.rest.contact, body.antisymmetric))
        flexibility = np.zeros_like(self.flexibility)
        flexibility[np.ix_(free, free)] = small.flexibility
        return replace(self, small=small, flexibility=flexibility)

    def move(self, push: Array) -> Array:
        """Return the step `(n,)` that balances the body, to first order, under contact forces `-push`."""
        return self.recover(self.small.solve(-self.residual - push))

    def recover(self, step: Array) -> Array:
        """Return a step `(n,)` of the condensed unknowns with what it moves inside the elements, in balance
        to first order."""
        form, whole = self.body.form, _vector(self.body, step)
        whole.data += form.harmonic_extension * whole
        whole.data -= form.inner_solve * self.inside
        return np.array(whole.FV().NumPy())

    def unloaded(self) -> Array:
        """Return the contact unknowns' step `(k,)` without contact forces."""
        return self.small.at_contact(-self.residual)


def _condensed(body: NeoHookeBody, residual: Array) -> tuple[Array, Any]:
    """A residual condensed by the body's latest tangent, and NGSolve's vector of it."""
    inside = _vector(body, residual)
    condensed = inside.CreateVector()
    condensed.data = inside + body.form.harmonic_extension_trans * inside
    return np.array(condensed.FV().NumPy()), inside


def transferred(coarse: NeoHookeBody, state: Array, fine: NeoHookeBody) -> Array:
    """Return a state in the unknowns of a higher order on the same mesh."""
    source, target = ng.GridFunction(coarse.space), ng.GridFunction(fine.space)
    source.vec.FV().NumPy()[:] = state
    for part, finer in zip(source.components, target.components, strict=True):
        finer.Set(part)
    return np.array(target.vec.FV().NumPy())


def _vector(body: NeoHookeBody, values: Array) -> Any:
    vector = body.form.mat.CreateColVector()
    vector.FV().NumPy()[:] = values
    return vector
