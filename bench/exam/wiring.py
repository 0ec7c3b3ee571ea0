"""Which two ridges to wire, where there are four channels: what each choice's warnings are worth.

`python -m bench.exam.wiring [FOLDER] [--first SEED] [--count N]` (default out/wiring, odd seeds from 6001 on,
behind the exam's) marches scenes. Over SEEDS of noise, behind CIRCUIT, it prints the warnings of gross slip
by `wire_first` of a check, by other pairs, by pairs at random, and by all ridges. An even first seed takes
scenes of the design set, on which the rule was chosen.
"""

from __future__ import annotations

import argparse
from itertools import combinations
from pathlib import Path

from threadpoolctl import threadpool_limits

import skincad
from bench.exam.__main__ import FEWEST, SEEDS, marks, warnings
from bench.exam.scenes import Skin, kept
from bench.exam.scoring import HEAD, case, line
from skincad.scenes import POINTS

CIRCUIT = "transimpedance"
FEWEST_RIDGES = 3  # of which two are a choice
Pairs = list[tuple[int, ...]]


def first_two(skin: Skin) -> tuple[int, ...]:
    """Return the two ridges that a check says to wire first, in order, of a skin at its force."""
    wired = skincad.check(skin.design, force=skin.force, model="linear", tol=0.05).wire_first
    return tuple(sorted(wired[:2]))


def choices(skin: Skin) -> dict[str, Pairs]:
    """Return ridges by the name of a choice; several pairs count as one choice at random."""
    n = skin.design.ridge.count
    every: Pairs = list(combinations(range(1, n + 1), 2))
    return {
        "wire_first": [first_two(skin)],
        "any two": every,
        "any two neighbours": [(i, i + 1) for i in range(1, n)],
        "the outermost two": [(1, n)],
        "two at one side": [(1, 2), (n - 1, n)],
        "2 and 3, the paper's": [(2, 3), (n - 2, n - 1)],
        "all": [tuple(range(1, n + 1))],
    }


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", nargs="?", type=Path, default=Path("out/wiring"))
    parser.add_argument("--first", type=int, default=6001, help="the first seed")
    parser.add_argument("--count", type=int, default=100, help="scenes")
    options = parser.parse_args()
    scenes = [kept(seed, options.folder / "scenes") for seed in numbers(options.first, options.count)]
    scenes = [s for s in scenes if s.time.size > FEWEST and s.slipping.shape[1] >= FEWEST_RIDGES]
    slips = sum(scene.gross is not None for scene in scenes)
    print(f"seeds from {options.first}: {len(scenes)} scenes, {slips} slip; behind {CIRCUIT}\n{HEAD}")
    cases = [case(scene, CIRCUIT, options.folder / "outputs") for scene in scenes]
    by_skin = {scene.skin.name: choices(scene.skin) for scene in scenes}
    for name in next(iter(by_skin.values())):
        told = [one.told(pair) for one in cases for pair in by_skin[one.scene.skin.name][name]]
        for kind in POINTS:
            print(line(f"{name}: {kind}", marks(told, warnings(kind), SEEDS)), flush=True)


def numbers(first: int, count: int) -> range:
    """Return every second number."""
    return range(first, first + 2 * count, 2)


if __name__ == "__main__":
    with threadpool_limits(limits=1, user_api="blas"):
        main()
