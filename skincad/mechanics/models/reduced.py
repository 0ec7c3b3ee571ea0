"""A pad of very many like features: each reduced to its force against indentation, the base to how far a
force on one feature lowers another.

Both are read off a short pad of the same features on the same base, the cell: in plane strain (linear.py),
with what free ends add (corrected.py). The cell is long enough for a force in its middle not to be felt at
its ends. Far from the ends of the pad features feel each other by their distance alone; near an end as near
the cell's. So

    d - gap_i = self(p_i) + sum over j of coupling_ij p_j    where p_i > 0,

a sparse system however many features there are. Only `cell_of` knows that they are ridges.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations
from operator import attrgetter
from time import perf_counter
from typing import Any

import numpy as np
from scipy import interpolate, linalg, optimize, sparse, spatial
from scipy.sparse.linalg import splu

from skincad.base.arrays import Array, Index
from skincad.base.estimate import Estimate
from skincad.base.interrupt import safe_point
from skincad.base.machine import one_blas_thread
from skincad.base.progress import Progress
from skincad.inputs.design import Design
from skincad.inputs.feature_tables import places
from skincad.inputs.material import layers, silicone
from skincad.mechanics.bodies.mesh import plane_piece
from skincad.mechanics.contact.ridge_model import check_few
from skincad.mechanics.models import linear
from skincad.mechanics.models.corrected import added_compliance
from skincad.mechanics.models.correction import Errors
from skincad.mechanics.models.pin_cell import PinCell, disc, lone, pin_cell, pin_curve
from skincad.mechanics.problem import (
    Answer,
    ContactError,
    Request,
    RidgeModel,
    check_flat,
    no_yield,
    pad_of,
)
from skincad.mechanics.validity import crown_radius, crown_rises
from skincad.shape.skin import section, skin_of

REACH = 4.0, 1.5  # thicknesses of the base, and lengths of the skin, between a feature and the cell's end
FEWEST = 15  # features of the cell, where the pad has as many
NEWTON_STEPS = 60  # ten are usual
SETTLED = 1e-10  # of the largest force
ROOT = 1e-9  # of the approach
FEW, DENSE = 300, 0.2  # features, and entries of the coupling, up to which a sparse solver is quicker
SAME = 1e-9  # relative; heights that differ by less are alike
FARTHEST = 64.0  # times the approach that closes all gaps: the search's end
FINENESS, ORDER = 1.0, 3  # of the cell's section
# Heights of which cells are solved, and thicknesses; quantities between are interpolated. For ratios of
# forces a line is enough: exponents of pins-dome differ by 0.03 at most (tests/mechanics/test_manufacture.py)
MOST_NODES, ROUGH_NODES = (4, 3), (2, 2)
ERRORS = Errors(approach=0.03, threshold=0.1, share=0.12)  # against the corrected model
# Of pins against CalculiX: the base's edges and roots count; on softer layers more, as `further` says
PIN_ERRORS = Errors(approach=0.08, threshold=0.08, share=0.12)
# A base whose side is less than so many roots gives way more than the cell's, which has no edges: off by up
# to twice these errors, as an outside check of single pins found
NARROW, NARROWER = 2.1, 2.5


@dataclass(frozen=True)
class FeatureModel:
    """`gap` `(n,)` mm of each feature from the plate when it first touches; `force` and `indentation` `(t,)`,
    N and mm, of one alone; `coupling` `(n, n)` mm/N."""

    gap: Array
    force: Array
    indentation: Array
    coupling: sparse.csr_matrix

    def alone(self, indentation: Array) -> tuple[Array, Array]:
        """Return force, N, and slope, N/mm, of a feature alone at indentations, mm: smooth, and straight
        beyond the table."""
        force, slope_of = self._smooth
        end = float(self.indentation[-1])
        inside = np.clip(indentation, 0.0, end)
        slope = np.where(indentation > 0, slope_of(inside), 0.0)
        return force(inside) + slope * np.maximum(indentation - end, 0.0), slope

    def lowered(self, drops: tuple[float, ...]) -> FeatureModel:
        """Return the pad of a part whose crests lie lower than drawn by `drops` `(n,)` mm, or () for none."""
        gap = self.gap + (np.array(drops) if drops else 0.0)
        return replace(self, gap=gap - gap.min())

    def ridge_model(self) -> RidgeModel:
        """Return it as the model of a yield: how each feature gives way itself goes into its own table.

        Raises ContactError for more features than that takes."""
        check_few(self.gap.size)
        coupling = self.coupling.toarray()
        table = self.indentation + coupling.diagonal()[:, None] * self.force
        np.fill_diagonal(coupling, 0.0)
        return RidgeModel(self.gap, coupling, self.force, table, 1.0, 1.0)

    @cached_property
    def _smooth(self) -> tuple[Any, Any]:
        """The table's interpolation, and its derivative."""
        force = interpolate.PchipInterpolator(self.indentation, self.force)
        return force, force.derivative()


def answer(design: Design, request: Request, progress: Progress | None = None) -> Answer:
    """Return the reduced model's verdict on a design; strains are taken as small."""
    check_flat(design.contact.plate, "reduced", "corrected")
    seconds: dict[str, float] = {}
    if progress:
        progress("reduced model: a short pad of the same features")
    model = feature_model(design, request.force, seconds, rough=request.rough).lowered(request.crest_offsets)
    began = perf_counter()
    pins = skin_of(design).family == "pin"
    with one_blas_thread() if pins else nullcontext():  # on a busy machine more take ten times as long
        forces, approach = pressed(model, request.force)
        first = all_touch_force(model)
    parts, warnings = None, list[str]()
    if request.ridge_model and pins and forces.size > 1:
        try:
            parts = model.ridge_model()
        except ContactError as failure:  # the verdict does not need the yield's model
            warnings.append(no_yield(failure))
    seconds["reduced"] = perf_counter() - began
    known, wider = PIN_ERRORS if pins else ERRORS, further(design)
    if pins and min(design.skin.width, design.skin.length) < NARROW * skin_of(design).profile.root_width:
        wider *= NARROWER
    error = wider * known.share * request.force / forces.size
    return Answer(
        touching=int(np.count_nonzero(forces > 0)),
        all_touch_force=Estimate(first, wider * known.threshold * first, "N"),
        approach=Estimate(approach, wider * known.approach * approach, "mm"),
        ridge_force=tuple(Estimate(float(force), error, "N") for force in forces),
        unknowns=forces.size,
        residual=SETTLED,
        seconds=seconds,
        warnings=tuple(warnings),
        ridge_model=parts,
    )


def cell_of(design: Design) -> Design:
    """Return the design with as few features as feel each other, as far from the ends of its base."""
    skin = skin_of(design)
    far = max(REACH[0] * design.skin.thickness, REACH[1] * design.skin.length)
    reach = math.ceil(far / skin.pitch)
    count = max(2 * reach + 1, FEWEST)
    if count >= skin.count:
        return design
    shorter = (skin.count - count) * skin.pitch
    return design.with_(ridge={"count": count}, skin={"width": design.skin.width - shorter})


def further(design: Design) -> float:
    """Return how much further a load is felt where a layer lies on a softer one, and so how much more the
    ends of the base change: a plate on springs bends over a length that grows with the fourth root of its
    modulus over theirs. Timoshenko and Woinowsky-Krieger, Theory of Plates and Shells, 2nd ed., sec. 57."""
    moduli = [stuff.young_modulus.value for stuff in (*layers(design), silicone(design))]
    return math.sqrt(math.sqrt(max([1.0, *(front / back for back, front in combinations(moduli, 2))])))


def feature_model(
    design: Design, force: float, seconds: dict[str, float], *, ends: bool = True, rough: bool = False
) -> FeatureModel:
    """Return the reduced pad of a design for forces of about `force` N; without `ends` in plane strain."""
    if skin_of(design).standing:
        began = perf_counter()
        model = pin_model(design, rough=rough)
        seconds["cell"] = perf_counter() - began
        return model
    cell = cell_of(design)
    few, many = skin_of(cell).count, skin_of(design).count
    began, share, pad = perf_counter(), force * few / many, pad_of(cell)
    best = linear.level(plane_piece(pad, FINENESS), ORDER, share)
    parts = linear.reduced_model(pad, best, share, {})
    seconds["cell"] = perf_counter() - began
    coupling = parts.coupling * (parts.unit / parts.scale)
    if ends:
        began = perf_counter()
        coupling = coupling + added_compliance(cell)
        seconds["solid"] = perf_counter() - began
    tops = np.full(many, -np.inf)
    for segment in section(design).outline:
        if segment.touches and segment.feature is not None:
            tops[segment.feature - 1] = max(tops[segment.feature - 1], segment.top)
    return FeatureModel(
        gap=tops.max() - tops,
        force=parts.force * parts.scale,
        indentation=parts.indentation[few // 2] * parts.unit,
        coupling=repeated(coupling, many),
    )


# Relative, from which values on cells are solved at three, and at four: by a line over a tenth a stiffness by
# the cube of the height is 0.8 % off
SPREADS = 0.1, 0.3


@dataclass(frozen=True)
class PinCells:
    """The cells of a design's pins: `cells[i][j]` at `nodes` of height and thickness, mm; `axial`, `across`
    and `magnet` `(n, ...)` are each pin's of `PinCell`, `thick` mm the base's thickness under it; `by_height`
    `(n, heights)` are weights of the cells of all heights in a pin's numbers."""

    cells: list[list[PinCell]]
    nodes: list[Array]
    thick: Array
    axial: Array
    across: Array
    magnet: Array
    by_height: Array

    @property
    def stiffest(self) -> PinCell:
        """The cell whose curve is taken."""
        return min((cell for row in self.cells for cell in row), key=lambda cell: cell.axial)

    @property
    def middle(self) -> int:
        """Place of the cells whose base stands for that of all heights."""
        return len(self.cells) // 2

    def at_pairs(self, of: Callable[[PinCell], Array], first: Index, second: Index) -> Array:
        """A number of the cells, or several, of pairs of pins, on a base of both pins' mean thickness."""
        weights = _lagrange(self.nodes[1], (self.thick[first] + self.thick[second]) / 2)
        return np.asarray(np.einsum("kt,tk...->k...", weights, [of(c) for c in self.cells[self.middle]]))


def pin_cells(design: Design, rough: bool = False) -> PinCells:
    """Solve the cells of a design's pins, in small strain; `rough`, at most two ways."""
    at = np.array(skin_of(design).heights), base_thicknesses(design)
    nodes = [_nodes(*one) for one in zip(at, ROUGH_NODES if rough else MOST_NODES, strict=True)]
    cells = [[pin_cell(lone(design, float(h), float(t))) for t in nodes[1]] for h in nodes[0]]
    axial, across, magnet = (
        _interpolated(nodes, np.array([[of(cell) for cell in row] for row in cells]), at)
        for of in (attrgetter("axial"), attrgetter("across"), attrgetter("magnet"))
    )
    return PinCells(cells, nodes, at[1], axial, across, magnet, _lagrange(nodes[0], at[0]))


def pin_model(design: Design, *, stuck: bool = False, rough: bool = False) -> FeatureModel:
    """Return the reduced pad of pins, in small strain, on a base without edges; with tips that are `stuck` to
    a plate that keeps its place, each by itself.

    The curve is that of the stiffest cell. What a pin gives way more by its height, by the base's thickness
    under it and by its lean stands on the diagonal of `coupling`. Pins feel each other by their distance, as
    on a base of the mean thickness under both; a pin's own root does not stiffen the base for its neighbours.
    """
    cells, skin = pin_cells(design, rough), skin_of(design)
    stiffest = cells.stiffest
    foot, (first, second) = _feet(design, cells)
    distance = np.linalg.norm(foot[first] - foot[second], axis=1)
    root = skin.profile.root_width / 2
    values = cells.at_pairs(lambda cell: cell.sinking(distance, root), first, second)
    everyone, tips = np.arange(skin.count), tip_compliances(design, cells)
    alone = tips[:, 2, 2]
    if stuck:
        held = np.linalg.solve(tips[:, :2, :2], tips[:, :2, 2:])[..., 0]
        alone = alone - (tips[:, 2, :2] * held).sum(axis=1)
    entries = np.concatenate([values, values, alone - stiffest.axial])
    index = np.concatenate([first, second, everyone]), np.concatenate([second, first, everyone])
    tops, (force, indentation) = pin_tops(design), pin_curve(stiffest.design)
    return FeatureModel(
        gap=tops.max() - tops,
        force=force,
        indentation=indentation,
        coupling=sparse.csr_matrix((entries, index), shape=(skin.count, skin.count)),
    )


def _feet(design: Design, cells: PinCells) -> tuple[Array, Index]:
    """Where pins stand `(n, 3)` mm, and the pairs of them `(2, pairs)` that feel each other."""
    foot = np.array([placed.foot for placed in skin_of(design).placed])
    reach = float(cells.stiffest.radius[-1])
    return foot, spatial.cKDTree(foot).query_pairs(reach, output_type="ndarray").T


def tip_compliances(design: Design, cells: PinCells) -> Array:
    """Return how far each pin's contact moves under forces on it, along x, y and z `(n, 3, 3)` mm/N, beside
    the contact's half-space. A flat tip does not turn on the plate."""
    many, across, turn = cells.axial.size, cells.across, moments(design)
    axis = np.array([placed.axis for placed in skin_of(design).placed])
    along = np.einsum("ni,nj->nij", axis, axis)
    by_force = across[:, 0, 0]
    if not math.isfinite(crown_radius(design)):
        by_force = by_force - across[:, 0, 1] ** 2 / across[:, 1, 1]
    parts = (
        (cells.axial, along),
        (by_force, np.eye(3) - along),
        (across[:, 0, 1], turn + turn.transpose(0, 2, 1)),
        (across[:, 1, 1], turn.transpose(0, 2, 1) @ turn),
    )
    return np.asarray(sum(factor.reshape(many, 1, 1) * matrix for factor, matrix in parts))


def _cross(vectors: Array) -> Array:
    """The matrices `(n, 3, 3)` of vector products from the left."""
    return np.asarray(np.cross(vectors[:, None, :], np.eye(3)[None], axis=2).transpose(0, 2, 1))


def tip_compliance(design: Design, cells: PinCells) -> Array:
    """Return the compliance `(3 n, 3 n)` mm/N of all pins' contacts under forces on them, all along x, then
    y, then z, beside their half-spaces: each pin's, and how pins feel each other through the base."""
    many, heights = cells.axial.size, np.array(skin_of(design).heights)
    first, second, blocks, slope = _through_base(design, cells)
    blocks[:, :2] -= heights[first, None, None] * slope
    whole = np.zeros((3, many, 3, many))
    whole[:, first, :, second] = blocks
    everyone = np.arange(many)
    whole[:, everyone, :, everyone] = tip_compliances(design, cells)
    matrix = whole.reshape(3 * many, 3 * many)
    return np.asarray((matrix + matrix.T) / 2)


def magnet_compliance(design: Design, cells: PinCells) -> Array:
    """Return how each pin's magnet goes under forces on all pins' tips, `(n, 6, n, 3)`: along x, y and z,
    mm/N, and turned about them, 1/N.

    It goes with its pin, and with the base that the other pins move, as far as its middle is above the base.
    """
    many, (low, high) = cells.axial.size, design.features.pocket.magnet_span  # type: ignore[union-attr]
    axis = np.array([placed.axis for placed in skin_of(design).placed])
    along = np.einsum("ni,nj->nij", axis, axis)
    pull, moment = np.eye(3) - along, moments(design)
    if not math.isfinite(crown_radius(design)):  # a flat tip does not turn on the plate
        moment = -(cells.across[:, 0, 1] / cells.across[:, 1, 1])[:, None, None] * pull
    up, out, tilt, out_by, tilt_by = cells.magnet.T[:, :, None, None]
    first, second, blocks, slope = _through_base(design, cells)
    level = np.maximum((low + high) / 2 - base_thicknesses(design), 0.0)
    blocks[:, :2] -= level[first, None, None] * slope
    whole = np.zeros((many, 6, many, 3))
    whole[first, :3, second] = blocks
    whole[first, 3, second], whole[first, 4, second] = slope[:, 1], -slope[:, 0]
    everyone = np.arange(many)
    whole[everyone, :3, everyone] = up * along + out * pull + out_by * moment
    whole[everyone, 3:, everyone] = _cross(axis) @ (tilt * pull + tilt_by * moment)
    return whole


def moments(design: Design) -> Array:
    """Return the moment across each pin's axis that forces on its tip make, by which they lift a side, per
    force `(n, 3, 3)` mm: a force on a leaning pin acts where its tip is highest."""
    radius, axis = crown_radius(design), np.array([placed.axis for placed in skin_of(design).placed])
    arm = radius * (np.array([0.0, 0.0, 1.0]) - axis) if math.isfinite(radius) else 0 * axis
    return _cross(axis) @ _cross(arm)


def _through_base(design: Design, cells: PinCells) -> tuple[Index, Index, Array, Array]:
    """The pairs of pins that feel each other, and how the first's root goes under forces on the second:
    moves `(k, 3, 3)` mm/N, and its slope along x and y `(k, 2, 3)` 1/N.

    A pin's root goes as the base's surface would, the mean over it, and turns as that does. The base is
    taken as level between two pins.
    """
    skin = skin_of(design)
    foot, pairs = _feet(design, cells)
    first, second = np.concatenate([pairs, pairs[::-1]], axis=1)
    ring, angle = disc()
    root = skin.profile.root_width / 2
    points = root * np.stack([ring * np.cos(angle), ring * np.sin(angle)], axis=1)
    away = foot[first, None, :2] - foot[second, None, :2] + points
    distance = np.linalg.norm(away, axis=2)
    heights, nodes = np.array(skin.heights), cells.nodes[0]
    taller = (heights[second] - nodes[cells.middle])[:, None]

    def moves(cell: PinCell) -> Array:
        """Outward and up by a push, outward, up and round by a pull `(k, 5, points)`."""
        push, pull, by_moment = cell.by_push, *cell.by_pull
        rows = (np.interp(distance, cell.radius, row, right=0.0) for row in (*push, *pull, *by_moment))
        out, up, *pulls = rows
        return np.stack([out, up, *(pulls[i] - taller * pulls[i + 3] for i in range(3))], axis=1)

    out, up, pulled_out, pulled_up, pulled_round = cells.at_pairs(moves, first, second).transpose(1, 0, 2)
    way = away / distance[:, :, None]
    field = np.zeros((first.size, ring.size, 3, 3))  # of a displacement, by a force
    spread = (pulled_out + pulled_round)[..., None, None] * way[..., :, None] * way[..., None, :]
    field[..., :2, :2] = spread - pulled_round[..., None, None] * np.eye(2)
    field[..., 2, :2] = pulled_up[..., None] * way
    field[..., :2, 2] = -out[..., None] * way
    field[..., 2, 2] = -up
    slope = np.einsum("qa,kqj->kaj", points, field[:, :, 2]) / (points**2).sum(axis=0)[:, None]
    return first, second, field.mean(axis=1), slope


def base_thicknesses(design: Design) -> Array:
    """Return the base's thickness under each feature `(n,)` mm, before the second curvature's turn."""
    base = design.skin
    along = np.array([base.arm(at.u, at.v) for at in places(base, design.features)])
    return np.asarray(
        base.thickness - 2 * base.curvature_radius * np.sin(along / base.curvature_radius / 2) ** 2
    )


def pin_tops(design: Design) -> Array:
    """Return the height of each pin's highest point `(n,)` mm: on its crown, or where it leans more on the
    crown's edge."""
    return np.array([placed.tip[2] for placed in skin_of(design).placed]) + crown_rises(design)


def _nodes(values: Array, most: int) -> Array:
    """At most so many values to solve at, all if there are no more; fewer where they are close."""
    distinct = np.unique(values)
    low, high = distinct[0], distinct[-1]
    spread = (high - low) / high
    if spread <= SAME:
        return np.array([(low + high) / 2])
    most = min(most, sum(spread > step for step in SPREADS) + 2)
    return distinct if distinct.size <= most else np.linspace(low, high, most)


def _lagrange(nodes: Array, at: Array) -> Array:
    """Weights `(n, nodes)` of the polynomial through all nodes at `at` `(n,)`."""
    factors = [
        np.prod([(at - other) / (node - other) for other in nodes if other != node], axis=0)
        * np.ones_like(at)
        for node in nodes
    ]
    return np.array(factors).T


def _interpolated(nodes: list[Array], values: Array, at: tuple[Array, Array]) -> Array:
    """Values `(heights, thicknesses, ...)` at nodes, for features `at` heights and thicknesses `(n,)`."""
    by_height, by_thickness = (_lagrange(node, x) for node, x in zip(nodes, at, strict=True))
    return np.asarray(np.einsum("ni,nj,ij...->n...", by_height, by_thickness, values))


def repeated(coupling: Array, many: int) -> sparse.csr_matrix:
    """Return the coupling `(many, many)` of a longer pad from its cell's `(few, few)`.

    A pair is coupled as the cell's of the same distance, by the mean of both features' places there: as near
    to an end, or in the middle. Beyond half the cell nothing is felt.
    """
    few, number, reach = len(coupling), np.arange(many), len(coupling) // 2
    from_end = many - 1 - number
    # which of the cell's features each is like: as near to an end, or the middle one
    place = np.where(number < reach, number, np.where(from_end < reach, few - 1 - from_end, reach))

    def coupled(at: Index, distance: int) -> Array:
        """The cell's coupling of features `at` `(k,)` with those so far on; 0 beyond its end."""
        there = at + distance
        inside = (there >= 0) & (there < few)
        return np.where(inside, coupling[at, np.where(inside, there, 0)], 0.0)

    rows, columns, values = [], [], []
    for offset in range(-reach, reach + 1):
        first = np.arange(max(0, -offset), many - max(0, offset))
        rows.append(first)
        columns.append(first + offset)
        values.append((coupled(place[first], offset) + coupled(place[first + offset], -offset)) / 2)
    entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
    return sparse.csr_matrix(entries, shape=(many, many))


def at_approach(model: FeatureModel, approach: float) -> tuple[Array, Array]:
    """Return forces, N, and indentations, mm, `(n,)` where the plate came down by `approach` mm; negative
    indentations are gaps. Semi-smooth Newton, damped where it does not approach."""
    n = model.gap.size
    forces, whole = np.zeros(n), model.coupling.toarray() if n > FEW else np.zeros((0, 0))
    last, share = math.inf, 1.0
    for _ in range(NEWTON_STEPS):
        safe_point()
        indentation = approach - model.gap - model.coupling @ forces
        wanted, slope = model.alone(indentation)
        off = wanted - forces
        size = float(np.abs(off).max())
        if size <= SETTLED * max(float(forces.max()), float(wanted.max()), 1e-300):
            return forces, indentation
        share = min(1.0, 2 * share) if size < last else share / 2
        last = size
        if model.coupling.nnz > DENSE * n**2 and n > FEW:
            forces = forces + share * linalg.solve(np.eye(n) + slope[:, None] * whole, off)
            continue
        matrix = sparse.identity(n, format="csc") + sparse.diags(slope) @ model.coupling
        forces = forces + share * splu(sparse.csc_matrix(matrix)).solve(off)
    raise ContactError("the reduced features do not settle; take a smaller force")


def pressed(model: FeatureModel, force: float) -> tuple[Array, float]:
    """Return the forces `(n,)`, N, and the approach, mm, under a total force."""
    approach = _root(model, lambda forces, _: float(forces.sum()) - force)
    return at_approach(model, approach)[0], approach


def all_touch_force(model: FeatureModel) -> float:
    """Return the smallest force, N, under which every feature touches; 0 for one."""
    if model.gap.size == 1:
        return 0.0
    approach = _root(model, lambda _, indentation: float(indentation.min()))
    return float(at_approach(model, approach)[0].sum())


def _root(model: FeatureModel, missing: Callable[[Array, Array], float]) -> float:
    """The approach, mm, at which `missing(forces, indentations)` is 0; it rises with the approach."""
    gap, end = float(np.ptp(model.gap)), float(model.indentation[-1])
    doubled = [start * 2**k for start in (gap, end) if start for k in range(round(math.log2(FARTHEST)))]
    high = next((d for d in doubled if missing(*at_approach(model, d)) > 0), 0.0)
    if not high:
        raise ContactError("no approach brings all features into contact")
    return float(optimize.brentq(lambda d: missing(*at_approach(model, d)), 0.0, high, xtol=ROOT * high))
