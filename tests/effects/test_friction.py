"""Laws of friction as a scene names them: their keys, their energy, and which ridge slips first."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from skincad.base import InputError
from skincad.effects import CondensedPad, Friction, MarchedPad, PlatePath, SmallStrain, Term
from skincad.mechanics import ContactPad, FrictionCoefficients
from skincad.scenes import load_scene
from skincad.scenes.march import march
from tests.effects.test_all_effects import COMPANIONS, built, dragged_through_gross_slip, piece
from tests.refusals import refused

SHEAR = {"law": "shear", "shear_stress": 0.1, "coefficient": 1.5}
TABLE = {"law": "table", "table": [[0.02, 1.5], [0.1, 0.8], [0.5, 0.3]]}
KINETIC = {**SHEAR, "kinetic": 1.2}


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({}, "coefficient: is missing; give coefficient a value"),
        ({"law": "amontons"}, "law: must be 'coulomb', 'shear' or 'table', got 'amontons'"),
        ({"law": "shear", "shear_stress": 0.1}, "coefficient: is missing, which law = shear asks for"),
        ({"law": "shear", "coefficient": 1.0}, "shear_stress: is missing, which law = shear asks for"),
        ({"law": "table"}, "table: is missing, which law = table asks for; give table a value"),
        ({**SHEAR, "shear_stress": 0.0}, "shear_stress: must be greater than 0 (MPa), got 0"),
        ({**SHEAR, "coefficient": 0.0}, "coefficient: must be at least 1e-06 with law = shear, got 0"),
        ({**SHEAR, "kinetic": 1.6}, "kinetic: must be at most coefficient, got 1.6"),
        (
            {"coefficient": 1.0, "shear_stress": 0.1},
            "shear_stress: has no effect with law = coulomb, got 0.1; take law = shear",
        ),
        ({"coefficient": 1.0, "table": [[0.1, 1.0]]}, "table: has no effect with law = coulomb"),
        ({**TABLE, "coefficient": 1.0}, "coefficient: has no effect with law = table, got 1; leave it out"),
        ({**TABLE, "kinetic": 1.6}, "kinetic: must be at most the table's first coefficient, 1.5, got 1.6"),
        ({"law": "table", "table": []}, "table: "),
        ({"law": "table", "table": [[0.1, 1.0, 2.0]]}, "table.0: "),
        ({"law": "table", "table": [[0.0, 1.0]]}, "table: needs pressures above 0 up to 1000 MPa"),
        ({"law": "table", "table": [[0.1, 0.0]]}, "table: needs pressures above 0 up to 1000 MPa"),
        ({"law": "table", "table": [[0.1, 21.0]]}, "coefficients above 0 up to 20, got [0.1, 21.0]"),
        (
            {"law": "table", "table": [[0.2, 1.0], [0.1, 1.2]]},
            "table: needs pressures that rise, got [0.1, 1.2]; put it before [0.2, 1.0]",
        ),
        (
            {"law": "table", "table": [[0.1, 1.0], [0.4, 0.2]]},
            "got [0.4, 0.2]; take a coefficient of at least 0.25 there",
        ),
    ],
)
def test_bad_tables_are_told_in_one_line(table: dict[str, Any], words: str) -> None:
    with refused(words):
        Friction(**table)


def test_a_scene_tells_the_key_with_its_table() -> None:
    words = "effects.friction.shear_stress: is missing, which law = shear asks for"
    with pytest.raises(InputError, match=words):
        load_scene("yamada-2002-slip", ["effects.friction.law=shear"])


def test_a_constant_shear_stress_is_a_table_of_one_pair() -> None:
    pair = [SHEAR["shear_stress"] / SHEAR["coefficient"], SHEAR["coefficient"]]  # type: ignore[operator]
    by_table = Friction(law="table", table=[pair]).cone
    assert Friction(**SHEAR).cone.breakpoints[0] == pytest.approx(by_table.breakpoints[0], rel=1e-15)
    assert Friction(coefficient=0.6, kinetic=0.5).cone == FrictionCoefficients(0.6, 0.5)
    assert Friction(**KINETIC).cone.kinetic == 1.2


def pads() -> dict[str, tuple[MarchedPad, list[Term]]]:
    """Small strain at rest, with a past, with masses: friction's own term left out."""
    cases: dict[str, tuple[MarchedPad, list[Term]]] = {
        "small_strain": (SmallStrain().marched(*piece(), 2, True, []), [])
    }
    for name in ("viscosity", *COMPANIONS):
        model, terms = built(name, {})
        cases[name] = model, [term for term in terms if not isinstance(term, Friction)]
    return cases


LAWS = {"shear": SHEAR, "kinetic": KINETIC, "table": TABLE}
# each law and each pad once; evidence goes through all nine pairs
PAIRS = {("small_strain", "kinetic"), ("viscosity", "table"), ("inertia", "shear")}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "law"),
    [
        pytest.param(
            *(name, law),
            marks=[] if (name, law) in PAIRS else pytest.mark.evidence(subject="laws of friction"),
        )
        for name in ("small_strain", "viscosity", "inertia")
        for law in LAWS
    ],
)
def test_work_is_stored_moves_or_is_lost(name: str, law: str) -> None:
    """To 1e-3 as by Coulomb's law; where points break off from static friction, what they lose within the
    step is straight in it: 1e-2."""
    (pad, others), table = pads()[name], LAWS[law]
    within = 1e-2 if "kinetic" in table else 1e-3
    run = dragged_through_gross_slip(pad, [Friction(**table), *others], within)
    normal, tangential = run.column("normal"), run.column("tangential")
    assert abs(tangential[-1]) < 0.95 * 1.5 * normal[-1]  # the law's cap is at work


@pytest.mark.evidence(subject="laws of friction")
def test_finite_strain_slips_by_area() -> None:
    """Dragged through gross slip, each point bears what the law says of it: 1e-9 of the largest, for the
    contact is solved on the last tangent but one."""
    scene = load_scene(
        "yamada-2002-press",
        [
            "effects.finite_strain={}",
            "effects.friction.law=shear",
            "effects.friction.shear_stress=0.05",
            "history.steps=8",
            "history.time_s=[0, 1, 2]",
            "history.normal_force_N=[0, 0.66, 0.66]",
            "history.tangential_force_N=none",
            "history.displacement_mm=[0, 0, 0.4]",
        ],
    )
    pad = scene.law.marched(replace(piece()[0]), piece()[1], 2, False, scene.terms)
    state = march(pad, scene.history.times, scene.history.drives(), scene.terms, keep=[8])
    assert state.stopped is None
    contact_state = state.states[8].contact
    assert contact_state.slips[contact_state.touches].all()
    most = 0.05 * pad.pad.area
    borne = np.minimum(contact_state.normal, most)
    assert contact_state.tangential == pytest.approx(borne, abs=1e-9 * contact_state.normal.max())
    assert (contact_state.normal > most).sum() >= 3


def test_every_kind_of_pad_has_the_same_area() -> None:
    """Two ridges' arcs, some 0.55 mm each, times 12 mm of length; 1e-9: halved or not, the same mesh."""
    crowns = [pad.discretisation.area.sum() for pad, _ in pads().values()]
    assert crowns == pytest.approx(3 * [crowns[0]], rel=1e-9)
    assert crowns[0] == pytest.approx(2 * 0.55 * piece()[0].whole.length, rel=0.02)


def path(normal: list[float], pull: list[float], area: list[float], slips: list[bool]) -> PlatePath:
    """Unloaded, pressed, pulled so far that ridges slip next, and with the slips."""
    rows = [np.zeros(len(normal)), np.array(normal), np.array(normal), np.array(normal)]
    along = [0 * rows[1], 0 * rows[1], np.array(pull), 1.05 * np.array(pull)]
    none = np.zeros(len(normal), dtype=bool)
    touched = np.array([none, none, none, none], dtype=float)
    touched[1:] = area
    slipping, nothing = np.array([none, none, none, slips], dtype=float), np.zeros(4)
    loads = np.array(rows), np.array(along)
    return PlatePath(np.arange(4.0), nothing, nothing, *loads, slipping, np.zeros((4, 0)), touched)


def test_the_order_of_slip_flips_where_load_and_area_do_not_go_together() -> None:
    """Ridge 1 bears 0.5 of its load and 0.05 MPa; ridge 2 0.4 of its, but 0.1 MPa."""
    loads = [0.4, 1.0, 1.0], [0.2, 0.4, 0.3], [4.0, 4.0, 4.0]
    seen = path(*loads, [True, False, False])
    entries = list(Friction(coefficient=0.5).afterwards(seen))
    assert entries == [
        "the order of slip rests on effects.friction.law: ridge 1 slips first, "
        "but by a constant shear stress ridge 2 would"
    ]
    other_way = path(*loads, [False, True, False])
    (entry,) = Friction(**SHEAR).afterwards(other_way)
    assert "ridge 2 slips first, but by Coulomb's law ridge 1 would" in entry


def warned(seen: PlatePath) -> list[str]:
    return list(Friction(coefficient=0.5).afterwards(seen))


def test_the_order_of_slip_is_not_told_where_it_is_the_same_or_nothing_slips() -> None:
    loads = [0.4, 1.0, 1.0], [0.2, 0.4, 0.3]
    assert warned(path(*loads, [1.0, 4.0, 4.0], [True, False, False])) == []
    assert warned(path(*loads, [2.1, 4.1, 4.0], [True, False, False])) == []  # too close
    assert warned(path(*loads, [4.0, 4.0, 4.0], [False, False, False])) == []


def test_a_ridge_that_has_just_met_the_plate_or_leaves_it_counts_for_nothing() -> None:
    """Its few points slip at once, whatever the law."""
    seen = path([0.01, 1.0, 1.0], [0.01, 0.4, 0.3], [0.1, 4.0, 4.0], [True, False, False])
    assert warned(seen) == []
    leaves = path([0.4, 1.0, 1.0], [0.2, 0.4, 0.3], [4.0, 4.0, 4.0], [True, False, False])
    leaves.pressed[-1, 0] = 0.0
    assert warned(leaves) == []


FLEXIBLE = 0.25  # mm/N


def springs() -> ContactPad:
    """Two points at the same height on springs of their own, alike in x and in z."""
    one, two = np.eye(4), np.zeros(2)
    ridge = np.array([0, 1])
    return ContactPad(FLEXIBLE * one, two, np.array([-1.0, 1.0]), ridge, np.ones(2), np.zeros((0, 3, 4)), 4)


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize(
    ("before", "after", "mean"),
    [
        (0.2, 0.6, 0.4),
        (0.6, 0.0, 0.3),  # at the step's end it carries nothing
        (0.0, 0.6, 0.3),
        (-0.2, 0.6, 0.6),  # the force turned round before the point slipped, and dragged it all the way
    ],
)
def test_friction_takes_the_mean_force_of_a_step_times_the_slide(
    before: float, after: float, mean: float, way: float
) -> None:
    skin, slid = CondensedPad(springs()), 0.1
    first, last = skin.start(), skin.start()
    first = replace(first, tangential=way * np.array([before, 0.0]) + 0.0, normal=np.array([2.0, 2.0]))
    last = replace(
        last,
        tangential=way * np.array([after, 0.1]) + 0.0,  # a freed point's is 0, not -0
        normal=np.array([2.0, 1.0]),
        slipped=-way * np.array([slid, 0.0]),
        residual=1e-11,
    )
    reading = skin.reading(first, last)
    assert reading.dissipated == pytest.approx(mean * slid, rel=1e-12)
    assert (reading.normal, reading.tangential) == (pytest.approx(3.0), pytest.approx(way * (after + 0.1)))
    # what the springs hold: half of flexibility times force squared, in both directions
    assert reading.elastic == pytest.approx(FLEXIBLE / 2 * (2.0**2 + 1.0**2 + after**2 + 0.1**2), rel=1e-12)
    assert reading.residual == 1e-11
    assert reading.work is None  # the plate does not turn
