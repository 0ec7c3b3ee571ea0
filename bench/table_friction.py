"""How often friction's bound holds on random designs, and how wide it is.

`python -m bench.table_friction 100 150 [COEFFICIENT]...`: a seed's pad is pressed with friction (0.2, 0.5, 1)
and without, at the force of bench/error_bars.py; some seconds a seed.
"""

from __future__ import annotations

import statistics
from collections.abc import Iterator
from functools import partial

import numpy as np

from bench import runner
from bench.campaign.random_designs import drawn
from bench.error_bars import force_of
from skincad.base import InputError
from skincad.inputs import Design
from skincad.mechanics import NEGLIGIBLE, ContactError, friction, plain_pad
from skincad.mechanics.models.friction import solve
from skincad.shape import skin_of

COEFFICIENTS = 0.2, 0.5, 1.0
MOST_RIDGES = 60  # more take minutes
NAMES = "all-touch force", "approach", "share"


def changes(design: Design, force: float, coefficient: float) -> Iterator[tuple[str, float, float]]:
    """Yield each quantity's relative change and its bound; an F9 that is as good as nothing has none."""
    solution = solve(plain_pad(design), coefficient, force)
    before, after = solution.without, solution.gripped
    bound = friction(design, int((before.ridge_force > 0).sum()))
    first, last = before.all_touch_force, after.all_touch_force
    if first and last and first > NEGLIGIBLE * force:
        yield NAMES[0], abs(last / first - 1), bound.threshold
    yield NAMES[1], abs(after.approach / before.approach - 1), bound.approach
    if skin_of(design).count > 1:
        share = np.abs(after.ridge_force - before.ridge_force).max() / before.ridge_force.mean()
        yield NAMES[2], float(share), bound.share


def judged(seed: int, coefficients: list[float]) -> dict[str, float]:
    """Return each quantity's largest change of a seed's design by its bound."""
    design = drawn(seed).design.with_(skin={"curvature_radius_y": None})
    if skin_of(design).count > MOST_RIDGES:
        raise InputError("ridge.count", f"more than {MOST_RIDGES} take minutes")
    largest: dict[str, float] = {}
    for coefficient in coefficients:
        try:
            for name, change, bound in changes(design, force_of(design, seed), coefficient):
                largest[name] = max(largest.get(name, 0.0), change / bound)
        except (ContactError, InputError) as refusal:
            print(f"seed {seed}, {coefficient:g}: {refusal}")
    return largest


def main() -> None:
    parser = runner.parser(__doc__, "first", "stop")
    parser.add_argument("coefficients", type=float, nargs="*", default=COEFFICIENTS)
    options = parser.parse_args()
    name = "-".join(["friction", *map(str, options.coefficients)])
    judge, seeds = partial(judged, coefficients=options.coefficients), range(options.first, options.stop)
    rows = runner.rows(name, judge, seeds, options)
    for name in NAMES:
        parts = [row[name] for row in rows if name in row]
        held, width = sum(part <= 1 for part in parts), 1 / max(statistics.median(parts), 1e-9)
        print(
            f"{name:16} held {held} of {len(parts)}, at worst {max(parts):.2f}, median {width:.1f} times wide"
        )


if __name__ == "__main__":
    main()
