"""The opening's words and moves belong together."""

from __future__ import annotations

import pytest

import skincad
from skincad.fabrication import Job, casting_sheet, opening_steps
from skincad.solids import END_PLATES, PartRole
from skincad.solids.mold import mold

MOLDS = {
    "shims": ("yamada-2002", []),
    "cast in": ("cast-in", []),
    "no slots": ("plain-ridges", []),
    "split": ("steep-fingertip", []),
    "bent": ("yamada-2002", ["skin.curvature_radius_y=200"]),
}


@pytest.mark.parametrize("name", MOLDS)
def test_the_steps_make_each_move_once_in_the_molds_order(name: str) -> None:
    template, settings = MOLDS[name]
    design = skincad.load(template, settings)
    closed = mold(design)
    steps = opening_steps(Job(design, closed))
    assert [move for step in steps for move in step.moves] == list(closed.opening)
    sheet = casting_sheet(Job(design, closed), [], "", True)
    order = [sheet.index(step.words) for step in steps]
    assert order == sorted(order)
    for step in steps:
        roles = {closed.part(part).role for move in step.moves for part in move.parts}
        if roles & END_PLATES:
            assert "end plates" in step.words
        if PartRole.COVER in roles:
            assert "cover" in step.words
        if PartRole.SHIM in roles:
            assert "shim" in step.words.lower()


def test_no_strip_leaves_before_its_skin() -> None:
    design = skincad.load("cast-in")
    words, moves = opening_steps(Job(design))[0]
    assert "Take the weights off" in words
    assert moves == ()
