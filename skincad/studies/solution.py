"""What solving found: values that give what is wanted, or how near any came."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from skincad.base.errors import RefusedError
from skincad.base.estimate import Estimate
from skincad.base.result import Result
from skincad.studies.knobs import Knob
from skincad.studies.question import Evaluation, Question
from skincad.studies.subject import Subject, Value, changed


@dataclass(frozen=True)
class Solved:
    """Values of the varied keys, the wanted results there, and which values the results' errors leave open.

    `interval` is `(low, high)` within the range of the one number that is varied, empty for several;
    `nearest` names the catalogue's choice that comes nearest to a number.
    """

    values: Mapping[str, Value]
    reached: Mapping[str, Estimate]
    interval: Mapping[str, tuple[float, float]]
    nearest: Mapping[str, str]
    passed: bool | None

    def as_json(self) -> dict[str, Any]:
        """Return one entry of `solutions`."""
        return {
            "values": dict(self.values),
            "reached": {key: found.as_json() for key, found in self.reached.items()},
            "interval": {key: list(ends) for key, ends in self.interval.items()},
            "nearest": dict(self.nearest),
            "passed": self.passed,
        }


@dataclass(frozen=True, repr=False)
class Solution(Result):
    """All `solutions` that were found, the least change first; where there is none, the `closest`.

    `complete` says that there are no others: the model that judges was asked at both ends of the range and at
    enough places between. `target` is by the result's keys; `evaluations` are all of them in their order,
    `notes` what else is to be known of the search, `seconds` its wall time.
    """

    shown_by = "skincad.outputs.studies:SOLUTION"
    subject: Subject
    question: Question
    target: Mapping[str, float]
    knobs: tuple[Knob, ...]
    solutions: tuple[Solved, ...]
    closest: Solved | None
    evaluations: tuple[Evaluation, ...]
    notes: tuple[str, ...]
    seconds: float
    complete: bool = False

    @property
    def name(self) -> str:
        """The subject's name."""
        return self.subject.name

    @property
    def feasible(self) -> bool:
        """Whether there is a solution."""
        return bool(self.solutions)

    @property
    def solved(self) -> Subject:
        """The design, scene or circuit of the first solution; RefusedError where there is none."""
        if not self.solutions:
            raise RefusedError(f"{self.name}: no value gives what is wanted, so there is nothing to write")
        return changed(self.subject, self.solutions[0].values)

    @property
    def exit_status(self) -> int:
        """0 where a solution was found, else 1."""
        return 0 if self.feasible else 1

    def as_json(self) -> dict[str, Any]:
        """Return the result under the contract's keys."""
        return {
            "name": self.name,
            "target": dict(self.target),
            "vary": {knob.key: list(knob.choices) or [knob.low, knob.high] for knob in self.knobs},
            "solutions": [each.as_json() for each in self.solutions],
            "closest": self.closest and self.closest.as_json(),
            "tier": self.question.tier,
            "evaluations": len(self.evaluations),
            "refused": sum(bool(each.refused) for each in self.evaluations),
            "feasible": self.feasible,
            "searched": "complete" if self.complete else "partial",
            "notes": list(self.notes),
            "seconds": {"total": self.seconds},
        }
