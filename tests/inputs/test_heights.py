"""Heights of the ridges: one for all, one a ridge, or crests levelled by one number."""

from __future__ import annotations

import json
import math
from typing import Any

import pytest

import skincad
from skincad.base import InputError
from skincad.inputs import Design, load
from skincad.outputs import schema_of
from skincad.solids import scaled_for_shrinkage
from tests.refusals import refused

UNLIKE = [0.5, 0.52, 0.5, 0.48, 0.5, 0.5, 0.47, 0.5, 0.55]
TEXT = f"ridge.heights={UNLIKE}"


@pytest.mark.parametrize(
    ("ridge", "message"),
    [
        ({"heights": UNLIKE[:8]}, "ridge.heights: must be 9 values, one a ridge (ridge.count), got 8; give"),
        ({"heights": []}, "ridge.heights: must be 9 values, one a ridge (ridge.count), got 0; give"),
        ({"heights": 0.5}, "ridge.heights: must be a list (mm), got 0.5"),
        (
            {"heights": [*UNLIKE[:8], 0]},
            "ridge.heights: ridge 9 must be above 0 and at most 50 mm high, got 0",
        ),
        ({"heights": [-1.0, *UNLIKE[1:]]}, "ridge.heights: ridge 1 must be above 0 and at most 50 mm high"),
        ({"heights": [0.5, 51.0, *UNLIKE[2:]]}, "ridge.heights: ridge 2 must be above 0 and at most 50 mm"),
        ({"heights": [math.nan, *UNLIKE[1:]]}, "ridge 1 must be above 0 and at most 50 mm high, got nan"),
        (
            {"heights": [0.5, math.inf, *UNLIKE[2:]]},
            "ridge 2 must be above 0 and at most 50 mm high, got inf",
        ),
        ({"heights": [0.5, "a", *UNLIKE[2:]]}, "ridge 2 must be above 0 and at most 50 mm high, got 'a'"),
        ({"heights": [True, *UNLIKE[1:]]}, "ridge 1 must be above 0 and at most 50 mm high, got True"),
        (
            {"heights": UNLIKE, "height": 0.5},
            "ridge.height: must not be given beside ridge.heights, got 0.5;",
        ),
        ({"heights": UNLIKE, "levelling": 0.5}, "ridge.levelling: must not be given beside ridge.heights"),
        (
            {"height": None},
            "ridge.height: is missing; give ridge.height a value, or ridge.heights one a ridge",
        ),
        ({"levelling": 1.5}, "ridge.levelling: must be less than or equal to 1, got 1.5"),
        ({"levelling": -0.1}, "ridge.levelling: must be greater than or equal to 0, got -0.1"),
        ({"levellling": 0.5}, "ridge.levellling: unknown key; did you mean 'levelling'?"),
        (
            {"heights": [*UNLIKE[:6], 0.02, *UNLIKE[7:]]},
            "ridge.crown: must be less than 0.02 mm (the smaller of height of ridge 7 and half tip_width)",
        ),
    ],
)
def test_what_is_wrong_is_one_line_with_its_ridge(
    yamada: Design, ridge: dict[str, Any], message: str
) -> None:
    with refused(message):
        yamada.with_(ridge=ridge)


def test_all_at_the_same_height_is_the_height(yamada: Design) -> None:
    assert yamada.heights == yamada.with_(ridge={"heights": [0.5] * 9}).heights == (0.5,) * 9
    assert not yamada.with_(ridge={"heights": [0.5] * 9}).uneven
    assert yamada.with_(ridge={"levelling": 0.0}).heights == (0.5,) * 9


@pytest.mark.parametrize("count", [1, 2, 8, 9])
@pytest.mark.parametrize("share", [0.3, 1.0])
def test_levelling_makes_up_for_its_part_of_each_crests_drop(
    yamada: Design, count: int, share: float
) -> None:
    """By the circle of the crests: z = T - R (1 - cos a) + h cos a."""
    design = yamada.with_(ridge={"count": count, "levelling": share})

    def z(ridge: int, height: float) -> float:
        lean = (ridge - (count + 1) / 2) * 1.0 / 60.0
        return 4.0 - 60.0 * (1 - math.cos(lean)) + height * math.cos(lean)

    before = [z(ridge, 0.5) for ridge in range(1, count + 1)]
    after = [z(ridge, height) for ridge, height in enumerate(design.heights, 1)]
    wanted = [low + share * (max(before) - low) for low in before]
    assert after == pytest.approx(wanted, abs=1e-12)  # rounding of 60 mm times a cosine
    assert design.heights == design.heights[::-1]  # to the last digit: half the pad stands for both
    assert min(design.heights) == 0.5  # the highest stay as they are


def test_a_flat_skin_is_level_already(yamada: Design) -> None:
    flat = yamada.with_(skin={"curvature_radius": 1e8}, ridge={"levelling": 1.0})
    assert flat.heights == pytest.approx([0.5] * 9, abs=1e-7)  # 16 / 2e8 mm of drop at the outer ridges
    assert flat.heights[0] - 0.5 == pytest.approx(8e-8, rel=1e-6)  # and no digit of it is lost


@pytest.mark.parametrize(
    ("settings", "heights"),
    [
        ([TEXT], UNLIKE),
        (["ridge.height=0.6", TEXT], UNLIKE),
        ([TEXT, "ridge.height=0.6"], [0.6] * 9),
        (["ridge.levelling=0.5", TEXT], UNLIKE),
        (["ridge.count=2", "ridge.heights=[0.5, 0.6]"], [0.5, 0.6]),
        (["ridge.heights=[0.5, 0.6]", "ridge.count=2"], [0.5, 0.6]),
        ([TEXT, "ridge.height=0.6", "ridge.levelling=0.0"], [0.6] * 9),
    ],
)
def test_what_is_set_last_takes_the_others_place(settings: list[str], heights: list[float]) -> None:
    design = load("yamada-2002", settings)
    assert design.heights == tuple(heights)
    names = ["yamada-2002", *settings]
    assert load(names[0], names[1:]).to_toml() == design.to_toml()


def test_a_changed_copy_takes_the_others_place_too(yamada: Design) -> None:
    unlike = yamada.with_(ridge={"levelling": 0.5}).with_(ridge={"heights": UNLIKE})
    assert (unlike.ridge.height, unlike.ridge.levelling, unlike.heights) == (None, None, tuple(UNLIKE))
    back = unlike.with_(ridge={"height": 0.5})
    assert back == yamada
    levelled = unlike.with_(ridge={"height": 0.5, "levelling": 0.5})
    assert levelled == yamada.with_(ridge={"levelling": 0.5})
    with pytest.raises(InputError, match=r"ridge\.heights: must be 5 values, one a ridge"):
        unlike.with_(ridge={"count": 5})


@pytest.mark.parametrize("ridge", [{"heights": UNLIKE}, {"levelling": 0.3}])
def test_a_design_is_loaded_from_the_toml_that_it_writes(
    yamada: Design, ridge: dict[str, Any], tmp_path: Any
) -> None:
    design = yamada.with_(ridge=ridge)
    (tmp_path / "copy.toml").write_text(design.to_toml())
    again = skincad.load_design(tmp_path / "copy.toml")
    assert again == design
    assert hash(again) == hash(design)


def test_the_schema_asks_for_one_of_the_two() -> None:
    ridge = json.loads(schema_of("designs"))["$defs"]["Ridge"]
    assert ridge["oneOf"] == [{"required": ["height"]}, {"required": ["heights"]}]
    assert not {"height", "heights"} & {*ridge["required"]}


def test_what_is_poured_is_larger_by_the_shrinkage(yamada: Design) -> None:
    """Heights are lengths; levelling is a share, and a larger skin of the same share has the same shape."""
    for ridge in ({"heights": UNLIKE}, {"levelling": 0.3}):
        design = yamada.with_(ridge=ridge, mold={"shrinkage": 0.02})
        larger = [height / 0.98 for height in design.heights]
        assert scaled_for_shrinkage(design).heights == pytest.approx(larger, rel=1e-14)
