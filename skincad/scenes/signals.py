"""Signals from a march: band-limited stress with its rate and jerk, and when ridges slip.

A quasi-static march with Coulomb friction is piecewise smooth, so its raw jerk is spikes of 1 / dt at events
that hang on the mesh; nobody may read those as signal. Everything goes through one causal low-pass.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from skincad.base.arrays import Array, Index, Mask
from skincad.circuit.low_pass import longest_step
from skincad.effects.kinds import Reading


def unresolved(time: Array, bandwidth: float) -> list[str]:
    """Return a warning where the march's steps do not reach up to `bandwidth` Hz, else nothing."""
    if time.size < 2 or bandwidth <= 0.5 / (step := longest_step(time)):
        return []
    return [
        f"steps of {step:.3g} s show what happens up to {0.5 / step:.4g} Hz: from there up to "
        f"readout.bandwidth_Hz ({bandwidth:g} Hz) rate and jerk are artefacts of the steps"
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


@dataclass(frozen=True, eq=False)
class Slips:
    """When ridges slip: `slipping` `(steps + 1, ridges)`; the `runs` of it, [from, to], and the step at which
    the one that lasts begins, by ridge from 1; and the first step of gross slip."""

    slipping: Mask
    runs: list[list[list[int]]]
    steps: list[int | None]
    gross: int | None


def slips_of(readings: Sequence[Reading], ridge: Index, ridges: int) -> Slips:
    """Return when the ridges slip, by a march's readings and the `ridge` `(m,)` of its contact points."""
    touches = np.array([reading.touches for reading in readings])
    slips = np.array([reading.slips for reading in readings])
    slipping = slip_by_ridge(touches, slips, ridge, ridges)
    runs = [intervals(column) for column in slipping.T]
    gross, last = gross_slip_step(touches, slips), len(readings) - 1
    return Slips(slipping, runs, [lasting_slip_step(run, gross, last) for run in runs], gross)
