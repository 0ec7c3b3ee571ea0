"""Wall time by stage, and what is told of it while a job runs."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from time import perf_counter
from typing import Protocol

from skincad.base.interrupt import safe_point


class Progress(Protocol):
    """Told what is being done and, where a cost model knows, how many seconds are left to the job's end."""

    def __call__(self, stage: str, left: float | None = None, /) -> object:
        """Take note of a stage that begins; `left` None: as told before."""


class Tick(Protocol):
    """Told a march's stage, its step, and the seconds left to its end."""

    def __call__(self, stage: str, step: int, left: float | None = None, /) -> object:
        """Take note of a step that is done; `left` None: as told before."""


def clock(seconds: float) -> str:
    """Return a time as minutes and seconds: 65 as "1:05"."""
    minutes, rest = divmod(round(max(seconds, 0.0)), 60)
    return f"{minutes}:{rest:02d}"


def about(seconds: float) -> str:
    """Return an expected time with two digits: 168 as "170 s"."""
    return f"{float(f'{seconds:.2g}'):g} s"


@dataclass
class Stopwatch:
    """Collects seconds by stage; `progress` is told each stage's name as it begins."""

    progress: Progress | None = None
    started: float = field(default_factory=perf_counter)
    stages: dict[str, float] = field(default_factory=dict)

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Count the block's seconds under this name."""
        safe_point()
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
