"""The OpenUSD stage of each family: the library's own validators, and the numbers of the other files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

import skincad
from skincad.base import InputError
from skincad.outputs import Package
from skincad.outputs.simulators import springs as room
from skincad.outputs.simulators.package import card, markdown
from tests.refusals import refused_command

pxr = pytest.importorskip("pxr", reason="USD is not read: pip install usd-core")
from pxr import Sdf, Usd, UsdGeom, UsdPhysics, UsdShade, UsdValidation  # noqa: E402

SINGLE = 2e-7  # relative: a stage's points, masses and axes have single precision
FAMILIES = {
    "ridge": ("yamada-2002", ("ridge.count=3", "skin.width=5")),
    "flat": ("flat-magnet", ()),
    "pin": ("pillars-9", ()),
    "ring": ("rings-5", ()),
    "doubly curved": ("yamada-2002", ("ridge.count=3", "skin.width=5", "skin.curvature_radius_y=100")),
    "groups of pins": ("nibs-fine", ()),
}
SUBJECTS = {"ring": "rings-5", "doubly curved": "packages: doubly curved", "groups of pins": "nibs-fine"}


def marks(name: str) -> list[pytest.MarkDecorator]:
    return [pytest.mark.evidence(subject=SUBJECTS[name]) if name in SUBJECTS else pytest.mark.slow]


class Written:
    """A package for USD and its stage."""

    def __init__(self, package: Package, folder: Path) -> None:
        self.package, self.path = package, folder / "skin.usda"
        skincad.write(package, folder)
        self.stage = Usd.Stage.Open(str(self.path))
        self.root = self.stage.GetDefaultPrim()
        self.bodies = [p for p in self.root.GetChildren() if p.HasAPI(UsdPhysics.RigidBodyAPI)]

    def prim(self, path: str) -> Any:
        return self.stage.GetPrimAtPath(self.root.GetPath().AppendPath(path))

    def hull(self, body: Any) -> trimesh.Trimesh:
        return read(body.GetChild("collider"))


def read(prim: Any) -> trimesh.Trimesh:
    """A stage's mesh, mm."""
    mesh = UsdGeom.Mesh(prim)
    corners = 1e3 * np.array(mesh.GetPointsAttr().Get(), dtype=float)
    return trimesh.Trimesh(corners, np.reshape(mesh.GetFaceVertexIndicesAttr().Get(), (-1, 3)), process=False)


def failures(stage: Any) -> list[str]:
    """What every validator of the library says of a stage."""
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    found = UsdValidation.ValidationContext(validators).Validate(stage)
    return [f"{error.GetName()}: {error.GetMessage()}" for error in found]


@pytest.fixture(scope="module", params=[pytest.param(name, marks=marks(name)) for name in FAMILIES])
def written(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Written:
    name, settings = FAMILIES[request.param]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(room, "SPANS", ())  # a stage has the springs at one load
        package = skincad.package(skincad.load_design(name, settings), "usd")
    return Written(package, tmp_path_factory.mktemp("usd"))


def test_the_librarys_own_validators_find_nothing(written: Written) -> None:
    assert failures(written.stage) == []
    assert UsdGeom.GetStageMetersPerUnit(written.stage) == 1.0
    assert UsdGeom.GetStageUpAxis(written.stage) == "Z"
    assert UsdPhysics.GetStageKilogramsPerUnit(written.stage) == 1.0


def test_the_validators_do_find(written: Written) -> None:
    """An axis that is missing, a joint of nothing, and a binding without its schema."""
    layer = Sdf.Layer.CreateAnonymous(".usda")
    layer.TransferContent(written.stage.GetRootLayer())
    stage = Usd.Stage.Open(layer)
    stage.ClearMetadata("upAxis")
    skin = stage.GetPrimAtPath(written.prim("skin").GetPath())
    UsdPhysics.Joint(skin.GetChild("joint")).GetBody1Rel().SetTargets(["/nowhere"])
    skin.RemoveAPI(UsdShade.MaterialBindingAPI)
    names = {error.partition(":")[0] for error in failures(stage)}
    assert names == {"MissingUpAxisMetadata", "JointInvalidPrimRel", "MissingMaterialBindingAPI"}


def test_the_card_is_of_what_the_stage_holds(written: Written) -> None:
    """Its springs are the drives, none coupled; nothing is said of MuJoCo."""
    words, springs = markdown(written.package), card(written.package)["springs"]
    assert springs["coupled"] is False
    drives = np.diag(written.package.springs.alone)
    assert np.array(springs["stiffness_N_per_mm"]) == pytest.approx(drives, rel=1e-9)
    assert "USD's drives against checks" in words
    assert "MuJoCo" not in words
    assert "creeps" not in words


def test_shapes_are_those_of_the_other_files(written: Written) -> None:
    package, surfaces = written.package, written.package.surfaces
    for name in ("carrier", "skin"):
        mesh, other = read(written.prim(f"{name}/visual")), surfaces[name]
        assert mesh.is_watertight
        assert mesh.volume == pytest.approx(other.volume, rel=20 * SINGLE)
        assert mesh.bounds == pytest.approx(other.bounds, abs=SINGLE * np.abs(other.bounds).max())
    exact = package.weighs.skin.mass / skincad.inputs.material.silicone(package.design).density * 1e6
    assert read(written.prim("skin/visual")).volume == pytest.approx(exact, rel=5e-3)  # chords
    hulls = {"carrier": "carrier-hull", "skin": "base-hull"}
    for body in written.bodies:
        if body.GetName() != "filling":
            other = surfaces[hulls.get(body.GetName(), body.GetName().replace("_", "-"))]
            assert written.hull(body).volume == pytest.approx(other.volume, rel=100 * SINGLE)
            shape = UsdPhysics.MeshCollisionAPI(body.GetChild("collider"))
            assert shape.GetApproximationAttr().Get() == "convexHull"


def test_mass_centre_and_inertia_are_those_of_the_links(written: Written) -> None:
    """All bodies together, about the origin."""
    weighs, mass, first, second = written.package.weighs, 0.0, np.zeros(3), np.zeros((3, 3))
    for body in written.bodies:
        has = UsdPhysics.MassAPI(body)
        m, at = has.GetMassAttr().Get() * 1e3, 1e3 * np.array(has.GetCenterOfMassAttr().Get(), dtype=float)
        axes = has.GetPrincipalAxesAttr().Get()
        turn = trimesh.transformations.quaternion_matrix([axes.GetReal(), *axes.GetImaginary()])[:3, :3]
        inertia = turn @ np.diag(np.array(has.GetDiagonalInertiaAttr().Get(), dtype=float)) @ turn.T * 1e9
        mass, first = mass + m, first + m * at
        second += inertia + m * (at @ at * np.eye(3) - np.outer(at, at))
    assert mass == pytest.approx(weighs.mass, rel=SINGLE)
    links = [weighs.carrier, weighs.skin, *([weighs.filling] if weighs.filling else [])]
    assert first == pytest.approx(sum(w.mass * w.centre for w in links), abs=20 * SINGLE * mass * 10)
    whole = sum(
        w.inertia + w.mass * (w.centre @ w.centre * np.eye(3) - np.outer(w.centre, w.centre)) for w in links
    )
    assert second == pytest.approx(whole, abs=20 * SINGLE * np.abs(whole).max())


def test_drives_bear_the_checks_forces_at_its_approach(written: Written) -> None:
    """A level plate pressed by hand: each drive gives way by what its collider's top stands above the plate.
    1 %: the colliders' chords, of the approach."""
    springs = written.package.springs
    features = [b for b in written.bodies if b.GetName() not in ("carrier", "skin", "filling")]
    tops = np.array([written.hull(body).bounds[1, 2] for body in features])
    joints = [body.GetChild("joint") for body in features]
    assert all(UsdPhysics.PrismaticJoint(joint).GetAxisAttr().Get() == "Z" for joint in joints)
    drives = [UsdPhysics.DriveAPI(joint, "linear") for joint in joints]
    stiffness = np.array([drive.GetStiffnessAttr().Get() for drive in drives]) / 1e3  # N/mm
    assert all(drive.GetDampingAttr().Get() > 0 for drive in drives)
    down = np.maximum(tops - (tops.max() - float(springs.approach)), 0.0)
    loaded = springs.body_force > 0.01 * springs.force / len(features)
    assert (stiffness * down)[loaded] == pytest.approx(
        springs.body_force[loaded], rel=0.01, abs=0.01 * springs.force / len(features)
    )
    assert (stiffness * down).sum() == pytest.approx(springs.force, rel=0.01)
    assert written.root.GetAttribute("skincad:force").Get() == springs.force


def test_taxels_are_where_the_csv_has_them(written: Written) -> None:
    places, cache = written.package.taxels, UsdGeom.XformCache()
    prims = {p.GetName(): p for p in written.stage.Traverse() if p.HasAttribute("skincad:kind")}
    assert {*prims} == {name.replace("-", "_") for name in places.names}
    for i, name in enumerate(places.names):
        prim = prims[name.replace("-", "_")]
        pose = np.array(cache.GetLocalToWorldTransform(prim)).T
        assert pose[:3, :3] == pytest.approx(places.poses[i, :, :3])
        assert pose[:3, 3] * 1e3 == pytest.approx(places.poses[i, :, 3])
        assert np.array(prim.GetAttribute("skincad:normal").Get()) == pytest.approx(places.poses[i, :, 2])
        assert prim.GetAttribute("skincad:area").Get() * 1e6 == pytest.approx(places.areas[i])
        assert prim.GetAttribute("skincad:kind").Get() == places.kinds[i]
    moves = prims[f"{places.names[-1]}".replace("-", "_")].GetParent()
    assert moves.HasAPI(UsdPhysics.RigidBodyAPI)
    assert moves.GetName() not in ("carrier", "skin")


def test_materials_have_the_designs_friction_and_densities(written: Written) -> None:
    design = written.package.design
    bound, _ = UsdShade.MaterialBindingAPI(written.prim("skin/collider")).ComputeBoundMaterial()
    physics = UsdPhysics.MaterialAPI(bound.GetPrim())
    density = skincad.inputs.material.silicone(design).density
    assert physics.GetDensityAttr().Get() == pytest.approx(density, rel=SINGLE)
    friction = 1.0 if design.contact.friction is None else design.contact.friction
    for attribute in (physics.GetStaticFrictionAttr(), physics.GetDynamicFrictionAttr()):
        assert attribute.Get() == pytest.approx(friction, rel=SINGLE)
    shader = UsdShade.Shader(bound.GetPrim().GetChild("surface"))
    assert shader.GetIdAttr().Get() == "UsdPreviewSurface"


def test_the_same_again_is_the_same_bytes(written: Written, tmp_path: Path) -> None:
    skincad.write(written.package, tmp_path / "again")
    assert (tmp_path / "again" / "skin.usda").read_bytes() == written.path.read_bytes()


def test_without_the_library_one_line_says_how_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("skincad.outputs.simulators.usd.find_spec", lambda _: None)
    with pytest.raises(InputError, match=r"kinds: needs the package usd-core.*pip install 'skincad\[usd\]'"):
        skincad.package(skincad.load_design("yamada-2002"), "usd")


def test_a_plate_that_is_not_flat_is_refused(tmp_path: Path) -> None:
    words = ("--set", "contact.plate.shape=tilted", "--set", "contact.plate.tilt=1", "--for", "usd")
    said = refused_command("package", "yamada-2002", *words, cwd=tmp_path)
    assert said.startswith("contact.plate.shape: must be 'flat' for mujoco and usd")
