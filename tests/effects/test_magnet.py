"""Magnetometers under pins in a scene: fields, noise, rounding, range, forces and slips; what is refused."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import skincad
from skincad.effects import magnet
from skincad.effects.magnet import force_estimates
from skincad.mechanics import magnetic_pins, magnetics
from skincad.outputs import write_table
from skincad.scenes import Scene, Simulation, load_scene, marched, read_out
from tests.refusals import refused_by

pytestmark = pytest.mark.slow
QUIET = {"noise": 0.0, "rate": 1000.0, "resolution": 0.0}


def pull(**sensors: Any) -> Scene:
    """The template's scene, its sensors changed, without noise unless a seed is given."""
    seed = {"noise_seed": sensors.pop("seed")} if "seed" in sensors else {}
    scene = load_scene("magnet-pillars-pull")
    design = scene.design.with_(magnetometer=sensors) if sensors else scene.design
    return Scene(
        name="pull",
        skin=design,
        history=scene.history,
        effects={"friction": {"coefficient": 0.3}, "magnet": seed},
    )


@cache
def run() -> Any:
    """The march, which no sensor changes."""
    return marched(pull())


def reading(**sensors: Any) -> Simulation:
    return read_out(pull(**sensors), run())


def by_number(result: Simulation, key: str) -> np.ndarray:
    """A readout `(steps, m, 3)`."""
    rows = [[owner[axis] for axis in "xyz"] for owner in result.read[key].values()]
    return np.moveaxis(np.array(rows), 2, 0)


def tips(result: Simulation) -> np.ndarray:
    return np.array([one.tips for one in result.march.readings])


def test_without_noise_readings_tell_the_forces_of_the_march() -> None:
    """To half of the last correction, a millionth of the largest force. The field starts as that of a check
    at rest."""
    result = reading(**QUIET)
    told = by_number(result, "pin_force_N")
    np.testing.assert_allclose(told, tips(result), atol=0.5e-6 * np.abs(tips(result)).max())
    np.testing.assert_allclose(tips(result)[:, :, 2].sum(axis=1), -result.normal_force, atol=1e-9)
    np.testing.assert_allclose(tips(result)[:, :, 0].sum(axis=1), result.tangential_force, atol=1e-9)
    check = skincad.check(result.scene.design)
    rest = np.array([[b.value for b in sensor.rest] for sensor in check.magnet.sensors])
    np.testing.assert_allclose(by_number(result, "field_mT")[0], rest, atol=1e-9)


def test_a_pressed_pin_sways_more_than_the_map_says() -> None:
    """The magnets go by the map's forces over what the press leaves of a pin's stiffness, tips.py."""
    from skincad.effects.pin_pad import pin_pad

    result = reading(**QUIET)
    design, last = result.scene.design, tips(result)[-1]
    more = 1 / (1 - pin_pad(design).tips.sway(-last[:, 2]))
    assert (more > 1.0).all()
    every = magnetic_pins(design)
    field = every.fields(every.poses(last * np.stack([more, more, 0 * more + 1], axis=1))).sum(axis=1)
    np.testing.assert_allclose(by_number(result, "field_mT")[-1], field, atol=1e-9)


def test_the_maps_error_is_that_of_readings_of_pins_unlike_the_map() -> None:
    """300 draws of ways, tilts and remanence, each pin's by itself, by which a standard deviation is off by
    4 %; what is not linear in errors of 8 % is as much again."""
    load, every = tips(reading(**QUIET))[-1], magnetic_pins(pull(**QUIET).design)
    poses, rng = every.poses(load), np.random.default_rng(5)
    rest, way, both = (every.fields(poses * part) for part in (0.0, magnetics.WAY, 1.0))
    own, sensors = (lambda load, _: (load, np.zeros((9, 6)))), pull(**QUIET).design.magnetometer
    off, within = [], np.ones(9, dtype=bool)
    for _ in range(300):
        ways, tilts, strength = rng.normal(1.0, [[magnetics.MOVES], [magnetics.TILTS], [0.0422]], (3, 9))
        seen = rest + ((way - rest) * ways[:, None] + (both - way) * tilts[:, None]) * strength[:, None]
        told = force_estimates(seen.sum(axis=1)[None], [None], every, own, sensors, within)
        off.append(told.forces[0] - load)
    assert every.spread + magnetics.RECOIL == pytest.approx(0.0422, abs=1e-4)
    assert np.std(off, axis=0).max() == pytest.approx(told.error, rel=0.15)


@cache
def bent(grip: float) -> tuple[Simulation, Simulation]:
    """The same in small and at finite strain, without noise, pressed by `grip` N and pulled by 0.2 of it."""
    history = {"steps": 40, "normal_force_N": [0.0, grip, grip], "tangential_force_N": [0.0, 0.0, 0.2 * grip]}
    quiet = pull(**QUIET).with_(history=history)
    finite = quiet.with_(effects={"finite_strain": {"steps": "chosen"}})
    return skincad.simulate(quiet, model="small_strain"), skincad.simulate(finite)


def test_fields_of_small_loads_at_finite_strain_are_those_of_small_strain() -> None:
    """Of a sixth of what closes all pins: 1 % of the largest change."""
    small, finite = (by_number(result, "field_mT") for result in bent(0.02))
    change = np.abs(small - small[0]).max()
    np.testing.assert_allclose(finite[0], small[0], atol=1e-12)
    np.testing.assert_allclose(finite, small, atol=0.01 * change)


def test_fields_at_finite_strain_are_of_the_pins_own_bodies() -> None:
    """Forces are read to 1e-5 N, as the map is that of the step before. Under 0.8 N the field is another than
    in small strain, and no note says so."""
    small, finite = bent(0.8)
    assert finite.model == "corrected"
    np.testing.assert_allclose(by_number(finite, "pin_force_N"), tips(finite), atol=1e-5)
    assert finite.read["pin_force_error_N"] < 1e-5 < finite.read["pin_force_map_error_N"] < 0.03
    one, other = (by_number(result, "field_mT") for result in (small, finite))
    change = np.abs(one - one[0]).max()
    assert 0.01 * change < np.abs(other - one).max() < 0.3 * change
    assert not [note for note in finite.warnings if "finite strain" in note]
    reading, every = finite.march.readings[-1], magnetic_pins(finite.scene.design)
    poses = every.poses(reading.tips) + reading.magnets(reading.tips)
    np.testing.assert_allclose(other[-1], every.fields(poses).sum(axis=1), atol=1e-9)


def test_slips_are_told_soon_after_they_come() -> None:
    """Within 5 steps without noise, in which the pull rises by the twentieth that is told; of the pin that
    slips last of all none is."""
    result = reading(**QUIET)
    told, slips = result.read["magnet_slip_step"], result.slip_steps
    assert told[4] is None
    others = [(a, b) for i, (a, b) in enumerate(zip(told, slips, strict=True)) if i != 4]
    assert all(0 <= a - b <= 5 for a, b in others)


def test_noise_delays_what_is_told_and_is_as_large_as_said() -> None:
    """10 % of the rms of some 2,600 samples, whose own error is 1.4 %; by another seed it is another."""
    quiet, noisy, other = (by_number(reading(**QUIET | more), "field_mT") for more in NOISES)
    for values in (noisy, other):
        assert (values - quiet).std() == pytest.approx(0.002, rel=0.1)
    assert np.abs(noisy - other).max() > 0.002
    told = reading(**QUIET | {"noise": 0.5, "seed": 1})
    spread = by_number(told, "pin_force_N") - tips(told)
    floor = np.array(told.read["pin_force_noise_N"])
    assert (spread.std(axis=0) / floor).mean() == pytest.approx(1.0, rel=0.15)
    first = min(step for step in told.read["magnet_slip_step"] if step is not None)
    assert first >= min(step for step in told.slip_steps if step is not None)


NOISES: tuple[dict[str, Any], ...] = ({}, {"noise": 2.0, "seed": 1}, {"noise": 2.0, "seed": 2})


def test_samples_are_held_rounded_and_kept_in_range() -> None:
    """At 20 Hz a step of 10 ms shows one of five; at a range of 4 mT the fields, 5.4 mT along z, saturate."""
    held = by_number(reading(**QUIET | {"rate": 20.0}), "field_mT")
    time = run().runs.march.time
    same = np.diff(held, axis=0).any(axis=(1, 2))
    assert same.sum() == np.unique(np.floor(time * 20 + 1e-6)).size - 1
    rounded = by_number(reading(**QUIET | {"resolution": 10.0}), "field_mT")
    np.testing.assert_allclose(rounded / 0.01, np.round(rounded / 0.01), atol=1e-6)
    short = reading(**QUIET | {"range": 4.0})
    assert by_number(short, "field_mT").max() == 4.0
    assert "sensor 1 leaves its range of 4 mT" in short.warnings
    assert "pin_force_N" not in short.read  # a reading that stands still is no force, and tells no slip
    assert short.read["magnet_slip_step"] == [None] * 9


def test_too_few_sensors_tell_fields_but_no_forces() -> None:
    result = reading(**QUIET | {"below": None, "places": [[0.0, 0.0, 1.0]]})
    assert "pin_force_N" not in result.read
    assert result.read["magnet_slip_step"] == [None] * 9
    assert any("too few" in warning for warning in result.warnings)
    assert "the sensors tell no pin's slip; they read with noise of 0 uT rms\n" in str(result)
    assert "magnets.png" in result.figures()


def test_forces_that_do_not_settle_are_not_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(magnet, "MOST_CORRECTIONS", 1)
    result = reading(**QUIET)
    assert "pin_force_N" not in result.read
    assert any("do not settle at step " in note for note in result.warnings)


def test_fields_and_forces_become_columns_and_a_figure(tmp_path: Path) -> None:
    result = reading(**QUIET)
    write_table(result, tmp_path / "signals.csv")
    columns = (tmp_path / "signals.csv").read_text("utf-8").splitlines()[0].split(",")
    assert {"sensor 1 x field [mT]", "pin 9 z pin force [N]"} <= {*columns}
    assert len(columns) == 7 + 2 * 27
    assert "magnets.png" in result.figures()
    assert "the sensors tell 8 of 9 pins' slip" in str(result)


def test_it_is_refused_without_sensors_and_of_ridges() -> None:
    with refused_by("effects.magnet: needs a skin with [magnetometer]"):
        load_scene("pillars-9-pull").with_(effects={"magnet": {}})
    with refused_by("effects.magnet"):
        load_scene("steady-pull").with_(effects={"magnet": {}})
