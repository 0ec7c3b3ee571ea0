"""Everything that silicone can reach in the closed mold: disjoint prisms and bores that touch on plane faces.

In a doubly curved mold the skin and what touches its back are curved; volumes hold there as well.

The seats (carrier on ledge, cover on carrier) and the shims' slits in the end plates count as tight.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from skincad.inputs.design import Design
from skincad.shape import curves
from skincad.solids.bowl import gap_beside
from skincad.solids.mold import Mold, mold
from skincad.solids.plan import Body, Bore, Part, Prism, bores
from skincad.solids.shrinkage import poured

ABOVE = "cover"  # name of the spaces in the cover: what is left in them is cut off


@dataclass(frozen=True)
class Space:
    """A part of the void. Air leaves it through its faces on the plane z = `open_at` mm; `counts` is false
    where air that stays does no harm."""

    name: str
    body: Body
    open_at: float | None = None
    counts: bool = True


@dataclass(frozen=True)
class Void:
    """Spaces that touch, and the rim over which silicone runs off, `(n, 3)` mm: it rises no higher."""

    spaces: tuple[Space, ...]
    rim: NDArray[np.float64] | None = None

    @property
    def volume(self) -> float:
        """Volume by formula, mm3."""
        return math.fsum(space.body.volume for space in self.spaces)


def alone(design: Design, closed: Mold) -> Mold:
    """Return the mold of one skin: all skins of a gang fill alike."""
    return closed if design.mold.cavities == 1 else mold(design.with_(mold={"cavities": 1}))


def void(design: Design, closed: Mold) -> Void:
    """Return what the silicone fills in a mold of one skin: skin, gate, the carrier's holes and vent, the gap
    round the carrier, bleeds and the reservoir in the cover. A gate stays shut by its syringe; bleeds are
    taped when full."""
    design, carrier, skin = poured(design), closed.part("carrier"), closed.part("skin")
    cover = closed.part("cover").body
    top = cover.high if isinstance(cover, Prism) else math.inf
    spaces = [Space("skin", skin.body)]
    holes = _through(carrier)
    names = ["vent", *(f"carrier hole {i}" for i in range(1, len(holes)))]
    spaces += [Space(name, cut) for name, cut in zip(names, holes, strict=True)]
    spaces += [Space("gap round the carrier", ring) for ring in _gap(design, carrier.body)]
    spaces += [Space(ABOVE, bore, top, counts=False) for bore in _over(closed)]
    spaces += [Space("gate", bore) for bore in _gates(closed)]
    return Void(tuple(spaces), _rim(next(s.body for s in spaces if s.name == ABOVE)))


def open_trough(closed: Mold) -> Void:
    """Return the skin's space with its back open, as the silicone is poured into it before the carrier."""
    return Void((Space("skin", closed.part("skin").body, open_at=0.0),))


def perforated(closed: Mold) -> bool:
    """Whether the carrier has holes besides its vent, which silicone fills."""
    return len(_through(closed.part("carrier"))) > 1


def _through(carrier: Part) -> list[Bore]:
    """A carrier's bores from its lower face, the vent first."""
    bored = [cut for cut in carrier.cuts if isinstance(cut, Bore)]
    return [bore for bore in bored if bore.start[2] == 0.0 or bore.within is not None]


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


def _over(closed: Mold) -> list[Bore]:
    """Bores of the cover over the carrier, the reservoir first; bolts and pins stand outside the trough."""
    carrier = closed.part("carrier").body
    if not isinstance(carrier, Prism):
        return []
    side = carrier.high if carrier.axis == "x" else max(s.start.x for s in carrier.outline)
    return [c for c in closed.part("cover").cuts if isinstance(c, Bore) and abs(c.start[0]) < side]


def _gates(closed: Mold) -> list[Body]:
    """Bores in the middle of end a: bolts and pins stand beside the skin."""
    plates = [part for part in closed.parts if part.name.startswith("end-a")]
    return [c for p in plates for c in p.cuts if any(bore.start[0] == 0.0 for bore in bores(p, c))]


def _rim(cup: Body) -> NDArray[np.float64] | None:
    if not isinstance(cup, Bore):
        return None
    (x, y, z), radius = cup.start, cup.end_radius or cup.radius
    turn = np.linspace(0, 2 * math.pi, 64, endpoint=False)
    around = (x + radius * np.cos(turn), y + radius * np.sin(turn), np.full(64, z + cup.length))
    return np.column_stack(around)
