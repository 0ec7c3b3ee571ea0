"""Crests of a measured part: how much lower they lie than designed, and what is refused or warned of."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

import skincad
from skincad.base import InputError
from skincad.inputs import Design
from skincad.shape import crest_drops, shift_warnings


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
