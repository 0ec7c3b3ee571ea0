"""What the benchmarks share: times, a process of its own for its peak memory, and a design's own matrix."""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
from collections.abc import Callable
from time import perf_counter
from typing import Any

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from skincad.inputs import Design
from skincad.mechanics import pad_of, plane_piece
from skincad.mechanics.bodies import elements

REPEATS = 3
ORDER = 3


def times(work: Callable[[], object], repeats: int = REPEATS) -> list[float]:
    """Return the wall time of each run, s."""
    rows = []
    for _ in range(repeats):
        started = perf_counter()
        work()
        rows.append(perf_counter() - started)
    return rows


def best(work: Callable[[], object]) -> float:
    """Return the shortest of a few runs, s: the one that the other users of the machine disturbed least."""
    return min(times(work))


def alone(function: Callable[..., dict[str, Any]], *arguments: object) -> dict[str, Any]:
    """Return what a function of a module finds in a fresh process, with its `peak_MB`, on one processor.

    A process inherits its parent's peak when it starts: call this before the parent has done any work.
    """
    code = (
        "import json, sys\n"
        "from importlib import import_module\n"
        "from bench.measure import peak\n"
        "module, function, arguments = json.loads(sys.argv[1])\n"
        "found = getattr(import_module(module), function)(*arguments)\n"
        "print(json.dumps({**found, 'peak_MB': peak()}))"
    )
    # a module that is run as a program calls itself __main__
    spec = getattr(sys.modules[function.__module__], "__spec__", None)
    module = function.__module__ if spec is None else spec.name
    done = subprocess.run(
        [sys.executable, "-c", code, json.dumps([module, function.__name__, arguments])],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
        timeout=3600,
    )
    if done.returncode:
        raise RuntimeError(done.stderr[-2000:])
    return dict(json.loads(done.stdout.splitlines()[-1]))


def peak() -> float:
    """Return this process's largest resident memory so far, MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def system(design: Design, fineness: float, order: int = ORDER) -> elements.ContactStiffness:
    """Return a design's condensed stiffness."""
    pad = pad_of(design)
    mesh = elements.curved(plane_piece(pad, fineness).mesh, order)
    return elements.symmetric_system(elements.assemble(mesh, order, pad.materials))


def free_block(found: elements.ContactStiffness) -> sparse.csc_matrix:
    """Return the stiffness over the free unknowns, contact unknowns last."""
    free = np.concatenate([found.interior, found.contact])
    return sparse.csc_matrix(found.matrix[free][:, free])


def factorise(block: sparse.csc_matrix) -> Any:
    """Factorise once, in SuperLU's best order for a symmetric matrix."""
    return splu(block, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
