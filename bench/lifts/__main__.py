"""The exam of lifts: is the object held, how far does it slide, how hard is it squeezed, by policy?

`python -m bench.lifts [--count N] [--first SEED] [--workers N] [--what policies|links|slow]` (default: 300
odd seeds from 1 on). Each lift is marched with each of the POLICIES; `--what links` marches the detector's
again with one link better, `--what slow` gentle lifts of SLOW N behind several amplifiers and on several
skins. Shares have their 95 % intervals (Wilson). An even first seed takes lifts that constants were set on.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from bench import runner
from bench.exam.scenes import Skin
from bench.lifts.fitting import AHEAD
from bench.lifts.scenes import (
    AMPLIFIERS,
    BAND,
    DELAY,
    FIRST,
    FRICTION,
    LONG,
    RATE,
    STRONG,
    Lift,
    circuit,
    drawn,
    effects,
    finger,
    first_two,
)
from skincad.detector import EARLY, GRIP, SURE, change_noise
from skincad.effects import Piezo
from skincad.inputs import load_design
from skincad.scenes import Scene
from skincad.scenes.grip import FINGERS, GRAVITY
from skincad.scenes.lift import LiftRun, carried, ears_of

POLICIES = {
    "constant": {"grip": {"policy": "constant"}},
    "detector, grip": {"grip": {"policy": "detector"}, "readout": {"alarms": GRIP}},
    "detector, sure": {"grip": {"policy": "detector"}, "readout": {"alarms": SURE}},
    "detector, early": {"grip": {"policy": "detector"}, "readout": {"alarms": EARLY}},
    "stress-rate": {"grip": {"policy": "stress-rate"}},
    "force and friction known": {"grip": {"policy": "force"}},
}
HEARS = "detector, grip"
SLIDE = 1.0  # mm
GOAL = 1.3  # of the least grip, a mean
STILL = 0.02  # s before the end, in which what is held does not slide
FALSE = 0.85  # of what friction bears: a raise is false where less is ahead
BINS = {
    "delay": (0.01, 0.02, 0.035, 0.05),
    "rise": (0.05, 0.1, 0.2, 0.4, 0.8),
    "first": (0.4, 0.6, 0.8, 1.0, 1.1),
    "signal": (-100.0, 10.0, 20.0, 30.0, 200.0),
}


@dataclass(frozen=True)
class Mark:
    """A lift's score: whether it is `held`, mm of its `slide`, `mean` and `peak` grip over the least since
    the fingers closed, `raises` and how many were `false`, what it was drawn with, and dB of `signal`."""

    seed: int
    policy: str
    link: str
    held: bool
    slide: float
    mean: float
    peak: float
    raises: int
    false: int
    delay: float
    rise: float
    first: float
    friction: float
    kind: str
    amplifier: str
    skin: str
    signal: float
    seconds: float

    @property
    def firm(self) -> bool:
        """Whether it is held with a slide below SLIDE."""
        return self.held and self.slide < SLIDE


def _grip(**values: Any) -> Callable[[Lift], dict[str, Any]]:
    return lambda _: {"grip": values}


def _piezo(**values: Any) -> Callable[[Lift], dict[str, Any]]:
    return lambda one: {"effects": {"piezo": {**one.scene.effects["piezo"], **values}}}


LINKS: dict[str, Callable[[Lift], dict[str, Any]]] = {
    "as drawn": lambda _: {},
    "no noise": _piezo(noise_seed=None),
    "delay 5 ms": _grip(delay=0.005),
    "force rate x 10": lambda one: {"grip": {"force_rate": 10.0 * (one.scene.grip.force_rate or 0.0)}},  # type: ignore[union-attr]
    "both": lambda one: {"grip": {"force_rate": 10.0 * (one.scene.grip.force_rate or 0.0), "delay": 0.005}},  # type: ignore[union-attr]
    "first grip 0.8 of the least": lambda one: {"grip": {"force": 0.8 * one.least}},
    "two ridges wired": lambda one: {"readout": {"ridges": list(first_two(one))}},
    **{f"all behind {name}": _piezo(circuit=circuit(name)) for name in AMPLIFIERS},
}


def judged(one: Lift, scene: Scene, policy: str, link: str) -> Mark:
    """Return the score of a lift's march as `scene` has it."""
    grip, piezo = scene.grip, scene.effects["piezo"]
    assert grip is not None
    run = carried(scene, finger(one), rate=RATE, seed=piezo.get("noise_seed"))
    closed, end = math.ceil(grip.close * RATE), run.time.size
    moving = bool(run.slides[max(closed, end - round(STILL * RATE)) :].any())
    taken = run.grip[closed:] / one.least
    slide = float(np.abs(run.slide).max())
    return Mark(
        one.seed, policy, link, not run.lost and not moving, slide, float(taken.mean()), float(taken.max()),
        len(run.alarms), false(one, run, grip.delay or 0.0), grip.delay or 0.0, one.rise,
        grip.force / one.least, one.friction, one.kind, one.amplifier, one.skin.name,
        signal(one, scene, run, closed), run.seconds,
    )  # fmt: skip


def false(one: Lift, run: LiftRun, delay: float) -> int:
    """Return how many alarms came where the load until AHEAD and the delay later is below FALSE of what
    friction bears at that grip, and nothing slides."""
    count, late = 0, round((AHEAD + delay) * RATE)
    for at in run.alarms:
        ahead = float(np.abs(run.load[at : at + late + 1]).max())
        count += ahead < FALSE * one.friction * float(run.grip[at]) and not run.slides[at]
    return count


def signal(one: Lift, scene: Scene, run: LiftRun, closed: int) -> float:
    """Return dB of the loudest pair's stress-rate while the load comes, over its noise."""
    differs, noise = _noise(scene)
    pair = run.outputs[:, :, 0] - run.outputs[:, :, 1]
    pair = np.diff(pair, axis=0, prepend=pair[:1]) if differs else pair
    rows = pair[closed : closed + round(one.rise * RATE)]
    power = float((rows**2).mean(axis=0).max()) / noise**2 if rows.size else 0.0
    return 10 * math.log10(max(power - 1.0, 1e-3))


_NOISES: dict[tuple[str, str], tuple[bool, float]] = {}  # by skin and amplifier


def _noise(scene: Scene) -> tuple[bool, float]:
    """Return whether the amplifier tells the stress, and V rms of a pair's noise: of its rate, then."""
    piezo = scene.parts["piezo"]
    assert isinstance(piezo, Piezo)
    key = (scene.design.name, repr(piezo.loaded))
    if key not in _NOISES:
        ears = ears_of(scene, RATE, 2000, None, 1.0)
        assert ears is not None
        chain = ears.chain
        change = change_noise(GRIP, chain.network, chain.bandwidth, RATE)
        noise = math.sqrt(2) * chain.noise_rms() if change is None else change
        _NOISES[key] = change is not None, noise
    return _NOISES[key]


def judge(case: str) -> Mark:
    """Return the score of a case, "seed/policy/link"."""
    seed, policy, link = case.split("/")
    one = drawn(int(seed))
    scene = one.scene.with_(**POLICIES[policy])
    if changes := LINKS[link](one):
        scene = scene.with_(**changes)
    return judged(one, scene, policy, link)


SLOW = 0.5  # N on each finger
SLOW_SKINS: dict[str, dict[str, Any]] = {
    "as it is, outer ridges lower": {},
    "level crests": {"ridge": {"levelling": 1.0}},
    "softer, 0.3 MPa": {"material": {"young_modulus": 0.3}},
}
SLOW_AMPLIFIERS = ("transimpedance", "single-supply", "charge-amplifier", LONG)


def slow(case: str) -> Mark:
    """Return the score of a gentle lift, "seed/amplifier/skin": SLOW N come within 0.4 to 0.8 s."""
    seed, amplifier, name = case.split("/")
    draw = np.random.default_rng((64, int(seed)))
    design = load_design("yamada-2002").with_(**SLOW_SKINS[name])
    friction, first, rise, delay = (draw.uniform(*ends) for ends in (FRICTION, FIRST, (0.4, 0.8), DELAY))
    least = SLOW / friction
    grip = {
        "gripper": "plain-plate", "mass": 1e3 * FINGERS * SLOW / GRAVITY, "force": first * least,
        "delay": delay, "force_rate": 30.0, "force_max": STRONG * least, "rise": rise, "acceleration": 0.0,
        "policy": "detector",
    }  # fmt: skip
    scene = Scene(
        name="slow", skin=design, grip=grip, effects=effects(friction, amplifier, int(seed)),
        readout={"ridges": list(range(1, 10)), "bandwidth_Hz": BAND},
    )  # fmt: skip
    one = Lift(
        int(seed),
        Skin(f"yamada-2002, {name}", design, 4.0),
        "lift",
        friction,
        least,
        first,
        rise,
        amplifier,
        scene,
    )
    return judged(one, scene, amplifier, name)


HEAD = ("", "lifts", "held, slide < 1 mm", "held", "mean grip", "peak", "raises", "false", "slide mm, median")


def line(name: str, marks: Sequence[Mark]) -> tuple[object, ...]:
    """Return a table's line: shares with their intervals, grips over the least."""
    firm, held = sum(m.firm for m in marks), sum(m.held for m in marks)
    slides = [m.slide for m in marks if m.held]
    return (
        name, len(marks), percent(firm, len(marks)), percent(held, len(marks)), *(
            f"{np.mean([getattr(m, key) for m in marks]):.2f}" if marks else "-"
            for key in ("mean", "peak", "raises", "false")
        ), f"{np.median(slides):.2g}" if slides else "-",
    )  # fmt: skip


def percent(hits: int, count: int) -> str:
    """Return a share in % with its 95 % interval."""
    low, high = runner.wilson(hits, count)
    return f"{100 * hits / max(1, count):.0f} ({100 * low:.0f}-{100 * high:.0f})"


def told(title: str, rows: Sequence[tuple[object, ...]]) -> None:
    """Print a table."""
    print(f"\n{title}", *runner.table(HEAD, rows), sep="\n", flush=True)


def by(marks: Sequence[Mark]) -> list[tuple[object, ...]]:
    """Return lines by delay, rise, first grip, signal, amplifier and kind."""
    rows = []
    for key, edges in BINS.items():
        for low, high in pairwise(edges):
            some = [m for m in marks if low <= getattr(m, key) < high or getattr(m, key) == high == edges[-1]]
            rows += [line(f"{key} {low:g} to {high:g}", some)] if some else []
    for key in ("amplifier", "kind"):
        for value in sorted({getattr(m, key) for m in marks}):
            rows.append(line(f"{key} {value}", [m for m in marks if getattr(m, key) == value]))
    return rows


def main() -> None:
    options = runner.parser(__doc__)
    options.add_argument("--first", type=int, default=1, help="the first seed; odd ones are to judge on")
    options.add_argument("--count", type=int, default=300, help="lifts")
    options.add_argument("--what", choices=("policies", "links", "slow"), default="policies")
    every = ",".join(map(str, range(len(POLICIES))))
    options.add_argument("--policies", default=every, help="by their numbers, from 0")
    asked = options.parse_args()
    seeds = range(asked.first, asked.first + 2 * asked.count, 2)
    names = list(POLICIES)
    if asked.what == "slow":
        name = next(iter(SLOW_SKINS))
        which = [*((a, name) for a in SLOW_AMPLIFIERS), *(("transimpedance", n) for n in [*SLOW_SKINS][1:])]
    elif asked.what == "policies":
        which = [(names[int(i)], "as drawn") for i in asked.policies.split(",")]
    else:
        which = [(HEARS, link) for link in LINKS]
    skins = seeds if asked.what == "slow" else sorted(seeds, key=lambda seed: drawn(seed).skin.name)
    cases = [f"{seed}/{policy}/{link}" for seed in skins for policy, link in which]
    marks = runner.rows("lifts", slow if asked.what == "slow" else judge, cases, asked, kind=Mark)
    rows = [(p, k, [m for m in marks if (m.policy, m.link) == (p, k)]) for p, k in which]
    title = f"{len(seeds)} lifts, seeds {seeds[0]} to {seeds[-1]}"
    told(
        title,
        [line(p if k == "as drawn" else k if asked.what == "links" else f"{p}, {k}", m) for p, k, m in rows],
    )
    if asked.what == "slow":
        print(*(f"{p}, {k}: {np.median([x.signal for x in m]):.0f} dB" for p, k, m in rows if m), sep="\n")
    if asked.what == "policies":
        for policy, _ in which:
            if policy == HEARS:
                told(HEARS, by([m for m in marks if m.policy == HEARS]))


if __name__ == "__main__":
    main()
