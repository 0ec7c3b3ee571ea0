"""A job: what follows from a design for its mold, each resolved once, when it is first asked for.

Rules, patterns, drawings and the sheet receive it. It plans; what is made by it is a `Build` (making.py).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.inputs.process import Process, processes
from skincad.inputs.silicone import Silicone
from skincad.shape.skin import Section, Skin, section, skin_of
from skincad.solids.bone import Bone, bone_of
from skincad.solids.cavity import parts_at_tips, split_ridges
from skincad.solids.ends import gate
from skincad.solids.inserts import lead_length
from skincad.solids.kind import kind_of
from skincad.solids.layout import Fits, Layout, end_angle, fits, is_clamped, layout
from skincad.solids.lids import bone_screws
from skincad.solids.mold import ClosedMold, mold
from skincad.solids.pins import magnet_of
from skincad.solids.plan import CAVITIES, END_PLATES, Bore, CutRole, Part, PartRole, bores
from skincad.solids.shrinkage import scaled_for_shrinkage, shrinkage
from skincad.solids.skin import skin_part


@dataclass(frozen=True, eq=False)
class Job:
    """A design with its skin, its mold, and by what and how each part is made; `planned` saves the planning
    of the mold."""

    design: Design
    planned: ClosedMold | None = field(default=None, repr=False)

    @cached_property
    def skin(self) -> Skin:
        """The skin as designed, which is the cured part."""
        return skin_of(self.design)

    @cached_property
    def section(self) -> Section:
        """The section of the skin as designed."""
        return section(self.design)

    @cached_property
    def skin_part(self) -> Part:
        """The skin as designed, as a solid's plan."""
        return skin_part(self.design)

    @property
    def bent(self) -> bool:
        """Whether the skin is curved along y too."""
        return kind_of(self.design).leans

    @property
    def rise(self) -> float:
        """By how much the ends of a doubly curved mold lean, deg."""
        return math.degrees(end_angle(self.design))

    @property
    def tips(self) -> bool:
        """Whether a base of cups closes pins' through holes."""
        return parts_at_tips(self.cast)

    @property
    def holes(self) -> bool:
        """Whether pins are cast: the cavity has holes."""
        return bool(self.skin.standing)

    @property
    def blind(self) -> bool:
        """Whether the cavity has blind holes, pins', which a rising front would leave full of air."""
        return self.holes and not self.tips

    @property
    def split(self) -> bool:
        """Whether the cavity is in pieces."""
        return bool(split_ridges(self.design))

    @property
    def ends(self) -> bool:
        """Whether end plates close the cavity."""
        return bool(self.closed.of(*END_PLATES))

    @property
    def disc(self) -> bool:
        """Whether the cavity is a disc in a block."""
        return bool(self.closed.of(PartRole.BLOCK))

    @property
    def riveted(self) -> bool:
        """Whether the carrier has holes besides its vent, in which silicone holds the skin like rivets."""
        return bool(bores(self.closed.first(PartRole.CARRIER), CutRole.RIVET))

    @property
    def bone(self) -> Bone | None:
        """What the skin is cast on; None where that is its carrier."""
        return bone_of(self.cast)

    @property
    def bone_screws(self) -> list[tuple[Bore, str]]:
        """The cores of the screws that hold a bone under the carrier, and their threads."""
        return bone_screws(self.cast)

    @property
    def bone_out(self) -> float:
        """How far a bone stands out of the cover, mm."""
        return (
            -float(self.bone.corners[:, :, 2].min()) - self.place.top - self.place.lid if self.bone else 0.0
        )

    @property
    def magnet(self) -> tuple[float, float] | None:
        """Diameter and length of the magnet that a pocket holds by its squeeze, mm; None where none fits."""
        return magnet_of(self.design)

    @cached_property
    def shrinkage(self) -> float:
        """The linear shrinkage that the mold makes up for."""
        return shrinkage(self.design)

    @cached_property
    def cast(self) -> Design:
        """What is poured, so that it cures to the design: scaled for shrinkage."""
        return scaled_for_shrinkage(self.design)

    @property
    def poured_part(self) -> Part:
        """The skin as poured; the first one's of a gang."""
        return self.closed.first(PartRole.SKIN)

    @cached_property
    def cast_skin(self) -> Skin:
        """The skin as poured."""
        return skin_of(self.cast)

    @cached_property
    def cast_section(self) -> Section:
        """The section of the skin as poured."""
        return section(self.cast)

    @cached_property
    def place(self) -> Layout:
        """Where the mold's screws, pins and seats lie."""
        return layout(self.cast, self.cast_section)[0]

    @cached_property
    def gate(self) -> float | None:
        """Diameter of the gate, mm; None where silicone is poured into the open trough."""
        return gate(self.design)

    @property
    def inserts(self) -> str:
        """What stands in the slots while silicone is poured: shims, strips, or "" without slots."""
        if self.skin.slot is None:
            return ""
        return "shims" if self.design.mold.method == "shim" else "strips"

    @cached_property
    def lead(self) -> float:
        """How long the straight leads of the strips are, mm; 0 without film."""
        return lead_length(self.cast if self.design.mold.method == "cast-in" else self.design)

    @cached_property
    def clamped(self) -> bool:
        """Whether clamps hold the cover, not bolts."""
        return is_clamped(self.cast)

    @cached_property
    def closed(self) -> ClosedMold:
        """The mold; raises InputError where there is none."""
        return self.planned or mold(self.design)

    @cached_property
    def single(self) -> Job:
        """The job of one skin of a gang: all of them fill alike."""
        return self if self.design.mold.cavities == 1 else Job(self.design.with_(mold={"cavities": 1}))

    @cached_property
    def silicone(self) -> Silicone:
        """What is cast."""
        return silicone(self.design)

    @cached_property
    def processes(self) -> dict[str, Process]:
        """All processes that are known, the workshop's own too, by name."""
        return processes(self.design.printer)

    @property
    def cavity_process(self) -> Process:
        """The process of the cavity."""
        return self.processes[self.design.mold.process]

    @property
    def block_process(self) -> Process:
        """The process of what the cover is screwed to: the cavity, or the block that it lies in."""
        return self.processes[self.design.mold.block_process or self.design.mold.process]

    @property
    def end_process(self) -> Process:
        """The process of the end plates."""
        return self.processes[self.design.mold.end_plate_process or self.design.mold.process]

    @property
    def lid_process(self) -> Process:
        """The process of carrier and cover."""
        return self.processes[self.design.mold.lid_process or self.design.mold.process]

    def maker(self, part: Part) -> str:
        """Return the name of the process that makes a part."""
        choice = self.design.mold
        if part.role in CAVITIES:
            return choice.process
        if part.role is PartRole.BLOCK:
            return choice.block_process or choice.process
        if part.role in END_PLATES:
            return choice.end_plate_process or choice.process
        return choice.lid_process or choice.process

    def process(self, part: Part) -> Process:
        """Return the process that makes a part."""
        return self.processes[self.maker(part)]

    def fits(self, part: Part) -> Fits:
        """Return the holes of a part."""
        return fits(self.design, self.maker(part))
