"""What free ends move from ridge to ridge, against the coarse solids that the effect itself takes."""

from __future__ import annotations

import numpy as np
import pytest

from skincad.inputs import Design
from skincad.mechanics import added_compliance, force_changes
from skincad.mechanics.left_out import end_compliance
from tests.mechanics.designs import filleted, yamada


def five(**changes: dict[str, float]) -> Design:
    """A pad of none of the shapes that the constants were read off."""
    return filleted().with_(ridge={"count": 5}, skin={"width": 7.0, **changes.pop("skin", {})}, **changes)


@pytest.mark.parametrize("skin", [{"thickness": 4.0, "length": 10.0}, {"thickness": 2.5, "length": 16.0}])
def test_ends_soften_as_in_three_dimensions(skin: dict[str, float]) -> None:
    design = five(skin=skin)
    solid, said = added_compliance(design), end_compliance(design)
    assert np.diag(said) == pytest.approx(np.diag(solid), rel=0.15)
    # ridges at opposite sides of a thick pad soften each other less than is said
    assert said == pytest.approx(solid, abs=0.16 * solid.max())


@pytest.mark.slow
def test_strips_hold_ridges_along_y() -> None:
    design = yamada().with_(ridge={"count": 3}, skin={"width": 5.0, "thickness": 3.0})
    bonded, bare = (design.with_(contact={"film": film}) for film in ("bonded", "ignored"))
    middle = end_compliance(bonded)[1, 1], end_compliance(bare)[1, 1]
    wanted = added_compliance(bonded)[1, 1], added_compliance(bare)[1, 1]
    assert middle == pytest.approx(wanted, rel=0.25)
    assert middle[0] < 0.5 * middle[1]


def test_force_goes_from_the_middle_outwards_and_none_is_lost() -> None:
    shift = force_changes(five(), np.array([[1.0, 1.0, 1.0, 1.0, 1.0], [0.0, 1.0, 2.0, 1.0, 0.0], [0.0] * 5]))
    assert shift.sum(axis=1) == pytest.approx(0, abs=1e-12)
    assert shift[0, :3] == pytest.approx(shift[0, :1:-1])
    assert shift[0, 0] > 0 > shift[0, 2]
    assert not shift[1, [0, 4]].any()  # what does not touch bears nothing
    assert not shift[2].any()


def test_ends_count_by_the_square_of_poissons_ratio_and_of_the_length() -> None:
    usual = end_compliance(five())
    assert not end_compliance(five(material={"young_modulus": 0.8, "poisson_ratio": 0.0})).any()
    assert end_compliance(five(skin={"length": 24.0})) == pytest.approx(usual / 4)
