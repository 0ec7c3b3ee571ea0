"""The log of a study: every finished evaluation, one JSON line each, only ever appended to.

Any number of runs may write to one log at once. A line goes in under the file's lock; if a run is killed in
the midst of it, the next one that appends cuts off what has no line end. Before an evaluation is begun it is
claimed by a lock on one byte of the CLAIMS file beside the log, which ends with the process: nothing is left
of a claim whose run was killed.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from skincad.base.errors import InputError
from skincad.base.estimate import Estimate
from skincad.base.strictjson import strict_json
from skincad.base.version import __version__
from skincad.studies.question import Evaluation

try:
    import fcntl
except ImportError:  # no POSIX: runs on one study at once are not kept apart
    fcntl = None  # type: ignore[assignment]

NAME = "evaluations.jsonl"
CLAIMS = ".skincad-claims"
SLOTS = 1 << 62  # bytes that claims lie at, by the key's first digits


@dataclass
class Log:
    """A study's finished evaluations by key; `other` counts the lines of other versions of skincad, which
    are not used. `torn` says whether a last line was cut off."""

    folder: Path
    evaluations: dict[str, Evaluation] = field(default_factory=dict)
    other: int = 0
    torn: bool = False
    _read: int = 0
    _claims: int = -1

    @property
    def path(self) -> Path:
        """The file."""
        return self.folder / NAME

    def append(self, evaluation: Evaluation) -> None:
        """Write a finished evaluation; raises InputError where the file can't be written."""
        line = (line_of(evaluation) + "\n").encode()
        with self._opened() as handle, _locked(handle):
            end = os.lseek(handle, 0, os.SEEK_END)
            whole = self._whole(handle, end)
            if whole != end:
                os.ftruncate(handle, whole)
                self.torn = True
            try:
                os.lseek(handle, whole, os.SEEK_SET)
                while line:
                    line = line[os.write(handle, line) :]
            except OSError:
                os.ftruncate(handle, whole)
                raise
        self.evaluations[evaluation.key] = evaluation

    def skip(self) -> None:
        """Leave out what the file has now: those evaluations are asked anew, and their lines stay."""
        if self.path.exists():
            self._read = self.path.stat().st_size

    def read(self) -> None:
        """Take in what was appended since, by other runs too; raises InputError for a file that is no log."""
        if not self.path.exists():
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
        if fcntl is None:
            return True
        if self._claims < 0:
            self.folder.mkdir(parents=True, exist_ok=True)
            self._claims = os.open(self.folder / CLAIMS, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
        try:
            fcntl.lockf(self._claims, fcntl.LOCK_EX | fcntl.LOCK_NB, 1, _slot(key))
        except BlockingIOError:
            return False
        except OSError:  # the file system has no locks
            return True
        return True

    def release(self, key: str) -> None:
        """Give a claim back."""
        if fcntl is not None and self._claims >= 0:
            fcntl.lockf(self._claims, fcntl.LOCK_UN, 1, _slot(key))

    def close(self) -> None:
        """Give all claims back."""
        if self._claims >= 0:
            os.close(self._claims)
            self._claims = -1

    @contextmanager
    def _opened(self) -> Iterator[int]:
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            handle = os.open(self.path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
            try:
                yield handle
            finally:
                os.close(handle)
        except OSError as failure:
            rule = f"{str(self.path)[:80]} cannot be written ({failure.strerror or failure})"
            raise InputError("folder", rule, remedy="name another folder, or make room") from None

    @staticmethod
    def _whole(handle: int, end: int) -> int:
        """Up to where the file consists of whole lines."""
        at = end
        while at > 0:
            start = max(0, at - 4096)
            block = _at(handle, start, at - start)
            newline = block.rfind(b"\n")
            if newline >= 0:
                return start + newline + 1
            at = start
        return 0


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


_PLAIN = ("key", "passed", "refused", "tier", "seconds", "when", "version")


def _slot(key: str) -> int:
    return int(key[:16], 16) % SLOTS


def _at(handle: int, start: int, size: int) -> bytes:
    os.lseek(handle, start, os.SEEK_SET)
    data = b""
    while len(data) < size and (part := os.read(handle, size - len(data))):
        data += part
    return data


@contextmanager
def _locked(handle: int) -> Iterator[None]:
    if fcntl is None:
        yield
        return
    try:
        fcntl.flock(handle, fcntl.LOCK_EX)
    except OSError:  # the file system has no locks
        yield
        return
    try:
        yield
    finally:
        fcntl.flock(handle, fcntl.LOCK_UN)
