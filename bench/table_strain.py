"""What finite strain changes on the coarse solid of `corrected-finite-strain`, against finer ones.

`python -m bench.table_strain 600 630`: random designs with few unknowns, half a minute each. A line tells the
change on the coarse solid and by how much it is off: of the all-touch force and of the approach relative, of
the share that is off most in mean shares; a * marks what the stated error does not hold."""

from __future__ import annotations

import numpy as np

from bench import runner
from bench.campaign.random_designs import drawn
from bench.error_bars import force_of
from skincad.base import InputError
from skincad.inputs import Design
from skincad.mechanics import (
    COARSE_ERRORS,
    COARSE_LAYERS,
    COARSE_PARTS,
    CoarseAnswer,
    Errors,
    Layers,
    errors_of,
    pad_of,
    plain_pad,
    relative_changes,
)
from skincad.mechanics.models.solid_finite_strain import solve

MOST = 9_000  # unknowns of the coarse solid; the finer one's are ten times as many
FINER, FINENESS = Layers(0.3, 1.8, 3), 1.3
Pair = tuple[CoarseAnswer, CoarseAnswer]  # before and after a change


def flat_design(seed: int) -> Design:
    """Return the random design of a seed, straight along y, under a flat plate at its own force."""
    design = drawn(seed).design
    flat = {"plate": {"shape": "flat"}, "force": force_of(design, seed)}
    return design.with_(skin={"curvature_radius_y": None}, contact=flat)


def compared(coarse: Pair, fine: Pair, stated: Errors) -> list[tuple[str, float, float, float]]:
    """Return by quantity the coarse pair's change, by how much it is off the fine one's, and its error."""
    change, truth = relative_changes(*coarse), relative_changes(*fine)
    one, other = (
        (after.ridge_force - before.ridge_force) / before.ridge_force.mean()
        for before, after in (coarse, fine)
    )
    return [
        ("all touch", change.threshold, abs(change.threshold - truth.threshold), stated.threshold),
        ("approach", change.approach, abs(change.approach - truth.approach), stated.approach),
        ("share", change.share, float(np.abs(one - other).max()), stated.share),
    ]


def line(row: runner.Row) -> str:
    """Return the changes, by how much they are off, and a * where the stated error does not hold."""
    parts = (f"{name} {v:+.4f} off {off:.4f}{'*' * (off > error)}" for name, v, off, error in row["changes"])
    return f"seed {row['seed']}{row['at']}: {'; '.join(parts)}"


def judged(seed: int) -> runner.Row:
    """Return a seed's changes by finite strain; none of a design with many unknowns."""
    design = flat_design(seed)
    force = design.contact.force
    coarse = solve(plain_pad(design), force, {}, COARSE_LAYERS)
    if coarse.finite.unknowns > MOST:
        raise InputError("unknowns", f"must be at most {MOST}", coarse.finite.unknowns)
    fine = solve(pad_of(design), force, {}, FINER, fineness=FINENESS)
    pairs = [(one.small, one.finite) for one in (coarse, fine)]
    stated = errors_of(relative_changes(*pairs[0]), COARSE_ERRORS, COARSE_PARTS)
    return {"seed": seed, "at": "", "changes": compared(*pairs, stated)}


def tell(rows: list[runner.Row]) -> None:
    """Print how many of the stated errors hold."""
    held = [off <= error for row in rows for *_, off, error in row["changes"]]
    print(f"held {sum(held)} of {len(held)}")


def main() -> None:
    options = runner.parser(__doc__, "first", "stop").parse_args()
    tell(runner.rows("strain", judged, range(options.first, options.stop), options, line))


if __name__ == "__main__":
    main()
