"""Slow modes of a skin, and what rings about a load of straight lines: against equations of motion."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from skincad import load_design
from skincad import mechanics as mech
from skincad.effects import CondensedPad, ModalPad, MovingPad, PlatePath, plate_ringing
from skincad.inputs.material import silicone
from skincad.mechanics.dynamics import ringing
from skincad.scenes import March, Scene, energy, halts_of, load_scene, piece_for, slips_of
from skincad.scenes.march import march
from skincad.shape import section
from tests.mechanics.designs import filleted

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
    mesh = mech.triangles(piece.pad, mech.default_sizes(piece.pad, FINENESS))
    pad = CondensedPad(mech.sliding(piece, mesh, order, True))
    return piece, mesh, pad


@cache
def modes() -> mech.Modes:
    piece, mesh, pad = parts()
    return mech.slow_modes(piece, mesh, ORDER, True, pad.pad.x, pad.pad.ridge)


def test_they_are_a_part_of_the_static_compliance() -> None:
    """What is left of it is positive definite, on other points too; of a shear of all points the slow modes
    are nearly all. The slowest swings about as a layer: a skin of finite width, and ridges on it, within 20 %
    of a quarter wave's period, measured 8 %."""
    pad, fine = parts()[2].pad, parts(3)[2].pad
    slow, whole = modes(), parts()[2].compliance
    assert np.linalg.eigvalsh(whole - slow.compliance).min() > 0
    m = pad.x.size
    shear = np.concatenate([np.ones(m), np.zeros(m)]) / m
    assert 0.8 < shear @ slow.compliance @ shear / (shear @ whole @ shear) < 1
    assert (np.diff(slow.frequency) >= 0).all()
    assert 2 * np.pi / slow.frequency[0] == pytest.approx(mech.layer_period(scene().design), rel=0.2)
    there = mech.at_points(slow, fine.x, fine.ridge)
    assert there.points.shape == (2 * fine.x.size, slow.frequency.size)
    assert np.linalg.eigvalsh(fine.compliance - there.compliance).min() > 0
    assert mech.at_points(slow, slow.x, slow.ridge) is slow


def test_long_steps_resolve_fewer() -> None:
    _, _, pad = parts()
    counts = [mech.resolved(modes(), pad.compliance, dt).frequency.size for dt in (1e-6, 1e-4, 3e-4, 1.0)]
    assert counts == sorted(counts, reverse=True)
    assert counts[0] == modes().frequency.size
    assert counts[-1] == 0


def test_what_a_step_cannot_advance_is_not_looked_for() -> None:
    piece, mesh, pad = parts()
    fewer = mech.slow_modes(piece, mesh, ORDER, True, pad.pad.x, pad.pad.ridge, 3e-4)
    assert 0 < fewer.frequency.size < modes().frequency.size
    some, every = (mech.resolved(of, pad.compliance, 3e-4) for of in (fewer, modes()))
    assert some.frequency == pytest.approx(every.frequency, rel=1e-6)  # the eigenvalues' tolerance
    none = mech.slow_modes(piece, mesh, ORDER, True, pad.pad.x, pad.pad.ridge, 1.0)
    assert none.strips.shape == (modes().strips.shape[0], 3, 0)


@pytest.mark.parametrize("dt", [1e-6, 1e-4, 3e-3])
def test_a_step_is_exact_for_a_force_straight_in_time(dt: float) -> None:
    """Of one mode from rest under a rising force; the closed form of a damped oscillator, d below 2 w."""
    w = 4000.0
    one = mech.Modes(
        np.array([w]), np.ones((2, 1)), np.zeros((0, 3, 1)), np.zeros(1), np.ones(1, dtype=np.int64)
    )
    step, d = mech.mode_step(one, dt), mech.RETARDATION * w**2
    count, rise = 40, 3.0
    state, force = np.zeros(2), 0.0
    for i in range(count):
        after = rise * dt * (i + 1)
        state = step.stays[0] @ state + step.start[0] * force + step.end[0] * after
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
    slow = mech.resolved(modes(), pad.compliance, scene().history.times[1])
    assert slow.frequency.size > 5
    modal, slips, felt = run(ModalPad(pad, slow, mass), mass)
    _, true, known = run(
        MovingPad(mech.linear(piece, mesh, ORDER, True), piece), mass, "inertia", "viscosity"
    )
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


TURNS = np.array([0.0, 1e-3, 2.5e-3, 2.9e-3, 6e-3])
LOADS = np.array([0.0, 2.0, 2.0, -1.0, -0.5])


@pytest.mark.parametrize("damping", [0.0, 0.05, 0.6])
def test_ringing_is_what_the_equation_of_motion_gives(damping: float) -> None:
    ring = ringing.Ringer(3000.0, damping)

    def pushed(t: float, state: np.ndarray) -> list[float]:
        load = np.interp(t, TURNS, LOADS)
        return [state[1], ring.frequency**2 * (load - state[0]) - 2 * damping * ring.frequency * state[1]]

    times = TURNS[:, None] + np.linspace(0, 1, 7) * np.append(np.diff(TURNS), 3e-3)[:, None]
    motion = solve_ivp(pushed, (0, 9e-3), [0, 0], rtol=1e-9, atol=1e-12, max_step=2e-5, dense_output=True)
    x, speed = motion.sol(times.ravel()).reshape(2, *times.shape)
    lag = 2 * damping / ring.frequency * speed
    wanted = x + lag - np.interp(times, TURNS, LOADS)
    assert ring.rings(TURNS, LOADS, times) == pytest.approx(wanted, abs=1e-6)


def test_a_ramp_of_whole_periods_leaves_nothing() -> None:
    ring = ringing.Ringer(2 * np.pi * 500, 0.0)
    corners, values = np.array([0.0, 0.004]), np.array([0.0, 1.0])
    times = corners[:, None] + np.linspace(0, 2e-3, 41)
    during, after = np.abs(ring.rings(corners, values, times)).max(axis=1)
    assert after == pytest.approx(0, abs=1e-12)
    assert during == pytest.approx(1 / (2 * np.pi * 500 * 0.004), rel=1e-9)


def test_silicone_on_a_spring_is_damped_by_its_retardation() -> None:
    swing = ringing.ringer(4.0, 1e-6)
    assert swing.frequency == 2000.0
    assert swing.damping == pytest.approx(1000 * mech.RETARDATION)
    assert ringing.ringer(4e12, 1e-6).damping < 1


@pytest.mark.parametrize(
    ("name", "volume"),
    [
        # a block, and nine columns of their mean diameter; a disc, and five rings by Pappus
        ("pillars-9", 20 * 20 * 3 + math.pi / 4 * 3.2**2 * (5.0 + 8 * 4.7)),
        ("rings-5", math.pi * 12**2 * 4 + 1.25 * 1.0 * 2 * math.pi * (1 + 3 + 5 + 7 + 9)),
        ("yamada-2002", None),
    ],
)
def test_the_mass_is_that_of_block_or_disc_and_features(name: str, volume: float | None) -> None:
    """Rings lean by up to 3 degrees and stand 1 mm above the base circle: 0.5 % of their own volume."""
    design = load_design(name)
    base, ridge = design.skin, design.ridge
    if volume is None:
        high = ridge.count * ridge.height * (ridge.root_width + ridge.tip_width) / 2
        volume = (base.width * base.thickness + high) * base.length
    expected = 1e-6 * silicone(design).density * volume
    assert mech.skin_mass(design) == pytest.approx(expected, rel=2e-3)


DOWN, ALONG, MASS = 10.0, 4.0, 0.5  # N/mm, N/mm, g
TIME = np.linspace(0.0, 0.02, 401)
CORNERS = np.array([0.0, 0.002, 0.006, 0.007, 0.02])
NORMAL = np.array([0.0, 2.0, 2.0, 2.0, 2.0])
SIDEWAYS = np.array([0.0, 0.0, 0.0, 0.8, 0.8])
STILL = np.zeros_like(CORNERS)


TONNE = 1e-6  # of a gram


def springs(
    normal: np.ndarray = NORMAL, pull: np.ndarray = SIDEWAYS, corners: np.ndarray = CORNERS, ridges: int = 1
) -> PlatePath:
    """A pad of linear springs whose ridges share forces evenly."""
    down, along = np.interp(TIME, corners, normal), np.interp(TIME, corners, pull)
    pressed, pulled = (np.tile(of[:, None] / ridges, ridges) for of in (down, along))
    none = np.zeros_like(pressed)
    return PlatePath(TIME, down / DOWN, along / ALONG, pressed, pulled, none, none, none)


def felt_by_skin(stiffness: float, load: np.ndarray, times: np.ndarray) -> np.ndarray:
    """What the skin feels more than the load, N: the plate's own mass times its acceleration."""
    mass = TONNE * MASS * (1 + mech.FREE_TOP)

    def pushed(t: float, state: np.ndarray) -> list[float]:
        lack = np.interp(t, CORNERS, load) - stiffness * (state[0] + mech.RETARDATION * state[1])
        return [state[1], lack / mass]

    motion = solve_ivp(pushed, (0, TIME[-1]), [0, 0], rtol=1e-8, atol=1e-12, max_step=2e-5, dense_output=True)
    return np.array([-TONNE * MASS * pushed(t, motion.sol(t))[1] for t in times])


def test_a_plate_rings_as_a_mass_on_both_springs() -> None:
    swing = plate_ringing(springs(), CORNERS, (NORMAL, SIDEWAYS), False, MASS)
    some = slice(None, None, 9)
    assert swing.normal[some] == pytest.approx(felt_by_skin(DOWN, NORMAL, swing.time[some]), abs=1e-5)
    assert swing.pull[some] == pytest.approx(felt_by_skin(ALONG, SIDEWAYS, swing.time[some]), abs=1e-5)
    slow = 2 * math.pi * math.sqrt(TONNE * MASS * (1 + mech.FREE_TOP) / ALONG)
    assert swing.period == pytest.approx(slow, rel=1e-3)  # damped by 5 %


def test_the_skins_share_of_mass_is_that_of_a_bonded_layers_slowest_mode() -> None:
    """A layer of 2 mm, 10 x 12 mm wide, G 0.3 MPa, 1000 kg/m3: stiffness G A / h, mass rho A h."""
    stiffness, mass = 0.3 * 120 / 2, 1e-12 * 1000 * 120 * 2
    assert math.sqrt(stiffness / (mech.FREE_TOP * mass)) / (2 * math.pi) == pytest.approx(
        mech.shear_frequency(0.3, 1000, 2.0)
    )


def test_a_driven_layer_meets_a_change_of_speed_with_its_impedance() -> None:
    """rho c A is the root of stiffness times mass; 2 / pi of it is the first mode's, half a wave high."""
    moves = SIDEWAYS / ALONG
    swing = plate_ringing(springs(), CORNERS, (STILL, moves), True, MASS)
    assert not swing.normal.any()
    assert swing.period == pytest.approx(2 * math.sqrt(TONNE * MASS / ALONG), rel=1e-2)  # 2 h / c
    speed = moves[3] / (CORNERS[3] - CORNERS[2])
    first = (swing.time >= CORNERS[2]) & (swing.time <= CORNERS[2] + swing.period / 3)
    wanted = 2 / math.pi * math.sqrt(ALONG * TONNE * MASS) * speed
    damping = math.pi * math.sqrt(ALONG / (TONNE * MASS)) * mech.RETARDATION / 2
    wanted *= math.exp(-damping * math.pi / 2)  # what is left after a quarter of a period
    # 2 %: looked at 32 times a period, and the peak comes a little early
    assert swing.pull[first].max() == pytest.approx(wanted, rel=0.02)


def test_corners_without_a_change_or_that_the_march_did_not_reach_do_not_count() -> None:
    assert plate_ringing(springs(STILL, STILL), CORNERS, (STILL, STILL), False, MASS) is None
    short = PlatePath(*(of[:60] for of in vars(springs()).values()))
    swing = plate_ringing(short, CORNERS, (NORMAL, SIDEWAYS), False, MASS)
    assert swing.time.max() <= short.time[-1]
    assert not swing.pull.any()


def test_a_plate_neither_lifts_the_skin_nor_pulls_more_than_friction_holds() -> None:
    quick = CORNERS * [1, 0.1, 1, 1, 1]
    on = springs(NORMAL, SIDEWAYS, quick, 2)
    swing = plate_ringing(on, quick, (3 * NORMAL, SIDEWAYS), False, MASS)
    down, sideways = np.array([[1.0, 1.0], [0.0, 0.0]]), np.array([[0.0, 0.0], [1.0, 1.0]])
    lifted, highest = swing.normal.min(), swing.normal.max()
    assert lifted < -2.0  # N, of which the skin bears two: it is left, no more
    assert swing.signals(on, down, 10.0) == pytest.approx(max(highest, 2.0) / 2, rel=1e-6)
    loose, sticking = (swing.signals(on, sideways, mu) for mu in (0.41, 100.0))
    assert loose < sticking
    assert sticking == pytest.approx(np.abs(swing.pull).max() / 2, rel=1e-6)


def test_a_skin_weighs_its_section_times_its_length() -> None:
    """To 3 %: base and ridges are taken as flat, without crowns and fillets."""
    design = filleted()
    wanted = 1e-6 * silicone(design).density * section(design).area * design.skin.length
    assert mech.skin_mass(design) == pytest.approx(wanted, rel=0.03)
