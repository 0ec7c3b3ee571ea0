"""What is wrong with a random design: `python -m bench.campaign.soundness [first [last]]`, by seeds.

`faults` builds it all: exact solids against formulas, print meshes, interference closed and while opening,
findings, casting sheet. The contact check is left out: it sees no part, and costs most.
"""

from __future__ import annotations

import re
import sys
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from manifold3d import Manifold

from bench.campaign.poured_by_solids import Kit, poured_by_solids
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
        shape = solid(
            part
        )  # KernelError unless BRepCheck finds it valid, and its volume the formula's to 1e-9
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


def main() -> None:
    first, last = (int(n) for n in (*sys.argv[1:], *("0", "500")[len(sys.argv) - 1 :]))
    print(summary([outcome(seed) for seed in range(first, last)]))


if __name__ == "__main__":
    main()
