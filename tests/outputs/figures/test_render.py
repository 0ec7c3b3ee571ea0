"""Shaded pictures: where a point lies, what is in front, which side is bright, and dark edges."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from skincad.outputs.figures.design import Camera, shaded, view

RED, BLUE = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)


def box(size: float, at: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> trimesh.Trimesh:
    mesh = trimesh.creation.box((size, size, size))
    mesh.apply_translation(at)
    return mesh


def colour(image: np.ndarray, seen: Camera, point: tuple[float, float, float]) -> np.ndarray:
    """What the picture shows where a point of the scene lies."""
    x, y = seen.pixel(np.array(point))
    return image[int(y), int(x)]


@pytest.mark.parametrize(("azimuth", "height"), [(0.0, 0.0), (32.0, 28.0), (90.0, 0.0), (200.0, 60.0)])
def test_a_view_is_upright_and_just_holds_what_it_shows(azimuth: float, height: float) -> None:
    shapes = [box(2.0), box(1.0, (5.0, 1.0, 2.0))]
    seen = view(shapes, azimuth, height, (320, 200))
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
    assert view(shapes, 0.0, 0.0, (10, 10)).towards == pytest.approx([0.0, -1.0, 0.0], abs=1e-12)
    assert view(shapes, 90.0, 0.0, (10, 10)).towards == pytest.approx([1.0, 0.0, 0.0], abs=1e-12)
    assert view(shapes, 0.0, 90.0, (10, 10)).towards == pytest.approx([0.0, 0.0, 1.0], abs=1e-12)


def test_what_is_nearer_hides_what_is_behind_it_and_all_round_it_is_white() -> None:
    near, far = box(1.0, (0.0, -3.0, 0.0)), box(3.0)
    for shapes, colours in (([near, far], [RED, BLUE]), ([far, near], [BLUE, RED])):
        seen = view(shapes, 0.0, 0.0, (180, 120))
        image = shaded(shapes, colours, seen)
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
    seen = view([shape], 35.0, 30.0, (120, 120))
    image = shaded([shape], [(1.0, 1.0, 1.0)], seen)
    top, front, right = (
        colour(image, seen, at)[0] for at in ((0.0, 0.0, 1.0), (0.0, -1.0, 0.0), (1.0, 0.0, 0.0))
    )
    assert 1.0 > top > front > right > 0.45
    left = view([shape], -120.0, 0.0, (120, 120))  # turned away from the light: what is left of it is even
    dark = shaded([shape], [(1.0, 1.0, 1.0)], left)
    assert colour(dark, left, (-1.0, 0.0, 0.0))[0] == pytest.approx(0.45)


def test_edges_between_faces_and_parts_are_dark_and_flat_faces_have_none() -> None:
    shape = box(2.0)
    seen = view([shape], 45.0, 0.0, (200, 200))  # two faces, one upright edge between them
    image = shaded([shape], [(1.0, 1.0, 1.0)], seen)
    row = image[100, :, 0]
    assert row[97:103].min() < 0.85 * min(row[60], row[140])  # the edge between them
    assert (row[60:95] == row[60]).all()  # none on a face, though it is of two triangles
    assert (row[106:140] == row[106]).all()
    # an outline against the white, and between two parts whose faces are in one plane
    pair = [box(2.0), box(2.0, (2.0, 0.0, 0.0))]
    seen = view(pair, 0.0, 0.0, (200, 100))
    row = shaded(pair, [(1.0, 1.0, 1.0)] * 2, seen)[50, :, 0]
    face = row[60]
    assert row[97:103].min() < 0.85 * face
    assert (row[10:90] == face).all()
    assert (row[110:190] == face).all()
    ends = np.flatnonzero(row < 1.0)[[0, -1]]
    assert ends == pytest.approx(np.array([0.02, 0.98]) * 200, abs=1.01)  # 96 % of the picture's width
    for outer in (row[ends[0] : ends[0] + 3], row[ends[1] - 2 : ends[1] + 1]):
        assert outer.min() < 0.92 * face
