"""What full friction changes at finite strain and in small strain: a coarse solid whose points stick.

`python -m bench.stuck_press plain-ridges yamada-2002 0 3 5`: templates and seeds of random designs; some
seconds to a minute each. Where a point touched at the end of a step it stays from then on, along x and along
y. For each, the change of the all-touch force and of the approach, relative, and of the share that changes
most, in mean shares: in small strain, at finite strain, and their difference in parts of what small strain
leaves out by its bound (left_out.py), which models/friction.py takes at most LOST of.

Another way than the package's: points never slide, what sticks is eliminated before the contact is solved,
and the body is the one of finite strain in both cases, at rest or where it is."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import linalg, sparse
from scipy.sparse.linalg import splu

import skincad
from bench import runner
from bench.table_strain import flat_design
from skincad.base import Array, Mask, one_blas_thread
from skincad.inputs import Design
from skincad.mechanics import (
    COARSE_LAYERS,
    ContactError,
    Errors,
    FrontFactors,
    NodalContact,
    Request,
    Ridges,
    body_of,
    coarse_sizes,
    factored,
    finite_strain,
    fronts_of,
    meshed_piece,
    plain_pad,
    press,
    run,
)
from skincad.mechanics.bodies import solid_law
from skincad.mechanics.contact.frictionless import all_touch_force

STEPS, NEWTON_STEPS, RESIDUAL = 10, 25, 1e-8
MOST = 16_000  # unknowns
PARTS = {"all touch": "threshold", "approach": "approach", "share": "share"}


@dataclass
class Linear:
    """The body linearised: its factors, and the compliance `(3 m, 3 m)` of the points along x, z and y."""

    coupling: Array
    small: FrontFactors
    compliance: Array


class StuckPress:
    """A pad pressed in steps, at finite strain or by its tangent at rest."""

    def __init__(self, design: Design, *, finite: bool, sticks: bool) -> None:
        pad = plain_pad(design)
        self.meshed = meshed_piece(pad, coarse_sizes(pad, 1.0))
        self.body = body = body_of(self.meshed, COARSE_LAYERS)
        self.finite, self.sticks, flat = finite, sticks, body.forms.plane.contact
        count, layers = body.forms.clamped.size, np.unique(body.along).size
        free = body.free[: body.displacements].reshape(3, count, layers)
        last = np.concatenate([flat - count, flat, flat + count])
        self.fronts, self.unknowns = fronts_of(body.forms, free, last)
        z = body.rest.contact
        self.contact = np.concatenate([z - count * layers, z, z + count * layers])
        rows = body.rest.nodes.rows
        self.rows, self.m = sparse.csr_matrix(sparse.block_diag([rows] * 3)), rows.shape[0]
        self.by_point, self.top = splu(rows.tocsc()), self.meshed.whole.top / self.meshed.unit
        self.scale = self.meshed.whole.young_modulus * self.meshed.unit**2 * 2 * self.meshed.sides
        self.sideways = np.concatenate([np.arange(self.m), np.arange(2 * self.m, 3 * self.m)])
        self.rest = np.zeros(body.free.size)
        self.at_rest = self.linearised(self.rest)

    def linearised(self, state: Array) -> Linear:
        """Return the body linearised at a state."""
        body = self.body
        at = solid_law.points(body.elements, *body.split(state))
        coupling = solid_law.coupling(at)
        stiffness = solid_law.stiffness(at, coupling)

        def inside(triangle: int):
            for element in body.of_triangle[triangle]:
                yield body.of_element[element], stiffness[element]

        small = factored(inside, self.fronts, self.unknowns, body.displacements)
        place = np.full(body.displacements, -1)
        place[small.border] = np.arange(small.border.size)
        where = place[self.contact]
        able, whole = np.flatnonzero(where >= 0), np.zeros((where.size, where.size))
        whole[np.ix_(able, able)] = small.flexibility[np.ix_(where[able], where[able])]
        compliance = np.asarray(self.rows @ (self.rows @ whole).T)
        return Linear(coupling, small, (compliance + compliance.T) / 2)

    def moved(self, linear: Linear, residual: Array, push: Array) -> Array:
        """Return the step `(n,)` that balances the body under contact forces `-push`."""
        body, count = self.body, self.body.displacements
        inner = body.elements.softening @ residual[count:].reshape(*linear.coupling.shape[:2], 1)
        load = -push[:count] - residual[:count]
        load -= body.summed(np.swapaxes(linear.coupling, 1, 2) @ inner)
        step = linear.small.solve(load)
        pressure = inner + body.elements.softening @ (linear.coupling @ step[body.of_element][:, :, None])
        return np.concatenate([step, pressure.ravel()])

    def under(
        self,
        linear: Linear,
        state: Array,
        residual: Array,
        force: float | None,
        held: Mask,
        anchors: Array,
        active: Mask | None,
    ) -> tuple[float, NodalContact, float, Array]:
        """Return force, contact, approach and push of the linearised pad; `force` None: where all touch."""
        free = self.rows @ (state + self.moved(linear, residual, 0 * state))[self.contact]
        c, t, z = linear.compliance, self.sideways[held], np.arange(self.m, 2 * self.m)
        lift, flexibility, by_normal, by_anchor = free[z], c[np.ix_(z, z)], np.zeros((0, self.m)), np.zeros(0)
        if t.size:
            sides = np.column_stack([c[np.ix_(t, z)], anchors[held] - free[t]])
            solved = linalg.solve(c[np.ix_(t, t)], sides, assume_a="sym")
            by_normal, by_anchor = solved[:, :-1], solved[:, -1]
            lift = lift + c[np.ix_(z, t)] @ by_anchor
            flexibility = flexibility - c[np.ix_(z, t)] @ by_normal
        unit = np.eye(self.body.rest.contact.size)
        ridges = Ridges.of(self.body.rest, unit, self.top)
        gap = ridges.gap - lift
        fine = ridges.fine_gap - self.body.rest.fine.rows @ self.by_point.solve(lift)
        base = float(gap.min())
        seen = replace(
            ridges, flexibility=(flexibility + flexibility.T) / 2, gap=gap - base, fine_gap=fine - base
        )
        load = force if force is not None else all_touch_force(seen, self.step_force)
        contact = press(seen.flexibility, seen.gap, load or 0.0, active)
        forces = np.zeros(3 * self.m)
        forces[z], forces[t] = -contact.force, by_anchor + by_normal @ contact.force
        push = np.zeros_like(state)
        push[self.contact] = -(self.rows.T @ forces)
        return load or 0.0, contact, contact.approach + base, push

    def solved(
        self, state: Array, force: float | None, held: Mask, anchors: Array, active: Mask | None
    ) -> tuple[Array, float, NodalContact, float]:
        """Return the equilibrium: state, force, contact and approach."""
        if not self.finite:
            load, contact, down, push = self.under(
                self.at_rest, self.rest, self.rest, force, held, anchors, active
            )
            return self.moved(self.at_rest, self.rest, push), load, contact, down
        residual, last = self.body.residual(state), np.inf
        linear = self.linearised(state)
        for _ in range(NEWTON_STEPS):
            load, contact, down, push = self.under(linear, state, residual, force, held, anchors, active)
            active, move, share = contact.active, self.moved(linear, residual, push), 1.0
            while not np.isfinite(self.body.energy(state + share * move)):
                share /= 2
            state = state + share * move
            residual = self.body.residual(state)
            size = float(np.linalg.norm((residual + push)[self.body.free]) / np.linalg.norm(push))
            if share == 1.0 and size <= RESIDUAL:
                return state, load, contact, down
            if size > 0.1 * last or size > 1e-2:
                linear = self.linearised(state)
            last = size
        raise ContactError(f"no equilibrium: {size:.1e}")

    def pressed(self, force: float) -> tuple[float, float, Array]:
        """Return all-touch force, N, approach, mm, and ridge forces, N, at `force` N."""
        able = self.at_rest.compliance.diagonal()[self.sideways]
        may = (able > 1e-9 * able.max()) & self.sticks
        held, anchors, state = np.zeros(2 * self.m, dtype=bool), np.zeros(2 * self.m), self.rest
        active, first, at_force = None, None, None
        numbers, of_point = np.unique(self.body.rest.nodes.ridge), self.body.rest.nodes.ridge
        with one_blas_thread():
            for level in (np.arange(4 * STEPS) + 1) / STEPS * force / self.scale:
                self.step_force = float(level)
                after, _, contact, down = self.solved(state, float(level), held, anchors, active)
                shares = np.array([contact.force[of_point == r].sum() for r in numbers]) * self.scale
                if first is None and shares.min() > 0:
                    first = self.solved(state, None, held, anchors, active)[1] * self.scale
                place = (self.rows @ after[self.contact])[self.sideways]
                touches = np.tile(contact.active, 2) & may
                anchors = np.where(touches & ~held, place, anchors)
                held, state, active = touches, after, contact.active
                if abs(level * self.scale - force) <= 1e-9 * force:
                    at_force = down * self.meshed.unit, shares
                if first is not None and at_force is not None:
                    return first, *at_force
        raise ContactError("not all ridges touch at four times the force")


def changes(design: Design, *, finite: bool) -> Errors:
    """Return what sticking changes: approach and all-touch force relative, the share in mean shares."""
    force = design.contact.force
    smooth, stuck = (StuckPress(design, finite=finite, sticks=s).pressed(force) for s in (False, True))
    share = np.abs(stuck[2] - smooth[2]).max() / smooth[2].mean()
    return Errors(stuck[1] / smooth[1] - 1, stuck[0] / smooth[0] - 1 if smooth[0] else 0.0, float(share))


def design_of(name: str) -> Design:
    """Return a template, or the random design of a seed."""
    return flat_design(int(name)) if name.isdigit() else skincad.load_design(name)


def judged(name: str) -> runner.Row:
    """Return by quantity what sticking changes in small strain, at finite strain, and the bound."""
    design = design_of(name)
    small, large = (changes(design, finite=finite) for finite in (False, True))
    force = design.contact.force
    bound = finite_strain(design, run("linear", design, Request(force), {}, None), force)
    return {"name": name} | {
        what: [getattr(one, key) for one in (small, large, bound)] for what, key in PARTS.items()
    }


def line(row: runner.Row) -> str:
    """Return a design's line."""
    words = []
    for what in PARTS:
        small, large, bound = row[what]
        words.append(f"{what} {small:+.4f}, {large:+.4f} ({(large - small) / bound:+.2f})")
    return f"{row['name']}: {'; '.join(words)}"


def main() -> None:
    parser = runner.parser(__doc__)
    parser.add_argument("designs", nargs="+")
    options = parser.parse_args()
    runner.rows("stuck-press", judged, options.designs, options, line)


if __name__ == "__main__":
    main()
