"""Lifts by seed: a skin, a friction, an object, how its load comes, and a gripper that is late and slow.

Even seeds are to fit and to set constants on, odd ones to judge on. Skins are the templates with films, which
both have, and random ones: 90 to fit on, 30 others to judge on (bench/exam/scenes.py). All ranges are
assumptions. They are drawn so that the skin's own force holds some of the objects and not all of them: the
least grip that holds is a share of it, which says what the object weighs. A gripper's rates are those of a
skin that is pressed by PRESSED or more; where it is pressed by less they are as much smaller.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

import skincad
from bench import runner
from bench.exam.scenes import DESIGN, MORE, SETS, Skin, random_skin, skins
from skincad.base import InputError
from skincad.circuit import Circuit, load_circuit
from skincad.scenes import LEVELS, Carrier, MarchSetup, Scene, carrier, piece_for
from skincad.scenes.grip import FINGERS, GRAVITY
from skincad.studies.holding import ACCELERATION, CLOSE, FIRST, FRICTION, HOLD, KINDS, LIFT, RISE, history

SHARE = 0.4, 1.5  # of the skin's own force: the least grip that holds
DELAY = 0.01, 0.05  # s
FORCE_RATE = 30.0, 300.0  # N/s
PRESSED = 4.0  # N
STRONG = 4.0  # times the larger of the skin's force and the least grip: the gripper's largest force
RATE, BAND = 2000.0, 800.0  # Hz
LONG = "charge-amplifier of 5 s"
AMPLIFIERS = ("transimpedance", LONG)
SKINS = runner.ROOT / "out" / "lifts" / "skins"
HEAVIEST = 1e5  # g, of Grip


@dataclass(frozen=True, eq=False)
class Lift:
    """A lift: N of the `least` grip that holds it, the `first` one's share of that, s of the load's `rise`,
    and how it comes; the `scene` holds the rest."""

    seed: int
    skin: Skin
    kind: str
    friction: float
    least: float
    first: float
    rise: float
    amplifier: str
    scene: Scene


def circuit(name: str) -> Circuit:
    """Return an amplifier; LONG holds a charge for 5 s: five resistors of 10 Gohm in a row."""
    if name == LONG:
        return load_circuit("charge-amplifier", ["amplifier.feedback_resistance=5e10"])
    return load_circuit(name)


@cache
def set_skins(kind: str) -> list[Skin]:
    """Return the skins of a set, made once."""
    more = [random_skin(i) for numbers in MORE for i in numbers] if kind == DESIGN else []
    return [*skins(kind), *more]


def drawn(seed: int) -> Lift:
    """Return the lift of a seed, drawn again where the skin can't be gripped so."""
    draw = np.random.default_rng((61, seed))
    pads = set_skins(SETS[seed % 2])
    while True:
        try:
            return _drawn(draw, seed, pads[int(draw.integers(len(pads)))])
        except InputError:
            continue


def _drawn(draw: np.random.Generator, seed: int, skin: Skin) -> Lift:
    friction, least = float(draw.uniform(*FRICTION)), skin.force * _log(draw, SHARE)
    first, rise, kind = float(draw.uniform(*FIRST)), _log(draw, RISE), str(draw.choice(KINDS))
    acceleration, up = float(draw.uniform(*ACCELERATION)), float(draw.uniform(*LIFT))
    time, load = history(draw, kind, rise)
    peak = least * friction
    still = peak / (1 + acceleration / GRAVITY if kind == "lift" else load.max())
    grip: dict[str, Any] = {
        "gripper": "plain-plate",
        "mass": float(np.clip(1e3 * FINGERS * still / GRAVITY, 0.0, HEAVIEST)),
        "force": first * least,
        "close": CLOSE,
        "delay": float(draw.uniform(*DELAY)),
        "force_rate": _log(draw, FORCE_RATE) * min(1.0, skin.force / PRESSED),
        "force_max": STRONG * max(skin.force, least),
        "policy": "constant",
    }
    if kind == "lift":
        grip |= {"rise": rise, "acceleration": acceleration, "lift": up, "hold": HOLD}
    else:
        grip |= {"load_time_s": time.tolist(), "load_N": (still * load).tolist()}
    amplifier = AMPLIFIERS[int(draw.integers(len(AMPLIFIERS)))]
    scene = Scene(
        name="lift",
        skin=skin.design,
        grip=grip,
        effects=effects(friction, amplifier, seed),
        readout={"ridges": list(range(1, skin.design.ridge.count + 1)), "bandwidth_Hz": BAND},
    )  # fmt: skip
    return Lift(seed, skin, kind, friction, least, first, rise, amplifier, scene)


def effects(friction: float, amplifier: str, seed: int) -> dict[str, Any]:
    """Return the effects of a lift; the seed is the noise's."""
    return {
        "friction": {"coefficient": friction},
        "film": {},
        "viscosity": {"retardation_time": 5e-4},
        "piezo": {"circuit": circuit(amplifier), "noise_seed": seed, "sampling_Hz": RATE},
    }


def _log(draw: np.random.Generator, ends: tuple[float, float]) -> float:
    return float(np.exp(draw.uniform(*np.log(ends))))


_CARRIERS: dict[str, Carrier] = {}  # of skins: their meshes and compliances


def finger(one: Lift) -> Carrier:
    """Return what carries a lift's object; a skin's mesh and compliance are made once and kept on disk."""
    scene, name = one.scene, one.skin.name
    if name not in _CARRIERS:

        def make() -> Carrier:
            return carrier(scene, MarchSetup(scene, piece_for(scene, {})), LEVELS[0])

        _CARRIERS[name] = runner.kept(SKINS / f"{name}.pkl", make)
    grip, cone = scene.grip, scene.cone
    assert grip is not None
    assert cone is not None
    return replace(_CARRIERS[name], mass=1e-6 * grip.mass / FINGERS, cone=cone)


def first_two(one: Lift) -> tuple[int, ...]:
    """Return the two ridges that a check says to wire first."""
    answer = skincad.check(one.skin.design, force=one.skin.force, model="linear", tol=0.05)
    return tuple(sorted(answer.wire_first[:2]))
