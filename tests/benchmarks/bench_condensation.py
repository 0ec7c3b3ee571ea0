"""Condensation to the contact unknowns, and where a check's time goes.

`python -m tests.benchmarks.bench_condensation` prints ratios of times taken in one run: the trailing
block of one factorisation against a solve per contact unknown, on three meshes of the section without
slots and on the default design; and each stage of the default check against one factorisation of its
own matrix.
"""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu
from threadpoolctl import threadpool_limits

from skincad import load
from skincad.design import Design
from skincad.mechanics import elements
from skincad.mechanics.check import check
from skincad.mechanics.condense import condense
from skincad.mechanics.mesh import default_sizes, triangles
from skincad.mechanics.problem import pad_of

REPEATS = 3
ORDER = 3


def best(work: Callable[[], object]) -> float:
    """Return the shortest of a few runs, s: the one that the other users of the machine disturbed least."""
    times = []
    for _ in range(REPEATS):
        started = perf_counter()
        work()
        times.append(perf_counter() - started)
    return min(times)


def system(design: Design, fineness: float) -> elements.Assembled:
    """Return a design's condensed stiffness."""
    pad = pad_of(design)
    materials = {"skin": (1.0, pad.poisson_ratio)}
    if pad.strips:
        materials["film"] = (pad.film_modulus / pad.young_modulus, pad.film_ratio)
    mesh = elements.curved(triangles(pad, default_sizes(pad, fineness)), ORDER)
    return elements.assemble(mesh, ORDER, materials)


def solve_each(block: sparse.csc_matrix, contact: int) -> np.ndarray:
    """Factorise and solve once for every contact unknown, which are last."""
    factor = splu(block, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    rows = np.empty((contact, contact))
    side = np.zeros(block.shape[0])
    for i in range(contact):
        side[i - contact] = 1.0
        rows[i] = factor.solve(side)[-contact:]
        side[i - contact] = 0.0
    return rows


def factorise(block: sparse.csc_matrix) -> object:
    """Factorise once, in SuperLU's best order for a symmetric matrix."""
    return splu(block, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})


def main() -> None:
    """Print both tables."""
    print(
        f"{'unknowns':>9} {'contact':>8} {'factor, s':>10} {'trailing':>9} {'each':>7} {'each/trailing':>14}"
    )
    default = load("yamada-2002")
    bare = default.with_(slot=None, film=None, contact={"film": "ignored"})
    for design, fineness in ((bare, 1.0), (bare, 2.0), (bare, 4.0), (default, 1.0)):
        found = system(design, fineness)
        free = np.concatenate([found.interior, found.contact])
        block, k = sparse.csc_matrix(found.matrix[free][:, free]), found.contact.size
        factor = best(lambda b=block: factorise(b))
        trailing = best(lambda f=found: condense(f.matrix, f.interior, f.contact)) / factor
        each = best(lambda b=block, c=k: solve_each(b, c)) / factor
        print(f"{free.size:9d} {k:8d} {factor:10.3f} {trailing:9.2f} {each:7.1f} {each / trailing:14.1f}")
    once = factor
    runs = [check(load("yamada-2002")) for _ in range(REPEATS)]
    quickest = min(runs, key=lambda c: c.seconds["total"])
    print("\ncheck yamada-2002, times of one factorisation of its own matrix (fineness 1)")
    for stage, seconds in quickest.seconds.items():
        print(f"{stage:>9} {seconds / once:6.2f}   ({seconds:.3f} s)")


if __name__ == "__main__":
    with threadpool_limits(limits=1, user_api="blas"):
        main()
