"""Films in a scene: loose ones leave empty slots, which carry nothing and may close."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from skincad.effects import LeftOutEffect
from skincad.effects.film import OF_PRESSURE, OF_SHEAR, FilmStrips
from skincad.inputs import Design
from skincad.mechanics import mean_width
from skincad.mechanics.check import check
from skincad.scenes import LEVELS, at_level
from tests.mechanics.designs import yamada
from tests.outlines import outline
from tests.refusals import refused
from tests.small_scene import THIRD, small_scene

LOOSE = ("effects.film.bond=loose", "readout.ridges=[]", "effects.friction=none")


@pytest.mark.slow
def test_a_loose_film_leaves_the_slots_empty(tmp_path: Path) -> None:
    """A scene's last step against the linear model."""
    scene = small_scene(tmp_path, "yamada-2002-press", THIRD, "history.steps=2", *LOOSE)
    here = at_level(scene, LEVELS[1]).march.readings[-1].approach
    there = check(scene.design.with_(contact={"film": "loose"}), force=1.3, model="linear").approach.value
    press = ("yamada-2002-press", THIRD, "history.steps=2", "readout.ridges=[]")
    bonded = at_level(small_scene(tmp_path, *press), LEVELS[0])
    # two meshes and orders: 0.5 % is the model's own; bonded strips make 4 % of difference
    assert here == pytest.approx(there, rel=5e-3)
    assert bonded.march.readings[-1].approach < 0.99 * here


def test_slots_that_close_end_the_march_at_the_same_force_however_it_is_stepped(tmp_path: Path) -> None:
    """Nothing looks at each step: where slots are found closed at the end, the march says when they did."""
    closed = []
    for peak, steps in ((6.0, 24), (7.0, 28), (7.0, 280)):  # steps of 0.25 and of 0.025 N
        press = f"history.normal_force_N=[0.0, {peak}]", f"history.steps={steps}"
        march = at_level(small_scene(tmp_path, "yamada-2002-press", *press, *LOOSE), LEVELS[0]).march
        at = len(march.readings)
        assert march.failed
        assert march.stopped.startswith(f"step {at}, t = {march.time[-1] + 0.1 / steps:.6g} s: ")
        assert march.stopped.endswith("two ridges meet or a slot closes")
        closed.append(peak / steps * at)
    assert closed[0] == pytest.approx(closed[1], rel=1e-12)
    assert closed[2] == pytest.approx(closed[1], abs=0.25)  # the coarser steps


@pytest.mark.parametrize(
    ("overrides", "words"),
    [
        (["readout.ridges=[2]"], "readout.ridges: needs films' stresses, which effects.film does not give"),
        (["readout.ridges=[]", "effects.piezo.circuit=yamada-2002"], "effects.piezo: needs films' stresses"),
    ],
)
def test_a_loose_film_feels_nothing_to_read(tmp_path: Path, overrides: list[str], words: str) -> None:
    with refused(words):
        small_scene(tmp_path, "yamada-2002-press", "effects.film.bond=loose", *overrides)


def test_bonded_strips_and_slots_full_of_silicone_differ(tmp_path: Path) -> None:
    """What the strips feel is not the silicone's stress in their place: they are 3750 times as stiff."""
    press = ("yamada-2002-press", THIRD, "history.steps=2", "readout.ridges=[1]")
    strip, silicone = (
        at_level(small_scene(tmp_path, *press, *more), LEVELS[0]) for more in ((), ("effects.film=none",))
    )
    assert not np.allclose(strip.raw[1], silicone.raw[1], rtol=0.1)
    assert any("film is not named" in warning for warning in silicone.warnings)


def said(pull: float, design: Design) -> LeftOutEffect:
    entry = FilmStrips.left_out(outline(design, (0.0, 1.0), (0.0, 4.0), (0.0, pull)))
    assert entry is not None
    return entry


def test_what_leaving_films_out_changes_goes_by_load_and_bluntness() -> None:
    """S1 - S2 is 2 MPa per N of a ridge's pull; of that, what shear and pressure make of blunt ends."""
    design = yamada()
    assert design.film is not None
    assert design.slot is not None
    area, pull, force = mean_width(design) * design.skin.length, 0.5 / 9, 4.0 / 9
    blunt = math.sqrt(design.film.thickness / design.slot.depth)
    wanted = blunt * (OF_SHEAR * pull + OF_PRESSURE * force) / area / (2 * pull)
    assert said(0.5, design).change == pytest.approx(wanted)
    thick = design.with_(film={"thickness": design.film.thickness / 4})
    assert said(0.5, thick).change == pytest.approx(wanted / 2)


def test_without_a_pull_it_is_less_sure() -> None:
    assert said(0.5, yamada()).within == 3.0
    assert said(0.0, yamada()).within == 4.0
