"""Whether `check --budget` and `check --tol` keep what they promise, on every template.

`python -m tests.benchmarks.table_accuracy [--only budget|tol] [template]...` prints, per template, the model
that a budget buys and how long it took against the budget; then, for the linear tier's mesh, what a tolerance
takes and whether the truth, the ladder's finest rung, lies within it. Times are seconds without imports.
"""

from __future__ import annotations

import argparse

from threadpoolctl import threadpool_limits

import skincad
from skincad.catalog import template_names
from skincad.design import Design
from skincad.mechanics.check import check
from skincad.mechanics.linear import FLOOR, RUNGS, level
from skincad.mechanics.mesh import default_sizes, triangles
from skincad.mechanics.problem import pad_of
from skincad.mechanics.tiers import AUTO, load
from skincad.mechanics.verdict import ContactCheck

BUDGETS = 1.0, 3.0, 10.0
TOLERANCES = 0.05, 0.01, 0.002
KEPT = 1.5  # times the budget


def budgets(names: list[str]) -> int:
    """Print the table of budgets; return how many were not kept."""
    late = 0
    print(f"{'template':22}" + "".join(f"{f'--budget {b:g}':>32}" for b in BUDGETS))
    for name in names:
        cells = []
        for budget in BUDGETS:
            found = check(skincad.load(name), budget=budget)
            spent = found.seconds["total"]
            late += spent > KEPT * budget
            cells.append(f"{found.tier:>24} {spent:5.2f} s{'!' if spent > KEPT * budget else ' '}")
        print(f"{name:22}" + "".join(cells), flush=True)
    print(f"{late} of {len(names) * len(BUDGETS)} took more than {KEPT:g} times the budget\n")
    return late


def tolerances(names: list[str]) -> int:
    """Print the table of tolerances; return how many were missed by the truth or said to be not met."""
    missed = 0
    print(f"{'template':22}" + "".join(f"{f'--tol {t:g}: time, error stated, true':>36}" for t in TOLERANCES))
    for name in names:
        design = skincad.load(name)
        truth = finest(design)
        cells = []
        for tol in TOLERANCES:
            found = check(design, tier="linear", tol=tol)
            stated, true = apart(found, truth)
            bad = true > tol or any("not met" in warning for warning in found.warnings)
            missed += bad
            cells.append(f"{found.seconds['total']:16.2f} s {stated:8.1e} {true:8.1e}{'!' if bad else ' '}")
        print(f"{name:22}" + "".join(cells), flush=True)
    print(f"{missed} of {len(names) * len(TOLERANCES)} not met")
    return missed


def finest(design: Design) -> tuple[float | None, float]:
    """Return F9 and approach of the linear ladder's last rung."""
    pad, rung = pad_of(design), RUNGS[-1]
    found = level(pad, triangles(pad, default_sizes(pad, rung.fineness)), rung.order, design.contact.force)
    return found.all_touch_force, found.approach


def apart(found: ContactCheck, truth: tuple[float | None, float]) -> tuple[float, float]:
    """Return the largest relative error of F9 and approach, as the mesh's is stated and as it is."""
    approach, force = found.approach, found.all_touch_force
    left_out = sum(bound.approach for bound in found.left_out) * (approach.value or 0.0)
    stated = [((approach.error or 0.0) - left_out) / (approach.value or 1.0)]
    true = [abs((approach.value or 0.0) / truth[1] - 1)]
    if force.value is not None and truth[0] is not None and found.ridges > 1:
        scale = max(truth[0], FLOOR * found.force)
        stated.append(((force.error or 0.0) - found.model_error) / scale)
        true.append(abs(force.value - truth[0]) / scale)
    return max(stated), max(true)


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser()
    parser.add_argument("names", nargs="*", default=template_names())
    parser.add_argument("--only", choices=("budget", "tol"))
    asked = parser.parse_args()
    for tier in AUTO:  # imports are no part of a budget
        load(tier)
    check(skincad.load("plain-ridges"), tier="linear")
    if asked.only != "tol":
        budgets(asked.names)
    if asked.only != "budget":
        tolerances(asked.names)


if __name__ == "__main__":
    with threadpool_limits(limits=1, user_api="blas"):
        main()
