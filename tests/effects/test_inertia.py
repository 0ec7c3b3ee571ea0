"""Masses in scenes: the drop, and the slip story with a plate's mass."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest

from skincad.scenes import LEVELS, Simulation, at_level, load_scene
from tests.small_scene import last_of_each, small_scene

INERTIA = ("effects.inertia={}", "effects.viscosity={}")
LONGER = (  # the pull goes on for 1 ms: masses are late
    "history.steps=650",
    "history.time_s=[0.0, 0.001, 0.002, 0.003, 0.0033, 0.0045, 0.0055, 0.0065]",
    "history.normal_force_N=[0.0, 4.0, 4.0, 4.0, 4.0, 4.0, 4.0, 4.0]",
    "history.tangential_force_N=[0.0, 0.0, 3.4, 3.4, 2.6, 3.2, 4.0, 4.8]",
)


@pytest.mark.slow
def test_undamped_masses_are_warned_of(tmp_path: Path) -> None:
    short = (
        *("history.time_s=[0.0, 0.001, 0.002]", "history.normal_force_N=[0.0, 1.2, 1.2]"),
        *("history.tangential_force_N=[0.0, 0.0, 0.5]", "history.steps=2", "plate.mass=0.1"),
        *("effects.film=none", "effects.small_strain.masses=false", "readout.ridges=[]"),
    )

    def run(*more: str) -> Simulation:
        return at_level(small_scene(tmp_path, "yamada-2002-press-and-pull", *short, *more), LEVELS[0])

    bare = run("effects.inertia={}")
    assert any("nothing damps the masses" in warning for warning in bare.warnings)
    damped = run(*INERTIA)
    assert not any("nothing damps" in warning for warning in damped.warnings)
    assert bare.energy["kinetic_mJ"] > 0
    assert damped.energy["viscous_mJ"] > 0


@cache
def slipped(*more: str) -> Simulation:
    return at_level(load_scene("yamada-2002-slip", last_of_each(*LONGER, *more)), LEVELS[0])


@pytest.mark.evidence(subject="masses: slip and drop")
def test_a_light_plate_keeps_the_story_and_a_heavy_one_hides_it() -> None:
    """At 0.1 g ridges slip from outside inward, 0.1 to 0.7 ms late; at 1 g the plate bounces on the skin, and
    all slips as soon as the pull meets a low of its normal force, before half of the paper's time.

    The march goes on after gross slip; 1e-3 of the work is the issue's.
    """
    light = slipped(*INERTIA, "plate.mass=0.1")
    first = light.slip_steps
    for side in ((1, 2, 3), (7, 6, 5)):
        steps = [first[i] for i in side]
        assert None not in steps
        assert steps[-1] > steps[0]
    assert light.gross_slip_step is not None
    assert 550 < light.gross_slip_step < 600
    heavy = slipped(*INERTIA, "plate.mass=1.0")
    assert heavy.gross_slip_step is not None
    assert heavy.gross_slip_step < 300
    for simulation in (light, heavy):
        assert simulation.march.stopped is None
        assert len(simulation.march.readings) == 651
        assert simulation.energy["imbalance"] < 1e-3
        assert simulation.march.column("residual").max() <= 1e-10


@pytest.mark.evidence(subject="masses: slip and drop")
def test_drop_keeps_its_energy() -> None:
    simulation = at_level(load_scene("drop"), LEVELS[0])
    assert simulation.march.stopped is None
    assert simulation.energy["imbalance"] < 1e-3
    # twice the weight, and more: it falls on the skin
    assert simulation.march.column("normal").max() > 6.0
