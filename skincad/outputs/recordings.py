"""Output of an acceptance by a recording: which strips work, and what is wrong with the others."""

from __future__ import annotations

from skincad.outputs.delivery import Presentation
from skincad.scenes.acceptance import CANT_TELL, RecordingAcceptance, StripState
from skincad.scenes.strip_assignment import WORKS

COMMAND = "accept"
MOST_PAIRS = 4  # that are named in the answer


def lines(result: RecordingAcceptance) -> list[str]:
    """Return the verdict, the strips that do not clearly work, and what the recording can't tell."""
    working = sum(strip.state == WORKS for strip in result.strips)
    verdict = "ACCEPTED" if result.passed else "NOT ACCEPTED"
    faults = [strip for strip in result.strips if strip.state != WORKS]
    return [
        f"{result.name}: {verdict}, {working} of {len(result.strips)} strips work.",
        *(f"  {strip.name:14} {_words(strip)}" for strip in faults),
        f"  gain           {result.common_gain} times the prediction",
        f"  start          {result.delay} after the recording's, at {result.duration:.2f} times the duration",
        *_alike(result),
        *(f"  note           {warning}" for warning in result.warnings),
    ]


def _words(strip: StripState) -> str:
    if strip.state == CANT_TELL:
        return f"can't tell: {strip.second} is most likely, {strip.probability:.0%}"
    return f"{strip.state} ({strip.probability:.1%} sure), gain {strip.gain}"


def _alike(result: RecordingAcceptance) -> list[str]:
    """Which strips could have changed places without the recording's showing it."""
    pairs = sorted({tuple(sorted((s.name, other))) for s in result.strips for other in s.alike})
    if not pairs:
        return []
    named = "; ".join(f"{a} from {b}" for a, b in pairs[:MOST_PAIRS])
    more = f"; {len(pairs) - MOST_PAIRS} more pairs (-v)" if len(pairs) > MOST_PAIRS else ""
    by = "recording" if result.pull else "press"
    return [f"  can't tell     {named}{more}: by this {by} a swap would not show"]


def next_step(result: RecordingAcceptance) -> str:
    """Return what to do next."""
    unsure = any(strip.state == CANT_TELL or strip.alike for strip in result.strips)
    if unsure and not result.pull:
        return "pull too, or press aside, and record that scene: a pull tells mirrored strips apart."
    if not result.passed:
        return "check the wires of the strips that are named, and record again."
    return ""


def details(result: RecordingAcceptance) -> list[str]:
    """Return state, probability and gain of each strip."""
    rows = []
    for strip in result.strips:
        alike = f"; like {', '.join(strip.alike)}" if strip.alike else ""
        rows.append(f"  {strip.name:14} {strip.state}, {strip.probability:.1%}, gain {strip.gain}{alike}")
    return [*rows, f"  seconds        {result.seconds['total']:.2f}"]


RECORDING = Presentation(
    COMMAND=COMMAND, lines=lines, next_step=next_step, details=details, files=lambda _: {}
)
