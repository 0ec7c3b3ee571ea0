"""The casting sheet: its numbers, its order, and what designs beside the golden ones make it say.

The whole sheets of four designs are in tests/golden.
"""

from __future__ import annotations

import csv
import math
import re
from functools import cache
from typing import Any

import pytest

from skincad.circuit import capacitance, electrode
from skincad.fabrication import (
    Job,
    casting_sheet,
    opening_steps,
    parts_csv,
    sheet_steps,
)
from skincad.fabrication.day_plan import day_plan, tasks
from skincad.fabrication.parts_list import consumables
from skincad.inputs import Design, load
from skincad.solids import CutRole, PartRole, bores
from skincad.solids.mold import mold
from tests.designs import SHIPPED, of_one_printer, three_ridges

FILMED = [name for name in SHIPPED if load(str(name.values[0])).film]
DAY = (9.0, 17.0)  # o'clock: hands work between
PRIMED, SHIMS, PRIMER, GLUE, MIX, CURE, PULL = (
    "End a has the gate",
    "water-break",
    "Brush primer",
    "cyanoacrylate between",
    "g of the same silicone (weigh",
    "Let the strips cure in",
    "Pull test: hang",
)


@pytest.fixture(scope="module")
def few() -> Design:
    """Three ridges of yamada-2002, whose sheet is written in half the time."""
    return load("yamada-2002", ["ridge.count=3"])


@cache
def sheet(design: Design) -> str:
    return casting_sheet(Job(design), [], "Passes.", True)


def order(text: str) -> list[str]:
    """The numbered steps."""
    return re.findall(r"^\d+\. (.*)$", text.partition("## In this order")[2], re.MULTILINE)


def place(steps: list[str], words: str) -> int:
    (index,) = (i for i, step in enumerate(steps) if words in step)
    return index


def assert_in_order(steps: list[str], phrases: list[str]) -> None:
    places = [place(steps, phrase) for phrase in phrases]
    assert places == sorted(set(places))


@pytest.mark.parametrize("change", [{"mold": {"pour": "open"}}, {"skin": {"curvature_radius_y": 200.0}}])
def test_the_mix_is_degassed_in_its_cup_alone(few: Design, change: dict[str, Any]) -> None:
    text = sheet(few.with_(**change))
    assert text.count("Degas the mix in its open cup") == text.count("never put the closed mold") == 1
    # an open trough gets a vacuum of its own, before the carrier goes on
    assert text.lower().count("degas") == 1
    assert text.count("vacuum") == 1 + ("the open mold under vacuum" in text)
    assert ("the open mold under vacuum" in text) == ("mold" in change)


def test_an_unknown_silicone_has_no_invented_recipe(few: Design) -> None:
    text = sheet(few.with_(material={"name": None, "young_modulus": 0.5}))
    assert "by its data sheet" in text
    assert "of A" not in text
    assert "| mixed | 8." in text
    assert "as half the pot life on its data sheet takes at 97 s each" in text


@pytest.mark.parametrize(
    ("name", "settings", "words", "unsaid"),
    [
        ("nozzle-04", [], "into heat-set inserts in holes of 4 mm", "tapped holes"),
        ("nozzle-04", ['printer.fdm.thread="tapped"'], "into tapped holes", "heat-set"),
        ("nozzle-04", [], "The shim must drop into its notch of 0.62 mm", "glued inserts"),
        ("cast-in", ["mold.lid_process=sla"], "silicone on cover with a brush", "Wash the crests with soap"),
        ("cast-in", [], "a spare strip drops into each notch", "post-cure"),  # its films would lose charge
        ("plain-ridges", ["mold.carrier=plain"], "- 1 ml of primer that bonds silicone", "rivets"),
        ("yamada-2002", ["film.d31=-23"], "If the first kick goes down", "If the first kick goes up"),
        ("yamada-2002", ["material.name=sylgard-184-25c"], "cure 48 h at room temperature", "°C or less"),
        ("yamada-2002", ["material.name=sylgard-184-200c"], "cure 0.2 h at 200 °C", "cure 48 h"),
        ("yamada-2002", ["skin.curvature_radius_y=200"], "Press the dowel pins into cavity", "insert"),
        ("yamada-2002", ["mold.lid_process=sla"], "Wash carrier and cover in 2 baths", "Wash all parts"),
        ("steep-fingertip", [], "Press the dowel pins into", "insert"),
    ],
)
def test_words_of_other_designs(name: str, settings: list[str], words: str, unsaid: str) -> None:
    text = sheet(load(name, [*settings, "ridge.count=3"]))
    assert words in text
    assert unsaid not in text


def test_all_parts_of_one_printer_are_washed() -> None:
    words = sheet_steps(Job(of_one_printer("lab-bench", ["ridge.count=3"])))["prepare"]
    assert "Wash all parts in 2 baths of isopropanol, 5 min each." in words


def test_a_plain_carrier_is_primed_before_the_mix() -> None:
    text = sheet(load("plain-ridges", ["mold.carrier=plain"]))
    assert text.index("Prime the carrier's lower face") < text.index("Mix. Start a clock")
    assert "holds by its primed face" in text


@pytest.mark.parametrize("name", ["yamada-2002", "cast-in"])
def test_two_inserts_a_ridge_and_cavity_are_to_be_bought(name: str) -> None:
    design = load(name, ["ridge.count=3"]).with_(mold={"cavities": 2})
    cast = name == "cast-in"
    inserts = mold(design).of(PartRole.STRIP if cast else PartRole.SHIM)
    assert len(inserts) == 2 * design.ridge.count * 2
    words = " film strips, PVDF" if cast else " shims of spring steel"
    assert f"{len(inserts)}{words}" in sheet(design)


@pytest.mark.parametrize(
    ("name", "settings", "coated"),
    [
        ("lab-bench", ["skin.curvature_radius_y=100"], False),
        ("lab-bench", ["film=none", "contact.film=loose"], True),
        ("cast-in", ["mold.lid_process=sla"], False),
        ("plain-ridges", [], False),
    ],
)
def test_no_release_agent_comes_to_where_a_film_must_hold(
    name: str, settings: list[str], coated: bool
) -> None:
    """A shim leaves it on the slot's walls."""
    lines = sheet(load(name, [*settings, "ridge.count=3"])).splitlines()
    (agent,) = (line for line in lines if "Put release agent" in line)
    assert ("cover and shims with a brush" in agent) == coated
    assert ("none on the shims" in agent) == (name == "lab-bench" and not coated)
    assert ("none on the strips" in agent) == (name == "cast-in")
    assert ("none in the notches" in agent) == (name != "plain-ridges")
    assert "none on the carrier" in agent


def test_a_coated_resin_is_sealed_for_its_trial_too() -> None:
    steps = order(sheet(load("lab-bench", ["printer.sla.coating=0.02", "ridge.count=3"])))
    assert "baked and sealed as in step 1" in steps[0]
    assert "Seal them with a coat of 0.02 mm" in steps[1]


def test_a_carrier_is_pulled_by_what_its_rivets_or_its_primer_bear() -> None:
    """Necks of 0.75 mm at half of E, or a third of 0.1 MPa on the back."""

    def force(design: Design) -> str:
        return re.search(r"pull at the carrier with ([\d.]+) N", sheet(design))[1]

    riveted = load("yamada-2002")
    necks = bores(mold(riveted).part("carrier"), CutRole.RIVET)
    assert force(riveted) == f"{len(necks) * math.pi * 0.75**2 * 0.5 * 0.8:.2g}"
    assert force(load("plain-ridges", ['mold.carrier="plain"'])) == f"{0.1 / 3 * 11 * 12:.2g}"


@pytest.mark.parametrize("name", SHIPPED)
def test_hands_work_by_day_after_what_has_to_cure(name: str) -> None:
    job = Job(load(name))
    plan = day_plan(job)
    assert [task._replace(day=0, hour=0.0) for task in plan] == tasks(job)
    ready = 0.0
    for task in plan:
        begin = 24 * (task.day - 1) + task.hour
        assert DAY[0] <= task.hour <= DAY[1]
        assert begin >= ready - 1e-9
        assert task.hour + task.hands / 60 <= DAY[1] or task.hour == DAY[0]
        ready = begin + (task.hands + task.wait) / 60
    *_, opened, last = [task for task in plan if task.wait or task is plan[-1]]
    cured = 24 * (opened.day - 1) + opened.hour + (opened.hands + opened.wait) / 60
    assert 24 * (last.day - 1) + last.hour >= cured + 24 - 1e-9  # a day after the last cure


@pytest.mark.parametrize("name", FILMED)
def test_primed_strips_are_used_while_their_primer_is_good(name: str) -> None:
    plan = day_plan(Job(load(name)))
    primed = next(i for i, task in enumerate(plan) if task.what == "make the strips ready")
    used = next(t for t in plan[primed:] if t.what.startswith(("draw the strips", "close the mold")))
    begin = plan[primed].hour + plan[primed].hands / 60
    end = 24 * (used.day - plan[primed].day) + used.hour + used.hands / 60
    assert end - begin <= 8.0  # h, as the sheet says


@pytest.mark.parametrize("name", FILMED)
def test_films_are_prepared_drawn_in_cured_tested_and_measured(name: str) -> None:
    """In this order; a meter reads what the circuits have (permittivity 12), within the error."""
    design = load(name)
    steps = order(sheet(design))
    cast = design.mold.method == "cast-in"
    assert_in_order(
        steps, [PRIMED, PRIMER, "Degas", PULL] if cast else [PRIMED, "Degas", PRIMER, GLUE, MIX, CURE, PULL]
    )
    if not cast:
        assert place(steps, SHIMS) < place(steps, "lay the shims into the notches")
        assert place(steps, "slide the end plates off") < place(steps, GLUE)
        assert place(steps, PULL) < place(steps, "Take the cover's")
    assert place(steps, "capacitance meter") == place(steps, PULL) + 1
    words = steps[place(steps, "capacitance meter")]
    read, error = map(float, re.search(r"taken off: ([\d.]+) ± ([\d.]+) pF", words).groups())
    assert abs(1e12 * capacitance(electrode(design), design.film.thickness, 12.0) - read) <= error


def test_arcs_are_drawn_through_their_notches_and_tested_when_those_are_off() -> None:
    design = three_ridges()
    text = sheet(design)
    steps = order(text)
    assert_in_order(steps, [PRIMER, GLUE, MIX, CURE, "take the plates off", PULL])
    # 12 mm of the summit's arc at 25 mm, a slot's outer edge at 25.2; plates of 4, grips of 6
    arm = 25.2
    long = 2 * arm * (12 / 2 / 25 + math.asin(4 / arm)) + 2 * 6
    assert int(re.search(r"(\d+) mm long, cut or etched as arcs", text)[1]) == math.ceil(long)
    assert "the last 6 mm at end b thinned to 0.019 mm" in text
    assert "above 0.057 mm it jams" in steps[place(steps, GLUE)]
    assert f"over the last {Job(design).lead + 10 - 4:g} mm of the wired end" in steps[place(steps, PRIMER)]


def test_the_other_wired_end_is_masked_and_comes_last(few: Design) -> None:
    """The usual one is in tests/golden."""
    steps = order(sheet(few.with_(film={"wiring_side": "a"})))
    assert f"the last {10 + Job(few).lead:g} mm of the wired end (end a)" in steps[place(steps, PRIMER)]
    assert "tail at end a" in steps[place(steps, GLUE)]
    assert "draw it out along the ridges, towards end b" in steps[place(steps, MIX)]
    assert "its mask meets the skin's end a" in steps[place(steps, MIX)]


def test_eighty_four_strips_are_drawn_in_by_the_pot_life() -> None:
    """Six skins of seven ridges; 20 min: 6 of them in 10 min."""
    text = sheet(load("yamada-2002", ["ridge.count=7", "mold.cavities=6", "material.name=dragon-skin-10"]))
    assert "draw in 6 of the 84 strips with it, at 97 s each, within 10 min" in text
    assert "14 times in all" in text
    assert "28 g of more silicone, " in text
    assert ": draws the strips in, 14 x 2 g" in text


def test_a_film_is_never_baked(few: Design) -> None:
    hot = order(sheet(few.with_(material={"name": "sylgard-184-200c"})))
    assert "as long as its data sheet asks at 80 °C or less" in hot[place(hot, CURE)]


def test_weights_and_thread_for_cast_in_strips() -> None:
    cast = " | ".join(need.words for need in consumables(Job(load("cast-in"))))
    assert "36 weights, 5.1 g" in cast
    assert "11 m of thread" in cast
    assert "cyanoacrylate" not in cast


@pytest.mark.parametrize("name", SHIPPED)
def test_sheet_and_parts_list_say_the_same_of_all_that_is_bought(name: str) -> None:
    job = Job(load(name))
    rows = csv.DictReader(parts_csv(job).splitlines())
    bought = {(row["quantity"], row["what"], row["designation"]) for row in rows}
    text = sheet(job.design)
    for need in consumables(job):
        assert (need.quantity, need.what, need.designation) in bought
        assert f"- {need.words}" in text.splitlines()


def test_without_a_film_there_is_nothing_of_it(few: Design) -> None:
    bare = few.with_(film=None, contact={"film": "loose"})
    words = " ".join(need.words for need in consumables(Job(bare)))
    assert "film" not in words
    assert "primer" not in words
    steps = [step.words for step in opening_steps(Job(bare))]
    assert steps[1] == "Draw each shim out along the ridges, towards end b."
    assert not any("film" in line or "strip" in line for line in steps)
    assert "shims with a brush" in sheet_steps(Job(bare))["release"]
