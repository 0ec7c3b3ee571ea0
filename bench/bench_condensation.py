"""Condensation to the contact unknowns: the trailing block of one factorisation against a solve for each.

`python -m bench.bench_condensation` prints ratios of times taken in one run, on three meshes of
the section without slots and on the default design. Where a check's time goes: bench_check.py.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse
from threadpoolctl import threadpool_limits

from bench.measure import best, factorise, free_block, system
from skincad import load
from skincad.mechanics import condense


def solve_each(block: sparse.csc_matrix, contact: int) -> np.ndarray:
    """Factorise and solve once for every contact unknown, which are last."""
    factor = factorise(block)
    rows = np.empty((contact, contact))
    side = np.zeros(block.shape[0])
    for i in range(contact):
        side[i - contact] = 1.0
        rows[i] = factor.solve(side)[-contact:]
        side[i - contact] = 0.0
    return rows


def main() -> None:
    """Print the table."""
    print(
        f"{'unknowns':>9} {'contact':>8} {'factor, s':>10} {'trailing':>9} {'each':>7} {'each/trailing':>14}"
    )
    default = load("yamada-2002")
    bare = default.with_(slot=None, film=None, contact={"film": "ignored"})
    for design, fineness in ((bare, 1.0), (bare, 2.0), (bare, 4.0), (default, 1.0)):
        equations = system(design, fineness)
        block, k = free_block(equations), equations.contact.size
        factor = best(lambda b=block: factorise(b))
        trailing = best(lambda f=equations: condense(f.matrix, f.interior, f.contact)) / factor
        each = best(lambda b=block, c=k: solve_each(b, c)) / factor
        size = block.shape[0]
        print(f"{size:9d} {k:8d} {factor:10.3f} {trailing:9.2f} {each:7.1f} {each / trailing:14.1f}")


if __name__ == "__main__":
    with threadpool_limits(limits=1, user_api="blas"):
        main()
