"""Slips from readings, and the errors of slips, leads and stresses by their source.

Signals from a march: band-limited stress with its rate and jerk, and when ridges slip. A quasi-static march
with Coulomb friction is piecewise smooth, so its raw jerk is spikes of 1 / dt at events that depend on the
mesh and are no signal. Everything goes through one causal low-pass.

How wrong a told ridge's differential stress may be, by source. Mesh: the largest change to a march on the
mesh before. Time step: the largest to one of fewer steps, at the times that both have, before gross slip:
from there on they tell of different states. That change itself is taken, four times what it would be of first
order in the step: points slip and stick from step to step, so the order is lower. Of yamada-2002-slip with
110 steps the error, by 550, is 0.06 to 0.96 of the change; of steady-pull and hold, looked at afterwards,
0.02 to 0.77. What is left out: the relative change of the ridges' loads, taken to be the signal's, of its
largest; and the largest change to a march with other fillets, in the steps that both are near chosen ones.

How wrong the time of a slip may be, and a lead, which is the time between two: by source. Mesh and time step:
the change to a march on the mesh before, and to one of fewer steps. What is left out: an effect that changes
a ridge's load by a share c lets it slip when it bears 1 / (1 + c) of what it bore at its slip without that
effect. How long before the slip the ridge bore that much is how far the slip may move; the same is taken for
later. Other fillets are such an effect: c is FILLETS times the mean change of the friction used over the last
fifth of those steps, and that of the median ridge at least. Range: marches whose tangential load grows
towards the slip.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from skincad.base.arrays import Array, Index, Mask
from skincad.base.estimate import Estimate
from skincad.circuit.state import longest_step
from skincad.mechanics.contact.state import FrictionCoefficients
from skincad.scenes.march import March
from skincad.scenes.runs import COARSE_STEP_FACTOR, Runs

# What fillets change until a corner snaps, they may change more by the time a ridge slips: found on seven
# slips of bench.leads (default_rng(7104) ...)
FILLETS = 2.0
# What one harmonic round the axis and a press without friction change of the share that slips, mean of all
# pulls: of a face 0.15; of rings 0.12 in the finest solids, and 0.2 on the line through three (ring_friction)
AROUND = 0.2


class BySource(NamedTuple):
    """An error, in the unit of what is wrong by it; a source that nobody asked is None."""

    mesh: float | None
    time_step: float | None
    left_out: float
    drift: float = 0.0

    @property
    def total(self) -> float | None:
        """The sum; None where the mesh's or the step's share is unknown."""
        if self.mesh is None or self.time_step is None:
            return None
        return self.mesh + self.time_step + self.left_out + self.drift

    @property
    def numerical(self) -> float:
        """Of the total, what mesh and steps cause."""
        return (self.total or 0.0) - self.left_out

    @property
    def known(self) -> float:
        """The sum of what is known."""
        return math.fsum(share for share in self if share is not None)

    def with_total(self) -> dict[str, float | None]:
        """Return it under JSON keys, the sum too."""
        return {**self._asdict(), "total": self.total}


def shown_band(time: Array, bandwidth: float) -> float:
    """Return up to which frequency, Hz, the steps of a march show what happens: at most `bandwidth`."""
    return bandwidth if time.size < 2 else min(bandwidth, 0.5 / longest_step(time))


def unresolved(time: Array, bandwidth: float) -> list[str]:
    """Return a warning where the march's steps do not reach up to `bandwidth` Hz, else nothing."""
    if (shown := shown_band(time, bandwidth)) == bandwidth:
        return []
    return [
        f"steps of {longest_step(time):.3g} s show what happens up to {shown:.4g} Hz, not up to "
        f"readout.bandwidth_Hz ({bandwidth:g} Hz): the jerk is each step's mean"
    ]


def slip_by_ridge(touches: Mask, slips: Mask, ridge: Index, ridges: int) -> Mask:
    """Return `(steps + 1, ridges)`: a ridge slips while all its touching points slip, and some touch."""
    mine = [ridge == r for r in range(1, ridges + 1)]
    columns = [touches[:, m].any(axis=1) & (slips | ~touches)[:, m].all(axis=1) for m in mine]
    return np.stack(columns, axis=1)


def intervals(slipping: Mask) -> list[list[int]]:
    """Return [from, to] of every run of True in `(n,)`, both inside the run."""
    edges = np.flatnonzero(np.diff(slipping.astype(np.int8), prepend=0, append=0))
    return [[int(a), int(b) - 1] for a, b in zip(edges[::2], edges[1::2], strict=True)]


def gross_slip_step(touches: Mask, slips: Mask) -> int | None:
    """Return the first index at which every touching point slips, None if there is none."""
    steps = np.flatnonzero(touches.any(axis=1) & (slips | ~touches).all(axis=1))
    return int(steps[0]) if steps.size else None


def lasting_slip_step(runs: list[list[int]], gross: int | None, last: int) -> int | None:
    """Return the start of the run that lasts to gross slip, or to the end."""
    end = last if gross is None else gross
    return next((a for a, b in runs if a <= end <= b), None)


def without_halts(runs: list[list[int]], time: Array, halts: float) -> list[list[int]]:
    """Return runs [from, to] at `time` `(n,)` s, two as one where at most `halts` s lie between them."""
    joined: list[list[int]] = []
    for start, end in runs:
        if joined and time[start] - time[joined[-1][1]] <= halts:
            joined[-1][1] = end
        else:
            joined.append([start, end])
    return joined


@dataclass(frozen=True, eq=False)
class Slips:
    """When ridges slip: `slipping` `(steps + 1, ridges)`; the `runs` of it, [from, to], and the step at which
    the one that lasts begins, by ridge from 1; and the first step of gross slip."""

    slipping: Mask
    runs: list[list[list[int]]]
    steps: list[int | None]
    gross: int | None


def slips_of(march: March, ridges: int, halts: float = 0.0) -> Slips:
    """Return when the ridges slip in a march. Halts of up to that many s do not end a slip: with masses a
    ridge that slips stops for a part of a swing."""
    readings, ridge = march.readings, march.ridge
    touches = np.array([reading.touches for reading in readings])
    slips = np.array([reading.slips for reading in readings])
    slipping = slip_by_ridge(touches, slips, ridge, ridges)
    runs = [without_halts(intervals(column), march.time, halts) for column in slipping.T]
    gross, last = gross_slip_step(touches, slips), len(readings) - 1
    steps = [lasting_slip_step(run, gross, last) for run in runs]
    return Slips(slipping, runs, steps, gross)


Stress = Mapping[int, Array]  # MPa by monitored ridge, `(steps + 1,)`


def stress_errors(
    runs: Runs, stress: Callable[[March], Stress], change: float, drift: Mapping[int, float]
) -> dict[int, BySource]:
    """Return the errors of the `stress` of the march that counts, MPa, by monitored ridge: `change` is what
    is left out, `drift` what drifts between chosen steps."""
    fewer, rounder = _by_fewer(runs, stress), _by_fillets(runs, stress)
    return {
        ridge: BySource(
            None if runs.error is None else runs.error.get(ridge),
            fewer.get(ridge),
            change * float(np.abs(values).max()) + rounder.get(ridge, 0.0),
            drift.get(ridge, 0.0),
        )
        for ridge, values in stress(runs.march).items()
    }


def _by_fewer(runs: Runs, stress: Callable[[March], Stress]) -> dict[int, float]:
    """The step's share by ridge; nothing where no march has fewer steps, or no step before gross slip."""
    every, coarse = runs.every, runs.coarse
    if every is None or coarse is None:
        return {}
    end = min(_gross(every), _gross(coarse))
    times, at, indices = np.intersect1d(every.time, coarse.time, return_indices=True)
    at, indices = at[times < end], indices[times < end]
    one, other = stress(every), stress(coarse)
    # both start unloaded: that they agree there says nothing
    return {r: float(np.abs(one[r][at] - other[r][indices]).max()) for r in one if at.size > 1}


def _by_fillets(runs: Runs, stress: Callable[[March], Stress]) -> dict[int, float]:
    """What other fillets change by ridge; nothing where no march has them."""
    if runs.fillets is None:
        return {}
    steps = near_chosen(runs.march, runs.fillets)
    one, other = stress(runs.march), stress(runs.fillets)
    return {r: float(np.abs(one[r][:steps] - other[r][:steps]).max()) for r in one}


def near_chosen(*marches: March) -> int:
    """Return how many steps lie before one of these marches in chosen steps could choose no more."""
    steps = [len(march.readings) for march in marches]
    for march in marches:
        if (drift := march.readings[-1].drift) is not None and drift.cut:
            chosen = (i for i, reading in enumerate(march.readings) if reading.drift and reading.drift.chosen)
            steps.append(1 + max(chosen))
    return min(steps)


def _gross(march: March) -> float:
    """When gross slip begins, s; never without it."""
    touches = np.array([reading.touches for reading in march.readings])
    slips = np.array([reading.slips for reading in march.readings])
    gross = gross_slip_step(touches, slips)
    return np.inf if gross is None else float(march.time[gross])


def change_of_slip_share(one: March, other: March) -> float:
    """Return by how much the shares that slip differ, the mean of the times that both marches have."""
    _, at, indices = np.intersect1d(one.time, other.time, return_indices=True)
    return float(np.abs(one.slip_share[at] - other.slip_share[indices]).mean())


def slip_share_error(runs: Runs, model: float = 0.0) -> float | None:
    """Return by how much the share that slips may be wrong by mesh, time step and `model`, the mean of all
    steps; None where nobody asked for the first two."""
    if runs.before is None or runs.every is None or runs.coarse is None:
        return None
    steps = change_of_slip_share(runs.every, runs.coarse) / (COARSE_STEP_FACTOR - 1)
    return change_of_slip_share(runs.after or runs.march, runs.before) + steps + model


@dataclass(frozen=True, eq=False)
class SlipErrors:
    """The errors, ms: of each ridge's `slips`, in order, of `gross` slip, and of `leads`, from a ridge's slip
    to gross slip, which mesh and step may move less than either."""

    slips: list[BySource]
    gross: BySource
    leads: list[BySource]


def slip_errors(
    runs: Runs,
    slips: Slips,
    change: float,
    driven: bool,
    cone: FrictionCoefficients,
    halts: float = 0.0,
) -> SlipErrors:
    """Return the errors of slips; `change` is the relative change of loads by what is left out, `driven`
    whether the plate's travel is given: gross slip depends on the skin then; `halts` is as of `slips_of`."""
    last, count = runs.march, len(slips.steps)
    time, loads = last.time, last.loads
    after, before, every, coarse = (
        None if march is None else _moments(march, count, halts)
        for march in (runs.after or last, runs.before, runs.every, runs.coarse)
    )
    whole = loads.sum(axis=2)
    missed = _drift(last)

    def spreads(changes: Array) -> Array:
        """By how much each slip's time, and last that of gross slip, may move, ms, for changes of the loads
        `(steps + 1, ridges)`."""
        column = [
            spread(time, loads[:, :, ridge], step, float(changes[step or 0, ridge]), cone)
            for ridge, step in enumerate(slips.steps)
        ]
        all_of_it = float(changes[slips.gross or 0].max(initial=0.0))
        return np.array([*column, spread(time, whole, slips.gross, all_of_it, cone) if driven else 0.0])

    def errors(of: Callable[[Array], Array], *spreads: Array) -> list[BySource]:
        mesh, fewer = (_apart(*two, of, spreads[0].size) for two in ((after, before), (every, coarse)))
        # of first order in the step, and at least a step
        steps = [
            None if parts is None else max(step_ms(last), parts / (COARSE_STEP_FACTOR - 1)) for parts in fewer
        ]
        others = (parts.tolist() for parts in spreads)
        return [BySource(*parts) for parts in zip(mesh, steps, *others, strict=True)]

    moved = spreads(np.full_like(missed, change) + _with_other_fillets(runs)), spreads(missed)
    slipped = errors(lambda moments: 1e3 * moments, *moved)
    of_leads = (moved_by[:-1] + moved_by[-1] for moved_by in moved)
    leads = errors(lambda moments: 1e3 * (moments[-1] - moments[:-1]), *of_leads)
    return SlipErrors(slipped[:-1], slipped[-1], leads)


def _with_other_fillets(runs: Runs) -> Array:
    """By how much other fillets may change the share of friction that a ridge uses, relative `(ridges,)`.

    FILLETS times the mean change of the last fifth of the steps before one of the marches chooses no more;
    that of the median ridge where it is larger, for one that slips by then uses all of it either way. 0
    without other fillets.
    """
    if runs.fillets is None:
        return np.zeros(runs.march.loads.shape[2])
    steps = near_chosen(runs.march, runs.fillets)
    used = []
    for march in (runs.march, runs.fillets):
        normal, pulled, _ = np.moveaxis(march.loads[4 * steps // 5 : steps], 1, 0)
        used.append(np.divide(np.abs(pulled), normal, out=np.zeros_like(normal), where=normal > 0))
    one, other = used
    own, all_of_it = np.abs(one - other).mean(axis=0), one.mean(axis=0)
    change = np.divide(own, all_of_it, out=np.zeros_like(own), where=all_of_it > 0)
    return np.asarray(FILLETS * np.maximum(change, np.median(change)))


def _drift(march: March) -> Array:
    """By how much drift changes each ridge's share of friction that is used, by step `(steps + 1, ridges)`,
    relative: of what the ridge bears along x, and along z. None without chosen steps, or contact."""
    none = np.zeros_like(march.loads[0, :2])
    drift = [none if reading.drift is None else reading.drift.forces for reading in march.readings]
    borne = np.abs(march.loads[:, 1::-1])  # along x, then z
    share = np.divide(drift, borne, out=np.zeros_like(borne), where=borne > 0)
    return np.asarray(share.sum(axis=1))


def step_ms(march: March) -> float:
    """Return the time of a march's step, ms, the longest where they are not equal; 0 without any."""
    return 1e3 * longest_step(march.time) if march.time.size > 1 else 0.0


def in_steps(march: March, step: int | None, error: BySource) -> BySource | None:
    """Return a slip's error, ms, in steps of its march; None without that slip."""
    if step is None:
        return None
    mesh, time_step = (None if part is None else _whole(part / step_ms(march)) for part in error[:2])
    others = (_whole(part / step_ms(march)) for part in error[2:] if part is not None)
    return BySource(mesh, time_step, *others)


def _whole(steps: float) -> float:
    """Steps without the rounding of the times that they come from."""
    return round(steps, 6)


def slip_step(step: int | None, error: BySource | None) -> Estimate:
    """Return the step of a slip; of no value without that slip."""
    return Estimate(step, None if error is None else error.total, "steps")


def lead(time: Array, gross: int | None, step: int | None, error: float | None) -> Estimate:
    """Return by how many ms a slip comes before gross slip; of no value without one of them."""
    if gross is None or step is None:
        return Estimate(None, None, "ms")
    return Estimate(1e3 * float(time[gross] - time[step]), error, "ms")


def _moments(march: March, ridges: int, halts: float) -> Array:
    """When ridges slip for good, s `(ridges + 1,)`, and last gross slip: the march's end without it, and that
    of a ridge that does not slip is put there too."""
    slips = slips_of(march, ridges, halts)
    last = march.time.size - 1 if slips.gross is None else slips.gross
    return np.asarray(march.time[[*(last if step is None else step for step in slips.steps), last]])


def _apart(
    one: Array | None, other: Array | None, of: Callable[[Array], Array], count: int
) -> list[float | None]:
    """By how much what is `of` two marches' moments differs, `count` numbers; None without one of them."""
    if one is None or other is None:
        return [None] * count
    return [float(difference) for difference in np.abs(of(one) - of(other))]


def spread(time: Array, loads: Array, step: int | None, change: float, cone: FrictionCoefficients) -> float:
    """Return for how long before a slip, ms, a ridge stood at least at what slips once its load is larger by
    `change`: by `loads` `(steps + 1, 3)`, normal and tangential N and what touches, mm2, and the friction of
    the `cone`."""
    if step is None or change == 0.0:
        return 0.0
    normal, tangential, area = loads.T
    touches = (normal > 0) & (area > 0)
    borne = cone.borne(np.where(touches, normal, 1.0), np.where(touches, area, 1.0))
    used = np.where(touches, np.abs(tangential) / borne, 0.0)
    low = np.flatnonzero(used[: step + 1] < used[step] / (1 + change))
    first = int(low[-1]) + 1 if low.size else 0
    return 1e3 * float(time[step] - time[min(first, step)])
