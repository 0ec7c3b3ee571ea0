"""What is told of a condensed pad's state: the work that friction takes, from points on springs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from skincad.effects import Share, Step, condensed
from skincad.mechanics import ContactPad, Drive, FrictionCoefficients

FLEXIBLE = 0.25  # mm/N


def springs() -> ContactPad:
    """Two points at the same height on springs of their own, alike in x and in z."""
    one, two = np.eye(4), np.zeros(2)
    ridge = np.array([0, 1])
    return ContactPad(FLEXIBLE * one, two, np.array([-1.0, 1.0]), ridge, np.ones(2), np.zeros((0, 3, 4)), 4)


@pytest.mark.parametrize("coefficient", [0.2, 0.7])
def test_friction_takes_what_the_plate_gives_and_no_spring_keeps(coefficient: float) -> None:
    """The plate's work in x is what springs keep and friction takes; friction takes mu N times the slide."""
    skin, cone = condensed(springs()), FrictionCoefficients(coefficient, coefficient)
    state = skin.start()
    drives = [Drive(2.0, travel=0.0), *(Drive(2.0, travel=0.05 * i) for i in range(1, 41))]
    before, dissipated, work = Drive(0.0, travel=0.0), 0.0, 0.0
    for drive in drives:
        step = Step(0.0, 1.0, before, drive, 0.0)
        after = skin.advanced(state, step, [Share(cone=cone)])
        reading = skin.reading(state, after)
        work += (after.travel - state.travel) * (state.tangential.sum() + after.tangential.sum()) / 2
        dissipated += reading.dissipated
        state, before = after, drive
    limit = coefficient * 2.0  # N, on both points together
    stretched = FLEXIBLE * limit / 2
    assert dissipated == pytest.approx(limit * (2.0 - stretched), rel=0.05)
    assert work == pytest.approx(dissipated + limit * stretched / 2, rel=1e-9)


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize(
    ("before", "after", "mean"),
    [
        (0.2, 0.6, 0.4),
        (0.6, 0.0, 0.3),  # at the step's end it carries nothing
        (0.0, 0.6, 0.3),
        (-0.2, 0.6, 0.6),  # the force turned round before the point slipped, and dragged it all the way
    ],
)
def test_friction_takes_the_mean_force_of_a_step_times_the_slide(
    before: float, after: float, mean: float, way: float
) -> None:
    skin, slid = condensed(springs()), 0.1
    first, last = skin.start(), skin.start()
    first = replace(first, tangential=way * np.array([before, 0.0]) + 0.0, normal=np.array([2.0, 2.0]))
    last = replace(
        last,
        tangential=way * np.array([after, 0.1]) + 0.0,  # a freed point's is 0, not -0
        normal=np.array([2.0, 1.0]),
        slipped=-way * np.array([slid, 0.0]),
        residual=1e-11,
    )
    reading = skin.reading(first, last)
    assert reading.dissipated == pytest.approx(mean * slid, rel=1e-12)
    assert (reading.normal, reading.tangential) == (pytest.approx(3.0), pytest.approx(way * (after + 0.1)))
    # what the springs hold: half of flexibility times force squared, in both directions
    assert reading.elastic == pytest.approx(FLEXIBLE / 2 * (2.0**2 + 1.0**2 + after**2 + 0.1**2), rel=1e-12)
    assert reading.residual == 1e-11
    assert reading.work is None  # the plate does not turn
