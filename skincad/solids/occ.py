"""Plans to exact solids: the one file that names the CAD kernel's classes.

Faces are swept or turned from wires directly; booleans are kept for bores. Every solid is checked twice,
by BRepCheck and by its volume against the plan's formula, because the kernel can accept a wrong result
silently.
"""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache
from typing import Literal, TypeVar

import numpy as np

from skincad.base.arrays import Array
from skincad.base.errors import FaultError, InputError, exhausted, resource_guard
from skincad.base.interrupt import safe_point
from skincad.shape import curves
from skincad.shape.curves import Loop, Segment
from skincad.solids.plan import (
    Axis,
    Body,
    Bore,
    ExtendedCut,
    GivenBody,
    Part,
    Prism,
    RevolvedBody,
    RotatedBody,
    TurnedBody,
    unturned,
)
from skincad.solids.projection import Arc, Polyline, Projection, Stroke, View, distinct

NO_LIBRARY = "cannot open shared object file"  # the dynamic linker's words for a library that is missing
try:
    import cadquery as cq
    from OCP.BRepAdaptor import BRepAdaptor_Curve, BRepAdaptor_Surface
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut, BRepAlgoAPI_Fuse
    from OCP.BRepBuilderAPI import (
        BRepBuilderAPI_MakeEdge,
        BRepBuilderAPI_MakeFace,
        BRepBuilderAPI_MakePolygon,
        BRepBuilderAPI_MakeWire,
        BRepBuilderAPI_Transform,
    )
    from OCP.BRepCheck import BRepCheck_Analyzer
    from OCP.BRepGProp import BRepGProp
    from OCP.BRepLib import BRepLib
    from OCP.BRepMesh import BRepMesh_IncrementalMesh
    from OCP.BRepPrimAPI import (
        BRepPrimAPI_MakeCone,
        BRepPrimAPI_MakeCylinder,
        BRepPrimAPI_MakePrism,
        BRepPrimAPI_MakeRevol,
    )
    from OCP.BRepTools import BRepTools
    from OCP.Geom import Geom_BezierCurve
    from OCP.GeomAbs import GeomAbs_Circle, GeomAbs_Cone, GeomAbs_Cylinder, GeomAbs_Line
    from OCP.gp import gp_Ax1, gp_Ax2, gp_Circ, gp_Dir, gp_Pln, gp_Pnt, gp_Trsf, gp_Vec
    from OCP.GProp import GProp_GProps
    from OCP.HLRAlgo import HLRAlgo_Projector
    from OCP.HLRBRep import HLRBRep_Algo, HLRBRep_HLRToShape
    from OCP.IFSelect import IFSelect_RetDone
    from OCP.Message import Message, Message_PrinterOStream
    from OCP.STEPControl import STEPControl_Controller, STEPControl_Reader
    from OCP.TColgp import TColgp_Array1OfPnt
    from OCP.TopAbs import TopAbs_EDGE, TopAbs_REVERSED, TopAbs_SOLID
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopLoc import TopLoc_Location
    from OCP.TopoDS import TopoDS, TopoDS_Face, TopoDS_Shape, TopoDS_Solid, TopoDS_Wire
    from OCP.TopTools import TopTools_ListOfShape
except ImportError as failure:
    if NO_LIBRARY not in str(failure):
        raise
    raise InputError(  # a bare Linux has no libGL and libX11
        "the CAD kernel",
        f"cannot be loaded ({failure})",
        remedy="on Debian or Ubuntu: apt-get install libgl1 libx11-6",
    ) from failure

KERNEL_TOLERANCE = 1e-7  # mm, source: OCCT's Precision::Confusion; an arc that rises less is a line to it
ANGLE = 10.0  # rad, between a mesh's chords: no limit, so that the tolerance alone counts
CHORDS = 16  # of a projected edge that is neither line nor circle: an ellipse's within 1 % of its radius
ROUNDING = 1e-12  # mm, of points: some hundred times the last digit of 10 mm
VOLUME_TOLERANCE = 1e-9  # relative, of the kernel's integral over a solid


class KernelError(FaultError):
    """The CAD kernel's solid is not valid, its volume is not the plan's, or the kernel failed."""


def _load_messages() -> None:
    """Have the kernel take its own STEP messages now: it looks for `XSTEP.us` in the working directory, and a
    file of that name which is not its own ends every STEP file later.
    """
    names = ("CSF_XSMessage", "CSF_SHMessage")
    before = {name: os.environ.get(name) for name in names}
    os.environ.update(dict.fromkeys(names, os.devnull))  # no folder: what is built in counts
    STEPControl_Controller.Init_s()
    for name, value in before.items():
        if value is None:
            del os.environ[name]
        else:
            os.environ[name] = value


_load_messages()
# a STEP file that it can't read is refused in a line of ours: the kernel's own would go to stdout
Message.DefaultMessenger_s().RemovePrinters(Message_PrinterOStream.get_type_descriptor_s())


def solid(part: Part) -> cq.Solid:
    """Return the part's exact solid, mm. Raises KernelError unless it is one valid solid of its volume, and
    ExhaustedError where memory does not suffice.
    """
    with resource_guard(f"the solid of {part.name}"):
        try:
            return _checked_solid(part)
        except Exception as failure:
            kind = type(failure)  # the kernel's errors have no class in common
            if not kind.__module__.startswith("OCP.") or exhausted(failure):
                raise
            words = f"{part.name}: the CAD kernel failed ({kind.__name__}: {failure})"
            raise KernelError(words) from failure


def _checked_solid(part: Part) -> cq.Solid:
    safe_point()
    if isinstance(part.body, RotatedBody):
        return cq.Solid(_only_solid(_turned(_checked_solid(unturned(part)).wrapped, part.body), part.name))
    part = replace(
        part,
        body=flattened(part.body),
        cuts=tuple(flattened(cut) for cut in part.cuts),
        adds=tuple(flattened(body) for body in part.adds),
    )
    result = unchecked_solid(part)
    if not BRepCheck_Analyzer(result.wrapped).IsValid():
        raise KernelError(f"{part.name}: BRepCheck finds the solid not valid")
    error = abs(volume(part, result) - part.volume)
    # the kernel takes points within its tolerance of a face as on it, so the edges that a cut makes, and the
    # faces up to them, may be off by as much
    cutting = KERNEL_TOLERANCE * float(result.Area()) if part.cuts or part.adds else 0.0
    if not error <= VOLUME_TOLERANCE * part.volume + rounding_error(part.body) + cutting:
        raise KernelError(f"{part.name}: volume differs from its formula by {error / part.volume:.1e} of it")
    return result


def volume(part: Part, shape: cq.Solid) -> float:
    """Return a solid's volume by the kernel, mm3.

    Where a bore or a pin meets a curved face the kernel's usual integration misses 1e-4 mm3 of it: there it
    is asked to refine until it estimates its error within `VOLUME_TOLERANCE`.
    """
    if not _on_curved(part):
        return float(shape.Volume())
    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape.wrapped, properties, VOLUME_TOLERANCE, False, False)
    return float(properties.Mass())


def _on_curved(part: Part) -> bool:
    """Whether a bore or a pin of a part meets a curved face."""
    if isinstance(part.body, RevolvedBody) and any(isinstance(cut, ExtendedCut) for cut in part.cuts):
        return True
    return any(
        bool(body.within)
        if isinstance(body, Bore)
        else isinstance(body, TurnedBody | RevolvedBody) and body.buried != 0.0
        for body in (*part.cuts, *part.adds)
    )


def moments(part: Part, shape: cq.Solid) -> tuple[Array, Array]:
    """Return a solid's centre `(3,)` mm and its inertia about it `(3, 3)` mm5, that of density 1 per mm3."""
    properties = GProp_GProps()
    if _on_curved(part):  # as in `volume`
        BRepGProp.VolumeProperties_s(shape.wrapped, properties, VOLUME_TOLERANCE, False, False)
    else:
        BRepGProp.VolumeProperties_s(shape.wrapped, properties)
    centre, matrix = properties.CentreOfMass(), properties.MatrixOfInertia()
    inertia = [[matrix.Value(i, j) for j in (1, 2, 3)] for i in (1, 2, 3)]
    return np.array([centre.X(), centre.Y(), centre.Z()]), np.array(inertia)


def unchecked_solid(part: Part) -> cq.Solid:
    """Return the part's solid as the kernel made it: right for a valid plan, but nobody has looked."""
    shape = _body(part.body)
    if part.adds:
        shape = _operated(BRepAlgoAPI_Fuse(), shape, [_body(body) for body in part.adds])
    if part.cuts:
        shape = _operated(BRepAlgoAPI_Cut(), shape, [_body(cut) for cut in part.cuts])
    return cq.Solid(_only_solid(shape, part.name))


def workplane(part: Part) -> cq.Workplane:
    """Return the part's exact solid on a cadquery workplane, named by the part."""
    return cq.Workplane("XY").newObject([solid(part)])


def tessellate(shape: cq.Solid, tolerance: float) -> None:
    """Give a solid a mesh whose chords keep within `tolerance` mm, absolute; none that it has is reused."""
    BRepTools.Clean_s(shape.wrapped)
    BRepMesh_IncrementalMesh(shape.wrapped, tolerance, False, ANGLE)


def triangles(shape: cq.Solid, tolerance: float) -> tuple[list[cq.Vector], list[tuple[int, int, int]]]:
    """Return corners, mm, and triangles of the mesh that `tessellate` gave; faces share no corners."""
    corners, faces = shape.tessellate(tolerance, ANGLE)
    return corners, faces


def projection(shape: cq.Solid, view: View) -> Projection:
    """Return a solid's edges as they are seen in a view, and those that lie behind: sharp edges and outlines
    of what is round; where two faces meet smoothly is no edge."""
    algorithm = HLRBRep_Algo()
    algorithm.Add(shape.wrapped)
    frame = gp_Ax2(gp_Pnt(*view.origin), gp_Dir(*view.towards), gp_Dir(*view.right))
    algorithm.Projector(HLRAlgo_Projector(frame))
    algorithm.Update()
    algorithm.Hide()
    edges = HLRBRep_HLRToShape(algorithm)
    visible = distinct([*_strokes(edges.VCompound()), *_strokes(edges.OutLineVCompound())])
    hidden = distinct([*_strokes(edges.HCompound()), *_strokes(edges.OutLineHCompound())])
    seen = {stroke.key() for stroke in visible}
    return Projection(tuple(visible), tuple(s for s in hidden if s.key() not in seen))


def _strokes(edges: TopoDS_Shape | None) -> list[Stroke]:
    """The edges of a projection, in its own plane, as plain data."""
    if edges is None or edges.IsNull():
        return []
    BRepLib.BuildCurves3d_s(edges)
    strokes, explorer = [], TopExp_Explorer(edges, TopAbs_EDGE)
    while explorer.More():
        strokes.append(_stroke(BRepAdaptor_Curve(TopoDS.Edge_s(explorer.Current()))))
        explorer.Next()
    return strokes


def _stroke(curve: BRepAdaptor_Curve) -> Stroke:
    low, high, kind = curve.FirstParameter(), curve.LastParameter(), curve.GetType()
    if kind == GeomAbs_Circle:
        circle = curve.Circle()
        centre, turns = circle.Location(), math.copysign(1.0, circle.Axis().Direction().Z())
        start = curve.Value(low if turns > 0 else high)
        angle = math.atan2(start.Y() - centre.Y(), start.X() - centre.X())
        return Arc((centre.X(), centre.Y()), circle.Radius(), angle, high - low)
    count = 1 if kind == GeomAbs_Line else CHORDS
    points = [curve.Value(low + (high - low) * i / count) for i in range(count + 1)]
    return Polyline(tuple((p.X(), p.Y()) for p in points)).straightened(KERNEL_TOLERANCE)


_Body = TypeVar("_Body", bound=Body)
Turns = Literal["x", "z"] | None  # the axis about which a wire is turned


def flattened(body: _Body) -> _Body:
    """Replace arcs that rise by less than the kernel's tolerance by lines: their ends would be its middle."""
    if isinstance(body, ExtendedCut):
        return replace(body, counts=flattened(body.counts), built=flattened(body.built))
    if isinstance(body, RotatedBody):
        return replace(body, body=flattened(body.body))
    if not isinstance(body, Prism | RevolvedBody | TurnedBody):
        return body
    lines = tuple(replace(s, bulge=0.0) if _rise(s) < KERNEL_TOLERANCE else s for s in body.outline)
    return replace(body, outline=lines)


def _rise(segment: Segment) -> float:
    return abs(segment.bulge) * segment.chord / 2


def rounding_error(body: Body) -> float:
    """Volume, mm3, by which a swept body may be off because a far centre is stored with 16 digits."""
    if not isinstance(body, Prism | RevolvedBody | TurnedBody):
        return 0.0
    arcs = math.fsum(s.length * s.radius for s in body.outline if s.bulge)
    if isinstance(body, TurnedBody):
        return 4 * sys.float_info.epsilon * arcs * 2 * math.pi * max(s.start.x for s in body.outline)
    path = body.high - body.low
    if isinstance(body, RevolvedBody):
        far = abs(body.centre)
        arcs, path = arcs + far * curves.length(body.outline), path * far
    return 4 * sys.float_info.epsilon * arcs * path


def _point(x: float, y: float, axis: Axis, level: float) -> gp_Pnt:
    return gp_Pnt(*_spread(x, y, axis, level))


def _spread(x: float, y: float, axis: Axis, level: float = 0.0) -> tuple[float, float, float]:
    """Coordinates of a loop's plane and along its axis, in the mold's frame."""
    return {"x": (level, x, y), "y": (x, level, y), "z": (x, y, level)}[axis]


def given_solid(body: GivenBody, key: str) -> cq.Solid:
    """Return the solid of a user's STEP file in its pose, mm. Raises InputError, by `key`, for a file that
    can't be read, and for one without a solid or with several."""
    return cq.Solid(_placed(_read(body.file, body.stamp, key), body))


@lru_cache(maxsize=4)
def _read(path: str, _stamp: tuple[int, int], key: str) -> TopoDS_Solid:
    """The file's only solid; by its stamp a changed file is read again."""
    name = path.replace("\\", "/").rpartition("/")[2]
    reader = STEPControl_Reader()
    if reader.ReadFile(path) != IFSelect_RetDone or not reader.TransferRoots():
        raise InputError(
            key, "is no STEP file that the CAD kernel reads", name, "export it as STEP AP214, in mm"
        )
    solids, explorer = [], TopExp_Explorer(reader.OneShape(), TopAbs_SOLID)
    while explorer.More():
        solids.append(TopoDS.Solid_s(explorer.Current()))
        explorer.Next()
    if len(solids) != 1:
        remedy = "export the solid, not its faces" if not solids else "export one body, or unite them"
        raise InputError(key, f"must hold one solid, and holds {len(solids)}", name, remedy)
    if not BRepCheck_Analyzer(solids[0]).IsValid():
        raise InputError(key, "holds a solid that is not valid", name, "repair it in your CAD program")
    return solids[0]


def _placed(shape: TopoDS_Shape, body: GivenBody) -> TopoDS_Shape:
    move = gp_Trsf()
    move.SetValues(*body.pose)
    return BRepBuilderAPI_Transform(shape, move, True).Shape()


def volume_in_front(shape: cq.Solid, radius: float = math.inf) -> float:
    """Return the volume of a solid at z > 0, mm3, or outside the cylinder of a radius, mm, with its axis
    along x and its summit at z = 0."""
    box = shape.BoundingBox()
    if math.isfinite(radius):
        long = box.xmax - box.xmin + 2.0
        back = cq.Solid.makeCylinder(
            radius, long, cq.Vector(box.xmin - 1.0, 0.0, -radius), cq.Vector(1, 0, 0)
        )
        wide = 4 * (radius + abs(box.ymin) + abs(box.ymax))
        over = cq.Solid.makeBox(long, wide, wide, cq.Vector(box.xmin - 1.0, -wide / 2, -radius))
        return float(shape.intersect(over).cut(back).Volume())
    if box.zmax <= 0:
        return 0.0
    if box.zmin >= 0:
        return float(shape.Volume())
    side = 4 * max(abs(v) for v in (box.xmin, box.xmax, box.ymin, box.ymax, box.zmax)) + 1
    room = cq.Solid.makeBox(side, side, side, cq.Vector(-side / 2, -side / 2, 0.0))
    return float(shape.intersect(room).Volume())


Hole = tuple[float, tuple[float, float, float], float]


def holes_of(shape: cq.Solid, deepest: float) -> tuple[Hole, ...]:
    """Return the round holes along z, each as radius, lowest place of its axis and highest z, mm. A hole is a
    cylinder's face whose normal points at its axis; a chamfer of up to `deepest` mm at its lower end belongs
    to it."""
    upright = dict[tuple[float, float, float], list[float]]()
    chamfers = list[tuple[float, float, float, float]]()
    for surface, is_cone, axis, box in _bored_faces(shape):
        way, place = axis.Direction(), axis.Location()
        if math.hypot(way.X(), way.Y()) >= 1e-6:
            continue
        x, y = round(place.X(), 6), round(place.Y(), 6)
        if is_cone:
            chamfers.append((x, y, box.zmin, box.zmax))
            continue
        row = upright.setdefault((round(surface.Cylinder().Radius(), 6), x, y), [math.inf, -math.inf])
        row[:] = [min(row[0], box.zmin), max(row[1], box.zmax)]
    for (_, x, y), row in upright.items():
        under = (low for u, v, low, high in chamfers if (u, v) == (x, y) and abs(high - row[0]) < 1e-4)
        row[0] = next((low for low in under if row[0] - low <= deepest), row[0])
    return tuple((radius, (x, y, low), high) for (radius, x, y), (low, high) in upright.items())


def _bored_faces(shape: cq.Solid) -> Iterator[tuple[BRepAdaptor_Surface, bool, gp_Ax1, cq.BoundBox]]:
    """The faces of round holes, cylinders or cones, with their axis and their box."""
    for face in shape.Faces():
        surface = BRepAdaptor_Surface(face.wrapped)
        kind = surface.GetType()
        if kind in (GeomAbs_Cylinder, GeomAbs_Cone) and face.wrapped.Orientation() == TopAbs_REVERSED:
            cone = kind == GeomAbs_Cone
            yield surface, cone, (surface.Cone() if cone else surface.Cylinder()).Axis(), face.BoundingBox()


def locks_of(shape: cq.Solid) -> tuple[tuple[float, tuple[float, float] | None], ...]:
    """Return the necks of the holes in front of the back (z > 0) that no straight pull along z empties, as
    areas, mm2, and places of those along z: holes across, and holes along z with a wider part nearer to the
    back than a narrower one, countersunk or stepped."""
    across = dict[tuple[float, ...], float]()  # a hole may be in several faces of one cylinder
    along = dict[tuple[float, float], list[tuple[float, float]]]()
    for surface, is_cone, axis, box in _bored_faces(shape):
        way, place = axis.Direction(), axis.Location()
        if math.hypot(way.X(), way.Y()) < 1e-6:
            ends = (surface.Value(0.0, v) for v in (surface.FirstVParameter(), surface.LastVParameter()))
            rims = [(p.Z(), math.hypot(p.X() - place.X(), p.Y() - place.Y())) for p in ends]
            along.setdefault((round(place.X(), 6), round(place.Y(), 6)), []).extend(rims)
        elif box.zmin > 0.0 and not is_cone and abs(way.Z()) < _STEEP:
            radius = surface.Cylinder().Radius()
            line = (place.X(), place.Y(), place.Z(), way.X(), way.Y(), way.Z(), radius)
            across[tuple(round(v, 6) for v in line)] = math.pi * radius**2
    necks = list[tuple[float, tuple[float, float] | None]]()
    for spot, rims in along.items():
        inside = [(z, r) for z, r in rims if z > -1e-6]
        narrow = [r for z, r in inside if any(low < z - 1e-6 and wide > r + _LIP for low, wide in inside)]
        if narrow:
            necks.append((math.pi * min(narrow) ** 2, spot))
    return (*((area, None) for area in across.values()), *necks)


_STEEP = math.cos(math.radians(45.0))  # a hole at less than 45 degrees to the back counts as across
_LIP = 0.1  # mm, assumption: by which a hole is wider, so that silicone is held behind it


def _body(body: Body) -> TopoDS_Shape:  # one a kind
    if isinstance(body, GivenBody):
        return _placed(_read(body.file, body.stamp, "mold.bone"), body)
    if isinstance(body, ExtendedCut):
        return _body(_tool_body(body))
    if isinstance(body, RotatedBody):
        return _turned(_body(body.body), body)
    if isinstance(body, TurnedBody):
        return _turned_about(body)
    if isinstance(body, Prism | RevolvedBody):
        return _prism(body) if isinstance(body, Prism) else _revolved(body)
    return _round(body)


def _round(body: Bore) -> TopoDS_Shape:
    direction = gp_Dir(0, 1, 0) if body.axis == "y" else gp_Dir(0, 0, 1)
    place = gp_Ax2(gp_Pnt(*body.start), direction)
    if body.end_radius is None:
        return BRepPrimAPI_MakeCylinder(place, body.radius, body.length).Shape()
    return BRepPrimAPI_MakeCone(place, body.radius, body.end_radius, body.length).Shape()


def _tool_body(cut: ExtendedCut) -> Prism | RevolvedBody | Bore | RotatedBody:
    """Return the tool of a cut: a turned section ends in the planes in which its part ends.

    There the tool's edges are the section's, exact. If the tool were longer, the kernel would have to compute
    where the plane meets each turned face. It has no formula for cones of a half angle below 0.02 or above
    1.55 rad, as flat crowns and steep flanks make: it walks along them in steps, and volumes are off by up to
    1e-6. Source: OCCT 7.9, IntPatch_Intersection.
    """
    if isinstance(cut.built, RevolvedBody) and isinstance(cut.counts, RevolvedBody):
        return replace(cut.built, low=cut.counts.low, high=cut.counts.high)
    return cut.built


def _turned(shape: TopoDS_Shape, place: RotatedBody) -> TopoDS_Shape:
    turn, shift = place.placement()
    motion = gp_Trsf()
    motion.SetValues(*(float(v) for row, d in zip(turn, shift, strict=True) for v in (*row, d)))
    return BRepBuilderAPI_Transform(shape, motion, True).Shape()


def _prism(prism: Prism) -> TopoDS_Shape:
    """Sweep the face against its normal, which makes a solid of positive volume."""
    axis, size = prism.axis, prism.high - prism.low
    start, sweep = (prism.low, size) if axis == "y" else (prism.high, -size)
    normal = gp_Dir(*_spread(0, 0, axis, -1 if axis == "y" else 1))
    plane = gp_Pln(_point(0.0, 0.0, axis, start), normal)  # given, because finding it takes half the time
    face = _face(prism, plane, axis, start)
    along = gp_Vec(*_spread(0, 0, axis, sweep))
    return BRepPrimAPI_MakePrism(face, along).Shape()


def _revolved(body: RevolvedBody) -> TopoDS_Shape:
    """Turn the face from its low end to its high one, against its normal as in a prism."""
    side = 1.0 if body.outline[0].start.z > body.centre else -1.0  # of the axis, on which the loop lies
    axis = gp_Ax1(gp_Pnt(0.0, 0.0, body.centre), gp_Dir(-side, 0.0, 0.0))  # about it +y comes after y = 0
    face = _face(body, gp_Pln(gp_Pnt(0.0, 0.0, 0.0), gp_Dir(0, -1, 0)), "y", 0.0)
    start = gp_Trsf()
    start.SetRotation(axis, body.low)
    placed = BRepBuilderAPI_Transform(face, start, True).Shape()
    turned = BRepPrimAPI_MakeRevol(placed, axis, body.high - body.low)
    if not turned.IsDone():
        raise KernelError("a revolved section cannot be built; it may cross its axis")
    return turned.Shape()


def _turned_about(body: TurnedBody) -> TopoDS_Shape:
    """A full turn about z, then moved to its axis; equal ones share what they are."""
    turn, motion = body.frame(), gp_Trsf()
    motion.SetValues(*(float(v) for row, d in zip(turn, body.origin, strict=True) for v in (*row, d)))
    return _whole_turn(body.outline).Moved(TopLoc_Location(motion))


@lru_cache(maxsize=8)
def _whole_turn(outline: Loop) -> TopoDS_Shape:
    plane = gp_Pln(gp_Pnt(0.0, 0.0, 0.0), gp_Dir(0, -1, 0))
    face = BRepBuilderAPI_MakeFace(plane, _wire(outline, "y", 0.0, "z"), False).Face()
    turned = BRepPrimAPI_MakeRevol(face, gp_Ax1(gp_Pnt(0.0, 0.0, 0.0), gp_Dir(0, 0, 1)))
    if not turned.IsDone():
        raise KernelError("a loop cannot be turned; it may cross its axis")
    return turned.Shape()


def _face(body: Prism | RevolvedBody, plane: gp_Pln, axis: Axis, level: float) -> TopoDS_Face:
    turns: Turns = "x" if isinstance(body, RevolvedBody) else None
    face = BRepBuilderAPI_MakeFace(plane, _wire(body.outline, axis, level, turns), False)
    for hole in body.holes:
        face.Add(TopoDS.Wire_s(_wire(hole, axis, level, turns).Reversed()))
    return face.Face()


def _wire(outline: Loop, axis: Axis, level: float, turns: Turns) -> TopoDS_Wire:
    if all(segment.bulge == 0.0 for segment in outline) and not turns:
        polygon = BRepBuilderAPI_MakePolygon()
        for segment in outline:
            polygon.Add(_point(segment.start.x, segment.start.z, axis, level))
        polygon.Close()
        return polygon.Wire()
    wire = BRepBuilderAPI_MakeWire()
    for segment in outline:
        wire.Add(_edge(segment, axis, level, turns))
    if not wire.IsDone():
        raise KernelError(f"a wire of {len(outline)} edges cannot be built (error {wire.Error()})")
    return wire.Wire()


def _edge(segment: Segment, axis: Axis, level: float, turns: Turns) -> object:
    start = _point(segment.start.x, segment.start.z, axis, level)
    end = _point(segment.end.x, segment.end.z, axis, level)
    if segment.bulge == 0.0:
        if turns and _straightened(segment, turns):
            return BRepBuilderAPI_MakeEdge(Geom_BezierCurve(_poles(start, end))).Edge()
        return BRepBuilderAPI_MakeEdge(start, end).Edge()
    towards = math.copysign(1.0, segment.bulge)  # from the arc's middle to its centre: left of the chord
    chord, radius = segment.chord, segment.radius
    x = -(segment.end.z - segment.start.z) / chord * towards
    y = (segment.end.x - segment.start.x) / chord * towards
    reach = radius - abs(segment.bulge) * chord / 2  # from the chord's middle
    middle_x, middle_y = (segment.start.x + segment.end.x) / 2, (segment.start.z + segment.end.z) / 2
    centre = _point(middle_x + reach * x, middle_y + reach * y, axis, level)
    # A loop in (x, z) turns clockwise about +y. Angles count from behind the centre, so that no arc comes
    # near the seam at 0, where the kernel rounds an angle to its tolerance.
    up = gp_Dir(*_spread(0, 0, axis, -towards if axis == "y" else towards))
    behind = gp_Dir(*_spread(x, y, axis))
    circle = gp_Circ(gp_Ax2(centre, up, behind), radius)
    return BRepBuilderAPI_MakeEdge(circle, start, end).Edge()


def _straightened(line: Segment, axis: Literal["x", "z"]) -> bool:
    """Whether the kernel would turn this line into a cylinder or a plane although it is neither parallel nor
    square to the axis: it does where length and projection differ by its tolerance, 1e-4 mm aside on 0.05 mm,
    and where the projection is no longer than that. A curve is taken as it is.
    """
    rise, along = line.end.z - line.start.z, abs(line.end.x - line.start.x)
    if axis == "z":
        rise, along = along, abs(rise)
    level = rise != 0.0 and rise * rise / (line.chord + along) <= 2 * KERNEL_TOLERANCE
    return level or ROUNDING < along <= 2 * KERNEL_TOLERANCE


def _poles(start: gp_Pnt, end: gp_Pnt) -> TColgp_Array1OfPnt:
    poles = TColgp_Array1OfPnt(1, 2)
    poles.SetValue(1, start)
    poles.SetValue(2, end)
    return poles


def _operated(
    operation: BRepAlgoAPI_Cut | BRepAlgoAPI_Fuse, shape: TopoDS_Shape, tools: list[TopoDS_Shape]
) -> TopoDS_Shape:
    """The shape with all tools cut from it or joined to it at once."""
    objects, others = TopTools_ListOfShape(), TopTools_ListOfShape()
    objects.Append(shape)
    for tool in tools:
        others.Append(tool)
    operation.SetArguments(objects)
    operation.SetTools(others)
    operation.Build()
    if not operation.IsDone():
        raise KernelError("a boolean of two solids failed")
    return operation.Shape()


def _only_solid(shape: TopoDS_Shape, name: str) -> TopoDS_Solid:
    solids = TopExp_Explorer(shape, TopAbs_SOLID)
    if not solids.More():
        raise KernelError(f"{name}: the kernel returned no solid")
    first = TopoDS.Solid_s(solids.Current())
    solids.Next()
    if solids.More():
        raise KernelError(f"{name}: the kernel returned more than one solid")
    return first
