"""The mold taken apart: parts lie clear of each other, in the order in which they come off."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

import skincad
from skincad.fabrication import manifold
from skincad.outputs import explosion_offset
from skincad.solids import PINS, ClosedMold, PartRole
from skincad.solids.mold import mold
from tests.bent_skin import three_ridges


def boxes(closed: ClosedMold) -> dict[str, np.ndarray]:
    """Lowest and highest corner of each part that is drawn apart, `(2, 3)` mm."""
    return {
        part.name: np.reshape(manifold(part, 0.2).bounding_box(), (2, 3)) + explosion_offset(part, closed)
        for part in closed.parts
    }


@pytest.mark.parametrize("name", ["yamada-2002", "plain-ridges", "steep-fingertip", "bent"])
def test_parts_lie_clear_of_each_other_in_the_order_of_opening(name: str) -> None:
    closed = mold(three_ridges() if name == "bent" else skincad.load(name))
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
    closed = mold(skincad.load("steep-fingertip"))
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
