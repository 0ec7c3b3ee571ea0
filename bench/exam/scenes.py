"""The exam's scenes by seed: a skin, a friction, a history, some told ridges; marched once and kept on disk.

Sets are split by seed, once: even ones to choose constants on (`design`), odd ones to be scored (`exam`).
They are marched as `simulate` marches them, with masses where their steps show them, but on the coarsest mesh
and at small strain. Every eighth has a plate of 0.05 to 1 g. Seeds below FIRST were scored before.

Skins are the templates with films, and random ones: 10 to fit on, 30 to score; 90 more to fit on. These keep
the proportions of yamada-2002 within a factor (assumption), and are pressed by what makes all their ridges
touch. The scenes that ship, and pulls and presses of a few ms, are in the design set.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache, partial
from pathlib import Path

import numpy as np

import skincad
from bench import runner
from bench.exam.histories import STEPS, History, history
from skincad.base import InputError
from skincad.inputs import Design, load_design, template_names
from skincad.inputs.material import silicone
from skincad.scenes import (
    LEVELS,
    MarchSetup,
    Scene,
    at_level,
    halts_of,
    load_scene,
    march_on,
    piece_for,
    slips_of,
)

DESIGN, EXAM = "design", "exam"
SETS = (DESIGN, EXAM)
RANDOM = {DESIGN: range(10), EXAM: range(110, 140)}  # numbers; 10 to 19 were scored before
# those of the design set's later batches: templates say little of other skins
MORE = range(20, 50), range(50, 110)
LARGEST = 12  # ridges; gripper-pad's 21 take as long as five others


NEWER = {"home-printer"}  # ships since the detector and the bounds were fitted: random scenes stay the same


@dataclass(frozen=True, eq=False)
class Skin:
    """A design, and N at which a scene of it presses."""

    name: str
    design: Design
    force: float


def templates() -> list[Skin]:
    """Return the flat-extruded templates with films and not more ridges than LARGEST; both sets have them."""
    rows = [load_design(name) for name in template_names("designs") if name not in NEWER]
    return [
        Skin(d.name, d, d.contact.force)
        for d in rows
        if d.film is not None and d.slot is not None and d.contact and d.ridge.count <= LARGEST
    ]


def skins(kind: str, batch: int = 0) -> list[Skin]:
    """Return a set's skins, templates first, or those of a later batch of its scenes, from 1."""
    if batch:
        return [random_skin(i) for i in MORE[batch - 1]]
    return [*templates(), *(random_skin(i) for i in RANDOM[kind])]


def random_skin(number: int) -> Skin:
    """Return the random skin of a number; the same every time."""
    draw = np.random.default_rng((20, number))
    while True:
        try:
            design = _drawn(draw, f"random-{number}")
            needed = skincad.check(design, model="winkler").all_touch_force.value
            force = float(np.clip(needed * draw.uniform(0.9, 1.6), 0.2, 60.0))
            return Skin(design.name, design, force)
        except InputError:
            continue


def _drawn(draw: np.random.Generator, name: str) -> Design:
    pitch = float(np.exp(draw.uniform(np.log(0.9), np.log(4.0))))
    count = int(draw.integers(3, LARGEST + 1))
    ridge = {
        "height": draw.uniform(0.35, 0.6), "root_width": draw.uniform(0.7, 0.82),
        "tip_width": draw.uniform(0.45, 0.6), "crown": draw.uniform(0.015, 0.04), "tip_fillet": 0.05,
        "root_fillet": 0.08,
    }  # fmt: skip
    slot = {"thickness": max(0.05 / pitch, 0.05), "depth": 0.25, "offset": 0.16, "elevation": 0.05}
    values = {
        "skin.curvature_radius": np.exp(draw.uniform(np.log(12), np.log(300))),
        "skin.thickness": pitch * draw.uniform(2.5, 6),
        "skin.width": pitch * (count + 2),
        "skin.length": pitch * draw.uniform(8, 20),
        "ridge.count": count,
        "ridge.pitch": pitch,
        "ridge.levelling": draw.choice([0.0, 0.0, 0.3, 0.6]),
        "material.young_modulus": np.exp(draw.uniform(np.log(0.15), np.log(1.5))),
        **{f"ridge.{key}": pitch * share for key, share in ridge.items()},
        **{f"slot.{key}": pitch * share for key, share in slot.items()},
    }
    return load_design("yamada-2002", [f'name="{name}"', *(f"{key}={v:.4g}" for key, v in values.items())])


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
    answer = march_on(LEVELS[0], replace(_SKINS[one.skin.name], scene=scene))
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
    return runner.kept(folder / f"{seed}.pkl", lambda: marched(drawn(seed)))


TOLD = 2, 3  # paper: strips in the second and third ridge from a side
PULLS = ("hold", "readout.bandwidth_Hz=5000.0", "history.steps=400")
FEW = {
    "fast load": (
        *PULLS, "history.time_s=[0.0, 0.001, 0.0015, 0.004]",
        "history.normal_force_N=[0.0, 4.0, 4.0, 4.0]", "history.tangential_force_N=[0.0, 0.0, 1.0, 1.0]",
    ),
    "to and fro": (
        *PULLS, "history.steps=600", "history.time_s=[0.0, 0.001, 0.002, 0.003, 0.004, 0.005, 0.006]",
        "history.normal_force_N=[0.0, 4.0, 4.0, 4.0, 4.0, 4.0, 4.0]",
        "history.tangential_force_N=[0.0, 0.0, 1.5, -1.5, 1.5, 0.0, 0.0]",
    ),
    "press too far": (
        *PULLS, "history.time_s=[0.0, 0.0005, 0.001, 0.002, 0.003, 0.004]",
        "history.normal_force_N=[0.0, 8.0, 3.0, 4.0, 4.0, 4.0]",
        "history.tangential_force_N=[0.0, 0.0, 0.0, 0.5, 0.5, 0.5]",
    ),
    "slip to -x": (
        "yamada-2002-slip", "history.tangential_force_N=[0.0, 0.0, -3.4, -3.4, -2.6, -3.2, -4.0]",
    ),
    "fast rolling": (
        "rolling", "history.time_s=[0.0, 0.001, 0.003, 0.007, 0.009]", "readout.bandwidth_Hz=5000.0",
    ),
}  # fmt: skip
NAMES = ("yamada-2002-slip", "steady-pull", "yamada-2002-stage", "hold", "rolling", "yamada-2002-press")
SHIPPED = {**{name: (name,) for name in NAMES}, **FEW}


def shipped(folder: Path) -> list[SceneRun]:
    """Return the marches of the scenes that ship, kept on disk; their seeds are below 0."""
    return [
        runner.kept(folder / f"{i}.pkl", partial(_shipped, -i, name)) for i, name in enumerate(SHIPPED, 1)
    ]


def _shipped(seed: int, name: str) -> SceneRun:
    source, *settings = SHIPPED[name]
    rows = [f"readout.ridges={list(TOLD)}", "effects.film={}", *settings]
    last = {row.partition("=")[0]: row for row in rows}
    scene = load_scene(source, [*last.values()]).with_(effects={"piezo": None})
    answer = at_level(scene, LEVELS[0])
    march = answer.march
    return SceneRun(
        seed, Skin(scene.design.name, scene.design, 4.0), 1.0, None, march.time, scene.readout.bandwidth_Hz,
        march.column("films"), answer.slipping, march.column("normal"), march.column("tangential"),
        answer.gross_slip_step, ((name, 0),), TOLD,
    )  # fmt: skip
