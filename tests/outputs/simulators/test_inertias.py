"""A lopsided body's inertia means the same to MuJoCo, to a URDF reader and to us: every axis in its place."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest
import yourdfpy

import skincad
from skincad.outputs.simulators.links import Links, Weight
from skincad.outputs.simulators.models import body_inertial, skin_urdf

LOPSIDED = Weight(
    2.0, np.array([1.0, -2.0, 3.0]), np.array([[9.0, 1.0, -2.0], [1.0, 8.0, 0.5], [-2.0, 0.5, 7.0]])
)


def test_mujoco_reads_it() -> None:
    text = f'<mujoco><worldbody><body name="b">{body_inertial(LOPSIDED, 0)}</body></worldbody></mujoco>'
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    turn = data.ximat[1].reshape(3, 3)
    assert model.body_mass[1] * 1e3 == pytest.approx(LOPSIDED.mass)
    assert data.xipos[1] * 1e3 == pytest.approx(LOPSIDED.centre)
    assert turn @ np.diag(model.body_inertia[1]) @ turn.T * 1e9 == pytest.approx(LOPSIDED.inertia)


def test_a_urdf_reader_reads_it(tmp_path: Path) -> None:
    design = skincad.load_design("steep-fingertip")
    (tmp_path / "a.urdf").write_text(skin_urdf(design, Links(LOPSIDED, LOPSIDED, (), None)))
    robot = yourdfpy.URDF.load(str(tmp_path / "a.urdf"), load_meshes=False, build_scene_graph=False)
    inertial = robot.link_map["carrier"].inertial
    assert inertial.mass * 1e3 == pytest.approx(LOPSIDED.mass)
    assert inertial.origin[:3, 3] * 1e3 == pytest.approx(LOPSIDED.centre)
    assert inertial.inertia * 1e9 == pytest.approx(LOPSIDED.inertia)
