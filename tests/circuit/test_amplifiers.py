"""The amplifiers as lists of elements: by hand, by states and by SPICE; what each is good for; its noise."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.constants import Boltzmann

from bench.campaign import rational
from skincad.base import InputError, RefusedError
from skincad.circuit import (
    Constants,
    Network,
    circuit_network,
    constants,
    decibels,
    gain,
    load_circuit,
    noise_samples,
    state_space,
    total_density,
)
from skincad.circuit.network import Element, Noise, network
from skincad.circuit.response import noise_density, response
from skincad.inputs import template_names
from tests.circuit.networks import (
    LOAD,
    element_lines,
    needs_ngspice,
    output,
    random_sets,
    spice_gain_error,
    state_response,
    vectors,
)
from tests.circuit.paper import exact_response, follower_response, loop_response
from tests.refusals import refused_by

BAND = np.geomspace(10.0, 20_000.0, 33)
HANDS = {"inverting": exact_response, "follower": follower_response}
# a constant that the paper's network has not, and the ends of the range it is drawn from
KINDS = {
    "plain": (),
    "capacitor": ("feedback_capacitance", 1e-12, 1e-8),
    "falling gain": ("gain_bandwidth", 1e4, 1e8),
}
CHARGE, FOLLOWER = load_circuit("charge-amplifier"), load_circuit("voltage-follower")
TRANSIMPEDANCE = constants(load_circuit("transimpedance"))


def sets(kind: str, count: int) -> list[Constants]:
    """Random constants, with one drawn besides, evenly in its logarithm."""
    if not KINDS[kind]:
        return random_sets(count)
    name, *ends = KINDS[kind]
    drawn = np.exp(np.random.default_rng(5).uniform(*np.log(ends), count))
    return [replace(c, **{name: float(f)}) for c, f in zip(random_sets(count), drawn, strict=True)]


def test_shipped_topologies_are_solved_by_hand_and_constants_say_units() -> None:
    shipped = {load_circuit(name).amplifier.topology for name in template_names("circuits")}
    assert shipped == HANDS.keys()
    names = constants(load_circuit("yamada-2002")).as_json()
    assert {"d33_C_per_N", "capacitance_F", "motional_inductance_H", "gain"} <= set(names)
    assert len(names) == len(Constants.__dataclass_fields__)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("topology", HANDS)
def test_the_elements_have_the_response_by_hand_and_by_states(topology: str, kind: str) -> None:
    """In phase too, on random sets. 1e-12: some ten factors a product; 1e-10: a sum of rows by hand where A
    Ropo is near Rf. States are solved at jw in units of one size: 1e-9."""
    for c in sets(kind, 20):
        elements = network(c, topology=topology)
        gains = response(elements, BAND)
        within = 1e-10 if c.gain_bandwidth else 1e-12
        np.testing.assert_allclose(gains, HANDS[topology](c, BAND), rtol=within)
        np.testing.assert_allclose(state_response(elements, c.d33, BAND), gains, rtol=1e-9)


@pytest.mark.parametrize(("kind", "within"), [("plain", 1e-8), ("capacitor", 1e-7)])
def test_loop_equations_and_node_equations_agree_on_random_sets(kind: str, within: float) -> None:
    # 1e-8 dB is 1e-9 relative: pivots of 1e16 times double precision, with a margin of 100
    worst = [decibels(loop_response(c, BAND) / exact_response(c, BAND)) for c in sets(kind, 100)]
    assert np.abs(worst).max() < within


def test_no_digit_is_lost_where_the_output_cancels_or_the_input_is_large() -> None:
    """A of Ropo / Rf but for 1e-9, where the loop equations keep no digit: against fractions."""
    for c in random_sets(20):
        near = replace(c, gain=c.output_resistance / c.feedback_resistance * (1 + 1e-9))
        gains = decibels(response(network(near), BAND[::22]))
        exact = [rational.gain(near, float(f)) for f in BAND[::22]]
        # 1e-5: where the machine has no extended precision, ten roundings over 1e-9
        np.testing.assert_allclose(gains, exact, rtol=0, atol=1e-5)
    # The paper's i2 - i3 would keep none of them at 1e16 ohm
    c = replace(constants(load_circuit("yamada-2002")), input_resistance=1e16)
    assert np.abs(decibels(response(network(c), BAND) / exact_response(c, BAND))).max() < 1e-8


@needs_ngspice
@pytest.mark.parametrize("name", template_names("circuits"))
def test_every_shipped_circuit_is_a_deck_with_spices_gain(tmp_path: Path, name: str) -> None:
    """To 1e-6 dB, sign and phase too; with a pole, its own digits at a resonance of quality 60."""
    circuit = load_circuit(name)
    assert spice_gain_error(tmp_path, circuit_network(circuit), "dec 10 0.05 20000") < 1e-7
    (tmp_path / "out.raw").unlink()
    slow = circuit_network(circuit.with_(amplifier={"gain_bandwidth": 1e6}))
    assert spice_gain_error(tmp_path, slow, "dec 50 10 20000") < 1e-6


@needs_ngspice
def test_elements_and_spice_agree_to_a_millionth_of_a_decibel(tmp_path: Path) -> None:
    sets, nodes = random_sets(200), ("pv", "film", "m1", "m2", "in", "out", "amp", "vout")
    lines = [LOAD]
    for i, c in enumerate(sets):
        for line in element_lines(network(c)):
            name, *rest = line.split()
            lines.append(" ".join([f"{name}_{i}", *(f"{w}_{i}" if w in nodes else w for w in rest)]))
    spice = vectors(tmp_path, lines, "ac dec 20 10 20000", [f"v(vout_{i})" for i in range(len(sets))])
    frequency = spice["frequency"].real
    assert frequency[0] == 10.0
    assert frequency[-1] > 19_000.0
    ours = [response(network(c), frequency) for c in sets]
    worst = max(np.abs(decibels(x / spice[f"v(vout_{i})"])).max() for i, x in enumerate(ours))
    assert worst < 1e-6  # what is asked: 1e-7 relative


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"capacitance": 0.0}, "capacitance: must be above 0"),
        ({"motional_resistance": -1.0}, "motional_resistance: must be above 0"),
        ({"gain": 0.0}, "gain: must be above 0"),
        ({"output_resistance": float("nan")}, "output_resistance: must be a finite number"),
        ({"d33": 0.0}, "d33: must not be 0"),
        ({"feedback_capacitance": -1e-12}, "feedback_capacitance: must not be below 0"),
        ({"gain_bandwidth": -1.0}, "gain_bandwidth: must not be below 0"),
    ],
)
def test_bad_constants_are_told_by_name(change: dict[str, float], words: str) -> None:
    with pytest.raises(InputError, match=re.escape(words)):
        replace(TRANSIMPEDANCE, **change)


@pytest.mark.parametrize(
    ("name", "settings", "words"),
    [
        ("charge-amplifier", ["amplifier.feedback_capacitance=-1e-12"],
         "amplifier.feedback_capacitance: must be greater than or equal to 0"),
        ("transimpedance", ["amplifier.gain_bandwidth=-1.0"],
         "amplifier.gain_bandwidth: must be greater than or equal to 0"),
        ("transimpedance", ["amplifier.topology=folower"], "amplifier.topology: no such topology"),
        # what the paper's network has not is not calibrated
        ("charge-amplifier", [], "amplifier.feedback_capacitance: must be 0 F where constants"),
        ("transimpedance", ["amplifier.gain_bandwidth=1e6"], "amplifier.gain_bandwidth: must be 0 Hz where"),
        ("voltage-follower", [], "amplifier.topology: must be inverting where constants"),
    ],
)  # fmt: skip
def test_bad_amplifiers_are_refused(name: str, settings: Any, words: str) -> None:
    with refused_by(words):
        gain(load_circuit(name, settings), "measured.csv")


C = constants(CHARGE)
TAU = C.feedback_resistance * C.feedback_capacitance


def test_a_charge_amplifier_holds_a_step_without_the_capacitor_it_is_the_papers() -> None:
    voltage = output(circuit_network(CHARGE), np.r_[0.0, np.full(20_000, 1e-12)], 1e4)
    exact = 1e-12 / C.feedback_capacitance * np.exp(-np.arange(20_001) * 1e-4 / TAU)
    # 1e-3: the film's own branch and the amplifier's gain of 1e5 take a share; half a step of 1e-4 s of 1 s
    assert np.abs(voltage[10:] - exact[10:]).max() < 1e-3 * exact[0]
    plain = constants(load_circuit("charge-amplifier", ["amplifier.feedback_capacitance=0.0"]))
    assert state_space(network(plain)).a.shape == (4, 4)
    nearly = replace(plain, feedback_capacitance=1e-18)  # 1e10 ohm and 1e-18 F: 16 MHz
    ratio = response(network(nearly), BAND) / response(network(plain), BAND)
    assert np.abs(ratio - 1).max() < 2e-3


@pytest.mark.parametrize("resistance", [1e9, 1e10, 1e11])
def test_the_drift_on_a_hold_is_what_the_feedbacks_time_says(resistance: float) -> None:
    """Of a load put on in 10 ms and held for 0.4 s, as in the scene `hold`."""
    c = replace(C, feedback_resistance=resistance)
    time = np.arange(0.0, 0.41, 1e-3)
    voltage = output(network(c), 1e-12 * np.clip(time / 0.01, 0.0, 1.0), 1e3)
    tau = resistance * c.feedback_capacitance
    # the charge came evenly over 0.01 s; 1e-4: a gain of 1e5 and an input of 1e12 ohm
    exact = 1e-12 / c.feedback_capacitance * tau / 0.01 * -math.expm1(-0.01 / tau) * math.exp(-0.4 / tau)
    assert voltage[-1] == pytest.approx(exact, abs=1e-3 * voltage.max())


def test_a_charge_amplifier_follows_the_stress_and_its_low_cut_off_is_found() -> None:
    time = np.arange(0.0, 0.02, 1e-5)
    stress = np.sin(2 * np.pi * 100.0 * time) ** 2
    voltage = output(circuit_network(CHARGE), stress * C.d33, 1e5)
    rate = output(circuit_network(load_circuit("transimpedance")), stress * C.d33, 1e5)
    assert np.corrcoef(voltage, stress)[0, 1] < -0.999  # d33 is below 0
    # the half period has as many rises as falls
    assert abs(np.corrcoef(rate, stress)[0, 1]) < 0.2
    slopes = gain(CHARGE).slopes
    assert slopes.cutoff.value == pytest.approx(1 / (2 * math.pi * TAU), abs=slopes.cutoff.error)
    assert slopes.above.value == pytest.approx(0.0, abs=slopes.above.error or 0.0)
    # 17.6 of 20: the corner is round, and two decades of slope do not outweigh it
    assert slopes.below.value == pytest.approx(20.0, abs=3.0)
    level = 20 * math.log10(abs(C.d33) / C.feedback_capacitance)
    assert gain(CHARGE).gain[300] == pytest.approx(level, abs=0.01)


F = constants(FOLLOWER)


def test_the_followers_low_cut_off_level_and_step() -> None:
    curve = gain(FOLLOWER)
    # the motional branch is a capacitor too, far below its resonance
    whole = F.capacitance + F.motional_capacitance + F.input_capacitance
    corner = 1 / (2 * math.pi * F.input_resistance * whole)
    assert curve.slopes.cutoff.value == pytest.approx(corner, abs=curve.slopes.cutoff.error)
    middle = int(np.argmin(np.abs(curve.frequency - 500.0)))
    # 1e-3: one hundredth of the corner's frequency squared, and a gain of 1e5
    assert curve.gain[middle] == pytest.approx(20 * math.log10(abs(F.d33) / whole), abs=1e-3)
    whole = F.capacitance + F.motional_capacitance + F.input_capacitance
    voltage = output(circuit_network(FOLLOWER), np.r_[0.0, np.full(2000, 1e-12)], 1e5)
    exact = 1e-12 / whole * np.exp(-np.arange(2001) * 1e-5 / (F.input_resistance * whole))
    # 1e-3: half a step of 1e-5 s of 33 ms, the branch's ringing, a gain of 1e5
    assert np.abs(voltage[1500:] - exact[1500:]).max() < 1e-3 * exact[0]


def test_a_large_bandwidth_is_no_limit() -> None:
    """The change falls as 1 / bandwidth."""
    whole = response(network(TRANSIMPEDANCE), BAND)
    sizes = [
        np.abs(response(network(replace(TRANSIMPEDANCE, gain_bandwidth=b)), BAND) / whole - 1).max()
        for b in (1e12, 1e13)
    ]
    assert sizes[0] < 1e-4
    assert sizes[1] == pytest.approx(sizes[0] / 10, rel=0.01)
    # 1 MHz, the least of common ones: below the drop at 9 kHz 0.5 dB, at the cut-off a hundredth
    common, none = (
        gain(load_circuit("yamada-2002", [f"amplifier.gain_bandwidth={b}"])) for b in ("1e6", "0.0")
    )
    change = common.gain - none.gain
    assert np.abs(change[none.frequency <= 1200.0]).max() < 0.01
    assert 0.3 < np.abs(change[none.frequency <= 9000.0]).max() < 0.6
    assert common.slopes.above.value == pytest.approx(60.0, abs=0.5)


def test_film_and_feedback_ring_at_the_mean_of_their_corner_and_the_bandwidth() -> None:
    """Behind R_f the falling gain is an inductance, R_f / (2 pi B): it rings with what lies at the input at
    sqrt(B / (2 pi R_f C)) (Graeme, Photodiode Amplifiers, 1996, chapter 3); C_f = sqrt(2) / (2 pi R_f f)
    calms it, as flat as two poles can be.
    """
    c = replace(TRANSIMPEDANCE, gain_bandwidth=1e6)
    # the motional branch, far below its resonance, is a capacitor too
    whole = c.capacitance + c.motional_capacitance + c.input_capacitance
    wanted = np.sqrt(c.gain_bandwidth / (2 * np.pi * c.feedback_resistance * whole))
    frequency = np.geomspace(1e3, 20_000.0, 4001)
    plain = response(network(TRANSIMPEDANCE), frequency)
    rise = decibels(response(network(c), frequency) / plain)
    assert frequency[rise.argmax()] == pytest.approx(wanted, rel=0.01)
    assert rise.max() > 30.0
    calm = replace(c, feedback_capacitance=np.sqrt(2) / (2 * np.pi * c.feedback_resistance * wanted))
    assert decibels(response(network(calm), frequency) / plain).max() < 0.1


def test_what_an_output_follows_at_once_goes_through_a_loop_of_capacitors_is_refused() -> None:
    """A divider of two resistors: no state but the film's, and the charge's share comes without delay."""
    ends = Element("Epv", ("pv", "load", "0"), 2.0), Element("Evout", ("vout", "film", "0"), 1.0)
    divider = Network((*ends, Element("C", ("pv", "film"), 1e-9), Element("R", ("film", "0"), 1e6)), 1.0)
    s = state_space(divider)
    # by the charge's rate: 2 s / (s + 1000) is s times 2 / (s + 1000), and nothing at rest
    assert (s.a.item(), s.b.item() * s.c.item(), s.d) == pytest.approx((-1e3, 2.0, 0.0))
    voltage = output(divider, np.r_[np.zeros(1), np.ones(50)], 1e5)
    assert voltage[-1] == pytest.approx(2.0 * 100 * -math.expm1(-1e-2) * math.exp(-49e-2), rel=1e-9)
    loop = (Element("Epv", ("pv", "load", "0"), 1.0), Element("C", ("pv", "vout"), 1e-9))
    with pytest.raises(RefusedError, match="a loop of capacitors"):
        state_space(Network((*loop, Element("C2", ("vout", "0"), 1e-9)), 1.0))


CIRCUITS = {name: load_circuit(name) for name in template_names("circuits")}
FOLLOWER_CONSTANTS = constants(CIRCUITS["voltage-follower"])
AMPLIFIER, LOSS = Noise(temperature=293.0, voltage_density=1e-8, current_density=1e-15), 0.02 * 1e-11
LOUD = Noise.model_construct(voltage_density=1.0, current_density=1.0)  # more than any amplifier's
TOPOLOGIES = ("inverting", "follower")


def of(name: str, n: Noise, loss: float = 0.0, **changes: float) -> Network:
    """A shipped circuit with other noise."""
    circuit = CIRCUITS[name]
    return network(replace(constants(circuit), **changes), n, loss, circuit.amplifier.topology)


@needs_ngspice
@pytest.mark.parametrize("name", CIRCUITS)
def test_the_resistors_noise_is_spices(tmp_path: Path, name: str) -> None:
    """Of a poor amplifier too: its output's resistance is heard only there."""
    poor = {"output_resistance": constants(CIRCUITS[name]).feedback_resistance / 2, "gain": 5.0}
    for changes in ({}, poor):
        quiet = of(name, Noise(temperature=293.15), **changes)
        lines = [LOAD, *element_lines(quiet), ".options temp=20"]
        spice = vectors(tmp_path, lines, "noise v(vout) Vload dec 10 10 20000", ["onoise_spectrum"])
        ours = total_density(quiet, spice["frequency"])
        # SPICE's spectrum is V/sqrt(Hz); its Boltzmann constant differs from CODATA's in the sixth digit
        np.testing.assert_allclose(np.sqrt(ours), spice["onoise_spectrum"], rtol=2e-5)
        (tmp_path / "out.raw").unlink()


@needs_ngspice
@pytest.mark.parametrize("name", [name for name in CIRCUITS if name != "voltage-follower"])
def test_amplifier_noise_takes_the_way_that_spice_finds(tmp_path: Path, name: str) -> None:
    """A source of 1 V before the amplifier, and one of 1 A into its input, by an AC analysis each."""
    loud = of(name, LOUD)
    elements, amplifier = element_lines(loud), constants(CIRCUITS[name]).gain
    body = [line for line in elements if not line.startswith("Eamp")]
    own = next(e.nodes[0] for e in loud.elements if e.name == "Eamp")
    volt = ["Vload load 0 DC 0", *body, "Vn seen in AC 1", f"Eamp {own} 0 seen 0 {-amplifier!r}"]
    ampere = ["Vload load 0 DC 0", *elements, "In 0 in AC 1"]
    for lines, source in ((volt, "Eamp voltage"), (ampere, "Eamp current into in")):
        spice = vectors(tmp_path, lines, "ac dec 10 10 20000", ["v(vout)"])
        ours = noise_density(loud, spice["frequency"].real)[source]
        np.testing.assert_allclose(np.sqrt(ours), np.abs(spice["v(vout)"]), rtol=1e-6)
        (tmp_path / "out.raw").unlink()


def way(network: Network, node: str) -> np.ndarray:
    """The output by 1 A into a node: a load of 1 through a resistance next to which all others are none."""
    huge = Element("Rhuge", ("load", node), 1e25)
    silent = [replace(e, value=0.0) if e.name == "Epv" else e for e in network.elements]
    return response(Network((*silent, huge), 1.0), BAND) * huge.value


@pytest.mark.parametrize("topology", TOPOLOGIES)
@pytest.mark.parametrize("gain", [5.0, 1e5])
def test_each_noise_source_goes_the_way_of_a_current_in_its_place(topology: str, gain: float) -> None:
    c = replace(FOLLOWER_CONSTANTS, gain=gain, output_resistance=5e3, feedback_capacitance=1e-11)
    quiet = network(c, topology=topology)
    densities = noise_density(network(c, AMPLIFIER, LOSS, topology), BAND)
    nodes, thermal = {e.nodes[0] for e in quiet.elements if e.kind == "E"}, 4 * Boltzmann * 293.0
    exact = {}
    for e in quiet.elements:
        if e.kind in "RC":
            a, b = (way(quiet, node) if node not in {*nodes, "0"} else 0.0 for node in e.nodes)
            loss = 2 * np.pi * BAND * 1e-11 * 0.02
            density = 1 / e.value if e.kind == "R" else loss
            exact[e.name] = thermal * density * np.abs(a - b) ** 2
    eamp = next(e for e in quiet.elements if e.name == "Eamp")
    own, plus, minus = eamp.nodes
    for node in {plus, minus} - {"0"}:
        exact[f"Eamp current into {node}"] = 1e-30 * np.abs(way(quiet, node)) ** 2
    # 1 V more at the input, and no load elsewhere
    shifted = [replace(e, value=0.0) if e.name == "Epv" else e for e in quiet.elements if e is not eamp]
    seen = (Element("Eneg", ("neg", "load", "0"), -1.0), Element("Eseen", ("seen", plus, "neg"), 1.0))
    loud = response(Network((*shifted, *seen, replace(eamp, nodes=(own, "seen", minus))), 1.0), BAND)
    exact["Eamp voltage"] = 1e-16 * np.abs(loud) ** 2
    for name, density in densities.items():
        # 1e-9: what a node of 1e9 ohm leaves beside 1e25
        np.testing.assert_allclose(density, exact[name.removesuffix(" loss")], rtol=1e-9, err_msg=name)
    assert len(densities) == sum(e.kind == "R" for e in quiet.elements) + 3 + (topology == "follower")


def test_the_followers_noise_by_hand_and_a_poles_resistor_adds_none() -> None:
    """Its own voltage noise and that of the feedback's resistor come out as they are."""
    densities = noise_density(network(FOLLOWER_CONSTANTS, AMPLIFIER, LOSS, "follower"), np.array([1000.0]))
    # 1e-4: a gain of 1e5
    assert densities["Eamp voltage"][0] == pytest.approx(1e-16, rel=1e-4)
    assert densities["R34"][0] == pytest.approx(
        4 * Boltzmann * 293.0 * FOLLOWER_CONSTANTS.feedback_resistance, rel=1e-4
    )
    # A resistor of 1 ohm, 0.13 nV/sqrt(Hz), where the input's 10 nV/sqrt(Hz) are 1e5 times as loud at a low
    # frequency, and still 50 times at 20 kHz
    slow = of("transimpedance", AMPLIFIER, gain_bandwidth=1e6)
    share = noise_density(slow, BAND)["Rpole"] / total_density(slow, BAND)
    assert share.max() < 1e-6


def test_a_lossy_films_noise_and_a_circuits_own_sources() -> None:
    """At one frequency a conductance w C tan(delta) at the film: as the input's, at the film's node."""
    c = constants(load_circuit("transimpedance", ["amplifier.series_resistance=1e-3"]))
    frequency = np.array([1000.0])
    conductance = 2 * np.pi * 1000.0 * 11e-12 * 0.02
    lossy = noise_density(network(c, LOUD, 0.02 * 11e-12), frequency)
    thermal = 4 * Boltzmann * 293.0 * conductance
    # with R1 + R2 next to nothing, film and input are one node
    assert lossy["Cpvd loss"][0] == pytest.approx(thermal * lossy["Eamp current into in"][0], rel=1e-6)
    # Only the film loses: its lead, in parallel, adds capacitance alone
    circuit = load_circuit("yamada-2002", ["noise.temperature=300.0", "cable.capacitance=3e-10"])
    c, whole = constants(circuit), circuit_network(circuit)
    film = constants(load_circuit("yamada-2002", ["cable.capacitance=0"])).capacitance
    # eps0 eps A / d: 8.8542e-12 F/m x 12 x 11.95 mm2 / 0.028 mm
    assert film == pytest.approx(8.8542e-12 * 12 * 11.95e-6 / 0.028e-3, rel=1e-4)
    assert c.capacitance - film == pytest.approx(3e-10, rel=1e-9)
    noise = Noise(temperature=300.0, voltage_density=10e-9, current_density=1e-15)
    assert whole == network(c, noise, film * circuit.film.loss_tangent)


@pytest.mark.parametrize("name", [name for name in CIRCUITS if name != "voltage-follower"])
def test_samples_have_the_density_and_the_seed_is_the_noise(name: str) -> None:
    n, rate, count = of(name, AMPLIFIER, LOSS), 40_000.0, 40_000
    one = noise_samples(n, rate, count, seed=1)
    np.testing.assert_array_equal(one, noise_samples(n, rate, count, seed=1))
    lines = [np.abs(np.fft.rfft(noise_samples(n, rate, count, seed)))[100:] for seed in range(20)]
    many = 2 * np.mean([np.sum((line / count) ** 2) for line in lines])
    # from 100 Hz on, where a line of 1 Hz is narrow against the density's own slope; a chi-square over some
    # 100 000 lines, most of them where the gain peaks, a charge amplifier's at the low end: 5 %
    frequency = np.geomspace(100.0, rate / 2, 1000)
    assert many == pytest.approx(np.trapezoid(total_density(n, frequency), frequency), rel=0.05)


@pytest.mark.parametrize(("rate", "count"), [(0.0, 8), (-1.0, 8), (math.inf, 8), (math.nan, 8), (1e3, 1)])
def test_a_rate_that_is_none_and_a_single_sample_are_refused(rate: float, count: int) -> None:
    with pytest.raises(InputError, match="rate: must be above 0 Hz, with at least two samples"):
        noise_samples(network(TRANSIMPEDANCE), rate, count, 1)


@pytest.mark.parametrize("frequency", [0.0, -1.0, np.nan, np.inf])
def test_a_bad_frequency_is_told(frequency: float) -> None:
    with pytest.raises(InputError, match="frequency: must be above 0 Hz"):
        response(network(TRANSIMPEDANCE), np.array([10.0, frequency]))
