"""Faults: a run that is killed, interrupted, out of space or not alone leaves the old or new result, whole.

skincad starts no workers of its own (test_no_workers): there is no part of it that could be killed alone.
"""

from __future__ import annotations

import ast
import hashlib
import os
import random
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest

import skincad
from tests.conftest import run_skincad

JOBS = {
    "make": ("make", "plain-ridges", "--format", "stl", "--set", "ridge.count=3", "--set", "skin.width=5.0"),
    "simulate": ("simulate", "yamada-2002-press", "--set", "readout.ridges=[]", "--set", "effects.film=none"),
    "circuit": ("circuit", "yamada-2002", "--set", "sweep.points=50"),
}
OTHER = {
    "make": ("--set", "ridge.height=0.45"),
    "simulate": ("--set", "history.steps=9"),
    "circuit": ("--set", "amplifier.gain=2e4"),
}
FIRST = {"make": (), "simulate": ("--set", "history.steps=8"), "circuit": ()}
SLOW = ["circuit", *(pytest.param(job, marks=pytest.mark.slow) for job in ("make", "simulate"))]
TIMED = {"simulate.json"}  # tells how long the run took

Contents = dict[str, str]


def command(job: str, other: bool) -> list[str]:
    return [sys.executable, "-m", "skincad", *JOBS[job], *(OTHER if other else FIRST)[job], "-o", "here"]


def contents(folder: Path) -> Contents:
    """File name to hash; of a file that tells the time, that it is whole."""
    return {
        p.name: "whole" if p.name in TIMED and p.read_bytes().endswith(b"}\n") else _hash(p)
        for p in folder.iterdir()
    }


def _hash(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def started(job: str, other: bool, cwd: Path) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        command(job, other), cwd=cwd, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )


@cache
def whole(job: str, other: bool) -> tuple[tuple[tuple[str, str], ...], float]:
    """What an undisturbed run leaves, and how many seconds it takes."""
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        began = time.monotonic()
        assert started(job, other, Path(folder)).wait(timeout=300) in (0, 1)
        seconds = time.monotonic() - began
        return tuple(sorted(contents(Path(folder) / "here").items())), seconds


@pytest.mark.slow
@pytest.mark.parametrize(("job", "times"), [("make", 22), ("simulate", 14), ("circuit", 14)])
def test_killed_at_random_moments(job: str, times: int, tmp_path: Path) -> None:
    results = [dict(whole(job, other)[0]) for other in (False, True)]
    seconds = whole(job, True)[1]
    assert results[0] != results[1]
    run_skincad(*command(job, False)[3:], cwd=tmp_path)
    dice = random.Random(2002)
    for i in range(times):
        # a third of the moments near the end, where files are written and folders renamed
        moment = dice.uniform(0.85, 1.05) if i % 3 == 0 else dice.uniform(0.1, 1.0)
        running = started(job, i % 2 == 0, tmp_path)
        time.sleep(moment * seconds)
        running.kill()
        running.wait()
        there = tmp_path / "here"
        if there.exists():
            assert contents(there) in results
        else:  # killed between two renames: the earlier result lies beside, whole
            (beside,) = tmp_path.glob(".here.*.old")
            assert contents(beside) in results
    assert started(job, True, tmp_path).wait(timeout=300) in (0, 1)
    assert contents(tmp_path / "here") == results[1]
    assert [p.name for p in tmp_path.iterdir()] == ["here"]  # what killed runs left is gone


def killed_within(folder: Path, program: str) -> None:
    """Run a Python program that kills itself while it replaces `here`."""
    head = "import os, signal\nfrom pathlib import Path\nfrom skincad import outfolder\n"
    die = "def die(*_, **__): os.kill(os.getpid(), signal.SIGKILL)\n"
    run = "with outfolder.replaced(Path('here')) as staging:\n    (staging / 'a').write_text('new')\n"
    run += "    (staging / 'make.json').write_text('{\"files\": [\"a\"]}')\n"
    done = subprocess.run([sys.executable, "-c", head + die + program + run], cwd=folder, check=False)
    assert done.returncode == -signal.SIGKILL


PLACES = {
    "before the first rename": "outfolder._swap = die\n",
    "between the renames": (
        "rename = Path.rename\n"
        "Path.rename = lambda self, to: die() if self.suffix == '.new' else rename(self, to)\n"
    ),
    "before the old one is removed": "outfolder.shutil.rmtree = die\n",
}


@pytest.mark.parametrize("place", PLACES)
def test_killed_at_each_place_of_the_swap(place: str, tmp_path: Path) -> None:
    from skincad.outfolder import MANIFEST, replaced

    with replaced(tmp_path / "here") as staging:
        (staging / "a").write_text("old")
        (staging / MANIFEST).write_text('{"files": ["a"]}')
    (tmp_path / "here" / "notes").write_text("mine")
    killed_within(tmp_path, PLACES[place])
    with pytest.raises(RuntimeError), replaced(tmp_path / "here"):
        raise RuntimeError  # the next run, which fails, has put all right nevertheless
    assert [p.name for p in tmp_path.iterdir()] == ["here"]
    expected = "new" if place == "before the old one is removed" else "old"
    assert (tmp_path / "here" / "a").read_text() == expected
    assert (tmp_path / "here" / "notes").read_text() == "mine"


def test_what_another_run_is_writing_is_left_alone(tmp_path: Path) -> None:
    from skincad.outfolder import replaced

    with replaced(tmp_path / "here") as one:
        (one / "a").write_text("one")
        done = subprocess.run(
            [sys.executable, "-c", "from pathlib import Path\nfrom skincad.outfolder import replaced\n"
             "with replaced(Path('here')) as two: (two / 'make.json').write_text('{\"files\": []}')"],
            cwd=tmp_path, check=False,
        )  # fmt: skip
        assert done.returncode == 0
        assert (one / "a").read_text() == "one"
    assert (tmp_path / "here" / "a").read_text() == "one"


def test_two_runs_into_one_folder_at_once(tmp_path: Path) -> None:
    """Both start together, twice: one of the two results is there, whole, and nothing beside it."""
    results = [dict(whole("circuit", other)[0]) for other in (False, True)]
    for _ in range(2):
        runs = [started("circuit", other, tmp_path) for other in (False, True)]
        assert [run.wait(timeout=300) for run in runs] == [0, 0]
        assert contents(tmp_path / "here") in results
        assert [p.name for p in tmp_path.iterdir()] == ["here"]


@pytest.mark.parametrize("job", SLOW)
def test_a_full_disk(job: str, tmp_path: Path) -> None:
    """No file above 2 kB can be written: one line, status 2, the earlier result as it was."""
    run_skincad(*command(job, False)[3:], cwd=tmp_path)
    earlier = contents(tmp_path / "here")
    done = subprocess.run(
        command(job, True),
        cwd=tmp_path, capture_output=True, text=True, check=False,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (2_000, 2_000)),
    )  # fmt: skip
    assert done.returncode == 2, done.stderr
    assert done.stderr.count("\n") == 1
    assert contents(tmp_path / "here") == earlier
    assert [p.name for p in tmp_path.iterdir()] == ["here"]


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
@pytest.mark.parametrize("job", SLOW)
def test_a_read_only_folder(job: str, tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    try:
        done = run_skincad(*command(job, False)[3:], cwd=tmp_path)
    finally:
        tmp_path.chmod(0o700)
    assert done.returncode == 2
    assert done.stderr.startswith("skincad: -o: here cannot be written")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("job", SLOW)
def test_a_folder_that_cannot_be_made(job: str, tmp_path: Path) -> None:
    """Also as root: /proc takes no folders."""
    arguments = [*command(job, False)[3:-1], "/proc/self/here"]
    done = run_skincad(*arguments, cwd=tmp_path)
    assert done.returncode == 2
    assert done.stderr.startswith("skincad: -o: /proc/self/here cannot be written")
    assert done.stderr.count("\n") == 1


@pytest.mark.slow
@pytest.mark.parametrize("job", ["make", "simulate"])
def test_ctrl_c(job: str, tmp_path: Path) -> None:
    """Status 130 and no half files: make leaves the earlier result, simulate what is done by then."""
    run_skincad(*command(job, False)[3:], cwd=tmp_path)
    earlier = contents(tmp_path / "here")
    long = command(job, True) + (["--set", "history.steps=200000"] if job == "simulate" else [])
    running = subprocess.Popen(long, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    busy: Callable[[], bool] = lambda: bool(list(tmp_path.glob(".here.*.new")))  # noqa: E731
    deadline = time.monotonic() + 60
    while job == "make" and not busy() and running.poll() is None and time.monotonic() < deadline:
        time.sleep(0.01)
    if job == "simulate":
        time.sleep(2.5 * whole("simulate", True)[1])  # in the march: imports and meshing are over
    running.send_signal(signal.SIGINT)
    _, err = running.communicate(timeout=120)
    assert running.returncode == 130, err
    assert "Traceback" not in err
    assert [p.name for p in tmp_path.iterdir()] == ["here"]
    if job == "make":
        assert contents(tmp_path / "here") == earlier
    else:
        assert contents(tmp_path / "here").keys() == earlier.keys()


def test_no_workers() -> None:
    """No part of skincad starts threads or processes: none can die alone."""
    starters = {"multiprocessing", "concurrent", "subprocess", "threading", "joblib", "asyncio"}
    for file in Path(skincad.__file__).parent.rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text("utf-8"))):
            if isinstance(node, ast.Import | ast.ImportFrom):
                names = (
                    [node.module or ""] if isinstance(node, ast.ImportFrom) else [a.name for a in node.names]
                )
                assert not {name.split(".")[0] for name in names} & starters, file
