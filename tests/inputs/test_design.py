import math
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skincad
from skincad.base import LONGEST_LINE, MOST_TOLD, InputError, table_of
from skincad.inputs import Design, load, overridden
from skincad.inputs.material import silicone
from skincad.shape import section
from tests.refusals import refused_by


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
        (
            {"material": {"young_modulus": "soft"}},
            "material.young_modulus: must be a number or {value, low, high}",
        ),
        ({"ridge": 3}, "ridge: must be a table, [ridge], got 3"),
        ({"mold": {"wall": 1e300}}, "mold.wall: must be less than or equal to 500 (mm)"),
        (
            {"material": {"young_modulus": 1e-320}},
            "material.young_modulus: must be from 0.001 to 100 MPa, got",
        ),
        (
            {"material": {"young_modulus": {"value": 1.0, "low": 2.0, "high": 3.0}}},
            "material.young_modulus: needs",
        ),
        ({"mold": {"process": "fdmm"}}, "mold.process: must be 'fdm', 'sla', 'cnc' or 'edm', got 'fdmm'"),
        ({"name": "../../x"}, "name: "),
        ({"ridge": None}, "ridge: is missing"),
        ({"colour": "red"}, "colour: unknown key"),
    ],
)
def test_a_broken_rule_names_key_rule_value_and_remedy(yamada: Design, change: dict, message: str) -> None:
    with refused_by(message):
        yamada.with_(**change)


BROKEN = {  # rules that hang together with no other one: of fields, then between keys
    "skin.length": {"skin": {"length": -1.0}},
    "ridge.height": {"ridge": {"height": "high"}},
    "contact.force": {"contact": {"force": 0.0}},
    "film.lead": {"film": {"lead": 0.5}},
}
BETWEEN = {
    "mold.process": {"mold": {"process": "hot-wire"}},
    "mold.lid_process": {"mold": {"lid_process": "cold-wire"}},
    "ridge.count": {"ridge": {"count": 12}},
    "ridge.tip_width": {"ridge": {"tip_width": 0.8}},
    "ridge.tip_fillet": {"ridge": {"tip_fillet": 1e-9}},
    "film.thickness": {"film": {"thickness": 0.1}},
    "film.electrode_margin": {"film": {"electrode_margin": 0.125}},
}


@pytest.mark.parametrize("rules", [BROKEN, BETWEEN])
def test_all_broken_rules_are_told_in_one_line_the_first_as_it_is_alone(yamada: Design, rules: dict) -> None:
    """Mending the rule that is told first leaves the others told as before, down to the last one."""
    left = dict(rules)
    lines = []
    while left:
        changes: dict = {}
        for change in left.values():
            for table, values in change.items():
                changes[table] = {**changes.get(table, {}), **values}
        with pytest.raises(InputError) as refused:
            yamada.with_(**changes)
        errors = [refused.value, *refused.value.others]
        assert {error.key for error in errors} == set(left)
        assert "\n" not in str(refused.value)
        assert str(refused.value) == "; besides, ".join([*lines_of(errors)])
        lines.append(str(refused.value))
        del left[refused.value.key]
    assert all(before.endswith(after) for before, after in pairwise(lines))


def lines_of(told: list[InputError]) -> list[str]:
    return [str(InputError(error.key, error.rule, error.value, error.remedy)) for error in told]


def test_no_more_rules_are_told_than_can_be_read(yamada: Design) -> None:
    with pytest.raises(InputError) as refused:
        yamada.with_(ridge={f"key_{i}": 1.0 for i in range(1000)})
    assert len(refused.value.others) == MOST_TOLD - 1
    assert len(str(refused.value)) <= LONGEST_LINE


def test_a_key_is_not_missing_where_one_is_misspelt(yamada: Design) -> None:
    data = yamada.model_dump(exclude_none=True)
    data["ridge"]["heigth"] = data["ridge"].pop("height")
    del data["skin"]["length"]
    with pytest.raises(InputError) as refused:
        Design(**data)
    assert [e.key for e in (refused.value, *refused.value.others)] == ["ridge.heigth", "skin.length"]


def test_a_design_is_frozen_and_with_leaves_it_alone(yamada: Design) -> None:
    higher = yamada.with_(ridge={"height": 0.6})
    assert (yamada.ridge.height, higher.ridge.height) == (0.5, 0.6)
    with pytest.raises(ValueError, match="frozen"):
        yamada.ridge.height = 0.7  # type: ignore[misc]


def test_overrides_read_toml_values_in_order() -> None:
    design = load(
        "yamada-2002",
        [
            "ridge.height=0.55",
            "contact={force = 3.0}",
            "contact.force=5.0",
            'name="mine"',
            "mold.carrier=plain",
        ],
    )
    assert (design.ridge.height, design.name, design.mold.carrier) == (0.55, "mine", "plain")
    assert design.contact.force == 5.0
    bare = load("yamada-2002", ["film=none", "slot=none", "contact.film=none"])
    assert bare.slot is None
    assert bare.film_state == "loose"


def test_a_dropped_slot_takes_its_film_along(yamada: Design) -> None:
    for bare in (load("yamada-2002", ["slot=none"]), yamada.with_(slot=None)):
        assert (bare.slot, bare.film, bare.film_state) == (None, None, "loose")
    assert load("yamada-2002", ["film=none"]).film_state == "loose"


def test_another_silicone_brings_its_own_values(yamada: Design) -> None:
    for soft in (
        load("yamada-2002", ["material.name=ecoflex-00-30"]),
        yamada.with_(material={"name": "ecoflex-00-30"}),
    ):
        assert silicone(soft).young_modulus.value == 0.07
    changed = load("yamada-2002", ["material.young_modulus=0.06", "material.name=ecoflex-00-30"])
    assert silicone(changed).young_modulus.value == 0.06


@pytest.mark.parametrize(
    "text", ["ridge.height=1\nfoo=3", "ridge.height", "=1", "ridge..height=1", "name.x=1"]
)
def test_a_malformed_override_is_refused(text: str) -> None:
    with pytest.raises(InputError, match="settings"):
        load("yamada-2002", [text])


def test_overriding_does_not_touch_its_input() -> None:
    data = {"ridge": {"height": 1.0}}
    overridden(data, ["ridge.height=2.0"])
    assert data == {"ridge": {"height": 1.0}}


def test_own_values_lie_on_top_of_the_catalog(yamada: Design) -> None:
    named = silicone(yamada)
    assert (named.name, named.young_modulus.value, named.density) == ("dragon-skin-30", 0.8, 1080.0)
    unnamed = silicone(yamada.with_(material={"name": None, "young_modulus": 0.3}))
    assert (unnamed.young_modulus.low, unnamed.young_modulus.high) == (0.3, 0.3)
    with pytest.raises(InputError, match="did you mean 'dragon-skin-30'"):
        yamada.with_(material={"name": "dragonskin-30"})


numbers = st.floats(allow_nan=True, allow_infinity=True) | st.integers() | st.text(max_size=5) | st.none()


@settings(max_examples=300, deadline=None, derandomize=True)
@given(
    st.sampled_from([p for p, _ in fields(Design)]), st.one_of(numbers, st.floats(1e-3, 1e3)), st.booleans()
)
def test_any_single_value_gives_a_valid_section_or_an_input_error(
    path: tuple, value: object, twice: bool
) -> None:
    data = skincad.load("yamada-2002").model_dump(exclude_none=True)
    table = data
    for key in path[:-1]:
        table = table.setdefault(key, {})
    table[path[-1]] = value
    try:
        area = section(Design(**data)).area
    except InputError as refused:
        message = str(refused)
    else:
        message = ""
        assert math.isfinite(area)
        assert area > 0
    assert "\n" not in message
