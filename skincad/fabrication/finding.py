"""A broken rule as data: what was measured, where, against which limit, and what would cure it."""

from __future__ import annotations

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
        return (
            f"{self.severity}: {self.rule}: {self.where}: {self.measured:.4g}{unit}, "
            f"limit {self.limit:.4g}; {self.remedy}"
        )
