"""Crest heights of a cast part, as measured, against the design's."""

from __future__ import annotations

import math
from collections import Counter
from pathlib import Path

import numpy as np

from skincad.base.columns import read_columns
from skincad.base.errors import InputError
from skincad.inputs.design import Design
from skincad.shape.skin import Skin, skin_of

# of the skin's thickness; the all-touch force goes with its power -0.65, so this changes it by 1.3 %
MOST_SHIFT = 0.02


MOST_NAMED = 12  # numbers in a message
# Places across a face where its height is measured, in half its width
FACE = (-0.8, 0.0, 0.8)


def crest_places(skin: Skin) -> tuple[tuple[float, float, float], ...]:
    """Return where a part's crests are measured, x, y and height over the flat back, mm: on each feature in
    the order of their numbers, or on a face at FACE along x."""
    if not skin.bare:
        return tuple((*placed.tip[:2], high) for placed, high in zip(skin.placed, skin.crests, strict=True))
    radius, along = skin.base.curvature_radius, [place * skin.base.width / 2 for place in FACE]
    falls = [2 * radius * math.sin(math.asin(x / radius) / 2) ** 2 for x in along]
    return tuple((x, 0.0, skin.base.thickness - fall) for x, fall in zip(along, falls, strict=True))


def crest_column(skin: Skin) -> str:
    """Return what counts the places in a CSV: the feature, "place" on a face."""
    return skin.family if not skin.bare else "place"


def crest_drops(path: Path | str, design: Design) -> tuple[tuple[float, ...], tuple[str, ...]]:
    """Return by how much each crest of a measured part lies lower than designed, mm, feature 1 first, and how
    the file was read.

    Columns `ridge`, `pin`, `ring` or, of a face, `place`, and `crest_mm`: the height over the flat back at
    each of `crest_places` once. `ridge` counts features of any family. Of a round face the outer two count
    by their mean, as its section turns.
    """
    skin = skin_of(design)
    column, places = crest_column(skin), crest_places(skin)
    columns = read_columns(path, *dict.fromkeys(((column, "crest_mm"), ("ridge", "crest_mm"))))
    numbers = columns[column if column in columns.by_name else "ridge"]
    if sorted(numbers.tolist()) != list(range(1, len(places) + 1)):
        rule = f"must give crest_mm of each {column} from 1 to {len(places)} once"
        times = dict.fromkeys(range(1, len(places) + 1), 0) | Counter(numbers.tolist())
        wrong = [number for number, count in times.items() if count != 1 or not 1 <= number <= len(places)]
        many = numbers.size > MOST_NAMED
        given = [f"{i:g} {times[i]} times" for i in wrong] if many else [f"{i:g}" for i in numbers]
        raise InputError(
            str(path), rule, ", ".join(given[:MOST_NAMED]), "number them as the casting sheet's form does"
        )
    measured = dict(zip(numbers.astype(int).tolist(), columns["crest_mm"].tolist(), strict=True))
    drops = [designed - measured[i] for i, (_, _, designed) in enumerate(places, 1)]
    key = f"{skin.family}.{'heights' if skin.uneven else 'height'}"
    most = list(skin.heights)
    if column == "place":
        key, most = "skin.thickness", [skin.base.thickness] * len(places)
    worst = max(range(len(places)), key=lambda i: abs(drops[i]) - most[i])
    if abs(drops[worst]) > most[worst]:
        rule = f"must be within {most[worst]:g} mm ({key}) of the designed {places[worst][2]:.4g} mm"
        raise InputError(f"{path}, {column} {worst + 1}", f"{rule} above the back", measured[worst + 1])
    if column == "place" and skin.base.round:
        drops[0] = drops[-1] = (drops[0] + drops[-1]) / 2
    return tuple(drops), columns.notes


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
