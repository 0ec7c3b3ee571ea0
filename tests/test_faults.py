"""Faults: a run that is killed, interrupted, out of space or not alone leaves the old or new result, whole.

skincad starts no workers of its own (tests/attacks/test_code.py): no part of it could be killed alone.
"""

from __future__ import annotations

import hashlib
import json
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import pytest

from skincad.base import InputError, checked_folder, files_below, replaced
from tests.conftest import run_skincad
from tests.processes import python, started
from tests.refusals import refused_command

JOBS = {
    "make": (
        *("make", "plain-ridges", "--format", "stl", "--model", "winkler"),
        *("--set", "ridge.count=1", "--set", "skin.width=3.0"),
    ),
    "simulate": (
        *("simulate", "yamada-2002-press", "--set", "skin=steep-fingertip"),  # three ridges
        *("--set", "history.normal_force_N=[0.0, 0.5]", "--set", "readout.ridges=[]"),
        *("--set", "effects.film=none"),
    ),
    "circuit": ("circuit", "yamada-2002", "--set", "sweep.points=50"),
}
OTHER = {
    "make": ("--set", "ridge.height=0.45"),
    "simulate": ("--set", "history.steps=9"),
    "circuit": ("--set", "amplifier.gain=2e4"),
}
FIRST = {"make": (), "simulate": ("--set", "history.steps=8"), "circuit": ()}
SLOW = ["circuit", *(pytest.param(job, marks=pytest.mark.slow) for job in ("make", "simulate"))]
LOADED = {  # what a job imports and what takes long to import
    "make": ("skincad.solids.occ", "skincad.fabrication.measures", "skincad.mechanics.models.winkler"),
    "simulate": (
        "skincad.scenes.simulation",
        "skincad.mechanics.models.linear",
        "skincad.outputs.figures.canvas",
    ),
    "circuit": ("skincad.circuit.bode", "skincad.outputs.figures.results"),
}
QUIET = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
KILLS = 6  # of each job, two of them near its end
TIMED = {"simulate.json"}  # tells how long the run took

Contents = dict[str, str]


def command(job: str, other: bool) -> list[str]:
    return [sys.executable, "-m", "skincad", *JOBS[job], *(OTHER if other else FIRST)[job], "-o", "here"]


def contents(folder: Path) -> Contents:
    """File name to hash; of a file that tells the time, that it is whole. Without what is being written."""
    return {
        name: "whole" if name in TIMED and p.read_bytes().endswith(b"}\n") else _hash(p)
        for name, p in files_below(folder).items()
    }


def _hash(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


FORKING = """
import importlib, json, os, resource, sys
from skincad.cli import main
for module in sys.argv[1:]:
    importlib.import_module(module)
for line in iter(sys.stdin.readline, ""):
    folder, arguments, most = json.loads(line)
    err = os.memfd_create("err")
    child = os.fork()
    if not child:
        os.chdir(folder)
        sys.argv = ["skincad", *arguments]
        null = os.open(os.devnull, os.O_RDWR)
        os.dup2(null, 0), os.dup2(null, 1), os.dup2(err, 2)
        if most is not None:
            resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))
        try:
            main()
        except SystemExit as end:
            os._exit(int(end.code or 0))
        os._exit(99)
    print(child, flush=True)
    sys.stdin.readline()  # until then a child that has ended keeps its number
    status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    print(json.dumps([status, os.pread(err, 100_000, 0).decode()]), flush=True)
    os.close(err)
"""


Ran = Callable[..., tuple[int, str, float]]


@contextmanager
def forking(job: str) -> Iterator[Ran]:
    """Run commands in children of a process that has imported all of a job: the libraries' seconds, in which
    nothing is written, are spent once."""
    with started(
        [sys.executable, "-c", FORKING, *LOADED[job]],
        limit=800.0,  # of all runs of a slow test
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as parent:
        assert parent.stdin is not None
        assert parent.stdout is not None
        to, of = parent.stdin, parent.stdout

        def ran(
            command: list[str],
            folder: Path,
            moment: Callable[[], None] | None = None,
            signum: int = signal.SIGKILL,
            most: int | None = None,
        ) -> tuple[int, str, float]:
            """Run a command in a folder: status, stderr and seconds. It gets `signum` when `moment` returns,
            and no file gets above `most` bytes."""
            folder.mkdir(exist_ok=True)
            to.write(json.dumps([str(folder), command[3:], most]) + "\n")
            to.flush()
            child, began = int(of.readline()), time.monotonic()
            if moment:
                moment()
                os.kill(child, signum)
            to.write("\n")
            to.flush()
            status, err = json.loads(of.readline())
            return status, err, time.monotonic() - began

        yield ran


@pytest.mark.slow
@pytest.mark.dear("what a kill leaves is to be seen at many moments")
@pytest.mark.parametrize("job", JOBS)
def test_killed_at_random_moments(job: str, tmp_path: Path) -> None:
    dice, killed = random.Random(2002), 0
    place, there = tmp_path / "place", tmp_path / "place" / "here"
    with forking(job) as ran:
        results = []
        for other in (False, True):  # what an undisturbed run leaves
            status, _, seconds = ran(command(job, other), tmp_path / f"{other}")
            assert status in (0, 1)
            results.append(contents(tmp_path / f"{other}" / "here"))
        assert results[0] != results[1]
        assert ran(command(job, False), place)[0] in (0, 1)
        for i in range(KILLS):
            # a third of the moments near the end, where files are written and folders renamed
            wait = seconds * (dice.uniform(0.85, 1.05) if i % 3 == 0 else dice.uniform(0.1, 1.0))
            status, _, spent = ran(command(job, i % 2 == 0), place, partial(time.sleep, wait))
            if status == -signal.SIGKILL:
                killed += 1
            else:  # it was done before: the machine has become faster
                seconds = min(seconds, spent)
            if not (there / f"{job}.json").exists():  # killed between two renames: the next run puts it right
                assert list(there.glob(".skincad-*/old"))
                assert any(contents(there).items() <= result.items() for result in results)  # never a mixture
                checked_folder(there, job)
            assert contents(there) in results
        assert killed
        assert ran(command(job, True), place)[0] in (0, 1)
    assert contents(there) == results[1]
    assert [p.name for p in place.iterdir()] == ["here"]
    assert not list(there.glob(".*"))  # what killed runs left is gone


OLD = {"a": "old", "same": "same", "gone": "old"}
NEW = {"a": "new", "same": "same", "come": "new"}
MOVES = 8  # four out, with the manifest, and four in
KILL = f"""
import os, signal
from pathlib import Path
from skincad.base.outfolder import checked_folder, replaced

def killed(work, function, count, after=False):
    # run `work` in a child that kills itself at its count-th call of a Path's function; tell whether it did
    child = os.fork()
    if child:
        return os.waitpid(child, 0)[1] == signal.SIGKILL
    real, calls = getattr(Path, function), [0]
    def dying(self, *rest):
        calls[0] += 1
        if calls[0] == count and not after:
            os.kill(os.getpid(), signal.SIGKILL)
        real(self, *rest)
        if calls[0] == count:
            os.kill(os.getpid(), signal.SIGKILL)
    setattr(Path, function, dying)
    work()
    os._exit(0)

def write(files):
    with replaced(Path("here")) as staging:
        for name, text in files.items():
            (staging / name).write_text(text)

def there():
    return {{p.name: p.read_text() for p in Path("here").iterdir() if p.is_file() and p.suffix != ".json"}}

OLD, NEW = {OLD}, {NEW}
"""


def run_program(program: str, folder: Path) -> None:
    done = python(KILL + program, cwd=folder)
    assert done.returncode == 0, done.stderr


PLACES = {
    **{f"before move {n}": ("rename", n, False, OLD) for n in range(1, MOVES + 1)},
    "after the last move": ("rename", MOVES, True, NEW),
    **{f"as old file {n} is removed": ("unlink", n, False, NEW) for n in range(1, 5)},
    **{
        f"as folder {n} is removed": ("rmdir", n + 1, False, NEW) for n in range(1, 4)
    },  # the probe's is first
}


@pytest.mark.parametrize("place", PLACES)
def test_killed_at_each_place_of_the_swap(place: str, tmp_path: Path) -> None:
    function, count, after, expected = PLACES[place]
    run_program(
        "write(OLD)\nPath('here/notes').write_text('mine')\n"
        f"assert killed(lambda: write(NEW), {function!r}, {count}, {after})\n",
        tmp_path,
    )
    with pytest.raises(RuntimeError), replaced(tmp_path / "here"):
        raise RuntimeError  # the next run, which fails, has put all right nevertheless
    assert [p.name for p in tmp_path.iterdir()] == ["here"]
    there = {p.name: p.read_text() for p in (tmp_path / "here").iterdir() if p.name != "make.json"}
    assert there == {**expected, "notes": "mine"}
    assert (tmp_path / "here" / "make.json").is_file()


def test_files_of_two_results_are_never_mixed(tmp_path: Path) -> None:
    """At every moment a manifest says that all is there, and without one the files are of one result."""
    run_program(
        f"for n in range(1, {MOVES} + 1):\n"
        "    write(OLD)\n"
        "    assert killed(lambda: write(NEW), 'rename', n, True)\n"
        "    left, whole = there(), Path('here/make.json').exists()\n"
        "    assert left.items() <= OLD.items() or left.items() <= NEW.items(), (n, left)\n"
        "    assert not whole or left in (OLD, NEW), (n, left)\n",
        tmp_path,
    )


@pytest.mark.slow
def test_killed_again_while_it_is_put_right(tmp_path: Path) -> None:
    """A kill as files leave, between, and before the last comes; each with another at every place of the run
    that puts it right."""
    run_program(
        "pairs = 0\n"
        f"for n in (2, 5, {MOVES}):\n"
        "  for function in ('rename', 'unlink', 'rmdir'):\n"
        "    for m in range(1, 20):\n"
        "        write(OLD)\n"
        "        assert killed(lambda: write(NEW), 'rename', n)\n"
        "        again = killed(lambda: checked_folder(Path('here')), function, m)\n"
        "        checked_folder(Path('here'))\n"
        "        assert there() == OLD, (n, function, m, there())\n"
        "        assert not list(Path('here').glob('.skincad*/old')), (n, function, m)\n"
        "        if not again:\n"
        "            break\n"
        "        pairs += 1\n"
        "assert pairs > 20, pairs\n",
        tmp_path,
    )


@pytest.mark.parametrize(("kill", "file"), [(5, "gone"), (7, "a")])  # all are out; `a` and `come` are in
def test_what_a_person_wrote_after_a_kill_is_not_written_over(tmp_path: Path, kill: int, file: str) -> None:
    """An old file can't go back where a person's lies, nor a changed new one be taken away: it says so."""
    run_program(f"write(OLD)\nassert killed(lambda: write(NEW), 'rename', {kill})", tmp_path)
    (tmp_path / "here" / file).write_text("mine")
    with pytest.raises(
        InputError, match=f"{file} was not written by skincad, or was changed since; move it away"
    ):
        checked_folder(tmp_path / "here")
    assert (tmp_path / "here" / file).read_text() == "mine"
    (tmp_path / "here" / file).unlink()
    checked_folder(tmp_path / "here")
    assert {p.name: p.read_text() for p in (tmp_path / "here").iterdir() if not p.suffix} == OLD


def test_what_another_run_is_writing_is_left_alone(tmp_path: Path) -> None:
    with replaced(tmp_path / "here") as one:
        (one / "a").write_text("one")
        done = subprocess.run(
            [sys.executable, "-c", "from pathlib import Path\nfrom skincad.base.outfolder import replaced\n"
             "with replaced(Path('here')) as two: (two / 'b').write_text('two')"],
            cwd=tmp_path, check=False,
            timeout=300,
        )  # fmt: skip
        assert done.returncode == 0
        assert (one / "a").read_text() == "one"
    assert (tmp_path / "here" / "a").read_text() == "one"


@pytest.mark.slow
@pytest.mark.dear("four whole processes")
def test_two_runs_into_one_folder_at_once(tmp_path: Path) -> None:
    """Both start together: one of the two results is there, whole, and nothing beside it."""
    results = []
    for other in (False, True):
        run_skincad(*command("circuit", other)[3:], cwd=tmp_path)
        results.append(contents(tmp_path / "here"))
    assert results[0] != results[1]
    one, two = (started(command("circuit", other), cwd=tmp_path, **QUIET) for other in (False, True))
    with one as first, two as second:
        assert [run.wait(timeout=300) for run in (first, second)] == [0, 0]
    assert contents(tmp_path / "here") in results
    assert [p.name for p in tmp_path.iterdir()] == ["here"]
    assert not list((tmp_path / "here").glob(".*"))


def test_many_runs_into_one_folder_at_once(tmp_path: Path) -> None:
    """Four processes, two commands, each again and again, the first ones into no folder: nobody is refused,
    and each command's last result is there, whole."""
    run_program(
        "def many(me):\n"
        "    for n in range(8):\n"
        "        command = ('make', 'circuit')[me % 2]\n"
        "        with replaced(Path('here'), command) as staging:\n"
        "            for name in 'xyz':\n"
        "                (staging / f'{command}-{name}').write_text(f'{me} {n}')\n"
        "children = []\n"
        "for me in range(4):\n"
        "    child = os.fork()\n"
        "    if not child:\n"
        "        many(me)\n"
        "        os._exit(0)\n"
        "    children.append(child)\n"
        "assert [os.waitpid(child, 0)[1] for child in children] == [0] * 4\n"
        "for command in ('make', 'circuit'):\n"
        "    texts = {Path(f'here/{command}-{name}').read_text() for name in 'xyz'}\n"
        "    assert len(texts) == 1 and texts.pop().endswith(' 7'), command\n"
        "assert len(list(Path('here').iterdir())) == 8, list(Path('here').iterdir())\n",
        tmp_path,
    )


@pytest.mark.slow
@pytest.mark.dear("one process runs a job many times")
@pytest.mark.parametrize(
    ("job", "kinds"), [("make", ("dxf", "step", "stl", "3mf", "png")), ("simulate", ()), ("circuit", ())]
)
def test_a_full_disk(job: str, kinds: tuple[str, ...], tmp_path: Path) -> None:
    """No file above so many bytes can be written: one line, status 2, the earlier result as it was.

    Of a kind of file the CAD kernel itself says nothing.
    """
    there = tmp_path / "here"
    with forking(job) as ran:
        assert ran(command(job, False), tmp_path)[0] in (0, 1)
        earlier = contents(there)
        commands = [(command(job, True), 2_000)]
        for kind in kinds:
            commands.append(([kind if word == "stl" else word for word in command(job, False)], 8_000))
        for arguments, most in commands:
            status, err, _ = ran(arguments, tmp_path, most=most)
            assert status == 2, err
            assert err.startswith("skincad: -o: ")
            assert err.count("\n") == 1
            assert contents(there) == earlier
            assert [p.name for p in tmp_path.iterdir()] == ["here"]
            assert not list(there.glob(".*"))


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
    message = refused_command(*arguments, cwd=tmp_path)
    assert message.startswith("-o: /proc/self/here cannot be written")


@pytest.mark.slow
@pytest.mark.dear("one process runs a job three times")
@pytest.mark.parametrize("job", ["make", "simulate"])
def test_ctrl_c(job: str, tmp_path: Path) -> None:
    """Status 130 and no half files: make leaves the earlier result, simulate what is done by then."""
    there = tmp_path / "here"
    long = [word.replace("history.steps=9", "history.steps=200000") for word in command(job, True)]
    if job == "make":  # all files take seconds; STL alone is there before a signal is
        long = [word for word in long if word not in ("--format", "stl")]
    with forking(job) as ran:
        _, _, seconds = ran(command(job, False), tmp_path)
        earlier = contents(there)

        def moment() -> None:
            deadline = time.monotonic() + 60
            while job == "make" and not list(there.glob(".skincad-*")) and time.monotonic() < deadline:
                time.sleep(0.01)
            if job == "simulate":
                time.sleep(3 * seconds)  # in the march: meshing is over

        status, err, _ = ran(long, tmp_path, moment, signal.SIGINT)
    assert status == 130, err
    assert "Traceback" not in err
    assert [p.name for p in tmp_path.iterdir()] == ["here"]
    assert not list(there.glob(".*"))
    if job == "make":
        assert contents(there) == earlier
    else:
        assert contents(there).keys() == earlier.keys()
