"""A strict reader takes the URDF: links, joints, meshes and masses."""

from __future__ import annotations

import mujoco
import pytest
import yourdfpy

from tests.outputs.simulators.conftest import PackageFolder

pytestmark = [pytest.mark.slow, pytest.mark.xdist_group("packages")]


def test_a_strict_reader_takes_it(simulated: PackageFolder) -> None:
    robot = yourdfpy.URDF.load(
        str(simulated.folder / "skin.urdf"),
        build_collision_scene_graph=True,
        load_collision_meshes=True,
        mesh_dir=str(simulated.folder),
    )
    assert robot.validate()
    assert robot.errors == []
    design, weighs = simulated.package.design, simulated.package.weighs
    ridges = {f"ridge-{i}" for i in range(1, design.ridge.count + 1)}
    assert {*robot.link_map} == {"carrier", "skin", "filling", *ridges}
    assert robot.base_link == "carrier"
    total = sum(link.inertial.mass for link in robot.link_map.values())
    assert total == pytest.approx(weighs.mass * 1e-3, rel=1e-12)
    model = mujoco.MjModel.from_xml_path(str(simulated.folder / "skin.urdf"))  # another strict reader
    assert model.ngeom == 2 + design.ridge.count
    low, high = robot.collision_scene.bounds * 1e3
    assert high[2] == pytest.approx(simulated.package.surfaces["skin"].bounds[1, 2], abs=1e-3)
    assert high[0] - low[0] == pytest.approx(simulated.package.surfaces["carrier"].extents[0], rel=0.2)
