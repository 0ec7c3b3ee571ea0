"""skincad against GetFEM on the reference section with fillets: pressed to 4 N, then dragged into gross slip.

`python -m bench.getfem [friction]` prints the tables. Both programs get the section and the plate's history,
its force and travel, and nothing of each other. skincad condenses the skin to its contact points and finds
who sticks by a semi-smooth Newton on their forces; GetFEM solves the whole body, on triangles from gmsh, with
an augmented Lagrangian (`getfem_process.py`). Who sticks inside a ridge is not compared: GetFEM's traction is
linear along an edge, too coarse. GetFEM and gmsh are processes of their own (Debian packages
`python3-getfem`, LGPL, and `gmsh`), on files in a temporary folder.
"""

from __future__ import annotations

import json
import shutil
import sys
import tempfile
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from pathlib import Path
from subprocess import run
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench import calculix, runner
from skincad import load
from skincad.mechanics import (
    Compliance,
    ContactPad,
    ContactState,
    Drive,
    FrictionCoefficients,
    Pad,
    default_sizes,
    halved,
    pad_of,
    piece_of,
    sliding,
    triangles,
)
from skincad.mechanics.contact.state import at_rest

PACKAGES = ("python3-getfem", "gmsh")
PYTHON = "/usr/bin/python3"  # Debian's, whose package it is
PROCESS = Path(__file__).with_name("getfem_process.py")
QUADRATURE = 6  # degree integrated exactly: curved P2 triangles
AUGMENTATION = 10.0  # MPa/mm; 1 and 100 give the same to the residual
RESIDUAL = 1e-9  # relative
ITERATIONS = 60  # of Newton; two to six are usual
HOLD = 1e3  # N/mm a mm of length: the first contact is held at START, then let go
START = 0.02  # mm, approach of the first contact
FORCE, FRICTION = 4.0, 0.5  # N, coefficient
PRESSES, STRIDES = 4, 25  # steps of the force, of the travel
TRAVEL = 1.0  # mm times the friction, enough for gross slip
FINENESS, ORDER = (0.25, 0.5, 1.0), 3
CLEAR = 1e-6  # of the force: a ridge that bears less is clear, and what it bears is rounding
WHOLE = 0.999  # of what friction holds: a ridge that bears this slips as a whole
BARE = {"slot": None, "film": None, "contact": {"film": "ignored", "friction": 0.0}}


@dataclass(frozen=True)
class FrictionalPad:
    """A history's states, one a row: `normal` and `tangential` `(steps, ridges)` N on the skin, and the
    plate's `approach` `(steps,)` mm."""

    normal: NDArray[np.float64]
    tangential: NDArray[np.float64]
    approach: NDArray[np.float64]
    unknowns: int


@cache
def missing() -> str:
    """Return what to install, or "" where both programs are there."""
    there = Path(PYTHON).exists() and shutil.which("gmsh") is not None
    if there and run([PYTHON, "-I", "-c", "import getfem"], capture_output=True, check=False).returncode == 0:
        return ""
    return f"GetFEM is not compared: apt-get install {' '.join(PACKAGES)}"


def drag(
    pad: Pad,
    fineness: float,
    drives: list[Drive],
    friction: float,
    augmentation: float = AUGMENTATION,
    start: float = START,
) -> FrictionalPad:
    """Return GetFEM's states at these drives' ends; each needs a normal force and a travel. A softer skin
    wants a smaller `augmentation`, MPa/mm, and a larger approach `start` of the first contact, mm.

    Raises RuntimeError when a program fails.
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        lines = calculix.geometry(pad, default_sizes(pad, fineness), recombined=False)
        calculix.meshed(lines, 2, folder)
        asked = _asked(pad, drives, friction)
        asked["numbers"] |= {"augmentation": augmentation, "start": start}
        (folder / "asked.json").write_text(json.dumps(asked))
        calculix.run_program([PYTHON, "-I", str(PROCESS)], folder)
        return read((folder / "found.json").read_text(), pad.length)


def _asked(pad: Pad, drives: list[Drive], friction: float) -> dict[str, Any]:
    """What the process is told; forces are of a slice 1 mm long."""
    shear = pad.young_modulus / (2 * (1 + pad.poisson_ratio))
    numbers = {
        "shear": shear,
        "lame": 2 * shear * pad.poisson_ratio / (1 - 2 * pad.poisson_ratio),
        "coefficient": friction,
        "rate": 1.0,
        "width": sum(s.length for s in pad.section.outline if s.kind == "back"),
    }
    return {
        "back": calculix.BACK,
        "ridges": list(pad.ridges),
        "top": pad.top,
        "quadrature": QUADRATURE,
        "residual": RESIDUAL,
        "iterations": ITERATIONS,
        "hold": HOLD,
        "numbers": numbers,
        "steps": [(drive.normal / pad.length, drive.travel) for drive in drives],
    }


def read(text: str, length: float) -> FrictionalPad:
    """Return the process' answer for a pad of this length, mm."""
    data = json.loads(text)

    def table(name: str) -> NDArray[np.float64]:
        return np.array([step[name] for step in data["steps"]])

    forces = length * table("normal"), length * table("tangential")
    return FrictionalPad(*forces, table("approach"), int(data["unknowns"]))


def section() -> Pad:
    """The pad that is dragged: the paper's, without slots and films."""
    return pad_of(load("yamada-2002").with_(**BARE))


def history(friction: float = FRICTION) -> list[Drive]:
    """What the plate does: presses in a few steps, then travels."""
    presses = [Drive(FORCE * i / PRESSES, travel=0.0) for i in range(1, PRESSES + 1)]
    return presses + [Drive(FORCE, travel=TRAVEL * friction * i / STRIDES) for i in range(1, STRIDES + 1)]


def own(pad: Pad, fineness: float, order: int, drives: list[Drive], friction: float) -> FrictionalPad:
    """Return skincad's states at these drives' ends, solved on the whole section."""
    piece = piece_of(pad, 0.0, halved=False)
    answer = sliding(piece, triangles(piece.pad, default_sizes(pad, fineness)), order, False)
    m, cone = answer.gap.size, FrictionCoefficients(friction, friction)
    skin = Compliance(answer.compliance, answer.gap, np.zeros(2 * m))
    states = [at_rest(m)]
    for before, after in pairwise([Drive(0.0, travel=0.0), *drives]):
        states.append(halved(lambda _: skin, states[-1], before, after, cone))
    return _by_ridge(pad, answer, states[1:])


def _by_ridge(pad: Pad, found: ContactPad, states: list[ContactState]) -> FrictionalPad:
    member = np.equal.outer(found.ridge, np.array(pad.ridges)).astype(float)
    return FrictionalPad(
        np.array([state.normal @ member for state in states]),
        np.array([state.tangential @ member for state in states]),
        np.array([state.approach for state in states]),
        found.unknowns,
    )


def used(found: FrictionalPad, friction: float) -> NDArray[np.float64]:
    """Return what each ridge bears of what friction holds there `(steps, ridges)`; 0 where it is clear."""
    held = friction * found.normal
    clear = held <= CLEAR * held.sum(axis=1, keepdims=True)
    return np.divide(found.tangential, held, out=np.zeros_like(held), where=~clear)


def let_go(found: FrictionalPad, drives: list[Drive], friction: float) -> NDArray[np.float64]:
    """Return per ridge the travel, mm, at which it first slips as a whole, between two steps by what it
    bears; nan where it does not."""
    travel = np.array([drive.travel for drive in drives])
    ends = np.full(found.normal.shape[1], np.nan)
    for ridge, course in enumerate(used(found, friction).T):
        over = np.flatnonzero(course[1:] >= WHOLE)
        if over.size:
            before, after = course[over[0]], course[over[0] + 1]
            share = (WHOLE - before) / (after - before)
            ends[ridge] = travel[over[0]] + share * (travel[over[0] + 1] - travel[over[0]])
    return ends


def apart(one: FrictionalPad, other: FrictionalPad) -> dict[str, float]:
    """Return the largest differences over all steps: a ridge's forces against the mean one at the end, their
    tangential sum and the approach against their largest."""
    mean = other.normal[-1].mean()
    sums = [found.tangential.sum(axis=1) for found in (one, other)]
    return {
        "normal": float(np.abs(one.normal - other.normal).max() / mean),
        "tangential": float(np.abs(one.tangential - other.tangential).max() / mean),
        "pull": float(np.abs(sums[0] - sums[1]).max() / np.abs(sums[1]).max()),
        "approach": float(np.abs(one.approach - other.approach).max() / other.approach.max()),
    }


def main() -> None:
    if missing():
        print(missing())
        return
    friction = float(sys.argv[1]) if sys.argv[1:] else FRICTION
    pad, drives = section(), history(friction)
    ours = {f"skincad {f:g}": own(pad, f, ORDER, drives, friction) for f in FINENESS[1:]}
    theirs = {f"GetFEM {f:g}": drag(pad, f, drives, friction) for f in FINENESS}
    best, last = list(ours.values())[-1], list(theirs.values())[-1]
    setting = f"{FORCE:g} N, friction {friction:g}, {len(drives)} steps"
    print(f"largest differences from skincad's finest; {setting}")
    lines = []
    for name, found in (ours | theirs).items():
        off = [f"{value:.1e}" for value in apart(found, best).values()]
        ends = " ".join(f"{end:.4f}" for end in let_go(found, drives, friction))
        lines.append((name, found.unknowns, *off, ends))
    head = ("", "unknowns", "normal", "tangential", "pull", "approach", "ridges let go at, mm")
    print("\n".join(runner.table(head, lines)))
    print("\ntravel, mm; pull, N, and ridges: . clear, o hold, x slip as a whole; skincad's, GetFEM's")
    for i, drive in enumerate(drives):
        cells = [f"{found.tangential[i].sum():9.4f} {_signs(found, friction, i)}" for found in (best, last)]
        print(f"{drive.travel:6.3f}{cells[0]}{cells[1]}")


def _signs(found: FrictionalPad, friction: float, step: int) -> str:
    """A letter for each ridge."""
    borne, clear = used(found, friction)[step], found.normal[step] <= CLEAR * found.normal[step].sum()
    return "".join("." if c else "x" if b >= WHOLE else "o" for b, c in zip(borne, clear, strict=True))


if __name__ == "__main__":
    main()
