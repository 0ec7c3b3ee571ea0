"""skincad against CalculiX on plain-ridges at 4 N: error against time, linear and neo-Hookean, in one run.

`python -m bench.calculix [linear]` prints the tables and the ratios of times at equal error. skincad solves
half of the section unasked; CalculiX is asked for the whole and, in the linear table, for the half too, its
cut held sideways. Times are processor times: CalculiX's without gmsh, skincad's with its mesh and the
all-touch force, which CalculiX is not asked. An error is the largest of the shares' differences, N.

CalculiX has quads from gmsh, CPE8R, or CAX8R of a section that turns, and penalty contact with a rigid flat
plate on a spring too soft to carry a force, so that the load is a force. Both programs are processes of their
own (Debian packages `calculix-ccx` and `gmsh`), on files in a temporary folder and on one processor.
"""

from __future__ import annotations

import math
import os
import re
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from time import perf_counter, process_time

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from bench import runner
from skincad import load
from skincad.laws import Ogden
from skincad.mechanics import Pad, Sizes, at_faces, default_sizes, half_of, pad_of, piece_of, plane_piece
from skincad.mechanics.models import finite_strain, linear
from skincad.shape import Segment

PACKAGES = ("calculix-ccx", "gmsh")
PROGRAMS = ("ccx", "gmsh")
GROWTH = 0.2  # of an edge per distance from the ridges and from the back's corners
RIDGES_REACH = 0.3  # mm; edges grow beyond this distance from a ridge's points
CORNER = 20  # times coarser at the back's corners than skincad: enough for 8-node quads, measured
PENALTY = 3e3  # MPa/mm; 0.15 MPa sink in by 5e-5 mm, 3e-4 of the approach; 1e4 takes twice as long
SOFT = 1e-6  # N/mm a mm of length, holds the plate while it is clear
FIRST = 1 / 16  # of the approach in one increment; of 1/8 and 1/4 half were cut and repeated
UNBALANCED = 1e-3  # of the force, what the contact forces may miss of it
TURN = 180  # wedges of 2 degrees, of which CalculiX prints one's contact force
PLATE_PARTS, NEAR_AXIS = 40, 1e-3  # a turned plate's elements, and mm from the axis to the first
PLATE = 0.5  # mm, height of the plate's only element
LINE, QUAD = 8, 16  # gmsh's numbers of a line of 3 nodes and a quad of 8
BACK, CUT = 10_000, 10_001  # numbers of curves, beyond any ridge's
SIZED = (
    "Mesh.MeshSizeFromPoints = 0;\nMesh.MeshSizeFromCurvature = 0;\nMesh.MeshSizeExtendFromBoundary = 0;\n"
)
FACE = 5_000  # of the first layer's face, beyond any of the outline's
SECTION = 20_000  # number of the surface, beyond any curve's: GetFEM keeps both in one list
FORCE = 4.0  # N
LEVELS = ((0.25, 2), (0.5, 2), (0.5, 3), (1.0, 3), (1.0, 4), (2.0, 4), (2.0, 5))  # fineness, order
MESHES = {"linear": (0.25, 0.5, 1.0, 2.0), "finite-strain": (0.25, 0.5, 1.0)}  # CalculiX's fineness
GOALS = {"linear": 50.0, "finite-strain": 100.0}
REPEATS = 3
# of the linear approach, where CalculiX's finite strain changes to a force (docs/evidence/facts.md)
SOFTER = 0.95


@dataclass(frozen=True)
class Quads:
    """Nodes `(n, 2)` mm, elements `(m, 8)` counted from 0, and per ridge its (element, face) pairs; nodes on
    the clamped `back` and on the `cut` of a half."""

    nodes: NDArray[np.float64]
    elements: NDArray[np.int64]
    back: NDArray[np.int64]
    cut: NDArray[np.int64]
    faces: dict[int, list[tuple[int, int]]]


@dataclass(frozen=True)
class PressedPad:
    """What is found: shares `(ridges,)` N, approach mm, and processor time, s; `more` s of it went into what
    only one program is asked."""

    shares: NDArray[np.float64]
    approach: float
    unknowns: int
    seconds: float
    more: float = 0.0


def missing() -> str:
    """Return what to install, or "" where both programs are there."""
    if all(shutil.which(program) for program in PROGRAMS):
        return ""
    return f"CalculiX is not compared: apt-get install {' '.join(PACKAGES)}"


def quads(pad: Pad, sizes: Sizes, folder: Path) -> Quads:
    """Return gmsh's second-order quads of the pad's section, their edges on its lines and arcs."""
    place, table = meshed(geometry(pad, sizes), 2, folder)
    # gmsh also writes the arcs' centres: only nodes of quads are kept
    values = np.array([row[5:] for row in table if row[1] == QUAD])
    if any(row[1] not in (LINE, QUAD) for row in table):
        raise RuntimeError("gmsh left triangles in its mesh")
    used, elements = np.unique(values, return_inverse=True)
    nodes = np.array([place[n][:2] for n in used.tolist()])
    sides = {
        frozenset((int(quad[j]), int(quad[(j + 1) % 4]))): (i, j + 1)
        for i, quad in enumerate(values)
        for j in range(4)
    }
    faces: dict[int, list[tuple[int, int]]] = {}
    held: dict[int, list[int]] = {BACK: [], CUT: []}
    for row in table:
        if row[1] == LINE and row[3] in held:
            held[row[3]] += row[5:]
        elif row[1] == LINE:
            faces.setdefault(row[3], []).append(sides[frozenset(row[5:7])])
    back, cut = (np.searchsorted(used, np.unique(held[part])).astype(np.int64) for part in (BACK, CUT))
    return Quads(nodes, elements.reshape(values.shape), back, np.setdiff1d(cut, back), faces)


def meshed(
    lines: Iterator[str], dimensions: int, folder: Path
) -> tuple[dict[int, list[float]], list[list[int]]]:
    """Return gmsh's mesh of second order, which it leaves in pad.msh: nodes by number, and its elements."""
    (folder / "pad.geo").write_text("\n".join(lines))
    words = ["gmsh", f"-{dimensions}", "-order", "2", "-format", "msh22", "-nt", "1", "pad.geo"]
    run_program(words, folder)
    text = (folder / "pad.msh").read_text()

    def block(name: str) -> list[list[str]]:
        lines = text.partition(f"${name}\n")[2].partition(f"$End{name}")[0].splitlines()[1:]
        return [line.split() for line in lines]

    place = {int(row[0]): [float(x) for x in row[1:]] for row in block("Nodes")}
    return place, [[int(word) for word in row] for row in block("Elements")]


def geometry(pad: Pad, sizes: Sizes, recombined: bool = True) -> Iterator[str]:
    """Lines of gmsh's input: points, arcs by their centres, named curves, and the size of edges; of quads, or
    where not `recombined` of triangles."""
    if pad.strips or pad.voids:
        raise ValueError("only sections without slots and strips are compared")
    outline = tuple(at_faces(pad))
    for i, s in enumerate(outline, 1):
        yield f"Point({i}) = {{{s.start.x!r}, {s.start.z!r}, 0}};"
    for i, s in enumerate(outline, 1):
        end = i % len(outline) + 1
        yield _curve(s, i, i, end)
    yield f"Curve Loop(1) = {{1:{len(outline)}}}; Plane Surface(1) = {{1}};"
    yield f"Physical Surface({SECTION}) = {{1}};"
    for number, layer in enumerate(pad.layers, FACE):
        first, last = (
            min(range(len(outline)), key=lambda i: math.dist(outline[i].start, end)) + 1
            for end in (layer.face.start, layer.face.end)
        )
        yield f"{_curve(layer.face, number, first, last)} Curve{{{number}}} In Surface{{1}};"
    back = [i for i, s in enumerate(outline, 1) if s.kind == "back"]
    yield f"Physical Curve({BACK}) = {{{_list(back)}}};"
    cut = [i for i, s in enumerate(outline, 1) if s.kind == "cut"]
    if cut:
        yield f"Physical Curve({CUT}) = {{{_list(cut)}}};"
    for ridge in pad.ridges:
        rows = [i for i, s in enumerate(outline, 1) if s.touches and s.feature == ridge]
        yield f"Physical Curve({ridge}) = {{{_list(rows)}}};"
    ends = {i for b in back for i in (b, b % len(outline) + 1)}
    corners = ends - {i for c in cut for i in (c, c % len(outline) + 1)}  # no corner of the pad
    crests = [i for i, s in enumerate(outline, 1) if s.feature is not None]
    yield f"Field[1] = Distance; Field[1].PointsList = {{{_list(corners)}}};"
    yield f"Field[2] = Distance; Field[2].PointsList = {{{_list(crests)}}};"
    beyond = f"0.5 * (F2 - {RIDGES_REACH} + Fabs(F2 - {RIDGES_REACH}))"
    corner = CORNER * sizes.corner
    yield f'Field[3] = MathEval; Field[3].F = "{corner!r} + {GROWTH} * F1";'
    yield f'Field[4] = MathEval; Field[4].F = "{sizes.contact!r} + {GROWTH} * {beyond}";'
    yield f'Field[5] = MathEval; Field[5].F = "{sizes.bulk!r}";'
    yield "Field[6] = Min; Field[6].FieldsList = {3, 4, 5}; Background Field = 6;"
    yield f"{SIZED}Mesh.Algorithm = 6;"
    if recombined:
        yield "Mesh.RecombineAll = 1; Mesh.RecombinationAlgorithm = 3;"
        yield "Mesh.SecondOrderIncomplete = 1;"


def _curve(s: Segment, number: int, first: int, last: int) -> str:
    if s.bulge == 0.0:
        return f"Line({number}) = {{{first}, {last}}};"
    aside = (1 - s.bulge**2) / (4 * s.bulge)  # of the chord, from its middle to the centre
    x = (s.start.x + s.end.x) / 2 - aside * (s.end.z - s.start.z)
    z = (s.start.z + s.end.z) / 2 + aside * (s.end.x - s.start.x)
    centre = 1000 + number
    return f"Point({centre}) = {{{x!r}, {z!r}, 0}}; Circle({number}) = {{{first}, {centre}, {last}}};"


def _list(numbers: object) -> str:
    return ", ".join(str(n) for n in sorted(numbers))  # type: ignore[call-overload]


def _quad(left: float, right: float, low: float, high: float) -> list[tuple[float, float]]:
    """The corners of a rectangle, then the middles of its sides."""
    x, z = (left + right) / 2, (low + high) / 2
    corners = [(left, low), (right, low), (right, high), (left, high)]
    return [*corners, (x, low), (right, z), (x, high), (left, z)]


def _deck(pad: Pad, mesh: Quads, force: float, start: float | None) -> Iterator[str]:
    """Lines of CalculiX's input for a slice 1 mm long, or for the whole turn; with a `start`, mm, the law and
    large strains."""
    finite, kind = start is not None, "CAX8R" if pad.revolved else "CPE8R"
    count, left, right = len(mesh.nodes), mesh.nodes[:, 0].min() - 1, mesh.nodes[:, 0].max() + 1
    left = max(left, NEAR_AXIS) if pad.revolved else left
    top, high = pad.top, pad.top + PLATE
    parts = PLATE_PARTS if pad.revolved else 1
    edges = pairwise(np.linspace(left, right, parts + 1).tolist())
    plate = [place for a, b in edges for place in _quad(a, b, top, high)]
    yield "*NODE, NSET=all"
    for i, (x, z) in enumerate([*mesh.nodes.tolist(), *plate], 1):
        yield f"{i}, {x:.12g}, {z:.12g}, 0."
    middles = mesh.nodes[mesh.elements[:, :4]].mean(axis=1)
    behind = [sum(z > layer.over(x) for layer in pad.layers) for x, z in middles.tolist()]
    names = [f"layer{n}" for n in range(len(pad.layers))] + ["skin"]
    for i, (quad, of) in enumerate(zip(mesh.elements + 1, behind, strict=True), 1):
        yield f"*ELEMENT, TYPE={kind}, ELSET={names[of]}\n" + ", ".join(str(n) for n in (i, *quad.tolist()))
    last = len(mesh.elements) + 1
    yield f"*ELEMENT, TYPE={kind}, ELSET=plate"
    for i in range(parts):
        yield ", ".join(str(n) for n in (last + i, *range(count + 8 * i + 1, count + 8 * i + 9)))
    # rigid: its nodes sink together (*RIGID BODY does not go with the conditions of plane strain)
    reference, others = count + 1, range(count + 2, count + 8 * parts + 1)
    yield from (f"*EQUATION\n2\n{n}, 2, 1., {reference}, 2, -1." for n in others)
    yield f"*ELEMENT, TYPE=SPRING1, ELSET=soft\n{last + parts}, {reference}\n*SPRING, ELSET=soft\n2\n{SOFT:f}"
    yield "*NSET, NSET=plate\n" + "\n".join(str(n) for n in (reference, *others))
    for name, nodes in (("back", mesh.back), ("cut", mesh.cut)):
        yield from [f"*NSET, NSET={name}", *(f"{n + 1}" for n in nodes)] if nodes.size else ()
    yield f"*NSET, NSET=reference\n{reference}"
    yield from _materials(pad, names, finite=finite)
    yield "*MATERIAL, NAME=steel\n*ELASTIC\n2e5, 0.3\n*SOLID SECTION, ELSET=plate, MATERIAL=steel\n1."
    yield "*SURFACE, NAME=under\n" + "\n".join(f"{last + i}, S1" for i in range(parts))
    yield f"*SURFACE INTERACTION, NAME=smooth\n*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n{PENALTY:f}"
    for ridge, faces in sorted(mesh.faces.items()):
        yield f"*SURFACE, NAME=ridge{ridge}"
        yield from (f"{element + 1}, S{face}" for element, face in faces)
        yield "*CONTACT PAIR, INTERACTION=smooth, TYPE=SURFACE TO SURFACE"
        yield f"ridge{ridge}, under"
    held = "back, 1, 2\nplate, 1, 1" + ("\ncut, 1, 1" if mesh.cut.size else "")
    yield f"*BOUNDARY\n{held}"
    step = "*STEP, INC=1000"
    if finite:  # from open contact a force diverges: first to an approach near the end, in small steps
        yield f"{step}, NLGEOM\n*STATIC\n{FIRST}, 1., 1e-4, {FIRST}"
        yield f"*BOUNDARY\n{reference}, 2, 2, {-start!r}\n*END STEP"
        step = f"{step}, NLGEOM, AMPLITUDE=STEP"
    yield f"{step}\n*STATIC\n1., 1.\n*BOUNDARY, OP=NEW\n{held}"
    yield f"*CLOAD\n{reference}, 2, {-force / (1.0 if pad.revolved else pad.length)!r}"
    yield "*NODE PRINT, NSET=reference, FREQUENCY=1000\nU"
    for ridge in sorted(mesh.faces):
        yield f"*CONTACT PRINT, SLAVE=ridge{ridge}, MASTER=under, FREQUENCY=1000\nCF"
    yield "*END STEP\n"


def _materials(pad: Pad, names: list[str], *, finite: bool) -> Iterator[str]:
    """Lines of the silicones of the domains, from the back, the skin's own last."""
    for name, stuff in zip(names, (*pad.layers, pad), strict=True):
        young, ratio = stuff.young_modulus, stuff.poisson_ratio
        shear, bulk = young / (2 * (1 + ratio)), young / (3 * (1 - 2 * ratio))
        yield f"*MATERIAL, NAME=of_{name}"
        if finite and pad.laws:
            yield from _ogden(pad, bulk)
        elif finite:  # C10 = G / 2, D1 = 2 / K
            yield f"*HYPERELASTIC, NEO HOOKE\n{shear / 2!r}, {2 / bulk!r}"
        else:
            yield f"*ELASTIC\n{young!r}, {ratio!r}"
        yield f"*SOLID SECTION, ELSET={name}, MATERIAL=of_{name}\n1."


def _ogden(pad: Pad, bulk: float) -> Iterator[str]:
    """Ogden's law in CalculiX, whose mu and alpha are ours: alternating, then D1 = 2 / K and zeros."""
    if not isinstance(pad.law, Ogden):
        raise ValueError("of laws beside neo-Hooke's only Ogden's is compared")
    law = pad.law.scaled(pad.young_modulus / pad.law.young_modulus(pad.poisson_ratio))
    constants = [number for pair in zip(law.mu, law.alpha, strict=True) for number in pair]
    constants += [2 / bulk, *(0.0 for _ in law.mu[1:])]
    yield f"*HYPERELASTIC, OGDEN, N={len(law.mu)}\n{', '.join(map(repr, constants))}"


def press(
    pad: Pad, fineness: float, force: float, start: float | None = None, *, whole: bool = True
) -> PressedPad:
    """Return CalculiX's contact of the pad with the plate at `force` N; of all of it, or of its half with the
    cut held sideways, as always of a section that turns.

    Small strain, or by the pad's law, neo-Hooke's or Ogden's, where `start` is given: an approach near the
    answer, mm, from where it changes from a driven plate to a loaded one. Raises RuntimeError when a
    program fails.
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        whole = whole and not pad.revolved
        piece = pad if whole else half_of(pad)
        if piece is None:
            raise ValueError("the pad is not its own mirror image")
        borne = force if whole or pad.revolved else force / 2
        length = TURN if pad.revolved else pad.length
        mesh = quads(piece, default_sizes(pad, fineness), folder)
        (folder / "pad.inp").write_text("\n".join(_deck(piece, mesh, borne, start)))
        before = _children()
        run_program(["ccx", "-i", "pad"], folder)
        seconds = _children() - before
        shares, approach = read((folder / "pad.dat").read_text(), len(mesh.faces))
    if abs(shares.sum() * length / borne - 1) > UNBALANCED:
        raise RuntimeError(f"CalculiX's ridges carry {shares.sum() * length:.4g} N of {borne:g} N")
    if not (whole or pad.revolved):
        shares = piece_of(pad).on_whole(2 * shares)
    return PressedPad(shares * length, approach, 2 * len(mesh.nodes), seconds)


def read(printed: str, ridges: int) -> tuple[NDArray[np.float64], float]:
    """Return the ridges' forces of the last step, N per mm of length, and the approach, mm."""
    number = r"([-+.\dE]+)"
    moved = re.findall(rf"for set REFERENCE.*\n\n +\d+ +{number} +{number}", printed)
    forces = re.findall(rf"surface force .*\n\n +{number} +{number}", printed)[-ridges:]
    if len(forces) != ridges or not moved:
        raise RuntimeError("CalculiX printed no contact forces")
    return np.array([-float(upward) for _, upward in forces]), -float(moved[-1][1])


def _children() -> float:
    """Processor time of all ended child processes, s."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def run_program(command: list[str], folder: Path) -> str:
    """Return what a program prints, run in the folder on one processor; raise RuntimeError where it fails."""
    settings = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run(
        command, cwd=folder, env=settings, capture_output=True, text=True, check=False, timeout=3600
    )
    if done.returncode:
        raise RuntimeError(f"{command[0]} failed: {done.stdout[-2000:]}{done.stderr[-500:]}")
    return done.stdout


def own(pad: Pad, model: str, fineness: float, order: int) -> PressedPad:
    """Return skincad's level of a model; its time is the median of a few runs, the first left out."""
    seconds, more = [], []
    for _ in range(REPEATS):
        solver = linear.level if model == "linear" else finite_strain.level
        started, clock = process_time(), perf_counter()
        answer = solver(plane_piece(pad, fineness), order, FORCE, ())
        seconds.append(process_time() - started)
        # stages are wall times: their share of the whole is what counts
        more.append(seconds[-1] * answer.seconds.get("threshold", 0.0) / (perf_counter() - clock))
    spent = statistics.median(seconds), statistics.median(more)
    return PressedPad(answer.ridge_force, answer.approach, answer.unknowns, *spent)


def missed(found: PressedPad, reference: PressedPad) -> float:
    """Return the largest difference of shares, N."""
    return float(np.abs(found.shares - reference.shares).max())


def time_at(error: float, seconds: NDArray[np.float64], errors: NDArray[np.float64]) -> float:
    """Return the time that this error takes, log-log between the rows that no quicker row beats.

    Above the largest error it is the quickest row's: never extrapolated. Below the smallest it is nan.
    """
    order = np.argsort(seconds)
    rows = order[errors[order] <= np.minimum.accumulate(errors[order])]
    time, left = seconds[rows], errors[rows]
    if error < left[-1]:
        return float("nan")
    return float(np.exp(np.interp(-np.log(error), -np.log(left), np.log(time))))


def compare(pad: Pad, model: str, start: float | None) -> None:
    ours = {f"skincad {f:g}, {k}": own(pad, model, f, k) for f, k in LEVELS}
    theirs = {f"CalculiX {f:g}": press(pad, f, FORCE, start) for f in MESHES[model]}
    knowing = MESHES[model] if start is None else ()
    halves = {f"its half {f:g}": press(pad, f, FORCE, whole=False) for f in knowing}
    best = [*ours.values()][-1]
    print(f"\n{model}: errors against skincad's finest, and against the program's own finest")
    lines = []
    for rows in (ours, theirs, halves):
        for setting, f in rows.items():
            last = [*rows.values()][-1]
            error, own_error = ("" if f is of else f"{missed(f, of):.1e}" for of in (best, last))
            half = " ".join(f"{s:.4f}" for s in f.shares[: (f.shares.size + 1) // 2])
            off = f"{f.approach / best.approach - 1:+.1e}"
            lines.append((setting, f.unknowns, f"{f.seconds:.2f}", error, own_error, off, half))
    head = ("fineness", "unknowns", "time, s", "share, N", "own, N", "approach", "shares, N")
    print("\n".join(runner.table(head, lines)))
    ratios(model, [*ours.values()], theirs | halves)


def ratios(model: str, ours: list[PressedPad], theirs: dict[str, PressedPad]) -> None:
    """Print the times at equal error, the errors against the last of `ours`."""
    *levels, best = ours
    whole = np.array([level.seconds for level in levels])
    contact = whole - np.array([level.more for level in levels])
    errors = np.array([missed(level, best) for level in levels])
    print(f"times at equal error, CalculiX's over skincad's (goal {GOALS[model]:g})")
    for setting, found in theirs.items():
        error = missed(found, best)
        both = [found.seconds / time_at(error, time, errors) for time in (whole, contact)]
        bound = "at least " if error > errors.max() else ""
        without = f", {both[1]:.0f}x without the all-touch force" if best.more else ""
        print(f"{setting:16}  error {error:.1e} N: {bound}{both[0]:.0f}x{without}")


def main() -> None:
    if missing():
        print(missing())
        return
    pad = pad_of(load("plain-ridges"))
    own(pad, "linear", 0.25, 2)  # imports and caches
    softer = SOFTER * own(pad, "linear", 0.5, 2).approach
    compare(pad, "linear", None)
    if sys.argv[1:] == ["linear"]:
        return
    compare(pad, "finite-strain", softer)


if __name__ == "__main__":
    with threadpool_limits(limits=1, user_api="blas"):
        main()
