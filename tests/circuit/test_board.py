"""The amplifier board: what its schematic connects, its parts and pins, and its gain."""

from __future__ import annotations

import csv
import io
import json
import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import skincad
from skincad.circuit import (
    Board,
    board,
    circuit_network,
    constants,
    load_circuit,
    state_space,
    without_rig,
)
from skincad.circuit.boards import INPUTS, capacitor, resistor
from skincad.circuit.network import network
from skincad.circuit.response import response
from skincad.inputs import template_names
from skincad.outputs import channels_csv, kicad_schematic, parts_csv
from tests.circuit import kicad, schematics
from tests.circuit.networks import needs_ngspice, vectors
from tests.conftest import run_skincad
from tests.refusals import refused, refused_by, refused_command

AT_5_KHZ = "sampling.rate=5000"
CIRCUITS = {  # a board of each topology, and of each amplifier that ships
    "rate": ("single-supply",),
    "charge": ("charge-amplifier", AT_5_KHZ),
    "follower": ("voltage-follower", AT_5_KHZ),
    "paper": ("yamada-2002",),
}
STRIPS = ((4, "rate"), (5, "charge"), (8, "paper"), (16, "rate"), (4, "follower"), (9, "follower"))


@cache
def board_of(circuit: str, strips: int | str = 8) -> Board:
    name, *settings = CIRCUITS[circuit]
    return board(load_circuit(name, settings), strips)


@cache
def drawing_of(circuit: str, strips: int | str = 8) -> schematics.Drawing:
    return schematics.read(kicad_schematic(board_of(circuit, strips)))


def wanted_nets(layout: Board) -> dict[str, frozenset[schematics.Pin]]:
    """The pins of each net, by the list of parts."""
    nets: dict[str, set[schematics.Pin]] = {}
    for part in layout.parts:
        for number, net in part.nets.items():
            nets.setdefault(net, set()).add((part.reference, number))
    return {net: frozenset(pins) for net, pins in nets.items()}


def table(text: str) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(text)))


@pytest.mark.parametrize(("strips", "circuit"), STRIPS)
def test_the_drawing_connects_what_the_parts_list_says(strips: int, circuit: str) -> None:
    layout, drawing = board_of(circuit, strips), drawing_of(circuit, strips)
    wanted = wanted_nets(layout)
    assert set(drawing.nets) == set(wanted.values())
    assert min(map(len, drawing.nets)) > 1  # no pin hangs in the air
    assert drawing.dots == drawing.meetings  # a reader sees what is connected
    named = {name: pins for pins, names in drawing.nets.items() for name in names}
    strip_nets = {net for c in layout.channels for net in (c.strip, f"{c.strip}+")}
    assert named == {net: wanted[net] for net in {"GND", "MID", "+3V3", "+3V3A"} | strip_nets}
    assert drawing.parts.keys() == {part.reference for part in layout.parts}
    for part in layout.parts:
        fields = drawing.parts[part.reference]
        assert (fields["Value"], fields["Footprint"]) == (part.value, part.footprint)
        assert (fields["Maker"], fields["Number"]) == (part.maker, part.number)


@pytest.mark.parametrize(("strips", "circuit"), STRIPS)
def test_no_text_of_the_drawing_lies_on_another(strips: int, circuit: str) -> None:
    """By boxes of KiCad's letters: as high as their size and about 0.85 times as wide. What ends at the right
    ends there; a label's flag is two letters longer than its words."""
    texts = schematics.texts(kicad_schematic(board_of(circuit, strips)))
    boxes = np.array([text.box for text in texts]) + np.array([-0.3, -0.3, 0.3, 0.3])  # mm between them
    left, low, right, high = boxes.T[:, :, None]
    over = (np.minimum(right, right.T) - np.maximum(left, left.T) > 0) & (
        np.minimum(high, high.T) - np.maximum(low, low.T) > 0
    )
    pairs = np.argwhere(np.triu(over, 1))
    assert [(texts[i].words, texts[j].words) for i, j in pairs] == []
    width, height = (420.0, 297.0) if strips <= 9 else (594.0, 420.0)
    assert boxes[:, :2].min() > 12  # the frame
    assert boxes[:, 2].max() < width - 12
    assert boxes[:, 3].max() < height - 45  # the title's block is 33 high


@pytest.mark.parametrize("strips", range(4, 17))
def test_each_strip_has_an_amplifier_and_an_input_of_its_own(strips: int) -> None:
    layout = board_of("rate", strips)
    rows = table(channels_csv(layout))
    assert [row["strip"] for row in rows] == [*(c.strip for c in layout.channels), "MID"]
    assert len({row["teensy_pin"] for row in rows}) == len({row["amplifier"] for row in rows}) == strips + 1
    assert 0 <= layout.spare < 4
    assert layout.chips * 4 == strips + 1 + layout.spare
    pairs = zip(layout.channels[::2], layout.channels[1::2], strict=False)
    assert all({a.converter, b.converter} == {1, 2} for a, b in pairs)  # a ridge's strips at once


def test_the_map_is_what_the_drawing_connects() -> None:
    """From the film's pin over resistors, diodes and amplifier to the converter's pin."""
    drawing = drawing_of("follower", "2S1,2S2,3S1,3S2")

    def beyond(pin: schematics.Pin) -> frozenset[schematics.Pin]:
        return next(pins for pins in drawing.nets if pin in pins)

    for n, row in enumerate(table(channels_csv(board_of("follower", "2S1,2S2,3S1,3S2")))[:-1], 1):
        plus, minus, out = (tuple(row[key].split(".")) for key in ("film_plus", "film_minus", "output"))
        assert beyond(plus) == drawing.named(f"{row['strip']}+") == {plus, (f"R{n}01", "1")}
        assert beyond(minus) == drawing.named("MID")
        assert beyond(out) == drawing.named(row["strip"]) == {out, (f"R{n}04", "2"), (f"C{n}02", "1")}
        assert (f"R{n}04", "1") in beyond((f"R{n}03", "2"))


def test_inputs_are_those_of_a_teensy() -> None:
    """Pins: PJRC's card of the Teensy 4.1. Converters: its core's analog.c, where 38, 39, 26 and 27 hang on
    the second one, and 24 and 25 on the first."""
    pins = {f"A{n}": 14 + n for n in range(14)} | {"A14": 38, "A16": 40, "A17": 41}
    assert {name: pin for name, pin, _ in INPUTS} == pins
    fixed = {pin: converter for _, pin, converter in INPUTS if pin in (24, 25, 26, 27, 38, 39)}
    assert fixed == {24: 1, 25: 1, 26: 2, 27: 2, 38: 2}


def test_the_parts_list_has_each_part_once() -> None:
    layout = board_of("rate", 5)
    rows = table(parts_csv(layout))
    names = [name for row in rows for name in row["reference"].split()]
    assert sorted(names) == sorted(part.reference for part in layout.parts)
    assert all(int(row["quantity"]) == len(row["reference"].split()) for row in rows)
    assert all(row[key] for row in rows for key in row)
    assert len({row["number"] for row in rows}) == len(rows)


@pytest.mark.parametrize(
    ("value", "number"),  # source: as distributors and the makers' data sheets list them
    [(1e5, "RC0603FR-07100KL"), (4.99e3, "RC0603FR-074K99L"), (100, "RC0603FR-07100RL"),
     (1e6, "RC0603FR-071ML"), (50e6, "HMC1206JT51M0"), (1e8, "HMC1206JT100M"), (1e10, "HMC1206JT10G0")],
)  # fmt: skip
def test_resistors_have_their_makers_numbers(value: float, number: str) -> None:
    assert resistor(value, "").number == number


def test_a_part_is_the_nearest_of_its_series() -> None:
    """Within half a step: 1.5 % of E96, rounded to three digits, and 7.5 % of E24, from 13 to 15."""
    draw = np.random.default_rng(60)
    for value in np.exp(draw.uniform(*np.log([10, 9.9e6]), 200)):
        assert resistor(value, "").value == pytest.approx(value, rel=0.015)
        assert schematics.value(resistor(value, "").text) == pytest.approx(resistor(value, "").value)
    for value in np.exp(draw.uniform(*np.log([11e6, 10e9]), 200)):
        assert resistor(value, "").value == pytest.approx(value, rel=0.075)
    for value in np.exp(draw.uniform(*np.log([1e-12, 1e-8]), 200)):
        chip = capacitor(value, "")
        assert chip.value == pytest.approx(value, rel=0.075)
        digits, power = re.search(r"(\d\d)(\d)[BJ]", chip.number).groups()  # 9: tenths of a picofarad
        picofarads = int(digits) * 10.0 ** (-1 if power == "9" else int(power))
        assert 1e-12 * picofarads == pytest.approx(chip.value)
    assert capacitor(0.34e-12, "")[:2] == (0.3e-12, "0.3p")


@pytest.mark.parametrize("name", template_names("circuits"))
def test_a_shipped_circuit_has_a_board_or_a_line_that_gives_it_one(name: str) -> None:
    settings: list[str] = []
    for _ in range(4):
        try:
            layout = board(load_circuit(name, settings), 4)
        except skincad.InputError as refusal:
            settings += re.findall(r"--set (\S+?)(?=[:;,]|$)", refusal.remedy)
        else:
            assert abs(layout.difference) <= 1.0
            return
    pytest.fail(f"{name}: {settings}")


@pytest.mark.parametrize(
    ("setting", "start"),
    [
        ("amplifier.series_resistance=100", "amplifier.series_resistance: must be 4000 to 2e+07"),
        ("amplifier.feedback_resistance=1e11", "amplifier.feedback_resistance: must be 1 to 1e+10"),
        ("amplifier.feedback_capacitance=1e-13", "amplifier.feedback_capacitance: must be 0 or 0.3e-12"),
        ("amplifier.feedback_capacitance=0", "amplifier.feedback_capacitance: parts that can be bought"),
        ("sampling=none", "sampling.rate: must be given"),
        ("sampling.rate=1e5", "sampling.rate: must be 100 to 50000"),
    ],
)
def test_a_circuit_that_no_part_gives_is_refused(setting: str, start: str) -> None:
    steady = [] if "capacitance" in setting else ["amplifier.feedback_capacitance=0.3e-12"]
    with refused_by(start):
        board(load_circuit("transimpedance", [*steady, setting]))


@pytest.mark.parametrize(
    ("setting", "start"),
    [
        ("amplifier.rail_high=5", "amplifier.rail_high: must be 1.65 to 3.3 V on a board of 3.3 V, got 5"),
        ("amplifier.rail_high=none", "amplifier.rail_high: must be 1.65 to 3.3 V"),
        ("amplifier.rail_low=-1", "amplifier.rail_low: must be 0 to 1.65 V"),
        ("amplifier.reference=1", "amplifier.reference: must be 1.567 to 1.732 V"),
    ],
)
def test_rails_of_another_supply_are_refused(setting: str, start: str) -> None:
    with refused_by(start):
        board(load_circuit("single-supply", [setting]))


@pytest.mark.parametrize(
    ("strips", "words"),
    [(3, "must be 4 to 16, got 3"), ("17", "must be 4 to 16, got 17"), (-4, "must be 4 to 16"),
     ("2S1,2S2,3S1", "must name 4 to 16 strips, got 3"), ("2S1,2S1,3S1,3S2", "must name each strip once"),
     ("2S1,2S3,3S1,3S2", "must be a number, or names as"), ("4.5", "must be a number")],
)  # fmt: skip
def test_other_strips_are_refused(strips: int | str, words: str) -> None:
    with refused(f"strips: {words}"):
        board_of("paper", strips)


def test_names_may_be_as_the_casting_sheet_has_them() -> None:
    names = [c.strip for c in board_of("paper", "2 S1, 2 S2,3 S1,3 S2").channels]
    assert names == ["2S1", "2S2", "3S1", "3S2"]


def test_the_command_writes_the_board_beside_the_gain(tmp_path: Path) -> None:
    line = ("circuit", "voltage-follower", "--set", AT_5_KHZ, "--board", "amp", "--strips", "5")
    process = run_skincad(*line, "--json", cwd=tmp_path)
    assert (process.returncode, process.stderr) == (0, "")
    data = json.loads(process.stdout)["board"]
    files = {path.name: path.read_bytes() for path in (tmp_path / "amp").iterdir()}
    assert files.keys() == {
        "voltage-follower.kicad_sch", "voltage-follower.kicad_pro", "bom.csv", "channels.csv", "board.md",
        "board.json",
    }  # fmt: skip
    assert {entry["path"]: entry["bytes"] for entry in data["files"]} == {
        f"amp/{name}": len(text) for name, text in files.items() if name != "board.json"
    }
    assert len(data["channels"]) == 5
    assert json.loads(files["voltage-follower.kicad_pro"])["meta"]["version"] == 1
    assert b"No board has been built" in files["board.md"]
    assert len(files["board.md"].split()) < 700  # a page
    said = run_skincad(*line, cwd=tmp_path).stdout  # again, over the same files
    assert "voltage-follower: a board for 5 strips, 1S1 to 3S1, on 3.3 V." in said
    assert "the circuit names no rails" in said
    assert {path.name: path.read_bytes() for path in (tmp_path / "amp").iterdir()} == files


@pytest.mark.slow
def test_a_board_is_refused_before_anything_is_written(tmp_path: Path) -> None:
    start = ("circuit", "yamada-2002")
    assert refused_command(*start, "--strips", "5", cwd=tmp_path).startswith("--strips: needs --board")
    line = refused_command(*start, "--board", "amp", "--strips", "3", cwd=tmp_path)
    assert line.startswith("--strips: must be 4 to 16, got 3")
    line = refused_command("circuit", "charge-amplifier", "--board", "amp", cwd=tmp_path)
    assert line.endswith("--set sampling.rate=5000")
    line = refused_command(*start, "--board", "amp", "--measured", "m.csv", cwd=tmp_path)
    assert line.startswith("--board: is of a circuit as it is")


@pytest.mark.parametrize("circuit", CIRCUITS)
def test_an_amplifier_does_not_ring(circuit: str) -> None:
    """The poles of the whole network, film and amplifier of finite bandwidth: a phase margin of 60 degrees is
    a damping of about 0.6 of two poles, 45 degrees one of 0.4. The film's own resonance, at 57 kHz with a
    quality of about 15, is none of the amplifier's: it is left out by its motional branch's value."""
    layout = board_of(circuit)
    assert layout.phase_margin >= 45
    topology = layout.circuit.amplifier.topology

    def damping(capacitance: float) -> float:
        c = layout.constants
        values = vars(c) | {"feedback_capacitance": capacitance, "motional_capacitance": 1e-6 * c.capacitance}
        poles = np.linalg.eigvals(state_space(network(type(c)(**values), topology=topology)).a)
        poles = poles[np.abs(poles) < 2 * np.pi * 1e9]
        film = 1 / np.sqrt(c.motional_inductance * 1e-6 * c.capacitance)
        own = poles[np.abs(np.abs(poles) / film - 1) > 0.05]
        return float((-own.real / np.abs(own)).min())

    assert damping(layout.constants.feedback_capacitance) > 0.4
    if not constants(layout.circuit).feedback_capacitance and topology == "inverting":
        assert damping(0.0) < 0.4  # what the board adds is needed


# A chip's amplifier as its data sheet has it (SBOS839): 130 dB, 10 MHz, 50 ohm, 4 pF and 2 pF at the inputs
AMPLIFIER = """.subckt amplifier minus plus out
Eg fast 0 plus minus 3162277.66
Rg fast slow 1
Cg slow 0 {capacitance!r}
Eo amp 0 slow 0 1
Ro amp out 50
Cm minus 0 4p
Cp plus 0 4p
Cd plus minus 2p
.ends
.model clamp D(IS=3e-12 CJO=2e-12 M=0.01 RS=1)
.options gmin=1e-17 reltol=1e-5"""
UNITS = {"": ("2", "3", "1"), "b": ("6", "5", "7"), "c": ("9", "10", "8"), "d": ("13", "12", "14")}


def deck(layout: Board, drawing: schematics.Drawing) -> tuple[list[str], dict[schematics.Pin, str]]:
    """A board's SPICE lines as it is drawn, and the node of each pin: films on all strips, a load on the
    first."""
    nodes = {pin: f"n{i}" for i, pins in enumerate(drawing.nets) for pin in pins}
    ground = nodes["J2", "2"]
    nodes = {pin: "0" if node == ground else node for pin, node in nodes.items()}
    lines = AMPLIFIER.format(capacitance=10**6.5 / (2 * np.pi * 10e6)).splitlines()
    for name, fields in drawing.parts.items():
        if name[0] in "RC":
            lines.append(
                f"{name} {nodes[name, '1']} {nodes[name, '2']} {schematics.value(fields['Value'])!r}"
            )
        elif name[0] == "D":
            lines.append(f"{name}a {nodes[name, '1']} {nodes[name, '3']} clamp")
            lines.append(f"{name}b {nodes[name, '3']} {nodes[name, '2']} clamp")
        elif name[0] == "U":
            for letter, pins in UNITS.items():
                lines.append(" ".join([f"X{name}{letter}", *(nodes[name, pin] for pin in pins), "amplifier"]))
        elif name == "FB1":
            lines.append(f"RFB1 {nodes[name, '1']} {nodes[name, '2']} 0.3")
    c = constants(without_rig(layout.circuit))
    lines += [f"Vs {nodes['J2', '1']} 0 DC 3.3", "Vload load 0 DC 0 AC 1"]
    for channel in layout.channels:
        n, plus, minus = channel.plus, nodes["J1", str(channel.plus)], nodes["J1", str(channel.minus)]
        load = "load" if n == 1 else "0"
        lines += [f"Epv{n} pv{n} {minus} {load} 0 {c.d33 / c.capacitance!r}"]
        lines += [f"Cpv{n} pv{n} {plus} {c.capacitance!r}", f"Rm{n} {plus} a{n} {c.motional_resistance!r}"]
        lines += [f"Lm{n} a{n} b{n} {c.motional_inductance!r}"]
        lines += [f"Cm{n} b{n} {minus} {c.motional_capacitance!r}"]
    return lines, nodes


@pytest.mark.evidence(subject="amplifier board")
@needs_ngspice
@pytest.mark.parametrize("circuit", CIRCUITS)
def test_the_drawn_board_has_the_circuits_gain(circuit: str, tmp_path: Path) -> None:
    """The schematic's own connections in ngspice, all channels at once, against the circuit's network.

    Up to the low-pass's corner within 1 dB of the circuit behind one pole, and up to a quarter of it, where
    the pole takes 0.26 dB, of the circuit itself. At rest all outputs are at half the supply: within 3 mV by
    the diodes' different currents, which the larger resistors turn into volts. Beside the loaded strip the
    others are quiet to 60 dB, by what the middle of the supply lets through."""
    layout, drawing = board_of(circuit, 5), drawing_of(circuit, 5)
    lines, nodes = deck(layout, drawing)
    low = max(layout.circuit.sweep.low, layout.corner / 1000)
    outputs = {c.strip: f"v({nodes['J2', str(c.output)]})" for c in layout.channels}
    middle = f"v({nodes['J2', '8']})"
    saved = [*outputs.values(), middle]
    spice = vectors(tmp_path, lines, f"ac dec 20 {low} {layout.corner}", saved)
    frequency = spice["frequency"].real
    sign = 1 if layout.circuit.amplifier.topology == "follower" else -1
    drawn = sign * (spice[outputs["1S1"]] - spice[middle])
    wanted = response(circuit_network(without_rig(layout.circuit)), frequency)
    behind = drawn / wanted * (1 + 1j * frequency / layout.corner)
    assert np.abs(20 * np.log10(np.abs(behind))).max() < 1.0
    assert np.abs(np.angle(behind)).max() < 0.2  # and the sign
    early = frequency <= layout.corner / 4
    assert np.abs(20 * np.log10(np.abs(drawn / wanted)))[early].max() < 1.0
    for strip in list(outputs)[1:]:
        assert np.abs(spice[outputs[strip]] - spice[middle]).max() < 1e-3 * np.abs(drawn).max()
    (tmp_path / "rest").mkdir()
    rest = vectors(tmp_path / "rest", lines, "op", saved)
    assert rest[middle][0] == pytest.approx(1.65, abs=0.01)  # 1 % resistors are nominal here; 10 mA of supply
    assert [rest[name][0] for name in outputs.values()] == pytest.approx([rest[middle][0]] * 5, abs=3e-3)


@pytest.mark.evidence(subject="amplifier board")
@needs_ngspice
@pytest.mark.parametrize("circuit", ["rate", "charge", "follower"])
def test_a_generator_through_a_capacitor_gives_what_the_page_says(circuit: str, tmp_path: Path) -> None:
    layout = board_of(circuit, 4)
    lines, nodes = deck(layout, drawing_of(circuit, 4))
    bare = [line for line in lines if not re.match(r"(Epv|Cpv|Rm|Lm|Cm\d)", line)]
    bare.append(f"Cprobe load {nodes['J1', '1']} 10p")
    out, f = f"v({nodes['J2', '3']})", layout.test_frequency
    spice = vectors(tmp_path, bare, f"ac lin 1 {f} {f}", [out])
    assert np.abs(spice[out])[0] == pytest.approx(
        layout.test_gain, rel=0.02
    )  # the low-pass: 0.5 % at a tenth


@pytest.mark.evidence(subject="amplifier board")
@kicad.needs_kicad
@pytest.mark.parametrize(("strips", "circuit"), [(16, "rate"), (5, "follower")])
def test_kicad_reads_the_same_connections_and_has_no_complaint(
    strips: int, circuit: str, tmp_path: Path
) -> None:
    layout = board_of(circuit, strips)
    skincad.write(layout, tmp_path / "amp")
    netlist, report = kicad.netlist_and_rules(
        tmp_path / "amp" / f"{layout.name}.kicad_sch", tmp_path / "home"
    )
    (nets,) = schematics.of(schematics.parsed(netlist), "nets")
    node = {"ref": "", "pin": ""}
    drawn = {
        frozenset(tuple(schematics.of(pin, key)[0][1] for key in node) for pin in schematics.of(net, "node"))
        for net in schematics.of(nets, "net")
    }
    assert drawn == set(wanted_nets(layout).values())
    assert "ERC messages: 0  Errors 0  Warnings 0" in report


@pytest.mark.evidence(subject="amplifier board")
@kicad.needs_kicad
def test_kicad_complains_of_a_board_with_a_wire_less(tmp_path: Path) -> None:
    """So the checker was run, and not only its window opened."""
    layout = board_of("paper", 4)
    skincad.write(layout, tmp_path / "amp")
    file = tmp_path / "amp" / f"{layout.name}.kicad_sch"
    text = file.read_text()
    wires = [line for line in text.splitlines(keepends=True) if line.startswith("  (wire")]
    file.write_text(text.replace(wires[0], ""))
    _, report = kicad.netlist_and_rules(file, tmp_path / "home")
    assert "not connected" in report


FOOTPRINTS = Path("/usr/share/kicad/footprints")


@pytest.mark.evidence(subject="amplifier board")
@pytest.mark.skipif(not FOOTPRINTS.is_dir(), reason="kicad-footprints is not installed")
def test_footprints_are_in_kicads_libraries() -> None:
    names = {part.footprint for n in range(4, 17) for part in board_of("rate", n).parts}
    names |= {part.footprint for part in board_of("paper").parts}
    for name in names:
        library, _, footprint = name.partition(":")
        assert (FOOTPRINTS / f"{library}.pretty" / f"{footprint}.kicad_mod").is_file(), name
