"""Numbers that were read off runs, in one table (fits.csv): neither physics with a source nor an assumption.

A fit says nothing about designs that are unlike those behind it. What makes designs alike here are seven
numbers without a unit (`shape_of`); a set of designs (fit_designs.csv) holds the range of each. A verdict by
a model whose fits saw nothing like the design says so, and a scene's estimate is then called uncalibrated.

The numbers stay where they are used; a row says where. docs/evidence/fits.md shows the table with their
values.
"""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass
from importlib import import_module
from importlib.resources import files
from typing import Any

from skincad.inputs.design import Design
from skincad.inputs.material import layers, silicone
from skincad.shape.skin import skin_of

NUMBERS = {
    "ridges": "ridges",
    "slenderness": "height by mean width",
    "base": "base thickness by pitch",
    "length": "length by base thickness",
    "curvature": "width by radius",
    "poisson": "Poisson's ratio",
    "layers": "modulus of a layer by the skin's own",
}
ROUNDING = 1e-9  # relative; a design at a range's end is within


def shape_of(design: Design) -> dict[str, float]:
    """Return the design's numbers, keys as in NUMBERS."""
    skin, table, own = skin_of(design), design.skin, silicone(design)
    moduli = (stuff.young_modulus.value / own.young_modulus.value for stuff in layers(design))
    return {
        "ridges": float(skin.count),
        "slenderness": max(skin.heights) / skin.profile.mean_width,
        "base": table.thickness / skin.pitch,
        "length": table.length / table.thickness,
        "curvature": table.width / table.curvature_radius,
        "poisson": own.poisson_ratio,
        "layers": max(moduli, key=lambda ratio: abs(math.log(ratio)), default=1.0),
    }


def _rows(table: str) -> list[dict[str, str]]:
    """The rows of a table beside this file."""
    with (files("skincad.mechanics") / table).open(encoding="utf-8") as lines:
        return list(csv.DictReader(lines))


def _range(words: str) -> tuple[float, float]:
    """Two numbers, "3 to 21"."""
    low, _, high = words.partition(" to ")
    return float(low), float(high)


# Sets of designs: what they are, and between what their numbers lie
DESIGNS = {
    row["set"]: (row["what"], {key: _range(row[key]) for key in NUMBERS}) for row in _rows("fit_designs.csv")
}


@dataclass(frozen=True)
class Fit:
    """Numbers, their `names` in a `module`, what they are, and the sets of designs behind them. `models` are
    those whose verdict's error they are part of; `effect` is the one whose estimate they scale. All designs
    are of one `family`."""

    module: str
    names: tuple[str, ...]
    what: str
    designs: tuple[str, ...]
    models: tuple[str, ...]
    effect: str
    family: str

    @property
    def values(self) -> dict[str, Any]:
        """The numbers by name."""
        home = import_module(f"skincad.{self.module}")
        return {name: getattr(home, name) for name in self.names}

    @property
    def ranges(self) -> dict[str, tuple[float, float]]:
        """Between what each number lies in all sets together."""
        sets = [DESIGNS[name][1] for name in self.designs]
        return {key: (min(of[key][0] for of in sets), max(of[key][1] for of in sets)) for key in NUMBERS}


FITS = tuple(
    Fit(
        row["module"],
        tuple(row["names"].split()),
        row["what"],
        tuple(row["designs"].split("; ")),
        tuple(row["models"].split()),
        row["effect"],
        row["family"],
    )
    for row in _rows("fits.csv")
)


def unlike(design: Design, *, model: str = "", effect: str = "") -> str:
    """Return in which numbers the design is unlike all that a model's or an effect's fits saw, or ""."""
    family, numbers, unseen = skin_of(design).family, shape_of(design), dict[str, str]()
    fits = [fit for fit in FITS if fit.family == family]
    if family != "ridge" and not any(model in fit.models for fit in fits):
        return f"it has [{family}]"
    for fit in fits:
        if model in fit.models or (effect and effect == fit.effect):
            for key, (low, high) in fit.ranges.items():
                margin = ROUNDING * abs(high)
                if not low - margin <= numbers[key] <= high + margin:
                    name = f"{family}s" if key == "ridges" else NUMBERS[key]
                    unseen[key] = f"{name} {numbers[key]:.5g} (seen: {low:.5g} to {high:.5g})"
                    if key == "layers" and low == high:
                        unseen[key] = "layers of other silicones (seen: none)"
    return ", ".join(unseen.values())
