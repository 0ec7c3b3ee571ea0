"""What becomes of the plate's work in a march."""

from __future__ import annotations

import numpy as np

from skincad.scenes.march import March


def energy(march: March) -> dict[str, float]:
    """Return the plate's work, what is stored and lost, mJ, and what is missing, relative to the work."""
    normal, tangential = march.column("normal"), march.column("tangential")
    down, along = np.diff(march.column("approach")), np.diff(march.column("travel"))
    by_forces = (normal[1:] + normal[:-1]) / 2 * down + (tangential[1:] + tangential[:-1]) / 2 * along
    works = [reading.work for reading in march.readings[1:]]
    pushed = sum(force if work is None else work for force, work in zip(by_forces, works, strict=True))
    stored = float(march.readings[-1].elastic)
    lost = float(march.column("dissipated").sum())
    kinetic = float(march.readings[-1].kinetic)
    viscous = float(march.column("viscous").sum())
    missing = abs(pushed - stored - kinetic - lost - viscous)
    return {
        "work_mJ": float(pushed),
        "elastic_mJ": stored,
        "kinetic_mJ": kinetic,
        "dissipated_mJ": lost,
        "viscous_mJ": viscous,
        "imbalance": float(missing) / max(abs(float(pushed)), stored, 1e-300),
    }
