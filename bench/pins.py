"""Skins of pins against CalculiX in three dimensions, pressed, and pulled with friction.

`python -m bench.pins [first] [end] [ratio]` holds the reduced model against it on random designs, half a
minute each: 9 or 25 graded pins on flat, bent and doubly curved bases; Poisson's ratio 0.49 in both, or
another: CalculiX has no hybrid elements. `python -m bench.pins layers [first] [end]`: on a back a twentieth
to twenty times as stiff. `python -m bench.pins times`: seconds of a check by the number of pins. `python -m
bench.pins slip`: six graded pins at finite strain with friction, two minutes. Half of that skin is meshed,
cut between the pins: where a cut runs through a tip CalculiX may lose its contact. `python -m bench.pins
magnets`: how magnets in these six go and turn under forces on two tips, half a minute.

The solid is of gmsh's tetrahedra of ten nodes. A rigid flat plate is driven to one approach after another,
and may then be pulled along x: penalty contact, free sides. Layers are solids that share their nodes. Of a
skin that two planes mirror only a quarter is meshed, and pulled a half.
"""

from __future__ import annotations

import math
import re
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from time import perf_counter, process_time

import numpy as np
from numpy.typing import NDArray

import skincad
from bench import runner
from bench.calculix import SIZED, meshed, run_program
from skincad.base import RefusedError
from skincad.effects import Share, Step
from skincad.effects.pin_pad import bent_pad, pin_pad
from skincad.inputs import Design, layers, shoulder
from skincad.inputs.material import silicone
from skincad.mechanics import Drive, FrictionCoefficients, advance, magnetic_pins, pin_tops
from skincad.mechanics.contact.tips import unloaded
from skincad.mechanics.models import reduced
from skincad.shape import heights, skin_of
from skincad.solids import Part, PartRole, behind, skin_part, unchecked_solid

PENALTY = 300.0  # MPa/mm: 0.1 MPa sink in by 3e-4 mm
UPWARD = 0.2  # of a face's normal, from which it may meet the plate
NEAR = 0.7  # of a pin's height, above which its faces may
FACES = (0, 1, 2), (0, 1, 3), (1, 2, 3), (0, 2, 3)  # corners of CalculiX's S1 to S4
TETRAHEDRON = 11  # gmsh's number of one of ten nodes
PLATE = 0.5  # mm, its thickness
COARSER = 3.0  # edges of elements in the base, of those at the tips
EDGE = 1e-6  # mm, from a plane, on which a node is
FINENESS = 6  # elements over a tip
LEVELS = 0.92, 0.98  # of the approach at which all touch
STRAIN = 0.05  # of a pin, at the force whose shares are compared
MAGNET, RIGID = 99, 1e3  # a magnet's number among shots, and how many times as stiff it is as the silicone
LOADS = (1, 1), (1, 2), (2, 0), (2, 2)  # on which pin, and along which axis
LOADED = 0.4  # of the tip's radius, within which nodes bear a load
FRICTION, DOWN = 0.3, 0.2  # mm, after half of it
PULLS = 0.1, 0.2, 0.3, 0.4, 0.5  # mm
SIZE = 0.45  # mm, of elements


@dataclass(frozen=True)
class Tetrahedra:
    """Nodes `(n, 3)` mm, elements `(m, 10)` in CalculiX's order counted from 0, by the `shot` `(m,)` that
    they are in, 0 in front, and per pin its (element, face) pairs that may meet the plate."""

    nodes: NDArray[np.float64]
    elements: NDArray[np.int64]
    shot: NDArray[np.int64]
    faces: dict[int, list[tuple[int, int]]]


def press(
    design: Design,
    size: float,
    approaches: Sequence[float],
    pulls: Sequence[float] = (),
    friction: float = 0.0,
    large: bool = False,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the pins' forces along x and z `(approaches and pulls, pins, 2)`, N, and how far their tips go
    up `(approaches and pulls, pins)`, mm, at approaches in mm and then travels in mm; neo-Hookean where
    strains are `large`. `size` mm is the edge of elements at the tips, and COARSER times that elsewhere.
    Raises RuntimeError where a program fails."""
    skin = skin_of(design)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        planes = 0 if not _is_mirrored(design) else 1 if pulls else 2
        mesh = tetrahedra(design, size, folder, planes)
        drives = [(0.0, -approach) for approach in approaches] + [(x, -approaches[-1]) for x in pulls]
        deck = _deck(design, mesh, drives, planes, friction, large)
        (folder / "pins.inp").write_text("\n".join(deck))
        run_program(["ccx", "-i", "pins"], folder)
        number = r"([-+.\dE]+)"
        printed = (folder / "pins.dat").read_text()
    up = re.findall(rf"surface force .*\n\n +{number} +{number} +{number}", printed)
    forces = np.array([(float(x), -float(z)) for x, _, z in up]).reshape(len(drives), -1, 2)
    tables = re.findall(r"for set APEX.*\n\n((?: .*\n)+)", printed)
    moved = [{int(n): float(z) for n, _, _, z in map(str.split, table.splitlines())} for table in tables]
    rises = np.array([[table[n] for n in apexes(design, mesh)] for table in moved])
    if not planes:
        return forces, rises
    foot = np.array([placed.foot[:2] for placed in skin.placed])
    inside = np.array([foot[i - 1] for i in mesh.faces])
    whole = 2.0 ** (np.abs(inside[:, -planes:]) < EDGE).sum(axis=1)
    folded = np.where(np.arange(2) >= 2 - planes, np.abs(foot), foot)
    like = np.linalg.norm(folded[:, None] - inside[None], axis=2).argmin(axis=1)
    return np.asarray((forces * whole[:, None])[:, like]), rises[:, like]


def middle(design: Design, pin: int) -> NDArray[np.float64]:
    """The middle of a pin's magnet, mm."""
    return np.array([*skin_of(design).placed[pin - 1].tip[:2], sum(design.features.pocket.magnet_span) / 2])


def _in_magnets(design: Design, points: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Whether points `(m, 3)` mm lie in each pin's magnet `(m, pins)`."""
    pocket = design.features.pocket
    if pocket is None or pocket.magnet is None:
        return np.zeros((len(points), 1), dtype=bool)
    away = points[:, None] - [middle(design, pin) for pin in range(1, skin_of(design).count + 1)]
    wide, long = pocket.magnet.diameter / 2 + EDGE, pocket.magnet.length / 2 + EDGE
    return (np.hypot(away[..., 0], away[..., 1]) < wide) & (np.abs(away[..., 2]) < long)


def _is_mirrored(design: Design) -> bool:
    """Whether the planes x = 0 and y = 0 mirror the pins."""
    tips = np.array([placed.tip for placed in skin_of(design).placed])

    def rows(of: NDArray[np.float64]) -> set[tuple[float, ...]]:
        return {tuple(row) for row in (np.round(of, 6) + 0.0).tolist()}

    return all(rows(tips * sign) == rows(tips) for sign in ((-1, 1, 1), (1, -1, 1)))


def tetrahedra(design: Design, size: float, folder: Path, planes: int) -> Tetrahedra:
    """Return gmsh's mesh of the skin's solid, its half at positive y, or its quarter at positive x too."""
    import cadquery as cq

    filled = design.features.pocket is not None and design.features.pocket.magnet is not None
    bare = design.with_(pin={"pocket": None}, magnetometer=None) if filled else design
    shape = unchecked_solid(skin_part(bare))
    cq.exporters.export(cq.Workplane(shape), str(folder / "skin.step"))
    for number in range(1, len(design.shot or ()) + 1):
        layer = Part(f"shot-{number}", PartRole.SKIN, behind(design, number))
        cq.exporters.export(cq.Workplane(unchecked_solid(layer)), str(folder / f"shot-{number}.step"))
    place, rows = meshed(_geometry(design, size, planes), 3, folder)
    values = np.array([row[-10:] for row in rows if row[1] == TETRAHEDRON])
    values[:, [8, 9]] = values[:, [9, 8]]  # gmsh's last two edges are CalculiX's the other way round
    used, elements = np.unique(values, return_inverse=True)
    nodes = np.array([place[n] for n in used.tolist()])
    elements = elements.reshape(values.shape)
    shot = _shots(design, nodes, elements)
    shot[_in_magnets(design, nodes[elements[:, :4]].mean(axis=1)).any(axis=1)] = MAGNET
    if np.unique(shot).size != 1 + len(design.shot or ()) + filled:
        raise RuntimeError("gmsh loses a layer of the skin")
    return Tetrahedra(nodes, elements, shot, _tips(design, nodes, elements))


def _shots(design: Design, nodes: NDArray[np.float64], elements: NDArray[np.int64]) -> NDArray[np.int64]:
    """The shot that each element is in: the first whose face its middle is behind; 0 for none."""
    x, y, z = nodes[elements[:, :4]].mean(axis=1).T
    if (radius := design.skin.curvature_radius_y) is not None:
        axis = design.skin.thickness - radius
        y, z = 0 * y, axis + np.hypot(y, z - axis)
    found = np.zeros(len(elements), dtype=np.int64)
    for number in range(len(design.shot or ()), 0, -1):
        found[z < heights(design, number, x, y)] = number
    return found


def _geometry(design: Design, size: float, planes: int) -> Iterator[str]:
    skin = design.skin
    yield 'SetFactory("OpenCASCADE"); Geometry.OCCTargetUnit = "MM";'
    names = ["skin", *(f"shot-{number}" for number in range(1, len(design.shot or ()) + 1))]
    low = -skin.width if planes == 1 else 0.0
    for number, name in enumerate(names):
        yield f's{number}() = ShapeFromFile("{name}.step");'
        if planes:
            box = f"{low}, 0, -1, {skin.width - low}, {skin.length}, {skin.thickness + 50}"
            yield f"Box({1000 + number}) = {{{box}}};"
            both = f"Volume{{s{number}()}}; Delete; }}{{ Volume{{{1000 + number}}}; Delete;"
            yield f"s{number}() = BooleanIntersection{{ {both} }};"
        if number:
            yield f"s0() = BooleanFragments{{ Volume{{s0()}}; Delete; }}{{ Volume{{s{number}()}}; Delete; }};"
    pocket = design.features.pocket
    for pin in range(1, skin_of(design).count + 1) if pocket and pocket.magnet else ():
        x, y, z = middle(design, pin)
        low, long, wide = z - pocket.magnet.length / 2, pocket.magnet.length, pocket.magnet.diameter / 2
        if planes and min((x, y)[2 - planes :]) < -EDGE:
            continue
        yield f"n = newv; Cylinder(n) = {{{x}, {y}, {low}, 0, 0, {long}, {wide}}};"
        if planes:
            yield f"m = newv; Box(m) = {{{box}}};"
            yield "n = BooleanIntersection{ Volume{n}; Delete; }{ Volume{m}; Delete; };"
        yield "s0() = BooleanFragments{ Volume{s0()}; Delete; }{ Volume{n}; Delete; };"
    yield "Physical Volume(1) = {s0()};"
    for i, placed in enumerate(skin_of(design).placed, 1):
        x, y, z = placed.tip
        yield f"Field[{i}] = Ball; Field[{i}].XCenter = {x!r}; Field[{i}].YCenter = {y!r};"
        wide = skin_of(design).profile.tip_width / 2
        yield f"Field[{i}].ZCenter = {z!r}; Field[{i}].Radius = {wide!r};"
        yield f"Field[{i}].Thickness = {2 * wide!r};"
        yield f"Field[{i}].VIn = {size!r}; Field[{i}].VOut = {COARSER * size!r};"
    many = len(skin_of(design).placed)
    yield f"Field[{many + 1}] = Min; Field[{many + 1}].FieldsList = {{1:{many}}};"
    yield f"Background Field = {many + 1};"
    yield f"{SIZED}Mesh.Algorithm3D = 10; Mesh.HighOrderOptimize = 2;"


def _tips(
    design: Design, nodes: NDArray[np.float64], elements: NDArray[np.int64]
) -> dict[int, list[tuple[int, int]]]:
    """Faces of the boundary that look up, each of the pin whose tip is nearest, and near that tip."""
    triples = np.sort(elements[:, np.array(FACES)].reshape(-1, 3), axis=1)
    _, first, count = np.unique(triples, axis=0, return_index=True, return_counts=True)
    outer = first[count == 1]
    element, face = outer // 4, outer % 4
    corners = nodes[elements[element[:, None], np.array(FACES)[face]]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    middle = corners.mean(axis=1)
    inward = nodes[elements[element, :4]].mean(axis=1) - middle
    normal *= -np.sign((normal * inward).sum(axis=1))[:, None]
    up = normal[:, 2] / np.linalg.norm(normal, axis=1) > UPWARD
    placed = skin_of(design).placed
    tip = np.array([p.tip for p in placed])
    height = np.array([np.linalg.norm(np.array(p.tip) - np.array(p.foot)) for p in placed])
    away = np.linalg.norm(middle[:, None] - tip[None], axis=2)
    nearest = away.argmin(axis=1)
    axis = np.array([p.axis for p in placed])[nearest]
    above = ((middle - tip[nearest]) * axis).sum(axis=1) > (NEAR - 1) * height[nearest]
    faces: dict[int, list[tuple[int, int]]] = {}
    for i in np.flatnonzero(up & above):
        faces.setdefault(int(nearest[i]) + 1, []).append((int(element[i]) + 1, int(face[i]) + 1))
    return dict(sorted(faces.items()))


def apexes(design: Design, mesh: Tetrahedra) -> list[int]:
    """Return the node nearest to each meshed pin's tip, counted from 1."""
    tips = [skin_of(design).placed[pin - 1].tip for pin in mesh.faces]
    return [int(np.linalg.norm(mesh.nodes - tip, axis=1).argmin()) + 1 for tip in tips]


def _deck(
    design: Design,
    mesh: Tetrahedra,
    drives: Sequence[tuple[float, float]],
    planes: int,
    friction: float,
    large: bool,
) -> Iterator[str]:
    nodes = mesh.nodes
    count, top = len(nodes), float(pin_tops(design).max())
    low, high = nodes[:, :2].min(axis=0) - 1.0, nodes[:, :2].max(axis=0) + 1.0
    (a, b), (c, d) = low.tolist(), high.tolist()
    flat = [(a, b), (c, b), (c, d), (a, d)]
    plate = [(x, y, top) for x, y in flat] + [(x, y, top + PLATE) for x, y in flat]
    yield "*NODE, NSET=all"
    yield from (
        f"{i}, {x:.12g}, {y:.12g}, {z:.12g}" for i, (x, y, z) in enumerate([*nodes.tolist(), *plate], 1)
    )
    yield from elements(mesh)
    last = len(mesh.elements) + 1
    yield "*ELEMENT, TYPE=C3D8, ELSET=plate"
    yield ", ".join(str(n) for n in (last, *range(count + 1, count + 9)))
    back = np.flatnonzero(nodes[:, 2] < EDGE) + 1
    yield from ["*NSET, NSET=back", *map(str, back), "*NSET, NSET=plate"]
    yield from map(str, range(count + 1, count + 9))
    cut = range(2 - planes, 2)
    for axis in cut:
        on = np.setdiff1d(np.flatnonzero(np.abs(nodes[:, axis]) < EDGE) + 1, back)
        yield from [f"*NSET, NSET=cut{axis + 1}", *map(str, on)]
    for number, stuff in enumerate((silicone(design), *layers(design))):
        young, poisson = stuff.young_modulus.value, stuff.poisson_ratio
        yield f"*MATERIAL, NAME=silicone{number}"
        if large:
            first = young / 4 / (1 + poisson)
            yield f"*HYPERELASTIC, NEO HOOKE\n{first!r}, {6 * (1 - 2 * poisson) / young!r}"
        else:
            yield f"*ELASTIC\n{young!r}, {poisson!r}"
        yield f"*SOLID SECTION, ELSET=shot{number}, MATERIAL=silicone{number}"
    yield "*MATERIAL, NAME=steel\n*ELASTIC\n2e5, 0.3"
    yield "*SOLID SECTION, ELSET=plate, MATERIAL=steel"
    yield f"*SURFACE, NAME=under\n{last}, S1"
    yield f"*SURFACE INTERACTION, NAME=smooth\n*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n{PENALTY:f}"
    if friction:
        yield f"*FRICTION\n{friction!r}, {PENALTY!r}"
    for pin, faces in mesh.faces.items():
        yield f"*SURFACE, NAME=pin{pin}"
        yield from (f"{element}, S{face}" for element, face in faces)
        yield f"*CONTACT PAIR, INTERACTION=smooth, TYPE=SURFACE TO SURFACE\npin{pin}, under"
    yield from ["*NSET, NSET=apex", *map(str, apexes(design, mesh))]
    cuts = "".join(f"\ncut{axis + 1}, {axis + 1}, {axis + 1}" for axis in cut)
    yield f"*BOUNDARY\nback, 1, 3\nplate, 1, 2{cuts}"
    step = f"*STEP, INC=1000{', NLGEOM' * large}\n*STATIC\n1., 1.\n*BOUNDARY"
    for x, z in drives:
        yield f"{step}\nplate, 1, 1, {x!r}\nplate, 3, 3, {z!r}"
        for pin in mesh.faces:
            yield f"*CONTACT PRINT, SLAVE=pin{pin}, MASTER=under, FREQUENCY=1000\nCF"
        yield "*NODE PRINT, NSET=apex, FREQUENCY=1000\nU\n*END STEP\n"


def elements(mesh: Tetrahedra) -> Iterator[str]:
    """Yield CalculiX's lines of all elements, a set a shot."""
    for number in np.unique(mesh.shot).tolist():
        yield f"*ELEMENT, TYPE=C3D10, ELSET=shot{number}"
        for i in np.flatnonzero(mesh.shot == number).tolist():
            yield ", ".join(str(n) for n in (i + 1, *(mesh.elements[i] + 1).tolist()))


def random_pins(seed: int) -> Design:
    """Return one of the designs, by its number."""
    rng = np.random.default_rng(seed)

    def between(low: float, high: float) -> float:
        return round(float(rng.uniform(low, high)), 3)

    tip = between(0.8, 3.0)
    root, height = tip * between(1.05, 1.4), tip * between(0.5, 1.8)
    pitch, crown = root + tip * between(0.3, 1.2), tip * between(0.06, 0.25)
    thickness, margin = pitch * between(0.3, 1.2), root / 2 + tip * between(0.15, 1.0)
    count = int(rng.choice([3, 3, 3, 5]))
    drop = height * between(0.02, 0.08)
    rings = count // 2 + 1
    width = (count - 1) * pitch + 2 * margin
    lean, kind = math.radians(between(2, 6)), rng.choice(["flat", "flat", "bent", "dome"])
    radius = (count - 1) * pitch / 2 / math.sin(lean)
    if kind != "flat":
        thickness += radius * (1 - math.cos(1.3 * lean)) * (2 if kind == "dome" else 1)
    skin = {"thickness": thickness, "width": width, "length": width}
    skin["curvature_radius"] = 1e8 if kind == "flat" else radius
    pin = {"pattern": "square", "columns": count, "rows": count, "pitch": pitch, "root_diameter": root}
    pin |= {"tip_diameter": tip, "crown": crown}
    if kind == "dome":
        skin["curvature_radius_y"] = radius
    pin |= {"heights": [height - i * drop for i in range(rings)]}
    return skincad.Design(
        name=f"{kind}-{count}x{count}",
        skin=skin,
        pin=pin,
        material={"name": "dragon-skin-20", "poisson_ratio": 0.49},
        mold={"process": "sla", "pour": "open"},
        contact={"force": 1.0, "friction": 0.0},
    )


def layered(seed: int) -> Design:
    """Return one of the designs with a back of another silicone, by its number."""
    design, rng = random_pins(seed), np.random.default_rng((seed, 1))
    deep = round(float(rng.uniform(0.25, 0.6)) * shoulder(design.skin), 3)
    modulus = round(silicone(design).young_modulus.value * float(20 ** rng.uniform(-1, 1)), 4)
    where = str(rng.choice(["thickness", "depth"]))
    return design.with_(shot=[{where: deep, "young_modulus": modulus, "poisson_ratio": 0.49}])


def compared(design: Design) -> tuple[float, float, float, float]:
    """Return the all-touch force in N by CalculiX, and how much the reduced model's is more, relative; the
    same of the approach; and the largest difference of forces, of their mean."""
    model, tip = reduced.feature_model(design, 1.0, {}), skin_of(design).profile.tip_width
    first = reduced.all_touch_force(model)
    closes = reduced.pressed(model, first)[1]
    nominal = STRAIN * silicone(design).young_modulus.value * math.pi / 4 * tip**2 * model.gap.size
    end = max(reduced.pressed(model, max(nominal, 1.3 * first))[1], 1.2 * closes)
    down = np.array([*(level * closes for level in LEVELS), end])
    forces, rises = press(design, tip / FINENESS, down.tolist())
    forces = forces[:, :, 1]
    last, total = int(model.gap.argmax()), forces.sum(axis=1)
    gaps = model.gap[last] - down[:2] - rises[:2, last]  # before it touches, where forces have no kink
    touch = down[0] + (down[1] - down[0]) * gaps[0] / (gaps[0] - gaps[1])
    rise = math.log(total[1] / total[0]) / math.log(down[1] / down[0])
    theirs = float(total[1] * (touch / down[1]) ** rise)
    shares, approach = reduced.pressed(model, float(total[-1]))
    off = float(np.abs(shares - forces[-1]).max() / forces[-1].mean())
    return theirs, first / theirs - 1, approach / end - 1, off


def many(count: int) -> Design:
    """Return rows of as many fine pins on a slightly curved base, lower outwards."""
    width = count + 1.0
    skin = {"thickness": 5.0, "width": width, "length": width}
    pin = {"pattern": "square", "columns": count, "rows": count, "pitch": 1.0, "crown": 0.08}
    pin |= {"heights": [0.5 - 0.002 * ring for ring in range((count + 1) // 2)]}
    return skincad.Design(
        name=f"pins-{count**2}",
        skin={**skin, "curvature_radius": 200.0, "curvature_radius_y": 300.0},
        pin={**pin, "root_diameter": 0.7, "tip_diameter": 0.5},
        material={"name": "dragon-skin-20"},
        mold={"process": "sla"},
        contact={"force": 10.0},
    )


def judged(seed: int, make: Callable[[int], Design], ratio: float) -> runner.Row:
    """Return a design's comparison; RefusedError where CalculiX fails."""
    design, began = make(seed).with_(material={"poisson_ratio": ratio}), perf_counter()
    try:
        numbers = compared(design)
    except RuntimeError as failure:
        raise RefusedError(f"{design.name} {str(failure).splitlines()[0]}") from None
    name = design.name
    if design.shot:
        stiff = layers(design)[0].young_modulus.value / silicone(design).young_modulus.value
        name += f", {stiff:.2g}"
    return {"seed": seed, "name": name, "numbers": numbers, "seconds": perf_counter() - began}


def line(row: runner.Row) -> str:
    force, off, approach, share = row["numbers"]
    numbers = f"{force:17.4f}{off:+8.1%}{approach:+10.1%}{share:8.1%}{row['seconds']:6.0f}"
    return f"{row['seed']:3} {row['name']:16}{numbers}"


def times() -> None:
    for count in (22, 44):
        began, cpu = perf_counter(), process_time()
        result = skincad.check(many(count))
        spent = f"{perf_counter() - began:.1f} s, {process_time() - cpu:.1f} s of processors"
        print(f"{result.name}: {spent}; all touch at {result.all_touch_force}", flush=True)


def six() -> Design:
    """Two rows of three pins, the middle one of each 0.1 mm higher."""
    return skincad.Design(
        name="six",
        skin={"curvature_radius": 1e8, "thickness": 2.0, "width": 12.0, "length": 8.0},
        pin={
            "columns": 3,
            "rows": 2,
            "pitch": 4.0,
            "root_diameter": 2.2,
            "tip_diameter": 1.8,
            "crown": 0.3,
            "heights": [2.4, 2.5, 2.4] * 2,
        },
        material={"name": "dragon-skin-20", "poisson_ratio": 0.49},
        mold={"process": "sla", "pour": "open"},
        contact={"force": 0.2},
    )


def magnetic_six() -> Design:
    """The same, each on a magnet."""
    magnet = {"diameter": 1.0, "length": 1.0, "grade": "N42"}
    sensors = {"below": 1.0, "range": 50.0, "noise": 2.0, "rate": 100.0}
    return six().with_(
        pin={"pocket": {"diameter": 0.9, "depth": 3.5, "magnet": magnet}}, magnetometer=sensors
    )


def magnet_moves(
    design: Design, loads: Sequence[tuple[int, int]], size: float = SIZE
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return how magnets go and turn under each load, a pin and an axis, `(loads, pins, 6)`, mm/N and 1/N, by
    CalculiX, the best rigid motion of a magnet's nodes, and by skincad."""
    placed, wide = skin_of(design).placed, LOADED * skin_of(design).profile.tip_width / 2
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        mesh = tetrahedra(design, size, folder, 0)
        nodes, stuff = mesh.nodes, silicone(design)
        young, poisson = stuff.young_modulus.value, stuff.poisson_ratio
        inside = _in_magnets(design, nodes)
        sets = {"back": nodes[:, 2] < EDGE, "magnets": inside.any(axis=1)}
        deck = ["*NODE, NSET=all"]
        deck += [f"{i}, {x:.12g}, {y:.12g}, {z:.12g}" for i, (x, y, z) in enumerate(nodes.tolist(), 1)]
        deck += elements(mesh)
        for which, ratio, number in ((young, poisson, 0), (RIGID * young, 0.3, MAGNET)):
            deck += [f"*MATERIAL, NAME=stuff{number}\n*ELASTIC\n{which!r}, {ratio!r}"]
            deck += [f"*SOLID SECTION, ELSET=shot{number}, MATERIAL=stuff{number}"]
        for which, members in sets.items():
            deck += [f"*NSET, NSET={which}", *map(str, np.flatnonzero(members) + 1)]
        deck += ["*BOUNDARY\nback, 1, 3"]
        corners = np.unique(mesh.elements[:, :4])
        for pin, axis in loads:
            arms = nodes[corners] - placed[pin - 1].tip
            bear, arms = (of[np.linalg.norm(arms, axis=1) < wide] for of in (corners + 1, arms))
            even = np.vstack([np.ones(bear.size), arms.T])  # no moment about the tip
            share = np.linalg.lstsq(even, [1.0, 0.0, 0.0, 0.0])[0]
            deck += ["*STEP\n*STATIC\n*CLOAD, OP=NEW"]
            deck += [f"{n}, {axis + 1}, {w:.9f}" for n, w in zip(bear.tolist(), share.tolist(), strict=True)]
            deck += ["*NODE PRINT, NSET=magnets\nU\n*END STEP"]
        (folder / "pins.inp").write_text("\n".join(deck) + "\n")
        run_program(["ccx", "-i", "pins"], folder)
        printed = (folder / "pins.dat").read_text()
    theirs = np.zeros((len(loads), len(placed), 6))
    for load, table in enumerate(re.findall(r"for set MAGNETS.*\n\n((?: .*\n)+)", printed)):
        rows = [row.split() for row in table.splitlines()]
        way = {int(n) - 1: [float(u) for u in moved] for n, *moved in rows}
        for pin in range(len(placed)):
            numbers = np.flatnonzero(inside[:, pin])
            arms = nodes[numbers] - middle(design, pin + 1)
            rigid = np.concatenate([np.hstack([np.eye(3), np.cross(np.eye(3), arm).T]) for arm in arms])
            theirs[load, pin] = np.linalg.lstsq(rigid, np.concatenate([way[n] for n in numbers.tolist()]))[0]
    goes = magnetic_pins(design).goes
    return theirs, np.array([goes[:, :, pin - 1, axis] for pin, axis in loads])


def print_magnet_moves() -> None:
    """Print how magnets go, mm/N, and turn, 1/N, by CalculiX and by skincad."""
    for (pin, axis), theirs, ours in zip(LOADS, *magnet_moves(magnetic_six(), LOADS), strict=True):
        print(f"1 N on pin {pin} along {'xyz'[axis]}")
        for number, (a, b) in enumerate(zip(theirs, ours, strict=True), 1):
            print(f"{number}  ", *(f"{one:8.4f}" for one in a), "  ", *(f"{one:8.4f}" for one in b))


def slips(
    pulls: Sequence[float], design: Design, size: float = SIZE
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return the pins' pulls and normal forces `(travels, pins, 2)`, N, by CalculiX and by skincad in small
    and at finite strain, at the plate's travels, mm, under the normal force that CalculiX has when it is
    down."""
    theirs, _ = press(design, size, [DOWN / 2, DOWN], pulls, FRICTION, large=True)
    force, tips = float(theirs[1, :, 1].sum()), pin_pad(design).tips
    state, small = advance(tips, unloaded(tips), Drive(force, travel=0.0), FRICTION), []
    pad, before = bent_pad(design), Drive(0.0, travel=0.0)
    bent, finite = pad.start(), []
    for travel in (0.0, *pulls):
        after, cone = Drive(force, travel=travel), FrictionCoefficients(FRICTION, FRICTION)
        bent, before = pad.advanced(bent, Step(0.0, 1.0, before, after), Share(cone)), after
        state = advance(tips, state, after, FRICTION)
        for contact, rows in ((state, small), (bent.contact, finite)):
            rows.append(np.stack([contact.tangential, contact.normal], axis=1))
    return theirs[2:], np.array(small[1:]), np.array(finite[1:])


def slip() -> None:
    """Print pulls of pins at the plate's travels, mN, by CalculiX and by skincad."""
    began = perf_counter()
    found = slips(PULLS, six())
    print(f"{perf_counter() - began:.0f} s")
    for travel, *rows in zip(PULLS, *found, strict=True):
        for name, row in zip(("CalculiX", "small strain", "finite strain"), rows, strict=True):
            print(f"{travel:4} mm {name:13}", *(f"{1e3 * pull:7.2f}" for pull in row[:3, 0]))


def main() -> None:
    parser = runner.parser(__doc__)
    parser.add_argument(
        "words", nargs="*", help="layers, times, slip or magnets; first and last seed; Poisson's ratio"
    )
    options = parser.parse_args()
    words, make = options.words, random_pins
    prints = {"times": times, "slip": slip, "magnets": print_magnet_moves}
    if len(words) == 1 and words[0] in prints:
        prints[words[0]]()
        return
    if words[:1] == ["layers"]:
        words, make = words[1:], layered
    first, end = (int(word) for word in (words[:2] or ("0", "16")))
    ratio = float(words[2]) if len(words) > 2 else 0.49
    print(f"{'':20}{'all touch at, N':>17}{'off':>8}{'approach':>10}{'share':>8}{'s':>6}")
    judge = partial(judged, make=make, ratio=ratio)
    runner.rows(f"{make.__name__}-{ratio:g}", judge, range(first, end), options, line)


if __name__ == "__main__":
    main()
