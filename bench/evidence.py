"""Evidence by turns: run the stalest, and write what it showed into docs/evidence/ledger.toml.

    python -m bench.evidence               the turn that was run the most commits ago
    python -m bench.evidence --turn 3 4    these, or `all`
    python -m bench.evidence --balance     deal the subjects to ten turns of equal core-seconds
    python -m bench.evidence --check       fail if a line was never run, is old or holds a failure
    python -m bench.evidence --of-commit   pytest's options for the turn of this commit and for what changed

Evidence is each test with the mark `evidence`; tests of one subject run together. A turn holds subjects. A
subject that no turn holds is new: each run takes it, until a turn that is run here gets it.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tomllib
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

import pytest
import tomlkit

from tests.tiers import LEDGER, SECONDS, TURNS, subject_of

HERE = Path(__file__).parents[1]
MOST_COMMITS = 200
CASES = "tests/hard_cases.toml"
QUIET = ("-W", "ignore::pytest.PytestAssertRewriteWarning")  # tests.tiers is imported here too


@dataclass(frozen=True)
class Turn:
    """A line of the ledger: what was run, at which commit, and how many of its cases failed.

    `subjects` says how many cases each has. A turn that was never run has no `cases`, and is a fault.
    """

    number: int
    subjects: dict[str, int] = field(default_factory=dict)
    commit: str = ""
    cases: int = 0
    failures: int = 0
    core_seconds: int = 0

    @property
    def age(self) -> int | None:
        """Commits since it was run or dealt; None if this history does not have that commit."""
        if not self.commit:
            return None
        words = ["git", "rev-list", "--count", f"{self.commit}..HEAD"]
        count = subprocess.run(words, cwd=HERE, capture_output=True, text=True, check=False, timeout=60)
        return int(count.stdout) if count.returncode == 0 else None


class Reports:
    """What pytest collects and reports of evidence, by subject: a plugin."""

    def __init__(self) -> None:
        self.collected, self.cases = Counter[str](), Counter[str]()
        self.failures, self.seconds = set[str](), Counter[str]()

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        self.collected.update(subject_of(item) for item in items)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        subject = report.nodeid.rpartition("@")[2]
        if report.failed:
            self.failures.add(report.nodeid)
        if report.when == "teardown":
            self.cases[subject] += 1
            self.seconds[subject] += dict(report.user_properties)["spent"][1]


def ledger() -> list[Turn]:
    """Return the ledger's lines, in order."""
    rows = tomllib.loads(LEDGER.read_text("utf-8"))["turn"] if LEDGER.exists() else []
    known = {row["number"]: Turn(**row) for row in rows}
    return [known.get(number, Turn(number)) for number in range(1, TURNS + 1)]


def write(turns: Iterable[Turn]) -> None:
    rows = [{**asdict(turn), "subjects": dict(sorted(turn.subjects.items()))} for turn in turns]
    title = "# Evidence by turns: `python -m bench.evidence` runs one and writes its line.\n\n"
    LEDGER.write_text(title + tomlkit.dumps({"turn": rows}), encoding="utf-8")


def balanced(subjects: Mapping[str, int]) -> list[Turn]:
    """Return ten turns of these subjects with about equal core-seconds.

    A turn is as old as the oldest from which it has a subject, and has the failures of all of them.
    """
    spent = tomllib.loads(SECONDS.read_text("utf-8"))["evidence"]
    source = {subject: turn for turn in ledger() for subject in turn.subjects}
    shares: list[list[str]] = [[] for _ in range(TURNS)]
    sums = [0.0] * TURNS
    expected = {name: spent.get(name, float(cases)) for name, cases in subjects.items()}
    for subject in sorted(subjects, key=lambda name: (-expected[name], name)):
        least = sums.index(min(sums))
        shares[least].append(subject)
        sums[least] += expected[subject]
    turns = []
    for number, share in enumerate(shares, 1):
        before = {source[name].number: source[name] for name in share if name in source}.values()
        oldest = max(before, key=lambda turn: turn.age or 0, default=None)
        was_run = all(name in source and source[name].cases for name in share)
        turns.append(
            Turn(
                number,
                {name: subjects[name] for name in share},
                oldest.commit if oldest and was_run else head(),
                sum(subjects[name] for name in share) if was_run else 0,
                sum(turn.failures for turn in before) if was_run else 0,
                round(sums[number - 1]),
            )
        )
    return turns


def git(*words: str) -> str:
    result = subprocess.run(["git", *words], cwd=HERE, capture_output=True, text=True, check=True, timeout=60)
    return result.stdout.strip()


def head() -> str:
    return git("rev-parse", "--short=12", "HEAD")


def collected() -> Counter[str]:
    """Return all subjects, and how many cases each has."""
    reports = Reports()
    words = ["--collect-only", "-qq", "-o", "addopts=", "-m", "evidence", *QUIET]
    if pytest.main(words, plugins=[reports]) != 0:
        raise SystemExit("bench.evidence: the tests can't be collected")
    return reports.collected


def run(turns: Sequence[Turn], numbers: Sequence[int]) -> list[Turn]:
    """Return all turns, these as they were run now; the first gets the subjects that no turn holds."""
    reports, commit = Reports(), head()
    words = ["-q", "-m", "evidence", "--turn", ",".join(map(str, numbers)), *QUIET]
    if pytest.main(words, plugins=[reports]) not in (0, 1):
        raise SystemExit("bench.evidence: the run did not end, and nothing is written")
    holders = {subject: turn.number for turn in turns for subject in turn.subjects}

    def line(number: int) -> Turn:
        subjects = [name for name in reports.cases if holders.get(name, numbers[0]) == number]
        failures = sum(name.rpartition("@")[2] in subjects for name in reports.failures)
        cases = {name: reports.cases[name] for name in subjects}
        seconds = sum(reports.seconds[name] for name in subjects)
        return Turn(number, cases, commit, sum(cases.values()), failures, round(seconds))

    return [line(turn.number) if turn.number in numbers else turn for turn in turns]


def faults(turns: Iterable[Turn]) -> Iterator[str]:
    """Say of each line that was never run, is too old or holds a failure which command runs it."""
    for turn in turns:
        age, command = turn.age, f"run `python -m bench.evidence --turn {turn.number}`"
        if not turn.cases:
            yield f"evidence, turn {turn.number}: it was never run; {command}"
        elif age is None or age > MOST_COMMITS:
            old = "its commit is not in this history" if age is None else f"{age} commits old"
            yield f"evidence, turn {turn.number}: {old}, {MOST_COMMITS} are allowed; {command}"
        if turn.failures:
            yield f"evidence, turn {turn.number}: {turn.failures} failures; {command}"


def changed(turns: Iterable[Turn]) -> Iterator[str]:
    """Give the subjects whose own file or row changed since they were run: page, template, hard case."""
    for turn in turns:
        if not turn.cases or turn.age is None:
            continue
        files = set(git("diff", "--name-only", turn.commit, "HEAD").splitlines())
        rows = changed_rows(turn.commit) if CASES in files else set()
        marks = files | {Path(file).stem for file in files if file.startswith("templates/")} | rows
        yield from (subject for subject in turn.subjects if subject in marks)


def changed_rows(commit: str) -> set[str]:
    """Return the names of hard cases that are not as they were."""
    before = {row["name"]: row for row in tomllib.loads(git("show", f"{commit}:{CASES}"))["case"]}
    after = {row["name"]: row for row in tomllib.loads((HERE / CASES).read_text("utf-8"))["case"]}
    return {name for name, row in after.items() if row != before.get(name)}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a turn, or say what is to be run; the status is 0 if nothing failed."""
    parser = argparse.ArgumentParser(prog="python -m bench.evidence")
    parser.add_argument("--turn", nargs="+", choices=[*map(str, range(1, TURNS + 1)), "all"])
    parser.add_argument("--balance", action="store_true")
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--of-commit", action="store_true")
    asked, turns = parser.parse_args(arguments), ledger()
    if asked.balance:
        write(balanced(collected()))
        return 0
    if asked.check:
        lines = [*faults(turns)]
        print("\n".join(lines), end="\n" if lines else "")
        return int(bool(lines))
    if asked.of_commit:
        count = git("rev-list", "--count", "HEAD")
        seen = [turn.number for turn in turns if turn.cases] or [0]  # none of what was never run
        options = [f"--subject={name}" for name in changed(turns)]
        print(f"--turn={seen[int(count) % len(seen)]}", *options, sep="\n")
        return 0
    oldest = max(turns, key=lambda turn: (not turn.cases, turn.age is None, turn.age or 0))
    numbers = [int(word) for word in asked.turn or [str(oldest.number)] if word != "all"]
    turns = run(turns, numbers or range(1, TURNS + 1))
    write(turns)
    for turn in turns:
        print(f"turn {turn.number}: {turn.cases} cases, {turn.failures} failures at {turn.commit}")
    return int(any(turn.failures for turn in turns))


if __name__ == "__main__":
    sys.exit(main())
