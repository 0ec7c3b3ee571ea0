"""Whether errors of faces, round faces and rings hold on random designs: of checks and of scenes.

`python -m bench.families 30 --seed 6200`: designs of these three kinds by turns, without friction pressed by
`linear` and by `finite-strain`, judged by the latter on a finer mesh; and pulled to gross slip in small
strain, judged on the finest mesh with half the steps. No constant was set on a random one.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

import skincad
from bench import runner
from skincad.base import Estimate
from skincad.inputs import Design
from skincad.mechanics import ContactCheck
from skincad.scenes import LEVELS, Scene, at_level

KINDS = "face", "round face", "rings"
FINER = 2e-3  # relative, of the judge's mesh
STEPS = 60


@dataclass(frozen=True)
class Held:
    """Of a seed: its kind, and by what is judged how many numbers lie within their errors, of how many."""

    seed: int
    kind: str
    held: dict[str, list[int]]


def drawn(seed: int) -> tuple[str, Design, float]:
    """Return a seed's kind, design and coefficient of friction."""
    rng, kind = np.random.default_rng([seed, 62]), KINDS[seed % len(KINDS)]
    thickness, width, radius = rng.uniform(2.0, 7.0), rng.uniform(14.0, 26.0), rng.uniform(40.0, 200.0)
    modulus, pitch = rng.uniform(0.1, 0.8), width / 8
    skin: dict[str, Any] = {"curvature_radius": radius, "thickness": thickness, "width": width}
    skin |= {"length": rng.uniform(12.0, 30.0)} if kind == "face" else {"outline": "round"}
    ring = {"count": 3, "pitch": pitch, "height": rng.uniform(0.4, 1.2), "crown": 0.05}
    ring |= {"root_width": 0.7 * pitch, "tip_width": 0.5 * pitch, "tip_fillet": 0.08, "root_fillet": 0.1}
    design = Design(
        name="drawn",
        skin=skin,
        material={"young_modulus": modulus, "poisson_ratio": 0.495},
        mold={"process": "sla"},
        contact={"force": modulus * rng.uniform(2.0, 9.0), "friction": 0.0},
        **({"ring": ring} if kind == "rings" else {"flat": {}}),
    )
    return kind, design, rng.uniform(0.2, 0.9)


def judged(seed: int) -> Held:
    """Return what holds of a seed; InputError where its design is refused."""
    kind, design, friction = drawn(seed)
    best = skincad.check(design, model="finite-strain", tol=FINER)
    held = {model: _within(skincad.check(design, model=model), best) for model in ("linear", "finite-strain")}
    force = design.contact.force

    def scene(steps: int) -> Scene:
        return Scene(
            name="drawn",
            skin=design,
            history={
                "steps": steps,
                "time_s": [0.0, 0.2, 1.0],
                "normal_force_N": [0.0, force, force],
                "tangential_force_N": [0.0, 0.0, 1.05 * friction * force],
            },
            effects={"friction": {"coefficient": friction}},
        )

    told, true = skincad.simulate(scene(STEPS), model="small_strain"), at_level(scene(2 * STEPS), LEVELS[-1])
    both = zip(told.slip_steps, true.slip_steps, told.slip_step_errors, strict=True)
    near = [abs(a - b / 2) <= e.numerical + 0.5 for a, b, e in both if a and b and e]
    steps = min(told.slip_share.size, true.slip_share[::2].size)
    off = float(np.abs(told.slip_share[:steps] - true.slip_share[::2][:steps]).mean())
    held |= {
        "slip steps": [sum(near), len(near)],
        "slip share": [int(off <= (told.slip_share_error or 0.0)), 1],
    }
    return Held(seed, kind, held)


def _within(told: ContactCheck, best: ContactCheck) -> list[int]:
    """How many of a check's numbers lie within their errors, and the best's, of how many."""
    pairs: list[tuple[Estimate, Estimate]] = [(told.approach, best.approach)]
    if told.ridges > 1:
        pairs += [
            (told.all_touch_force, best.all_touch_force),
            *zip(told.ridge_force, best.ridge_force, strict=True),
        ]
    near = [
        abs((a.value or 0.0) - (b.value or 0.0)) <= (a.error or 0.0) + (b.error or 0.0)
        for a, b in pairs
        if a.value is not None and b.value is not None
    ]
    return [sum(near), len(near)]


def summary(cases: list[Held]) -> list[str]:
    """Return the table: what is judged, by kind."""
    lines = []
    for what in cases[0].held if cases else ():
        sums = [np.sum([case.held[what] for case in cases if case.kind == kind], axis=0) for kind in KINDS]
        lines.append((what, *(runner.share(int(s[0]), int(s[1])) if np.size(s) == 2 else "" for s in sums)))
    return runner.table(("within their errors", *KINDS), lines)


def main() -> None:
    """Print the table."""
    options = runner.parser(__doc__, "count", seed=6200).parse_args()
    seeds = range(options.seed, options.seed + options.count)
    print("\n".join(summary(runner.rows("families", judged, seeds, options, kind=Held))))


if __name__ == "__main__":
    main()
