"""Ridges of unlike height in the section, and what it guards of each."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from skincad.base import InputError
from skincad.inputs import Design
from skincad.shape import Segment, crest_drops, section, skin_of
from tests.refusals import refused

UNLIKE = [0.5, 0.52, 0.5, 0.48, 0.5, 0.5, 0.47, 0.5, 0.55]


def crown(design: Design, ridge: int) -> Segment:
    (segment,) = (s for s in section(design).outline if s.kind == "crown" and s.feature == ridge)
    return segment


@pytest.mark.parametrize("ridge", [{"heights": UNLIKE}, {"levelling": 0.7}, {"levelling": 1.0}])
def test_each_summit_stands_its_height_over_the_base_circle(yamada: Design, ridge: dict[str, Any]) -> None:
    design = yamada.with_(ridge=ridge)
    for number, height in enumerate(design.heights, 1):
        lean = (number - 5) / 60
        x, z = crown(design, number).point(0.5)
        assert x == pytest.approx((60 + height) * math.sin(lean), abs=1e-12)  # rounding of 60 mm
        assert z == pytest.approx(4 - 60 + (60 + height) * math.cos(lean), abs=1e-12)
        assert skin_of(design).crests[number - 1] == pytest.approx(z, abs=1e-12)


def test_ridges_of_the_same_height_have_the_same_section(yamada: Design) -> None:
    assert section(yamada.with_(ridge={"heights": [0.5] * 9})) == section(yamada)


def test_a_ridge_is_as_on_a_skin_of_its_height(yamada: Design) -> None:
    unlike = section(yamada.with_(ridge={"heights": UNLIKE})).outline
    for number, height in enumerate(UNLIKE, 1):
        alike = section(yamada.with_(ridge={"height": height})).outline
        assert [s for s in unlike if s.feature == number] == [s for s in alike if s.feature == number]
    assert all(a.end == b.start for a, b in zip(unlike, (*unlike[1:], unlike[0]), strict=True))


def test_reversed_heights_mirror_the_section(yamada: Design) -> None:
    one, other = (
        np.array([[*s.start, s.bulge] for s in section(yamada.with_(ridge={"heights": heights})).outline])
        for heights in (UNLIKE, UNLIKE[::-1])
    )
    images = {tuple(np.round(row, 12) + 0.0) for row in one[:, :2] * [-1.0, 1.0]}
    assert images == {tuple(np.round(row, 12) + 0.0) for row in other[:, :2]}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"ridge": {"heights": [*UNLIKE[:5], 0.155, *UNLIKE[6:]], "root_fillet": 0.45}},
            "ridge.root_fillet: ridge 6, 0.155 mm high: root and tip fillet need",
        ),
        (
            {"ridge": {"heights": [*UNLIKE[:5], 0.04, *UNLIKE[6:]]}},
            "ridge.crown: ridge 6, 0.04 mm high: makes the crown's edges as steep",
        ),
        (
            {"ridge": {"heights": [*UNLIKE[:6], 0.15, *UNLIKE[7:]]}},
            "slot: must lie inside the outline; S1 of ridge 7 crosses it",
        ),
        (
            {"ridge": {"heights": [*UNLIKE[:6], 0.2, *UNLIKE[7:]]}},
            "slot.offset: leaves a wall to the outline at S1 of ridge 7 of 0.0",
        ),
        (
            {"ridge": {"heights": [3.0, 0.5, *UNLIKE[2:]], "root_width": 0.97, "root_fillet": 0.05}},
            " mm at ridges 1 and 2, got 0.05",
        ),
    ],
)
def test_what_does_not_fit_names_its_ridge(yamada: Design, change: dict[str, Any], message: str) -> None:
    with refused(message):
        section(yamada.with_(**change))


def test_a_measured_crest_is_held_against_its_own_ridge(yamada: Design, tmp_path: Any) -> None:
    design = yamada.with_(ridge={"heights": [*UNLIKE[:8], 1.0]})
    lower = [0.01, -0.02, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.6]  # the last would be too much of 0.5 mm
    rows = [
        f"{i},{z - drop!r}" for i, (z, drop) in enumerate(zip(skin_of(design).crests, lower, strict=True), 1)
    ]
    (tmp_path / "crests.csv").write_text("ridge,crest_mm\n" + "\n".join(rows))
    assert crest_drops(tmp_path / "crests.csv", design) == pytest.approx(lower, abs=1e-12)
    (tmp_path / "crests.csv").write_text(
        "ridge,crest_mm\n" + "\n".join([*rows[:7], "8,3.7", f"9,{skin_of(design).crests[8] - 0.95!r}"])
    )
    with pytest.raises(InputError, match=r"ridge 8: must be within 0\.5 mm \(ridge\.heights\)"):
        crest_drops(tmp_path / "crests.csv", design)


def test_the_skin_is_as_high_as_at_its_highest_crest(yamada: Design) -> None:
    assert skin_of(yamada).height == 4.5
    assert skin_of(yamada.with_(ridge={"levelling": 0.9})).height == 4.5  # outer ridges are higher, and lower
    assert skin_of(yamada.with_(ridge={"heights": [*UNLIKE[:8], 0.8]})).height == 4.8
