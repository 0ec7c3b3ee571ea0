"""A design or scene while somebody moves its sliders: the session, what answers it, and who computes that.

An observer hears of each change; nothing here knows of a browser.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from threading import RLock
from time import perf_counter, sleep
from traceback import print_exc
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from skincad.base.errors import InputError, RefusedError
from skincad.inputs.design import Design
from skincad.live.session import Editable, Session, apply_moves, redo_step, start_session, undo_step
from skincad.live.shapes import DesignView, view
from skincad.live.worker import LatestRunner, Signals, Worker, check_design, make_files, run_scene
from skincad.scenes.scene import Scene
from skincad.studies.subject import Setting

if TYPE_CHECKING:
    from skincad.fabrication.rules import Finding
    from skincad.mechanics.verdict import ContactCheck

QUIET = 0.15  # s without a move, after which slower answers than a picture are computed
T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class Reply(Generic[T]):
    """An answer `of` a design or scene, which may have changed since."""

    of: Editable
    what: T


class Desk:
    """One session with its answers; `source` is the template or file that it began from.

    `observer` is called with "session", "quiet" or the name of the answer that changed: from any thread, one
    call at a time. Answers are the newest of each kind, None where there was none yet. `better` are the
    verdicts of better models than the closed form as they came, `verdict` is the last one, as `skincad check`
    has it.
    """

    view: Reply[DesignView] | None = None
    closed_form: Reply[ContactCheck | str] | None = None
    findings: Reply[tuple[Finding, ...]] | None = None
    better: Reply[tuple[ContactCheck, ...]] | None = None
    verdict: Reply[ContactCheck] | None = None
    signals: Reply[Signals] | None = None
    trouble: Reply[str] | None = None
    stage = ""  # what is computed now
    making = ""  # what `make` is at, or said at its end

    def __init__(self, subject: Editable, source: str, observer: Callable[[str], None]) -> None:
        self.source, self._observer = source, observer
        self.session = start_session(subject)
        self.lock = RLock()
        self._quick = LatestRunner(self._work)
        self._slow = Worker(run_scene if isinstance(subject, Scene) else check_design, self._on_news)

    @cached_property
    def _maker(self) -> Worker:
        return Worker(make_files, self._on_make_news)

    def begin(self) -> None:
        """Compute the first answers."""
        self._quick.give(self.session)

    def close(self) -> None:
        """End the processes beside it, and call no observer any more."""
        with self.lock:
            self._observer = lambda _: None
        self._slow.close()
        if "_maker" in self.__dict__:
            self._maker.close()

    def wait_until_drawn(self, timeout: float) -> bool:
        """Wait until the newest subject is drawn, at most `timeout` s; return whether it is."""
        ends = perf_counter() + timeout
        while not self.is_current(self.view) and perf_counter() < ends:
            sleep(0.01)
        return self.is_current(self.view)

    def wait_until_settled(self, timeout: float) -> bool:
        """Wait until all answers are of the newest subject, at most `timeout` s; return whether they are."""
        ends = perf_counter() + timeout
        while perf_counter() < ends:
            if self._quick.idle(0.05) and not self._slow.busy:
                return True
            sleep(0.01)
        return False

    def move(self, values: Mapping[str, Setting]) -> None:
        """Give keys other values."""
        self._become(lambda session: apply_moves(session, values, perf_counter()))

    def undo(self) -> None:
        """Go a step back."""
        self._become(undo_step)

    def redo(self) -> None:
        """Take back the last undoing."""
        self._become(redo_step)

    def save(self, name: str) -> str:
        """Write a TOML file into the working directory, its comments kept; return what to say of it."""
        from skincad.outputs.tomls import write_copy

        file = name.removesuffix(".toml") + ".toml"
        try:
            if Path(file).name != file or file.startswith("."):
                raise InputError("file", "must be a name without folders", name)
            write_copy(Path(file), self.source, self.session.subject, {})
        except (InputError, RefusedError) as failure:
            return str(failure)
        return f"Saved as {Path(file).absolute()}"

    def make(self) -> None:
        """Write the files that `skincad make` writes, to out/<name>."""
        if "_maker" in self.__dict__ and self._maker.busy:
            return
        design = self.session.design
        self._answer("making", making=f"Making out/{design.name} ...")
        self._maker.ask((design, Path("out") / design.name))

    def is_current(self, answer: Reply[Any] | None) -> bool:
        """Return whether an answer is of the subject as it is now."""
        return answer is not None and answer.of == self.session.subject

    def _become(self, step: Callable[[Session], Session]) -> None:
        with self.lock:
            before, self.session = self.session, step(self.session)
            self._observer("session")
            if self.session.subject != before.subject:
                self._quick.give(self.session)

    def _answer(self, kind: str, **changes: Any) -> None:
        with self.lock:
            vars(self).update(changes)
            self._observer(kind)

    def _work(self, session: Session, newer: Callable[[], bool]) -> None:
        """What is quick, as long as nobody moves on: the picture, the closed form's verdict, findings."""
        subject, is_design = session.subject, isinstance(session.subject, Design)
        try:
            picture = view(session.design, molded=is_design)
            self._answer("view", view=Reply(subject, picture))
            if newer():
                return
            if is_design:
                self._answer("closed_form", closed_form=Reply(subject, closed_form(session)))
            ends = perf_counter() + QUIET
            while perf_counter() < ends and not newer():
                sleep(0.01)
            if newer():
                return
            if is_design:
                self._answer("findings", findings=Reply(subject, findings(picture)))
            self._answer("quiet")
            self._slow.ask(subject)
        except Exception as failure:  # a page stays, whatever a design leads to
            words = f"{type(failure).__name__}: {failure}"
            self._answer("trouble", trouble=Reply(subject, words))
            print_exc(file=sys.stderr)

    def _on_news(self, subject: Editable, kind: str, what: Any) -> None:
        if kind == "stage":
            stage, left = what
            more = f", about {left:.0f} s left" if left else ""
            self._answer("stage", stage=f"{stage}{more}")
        elif kind == "model":
            with self.lock:
                before = self.better
                verdicts = before.what if before is not None and before.of == subject else ()
                others = tuple(verdict for verdict in verdicts if verdict.model != what.model)
            self._answer("better", better=Reply(subject, (*others, what)))
        elif kind in ("verdict", "signals"):
            self._answer(kind, **{kind: Reply(subject, what)}, trouble=None)
        elif kind == "done":
            self._answer("stage", stage="")
        else:  # refused, or failed
            self._answer("trouble", trouble=Reply(subject, str(what)), stage="")

    def _on_make_news(self, request: tuple[Any, Path], kind: str, what: Any) -> None:
        if kind == "stage":
            self._answer("making", making=f"Making {request[1]}: {what[0]} ...")
        elif kind == "made":
            summary, _, written = what
            self._answer("making", making=f"{summary}: {written}")
        elif kind in ("refused", "failed"):
            self._answer("making", making=f"Nothing was made: {what}")


def closed_form(session: Session) -> ContactCheck | str:
    """Return the closed form's verdict, or why it has none."""
    from skincad.mechanics.check import check

    try:
        return check(session.design, model="winkler")
    except (InputError, RefusedError) as refusal:
        return str(refusal)


def findings(picture: DesignView) -> tuple[Finding, ...]:
    """Return what stands against making a design; none where it has no mold, which says why itself."""
    from skincad.fabrication.filling import filling_findings
    from skincad.fabrication.findings import design_findings
    from skincad.fabrication.job import Job
    from skincad.fabrication.strips import strip_findings

    if picture.closed is None:
        return ()
    job = Job(picture.design, picture.closed)
    rows = [*design_findings(job), *filling_findings(job), *strip_findings(job)]
    order = ("error", "warning", "note")
    return tuple(sorted(rows, key=lambda finding: order.index(finding.severity)))
