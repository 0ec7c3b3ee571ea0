"""Progress while a job runs: stages, seconds, and bars on a terminal."""

from __future__ import annotations

import sys
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any, TypeVar

from skincad.base.interrupt import safe_point

LATE = "longer than expected"
WIDTH = 40

T = TypeVar("T")


@contextmanager
def stage_bar(stages: int) -> Iterator[Progress | None]:
    """Show a bar while the block runs: by the seconds left where they are known, else by its stages."""
    with _stages(stages) as (_, progress):
        yield progress


def one_by_one(stages: int, items: Callable[[Progress | None], Iterable[T]]) -> Generator[T, None, None]:
    """Yield what is found under a stage bar, which leaves the terminal meanwhile: there one may print."""
    with _stages(stages) as (bar, progress):
        for entry in items(progress):
            if bar:
                bar.stop()
            yield entry
            if bar:
                bar.start()


@contextmanager
def _stages(stages: int) -> Iterator[tuple[Any, Progress | None]]:
    if not sys.stderr.isatty():
        yield None, None
        return
    from rich.progress import TextColumn, TimeElapsedColumn

    columns = TextColumn("{task.description:14}"), _time_bar(), TimeElapsedColumn(), _seconds_left()
    with _shown(columns, stages + 1) as (bar, update):

        def told(stage: str, left: float | None = None, /) -> None:
            count = bar.tasks[0].completed + 1
            update(stage, left, completed=count, total=max(stages, count) + 1)

        yield bar, told


@contextmanager
def step_bar(steps: int) -> Iterator[Tick | None]:
    """Show a march's steps, and the seconds left, while the block runs."""
    if not sys.stderr.isatty():
        yield None
        return
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn

    columns = (
        TextColumn("{task.description:24}"),
        BarColumn(WIDTH),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        _seconds_left(),
    )
    with _shown(columns, steps) as (_, update):
        yield lambda stage, step, left=None, /: update(stage, left, completed=step)


@contextmanager
def _shown(columns: tuple[Any, ...], total: int) -> Iterator[tuple[Any, Callable[..., None]]]:
    """A bar, and what is told a stage, the seconds left, and how far the bar has come."""
    from rich.console import Console
    from rich.progress import Progress as Bars

    with Bars(*columns, console=Console(stderr=True), transient=True, get_time=perf_counter) as bar:
        task = bar.add_task("starting", total=total, ends=None)

        def update(stage: str, left: float | None, **done: Any) -> None:
            ends: dict[str, Any] = {} if left is None else {"ends": perf_counter() + left}
            bar.update(task, description=stage, **done, **ends)

        yield bar, update


def left_in_words(ends: float | None, now: float) -> str:
    """Return how long until `ends`, both s of one clock: "1:05 left"; "" where that is not known."""
    if ends is None:
        return ""
    return LATE if ends < now else f"{clock(ends - now)} left"


def _seconds_left() -> Any:
    from rich.progress import ProgressColumn, Task
    from rich.text import Text

    class Left(ProgressColumn):
        """The seconds left, which run down between two tellings."""

        def render(self, task: Task) -> Text:
            return Text(left_in_words(task.fields["ends"], task.get_time()))

    return Left()


def _time_bar() -> Any:
    from rich.progress import BarColumn, Task
    from rich.progress_bar import ProgressBar

    class TimeBar(BarColumn):
        """Elapsed against expected seconds; stages done against all where none are known."""

        def render(self, task: Task) -> ProgressBar:
            if task.fields["ends"] is None or task.start_time is None:
                return super().render(task)
            whole = max(task.fields["ends"] - task.start_time, 1e-9)
            return ProgressBar(total=whole, completed=min(task.elapsed or 0.0, whole), width=WIDTH)

    return TimeBar(WIDTH)


# Told (stage, left): the stage that begins and, where a cost model knows, the seconds left to the job's end;
# without them, as told before
Progress = Callable[..., object]
# Told (stage, step, left): a march's stage, the step that is done, and the seconds left to its end
Tick = Callable[..., object]


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
