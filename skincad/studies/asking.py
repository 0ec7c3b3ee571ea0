"""Asking one question of many designs, each once, and reading the wanted numbers off the evaluations."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from skincad.base.arrays import Array
from skincad.base.stopwatch import Progress
from skincad.studies.measures import resolved
from skincad.studies.question import Evaluation, Query, evaluate, key_of
from skincad.studies.subject import Subject, Value

GUIDE = "winkler"  # the closed form: a thousandth of the time, and the right slope


@dataclass
class Evaluator:
    """A question of a subject, its evaluations so far by key, and the numbers `wished` of them.

    `target` is what is wished by the result's own keys, empty until the first answer tells them.
    """

    subject: Subject
    question: Query
    wished: Mapping[str, float]
    progress: Progress | None = None
    target: dict[str, float] = field(default_factory=dict)
    evaluations: dict[str, Evaluation] = field(default_factory=dict)
    unlike: bool = False  # whether the closed form's result lacks a number that is wished

    def ask(self, values: Mapping[str, Value]) -> Evaluation:
        """Return the answer for some values. Raises InputError for a wish that no result's key is."""
        key = key_of(self.subject, values, self.question)
        if key not in self.evaluations:
            if self.progress:
                self.progress(
                    ", ".join(f"{name.rpartition('.')[2]} {short(v)}" for name, v in values.items())
                )
            self.evaluations[key] = evaluation = evaluate(self.subject, values, self.question)
            self.name(evaluation)
        return self.evaluations[key]

    def name(self, evaluation: Evaluation) -> None:
        """Take the wishes' keys from a first answer."""
        if evaluation.results and not self.target:
            self.target = {resolved(key, evaluation.results): value for key, value in self.wished.items()}

    def told(self, evaluation: Evaluation) -> list[float] | None:
        """Return the wished results' values; None where one has none or the design is refused."""
        if evaluation.refused or not evaluation.results:
            return None
        values = [evaluation.results[key].value for key in self.target]
        return [value for value in values if value is not None] if None not in values else None

    def guide(self, values: Mapping[str, Value]) -> list[float] | None:
        """Return what the closed form says, without counting it as an evaluation; None where it does not."""
        evaluation = evaluate(self.subject, values, replace(self.question, tier=GUIDE))
        self.name(evaluation)
        return self.told(evaluation)

    @property
    def guided(self) -> bool:
        """Whether there is a closed form that is cheaper than what is asked."""
        return self.question.kind == "check" and self.question.tier != GUIDE and not self.unlike

    def off(self, evaluation: Evaluation) -> float:
        """Return how far an answer is from the wishes, in parts of them; infinite where it has no values."""
        values = self.told(evaluation)
        if values is None:
            return math.inf
        wanted = self.target.values()
        return max(abs(x - y) / (abs(y) or 1.0) for x, y in zip(values, wanted, strict=True))


def short(value: Value) -> str:
    """Return a value as it is shown."""
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def scaled(value: Array, wanted: Array) -> Array:
    """Return results as logarithms where they are wanted above 0: powers of sizes are lines then."""
    above = wanted > 0
    logs = np.log(np.maximum(value, 1e-9 * np.abs(wanted)), where=above, out=np.zeros(len(wanted)))
    return np.where(above, logs, value)
