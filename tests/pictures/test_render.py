"""Shaded pictures of a box: where it lies, how bright its faces are, where its edges are."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from skincad.pictures.render import Camera, shaded, view

SIDES = np.array([4.0, 2.0, 1.0])  # mm
GREY = (0.8, 0.8, 0.8)


def pictured(azimuth: float, height: float, size: tuple[int, int] = (120, 90)) -> tuple[Camera, np.ndarray]:
    box = trimesh.creation.box(SIDES)
    seen = view([box], azimuth, height, size)
    return seen, shaded([box], [GREY], seen)


@pytest.mark.parametrize(("azimuth", "height"), [(0.0, 0.0), (90.0, 0.0), (30.0, 25.0), (-120.0, 60.0)])
def test_it_is_seen_whole_and_fills_the_picture(azimuth: float, height: float) -> None:
    seen, image = pictured(azimuth, height)
    assert np.array([seen.right, seen.up, seen.towards]) @ np.array(
        [seen.right, seen.up, seen.towards]
    ).T == pytest.approx(np.eye(3), abs=1e-12)
    painted = np.argwhere(image.min(axis=2) < 1.0)
    free = painted.min(axis=0), np.array(image.shape[:2]) - 1 - painted.max(axis=0)
    assert min(free[0].min(), free[1].min()) >= 1
    assert min((free[0] / image.shape[:2]).min(), 1.0) <= 0.03  # 96 % of one side, the rest on both
    corners = [seen.pixel(SIDES / 2 * [x, y, z]) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    low, high = np.min(corners, axis=0), np.max(corners, axis=0)
    assert painted.min(axis=0)[::-1] == pytest.approx(low, abs=1.5)  # pixels
    assert painted.max(axis=0)[::-1] == pytest.approx(high, abs=1.5)


def test_faces_are_lit_from_the_upper_right_and_edges_are_dark() -> None:
    seen, image = pictured(30.0, 30.0)

    def at(point: list[float]) -> float:
        across, down = seen.pixel(SIDES / 2 * point)
        return float(image[round(down), round(across), 0])

    top, front, side = at([0.0, 0.0, 1.0]), at([0.0, -1.0, 0.0]), at([1.0, 0.0, 0.0])
    assert 0.8 >= top > front > side >= 0.45 * 0.8
    for edge in ([0.0, -1.0, 1.0], [1.0, 0.0, 1.0], [1.0, -1.0, 0.0]):
        across, down = (round(float(each)) for each in seen.pixel(SIDES / 2 * edge))
        near = image[down - 1 : down + 2, across - 1 : across + 2, 0]
        assert near.min() < 0.9 * side  # darker than the darkest face beside it: a line of half a pixel
        assert near.min() > 0.2 * side
    assert (image[0] == 1.0).all()


def test_what_is_near_hides_what_is_behind_and_parts_have_a_line_between() -> None:
    near, far = trimesh.creation.box([1.0, 1.0, 1.0]), trimesh.creation.box([3.0, 1.0, 3.0])
    near.apply_translation([0.0, -2.0, 0.0])
    seen = view([near, far], 0.0, 0.0, (90, 90))
    image = shaded([near, far], [(1.0, 0.0, 0.0), (0.0, 0.0, 1.0)], seen)
    red, blue = image[45, 45], image[10, 45]
    assert red[0] > 0 == red[2]
    assert blue[2] > 0 == blue[0]
    row = image[45]
    assert (row[:, 0].max(), row[:, 2].max()) == (1.0, 1.0)  # white beside it
    border = round(seen.pixel(np.array([0.5, -2.5, 0.0]))[0])
    dark = row[border - 2 : border + 2].max(axis=1).min()
    assert dark < 0.7 * max(red[0], blue[2])
