"""What friction changes on the coarse solid, sticking and sliding along x and y, against finer solids.

`python -m bench.table_solid_friction 502 530`: random designs with few unknowns, half a minute each, at
friction 0.3 and 1. A line tells the change and by how much it is off: of the all-touch force and of the
approach relative, of the share that is off most in mean shares; a * marks what the stated error does not
hold."""

from __future__ import annotations

import sys

import numpy as np

from bench.campaign.random_designs import drawn
from bench.error_bars import force_of
from skincad.base.errors import InputError
from skincad.mechanics.models.corrected import errors_of, plain_pad, relative_changes
from skincad.mechanics.models.friction import SOLID_ORDER, SOLID_STEPS, solve_solid
from skincad.mechanics.models.solid import Layers
from skincad.mechanics.problem import ContactError, pad_of

MOST = 40_000  # unknowns of the coarse solid
FINER, FINENESS = Layers(0.3, 1.8, 3), 1.3
COEFFICIENTS = 0.3, 1.0


def main() -> None:
    """Print a line a seed and coefficient, and how many of the stated errors hold."""
    held = judged = 0
    for seed in range(int(sys.argv[1]), int(sys.argv[2])):
        design = drawn(seed).design
        flat = {"plate": {"shape": "flat"}, "force": force_of(design, seed)}
        design = design.with_(skin={"curvature_radius_y": None}, contact=flat)
        force = design.contact.force
        for coefficient in COEFFICIENTS:
            try:
                coarse = solve_solid(plain_pad(design), coefficient, force)
                if coarse.without.unknowns > MOST:
                    break
                steps = 2 * SOLID_STEPS
                fine = solve_solid(
                    pad_of(design), coefficient, force, (), FINER, FINENESS, SOLID_ORDER, steps
                )
            except (ContactError, InputError) as refusal:
                print(f"seed {seed}, {coefficient:g}: {refusal}")
                continue
            change, truth = (relative_changes(s.without, s.gripped) for s in (coarse, fine))
            stated = errors_of(change, coarse.constant, coarse.by_change)
            one, other = (
                (s.gripped.ridge_force - s.without.ridge_force) / s.without.ridge_force.mean()
                for s in (coarse, fine)
            )
            rows = (
                ("all touch", change.threshold, abs(change.threshold - truth.threshold), stated.threshold),
                ("approach", change.approach, abs(change.approach - truth.approach), stated.approach),
                ("share", change.share, float(np.abs(one - other).max()), stated.share),
            )
            words = "; ".join(f"{name} {v:+.4f} off {off:.4f}{'*' * (off > e)}" for name, v, off, e in rows)
            held, judged = held + sum(off <= e for *_, off, e in rows), judged + len(rows)
            print(f"seed {seed}, {coefficient:g}: {words}", flush=True)
    print(f"held {held} of {judged}")


if __name__ == "__main__":
    main()
