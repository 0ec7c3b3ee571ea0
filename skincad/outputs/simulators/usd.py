"""The skin as an OpenUSD stage with UsdPhysics: the links of MuJoCo's model, their colliders, joints and
taxels. m, kg, N, s; z is up.

All prims lie in the design's frame. Each feature, or group of pins, slides along z against a drive.
UsdPhysics couples no joints, so each drive is on its own: at the check's approach it bears the check's force.
Parts of the skin don't touch each other: one collision group is filtered against itself. A taxel is an Xform
in the body that it moves with; attributes `skincad:kind`, `skincad:side`, `skincad:normal`, `skincad:size`
(m) and `skincad:area` (m2) say what it is. Source: UsdPhysics, OpenUSD's rigid body schema (openusd.org).
"""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from skincad.base.arrays import Array
from skincad.base.errors import InputError
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.outputs.simulators.links import Links, Weight, feature_bodies
from skincad.outputs.simulators.models import KG, KG_M2, N_PER_M, STEP, M, friction
from skincad.outputs.simulators.springs import Springs
from skincad.outputs.simulators.taxels import Taxels
from skincad.solids.layout import lid_process
from skincad.solids.plan import PartRole

PACKAGE = "pxr"  # of usd-core


def installed() -> bool:
    """Return whether the library that writes stages is there."""
    return find_spec(PACKAGE) is not None


def require_usd() -> None:
    """Raise InputError where the library that writes stages is missing."""
    if not installed():
        raise InputError("kinds", "needs the package usd-core", "usd", "pip install 'skincad[usd]'")


def write_usd(
    design: Design,
    links: Links,
    springs: Springs,
    taxels: Taxels,
    surfaces: dict[str, trimesh.Trimesh],
    about: str,
    path: Path,
) -> None:
    """Write the stage, as text to a name that ends in `.usda`; `surfaces` are by name as in `Package`."""
    from pxr import Kind, Tf, Usd, UsdGeom, UsdPhysics, UsdShade

    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdPhysics.SetStageKilogramsPerUnit(stage, 1.0)
    root = UsdGeom.Xform.Define(stage, f"/{Tf.MakeValidIdentifier(design.name)}").GetPrim()
    stage.SetDefaultPrim(root)
    stage.GetRootLayer().documentation = about
    Usd.ModelAPI(root).SetKind(Kind.Tokens.component)
    UsdPhysics.ArticulationRootAPI.Apply(root)
    home = root.GetPath()
    UsdGeom.Scope.Define(stage, home.AppendChild("materials"))
    group = UsdPhysics.CollisionGroup.Define(stage, home.AppendChild("collisions"))
    group.CreateFilteredGroupsRel().AddTarget(group.GetPath())
    group.GetCollidersCollectionAPI().CreateIncludesRel().AddTarget(home)
    rubber = _material(stage, home, "silicone", PartRole.SKIN, silicone(design).density)
    for name in ("Static", "Dynamic"):
        getattr(UsdPhysics.MaterialAPI(rubber), f"Create{name}FrictionAttr")(friction(design))
    rigid = _material(stage, home, "carrier", PartRole.CARRIER, 1e3 * lid_process(design).density)
    members = feature_bodies(design)
    parts = [("carrier", links.carrier, rigid, "carrier-hull"), ("skin", links.base, rubber, "base-hull")]
    parts += [("filling", links.filling, rubber, "")] if links.filling else []
    parts += [(name, weight, rubber, name) for name, weight in zip(members, links.ridges, strict=True)]
    bodies = {}
    for name, weight, material, hull in parts:
        body = UsdGeom.Xform.Define(stage, home.AppendChild(Tf.MakeValidIdentifier(name))).GetPrim()
        UsdPhysics.RigidBodyAPI.Apply(body)
        _weigh(body, weight)
        UsdShade.MaterialBindingAPI.Apply(body).Bind(material)
        if name in ("carrier", "skin"):
            _mesh(stage, body, "visual", surfaces[name])
        if hull:
            shape = _mesh(stage, body, "collider", surfaces[hull])
            shape.CreatePurposeAttr(UsdGeom.Tokens.guide)
            UsdPhysics.CollisionAPI.Apply(shape.GetPrim())
            UsdPhysics.MeshCollisionAPI.Apply(shape.GetPrim()).CreateApproximationAttr("convexHull")
        bodies[name] = body
    stiffness = dict(zip(members, (springs.alone * N_PER_M).tolist(), strict=True))
    for name, body in list(bodies.items())[1:]:  # without the carrier
        kind = UsdPhysics.PrismaticJoint if name in members else UsdPhysics.FixedJoint
        joint = kind.Define(stage, body.GetPath().AppendChild("joint"))
        joint.CreateBody0Rel().AddTarget(bodies["carrier" if name == "skin" else "skin"].GetPath())
        joint.CreateBody1Rel().AddTarget(body.GetPath())
        if name in members:
            joint.CreateAxisAttr(UsdGeom.Tokens.z)
            drive = UsdPhysics.DriveAPI.Apply(joint.GetPrim(), "linear")
            drive.CreateStiffnessAttr(stiffness[name])
            drive.CreateDampingAttr(2 * stiffness[name] * STEP)
    _place(stage, bodies, design, taxels)
    _note(root, "Double", force=springs.force, approach=float(springs.approach) * M)
    stage.GetRootLayer().Export(str(path))


def _place(stage: Any, bodies: dict[str, Any], design: Design, taxels: Taxels) -> None:
    """Put each taxel into the body that it moves with: the end of a pocket in the base into that."""
    from pxr import Gf, Tf, UsdGeom

    of_feature = {i + 1: name for name, group in feature_bodies(design).items() for i in group}
    for i, name in enumerate(taxels.names):
        in_base = taxels.kinds[i] == "pocket" and taxels.poses[i, 2, 3] <= design.skin.thickness
        body = bodies["skin" if in_base else of_feature[taxels.ridges[i]]]
        taxel = UsdGeom.Xform.Define(stage, body.GetPath().AppendChild(Tf.MakeValidIdentifier(name)))
        pose = np.eye(4)
        pose[:3] = taxels.poses[i]
        pose[:3, 3] *= M
        taxel.AddTransformOp().Set(Gf.Matrix4d(*pose.T.ravel().tolist()))
        _note(taxel.GetPrim(), "String", kind=taxels.kinds[i], side=taxels.sides[i])
        _note(taxel.GetPrim(), "Vector3d", normal=Gf.Vec3d(*pose[:3, 2].tolist()))
        _note(taxel.GetPrim(), "Double2", size=Gf.Vec2d(*(taxels.sizes[i] * M).tolist()))
        _note(taxel.GetPrim(), "Double", area=float(taxels.areas[i]) * M**2)


def _material(stage: Any, home: Any, name: str, role: PartRole, density: float) -> Any:
    """A material by its colour and density, kg/m3."""
    from pxr import Gf, Sdf, UsdPhysics, UsdShade

    material = UsdShade.Material.Define(stage, home.AppendPath(f"materials/{name}"))
    shader = UsdShade.Shader.Define(stage, material.GetPath().AppendChild("surface"))
    shader.CreateIdAttr("UsdPreviewSurface")
    shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(*role.colour))
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    UsdPhysics.MaterialAPI.Apply(material.GetPrim()).CreateDensityAttr(density)
    return material


def _mesh(stage: Any, body: Any, name: str, surface: trimesh.Trimesh) -> Any:
    """A mesh of a body."""
    from pxr import UsdGeom, Vt

    shape = UsdGeom.Mesh.Define(stage, body.GetPath().AppendChild(name))
    points = Vt.Vec3fArray.FromNumpy((np.array(surface.vertices) * M).astype(np.float32))
    shape.CreatePointsAttr(points)
    shape.CreateExtentAttr(UsdGeom.PointBased.ComputeExtent(points))
    shape.CreateFaceVertexCountsAttr(Vt.IntArray(len(surface.faces), 3))
    shape.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(surface.faces.ravel().astype(np.int32)))
    shape.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    return shape


def _weigh(body: Any, weight: Weight) -> None:
    """Give a body its mass, centre and principal inertia."""
    from pxr import Gf, UsdPhysics

    values, axes = np.linalg.eigh(weight.inertia * KG_M2)
    axes[:, 2] *= np.sign(np.linalg.det(axes))  # right-handed
    frame: Array = np.eye(4)
    frame[:3, :3] = axes.T
    mass = UsdPhysics.MassAPI.Apply(body)
    mass.CreateMassAttr(weight.mass * KG)
    mass.CreateCenterOfMassAttr(Gf.Vec3f(*(weight.centre * M).tolist()))
    mass.CreateDiagonalInertiaAttr(Gf.Vec3f(*values.tolist()))
    mass.CreatePrincipalAxesAttr(Gf.Quatf(Gf.Matrix4d(*frame.ravel().tolist()).ExtractRotationQuat()))


def _note(prim: Any, kind: str, /, **values: Any) -> None:
    """Give a prim attributes of ours."""
    from pxr import Sdf

    for name, value in values.items():
        prim.CreateAttribute(f"skincad:{name}", getattr(Sdf.ValueTypeNames, kind)).Set(value)
