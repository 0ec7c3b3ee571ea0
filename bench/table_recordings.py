"""Dead, reversed and swapped strips by a recording: `python -m bench.table_recordings 26000 26200`.

A synthetic recording a seed, of four scenes with one, three or all monitored ridges. Its truth is another
simulation than the judge's: modulus, friction and speed up to 20 % off, crests by the mold's process; one in
ten with finite strain where `simulate` takes it. Each strip's gain scatters by 10 %, all have a common one of
0.6 to 1.6, noise, offset, drift, a start delay and a sampling of their own. Constants were chosen on seeds
22000 to 22199 and 23000 to 23199. Simulations are kept in the folder given last, out/recordings by default.

A recording is right if all its strips are: each fault named, all others said to work. It is undecided if a
strip has "can't tell", or if two strips are swapped that are named as alike. Else it is wrong.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from dataclasses import dataclass, replace
from functools import cache, partial
from pathlib import Path

import numpy as np

import skincad
from bench import runner
from skincad.inputs import FilmRecording
from skincad.scenes import (
    CANT_TELL,
    LEVELS,
    FilmPrediction,
    RecordingAcceptance,
    Scene,
    at_level,
    judge,
    modulus_range,
    predict_films,
    recorded_scene,
    strip_name,
    varied,
    with_modulus,
)

SCENES = {  # name: template, circuit, settings
    "press": ("yamada-2002-press", "transimpedance", ()),
    "press and pull": ("yamada-2002-press-and-pull", "charge-amplifier", ()),
    "fast pull": ("steady-pull", "transimpedance", ("history.steps=300",)),
    "lab bench": ("yamada-2002-press-and-pull", "voltage-follower", ("skin=lab-bench", "history.steps=80")),
}
VARIANTS = 10  # truths of each scene and thousand of seeds
OFF = 0.2  # relative: modulus, friction, speed
KINDS = "dead", "hum", "reversed", "swapped"


@cache
def scene_of(name: str) -> Scene:
    template, circuit, settings = SCENES[name]
    skin = next((s.partition("=")[2] for s in settings if s.startswith("skin=")), None)
    rest = [s for s in settings if not s.startswith("skin=")]
    scene = skincad.load_scene(template, rest, skin=skin)
    ridges = list(range(1, scene.design.ridge.count + 1))
    return recorded_scene(scene.with_(effects={"piezo": {"circuit": circuit}}, readout={"ridges": ridges}))


@cache
def prediction_of(name: str, folder: Path) -> FilmPrediction:
    path = folder / f"{name.replace(' ', '-')}.pkl"
    return runner.kept(path, lambda: predict_films(scene_of(name)))


@dataclass(frozen=True)
class Truth:
    """Outputs `(strips, steps)` V at `time` s of a scene that is not quite the one predicted."""

    time: np.ndarray
    outputs: np.ndarray


@cache
def truth_of(name: str, group: int, number: int, folder: Path) -> Truth:
    path = folder / f"{name.replace(' ', '-')}-{group}-{number}.pkl"
    return runner.kept(path, lambda: simulated(name, group, number))


def simulated(name: str, group: int, number: int) -> Truth:
    """Return a truth: tolerances, speed, then a hold that the judge's scene lacks."""
    draw = np.random.default_rng((group, list(SCENES).index(name), number))
    scene = scene_of(name)
    _, value, _ = modulus_range(scene.design)
    scene = varied(with_modulus(scene, value * draw.uniform(1 - OFF, 1 + OFF)), draw)
    h, speed = scene.history, draw.uniform(1 - OFF, 1 + OFF)
    longer = 1.3
    history = {
        "time_s": [t / speed for t in (*h.time_s, longer * h.time_s[-1])],
        "normal_force_N": [*h.normal_force_N, h.normal_force_N[-1]],
        "tangential_force_N": [*h.tangential_force_N, h.tangential_force_N[-1]],
        "steps": round(h.steps * longer),
    }
    scene = scene.with_(history=history)
    run = skincad.simulate(scene) if number == 0 else at_level(scene, LEVELS[0])
    output = run.read["output_V"]
    rows = [output[str(r)][s] for r in scene.readout.ridges for s in ("S1", "S2")]
    return Truth(run.march.time, np.array(rows))


@dataclass(frozen=True)
class Case:
    """A recording, what was done to its channels, and by what the judge predicts them."""

    scene: str
    prediction: FilmPrediction
    recording: FilmRecording
    states: dict[str, str]
    kinds: tuple[str, ...]


def case_of(seed: int, folder: Path) -> Case:
    draw = np.random.default_rng(seed)
    name = str(draw.choice(list(SCENES)))
    whole = prediction_of(name, folder)
    truth = truth_of(name, seed // 1000, int(draw.integers(VARIANTS)), folder)
    ridges = sorted({r for r, _ in whole.strips})
    count = int(draw.choice([1, 3, len(ridges)]))
    chosen = set(draw.choice(ridges, count, replace=False).tolist())
    at = [i for i, (r, _) in enumerate(whole.strips) if r in chosen]
    prediction = replace(
        whole,
        strips=tuple(whole.strips[i] for i in at),
        worlds=whole.worlds[:, at],
        changes=whole.changes[:, at],
    )
    outputs = (
        truth.outputs[at] * draw.normal(1.0, 0.1, (len(at), 1)) * np.exp(draw.uniform(*np.log([0.6, 1.6])))
    )
    states, kinds, outputs, humming = faulted(draw, prediction, outputs)
    press = prediction.press_end
    step, delay = press / draw.uniform(60, 400), press * draw.uniform(0.1, 1.0)
    last = truth.time[-1] * draw.uniform(0.9, 1.0) + delay
    time = np.arange(0.0, last, step)
    volts = np.array([np.interp(time - delay, truth.time, row, left=0.0) for row in outputs])
    peak = float(np.median(np.abs(outputs).max(axis=1)[np.abs(outputs).max(axis=1) > 0]))
    noise = peak * np.exp(draw.uniform(*np.log([0.001, 0.02])))
    volts += draw.normal(0, noise, volts.shape) + peak * draw.uniform(-0.2, 0.2, (len(at), 1))
    volts += peak * draw.uniform(-0.03, 0.03, (len(at), 1)) * time / time[-1]
    for i in humming:
        volts[i] += peak * draw.uniform(0.1, 1.0) * np.sin(2 * np.pi * (50 * time + draw.uniform()))
    time = np.round(time, 9)
    return Case(name, prediction, FilmRecording(prediction.strips, time, volts), states, kinds)


def faulted(draw, prediction: FilmPrediction, outputs: np.ndarray):
    """Return states by strip, kinds of the faults, the outputs with them, and channels that hum."""
    strips, outputs = prediction.strips, outputs.copy()
    states = {strip_name(s): "works" for s in strips}
    free, kinds, humming = list(range(len(strips))), [], []
    for _ in range(int(draw.choice([0, 1, 2], p=[0.3, 0.45, 0.25]))):
        kind = str(draw.choice(KINDS))
        if len(free) < 2 or (kind != "swapped" and len(strips) == 2 and len(free) < 2):
            break
        a = int(draw.choice(free))
        if kind == "swapped":
            how = int(draw.integers(3))
            same = [b for b in free if b != a and strips[b][0] == strips[a][0]]
            near = [b for b in free if abs(strips[b][0] - strips[a][0]) == 1]
            others = (same, near, [b for b in free if b != a])[how] or [b for b in free if b != a]
            b = int(draw.choice(others))
            outputs[[a, b]] = outputs[[b, a]]
            for one, other in ((a, b), (b, a)):
                states[strip_name(strips[one])] = f"swapped with {strip_name(strips[other])}"
                free.remove(one)
            kinds.append("swapped, one ridge" if strips[a][0] == strips[b][0] else "swapped, two ridges")
            continue
        free.remove(a)
        outputs[a] *= -1.0 if kind == "reversed" else 0.0
        states[strip_name(strips[a])] = "reversed" if kind == "reversed" else "dead"
        kinds.append("dead, humming" if kind == "hum" else kind)
        humming += [a] * (kind == "hum")
    return states, tuple(kinds), outputs, humming


def verdict(case: Case, result: RecordingAcceptance) -> str:
    told = {s.name: s for s in result.strips}
    answer = "right"
    for name, state in case.states.items():
        strip = told[name]
        if strip.state == state:
            continue
        other = state.removeprefix("swapped with ")
        if strip.state == CANT_TELL or (strip.state == "works" and other in strip.alike):
            answer = "undecided"
        else:
            return "wrong"
    return answer


def judged(seed: int, folder: Path) -> tuple[Case, RecordingAcceptance, str]:
    """Return a seed's case, the judge's answer, and what it is worth."""
    case = case_of(seed, folder)
    result = judge(scene_of(case.scene), case.prediction, case.recording)
    return case, result, verdict(case, result)


def row_of(seed: int, folder: Path) -> dict[str, str]:
    """Return a seed's groups, what the answer is worth, and what differs."""
    case, result, worth = judged(seed, folder)
    off = {
        s.name: (case.states[s.name], s.state, round(s.probability, 3), s.second, str(s.gain))
        for s in result.strips
        if s.state != case.states[s.name]
    }
    return {
        "fault": case.kinds[0] if len(case.kinds) == 1 else "two faults" if case.kinds else "no fault",
        "scene": case.scene,
        "ridges": {2: "1 ridge", 6: "3 ridges"}.get(len(case.states), "all ridges"),
        "worth": worth,
        "text": f"{seed} {worth} {case.scene} {case.kinds} {result.duration} {off}",
    }


def main() -> None:
    parser = runner.parser(__doc__, "first", "stop")
    parser.add_argument("folder", nargs="?", type=Path, default=Path("out/recordings"))
    parser.add_argument("-v", "--verbose", action="store_true", help="each recording that is not right")
    options = parser.parse_args()
    seeds = range(options.first, options.stop)
    rows = runner.rows("recordings", partial(row_of, folder=options.folder), seeds, options)
    tallies: dict[tuple[str, str], Counter[str]] = defaultdict(Counter)
    for row in rows:
        if options.verbose and row["worth"] != "right":
            print(row["text"])
        for group in ("fault", "scene", "ridges"):
            tallies[group, row[group]][row["worth"]] += 1
        tallies["", "all"][row["worth"]] += 1
    print("| | recordings | right | undecided | wrong | right, 95 % |\n|---|---|---|---|---|---|")
    for (group, name), tally in sorted(tallies.items(), key=lambda row: (row[0][0] or "z", row[0][1])):
        low, high = runner.wilson(tally["right"], tally.total())
        counts = [tally.total(), *(tally[worth] for worth in ("right", "undecided", "wrong"))]
        cells = [f"{group}: {name}" if group else name, *map(str, counts), f"{low:.0%} to {high:.0%}"]
        print(f"| {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
