"""One BLAS thread while something is solved, and as many as before when nothing is."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock

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
                self.limits = threadpool_limits(limits=1, user_api="blas")
            self.inside += 1

    def leave(self) -> None:
        """Restore what was before the first entered, if nobody else is inside."""
        with self.lock:
            self.inside -= 1
            if self.limits is not None and self.inside == 0:
                self.limits.restore_original_limits()
                self.limits = None


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
