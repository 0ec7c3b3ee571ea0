"""What silicone fills, mm3, from the parts as solids alone: the spaces that they leave, by booleans."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

BESIDE = (
    1.0  # mm of the walls beside the carrier: beyond its gap (0.3 at most here), short of the bolts (1.2)
)
NEAR = 1e-3  # mm: a space that starts this close to a plane starts on it

Box = tuple[tuple[float, float, float], tuple[float, float, float]]


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
