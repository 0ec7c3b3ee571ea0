"""A board to solder: a circuit's amplifiers for 4 to 16 strips, of parts that can be bought, on one supply.

Every strip has a channel: header, a resistor, two diodes to the rails, a resistor, the circuit's amplifier,
and a low-pass of one pole before the converter. All rest at half the supply, which a divider and a spare
amplifier make. The strips' other faces rest there too, so that no constant voltage lies across a film.

Sources of the parts. Checked 2026-11 on copies of the makers' sheets: NXP 2001-10-12, BAV199: 3 pA typical,
4 A for 1 us, pins; Infineon 2004-03-10, BAV199: 2 pF typical; Stackpole 2018-08-20, HMC: E24 up to 10 Gohm
in size 1206; KEMET C1030, CBR: codes, and 0.1 to 100 pF; PJRC, analog.c: inputs of the Teensy 4.1. Not
checked, as of the maker's data sheet: TI SBOS839, TLV9064: 0.5 pA, at most 1.6 mV, 10 MHz, 130 dB, 2 pF
differential and 4 pF common. Nothing was ordered: a number is made by its maker's rule for order codes.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from skincad.base.errors import InputError
from skincad.base.result import Record, Result, item, record, reported_from
from skincad.circuit.bode import without_rig
from skincad.circuit.model import UNLIMITED, Amplifier, Circuit, circuit_network, constants
from skincad.circuit.network import PICO, Constants, network
from skincad.circuit.response import decibels, response

FEWEST, MOST = 4, 16  # strips; source: a Teensy 4.1 has 18 analogue inputs, and one reads the middle
NAME = re.compile(r"[1-9][0-9]{0,2}S[12]")  # of a strip, as film/strip-board.kicad_mod names it
SUPPLY = 3.3  # V, source: Teensy 4.1, which gives it and converts up to it
GND, SOURCE, RAIL, MIDDLE = "GND", "+3V3", "+3V3A", "MID"  # nets; the rail is the source behind a ferrite

OPAMP_GAIN, OPAMP_BANDWIDTH = 10**6.5, 10e6  # 1, Hz; source: SBOS839
OPAMP_COMMON, OPAMP_DIFFERENTIAL = 4e-12, 2e-12  # F, source: SBOS839
OPAMP_BIAS, OPAMP_OFFSET = 0.5e-12, 1.6e-3  # A typical, V at most; source: SBOS839
CLAMP_LEAKAGE, CLAMP_CAPACITANCE = 3e-12, 2 * 2e-12  # A and F of two diodes, typical; source: NXP, Infineon
UNITS = 4  # amplifiers in one TLV9064
FOLLOWER = "follower"
DRAWN = ("inverting", FOLLOWER)  # topologies that have a drawing

RATES = (100.0, 50e3)  # Hz; above, a converter of 1 MS/s has too little time for 9 inputs one after another
PASS = 0.8  # of the Nyquist frequency: the low-pass's corner, to which a recording is true (circuit/state.py)
SPARK = 8e3  # V, source: IEC 61000-4-2, contact, level 4
PROTECTION = SPARK / 4.0  # ohm before the diodes, which stand 4 A for 1 us; source: NXP, BAV199
PROBE = 10e-12  # F, assumption: the capacitor through which a finished channel is tested
STEADY = 60.0  # deg of phase margin that a capacitor is chosen for
RINGING = 45.0  # deg, below which a capacitor that a circuit names is refused
CLOSE = 1.0  # dB by which the board's gain may differ from the circuit's up to the low-pass's corner

E24 = (10, 11, 12, 13, 15, 16, 18, 20, 22, 24, 27, 30, 33, 36, 39, 43, 47, 51, 56, 62, 68, 75, 82, 91)
E96 = tuple(round(100 * 10 ** (k / 96)) for k in range(96))  # source: IEC 60063
TENTHS = tuple(0.1 * n for n in range(3, 10))  # pF, steps below 1 pF; less is lost in a board's own 0.1 pF
ORDINARY, HIGH = 10e6, 10e9  # ohm: the largest of ordinary chips, and of those of high resistance
HALF_WAY = 10.5e6  # ohm: from there on 11 Mohm, the smallest of high resistance, is nearer

# The analogue inputs of a Teensy 4.1: name, pin, converter. Some hang on one converter alone. In this order
# the two strips of a ridge are on different ones, which can sample both at once.
INPUTS = (
    *((f"A{n}", 14 + n, 1 + n % 2) for n in range(10)),
    ("A10", 24, 1), ("A12", 26, 2), ("A11", 25, 1), ("A13", 27, 2), ("A16", 40, 1), ("A14", 38, 2),
    ("A17", 41, 1),
)  # fmt: skip


class Chip(NamedTuple):
    """A part that can be bought: its value in SI, how it is printed, where it is soldered, who makes it."""

    value: float
    text: str
    footprint: str
    maker: str
    number: str


def fixed(text: str, footprint: str, maker: str, number: str) -> Chip:
    """Return a part that is the same on every board."""
    return Chip(math.nan, text, footprint, maker, number)


R0603, C0603 = "Resistor_SMD:R_0603_1608Metric", "Capacitor_SMD:C_0603_1608Metric"
OPAMP = fixed("TLV9064", "Package_SO:SOIC-14_3.9x8.7mm_P1.27mm", "Texas Instruments", "TLV9064IDR")
CLAMP = fixed("BAV199", "Package_TO_SOT_SMD:SOT-23", "Nexperia", "BAV199,215")
FERRITE = fixed("600 at 100 MHz", "Inductor_SMD:L_0603_1608Metric", "Murata", "BLM18AG601SN1D")
BULK = fixed("10u", "Capacitor_SMD:C_0805_2012Metric", "Murata", "GRM21BR61E106KA73L")
MICRO = fixed("1u", C0603, "Murata", "GRM188R71E105KA12D")
BYPASS = fixed("100n", C0603, "Murata", "GRM188R71H104KA93D")


@dataclass(frozen=True)
class BoardPart(Record):
    """A part, with the net at each of its pins; `kind` is that of its symbol."""

    reference: str = item(meaning="its name in the schematic")
    kind: str = item(meaning="of its symbol")
    role: str = item(meaning="what it does")
    value: str = item(meaning="as the schematic has it")
    footprint: str = item(meaning="of KiCad's libraries")
    maker: str = item(meaning="of the part")
    number: str = item(meaning="the maker's")
    nets: dict[str, str] = item(meaning="by pin")


@dataclass(frozen=True)
class Channel(Record):
    """The way of a strip: pins of the film's header J1, amplifier, pin of J2, and input of a Teensy 4.1."""

    strip: str = item(meaning="ridge and side")
    plus: int = item(meaning="pin of J1, the front")
    minus: int = item(meaning="pin of J1, the back, at the middle of the supply")
    amplifier: str = item(meaning="its unit")
    output: int = item(meaning="pin of J2")
    analog: str = item(meaning="input")
    pin: int = item(meaning="of the Teensy")
    converter: int = item(meaning="1 or 2")


@dataclass(frozen=True)
class Purchase(Record):
    """What a circuit's key becomes: the value that can be bought, nearest to the circuit's."""

    key: str = item(meaning="of the circuit")
    circuit: float = item(meaning="SI")
    board: float = item(meaning="SI")

    @property
    def change(self) -> float:
        """By how much it differs, relative; 0 of a part that the circuit has not."""
        return self.board / self.circuit - 1 if self.circuit else 0.0


@record()
class Board(Result):
    """A board for some strips of a circuit.

    `difference` is the largest by which its gain differs from the circuit's up to the low-pass's `corner`,
    the low-pass left out: by what can be bought, and by the amplifier's own gain and bandwidth.
    """

    shown_by = "skincad.outputs.boards:BOARD"
    circuit: Circuit
    constants: Constants = item(meaning="of the network, as it can be bought")
    purchases: tuple[Purchase, ...] = item(meaning="what keys become")
    parts: tuple[BoardPart, ...] = item(meaning="all, by reference")
    channels: tuple[Channel, ...] = item(meaning="a strip each")
    rate: float = item("Hz", "samples a second, of the circuit")
    corner: float = item("Hz", "of the low-pass before the converter, -3 dB")
    difference: float = item("dB", "largest, of the gain up to the corner")
    phase_margin: float = item("deg", "of an amplifier")
    rest_error: float = item("V", "typical, at 25 degrees Celsius, by leakage; without the offset voltage")
    test_frequency: float = item("Hz", "at which a channel is tested")
    test_gain: float = item(meaning="V/V there, from a generator through 10 pF, without a film")

    name = reported_from("circuit.name", meaning="of the circuit")

    @property
    def follows(self) -> bool:
        """Whether its amplifiers are followers; else they invert."""
        return self.circuit.amplifier.topology == FOLLOWER

    @property
    def spare(self) -> int:
        """How many amplifiers are wired as followers of the middle."""
        return -(len(self.channels) + 1) % UNITS

    @property
    def chips(self) -> int:
        """How many chips of four amplifiers there are."""
        return (len(self.channels) + 1 + self.spare) // UNITS


def board(circuit: Circuit, strips: int | str | Sequence[str] = 8) -> Board:
    """Return an amplifier board for as many strips, or for strips by name, as `"2S1,2S2,3S1,3S2"`.

    By number they are 1S1, 1S2, 2S1 and so on: two a ridge. Range: 4 to 16 strips, `sampling.rate` 100 Hz to
    50 kHz. Raises InputError for others, and for a circuit that parts which can be bought do not give within
    1 dB.
    """
    names = strip_names(strips)
    rate, corner, low_pass = _low_pass(circuit)
    amplifier, c = circuit.amplifier, constants(without_rig(circuit))
    if not 2 * PROTECTION <= c.series_resistance <= 2 * ORDINARY:
        rule = f"must be {2 * PROTECTION:g} to {2 * ORDINARY:g} ohm on a board, to protect the input"
        remedy = "--set amplifier.series_resistance=1e4"
        raise InputError("amplifier.series_resistance", rule, c.series_resistance, remedy)
    series = resistor(c.series_resistance / 2, "series_resistance")
    feedback = resistor(c.feedback_resistance, "feedback_resistance")
    if amplifier.topology not in DRAWN:
        raise InputError("amplifier.topology", f"must be {' or '.join(DRAWN)} on a board", amplifier.topology)
    _check_rails(amplifier)
    follows = amplifier.topology == FOLLOWER
    bias = resistor(c.input_resistance, "input_resistance") if follows else None
    real = replace(
        c,
        series_resistance=2 * series.value,
        feedback_resistance=feedback.value,
        input_resistance=bias.value if bias else c.input_resistance,
        input_capacitance=OPAMP_COMMON + CLAMP_CAPACITANCE + (0 if follows else OPAMP_DIFFERENTIAL),
        gain=OPAMP_GAIN,
        gain_bandwidth=OPAMP_BANDWIDTH,
    )
    across = _feedback_capacitor(real, amplifier.topology)
    real = replace(real, feedback_capacitance=across.value)
    difference = _largest_difference(circuit, c, real, corner)
    if abs(difference) > CLOSE:
        rule = f"parts that can be bought change its gain by {difference:.1f} dB below {corner:g} Hz"
        if not c.feedback_capacitance and not follows:
            remedy = f"--set amplifier.feedback_capacitance={across.value:g}: without it the amplifier rings"
            rule += f", with {across.text}F beside {feedback.text}"
            raise InputError("amplifier.feedback_capacitance", rule, 0.0, remedy)
        own = f"gain={OPAMP_GAIN:.2g}, gain_bandwidth={OPAMP_BANDWIDTH:g}, input_capacitance=1e-11"
        raise InputError(circuit.name, rule, remedy=f"give its amplifier a TLV9064's {own}, and parts of E24")
    keys = ["series_resistance", "feedback_resistance", "feedback_capacitance"]
    keys += ["input_resistance"] * follows
    test_frequency = float(f"{corner / 10:.1g}")
    return Board(
        circuit=circuit,
        constants=real,
        purchases=tuple(Purchase(f"amplifier.{key}", getattr(c, key), getattr(real, key)) for key in keys),
        parts=tuple(_parts(names, series, feedback, across, bias, low_pass)),
        channels=tuple(_channels(names)),
        rate=rate,
        corner=1 / (2 * math.pi * low_pass[0].value * low_pass[1].value),
        difference=difference,
        phase_margin=_phase_margin(real, amplifier.topology),
        rest_error=(OPAMP_BIAS + CLAMP_LEAKAGE) * (bias or feedback).value,
        test_frequency=test_frequency,
        test_gain=_test_gain(real, follows, test_frequency),
    )


def _check_rails(amplifier: Amplifier) -> None:
    """Raise InputError for rails that are not a board's; one without rails and reference passes."""
    if amplifier.rails == UNLIMITED and not amplifier.reference:
        return
    low, high = amplifier.rails
    half = SUPPLY / 2
    for key, value, (least, most) in (
        ("rail_low", low, (0.0, half)),
        ("reference", amplifier.reference, (0.95 * half, 1.05 * half)),
        ("rail_high", high, (half, SUPPLY)),
    ):
        if not least <= value <= most:
            rule = f"must be {least:.4g} to {most:.4g} V on a board of {SUPPLY:g} V"
            shown = value if math.isfinite(value) else None
            raise InputError(f"amplifier.{key}", rule, shown, "take those of single-supply: 0.02, 1.65, 3.28")


def strip_names(strips: int | str | Sequence[str]) -> tuple[str, ...]:
    """Return the strips' names of a number of strips, of names, or of either as text.

    Raises InputError unless they are 4 to 16 different names of a ridge and S1 or S2.
    """
    text = strips if isinstance(strips, str) else ""
    count = int(text) if re.fullmatch(r"[+-]?[0-9]{1,9}", text.strip()) else strips
    remedy = f"make several boards for more than {MOST}, and leave channels bare for fewer than {FEWEST}"
    if isinstance(count, int):
        if not FEWEST <= count <= MOST:
            raise InputError("strips", f"must be {FEWEST} to {MOST}", count, remedy)
        return tuple(f"{1 + n // 2}S{1 + n % 2}" for n in range(count))
    rows = text.split(",") if isinstance(strips, str) else count
    if not isinstance(rows, Sequence) or not all(isinstance(name, str) for name in rows):
        raise InputError("strips", "must be a number, or names as 2S1,2S2,3S1,3S2", strips)
    names = tuple("".join(name.split()) for name in rows)
    for name in names:
        if not NAME.fullmatch(name):
            raise InputError("strips", "must be a number, or names as 2S1,2S2,3S1,3S2", name)
    if len(set(names)) < len(names):
        raise InputError("strips", "must name each strip once", ",".join(names))
    if not FEWEST <= len(names) <= MOST:
        raise InputError("strips", f"must name {FEWEST} to {MOST} strips", len(names), remedy)
    return names


def resistor(value: float, key: str) -> Chip:
    """Return the nearest resistor to a value in ohm; raises InputError, of `amplifier.<key>`, beyond 1 ohm to
    10 Gohm."""
    if not 1.0 <= value <= HIGH:
        remedy = f"--set amplifier.{key}={min(max(value, 1), HIGH):g}"
        raise InputError(f"amplifier.{key}", f"must be 1 to {HIGH:g} ohm on a board", value, remedy)
    if value < HALF_WAY:
        value = min(_nearest(value, E96), ORDINARY)
        return Chip(value, _printed(value), R0603, "Yageo", f"RC0603FR-07{_code(value)}L")
    value = max(_nearest(value, E24), 11e6)
    high, letter = (value / 1e9, "G") if value >= 1e9 else (value / 1e6, "M")
    digits = f"{high:.2f}" if high < 10 else f"{high:.1f}" if high < 100 else f"{high:.0f}."
    footprint = "Resistor_SMD:R_1206_3216Metric"
    return Chip(value, _printed(value), footprint, "Stackpole", f"HMC1206JT{digits.replace('.', letter)}")


def capacitor(value: float, key: str) -> Chip:
    """Return the nearest capacitor of class 1 (C0G) to a value in F; raises InputError, of `amplifier.<key>`,
    beyond 0.3 pF to 10 nF."""
    pico = value / PICO
    if not TENTHS[0] * (1 - 1e-9) <= pico <= 1e4 * (1 + 1e-9):
        remedy = f"--set amplifier.{key}={0.3e-12 if pico < 1 else 1e-8:g}"
        raise InputError(f"amplifier.{key}", "must be 0 or 0.3e-12 to 1e-8 F on a board", value, remedy)
    if pico < 0.95:
        pico = min(TENTHS, key=lambda step: abs(step - pico))
        digits = f"{round(100 * pico)}8"
    else:
        pico = max(1.0, _nearest(pico, E24))
        power = math.floor(math.log10(pico) + 1e-9)
        digits = f"{round(10 * pico / 10**power)}{power - 1 if power else 9}"
    value = float(f"{pico:.6g}e-12")
    text = _printed(value)
    if pico <= 100:
        tolerance = "B" if pico < 10 else "J"
        return Chip(value, text, C0603, "KEMET", f"CBR06C{digits}{tolerance}5GAC")
    return Chip(value, text, C0603, "Murata", f"GRM1885C1H{digits}JA01D")


def _nearest(value: float, series: Sequence[int]) -> float:
    """The value of a series, of any power of ten, nearest by its logarithm."""
    power = math.floor(math.log10(value) + 1e-12)
    scale = series[0]
    steps = [*series, 10 * scale]
    best = min(steps, key=lambda step: abs(math.log(step / scale) - math.log(value / 10**power)))
    return float(f"{best / scale * 10**power:.6g}")


PREFIXES = {-12: "p", -9: "n", -6: "u", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}


def _printed(value: float) -> str:
    """A value with its prefix, as 4.99k."""
    power = min(9, max(-12, 3 * math.floor(math.log10(value) / 3 + 1e-9)))
    return f"{value / 10.0**power:.4g}{PREFIXES[power]}"


def _code(value: float) -> str:
    """A resistance as IEC 60062 writes it: the letter stands for the point, as 4K99."""
    power = max(0, min(2, math.floor(math.log10(value) / 3 + 1e-9)))
    whole, _, part = f"{value / 1000**power:.4g}".partition(".")
    return f"{whole}{'RKM'[power]}{part}"


def _low_pass(circuit: Circuit) -> tuple[float, float, tuple[Chip, Chip]]:
    """The rate and the corner wanted, Hz, and resistor and capacitor before the converter.

    The capacitor gives the converter's own, about 2 pF (assumption), its charge: 10 nF holds it within one
    step of 12 bits.
    """
    rate = circuit.sampling.rate if circuit.sampling else None
    low, high = RATES
    if rate is None or not low <= rate <= high:
        rule = "must be " + "given" * (rate is None) + f"{low:g} to {high:g} Hz" * (rate is not None)
        rule += " for a board, whose low-pass depends on it"
        raise InputError("sampling.rate", rule, rate, "--set sampling.rate=5000")
    corner = PASS * rate / 2
    chip = capacitor(10e-9, "")
    return rate, corner, (resistor(1 / (2 * math.pi * corner * chip.value), ""), chip)


def _feedback_capacitor(c: Constants, topology: str) -> Chip:
    """The capacitor beside the feedback's resistor: the circuit's, or the least that keeps it steady."""
    key = "feedback_capacitance"

    def margin(chip: Chip) -> float:
        return _phase_margin(replace(c, feedback_capacitance=chip.value), topology)

    given = capacitor(c.feedback_capacitance, key) if c.feedback_capacitance else None
    if given and margin(given) >= RINGING:
        return given
    steps = (step * PICO for step in (*TENTHS, *(e * 10.0**n for n in range(-1, 3) for e in E24)))
    least = next((chip for step in steps if margin(chip := capacitor(step, key)) >= STEADY), None)
    if least and not given:
        return least
    rule = f"leaves the amplifier less than {RINGING:g} degrees of phase margin"
    remedy = f"--set amplifier.{key}={least.value:g}" if least else "take less capacitance at the input"
    raise InputError(f"amplifier.{key}", rule, c.feedback_capacitance, remedy)


def _phase_margin(c: Constants, topology: str) -> float:
    """The phase margin of an amplifier, degrees: of its open loop of one pole and the feedback's divider.

    The divider lies between the feedback's impedance and the input's: of the inverting input the film behind
    its resistor, diodes and chip, of a follower's inverting input the chip alone.
    """
    s = np.asarray(2j * np.pi * np.geomspace(1e-6, 10 * c.gain_bandwidth, 8000), np.complex128)
    back = 1 / (1 / c.feedback_resistance + s * c.feedback_capacitance)
    if topology == FOLLOWER:
        ahead = 1 / (s * (OPAMP_COMMON + OPAMP_DIFFERENTIAL))
    else:
        ahead = 1 / (s * c.input_capacitance + 1 / (c.series_resistance + 1 / (s * c.capacitance)))
    loop = c.gain / (1 + s * c.gain / (2 * np.pi * c.gain_bandwidth)) * ahead / (ahead + back)
    last = int(np.flatnonzero(np.abs(loop) >= 1)[-1])
    return float(180 + np.degrees(np.unwrap(np.angle(loop))[last]))


def _test_gain(c: Constants, follows: bool, frequency: float) -> float:
    """The gain from a generator through `PROBE` in a film's place, V/V, of an ideal amplifier."""
    s = 2j * math.pi * frequency
    if follows:
        return abs(s * PROBE / (s * (PROBE + c.input_capacitance) + 1 / c.input_resistance))
    return abs(s * PROBE / (1 / c.feedback_resistance + s * c.feedback_capacitance))


def _largest_difference(circuit: Circuit, c: Constants, real: Constants, corner: float) -> float:
    """The board's gain by the circuit's where they differ most up to the corner, dB."""
    low = min(circuit.sweep.low, corner / 10)
    frequency = np.geomspace(low, corner, 200)
    wanted = response(circuit_network(circuit, c), frequency)
    bought = response(network(real, topology=circuit.amplifier.topology), frequency)
    change = decibels(bought) - decibels(wanted)
    return float(change[np.argmax(np.abs(change))])


def unit(number: int) -> tuple[str, str, tuple[str, str, str]]:
    """Return the chip, the letter and the pins (inverting, other input, output) of an amplifier, from 0."""
    pins = (("2", "3", "1"), ("6", "5", "7"), ("9", "10", "8"), ("13", "12", "14"))[number % UNITS]
    return f"U{1 + number // UNITS}", "ABCD"[number % UNITS], pins


def _channels(names: Sequence[str]) -> Iterator[Channel]:
    for n, strip in enumerate(names):
        chip, letter, _ = unit(n)
        yield Channel(strip, 2 * n + 1, 2 * n + 2, f"{chip}{letter}", n + 3, *INPUTS[n])


def _parts(
    names: Sequence[str],
    series: Chip,
    feedback: Chip,
    across: Chip,
    bias: Chip | None,
    low_pass: tuple[Chip, Chip],
) -> Iterator[BoardPart]:
    """All parts with their nets. A strip's nets: 3S1+ at the film, 3S1/c between the diodes, 3S1/i at the
    input, 3S1/b behind a follower's feedback, 3S1/o at the output, and 3S1 at the converter."""
    chips: dict[str, dict[str, str]] = {}

    def amplifier(number: int, minus: str, plus: str, out: str) -> None:
        chip, _, pins = unit(number)
        chips.setdefault(chip, {"4": RAIL, "11": GND}).update(zip(pins, (minus, plus, out), strict=True))

    for n, strip in enumerate(names):
        at, clamp, inside, out = 100 * (n + 1), f"{strip}/c", f"{strip}/i", f"{strip}/o"
        back = f"{strip}/b" if bias else inside
        yield _part(f"R{at + 1}", "R", "series", series, f"{strip}+", clamp)
        yield _part(f"D{at + 1}", "clamp", "clamp", CLAMP, GND, RAIL, clamp)
        yield _part(f"R{at + 2}", "R", "series", series, clamp, inside)
        yield _part(f"R{at + 3}", "R", "feedback", feedback, back, out)
        yield _part(f"C{at + 1}", "C", "across", across, back, out)
        yield _part(f"R{at + 4}", "R", "low-pass", low_pass[0], out, strip)
        yield _part(f"C{at + 2}", "C", "low-pass", low_pass[1], strip, GND)
        if bias:
            yield _part(f"R{at + 5}", "R", "bias", bias, inside, MIDDLE)
        amplifier(n, back, inside if bias else MIDDLE, out)
    count = len(names)
    amplifier(count, "middle", "half", "middle")
    spares = -(count + 1) % UNITS
    for n in range(spares):
        amplifier(count + 1 + n, f"spare{n}", MIDDLE, f"spare{n}")
    half, smooth = resistor(100e3, ""), resistor(100.0, "")
    yield _part("R1", "R", "divider", half, RAIL, "half")
    yield _part("R2", "R", "divider", half, "half", GND)
    yield _part("R3", "R", "middle", smooth, "middle", MIDDLE)
    yield _part("C1", "C", "bulk", BULK, RAIL, GND)
    yield _part("C2", "C", "divider", MICRO, "half", GND)
    yield _part("C3", "C", "middle", MICRO, MIDDLE, GND)
    yield _part("FB1", "ferrite", "ferrite", FERRITE, SOURCE, RAIL)
    for n, (chip, nets) in enumerate(chips.items()):
        yield BoardPart(chip, "opamp", "amplifier", *OPAMP[1:], nets=nets)
        yield _part(f"C{4 + n}", "C", "bypass", BYPASS, RAIL, GND)
    film = [net for strip in names for net in (f"{strip}+", MIDDLE)]
    converter = [SOURCE, GND, *names, MIDDLE, GND]
    place = "Connector_PinHeader_2.54mm:PinHeader"
    two = fixed("film", f"{place}_2x{count:02d}_P2.54mm_Vertical", "Samtec", f"TSW-1{count:02d}-07-G-D")
    pins = len(converter)
    one = fixed("converter", f"{place}_1x{pins:02d}_P2.54mm_Vertical", "Samtec", f"TSW-1{pins:02d}-07-G-S")
    yield _part("J1", "film", "film", two, *film)
    yield _part("J2", "converter", "converter", one, *converter)


def _part(reference: str, kind: str, role: str, chip: Chip, *nets: str) -> BoardPart:
    return BoardPart(reference, kind, role, *chip[1:], nets={str(n): net for n, net in enumerate(nets, 1)})
