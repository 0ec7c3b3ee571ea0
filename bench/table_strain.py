"""What finite strain changes on the coarse solid of `corrected-finite-strain`, against finer ones.

`python -m bench.table_strain 600 630`: random designs with few unknowns, half a minute each. A line tells the
change on the coarse solid and by how much it is off: of the all-touch force and of the approach relative, of
the share that is off most in mean shares; a * marks what the stated error does not hold."""

from __future__ import annotations

import sys

import numpy as np

from bench.campaign.random_designs import drawn
from bench.error_bars import force_of
from skincad.base.errors import InputError
from skincad.mechanics.models.corrected import errors_of, plain_pad, relative_changes
from skincad.mechanics.models.solid import Layers
from skincad.mechanics.models.solid_finite_strain import (
    COARSE_ERRORS,
    COARSE_LAYERS,
    COARSE_PARTS,
    solve,
)
from skincad.mechanics.problem import ContactError, pad_of

MOST = 9_000  # unknowns of the coarse solid; the finer one's are ten times as many
FINER, FINENESS = Layers(0.3, 1.8, 3), 1.3


def main() -> None:
    """Print a line a seed, and how many of the stated errors hold."""
    held = judged = 0
    for seed in range(int(sys.argv[1]), int(sys.argv[2])):
        design = drawn(seed).design
        flat = {"plate": {"shape": "flat"}, "force": force_of(design, seed)}
        design = design.with_(skin={"curvature_radius_y": None}, contact=flat)
        force = design.contact.force
        try:
            coarse = solve(plain_pad(design), force, {}, COARSE_LAYERS)
            if coarse.finite.unknowns > MOST:
                continue
            fine = solve(pad_of(design), force, {}, FINER, fineness=FINENESS)
        except (ContactError, InputError) as refusal:
            print(f"seed {seed}: {refusal}")
            continue
        change, truth = (relative_changes(s.small, s.finite) for s in (coarse, fine))
        stated = errors_of(change, COARSE_ERRORS, COARSE_PARTS)
        one, other = (
            (s.finite.ridge_force - s.small.ridge_force) / s.small.ridge_force.mean() for s in (coarse, fine)
        )
        rows = (
            ("all touch", change.threshold, abs(change.threshold - truth.threshold), stated.threshold),
            ("approach", change.approach, abs(change.approach - truth.approach), stated.approach),
            ("share", change.share, float(np.abs(one - other).max()), stated.share),
        )
        words = [
            f"{name} {value:+.4f} off {off:.4f}{'*' * (off > error)}" for name, value, off, error in rows
        ]
        held, judged = held + sum(off <= error for *_, off, error in rows), judged + len(rows)
        print(f"seed {seed}: {'; '.join(words)}", flush=True)
    print(f"held {held} of {judged}")


if __name__ == "__main__":
    main()
