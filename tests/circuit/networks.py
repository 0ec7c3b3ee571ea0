"""Networks of random constants, their output from rest, and ngspice: a deck in, its vectors out."""

from __future__ import annotations

import math
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from scipy.constants import Boltzmann, elementary_charge
from scipy.linalg import matrix_balance

from skincad.circuit import BOUNDS, Circuit, Constants, Network, constants, netlist, run, state_space, stepper
from skincad.circuit.response import response

LOAD = "Vload load 0 DC 0 AC 1"
needs_ngspice = pytest.mark.skipif(shutil.which("ngspice") is None, reason="ngspice is not installed")


def element_lines(network: Network) -> list[str]:
    """Return the elements' lines of a network's deck, without its load."""
    lines = netlist(network, "a deck").splitlines()
    return [line for line in lines if line and line[0] not in "*." and not line.startswith("Vload")]


def spice_gain_error(folder: Path, network: Network, sweep: str) -> float:
    """Return the largest relative difference of a network's gain from SPICE's."""
    spice = vectors(folder, [LOAD, *element_lines(network)], f"ac {sweep}", ["v(vout)"])
    return float(np.abs(response(network, spice["frequency"].real) / spice["v(vout)"] - 1).max())


def vectors(folder: Path, lines: list[str], analysis: str, saved: list[str]) -> dict[str, np.ndarray]:
    """Run one analysis of a deck's lines; return the scale and the saved vectors, all digits."""
    deck = [
        "* deck", *lines, ".control", "set filetype=binary", "save " + " ".join(saved), analysis,
        "write out.raw", "quit", ".endc", ".end", "",
    ]  # fmt: skip
    (folder / "deck.cir").write_text("\n".join(deck))
    process = subprocess.run(
        ["ngspice", "-b", "deck.cir"], cwd=folder, capture_output=True, text=True, check=False, timeout=120
    )
    assert (folder / "out.raw").is_file(), process.stdout + process.stderr
    head, _, body = (folder / "out.raw").read_bytes().partition(b"Binary:\n")
    rows = head.decode().splitlines()
    start = rows.index("Variables:") + 1
    names = [row.split()[1] for row in rows[start:]]
    kind = complex if any("complex" in row for row in rows[:start]) else float
    table = np.frombuffer(body, kind).reshape(-1, len(names))
    return {name: table[:, i] for i, name in enumerate(names)}


def random_sets(count: int, seed: int = 6) -> list[Constants]:
    """Return constants drawn evenly in their logarithms."""
    draw, sets = np.random.default_rng(seed), []
    for _ in range(count):
        values = {name: float(np.exp(draw.uniform(*np.log(bounds)))) for name, bounds in BOUNDS.items()}
        values["motional_capacitance"] *= values["capacitance"]
        sets.append(Constants(d33=-33e-12, **values))
    return sets


def state_response(network: Network, charge: float, frequency: np.ndarray) -> np.ndarray:
    """Return the response `(n,)` V/N of the state equations, solved at jw, to `charge` C/N."""
    s, jw = state_space(network), 2j * np.pi * frequency
    a, (units, _) = matrix_balance(s.a, permute=False, separate=True)
    rows = jw[:, None, None] * np.eye(s.b.size) - a
    states = np.linalg.solve(rows, (s.b / units)[:, None])[:, :, 0]
    return np.asarray(charge * (jw * (states @ (s.c * units)) + s.d))


def output(network: Network, charge: np.ndarray, rate: float) -> np.ndarray:
    """Return the output `(n,)` V for a charge `(n,)` C sampled at `rate` Hz, at rest before."""
    return run(stepper(network, rate), charge)[0]


SECOND_POLE = 14e6  # Hz; a phase margin of 55 degrees at 10 MHz, which ours has not
CLAMP = 1e3  # S, of the rails: 60 mA of the input stage are 60 uV
KELVIN = 293.15  # of SPICE's 20 degrees
VOLT = Boltzmann * KELVIN / elementary_charge


def bought(circuit: Circuit, load: str) -> list[str]:
    """A deck of a circuit with an operational amplifier of the maker's figures, in volts from ground.

    Its input stage drives an integrator whose voltage stops at the rails, so that nothing winds up beyond
    them; then comes a second pole. 1/f noise is a diode's, as in makers' macromodels: shot noise and KF.
    """
    c, a, noise = constants(circuit), circuit.amplifier, circuit.noise
    low, high = (limit if math.isfinite(limit) else math.copysign(1e6, limit) for limit in a.rails)
    inverting = a.topology == "inverting"
    plus, minus = ("ref", "in") if inverting else ("in", "back")
    store, drive = 1e-9, 1e-6  # F of the integrator; A through the noise's diodes
    stage = 2 * math.pi * a.gain_bandwidth * store
    shot = VOLT / drive * math.sqrt(2 * elementary_charge * drive)  # V/sqrt(Hz) over a diode
    seen = max(noise.voltage_density, 1e-15) / shot / math.sqrt(2)  # of each of two diodes
    heard = noise.current_density / math.sqrt(4 * Boltzmann * KELVIN * 1e6)
    back = "in" if inverting else "back"
    return [
        load,
        f"Vref ref 0 {a.reference!r}",
        f"Epv pv ref load 0 {c.d33 / c.capacitance!r}",
        f"Cpvd pv film {c.capacitance!r}",
        f"Rmot film m1 {c.motional_resistance!r}",
        f"Lmot m1 m2 {c.motional_inductance!r}",
        f"Cmot m2 ref {c.motional_capacitance!r}",
        f"R12 film in {c.series_resistance!r}",
        f"R34 out {back} {c.feedback_resistance!r}",
        *[f"C34 out {back} {c.feedback_capacitance!r}"] * bool(c.feedback_capacitance),
        f"Rin in ref {c.input_resistance!r}",
        f"Cin in 0 {c.input_capacitance!r}",
        f"Ibias in 0 {a.input_bias_current!r}",
        "Rheard heard 0 1e6",
        f"Gheard in 0 heard 0 {heard!r}",
        f"Id1 0 d1 {drive!r}", "D1 d1 0 flicker",
        f"Id2 0 d2 {drive!r}", "D2 d2 0 flicker",
        f".model flicker D(IS=1e-14 N=1 KF={2 * elementary_charge * noise.voltage_corner!r} AF=1)",
        f"Eseen seen {plus} d1 d2 {seen!r}",
        f"Gstage 0 x seen {minus} {stage!r}",
        f"Cx x 0 {store!r}",
        f"Gx x 0 x 0 {stage / a.gain!r}",
        f"Bclamp x 0 I={CLAMP!r}*(max(V(x)-{high!r},0)+min(V(x)-{low!r},0))",
        "Ey y 0 x 0 1", "Ry y z 1", f"Cz z 0 {1 / (2 * math.pi * SECOND_POLE)!r}", "Ez amp 0 z 0 1",
        f"Ropo amp out {c.output_resistance!r}",
        "Evout vout 0 ref out 1" if inverting else "Evout vout 0 out ref 1",
        ".options temp=20 tnom=20 reltol=1e-5 abstol=1e-16 method=gear",
    ]  # fmt: skip
