import math
import re

import pytest

from skincad.fabrication import DEAD_VOLUME, Job, casting_sheet, manifold, poured_volume
from skincad.fabrication.facts import Facts
from skincad.inputs import Design, load
from skincad.solids import CutRole, Part, PartRole, bores, box
from skincad.solids.mold import mold


def sheet(design: Design) -> str:
    return casting_sheet(Job(design), [], "Passes.", True)


def test_poured_volume_is_the_closed_molds_void(yamada: Design) -> None:
    """By booleans: a block around the cavity's space, less every part but the skin."""
    closed = mold(yamada)
    half, end, high = 37.0 / 2, 6.0 + 4.0, closed.part("cover").body.high
    space = manifold(Part("block", PartRole.COVER, box(half, (-end, end), (-13.4, high))), 1e-3)
    for part in closed.parts:
        if part.name != "skin":
            space = space - manifold(part, 1e-3)
    void = [p.volume() for p in space.decompose() if p.bounding_box()[0] < 0 < p.bounding_box()[3]]
    # clearances of the carrier's seat and the shims' slits are in the void too, 1 % of it; chords
    assert poured_volume(Job(yamada, closed)) == pytest.approx(max(void), rel=0.015)


def test_each_part_is_said_to_be_made_by_what_judges_it() -> None:
    design = load("milled-pad")
    rows = dict(re.findall(r"^\| (\S+) \| (\w+), ", sheet(design), re.MULTILINE))
    parts = {p.name: p for p in mold(design).parts if p.made == "made"}
    assert rows == {name: Job(design).maker(part) for name, part in parts.items()}
    assert (rows["cavity"], rows["end-a-comb"], rows["cover"]) == ("cnc", "edm", "cnc")


def test_masses_follow_from_volume_density_and_mix(yamada: Design) -> None:
    grams = poured_volume(Job(yamada)) * 1080e-6 + DEAD_VOLUME
    a, b = map(float, re.findall(r"weigh ([\d.]+) g of A and ([\d.]+) g of B", sheet(yamada))[0])
    assert a + b == pytest.approx(grams, abs=0.02)  # two roundings to 0.01 g
    ten_to_one = sheet(yamada.with_(material={"name": "sylgard-184"}))
    a, b = map(float, re.findall(r"weigh ([\d.]+) g of A and ([\d.]+) g of B", ten_to_one)[0])
    assert a / b == pytest.approx(10.0, rel=0.02)


def test_the_temperature_of_a_cure_is_told(yamada: Design) -> None:
    warm, hot = (sheet(yamada.with_(material={"name": f"sylgard-184-{c}c"})) for c in (25, 200))
    assert "cure 48 h at room temperature" in warm
    assert "cure 0.2 h at 200 °C" in hot


@pytest.mark.parametrize("change", [{}, {"pour": "open"}])
def test_the_mix_is_degassed_open_and_no_filled_mold_is_put_under_vacuum(
    yamada: Design, change: dict
) -> None:
    bent = yamada.with_(skin={"curvature_radius_y": 200.0})
    for design in (yamada.with_(mold=change), bent):
        text = sheet(design)
        assert text.count("Degas the mix in its open cup") == text.count("never put the closed mold") == 1
        assert text.lower().count("degas") == text.count("vacuum") == 1


@pytest.mark.parametrize(("name", "insert"), [("lab-bench", "glued"), ("nozzle-04", "heat-set")])
def test_a_resin_is_not_asked_to_melt_round_an_insert(name: str, insert: str) -> None:
    assert f"into {insert} inserts in holes of 4 mm" in sheet(load(name))
    tapped = load(name, [f'printer.{load(name).mold.process}.thread="tapped"'])
    assert "into tapped holes" in sheet(tapped)


def test_an_unknown_silicone_has_no_invented_recipe(yamada: Design) -> None:
    text = sheet(yamada.with_(material={"name": None, "young_modulus": 0.5}))
    assert "by its data sheet" in text
    assert "of A" not in text


def test_bolts_and_pins_are_long_and_short_enough(yamada: Design) -> None:
    text = sheet(yamada)
    (along,) = map(int, re.findall(r"4 M3 x (\d+) through both end plates", text))
    (upright,) = map(int, re.findall(r"2 M3 x (\d+) for the cover", text))
    assert along == 25  # 12 and two plates of 4, and the shrinkage; ISO has no 21
    assert upright == 4 + 4  # cover and thread
    assert "4 of at most 8.8 mm, 2 of at most 9.9 mm" in text


def test_a_failed_job_says_so_at_the_top(yamada: Design) -> None:
    text = casting_sheet(Job(yamada), [], "Passes.", False)
    assert text.splitlines()[2].startswith("**Don't make it yet.** Mold: no errors")


def test_without_slots_there_is_no_word_of_shims() -> None:
    assert "shim" not in sheet(load("plain-ridges"))


@pytest.mark.parametrize("name", ["yamada-2002", "cast-in"])
@pytest.mark.parametrize("cavities", [1, 2])
def test_two_inserts_a_ridge_and_cavity_are_to_be_bought(name: str, cavities: int) -> None:
    design = load(name).with_(mold={"cavities": cavities})
    closed, cast = mold(design), name == "cast-in"
    inserts = closed.of(PartRole.STRIP if cast else PartRole.SHIM)
    assert len(inserts) == 2 * design.ridge.count * cavities
    words = " film strips, PVDF" if cast else " shims of spring steel"
    assert f"{len(inserts)}{words}" in sheet(design)


@pytest.mark.parametrize(
    ("name", "settings", "coated"),
    [
        ("lab-bench", [], False),
        ("lab-bench", ["skin.curvature_radius_y=100"], False),
        ("lab-bench", ["film=none", "contact.film=loose"], True),
        ("cast-in", ["mold.lid_process=sla"], False),
        ("plain-ridges", [], False),
    ],
)
def test_no_release_agent_comes_to_where_a_film_must_hold(
    name: str, settings: list[str], coated: bool
) -> None:
    """What a shim has on it, it leaves on the slot's walls."""
    lines = sheet(load(name, settings)).splitlines()
    (agent,) = (line for line in lines if "Put release agent" in line)
    assert ("cover and shims with a brush" in agent) == coated
    assert ("none on the shims" in agent) == (name == "lab-bench" and not coated)
    assert ("none on the strips" in agent) == (name == "cast-in")
    assert ("none in the notches" in agent) == (name != "plain-ridges")
    assert "none on the carrier" in agent


def test_metal_needs_no_release_agent_and_resin_is_washed_of_it() -> None:
    metal, mixed, resin = (
        sheet(load(*given))
        for given in (("yamada-2002",), ("cast-in", ["mold.lid_process=sla"]), ("lab-bench",))
    )
    assert "Use no release agent" in metal
    assert "- release agent" not in metal
    assert "Put release agent for silicone on cover with a brush" in mixed
    assert [text.count("Wash the crests with soap and water") for text in (metal, mixed, resin)] == [0, 0, 1]


@pytest.mark.parametrize("coating", [0.0, 0.02])
def test_a_resin_is_tried_by_a_drop_before_all_else(coating: float) -> None:
    """One story: nothing is sealed that the design has no coat for."""
    text = sheet(load("lab-bench", [f"printer.sla.coating={coating}"]))
    steps = re.findall(r"^(\d+)\. (.*)$", text.partition("## In this order")[2], re.MULTILINE)
    assert [number for number, _ in steps] == [str(i) for i in range(len(steps))]
    assert steps[0][1].startswith("Trial of the resin: print a small plate")
    assert ("baked and sealed as in step 1" in steps[0][1]) == (coating > 0)
    assert ("Seal them with a coat of 0.02 mm" in steps[1][1]) == (coating > 0)
    assert "Trial" not in sheet(load("yamada-2002"))


def test_a_plain_carrier_is_primed_before_the_mix_and_its_primer_is_bought() -> None:
    text = sheet(load("plain-ridges", ["mold.carrier=plain"]))
    assert text.index("Prime the carrier's lower face") < text.index("Mix. Start a clock")
    assert "- 1 ml of primer that bonds silicone" in text
    assert "Prime the carrier" not in sheet(load("plain-ridges"))


def test_a_record_goes_with_the_part_and_a_puck_tells_when_to_open() -> None:
    text = sheet(load("lab-bench"))
    a, b = re.findall(r"weigh ([\d.]+) g of A and ([\d.]+) g of B, [\d.]+ g, into one cup", text)[0]
    assert f"| A, g | {a} | |" in text
    assert f"| B, g | {b} | |" in text
    assert (
        text.index("as a puck, 5 mm thick") < text.index("Look at it under a lamp") < text.index("## Record")
    )
    unknown = sheet(load("yamada-2002").with_(material={"name": None, "young_modulus": 0.5}))
    assert "| mixed | 8." in unknown


def test_strips_are_tried_for_insulation_and_polarity_where_there_are_some() -> None:
    assert "all to the same side" in sheet(load("yamada-2002"))
    assert "oscilloscope" not in sheet(load("plain-ridges"))


def test_printed_combs_are_tried_by_a_ladder_of_notches() -> None:
    tried = "print the notch ladder of `skincad coupon sla`. The shim must drop into its notch of 0.62 mm"
    assert tried in sheet(load("nozzle-04"))
    assert "notch ladder" not in sheet(load("lab-bench"))  # its combs are cut by wire


def test_a_carrier_is_pulled_by_what_its_rivets_or_its_primer_bear() -> None:
    """Necks of 0.75 mm at half of E, or a third of 0.1 MPa on the back."""
    riveted = load("yamada-2002")
    necks = bores(mold(riveted).part("carrier"), CutRole.RIVET)
    force = len(necks) * math.pi * 0.75**2 * 0.5 * 0.8
    assert Facts(Job(riveted)).pull_off == pytest.approx(force, rel=1e-9)
    assert f"pull the carrier off it with {force:.2g} N" in sheet(riveted)
    plain = load("plain-ridges", ['mold.carrier="plain"'])
    assert Facts(Job(plain)).pull_off == pytest.approx(0.1 / 3 * 11 * 12, rel=1e-9)
    assert "holds by its primed face" in sheet(plain)


def test_a_post_cure_is_an_option_before_films_are_in() -> None:
    assert "post-cure the skin, before films go in, 2 h at 80 °C and 1 h at 100 °C" in sheet(
        load("yamada-2002")
    )
    assert "out of its printed mold" in sheet(load("plain-ridges"))
    assert "post-cure" not in sheet(load("cast-in"))  # its films would lose their charge


def test_prints_have_settings_plates_and_flat_joints() -> None:
    text = sheet(load("lab-bench"))
    assert "Plates: solids/mold-plate-1.3mf: cover, cavity, carrier." in text
    assert (
        "Lap the printed joint faces (both ends and the top of the cavity and the carrier's lower face)"
        in text
    )
    assert "Lap" not in sheet(load("yamada-2002"))


def test_film_is_turned_the_right_way_and_its_leads_are_relieved() -> None:
    text = sheet(load("yamada-2002"))
    assert "If the first kick goes up, the tip is on the + face" in text
    assert "If the first kick goes down" in sheet(load("yamada-2002", ["film.d31=-23"]))
    assert text.index("put a drop of the same silicone on each") < text.index("crimp a contact")
    assert "behind the pads" in text
