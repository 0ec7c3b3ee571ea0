"""Crest heights of a cast part, as measured, against the design's."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from skincad.base.columns import read_columns
from skincad.base.errors import InputError
from skincad.inputs.design import Design
from skincad.shape.skin import skin_of

# of the skin's thickness; the all-touch force goes with its power -0.65, so this changes it by 1.3 %
MOST_SHIFT = 0.02


def crest_drops(path: Path | str, design: Design) -> tuple[tuple[float, ...], tuple[str, ...]]:
    """Return by how much each crest of a measured part lies lower than designed, mm, ridge 1 first, and how
    the file was read.

    Columns `ridge` and `crest_mm`: the summit's height over the flat back, every ridge once.
    """
    columns = read_columns(path, ("ridge", "crest_mm"))
    skin = skin_of(design)
    count, ridges = skin.count, columns["ridge"]
    if sorted(ridges.tolist()) != list(range(1, count + 1)):
        raise InputError(str(path), f"must give crest_mm of each ridge from 1 to {count} once")
    measured = dict(zip(ridges.astype(int).tolist(), columns["crest_mm"].tolist(), strict=True))
    designed = skin.crests
    drops = tuple(designed[i] - measured[i + 1] for i in range(count))
    heights, key = skin.heights, "heights" if skin.uneven else "height"
    worst = max(range(count), key=lambda i: abs(drops[i]) - heights[i])
    if abs(drops[worst]) > heights[worst]:
        raise InputError(
            f"{path}, ridge {worst + 1}",
            f"must be within {heights[worst]:g} mm (ridge.{key}) of the designed "
            f"{designed[worst]:.4g} mm above the back",
            measured[worst + 1],
        )
    return drops, columns.notes


def shift_warnings(drops: tuple[float, ...], design: Design) -> tuple[str, ...]:
    """Say that all crests of a measured part are shifted: the contact does not feel it, the thickness may."""
    shift = -float(np.median(drops)) if drops else 0.0
    if abs(shift) <= MOST_SHIFT * design.skin.thickness:
        return ()
    side = "higher" if shift > 0 else "lower"
    return (
        f"the median crest lies {abs(shift):.3g} mm {side} than designed: the gauge's zero, or a back of "
        f"another thickness than the {design.skin.thickness:g} mm that the model assumes",
    )
