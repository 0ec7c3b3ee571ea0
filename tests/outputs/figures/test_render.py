"""The picture of a design: shaded, what is in front and bright, and the mold taken apart in its order."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
import trimesh

import skincad
from skincad.fabrication import Job, manifold
from skincad.outputs import explosion_offset
from skincad.outputs.figures import design as pictures
from skincad.solids import PINS, ClosedMold, PartRole
from tests.designs import three_ridges

RED, BLUE = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)


def box(size: float, at: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> trimesh.Trimesh:
    shape = trimesh.creation.box((size, size, size))
    shape.apply_translation(at)
    return shape


def colour(image: np.ndarray, seen: pictures.Camera, point: tuple[float, float, float]) -> np.ndarray:
    """What the picture shows where a point of the scene lies."""
    x, y = seen.pixel(np.array(point))
    return image[int(y), int(x)]


@pytest.mark.parametrize(("azimuth", "height"), [(0.0, 0.0), (32.0, 28.0), (90.0, 0.0), (200.0, 60.0)])
def test_a_view_is_upright_and_just_holds_what_it_shows(azimuth: float, height: float) -> None:
    shapes = [box(2.0), box(1.0, (5.0, 1.0, 2.0))]
    seen = pictures.view(shapes, azimuth, height, (320, 200))
    axes = np.array([seen.right, seen.up, seen.towards])
    assert axes @ axes.T == pytest.approx(np.eye(3), abs=1e-12)
    assert np.linalg.det(axes) == pytest.approx(1.0)
    assert seen.right[2] == 0.0  # the horizon is level
    assert seen.up[2] >= 0.0
    assert seen.towards[2] == pytest.approx(np.sin(np.radians(height)))
    pixels = np.array([seen.pixel(corner) for shape in shapes for corner in shape.vertices])
    low, high = pixels.min(axis=0), pixels.max(axis=0)
    assert (low + high) / 2 == pytest.approx([160.0, 100.0], abs=1e-9)
    filled = (high - low) / (320, 200)
    assert filled.max() == pytest.approx(0.96, abs=1e-9)


def test_angles_go_from_the_front_to_the_right_and_up() -> None:
    shapes = [box(1.0)]
    assert pictures.view(shapes, 0.0, 0.0, (10, 10)).towards == pytest.approx([0.0, -1.0, 0.0], abs=1e-12)
    assert pictures.view(shapes, 90.0, 0.0, (10, 10)).towards == pytest.approx([1.0, 0.0, 0.0], abs=1e-12)
    assert pictures.view(shapes, 0.0, 90.0, (10, 10)).towards == pytest.approx([0.0, 0.0, 1.0], abs=1e-12)


def test_what_is_nearer_hides_what_is_behind_it_and_all_round_it_is_white() -> None:
    near, far = box(1.0, (0.0, -3.0, 0.0)), box(3.0)
    for shapes, colours in (([near, far], [RED, BLUE]), ([far, near], [BLUE, RED])):
        seen = pictures.view(shapes, 0.0, 0.0, (180, 120))
        image = pictures.shaded(shapes, colours, seen)
        assert image.shape == (120, 180, 3)
        assert (image >= 0).all()
        assert (image <= 1).all()
        front = colour(image, seen, (0.0, -3.5, 0.0))
        assert front[0] > 0.4
        assert front[2] == 0.0
        beside = colour(image, seen, (1.2, -1.5, 1.2))
        assert beside[2] > 0.4
        assert beside[0] == 0.0
        assert (image[:, :10] == 1.0).all()
        assert (image[0] == 1.0).all()


def test_the_side_towards_the_light_is_brighter_and_none_is_black() -> None:
    """It comes from the viewer's upper right: the top is the brightest, then the front, then the right."""
    shape = box(2.0)
    seen = pictures.view([shape], 35.0, 30.0, (120, 120))
    image = pictures.shaded([shape], [(1.0, 1.0, 1.0)], seen)
    top, front, right = (
        colour(image, seen, at)[0] for at in ((0.0, 0.0, 1.0), (0.0, -1.0, 0.0), (1.0, 0.0, 0.0))
    )
    assert 1.0 > top > front > right > 0.45
    left = pictures.view([shape], -120.0, 0.0, (120, 120))  # away from the light: its rest is even
    dark = pictures.shaded([shape], [(1.0, 1.0, 1.0)], left)
    assert colour(dark, left, (-1.0, 0.0, 0.0))[0] == pytest.approx(0.45)


def test_edges_between_faces_and_parts_are_dark_and_flat_faces_have_none() -> None:
    shape = box(2.0)
    seen = pictures.view([shape], 45.0, 0.0, (200, 200))  # two faces, one upright edge between them
    image = pictures.shaded([shape], [(1.0, 1.0, 1.0)], seen)
    row = image[100, :, 0]
    assert row[97:103].min() < 0.85 * min(row[60], row[140])  # the edge between them
    assert (row[60:95] == row[60]).all()  # none on a face, though it is of two triangles
    assert (row[106:140] == row[106]).all()
    # an outline against the white, and between two parts whose faces are in one plane
    pair = [box(2.0), box(2.0, (2.0, 0.0, 0.0))]
    seen = pictures.view(pair, 0.0, 0.0, (200, 100))
    row = pictures.shaded(pair, [(1.0, 1.0, 1.0)] * 2, seen)[50, :, 0]
    face = row[60]
    assert row[97:103].min() < 0.85 * face
    assert (row[10:90] == face).all()
    assert (row[110:190] == face).all()
    ends = np.flatnonzero(row < 1.0)[[0, -1]]
    assert ends == pytest.approx(np.array([0.02, 0.98]) * 200, abs=1.01)  # 96 % of the picture's width
    for outer in (row[ends[0] : ends[0] + 3], row[ends[1] - 2 : ends[1] + 1]):
        assert outer.min() < 0.92 * face


def boxes(closed: ClosedMold) -> dict[str, np.ndarray]:
    """Lowest and highest corner of each part that is drawn apart, `(2, 3)` mm."""
    return {
        part.name: np.reshape(manifold(part, 0.2).bounding_box(), (2, 3)) + explosion_offset(part, closed)
        for part in closed.parts
    }


@pytest.mark.parametrize("name", ["yamada-2002", "plain-ridges", "steep-fingertip", "bent"])
def test_parts_lie_clear_of_each_other_in_the_order_of_opening(name: str) -> None:
    closed = Job(three_ridges() if name == "bent" else skincad.load(name)).closed
    placed = boxes(closed)
    shown = [part for part in closed.parts if part.made == "made" or part.role is PartRole.SKIN]
    upright = [p.name for p in shown if p.role in (PartRole.COVER, PartRole.CARRIER, PartRole.SKIN)]
    order = ["cover", "carrier", "skin"]
    assert sorted(upright) == sorted(order)
    for above, below in pairwise(order):
        assert placed[above][0, 2] > placed[below][1, 2]
    cavity = [p for p in shown if p.name.startswith("cavity")]
    assert placed["skin"][0, 2] > max(placed[p.name][1, 2] for p in cavity if p.role is not PartRole.BASE)
    middle = np.array([placed[p.name] for p in cavity])
    for part in shown:
        if part.end == "a":
            assert placed[part.name][1, 1] < middle[:, 0, 1].min()
        if part.end == "b":
            assert placed[part.name][0, 1] > middle[:, 1, 1].max()
    for end in "ab":
        if f"end-{end}-comb" in placed:
            assert placed[f"end-{end}-keeper"][0, 2] > placed[f"end-{end}-comb"][0, 2]
    if name != "bent":
        drawn = [
            explosion_offset(part, closed) for part in shown if part.end and part.role is not PartRole.KEEPER
        ]
        assert all((shift[0], shift[2]) == (0.0, 0.0) for shift in drawn)  # straight out


def test_pins_stay_where_they_are_pressed_in() -> None:
    closed = Job(skincad.load("steep-fingertip")).closed
    at = {part.name: explosion_offset(part, closed) for part in closed.parts}
    for name, shift in at.items():
        if name.startswith("pin-cover"):
            assert (shift == at["cover"]).all()
        if name.startswith("pin-base"):
            assert (shift == at["cavity-base"]).all()
    assert at["cavity-base"][2] < 0
    assert at["cavity-left"][0] < 0 < at["cavity-right"][0]
    assert (at["cavity-left"] == -at["cavity-right"]).all()
    ends = [part for part in closed.parts if part.role in PINS and part.end]
    for pin in ends:  # half way out
        plate = next(shift for name, shift in at.items() if name.startswith(f"end-{pin.end}"))
        assert at[pin.name][1] == pytest.approx(plate[1] / 2)
