"""A scene on ridges of unlike height: turned round and pulled the other way it is the same."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from skincad.inputs import template_text
from skincad.scenes import LEVELS, at_level, load_scene
from tests.small_scene import small_skin


def marched(folder: Path, heights: list[float], pull: float) -> list[tuple[float, float, float]]:
    """Normal force, approach and travel at each step."""
    text = small_skin(template_text("yamada-2002")).replace("height = 0.5 ", f"heights = {heights} ")
    (folder / "skin.toml").write_text(text)
    settings = [
        "skin=skin.toml",
        "history.normal_force_N=[0.0, 1.3, 1.3]",
        f"history.tangential_force_N=[0.0, 0.0, {pull}]",
        *("history.steps=8", "effects.film=none", "readout.ridges=[]"),
    ]
    (folder / "scene.toml").write_text(template_text("yamada-2002-press-and-pull", "scenes"))
    march = at_level(load_scene(folder / "scene.toml", settings), LEVELS[0]).march
    return [(r.normal, r.approach, r.travel) for r in march.readings]


@pytest.mark.slow
def test_a_skin_turned_round_and_pulled_the_other_way_moves_alike(tmp_path: Path) -> None:
    one = np.array(marched(tmp_path, [0.49, 0.5, 0.504], 0.3))
    other = np.array(marched(tmp_path, [0.504, 0.5, 0.49], -0.3)) * [1, 1, -1]
    # the coarsest meshes: each is off by some tenths of a percent, and not its own mirror image
    assert one == pytest.approx(other, rel=0.01, abs=1e-4)
    assert abs(one[-1, 2]) > 1e-2
