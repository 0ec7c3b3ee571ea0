"""skincad against GetFEM, in three dimensions: rings and a round face that a level plate presses and pulls.

`python -m bench.ring_friction [name ...] [--sectors 6 8 10]` prints both programs' tables. Both get the
design, the plate's force and its travel. skincad takes the pull as one harmonic round the axis and one force
along x all round a ring. GetFEM solves half of the skin (`ring_friction_process.py`), turned from a section
of quads, in small strain too; every harmonic, both directions of slip and an uneven pressure are in it. It
presses twice: without friction until the pull begins, as skincad does, and with friction from the start.
GetFEM is a process of its own (Debian's package `python3-getfem`, LGPL), on files in a temporary folder.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise, product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bench import calculix, getfem, runner
from skincad import Design, Scene, load
from skincad.effects import CondensedPad
from skincad.scenes import LEVELS, Simulation, at_level

PROCESS = Path(__file__).with_name("ring_friction_process.py")
YOUNG, POISSON, FRICTION = 0.5, 0.49, 0.5  # MPa; bricks of less nearly incompressible silicone converge
PULLS, PRESSES = 16, 4  # steps
BEGUN, HALF, WHOLE = 0.05, 0.5, 0.995  # of a ring's contact that slips; of what friction bears on it
SHOWN = (0.1, 0.3, 0.5, 0.7, 0.9)
HALVES = (0.0, 0.5, 1.0)
# The process' numbers: degrees that quadratures take exactly, of the whole strain, of its volume and of the
# contact; MPa/mm; N/mm and mm, by which the first contact is held; relative
NUMBERS = {
    "full": 6,
    "reduced": 3,
    "quadrature": 6,
    "augmentation": 1.0,
    "hold": 1e3,
    "start": 0.02,
    "residual": 1e-8,
    "iterations": 60,
}

Values = NDArray[np.float64]
Place = Callable[[float, float], tuple[float, float]]  # of an arc and a height, both as shares


class Pull(NamedTuple):
    """A `design`, the normal `force` N, and the `travel` mm that ends in gross slip."""

    design: Design
    force: float
    travel: float


class Bricks(NamedTuple):
    """How many bricks lie `across` a crest, in a ring's height, in the base's depth, and round half a turn;
    and how long they are between rings, mm."""

    across: int
    tall: int
    deep: int
    sectors: int
    gap: float


MESHES = {6: Bricks(3, 2, 2, 6, 1.2), 8: Bricks(4, 2, 3, 8, 1.0), 10: Bricks(6, 2, 3, 10, 0.8)}


def rings(heights: Sequence[float], curvature: float = 1e8) -> Design:
    """`rings-5` with so many rings, heights in mm, without fillets."""
    ring = {"count": len(heights), "heights": heights, "height": None, "tip_fillet": 0.0, "root_fillet": 0.0}
    return load("rings-5").with_(
        skin={"width": 4.0 * len(heights), "thickness": 3.0, "curvature_radius": curvature},
        ring=ring,
        material={"name": None, "young_modulus": YOUNG, "poisson_ratio": POISSON},
    )


def face() -> Design:
    """A round face that touches on two thirds of its width."""
    return Design(
        name="round-face",
        skin={"curvature_radius": 60.0, "thickness": 3.0, "width": 10.0, "outline": "round"},
        flat={},
        material={"young_modulus": YOUNG, "poisson_ratio": POISSON},
        mold={"process": "sla"},
        contact={"force": 1.0},
    )


def pulls() -> dict[str, Pull]:
    """What is compared."""
    return {
        "two": Pull(rings((1.0, 1.0)), 2.0, 0.8),
        "three": Pull(rings((1.0, 1.0, 1.0), 150.0), 3.0, 0.6),
        "unlike": Pull(rings((1.0, 0.9)), 2.0, 0.9),
        "face": Pull(face(), 1.0, 0.22),
    }


@dataclass(frozen=True)
class PulledSkin:
    """States from the press on, one a row: `normal` and `tangential` N of each ring, what of it `touches` and
    `slips`, mm2, all `(steps, rings)`; `uneven` is by how much of its mean the pressure round a ring goes
    with the cosine, positive where it is harder ahead; `approach` mm `(steps,)`."""

    normal: Values
    tangential: Values
    touches: Values
    slips: Values
    uneven: Values
    approach: Values

    @property
    def pull(self) -> Values:
        """The pull, of what friction bears `(steps,)`."""
        return np.asarray(self.tangential.sum(axis=1) / (FRICTION * self.normal.sum(axis=1)))

    @property
    def share(self) -> Values:
        """What of each ring's contact slips `(steps, rings)`."""
        return self.slips / self.touches

    @property
    def slip_share(self) -> Values:
        """What of all contact slips `(steps,)`."""
        return np.asarray(self.slips.sum(axis=1) / self.touches.sum(axis=1))

    @property
    def used(self) -> Values:
        """What each ring bears of what friction bears on it `(steps, rings)`."""
        return self.tangential / (FRICTION * self.normal)

    def pull_at(self, values: Values, least: float) -> list[float]:
        """Return the pull from which on each ring's values `(steps, rings)` are at least that, straight
        between steps; nan where they never are."""
        ends = []
        for column in values.T:
            below = np.flatnonzero(column[1:] < least)  # a press may slip
            i = int(below[-1]) + 1 if below.size else 0
            over = i + 1 == column.size
            ends.append(
                math.nan if over else float(np.interp(least, column[i : i + 2], self.pull[i : i + 2]))
            )
        return ends


def apart(one: PulledSkin, other: PulledSkin) -> float:
    """Return by how much the slip shares differ at equal pulls from 0.05 to 0.95, the mean."""
    at = np.linspace(0.05, 0.95, 19)
    first, second = (np.interp(at, skin.pull[1:], skin.slip_share[1:]) for skin in (one, other))
    return float(np.abs(first - second).mean())


def scene(pull: Pull) -> Scene:
    """The press in one step, and the travel in PULLS."""
    history = {
        "steps": 1 + PULLS,
        "time_s": [0.0, 1.0, 1.0 + PULLS],
        "normal_force_N": [0.0, pull.force, pull.force],
        "tangential_force_N": None,
        "displacement_mm": [0.0, 0.0, pull.travel],
    }
    effects = {"friction": {"coefficient": FRICTION}}
    return Scene(name="pulled", skin=pull.design, history=history, effects=effects)


def own(pull: Pull, level: int = 2) -> PulledSkin:
    """Return skincad's states."""
    return read(at_level(scene(pull), LEVELS[level]))


def read(result: Simulation) -> PulledSkin:
    """Return a march's states from its first step on."""
    march = result.march
    assert isinstance(march.pad, CondensedPad)
    pad = march.pad.pad
    member = np.equal.outer(pad.ridge, np.unique(pad.ridge)).astype(float)
    normal, tangential, _ = np.moveaxis(march.loads[1:], 1, 0)
    up = [
        pad.held_level(reading.touches)[1] @ march.states[i].tangential @ member
        if i in march.states
        else np.full(normal.shape[1], math.nan)
        for i, reading in enumerate(march.readings)
    ]
    return PulledSkin(
        normal=normal,
        tangential=tangential,
        touches=(march.column("touches") * march.area)[1:] @ member,
        slips=(march.column("slips") * march.area)[1:] @ member,
        uneven=-2 * np.array(up)[1:] / normal,
        approach=march.column("approach")[1:],
    )


def theirs(pull: Pull, bricks: Bricks, *, pressed_smooth: bool = True) -> PulledSkin:
    """Return GetFEM's states. Raises RuntimeError when it fails."""
    rubbed = [(pull.travel * (i + 1) / PULLS, FRICTION) for i in range(PULLS)]
    steps = [(pull.force, *step) for step in rubbed]
    if pressed_smooth:
        steps = [(pull.force, 0.0, 0.0), *steps]
    else:
        steps = [(pull.force * (i + 1) / PRESSES, 0.0, FRICTION) for i in range(PRESSES)] + steps
    parts, crests = mesh(pull.design, bricks)
    asked = {
        **NUMBERS,
        **crests,
        "shear": YOUNG / (2 * (1 + POISSON)),
        "bulk": YOUNG / (3 * (1 - 2 * POISSON)),
        "steps": [(force / 2, travel, coefficient) for force, travel, coefficient in steps],
    }
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        np.savez(folder / "mesh.npz", **parts)
        (folder / "asked.json").write_text(json.dumps(asked))
        calculix.run_program([getfem.PYTHON, "-I", str(PROCESS)], folder)
        rows = json.loads((folder / "found.json").read_text())[-1 - PULLS :]
    table = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    halves = {name: 2 * table[name] for name in ("normal", "tangential", "touches", "slips")}
    return PulledSkin(**halves, uneven=4 * table["ahead"] / halves["normal"], approach=table["approach"])


def mesh(design: Design, bricks: Bricks) -> tuple[dict[str, Values], dict[str, Any]]:
    """Return half of a skin: GetFEM's nodes of bricks `QK` `(3, 27, n)` and wedges `PRISM` `(3, 18, n)`, mm;
    and where its crests are, by radius and height."""
    found: dict[str, list[list[tuple[float, ...]]]] = {"QK": [], "PRISM": []}
    angles = np.linspace(0.0, math.pi, 2 * bricks.sectors + 1)
    for nodes in _quads(design, bricks):  # (3, 3, 2): up, outward, and radius and height
        for k in range(0, 2 * bricks.sectors, 2):
            if nodes[0, 0, 0]:
                order = [(up, turn, out) for up, turn, out in product(range(3), repeat=3)]
            else:  # a triangle by its corners on the axis and beyond
                order = [
                    (up, turn, out)
                    for up in range(3)
                    for turn, out in ((0, 0), (0, 1), (0, 2), (2, 1), (1, 2), (2, 2))
                ]
            places = [(*nodes[up, out], angles[k + turn]) for up, turn, out in order]
            kind = "QK" if nodes[0, 0, 0] else "PRISM"
            found[kind].append([(r * math.cos(t), r * math.sin(t), z) for r, z, t in places])
    parts = {kind: np.moveaxis(np.array(rows or np.empty((0, 1, 3))), 0, 2) for kind, rows in found.items()}
    parts = {kind: np.swapaxes(nodes, 0, 1) for kind, nodes in parts.items()}
    top = max(float(nodes[2].max()) for nodes in parts.values() if nodes.size)
    ring, radii = design.ring, [0.0]
    foot = 0.0
    if ring is not None:
        assert ring.heights is not None
        radii = [ring.first_radius + i * ring.spacing for i in range(ring.count)]
        foot = top - 0.6 * min(ring.heights)
    return parts, {"rings": radii, "base": foot, "top": top}


def _quads(design: Design, bricks: Bricks) -> Iterator[Values]:
    """The section's quads by nine nodes `(3, 3, 2)`."""
    ring, skin = design.ring, design.skin
    bend, thick = skin.curvature_radius, skin.thickness

    def placed(arc: float, height: float) -> tuple[float, float]:
        fallen = 2 * bend * math.sin(arc / (2 * bend)) ** 2
        return (bend + height) * math.sin(arc / bend), thick - fallen + height * math.cos(arc / bend)

    def base(arc: float, share: float) -> tuple[float, float]:
        radius, height = placed(arc, 0.0)
        return radius, share * height

    def patch(place: Place, arcs: Sequence[float], levels: int) -> Iterator[Values]:
        for (a, b), j in product(pairwise(arcs), range(levels)):
            yield np.array([[place(a + (b - a) * s, (j + t) / levels) for s in HALVES] for t in HALVES])

    def between(a: float, b: float) -> list[float]:
        return np.linspace(a, b, max(1, round((b - a) / bricks.gap)) + 1).tolist()

    end = 0.0
    for i, height in enumerate(ring.heights or () if ring else ()):
        assert ring is not None
        middle, root, tip = ring.first_radius + i * ring.spacing, ring.root_width / 2, ring.tip_width / 2
        crown = (tip**2 + ring.crown**2) / (2 * ring.crown)

        def crest(
            arc: float, share: float, at: tuple[float, ...] = (middle, height, root, tip, crown)
        ) -> Any:
            middle, height, root, tip, crown = at
            out = (arc - middle) / root
            summit = height - crown + math.sqrt(crown**2 - (out * tip) ** 2)
            return placed(middle + out * (root + (tip - root) * share), share * summit)

        if middle - root > end + 1e-9:
            yield from patch(base, between(end, middle - root), bricks.deep)
        arcs = np.linspace(middle - root, middle + root, bricks.across + 1).tolist()
        yield from patch(base, arcs, bricks.deep)
        yield from patch(crest, arcs, bricks.tall)
        end = middle + root
    yield from patch(base, between(end, skin.width / 2), bricks.deep)


def compared(name: str, pull: Pull, sectors: Sequence[int]) -> None:
    """Print the tables of one pull, by meshes of so many sectors; of three and more the line through their
    shares, to bricks without width."""
    skins = {f"skincad {level}": own(pull, level) for level in (1, 2)}
    bricks = {n: MESHES[n]._replace(gap=3.0 / n) if name == "face" else MESHES[n] for n in sectors}
    wide = [size.gap if name == "face" else 1 / size.across for size in bricks.values()]
    presses = {"": True, ", pressed with friction": False}
    for words, smooth in presses.items():
        skins |= {f"GetFEM {n}{words}": theirs(pull, bricks[n], pressed_smooth=smooth) for n in sectors}
    print(f"\n{name}: {pull.force:g} N, friction {FRICTION:g}; pulls are of what friction bears")
    best, rows = skins["skincad 2"], []
    for who, skin in skins.items():
        cells = [skin.normal[0], skin.tangential[1], skin.pull_at(skin.share, BEGUN)]
        cells += [skin.pull_at(skin.share, HALF), skin.pull_at(skin.used, WHOLE), skin.uneven[-1]]
        words = [" ".join(f"{value:.3f}" for value in values) for values in cells]
        rows.append((who, f"{skin.approach[0]:.4f}", *words, f"{apart(skin, best):.3f}"))
    head = (
        "",
        "approach, mm",
        "pressed, N",
        "pulled a step, N",
        "begins",
        "half",
        "whole",
        "uneven",
        "apart",
    )
    print("\n".join(runner.table(head, rows)))
    shares = {who: np.interp(SHOWN, skin.pull[1:], skin.slip_share[1:]) for who, skin in skins.items()}
    for words in presses if len(sectors) > 2 else ():
        lines = np.polyfit(wide, [shares[f"GetFEM {n}{words}"] for n in sectors], 1)
        shares[f"GetFEM, line{words}"] = lines[1]
    print("slip_share at pulls of " + " ".join(f"{at:g}" for at in SHOWN))
    for who, values in shares.items():
        print(f"  {who:36s}" + " ".join(f"{share:.3f}" for share in values))


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("names", nargs="*", metavar="name", help=f"of {', '.join(pulls())}; all if not given")
    parser.add_argument(
        "--sectors", nargs="+", type=int, choices=MESHES, default=list(MESHES), help="of meshes"
    )
    asked = parser.parse_args()
    if unknown := {*asked.names} - {*pulls()}:
        parser.error(f"unknown: {', '.join(sorted(unknown))}")
    if getfem.missing():
        sys.exit(getfem.missing())
    for name in asked.names or pulls():
        compared(name, pulls()[name], asked.sectors)


if __name__ == "__main__":
    main()
