import math

import numpy as np
import pytest

from skincad.fabrication import manifold
from skincad.shape import Point, loop
from skincad.solids import Bore, Grid, Part, PartRole, Prism, RevolvedBody, RotatedBody, box, swept, unturned
from skincad.solids.plan import turned


def test_volume_is_body_less_cuts() -> None:
    drilled = Part("p", PartRole.COVER, box(2, (0, 5), (0, 1)), (Bore((0, 2, 0), "z", 1.0, 0.5, 1.0),))
    frustum = math.pi / 3 * (0.25 + 0.5 + 1.0)
    assert drilled.volume == pytest.approx(20.0 - frustum, rel=1e-14)


def test_moved_along_its_axis_a_part_sweeps_a_longer_one_and_keeps_its_bores_open() -> None:
    plate = Part("p", PartRole.COVER, box(2, (0, 1), (0, 4), "y"), (Bore((0, 0, 2), "y", 1.0, 0.5),))
    path = swept(plate, "y", -3.0, 1e-3)
    assert path.volume == pytest.approx(4 * plate.volume, rel=1e-14)
    assert manifold(path, 1e-3).bounding_box()[1] == -3.0


def test_moved_across_its_axis_a_prism_sweeps_its_shadow() -> None:
    mushroom = loop([Point(*p) for p in ((-1, 0), (1, 0), (1, 1), (3, 2), (-3, 2), (-1, 1))])
    part = Part("p", PartRole.SKIN, Prism(mushroom, "y", 0.0, 1.0))
    path = swept(part, "z", 5.0, 1e-3)
    assert path.volume == pytest.approx(part.volume + 6 * 5.0, rel=1e-12)  # width 6 everywhere above


def test_a_pin_moved_across_its_axis_is_refused() -> None:
    pin = Part("pin", PartRole.END_PIN, Bore((0, 0, 0), "z", 1.0, 0.5))
    with pytest.raises(ValueError, match="pin moves along its axis only"):
        swept(pin, "y", 1.0, 1e-3)


def test_moved_aside_a_prism_sweeps_its_shadow_along_the_heading() -> None:
    part = Part("p", PartRole.COVER, box(1.0, (0.0, 2.0), (0.0, 1.0), "y"))
    path = swept(part, (math.sin(0.3), -math.cos(0.3)), 5.0, 1e-3)
    width = 2.0 * math.cos(0.3) + 1.0 * math.sin(0.3)  # width of a 2 x 1 mm box seen along the heading
    assert path.volume == pytest.approx(2.0 * (2.0 + 5.0 * width), rel=1e-12)


def test_a_blind_hole_leaves_no_way_open_in_what_is_swept() -> None:
    blind = Part("p", PartRole.COVER, box(2, (0, 4), (0, 4), "y"), (Bore((0, 0, 2), "y", 3.0, 0.5),))
    assert swept(blind, "y", 2.0, 1e-3).volume == pytest.approx(4 * 6 * 4)


def test_a_pin_along_y_moved_down_sweeps_a_stadium() -> None:
    pin = Part("pin", PartRole.END_PIN, Bore((0, 0, 0), "y", 3.0, 1.0))
    path = swept(pin, "z", -4.0, 1e-5)
    assert path.volume == pytest.approx(3.0 * (math.pi + 8.0), rel=1e-4)  # chords within 1e-5 mm


def test_a_turned_part_has_its_own_frame_and_is_swept_along_its_own_y() -> None:
    plate = Part("p", PartRole.COVER, box(2, (5, 6), (0, 4), "y"), (Bore((0, 5, 2), "y", 1.0, 0.5),))
    leaning = turned(plate, 20.0, 0.3, 5.0)
    assert unturned(leaning) == plate
    assert leaning.volume == plate.volume
    path = swept(leaning, "y", 3.0, 1e-3)
    assert path.volume == pytest.approx(4 * plate.volume, rel=1e-14)
    ends = np.array([[0.0, 5.0, 20.0], [0.0, 5.0, 0.0], [0.0, 9.0, 0.0]])  # the axis, the foot, the way's end
    placed = [
        [0.0, 0.0, 20.0],
        [0.0, 20 * math.sin(0.3), 20 - 20 * math.cos(0.3)],
        [0.0, 20 * math.sin(0.3) + 4 * math.cos(0.3), 20 - 20 * math.cos(0.3) + 4 * math.sin(0.3)],
    ]
    assert isinstance(leaning.body, RotatedBody)
    assert np.allclose(leaning.body.placed(ends), placed, atol=1e-14)
    assert np.allclose(leaning.body.returned(np.array(placed)), ends, atol=1e-14)


def test_what_turns_is_swept_by_turning_and_upward_by_its_silhouette() -> None:
    grid = Grid(20.0, 0.3, 22.0)
    square = loop([Point(*p) for p in ((-1, -2), (1, -2), (1, 0), (-1, 0))])
    arc = Part("a", PartRole.SHIM, RevolvedBody(square, 20.0, -0.3, 0.3, grid=grid))
    assert swept(arc, "turn", 0.9, 1e-3).volume == pytest.approx(2.5 * arc.volume, rel=1e-14)
    risen = swept(arc, "z", 5.0, 1e-4)
    assert risen.volume == pytest.approx(arc.volume + 2 * 5.0 * 2 * 22 * math.sin(0.3), rel=1e-4)  # chords


def test_a_grids_angles_are_common_and_ends_between_them_lie_on_its_chords() -> None:
    grid, fine = Grid(20.0, 0.3, 22.0), 1e-3
    whole, part = grid.angles(-0.3, 0.3, fine), grid.angles(-0.11, 0.9, fine)
    assert (whole[0], whole[-1], part[0], part[-1]) == (-0.3, 0.3, -0.11, 0.9)
    assert set(whole[whole > -0.11]) <= set(part)  # to the last digit
    step = whole[1] - whole[0]
    assert 22.0 * (1 - math.cos(step / 2)) < fine / 2 < 22.0 * (1 - math.cos(0.6 * step))
    (y0, z0), (y1, z1), (y2, z2) = (
        *grid.arc(whole[3], whole[4], fine),
        grid.arc(whole[3] + 0.3 * step, 0.3, fine)[0],
    )
    assert (y1 - y0) * (z2 - z0) == pytest.approx((y2 - y0) * (z1 - z0), rel=1e-9)
    assert math.hypot(y2, 20 - z2) < 20.0
