"""A plate that turns: a plane that rolls on a circle, a turned frame, work and its balance."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from skincad.effects import CondensedPad, Share, Step, condensed
from skincad.mechanics import ContactPad, ContactState, Drive, FrictionCoefficients
from skincad.mechanics.film import turning
from tests.mechanics.film.test_sliding import meshed

RADIUS, SPACING = 60.0, 0.05


def stiff_circle() -> CondensedPad:
    """Points on a circle, each on stiff springs of its own."""
    angle = np.arange(-80, 81) * SPACING / RADIUS
    x, gap = RADIUS * np.sin(angle), 2 * RADIUS * np.sin(angle / 2) ** 2
    none = np.zeros((0, 3, 2 * x.size))
    ridge = np.ones(x.size, dtype=np.int64)
    return condensed(ContactPad(1e-9 * np.eye(2 * x.size), gap, x, ridge, np.ones(x.size), none, 1))


def marched(model: CondensedPad, drives: list[Drive], cone: FrictionCoefficients) -> list[ContactState]:
    states = [model.start()]
    for before, after in pairwise(drives):
        states.append(model.advanced(states[-1], Step(0.0, 1.0, before, after), [Share(cone)]))
    return states


@pytest.mark.parametrize("way", [1, -1])
def test_a_plane_rolls_on_a_circle(way: int) -> None:
    """By hand: it travels R (sin a - a) along itself, a being minus its angle, and slips nowhere."""
    last = math.radians(3.0)
    drives = [Drive(0.0, 0.0), Drive(1.0, 0.0)]
    drives += [Drive(1.0, 0.0, angle=way * last * i / 300) for i in range(1, 301)]
    states = marched(stiff_circle(), drives, FrictionCoefficients(1.0, 1.0))
    rolled = -way * last
    # points on chords of 0.05 mm instead of the circle: (0.05 / 60)^2 / 24 of the way rolled
    assert states[-1].travel == pytest.approx(RADIUS * (math.sin(rolled) - rolled), abs=1e-5)
    assert abs(states[-1].travel) > 1e-3
    assert not any(state.slips.any() for state in states[2:])
    middle = stiff_circle().pad.x @ states[-1].normal
    # where a polygon's corner meets the plate: to half a chord
    assert middle == pytest.approx(RADIUS * math.sin(rolled), abs=SPACING)


def test_the_frame_turns_with_the_plate() -> None:
    """Against vectors written out: how a force along the plate and one along its normal move the skin."""
    pad, angle = meshed()[2], math.radians(4.0)
    m, seen = pad.gap.size, turning.rotated_pad(meshed()[2], angle)
    along, normal = (
        np.array([math.cos(angle), math.sin(angle)]),
        np.array([-math.sin(angle), math.cos(angle)]),
    )
    force = np.random.default_rng(1).normal(size=(m, 2))  # along, normal
    plain = force[:, :1] * along + force[:, 1:] * normal
    assert turning.in_skin_axes(force.T.ravel(), angle) == pytest.approx(plain.T.ravel(), abs=1e-14)
    moved = (pad.compliance @ plain.T.ravel()).reshape(2, m).T
    expected = np.concatenate([moved @ along, moved @ normal])
    # rounding
    assert seen.compliance @ force.T.ravel() == pytest.approx(expected, abs=1e-12 * np.abs(expected).max())
    place = np.column_stack([pad.x, -pad.gap])
    below = -(place @ normal)
    assert seen.gap == pytest.approx(below - below.min(), abs=1e-12)
    assert seen.free[:m] == pytest.approx(place @ along - pad.x, abs=1e-12)
    assert not seen.free[m:].any()


def test_a_turned_plate_is_a_turned_pull() -> None:
    """A bonded plate that turned by a, pressed along its normal: the same forces as seen by the fixed one."""
    model = stiff_circle()
    one = model.pad
    point = replace(
        one,
        compliance=np.diag([0.3, 0.1]),
        gap=np.zeros(1),
        x=np.zeros(1),
        ridge=one.ridge[:1],
        weight=one.weight[:1],
        strips=np.zeros((0, 3, 2)),
    )
    angle = math.radians(5.0)
    drives = [Drive(0.0, 0.0), Drive(0.0, 0.0, angle=angle), Drive(2.0, 0.5, angle=angle)]
    state = marched(condensed(point), drives, FrictionCoefficients(1.0, 1.0))[-1]
    x = 2.0 * math.sin(angle) + 0.5 * math.cos(angle)
    z = -2.0 * math.cos(angle) + 0.5 * math.sin(angle)
    by_hand = np.array([0.3 * x, 0.1 * z])
    assert state.approach == pytest.approx(by_hand @ [math.sin(angle), -math.cos(angle)], rel=1e-12)
    assert state.travel == pytest.approx(by_hand @ [math.cos(angle), math.sin(angle)], rel=1e-12)


def test_work_is_what_is_stored_and_lost() -> None:
    """Forces and moment at their mean over a step: what is missing falls with the steps' square."""

    def missing(steps: int) -> float:
        pad = meshed()[2]
        drives = [Drive(1.2 * i / steps, 0.0) for i in range(steps + 1)]
        drives += [Drive(1.2, 0.0, angle=math.radians(2.0) * i / steps) for i in range(1, steps + 1)]
        model = condensed(pad)
        states = marched(model, drives, FrictionCoefficients(0.0, 0.0))
        readings = [model.reading(a, b) for a, b in pairwise([states[0], *states])]
        press_work = 0.5 * sum(
            (a.normal + b.normal) * (b.approach - a.approach) for a, b in pairwise(readings[: steps + 1])
        )
        work = press_work + sum(reading.work or 0.0 for reading in readings)
        turned_work = sum(reading.work or 0.0 for reading in readings)
        assert abs(turned_work) > 0.01 * press_work
        return abs(work - readings[-1].elastic) / work

    coarse, fine = missing(20), missing(40)
    assert fine < 5e-4
    # points close within steps: between first and second order
    assert fine < 0.6 * coarse
