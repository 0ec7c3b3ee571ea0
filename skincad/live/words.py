"""The page's words as HTML: the state of the design, verdicts with their error bars, findings."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import TYPE_CHECKING

from skincad.live.session import Session
from skincad.mechanics.verdict import ContactCheck
from skincad.outputs import checks

if TYPE_CHECKING:
    from skincad.fabrication.rules import Finding
    from skincad.live.desk import Answers, Desk

RED, GREEN, AMBER, BLUE, GREY = "#b3261e", "#1b6e3c", "#8a5a00", "#1f5fa8", "#6b7280"
PALE = {RED: "#fdecea", GREEN: "#e7f4ec", AMBER: "#fdf3e0", BLUE: "#e9f0f8", GREY: "#f1f2f4"}
NAMES = {"winkler": "closed form"}
BARS = 260.0, 20.0  # px: width of the error bars' scale, height of a row
MAX_FINDINGS = 12


def text_html(text: str) -> str:
    """Return HTML as all of the page's is set."""
    return f"<div style='font-size:13px;line-height:1.35;padding:0 8px;overflow-wrap:anywhere'>{text}</div>"


def state_html(session: Session) -> str:
    """Return the state: the design, or why the wanted values make none."""
    if session.refusal is not None:
        waiting = f"The skin shown is the last that is one: {escape(_values(session))} waits."
        return _box(RED, f"<b>{escape(str(session.refusal))}</b><br>{waiting} Undo drops it.")
    steps = len(session.past)
    changed = f"{steps} change{'s' * (steps != 1)}" if steps else "as it was loaded"
    return _box(GREY, f"<b>{escape(session.subject.name)}</b>: {changed}")


def _values(session: Session) -> str:
    items = (
        f"{key} = {value}" if value is not None else f"no {key}" for key, value in session.pending.items()
    )
    return ", ".join(items)


def best(desk: Desk) -> ContactCheck | str | None:
    """Return the verdict of the best model that has answered for the design as it is now; why the closed form
    has none; None where nothing has answered yet."""
    answers = desk.answers
    if answers.verdict is not None and desk.is_current(answers.verdict):
        return answers.verdict.what
    if answers.better is not None and desk.is_current(answers.better):
        return answers.better.what[-1]
    if answers.closed_form is not None and desk.is_current(answers.closed_form):
        return answers.closed_form.what
    return None


def verdict_html(desk: Desk) -> str:
    """Return the best verdict there is, and all models' forces with their error bars."""
    answers, verdict = desk.answers, best(desk)
    if isinstance(verdict, ContactCheck):
        last = answers.verdict is not None and answers.verdict.what is verdict
        note = "the verdict of <code>skincad check</code>" if last else "better models follow"
        model = NAMES.get(verdict.model, f"{verdict.model} model")
        words = f"<b>{escape(checks.verdict(verdict))}</b><br>By the {model}; {note}."
        headline = _box({"passes": GREEN, "fails": RED}.get(verdict.verdict, AMBER), words)
    else:
        headline = _box(AMBER, escape(verdict or "..."))
    stage = f"<div style='color:{GREY}'>{escape(answers.stage)} ...</div>" if answers.stage else ""
    if answers.trouble is not None and desk.is_current(answers.trouble):
        stage = _box(AMBER, escape(answers.trouble.what))
    return headline + _rows(desk) + stage + _advice(desk)


def _advice(desk: Desk) -> str:
    final = desk.answers.verdict
    if final is None or not desk.is_current(final):
        return ""
    return lines_html([*checks.CHECK.lines(final.what)[1:], *checks.CHECK.details(final.what)])


def lines_html(lines: Sequence[str]) -> str:
    """Return the lines that a command prints, their first words as the heads of a table's rows."""
    rows = []
    for line in lines:
        head, text = (line[2:17].strip(), line[17:]) if line.startswith("  ") else ("", line)
        first = (
            f"<td style='color:{GREY};white-space:nowrap;padding-right:8px'>{escape(head)}</td>"
            if head
            else ""
        )
        span = "" if head else " colspan='2'"
        rows.append(f"<tr style='vertical-align:top'>{first}<td{span}>{escape(text.strip())}</td></tr>")
    return f"<table style='font-size:12px;line-height:1.3;border-spacing:0'>{''.join(rows)}</table>"


def _rows(desk: Desk) -> str:
    """A row for each model: its name, an error bar on a common scale, its force."""
    answers, rows = desk.answers, []
    if answers.closed_form is not None and isinstance(answers.closed_form.what, ContactCheck):
        rows.append((answers.closed_form.what, desk.is_current(answers.closed_form)))
    if answers.better is not None:
        rows += [(check, desk.is_current(answers.better)) for check in answers.better.what]
    final = answers.verdict
    if final is not None and desk.is_current(final):
        rows = [row for row in rows if row[0].model != final.what.model] + [(final.what, True)]
    rows = [row for row in rows if row[0].all_touch_force.value is not None]
    if not rows:
        return ""
    force = rows[0][0].force
    tops = [min((f.all_touch_force.upper or 0.0), 3 * (f.all_touch_force.value or 0.0)) for f, _ in rows]
    far = 1.15 * max(force, *tops)
    wide, high = BARS
    bars = [_bar(check, fresh, place * high, wide / far) for place, (check, fresh) in enumerate(rows)]
    line, low = force * wide / far, len(rows) * high
    force_line = (
        f"<line x1='{line:.1f}' x2='{line:.1f}' y1='0' y2='{low}' stroke='{BLUE}' stroke-dasharray='3 2'/>"
        f"<text x='{line:.1f}' y='{low + 11}' text-anchor='middle' fill='{BLUE}'>{force:g} N asked</text>"
    )
    frame = f"viewBox='-112 0 {wide + 112:.0f} {low + 14:.0f}' width='100%' font-size='10.5'"
    title = "Force at which all ridges touch, N"
    return f"<div><b>{title}</b></div><svg {frame}>{force_line}{''.join(bars)}</svg>"


def _bar(check: ContactCheck, fresh: bool, top: float, scale: float) -> str:
    force, middle = check.all_touch_force, top + BARS[1] / 2
    value, error = force.value or 0.0, force.error or 0.0
    ink = "#222" if fresh else "#a9adb5"
    low, high = max(0.0, value - error) * scale, min((value + error) * scale, BARS[0])
    name = NAMES.get(check.model, check.model.replace("corrected-finite-strain", "corr.-finite-str."))
    name += "" if fresh else " (older)"
    return (
        f"<text x='-4' y='{middle + 3.5}' text-anchor='end' fill='{ink}'>{escape(name)}</text>"
        f"<line x1='{low:.1f}' x2='{high:.1f}' y1='{middle}' y2='{middle}' stroke='{ink}' stroke-width='2'/>"
        f"<circle cx='{value * scale:.1f}' cy='{middle}' r='3.2' fill='{ink}'/>"
        f"<title>{escape(str(force))}</title>"
    )


def findings_html(desk: Desk) -> str:
    """Return what stands against making the design."""
    answers = desk.answers
    if answers.view is not None and answers.view.what.refusal:
        return _box(AMBER, f"<b>No mold.</b> {escape(answers.view.what.refusal)}")
    if answers.findings is None:
        return ""
    fresh = desk.is_current(answers.findings)
    findings, old = answers.findings.what, "" if fresh else " (older than the design)"
    if not findings:
        return _box(GREEN if fresh else GREY, f"Nothing stands against making it{old}.")
    boxes = "".join(_finding(finding) for finding in findings[:MAX_FINDINGS])
    more = len(findings) - MAX_FINDINGS
    rest = f"<div>and {more} more</div>" if more > 0 else ""
    return f"<div style='opacity:{1.0 if fresh else 0.45}'><b>Making it{old}</b>{boxes}{rest}</div>"


def _finding(finding: Finding) -> str:
    colour = {"error": RED, "warning": AMBER}.get(finding.severity, GREY)
    return _box(colour, escape(str(finding)))


def making_html(answers: Answers, saved: str) -> str:
    """Return what `make` and `save` last said."""
    texts = [text for text in (saved, answers.making) if text]
    return "".join(_box(BLUE, escape(text)) for text in texts)


def _box(colour: str, text: str) -> str:
    style = (
        f"border-left:4px solid {colour};background:{PALE[colour]};color:#222;padding:4px 8px;margin:4px 0"
    )
    return f"<div style='{style}'>{text}</div>"


def signals_html(desk: Desk) -> str:
    """Return what a scene's simulation says, and how far the next one has come."""
    answers = desk.answers
    stage = f"<div style='color:{GREY}'>{escape(answers.stage)} ...</div>" if answers.stage else ""
    if answers.trouble is not None and desk.is_current(answers.trouble):
        stage = _box(AMBER, escape(answers.trouble.what))
    if answers.signals is None:
        return stage
    signals, fresh = answers.signals.what, desk.is_current(answers.signals)
    how = "one coarse mesh, of unknown error" if signals.rough else "as <code>skincad simulate</code> has it"
    colour, words = (GREY, how) if fresh else (AMBER, f"{how}; older than the scene")
    lines = lines_html(signals.lines)
    return f"{_box(colour, words)}<div style='opacity:{1.0 if fresh else 0.45}'>{lines}</div>{stage}"
