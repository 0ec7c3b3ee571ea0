"""Same input, same bytes: on one thread or two, in any folder, whatever the order of Python's sets, and by
another numpy.

What is told of time differs: `seconds` in simulate.json. Step files name no time. Another numpy has another
OpenBLAS: then the last digits of forces in make.json differ too, and no other file (2.4.6 and 2.2.6).
SKINCAD_OTHER_NUMPY names a folder with another numpy (`pip install --target FOLDER numpy==...`).
"""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import pytest

from skincad.base import files_below
from tests.conftest import skincad_process
from tests.processes import python

JOBS = {
    "make": ("make", "yamada-2002", "--model", "corrected"),  # auto goes by the clock
    "simulate": ("simulate", "yamada-2002-press-and-pull", "--set", "history.steps=20"),
    "circuit": ("circuit", "yamada-2002", "--set", "sweep.points=50"),
}
OTHER_NUMPY = os.environ.get("SKINCAD_OTHER_NUMPY", "")
FIRST = os.pathsep.join([OTHER_NUMPY, *filter(None, [os.environ.get("PYTHONPATH")])])
# a tenth of the last digit that a table prints; rounding in BLAS, which another build sums in another order
SAME = 1e-6


def run(job: str, folder: str, cwd: Path, **environment: str) -> Path:
    done = skincad_process(*JOBS[job], "-o", folder, cwd=cwd, **environment)
    assert done.returncode == 0, done.stderr
    return cwd / folder


def told(path: Path) -> Any:
    """A file's bytes, or without the time that it tells."""
    if path.name != "simulate.json":
        return path.read_bytes()
    data = json.loads(path.read_text("utf-8"))
    assert data.pop("seconds")
    return data


@pytest.mark.slow
@pytest.mark.parametrize("job", ["circuit", "make", "simulate"])
def test_same_bytes_on_one_thread_and_on_two(job: str, tmp_path: Path) -> None:
    one, two = (
        run(job, name, tmp_path, PYTHONHASHSEED=name, OPENBLAS_NUM_THREADS=name, OMP_NUM_THREADS=name)
        for name in ("1", "2")
    )
    names = list(files_below(one))
    assert names == list(files_below(two))
    for name in names:
        assert told(one / name) == told(two / name), name


def other_version() -> str:
    program = "import numpy; print(numpy.__version__)"
    done = python(program, PYTHONPATH=FIRST)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


@pytest.mark.slow
@pytest.mark.skipif(not OTHER_NUMPY, reason="SKINCAD_OTHER_NUMPY names no folder")
@pytest.mark.parametrize("job", ["make", "simulate", "circuit"])
def test_same_bytes_by_another_numpy(job: str, tmp_path: Path, record_property: Any) -> None:
    """Files that differ are told; their numbers differ by rounding at most."""
    import numpy as np

    assert other_version() != np.__version__
    one, two = run(job, "one", tmp_path), run(job, "two", tmp_path, PYTHONPATH=FIRST)
    names = list(files_below(one))
    assert names == list(files_below(two))
    differ = [name for name in names if told(one / name) != told(two / name)]
    record_property("summary", f"numpy {np.__version__} and {other_version()}: differ {differ or 'nothing'}")
    for name in differ:
        here, there = (_numbers(folder / name) for folder in (one, two))
        assert len(here) == len(there), name
        assert here == pytest.approx(there, rel=SAME, abs=SAME), name


def _numbers(path: Path) -> list[float]:
    """All numbers of a text file but those of a time and of hashes."""
    import re

    text = json.dumps(told(path)) if path.name == "simulate.json" else path.read_text("utf-8")
    text = re.sub(r"[0-9a-f]{64}", "", text)
    return [float(n) for n in re.findall(r"-?\d+\.?\d*(?:e[-+]?\d+)?", text)]
