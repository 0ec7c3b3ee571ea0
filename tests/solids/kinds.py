"""One small design of each kind of mold, for tests that are the same for all."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import cadquery as cq

import skincad
from skincad.inputs import Design
from tests import designs
from tests.designs import bent, mounted_design, three_ridges

STIFF = {"young_modulus": 2.0, "poisson_ratio": 0.499}
LEVEL, ARC = {**STIFF, "thickness": 1.0}, {**STIFF, "depth": 1.0}
RIVETS = {"bond": "rivets"}
FEW = ["ridge.count=3", "skin.width=5.0"]
STEM, PLATE = (5.0, 6.0, 12.0), (12.0, 14.0, 1.5)


def few_ridges(**tables: Any) -> Design:
    return skincad.load("yamada-2002", FEW).with_(**tables)


def few_strips(**tables: Any) -> Design:
    return skincad.load("cast-in", ["ridge.count=3"]).with_(**tables)


def stem(high: float = 2.0) -> cq.Workplane:
    """A block on the back, and a stem behind it."""
    block = cq.Workplane("XY").box(8, 10, high, centered=(True, True, False))
    return block.faces("<Z").workplane().rect(*STEM[:2]).extrude(STEM[2])


def saddle(radius: float, high: float = 2.0) -> cq.Workplane:
    """The same, longer, for a back of that radius along y."""
    block = cq.Workplane("XY").box(8, 10, high + 2.0).translate((0, 0, high / 2 - 1.0))
    under = cq.Workplane("YZ").circle(radius).extrude(20, both=True).translate((0, 0, -radius))
    block = block.cut(under)
    behind = cq.Workplane("XY").box(*STEM[:2], 14.5, centered=(True, True, False))
    return block.union(behind.translate((0, 0, -14.0)))


def lab_bowl() -> Design:
    """Three ridges on 8 mm, curved along y by 60 mm."""
    return skincad.load("lab-bench", ["ridge.count=3", "skin.curvature_radius_y=60.0"])


def plate(wide: float = PLATE[0], long: float = PLATE[1]) -> cq.Workplane:
    """A plate that ends at the back, with two holes for pins and two for rivets."""
    block = cq.Workplane("XY").box(wide, long, PLATE[2], centered=(True, True, False))
    drilled = block.faces(">Z").workplane().pushPoints([(-4.5, 0), (4.5, 0)]).hole(2.0)
    return drilled.faces(">Z").workplane().pushPoints([(0, -4), (0, 4)]).hole(1.5)


def boned(folder: Path, shape: cq.Workplane | str, base: Design | None = None, **mold_keys: Any) -> Design:
    """A design, else a lab-bench of three ridges, cast on a bone."""
    path = folder / f"bone-{len(list(folder.iterdir()))}.step"  # molds of a run are kept by the path
    if isinstance(shape, str):
        path.write_text(shape)
    else:
        cq.exporters.export(shape, str(path))
    base = base or skincad.load("lab-bench", ["ridge.count=3"])
    return base.with_(mold={"bone": str(path), "gate": None, **mold_keys})


def many_locked() -> Design:
    """Seven locked ridges on a radius of 8 mm: pieces between on both sides of the middle one."""
    skin = {"curvature_radius": 8.0, "width": 10.5, "thickness": 4.0}
    ridge = {"count": 7, "height": 1.2, "pitch": 1.3, "root_width": 0.5, "tip_width": 0.5}
    return skincad.load("steep-fingertip").with_(skin=skin, ridge=ridge, slot=None, mold={"floor": 14.0})


def bowl_of_layers(*shots: dict[str, Any]) -> Design:
    """Three ridges on a skin that is curved along y too, in layers."""
    return bent("yamada-2002", 60.0, *FEW).with_(shot=shots)


def deep_bowl() -> Design:
    """A thick skin without slots, curved along y too."""
    return bent("plain-ridges", 60.0, "ridge.count=3").with_(skin={"thickness": 7.0, "length": 20.0})


def round_flat() -> Design:
    """A cylinder under a spherical cap."""
    skin = {"outline": "round", "curvature_radius": 30.0, "thickness": 4.0, "width": 14.0}
    rest = {"material": {"name": "dragon-skin-20"}, "mold": {"process": "sla"}}
    return skincad.Design(name="round-flat", skin=skin, flat={"columns": 1, "rows": 1, "pitch": 4.0}, **rest)


def wide_rings() -> Design:
    return designs.rings().with_(skin={"width": 22.0})


LOCKED = ["skin.curvature_radius=15.0", "ridge.tip_width=0.7", "slot=none"]
HARD = {"name": "dragon-skin-30"}
IN_A_BLOCK = {"block_process": "fdm", "lid_process": "fdm"}
KINDS: dict[str, Callable[[Path], Design]] = {
    "straight": lambda _: few_ridges(),
    "plain": lambda _: skincad.load("plain-ridges", ["ridge.count=3"]),
    "unlike": lambda _: few_ridges(ridge={"heights": [0.45, 0.5, 0.56]}),
    "strips": lambda _: few_strips(),
    "tilted strips": lambda _: few_strips(slot={"tilt": 30.0}),
    "strips wired at the gate": lambda _: few_strips(film={"wiring_side": "a"}),
    "gang": lambda _: few_ridges(mold={"cavities": 2}),
    "gang of four": lambda _: skincad.load("plain-ridges", ["ridge.count=3", "mold.cavities=4"]),
    "split": lambda _: skincad.load("steep-fingertip"),
    "split of seven": lambda _: many_locked(),
    "locked": lambda _: skincad.load("yamada-2002", LOCKED),
    "mount": lambda _: mounted_design("yamada-2002"),
    "bowl": lambda _: three_ridges(),
    "shallow bowl": lambda _: bent("yamada-2002", 60.0, "ridge.count=3"),
    "mount on a bowl": lambda _: mounted_design("bent"),
    "round": lambda _: designs.rings(),
    "round and flat": lambda _: round_flat(),
    "round in a block": lambda _: designs.rings().with_(mold=IN_A_BLOCK),
    "round with pins": lambda _: designs.round_nibs().with_(skin={"width": 8.0}),
    "pins": lambda _: designs.pillars(),
    "pins on a dome": lambda _: designs.dome().with_(pin={"rings": 2}),
    "pins through a plate": lambda _: designs.pillars().with_(mold={"split": "tips"}),
    "pockets": lambda _: designs.flat(),
    "layers": lambda _: few_ridges(shot=(LEVEL,)),
    "layers with rivets": lambda _: few_ridges(shot=({**ARC, "depth": 1.2, **RIVETS},)),
    "round layers": lambda _: designs.rings().with_(shot=({**LEVEL, **RIVETS},)),
    "round layers of a depth": lambda _: designs.rings().with_(shot=({**STIFF, "depth": 2.0},)),
    "layers over pins": lambda _: designs.pillars().with_(shot=({**LEVEL, **RIVETS},)),
    "pockets through layers": lambda _: designs.pillars().with_(
        pin={"pocket": {"diameter": 1.6, "depth": 2.5}}, shot=(LEVEL,)
    ),
    "layers over pockets": lambda _: designs.flat().with_(shot=({**STIFF, "depth": 1.2},)),
    "layers in a bowl": lambda _: bowl_of_layers({**STIFF, "thickness": 1.5}),
    "layers with rivets in a bowl": lambda _: deep_bowl().with_(
        shot=({**STIFF, **RIVETS, "thickness": 2.0}, {**STIFF, "depth": 2.5})
    ),
    "layers over pins on a dome": lambda _: designs.dome().with_(
        pin={"rings": 2}, shot=({**STIFF, "thickness": 1.5},)
    ),
    "pockets in a bowl": lambda _: designs.flat().with_(skin={"curvature_radius_y": 40.0}),
    "pockets through layers in a bowl": lambda _: designs.flat().with_(
        skin={"curvature_radius_y": 40.0, "thickness": 5.0}, shot=({**STIFF, "thickness": 1.5},)
    ),
    "bone": lambda folder: boned(folder, stem()),
    "bone on pins": lambda folder: boned(folder, plate(), bone_bond="rivets"),
    "turned bone": lambda folder: boned(folder, stem(), bone_at=[2.0, 1.0, 0.0], bone_turn=[0.0, 0.0, 90.0]),
    "bones of a gang": lambda folder: boned(folder, stem(), cavities=2),
    "bone behind a layer": lambda folder: boned(folder, stem()).with_(shot=({**HARD, "thickness": 3.0},)),
    "bone in a bowl": lambda folder: boned(folder, saddle(52.0), lab_bowl()),
    "bone behind a layer in a bowl": lambda folder: boned(folder, saddle(52.0), lab_bowl()).with_(
        shot=({**HARD, "thickness": 4.0},)
    ),
    "bone in a round skin": lambda folder: boned(folder, stem(), wide_rings()),
    "bone on pins in a round skin": lambda folder: boned(
        folder, plate(), wide_rings().with_(shot=({**HARD, "thickness": 2.6},))
    ),
}
