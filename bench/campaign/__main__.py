"""`python -m bench.campaign --minutes N --seed S [--mode M] [-o DIR]`: runs cases, shrinks, saves failures.

Exit status 1 where anything failed. The figures at the end count runs, refusals by key, and failures by kind.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import hypothesis
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis.internal.conjecture import engine

from bench.campaign.cases import Case
from bench.campaign.child import Outcome, alone
from bench.campaign.strategies import MODES

ROUND = 40  # cases drawn before the next seed; a round's failures are shrunk at its end
SHRINKING = 120  # s at most for one failure
KEPT = 5  # cases written of one kind of failure, beside the shrunk one
DEAR = 5  # every so many checks the next model is asked too


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
