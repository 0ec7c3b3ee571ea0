"""Everything that silicone can reach in the closed mold: disjoint prisms and bores that touch on plane faces.

In a doubly curved mold the skin and what touches its back are curved; volumes hold there as well.

The seats (carrier on ledge, cover on carrier) and the shims' slits in the end plates count as tight.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from skincad.base.arrays import Array
from skincad.inputs.design import Design
from skincad.shape import curves
from skincad.solids.bent import gap_beside
from skincad.solids.mold import ClosedMold, mold
from skincad.solids.plan import END_PLATES, Body, Bore, CutRole, PartRole, Prism, bores
from skincad.solids.shrinkage import scaled_for_shrinkage


@dataclass(frozen=True)
class Space:
    """A part of the void, in or beside a part of the mold. Air leaves it through its faces on the plane
    z = `open_at` mm."""

    name: str
    body: Body
    beside: PartRole
    open_at: float | None = None
    number: int | None = None  # among spaces of its name

    @property
    def where(self) -> str:
        """The name of the place, as a finding says it."""
        return self.name if self.number is None else f"{self.name} {self.number}"


@dataclass(frozen=True)
class Void:
    """Spaces that touch, and the rim over which silicone runs off, `(n, 3)` mm: it rises no higher."""

    spaces: tuple[Space, ...]
    rim: Array | None = None

    @property
    def volume(self) -> float:
        """Volume by formula, mm3."""
        return math.fsum(space.body.volume for space in self.spaces)


def single_skin_mold(design: Design, closed: ClosedMold) -> ClosedMold:
    """Return the mold of one skin: all skins of a gang fill alike."""
    return closed if design.mold.cavities == 1 else mold(design.with_(mold={"cavities": 1}))


def void(design: Design, closed: ClosedMold) -> Void:
    """Return what the silicone fills in a mold of one skin: skin, gate, the carrier's holes and vent, the gap
    round the carrier, bleeds and the reservoir in the cover. A gate stays shut by its syringe; bleeds are
    taped when full."""
    design, carrier = scaled_for_shrinkage(design), closed.first(PartRole.CARRIER)
    cover = closed.first(PartRole.COVER)
    top = cover.body.high if isinstance(cover.body, Prism) else math.inf
    over = bores(cover, CutRole.RESERVOIR, CutRole.BLEED)
    rivets = enumerate(bores(carrier, CutRole.RIVET), 1)
    plates = [cut for part in closed.of(*END_PLATES) for cut in part.cuts]
    spaces = [
        Space("skin", closed.first(PartRole.SKIN).body, PartRole.SKIN),
        *(Space("vent", bore, PartRole.CARRIER) for bore in bores(carrier, CutRole.VENT)),
        *(Space("carrier hole", bore, PartRole.CARRIER, number=i) for i, bore in rivets),
        *(Space("gap round the carrier", ring, PartRole.CARRIER) for ring in _gap(design, carrier.body)),
        *(Space("seal", bore, PartRole.COVER) for part in closed.of(PartRole.SEAL) for bore in bores(part)),
        *(Space("cover", bore, PartRole.COVER, top) for bore in over),
        *(Space("gate", cut, PartRole.END_PLATE) for cut in plates if cut.role is CutRole.GATE),
    ]
    return Void(tuple(spaces), _rim(over[0]))


def open_trough(closed: ClosedMold) -> Void:
    """Return the skin's space with its back open, as the silicone is poured into it before the carrier."""
    return Void((Space("skin", closed.first(PartRole.SKIN).body, PartRole.SKIN, open_at=0.0),))


def perforated(closed: ClosedMold) -> bool:
    """Whether the carrier has holes besides its vent, which silicone fills."""
    return bool(bores(closed.first(PartRole.CARRIER), CutRole.RIVET))


def _gap(design: Design, carrier: Body) -> list[Prism]:
    gap = design.mold.clearance
    if gap == 0.0 or not isinstance(carrier, Prism):
        return []
    if carrier.axis == "x":
        return gap_beside(carrier, gap)
    corners = np.array([s.start for s in carrier.outline])
    (x, y), half = corners.max(axis=0), design.skin.length / 2
    outer = curves.rectangle(-float(x) - gap, float(x) + gap, -half, half)
    inner = curves.rectangle(-float(x), float(x), -float(y), float(y))
    return [replace(carrier, outline=outer, holes=(inner,))]


def _rim(cup: Bore) -> Array:
    (x, y, z), radius = cup.start, cup.far_radius
    turn = np.linspace(0, 2 * math.pi, 64, endpoint=False)
    around = (x + radius * np.cos(turn), y + radius * np.sin(turn), np.full(64, z + cup.length))
    return np.column_stack(around)
