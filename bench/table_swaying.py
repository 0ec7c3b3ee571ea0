"""What leaving out finite strain is said to change, against what it changes.

`python -m bench.table_swaying 2 20`: random scenes of seed 2, 20 of them. Three to seven ridges are pressed
to a nominal strain of 0.02 to 0.13 and pulled to 0.95 of friction at 0.15 to 0.6, films bonded or silicone in
their place, in small and in finite strain on one mesh: ten seconds to a minute a scene. Besides, Pcr of its
ridges, from how much steeper the difference rises with the pull, against mechanics/left_out.py.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from bench import runner
from bench.random_scenes import between, random_skin
from skincad.base import Array
from skincad.effects import FiniteStrain, SmallStrain
from skincad.mechanics import Drive, default_sizes, piece_of, sway_force, triangles
from skincad.scenes import March, Scene, left_out_effects, load_scene, piece_for
from skincad.scenes.march import march

FINENESS, ORDER = 0.3, 2
PRESSED, STEPS = 4, 10  # of which the first press
STEADY = 0.04  # spread of a ridge's normal force and of its slope: beyond it no Pcr is read off
RAISED = 1.05  # least gain of a slope from which Pcr is read off


@dataclass(frozen=True)
class Forces:
    """By step and ridge: normal and tangential forces, N, and S1 - S2, MPa; and the march."""

    normal: Array
    tangential: Array
    difference: Array
    march: March


def drawn(rng: np.random.Generator) -> Scene:
    """Return a random scene; InputError where its skin cannot be."""
    design, normal = random_skin(rng)
    friction = round(between(rng, 0.15, 0.6), 4)
    changes = [
        f"history.steps={STEPS}",
        f"history.time_s=[0.0, {PRESSED / 1000}, {STEPS / 1000}]",
        f"history.normal_force_N=[0.0, {normal}, {normal}]",
        f"history.tangential_force_N=[0.0, 0.0, {0.95 * friction * normal}]",
        f"effects.friction.coefficient={friction}",
        "readout.ridges=[3]",
        *([] if rng.random() < 0.5 else ["effects.film=none"]),
    ]
    return load_scene("yamada-2002-slip", changes, skin=design)


def both(scene: Scene) -> tuple[Forces, Forces]:
    """Return the scene marched in small and in finite strain, on the same mesh of the whole pad."""
    piece = piece_for(scene, {})
    piece = piece_of(piece.whole, piece.thickness, halved=False)
    mesh = triangles(piece.pad, default_sizes(piece.pad, FINENESS))
    times, drives = scene.history.times, scene.history.drives()
    small, large = (
        _marched(law.marched(piece, mesh, ORDER, True, scene.terms), times, drives, scene)
        for law in (SmallStrain(), FiniteStrain())
    )
    return small, large


def _marched(pad: Any, times: Array, drives: list[Drive], scene: Scene) -> Forces:
    run = march(pad, times, drives, scene.terms, keep=range(len(drives)))
    grips = [pad.grip(run.states[i]) for i in range(len(run.readings))]
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
        normal, pull = each.normal[PRESSED:end, ridge], each.tangential[PRESSED:end, ridge]
        difference = each.difference[PRESSED:end, ridge]
        if np.ptp(pull) < 1e-3 * normal.max() or normal.std() > STEADY * normal.mean():
            return None
        line = np.polynomial.Polynomial.fit(pull, difference, 1)
        if np.abs(line(pull) - difference).max() > STEADY * np.ptp(difference):
            return None
        slopes.append(float(line.convert().coef[1]))
    gain = slopes[1] / slopes[0]
    return None if gain < RAISED else float(large.normal[PRESSED:end, ridge].mean()) / (1 - 1 / gain)


def main() -> None:
    options = runner.parser(__doc__, "seed", "count", recorded=False).parse_args()
    rng, parts, forces = np.random.default_rng(options.seed), list[float](), list[float]()

    def pair(_: int) -> tuple[Scene, tuple[Forces, Forces]]:
        scene = drawn(rng)
        return scene, both(scene)

    for scene, (small, large) in runner.until(options.count, pair):
        end = min(len(small.difference), len(large.difference))
        there, here = large.difference[:end], small.difference[:end]
        change = float(np.abs(there - here).max() / np.abs(here).max())
        said = next(
            entry for entry in left_out_effects(scene, small.march) if entry.effect == "finite_strain"
        ).change
        ratios = [
            answer / sway_force(scene.design, float(large.normal[-1, ridge]))
            for ridge in range(scene.design.ridge.count)
            if (answer := critical(small, large, ridge))
        ]
        parts.append(said / change)
        forces += [float(np.median(ratios))] if ratios else []
        last = f", Pcr found over stated {forces[-1]:.2f}" if ratios else ""
        print(f"changes by {change:.2f}, said {said:.2f}{last}; {large.march.stopped or ''}", flush=True)
    held = sum(0.5 <= part <= 2 for part in parts)
    spread = f"{min(parts):.2f} to {max(parts):.2f}"
    print(f"said over found {spread}, within a factor of two in {runner.share(held, len(parts))}")
    print(f"Pcr found over stated {min(forces):.2f} to {max(forces):.2f}, median {np.median(forces):.2f}")


if __name__ == "__main__":
    main()
