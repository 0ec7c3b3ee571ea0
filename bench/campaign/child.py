"""One case in a process of its own, memory and processor time bounded; what became of it as plain data."""

from __future__ import annotations

import contextlib
import json
import os
import resource
import signal
import sys
import traceback
from dataclasses import dataclass, field
from pathlib import Path

from bench.campaign.cases import Case, figures
from bench.campaign.invariants import Fault, faults
from skincad.base import InputError, RefusedError

MEMORY = 4 * 2**30  # bytes above what the libraries have mapped already
SECONDS = 150  # of processor time; the slowest sound cases take a fifth


@dataclass(frozen=True)
class Outcome:
    """`refused` is the key of an InputError, `unsolved` the words of a RefusedError, "" where there was none;
    `seconds` of processor time, `peak` memory in bytes."""

    refused: str = ""
    unsolved: str = ""
    faults: list[Fault] = field(default_factory=list)
    seconds: float = 0.0
    peak: int = 0


def judged(case: Case, *, dear: bool = False) -> Outcome:
    """Return what became of a case here; an exception that is not skincad's own is a fault."""
    try:
        numbers = figures(case)
        stuck = str(numbers["stopped"]) if numbers.get("failed") else ""
        return Outcome(unsolved=stuck, faults=list(faults(case, numbers, dear=dear)))
    except InputError as refusal:
        return Outcome(refused=refusal.key.removeprefix("skin.") or "?")
    except RefusedError as failure:
        return Outcome(unsolved=f"{type(failure).__name__}: {failure}")
    except Exception as failure:  # whatever it is, it is what this looks for
        where = [f for f in traceback.extract_tb(failure.__traceback__) if "skincad" in f.filename]
        last = where[-1] if where else traceback.extract_tb(failure.__traceback__)[-1]
        kind = f"{type(failure).__name__} at {Path(last.filename).name}:{last.name}"
        return Outcome(faults=[(kind, f"{failure} (line {last.lineno})")])


def alone(case: Case, *, dear: bool = False) -> Outcome:
    """Return what became of a case in a child process; a signal that ended it is a fault."""
    reader, writer = os.pipe()
    sys.stdout.flush()
    child = os.fork()
    if child == 0:
        os.close(reader)
        _child(case, dear, writer)
    os.close(writer)
    with os.fdopen(reader, "rb") as pipe:
        answer = pipe.read()
    _, status, usage = os.wait4(child, 0)
    seconds, peak = usage.ru_utime + usage.ru_stime, usage.ru_maxrss * 1024
    if os.WIFSIGNALED(status) or not answer:
        number = os.WTERMSIG(status) if os.WIFSIGNALED(status) else 0
        name = signal.Signals(number).name if number else f"status {os.waitstatus_to_exitcode(status)}"
        words = f"{case.kind}: the process ended by {name}"
        return Outcome(faults=[(words, words)], seconds=seconds, peak=peak)
    data = json.loads(answer)
    return Outcome(data["refused"], data["unsolved"], [(a, b) for a, b in data["faults"]], seconds, peak)


def _child(case: Case, dear: bool, writer: int) -> None:
    """Judge and leave, whatever happens: this process must not go on as its parent."""
    status = 3
    try:
        mapped = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (mapped + MEMORY, mapped + MEMORY))
        resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS + 5))
        silent = os.open(os.devnull, os.O_WRONLY)
        os.dup2(silent, 1)  # libraries written in C have words for the terminal
        os.dup2(silent, 2)
        answer = judged(case, dear=dear)
        table = {"refused": answer.refused, "unsolved": answer.unsolved, "faults": answer.faults}
        with os.fdopen(writer, "wb") as pipe:
            pipe.write(json.dumps(table).encode())
        status = 0
    finally:
        with contextlib.suppress(BaseException):
            os._exit(status)
