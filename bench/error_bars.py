"""How honest error bars are: the stated error of random designs against the error that a better rung shows.

A design's force is drawn too: one at which ridges that shared it evenly were strained by 0.3 to 5 %. The part
of an error that is the mesh's is held against the rung above on the same model, the part that is the model's
against the model above; on every tenth seed both against the top rung: two rungs may share one bias.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from time import perf_counter
from typing import TypeVar

import numpy as np

from bench.campaign.random_designs import drawn
from skincad.base.errors import InputError, RefusedError
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.mechanics.bodies.meshed import plane_piece
from skincad.mechanics.left_out import finite_strain as small_strain
from skincad.mechanics.left_out import free_ends
from skincad.mechanics.problem import Answer, Pad, Request, pad_of
from skincad.mechanics.tiers import corrected, finite_strain, linear, solid, winkler
from skincad.mechanics.tiers.linear import RUNGS
from skincad.mechanics.tiers.plane_level import level
from skincad.mechanics.validity import beyond_small_strain

STRAINS = 0.003, 0.05  # of ridges that share the force evenly
TOPS = 10  # every tenth seed is held against the top rung too
NOTHING = 1e-9  # of the force (or mm per N); an F9 that is rounding
ABOVE = 2  # rungs 0 and 1 share order 3: what they are held against has order 4 at least
FINITE = 20  # every twentieth against finite strain
TOLERANCES = 0.05, 5e-3  # of the mesh: the coarsest rung, and the one that `check` takes
QUANTITIES = ("all_touch_force", "approach")
T = TypeVar("T")


@dataclass(frozen=True)
class Row:
    """One stated error and what it was held against: `value`, `stated` and `true` in N or mm.

    `part` is mesh, ends (free ends left out), strain (finite strain left out) or model; `against` names the
    better rung, `top` says whether it is the ladder's last.
    """

    seed: int
    tier: str
    part: str
    quantity: str
    value: float
    stated: float
    true: float
    against: str
    top: bool

    @property
    def held(self) -> bool:
        """Whether the true error lies within the stated one."""
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

    def as_json(self) -> dict[str, object]:
        """Return all fields as plain data."""
        return asdict(self)


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
        self.finest: dict[str, float | None] = {}

    def mesh(self) -> None:
        """The linear tier's meshes against the rung above, and on top seeds against the last rung."""
        pad = self._tried("pad", lambda: pad_of(self.design))
        if pad is None:
            return
        solved = _Levels(pad, self.force)
        for tol in TOLERANCES:
            answered = self._tried(f"linear {tol:g}", lambda tol=tol: climbed(pad, self.force, tol))
            if answered is None:
                continue
            found, rung = answered
            self.linear = found
            last = len(RUNGS) - 1
            above = [min(max(rung + 1, ABOVE), last)] + [last] * self.top
            for i in dict.fromkeys(i for i in above if i > rung):
                name = f"fineness {RUNGS[i].fineness:g}, order {RUNGS[i].order}"
                truth = self._tried(name, lambda i=i: solved.numbers(i))
                if truth is not None:
                    self.finest = truth
                    stated = {q: getattr(found, q).error for q in QUANTITIES}
                    self._add(f"linear, tol {tol:g}", "mesh", found, stated, truth, name, i == last)

    def models(self, *, solids: bool, ends: bool) -> None:
        """What the models leave out, against the models that know it."""
        plane, request = self.linear, Request(self.force, TOLERANCES[-1])
        rough = self._tried("winkler", lambda: winkler.answer(self.design, request))
        if plane is None:
            return
        if rough is not None:
            stated = {q: getattr(rough, q).error for q in QUANTITIES}
            self._add("winkler", "model", rough, stated, numbers(plane), "linear", False)
        if beyond_small_strain(self.design, self.force, plane) or plane.fault:
            self.refused["models"] = "beyond small strain: no verdict"
            return
        if ends:
            self._ends(plane, request, solids and self.top)
        if solids and self.seed % FINITE == 0:
            finite = self._tried("finite-strain", lambda: finite_strain.answer(self.design, request))
            if finite is not None:
                bound = small_strain(self.design, plane, self.force)
                stated = relative(plane, bound.threshold, bound.approach)
                self._add("linear", "strain", plane, stated, numbers(finite), "finite-strain", True)

    def _ends(self, plane: Answer, request: Request, with_solid: bool) -> None:
        ends = self._tried("corrected", lambda: corrected.answer(self.design, request, fine=plane))
        if ends is None:
            return
        bound = free_ends(self.design)
        stated = relative(plane, bound.threshold, bound.approach)
        self._add("linear", "ends", plane, stated, numbers(ends), "corrected", False)
        whole = self._tried("solid", lambda: solid.answer(self.design, request)) if with_solid else None
        if whole is not None:
            self._add("linear", "ends", plane, stated, numbers(whole), "solid", True)
            own = {q: getattr(ends, q).error for q in QUANTITIES}
            self._add("corrected", "method", ends, own, numbers(whole), "solid", True)

    def _add(
        self,
        tier: str,
        part: str,
        found: Answer,
        stated: dict[str, float | None],
        truth: dict[str, float | None],
        against: str,
        top: bool,
    ) -> None:
        for quantity in QUANTITIES:
            value, true, error = getattr(found, quantity).value, truth[quantity], stated[quantity]
            if value is None or true is None:
                if (value is None) != (true is None):
                    self.refused[f"{tier} {quantity}"] = f"{value} against {true}"
                continue
            if max(value, true) <= NOTHING * self.force or error is None:
                continue  # ridges that touch at once
            missed = abs(value - true)
            self.rows.append(Row(self.seed, tier, part, quantity, value, error, missed, against, top))

    def _tried(self, name: str, work: Callable[[], T]) -> T | None:
        try:
            return work()
        except (InputError, RefusedError) as refusal:
            self.refused[name] = str(refusal)
            return None


class _Levels:
    """Levels of one pad on the linear ladder, each solved once."""

    def __init__(self, pad: Pad, force: float) -> None:
        self.pad, self.force = pad, force
        self.known: dict[int, dict[str, float | None]] = {}

    def numbers(self, i: int) -> dict[str, float | None]:
        """Return F9 and approach of the rung's higher order."""
        if i not in self.known:
            found = level(plane_piece(self.pad, RUNGS[i].fineness), RUNGS[i].order, self.force)
            self.known[i] = {"all_touch_force": found.all_touch_force, "approach": found.approach}
        return self.known[i]


def climbed(pad: Pad, force: float, tol: float) -> tuple[Answer, int]:
    """Return the linear tier's answer to a tolerance and the number of the rung that it ended on."""
    told: list[str] = []
    found = linear.solve(pad, Request(force, tol), told.append)
    ends = {f"linear tier: fineness {r.fineness:g}, order {r.order}": i for i, r in enumerate(RUNGS)}
    return found, ends[told[-1]]


def numbers(found: Answer) -> dict[str, float | None]:
    """Return an answer's values by quantity."""
    return {q: getattr(found, q).value for q in QUANTITIES}


def relative(found: Answer, threshold: float, approach: float) -> dict[str, float | None]:
    """Return bounds that are relative to the answer as N and mm."""
    share = {"all_touch_force": threshold, "approach": approach}
    return {q: None if (v := getattr(found, q).value) is None else share[q] * v for q in QUANTITIES}


def groups(rows: list[Row]) -> Iterator[tuple[tuple[str, ...], list[Row]]]:
    """Yield rows by tier, part, quantity and what they are held against: the rung above or the top."""

    def key(row: Row) -> tuple[str, ...]:
        return row.tier, row.part, row.quantity, "top" if row.top else "above"

    for name in dict.fromkeys(map(key, rows)):
        yield name, [row for row in rows if key(row) == name]
