"""The process keeps its BLAS threads, and each thread its numbers, however checks overlap."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

import skincad
from skincad.base import one_blas_thread
from skincad.inputs import Design
from skincad.mechanics import default_sizes, pad_of, triangles
from skincad.mechanics.bodies import elements

BEFORE = 2  # of a user's own choice
# a thread has a heap of its own, where arrays are aligned otherwise: sums in BLAS and numpy then round
# otherwise, in a thread that is alone too
ROUNDING = 1e-12


def blas_threads() -> set[int]:
    """The numbers of threads of all BLAS libraries that are loaded."""
    return {pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"}


@pytest.fixture(autouse=True)
def several_threads() -> Iterator[None]:
    with threadpool_limits(limits=BEFORE, user_api="blas"):
        yield


@pytest.mark.parametrize("order", [(0, 1), (1, 0), (0, 1, 2), (2, 0, 1)])
def test_the_last_to_leave_restores_whatever_the_order(order: tuple[int, ...]) -> None:
    blocks = [one_blas_thread() for _ in order]
    for block in blocks:
        block.__enter__()
    for left, number in enumerate(order, 1):
        assert blas_threads() == {1}
        blocks[number].__exit__(None, None, None)
        assert blas_threads() == ({BEFORE} if left == len(order) else {1})


WITHOUT_MEMORY = """
import resource
import numpy as np
from scipy.linalg import solve_triangular
from skincad.base.machine import one_blas_thread
with one_blas_thread():
    pass
used = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (used + (8 << 20), used + (8 << 20)))
for solve in (solve_triangular, np.linalg.solve):
    assert np.allclose(solve(np.eye(100), np.ones(100)), 1.0)
"""


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="asks Linux how much memory is used")
def test_blas_has_what_it_works_in_before_memory_runs_out() -> None:
    """Else it would ask again for ever, deaf to signals: hence the timeout, of a run that takes a second."""
    subprocess.run([sys.executable, "-c", WITHOUT_MEMORY], check=True, timeout=120)


def test_an_error_inside_restores_too() -> None:
    with pytest.raises(ValueError, match="of the block"), ExitStack() as stack:
        stack.enter_context(one_blas_thread())
        raise ValueError("of the block")
    assert blas_threads() == {BEFORE}


def pads() -> list[Design]:
    """Two designs whose checks take unlike times, so that they overlap."""
    base = skincad.load("plain-ridges")
    return [base.with_(ridge={"count": n}, skin={"width": 1.0 + 2.0 * n}) for n in (1, 2)]


def assembled(design: Design) -> list[float]:
    """The finite elements' part of a check, without the rest that holds Python's lock for longest."""
    pad = pad_of(design)
    mesh = elements.curved(triangles(pad, default_sizes(pad)), 2)
    matrix = elements.assemble(mesh, 2, {"skin": (1.0, pad.poisson_ratio)}).matrix
    return [float(matrix.nnz), float(np.abs(matrix.data).sum())]


def linear(design: Design) -> list[float | None]:
    result = skincad.check(design, force=1.0, model="linear", tol=0.3)
    return [result.approach.value, result.all_touch_force.value, *(e.value for e in result.ridge_force)]


@pytest.mark.slow
@pytest.mark.parametrize(("job", "times"), [(linear, 1), (assembled, 2)])
def test_two_threads_give_the_numbers_of_one(job: Callable[[Design], object], times: int) -> None:
    designs = pads()
    alone = [job(design) for design in designs]
    with ThreadPoolExecutor(2) as pool:
        together = list(pool.map(job, times * designs))
    for values, expected in zip(together, times * alone, strict=True):
        assert values == pytest.approx(expected, rel=ROUNDING, abs=ROUNDING)
    assert blas_threads() == {BEFORE}
