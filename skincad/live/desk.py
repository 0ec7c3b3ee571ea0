"""A design or scene while somebody moves its sliders: the session, what answers it, and who computes that.

Whoever looks on is told of each change; nothing here knows of a browser.
"""

from __future__ import annotations

import sys
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from threading import RLock
from time import perf_counter, sleep
from traceback import print_exc
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from skincad.base.errors import InputError, RefusedError
from skincad.inputs.design import Design
from skincad.live.jobs import Signals, judged, made, simulated
from skincad.live.session import Edited, Session, begun, moved, redone, undone
from skincad.live.shapes import DrawnDesign, view
from skincad.live.worker import Newest, Worker
from skincad.scenes.scene import Scene
from skincad.studies.subject import Setting

if TYPE_CHECKING:
    from skincad.fabrication.finding import Finding
    from skincad.mechanics.verdict import ContactCheck

QUIET = 0.15  # s without a move, after which what takes longer than a picture is asked for
T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class Reply(Generic[T]):
    """What was found `of` a design or scene, which may have been moved on since."""

    of: Edited
    what: T


@dataclass(frozen=True, eq=False)
class Answers:
    """The newest of each kind; None where there was none yet. `better` are the verdicts of better tiers than
    the closed form as they came, `verdict` the last one, as `skincad check` has it."""

    view: Reply[DrawnDesign] | None = None
    closed_form: Reply[ContactCheck | str] | None = None
    findings: Reply[tuple[Finding, ...]] | None = None
    better: Reply[tuple[ContactCheck, ...]] | None = None
    verdict: Reply[ContactCheck] | None = None
    signals: Reply[Signals] | None = None
    trouble: Reply[str] | None = None
    stage: str = ""  # what is computed now
    making: str = ""  # what `make` is at, or said at its end


@dataclass(frozen=True)
class Timing:
    """When, s of `perf_counter`, a move came, and when its picture and first verdict had been handed on."""

    asked: float
    drawn: float
    judged: float


class Desk:
    """One session with its answers; `source` is the template or file that it began from.

    `looks_on` is told "session", "quiet" or which of the answers changed, from any thread, one at a time.
    `came` is when the move that is handled came, which may have waited for `lock`.
    """

    def __init__(self, subject: Edited, source: str, looks_on: Callable[[str], None]) -> None:
        self.source, self._looks_on = source, looks_on
        self.session, self.answers = begun(subject), Answers()
        self.timings: deque[Timing] = deque(maxlen=1000)
        self.came = perf_counter()
        self.lock = RLock()
        self._quick = Newest(self._work)
        self._slow = Worker(simulated if isinstance(subject, Scene) else judged, self._slow_told)

    @cached_property
    def _maker(self) -> Worker:
        return Worker(made, self._made_told)

    def begin(self) -> None:
        """Compute the first answers."""
        self._quick.give((self.session, self.came))

    def close(self) -> None:
        """End what runs beside, and tell nobody any more."""
        with self.lock:
            self._looks_on = lambda _: None
        self._slow.close()
        if "_maker" in self.__dict__:
            self._maker.close()

    def drawn(self, timeout: float) -> bool:
        """Wait until the newest subject is drawn, at most `timeout` s; return whether it is."""
        ends = perf_counter() + timeout
        while not self.stands(self.answers.view) and perf_counter() < ends:
            sleep(0.01)
        return self.stands(self.answers.view)

    def settled(self, timeout: float) -> bool:
        """Wait until all answers are of the newest subject, at most `timeout` s; return whether they are."""
        ends = perf_counter() + timeout
        while perf_counter() < ends:
            if self._quick.idle(0.05) and not self._slow.busy:
                return True
            sleep(0.01)
        return False

    def move(self, values: Mapping[str, Setting]) -> None:
        """Give keys other values."""
        self._become(lambda session: moved(session, values, perf_counter()))

    def undo(self) -> None:
        """Go a step back."""
        self._become(undone)

    def redo(self) -> None:
        """Take back the last undoing."""
        self._become(redone)

    def save(self, name: str) -> str:
        """Write a TOML file into the working directory, its comments kept; return what to say of it."""
        from skincad.outputs.designcopy import write_copy

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

    def stands(self, answer: Reply[Any] | None) -> bool:
        """Return whether an answer is of the subject as it is now."""
        return answer is not None and answer.of == self.session.subject

    def _become(self, step: Callable[[Session], Session]) -> None:
        with self.lock:
            before, self.session = self.session, step(self.session)
            self._looks_on("session")
            if self.session.subject != before.subject:
                self._quick.give((self.session, self.came))

    def _answer(self, kind: str, **changes: Any) -> None:
        with self.lock:
            self.answers = replace(self.answers, **changes)
            self._looks_on(kind)

    def _work(self, given: tuple[Session, float], newer: Callable[[], bool]) -> None:
        """What is quick, as long as nobody moves on: the picture, the closed form's verdict, findings."""
        session, asked = given
        subject, made_too = session.subject, isinstance(session.subject, Design)
        try:
            shown = view(session.design, molded=made_too)
            self._answer("view", view=Reply(subject, shown))
            drawn = perf_counter()
            if newer():
                return
            if made_too:
                self._answer("closed_form", closed_form=Reply(subject, closed_form(session)))
            self.timings.append(Timing(asked, drawn, perf_counter()))
            ends = perf_counter() + QUIET
            while perf_counter() < ends and not newer():
                sleep(0.01)
            if newer():
                return
            if made_too:
                self._answer("findings", findings=Reply(subject, findings(shown)))
            self._answer("quiet")
            self._slow.ask(subject)
        except Exception as failure:  # a page stays, whatever a design leads to
            words = f"{type(failure).__name__}: {failure}"
            self._answer("trouble", trouble=Reply(subject, words))
            print_exc(file=sys.stderr)

    def _slow_told(self, subject: Edited, kind: str, what: Any) -> None:
        if kind == "stage":
            stage, left = what
            more = f", about {left:.0f} s left" if left else ""
            self._answer("stage", stage=f"{stage}{more}")
        elif kind == "tier":
            with self.lock:
                before = self.answers.better
                told = before.what if before is not None and before.of == subject else ()
                others = tuple(found for found in told if found.tier != what.tier)
            self._answer("better", better=Reply(subject, (*others, what)))
        elif kind in ("verdict", "signals"):
            self._answer(kind, **{kind: Reply(subject, what)}, trouble=None)
        elif kind == "done":
            self._answer("stage", stage="")
        else:  # refused, or failed
            self._answer("trouble", trouble=Reply(subject, str(what)), stage="")

    def _made_told(self, asked: tuple[Any, Path], kind: str, what: Any) -> None:
        if kind == "stage":
            self._answer("making", making=f"Making {asked[1]}: {what[0]} ...")
        elif kind == "made":
            summary, _, written = what
            self._answer("making", making=f"{summary}: {written}")
        elif kind in ("refused", "failed"):
            self._answer("making", making=f"Nothing was made: {what}")


def closed_form(session: Session) -> ContactCheck | str:
    """Return the closed form's verdict, or why it has none."""
    from skincad.mechanics.touching import check

    try:
        return check(session.design, tier="winkler")
    except (InputError, RefusedError) as refusal:
        return str(refusal)


def findings(shown: DrawnDesign) -> tuple[Finding, ...]:
    """Return what stands against making a design; none where it has no mold, which says why itself."""
    from skincad.fabrication.filling import filling_findings
    from skincad.fabrication.findings import design_findings
    from skincad.fabrication.strip_rules import strip_findings

    design, closed = shown.design, shown.closed
    if closed is None:
        return ()
    found = [*design_findings(design, closed), *filling_findings(design, closed), *strip_findings(design)]
    order = ("error", "warning", "note")
    return tuple(sorted(found, key=lambda finding: order.index(finding.severity)))
