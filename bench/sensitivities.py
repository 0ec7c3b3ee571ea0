"""Whether the intervals of the all-touch force's exponents hold the linear model's.

`python -m bench.sensitivities [SEED ...]`: of all templates, or of random designs; a row for each design and
key, and how many of each key lie inside. Differences are 3 % each way, of the linear model at its finest
tolerance that check asks for.
"""

from __future__ import annotations

import math
import sys

import skincad
from bench.campaign.random_designs import drawn
from skincad.base import InputError, RefusedError
from skincad.inputs import Design
from skincad.mechanics import KEYS, Request, intervals
from skincad.mechanics.models import linear
from skincad.mechanics.models.winkler import all_touch_force

BY, FINEST = 0.03, 5e-3


def exponent(design: Design, key: str) -> float | None:
    """The exponent by the linear model; None where the key is not given, or a guard or the model refuses."""
    table, _, name = key.partition(".")
    now = getattr(getattr(design, table), name)
    ends = []
    for by in (1 - BY, 1 + BY) if now else ():
        try:
            changed = design.with_(**{table: {name: now * by}})
            force = linear.answer(changed, Request(design.contact.force, FINEST)).all_touch_force.value
        except (InputError, RefusedError):
            return None
        if not force:
            return None
        ends.append((math.log(by), math.log(force)))
    if not ends:
        return None
    (low, first), (high, last) = ends
    return (last - first) / (high - low)


def main(seeds: list[int]) -> None:
    """Print the rows and how many lie inside."""
    names = [f"seed {seed}" for seed in seeds] or skincad.template_names()
    designs = [drawn(seed).design for seed in seeds] or [skincad.load(name) for name in names]
    inside: dict[str, list[bool]] = {key: [] for key in KEYS}
    for name, design in zip(names, designs, strict=True):
        stated = intervals(design, all_touch_force(design))
        for key in stated.keys() & {*KEYS}:
            if (answer := exponent(design, key)) is not None:
                low, high = stated[key]
                inside[key].append(low <= answer <= high)
                told = "" if inside[key][-1] else "  OUTSIDE"
                print(f"{name:20} {key:24} {low:6.2f} to {high:6.2f}: {answer:6.2f}{told}", flush=True)
    for key, each in inside.items():
        print(f"{key:24} {sum(each)} of {len(each)} inside")


if __name__ == "__main__":
    main([int(seed) for seed in sys.argv[1:]])
