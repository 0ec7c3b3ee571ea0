"""Slip felt from two ridges' outputs, by scene and amplifier, beside detectors that never and always alarm.

`python -m bench.table_detector [-o DIR] [SCENE ...]` (default out/detector) marches every scene
that ships, and four of its own of a few ms, once each; adds 200 seeded noises; prints the table and the area
under the receiver operating curve, and draws it in roc.png. Constants of scenes/slip.py were chosen on the
scenes marked *; rolling, and what is named on the command line, they have not seen.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from threadpoolctl import threadpool_limits

from skincad.circuit.model import circuit_network, load_circuit
from skincad.effects.piezo import Chain, fitted, strip_charges
from skincad.inputs.catalog import template_names
from skincad.scenes import simulation
from skincad.scenes.levels import LEVELS
from skincad.scenes.scene import load_scene
from skincad.scenes.slip import (
    GROSS,
    INCIPIENT,
    THRESHOLD,
    Detector,
    Event,
    at_rest,
    detector,
    fed,
    score,
    statistic,
)

RIDGES = (2, 3)  # paper: strips in the second and third ridge from a side
CIRCUITS = ("transimpedance", "yamada-2002", "yamada-2002-motional")
LEVEL = LEVELS[1]
RUNS = 200
LOUDER = {  # times the noise
    "transimpedance": (1.0, 30.0, 100.0, 300.0),
    "yamada-2002": (1.0, 10.0),
    "yamada-2002-motional": (0.1, 1.0),
}
PULLS = ("hold", "readout.bandwidth_Hz=5000.0", "history.steps=400")
OWN = {
    "fast load *": (
        *PULLS, "history.time_s=[0.0, 0.001, 0.0015, 0.004]",
        "history.normal_force_N=[0.0, 4.0, 4.0, 4.0]", "history.tangential_force_N=[0.0, 0.0, 1.0, 1.0]",
    ),
    "to and fro *": (
        *PULLS, "history.steps=600", "history.time_s=[0.0, 0.001, 0.002, 0.003, 0.004, 0.005, 0.006]",
        "history.normal_force_N=[0.0, 4.0, 4.0, 4.0, 4.0, 4.0, 4.0]",
        "history.tangential_force_N=[0.0, 0.0, 1.5, -1.5, 1.5, 0.0, 0.0]",
    ),
    "press too far *": (
        *PULLS, "history.time_s=[0.0, 0.0005, 0.001, 0.002, 0.003, 0.004]",
        "history.normal_force_N=[0.0, 8.0, 3.0, 4.0, 4.0, 4.0]",
        "history.tangential_force_N=[0.0, 0.0, 0.0, 0.5, 0.5, 0.5]",
    ),
    "slip to -x": (
        "yamada-2002-slip", "history.tangential_force_N=[0.0, 0.0, -3.4, -3.4, -2.6, -3.2, -4.0]",
    ),
}  # fmt: skip
CHOSEN_ON = ("yamada-2002-slip", "yamada-2002-stage", "hold")


@dataclass(frozen=True, eq=False)
class Case:
    """A marched scene: outputs `(n, ridges, 2)` V of a circuit without noise, and what truly slipped."""

    name: str
    time: np.ndarray
    outputs: np.ndarray
    chain: Chain
    circuit: str
    noise: float
    runs: list[list[list[int]]]
    gross: int | None

    @property
    def detector(self) -> Detector:
        """The detector of this scene's rate and band."""
        return detector(1 / float(self.time[1]), self.chain.bandwidth, math.sqrt(2) * self.noise)

    @property
    def late(self) -> list[tuple[int, int]]:
        """The runs that last to gross slip, by told ridge."""
        return [
            (a, b) for mine in self.runs for a, b in mine if self.gross is not None and a <= self.gross <= b
        ]


def cases(name: str, settings: Sequence[str]) -> list[Case]:
    """March a scene once and return it by each circuit."""
    scene = load_scene(settings[0], [f"readout.ridges={list(RIDGES)}", *settings[1:]])
    with_film = [] if "film" in scene.effects else ["effects.film={}"]
    scene = load_scene(settings[0], [f"readout.ridges={list(RIDGES)}", *settings[1:], *with_film])
    found = simulation.at_level(scene, LEVEL)
    time = found.march.time
    stress = found.march.column("films")
    made = []
    for circuit in CIRCUITS:
        own = fitted(load_circuit(circuit), scene.design)
        chain = Chain.of(circuit_network(own), time, scene.readout.bandwidth_Hz)
        charges = strip_charges(own, scene.design, stress)
        outputs = [[chain.output(charges[:, 2 * (r - 1) + side]) for side in (0, 1)] for r in RIDGES]
        made.append(
            Case(
                name, time, np.moveaxis(np.array(outputs), 2, 0), chain, circuit,
                chain.noise_rms(), [found.runs[r - 1] for r in RIDGES], found.gross_slip_step,
            )
        )  # fmt: skip
    return made


def noises(case: Case) -> np.ndarray:
    """Return `(RUNS, n, ridges, 2)` V of noise."""
    shape = (RUNS, len(RIDGES), 2)
    drawn = [case.chain.noise((seed, ridge, side)) for seed, ridge, side in np.ndindex(shape)]
    return np.moveaxis(np.array(drawn).reshape(*shape, -1), 3, 1)


def alarms(case: Case, noise: np.ndarray | float = 0.0) -> list[Event]:
    """Return the detector's events."""
    return fed(case.detector, at_rest(case.detector, len(RIDGES)), case.outputs + noise)[0]


def always(case: Case) -> list[Event]:
    """An alarm of every ridge and of all in every window."""
    at = range(0, case.time.size, case.detector.window)
    return [
        e for i in at for e in (*(Event(INCIPIENT, r, i) for r in range(len(RIDGES))), Event(GROSS, None, i))
    ]


def row(case: Case, what: str, events: list[list[Event]]) -> str:
    """Return a table's line: mean hits, misses and false alarms, median lead and its worst."""
    found = [score(case.detector, e, case.time, case.runs, case.gross) for e in events]
    means = [float(np.mean([getattr(s, key) for s in found])) for key in ("hits", "missed", "false")]
    leads = [[1e3 * x for s in found if (x := s.lead[told]) is not None] for told in range(len(RIDGES))]
    text = "  ".join(f"{np.median(x):7.3g} ({min(x):.3g})" if x else f"{'-':>7}" for x in leads)
    return f"{case.name:26} {case.circuit:20} {what:15}" + "".join(f"{m:8.2f}" for m in means) + f"   {text}"


def level(case: Case, noise: np.ndarray | float, louder: float) -> tuple[float | None, float]:
    """Return the largest statistic within the slips that last to gross slip, None without, and elsewhere."""
    d = Detector(case.detector.window, louder * case.detector.noise)
    values = statistic(d, at_rest(d, len(RIDGES)), case.outputs + noise)
    free, late = np.ones(values.shape, bool), []
    for told, mine in enumerate(case.runs):
        for a, b in mine:
            inside = slice(max(0, a - d.window), b + d.window + 1)
            free[inside, told] = False
            if (a, b) in case.late:
                late.append(float(values[inside, told].max()))
    return (max(late) if late else None), float(values[free].max())


def area(slips: np.ndarray, others: np.ndarray) -> float:
    """Return the share of pairs in which the slip has the larger statistic, ties half: the curve's area."""
    difference = slips[:, None] - others[None, :]
    return float(np.mean((difference > 0) + 0.5 * (difference == 0)))


def main(arguments: list[str]) -> None:
    """Print the table and draw the curve."""
    folder = Path(arguments[arguments.index("-o") + 1]) if "-o" in arguments else Path("out/detector")
    named = [a for a in arguments if a != "-o" and a != str(folder)]
    shipped = {n + (" *" if n in CHOSEN_ON else ""): (n,) for n in named or template_names("scenes")}
    told = [case for name, s in {**shipped, **({} if named else OWN)}.items() for case in cases(name, s)]
    print(
        f"{'scene':26} {'amplifier':20} {'detector':15}{'hits':>8}{'missed':>8}{'false':>8}"
        "   lead of ridges 2, 3: ms (least)"
    )
    pool: dict[tuple[str, float], tuple[list[float], list[float]]] = {}
    for case in told:
        drawn = noises(case)
        print(row(case, "noiseless", [alarms(case)]))
        print(row(case, f"{RUNS} noises", [alarms(case, noise) for noise in drawn]))
        if case.circuit == CIRCUITS[0]:
            print(row(case, "always silent", [[]]))
            print(row(case, "always alarming", [always(case)]))
        for louder in LOUDER[case.circuit]:
            slips, rest = pool.setdefault((case.circuit, louder), ([], []))
            for noise in drawn:
                late, other = level(case, louder * noise, louder)
                rest.append(other)
                if late is not None:
                    slips.append(late)
    folder.mkdir(parents=True, exist_ok=True)
    curves({key: (np.array(a), np.array(b)) for key, (a, b) in pool.items()}, folder / "roc.png")


def curves(pool: dict[tuple[str, float], tuple[np.ndarray, np.ndarray]], path: Path) -> None:
    """Print each curve's area and draw them."""
    figure = Figure(figsize=(6.4, 5.6), dpi=100, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    for (circuit, louder), (slips, others) in pool.items():
        if not slips.size:
            continue
        levels = np.sort(np.concatenate([slips, others, [np.inf]]))[::-1]
        seen = [np.mean(slips >= x) for x in levels]
        wrong = [np.mean(others >= x) for x in levels]
        at = float(np.mean(others > THRESHOLD)), float(np.mean(slips > THRESHOLD))
        found = area(slips, others)
        print(
            f"{circuit:20} noise x {louder:<5g} area {found:.4f}; "
            f"at {THRESHOLD:g} rms: seen {at[1]:.3f}, false {at[0]:.3f}"
        )
        dashed = dict(zip(CIRCUITS, ("-", "--", ":"), strict=True))[circuit]
        (line,) = axes.step(
            wrong, seen, dashed, where="post", label=f"{circuit}, noise x {louder:g}: {found:.3f}"
        )
        axes.plot(*at, "o", color=line.get_color(), markersize=4)
    axes.plot(
        [0, 1], [0, 1], color="#999", linewidth=0.8, label="silent at (0, 0), always at (1, 1), or chance"
    )
    axes.set_xlabel("share of runs with a false alarm in them")
    axes.set_ylabel("share of slips seen before gross slip")
    axes.set_title(f"{RUNS} noises a scene; points: threshold of {THRESHOLD:g} noise rms", fontsize=10)
    axes.legend(fontsize=8, loc="lower right")
    axes.grid(color="#ddd", linewidth=0.6)
    figure.savefig(path)


if __name__ == "__main__":
    with threadpool_limits(limits=1, user_api="blas"):
        main(sys.argv[1:])
