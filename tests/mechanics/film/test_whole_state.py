"""The whole pad's state under given contact forces, against the condensed pad that the forces are from."""

from __future__ import annotations

import numpy as np
import pytest

from skincad.mechanics import press
from skincad.mechanics.bodies import film_field
from skincad.mechanics.film.stick import in_strip_axes, on_whole
from tests.mechanics.film.test_sliding import meshed


def force() -> np.ndarray:
    """A press, and a pull that is no mirror image of itself."""
    pad = meshed()[2]
    m = pad.gap.size
    normal = press(pad.compliance[m:, m:], pad.gap, 1.2).force
    return np.concatenate([0.3 * normal * (1 + np.sign(pad.x)), -normal])


def test_contact_points_move_as_the_condensed_pads() -> None:
    part, _, pad = meshed()
    shown = pad.whole.deformed_section(force(), part.whole.top, 0.0)
    moved = (pad.compliance @ force()).reshape(2, -1).T
    points = np.column_stack([pad.x, part.whole.top - pad.gap])
    off = np.hypot(*(shown.place[:, None] - points[None]).transpose(2, 0, 1))
    at = off.argmin(axis=0)
    drawn = off.min(axis=0) < 1e-9  # elements' corners and middles are drawn: of order 3, every third point
    assert drawn.sum() > 0.3 * pad.x.size
    assert {-1.0, 1.0} <= set(np.sign(pad.x[drawn]))
    # rounding of two solves
    assert shown.shift[at[drawn]] == pytest.approx(moved[drawn], abs=1e-9 * np.abs(moved).max())


def test_strips_feel_what_the_condensed_pad_says() -> None:
    part, _, pad = meshed()
    sides = pad.whole._moved(force())
    stresses = []
    for moved in sides:
        film_field.set_state(pad.whole.body, moved)
        stress = film_field.averages(pad.whole.body, part.slots, part.thickness, part.unit)
        stresses.append(on_whole(part, in_strip_axes(stress * part.pad.young_modulus, part.slots), 1))
    right = np.array([slot.centre.x > 0 for slot in part.whole.section.slots])
    expected = pad.strips @ force()
    whole = np.where(right[:, None], stresses[0], stresses[1])
    assert whole == pytest.approx(expected, abs=1e-8 * np.abs(expected).max())


def test_a_plate_through_the_flanks_is_a_fault() -> None:
    part, _, pad = meshed()
    assert pad.whole.fault(0 * force(), part.whole.top, 0.0) is None
    assert "meets the plate" in pad.whole.fault(0 * force(), part.whole.top - 0.4, 0.0)
    # the plate falls towards -x: what is met lies in the mirrored half
    assert "meets the plate" in pad.whole.fault(0 * force(), part.whole.top, 0.3)
    assert "meets the plate" in pad.whole.fault(0 * force(), part.whole.top, -0.3)


def test_ridges_that_give_more_at_the_ends_let_the_plate_down() -> None:
    """A plate 0.4 mm too deep meets the flanks; no longer where the ends let every ridge down by as much."""
    part, _, pad = meshed()
    deep, x = part.whole.top - 0.4, np.array([-1.0, 1.0])
    assert pad.whole.fault(0 * force(), deep, 0.0, (x, np.full(2, 0.4))) is None
    assert "meets the plate" in pad.whole.fault(0 * force(), deep, 0.0, (x, np.full(2, 0.01)))
