"""A skin of pins in CalculiX: its solid in gmsh's tetrahedra of ten nodes, pressed by a rigid flat plate that
is driven to one approach after another, and may then be pulled along x against friction. Layers of other
silicones are solids of their own that share their nodes.

Small strain unless asked, penalty contact, and sides that are free. Both programs are processes of their own,
as in calculix.py. Of a skin that two planes mirror only a quarter is meshed, and pulled a half.
"""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bench.calculix import run_program
from skincad.inputs import Design, layers
from skincad.inputs.material import silicone
from skincad.mechanics import pin_tops
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


def _is_mirrored(design: Design) -> bool:
    """Whether the planes x = 0 and y = 0 mirror the pins."""
    tips = np.array([placed.tip for placed in skin_of(design).placed])

    def rows(of: NDArray[np.float64]) -> set[tuple[float, ...]]:
        return {tuple(row) for row in (np.round(of, 6) + 0.0).tolist()}

    return all(rows(tips * sign) == rows(tips) for sign in ((-1, 1, 1), (1, -1, 1)))


def tetrahedra(design: Design, size: float, folder: Path, planes: int) -> Tetrahedra:
    """Return gmsh's mesh of the skin's solid, its half at positive y, or its quarter at positive x too."""
    import cadquery as cq

    shape = unchecked_solid(skin_part(design))
    cq.exporters.export(cq.Workplane(shape), str(folder / "skin.step"))
    for number in range(1, len(design.shot or ()) + 1):
        layer = Part(f"shot-{number}", PartRole.SKIN, behind(design, number))
        cq.exporters.export(cq.Workplane(unchecked_solid(layer)), str(folder / f"shot-{number}.step"))
    (folder / "pins.geo").write_text("\n".join(_geometry(design, size, planes)))
    run_program(["gmsh", "-3", "-order", "2", "-format", "msh22", "-nt", "1", "pins.geo"], folder)
    text = (folder / "pins.msh").read_text()

    def block(name: str) -> list[str]:
        return text.partition(f"${name}\n")[2].partition(f"$End{name}")[0].splitlines()[1:]

    place = {int(row[0]): [float(x) for x in row[1:]] for row in map(str.split, block("Nodes"))}
    rows = [[int(word) for word in line.split()] for line in block("Elements")]
    values = np.array([row[-10:] for row in rows if row[1] == TETRAHEDRON])
    values[:, [8, 9]] = values[:, [9, 8]]  # gmsh's last two edges are CalculiX's the other way round
    used, elements = np.unique(values, return_inverse=True)
    nodes = np.array([place[int(n)] for n in used])
    elements = elements.reshape(values.shape)
    shot = _shots(design, nodes, elements)
    if np.unique(shot).size != 1 + len(design.shot or ()):
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
    for option in ("MeshSizeFromPoints", "MeshSizeFromCurvature", "MeshSizeExtendFromBoundary"):
        yield f"Mesh.{option} = 0;"
    yield "Mesh.Algorithm3D = 10; Mesh.HighOrderOptimize = 2;"


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
    for number in np.unique(mesh.shot).tolist():
        yield f"*ELEMENT, TYPE=C3D10, ELSET=shot{number}"
        for i in np.flatnonzero(mesh.shot == number).tolist():
            yield ", ".join(str(n) for n in (i + 1, *(mesh.elements[i] + 1).tolist()))
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
