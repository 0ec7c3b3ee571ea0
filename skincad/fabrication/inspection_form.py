"""The inspection as a form of the casting sheet: what to measure and how, limits, and room to write."""

from __future__ import annotations

from skincad.fabrication.crest_limits import GAUGE_SIGMA
from skincad.fabrication.inspection import Inspection


def inspection_lines(inspected: Inspection) -> list[str]:
    """Return the form as Markdown."""
    limits = [f"±{limit:.3f}" for limit in inspected.crests.beside] or ["-"] * len(inspected.crests.heights)
    crests = [
        f"| {ridge} | {height:.3f} | | | | {limit} |"
        for ridge, (height, limit) in enumerate(zip(inspected.crests.heights, limits, strict=True), 1)
    ]
    rows = [
        f"| {m.what} | {m.nominal:.3f} | {m.low:.3f} to {m.high:.3f} | | {m.unit} | {m.how} |"
        for m in inspected.measures
    ]
    return [
        "## Inspection",
        "",
        "Measure the finished skin on its carrier, a day after the last cure. Crests first: each over "
        "the back, in the middle of its width and its length, by a microscope's focus or a profile projector "
        f"that repeats to {GAUGE_SIGMA:g} mm; a dial gauge does it if it presses all crests alike.",
        "",
        "| ridge | comes out at, mm | measured, mm | more than that | beside the line | limit |",
        "|---|---|---|---|---|---|",
        *crests,
        "",
        *_by_hand(len(inspected.crests.heights)),
        "| what | nominal | limits | measured | unit | with |",
        "|---|---|---|---|---|---|",
        *rows,
        "",
        *(line for remark in inspected.said for line in (remark, "")),
    ]


def _by_hand(count: int) -> list[str]:
    """How a person comes by what lies beside the line: columns A to F are the table's."""
    if count == 1:
        return []
    last = count + 1
    over = f"D$2:D${last},A$2:A${last}"
    beside = f"column E is `=D2-FORECAST(A2,{over})`, " if count > 2 else ""
    return [
        "A line through the fourth column over the first takes out how the part lay under the gauge. In a "
        f"spreadsheet with this table from A1 on, {beside}the tilt `={count - 1}*SLOPE({over})`. A crest "
        "beyond its limit is a fault of its own: look for a bubble, a blocked groove or flash.",
        "",
    ]
