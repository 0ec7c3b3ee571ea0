"""What is wrong with a random design, by seeds.

`faults` builds it all: exact solids against formulas, print meshes, interference closed and while opening,
findings, casting sheet. The contact check is left out: it sees no part, and costs most. `poured_by_solids`
returns what silicone fills, from the parts as solids alone: the spaces that they leave, by booleans.
"""

from __future__ import annotations

import re
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from manifold3d import Manifold

from bench.campaign.random_designs import drawn
from skincad.fabrication import (
    Job,
    casting_sheet,
    design_findings,
    filling_findings,
    interference,
    manifold,
    mesh,
    poured_volume,
)
from skincad.inputs import Design
from skincad.inputs.material import silicone
from skincad.solids import ClosedMold
from skincad.solids.mold import mold

CHORD = 2e-3  # mm, asked of the print meshes
# a design may well have these errors: it is told, and nothing is wrong with its parts
OF_DESIGN = {"undercut", "build volume", "lead width", "strip lap", "slit fit", "notch"}
BESIDE = 1.0  # mm of the walls beside the carrier: beyond its gap (0.3 at most), short of the bolts (1.2)
NEAR = 1e-3  # mm: a space that starts this close to a plane starts on it
Box = tuple[tuple[float, float, float], tuple[float, float, float]]


@dataclass(frozen=True)
class Outcome:
    """What became of a seed: its design as TOML, refusals before it, and what is wrong with it."""

    seed: int
    toml: str
    refused: tuple[str, ...]
    faults: tuple[str, ...]
    seconds: float


def outcome(seed: int, *, kernel: bool = True) -> Outcome:
    """Return what is wrong with a seed's design; an exception is told as a fault, never lost."""
    started = time.perf_counter()
    answer = drawn(seed)
    wrong: list[str] = []
    try:
        wrong += faults(answer.design, kernel=kernel)
    except Exception as failure:  # whatever it is, it is what this looks for
        wrong.append(f"{type(failure).__name__}: {failure}")
    text = answer.design.to_toml()
    return Outcome(seed, text, answer.refused, tuple(wrong), time.perf_counter() - started)


def faults(design: Design, *, kernel: bool = True) -> Iterator[str]:
    """Yield what is wrong: an invalid or open part, two volumes that differ, interference, a wrong mass."""
    closed = mold(design)
    yield from _solid_faults(closed) if kernel else ()
    yield from _mesh_faults(closed)
    gap = min(design.mold.clearance, design.mold.slit_clearance) or CHORD
    fine = max(1e-4, min(CHORD, gap / 10))  # as `make` takes it
    yield from map(str, interference(closed, fine))
    findings = [*design_findings(Job(design, closed)), *filling_findings(Job(design, closed))]
    yield from (str(f) for f in findings if f.severity == "error" and f.rule not in OF_DESIGN)
    yield from _sheet_faults(design, closed, casting_sheet(Job(design, closed), findings, "Passes.", True))


def _solid_faults(closed: ClosedMold) -> Iterator[str]:
    from skincad.solids import solid

    for part in closed.parts:
        # KernelError unless BRepCheck finds it valid, and its volume the formula's to 1e-9
        shape = solid(part)
        if len(shape.Faces()) < 3:
            yield f"{part.name}: {len(shape.Faces())} faces"


def _mesh_faults(closed: ClosedMold) -> Iterator[str]:
    for part in closed.parts:
        shape = mesh(part, CHORD)
        if not (shape.is_watertight and shape.is_winding_consistent):
            yield f"{part.name}: its mesh is open"
        # chords keep within CHORD of the surface, so the volume between is at most that times the area
        error, most = abs(shape.volume - part.volume), CHORD * shape.area
        if not error <= most:
            yield f"{part.name}: mesh {shape.volume:.6g} mm3, formula {part.volume:.6g}, {most:.2g} allowed"


def _sheet_faults(design: Design, closed: ClosedMold, sheet: str) -> Iterator[str]:
    (found,) = re.findall(r"the mold takes ([\d.]+) cm³, ([\d.]+) g", sheet)
    volume, grams = 1000 * float(found[0]), float(found[1])
    formula = poured_volume(Job(design, closed))
    if abs(volume / formula - 1) > 1e-3:  # the sheet has four digits
        yield f"casting sheet: {volume} mm3, poured are {formula:.2f}"
    if abs(grams / (formula * silicone(design).density * 1e-6) - 1) > 1e-3:
        yield f"casting sheet: {grams} g of {formula:.2f} mm3"
    if design.skin.curvature_radius_y is not None:  # tests/fabrication/test_doubly_curved.py holds these
        return
    solids = {part.name: manifold(part, 1e-3) for part in closed.parts}
    spaces = poured_by_solids(solids, Kit(_bounds, _block, Manifold.decompose, Manifold.volume))
    # bores are polygons within 1e-3 mm: the skin's and carrier's surface, once
    most = 1e-3 * sum(
        s.surface_area() for n, s in solids.items() if n.startswith(("skin", "carrier", "cover"))
    )
    if abs(spaces - formula) > most:
        yield f"poured: {formula:.3f} mm3 by formula, {spaces:.3f} by booleans, {most:.2g} allowed"


@dataclass(frozen=True)
class Kit:
    """A library of solids whose `-` cuts: bounds of one, a block, and the separate pieces of one."""

    bounds: Callable[[Any], Box]
    block: Callable[[Box], Any]
    pieces: Callable[[Any], list[Any]]
    volume: Callable[[Any], float]


def poured_by_solids(solids: Mapping[str, Any], kit: Kit) -> float:
    """Return the volume of skins, carriers' holes and vents, gaps round the carriers, bores of the cover over
    them, and gates. `solids` are all parts of a closed mold by name."""
    skins = [name for name in solids if name.startswith("skin")]
    return sum(_over_one(solids, name.removeprefix("skin"), kit) for name in skins)


def _over_one(solids: Mapping[str, Any], number: str, kit: Kit) -> float:
    skin, carrier = solids[f"skin{number}"], solids[f"carrier{number}"]
    around, cover = kit.bounds(carrier), kit.bounds(solids["cover"])
    left, right, back = around[0][0] - BESIDE, around[1][0] + BESIDE, around[0][2]
    cavities = [solid for name, solid in solids.items() if name.startswith("cavity")]
    end = kit.bounds(cavities[0])[1][1]
    seat = kit.block(((left, -end, back), (right, end, around[1][2]))) - carrier
    for cavity in cavities:
        seat = seat - cavity
    over = kit.block(((left, cover[0][1], cover[0][2]), (right, cover[1][1], cover[1][2]))) - solids["cover"]
    through = []
    if seal := solids.get("seal"):  # beside it are walls, a gap away
        low, high = kit.bounds(seal)
        sheet = (around[0][0], low[1], low[2]), (around[1][0], high[1], high[2])
        through = _from(low[2], kit.block(sheet) - seal, kit)
    spaces = [
        *through,
        *_from(back, seat, kit),  # not what is drilled from above only
        *_from(cover[0][2], over, kit),
        *_gates(solids.get("end-a-keeper") or solids["end-a"], kit.bounds(skin), kit),
    ]
    return kit.volume(skin) + sum(kit.volume(space) for space in spaces)


def _from(level: float, space: Any, kit: Kit) -> list[Any]:
    return [piece for piece in kit.pieces(space) if kit.bounds(piece)[0][2] < level + NEAR]


def _gates(plate: Any, skin: Box, kit: Kit) -> list[Any]:
    """Holes of an end plate that end on the skin; what lies below the plate's curved edge is none."""
    around = kit.bounds(plate)
    rows = []
    for piece in kit.pieces(kit.block(around) - plate):
        low, high = kit.bounds(piece)
        inside = skin[0][0] < low[0] and high[0] < skin[1][0] and skin[0][2] < low[2] and high[2] < skin[1][2]
        if inside and low[2] > around[0][2] + NEAR:
            rows.append(piece)
    return rows


def _bounds(solid: Manifold) -> Any:
    box = solid.bounding_box()
    return box[:3], box[3:]


def _block(box: Any) -> Manifold:
    return Manifold.cube(tuple(np.subtract(box[1], box[0]))).translate(box[0])


def summary(outcomes: list[Outcome]) -> str:
    """Return counts, refusals by key, and each failure with the TOML that reproduces it."""
    refused = Counter(key for o in outcomes for key in o.refused)
    bad = [o for o in outcomes if o.faults]
    seconds = sum(o.seconds for o in outcomes)
    lines = [
        f"{len(outcomes)} random designs, {len(bad)} with faults, {seconds:.0f} s of work; "
        f"{refused.total()} draws refused: " + ", ".join(f"{key} {n}" for key, n in refused.most_common())
    ]
    for each in bad:
        lines += [f"seed {each.seed}: {fault}" for fault in each.faults] + [each.toml]
    return "\n".join(lines)
