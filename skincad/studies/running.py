"""Evaluations of many designs, here, by workers or by a cluster, each logged at once.

The log of a study: every finished evaluation, one JSON line each, only ever appended to. Any number of runs
may write to one log at once. A line goes in under a lock; if a run is killed in the midst of it, the next one
that appends cuts off what has no line end. Before an evaluation is begun it is claimed. Claims and the lock
are locks on single bytes of the CLAIMS file beside the log, which end with the process: nothing is left of a
claim whose run was killed.

Whoever computes is a `concurrent.futures.Executor`; a Dask client offers one too.
"""

from __future__ import annotations

import json
import os
import signal
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from skincad.base.errors import ExhaustedError, InputError, require_number
from skincad.base.estimate import Estimate
from skincad.base.interrupt import safe_point
from skincad.base.reading import strict_json
from skincad.base.version import __version__
from skincad.studies.query import Evaluation, Query, evaluate, key_of
from skincad.studies.subject import Subject, Value

try:
    import fcntl
except ImportError:  # no POSIX: runs on one study at once are not kept apart
    fcntl = None  # type: ignore[assignment]

NAME = "evaluations.jsonl"
CLAIMS = ".skincad-claims"
SLOTS = 1 << 62  # bytes that claims lie at, by the key's first digits; the next one is the lock of the log


@dataclass
class Log:
    """A study's finished evaluations by key, without a folder in memory alone.

    `other` counts the lines of other versions of skincad, which are not used. `torn` says whether a last line
    was cut off.
    """

    folder: Path | None = None
    evaluations: dict[str, Evaluation] = field(default_factory=dict)
    other: int = 0
    torn: bool = False
    _read: int = 0
    _claims: int = -1

    @property
    def path(self) -> Path:
        """The file."""
        return (self.folder or Path()) / NAME

    def append(self, evaluation: Evaluation) -> None:
        """Write a finished evaluation; raises InputError where the file can't be written."""
        if self.folder is not None:
            with self._opened() as handle:
                self._lock("LOCK_EX", SLOTS)
                try:
                    self._write(handle, (line_of(evaluation) + "\n").encode())
                finally:
                    self._lock("LOCK_UN", SLOTS)
        self.evaluations[evaluation.key] = evaluation

    def _write(self, handle: int, line: bytes) -> None:
        """Write a line behind the last whole one."""
        whole = end = os.lseek(handle, 0, os.SEEK_END)
        if end and _at(handle, end - 1, 1) != b"\n":
            whole = _at(handle, 0, end).rfind(b"\n") + 1
            os.ftruncate(handle, whole)
            self.torn = True
        try:
            while line:
                line = line[os.write(handle, line) :]
        except OSError:
            os.ftruncate(handle, whole)
            raise

    def skip(self) -> None:
        """Leave out what the file has now: those evaluations are asked anew, and their lines stay."""
        if self.path.exists():
            self._read = self.path.read_bytes().rfind(b"\n") + 1  # a torn line makes room for the next

    def read(self) -> None:
        """Take in what was appended since, by other runs too; raises InputError for a file that is no log."""
        if self.folder is None or not self.path.exists():
            return
        with self._opened() as handle:
            end = os.fstat(handle).st_size
            text = _at(handle, self._read, end - self._read)
        whole = text[: text.rfind(b"\n") + 1]  # a last line may still be under way
        self._read += len(whole)
        for number, line in enumerate(whole.splitlines(), 1):
            try:
                evaluation = evaluation_of(json.loads(line))
            except (ValueError, KeyError, TypeError, AttributeError):
                rule = f"{str(self.path)[:80]} is no log of a study: line {number} can't be read"
                raise InputError("folder", rule, remedy="name another folder") from None
            if evaluation.version == __version__:
                self.evaluations[evaluation.key] = evaluation
            else:
                self.other += 1

    def claim(self, key: str) -> bool:
        """Return whether this run may evaluate this key now; it keeps the claim until `release`."""
        return self._lock("LOCK_EX LOCK_NB", _slot(key))

    def release(self, key: str) -> None:
        """Give a claim back."""
        self._lock("LOCK_UN", _slot(key))

    def close(self) -> None:
        """Give all claims back."""
        if self._claims >= 0:
            os.close(self._claims)
            self._claims = -1

    def _lock(self, names: str, slot: int) -> bool:
        """Whether a byte was locked or unlocked; also where the file system or the machine has no locks."""
        if fcntl is None or self.folder is None:
            return True
        if self._claims < 0:
            self._claims = self._open(self.folder / CLAIMS)
        try:
            fcntl.lockf(self._claims, sum(getattr(fcntl, name) for name in names.split()), 1, slot)
        except BlockingIOError:
            return False
        except OSError:
            return True
        return True

    @contextmanager
    def _opened(self) -> Iterator[int]:
        handle = self._open(self.path, os.O_APPEND)
        try:
            yield handle
        except OSError as failure:
            raise _unwritten(self.path, failure) from None
        finally:
            os.close(handle)

    @staticmethod
    def _open(path: Path, how: int = 0) -> int:
        """Open a file, made with its folder where there is none."""
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            return os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | how, 0o644)
        except OSError as failure:
            raise _unwritten(path, failure) from None


def _unwritten(path: Path, failure: OSError) -> InputError:
    rule = f"{str(path)[:80]} cannot be written ({failure.strerror or failure})"
    return InputError("folder", rule, remedy="name another folder, or make room")


def log_in(folder: Path | str | None, *, fresh: bool) -> Log:
    """Return the log of a study's folder, to be gone on with, or with `fresh` from its end."""
    log = Log(None if folder is None else Path(folder))
    if fresh:
        log.skip()
    return log


def line_of(evaluation: Evaluation) -> str:
    """Return an evaluation as a line of JSON."""
    results = {
        key: [estimate.value, estimate.error, estimate.unit] for key, estimate in evaluation.results.items()
    }
    return strict_json(
        {**{k: getattr(evaluation, k) for k in _PLAIN}, "values": dict(evaluation.values), "results": results}
    )


def evaluation_of(data: dict[str, Any]) -> Evaluation:
    """Return the evaluation of a line's JSON; raises KeyError, TypeError or ValueError for another's."""
    results = {key: Estimate(*entry) for key, entry in data["results"].items()}
    return Evaluation(values=dict(data["values"]), results=results, **{k: data[k] for k in _PLAIN})


_PLAIN = ("key", "passed", "refused", "model", "seconds", "when", "version")


def _slot(key: str) -> int:
    return int(key[:16], 16) % SLOTS


def _at(handle: int, start: int, size: int) -> bytes:
    os.lseek(handle, start, os.SEEK_SET)
    data = b""
    while len(data) < size and (part := os.read(handle, size - len(data))):
        data += part
    return data


MOST_WORKERS = 256
AHEAD = 2  # evaluations given out for each worker: none waits for the next
POLL = 0.2  # s; until what another run has claimed is looked at again
PATIENCE = 10.0  # s, for a cluster to answer
Values = Mapping[str, Value]
OnEvaluation = Callable[[Evaluation, int, int], object]  # an evaluation, how many are done, of how many


@dataclass(frozen=True)
class Workers:
    """Who computes: `executor` None in this process itself; `count` at once."""

    executor: Executor | None = None
    count: int = 1


@dataclass
class Run:
    """A question of a subject at many values: `evaluated` how many of them were computed now, `reused` how
    many the log or an earlier point had."""

    subject: Subject
    question: Query
    log: Log = field(default_factory=Log)
    evaluated: int = 0
    reused: int = 0

    def at(
        self, points: Sequence[Values], workers: Workers, on_evaluation: OnEvaluation | None = None
    ) -> list[Evaluation]:
        """Return the evaluations of `points`, in their order; `on_evaluation` hears of each as it is done.

        What was finished before an interruption stays in the log.
        """
        keys = [key_of(self.subject, values, self.question) for values in points]
        wanted = dict(zip(keys, points, strict=True))
        self.log.read()
        todo = {key: values for key, values in wanted.items() if key not in self.log.evaluations}
        self.reused += len(points) - len(todo)
        finished = len(wanted) - len(todo)
        for evaluation in self._computed(todo, workers):
            finished += 1
            if on_evaluation is not None:
                on_evaluation(evaluation, finished, len(wanted))
        return [replace(self.log.evaluations[key], values=dict(wanted[key])) for key in keys]

    def _computed(self, todo: dict[str, Values], workers: Workers) -> Iterator[Evaluation]:
        """Yield evaluations as they are finished; those that another run has claimed come from the log."""
        flying: dict[Future[Evaluation], str] = {}
        try:
            while todo or flying:
                safe_point()
                claimed = None
                if len(flying) < AHEAD * workers.count:
                    claimed = next((key for key in todo if self.log.claim(key)), None)
                self.log.read()  # after the claim: another run may have finished it just before
                for key in [key for key in todo if key in self.log.evaluations]:
                    del todo[key]
                    if key == claimed:
                        self.log.release(key)
                    self.reused += 1
                    yield self.log.evaluations[key]
                if claimed is not None and claimed in todo:
                    values = todo.pop(claimed)
                    if workers.executor is None:
                        yield self._kept(claimed, evaluate(self.subject, values, self.question))
                    else:
                        future = workers.executor.submit(evaluate, self.subject, values, self.question)
                        flying[future] = claimed
                elif flying:
                    for future in wait(flying, POLL, FIRST_COMPLETED).done:
                        evaluation = future.result()
                        yield self._kept(flying.pop(future), evaluation)
                elif todo:
                    time.sleep(POLL)
        finally:
            for future, key in flying.items():
                future.cancel()
                self.log.release(key)

    def _kept(self, key: str, evaluation: Evaluation) -> Evaluation:
        self.evaluated += 1
        self.log.append(evaluation)
        self.log.release(key)
        return evaluation


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
        except BaseException as failure:
            for process in list((getattr(pool, "_processes", None) or {}).values()):
                process.terminate()  # what is under way counts for nothing
            if isinstance(failure, BrokenProcessPool):
                rule = "a worker was ended, most likely for want of memory; take fewer workers"
                raise ExhaustedError(rule) from None
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
    try:
        client = Client(dask, timeout=PATIENCE) if isinstance(dask, str) else dask
    except (OSError, ValueError, TypeError) as failure:
        raise InputError("dask", f"no cluster answers ({failure})", dask, "check the address") from None
    try:
        yield Workers(client.get_executor(), max(1, len(client.nthreads())))
    finally:
        if client is not dask:
            client.close()
