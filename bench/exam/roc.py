"""What a threshold trades: gross slips warned of against false alarms, printed and drawn."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from bench.exam.cases import Case
from bench.exam.fitting import alarms
from bench.exam.scoring import HEAD, Mark, line, mark, rate, wilson
from skincad.scenes import detector

THRESHOLDS = tuple(float(t) for t in np.arange(-1.5, 4.1, 0.25))


def marks(told: list[Case], kind: str) -> dict[float, list[Mark]]:
    """Return by threshold what the detector's alarms of a kind are worth in cases, with noise."""
    table: dict[float, list[Mark]] = {threshold: [] for threshold in THRESHOLDS}
    for one in told:
        noise = math.sqrt(2) * one.noise
        d = detector.detector(one.rate, one.scene.bandwidth, noise, THRESHOLDS[0], kind)
        outputs = one.outputs + one.noises(1)
        odds = detector.statistic(d, detector.at_rest(outputs.shape[1]), outputs)[0]
        for threshold, each in table.items():
            each.append(mark(one, alarms(replace(d, threshold=threshold), odds), d.window))
    return table


def printed(found: dict[float, list[Mark]], kind: str) -> None:
    """Print a line a threshold."""
    print(f"\n{kind} alarms by threshold\n{HEAD}")
    for threshold, each in found.items():
        chosen = " (ours)" if detector.POINTS[kind].threshold == threshold else ""
        print(line(f"threshold {threshold:g}{chosen}", each), flush=True)


def point(each: list[Mark]) -> tuple[float, float, float, float]:
    """Return false alarms a minute of handling, and the % of gross slips warned of with its 95 % interval."""
    slips = [m for m in each if m.slips]
    hits = sum(m.warned for m in slips)
    minute = rate(sum(m.false for m in each), sum(m.seconds for m in each) / 60)[0]
    low, high = wilson(hits, len(slips))
    return minute, 100 * hits / max(1, len(slips)), 100 * low, 100 * high


def drawn(curves: dict[tuple[str, str], dict[float, list[Mark]]], path: Path) -> None:
    """Draw the curve of each amplifier and kind of alarms, what is shipped marked."""
    figure, axes = plt.subplots(figsize=(6, 4), layout="constrained")
    for (name, kind), found in curves.items():
        at = np.array([point(each) for each in found.values()])
        (drawn_line,) = axes.plot(at[:, 0], at[:, 1], marker=".", label=f"{name}, {kind}")
        axes.fill_between(at[:, 0], at[:, 2], at[:, 3], alpha=0.12, color=drawn_line.get_color())
        chosen = detector.POINTS[kind].threshold
        minute, share, *_ = point(found[chosen])
        axes.plot([minute], [share], marker="o", color=drawn_line.get_color())
    axes.set(
        xscale="log", xlabel="false alarms a minute of handling", ylim=(0, 100),
        ylabel="gross slips warned of, %",
    )  # fmt: skip
    axes.grid(alpha=0.3)
    axes.legend()
    figure.savefig(path, dpi=150)
    plt.close(figure)
