"""Films in a scene: empty or bonded strips, their capacitance and charge, the outputs of their amplifiers."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest
import shapely

import skincad
from skincad.base import InputError
from skincad.circuit import capacitance, constants, corner, electrode, load_circuit
from skincad.effects import Observables, Piezo, ReaderContext, fitted, strip_charges
from skincad.fabrication import Job, strip_patterns
from skincad.inputs import template_names, template_text
from skincad.outputs import write_table
from skincad.scenes import (
    LEVELS,
    SceneRun,
    Simulation,
    at_level,
    load_scene,
    marched,
    marching,
    plan,
    read_out,
    simulate,
)
from skincad.shape import polygon
from tests.circuit.networks import bought, needs_ngspice, vectors
from tests.refusals import refused, refused_by, refused_command
from tests.small_scene import THIRD, last_of_each, small_scene

LOOSE = ("effects.film.bond=loose", "readout.ridges=[]", "effects.friction=none")


@pytest.mark.slow
def test_a_loose_film_leaves_the_slots_empty(tmp_path: Path) -> None:
    """A scene's last step against the linear model."""
    scene = small_scene(tmp_path, "yamada-2002-press", THIRD, "history.steps=2", *LOOSE)
    here = at_level(scene, LEVELS[1]).march.readings[-1].approach
    there = skincad.check(
        scene.design.with_(contact={"film": "loose"}), force=1.3, model="linear"
    ).approach.value
    press = ("yamada-2002-press", THIRD, "history.steps=2", "readout.ridges=[]")
    bonded = at_level(small_scene(tmp_path, *press), LEVELS[0])
    # two meshes and orders: 0.5 % is the model's own; bonded strips make 4 % of difference
    assert here == pytest.approx(there, rel=5e-3)
    assert bonded.march.readings[-1].approach < 0.99 * here


@pytest.mark.slow
def test_slots_that_close_end_the_march_at_the_same_force_however_it_is_stepped(tmp_path: Path) -> None:
    """Nothing looks at each step: where slots are found closed at the end, the march says when they did."""
    closed = []
    for peak, steps in ((6.0, 24), (7.0, 28), (7.0, 112)):  # steps of 0.25 and of 0.0625 N
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


@pytest.mark.slow
def test_bonded_strips_and_slots_full_of_silicone_differ(tmp_path: Path) -> None:
    """What the strips feel is not the silicone's stress in their place: they are 3750 times as stiff."""
    press = ("yamada-2002-press", THIRD, "history.steps=2", "readout.ridges=[1]")
    strip, silicone = (
        at_level(small_scene(tmp_path, *press, *more), LEVELS[0]) for more in ((), ("effects.film=none",))
    )
    assert not np.allclose(strip.raw[1], silicone.raw[1], rtol=0.1)
    assert any("film is not named" in warning for warning in silicone.warnings)


def test_capacitances_are_the_data_sheets() -> None:
    """Of a square centimetre of 28 um film, and of a strip; a wider strip and a longer lead have more."""
    assert capacitance(100.0, 0.028, 12.0) == pytest.approx(380e-12, rel=0.01)  # data sheet's digits
    assert capacitance(0.25 * 12, 0.028, 12.0) == pytest.approx(11e-12, rel=0.05)
    plain, wide, lead = (
        constants(load_circuit("transimpedance", settings)).capacitance
        for settings in ([], ["film.area=6.0"], ["cable.capacitance=20e-12"])
    )
    assert wide - plain == pytest.approx(capacitance(3.0, 0.028, 12.0))
    assert lead - plain == pytest.approx(10e-12)


DESIGN = skincad.load("yamada-2002")
SLIP = "yamada-2002-slip"
RESISTANCE = 1e8 * 1e5 / (1 + 1e5)  # of the transimpedance's feedback at its finite gain
WIDTH = 5000.0


def readings(stress: np.ndarray) -> list[Observables]:
    """Readings of `(steps + 1, 3)` MPa in S1 of ridge 1; all other strips feel nothing."""
    result = []
    for row in stress:
        films = np.zeros((18, 3))
        films[0] = row
        none = np.zeros(0, bool)
        result.append(Observables(0.0, 0.0, 0.0, 0.0, none, none, films, 0.0, 0.0, 0.0))
    return result


def piezo_data(stress: np.ndarray, dt: float, width: float = WIDTH, **keys: Any) -> dict[str, Any]:
    piezo = Piezo(**{"circuit": "transimpedance", **keys})
    time = np.arange(stress.shape[0]) * dt
    return dict(piezo.read(ReaderContext(DESIGN, (1,), width), time, readings(stress)))


def ramp(count: int = 400, dt: float = 1e-5, rate: float = 10.0) -> np.ndarray:
    """Across the film alone, MPa, at `rate` MPa/s."""
    return np.outer(np.arange(count) * dt * rate, [1.0, 0.0, 0.0])


@pytest.mark.parametrize("name", [n for n in template_names() if skincad.load(n).film])
def test_the_electrode_is_the_cutting_patterns(name: str) -> None:
    design = skincad.load(name)
    for strip in strip_patterns(Job(design)):
        faces = [shapely.Polygon(polygon(metal, 1e-6)) for metal in (strip.front, strip.back)]
        assert electrode(design) == pytest.approx(faces[0].intersection(faces[1]).area, rel=2e-3)  # shrinkage


def test_each_stress_gives_its_charge_by_hand() -> None:
    circuit = load_circuit("transimpedance")
    film = DESIGN.film
    assert film is not None
    inside = (12.0 - 2 * 0.04) * (0.25 - 2 * 0.04)  # length and depth less the bare edges
    for row, d in (((1, 0, 0), film.d33), ((0, 1, 0), film.d32), ((0, 0, 1), film.d31)):
        charges = strip_charges(circuit, DESIGN, np.array([[row]], float))
        assert charges[0, 0] == pytest.approx(d * 1e-12 * inside, rel=1e-12)
    width_drawn = load_circuit("transimpedance", ["film.draw_axis=width"])
    turned = strip_charges(width_drawn, DESIGN, np.eye(3)[None])  # three strips, each stressed one way
    wanted = [d * 1e-12 * inside for d in (film.d33, film.d31, film.d32)]
    assert turned[0] == pytest.approx(wanted, rel=1e-12)


def test_a_constant_stress_rate_is_a_constant_current() -> None:
    """And that times the feedback's resistance the output, once low-pass and amplifier have settled."""
    film = DESIGN.film
    assert film is not None
    current = film.d33 * 1e-12 * electrode(DESIGN) * 10.0
    output = piezo_data(ramp(), 1e-5)["output_V"]["1"]
    # 1e-6: the amplifier's 1e12 ohm beside its input, and the network's 0.2 ms after 4 ms
    assert output["pair"][-1] == pytest.approx(current * RESISTANCE, rel=1e-6)
    assert output["pair"] == output["S1"]
    assert np.abs(output["S2"]).max() == 0.0


def test_a_step_of_stress_gives_its_charge_in_all() -> None:
    stress = np.zeros((600, 3))
    stress[100:, 0] = 0.1
    output = np.array(piezo_data(stress, 1e-5)["output_V"]["1"]["pair"])
    charge = strip_charges(load_circuit("transimpedance"), DESIGN, stress[-1:][None])[0, 0]
    # trapezoids over a pulse of some ten samples
    assert np.trapezoid(output, dx=1e-5) == pytest.approx(charge * RESISTANCE, rel=1e-3)
    assert abs(output[-1]) < 1e-6 * np.abs(output).max()
    assert np.abs(output[:100]).max() == 0.0


SUPPLY = load_circuit("single-supply")


def push(load: float) -> np.ndarray:
    """Across the film, MPa every 1e-5 s: on within 1 ms, held, off within 1 ms."""
    return np.outer(
        load * np.interp(np.arange(600), [0, 50, 150, 300, 400], [0, 0, 1, 1, 0]), [1.0, 0.0, 0.0]
    )


def test_an_amplifier_stops_at_its_rails_before_the_low_pass_and_says_so() -> None:
    """A weak push is as without rails, to the last digit; a strong one stops at either rail."""
    unlimited = SUPPLY.with_(amplifier={"rail_low": None, "rail_high": None})
    weak, strong = push(0.02), push(0.5)
    within, plain = (piezo_data(weak, 1e-5, circuit=c) for c in (SUPPLY, unlimited))
    assert within["output_V"] == plain["output_V"]
    assert (within["clipped_share"], within["clipped_strips"]) == (0.0, [])
    assert (within["output_swing_V"], plain["output_swing_V"]) == (
        pytest.approx([-1.63, 1.63], abs=1e-3),
        [None] * 2,
    )
    assert within["output_offset_V"] == pytest.approx(0.5e-12 * 1e8, rel=1e-3)
    clips, free = (piezo_data(strong, 1e-5, circuit=c) for c in (SUPPLY, unlimited))
    output, linear = (np.array(data["output_V"]["1"]["S1"]) for data in (clips, free))
    low, high = clips["output_swing_V"]
    # a bounded signal behind two equal poles is as bounded; 0.1 % of what the network's steps round off
    assert output.min() == pytest.approx(low, rel=1e-3)
    assert output.max() == pytest.approx(high, rel=1e-3)
    assert np.abs(linear).max() > 1.5 * high
    (strip,) = clips["clipped_strips"]
    assert (strip["ridge"], strip["strip"]) == (1, "S1")
    assert strip["share_of_time"] == clips["clipped_share"]
    at_rail = np.isclose(np.abs(output), high, rtol=5e-3).mean()
    assert clips["clipped_share"] == pytest.approx(at_rail, abs=0.05)  # the low-pass takes 0.1 ms at each end
    (warning,) = [text for text in clips["warnings"] if "rail" in text]
    assert warning.startswith(
        f"single-supply is driven to a rail: ridge 1 S1 for {clips['clipped_share']:.2g}"
    )
    needed = np.abs(linear).max() / high
    assert f"would need {needed:.2g} times its swing" in warning
    # as much less resistance and as much more capacitance is enough
    less = {"feedback_resistance": 0.9e8 / needed, "feedback_capacitance": 1e-12 * needed / 0.9}
    assert piezo_data(strong, 1e-5, circuit=SUPPLY.with_(amplifier=less))["clipped_share"] == 0.0


@needs_ngspice
@pytest.mark.evidence(subject="circuit: bought amplifier single-supply")
@pytest.mark.parametrize("load", [0.02, 0.2, 0.5])
def test_the_output_of_a_push_is_spices_with_the_makers_figures(tmp_path: Path, load: float) -> None:
    """From the film's charge through the amplifier and its rails to two poles of 5 kHz."""
    stress, time = push(load), np.arange(600) * 1e-5
    circuit = fitted(SUPPLY, DESIGN)
    charges = strip_charges(circuit, DESIGN, stress[:, None])[:, 0] / constants(circuit).d33
    points = " ".join(f"{t!r} {x!r}" for t, x in zip(time.tolist(), charges.tolist(), strict=True))
    pole = 1 / corner(WIDTH)
    filters = ["Ef1 f1 0 vout 0 1", "Rf1 f1 f2 1", f"Cf1 f2 0 {pole!r}"]
    filters += ["Ef2 f3 0 f2 0 1", "Rf2 f3 f4 1", f"Cf2 f4 0 {pole!r}"]
    deck = [*bought(circuit, f"Vload load 0 PWL({points})"), *filters]
    spice = vectors(tmp_path, deck, "tran 1u 5.99m 0 1u", ["v(f4)"])
    there = np.interp(time, spice["time"], spice["v(f4)"])
    output = np.array(piezo_data(stress, 1e-5, circuit=SUPPLY)["output_V"]["1"]["S1"])
    # 2 % of the swing at a rail, as of an edge a step later; without one what the second pole leaves
    within = 0.02 * 3.26 if load > 0.1 else 1e-3 * np.abs(output).max()
    assert np.abs(output - (there - there[0])).max() < within


def test_the_noise_of_an_amplifier_at_a_rail_does_not_take_it_beyond() -> None:
    loud = SUPPLY.with_(noise={"voltage_density": 1e-5})
    data = piezo_data(push(0.5), 1e-5, circuit=loud, noise_seed=1)
    low, high = data["output_swing_V"]
    output = np.array(data["output_V"]["1"]["S1"])
    assert data["output_noise_V_rms"] > 0.01 * high
    assert output.min() > 1.001 * low
    assert output.max() < 1.001 * high
    other = piezo_data(push(0.0), 1e-5, circuit=loud, noise_seed=1)["output_V"]["1"]["S1"]
    assert np.std(other) == pytest.approx(data["output_noise_V_rms"], rel=0.5)


def test_strips_at_a_rail_beyond_three_are_counted() -> None:
    watched = ReaderContext(DESIGN, (1, 2), WIDTH)
    rows = readings(push(0.5))
    for row in rows:
        row.films[1:4] = row.films[0] * np.array([[0.9], [0.8], [0.7]])
    data = Piezo(circuit=SUPPLY).read(watched, np.arange(600) * 1e-5, rows)
    assert [(s["ridge"], s["strip"]) for s in data["clipped_strips"]] == [
        (1, "S1"),
        (1, "S2"),
        (2, "S1"),
        (2, "S2"),
    ]
    assert any("ridge 2 S1 for" in text and "1 more for less" in text for text in data["warnings"])


@pytest.mark.parametrize("samples", [range(601), (0, 1.3, 2, 3, 4.7, *range(5, 600))])
def test_uneven_steps_stop_at_the_rails_too(samples: Sequence[float]) -> None:
    at = np.array(samples)
    stress = np.column_stack([np.interp(at, np.arange(600), push(0.5)[:, 0]), *np.zeros((2, at.size))])
    data = Piezo(circuit=SUPPLY).read(ReaderContext(DESIGN, (1,), WIDTH), at * 1e-5, readings(stress))
    output, even = np.array(data["output_V"]["1"]["S1"]), piezo_data(push(0.5), 1e-5, circuit=SUPPLY)
    wanted = np.interp(at[:-1], np.arange(600), even["output_V"]["1"]["S1"])
    # 2 % of the swing: other steps of the network, by which an edge of 0.1 ms comes a step later
    assert np.abs(output[:-1] - wanted).max() < 0.02 * 3.26


@pytest.mark.parametrize("seed", range(10))
def test_the_steps_of_the_march_do_not_count(seed: int) -> None:
    """The same straight pieces of stress by 1000 equal steps, and by 50 with the corners between them."""
    draw = np.random.default_rng((39, seed))
    corners = np.sort(draw.choice(np.arange(1, 1000), 8, replace=False))
    at = np.union1d(np.arange(0, 1001, 20), corners)
    points = np.array([0, *corners, 1000])
    fine = np.outer(np.interp(np.arange(1001), points, draw.normal(size=points.size)), [1.0, 0.0, 0.0])
    piezo, watched = Piezo(circuit="transimpedance"), ReaderContext(DESIGN, (1,), WIDTH)
    one, other = (
        np.array(piezo.read(watched, time * 1e-5, readings(stress))["output_V"]["1"]["S1"])
        for time, stress in ((np.arange(1001), fine), (at, fine[at]))
    )
    # the low-pass's output is taken as straight within a step of a tenth of its time: 0.01 / 12
    assert np.abs(one[at] - other).max() < 2e-3 * np.abs(one).max()


@pytest.mark.parametrize("samples", [range(201), (0, 1.3, 2, 3, 4.7, *range(5, 200))])
def test_the_noise_of_other_seeds_is_told_as_a_difference(samples: Sequence[float]) -> None:
    times = 1e-5 * np.array(samples)
    watched, still = ReaderContext(DESIGN, (1, 3), WIDTH), readings(np.zeros((times.size, 3)))
    reference, other = (
        Piezo(circuit="transimpedance", noise_seed=seed).read(watched, times, still)["output_V"]
        for seed in (5, 7)
    )
    noises = list(Piezo(circuit="transimpedance", noise_seed=5).other_noises(watched, times))
    assert len(noises) == 19
    for i, ridge in enumerate(("1", "3")):
        for k, side in enumerate(("S1", "S2")):
            wanted = np.array(other[ridge][side])
            moved = np.array(reference[ridge][side]) + noises[1][:, i, k]
            np.testing.assert_allclose(moved, wanted, atol=1e-12 * np.abs(wanted).max())
    assert list(Piezo(circuit="transimpedance").other_noises(watched, times)) == []


def test_a_wider_strip_gives_more_and_a_longer_lead_has_no_more_capacitance() -> None:
    circuit = load_circuit("transimpedance")
    wide = DESIGN.with_(slot={"depth": 0.3})
    lead = DESIGN.with_(film={"lead": 16.0})
    stress = np.ones((1, 1, 3))
    charges = [strip_charges(circuit, d, stress)[0, 0] for d in (DESIGN, wide, lead)]
    assert charges[1] == pytest.approx(charges[0] * 0.22 / 0.17)
    assert charges[2] == charges[0]
    areas = [fitted(circuit, d).film.area for d in (DESIGN, wide, lead)]
    assert areas[1] == pytest.approx(areas[0] * 0.22 / 0.17)
    assert areas[2] == areas[0]


@pytest.mark.slow
def test_noise_is_the_seeds_and_has_the_size_that_is_told() -> None:
    still = np.zeros((10_000, 3))
    runs = [piezo_data(still, 1e-5, noise_seed=seed) for seed in (1, 1, 2)]
    assert runs[0]["output_V"] == runs[1]["output_V"]
    assert runs[0]["output_V"] != runs[2]["output_V"]
    one, other = (np.array(runs[0]["output_V"]["1"][side]) for side in ("S1", "S2"))
    size = runs[0]["output_noise_V_rms"]
    # 0.1 s of a noise with its power below 2 kHz: some 200 independent samples, whose spread is 5 %
    assert np.std(one) == pytest.approx(size, rel=0.15)
    assert abs(np.corrcoef(one, other)[0, 1]) < 0.2
    assert runs[0]["signal_to_noise_dB"]["1"] is None
    assert piezo_data(still, 1e-5)["output_V"]["1"]["S1"] == [0.0] * 10_000


def test_the_ratio_is_the_pairs_to_two_amplifiers() -> None:
    data = piezo_data(ramp(), 1e-5)
    size = np.std(data["output_V"]["1"]["pair"]) / (math.sqrt(2) * data["output_noise_V_rms"])
    assert data["signal_to_noise_dB"]["1"] == pytest.approx(20 * math.log10(size), rel=1e-9)


def test_a_narrower_band_has_less_noise() -> None:
    loud, quiet = (piezo_data(ramp(), 1e-5, width)["output_noise_V_rms"] for width in (5000.0, 50.0))
    assert quiet < loud / 3
    assert corner(50.0) < corner(5000.0)


def test_one_entry_is_at_rest() -> None:
    data = piezo_data(np.zeros((1, 3)), 1e-5, noise_seed=0)
    assert len(data["output_V"]["1"]["pair"]) == 1


@cache
def march() -> SceneRun:
    """Three ridges, pressed: the skin is its own mirror image."""
    settings = ("effects.piezo.circuit=transimpedance", "history.steps=12", "readout.bandwidth_Hz=50.0")
    with pytest.MonkeyPatch.context() as patch, TemporaryDirectory() as folder:
        patch.setattr(plan, "LEVELS", LEVELS[:1])
        scene = small_scene(Path(folder), "yamada-2002-press", THIRD, *settings, "readout.ridges=[1, 2, 3]")
        return marched(scene.with_(skin=scene.design))


@cache
def pressed() -> Simulation:
    return read_out(march().on.scene, march())


def test_a_mirrored_press_leaves_nothing_in_the_middle_pair() -> None:
    """Ridge 2's S1 is S2, and ridge 1's S1 is ridge 3's S2."""
    outputs = pressed().as_json()["output_V"]
    size = max(np.abs(strips["S1"]).max() for strips in outputs.values())
    # 1e-6: what the contact's own solution leaves of the symmetry
    assert np.abs(outputs["2"]["pair"]).max() < 1e-6 * size
    assert np.abs(np.subtract(outputs["1"]["S1"], outputs["3"]["S2"])).max() < 1e-6 * size
    assert np.abs(np.add(outputs["1"]["pair"], outputs["3"]["pair"])).max() < 1e-6 * size
    assert np.abs(outputs["1"]["pair"]).max() > 0.01 * size


def test_the_outputs_are_columns_of_the_table(tmp_path: Path) -> None:
    write_table(pressed(), tmp_path / "signals.csv")
    rows = list(csv.DictReader((tmp_path / "signals.csv").open()))
    values = [float(row["ridge 3 pair output [V]"]) for row in rows]
    np.testing.assert_allclose(values, pressed().read["output_V"]["3"]["pair"], rtol=1e-8, atol=1e-15)


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (["effects.film=none"], "effects.piezo: needs the effect film"),
        (["skin=plain-ridges", "effects.film=none"], "effects.piezo: needs a skin with a [film]"),
        (["effects.piezo.circuit=yamda-2002"], "effects.piezo.circuit: yamda-2002: no such template"),
        (["effects.piezo.noise_seed=-1"], "effects.piezo.noise_seed: must be greater than or equal to 0"),
        (["effects.piezo={}"], "effects.piezo.circuit: is missing"),
    ],
)
def test_what_cannot_be_is_told(settings: list[str], words: str) -> None:
    with refused_by(words):
        load_scene(SLIP, last_of_each("effects.piezo.circuit=yamada-2002", *settings))


def test_a_strip_that_gives_no_charge_is_refused() -> None:
    flat = DESIGN.with_(film={"d33": 0.0})
    Piezo(circuit="transimpedance").check(flat)  # the other two give charge
    dead = DESIGN.with_(film={"d31": 0.0, "d32": 0.0, "d33": 0.0})
    with pytest.raises(InputError, match="must not all be 0"):
        Piezo(circuit="transimpedance").check(dead)


def test_a_circuit_lies_beside_its_scene(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(template_text("transimpedance", "circuits"))
    scene = template_text(SLIP, "scenes") + '\n[effects.piezo]\ncircuit = "mine.toml"\n'
    (tmp_path / "scene.toml").write_text(scene)
    piezo = load_scene(tmp_path / "scene.toml").parts["piezo"]
    assert isinstance(piezo, Piezo)
    assert piezo.circuit == load_circuit("transimpedance")


def test_a_bad_constant_exits_with_2_and_writes_nothing(tmp_path: Path) -> None:
    text = template_text("transimpedance", "circuits").replace("gain = 1e5", "gain = 0.0")
    (tmp_path / "mine.toml").write_text(text)
    (tmp_path / "s.toml").write_text(
        template_text(SLIP, "scenes") + '\n[effects.piezo]\ncircuit = "mine.toml"\n'
    )
    message = refused_command("simulate", "s.toml", cwd=tmp_path)
    assert message.startswith("effects.piezo.circuit: amplifier.gain: must be greater than 0")


def test_a_circuits_tables_may_stand_in_the_scene() -> None:
    circuit = load_circuit("transimpedance").with_(amplifier={"feedback_resistance": 2e8})
    scene = load_scene(SLIP, ["effects.piezo.circuit=transimpedance"])
    piezo = scene.with_(effects={"piezo": {"circuit": circuit.model_dump(exclude_none=True)}}).parts["piezo"]
    assert isinstance(piezo, Piezo)
    assert piezo.circuit == circuit
    with pytest.raises(InputError, match=r"effects.piezo.circuit: must be a circuit, or the name"):
        load_scene(SLIP, ["effects.piezo.circuit=3"])
    with pytest.raises(InputError, match=r"effects.piezo.circuit.amplifier.gian: unknown key"):
        load_scene(SLIP, ["effects.piezo.circuit={amplifier={gian=1}}"])


def test_the_largest_output_is_any_strips() -> None:
    outputs = pressed().read["output_V"]
    largest = max(np.abs(strips[side]).max() for strips in outputs.values() for side in ("S1", "S2"))
    assert pressed().read["largest_output_V"] == pytest.approx(largest, rel=1e-12)
    doubled = load_circuit("transimpedance").with_(amplifier={"feedback_resistance": 2e8})
    again = read_out(
        pressed().scene.with_(effects={"piezo": {"circuit": doubled.model_dump(exclude_none=True)}}), march()
    )
    # the amplifier's finite gain and the film's capacitance: a part in 1e5
    assert again.read["largest_output_V"] == pytest.approx(2 * largest, rel=1e-3)
    assert again.raw[3] == pytest.approx(pressed().raw[3], abs=0.0)


def test_a_march_read_by_another_circuit_is_as_if_marched_anew() -> None:
    other = pressed().scene.with_(
        effects={"piezo": {"circuit": "charge-amplifier"}}, readout={"bandwidth_Hz": 80.0}
    )
    assert marching(other) == marching(pressed().scene)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(plan, "LEVELS", LEVELS[:1])
        anew = simulate(other, model="small_strain").as_json()
    data = read_out(other, march()).as_json()
    assert {k: v for k, v in data.items() if k != "seconds"} == {
        k: v for k, v in anew.items() if k != "seconds"
    }
    assert marching(other.with_(readout={"ridges": [2]})) != marching(other)
    assert marching(other.with_(effects={"friction": {"coefficient": 0.4}})) != marching(other)
