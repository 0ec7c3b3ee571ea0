"""The sheet's words on films: all that makes them hold, in its order, with amounts and times."""

import math
import re

import pytest

import skincad
from skincad.circuit import capacitance, electrode
from skincad.fabrication import Job, opening_steps, sheet_steps
from skincad.fabrication.parts_list import parts_list
from skincad.fabrication.shopping import consumables
from skincad.inputs import Design, template_names
from tests.bent_skin import three_ridges
from tests.fabrication.test_sheet import sheet
from tests.templates import SHIPPED

ALCOHOL, SHIMS, PRIMER, GLUE, MIX, CURE, PULL = (
    "End a has the gate",
    "water-break",
    "Brush primer",
    "cyanoacrylate between",
    "g of the same silicone (weigh",
    "Let the strips cure in",
    "Pull test: hang",
)
FILMED = [name for name in template_names() if skincad.load(name).film]


def order(text: str) -> list[str]:
    """The numbered steps."""
    return re.findall(r"^\d+\. (.*)$", text.partition("## In this order")[2], re.MULTILINE)


def place(steps: list[str], words: str) -> int:
    (index,) = (i for i, step in enumerate(steps) if words in step)
    return index


@pytest.mark.parametrize("name", FILMED)
def test_a_film_is_prepared_drawn_in_cured_and_tested_in_this_order(name: str) -> None:
    design = skincad.load(name)
    steps = order(sheet(design))
    cast = design.mold.method == "cast-in"
    words = [ALCOHOL, PRIMER, "Degas", PULL] if cast else [ALCOHOL, "Degas", PRIMER, GLUE, MIX, CURE, PULL]
    places = [place(steps, phrase) for phrase in words]
    assert places == sorted(set(places))
    if not cast:
        assert place(steps, SHIMS) < place(steps, "lay the shims into the notches")
        assert place(steps, "slide the end plates off") < place(steps, GLUE)
        assert place(steps, PULL) < place(steps, "Take the cover's")


def test_arcs_are_drawn_through_their_notches_and_tested_when_those_are_off() -> None:
    design = three_ridges()
    text = sheet(design)
    steps = order(text)
    words = [PRIMER, GLUE, MIX, CURE, "take the plates off", PULL]
    places = [place(steps, phrase) for phrase in words]
    assert places == sorted(set(places))
    # 12 mm of the summit's arc at 25 mm, a slot's outer edge at 25.2; plates of 4, grips of 6
    arm = 25.2
    long = 2 * arm * (12 / 2 / 25 + math.asin(4 / arm)) + 2 * 6
    assert int(re.search(r"(\d+) mm long, cut or etched as arcs", text)[1]) == math.ceil(long)
    assert "the last 6 mm at end b thinned to 0.019 mm" in text
    assert "above 0.057 mm it jams" in steps[place(steps, GLUE)]
    assert f"over the last {Job(design).lead + 10 - 4:g} mm of the wired end" in steps[place(steps, PRIMER)]


@pytest.mark.parametrize(("side", "drawn"), [("a", "b"), ("b", "a")])
def test_the_wired_end_is_masked_and_comes_last(yamada: Design, side: str, drawn: str) -> None:
    steps = order(sheet(yamada.with_(film={"wiring_side": side})))
    assert (
        f"the last {10 + Job(yamada).lead:g} mm of the wired end (end {side})" in steps[place(steps, PRIMER)]
    )
    assert "its number and + side written on it" in steps[place(steps, PRIMER)]
    assert f"tail at end {side}" in steps[place(steps, GLUE)]
    assert f"draw it out along the ridges, towards end {drawn}" in steps[place(steps, MIX)]
    assert f"its mask meets the skin's end {side}" in steps[place(steps, MIX)]


def test_eighty_four_strips_are_drawn_in_by_the_pot_life() -> None:
    """Six skins of seven ridges; 20 min: 6 of them in 10 min."""
    settings = ["ridge.count=7", "mold.cavities=6", "material.name=dragon-skin-10"]
    design = skincad.load("yamada-2002", settings)
    text = sheet(design)
    assert "draw in 6 of the 84 strips with it, at 97 s each, within 10 min" in text
    assert "14 times in all" in text
    assert "28 g of more silicone, " in text
    assert ": draws the strips in, 14 x 2 g" in text
    unknown = sheet(skincad.load("yamada-2002").with_(material={"name": None, "young_modulus": 0.5}))
    assert "as half the pot life on its data sheet takes at 97 s each" in unknown


def test_a_film_is_never_baked(yamada: Design) -> None:
    hot = order(sheet(yamada.with_(material={"name": "sylgard-184-200c"})))
    assert "as long as its data sheet asks at 80 °C or less" in hot[place(hot, CURE)]
    cold = order(sheet(yamada))
    assert "16 h at room temperature" in cold[place(cold, CURE)]


def test_what_films_need_is_to_be_bought_with_amounts(yamada: Design) -> None:
    """18 strips and two to spare; primer for 2 x 20 x 0.25 x 12 mm2 is 0.024 ml, less than the least told."""
    rows = " | ".join(need.words for need in consumables(Job(yamada)))
    for words in (
        "18 film strips, PVDF, 28 µm, sputtered metal on both faces, and 2 to spare",
        "36 crimp contacts, for flat cable, 2.54 mm apart",  # two pads a strip
        "primer that bonds silicone to plastics and metal (silane or titanate type), with a fine brush",
        "37 ml of isopropanol",  # 10 and 0.5 a wipe
        "54 lint-free wipes",  # one a strip, two a shim
        "184 cm of low-tack tape, acrylic adhesive",  # 20 folded over lead and tab, 46 mm
        "1 g of cyanoacrylate, thin",
        "4 g of more silicone",
        "film clip and weight, 10.7 g together: pull test, on 0.3 m of thread",  # 0.105 N
    ):
        assert words in rows
    cast = " | ".join(need.words for need in consumables(Job(skincad.load("cast-in"))))
    assert "36 weights, 5.1 g" in cast
    assert "11 m of thread" in cast
    assert "cyanoacrylate" not in cast


@pytest.mark.parametrize("name", SHIPPED)
def test_sheet_and_parts_list_say_the_same_of_all_that_is_bought(name: str) -> None:
    job = Job(skincad.load(name))
    bought = {(item.quantity, item.what, item.designation) for item in parts_list(job)}
    text = sheet(job.design)
    for need in consumables(job):
        assert (str(need.quantity), need.what, need.size) in bought
        assert f"- {need.words}" in text.splitlines()


def test_without_a_film_there_is_nothing_of_it(yamada: Design) -> None:
    bare = yamada.with_(film=None, contact={"film": "loose"})
    words = " ".join(need.words for need in consumables(Job(bare)))
    assert "film" not in words
    assert "primer" not in words
    words = [step.words for step in opening_steps(Job(bare))]
    assert words[1] == "Draw each shim out along the ridges, towards end b."
    assert not any("film" in line or "strip" in line for line in words)
    assert "shims with a brush" in sheet_steps(Job(bare))["release"]


@pytest.mark.parametrize("name", FILMED)
def test_a_meter_reads_what_the_circuit_has(name: str) -> None:
    """The capacitance told is that of the circuits' films (permittivity 12) within the error told."""
    design = skincad.load(name)
    assert design.film is not None
    steps = order(sheet(design))
    read, error = re.search(
        r"taken off: ([\d.]+) ± ([\d.]+) pF", steps[place(steps, "capacitance meter")]
    ).groups()
    expected = 1e12 * capacitance(electrode(design), design.film.thickness, 12.0)
    assert abs(expected - float(read)) <= float(error)
    assert place(steps, "capacitance meter") == place(steps, PULL) + 1
