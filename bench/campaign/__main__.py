"""`python -m bench.campaign --minutes N --seed S [--mode M] [-o DIR]`: runs cases, shrinks, saves failures.

A case has a process of its own, memory and processor time bounded. Exit status 1 where anything failed. The
figures at the end count runs, refusals by key, and failures by kind.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import re
import resource
import signal
import sys
import time
import traceback
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import hypothesis
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis.internal.conjecture import engine

from bench.campaign.cases import Case, figures
from bench.campaign.invariants import Fault, faults
from bench.campaign.strategies import MODES
from skincad.base import InputError, RefusedError

ROUND = 40  # cases drawn before the next seed; a round's failures are shrunk at its end
SHRINKING = 120  # s at most for one failure
KEPT = 5  # cases written of one kind of failure, beside the shrunk one
DEAR = 5  # every so many checks the next model is asked too
MEMORY = 4 * 2**30  # bytes above what the libraries have mapped already
SECONDS = 150  # of processor time; the slowest sound cases take a fifth


@dataclass(frozen=True)
class Outcome:
    """`refused` is the key of an InputError, `unsolved` the words of a RefusedError, "" where there was none;
    `seconds` of processor time, `peak` memory in bytes."""

    refused: str = ""
    unsolved: str = ""
    faults: list[Fault] = field(default_factory=list)
    seconds: float = 0.0
    peak: int = 0


def judged(case: Case, *, dear: bool = False) -> Outcome:
    """Return what became of a case here; an exception that is not skincad's own is a fault."""
    try:
        numbers = figures(case)
        stuck = str(numbers["stopped"]) if numbers.get("failed") else ""
        return Outcome(unsolved=stuck, faults=list(faults(case, numbers, dear=dear)))
    except InputError as refusal:
        return Outcome(refused=refusal.key.removeprefix("skin.") or "?")
    except RefusedError as failure:
        return Outcome(unsolved=f"{type(failure).__name__}: {failure}")
    except Exception as failure:  # whatever it is, it is what this looks for
        where = [f for f in traceback.extract_tb(failure.__traceback__) if "skincad" in f.filename]
        last = where[-1] if where else traceback.extract_tb(failure.__traceback__)[-1]
        kind = f"{type(failure).__name__} at {Path(last.filename).name}:{last.name}"
        return Outcome(faults=[(kind, f"{failure} (line {last.lineno})")])


def alone(case: Case, *, dear: bool = False) -> Outcome:
    """Return what became of a case in a child process; a signal that ended it is a fault."""
    reader, writer = os.pipe()
    sys.stdout.flush()
    child = os.fork()
    if child == 0:
        os.close(reader)
        _child(case, dear, writer)
    os.close(writer)
    with os.fdopen(reader, "rb") as pipe:
        answer = pipe.read()
    _, status, usage = os.wait4(child, 0)
    seconds, peak = usage.ru_utime + usage.ru_stime, usage.ru_maxrss * 1024
    if os.WIFSIGNALED(status) or not answer:
        number = os.WTERMSIG(status) if os.WIFSIGNALED(status) else 0
        name = signal.Signals(number).name if number else f"status {os.waitstatus_to_exitcode(status)}"
        words = f"{case.kind}: the process ended by {name}"
        return Outcome(faults=[(words, words)], seconds=seconds, peak=peak)
    data = json.loads(answer)
    return Outcome(data["refused"], data["unsolved"], [(a, b) for a, b in data["faults"]], seconds, peak)


def _child(case: Case, dear: bool, writer: int) -> None:
    """Judge and leave, whatever happens: this process must not go on as its parent."""
    status = 3
    try:
        mapped = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (mapped + MEMORY, mapped + MEMORY))
        resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS + 5))
        silent = os.open(os.devnull, os.O_WRONLY)
        os.dup2(silent, 1)  # libraries written in C have words for the terminal
        os.dup2(silent, 2)
        answer = judged(case, dear=dear)
        table = {"refused": answer.refused, "unsolved": answer.unsolved, "faults": answer.faults}
        with os.fdopen(writer, "wb") as pipe:
            pipe.write(json.dumps(table).encode())
        status = 0
    finally:
        with contextlib.suppress(BaseException):
            os._exit(status)


class Failed(AssertionError):  # noqa: N818
    """The case of this round's kind of failure, for Hypothesis to shrink."""


@dataclass
class Campaign:
    """What has been run so far, and where the rest goes."""

    out: Path
    until: float
    runs: Counter[str] = field(default_factory=Counter)
    refused: Counter[str] = field(default_factory=Counter)
    unsolved: Counter[str] = field(default_factory=Counter)
    failed: Counter[str] = field(default_factory=Counter)
    peak: int = 0
    slowest: float = 0.0
    shrunk: dict[str, Case] = field(default_factory=dict)
    hunted: str = ""

    def round(self, mode: str, number: int, seed: int) -> None:
        """Run one round of cases; shrink the first new kind of failure that it meets."""
        choices = MODES[mode]
        strategy = choices[number % len(choices)]
        self.hunted = ""

        @hypothesis.seed(seed)
        @settings(
            max_examples=ROUND,
            database=None,
            deadline=None,
            report_multiple_bugs=False,
            phases=[Phase.generate, Phase.shrink],
            suppress_health_check=list(HealthCheck),
        )
        @given(strategy)
        def one(case: Case) -> None:
            self.one(case)

        try:
            one()
        except (Failed, hypothesis.errors.Flaky) as failure:
            print(f"  {self.hunted}: {failure}"[:200], flush=True)
        if self.hunted:
            self.save(self.hunted)

    def one(self, case: Case) -> None:
        """Run one case; while a kind of failure is hunted, only this kind counts."""
        if time.monotonic() > self.until and not self.hunted:
            return
        answer = alone(case, dear=not self.hunted and self.runs["check"] % DEAR == 0)
        if not self.hunted:
            self.count(case, answer)
        for kind, words in answer.faults:
            if self.hunted in ("", kind) and (self.hunted or kind not in self.shrunk):
                self.hunted = kind
                self.shrunk[kind] = case
                raise Failed(words)

    def count(self, case: Case, found: Outcome) -> None:
        self.runs[case.kind] += 1
        self.peak, self.slowest = max(self.peak, found.peak), max(self.slowest, found.seconds)
        if found.refused:
            self.refused[f"{case.kind}: {found.refused}"] += 1
        if found.unsolved:
            self.unsolved[f"{case.kind}: {re.sub('[0-9][0-9.e+-]*', '#', found.unsolved)[:90]}"] += 1
            if self.unsolved.total() <= 10 * KEPT:
                self.write(f"unsolved-{case.kind}-{self.unsolved.total()}", case, found.unsolved)
        for kind in {kind for kind, _ in found.faults}:
            self.failed[kind] += 1
            if self.failed[kind] <= KEPT:
                self.write(f"failed-{kind}-{self.failed[kind]}", case, str(found.faults))

    def save(self, kind: str) -> None:
        self.write(f"shrunk-{kind}", self.shrunk[kind], kind)

    def write(self, name: str, case: Case, words: str) -> None:
        self.out.mkdir(parents=True, exist_ok=True)
        safe = "".join(c if c.isalnum() or c == "-" else "-" for c in name)[:80]
        text = "".join(f"# {line}\n" for line in words.splitlines()) + case.toml()
        (self.out / f"{safe}.toml").write_text(text, "utf-8")

    def figures(self) -> dict[str, object]:
        return {
            "runs": dict(self.runs),
            "refused": dict(self.refused.most_common()),
            "unsolved": dict(self.unsolved.most_common()),
            "failed": dict(self.failed.most_common()),
            "peak_MB": round(self.peak / 1e6),
            "slowest_s": round(self.slowest, 1),
        }


def preloaded() -> None:
    """Import what the cases need, once, before any of them forks."""
    import bench.campaign.soundness  # noqa: F401
    import skincad.circuit.bode
    import skincad.mechanics.film.sliding
    import skincad.mechanics.models.linear
    import skincad.mechanics.verdict
    import skincad.scenes.simulation
    import skincad.solids.occ  # noqa: F401


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m bench.campaign", description=__doc__)
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--mode", choices=[*MODES, "all"], default="all")
    parser.add_argument("-o", dest="out", type=Path, default=Path("out/campaign"))
    options = parser.parse_args()
    preloaded()
    engine.MAX_SHRINKING_SECONDS = SHRINKING
    campaign = Campaign(options.out, time.monotonic() + 60 * options.minutes)
    modes = list(MODES) if options.mode == "all" else [options.mode]
    number = 0
    while time.monotonic() < campaign.until:
        mode = modes[number % len(modes)]
        campaign.round(mode, number // len(modes), 1000 * options.seed + number)
        number += 1
        print(mode, sum(campaign.runs.values()), dict(campaign.failed), file=sys.stderr, flush=True)
    text = json.dumps(campaign.figures(), indent=1)
    print(text)
    campaign.out.mkdir(parents=True, exist_ok=True)
    (campaign.out / f"figures-{options.mode}-{options.seed}.json").write_text(text + "\n", "utf-8")
    return 1 if campaign.failed else 0


if __name__ == "__main__":
    sys.exit(main())
