"""Which information the films lack: networks that are told friction, the plate's forces, or both.

`python -m bench.exam.missing FOLDER` fits the network that warns of gross slip to two thirds of the design
set in turn, with what it is told as a feature of every ridge. It prints what its warnings are worth on the
rest, as drawn: without more, with friction, with the pull over the normal force, and with that over friction.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from bench.exam.fitting import FEWEST, FOLDS, Heard, alarms, odds, of_skins, variants
from bench.exam.network import fitted
from bench.exam.scenes import kept, seeds
from bench.exam.scoring import HEAD, line, mark
from bench.exam.skins import DESIGN
from skincad.scenes import BACK, SEEN

TOLD = "nothing", "friction", "forces", "both"
LEVELS = 1.0, 2.0, 3.0
LIGHT, MOST = 1e-3, 2.0  # of the largest normal force, below which the pull is over that; of what is told


def told(h: Heard, what: str) -> Heard:
    """Return what is heard, with more features."""
    scene, (count, ridges, _) = h.case.scene, h.felt.shape
    normal = np.maximum(scene.normal[:count], LIGHT * scene.normal.max())
    pull = np.abs(scene.tangential[:count]) / normal
    more = {"friction": np.full(count, scene.friction), "forces": pull, "both": pull / scene.friction}
    if what not in more:
        return h
    column = np.minimum(more[what], MOST).astype(np.float32)
    return replace(h, felt=np.concatenate([h.felt, np.repeat(column[:, None, None], ridges, 1)], axis=2))


def main(folder: Path) -> None:
    answer = [kept(seed, folder / "scenes") for seed in seeds(DESIGN)]
    rows = [list(variants(m, folder / "outputs")) for m in answer if m.time.size >= FEWEST]
    print(f"{len(rows)} scenes\n{HEAD}")
    for what in TOLD:
        marks = {level: [] for level in LEVELS}  # type: ignore[var-annotated]
        for fold in range(FOLDS):
            mine = [told(h, what) for i, row in enumerate(rows) if i % FOLDS != fold for h in row]
            network = fitted(of_skins(mine, records=False), fold)
            for row in rows[fold::FOLDS]:
                h = told(row[0], what)
                values = odds(network, h.felt).mean(axis=1)
                values = np.where((h.loud > SEEN).any(axis=1), values, -np.inf)[:, None]
                for level, each in marks.items():
                    each.append(mark(h.case, alarms(values, level, BACK, skin=True), h.window))
        for level, each in marks.items():
            print(line(f"{what} told, threshold {level:g}", each), flush=True)


if __name__ == "__main__":
    with threadpool_limits(limits=1, user_api="blas"):
        main(Path(sys.argv[1]))
