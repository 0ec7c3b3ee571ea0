"""skincad against CalculiX on plain-ridges at 4 N: error against time, linear and neo-Hookean, in one run.

`python -m bench.bench_calculix [linear]` prints the tables and the ratios of times at equal error. The
section is its own mirror image: skincad solves half of it, unasked; CalculiX is asked for the whole and, in
the linear table, for the half too, its cut held sideways, as one who knows would ask it. Both run on one
processor; times are processor times, which are wall times where nothing else runs. CalculiX's is of its
process alone, without gmsh; skincad's holds its mesh and the all-touch force besides, which CalculiX is not
asked: the ratio is printed without it too. An error is the largest of the shares' differences, N.
"""

from __future__ import annotations

import statistics
import sys
from dataclasses import dataclass
from time import perf_counter, process_time

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from bench import calculix
from bench.calculix import PressedPad
from skincad import load
from skincad.mechanics import Pad, pad_of, plane_piece
from skincad.mechanics.models import finite_strain, linear

FORCE = 4.0  # N
LEVELS = ((0.25, 2), (0.5, 2), (0.5, 3), (1.0, 3), (1.0, 4), (2.0, 4), (2.0, 5))  # fineness, order
MESHES = {"linear": (0.25, 0.5, 1.0, 2.0), "finite-strain": (0.25, 0.5, 1.0)}  # CalculiX's fineness
GOALS = {"linear": 50.0, "finite-strain": 100.0}
REPEATS = 3
WIDTHS = (16, 10, 9, 10, 10, 10)
# of the linear approach, where CalculiX's finite strain changes to a force (docs/evidence/facts.md)
SOFTER = 0.95


@dataclass(frozen=True)
class Row:
    """One mesh of one program."""

    setting: str
    found: PressedPad


def own(pad: Pad, model: str, fineness: float, order: int) -> PressedPad:
    """Return skincad's level of a model; its time is the median of a few runs, the first left out."""
    seconds, more = [], []
    for _ in range(REPEATS):
        solver = linear.level if model == "linear" else finite_strain.Levels()
        started, clock = process_time(), perf_counter()
        answer = solver(plane_piece(pad, fineness), order, FORCE, ())
        seconds.append(process_time() - started)
        # stages are wall times: their share of the whole is what counts
        more.append(seconds[-1] * answer.seconds.get("threshold", 0.0) / (perf_counter() - clock))
    spent = statistics.median(seconds), statistics.median(more)
    return PressedPad(answer.ridge_force, answer.approach, answer.unknowns, *spent)


def missed(found: PressedPad, reference: PressedPad) -> float:
    """Return the largest difference of shares, N."""
    return float(np.abs(found.shares - reference.shares).max())


def envelope(
    seconds: NDArray[np.float64], errors: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the rows that no quicker row beats, quickest first."""
    order = np.argsort(seconds)
    lowest = np.minimum.accumulate(errors[order])
    kept = order[errors[order] <= lowest]
    return seconds[kept], errors[kept]


def time_at(error: float, seconds: NDArray[np.float64], errors: NDArray[np.float64]) -> float:
    """Return the time that this error takes, log-log between the rows that no quicker row beats.

    Above the largest error it is the quickest row's: never extrapolated. Below the smallest it is nan.
    """
    time, left = envelope(seconds, errors)
    if error < left[-1]:
        return float("nan")
    return float(np.exp(np.interp(-np.log(error), -np.log(left), np.log(time))))


def compare(pad: Pad, model: str, start: float | None) -> None:
    """Print one model's table and ratios."""
    ours = [Row(f"skincad {f:g}, {k}", own(pad, model, f, k)) for f, k in LEVELS]
    theirs = [Row(f"CalculiX {f:g}", calculix.press(pad, f, FORCE, start)) for f in MESHES[model]]
    knowing = MESHES[model] if start is None else ()
    halves = [Row(f"its half {f:g}", calculix.press(pad, f, FORCE, whole=False)) for f in knowing]
    best, finest = ours[-1].found, theirs[-1].found
    print(f"\n{model}: errors against skincad's finest, and against the program's own finest")
    names = ("fineness", "unknowns", "time, s", "share, N", "own, N", "approach")
    print("".join(f"{name:>{width}}" for name, width in zip(names, WIDTHS, strict=True)) + "  shares, N")
    for rows, last in ((ours, best), (theirs, finest), (halves, halves[-1].found if halves else None)):
        for row in rows:
            f = row.found
            own_error = "" if f is last else f"{missed(f, last):.1e}"
            error = "" if f is best else f"{missed(f, best):.1e}"
            half = " ".join(f"{s:.4f}" for s in f.shares[: (f.shares.size + 1) // 2])
            off = f"{f.approach / best.approach - 1:+.1e}"
            cells = (row.setting, str(f.unknowns), f"{f.seconds:.2f}", error, own_error, off)
            print("".join(f"{c:>{width}}" for c, width in zip(cells, WIDTHS, strict=True)) + f"  {half}")
    ratios(model, [row.found for row in ours], [*theirs, *halves])


def ratios(model: str, ours: list[PressedPad], theirs: list[Row]) -> None:
    """Print the times at equal error, the errors against the last of `ours`."""
    *levels, best = ours
    whole = np.array([level.seconds for level in levels])
    contact = whole - np.array([level.more for level in levels])
    errors = np.array([missed(level, best) for level in levels])
    print(f"times at equal error, CalculiX's over skincad's (goal {GOALS[model]:g})")
    for row in theirs:
        error = missed(row.found, best)
        both = [row.found.seconds / time_at(error, time, errors) for time in (whole, contact)]
        bound = "at least " if error > errors.max() else ""
        without = f", {both[1]:.0f}x without the all-touch force" if best.more else ""
        print(f"{row.setting:>16}  error {error:.1e} N: {bound}{both[0]:.0f}x{without}")


def main() -> None:
    if calculix.missing():
        print(calculix.missing())
        return
    pad = pad_of(load("plain-ridges"))
    own(pad, "linear", 0.25, 2)  # imports and caches
    softer = SOFTER * own(pad, "linear", 0.5, 2).approach
    compare(pad, "linear", None)
    if sys.argv[1:] == ["linear"]:
        return
    compare(pad, "finite-strain", softer)


if __name__ == "__main__":
    with threadpool_limits(limits=1, user_api="blas"):
        main()
