"""Prints: on which plates of a machine the parts lie, and the slicer's settings that estimates assume."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from skincad.fabrication.job import Job
from skincad.fabrication.machine_rules import extent, laid_on_end, on_end
from skincad.fabrication.meshes import BedPart, Spot, plates
from skincad.fabrication.papers import macro
from skincad.fabrication.rules import Finding
from skincad.inputs.process import Process
from skincad.solids.plan import CAVITIES, END_PLATES, Part, PartRole

# mm, assumption: what slicers take off the first layers' sides; source: PrusaSlicer's default for filament
ELEPHANT_FOOT = {"filament": 0.2, "resin": 0.1}


class PrintPlate(NamedTuple):
    """One plate: its number from 1 among all of a mold, its process's name, and where its parts lie."""

    number: int
    process: str
    spots: tuple[Spot, ...]

    @property
    def file(self) -> str:
        """The file that has it."""
        return f"solids/mold-plate-{self.number}.3mf"


def print_plates(job: Job) -> list[PrintPlate]:
    """Return the plates that a mold's printed parts fill, each by one process; none where nothing is printed.

    A part that is larger than its machine's bed has a plate to itself, in the middle of it: the finding
    `build volume` reports it.
    """
    lying: dict[str, list[BedPart]] = {}
    for part in job.closed.made:
        if job.process(part).layer:
            x, y, z = extent(part)
            sides = (x, z, y) if laid_on_end(job, part) else (x, y, z)
            lying.setdefault(job.maker(part), []).append(BedPart(part.name, *sides))
    rows = [(name, spots) for name, parts in lying.items() for spots in plates(parts, job.processes[name])]
    return [PrintPlate(number, name, tuple(spots)) for number, (name, spots) in enumerate(rows, 1)]


def prints(job: Job, findings: Iterable[Finding]) -> list[tuple[str, str, str]]:
    """Return how parts are printed, by process: its name, the slicer's settings, and the plates in words;
    `findings` are the mold's."""
    rows: dict[str, list[str]] = {}
    for plate in print_plates(job):
        names = ", ".join(spot.name for spot in plate.spots)
        rows.setdefault(plate.process, []).append(f"{plate.file}: {names}")
    return [
        (name, print_settings(job.processes[name], supported(name, findings)), "; ".join(on))
        for name, on in rows.items()
    ]


def supported(process: str, findings: Iterable[Finding]) -> bool:
    """Whether parts by a process need supports."""
    return any(f.rule == "overhang" and f.where.endswith(f"by {process}") for f in findings)


def printed(job: Job) -> list[str]:
    """Return which parts of the mold are printed, by what they are called."""
    makers = {"cavity": job.cavity_process, **({"end plates": job.end_process} if job.ends else {})}
    makers |= {"cover": job.lid_process, **({"plugs": job.lid_process} if job.closed.plugs else {})}
    return [name for name, process in makers.items() if process.layer]


def print_settings(process: Process, supports: bool) -> str:
    """Return the slicer's settings that price, mass and stiffness assume."""
    facts = {"process": process, "supported": supports, "ELEPHANT_FOOT": ELEPHANT_FOOT}
    return macro("papers/print-settings.md", "settings", **facts)


def lapped(job: Job) -> list[str]:
    """Return the printed joint faces, which are made flat by hand."""
    faces = {
        f"{'both ends and ' if job.ends else ''}the top of the cavity": CAVITIES,
        "the end plates' inner faces": END_PLATES,
        "the carrier's lower face": {PartRole.CARRIER},
    }
    printed = {part.role for part in job.closed.made if job.process(part).layer}
    return [face for face, roles in faces.items() if roles & printed]


def face_down(job: Job, part: Part) -> str:
    """Return which face of a part lies on the plate."""
    if part.role is PartRole.PLUG:
        return "upper face"
    if not on_end(part, job.process(part)):
        return "lower face"
    if part.role in END_PLATES:
        return "outer face" if part.end == "a" else "inner face"
    return "face at end a"
