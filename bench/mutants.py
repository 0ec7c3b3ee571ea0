"""What the tests see: random small changes of the code, each with tests that run the changed line.

`python -m bench.mutants --seed 1 --count 300` changes one operator or constant at a time in a copy of this
tree (see `bench.mutate`), runs fast tests that reach it (see `bench.covered`, which runs them all once) and
writes a JSON line of each to out/mutants-SEED/records.jsonl; started again it goes on. A change that they do
not see gets slow tests and evidence of its room, as far as out/core-seconds says what these take. A run that
takes many times as long as without the change counts as seen. At the end: the share seen, and what was not.

`--changes RECORDS` makes the changes of another commit's records, where their lines still are.

mutmut 3 is no substitute: it changes nothing in decorated classes and functions, nor outside functions (its
issues 480 and 558), which is 22 % of the 33,208 places here, and draws no sample by a seed (issue 306).
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
from itertools import count
from pathlib import Path
from queue import SimpleQueue
from threading import Lock
from time import perf_counter
from typing import Any

from bench.covered import Covered, recorded
from bench.mutate import Site, mutated, sites

HERE = Path(__file__).parents[1]
SLOWER, START = 6.0, 10.0  # times the unchanged tests and s: a change that makes a loop endless is seen
REST_BUDGET = 60.0  # s of slow tests and evidence for a change that fast tests do not see
MISSING = 4  # pytest's status where it knows no such test
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
    rows = [
        (path.relative_to(tree).as_posix(), site, text.splitlines()[site.start[0] - 1].strip())
        for path, text in texts.items()
        if path.relative_to(tree).match(pattern)
        for site in sites(text)
    ]
    dice = random.Random(seed)
    return [
        (Mutant(file, *site.start, site.before, dice.choice(site.after), code), site)
        for file, site, code in dice.sample(rows, min(number, len(rows)))
    ]


def copy(tree: Path, target: Path) -> None:
    """Copy what git tracks of a tree, and what it doesn't ignore."""
    words = ["git", "-C", str(tree), "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    names = subprocess.run(words, capture_output=True, text=True, check=True, timeout=3600).stdout
    for name in filter(None, names.split("\0")):
        if (tree / name).is_file():
            (target / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(tree / name, target / name)


def verdict(tree: Path, tests: Sequence[str], limit: float | None) -> str | None:
    """Return the first of these tests that fails against a tree, None if all pass."""
    pytest = ["-m", "pytest", "-o", "addopts=", "-x", "-q", "-p", "no:cacheprovider", "-rfE"]
    limited = ["sh", "-c", f'ulimit -v {MEMORY}; exec "$@"', "sh"]
    environment = {"PYTHONPATH": str(tree), "TMPDIR": str(tree.parent), "OPENBLAS_NUM_THREADS": "1"}
    environment["PYTHONDONTWRITEBYTECODE"] = "1"  # else a change of the same length and second is missed
    process = subprocess.Popen(
        [*limited, sys.executable, *pytest, *tests],
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
        process.communicate(timeout=60)
        return "too long"
    if process.returncode == 0 and " passed" in said:  # not all skipped or deselected
        return None
    failed = re.search(r"^(?:FAILED|ERROR) (.+?)(?: - |$)", said, re.MULTILINE)
    if process.returncode == MISSING and "not found: " in said and not failed:
        raise ValueError(f"not all of {' '.join(tests)} are there: {said}")
    return failed[1] if failed else f"status {process.returncode}"


def later_tests(file: str, budget: float) -> dict[str, float]:
    """Return slow tests and evidence of a file's room, and what each took, s: those of its own test file
    first, then the cheapest, `budget` s of them at the most."""
    room = Path("tests") / Path(file).relative_to("skincad").parent
    known: dict[str, float] = {}
    for tier in ("slow", "evidence"):
        if (path := HERE / "out" / "core-seconds" / f"{tier}.json").exists():
            spent_by = json.loads(path.read_text())
            known |= {name.rpartition("@")[0] or name: spent for name, spent in spent_by.items()}
    mirror = f"{room}/test_{Path(file).name}::"
    names = sorted(
        (name for name in known if name.startswith(f"{room}/")),
        key=lambda name: (not name.startswith(mirror), known[name]),
    )
    rows, spent = dict[str, float](), 0.0
    for name in names:
        spent += known[name]
        if spent <= budget:
            rows[name] = known[name]
    return rows


def drawn_again(tree: Path, records: Path) -> Iterator[tuple[Mutant, Site]]:
    """Give the changes of another commit's records; where a line is there several times, at the nearest."""
    for row in map(json.loads, records.read_text("utf-8").splitlines()):
        path = tree / row["file"]
        text = path.read_text("utf-8") if path.exists() else ""
        lines = text.splitlines()
        places = [
            site
            for site in sites(text)
            if site.before == row["before"]
            and row["after"] in site.after
            and lines[site.start[0] - 1].strip() == row["code"]
        ]
        if not places:
            print(f"gone: {line(row)}", file=sys.stderr, flush=True)
            continue
        site = min(places, key=lambda at: (abs(at.start[0] - row["line"]), abs(at.start[1] - row["column"])))
        yield Mutant(row["file"], *site.start, site.before, row["after"], row["code"]), site


class Bench:
    """Copies of the tree, one a worker, what their tests run, and the records of changes."""

    def __init__(self, out: Path, folder: Path, workers: int) -> None:
        self.out, self.lock, self.trees = out / "records.jsonl", Lock(), SimpleQueue[Path]()
        self.records: list[dict[str, Any]] = []
        if self.out.exists():
            self.records = [json.loads(line) for line in self.out.read_text("utf-8").splitlines()]
        for each in range(workers):
            copy(HERE, folder / str(each) / "tree")
            self.trees.put(folder / str(each) / "tree")
        self.covered: Covered = recorded(folder / "0" / "tree", out, HERE)

    def known(self, mutant: Mutant) -> dict[str, Any] | None:
        answer = asdict(mutant)
        return next((record for record in self.records if answer.items() <= record.items()), None)

    def judge(self, mutant: Mutant, site: Site, budget: float) -> None:
        """Run tests that reach a change, and record what they say."""
        if self.known(mutant):
            return
        with self.lock:  # the coverage's file has one reader
            tests = self.covered.tests(mutant.file, mutant.line, budget)
        tree, started, by = self.trees.get(), perf_counter(), None
        try:
            with changed(tree / mutant.file, site, mutant.after):
                if tests:
                    by = verdict(tree, tests, SLOWER * (START + self.covered.spent(tests)))
                if by is None and (rest := later_tests(mutant.file, REST_BUDGET)):
                    by = verdict(tree, list(rest), SLOWER * (START + sum(rest.values())))
                    tests = [*tests, *rest]
        finally:
            self.trees.put(tree)
        spent = {"tests": len(tests), "seconds": round(perf_counter() - started, 1)}
        table = {**asdict(mutant), "seen": by is not None, "by": by, **spent}
        with self.lock, self.out.open("a", encoding="utf-8") as file:
            self.records.append(table)
            file.write(json.dumps(table) + "\n")
        print(f"{'seen' if by else 'NOT SEEN'}  {line(table)}", file=sys.stderr, flush=True)


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
    unseen = [each for each in told if not each["seen"]]
    seen = len(told) - len(unseen)
    head = f"{seen} of {len(told)} seen ({seen / max(len(told), 1):.0%}), not seen:"
    return "\n".join([head, *(line(each) + ("" if each["tests"] else "  (no test)") for each in unseen)])


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="python -m bench.mutants")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--file", default="*.py", metavar="GLOB", help="only such files, as skincad/scenes/*")
    parser.add_argument(
        "--budget", type=float, default=15.0, metavar="S", help="the tests' own time a change is worth"
    )
    parser.add_argument("--changes", type=Path, metavar="RECORDS", help="those of another commit")
    parser.add_argument("--workers", type=int, choices=(1, 2), default=1)
    parser.add_argument("-o", dest="out", type=Path, help="folder of records; default out/mutants-SEED")
    options = parser.parse_args(arguments)
    out = options.out or HERE / "out" / f"mutants-{options.seed}"
    out.mkdir(parents=True, exist_ok=True)
    if options.changes:
        mutants = list(drawn_again(HERE, options.changes))
    else:
        mutants = drawn(HERE, options.file, options.seed, options.count)
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(options.workers) as pool:
        bench = Bench(out, Path(folder), options.workers)
        list(pool.map(lambda each: bench.judge(*each, options.budget), mutants))
    print(summary([found for mutant, _ in mutants if (found := bench.known(mutant))]))


if __name__ == "__main__":
    main()
