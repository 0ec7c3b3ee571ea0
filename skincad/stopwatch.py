"""Wall time by stage."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from time import perf_counter

Progress = Callable[[str], None]


@dataclass
class Stopwatch:
    """Collects seconds by stage; `progress` is told each stage's name as it begins."""

    progress: Progress | None = None
    started: float = field(default_factory=perf_counter)
    stages: dict[str, float] = field(default_factory=dict)

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Count the block's seconds under this name."""
        if self.progress:
            self.progress(name)
        begin = perf_counter()
        try:
            yield
        finally:
            self.stages[name] = self.stages.get(name, 0.0) + perf_counter() - begin

    def seconds(self) -> dict[str, float]:
        """Return the seconds so far: `total` since the start, and each stage."""
        return {"total": perf_counter() - self.started, **self.stages}
