"""Rings bonded to a plate that moves along x, in three dimensions, by CalculiX.

`python -m bench.bonded_rings` prints each ring's stiffness by CalculiX and by skincad. Half of the skin is
turned from a section of rectangles, in quadratic bricks; the crests' nodes move along x alone. CalculiX is a
process of its own (Debian's package `calculix-ccx`, GPL), on files in a temporary folder.
"""

from __future__ import annotations

import math
import re
import sys
import tempfile
from collections.abc import Iterable, Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bench import calculix
from skincad import Design, Scene
from skincad.effects import CondensedPad
from skincad.scenes import LEVELS, at_level

YOUNG, POISSON = 1.0, 0.45  # MPa; bricks of less nearly incompressible silicone converge
THICKNESS, RADIUS, HEIGHT, WIDTH, RINGS = 2.0, 8.0, 1.0, 1.25, (2.0, 6.0)  # mm
SIZE, SECTORS = 0.25, 16  # mm of a brick, and how many half a turn has
TRAVEL = 0.1  # mm
Node = tuple[int, int, int]  # twice the numbers of a brick's corner, along r, z and round
CORNERS = ((0, 0, 0), (2, 0, 0), (2, 0, 2), (0, 0, 2))
MIDDLES = ((1, 0, 0), (2, 0, 1), (1, 0, 2), (0, 0, 1))
UPRIGHT = ((0, 1, 0), (2, 1, 0), (2, 1, 2), (0, 1, 2))


def design() -> Design:
    """The skin of both programs: two rings with upright walls and flat crests on a flat disc."""
    ring = {"count": len(RINGS), "pitch": RINGS[1] - RINGS[0], "height": HEIGHT, "crown": 0.0}
    ring |= {"root_width": WIDTH, "tip_width": WIDTH, "tip_fillet": 0.0, "root_fillet": 0.0}
    return Design(
        name="bonded-rings",
        skin={"curvature_radius": 1e8, "thickness": THICKNESS, "width": 2 * RADIUS, "outline": "round"},
        ring=ring,
        material={"young_modulus": YOUNG, "poisson_ratio": POISSON},
        mold={"process": "sla"},
        contact={"force": 1.0},
    )


def own() -> dict[str, NDArray[np.float64]]:
    """Return skincad's stiffness of each ring, N/mm, under a plate that keeps `level`, and one that is `free`
    to follow the skin."""
    history = {
        "time_s": [0.0, 1.0],
        "normal_force_N": [0.0, 1.0],
        "tangential_force_N": [0.0, 0.0],
        "steps": 1,
    }
    effects = {"friction": {"coefficient": 1.0}}
    pad = at_level(Scene(name="bonded", skin=design(), history=history, effects=effects), LEVELS[2]).march.pad
    assert isinstance(pad, CondensedPad)
    points, m = pad.pad, pad.pad.x.size
    level, _ = points.held_level(np.ones(m, dtype=bool))
    force = {"level": level, "free": points.compliance[:m, :m]}
    pulls = {name: np.linalg.solve(compliance, np.ones(m)) for name, compliance in force.items()}
    return {name: np.bincount(points.ridge, pull)[1:] for name, pull in pulls.items()}


def theirs(size: float = SIZE, sectors: int = SECTORS) -> NDArray[np.float64]:
    """Return CalculiX's stiffness of each ring, N/mm. Raises RuntimeError when it fails."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "rings.inp").write_text("\n".join(_deck(size, sectors)) + "\n")
        calculix.run_program(["ccx", "rings"], folder)
        text = (folder / "rings.dat").read_text()
    sums = re.findall(r"total force.*?set RING(\d).*?\n\s*\n\s*(\S+)", text)
    if len(sums) != len(RINGS):
        raise RuntimeError(f"CalculiX gives the forces of {len(sums)} rings")
    return np.array([2 * float(force) / TRAVEL for _, force in sorted(sums)])  # of both halves


def _deck(size: float, sectors: int) -> Iterator[str]:
    """The input file's lines."""
    r, z = _radii(size), _heights(size)
    bricks: dict[str, list[list[Node]]] = {"C3D15": [], "C3D20R": []}
    for j in range(z.size - 1):
        for i in range(r.size - 1):
            middle = (r[i] + r[i + 1]) / 2
            if z[j] < THICKNESS - size / 2 or any(abs(middle - at) < WIDTH / 2 for at in RINGS):
                for k in range(sectors):
                    kind, element = _brick((2 * i, 2 * j, 2 * k))
                    bricks[kind].append(element)
    used = sorted({node for elements in bricks.values() for element in elements for node in element})
    number = {node: n for n, node in enumerate(used, 1)}
    yield "*NODE"
    for node, n in number.items():
        out, up, angle = _between(r, node[0]), _between(z, node[1]), math.pi * node[2] / (2 * sectors)
        yield f"{n},{out * math.cos(angle):.9g},{out * math.sin(angle):.9g},{up:.9g}"
    count = 0
    for kind, elements in bricks.items():
        yield f"*ELEMENT,TYPE={kind},ELSET=SKIN"
        for element in elements:
            count += 1
            words = [str(count), *(str(number[node]) for node in element)]
            yield ",".join(words[:15]) + ","
            yield ",".join(words[15:])
    top, crests = 2 * (z.size - 1), [list[int]() for _ in RINGS]
    for node, n in number.items():
        if node[1] == top:
            crests[int(np.argmin([abs(_between(r, node[0]) - at) for at in RINGS]))].append(n)
    crest = {n for numbers in crests for n in numbers}
    cut = [n for (i, j, k), n in number.items() if j and (i == 0 or k in (0, 2 * sectors)) and n not in crest]
    yield from _set("BACK", (n for node, n in number.items() if node[1] == 0))
    yield from _set("CUT", cut)
    for ring, numbers in enumerate(crests, 1):
        yield from _set(f"RING{ring}", numbers)
    yield from ("*MATERIAL,NAME=SILICONE", "*ELASTIC", f"{YOUNG},{POISSON}")
    yield from ("*SOLID SECTION,ELSET=SKIN,MATERIAL=SILICONE", "*BOUNDARY", "BACK,1,3", "CUT,2,2")
    yield from ("*STEP", "*STATIC", "*BOUNDARY")
    for ring in range(1, len(RINGS) + 1):
        yield from (f"RING{ring},1,1,{TRAVEL}", f"RING{ring},2,3,0.0")
    for ring in range(1, len(RINGS) + 1):
        yield from (f"*NODE PRINT,NSET=RING{ring},TOTALS=ONLY", "RF")
    yield "*END STEP"


def _brick(at: Node) -> tuple[str, list[Node]]:
    """A brick's kind and nodes; on the axis a wedge."""
    i, j, k = at

    def nodes(places: Iterable[Node], up: int = 0) -> list[Node]:
        return [(i + a, j + b + up, 0 if i + a == 0 else k + c) for a, b, c in places]

    if i:
        parts = nodes(CORNERS), nodes(CORNERS, 2), nodes(MIDDLES), nodes(MIDDLES, 2), nodes(UPRIGHT)
        return "C3D20R", [node for part in parts for node in part]
    corners, middles, upright = CORNERS[:3], MIDDLES[:3], UPRIGHT[:3]
    parts = nodes(corners), nodes(corners, 2), nodes(middles), nodes(middles, 2), nodes(upright)
    return "C3D15", [node for part in parts for node in part]


def _radii(size: float) -> NDArray[np.float64]:
    marks = sorted({0.0, RADIUS, *(at + side * WIDTH / 2 for at in RINGS for side in (-1, 1))})
    parts = [np.linspace(a, b, max(1, round((b - a) / size)) + 1)[1:] for a, b in pairwise(marks)]
    return np.concatenate([[0.0], *parts])


def _heights(size: float) -> NDArray[np.float64]:
    base = np.linspace(0.0, THICKNESS, round(THICKNESS / size) + 1)
    return np.append(base, THICKNESS + np.linspace(0.0, HEIGHT, round(HEIGHT / size) + 1)[1:])


def _between(values: NDArray[np.float64], twice: int) -> float:
    return float(values[twice // 2] + values[(twice + 1) // 2]) / 2


def _set(name: str, numbers: Iterable[int]) -> Iterator[str]:
    yield f"*NSET,NSET={name}"
    yield from (f"{number}," for number in numbers)


def main() -> None:
    if calculix.missing():
        sys.exit(calculix.missing())
    for name, stiffness in {"CalculiX": theirs(), **own()}.items():
        print(f"{name:10s} " + "  ".join(f"{value:.3f} N/mm" for value in stiffness))


if __name__ == "__main__":
    main()
