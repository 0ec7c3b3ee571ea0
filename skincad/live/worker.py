"""Who computes beside the page, and what the jobs are.

Of several questions only the newest counts. A process checks for a newer question wherever its work reports
progress, and drops the older one. One that does not check in time is ended and replaced.
"""

from __future__ import annotations

import os
import signal
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from threading import Condition, RLock, Thread, Timer
from time import perf_counter
from typing import TYPE_CHECKING, Any

from skincad.base.arrays import Array
from skincad.base.errors import InputError, RefusedError, exhausted
from skincad.base.progress import Progress
from skincad.inputs.design import Design
from skincad.scenes.scene import Scene

if TYPE_CHECKING:
    from skincad.scenes.simulation import Simulation


@dataclass(frozen=True, eq=False)
class Signals:
    """Signals of a simulated scene: the differential stress of each monitored ridge, MPa, over `time`, s.

    `rough` signals are of a single coarse mesh, of unknown error; `lines` are what `simulate` prints.
    """

    time: Array
    stress: dict[int, Array]
    rough: bool
    lines: tuple[str, ...]


def check_design(design: Design, tell: Tell) -> None:
    """Tell each model's verdict, then the last one as `skincad check` has it, its advice as it is found."""
    from skincad.mechanics.check import check
    from skincad.studies.advice import advising, seconds_for_advice

    stage = _stages(tell)
    contact_check = check(design, progress=stage, on_verdict=lambda verdict: tell("model", verdict))
    tell("verdict", contact_check)
    for more in advising(design, contact_check, stage, seconds_for_advice(contact_check)):
        tell("verdict", more)


def run_scene(scene: Scene, tell: Tell) -> None:
    """Tell a scene's signals on the coarsest mesh, then those of `skincad simulate`."""
    from skincad.scenes.march import LEVELS
    from skincad.scenes.simulation import at_level, marched, read_out

    def tick(stage: str, step: int, left: float | None = None, /) -> None:
        tell("stage", (f"{stage}, step {step} of {scene.history.step_count}", left))

    tell("signals", _signals(at_level(scene, LEVELS[0], tick), rough=True))
    tell("signals", _signals(read_out(scene, marched(scene, tick=tick)), rough=False))


def make_files(request: tuple[Design, Path], tell: Tell) -> None:
    """Make a design's files as `skincad make` does; tell what it prints."""
    from skincad.fabrication.making import make
    from skincad.outputs.delivery import ready, write
    from skincad.outputs.makes import COMMAND, names

    (design, folder), stage = request, _stages(tell)
    ready(folder, COMMAND, names(design))
    result = make(design, progress=stage)
    written = write(result, folder, progress=stage)
    tell("made", (result.summary, result.details(), str(written)))


def _stages(tell: Tell) -> Progress:
    def stage(what: str, left: float | None = None, /) -> None:
        tell("stage", (what, left))

    return stage


def preload() -> None:
    """Import what the first move of a slider needs."""
    import skincad.fabrication.filling
    import skincad.fabrication.findings
    import skincad.fabrication.strips
    import skincad.mechanics.models.winkler
    import skincad.outputs.checks  # noqa: F401


def _signals(simulation: Simulation, *, rough: bool) -> Signals:
    stress = {ridge: signal.value for ridge, signal in simulation.signals.items()}
    return Signals(simulation.march.time, stress, rough, tuple(str(simulation).split("\n")))


PATIENCE = 3.0  # s, until a process that does not check for a newer question is ended
LESS_URGENT = 10  # of 19: who moves a slider comes first
SAID_EVERY = 0.1  # s, at least, between two reports of a stage
Tell = Callable[[str, Any], None]  # what kind of news, and what it is
Job = Callable[[Any, Tell], None]  # answers a question by its calls of Tell; a function of a module


class OutdatedError(BaseException):
    """A newer question came: this answer is no longer needed. No Exception, so that no model catches it."""


class LatestRunner:
    """A thread that works off the newest thing it was given, and forgets what that replaced."""

    def __init__(self, work: Callable[[Any, Callable[[], bool]], None]) -> None:
        """`work` is given a thing, and what says whether a newer one has come meanwhile."""
        self._work, self._given, self._number, self._done = work, None, 0, 0
        self._changed = Condition()
        Thread(target=self._run, daemon=True).start()

    def give(self, thing: Any) -> None:
        """Work this off next."""
        with self._changed:
            self._given, self._number = thing, self._number + 1
            self._changed.notify_all()

    def idle(self, timeout: float) -> bool:
        """Wait until all is worked off, at most `timeout` s; return whether it is."""
        with self._changed:
            return self._changed.wait_for(lambda: self._done == self._number, timeout)

    def _is_older(self, number: int) -> bool:
        return self._number != number

    def _run(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._done != self._number)
                thing, number = self._given, self._number
            self._work(thing, partial(self._is_older, number))
            with self._changed:
                self._done = number
                self._changed.notify_all()


class Worker:
    """A process that answers questions by one job; `on_news` gets each piece of news of the newest question:
    the question, the kind and what it is. The last one is of the kind "done", "refused" or "failed"."""

    def __init__(self, job: Job, on_news: Callable[[Any, str, Any], None], *, warm: bool = True) -> None:
        self._job, self._on_news, self._lock = job, on_news, RLock()
        self._number, self._begun, self._ended = 0, 0, 0
        self._question: Any = None
        self._line: Any = None
        self._process: Any = None
        if warm:
            self._start()

    @property
    def busy(self) -> bool:
        """Whether the newest question is not answered yet."""
        return self._ended != self._number

    def ask(self, question: Any) -> None:
        """Take this question up instead of any other."""
        with self._lock:
            under_way = self.busy
            self._number += 1
            self._question, number = question, self._number
            if self._process is None:
                self._start()
            with suppress(OSError):  # it ended just now: who listens to it says so
                self._line.send((number, question))
        if under_way:
            timer = Timer(PATIENCE, self._insist, (number,))
            timer.daemon = True
            timer.start()

    def close(self) -> None:
        """End the process, whatever it is at."""
        with self._lock:
            self._number, self._ended = self._number + 1, self._number + 1
            if self._process is not None:
                self._process.terminate()

    def _start(self) -> None:
        context = get_context("spawn")
        self._line, theirs = context.Pipe()
        self._process = context.Process(target=_answer, args=(theirs, self._job), daemon=True)
        self._process.start()
        theirs.close()
        Thread(target=self._listen, args=(self._line,), daemon=True).start()

    def _insist(self, number: int) -> None:
        """End a process that is still at an older question, and ask a new one."""
        with self._lock:
            if number != self._number or self._begun >= number:
                return
            if self._process is not None:
                self._process.kill()
            self._start()
            self._line.send((number, self._question))

    def _listen(self, line: Any) -> None:
        while True:
            try:
                number, kind, what = line.recv()
            except (EOFError, OSError):
                with self._lock:
                    if line is not self._line:
                        return
                    self._process = None  # the next question starts another
                    if not self.busy:
                        return
                    self._ended, question = self._number, self._question
                self._on_news(question, "failed", "the process was ended, most likely for want of memory")
                return
            with self._lock:
                self._begun = max(self._begun, number)
                if number != self._number:
                    continue
                question = self._question
                if kind in ("done", "refused", "failed"):
                    self._ended = number
            if kind != "begun":
                self._on_news(question, kind, what)


def _answer(line: Any, job: Job) -> None:
    """Answer questions until nobody asks any more."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for who asks
    if hasattr(os, "nice"):
        os.nice(LESS_URGENT)
    while True:
        try:
            number, question = line.recv()
            while line.poll():
                number, question = line.recv()
            line.send((number, "begun", None))
            line.send((number, *_run_job(question, job, number, line)))
        except OutdatedError:
            continue
        except (EOFError, OSError):
            return


def _run_job(question: Any, job: Job, number: int, line: Any) -> tuple[str, Any]:
    """Do a job and return its last news."""
    last_stage = 0.0

    def tell(kind: str, what: Any) -> None:
        nonlocal last_stage
        if line.poll():
            raise OutdatedError
        if kind != "stage" or perf_counter() - last_stage > SAID_EVERY:
            last_stage = perf_counter()
            line.send((number, kind, what))

    try:
        job(question, tell)
    except (InputError, RefusedError) as refusal:
        return "refused", str(refusal)
    except Exception as failure:  # a page stays, whatever a model makes of a design
        lacking = exhausted(failure)
        return "failed", f"out of {lacking}" if lacking else f"{type(failure).__name__}: {failure}"
    return "done", None
