"""Films in a scene: loose ones leave empty slots, which carry nothing and may close."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from skincad.errors import InputError
from skincad.levels import LEVELS
from skincad.mechanics.check import check
from skincad.simulation import at_level
from tests.small_scene import THIRD, small_scene

LOOSE = ("effects.film.bond=loose", "readout.ridges=[]", "effects.friction=none")


def pressed(folder: Path, *overrides: str) -> tuple[float, float, tuple[str, ...]]:
    """Approach of the scene's last step and of the linear tier, and the scene's warnings."""
    scene = small_scene(folder, "yamada-2002-press", THIRD, "history.steps=2", *LOOSE, *overrides)
    found = at_level(scene, LEVELS[1])
    other = check(scene.design.with_(contact={"film": "loose"}), force=1.3, tier="linear")
    return found.march.readings[-1].approach, other.approach.value or 0.0, found.warnings


def test_a_loose_film_leaves_the_slots_empty(tmp_path: Path) -> None:
    here, there, _ = pressed(tmp_path)
    press = ("yamada-2002-press", THIRD, "history.steps=2", "readout.ridges=[]")
    bonded = at_level(small_scene(tmp_path, *press), LEVELS[0])
    # two meshes and orders: 0.5 % is the tier's own; bonded strips make 4 % of difference
    assert here == pytest.approx(there, rel=5e-3)
    assert bonded.march.readings[-1].approach < 0.99 * here


def test_slots_that_close_are_warned_of(tmp_path: Path) -> None:
    assert not any("slot" in warning for warning in pressed(tmp_path)[2])
    hard = "history.normal_force_N=[0.0, 9.0]"
    assert any("no model of contact there" in warning for warning in pressed(tmp_path, hard)[2])


@pytest.mark.parametrize(
    ("overrides", "words"),
    [
        (["readout.ridges=[2]"], "readout.ridges: asks for films' stresses, and effects.film leaves"),
        (["readout.ridges=[]", "effects.piezo.circuit=yamada-2002"], "effects.piezo: reads films' stresses"),
    ],
)
def test_a_loose_film_feels_nothing_to_read(tmp_path: Path, overrides: list[str], words: str) -> None:
    with pytest.raises(InputError) as refusal:
        small_scene(tmp_path, "yamada-2002-press", "effects.film.bond=loose", *overrides)
    assert words in str(refusal.value)


def test_bonded_strips_and_slots_full_of_silicone_differ(tmp_path: Path) -> None:
    """What the strips feel is not the silicone's stress in their place: they are 3750 times as stiff."""
    press = ("yamada-2002-press", THIRD, "history.steps=2", "readout.ridges=[1]")
    strip, silicone = (
        at_level(small_scene(tmp_path, *press, *more), LEVELS[0]) for more in ((), ("effects.film=none",))
    )
    assert not np.allclose(strip.raw[1], silicone.raw[1], rtol=0.1)
    assert any("film is not named" in warning for warning in silicone.warnings)
