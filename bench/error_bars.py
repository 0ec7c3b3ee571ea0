"""How honest error bars are: stated errors of random designs against those that a better refinement shows.

A design's force is drawn too: one at which ridges that shared it evenly were strained by 0.3 to 5 %. The part
of an error that is the mesh's is held against the refinement above on the same model, the part that is the
model's against the model above; on every tenth seed both against the top refinement: two refinements may
share one bias.

`python -m bench.error_bars ROWS.jsonl` solves the seeds that the file does not have yet, the dearest last,
and prints the table. Which: `--first SEED --seeds N`; without what is dear, solids and free ends: `--plane`.
`--picture PNG` draws the calibration plot.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from time import perf_counter
from typing import TypeVar

import numpy as np

from bench import runner
from bench.campaign.random_designs import drawn
from skincad.base import Array, Estimate, InputError, RefusedError
from skincad.inputs import Design
from skincad.inputs.material import silicone
from skincad.mechanics import (
    Answer,
    LeftOut,
    Pad,
    Request,
    free_ends,
    pad_of,
    plane_piece,
    small_strain_violation,
)
from skincad.mechanics import finite_strain as small_strain
from skincad.mechanics.models import corrected, finite_strain, linear, solid, winkler
from skincad.mechanics.models.linear import REFINEMENTS, level

STRAINS = 0.003, 0.05  # of ridges that share the force evenly
TOPS = 10  # every tenth seed is held against the top refinement too
NOTHING = 1e-9  # of the force (or mm per N); an F9 that is rounding
ABOVE = 2  # refinements 0 and 1 share order 3: what they are held against has order 4 at least
FINITE = 20  # every twentieth against finite strain
TOLERANCES = 0.05, 5e-3  # of the mesh: the coarsest refinement, and the one that `check` takes
SINGLE = "all_touch_force", "approach"
QUANTITIES = (*SINGLE, "shares")
T = TypeVar("T")
# By quantity: force `(1,)` N, approach `(1,)` mm, shares `(ridges,)` N; None where there is none
Numbers = dict[str, Array | None]


@dataclass(frozen=True)
class Row:
    """One stated error and what it was held against: `value`, `stated` and `true` in N or mm.

    `part` is mesh, ends (free ends left out), strain (finite strain left out) or model; `against` names the
    better refinement, `top` says whether it is the ladder's last. Of the shares it is the ridge whose error
    is the most used up, and `value` is the mean share."""

    seed: int
    model: str
    part: str
    quantity: str
    value: float
    stated: float
    true: float
    against: str
    top: bool

    @property
    def held(self) -> bool:
        return self.true <= self.stated

    @property
    def width(self) -> float:
        """Stated against true error."""
        return self.stated / self.true if self.true else math.inf


@dataclass(frozen=True)
class Outcome:
    """What a seed gave: its rows, what was refused and why, and the seconds it took."""

    seed: int
    rows: tuple[Row, ...]
    refused: dict[str, str]
    seconds: float


def force_of(design: Design, seed: int) -> float:
    """Return the force, N, at which the design is asked."""
    stuff, ridge = silicone(design), design.ridge
    plane = stuff.young_modulus.value / (1 - stuff.poisson_ratio**2)
    area = ridge.count * (ridge.root_width + ridge.tip_width) / 2 * design.skin.length
    low, high = np.log(STRAINS)
    strain = float(np.exp(np.random.default_rng([seed, 7]).uniform(low, high)))
    return strain * plane * area


def outcome(seed: int, *, solids: bool = True, ends: bool = True) -> Outcome:
    """Return the rows of a seed; `solids` and `ends` say whether the dear comparisons are made."""
    began = perf_counter()
    design = drawn(seed).design
    if design.skin.curvature_radius_y is not None:
        design = design.with_(skin={"curvature_radius_y": None})  # sections are pressed as straight along y
    run = _Seed(seed, design, force_of(design, seed), seed % TOPS == 0)
    run.mesh()
    run.models(solids=solids, ends=ends)
    return Outcome(seed, tuple(run.rows), run.refused, perf_counter() - began)


class _Seed:
    """One design, its answers so far and the rows that they give."""

    def __init__(self, seed: int, design: Design, force: float, top: bool) -> None:
        self.seed, self.design, self.force, self.top = seed, design, force, top
        self.rows: list[Row] = []
        self.refused: dict[str, str] = {}
        self.linear: Answer | None = None

    def mesh(self) -> None:
        """The linear model's meshes against the refinement above, and on top seeds against the last
        refinement."""
        pad = self._tried("pad", lambda: pad_of(self.design))
        if pad is None:
            return
        solved = cache(partial(numbers_at, pad, self.force))
        for tol in TOLERANCES:
            answered = self._tried(f"linear {tol:g}", lambda tol=tol: refined_to(pad, self.force, tol))
            if answered is None:
                continue
            found, refinement = answered
            self.linear = found
            last = len(REFINEMENTS) - 1
            above = [min(max(refinement + 1, ABOVE), last)] + [last] * self.top
            for i in dict.fromkeys(i for i in above if i > refinement):
                name = f"fineness {REFINEMENTS[i].fineness:g}, order {REFINEMENTS[i].order}"
                truth = self._tried(name, lambda i=i: solved(i))
                if truth is not None:
                    self._add(f"linear, tol {tol:g}", "mesh", found, errors(found), truth, name, i == last)

    def models(self, *, solids: bool, ends: bool) -> None:
        plane, request = self.linear, Request(self.force, TOLERANCES[-1])
        rough = self._tried("winkler", lambda: winkler.answer(self.design, request))
        if plane is None:
            return
        if rough is not None:
            self._add("winkler", "model", rough, errors(rough), numbers(plane), "linear", False)
        if small_strain_violation(self.design, self.force, plane) or plane.fault:
            self.refused["models"] = "beyond small strain: no verdict"
            return
        if ends:
            self._ends(plane, request, solids and self.top)
        if solids and self.seed % FINITE == 0:
            finite = self._tried("finite-strain", lambda: finite_strain.answer(self.design, request))
            if finite is not None:
                bound = small_strain(self.design, plane, self.force)
                stated = relative(plane, bound)
                self._add("linear", "strain", plane, stated, numbers(finite), "finite-strain", True)

    def _ends(self, plane: Answer, request: Request, with_solid: bool) -> None:
        ends = self._tried("corrected", lambda: corrected.answer(self.design, request, fine=plane))
        if ends is None:
            return
        bound = free_ends(self.design)
        stated = relative(plane, bound)
        self._add("linear", "ends", plane, stated, numbers(ends), "corrected", False)
        whole = self._tried("solid", lambda: solid.answer(self.design, request)) if with_solid else None
        if whole is not None:
            self._add("linear", "ends", plane, stated, numbers(whole), "solid", True)
            self._add("corrected", "method", ends, errors(ends), numbers(whole), "solid", True)

    def _add(
        self, model: str, part: str, found: Answer, stated: Numbers, truth: Numbers, against: str, top: bool
    ) -> None:
        mine = numbers(found)
        for quantity in QUANTITIES:
            value, true, error = mine[quantity], truth[quantity], stated[quantity]
            if value is None or true is None:
                if (value is None) != (true is None):
                    self.refused[f"{model} {quantity}"] = f"{value} against {true}"
                continue
            if max(*value, *true) <= NOTHING * self.force or error is None:
                continue  # ridges that touch at once
            missed = np.abs(value - true)
            if quantity == "shares" and missed.max() <= NOTHING * self.force:
                continue  # one ridge carries all, or two that are each other's image a half each
            worst = int(np.argmax(missed / np.maximum(error, NOTHING * self.force)))
            rows = float(value.mean()), float(error[worst]), float(missed[worst])
            self.rows.append(Row(self.seed, model, part, quantity, *rows, against, top))

    def _tried(self, name: str, work: Callable[[], T]) -> T | None:
        try:
            return work()
        except (InputError, RefusedError) as refusal:
            self.refused[name] = str(refusal)
            return None


def numbers_at(pad: Pad, force: float, i: int) -> Numbers:
    """Return force, approach and shares by the higher order of a refinement."""
    answer = level(plane_piece(pad, REFINEMENTS[i].fineness), REFINEMENTS[i].order, force)
    first = None if answer.all_touch_force is None else np.array([answer.all_touch_force])
    shares = answer.ridge_force
    return {"all_touch_force": first, "approach": np.array([answer.approach]), "shares": shares}


def refined_to(pad: Pad, force: float, tol: float) -> tuple[Answer, int]:
    """Return the linear model's answer to a tolerance and the number of the refinement that it ended on."""
    rows: list[str] = []
    solution = linear.solve(pad, Request(force, tol), rows.append)
    ends = {f"linear model: fineness {r.fineness:g}, order {r.order}": i for i, r in enumerate(REFINEMENTS)}
    return solution, ends[rows[-1]]


def numbers(found: Answer) -> Numbers:
    return _each(found, lambda estimate: estimate.value)


def errors(found: Answer) -> Numbers:
    return _each(found, lambda estimate: estimate.error)


def relative(found: Answer, bound: LeftOut) -> Numbers:
    """Return a bound that is relative to the answer, of a share to the mean one, as N and mm."""
    parts = {"all_touch_force": bound.threshold, "approach": bound.approach, "shares": bound.share}
    known = numbers(found).items()
    return {q: None if value is None else np.full_like(value, parts[q] * value.mean()) for q, value in known}


def _each(found: Answer, of: Callable[[Estimate], float | None]) -> Numbers:
    single = {q: of(getattr(found, q)) for q in SINGLE}
    table: Numbers = {q: None if v is None else np.array([v]) for q, v in single.items()}
    shares = [of(share) for share in found.ridge_force]
    return table | {"shares": None if None in shares else np.array(shares, dtype=float)}


def groups(rows: list[Row]) -> Iterator[tuple[tuple[str, ...], list[Row]]]:
    """Yield rows by model, part, quantity and what they are held against: the refinement above or the top."""

    def key(row: Row) -> tuple[str, ...]:
        return row.model, row.part, row.quantity, "top" if row.top else "above"

    for name in dict.fromkeys(map(key, rows)):
        yield name, [row for row in rows if key(row) == name]


def table(rows: list[Row]) -> list[str]:
    lines = []
    for (model, part, quantity, against), mine in groups(rows):
        held = np.mean([row.held for row in mine])
        missed = [f"{row.seed} ({row.true:.2g} > {row.stated:.2g})" for row in mine if not row.held]
        width = float(np.median([row.width for row in mine]))
        lines.append(
            (model, part, quantity, against, len(mine), f"{held:.1%}", f"{width:.2g}", " ".join(missed))
        )
    head = ("model", "part", "of", "against", "cases", "held", "median width", "missed")
    return runner.table(head, lines)


def main() -> None:
    parser = runner.parser(__doc__)
    parser.add_argument("rows", type=Path)
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    parser.add_argument("--seeds", type=int, default=200)
    parser.add_argument("--plane", action="store_true", help="no solids, no free ends")
    parser.add_argument("--picture", type=Path)
    options = parser.parse_args()
    options.records = options.rows
    seeds = sorted(range(options.first, options.first + options.seeds), key=lambda s: (s % TOPS == 0, s))
    judge = partial(outcome, solids=not options.plane, ends=not options.plane)
    outcomes = sorted(runner.rows("error-bars", judge, seeds, options), key=lambda one: one["seed"])
    rows = [Row(**row) for one in outcomes for row in one["rows"]]
    print("\n".join(table(rows)))
    for one in outcomes:
        for name, why in one["refused"].items():
            print(f"seed {one['seed']}: {name}: {why}")
    if options.picture:
        from bench.pictures import calibration_plot

        calibration_plot(rows, options.picture)


if __name__ == "__main__":
    main()
