"""Does a better model take a verdict back? Random designs, soft and slender ones too, judged by `auto` and by
the best model there is.

`python -m bench.verdicts 40 --seed 1000` draws 40 designs and prints the share of each outcome, the designs
whose verdict is taken back, and how wide `auto`'s errors are. The best model is pressed without friction,
which `auto` has in its error; with `--smooth` it is told too, so that its errors are those of what it
computes.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from functools import partial
from time import perf_counter

import numpy as np

import skincad
from bench import runner
from skincad.base import InputError, RefusedError
from skincad.inputs import Design
from skincad.mechanics import ContactCheck, is_decided, limits

BEST = "solid-finite-strain"
STRAINS = 0.02, 0.3  # nominal, of ridges that shared the force evenly
DRAWS = 200  # until the design's own rules let one pass


@dataclass(frozen=True)
class Comparison:
    """A seed's verdicts; forces and lengths in N and mm, None where a model has none."""

    seed: int
    model: str
    verdict: str
    best: str
    force: float
    needed: tuple[float | None, float | None]
    best_needed: tuple[float | None, float | None]
    approach: tuple[float | None, float | None]
    best_approach: tuple[float | None, float | None]
    seconds: tuple[float, float]
    said: str

    @property
    def taken_back(self) -> bool:
        """Whether the best model denies beyond its error what `auto` says."""
        return {self.verdict, self.best} == {"passes", "fails"} or (
            self.verdict == "passes" and self.best == "none"
        )


def drawn(seed: int) -> Design:
    """Return a seed's design: 3 to 9 ridges, upright or tapered, stubby to slender, soft to hard."""
    rng = np.random.default_rng([seed, 31])
    for _ in range(DRAWS):
        root, count = float(rng.uniform(0.4, 1.4)), int(rng.integers(3, 10))
        tip, height = root * float(rng.uniform(0.5, 1.0)), root * float(rng.uniform(0.4, 2.2))
        pitch = root + float(rng.uniform(0.3, 1.0))
        ridge = {"count": count, "pitch": pitch, "height": height, "root_width": root, "tip_width": tip}
        round_ = {"crown": 0.05 * tip, "tip_fillet": 0.06 * tip, "root_fillet": 0.08 * root}
        width = (count - 1) * pitch + root + 1.0
        skin = {
            "curvature_radius": width * float(np.exp(rng.uniform(np.log(1.5), np.log(30.0)))),
            "thickness": float(rng.uniform(1.5, 6.0)),
            "width": width,
            "length": float(rng.uniform(4.0, 20.0)),
        }
        soft = float(np.exp(rng.uniform(np.log(0.08), np.log(2.0))))
        material = {"name": None, "young_modulus": soft, "poisson_ratio": float(rng.choice([0.47, 0.499]))}
        strain = float(np.exp(rng.uniform(*np.log(STRAINS))))
        try:
            design = skincad.load("plain-ridges").with_(
                name=f"drawn-{seed}", skin=skin, ridge={**ridge, **round_}, material=material
            )
            return design.with_(contact={"force": strain * count * limits(design).squeeze})
        except InputError:
            continue
    raise ValueError(f"seed {seed}: no design in {DRAWS} draws")


def verdict(found: ContactCheck) -> str:
    """Return passes, fails, open (the error spans the force) or none (beyond the model's range)."""
    if found.out_of_range:
        return "none"
    if found.passed:
        return "passes"
    if found.all_touch_force.value is None:
        return "fails" if found.touching < found.ridges else "none"
    return "fails" if is_decided(found) else "open"


def judged(seed: int, friction: float | None = None) -> Comparison:
    """Return a seed's verdicts; `auto` is told this `friction`, the best model that there is none."""
    design, clock, said = drawn(seed), [perf_counter()], ""
    rows: list[ContactCheck | None] = []
    for model, told in (("auto", friction), (BEST, 0.0)):
        try:
            rows.append(skincad.check(design.with_(contact={"friction": told}), model=model))
            said += rows[-1].out_of_range if rows[-1] else ""
        except (InputError, RefusedError) as refusal:
            rows.append(None)
            said += f"{model}: {refusal} "
        clock.append(perf_counter())
    auto, best = rows

    def numbers(of: ContactCheck | None, name: str) -> tuple[float | None, float | None]:
        return (None, None) if of is None else (getattr(of, name).value, getattr(of, name).error)

    words = [verdict(of) if of else "none" for of in rows]
    return Comparison(
        seed,
        auto.model if auto else "",
        words[0],
        words[1],
        design.contact.force,
        numbers(auto, "all_touch_force"),
        numbers(best, "all_touch_force"),
        numbers(auto, "approach"),
        numbers(best, "approach"),
        (clock[1] - clock[0], clock[2] - clock[1]),
        said.strip(),
    )


def summary(rows: list[Comparison]) -> list[str]:
    outcomes = Counter((row.verdict, row.best) for row in rows)
    lines = [f"auto {ours:7} best {theirs:7} {n:4}" for (ours, theirs), n in sorted(outcomes.items())]
    lines += [
        f"taken back: seed {row.seed}, {row.model}: {row.verdict}, {BEST}: {row.best}; {row.said}"
        for row in rows
        if row.taken_back
    ]
    for name in ("needed", "approach"):
        pairs = [(getattr(row, name), getattr(row, f"best_{name}")) for row in rows]
        known = [(a, b) for a, b in pairs if None not in (*a, *b) and a[0] > 0]
        missed = [abs(a[0] - b[0]) for a, b in known]
        held = sum(m <= a[1] + b[1] for m, (a, b) in zip(missed, known, strict=True))
        wide = np.median([a[1] / m for m, (a, b) in zip(missed, known, strict=True) if m]) if known else 0.0
        lines.append(
            f"{name:9} within both errors in {held} of {len(known)}, auto's error {wide:.1f} times the miss"
        )
    return lines


def main() -> None:
    parser = runner.parser(__doc__, "count", seed=1000)
    parser.add_argument("--smooth", action="store_true", help="tell auto too that there is no friction")
    options = parser.parse_args()
    name, friction = ("verdicts-smooth", 0.0) if options.smooth else ("verdicts", None)
    seeds = range(options.seed, options.seed + options.count)
    rows = runner.rows(name, partial(judged, friction=friction), seeds, options, kind=Comparison)
    print("\n".join(summary(rows)))


if __name__ == "__main__":
    main()
