"""The CAD kernel re-reads STEP: names, colours, and the casting sheet's numbers from the assembly's
solids, by booleans."""

from __future__ import annotations

import re
from functools import lru_cache
from pathlib import Path

import cadquery as cq

from bench.campaign.soundness import Box, Kit, poured_by_solids
from skincad.solids.mold import mold
from tests.consumers import Job

SHARE = 1e-3  # asked: the sheet agrees with the solids to 0.1 %
COLOUR = 1e-6  # STEP's digits


def missing() -> str:
    """Return why it can't run here, or ""."""
    return ""  # skincad builds with it


@lru_cache(maxsize=8)
def read(path: Path) -> tuple[dict[str, cq.Solid], dict[str, tuple[float, ...]]]:
    """Return an assembly's solids and colours by name."""
    whole = cq.Assembly.importStep(str(path))
    solids = {child.name: child.obj.moved(child.loc) for child in whole.children}
    return solids, {child.name: child.color.toTuple()[:3] for child in whole.children}


def poured(path: Path) -> float:
    """Return the volume that silicone fills by the solids of an assembly, mm3."""
    kit = Kit(_bounds, _block, lambda shape: list(shape.Solids()), lambda shape: float(shape.Volume()))
    return poured_by_solids(read(path)[0], kit)


def _bounds(shape: cq.Shape) -> Box:
    box = shape.BoundingBox(1e-6)
    return (box.xmin, box.ymin, box.zmin), (box.xmax, box.ymax, box.zmax)


def _block(box: Box) -> cq.Solid:
    (x, y, z), high = box
    return cq.Solid.makeBox(high[0] - x, high[1] - y, high[2] - z, cq.Vector(x, y, z))


def sheet_numbers(text: str) -> dict[str, str]:
    """Return the numbers that a casting sheet says, as written: cm3 by part, `poured` cm3, `grams`."""
    volumes = dict(re.findall(r"^\| ([\w-]+) \|.*\| ([\d.]+) \|$", text, re.M))
    cm3, grams = re.findall(r"the mold takes ([\d.]+) cm³, ([\d.]+) g", text)[0]
    return {**volumes, "poured": cm3, "grams": grams}


def from_solids(job: Job) -> dict[str, float]:
    """Return the same numbers from the assembly's solids."""
    path = job.file("solids/assembly.step")
    volumes = {name: solid.Volume() / 1000 for name, solid in read(path)[0].items()}
    volume = poured(path) / 1000
    return {**volumes, "poured": volume, "grams": volume * job.plan.silicone.density * 1e-3}


def complaints(job: Job) -> list[str]:
    """Return names and colours that the assembly lost, and the sheet's numbers that its solids don't have."""
    solids, colours = read(job.file("solids/assembly.step"))
    if list(solids) != job.names:
        return [f"assembly.step: {', '.join(solids)}"]
    wrong = [
        f"assembly.step: {part.name} is coloured {colours[part.name]}"
        for part in mold(job.design).parts
        if any(abs(a - b) > COLOUR for a, b in zip(colours[part.name], part.colour, strict=True))
    ]
    true = from_solids(job)
    for name, written in sheet_numbers(job.file("casting-sheet.md").read_text("utf-8")).items():
        if abs(float(written) - true[name]) > SHARE * true[name] + _half_digit(written):
            wrong.append(f"casting-sheet.md: {name} {written}, its solids {true[name]:.5g}")
    return wrong


def _half_digit(written: str) -> float:
    return 0.5 * float(10 ** -len(written.partition(".")[2]))
