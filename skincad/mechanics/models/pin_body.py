"""A pin at finite strain under a plate: how far its tip goes under a normal force and a pull.

The body is a pin on a disc of base (`lone`), its half meshed (bodies/turned_body.py). Its tip moves as one
that is rigid. A flat one keeps its angle; a crown rolls on the plate without slip: so a normal force acts
beside the pin's axis once that turns, and the contact goes further than the crown's middle. Equilibria under
a normal force N, where the contact has gone d along x, are the nodes of a table of

    H(N, d) = stored energy - N times the contact's sinking,  dH/dd = the pull,  dH/dN = - the sinking,

its cubic interpolation of Hermite's kind in both, as that of how a pin's magnet goes and turns. Heights
between those that are solved are interpolated at the same N and sway d / h. What counts is the excess over
small strain, which the reduced model has on a finer mesh, with the contact's own half-space.

Range: quasi-static; a base that is level round the pin, and wide; a pull and a normal force in the plane of
the axis. A contact is one point. Reference: the elastica, CalculiX, and the cell in small strain
(tests/mechanics/models/test_pin_body.py).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import product

import numpy as np

from skincad.base.arrays import Array, Index
from skincad.base.machine import one_blas_thread
from skincad.inputs.design import Design
from skincad.mechanics.bodies.mesh import Sizes, meshed_piece
from skincad.mechanics.bodies.solid_body import SolidBody
from skincad.mechanics.bodies.turned_body import rigid_parts, turned_body
from skincad.mechanics.contact.tips import Bending
from skincad.mechanics.models.pin_cell import magnet_pad
from skincad.mechanics.models.reduced import PinCells
from skincad.mechanics.problem import ContactError
from skincad.mechanics.validity import crown_radius, limits
from skincad.shape.skin import skin_of

# Of the mesh, order and edges, of the tip's radius: at a sharp root finer ones crease soon
ORDER, AT_TIP, ON_FLANK, IN_BASE = 2, 0.5, 0.2, 1.2
SWAY = 1 / 8  # between nodes, of the pin's height
STRAIN, OF_BUCKLING = 0.05, 0.25  # between nodes: of a pin, and of the force at which it tips over
SETTLED, ITERATIONS = 1e-5, 15  # of the tip's radius; four are usual
HALVINGS = 3  # of a way between two nodes
FIRM = 0.05  # of a pin's first stiffness; with less it is about to tip over
MIXED = 5e-4  # of a pull and a sinking: what `off` does not tell, of mixed derivatives and Newton's rest
MARGIN = 0.02  # of a square, by which a pin is beyond it before it is in the next
# The slope of a cubic through two values and slopes is off by at most 1 / (6 sqrt 3) of the interval times
# what its second derivative is off by at an end, where the fourth derivative is constant
OFF = 1 / (6 * math.sqrt(3))
# Hermite's functions of the value and the slope at 0, and those at 1, by powers; and their two derivatives
_CUBICS = np.array([[1, 0, -3, 2], [0, 1, -2, 1], [0, 0, 3, -2], [0, 0, -1, 1]], dtype=float)
HERMITE = np.array([_CUBICS @ np.linalg.matrix_power(np.diag([1, 2, 3], -1), k) for k in range(3)])


@dataclass(frozen=True, eq=False)
class PinBody:
    """The `body` of a cell and how its `tip` moves, of `turned_body`; means over its `magnet` `(4, n)`, of
    `rigid_parts`; its crown's `radius` in the `unit`, mm; `force` N is a force of 1."""

    body: SolidBody
    tip: Array
    magnet: Array
    radius: float
    unit: float
    force: float


@dataclass(frozen=True, eq=False)
class BentPin:
    """An equilibrium: the body's state `values`, how its tip is `moved` `(3,)`, along x, down, and turned,
    and its `numbers`: H in mJ, pull N, sinking mm, and the derivatives of the pull by N and by d, N/mm, and
    of the sinking by N, mm/N. `magnet` `(3, 3)` is how far its magnet has gone along x and up, mm, and the
    angle that it is turned by towards x, each with its derivatives by N and by d; zeros without one."""

    values: Array
    moved: Array
    numbers: Array
    magnet: Array


@lru_cache(maxsize=16)
def pin_body(cell: Design) -> PinBody:
    """Return the body of a design of one pin."""
    pad, wide = magnet_pad(cell), skin_of(cell).profile.tip_width / 2
    base = IN_BASE * wide
    meshed = meshed_piece(pad, Sizes(AT_TIP * wide, ON_FLANK * wide, base, base, smooth=True))
    body, tip = turned_body(meshed, ORDER)
    force = pad.young_modulus * meshed.unit**2
    magnet = rigid_parts(body, "film")
    return PinBody(body, tip, magnet, crown_radius(cell) / meshed.unit, meshed.unit, force)


@lru_cache(maxsize=2048)
def bent_pin(cell: Design, force: float, i: int, j: int) -> BentPin:
    """Return the equilibrium under i times a normal `force`, N, where the contact has gone j times SWAY of
    the height; each by way of those before. Raises ContactError where the pin folds."""
    pin, step = pin_body(cell), SWAY * skin_of(cell).heights[0]
    if (i, j) == (0, 0):
        return _equilibrium(pin, np.zeros(pin.body.free.size), np.zeros(3), 0.0, 0.0)
    before, start = (i, j - 1) if j else (i - 1, 0), (i * force, (j - 1) * step)
    try:
        with one_blas_thread():
            return _followed(pin, bent_pin(cell, force, *before), start, (i * force, j * step))
    except ContactError:
        at = f"pressed by {i * force:.2g} N and pulled aside by {j * SWAY:.2g} of its height"
        raise ContactError(f"a pin folds, {at}") from None


def _followed(
    pin: PinBody, before: BentPin, start: tuple[float, float], end: tuple[float, float], depth: int = HALVINGS
) -> BentPin:
    """The equilibrium at `end`, a normal force and a way, by others in between where Newton fails."""
    try:
        return _equilibrium(pin, before.values, before.moved, *end)
    except ContactError:
        if not depth:
            raise
    middle = (start[0] + end[0]) / 2, (start[1] + end[1]) / 2
    return _followed(pin, _followed(pin, before, start, middle, depth - 1), middle, end, depth - 1)


def _equilibrium(pin: PinBody, values: Array, moved: Array, normal: float, way: float) -> BentPin:
    """Newton from a state nearby; in each step the tip's forces follow from how it moves, linearly."""
    body, tip = pin.body, pin.body.rest.contact
    normal, way = normal / pin.force, way / pin.unit
    for _ in range(ITERATIONS):
        linear = body.linearised(values, body.residual(values))
        stiffness = np.asarray(np.linalg.inv(linear.flexibility), dtype=np.float64)
        alone = (values + linear.move(np.zeros_like(values)))[tip]
        moved, held, numbers, further = _rolled(pin, stiffness, alone, moved, normal, way)
        push = np.zeros((3, values.size))  # as it is, and with more of the normal force, or of the way
        push[:, tip] = -held - np.array([0 * held, *further])
        step = linear.move(push[0])
        values = values + step
        if not np.isfinite(energy := body.energy(values)):
            break
        if np.abs(step[: body.displacements]).max() <= SETTLED:
            force, unit = pin.force, pin.unit
            scale = [force * unit, force, unit, 1.0, force / unit, unit / force]
            numbers = np.array([energy - normal * numbers[1], *numbers]) * scale
            moves = np.array([values, *(linear.move(more) - step for more in push[1:])])
            x, up, sine, less = pin.magnet @ moves[:, : body.displacements].T
            cosine = 1 + less[0]
            turn = np.array([math.atan2(sine[0], cosine), *(cosine * sine - sine[0] * less)[1:]])
            magnet = np.array([x * unit, up * unit, turn]) / [1.0, force, unit]
            return BentPin(values, moved, numbers, magnet)
    raise ContactError("a pin does not settle")


def _rolled(
    pin: PinBody, stiffness: Array, alone: Array, moved: Array, normal: float, way: float
) -> tuple[Array, Array, Array, Array]:
    """How a tip moves whose unknowns take forces by their `stiffness` `(k, k)` away from where they are
    `alone` `(k,)`; these forces; the numbers of a `BentPin` but the first; and how the forces rise with the
    normal force and with the way `(2, k)`. Newton."""
    crown = pin.radius if math.isfinite(pin.radius) else 0.0
    for _ in range(ITERATIONS):
        x, down, turn = moved
        cosine, sine = math.cos(turn), math.sin(turn)
        held = stiffness @ (np.array([x, down, cosine - 1, sine]) @ pin.tip - alone)
        slopes = np.array([pin.tip[0], pin.tip[1], cosine * pin.tip[3] - sine * pin.tip[2]])
        forces, matrix = slopes @ held, slopes @ stiffness @ slopes.T
        matrix[2, 2] -= held @ (cosine * pin.tip[2] + sine * pin.tip[3])
        pull, further, rises = forces[0], crown * (1 - cosine), crown * sine
        wanted = np.array(
            [[1.0, 0.0, further], matrix[1], matrix[2] - further * matrix[0] + rises * matrix[1]]
        )
        wanted[2, 2] += crown * (normal * cosine - pull * sine)
        missing = [
            x + crown * (turn - sine) - way,
            forces[1] - normal,
            forces[2] - pull * further + forces[1] * rises,
        ]
        if not crown:
            wanted[2], missing[2] = [0.0, 0.0, 1.0], turn
        step = np.linalg.solve(wanted, missing)
        moved = moved - step
        if np.abs(step).max() <= SETTLED**2:
            by_way, by_normal = np.linalg.inv(wanted).T[:2]
            sinks = np.array([0.0, 1.0, -rises])
            numbers = pull, down - further, matrix[0] @ by_normal, matrix[0] @ by_way, sinks @ by_normal
            slope = np.array([by_normal, by_way]) @ slopes @ stiffness
            return moved, held, np.array(numbers), slope
    raise ContactError("a crown does not roll on")


@dataclass(frozen=True, eq=False)
class BentPins:
    """n pins in squares of the tables of `cells`, k heights: `square` `(2, n)` numbers its first node, by
    normal forces and by sways; `weights` `(n, k)` are those of the cells, `height` `(n,)` mm, `force` N is
    between two nodes. `tables` `(4, n, 4, 4)` are the coefficients of Hermite's functions, by normal force
    and by sway, of H, mJ, and of how magnets go along the pull and up, mm, and turn; `at_rest` `(3, n, 2)`
    the slopes of the latter three in unloaded pins. `soft` and `sinks` `(n,)` mm/N are what an unloaded pin
    gives way across and along its axis; `off` `(2, n)` by how much the pull, N, and the sinking, mm, may be
    off between nodes, beside MIXED."""

    cells: tuple[Design, ...]
    weights: Array
    height: Array
    force: float
    square: Index
    tables: Array
    at_rest: Array
    soft: Array
    sinks: Array
    off: Array

    def sway(self, normal: Array, pull: Array) -> tuple[Array, Array]:
        """Return where in their squares pins are under normal forces and pulls `(n,)` N, `(2, n)` by normal
        force and sway, 0 to 1 inside; and there H and its derivatives by these: u, v, uu, uv and vv
        `(6, n)`."""
        u, step = normal / self.force - self.square[0], SWAY * self.height
        v, first = pull * self.soft / step - self.square[1], step**2 / self.soft
        for _ in range(4 * ITERATIONS):
            energy = _hermite(self.tables[0], u, v)
            change = (pull * step - energy[2]) / np.maximum(energy[5], FIRM * first)
            v = v + change
            if np.abs(change).max() <= SETTLED**2:
                return np.array([u, v]), energy
        raise ContactError("a pin's sway does not settle")

    def magnets(self, forces: Array) -> Array:
        """Return what finite strain adds to how magnets go and turn `(n, 6)`, mm and rad, under forces on the
        tips `(n, 3)` N."""
        normal, pull = -forces[:, 2], np.hypot(*forces[:, :2].T)
        (u, v), _ = self.sway(normal, pull)
        small = np.stack([normal / self.force, pull * self.soft / (SWAY * self.height)], axis=1)
        linear = (self.at_rest * small).sum(axis=2)
        way, up, turn = [_hermite(table, u, v)[0] for table in self.tables[1:]] - linear
        x, y = np.divide(forces[:, :2].T, pull, out=np.zeros((2, pull.size)), where=pull > 0)
        return np.stack([way * x, way * y, up, -turn * y, turn * x, 0 * up], axis=1)

    def tips_over(self, normal: Array, pull: Array) -> Array:
        """Return which pins `(n,)` have no more stiffness."""
        return np.asarray(self.sway(normal, pull)[1][5] * self.soft < FIRM * (SWAY * self.height) ** 2)

    def bending(self, normal: Array, pull: Array) -> Bending:
        """Return what finite strain adds under normal forces and pulls `(n,)` N."""
        (_, v), (stored, u_slope, _, uu, uv, vv) = self.sway(normal, pull)
        step, force = SWAY * self.height, self.force
        vv = np.maximum(vv, FIRM * step**2 / self.soft)
        sinking = -u_slope / force
        small = (self.soft * pull**2 + self.sinks * normal**2) / 2
        return Bending(
            way=(self.square[1] + v) * step - self.soft * pull,
            sinking=sinking - self.sinks * normal,
            by_pull=step**2 / vv - self.soft,
            by_normal=-uv / vv * step / force,
            sinking_by_normal=(uv**2 / vv - uu) / force**2 - self.sinks,
            stored=stored + normal * sinking - small,
        )

    def followed(self, normal: Array, pull: Array) -> BentPins | None:
        """Return the pins in the next squares, one further each way, where some are beyond theirs; None where
        none is. Raises ContactError for a square that has no equilibria."""
        at = self.sway(normal, pull)[0]
        move = (at > 1 + MARGIN).astype(int) - ((at < -MARGIN) & (self.square > 0))
        return self.moved(self.square + move) if move.any() else None

    def moved(self, square: Index) -> BentPins:
        """Return the pins in other squares `(2, n)`."""
        heights = np.array([skin_of(cell).heights[0] for cell in self.cells])
        step, ends = SWAY * heights, tuple(product((0, 1), repeat=2))
        scale = np.array([0 * step + 1, step, 0 * step + self.force, self.force * step])[:, None]
        tables, off = np.empty((4, len(square.T), 4, 4)), np.empty((2, len(square.T)))
        for i, j in np.unique(square, axis=1).T.tolist():
            pins = (square == [[i], [j]]).all(axis=0)
            table, curved = np.empty((4, heights.size, 4, 4)), np.empty((2, heights.size, 4))
            for place, (a, b) in enumerate(ends):
                nodes = [bent_pin(cell, self.force, i + a, j + b) for cell in self.cells]
                stored, pull, sinks, by_normal, by_way, sinks_more = np.array([n.numbers for n in nodes]).T
                gone, by_force, by_sway = np.array([n.magnet for n in nodes]).T
                mixed = [by_normal, *(0 * gone)]  # of magnets it is left out: 2e-4 of a way
                rows = np.array([[stored, *gone], [pull, *by_sway], [-sinks, *by_force], mixed])
                slopes = (rows * scale).reshape(2, 2, 4, -1)
                table[:, :, 2 * a : 2 * a + 2, 2 * b : 2 * b + 2] = np.moveaxis(slopes, (0, 1), (2, 3))
                curved[:, :, place] = -sinks_more * self.force**2, by_way * step**2
            for place, (a, b) in enumerate(ends):
                corner = np.tile([[float(a)], [float(b)]], heights.size)
                curved[:, :, place] -= _hermite(table[0], *corner)[[3, 5]]
            weights = self.weights[pins]
            tables[:, pins] = np.einsum("nk,qkab->qnab", weights, table)
            worst = OFF * np.abs(np.einsum("nk,ckp->cnp", weights, curved)).max(axis=2)
            off[:, pins] = worst[1] / (SWAY * self.height[pins]), worst[0] / self.force
        return replace(self, square=square, tables=tables, off=off)


def bent_pins(cells: PinCells, height: Array) -> BentPins:
    """Return unloaded pins of these heights `(n,)` mm, on a base of their mean thickness."""
    designs = tuple(row[len(row) // 2].design for row in cells.cells)
    ends, none = [limits(cell) for cell in designs], np.zeros(0)
    force = min(min(STRAIN * end.squeeze, OF_BUCKLING * end.buckling) for end in ends)
    first = np.array([bent_pin(cell, force, 0, 0).numbers for cell in designs])
    by_sway = first[:, 4] * np.array([skin_of(cell).heights[0] for cell in designs]) ** 2
    weights = cells.by_height
    soft, sinks = height**2 / (weights @ by_sway), weights @ first[:, 5]
    square = np.zeros((2, height.size), dtype=np.int64)
    pins = BentPins(designs, weights, height, force, square, none, none, soft, sinks, none).moved(square)
    return replace(pins, at_rest=pins.tables[1:, :, [1, 0], [0, 1]])


def _hermite(coefficients: Array, u: Array, v: Array) -> Array:
    """A bicubic of `(n, 4, 4)` coefficients and its derivatives `(6, n)` by u, v, uu, uv and vv; beyond 0 to
    1 what these say where it ends, along u for a square more."""
    ends = [np.clip(at, 0.0, 1.0) for at in (u, v)]
    by_u, by_v = (np.einsum("dfp,pn->dnf", HERMITE, at ** np.arange(4)[:, None]) for at in ends)
    orders = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
    value, one, other, uu, uv, vv = (
        np.einsum("na,nab,nb->n", by_u[i], coefficients, by_v[j]) for i, j in orders
    )
    du, dv = np.clip(u - ends[0], -1.0, 1.0), v - ends[1]
    value = value + one * du + other * dv + (uu * du**2 + 2 * uv * du * dv + vv * dv**2) / 2
    return np.array([value, one + uu * du + uv * dv, other + uv * du + vv * dv, uu, uv, vv])
