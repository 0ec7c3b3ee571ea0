"""What leaving an effect out is said to change, against what it changes.

`python -m bench.left_out 2 20`: 20 random scenes of seed 2 (bench/random_scenes.py), each marched with and
without film, free ends and masses (the skin's, and a plate as heavy, with viscosity as without it) on one
coarse mesh, some five minutes on a core; or with the effects that are named after that. A line a scene, said
/ found; then how many lie within a factor of two, and within the factor that the estimate itself names.

`python -m bench.left_out 2 20 finite_strain`: scenes that pull to 0.95 of friction, in small and in finite
strain on one mesh, up to a minute each. Besides, Pcr of their ridges, from how much steeper the difference
rises with the pull, against effects/finite_strain.py.
"""

from __future__ import annotations

import itertools
from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from bench import runner
from bench.random_scenes import PULLED_FROM, pulled_scene, random_scene
from skincad.base import Array, InputError
from skincad.effects import FiniteStrain, SmallStrain, sway_force
from skincad.mechanics import Drive, default_sizes, piece_of, skin_mass, triangles
from skincad.scenes import LEVELS, March, MarchSetup, Scene, left_out_effects, march_on, path_of, piece_for
from skincad.scenes.march import march
from skincad.shape import skin_of

EFFECTS = ("film", "free_ends", "inertia")
QUASI_STATIC = 60  # steps of a march without masses, which does not see time
FINENESS, ORDER = 0.25, 2  # of marches with masses
STRAIN_FINENESS = 0.3  # of those in small and in finite strain
STEADY = 0.04  # spread of a ridge's normal force and of its slope: beyond it no Pcr is read off
RAISED = 1.05  # least gain of a slope from which Pcr is read off


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
    return _held_to(effect, without, left, change(path_of(left).felt, path_of(named).felt))


def _held_to(effect: str, without: Scene, left: March, found: float) -> Compared:
    entry = next(entry for entry in left_out_effects(without, path_of(left)) if entry.effect == effect)
    assert entry.within is not None
    return Compared(effect, entry.change, entry.within, found)


def change(without: Array, named: Array) -> float:
    """Return the largest change of `(n, ridges)` MPa where both marches got to, by the largest without."""
    end = min(len(without), len(named))
    return float(np.abs(named[:end] - without[:end]).max() / np.abs(without[:end]).max())


def _graded(scene: Scene) -> March:
    """Return the scene's march on its own coarsest mesh, fine at the strips' ends."""
    return march_on(LEVELS[0], MarchSetup(scene, piece_for(scene, {})))


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


@dataclass(frozen=True)
class Forces:
    """By step and ridge: normal and tangential forces, N, and S1 - S2, MPa; and the march."""

    normal: Array
    tangential: Array
    difference: Array
    march: March


def both(scene: Scene) -> tuple[Forces, Forces]:
    """Return the scene marched in small and in finite strain, on the same mesh of the whole pad."""
    piece = piece_for(scene, {})
    piece = piece_of(piece.whole, piece.thickness, halved=False)
    mesh = triangles(piece.pad, default_sizes(piece.pad, STRAIN_FINENESS))
    times, drives = scene.history.times, scene.history.drives()
    small, large = (
        _forces(law.marched(piece, mesh, ORDER, True, scene.terms), times, drives, scene)
        for law in (SmallStrain(), FiniteStrain())
    )
    return small, large


def _forces(pad: Any, times: Array, drives: list[Drive], scene: Scene) -> Forces:
    run = march(pad, times, drives, scene.terms, keep=range(len(drives)))
    grips = [run.states[i].contact for i in range(len(run.readings))]
    first, count = int(run.ridge.min()), int(np.ptp(run.ridge)) + 1
    normal, across = (
        np.array([np.bincount(run.ridge - first, force, count) for force in forces])
        for forces in ([g.normal for g in grips], [g.tangential for g in grips])
    )
    films = run.column("films")[:, :, 0]
    return Forces(normal, across, films[:, ::2] - films[:, 1::2], run)


def critical(small: Forces, large: Forces, ridge: int) -> float | None:
    """Return Pcr of a ridge, N, by how much steeper the difference rises with its pull; None where its
    normal force or the slope changes on the way."""
    end, slopes = min(len(small.difference), len(large.difference)), list[float]()
    for each in (small, large):
        normal, pull = each.normal[PULLED_FROM:end, ridge], each.tangential[PULLED_FROM:end, ridge]
        difference = each.difference[PULLED_FROM:end, ridge]
        if np.ptp(pull) < 1e-3 * normal.max() or normal.std() > STEADY * normal.mean():
            return None
        line = np.polynomial.Polynomial.fit(pull, difference, 1)
        if np.abs(line(pull) - difference).max() > STEADY * np.ptp(difference):
            return None
        slopes.append(float(line.convert().coef[1]))
    gain = slopes[1] / slopes[0]
    return None if gain < RAISED else float(large.normal[PULLED_FROM:end, ridge].mean()) / (1 - 1 / gain)


def finite_strain(seed: int, count: int) -> list[Compared]:
    """Print what finite strain changes in random scenes, and Pcr; return the rows."""
    rng, rows, forces = np.random.default_rng(seed), list[Compared](), list[float]()

    def pair(_: int) -> tuple[Scene, tuple[Forces, Forces]]:
        scene = pulled_scene(rng)
        return scene, both(scene)

    for scene, (small, large) in runner.until(count, pair):
        found = change(small.difference, large.difference)
        rows.append(_held_to("finite_strain", scene, small.march, found))
        ratios = [
            answer / sway_force(scene.design, float(large.normal[-1, ridge]))
            for ridge in range(scene.design.ridge.count)
            if (answer := critical(small, large, ridge))
        ]
        forces += [float(np.median(ratios))] if ratios else []
        last = f", Pcr found over stated {forces[-1]:.2f}" if ratios else ""
        words = f"changes by {found:.2f}, said {rows[-1].said:.2f}{last}"
        print(f"{words}; {large.march.stopped or ''}", flush=True)
    if forces:
        spread = f"{min(forces):.2f} to {max(forces):.2f}, median {np.median(forces):.2f}"
        print(f"Pcr found over stated {spread}")
    return rows


def others(seed: int, count: int, effects: Sequence[str]) -> dict[str, list[Compared]]:
    """Print what these effects change in random scenes; return the rows."""
    rows: dict[str, list[Compared]] = defaultdict(list)
    for number, scene in enumerate(scenes(seed, count) if effects else (), 1):
        history = scene.history
        told = [f"{number:3} {skin_of(scene.design).count} ridges, {history.time_s[-1]:7.2g} s"]
        told += ["driven"] * (history.tangential_force_N is None)
        for effect in effects:
            row = compared(scene, effect)
            rows[effect].append(row)
            missed = "" if row.off <= row.within else f" (stated: within {row.within:g})"
            told.append(f"{row.effect} {row.said:.3f} / {row.found:.3f}{missed}")
        print("; ".join(told), flush=True)
    return rows


def main() -> None:
    parser = runner.parser(__doc__, "seed", "count", recorded=False)
    parser.add_argument("effects", nargs="*", default=EFFECTS)
    options = parser.parse_args()
    effects = [effect for effect in options.effects if effect != "finite_strain"]
    with threadpool_limits(limits=1, user_api="blas"):
        rows = others(options.seed, options.count, effects)
        if "finite_strain" in options.effects:
            rows["finite_strain"] = finite_strain(options.seed, options.count)
    for effect, compared_rows in rows.items():
        print(f"{effect}: {held(compared_rows)}")


if __name__ == "__main__":
    main()
