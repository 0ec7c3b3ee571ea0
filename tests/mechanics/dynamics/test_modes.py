"""Slow modes: their share of the compliance, exact steps, and marches with them against all masses."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from skincad.effects import ModalPad, condensed
from skincad.effects.moving import moving
from skincad.mechanics import (
    RETARDATION,
    Modes,
    at_points,
    default_sizes,
    layer_period,
    mode_step,
    resolved,
    sliding,
    slow_modes,
    triangles,
)
from skincad.scenes import March, Scene, energy, halts_of, load_scene, piece_for, slips_of
from skincad.scenes.march import march

FINENESS, ORDER = 0.2, 2
PULL = (
    "history.time_s=[0.0, 0.002, 0.008]",
    "history.normal_force_N=[0.0, 1.2, 1.2]",
    "history.tangential_force_N=[0.0, 0.0, 0.8]",
    "history.steps=200",
    "effects.friction.coefficient=0.6",
    "readout.ridges=[1, 2, 3]",
)


@cache
def scene() -> Scene:
    plain = load_scene("yamada-2002-slip")
    design = plain.design.with_(ridge={"count": 3}, skin={"width": 5.0})
    return load_scene("yamada-2002-slip", list(PULL), skin=design)


@cache
def parts(order: int = ORDER) -> tuple:  # type: ignore[type-arg]
    piece = piece_for(scene(), {})
    mesh = triangles(piece.pad, default_sizes(piece.pad, FINENESS))
    pad = condensed(sliding(piece, mesh, order, True))
    return piece, mesh, pad


@cache
def modes() -> Modes:
    piece, mesh, pad = parts()
    return slow_modes(piece, mesh, ORDER, True, pad.x, pad.ridge)


def test_they_are_a_part_of_the_static_compliance() -> None:
    """What is left of it is positive definite; of a shear of all points the slow modes are nearly all."""
    _, _, pad = parts()
    slow, whole = modes(), parts()[2].compliance
    rest = np.linalg.eigvalsh(whole - slow.compliance)
    assert rest.min() > 0
    m = pad.x.size
    shear = np.concatenate([np.ones(m), np.zeros(m)]) / m
    assert 0.8 < shear @ slow.compliance @ shear / (shear @ whole @ shear) < 1
    assert (np.diff(slow.frequency) >= 0).all()


def test_the_slowest_swings_about_as_a_layer() -> None:
    """A skin of finite width, and ridges on it: within 20 % of a quarter wave's period, measured 8 %."""
    period = 2 * np.pi / modes().frequency[0]
    assert period == pytest.approx(layer_period(scene().design), rel=0.2)


def test_on_other_points_they_stay_a_part_of_the_compliance() -> None:
    _, _, fine = parts(3)
    there = at_points(modes(), fine.x, fine.ridge)
    assert there.points.shape == (2 * fine.x.size, modes().frequency.size)
    assert np.linalg.eigvalsh(fine.compliance - there.compliance).min() > 0
    assert at_points(modes(), modes().x, modes().ridge) is modes()


def test_long_steps_resolve_fewer() -> None:
    _, _, pad = parts()
    counts = [resolved(modes(), pad.compliance, dt).frequency.size for dt in (1e-6, 1e-4, 3e-4, 1.0)]
    assert counts == sorted(counts, reverse=True)
    assert counts[0] == modes().frequency.size
    assert counts[-1] == 0


@pytest.mark.parametrize("dt", [1e-6, 1e-4, 3e-3])
def test_a_step_is_exact_for_a_force_straight_in_time(dt: float) -> None:
    """Of one mode from rest under a rising force; the closed form of a damped oscillator, d below 2 w."""
    w = 4000.0
    one = Modes(np.array([w]), np.ones((2, 1)), np.zeros((0, 3, 1)), np.zeros(1), np.ones(1, dtype=np.int64))
    step, d = mode_step(one, dt), RETARDATION * w**2
    count, rise = 40, 3.0
    state, force = np.zeros(2), 0.0
    for i in range(count):
        after = rise * dt * (i + 1)
        state = step.stays[0] @ state + step.before[0] * force + step.after[0] * after
        force = after
    t, z = count * dt, d / (2 * w)
    swing = w * np.sqrt(1 - z * z)
    fades = np.exp(-z * w * t)
    lag = d / w**2
    exact = (
        rise
        / w**2
        * (t - lag + fades * (lag * np.cos(swing * t) + (z * w * lag - 1) / swing * np.sin(swing * t)))
    )
    assert state[0] == pytest.approx(exact, rel=1e-6)


def run(pad: object, mass: float, *more: str) -> tuple[March, list[int | None], np.ndarray]:
    told = scene() if not more else scene().with_(plate={"mass": mass}, effects={name: {} for name in more})
    found = march(pad, told.history.times, told.history.drives(), told.terms, mass=mass)  # type: ignore[arg-type]
    films = found.column("films")[:, :, 0]
    return found, slips_of(found, 3, halts_of(scene())).steps, films[:, ::2] - films[:, 1::2]


@pytest.mark.evidence(subject="slow modes")
@pytest.mark.parametrize("mass", [1e-9, 0.2])
def test_a_march_is_that_with_all_masses(mass: float) -> None:
    """Slips to 3 of 200 steps, signals to 6 % of the largest before all slip; without masses they are off by
    more."""
    piece, mesh, pad = parts()
    slow = resolved(modes(), pad.compliance, scene().history.times[1])
    assert slow.frequency.size > 5
    modal, slips, felt = run(ModalPad(pad, slow, mass), mass)
    _, true, known = run(moving(piece, mesh, ORDER, True), mass, "inertia", "viscosity")
    still = run(pad, 0.0)[2]
    for one, other in zip(slips, true, strict=True):
        assert (one is None) == (other is None)
        assert one is None or other is None or abs(one - other) <= 3
    end = min(len(felt), len(known), len(still), *(step for step in true if step is not None))
    off, without = (
        np.abs(run_[:end] - known[:end]).max() / np.abs(known[:end]).max() for run_ in (felt, still)
    )
    assert off < 0.06
    assert off < without
    assert energy(modal)["imbalance"] < 5e-3


@pytest.mark.slow
def test_without_slow_modes_and_plate_it_is_the_still_pad() -> None:
    _, _, pad = parts()
    still, none = run(pad, 0.0), run(ModalPad(pad, modes().first(0)), 0.0)
    assert none[1] == still[1]
    assert none[2] == pytest.approx(still[2], abs=1e-12)
