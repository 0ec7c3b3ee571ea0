"""One BLAS thread while something is solved, and as many as before when nothing is."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from threading import Lock

import numpy as np
from scipy.linalg import solve_triangular
from threadpoolctl import threadpool_limits


class _Limit:
    """The limit that all threads share: BLAS has one number of threads for the whole process."""

    def __init__(self) -> None:
        self.lock, self.inside = Lock(), 0
        self.limits: threadpool_limits | None = None

    def enter(self) -> None:
        """Set the limit, if nobody else has."""
        with self.lock:
            if self.limits is None:
                _ask_for_memory()
                self.limits = threadpool_limits(limits=1, user_api="blas")
            self.inside += 1

    def leave(self) -> None:
        """Restore what was before the first entered, if nobody else is inside."""
        with self.lock:
            self.inside -= 1
            if self.limits is not None and self.inside == 0:
                self.limits.restore_original_limits()
                self.limits = None


@cache
def _ask_for_memory() -> None:
    """Let BLAS allocate what it works in, once and before anything large: OpenBLAS asks again for ever for
    memory that is not there, and no signal ends that."""
    for solve in (solve_triangular, np.linalg.solve):  # scipy and numpy bring one each
        solve(np.eye(2), np.ones(2))


_LIMIT = _Limit()


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Solve the block with one BLAS thread: on dense blocks as small as ours more only wait for each other,
    3 to 60 times longer.

    Blocks may nest and overlap between threads: the first to enter sets the limit for the process, the last
    to leave restores what was there before.
    """
    _LIMIT.enter()
    try:
        yield
    finally:
        _LIMIT.leave()
