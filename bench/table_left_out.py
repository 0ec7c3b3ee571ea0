"""What leaving an effect out is said to change, against what it changes: film, free ends, masses.

`python -m bench.table_left_out 2 20`: 20 random scenes of seed 2 (bench/random_scenes.py), each marched with
and without each effect on one coarse mesh: some five minutes on a core. Names of effects after that take
these alone. A line a scene, said / found; then how many of them lie within a factor of two, and within the
factor that the estimate itself names, with the 95 % interval.

Masses are those of the skin and of a plate as heavy, with viscosity as without it. Finite strain
has a bench of its own, table_swaying.py; friction and viscosity say nothing of themselves.
"""

from __future__ import annotations

import itertools
from collections import Counter, defaultdict
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from bench import runner
from bench.random_scenes import random_scene
from skincad.base import Array, InputError
from skincad.mechanics import default_sizes, skin_mass, triangles
from skincad.scenes import LEVELS, March, MarchSetup, Scene, left_out_effects, march_on, path_of, piece_for
from skincad.scenes.march import march
from skincad.shape import skin_of

EFFECTS = ("film", "free_ends", "inertia")
QUASI_STATIC = 60  # steps of a march without masses, which does not see time
FINENESS, ORDER = 0.25, 2  # of marches with masses


@dataclass(frozen=True)
class Compared:
    """An effect's change as `said`, to a factor of `within`, and as `found`."""

    effect: str
    said: float
    within: float
    found: float

    @property
    def off(self) -> float:
        """By what factor the one is larger than the other."""
        return max(self.said / self.found, self.found / self.said)


def compared(scene: Scene, effect: str) -> Compared:
    """Return what an effect changes in a scene; masses in the scene as it is, the others without time."""
    scene = scene.with_(effects={"small_strain": {"masses": False}})
    if effect == "inertia":
        return _one(effect, scene, _coarse(scene), _coarse(with_masses(scene)))
    still = scene.with_(history={"steps": QUASI_STATIC})
    without = still.with_(effects={effect: None})
    return _one(effect, without, _graded(without), _graded(still.with_(effects={effect: {}})))


def with_masses(scene: Scene) -> Scene:
    """Return a scene under a plate as heavy as its skin."""
    mass = float(f"{skin_mass(scene.design):.6g}")
    return scene.with_(plate={"mass": mass}, effects={"inertia": {}, "viscosity": {}})


def _one(effect: str, without: Scene, left: March, named: March) -> Compared:
    entry = next(entry for entry in left_out_effects(without, left) if entry.effect == effect)
    assert entry.within is not None
    return Compared(effect, entry.change, entry.within, change(felt(left), felt(named)))


def felt(found: March) -> Array:
    """Return S1 - S2 `(steps + 1, ridges)` MPa."""
    return path_of(found).felt


def change(without: Array, named: Array) -> float:
    """Return the largest change of `(n, ridges)` MPa where both marches got to, by the largest without."""
    end = min(len(without), len(named))
    return float(np.abs(named[:end] - without[:end]).max() / np.abs(without[:end]).max())


def _graded(scene: Scene) -> March:
    """Return the scene's march on its own coarsest mesh, fine at the strips' ends."""
    return march_on(LEVELS[0], MarchSetup(scene, piece_for(scene, {})), {})


def _coarse(scene: Scene) -> March:
    """Return the scene's march on a mesh for masses."""
    piece = piece_for(scene, {})
    mesh = triangles(piece.pad, default_sizes(piece.pad, FINENESS))
    pad: Any = scene.law.marched(piece, mesh, ORDER, True, scene.terms)
    times, drives, ends = scene.history.times, scene.history.drives(), scene.law.limits(scene.design)
    return march(pad, times, drives, scene.terms, mass=scene.plate.mass or 0.0, limits=ends)


def scenes(seed: int, count: int) -> Iterator[Scene]:
    """Yield the first random scenes of a seed whose skins can be."""
    draws = itertools.count()
    for _ in range(count):
        scene = None
        while scene is None:
            with suppress(InputError):
                scene = random_scene(np.random.default_rng((seed, next(draws))))
        yield scene


def held(rows: list[Compared]) -> str:
    """Return how many lie within a factor of two, and within the one that is stated."""
    told = []
    for name, factors in (("2", [2.0] * len(rows)), ("its own", [row.within for row in rows])):
        hits = sum(row.off <= factor for row, factor in zip(rows, factors, strict=True))
        told.append(f"within {name} in {runner.share(hits, len(rows))}")
    parts = np.array([row.said / row.found for row in rows])
    spread = f"{parts.min():.2f} to {parts.max():.2f}, median {np.median(parts):.2f}"
    own = ", ".join(f"{f:g} {n} times" for f, n in sorted(Counter(row.within for row in rows).items()))
    return f"said over found {spread}; {'; '.join(told)}, which is {own}"


def main() -> None:
    parser = runner.parser(__doc__, "seed", "count", recorded=False)
    parser.add_argument("effects", nargs="*", default=EFFECTS)
    options = parser.parse_args()
    rows: dict[str, list[Compared]] = defaultdict(list)
    with threadpool_limits(limits=1, user_api="blas"):
        for number, scene in enumerate(scenes(options.seed, options.count), 1):
            design, history = scene.design, scene.history
            told = [f"{number:3} {skin_of(design).count} ridges, {history.time_s[-1]:7.2g} s"]
            told += ["driven"] * (history.tangential_force_N is None)
            for effect in options.effects:
                row = compared(scene, effect)
                rows[effect].append(row)
                missed = "" if row.off <= row.within else f" (stated: within {row.within:g})"
                told.append(f"{row.effect} {row.said:.3f} / {row.found:.3f}{missed}")
            print("; ".join(told), flush=True)
    for effect, each in rows.items():
        print(f"{effect}: {held(each)}")


if __name__ == "__main__":
    main()
