"""Evaluating many designs: in this process, in several, or on a cluster; what the log knows is reused.

Whoever computes is a `concurrent.futures.Executor`; a Dask client offers one too.
"""

from __future__ import annotations

import signal
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from multiprocessing import get_context
from typing import Any

from skincad.base.arguments import require_number
from skincad.base.errors import ExhaustedError, InputError
from skincad.base.interrupt import safe_point
from skincad.studies.log import Log
from skincad.studies.question import Evaluation, Query, evaluate, key_of
from skincad.studies.subject import Subject, Value

MOST_WORKERS = 256
AHEAD = 2  # evaluations given out for each worker: none waits for the next
POLL = 0.2  # s; until what another run has claimed is looked at again
PATIENCE = 10.0  # s, for a cluster to answer
Values = Mapping[str, Value]
Outcome = Callable[[Evaluation, int, int], object]  # an evaluation, how many are done, of how many


@dataclass(frozen=True)
class Workers:
    """Who computes: `executor` None in this process itself; `count` at once."""

    executor: Executor | None = None
    count: int = 1


@dataclass
class Run:
    """A question of a subject at many values: `evaluations` by key, `asked` how many of them were computed
    now, `reused` how many the log or an earlier point had."""

    subject: Subject
    question: Query
    log: Log | None = None
    evaluations: dict[str, Evaluation] = field(default_factory=dict)
    evaluated: int = 0
    reused: int = 0

    def at(
        self, points: Sequence[Values], workers: Workers, on_evaluation: Outcome | None = None
    ) -> list[Evaluation]:
        """Return the evaluations of `points`, in their order; `told` of each as it is done.

        What was finished before an interruption stays in the log.
        """
        keys = [key_of(self.subject, values, self.question) for values in points]
        wanted = dict(zip(keys, points, strict=True))
        self._look()
        todo = [key for key in wanted if key not in self.evaluations]
        self.reused += len(points) - len(todo)
        finished = len(wanted) - len(todo)
        for evaluation in self._computed({key: wanted[key] for key in todo}, workers):
            finished += 1
            if on_evaluation is not None:
                on_evaluation(evaluation, finished, len(wanted))
        return [replace(self.evaluations[key], values=dict(wanted[key])) for key in keys]

    def _look(self) -> None:
        """Take in what the log has, of other runs too."""
        if self.log is not None:
            self.log.read()
            self.evaluations |= self.log.evaluations

    def _computed(self, todo: dict[str, Values], workers: Workers) -> Iterator[Evaluation]:
        """Yield evaluations as they are finished; those that another run has claimed come from the log."""
        flying: dict[Future[Evaluation], str] = {}
        waiting = list(todo)
        try:
            while waiting or flying:
                safe_point()
                claimed = self._next(waiting) if len(flying) < AHEAD * workers.count else None
                self._look()  # after the claim: another run may have finished it just before
                for key in [key for key in waiting if key in self.evaluations]:
                    waiting.remove(key)
                    yield self._reused(key, claimed)
                if claimed is not None and claimed in waiting:
                    waiting.remove(claimed)
                    if workers.executor is None:
                        yield self._kept(claimed, evaluate(self.subject, todo[claimed], self.question))
                        continue
                    future = workers.executor.submit(evaluate, self.subject, todo[claimed], self.question)
                    flying[future] = claimed
                    continue
                if flying:
                    yield from self._landed(flying)
                elif waiting:
                    time.sleep(POLL)
        finally:
            for future, key in flying.items():
                future.cancel()
                self._release(key)

    def _next(self, waiting: list[str]) -> str | None:
        """The first evaluation that no other run has claimed, claimed."""
        if self.log is None:
            return next(iter(waiting), None)
        return next((key for key in waiting if self.log.claim(key)), None)

    def _reused(self, key: str, claimed: str | None) -> Evaluation:
        if key == claimed:
            self._release(key)
        self.reused += 1
        return self.evaluations[key]

    def _landed(self, flying: dict[Future[Evaluation], str]) -> Iterator[Evaluation]:
        finished, _ = wait(flying, POLL, FIRST_COMPLETED)
        for future in finished:
            key = flying[future]
            try:
                evaluation = future.result()
            except BrokenProcessPool:
                rule = "a worker was ended, most likely for want of memory; take fewer workers"
                raise ExhaustedError(rule) from None
            del flying[future]
            yield self._kept(key, evaluation)

    def _kept(self, key: str, evaluation: Evaluation) -> Evaluation:
        self.evaluations[key] = evaluation
        self.evaluated += 1
        if self.log is not None:
            self.log.append(evaluation)
            self._release(key)
        return evaluation

    def _release(self, key: str) -> None:
        if self.log is not None:
            self.log.release(key)


@contextmanager
def workers(count: int = 1, dask: str | Any | None = None) -> Iterator[Workers]:
    """Yield who computes: `count` processes on this machine, or a Dask cluster by its address or client.

    Raises InputError for a count out of range, without the package, or for a cluster that does not answer.
    """
    require_number(
        "workers", count, lambda value: 1 <= value <= MOST_WORKERS, f"must be from 1 to {MOST_WORKERS}"
    )
    if dask is not None:
        if count != 1:
            raise InputError("workers", "is told by the cluster", count, "leave it out")
        with _cluster(dask) as cluster:
            yield cluster
    elif count == 1:
        yield Workers()
    else:
        pool = ProcessPoolExecutor(count, get_context("spawn"), initializer=_worker)
        try:
            yield Workers(pool, count)
        except BaseException:
            for process in list(getattr(pool, "_processes", {}).values()):
                process.terminate()  # what is under way counts for nothing
            raise
        finally:
            pool.shutdown(cancel_futures=True)


def _worker() -> None:
    """Leave Ctrl-C to the process that gave out the work."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


@contextmanager
def _cluster(dask: Any) -> Iterator[Workers]:
    """A client's own executor; a client made here from an address is closed."""
    try:
        from distributed import Client
    except ImportError:
        raise InputError(
            "dask", "needs the package distributed", remedy="pip install 'skincad[dask]'"
        ) from None
    if not isinstance(dask, str):
        yield Workers(dask.get_executor(), max(1, len(dask.nthreads())))
        return
    try:
        client = Client(dask, timeout=PATIENCE)
    except (OSError, ValueError, TypeError) as failure:
        raise InputError("dask", f"no cluster answers ({failure})", dask, "check the address") from None
    try:
        yield Workers(client.get_executor(), max(1, len(client.nthreads())))
    finally:
        client.close()
