"""What finite strain, friction and both change on the coarse solid, against finer solids and another way.

`python -m bench.coarse_solid strain 600 630`: finite strain, as `corrected-finite-strain` has it, of random
designs with few unknowns, half a minute each. `friction 502 530`: friction 0.3 and 1, sticking and sliding
along x and y. A line tells the change and by how much it is off: of the all-touch force and of the approach
relative, of the share that is off most in mean shares; a * marks what the stated error does not hold.

`python -m bench.coarse_solid stuck plain-ridges yamada-2002 0 3 5`: the same changes by full friction, in
small strain and at finite strain, of templates and seeds; some seconds to a minute each. Their difference is
in parts of what small strain leaves out by its bound (left_out.py); models/friction.py takes LOST of it at
most. Here points never slide: one that touched at the end of a step stays, and is eliminated before the
contact is solved. The body is the one of finite strain in both cases, at rest or where it is.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import linalg, sparse
from scipy.sparse.linalg import splu

import skincad
from bench import runner
from bench.campaign.random_designs import drawn
from bench.error_bars import force_of
from skincad.base import Array, InputError, Mask, one_blas_thread
from skincad.inputs import Design
from skincad.mechanics import (
    COARSE_ERRORS,
    COARSE_LAYERS,
    COARSE_PARTS,
    SOLID_ORDER,
    SOLID_STEPS,
    ContactError,
    Correction,
    Errors,
    FrontFactors,
    Layers,
    NodalContact,
    Request,
    Ridges,
    body_of,
    coarse_sizes,
    factored,
    finite_strain,
    fronts_of,
    meshed_piece,
    pad_of,
    plain_pad,
    press,
    run,
    solve_solid,
)
from skincad.mechanics.bodies import solid_law
from skincad.mechanics.contact.frictionless import all_touch_force
from skincad.mechanics.models.solid_finite_strain import solve

MOST = 9_000  # unknowns of the coarse solid; the finer one's are ten times as many
FINER, FINENESS = Layers(0.3, 1.8, 3), 1.3
MOST_BY_FRICTION = 40_000  # unknowns of the coarse solid
COEFFICIENTS = 0.3, 1.0
STEPS, NEWTON_STEPS, RESIDUAL = 10, 25, 1e-8
PARTS = {"all touch": "threshold", "approach": "approach", "share": "share"}


def flat_design(seed: int) -> Design:
    """Return the random design of a seed, straight along y, under a flat plate at its own force."""
    design = drawn(seed).design
    flat = {"plate": {"shape": "flat"}, "force": force_of(design, seed)}
    return design.with_(skin={"curvature_radius_y": None}, contact=flat)


def compared(coarse: Correction, fine: Correction) -> list[tuple[str, float, float, float]]:
    """Return by quantity the coarse change, by how much it is off the fine one's, and its error."""
    change, truth, stated = coarse.relative, fine.relative, coarse.errors
    one, other = (
        (each.after.ridge_force - each.before.ridge_force) / each.before.ridge_force.mean()
        for each in (coarse, fine)
    )
    return [
        ("all touch", change.threshold, abs(change.threshold - truth.threshold), stated.threshold),
        ("approach", change.approach, abs(change.approach - truth.approach), stated.approach),
        ("share", change.share, float(np.abs(one - other).max()), stated.share),
    ]


def line(row: runner.Row) -> str:
    parts = (f"{name} {v:+.4f} off {off:.4f}{'*' * (off > error)}" for name, v, off, error in row["changes"])
    return f"seed {row['seed']}{row['at']}: {'; '.join(parts)}"


def by_strain(seed: int) -> runner.Row:
    """Return a seed's changes by finite strain; none of a design with many unknowns."""
    design = flat_design(seed)
    force = design.contact.force
    coarse = solve(plain_pad(design), force, {}, COARSE_LAYERS)
    if coarse.after.unknowns > MOST:
        raise InputError("unknowns", f"must be at most {MOST}", coarse.after.unknowns)
    fine = solve(pad_of(design), force, {}, FINER, fineness=FINENESS)
    coarse = replace(coarse, constant=COARSE_ERRORS, by_change=COARSE_PARTS)
    return {"seed": seed, "at": "", "changes": compared(coarse, fine)}


def by_friction(case: str) -> runner.Row:
    """Return the changes by friction of a seed and a coefficient; none of a design with many unknowns."""
    seed, mu = int(case.split(maxsplit=1)[0]), float(case.split()[1])
    design = flat_design(seed)
    force = design.contact.force
    coarse = solve_solid(plain_pad(design), mu, force)
    if coarse.before.unknowns > MOST_BY_FRICTION:
        raise InputError("unknowns", f"must be at most {MOST_BY_FRICTION}", coarse.before.unknowns)
    fine = solve_solid(pad_of(design), mu, force, (), FINER, FINENESS, SOLID_ORDER, 2 * SOLID_STEPS)
    return {"seed": seed, "at": f", {mu:g}", "changes": compared(coarse, fine)}


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
    return flat_design(int(name)) if name.isdigit() else skincad.load_design(name)


def by_sticking(name: str) -> runner.Row:
    """Return by quantity what sticking changes in small strain, at finite strain, and the bound."""
    design = design_of(name)
    small, large = (changes(design, finite=finite) for finite in (False, True))
    force = design.contact.force
    bound = finite_strain(design, run("linear", design, Request(force), {}, None), force)
    return {"name": name} | {
        what: [getattr(one, key) for one in (small, large, bound)] for what, key in PARTS.items()
    }


def sticking_line(row: runner.Row) -> str:
    words = []
    for what in PARTS:
        small, large, bound = row[what]
        words.append(f"{what} {small:+.4f}, {large:+.4f} ({(large - small) / bound:+.2f})")
    return f"{row['name']}: {'; '.join(words)}"


def main() -> None:
    parser = runner.parser(__doc__)
    parser.add_argument("kind", choices=("strain", "friction", "stuck"))
    parser.add_argument("cases", nargs="+", help="the first seed and the one to stop at; templates and seeds")
    options = parser.parse_args()
    if options.kind == "stuck":
        runner.rows("stuck-press", by_sticking, options.cases, options, sticking_line)
        return
    seeds = range(*map(int, options.cases))
    if options.kind == "strain":
        rows = runner.rows("strain", by_strain, seeds, options, line)
    else:
        cases = [f"{seed} {mu}" for seed in seeds for mu in COEFFICIENTS]
        rows = runner.rows("solid-friction", by_friction, cases, options, line)
    held = [off <= error for row in rows for *_, off, error in row["changes"]]
    print(f"held {sum(held)} of {len(held)}")


if __name__ == "__main__":
    main()
