"""Random designs over every key that shapes a part: a seed draws one.

What the model or the mold refuses is counted by the key that it names, and the seed draws again until one is
accepted.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import Any

import numpy as np

from skincad.base import InputError
from skincad.inputs import PROCESSES, Design, silicones
from skincad.inputs.material import silicone
from skincad.mechanics import crest_gaps, pad_of, ridge_stiffness
from skincad.shape import skin_of
from skincad.solids.mold import mold

MOST_DRAWS = 200  # of one seed; every second draw or so is a design


@dataclass(frozen=True)
class Drawn:
    """An accepted design, and the keys that the draws before it were refused by."""

    design: Design
    refused: tuple[str, ...]


def drawn(seed: int) -> Drawn:
    """Return the seed's first design that model and mold accept."""
    random = np.random.default_rng(seed)
    refused: list[str] = []
    for _ in range(MOST_DRAWS):
        try:
            design = Design(name=f"random-{seed}", **tables(Dice(random)))
            mold(design)
        except InputError as refusal:
            refused.append(refusal.key)
        else:
            return Drawn(design, tuple(refused))
    raise AssertionError(f"seed {seed}: none of {MOST_DRAWS} draws is a design: {Counter(refused)}")


class Dice:
    """A random generator with the few shapes of draw that are needed here."""

    def __init__(self, random: np.random.Generator) -> None:
        self.random = random

    def over(self, low: float, high: float) -> float:
        return float(self.random.uniform(low, high))

    def scale(self, low: float, high: float) -> float:
        return float(np.exp(self.random.uniform(np.log(low), np.log(high))))

    def happens(self, share: float) -> bool:
        return bool(self.random.random() < share)

    def whole(self, low: int, high: int) -> int:
        return int(self.random.integers(low, high + 1))

    def one(self, values: Any) -> Any:
        return list(values)[self.whole(0, len(values) - 1)]

    def maybe(self, share: float, **tables: Any) -> dict[str, Any]:
        return {key: value for key, value in tables.items() if self.happens(share)}


def tables(dice: Dice) -> dict[str, Any]:
    """Return a design's tables, drawn so that every second or so is a design."""
    ridge = _ridge(dice)
    skin = _skin(dice, ridge)
    table = {"skin": skin, "ridge": ridge, "material": {"name": dice.one(silicones())}, "mold": _mold(dice)}
    if dice.happens(0.6):
        table["slot"] = _slot(dice, ridge)
        if dice.happens(0.7):
            table["film"] = _film(dice, table["slot"])
            if dice.happens(0.4):
                table["mold"]["method"] = "cast-in"
    return table


def _ridge(dice: Dice) -> dict[str, Any]:
    pitch = dice.scale(0.4, 8.0)
    root = pitch * dice.over(0.4, 0.98)
    tip = root * (1.0 if dice.happens(0.05) else dice.over(0.3, 1.0))
    height = pitch * dice.scale(0.1, 1.2)
    most = min(height, tip / 2)
    small = {
        "crown": 0.0 if dice.happens(0.15) else most * dice.scale(0.01, 0.9),
        "tip_fillet": 0.0 if dice.happens(0.15) else most * dice.scale(0.05, 0.8),
        "root_fillet": 0.0 if dice.happens(0.15) else min(pitch - root, height) * dice.scale(0.05, 0.8),
    }
    count = dice.whole(1, 15)
    return {"count": count, "pitch": pitch, "root_width": root, "tip_width": tip, "height": height, **small}


def _skin(dice: Dice, ridge: dict[str, Any]) -> dict[str, Any]:
    width = ridge["count"] * ridge["pitch"] * dice.over(1.02, 1.6) + 2 * ridge["root_fillet"]
    width = max(width, dice.scale(3.0, 10.0))
    return {
        "curvature_radius": 1e8 if dice.happens(0.03) else width * dice.scale(0.75, 100.0),
        "thickness": dice.scale(1.0, 20.0),
        "width": width,
        "length": dice.scale(9.0, 80.0),
    }


def _slot(dice: Dice, ridge: dict[str, Any]) -> dict[str, Any]:
    thickness = ridge["tip_width"] * dice.scale(0.02, 0.25)
    return {
        "thickness": max(thickness, 0.006),
        "depth": max(ridge["height"] * dice.over(0.1, 0.9), 0.05),
        "offset": ridge["tip_width"] * dice.over(0.1, 0.45),
        "elevation": ridge["height"] * dice.over(-0.4, 0.6),
        "tilt": 0.0 if dice.happens(0.5) else dice.over(-30.0, 50.0),
    }


def _film(dice: Dice, slot: dict[str, Any]) -> dict[str, Any]:
    return {
        "thickness": slot["thickness"] * dice.over(0.2, 1.0),
        "electrode_margin": slot["depth"] * dice.over(0.0, 0.4),
        "lead": dice.scale(1.0, 30.0),
        "wiring_side": dice.one("ab"),
    }


def _mold(dice: Dice) -> dict[str, Any]:
    return {
        "process": dice.one(PROCESSES),
        **dice.maybe(0.3, end_plate_process=dice.one(PROCESSES), lid_process=dice.one(PROCESSES)),
        "wall": dice.over(12.0, 20.0),
        "floor": dice.over(9.0, 15.0),
        "end_plate": dice.over(1.0, 10.0),
        "cover": dice.over(1.0, 10.0),
        "clearance": 0.0 if dice.happens(0.05) else dice.scale(0.005, 0.3),
        "slit_clearance": 0.0 if dice.happens(0.05) else dice.scale(0.002, 0.05),
        "shrinkage": dice.one((0.0, 0.001, 0.01, 0.05)),
        "split": dice.one(("none", "none", "auto")),
        "cavities": dice.one((1, 1, 1, 2, 3)),
        "carrier": dice.one(("perforated", "plain")),
        "carrier_thickness": dice.over(1.0, 12.0),
        "pour": dice.one(("syringe", "open")),
        "pour_tilt": dice.over(0.0, 60.0),
        "gate": dice.scale(0.4, 5.0),
        "vent": dice.scale(0.3, 3.0),
        **dice.maybe(0.2, reservoir=dice.scale(3.0, 20.0)),
    }


def wide(seed: int) -> tuple[Design, float]:
    """Return a pad far from the templates and a force, N: 1 to 40 ridges on a base 0.02 to 3 widths thick,
    nu 0.3 to 0.4999, crowns none to large, every seventh plate shaped; no mold is asked for.

    The force is 1e-4 to 10 times what closes all gaps of independent springs (what strains them by a tenth
    where that is less, or where nothing is to be closed).
    """
    dice = Dice(np.random.default_rng([seed, 11]))
    for _ in range(MOST_DRAWS):
        try:
            design = Design(name=f"wide-{seed}", **_wide(dice))
            pad_of(design)
        except InputError:
            continue
        return design, _any_force(design, dice)
    raise AssertionError(f"seed {seed}: none of {MOST_DRAWS} draws is a design")


def _wide(dice: Dice) -> dict[str, Any]:
    count, pitch = round(dice.scale(0.5, 40.5)) or 1, dice.scale(0.4, 8.0)
    root = pitch * dice.over(0.3, 0.98)
    tip, height = root * dice.over(0.3, 1.0), pitch * dice.scale(0.1, 1.2)
    crown = 0.0 if dice.happens(0.25) else min(height, tip / 2) * dice.scale(0.01, 0.9)
    fillet = 0.0 if dice.happens(0.4) else min(height, tip / 2) * dice.scale(0.05, 0.8)
    ridge = {"count": count, "pitch": pitch, "root_width": root, "tip_width": tip, "height": height}
    width = max(count * pitch * dice.over(1.02, 1.6), 1.0)
    thickness = width * dice.scale(0.02, 3.0)
    skin = {
        "curvature_radius": width * dice.scale(max(0.75, 0.15 * width / thickness), 300.0),
        "thickness": thickness,
        "width": width,
        "length": dice.scale(3.0, 100.0),
    }
    table = {"skin": skin, "ridge": {**ridge, "crown": crown, "tip_fillet": fillet}}
    table["material"] = {"young_modulus": 1.0, "poisson_ratio": 0.5 - dice.scale(1e-4, 0.2)}
    if dice.happens(0.25):
        table["slot"] = _slot(dice, table["ridge"])
    if dice.happens(0.15):
        table["contact"] = {"plate": _plate(dice, skin)}
    return table


def _plate(dice: Dice, skin: dict[str, Any]) -> dict[str, Any]:
    height = 0.1 * skin["width"] ** 2 / skin["curvature_radius"]
    tilt = {"shape": "tilted", "tilt": dice.over(-1.0, 1.0) * min(2.0, 20 * height / skin["width"])}
    cylinder = {"shape": "cylinder", "radius": skin["width"] * dice.scale(2.0, 300.0)}
    return dict(dice.one((tilt, cylinder, {"shape": "step", "height": height * dice.over(0.0, 1.0)})))


def _any_force(design: Design, dice: Dice) -> float:
    stiffness, gaps = ridge_stiffness(design), crest_gaps(design)
    area = (
        skin_of(design).count
        * (skin_of(design).profile.root_width + skin_of(design).profile.tip_width)
        / 2
        * design.skin.length
    )
    most = 0.1 * silicone(design).young_modulus.value * area
    touching = stiffness * float((gaps.max() - gaps).sum())
    return dice.scale(1e-4, 10.0) * (min(touching, most) if touching > 1e-9 * most else most)
