"""What friction changes on the coarse solid, sticking and sliding along x and y, against finer solids.

`python -m bench.table_solid_friction 502 530`: random designs with few unknowns, half a minute each, at
friction 0.3 and 1. A line tells the change and by how much it is off: of the all-touch force and of the
approach relative, of the share that is off most in mean shares; a * marks what the stated error does not
hold."""

from __future__ import annotations

from bench import runner
from bench.table_strain import FINENESS, FINER, compared, flat_design, line, tell
from skincad.base import InputError
from skincad.mechanics import (
    SOLID_ORDER,
    SOLID_STEPS,
    errors_of,
    pad_of,
    plain_pad,
    relative_changes,
    solve_solid,
)

MOST = 40_000  # unknowns of the coarse solid
COEFFICIENTS = 0.3, 1.0


def judged(case: str) -> runner.Row:
    """Return the changes by friction of a seed and a coefficient; none of a design with many unknowns."""
    seed, mu = int(case.split(maxsplit=1)[0]), float(case.split()[1])
    design = flat_design(seed)
    force = design.contact.force
    coarse = solve_solid(plain_pad(design), mu, force)
    if coarse.without.unknowns > MOST:
        raise InputError("unknowns", f"must be at most {MOST}", coarse.without.unknowns)
    fine = solve_solid(pad_of(design), mu, force, (), FINER, FINENESS, SOLID_ORDER, 2 * SOLID_STEPS)
    pairs = [(one.without, one.gripped) for one in (coarse, fine)]
    stated = errors_of(relative_changes(*pairs[0]), coarse.constant, coarse.by_change)
    return {"seed": seed, "at": f", {mu:g}", "changes": compared(*pairs, stated)}


def main() -> None:
    options = runner.parser(__doc__, "first", "stop").parse_args()
    cases = [f"{seed} {mu}" for seed in range(options.first, options.stop) for mu in COEFFICIENTS]
    tell(runner.rows("solid-friction", judged, cases, options, line))


if __name__ == "__main__":
    main()
