"""What friction changes on the coarse solid, sticking and sliding along x and y, against finer solids.

`python -m bench.table_solid_friction 502 530`: random designs with few unknowns, half a minute each, at
friction 0.3 and 1. A line tells the change and by how much it is off: of the all-touch force and of the
approach relative, of the share that is off most in mean shares; a * marks what the stated error does not
hold."""

from __future__ import annotations

import sys

from bench.table_strain import FINENESS, FINER, Judge, flat_design
from skincad.base import InputError
from skincad.mechanics import (
    SOLID_ORDER,
    SOLID_STEPS,
    ContactError,
    errors_of,
    pad_of,
    plain_pad,
    relative_changes,
    solve_solid,
)

MOST = 40_000  # unknowns of the coarse solid
COEFFICIENTS = 0.3, 1.0


def main() -> None:
    """Print a line a seed and coefficient, and how many of the stated errors hold."""
    judge, steps = Judge(), 2 * SOLID_STEPS
    for seed in range(int(sys.argv[1]), int(sys.argv[2])):
        design = flat_design(seed)
        force = design.contact.force
        for mu in COEFFICIENTS:
            try:
                coarse = solve_solid(plain_pad(design), mu, force)
                if coarse.without.unknowns > MOST:
                    break
                fine = solve_solid(pad_of(design), mu, force, (), FINER, FINENESS, SOLID_ORDER, steps)
            except (ContactError, InputError) as refusal:
                print(f"seed {seed}, {mu:g}: {refusal}")
                continue
            pairs = [(one.without, one.gripped) for one in (coarse, fine)]
            stated = errors_of(relative_changes(*pairs[0]), coarse.constant, coarse.by_change)
            print(f"seed {seed}, {mu:g}: {judge.line(*pairs, stated)}", flush=True)
    print(f"held {judge.held} of {judge.judged}")


if __name__ == "__main__":
    main()
