"""Random skins, and random scenes of pressing and pulling them: what benches of scenes draw from.

Ranges are assumptions: three to seven ridges of the paper's proportions within a factor of two, pressed to a
nominal strain of 0.02 to 0.13; a quarter of the scenes are on the templates' skins. Speeds go by the skin's
slowest mode, which is 60 to 2000 Hz: ramps of 0.1 to 100 ms.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from bench.exam.scenes import templates
from skincad.inputs import Design, load
from skincad.inputs.material import silicone
from skincad.mechanics import shear_frequency
from skincad.scenes import Scene, load_scene
from skincad.shape import skin_of

SHIPPED = 0.25  # share of scenes on a template's skin
TILTED, LARGEST_TILT = 0.3, 45.0  # share of skins whose slots lean, and how far, deg
DRIVEN, PRESSED = 0.2, 0.1  # share of scenes whose plate is driven along, and that only press
PERIODS = 0.15, 6.0  # length of a ramp by the period of the skin's slowest mode
STEPS = 300
PULLED_FROM, PULLED_STEPS = 4, 10  # the step that ends the press of `pulled_scene`, and all of its


def between(rng: np.random.Generator, low: float, high: float) -> float:
    """Return a number between two, its logarithm evenly spread."""
    return math.exp(rng.uniform(math.log(low), math.log(high)))


def random_skin(rng: np.random.Generator, tilt: float = 0.0) -> tuple[Design, float]:
    """Return a random skin and the N that press it; InputError where it cannot be."""
    pitch = between(rng, 0.8, 2.5)
    root = pitch * rng.uniform(0.5, 0.8)
    tip = root * rng.uniform(0.6, 0.9)
    height = root * rng.uniform(0.45, 0.95)
    count = int(rng.choice([3, 3, 5, 7]))
    thickness, width = pitch * rng.uniform(1.5, 5), pitch * (count + rng.uniform(1, 3))
    radius, length, modulus = width * between(rng, 3, 60), rng.uniform(6, 20), between(rng, 0.1, 1.5)
    normal = round(rng.uniform(0.02, 0.13) * modulus * (root + tip) / 2 * length * count, 4)
    tables = {
        "skin": {"curvature_radius": radius, "thickness": thickness, "width": width, "length": length},
        "ridge": {
            "count": count,
            "pitch": pitch,
            "height": height,
            "root_width": root,
            "tip_width": tip,
            "crown": 0.04 * tip,
            "tip_fillet": 0.1 * tip,
            "root_fillet": 0.15 * height,
        },
        "slot": {"depth": 0.5 * height, "offset": 0.2 * root, "elevation": 0.1 * height, "tilt": tilt},
        "contact": {"force": normal},
        "material": {"young_modulus": {"value": modulus, "low": 0.8 * modulus, "high": 1.2 * modulus}},
    }
    return load("yamada-2002").with_(**_rounded(tables)), normal


def _rounded(value: Any) -> Any:
    """Return a table's numbers as one would write them."""
    if isinstance(value, dict):
        return {key: _rounded(inner) for key, inner in value.items()}
    return value if isinstance(value, int) else round(float(value), 4)


def random_scene(rng: np.random.Generator) -> Scene:
    """Return a random scene, films bonded in half of them; InputError where its skin cannot be.

    Pressed, pulled, pulled on or back, each at its own speed and held for a while.
    """
    tilt = round(rng.uniform(-LARGEST_TILT, LARGEST_TILT), 1) if rng.random() < TILTED else 0.0
    shipped = templates()
    if rng.random() < SHIPPED:
        one = shipped[int(rng.integers(len(shipped)))]
        design, normal = one.design, round(one.force * rng.uniform(0.4, 1.0), 4)
    else:
        design, normal = random_skin(rng, tilt)
    friction, level = round(between(rng, 0.15, 0.8), 4), rng.uniform(0.3, 0.95)
    pull = level * friction * normal * (rng.random() >= PRESSED)
    driven = rng.random() < DRIVEN
    pull *= _give(design) if driven else 1.0
    period = 1 / slowest(design)
    press, on, back = (between(rng, *PERIODS) * period for _ in range(3))
    holds = [period * rng.uniform(0.5, 2.0) for _ in range(3)]
    time = np.cumsum([0.0, press, holds[0], on, holds[1], back, holds[2]])
    last = rng.uniform(-0.5, 0.9)
    across, other = ("displacement_mm", "tangential_force_N")[:: 1 if driven else -1]
    changes = [
        f"history.steps={STEPS}",
        f"history.time_s={_listed(time)}",
        f"history.normal_force_N={_listed([0, *[normal] * 6])}",
        f"history.{across}={_listed([0, 0, 0, pull, pull, last * pull, last * pull])}",
        f"history.{other}=none",
        f"effects.friction.coefficient={friction}",
        f"readout.ridges={list(range(1, skin_of(design).count + 1))}",
        *([] if rng.random() < 0.5 else ["effects.film=none"]),
    ]
    return load_scene("yamada-2002-slip", changes, skin=design)


def pulled_scene(rng: np.random.Generator) -> Scene:
    """Return a random scene pressed, and pulled to 0.95 of friction; InputError where its skin cannot be."""
    design, normal = random_skin(rng)
    friction = round(between(rng, 0.15, 0.6), 4)
    changes = [
        f"history.steps={PULLED_STEPS}",
        f"history.time_s=[0.0, {PULLED_FROM / 1000}, {PULLED_STEPS / 1000}]",
        f"history.normal_force_N=[0.0, {normal}, {normal}]",
        f"history.tangential_force_N=[0.0, 0.0, {0.95 * friction * normal}]",
        f"effects.friction.coefficient={friction}",
        "readout.ridges=[3]",
        *([] if rng.random() < 0.5 else ["effects.film=none"]),
    ]
    return load_scene("yamada-2002-slip", changes, skin=design)


def _give(design: Design) -> float:
    """Return mm of travel per N of pull, of a sheared block: less than ridges give."""
    ridge, shear = design.ridge, silicone(design).young_modulus.value / 3
    return design.skin.thickness / (shear * ridge.count * ridge.root_width * design.skin.length)


def slowest(design: Design) -> float:
    """Return the frequency of a skin's slowest mode, Hz, as of a bonded layer."""
    stuff = silicone(design)
    shear = stuff.young_modulus.value / (2 * (1 + stuff.poisson_ratio))
    return shear_frequency(shear, stuff.density, skin_of(design).height)


def _listed(values: Any) -> list[float]:
    return [float(f"{float(value):.5g}") for value in values]
