"""The page's words as HTML, by templates/pages/live.html: the design's state, verdicts, findings, signals."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from skincad.live.session import Session
from skincad.mechanics.verdict import ContactCheck
from skincad.outputs import checks
from skincad.outputs.pages import html

if TYPE_CHECKING:
    from skincad.detector.listening import Listener
    from skincad.live.desk import Desk

PAGE = "live.html"


def text_html(text: str) -> str:
    """Return HTML as all of the page's is set."""
    return html(PAGE, "text", text)


def state_html(session: Session) -> str:
    """Return the state: the design, or why the wanted values make none."""
    return html(PAGE, "state", session)


def best(desk: Desk) -> ContactCheck | str | None:
    """Return the verdict of the best model that has answered for the design as it is now; why the closed form
    has none; None where nothing has answered yet."""
    if desk.verdict is not None and desk.is_current(desk.verdict):
        return desk.verdict.what
    if desk.better is not None and desk.is_current(desk.better):
        return desk.better.what[-1]
    if desk.closed_form is not None and desk.is_current(desk.closed_form):
        return desk.closed_form.what
    return None


def verdict_html(desk: Desk) -> str:
    """Return the best verdict there is, and all models' forces with their error bars."""
    verdict, rows = best(desk), list[tuple[ContactCheck, bool]]()
    if desk.closed_form is not None and isinstance(desk.closed_form.what, ContactCheck):
        rows.append((desk.closed_form.what, desk.is_current(desk.closed_form)))
    if desk.better is not None:
        rows += [(check, desk.is_current(desk.better)) for check in desk.better.what]
    final = desk.verdict.what if desk.verdict and desk.is_current(desk.verdict) else None
    if final is not None:
        rows = [row for row in rows if row[0].model != final.model] + [(final, True)]
    rows = [row for row in rows if row[0].all_touch_force.value is not None]
    headline = checks.verdict(verdict) if isinstance(verdict, ContactCheck) else ""
    lines = [*checks.CHECK.lines(final)[1:], *checks.CHECK.details(final)] if final else []
    last = final is not None and verdict is final
    return html(PAGE, "verdict", verdict, headline, last, rows, desk, _trouble(desk), lines)


def _trouble(desk: Desk) -> str:
    trouble = desk.trouble
    return trouble.what if trouble is not None and desk.is_current(trouble) else ""


def findings_html(desk: Desk) -> str:
    """Return what stands against making the design."""
    no_mold = desk.view.what.refusal if desk.view else ""
    if desk.findings is None:
        return html(PAGE, "findings", (), True, no_mold) if no_mold else ""
    fresh = desk.is_current(desk.findings)
    return html(PAGE, "findings", desk.findings.what, fresh, no_mold)


def making_html(desk: Desk, saved: str) -> str:
    """Return what `make` and `save` last said."""
    return html(PAGE, "making", [text for text in (saved, desk.making) if text])


def signals_html(desk: Desk) -> str:
    """Return what a scene's simulation says, and how far the next one has come."""
    signals = desk.signals.what if desk.signals else None
    fresh = desk.is_current(desk.signals)
    return html(PAGE, "signals", signals, fresh, desk, _trouble(desk))


def listening_html(name: str, listener: Listener, events: list[dict[str, Any]]) -> str:
    """Return what a detector that listens has heard, the newest of its events first."""
    return html(PAGE, "listening", name, listener, events)
