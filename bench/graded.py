"""Graded pins warn before gross slip: which heights give the longest lead at which grip?

`python -m bench.graded [design]` presses pillars-9, or another design of one high pin among lower ones, with
each of GRIPS, of what presses its pins to a strain of 1, pulls at RATE, and prints how long before gross slip
the first pin slips for good, with its error, by how much lower the others are. All of it is at finite strain
in chosen steps. `--picture FILE` draws that. A lead in ms goes with the pull's rate; as a share of the pull
at gross slip it does not. Beside it stands the force at which all pins touch, of the grip: while that is less
than 1 the lead is about that share. Two minutes.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import skincad
from skincad.inputs import Design, load_design
from skincad.mechanics import limits
from skincad.mechanics.models import reduced
from skincad.scenes import Scene
from skincad.shape import skin_of

GRIPS = 0.004, 0.008, 0.016  # of what presses all pins to a strain of 1
LOWER = 0.01, 0.02, 0.03, 0.05, 0.07, 0.1  # by which all but the highest pin are lower, of its height
RATE = 0.08  # N/s, of the pull
FRICTION, STEPS, PRESS = 0.3, 100, 0.2  # s


class Lead(NamedTuple):
    """Of a `grip` in N and pins `lower` by mm: the force at which all touch, of the grip; the lead and its
    error, ms, and as a share of the pull at gross slip; None where nothing slips before all does, or why it
    stopped."""

    grip: float
    lower: float
    closing: float
    lead: float | None
    error: float | None
    share: float | None
    stopped: str


def graded(design: Design, lower: float) -> Design:
    """Return the design with all pins but its highest lower by so many mm."""
    high = max(skin_of(design).heights)
    return design.with_(pin={"height": None, "levelling": None, "heights": [high, high - lower]})


def lead_of(design: Design, grip: float, lower: float) -> Lead:
    """Return the lead of one design under one grip."""
    pull = 1.02 * FRICTION * grip
    history = {
        "steps": STEPS,
        "time_s": [0.0, PRESS, PRESS + pull / RATE],
        "normal_force_N": [0.0, grip, grip],
        "tangential_force_N": [0.0, 0.0, pull],
    }
    effects = {"friction": {"coefficient": FRICTION}, "finite_strain": {"steps": "chosen"}}
    scene = Scene(name="graded", skin=graded(design, lower), history=history, effects=effects)
    result = skincad.simulate(scene)
    closing = reduced.all_touch_force(reduced.pin_model(scene.design)) / grip
    leads = [(lead.value, lead.error) for lead in result.lead.values() if lead.value]
    if not leads or result.gross_slip_step is None:
        return Lead(grip, lower, closing, None, None, None, result.stopped or "")
    lead, error = max(leads)
    share = lead / 1e3 * RATE / float(result.tangential_force[result.gross_slip_step])
    return Lead(grip, lower, closing, lead, error, share, "")


def rows(design: Design) -> Iterator[Lead]:
    """Yield all leads of a design, told as they are known."""
    high, ends = max(skin_of(design).heights), limits(design)
    for grip in (round(part * skin_of(design).count * ends.squeeze, 3) for part in GRIPS):
        for part in LOWER:
            yield lead_of(design, grip, round(part * high, 3))


def line(row: Lead) -> str:
    """Return a row of the table."""
    start = f"{row.grip:7.3f} {row.lower:8.3f} {row.closing:7.0%}"
    if row.lead is None:
        return f"{start}   none  {row.stopped}"
    error = "?" if row.error is None else f"{row.error:.0f}"
    return f"{start} {row.lead:6.0f} +- {error:>4} {row.share:8.0%}"


def draw(found: Sequence[Lead], path: Path) -> None:
    """Draw the leads over the grading, a line a grip."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot as plt

    figure, axes = plt.subplots(figsize=(6, 4), layout="constrained")
    for grip in dict.fromkeys(row.grip for row in found):
        mine = [row for row in found if row.grip == grip and row.share is not None]
        bars = [(row.error or 0.0) / row.lead * row.share for row in mine if row.lead]
        shares = [row.share for row in mine]
        axes.errorbar([row.lower for row in mine], shares, bars, marker="o", capsize=3, label=f"{grip:g} N")
    axes.set_xlabel("all pins but the highest are lower by, mm")
    axes.set_ylim(0.0, 1.0)
    axes.set_ylabel("pull from the first slip to gross slip, of the pull then")
    axes.legend(title="grip")
    figure.savefig(path, dpi=150)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("design", nargs="?", default="pillars-9", help="a template, or a TOML file")
    parser.add_argument("--picture", type=Path, help="where to draw the leads")
    options = parser.parse_args()
    print(f"{'grip, N':>7} {'lower, mm':>8} {'closes':>8} {'lead, ms':>14} {'of pull':>8}")
    found = []
    for row in rows(load_design(options.design)):
        found.append(row)
        print(line(row), flush=True)
    for grip in dict.fromkeys(row.grip for row in found):
        best = max((row for row in found if row.grip == grip), key=lambda row: row.share or 0.0)
        words = f"{best.lower:g} mm, which all touch at {best.closing:.0%} of it"
        print(f"with {grip:g} N the longest lead is that of pins lower by {words}")
    if options.picture:
        draw(found, options.picture)


if __name__ == "__main__":
    main()
