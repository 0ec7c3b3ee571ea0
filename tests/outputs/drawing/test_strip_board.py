"""The board's footprint as an own small reader of its brackets has it."""

from __future__ import annotations

import re
from typing import Any

import pytest

import skincad
from skincad.fabrication import Job
from skincad.inputs import template_names
from skincad.outputs.drawing.flat import DRILL, FOOTPRINT_ROOM, strip_board
from skincad.solids.inserts import PITCH


def read(text: str) -> list[Any]:
    """A text of brackets as lists of words."""
    stack: list[list[Any]] = [[]]
    for token in re.findall(r'"[^"]*"|[()]|[^\s()]+', text):
        if token == "(":
            stack.append([])
        elif token == ")":
            expression = stack.pop()
            stack[-1].append(expression)
        else:
            stack[-1].append(token.strip('"'))
    (whole,) = stack[0]
    return whole


def pads(text: str) -> dict[str, tuple[float, float]]:
    rows = [row for row in read(text) if row[0] == "pad"]
    assert all(row[2:4] == ["thru_hole", "circle"] for row in rows)
    assert all(["drill", f"{DRILL:g}"] in row for row in rows)
    places = {row[1]: (float(row[4][1]), float(row[4][2])) for row in rows}
    assert len(places) == len(rows)  # no name twice
    return places


@pytest.mark.parametrize("name", [n for n in template_names() if skincad.load(n).film])
def test_each_strip_has_a_pin_for_each_face_in_its_own_column(name: str) -> None:
    design = skincad.load(name)
    places = pads(strip_board(Job(design)))
    labels = [f"{ridge}{side}" for ridge in range(1, design.ridge.count + 1) for side in ("S1", "S2")]
    assert set(places) == {f"{label}{sign}" for label in labels for sign in "+-"}
    for i, label in enumerate(labels):  # places have four decimals
        assert places[f"{label}+"][0] - places["1S1+"][0] == pytest.approx(PITCH * i, abs=2e-4)
        assert places[f"{label}-"][0] == places[f"{label}+"][0]
        assert places[f"{label}-"][1] - places[f"{label}+"][1] == pytest.approx(PITCH, abs=2e-4)  # y is down
    assert sum(x for x, _ in places.values()) == pytest.approx(0.0, abs=1e-3)
    (yard,) = (row for row in read(strip_board(Job(design))) if row[0] == "fp_rect")
    assert float(yard[2][1]) - max(x for x, _ in places.values()) == pytest.approx(FOOTPRINT_ROOM, abs=2e-4)


def test_seen_from_the_skin_end_a_has_its_strips_the_other_way_round() -> None:
    b, a = (pads(strip_board(Job(skincad.load("cast-in", [f'film.wiring_side="{s}"'])))) for s in "ba")
    assert b["1S1+"][0] < b["9S2+"][0]
    assert {name: (-x, y) for name, (x, y) in a.items()} == b


def test_no_film_no_board() -> None:
    with pytest.raises(ValueError, match="without film"):
        strip_board(Job(skincad.load("plain-ridges")))
