"""Random valid sections without a mold, by rule: `python -m bench.table_molds [count]`.

Sections are drawn far wider than by random_designs, and nothing of the mold but its process is
given: what is refused here is refused by a value that nobody wrote. No CAD kernel, no finite elements.
"""

from __future__ import annotations

import re
import sys
import time
from collections import Counter, defaultdict
from collections.abc import Iterator
from typing import Any

import numpy as np

from bench.campaign.random_designs import Dice
from skincad.base import InputError
from skincad.inputs import PROCESSES, Design, silicones
from skincad.shape import section
from skincad.solids.mold import mold

COUNT = 2000


def sections(count: int, seed: int = 0) -> Iterator[Design]:
    """Yield designs whose section is one, their molds at the defaults of all keys but the process."""
    dice, found = Dice(np.random.default_rng(seed)), 0
    while found < count:
        try:
            design = Design(name=f"section-{found}", **tables(dice))
            section(design)
        except InputError:
            continue
        found += 1
        yield design


def tables(dice: Dice) -> dict[str, Any]:
    """Return a design's tables, each length over its own decades."""
    skin = {
        "curvature_radius": dice.scale(5.0, 1e5),
        "thickness": dice.scale(0.5, 45.0),
        "width": dice.scale(3.0, 200.0),
        "length": dice.scale(3.0, 200.0),
    }
    ridge = _ridge(dice, skin["width"])
    table = {
        "skin": skin,
        "ridge": ridge,
        "material": {"name": dice.one(silicones())},
        "mold": {"process": dice.one(PROCESSES)},
    }
    if dice.happens(0.5):
        table["slot"] = _slot(dice, ridge)
        if dice.happens(0.5):
            table["film"] = {
                "thickness": table["slot"]["thickness"] * dice.over(0.2, 1.0),
                "electrode_margin": 0.0,
            }
    return table


def _ridge(dice: Dice, width: float) -> dict[str, Any]:
    """Ridges that fill a third of the width or more, as a relief is meant."""
    count = round(dice.scale(1.0, 40.0))
    pitch = min(100.0, width / count * dice.over(0.3, 1.0))
    root = pitch * dice.over(0.2, 0.99)
    tip = root * dice.over(0.2, 1.0)
    height = min(50.0, pitch * dice.scale(0.05, 1.5))
    most = min(height, tip / 2)
    return {
        "count": count,
        "pitch": pitch,
        "root_width": root,
        "tip_width": tip,
        "height": height,
        "crown": min(10.0, 0.0 if dice.happens(0.2) else most * dice.scale(0.01, 0.9)),
        "tip_fillet": 0.0 if dice.happens(0.2) else most * dice.scale(0.01, 0.8),
        "root_fillet": 0.0 if dice.happens(0.2) else min(pitch - root, height) * dice.scale(0.01, 0.8),
    }


def _slot(dice: Dice, ridge: dict[str, Any]) -> dict[str, Any]:
    return {
        "thickness": max(0.006, ridge["tip_width"] * dice.scale(0.01, 0.2)),
        "depth": max(0.02, ridge["height"] * dice.over(0.1, 0.9)),
        "offset": ridge["tip_width"] * dice.over(0.1, 0.45),
        "elevation": ridge["height"] * dice.over(-0.4, 0.6),
        "tilt": 0.0 if dice.happens(0.5) else dice.over(-30.0, 45.0),
    }


def refusals(designs: Iterator[Design]) -> list[tuple[Design, InputError]]:
    rows = []
    for design in designs:
        try:
            mold(design)
        except InputError as refused:
            rows.append((design, refused))
    return rows


def main() -> None:
    count, start = int(sys.argv[1]) if len(sys.argv) > 1 else COUNT, time.perf_counter()
    answer = refusals(sections(count))
    rules: dict[str, list[str]] = defaultdict(list)
    for _, refused in answer:
        rules[re.sub(r"-?\d[\d.e+-]*", "#", f"{refused.key}: {refused.rule}")].append(str(refused))
    print(f"{len(answer)} of {count} valid sections have no mold ({len(answer) / count:.1%})")
    for examples in sorted(rules.values(), key=len, reverse=True):
        print(f"{len(examples):6}  {examples[0]}")
    keys = Counter(refused.key for _, refused in answer)
    print("by key: " + ", ".join(f"{key} {n}" for key, n in keys.most_common()))
    print(f"{time.perf_counter() - start:.1f} s")


if __name__ == "__main__":
    main()
