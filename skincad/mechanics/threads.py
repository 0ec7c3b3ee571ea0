"""One BLAS thread for the small dense solves: more of them only wait for each other, 3 to 60 times longer."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext


def one_blas_thread() -> AbstractContextManager[object]:
    """Return a context in which BLAS runs on one thread.

    Without threadpoolctl nothing is limited: results are the same, a busy machine takes longer, and
    OPENBLAS_NUM_THREADS=1 before the start does the same.
    """
    try:
        from threadpoolctl import threadpool_limits  # type: ignore[import-not-found, import-untyped, unused-ignore]
    except ImportError:
        return nullcontext()
    limits: AbstractContextManager[object] = threadpool_limits(limits=1, user_api="blas")
    return limits
