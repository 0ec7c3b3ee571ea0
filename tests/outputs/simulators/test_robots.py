"""The skin on a robot of others: attached by MjSpec, then pressed and pulled under the robot's settings."""

from __future__ import annotations

import importlib.util
import warnings
from functools import cache
from pathlib import Path

import mujoco
import numpy as np
import pytest
import trimesh

import skincad
from skincad.outputs.simulators import springs
from skincad.outputs.simulators.links import feature_bodies
from skincad.outputs.simulators.taxels import crests
from tests.outputs.simulators.conftest import PackageFolder

# Each with its own units, order of angles, folder of meshes, inertia, defaults and method; classes and names
# are those of skin.xml, with values that would spoil it.
LEFT = """<mujoco model="left">
<compiler angle="degree" eulerseq="xyz" autolimits="true" meshdir="assets" inertiafromgeom="true"
 boundmass="0.01" boundinertia="1e-5"/>
<option timestep="0.001" integrator="Euler" cone="pyramidal"/>
<default>
 <geom margin="0.01" friction="0.1 0.1 0.1" solref="0.05 0.5" density="5000" condim="1" contype="1"/>
 <joint armature="3" damping="7" stiffness="11" frictionloss="0.5" type="hinge"/>
 <mesh scale="2 2 2"/>
 <tendon stiffness="9" damping="9" frictionloss="9"/>
 <default class="ridge"><geom friction="9 9 9"/><joint axis="1 0 0" type="hinge" range="-1 1"/></default>
 <default class="collision"><geom contype="4" conaffinity="4" group="5"/></default>
 <default class="visual"><geom type="sphere" size="1"/></default>
</default>
<asset><mesh name="skin" file="bone.stl" scale="0.001 0.001 0.001"/></asset>
<worldbody>
 <body name="carrier" pos="0.1 0 0.3" euler="0 0 35">
  <joint name="ridge-1" axis="0 1 0" range="-90 90"/>
  <geom name="skin" type="mesh" mesh="skin"/>
  <body name="finger" pos="0.05 0 0.05" euler="20 30 0">
   <joint name="bend" axis="0 1 0" range="-40 40"/>
   <geom name="carrier" type="capsule" size="0.004" fromto="0 0 -0.03 0 0 -0.012"/>
   <site name="tip" pos="0 0 0" euler="0 0 15"/>
  </body>
 </body>
</worldbody>
<equality><joint joint1="ridge-1"/><joint joint1="bend"/></equality>
</mujoco>"""
RIGHT = """<mujoco model="right">
<compiler angle="radian" eulerseq="ZYX" autolimits="false" assetdir="assets" inertiafromgeom="auto"
 discardvisual="true" fusestatic="true" balanceinertia="true"/>
<option timestep="0.002" integrator="implicit" cone="elliptic" impratio="1" gravity="0 -9.81 0" solver="CG"
 iterations="200"/>
<default>
 <geom solimp="0.5 0.6 0.01" friction="0.3" gap="0.001"/>
 <joint limited="true" range="-0.5 0.5" armature="0.1" damping="1" frictionloss="0.1"/>
 <site type="sphere" size="0.5" group="0"/>
</default>
<worldbody>
 <body name="finger" pos="0 0.2 0.1" euler="1.2 0.3 -0.4">
  <inertial pos="0 0 0" mass="0.2" diaginertia="1e-4 1e-4 1e-4"/>
  <joint name="reach" type="slide" axis="0 0 1"/>
  <geom name="base-hull" type="box" size="0.003 0.003 0.003" pos="0 0 -0.03"/>
  <site name="tip" pos="0 0 0.01" euler="0.3 0 0"/>
 </body>
</worldbody>
<equality><joint joint1="reach"/></equality>
</mujoco>"""


# A robot that includes the file: its own defaults are those of the skin's classes too.
HOSTILE = """<mujoco><compiler angle="degree" autolimits="true" inertiafromgeom="true"/>
<default>
 <geom margin="0.01" gap="0.001" solmix="5" density="5000"/>
 <joint armature="3" damping="7" stiffness="11" frictionloss="0.5" range="-1 1"/>
 <tendon damping="9" frictionloss="9" range="-1 1"/>
</default>
<include file="skin.xml"/></mujoco>"""
PLATE = """<mujoco><worldbody><body name="plate" gravcomp="1">
<joint name="z" type="slide" axis="0 0 -1"/><joint name="x" type="slide" axis="1 0 0"/>
<inertial pos="0 0 0" mass="{mass}" diaginertia="1e-4 1e-4 1e-4"/><geom type="box" size="{size}"/>
</body></worldbody>
<actuator><motor name="press" joint="z"/><motor name="pull" joint="x"/></actuator></mujoco>"""
FRICTION, STICKS, SLIDES = 0.6, 0.5, 1.3  # the pulls, of what friction holds
FAMILIES = {"ridge": "plain-ridges", "pin": "pillars-9", "ring": "rings-5", "flat": "flat-magnet"}
# Models of others in packages that may be installed (without what they need), and the body that gets the skin
OTHERS = {
    "fetch": ("gymnasium_robotics", "envs/assets/fetch/reach.xml", "robot0:gripper_link"),
    "jaco": ("dm_control", "third_party/kinova/jaco_hand.xml", "hand"),
    "panda": ("robosuite", "models/assets/robots/panda/robot.xml", "right_hand"),
}


@cache
def packaged(family: str, parent: Path) -> PackageFolder:
    design = skincad.load_design(FAMILIES[family]).with_(contact={"friction": FRICTION})
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(springs, "SPANS", ())
        return PackageFolder(skincad.package(design, "mujoco"), parent / family)


def file_of(package: str, path: str) -> str:
    """The path of a file in an installed package, which is not loaded; "" without."""
    spec = importlib.util.find_spec(package)
    return "" if spec is None else str(Path(spec.origin or "").parent / path)


def own_robot(text: str, folder: Path) -> mujoco.MjSpec:
    (folder / "assets").mkdir()
    trimesh.creation.box((20.0, 20.0, 20.0)).export(folder / "assets" / "bone.stl")
    (folder / "robot.xml").write_text(text)
    return mujoco.MjSpec.from_file(str(folder / "robot.xml"))


class Pressed:
    """A skin on a robot, and a plate on slides along the skin's z and x. `where` is the attached frame or
    site; without one the robot includes the skin."""

    def __init__(self, robot: mujoco.MjSpec, skin: PackageFolder, prefix: str = "", **where: object) -> None:
        self.verdict, self.design = skin.package.springs.verdict, skin.package.design
        self.count, self.prefix = len(feature_bodies(self.design)), prefix
        child = mujoco.MjSpec.from_file(str(skin.folder / "skin.xml")) if where else robot
        child.body("skin").add_site(name="origin")
        if where:
            robot.attach(child, prefix=prefix, **where)
        bare = robot.compile()
        data = mujoco.MjData(bare)
        mujoco.mj_forward(bare, data)
        origin = data.site(f"{prefix}origin")
        turn, quat = origin.xmat.reshape(3, 3), np.zeros(4)
        mujoco.mju_mat2Quat(quat, origin.xmat)
        half = np.array([self.design.skin.width, self.design.skin.length, 2.0]) * 1e-3
        text = PLATE.format(size=" ".join(map(str, half)), mass=self.verdict.force / 9.81)
        self.top = max(place[2, 3] for place in crests(self.design).poses) * 1e-3 + half[2]
        at = robot.worldbody.add_frame(pos=origin.xpos + turn @ [0.0, 0.0, self.top], quat=quat)
        robot.attach(mujoco.MjSpec.from_string(text), frame=at, prefix="plate-")
        self.model = robot.compile()
        self.data = mujoco.MjData(self.model)

    def after(self, seconds: float, pull: float = 0.0) -> Pressed:
        self.data.actuator("plate-press").ctrl = self.verdict.force
        self.data.actuator("plate-pull").ctrl = pull * FRICTION * self.verdict.force
        for _ in range(round(seconds / self.model.opt.timestep)):
            mujoco.mj_step(self.model, self.data)
        assert all(warning.number == 0 for warning in self.data.warning)
        return self

    def forces(self, kind: str = "touch") -> np.ndarray:
        """Of each feature: its normal force, or in the skin's axes what it does to the plate, N."""
        return np.array([self.data.sensor(f"{self.prefix}{kind}-{i + 1}").data for i in range(self.count)])

    def place(self) -> np.ndarray:
        """How far the plate has gone along the skin's x, and is below its first touch, mm."""
        origin = self.data.site(f"{self.prefix}origin")
        x, _, z = origin.xmat.reshape(3, 3).T @ (self.data.body("plate-plate").xpos - origin.xpos)
        return np.array([x, self.top - z]) * 1e3


def judge(run: Pressed) -> None:
    """Pressed by the check's force: each feature's force within the check's error of it, the approach too.
    Means of 0.5 s: by Euler's method at 2 ms forces flicker. 3 % of the mean force, 1 % of all: what is left
    of the plate's own motion. A pyramid of friction holds from 1 / sqrt 2 of the cone's on; a held plate
    creeps as fast as the robot's method lets it: by up to 60 % of the approach a second.
    """
    verdict, rows, down = run.after(2.5).verdict, [], []
    for _ in range(50):
        rows.append(run.after(0.01).forces()[:, 0])
        down.append(run.place()[1])
    force = np.mean(rows, axis=0)
    assert force.sum() == pytest.approx(verdict.force, rel=0.01)
    for share, other in zip(force, verdict.ridge_force, strict=True):
        assert abs(share - float(other)) <= (other.error or 0.0) + 0.03 * verdict.force / run.count
    assert abs(np.mean(down) - float(verdict.approach)) <= verdict.approach.error
    held, pulls = run.after(0.5, STICKS).place()[0], []
    for _ in range(50):
        pulls.append(run.after(0.01, STICKS).forces("force")[:, 0].sum())
    assert np.mean(pulls) == pytest.approx(-STICKS * FRICTION * verdict.force, rel=0.02)
    assert abs(run.place()[0] - held) < 0.4 * float(verdict.approach)
    sums = np.zeros(2)
    for _ in range(10):
        pulled, pressed = run.after(0.004, SLIDES).forces("force")[:, 0].sum(), run.forces()[:, 0].sum()
        sums += [pulled, pressed] if pressed > 0.2 * verdict.force else 0.0  # a plate that slides hops
    assert run.place()[0] - held > float(verdict.approach)
    pyramid = run.model.opt.cone == mujoco.mjtCone.mjCONE_PYRAMIDAL
    assert 0.98 * FRICTION / (np.sqrt(2) if pyramid else 1.0) < -sums[0] / sums[1] < 1.02 * FRICTION


FAMILY = [
    pytest.param(f, marks=pytest.mark.evidence(subject=f"robots: {f}")) for f in ("pin", "ring", "flat")
]


@pytest.mark.parametrize("family", [pytest.param("ridge", marks=pytest.mark.slow), *FAMILY])
@pytest.mark.parametrize("text", [LEFT, RIGHT], ids=["left", "right"])
def test_attached_to_a_robot_each_feature_bears_what_the_check_says(
    text: str, family: str, tmp_path: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    """Under the robot's own compiler, defaults and options; MuJoCo says that they differ."""
    skin, robot = packaged(family, tmp_path_factory.getbasetemp()), own_robot(text, tmp_path)
    alone = robot.compile().body_mass.sum()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        run = Pressed(robot, skin, "pad-", site=robot.site("tip"))
    plate = run.model.body("plate-plate").mass[0]
    assert run.model.body_mass.sum() - plate - alone == pytest.approx(
        1e-3 * skin.package.weighs.mass, rel=1e-6
    )
    judge(run)


@pytest.mark.slow
def test_defaults_of_a_robot_that_includes_the_skin_do_not_reach_it(
    tmp_path_factory: pytest.TempPathFactory,
) -> None:
    skin = packaged("ridge", tmp_path_factory.getbasetemp())
    (skin.folder / "hostile.xml").write_text(HOSTILE)
    judge(Pressed(mujoco.MjSpec.from_file(str(skin.folder / "hostile.xml")), skin))


@pytest.mark.evidence(subject="robots: {name}")
@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("name", OTHERS)
def test_on_robots_of_others(name: str, family: str, tmp_path_factory: pytest.TempPathFactory) -> None:
    """Of packages that are installed by pip without what they need; their joints are locked.
    At 1 ms: under a pyramidal cone at 2 ms a plate on a fixed base rattles by a fifth of its force."""
    package, path, body = OTHERS[name]
    if not file_of(package, path):
        pytest.skip(f"{name} is not loaded: pip install --no-deps {package.replace('_', '-')}")
    robot = mujoco.MjSpec.from_file(file_of(package, path))
    for joint in robot.joints:
        if joint.type != mujoco.mjtJoint.mjJNT_FREE:
            lock = robot.add_equality(type=mujoco.mjtEq.mjEQ_JOINT, name1=joint.name)
            lock.objtype, lock.solref = mujoco.mjtObj.mjOBJ_JOINT, [0.004, 1.0]
    for part in robot.bodies:
        part.gravcomp = 1.0
    robot.option.timestep = 0.001
    frame = robot.body(body).add_frame(pos=[0.0, 0.3, 0.0], quat=[0.9, 0.1, 0.3, 0.2])  # clear of the robot
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        run = Pressed(robot, packaged(family, tmp_path_factory.getbasetemp()), "pad-", frame=frame)
    judge(run)
