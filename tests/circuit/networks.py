"""Networks of random constants, their output from rest, and ngspice: a deck in, its vectors out."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import matrix_balance

from skincad.circuit import BOUNDS, Constants, Network, netlist, run, state_space, stepper
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
