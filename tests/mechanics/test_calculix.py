"""Another program's contact on the same section: CalculiX, where it is installed."""

from __future__ import annotations

import numpy as np
import pytest

from bench import calculix
from bench.bench_calculix import FORCE, SOFTER, own
from skincad.mechanics.problem import pad_of
from tests.mechanics.designs import filleted

COARSE = 0.25  # fineness of CalculiX's mesh


@pytest.mark.slow
@pytest.mark.skipif(bool(calculix.missing()), reason=calculix.missing())
@pytest.mark.parametrize("tier", ["linear", "finite-strain"])
def test_calculix_gives_the_same_shares(tier: str) -> None:
    pad = pad_of(filleted())
    start = None if tier == "linear" else SOFTER * own(pad, "linear", 0.5, 2).approach
    theirs, ours = calculix.press(pad, COARSE, FORCE, start), own(pad, tier, 0.5, 3)
    # 0.01 N of a mean share of 0.44: the coarse mesh is off by 0.0025 N, large strain shifts shares by 0.02
    assert np.abs(theirs.shares - ours.shares).max() <= 0.01
    assert theirs.shares.sum() == pytest.approx(FORCE, rel=1e-3)  # CalculiX's own convergence
    assert theirs.approach == pytest.approx(ours.approach, rel=5e-3)  # penalty and coarse mesh
