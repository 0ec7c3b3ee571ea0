"""Free ends in a scene: the corrected model's approach and shares, and what they may not be named with."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import skincad
from skincad.base import InputError
from skincad.mechanics import added_compliance
from skincad.scenes import LEVELS, at_level, load_scene
from tests.small_scene import THIRD, small_scene

PRESS = ("yamada-2002-press", THIRD, "history.steps=2", "effects.friction=none", "readout.ridges=[]")
ENDS = "effects.free_ends={}"


def shares(simulation: object) -> np.ndarray:
    state, ridge = simulation.march.states[2], simulation.march.ridge
    return np.array([state.normal[ridge == r].sum() for r in np.unique(ridge)])


@pytest.mark.slow
def test_approach_and_shares_are_the_corrected_models(tmp_path: Path) -> None:
    scene = small_scene(tmp_path, *PRESS, ENDS)
    plane, simulation = at_level(small_scene(tmp_path, *PRESS), LEVELS[1]), at_level(scene, LEVELS[1])
    model = skincad.check(scene.design.with_(contact={"film": "bonded"}), force=1.3, model="corrected")
    wanted = np.array([force.value for force in model.ridge_force])
    approach = model.approach.value
    # 1 %: nine ridges agree to 0.6 % (ends.py), the model's own error is 0.5 %
    assert simulation.march.readings[-1].approach == pytest.approx(approach, rel=0.01)
    assert shares(simulation) == pytest.approx(wanted, abs=0.01 * wanted.mean())
    # and it is the ends that do it
    assert plane.march.readings[-1].approach < 0.95 * approach


@pytest.mark.evidence(subject="free ends of scenes")
def test_outer_ridges_of_nine_bear_more(tmp_path: Path) -> None:
    """plain-ridges at 4 N: the outer ridge's share doubles. Measured 0.25 % and 0.32 % (ends.py)."""
    scene = ("yamada-2002-press", ["skin=plain-ridges", "history.steps=2", "effects.film=none"])
    bare = ["effects.friction=none", "readout.ridges=[]"]
    plane, simulation = (
        at_level(load_scene(scene[0], [*scene[1], *bare, *more]), LEVELS[1]) for more in ([], [ENDS])
    )
    design = simulation.scene.design.with_(contact={"friction": 0.0})
    model = skincad.check(design, force=4.0, model="corrected")
    wanted = np.array([force.value for force in model.ridge_force])
    assert simulation.march.readings[-1].approach == pytest.approx(model.approach.value, rel=0.005)
    assert shares(simulation) == pytest.approx(wanted, abs=0.005 * wanted.mean())
    assert shares(plane)[0] < 0.6 * wanted[0]


@pytest.mark.slow
def test_ends_soften_a_pad_the_less_the_longer_it_is(tmp_path: Path) -> None:
    design = small_scene(tmp_path, *PRESS).design.with_(slot=None)
    by_length = [added_compliance(design.with_(skin={"length": length})) for length in (6.0, 12.0, 24.0)]
    for more in by_length:
        assert np.linalg.eigvalsh(more).min() >= -1e-9 * more.max()
        assert (more == more[::-1, ::-1]).all()
    # two ends: of what a pad of length L adds per N, the half is left at 2 L, and the force spreads on 2 L
    first, second, third = (float(more.sum()) for more in by_length)
    assert second < 0.5 * first
    assert third < 0.5 * second


def test_ends_are_not_known_with_a_past(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"effects\.free_ends: does not work together with"):
        small_scene(tmp_path, *PRESS, ENDS, "effects.viscosity.retardation_time=1e-4")


@pytest.mark.evidence(subject="free ends of scenes")
def test_at_finite_strain_ends_add_what_they_add_at_small_strain(tmp_path: Path) -> None:
    """Under a force that one ridge bears: as much more approach, by both ways of steps; rounding."""
    light = (*PRESS[:1], "history.normal_force_N=[0.0, 0.013]", *PRESS[2:])
    for law in ((), ("effects.finite_strain.steps=all",), ("effects.finite_strain.steps=chosen",)):
        plane, free = (
            at_level(small_scene(tmp_path, *light, *law, *more), LEVELS[0]) for more in ((), (ENDS,))
        )
        sunk = free.march.readings[-1].approach - plane.march.readings[-1].approach
        assert sunk == pytest.approx(0.013 * added_compliance(free.scene.design)[1, 1], rel=1e-6)
        assert free.march.loads[-1, 0] == pytest.approx([0.0, 0.013, 0.0], rel=1e-9, abs=1e-12)
