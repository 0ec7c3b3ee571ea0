"""What the detector is held against: everything, a threshold on the rate, and what no film tells.

The threshold is that on the outputs' rate of change that an engineer would set first: a pair that falls by
more than DROP of its largest of late, in a window. Two are oracles: one knows when each told ridge slips, the
other the plate's forces and friction, and warns where the pull passes a share of what holds.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import maximum_filter1d

from bench.exam.cases import Case
from bench.exam.scoring import Alarm

DROP = 0.5  # assumption
LATE = 10  # windows; assumption
LOUD = 6.0  # noise rms of a pair; assumption


def always(case: Case, window: int) -> list[Alarm]:
    """Return an alarm of every ridge in every window."""
    return [(r, i) for i in range(0, case.outputs.shape[0], window) for r in range(case.outputs.shape[1])]


def threshold(case: Case, window: int, outputs: np.ndarray) -> list[Alarm]:
    """Return where a pair's size falls by DROP of its largest of late within a window."""
    pair = np.abs(outputs[:, :, 0] - outputs[:, :, 1])
    size = LATE * window
    largest = maximum_filter1d(pair, size, axis=0, origin=(size - 1) // 2, mode="constant")
    before = np.concatenate([np.zeros_like(pair[:window]), pair[:-window]])
    fall = (before - pair > DROP * largest) & (largest > LOUD * np.sqrt(2) * case.noise)
    rises = fall & ~np.concatenate([np.zeros_like(fall[:1]), fall[:-1]])
    return [(int(r), int(i)) for i, r in np.argwhere(rises)]


def slips(case: Case) -> list[Alarm]:
    """Return where each told ridge begins to slip."""
    return [(ridge, first) for ridge, runs in enumerate(case.runs) for first, _ in runs]


def cone(case: Case, near: float) -> list[Alarm]:
    """Return where the plate's pull passes `near` of what friction holds, told of the skin."""
    end = case.outputs.shape[0]
    pull, normal = np.abs(case.scene.tangential[:end]), case.scene.normal[:end]
    over = (pull > near * case.scene.friction * normal) & (normal > 0)
    rises = np.flatnonzero(over & ~np.concatenate([[False], over[:-1]]))
    return [(None, int(i)) for i in rises]
