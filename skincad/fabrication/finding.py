"""A broken rule as data: what was measured, where, against which limit, and what would cure it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from typing import Any, Literal


@dataclass(frozen=True)
class Finding:
    """A broken rule. `error` fails the job, `warning` fails it under --strict, `note` never does."""

    rule: str
    where: str
    measured: float
    limit: float
    unit: str
    severity: Literal["note", "warning", "error"]
    remedy: str

    def as_json(self) -> dict[str, Any]:
        """Return the finding as plain data."""
        return asdict(self)

    def __str__(self) -> str:
        unit = f" {self.unit}" if self.unit else ""
        numbers = f": {self.measured:.4g}{unit}, limit {self.limit:.4g}"
        if not unit and {self.measured, self.limit} == {0.0, 1.0}:  # yes or no, as `where` says
            numbers = ""
        return f"{self.severity}: {self.rule}: {self.where}{numbers}; {self.remedy}"


def counted(findings: Iterable[Finding]) -> str:
    """Return how many errors and warnings there are, as "no errors, 1 warning"."""
    count = Counter(finding.severity for finding in findings)
    words = []
    for severity in ("error", "warning"):
        number = count[severity]
        words.append(f"{number or 'no'} {severity}{'s' * (number != 1)}")
    return ", ".join(words)
