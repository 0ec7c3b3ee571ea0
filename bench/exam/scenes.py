"""The exam's scenes by seed: a skin, a friction, a history, some told ridges; marched once and kept on disk.

Sets are split by seed, once: even ones to choose constants on (`design`), odd ones to be scored (`exam`).
They are marched as `simulate` marches them, with masses where their steps show them, but on the coarsest mesh
alone and at small strain. Every eighth has a plate of 0.05 to 1 g. Seeds below FIRST were scored before.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from bench.exam.histories import STEPS, History, history
from bench.exam.skins import DESIGN, EXAM, SETS, Skin, skins
from skincad.base import InputError
from skincad.inputs.material import silicone
from skincad.scenes import LEVELS, MarchSetup, Scene, halts_of, march_on, piece_for, slips_of

COUNT = {DESIGN: 240, EXAM: 320}  # scenes
LATER = 360, 200  # more to fit on, by batch, each of other skins
FIRST = 4000  # seed
HEAVY = 8  # every so manyth scene's plate has a mass
FRICTION = 0.2, 1.0
MASS = 0.05, 1.0  # g


@dataclass(frozen=True, eq=False)
class Drawn:
    """A scene before its march."""

    seed: int
    skin: Skin
    friction: float
    mass: float | None
    way: History
    scene: Scene


@dataclass(frozen=True, eq=False)
class SceneRun:
    """A scene after it: films' `stress` `(n, strips, 3)` MPa, `slipping` `(n, ridges)`, forces N; `gross` is
    the step of gross slip, where it ends, None without one; `told` ridges from 1."""

    seed: int
    skin: Skin
    friction: float
    mass: float | None
    time: np.ndarray
    bandwidth: float
    stress: np.ndarray
    slipping: np.ndarray
    normal: np.ndarray
    tangential: np.ndarray
    gross: int | None
    phases: tuple[tuple[str, int], ...]
    told: tuple[int, ...]


@cache
def set_skins(kind: str, batch: int) -> list[Skin]:
    """Return the skins of a set's batch, made once."""
    return skins(kind, batch)


def batch(seed: int) -> int:
    """Return which batch a seed is of: 0, or a later one of the design set."""
    ends = np.cumsum([COUNT[DESIGN], *LATER])
    return 0 if seed % 2 else int(np.searchsorted(ends, (seed - FIRST) // 2, side="right"))


def seeds(kind: str) -> list[int]:
    """Return a set's seeds."""
    first = FIRST + SETS.index(kind)
    count = COUNT[kind] + (sum(LATER) if kind == DESIGN else 0)
    return list(range(first, first + 2 * count, 2))


def drawn(seed: int) -> Drawn:
    """Return the scene of a seed, drawn again where skin and history do not fit."""
    draw = np.random.default_rng((2020, seed))
    pads, heavy = set_skins(SETS[seed % 2], batch(seed)), (seed // 2) % HEAVY == HEAVY - 1
    while True:
        skin = pads[int(draw.integers(len(pads)))]
        friction = float(draw.uniform(*FRICTION))
        mass = float(np.exp(draw.uniform(*np.log(MASS)))) if heavy else None
        design = skin.design
        turn = min(3.0, float(np.degrees(2 * design.ridge.pitch / design.skin.curvature_radius)))
        way = history(draw, skin.force, friction, 0.0 if heavy else turn, _reach(skin, friction))
        try:
            return Drawn(seed, skin, friction, mass, way, _scene(skin, friction, mass, way))
        except InputError:
            continue


def _reach(skin: Skin, friction: float) -> float:
    """Return mm of travel that about slips twice over: a sheared block's, which is stiffer than ridges."""
    d = skin.design
    area = d.ridge.count * d.ridge.root_width * d.skin.length
    return 2 * friction * skin.force * d.skin.thickness / (silicone(d).young_modulus.value / 3 * area)


def _scene(skin: Skin, friction: float, mass: float | None, way: History) -> Scene:
    across = {"tangential_force_N": way.tangential} if way.travel is None else {"displacement_mm": way.travel}
    history = {"time_s": way.time, "normal_force_N": way.normal, **across, "steps": STEPS}
    if np.any(way.angle):
        history["rotation_deg"] = way.angle
    return Scene(
        name="exam", skin=skin.design, history=history, plate={} if mass is None else {"mass": mass},
        effects={"friction": {"coefficient": friction}, "film": {}},
        readout={"ridges": [1], "bandwidth_Hz": way.bandwidth},
    )  # fmt: skip


_SKINS: dict[str, MarchSetup] = {}  # their mesh and modes


def marched(one: Drawn) -> SceneRun:
    """March a scene; a skin's mesh and modes are made once."""
    scene = one.scene
    if one.skin.name not in _SKINS:
        _SKINS[one.skin.name] = MarchSetup(scene, piece_for(scene, {}))
    answer = march_on(LEVELS[0], replace(_SKINS[one.skin.name], scene=scene), {})
    slips = slips_of(answer, scene.design.ridge.count, halts_of(scene))
    slipping = np.zeros_like(slips.slipping)
    for ridge, runs in enumerate(slips.runs):
        for first, last in runs:
            slipping[first : last + 1, ridge] = True
    draw = np.random.default_rng((77, one.seed))
    ridges = scene.design.ridge.count
    told = np.sort(draw.permutation(ridges)[: draw.integers(1, min(9, ridges) + 1)]) + 1
    return SceneRun(
        one.seed, one.skin, one.friction, one.mass, answer.time, one.way.bandwidth, answer.column("films"),
        slipping, answer.column("normal"), answer.column("tangential"), slips.gross, one.way.phases,
        tuple(told.tolist()),
    )  # fmt: skip


def kept(seed: int, folder: Path) -> SceneRun:
    """Return a seed's march from disk, marched if it is not there."""
    path = folder / f"{seed}.npz"
    one = drawn(seed)
    if not path.exists():
        answer = marched(one)
        arrays = {k: getattr(answer, k) for k in ("time", "stress", "slipping", "normal", "tangential")}
        gross = -1 if answer.gross is None else answer.gross
        folder.mkdir(parents=True, exist_ok=True)
        np.savez_compressed(path, gross=gross, told=answer.told, **arrays)
    with np.load(path) as data:
        gross = int(data["gross"])
        return SceneRun(
            seed, one.skin, one.friction, one.mass, data["time"], one.way.bandwidth, data["stress"],
            data["slipping"], data["normal"], data["tangential"], None if gross < 0 else gross,
            one.way.phases, tuple(data["told"].tolist()),
        )  # fmt: skip


def scenes(kind: str, folder: Path) -> Iterator[SceneRun]:
    """Yield a set's scenes, those of one skin after each other."""
    order = sorted(seeds(kind), key=lambda s: drawn(s).skin.name)
    for seed in order:
        yield kept(seed, folder)


if __name__ == "__main__":
    with threadpool_limits(limits=1, user_api="blas"), warnings.catch_warnings():
        for kind in sys.argv[2:] or SETS:
            for found in scenes(kind, Path(sys.argv[1])):
                slip = found.slipping.any(axis=1).argmax()
                print(
                    found.seed, found.skin.name, f"{found.friction:.2f}", found.mass, len(found.time) - 1,
                    "gross", found.gross, "first slip", slip, [p for p, _ in found.phases], flush=True,
                )  # fmt: skip
