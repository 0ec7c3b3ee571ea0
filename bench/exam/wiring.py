"""Which two ridges to wire, where there are four channels: what each choice's warnings are worth.

`python -m bench.exam.wiring [FOLDER] [--first SEED] [--count N]` (default out/wiring, odd seeds from 6001 on,
behind the exam's) marches scenes. Over SEEDS of noise, behind CIRCUIT, it prints the warnings of gross slip
by `wire_first` of a check, by other pairs, by pairs at random, and by all ridges. An even first seed takes
scenes of the design set, on which the rule was chosen.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

import skincad
from bench.exam.__main__ import FEWEST, SEEDS, marks, warnings
from bench.exam.scenes import SceneRun, Skin, kept
from bench.exam.scoring import HEAD, case, line
from skincad.scenes import POINTS

CIRCUIT = "transimpedance"
FEWEST_RIDGES = 3  # of which two are a choice
ANY = 8  # pairs at random of each scene
Pairs = list[tuple[int, ...]]


def first_two(skin: Skin) -> tuple[int, ...]:
    """Return the two ridges that a check says to wire first, in order, of a skin at its force."""
    wired = skincad.check(skin.design, force=skin.force, model="linear", tol=0.05).wire_first
    return tuple(sorted(wired[:2]))


def choices(scene: SceneRun, first: tuple[int, ...]) -> dict[str, Pairs]:
    """Return ridges by the name of a choice, as many in each scene; `first` are those to wire first."""
    n, draw = scene.slipping.shape[1], np.random.default_rng(scene.seed)
    return {
        "wire_first": [first],
        "any two": [tuple(sorted((draw.permutation(n)[:2] + 1).tolist())) for _ in range(ANY)],
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
    skins = {scene.skin.name: scene.skin for scene in scenes}
    first = {name: first_two(skin) for name, skin in skins.items()}
    by_scene = [choices(scene, first[scene.skin.name]) for scene in scenes]
    for name in by_scene[0]:
        told = [one.told(pair) for one, pairs in zip(cases, by_scene, strict=True) for pair in pairs[name]]
        for kind in POINTS:
            print(line(f"{name}: {kind}", marks(told, warnings(kind), SEEDS)), flush=True)


def numbers(first: int, count: int) -> range:
    """Return every second number."""
    return range(first, first + 2 * count, 2)


if __name__ == "__main__":
    with threadpool_limits(limits=1, user_api="blas"):
        main()
