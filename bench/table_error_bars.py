"""Stated errors of random designs against true ones.

`python -m bench.table_error_bars ROWS.jsonl` solves the seeds that the file does not have yet, one after the
other, appends them and prints the table. Which: `--first SEED --seeds N`, for at most `--minutes M`; without
what is dear, solids and free ends, by `--plane`. `--picture PNG` draws the calibration plot.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from time import perf_counter

import numpy as np

from bench.error_bars import TOPS, Row, groups, outcome


def read(path: Path) -> dict[int, tuple[list[Row], dict[str, str]]]:
    """Return what a file has, by seed."""
    found = {}
    for line in path.read_text("utf-8").splitlines() if path.exists() else ():
        data = json.loads(line)
        found[data["seed"]] = [Row(**row) for row in data["rows"]], data["refused"]
    return found


def solve(path: Path, seeds: range, minutes: float, plane: bool) -> None:
    """Solve what is missing; every tenth seed, the dearest, comes last."""
    began, known = perf_counter(), read(path)
    for seed in sorted(seeds, key=lambda s: (s % TOPS == 0, s)):
        if seed in known:
            continue
        if perf_counter() - began > 60 * minutes:
            break
        done = outcome(seed, solids=not plane, ends=not plane)
        with path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(done.as_json()) + "\n")
        print(f"seed {seed}: {done.seconds:.1f} s, {len(done.rows)} rows", file=sys.stderr)


def table(rows: list[Row]) -> list[str]:
    """Return the table's lines."""
    head = f"{'model':18}{'part':8}{'of':18}{'against':8}{'cases':>6}{'held':>8}{'median width':>14}  missed"
    lines = [head]
    for (model, part, quantity, against), mine in groups(rows):
        held = np.mean([row.held for row in mine])
        missed = [f"{row.seed} ({row.true:.2g} > {row.stated:.2g})" for row in mine if not row.held]
        width = float(np.median([row.width for row in mine]))
        lines.append(
            f"{model:18}{part:8}{quantity:18}{against:8}{len(mine):6d}{held:8.1%}{width:14.2g}"
            f"  {' '.join(missed)}"
        )
    return lines


def main() -> None:
    """Solve, print, draw."""
    parser = argparse.ArgumentParser()
    parser.add_argument("rows", type=Path)
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    parser.add_argument("--seeds", type=int, default=200)
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--plane", action="store_true", help="no solids, no free ends")
    parser.add_argument("--picture", type=Path)
    options = parser.parse_args()
    seeds = range(options.first, options.first + options.seeds)
    solve(options.rows, seeds, options.minutes, options.plane)
    known = read(options.rows)
    rows = [row for seed in sorted(known) if seed in seeds for row in known[seed][0]]
    print("\n".join(table(rows)))
    for seed in sorted(set(known) & set(seeds)):
        for name, why in known[seed][1].items():
            print(f"seed {seed}: {name}: {why}")
    if options.picture:
        from bench.calibration_plot import calibration_plot

        calibration_plot(rows, options.picture)


if __name__ == "__main__":
    main()
