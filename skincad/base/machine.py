"""The machine: its processor, and one BLAS thread for small dense solves."""

from __future__ import annotations

import os
import platform
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from importlib.metadata import version
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np
from scipy.linalg import solve_triangular
from threadpoolctl import threadpool_limits


@cache
def _ask_for_memory() -> None:
    """Let BLAS allocate what it works in, once and before anything large: OpenBLAS asks again for ever for
    memory that is not there, and no signal ends that."""
    for solve in (solve_triangular, np.linalg.solve):  # scipy and numpy bring one each
        solve(np.eye(2), np.ones(2))


# BLAS has one number of threads for the whole process: the limit, once for each block that is inside it
_LOCK = Lock()
_INSIDE: list[threadpool_limits] = []


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Solve the block with one BLAS thread: on dense blocks as small as ours more only wait for each other,
    3 to 60 times longer.

    Blocks may nest and overlap between threads: the first to enter sets the limit for the process, the last
    to leave restores what was there before.
    """
    with _LOCK:
        if not _INSIDE:
            _ask_for_memory()
        _INSIDE.append(_INSIDE[0] if _INSIDE else threadpool_limits(limits=1, user_api="blas"))
    try:
        yield
    finally:
        with _LOCK:
            limit = _INSIDE.pop()
            if not _INSIDE:
                limit.restore_original_limits()


LIBRARIES = ("ngsolve", "numpy", "scipy", "cadquery", "manifold3d", "skincad")


def machine() -> dict[str, Any]:
    """Return processor, cores that this process may use, load and versions; no host name, no user.

    `load` is the machine's mean number of running processes over the last minute, None where it is unknown:
    above 1 a core the times are somebody else's too.
    """
    return {
        "processor": _processor(),
        "cores": len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count(),
        "load": round(os.getloadavg()[0], 2) if hasattr(os, "getloadavg") else None,
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        "versions": {name: version(name) for name in LIBRARIES},
    }


def _processor() -> str:
    """The model's name as the system reports it."""
    info = Path("/proc/cpuinfo")
    if info.is_file():
        for line in info.read_text("utf-8", errors="replace").splitlines():
            key, _, value = line.partition(":")
            if key.strip() == "model name":
                return " ".join(value.split())
    return platform.processor() or platform.machine()
