"""What the tests see: random small changes of the code, each with the tests of the file that it is in.

`python -m bench.mutants --seed 1 --count 300` changes one operator or constant at a time in a copy of this
tree (see `bench.mutate`), runs the tests of the changed file (see `bench.mirrored`) and writes a JSON line of
each to out/mutants-SEED.jsonl; started again it goes on. A run that takes several times as long as it does
without the change counts as seen. At the end: the share seen, and what was not.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from itertools import count, islice
from pathlib import Path
from queue import SimpleQueue
from threading import Lock
from time import perf_counter
from typing import Any

from bench.mirrored import covering
from bench.mutate import Site, mutated, sites

HERE = Path(__file__).parents[1]
SLOWER = 5.0  # times the unchanged tests' run: a change that makes a loop endless is seen
MEMORY = 16 * 2**20  # KiB of address space: a change may ask for all there is
TICKS = count(1)  # times of change, s, that no file has


@dataclass(frozen=True)
class Mutant:
    """One change: a file from the tree's top, a place in it, what stood there, what stands now, the line."""

    file: str
    line: int
    column: int
    before: str
    after: str
    code: str


def drawn(tree: Path, pattern: str, seed: int, number: int) -> list[tuple[Mutant, Site]]:
    """Return the changes, drawn evenly from all places of the files that match."""
    texts = {path: path.read_text("utf-8") for path in sorted((tree / "skincad").rglob("*.py"))}
    found = [
        (path.relative_to(tree).as_posix(), site, text.splitlines()[site.start[0] - 1].strip())
        for path, text in texts.items()
        if path.relative_to(tree).match(pattern)
        for site in sites(text)
    ]
    dice = random.Random(seed)
    return [
        (Mutant(file, *site.start, site.before, dice.choice(site.after), code), site)
        for file, site, code in dice.sample(found, min(number, len(found)))
    ]


def copy(tree: Path, target: Path) -> None:
    """Copy what git tracks of a tree, and what it doesn't ignore."""
    words = ["git", "-C", str(tree), "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    names = subprocess.run(words, capture_output=True, text=True, check=True).stdout
    for name in filter(None, names.split("\0")):
        if (tree / name).is_file():
            (target / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(tree / name, target / name)


def verdict(tree: Path, test: str, limit: float | None) -> tuple[str | None, float]:
    """Return the first test of a file that fails against a tree (None if all pass), and s taken."""
    pytest = [
        "-m",
        "pytest",
        "-o",
        "addopts=",
        "-m",
        "not slow",
        "-x",
        "-q",
        "-p",
        "no:cacheprovider",
        "-rfE",
    ]
    limited = ["sh", "-c", f'ulimit -v {MEMORY}; exec "$@"', "sh"]
    environment = {"PYTHONPATH": str(tree), "TMPDIR": str(tree.parent), "OPENBLAS_NUM_THREADS": "1"}
    started = perf_counter()
    process = subprocess.Popen(
        [*limited, sys.executable, *pytest, test],
        cwd=tree,
        env={**os.environ, **environment},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )
    try:
        said, _ = process.communicate(timeout=limit)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        said = f"FAILED {test}:too-long"
    spent = perf_counter() - started
    if process.returncode == 0 and " passed" in said:  # not all skipped or deselected
        return None, spent
    failed = re.search(r"^(?:FAILED|ERROR) (\S+)", said, re.MULTILINE)
    return failed[1] if failed else f"{test}:{process.returncode}", spent


class Bench:
    """Copies of the tree, one a worker, and the records: changes, and what a test file takes without one."""

    def __init__(self, out: Path, folder: Path, workers: int, shortest: float) -> None:
        self.out, self.shortest = out, shortest
        self.lock, self.trees = Lock(), SimpleQueue[Path]()
        self.records: list[dict[str, Any]] = []
        if out.exists():
            self.records = [json.loads(line) for line in out.read_text("utf-8").splitlines()]
        for each in range(workers):
            copy(HERE, folder / str(each) / "tree")
            self.trees.put(folder / str(each) / "tree")

    def record(self, told: dict[str, Any]) -> None:
        with self.lock, self.out.open("a", encoding="utf-8") as file:
            self.records.append(told)
            file.write(json.dumps(told) + "\n")

    def known(self, told: dict[str, Any]) -> dict[str, Any] | None:
        """Return the record that holds all these keys."""
        return next((each for each in self.records if told.items() <= each.items()), None)

    def normal(self, tree: Path, test: str) -> float | None:
        """Return what a test file takes without a change, s; None if it fails even so, or runs nothing."""
        if not (record := self.known({"test": test})):
            failed, spent = verdict(tree, test, None)
            self.record(record := {"test": test, "failed": failed, "normal_s": round(spent, 1)})
        return None if record["failed"] else float(record["normal_s"])

    def judge(self, mutant: Mutant, site: Site, most: int) -> None:
        """Run a change's tests, the cheapest first, and record what they say."""
        if self.known(asdict(mutant)):
            return
        tree, started, by = self.trees.get(), perf_counter(), None
        try:
            times = ((self.normal(tree, test), test) for test in covering(HERE, mutant.file))
            usable = sorted(islice(((spent, test) for spent, test in times if spent is not None), most))
            with changed(tree / mutant.file, site, mutant.after):
                for spent, test in usable:
                    by = by or verdict(tree, test, max(self.shortest, SLOWER * spent))[0]
        finally:
            self.trees.put(tree)
        tests = [test for _, test in usable]
        told = {
            "seen": by is not None,
            "by": by,
            "tests": tests,
            "seconds": round(perf_counter() - started, 1),
        }
        self.record({**asdict(mutant), **told})
        print(f"{'seen' if by else 'NOT SEEN'}  {line(asdict(mutant))}", file=sys.stderr, flush=True)


@contextmanager
def changed(path: Path, site: Site, after: str) -> Iterator[None]:
    """Change a file for a while; its time of change tells Python that what it compiled before is old."""
    text, stat = path.read_text("utf-8"), path.stat()
    try:
        path.write_text(mutated(text, site, after), encoding="utf-8")
        os.utime(path, (next(TICKS), next(TICKS)))
        yield
    finally:
        path.write_text(text, encoding="utf-8")
        os.utime(path, ns=(stat.st_atime_ns, stat.st_mtime_ns))


def line(told: Mapping[str, Any]) -> str:
    """Return a change in words."""
    return "{file}:{line}:{column}  {before!r} -> {after!r}  in  {code}".format(**told)


def summary(told: Sequence[Mapping[str, Any]]) -> str:
    """Return the share seen, and the changes that were not."""
    unseen = [each for each in told if not each["seen"]]
    seen = len(told) - len(unseen)
    head = f"{seen} of {len(told)} seen ({seen / max(len(told), 1):.0%}), not seen:"
    return "\n".join([head, *(line(each) + ("" if each["tests"] else "  (no test)") for each in unseen)])


def main(arguments: Sequence[str] | None = None) -> None:
    """Draw, judge, tell."""
    parser = argparse.ArgumentParser(prog="python -m bench.mutants")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--file", default="*.py", metavar="GLOB", help="only such files, as skincad/scenes/*")
    parser.add_argument(
        "--timeout", type=float, default=60.0, metavar="S", help="the shortest limit of a test file"
    )
    parser.add_argument(
        "--files", type=int, default=3, metavar="N", help="at most so many test files without a mirror"
    )
    parser.add_argument("--workers", type=int, choices=(1, 2), default=1)
    parser.add_argument("-o", dest="out", type=Path, help="records; default out/mutants-SEED.jsonl")
    told = parser.parse_args(arguments)
    out = told.out or HERE / "out" / f"mutants-{told.seed}.jsonl"
    out.parent.mkdir(parents=True, exist_ok=True)
    mutants = drawn(HERE, told.file, told.seed, told.count)
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(told.workers) as pool:
        bench = Bench(out, Path(folder), told.workers, told.timeout)
        list(pool.map(lambda each: bench.judge(*each, told.files), mutants))
    print(summary([found for mutant, _ in mutants if (found := bench.known(asdict(mutant)))]))


if __name__ == "__main__":
    main()
