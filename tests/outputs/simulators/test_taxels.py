"""Places and axes of what feels, against the section and the STEP file's own points."""

from __future__ import annotations

import re

import numpy as np
import pytest

import skincad
from skincad.outputs.simulators.taxels import films, taxels
from skincad.solids import skin_part, workplane

NAMES = ("yamada-2002", "yamada-2002-tilted", "steep-fingertip")


@pytest.mark.parametrize("name", NAMES)
def test_axes_are_right_handed_and_the_third_points_outward(name: str) -> None:
    design = skincad.load_design(name)
    places = taxels(design)
    turn = places.poses[:, :, :3]
    assert np.linalg.det(turn) == pytest.approx(1.0)
    assert np.einsum("nij,nik->njk", turn, turn) == pytest.approx(np.broadcast_to(np.eye(3), turn.shape))
    assert (turn[:, 2, 2] > 0).all()
    assert turn[:, :, 1] == pytest.approx(np.broadcast_to([0.0, 1.0, 0.0], (len(turn), 3)))


def test_a_tilted_strip_leans_as_its_slot() -> None:
    """45 degrees, tops inward: of the middle ridge S1's outward axis has +x, S2's -x."""
    places = films(skincad.load_design("yamada-2002-tilted"))
    one, other = (places.poses[places.names.index(f"ridge-5-{side}")][:, 2] for side in ("S1", "S2"))
    assert one == pytest.approx([np.sqrt(0.5), 0.0, np.sqrt(0.5)])
    assert other == pytest.approx([-np.sqrt(0.5), 0.0, np.sqrt(0.5)])


@pytest.mark.parametrize("doubly", [False, True])
@pytest.mark.parametrize("name", ["yamada-2002", "yamada-2002-tilted"])
def test_strips_lie_within_a_micrometre_of_the_slots_in_the_solid(name: str, doubly: bool, tmp_path) -> None:
    """The mean of each slot's four corner edges in the middle of the skin, as read back from STEP."""
    import cadquery as cq

    design = skincad.load_design(name)
    if doubly:
        design = design.with_(skin={"curvature_radius_y": 100.0})
    path = str(tmp_path / "skin.step")
    workplane(skin_part(design)).val().exportStep(path)
    solid = cq.importers.importStep(path).val()
    places = films(design)
    middle = solid.intersect(cq.Solid.makeBox(40, 1e-3, 20, cq.Vector(-20, -5e-4, -1)))
    faces = [f for f in middle.Faces() if abs(f.normalAt().y) > 0.9 and f.Center().y < 0]
    holes = np.array([wire.Center().toTuple() for face in faces for wire in face.innerWires()])
    assert len(holes) == len(places.names) == 18
    away = np.linalg.norm(places.poses[:, None, :, 3][:, :, [0, 2]] - holes[None][:, :, [0, 2]], axis=2)
    assert away.min(axis=1).max() < 1e-3
    assert len({*away.argmin(axis=1).tolist()}) == 18


def test_without_slots_crests_alone_feel() -> None:
    places = taxels(skincad.load_design("plain-ridges"))
    assert {*places.kinds} == {"crest"}
    assert len(places.names) == 9
    assert places.poses[4, :, 3] == pytest.approx([0.0, 0.0, 4.5])
    assert re.fullmatch(r"ridge-\d-crest", places.names[0])
