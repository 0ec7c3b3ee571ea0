"""Ridges of unlike height in the section; how much lower the crests of a measured part lie than designed."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import skincad
from skincad.base import InputError
from skincad.inputs import Design
from skincad.shape import Segment, crest_drops, section, shift_warnings, skin_of
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
        ({"ridge": {"heights": [*UNLIKE[:5], 0.155, *UNLIKE[6:]], "root_fillet": 0.45}},
         "ridge.root_fillet: ridge 6, 0.155 mm high: root and tip fillet need"),
        ({"ridge": {"heights": [*UNLIKE[:5], 0.04, *UNLIKE[6:]]}},
         "ridge.crown: ridge 6, 0.04 mm high: makes the crown's edges as steep"),
        ({"ridge": {"heights": [*UNLIKE[:6], 0.15, *UNLIKE[7:]]}},
         "slot: must lie inside the outline; S1 of ridge 7 crosses it"),
        ({"ridge": {"heights": [*UNLIKE[:6], 0.2, *UNLIKE[7:]]}},
         "slot.offset: leaves a wall to the outline at S1 of ridge 7 of 0.0"),
        ({"ridge": {"heights": [3.0, 0.5, *UNLIKE[2:]], "root_width": 0.97, "root_fillet": 0.05}},
         " mm at ridges 1 and 2, got 0.05"),
    ],
)  # fmt: skip
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


def summit(design: Design, ridge: int) -> float:
    """Height of a crest over the back, mm: all lie on one circle, pitch by pitch along the base circle."""
    skin, middle = design.skin, (design.ridge.count + 1) / 2
    lean = (ridge - middle) * design.ridge.pitch / skin.curvature_radius
    out = skin.curvature_radius + design.ridge.height
    return skin.thickness + design.ridge.height - out * (1 - math.cos(lean))


def measured(path: Path, design: Design, lower: list[float]) -> Path:
    """The crests of a part, as much lower than designed as said, in a file of another order."""
    rows = [f"{i},{summit(design, i) - drop!r}" for i, drop in enumerate(lower, 1)]
    path.write_text("ridge,crest_mm\n" + "\n".join(reversed(rows)))
    return path


@pytest.mark.parametrize("name", ["yamada-2002", "plain-ridges", "fingertip-soft"])
def test_drops_are_those_from_the_circle_of_the_crests(tmp_path: Path, name: str) -> None:
    design = skincad.load(name)
    lower = [0.01 * (-1) ** i * i for i in range(design.ridge.count)]
    drops = crest_drops(measured(tmp_path / "crests.csv", design, lower), design)
    assert drops == pytest.approx(lower, abs=1e-12)  # rounding of a height of some mm


@pytest.mark.parametrize("sign", [1, -1])
def test_a_crest_farther_off_than_a_ridge_is_high_is_refused_by_its_number(
    tmp_path: Path, yamada: Design, sign: int
) -> None:
    height = yamada.ridge.height
    lower = [0.0, sign * 0.9 * height, *[0.0] * 5, -sign * 1.1 * height, 0.0]
    path = measured(tmp_path / "crests.csv", yamada, lower)
    with pytest.raises(InputError) as refused:
        crest_drops(path, yamada)
    designed = summit(yamada, 8)
    assert "ridge 8" in str(refused.value)
    assert f"must be within {height:g} mm (ridge.height) of the designed {designed:.4g} mm" in str(
        refused.value
    )
    assert refused.value.value == pytest.approx(designed + sign * 1.1 * height, abs=1e-12)
    lower[7], lower[4] = (
        -sign * 0.999 * height,
        sign * height,
    )  # the middle one just as far: numbers are exact
    assert len(crest_drops(measured(path, yamada, lower), yamada)) == 9


def test_a_file_of_numbers_without_heights_is_refused(tmp_path: Path, yamada: Design) -> None:
    path = tmp_path / "crests.csv"
    path.write_text("ridge\n" + "\n".join(map(str, range(1, 10))))
    with pytest.raises(InputError, match="must give crest_mm of each ridge from 1 to 9 once"):
        crest_drops(path, yamada)


@pytest.mark.parametrize("thickness", [1.0, 4.0])
def test_a_shift_of_all_crests_by_more_than_a_fiftieth_of_the_thickness_is_told(
    yamada: Design, thickness: float
) -> None:
    """One crest alone, however low, is no shift: the median counts."""
    design = yamada.with_(
        skin={"thickness": thickness}, **{"slot": None, "film": None, "contact": {"film": None}}
    )
    most = 0.02 * thickness
    assert shift_warnings((), design) == ()
    assert shift_warnings((0.4, *[0.0] * 8), design) == ()
    for sign, side in ((1, "lower"), (-1, "higher")):
        assert shift_warnings((sign * most,) * 9, design) == ()
        (said,) = shift_warnings((sign * 1.01 * most,) * 8 + (-0.4 * sign,), design)
        assert f"the median crest lies {1.01 * most:.3g} mm {side} than designed" in said
        assert f"another thickness than the {thickness:g} mm" in said
