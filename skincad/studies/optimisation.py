"""What optimising found: the front's designs as the judge sees them, or how near any came."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from skincad.base.errors import InputError
from skincad.base.estimate import Estimate
from skincad.base.result import Result
from skincad.studies.study import Study
from skincad.studies.subject import Subject, Value, changed
from skincad.studies.sweeping import SweepResult


@dataclass(frozen=True)
class Member:
    """A design of the front: its values, and by the judge its objectives, and its constraints' numbers with
    whether each is kept."""

    values: Mapping[str, Value]
    objectives: Mapping[str, Estimate]
    constraints: Mapping[str, tuple[Estimate, bool]]
    tier: str

    @property
    def allowed(self) -> bool:
        """Whether all constraints are kept."""
        return all(kept for _, kept in self.constraints.values())

    def as_json(self) -> dict[str, Any]:
        """Return one entry of `front`."""
        return {
            "values": dict(self.values),
            "objectives": {key: found.as_json() for key, found in self.objectives.items()},
            "constraints": {
                key: {**found.as_json(), "kept": kept} for key, (found, kept) in self.constraints.items()
            },
            "tier": self.tier or None,
        }


@dataclass(frozen=True, repr=False)
class Optimisation(Result):
    """The judged `front` of a study, the best of the first objective first; where it is empty, the `closest`.

    `rows` are all evaluations of the searching model; `start` is the subject as the study has it, judged.
    `untried` is how many combinations were not tried; None if a key has a continuous range.
    """

    shown_by = "skincad.outputs.studies:OPTIMISATION"
    study: Study
    subject: Subject
    front: tuple[Member, ...]
    closest: Member | None
    start: Member | None
    rows: SweepResult
    judged: int
    untried: int | None
    evaluations: int
    reused: int
    seconds: float

    @property
    def name(self) -> str:
        """The study's name."""
        return self.study.name

    @property
    def feasible(self) -> bool:
        """Whether a design keeps all constraints."""
        return bool(self.front)

    @property
    def aims(self) -> list[str]:
        """The keys of objectives and constraints, as results have them."""
        told = next(iter([*self.front, *filter(None, [self.closest, self.start])]), None)
        return [] if told is None else [*told.objectives, *told.constraints]

    def design(self, number: int = 1) -> Subject:
        """Return a member of the front as a design, scene or circuit; InputError where there is none."""
        if not 1 <= number <= len(self.front):
            raise InputError("number", f"must be from 1 to {len(self.front)}", number)
        return changed(self.subject, self.front[number - 1].values)

    @property
    def exit_status(self) -> int:
        """0 where a design keeps all limits, else 1."""
        return 0 if self.feasible else 1

    def as_json(self) -> dict[str, Any]:
        """Return the result under the contract's keys."""
        return {
            "name": self.name,
            "about": self.subject.name,
            "front": [member.as_json() for member in self.front],
            "closest": self.closest and self.closest.as_json(),
            "start": self.start and self.start.as_json(),
            "tier": self.rows.question.tier,
            "judge": self.study.judge,
            "judged": self.judged,
            "untried": self.untried,
            "evaluations": self.evaluations,
            "reused": self.reused,
            "feasible": self.feasible,
            "seconds": {"total": self.seconds},
        }
