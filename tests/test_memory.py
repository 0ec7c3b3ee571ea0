"""Memory that a call takes and never gives back: what a server or a sweep of thousands would die of."""

from __future__ import annotations

import ctypes
import gc
import sys
from collections.abc import Callable

import pytest

import skincad
from skincad.mechanics import default_sizes, pad_of, section_forms, triangles
from skincad.mechanics.bodies import elements

# MB a call of what malloc has given out and not got back: exact, unlike the resident size. A point of an
# element's map that stays is 160 bytes, 0.05 and 1.3 MB a call here; NGSolve's own tables grow by below 0.002
KEPT = 0.005
BLOCKS = 40  # Python's own blocks a check, of at most 512 bytes each, that are not given back


class _Malloc(ctypes.Structure):
    """glibc's struct mallinfo2."""

    _fields_ = [
        (name, ctypes.c_size_t)
        for name in (
            *("arena", "ordblks", "smblks", "hblks", "hblkhd"),
            *("usmblks", "fsmblks", "uordblks", "fordblks", "keepcost"),
        )
    ]


def in_use() -> float:
    """Return the MB that malloc has given out; skips where the C library does not tell."""
    answer = getattr(ctypes.CDLL(None), "mallinfo2", None)
    if answer is None:
        pytest.skip("the C library has no mallinfo2 (glibc has it from 2.33 on)")
    answer.restype = _Malloc
    seen = answer()
    return float(seen.uordblks + seen.hblkhd) / 1e6


def kept(call: Callable[[], object], times: int) -> float:
    """Return the MB that a call keeps, once what is made only once is there."""
    for _ in range(2):
        call()
    gc.collect()
    gc.freeze()  # what other tests left; to look through it at each collection takes longer than the calls
    before = in_use()
    for _ in range(times):
        call()
        gc.collect()
    return (in_use() - before) / times


@pytest.mark.slow
def test_finite_elements_give_their_memory_back() -> None:
    pad = pad_of(skincad.load("plain-ridges").with_(ridge={"count": 1}, skin={"width": 3.0}))
    materials = {"skin": (1.0, pad.poisson_ratio)}
    mesh = elements.curved(triangles(pad, default_sizes(pad)), 2)
    system = elements.assemble(mesh, 2, materials)
    jobs: dict[str, Callable[[], object]] = {
        "mesh": lambda: elements.curved(triangles(pad, default_sizes(pad)), 2),
        "assemble": lambda: elements.assemble(mesh, 2, materials),
        "outlines": lambda: elements.outlines(system, system.lift),
        "section": lambda: section_forms(mesh, 2, materials),
    }
    # of four calls, what tables grow by once for all was up to 0.006 MB a call; of eight it is half of that
    assert {name: growth for name, job in jobs.items() if (growth := kept(job, 8)) > KEPT} == {}


@pytest.mark.parametrize(
    "checks",
    [
        pytest.param(14, marks=pytest.mark.slow),
        pytest.param(60, marks=pytest.mark.evidence(subject="memory of checks")),
    ],
)
def test_checks_take_no_more_memory_than_those_before(checks: int) -> None:
    # by what is given out, not by resident memory, which jumps by a MB when it likes
    design = skincad.load("plain-ridges").with_(ridge={"count": 1}, skin={"width": 3.0})

    def job() -> None:
        skincad.check(design, force=1.0, model="linear", tol=0.3)

    kept(job, checks // 2)
    before = sys.getallocatedblocks()
    assert kept(job, checks) < KEPT
    assert (sys.getallocatedblocks() - before) / checks < BLOCKS
