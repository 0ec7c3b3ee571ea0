"""A design's keys, the rules between them, its heights; what all that press a skin say of a bad one."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skincad
from skincad.base import LONGEST_LINE, MOST_TOLD, InputError, RefusedError, Stopwatch, table_of
from skincad.fabrication import Job
from skincad.inputs import Design, load, overridden
from skincad.material import small_strain_curve
from skincad.mechanics import film_stresses
from skincad.outputs import schema_of
from skincad.scenes import LEVELS, at_level, load_scene
from skincad.shape import section
from skincad.solids import scaled_for_shrinkage
from skincad.studies import scene_on
from tests.mechanics.designs import yamada
from tests.refusals import refused, refused_by


def fields(model: type, path: tuple[str, ...] = ()) -> list[tuple[tuple[str, ...], object]]:
    rows = []
    for key, field in model.model_fields.items():
        inner = table_of(model, key)
        rows += fields(inner, (*path, key)) if inner and key != "young_modulus" else [((*path, key), field)]
    return rows


def test_every_field_has_a_meaning_and_every_number_a_unit() -> None:
    for path, field in fields(Design):
        assert field.description, path
        if field.annotation in (float, int, float | None):
            assert field.json_schema_extra["unit"], path
    ridge = json.loads(schema_of("designs"))["$defs"]["Ridge"]
    assert ridge["oneOf"] == [{"required": ["height"]}, {"required": ["heights"]}]
    assert not {"height", "heights"} & {*ridge["required"]}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"ridge": {"heigth": 0.5}}, "ridge.heigth: unknown key; did you mean 'height'?"),
        ({"ridge": {"height": "0.5 mm"}}, "ridge.height: must be a number (mm), got '0.5 mm'"),
        ({"ridge": {"height": float("nan")}}, "ridge.height: must be a finite number (mm), got nan"),
        ({"ridge": {"height": math.inf}}, "ridge.height: must be a finite number (mm), got inf"),
        ({"ridge": {"height": -0.5}}, "ridge.height: must be greater than 0 (mm), got -0.5"),
        ({"ridge": {"height": True}}, "ridge.height: must be a number (mm), got True"),
        ({"ridge": {"count": 10**9}}, "ridge.count: must be less than or equal to 999, got 1000000000"),
        ({"ridge": {"count": 2.5}}, "ridge.count: must be an integer"),
        ({"ridge": {"root_width": 1.2}}, "ridge.root_width: must be less than 1 mm (ridge.pitch), got 1.2"),
        ({"ridge": {"tip_width": 0.8}}, "ridge.tip_width: must be at most 0.75 mm"),
        ({"ridge": {"crown": 0.3}}, "ridge.crown: must be less than 0.25 mm"),
        ({"ridge": {"count": 12}}, "ridge.count: at most 11 ridges"),
        ({"skin": {"curvature_radius": 7.0}}, "skin.width: the fan from side to side must stay below 90"),
        ({"skin": {"curvature_radius": 9.0, "thickness": 2.0}}, "skin.thickness: must be above"),
        ({"film": {"thickness": 0.1}}, "film.thickness: must be at most 0.05 mm (slot.thickness), got 0.1"),
        ({"slot": None, "film": {"thickness": 0.028}}, "film: needs a slot to lie in"),
        ({"film": None, "contact": {"film": "bonded"}}, "contact.film: 'bonded' needs a [film]"),
        ({"ridge": {"heigth": 0.5, "height": None}}, "ridge.heigth: unknown key; did you mean 'height'?"),
        ({"material": {"young_modulus": "soft"}},
         "material.young_modulus: must be a number or {value, low, high}"),
        ({"ridge": 3}, "ridge: must be a table, [ridge], got 3"),
        ({"mold": {"wall": 1e300}}, "mold.wall: must be less than or equal to 500 (mm)"),
        ({"material": {"young_modulus": 1e-320}},
         "material.young_modulus: must be from 0.001 to 100 MPa, got"),
        ({"material": {"young_modulus": {"value": 1.0, "low": 2.0, "high": 3.0}}},
         "material.young_modulus: needs"),
        ({"mold": {"process": "fdmm"}}, "mold.process: must be 'fdm', 'sla', 'cnc' or 'edm', got 'fdmm'"),
        ({"name": "../../x"}, "name: "),
        ({"ridge": None}, "ridge: is missing"),
        ({"colour": "red"}, "colour: unknown key"),
        ({"skin": {"curvature_radius_y": 4.9}}, "skin.curvature_radius_y: must be at least 5 mm, or the"),
        ({"skin": {"curvature_radius_y": 7.0}},
         "skin.length: the fan from end to end must stay below 90 degrees, so below 11 mm, got 12"),
        ({"skin": {"curvature_radius_y": 0.5}}, "skin.curvature_radius_y: must be greater than or equal to"),
        ({"skin": {"curvature_radius_y": 1e9}}, "skin.curvature_radius_y: must be less than or equal to 1"),
        ({"mold": {"method": "cast-in"}, "skin": {"curvature_radius_y": 60.0}},
         "mold.method: needs straight strips, and skin.curvature_radius_y bends them, got 'cast-in'; drop"),
    ],
)  # fmt: skip
def test_a_broken_rule_names_key_rule_value_and_remedy(yamada: Design, change: dict, message: str) -> None:
    with refused_by(message):
        yamada.with_(**change)


# rules that hang together with no other one: of fields, then between keys
BROKEN = {"skin.length": -1.0, "ridge.height": "high", "contact.force": 0.0, "film.lead": 0.5}
BETWEEN = {"mold.process": "hot-wire", "mold.lid_process": "cold-wire", "ridge.count": 12}
BETWEEN |= {"ridge.tip_width": 0.8, "ridge.tip_fillet": 1e-9, "film.thickness": 0.1}
BETWEEN |= {"film.electrode_margin": 0.125}


@pytest.mark.parametrize("rules", [BROKEN, BETWEEN])
def test_all_broken_rules_are_told_in_one_line_the_first_as_it_is_alone(yamada: Design, rules: dict) -> None:
    """Mending the rule that is told first leaves the others told as before, down to the last one."""
    left = dict(rules)
    lines = []
    while left:
        changes: dict = {}
        for key, value in left.items():
            table, _, name = key.partition(".")
            changes.setdefault(table, {})[name] = value
        with pytest.raises(InputError) as refused:
            yamada.with_(**changes)
        errors = [refused.value, *refused.value.others]
        assert {error.key for error in errors} == set(left)
        assert "\n" not in str(refused.value)
        alone = [str(InputError(error.key, error.rule, error.value, error.remedy)) for error in errors]
        assert str(refused.value) == "; besides, ".join(alone)
        lines.append(str(refused.value))
        del left[refused.value.key]
    assert all(before.endswith(after) for before, after in pairwise(lines))


def test_few_rules_are_told_and_no_misspelt_key_is_missing(
    yamada: Design,
) -> None:
    with pytest.raises(InputError) as refused:
        yamada.with_(ridge={f"key_{i}": 1.0 for i in range(1000)})
    assert len(refused.value.others) == MOST_TOLD - 1
    assert len(str(refused.value)) <= LONGEST_LINE
    data = yamada.model_dump(exclude_none=True)
    data["ridge"]["heigth"] = data["ridge"].pop("height")
    del data["skin"]["length"]
    with pytest.raises(InputError) as refused:
        Design(**data)
    assert [e.key for e in (refused.value, *refused.value.others)] == ["ridge.heigth", "skin.length"]


def test_a_pins_crown_that_is_next_to_nothing_is_refused() -> None:
    """The sphere of a crown of 1e-308 mm has no radius that a float holds."""
    with pytest.raises(InputError, match=r"pin.crown: must be 0, or at least 1e-09 mm, got 1e-308; take 0"):
        skincad.load("pillars-9").with_(pin={"crown": 1e-308})
    assert skincad.load("pillars-9").with_(pin={"crown": 0.0}).pin.crown == 0.0


def test_a_design_is_frozen_and_with_leaves_it_alone(yamada: Design) -> None:
    higher = yamada.with_(ridge={"height": 0.6})
    assert (yamada.ridge.height, higher.ridge.height) == (0.5, 0.6)
    with pytest.raises(ValueError, match="frozen"):
        yamada.ridge.height = 0.7


def test_overrides_read_toml_values_in_order(yamada: Design) -> None:
    settings = ["ridge.height=0.55", "contact={force = 3.0}", "contact.force=5.0", 'name="mine"']
    design = load("yamada-2002", [*settings, "mold.carrier=plain"])
    assert (design.ridge.height, design.name, design.mold.carrier) == (0.55, "mine", "plain")
    assert design.contact.force == 5.0
    bare = load("yamada-2002", ["film=none", "slot=none", "contact.film=none"])
    assert (bare.slot, bare.film_state) == (None, "loose")
    data = {"ridge": {"height": 1.0}}
    overridden(data, ["ridge.height=2.0"])
    assert data == {"ridge": {"height": 1.0}}
    for bare in (load("yamada-2002", ["slot=none"]), yamada.with_(slot=None)):
        assert (bare.slot, bare.film, bare.film_state) == (None, None, "loose")
    assert load("yamada-2002", ["film=none"]).film_state == "loose"


@pytest.mark.parametrize(
    "text", ["ridge.height=1\nfoo=3", "ridge.height", "=1", "ridge..height=1", "name.x=1"]
)
def test_a_malformed_override_is_refused(text: str) -> None:
    with pytest.raises(InputError, match="settings"):
        load("yamada-2002", [text])


def test_own_values_lie_on_top_of_the_catalog(yamada: Design) -> None:
    named = Job(yamada).silicone
    assert (named.name, named.young_modulus.value, named.density) == ("dragon-skin-30", 0.8, 1080.0)
    unnamed = Job(yamada.with_(material={"name": None, "young_modulus": 0.3})).silicone
    assert (unnamed.young_modulus.low, unnamed.young_modulus.high) == (0.3, 0.3)
    with pytest.raises(InputError, match="did you mean 'dragon-skin-30'"):
        yamada.with_(material={"name": "dragonskin-30"})
    for soft in (
        load("yamada-2002", ["material.name=ecoflex-00-30"]),
        yamada.with_(material={"name": "ecoflex-00-30"}),
    ):
        assert Job(soft).silicone.young_modulus.value == 0.07
    changed = load("yamada-2002", ["material.young_modulus=0.06", "material.name=ecoflex-00-30"])
    assert Job(changed).silicone.young_modulus.value == 0.06


numbers = st.floats(allow_nan=True, allow_infinity=True) | st.integers() | st.text(max_size=5) | st.none()
single_values = given(
    st.sampled_from([p for p, _ in fields(Design)]), st.one_of(numbers, st.floats(1e-3, 1e3))
)


def assert_section_or_one_line(path: tuple, value: object) -> None:
    data = skincad.load("yamada-2002").model_dump(exclude_none=True)
    table = data
    for key in path[:-1]:
        table = table.setdefault(key, {})
    table[path[-1]] = value
    message = ""
    try:
        assert 0.0 < section(Design(**data)).area < math.inf
    except InputError as refusal:
        message = str(refusal)
    assert "\n" not in message


@settings(max_examples=80, deadline=None, derandomize=True)
@single_values
def test_any_single_value_gives_a_valid_section_or_an_input_error(path: tuple, value: object) -> None:
    assert_section_or_one_line(path, value)


@pytest.mark.evidence(subject="seeds: single values")
@settings(max_examples=1000, deadline=None, derandomize=True)
@single_values
def test_any_of_many_single_values_does(path: tuple, value: object) -> None:
    assert_section_or_one_line(path, value)


UNLIKE = [0.5, 0.52, 0.5, 0.48, 0.5, 0.5, 0.47, 0.5, 0.55]
TEXT = f"ridge.heights={UNLIKE}"


@pytest.mark.parametrize(
    ("ridge", "message"),
    [
        ({"heights": UNLIKE[:8]}, "ridge.heights: must be 9 values, one a ridge (ridge.count), got 8; give"),
        ({"heights": []}, "ridge.heights: must be 9 values, one a ridge (ridge.count), got 0; give"),
        ({"heights": 0.5}, "ridge.heights: must be a list (mm), got 0.5"),
        ({"heights": [*UNLIKE[:8], 0]},
         "ridge.heights: ridge 9 must be above 0 and at most 50 mm high, got 0"),
        ({"heights": [-1.0, *UNLIKE[1:]]}, "ridge.heights: ridge 1 must be above 0 and at most 50 mm high"),
        ({"heights": [0.5, 51.0, *UNLIKE[2:]]}, "ridge.heights: ridge 2 must be above 0 and at most 50 mm"),
        ({"heights": [math.nan, *UNLIKE[1:]]}, "ridge 1 must be above 0 and at most 50 mm high, got nan"),
        ({"heights": [0.5, math.inf, *UNLIKE[2:]]},
         "ridge 2 must be above 0 and at most 50 mm high, got inf"),
        ({"heights": [0.5, "a", *UNLIKE[2:]]}, "ridge 2 must be above 0 and at most 50 mm high, got 'a'"),
        ({"heights": [True, *UNLIKE[1:]]}, "ridge 1 must be above 0 and at most 50 mm high, got True"),
        ({"heights": UNLIKE, "height": 0.5},
         "ridge.height: must not be given beside ridge.heights, got 0.5;"),
        ({"heights": UNLIKE, "levelling": 0.5}, "ridge.levelling: must not be given beside ridge.heights"),
        ({"height": None},
         "ridge.height: is missing; give ridge.height a value, or ridge.heights one a ridge"),
        ({"levelling": 1.5}, "ridge.levelling: must be less than or equal to 1, got 1.5"),
        ({"levelling": -0.1}, "ridge.levelling: must be greater than or equal to 0, got -0.1"),
        ({"levellling": 0.5}, "ridge.levellling: unknown key; did you mean 'levelling'?"),
        ({"heights": [*UNLIKE[:6], 0.02, *UNLIKE[7:]]},
         "ridge.crown: must be less than 0.02 mm (the smaller of height of ridge 7 and half tip_width)"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_a_line_with_its_ridge(yamada: Design, ridge: dict[str, Any], message: str) -> None:
    with refused(message):
        yamada.with_(ridge=ridge)


@pytest.mark.parametrize("count", [1, 2, 8, 9])
@pytest.mark.parametrize("share", [0.3, 1.0])
def test_levelling_makes_up_for_a_part_of_the_drop(yamada: Design, count: int, share: float) -> None:
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


@pytest.mark.parametrize(
    ("settings", "heights"),
    [
        (["ridge.height=0.6", TEXT], UNLIKE),
        ([TEXT, "ridge.height=0.6"], [0.6] * 9),
        (["ridge.levelling=0.5", TEXT], UNLIKE),
        (["ridge.count=2", "ridge.heights=[0.5, 0.6]"], [0.5, 0.6]),
        (["ridge.heights=[0.5, 0.6]", "ridge.count=2"], [0.5, 0.6]),
        ([TEXT, "ridge.height=0.6", "ridge.levelling=0.0"], [0.6] * 9),
    ],
)
def test_what_is_set_last_takes_the_others_place(settings: list[str], heights: list[float]) -> None:
    assert load("yamada-2002", settings).heights == tuple(heights)


def test_a_changed_copy_takes_the_others_place_too(yamada: Design) -> None:
    unlike = yamada.with_(ridge={"levelling": 0.5}).with_(ridge={"heights": UNLIKE})
    assert (unlike.ridge.height, unlike.ridge.levelling, unlike.heights) == (None, None, tuple(UNLIKE))
    back = unlike.with_(ridge={"height": 0.5})
    assert back == yamada
    levelled = unlike.with_(ridge={"height": 0.5, "levelling": 0.5})
    assert levelled == yamada.with_(ridge={"levelling": 0.5})
    with pytest.raises(InputError, match=r"ridge\.heights: must be 5 values, one a ridge"):
        unlike.with_(ridge={"count": 5})
    assert yamada.heights == yamada.with_(ridge={"heights": [0.5] * 9}).heights == (0.5,) * 9
    assert not yamada.with_(ridge={"heights": [0.5] * 9}).uneven
    assert yamada.with_(ridge={"levelling": 0.0}).heights == (0.5,) * 9
    flat = yamada.with_(skin={"curvature_radius": 1e8}, ridge={"levelling": 1.0})
    assert flat.heights == pytest.approx([0.5] * 9, abs=1e-7)  # 16 / 2e8 mm of drop at the outer ridges
    assert flat.heights[0] - 0.5 == pytest.approx(8e-8, rel=1e-6)  # and no digit of it is lost


@pytest.mark.parametrize("ridge", [{"heights": UNLIKE}, {"levelling": 0.3}])
def test_heights_are_written_and_grow_with_the_shrinkage(yamada: Design, ridge: dict, tmp_path: Any) -> None:
    """Heights are lengths; levelling is a share, and a larger skin of the same share has the same shape."""
    design = yamada.with_(ridge=ridge, mold={"shrinkage": 0.02})
    (tmp_path / "copy.toml").write_text(design.to_toml())
    again = skincad.load_design(tmp_path / "copy.toml")
    assert again == design
    assert hash(again) == hash(design)
    larger = [height / 0.98 for height in design.heights]
    assert scaled_for_shrinkage(design).heights == pytest.approx(larger, rel=1e-14)


def small(**change: dict[str, object]) -> Design:
    """One ridge, slots full of silicone."""
    tables = {"skin": {}, "ridge": {}, **change}
    tables["skin"] = {"width": 3.0, **tables["skin"]}
    tables["ridge"] = {"count": 1, **tables["ridge"]}
    return yamada().with_(film=None, contact={"film": "ignored"}, **tables)


def by_check(design: Design, force: float, folder: Path) -> str:
    return skincad.check(design, force=force, model="linear", tol=0.05).out_of_range


def by_scene(design: Design, force: float, folder: Path) -> str:
    """Pressed within eight steps."""
    (folder / "skin.toml").write_text(design.to_toml())
    settings = [f"skin={(folder / 'skin.toml').as_posix()!r}", f"history.normal_force_N=[0.0, {force}]"]
    settings += ["history.steps=8", "effects.film=none", "readout.ridges=[]"]
    march = at_level(load_scene("yamada-2002-press", settings), LEVELS[0]).march
    return march.stopped or "" if march.failed else ""


def by_film(design: Design, force: float, folder: Path) -> str:
    film_stresses(design, force, tol=0.5)
    return ""


def by_fit(design: Design, force: float, folder: Path) -> str:
    """A pad's curve ends before the force."""
    last = float(small_strain_curve(design, 0.8, Stopwatch(None)).force[-1])
    return f"ends at {last:g} N" if last < force else ""


def by_ladder(design: Design, force: float, folder: Path) -> str:
    """The scene that `accuracy` marches, with the design's own force."""
    march = at_level(scene_on(design.with_(contact={"force": force}), "history.steps=40"), LEVELS[0]).march
    return march.stopped or "" if march.failed else ""


WAYS: dict[str, Callable[[Design, float, Path], str]] = {"check": by_check, "simulate": by_scene}
WAYS |= {"film stress": by_film, "fit-material": by_fit, "accuracy": by_ladder}
BAD: dict[str, tuple[dict[str, dict[str, object]], float]] = {
    "pressed flat": ({}, 1e4),
    "strained": ({"skin": {"curvature_radius": 4.0, "thickness": 5.0}}, 20.0),
    "buckled": ({"ridge": {"height": 4.0}, "skin": {"curvature_radius": 6.0}}, 10.0),
    "more force than there is": ({}, 1e300),
}
SLOW = {"fit-material", "film stress"}  # solve a solid, films


@pytest.mark.parametrize("case", BAD)
@pytest.mark.parametrize("way", [pytest.param(w, marks=[pytest.mark.slow] * (w in SLOW)) for w in WAYS])
def test_each_way_refuses_or_says_that_it_is_beyond(way: str, case: str, tmp_path: Path) -> None:
    change, force = BAD[case]
    try:
        answer = WAYS[way](small(**change), force, tmp_path)
    except (InputError, RefusedError) as refusal:
        answer = str(refusal)
    assert answer, f"{way} takes it"


@pytest.mark.parametrize("way", ["check", "simulate", pytest.param("film stress", marks=pytest.mark.slow)])
def test_a_good_one_is_taken(way: str, tmp_path: Path) -> None:
    assert WAYS[way](small(), 0.4, tmp_path) == ""


@pytest.mark.parametrize("table", ["material", "film"])
def test_no_stuff_is_taken_as_incompressible_or_beyond(table: str) -> None:
    """At 0.5 a bulk modulus has no bound, above it is negative."""
    for ratio in (0.0, 0.3, 0.49):
        assert yamada().with_(**{table: {"poisson_ratio": ratio}})
    for wrong in (-0.01, 0.5, 0.51, 1.0):
        with pytest.raises(InputError, match=rf"^{table}\.poisson_ratio: must be"):
            yamada().with_(**{table: {"poisson_ratio": wrong}})
