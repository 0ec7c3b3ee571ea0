"""The scenes that ship, and four pulls and presses of a few ms: in the design set, as they always were."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from bench.exam.scenes import SceneRun
from bench.exam.skins import Skin
from skincad.scenes import LEVELS, at_level, load_scene

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
    """Return the marches, kept on disk; their seeds are below 0."""
    return [_kept(-i, name, folder) for i, name in enumerate(SHIPPED, 1)]


def _kept(seed: int, name: str, folder: Path) -> SceneRun:
    path, (source, *settings) = folder / f"{-seed}.npz", SHIPPED[name]
    rows = [f"readout.ridges={list(TOLD)}", "effects.film={}", *settings]
    last = {row.partition("=")[0]: row for row in rows}
    scene = load_scene(source, [*last.values()]).with_(effects={"piezo": None})
    if not path.exists():
        answer = at_level(scene, LEVELS[0])
        march = answer.march
        folder.mkdir(parents=True, exist_ok=True)
        np.savez_compressed(
            path, time=march.time, stress=march.column("films"), slipping=answer.slipping,
            normal=march.column("normal"), tangential=march.column("tangential"),
            gross=-1 if answer.gross_slip_step is None else answer.gross_slip_step,
        )  # fmt: skip
    with np.load(path) as data:
        gross = int(data["gross"])
        return SceneRun(
            seed, Skin(scene.design.name, scene.design, 4.0), 1.0, None, data["time"],
            scene.readout.bandwidth_Hz, data["stress"], data["slipping"], data["normal"],
            data["tangential"], None if gross < 0 else gross, ((name, 0),), TOLD,
        )  # fmt: skip
