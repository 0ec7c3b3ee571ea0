"""Stated errors of random designs against true ones.

`python -m bench.table_error_bars ROWS.jsonl` solves the seeds that the file does not have yet, the dearest
last, and prints the table. Which: `--first SEED --seeds N`; without what is dear, solids and free ends, by
`--plane`. `--picture PNG` draws the calibration plot.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np

from bench import runner
from bench.error_bars import TOPS, Row, groups, outcome


def table(rows: list[Row]) -> list[str]:
    """Return the table's lines."""
    lines = []
    for (model, part, quantity, against), mine in groups(rows):
        held = np.mean([row.held for row in mine])
        missed = [f"{row.seed} ({row.true:.2g} > {row.stated:.2g})" for row in mine if not row.held]
        width = float(np.median([row.width for row in mine]))
        lines.append(
            (model, part, quantity, against, len(mine), f"{held:.1%}", f"{width:.2g}", " ".join(missed))
        )
    head = ("model", "part", "of", "against", "cases", "held", "median width", "missed")
    return runner.table(head, lines)


def main() -> None:
    """Solve, print, draw."""
    parser = runner.parser(__doc__)
    parser.add_argument("rows", type=Path)
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    parser.add_argument("--seeds", type=int, default=200)
    parser.add_argument("--plane", action="store_true", help="no solids, no free ends")
    parser.add_argument("--picture", type=Path)
    options = parser.parse_args()
    options.records = options.rows
    seeds = sorted(range(options.first, options.first + options.seeds), key=lambda s: (s % TOPS == 0, s))
    judge = partial(outcome, solids=not options.plane, ends=not options.plane)
    outcomes = sorted(runner.rows("error-bars", judge, seeds, options), key=lambda one: one["seed"])
    rows = [Row(**row) for one in outcomes for row in one["rows"]]
    print("\n".join(table(rows)))
    for one in outcomes:
        for name, why in one["refused"].items():
            print(f"seed {one['seed']}: {name}: {why}")
    if options.picture:
        from bench.calibration_plot import calibration_plot

        calibration_plot(rows, options.picture)


if __name__ == "__main__":
    main()
